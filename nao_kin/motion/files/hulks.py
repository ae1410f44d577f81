"""HULKs' JSON motions: positions to begin with, then key frames that take a duration each.

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

from nao_kin._common.arrays import Floats
from nao_kin._common.warn import warn_caller
from nao_kin._text import abbreviated
from nao_kin.errors import BadArgument, nearest_names
from nao_kin.motion.files.format import Format
from nao_kin.motion.files.key_frames import COSINE_ERROR, eased
from nao_kin.motion.files.source import MotionFileWarning, Place, Source, described
from nao_kin.motion.files.tables import columns, sampled
from nao_kin.motion.files.tracks import Track, check_times, motion_of
from nao_kin.motion.motion import Motion
from nao_kin.parameters import BODY_ORDER

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


def recognises(source: Source) -> bool:
    """Whether it is a JSON object with initial_positions."""
    value = source.json.value
    return isinstance(value, dict) and "initial_positions" in value


def read(source: Source) -> Motion:
    """The motion in a HULKs file, whose first key is at 0 s.

    Raises:
        BadInputFile: with line and column, and the path to the value.
    """
    document = source.json.value
    if not isinstance(document, dict):
        raise source.error(f"expected an object with initial_positions, got {described(document)}")
    mode = document.get("interpolation_mode", "linear")
    if mode not in _MODES:
        reason = f"{described(mode)}, expected {' or '.join(_MODES)}"
        raise source.error(reason, source.place(["interpolation_mode"]))
    start, first = _positions(source, ["initial_positions"])
    rows: list[list[Any]] = [list(first.values())]
    frames, paths = list[Path](), [start]
    durations: list[Any] = []
    for path, frame in _frames(source):
        if "duration" not in frame:
            raise source.error("a key frame without a duration", source.place(path))
        durations.append(frame["duration"])
        frames.append(path)
        where, found = _positions(source, [*path, "positions"])
        if found.keys() != first.keys():
            odd = ", ".join(sorted(found.keys() ^ first.keys())[:3])
            raise source.error(f"names other joints than initial_positions: {odd}", source.place(where))
        rows.append([found[joint] for joint in first])
        paths.append(where)
    steps = source.floats(durations, "duration", lambda at: source.place([*frames[at], "duration"]))
    times = np.concatenate([[0.0], np.cumsum(steps)])
    check_times(source, times, lambda key: source.place([*frames[key - 1], "duration"]))
    flat = [value for row in rows for value in row]
    names = list(first)

    def place(at: int) -> Place:
        part, joint = _PLACES[BODY_ORDER.index(names[at % len(names)])]
        return source.place([*paths[at // len(names)], part, joint])

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
    document = source.json.value
    if ("motion" in document) == ("frames" in document):
        raise source.error("expected either motion or frames")
    name = "motion" if "motion" in document else "frames"
    waits = set[str]()
    for index, entry in enumerate(_list(source, [name])):
        path: Path = [name, index]
        if not isinstance(entry, dict):
            raise source.error(f"expected an object, got {described(entry)}", source.place(path))
        if name == "motion":
            waits |= {condition for condition in _CONDITIONS if entry.get(condition)}
            for row, frame in enumerate(_list(source, [*path, "keyframes"])):
                if not isinstance(frame, dict):
                    raise source.error(
                        f"expected an object, got {described(frame)}", source.place([*path, "keyframes", row])
                    )
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


def _list(source: Source, path: Path) -> list[Any]:
    value = source.json.value
    for step in path:
        if isinstance(value, dict) and step not in value:
            raise source.error(f"no {step!r}", source.place(path[:-1]))
        value = value[step]
    if not isinstance(value, list):
        raise source.error(f"expected a list, got {described(value)}", source.place(path))
    return value


def _positions(source: Source, path: Path) -> tuple[Path, dict[str, Any]]:
    """The path to a set of positions, and what they give for each joint, by NAOqi's names."""
    value = source.json.value
    for step in path:
        if isinstance(value, dict) and step not in value:
            raise source.error(f"no {step!r}", source.place(path[:-1]))
        value = value[step]
    if isinstance(value, dict) and _POSITIONS in value:
        path, value = [*path, _POSITIONS], value[_POSITIONS]
    found = dict[str, Any]()
    parts = _objects(source, value, path, (*PARTS, _STIFFNESSES))
    for part, joints in parts.items():
        if part != _STIFFNESSES:
            for joint, angle in _objects(source, joints, [*path, part], PARTS[part]).items():
                found[_JOINTS[part, joint]] = angle
    if not found:
        raise source.error("no joint", source.place(path))
    return path, found


def _objects(source: Source, value: Any, path: Path, names: tuple[str, ...]) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise source.error(f"expected an object, got {described(value)}", source.place(path))
    for name in value:
        if name not in names:
            near = ", ".join(nearest_names(name, names)) or ", ".join(names)
            raise source.error(f"unknown joint (nearest: {near})", source.place([*path, name]))
    return value


def write(motion: Motion, rate: float | None) -> bytes:
    """A HULKs file of the newest generation: a key frame wherever some joint has a key, or at a rate.

    Raises:
        BadArgument: joints that are missing or that the format does not know, times before 0.
    """
    times, values = sampled(motion, rate, "HULKs motion")
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


HULKS = Format("hulks", (".json",), "HULKs' key frames", recognises, read, write)
