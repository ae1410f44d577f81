"""Semantics from a small TOML file, to lie beside a URDF.

```toml
end_effectors = ["l_hand", "r_hand"]
soles = ["l_sole", "r_sole"]
cameras = ["camera"]
accelerometers = ["imu"]
gyrometers = ["imu"]
force_sensors = ["l_sole", "r_sole"]
start = "stand"
root = "pelvis"

[chains]
left_arm = ["l_shoulder", "l_elbow"]

[postures.stand]
angles = { l_elbow = -0.4 }          # rad, m or ratio; joints not named are at zero

[postures.lie]
angles = { l_elbow = -0.1 }
up = [1.0, 0.0, 0.0]                 # where it does not stand on its soles

[[coupled_limits]]
joint = "head_pitch"
of = "head_yaw"
at = [-1.0, 0.0, 1.0]
lower = [-0.2, -0.5, -0.2]
upper = [0.2, 0.5, 0.2]

[units]
l_gripper = "1"

[fields_of_view]
camera = [0.98, 0.76]                # horizontal and vertical [rad]

[ros_names]
l_hand = "l_gripper"                 # where the ROS description of the robot has another name

[views.hands]
direction = [1.0, 0.2, 0.5]
joints = ["l_wrist", "r_wrist"]
```
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from nao_kin._core.arrays import Vector
from nao_kin._core.files import read_toml
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument, BadInputFile, nearest_names
from nao_kin.robot.semantics.meaning import FRAME_FIELDS, CoupledLimit, Posture, Semantics, View


def read_semantics(path: Path | str) -> Semantics:
    """The semantics that a TOML file describes.

    Whether its joints and frames exist is not looked at here, but when a robot is given them.

    Raises:
        BadArgument: no path.
        BadInputFile: the file cannot be read, is no TOML, or has an entry that is unknown or of the wrong kind.

    Examples:
        >>> from pathlib import Path
        >>> _ = Path("robot.toml").write_text("end_effectors = ['gripper']")
        >>> nk.semantics.read_semantics("robot.toml").end_effectors
        ('gripper',)
    """
    document = read_toml(path)
    try:
        return Semantics(**_members(document, "", _READERS))
    except (_Wrong, BadArgument) as error:
        raise BadInputFile(str(path), str(error)) from None


_LARGEST = sys.float_info.max


class _Wrong(Exception):
    """What is wrong with an entry; `read_semantics` adds the file's name."""


_Reader = Callable[[Any, str], Any]


def _members(table: Any, where: str, readers: Mapping[str, _Reader], required: tuple[str, ...] = ()) -> dict[str, Any]:
    """The entries of a table, each read by the reader of its name."""
    values = _table(table, where)
    for name in values:
        if name not in readers:
            near = ", ".join(nearest_names(name, readers) or sorted(readers))
            raise _Wrong(f"unknown entry {quoted(where + name)} (nearest: {near})")
    for name in required:
        if name not in values:
            raise _Wrong(f"{where.rstrip('.')} has no {name!r}")
    return {name: readers[name](value, f"{where}{name}") for name, value in values.items()}


def _table(value: Any, where: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise _Wrong(f"{where.rstrip('.')} must be a table, got {quoted(value)}")
    return value


def _text(value: Any, where: str) -> str:
    if not isinstance(value, str):
        raise _Wrong(f"{where} must be text, got {quoted(value)}")
    return value


def _number(value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) <= _LARGEST:
        raise _Wrong(f"{where} must be a finite number, got {quoted(value)}")
    return float(value)


def _list_of(read: _Reader) -> Callable[[Any, str], tuple[Any, ...]]:
    def read_list(value: Any, where: str) -> tuple[Any, ...]:
        if not isinstance(value, list):
            raise _Wrong(f"{where} must be a list, got {quoted(value)}")
        return tuple(read(item, f"{where}[{index}]") for index, item in enumerate(value))

    return read_list


def _table_of(read: _Reader) -> Callable[[Any, str], dict[str, Any]]:
    def read_table(value: Any, where: str) -> dict[str, Any]:
        return {name: read(item, f"{where}.{name}") for name, item in _table(value, where).items()}

    return read_table


_names, _numbers = _list_of(_text), _list_of(_number)


def _vector(value: Any, where: str) -> Vector:
    numbers = _numbers(value, where)
    if len(numbers) != 3 or not any(numbers):
        raise _Wrong(f"{where} must be three numbers, not all zero, got {quoted(value)}")
    return numbers[0], numbers[1], numbers[2]


def _posture(value: Any, where: str) -> Posture:
    return Posture(**_members(value, f"{where}.", {"angles": _table_of(_number), "up": _vector}, ("angles",)))


def _view(value: Any, where: str) -> View:
    readers: dict[str, _Reader] = {"direction": _vector, "joints": _names}
    return View(**_members(value, f"{where}.", readers, tuple(readers)))


def _coupled_limit(value: Any, where: str) -> CoupledLimit:
    readers: dict[str, _Reader] = {"joint": _text, "of": _text, "at": _numbers, "lower": _numbers, "upper": _numbers}
    return CoupledLimit(**_members(value, f"{where}.", readers, tuple(readers)))


_READERS: dict[str, _Reader] = {
    **dict.fromkeys(FRAME_FIELDS, _names),
    **dict.fromkeys(("start", "version", "root"), _text),
    "chains": _table_of(_names),
    "postures": _table_of(_posture),
    "coupled_limits": _list_of(_coupled_limit),
    "units": _table_of(_text),
    "views": _table_of(_view),
    "fields_of_view": _table_of(_numbers),
    "ros_names": _table_of(_text),
}
