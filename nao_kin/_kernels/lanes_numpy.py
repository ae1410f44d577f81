"""Vectors of one register's width in NumPy: defines the functions of `lanes`, and runs when nothing is compiled."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

BITS = 512

Array = NDArray[Any]
Lanes = NDArray[Any]


def lane_count(m: Array) -> int:
    """The number of entries of an array of this kind in one vector."""
    itemsize: int = m.itemsize
    return BITS // (8 * itemsize)


def load(m: Array, at: int) -> Lanes:
    """The vector that starts at m[at]."""
    return np.array(m[at : at + lane_count(m)])


def store(m: Array, at: int, v: Lanes) -> None:
    """Write a vector to m[at] and the following entries."""
    m[at : at + len(v)] = v


def spread(m: Array, value: float) -> Lanes:
    """A vector of the kind of `m` with one number in every lane."""
    return np.full(lane_count(m), value, dtype=m.dtype)


def square_root(v: Lanes) -> Lanes:
    """The root in every lane."""
    return np.sqrt(v)


def nearest(v: Lanes) -> Lanes:
    """The nearest whole number in every lane."""
    return np.rint(v)


def whole(v: Lanes) -> Lanes:
    """Whole numbers as integers."""
    return v.astype(np.int64 if v.itemsize == 8 else np.int32)


def following(k: Lanes) -> Lanes:
    """K + 1 in every lane of integers."""
    return k + 1


def with_sign(v: Lanes, sign: Lanes) -> Lanes:
    """The magnitude of one with the sign of the other."""
    return np.copysign(v, sign)


def where_less(a: Lanes, b: Lanes, yes: Lanes, no: Lanes) -> Lanes:
    """In every lane `yes` where a < b, else `no`."""
    return np.where(a < b, yes, no)


def where_even(k: Lanes, yes: Lanes, no: Lanes) -> Lanes:
    """In every lane `yes` where the integer k is even, else `no`."""
    return np.where(k & 1 == 0, yes, no)


def negated_by_bit(k: Lanes, v: Lanes) -> Lanes:
    """−v in the lanes where the second lowest bit of the integer k is set, else v."""
    return np.where(k & 2 == 0, v, -v)


def magnitude_bits(v: Lanes) -> Lanes:
    """The bits of |v| as integers: they have the order of the magnitudes, with infinity and then NaN at the top."""
    bits = v.view(np.int64 if v.itemsize == 8 else np.int32)
    return np.asarray(bits & np.iinfo(bits.dtype).max)


def larger(a: Lanes, b: Lanes) -> Lanes:
    """The larger integer in every lane."""
    return np.maximum(a, b)


def largest(k: Lanes) -> int:
    """The largest of all lanes of integers."""
    return int(k.max())


def read_columns(rows: Array, at: int, stride: int, m: Array, to: int, width: int) -> None:
    """Write a square block of `rows`, whose rows are `stride` apart, as columns of `m`, which are `width` apart.

    The rows may be in double precision where `m` is in single.
    """
    n = lane_count(m)
    for i in range(n):
        for k in range(n):
            m[to + k * width + i] = rows[at + i * stride + k]


def write_fours(m: Array, sources: Array, first: int, width: int, shift: int, out: Array, at: int, stride: int) -> None:
    """Write four columns of `m`, which start at width · sources[first…] + shift, as rows of `out`, `stride` apart."""
    for i in range(lane_count(m)):
        for k in range(4):
            out[at + i * stride + k] = m[width * sources[first + k] + shift + i]
