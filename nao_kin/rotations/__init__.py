"""Rotations, hand-rolled in NumPy: matrices, three angles, invariants, quaternions; batches over leading axes."""

from __future__ import annotations

from nao_kin.rotations._checks import RotationDefects, check_rotation, is_rotation, nearest_rotation
from nao_kin.rotations._davenport import are_davenport_axes, davenport_angles, matrix_from_davenport
from nao_kin.rotations._elementary import rot_x, rot_y, rot_z
from nao_kin.rotations._euler import EulerAngles, euler_from_matrix, matrix_from_euler, matrix_from_rpy, rpy_from_matrix
from nao_kin.rotations._invariants import (
    euler_rodrigues,
    exp,
    linear_invariants,
    log,
    matrix_from_euler_rodrigues,
    matrix_from_linear,
    matrix_from_natural,
    natural_invariants,
)
from nao_kin.rotations._points import rotation_from_points
from nao_kin.rotations._quaternions import (
    matrix_from_quat,
    quat_canonical,
    quat_conjugate,
    quat_from_matrix,
    quat_from_xyzw,
    quat_multiply,
    quat_to_xyzw,
    slerp,
)
from nao_kin.rotations._three_angles import SEQUENCES

__all__ = [
    "SEQUENCES",
    "EulerAngles",
    "RotationDefects",
    "are_davenport_axes",
    "check_rotation",
    "davenport_angles",
    "euler_from_matrix",
    "euler_rodrigues",
    "exp",
    "is_rotation",
    "linear_invariants",
    "log",
    "matrix_from_davenport",
    "matrix_from_euler",
    "matrix_from_euler_rodrigues",
    "matrix_from_linear",
    "matrix_from_natural",
    "matrix_from_quat",
    "matrix_from_rpy",
    "natural_invariants",
    "nearest_rotation",
    "quat_canonical",
    "quat_conjugate",
    "quat_from_matrix",
    "quat_from_xyzw",
    "quat_multiply",
    "quat_to_xyzw",
    "rot_x",
    "rot_y",
    "rot_z",
    "rotation_from_points",
    "rpy_from_matrix",
    "slerp",
]
