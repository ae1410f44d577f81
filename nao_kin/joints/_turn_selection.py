"""Which angles of each ball are meant, of all that make its rotation.

A rotation belongs to two triples of angles, each angle known up to whole turns, and at lock only the sum of the outer
ones. The joints of one motor go together, so balls that share a motor are solved together:

1. Every ball gives its candidates: both triples; near a lock, where rounding leaves the outer angles open, with these
   as the reference has them, or each triple also as the hints have it.
2. For every combination of candidates, every motor is read where it is known best, by the whole turns that come first
   in this order: couplings kept; inside the limits, or near the reference; near the hints; near the middle of the
   limits.
3. The combination that comes first in the same order is taken.

Hints are the values that carriers and followers hold, whole turns included. Arrays have the batch last: shape (n,) for
a value, (3, n) for a triple.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats
from nao_kin.joints._readings import (
    TURN,
    Ball,
    JointReading,
    Mismatch,
    Motor,
    Repetition,
    Slot,
    Source,
    connected,
    inside_at_lock,
    motors_of,
    moved,
    near,
    nearest_at_lock,
    turns_of_quaternion,
    uncertainty,
    wrapped,
)
from nao_kin.robot import COUPLING_TOLERANCE, LIMIT_TOLERANCE

# A value better known than this needs no second source.
_SURE = 1e-13
# No limit of a turn is larger than this, and no hint is taken for more [rad].
_UNLIMITED = 1e3
# Whole turns tried to either side where couplings decide, or limits allow as many.
_TURNS = 16


@dataclass(frozen=True)
class _Range:
    """Limits of a joint, infinite where there are none, and what counts as the middle between them."""

    lower: float
    upper: float
    middle: float

    @classmethod
    def of(cls, reading: JointReading) -> _Range:
        lower = reading.lower if abs(reading.lower) <= _UNLIMITED else -math.inf
        upper = reading.upper if abs(reading.upper) <= _UNLIMITED else math.inf
        if math.isinf(lower) and math.isinf(upper):
            return cls(lower, upper, 0.0)
        if math.isinf(lower) or math.isinf(upper):
            return cls(lower, upper, upper - math.pi if math.isinf(lower) else lower + math.pi)
        return cls(lower, upper, 0.5 * (lower + upper))

    @property
    def holds_turns(self) -> bool:
        """Whether some angle is inside the limits by more than one count of whole turns."""
        return self.upper - self.lower >= TURN - 2.0 * LIMIT_TOLERANCE

    def outside(self, values: Floats) -> Floats:
        """How far values are outside the limits, zero inside."""
        over = np.maximum(self.lower - values, values - self.upper) - LIMIT_TOLERANCE
        return np.asarray(np.maximum(over, 0.0))


@dataclass(frozen=True, eq=False)
class _Given:
    """What `choose` is given: typed configurations (n, nq), and configurations of the robot to be near to."""

    typed: Floats
    reference: Floats | None

    def hint(self, source: Source) -> Floats:
        """The value at a source, shape (n,); nobody may have set it, so it is bounded."""
        return np.clip(source.of(self.typed), -_UNLIMITED, _UNLIMITED)

    def target(self, reading: JointReading, middle: float) -> Floats:
        """The reference's value of a joint, or the middle of its limits, shape (n,)."""
        return np.full(len(self.typed), middle) if self.reference is None else reading.of(self.reference)


@dataclass(frozen=True, eq=False)
class _Triple:
    """A candidate for a ball: its angles, shape (3, n), and how uncertain the outer two are, shape (n,)."""

    angles: Floats
    doubt: Floats


