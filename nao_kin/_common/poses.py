"""Poses [[R, t], [0, 1]] taken apart and put together; whether R is a rotation is for `nao_kin.rotations` to say."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats
from nao_kin._common.vectors import as_batch, as_vectors, common_batch, first_index
from nao_kin.errors import BadArgument, at_index

_LAST_ROW = (0.0, 0.0, 0.0, 1.0)


def split_poses(T: ArrayLike, what: str) -> tuple[Floats, Floats]:
    """The matrices R, shape (..., 3, 3), and the translations t, shape (..., 3), of poses, shape (..., 4, 4).

    Raises:
        BadArgument: the last row of some pose is not (0, 0, 0, 1); or not numbers, or a translation outside ±1e150.
        WrongShape, NotFinite: not of shape (..., 4, 4), NaN or infinity.
    """
    poses = as_batch(T, (4, 4), what)
    bad = (poses[..., 3, :] != _LAST_ROW).any(axis=-1)
    if bad.any():
        index = first_index(bad)
        raise BadArgument(
            f"the last row of {what} must be (0, 0, 0, 1), got {poses[index][3].tolist()}{at_index(index)}"
        )
    return poses[..., :3, :3], as_vectors(poses[..., :3, 3], f"the translation of {what}")


def join_poses(R: Floats, t: Floats) -> Floats:
    """The poses [[R, t], [0, 1]], shape (..., 4, 4), of matrices (..., 3, 3) and translations (..., 3)."""
    T = np.empty((*common_batch("rotations and translations", R.shape[:-2], t.shape[:-1]), 4, 4))
    T[..., :3, :3], T[..., :3, 3], T[..., 3, :] = R, t, _LAST_ROW
    return T
