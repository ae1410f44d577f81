"""The rows of a log, what is odd about its sensors, and which soles carry the robot.

What cannot be used is left out, and a note says so.

A sensor is odd if it is never known, is beyond its unit, never changes although the legs move, has the wrong sign, or
contradicts the legs: where they show that only one sole can be on the floor, this sole carries, and the others do not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import LOWER, TOUCHING, Floats, as_numbers, shaped
from nao_kin.errors import BadArgument
from nao_kin.robot import Feet, RobotModel
from nao_kin.rotations import matrix_from_rpy, rpy_from_matrix
from nao_kin.world.doing import HALF, UNLOADED, contact
from nao_kin.world.rest import Mask

Result = TypeVar("Result")

# Percentiles that stand for large and small values: the others are delays, bad contact and spikes.
_HIGH, _LOW, _LARGEST = 80.0, 20.0, 99.0
# Values that cannot be are spikes, and left out, in up to this share of the rows, or in two of them.
_RARE = 0.003
# Share of the largest values that is more than noise about zero.
_SOME = 0.1


class Rows(NamedTuple):
    """The rows of a log with a time of their own: of rows with one time, the first value that is known counts.

    `times` ascend, shape (m,) [s]; `own` is the index in them of each given row, shape (n,).
    """

    times: Floats
    own: NDArray[np.intp]
    notes: tuple[str, ...]

    @staticmethod
    def of(times: ArrayLike, count: int) -> Rows:
        """Return the rows of a log of `count` rows; refuse times that go back, or stand still in most rows."""
        moments = np.array(shaped(times, (count,), "times"))
        steps = np.diff(moments)
        if (steps < 0.0).any():
            k = int((steps < 0.0).argmax())
            now, before = (float(moments[at]) for at in (k + 1, k))
            raise BadArgument(f"times must ascend: row {k + 1} is at {now!r} s, row {k} at {before!r} s")
        again = np.append(np.zeros(min(count, 1), dtype=np.bool_), steps == 0.0)
        if not again.any():
            return Rows(moments, np.arange(count), ())
        k, repeated = int(again.argmax()), int(again.sum())
        if repeated > count / 2:
            raise BadArgument(f"times must ascend: {repeated} of {count} rows repeat a time: are they rounded?")
        note = f"{repeated} rows repeat a time, as row {k} does at {float(moments[k])!r} s: they count once"
        return Rows(moments[~again], np.cumsum(~again) - 1, (note,))

    def merged(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return the values (n, ...) of the rows with a time of their own, shape (m, ...)."""
        starts = np.searchsorted(self.own, np.arange(len(self.times)))
        counts, found = np.diff(starts, append=len(self.own)), np.array(values[starts])
        for k in range(1, counts.max(initial=1)):
            some = counts > k
            found[some] = np.where(np.isnan(found[some]), values[starts[some] + k], found[some])
        return found

    def read(self, value: ArrayLike, width: int, what: str) -> Floats:
        """Return the values (n, width) of a sensor, which may have NaN, in the rows with a time of their own."""
        return self.merged(shaped(value, (len(self.own), width), what, gaps=True))

    def expanded(self, found: Result) -> Result:
        """Return a result whose arrays have a row for each time as one with a row for each given row."""
        if len(self.own) == len(self.times):
            return found
        arrays = {field.name: getattr(found, field.name) for field in fields(found)}  # type: ignore[arg-type]
        rows = {name: array[self.own] for name, array in arrays.items() if isinstance(array, np.ndarray)}
        return replace(found, **rows)  # type: ignore[type-var]


def corrected(robot: RobotModel, what: str, given: ArrayLike | None) -> Any:
    """Return what a sensor reports, by the name of an argument of `state`, without the errors that the robot states.

    With R = Ry(pitch) Rx(roll) of the root link in the axes of the inertial unit, a vector v in these is Rᵀ (v − bias)
    in those of the root link, and an orientation R_unit is R_unit R. A force is gain · (value − zero).
    """
    known, sensors = robot.semantics.sensors, robot.semantics.force_sensors
    width = {"forces": len(sensors), "angles": 2, "gyro": 3, "accelerometer": 3}.get(what)  # none of others
    if given is None or not known or np.shape(given)[-1:] != (width,):  # another shape is refused later
        return given
    values = as_numbers(given, what)
    if what == "forces":
        zeros, gains = np.transpose([known.get(name, (0.0, 1.0)) for name in sensors])
        return (values - zeros) * gains
    R = matrix_from_rpy([*known.get("mounting", (0.0, 0.0)), 0.0])
    if what != "angles":
        return (values - np.array(known.get(f"{what}_bias", (0.0, 0.0, 0.0)))) @ R
    R_unit = matrix_from_rpy(np.nan_to_num(np.concatenate([values, 0.0 * values[..., :1]], axis=-1)))
    return np.where(np.isfinite(values), rpy_from_matrix(R_unit @ R)[..., :2], np.nan)


