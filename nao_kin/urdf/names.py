"""Names that no two parts of a robot share."""

from __future__ import annotations

from collections.abc import Iterable

from nao_kin._common.free_names import fresh_name
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
