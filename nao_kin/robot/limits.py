"""Joint limits: the box of every joint, and tables in which one joint's range depends on another's value."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from nao_kin._arrays import Floats
from nao_kin.parameters import CoupledLimit

# Limits written in degrees come back from radians with rounding; a value that misses by less than this is on the limit.
TOLERANCE = 1e-9


@dataclass(frozen=True)
class LimitViolation:
    """One joint outside its range.

    Attributes:
        joint: its name.
        value: its value.
        lower: smallest value allowed.
        upper: largest value allowed.
        unit: unit of the three numbers.
        index: which configuration of the batch.
        of: for a table, the joint that sets the range.
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
        """How far outside."""
        return max(self.lower - self.value, self.value - self.upper)

    def describe(self, *, degrees: bool = False, index: bool = True) -> str:
        """Joint, value and range in words.

        Args:
            degrees: angles in degrees.
            index: say which configuration of a batch it was.
        """
        scale, unit = (math.degrees(1.0), "°") if degrees and self.unit == "rad" else (1.0, f" {self.unit}")
        value, lower, upper = (number * scale for number in (self.value, self.lower, self.upper))
        text = f"{self.joint} = {value:.6g} not in [{lower:.6g}, {upper:.6g}]{'' if self.unit == '1' else unit}"
        if self.of is not None:
            text += f" at {self.of} = {self.of_value * scale:.6g}"
        return f"{text} (configuration {', '.join(map(str, self.index))})" if index and self.index else text

    def __str__(self) -> str:
        return self.describe()


class JointLimits:
    """The limits of all joints of a robot, for values (..., n) in the order of `names`."""

    def __init__(
        self,
        names: tuple[str, ...],
        lower: Floats,
        upper: Floats,
        units: tuple[str, ...],
        tables: Sequence[CoupledLimit],
    ) -> None:
        self.names, self.lower, self.upper, self.units = names, lower, upper, units
        column = {name: index for index, name in enumerate(names)}
        self._tables = [(table, column[table.joint], column[table.of]) for table in tables]

    def count(self, values: Floats, joints: Collection[str] | None = None) -> int:
        """How many joints of all configurations are outside a limit."""
        boxes, tables = self._outside(values, joints)
        return int(boxes.sum()) + sum(int(outside.sum()) for outside in tables)

    def violations(
        self, values: Floats, joints: Collection[str] | None = None, *, most: int | None = None
    ) -> tuple[LimitViolation, ...]:
        """Every joint outside its box, or inside it and outside its table, in order of the batch.

        Args:
            values: joint values, shape (..., n).
            joints: look at these joints only; None for all. A table is looked at when either of its joints is named.
            most: stop after this many configurations.
        """
        boxes, tables = self._outside(values, joints)
        affected = boxes.any(axis=-1)
        for outside in tables:
            affected = affected | outside
        found = []
        for place in np.argwhere(affected)[:most].tolist():
            at = tuple(place)
            here = [
                LimitViolation(name, float(v), float(low), float(high), unit, at)
                for name, v, low, high, unit, bad in zip(
                    self.names, values[at], self.lower, self.upper, self.units, boxes[at], strict=True
                )
                if bad
            ]
            for (table, column, of), outside in zip(self._tables, tables, strict=True):
                if outside[at]:
                    driver = float(values[at][of])
                    lower, upper = _range(table, np.array(driver))
                    bounds = float(lower), float(upper)
                    violation = LimitViolation(table.joint, float(values[at][column]), *bounds, self.units[column], at)
                    here.append(replace(violation, of=table.of, of_value=driver))
            found += sorted(here, key=lambda violation: -violation.excess)
        return tuple(found)

    def _outside(
        self, values: Floats, joints: Collection[str] | None
    ) -> tuple[NDArray[np.bool_], list[NDArray[np.bool_]]]:
        """Which joints are outside their boxes, (..., n), and for each table, which configurations are outside it."""
        boxes = (values < self.lower - TOLERANCE) | (values > self.upper + TOLERANCE)
        if joints is not None:
            boxes &= np.array([name in joints for name in self.names], dtype=np.bool_)
        tables = []
        for table, column, of in self._tables:
            lower, upper = _range(table, values[..., of])
            outside = (values[..., column] < lower - TOLERANCE) | (values[..., column] > upper + TOLERANCE)
            named = joints is None or table.joint in joints or table.of in joints
            # Where the box is already violated, the table adds nothing.
            tables.append(np.asarray(outside & ~boxes[..., column] & named))
        return boxes, tables

    def clamp(self, values: Floats) -> Floats:
        """The nearest values inside the boxes, then inside the tables at those values; a copy."""
        inside: Floats = np.clip(values, self.lower, self.upper)
        for table, column, of in self._tables:
            lower, upper = _range(table, inside[..., of])
            inside[..., column] = np.clip(
                inside[..., column], np.maximum(lower, self.lower[column]), np.minimum(upper, self.upper[column])
            )
        return inside

    def random(self, rng: np.random.Generator, shape: tuple[int, ...]) -> Floats:
        """Values inside all limits, each joint uniform in its range; joints without limits uniform in [−π, π]."""
        low = np.where(
            np.isfinite(self.lower), self.lower, np.where(np.isfinite(self.upper), self.upper - np.pi, -np.pi)
        )
        high = np.where(np.isfinite(self.upper), self.upper, low + 2 * np.pi)
        values = low + (high - low) * rng.random((*shape, len(self.names)))
        for table, column, of in self._tables:
            lower, upper = _range(table, values[..., of])
            lower, upper = np.maximum(lower, self.lower[column]), np.minimum(upper, self.upper[column])
            fraction = (values[..., column] - low[column]) / (high[column] - low[column])
            values[..., column] = lower + (upper - lower) * fraction
        return values


def _range(table: CoupledLimit, at: Floats) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    return (
        np.asarray(np.interp(at, table.at, table.lower)),
        np.asarray(np.interp(at, table.at, table.upper)),
    )
