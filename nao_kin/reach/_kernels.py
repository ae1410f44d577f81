"""Compiled loops over samples: random numbers → joint values → hand → voxel → counts.

The code processes one sample after another, so that the result of a sample does not depend on its neighbours. It runs
as Python without Numba, and until compiling is worth the wait.
"""

from __future__ import annotations

import hashlib
import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats, drawn_ranges
from nao_kin._kernels.cache import CachedKernel, Floats1, Floats2, Ints2, both_ways
from nao_kin._kernels.chains import Chain, FramePose, chain_of, to_frame
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.robot import RobotModel, serial_chain
from nao_kin.robot.semantics import CoupledLimit

# --- The joints between two frames of a robot as arrays for the kernels.

Integers = NDArray[np.int64]

# Manipulability is counted in integer steps, so that sums do not depend on their order: its upper bound in steps.
_STEPS = 2**30
# Differences of placements below this are due to another machine's trigonometry, not to another robot.
_DIGITS = 12


class ChainTables(NamedTuple):
    """A serial chain of c coordinates, and their limits, for the kernels."""

    chain: Chain
    moving: int  # number of coordinates that move the frame; the others only affect limits
    low: Floats1  # of each coordinate, shape (c,)
    high: Floats1
    tables: Ints2  # coupled limits (t, 4): coordinate, the one it depends on, first and last + 1 of its rows in `bends`
    bends: Floats2  # at, lower, upper, shape (b, 3)


@dataclass(frozen=True, eq=False)
class MovedChain:
    """The joints that move a frame relative to a reference frame, by name and as tables."""

    frame: str
    reference: str
    joints: tuple[str, ...]
    radius: float  # of a ball about `centre` that contains the frame: the length of the stretched chain [m]
    tables: ChainTables

    @property
    def centre(self) -> Floats:
        """Position of the first joint in the reference frame, shape (3,) [m]."""
        return np.asarray(self.tables.chain.links[3:12:4])

    @property
    def manipulability_step(self) -> float:
        """The smallest power of two such that every manipulability of this chain is at most 2³⁰ times it.

        With r = min(3, moving), w² ≤ (mean of the eigenvalues of J_v J_vᵀ)ʳ. The sum of the eigenvalues is the sum of
        the squared columns.
        """
        chain, moving = self.tables.chain, self.tables.moving
        longest = np.zeros(moving)
        speeds = np.abs(chain.ratio) * np.where(chain.slides != 0.0, 1.0, self.radius)
        np.add.at(longest, np.maximum(chain.place, 0), speeds)  # a fixed joint adds nothing
        rank = min(3, moving)
        bound = (float(longest @ longest) / rank) ** (rank / 2)
        return 2.0 ** math.ceil(math.log2(bound / _STEPS)) if bound > 0.0 else 1.0

    @property
    def digest(self) -> str:
        """Fingerprint of geometry and limits, the same on every machine."""
        found = hashlib.sha256("\0".join(self.joints).encode())
        (_, links, slides, place, ratio, offset), *limits = self.tables
        for part in (links, slides, np.maximum(place, 0), ratio, offset, *limits):
            found.update((np.round(np.asarray(part, dtype=np.float64), _DIGITS) + 0.0).astype("<f8").tobytes())
        return found.hexdigest()


def moved_chain(robot: RobotModel, name: str, reference: str | None) -> MovedChain:
    """Return the joints between a reference and a frame, or the end of a named chain.

    The reference is the root for None and, with a floating base, for "world".
    """
    frame = _frame_named(robot, name)
    floating = robot.base == "floating" and "world" not in robot.frame_names
    if reference is None or (reference == "world" and floating):
        reference = robot.semantics.root if robot.semantics.root in robot.frame_names else robot.tree.root
    chain = serial_chain(robot, reference, frame)
    joints = list(chain.coordinates)
    if not joints:
        raise BadArgument(f"no joint moves {frame} in {reference}")
    numbers = chain_of([chain], joints)
    moving = len(joints)
    tables = _tables_of(robot, joints)
    column = {joint: index for index, joint in enumerate(joints)}
    low, high = _ranges(robot, joints)
    bends = [np.column_stack([table.at, table.lower, table.upper]) for table in tables]
    ends = list(itertools.accumulate(map(len, bends), initial=0))
    rows = [(column[table.joint], column[table.of], *ends[i : i + 2]) for i, table in enumerate(tables)]
    coupled = np.array(rows, dtype=np.int64).reshape(-1, 4)
    arrays = ChainTables(numbers, moving, low, high, coupled, np.concatenate([np.zeros((0, 3)), *bends]))
    return MovedChain(frame, reference, tuple(joints), chain.length(robot) * (1.0 + 1e-9), arrays)


