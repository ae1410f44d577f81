"""What is compared and how: the functions under test, one row's comparison, and how far two results are apart."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from nao_kin import rotations
from nao_kin._common.arrays import Floats
from nao_kin.crosscheck.samples import RotationSample
from nao_kin.joints import JointAxes

# The difference of a pair that says nothing about the convention; it is not counted.
LEFT_OUT = -1.0

Function = Callable[..., Any]


@dataclass(frozen=True)
class Conversions:
    """Every conversion that a run compares; by default the library's own.

    Each field holds the public function of that name of `nao_kin.rotations`, and `joint_axes` what makes the
    `JointAxes` of a robot. The hand-rolled forward kinematics turns with `rot_x`, `rot_y` and `rot_z`.
    `dataclasses.replace(Conversions(), log=mine)` puts another function to the test.

    Examples:
        >>> from dataclasses import replace
        >>> mine = replace(nk.crosscheck.Conversions(), log=lambda R: -nk.rotations.log(R))
        >>> report = nk.crosscheck.run(nk.load_nao(), samples=1, conversions=mine)
        >>> [row.convention for row in report.rows if not row.ok]
        ['log', 'log']
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


def difference(ours: Any, theirs: Floats) -> Floats:
    """Largest difference of any component, shape (n,); infinite where the shapes differ."""
    mine = np.asarray(ours, dtype=np.float64)
    if mine.shape != theirs.shape:
        return np.full(len(theirs), np.inf)
    return np.asarray(np.abs(mine - theirs).max(axis=tuple(range(1, mine.ndim)), initial=0.0))


def angle_difference(ours: Floats, theirs: Floats) -> Floats:
    """Difference of angles modulo a turn, in magnitude, component by component [rad]."""
    apart = ours - theirs
    return np.asarray(np.abs(apart - 2.0 * np.pi * np.round(apart / (2.0 * np.pi))))


def direction_difference(ours: Any, theirs: Floats) -> Floats:
    """Difference of vectors of which v and −v mean the same."""
    return np.minimum(difference(ours, theirs), difference(ours, -theirs))


def rotation_vector_difference(ours: Any, theirs: Floats) -> Floats:
    """Difference of rotation vectors, of which v and v − 2π v/‖v‖ mean the same: none jumps at π."""
    length = np.sqrt(np.square(theirs).sum(axis=1, keepdims=True))
    round_the_other_way = theirs - 2.0 * np.pi * theirs / np.where(length > 0.0, length, 1.0)
    return np.minimum(difference(ours, theirs), difference(ours, round_the_other_way))


def outside(value: Floats, lower: float, upper: float) -> Floats:
    """How far a value is outside [lower, upper]."""
    return np.maximum(np.maximum(lower - value, value - upper), 0.0)


def largest(*differences: Floats) -> Floats:
    """The largest of several differences of each pair; NaN counts as the largest."""
    return np.asarray(np.maximum.reduce(differences))
