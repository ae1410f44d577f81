"""Joints and the motors that move them: bounds, shared motors, and left and right in the names of joints."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from nao_kin._core.arrays import Floats, choice

if TYPE_CHECKING:
    from nao_kin.robot.model import RobotModel

# --- Left and right in the names of joints.

Side = Literal["left", "right"]

_OTHER = {"L": "R", "R": "L", "l": "r", "r": "l"}
_WORDS = {"left": "right", "right": "left", "Left": "Right", "Right": "Left", "LEFT": "RIGHT", "RIGHT": "LEFT"}
_SIDE = re.compile(
    r"""
    (?<![A-Za-z])(?:LEFT|RIGHT)(?![A-Za-z])           # LEFT_ELBOW
    | ^[LR](?=[A-Z])                                  # LShoulderPitch
    | ^[lr](?=_) | (?<=_)[lrLR]$                      # l_elbow, elbow_l
    | ^(?:left|right)(?![a-z]) | (?<![A-Za-z])(?:left|right)$  # left_elbow, leftElbow, elbow_left
    | ^(?:Left|Right)(?![a-z]) | (?:Left|Right)$      # LeftElbow, elbowLeft
    """,
    re.VERBOSE,
)


def side_of(name: str) -> Side | None:
    """Return the side in a name such as LElbowRoll, l_elbow, elbow_l or left_elbow; None without one."""
    match = _SIDE.search(name)
    if match is None:
        return None
    return "left" if match.group()[0] in "lL" else "right"


def other_side(name: str) -> str:
    """Return the name with left and right exchanged; the same name without a side."""
    return _SIDE.sub(lambda match: _WORDS.get(match.group()) or _OTHER[match.group()], name, count=1)


# --- Joints and their motors; one motor may move several joints, such as the two HipYawPitch.


Hips = Literal["average", "left", "right"]


def check_hips(hips: str) -> None:
    """Raise `UnknownName` for an unknown rule for two joints of one motor."""
    choice(hips, get_args(Hips), "rule for the hips")


def joints_by_motor(robot: RobotModel, names: Iterable[str]) -> dict[str, list[str]]:
    """Return driving joint → the joints among `names` that its motor moves, the driving joint first."""
    motors: dict[str, list[str]] = {}
    for name in sorted(names, key=robot.mimics.__contains__):
        mimic = robot.mimics.get(name)
        if mimic is None or mimic.multiplier != 0.0:
            motors.setdefault(name if mimic is None else mimic.joint, []).append(name)
    return motors


def joints_of_side(joints: list[str], hips: Hips) -> list[str]:
    """Return the joints that determine a motor: those on the side `hips`, or all joints if none is on that side."""
    return [joint for joint in joints if side_of(joint) == hips] or joints


def motor_values(robot: RobotModel, values: Mapping[str, Floats], hips: Hips) -> dict[str, Floats]:
    """Return driving joint → values, from values of any joints; a mimic joint gives (value − offset) / multiplier.

    Several joints of one motor give the mean of their values, or of those on the side `hips` if there are any.
    """
    found = {}
    for motor, joints in joints_by_motor(robot, values).items():
        columns = [
            robot.mimics[name].driver_value(values[name]) if name in robot.mimics else values[name]
            for name in joints_of_side(joints, hips)
        ]
        found[motor] = columns[0] if len(columns) == 1 else np.mean(columns, axis=0)
    return found


def with_shared_motors(robot: RobotModel, values: Mapping[str, Floats], hips: Hips) -> dict[str, Floats]:
    """Return joint → values with one value for each motor of which several joints are given, as in `motor_values`."""
    several = [name for joints in joints_by_motor(robot, values).values() if len(joints) > 1 for name in joints]
    alone = {name: value for name, value in values.items() if name not in several}
    return alone | motor_values(robot, {name: values[name] for name in several}, hips)
