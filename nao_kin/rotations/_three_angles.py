"""The 24 three-angle conventions, and their kernels: three turns composed, and taken apart again.

A convention is one of 12 sequences of axes, turned about moving or fixed axes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

from nao_kin._common.kernels import Functions, Kernel, Number
from nao_kin.errors import BadArgument, UnknownName

Axes = Literal["moving", "fixed"]
AtLock = Literal["first", "third"]

SEQUENCES = tuple(a + b + c for a in "xyz" for b in "xyz" for c in "xyz" if a != b != c)

# Sequences of one or two axes: turns that do not reach every rotation.
SHORT_SEQUENCES = (*"xyz", *(a + b for a in "xyz" for b in "xyz" if a != b))

# Below this the two matrix entries that tell the first angle from the third are rounding errors of the matrix.
LOCK = 4.0 * 2.0**-52

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
        short = isinstance(sequence, str) and sequence in SHORT_SEQUENCES
        raise _unknown_sequence(sequence, SEQUENCES, "`nearest_euler` takes one or two axes" if short else "")
    raise _unknown_axes(axes)


def find_any_convention(sequence: str, axes: Axes) -> tuple[Convention, int]:
    """As `find_convention`, and the number of angles: of one or two axes, a convention whose other angles are zero."""
    count = len(sequence) if isinstance(sequence, str) else 0
    if isinstance(sequence, str) and sequence in SHORT_SEQUENCES:
        rest = "".join(axis for axis in "xyz" if axis not in sequence)
        return find_convention((sequence + rest)[:3], axes), count
    if not isinstance(sequence, str) or sequence not in SEQUENCES:
        raise _unknown_sequence(sequence, (*SEQUENCES, *SHORT_SEQUENCES))
    return find_convention(sequence, axes), count


def find_short_sequence(sequence: str, axes: Axes) -> tuple[int, ...]:
    """The one or two axes as numbers, in the order in which moving axes make the same turns."""
    if not isinstance(sequence, str) or sequence not in SHORT_SEQUENCES:
        full = isinstance(sequence, str) and sequence in SEQUENCES
        raise _unknown_sequence(sequence, SHORT_SEQUENCES, "`euler_from_matrix` takes three axes" if full else "")
    if not isinstance(axes, str) or axes not in ("moving", "fixed"):
        raise _unknown_axes(axes)
    places = tuple("xyz".index(axis) for axis in sequence)
    return places if axes == "moving" else places[::-1]


def _unknown_sequence(sequence: object, valid: tuple[str, ...], hint: str = "") -> UnknownName:
    if isinstance(sequence, str) and sequence.lower() in valid:
        hint = "letter case carries no meaning: write it in lower case and say axes='moving' or axes='fixed'"
    return UnknownName("sequence", sequence, valid, hint)


def _unknown_axes(axes: object) -> BadArgument | UnknownName:
    if axes is None:
        return BadArgument("axes= must be given: 'moving' (turns about the axes carried along) or 'fixed'")
    return UnknownName("axes", axes, ("moving", "fixed"))


def check_at_lock(at_lock: AtLock) -> None:
    """Refuse anything but the two tie-breaks."""
    if not isinstance(at_lock, str) or at_lock not in ("first", "third"):
        raise UnknownName("at_lock", at_lock, ("first", "third"))


def composition(convention: Convention) -> Kernel:
    """The kernel (α, β, γ in the order written) → the nine entries of R."""
    i, j, k, s = convention.i, convention.j, convention.k, convention.sign

    def kernel(f: Functions, *angles: Number) -> tuple[Number, ...]:
        first, middle, third = angles[::-1] if convention.reversed else angles
        # An odd permutation of the axes mirrors space, in which every angle changes its sign.
        ca, sa = f.cos(first), s * f.sin(first)
        cb, sb = f.cos(middle), s * f.sin(middle)
        cc, sc = f.cos(third), s * f.sin(third)
        m: list[Number] = [0.0] * 9
        if convention.symmetric:
            m[3 * i + i], m[3 * i + j], m[3 * i + k] = cb, sb * sc, sb * cc
            m[3 * j + i], m[3 * k + i] = sa * sb, 0.0 - ca * sb
            u, v = ca * cb, sa * cb
            m[3 * j + j], m[3 * j + k] = ca * cc - v * sc, 0.0 - ca * sc - v * cc
            m[3 * k + j], m[3 * k + k] = sa * cc + u * sc, u * cc - sa * sc
        else:
            m[3 * i + i], m[3 * i + j], m[3 * i + k] = cb * cc, 0.0 - cb * sc, sb
            m[3 * j + k], m[3 * k + k] = 0.0 - sa * cb, ca * cb
            u, v = ca * sb, sa * sb
            m[3 * j + i], m[3 * j + j] = ca * sc + v * cc, ca * cc - v * sc
            m[3 * k + i], m[3 * k + j] = sa * sc - u * cc, sa * cc + u * sc
        return tuple(m)

    return kernel


def extraction(convention: Convention, third_is_zero: bool) -> Kernel:
    """The kernel from nine entries to both triples and the lock mask; `third_is_zero` speaks of moving axes."""
    i, j, k, s = convention.i, convention.j, convention.k, convention.sign
    positive = s > 0.0

    def signed(value: Number) -> Number:
        # Adding 0.0 turns −0.0 into 0.0, which keeps atan2 off −π.
        return 0.0 + value if positive else 0.0 - value

    def kernel(f: Functions, *m: Number) -> tuple[Number, ...]:
        if convention.symmetric:
            y, x = 0.0 + m[3 * j + i], m[3 * k + i] * -s
        else:
            y, x = 0.0 - signed(m[3 * j + k]), m[3 * k + k]
        h = f.sqrt(x * x + y * y)
        locked = h <= LOCK
        some_locked = f.some(locked)
        if some_locked:
            x = f.where(locked, m[3 * j + j] if third_is_zero else 1.0, x)
            y = f.where(locked, signed(m[3 * k + j]) if third_is_zero else 0.0, y)
        first = f.atan2(y, x)
        # (x, y) is h (cos, sin) of the first angle: turning it out needs no division, for atan2 is blind to scale.
        y = signed(y)
        cosine = x * m[3 * j + j] + y * m[3 * k + j]
        if convention.symmetric:
            middle = f.atan2(h, m[3 * i + i])
            third = f.atan2(0.0 - signed(x * m[3 * j + k] + y * m[3 * k + k]), cosine)
            other_middle = 0.0 - middle
        else:
            middle = f.atan2(signed(m[3 * i + k]), h)
            third = f.atan2(signed(x * m[3 * j + i] + y * m[3 * k + i]), cosine)
            other_middle = f.where(middle < 0.0, -math.pi, math.pi) - middle
        if some_locked and third_is_zero:
            third = f.where(locked, 0.0, third)
        other_first, other_third = _opposite(f, first), _opposite(f, third)
        if convention.reversed:
            first, third, other_first, other_third = third, first, other_third, other_first
        return first, middle, third, other_first, other_middle, other_third, locked

    return kernel


def _opposite(f: Functions, angle: Number) -> Number:
    return angle + f.where(angle > 0.0, -math.pi, math.pi)
