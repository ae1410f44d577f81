"""The sphere of directions in 48 cells of equal area: HEALPix of resolution 2, in the ring scheme.

Source: K. M. Górski et al., HEALPix: A Framework for High-Resolution Discretization and Fast Analysis of Data
Distributed on the Sphere, The Astrophysical Journal 622 (2005), equations 2 to 9.
"""

from __future__ import annotations

import math

import numpy as np

from nao_kin._common.arrays import Floats

# Each of the twelve base cells is cut into RESOLUTION² cells. One bit for each fits into a positive int64.
RESOLUTION = 2
DIRECTION_COUNT = 12 * RESOLUTION**2


def direction_cells() -> Floats:
    """Unit vectors to the middles of the 48 cells of directions, shape (48, 3), in the order of their numbers.

    Examples:
        >>> nk.reach.direction_cells().shape
        (48, 3)
    """
    n = RESOLUTION
    rows = []
    for ring in range(1, 4 * n):
        from_pole = min(ring, 4 * n - ring)
        if from_pole < n:  # a polar cap: 4 · ring cells
            height, cells, start = 1.0 - from_pole**2 / (3.0 * n**2), 4 * from_pole, 0.5
        else:
            height, cells, start = 4.0 / 3.0 - 2.0 * from_pole / (3.0 * n), 4 * n, 0.5 * ((from_pole - n + 1) % 2)
        height = height if ring < 2 * n else -height
        radius = math.sqrt(1.0 - height**2)
        angles = (np.arange(cells) + start) * (2.0 * math.pi / cells)
        rows.append(np.column_stack([radius * np.cos(angles), radius * np.sin(angles), np.full(cells, height)]))
    return np.concatenate(rows)
