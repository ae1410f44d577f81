"""Rotations from directions: the shortest turn from one to another, and the best fit to many."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._common.arrays import Floats
from nao_kin._common.vectors import as_batch, common_batch, cross, dot, first_index, norm, unit
from nao_kin.errors import BadArgument, DegeneratePoints, WrongShape, at_index
from nao_kin.rotations._points import THINNEST, best_fit, refuse_one_line
from nao_kin.rotations._quaternions import matrix_from_quat
from nao_kin.rotations._weights import as_shares

# ‖a + b‖ of unit vectors up to which they count as opposite: they are to rounding.
_OPPOSITE = 4.0 * 2.0**-52


@dataclass(frozen=True, eq=False)
class DirectionFit:
    """The rotation that fits directions best.

    Attributes:
        rotation: R, shape (..., 3, 3).
        residual: root of the weighted mean of ‖bᵢ − R aᵢ‖² over the unit directions, shape (...): nearly the root mean
            square of `angles`.
        angles: the angle left between R aᵢ and bᵢ, shape (..., n) [rad].

    Examples:
        >>> fit = nk.rotations.rotation_from_directions([[0, 0, 1], [1, 0, 0]], [[0, 0, 1], [1, 0, 0.2]])
        >>> fit.residual.round(4), fit.angles
        (np.float64(0.0987), array([0.0987, 0.0987]))
    """

    rotation: Floats
    residual: Floats
    angles: Floats


def rotation_between(a: ArrayLike, b: ArrayLike, *, axis: ArrayLike | None = None) -> Floats:
    """The rotation by the least angle that takes the direction of a to the direction of b: about a × b.

    Between opposite directions every half turn about an axis normal to a is as short. Then the axis is the part of
    `axis` normal to a; without one, the part of that coordinate axis normal to a which is farthest from the line of a
    (its component of a is smallest in magnitude; x before y before z where they are equal): −z is reached from z by a
    half turn about x, −x from x about y. Directions count as opposite to rounding: ‖a/‖a‖ + b/‖b‖‖ ≤ 4 × 2⁻⁵².

    Args:
        a: directions before, shape (..., 3), of any length but zero.
        b: directions after, shape (..., 3); broadcasts with a.
        axis: for opposite directions, shape (..., 3), not along a; broadcasts with them. Elsewhere without effect.

    Returns:
        Rotation matrices, shape (..., 3, 3), with R a along b to a few 1e-16.

    Raises:
        ZeroNorm: a direction or axis of length zero; carries its index.
        BadArgument: an axis along a where a and b are opposite, with the index; not numbers.
        WrongShape, NotFinite: wrong or mismatched shapes, NaN or infinity.

    Examples:
        >>> R = nk.rotations.rotation_between([1, 0, 0], [0, 2, 0])
        >>> np.allclose(R, nk.rotations.rot_z(np.pi / 2))
        True
        >>> over = nk.rotations.rotation_between([0, 0, 1], [0, 0, -1], axis=[0, 1, 0])
        >>> np.allclose(over, nk.rotations.rot_y(np.pi))
        True
    """
    first, second = (_units(side, f"direction {name}") for side, name in ((a, "a"), (b, "b")))
    shapes = [first.shape[:-1], second.shape[:-1]]
    if axis is not None:
        about = _units(axis, "axis")
        shapes.append(about.shape[:-1])
    batch = common_batch("a, b and axis" if axis is not None else "a and b", *shapes)
    first, second = np.broadcast_to(first, (*batch, 3)), np.broadcast_to(second, (*batch, 3))
    total, difference = first + second, second - first
    near = (dot(first, second) >= 0.0)[..., np.newaxis]
    # Twice the normal of the two, from whichever of sum and difference is small and therefore exact.
    normal = cross(first, np.where(near, difference, total))
    cosine, sine = norm(total), norm(difference)
    opposite = np.asarray(cosine <= _OPPOSITE)
    if opposite.any():
        farthest = np.eye(3)[np.abs(first).argmin(axis=-1)]
        wanted = farthest if axis is None else np.broadcast_to(about, (*batch, 3))
        normal = np.where(opposite[..., np.newaxis], _normal_part(wanted, first, opposite), normal)
        cosine = np.where(opposite, 0.0, cosine)
    length = norm(normal)
    same = length == 0.0
    vector = normal * np.where(same, 0.0, sine / np.where(same, 1.0, length))[..., np.newaxis]
    return matrix_from_quat(np.concatenate([cosine[..., np.newaxis], vector], axis=-1))


def rotation_from_directions(before: ArrayLike, after: ArrayLike, weights: ArrayLike | None = None) -> DirectionFit:
    """The rotation that best takes directions to where they are seen: Wahba's problem.

    The R with least Σ wᵢ ‖bᵢ − R aᵢ‖² over the unit directions aᵢ before and bᵢ after, the rotation nearest to
    Σ wᵢ bᵢ aᵢᵀ. `rotation_from_points` is for points, whose common shift does not matter and whose distances count.

    Args:
        before: directions, shape (..., n, 3), n ≥ 2, of any length but zero.
        after: the same directions after the rotation, shape (..., n, 3); batch axes broadcast.
        weights: shape (..., n), none negative, not all zero; their scale does not matter. Best 1/σᵢ² of directions
            known to σᵢ [rad]. Without them all count alike.

    Returns:
        Rotation, residual, and the angle left of each direction.

    Raises:
        DegeneratePoints: fewer than two directions, directions along one line (√wᵢ aᵢ or √wᵢ bᵢ thinner than 1e-6 of
            their length), or such that no single rotation fits best.
        ZeroNorm: a direction of length zero; carries its index.
        BadArgument: negative weights, or no positive one; not numbers.
        WrongShape, NotFinite: wrong or mismatched shapes, NaN or infinity.

    Source: Wahba, A least squares estimate of satellite attitude, SIAM Review 7(3), 1965; Markley, Attitude
    determination using vector observations and the SVD, J. Astronautical Sciences 36(3), 1988.

    Examples:
        >>> gravity, north = [0, 0, -1], [1, 0, 0]
        >>> fit = nk.rotations.rotation_from_directions([gravity, north], [gravity, [0, 1, 0]])
        >>> np.allclose(fit.rotation, nk.rotations.rot_z(np.pi / 2))
        True
        >>> bool(fit.residual < 1e-15)
        True
    """
    A, B = (_units(side, f"directions {name}") for side, name in ((before, "before"), (after, "after")))
    for side, what in ((A, "directions before"), (B, "directions after")):
        if side.ndim < 2:
            raise WrongShape(what, "(..., n, 3)", side.shape)
    count = A.shape[-2]
    if B.shape[-2] != count:
        raise WrongShape("directions after", f"(..., {count}, 3), as many as before", B.shape)
    if count < 2:
        raise DegeneratePoints(f"a rotation needs at least two directions, got {count}")
    shares = as_shares(weights, count)
    batch = common_batch("directions and weights", A.shape[:-2], B.shape[:-2], shares.shape[:-1])
    A, B = np.broadcast_to(A, (*batch, count, 3)), np.broadcast_to(B, (*batch, count, 3))
    roots = np.sqrt(np.broadcast_to(shares, (*batch, count)))[..., np.newaxis]
    for side, what in ((A, "directions before"), (B, "directions after")):
        refuse_one_line(roots * side, what, THINNEST["least_squares"])
    R = best_fit(roots * A, roots * B, "directions")
    turned = A @ np.swapaxes(R, -1, -2)
    apart = norm(B - turned)
    residual = norm(roots[..., 0] * apart)
    angles = 2.0 * np.arctan2(apart, norm(B + turned))
    return DirectionFit(R, np.asarray(residual), np.asarray(angles))


def _units(value: ArrayLike, what: str) -> Floats:
    return unit(as_batch(value, (3,), what), what)[0]


def _normal_part(wanted: Floats, first: Floats, needed: NDArray[np.bool_]) -> Floats:
    """The part of unit vectors normal to others, refused where it is needed and nothing."""
    part = wanted - dot(wanted, first)[..., np.newaxis] * first
    along = np.asarray(needed & (norm(part) <= _OPPOSITE))
    if along.any():
        raise BadArgument(
            f"the axis of a half turn between opposite directions{at_index(first_index(along))} must not lie along them"
        )
    # What is left of a long axis leans along by rounding: once more.
    part = part / np.where(needed, norm(part), 1.0)[..., np.newaxis]
    return np.asarray(part - dot(part, first)[..., np.newaxis] * first)
