"""This library's own motion files: JSON without loss, tables in CSV with units in their headers, and NumPy's npz."""

from __future__ import annotations

import io
import json
import math
import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._core.csv_numbers import CsvHead, TableColumns, csv_head, read_csv
from nao_kin._core.files import described, read_arrays
from nao_kin._core.headings import JOINT_UNITS, TIME_UNITS, in_si_units, read_heading
from nao_kin._core.text import MAX_SHOWN, quoted
from nao_kin.errors import BadArgument, BadInputFile
from nao_kin.motion.files.source import FilePosition, Format, MotionSource, has_field, in_json
from nao_kin.motion.files.tracks import Track, check_times, is_hand, motion_of, units_per_second, warn_of_curves
from nao_kin.motion.interpolation import INTERPOLATIONS, Interpolation
from nao_kin.motion.motion import Motion

# --- JSON: every motion without loss.
#
#     {"format": "nao_kin motion",
#      "units": {"time": "s", "angle": "rad"},
#      "interpolation": "linear",
#      "joint_names": ["HeadYaw", "LHand"],
#      "times": [[0.0, 0.5], [0.0]],
#      "keys": [[0.0, 0.3], [0.4]]}
#
# All joints may share one list of times; then "keys" has a row for each time. For "bezier", "handles" has for each
# joint and key [[seconds, value] before, [seconds, value] after], offsets from the key.

TITLE = "nao_kin motion"
_FIELDS = ("format", "units", "interpolation", "joint_names", "times", "keys", "handles")
_UNITS = {"time": tuple(TIME_UNITS), "angle": ("rad", "deg")}
_ADVICE = '"units": {"time": "s"} in the file says otherwise'


def _read_json(source: MotionSource) -> Motion:
    """Read the motion in a JSON file."""
    document = source.fields(source.json, _FIELDS, "field")
    if document.get("format", TITLE) != TITLE:
        raise source.error(f"expected {TITLE!r}, got {described(document['format'])}", in_json("format"))
    joints = source.list_at("joint_names")
    if not joints:
        raise source.error("no joints", in_json("joint_names"))
    for row, joint in enumerate(joints):
        source.check_joint(joint, in_json("joint_names", row))
    unit, angles = _unit(source, "time"), _unit(source, "angle")
    angle = math.pi / 180.0 if angles == "deg" or (source.degrees and angles is None) else 1.0
    interpolation = _interpolation(source)
    times, columns = _times_and_keys(source, joints)
    per_second = units_per_second(source, np.unique(np.concatenate(times)), unit, _ADVICE)
    handles: list[Floats | None] = [None] * len(joints)
    if document.get("handles") is not None:
        if interpolation != "bezier":
            raise source.error(f"handles belong to bezier interpolation, not {interpolation}", in_json("handles"))
        handles = _handles(source, columns)
    tracks = []
    for row, (joint, own, keys, offsets) in enumerate(zip(joints, times, columns, handles, strict=True)):
        scale = 1.0 if is_hand(joint) else angle
        time_of = in_json("times", row) if _is_nested(document["times"]) else in_json("times")
        tracks.append(
            Track(
                joint,
                own / per_second,
                keys * scale,
                None if offsets is None else offsets * [1.0 / per_second, scale],
                in_json("joint_names", row),
                time_of.entry,
                in_json("handles", row).entry,
            )
        )
    return motion_of(source, tracks, interpolation, negative=True)


def _times_and_keys(source: MotionSource, joints: list[str]) -> tuple[list[Floats], list[Floats]]:
    """Return times and keys of each joint; a shared list of times gives a shared array."""
    times, keys = source.list_at("times"), source.list_at("keys")
    if _is_nested(times):
        for name, rows in (("times", times), ("keys", keys)):
            if len(rows) != len(joints):
                raise source.error(f"{len(rows)} lists for {len(joints)} joints", in_json(name))
        own = [source.floats_at("time", "times", row) for row in range(len(joints))]
        columns = [source.floats_at("key", "keys", row) for row in range(len(joints))]
        return own, columns
    shared = source.floats_at("time", "times")
    if not len(shared):
        raise source.error("no times", in_json("times"))
    if len(keys) != len(shared):
        raise source.error(f"{len(keys)} rows for {len(shared)} times", in_json("keys"))
    table = np.empty((len(keys), len(joints)))
    for row in range(len(keys)):
        values = source.floats_at("key", "keys", row)
        if len(values) != len(joints):
            raise source.error(f"{len(values)} keys for {len(joints)} joints", in_json("keys", row))
        table[row] = values
    return [shared] * len(joints), list(table.T)


