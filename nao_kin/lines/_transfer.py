"""The 6×6 matrices that carry Plücker coordinates from one origin, or one frame, to another."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._arrays import Floats, as_floats
from nao_kin._vectors import as_vectors, common_batch, cross_matrix, first_index
from nao_kin.errors import BadArgument
from nao_kin.rotations import check_rotation


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
    """
    R, t = as_rigid_motion(T_ab, "T_ab")
    X = np.zeros((*t.shape[:-1], 6, 6))
    X[..., :3, :3] = X[..., 3:, 3:] = R
    X[..., 3:, :3] = cross_matrix(t) @ R
    return X


def as_rigid_motion(T: ArrayLike, what: str) -> tuple[Floats, Floats]:
    """The checked rotations (..., 3, 3) and translations (..., 3) of the poses T, shape (..., 4, 4)."""
    poses = as_floats(T, (4, 4), what)
    bad = (poses[..., 3, :] != (0.0, 0.0, 0.0, 1.0)).any(axis=-1)
    if bad.any():
        index = first_index(bad)
        where = f" at index {list(index)}" if index else ""
        raise BadArgument(f"the last row of {what} must be (0, 0, 0, 1), got {poses[index][3].tolist()}{where}")
    R = poses[..., :3, :3]
    check_rotation(R)
    return R, as_vectors(poses[..., :3, 3], f"the translation of {what}")
