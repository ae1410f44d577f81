"""The functions under test, in one place where a faulty one can be put in, and how one of them is compared."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from nao_kin import rotations
from nao_kin._common.arrays import Floats
from nao_kin.crosscheck.samples import RotationSample
from nao_kin.joints import JointAxes

Function = Callable[..., Any]


@dataclass(frozen=True)
class Conversions:
    """Every conversion that a run compares; by default the library's own.

    Each field holds the public function of that name of `nao_kin.rotations`, and `joint_axes` what makes the
    `JointAxes` of a robot. The hand-rolled forward kinematics turns with `rot_x`, `rot_y` and `rot_z`.
    `dataclasses.replace(Conversions(), log=mine)` puts another function to the test.
    """

    rot_x: Function = rotations.rot_x
    rot_y: Function = rotations.rot_y
    rot_z: Function = rotations.rot_z
    matrix_from_rpy: Function = rotations.matrix_from_rpy
    rpy_from_matrix: Function = rotations.rpy_from_matrix
    matrix_from_euler: Function = rotations.matrix_from_euler
    euler_from_matrix: Function = rotations.euler_from_matrix
    matrix_from_davenport: Function = rotations.matrix_from_davenport
    davenport_angles: Function = rotations.davenport_angles
    matrix_from_natural: Function = rotations.matrix_from_natural
    natural_invariants: Function = rotations.natural_invariants
    matrix_from_linear: Function = rotations.matrix_from_linear
    linear_invariants: Function = rotations.linear_invariants
    matrix_from_euler_rodrigues: Function = rotations.matrix_from_euler_rodrigues
    euler_rodrigues: Function = rotations.euler_rodrigues
    exp: Function = rotations.exp
    log: Function = rotations.log
    matrix_from_quat: Function = rotations.matrix_from_quat
    quat_from_matrix: Function = rotations.quat_from_matrix
    quat_multiply: Function = rotations.quat_multiply
    quat_conjugate: Function = rotations.quat_conjugate
    quat_to_xyzw: Function = rotations.quat_to_xyzw
    quat_from_xyzw: Function = rotations.quat_from_xyzw
    slerp: Function = rotations.slerp
    joint_axes: Function = JointAxes


@dataclass(frozen=True)
class Check:
    """A row of the report as a function of rotations: one conversion beside one oracle.

    Attributes:
        convention, against, note: as in `Row`.
        difference: how far the two are apart at n rotations, shape (n,); `LEFT_OUT` where a rotation says nothing.
    """

    convention: str
    against: str
    difference: Callable[[RotationSample, Conversions], Floats]
    note: str = ""
