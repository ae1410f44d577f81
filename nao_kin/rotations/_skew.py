"""Vectors as skew-symmetric matrices: the matrices of the cross product, and back."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats
from nao_kin._common.vectors import as_batch, cross_matrix, first_index
from nao_kin.errors import BadArgument, at_index
from nao_kin.rotations._checks import TOLERANCE


def skew(v: ArrayLike) -> Floats:
    """The matrix [v×] of the cross product, [v×] w = v × w; often written v^ or hat.

    Args:
        v: vectors, shape (..., 3).

    Returns:
        Skew-symmetric matrices [[0, −z, y], [z, 0, −x], [−y, x, 0]], shape (..., 3, 3).

    Raises:
        BadArgument, WrongShape, NotFinite: not numbers, not of shape (..., 3), NaN or infinity.

    Examples:
        >>> nk.rotations.skew([1, 2, 3]).tolist()
        [[0.0, -3.0, 2.0], [3.0, 0.0, -1.0], [-2.0, 1.0, 0.0]]
    """
    # Adding 0.0 turns −0.0 into 0.0.
    return cross_matrix(as_batch(v, (3,), "vector")) + 0.0


def vee(W: ArrayLike) -> Floats:
    """The vector v of a skew-symmetric matrix W = [v×], the inverse of `skew`.

    Of entries that differ by rounding the mean is taken: v = ½ (w32 − w23, w13 − w31, w21 − w12). That of any other
    matrix, vect W, comes from `linear_invariants` for a rotation.

    Args:
        W: skew-symmetric matrices, shape (..., 3, 3).

    Returns:
        Vectors, shape (..., 3).

    Raises:
        BadArgument: some matrix is not skew-symmetric: an entry of W + Wᵀ is above 1e-6 of the largest entry of W;
            the message has its index. Or not numbers.
        WrongShape, NotFinite: not of shape (..., 3, 3), NaN or infinity.

    Examples:
        >>> nk.rotations.vee([[0, -3, 2], [3, 0, -1], [-2, 1, 0]])
        array([1., 2., 3.])
    """
    matrices = as_batch(W, (3, 3), "skew-symmetric matrix")
    half = 0.5 * matrices
    largest = np.abs(half).max(axis=(-2, -1))
    symmetric = np.abs(half + np.swapaxes(half, -1, -2)).max(axis=(-2, -1))
    if (symmetric > TOLERANCE * largest).any():
        index = first_index(np.asarray(symmetric > TOLERANCE * largest))
        raise BadArgument(
            f"matrix{at_index(index)} is not skew-symmetric: largest entry of W + Wᵀ is {2.0 * symmetric[index]:.3g}, "
            f"of W {2.0 * largest[index]:.3g}"
        )
    return np.stack(
        [half[..., 2, 1] - half[..., 1, 2], half[..., 0, 2] - half[..., 2, 0], half[..., 1, 0] - half[..., 0, 1]],
        axis=-1,
    )
