"""Twists and the motions they generate: exponential, logarithm, and the 4 × 4 matrix of a twist."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from nao_kin import rotations
from nao_kin._common.arrays import Floats
from nao_kin._common.kernels import evaluate
from nao_kin._common.poses import join_poses, split_poses
from nao_kin._common.turn_coefficients import inverse_coefficients, jacobian_coefficients
from nao_kin._common.vectors import as_batch, cross, cross_matrix, dot, first_index
from nao_kin.errors import BadArgument, at_index
from nao_kin.screws._poses import as_twists

# [rad]; of a longer rotation vector the angle within a turn has no correct digit.
LARGEST_ANGLE = 1e15
# How far a 4 × 4 matrix may be from the form of a twist, beside its largest entry.
_FORM = 1e-9


def exp(twist: ArrayLike) -> Floats:
    """The motion that a body makes in unit time under a constant twist: exp [ξ] = [[exp [ω×], J(ω) v], [0, 1]].

    J(ω) = 1 + (1 − cos θ)/θ² [ω×] + (θ − sin θ)/θ³ [ω×]² with θ = ‖ω‖, the left Jacobian of SO(3). Every entry is right
    to a few 1e-16 · max(1, θ), in the last column times ‖v‖, at θ = 0, at π and everywhere between.

    Args:
        twist: ξ = (v; ω), linear part first as in `RobotModel.jacobian` and Pinocchio, shape (..., 6) [m, rad]. v is
            the velocity of the point of the body that is passing the origin.

    Returns:
        Poses, shape (..., 4, 4).

    Raises:
        BadArgument: not numbers, outside ±1e150, or ‖ω‖ above 1e15 rad, of which the angle within a turn is lost.
        WrongShape, NotFinite: not of shape (..., 6), NaN or infinity.

    Source: Murray, Li and Sastry, A Mathematical Introduction to Robotic Manipulation, 2.3.2.

    Examples:
        >>> nk.screws.exp([0, 0, 0.5, 0, 0, np.pi / 2])  # a quarter turn about z, and half a metre along it
        array([[ 0. , -1. ,  0. ,  0. ],
               [ 1. ,  0. ,  0. ,  0. ],
               [ 0. ,  0. ,  1. ,  0.5],
               [ 0. ,  0. ,  0. ,  1. ]])
    """
    return motion_of(*turns_checked(twist))


def log(T_ab: ArrayLike) -> Floats:
    """The twist of a motion, ξ = (v; ω) with exp [ξ] = T: ω = log R with ‖ω‖ in [0, π], v = J(ω)⁻¹ t.

    J(ω)⁻¹ = 1 − ½ [ω×] + (1 − (θ/2) cot(θ/2))/θ² [ω×]². For matrices exact to rounding ω is accurate to a few 1e-16,
    v to a few 1e-16 · ‖t‖, at θ = 0 and π too; small angles also relative to themselves.

    Args:
        T_ab: poses [[R, t], [0, 1]], shape (..., 4, 4).

    Returns:
        Twists (linear; angular), shape (..., 6) [m, rad]. At θ = π, where ω and −ω turn alike, the ω whose first
        component that is not zero is positive, and the v that belongs to it.

    Raises:
        NotARotation: the rotation part of some pose is none.
        BadArgument: the last row of some pose is not (0, 0, 0, 1).
        WrongShape, NotFinite: in `T_ab`.

    Source: Murray, Li and Sastry, A Mathematical Introduction to Robotic Manipulation, 2.3.2.

    Examples:
        >>> nk.screws.log(nk.screws.pose(nk.rotations.rot_z(np.pi / 2), [0, 0, 0.5]))
        array([0.    , 0.    , 0.5   , 0.    , 0.    , 1.5708])
    """
    return np.concatenate(log_parts(*split_poses(T_ab, "T_ab")), axis=-1)


def hat(twist: ArrayLike) -> Floats:
    """The matrix [ξ] = [[[ω×], v], [0, 0]] of a twist, whose matrix exponential is the motion.

    Args:
        twist: (v; ω), shape (..., 6).

    Returns:
        Matrices, shape (..., 4, 4).

    Raises:
        BadArgument, WrongShape, NotFinite: not numbers, not of shape (..., 6), NaN or infinity.

    Examples:
        >>> nk.screws.hat([1, 2, 3, 0, 0, 4])
        array([[ 0., -4.,  0.,  1.],
               [ 4.,  0.,  0.,  2.],
               [ 0.,  0.,  0.,  3.],
               [ 0.,  0.,  0.,  0.]])
    """
    v, omega = as_twists(twist)
    found = np.zeros((*v.shape[:-1], 4, 4))
    found[..., :3, :3] = cross_matrix(omega) + 0.0
    found[..., :3, 3] = v
    return found


def vee(matrix: ArrayLike) -> Floats:
    """The twist (v; ω) of a matrix [[[ω×], v], [0, 0]], what `hat` made.

    Args:
        matrix: shape (..., 4, 4), with an antisymmetric part [ω×] and a last row of zeros.

    Returns:
        Twists, shape (..., 6).

    Raises:
        BadArgument: not of that form, by more than 1e-9 of its largest entry; rounding up to there is averaged out.
        WrongShape, NotFinite: not of shape (..., 4, 4), NaN or infinity.

    Examples:
        >>> nk.screws.vee(nk.screws.hat([1, 2, 3, 0, 0, 4]))
        array([1., 2., 3., 0., 0., 4.])
    """
    matrices = as_batch(matrix, (4, 4), "matrix")
    W = matrices[..., :3, :3]
    defect = np.maximum(np.abs(W + np.swapaxes(W, -1, -2)).max(axis=(-2, -1)), np.abs(matrices[..., 3, :]).max(axis=-1))
    wrong = defect > _FORM * np.abs(matrices).max(axis=(-2, -1))
    if wrong.any():
        index = first_index(wrong)
        raise BadArgument(
            f"the matrix of a twist must be [[[ω×], v], [0, 0]], but{at_index(index)} it differs from that form by "
            f"{defect[index]:.3g}"
        )
    omega = 0.5 * np.stack([W[..., 2, 1] - W[..., 1, 2], W[..., 0, 2] - W[..., 2, 0], W[..., 1, 0] - W[..., 0, 1]], -1)
    return np.concatenate([matrices[..., :3, 3], omega], axis=-1)


def turns_checked(twist: ArrayLike, what: str = "twist") -> tuple[Floats, Floats]:
    """Linear and angular part of twists whose angles mean something."""
    v, omega = as_twists(twist, what)
    square = dot(omega, omega)
    if square.size and square.max() > LARGEST_ANGLE**2:
        index = first_index(square > LARGEST_ANGLE**2)
        raise BadArgument(
            f"the {what}{at_index(index)} turns by more than {LARGEST_ANGLE:.0e} rad: {omega[index].tolist()}"
        )
    return v, omega


def motion_of(v: Floats, omega: Floats) -> Floats:
    """The pose exp [(v; ω)]."""
    B, C = evaluate(jacobian_coefficients, [dot(omega, omega)[..., None]], (), ())
    across = cross(omega, v)
    t = v + B[..., None] * across + C[..., None] * cross(omega, across)
    return join_poses(rotations.exp(omega), t)


def log_parts(R: Floats, t: Floats) -> tuple[Floats, Floats]:
    """The linear and the angular part of the logarithm of a motion, which is checked on the way."""
    omega = rotations.log(R)
    D, _, _ = evaluate(inverse_coefficients, [dot(omega, omega)[..., None]], (), (), ())
    across = cross(omega, t)
    return t - 0.5 * across + D[..., None] * cross(omega, across), omega
