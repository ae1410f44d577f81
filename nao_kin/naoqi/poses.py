"""Poses as NAOqi writes them: Position6D, six numbers, and transforms, sixteen numbers row by row."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats, as_floats
from nao_kin._common.vectors import as_batch, first_index
from nao_kin.errors import BadArgument, NotARotation, at_index
from nao_kin.rotations import check_rotation, matrix_from_rpy, nearest_rotation, rpy_from_matrix

# A last row that is farther from (0, 0, 0, 1) is no rounding.
_RIGID = 1e-6
# Sixteen numbers that people type or NAOqi sends in single precision are a rotation to within this.
_TYPED = 1e-3


def position6d(T: ArrayLike) -> Floats:
    """Position6D (x, y, z, wx, wy, wz) of poses, with R = Rz(wz) Ry(wy) Rx(wx).

    wy is in [−π/2, π/2]. At wy = ±π/2 only wx ∓ wz is determined, and wz is 0: the pose is still exact.

    Args:
        T: homogeneous matrices, shape (..., 4, 4).

    Returns:
        Shape (..., 6) [m, rad].

    Raises:
        NotARotation, BadArgument: T is no rigid transform.
        WrongShape, NotFinite: not of this shape, NaN or infinity.

    Examples:
        >>> nk.naoqi.position6d(nk.naoqi.pose([0.1, 0.0, 0.2, 0.0, 0.5, 0.0])).tolist()
        [0.1, 0.0, 0.2, 0.0, 0.5, 0.0]
    """
    poses = _rigid(as_batch(T, (4, 4), "T"), "T")
    return np.concatenate([poses[..., :3, 3], rpy_from_matrix(poses[..., :3, :3])], axis=-1)


def pose(position6d: ArrayLike) -> Floats:
    """Homogeneous matrices, shape (..., 4, 4), of Position6D (x, y, z, wx, wy, wz), shape (..., 6) [m, rad].

    Raises:
        WrongShape, NotFinite, BadArgument: not six finite numbers.

    Examples:
        >>> nk.naoqi.pose([0.1, 0.0, 0.2, 0.0, 0.0, 0.0])[:3, 3].tolist()
        [0.1, 0.0, 0.2]
    """
    six = as_batch(position6d, (6,), "position6d")
    T = np.zeros((*six.shape[:-1], 4, 4))
    T[..., :3, :3] = matrix_from_rpy(six[..., 3:])
    T[..., :3, 3] = six[..., :3]
    T[..., 3, 3] = 1.0
    return T


def transform_list(T: ArrayLike) -> Floats:
    """The sixteen numbers of poses row by row, as getTransform gives them.

    Args:
        T: homogeneous matrices, shape (..., 4, 4).

    Returns:
        Shape (..., 16); a copy.

    Raises:
        NotARotation, BadArgument: T is no rigid transform.
        WrongShape, NotFinite: not of this shape, NaN or infinity.

    Examples:
        >>> nk.naoqi.transform_list(np.eye(4)).tolist()[:5]
        [1.0, 0.0, 0.0, 0.0, 0.0]
    """
    poses = _rigid(as_batch(T, (4, 4), "T"), "T")
    return np.array(poses.reshape(*poses.shape[:-2], 16))


def pose_from_list(transform: ArrayLike) -> Floats:
    """Poses of sixteen numbers row by row, or of twelve, the last row left out, as setTransforms takes them.

    What is left of rounding, to single precision or to a few digits, is taken out of the rotation: the nearest one is
    given. So much may be off as would be with three digits.

    Args:
        transform: shape (..., 16) or (..., 12).

    Returns:
        Homogeneous matrices, shape (..., 4, 4).

    Raises:
        NotARotation: the numbers are no rotation by more than 1e-3.
        BadArgument: the last row is not 0, 0, 0, 1.
        WrongShape, NotFinite: not 16 or 12 finite numbers.

    Examples:
        >>> nk.naoqi.pose_from_list(np.eye(4).ravel()).shape
        (4, 4)
    """
    numbers = as_floats(transform, (), "transform")
    count = numbers.shape[-1] if numbers.ndim else 0
    numbers = as_batch(numbers, (12 if count == 12 else 16,), "transform")
    T = np.zeros((*numbers.shape[:-1], 4, 4))
    T[..., 3, 3] = 1.0
    rows = count // 4
    T[..., :rows, :] = numbers.reshape(*numbers.shape[:-1], rows, 4)
    _check_last_row(T, "transform")
    _check_rotation(T, "transform", _TYPED)
    T[..., :3, :3] = nearest_rotation(T[..., :3, :3])
    T[..., 3, :] = 0.0, 0.0, 0.0, 1.0
    return T


def _rigid(T: Floats, what: str) -> Floats:
    _check_last_row(T, what)
    _check_rotation(T, what, None)
    return T


def _check_rotation(T: Floats, what: str, tolerance: float | None) -> None:
    try:
        if tolerance is None:
            check_rotation(T[..., :3, :3])
        else:
            check_rotation(T[..., :3, :3], tolerance)
    except NotARotation as error:
        error.args = (f"{what}: {error}",)
        raise


def _check_last_row(T: Floats, what: str) -> None:
    wrong = np.abs(T[..., 3, :] - np.array([0.0, 0.0, 0.0, 1.0])).sum(axis=-1) > _RIGID
    if wrong.any():
        index = first_index(wrong)
        row = ", ".join(f"{value:.6g}" for value in T[index][3])
        raise BadArgument(f"{what}{at_index(index)} is no rigid transform: its last row is {row}, not 0, 0, 0, 1")
