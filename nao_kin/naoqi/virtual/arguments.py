"""Read the arguments that scripts send over NAOqi: numbers, flags, names, and one entry or list for each joint.

A method of a service states the kinds of its arguments as annotations, such as `Share`; a kind is a type and the
function that reads a value, given the argument's name.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Annotated, Any

import numpy as np

from nao_kin._core.arrays import Floats, as_floats, choice as valid_name, shaped
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument, NotFinite


def number(value: object, what: str) -> float:
    """Return one finite number."""
    if not isinstance(value, (bool, int, float, np.integer, np.floating)):
        raise BadArgument(f"{what} must be a number, got {quoted(value, 60)}")
    if not math.isfinite(value):
        raise NotFinite(what, (), float(value))
    return float(value)


def fraction(value: object, what: str, *, positive: bool = False) -> float:
    """Return a number from 0 to 1; with `positive`, above 0."""
    result = number(value, what)
    if not (0.0 <= result <= 1.0) or (positive and result == 0.0):
        raise BadArgument(f"{what} must be {'above 0 and at most' if positive else 'between 0 and'} 1, got {result:g}")
    return result


def duration(value: object, what: str, *, zero: bool = False) -> float:
    """Return a positive number of seconds; with `zero`, zero too."""
    result = number(value, what)
    if result < 0.0 or (result == 0.0 and not zero):
        raise BadArgument(f"{what} must be {'at least' if zero else 'above'} 0 s, got {result:g} s")
    return result


def flag(value: object, what: str) -> bool:
    """Return True or False; 1 and 0 are accepted."""
    if isinstance(value, (bool, np.bool_)) or (isinstance(value, (int, float)) and value in (0, 1)):
        return bool(value)
    raise BadArgument(f"{what} must be True or False, got {quoted(value, 60)}")


def whole(value: object, what: str) -> int:
    """Return a whole number; 2.0 is accepted."""
    result = number(value, what)
    if not result.is_integer():
        raise BadArgument(f"{what} must be a whole number, got {result:g}")
    return int(result)


def text(value: object, what: str) -> str:
    """Return a text."""
    if isinstance(value, str):
        return value
    raise BadArgument(f"{what} must be a text, got {quoted(value, 60)}")


def choice(value: object, what: str, valid: Sequence[str]) -> str:
    """Return one of the valid names."""
    return valid_name(text(value, what), valid, what)


def one_of(what: str, valid: Sequence[str]) -> Callable[[object, str], str]:
    """Return a function that reads one of the valid names, which messages call `what`."""
    return lambda value, _: choice(value, what, valid)


def is_list(value: object) -> bool:
    """Return whether NAOqi treats the value as a list: a list, a tuple or an array."""
    return isinstance(value, (list, tuple, np.ndarray))


def entries(value: Any, what: str, count: int | None = None) -> list[Any]:
    """Return the entries of a list, of the given length if there is one."""
    if not is_list(value):
        raise BadArgument(f"{what} must be a list{'' if count is None else f' of {count}'}, got {quoted(value, 60)}")
    if count is not None and len(value) != count:
        raise BadArgument(f"{what} must be a list of {count}, got {len(value)}")
    return list(value)


def pairs(value: Any, what: str) -> list[tuple[str, Any]]:
    """Return the names and values of a list of [name, value], or of a map."""
    rows = list(value.items()) if isinstance(value, Mapping) else value
    if not is_list(rows) or not all(is_list(row) and len(row) == 2 and isinstance(row[0], str) for row in rows):
        raise BadArgument(f"{what} must be a list of [name, value] pairs, got {quoted(value, 60)}")
    return [(name, entry) for name, entry in rows]


def three(value: Any, what: str) -> Floats:
    """Return three numbers, shape (3,)."""
    return np.array(shaped(value, (3,), what))


# The kinds of arguments.
Number = Annotated[float, number]
Whole = Annotated[int, whole]
Flag = Annotated[bool, flag]
Text = Annotated[str, text]
Fraction = Annotated[float, fraction]  # from 0 to 1
Share = Annotated[float, partial(fraction, positive=True)]  # above 0, at most 1
Duration = Annotated[float, duration]  # above 0 [s]
Delay = Annotated[float, partial(duration, zero=True)]  # at least 0 [s]
Point = Annotated[Floats, three]
Entries = Annotated[list[Any], entries]


def one_each(value: Any, joints: Sequence[str], what: str) -> Floats:
    """Return one number for each joint, shape (joints,), from a number for all or a list of one for each."""
    if not is_list(value):
        return np.full(len(joints), number(value, what))
    values = _numbers(value, what)
    if len(values) != len(joints):
        raise BadArgument(f"{what} must be one number or {_one_for_each(joints)}, got {len(values)}")
    return values


def list_each(value: Any, joints: Sequence[str], what: str) -> tuple[Floats, ...]:
    """Return a list of numbers for each joint, of any lengths.

    NAOqi accepts one number for all joints, a list of one number for each, and a list of one list for each; for a
    single joint also just its list.
    """
    if not is_list(value):
        return (np.full(1, number(value, what)),) * len(joints)
    if len(joints) == 1 and not any(map(is_list, value)):
        value = [value]
    if len(value) != len(joints):
        raise BadArgument(
            f"{what} must be one number or list for each joint, {_one_for_each(joints)}, got {len(value)}"
        )
    lists = []
    for joint, entry in zip(joints, value, strict=True):
        of = f"{what} of {joint}"
        lists.append(_numbers(entry, of) if is_list(entry) else np.full(1, number(entry, of)))
        if not len(lists[-1]):
            raise BadArgument(f"{of} must not be empty")
    return tuple(lists)


def check_times(times: Sequence[Floats], joints: Sequence[str]) -> None:
    """Refuse times that are not positive and ascending."""
    for joint, row in zip(joints, times, strict=True):
        if row[0] <= 0.0:
            raise BadArgument(f"times of {joint} must be above 0 s, got {row[0]:g} s")
        steps = np.diff(row)
        if not (steps > 0.0).all():
            at = int(np.argmin(steps > 0.0))
            raise BadArgument(f"times of {joint} must ascend, got {row[at]:g} s and then {row[at + 1]:g} s")


def timed(values: Any, times: Any, joints: Sequence[str], what: str) -> tuple[tuple[Floats, ...], tuple[Floats, ...]]:
    """Return each joint's values and their times, read by `list_each`: one time for each value, positive, ascending."""
    rows, when = list_each(values, joints, what), list_each(times, joints, "times")
    check_lengths(rows, when, joints, what)
    check_times(when, joints)
    return rows, when


def check_lengths(lists: Sequence[Floats], times: Sequence[Floats], joints: Sequence[str], what: str) -> None:
    """Refuse joints with more values than times, or fewer."""
    for joint, row, at in zip(joints, lists, times, strict=True):
        if len(row) != len(at):
            raise BadArgument(f"{joint} has {len(row)} {what} and {len(at)} times; there must be one time for each")


def _numbers(value: Any, what: str) -> Floats:
    array = np.array(as_floats(value, (), what))
    if array.ndim != 1:
        raise BadArgument(f"{what} must be a list of numbers, got {quoted(value, 60)}")
    return array


def _one_for_each(joints: Sequence[str]) -> str:
    named = ", ".join(joints) if len(joints) <= 4 else f"{joints[0]} … {joints[-1]}"
    return f"{len(joints)} for {named}"
