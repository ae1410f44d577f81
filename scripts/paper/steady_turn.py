"""Problem 8: a rotation matrix that depends on time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nao_kin.rotations import euler_rodrigues, log, matrix_from_natural, natural_invariants
from paper import symbolic
from paper.rows import Erratum, Problem, Row, largest

DIAGONAL = np.ones(3) / np.sqrt(3.0)


def matrix_at(angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return R(t) of problem 8 for αt = `angle`, shape (..., 3, 3)."""
    c, s = np.cos(angle / 2), np.sin(angle / 2)
    rho = 2 * np.sqrt(3.0) / 3 * s * c
    diagonal, minus, plus = c**2 - s**2 / 3, 2 * s**2 / 3 - rho, 2 * s**2 / 3 + rho
    rows = [[diagonal, minus, plus], [plus, diagonal, minus], [minus, plus, diagonal]]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def problem_8() -> Problem:
    """Solve problem 8: R(t) is the rotation by αt about (1, 1, 1)/√3, for all t."""
    turn = np.linspace(0, np.pi, 1001)
    r, r0 = euler_rodrigues(matrix_at(turn))
    around = matrix_at(2 * turn) - matrix_from_natural(DIAGONAL, 2 * turn)
    parameters = np.concatenate([r - np.sin(turn / 2)[:, None] * DIAGONAL, (r0 - np.cos(turn / 2))[:, None]], axis=1)
    quarter, half, full = (euler_rodrigues(matrix_at(np.array(angle))) for angle in (np.pi / 2, np.pi, 2 * np.pi))
    axis_half, angle_half = natural_invariants(matrix_at(np.array(np.pi)))
    axis_full, angle_full = natural_invariants(matrix_at(np.array(0.0)))
    steps = log(np.swapaxes(matrix_at(2 * turn[:-1]), -1, -2) @ matrix_at(2 * turn[1:])) * 1000 / (2 * np.pi)
    forward, backward = matrix_at(np.array(np.pi / 3)), matrix_at(np.array(-np.pi / 3))
    proofs, notes = symbolic.turn_about_the_diagonal()
    return Problem(
        "8",
        "R(t), the rotation by αt about (1, 1, 1)/√3",
        rows=(
            Row("largest |R(t) − rotation by αt|, αt in [0, 2π]", "rotations.matrix_from_natural", largest(around), 0),
            Row(
                "largest error of (r, r0) as functions of αt in [0, π]",
                "rotations.euler_rodrigues",
                largest(parameters),
                0,
            ),
            Row("αt = π/2: r0", "rotations.euler_rodrigues", quarter[1], np.sqrt(0.5)),
            Row("αt = π/2: r", "rotations.euler_rodrigues", quarter[0], np.full(3, 0.408248290464)),
            Row("αt = π: r0", "rotations.euler_rodrigues", half[1], 0),
            Row("αt = π: r, of its two signs", "rotations.euler_rodrigues", half[0], DIAGONAL),
            Row("αt = π: φ", "rotations.natural_invariants", angle_half, np.pi),
            Row(
                "αt = π: e eᵀ − ½ (I + R)",
                "rotations.natural_invariants",
                np.outer(axis_half, axis_half) - (np.eye(3) + matrix_at(np.array(np.pi))) / 2,
                np.zeros((3, 3)),
            ),
            Row("αt = 2π: r0", "rotations.euler_rodrigues", full[1], 1),
            Row("αt = 2π: r", "rotations.euler_rodrigues", full[0], np.zeros(3)),
            Row("R = I: φ", "rotations.natural_invariants", angle_full, 0),
            Row("R = I: no axis, reported as zero", "rotations.natural_invariants", axis_full, np.zeros(3)),
            *proofs,
        ),
        errata=(
            Erratum(
                where="problem 8, part 3",
                printed="r = NaN at αt = 2π and αt = π, the first left as it is",
                right="at αt = 2π, R = I: φ = 0, r0 = 1, r = 0, and no axis is distinguished",
                evidence=f"r0 = {full[1]:.9g}, ‖r‖ = {np.linalg.norm(full[0]):.1e}; nothing is NaN",
                refuted=bool(np.isfinite([*full[0], full[1], *axis_full, angle_full]).all()),
            ),
            Erratum(
                where="problem 8, text",
                printed="the trace and the quaternion norm are the quadratic invariants",
                right="the quadratic invariants are the Euler–Rodrigues parameters (r, r0)",
                evidence=f"turns by ±60° share the trace {np.trace(forward):.9g} and the norm 1; their r differ",
                refuted=abs(np.trace(forward) - np.trace(backward)) < 1e-12
                and largest(euler_rodrigues(forward)[0] - euler_rodrigues(backward)[0]) > 0.5,
            ),
            Erratum(
                where="problem 8, part 2",
                printed="an oscillation, as of a pendulum",
                right="a steady turn about a fixed axis at the rate α",
                evidence=f"the angular velocity is α (1, 1, 1)/√3 at every t, to {largest(steps - DIAGONAL):.1e}",
                refuted=largest(steps - DIAGONAL) < 1e-9,
            ),
        ),
        notes=notes,
    )
