"""The report of a cross-check: one row per convention and oracle, and the counting of a row's differences."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from nao_kin import rotations
from nao_kin._core.arrays import Floats, choice, finite_or_none
from nao_kin._core.text import abbreviated, one_line_repr, text_table
from nao_kin.crosscheck.samples import Configurations, RotationSample
from nao_kin.errors import NaoKinError, WrongShape
from nao_kin.joints import JointAxes

TOLERANCE = 1e-12


@dataclass(frozen=True)
class Place:
    """Where the worst discrepancy of a row occurred.

    Attributes:
        frame: the frame, or the joint, whose numbers differ most.
        configuration: index of the configuration in the run.
        stratum: the kind of configuration ("zero", "limits", "right angles" …).
        q: the configuration [rad, m or ratio].
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
        convention: the compared convention: the name of the function under test if there is one.
        against: the oracle.
        pairs: number of compared pairs of results.
        worst: largest discrepancy; infinite if a result is NaN, of the wrong shape, or an error.
        tolerance: largest discrepancy allowed.
        place: the place of the worst discrepancy; None without pairs.
        failing: the frames or joints that exceed the tolerance in some configuration.
        note: omitted comparisons and the reason, or the error that the function raised.
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
        """Whether there are compared pairs, and no discrepancy exceeds the tolerance."""
        return self.pairs > 0 and self.worst <= self.tolerance

    @property
    def cells(self) -> tuple[str, ...]:
        """The row as text, one cell for each of `Report.columns`."""
        numbers = str(self.pairs), f"{self.worst:.1e}", f"{self.tolerance:.0e}"
        return self.convention, self.against, *numbers, str(self.place or "–"), "" if self.ok else "FAILS"

    def as_dict(self) -> dict[str, Any]:
        """Return the row as plain values; an infinite discrepancy becomes None, because JSON has no infinity.

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
            "frame": place and place.frame,
            "configuration": place and {"index": place.configuration, "stratum": place.stratum, "q": list(place.q)},
            "failing": list(self.failing),
            "note": self.note,
        }


class Tally:
    """A row that is being filled: the worst difference of one convention over many chunks of configurations."""

    def __init__(self, convention: str, against: str, note: str = "") -> None:
        self.convention, self.against, self.note = convention, against, note
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
        for index in np.flatnonzero(values.max(axis=0) > TOLERANCE).tolist():
            self._failing[frames[index]] = None

    def compare(self, first: int, count: int, frames: Sequence[str], function: Callable[..., Any], *args: Any) -> None:
        """Count the differences (count, m) that a comparison returns; an error in it fails every pair of this row."""
        try:
            found = np.reshape(function(*args), (count, len(frames)))
        except Exception as error:
            self.refuse(error)
            found = np.full((count, len(frames)), np.inf)
        self.add(found, first, frames)

    def refuse(self, error: Exception) -> None:
        """Note the error that the function under test raised."""
        reason = str(error) if isinstance(error, NaoKinError) else f"{type(error).__name__}: {error}"
        self.note = f"refused: {abbreviated(reason)}"

    def row(self, configurations: Configurations) -> Row:
        """Return the row so far."""
        place = None
        if self._place is not None:
            index, frame = self._place
            place = Place(frame, index, configurations.kinds[index], tuple(configurations.q[index].tolist()))
        found = self._pairs, max(self._worst, 0.0), TOLERANCE, place, tuple(self._failing)
        return Row(self.convention, self.against, *found, self.note)


@one_line_repr
@dataclass(frozen=True)
class Report:
    """The outcome of a run.

    Attributes:
        robot: name of the robot.
        joint_names: the joints of the configurations, in their order.
        seed: seed of the run.
        strata: number of compared configurations of each kind.
        rows: the table. Each row has a `convention`, the oracle `against` which it is compared, the number of compared
            `pairs`, the `worst` discrepancy, the `tolerance`, `ok`, the `failing` frames or joints, a `note`, the text
            of its `cells`, and the `place` of the worst discrepancy, or None: the `frame` or joint, the index of the
            `configuration`, the `stratum` (kind of configuration), and `q`.
        columns: headings of the cells of every row.
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
        """The rows that exceed their tolerance."""
        return tuple(row for row in self.rows if not row.ok)

    @property
    def worst(self) -> dict[str, Row]:
        """For each convention, the row that is nearest to its tolerance, or exceeds it most."""
        found: dict[str, Row] = {}
        for row in self.rows:
            known = found.get(row.convention)
            if known is None or row.worst / row.tolerance > known.worst / known.tolerance:
                found[row.convention] = row
        return found

    def as_dict(self) -> dict[str, Any]:
        """Return the report as plain values.

        Examples:
            >>> nk.crosscheck.run(nk.load_nao(), samples=1).as_dict()["ok"]
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
        """Return the table as text."""
        verdict = "all within tolerance" if self.ok else f"{len(self.failures)} rows exceed their tolerance"
        return f"{text_table(self.columns, [row.cells for row in self.rows])}\n{self.robot}: {verdict}"


# --- The functions under test, the comparison of one row, and differences of two results.

# The difference of a pair that is not counted.
LEFT_OUT = -1.0

Function = Callable[..., Any]


# Public functions of `nao_kin.rotations` without a convention: checks, draws, fits to data, and signs of quaternions.
_OTHERS = {
    *("check_rotation", "is_rotation", "nearest_rotation", "random_rotation", "random_rotation_near"),
    *("rotation_from_directions", "rotation_from_points", "quat_canonical", "quat_unwrap"),
}


class Conversions:
    """The conversions to compare; by default the library's own, each public function of `nao_kin.rotations`.

    `Conversions(log=mine)` tests another function; `joint_axes` is the class `JointAxes`, or what replaces it.

    Examples:
        >>> mine = nk.crosscheck.Conversions(log=lambda R: -nk.rotations.log(R))
        >>> report = nk.crosscheck.run(nk.load_nao(), samples=1, conversions=mine)
        >>> [row.convention for row in report.rows if not row.ok]
        ['log', 'log']
    """

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Function: ...

    def __init__(self, **tested: Function) -> None:
        offered = {name: getattr(rotations, name) for name in rotations.__all__ if name not in _OTHERS}
        results = (type, tuple)  # classes of results, and SEQUENCES
        own = {name: value for name, value in offered.items() if not isinstance(value, results)}
        own |= {"RotationSpline": rotations.RotationSpline, "joint_axes": JointAxes}
        for name in tested:
            choice(name, own, "conversion")
        vars(self).update(own | tested)


@dataclass(frozen=True)
class Check:
    """A row of the report as a function of n rotations: differences, shape (n,); `LEFT_OUT` for omitted rotations."""

    convention: str
    against: str
    difference: Callable[[RotationSample, Conversions], Floats]
    note: str = ""


def shaped(ours: Any, shape: tuple[int, ...]) -> Floats:
    """Return the result of a function under test as an array of this shape, or raise WrongShape."""
    mine = np.asarray(ours, dtype=np.float64)
    if mine.shape != shape:
        raise WrongShape("the returned array", str(shape), mine.shape)
    return mine


def difference(ours: Any, theirs: Floats) -> Floats:
    """Return the largest difference of any component, shape (n,)."""
    errors = np.abs(shaped(ours, theirs.shape) - theirs)
    return np.asarray(errors.max(axis=tuple(range(1, errors.ndim)), initial=0.0))


def angle_difference(ours: Floats, theirs: Floats) -> Floats:
    """Return the difference of angles modulo a turn, in magnitude, component by component [rad]."""
    error = ours - theirs
    return np.asarray(np.abs(error - 2.0 * np.pi * np.round(error / (2.0 * np.pi))))


def direction_difference(ours: Any, theirs: Floats) -> Floats:
    """Return the difference of vectors where v and −v are equivalent."""
    return np.minimum(difference(ours, theirs), difference(ours, -theirs))


def rotation_vector_difference(ours: Any, theirs: Floats) -> Floats:
    """Return the difference of rotation vectors, where v and v − 2π v/‖v‖ are equivalent."""
    length = np.sqrt(np.square(theirs).sum(axis=1, keepdims=True))
    opposite = theirs - 2.0 * np.pi * theirs / np.where(length > 0.0, length, 1.0)
    return np.minimum(difference(ours, theirs), difference(ours, opposite))


def outside(value: Floats, lower: float, upper: float) -> Floats:
    """Return how far a value is outside [lower, upper]."""
    return np.maximum(np.maximum(lower - value, value - upper), 0.0)


def largest(*differences: Floats) -> Floats:
    """Return the largest of several differences of each pair; NaN counts as the largest."""
    return np.asarray(np.maximum.reduce(differences))
