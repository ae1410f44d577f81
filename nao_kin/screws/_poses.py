"""Rigid motions as 4 × 4 matrices: made, inverted, composed, applied to points, repaired."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats
from nao_kin._common.poses import join_poses, split_poses
from nao_kin._common.vectors import as_batch, as_vectors, common_batch, first_index, rigid_inverse
from nao_kin.errors import BadArgument, at_index
from nao_kin.rotations import check_rotation, nearest_rotation

# How far the last row may be from (0, 0, 0, 1) in a matrix that is meant as a pose.
_LAST_ROW = 1e-3


def pose(R_ab: ArrayLike, p: ArrayLike) -> Floats:
    """The pose T_ab = [[R_ab, p], [0, 1]] of frame b in frame a.

    Args:
        R_ab: rotation matrices, shape (..., 3, 3).
        p: the origin of b in a, shape (..., 3) [m]; batch axes broadcast.

    Returns:
        Poses, shape (..., 4, 4).

    Raises:
        NotARotation: some matrix is not orthogonal with determinant +1; carries its index and its defects.
        BadArgument, WrongShape, NotFinite: not numbers, wrong or mismatched shapes, NaN or infinity.

    Examples:
        >>> nk.screws.pose(nk.rotations.rot_z(np.pi / 2), [1, 2, 3])
        array([[ 0., -1.,  0.,  1.],
               [ 1.,  0.,  0.,  2.],
               [ 0.,  0.,  1.,  3.],
               [ 0.,  0.,  0.,  1.]])
    """
    rotations = as_batch(R_ab, (3, 3), "R_ab")
    check_rotation(rotations)
    return join_poses(rotations, as_vectors(p, "p"))


def inverse(T_ab: ArrayLike) -> Floats:
    """The inverse T_ba = [[Rᵀ, −Rᵀ p], [0, 1]], the pose of frame a in frame b.

    Args:
        T_ab: poses [[R, p], [0, 1]], shape (..., 4, 4).

    Returns:
        Poses, shape (..., 4, 4).

    Raises:
        NotARotation: the rotation part of some pose is none.
        BadArgument: the last row of some pose is not (0, 0, 0, 1).
        WrongShape, NotFinite: in `T_ab`.

    Examples:
        >>> T_ab = nk.screws.pose(nk.rotations.rot_z(np.pi / 2), [1, 2, 3])
        >>> nk.screws.inverse(T_ab)[:3, 3]
        array([-2.,  1., -3.])
    """
    R, p = as_poses(T_ab, "T_ab")
    return rigid_inverse(join_poses(R, p))


def compose(*poses: ArrayLike) -> Floats:
    """The product of poses, T_ad = T_ab T_bc T_cd.

    Args:
        poses: one or more, each of shape (..., 4, 4); batch axes broadcast.

    Returns:
        Poses, shape (..., 4, 4). A product of very many is a rotation only up to its rounding: `nearest_pose`.

    Raises:
        NotARotation: the rotation part of some pose is none.
        BadArgument: no pose at all; or the last row of some pose is not (0, 0, 0, 1).
        WrongShape, NotFinite: wrong or mismatched shapes, NaN or infinity.

    Examples:
        >>> T_ab = nk.screws.pose(nk.rotations.rot_z(np.pi / 2), [1, 0, 0])
        >>> nk.screws.compose(T_ab, T_ab)[:3, 3]
        array([1., 1., 0.])
    """
    if not poses:
        raise BadArgument("compose needs at least one pose")
    (R, p), *others = (as_poses(T, f"pose {i}") for i, T in enumerate(poses, 1))
    common_batch("the poses", p.shape[:-1], *(q.shape[:-1] for _, q in others))
    for S, q in others:
        p = p + turned(R, q)
        R = R @ S
    return join_poses(R, p)


def transform_point(T_ab: ArrayLike, p_b: ArrayLike) -> Floats:
    """A point given in frame b, in the coordinates of frame a; or a point of a, carried along: R p + t.

    Args:
        T_ab: poses [[R, t], [0, 1]], shape (..., 4, 4).
        p_b: points, shape (..., 3) [m]; batch axes broadcast.

    Returns:
        Points, shape (..., 3) [m].

    Raises:
        NotARotation: the rotation part of some pose is none.
        BadArgument: the last row of some pose is not (0, 0, 0, 1).
        WrongShape, NotFinite: wrong or mismatched shapes, NaN or infinity.

    Examples:
        >>> T_ab = nk.screws.pose(nk.rotations.rot_z(np.pi / 2), [1, 2, 3])
        >>> nk.screws.transform_point(T_ab, [[1, 0, 0], [0, 0, 1]])
        array([[1., 3., 3.],
               [1., 2., 4.]])
    """
    (R, t), points = as_poses(T_ab, "T_ab"), as_vectors(p_b, "p_b")
    common_batch("T_ab and p_b", t.shape[:-1], points.shape[:-1])
    return turned(R, points) + t


def nearest_pose(M: ArrayLike) -> Floats:
    """The rigid motion nearest to a 4 × 4 matrix in the Frobenius norm: the nearest rotation, the same translation.

    The entries of R and p stand in different places of the matrix, so that no choice of a unit of length matters.

    Args:
        M: matrices, shape (..., 4, 4), for instance products of many poses, or poses measured or typed.

    Returns:
        Poses, shape (..., 4, 4), with the last row (0, 0, 0, 1).

    Raises:
        BadArgument: a last row farther than 1e-3 from (0, 0, 0, 1) in some entry, as of a transposed pose; or a matrix
            that has no single nearest rotation, as `nearest_rotation` says.
        WrongShape, NotFinite: not of shape (..., 4, 4), NaN or infinity.

    Examples:
        >>> typed = [[0.707, -0.707, 0, 0.1], [0.707, 0.707, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
        >>> nk.screws.nearest_pose(typed)[0]
        array([ 0.7071, -0.7071,  0.    ,  0.1   ])
    """
    matrices = as_batch(M, (4, 4), "matrix")
    far = np.abs(matrices[..., 3, :] - [0.0, 0.0, 0.0, 1.0]).max(axis=-1) > _LAST_ROW
    if far.any():
        index = first_index(far)
        raise BadArgument(
            f"the last row of the matrix{at_index(index)} must be (0, 0, 0, 1) to {_LAST_ROW:.0e}, "
            f"got {matrices[index][3].tolist()}"
        )
    return join_poses(nearest_rotation(matrices[..., :3, :3]), as_vectors(matrices[..., :3, 3], "the translation"))


def as_poses(T: ArrayLike, what: str) -> tuple[Floats, Floats]:
    """The checked rotations (..., 3, 3) and translations (..., 3) of the poses T, shape (..., 4, 4)."""
    R, t = split_poses(T, what)
    check_rotation(R)
    return R, t


def as_twists(value: ArrayLike, what: str = "twist") -> tuple[Floats, Floats]:
    """The linear and the angular part of twists, or force and moment of wrenches, shape (..., 6)."""
    six = as_vectors(value, what, 6)
    return six[..., :3], six[..., 3:]


def turned(R: Floats, v: Floats) -> Floats:
    """R v."""
    return np.asarray(np.einsum("...ij,...j->...i", R, v))