@dataclass(eq=False)
class _Assignment:
    """A candidate for every ball of a group.

    Attributes:
        angles: shape (balls, 3, n).
        doubts: uncertainty of the outer angles, shape (balls, n).
        costs: what decides between assignments, the most important first: couplings broken; squared distances from the
            limits or the reference, from the hints, and from the middle of the limits; shape (4, n).
    """

    angles: Floats
    doubts: Floats
    costs: Floats

    def value(self, ball: int, place: int) -> Floats:
        return np.asarray(self.angles[ball, place])

    def doubt(self, ball: int, place: int) -> Floats:
        return np.asarray(self.doubts[ball]) if place != 1 else np.zeros(1)

    def take_better(self, other: _Assignment) -> None:
        """Row by row the one whose costs come first; of equals, what is here stays."""
        better = _first(np.stack([self.costs, other.costs], axis=1)) == 1
        if better.any():
            self.angles = np.where(better, other.angles, self.angles)
            self.doubts = np.where(better, other.doubts, self.doubts)
            self.costs = np.where(better, other.costs, self.costs)


@dataclass(frozen=True, eq=False)
class _Group:
    """Balls that share motors, and all motors that turn them; or one shared motor without balls."""

    balls: Sequence[Ball]
    motors: Sequence[Motor]


class TurnSelection:
    """Chooses the angles of all balls for n typed configurations at once."""

    def __init__(self, balls: Sequence[Ball], slots: Iterable[Slot], repetitions: Iterable[Repetition]) -> None:
        motors = motors_of(balls, slots, repetitions)
        self._groups = [_Group([balls[index] for index in indices], members) for indices, members in connected(motors)]
        self._drivers = {motor.driver.name: motor for motor in motors}

    def choose(self, typed: Floats, reference: Floats | None) -> tuple[dict[str, Floats], list[Mismatch]]:
        """Values of the joints that have a coordinate of their own inside balls, and what the couplings miss.

        Args:
            typed: typed configurations, shape (n, nq).
            reference: configurations of the robot, shape (n, robot.nq).

        Returns:
            Joint name → values, shape (n,); and a row for every joint that follows.
        """
        given = _Given(typed, reference)
        chosen: dict[str, Floats] = {}
        mismatches: list[Mismatch] = []
        for group in self._groups:
            best = self._best(group, given)
            for motor in group.motors:
                if motor.ball >= 0:
                    chosen[motor.driver.name] = best.value(motor.ball, motor.place)
                mismatches += _mismatches(motor, best, given)
        return chosen, mismatches

    def _best(self, group: _Group, given: _Given) -> _Assignment:
        first, *others = itertools.product(*(self._candidates(ball, given) for ball in group.balls))
        best = _assignment(group, first, given)
        for triples in others:
            best.take_better(_assignment(group, triples, given))
        return best

    def _candidates(self, ball: Ball, given: _Given) -> list[_Triple]:
        """Both triples; where rounding or a lock leaves the outer angles open, each also as the hints have them."""
        found = turns_of_quaternion(ball, ball.quaternions(given.typed))
        ranges = [_Range.of(reading) for reading in ball.readings]
        target = np.stack([given.target(*pair) for pair in zip(ball.readings, (r.middle for r in ranges), strict=True)])
        candidates = []
        for branch in (found.angles, found.other):
            angles = branch.T
            if found.locked.any():
                freed = nearest_at_lock(ball, angles, target)
                if given.reference is None:
                    lower, upper = np.transpose([(r.lower, r.upper) for r in ranges])
                    freed = inside_at_lock(ball, freed, lower, upper)
                angles = np.where(found.locked, freed, angles)
            triple = _Triple(angles, uncertainty(ball, angles[1], found.locked))
            if given.reference is not None:
                triple = _brought_near(ball, triple, 0, target[0])
            candidates.append(triple)
            if (triple.doubt > _SURE).any() and (given.reference is None or found.locked.any()):
                candidates += self._hinted(ball, triple, given)
        return candidates

    def _hinted(self, ball: Ball, triple: _Triple, given: _Given) -> list[_Triple]:
        """The triple with an outer angle as it is hinted, where rounding explains the difference."""
        for place in (0, 2):
            hints = self._hints(ball.readings[place])
            if hints:
                return [_brought_near(ball, triple, place, given.hint(hints[0]))]
        return []

    def _hints(self, reading: JointReading) -> list[Source]:
        motor = self._drivers[reading.driver]
        sources = [motor.stated] if motor.stated is not None else motor.hints
        return [source.follower_of(reading.mimic) for source in sources]


