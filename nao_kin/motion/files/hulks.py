"""HULKs' motions: JSON with key frames, and the older .motion2.

Positions to begin with, then key frames that take a duration each:

    {"initial_positions": {"head": {"yaw": 0.0, "pitch": 0.0}, "left_arm": {…}, …},
     "interpolation_mode": "linear",
     "motion": [{"keyframes": [{"duration": 0.5, "positions": {…}}], "exit_condition": {…}}]}

Source: HULKs/hulk, crates/motionfile: seconds and radians, hands as ratios; "interpolation_mode" is "linear" where it
is missing. An older generation has "frames" in the place of "motion", a list of key frames and conditions. Motions of
whole motor commands have {"positions": {…}, "stiffnesses": {…}} in the place of positions. Stiffnesses are left out.
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
from nao_kin.errors import BadArgument, nearest_names
from nao_kin.motion.files.key_frames import COSINE_ERROR, eased
from nao_kin.motion.files.source import Format, MotionFileWarning, Place, Source, in_json
from nao_kin.motion.files.tracks import Track, check_times, columns, milliseconds, motion_of, straight_rows
from nao_kin.motion.motion import Motion
from nao_kin.robot.nao import BODY_ORDER

_ARM = ("shoulder_pitch", "shoulder_roll", "elbow_yaw", "elbow_roll", "wrist_yaw", "hand")
_LEG = ("hip_yaw_pitch", "hip_roll", "hip_pitch", "knee_pitch", "ankle_pitch", "ankle_roll")
PARTS = {"head": ("yaw", "pitch"), "left_arm": _ARM, "left_leg": _LEG, "right_leg": _LEG, "right_arm": _ARM}
# In the order of NAOqi's Body, as parts and their joints are listed above.
_PLACES = [(part, joint) for part, joints in PARTS.items() for joint in joints]
_JOINTS = dict(zip(_PLACES, BODY_ORDER, strict=True))
_MODES = ("linear", "cosine")
_POSITIONS, _STIFFNESSES = "positions", "stiffnesses"
_CONDITIONS = ("entry_condition", "enable", "exit_condition", "interrupt_conditions")
Path = list[str | int]


def _recognises_hulks(source: Source) -> bool:
    """Whether it is a JSON object with initial_positions."""
    value = source.json
    return isinstance(value, dict) and "initial_positions" in value


def _read_hulks(source: Source) -> Motion:
    """The motion in a HULKs file, whose first key is at 0 s.

    Raises:
        BadInputFile: with the path to the value.
    """
    document = source.json
    if not isinstance(document, dict):
        raise source.error(f"expected an object with initial_positions, got {described(document)}")
    mode = document.get("interpolation_mode", "linear")
    if mode not in _MODES:
        reason = f"{described(mode)}, expected {' or '.join(_MODES)}"
        raise source.error(reason, in_json("interpolation_mode"))
    start, first = _positions(source, ["initial_positions"])
    rows: list[list[Any]] = [list(first.values())]
    frames, paths = list[Path](), [start]
    durations: list[Any] = []
    for path, frame in _frames(source):
        if "duration" not in frame:
            raise source.error("a key frame without a duration", in_json(*path))
        durations.append(frame["duration"])
        frames.append(path)
        where, found = _positions(source, [*path, "positions"])
        if found.keys() != first.keys():
            odd = ", ".join(sorted(found.keys() ^ first.keys())[:3])
            raise source.error(f"names other joints than initial_positions: {odd}", in_json(*where))
        rows.append([found[joint] for joint in first])
        paths.append(where)
    steps = source.floats(durations, "duration", lambda at: in_json(*frames[at], "duration"))
    times = np.concatenate([[0.0], np.cumsum(steps)])
    check_times(source, times, lambda key: in_json(*frames[key - 1], "duration"))
    flat = [value for row in rows for value in row]
    names = list(first)

    def place(at: int) -> Place:
        part, joint = _PLACES[BODY_ORDER.index(names[at % len(names)])]
        return in_json(*paths[at // len(names)], part, joint)

    table = source.floats(flat, "angle", place).reshape(len(rows), len(names))
    tracks = [Track(joint, times, table[:, column].copy()) for column, joint in enumerate(names)]
    if mode == "linear":
        return motion_of(source, tracks)
    return _eased(source, tracks)


def _eased(source: Source, tracks: list[Track]) -> Motion:
    """Cosine steps as Bezier curves that rest at every key."""
    warn_caller(
        f"{abbreviated(source.name)}: cosine steps are read as cubic ones, from which they differ by up to "
        f"{100 * COSINE_ERROR:g} % of a step",
        MotionFileWarning,
    )
    curves = [
        Track(track.joint, track.times, track.keys, eased(track.times, track.keys, np.full(len(track.keys), "cosine")))
        for track in tracks
    ]
    return motion_of(source, curves, "bezier")


def _frames(source: Source) -> Iterator[tuple[Path, dict[str, Any]]]:
    """The key frames of all generations, each with its path."""
    document = source.json
    if ("motion" in document) == ("frames" in document):
        raise source.error("expected either motion or frames")
    name = "motion" if "motion" in document else "frames"
    waits = set[str]()
    for index, entry in enumerate(source.list_at(name)):
        path: Path = [name, index]
        if not isinstance(entry, dict):
            raise source.error(f"expected an object, got {described(entry)}", in_json(*path))
        if name == "motion":
            waits |= {condition for condition in _CONDITIONS if entry.get(condition)}
            for row, frame in enumerate(source.list_at(*path, "keyframes")):
                if not isinstance(frame, dict):
                    raise source.error(f"expected an object, got {described(frame)}", in_json(*path, "keyframes", row))
                yield [*path, "keyframes", row], frame
        elif "duration" in entry or "positions" in entry:
            yield path, entry
        else:
            waits |= set(map(abbreviated, list(entry)[:1]))
    if waits:
        warn_caller(
            f"{abbreviated(source.name)}: what waits for the robot's sensors is left out: {', '.join(sorted(waits))}",
            MotionFileWarning,
        )


def _positions(source: Source, path: Path) -> tuple[Path, dict[str, Any]]:
    """The path to a set of positions, and what they give for each joint, by NAOqi's names."""
    value = source.at(*path)
    if isinstance(value, dict) and _POSITIONS in value:
        path, value = [*path, _POSITIONS], value[_POSITIONS]
    found = dict[str, Any]()
    parts = _objects(source, value, path, (*PARTS, _STIFFNESSES))
    for part, joints in parts.items():
        if part != _STIFFNESSES:
            for joint, angle in _objects(source, joints, [*path, part], PARTS[part]).items():
                found[_JOINTS[part, joint]] = angle
    if not found:
        raise source.error("no joint", in_json(*path))
    return path, found


