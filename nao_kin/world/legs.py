"""What the legs of a robot say in the rows of a log: where its soles are, which of them carry it, and how much.

Contacts and forces are used as far as they are not odd: where a sole has none that can be used, the legs decide for
all of them. Weight and unit of the forces come from the log, and are compared with the robot's mass.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import LOWER, TOUCHING, Floats, as_floats, as_numbers, between_samples, check_tolerance
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.robot import Feet, RobotModel, serial_chain
from nao_kin.world.doing import HALF, UNLOADED, Contact, decided
from nao_kin.world.rest import Mask, RestLog, Turns
from nao_kin.world.sensors import WIDTHS, Rows, Sensor, bridged, corrected

# Standard gravity [m/s²].
GRAVITY = 9.80665
# Share of the force from which the other sole becomes the support: more than half, so that the support does not switch
# back and forth while both carry the robot.
_SHARE = 0.6
# The weight is the 95th percentile of the forces in the log, or, if the robot stands for a short time only, the largest
# median over _HELD [s]; in kg or N it is at least and at most these shares of that of the robot's mass. Forces whose
# sum is 1 within _SHARES are shares of the weight.
_HEAVY, _HELD, _LEAST, _MOST, _SHARES = 95.0, 0.3, 0.5, 1.5, 0.02
# One sole alone carries this share of the mass in a standing robot whose other sole has a dead sensor.
_HALF = 0.35, 0.75
# A sole is alone on the floor if it is lower than the others by this height [m], more than zeros of the legs' joints
# that are off by a degree make of soles on one floor. This must last for _EVIDENCE in all to say anything [s].
_ALONE, _EVIDENCE = 0.01, 0.2
# A sole whose force differs by less than this share of the weight between the floor and the air contradicts the legs,
# and one that shows more in the air has an offset.
_SAME = 0.1
# Hips that are lower over the lowest sole than this share of the length of the leg are those of a robot that sits: 0.1
# and 0.2 in the postures of a NAO that sit, 0.6 in those that crouch.
_LOW = 0.45
# By this much the legs must turn the root link, so that an inertial sensor that never changes is odd [rad].
_TURNED = np.radians(3.0)
# The largest values that inertial sensors show, and what larger ones may be: 500 °/s of a NAO's gyrometer, and a half
# turn [rad/s, rad]. Source: doc.aldebaran.com/2-8, inertial_naov6.
LARGEST = {"gyro": np.radians(500.0), "angles": np.pi}
_HINTS = {
    "gyro": ": are these deg/s? A heading such as GyroX [deg/s] says so",
    "angles": ": are these degrees?",
    "accelerometer": ", as LoLA has it",
}


class Legs:
    """The legs of a robot: the s soles, the joints that move them, and the f force sensors.

    Attributes:
        robot, feet, heights: the robot, its soles, and the height of each frame over its sole, shape (s,) [m].
        flat: whether all heights are zero.
        columns: of a configuration that move soles, shape (j,).
        carried: 1 for the force sensors that each sole carries, shape (s, f).
        cells: indices of the force sensors of each sole, and their places in its frame, x and y.
        hips: the first joints of the legs in the root link, shape (h, 3) [m].
        low: height of the hips over the lowest sole, below which the robot sits [m].
    """

    def __init__(self, robot: RobotModel, soles: Sequence[str] | None) -> None:
        self.robot, self.feet = robot, Feet.of(robot, soles, needed=True, or_origin=True)
        self.heights = self.feet.heights
        self.flat = not self.heights.any()
        chains = [serial_chain(robot, robot.tree.root, sole) for sole in self.feet.names]
        moving = {name for chain in chains for name in chain.coordinates}
        self.columns = np.array(
            [robot.nq_base + k for k, name in enumerate(robot.joint_names) if name in moving], dtype=np.intp
        )
        sensors = robot.semantics.force_sensors
        carried = self.feet.carried(robot, sensors)
        self.carried = carried.astype(np.float64)
        self.cells: list[tuple[NDArray[np.intp], Floats]] = []
        for name, own in zip(self.feet.names, carried, strict=True):
            places = robot.fk(robot.neutral(), np.array(sensors)[own].tolist(), reference=name)[:, :2, 3]
            self.cells.append((np.flatnonzero(own), places))
        origins = [chain.placements[:, :, 3] for chain in chains]
        self.hips = np.array([places[0] for places in origins if len(places) > 1]).reshape(-1, 3)
        self.low = _LOW * float(min(np.linalg.norm(places[1:], axis=1).sum() for places in origins))

    def soles(self, q: Floats) -> Floats:
        """Return the poses of the soles in the root link, on the ground, shape (..., s, 4, 4)."""
        T = np.asarray(self.robot.fk(q, self.feet.names, reference=self.robot.tree.root))
        return T if self.flat else self.feet.on_ground(T)


def standing_sole(T_base_soles: Floats, before: int) -> int:
    """Return the sole (s, 4, 4) on which a robot stands: `before`, unless another one is lower, seen from both."""
    return int(_next_soles(sole_heights(T_base_soles))[before])


def _next_soles(heights: Floats) -> NDArray[np.intp]:
    """Return the sole on which a robot stands after each sole i, shape (..., s), by the height of j over i (s, s)."""
    below = (heights < -LOWER) & (heights.swapaxes(-1, -2) > -LOWER)
    lowest = np.where(below, heights, np.inf).argmin(axis=-1)
    return np.where(below.any(axis=-1), lowest, np.arange(heights.shape[-1]))


def sole_heights(T_base_soles: Floats) -> Floats:
    """Return the height of sole j over the plane of sole i, shape (..., s, s), for soles at (..., s, 4, 4) [m]."""
    levers = T_base_soles[..., None, :, :3, 3] - T_base_soles[..., :, None, :3, 3]
    return np.asarray((levers @ T_base_soles[..., :3, 2, None])[..., 0])


# --- Which soles carry a robot, and whether it is lifted, by contacts, by forces, or by its legs alone.


class Loads(NamedTuple):
    """How contacts or forces (n, k) are read: how much each counts for each sole, (k, s), and the robot's weight."""

    sensor: Sensor
    counted: Floats
    weight: float

    def ground(self, values: Floats, known: Mask, moments: Floats, stands: Contact, heavy: Contact) -> Ground:
        """Return rows by values without errors, and rules of the soles' contact and of half of the weight on them."""
        pressed, share = np.where(values > 0.0, values, 0.0) @ self.counted, np.full(len(values), np.nan)
        sensors = None if self.counted.shape[0] == self.counted.shape[1] else np.maximum(values, 0.0)
        total = pressed.sum(axis=1)
        loaded = half = total > 0.0
        if self.sensor.what == "forces":
            share = total / self.weight
            loaded, half = share >= UNLOADED, share >= HALF
        carry, both = decided(stands, loaded, moments), decided(heavy, half, moments)
        return Ground(self.sensor.what, pressed, sensors, known, carry, share, both, self)


