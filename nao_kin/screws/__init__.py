"""Rigid motions written by hand in NumPy: poses, twists, wrenches, screws, SE(3) and its Jacobians, interpolation.

A twist is (v; ω), linear part first, as in the Jacobians of this package and in Pinocchio; a wrench is (force; moment).
The Plücker coordinates of `nao_kin.screws.lines` are (direction; moment): a unit rotation about a line is the twist
(moment; direction), with the halves exchanged, and a unit force along it the wrench (direction; moment).
"""

from __future__ import annotations

from nao_kin._core.guesses import public_attributes as _public_attributes
from nao_kin.screws._exponential import (
    Screw,
    exp,
    hat,
    left_jacobian,
    left_jacobian_inverse,
    log,
    right_jacobian,
    right_jacobian_inverse,
    sclerp,
    vee,
)
from nao_kin.screws._poses import (
    adjoint,
    bracket,
    dual_bracket,
    dual_quat_from_pose,
    dual_quat_multiply,
    inverse,
    nearest_pose,
    pose,
    pose_from_dual_quat,
    pose_of as pose_of,
    refuse_not_rigid as refuse_not_rigid,
    rigid_poses as rigid_poses,
    transform_point,
    transform_twist,
    transform_wrench,
)

__all__ = [
    "Screw",
    "adjoint",
    "bracket",
    "dual_bracket",
    "dual_quat_from_pose",
    "dual_quat_multiply",
    "exp",
    "hat",
    "inverse",
    "left_jacobian",
    "left_jacobian_inverse",
    "log",
    "nearest_pose",
    "pose",
    "pose_from_dual_quat",
    "right_jacobian",
    "right_jacobian_inverse",
    "sclerp",
    "transform_point",
    "transform_twist",
    "transform_wrench",
    "vee",
]

globals().update(_public_attributes(__name__))
