"""The shortest path through layers of candidates, one layer for each sample of a path (Bellman 1957)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats


def reached(cost: Floats, before: Floats, values: Floats, weights: Floats) -> tuple[Floats, NDArray[np.int64]]:
    """Return the least cost up to each of k values (k, c), and the index of its predecessor.

    Predecessors `before`, shape (m, c), have the least costs `cost`, shape (m,). A step between them and the values
    costs Σ (Δ_j · weight_j)².
    """
    total = cost[:, None] + (((values - before[:, None]) * weights) ** 2).sum(axis=-1)
    back = np.argmin(total, axis=0)
    return total[back, np.arange(len(values))], back


def traced(backs: Sequence[NDArray[np.int64]], last: int) -> list[int]:
    """Return the index of the path in each layer, from their predecessors and the index in the last one."""
    places = [last]
    for back in backs[:0:-1]:
        places.append(int(back[places[-1]]))
    return places[::-1]