@dataclass(frozen=True, eq=False)
class Ground:
    """What contacts or forces say about the s soles of a robot in n rows.

    Attributes:
        rule: "contacts", "forces", or "joints" for neither, or where a sole has none that can be used.
        pressed: contact of or force on each sole, none below zero, shape (n, s); NaN for a sole whose are not used.
        sensors: force on each force sensor of the semantics, shape (n, f), NaN for those that are not used; None if
            they are not given.
        known: in which rows there are values, shape (n,).
        stands: in which rows the soles carry, shape (n,).
        share: force on all soles as a share of the weight, shape (n,); NaN without forces.
        heavy: in which rows the soles carry half of the weight, shape (n,); `stands` without forces.
        loads: how contacts or forces are read; None without them.
    """

    rule: str
    pressed: Floats
    sensors: Floats | None
    known: Mask
    stands: Mask
    share: Floats
    heavy: Mask
    loads: Loads | None = None

    @staticmethod
    def of(
        legs: Legs,
        T_base_soles: Floats,
        legs_known: Mask,
        rows: Rows,
        contacts: ArrayLike | None,
        forces: ArrayLike | None,
        longest_gap: float,
        notes: list[str],
    ) -> Ground:
        """Return what the arguments of `odometry` say, and add notes on what is odd."""
        moments, feet, robot = rows.times, legs.feet, legs.robot
        if contacts is not None and forces is not None:
            raise BadArgument("give contacts or forces, not both")
        if contacts is None and forces is None:
            return Ground.by_legs(np.ones((len(moments), len(feet.names))))
        rule, names, carried = "contacts", feet.names, np.eye(len(feet.names))
        if contacts is not None:
            values = rows.read(contacts, len(names), rule)
            values = np.where(np.isnan(values), np.nan, values != 0.0)
        else:
            rule, numbers = "forces", as_numbers(corrected(robot, "forces", forces), "forces")
            feet.forces(robot, np.zeros(numbers.shape), (len(rows.own),))  # refuses other shapes
            values = rows.read(numbers, numbers.shape[1], rule)
            if numbers.shape[1] != len(names):
                names, carried = robot.semantics.force_sensors, legs.carried
        alone, air = _standing_alone(T_base_soles, legs_known, moments)
        steps = (alone.any(axis=0) & air.any(axis=0)) @ carried > 0.0
        given = Sensor(rule, values, names, notes)
        given.must_move(steps & (rule == "forces"))
        given.must_press()
        used = np.isfinite(given.values).any(axis=0)
        given.values[:, used], known = bridged(given.values[:, used], moments, longest_gap)
        pressed, high, weight = _summed(given.values, carried), alone, 1.0
        if rule == "forces":
            weight = _weight(pressed, moments)
            level = (np.abs(sole_heights(T_base_soles)) <= TOUCHING).all(axis=(1, 2)) & legs_known
            if any(_HALF[0] * unit <= weight <= _HALF[1] * unit for unit in (robot.mass, GRAVITY * robot.mass)):
                high = alone | level[:, None]
        heavy = rule == "contacts" or weight >= _HALF[0] * robot.mass or _are_shares(pressed)
        if heavy and np.isfinite(pressed).all():
            soles = Sensor(rule, pressed, feet.names, notes)
            soles.must_follow_the_legs(high, air, _SAME * weight)
            pressed = soles.values
        standing = rule == "forces" and (weight >= _LEAST * robot.mass or _are_shares(pressed))
        if standing and np.isfinite(pressed).all():
            given.subtract_offset(air @ carried > 0.0, _SAME * weight / carried.sum(axis=1) @ carried)
            pressed = _summed(given.values, carried)
        if not np.isfinite(pressed).all():
            notes.append(f"the legs say which sole carries, and not the {rule}")
            return Ground.by_legs(pressed, None if len(names) == len(feet.names) else np.maximum(given.values, 0.0))
        carries = True
        if rule == "forces":
            weight = _weight(pressed, moments)
            odd, carries = _on_weight(robot.mass, weight, shares=_are_shares(pressed))
            notes += odd
            weight = weight if carries else max(robot.mass, weight)
        loads = Loads(given, _counted(given.values, carried), weight)
        ground, never = loads.ground(given.values, known, moments, Contact(), Contact()), np.zeros_like(known)
        return ground if carries else replace(ground, stands=never, heavy=never)

    @staticmethod
    def by_legs(pressed: Floats, sensors: Floats | None = None) -> Ground:
        """Return rows in which the legs say which soles carry."""
        every = np.ones(len(pressed), dtype=np.bool_)
        return Ground("joints", pressed, sensors, every, every, np.full(len(pressed), np.nan), every)

    def supports(self, T_base_soles: Floats, before: int | None = None) -> NDArray[np.intp]:
        """Return the index of the support in each row, with soles at T_base_soles (n, s, 4, 4), shape (n,).

        `before` is the support before them, None for the one on which the robot stands by its joints.
        """
        now, found = standing_sole(T_base_soles[0], 0) if before is None else before, []
        if self.rule == "joints":
            for after in _next_soles(sole_heights(T_base_soles)).tolist():
                found.append(now := after[now])
            return np.array(found, dtype=np.intp)
        for row in self.pressed.tolist():
            most, first = max(row), before is None and not found
            enough = _SHARE * sum(row) if self.rule == "forces" and not first else 0.0
            if most > enough and not (self.rule == "contacts" and row[now] > 0.0):
                now = row.index(most)
            found.append(now)
        return np.array(found, dtype=np.intp)


