"""Joints and the motors that move them; one motor may move several joints, such as the two HipYawPitch of a NAO."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._core.sides import Hips, joints_of_side

if TYPE_CHECKING:
    from nao_kin.robot.model import RobotModel


def joints_by_motor(robot: RobotModel, names: Iterable[str]) -> dict[str, list[str]]:
    """Return driving joint → the joints among `names` that its motor moves, the driving joint first."""
    motors: dict[str, list[str]] = {}
    for name in sorted(names, key=robot.mimics.__contains__):
        mimic = robot.mimics.get(name)
        if mimic is None or mimic.multiplier != 0.0:
            motors.setdefault(name if mimic is None else mimic.joint, []).append(name)
    return motors


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
