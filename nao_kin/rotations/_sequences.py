"""The 24 three-angle conventions: 12 sequences of axes, turned about moving or fixed axes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from nao_kin.errors import BadArgument, UnknownName

Axes = Literal["moving", "fixed"]
AtLock = Literal["first", "third"]

SEQUENCES = tuple(a + b + c for a in "xyz" for b in "xyz" for c in "xyz" if a != b != c)

# The default of `axes=`: the keyword is required, and its absence is answered with the library's own error.
REQUIRED: Any = None


@dataclass(frozen=True)
class Convention:
    """One of the 24 conventions as a sequence about moving axes i, j, then i or the remaining axis k.

    Attributes:
        i, j, k: the axes as numbers; k is the one that is neither i nor j.
        sign: +1 where (i, j, k) is an even permutation of (x, y, z), −1 where it is odd.
        symmetric: whether the third turn is about i again (proper Euler angles).
        reversed: whether the angles are given in the opposite order (fixed axes).
    """

    i: int
    j: int
    k: int
    sign: float
    symmetric: bool
    reversed: bool


def _convention(sequence: str, axes: str) -> Convention:
    # Turns about fixed axes are the same turns about moving axes in the opposite order.
    i, j, third = ("xyz".index(axis) for axis in (sequence if axes == "moving" else sequence[::-1]))
    return Convention(i, j, 3 - i - j, 1.0 if (j - i) % 3 == 1 else -1.0, third == i, axes == "fixed")


_CONVENTIONS = {(s, axes): _convention(s, axes) for s in SEQUENCES for axes in ("moving", "fixed")}


def find_convention(sequence: str, axes: Axes) -> Convention:
    """The convention of that name; anything that is not exactly one of the 24 is refused."""
    if isinstance(sequence, str) and isinstance(axes, str):
        found = _CONVENTIONS.get((sequence, axes))
        if found is not None:
            return found
    if not isinstance(sequence, str) or sequence not in SEQUENCES:
        spelling = isinstance(sequence, str) and sequence.lower() in SEQUENCES
        hint = "letter case carries no meaning: write it in lower case and say axes='moving' or axes='fixed'"
        raise UnknownName("sequence", sequence, SEQUENCES, hint if spelling else "")
    if axes is None:
        raise BadArgument("axes= must be given: 'moving' (turns about the axes carried along) or 'fixed'")
    raise UnknownName("axes", axes, ("moving", "fixed"))


def check_at_lock(at_lock: AtLock) -> None:
    """Refuse anything but the two tie-breaks."""
    if not isinstance(at_lock, str) or at_lock not in ("first", "third"):
        raise UnknownName("at_lock", at_lock, ("first", "third"))
