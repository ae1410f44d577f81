"""What a reproduced problem consists of: numbers beside the paper's, and what the paper got wrong."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

TOLERANCE = 1e-9


@dataclass(frozen=True, eq=False)
class Row:
    """One number, vector or matrix beside the paper's.

    Attributes:
        quantity: what it is, with its unit.
        function: the public function that computed it.
        value: what came out; a boolean for a statement.
        paper: what the paper has, corrected where an erratum says so; for what it claims, what the claim comes to.
    """

    quantity: str
    function: str
    value: ArrayLike
    paper: ArrayLike

    @property
    def difference(self) -> float:
        """Largest absolute difference; infinite where the shapes differ or a NaN came out."""
        value, paper = np.asarray(self.value, dtype=float), np.asarray(self.paper, dtype=float)
        if value.shape != paper.shape:
            return np.inf
        difference = float(np.abs(value - paper).max(initial=0.0))
        return difference if np.isfinite(difference) else np.inf

    @property
    def agrees(self) -> bool:
        """Whether the difference is at most 1e-9."""
        return self.difference <= TOLERANCE

    def as_json(self) -> dict[str, Any]:
        """The row for a program."""
        return {
            "quantity": self.quantity,
            "function": self.function,
            "value": np.asarray(self.value).tolist(),
            "paper": np.asarray(self.paper).tolist(),
            "difference": self.difference,
            "agrees": self.agrees,
        }


@dataclass(frozen=True)
class Erratum:
    """A place where the paper is wrong.

    Attributes:
        where: where in the paper.
        printed: what stands there.
        right: what is right.
        evidence: what was computed to tell the two apart.
        refuted: whether the computation speaks against the printed version.
    """

    where: str
    printed: str
    right: str
    evidence: str
    refuted: bool

    def as_json(self) -> dict[str, Any]:
        """The erratum for a program."""
        return {**vars(self), "refuted": bool(self.refuted)}


@dataclass(frozen=True)
class Problem:
    """A problem with everything that was computed for it."""

    number: str
    title: str
    rows: tuple[Row, ...]
    errata: tuple[Erratum, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether every row agrees and every erratum is refuted."""
        return all(row.agrees for row in self.rows) and all(erratum.refuted for erratum in self.errata)

    def as_json(self) -> dict[str, Any]:
        """The problem for a program."""
        return {
            "problem": self.number,
            "title": self.title,
            "ok": self.ok,
            "rows": [row.as_json() for row in self.rows],
            "errata": [erratum.as_json() for erratum in self.errata],
            "notes": list(self.notes),
        }


def largest(array: ArrayLike) -> float:
    """Largest absolute entry."""
    return float(np.abs(np.asarray(array)).max(initial=0.0))
