"""Rotations, hand-rolled in NumPy: matrices, three angles, invariants, quaternions; batches over leading axes."""

from __future__ import annotations

from nao_kin.rotations._checks import RotationDefects, check_rotation, is_rotation, nearest_rotation
from nao_kin.rotations._continuity import quat_nearest, quat_unwrap
from nao_kin.rotations._davenport import are_davenport_axes, davenport_angles, matrix_from_davenport
from nao_kin.rotations._directions import DirectionFit, rotation_between, rotation_from_directions
from nao_kin.rotations._elementary import rot_x, rot_y, rot_z
from nao_kin.rotations._euler import (
    EulerAngles,
    euler_from_matrix,
    euler_from_quat,
    matrix_from_euler,
    matrix_from_rpy,
    quat_from_euler,
    rpy_from_matrix,
)
from nao_kin.rotations._exponential import angle_between, exp, log, power
from nao_kin.rotations._invariants import (
    euler_rodrigues,
    linear_invariants,
    matrix_from_euler_rodrigues,
    matrix_from_linear,
    matrix_from_natural,
    natural_invariants,
)
from nao_kin.rotations._jacobians import left_jacobian, left_jacobian_inverse, right_jacobian, right_jacobian_inverse
from nao_kin.rotations._mean import MeanRotation, mean_rotation
from nao_kin.rotations._mrp import matrix_from_mrp, mrp_from_matrix, mrp_shadow
from nao_kin.rotations._nearest_angles import NearestAngles, nearest_davenport, nearest_euler
from nao_kin.rotations._points import rotation_from_points
from nao_kin.rotations._quat_powers import quat_exp, quat_log, quat_power
from nao_kin.rotations._quaternions import (
    matrix_from_quat,
    quat_canonical,
    quat_conjugate,
    quat_from_matrix,
    quat_from_xyzw,
    quat_multiply,
    quat_rotate,
    quat_to_xyzw,
)
from nao_kin.rotations._random import random_quat, random_rotation, random_rotation_near
from nao_kin.rotations._rates import euler_rate_jacobian, euler_rate_jacobian_inverse
from nao_kin.rotations._skew import skew, vee
from nao_kin.rotations._slerp import slerp
from nao_kin.rotations._spline import RotationSpline
from nao_kin.rotations._three_angles import SEQUENCES

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