def _frame_named(robot: RobotModel, name: str) -> str:
    if name not in robot.frame_names and name not in robot.chains:
        raise UnknownName("frame or chain", name, tuple(dict.fromkeys((*robot.chains, *robot.frame_names))))
    if name in robot.frame_names:
        return name
    table = robot.joints
    carried = {
        effector: [table.names[k] for k in table.path(robot.frame_placement(effector)[0])]
        for effector in robot.semantics.end_effectors
    }
    chain = robot.chains[name]
    found = [effector for effector, joints in carried.items() if chain[0] in joints]
    if found:
        return max(found, key=lambda effector: len(set(chain) & set(carried[effector])))
    return table.links[table.row(chain[-1])]


def _tables_of(robot: RobotModel, joints: list[str]) -> list[CoupledLimit]:
    """Return the tables of these joints in the robot's order; add the joints that they depend on to `joints`."""
    done = 0
    while done < len(joints):
        joints += [table.of for table in robot.coupled_limits if table.joint == joints[done] and table.of not in joints]
        joints[:] = dict.fromkeys(joints)
        done += 1
    return [table for table in robot.coupled_limits if table.joint in joints]


def _ranges(robot: RobotModel, joints: list[str]) -> tuple[Floats, Floats]:
    """Return the lowest and highest values of the joints, by the rule of `RobotModel.random`."""
    columns = [robot.joint_names.index(joint) for joint in joints]
    lower, upper = robot.lower[columns], robot.upper[columns]
    for joint, column in zip(joints, columns, strict=True):
        bounded = math.isfinite(robot.lower[column]) and math.isfinite(robot.upper[column])
        if not bounded and robot.joint_units[column] != "rad":
            raise BadArgument(f"{joint} slides without limits: the positions of the frame are not bounded")
    return drawn_ranges(lower, upper)


# --- The sphere of directions in 48 cells of equal area: HEALPix of resolution 2, in the ring scheme.
#
# Source: K. M. Górski et al., HEALPix: A Framework for High-Resolution Discretization and Fast Analysis of Data
# Distributed on the Sphere, The Astrophysical Journal 622 (2005), equations 2 to 9.

# Each of the twelve base cells is divided into RESOLUTION² cells. One bit per cell fits into a positive int64.
RESOLUTION = 2
DIRECTION_COUNT = 12 * RESOLUTION**2


