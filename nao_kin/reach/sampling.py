"""Draw random configurations, and count the resulting positions of the hand."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, wait

import numpy as np

from nao_kin._core.arrays import MAX_THREADS, Floats, positive, whole_number
from nao_kin._core.process import usable_cores
from nao_kin._kernels.cache import first_rows
from nao_kin.errors import BadArgument
from nao_kin.reach._kernels import KERNELS, ChainTables, Integers, VoxelGrid, moved_chain
from nao_kin.reach.reach_map import MAX_INDEX, ReachMap, ReachSettings, SampleRange, map_of, union
from nao_kin.robot import RobotModel

# Samples counted between two checks for a stop; their arrays fit into the cache of one core.
_BLOCK = 8192
# Samples counted at a time as Python, until the kernels are worth the wait.
_FEW = 64
# During counting, every voxel of the box around the reach takes 32 bytes.
_MAX_VOXELS = 50_000_000
# If all these samples fall into one voxel with the largest manipulability, the sum is still below 2⁶³.
_MAX_SAMPLES = 2**32
# Words that Philox generates from one count.
_WORDS = 4
_SECONDS_BETWEEN_REPORTS = 0.1


def workspace(
    robot: RobotModel,
    frame: str,
    samples: int | SampleRange = 1_000_000,
    *,
    voxel: float = 0.01,
    seed: int = 0,
    reference: str | None = None,
    shard: tuple[int, int] | None = None,
    previous: ReachMap | None = None,
    threads: int | None = None,
    progress: Callable[[int, int], object] | None = None,
    stop: Callable[[], bool] | None = None,
) -> ReachMap:
    """Return a voxel map of the positions of a frame, with the number of samples, manipulability and directions.

    Samples are configurations drawn as by `RobotModel.random`: each joint uniform in its box; for a coupled limit, the
    box is mapped onto the range at the other joint's value. Sample i depends on seed and i alone: words i·c to
    i·c + c − 1 of NumPy's Philox generator are its c joint values. All counts are integers, so that the sum of partial
    maps equals the whole map bit for bit, for any parts and number of threads.

    The manipulability is that of the position, w = √det(J_v J_vᵀ), with J_v the (3, n) Jacobian of the frame's origin
    for the n joints that move it. Up to a factor this is the volume of the ellipsoid of velocities at unit joint
    speeds, in m³ for three or more revolute joints. It is zero if the hand cannot move along some direction. With fewer
    than three joints w = √det(J_vᵀ J_v). (The six-row Jacobian of an arm with five joints never has full rank.)

    Args:
        robot: any robot; a floating base stays where it is.
        frame: a frame, or the name of a chain for its end effector.
        samples: number of samples, or (start, stop) for a part of them.
        voxel: edge of a voxel [m].
        seed: seed of the samples.
        reference: the frame in which positions are counted; None for the root.
        shard: (k, n) for the k-th of n equal parts of the samples, k from 0.
        previous: a map with the same settings; the result includes its samples, which are not drawn again.
        threads: number of threads; None for one per core that this process may use.
        progress: called repeatedly, in the calling thread, with the numbers of samples done and requested.
        stop: called repeatedly; if it returns true, the map of the samples done so far is returned.

    Raises:
        BadArgument: no joint moves the frame, a joint slides without limits, there would be too many voxels, or
            `previous` has other settings.

    Source: T. Yoshikawa, Manipulability of Robotic Mechanisms, The International Journal of Robotics Research 4 (1985)
    3–9, equation 9, with the translational part of J as in Yoshikawa, Translational and Rotational Manipulability of
    Robotic Manipulators, Proc. IECON 1991.

    Examples:
        >>> reach = nk.reach.workspace(nk.load_nao(), "LArm", 1000, voxel=0.05)
        >>> reach.column("count").shape == reach.column("best").shape
        True
    """
    requested = _requested_range(samples, shard)
    workers = usable_cores() if threads is None else whole_number(threads, "threads", 1, MAX_THREADS)
    edge, number = float(positive(voxel, "voxel")), whole_number(seed, "seed", 0, 2**64 - 1)
    chain = moved_chain(robot, frame, reference)
    if edge > 2.0 * chain.radius:
        raise BadArgument(f"voxel = {edge:g} m is wider than the whole reach of {frame}, {2.0 * chain.radius:.3g} m")
    grid = _grid(chain.centre, chain.radius, edge)
    frames, step = (chain.frame, chain.reference), chain.manipulability_step
    settings = ReachSettings(robot.name, *frames, chain.joints, chain.digest, edge, number, step)
    done: tuple[SampleRange, ...] = ()
    if previous is not None:
        settings.check_same(previous.settings, "the previous map")
        done = previous.ranges
    counter = _Counter(chain.tables, settings, grid)
    counter.count(_without(requested, done), workers, progress, stop)
    rows = np.flatnonzero(counter.totals[:, 0])
    indices = np.stack(np.unravel_index(rows, grid.shape), axis=-1) + np.array(grid.first)
    counted = map_of(settings, counter.done, indices, counter.totals[rows])
    return counted if previous is None else previous + counted


def _requested_range(samples: int | SampleRange, shard: tuple[int, int] | None) -> SampleRange:
    """Return (start, stop) for a number of samples or a range of them, or for its k-th of n parts, shard (k, n)."""
    if isinstance(samples, (tuple, list)):
        begin, end = samples
        start = whole_number(begin, "the first sample", 0)
        stop = whole_number(end, "the end of the samples", start + 1, _MAX_SAMPLES)
    else:
        start, stop = 0, whole_number(samples, "samples", 1, _MAX_SAMPLES)
    if shard is None:
        return start, stop
    part, parts = shard
    count = whole_number(parts, "the number of shards", 1, stop - start)
    k = whole_number(part, "the shard", 0, count - 1)
    return start + (stop - start) * k // count, start + (stop - start) * (k + 1) // count


def _without(requested: SampleRange, done: Sequence[SampleRange]) -> tuple[SampleRange, ...]:
    """Return `requested` minus `done`, whose ranges are disjoint and ascending."""
    remaining, (start, stop) = [], requested
    for first, last in (*done, (stop, stop)):
        if start < min(first, stop):
            remaining.append((start, min(first, stop)))
        start = max(start, last)
    return tuple(remaining)


class _Counter:
    """Counts samples in one array, in several threads."""

    def __init__(self, chain: ChainTables, settings: ReachSettings, grid: VoxelGrid) -> None:
        self._chain, self._settings, self._grid = chain, settings, grid
        self._lock = threading.Lock()
        self._ending = threading.Event()
        self._done: list[SampleRange] = []
        # One row for each voxel of the box: count, best, sum, directions.
        self.totals: Integers = np.zeros((math.prod(grid.shape), 4), dtype=np.int64)

    @property
    def done(self) -> tuple[SampleRange, ...]:
        """The samples counted so far."""
        with self._lock:
            return union(self._done)

    def count(
        self,
        ranges: Sequence[SampleRange],
        workers: int,
        progress: Callable[[int, int], object] | None,
        stop: Callable[[], bool] | None,
    ) -> None:
        """Count the samples of these ranges, until all are done or `stop` returns true."""
        few = _blocks(ranges, _FEW)
        number = sum(math.ceil((stop - start) / _FEW) for start, stop in ranges)
        uncompiled = tuple(kernel.uncompiled for kernel in KERNELS)
        if first_rows(KERNELS, lambda part: self._count_block(next(few), uncompiled), number) < number:
            for kernel in KERNELS:
                kernel.ready()  # in this thread, so that Ctrl-C ends it
        blocks = _blocks([left for part in ranges for left in _without(part, self.done)], _BLOCK)
        requested = sum(stop - start for start, stop in ranges)
        with ThreadPoolExecutor(workers, thread_name_prefix="nao_kin_reach") as pool:
            try:
                running = {pool.submit(self._work, blocks) for _ in range(workers)}
                while running:
                    finished, running = wait(running, timeout=_SECONDS_BETWEEN_REPORTS, return_when="FIRST_EXCEPTION")
                    for worker in finished:
                        worker.result()
                    if progress is not None:
                        progress(sum(stop - start for start, stop in self.done), requested)
                    if stop is not None and stop():
                        self._ending.set()
            finally:
                self._ending.set()  # after an exception, no thread continues

    def _work(self, blocks: Iterator[SampleRange]) -> None:
        while not self._ending.is_set():
            with self._lock:
                block = next(blocks, None)
            if block is None:
                return
            self._count_block(block, KERNELS)

    def _count_block(self, block: SampleRange, functions: Sequence[Callable[..., object]]) -> None:
        joint_values, hands, places, tally = functions
        chain = self._chain
        size, joints = block[1] - block[0], len(chain.low)
        values, manipulability = np.empty((size, joints)), np.empty(size)
        positions, axes = np.empty((size, 3)), np.empty((size, 3))
        found = np.empty((size, 2), dtype=np.int64)
        joint_values(_draws(self._settings.seed, block, joints), chain, values)
        hands(values, chain, positions, axes, manipulability)
        places(positions, axes, self._grid, found)
        with self._lock:
            tally(found, manipulability, self._settings.step, self.totals)
            self._done.append(block)
            if len(self._done) > 1000:
                self._done[:] = union(self._done)


def _draws(seed: int, block: SampleRange, joints: int) -> np.ndarray[tuple[int, int], np.dtype[np.uint64]]:
    """Return the random words of these samples, shape (m, joints); NumPy guarantees the same ones in every version."""
    start, stop = block[0] * joints, block[1] * joints
    generator = np.random.Philox(seed)
    generator.advance(start // _WORDS)
    words = generator.random_raw(stop - start // _WORDS * _WORDS)[start % _WORDS :]
    return words.reshape(-1, joints)


def _blocks(ranges: Sequence[SampleRange], size: int) -> Iterator[SampleRange]:
    for start, stop in ranges:
        for first in range(start, stop, size):
            yield first, min(first + size, stop)


def _grid(centre: Floats, radius: float, voxel: float) -> VoxelGrid:
    """Return the voxels that contain a ball, with a margin of one voxel on each side."""
    with np.errstate(over="ignore"):
        first, last = np.floor((centre - radius) / voxel) - 1.0, np.floor((centre + radius) / voxel) + 1.0
        sides = last - first + 1.0
        count = float(np.prod(sides))
    furthest = float(np.abs(centre).max()) + radius
    if not count <= _MAX_VOXELS or not furthest / voxel < MAX_INDEX:
        least = max(2.0 * radius / (_MAX_VOXELS ** (1 / 3) - 4.0), furthest / MAX_INDEX)
        raise BadArgument(
            f"voxel={voxel:g} would make {count:.3g} voxels, more than {_MAX_VOXELS:.0e}; give at least {least:.2g} m"
        )
    return VoxelGrid(voxel, *(tuple(numbers.astype(int).tolist()) for numbers in (first, sides)))
