"""Three turns about arbitrary axes, consecutive ones perpendicular: Davenport's generalisation of Euler angles."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._arrays import Floats, as_floats
from nao_kin._vectors import unit
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.rotations._kernels import evaluate, rescaled
from nao_kin.rotations._sequences import AtLock, check_at_lock, find_convention
from nao_kin.rotations._three_angles import extraction
from nao_kin.rotations.checks import as_rotations
from nao_kin.rotations.euler import EulerAngles
from nao_kin.rotations.invariants import matrix_from_natural

# How far from perpendicular two unit axes may be; the matrix of the angles is then wrong by as much.
_SKEW = 1e-9
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
        a1: first axis, shape (3,), of any length but zero.
        a2: second axis, perpendicular to the first and the third.
        a3: third axis.
        at_lock: which outer angle is zero at lock, the "first" or the "third". Lock is a3, carried along, parallel to
            a1: |sin(β + δ)| up to 4 × 2⁻⁵².

    Returns:
        Principal triple (its β in [−δ, π − δ] where δ ≥ 0, else in [−π − δ, −δ]: the half turn that holds β = 0), the
        other triple (its β in the other half turn), and the lock mask. All angles in [−π, π]. A first and a third axis
        that are parallel up to rounding, |sin δ| ≤ 4 × 2⁻⁵², count as parallel: δ is 0 or π.

    Raises:
        BadArgument: consecutive axes that are not perpendicular to 1e-9: three turns about such axes do not reach every
            rotation. Names the axes and the angle between them.
        ZeroNorm: a zero axis.
        NotARotation: some matrix is not orthogonal with determinant +1.
        UnknownName: no such tie-break.
        WrongShape, NotFinite: wrong shapes, NaN or infinity.

    Source: Shuster and Markley, Generalization of the Euler angles, J. Astronautical Sciences 51(2), 2003.
    """
    check_at_lock(at_lock)
    first, second, third = _axes(a1, a2, a3)
    for (name, a), (other_name, b) in ((("a1", first), ("a2", second)), (("a2", second), ("a3", third))):
        if abs(float(a @ b)) > _SKEW:
            between = math.degrees(math.atan2(float(np.linalg.norm(np.cross(a, b))), float(a @ b)))
            raise BadArgument(
                f"axes {name} and {other_name} must be perpendicular, or their turns do not reach every rotation; "
                f"the angle between them is {between:.9g}°"
            )
    sine = float(second @ np.cross(first, third))
    # Exactly parallel then, or the sign of a rounding error would choose the principal triple.
    delta = math.atan2(0.0 if abs(sine) <= _PARALLEL else sine, float(first @ third))
    # Turning the second axis round puts the half turn that holds β = 0 into the principal triple, tie-break included.
    side = 1.0 if delta >= 0.0 else -1.0
    second, delta = side * second, side * delta
    B = np.stack([first, second, np.cross(first, second)], axis=-1)
    C = np.stack([third, second, np.cross(third, second)], axis=-1)
    matrices = as_rotations(R)
    kernel = extraction(find_convention("xyx", "moving"), third_is_zero=at_lock == "third")
    proper = (B.T @ matrices @ C).reshape(*matrices.shape[:-2], 9)
    angles, other, locked = evaluate(kernel, [proper], (3,), (3,), ())
    for triple in (angles, other):
        triple[..., 1] = side * _wrapped(triple[..., 1] - delta) + 0.0
    return EulerAngles(angles, other, locked.astype(np.bool_))


def matrix_from_davenport(angles: ArrayLike, a1: ArrayLike, a2: ArrayLike, a3: ArrayLike) -> Floats:
    """Rotation matrix of three turns about arbitrary axes, R = Rot(a1, α) Rot(a2, β) Rot(a3, γ).

    Args:
        angles: (α, β, γ), shape (..., 3) [rad].
        a1: first axis, shape (3,), of any length but zero; the axes need not be perpendicular.
        a2: second axis, as carried along by the first turn.
        a3: third axis, as carried along by the first two turns.

    Returns:
        Rotation matrices, shape (..., 3, 3).

    Raises:
        ZeroNorm: a zero axis.
        BadArgument, WrongShape, NotFinite: not numbers, wrong shapes, NaN or infinity.
    """
    values = as_floats(angles, (3,), "angles")
    turns = [matrix_from_natural(axis, values[..., i]) for i, axis in enumerate(_axes(a1, a2, a3))]
    return np.asarray(turns[0] @ turns[1] @ turns[2])


def _axes(*axes: ArrayLike) -> list[Floats]:
    units = []
    for i, axis in enumerate(axes, 1):
        vector = as_floats(axis, (3,), f"axis a{i}")
        if vector.ndim != 1:
            raise WrongShape(f"axis a{i}", "(3,)", vector.shape)
        units.append(unit(rescaled(vector, f"axis a{i}"), f"axis a{i}")[0])
    return units


def _wrapped(angle: Floats) -> Floats:
    """The angle, from within (−2π, 2π], taken into [−π, π]."""
    return np.where(angle > math.pi, angle - 2.0 * math.pi, np.where(angle < -math.pi, angle + 2.0 * math.pi, angle))
