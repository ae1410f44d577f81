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
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats
from nao_kin.joints._readings import (
    Ball,
    Mismatch,
    Slot,
    Source,
    inside_at_lock,
    moved,
    near,
    nearest_at_lock,
    turns_of_quaternion,
    uncertainty,
)
from nao_kin.joints.grouping import TURN, JointNode, wrapped
from nao_kin.robot import COUPLING_TOLERANCE, LIMIT_TOLERANCE

# A value better known than this needs no second source.
_SURE = 1e-13
# No limit of a turn is larger than this, and no hint is taken for more [rad].
_UNLIMITED = 1e3
# Whole turns tried to either side where couplings decide, or limits allow as many.
_TURNS = 16


# --- Which joints share a motor, and where a typed configuration has their values.


class Angle(NamedTuple):
    """A joint value that is one of the three angles of a ball, by the place of the ball in a list."""

    ball: int
    place: int


Place = Angle | Source
Held = Iterable[tuple[JointNode, Source]]


@dataclass(frozen=True, eq=False)
class Motor:
    """A joint with a coordinate of its own and all that follow it, by where a typed configuration has their values.

    Attributes:
        driver: the joint.
        at: where its value is.
        followers: the joints that follow it, each with the place of its value.
        hints: the values that carriers and followers give the driver.
    """

    driver: JointNode
    at: Place
    followers: list[tuple[JointNode, Place]] = field(default_factory=list)
    hints: list[Source] = field(default_factory=list)

    @property
    def balls(self) -> set[int]:
        """The balls that it turns."""
        return {at.ball for at in (self.at, *(at for _, at in self.followers)) if isinstance(at, Angle)}

    def among(self, balls: Sequence[int]) -> Motor:
        """The same motor, with its balls as places in `balls`."""

        def here(at: Place) -> Place:
            return Angle(balls.index(at.ball), at.place) if isinstance(at, Angle) else at

        return replace(self, at=here(self.at), followers=[(joint, here(at)) for joint, at in self.followers])


def motors_of(balls: Sequence[Ball], slots: Iterable[Slot], followers: Held, hints: Held) -> list[Motor]:
    """The motors that turn a ball or are shared, each once; arguments as `Assembly` has them."""
    written: list[tuple[JointNode, Place]] = [(slot.joint, Source(slot.column)) for slot in slots if not slot.derived]
    in_balls: list[tuple[JointNode, Place]] = [
        (joint, Angle(index, place)) for index, ball in enumerate(balls) for place, joint in enumerate(ball.joints)
    ]
    motors = {joint.name: Motor(joint, at) for joint, at in written + in_balls if not joint.follows}
    for joint, at in (*in_balls, *written, *followers):
        if joint.follows:
            motors[joint.driver].followers.append((joint, at))
    for joint, source in hints:
        motors[joint.driver].hints.append(source.driver_of(joint.coupling))
    for motor in motors.values():
        motor.hints.extend(at.driver_of(joint.coupling) for joint, at in motor.followers if isinstance(at, Source))
    return [motor for motor in motors.values() if motor.balls or motor.followers]


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


# --- The whole turns and triples that come first.


@dataclass(frozen=True)
class _Range:
    """Limits of a joint, infinite where there are none, and what counts as the middle between them."""

    lower: float
    upper: float
    middle: float

    @classmethod
    def of(cls, joint: JointNode) -> _Range:
        lower = joint.lower if abs(joint.lower) <= _UNLIMITED else -math.inf
        upper = joint.upper if abs(joint.upper) <= _UNLIMITED else math.inf
        if math.isinf(lower) and math.isinf(upper):
            return cls(lower, upper, 0.0)
        if math.isinf(lower) or math.isinf(upper):
            return cls(lower, upper, upper - math.pi if math.isinf(lower) else lower + math.pi)
        return cls(lower, upper, 0.5 * (lower + upper))

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

    def target(self, joint: JointNode, middle: float) -> Floats:
        """The reference's value of a joint, or the middle of its limits, shape (n,)."""
        return np.full(len(self.typed), middle) if self.reference is None else joint.of(self.reference)


class _Triple(NamedTuple):
    """A candidate for a ball: its angles, shape (3, n), and how uncertain the outer two are, shape (n,)."""

    angles: Floats
    doubt: Floats