def _handles(source: MotionSource, columns: list[Floats]) -> list[Floats | None]:
    rows = source.list_at("handles")
    if len(rows) != len(columns):
        raise source.error(f"{len(rows)} lists for {len(columns)} joints", in_json("handles"))
    result = list[Floats | None]()
    for row, keys in enumerate(columns):
        own, place = source.list_at("handles", row), in_json("handles", row)
        if len(own) != len(keys):
            raise source.error(f"{len(own)} handles for {len(keys)} keys", place)
        for key, pair in enumerate(own):
            if not (isinstance(pair, list) and len(pair) == 2 and all(type(x) is list and len(x) == 2 for x in pair)):
                reason = f"expected [[seconds, value], [seconds, value]], got {described(pair)}"
                raise source.error(reason, place.entry(key))
        flat = [number for pair in own for side in pair for number in side]

        def offset(at: int, place: FilePosition = place) -> FilePosition:
            return place.entry(at // 4).entry(at // 2 % 2).entry(at % 2)

        result.append(source.floats(flat, "offset", offset).reshape(-1, 2, 2))
    return result


def _interpolation(source: MotionSource) -> Interpolation:
    given = source.json.get("interpolation", "linear")
    for known in INTERPOLATIONS:
        if given == known:
            return known
    reason = f"{described(given)}, expected one of {', '.join(INTERPOLATIONS)}"
    raise source.error(reason, in_json("interpolation"))


def _unit(source: MotionSource, quantity: str) -> str | None:
    """Return the unit that the file states for a quantity, or None."""
    units = source.fields(source.json.get("units", {}), tuple(_UNITS), "quantity", "units")
    if quantity not in units:
        return None
    given = units[quantity]
    if not isinstance(given, str) or given not in _UNITS[quantity]:
        expected = ", ".join(_UNITS[quantity])
        raise source.error(f"unit {quoted(given, MAX_SHOWN)}, expected {expected}", in_json("units", quantity))
    return given


def _is_nested(times: list[Any]) -> bool:
    return bool(times) and isinstance(times[0], list)


def _write_json(motion: Motion, _: Motion) -> bytes:
    """Write a JSON file from which the same motion is read."""
    fields: dict[str, Any] = {
        "times": [times.tolist() for times in motion.times],
        "keys": [keys.tolist() for keys in motion.keys],
    }
    if motion.handles is not None:
        fields["handles"] = [handles.tolist() for handles in motion.handles]
    head = {
        "format": TITLE,
        "units": {"time": "s", "angle": "rad"},
        "interpolation": motion.interpolation,
        "joint_names": list(motion.joint_names),
    }
    lines = [f'"{name}": {json.dumps(value, ensure_ascii=False)}' for name, value in head.items()]
    for name, rows in fields.items():
        lines.append(f'"{name}": [\n' + ",\n".join(f"  {json.dumps(row)}" for row in rows) + "]")
    return ("{" + ",\n ".join(lines) + "}\n").encode()


_recognises_json = has_field("joint_names", "format")
JSON = Format(
    "json", (".json",), "names, times, keys and handles, without loss", _recognises_json, _read_json, _write_json
)


# --- CSV: a header with units, a column of times and a column for each joint.
#
# A table has a header with units, a column of times and a column for each joint; a joint has no key in an empty cell.
#
# The delimiter is a comma, a semicolon or a tab; keys are joined by straight lines. Headings, comment lines above them,
# decimal commas, and dates and times of ISO 8601 are read as in logs.
#
#     time [s], HeadYaw [deg], LHand [%]
#     0.0, 0, 40
#     0.5, 30,


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


def write_csv(motion: Motion, _: Motion, angle: str = "rad") -> bytes:
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


CSV = Format("csv", (".csv", ".tsv", ".txt"), "a table with units in its header", _recognises_csv, _read_csv, write_csv)


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
