"""Numbers as colours, cold to warm through a light middle."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats

# Red, green, blue from the lowest value to the highest, equally spaced.
COLD_TO_WARM: tuple[tuple[float, float, float], ...] = (
    (0.16, 0.32, 0.66),
    (0.36, 0.63, 0.83),
    (0.90, 0.91, 0.88),
    (0.95, 0.66, 0.36),
    (0.74, 0.17, 0.12),
)


def colours(values: ArrayLike, low: float, high: float) -> Floats:
    """Red, green, blue in [0, 1], shape (..., 3), of numbers on a scale from low to high, with low < high."""
    at = np.linspace(low, high, len(COLD_TO_WARM))
    numbers = np.asarray(values, dtype=np.float64)
    return np.stack([np.interp(numbers, at, channel) for channel in zip(*COLD_TO_WARM, strict=True)], axis=-1)
