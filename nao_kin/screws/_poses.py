"""Rigid motions as 4 × 4 matrices: construct, invert, apply to points, repair; and as dual quaternions."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import (
    Floats,
    as_floats,
    common_batch,
    cross,
    cross_matrix,
    dot,
    first_index,
    join_poses,
    norm,
    rigid_inverse,
    unit,
)
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument, NotARotation, WrongShape, at_index
from nao_kin.rotations import (
    RotationDefects,
    check_rotation,
    matrix_from_quat,
    matrix_from_rpy,
    nearest_rotation,
    quat_conjugate,
    quat_from_matrix,
    quat_multiply,
)

# Largest distance of the last row of an approximate pose from (0, 0, 0, 1).
_LAST_ROW = 1e-3


def pose(R_ab: ArrayLike, p: ArrayLike) -> Floats:
    """The pose T_ab = [[R_ab, p], [0, 1]] of frame b in frame a.

    Args:
        R_ab: rotation matrices, shape (..., 3, 3).
        p: the origin of b in a, shape (..., 3) [m]; batch axes broadcast.

    Returns:
        Poses, shape (..., 4, 4).

    Examples:
        >>> nk.screws.pose(nk.rotations.rot_z(np.pi / 2), [1, 2, 3])[0]
        array([ 0., -1.,  0.,  1.])
    """
    rotations = as_floats(R_ab, (3, 3), "R_ab")
    check_rotation(rotations)
    return join_poses(rotations, as_floats(p, (3,), "p"))


def inverse(T_ab: ArrayLike) -> Floats:
    """The inverse T_ba = [[Rᵀ, −Rᵀ p], [0, 1]], the pose of frame a in frame b.

    Args:
        T_ab: poses [[R, p], [0, 1]], shape (..., 4, 4).

    Returns:
        Poses, shape (..., 4, 4).

    Examples:
        >>> T_ab = nk.screws.pose(nk.rotations.rot_z(np.pi / 2), [1, 2, 3])
        >>> nk.screws.inverse(T_ab)[:3, 3]
        array([-2.,  1., -3.])
    """
    R, p = as_poses(T_ab, "T_ab")
    return rigid_inverse(join_poses(R, p))


def transform_point(T_ab: ArrayLike, p_b: ArrayLike) -> Floats:
    """The coordinates in frame a of a point given in frame b, R p + t; also a point of frame a moved by T_ab.

    Args:
        T_ab: poses [[R, t], [0, 1]], shape (..., 4, 4).
        p_b: points, shape (..., 3) [m]; batch axes broadcast.

    Returns:
        Points, shape (..., 3) [m].

    Examples:
        >>> T_ab = nk.screws.pose(nk.rotations.rot_z(np.pi / 2), [1, 2, 3])
        >>> nk.screws.transform_point(T_ab, [1, 0, 0])
        array([1., 3., 3.])
    """
    (R, t), points = as_poses(T_ab, "T_ab"), as_floats(p_b, (3,), "p_b")
    common_batch("T_ab and p_b", t.shape[:-1], points.shape[:-1])
    return turned(R, points) + t


def nearest_pose(M: ArrayLike) -> Floats:
    """The rigid motion nearest to a 4 × 4 matrix in the Frobenius norm: the nearest rotation, the same translation.

    Args:
        M: matrices, shape (..., 4, 4), for instance products of many poses, or measured or typed poses.

    Returns:
        Poses, shape (..., 4, 4), with the last row (0, 0, 0, 1).

    Raises:
        BadArgument: a last row farther than 1e-3 from (0, 0, 0, 1) in some entry, as in a transposed pose; or a matrix
            without a single nearest rotation.

    Examples:
        >>> typed = [[0.707, -0.707, 0, 0.1], [0.707, 0.707, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
        >>> nk.screws.nearest_pose(typed)[0]
        array([ 0.7071, -0.7071,  0.    ,  0.1   ])
    """
    matrices = as_floats(M, (4, 4), "matrix")
    far = np.abs(matrices[..., 3, :] - [0.0, 0.0, 0.0, 1.0]).max(axis=-1) > _LAST_ROW
    if far.any():
        index = first_index(far)
        raise BadArgument(
            f"the last row of the matrix{at_index(index)} must be (0, 0, 0, 1) to {_LAST_ROW:.0e}, "
            f"got {matrices[index][3].tolist()}"
        )
    return join_poses(nearest_rotation(matrices[..., :3, :3]), matrices[..., :3, 3])


# --- Checks of poses for other rooms.

# Largest defect of a pose, as of rotations, and the largest that is not corrected.
_RIGID, _ROUNDING = 1e-6, 1e-14


def pose_of(value: ArrayLike, what: str) -> Floats:
    """Return a pose (4, 4) given as a matrix, or as (dx, dy, dz, roll, pitch, yaw)."""
    if isinstance(value, Mapping):  # a table of a file
        raise BadArgument(f"{what} must be [dx, dy, dz, roll, pitch, yaw] or four rows of four, got {quoted(value)}")
    array = as_floats(value, (), what)
    if array.shape == (6,):
        return join_poses(matrix_from_rpy(array[3:]), array[:3])
    if array.shape != (4, 4):
        raise WrongShape(what, "(6,) or (4, 4)", array.shape)
    try:
        return rigid_poses(array, what)
    except NotARotation as error:
        raise BadArgument(str(error)) from None


def rigid_poses(T: ArrayLike, what: str) -> Floats:
    """Return a copy of poses of shape (..., 4, 4) with the nearest rotations; raise for the first one not rigid."""
    poses = as_floats(T, (4, 4), what)
    off = refuse_not_rigid(poses, what).orthogonality > _ROUNDING
    nearest: Floats = poses.copy()
    if np.any(off):
        nearest[off, :3, :3] = nearest_rotation(poses[off, :3, :3])
    nearest[..., 3, :] = 0.0, 0.0, 0.0, 1.0
    return nearest


def refuse_not_rigid(T: Floats, what: str, *tolerance: float) -> RotationDefects:
    """Return the defects of the poses' rotations; raise NotARotation or BadArgument for the first one not rigid."""
    defects = check_rotation(T[..., :3, :3], *tolerance, name=what)
    wrong = np.abs(T[..., 3, :] - np.array([0.0, 0.0, 0.0, 1.0])).sum(axis=-1) > _RIGID
    if wrong.any():
        index = first_index(wrong)
        row = ", ".join(f"{value:.6g}" for value in T[index][3])
        raise BadArgument(f"{what}{at_index(index)} is not a rigid transform: its last row is {row}, not 0, 0, 0, 1")
    return defects


def as_poses(T: ArrayLike, what: str) -> tuple[Floats, Floats]:
    """Return the rotations (..., 3, 3) and the translations (..., 3) of rigid poses."""
    poses = as_floats(T, (4, 4), what)
    refuse_not_rigid(poses, what)
    return poses[..., :3, :3], poses[..., :3, 3]


def as_twists(value: ArrayLike, what: str = "twist") -> tuple[Floats, Floats]:
    """The linear and the angular part of twists, or force and moment of wrenches, shape (..., 6)."""
    six = as_floats(value, (6,), what)
    return six[..., :3], six[..., 3:]


def turned(R: Floats, v: Floats) -> Floats:
    """R v."""
    return np.asarray(np.einsum("...ij,...j->...i", R, v))


# --- Twists and wrenches in other frames, and their brackets.


def adjoint(T_ab: ArrayLike) -> Floats:
    """The matrix Ad with ξ_a = Ad ξ_b for every twist (linear; angular): Ad = [[R, [t×] R], [0, R]].

    It is Pinocchio's `SE3.toActionMatrix`. Exchanging the two halves of its rows and of its columns gives the
    `motion_matrix` of lines.

    Args:
        T_ab: pose [[R, t], [0, 1]] of frame b in frame a, shape (..., 4, 4).

    Returns:
        Ad, shape (..., 6, 6), of determinant 1.

    Source: Murray, Li and Sastry, A Mathematical Introduction to Robotic Manipulation, 2.4.2.

    Examples:
        >>> nk.screws.adjoint(nk.screws.pose(np.eye(3), [0, 0.5, 0])) @ [0, 0, 0, 0, 0, 1]
        array([0.5, 0. , 0. , 0. , 0. , 1. ])
    """
    R, t = as_poses(T_ab, "T_ab")
    return upper_blocks(R, cross_matrix(t) @ R)


def upper_blocks(J: Floats, Q: Floats) -> Floats:
    """The matrices [[J, Q], [0, J]], shape (..., 6, 6)."""
    found = np.zeros((*J.shape[:-2], 6, 6))
    found[..., :3, :3] = found[..., 3:, 3:] = J
    found[..., :3, 3:] = Q
    return found


def transform_twist(T_ab: ArrayLike, twist: ArrayLike) -> Floats:
    """The coordinates in frame a of a twist given in frame b, `adjoint(T_ab)` @ twist = (R v + t × R ω; R ω).

    Args:
        T_ab: poses [[R, t], [0, 1]], shape (..., 4, 4).
        twist: (v; ω), shape (..., 6); batch axes broadcast.

    Returns:
        Twists, shape (..., 6).

    Examples:
        >>> nk.screws.transform_twist(nk.screws.pose(np.eye(3), [0, 0.5, 0]), [0, 0, 0, 0, 0, 1])
        array([0.5, 0. , 0. , 0. , 0. , 1. ])
    """
    (R, t), (v, omega) = as_poses(T_ab, "T_ab"), as_twists(twist)
    common_batch("T_ab and twist", t.shape[:-1], v.shape[:-1])
    about = turned(R, omega)
    return np.concatenate([turned(R, v) + cross(t, about), about], axis=-1)


def transform_wrench(T_ab: ArrayLike, wrench: ArrayLike) -> Floats:
    """The coordinates in frame a of a wrench given in frame b, `lines.motion_matrix(T_ab)` @ wrench.

    It is (R f; R τ + t × R f).

    Args:
        T_ab: poses [[R, t], [0, 1]], shape (..., 4, 4).
        wrench: (f; τ), force first and the moment about the origin of b, shape (..., 6) [N, N m]; batch axes broadcast.

    Returns:
        Wrenches, shape (..., 6), the moments about the origin of a.

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

    It is the rate of change of ξ_b when ξ_b is moved by ξ_a, d/ds Ad(exp s ξ_a) ξ_b at s = 0, and the twist of the
    matrix [ξ_a] [ξ_b] − [ξ_b] [ξ_a]. Pinocchio calls it `Motion.cross`.

    Args:
        a: twists (v; ω), shape (..., 6).
        b: twists, shape (..., 6); batch axes broadcast.

    Returns:
        Twists, shape (..., 6).

    Source: Murray, Li and Sastry, A Mathematical Introduction to Robotic Manipulation, appendix A, 2.3.

    Examples:
        >>> nk.screws.bracket([0, 0, 0, 0, 0, 1], [1, 0, 0, 0, 0, 0])  # rotating about z turns a velocity along x to y
        array([0., 1., 0., 0., 0., 0.])
    """
    (v_a, omega_a), (v_b, omega_b) = as_twists(a, "twist a"), as_twists(b, "twist b")
    common_batch("twists a and b", v_a.shape[:-1], v_b.shape[:-1])
    return np.concatenate([cross(omega_a, v_b) + cross(v_a, omega_b), cross(omega_a, omega_b)], axis=-1)


def dual_bracket(twist: ArrayLike, wrench: ArrayLike) -> Floats:
    """The rate of change of a wrench that is moved by a twist: (ω × f; ω × τ + v × f).

    It is the negative dual of the bracket, dual_bracket(ξ, w)·η = −w·bracket(ξ, η), so the power w·η is constant when w
    and η are both moved. Pinocchio calls it `Motion.cross` of a `Force`.

    Args:
        twist: (v; ω), shape (..., 6).
        wrench: (f; τ), shape (..., 6); batch axes broadcast.

    Returns:
        Wrenches, shape (..., 6).

    Source: Featherstone, Rigid Body Dynamics Algorithms, 2.9.

    Examples:
        >>> nk.screws.dual_bracket([0, 0, 0, 0, 0, 1], [10, 0, 0, 0, 0, 0])
        array([ 0., 10.,  0.,  0.,  0.,  0.])
    """
    (v, omega), (f, tau) = as_twists(twist), as_twists(wrench, "wrench")
    common_batch("twist and wrench", v.shape[:-1], f.shape[:-1])
    return np.concatenate([cross(omega, f), cross(omega, tau) + cross(v, f)], axis=-1)


# --- Unit dual quaternions r + ε d: eight numbers (r; d), scalar first, rotation r and translation t in d = ½ t r.
#
# q and −q are the same motion. Dual quaternions of any non-zero length are accepted, and divided by the length of r;
# for a unit one r·d = 0.

# As for rotation matrices, rounding to float32 is accepted.
_TOLERANCE = 1e-6


def dual_quat_from_pose(T_ab: ArrayLike) -> Floats:
    """Unit dual quaternion of a pose, r + ε ½ t r, with the canonical sign of r.

    Args:
        T_ab: poses [[R, t], [0, 1]], shape (..., 4, 4).

    Returns:
        (r; d), shape (..., 8), with d in units of length.

    Source: Kavan, Collins, O'Sullivan and Zara, Dual quaternions for rigid transformation blending, TCD-CS-2006-46.

    Examples:
        >>> nk.screws.dual_quat_from_pose(nk.screws.pose(nk.rotations.rot_x(np.pi), [0, 0, 2]))
        array([0., 1., 0., 0., 0., 0., 1., 0.])
    """
    R, t = as_poses(T_ab, "T_ab")
    r = quat_from_matrix(R)
    return np.concatenate([r, quat_multiply(_pure(0.5 * t), r) + 0.0], axis=-1)


def pose_from_dual_quat(q: ArrayLike) -> Floats:
    """The pose of a dual quaternion, R of r and t = 2 d r*, both divided by ‖r‖².

    Args:
        q: (r; d), shape (..., 8), of any length but zero.

    Returns:
        Poses, shape (..., 4, 4).

    Raises:
        BadArgument: r·d is not zero to 1e-6: q is not a rigid motion.

    Examples:
        >>> nk.screws.pose_from_dual_quat([0, 1, 0, 0, 0, 0, 1, 0])[:3, 3]
        array([0., 0., 2.])
    """
    r, d = _unit(q)
    t = 2.0 * quat_multiply(d, quat_conjugate(r))[..., 1:]
    return join_poses(matrix_from_quat(r), t)


def dual_quat_multiply(p: ArrayLike, q: ArrayLike) -> Floats:
    """The product p q = (r_p r_q; r_p d_q + d_p r_q): first the motion q, then p.

    Args:
        p: dual quaternions, shape (..., 8), of any length.
        q: dual quaternions; batch axes broadcast.

    Returns:
        Dual quaternions, shape (..., 8).

    Examples:
        >>> half = nk.screws.dual_quat_from_pose(nk.screws.pose(np.eye(3), [0, 0, 1]))
        >>> nk.screws.pose_from_dual_quat(nk.screws.dual_quat_multiply(half, half))[:3, 3]
        array([0., 0., 2.])
    """
    P, Q = as_floats(p, (8,), "dual quaternion p"), as_floats(q, (8,), "dual quaternion q")
    common_batch("dual quaternions p and q", P.shape[:-1], Q.shape[:-1])
    real = quat_multiply(P[..., :4], Q[..., :4])
    return np.concatenate(
        [real, quat_multiply(P[..., :4], Q[..., 4:]) + quat_multiply(P[..., 4:], Q[..., :4])], axis=-1
    )


def _pure(v: Floats) -> Floats:
    """The quaternions (0, v)."""
    return np.concatenate([np.zeros((*v.shape[:-1], 1)), v], axis=-1)


def _unit(q: ArrayLike) -> tuple[Floats, Floats]:
    """Return real and dual part, divided by the length of the real part; refuse anything but rigid motions."""
    Q = as_floats(q, (8,), "dual quaternion")
    r, length = unit(Q[..., :4], "dual quaternion")
    d = Q[..., 4:] / length[..., None]
    product = dot(r, d)
    wrong = ~(np.abs(product) <= _TOLERANCE * np.maximum(1.0, norm(d)))
    if wrong.any():
        index = first_index(wrong)
        raise BadArgument(f"r·d of a unit dual quaternion must be zero, got {product[index]:.3g}{at_index(index)}")
    return r, d - product[..., None] * r
