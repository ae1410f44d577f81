"""Reach maps in files, and the ranges of samples of a map."""

from __future__ import annotations

import io
import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats, choice, colours, whole_number
from nao_kin._core.files import read_arrays, read_bytes
from nao_kin._core.text import abbreviated, quoted
from nao_kin.errors import BadArgument, BadInputFile

# --- Ranges of sample numbers: requested, done and remaining ones.

SampleRange = tuple[int, int]

# If all these samples fall into one voxel with the largest manipulability, the sum is still below 2⁶³.
MAX_SAMPLES = 2**32


def requested_range(samples: int | SampleRange, shard: tuple[int, int] | None) -> SampleRange:
    """Return (start, stop) for a number of samples or a range of them, or for its k-th of n parts, shard (k, n)."""
    if isinstance(samples, (tuple, list)):
        if len(samples) != 2:
            raise BadArgument(f"samples must be a number, or (start, stop), got {quoted(samples)}")
        start = whole_number(samples[0], "the first sample", 0)
        stop = whole_number(samples[1], "the end of the samples", start + 1, MAX_SAMPLES)
    else:
        start, stop = 0, whole_number(samples, "samples", 1, MAX_SAMPLES)
    if shard is None:
        return start, stop
    if not isinstance(shard, (tuple, list)) or len(shard) != 2:
        raise BadArgument(f"shard must be (k, n), the k-th of n parts, got {quoted(shard)}")
    count = whole_number(shard[1], "the number of shards", 1, stop - start)
    k = whole_number(shard[0], "the shard", 0, count - 1)
    return start + (stop - start) * k // count, start + (stop - start) * (k + 1) // count


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


def without(requested: SampleRange, done: Sequence[SampleRange]) -> tuple[SampleRange, ...]:
    """Return `requested` minus `done`, whose ranges are disjoint and ascending."""
    remaining, (start, stop) = [], requested
    for first, last in (*done, (stop, stop)):
        if start < min(first, stop):
            remaining.append((start, min(first, stop)))
        start = max(start, last)
    return tuple(remaining)


# --- Reach maps in files: NumPy archives, which can be read back, and VTK and PLY for other programs.

COLUMNS = ("best", "mean", "count", "coverage")
_FORMAT = "nao_kin reach map 1"
# During counting, every voxel of the box around the reach takes 32 bytes.
MAX_VOXELS = 50_000_000
_WRONG = "no reach map of nao-kin (.npz), or an incomplete one"


def check_column(name: str) -> None:
    """Raise `UnknownName` if `name` is not a column of a map."""
    choice(name, COLUMNS, "number of a voxel")


def npz_bytes(settings: Mapping[str, Any], ranges: Sequence[SampleRange], arrays: Mapping[str, NDArray[Any]]) -> bytes:
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


def read_npz(path: Path | str) -> tuple[dict[str, Any], tuple[SampleRange, ...], dict[str, NDArray[Any]]]:
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


def vtk_bytes(title: str, indices: NDArray[np.int32], voxel: float, columns: Mapping[str, Floats]) -> bytes:
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


def ply_bytes(points: Floats, values: Floats) -> bytes:
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
