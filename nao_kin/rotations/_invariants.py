"""Natural, linear and quadratic invariants of a rotation, each in both directions."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, as_floats, common_batch, first_index
from nao_kin._core.kernels import Functions, Number, evaluate
from nao_kin._core.warn import warn_of_degrees
from nao_kin.errors import BadArgument, at_index
from nao_kin.rotations._checks import TOLERANCE, evaluate_normalised, evaluate_rotations
from nao_kin.rotations._elementary import from_linear, from_natural, rodrigues
from nao_kin.rotations._quaternions import axis_and_half_angle, matrix_from_quat, quaternion_of

# Where cos φ rounds to −1, the axis in sin φ e has lost eight digits or more.
_SINE_NEAR_PI = 2.0**-26


def natural_invariants(R: ArrayLike) -> tuple[Floats, Floats]:
    """Axis e and angle φ of a rotation, R = 1 + sin φ [e×] + (1 − cos φ) [e×]².

    Computed from the quadratic invariants, φ = 2 atan2(‖r‖, r0) and e = r/‖r‖, which are accurate at φ = 0 and φ = π.
    There an arccos loses half the digits, and vect R loses the axis. For matrices exact to rounding the angle is
    accurate to a few 1e-16, near 0 also relative to itself, and the axis to a few 1e-16 at every angle but 0.

    Args:
        R: rotation matrices, shape (..., 3, 3).

    Returns:
        The axis and the angle. Axis: unit vectors, shape (..., 3); zero where the angle is zero, which has no axis. At
        φ = π its first non-zero component is positive. Angle: shape (...), in [0, π] [rad].

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 2.3.2 and 2.3.6.

    Examples:
        >>> axis, angle = nk.rotations.natural_invariants([[0, 0, 1], [1, 0, 0], [0, 1, 0]])
        >>> axis, np.rad2deg(angle).round(9)
        (array([0.5774, 0.5774, 0.5774]), np.float64(120.0))
    """
    axis, angle = evaluate_rotations(_natural, R, (3,), ())
    return axis, angle


def matrix_from_natural(axis: ArrayLike, angle: ArrayLike) -> Floats:
    """Rotation matrix of an axis and an angle, R = 1 + sin φ [e×] + (1 − cos φ) [e×]² with e = axis/‖axis‖.

    Args:
        axis: vectors of any length, shape (..., 3); a zero vector only where the angle is zero.
        angle: shape (...) [rad]; broadcasts with the axis.

    Returns:
        Rotation matrices, shape (..., 3, 3).

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 2.3.2.

    Examples:
        >>> nk.rotations.matrix_from_natural([1, 1, 1], np.deg2rad(120))[0].round(12) + 0.0
        array([0., 0., 1.])
    """
    axes, angles = vector_and_number(axis, angle, "axis", "angle")
    warn_of_degrees(angles, "angle")
    angles = angles[..., np.newaxis]
    if not angles.all():
        axes = np.where((angles == 0.0) & ~axes.any(axis=-1, keepdims=True), 1.0, axes)
    return evaluate_normalised(from_natural, axes, "rotation axis", angles)


def linear_invariants(R: ArrayLike) -> tuple[Floats, Floats]:
    """Linear invariants of a rotation, q = vect R = sin φ e and q0 = (tr R − 1)/2 = cos φ.

    vect R = ½ (r32 − r23, r13 − r31, r21 − r12).

    Args:
        R: rotation matrices, shape (..., 3, 3).

    Returns:
        q: shape (..., 3).
        q0: shape (...).

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 2.3.3.

    Examples:
        >>> nk.rotations.linear_invariants(nk.rotations.rot_z(0.5))  # sin 0.5 and cos 0.5
        (array([0.    , 0.    , 0.4794]), array(0.8776))
    """
    q, q0 = evaluate_rotations(_linear, R, (3,), ())
    return q, q0


def matrix_from_linear(q: ArrayLike, q0: ArrayLike) -> Floats:
    """Rotation matrix of its linear invariants, R = q0 1 + [q×] + q qᵀ/(1 + q0).

    Near φ = π, q = sin φ e vanishes and with it the axis: rounding of q turns the axis by about 1e-16/‖q‖. Where cos φ
    has rounded to −1 (‖q‖ < 2⁻²⁶) the function raises an error instead of guessing; natural and quadratic invariants
    have no such limit.

    Args:
        q: sin φ e, shape (..., 3).
        q0: cos φ, shape (...); broadcasts with q.

    Returns:
        Rotation matrices, shape (..., 3, 3).

    Raises:
        BadArgument: ‖q‖² + q0² differs from 1 by more than 1e-6, or the axis is lost.

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 2.3.3.

    Examples:
        >>> R = nk.rotations.matrix_from_linear([0.0, 0.0, 0.6], 0.8)
        >>> np.allclose(R, nk.rotations.rot_z(np.arctan2(0.6, 0.8)))
        True
    """
    vectors, scalars = vector_and_number(q, q0, "q", "q0")
    sine = np.sqrt(np.square(vectors).sum(axis=-1))
    defect = np.abs(np.square(sine) + np.square(scalars) - 1.0)
    if not (defect <= TOLERANCE).all():
        index = first_index(defect > TOLERANCE)
        raise BadArgument(
            f"linear invariants{at_index(index)} must satisfy ‖q‖² + q0² = 1, "
            f"got q = {vectors[index].tolist()}, q0 = {scalars[index]:.6g}"
        )
    lost = (scalars < 0.0) & (sine < _SINE_NEAR_PI)
    if lost.any():
        index = first_index(lost)
        raise BadArgument(
            f"linear invariants{at_index(index)} belong to a rotation by π, whose axis they do not contain "
            f"(‖q‖ = {sine[index]:.3g}): use natural or quadratic invariants"
        )
    return evaluate(from_linear, [vectors, scalars[..., np.newaxis]], (3, 3))[0]


def euler_rodrigues(R: ArrayLike) -> tuple[Floats, Floats]:
    """Quadratic invariants of a rotation, the Euler–Rodrigues parameters r = sin(φ/2) e and r0 = cos(φ/2).

    They are the unit quaternion (r0, r1, r2, r3) of `quat_from_matrix`, with its canonical sign and accuracy.

    Args:
        R: rotation matrices, shape (..., 3, 3).

    Returns:
        r: shape (..., 3).
        r0: shape (...), not negative.

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 2.3.6.

    Examples:
        >>> nk.rotations.euler_rodrigues(nk.rotations.rot_x(np.pi / 2))  # sin 45° and cos 45°
        (array([0.7071, 0.    , 0.    ]), array(0.7071))
    """
    r0, r = evaluate_rotations(quaternion_of, R, (), (3,))
    return r, r0


def matrix_from_euler_rodrigues(r: ArrayLike, r0: ArrayLike) -> Floats:
    """Rotation matrix of the quadratic invariants, R = (r0² − r·r) 1 + 2 r rᵀ + 2 r0 [r×].

    Args:
        r: sin(φ/2) e, shape (..., 3).
        r0: cos(φ/2), shape (...); broadcasts with r. (r, r0), which must not be zero, is normalised first.

    Returns:
        Rotation matrices, shape (..., 3, 3).

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 2.3.6.

    Examples:
        >>> R = nk.rotations.matrix_from_euler_rodrigues([0.6, 0.0, 0.0], 0.8)
        >>> np.allclose(R, nk.rotations.rot_x(2 * np.arctan2(0.6, 0.8)))
        True
    """
    vectors, scalars = vector_and_number(r, r0, "r", "r0")
    return matrix_from_quat(np.concatenate([scalars[..., np.newaxis], vectors], axis=-1))


def vector_and_number(
    vector: ArrayLike, number: ArrayLike, vector_name: str, number_name: str
) -> tuple[Floats, Floats]:
    vectors, numbers = as_floats(vector, (3,), vector_name), as_floats(number, (), number_name)
    batch = common_batch(f"{vector_name} and {number_name}", vectors.shape[:-1], numbers.shape)
    return np.broadcast_to(vectors, (*batch, 3)), np.broadcast_to(numbers, batch)


def _linear(f: Functions, *m: Number) -> tuple[Number, ...]:
    m00, m01, m02, m10, m11, m12, m20, m21, m22 = m
    return 0.5 * (m21 - m12), 0.5 * (m02 - m20), 0.5 * (m10 - m01), 0.5 * (m00 + m11 + m22 - 1.0)


def _natural(f: Functions, *m: Number) -> tuple[Number, ...]:
    *axis, half = axis_and_half_angle(f, *quaternion_of(f, *m))
    return *axis, 2.0 * half


# --- Modified Rodrigues parameters: three numbers for a rotation, regular up to a whole turn.


def mrp_from_matrix(R: ArrayLike) -> Floats:
    """Modified Rodrigues parameters of a rotation, p = e tan(φ/4) = r/(1 + r0), with φ ≤ π and so ‖p‖ ≤ 1.

    The other triple of the same rotation, ‖p‖ ≥ 1, is −p/‖p‖².

    Args:
        R: rotation matrices, shape (..., 3, 3).

    Returns:
        Parameters, shape (..., 3); at φ = π the first non-zero component is positive.

    Source: Schaub and Junkins, Stereographic orientation parameters, J. Astronautical Sciences 44(1), 1996.

    Examples:
        >>> nk.rotations.mrp_from_matrix(nk.rotations.rot_z(np.pi / 2))  # tan 22.5°
        array([0.    , 0.    , 0.4142])
    """
    return evaluate_rotations(_parameters, R, (3,))[0]


def matrix_from_mrp(p: ArrayLike) -> Floats:
    """Rotation matrix of modified Rodrigues parameters, R = 1 + (8 [p×]² + 4 (1 − p²) [p×])/(1 + p²)².

    Args:
        p: e tan(φ/4), shape (..., 3), of any length: both triples of a rotation give the same matrix.

    Returns:
        Rotation matrices, shape (..., 3, 3).

    Source: Schaub and Junkins, Stereographic orientation parameters, J. Astronautical Sciences 44(1), 1996.

    Examples:
        >>> R = nk.rotations.matrix_from_mrp([0.0, 0.0, np.tan(0.3 / 4)])
        >>> np.allclose(R, nk.rotations.rot_z(0.3))
        True
    """
    return evaluate(_matrix, [as_floats(p, (3,), "modified Rodrigues parameters")], (3, 3))[0]


def _parameters(f: Functions, *m: Number) -> tuple[Number, ...]:
    r0, r1, r2, r3 = quaternion_of(f, *m)
    divisor = 1.0 + r0
    return r1 / divisor, r2 / divisor, r3 / divisor


def _matrix(f: Functions, x: Number, y: Number, z: Number) -> tuple[Number, ...]:
    square = x * x + y * y + z * z
    quotient = 1.0 / (1.0 + square)
    return rodrigues(x, y, z, 4.0 * quotient * (1.0 - square) * quotient, 8.0 * quotient * quotient)
