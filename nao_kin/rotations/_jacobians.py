"""What a change of a rotation vector does to its rotation: the left and right Jacobians of SO(3), and their inverses.

With φ = ‖v‖:  J_l(v) = 1 + (1 − cos φ)/φ² [v×] + (φ − sin φ)/φ³ [v×]²  and  J_r(v) = J_l(−v) = J_l(v)ᵀ.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats
from nao_kin._common.kernels import Functions, Kernel, Number
from nao_kin._common.turn_coefficients import WHOLE_TURN, inverse_coefficients, jacobian_coefficients
from nao_kin._common.vectors import first_index
from nao_kin.errors import SingularMatrix
from nao_kin.rotations._checks import evaluate_vectors
from nao_kin.rotations._elementary import rodrigues, squared_angle


def left_jacobian(v: ArrayLike) -> Floats:
    """The left Jacobian of SO(3): exp(v + δ) ≈ exp(J_l(v) δ) exp(v) for small δ.

    J_l(v) = 1 + (1 − cos φ)/φ² [v×] + (φ − sin φ)/φ³ [v×]² with φ = ‖v‖. Of a rotation vector that changes with time,
    J_l(v) v̇ is the angular velocity in the fixed frame. Its determinant is (sin(φ/2)/(φ/2))²: at φ = 2πk, k ≥ 1, it
    keeps the direction of v only.

    Args:
        v: rotation vectors, shape (..., 3) [rad]; any length.

    Returns:
        Matrices, shape (..., 3, 3), every entry right to a few 1e-16 · max(1, φ).

    Raises:
        BadArgument: not numbers, or so long (1e140 rad) that the angle within a turn means nothing.
        WrongShape, NotFinite: not of shape (..., 3), NaN or infinity.

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

    J_r(v) = J_l(−v) = J_l(v)ᵀ. Of a rotation vector that changes with time, J_r(v) v̇ is the angular velocity in the
    moving frame. At φ = 2πk, k ≥ 1, it is singular as the left one is.

    Args:
        v: rotation vectors, shape (..., 3) [rad]; any length.

    Returns:
        Matrices, shape (..., 3, 3), every entry right to a few 1e-16 · max(1, φ).

    Raises:
        BadArgument, WrongShape, NotFinite: as `left_jacobian`.

    Source: Barfoot, State Estimation for Robotics, 7.1.5.

    Examples:
        >>> v, delta = np.array([0.3, -0.5, 0.9]), 1e-6 * np.array([1.0, 2.0, 3.0])
        >>> moved = nk.rotations.exp(v) @ nk.rotations.exp(nk.rotations.right_jacobian(v) @ delta)
        >>> np.allclose(nk.rotations.exp(v + delta), moved, atol=1e-11)
        True
    """
    return evaluate_vectors(_right, v, (3, 3))[0]


def left_jacobian_inverse(v: ArrayLike) -> Floats:
    """The inverse of the left Jacobian of SO(3): log(exp(δ) exp(v)) ≈ v + J_l(v)⁻¹ δ for small δ.

    J_l(v)⁻¹ = 1 − ½ [v×] + (1 − (φ/2) cot(φ/2))/φ² [v×]² with φ = ‖v‖. Nothing happens at φ = π. Towards φ = 2πk,
    k ≥ 1, it grows as 2πk/|φ − 2πk|, and there it does not exist.

    Args:
        v: rotation vectors, shape (..., 3) [rad].

    Returns:
        Matrices, shape (..., 3, 3), right to a few 1e-16 in every entry up to φ = π, and towards 2πk to as many digits
        as the distance φ − 2πk has.

    Raises:
        SingularMatrix: φ = 2πk, k ≥ 1, up to rounding: |sin(φ/2)| ≤ 4 × 2⁻⁵² φ/2; carries the index.
        BadArgument, WrongShape, NotFinite: as `left_jacobian`.

    Source: Barfoot, State Estimation for Robotics, 7.1.5.

    Examples:
        >>> nk.rotations.left_jacobian_inverse([0.0, 0.0, np.pi])
        array([[ 0.    ,  1.5708,  0.    ],
               [-1.5708,  0.    ,  0.    ],
               [ 0.    ,  0.    ,  1.    ]])
    """
    return _inverse(_left_inverse, v, "left Jacobian")


def right_jacobian_inverse(v: ArrayLike) -> Floats:
    """The inverse of the right Jacobian of SO(3): log(exp(v) exp(δ)) ≈ v + J_r(v)⁻¹ δ for small δ.

    J_r(v)⁻¹ = J_l(−v)⁻¹ = (J_l(v)⁻¹)ᵀ.

    Args:
        v: rotation vectors, shape (..., 3) [rad].

    Returns:
        Matrices, shape (..., 3, 3), as right as `left_jacobian_inverse`.

    Raises:
        SingularMatrix, BadArgument, WrongShape, NotFinite: as `left_jacobian_inverse`.

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
    B, C = jacobian_coefficients(f, squared_angle(f, x, y, z))
    return rodrigues(x, y, z, B, C)


def _right(f: Functions, x: Number, y: Number, z: Number) -> tuple[Number, ...]:
    return _left(f, 0.0 - x, 0.0 - y, 0.0 - z)


def _left_inverse(f: Functions, x: Number, y: Number, z: Number) -> tuple[Number, ...]:
    D, _, opening = inverse_coefficients(f, squared_angle(f, x, y, z))
    return *rodrigues(x, y, z, -0.5, D), opening


def _right_inverse(f: Functions, x: Number, y: Number, z: Number) -> tuple[Number, ...]:
    return _left_inverse(f, 0.0 - x, 0.0 - y, 0.0 - z)
