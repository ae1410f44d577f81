"""Names that no two parts of a robot share."""

from __future__ import annotations

import itertools
from collections.abc import Container, Iterable, Iterator

from nao_kin._text import quoted


def names_apart(links: Iterable[str], joints: Iterable[str], notes: list[str]) -> dict[str, str]:
    """New names for links that share theirs with a joint: "…_link", or "…_frame" where that is taken.

    Args:
        links: names of the links.
        joints: names of the joints.
        notes: gets a line for each.
    """
    links, joints = tuple(links), frozenset(joints)
    taken = joints.union(links)
    renamed: dict[str, str] = {}
    for name in links:
        if name in joints:
            renamed[name] = fresh_name(name, taken, "_link", "_frame")
            notes.append(f"link {quoted(name)} renamed {quoted(renamed[name])}: a joint has the same name")
    return renamed


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
