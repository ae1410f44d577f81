"""Matrices made of lines: what carries Plücker coordinates to another origin or frame, and the geometric Jacobian."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats, as_floats
from nao_kin._common.vectors import as_vectors, common_batch, cross_matrix
from nao_kin._text import quoted
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.lines._line import PluckerLine, as_rigid_motion, check_line


def transfer_matrix(a: ArrayLike, b: ArrayLike) -> Floats:
    """The matrix U with k_b = U k_a for the coordinates (direction; moment) of every line about the origins a and b.

    U = [[1, 0], [A − B, 1]], where A and B are the cross-product matrices of a and b: n_b = n_a + (a − b) × e.

    Args:
        a: the origin the coordinates are about, shape (..., 3) [m].
        b: the origin they are wanted about, shape (..., 3) [m].

    Returns:
        U, shape (..., 6, 6), of determinant 1.

    Raises:
        WrongShape, NotFinite: in either argument.

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 3.2.2.

    Examples:
        >>> line = nk.lines.PluckerLine.through([1, 0, 0], [1, 2, 0])
        >>> nk.lines.transfer_matrix([0, 0, 0], [3, 0, 0]) @ line.coordinates
        array([ 0.,  1.,  0.,  0.,  0., -2.])
    """
    a, b = as_vectors(a, "a"), as_vectors(b, "b")
    batch = common_batch("a and b", a.shape[:-1], b.shape[:-1])
    U = np.zeros((*batch, 6, 6))
    U[...] = np.eye(6)
    U[..., 3:, :3] = cross_matrix(a - b)
    return U


def motion_matrix(T_ab: ArrayLike) -> Floats:
    """The matrix X with k_a = X k_b for the coordinates (direction; moment) of every line about the origins of a and b.

    X = [[R, 0], [t× R, R]] for the pose T_ab = [[R, t], [0, 1]], where t× is the cross-product matrix of t.

    It is the adjoint of SE(3) with its halves exchanged. The adjoint in Pinocchio's order (linear; angular) is
    Ad = [[R, t× R], [0, R]], and a unit turn about a line is the velocity (linear; angular) = (moment; direction), so
    Ad = P X P with P = [[0, 1], [1, 0]]. The same X is the matrix of Pinocchio's `SE3.toDualActionMatrix`, for a force
    along a line has the coordinates (force; moment).

    Args:
        T_ab: pose of frame b in frame a, shape (..., 4, 4).

    Returns:
        X, shape (..., 6, 6), of determinant 1.

    Raises:
        NotARotation: the rotation part of some pose is none.
        BadArgument: the last row of some pose is not (0, 0, 0, 1).
        WrongShape, NotFinite: in `T_ab`.

    Examples:
        >>> line = nk.lines.PluckerLine.through([1, 0, 0], [1, 2, 0])
        >>> nk.lines.motion_matrix(nk.screws.pose(np.eye(3), [0, 0, 0.5])) @ line.coordinates
        array([ 0. ,  1. ,  0. , -0.5,  0. ,  1. ])
    """
    R, t = as_rigid_motion(T_ab, "T_ab")
    X = np.zeros((*t.shape[:-1], 6, 6))
    X[..., :3, :3] = X[..., 3:, 3:] = R
    X[..., 3:, :3] = cross_matrix(t) @ R
    return X


def geometric_jacobian(
    axes: PluckerLine,
    *,
    at: ArrayLike = (0.0, 0.0, 0.0),
    coupling: ArrayLike | None = None,
    sliding: ArrayLike = False,
) -> Floats:
    """The Jacobian of a body behind joints: its columns are the Plücker coordinates of the joint axes.

    Column j is (moment; direction) of axis j about the point `at`: turning at unit speed about that line, the body has
    the angular velocity e_j, and its point `at` the velocity e_j × (at − p_j) = n_j. The order (linear; angular) is
    Pinocchio's; the axes' frame is the frame of the result. A sliding joint has the column (direction; 0), the line at
    infinity about which it turns.

    Args:
        axes: the m axes, batch shape (..., m).
        at: the point of the body whose velocity is asked for, shape (..., 3) [m]: the frame's origin, or the root's.
        coupling: ∂(angle of axis)/∂(coordinate of the robot), shape (m, n). A mimic joint has its multiplier in the
            column of its primary; an axis that does not carry the body has a row of zeros. Left out: the axes are the
            coordinates.
        sliding: which joints are prismatic, shape (m,) or one answer for all.

    Returns:
        J, shape (..., 6, n), with n = m when no coupling is given.

    Raises:
        WrongShape: `axes` is a single line without a joint axis, or the arguments do not fit together.
        BadArgument: `axes` is no `PluckerLine`, or `sliding` holds anything but booleans.
        NotFinite: in `at` or `coupling`.

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 5.2.

    Examples:
        >>> axes = nk.lines.PluckerLine.from_point_direction([[0, 0, 0], [1, 0, 0]], [0, 0, 1])
        >>> nk.lines.geometric_jacobian(axes, at=[2, 0, 0])[:2] + 0.0  # two turns about z carry the hand along y
        array([[0., 0.],
               [2., 1.]])
    """
    check_line(axes, "axes")
    if not axes.batch_shape:
        raise WrongShape("batch axes of axes", "(..., m)", ())
    point = as_vectors(at, "at")
    common_batch("axes and at", axes.batch_shape[:-1], point.shape[:-1])
    seen = axes.transfer_to(point[..., None, :])
    count = axes.batch_shape[-1]
    slides = np.asarray(sliding, dtype=object)
    if not all(isinstance(answer, (bool, np.bool_)) for answer in slides.flat):
        raise BadArgument(f"sliding must be true or false for each joint, got {quoted(sliding)}")
    if slides.shape not in ((), (count,)):
        raise WrongShape("sliding", f"({count},)", slides.shape)
    slides = np.broadcast_to(slides.astype(np.bool_), (count,))[:, None]
    turning = np.concatenate([seen.moment, seen.direction], axis=-1)
    shifting = np.concatenate([seen.direction, np.zeros_like(seen.direction)], axis=-1)
    columns = np.swapaxes(np.where(slides, shifting, turning), -1, -2)
    if coupling is None:
        return columns
    C = as_floats(coupling, (), "coupling")
    if C.ndim != 2 or C.shape[0] != count:
        raise WrongShape("coupling", f"({count}, n)", C.shape)
    return columns @ C
