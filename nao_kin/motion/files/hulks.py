"""HULKs' motions: JSON with key frames, and the older .motion2.

Initial positions, then key frames with a duration each:

    {"initial_positions": {"head": {"yaw": 0.0, "pitch": 0.0}, "left_arm": {…}, …},
     "interpolation_mode": "linear",
     "motion": [{"keyframes": [{"duration": 0.5, "positions": {…}}], "exit_condition": {…}}]}

Source: HULKs/hulk, crates/motionfile: seconds and radians, hands as ratios; "interpolation_mode" is "linear" by
default. An older generation has "frames" instead of "motion", a list of key frames and conditions. Motions of whole
motor commands have {"positions": {…}, "stiffnesses": {…}} instead of positions. Stiffnesses are left out.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._core.files import described
from nao_kin._core.text import abbreviated
from nao_kin._core.warn import warn_caller
from nao_kin.errors import BadArgument
from nao_kin.motion.files.key_frames import COSINE_ERROR, eased, warn_of_sensors
from nao_kin.motion.files.source import (
    FilePosition,
    Format,
    JsonPath,
    MotionFileWarning,
    MotionSource,
    has_field,
    in_json,
)
from nao_kin.motion.files.tracks import Track, check_times, milliseconds, motion_of, nao_rows
from nao_kin.motion.motion import Motion
from nao_kin.robot.nao import BODY_ORDER

_ARM = ("shoulder_pitch", "shoulder_roll", "elbow_yaw", "elbow_roll", "wrist_yaw", "hand")
_LEG = ("hip_yaw_pitch", "hip_roll", "hip_pitch", "knee_pitch", "ankle_pitch", "ankle_roll")
PARTS = {"head": ("yaw", "pitch"), "left_arm": _ARM, "left_leg": _LEG, "right_leg": _LEG, "right_arm": _ARM}
# The parts above are in the order of NAOqi's Body.
_PLACES = [(part, joint) for part, joints in PARTS.items() for joint in joints]
_JOINTS = dict(zip(_PLACES, BODY_ORDER, strict=True))
_MODES = ("linear", "cosine")
_POSITIONS, _STIFFNESSES = "positions", "stiffnesses"
_CONDITIONS = ("entry_condition", "enable", "exit_condition", "interrupt_conditions")


def _read_hulks(source: MotionSource) -> Motion:
    """Read the motion in a HULKs file, whose first key is at 0 s."""
    document = source.json
    if not isinstance(document, dict):
        raise source.error(f"expected an object with initial_positions, got {described(document)}")
    mode = document.get("interpolation_mode", "linear")
    if mode not in _MODES:
        reason = f"{described(mode)}, expected {' or '.join(_MODES)}"
        raise source.error(reason, in_json("interpolation_mode"))
    start, first = _positions(source, ["initial_positions"])
    rows, paths = [[*first.values()]], [start]
    durations, frames = list[Any](), list[JsonPath]()
    for path, frame in _frames(source):
        if "duration" not in frame:
            raise source.error("a key frame without a duration", in_json(*path))
        durations.append(frame["duration"])
        frames.append(path)
        where, positions = _positions(source, [*path, "positions"])
        if positions.keys() != first.keys():
            odd = ", ".join(sorted(positions.keys() ^ first.keys())[:3])
            raise source.error(f"names other joints than initial_positions: {odd}", in_json(*where))
        rows.append([positions[joint] for joint in first])
        paths.append(where)
    steps = source.floats(durations, "duration", lambda at: in_json(*frames[at], "duration"))
    times = np.concatenate([[0.0], np.cumsum(steps)])
    check_times(source, times, lambda key: in_json(*frames[key - 1], "duration"))
    names = list(first)

    def place(at: int) -> FilePosition:
        return in_json(*paths[at // len(names)], *_PLACES[BODY_ORDER.index(names[at % len(names)])])

    flat = source.floats([value for row in rows for value in row], "angle", place)
    columns = flat.reshape(len(rows), len(names)).T
    if mode == "linear":
        return motion_of(source, [Track(joint, times, keys) for joint, keys in zip(names, columns, strict=True)])
    warn_caller(
        f"{abbreviated(source.name)}: cosine steps are read as cubic ones, from which they differ by up to "
        f"{100 * COSINE_ERROR:g} % of a step",
        MotionFileWarning,
    )
    eases = np.full(len(times), "cosine")
    tracks = [Track(joint, times, keys, eased(times, keys, eases)) for joint, keys in zip(names, columns, strict=True)]
    return motion_of(source, tracks, "bezier")


def _frames(source: MotionSource) -> Iterator[tuple[JsonPath, dict[str, Any]]]:
    """Yield the key frames of all generations, each with its path."""
    document = source.json
    if ("motion" in document) == ("frames" in document):
        raise source.error("expected either motion or frames")
    name = "motion" if "motion" in document else "frames"
    waits = set[str]()
    for path, entry in source.objects_at(name):
        if name == "motion":
            waits |= {condition for condition in _CONDITIONS if entry.get(condition)}
            yield from source.objects_at(*path, "keyframes")
        elif "duration" in entry or "positions" in entry:
            yield path, entry
        else:
            waits |= set(map(abbreviated, list(entry)[:1]))
    warn_of_sensors(source, waits)


def _positions(source: MotionSource, path: JsonPath) -> tuple[JsonPath, dict[str, Any]]:
    """Return the path to a set of positions, and the value of each joint in them, by NAOqi's names."""
    value = source.at(*path)
    if isinstance(value, dict) and _POSITIONS in value:
        path, value = [*path, _POSITIONS], value[_POSITIONS]
    angles = dict[str, Any]()
    for part, joints in source.fields(value, (*PARTS, _STIFFNESSES), "joint", *path).items():
        if part != _STIFFNESSES:
            for joint, angle in source.fields(joints, PARTS[part], "joint", *path, part).items():
                angles[_JOINTS[part, joint]] = angle
    if not angles:
        raise source.error("no joint", in_json(*path))
    return path, angles