class TurnSelection:
    """Chooses the angles of all balls for n typed configurations at once."""

    def __init__(self, balls: Sequence[Ball], slots: Iterable[Slot], followers: Held, hints: Held) -> None:
        motors = motors_of(balls, slots, followers, hints)
        # Balls that share motors, with all motors that turn them; or one shared motor without balls.
        self._groups = [([balls[index] for index in indices], members) for indices, members in connected(motors)]
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
        for balls, motors in self._groups:
            candidates = itertools.product(*(self._candidates(ball, given) for ball in balls))
            found = (_assignment(balls, motors, triples, given) for triples in candidates)
            best = next(found)
            for other in found:
                best.take_better(other)
            for motor in motors:
                if isinstance(motor.at, Angle):
                    chosen[motor.driver.name] = best.angles[motor.at]
                mismatches += best.mismatches(motor)
        return chosen, mismatches

    def _candidates(self, ball: Ball, given: _Given) -> list[_Triple]:
        """Both triples; where rounding or a lock leaves the outer angles open, each also as the hints have them."""
        found = turns_of_quaternion(ball, ball.quaternions(given.typed))
        ranges = [_Range.of(joint) for joint in ball.joints]
        target = np.stack([given.target(*pair) for pair in zip(ball.joints, (r.middle for r in ranges), strict=True)])
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
                hints = [(place, hint) for place in (0, 2) for hint in self._hints(ball.joints[place])]
                candidates += [_brought_near(ball, triple, place, given.hint(hint)) for place, hint in hints[:1]]
        return candidates

    def _hints(self, joint: JointNode) -> list[Source]:
        motor = self._drivers[joint.driver]
        sources = [motor.at] if isinstance(motor.at, Source) else motor.hints
        return [source.follower_of(joint.coupling) for source in sources]


def _brought_near(ball: Ball, triple: _Triple, place: int, target: Floats) -> _Triple:
    """The triple with an outer angle at the target, up to whole turns, where it is no better known than that."""
    by = wrapped(target - triple.angles[place])
    explained = (triple.doubt > _SURE) & (np.abs(by) <= triple.doubt)
    if not explained.any():
        return triple
    return _Triple(moved(ball, triple.angles, place, np.where(explained, by, 0.0)), triple.doubt)


def _assignment(
    balls: Sequence[Ball], motors: Sequence[Motor], triples: Sequence[_Triple], given: _Given
) -> _Assignment:
    """One combination of candidates with every motor read where it is known best, and its costs."""
    n, size = len(given.typed), len(balls)
    found = _Assignment(given, balls, np.zeros((size, 3, n)), np.zeros((size, n)), np.zeros((4, n)))
    for index, triple in enumerate(triples):
        found.angles[index], found.doubts[index] = triple
    shared = [motor for motor in motors if motor.followers]
    # At a lock one motor may have to wait for what another one adds to the ball.
    for _ in shared if np.any(found.doubts > _SURE) else shared[:1]:
        for motor in shared:
            found.bring_together(motor)
    for motor in motors:
        if isinstance(motor.at, Angle):
            found.costs += found.turn(motor, motor.at)
        elif motor.followers:
            found.costs[0] += found.broken(motor, found.read(motor.at)[0][None])[0]
    return found


