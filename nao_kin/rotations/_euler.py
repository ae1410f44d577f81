"""Three angles and back: all 24 conventions, both solutions, at every distance from lock."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._common.arrays import Floats
from nao_kin._common.kernels import evaluate
from nao_kin._common.vectors import as_batch
from nao_kin.rotations._checks import evaluate_rotations
from nao_kin.rotations._quaternions import matrix_from_quat, quat_from_matrix
from nao_kin.rotations._three_angles import (
    REQUIRED,
    AtLock,
    Axes,
    check_at_lock,
    composition,
    extraction,
    find_any_convention,
    find_convention,
)


@dataclass(frozen=True, eq=False)
class EulerAngles:
    """The two triples of angles that give one rotation.

    Attributes:
        angles: the principal triple, shape (..., 3) [rad], in the order of the sequence as written: middle angle in
            [−π/2, π/2], or in [0, π] where the first and third axes are the same; the outer two in [−π, π].
        other: the other triple, shape (..., 3) [rad], all three in [−π, π].
        locked: shape (...); True where only the sum or the difference of the outer angles is determined.

    Examples:
        >>> found = nk.rotations.euler_from_matrix(nk.rotations.rot_y(0.5), "zyx", axes="moving")
        >>> found.angles, found.other, found.locked
        (array([0. , 0.5, 0. ]), array([3.1416, 2.6416, 3.1416]), array(False))
    """

    angles: Floats
    other: Floats
    locked: NDArray[np.bool_]


def matrix_from_euler(angles: ArrayLike, sequence: str, *, axes: Axes = REQUIRED) -> Floats:
    """Rotation matrix of three turns about coordinate axes, or of one or two.

    For a sequence "ijk" and angles (α, β, γ), in that order:
    moving axes, R = Ri(α) Rj(β) Rk(γ); fixed axes, R = Rk(γ) Rj(β) Ri(α).
    For "ij": moving axes, R = Ri(α) Rj(β); fixed axes, R = Rj(β) Ri(α). For "i": R = Ri(α).

    Args:
        angles: shape (..., 3), or (..., 2) or (..., 1) as the sequence is long [rad]; in its order.
        sequence: one to three of "x", "y", "z", neighbours different, lower case.
        axes: "moving" or "fixed"; required.

    Returns:
        Rotation matrices, shape (..., 3, 3), active.

    Raises:
        UnknownName: no such sequence or kind of axes.
        BadArgument, WrongShape, NotFinite: `axes` missing; angles not numbers, not as many as axes, NaN.

    Source: Craig, Introduction to Robotics, 2.8 and appendix B.

    Examples:
        >>> quarter = np.pi / 2
        >>> nk.rotations.matrix_from_euler([quarter, quarter, 0], "xyz", axes="moving").round(12) + 0.0
        array([[0., 0., 1.],
               [1., 0., 0.],
               [0., 1., 0.]])
        >>> turned = nk.rotations.matrix_from_euler([0.2, 0.3], "zy", axes="moving")
        >>> np.allclose(turned, nk.rotations.rot_z(0.2) @ nk.rotations.rot_y(0.3))
        True
    """
    convention, count = find_any_convention(sequence, axes)
    values = as_batch(angles, (count,), "angles")
    if count < 3:
        values = np.concatenate([values, np.zeros((*values.shape[:-1], 3 - count))], axis=-1)
    return evaluate(composition(convention), [values], (3, 3))[0]


def quat_from_euler(angles: ArrayLike, sequence: str, *, axes: Axes = REQUIRED) -> Floats:
    """Unit quaternion of three turns about coordinate axes, or of one or two.

    Args:
        angles: as in `matrix_from_euler` [rad].
        sequence: as in `matrix_from_euler`.
        axes: as in `matrix_from_euler`.

    Returns:
        Quaternions (r0, r1, r2, r3), scalar first, in canonical sign, shape (..., 4).

    Raises:
        UnknownName, BadArgument, WrongShape, NotFinite: as `matrix_from_euler`.

    Examples:
        >>> nk.rotations.quat_from_euler([0.0, 0.0, np.pi / 2], "xyz", axes="moving").round(4)
        array([0.7071, 0.    , 0.    , 0.7071])
    """
    return quat_from_matrix(matrix_from_euler(angles, sequence, axes=axes))


def euler_from_quat(q: ArrayLike, sequence: str, *, axes: Axes = REQUIRED, at_lock: AtLock = "third") -> EulerAngles:
    """Both triples of angles of the rotation of a quaternion.

    Args:
        q: quaternions (r0, r1, r2, r3), scalar first, of any length but zero, shape (..., 4).
        sequence: as in `euler_from_matrix`.
        axes: as in `euler_from_matrix`.
        at_lock: as in `euler_from_matrix`.

    Returns:
        The angles, as of `euler_from_matrix`.

    Raises:
        ZeroNorm: some quaternion is zero; carries its index.
        UnknownName, BadArgument, WrongShape, NotFinite: as `euler_from_matrix`.

    Examples:
        >>> nk.rotations.euler_from_quat([1.0, 0.0, 0.0, 1.0], "zyx", axes="moving").angles.round(4)
        array([1.5708, 0.    , 0.    ])
    """
    return euler_from_matrix(matrix_from_quat(q), sequence, axes=axes, at_lock=at_lock)


def euler_from_matrix(R: ArrayLike, sequence: str, *, axes: Axes = REQUIRED, at_lock: AtLock = "third") -> EulerAngles:
    """Both triples of angles of a rotation, exact at every distance from lock.

    The first angle comes from an atan2, is turned back out of the matrix, and the other two come from an atan2 each of
    what is left; they absorb whatever error the first one has, so the matrix of the angles differs from R by a few
    units of 1e-16 even where the single angles are ill-determined. For moving axes x, y, z:

        α = atan2(−r23, r33),  β = atan2(r13, √(r23² + r33²)),
        γ = atan2(cos α r21 + sin α r31, cos α r22 + sin α r32).

    The other triple is (α + π, π − β, γ + π), or (α + π, −β, γ + π) where the first and third axes are the same.

    Args:
        R: rotation matrices, shape (..., 3, 3).
        sequence: three of "x", "y", "z", neighbours different, lower case; angles are returned in this order.
        axes: "moving" or "fixed"; required.
        at_lock: which outer angle is zero at lock, the "first" or the "third" as written. Lock is where the outer
            angles cannot be told apart from the matrix: |cos β| (|sin β| for equal outer axes) up to 4 × 2⁻⁵².

    Returns:
        Principal triple, other triple and lock mask.

    Raises:
        NotARotation: some matrix is not orthogonal with determinant +1.
        UnknownName: no such sequence, kind of axes or tie-break.
        BadArgument, WrongShape, NotFinite: `axes` missing; R not numbers, not of shape (..., 3, 3), NaN.

    Examples:
        >>> R = nk.rotations.matrix_from_euler([0.1, 0.2, 0.3], "zyx", axes="moving")
        >>> nk.rotations.euler_from_matrix(R, "zyx", axes="moving").angles
        array([0.1, 0.2, 0.3])
        >>> nk.rotations.euler_from_matrix(R, "xyz", axes="fixed").angles
        array([0.3, 0.2, 0.1])
    """
    convention = find_convention(sequence, axes)
    check_at_lock(at_lock)
    kernel = extraction(convention, third_is_zero=(at_lock == "third") != convention.reversed)
    angles, other, locked = evaluate_rotations(kernel, R, (3,), (3,), ())
    return EulerAngles(angles, other, locked.astype(np.bool_))


def matrix_from_rpy(rpy: ArrayLike) -> Floats:
    """Rotation matrix of roll, pitch and yaw, R = Rz(yaw) Ry(pitch) Rx(roll).

    Turns about the fixed axes x, y, z, in this order: the convention of URDF, Pinocchio and NAOqi's Position6D.

    Args:
        rpy: (roll, pitch, yaw), shape (..., 3) [rad].

    Returns:
        Rotation matrices, shape (..., 3, 3).

    Raises:
        BadArgument, WrongShape, NotFinite: not numbers, not of shape (..., 3), NaN or infinity.

    Examples:
        >>> R = nk.rotations.matrix_from_rpy([0.1, 0.2, 0.3])
        >>> np.allclose(R, nk.rotations.rot_z(0.3) @ nk.rotations.rot_y(0.2) @ nk.rotations.rot_x(0.1))
        True
    """
    return matrix_from_euler(rpy, "xyz", axes="fixed")


def rpy_from_matrix(R: ArrayLike, *, at_lock: AtLock = "third") -> Floats:
    """Roll, pitch and yaw of a rotation, R = Rz(yaw) Ry(pitch) Rx(roll), with pitch in [−π/2, π/2].

    The principal solution of `euler_from_matrix(R, "xyz", axes="fixed")`, which also gives the other one.

    Args:
        R: rotation matrices, shape (..., 3, 3).
        at_lock: which angle is zero where pitch = ±π/2: the "first", roll, or the "third", yaw.

    Returns:
        (roll, pitch, yaw), shape (..., 3) [rad].

    Raises:
        NotARotation: some matrix is not orthogonal with determinant +1.
        UnknownName: no such tie-break.
        BadArgument, WrongShape, NotFinite: R not numbers, not of shape (..., 3, 3), NaN or infinity.

    Examples:
        >>> nk.rotations.rpy_from_matrix(nk.rotations.rot_z(0.3) @ nk.rotations.rot_x(0.1))
        array([0.1, 0. , 0.3])
    """
    return euler_from_matrix(R, "xyz", axes="fixed", at_lock=at_lock).angles
