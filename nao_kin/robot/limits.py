"""Joint limits: the box of every joint, and tables in which one joint's range depends on another's value."""

from __future__ import annotations

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

    def without_index(self) -> str:
        """Joint, value and range in words; which configuration it was is left out."""
        unit = "" if self.unit == "1" else f" {self.unit}"
        text = f"{self.joint} = {self.value:.6g} not in [{self.lower:.6g}, {self.upper:.6g}]{unit}"
        if self.of is not None:
            text += f" at {self.of} = {self.of_value:.6g}"
        return text

    def __str__(self) -> str:
        text = self.without_index()
        return text if not self.index else f"{text} (configuration {', '.join(map(str, self.index))})"


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

    def violations(self, values: Floats, joints: Collection[str] | None = None) -> tuple[LimitViolation, ...]:
        """Every joint outside its box, and every joint outside its table, in order of the batch.

        Args:
            values: joint values, shape (..., n).
            joints: look at these joints only; None for all. A table is looked at when either of its joints is named.
        """
        found = []
        outside = (values < self.lower - TOLERANCE) | (values > self.upper + TOLERANCE)
        if joints is not None:
            outside &= np.array([name in joints for name in self.names], dtype=np.bool_)
        for place in np.argwhere(outside).tolist():
            at, column = tuple(place[:-1]), place[-1]
            value, bounds = float(values[tuple(place)]), (float(self.lower[column]), float(self.upper[column]))
            found.append(LimitViolation(self.names[column], value, *bounds, self.units[column], at))
        for table, column, of in self._tables:
            if joints is not None and not {table.joint, table.of} & set(joints):
                continue
            driver, driven = values[..., of], values[..., column]
            lower, upper = _range(table, driver)
            # Where the box is already violated, the table adds nothing.
            outside_table = ((driven < lower - TOLERANCE) | (driven > upper + TOLERANCE)) & ~outside[..., column]
            for place in np.argwhere(outside_table).tolist():
                at = tuple(place)
                bounds = float(lower[at]), float(upper[at])
                violation = LimitViolation(table.joint, float(driven[at]), *bounds, self.units[column], at)
                found.append(replace(violation, of=table.of, of_value=float(driver[at])))
        return tuple(sorted(found, key=lambda violation: (violation.index, -violation.excess)))

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
