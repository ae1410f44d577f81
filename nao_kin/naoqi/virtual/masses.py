"""Masses and centres of mass of the robot's segments, as getMass and getCOM want them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from nao_kin import NaoModel
from nao_kin._common.arrays import Floats
from nao_kin.naoqi.names import as_names, joint_names

TORSO = "Torso"
WHOLE = ("Body", "Joints", "Com")


def mass_and_com(robot: NaoModel, q: ArrayLike, name: str) -> tuple[float, Floats]:
    """Mass of a part and its centre of mass in the torso's frame.

    Args:
        robot: a NAO with a fixed base.
        q: configuration, shape (25,).
        name: a joint for the segment that it moves, a chain or group for the segments of its joints, "Torso" for the
            trunk alone, "Body", "Joints" or "Com" for the whole robot.

    Returns:
        Mass [kg] and position, shape (3,) [m]; the origin of the torso for a part without mass.

    Raises:
        UnknownName: no such part.
    """
    if name in WHOLE:
        return robot.mass, np.array(robot.com(q))
    trunk = name == TORSO
    joints = () if trunk else joint_names(robot, as_names(name))
    total, moment = 0.0, np.zeros(3)
    for joint in (TORSO,) if trunk else joints:
        inertia = robot.model.inertias[0 if trunk else robot.model.getJointId(joint)]
        T_torso_segment = np.eye(4) if trunk else robot.fk(q, joint)
        total += inertia.mass
        moment += inertia.mass * (T_torso_segment[:3, :3] @ inertia.lever + T_torso_segment[:3, 3])
    return float(total), moment / total if total > 0.0 else np.zeros(3)
