"""The mean of rotations, weighted, with its spread."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats
from nao_kin._common.vectors import common_batch, dot
from nao_kin.errors import BadArgument, UnknownName, WrongShape
from nao_kin.rotations._checks import as_rotations, nearest_rotation
from nao_kin.rotations._exponential import exp, log
from nao_kin.rotations._weights import as_shares

Method = Literal["geodesic", "chordal"]

_MOST_STEPS = 200
# Length of a step that changes nothing but the last digit, and of one that may be rounding [rad].
_LAST_STEP, _SHORT_STEP = 1e-15, 1e-12
# Below 1, so that no step overshoots so far that the sum of squares grows; above, Newton's own.
_LEAST_CURVATURE = 0.55


@dataclass(frozen=True, eq=False)
class MeanRotation:
    """A mean of rotations, and how they scatter about it.

    Attributes:
        rotation: the mean R̄, shape (..., 3, 3).
        spread: root of the weighted mean of the squared angles to the mean, shape (...) [rad].
        covariance: weighted mean of v vᵀ with v = log(R̄ᵀ Rᵢ), in the axes of the mean's frame, shape (..., 3, 3)
            [rad²]; its trace is the spread squared.

    Examples:
        >>> mean = nk.rotations.mean_rotation(nk.rotations.rot_x([0.1, 0.3]))
        >>> mean.spread.round(12), mean.covariance.diagonal()
        (np.float64(0.1), array([0.01, 0.  , 0.  ]))
    """

    rotation: Floats
    spread: Floats
    covariance: Floats


def mean_rotation(R: ArrayLike, weights: ArrayLike | None = None, *, method: Method = "geodesic") -> MeanRotation:
    """The weighted mean of rotations, with its spread.

    geodesic: the R̄ with least Σ wᵢ φᵢ², φᵢ the angle from R̄ to Rᵢ (the Karcher mean). It is the only one where all
    rotations lie within less than 90° of some rotation. Where they scatter wider, there may be several local minima,
    and the one reached from the chordal mean is returned.
    chordal: the R̄ with least Σ wᵢ ‖Rᵢ − R̄‖², the rotation nearest to Σ wᵢ Rᵢ, which is the mean of unit quaternions
    as eigenvector too. It costs less, is the least of all wherever it exists, and is drawn less by what lies far off.
    Of two rotations of one weight both are half way between; of rotations close together they hardly differ.

    Args:
        R: rotation matrices, shape (..., n, 3, 3); the mean is over n ≥ 1.
        weights: shape (..., n), none negative, not all zero; broadcasts with R. Their scale does not matter. Without
            them all rotations count alike.
        method: "geodesic" or "chordal".

    Returns:
        Mean, spread and covariance.

    Raises:
        BadArgument: rotations without a single mean, whose weighted sum has no single nearest rotation (two of them
            half a turn apart, or scattered evenly over all directions); the message has the index. No rotations at all;
            negative weights, or no positive one; not numbers.
        NotARotation: some matrix is not orthogonal with determinant +1; carries its index and its defects.
        UnknownName: no such method.
        WrongShape, NotFinite: wrong or mismatched shapes, NaN or infinity.

    Source: Hartley, Trumpf, Dai and Li, Rotation averaging, IJCV 103, 2013.

    Examples:
        >>> mean = nk.rotations.mean_rotation(nk.rotations.rot_z([0.1, 0.2, 0.6]))
        >>> np.allclose(mean.rotation, nk.rotations.rot_z(0.3))
        True
        >>> mean.spread
        array(0.216)
        >>> heavier = nk.rotations.mean_rotation(nk.rotations.rot_z([0.1, 0.5]), weights=[3, 1])
        >>> np.allclose(heavier.rotation, nk.rotations.rot_z(0.2))
        True
    """
    if not isinstance(method, str) or method not in ("geodesic", "chordal"):
        raise UnknownName("method", method, ("geodesic", "chordal"))
    rotations = as_rotations(R)
    if rotations.ndim < 3:
        raise WrongShape("rotations", "(..., n, 3, 3)", rotations.shape)
    if rotations.shape[-3] == 0:
        raise BadArgument("a mean needs at least one rotation, got none")
    shares = as_shares(weights, rotations.shape[-3])
    batch = common_batch("rotations and weights", rotations.shape[:-2], shares.shape)
    rotations, shares = np.broadcast_to(rotations, (*batch, 3, 3)), np.broadcast_to(shares, batch)
    mean = _chordal(rotations, shares)
    if method == "geodesic":
        mean = _geodesic(mean, rotations, shares)
    arms = _arms(mean, rotations)
    covariance = np.swapaxes(shares[..., np.newaxis] * arms, -1, -2) @ arms
    return MeanRotation(mean, np.asarray(np.sqrt(dot(shares, dot(arms, arms)))), covariance)


def _chordal(rotations: Floats, shares: Floats) -> Floats:
    try:
        return nearest_rotation(np.einsum("...n,...nij->...ij", shares, rotations))
    except BadArgument as error:
        raise BadArgument(f"the rotations have no single mean: of their sum, {error}") from None


def _geodesic(mean: Floats, rotations: Floats, shares: Floats) -> Floats:
    """From `mean` downhill by Newton's steps, with the curvature (φ/2) cot(φ/2) across each arm kept from falling.

    The square of an angle curves by at most 1, also where it has a kink, at π. So with curvatures above ½ a step never
    goes uphill, and no search along it is needed.
    """
    previous = np.inf
    for _ in range(_MOST_STEPS):
        arms = _arms(mean, rotations)
        squares = dot(arms, arms)
        half = 0.5 * np.sqrt(squares)
        across = np.maximum(np.where(half > 0.0, half / np.tan(np.where(half > 0.0, half, 1.0)), 1.0), _LEAST_CURVATURE)
        # Across the arm by `across`, along it by 1.
        along = shares * (1.0 - across) / np.where(squares > 0.0, squares, 1.0)
        curvature = dot(shares, across)[..., np.newaxis, np.newaxis] * np.eye(3)
        curvature = curvature + np.swapaxes(along[..., np.newaxis] * arms, -1, -2) @ arms
        slope = np.einsum("...n,...ni->...i", shares, arms)
        step = np.linalg.solve(curvature, slope[..., np.newaxis])[..., 0]
        mean = mean @ exp(step)
        length = float(np.abs(step).max(initial=0.0))
        if length <= _LAST_STEP or 0.5 * previous <= length <= _SHORT_STEP:
            break
        previous = length
    return nearest_rotation(mean)


def _arms(mean: Floats, rotations: Floats) -> Floats:
    """The rotation vectors from the mean to each rotation, in the mean's frame, shape (..., n, 3)."""
    return log(np.swapaxes(mean, -1, -2)[..., np.newaxis, :, :] @ rotations)
