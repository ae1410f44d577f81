"""The values of all joints of a robot, by the names that an export gives them."""

from __future__ import annotations

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.export.variants.names import new_names
from nao_kin.robot import RobotModel


def joint_values(robot: RobotModel, q: Floats, names: str = "naoqi") -> dict[str, Floats]:
    """Values of every joint in configurations, of joints that follow another one too.

    Args:
        robot: the robot.
        q: configurations, shape (..., nq).
        names: "naoqi" or "ros".

    Returns:
        Name → values, shape (...).
    """
    own = {name: np.asarray(value) for name, value in robot.angles(q).items()}
    values = own | {name: mimic.value(own[mimic.joint]) for name, mimic in robot.mimics.items()}
    new = new_names(robot.semantics, names)
    return {new.get(name, name): value for name, value in values.items()}
