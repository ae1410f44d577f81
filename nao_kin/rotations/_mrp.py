"""Modified Rodrigues parameters: three numbers for a rotation, regular up to a whole turn."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats
from nao_kin._common.kernels import LARGEST_SQUARE, Functions, Number, OutOfScale, evaluate, rescaled
from nao_kin._common.vectors import as_batch, first_index, largest
from nao_kin.errors import BadArgument, at_index
from nao_kin.rotations._checks import evaluate_rotations
from nao_kin.rotations._elementary import rodrigues
from nao_kin.rotations._quat_kernels import quaternion_of


def mrp_from_matrix(R: ArrayLike) -> Floats:
    """Modified Rodrigues parameters of a rotation, p = e tan(φ/4) = r/(1 + r0), with φ ≤ π and so ‖p‖ ≤ 1.

    `mrp_shadow` gives the other triple of the same rotation, ‖p‖ ≥ 1.

    Args:
        R: rotation matrices, shape (..., 3, 3).

    Returns:
        Parameters, shape (..., 3). At φ = π, where p and −p are the same rotation, the one whose first component that
        is not zero is positive.

    Raises:
        NotARotation: some matrix is not orthogonal with determinant +1; carries its index and its defects.
        BadArgument, WrongShape, NotFinite: not numbers, not of shape (..., 3, 3), NaN or infinity.

    Source: Schaub and Junkins, Stereographic orientation parameters, J. Astronautical Sciences 44(1), 1996.

    Examples:
        >>> nk.rotations.mrp_from_matrix(nk.rotations.rot_z(np.pi / 2))  # tan 22.5°
        array([0.    , 0.    , 0.4142])
    """
    return evaluate_rotations(_parameters, R, (3,))[0]


def matrix_from_mrp(p: ArrayLike) -> Floats:
    """Rotation matrix of modified Rodrigues parameters, R = 1 + (8 [p×]² + 4 (1 − p²) [p×])/(1 + p²)².

    Args:
        p: e tan(φ/4), shape (..., 3), of any length: both triples of a rotation give the same matrix.

    Returns:
        Rotation matrices, shape (..., 3, 3).

    Raises:
        BadArgument, WrongShape, NotFinite: not numbers, not of shape (..., 3), NaN or infinity.

    Source: Schaub and Junkins, Stereographic orientation parameters, J. Astronautical Sciences 44(1), 1996.

    Examples:
        >>> R = nk.rotations.matrix_from_mrp([0.0, 0.0, np.tan(0.3 / 4)])
        >>> np.allclose(R, nk.rotations.rot_z(0.3))
        True
    """
    parameters = as_batch(p, (3,), "modified Rodrigues parameters")
    try:
        return evaluate(_matrix, [parameters], (3, 3))[0]
    except OutOfScale:
        # The other triple of a long one is short.
        long = (largest(parameters) > 1.0)[..., np.newaxis]
        short = np.where(long, _shadow(np.where(long, parameters, 1.0)), parameters)
        return evaluate(_matrix, [short], (3, 3))[0]


def mrp_shadow(p: ArrayLike) -> Floats:
    """The other triple of the same rotation, −p/‖p‖²: −e tan((2π − φ)/4), the turn the other way round.

    Where one triple grows beyond all bounds, towards φ = 2π, the other is near zero: change at ‖p‖ = 1, and both stay
    within 1.

    Args:
        p: modified Rodrigues parameters, shape (..., 3).

    Returns:
        Parameters, shape (..., 3).

    Raises:
        ZeroNorm: p = 0, the identity, whose other triple is infinite; carries its index.
        BadArgument: p so short that the other triple overflows; or not numbers.
        WrongShape, NotFinite: not of shape (..., 3), NaN or infinity.

    Source: Schaub and Junkins, Stereographic orientation parameters, J. Astronautical Sciences 44(1), 1996.

    Examples:
        >>> nk.rotations.mrp_shadow([0.0, 0.0, 0.5])
        array([ 0.,  0., -2.])
    """
    parameters = as_batch(p, (3,), "modified Rodrigues parameters")
    with np.errstate(over="ignore"):
        found = _shadow(parameters)
    finite = np.asarray(np.isfinite(found).all(axis=-1))
    if not finite.all():
        index = first_index(~finite)
        raise BadArgument(f"the other triple of parameters{at_index(index)} overflows: {parameters[index].tolist()}")
    return found


def _shadow(p: Floats) -> Floats:
    direction = rescaled(p, "modified Rodrigues parameters")
    square = np.square(direction).sum(axis=-1, keepdims=True)
    return np.asarray(-(direction / square) / largest(p)[..., np.newaxis] + 0.0)


def _parameters(f: Functions, *m: Number) -> tuple[Number, ...]:
    r0, r1, r2, r3 = quaternion_of(f, *m)
    divisor = 1.0 + r0
    return r1 / divisor, r2 / divisor, r3 / divisor


def _matrix(f: Functions, x: Number, y: Number, z: Number) -> tuple[Number, ...]:
    square = x * x + y * y + z * z
    if not f.within(square, LARGEST_SQUARE):
        raise OutOfScale
    quotient = 1.0 / (1.0 + square)
    return rodrigues(x, y, z, 4.0 * quotient * (1.0 - square) * quotient, 8.0 * quotient * quotient)
