"""Counting: the worst discrepancy of one convention over many chunks of configurations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nao_kin._arrays import Floats
from nao_kin.crosscheck._strata import Configurations
from nao_kin.crosscheck.report import Place, Row

TOLERANCE = 1e-12

# The discrepancy of a pair that says nothing about the convention; it is not counted.
LEFT_OUT = -1.0


class Tally:
    """One row in the making.

    Args:
        convention, against, tolerance, note: as in `Row`.
    """

    def __init__(self, convention: str, against: str, tolerance: float = TOLERANCE, note: str = "") -> None:
        self.convention, self.against, self.tolerance, self.note = convention, against, tolerance, note
        self._pairs, self._worst = 0, -1.0
        self._place: tuple[int, str] | None = None
        self._failing: dict[str, None] = {}

    def add(self, discrepancy: Floats, first: int, frames: Sequence[str]) -> None:
        """Count the discrepancies (n, m) of m frames at the configurations from index `first` on."""
        values = np.where(np.isnan(discrepancy), np.inf, discrepancy)
        self._pairs += int(np.count_nonzero(values >= 0.0))
        if values.size == 0:
            return
        row, column = np.unravel_index(int(np.argmax(values)), values.shape)
        worst = float(values[row, column])
        if worst > self._worst:
            self._worst, self._place = worst, (first + int(row), frames[int(column)])
        for index in np.flatnonzero(values.max(axis=0) > self.tolerance).tolist():
            self._failing[frames[index]] = None

    def refuse(self, reason: str, shape: tuple[int, int], first: int, frames: Sequence[str]) -> None:
        """Count pairs (n, m) that could not be compared because the function under test raised an error."""
        self.note = f"refused: {reason}"
        self.add(np.full(shape, np.inf), first, frames)

    def row(self, configurations: Configurations) -> Row:
        """The row so far."""
        place = None
        if self._place is not None:
            index, frame = self._place
            q = tuple(configurations.q[index].tolist())
            place = Place(frame, index, configurations.strata[index], q)
        worst = max(self._worst, 0.0)
        return Row(
            self.convention, self.against, self._pairs, worst, self.tolerance, place, tuple(self._failing), self.note
        )
