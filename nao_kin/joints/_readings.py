"""The values of the robot's joints in a typed configuration, and which of the angles that give a rotation they are."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import COUPLING_TOLERANCE, LIMIT_TOLERANCE, Floats
from nao_kin.joints.grouping import TURN, JointNode, wrapped
from nao_kin.robot.semantics import Mimic
from nao_kin.rotations import (
    EulerAngles,
    davenport_angles,
    matrix_from_quat,
    quat_from_xyzw,
    quat_multiply,
    quat_to_xyzw,
)


@dataclass(frozen=True)
class Slot:
    """A coordinate of the typed model that is the value of one joint of the robot."""

    joint: JointNode
    index: int  # of the joint of the typed model
    column: int  # index in the typed configuration
    row: int  # index of its rate in the typed velocity
    derived: bool  # whether it only repeats the value of another joint of the typed model


@dataclass(frozen=True)
class Reading:
    """A joint value as a linear function of one coordinate: scale · typed[column] + shift."""

    column: int
    scale: float = 1.0
    shift: float = 0.0

    def of(self, typed: Floats) -> Floats:
        """Return the values at typed configurations, shape (..., nq) → (...)."""
        return np.asarray(self.scale * typed[..., self.column] + self.shift)

    def driver_of(self, mimic: Mimic) -> Reading:
        """Return the value of the driver whose follower has this value."""
        return Reading(self.column, self.scale / mimic.multiplier, (self.shift - mimic.offset) / mimic.multiplier)

    def follower_of(self, mimic: Mimic) -> Reading:
        """Return the value of the follower whose driver has this value."""
        return Reading(self.column, self.scale * mimic.multiplier, self.shift * mimic.multiplier + mimic.offset)


@dataclass(frozen=True, eq=False)
class Ball:
    """A spherical joint of the typed model."""

    name: str
    joints: tuple[JointNode, JointNode, JointNode]  # the joints that it replaces
    axes: Floats  # in its frame with all joints at zero, one per row, shape (3, 3)
    column: int  # where its quaternion (x, y, z, w) begins in the typed configuration
    row: int  # where its angular velocity begins in the typed velocity

    def quaternions(self, typed: Floats) -> Floats:
        """Return the quaternions (x, y, z, w) of typed configurations, shape (..., nq) → (..., 4)."""
        return typed[..., self.column : self.column + 4]

    def angles(self, q: Floats) -> Floats:
        """Return the three angles at configurations of the robot, shape (..., robot.nq) → (..., 3)."""
        return np.stack([joint.of(q) for joint in self.joints], axis=-1)


@dataclass(frozen=True, eq=False)
class Mismatch:
    """The difference between a follower and the value that its driver requires, at n configurations."""

    follower: JointNode
    driver_value: Floats  # shape (n,), as the other arrays
    follower_value: Floats
    violated: NDArray[np.bool_]  # where rounding does not explain the difference
    nearest: Floats  # the driver's value that is nearest to the given values of the driver and all its followers


@dataclass(frozen=True)
class CouplingViolation:
    """A typed configuration in which two joints of one motor have values that no motor position produces.

    Attributes:
        primary: the driving joint.
        mimic: the joint that follows it.
        primary_value: value of the driving joint.
        mimic_value: value of the follower, moved by whole turns to be nearest to the expected value.
        expected: value of the follower that the driving joint requires.
        nearest: value of the driving joint that is nearest to the given values of this joint and all its followers.
        index: index of the configuration in the batch.
    """

    primary: str
    mimic: str
    primary_value: float
    mimic_value: float
    expected: float
    nearest: float
    index: tuple[int, ...] = ()


def coupling_violations(mismatches: Sequence[Mismatch], batch: tuple[int, ...]) -> tuple[CouplingViolation, ...]:
    """Return the violations of a flattened batch, in the order of its configurations."""
    rows = [
        CouplingViolation(
            primary=mismatch.follower.coupling.joint,
            mimic=mismatch.follower.name,
            primary_value=float(mismatch.driver_value[i]),
            mimic_value=float(mismatch.follower_value[i]),
            expected=float(mismatch.follower.coupling.value(mismatch.driver_value[i])),
            nearest=float(mismatch.nearest[i]),
            index=tuple(map(int, np.unravel_index(i, batch))) if batch else (),
        )
        for mismatch in mismatches
        for i in np.flatnonzero(mismatch.violated)
    ]
    return tuple(sorted(rows, key=lambda row: row.index))


# --- Spherical joints: quaternions from three angles, angles from quaternions, and the choice of angles at lock.

# Error of an angle far from lock that results from rounding the quaternion and the matrix made from it [rad].
_ROUNDING = 32.0 * float(np.finfo(np.float64).eps)


def quaternion_of_turns(ball: Ball, angles: Floats) -> Floats:
    """Return the quaternion (x, y, z, w) of three turns, continuous in the angles; (..., 3) → (..., 4)."""
    half = 0.5 * angles[..., None]
    turns = np.concatenate([np.cos(half), np.sin(half) * ball.axes], axis=-1)
    return quat_to_xyzw(quat_multiply(quat_multiply(turns[..., 0, :], turns[..., 1, :]), turns[..., 2, :]))


def turns_of_quaternion(ball: Ball, xyzw: Floats) -> EulerAngles:
    """Return both triples of angles of unit quaternions (x, y, z, w), shape (..., 4)."""
    return davenport_angles(matrix_from_quat(quat_from_xyzw(xyzw)), *ball.axes)


def angular_velocity_axes(ball: Ball, angles: Floats) -> Floats:
    """Return the matrix (..., 3, 3) from three joint rates to the angular velocity in the moved frame.

    Its columns are Rot(a3, −γ) Rot(a2, −β) a1, Rot(a3, −γ) a2 and a3.
    """
    first, second, third = (np.broadcast_to(axis, (*angles.shape[:-1], 3)) for axis in ball.axes)
    first = _turned(_turned(first, ball.axes[1], -angles[..., 1]), ball.axes[2], -angles[..., 2])
    second = _turned(second, ball.axes[2], -angles[..., 2])
    return np.stack([first, second, third], axis=-1)


def outer_axes_angle(ball: Ball, middle: Floats) -> tuple[Floats, Floats]:
    """Return cosine and sine of the angle between the outer axes at these values of the middle angle."""
    first, second, third = ball.axes
    theta = middle + math.atan2(float(second @ np.cross(first, third)), float(first @ third))
    return np.cos(theta), np.sin(theta)


def outer_uncertainty(ball: Ball, middle: Floats, locked: NDArray[np.bool_]) -> Floats:
    """Return how far rounding may move the outer angles [rad]; at lock only their sum or difference is determined."""
    _, sine = outer_axes_angle(ball, middle)
    with np.errstate(divide="ignore"):
        return np.where(locked, math.pi, np.minimum(_ROUNDING / np.abs(sine), math.pi))


def nearest_turn(angles: Floats, target: Floats) -> Floats:
    """Return the angles, moved by whole turns to within half a turn of the target."""
    return np.asarray(target + wrapped(angles - target))


def move_angle(ball: Ball, angles: Floats, place: int, by: Floats) -> Floats:
    """Return the triples (3, n) with one angle moved; if it is an outer angle, the other one moves to compensate.

    Close to lock the two outer axes nearly coincide, and a turn about one nearly cancels a turn about the other.
    """
    result = np.array(angles)
    result[place] += by
    if place != 1:
        result[2 - place] -= by * outer_axes_angle(ball, angles[1])[0]
    return result


def nearest_at_lock(ball: Ball, angles: Floats, target: Floats) -> Floats:
    """Return the triples (3, n) nearest to the target among all triples that give the same rotations at lock."""
    sign = np.sign(outer_axes_angle(ball, angles[1])[0])
    spare = wrapped(angles[0] + sign * angles[2] - target[0] - sign * target[2]) / 2.0
    return np.stack([target[0] + spare, angles[1], target[2] + sign * spare])


def inside_at_lock(ball: Ball, angles: Floats, lower: Floats, upper: Floats) -> Floats:
    """Return triples (3, n) at lock, moved into the limits of the outer angles or as near to them as possible."""
    sign = np.sign(outer_axes_angle(ball, angles[1])[0])
    # The values of the first angle for the third at either end of its range; their sum or difference does not change.
    ends = np.sort([angles[0] + sign * (angles[2] - end) for end in (lower[2], upper[2])], axis=0)
    low, high = np.maximum(lower[0], ends[0]), np.minimum(upper[0], ends[1])
    with np.errstate(invalid="ignore"):  # without limits, ∞ − ∞ is computed but not used
        first = np.where(low <= high, np.clip(angles[0], low, high), 0.5 * (low + high))
    return move_angle(ball, angles, 0, first - angles[0])


def _turned(vectors: Floats, axis: Floats, angle: Floats) -> Floats:
    """Return Rot(axis, angle) v by Rodrigues' formula."""
    cosine, sine = np.cos(angle)[..., None], np.sin(angle)[..., None]
    along = np.einsum("...i,i->...", vectors, axis)[..., None]
    return np.asarray(cosine * vectors + sine * np.cross(axis, vectors) + (1.0 - cosine) * along * axis)


