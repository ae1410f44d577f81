"""Observations in a JSON file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats, as_floats, join_poses
from nao_kin._core.files import described, read_json, read_text
from nao_kin._core.text import quoted
from nao_kin.calibration.observations import AnyObservation, Contacts, Pixels, Poses
from nao_kin.errors import BadArgument, BadInputFile, NaoKinError, UnknownName
from nao_kin.robot import RobotModel, check_robot
from nao_kin.rotations import matrix_from_rpy
from nao_kin.world import camera

_HEAD = {"joints", "frames", "start", "observations"}
# The members of an observation of each type, and of each thing it has seen; those of every type.
_MEMBERS = {
    "pixels": ({"camera", "resolution", "intrinsics", "distortion", "points", "frame", "board"}, {"pixels"}),
    "poses": ({"frame", "world", "marker", "reference"}, {"pose"}),
    "contacts": ({"frame", "reference", "height"}, set[str]()),
}
_COMMON, _COMMON_SEEN = {"type", "noise", "posture", "seen"}, {"joints"}


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
        {"observations": […], "joints": …, "frames": …, "start": …}, of which calibrate takes all.

    Raises:
        BadInputFile: the file cannot be read, or what it says is not understood; names the observation and posture.

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
            board: _pose(T, f"start of {board}") for board, T in _object(document.get("start", {}), "start").items()
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
    members, of_seen = _MEMBERS[kind]
    _check_members(given, _COMMON | members)
    seen = _list(given.get("seen"), "seen")
    for number, one in enumerate(seen):
        _check_members(one, _COMMON_SEEN | of_seen, f"seen {number}: ")
    posture = given.get("posture")
    base = robot.neutral() if posture is None else robot.posture(posture)
    rows = [_configuration(robot, base, one.get("joints", {}), f"seen {number}") for number, one in enumerate(seen)]
    own = {key: value for key, value in given.items() if key in {"frame", "board", "world", "marker", "reference"}}
    own |= {key: given[key] for key in ("noise", "height") if key in given}
    for key in (
        ("frame", "camera", "reference") if kind == "contacts" else ("camera",) if kind == "pixels" else ("frame",)
    ):
        if not isinstance(given.get(key, "" if key == "camera" and kind != "pixels" else None), str):
            raise BadArgument(f"{key} must be given: the name of a frame")
    if kind == "contacts":
        return Contacts(np.array(rows), **own)
    if kind == "poses":
        poses = [_pose(one.get("pose"), f"pose of seen {number}") for number, one in enumerate(seen)]
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


def _configuration(robot: RobotModel, base: Floats, joints: Any, what: str) -> Floats:
    """Return a configuration with the named joints, others as in the base posture."""
    values = _object(joints, f"joints of {what}")
    named = robot.configuration(values, limits="ignore")
    q = np.array(base)
    for name in values:
        place = (
            robot.nq
            - len(robot.joint_names)
            + robot.joint_names.index(robot.mimics[name].joint if name in robot.mimics else name)
        )
        q[place] = named[place]
    return q


def _pixels(given: Any, count: int, what: str) -> Floats:
    rows = [[np.nan, np.nan] if row is None else row for row in _list(given, what)]
    try:
        found = np.array(rows, dtype=np.float64)
    except (TypeError, ValueError):
        raise BadArgument(f"{what} must be [u, v] or null for each point") from None
    if found.shape != (count, 2):
        raise BadArgument(f"{what} must be [u, v] or null for each of {count} points, got {len(rows)}")
    return found


def _pose(given: Any, what: str) -> Floats:
    array = as_floats(_list(given, what), (), what)
    if array.shape == (6,):
        return join_poses(matrix_from_rpy(array[3:]), array[:3])
    if array.shape != (4, 4):
        raise BadArgument(f"{what} must be (x, y, z, roll, pitch, yaw), or four rows of four")
    return array


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
