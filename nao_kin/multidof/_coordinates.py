"""Which number of a typed configuration means what, and that its quaternions are rotations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats, as_floats
from nao_kin._text import at_index
from nao_kin.errors import BadArgument
from nao_kin.robot import UNIT_TOLERANCE
from nao_kin.semantics import Mimic


@dataclass(frozen=True)
class JointReading:
    """The value of one joint of the robot, as a function of the robot's own configuration q.

    value = mimic.multiplier · q[column] + mimic.offset; a joint of its own mimics itself, with multiplier 1.

    Attributes:
        name: the joint.
        mimic: the joint whose coordinate it reads, itself or the one it follows, and how.
        column: place of that coordinate in q.
        row: place of its rate in the velocity.
        lower: smallest value.
        upper: largest value.
        revolute: whether whole turns of it leave every pose as it is.
    """

    name: str
    mimic: Mimic
    column: int
    row: int
    lower: float
    upper: float
    revolute: bool

    @property
    def driver(self) -> str:
        """The joint whose coordinate it reads."""
        return self.mimic.joint

    @property
    def follows(self) -> bool:
        """Whether another joint drives it."""
        return self.name != self.mimic.joint

    def of(self, q: Floats) -> Floats:
        """The values at configurations q, shape (..., nq) → (...)."""
        return np.asarray(self.driven(q[..., self.column]))

    def driven(self, driver: Floats) -> Floats:
        """Its values at these values of its driver."""
        return self.mimic.multiplier * driver + self.mimic.offset


@dataclass(frozen=True)
class Slot:
    """A coordinate of the typed model that is the value of one joint of the robot.

    Attributes:
        reading: the joint.
        column: place in the typed configuration.
        row: place of its rate in the typed velocity.
        derived: whether it only repeats what another joint of the typed model says.
    """

    reading: JointReading
    column: int
    row: int
    derived: bool


@dataclass(frozen=True)
class Source:
    """A joint value read off a typed configuration: scale · typed[column] + shift."""

    column: int
    scale: float = 1.0
    shift: float = 0.0

    def of(self, typed: Floats) -> Floats:
        """The values at typed configurations, shape (..., nq) → (...)."""
        return np.asarray(self.scale * typed[..., self.column] + self.shift)

    def driver_of(self, mimic: Mimic) -> Source:
        """The driver's value, where this one is its follower's."""
        return Source(self.column, self.scale / mimic.multiplier, (self.shift - mimic.offset) / mimic.multiplier)

    def follower_of(self, mimic: Mimic) -> Source:
        """The follower's value, where this one is its driver's."""
        return Source(self.column, self.scale * mimic.multiplier, self.shift * mimic.multiplier + mimic.offset)


@dataclass(frozen=True)
class Repetition:
    """What a typed configuration says of a joint whose value it has already, in a ball or as a follower's driver.

    Attributes:
        reading: the joint.
        source: where it says so.
        carrier: whether the joint only carries links between the axes of a merged joint; what it says is then no more
            than a hint.
    """

    reading: JointReading
    source: Source
    carrier: bool


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
    readings: tuple[JointReading, JointReading, JointReading]
    axes: Floats
    column: int
    row: int

    def quaternions(self, typed: Floats) -> Floats:
        """The quaternions (x, y, z, w) of typed configurations, shape (..., nq) → (..., 4)."""
        return typed[..., self.column : self.column + 4]


class Quaternions:
    """Where the quaternions (x, y, z, w) of a typed configuration stand."""

    def __init__(self, nq: int, starts: Mapping[str, int]) -> None:
        """Args: number of coordinates, and name of the joint (or "base") → column where its quaternion begins."""
        self._nq, self._names = nq, tuple(starts)
        self._columns = np.array(list(starts.values()), dtype=np.intp)[:, None] + np.arange(4)

    def checked(self, q_typed: ArrayLike) -> Floats:
        """`q_typed` with quaternions of norm 1 to rounding; a copy wherever there are any.

        Raises:
            BadArgument: a quaternion whose norm is not 1 to 1e-6, with its joint and its place in the batch.
            WrongShape, NotFinite: no typed configuration.
        """
        typed = as_floats(q_typed, (self._nq,), "q_typed")
        if not self._names:
            return typed
        parts = typed[..., self._columns]
        with np.errstate(over="ignore"):
            norms = np.sqrt(np.sum(parts * parts, axis=-1))
        wrong = ~(np.abs(norms - 1.0) <= UNIT_TOLERANCE)
        if wrong.any():
            place = tuple(int(i) for i in np.argwhere(wrong)[0])
            name, norm = self._names[place[-1]], f"{norms[place]:.8g}{at_index(place[:-1])}"
            raise BadArgument(f"{name} must be a unit quaternion (x, y, z, w), got one of norm {norm}")
        unit = np.array(typed)
        # What is left of the norm would end up in the rotation matrices, squared.
        unit[..., self._columns] = parts / norms[..., None]
        return unit
