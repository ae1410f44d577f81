"""Rotations as exponentials: exp, log, powers, angles between rotations, Jacobians of SO(3), random rotations."""

from __future__ import annotations

from collections.abc import Iterable
from typing import SupportsIndex, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, as_floats, common_batch, first_index, generator
from nao_kin._core.kernels import (
    SMALLEST_NORMAL,
    WHOLE_TURN,
    Functions,
    Kernel,
    Number,
    evaluate,
    inverse_coefficients,
    jacobian_coefficients,
)
from nao_kin.errors import BadArgument, SingularMatrix, WrongShape
from nao_kin.rotations._checks import as_rotations, evaluate_rotations, evaluate_vectors
from nao_kin.rotations._elementary import from_rotation_vector, rodrigues
from nao_kin.rotations._quaternions import axis_and_half_angle, matrix_from_quat, quaternion_of


def exp(v: ArrayLike) -> Floats:
    """Rotation matrix of a rotation vector, exp [v×] = 1 + (sin φ/φ) [v×] + ((1 − cos φ)/φ²) [v×]² with φ = ‖v‖.

    Every entry is accurate to a few 1e-16 · max(1, φ), the antisymmetric part to a few 1e-16 · φ, down to φ = 0.

    Args:
        v: axis times angle, shape (..., 3) [rad].

    Returns:
        Rotation matrices, shape (..., 3, 3).

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 2.3.2.

    Examples:
        >>> nk.rotations.exp([0.0, 0.0, np.pi / 2])[0].round(12) + 0.0
        array([ 0., -1.,  0.])
    """
    return evaluate_vectors(from_rotation_vector, v, (3, 3))[0]


def log(R: ArrayLike) -> Floats:
    """Rotation vector of a rotation, axis times angle, with length in [0, π].

    v = r · 2 atan2(‖r‖, r0)/‖r‖ with the quadratic invariants (r, r0), which are accurate at φ = 0 and φ = π. For
    matrices exact to rounding it is accurate to a few 1e-16 in every component, and near φ = 0 also relative to φ.

    Args:
        R: rotation matrices, shape (..., 3, 3).

    Returns:
        Rotation vectors, shape (..., 3) [rad]; at φ = π the first non-zero component is positive.

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 2.3.6.

    Examples:
        >>> nk.rotations.log([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
        array([0.    , 0.    , 1.5708])
    """
    return evaluate_rotations(_logarithm, R, (3,))[0]


def power(R: ArrayLike, t: ArrayLike) -> Floats:
    """The power Rᵗ = exp(t log R): the rotation about the axis of R by t times its angle, which is at most π.

    Whole powers are products of R; R⁻¹ = Rᵀ. At φ = π the axis is that of `log`, which selects one of the two square
    roots.

    Args:
        R: rotation matrices, shape (..., 3, 3).
        t: exponents, shape (...); broadcasts with R.

    Returns:
        Rotation matrices, shape (..., 3, 3), accurate to a few 1e-16 · max(1, |t|).

    Examples:
        >>> np.allclose(nk.rotations.power(nk.rotations.rot_z(0.6), -0.5), nk.rotations.rot_z(-0.3))
        True
    """
    vectors, exponents = log(R), as_floats(t, (), "exponent")
    common_batch("R and t", vectors.shape[:-1], exponents.shape)
    return exp(exponents[..., np.newaxis] * vectors)


def angle_between(A: ArrayLike, B: ArrayLike) -> Floats:
    """The angle of Aᵀ B, which is also that of A Bᵀ; accurate at 0 and at π.

    Args:
        A: rotation matrices, shape (..., 3, 3).
        B: rotation matrices, shape (..., 3, 3); broadcasts with A.

    Returns:
        Angles, shape (...), in [0, π] [rad]; accurate to a few 1e-16 for matrices exact to rounding.

    Examples:
        >>> nk.rotations.angle_between(nk.rotations.rot_x(0.1), nk.rotations.rot_x(0.5))
        array(0.4)
    """
    first, second = as_rotations(A), as_rotations(B)
    batch = common_batch("rotations A and B", first.shape[:-2], second.shape[:-2])
    sides = [np.broadcast_to(side.reshape(*side.shape[:-2], 9), (*batch, 9)) for side in (first, second)]
    return evaluate(_angle_of_quotient, sides, ())[0]


