"""The codes of the operations, and the size of a tile: what programs and the kernel that runs them agree on."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from nao_kin._common.arrays import Floats

TURN, ADD_1, ADD_2, ADD_3, SLIDE, CROSS, PROJECT, BASE, HINGE, MATRIX, QUATERNION, RPY = range(12)

# Bytes of a vector and of a cache line; configurations in a tile are a few vectors of their numbers, for the work on
# two hides the time it takes to look up an operation.
LINE = 64
VECTORS = 2


class Tables(NamedTuple):
    """A program as the kernel takes it; places are counted in rows of scratch memory.

    Attributes:
        widths: numbers in each configuration, velocity and acceleration; zero for an input that is not read.
        inputs: row of the first number of each of the three.
        angles: for each angle, the row of its number and the row of its sine, shape (angles, 2); the cosine follows it.
        ratios: ratio and offset of each, shape (angles, 2): ratio × number + offset.
        operations: shape (operations, 10), see `nao_kin.batch.operations`.
        weights: the constants in them.
        sources: row of each number of the result.
    """

    widths: NDArray[np.int64]
    inputs: NDArray[np.int64]
    angles: NDArray[np.int64]
    ratios: Floats
    operations: NDArray[np.int64]
    weights: Floats
    sources: NDArray[np.int64]


def aligned_empty(count: int, dtype: np.dtype[Any]) -> NDArray[Any]:
    """Memory for so many numbers that begins where a vector can be written at once.

    Examples:
        >>> numbers = nk.batch.aligned_empty(5, np.dtype(np.float64))
        >>> numbers.shape, numbers.ctypes.data % 32
        ((5,), 0)
    """
    memory = np.empty(count + LINE // dtype.itemsize, dtype)
    skipped = -memory.ctypes.data % LINE // dtype.itemsize
    return memory[skipped : skipped + count]


def tile_width(dtype: np.dtype[Any]) -> int:
    """Configurations in a tile."""
    return VECTORS * LINE // dtype.itemsize
