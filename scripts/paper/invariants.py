"""Problems 9 and 11: natural, linear and quadratic invariants, and the matrix from them, also in singular cases."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from nao_kin.errors import BadArgument, ZeroNorm
from nao_kin.rotations import (
    check_rotation,
    euler_from_matrix,
    euler_rodrigues,
    linear_invariants,
    matrix_from_euler_rodrigues,
    matrix_from_linear,
    matrix_from_natural,
    matrix_from_quat,
    natural_invariants,
    quat_multiply,
    rot_x,
    rot_y,
)
from paper.rows import Erratum, Problem, Row, largest

ROOT2 = np.sqrt(2.0)
DIAGONAL = np.ones(3) / np.sqrt(3.0)
MATRIX_9 = np.array([[1 / ROOT2, 0, 1 / ROOT2], [-1 / 2, 1 / ROOT2, 1 / 2], [-1 / 2, -1 / ROOT2, 1 / 2]])
AXIS_9 = [-0.678598344546, 0.678598344546, -0.281084637715]
ANGLE_9 = 62.79942961983808
R_9, R0_9 = [-0.353553390593, 0.353553390593, -0.146446609407], 0.853553390593


def problem_9() -> Problem:
    """Solve problem 9: a given matrix is a rotation; its invariants."""
    defects = check_rotation(MATRIX_9)
    axis, angle = natural_invariants(MATRIX_9)
    r, r0 = euler_rodrigues(MATRIX_9)
    printed = np.arccos((1 - np.trace(MATRIX_9)) / 2)
    return Problem(
        "9",
        "a matrix is a rotation; axis, angle, Euler–Rodrigues parameters",
        rows=(
            Row("det R − 1", "rotations.check_rotation", defects.determinant, 0),
            Row("largest entry of RᵀR − 1", "rotations.check_rotation", defects.orthogonality, 0),
            Row("angle φ [deg]", "rotations.natural_invariants", np.rad2deg(angle), ANGLE_9),
            Row("axis e", "rotations.natural_invariants", axis, AXIS_9),
            Row("r0", "rotations.euler_rodrigues", r0, R0_9),
            Row("r", "rotations.euler_rodrigues", r, R_9),
        ),
        errata=(
            Erratum(
                where="problem 9, equation 17",
                printed="φ = arccos((1 − tr R)/2)",
                right="φ = arccos((tr R − 1)/2), as in its code; atan2(‖vect R‖, (tr R − 1)/2) stays accurate at 0 "
                "and π",
                evidence=f"the printed formula gives {np.rad2deg(printed):.9g}°, the supplement of "
                f"{np.rad2deg(angle):.9g}°",
                refuted=abs(printed - angle) > 0.1 and abs(printed + angle - np.pi) < 1e-12,
            ),
        ),
    )


def problem_11() -> Problem:
    """Solve problem 11: all invariants as functions, the matrix from them in singular cases too; quaternions."""
    axis, angle = natural_invariants(MATRIX_9)
    q, q0 = linear_invariants(MATRIX_9)
    r, r0 = euler_rodrigues(MATRIX_9)
    half_turn = np.array([[-1, 2, 2], [2, -1, 2], [2, 2, -1]]) / 3
    cases = {
        "(a) π about x": ([1, 0, 0], np.pi, np.diag([1, -1, -1])),
        "(b) π/4 about y": ([0, 1, 0], np.pi / 4, rot_y(np.pi / 4)),
        "(c) π about (1, 1, 1)/√3": (DIAGONAL, np.pi, half_turn),
    }
    rows = [
        Row("11.1 φ [deg]", "rotations.natural_invariants", np.rad2deg(angle), ANGLE_9),
        Row("11.1 e", "rotations.natural_invariants", axis, AXIS_9),
        Row("11.2 q0", "rotations.linear_invariants", q0, 0.457106781187),
        Row("11.2 q", "rotations.linear_invariants", q, [-0.603553390593, 0.603553390593, -0.25]),
        Row("11.3 r0", "rotations.euler_rodrigues", r0, R0_9),
        Row("11.3 r", "rotations.euler_rodrigues", r, R_9),
        Row("11.4 back from (e, φ)", "rotations.matrix_from_natural", matrix_from_natural(axis, angle), MATRIX_9),
        Row("11.4 back from (q, q0)", "rotations.matrix_from_linear", matrix_from_linear(q, q0), MATRIX_9),
        Row(
            "11.4 back from (r, r0)",
            "rotations.matrix_from_euler_rodrigues",
            matrix_from_euler_rodrigues(r, r0),
            MATRIX_9,
        ),
    ]
    for name, (e, phi, R) in cases.items():
        rows += [
            Row(f"11.4 {name}", "rotations.matrix_from_natural", matrix_from_natural(e, phi), R),
            Row(
                f"11.4 {name}, there and back by (e, φ)",
                "rotations.natural_invariants",
                matrix_from_natural(*natural_invariants(R)),
                R,
            ),
            Row(
                f"11.4 {name}, there and back by (r, r0)",
                "rotations.euler_rodrigues",
                matrix_from_euler_rodrigues(*euler_rodrigues(R)),
                R,
            ),
        ]
    rows += [
        Row(
            "11.4 (b) there and back by (q, q0)",
            "rotations.linear_invariants",
            matrix_from_linear(*linear_invariants(cases["(b) π/4 about y"][2])),
            rot_y(np.pi / 4),
        ),
        Row(
            "11.4 (a) from (q, q0) is rejected: it contains no axis",
            "rotations.matrix_from_linear",
            _refuses(BadArgument, matrix_from_linear, [0, 0, 0], -1),
            True,
        ),
        *_quaternion_rows(),
    ]
    locked = bool(euler_from_matrix(half_turn, "xyz", axes="moving").locked)
    same = largest(matrix_from_natural(-DIAGONAL, np.pi) - half_turn)
    found = natural_invariants([rot_x(np.pi), half_turn])[0]
    return Problem(
        "11",
        "invariants as functions, and back; quaternions",
        rows=tuple(rows),
        errata=(
            Erratum(
                where="problem 11.4, text",
                printed="the ambiguity at φ = π is gimbal lock",
                right="gimbal lock belongs to three-angle sequences; at φ = π only the sign of the axis is lost",
                evidence=f"(c) is {'' if locked else 'not '}at lock for x, y, z; e and −e differ by {same:.1e}",
                refuted=not locked and same < 1e-12,
            ),
            Erratum(
                where="problem 11.4, text",
                printed="a near-zero axis norm means an axis parallel to a coordinate axis",
                right="a zero vector is not an axis, and is an error",
                evidence="a turn by π about (0, 0, 0) is refused; one about (1e-300, 0, 0) is one about x",
                refuted=_refuses(ZeroNorm, matrix_from_natural, [0, 0, 0], np.pi)
                and largest(matrix_from_natural([1e-300, 0, 0], np.pi) - rot_x(np.pi)) < 1e-12,
            ),
            Erratum(
                where="appendix C",
                printed="solve e eᵀ = ½ (I + R) symbolically and take the first two roots",
                right="the column of ½ (I + R) with the largest diagonal entry is the axis, for every R with φ = π",
                evidence="(a) and (c) give (1, 0, 0) and (1, 1, 1)/√3 without a solver",
                refuted=largest(found - np.array([[1, 0, 0], DIAGONAL])) < 1e-12,
            ),
        ),
    )


def _quaternion_rows() -> tuple[Row, ...]:
    p, q = np.array([1.0, 2.0, 3.0, 4.0]), np.array([0.5, -1.5, 2.5, 0.25])
    product = np.r_[p[0] * q[0] - p[1:] @ q[1:], p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])]
    q0, q1, q2, q3 = unit = p / np.linalg.norm(p)
    printed = [
        [1 - 2 * (q2**2 + q3**2), 2 * (q1 * q2 - q0 * q3), 2 * (q0 * q2 + q1 * q3)],
        [2 * (q1 * q2 + q0 * q3), 1 - 2 * (q1**2 + q3**2), 2 * (q2 * q3 - q0 * q1)],
        [2 * (q1 * q3 - q0 * q2), 2 * (q0 * q1 + q2 * q3), 1 - 2 * (q1**2 + q2**2)],
    ]
    return (
        Row("11.4 product of quaternions", "rotations.quat_multiply", quat_multiply(p, q), product),
        Row("11.4 matrix of a quaternion", "rotations.matrix_from_quat", matrix_from_quat(unit), printed),
    )


def _refuses(error: type[Exception], function: Callable[..., object], *arguments: object) -> bool:
    try:
        function(*arguments)
    except error:
        return True
    return False