def _logarithm(f: Functions, *m: Number) -> tuple[Number, ...]:
    r0, r1, r2, r3 = quaternion_of(f, *m)
    # The floor avoids 0/0; atan2(n, r0)/n is 1 to the last digit below n = 1e-8.
    norm = f.larger(f.sqrt(r1 * r1 + r2 * r2 + r3 * r3), SMALLEST_NORMAL)
    quotient = 2.0 * f.atan2(norm, r0) / norm
    return r1 * quotient, r2 * quotient, r3 * quotient


def _angle_of_quotient(f: Functions, *m: Number) -> tuple[Number, ...]:
    a, b = m[:9], m[9:]
    quotient = (a[i] * b[j] + a[3 + i] * b[3 + j] + a[6 + i] * b[6 + j] for i in range(3) for j in range(3))
    return (2.0 * axis_and_half_angle(f, *quaternion_of(f, *quotient))[3],)


# --- The left and right Jacobians of SO(3), and their inverses.
#
# With φ = ‖v‖:  J_l(v) = 1 + (1 − cos φ)/φ² [v×] + (φ − sin φ)/φ³ [v×]²  and  J_r(v) = J_l(−v) = J_l(v)ᵀ.


def left_jacobian(v: ArrayLike) -> Floats:
    """The left Jacobian of SO(3): exp(v + δ) ≈ exp(J_l(v) δ) exp(v) for small δ.

    J_l(v) = 1 + (1 − cos φ)/φ² [v×] + (φ − sin φ)/φ³ [v×]² with φ = ‖v‖. If v changes with time, J_l(v) v̇ is the
    angular velocity in the fixed frame. det J_l = (sin(φ/2)/(φ/2))²: at φ = 2πk, k ≥ 1, the rank is one.

    Args:
        v: rotation vectors, shape (..., 3) [rad].

    Returns:
        Matrices, shape (..., 3, 3), every entry accurate to a few 1e-16 · max(1, φ).

    Source: Barfoot, State Estimation for Robotics, 7.1.5.

    Examples:
        >>> v, delta = np.array([0.3, -0.5, 0.9]), 1e-6 * np.array([1.0, 2.0, 3.0])
        >>> moved = nk.rotations.exp(nk.rotations.left_jacobian(v) @ delta) @ nk.rotations.exp(v)
        >>> np.allclose(nk.rotations.exp(v + delta), moved, atol=1e-11)
        True
    """
    return evaluate_vectors(_left, v, (3, 3))[0]


def right_jacobian(v: ArrayLike) -> Floats:
    """The right Jacobian of SO(3): exp(v + δ) ≈ exp(v) exp(J_r(v) δ) for small δ.

    J_r(v) = J_l(−v) = J_l(v)ᵀ. If v changes with time, J_r(v) v̇ is the angular velocity in the moving frame.

    Args:
        v: rotation vectors, shape (..., 3) [rad].

    Returns:
        Matrices, shape (..., 3, 3), every entry accurate to a few 1e-16 · max(1, φ).

    Source: Barfoot, State Estimation for Robotics, 7.1.5.

    Examples:
        >>> v = [0.3, -0.5, 0.9]
        >>> np.allclose(nk.rotations.right_jacobian(v), nk.rotations.left_jacobian(v).T)
        True
    """
    return evaluate_vectors(_right, v, (3, 3))[0]


def left_jacobian_inverse(v: ArrayLike) -> Floats:
    """The inverse of the left Jacobian of SO(3): log(exp(δ) exp(v)) ≈ v + J_l(v)⁻¹ δ for small δ.

    J_l(v)⁻¹ = 1 − ½ [v×] + (1 − (φ/2) cot(φ/2))/φ² [v×]² with φ = ‖v‖. It is regular at φ = π and grows as
    2πk/|φ − 2πk| towards φ = 2πk, k ≥ 1.

    Args:
        v: rotation vectors, shape (..., 3) [rad].

    Returns:
        Matrices, shape (..., 3, 3), accurate to a few 1e-16 in every entry up to φ = π, and near 2πk as accurate as φ −
        2πk.

    Raises:
        SingularMatrix: φ = 2πk, k ≥ 1, up to rounding: |sin(φ/2)| ≤ 4 × 2⁻⁵² φ/2; carries the index.

    Source: Barfoot, State Estimation for Robotics, 7.1.5.

    Examples:
        >>> nk.rotations.left_jacobian_inverse([0.0, 0.0, np.pi])[0]
        array([0.    , 1.5708, 0.    ])
    """
    return _inverse(_left_inverse, v, "left Jacobian")