def _brought_near(ball: Ball, triple: _Triple, place: int, target: Floats) -> _Triple:
    """The triple with an outer angle at the target, up to whole turns, where it is no better known than that."""
    by = wrapped(target - triple.angles[place])
    explained = (triple.doubt > _SURE) & (np.abs(by) <= triple.doubt)
    if not explained.any():
        return triple
    return _Triple(moved(ball, triple.angles, place, np.where(explained, by, 0.0)), triple.doubt)


def _assignment(group: _Group, triples: Sequence[_Triple], given: _Given) -> _Assignment:
    """One combination of candidates with every motor read where it is known best, and its costs."""
    n, size = len(given.typed), len(group.balls)
    found = _Assignment(np.zeros((size, 3, n)), np.zeros((size, n)), np.zeros((4, n)))
    for index, triple in enumerate(triples):
        found.angles[index], found.doubts[index] = triple.angles, triple.doubt
    shared = [motor for motor in group.motors if motor.shared]
    # At a lock one motor may have to wait for what another one adds to the ball.
    for _ in shared if np.any(found.doubts > _SURE) else shared[:1]:
        for motor in shared:
            _bring_together(group, motor, found, given)
    for motor in group.motors:
        if motor.ball >= 0:
            found.angles[motor.ball, motor.place], costs = _with_turns(motor, found, given)
            found.costs += costs
        elif motor.shared:
            found.costs[0] += _broken(motor, _driver_value(motor, found, given)[None], found, given)[0]
    return found


def _bring_together(group: _Group, motor: Motor, found: _Assignment, given: _Given) -> None:
    """Read a motor where it is known best, and give that value to all that it turns."""
    if motor.ball >= 0:
        found.angles[motor.ball, motor.place], _ = _with_turns(motor, found, given)
        _take_from_followers(group, motor, found, given)
    value, doubt = _driver_value(motor, found, given), _driver_doubt(motor, found)
    for follower, index, place in motor.in_balls:
        off = follower.excess(found.value(index, place), value)
        mine = found.doubt(index, place)
        asked = abs(follower.mimic.multiplier) * doubt
        agreed = np.abs(off) <= COUPLING_TOLERANCE + asked + mine
        _move(group, found, index, place, np.where(agreed, -off, 0.0))
        if place != 1:
            found.doubts[index] = np.where(agreed, np.minimum(mine, asked), mine)


def _take_from_followers(group: _Group, motor: Motor, found: _Assignment, given: _Given) -> None:
    """Where a lock leaves the driver open, move it to where a follower knows better."""
    if motor.place == 1 or not np.any(found.doubts[motor.ball] > _SURE):
        return
    value, doubt = found.value(motor.ball, motor.place), found.doubt(motor.ball, motor.place)
    by = np.zeros_like(value)
    sources = [(each, found.value(*at), found.doubt(*at)) for each, *at in motor.in_balls]
    sources += [(each, source.of(given.typed), np.zeros(1)) for each, source in motor.written]
    for follower, stated, uncertain in sources:
        scale = follower.mimic.multiplier
        off, other = follower.excess(stated, value) / scale, uncertain / abs(scale)
        better = (doubt > _SURE) & (other < doubt) & (np.abs(off) <= COUPLING_TOLERANCE + doubt + other)
        by, doubt = np.where(better, off, by), np.where(better, other, doubt)
    _move(group, found, motor.ball, motor.place, by)
    found.doubts[motor.ball] = doubt


def _move(group: _Group, found: _Assignment, index: int, place: int, by: Floats) -> None:
    if by.any():
        found.angles[index] = moved(group.balls[index], found.angles[index], place, by)


def _driver_value(motor: Motor, found: _Assignment, given: _Given) -> Floats:
    return found.value(motor.ball, motor.place) if motor.stated is None else motor.stated.of(given.typed)


def _driver_doubt(motor: Motor, found: _Assignment) -> Floats:
    return found.doubt(motor.ball, motor.place) if motor.stated is None else np.zeros(1)