def _write_hulks(motion: Motion, _: Motion) -> bytes:
    """Write a HULKs file of the newest generation with a key frame at each key time."""
    times, table = nao_rows(motion, BODY_ORDER, "HULKs motion")
    if times[0] < 0.0:
        raise BadArgument(f"HULKs motion files begin at 0 s, the motion at {times[0]:g} s")
    if times[0] > 0.0:
        times, table = np.concatenate([[0.0], times]), np.concatenate([table[:1], table])
    frames = [
        f'   {{"duration": {duration!r}, "positions": {_object(row)}}}'
        for duration, row in zip(_durations(times), table[1:], strict=True)
    ]
    text = (
        f'{{"initial_positions": {_object(table[0])},\n "interpolation_mode": "linear",\n'
        f' "motion": [{{"keyframes": [\n{",".join(chr(10) + frame for frame in frames).strip(chr(10))}\n  ]}}]}}\n'
    )
    return text.encode()


def _durations(times: Floats) -> list[float]:
    """Return steps that add up to the times as nearly as sums of floating-point numbers can."""
    steps, reached = [], 0.0
    for time in times[1:].tolist():
        steps.append(round(time - reached, 12))
        reached += steps[-1]
    return steps


def _object(row: Floats) -> str:
    positions: dict[str, dict[str, float]] = {part: {} for part in PARTS}
    for (part, joint), value in zip(_PLACES, row.tolist(), strict=True):
        positions[part][joint] = value
    return json.dumps(positions)


HULKS = Format("hulks", (".json",), "HULKs' key frames", has_field("initial_positions"), _read_hulks, _write_hulks)


# --- HULKs' older .motion2: JSON with lists of positions, whose times are fractions of the total.
#
#     {"header": {"version": "2.0", "title": "nod", "time": 1000, "joints": [0, 1]},
#      "position": [{"time": 1, "parameters": [0.0, 0.2]}, {"time": 3, "parameters": [0.0, 0.0]}],
#      "stiffness": [{"time": 1, "parameters": [1.0, 1.0]}]}
#
# Source: HULKs' code releases, MotionFile.cpp and MotionFilePlayer.cpp: joints are numbers in the order of NAOqi's
# Body, angles radians, header.time whole milliseconds; the times of the positions are scaled so that their sum is
# header.time. Straight lines lead from the robot's current pose to the first position and on to the others.

