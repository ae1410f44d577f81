"""Compiled loops over samples: drawn numbers → joint values → hand → voxel, and their count.

Plain scalar code for one sample after another, so that what is computed of a sample does not depend on its neighbours.
Without Numba, and until it is worth waiting for it, the functions run as they stand.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from nao_kin._common.arrays import Floats
from nao_kin._common.both_ways import both_ways, register_parts
from nao_kin._common.kernel_cache import KeptKernel
from nao_kin.reach.chain_tables import ChainTables, Integers
from nao_kin.reach.directions import RESOLUTION

_DISCARDED = np.uint64(11)
_UNIT = 2.0**-53


class VoxelGrid(NamedTuple):
    """Voxels that are counted: `shape` of them from the index `first` on, each `voxel` wide [m]."""

    voxel: float
    first: tuple[int, int, int]
    shape: tuple[int, int, int]


def kept(*arguments: str) -> Callable[[Callable[..., Any]], KeptKernel]:
    """A kernel kept on disk, with arguments of the types that `_signature` has by these names."""

    def made(function: Callable[..., Any]) -> KeptKernel:
        name = function.__name__
        return KeptKernel(
            function,
            "the kernels of reach maps",
            f"reach kernel, {name}",
            lambda: _signature(arguments),
            3.0,
        )

    return made


def _signature(arguments: tuple[str, ...]) -> Any:
    """The types of a kernel that gives back nothing."""
    from numba import types

    register_parts()
    row, rows, whole, whole_rows = types.float64[::1], types.float64[:, ::1], types.int64[::1], types.int64[:, ::1]
    matrices, number, three = types.float64[:, :, ::1], types.int64, types.UniTuple(types.int64, 3)
    chain = matrices, types.boolean[::1], whole, row, row, number, row, row, whole_rows, rows
    named = {
        "draws": types.uint64[:, ::1],
        "chain": types.NamedTuple(chain, ChainTables),
        "grid": types.NamedTuple((types.float64, three, three), VoxelGrid),
        "number": types.float64,
        "row": row,
        "rows": rows,
        "whole_rows": whole_rows,
    }
    return types.void(*(named[name] for name in arguments))


@kept("draws", "chain", "rows")
def joint_values(draws: NDArray[np.uint64], chain: ChainTables, values: Floats) -> None:
    """Values (m, c) inside all limits from 64 random bits each.

    Each uniform in its box; then the box of a coupled joint is mapped onto its range at the joint it depends on.
    """
    count = chain.low.shape[0]
    for sample in range(draws.shape[0]):
        for c in range(count):
            # The 53 bits of a double in [0, 1), as NumPy's own generators have them.
            uniform = (draws[sample, c] >> _DISCARDED) * _UNIT
            values[sample, c] = chain.low[c] + (chain.high[c] - chain.low[c]) * uniform
        for table in range(chain.tables.shape[0]):
            c, of = chain.tables[table, 0], chain.tables[table, 1]
            bends = chain.bends[chain.tables[table, 2] : chain.tables[table, 3]]
            width = chain.high[c] - chain.low[c]
            share = (values[sample, c] - chain.low[c]) / width if width > 0.0 else 0.0
            lower = interpolated(bends, 1, values[sample, of])
            upper = interpolated(bends, 2, values[sample, of])
            lower = min(max(lower, chain.low[c]), chain.high[c])
            upper = min(max(upper, chain.low[c]), chain.high[c])
            values[sample, c] = lower + (upper - lower) * share


@both_ways
def interpolated(bends: Floats, column: int, at: float) -> float:
    """Column of a piecewise linear table, constant outside of it."""
    last = bends.shape[0] - 1
    if at <= bends[0, 0]:
        return float(bends[0, column])
    if at >= bends[last, 0]:
        return float(bends[last, column])
    right = 1
    while bends[right, 0] < at:
        right += 1
    left = right - 1
    share = (at - bends[left, 0]) / (bends[right, 0] - bends[left, 0])
    return float(bends[left, column] + share * (bends[right, column] - bends[left, column]))


@kept("rows", "chain", "rows", "rows", "row")
def hands(values: Floats, chain: ChainTables, positions: Floats, axes: Floats, manipulability: Floats) -> None:
    """Position (m, 3), x axis (m, 3) and manipulability (m,) of the frame at joint values (m, c)."""
    joints = chain.slides.shape[0]
    origin, axis, columns = np.empty((joints, 3)), np.empty((joints, 3)), np.empty((chain.moving, 3))
    R, turned, p = np.empty((3, 3)), np.empty((3, 3)), np.empty(3)
    for sample in range(values.shape[0]):
        for i in range(3):
            p[i] = chain.placements[0, i, 3]
            for j in range(3):
                R[i, j] = chain.placements[0, i, j]
        for k in range(joints):
            value = chain.multiplier[k] * values[sample, chain.coordinate[k]] + chain.offset[k]
            for i in range(3):
                origin[k, i], axis[k, i] = p[i], R[i, 2]
            if chain.slides[k]:
                for i in range(3):
                    p[i] += value * R[i, 2]
            else:
                cosine, sine = math.cos(value), math.sin(value)
                for i in range(3):
                    first, second = R[i, 0], R[i, 1]
                    R[i, 0], R[i, 1] = cosine * first + sine * second, cosine * second - sine * first
            A = chain.placements[k + 1]
            for i in range(3):
                p[i] += R[i, 0] * A[0, 3] + R[i, 1] * A[1, 3] + R[i, 2] * A[2, 3]
                for j in range(3):
                    turned[i, j] = R[i, 0] * A[0, j] + R[i, 1] * A[1, j] + R[i, 2] * A[2, j]
            R, turned = turned, R
        columns[:] = 0.0
        for k in range(joints):
            m, c = chain.multiplier[k], chain.coordinate[k]
            if chain.slides[k]:
                for i in range(3):
                    columns[c, i] += m * axis[k, i]
            else:
                x, y, z = p[0] - origin[k, 0], p[1] - origin[k, 1], p[2] - origin[k, 2]
                columns[c, 0] += m * (axis[k, 1] * z - axis[k, 2] * y)
                columns[c, 1] += m * (axis[k, 2] * x - axis[k, 0] * z)
                columns[c, 2] += m * (axis[k, 0] * y - axis[k, 1] * x)
        for i in range(3):
            positions[sample, i], axes[sample, i] = p[i], R[i, 0]
        manipulability[sample] = volume(columns)


@both_ways
def volume(columns: Floats) -> float:
    """√det(J_v J_vᵀ) of the Jacobian with these columns (n, 3); √det(J_vᵀ J_v) for less than three of them.

    By the formula of Cauchy and Binet: the root of the sum of all squared minors, which keeps every digit near a
    singularity, where the determinant of the product loses half of them.
    """
    count = columns.shape[0]
    total = 0.0
    if count == 1:
        for i in range(3):
            total += columns[0, i] * columns[0, i]
    for a in range(count):
        for b in range(a + 1, count):
            x = columns[a, 1] * columns[b, 2] - columns[a, 2] * columns[b, 1]
            y = columns[a, 2] * columns[b, 0] - columns[a, 0] * columns[b, 2]
            z = columns[a, 0] * columns[b, 1] - columns[a, 1] * columns[b, 0]
            if count == 2:
                total += x * x + y * y + z * z
            for c in range(b + 1, count):
                minor = columns[c, 0] * x + columns[c, 1] * y + columns[c, 2] * z
                total += minor * minor
    return math.sqrt(total)


@both_ways
def direction_cell(x: float, y: float, z: float) -> int:
    """The HEALPix cell of a unit vector, ring scheme (Górski et al. 2005, section 5)."""
    n = RESOLUTION
    quarter = math.atan2(y, x) / (0.5 * math.pi)
    if quarter < 0.0:
        quarter += 4.0
    height = abs(z)
    if 3.0 * height <= 2.0:
        middle, slope = n * (0.5 + quarter), 0.75 * n * z
        falling, rising = math.floor(middle - slope), math.floor(middle + slope)
        ring = n + 1 + falling - rising
        shift = 1 - (ring & 1)
        place = ((falling + rising - n + shift + 1) // 2) % (4 * n)
        return 2 * n * (n - 1) + (ring - 1) * 4 * n + place
    part = quarter - math.floor(quarter)
    width = n * math.sqrt(max(0.0, 3.0 * (1.0 - height)))
    ring = math.floor(part * width) + math.floor((1.0 - part) * width) + 1
    place = math.floor(quarter * ring) % (4 * ring)
    return 2 * ring * (ring - 1) + place if z > 0.0 else 12 * n * n - 2 * ring * (ring + 1) + place


@kept("rows", "rows", "grid", "whole_rows")
def places(positions: Floats, axes: Floats, grid: VoxelGrid, found: Integers) -> None:
    """Number of the voxel in its grid, and the bit of the direction, shape (m, 2)."""
    for sample in range(positions.shape[0]):
        voxel = 0
        for i in range(3):
            index = math.floor(positions[sample, i] / grid.voxel) - grid.first[i]
            voxel = voxel * grid.shape[i] + index
        found[sample, 0] = voxel
        found[sample, 1] = 1 << direction_cell(axes[sample, 0], axes[sample, 1], axes[sample, 2])


@kept("whole_rows", "row", "number", "whole_rows")
def tally(found: Integers, manipulability: Floats, step: float, totals: Integers) -> None:
    """Count samples into `totals`, one row per voxel: how many, best and sum of manipulability in steps, directions."""
    for sample in range(found.shape[0]):
        voxel = found[sample, 0]
        steps = int(manipulability[sample] / step)
        totals[voxel, 0] += 1
        totals[voxel, 1] = max(totals[voxel, 1], steps)
        totals[voxel, 2] += steps
        totals[voxel, 3] |= found[sample, 1]


KERNELS = joint_values, hands, places, tally
