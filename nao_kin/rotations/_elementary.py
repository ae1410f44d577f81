"""Rotation matrices about a coordinate axis, and the kernels of Rodrigues' formula for any axis."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, as_floats, cross_matrix, first_index
from nao_kin._core.kernels import SMALLEST_NORMAL, Functions, Kernel, Number, evaluate
from nao_kin._core.warn import warn_of_degrees
from nao_kin.errors import BadArgument, at_index
from nao_kin.rotations._checks import TOLERANCE


def rot_x(angle: ArrayLike) -> Floats:
    """Rotation about x, [[1, 0, 0], [0, c, −s], [0, s, c]] with c = cos(angle), s = sin(angle).

    Args:
        angle: shape (...) [rad].

    Returns:
        Rotation matrices, shape (..., 3, 3), active.

    Examples:
        >>> nk.rotations.rot_x(0.5) @ [0, 1, 0]
        array([0.    , 0.8776, 0.4794])
    """
    return _turn(_about_x, angle)


def rot_y(angle: ArrayLike) -> Floats:
    """Rotation about y, [[c, 0, s], [0, 1, 0], [−s, 0, c]] with c = cos(angle), s = sin(angle).

    Args:
        angle: shape (...) [rad].

    Returns:
        Rotation matrices, shape (..., 3, 3), active.

    Examples:
        >>> nk.rotations.rot_y(0.5) @ [0, 0, 1]
        array([0.4794, 0.    , 0.8776])
    """
    return _turn(_about_y, angle)


def rot_z(angle: ArrayLike) -> Floats:
    """Rotation about z, [[c, −s, 0], [s, c, 0], [0, 0, 1]] with c = cos(angle), s = sin(angle).

    Args:
        angle: shape (...) [rad].

    Returns:
        Rotation matrices, shape (..., 3, 3), active.

    Examples:
        >>> nk.rotations.rot_z(0.5) @ [1, 0, 0]
        array([0.8776, 0.4794, 0.    ])
    """
    return _turn(_about_z, angle)


def _turn(kernel: Kernel, angle: ArrayLike) -> Floats:
    angles = as_floats(angle, (), "angle")
    warn_of_degrees(angles, "angle", 2)
    return evaluate(kernel, [angles[..., np.newaxis]], (3, 3))[0]


def _about_x(f: Functions, angle: Number) -> tuple[Number, ...]:
    c, s = f.cos(angle), f.sin(angle)
    return 1.0, 0.0, 0.0, 0.0, c, 0.0 - s, 0.0, s, c


def _about_y(f: Functions, angle: Number) -> tuple[Number, ...]:
    c, s = f.cos(angle), f.sin(angle)
    return c, 0.0, s, 0.0, 1.0, 0.0, 0.0 - s, 0.0, c


def _about_z(f: Functions, angle: Number) -> tuple[Number, ...]:
    c, s = f.cos(angle), f.sin(angle)
    return c, 0.0 - s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0


def rodrigues(x: Number, y: Number, z: Number, A: Number, B: Number) -> tuple[Number, ...]:
    """The nine entries of 1 + A [v×] + B [v×]² for v = (x, y, z)."""
    ax, ay, az = A * x, A * y, A * z
    bx, by, bz = B * x, B * y, B * z
    xx, yy, zz = bx * x, by * y, bz * z
    xy, xz, yz = bx * y, bx * z, by * z
    return 1.0 - (yy + zz), xy - az, xz + ay, xy + az, 1.0 - (xx + zz), yz - ax, xz - ay, yz + ax, 1.0 - (xx + yy)


def from_rotation_vector(f: Functions, x: Number, y: Number, z: Number) -> tuple[Number, ...]:
    """The matrix of a rotation vector of any length: A = sin φ/φ, B = (1 − cos φ)/φ² with φ = ‖v‖."""
    square = x * x + y * y + z * z
    # The floor avoids 0/0; both quotients are constant to the last digit below φ = 1e-8.
    square = f.larger(square, SMALLEST_NORMAL)
    half = 0.5 * f.sqrt(square)
    # One tangent of the half angle gives sine and cosine: 2t/(1 + t²) and (1 − t²)/(1 + t²), at half the cost.
    quotient = f.tan(half) / half
    A = quotient / (1.0 + 0.25 * square * quotient * quotient)
    return rodrigues(x, y, z, A, 0.5 * A * quotient)


def from_natural(f: Functions, x: Number, y: Number, z: Number, angle: Number) -> tuple[Number, ...]:
    """The matrix of an axis of any length and an angle: A = sin φ, B = 1 − cos φ for the unit axis."""
    square = f.square(x, y, z)
    t = f.tan(0.5 * angle)
    divisor = 1.0 + t * t
    return rodrigues(x, y, z, 2.0 * t / (divisor * f.sqrt(square)), 2.0 * (t * t / divisor) / square)


def from_quaternion(f: Functions, r0: Number, r1: Number, r2: Number, r3: Number) -> tuple[Number, ...]:
    """The matrix of a quaternion of any length: A = 2 r0, B = 2 for the vector part of the unit quaternion."""
    B = 2.0 / f.square(r0, r1, r2, r3)
    return rodrigues(r1, r2, r3, B * r0, B)


def from_linear(f: Functions, x: Number, y: Number, z: Number, q0: Number) -> tuple[Number, ...]:
    """The matrix of linear invariants e sin φ, cos φ of any length: A = 1, B = (1 − cos φ)/sin² φ = 1/(1 + cos φ)."""
    square = x * x + y * y + z * z
    scale = 1.0 / f.sqrt(square + q0 * q0)
    # 1/(1 + q0) needs no axis at φ = 0; (1 − q0)/‖q‖² needs no digits of 1 + q0 near φ = π.
    obtuse = q0 < 0.0
    B = f.where(obtuse, 1.0 - scale * q0, 1.0) / f.where(obtuse, scale * scale * square, 1.0 + scale * q0)
    return rodrigues(scale * x, scale * y, scale * z, 1.0, B)


# --- Skew-symmetric matrices of the cross product.


def skew(v: ArrayLike) -> Floats:
    """The matrix [v×] of the cross product, [v×] w = v × w; often written v^ or hat.

    Args:
        v: vectors, shape (..., 3).

    Returns:
        Skew-symmetric matrices [[0, −z, y], [z, 0, −x], [−y, x, 0]], shape (..., 3, 3).

    Examples:
        >>> nk.rotations.skew([1, 2, 3]).tolist()
        [[0.0, -3.0, 2.0], [3.0, 0.0, -1.0], [-2.0, 1.0, 0.0]]
    """
    # Adding 0.0 turns −0.0 into 0.0.
    return cross_matrix(as_floats(v, (3,), "vector")) + 0.0


def vee(W: ArrayLike) -> Floats:
    """The vector v of a skew-symmetric matrix W = [v×], the inverse of `skew`.

    Rounding is averaged out: v = ½ (w32 − w23, w13 − w31, w21 − w12). For the vector vect R of a rotation see
    `linear_invariants`.

    Args:
        W: skew-symmetric matrices, shape (..., 3, 3).

    Returns:
        Vectors, shape (..., 3).

    Raises:
        BadArgument: an entry of W + Wᵀ is above 1e-6 of the largest entry of W.

    Examples:
        >>> nk.rotations.vee([[0, -3, 2], [3, 0, -1], [-2, 1, 0]])
        array([1., 2., 3.])
    """
    matrices = as_floats(W, (3, 3), "skew-symmetric matrix")
    half = 0.5 * matrices
    largest = np.abs(half).max(axis=(-2, -1))
    symmetric = np.abs(half + np.swapaxes(half, -1, -2)).max(axis=(-2, -1))
    if (symmetric > TOLERANCE * largest).any():
        index = first_index(np.asarray(symmetric > TOLERANCE * largest))
        sizes = 2.0 * float(symmetric[index]), 2.0 * float(largest[index])
        raise BadArgument(
            f"matrix{at_index(index)} is not skew-symmetric: largest entry of W + Wᵀ is {sizes[0]:.3g}, "
            f"of W {sizes[1]:.3g}"
        )
    return np.stack(
        [half[..., 2, 1] - half[..., 1, 2], half[..., 0, 2] - half[..., 2, 0], half[..., 1, 0] - half[..., 0, 1]],
        axis=-1,
    )
