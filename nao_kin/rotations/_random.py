"""Random rotations: uniform, and near a given one."""

from __future__ import annotations

import operator
from collections.abc import Iterable
from typing import SupportsIndex, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, as_batch, generator, unit
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.rotations._checks import as_rotations
from nao_kin.rotations._exponential import exp
from nao_kin.rotations._quaternions import matrix_from_quat, quat_canonical

Random: TypeAlias = "np.random.Generator | int | None"  # as text, because NumPy takes 15 ms to load its generators
Shape = SupportsIndex | Iterable[SupportsIndex]

# A larger size of one axis is a mistake; NumPy has no arrays of 2^63 entries.
_MOST = 10**15


def random_rotation(rng: Random = None, shape: Shape = ()) -> Floats:
    """Return uniformly distributed random rotations: their distribution is invariant under any fixed rotation.

    Their angle φ has the density (1 − cos φ)/π on [0, π].

    Args:
        rng: a generator, or a seed for one.
        shape: batch shape or number; () for one rotation.

    Returns:
        Rotation matrices, shape `(*shape, 3, 3)`.

    Examples:
        >>> R = nk.rotations.random_rotation(np.random.default_rng(0), 1000)
        >>> bool(nk.rotations.is_rotation(R).all()), bool(np.linalg.norm(R.mean(axis=0)) < 0.1)
        (True, True)
    """
    return matrix_from_quat(_normals(rng, shape, 4))


def random_quat(rng: Random = None, shape: Shape = ()) -> Floats:
    """Return unit quaternions of uniformly distributed rotations, in canonical sign: normalised normal deviates.

    Args:
        rng: a generator, or a seed for one.
        shape: batch shape or number; () for one quaternion.

    Returns:
        Quaternions, shape `(*shape, 4)`.

    Source: Muller, A note on a method for generating points uniformly on n-dimensional spheres, CACM 2(4), 1959.

    Examples:
        >>> nk.rotations.random_quat(1, (2, 5)).shape
        (2, 5, 4)
    """
    return quat_canonical(unit(_normals(rng, shape, 4), "normal numbers")[0])


def random_rotation_near(R: ArrayLike, sigma: ArrayLike, rng: Random = None, shape: Shape = ()) -> Floats:
    """Return random rotations near given ones, R exp(v) with normally distributed v in the axes of the moving frame.

    The components of v are independent, with mean zero and standard deviation σ. For one σ, small against 1 rad, the
    root mean square of the angle to R is √3 σ; angles beyond π wrap.

    Args:
        R: rotation matrices, shape (..., 3, 3), the means.
        sigma: standard deviation about every axis, one number, or about x, y and z, shape (3,), from 0 to 1e100 [rad].
        rng: a generator, or a seed for one.
        shape: number or batch shape of samples for each R.

    Returns:
        Rotation matrices, shape `(..., *shape, 3, 3)`.

    Source: Barfoot, State Estimation for Robotics, 7.3.1.

    Examples:
        >>> R = nk.rotations.rot_z(1.0)
        >>> near = nk.rotations.random_rotation_near(R, 0.01, np.random.default_rng(0), 1000)
        >>> round(float(np.sqrt(np.mean(nk.rotations.angle_between(R, near) ** 2))), 4)
        0.0172
    """
    middle, deviations = as_rotations(R), as_batch(sigma, (), "sigma")
    if deviations.shape not in ((), (3,)):
        raise WrongShape("sigma", "() or (3,)", deviations.shape)
    if not ((deviations >= 0.0) & (deviations <= 1e100)).all():
        raise BadArgument(f"sigma must be from 0 to 1e100 rad, got {deviations.tolist()}")
    sizes = _sizes(shape)
    batch = middle.shape[:-2]
    turns = exp(deviations * generator(rng).standard_normal((*batch, *sizes, 3)))
    return np.asarray(middle.reshape(*batch, *(1,) * len(sizes), 3, 3) @ turns)


def _normals(rng: Random, shape: Shape, count: int) -> Floats:
    return np.asarray(generator(rng).standard_normal((*_sizes(shape), count)))


def _sizes(shape: Shape) -> tuple[int, ...]:
    try:
        sizes = tuple(map(operator.index, shape if isinstance(shape, Iterable) else (shape,)))
    except TypeError:
        raise BadArgument(f"shape must be a whole number or several, got {quoted(shape)}") from None
    if not all(0 <= size < _MOST for size in sizes):
        raise BadArgument(f"shape must have sizes from 0 to {_MOST:g}, got {quoted(sizes)}")
    return sizes
