"""Inverse kinematics: joint values for poses, all of them, inside the limits, and the reason where there are none."""

from nao_kin.ik.numeric import numeric
from nao_kin.ik.results import Family, IKResult, Obstacles, Reason
from nao_kin.ik.velocity import velocity
from nao_kin.ik.velocity_result import TwistMap, VelocityResult

__all__ = [
    "Family",
    "IKResult",
    "Obstacles",
    "Reason",
    "TwistMap",
    "VelocityResult",
    "numeric",
    "velocity",
]
