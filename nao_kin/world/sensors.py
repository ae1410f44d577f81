"""The rows of a log, and what is odd about its sensors: what cannot be used is left out, and a note says so.

A sensor is odd if it is never known, is beyond its unit, never changes although the legs move, has the wrong sign, or
contradicts the legs: where they show that only one sole can be on the floor, this sole carries, and the others do not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, as_numbers, shaped
from nao_kin.errors import BadArgument
from nao_kin.robot import RobotModel
from nao_kin.rotations import matrix_from_rpy, rpy_from_matrix
from nao_kin.world.rest import Mask

Result = TypeVar("Result")

# Numbers of each inertial sensor.
WIDTHS = {"angles": 2, "accelerometer": 3, "gyro": 3}
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
    width = len(sensors) if what == "forces" else WIDTHS.get(what)
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

    Columns with names are used one by one; without names, all of them or none. The values are `gain` times those that
    were given minus `offset`, shapes (k,); the gain of a column that cannot be used is NaN.
    """

    def __init__(self, what: str, values: Floats, columns: Sequence[str] | None, notes: list[str]) -> None:
        self.values = np.array(values)
        self.gain, self.offset = np.ones(values.shape[1]), np.zeros(values.shape[1])
        self.what, self._columns, self._notes = what, columns, notes
        self._note(~np.isfinite(self.values).any(axis=0), "never known")

    def _note(self, odd: Any, reason: str, *, unused: bool = True) -> None:
        """Note columns that are odd, and leave them out if they are `unused`."""
        if odd.any():
            names = "" if self._columns is None or odd.all() else f" of {', '.join(np.array(self._columns)[odd])}"
            self._notes.append(f"{self.what}{names}: {reason}" + ("; not used" if unused else ""))
            if unused:
                columns = odd | (self._columns is None)
                self.values[:, columns] = self.gain[columns] = np.nan

    def _typical(self, percent: float, rows: Mask | None = None) -> Floats:
        """Return a percentile of each column, in rows (n, k) of their own; NaN without values."""
        values = self.values if rows is None else np.where(rows, self.values, np.nan)
        ordered, last = np.sort(values, axis=0), np.isfinite(values).sum(axis=0) - 1  # NaN is last
        place, columns = 0.01 * percent * np.maximum(last, 0), np.arange(values.shape[1])
        row = place.astype(np.intp)
        low, high = ordered[row, columns], ordered[np.minimum(row + 1, last), columns]
        return np.asarray(low + (place - row) * (high - low))

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
            self.values, self.gain, agreement = -self.values, -self.gain, -agreement
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

    def contradicts_the_legs(self) -> None:
        """Leave out the sensor."""
        self._note(np.ones(len(self.gain), dtype=np.bool_), "in contradiction to the legs and the forces")

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
        self.offset = np.where(shifted, off, 0.0)
        self.values -= self.offset
        shown = ", ".join(f"{value:.3g}" for value in off[shifted])
        self._note(shifted, f"{shown} in the air, as the legs say; subtracted", unused=False)
