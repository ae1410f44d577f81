"""Joint limits: the range of every joint, and tables in which one joint's range depends on another's value."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import LIMIT_TOLERANCE, MEASURED_TOLERANCES, Floats, LimitPolicy as LimitPolicy, drawn_ranges
from nao_kin._core.warn import warn_caller
from nao_kin.errors import MeasuredLimitsWarning
from nao_kin.robot.semantics import CoupledLimit

_MIN_DIGITS, _MAX_DIGITS = 6, 17
# A warning names this many joints with their distances, and counts the others.
_MAX_NAMED = 6


@dataclass(frozen=True)
class LimitViolation:
    """One joint outside its range.

    Attributes:
        joint: its name.
        value: its value.
        lower: smallest value allowed.
        upper: largest value allowed.
        unit: unit of the three numbers.
        index: index of the configuration in the batch.
        of: for a coupled limit, the joint on which the range depends.
        of_value: value of that joint.
    """

    joint: str
    value: float
    lower: float
    upper: float
    unit: str
    index: tuple[int, ...] = ()
    of: str | None = None
    of_value: float = 0.0

    @property
    def excess(self) -> float:
        """Distance from the range."""
        return max(self.lower - self.value, self.value - self.upper)

    def describe(self, *, degrees: bool = False, index: bool = True) -> str:
        """Return joint, value and range in words.

        Args:
            degrees: angles in degrees.
            index: name the configuration of a batch.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.configuration({"HeadYaw": 3.0}, limits="ignore")
            >>> nao.limit_violations(q)[0].describe()
            'HeadYaw = 3 not in [-2.08567, 2.08567] rad'
        """
        scale, unit = (math.degrees(1.0), "°") if degrees and self.unit == "rad" else (1.0, f" {self.unit}")
        value, lower, upper = _distinguishable(*(number * scale for number in (self.value, self.lower, self.upper)))
        text = f"{self.joint} = {value} not in [{lower}, {upper}]{'' if self.unit == '1' else unit}"
        if self.of is not None:
            text += f" at {self.of} = {self.of_value * scale:.6g}"
        return f"{text} (configuration {', '.join(map(str, self.index))})" if index and self.index else text

    def __str__(self) -> str:
        return self.describe()


@dataclass(frozen=True)
class OutsideRows:
    """The configurations of a batch with joints outside their limits.

    Attributes:
        rows: how many configurations.
        largest: largest distance of a joint from its range [rad, m or ratio].
        joint: that joint; "" for none.
        joints: joint → its largest distance, for all that are outside, the farthest first.
    """

    rows: int = 0
    largest: float = 0.0
    joint: str = ""
    joints: dict[str, float] = field(default_factory=dict)

    def and_then(self, other: OutsideRows) -> OutsideRows:
        """Return the sum of both row counts, with the larger distance of each joint."""
        joints = self.joints | {name: max(value, self.joints.get(name, 0.0)) for name, value in other.joints.items()}
        return OutsideRows._with(self.rows + other.rows, joints)

    @classmethod
    def _with(cls, rows: int, joints: dict[str, float]) -> OutsideRows:
        ordered = dict(sorted(joints.items(), key=lambda item: -item[1]))
        joint = next(iter(ordered), "")
        return cls(rows, ordered.get(joint, 0.0), joint, ordered)

    @classmethod
    def of(cls, values: Floats, inside: Floats, names: Sequence[str]) -> OutsideRows:
        """Return the rows of values (..., n) that differ from those inside the limits by more than the tolerance."""
        distances = np.abs(inside - values).reshape(-1, len(names))
        outside = distances > LIMIT_TOLERANCE
        if not outside.any():
            return cls()
        farthest = zip(names, distances.max(axis=0).tolist(), strict=True)
        beyond = {name: distance for name, distance in farthest if distance > LIMIT_TOLERANCE}
        return cls._with(int(outside.any(axis=-1).sum()), beyond)

    def warn(self, unit_of: Callable[[str], str]) -> None:
        """Warn that limits="measured" has accepted these configurations, if any; `unit_of` gives a joint's unit."""
        if not self.rows:
            return
        several = "1 configuration has" if self.rows == 1 else f"{self.rows} configurations have"
        distances = [
            f"{joint} by {f'{math.degrees(value):.2g}°' if unit_of(joint) == 'rad' else f'{value:.2g}'}"
            for joint, value in self.joints.items()
        ]
        more = len(distances) - _MAX_NAMED
        named = ", ".join(distances[:_MAX_NAMED]) + (f" and {more} more joints by less" if more > 0 else "")
        text = f"{several} joints outside their limits, {named}; accepted as measured"
        warn_caller(text, MeasuredLimitsWarning, subject="measured")


