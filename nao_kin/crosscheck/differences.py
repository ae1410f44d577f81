"""How far two results are apart, one number for each pair, and the worst of them over many configurations."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin._text import abbreviated
from nao_kin.crosscheck.report import Place, Row
from nao_kin.crosscheck.samples import Configurations
from nao_kin.errors import NaoKinError

TOLERANCE = 1e-12

# The difference of a pair that says nothing about the convention; it is not counted.
LEFT_OUT = -1.0


def difference(ours: Any, theirs: Floats) -> Floats:
    """Largest difference of any component, shape (n,); infinite where the shapes differ."""
    mine = np.asarray(ours, dtype=np.float64)
    if mine.shape != theirs.shape:
        return np.full(len(theirs), np.inf)
    return np.asarray(np.abs(mine - theirs).max(axis=tuple(range(1, mine.ndim)), initial=0.0))


def angle_difference(ours: Floats, theirs: Floats) -> Floats:
    """Difference of angles modulo a turn, in magnitude, component by component [rad]."""
    apart = ours - theirs
    return np.asarray(np.abs(apart - 2.0 * np.pi * np.round(apart / (2.0 * np.pi))))


def direction_difference(ours: Any, theirs: Floats) -> Floats:
    """Difference of vectors of which v and −v mean the same."""
    return np.minimum(difference(ours, theirs), difference(ours, -theirs))


def rotation_vector_difference(ours: Any, theirs: Floats) -> Floats:
    """Difference of rotation vectors, of which v and v − 2π v/‖v‖ mean the same: none jumps at π."""
    length = np.sqrt(np.square(theirs).sum(axis=1, keepdims=True))
    round_the_other_way = theirs - 2.0 * np.pi * theirs / np.where(length > 0.0, length, 1.0)
    return np.minimum(difference(ours, theirs), difference(ours, round_the_other_way))


def outside(value: Floats, lower: float, upper: float) -> Floats:
    """How far a value is outside [lower, upper]."""
    return np.maximum(np.maximum(lower - value, value - upper), 0.0)


def largest(*differences: Floats) -> Floats:
    """The largest of several differences of each pair; NaN counts as the largest."""
    return np.asarray(np.maximum.reduce(differences))


class Tally:
    """One row in the making: the worst difference of one convention over many chunks of configurations.

    Args:
        convention, against, tolerance, note: as in `Row`.
    """

    def __init__(self, convention: str, against: str, tolerance: float = TOLERANCE, note: str = "") -> None:
        self.convention, self.against, self.tolerance, self.note = convention, against, tolerance, note
        self._pairs, self._worst = 0, -1.0
        self._place: tuple[int, str] | None = None
        self._failing: dict[str, None] = {}

    def add(self, differences: Floats, first: int, frames: Sequence[str]) -> None:
        """Count the differences (n, m) of m frames at the configurations from index `first` on."""
        values = np.where(np.isnan(differences), np.inf, differences)
        self._pairs += int(np.count_nonzero(values >= 0.0))
        if values.size == 0:
            return
        row, column = np.unravel_index(int(np.argmax(values)), values.shape)
        worst = float(values[row, column])
        if worst > self._worst:
            self._worst, self._place = worst, (first + int(row), frames[int(column)])
        for index in np.flatnonzero(values.max(axis=0) > self.tolerance).tolist():
            self._failing[frames[index]] = None

    def compare(self, differences: Callable[[], Floats], count: int, first: int, frames: Sequence[str]) -> None:
        """Count the differences (count, m) that a comparison returns; where it raises an error, every pair fails.

        Whatever a function under test raises is its own failure, and that of no other row.
        """
        try:
            found = np.broadcast_to(differences(), (count, len(frames)))
        except Exception as error:
            self.refuse(error)
            found = np.full((count, len(frames)), np.inf)
        self.add(found, first, frames)

    def refuse(self, error: Exception) -> None:
        """Note the error that the function under test raised."""
        reason = str(error) if isinstance(error, NaoKinError) else f"{type(error).__name__}: {error}"
        self.note = f"refused: {abbreviated(reason)}"

    def row(self, configurations: Configurations) -> Row:
        """The row so far."""
        place = None
        if self._place is not None:
            index, frame = self._place
            q = tuple(configurations.q[index].tolist())
            place = Place(frame, index, configurations.kinds[index], q)
        worst = max(self._worst, 0.0)
        return Row(
            self.convention, self.against, self._pairs, worst, self.tolerance, place, tuple(self._failing), self.note
        )
