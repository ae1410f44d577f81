"""Array arguments: converted once, checked once, and refused with the library's own errors."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._text import quoted
from nao_kin.errors import BadArgument, NotFinite, WrongShape

Floats = NDArray[np.float64]
Vector = tuple[float, float, float]

# Below this size, setting up the error state of a sum costs more than the exact search.
_SMALL = 2000


def as_floats(value: ArrayLike, tail: tuple[int, ...], what: str) -> Floats:
    """`value` as a finite float64 array of shape (..., *tail); not copied when it is one already.

    Raises:
        BadArgument: not numbers.
        WrongShape: the trailing axes are not `tail`.
        NotFinite: NaN or infinity, with the index of the first.
    """
    array = as_numbers(value, what)
    if array.shape[array.ndim - len(tail) :] != tail or array.ndim < len(tail):
        raise WrongShape(what, f"(..., {', '.join(map(str, tail))})" if tail else "(...)", array.shape)
    if not all_finite(array):
        refuse_non_finite(array, what)
    return array


def all_finite(array: Floats) -> bool:
    """Whether no entry is NaN or infinite; for large arrays at the cost of one sum."""
    if array.size > _SMALL:
        # Not a dot product: BLAS deals it out to threads, which on a busy machine take ten times as long.
        with np.errstate(over="ignore", invalid="ignore"):
            if math.isfinite(array.sum()):
                return True
    return bool(np.isfinite(array).all())


def as_numbers(value: ArrayLike, what: str) -> Floats:
    """`value` as a float64 array of any shape; ragged, textual and complex input and masked entries refused."""
    if type(value) is np.ndarray and value.dtype == np.float64:
        return value
    if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
        raise BadArgument(f"{what} has masked entries; fill them first, as in {what}.filled(0.0)")
    try:
        array: NDArray[Any] = np.asarray(value)
        if array.dtype.kind not in "fiub":
            raise TypeError
        return array.astype(np.float64)
    except (TypeError, ValueError):
        raise BadArgument(f"{what} must be real numbers, got {quoted(value, 60)}") from None


def refuse_non_finite(array: Floats, what: str) -> None:
    """Raise `NotFinite` for the first NaN or infinity of `array`, if it has one."""
    finite = np.isfinite(array)
    if not finite.all():
        index = tuple(int(i) for i in np.argwhere(~finite)[0])
        raise NotFinite(what, index, float(array[index]))
