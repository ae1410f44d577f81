"""HULKs' older .motion2: JSON with lists of positions, whose times are shares of the whole.

    {"header": {"version": "2.0", "title": "nod", "time": 1000, "joints": [0, 1]},
     "position": [{"time": 1, "parameters": [0.0, 0.2]}, {"time": 3, "parameters": [0.0, 0.0]}],
     "stiffness": [{"time": 1, "parameters": [1.0, 1.0]}]}

Source: HULKs' code releases, MotionFile.cpp and MotionFilePlayer.cpp: joints are numbers in the order of NAOqi's Body,
angles radians, header.time whole milliseconds; the times of the positions are scaled so that their sum is header.time.
The first position is reached from wherever the robot is, on a straight line, as are the others.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from nao_kin.errors import BadArgument
from nao_kin.motion.files.format import Format
from nao_kin.motion.files.source import Place, Source, described
from nao_kin.motion.files.tables import columns, milliseconds, sampled
from nao_kin.motion.files.tracks import Track, check_times, motion_of
from nao_kin.motion.motion import Motion
from nao_kin.parameters import BODY_ORDER

_VERSION = "2.0"


def recognises(source: Source) -> bool:
    """Whether it is a JSON object with header and position."""
    value = source.json.value
    return isinstance(value, dict) and "header" in value and ("position" in value or "commands" in value)


def read(source: Source) -> Motion:
    """The motion in a .motion2 file; stiffnesses are left out.

    Raises:
        BadInputFile: with line and column, and the path to the value.
    """
    document = source.json.value
    if not isinstance(document, dict) or not isinstance(document.get("header"), dict):
        raise source.error("expected an object with header and position")
    header = document["header"]
    if header.get("version") != _VERSION:
        raise source.error(
            f"version {described(header.get('version'))}, expected {_VERSION!r}", source.place(["header"])
        )
    joints = header.get("joints")
    if not isinstance(joints, list) or not joints:
        raise source.error("expected a list of numbers of joints under joints", source.place(["header"]))
    for index, joint in enumerate(joints):
        place = source.place(["header", "joints", index])
        if type(joint) is not int or not 0 <= joint < len(BODY_ORDER):
            raise source.error(f"{described(joint)}, expected the number of a joint, 0 to {len(BODY_ORDER) - 1}", place)
        if joint in joints[:index]:
            raise source.error(f"joint {joint} ({BODY_ORDER[joint]}) is given twice", place)
    total = source.floats([header.get("time")], "time", lambda _: source.place(["header"]))[0]
    positions = document.get("position")
    if not isinstance(positions, list) or not positions:
        raise source.error("no list of positions under position")
    steps, rows = [], []
    for index, entry in enumerate(positions):
        if not isinstance(entry, dict) or not isinstance(entry.get("parameters"), list) or "time" not in entry:
            raise source.error("expected an object with time and parameters", source.place(["position", index]))
        if len(entry["parameters"]) != len(joints):
            reason = f"{len(entry['parameters'])} values for {len(joints)} joints"
            raise source.error(reason, source.place(["position", index, "parameters"]))
        steps.append(entry["time"])
        rows += entry["parameters"]
    shares = source.floats(steps, "time", lambda at: source.place(["position", at, "time"]))
    return _motion(source, joints, float(total), shares, rows)


def _motion(source: Source, joints: list[int], total: float, shares: Any, rows: list[Any]) -> Motion:
    if total < 0.0 or (shares < 0.0).any():
        entry: list[str | int] = ["position", int(np.argmax(shares < 0.0)), "time"]
        bad = ["header", "time"] if total < 0.0 else entry
        raise source.error("a negative time", source.place(bad))
    sums = np.cumsum(shares)
    times = sums * (total / sums[-1]) / 1e3 if sums[-1] > 0.0 else np.zeros(len(shares))
    check_times(source, times, lambda key: source.place(["position", key, "time"]))

    def place(at: int) -> Place:
        return source.place(["position", at // len(joints), "parameters", at % len(joints)])

    table = source.floats(rows, "angle", place).reshape(len(times), len(joints))
    tracks = [Track(BODY_ORDER[joint], times, table[:, column].copy()) for column, joint in enumerate(joints)]
    return motion_of(source, tracks)


def write(motion: Motion, rate: float | None) -> bytes:
    """A .motion2 file at full stiffness: a position wherever some joint has a key, or at a rate.

    Raises:
        BadArgument: joints that the format does not know, times before 0 or nearer than 1 ms.
    """
    times, values = sampled(motion, rate, "motion2")
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


MOTION2 = Format("motion2", (".motion2",), "HULKs' older positions", recognises, read, write)
