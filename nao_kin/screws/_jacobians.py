"""The Jacobians of the exponential of SE(3), left and right, and their inverses.

A motion of SE(3) is a rotation in dual numbers: with ω + ε v in the place of ω, the formulas of SO(3) give the 3 × 3
blocks of SE(3). Block Q below is the derivative of J(ω) along v.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats
from nao_kin._common.kernels import evaluate
from nao_kin._common.turn_coefficients import WHOLE_TURN, inverse_coefficients, jacobian_derivatives
from nao_kin._common.vectors import cross_matrix, dot, first_index
from nao_kin.errors import SingularMatrix
from nao_kin.screws._exponential import turns_checked


def left_jacobian(twist: ArrayLike) -> Floats:
    """The matrix J with exp [ξ + δ] = exp [J δ] exp [ξ] for small δ: [[J(ω), Q], [0, J(ω)]].

    J(ω) = 1 + B [ω×] + C [ω×]² is that of SO(3), with B = (1 − cos θ)/θ², C = (θ − sin θ)/θ³, and
    Q = B [v×] + C ([ω×][v×] + [v×][ω×]) + (ω·v) (B'/θ [ω×] + C'/θ [ω×]²) with the derivatives by θ = ‖ω‖.
    J ξ̇ is the velocity of the body with the pose exp [ξ], seen in the fixed frame. J = ∫₀¹ Ad(exp [s ξ]) ds.

    Args:
        twist: ξ = (v; ω), linear part first, shape (..., 6) [m, rad].

    Returns:
        J, shape (..., 6, 6), for twists (linear; angular) on both sides.

    Raises:
        BadArgument: not numbers, outside ±1e150, or ‖ω‖ above 1e15 rad.
        WrongShape, NotFinite: not of shape (..., 6), NaN or infinity.

    Source: Barfoot, State Estimation for Robotics, 7.1.5, for another form of Q.

    Examples:
        >>> xi = np.array([0.1, 0.2, 0.3, 0, 0, 1])
        >>> nk.screws.left_jacobian(xi) @ xi  # along ξ itself nothing turns away
        array([0.1, 0.2, 0.3, 0. , 0. , 1. ])
    """
    v, omega = turns_checked(twist)
    square = dot(omega, omega)[..., None]
    B, C, dB, dC = (c[..., None, None] for c in evaluate(jacobian_derivatives, [square], (), (), (), ()))
    W, V, W2, WV, along = _products(v, omega)
    return _blocks(np.eye(3) + B * W + C * W2, B * V + C * WV + along * (dB * W + dC * W2))


def right_jacobian(twist: ArrayLike) -> Floats:
    """The matrix J with exp [ξ + δ] = exp [ξ] exp [J δ] for small δ: `left_jacobian` of −ξ; Pinocchio's `Jexp6`.

    J ξ̇ is the velocity of the body with the pose exp [ξ], seen in the body's own frame.

    Args:
        twist: ξ = (v; ω), linear part first, shape (..., 6) [m, rad].

    Returns:
        J, shape (..., 6, 6), for twists (linear; angular) on both sides.

    Raises:
        BadArgument: not numbers, outside ±1e150, or ‖ω‖ above 1e15 rad.
        WrongShape, NotFinite: not of shape (..., 6), NaN or infinity.

    Examples:
        >>> xi, change = np.array([0.1, 0.2, 0.3, 0, 0, 1]), np.array([0, 0, 0, 1e-6, 0, 0])
        >>> there = nk.screws.compose(nk.screws.inverse(nk.screws.exp(xi)), nk.screws.exp(xi + change))
        >>> bool(np.allclose(nk.screws.log(there), nk.screws.right_jacobian(xi) @ change, atol=1e-11))
        True
    """
    v, omega = turns_checked(twist)
    return left_jacobian(-np.concatenate([v, omega], axis=-1))


def left_jacobian_inverse(twist: ArrayLike) -> Floats:
    """The inverse of `left_jacobian`: how ξ = log T changes when T moves, log(exp [δ] T) = ξ + J⁻¹ δ for small δ.

    [[J⁻¹, Q'], [0, J⁻¹]] with J⁻¹ = 1 − ½ [ω×] + D [ω×]², D = (1 − (θ/2) cot(θ/2))/θ², and
    Q' = −½ [v×] + D ([ω×][v×] + [v×][ω×]) + (ω·v) D'/θ [ω×]².

    Args:
        twist: ξ = (v; ω), linear part first, shape (..., 6) [m, rad].

    Returns:
        J⁻¹, shape (..., 6, 6), for twists (linear; angular) on both sides.

    Raises:
        SingularMatrix: ‖ω‖ is a multiple of 2π other than 0, up to its rounding; no logarithm comes near.
        BadArgument: not numbers, outside ±1e150, or ‖ω‖ above 1e15 rad.
        WrongShape, NotFinite: not of shape (..., 6), NaN or infinity.

    Source: Barfoot, State Estimation for Robotics, 7.1.5, for the blocks in another form.

    Examples:
        >>> xi = [0.1, 0.2, 0.3, 0, 0, 1]
        >>> bool(np.allclose(nk.screws.left_jacobian_inverse(xi) @ nk.screws.left_jacobian(xi), np.eye(6)))
        True
    """
    v, omega = turns_checked(twist)
    D, dD, opening = evaluate(inverse_coefficients, [dot(omega, omega)[..., None]], (), (), ())
    whole = np.asarray(np.abs(opening) <= WHOLE_TURN)
    if whole.any():
        raise SingularMatrix("Jacobian of the exponential", "‖ω‖ is a multiple of 2π", first_index(whole))
    D, dD = D[..., None, None], dD[..., None, None]
    W, V, W2, WV, along = _products(v, omega)
    return _blocks(np.eye(3) - 0.5 * W + D * W2, -0.5 * V + D * WV + along * dD * W2)


def right_jacobian_inverse(twist: ArrayLike) -> Floats:
    """The inverse of `right_jacobian`: log(T exp [δ]) = ξ + J⁻¹ δ for small δ and ξ = log T; Pinocchio's `Jlog6`.

    Args:
        twist: ξ = (v; ω), linear part first, shape (..., 6) [m, rad].

    Returns:
        J⁻¹, shape (..., 6, 6), for twists (linear; angular) on both sides: `left_jacobian_inverse` of −ξ.

    Raises:
        SingularMatrix: ‖ω‖ is a multiple of 2π other than 0, up to its rounding.
        BadArgument: not numbers, outside ±1e150, or ‖ω‖ above 1e15 rad.
        WrongShape, NotFinite: not of shape (..., 6), NaN or infinity.

    Examples:
        >>> xi = np.array([0.1, 0.2, 0.3, 0, 0, 1])
        >>> same = nk.screws.right_jacobian_inverse(xi), nk.screws.left_jacobian_inverse(-xi)
        >>> bool(np.array_equal(*same))
        True
    """
    v, omega = turns_checked(twist)
    return left_jacobian_inverse(-np.concatenate([v, omega], axis=-1))


def _products(v: Floats, omega: Floats) -> tuple[Floats, ...]:
    """[ω×], [v×], [ω×]², [ω×][v×] + [v×][ω×] and, to multiply them by, ω·v.

    [a×][b×] = b aᵀ − (a·b) 1 costs half of what a product of matrices does.
    """
    along, outer = dot(omega, v)[..., None, None], v[..., :, None] * omega[..., None, :]
    W2 = omega[..., :, None] * omega[..., None, :] - dot(omega, omega)[..., None, None] * np.eye(3)
    WV = outer + np.swapaxes(outer, -1, -2) - 2.0 * along * np.eye(3)
    return cross_matrix(omega), cross_matrix(v), W2, WV, along


def _blocks(J: Floats, Q: Floats) -> Floats:
    found = np.zeros((*J.shape[:-2], 6, 6))
    found[..., :3, :3] = found[..., 3:, 3:] = J
    found[..., :3, 3:] = Q
    return found
