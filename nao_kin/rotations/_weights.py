"""Weights of what is averaged or fitted."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats
from nao_kin._common.vectors import as_batch, first_index
from nao_kin.errors import BadArgument, at_index


def as_shares(weights: ArrayLike | None, count: int) -> Floats:
    """`weights` of `count` things as shares of 1, shape (..., count); alike without weights.

    Raises:
        BadArgument: a negative weight, or no positive one; not numbers.
        WrongShape, NotFinite: not of shape (..., count), NaN or infinity.
    """
    if weights is None:
        return np.full(count, 1.0 / count)
    values = as_batch(weights, (count,), "weights")
    if (values < 0.0).any():
        index = first_index(values < 0.0)
        raise BadArgument(f"weights must not be negative, got {values[index]:g}{at_index(index)}")
    largest = values.max(axis=-1, keepdims=True)
    if not largest.all():
        where = at_index(first_index(largest[..., 0] == 0.0))
        raise BadArgument(f"at least one weight must be positive, got zeros only{where}")
    # A common scale changes nothing, and keeps their sum from overflowing.
    scaled = values / largest
    return np.asarray(scaled / scaled.sum(axis=-1, keepdims=True))
