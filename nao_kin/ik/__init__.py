"""Inverse kinematics: joint values for poses, all of them, inside the limits, and the reason where there are none."""

from nao_kin.ik.numeric import numeric
from nao_kin.ik.results import Family, IKResult, Obstacles, Reason

__all__ = ["Family", "IKResult", "Obstacles", "Reason", "numeric"]
