"""Unit dual quaternions r + ε d: eight numbers (r; d), scalar first, with rotation r and translation t in d = ½ t r.

q and −q are the same motion. Dual quaternions of any non-zero length are accepted, and divided by the length of r; for
a unit one r·d = 0.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from nao_kin import rotations
from nao_kin._core.arrays import Floats, as_vectors, common_batch, dot, first_index, join_poses, norm, unit
from nao_kin.errors import BadArgument, at_index
from nao_kin.screws.lines import PluckerLine
from nao_kin.screws.lines._line import as_poses, check_line

# As for rotation matrices, rounding to float32 is accepted.
_TOLERANCE = 1e-6


def dual_quat_from_pose(T_ab: ArrayLike) -> Floats:
    """Unit dual quaternion of a pose, r + ε ½ t r, with the canonical sign of r.

    Args:
        T_ab: poses [[R, t], [0, 1]], shape (..., 4, 4).

    Returns:
        (r; d), shape (..., 8), with d in units of length.

    Source: Kavan, Collins, O'Sullivan and Zara, Dual quaternions for rigid transformation blending, TCD-CS-2006-46.

    Examples:
        >>> nk.screws.dual_quat_from_pose(nk.screws.pose(nk.rotations.rot_x(np.pi), [0, 0, 2]))
        array([0., 1., 0., 0., 0., 0., 1., 0.])
    """
    R, t = as_poses(T_ab, "T_ab")
    r = rotations.quat_from_matrix(R)
    return np.concatenate([r, rotations.quat_multiply(_pure(0.5 * t), r) + 0.0], axis=-1)


def pose_from_dual_quat(q: ArrayLike) -> Floats:
    """The pose of a dual quaternion, R of r and t = 2 d r*, both divided by ‖r‖².

    Args:
        q: (r; d), shape (..., 8), of any length but zero.

    Returns:
        Poses, shape (..., 4, 4).

    Raises:
        BadArgument: r·d is not zero to 1e-6: q is not a rigid motion.

    Examples:
        >>> nk.screws.pose_from_dual_quat([0, 1, 0, 0, 0, 0, 1, 0])[:3, 3]
        array([0., 0., 2.])
    """
    r, d = _unit(q, "dual quaternion")
    t = 2.0 * rotations.quat_multiply(d, rotations.quat_conjugate(r))[..., 1:]
    return join_poses(rotations.matrix_from_quat(r), t)


def dual_quat_multiply(p: ArrayLike, q: ArrayLike) -> Floats:
    """The product p q = (r_p r_q; r_p d_q + d_p r_q): first the motion q, then p.

    Args:
        p: dual quaternions, shape (..., 8), of any length.
        q: dual quaternions; batch axes broadcast.

    Returns:
        Dual quaternions, shape (..., 8).

    Examples:
        >>> half = nk.screws.dual_quat_from_pose(nk.screws.pose(np.eye(3), [0, 0, 1]))
        >>> nk.screws.pose_from_dual_quat(nk.screws.dual_quat_multiply(half, half))[:3, 3]
        array([0., 0., 2.])
    """
    P, Q = as_vectors(p, "dual quaternion p", 8), as_vectors(q, "dual quaternion q", 8)
    common_batch("dual quaternions p and q", P.shape[:-1], Q.shape[:-1])
    multiply = rotations.quat_multiply
    real = multiply(P[..., :4], Q[..., :4])
    return np.concatenate([real, multiply(P[..., :4], Q[..., 4:]) + multiply(P[..., 4:], Q[..., :4])], axis=-1)


def dual_quat_conjugate(q: ArrayLike) -> Floats:
    """The conjugate (r*; d*); for a unit dual quaternion the inverse motion.

    Args:
        q: dual quaternions, shape (..., 8).

    Returns:
        Dual quaternions, shape (..., 8).

    Examples:
        >>> nk.screws.dual_quat_conjugate([0, 1, 0, 0, 0, 0, 1, 0])
        array([ 0., -1.,  0.,  0.,  0.,  0., -1.,  0.])
    """
    Q = as_vectors(q, "dual quaternion", 8)
    return np.concatenate([rotations.quat_conjugate(Q[..., :4]), rotations.quat_conjugate(Q[..., 4:])], axis=-1)


def dual_quat_transform_point(q: ArrayLike, point: ArrayLike) -> Floats:
    """A point moved by the motion q: the vector part of r p r* + 2 d r*, for ‖r‖ = 1.

    Args:
        q: dual quaternions, shape (..., 8), of any length but zero.
        point: shape (..., 3) [m]; batch axes broadcast.

    Returns:
        Points, shape (..., 3) [m].

    Examples:
        >>> nk.screws.dual_quat_transform_point([0, 1, 0, 0, 0, 0, 1, 0], [1, 2, 3]) + 0.0
        array([ 1., -2., -1.])
    """
    (r, d), p = _unit(q, "dual quaternion"), as_vectors(point, "point")
    common_batch("dual quaternion and point", r.shape[:-1], p.shape[:-1])
    multiply = rotations.quat_multiply
    return multiply(multiply(r, _pure(p)) + 2.0 * d, rotations.quat_conjugate(r))[..., 1:]


def dual_quat_transform_line(q: ArrayLike, line: PluckerLine) -> PluckerLine:
    """A line moved by the motion q: q (e + ε n) q*, with direction e and moment n about the origin.

    Args:
        q: dual quaternions, shape (..., 8), of any length but zero.
        line: lines; batch axes broadcast.

    Returns:
        Lines with their moments about the origin of coordinates, whatever the origin of `line` is.

    Examples:
        >>> x_axis = nk.lines.PluckerLine.through([0, 0, 0], [1, 0, 0])
        >>> nk.screws.dual_quat_transform_line([0, 1, 0, 0, 0, 0, 1, 0], x_axis).point
        array([0., 0., 2.])
    """
    check_line(line, "line")
    r, d = _unit(q, "dual quaternion")
    common_batch("dual quaternion and line", r.shape[:-1], line.batch_shape)
    seen = line.transfer_to((0.0, 0.0, 0.0))
    motion = np.concatenate([r, d], axis=-1)
    dual_vector = np.concatenate([_pure(seen.direction), _pure(seen.moment)], axis=-1)
    moved = dual_quat_multiply(dual_quat_multiply(motion, dual_vector), dual_quat_conjugate(motion))
    return PluckerLine(moved[..., 1:4], moved[..., 5:])


def _pure(v: Floats) -> Floats:
    """The quaternions (0, v)."""
    return np.concatenate([np.zeros((*v.shape[:-1], 1)), v], axis=-1)


def _unit(q: ArrayLike, what: str) -> tuple[Floats, Floats]:
    """Return real and dual part, divided by the length of the real part; refuse anything but rigid motions."""
    Q = as_vectors(q, what, 8)
    r, length = unit(Q[..., :4], what)
    d = Q[..., 4:] / length[..., None]
    product = dot(r, d)
    wrong = ~(np.abs(product) <= _TOLERANCE * np.maximum(1.0, norm(d)))
    if wrong.any():
        index = first_index(wrong)
        raise BadArgument(f"r·d of a unit {what} must be zero, got {product[index]:.3g}{at_index(index)}")
    return r, d - product[..., None] * r