def right_jacobian_inverse(v: ArrayLike) -> Floats:
    """The inverse of the right Jacobian of SO(3): log(exp(v) exp(δ)) ≈ v + J_r(v)⁻¹ δ for small δ.

    J_r(v)⁻¹ = J_l(−v)⁻¹ = (J_l(v)⁻¹)ᵀ.

    Args:
        v: rotation vectors, shape (..., 3) [rad].

    Returns:
        Matrices, shape (..., 3, 3), as accurate as `left_jacobian_inverse`.

    Raises:
        SingularMatrix: φ = 2πk, k ≥ 1, up to rounding; carries the index.

    Source: Barfoot, State Estimation for Robotics, 7.1.5.

    Examples:
        >>> v = np.array([0.3, -0.5, 0.9])
        >>> np.allclose(nk.rotations.right_jacobian_inverse(v) @ nk.rotations.right_jacobian(v), np.eye(3))
        True
    """
    return _inverse(_right_inverse, v, "right Jacobian")


def _inverse(kernel: Kernel, v: ArrayLike, what: str) -> Floats:
    found, opening = evaluate_vectors(kernel, v, (3, 3), ())
    singular = np.asarray(np.abs(opening) <= WHOLE_TURN)
    if singular.any():
        raise SingularMatrix(what, "the rotation vector is a whole number of turns", first_index(singular))
    return found


def _left(f: Functions, x: Number, y: Number, z: Number) -> tuple[Number, ...]:
    B, C = jacobian_coefficients(f, x * x + y * y + z * z)
    return rodrigues(x, y, z, B, C)


def _right(f: Functions, x: Number, y: Number, z: Number) -> tuple[Number, ...]:
    return _left(f, 0.0 - x, 0.0 - y, 0.0 - z)


def _left_inverse(f: Functions, x: Number, y: Number, z: Number) -> tuple[Number, ...]:
    D, _, opening = inverse_coefficients(f, x * x + y * y + z * z)
    return *rodrigues(x, y, z, -0.5, D), opening


def _right_inverse(f: Functions, x: Number, y: Number, z: Number) -> tuple[Number, ...]:
    return _left_inverse(f, 0.0 - x, 0.0 - y, 0.0 - z)


# --- Random rotations: uniform, and near a given one.

Random: TypeAlias = "np.random.Generator | int | None"  # as text, because NumPy takes 15 ms to load its generators
Shape = SupportsIndex | Iterable[SupportsIndex]


def random_rotation(rng: Random = None, shape: Shape = ()) -> Floats:
    """Return uniformly distributed random rotations: their distribution is invariant under any fixed rotation.

    Their angle φ has the density (1 − cos φ)/π on [0, π]: they are matrices of normalised normal deviates.

    Args:
        rng: a generator, or a seed for one.
        shape: batch shape or number; () for one rotation.

    Returns:
        Rotation matrices, shape `(*shape, 3, 3)`.

    Source: Muller, A note on a method for generating points uniformly on n-dimensional spheres, CACM 2(4), 1959.

    Examples:
        >>> R = nk.rotations.random_rotation(np.random.default_rng(0), 1000)
        >>> bool(nk.rotations.is_rotation(R).all()), bool(np.linalg.norm(R.mean(axis=0)) < 0.1)
        (True, True)
    """
    return matrix_from_quat(generator(rng).standard_normal((*_sizes(shape), 4)))


def random_rotation_near(R: ArrayLike, sigma: ArrayLike, rng: Random = None, shape: Shape = ()) -> Floats:
    """Return random rotations near given ones, R exp(v) with normally distributed v in the axes of the moving frame.

    The components of v are independent, with mean zero and standard deviation σ. For one σ, small against 1 rad, the
    root mean square of the angle to R is √3 σ; angles beyond π wrap.

    Args:
        R: rotation matrices, shape (..., 3, 3), the means.
        sigma: standard deviation about every axis, one number, or about x, y and z, shape (3,), not negative [rad].
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
    middle, deviations = as_rotations(R), as_floats(sigma, (), "sigma")
    if deviations.shape not in ((), (3,)):
        raise WrongShape("sigma", "() or (3,)", deviations.shape)
    if not (deviations >= 0.0).all():
        raise BadArgument(f"sigma must not be negative, got {deviations.tolist()}")
    sizes = _sizes(shape)
    batch = middle.shape[:-2]
    turns = exp(deviations * generator(rng).standard_normal((*batch, *sizes, 3)))
    return np.asarray(middle.reshape(*batch, *(1,) * len(sizes), 3, 3) @ turns)


def _sizes(shape: Shape) -> tuple[SupportsIndex, ...]:
    return tuple(shape) if isinstance(shape, Iterable) else (shape,)
