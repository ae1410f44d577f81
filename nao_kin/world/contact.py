"""Which soles carry a robot, and whether it is lifted, by contacts, by forces, or by its legs alone.

Contacts and forces are used as far as they are not odd (`Sensor`): where a sole has none that can be used, the legs
decide for all of them. Weight and unit of the forces come from the log, and are compared with the robot's mass.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import LOWER, TOUCHING, Floats, as_numbers
from nao_kin.errors import BadArgument
from nao_kin.robot import Feet, RobotModel
from nao_kin.world.sensors import Mask, Rows, Sensor, bridged, debounced

# Standard gravity [m/s²].
GRAVITY = 9.80665
# Share of the force from which the other sole becomes the support: more than half, so that the support does not switch
# back and forth while both carry the robot.
_SHARE = 0.6
# A robot is lifted if its soles carry less than this share of its weight for _LIFTED, and stands again after _DOWN [s].
# Source of the times: B-Human's groundContactDetector.cfg (d89d603), maxTimeWithoutPressure, minTimeWithPressure.
_UNLOADED, _LIFTED, _DOWN = 0.2, 0.2, 0.1
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
    return np.asarray(np.einsum("...ijk,...ik->...ij", levers, T_base_soles[..., :3, 2]))


def standing_alone(T_base_soles: Floats, known: Mask, moments: Floats) -> tuple[Mask, Mask]:
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


@dataclass(frozen=True, eq=False)
class Ground:
    """What contacts or forces say about the s soles of a robot in n rows.

    Attributes:
        rule: "contacts", "forces", or "joints" for neither, or where a sole has none that can be used.
        pressed: contact of or force on each sole, none below zero, shape (n, s); NaN for a sole whose are not used.
        sensors: force on each force sensor of the semantics, shape (n, f), NaN for those that are not used; None if
            they are not given.
        known: in which rows there are values, shape (n,).
        stands: in which rows the robot is not lifted, shape (n,).
    """

    rule: str
    pressed: Floats
    sensors: Floats | None
    known: Mask
    stands: Mask

    @staticmethod
    def of(
        robot: RobotModel,
        feet: Feet,
        T_base_soles: Floats,
        legs_known: Mask,
        rows: Rows,
        contacts: ArrayLike | None,
        forces: ArrayLike | None,
        longest_gap: float,
        notes: list[str],
    ) -> Ground:
        """Return what the arguments of `odometry` say, and add notes on what is odd."""
        moments, everywhere = rows.times, np.ones(len(rows.times), dtype=np.bool_)
        if contacts is not None and forces is not None:
            raise BadArgument("give contacts or forces, not both")
        if contacts is None and forces is None:
            return Ground("joints", np.ones((len(moments), len(feet.names))), None, everywhere, everywhere)
        rule, names, carried = "contacts", feet.names, np.eye(len(feet.names))
        if contacts is not None:
            values = rows.read(contacts, len(names), rule)
            values = np.where(np.isnan(values), np.nan, values != 0.0)
        else:
            rule, numbers = "forces", as_numbers(forces, "forces")  # type: ignore[arg-type]
            feet.forces(robot, np.zeros(numbers.shape), (len(rows.own),))  # refuses other shapes
            values = rows.read(numbers, numbers.shape[1], rule)
            if numbers.shape[1] != len(names):
                names = robot.semantics.force_sensors
                carried = feet.carried(robot, names).astype(np.float64)
        alone, air = standing_alone(T_base_soles, legs_known, moments)
        steps = (alone.any(axis=0) & air.any(axis=0)) @ carried > 0.0
        given = Sensor(rule, values, names, notes)
        given.must_move(steps & (rule == "forces"))
        given.must_press()
        values = given.values
        used = np.isfinite(values).any(axis=0)
        values[:, used], known = bridged(values[:, used], moments, longest_gap)
        pressed, high, weight = _summed(values, carried), alone, 1.0
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
            least = _SAME * weight / carried.sum(axis=1) @ carried[:, used]
            names_used, low = np.array(names)[used].tolist(), (air @ carried > 0.0)[:, used]
            given = Sensor(rule, values[:, used], names_used, notes)
            given.subtract_offset(low, least)
            values[:, used] = given.values
            pressed = _summed(values, carried)
        sensors = None if len(names) == len(feet.names) else np.maximum(values, 0.0)
        if not np.isfinite(pressed).all():
            notes.append(f"the legs say which sole carries, and not the {rule}")
            return Ground("joints", pressed, sensors, everywhere, everywhere)
        loaded: Mask = np.asarray(pressed.any(axis=1))
        if rule == "forces":
            weight = _weight(pressed, moments)
            odd, carries = _on_weight(robot.mass, weight, shares=_are_shares(pressed))
            notes += odd
            loaded &= carries & (pressed.sum(axis=1) >= _UNLOADED * weight)
        stands = debounced(debounced(loaded, moments, False, _LIFTED), moments, True, _DOWN)
        return Ground(rule, pressed, sensors, known, stands)

    def supports(self, rows: NDArray[np.intp], T_base_soles: Floats) -> NDArray[np.intp]:
        """Return the index of the support in some rows, with soles at T_base_soles (m, s, 4, 4), shape (m,)."""
        heights, pressed = sole_heights(T_base_soles), self.pressed[rows]
        now, own = standing_sole(T_base_soles[0], 0), np.arange(heights.shape[-1])
        strongest, total = pressed.argmax(axis=1), pressed.sum(axis=1)
        # The support after each row, for each support before it, shape (m, s).
        if self.rule == "joints":
            after = _next_soles(heights)
        elif self.rule == "contacts":
            after = np.where((pressed > 0.0) | (total == 0.0)[:, None], own, strongest[:, None])
        else:
            now = int(strongest[0]) if total[0] > 0.0 else now
            changes = (total > 0.0) & (pressed.max(axis=1) > _SHARE * total)
            after = np.where(changes[:, None], strongest[:, None], own)
        found = np.empty(len(after), dtype=np.intp)
        for k, row in enumerate(after.tolist()):
            found[k] = now = row[now]
        return found


def _summed(values: Floats, carried: Floats) -> Floats:
    """Return the force on each sole, shape (n, s), from sensors (n, f) that are `carried` by them (s, f).

    Where a sensor of a sole is not used, its others count for it.
    """
    used = np.isfinite(values).all(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        counted = carried.sum(axis=1) / carried[:, used].sum(axis=1)
        return np.asarray(np.maximum(values[:, used], 0.0) @ carried[:, used].T * counted)


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
