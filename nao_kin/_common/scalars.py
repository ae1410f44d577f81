"""Single numbers, as people, files and programs give them."""

from __future__ import annotations

import math
import numbers
import operator
import re
from typing import SupportsIndex

from nao_kin._text import quoted
from nao_kin.errors import BadArgument

# More threads, and more searches or steps of one, are a mistake, and would never end.
MOST_THREADS, MOST_SEARCHES = 10_000, 1_000_000

_DECIMAL = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)


def decimal(text: str) -> float:
    """The number that `text` writes in decimal digits.

    Python's own `float` also takes 1_0 for 10 and digits of any script, which nobody writes on purpose.

    Raises:
        ValueError: no decimal number; "nan" and "inf" are none.
    """
    stripped = text.strip()
    if not _DECIMAL.fullmatch(stripped):
        raise ValueError(f"not a decimal number: {quoted(text)}")
    return float(stripped)


def finite_or_none(value: float) -> float | None:
    """`value` for JSON, which has no infinity: None for what is not there, such as a limit."""
    return value if math.isfinite(value) else None


def whole_number(value: SupportsIndex, what: str, least: int, most: int | None = None) -> int:
    """`value` as an int that is at least `least`, and at most `most` where that is given.

    Raises:
        BadArgument: no whole number, or one out of range.
    """
    try:
        number = operator.index(value)
    except TypeError:
        raise BadArgument(f"{what} must be a whole number, got {quoted(value)}") from None
    if number >= least and (most is None or number <= most):
        return number
    # Python refuses to write out numbers of thousands of digits.
    given = str(number) if number.bit_length() <= 256 else f"one of {number.bit_length()} bits"
    raise BadArgument(f"{what} must be {f'at least {least}' if number < least else f'at most {most}'}, got {given}")


def check_tolerance(tolerance: object, what: str = "tolerance") -> None:
    """Refuse anything but one number ≥ 0.

    Raises:
        BadArgument: no real number, NaN, or a negative one.
    """
    try:
        fine = isinstance(tolerance, numbers.Real) and float(tolerance) >= 0.0
    except OverflowError:
        fine = False
    if not fine:
        raise BadArgument(f"{what} must be a number ≥ 0, got {quoted(tolerance)}")