def bridged(values: Floats, moments: Floats, longest_gap: float) -> tuple[Floats, Mask]:
    """Return measured rows of numbers (n, k), with those that have NaN interpolated in time.

    The mask (n,) has the rows that are not farther than a gap from the rows before and after with values.
    """
    known: Mask = np.asarray(np.isfinite(values).all(axis=1))
    at = np.flatnonzero(known)
    if len(at) == len(known) or not len(at):
        return np.where(known[:, None], values, 0.0), known
    filled = np.column_stack([np.interp(moments, moments[at], column[at]) for column in values.T])
    rows = np.arange(len(known))
    before = at[np.maximum(np.searchsorted(at, rows, side="right") - 1, 0)]
    after = at[np.minimum(np.searchsorted(at, rows), len(at) - 1)]
    near = np.maximum(np.abs(moments - moments[before]), np.abs(moments[after] - moments)) <= longest_gap
    return filled, near


class Sensor:
    """The values (n, k) of a sensor, NaN in columns that cannot be used; notes say what is odd about it.

    Columns with names are used one by one; without names, all of them or none.
    """

    def __init__(self, what: str, values: Floats, columns: Sequence[str] | None, notes: list[str]) -> None:
        self.values = np.array(values)
        self._what, self._columns, self._notes = what, columns, notes
        self._note(~np.isfinite(self.values).any(axis=0), "never known")

    def _note(self, odd: Any, reason: str, *, unused: bool = True) -> None:
        """Note columns that are odd, and leave them out if they are `unused`."""
        if odd.any():
            names = "" if self._columns is None or odd.all() else f" of {', '.join(np.array(self._columns)[odd])}"
            self._notes.append(f"{self._what}{names}: {reason}" + ("; not used" if unused else ""))
            if unused:
                self.values[:, odd | (self._columns is None)] = np.nan

    def _typical(self, percent: float, rows: Mask | None = None) -> Floats:
        """Return a percentile of each column, in rows (n, k) of their own; NaN without values."""
        at = np.full(self.values.shape[1], np.nan)
        for k, known in enumerate(np.isfinite(self.values).T):
            own = known if rows is None else known & rows[:, k]
            if own.any():
                at[k] = np.percentile(self.values[own, k], percent)
        return at

    def must_move(self, moves: Mask | bool) -> None:
        """Leave out values that never change although the robot moves, for the sensor or for each column."""
        first = self._typical(0.0)
        still = np.asarray(first == self._typical(100.0))
        still &= moves & (still.all() or self._columns is not None)
        self._note(still, f"always {', '.join(f'{value:.3g}' for value in first[still])} although the robot moves")

    def must_be_within(self, most: float, hint: str) -> None:
        """Leave out absolute values above the largest one in the sensor's unit; `hint` says what they may be."""
        beyond = np.abs(self.values) > most
        if beyond.any():
            some = int(beyond.any(axis=1).sum())
            reason = f"up to {np.nanmax(np.abs(self.values)):.3g}, and at most {most:.2g} can be{hint}"
            rare = some <= max(2.0, _RARE * len(self.values))
            self.values[beyond] = np.nan
            self._note(beyond.any(axis=0), reason + f"; {some} rows left out" if rare else reason, unused=not rare)

    def agree_with(self, along: Floats, hint: str = "") -> Floats:
        """Turn the sign of values that disagree with `along` (n, k) in the sum of products; return that of columns."""
        agreement = np.nansum(self.values * along, axis=0)
        whole = np.isfinite(self.values).any(axis=0)
        if agreement.sum() < 0.0:
            self.values, agreement = -self.values, -agreement
            self._note(whole, f"negative when the robot stands{hint}; its sign is changed", unused=False)
        elif self._columns is None and agreement.sum() == 0.0:
            reason = "the robot never stands upright: its sign is taken as that of 9.8 m/s² up"
            self._note(whole, reason, unused=False)
        return np.asarray(agreement)

    def must_press(self) -> None:
        """Leave out contacts and forces that are negative."""
        if np.isfinite(self.values).any():
            agreement = self.agree_with(np.ones(self.values.shape))
            self._note(agreement < -_SOME * agreement.max(), "negative")
            below = self.values < -_SOME * np.nanmax(self._typical(_LARGEST))
            self._note(below.sum(axis=0) > _RARE * len(self.values), "negative in some rows, 0 there", unused=False)

    def must_follow_the_legs(self, high: Mask, low: Mask, least: Floats | float) -> None:
        """Leave out columns that are not higher by `least` in rows (n, k) in which the legs say so than in low ones."""
        on, off = self._typical(_HIGH, high), self._typical(_LOW, low)
        never = self._typical(_LARGEST) < least
        odd = (on - off < least) | np.isfinite(on) & never
        odd &= not never.all()  # otherwise it is in the air throughout
        self._note(odd, "in contradiction to the legs" + (": exchanged?" if odd.all() and len(odd) > 1 else ""))

    def subtract_offset(self, low: Mask, least: Floats) -> None:
        """Subtract what columns show beyond `least` in rows (n, k) in which the legs say that they are low."""
        off = self._typical(_LOW, low)
        shifted = np.abs(off) > least
        self.values -= np.where(shifted, off, 0.0)
        shown = ", ".join(f"{value:.3g}" for value in off[shifted])
        self._note(shifted, f"{shown} in the air, as the legs say; subtracted", unused=False)