def direction_cells() -> Floats:
    """Return unit vectors to the centres of the 48 cells of directions, in the order of their numbers, shape (48, 3).

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


# --- Compiled loops over samples: random numbers → joint values → hand → voxel → counts.

_DISCARDED = np.uint64(11)
_UNIT = 2.0**-53


class VoxelGrid(NamedTuple):
    """The counted voxels: `shape` of them from index `first` on, each `voxel` wide [m]."""

    voxel: float
    first: tuple[int, int, int]
    shape: tuple[int, int, int]


def cached_kernel(function: Callable[..., Any]) -> CachedKernel:
    """Return a kernel cached on disk."""
    return CachedKernel(function, "the kernels of reach maps", f"reach kernel, {function.__name__}", seconds=3.0)


@cached_kernel
def joint_values(draws: Annotated[NDArray[np.uint64], "uint64", 2], tables: ChainTables, values: Floats2) -> None:
    """Write values (m, c) inside limits from 64 random bits each: uniform in boxes, then mapped to coupled ranges."""
    count = tables.low.shape[0]
    for sample in range(draws.shape[0]):
        for c in range(count):
            # The 53 bits of a double in [0, 1), as in NumPy's generators.
            uniform = (draws[sample, c] >> _DISCARDED) * _UNIT
            values[sample, c] = tables.low[c] + (tables.high[c] - tables.low[c]) * uniform
        for table in range(tables.tables.shape[0]):
            c, of = tables.tables[table, 0], tables.tables[table, 1]
            bends = tables.bends[tables.tables[table, 2] : tables.tables[table, 3]]
            width = tables.high[c] - tables.low[c]
            share = (values[sample, c] - tables.low[c]) / width if width > 0.0 else 0.0
            lower = interpolated(bends, 1, values[sample, of])
            upper = interpolated(bends, 2, values[sample, of])
            lower = min(max(lower, tables.low[c]), tables.high[c])
            upper = min(max(upper, tables.low[c]), tables.high[c])
            values[sample, c] = lower + (upper - lower) * share


@both_ways
def interpolated(bends: Floats, column: int, at: float) -> float:
    """Return a column of a piecewise linear table, which is constant beyond its ends."""
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


@cached_kernel
def hands(values: Floats2, tables: ChainTables, positions: Floats2, axes: Floats2, manipulability: Floats1) -> None:
    """Write position (m, 3), x axis (m, 3) and manipulability (m,) of the frame at joint values (m, c)."""
    chain, joints = tables.chain, len(tables.chain.slides)
    posed = FramePose(np.empty(12), np.empty(3 * joints), np.empty(3 * joints))
    T, axis, origin = posed.T, posed.axes, posed.origins
    columns = np.empty((tables.moving, 3))
    for sample in range(values.shape[0]):
        to_frame(chain, values[sample], 0, 0, posed)
        columns[:] = 0.0
        for k in range(joints):
            m, c = chain.ratio[k], chain.place[k]
            if c < 0:
                continue
            a, b, d = axis[3 * k], axis[3 * k + 1], axis[3 * k + 2]
            if chain.slides[k] != 0.0:
                x, y, z = a, b, d
            else:
                u, v, w = T[3] - origin[3 * k], T[7] - origin[3 * k + 1], T[11] - origin[3 * k + 2]
                x, y, z = b * w - d * v, d * u - a * w, a * v - b * u
            columns[c, 0] += m * x
            columns[c, 1] += m * y
            columns[c, 2] += m * z
        for i in range(3):
            positions[sample, i], axes[sample, i] = T[4 * i + 3], T[4 * i]
        manipulability[sample] = volume(columns)


@both_ways
def volume(columns: Floats) -> float:
    """Return √det(J_v J_vᵀ) of the Jacobian with these columns (n, 3); √det(J_vᵀ J_v) for fewer than three.

    This is the root of the sum of all squared minors (Cauchy–Binet), which keeps every digit near a singularity; the
    determinant of the product loses half of them.
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
    """Return the HEALPix cell of a unit vector, ring scheme (Górski et al. 2005, section 5)."""
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


@cached_kernel
def places(positions: Floats2, axes: Floats2, grid: VoxelGrid, found: Ints2) -> None:
    """Write the number of the voxel in the grid, and the bit of the direction, shape (m, 2)."""
    for sample in range(positions.shape[0]):
        voxel = 0
        for i in range(3):
            index = math.floor(positions[sample, i] / grid.voxel) - grid.first[i]
            voxel = voxel * grid.shape[i] + index
        found[sample, 0] = voxel
        found[sample, 1] = 1 << direction_cell(axes[sample, 0], axes[sample, 1], axes[sample, 2])


@cached_kernel
def tally(found: Ints2, manipulability: Floats1, step: float, totals: Ints2) -> None:
    """Count samples in `totals`, one row per voxel: count, best and sum of manipulability in steps, directions."""
    for sample in range(found.shape[0]):
        voxel = found[sample, 0]
        steps = int(manipulability[sample] / step)
        totals[voxel, 0] += 1
        totals[voxel, 1] = max(totals[voxel, 1], steps)
        totals[voxel, 2] += steps
        totals[voxel, 3] |= found[sample, 1]


KERNELS = joint_values, hands, places, tally
