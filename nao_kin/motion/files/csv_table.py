"""Motions as tables: CSV with a header of units, and NumPy's npz."""

from __future__ import annotations

import csv
import io
import math
import re
import tokenize
import zipfile
import zlib
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats, decimal
from nao_kin._core.csv_numbers import CsvHead, csv_head, iso_times, plain_floats
from nao_kin._core.headings import (
    JOINT_UNITS,
    TIME_UNITS,
    IsoTimes,
    in_si_units,
    is_index,
    read_heading,
    seconds,
    time_unit_of,
)
from nao_kin._core.text import MOST_SHOWN, abbreviated, quoted
from nao_kin.errors import BadArgument
from nao_kin.motion.files.source import Format, Place, Source
from nao_kin.motion.files.tracks import Track, check_times, is_hand, motion_of, sampled, warn_of_curves
from nao_kin.motion.interpolation import INTERPOLATIONS
from nao_kin.motion.motion import Motion


class _Column(NamedTuple):
    """A column that is read: the joint or the times, their unit ("" where that of times is not said), and where."""

    name: str
    unit: str
    place: int
    is_time: bool
    heading: str


def _recognises_csv(source: Source) -> bool:
    """Whether the header names a time column."""
    return any(read_heading(field).is_time for field in _head(source).fields)


def _head(source: Source) -> CsvHead:
    return csv_head(source.text.encode("utf-8", "replace"))


def _read_csv(source: Source) -> Motion:
    """The motion in a CSV file.

    Raises:
        BadInputFile: with line and column.
    """
    head = _head(source)
    if head.problem:
        raise source.error(f"malformed CSV: {head.problem}", Place(head.line))
    if not head.fields:
        raise source.error("empty; expected a header with a time column")
    columns, other = _columns(source, head)
    rows, lines = [], []
    body = source.text.encode("utf-8", "replace")[head.size :]
    rest = body.decode()
    time = next(index for index, column in enumerate(columns) if column.is_time)
    times = iso_times(body, head.delimiter, columns[time].place)
    if times is not None:
        columns[time] = columns[time]._replace(unit="s")
    reader = csv.reader(io.StringIO(rest, newline=""), delimiter=head.delimiter, strict=True)
    # Then `float` reads only decimal digits.
    plain = rest.isascii() and "_" not in rest and times is None
    try:
        for fields in reader:
            if not any(fields) or not any(field.strip() for field in fields):
                continue
            line = head.lines + reader.line_num
            if len(fields) != len(head.fields):
                raise source.error(f"{len(fields)} values, the header names {len(head.fields)} columns", Place(line))
            fields = [fields[column.place] for column in columns]
            if head.mark != ".":
                fields = [field.replace(head.mark, ".") for field in fields]
            row = plain_floats(fields) if plain else None
            rows.append(row or _cells(source, fields, columns, line, times))
            lines.append(line)
    except csv.Error as error:
        raise source.error(f"malformed CSV: {error}", Place(head.lines + reader.line_num)) from None
    if not rows:
        raise source.error("a header and no keys", Place(head.line))
    tracks = [
        Track(column.name, np.zeros(0), np.zeros(0), place=Place(head.line, column.place + 1)) for column in other
    ]
    tracks += _tracks(source, columns, np.array(rows), lines, head.line)
    return motion_of(source, tracks, negative=True)


def _tracks(source: Source, columns: list[_Column], table: Floats, lines: list[int], header_at: int) -> list[Track]:
    time = next(index for index, column in enumerate(columns) if column.is_time)
    times, at = table[:, time], columns[time].place + 1
    if np.isnan(times).any():
        raise source.error("a row without a time", Place(lines[int(np.argmax(np.isnan(times)))], at))
    times = seconds(times, columns[time].unit or time_unit_of(times))
    check_times(source, times, lambda row: Place(lines[row], at), negative=True)
    tracks = []
    for column, values in zip(columns, in_si_units(table, [column.unit for column in columns]).T, strict=True):
        if not column.is_time:
            rows = np.flatnonzero(~np.isnan(values))
            # All joints that have a key in every row share one array.
            own = times if len(rows) == len(times) else times[rows]
            tracks.append(Track(column.name, own, values[rows], place=Place(header_at, column.place + 1)))
    return tracks


def _cells(source: Source, fields: list[str], columns: list[_Column], line: int, times: IsoTimes | None) -> list[float]:
    """The numbers of a row, NaN where a cell is empty."""
    values = []
    for column, field in zip(columns, fields, strict=True):
        if times is not None and column.is_time and field.strip():
            try:
                values.append(times.seconds(field))
            except ValueError as error:
                at = Place(line, column.place + 1)
                raise source.error(f"{column.heading[:MOST_SHOWN]} {error}", at) from None
            continue
        try:
            value = decimal(field) if field.strip() else math.nan
        except ValueError:
            value = math.inf
        if math.isinf(value):
            shown = quoted(field.strip(), MOST_SHOWN)
            raise source.error(
                f"{column.heading[:MOST_SHOWN]} is {shown}, expected a finite number", Place(line, column.place + 1)
            )
        values.append(value)
    return values


