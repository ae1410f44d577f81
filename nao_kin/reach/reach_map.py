"""The map: for every voxel that a hand reached, how often, how well, and in which directions."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, as_floats, whole_number
from nao_kin._core.text import abbreviated
from nao_kin.errors import BadArgument, BadInputFile, WrongShape
from nao_kin.reach import files
from nao_kin.reach._kernels import DIRECTION_COUNT, Integers
from nao_kin.reach.files import SampleRange, overlap, union
from nao_kin.rotations import rot_z

# --- Where to stand so that most targets are within reach.

# Places that are compared at once, 8 bytes each.
_MOST_PLACES = 30_000_000
# A place's score: the number of targets above these bits, the sum of their manipulability in them.
_BITS = 40


@dataclass(frozen=True, eq=False)
class Stance:
    """A place for the reference frame of a reach map, upright.

    Attributes:
        position: its origin in the targets' frame, shape (3,) [m].
        yaw: its heading about the vertical, in (−π, π] [rad].
        reached: which targets are within reach, shape (m,).
        manipulability: the best manipulability at each target, 0 out of reach, shape (m,).

    Examples:
        >>> reach = nk.reach.workspace(nk.load_nao(), "LArm", 1000, voxel=0.05)
        >>> stance = reach.best_stance([[0.5, 0.0, 0.1]])
        >>> stance.position.shape, bool(stance.reached.all())
        ((3,), True)
    """

    position: Floats
    yaw: float
    reached: NDArray[np.bool_]
    manipulability: Floats

    @property
    def count(self) -> int:
        """How many targets are within reach."""
        return int(self.reached.sum())

    @property
    def pose(self) -> Floats:
        """T_targets_reference: coordinates in the reference frame to those of the targets, shape (4, 4)."""
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = rot_z(self.yaw), self.position
        return T


def best_stance(reach: ReachMap, targets: ArrayLike, height: float | tuple[float, float] | None, yaws: int) -> Stance:
    """As `ReachMap.best_stance`.

    A target in voxel t, counted from the place, is within reach from place g when voxel t − g is in the map. So every
    target votes for the map, mirrored, moved to t; the votes of all targets are counted on one grid, heading by
    heading.
    """
    points = as_floats(targets, (3,), "targets")
    if points.ndim != 2 or len(points) == 0:
        raise WrongShape("targets", "(m, 3) with m ≥ 1", points.shape)
    if len(reach.count) == 0:
        raise BadArgument("the map is empty: nothing is within reach")
    headings = whole_number(yaws, "yaws", 1)
    votes = _Votes(reach, points, _heights(height))
    best, place, yaw = -1, np.zeros(3), 0.0
    for heading in np.arange(headings) * (2.0 * math.pi / headings):
        score, found = votes.best_place(rot_z(heading))
        if score > best:
            best, place, yaw = score, found, float(heading)
    yaw = yaw - 2.0 * math.pi if yaw > math.pi else yaw
    seen = (points - place) @ rot_z(yaw)
    return Stance(place, yaw, reach.reachable(seen), reach.best_at(seen))


def _heights(height: float | tuple[float, float] | None) -> tuple[float, float] | None:
    if height is None:
        return None
    array = as_floats(height, (), "height")
    if array.shape not in ((), (2,)):
        raise WrongShape("height", "() or (2,)", array.shape)
    low, high = (float(array), float(array)) if array.shape == () else (float(array[0]), float(array[1]))
    if low > high:
        raise BadArgument(f"height must be from low to high, got {low:g} and {high:g}")
    return low, high


class _Votes:
    """Counts, place by place, which targets are within reach there, and how well.

    Places are the points (g + ½) · voxel with whole numbers g, turned by the heading: targets on round numbers then
    stand in the middle of voxels, and not between two. Where the height is given, its places start at its low end.
    """

    def __init__(self, reach: ReachMap, targets: Floats, heights: tuple[float, float] | None) -> None:
        self._targets, self._voxel, self._heights = targets, reach.voxel, heights
        self._low, high = reach.indices.min(axis=0).astype(np.int64), reach.indices.max(axis=0).astype(np.int64)
        self._sides = high - self._low + 1
        # Large numbers of targets leave fewer bits for each.
        shift = max(0, int(reach.best_steps.max()).bit_length() + len(targets).bit_length() - _BITS)
        scores = np.zeros(tuple(self._sides), dtype=np.int64)
        scores[tuple((reach.indices - self._low).T)] = (1 << _BITS) + (reach.best_steps >> shift)
        self._mirrored = scores[::-1, ::-1, ::-1]

    def best_place(self, R: Floats) -> tuple[int, Floats]:
        """The score of the best place at a heading, and the place in the targets' frame."""
        origin = np.full(3, 0.5 * self._voxel)
        if self._heights is not None:
            origin[2] = self._heights[0]
        cells = np.floor((self._targets @ R - origin) / self._voxel)
        if np.abs(cells).max() >= 2**40:
            raise BadArgument("targets are too far away for voxels of this size")
        # The mirrored map, moved to a target, starts at:
        starts: Integers = cells.astype(np.int64) - (self._low + self._sides - 1)
        first, last = starts.min(axis=0), starts.max(axis=0) + self._sides
        if self._heights is not None:
            first[2], last[2] = 0, math.floor((self._heights[1] - self._heights[0]) / self._voxel + 1e-9) + 1
        if math.prod((last - first).tolist()) > _MOST_PLACES:
            raise BadArgument("targets are too far apart to compare all places between them: give fewer at a time")
        votes = np.zeros(tuple(last - first), dtype=np.int64)
        for start in starts - first:
            low, high = np.maximum(start, 0), np.minimum(start + self._sides, votes.shape)
            if (low < high).all():
                votes[tuple(map(slice, low, high))] += self._mirrored[tuple(map(slice, low - start, high - start))]
        best = int(np.argmax(votes))
        place = np.array(np.unravel_index(best, votes.shape)) + first
        return int(votes.flat[best]), R @ (origin + place * self._voxel)


