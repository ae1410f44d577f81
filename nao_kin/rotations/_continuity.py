"""Of q and −q, which are one rotation, the one that goes on without a jump."""

from __future__ import annotations

import operator
from typing import SupportsIndex

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats
from nao_kin._common.kernels import rescaled
from nao_kin._common.vectors import as_batch, common_batch, dot
from nao_kin.errors import BadArgument


def quat_nearest(q: ArrayLike, reference: ArrayLike) -> Floats:
    """Of q and −q, which are the same rotation, the one nearer to a reference: with q · reference ≥ 0.

    Args:
        q: quaternions, shape (..., 4); their length stays.
        reference: quaternions, shape (..., 4), of any length but zero; broadcasts with q.

    Returns:
        Quaternions, shape (..., 4); q as given where both are equally near, half a turn from the reference.

    Raises:
        ZeroNorm: a zero quaternion; carries its index.
        BadArgument, WrongShape, NotFinite: not numbers, wrong or mismatched shapes, NaN or infinity.

    Examples:
        >>> nk.rotations.quat_nearest([-0.8, 0.0, 0.0, -0.6], [1, 0, 0, 0])
        array([0.8, 0. , 0. , 0.6])
    """
    quats, references = as_batch(q, (4,), "quaternion"), as_batch(reference, (4,), "reference")
    common_batch("quaternions and references", quats.shape[:-1], references.shape[:-1])
    inner = dot(rescaled(quats, "quaternion"), rescaled(references, "reference"))
    return np.where(inner[..., np.newaxis] < 0.0, -quats, quats) + 0.0


def quat_unwrap(q: ArrayLike, *, axis: SupportsIndex = -2) -> Floats:
    """Quaternions along a path with their signs chosen so that none jumps: each has q · previous ≥ 0; the first stays.

    Rotations themselves do not change. Steps of less than half a turn are told right; at exactly half a turn, where
    both signs are equally near, the sign relative to the one before stays as given.

    Args:
        q: quaternions, shape (..., n, 4); their length stays.
        axis: the axis of q along which the path runs; by default the last but one.

    Returns:
        Quaternions, of the shape of q.

    Raises:
        ZeroNorm: a zero quaternion; carries its index.
        BadArgument: an axis that q does not have, or the one of its components; not numbers.
        WrongShape, NotFinite: not of shape (..., 4), NaN or infinity.

    Examples:
        >>> q = [[1.0, 0.0, 0.0, 0.0], [-0.96, 0.0, 0.0, -0.28], [0.8, 0.0, 0.0, 0.6]]
        >>> nk.rotations.quat_unwrap(q)[:, 0].tolist()
        [1.0, 0.96, 0.8]
    """
    quats = as_batch(q, (4,), "quaternion")
    along = _path_axis(axis, quats.ndim)
    if not quats.size:
        return np.array(quats)
    path = np.moveaxis(rescaled(quats, "quaternion"), along, 0)
    flips = np.ones(path.shape[:-1])
    flips[1:] = np.where(dot(path[1:], path[:-1]) < 0.0, -1.0, 1.0)
    signs = np.moveaxis(np.cumprod(flips, axis=0), 0, along)
    return np.asarray(quats * signs[..., np.newaxis] + 0.0)


def _path_axis(axis: SupportsIndex, ndim: int) -> int:
    try:
        along = operator.index(axis)
    except TypeError:
        along = ndim
    if along < 0:
        along += ndim
    if not 0 <= along < ndim - 1:
        raise BadArgument(
            f"axis must be one of the {ndim - 1} before the components, from {-ndim} to −2 or from 0, got {axis}"
        )
    return along
