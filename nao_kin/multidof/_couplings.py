"""Joints that share a motor: where a typed configuration says what of each, and where it puts them at odds."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from nao_kin._common.arrays import Floats
from nao_kin.multidof._ball_angles import wrapped
from nao_kin.multidof._coordinates import Ball, JointReading, Repetition, Slot, Source


@dataclass(eq=False)
class Motor:
    """A joint with a coordinate of its own and all that follow it, by where a typed configuration has their values.

    Attributes:
        driver: the joint.
        ball: index of the ball that it is part of; −1 for none.
        place: which of that ball's three angles it is.
        stated: where its value is written when it is in no ball.
        in_balls: followers inside balls, each with the index of the ball and its place there.
        written: followers whose values are written.
        hints: what carriers and followers say of the driver's value.
    """

    driver: JointReading
    ball: int = -1
    place: int = 0
    stated: Source | None = None
    in_balls: list[tuple[JointReading, int, int]] = field(default_factory=list)
    written: list[tuple[JointReading, Source]] = field(default_factory=list)
    hints: list[Source] = field(default_factory=list)

    @property
    def followers(self) -> list[JointReading]:
        """All joints that follow."""
        return [reading for reading, *_ in self.in_balls] + [reading for reading, _ in self.written]

    @property
    def shared(self) -> bool:
        """Whether there is a coupling to keep."""
        return bool(self.in_balls or self.written)

    @property
    def balls(self) -> set[int]:
        """The balls that it turns."""
        return {ball for _, ball, _ in self.in_balls} | ({self.ball} if self.ball >= 0 else set())

    def among(self, balls: Sequence[int]) -> Motor:
        """The same motor, with its balls as places in `balls`."""
        ball = balls.index(self.ball) if self.ball >= 0 else -1
        in_balls = [(reading, balls.index(index), place) for reading, index, place in self.in_balls]
        return replace(self, ball=ball, in_balls=in_balls)


def motors_of(balls: Sequence[Ball], slots: Iterable[Slot], repetitions: Iterable[Repetition]) -> list[Motor]:
    """The motors that turn a ball or are shared, each once."""
    motors: dict[str, Motor] = {}
    own = [slot for slot in slots if not slot.derived]
    for slot in own:
        if not slot.reading.follows:
            motors[slot.reading.name] = Motor(slot.reading, stated=Source(slot.column))
    parts = [(reading, index, place) for index, ball in enumerate(balls) for place, reading in enumerate(ball.readings)]
    for reading, index, place in parts:
        if not reading.follows:
            motors[reading.name] = Motor(reading, index, place)
    for reading, index, place in parts:
        if reading.follows:
            motors[reading.driver].in_balls.append((reading, index, place))
    for slot in own:
        if slot.reading.follows:
            motors[slot.reading.driver].written.append((slot.reading, Source(slot.column)))
    for repetition in repetitions:
        if repetition.reading.follows and not repetition.carrier:
            motors[repetition.reading.driver].written.append((repetition.reading, repetition.source))
        else:
            motors[repetition.reading.driver].hints.append(repetition.source.driver_of(repetition.reading.mimic))
    for motor in motors.values():
        motor.hints += [source.driver_of(reading.mimic) for reading, source in motor.written]
    return [motor for motor in motors.values() if motor.balls or motor.shared]


def connected(motors: Iterable[Motor]) -> Iterator[tuple[list[int], list[Motor]]]:
    """Groups of balls that share motors, with these motors, whose balls are then counted within the group.

    Motors without balls come one by one.
    """
    groups: list[tuple[set[int], list[Motor]]] = []
    for motor in motors:
        joined = [group for group in groups if group[0] & motor.balls]
        groups = [group for group in groups if not group[0] & motor.balls]
        balls = motor.balls.union(*(group[0] for group in joined))
        groups.append((balls, [member for group in joined for member in group[1]] + [motor]))
    for balls, members in groups:
        order = sorted(balls)
        yield order, [motor.among(order) for motor in members]


def excess_of(follower: JointReading, value: Floats, driver: Floats) -> Floats:
    """How far a follower's value is above what its driver asks of it; for a revolute up to whole turns."""
    difference = value - follower.driven(driver)
    return wrapped(difference) if follower.revolute else np.asarray(difference)


@dataclass(frozen=True, eq=False)
class Mismatch:
    """How far a joint is from what the one it follows asks of it.

    Attributes:
        follower: the joint that follows.
        driver_value: value of the driver, shape (n,).
        follower_value: value of the follower, shape (n,).
        violated: where rounding does not explain the difference, shape (n,).
        nearest: value of the driver that together with all its followers is nearest to the values given, shape (n,).
    """

    follower: JointReading
    driver_value: Floats
    follower_value: Floats
    violated: NDArray[np.bool_]
    nearest: Floats


@dataclass(frozen=True)
class CouplingViolation:
    """Two joints of one motor that a typed configuration puts at values no motor position produces.

    Attributes:
        primary: the driving joint.
        mimic: the joint that follows it.
        primary_value: value of the driving joint.
        mimic_value: value of the joint that follows, by whole turns nearest to what is expected.
        expected: value the driving joint asks of it.
        nearest: value of the driving joint that, with what follows from it, is nearest to the values given.
        index: which configuration of the batch.
    """

    primary: str
    mimic: str
    primary_value: float
    mimic_value: float
    expected: float
    nearest: float
    index: tuple[int, ...] = ()


def coupling_violations(mismatches: Sequence[Mismatch], batch: tuple[int, ...]) -> tuple[CouplingViolation, ...]:
    """The rows of what was found for the flattened batch, by configuration."""
    rows = []
    for mismatch in mismatches:
        follower = mismatch.follower
        for i in np.flatnonzero(mismatch.violated):
            value = mismatch.driver_value[i]
            rows.append(
                CouplingViolation(
                    primary=follower.driver,
                    mimic=follower.name,
                    primary_value=float(value),
                    mimic_value=float(mismatch.follower_value[i]),
                    expected=float(follower.driven(value)),
                    nearest=float(mismatch.nearest[i]),
                    index=tuple(int(k) for k in np.unravel_index(int(i), batch)) if batch else (),
                )
            )
    return tuple(sorted(rows, key=lambda row: row.index))
