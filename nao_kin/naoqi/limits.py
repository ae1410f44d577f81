"""Joint limits as getLimits gives them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.naoqi.names import joint_names
from nao_kin.robot import RobotModel, check_robot


def limits(robot: RobotModel, names: str | Iterable[str] = "Body") -> Floats:
    """[minAngle, maxAngle, maxVelocity, maxTorque] of joints, a row each, from the robot's own URDF.

    Ranges are the boxes; HeadPitch and the AnkleRolls are narrower where another joint's value makes them so, which
    getLimits does not say (`robot.coupled_limits` does). The published URDFs of the NAO hold the speeds at no load.

    Args:
        robot: a NAO of any version.
        names: as in `joint_names`.

    Returns:
        Shape (n, 4) [rad, rad, rad/s, N m; 0 to 1 and 1/s for the hands].

    Raises:
        UnknownName, BadArgument: as `joint_names`.

    Examples:
        >>> nk.naoqi.limits(nk.load_nao(), "HeadYaw").round(3).tolist()
        [[-2.086, 2.086, 8.268, 1.547]]
    """
    check_robot(robot)
    column = {name: index for index, name in enumerate(robot.joint_names)}
    rows = []
    for joint in joint_names(robot, names):
        mimic = robot.mimics.get(joint)
        own = column[joint if mimic is None else mimic.joint]
        box = float(robot.lower[own]), float(robot.upper[own])
        lower, upper = box if mimic is None else mimic.range(*box)
        ratio = 1.0 if mimic is None else abs(mimic.multiplier)
        rows.append((lower, upper, ratio * float(robot.velocity_limits[own]), float(robot.effort_limits[own])))
    return np.array(rows, dtype=np.float64).reshape(-1, 4)
