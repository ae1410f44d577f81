"""Exponential, logarithm and powers of quaternions, as Hamilton's algebra has them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats
from nao_kin._common.kernels import SMALLEST_NORMAL, Functions, Number, OutOfScale, evaluate, rescaled
from nao_kin._common.vectors import as_batch, common_batch, first_index, largest
from nao_kin.errors import BadArgument, at_index
from nao_kin.rotations._checks import as_exponent
from nao_kin.rotations._quat_kernels import axis_and_half_angle

# e to this is about 1e304.
_LARGEST_SCALAR = 700.0
_LARGEST_VECTOR = 1e139
# Rounding leaves a unit quaternion with a logarithm of its length up to this.
_UNIT = 1e-15


def quat_exp(q: ArrayLike) -> Floats:
    """The exponential of a quaternion, exp(r0, r) = e^r0 (cos ‖r‖, sin ‖r‖ r/‖r‖).

    Of (0, v/2), with v a rotation vector, it is the unit quaternion of that rotation: `quat_exp([0, *v / 2])`.

    Args:
        q: quaternions (r0, r1, r2, r3), shape (..., 4).

    Returns:
        Quaternions, shape (..., 4), of length e^r0; continuous in q, so not of canonical sign.

    Raises:
        BadArgument: not numbers; r0 above 700, whose exponential overflows; r outside ±1e139.
        WrongShape, NotFinite: not of shape (..., 4), NaN or infinity.

    Examples:
        >>> nk.rotations.quat_exp([0.0, 0.0, 0.0, np.pi / 4])  # half of 90° about z
        array([0.7071, 0.    , 0.    , 0.7071])
    """
    quats = as_batch(q, (4,), "quaternion")
    fine = (quats[..., 0] <= _LARGEST_SCALAR) & (largest(quats[..., 1:]) <= _LARGEST_VECTOR)
    if not fine.all():
        index = first_index(np.asarray(~fine))
        raise BadArgument(
            f"quaternion{at_index(index)} is too large for its exponential: {quats[index].tolist()}; "
            f"r0 may be up to {_LARGEST_SCALAR:g}, r up to {_LARGEST_VECTOR:g}"
        )
    found = evaluate(_exponential, [quats[..., 1:]], (4,))[0]
    scalars = quats[..., 0]
    return found if not scalars.any() else np.asarray(found * np.exp(scalars)[..., np.newaxis])


def quat_log(q: ArrayLike) -> Floats:
    """The principal logarithm of a quaternion, log q = (ln ‖q‖, θ r/‖r‖) with θ = atan2(‖r‖, r0) in [0, π].

    For a unit quaternion its vector part is half the rotation vector: axis times φ/2. It follows the quaternion, not
    the rotation: −q has the logarithm of the turn the other way round, by 2π − φ. Take `quat_canonical(q)` for φ ≤ π.

    Args:
        q: quaternions (r0, r1, r2, r3) of any length but zero, shape (..., 4).

    Returns:
        Quaternions, shape (..., 4). Where r = 0 and r0 < 0, which is a whole turn about no axis in particular, the
        vector part is (π, 0, 0).

    Raises:
        ZeroNorm: a zero quaternion; carries its index.
        BadArgument, WrongShape, NotFinite: not numbers, not of shape (..., 4), NaN or infinity.

    Examples:
        >>> half = np.sqrt(0.5)
        >>> 2 * nk.rotations.quat_log([half, 0, 0, half])[1:]  # the rotation vector
        array([0.    , 0.    , 1.5708])
    """
    quats = as_batch(q, (4,), "quaternion")
    try:
        return evaluate(_logarithm, [quats], (4,))[0]
    except OutOfScale:
        found = evaluate(_logarithm, [rescaled(quats, "quaternion")], (4,))[0]
        found[..., 0] += np.log(largest(quats))
        return found


def quat_power(q: ArrayLike, t: ArrayLike) -> Floats:
    """The power qᵗ = exp(t log q) = ‖q‖ᵗ (cos tθ, sin tθ r/‖r‖) with θ = atan2(‖r‖, r0) in [0, π].

    A unit quaternion turns by t times its angle 2θ in [0, 2π], and its power is a unit quaternion: a length within
    1e-15 of 1 counts as 1, for a large exponent would make its rounding large. The power follows the quaternion, not
    the rotation: q and −q have different powers. `power` follows the rotation, by φ ≤ π, and so does
    `quat_power(quat_canonical(q), t)`.

    Args:
        q: quaternions (r0, r1, r2, r3) of any length but zero, shape (..., 4).
        t: exponents, shape (...); broadcasts with q.

    Returns:
        Quaternions, shape (..., 4), with the axis of `quat_log`.

    Raises:
        ZeroNorm: a zero quaternion; carries its index.
        BadArgument: not numbers, t outside ±1e15, or a power so long that it overflows.
        WrongShape, NotFinite: wrong or mismatched shapes, NaN or infinity.

    Examples:
        >>> half = np.sqrt(0.5)
        >>> nk.rotations.quat_power([half, 0, 0, half], 2.0).round(12) + 0.0
        array([0., 0., 0., 1.])
    """
    logarithms, exponents = quat_log(q), as_exponent(t, "exponent")
    common_batch("quaternions and exponents", logarithms.shape[:-1], exponents.shape)
    logarithms[np.abs(logarithms[..., 0]) <= _UNIT, 0] = 0.0
    return quat_exp(exponents[..., np.newaxis] * logarithms)


def _exponential(f: Functions, x: Number, y: Number, z: Number) -> tuple[Number, ...]:
    # The floor keeps 0/0 away; sin θ/θ is 1 to the last digit from θ = 1e-8 down.
    theta = f.larger(f.sqrt(x * x + y * y + z * z), SMALLEST_NORMAL)
    quotient = f.sin(theta) / theta
    return f.cos(theta), quotient * x, quotient * y, quotient * z


def _logarithm(f: Functions, *q: Number) -> tuple[Number, ...]:
    square = f.square(*q)
    x, y, z, theta = axis_and_half_angle(f, *q)
    # Without a vector part θ is 0 or π, and the axis zero: at π it becomes x.
    x = f.where(theta >= math.pi, f.where((y == 0.0) & (z == 0.0) & (x == 0.0), 1.0, x), x)
    return 0.5 * f.log(square), theta * x, theta * y, theta * z
