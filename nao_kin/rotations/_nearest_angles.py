"""One or two turns that come nearest to a rotation, and how much of it they leave."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats
from nao_kin._common.kernels import Functions, Number, evaluate
from nao_kin._common.vectors import common_batch, cross, first_index, norm, unit
from nao_kin.errors import BadArgument, at_index
from nao_kin.rotations._checks import as_rotations, evaluate_rotations
from nao_kin.rotations._davenport import scaled_axis
from nao_kin.rotations._quat_kernels import quaternion_of
from nao_kin.rotations._three_angles import REQUIRED, Axes, find_short_sequence

# Normalising two parallel axes of any lengths leaves at most this sine between them.
_PARALLEL = 4.0 * 2.0**-52


@dataclass(frozen=True, eq=False)
class NearestAngles:
    """The angles of one or two turns nearest to a rotation.

    Attributes:
        angles: in the order of the axes as written, shape (..., 1) or (..., 2), in [−π, π] [rad].
        residual: angle between the rotation and the turns, shape (...) [rad]; 0 where the rotation is such turns.

    Examples:
        >>> tilted = nk.rotations.rot_z(0.3) @ nk.rotations.rot_y(0.01)
        >>> found = nk.rotations.nearest_euler(tilted, "z", axes="moving")
        >>> found.angles, found.residual
        (array([0.3]), array(0.01))
    """

    angles: Floats
    residual: Floats


def nearest_euler(R: ArrayLike, sequence: str, *, axes: Axes = REQUIRED) -> NearestAngles:
    """The turns about one or two coordinate axes that come nearest to a rotation: the least angle is left between.

    Not every rotation is a turn about z, or one about z and then y. The residual says how far from it this one is;
    compare it with what counts as such a rotation. Three axes reach every rotation: `euler_from_matrix`.

    For "i", α = 2 atan2(rᵢ, r0) with the unit quaternion (r0, r): the twist about the axis. For moving axes "ij" the
    products of half angles that make the quaternion form a matrix of rank one, and the nearest is found in closed
    form: α and β are the sum and the difference of atan2(rᵢ + rⱼ, r0 − s rₖ) and atan2(rᵢ − rⱼ, r0 + s rₖ), k being
    the third axis and s = ±1 with eᵢ × eⱼ = s eₖ.

    Args:
        R: rotation matrices, shape (..., 3, 3).
        sequence: one or two of "x", "y", "z", different, lower case; angles are returned in this order.
        axes: "moving" or "fixed"; required.

    Returns:
        Angles and residual. Of one axis the residual is at most π, of two at most π/2; where it is that, other angles
        come as near.

    Raises:
        NotARotation: some matrix is not orthogonal with determinant +1; carries its index and its defects.
        UnknownName: no such sequence or kind of axes.
        BadArgument, WrongShape, NotFinite: `axes` missing; R not numbers, not of shape (..., 3, 3), NaN.

    Examples:
        >>> R = nk.rotations.matrix_from_euler([0.3, -0.4], "zy", axes="moving")
        >>> found = nk.rotations.nearest_euler(R, "zy", axes="moving")
        >>> found.angles, bool(found.residual < 1e-15)
        (array([ 0.3, -0.4]), True)
        >>> nk.rotations.nearest_euler(R, "z", axes="moving").residual
        array(0.4)
    """
    places = find_short_sequence(sequence, axes)
    units = [[float(row == place) for row in range(3)] for place in places]

    def kernel(f: Functions, *m: Number) -> tuple[Number, ...]:
        return _nearest(f, *quaternion_of(f, *m), *units)

    angles, residual = evaluate_rotations(kernel, R, (len(places),), ())
    # Turns about fixed axes are the same turns about moving axes in the opposite order.
    return NearestAngles(np.ascontiguousarray(angles[..., ::-1]) if axes == "fixed" else angles, residual)


def nearest_davenport(R: ArrayLike, a1: ArrayLike, a2: ArrayLike | None = None) -> NearestAngles:
    """The turns about one or two arbitrary axes nearest to a rotation: Rot(a1, α) Rot(a2, β), or Rot(a1, α).

    As `nearest_euler`, about axes that need be neither coordinate axes nor perpendicular. One axis gives the twist of
    a rotation about it; what is left, Rot(a1, −α) R, is its swing.

    Args:
        R: rotation matrices, shape (..., 3, 3).
        a1: first axis, shape (..., 3), of any length but zero; broadcasts with R.
        a2: second axis, as carried along by the first turn, not parallel to the first; or None.

    Returns:
        Angles and residual. Where the residual is largest, other angles come as near.

    Raises:
        ZeroNorm: a zero axis; carries its index.
        BadArgument: parallel axes, with the index; not numbers.
        NotARotation: some matrix is not orthogonal with determinant +1; carries its index and its defects.
        WrongShape, NotFinite: wrong or mismatched shapes, NaN or infinity.

    Examples:
        >>> R = nk.rotations.matrix_from_natural([1, 1, 0], 0.7)
        >>> nk.rotations.nearest_davenport(R, [2, 2, 0]).angles
        array([0.7])
    """
    given = [a1] if a2 is None else [a1, a2]
    units = [unit(scaled_axis(axis, f"axis a{i}"), "axis")[0] for i, axis in enumerate(given, 1)]
    matrices = as_rotations(R)
    batch = common_batch("R and the axes", matrices.shape[:-2], *(axis.shape[:-1] for axis in units))
    if len(units) == 2:
        parallel = np.asarray(norm(cross(*units)) <= _PARALLEL)
        if parallel.any():
            raise BadArgument(f"axes a1 and a2{at_index(first_index(parallel))} must not be parallel")
    entries = np.broadcast_to(matrices.reshape(*matrices.shape[:-2], 9), (*batch, 9))
    inputs = [entries, *(np.broadcast_to(axis, (*batch, 3)) for axis in units)]

    def kernel(f: Functions, *m: Number) -> tuple[Number, ...]:
        return _nearest(f, *quaternion_of(f, *m[:9]), *(m[start : start + 3] for start in range(9, len(m), 3)))

    return NearestAngles(*evaluate(kernel, inputs, (len(units),), ()))


def _nearest(f: Functions, r0: Number, x: Number, y: Number, z: Number, *axes: Number) -> tuple[Number, ...]:
    """The angles and the residual of a unit quaternion and one or two unit axes."""
    a0, a1, a2 = axes[0]
    along = x * a0 + y * a1 + z * a2
    if len(axes) == 1:
        half = f.atan2(along, r0)
        c, s = f.cos(half), f.sin(half)
        angles: tuple[Number, ...] = (_wrapped(f, 2.0 * half),)
        turned = (c, s * a0, s * a1, s * a2)
    else:
        b0, b1, b2 = axes[1]
        n0, n1, n2 = a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0
        cosine = a0 * b0 + a1 * b1 + a2 * b2
        along_second = x * b0 + y * b1 + z * b2
        across = x * n0 + y * n1 + z * n2 - r0 * cosine
        # The inner product with the quaternion of the turns, cos and sin of the half angles a and b on either side of
        # [[r0, along_second], [along, across]], is a term of a + b and one of a − b; each is largest on its own.
        total = f.atan2(along + along_second, r0 - across)
        difference = f.atan2(along - along_second, r0 + across)
        ha, hb = 0.5 * (total + difference), 0.5 * (total - difference)
        ca, sa, cb, sb = f.cos(ha), f.sin(ha), f.cos(hb), f.sin(hb)
        p, q, r = sa * cb, ca * sb, sa * sb
        angles = (_wrapped(f, total + difference), _wrapped(f, total - difference))
        turned = (ca * cb - r * cosine, p * a0 + q * b0 + r * n0, p * a1 + q * b1 + r * n1, p * a2 + q * b2 + r * n2)
    pairs = tuple(zip((r0, x, y, z), turned, strict=True))
    apart = sum((u - v) * (u - v) for u, v in pairs)
    together = sum((u + v) * (u + v) for u, v in pairs)
    return *angles, 4.0 * f.atan2(f.sqrt(apart), f.sqrt(together))


def _wrapped(f: Functions, angle: Number) -> Number:
    """The angle, from within [−2π, 2π], taken into [−π, π]."""
    return angle - f.where(angle > math.pi, 2.0 * math.pi, f.where(angle < -math.pi, -2.0 * math.pi, 0.0)) + 0.0