# --- Selection of the joint angles of each spherical joint, among all angles that give its rotation.
#
# A rotation belongs to two triples of angles, each angle up to whole turns. At lock it determines only the sum or the
# difference of the outer angles. Joints of one motor move together, so spherical joints that share a motor are solved
# together:
#
# 1. The candidates for a ball are both triples. Near a lock, rounding leaves the outer angles undetermined: they are
# chosen near the preferred values or, without these, inside the limits; a copy of each triple is chosen near the hints.
# 2. For every combination of candidates, every motor takes its value from the joint where the value is most accurate.
# The number of whole turns is the best by these criteria, the most important first: fewest violated couplings; inside
# the limits, or near the preferred values; near the hints; near the middle of the limits.
# 3. The best combination by the same criteria is used.
#
# Hints are the values of carriers and followers, whole turns included. Arrays have the batch last: shape (n,) for a
# value, (3, n) for a triple.

# A value with less uncertainty than this needs no second source [rad].
_SURE = 1e-13
# Larger limits count as no limits, and hints are clipped to this [rad].
_UNLIMITED = 1e3
# Number of whole turns that are tried in each direction, if couplings distinguish them or limits allow them.
_TURNS = 16


# --- Joints that share a motor, and where a typed configuration holds their values.


class Angle(NamedTuple):
    """A joint value that is one of the three angles of a ball: index of the ball in a list, index of the angle."""

    ball: int
    place: int


