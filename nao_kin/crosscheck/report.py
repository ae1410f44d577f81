"""What a cross-check found: one row per convention and oracle, and how a row is tallied."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin._common.scalars import finite_or_none
from nao_kin._text import abbreviated
from nao_kin.crosscheck.samples import Configurations
from nao_kin.errors import NaoKinError

TOLERANCE = 1e-12


@dataclass(frozen=True)
class Place:
    """Where the worst discrepancy of a row happened.

    Attributes:
        frame: the frame, or the joint, whose numbers differ most.
        configuration: index of the configuration in the run.
        stratum: the kind of configuration ("zero", "limits", "right angles" …).
        q: the configuration [rad, m or ratio].

    Examples:
        >>> place = nk.crosscheck.Place("LArm", 3, "limits", (0.0, 0.1))
        >>> place.frame, place.stratum
        ('LArm', 'limits')
    """

    frame: str
    configuration: int
    stratum: str
    q: tuple[float, ...] = field(repr=False)

    def __str__(self) -> str:
        return f"{self.frame}, {self.stratum} #{self.configuration}"


@dataclass(frozen=True)
class Row:
    """One convention compared with one oracle.

    Attributes:
        convention: what was compared, by the name of the function under test where there is one.
        against: the oracle.
        pairs: how many pairs of results were compared.
        worst: largest discrepancy; infinite where a result is NaN, of the wrong shape, or refused.
        tolerance: largest discrepancy allowed.
        place: where the worst one happened; None without pairs.
        failing: the frames or joints that exceed the tolerance somewhere.
        note: what was left out and why, why the tolerance is what it is, or why the function refused.

    Examples:
        >>> report = nk.crosscheck.run(nk.load_nao(), samples=1)
        >>> row = report.rows[0]
        >>> row.worst <= row.tolerance
        True
    """

    convention: str
    against: str
    pairs: int
    worst: float
    tolerance: float
    place: Place | None
    failing: tuple[str, ...] = ()
    note: str = ""

    @property
    def ok(self) -> bool:
        """Whether something was compared, and no discrepancy exceeds the tolerance."""
        return self.pairs > 0 and self.worst <= self.tolerance

    @property
    def cells(self) -> tuple[str, ...]:
        """The row as text, one cell for each of `Report.columns`."""
        place = "–" if self.place is None else str(self.place)
        verdict = "" if self.ok else "FAILS"
        numbers = str(self.pairs), f"{self.worst:.1e}", f"{self.tolerance:.0e}"
        return (self.convention, self.against, *numbers, place, verdict)

    def as_dict(self) -> dict[str, Any]:
        """The row as plain values; an infinite discrepancy becomes None, for JSON has no infinity.

        Examples:
            >>> report = nk.crosscheck.run(nk.load_nao(), samples=1)
            >>> sorted(report.rows[0].as_dict())[:3]
            ['against', 'configuration', 'convention']
        """
        place = self.place
        return {
            "convention": self.convention,
            "against": self.against,
            "pairs": self.pairs,
            "worst": finite_or_none(self.worst),
            "tolerance": self.tolerance,
            "ok": self.ok,
            "frame": place.frame if place else None,
            "configuration": {"index": place.configuration, "stratum": place.stratum, "q": list(place.q)}
            if place
            else None,
            "failing": list(self.failing),
            "note": self.note,
        }


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


@dataclass(frozen=True)
class Report:
    """The outcome of a run.

    Attributes:
        robot: name of the robot.
        joint_names: the joints of the configurations, in their order.
        seed: seed of the run.
        strata: how many configurations of each kind were compared.
        rows: the table.
        columns: headings of the cells of every row.

    Examples:
        >>> report = nk.crosscheck.run(nk.load_nao(), samples=1)
        >>> report.ok, report.robot
        (True, 'nao_v6')
    """

    columns: ClassVar[tuple[str, ...]] = ("convention", "against", "pairs", "worst", "tolerance", "worst at", "")

    robot: str
    joint_names: tuple[str, ...]
    seed: int
    strata: dict[str, int]
    rows: tuple[Row, ...]

    @property
    def samples(self) -> int:
        """Number of configurations."""
        return sum(self.strata.values())

    @property
    def ok(self) -> bool:
        """Whether every row is within its tolerance."""
        return all(row.ok for row in self.rows)

    @property
    def failures(self) -> tuple[Row, ...]:
        """The rows that are not."""
        return tuple(row for row in self.rows if not row.ok)

    @property
    def worst(self) -> dict[str, Row]:
        """Of each convention the row that comes nearest to its tolerance, or exceeds it most."""
        found: dict[str, Row] = {}
        for row in self.rows:
            known = found.get(row.convention)
            if known is None or row.worst / row.tolerance > known.worst / known.tolerance:
                found[row.convention] = row
        return found

    def as_dict(self) -> dict[str, Any]:
        """The report as plain values.

        Examples:
            >>> report = nk.crosscheck.run(nk.load_nao(), samples=1)
            >>> report.as_dict()["ok"]
            True
        """
        return {
            "robot": self.robot,
            "ok": self.ok,
            "samples": self.samples,
            "seed": self.seed,
            "strata": dict(self.strata),
            "joint_names": list(self.joint_names),
            "rows": [row.as_dict() for row in self.rows],
        }

    def __str__(self) -> str:
        """The table as text."""
        cells = [self.columns, *(row.cells for row in self.rows)]
        widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
        lines = ["  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)) for line in cells]
        verdict = "all within tolerance" if self.ok else f"{len(self.failures)} rows exceed their tolerance"
        return "\n".join([*map(str.rstrip, lines), f"{self.robot}: {verdict}"])
