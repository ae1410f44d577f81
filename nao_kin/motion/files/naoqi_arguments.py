"""The arguments of NAOqi's angleInterpolation and angleInterpolationBezier, as JSON.

    [["HeadYaw", "HeadPitch"], [[0.3, 0.0], 0.2], [[1.0, 2.0], 1.0], true]
    [["HeadYaw"], [[1.0]], [[[0.3, [3, -0.3, 0.0], [3, 0.0, 0.0]]]]]

The first, of four, are names, angles, times and isAbsolute; the second, of three, names, times and control points. As
in NAOqi, names are one name, a list or a chain such as "Head" or "Body", and angles and times a number or a list for
each joint. An object of the same things by name ("names", "angles" or "keys", "times", "isAbsolute") is read too.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import Any

from nao_kin._common.arrays import Floats
from nao_kin.errors import nearest_names
from nao_kin.motion.files.control_points import control_points, plain_keys, points
from nao_kin.motion.files.format import Format
from nao_kin.motion.files.source import Place, Source, described
from nao_kin.motion.files.tables import is_hand, sampled
from nao_kin.motion.files.tracks import Track, motion_of
from nao_kin.motion.motion import Motion
from nao_kin.parameters import BODY_ORDER, CHAINS

_CHAINS = {**CHAINS, "Body": BODY_ORDER}
_ANGLES = ("angles", "angleLists", "keys", "controlPoints")
_TIMES = ("times", "timeLists")
Path = list[str | int]


def recognises(source: Source) -> bool:
    """Whether it is a JSON list that begins with names, or an object with names and times."""
    value = source.json.value
    if isinstance(value, dict):
        return "names" in value and any(name in value for name in _TIMES)
    if not isinstance(value, list) or len(value) not in (3, 4):
        return False
    return isinstance(value[0], str) or (isinstance(value[0], list) and all(isinstance(x, str) for x in value[0]))


def read(source: Source) -> Motion:
    """The motion that the call makes.

    Raises:
        BadInputFile: with line and column, and the path to the value; relative angles, for what they are relative to is
            not in the file.
    """
    paths = _paths(source)
    names, single = _names(source, paths["names"])
    keys, times = (_per_joint(source, paths[what], names, single=single) for what in ("angles", "times"))
    tracks = []
    bezier = any(not plain_keys(rows) for rows, _ in keys)
    for row, joint in enumerate(names):
        (own, key_path), (stamps, time_path) = keys[row], times[row]

        def time_of(key: int, path: Path | None = time_path) -> Place:
            return Place() if path is None else source.place([*path, key] if path[-1:] != ["="] else path[:-1])

        def key_of(key: int, path: Path | None = key_path) -> Place:
            return Place() if path is None else source.place([*path, key] if path[-1:] != ["="] else path[:-1])

        seconds = source.floats(stamps, "time", time_of)
        if len(own) != len(seconds):
            raise source.error(f"{joint} has {len(seconds)} times and {len(own)} keys", source.place(paths["angles"]))
        values, handles = _curve(source, own, seconds, key_of, bezier=bezier)
        if source.degrees and not is_hand(joint):
            values = values * (math.pi / 180.0)
            if handles is not None:
                handles[..., 1] *= math.pi / 180.0
        tracks.append(Track(joint, seconds, values, handles, source.place(paths["names"]), time_of, key_of))
    return motion_of(source, tracks, "bezier" if bezier else "linear")


def _curve(source: Source, rows: list[Any], times: Floats, place: Any, *, bezier: bool) -> tuple[Floats, Floats | None]:
    if bezier:
        return control_points(source, rows, times, place)
    return source.floats(rows, "angle", place), None


def _paths(source: Source) -> dict[str, Path]:
    """Where names, angles and times stand."""
    value = source.json.value
    if isinstance(value, dict):
        known = ("names", *_ANGLES, *_TIMES, "isAbsolute")
        for name in value:
            if name not in known:
                near = ", ".join(nearest_names(name, known)) or ", ".join(known)
                raise source.error(f"unknown argument (nearest: {near})", source.place([name]))
        found: dict[str, Path] = {}
        for what, choices in (("names", ("names",)), ("angles", _ANGLES), ("times", _TIMES)):
            given = [name for name in choices if name in value]
            if len(given) != 1:
                raise source.error(f"{len(given)} of {' and '.join(choices)}, expected one")
            found[what] = [given[0]]
        absolute, where = value.get("isAbsolute", True), ["isAbsolute"]
    elif isinstance(value, list) and len(value) == 3:
        return {"names": [0], "times": [1], "angles": [2]}
    elif isinstance(value, list) and len(value) == 4:
        found, absolute, where = {"names": [0], "angles": [1], "times": [2]}, value[3], [3]  # type: ignore[list-item]
    else:
        raise source.error(
            f"expected [names, angles, times, isAbsolute] or [names, times, keys], got {described(value)}"
        )
    if absolute is False or absolute == 0:
        raise source.error("relative angles: what they are relative to is not in the file", source.place(where))
    if absolute is not True and absolute != 1:
        raise source.error(f"isAbsolute is {described(absolute)}, expected true", source.place(where))
    return found


def _names(source: Source, path: Path) -> tuple[list[str], bool]:
    """The joints, and whether they are one name."""
    given = source.json.value[path[0]]
    single = isinstance(given, str)
    names: list[str] = []
    for index, name in enumerate(given if isinstance(given, list) else [given]):
        where = [*path, index] if isinstance(given, list) else path
        if isinstance(name, str) and name in _CHAINS and name not in source.joints:
            named: Sequence[str] = _CHAINS[name]
        else:
            named = [source.check_joint(name, lambda where=where: source.place(where))]  # type: ignore[misc]
        for joint in named:
            if joint in names:
                raise source.error(f"joint {joint} is given twice", source.place(where))
            names.append(joint)
    if not names:
        raise source.error("no names", source.place(path))
    return names, single and len(names) == 1


def _per_joint(source: Source, path: Path, names: list[str], *, single: bool) -> list[tuple[list[Any], Path | None]]:
    """What stands for each joint as a list, and its path; a path that ends in "=" is that of a single value."""
    given = source.json.value[path[0]]
    if not isinstance(given, list):
        return [([given], [*path, "="])] * len(names)
    nested = any(isinstance(entry, list) for entry in given)
    if single and (not nested or _is_points(given)):
        return [(given, path)]
    if len(names) == 1 and not nested:
        return [(given, path)]
    if len(given) == 1 and not nested:
        return [(given, path)] * len(names)
    if len(given) != len(names):
        raise source.error(f"{len(given)} entries for {len(names)} joints", source.place(path))
    return [
        (entry, [*path, row]) if isinstance(entry, list) else ([entry], [*path, row, "="])
        for row, entry in enumerate(given)
    ]


def _is_points(rows: list[Any]) -> bool:
    """Whether a list is the control points of one joint, and not a list of such lists."""
    return isinstance(rows[0], list) and bool(rows[0]) and not isinstance(rows[0][0], list) and len(rows[0]) == 3


def write(motion: Motion, rate: float | None) -> bytes:
    """The arguments of angleInterpolation for a linear motion, else those of angleInterpolationBezier."""
    if rate is not None:
        times, values = sampled(motion, rate, "NAOqi")
        motion = Motion(times, motion.joint_names, values)
    names = json.dumps(list(motion.joint_names), ensure_ascii=False)
    stamps, keys = ([row.tolist() for row in motion.times], points(motion))
    rows = [_rows(stamps), _rows(keys)] if motion.interpolation != "linear" else [_rows(keys), _rows(stamps), "true"]
    return ("[" + ",\n ".join([names, *rows]) + "]\n").encode()


def _rows(rows: list[list[Any]]) -> str:
    return "[\n" + ",\n".join(f"  {json.dumps(row)}" for row in rows) + "]"


NAOQI = Format("naoqi", (".json",), "arguments of angleInterpolation", recognises, read, write)
