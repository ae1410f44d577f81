"""One formula for one rotation and for a million.

A kernel is a formula over single components, `kernel(f, m00, m01, …) -> (c0, c1, …)`. Its components are Python floats
(then `f` is `FLOATS`, the functions of `math`: one rotation costs a few microseconds) or contiguous arrays (then `f` is
`ARRAYS`, the ufuncs of NumPy). Batches pass through in chunks whose temporaries stay in the processor's cache.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin._common.vectors import first_index, largest
from nao_kin.errors import ZeroNorm

Number = Any  # a float or an array of floats: kernels are written once for both
Kernel = Callable[..., tuple[Number, ...]]

CHUNK = 8192

# Between these the square of a length neither underflows nor overflows, nor loses a digit.
SMALLEST_SQUARE, LARGEST_SQUARE = 1e-280, 1e280
SMALLEST_NORMAL = 2.0**-1022


class OutOfScale(Exception):
    """A kernel met a vector too short or too long to be squared; its caller rescales and calls again."""


@dataclass(frozen=True)
class Functions:
    """The functions a kernel may call beside + − × ÷ and comparison."""

    sqrt: Callable[[Number], Number]
    sin: Callable[[Number], Number]
    cos: Callable[[Number], Number]
    tan: Callable[[Number], Number]
    log: Callable[[Number], Number]
    atan2: Callable[[Number, Number], Number]
    larger: Callable[[Number, Number], Number]
    where: Callable[[Number, Number, Number], Number]
    some: Callable[[Number], bool]
    within: Callable[[Number, float], bool]

    def square(self, *components: Number) -> Number:
        """Sum of squares; `OutOfScale` where it would not be accurate."""
        total = components[0] * components[0]
        for component in components[1:]:
            total = total + component * component
        if self.some(total < SMALLEST_SQUARE) or self.some(total > LARGEST_SQUARE):
            raise OutOfScale
        return total


def _choose(condition: bool, yes: float, no: float) -> float:
    return yes if condition else no


def _float_within(value: float, bound: float) -> bool:
    return -bound <= value <= bound


def _array_within(value: Any, bound: float) -> bool:
    # Written so that NaN, which min and max pass on, answers False.
    return bool(value.max() <= bound) and bool(value.min() >= -bound)


FLOATS = Functions(math.sqrt, math.sin, math.cos, math.tan, math.log, math.atan2, max, _choose, bool, _float_within)
ARRAYS = Functions(np.sqrt, np.sin, np.cos, np.tan, np.log, np.arctan2, np.maximum, np.where, np.any, _array_within)


def evaluate(kernel: Kernel, inputs: Sequence[Floats], *tails: tuple[int, ...]) -> list[Floats]:
    """`kernel` on every row of `inputs`, arrays (*batch, m_i) of one batch shape.

    Its results, in order, fill new arrays of shape (*batch, *tail), one for each of `tails`.
    """
    batch = inputs[0].shape[:-1]
    rows = [values.reshape(-1, values.shape[-1]) for values in inputs]
    count = len(rows[0])
    outs = [np.empty((count, math.prod(tail))) for tail in tails]
    if count == 1:
        components = [x for values in rows for x in values[0].tolist()]
        results = kernel(FLOATS, *components)
        for out in outs:
            out[0], results = results[: out.shape[1]], results[out.shape[1] :]
    else:
        targets = [column for out in outs for column in out.T]
        if count > CHUNK:
            keep_the_heap()
        # What overflows is met by the kernel itself with an error that says more than a warning.
        with np.errstate(over="ignore", invalid="ignore"):
            for start in range(0, count, CHUNK):
                part = slice(start, start + CHUNK)
                columns = [column for values in rows for column in np.ascontiguousarray(values[part].T)]
                for target, result in zip(targets, kernel(ARRAYS, *columns), strict=True):
                    target[part] = result
    return [out.reshape((*batch, *tail)) for out, tail in zip(outs, tails, strict=True)]


def rescaled(vectors: Floats, what: str) -> Floats:
    """`vectors`, shape (..., m), each divided by its largest component: same direction, a length from 1 to √m.

    Raises:
        ZeroNorm: some vector is exactly zero; carries its index.
    """
    size = largest(vectors)
    if not size.all():
        raise ZeroNorm(what, first_index(size == 0.0))
    return np.asarray(vectors / size[..., np.newaxis])


def keep_the_heap() -> None:
    """Keep glibc from handing the temporaries of each chunk back to the system, to fault them in again for the next.

    Freeing one large block raises its limits for good: kernels run up to twice as fast. Elsewhere it costs nothing.
    """
    np.empty(1 << 20)
