"""The map: number, manipulability and directions of the samples of a hand in each voxel."""

from __future__ import annotations

import io
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, as_floats, choice, colours, join_poses, whole_number
from nao_kin._core.files import check_replaceable, read_arrays, read_bytes, write_document
from nao_kin._core.text import abbreviated
from nao_kin.errors import BadArgument, BadInputFile, WrongShape
from nao_kin.reach._kernels import DIRECTION_COUNT, Integers
from nao_kin.rotations import rot_z

# --- Ranges of sample numbers.

SampleRange = tuple[int, int]


def union(ranges: Iterable[SampleRange]) -> tuple[SampleRange, ...]:
    """Return the same samples in as few ascending ranges as possible."""
    merged: list[SampleRange] = []
    for start, stop in sorted(ranges):
        if merged and start <= merged[-1][1]:
            merged[-1] = merged[-1][0], max(stop, merged[-1][1])
        elif start < stop:
            merged.append((start, stop))
    return tuple(merged)


def overlap(ranges: Sequence[SampleRange], others: Sequence[SampleRange]) -> SampleRange | None:
    """Return the first range that is in both; None if they share nothing."""
    shared = ((max(a, c), min(b, d)) for a, b in ranges for c, d in others)
    return next(((start, stop) for start, stop in shared if start < stop), None)


# --- The pose with most targets within reach.

# Positions compared in one step, 8 bytes each.
_MAX_POSITIONS = 30_000_000
# The lower bits of a position's score sum the manipulability at the targets, the higher ones count the targets.
_BITS = 40


@dataclass(frozen=True, eq=False)
class Stance:
    """An upright pose for the reference frame of a reach map.

    Attributes:
        position: its origin in the targets' frame, shape (3,) [m].
        yaw: its heading about the vertical, in (−π, π] [rad].
        reached: which targets are within reach, shape (m,).
        manipulability: the best manipulability at each target, 0 out of reach, shape (m,).
    """

    position: Floats
    yaw: float
    reached: NDArray[np.bool_]
    manipulability: Floats

    @property
    def count(self) -> int:
        """Number of targets within reach."""
        return int(self.reached.sum())

    @property
    def pose(self) -> Floats:
        """T_targets_reference: from coordinates in the reference frame to those of the targets, shape (4, 4)."""
        return join_poses(rot_z(self.yaw), self.position)


def _heights(height: float | tuple[float, float] | None) -> tuple[float, float] | None:
    if height is None:
        return None
    array = as_floats(height, (), "height")
    if array.shape not in ((), (2,)):
        raise WrongShape("height", "() or (2,)", array.shape)
    low, high = np.broadcast_to(array, 2).tolist()
    if low > high:
        raise BadArgument(f"height must be from low to high, got {low:g} and {high:g}")
    return low, high


class _Votes:
    """Votes of the targets for positions on a grid.

    From position g, a target in voxel t is within reach if voxel t − g is in the map, so each target adds the mirrored
    map, moved to t. Positions are (g + ½) · voxel with integers g, turned by the heading, so that targets with round
    coordinates are in the middle of voxels, not between two. If a height is given, the grid starts at its low end.
    """

    def __init__(self, reach: ReachMap, targets: Floats, heights: tuple[float, float] | None) -> None:
        self._targets, self._voxel, self._heights = targets, reach.voxel, heights
        self._low, high = reach.indices.min(axis=0).astype(np.int64), reach.indices.max(axis=0).astype(np.int64)
        self._sides = high - self._low + 1
        # With many targets there are fewer bits for each.
        shift = max(0, int(reach.best_steps.max()).bit_length() + len(targets).bit_length() - _BITS)
        scores = np.zeros(tuple(self._sides), dtype=np.int64)
        scores[tuple((reach.indices - self._low).T)] = (1 << _BITS) + (reach.best_steps >> shift)
        self._mirrored = scores[::-1, ::-1, ::-1]

    def best_position(self, R: Floats) -> tuple[int, Floats]:
        """Return the best score at a heading, and its position in the targets' frame."""
        origin = np.full(3, 0.5 * self._voxel)
        if self._heights is not None:
            origin[2] = self._heights[0]
        cells = np.floor((self._targets @ R - origin) / self._voxel)
        # The start of the mirrored map after it is moved to each target.
        starts: Integers = cells.astype(np.int64) - (self._low + self._sides - 1)
        first, last = starts.min(axis=0), starts.max(axis=0) + self._sides
        if self._heights is not None:
            first[2], last[2] = 0, math.floor((self._heights[1] - self._heights[0]) / self._voxel + 1e-9) + 1
        if math.prod((last - first).tolist()) > _MAX_POSITIONS:
            raise BadArgument("targets are too far apart to compare all positions between them: give fewer at a time")
        votes = np.zeros(tuple(last - first), dtype=np.int64)
        for start in starts - first:
            low, high = np.maximum(start, 0), np.minimum(start + self._sides, votes.shape)
            if (low < high).all():
                votes[tuple(map(slice, low, high))] += self._mirrored[tuple(map(slice, low - start, high - start))]
        best = int(np.argmax(votes))
        cell = np.array(np.unravel_index(best, votes.shape)) + first
        return int(votes.flat[best]), R @ (origin + cell * self._voxel)


