"""Arguments that are one of a few names, names, or true or false."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from nao_kin._text import quoted
from nao_kin.errors import BadArgument, UnknownName


def choice(value: object, valid: Iterable[str], what: str, hint: str = "") -> str:
    """One of the valid names.

    Raises:
        UnknownName: none of them, or no name at all.
    """
    names = tuple(valid)
    if not isinstance(value, str) or value not in names:
        raise UnknownName(what, value, names, hint)
    return value


def flag(value: object, what: str) -> bool:
    """True or False as it is: every other text is true to Python, and an array neither.

    Raises:
        BadArgument: neither.
    """
    if not isinstance(value, (bool, np.bool_)):
        raise BadArgument(f"{what} must be True or False, got {quoted(value)}")
    return bool(value)


def texts(values: object, what: str) -> tuple[str, ...]:
    """Several texts, as in a list.

    Raises:
        BadArgument: one text, or something else in their place or among them.
    """
    if isinstance(values, str) or not isinstance(values, Iterable):
        raise BadArgument(f"{what} must be a list of texts, got {quoted(values)}")
    found = tuple(values)
    for value in found:
        if not isinstance(value, str):
            raise BadArgument(f"{what} must be texts, got {quoted(value)}")
    return found
