"""Drawing configurations and counting where they take the hand."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, wait

import numpy as np

from nao_kin._core.arrays import MAX_THREADS, Floats, as_floats, whole_number
from nao_kin._core.process import usable_cores
from nao_kin._kernels.cache import first_rows
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.reach._kernels import KERNELS, ChainTables, Integers, MovedChain, VoxelGrid, moved_chain
from nao_kin.reach.files import MOST_VOXELS, SampleRange, asked_range, union, without
from nao_kin.reach.reach_map import MOST_INDEX, ReachMap, ReachSettings, map_of
from nao_kin.robot import RobotModel, check_robot

# Samples between two looks at whether to stop; their arrays fit into a core's own cache.
_BLOCK = 8192
# So many are counted as Python at a time, until the kernels are worth waiting for.
_FEW = 64
# Philox turns one count into four words.
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
    """A map of where a frame can be: voxels with the number of samples, manipulability and directions.

    A sample is a configuration drawn as `RobotModel.random` does: each joint uniform in its box, and where a table
    couples it to another joint, the box mapped onto the range at that joint's value. Sample i is a function of seed and
    i alone: words i·c to i·c + c − 1 of NumPy's Philox generator are its c joint values. Everything is counted in
    integers, so that maps of parts add up to the map of the whole bit for bit, whatever the parts and threads.

    The manipulability is that of the position, w = √det(J_v J_vᵀ), with J_v the (3, n) Jacobian of the frame's origin
    by the n joints that move it: the volume, up to a factor, of the ellipsoid of velocities at unit joint speeds. It is
    zero where the hand cannot move along some direction. With less than three joints w = √det(J_vᵀ J_v). Its unit is
    m³ for three or more turning joints. (The six-row Jacobian of a five-joint arm has no full rank anywhere.)

    Args:
        robot: any robot; a floating base is left where it is.
        frame: a frame, or the name of a chain, which stands for its end effector.
        samples: how many, or (start, stop) for a part of them.
        voxel: edge of a voxel [m].
        seed: seed of the samples.
        reference: the frame in which positions are counted; None for the root.
        shard: (k, n) for the k-th of n equal parts of the samples, k from 0.
        previous: a map of the same settings: what it has is not drawn again, and is in the result.
        threads: how many; None for one for each core that this process may use.
        progress: called with the samples done and asked for, now and then, in the calling thread.
        stop: asked now and then; when it says yes, the map of what is done is returned.

    Returns:
        The map; its `samples` and `ranges` say what is in it.

    Raises:
        UnknownName: no such frame or chain.
        BadArgument: nothing moves the frame; a sliding joint without limits; samples, shard, seed or threads out of
            range; a voxel that is not positive or so small that there are too many; `previous` of other settings.

    Source: T. Yoshikawa, Manipulability of Robotic Mechanisms, The International Journal of Robotics Research 4 (1985)
    3–9, equation 9, with the translational part of J as in Yoshikawa, Translational and Rotational Manipulability of
    Robotic Manipulators, Proc. IECON 1991.

    Examples:
        >>> reach = nk.reach.workspace(nk.load_nao(), "LArm", 1000, voxel=0.05)
        >>> reach.column("count").shape == reach.column("best").shape
        True
    """
    check_robot(robot)
    asked = asked_range(samples, shard)
    workers = usable_cores() if threads is None else whole_number(threads, "threads", 1, MAX_THREADS)
    chain, settings = _prepared(robot, frame, voxel, seed, reference)
    first, shape = _box(chain.centre, chain.radius, settings.voxel)
    done: tuple[SampleRange, ...] = ()
    if previous is not None:
        if not isinstance(previous, ReachMap):
            raise BadArgument(f"previous must be a ReachMap, got {type(previous).__name__}")
        settings.check_same(previous.settings, "the previous map")
        done = previous.ranges
    counter = _Counter(chain.tables, settings, first, shape)
    counter.count(without(asked, done), workers, progress, stop)
    rows = np.flatnonzero(counter.totals[:, 0])
    indices = np.stack(np.unravel_index(rows, shape), axis=-1) + np.array(first)
    counted = map_of(settings, counter.done, indices, counter.totals[rows])
    return counted if previous is None else previous + counted


def map_settings(
    robot: RobotModel, frame: str, *, voxel: float = 0.01, seed: int = 0, reference: str | None = None
) -> ReachSettings:
    """The settings of the map that `workspace` would make; arguments and errors are its own."""
    check_robot(robot)
    return _prepared(robot, frame, voxel, seed, reference)[1]


def _prepared(
    robot: RobotModel, frame: str, voxel: float, seed: int, reference: str | None
) -> tuple[MovedChain, ReachSettings]:
    """What moves the frame, and the settings of its map."""
    edge, number = _edge(voxel), whole_number(seed, "seed", 0, 2**64 - 1)
    chain = moved_chain(robot, frame, reference)
    _box(chain.centre, chain.radius, edge)  # which refuses voxels that are too many
    settings = ReachSettings(
        robot=robot.name,
        frame=chain.frame,
        reference=chain.reference,
        joints=chain.joints,
        chain=chain.digest,
        voxel=edge,
        seed=number,
        step=chain.manipulability_step,
    )
    return chain, settings


class _Counter:
    """Counts samples into one array, in several threads."""

    def __init__(
        self, chain: ChainTables, settings: ReachSettings, first: tuple[int, int, int], shape: tuple[int, int, int]
    ) -> None:
        self._chain, self._settings, self._grid = chain, settings, VoxelGrid(settings.voxel, first, shape)
        self._lock = threading.Lock()
        self._ending = threading.Event()
        self._done: list[SampleRange] = []
        # One row for each voxel of the box: count, best, sum, directions.
        self.totals: Integers = np.zeros((math.prod(shape), 4), dtype=np.int64)

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
        """Count the samples of these ranges, until all are done or `stop` says so."""
        few = _blocks(ranges, _FEW)
        number = sum(math.ceil((stop - start) / _FEW) for start, stop in ranges)
        uncompiled = tuple(kernel.uncompiled for kernel in KERNELS)
        if first_rows(KERNELS, lambda part: self._count_block(next(few), uncompiled), number) < number:
            for kernel in KERNELS:
                kernel.ready()  # here, and not in a thread, where nobody listens
        blocks = _blocks([left for part in ranges for left in without(part, self.done)], _BLOCK)
        asked = sum(stop - start for start, stop in ranges)
        with ThreadPoolExecutor(workers, thread_name_prefix="nao_kin_reach") as pool:
            try:
                running = {pool.submit(self._work, blocks) for _ in range(workers)}
                while running:
                    finished, running = wait(running, timeout=_SECONDS_BETWEEN_REPORTS, return_when="FIRST_EXCEPTION")
                    for worker in finished:
                        worker.result()
                    if progress is not None:
                        progress(sum(stop - start for start, stop in self.done), asked)
                    if stop is not None and stop():
                        self._ending.set()
            finally:
                self._ending.set()  # whatever came up: no thread goes on

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
    """The random words of these samples, shape (m, joints); NumPy promises them to be the same in every version."""
    start, stop = block[0] * joints, block[1] * joints
    generator = np.random.Philox(seed)
    generator.advance(start // _WORDS)
    words = generator.random_raw(stop - start // _WORDS * _WORDS)[start % _WORDS :]
    return words.reshape(-1, joints)


def _blocks(ranges: Sequence[SampleRange], size: int) -> Iterator[SampleRange]:
    for start, stop in ranges:
        for first in range(start, stop, size):
            yield first, min(first + size, stop)


def _edge(voxel: float) -> float:
    array = as_floats(voxel, (), "voxel")
    if array.shape != ():
        raise WrongShape("voxel", "()", array.shape)
    if not array > 0.0:
        raise BadArgument(f"voxel must be positive, got {float(array):g}")
    return float(array)


def _box(centre: Floats, radius: float, voxel: float) -> tuple[tuple[int, int, int], tuple[int, int, int]]:
    """First index and number of the voxels along each axis that hold a ball, with one to spare on each side."""
    with np.errstate(over="ignore"):
        first, last = np.floor((centre - radius) / voxel) - 1.0, np.floor((centre + radius) / voxel) + 1.0
        sides = last - first + 1.0
        count = float(np.prod(sides))
    furthest = float(np.abs(centre).max()) + radius
    if not count <= MOST_VOXELS or not furthest / voxel < MOST_INDEX:
        least = max(2.0 * radius / (MOST_VOXELS ** (1 / 3) - 4.0), furthest / MOST_INDEX)
        raise BadArgument(
            f"voxels of {voxel:g} m would be {count:.3g} to count, and {MOST_VOXELS:.0e} are the most; "
            f"take voxels of at least {least:.2g} m"
        )
    x, y, z = (int(index) for index in first)
    width, depth, height = (int(side) for side in sides)
    return (x, y, z), (width, depth, height)