# --- Which soles carry a robot, and whether it is lifted, by contacts, by forces, or by its legs alone.
#
# Contacts and forces are used as far as they are not odd: where a sole has none that can be used, the legs decide for
# all of them. Weight and unit of the forces come from the log, and are compared with the robot's mass.

# Standard gravity [m/s²].
GRAVITY = 9.80665
# Share of the force from which the other sole becomes the support: more than half, so that the support does not switch
# back and forth while both carry the robot.
_SHARE = 0.6
# The weight is the 95th percentile of the forces in the log, or, if the robot stands for a short time only, the largest
# median over _HELD [s]; in kg or N it is at least and at most these shares of that of the robot's mass. Forces whose
# sum is 1 within _SHARES are shares of the weight.
_HEAVY, _HELD, _LEAST, MOST, _SHARES = 95.0, 0.3, 0.5, 1.5, 0.02
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
        stands: in which rows the soles carry, shape (n,).
        share: force on all soles as a share of the weight, shape (n,); NaN without forces.
        heavy: in which rows the soles carry half of the weight, shape (n,); `stands` without forces.
    """

    rule: str
    pressed: Floats
    sensors: Floats | None
    known: Mask
    stands: Mask
    share: Floats
    heavy: Mask

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
        share = np.full(len(moments), np.nan)
        if contacts is not None and forces is not None:
            raise BadArgument("give contacts or forces, not both")
        if contacts is None and forces is None:
            return Ground(
                "joints", np.ones((len(moments), len(feet.names))), None, everywhere, everywhere, share, everywhere
            )
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
            return Ground("joints", pressed, sensors, everywhere, everywhere, share, everywhere)
        loaded: Mask = np.asarray(pressed.any(axis=1))
        half: Mask = loaded
        if rule == "forces":
            weight = _weight(pressed, moments)
            odd, carries = _on_weight(robot.mass, weight, shares=_are_shares(pressed))
            notes += odd
            share = pressed.sum(axis=1) / (weight if carries else max(robot.mass, weight))
            loaded &= carries & (share >= UNLOADED)
            half = np.asarray(loaded & (share >= HALF))
        return Ground(rule, pressed, sensors, known, contact(loaded, moments), share, contact(half, moments))

    def supports(
        self, rows: NDArray[np.intp] | slice, T_base_soles: Floats, before: int | None = None
    ) -> NDArray[np.intp]:
        """Return the index of the support in some rows, with soles at T_base_soles (m, s, 4, 4), shape (m,).

        `before` is the support before them, None for the one on which the robot stands by its joints.
        """
        pressed = self.pressed[rows]
        now, own = standing_sole(T_base_soles[0], 0) if before is None else before, np.arange(pressed.shape[1])
        strongest, total = pressed.argmax(axis=1), pressed.sum(axis=1)
        # The support after each row, for each support before it, shape (m, s).
        if self.rule == "joints":
            after = _next_soles(sole_heights(T_base_soles))
        elif self.rule == "contacts":
            after = np.where((pressed > 0.0) | (total == 0.0)[:, None], own, strongest[:, None])
        else:
            now = int(strongest[0]) if total[0] > 0.0 and before is None else now
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
    if not any(_LEAST * unit <= weight <= MOST * unit for unit in (mass, GRAVITY * mass)):
        return [f"forces: the soles carry {weight:.3g}, and {robot}: another unit, or an offset?"], True
    return [], True
