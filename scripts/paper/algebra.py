"""Problems 4 and 6: the matrix 1 + u vᵀ, and the Plücker coordinates of a line."""

from __future__ import annotations

import numpy as np

from nao_kin.errors import SingularMatrix
from nao_kin.rotations import rank_one
from nao_kin.screws.lines import PluckerLine, transfer_matrix
from paper import symbolic
from paper.rows import Erratum, Problem, Row, largest


def problem_4() -> Problem:
    """Solve problem 4: eigenvalues, eigenvectors and determinant of T = 1 + u vᵀ."""
    u, v = np.random.default_rng(4).normal(size=(2, 1000, 3))
    T, eigen = rank_one.matrix(u, v), rank_one.eigen(u, v)
    residual = T @ eigen.vectors - eigen.vectors * eigen.values[:, None, :]
    numeric_det = np.linalg.det(T)
    shear = rank_one.eigen([1, 2, 3], [3, 0, -1])
    singular = rank_one.eigen([1, 2, 3], [2, 0, -1])
    proofs, notes = symbolic.rank_one()
    return Problem(
        "4",
        "eigenvalues, eigenvectors and determinant of T = I + u vᵀ",
        rows=(
            Row("largest |T w − λ w| over 1000 pairs", "rotations.rank_one.eigen", largest(residual), 0),
            Row(
                "largest |vᵀ w| of the first two",
                "rotations.rank_one.eigen",
                largest(v[:, None, :] @ eigen.vectors[..., :2]),
                0,
            ),
            Row(
                "largest |det T − (1 + u·v)|",
                "rotations.rank_one.determinant",
                largest(rank_one.determinant(u, v) - numeric_det),
                0,
            ),
            Row(
                "eigenvalues, u = (1, 2, 3), v = (4, 5, 6)",
                "rotations.rank_one.eigen",
                rank_one.eigen([1, 2, 3], [4, 5, 6]).values,
                [1, 1, 33],
            ),
            Row("eigenvalues, u·v = 0", "rotations.rank_one.eigen", shear.values, [1, 1, 1]),
            Row("u·v = 0 is defective", "rotations.rank_one.eigen", shear.defective, True),
            Row("its Jordan form", "rotations.rank_one.eigen", shear.jordan_form, [[1, 0, 0], [0, 1, 1], [0, 0, 1]]),
            Row("eigenvalues, u·v = −1", "rotations.rank_one.eigen", singular.values, [1, 1, 0]),
            Row(
                "determinant, u·v = −1",
                "rotations.rank_one.determinant",
                rank_one.determinant([1, 2, 3], [2, 0, -1]),
                0,
            ),
            Row("u·v = −1 has no inverse", "rotations.rank_one.inverse", _refuses_singular(), True),
            *proofs,
        ),
        errata=(
            Erratum(
                where="appendix A",
                printed="PHS = 1 + dot(u.T, v), then print(RHS) and LHS − RHS",
                right="the right-hand side under one name",
                evidence="by inspection: the listing stops with a NameError at RHS; the identity it was to show holds",
                refuted=True,
            ),
        ),
        notes=notes,
    )


def problem_6() -> Problem:
    """Solve problem 6: Plücker coordinates of one line about two origins."""
    p, q, a, b = [1, 2, 3], [4, 5, 6], [0, 0, 0], [0, 0, 1]
    from_a, from_b = (PluckerLine.through(p, q, origin=origin) for origin in (a, b))
    U = transfer_matrix(a, b)
    expected = np.eye(6)
    expected[3:, :3] = [[0, 1, 0], [-1, 0, 0], [0, 0, 0]]
    return Problem(
        "6",
        "Plücker coordinates of the line through (1, 2, 3) and (4, 5, 6)",
        rows=(
            Row("direction e", "lines.PluckerLine.through", from_a.direction, np.ones(3) / np.sqrt(3)),
            Row(
                "moment about a = (0, 0, 0)",
                "lines.PluckerLine.through",
                from_a.moment,
                np.array([-1, 2, -1]) / np.sqrt(3),
            ),
            Row(
                "moment about b = (0, 0, 1)",
                "lines.PluckerLine.through",
                from_b.moment,
                np.array([0, 1, -1]) / np.sqrt(3),
            ),
            Row("transfer matrix U", "lines.transfer_matrix", U, expected),
            Row("k_b − U k_a", "lines.transfer_matrix", from_b.coordinates - U @ from_a.coordinates, np.zeros(6)),
            Row(
                "k_b − k_a transferred",
                "lines.PluckerLine.transfer_to",
                from_b.coordinates - from_a.transfer_to(b).coordinates,
                np.zeros(6),
            ),
        ),
    )


def _refuses_singular() -> bool:
    try:
        rank_one.inverse([1, 2, 3], [2, 0, -1])
    except SingularMatrix:
        return True
    return False
