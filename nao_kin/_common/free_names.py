"""Names beside those that are taken."""

from __future__ import annotations

import itertools
from collections.abc import Container, Iterator


def fresh_name(name: str, taken: Container[str], *endings: str) -> str:
    """The name with the first ending that makes one not taken yet; the last ending is tried with numbers, too.

    Without endings: the name itself, or with the first number from 2 on.
    """
    return next(name + ending for ending in _endless(endings or ("",)) if name + ending not in taken)


def with_underscores(name: str, taken: Container[str]) -> str:
    """The name, with as many underscores behind it as set it apart from the names taken."""
    while name in taken:
        name += "_"
    return name


def _endless(endings: tuple[str, ...]) -> Iterator[str]:
    return itertools.chain(endings, (f"{endings[-1]}_{n}" for n in itertools.count(2)))