Place = Angle | Reading
Readings = Iterable[tuple[JointNode, Reading]]


@dataclass(frozen=True, eq=False)
class Motor:
    """A joint with its own coordinate, all its followers, and where a typed configuration holds their values."""

    driver: JointNode
    at: Place
    followers: list[tuple[JointNode, Place]] = field(default_factory=list)
    hints: list[Reading] = field(default_factory=list)  # values that carriers and followers imply for the driver

    @property
    def balls(self) -> set[int]:
        """The indices of the balls that the motor turns."""
        return {at.ball for at in (self.at, *(at for _, at in self.followers)) if isinstance(at, Angle)}


def motors_of(balls: Sequence[Ball], slots: Iterable[Slot], followers: Readings, hints: Readings) -> list[Motor]:
    """Return the motors that turn a ball or have followers, each once; the arguments are those of `Assembly`."""
    written: list[tuple[JointNode, Place]] = [(slot.joint, Reading(slot.column)) for slot in slots if not slot.derived]
    in_balls: list[tuple[JointNode, Place]] = [
        (joint, Angle(index, place)) for index, ball in enumerate(balls) for place, joint in enumerate(ball.joints)
    ]
    motors = {joint.name: Motor(joint, at) for joint, at in written + in_balls if joint.mimic is None}
    for joint, at in (*in_balls, *written, *followers):
        if joint.mimic is not None:
            motors[joint.mimic.joint].followers.append((joint, at))
    for joint, source in hints:
        motors[joint.coupling.joint].hints.append(source.driver_of(joint.coupling))
    for motor in motors.values():
        motor.hints.extend(at.driver_of(joint.coupling) for joint, at in motor.followers if isinstance(at, Reading))
    return [motor for motor in motors.values() if motor.balls or motor.followers]


def connected(motors: Iterable[Motor]) -> list[tuple[list[int], list[Motor]]]:
    """Return groups of balls that share motors, with these motors; a motor without balls is a group by itself."""
    groups: list[tuple[set[int], list[Motor]]] = []
    for motor in motors:
        joined = [group for group in groups if group[0] & motor.balls]
        groups = [group for group in groups if not group[0] & motor.balls]
        balls = motor.balls.union(*(group[0] for group in joined))
        groups.append((balls, [member for group in joined for member in group[1]] + [motor]))
    return [(sorted(balls), members) for balls, members in groups]


# --- The choice of whole turns and triples.


