"""Observations in a JSON file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats, as_floats
from nao_kin._core.files import described, read_json, read_text
from nao_kin._core.text import quoted
from nao_kin.calibration.observations import AnyObservation, Contacts, Pixels, Poses, errors_of
from nao_kin.errors import BadArgument, BadInputFile, NaoKinError, UnknownName
from nao_kin.robot import RobotModel, check_robot, pose_of
from nao_kin.world import camera

_HEAD = {"joints", "frames", "start", "observations"}
# Of each type of observation: the members that must be names, all others, and those of each posture.
_MEMBERS = {
    "pixels": (("camera",), {"resolution", "intrinsics", "distortion", "points", "frame", "board"}, {"pixels"}),
    "poses": (("frame",), {"world", "marker", "reference"}, {"pose"}),
    "contacts": (("frame", "reference"), {"height"}, set[str]()),
}
_COMMON = {"type", "noise", "posture", "seen"}
# Members that are the attributes of the same names.
_PASSED_ON = ("frame", "board", "world", "marker", "reference", "height", "noise")


def read_observations(robot: RobotModel, path: Path | str) -> dict[str, Any]:
    """Return the arguments of `calibrate` from a JSON file.

    The file has the members `observations` and, as for `calibrate`, `joints`, `frames` and `start`. An observation has
    a `type`: "pixels", "poses" or "contacts"; the attributes of `Pixels`, `Poses` or `Contacts`; and `seen`, a list
    with one object for each posture: `joints` (name → reported value [rad], joints not named as in the `posture` of
    the observation, or zero) and `pixels` ([u, v] or null for each point) or `pose` (six numbers, or rows of four).
    A camera is named, with a `resolution` and perhaps its own `intrinsics` [fx, fy, cx, cy] and `distortion`.

    Args:
        robot: the nominal robot.
        path: the file, "-" for standard input.

    Returns:
        {"observations": […], "joints": …, "frames": …, "start": …}, all of them arguments of `calibrate`.

    Raises:
        BadInputFile: the file cannot be read or is not valid; the message names the observation and posture.

    Examples:
        >>> arguments = nk.calibration.read_observations(nk.load_nao(), "observations.json")  # doctest: +SKIP
        >>> found = nk.calibration.calibrate(nk.load_nao(), **arguments)  # doctest: +SKIP
    """
    check_robot(robot)
    name = str(path)
    document = read_json(name, read_text(name))
    try:
        _check_members(document, _HEAD)
        given = _list(document.get("observations"), "observations")
        joints, frames = document.get("joints", []), document.get("frames", [])
        if not isinstance(joints, list) or not isinstance(frames, list | dict):
            raise BadArgument("joints must be a list of names, and frames too, or an object of lists")
        start = {
            board: pose_of(T, f"start of {board}") for board, T in _object(document.get("start", {}), "start").items()
        }
    except NaoKinError as error:
        raise BadInputFile(name, str(error)) from None
    observations = []
    for number, one in enumerate(given):
        try:
            observations.append(_observation(robot, one))
        except NaoKinError as error:
            raise BadInputFile(name, f"observation {number}: {error}") from None
    return {"observations": observations, "joints": joints, "frames": frames, "start": start}


def _observation(robot: RobotModel, given: Any) -> AnyObservation:
    kind = _object(given, "an observation").get("type")
    if not isinstance(kind, str) or kind not in _MEMBERS:
        raise UnknownName("type of observation", kind, tuple(_MEMBERS))
    names, others, of_seen = _MEMBERS[kind]
    _check_members(given, _COMMON | set(names) | others)
    for key in names:
        if not isinstance(given.get(key), str):
            raise BadArgument(f"{key} must be given: the name of a frame")
    seen, posture, rows = _list(given.get("seen"), "seen"), given.get("posture"), list[Floats]()
    for number, one in enumerate(seen):
        _check_members(one, {"joints"} | of_seen, f"seen {number}: ")
        joints = _object(one.get("joints", {}), f"joints of seen {number}")
        with_posture = robot.configuration if posture is None else partial(robot.posture, posture)
        with errors_of(f"seen {number}"):
            rows.append(with_posture(joints, limits="ignore"))
    own = {key: given[key] for key in _PASSED_ON if key in given}
    if kind == "contacts":
        return Contacts(np.array(rows), **own)
    if kind == "poses":
        poses = [pose_of(one.get("pose"), f"pose of seen {number}") for number, one in enumerate(seen)]
        return Poses(np.array(rows), poses=np.array(poses), **own)
    points = as_floats(_list(given.get("points"), "points"), (3,), "points")
    pixels = [_pixels(one.get("pixels"), len(points), f"pixels of seen {number}") for number, one in enumerate(seen)]
    return Pixels(np.array(rows), _camera(robot, given), np.array(pixels), points, **own)


def _camera(robot: RobotModel, given: Mapping[str, Any]) -> Any:
    resolution = given.get("resolution", "VGA")
    found = camera(robot, given["camera"], tuple(resolution) if isinstance(resolution, list) else resolution)
    if "intrinsics" in given:
        numbers = as_floats(given["intrinsics"], (4,), "intrinsics").tolist()
        found = replace(found, **dict(zip(("fx", "fy", "cx", "cy"), numbers, strict=True)))
    if "distortion" in given:
        found = replace(found, distortion=tuple(as_floats(given["distortion"], (), "distortion").ravel().tolist()))
    return found


def _pixels(given: Any, count: int, what: str) -> Floats:
    rows = [[np.nan, np.nan] if row is None else row for row in _list(given, what)]
    try:
        found = np.array(rows, dtype=np.float64)
    except (TypeError, ValueError):
        raise BadArgument(f"{what} must be [u, v] or null for each point") from None
    if found.shape != (count, 2):
        raise BadArgument(f"{what} must be [u, v] or null for each of {count} points, got {len(rows)}")
    return found


def _list(value: Any, what: str) -> list[Any]:
    if not isinstance(value, list) or not value:
        raise BadArgument(f"{what} must be a list that is not empty, got {quoted(described(value))}")
    return value


def _object(value: Any, what: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise BadArgument(f"{what} must be an object, got {quoted(described(value))}")
    return value


def _check_members(value: Any, known: set[str], where: str = "") -> None:
    for name in _object(value, f"{where}the document" if not where else where.rstrip(": ")):
        if name not in known:
            raise UnknownName(f"{where}member", name, sorted(known))
