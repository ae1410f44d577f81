"""Three turns about arbitrary axes, consecutive ones perpendicular: Davenport's generalisation of Euler angles."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._common.arrays import Floats
from nao_kin._common.kernels import evaluate, rescaled
from nao_kin._common.vectors import as_batch, common_batch, cross, dot, first_index, norm, unit
from nao_kin.errors import BadArgument, at_index
from nao_kin.rotations._checks import as_rotations
from nao_kin.rotations._euler import EulerAngles
from nao_kin.rotations._invariants import matrix_from_natural
from nao_kin.rotations._three_angles import AtLock, check_at_lock, extraction, find_convention

# |cos| up to which two axes count as perpendicular; the matrix of the angles is then wrong by as much.
_PERPENDICULAR = 1e-9
# Normalising two parallel axes of any lengths leaves at most this sine between them.
_PARALLEL = 4.0 * 2.0**-52


def davenport_angles(
    R: ArrayLike, a1: ArrayLike, a2: ArrayLike, a3: ArrayLike, *, at_lock: AtLock = "third"
) -> EulerAngles:
    """Both triples of angles with R = Rot(a1, α) Rot(a2, β) Rot(a3, γ), exact at every distance from lock.

    Each turn is about the axis as carried along by the ones before it. With δ the angle from a1 to a3 about a2 and the
    frames B = [a1, a2, a1 × a2], C = [a3, a2, a3 × a2], the matrix Bᵀ R C is a turn by α about x, β + δ about y and γ
    about x, which is taken apart as a proper Euler sequence. The coordinate axes give the 12 moving Euler sequences.

    Args:
        R: rotation matrices, shape (..., 3, 3).
        a1: first axis, shape (..., 3), of any length but zero; batch axes broadcast with those of R.
        a2: second axis, perpendicular to the first and the third.
        a3: third axis.
        at_lock: which outer angle is zero at lock, the "first" or the "third". Lock is a3, carried along, parallel to
            a1: |sin(β + δ)| up to 4 × 2⁻⁵².

    Returns:
        Principal triple (its β in [−δ, π − δ] where δ ≥ 0, else in [−π − δ, −δ]: the half turn that holds β = 0), the
        other triple (its β in the other half turn), and the lock mask. All angles in [−π, π]. A first and a third axis
        that are parallel up to rounding, |sin δ| ≤ 4 × 2⁻⁵², count as parallel: δ is 0 or π.

    Raises:
        BadArgument: axes that `are_davenport_axes` refuses: three turns about them do not reach every rotation. Names
            the two axes that are not perpendicular, the angle between them, and their index.
        ZeroNorm: a zero axis.
        NotARotation: some matrix is not orthogonal with determinant +1.
        UnknownName: no such tie-break.
        WrongShape, NotFinite: wrong or mismatched shapes, NaN or infinity.

    Source: Shuster and Markley, Generalization of the Euler angles, J. Astronautical Sciences 51(2), 2003.

    Examples:
        >>> left_hip = [0, 1, -1], [1, 0, 0], [0, 1, 0]
        >>> R = nk.rotations.matrix_from_davenport([-0.3, 0.2, -0.5], *left_hip)
        >>> nk.rotations.davenport_angles(R, *left_hip).angles
        array([-0.3,  0.2, -0.5])
    """
    check_at_lock(at_lock)
    axes = [scaled_axis(axis, f"axis a{i}") for i, axis in enumerate((a1, a2, a3), 1)]
    matrices = as_rotations(R)
    common_batch("R and the axes", matrices.shape[:-2], *(axis.shape[:-1] for axis in axes))
    for i in range(2):
        _refuse_leaning(axes[i], axes[i + 1], f"axes a{i + 1} and a{i + 2}")
    first, second, third = (unit(axis, "axis")[0] for axis in axes)
    sine = dot(second, cross(first, third))
    # Exactly parallel then, or the sign of a rounding error would choose the principal triple.
    delta = np.arctan2(np.where(np.abs(sine) <= _PARALLEL, 0.0, sine), dot(first, third))
    # Turning the second axis round puts the half turn that holds β = 0 into the principal triple, tie-break included.
    side = np.where(delta >= 0.0, 1.0, -1.0)
    second, delta = side[..., np.newaxis] * second, side * delta
    B = np.stack(np.broadcast_arrays(first, second, cross(first, second)), axis=-2)
    C = np.stack(np.broadcast_arrays(third, second, cross(third, second)), axis=-1)
    kernel = extraction(find_convention("xyx", "moving"), third_is_zero=at_lock == "third")
    turned = B @ matrices @ C
    angles, other, locked = evaluate(kernel, [turned.reshape(*turned.shape[:-2], 9)], (3,), (3,), ())
    for triple in (angles, other):
        triple[..., 1] = side * _wrapped(triple[..., 1] - delta) + 0.0
    return EulerAngles(angles, other, locked.astype(np.bool_))


def are_davenport_axes(a1: ArrayLike, a2: ArrayLike, a3: ArrayLike) -> NDArray[np.bool_]:
    """Whether turns about three axes reach every rotation: a1 ⟂ a2 and a2 ⟂ a3, |cos| of the angle up to 1e-9.

    `davenport_angles` takes exactly the axes for which this is true.

    Args:
        a1: first axes, shape (..., 3), of any length but zero.
        a2: second axes; batch axes broadcast.
        a3: third axes.

    Returns:
        Booleans, shape (...).

    Raises:
        ZeroNorm: a zero axis; carries its index.
        BadArgument, WrongShape, NotFinite: not numbers, wrong or mismatched shapes, NaN or infinity.

    Source: Davenport, Rotations about nonorthogonal axes, AIAA Journal 11(6), 1973, doi:10.2514/3.6842.

    Examples:
        >>> nk.rotations.are_davenport_axes([0, 1, -1], [1, 0, 0], [[0, 1, 0], [1, 1, 0]])
        array([ True, False])
    """
    first, second, third = (scaled_axis(axis, f"axis a{i}") for i, axis in enumerate((a1, a2, a3), 1))
    common_batch("axes a1, a2 and a3", first.shape[:-1], second.shape[:-1], third.shape[:-1])
    return np.asarray(_are_perpendicular(first, second) & _are_perpendicular(second, third))


def matrix_from_davenport(
    angles: ArrayLike, a1: ArrayLike, a2: ArrayLike | None = None, a3: ArrayLike | None = None
) -> Floats:
    """Rotation matrix of one, two or three turns about arbitrary axes, R = Rot(a1, α) Rot(a2, β) Rot(a3, γ).

    Args:
        angles: (α, β, γ), shape (..., 3), or (..., 2) or (..., 1) for fewer axes [rad].
        a1: first axis, shape (..., 3), of any length but zero; the axes need not be perpendicular. Batch axes
            broadcast with those of the angles.
        a2: second axis, as carried along by the first turn; None for one turn.
        a3: third axis, as carried along by the first two turns; None for two turns.

    Returns:
        Rotation matrices, shape (..., 3, 3).

    Raises:
        ZeroNorm: a zero axis.
        BadArgument: a third axis without a second; not numbers.
        WrongShape, NotFinite: wrong or mismatched shapes, NaN or infinity.

    Examples:
        >>> R = nk.rotations.matrix_from_davenport([0.2, 0.3], [0, 0, 1], [1, 0, 0])
        >>> np.allclose(R, nk.rotations.rot_z(0.2) @ nk.rotations.rot_x(0.3))
        True
    """
    if a2 is None and a3 is not None:
        raise BadArgument("axis a2 is missing, and a3 is given")
    given = [a1, *(axis for axis in (a2, a3) if axis is not None)]
    axes = [unit(scaled_axis(axis, f"axis a{i}"), "axis")[0] for i, axis in enumerate(given, 1)]
    values = as_batch(angles, (len(axes),), "angles")
    common_batch("angles and axes", values.shape[:-1], *(axis.shape[:-1] for axis in axes))
    found, *others = (matrix_from_natural(axis, values[..., i]) for i, axis in enumerate(axes))
    for turn in others:
        found = found @ turn
    return found


def scaled_axis(axis: ArrayLike, what: str) -> Floats:
    """The axis at a length from 1 to √3, shape (..., 3); zero refused."""
    return rescaled(as_batch(axis, (3,), what), what)


def _refuse_leaning(a: Floats, b: Floats, what: str) -> None:
    leaning = ~np.asarray(_are_perpendicular(a, b))
    if leaning.any():
        index = first_index(leaning)
        one, two = np.broadcast_to(a, (*leaning.shape, 3))[index], np.broadcast_to(b, (*leaning.shape, 3))[index]
        between = math.degrees(math.atan2(float(norm(cross(one, two))), float(one @ two)))
        raise BadArgument(
            f"{what}{at_index(index)} must be perpendicular, or their turns do not reach every rotation; "
            f"the angle between them is {between:.9g}°"
        )


def _are_perpendicular(a: Floats, b: Floats) -> NDArray[np.bool_]:
    """Written component by component, so that a batch is rounded as each of its pairs alone."""
    a0, a1, a2 = (a[..., i] for i in range(3))
    b0, b1, b2 = (b[..., i] for i in range(3))
    lengths = np.sqrt((a0 * a0 + a1 * a1 + a2 * a2) * (b0 * b0 + b1 * b1 + b2 * b2))
    return np.asarray(np.abs(a0 * b0 + a1 * b1 + a2 * b2) <= _PERPENDICULAR * lengths)


def _wrapped(angle: Floats) -> Floats:
    """The angle, from within (−2π, 2π], taken into [−π, π]."""
    return np.where(angle > math.pi, angle - 2.0 * math.pi, np.where(angle < -math.pi, angle + 2.0 * math.pi, angle))
