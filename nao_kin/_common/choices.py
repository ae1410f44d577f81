"""Arguments that are one of a few names."""

from __future__ import annotations

from collections.abc import Iterable

from nao_kin.errors import UnknownName


def choice(value: object, valid: Iterable[str], what: str, hint: str = "") -> str:
    """One of the valid names.

    Raises:
        UnknownName: none of them, or no name at all.
    """
    names = tuple(valid)
    if not isinstance(value, str) or value not in names:
        raise UnknownName(what, value, names, hint)
    return value
