"""Names, times, keys and handles as they are given to a motion, made into read-only columns or refused."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats, all_finite, as_floats, as_numbers
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument, NotFinite, WrongShape

# A handle that leaves its segment by no more than rounding, or by what single precision makes of it.
_HANDLE_ROUNDING = 1e-6

# No joint is there, and products of three such numbers are still numbers.
_LARGEST = 1e100

Columns = tuple[Floats, ...]


def checked_names(names: Any) -> tuple[str, ...]:
    """The joint names of a motion.

    Raises:
        BadArgument: none, one that is no text, or one twice.
    """
    if isinstance(names, str) or not isinstance(names, Iterable):
        raise BadArgument(f"joint_names must be a list of names, got {quoted(names)}")
    found = tuple(names)
    if not found:
        raise BadArgument("a motion needs at least one joint, got no joint_names")
    seen = set[str]()
    for index, name in enumerate(found):
        if not isinstance(name, str) or not name:
            raise BadArgument(f"joint_names must be texts, got {quoted(name)} at index [{index}]")
        if name in seen:
            raise BadArgument(f"joint_names has {quoted(name)} twice, again at index [{index}]")
        seen.add(name)
    return found


def checked_times(times: Any, names: tuple[str, ...]) -> tuple[Columns, bool]:
    """The times of each joint, and whether one list was given for all.

    Raises:
        BadArgument: none, or not ascending.
        WrongShape, NotFinite: no finite numbers of the right shape.
    """
    rows = _rows(times, "times")
    if _is_single(rows[0]):
        column = _checked_column(times if isinstance(times, np.ndarray) else rows, "times")
        _check_ascending(column, "times")
        return (column,) * len(names), True
    if len(rows) != len(names):
        raise BadArgument(f"times must have one list for each of {len(names)} joints, got {len(rows)}")
    columns = list[Floats]()
    for index, (name, row) in enumerate(zip(names, rows, strict=True)):
        if index and row is rows[index - 1]:
            columns.append(columns[-1])
            continue
        column = _checked_column(row, f"times of {name}")
        _check_ascending(column, f"times of {name}")
        # Joints of equal times share one array, so that places in it are looked up once.
        columns.append(columns[-1] if index and np.array_equal(column, columns[-1]) else column)
    return tuple(columns), False


def checked_keys(keys: Any, names: tuple[str, ...], times: Columns, *, shared: bool) -> Columns:
    """The keys of each joint.

    Args:
        keys: a row for each time where times are `shared`, else a list for each joint.
        names: the joints.
        times: of each joint.
        shared: one list of times was given for all.

    Raises:
        BadArgument, WrongShape, NotFinite: no finite numbers, or not one for each time.
    """
    if shared:
        array = as_numbers(keys, "keys")
        if array.ndim == 1 and len(names) == 1:
            array = array[:, None]
        wanted = (len(times[0]), len(names))
        if array.shape != wanted:
            hint = "; a list for each joint goes with times for each joint" if array.shape == wanted[::-1] else ""
            raise WrongShape("keys", f"{wanted}, a row for each time{hint}", array.shape)
        if not all_finite(array):
            row, column = np.argwhere(~np.isfinite(array))[0].tolist()
            raise NotFinite("keys", (row, column), float(array[row, column]), names[column])
        _check_size(array, "keys")
        # One row for each joint in memory.
        return tuple(np.array(array.T, order="C"))
    rows = _rows(keys, "keys")
    if len(rows) != len(names):
        raise BadArgument(f"keys must have one list for each of {len(names)} joints, got {len(rows)}")
    columns = []
    for name, row, column in zip(names, rows, times, strict=True):
        values = _checked_column(row, f"keys of {name}")
        if len(values) != len(column):
            raise BadArgument(f"{name} has {len(column)} times and {len(values)} keys; expected one for each")
        columns.append(values)
    return tuple(columns)


def checked_handles(handles: Any, names: tuple[str, ...], times: Columns, interpolation: str) -> Columns:
    """The handles of each joint, shape (k, 2, 2).

    Raises:
        BadArgument: with another interpolation, for other joints, or leaving their segment in time.
        WrongShape, NotFinite: no finite numbers of that shape.
    """
    if interpolation != "bezier":
        raise BadArgument(f"handles belong to bezier interpolation, got {interpolation}")
    rows = _rows(handles, "handles")
    if len(rows) != len(names):
        raise BadArgument(f"handles must have one array for each of {len(names)} joints, got {len(rows)}")
    columns = []
    for name, row, column in zip(names, rows, times, strict=True):
        values = np.array(as_floats(row, (), f"handles of {name}"))
        if values.shape != (len(column), 2, 2):
            raise WrongShape(f"handles of {name}", f"({len(column)}, 2, 2)", values.shape)
        _check_size(values, f"handles of {name}")
        _check_within(values, column, name)
        columns.append(values)
    return tuple(columns)


def _check_within(handles: Floats, times: Floats, name: str) -> None:
    """Refuse handles that leave the segment beside their key in time; the outermost may have any length."""
    widths = np.diff(times)
    room = [np.concatenate([[np.inf], widths]), np.concatenate([widths, [np.inf]])]
    for side, (word, sign) in enumerate((("before", -1.0), ("after", 1.0))):
        length = sign * handles[:, side, 0]
        slack = _HANDLE_ROUNDING * np.where(np.isfinite(room[side]), room[side], 1.0)
        wrong = (length < -slack) | (length > room[side] + slack)
        if wrong.any():
            key = int(np.argmax(wrong))
            offset = float(handles[key, side, 0])
            least, most = (-room[side][key], 0.0) if side == 0 else (0.0, room[side][key])
            raise BadArgument(
                f"{name}: the handle {word} key {key} is {offset:.9g} s from it, expected between {least:.9g} and "
                f"{most:.9g} s: within the segment"
            )


def check_speeds(names: tuple[str, ...], times: Columns, keys: Columns) -> None:
    """Refuse keys so far apart, or times so near, that the speed between them is no floating-point number."""
    for name, column, values in zip(names, times, keys, strict=True):
        with np.errstate(over="ignore"):
            fine = np.isfinite(np.diff(values) / np.diff(column))
        if not fine.all():
            key = int(np.argmin(fine))
            gap = column[key + 1] - column[key]
            raise BadArgument(
                f"{name} moves from {values[key]:g} to {values[key + 1]:g} in {gap:g} s after key {key}: "
                "no speed that floating point can hold"
            )


def out_of_order(times: Floats) -> tuple[int, str] | None:
    """The first of some times that does not come after the one before it, and how it stands to that; None for none."""
    ascends = np.diff(times) > 0.0
    if ascends.all():
        return None
    key = int(np.argmin(ascends)) + 1
    return key, "the same as" if times[key] == times[key - 1] else "before"


def _check_ascending(times: Floats, what: str) -> None:
    wrong = out_of_order(times)
    if wrong is not None:
        key, word = wrong
        raise BadArgument(
            f"{what} must ascend: {times[key]:.9g} s at index [{key}] is {word} {times[key - 1]:.9g} s at [{key - 1}]"
        )


def _checked_column(values: Any, what: str) -> Floats:
    array = np.array(as_floats(values, (), what))
    if array.ndim != 1:
        raise WrongShape(what, "(k,)", array.shape)
    if len(array) == 0:
        raise BadArgument(f"{what} must have at least one key, got none")
    _check_size(array, what)
    return array


def _check_size(values: Floats, what: str) -> None:
    """Refuse numbers with which floating point cannot compute."""
    far = np.abs(values) > _LARGEST
    if far.any():
        raise BadArgument(f"{what} must be at most {_LARGEST:g} in size, got {float(values[far][0]):g}")


def _rows(values: Any, what: str) -> list[Any]:
    """The entries of a list; of one array of numbers, only the first."""
    if isinstance(values, (str, bytes)) or not isinstance(values, Iterable):
        raise BadArgument(f"{what} must be a list, got {quoted(values)}")
    array = values if isinstance(values, np.ndarray) and values.ndim < 2 else None
    rows = list(values if array is None else array.reshape(-1)[:1])
    if not rows:
        raise BadArgument(f"{what} must have at least one entry, got none")
    return rows


def _is_single(value: Any) -> bool:
    if isinstance(value, np.ndarray):
        return value.ndim == 0
    return isinstance(value, (str, bytes)) or not isinstance(value, Iterable)
