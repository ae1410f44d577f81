"""The points of a source: those in a fixed order, a row of `layouts.toml` each, and the rule for names in any naming.

A name has a side and a part, in any order and spelling: LeftForeArm, lForeArm, LowerArm_L, elbow.l, Bip01 L Forearm,
WRIST_LEFT, LELB. The side is a word (left, right, l, r), or is run together with a known part. What remains, or its
last words, must be one of the words that `layouts.toml` lists for a part, the preferred one first: where a file has
LeftArm, its LeftShoulder is a clavicle.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats, as_floats, choice
from nao_kin._core.files import read_toml
from nao_kin._core.text import abbreviated, nearest_names
from nao_kin.errors import BadArgument, UnknownName, WrongShape

SIDES = ("left_", "right_")
LIMBS = (("shoulder", "elbow", "wrist"), ("hip", "knee", "ankle"))
_TRUNK = ("pelvis", "chest", "neck", "head", "nose")
_PAIRS = ("eye", "ear", "shoulder", "elbow", "wrist", "hand", "finger", "thumb", "hip", "knee", "ankle", "toe")
POINTS = (*_TRUNK, *(side + part for part in _PAIRS for side in SIDES))
# The middle of two points stands for a third one that a source does not have.
_MIDDLES = {"pelvis": "hip", "neck": "shoulder", "head": "ear"}
# Parts of animals.
_ANIMAL = ("tail", "paw", "wing", "hoof", "snout", "muzzle")

_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|[0-9]+")


TABLES = read_toml(Path(__file__).with_name("layouts.toml"))
# Part → words, the preferred one first; all of them; and word → side, longer words first.
_WORDS: dict[str, tuple[str, ...]] = {part: tuple(text.split()) for part, text in TABLES["words"].items()}
_KNOWN = {word for words in _WORDS.values() for alternative in words for word in alternative.split("+")}
_SIDE_WORDS = {word: f"{side}_" for side, text in TABLES["sides"].items() for word in text.split()}


def key_of(name: str) -> str:
    """Return a name without the differences that do not count: letter case, blanks and signs."""
    return "".join(c for c in name.lower() if c.isalnum())


@lru_cache(maxsize=4096)
def side_and_word(name: str) -> tuple[str, str]:
    """Return the side of a joint, "left_", "right_" or "", and the known word for its part, with its number.

    Without a known word, both are empty.
    """
    words = [word.lower().lstrip("0") or "0" for word in _WORD.findall(name)]
    at = next((k for k, word in enumerate(words) if word in _SIDE_WORDS), None)
    side = "" if at is None else _SIDE_WORDS[words.pop(at)]
    for start in range(len(words)):
        key = "".join(words[start:])
        if _is_known(key):
            return side, key
        for word, other in _SIDE_WORDS.items() if not side else ():
            for rest in (key.removeprefix(word), key.removesuffix(word)):
                if rest != key and _is_known(rest):
                    return other, rest
    return "", ""


def _is_known(key: str) -> bool:
    return key in _KNOWN or key.rstrip("0123456789") in _KNOWN


@lru_cache(maxsize=64)
def resolved(joints: tuple[str, ...]) -> dict[str, tuple[str, ...]]:
    """Return name of `POINTS` → the joint, or the joints whose mean it is, by the rule for names."""
    at: dict[tuple[str, str], str] = {}
    keys = {joint: side_and_word(joint) for joint in joints}
    for exact in (True, False):
        for joint, (side, word) in keys.items():
            if word:
                at.setdefault((side, word if exact else word.rstrip("0123456789")), joint)
    found: dict[str, tuple[str, ...]] = {}
    used: set[str] = set()
    for part, words in _WORDS.items():
        for side in SIDES if part in _PAIRS else ("",):
            for word in words:
                parts = tuple(at.get((side, one), "") for one in word.split("+"))
                if all(parts) and not used & {*parts}:
                    found[side + part] = parts
                    used.update(parts)
                    break
    for name, part in _MIDDLES.items():
        if name not in found and all(side + part in found for side in SIDES):
            found[name] = (*found["left_" + part], *found["right_" + part])
    return found


@dataclass(frozen=True, eq=False)
class Layout:
    """A row of `layouts.toml`: the points of a source in their order, or any points with names."""

    name: str
    order: str = ""
    endings: Sequence[str] = ("",)
    axes: Sequence[str] | None = None
    levels: float = 1.0
    unit: str | None = None
    rate: float | None = None
    reference: str = ""
    stated: Mapping[str, str] | None = None  # name of `POINTS` → joint of the file, or "a + b"

    @cached_property
    def orders(self) -> tuple[tuple[str, ...], ...]:
        """The orders of the points of an array; several, if it may have several lengths."""
        return tuple((*self.order.split(), *ending.split()) for ending in self.endings if self.order)

    def order_of(self, count: int) -> tuple[str, ...]:
        """Return the order of an array of so many points; none if the source has no such array."""
        return next((order for order in self.orders if len(order) == count), ())

    def resolved(self, joints: Iterable[str]) -> dict[str, tuple[str, ...]]:
        """Return name → the joint, or the joints, whose mean it is, for all points that the joints give."""
        joints = tuple(joints)
        found = resolved(joints)
        if self.stated:
            by_key = {key_of(joint): joint for joint in joints}
            found = found | {
                name: tuple(by_key[key_of(part)] for part in text.split("+")) for name, text in self.stated.items()
            }
        return found


LAYOUTS = {name: Layout(name, **row) for name, row in TABLES["layouts"].items()}


def layout_of(joints: Sequence[str]) -> Layout:
    """Return the layout whose names the joints have, the one that they fill most; else one of names alone."""
    keys = {key_of(joint) for joint in joints}
    best, most = Layout("names"), 0.0
    for layout in LAYOUTS.values():
        for order in layout.orders:
            share = len(keys) / len(order)
            if most < share <= 1.0 and keys <= {key_of(joint) for joint in order}:
                best, most = layout, share
    return best


def check_names(names: Mapping[str, str], joints: Sequence[str]) -> None:
    """Raise UnknownName unless names are name of `POINTS` → joint, or "a + b"."""
    for name, joint in names.items():
        choice(name, POINTS, "point")
        for part in str(joint).split("+"):
            if key_of(part) not in map(key_of, joints):
                raise UnknownName(f"joint for {name}", part.strip(), joints)


def check_shoulders(found: Mapping[str, tuple[str, ...]], joints: Sequence[str]) -> None:
    """Raise BadArgument, with what the joints seem to be, unless both shoulders are among the points found."""
    lacking = [side + "shoulder" for side in SIDES if side + "shoulder" not in found]
    if not lacking:
        return
    parts = [joint for joint in joints if any(word in key_of(joint) for word in _ANIMAL)]
    arms = any(side + part in found for side in SIDES for part in ("elbow", "wrist"))
    what = f"an animal's ({abbreviated(', '.join(parts))}): " if parts else "" if arms else "no arms: "
    near = nearest_names(lacking[0], joints)
    advice = f"nearest: {', '.join(near)}" if near else f"joints: {abbreviated(', '.join(joints))}"
    lack = f"{what}no {' and no '.join(lacking)} under a known name ({advice})"
    raise BadArgument(f"{lack}; names= (--names) states names")


def shown_joints(layout: Layout, joints: Sequence[str]) -> str:
    """Return the joints of the left limbs, for a note; raise BadArgument if there are no shoulders."""
    found = layout.resolved(joints)
    check_shoulders(found, joints)
    parts = [part for part in ("shoulder", "elbow", "wrist", "hip", "knee", "ankle") if "left_" + part in found]
    return ", ".join(f"{part} {' + '.join(found['left_' + part])}" for part in parts)


# --- Arrays of points.


def landmark_array(landmarks: Any, layout: Layout) -> Floats:
    """Return checked points in the order of a source, shape (n, k, 3 or 4)."""
    array = as_floats(landmarks, (), "landmarks", gaps=True)
    if array.ndim == 2:
        array = array[None]
    if array.ndim != 3 or not layout.order_of(array.shape[1]) or array.shape[2] not in (3, 4) or not len(array):
        flat = "; two coordinates give no directions" if array.shape[-1:] == (2,) else ""
        counts = ", ".join(str(len(order)) for order in layout.orders)
        raise WrongShape("landmarks", f"(n, {counts}, 3 or 4) for {layout.name}{flat}", array.shape)
    return array


def by_joint(array: Floats, layout: Layout) -> tuple[dict[str, Floats], dict[str, Floats]]:
    """Return `by_order` of points in the order of a source."""
    return by_order(array, layout.order_of(array.shape[1]))


def by_order(array: Floats, order: Sequence[str]) -> tuple[dict[str, Floats], dict[str, Floats]]:
    """Return joint → places (n, 3), and → confidence (n,), if it is given, of points (n, k, 3 or 4)."""
    places = dict(zip(order, np.moveaxis(array[..., :3], 1, 0), strict=True))
    return places, dict(zip(order, array[..., 3].T, strict=True)) if array.shape[2] == 4 else {}
