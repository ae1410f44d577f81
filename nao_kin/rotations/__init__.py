"""Rotations written by hand in NumPy: matrices, three angles, invariants and quaternions, with leading batch axes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nao_kin._core.guesses import guessing as _guessing
from nao_kin.rotations import rank_one  # noqa: F401  (a page of its own)
from nao_kin.rotations._checks import RotationDefects, check_rotation, is_rotation, nearest_rotation
from nao_kin.rotations._elementary import rot_x, rot_y, rot_z, skew, vee
from nao_kin.rotations._exponential import (
    angle_between,
    exp,
    left_jacobian,
    left_jacobian_inverse,
    log,
    power,
    right_jacobian,
    right_jacobian_inverse,
)
from nao_kin.rotations._fitting import (
    DirectionFit,
    MeanRotation,
    NearestAngles,
    mean_rotation,
    nearest_davenport,
    nearest_euler,
    rotation_between,
    rotation_from_directions,
    rotation_from_points,
)
from nao_kin.rotations._invariants import (
    euler_rodrigues,
    linear_invariants,
    matrix_from_euler_rodrigues,
    matrix_from_linear,
    matrix_from_mrp,
    matrix_from_natural,
    mrp_from_matrix,
    mrp_shadow,
    natural_invariants,
)
from nao_kin.rotations._quaternions import (
    matrix_from_quat,
    quat_canonical,
    quat_conjugate,
    quat_exp,
    quat_from_matrix,
    quat_from_xyzw,
    quat_log,
    quat_multiply,
    quat_nearest,
    quat_power,
    quat_rotate,
    quat_to_xyzw,
    quat_unwrap,
    slerp,
)
from nao_kin.rotations._random import random_quat, random_rotation, random_rotation_near
from nao_kin.rotations._rates import euler_rate_jacobian, euler_rate_jacobian_inverse
from nao_kin.rotations._spline import RotationSpline
from nao_kin.rotations._three_angles import (
    SEQUENCES,
    EulerAngles,
    are_davenport_axes,
    davenport_angles,
    euler_from_matrix,
    euler_from_quat,
    matrix_from_davenport,
    matrix_from_euler,
    matrix_from_rpy,
    quat_from_euler,
    rpy_from_matrix,
)

__all__ = [
    "SEQUENCES",
    "DirectionFit",
    "EulerAngles",
    "MeanRotation",
    "NearestAngles",
    "RotationDefects",
    "RotationSpline",
    "angle_between",
    "are_davenport_axes",
    "check_rotation",
    "davenport_angles",
    "euler_from_matrix",
    "euler_from_quat",
    "euler_rate_jacobian",
    "euler_rate_jacobian_inverse",
    "euler_rodrigues",
    "exp",
    "is_rotation",
    "left_jacobian",
    "left_jacobian_inverse",
    "linear_invariants",
    "log",
    "matrix_from_davenport",
    "matrix_from_euler",
    "matrix_from_euler_rodrigues",
    "matrix_from_linear",
    "matrix_from_mrp",
    "matrix_from_natural",
    "matrix_from_quat",
    "matrix_from_rpy",
    "mean_rotation",
    "mrp_from_matrix",
    "mrp_shadow",
    "natural_invariants",
    "nearest_davenport",
    "nearest_euler",
    "nearest_rotation",
    "power",
    "quat_canonical",
    "quat_conjugate",
    "quat_exp",
    "quat_from_euler",
    "quat_from_matrix",
    "quat_from_xyzw",
    "quat_log",
    "quat_multiply",
    "quat_nearest",
    "quat_power",
    "quat_rotate",
    "quat_to_xyzw",
    "quat_unwrap",
    "random_quat",
    "random_rotation",
    "random_rotation_near",
    "right_jacobian",
    "right_jacobian_inverse",
    "rot_x",
    "rot_y",
    "rot_z",
    "rotation_between",
    "rotation_from_directions",
    "rotation_from_points",
    "rpy_from_matrix",
    "skew",
    "slerp",
    "vee",
]

if not TYPE_CHECKING:
    __getattr__ = _guessing(__name__)
