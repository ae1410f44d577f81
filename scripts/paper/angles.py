"""Problems 5, 7 and 10: three angles, composed and recovered, and a rotation from three points."""

from __future__ import annotations

import numpy as np

from nao_kin.rotations import (
    check_rotation,
    euler_from_matrix,
    linear_invariants,
    matrix_from_euler,
    matrix_from_rpy,
    natural_invariants,
    rotation_from_points,
)
from paper.rows import Erratum, Problem, Row, largest

ROOT3 = np.sqrt(3.0)


def problem_5() -> Problem:
    """Solve problem 5: roll, pitch and yaw of a fixed-axis matrix, both solutions."""
    Q = np.array(
        [
            [ROOT3 / 4, -ROOT3 / 4 + 3 / 8, 1 / 4 + 3 * ROOT3 / 8],
            [1 / 4, 3 / 4 + ROOT3 / 8, -ROOT3 / 4 + 3 / 8],
            [-ROOT3 / 2, 1 / 4, ROOT3 / 4],
        ]
    )
    found = euler_from_matrix(Q, "xyz", axes="fixed")
    both = matrix_from_rpy([found.angles, found.other])
    printed = largest(matrix_from_rpy(np.deg2rad([150, 120, 150])) - Q)
    return Problem(
        "5",
        "roll, pitch and yaw of a matrix, fixed axes",
        rows=(
            Row("first solution [deg]", "rotations.euler_from_matrix", np.rad2deg(found.angles), [30, 60, 30]),
            Row("second solution [deg]", "rotations.euler_from_matrix", np.rad2deg(found.other), [-150, 120, -150]),
            Row("largest difference of their matrices from Q", "rotations.matrix_from_rpy", largest(both - Q), 0),
        ),
        errata=(
            Erratum(
                where="problem 5",
                printed="second solution (150°, 120°, 150°)",
                right="(−150°, 120°, −150°): with cos β < 0 both arguments of atan2 change sign",
                evidence=f"the printed triple gives a matrix {printed:.9g} away from Q",
                refuted=printed > 0.4,
            ),
        ),
    )


def problem_7() -> Problem:
    """Solve problem 7: 30° about z, then 30° about the new y; natural invariants."""
    R = matrix_from_euler(np.deg2rad([30, 30, 0]), "zyx", axes="moving")
    axis, angle = natural_invariants(R)
    q, _ = linear_invariants(R)
    printed = float(np.linalg.norm([-0.125, 0.4665, 0.4665])) / 2
    return Problem(
        "7",
        "30° about z, then 30° about the new y",
        rows=(
            Row(
                "7.1 matrix",
                "rotations.matrix_from_euler",
                R,
                [[3 / 4, -1 / 2, ROOT3 / 4], [ROOT3 / 4, ROOT3 / 2, 1 / 4], [-1 / 2, 0, ROOT3 / 2]],
            ),
            Row("7.2 angle φ [deg]", "rotations.natural_invariants", np.rad2deg(angle), 42.181162357998204),
            Row("7.2 vect R", "rotations.linear_invariants", q, [-0.125, 0.466506350946, 0.466506350946]),
            Row("7.2 axis e", "rotations.natural_invariants", axis, [-0.186156787897, 0.694746590607, 0.694746590607]),
        ),
        errata=(
            Erratum(
                where="problem 7, equation 13",
                printed="vect R = ½ (−0.125, 0.4665, 0.4665)",
                right="vect R = (−0.125, 0.4665, 0.4665): the half is already included",
                evidence=f"‖vect R‖ must be sin φ = {np.sin(angle):.9g}; the printed vector has {printed:.4g}",
                refuted=abs(printed - float(np.sin(angle))) > 0.3,
            ),
        ),
    )


def problem_10() -> Problem:
    """Solve problem 10: an aircraft's rotation from three points, its moving-axis angles, and a fourth point."""
    a, b, c, d = np.array([[0, 10, 0], [7, 0, 0], [-7, 0, 0], [0, 8, 2]], dtype=float)
    a_after = np.array([390, 4030 - 5 * ROOT3, 1615 + 10 * ROOT3]) / 4
    b_after = np.array([800 + 14 * ROOT3, 8021 + 14 * ROOT3, 3214 - 21 * ROOT3]) / 8
    c_after = np.array([800 - 14 * ROOT3, 7979 - 14 * ROOT3, 3186 + 21 * ROOT3]) / 8
    before, after = np.array([a, b, c]), np.array([a_after, b_after, c_after])
    Q = rotation_from_points(before, after, method="triads")
    defects = check_rotation(Q)
    arms = before - (b + c) / 2, after - (b_after + c_after) / 2
    found = euler_from_matrix(Q, "xyz", axes="moving")
    return Problem(
        "10",
        "an aircraft before and after a motion",
        rows=(
            Row(
                "10.1 rotation Q from two triads",
                "rotations.rotation_from_points",
                Q,
                [
                    [0.433012701892, -0.25, 0.866025403784],
                    [0.808012701892, 0.533493649054, -0.25],
                    [-0.399519052838, 0.808012701892, 0.433012701892],
                ],
            ),
            Row(
                "10.1 least squares − triads",
                "rotations.rotation_from_points",
                rotation_from_points(before, after) - Q,
                np.zeros((3, 3)),
            ),
            Row("10.1 det Q − 1", "rotations.check_rotation", defects.determinant, 0),
            Row("10.1 largest entry of QᵀQ − 1", "rotations.check_rotation", defects.orthogonality, 0),
            Row(
                "10.1 arms after − Q · arms before",
                "rotations.rotation_from_points",
                arms[1] - arms[0] @ Q.T,
                np.zeros((3, 3)),
            ),
            Row("10.3 first solution [deg]", "rotations.euler_from_matrix", np.rad2deg(found.angles), [30, 60, 30]),
            Row(
                "10.3 second solution [deg]", "rotations.euler_from_matrix", np.rad2deg(found.other), [-150, 120, -150]
            ),
            Row(
                "10.4 tail point d′",
                "rotations.rotation_from_points",
                Q @ (d - (b + c) / 2) + (b_after + c_after) / 2,
                [99.732050807569, 1003.767949192431, 407.330127018922],
            ),
        ),
    )