def _standing_alone(T_base_soles: Floats, known: Mask, moments: Floats) -> tuple[Mask, Mask]:
    """Return in which rows the legs put each sole below all others, and above one that is, shapes (n, s).

    A sole for which this does not last has no such rows.
    """
    heights = sole_heights(T_base_soles)
    above = (heights > _ALONE) & (heights.swapaxes(1, 2) < -_ALONE) & known[:, None, None]  # sole j over sole i
    one = np.eye(heights.shape[-1], dtype=np.bool_)
    alone = np.asarray((above | one).all(axis=2) & ~one.all())
    air = (above & alone[..., None]).any(axis=1)
    least = _EVIDENCE / _step(moments)
    return alone & (alone.sum(axis=0) >= least), air & (air.sum(axis=0) >= least)


def _step(moments: Floats) -> float:
    """Return the median time between two rows, infinite for a single one [s]."""
    return float(np.median(np.diff(moments))) if len(moments) > 1 else np.inf


def _counted(values: Floats, carried: Floats) -> Floats:
    """Return how much each sensor (n, f) counts for each sole, shape (f, s), if they are `carried` by them (s, f).

    Where a sensor of a sole is not used, its others count for it; without any, the sole has NaN.
    """
    used = np.isfinite(values).all(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray((carried * used * (carried.sum(axis=1) / (carried @ used))[:, None]).T)


def _summed(values: Floats, carried: Floats) -> Floats:
    """Return the force on each sole, shape (n, s), from sensors (n, f) that are `carried` by them (s, f)."""
    return np.asarray(np.where(values > 0.0, values, 0.0) @ _counted(values, carried))


def _weight(pressed: Floats, moments: Floats) -> float:
    """Return the weight of a robot by the forces on its soles (n, s), NaN for those that are not used."""
    total = np.nansum(pressed, axis=1)
    usual = float(np.percentile(total, _HEAVY))
    rows = min(len(total), max(1, round(_HELD / _step(moments))))
    held = float(np.median(np.lib.stride_tricks.sliding_window_view(total, rows), axis=1).max())
    return held if held > 2.0 * usual else usual


def _are_shares(pressed: Floats) -> bool:
    """Return whether forces (n, s) are shares of the weight, with a sum of 1 wherever they carry."""
    total = pressed.sum(axis=1)
    carried = total[total > _LEAST]
    return len(carried) > 0 and bool((np.abs(carried - 1.0) <= _SHARES).all())


def _on_weight(mass: float, weight: float, *, shares: bool) -> tuple[list[str], bool]:
    """Return what is odd about the weight by the forces of a log, and whether it can be that of a standing robot."""
    robot = f"the robot weighs {mass:.3g} kg, which is {GRAVITY * mass:.3g} N"
    if shares:
        return ["forces: with a sum of 1, taken as shares of the weight"], True
    if weight < _LEAST * mass:
        return [f"forces: the soles carry {weight:.2g} at most, and {robot}: no row counts as standing"], False
    if not any(_LEAST * unit <= weight <= _MOST * unit for unit in (mass, GRAVITY * mass)):
        return [f"forces: the soles carry {weight:.3g}, and {robot}: another unit, or an offset?"], True
    return [], True


def centre_of_pressure(T_world_soles: Floats, pressed: Floats, pressure: Floats) -> Floats:
    """Return the centre of pressure of all soles (n, s, 4, 4) in the world, x and y, shape (n, 2).

    `pressed` is the force on each, shape (n, s), and `pressure` the centre of pressure on it, shape (n, s, 2).
    """
    places = (T_world_soles[..., :2, :2] @ pressure[..., None])[..., 0] + T_world_soles[..., :2, 3]
    total = pressed.sum(axis=1)[:, None]
    moments = np.where(pressed[..., None] > 0.0, pressed[..., None] * places, 0.0).sum(axis=1)
    return np.asarray(moments / np.where(total > 0.0, total, np.nan))


# --- A log.


@dataclass(frozen=True, eq=False)
class LegLog:
    """A checked log of n rows: what its joints say about the soles, and contacts or forces about the ground.

    Attributes:
        legs: those of the robot.
        rows: the rows with a time of their own, n of them.
        q: configurations, interpolated where they are NaN, shape (n, nq).
        T_base_soles: poses of the soles in the root link, on the ground, shape (n, s, 4, 4).
        ground: contacts or forces.
        support: index of the sole on which the robot stands, shape (n,).
        known: in which rows the values of the legs and of the ground are known, shape (n,).
        longest_gap: largest time between two rows of a segment [s].
        notes: what is odd about the sensors.
        sensors: how contacts, forces and inertial sensors are read, by their names.
    """

    legs: Legs
    rows: Rows
    q: Floats
    T_base_soles: Floats
    ground: Ground
    support: NDArray[np.intp]
    known: Mask
    longest_gap: float
    notes: list[str]
    sensors: dict[str, Sensor] = field(default_factory=dict)

    @staticmethod
    def of(
        legs: Legs,
        times: ArrayLike,
        q: ArrayLike,
        contacts: ArrayLike | None,
        forces: ArrayLike | None,
        longest_gap: float,
        T_base_soles: Floats | None = None,
    ) -> LegLog:
        """Return the log that the arguments of `odometry` give, and the poses of the soles if they are known."""
        robot = legs.robot
        values = as_floats(q, (robot.nq,), "q", gaps=True)
        if values.ndim != 2 or not len(values):
            raise WrongShape("q", f"(n, {robot.nq}), one configuration at least", values.shape)
        rows = Rows.of(times, len(values))
        measured = rows.merged(values)
        filled, known = between_samples(measured), np.asarray(~np.isnan(measured[:, legs.columns]).any(axis=1))
        configurations = robot.checked(np.where(np.isnan(filled), robot.neutral(), filled))
        check_tolerance(longest_gap, "longest_gap")
        notes, T_base_soles = list(rows.notes), legs.soles(configurations) if T_base_soles is None else T_base_soles
        ground = Ground.of(legs, T_base_soles, known, rows, contacts, forces, longest_gap, notes)
        support, known = ground.supports(T_base_soles), known & ground.known
        sensors = {} if ground.loads is None else {ground.rule: ground.loads.sensor}
        found = legs, rows, configurations, T_base_soles, ground, support, known, float(longest_gap), notes, sensors
        return LegLog(*found)

    @property
    def moments(self) -> Floats:
        """Times of the rows, shape (n,) [s]."""
        return self.rows.times

    @property
    def lost(self) -> Mask:
        """In which rows the values of the legs or of the ground are missing for longer than the longest gap, (n,)."""
        at = np.flatnonzero(self.known)
        wide = np.diff(self.moments[at], prepend=-np.inf, append=np.inf) > self.longest_gap
        return np.asarray(~self.known & wide[np.searchsorted(at, np.arange(len(self.known)))])

    @cached_property
    def lever(self) -> Floats:
        """The pose of the support in the root link, shape (n, 4, 4)."""
        return self.T_base_soles[np.arange(len(self.support)), self.support]

    @cached_property
    def carrying(self) -> Mask:
        """Which soles carry the robot or, from the joints alone, are as low as the support, shape (n, s)."""
        if self.ground.rule == "joints":
            heights = sole_heights(self.T_base_soles)[np.arange(len(self.support)), self.support]
            return np.asarray(np.abs(heights) <= TOUCHING)
        return self.legs.feet.loaded(self.ground.pressed)

    @cached_property
    def pressure(self) -> Floats:
        """The centre of pressure on each sole, shape (n, s, 2); NaN without forces of its sensors."""
        ground, found = self.ground, np.full((*self.ground.pressed.shape, 2), np.nan)
        if ground.sensors is not None:
            pressed = np.where(ground.pressed > 0.0, ground.pressed, np.nan)
            for k, (own, places) in enumerate(self.legs.cells):
                found[:, k] = ground.sensors[:, own] @ places / pressed[:, k, None]
        return found

    def read(self, what: str, given: ArrayLike) -> Floats:
        """Return the values (n, width) of an inertial sensor without its known errors."""
        return self.rows.read(corrected(self.legs.robot, what, given), WIDTHS[what], what)

    def measured(self, what: str, values: Floats, *, along: Floats | None = None) -> tuple[Floats, Mask] | None:
        """Return values (n, k) of an inertial sensor, interpolated in time, and where they are known; or None.

        None stands for a sensor that cannot be used, and the notes say why. `along` is that of `Sensor`.
        """
        known, hint = values[np.isfinite(values).all(axis=1)], _HINTS[what]
        moves = len(known) > 1 and bool((known == known[0]).all()) and self._turns(what)
        self.sensors[what] = found = Sensor(what, values, None, self.notes)
        found.must_be_within(LARGEST.get(what, np.inf), hint)
        found.must_move(moves)
        if along is not None and np.isfinite(found.values).any():
            found.agree_with(along, hint)
        return bridged(found.values, self.moments, self.longest_gap) if np.isfinite(found.values).any() else None

    def turns(self, gyro: ArrayLike | None, up: Floats | None = None) -> tuple[Turns | None, RestLog]:
        """Return the angular velocity without its bias, and the rest in the log; None without gyrometer to use.

        Without gyrometer, verticals `up` (n, 3) show whether the trunk is quiet.
        """
        found = None if gyro is None else self.measured("gyro", self.read("gyro", gyro))
        joints, stands = self.q[:, self.legs.columns], self.ground.stands
        if found is None:
            used = self.known if up is None else self.known & np.isfinite(up).all(axis=1)
            return None, RestLog.of(self.moments, joints, stands, used, up, "up")
        rates, near = found
        rest = RestLog.of(self.moments, joints, stands, self.known & near, rates, "gyro")
        return Turns(rates - rest.bias, near, rest.deviation), rest

    def _turns(self, what: str) -> bool:
        """Return whether the legs turn the root link, about the vertical too if a gyrometer would show it."""
        R = self.lever[self.known & self.ground.stands, :3, :3]
        turns = R.reshape(-1, 9) if what == "gyro" else R[:, :, 2]
        return len(R) > 0 and bool((np.diff(np.percentile(turns, [1.0, 99.0], axis=0), axis=0) > _TURNED).any())