class JointLimits:
    """The limits of all joints of a robot, lower and upper (n,), for values (..., n) in the order of `names`."""

    def __init__(
        self, names: Sequence[str], lower: Floats, upper: Floats, units: Sequence[str], tables: Sequence[CoupledLimit]
    ) -> None:
        self.names, self.lower, self.upper, self.units, self.tables = names, lower, upper, units, tuple(tables)
        column = {name: index for index, name in enumerate(names)}
        # Each table, with the column of its joint and that of the joint on which the range depends.
        self._tables = [(table, column[table.joint], column[table.of]) for table in self.tables]
        # The largest distance from a limit that limits="measured" accepts, and limits="enforce".
        self.tolerances = {
            "measured": np.array([MEASURED_TOLERANCES.get(unit, LIMIT_TOLERANCE) for unit in units]),
            "enforce": np.full(len(names), LIMIT_TOLERANCE),
        }
        self._boxes = {name: (float(lower[i]), float(upper[i])) for name, i in column.items()}
        self._tolerated = {
            name: (low - LIMIT_TOLERANCE, high + LIMIT_TOLERANCE) for name, (low, high) in self._boxes.items()
        }

    def inside(self, values: Floats, policy: LimitPolicy = "enforce") -> NDArray[np.bool_]:
        """Return which joints are inside their own limits and their tables, shape (..., n)."""
        boxes, tables = self._outside(values, None, policy)
        for (_, column, _), outside in zip(self._tables, tables, strict=True):
            boxes[..., column] |= outside
        return np.logical_not(boxes, order="C")

    def surely_inside(self, values: Mapping[str, float]) -> bool:
        """Return whether these joints of one configuration are inside, with all others at zero; fast for few joints."""
        for name, value in values.items():
            lower, upper = self._tolerated[name]
            if not lower <= value <= upper:
                return False
        for table in self.tables:
            if table.joint in values or table.of in values:
                lower, upper = _range_at(table, values.get(table.of, 0.0))
                if not lower - LIMIT_TOLERANCE <= values.get(table.joint, 0.0) <= upper + LIMIT_TOLERANCE:
                    return False
        return True

    def count(self, values: Floats, joints: Collection[str] | None = None, policy: LimitPolicy = "enforce") -> int:
        """Return how many joints of all configurations are outside a limit."""
        boxes, tables = self._outside(values, joints, policy)
        return int(boxes.sum()) + sum(int(outside.sum()) for outside in tables)

    def violations(
        self,
        values: Floats,
        joints: Collection[str] | None = None,
        policy: LimitPolicy = "enforce",
        *,
        max_configurations: int | None = None,
    ) -> tuple[LimitViolation, ...]:
        """Return every joint outside its own limits, or else outside its table, by configuration and then by excess.

        With `joints`, only these joints, and only tables that contain one of them. Stops after `max_configurations`
        with any.
        """
        boxes, tables = self._outside(values, joints, policy)
        affected = np.logical_or.reduce([boxes.any(axis=-1), *tables])
        found: list[LimitViolation] = []
        for place in np.argwhere(affected)[:max_configurations].tolist():
            at = tuple(place)
            row = values[at].tolist()
            current = [
                LimitViolation(name, row[k], *self._boxes[name], self.units[k], at)
                for k, name in enumerate(self.names)
                if boxes[at][k]
            ]
            for (table, column, of), outside in zip(self._tables, tables, strict=True):
                if outside[at]:
                    ends = _range_at(table, row[of])
                    current.append(
                        LimitViolation(table.joint, row[column], *ends, self.units[column], at, table.of, row[of])
                    )
            found += sorted(current, key=lambda violation: -violation.excess)
        return tuple(found)

    def _outside(
        self, values: Floats, joints: Collection[str] | None, policy: LimitPolicy
    ) -> tuple[NDArray[np.bool_], list[NDArray[np.bool_]]]:
        """Return which joints are outside their own limits, (..., n), and which configurations violate each table."""
        tolerances = self.tolerances[policy]
        boxes = (values < self.lower - tolerances) | (values > self.upper + tolerances)
        if joints is not None:
            boxes &= np.array([name in joints for name in self.names], dtype=np.bool_)
        tables = []
        for table, column, of in self._tables:
            lower, upper = table.range(values[..., of])
            tolerance = tolerances[column]
            outside = (values[..., column] < lower - tolerance) | (values[..., column] > upper + tolerance)
            named = joints is None or table.joint in joints or table.of in joints
            # If the joint's own range is already violated, the table adds nothing.
            tables.append(np.asarray(outside & ~boxes[..., column] & named))
        return boxes, tables

    def clamp(self, values: Floats) -> Floats:
        """Return a copy with values moved to the nearest ones inside their own limits, and then inside the tables."""
        inside: Floats = np.clip(values, self.lower, self.upper)
        for table, column, of in self._tables:
            inside[..., column] = np.clip(inside[..., column], *self._narrowed(table, column, inside[..., of]))
        return inside

    def random(self, rng: np.random.Generator, shape: tuple[int, ...]) -> Floats:
        """Return values inside all limits, uniform in each range; joints without limits are uniform in [−π, π].

        Joints with one limit are uniform within a turn of it.
        """
        low, high = drawn_ranges(self.lower, self.upper)
        values = low + (high - low) * rng.random((*shape, len(self.names)))
        for table, column, of in self._tables:
            lower, upper = self._narrowed(table, column, values[..., of])
            fraction = (values[..., column] - low[column]) / (high[column] - low[column])
            values[..., column] = lower + (upper - lower) * fraction
        return values

    def _narrowed(self, table: CoupledLimit, column: int, of: Floats) -> tuple[Floats, Floats]:
        """Return the range of a table within the joint's own limits; the nearest limit if they do not overlap."""
        lower, upper = table.range(of)
        box = self.lower[column], self.upper[column]
        return np.clip(lower, *box), np.clip(upper, *box)


def _distinguishable(value: float, lower: float, upper: float) -> tuple[str, str, str]:
    """Return a value and the range that it violates, with enough digits to show the difference."""
    for digits in range(_MIN_DIGITS, _MAX_DIGITS):
        texts = f"{value:.{digits}g}", f"{lower:.{digits}g}", f"{upper:.{digits}g}"
        shown = tuple(map(float, texts))
        if not shown[1] <= shown[0] <= shown[2]:
            break
    return texts


def _range_at(table: CoupledLimit, of: float) -> tuple[float, float]:
    """Return `CoupledLimit.range` at one value, without arrays."""
    right = bisect_right(table.at, of)
    if right == 0 or right == len(table.at):
        end = min(right, len(table.at) - 1)
        return table.lower[end], table.upper[end]
    left = right - 1
    share = (of - table.at[left]) / (table.at[right] - table.at[left])
    return (
        table.lower[left] + share * (table.lower[right] - table.lower[left]),
        table.upper[left] + share * (table.upper[right] - table.upper[left]),
    )