# --- The map: number, manipulability and directions of the samples of a hand in each voxel.

# Each voxel index fits into this many bits, so that three of them make one key.
_INDEX_BITS = 20
MAX_INDEX = 2**_INDEX_BITS - 2


@dataclass(frozen=True)
class ReachSettings:
    """The settings that two maps must share to be added.

    Attributes:
        robot: name of the robot.
        frame: the frame whose positions are counted.
        reference: the frame in which the positions are given.
        joints: the joints drawn at random.
        chain: fingerprint of the geometry and the limits between the two frames.
        voxel: edge of a voxel [m].
        seed: seed of the samples.
        step: unit of the integers in which manipulability is summed.
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
        """Raise `BadArgument` with the first setting that differs in `other`, the settings of `what`."""
        for name, mine in asdict(self).items():
            theirs = getattr(other, name)
            if mine == theirs:
                continue
            if name in ("joints", "chain", "step"):
                raise BadArgument(f"{what} is of a robot {self.robot} with other joints, limits or lengths")
            raise BadArgument(f"{what} is of another {name}: {abbreviated(theirs)} instead of {abbreviated(mine)}")


@dataclass(frozen=True, eq=False)
class ReachMap:
    """Hand positions counted in voxels; `workspace` makes it.

    Voxel (i, j, k) contains the points p with ⌊p / voxel⌋ = (i, j, k), in the reference frame. Each voxel with at least
    one sample has a row; rows are in ascending order of the indices. Maps of different samples with the same settings
    can be added: `part_a + part_b`.

    Attributes:
        settings: what the maps must share to be added: names of `robot`, `frame` and `reference`; the `joints` drawn at
            random; `chain`, a fingerprint of the geometry and limits between the two frames; `voxel` [m]; `seed`; and
            `step`, the unit in which manipulability is summed.
        ranges: the samples counted, as ranges (start, stop) in ascending order.
        indices: (i, j, k) of every voxel, shape (m, 3).
        count: samples in it, shape (m,).
        best_steps: its largest manipulability, in steps of `settings.step`, shape (m,).
        total_steps: sum of the manipulability of its samples in the same steps, shape (m,).
        masks: directions of the hand's x axis, bit d for cell d of `direction_cells`, shape (m,).
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

    # --- contents -------------------------------------------------------------------------------------------------

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
        """Total volume of the voxels [m³]."""
        return len(self.count) * self.voxel**3

    @property
    def centres(self) -> Floats:
        """Centre of every voxel in the reference frame, shape (m, 3) [m]."""
        return np.asarray((self.indices + 0.5) * self.voxel)

    @property
    def best(self) -> Floats:
        """Largest manipulability in every voxel, shape (m,), in the unit given at `workspace`."""
        return np.asarray(self.best_steps * self.settings.step)

    @property
    def mean(self) -> Floats:
        """Mean manipulability of the samples of every voxel, shape (m,)."""
        return np.asarray(self.total_steps / self.count * self.settings.step)

    @property
    def directions(self) -> NDArray[np.bool_]:
        """Which of the 48 cells of `direction_cells` contain a direction of the hand's x axis, shape (m, 48)."""
        return np.asarray((self.masks[:, None] >> np.arange(DIRECTION_COUNT)) & 1, dtype=np.bool_)

    @property
    def coverage(self) -> Floats:
        """Share of the sphere of directions of the hand's x axis, shape (m,), in (0, 1]."""
        return np.asarray(self.directions.mean(axis=1, dtype=np.float64))

    def column(self, name: str) -> Floats:
        """Return one number per voxel by name: "count", "best", "mean" or "coverage", shape (m,).

        Examples:
            >>> reach = nk.reach.workspace(nk.load_nao(), "LArm", 1000, voxel=0.05)
            >>> bool((reach.column("coverage") <= 1).all())
            True
        """
        choice(name, COLUMNS, "column of a reach map", "best and mean are those of the manipulability")
        return np.asarray(getattr(self, name), dtype=np.float64)

    # --- queries --------------------------------------------------------------------------------------------------

    def reachable(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Return whether a sample fell into the voxel of each point (..., 3) in the reference frame, shape (...).

        A reachable voxel at the boundary without a sample counts as out of reach.

        Examples:
            >>> reach = nk.reach.workspace(nk.load_nao(), "LArm", 1000, voxel=0.05)
            >>> reach.reachable([[0.15, 0.15, 0.1], [2.0, 0.0, 0.0]]).tolist()
            [True, False]
        """
        return np.asarray(self._rows(as_floats(points, (3,), "points")) >= 0)

    def best_at(self, points: ArrayLike) -> Floats:
        """Return the largest manipulability in the voxel of each point (..., 3), shape (...); 0 out of reach."""
        rows = self._rows(as_floats(points, (3,), "points"))
        return np.asarray(np.append(self.best, 0.0)[rows])

    def best_stance(
        self, targets: ArrayLike, *, height: float | tuple[float, float] | None = None, yaws: int = 36
    ) -> Stance:
        """Return the upright pose of the reference frame from which most targets are within reach.

        Positions are tried on a grid with the size of the voxels, headings in equal steps of the full turn. Among
        poses with equally many targets within reach, the one with the largest sum of best manipulability at the targets
        is returned, or the first of several such poses. The reference must be a frame that is upright if the robot is,
        such as the trunk.

        Args:
            targets: points in a frame with z up, shape (m, 3) with m ≥ 1 [m].
            height: height of the reference frame in the targets' frame: one value, or (low, high); None for any [m].
            yaws: number of headings, the first along x.

        Returns:
            The stance: its `position`, shape (3,) [m], and heading `yaw`, in (−π, π] [rad], in the targets' frame, both
            in `pose`, shape (4, 4); which targets are `reached`, shape (m,), and their `count`; and the best
            `manipulability` at each target, 0 out of reach, shape (m,).

        Raises:
            BadArgument: the map is empty, or the targets are so far apart that their grid is too large.

        Examples:
            >>> reach = nk.reach.workspace(nk.load_nao(), "LArm", 1000, voxel=0.05)
            >>> stance = reach.best_stance([[0.5, 0.0, 0.1], [0.5, 0.1, 0.1]])
            >>> stance.reached.tolist()
            [True, True]
        """
        points = as_floats(targets, (3,), "targets")
        if points.ndim != 2 or len(points) == 0:
            raise WrongShape("targets", "(m, 3) with m ≥ 1", points.shape)
        if len(self.count) == 0:
            raise BadArgument("the map is empty: nothing is within reach")
        headings = whole_number(yaws, "yaws", 1, 1_000_000)
        votes = _Votes(self, points, _heights(height))
        best, position, yaw = -1, np.zeros(3), 0.0
        for heading in np.arange(headings) * (2.0 * math.pi / headings):
            score, found = votes.best_position(rot_z(heading))
            if score > best:
                best, position, yaw = score, found, float(heading)
        yaw = yaw - 2.0 * math.pi if yaw > math.pi else yaw
        seen = (points - position) @ rot_z(yaw)
        return Stance(position, yaw, self.reachable(seen), self.best_at(seen))

    # --- sums of maps ---------------------------------------------------------------------------------------------

    def __add__(self, other: object) -> ReachMap:
        """Return the map of the samples of both maps, bit for bit the same as from one run.

        Raises:
            BadArgument: their robots, frames, voxels or seeds differ, or they share samples.
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
        """Return the same samples in voxels that are `factor` times as wide.

        Examples:
            >>> reach = nk.reach.workspace(nk.load_nao(), "LArm", 1000, voxel=0.05)
            >>> reach.coarser(2).settings.voxel
            0.1
        """
        factor = whole_number(factor, "factor", 1, 10**18)
        settings = replace(self.settings, voxel=self.voxel * factor)
        rows = {name: getattr(self, name) for name in _COUNTED}
        # A factor larger than all indices leaves only their signs.
        return _collected(settings, self.ranges, self.indices // min(factor, 2**_INDEX_BITS), rows)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, ReachMap):
            return NotImplemented
        same = self.settings == other.settings and self.ranges == other.ranges
        return same and all(np.array_equal(getattr(self, name), getattr(other, name)) for name in ROW_ARRAYS)

    __hash__ = None  # type: ignore[assignment]

    # --- files ----------------------------------------------------------------------------------------------------

    def save(self, path: Path | str, *, overwrite: bool = False) -> Path:
        """Write the map to a NumPy archive (.npz) that `load` reads back; equal maps give equal files.

        Raises:
            BadArgument: the file exists, without `overwrite`, or cannot be written.

        Examples:
            >>> reach = nk.reach.workspace(nk.load_nao(), "LArm", 1000, voxel=0.05)
            >>> reach.save("reach.npz").name
            'reach.npz'
        """
        check_replaceable(path, overwrite=overwrite)
        arrays = {name: getattr(self, name) for name in ROW_ARRAYS}
        content = _npz_bytes(asdict(self.settings), self.ranges, arrays)
        return write_document(path, content, overwrite=overwrite)[0]

    def save_vtk(self, path: Path | str, *, overwrite: bool = False) -> Path:
        """Write a legacy VTK file, for ParaView for example: the box around the map as structured points.

        Every cell is a voxel with count, best, mean and coverage, all zero in a voxel without samples.

        Raises:
            BadArgument: the map is empty, or the file exists, without `overwrite`, or cannot be written.
        """
        check_replaceable(path, overwrite=overwrite)
        columns = {name: self.column(name) for name in COLUMNS}
        content = _vtk_bytes(self.settings.robot, self.indices, self.voxel, columns)
        return write_document(path, content, overwrite=overwrite)[0]

    def save_ply(self, path: Path | str, *, by: str = "best", overwrite: bool = False) -> Path:
        """Write a PLY file: the centres of the voxels as points, coloured from cold (smallest) to warm (largest).

        Args:
            path: the file.
            by: quantity of the colours: "count", "best", "mean" or "coverage".
            overwrite: replace an existing file.

        Raises:
            BadArgument: the map is empty, or the file exists, without `overwrite`, or cannot be written.
        """
        check_replaceable(path, overwrite=overwrite)
        return write_document(path, _ply_bytes(self.centres, self.column(by)), overwrite=overwrite)[0]

    # --- inside ---------------------------------------------------------------------------------------------------

    @cached_property
    def _keys(self) -> Integers:
        return _keys_of(self.indices)

    def _rows(self, points: Floats) -> Integers:
        """Return the row of the voxel of each point; −1 for none."""
        with np.errstate(over="ignore"):
            cells = np.floor(points / self.voxel)
        near = np.asarray((np.abs(cells) < 2.0**_INDEX_BITS).all(axis=-1))
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
    settings: ReachSettings, ranges: Iterable[SampleRange], indices: NDArray[np.integer[Any]], totals: Integers
) -> ReachMap:
    """Return the map of voxels (m, 3) in ascending order with rows (m, 4) of count, best, sum and directions."""
    columns = (np.ascontiguousarray(totals[:, column]) for column in range(4))
    return ReachMap(settings, union(ranges), np.asarray(indices, dtype=np.int32), *columns)


def _collected(
    settings: ReachSettings, ranges: tuple[SampleRange, ...], indices: NDArray[np.int32], rows: dict[str, Integers]
) -> ReachMap:
    """Return the map of rows; several rows may belong to one voxel."""
    _, first, place = np.unique(_keys_of(indices), return_index=True, return_inverse=True)
    totals = np.zeros((len(first), 4), dtype=np.int64)
    for column, (name, add) in enumerate(zip(_COUNTED, (np.add, np.maximum, np.add, np.bitwise_or), strict=True)):
        add.at(totals[:, column], place, rows[name])
    return map_of(settings, ranges, indices[first], totals)


def _keys_of(indices: NDArray[np.integer[Any]]) -> Integers:
    """Return one number for the three indices, in the same order."""
    shifted = np.asarray(indices, dtype=np.int64) + 2**_INDEX_BITS
    return np.asarray((shifted[..., 0] << 42) | (shifted[..., 1] << 21) | shifted[..., 2])


# --- Reach maps in files: NumPy archives, which can be read back, and VTK and PLY for other programs.

COLUMNS = ("best", "mean", "count", "coverage")
_FORMAT = "nao_kin reach map 1"
_WRONG = "no reach map of nao-kin (.npz), or an incomplete one"


def _npz_bytes(settings: Mapping[str, Any], ranges: Sequence[SampleRange], arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Return the parts of a map as a compressed archive."""
    parts: dict[str, Any] = {
        "format": np.array(_FORMAT),
        "settings": np.array(json.dumps(settings)),
        "ranges": np.array(ranges, dtype=np.int64).reshape(-1, 2),
        **arrays,
    }
    content = io.BytesIO()
    np.savez_compressed(content, **parts)
    return content.getvalue()


def _read_npz(path: Path | str) -> tuple[dict[str, Any], tuple[SampleRange, ...], dict[str, NDArray[Any]]]:
    """Read the parts of a map: settings, ranges, and the arrays of its voxels."""
    name = abbreviated(path)
    found = read_arrays(name, read_bytes(str(path), unpack=False), wrong=_WRONG)
    try:
        if "format" not in found or str(found.pop("format")) != _FORMAT:
            raise ValueError("of another format")
        settings = json.loads(str(found.pop("settings")))
        ranges = tuple((int(start), int(stop)) for start, stop in found.pop("ranges"))
        _check_arrays(found, sum(stop - start for start, stop in ranges))
    except (KeyError, TypeError, ValueError, RecursionError) as error:
        raise BadInputFile(name, f"{_WRONG}: {abbreviated(error)}") from None
    return settings, ranges, found


def _check_arrays(arrays: Mapping[str, NDArray[Any]], samples: int) -> None:
    rows = len(arrays["count"])
    for name, array in arrays.items():
        if array.shape != ((rows, 3) if name == "indices" else (rows,)) or array.dtype.kind != "i":
            raise ValueError(f"{name} has shape {array.shape} and type {array.dtype}")
    if int(arrays["count"].sum()) != samples:
        raise ValueError("the counts are not those of its samples")


def _vtk_bytes(title: str, indices: NDArray[np.int32], voxel: float, columns: Mapping[str, Floats]) -> bytes:
    """Return voxels as the cells of structured points, in big-endian binary.

    Source: The VTK User's Guide, 11th edition, VTK File Formats, Simple Legacy Formats.
    """
    _check_any(indices)
    first = indices.min(axis=0)
    shape = indices.max(axis=0) - first + 1
    cell = np.ravel_multi_index(tuple((indices - first).T), tuple(shape), order="F")  # x runs fastest
    cells = int(np.prod(shape))
    head = (
        "# vtk DataFile Version 3.0",
        abbreviated(title.encode("ascii", "replace").decode(), 200),
        "BINARY",
        "DATASET STRUCTURED_POINTS",
        "DIMENSIONS " + " ".join(str(side + 1) for side in shape),
        "ORIGIN " + " ".join(repr(float(corner)) for corner in first * voxel),
        f"SPACING {voxel!r} {voxel!r} {voxel!r}",
        f"CELL_DATA {cells}",
    )
    content = io.BytesIO()
    content.write(("\n".join(head) + "\n").encode("ascii"))
    for name, values in columns.items():
        dense = np.zeros(cells, dtype=">f8")
        dense[cell] = values
        content.write(f"SCALARS {name} double 1\nLOOKUP_TABLE default\n".encode("ascii"))
        content.write(dense.tobytes() + b"\n")
    return content.getvalue()


def _ply_bytes(points: Floats, values: Floats) -> bytes:
    """Return coloured points, cold for the smallest value and warm for the largest."""
    from trimesh import PointCloud

    _check_any(points)
    low, high = float(values.min()), float(values.max())
    rgb = colours(values, low, high if high > low else low + 1.0)
    rgba = np.column_stack([np.round(255.0 * rgb), np.full(len(rgb), 255.0)]).astype(np.uint8)
    make: Any = PointCloud
    return bytes(make(points, colors=rgba).export(file_type="ply"))


def _check_any(rows: NDArray[Any]) -> None:
    if len(rows) == 0:
        raise BadArgument("the map is empty: nothing to write")


def load(path: Path | str) -> ReachMap:
    """Read a map that `ReachMap.save` wrote.

    Raises:
        BadInputFile: the file cannot be read, or is not a reach map.

    Examples:
        >>> reach = nk.reach.workspace(nk.load_nao(), "LArm", 1000, voxel=0.05)
        >>> nk.reach.load(reach.save("larm.npz")) == reach
        True
    """
    settings, ranges, arrays = _read_npz(path)
    try:
        settings["joints"] = tuple(settings["joints"])
        return ReachMap(ReachSettings(**settings), ranges, **arrays)
    except (TypeError, KeyError):
        raise BadInputFile(abbreviated(path), "a reach map of nao-kin with parts that this version lacks") from None
