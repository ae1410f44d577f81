"""Which number of a typed configuration means what."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nao_kin._arrays import Floats


@dataclass(frozen=True)
class Reading:
    """The value of one joint of the robot, as a function of the robot's own configuration q.

    value = multiplier · q[column] + offset; a joint of its own has multiplier 1 and offset 0.

    Attributes:
        name: the joint.
        driver: the joint whose coordinate it reads: itself, or the one it follows.
        column: place of that coordinate in q.
        row: place of its rate in the velocity.
        multiplier: ratio of the two values.
        offset: value when the driver is at zero.
        lower: smallest value.
        upper: largest value.
    """

    name: str
    driver: str
    column: int
    row: int
    multiplier: float
    offset: float
    lower: float
    upper: float

    @property
    def follows(self) -> bool:
        """Whether another joint drives it."""
        return self.name != self.driver

    def of(self, q: Floats) -> Floats:
        """The values at configurations q, shape (..., nq) → (...)."""
        return np.asarray(self.multiplier * q[..., self.column] + self.offset)


@dataclass(frozen=True)
class Slot:
    """A coordinate of the typed model that is the value of one joint of the robot.

    Attributes:
        reading: the joint.
        column: place in the typed configuration.
        row: place of its rate in the typed velocity.
        derived: whether it only repeats what another joint of the typed model says.
    """

    reading: Reading
    column: int
    row: int
    derived: bool


@dataclass(frozen=True, eq=False)
class Ball:
    """A spherical joint of the typed model.

    Attributes:
        name: its name.
        readings: the three joints of the robot it replaces.
        axes: their axes in the ball's frame with all joints at zero, one per row, shape (3, 3).
        column: where its quaternion (x, y, z, w) begins in the typed configuration.
        row: where its angular velocity begins in the typed velocity.
    """

    name: str
    readings: tuple[Reading, Reading, Reading]
    axes: Floats
    column: int
    row: int
