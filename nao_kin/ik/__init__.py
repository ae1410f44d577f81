"""Inverse kinematics: joint values for poses, all of them, inside the limits, and the reason where there are none."""

from nao_kin.ik.body.whole_body import whole_body
from nao_kin.ik.body.whole_body_result import WholeBodyResult
from nao_kin.ik.closed_forms.arm import arm
from nao_kin.ik.closed_forms.head import head, look_at
from nao_kin.ik.closed_forms.leg import leg
from nao_kin.ik.closed_forms.legs import legs
from nao_kin.ik.closed_forms.legs_result import LegsResult
from nao_kin.ik.limbs import limb_of_frame, limbs
from nao_kin.ik.paths.follow import follow
from nao_kin.ik.paths.followed_path import FollowedLimb, FollowedPath
from nao_kin.ik.paths.jumps import Jump
from nao_kin.ik.paths.time_scaling import Stretch
from nao_kin.ik.results import Family, IKResult, Obstacles, Reason
from nao_kin.ik.search.numeric import numeric
from nao_kin.ik.velocity import velocity
from nao_kin.ik.velocity_result import TwistMap, VelocityResult
from nao_kin.ik.warming import KERNELS, warm_up

__all__ = [
    "KERNELS",
    "Family",
    "FollowedLimb",
    "FollowedPath",
    "IKResult",
    "Jump",
    "LegsResult",
    "Obstacles",
    "Reason",
    "Stretch",
    "TwistMap",
    "VelocityResult",
    "WholeBodyResult",
    "arm",
    "follow",
    "head",
    "leg",
    "legs",
    "limb_of_frame",
    "limbs",
    "look_at",
    "numeric",
    "velocity",
    "warm_up",
    "whole_body",
]