@dataclass(frozen=True)
class _TurnRange:
    """Limits of a joint, infinite without limits, and the middle between them."""

    lower: float
    upper: float
    middle: float

    @classmethod
    def of(cls, joint: JointNode) -> _TurnRange:
        lower = joint.lower if abs(joint.lower) <= _UNLIMITED else -math.inf
        upper = joint.upper if abs(joint.upper) <= _UNLIMITED else math.inf
        if math.isinf(lower) and math.isinf(upper):
            return cls(lower, upper, 0.0)
        if math.isinf(lower) or math.isinf(upper):
            return cls(lower, upper, upper - math.pi if math.isinf(lower) else lower + math.pi)
        return cls(lower, upper, 0.5 * (lower + upper))

    def outside(self, values: Floats) -> Floats:
        """Return how far values are outside the limits, zero inside."""
        over = np.maximum(self.lower - values, values - self.upper) - LIMIT_TOLERANCE
        return np.asarray(np.maximum(over, 0.0))


@dataclass(frozen=True, eq=False)
class _Input:
    """The input of `choose`: typed configurations (n, nq), and the robot's configurations to stay near to."""

    typed: Floats
    near: Floats | None

    def hint(self, source: Reading) -> Floats:
        """Return the value of a reading, shape (n,), bounded, because the caller may never have set it."""
        return np.clip(source.of(self.typed), -_UNLIMITED, _UNLIMITED)

    def target(self, joint: JointNode, middle: float) -> Floats:
        """Return the preferred value of a joint, or the middle of its limits, shape (n,)."""
        return np.full(len(self.typed), middle) if self.near is None else joint.of(self.near)


class _Triple(NamedTuple):
    """A candidate for a ball: angles, shape (3, n), and the uncertainty of the outer two, shape (n,)."""

    angles: Floats
    uncertainty: Floats


class TurnSelection:
    """The choice of the angles of all balls, for n typed configurations together."""

    def __init__(self, balls: Sequence[Ball], slots: Iterable[Slot], followers: Readings, hints: Readings) -> None:
        motors = motors_of(balls, slots, followers, hints)
        self._balls, self._groups = balls, connected(motors)
        self._drivers = {motor.driver.name: motor for motor in motors}

    def choose(self, typed: Floats, near: Floats | None) -> tuple[dict[str, Floats], list[Mismatch]]:
        """Return values (n,) of the driving joints inside balls, by name, and the mismatch of every follower."""
        query = _Input(typed, near)
        chosen: dict[str, Floats] = {}
        mismatches: list[Mismatch] = []
        for indices, motors in self._groups:
            candidates = itertools.product(*(self._candidates(self._balls[index], query) for index in indices))
            triples = (dict(zip(indices, combination, strict=True)) for combination in candidates)
            found = (_assignment(self._balls, motors, combination, query) for combination in triples)
            best = next(found)
            for other in found:
                best.take_better(other)
            for motor in motors:
                if isinstance(motor.at, Angle):
                    chosen[motor.driver.name] = best.angles[motor.at]
                mismatches += best.mismatches(motor)
        return chosen, mismatches

    def _candidates(self, ball: Ball, query: _Input) -> list[_Triple]:
        """Return both triples; if the outer angles are undetermined, also each triple chosen near the hints."""
        found = turns_of_quaternion(ball, ball.quaternions(query.typed))
        ranges = [_TurnRange.of(joint) for joint in ball.joints]
        target = np.stack([query.target(*pair) for pair in zip(ball.joints, (r.middle for r in ranges), strict=True)])
        candidates = []
        for branch in (found.angles, found.other):
            angles = branch.T
            if found.locked.any():
                freed = nearest_at_lock(ball, angles, target)
                if query.near is None:
                    lower, upper = np.transpose([(r.lower, r.upper) for r in ranges])
                    freed = inside_at_lock(ball, freed, lower, upper)
                angles = np.where(found.locked, freed, angles)
            triple = _Triple(angles, outer_uncertainty(ball, angles[1], found.locked))
            if query.near is not None:
                triple = _near_target(ball, triple, 0, target[0])
            candidates.append(triple)
            if (triple.uncertainty > _SURE).any() and (query.near is None or found.locked.any()):
                hints = [(place, hint) for place in (0, 2) for hint in self._hints(ball.joints[place])]
                candidates += [_near_target(ball, triple, place, query.hint(hint)) for place, hint in hints[:1]]
        return candidates

    def _hints(self, joint: JointNode) -> list[Reading]:
        motor = self._drivers[joint.coupling.joint]
        sources = [motor.at] if isinstance(motor.at, Reading) else motor.hints
        return [source.follower_of(joint.coupling) for source in sources]


