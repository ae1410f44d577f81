"""JSON: every motion without loss.

    {"format": "nao_kin motion",
     "units": {"time": "s", "angle": "rad"},
     "interpolation": "linear",
     "joint_names": ["HeadYaw", "LHand"],
     "times": [[0.0, 0.5], [0.0]],
     "keys": [[0.0, 0.3], [0.4]]}

All joints may share one list of times; then "keys" has a row for each time. For "bezier", "handles" has for each joint
and key [[seconds, value] before, [seconds, value] after], offsets from the key.
"""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._core.files import described
from nao_kin._core.headings import TIME_UNITS
from nao_kin._core.text import MAX_SHOWN, quoted
from nao_kin.motion.files.source import FilePosition, Format, MotionSource, in_json
from nao_kin.motion.files.tracks import Track, is_hand, motion_of, units_per_second
from nao_kin.motion.interpolation import INTERPOLATIONS, Interpolation
from nao_kin.motion.motion import Motion

TITLE = "nao_kin motion"
_FIELDS = ("format", "units", "interpolation", "joint_names", "times", "keys", "handles")
_UNITS = {"time": tuple(TIME_UNITS), "angle": ("rad", "deg")}
_ADVICE = '"units": {"time": "s"} in the file says otherwise'


def recognises(source: MotionSource) -> bool:
    """Return whether the file is a JSON object with joint_names or the title of this format."""
    value = source.json
    return isinstance(value, dict) and ("joint_names" in value or value.get("format") == TITLE)


def read(source: MotionSource) -> Motion:
    """Read the motion in a JSON file."""
    document = source.json
    if not isinstance(document, dict):
        raise source.error(f"expected an object with joint_names, times and keys, got {described(document)}")
    source.fields(document, _FIELDS, "field")
    if document.get("format", TITLE) != TITLE:
        raise source.error(f"expected {TITLE!r}, got {described(document['format'])}", in_json("format"))
    for name in ("joint_names", "times", "keys"):
        if name not in document:
            raise source.error(f"no {name!r}; expected joint_names, times and keys")
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
    units = source.json.get("units", {})
    if not isinstance(units, dict):
        raise source.error(f"expected an object, got {described(units)}", in_json("units"))
    for name in units:
        if name not in _UNITS:
            raise source.error(f"unknown quantity; expected {' or '.join(_UNITS)}", in_json("units", name))
    if quantity not in units:
        return None
    given = units[quantity]
    if not isinstance(given, str) or given not in _UNITS[quantity]:
        expected = ", ".join(_UNITS[quantity])
        raise source.error(f"unit {quoted(given, MAX_SHOWN)}, expected {expected}", in_json("units", quantity))
    return given


def _is_nested(times: list[Any]) -> bool:
    return bool(times) and isinstance(times[0], list)


def write(motion: Motion, _: Motion) -> bytes:
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


JSON = Format("json", (".json",), "names, times, keys and handles, without loss", recognises, read, write)
