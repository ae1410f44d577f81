"""Vectors of the width of one register, so that a kernel computes many configurations together.

The compiler vectorises a loop over parts of one array only behind a check that the parts do not overlap. Here the width
is fixed: 512 bits, 8 double or 16 single precision numbers, which narrower registers process in several steps. Vectors
have the operators + − × ÷; the other functions are defined here in NumPy, and run so when nothing is compiled. In
compiled code, those of `lanes_llvm` replace them.

For comparison, plain loops of Numba over tiles of 32, with constant widths, unsigned indices and `contract`, take 1.6
times as long for the poses of five frames (65 against 40 ns), 1.6 times for centres of mass, 2.5 times for a Jacobian,
1.4 times for quaternions and 1.3 times for roll, pitch and yaw (same programs, one thread, AVX-512).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numba
import numpy as np
from numpy.typing import NDArray

from nao_kin._kernels.program import LINE

Array = NDArray[Any]
Lanes = NDArray[Any]


def lane_count(m: Array) -> int:
    """Return the number of entries of an array of this kind in one vector."""
    itemsize: int = m.itemsize
    return LINE // itemsize


def load(m: Array, at: int) -> Lanes:
    """Return the vector that starts at m[at]."""
    return np.array(m[at : at + lane_count(m)])


def store(m: Array, at: int, v: Lanes) -> None:
    """Write a vector to m[at] and the following entries."""
    m[at : at + len(v)] = v


def spread(m: Array, value: float) -> Lanes:
    """Return a vector of the kind of `m` with one number in every lane."""
    return np.full(lane_count(m), value, dtype=m.dtype)


def square_root(v: Lanes) -> Lanes:
    """Return the square root in every lane."""
    return np.sqrt(v)


def nearest(v: Lanes) -> Lanes:
    """Return the nearest whole number in every lane."""
    return np.rint(v)


def whole(v: Lanes) -> Lanes:
    """Return whole numbers as integers."""
    return v.astype(np.int64 if v.itemsize == 8 else np.int32)


def following(k: Lanes) -> Lanes:
    """Return k + 1 in every lane of integers."""
    return k + 1


def with_sign(v: Lanes, sign: Lanes) -> Lanes:
    """Return the magnitude of `v` with the sign of `sign`."""
    return np.copysign(v, sign)


def where_less(a: Lanes, b: Lanes, yes: Lanes, no: Lanes) -> Lanes:
    """Return in every lane `yes` if a < b, otherwise `no`."""
    return np.where(a < b, yes, no)


def where_even(k: Lanes, yes: Lanes, no: Lanes) -> Lanes:
    """Return in every lane `yes` if the integer k is even, otherwise `no`."""
    return np.where(k & 1 == 0, yes, no)


def negated_by_bit(k: Lanes, v: Lanes) -> Lanes:
    """Return −v in the lanes with the second lowest bit of the integer k set, otherwise v."""
    return np.where(k & 2 == 0, v, -v)


def magnitude_bits(v: Lanes) -> Lanes:
    """Return the bits of |v| as integers, which are ordered like the magnitudes, with infinity and then NaN last."""
    bits: Lanes = v.view(np.int64 if v.itemsize == 8 else np.int32)
    return np.asarray(bits & np.iinfo(bits.dtype).max)


def larger(a: Lanes, b: Lanes) -> Lanes:
    """Return the larger integer in every lane."""
    return np.maximum(a, b)


def largest(k: Lanes) -> int:
    """Return the largest of all lanes of integers."""
    return int(k.max())


def read_columns(rows: Array, at: int, stride: int, m: Array, to: int, width: int) -> None:
    """Write a square block of `rows`, `stride` apart, as columns of `m`, `width` apart, in the precision of `m`."""
    n = lane_count(m)
    for i in range(n):
        for k in range(n):
            m[to + k * width + i] = rows[at + i * stride + k]


def write_fours(m: Array, sources: Array, first: int, width: int, shift: int, out: Array, at: int, stride: int) -> None:
    """Write four columns of `m`, which start at width · sources[first…] + shift, as rows of `out`, `stride` apart."""
    for i in range(lane_count(m)):
        for k in range(4):
            out[at + i * stride + k] = m[width * sources[first + k] + shift + i]


if not (TYPE_CHECKING or numba.config.DISABLE_JIT):
    from nao_kin._kernels.lanes_llvm import *  # noqa: F403
