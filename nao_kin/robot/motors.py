"""Joints and the motors that move them; one motor may move several joints, such as the two HipYawPitch of a NAO."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._core.sides import Hips, joints_of_side
from nao_kin.robot.semantics import Mimic

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


def without_gaps(robot: RobotModel, values: Mapping[str, Floats], rest: Floats) -> dict[str, Floats]:
    """Return joint → finite values, with one for every motor, from values of some joints, in which NaN is a gap.

    A gap is filled with the value of another joint of the same motor, or else with that of the driving joint in `rest`
    (n,), which also has the values of the joints that are absent.
    """
    found = dict(zip(robot.joint_names, rest, strict=True))
    couplings = {name: robot.mimics.get(name) or Mimic(name) for name in values}
    measured: dict[str, Floats] = {}
    for name, coupling in couplings.items():
        if coupling.multiplier != 0.0:
            value = coupling.driver_value(values[name])
            known = measured.get(coupling.joint, value)
            measured[coupling.joint] = np.where(np.isnan(known), value, known)
    for motor, value in measured.items():
        found[motor] = np.where(np.isnan(value), found[motor], value)
    filled = {
        name: np.where(np.isnan(value), couplings[name].value(found[couplings[name].joint]), value)
        for name, value in values.items()
    }
    absent = {name: value for name, value in found.items() if name not in measured}
    return absent | filled


def with_shared_motors(robot: RobotModel, values: Mapping[str, Floats], hips: Hips) -> dict[str, Floats]:
    """Return joint → values with one value for each motor of which several joints are given, as in `motor_values`."""
    several = [name for joints in joints_by_motor(robot, values).values() if len(joints) > 1 for name in joints]
    alone = {name: value for name, value in values.items() if name not in several}
    return alone | motor_values(robot, {name: values[name] for name in several}, hips)
