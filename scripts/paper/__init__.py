"""The problems of the source paper, each solved by the public functions of nao_kin."""

from __future__ import annotations

from collections.abc import Callable

from paper.algebra import problem_4, problem_6
from paper.anatomy import problem_3
from paper.angles import problem_5, problem_7, problem_10
from paper.invariants import problem_9, problem_11
from paper.rows import Erratum, Problem, Row
from paper.steady_turn import problem_8
from paper.structure import problem_2

PROBLEMS: tuple[Callable[[], Problem], ...] = (
    problem_2,
    problem_3,
    problem_4,
    problem_5,
    problem_6,
    problem_7,
    problem_8,
    problem_9,
    problem_10,
    problem_11,
)

__all__ = ["PROBLEMS", "Erratum", "Problem", "Row"]