_VERSION = "2.0"


def _recognises_motion2(source: MotionSource) -> bool:
    """Return whether the file is a JSON object with header and position."""
    value = source.json
    return isinstance(value, dict) and "header" in value and ("position" in value or "commands" in value)


def _read_motion2(source: MotionSource) -> Motion:
    """Read the motion in a .motion2 file; stiffnesses are left out."""
    document = source.json
    if not isinstance(document, dict) or not isinstance(document.get("header"), dict):
        raise source.error("expected an object with header and position")
    header = document["header"]
    if header.get("version") != _VERSION:
        raise source.error(f"version {described(header.get('version'))}, expected {_VERSION!r}", in_json("header"))
    joints = source.list_at("header", "joints")
    if not joints:
        raise source.error("no joints", in_json("header", "joints"))
    for index, joint in enumerate(joints):
        place = in_json("header", "joints", index)
        if type(joint) is not int or not 0 <= joint < len(BODY_ORDER):
            raise source.error(f"{described(joint)}, expected the number of a joint, 0 to {len(BODY_ORDER) - 1}", place)
        if joint in joints[:index]:
            raise source.error(f"joint {joint} ({BODY_ORDER[joint]}) is given twice", place)
    total = float(source.floats([source.at("header", "time")], "time", lambda _: in_json("header", "time"))[0])
    rows, steps = list[Floats](), list[Any]()
    for path, _ in source.objects_at("position"):
        values = source.floats_at("angle", *path, "parameters")
        if len(values) != len(joints):
            raise source.error(f"{len(values)} values for {len(joints)} joints", in_json(*path, "parameters"))
        rows.append(values)
        steps.append(source.at(*path, "time"))
    if not steps:
        raise source.error("no positions", in_json("position"))

    def time_of(index: int) -> FilePosition:
        return in_json("position", index, "time")

    shares = source.floats(steps, "time", time_of)
    if total < 0.0 or (shares < 0.0).any():
        place = in_json("header", "time") if total < 0.0 else time_of(int(np.argmax(shares < 0.0)))
        raise source.error("a negative time", place)
    sums = np.cumsum(shares)
    times = sums * (total / sums[-1]) / 1e3 if sums[-1] > 0.0 else np.zeros(len(shares))
    check_times(source, times, time_of)
    columns = zip(joints, np.array(rows).T, strict=True)
    return motion_of(source, [Track(BODY_ORDER[joint], times, keys) for joint, keys in columns])


def _write_motion2(motion: Motion, _: Motion) -> bytes:
    """Write a .motion2 file at full stiffness with a position at each key time."""
    named = [joint for joint in BODY_ORDER if joint in motion.joint_names]
    times, table = nao_rows(motion, named or BODY_ORDER, "motion2")
    stamps = milliseconds(times, "motion2")
    if stamps[-1] == 0:
        raise BadArgument("motion2 files must last longer than 0 s, the motion ends at 0 s")
    header = {"version": _VERSION, "title": "", "time": stamps[-1], "joints": [BODY_ORDER.index(j) for j in named]}
    rows = [
        f'  {{"time": {step}, "parameters": {json.dumps(row)}}}'
        for step, row in zip(np.diff([0, *stamps]).tolist(), table.tolist(), strict=True)
    ]
    full = f'  {{"time": {stamps[-1]}, "parameters": {json.dumps([1.0] * len(named))}}}'
    text = f'{{"header": {json.dumps(header)},\n "position": [\n' + ",\n".join(rows)
    return (text + f'\n ],\n "stiffness": [\n{full}\n ]}}\n').encode()


MOTION2 = Format("motion2", (".motion2",), "HULKs' older positions", _recognises_motion2, _read_motion2, _write_motion2)