def _with_turns(motor: Motor, found: _Assignment, given: _Given) -> tuple[Floats, Floats]:
    """The driver's angle by the whole turns that come first, shape (n,), and its costs, shape (4, n)."""
    limits = _Range.of(motor.driver)
    target = given.target(motor.driver, limits.middle)
    hints = [given.hint(source) for source in motor.hints]
    candidates = _turns(motor, limits, found.value(motor.ball, motor.place), target, hints, given)
    costs = np.empty((4, *candidates.shape))
    costs[0] = _broken(motor, candidates, found, given)
    outside = limits.outside(candidates) if given.reference is None else candidates - target
    costs[1], costs[3] = outside**2, (candidates - target) ** 2
    costs[2] = sum(((candidates - hint) ** 2 for hint in hints), np.zeros(1))
    if len(candidates) == 1:
        return candidates[0], costs[:, 0]
    first = _first(costs)
    return _picked(candidates, first), _picked(costs, first)


def _turns(
    motor: Motor, limits: _Range, angle: Floats, target: Floats, hints: Sequence[Floats], given: _Given
) -> Floats:
    """The driver's angle by all the whole turns that may be meant, shape (candidates, n)."""
    nearest = near(angle, target)
    # Whole turns of the driver that turn a follower by anything else.
    winding = any(follower.mimic.multiplier % 1.0 != 0.0 for follower in motor.followers if follower.revolute)
    winding |= any(not follower.revolute for follower in motor.followers)
    if not winding and (given.reference is not None or not (limits.holds_turns and hints)):
        return nearest[None]
    tried = [nearest, *(near(angle, hint) for hint in hints)]
    counts = _TURNS if winding else min(_TURNS, math.ceil(min(limits.upper - limits.lower, 2e3) / (2.0 * TURN)))
    tried += [nearest + sign * count * TURN for count in range(1, counts + 1) for sign in (-1.0, 1.0)]
    return np.stack(tried)


def _broken(motor: Motor, drivers: Floats, found: _Assignment, given: _Given) -> Floats:
    """How many followers disagree with the driver at values (candidates, n)."""
    count = np.zeros(drivers.shape)
    doubt = _driver_doubt(motor, found)
    for follower, value, uncertain in _follower_values(motor, found, given):
        off = np.abs(follower.excess(value, drivers))
        count += off > COUPLING_TOLERANCE + abs(follower.mimic.multiplier) * doubt + uncertain
    return count


def _follower_values(motor: Motor, found: _Assignment, given: _Given) -> list[tuple[JointReading, Floats, Floats]]:
    """Every follower with its value and how uncertain that is, shape (n,)."""
    values = [(follower, found.value(*at), found.doubt(*at)) for follower, *at in motor.in_balls]
    return values + [(follower, source.of(given.typed), np.zeros(1)) for follower, source in motor.written]


def _mismatches(motor: Motor, found: _Assignment, given: _Given) -> list[Mismatch]:
    """A row for each follower of a motor."""
    value, doubt = _driver_value(motor, found, given), _driver_doubt(motor, found)
    rows = [
        (
            follower,
            follower.excess(stated, value),
            COUPLING_TOLERANCE + abs(follower.mimic.multiplier) * doubt + own,
        )
        for follower, stated, own in _follower_values(motor, found, given)
    ]
    weight = 1.0 + sum(follower.mimic.multiplier**2 for follower, _, _ in rows)
    pull = sum((follower.mimic.multiplier * off for follower, off, _ in rows), np.zeros(1))
    return [
        Mismatch(follower, value, follower.driven(value) + off, np.abs(off) > allowed, value + pull / weight)
        for follower, off, allowed in rows
    ]


def _first(costs: Floats) -> NDArray[np.intp]:
    """Index of the candidate whose costs (levels, candidates, n) come first, level by level; the first of equals."""
    alive = np.ones(costs.shape[1:], dtype=np.bool_)
    for level in costs:
        least = np.where(alive, level, np.inf).min(axis=0)
        alive &= level == least
    return np.asarray(alive.argmax(axis=0))


def _picked(values: Floats, index: NDArray[np.intp]) -> Floats:
    """Row by row one of the candidates: (..., candidates, n) → (..., n)."""
    return np.asarray(values[..., index, np.arange(len(index))])
