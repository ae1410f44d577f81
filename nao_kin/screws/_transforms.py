"""Twists and wrenches in other frames, and what becomes of one twist under another."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats
from nao_kin._common.vectors import common_batch, cross, cross_matrix
from nao_kin.screws._poses import as_poses, as_twists, turned


def adjoint(T_ab: ArrayLike) -> Floats:
    """The matrix Ad with ξ_a = Ad ξ_b for every twist (linear; angular): Ad = [[R, [t×] R], [0, R]].

    It is Pinocchio's `SE3.toActionMatrix`, and the `motion_matrix` of lines with its halves exchanged.

    Args:
        T_ab: pose [[R, t], [0, 1]] of frame b in frame a, shape (..., 4, 4).

    Returns:
        Ad, shape (..., 6, 6), of determinant 1.

    Raises:
        NotARotation: the rotation part of some pose is none.
        BadArgument: the last row of some pose is not (0, 0, 0, 1).
        WrongShape, NotFinite: in `T_ab`.

    Source: Murray, Li and Sastry, A Mathematical Introduction to Robotic Manipulation, 2.4.2.

    Examples:
        >>> nk.screws.adjoint(nk.screws.pose(np.eye(3), [0, 0.5, 0])) @ [0, 0, 0, 0, 0, 1]
        array([0.5, 0. , 0. , 0. , 0. , 1. ])
    """
    R, t = as_poses(T_ab, "T_ab")
    Ad = np.zeros((*t.shape[:-1], 6, 6))
    Ad[..., :3, :3] = Ad[..., 3:, 3:] = R
    Ad[..., :3, 3:] = cross_matrix(t) @ R
    return Ad


def dual_adjoint(T_ab: ArrayLike) -> Floats:
    """The matrix Ad⁻ᵀ with w_a = Ad⁻ᵀ w_b for every wrench (force; moment): [[R, 0], [[t×] R, R]].

    The power w·ξ is the same in both frames. It is Pinocchio's `SE3.toDualActionMatrix` and the `motion_matrix` of
    lines, for a unit force along a line has the line's coordinates (direction; moment).

    Args:
        T_ab: pose [[R, t], [0, 1]] of frame b in frame a, shape (..., 4, 4).

    Returns:
        Ad⁻ᵀ, shape (..., 6, 6), of determinant 1.

    Raises:
        NotARotation: the rotation part of some pose is none.
        BadArgument: the last row of some pose is not (0, 0, 0, 1).
        WrongShape, NotFinite: in `T_ab`.

    Examples:
        >>> nk.screws.dual_adjoint(nk.screws.pose(np.eye(3), [0.5, 0, 0])) @ [0, 0, 10, 0, 0, 0]
        array([ 0.,  0., 10.,  0., -5.,  0.])
    """
    R, t = as_poses(T_ab, "T_ab")
    dual = np.zeros((*t.shape[:-1], 6, 6))
    dual[..., :3, :3] = dual[..., 3:, 3:] = R
    dual[..., 3:, :3] = cross_matrix(t) @ R
    return dual


def transform_twist(T_ab: ArrayLike, twist: ArrayLike) -> Floats:
    """A twist given in frame b, in the coordinates of frame a: (R v + t × R ω; R ω), that is `adjoint(T_ab)` times it.

    Args:
        T_ab: poses [[R, t], [0, 1]], shape (..., 4, 4).
        twist: (v; ω), shape (..., 6); batch axes broadcast.

    Returns:
        Twists, shape (..., 6).

    Raises:
        NotARotation: the rotation part of some pose is none.
        BadArgument: the last row of some pose is not (0, 0, 0, 1).
        WrongShape, NotFinite: wrong or mismatched shapes, NaN or infinity.

    Examples:
        >>> nk.screws.transform_twist(nk.screws.pose(np.eye(3), [0, 0.5, 0]), [0, 0, 0, 0, 0, 1])
        array([0.5, 0. , 0. , 0. , 0. , 1. ])
    """
    (R, t), (v, omega) = as_poses(T_ab, "T_ab"), as_twists(twist)
    common_batch("T_ab and twist", t.shape[:-1], v.shape[:-1])
    about = turned(R, omega)
    return np.concatenate([turned(R, v) + cross(t, about), about], axis=-1)


def transform_wrench(T_ab: ArrayLike, wrench: ArrayLike) -> Floats:
    """A wrench given in frame b, in the coordinates of frame a: (R f; R τ + t × R f), `dual_adjoint(T_ab)` times it.

    Args:
        T_ab: poses [[R, t], [0, 1]], shape (..., 4, 4).
        wrench: (f; τ), force first and the moment about the origin of b, shape (..., 6) [N, N m]; batch axes broadcast.

    Returns:
        Wrenches, shape (..., 6), the moments about the origin of a.

    Raises:
        NotARotation: the rotation part of some pose is none.
        BadArgument: the last row of some pose is not (0, 0, 0, 1).
        WrongShape, NotFinite: wrong or mismatched shapes, NaN or infinity.

    Examples:
        >>> nk.screws.transform_wrench(nk.screws.pose(np.eye(3), [0.5, 0, 0]), [0, 0, 10, 0, 0, 0])
        array([ 0.,  0., 10.,  0., -5.,  0.])
    """
    (R, t), (f, tau) = as_poses(T_ab, "T_ab"), as_twists(wrench, "wrench")
    common_batch("T_ab and wrench", t.shape[:-1], f.shape[:-1])
    force = turned(R, f)
    return np.concatenate([force, turned(R, tau) + cross(t, force)], axis=-1)


def bracket(a: ArrayLike, b: ArrayLike) -> Floats:
    """The Lie bracket of two twists, [ξ_a, ξ_b] = (ω_a × v_b + v_a × ω_b; ω_a × ω_b).

    It is how fast ξ_b changes when it is carried along by ξ_a, d/ds Ad(exp s ξ_a) ξ_b at s = 0, and the twist of the
    matrix [ξ_a] [ξ_b] − [ξ_b] [ξ_a]. Pinocchio writes `Motion.cross`.

    Args:
        a: twists (v; ω), shape (..., 6).
        b: twists, shape (..., 6); batch axes broadcast.

    Returns:
        Twists, shape (..., 6).

    Raises:
        BadArgument, WrongShape, NotFinite: not numbers, wrong or mismatched shapes, NaN or infinity.

    Source: Murray, Li and Sastry, A Mathematical Introduction to Robotic Manipulation, appendix A, 2.3.

    Examples:
        >>> nk.screws.bracket([0, 0, 0, 0, 0, 1], [1, 0, 0, 0, 0, 0])  # turning about z, a velocity along x moves to y
        array([0., 1., 0., 0., 0., 0.])
    """
    (v_a, omega_a), (v_b, omega_b) = as_twists(a, "twist a"), as_twists(b, "twist b")
    common_batch("twists a and b", v_a.shape[:-1], v_b.shape[:-1])
    return np.concatenate([cross(omega_a, v_b) + cross(v_a, omega_b), cross(omega_a, omega_b)], axis=-1)


def dual_bracket(twist: ArrayLike, wrench: ArrayLike) -> Floats:
    """What a twist does to a wrench carried along by it: (ω × f; ω × τ + v × f).

    It is the dual of the bracket with its sign turned, dual_bracket(ξ, w)·η = −w·bracket(ξ, η), so that the power w·η
    stays when both are carried along. Pinocchio writes `Motion.cross` of a `Force`.

    Args:
        twist: (v; ω), shape (..., 6).
        wrench: (f; τ), shape (..., 6); batch axes broadcast.

    Returns:
        Wrenches, shape (..., 6).

    Raises:
        BadArgument, WrongShape, NotFinite: not numbers, wrong or mismatched shapes, NaN or infinity.

    Source: Featherstone, Rigid Body Dynamics Algorithms, 2.9.

    Examples:
        >>> nk.screws.dual_bracket([0, 0, 0, 0, 0, 1], [10, 0, 0, 0, 0, 0])
        array([ 0., 10.,  0.,  0.,  0.,  0.])
    """
    (v, omega), (f, tau) = as_twists(twist), as_twists(wrench, "wrench")
    common_batch("twist and wrench", v.shape[:-1], f.shape[:-1])
    return np.concatenate([cross(omega, f), cross(omega, tau) + cross(v, f)], axis=-1)
