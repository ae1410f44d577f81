"""Unit quaternions, scalar first: (r0, r1, r2, r3) = (cos φ/2, e sin φ/2), the Euler–Rodrigues parameters."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats
from nao_kin._common.kernels import Functions, Number, OutOfScale, evaluate, rescaled
from nao_kin._common.vectors import as_batch, as_vectors, common_batch, first_index
from nao_kin.errors import ZeroNorm
from nao_kin.rotations._checks import evaluate_rotations
from nao_kin.rotations._elementary import from_quaternion
from nao_kin.rotations._quat_kernels import quaternion_of


def quat_from_matrix(R: ArrayLike) -> Floats:
    """Unit quaternion of a rotation, in canonical sign.

    4 r rᵀ is linear in R; its row with the largest diagonal entry, normalised, is r. No component is ever divided by a
    small one, so each is accurate to a few 1e-16, and for small angles the vector part also relative to its own size.

    Args:
        R: rotation matrices, shape (..., 3, 3).

    Returns:
        Quaternions (r0, r1, r2, r3), shape (..., 4), with r0 > 0, or r0 = 0 and the first other component that is not
        zero positive.

    Raises:
        NotARotation: some matrix is not orthogonal with determinant +1.
        BadArgument, WrongShape, NotFinite: not numbers, not of shape (..., 3, 3), NaN or infinity.

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 2.3.6.

    Examples:
        >>> nk.rotations.quat_from_matrix(nk.rotations.rot_z(np.pi / 2))
        array([0.7071, 0.    , 0.    , 0.7071])
    """
    return evaluate_rotations(quaternion_of, R, (4,))[0]


def matrix_from_quat(q: ArrayLike) -> Floats:
    """Rotation matrix of a quaternion, R = (r0² − r·r) 1 + 2 r rᵀ + 2 r0 [r×] with (r0, r) = q/‖q‖.

    Args:
        q: quaternions (r0, r1, r2, r3) of any length but zero, shape (..., 4).

    Returns:
        Rotation matrices, shape (..., 3, 3).

    Raises:
        ZeroNorm: a zero quaternion; carries its index.
        BadArgument, WrongShape, NotFinite: not numbers, not of shape (..., 4), NaN or infinity.

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 2.3.6.

    Examples:
        >>> nk.rotations.matrix_from_quat([1, 0, 0, 1]).round(12) + 0.0  # 90° about z, of any length
        array([[ 0., -1.,  0.],
               [ 1.,  0.,  0.],
               [ 0.,  0.,  1.]])
    """
    quats = as_batch(q, (4,), "quaternion")
    try:
        return evaluate(from_quaternion, [quats], (3, 3))[0]
    except OutOfScale:
        return evaluate(from_quaternion, [rescaled(quats, "quaternion")], (3, 3))[0]


def quat_multiply(p: ArrayLike, q: ArrayLike) -> Floats:
    """Hamilton's product p q = (p0 q0 − p·q, p0 q + q0 p + p × q): first the rotation q, then p.

    Args:
        p: quaternions, shape (..., 4), of any length.
        q: quaternions, shape (..., 4); broadcasts with p.

    Returns:
        Quaternions, shape (..., 4); ‖p q‖ = ‖p‖ ‖q‖.

    Raises:
        BadArgument, WrongShape, NotFinite: not numbers, outside ±1e150, wrong or mismatched shapes, NaN.

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 2.3.6.

    Examples:
        >>> nk.rotations.quat_multiply([0, 1, 0, 0], [0, 0, 1, 0])  # i j = k
        array([0., 0., 0., 1.])
    """
    P, Q = as_vectors(p, "quaternion p", 4), as_vectors(q, "quaternion q", 4)
    batch = common_batch("quaternions p and q", P.shape[:-1], Q.shape[:-1])
    return evaluate(_product, [np.broadcast_to(side, (*batch, 4)) for side in (P, Q)], (4,))[0]


def quat_conjugate(q: ArrayLike) -> Floats:
    """The conjugate (r0, −r1, −r2, −r3); for a unit quaternion the inverse rotation.

    Args:
        q: quaternions, shape (..., 4).

    Returns:
        Quaternions, shape (..., 4).

    Raises:
        BadArgument, WrongShape, NotFinite: not numbers, not of shape (..., 4), NaN or infinity.

    Examples:
        >>> nk.rotations.quat_conjugate([0.8, 0.6, 0.0, 0.0])
        array([ 0.8, -0.6,  0. ,  0. ])
    """
    return as_batch(q, (4,), "quaternion") * [1.0, -1.0, -1.0, -1.0] + 0.0


def quat_canonical(q: ArrayLike) -> Floats:
    """Of q and −q, which are the same rotation, the one whose first component that is not zero is positive.

    Args:
        q: quaternions, shape (..., 4); their length stays.

    Returns:
        Quaternions, shape (..., 4).

    Raises:
        ZeroNorm: a zero quaternion; carries its index.
        BadArgument, WrongShape, NotFinite: not numbers, not of shape (..., 4), NaN or infinity.

    Examples:
        >>> nk.rotations.quat_canonical([[-0.8, 0.6, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0]])
        array([[ 0.8, -0.6,  0. ,  0. ],
               [ 0. ,  1. ,  0. ,  0. ]])
    """
    quats = as_batch(q, (4,), "quaternion")
    nonzero = quats != 0.0
    if not nonzero.any(axis=-1).all():
        raise ZeroNorm("quaternion", first_index(~nonzero.any(axis=-1)))
    first = np.take_along_axis(quats, nonzero.argmax(axis=-1)[..., np.newaxis], axis=-1)
    return np.where(first < 0.0, -quats, quats) + 0.0


def quat_rotate(q: ArrayLike, v: ArrayLike) -> Floats:
    """The vector turned by a quaternion, q v q⁻¹ = v + r0 t + r × t with t = 2 r × v and (r0, r) = q/‖q‖.

    Args:
        q: quaternions (r0, r1, r2, r3) of any length but zero, shape (..., 4).
        v: vectors, shape (..., 3); broadcasts with q.

    Returns:
        Vectors, shape (..., 3): `matrix_from_quat(q) @ v`.

    Raises:
        ZeroNorm: a zero quaternion; carries its index.
        BadArgument, WrongShape, NotFinite: not numbers, v outside ±1e150, wrong or mismatched shapes, NaN or infinity.

    Examples:
        >>> half = np.sqrt(0.5)
        >>> nk.rotations.quat_rotate([half, 0, 0, half], [1.0, 0.0, 2.0])  # 90° about z
        array([0., 1., 2.])
    """
    quats, vectors = as_batch(q, (4,), "quaternion"), as_vectors(v, "vector")
    batch = common_batch("quaternions and vectors", quats.shape[:-1], vectors.shape[:-1])
    vectors = np.broadcast_to(vectors, (*batch, 3))
    try:
        return evaluate(_rotated, [np.broadcast_to(quats, (*batch, 4)), vectors], (3,))[0]
    except OutOfScale:
        sized = np.broadcast_to(rescaled(quats, "quaternion"), (*batch, 4))
        return evaluate(_rotated, [sized, vectors], (3,))[0]


def quat_to_xyzw(q: ArrayLike) -> Floats:
    """(r0, r1, r2, r3) → (r1, r2, r3, r0): the order of Pinocchio's and Eigen's `coeffs()`, scipy and ROS.

    Args:
        q: quaternions, scalar first, shape (..., 4).

    Returns:
        Quaternions, scalar last, shape (..., 4).

    Raises:
        BadArgument, WrongShape, NotFinite: not numbers, not of shape (..., 4), NaN or infinity.

    Examples:
        >>> nk.rotations.quat_to_xyzw([1, 2, 3, 4])
        array([2., 3., 4., 1.])
    """
    return as_batch(q, (4,), "quaternion")[..., [1, 2, 3, 0]]


def quat_from_xyzw(xyzw: ArrayLike) -> Floats:
    """(x, y, z, w) → (w, x, y, z): from the order of Pinocchio's and Eigen's `coeffs()`, scipy and ROS.

    Args:
        xyzw: quaternions, scalar last, shape (..., 4).

    Returns:
        Quaternions, scalar first, shape (..., 4).

    Raises:
        BadArgument, WrongShape, NotFinite: not numbers, not of shape (..., 4), NaN or infinity.

    Examples:
        >>> nk.rotations.quat_from_xyzw([2, 3, 4, 1])
        array([1., 2., 3., 4.])
    """
    return as_batch(xyzw, (4,), "quaternion xyzw")[..., [3, 0, 1, 2]]


def _rotated(f: Functions, *components: Number) -> tuple[Number, ...]:
    r0, r1, r2, r3, x, y, z = components
    scale = 2.0 / f.square(r0, r1, r2, r3)
    tx, ty, tz = scale * (r2 * z - r3 * y), scale * (r3 * x - r1 * z), scale * (r1 * y - r2 * x)
    return (
        x + r0 * tx + (r2 * tz - r3 * ty),
        y + r0 * ty + (r3 * tx - r1 * tz),
        z + r0 * tz + (r1 * ty - r2 * tx),
    )


def _product(f: Functions, *components: Number) -> tuple[Number, ...]:
    p0, p1, p2, p3, q0, q1, q2, q3 = components
    return (
        p0 * q0 - (p1 * q1 + p2 * q2 + p3 * q3),
        p0 * q1 + q0 * p1 + (p2 * q3 - p3 * q2),
        p0 * q2 + q0 * p2 + (p3 * q1 - p1 * q3),
        p0 * q3 + q0 * p3 + (p1 * q2 - p2 * q1),
    )