def _near_target(ball: Ball, triple: _Triple, place: int, target: Floats) -> _Triple:
    """Return the triple with an outer angle moved to the target, up to whole turns, where its uncertainty allows it."""
    by = wrapped(target - triple.angles[place])
    explained = (triple.uncertainty > _SURE) & (np.abs(by) <= triple.uncertainty)
    if not explained.any():
        return triple
    return _Triple(move_angle(ball, triple.angles, place, np.where(explained, by, 0.0)), triple.uncertainty)


def _assignment(
    balls: Sequence[Ball], motors: Sequence[Motor], triples: Mapping[int, _Triple], query: _Input
) -> _Assignment:
    """Return one combination of candidates with its costs; every motor's value is read where it is most accurate."""
    n, size = len(query.typed), len(balls)
    found = _Assignment(query, balls, np.zeros((size, 3, n)), np.zeros((size, n)), np.zeros((4, n)))
    for index, triple in triples.items():
        found.angles[index], found.uncertainties[index] = triple
    shared = [motor for motor in motors if motor.followers]
    # Repeated, because at a lock one motor may depend on the angle of another motor of the ball.
    for _ in shared if np.any(found.uncertainties > _SURE) else shared[:1]:
        for motor in shared:
            found.reconcile(motor)
    for motor in motors:
        if isinstance(motor.at, Angle):
            found.costs += found.choose_turns(motor, motor.at)
        elif motor.followers:
            found.costs[0] += found.violated_couplings(motor, found.read(motor.at)[0][None])[0]
    return found


