"""Motions as tables: CSV with a header of units, and NumPy's npz.

A table has a header with units, a column of times and a column for each joint; a joint has no key in an empty cell.

The delimiter is a comma, a semicolon or a tab; keys are joined by straight lines. Headings, comment lines above them,
decimal commas, and dates and times of ISO 8601 are read as in logs.

    time [s], HeadYaw [deg], LHand [%]
    0.0, 0, 40
    0.5, 30,
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from nao_kin._core.csv_numbers import CsvHead, TableColumns, csv_head, read_csv
from nao_kin._core.files import read_arrays
from nao_kin._core.headings import JOINT_UNITS, in_si_units, read_heading
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument, BadInputFile
from nao_kin.motion.files.source import FilePosition, Format, MotionSource
from nao_kin.motion.files.tracks import Track, check_times, is_hand, motion_of, units_per_second, warn_of_curves
from nao_kin.motion.interpolation import INTERPOLATIONS
from nao_kin.motion.motion import Motion


def _recognises_csv(source: MotionSource) -> bool:
    """Return whether the header names a time column."""
    head = csv_head(source.name, _encoded(source), "a header")
    return any(read_heading(field).is_time for field in head.fields)


def _encoded(source: MotionSource) -> bytes:
    return source.text.encode("utf-8", "replace")


def _read_csv(source: MotionSource) -> Motion:
    """Read the motion in a CSV file."""
    tracks: list[Track] = []
    first = FilePosition()

    def understood(head: CsvHead) -> TableColumns:
        """Return the columns to read, joints once each; omitted joints become tracks without keys."""
        nonlocal first
        first = FilePosition(head.line, 1)

        def units_of(_: str, joint: str, place: int) -> Sequence[str]:
            if source.check_joint(joint, first.field(place)) in source.joints:
                return JOINT_UNITS["1"] if is_hand(joint) else (*JOINT_UNITS["rad"], *JOINT_UNITS["m"])
            tracks.append(Track(joint, np.zeros(0), np.zeros(0), place=first.field(place)))
            return ()

        def error(reason: str, place: int) -> BadInputFile:
            return source.error(reason, first.field(place))

        headings = [head.read_as.get(field, field) for field in head.fields]
        table, times = TableColumns.of(headings, source.joints, units_of, error, degrees=source.degrees)
        if len(times) != 1:
            reason = f"{len(times)} columns of times, expected one, headed time [s] or time [ms]"
            raise source.error(reason, FilePosition(head.line))
        return replace(table, blanks=True)

    table, rows, lines = read_csv(source.name, _encoded(source), understood, "a header with a time column")
    if not len(rows):
        raise source.error("a header and no keys", FilePosition(first.line))
    times, at = rows[:, -1], table.places[-1] + 1
    if np.isnan(times).any():
        raise source.error("a row without a time", FilePosition(lines[int(np.argmax(np.isnan(times)))], at))
    times = times / units_per_second(source, times, table.time_unit)
    check_times(source, times, lambda row: FilePosition(lines[row], at), negative=True)
    for name, place, values in zip(table.names, table.places, in_si_units(rows[:, :-1], table.units).T, strict=False):
        given = np.flatnonzero(~np.isnan(values))
        # All joints that have a key in every row share one array.
        own = times if len(given) == len(times) else times[given]
        tracks.append(Track(name, own, values[given], place=first.field(place)))
    return motion_of(source, tracks, negative=True)


def write_csv_in_degrees(motion: Motion, original: Motion) -> bytes:
    """Do the same as `_write_csv`, in degrees."""
    return _write_csv(motion, original, angle="deg")


def _write_csv(motion: Motion, _: Motion, angle: str = "rad") -> bytes:
    """Write CSV in seconds and a unit of angles, hands as ratios; a cell is empty where a joint has no key."""
    warn_of_curves(motion, "CSV")
    times = motion.key_times
    table = np.full((len(times), len(motion.keys)), math.nan)
    for column, (own, keys) in enumerate(zip(motion.times, motion.keys, strict=True)):
        turns = angle == "deg" and not is_hand(motion.joint_names[column])
        table[np.searchsorted(times, own), column] = np.degrees(keys) if turns else keys
    for joint in motion.joint_names:
        if not re.fullmatch(r"[^\[\](),;\t\r\n\"]*", joint) or joint != joint.strip() or read_heading(joint).is_time:
            raise BadArgument(f"a CSV header cannot hold the joint {quoted(joint)}")
    header = ["time [s]", *(f"{joint} [{'1' if is_hand(joint) else angle}]" for joint in motion.joint_names)]
    lines = [",".join(header)]
    for time, row in zip(times.tolist(), table.tolist(), strict=True):
        lines.append(",".join([repr(time), *("" if value != value else repr(value) for value in row)]))
    return ("\n".join(lines) + "\n").encode()


CSV = Format(
    "csv", (".csv", ".tsv", ".txt"), "a table with units in its header", _recognises_csv, _read_csv, _write_csv
)


# --- NumPy's npz: every motion without loss, fast to load.
#
# Arrays: joint_names (joints,) text; counts (joints,) the number of keys of each; times and keys (sum of counts,) joint
# after joint [s; rad, m or ratio]; interpolation () text; for "bezier", handles (sum of counts, 2, 2).

_REQUIRED = ("joint_names", "counts", "times", "keys", "interpolation")


def _recognises_npz(source: MotionSource) -> bool:
    """Return whether the file begins like a zip file."""
    return source.data[:4] == b"PK\x03\x04"


def _read_npz(source: MotionSource) -> Motion:
    """Read the motion in an npz file, without unpickling anything."""
    arrays = read_arrays(source.name, source.data, (*_REQUIRED, "handles"), wrong="not an npz file of a motion")
    for name in _REQUIRED:
        if name not in arrays:
            raise source.error(f"no array {name!r}; expected {', '.join(_REQUIRED)}")
    names, counts = arrays["joint_names"], arrays["counts"]
    if names.ndim != 1 or names.dtype.kind != "U":
        raise source.error(f"joint_names must be texts (joints,), got {names.dtype} {names.shape}")
    if counts.shape != names.shape or counts.dtype.kind not in "iu" or (counts < 1).any() or (counts > 1 << 40).any():
        raise source.error(f"counts must be whole numbers ≥ 1 {names.shape}, got {counts.dtype} {counts.shape}")
    total = int(sum(counts.tolist()))
    interpolation = str(arrays["interpolation"]) if arrays["interpolation"].ndim == 0 else ""
    if interpolation not in INTERPOLATIONS:
        raise source.error(f"interpolation must be one of {', '.join(INTERPOLATIONS)}")
    shapes: dict[str, tuple[int, ...]] = {"times": (total,), "keys": (total,)}
    if interpolation == "bezier":
        shapes["handles"] = (total, 2, 2)
    for name, shape in shapes.items():
        if name not in arrays:
            raise source.error(f"no array {name!r}, which bezier interpolation needs")
        array = arrays[name]
        if array.shape != shape or array.dtype.kind not in "fiu":
            raise source.error(f"{name} must be numbers {shape}, got {array.dtype} {array.shape}")
        arrays[name] = array.astype(np.float64)
        if not np.isfinite(arrays[name]).all():
            index = np.argwhere(~np.isfinite(arrays[name]))[0].tolist()
            raise source.error(f"{name}{index} is {array[tuple(index)]}, expected a finite number")
    ends = np.cumsum(counts.astype(np.int64))[:-1]
    parts = {name: np.split(arrays[name], ends) for name in shapes}
    tracks = []
    for row, joint in enumerate(names.tolist()):
        own = parts["handles"][row].copy() if "handles" in parts else None
        first = int(ends[row - 1]) if row else 0

        def place(key: int, first: int = first) -> FilePosition:
            return FilePosition(where=f"times[{first + key}]")

        where = FilePosition(where=f"joint_names[{row}]")
        tracks.append(Track(joint, parts["times"][row], parts["keys"][row], own, where, place))
    return motion_of(source, tracks, interpolation, negative=True)


def _write_npz(motion: Motion, _: Motion) -> bytes:
    """Write an npz file from which the same motion is read."""
    arrays: dict[str, Any] = {
        "joint_names": np.array(motion.joint_names),
        "counts": np.array([len(keys) for keys in motion.keys]),
        "times": np.concatenate(motion.times),
        "keys": np.concatenate(motion.keys),
        "interpolation": np.array(motion.interpolation),
    }
    if motion.handles is not None:
        arrays["handles"] = np.concatenate(motion.handles)
    file = io.BytesIO()
    np.savez_compressed(file, **arrays)  # none of them is pickled: they hold numbers and text
    return file.getvalue()


NPZ = Format("npz", (".npz",), "NumPy arrays, without loss", _recognises_npz, _read_npz, _write_npz)