# --- The map: for every voxel that a hand reached, how often, how well, and in which directions.

# Voxel indices fit into this many bits each, so that the three of them are one key.
_INDEX_BITS = 20
MOST_INDEX = 2**_INDEX_BITS - 2

_Row = TypeVar("_Row", bound=np.generic)


@dataclass(frozen=True)
class ReachSettings:
    """What two maps must share to be parts of one.

    Attributes:
        robot: name of the robot.
        frame: the frame whose positions are counted.
        reference: the frame in which they are.
        joints: the joints that were drawn.
        chain: fingerprint of the geometry and the limits between the two frames.
        voxel: edge of a voxel [m].
        seed: seed of the samples.
        step: unit of the integers in which manipulability is summed.

    Examples:
        >>> settings = nk.reach.workspace(nk.load_nao(), "LArm", voxel=0.05, samples=1000).settings
        >>> settings.frame, settings.reference
        ('LArm', 'torso')
    """

    robot: str
    frame: str
    reference: str
    joints: tuple[str, ...]
    chain: str
    voxel: float
    seed: int
    step: float

    def check_same(self, other: ReachSettings, what: str) -> None:
        """Raise `BadArgument` with the first setting that differs from the one in `what`."""
        for name, mine in asdict(self).items():
            theirs = getattr(other, name)
            if mine == theirs:
                continue
            if name in ("joints", "chain", "step"):
                raise BadArgument(f"{what} is of a robot {self.robot} with other joints, limits or lengths")
            raise BadArgument(f"{what} is of another {name}: {abbreviated(theirs)} instead of {abbreviated(mine)}")


