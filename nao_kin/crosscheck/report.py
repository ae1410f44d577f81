"""What a cross-check found: one row per convention and oracle, and how a row is tallied."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from nao_kin import rotations
from nao_kin._core.arrays import Floats, finite_or_none
from nao_kin._core.text import abbreviated
from nao_kin.crosscheck.samples import Configurations, RotationSample
from nao_kin.errors import NaoKinError, WrongShape
from nao_kin.joints import JointAxes

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
            "frame": place and place.frame,
            "configuration": place and {"index": place.configuration, "stratum": place.stratum, "q": list(place.q)},
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

    def compare(self, first: int, count: int, frames: Sequence[str], function: Callable[..., Any], *args: Any) -> None:
        """Count the differences (count, m) that a comparison of the arguments returns; an error fails every pair.

        Whatever a function under test raises is its own failure, and that of no other row.
        """
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
        """The row so far."""
        place = None
        if self._place is not None:
            index, frame = self._place
            place = Place(frame, index, configurations.kinds[index], tuple(configurations.q[index].tolist()))
        found = self._pairs, max(self._worst, 0.0), self.tolerance, place, tuple(self._failing)
        return Row(self.convention, self.against, *found, self.note)


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


# --- What is compared and how: the functions under test, one row's comparison, and how far two results are apart.

# The difference of a pair that says nothing about the convention; it is not counted.
LEFT_OUT = -1.0

Function = Callable[..., Any]


@dataclass(frozen=True)
class Conversions:
    """Every conversion that a run compares; by default the library's own.

    Each field holds the public function of that name of `nao_kin.rotations`, and `joint_axes` what makes the
    `JointAxes` of a robot. The hand-rolled forward kinematics turns with `rot_x`, `rot_y` and `rot_z`.
    `dataclasses.replace(Conversions(), log=mine)` puts another function to the test.

    Examples:
        >>> from dataclasses import replace
        >>> mine = replace(nk.crosscheck.Conversions(), log=lambda R: -nk.rotations.log(R))
        >>> report = nk.crosscheck.run(nk.load_nao(), samples=1, conversions=mine)
        >>> [row.convention for row in report.rows if not row.ok]
        ['log', 'log']
    """

    rot_x: Function = rotations.rot_x
    rot_y: Function = rotations.rot_y
    rot_z: Function = rotations.rot_z
    matrix_from_rpy: Function = rotations.matrix_from_rpy
    rpy_from_matrix: Function = rotations.rpy_from_matrix
    matrix_from_euler: Function = rotations.matrix_from_euler
    euler_from_matrix: Function = rotations.euler_from_matrix
    matrix_from_davenport: Function = rotations.matrix_from_davenport
    davenport_angles: Function = rotations.davenport_angles
    matrix_from_natural: Function = rotations.matrix_from_natural
    natural_invariants: Function = rotations.natural_invariants
    matrix_from_linear: Function = rotations.matrix_from_linear
    linear_invariants: Function = rotations.linear_invariants
    matrix_from_euler_rodrigues: Function = rotations.matrix_from_euler_rodrigues
    euler_rodrigues: Function = rotations.euler_rodrigues
    exp: Function = rotations.exp
    log: Function = rotations.log
    matrix_from_quat: Function = rotations.matrix_from_quat
    quat_from_matrix: Function = rotations.quat_from_matrix
    quat_multiply: Function = rotations.quat_multiply
    quat_conjugate: Function = rotations.quat_conjugate
    quat_to_xyzw: Function = rotations.quat_to_xyzw
    quat_from_xyzw: Function = rotations.quat_from_xyzw
    slerp: Function = rotations.slerp
    joint_axes: Function = JointAxes


@dataclass(frozen=True)
class Check:
    """A row of the report as a function of rotations: one conversion beside one oracle.

    Attributes:
        convention, against, note: as in `Row`.
        difference: how far the two are apart at n rotations, shape (n,); `LEFT_OUT` where a rotation says nothing.
    """

    convention: str
    against: str
    difference: Callable[[RotationSample, Conversions], Floats]
    note: str = ""


def shaped(ours: Any, shape: tuple[int, ...]) -> Floats:
    """What a function under test returned, as an array.

    Raises:
        WrongShape: it has another shape.
    """
    mine = np.asarray(ours, dtype=np.float64)
    if mine.shape != shape:
        raise WrongShape("what it returned", str(shape), mine.shape)
    return mine


def difference(ours: Any, theirs: Floats) -> Floats:
    """Largest difference of any component, shape (n,)."""
    apart = np.abs(shaped(ours, theirs.shape) - theirs)
    return np.asarray(apart.max(axis=tuple(range(1, apart.ndim)), initial=0.0))


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