@dataclass(eq=False)
class _Assignment:
    """A candidate for every ball of a group.

    Attributes:
        given: what the angles are chosen for.
        balls: the balls of the group.
        angles: shape (balls, 3, n).
        doubts: uncertainty of the outer angles, shape (balls, n).
        costs: what decides between assignments, the most important first: couplings broken; squared distances from the
            limits or the reference, from the hints, and from the middle of the limits; shape (4, n).
    """

    given: _Given
    balls: Sequence[Ball]
    angles: Floats
    doubts: Floats
    costs: Floats

    def read(self, at: Place) -> tuple[Floats, Floats]:
        """The value at a place, and how uncertain it is; shape (n,), or (1,) where it is certain."""
        if isinstance(at, Source):
            return at.of(self.given.typed), np.zeros(1)
        return self.angles[at], self.doubts[at.ball] if at.place != 1 else np.zeros(1)

    def take_better(self, other: _Assignment) -> None:
        """Row by row the one whose costs come first; of equals, what is here stays."""
        better = _first(np.stack([self.costs, other.costs], axis=1)) == 1
        if better.any():
            self.angles = np.where(better, other.angles, self.angles)
            self.doubts = np.where(better, other.doubts, self.doubts)
            self.costs = np.where(better, other.costs, self.costs)

    def bring_together(self, motor: Motor) -> None:
        """Read a motor where it is known best, and give that value to all that it turns."""
        if isinstance(motor.at, Angle):
            self.turn(motor, motor.at)
            self._take_from_followers(motor, motor.at)
        value, doubt = self.read(motor.at)
        for follower, at in motor.followers:
            if isinstance(at, Source):
                continue
            stated, mine = self.read(at)
            off = follower.excess(stated, value)
            asked = abs(follower.coupling.multiplier) * doubt
            agreed = np.abs(off) <= COUPLING_TOLERANCE + asked + mine
            self._move(at, np.where(agreed, -off, 0.0))
            if at.place != 1:
                self.doubts[at.ball] = np.where(agreed, np.minimum(mine, asked), mine)

    def _take_from_followers(self, motor: Motor, at: Angle) -> None:
        """Where a lock leaves the driver open, move it to where a follower knows better."""
        value, doubt = self.read(at)
        if not np.any(doubt > _SURE):
            return
        by = np.zeros_like(value)
        for follower, place in motor.followers:
            scale = follower.coupling.multiplier
            stated, uncertain = self.read(place)
            off, other = follower.excess(stated, value) / scale, uncertain / abs(scale)
            better = (doubt > _SURE) & (other < doubt) & (np.abs(off) <= COUPLING_TOLERANCE + doubt + other)
            by, doubt = np.where(better, off, by), np.where(better, other, doubt)
        self._move(at, by)
        self.doubts[at.ball] = doubt

    def _move(self, at: Angle, by: Floats) -> None:
        if by.any():
            self.angles[at.ball] = moved(self.balls[at.ball], self.angles[at.ball], at.place, by)

    def turn(self, motor: Motor, at: Angle) -> Floats:
        """Take the driver's angle by the whole turns that come first; its costs, shape (4, n)."""
        limits, given = _Range.of(motor.driver), self.given
        target = given.target(motor.driver, limits.middle)
        hints = [given.hint(source) for source in motor.hints]
        candidates = _turns(motor, limits, self.angles[at], target, hints, given)
        costs = np.empty((4, *candidates.shape))
        costs[0] = self.broken(motor, candidates)
        outside = limits.outside(candidates) if given.reference is None else candidates - target
        costs[1], costs[3] = outside**2, (candidates - target) ** 2
        costs[2] = sum(((candidates - hint) ** 2 for hint in hints), np.zeros(1))
        first, column = _first(costs), np.arange(len(target))
        self.angles[at] = candidates[first, column]
        return np.asarray(costs[:, first, column])

    def broken(self, motor: Motor, drivers: Floats) -> Floats:
        """How many followers disagree with the driver at values (candidates, n)."""
        count = np.zeros(drivers.shape)
        for _, off, allowed in self._excesses(motor, drivers):
            count += np.abs(off) > allowed
        return count

    def mismatches(self, motor: Motor) -> list[Mismatch]:
        """A row for each follower of a motor."""
        value, _ = self.read(motor.at)
        rows, ratios = self._excesses(motor, value), [joint.coupling.multiplier for joint, _ in motor.followers]
        pull = sum((ratio * off for ratio, (_, off, _) in zip(ratios, rows, strict=True)), np.zeros(1))
        nearest = value + pull / (1.0 + sum(ratio**2 for ratio in ratios))
        return [
            Mismatch(joint, value, joint.coupling.value(value) + off, np.abs(off) > allowed, nearest)
            for joint, off, allowed in rows
        ]

    def _excesses(self, motor: Motor, drivers: Floats) -> list[tuple[JointNode, Floats, Floats]]:
        """Every follower with how far it is above what these values of the driver ask, and how far it may be."""
        _, doubt = self.read(motor.at)
        found = []
        for follower, at in motor.followers:
            value, own = self.read(at)
            allowed = COUPLING_TOLERANCE + abs(follower.coupling.multiplier) * doubt + own
            found.append((follower, follower.excess(value, drivers), allowed))
        return found


def _turns(
    motor: Motor, limits: _Range, angle: Floats, target: Floats, hints: Sequence[Floats], given: _Given
) -> Floats:
    """The driver's angle by all the whole turns that may be meant, shape (candidates, n)."""
    nearest = near(angle, target)
    # Whole turns of the driver that turn a follower by anything else.
    winding = any(joint.kind != "revolute" or joint.coupling.multiplier % 1.0 != 0.0 for joint, _ in motor.followers)
    # Whether some angle is inside the limits by more than one count of whole turns.
    several = limits.upper - limits.lower >= TURN - 2.0 * LIMIT_TOLERANCE
    if not winding and (given.reference is not None or not (several and hints)):
        return nearest[None]
    tried = [nearest, *(near(angle, hint) for hint in hints)]
    counts = _TURNS if winding else min(_TURNS, math.ceil(min(limits.upper - limits.lower, 2e3) / (2.0 * TURN)))
    tried += [nearest + sign * count * TURN for count in range(1, counts + 1) for sign in (-1.0, 1.0)]
    return np.stack(tried)


def _first(costs: Floats) -> NDArray[np.intp]:
    """Index of the candidate whose costs (levels, candidates, n) come first, level by level; the first of equals."""
    alive = np.ones(costs.shape[1:], dtype=np.bool_)
    for level in costs:
        least = np.where(alive, level, np.inf).min(axis=0)
        alive &= level == least
    return np.asarray(alive.argmax(axis=0))
