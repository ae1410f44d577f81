"""The exponential map of rotations and its inverse."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats
from nao_kin._common.vectors import as_batch, first_index
from nao_kin.errors import BadArgument
from nao_kin.rotations._checks import evaluate_rotations
from nao_kin.rotations._elementary import from_rotation_vector
from nao_kin.rotations._kernels import SMALLEST_NORMAL, Functions, Number, OutOfScale, evaluate
from nao_kin.rotations._quaternions import quaternion_of


def exp(v: ArrayLike) -> Floats:
    """Rotation matrix of a rotation vector, exp [v×] = 1 + (sin φ/φ) [v×] + ((1 − cos φ)/φ²) [v×]² with φ = ‖v‖.

    Every entry is right to a few 1e-16 · max(1, φ), for the angle within a turn is what is left of φ's digits: beyond
    φ = 1e16 none. The antisymmetric part is right to a few 1e-16 · φ, down to φ = 0.

    Args:
        v: axis times angle, shape (..., 3) [rad]; any length.

    Returns:
        Rotation matrices, shape (..., 3, 3).

    Raises:
        BadArgument: not numbers, or so long (1e140 rad) that the angle within a turn means nothing.
        WrongShape, NotFinite: not of shape (..., 3), NaN or infinity.

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 2.3.2.
    """
    vectors = as_batch(v, (3,), "rotation vector")
    try:
        return evaluate(from_rotation_vector, [vectors], (3, 3))[0]
    except OutOfScale:
        index = first_index(np.abs(vectors).max(axis=-1) > 1e139)
        where = f" at index {list(index)}" if index else ""
        raise BadArgument(f"rotation vector{where} is longer than 1e140 rad: {vectors[index].tolist()}") from None


def log(R: ArrayLike) -> Floats:
    """Rotation vector of a rotation, axis times angle, with length in [0, π].

    v = r · 2 atan2(‖r‖, r0)/‖r‖ with the quadratic invariants (r, r0), which lose nothing at φ = 0 or φ = π. For
    matrices exact to rounding it is accurate to a few 1e-16 in every component, and near φ = 0 also relative to φ.

    Args:
        R: rotation matrices, shape (..., 3, 3).

    Returns:
        Rotation vectors, shape (..., 3) [rad]; at φ = π, where v and −v give the same rotation, the one whose first
        component that is not zero is positive.

    Raises:
        NotARotation: some matrix is not orthogonal with determinant +1; carries its index and its defects.
        BadArgument, WrongShape, NotFinite: not numbers, not of shape (..., 3, 3), NaN or infinity.

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 2.3.6.
    """
    return evaluate_rotations(_logarithm, R, (3,))[0]


def _logarithm(f: Functions, *m: Number) -> tuple[Number, ...]:
    r0, r1, r2, r3 = quaternion_of(f, *m)
    # The floor keeps 0/0 away; atan2(n, r0)/n is 1 to the last digit from n = 1e-8 down.
    norm = f.larger(f.sqrt(r1 * r1 + r2 * r2 + r3 * r3), SMALLEST_NORMAL)
    quotient = 2.0 * f.atan2(norm, r0) / norm
    return r1 * quotient, r2 * quotient, r3 * quotient