def _objects(source: Source, value: Any, path: Path, names: tuple[str, ...]) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise source.error(f"expected an object, got {described(value)}", in_json(*path))
    for name in value:
        if name not in names:
            near = ", ".join(nearest_names(name, names)) or ", ".join(names)
            raise source.error(f"unknown joint (nearest: {near})", in_json(*path, name))
    return value


def _write_hulks(motion: Motion, rate: float | None) -> bytes:
    """A HULKs file of the newest generation: a key frame wherever some joint has a key, or at a rate.

    Raises:
        BadArgument: joints that are missing or that the format does not know, times before 0.
    """
    times, values = straight_rows(motion, rate, "HULKs motion")
    table = columns(motion, values, BODY_ORDER, "HULKs motion", one_hip=False)
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
    """Steps that add up to the times again, as nearly as sums of floating-point numbers can."""
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


HULKS = Format("hulks", (".json",), "HULKs' key frames", _recognises_hulks, _read_hulks, _write_hulks)


# --- HULKs' older .motion2: JSON with lists of positions, whose times are shares of the whole.
#
#     {"header": {"version": "2.0", "title": "nod", "time": 1000, "joints": [0, 1]},
#      "position": [{"time": 1, "parameters": [0.0, 0.2]}, {"time": 3, "parameters": [0.0, 0.0]}],
#      "stiffness": [{"time": 1, "parameters": [1.0, 1.0]}]}
#
# Source: HULKs' code releases, MotionFile.cpp and MotionFilePlayer.cpp: joints are numbers in the order of NAOqi's
# Body, angles radians, header.time whole milliseconds; the times of the positions are scaled so that their sum is
# header.time. The first position is reached from wherever the robot is, on a straight line, as are the others.

_VERSION = "2.0"


def _recognises_motion2(source: Source) -> bool:
    """Whether it is a JSON object with header and position."""
    value = source.json
    return isinstance(value, dict) and "header" in value and ("position" in value or "commands" in value)