@dataclass(frozen=True, eq=False)
class ReachMap:
    """Hand positions counted in voxels, as `workspace` makes it.

    Voxel (i, j, k) holds the points p with ⌊p / voxel⌋ = (i, j, k), in the reference's frame. Only voxels that some
    sample fell into have a row, in ascending order of their indices. Maps of different samples of the same settings
    add up: `part_a + part_b`.

    Attributes:
        settings: robot, frames, voxel size and seed.
        ranges: the samples counted, as ranges (start, stop) in ascending order.
        indices: (i, j, k) of every voxel, shape (m, 3).
        count: samples in it, shape (m,).
        best_steps: its largest manipulability, in steps of `settings.step`, shape (m,).
        total_steps: sum of the manipulability of its samples in the same steps, shape (m,).
        masks: directions of the hand's x axis, bit d for cell d of `direction_cells`, shape (m,).

    Examples:
        >>> reach = nk.reach.workspace(nk.load_nao(), "LArm", 1000, voxel=0.05)
        >>> int(reach.column("count").sum())
        1000
    """

    settings: ReachSettings
    ranges: tuple[SampleRange, ...]
    indices: NDArray[np.int32] = field(repr=False)
    count: Integers = field(repr=False)
    best_steps: Integers = field(repr=False)
    total_steps: Integers = field(repr=False)
    masks: Integers = field(repr=False)

    def __post_init__(self) -> None:
        for name in ROW_ARRAYS:
            getattr(self, name).flags.writeable = False

    # --- what is in it --------------------------------------------------------------------------------------------

    @property
    def samples(self) -> int:
        """Number of samples counted."""
        return sum(stop - start for start, stop in self.ranges)

    @property
    def voxel(self) -> float:
        """Edge of a voxel [m]."""
        return self.settings.voxel

    @property
    def volume(self) -> float:
        """Volume of all voxels with a sample [m³]."""
        return len(self.count) * self.voxel**3

    @property
    def centres(self) -> Floats:
        """Middle of every voxel in the reference's frame, shape (m, 3) [m]."""
        return np.asarray((self.indices + 0.5) * self.voxel)

    @property
    def best(self) -> Floats:
        """Largest manipulability in every voxel, shape (m,); its unit is that of `workspace`."""
        return np.asarray(self.best_steps * self.settings.step)

    @property
    def mean(self) -> Floats:
        """Mean manipulability of the samples of every voxel, shape (m,)."""
        return np.asarray(self.total_steps / self.count * self.settings.step)

    @property
    def directions(self) -> NDArray[np.bool_]:
        """Which of the 48 cells of `direction_cells` the hand's x axis points into, shape (m, 48)."""
        return np.asarray((self.masks[:, None] >> np.arange(DIRECTION_COUNT)) & 1, dtype=np.bool_)

    @property
    def coverage(self) -> Floats:
        """Share of the sphere of directions that the hand's x axis points into, shape (m,), in (0, 1]."""
        return np.asarray(self.directions.mean(axis=1, dtype=np.float64))

    def column(self, name: str) -> Floats:
        """One number per voxel by name: "count", "best", "mean" or "coverage", shape (m,).

        Raises:
            UnknownName: another name.

        Examples:
            >>> reach = nk.reach.workspace(nk.load_nao(), "LArm", 1000, voxel=0.05)
            >>> bool((reach.column("coverage") <= 1).all())
            True
        """
        files.check_column(name)
        return np.asarray(getattr(self, name), dtype=np.float64)

    # --- what can be asked of it ----------------------------------------------------------------------------------

    def reachable(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Whether a sample fell into the voxel of a point.

        Samples are not all configurations: a voxel at the rim that no sample happened to find counts as out of reach.

        Args:
            points: in the reference's frame, shape (..., 3) [m].

        Returns:
            Shape (...).

        Raises:
            WrongShape, NotFinite, BadArgument: no points.

        Examples:
            >>> reach = nk.reach.workspace(nk.load_nao(), "LArm", 1000, voxel=0.05)
            >>> reach.reachable([[0.15, 0.15, 0.1], [2.0, 0.0, 0.0]]).tolist()
            [True, False]
        """
        return np.asarray(self._rows(as_floats(points, (3,), "points")) >= 0)

    def best_at(self, points: ArrayLike) -> Floats:
        """Largest manipulability in the voxel of a point, shape (...); 0 out of reach. Arguments as `reachable`.

        Examples:
            >>> reach = nk.reach.workspace(nk.load_nao(), "LArm", 1000, voxel=0.05)
            >>> float(reach.best_at([2.0, 0.0, 0.0]))
            0.0
        """
        rows = self._rows(as_floats(points, (3,), "points"))
        return np.asarray(np.append(self.best, 0.0)[rows])

    def best_stance(
        self, targets: ArrayLike, *, height: float | tuple[float, float] | None = None, yaws: int = 36
    ) -> Stance:
        """Where to put the reference frame, upright, so that most targets are within reach.

        Its position is looked for on a grid of the voxels' size, its heading on equal steps of the full turn. Among
        places from which equally many targets are within reach, the one with the largest sum of best manipulability at
        them wins, then the first. The frame must be one that stands upright when the robot does: the trunk's.

        Args:
            targets: points in a frame with z up, shape (m, 3) with m ≥ 1 [m].
            height: the height of the reference frame in that frame: one value, or from and to; None for any [m].
            yaws: number of headings, the first along x.

        Raises:
            WrongShape, NotFinite, BadArgument: no targets, no heights, no number of headings, an empty map; or targets
                so far apart that their grid is too large.

        Examples:
            >>> reach = nk.reach.workspace(nk.load_nao(), "LArm", 1000, voxel=0.05)
            >>> stance = reach.best_stance([[0.5, 0.0, 0.1], [0.5, 0.1, 0.1]])
            >>> stance.reached.tolist()
            [True, True]
        """
        return best_stance(self, targets, height, yaws)

    # --- parts and wholes -----------------------------------------------------------------------------------------

    def __add__(self, other: object) -> ReachMap:
        """The map of the samples of both, bit for bit that of one run.

        Raises:
            BadArgument: they are of different robots, frames, voxels or seeds, or share samples.
        """
        if not isinstance(other, ReachMap):
            return NotImplemented
        self.settings.check_same(other.settings, "the second map")
        shared = overlap(self.ranges, other.ranges)
        if shared is not None:
            raise BadArgument(f"both maps hold the samples from {shared[0]} to {shared[1]}")
        indices = np.concatenate([self.indices, other.indices])
        rows = {name: np.concatenate([getattr(self, name), getattr(other, name)]) for name in _COUNTED}
        return _collected(self.settings, union(self.ranges + other.ranges), indices, rows)

    def coarser(self, factor: int) -> ReachMap:
        """The same samples in voxels that are `factor` times as wide.

        Raises:
            BadArgument: no whole number ≥ 1.

        Examples:
            >>> reach = nk.reach.workspace(nk.load_nao(), "LArm", 1000, voxel=0.05)
            >>> reach.coarser(2).settings.voxel
            0.1
        """
        factor = whole_number(factor, "factor", 1)
        settings = replace(self.settings, voxel=self.voxel * factor)
        rows = {name: getattr(self, name) for name in _COUNTED}
        # A factor beyond all indices leaves the signs.
        return _collected(settings, self.ranges, self.indices // min(factor, 2**_INDEX_BITS), rows)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, ReachMap):
            return NotImplemented
        same = self.settings == other.settings and self.ranges == other.ranges
        return same and all(np.array_equal(getattr(self, name), getattr(other, name)) for name in ROW_ARRAYS)

    __hash__ = None  # type: ignore[assignment]

    # --- files ----------------------------------------------------------------------------------------------------

    def save(self, path: Path | str) -> Path:
        """Write the map to a NumPy archive (.npz) that `load` reads back; equal maps give equal files.

        Raises:
            BadArgument: the file cannot be written.

        Examples:
            >>> reach = nk.reach.workspace(nk.load_nao(), "LArm", 1000, voxel=0.05)
            >>> reach.save("reach.npz").name
            'reach.npz'
        """
        arrays = {name: getattr(self, name) for name in ROW_ARRAYS}
        return files.write_npz(path, asdict(self.settings), self.ranges, arrays)

    def save_vtk(self, path: Path | str) -> Path:
        """Write a legacy VTK file: the box around the map as structured points, the voxels its cells.

        Every cell has count, best, mean and coverage, zero where no sample fell. ParaView and VisIt cut and threshold
        it.

        Raises:
            BadArgument: the map is empty, or the file cannot be written.

        Examples:
            >>> reach = nk.reach.workspace(nk.load_nao(), "LArm", 1000, voxel=0.05)
            >>> reach.save_vtk("reach.vtk").name
            'reach.vtk'
        """
        columns = {name: self.column(name) for name in files.COLUMNS}
        return files.write_vtk(path, self.settings.robot, self.indices, self.voxel, columns)

    def save_ply(self, path: Path | str, *, colour_by: str = "best") -> Path:
        """Write a PLY file: the middles of the voxels as points, coloured from cold (least) to warm (most).

        Args:
            path: the file.
            colour_by: "count", "best", "mean" or "coverage".

        Raises:
            UnknownName: another name.
            BadArgument: the map is empty, or the file cannot be written.

        Examples:
            >>> reach = nk.reach.workspace(nk.load_nao(), "LArm", 1000, voxel=0.05)
            >>> reach.save_ply("reach.ply", colour_by="count").name
            'reach.ply'
        """
        return files.write_ply(path, self.centres, self.column(colour_by))

    # --- inside ---------------------------------------------------------------------------------------------------

    @cached_property
    def _keys(self) -> Integers:
        return _keys_of(self.indices)

    def _rows(self, points: Floats) -> Integers:
        """Row of the voxel of each point; −1 where there is none."""
        bound = 2.0**_INDEX_BITS
        with np.errstate(over="ignore"):
            cells = np.floor(points / self.voxel)
        near = np.asarray((np.abs(cells) < bound).all(axis=-1))
        keys = _keys_of(np.where(near[..., None], cells, 0.0).astype(np.int64))
        rows = np.searchsorted(self._keys, keys)
        found = near & (np.append(self._keys, -1)[rows] == keys)
        return np.where(found, rows, -1)

    def __repr__(self) -> str:
        settings = self.settings
        return (
            f"<ReachMap of {settings.frame} in {settings.reference} of {settings.robot}: {self.samples} samples in "
            f"{len(self.count)} voxels of {1000 * self.voxel:g} mm>"
        )


ROW_ARRAYS = tuple(row.name for row in fields(ReachMap) if row.name not in ("settings", "ranges"))
_COUNTED = ROW_ARRAYS[1:]


def map_of(
    settings: ReachSettings, ranges: Iterable[SampleRange], indices: NDArray[_Row], totals: Integers
) -> ReachMap:
    """The map of voxels (m, 3) in ascending order and their rows (m, 4) of count, best, sum and directions."""
    columns = (np.ascontiguousarray(totals[:, column]) for column in range(4))
    return ReachMap(settings, union(ranges), np.asarray(indices, dtype=np.int32), *columns)


def _collected(
    settings: ReachSettings, ranges: tuple[SampleRange, ...], indices: NDArray[np.int32], rows: dict[str, Integers]
) -> ReachMap:
    """The map of rows that may be of the same voxels."""
    _, first, place = np.unique(_keys_of(indices), return_index=True, return_inverse=True)
    totals = np.zeros((len(first), 4), dtype=np.int64)
    for column, (name, add) in enumerate(zip(_COUNTED, (np.add, np.maximum, np.add, np.bitwise_or), strict=True)):
        add.at(totals[:, column], place, rows[name])
    return map_of(settings, ranges, indices[first], totals)


def _keys_of(indices: NDArray[_Row]) -> Integers:
    """One number for three indices, ascending with them."""
    shifted = np.asarray(indices, dtype=np.int64) + 2**_INDEX_BITS
    return np.asarray((shifted[..., 0] << 42) | (shifted[..., 1] << 21) | shifted[..., 2])


def load(path: Path | str) -> ReachMap:
    """The map that `ReachMap.save` wrote to a file.

    Raises:
        BadInputFile: the file cannot be read, or holds no such map.

    Examples:
        >>> reach = nk.reach.workspace(nk.load_nao(), "LArm", 1000, voxel=0.05)
        >>> _ = reach.save("reach.npz")
        >>> nk.reach.load("reach.npz").settings == reach.settings
        True
    """
    settings, ranges, arrays = files.read_npz(path)
    try:
        settings["joints"] = tuple(settings["joints"])
        return ReachMap(ReachSettings(**settings), ranges, **arrays)
    except (TypeError, KeyError):
        raise BadInputFile(abbreviated(path), "a reach map of nao-kin with other parts than this version's") from None
