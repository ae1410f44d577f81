"""The parts of a reproduced problem: results next to the paper's, and errors of the paper."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

TOLERANCE = 1e-9


@dataclass(frozen=True, eq=False)
class Row:
    """One number, vector or matrix next to the paper's.

    Attributes:
        quantity: its name, with its unit.
        function: the public function that computed it.
        value: the result; a boolean for a statement.
        paper: the paper's value, corrected where an erratum says so; for a claim of the paper, the value that follows
            from the claim.
    """

    quantity: str
    function: str
    value: ArrayLike
    paper: ArrayLike

    @property
    def difference(self) -> float:
        """Return the largest absolute difference; infinite if the shapes differ or a value is NaN."""
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
        """Return the row for JSON."""
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
        where: the place in the paper.
        printed: the printed version.
        right: the correct version.
        evidence: the computation that decides between the two.
        refuted: whether the computation contradicts the printed version.
    """

    where: str
    printed: str
    right: str
    evidence: str
    refuted: bool

    def as_json(self) -> dict[str, Any]:
        """Return the erratum for JSON."""
        return {**vars(self), "refuted": bool(self.refuted)}


@dataclass(frozen=True)
class Problem:
    """A problem with all its results."""

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
        """Return the problem for JSON."""
        return {
            "problem": self.number,
            "title": self.title,
            "ok": self.ok,
            "rows": [row.as_json() for row in self.rows],
            "errata": [erratum.as_json() for erratum in self.errata],
            "notes": list(self.notes),
        }


def largest(array: ArrayLike) -> float:
    """Return the largest absolute entry."""
    return float(np.abs(np.asarray(array)).max(initial=0.0))
