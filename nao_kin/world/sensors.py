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

from nao_kin._core.arrays import Floats, shaped
from nao_kin.errors import BadArgument

Mask = NDArray[np.bool_]
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
        moments = shaped(times, (count,), "times")
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


def debounced(mask: Mask, moments: Floats, value: bool, shortest: float) -> Mask:
    """Return a mask (n,) in which runs of `value` that are shorter than a time have the other value."""
    edges = np.flatnonzero(np.diff(mask)) + 1
    starts, ends = np.concatenate([[0], edges]), np.concatenate([edges, [len(mask)]])
    lasting = moments[np.minimum(ends, len(mask) - 1)] - moments[starts]
    brief = (mask[starts] == value) & (lasting < shortest) & (len(starts) > 1)
    return np.asarray(mask ^ np.repeat(brief, ends - starts))


def examined(
    what: str,
    values: Floats,
    columns: Sequence[str] | None = None,
    *,
    moves: Mask | bool = False,
    most: float = np.inf,
    hint: str = "",
    along: Floats | None = None,
    high: Mask | None = None,
    low: Mask | None = None,
    least: Floats | float = 0.0,
) -> tuple[Floats, list[str]]:
    """Return the values (n, k) of a sensor, NaN in columns that cannot be used, and notes on what is odd about it.

    Args:
        what: the sensor, for the notes.
        values: NaN where they are not known.
        columns: names of the k columns, which are used one by one; None to use all of them or none.
        moves: whether the robot moves so that the values change, of the sensor or of each column.
        most: largest absolute value in its unit.
        hint: what larger values, or those of the other sign, may be.
        along: what the values agree with, shape (n, k): the sum of the products is positive, of `columns` each.
        high: in which rows the legs say that a column is high, shape (n, k).
        low: in which rows they say that it is low, shape (n, k); without `high`, by how much it is not is subtracted.
        least: by how much high and low values of a column differ.
    """
    found, notes = np.array(values), list[str]()

    def note(odd: Any, reason: str, *, unused: bool = True) -> None:
        if odd.any():
            names = "" if columns is None or np.all(odd) else f" of {', '.join(np.array(columns)[odd])}"
            notes.append(f"{what}{names}: {reason}" + ("; not used" if unused else ""))
            if unused:
                found[:, odd | (columns is None)] = np.nan

    def typical(percent: float, rows: Mask | None = None) -> Floats:
        """Return a percentile of each column in some rows, NaN without them."""
        at = np.full(found.shape[1], np.nan)
        for k, known in enumerate(np.isfinite(found).T):
            own = known if rows is None else known & rows[:, k]
            if own.any():
                at[k] = np.percentile(found[own, k], percent)
        return at

    note(~np.isfinite(found).any(axis=0), "never known")
    beyond = np.abs(found) > most
    if beyond.any():
        some = int(beyond.any(axis=1).sum())
        reason = f"up to {np.nanmax(np.abs(found)):.3g}, and at most {most:.2g} can be{hint}"
        rare = some <= max(2.0, _RARE * len(found))
        found[beyond] = np.nan
        note(beyond.any(axis=0), reason + f"; {some} rows left out" if rare else reason, unused=not rare)
    first = typical(0.0)
    still = np.asarray(first == typical(100.0))
    still &= moves & (still.all() or columns is not None)
    note(still, f"always {', '.join(f'{value:.3g}' for value in first[still])} although the robot moves")
    if along is not None and np.isfinite(found).any():
        agreement = np.nansum(found * along, axis=0)
        whole = np.isfinite(found).any(axis=0)
        if agreement.sum() < 0.0:
            found, agreement = -found, -agreement
            note(whole, f"negative when the robot stands{hint}; its sign is changed", unused=False)
        elif columns is None and agreement.sum() == 0.0:
            note(whole, "the robot never stands upright: its sign is taken as that of 9.8 m/s² up", unused=False)
        if columns is not None:
            note(agreement < -_SOME * agreement.max(), "negative")
            below = found < -_SOME * np.nanmax(typical(_LARGEST))
            note(below.sum(axis=0) > _RARE * len(found), "negative in some rows, 0 there", unused=False)
    if high is not None and low is not None:
        on, off = typical(_HIGH, high), typical(_LOW, low)
        never = typical(_LARGEST) < least
        odd = (on - off < least) | np.isfinite(on) & never
        odd &= not never.all()  # otherwise it is in the air throughout
        note(odd, "in contradiction to the legs" + (": exchanged?" if odd.all() and len(odd) > 1 else ""))
    elif low is not None:
        off = typical(_LOW, low)
        shifted = np.abs(off) > least
        found -= np.where(shifted, off, 0.0)
        shown = ", ".join(f"{value:.3g}" for value in off[shifted])
        note(shifted, f"{shown} in the air, as the legs say; subtracted", unused=False)
    return found, notes