def _read_motion2(source: Source) -> Motion:
    """The motion in a .motion2 file; stiffnesses are left out.

    Raises:
        BadInputFile: with the path to the value.
    """
    document = source.json
    if not isinstance(document, dict) or not isinstance(document.get("header"), dict):
        raise source.error("expected an object with header and position")
    header = document["header"]
    if header.get("version") != _VERSION:
        raise source.error(f"version {described(header.get('version'))}, expected {_VERSION!r}", in_json("header"))
    joints = header.get("joints")
    if not isinstance(joints, list) or not joints:
        raise source.error("expected a list of numbers of joints under joints", in_json("header"))
    for index, joint in enumerate(joints):
        place = in_json("header", "joints", index)
        if type(joint) is not int or not 0 <= joint < len(BODY_ORDER):
            raise source.error(f"{described(joint)}, expected the number of a joint, 0 to {len(BODY_ORDER) - 1}", place)
        if joint in joints[:index]:
            raise source.error(f"joint {joint} ({BODY_ORDER[joint]}) is given twice", place)
    total = source.floats([header.get("time")], "time", lambda _: in_json("header"))[0]
    positions = document.get("position")
    if not isinstance(positions, list) or not positions:
        raise source.error("no list of positions under position")
    steps, rows = [], []
    for index, entry in enumerate(positions):
        if not isinstance(entry, dict) or not isinstance(entry.get("parameters"), list) or "time" not in entry:
            raise source.error("expected an object with time and parameters", in_json("position", index))
        if len(entry["parameters"]) != len(joints):
            reason = f"{len(entry['parameters'])} values for {len(joints)} joints"
            raise source.error(reason, in_json("position", index, "parameters"))
        steps.append(entry["time"])
        rows += entry["parameters"]
    shares = source.floats(steps, "time", lambda at: in_json("position", at, "time"))
    return _motion(source, joints, float(total), shares, rows)


def _motion(source: Source, joints: list[int], total: float, shares: Any, rows: list[Any]) -> Motion:
    if total < 0.0 or (shares < 0.0).any():
        entry: list[str | int] = ["position", int(np.argmax(shares < 0.0)), "time"]
        bad = ["header", "time"] if total < 0.0 else entry
        raise source.error("a negative time", in_json(*bad))
    sums = np.cumsum(shares)
    times = sums * (total / sums[-1]) / 1e3 if sums[-1] > 0.0 else np.zeros(len(shares))
    check_times(source, times, lambda key: in_json("position", key, "time"))

    def place(at: int) -> Place:
        return in_json("position", at // len(joints), "parameters", at % len(joints))

    table = source.floats(rows, "angle", place).reshape(len(times), len(joints))
    tracks = [Track(BODY_ORDER[joint], times, table[:, column].copy()) for column, joint in enumerate(joints)]
    return motion_of(source, tracks)


def _write_motion2(motion: Motion, rate: float | None) -> bytes:
    """A .motion2 file at full stiffness: a position wherever some joint has a key, or at a rate.

    Raises:
        BadArgument: joints that the format does not know, times before 0 or nearer than 1 ms.
    """
    times, values = straight_rows(motion, rate, "motion2")
    named = [joint for joint in BODY_ORDER if joint in motion.joint_names]
    table = columns(motion, values, named or BODY_ORDER, "motion2", one_hip=False)
    stamps = milliseconds(times, "motion2")
    if stamps[-1] == 0:
        raise BadArgument("motion2 files take some time, the motion ends at 0 s")
    header = {"version": _VERSION, "title": "", "time": stamps[-1], "joints": [BODY_ORDER.index(j) for j in named]}
    rows = [
        f'  {{"time": {step}, "parameters": {json.dumps(row)}}}'
        for step, row in zip(np.diff([0, *stamps]).tolist(), table.tolist(), strict=True)
    ]
    full = f'  {{"time": {stamps[-1]}, "parameters": {json.dumps([1.0] * len(named))}}}'
    text = f'{{"header": {json.dumps(header)},\n "position": [\n' + ",\n".join(rows)
    return (text + f'\n ],\n "stiffness": [\n{full}\n ]}}\n').encode()


MOTION2 = Format("motion2", (".motion2",), "HULKs' older positions", _recognises_motion2, _read_motion2, _write_motion2)