@dataclass(eq=False)
class _Assignment:
    """A candidate for every ball of a group, with its costs; the angles of other balls are zero.

    The costs, the most important first: number of violated couplings; squared distances from the limits or the
    preferred values, from the hints, and from the middle of the limits.
    """

    query: _Input
    balls: Sequence[Ball]
    angles: Floats  # shape (balls, 3, n)
    uncertainties: Floats  # of the outer angles, shape (balls, n)
    costs: Floats  # shape (4, n)

    def read(self, at: Place) -> tuple[Floats, Floats]:
        """Return the value at a place and its uncertainty, shape (n,), or (1,) where it is certain."""
        if isinstance(at, Reading):
            return at.of(self.query.typed), np.zeros(1)
        return self.angles[at], self.uncertainties[at.ball] if at.place != 1 else np.zeros(1)

    def take_better(self, other: _Assignment) -> None:
        """Take over the configurations in which the other assignment has the lower costs."""
        better = _first_by_costs(np.stack([self.costs, other.costs], axis=1)) == 1
        if better.any():
            self.angles = np.where(better, other.angles, self.angles)
            self.uncertainties = np.where(better, other.uncertainties, self.uncertainties)
            self.costs = np.where(better, other.costs, self.costs)

    def reconcile(self, motor: Motor) -> None:
        """Read a motor's value where it is most accurate, and set all angles that the motor turns to this value."""
        if isinstance(motor.at, Angle):
            self.choose_turns(motor, motor.at)
            self._take_from_followers(motor, motor.at)
        value, uncertainty = self.read(motor.at)
        for follower, at in motor.followers:
            if isinstance(at, Reading):
                continue
            stated, own = self.read(at)
            off = follower.excess(stated, value)
            asked = abs(follower.coupling.multiplier) * uncertainty
            agreed = np.abs(off) <= COUPLING_TOLERANCE + asked + own
            self._move(at, np.where(agreed, -off, 0.0))
            if at.place != 1:
                self.uncertainties[at.ball] = np.where(agreed, np.minimum(own, asked), own)

    def _take_from_followers(self, motor: Motor, at: Angle) -> None:
        """If a lock leaves the driver undetermined, move it to the value that a more accurate follower implies."""
        value, uncertainty = self.read(at)
        if not np.any(uncertainty > _SURE):
            return
        by = np.zeros_like(value)
        for follower, place in motor.followers:
            scale = follower.coupling.multiplier
            stated, uncertain = self.read(place)
            off, other = follower.excess(stated, value) / scale, uncertain / abs(scale)
            better = (
                (uncertainty > _SURE)
                & (other < uncertainty)
                & (np.abs(off) <= COUPLING_TOLERANCE + uncertainty + other)
            )
            by, uncertainty = np.where(better, off, by), np.where(better, other, uncertainty)
        self._move(at, by)
        self.uncertainties[at.ball] = uncertainty

    def _move(self, at: Angle, by: Floats) -> None:
        if by.any():
            self.angles[at.ball] = move_angle(self.balls[at.ball], self.angles[at.ball], at.place, by)

    def choose_turns(self, motor: Motor, at: Angle) -> Floats:
        """Move the driver's angle by the best number of whole turns; return the costs, shape (4, n)."""
        limits, query = _TurnRange.of(motor.driver), self.query
        target = query.target(motor.driver, limits.middle)
        hints = [query.hint(source) for source in motor.hints]
        candidates = _turn_candidates(motor, limits, self.angles[at], target, hints, query)
        costs = np.empty((4, *candidates.shape))
        costs[0] = self.violated_couplings(motor, candidates)
        outside = limits.outside(candidates) if query.near is None else candidates - target
        costs[1], costs[3] = outside**2, (candidates - target) ** 2
        costs[2] = sum(((candidates - hint) ** 2 for hint in hints), np.zeros(1))
        first, column = _first_by_costs(costs), np.arange(len(target))
        self.angles[at] = candidates[first, column]
        return np.asarray(costs[:, first, column])

    def violated_couplings(self, motor: Motor, drivers: Floats) -> Floats:
        """Return the number of followers that disagree with the driver at values (candidates, n)."""
        count = np.zeros(drivers.shape)
        for _, off, allowed in self._excesses(motor, drivers):
            count += np.abs(off) > allowed
        return count

    def mismatches(self, motor: Motor) -> list[Mismatch]:
        """Return the mismatch of each follower of a motor."""
        value, _ = self.read(motor.at)
        rows, ratios = self._excesses(motor, value), [joint.coupling.multiplier for joint, _ in motor.followers]
        pull = sum((ratio * off for ratio, (_, off, _) in zip(ratios, rows, strict=True)), np.zeros(1))
        nearest = value + pull / (1.0 + sum(ratio**2 for ratio in ratios))
        return [
            Mismatch(joint, value, joint.coupling.value(value) + off, np.abs(off) > allowed, nearest)
            for joint, off, allowed in rows
        ]

    def _excesses(self, motor: Motor, drivers: Floats) -> list[tuple[JointNode, Floats, Floats]]:
        """Return every follower, its excess over the value that these driver values require, and the allowed excess."""
        _, uncertainty = self.read(motor.at)
        found = []
        for follower, at in motor.followers:
            value, own = self.read(at)
            allowed = COUPLING_TOLERANCE + abs(follower.coupling.multiplier) * uncertainty + own
            found.append((follower, follower.excess(value, drivers), allowed))
        return found


def _turn_candidates(
    motor: Motor, limits: _TurnRange, angle: Floats, target: Floats, hints: Sequence[Floats], query: _Input
) -> Floats:
    """Return the driver's angle with all numbers of whole turns to try, shape (candidates, n)."""
    nearest = nearest_turn(angle, target)
    # Whether a whole turn of the driver is not a whole turn of some follower.
    winding = any(joint.kind != "revolute" or joint.coupling.multiplier % 1.0 != 0.0 for joint, _ in motor.followers)
    # Whether some angle is inside the limits with more than one number of whole turns.
    several = limits.upper - limits.lower >= TURN - 2.0 * LIMIT_TOLERANCE
    if not winding and (query.near is not None or not (several and hints)):
        return nearest[None]
    tried = [nearest, *(nearest_turn(angle, hint) for hint in hints)]
    counts = _TURNS if winding else min(_TURNS, math.ceil(min(limits.upper - limits.lower, 2e3) / (2.0 * TURN)))
    tried += [nearest + sign * count * TURN for count in range(1, counts + 1) for sign in (-1.0, 1.0)]
    return np.stack(tried)


def _first_by_costs(costs: Floats) -> NDArray[np.intp]:
    """Return the index of the candidate with the lowest costs (levels, candidates, n); the first level matters most."""
    alive = np.ones(costs.shape[1:], dtype=np.bool_)
    for level in costs:
        least = np.where(alive, level, np.inf).min(axis=0)
        alive &= level == least
    return np.asarray(alive.argmax(axis=0))