def _columns(source: Source, head: CsvHead) -> tuple[list[_Column], list[_Column]]:
    """The columns that are read, times and joints each once, and those that are left out."""
    found, other = list[_Column](), list[_Column]()
    for place, field in enumerate(head.fields):
        if place == 0 and is_index(field):
            continue
        heading, at = read_heading(field), Place(head.line, place + 1)
        name, unit = heading.name, heading.unit
        if heading.is_time:
            units: Iterable[str] = TIME_UNITS
        else:
            source.check_joint(name, at)
            if name not in source.joints:
                other.append(_Column(name, "", place, False, ""))
                continue
            if name in (column.name for column in found):
                raise source.error(f"joint {name} is given twice", at)
            units = JOINT_UNITS["1"] if is_hand(name) else (*JOINT_UNITS["rad"], *JOINT_UNITS["m"])
            usual = "1" if is_hand(name) else "deg" if source.degrees else "rad"
            unit = usual if unit is None else unit
        if unit is not None and unit not in units:
            raise source.error(f"unit {quoted(unit, MOST_SHOWN)} of {name}, expected one of {', '.join(units)}", at)
        found.append(_Column(name, unit or "", place, heading.is_time, field.strip()))
    times = sum(column.is_time for column in found)
    if times != 1:
        raise source.error(f"{times} columns of times, expected one, headed time [s] or time [ms]", Place(head.line))
    return found, other


def _write_csv(motion: Motion, rate: float | None) -> bytes:
    """A CSV file: seconds and radians, hands as ratios; a cell is empty where a joint has no key.

    Raises:
        BadArgument: a name that a header cannot hold.
    """
    motion = sampled(motion, rate)
    warn_of_curves(motion, "CSV")
    times = motion.key_times
    table = np.full((len(times), len(motion.keys)), math.nan)
    for column, (own, keys) in enumerate(zip(motion.times, motion.keys, strict=True)):
        table[np.searchsorted(times, own), column] = keys
    for joint in motion.joint_names:
        if not re.fullmatch(r"[^\[\](),;\t\r\n\"]*", joint) or joint != joint.strip() or read_heading(joint).is_time:
            raise BadArgument(f"a CSV header cannot hold the joint {quoted(joint)}")
    header = ["time [s]", *(f"{joint} [{'1' if is_hand(joint) else 'rad'}]" for joint in motion.joint_names)]
    lines = [",".join(header)]
    for time, row in zip(times.tolist(), table.tolist(), strict=True):
        lines.append(",".join([repr(time), *("" if value != value else repr(value) for value in row)]))
    return ("\n".join(lines) + "\n").encode()


CSV = Format(
    "csv", (".csv", ".tsv", ".txt"), "a table with units in its header", _recognises_csv, _read_csv, _write_csv
)


# --- NumPy's npz: every motion as it is, without loss, fast to load.
#
# Arrays: joint_names (joints,) text; counts (joints,) the number of keys of each; times and keys (sum of counts,) one
# joint after the other [s; rad, m or ratio]; interpolation () text; for "bezier", handles (sum of counts, 2, 2).

# A motion of 10⁷ keys has a fifth of it.
_MOST_BYTES = 1 << 31
# What zip files and arrays that are broken make zipfile and NumPy raise.
_BROKEN = (
    *(ValueError, EOFError, OSError, KeyError, MemoryError, OverflowError, RuntimeError, SyntaxError, TypeError),
    *(zipfile.BadZipFile, zlib.error, tokenize.TokenError),
)
_REQUIRED = ("joint_names", "counts", "times", "keys", "interpolation")


def _recognises_npz(source: Source) -> bool:
    """Whether it begins as a zip file does."""
    return source.data[:4] == b"PK\x03\x04"


def _read_npz(source: Source) -> Motion:
    """The motion in an npz file; nothing in it is ever unpickled.

    Raises:
        BadInputFile: names the array.
    """
    arrays = _arrays(source)
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

        def place(key: int, first: int = first) -> Place:
            return Place(where=f"times[{first + key}]")

        where = Place(where=f"joint_names[{row}]")
        tracks.append(Track(joint, parts["times"][row], parts["keys"][row], own, where, place))
    return motion_of(source, tracks, interpolation, negative=True)


def _arrays(source: Source) -> dict[str, NDArray[Any]]:
    """All arrays of the file."""
    try:
        with zipfile.ZipFile(io.BytesIO(source.data)) as archive:
            size = sum(entry.file_size for entry in archive.infolist())
        if size > _MOST_BYTES:
            raise source.error(f"unpacked it is {size} bytes, more than {_MOST_BYTES}")
        with np.load(io.BytesIO(source.data), allow_pickle=False) as archive:
            return {name: archive[name] for name in archive.files if name in (*_REQUIRED, "handles")}
    except _BROKEN as error:
        raise source.error(f"no npz file of a motion: {abbreviated(error)}") from None


def _write_npz(motion: Motion, rate: float | None) -> bytes:
    """An npz file that gives back the same motion; with a rate, its samples."""
    motion = sampled(motion, rate)
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
    np.savez_compressed(file, allow_pickle=False, **arrays)
    return file.getvalue()


NPZ = Format("npz", (".npz",), "NumPy arrays, without loss", _recognises_npz, _read_npz, _write_npz)
