"""Rotation matrices of one turn: about a coordinate axis, and the kernels of Rodrigues' formula about any other."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats
from nao_kin._common.kernels import (
    LARGEST_SQUARE,
    SMALLEST_NORMAL,
    Functions,
    Kernel,
    Number,
    OutOfScale,
    evaluate,
)
from nao_kin._common.vectors import as_batch


def rot_x(angle: ArrayLike) -> Floats:
    """Rotation about x, [[1, 0, 0], [0, c, −s], [0, s, c]] with c = cos(angle), s = sin(angle).

    Args:
        angle: shape (...) [rad].

    Returns:
        Rotation matrices, shape (..., 3, 3), active.

    Raises:
        BadArgument, NotFinite: not numbers, NaN or infinity.

    Examples:
        >>> nk.rotations.rot_x(0.5)
        array([[ 1.    ,  0.    ,  0.    ],
               [ 0.    ,  0.8776, -0.4794],
               [ 0.    ,  0.4794,  0.8776]])
    """
    return _turn(_about_x, angle)


def rot_y(angle: ArrayLike) -> Floats:
    """Rotation about y, [[c, 0, s], [0, 1, 0], [−s, 0, c]] with c = cos(angle), s = sin(angle).

    Args:
        angle: shape (...) [rad].

    Returns:
        Rotation matrices, shape (..., 3, 3), active.

    Raises:
        BadArgument, NotFinite: not numbers, NaN or infinity.

    Examples:
        >>> nk.rotations.rot_y(0.5)
        array([[ 0.8776,  0.    ,  0.4794],
               [ 0.    ,  1.    ,  0.    ],
               [-0.4794,  0.    ,  0.8776]])
    """
    return _turn(_about_y, angle)


def rot_z(angle: ArrayLike) -> Floats:
    """Rotation about z, [[c, −s, 0], [s, c, 0], [0, 0, 1]] with c = cos(angle), s = sin(angle).

    Args:
        angle: shape (...) [rad].

    Returns:
        Rotation matrices, shape (..., 3, 3), active.

    Raises:
        BadArgument, NotFinite: not numbers, NaN or infinity.

    Examples:
        >>> nk.rotations.rot_z(0.5)
        array([[ 0.8776, -0.4794,  0.    ],
               [ 0.4794,  0.8776,  0.    ],
               [ 0.    ,  0.    ,  1.    ]])
    """
    return _turn(_about_z, angle)


def _turn(kernel: Kernel, angle: ArrayLike) -> Floats:
    angles = as_batch(angle, (), "angle")
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
    """Rotation vector of any length: A = sin φ/φ, B = (1 − cos φ)/φ² with φ = ‖v‖."""
    square = squared_angle(f, x, y, z)
    # The floor keeps 0/0 away; both quotients are constant to the last digit from φ = 1e-8 down.
    square = f.larger(square, SMALLEST_NORMAL)
    half = 0.5 * f.sqrt(square)
    # One tangent of the half angle gives sine and cosine: 2t/(1 + t²) and (1 − t²)/(1 + t²), at half their price.
    quotient = f.tan(half) / half
    A = quotient / (1.0 + 0.25 * square * quotient * quotient)
    return rodrigues(x, y, z, A, 0.5 * A * quotient)


def squared_angle(f: Functions, x: Number, y: Number, z: Number) -> Number:
    """‖v‖² of a rotation vector; `OutOfScale` where it is too long to mean an angle within a turn."""
    square = x * x + y * y + z * z
    if not f.within(square, LARGEST_SQUARE):
        raise OutOfScale
    return square


def from_natural(f: Functions, x: Number, y: Number, z: Number, angle: Number) -> tuple[Number, ...]:
    """Axis of any length and angle: A = sin φ, B = 1 − cos φ for the unit axis."""
    square = f.square(x, y, z)
    t = f.tan(0.5 * angle)
    divisor = 1.0 + t * t
    return rodrigues(x, y, z, 2.0 * t / (divisor * f.sqrt(square)), 2.0 * (t * t / divisor) / square)


def from_quaternion(f: Functions, r0: Number, r1: Number, r2: Number, r3: Number) -> tuple[Number, ...]:
    """Quaternion of any length: A = 2 r0, B = 2 for the vector part of the unit quaternion."""
    B = 2.0 / f.square(r0, r1, r2, r3)
    return rodrigues(r1, r2, r3, B * r0, B)


def from_linear(f: Functions, x: Number, y: Number, z: Number, q0: Number) -> tuple[Number, ...]:
    """Linear invariants e sin φ, cos φ, brought to unit length: A = 1, B = (1 − cos φ)/sin² φ = 1/(1 + cos φ)."""
    square = x * x + y * y + z * z
    scale = 1.0 / f.sqrt(square + q0 * q0)
    # 1/(1 + q0) needs no axis at φ = 0; (1 − q0)/‖q‖² needs no digits of 1 + q0 near φ = π.
    obtuse = q0 < 0.0
    B = f.where(obtuse, 1.0 - scale * q0, 1.0) / f.where(obtuse, scale * scale * square, 1.0 + scale * q0)
    return rodrigues(scale * x, scale * y, scale * z, 1.0, B)
