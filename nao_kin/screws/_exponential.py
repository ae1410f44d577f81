"""Twists, screws and the motions they generate: exponential, logarithm, the Jacobians of SE(3), interpolation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin import rotations
from nao_kin._core.arrays import (
    Floats,
    as_floats,
    choice,
    common_batch,
    cross,
    cross_matrix,
    dot,
    first_index,
    join_poses,
    unit,
)
from nao_kin._core.kernels import (
    WHOLE_TURN,
    evaluate,
    inverse_coefficients,
    jacobian_coefficients,
    jacobian_derivatives,
)
from nao_kin._core.text import one_line_repr
from nao_kin.errors import BadArgument, SingularMatrix, at_index
from nao_kin.screws._poses import as_poses, as_twists, turned, upper_blocks
from nao_kin.screws.lines import PluckerLine

# Largest difference of a 4 × 4 matrix from the form of a twist, relative to its largest entry.
_FORM = 1e-9


def exp(twist: ArrayLike) -> Floats:
    """The displacement of a body in unit time under a constant twist: exp [ξ] = [[exp [ω×], J(ω) v], [0, 1]].

    J(ω) = 1 + (1 − cos θ)/θ² [ω×] + (θ − sin θ)/θ³ [ω×]² with θ = ‖ω‖, the left Jacobian of SO(3). Every entry is
    accurate to a few 1e-16 · max(1, θ), in the last column times ‖v‖, also at θ = 0 and π.

    Args:
        twist: ξ = (v; ω), linear part first as in `RobotModel.jacobian` and Pinocchio, shape (..., 6) [m, rad];
            v the velocity of the point of the body at the origin.

    Returns:
        Poses, shape (..., 4, 4).

    Source: Murray, Li and Sastry, A Mathematical Introduction to Robotic Manipulation, 2.3.2.

    Examples:
        >>> nk.screws.exp([0, 0, 0.5, 0, 0, np.pi / 2])[[0, 2]]  # a quarter turn about z, and half a metre along it
        array([[ 0. , -1. ,  0. ,  0. ],
               [ 0. ,  0. ,  1. ,  0.5]])
    """
    return motion_of(*as_twists(twist))


def log(T_ab: ArrayLike) -> Floats:
    """The twist of a motion, ξ = (v; ω) with exp [ξ] = T: ω = log R with ‖ω‖ in [0, π], v = J(ω)⁻¹ t.

    J(ω)⁻¹ = 1 − ½ [ω×] + (1 − (θ/2) cot(θ/2))/θ² [ω×]². For matrices exact to rounding ω is accurate to a few 1e-16 and
    v to a few 1e-16 · ‖t‖, at θ = 0 and π too; small angles also relative to themselves.

    Args:
        T_ab: poses [[R, t], [0, 1]], shape (..., 4, 4).

    Returns:
        Twists (linear; angular), shape (..., 6) [m, rad]. At θ = π the first non-zero component of ω is positive.

    Source: Murray, Li and Sastry, A Mathematical Introduction to Robotic Manipulation, 2.3.2.

    Examples:
        >>> nk.screws.log(nk.screws.pose(nk.rotations.rot_z(np.pi / 2), [0, 0, 0.5]))
        array([0.    , 0.    , 0.5   , 0.    , 0.    , 1.5708])
    """
    return np.concatenate(log_parts(*as_poses(T_ab, "T_ab")), axis=-1)


def hat(twist: ArrayLike) -> Floats:
    """The matrix [ξ] = [[[ω×], v], [0, 0]] of a twist, whose matrix exponential is the motion.

    Args:
        twist: (v; ω), shape (..., 6).

    Returns:
        Matrices, shape (..., 4, 4).

    Examples:
        >>> nk.screws.hat([1, 2, 3, 0, 0, 4])[0]
        array([ 0., -4.,  0.,  1.])
    """
    v, omega = as_twists(twist)
    found = np.zeros((*v.shape[:-1], 4, 4))
    found[..., :3, :3] = cross_matrix(omega) + 0.0
    found[..., :3, 3] = v
    return found


def vee(matrix: ArrayLike) -> Floats:
    """The twist (v; ω) of a matrix [[[ω×], v], [0, 0]], the inverse of `hat`.

    Args:
        matrix: shape (..., 4, 4), with a skew-symmetric part [ω×] and a last row of zeros.

    Returns:
        Twists, shape (..., 6).

    Raises:
        BadArgument: it differs from that form by more than 1e-9 of its largest entry; smaller errors are averaged out.

    Examples:
        >>> nk.screws.vee(nk.screws.hat([1, 2, 3, 0, 0, 4]))
        array([1., 2., 3., 0., 0., 4.])
    """
    matrices = as_floats(matrix, (4, 4), "matrix")
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


def motion_of(v: Floats, omega: Floats) -> Floats:
    """The pose exp [(v; ω)]."""
    B, C = evaluate(jacobian_coefficients, [dot(omega, omega)[..., None]], (), ())
    across = cross(omega, v)
    t = v + B[..., None] * across + C[..., None] * cross(omega, across)
    return join_poses(rotations.exp(omega), t)


def log_parts(R: Floats, t: Floats) -> tuple[Floats, Floats]:
    """Return the linear and the angular part of the logarithm of a motion, after checking the motion."""
    omega = rotations.log(R)
    D, _, _ = evaluate(inverse_coefficients, [dot(omega, omega)[..., None]], (), (), ())
    across = cross(omega, t)
    return t - 0.5 * across + D[..., None] * cross(omega, across), omega


# --- The Jacobians of the exponential of SE(3), left and right, and their inverses.
#
# A motion of SE(3) is a rotation in dual numbers: with ω + ε v in the place of ω, the formulas of SO(3) give the 3 ×
# 3 blocks of SE(3). Block Q below is the derivative of J(ω) along v.


def left_jacobian(twist: ArrayLike) -> Floats:
    """The matrix J with exp [ξ + δ] = exp [J δ] exp [ξ] for small δ: [[J(ω), Q], [0, J(ω)]].

    J(ω) = 1 + B [ω×] + C [ω×]² is that of SO(3), with B = (1 − cos θ)/θ², C = (θ − sin θ)/θ³, and
    Q = B [v×] + C ([ω×][v×] + [v×][ω×]) + (ω·v) (B'/θ [ω×] + C'/θ [ω×]²) with the derivatives by θ = ‖ω‖.
    J ξ̇ is the velocity of the body with the pose exp [ξ], in the fixed frame. J = ∫₀¹ Ad(exp [s ξ]) ds.

    Args:
        twist: ξ = (v; ω), linear part first, shape (..., 6) [m, rad].

    Returns:
        J, shape (..., 6, 6), for twists (linear; angular) on both sides.

    Source: Barfoot, State Estimation for Robotics, 7.1.5, for another form of Q.

    Examples:
        >>> xi = np.array([0.1, 0.2, 0.3, 0, 0, 1])
        >>> nk.screws.left_jacobian(xi) @ xi  # J ξ = ξ
        array([0.1, 0.2, 0.3, 0. , 0. , 1. ])
    """
    v, omega = as_twists(twist)
    square = dot(omega, omega)[..., None]
    B, C, dB, dC = (c[..., None, None] for c in evaluate(jacobian_derivatives, [square], (), (), (), ()))
    W, V, W2, WV, along = _products(v, omega)
    return upper_blocks(np.eye(3) + B * W + C * W2, B * V + C * WV + along * (dB * W + dC * W2))


def right_jacobian(twist: ArrayLike) -> Floats:
    """The matrix J with exp [ξ + δ] = exp [ξ] exp [J δ] for small δ: `left_jacobian` of −ξ; Pinocchio's `Jexp6`.

    J ξ̇ is the velocity of the body with the pose exp [ξ], in the body's frame.

    Args:
        twist: ξ = (v; ω), linear part first, shape (..., 6) [m, rad].

    Returns:
        J, shape (..., 6, 6), for twists (linear; angular) on both sides.

    Examples:
        >>> xi, delta = np.array([0.1, 0.2, 0.3, 0, 0, 1]), np.array([0, 0, 0, 1e-6, 0, 0])
        >>> change = nk.screws.inverse(nk.screws.exp(xi)) @ nk.screws.exp(xi + delta)
        >>> bool(np.allclose(nk.screws.log(change), nk.screws.right_jacobian(xi) @ delta, atol=1e-11))
        True
    """
    return left_jacobian(-as_floats(twist, (6,), "twist"))


def left_jacobian_inverse(twist: ArrayLike) -> Floats:
    """The inverse of `left_jacobian`: log(exp [δ] T) = ξ + J⁻¹ δ for small δ and ξ = log T.

    [[J⁻¹, Q'], [0, J⁻¹]] with J⁻¹ = 1 − ½ [ω×] + D [ω×]², D = (1 − (θ/2) cot(θ/2))/θ², and
    Q' = −½ [v×] + D ([ω×][v×] + [v×][ω×]) + (ω·v) D'/θ [ω×]².

    Args:
        twist: ξ = (v; ω), linear part first, shape (..., 6) [m, rad].

    Returns:
        J⁻¹, shape (..., 6, 6), for twists (linear; angular) on both sides.

    Raises:
        SingularMatrix: ‖ω‖ is a multiple of 2π other than 0, up to its rounding.

    Source: Barfoot, State Estimation for Robotics, 7.1.5, for the blocks in another form.

    Examples:
        >>> xi = [0.1, 0.2, 0.3, 0, 0, 1]
        >>> bool(np.allclose(nk.screws.left_jacobian_inverse(xi) @ nk.screws.left_jacobian(xi), np.eye(6)))
        True
    """
    v, omega = as_twists(twist)
    D, dD, opening = evaluate(inverse_coefficients, [dot(omega, omega)[..., None]], (), (), ())
    whole = np.asarray(np.abs(opening) <= WHOLE_TURN)
    if whole.any():
        raise SingularMatrix("Jacobian of the exponential", "‖ω‖ is a multiple of 2π", first_index(whole))
    D, dD = D[..., None, None], dD[..., None, None]
    W, V, W2, WV, along = _products(v, omega)
    return upper_blocks(np.eye(3) - 0.5 * W + D * W2, -0.5 * V + D * WV + along * dD * W2)


def right_jacobian_inverse(twist: ArrayLike) -> Floats:
    """The inverse of `right_jacobian`: log(T exp [δ]) = ξ + J⁻¹ δ for small δ and ξ = log T; Pinocchio's `Jlog6`.

    Args:
        twist: ξ = (v; ω), linear part first, shape (..., 6) [m, rad].

    Returns:
        J⁻¹, shape (..., 6, 6), for twists (linear; angular) on both sides: `left_jacobian_inverse` of −ξ.

    Raises:
        SingularMatrix: ‖ω‖ is a multiple of 2π other than 0, up to its rounding.

    Examples:
        >>> xi = np.array([0.1, 0.2, 0.3, 0, 0, 1])
        >>> bool(np.array_equal(nk.screws.right_jacobian_inverse(xi), nk.screws.left_jacobian_inverse(-xi)))
        True
    """
    return left_jacobian_inverse(-as_floats(twist, (6,), "twist"))


def _products(v: Floats, omega: Floats) -> tuple[Floats, ...]:
    """[ω×], [v×], [ω×]², [ω×][v×] + [v×][ω×] and ω·v; by [a×][b×] = b aᵀ − (a·b) 1, at half the cost of a product."""
    along, outer = dot(omega, v)[..., None, None], v[..., :, None] * omega[..., None, :]
    W2 = omega[..., :, None] * omega[..., None, :] - dot(omega, omega)[..., None, None] * np.eye(3)
    WV = outer + np.swapaxes(outer, -1, -2) - 2.0 * along * np.eye(3)
    return cross_matrix(omega), cross_matrix(v), W2, WV, along


# --- Interpolation of poses along a screw.


def sclerp(T_0: ArrayLike, T_1: ArrayLike, s: ArrayLike, *, arc: Literal["shorter", "longer"] = "shorter") -> Floats:
    """The pose at a fraction s of the screw motion from T_0 to T_1, T_0 exp(s log(T_0⁻¹ T_1)), at constant speed.

    The body rotates about a line and slides along it, both in proportion to s; the orientation is that of slerp. The
    path does not depend on the frames in which it is expressed.

    Args:
        T_0: poses at s = 0, shape (..., 4, 4).
        T_1: poses at s = 1; batch axes broadcast.
        s: shape (...), broadcasts with the poses; may be outside [0, 1].
        arc: "shorter", or "longer" to rotate by θ − 2π about the same line instead of by θ ≤ π, with the same slide
            along it. At θ = π, where both are equally long, the shorter one has the axis whose first non-zero component
            is positive, in frame 0.

    Returns:
        Poses, shape (..., 4, 4).

    Raises:
        BadArgument: the longer arc between two poses that differ by a translation alone, which determines no line.

    Source: Kavan, Collins, O'Sullivan and Zara, Dual quaternions for rigid transformation blending, TCD-CS-2006-46.

    Examples:
        >>> T_0, T_1 = np.eye(4), nk.screws.pose(nk.rotations.rot_z(np.pi), [2, 0, 0.4])
        >>> nk.screws.sclerp(T_0, T_1, 0.5)[:3, 3]  # half of a half turn about the upright line through (1, 0, 0)
        array([ 1. , -1. ,  0.2])
    """
    choice(arc, ("shorter", "longer"), "arc")
    parts = as_floats(s, (), "s")
    (R_0, p_0), (R_1, p_1) = as_poses(T_0, "T_0"), as_poses(T_1, "T_1")
    common_batch("T_0, T_1 and s", p_0.shape[:-1], p_1.shape[:-1], parts.shape)
    # Computed from the difference of the origins, because two poses far from the origin may be close to each other.
    back = np.swapaxes(R_0, -1, -2)
    v, omega = log_parts(back @ R_1, turned(back, p_1 - p_0))
    if arc == "longer":
        v, omega = _the_other_way(v, omega)
    way = motion_of(parts[..., None] * v, parts[..., None] * omega)
    return join_poses(R_0 @ way[..., :3, :3], p_0 + turned(R_0, way[..., :3, 3]))


def _the_other_way(v: Floats, omega: Floats) -> tuple[Floats, Floats]:
    """The twist about the same screw axis with the angle θ − 2π and the same slide."""
    _, angle, across, translation = _axes_of(v, omega)
    if translation.any():
        index = first_index(translation)
        raise BadArgument(
            f"the poses{at_index(index)} differ by a translation alone, which determines no line to rotate about"
        )
    ratio = (1.0 - 2.0 * np.pi / angle)[..., None]
    return v - across + ratio * across, ratio * omega


def _axes_of(v: Floats, omega: Floats) -> tuple[Floats, Floats, Floats, NDArray[np.bool_]]:
    """Return directions e, angles, the part of v across e, and which twists have no axis."""
    without_turn = np.asarray((omega == 0.0).all(axis=-1))
    e, angle = unit(np.where(without_turn[..., None], 1.0, omega), "axis")
    across = cross(cross(e, v), e)
    return e, angle, across, without_turn


# --- Screws.


@one_line_repr
@dataclass(frozen=True, eq=False, init=False)
class Screw:
    """A rotation about a line with a slide along it, or a batch of them; every rigid motion is one (Chasles).

    It describes a displacement, with angle [rad] and slide [m], or a velocity, with [rad/s] and [m/s]. Immutable: the
    arrays are read-only copies. `screws[i]` indexes the batch axes.

    Attributes:
        axis: the directed line.
        angle: rotation about it, right-handed, shape (...).
        slide: translation along it, shape (...).

    Source: Murray, Li and Sastry, A Mathematical Introduction to Robotic Manipulation, 2.3.3.

    Examples:
        >>> upright = nk.screws.lines.PluckerLine.from_point_direction([1, 0, 0], [0, 0, 1])
        >>> nk.screws.Screw(upright, np.pi, 0.4).pose[:3, 3].round(9) + 0.0
        array([2. , 0. , 0.4])
    """

    axis: PluckerLine
    angle: Floats
    slide: Floats

    def __init__(self, axis: PluckerLine, angle: ArrayLike, slide: ArrayLike) -> None:
        numbers = {"angle": as_floats(angle, (), "angle"), "slide": as_floats(slide, (), "slide")}
        batch = common_batch("axis, angle and slide", axis.batch_shape, *(value.shape for value in numbers.values()))
        for name, value in numbers.items():
            own = np.array(np.broadcast_to(value, batch))
            own.setflags(write=False)
            object.__setattr__(self, name, own)
        # The axis with its own origin, in the batch shape of all three.
        object.__setattr__(self, "axis", axis.transfer_to(np.broadcast_to(axis.origin, (*batch, 3))))

    @classmethod
    def from_twist(cls, twist: ArrayLike) -> Screw:
        """The screw of a twist (v; ω): angle ‖ω‖, slide v·e, about the line along e = ω/‖ω‖ through ω × v/‖ω‖².

        A twist without ω is a translation, with infinite pitch: angle 0, slide ‖v‖, along the parallel to v through the
        origin. The zero twist gets the z axis, angle 0 and slide 0.

        Args:
            twist: (v; ω), linear part first, shape (..., 6).

        Returns:
            Screws with angle ≥ 0, about axes whose moments are about the origin of the twist's frame.

        Examples:
            >>> screw = nk.screws.Screw.from_twist([0, -2, 1, 0, 0, 2])
            >>> screw.axis.point, screw.angle.tolist(), screw.slide.tolist(), screw.pitch.tolist()
            (array([1., 0., 0.]), 2.0, 1.0, 0.5)
        """
        v, omega = as_twists(twist)
        moving = np.asarray(v.any(axis=-1))
        along, speed = unit(np.where(moving[..., None], v, [0.0, 0.0, 1.0]), "direction")
        e, angle, across, straight = _axes_of(v, omega)
        moment = np.where(straight[..., None], 0.0, across / np.where(straight, 1.0, angle)[..., None])
        return cls(
            PluckerLine(np.where(straight[..., None], along, e), moment),
            np.where(straight, 0.0, angle),
            np.where(straight, np.where(moving, speed, 0.0), dot(e, v)),
        )

    @classmethod
    def from_pose(cls, T_ab: ArrayLike) -> Screw:
        """The screw of a displacement: that of its twist `log(T_ab)`, with the angle in [0, π].

        A translation gets angle 0, about the parallel through the origin; the identity gets the z axis, angle 0 and
        slide 0. Close to either, the line is far away, and its error is the rounding of R divided by θ².

        Args:
            T_ab: poses [[R, t], [0, 1]], shape (..., 4, 4).

        Returns:
            Screws, with axes in the coordinates of frame a.

        Examples:
            >>> screw = nk.screws.Screw.from_pose(nk.screws.pose(nk.rotations.rot_z(np.pi), [2, 0, 0.4]))
            >>> screw.axis.point, screw.axis.direction, screw.slide.round(9).tolist()
            (array([1., 0., 0.]), array([0., 0., 1.]), 0.4)
        """
        return cls.from_twist(log(T_ab))

    @property
    def pitch(self) -> Floats:
        """Slide per angle, shape (...) [m/rad]: 0 for a rotation or no motion, ±∞ for a translation.

        Examples:
            >>> nk.screws.Screw.from_twist([[0, 0, 1, 0, 0, 2], [0, 0, 1, 0, 0, 0]]).pitch
            array([0.5, inf])
        """
        turning = self.angle != 0.0
        with np.errstate(over="ignore"):
            finite = self.slide / np.where(turning, self.angle, 1.0)
        return np.asarray(np.where(turning | (self.slide == 0.0), finite, np.copysign(np.inf, self.slide)))

    @property
    def twist(self) -> Floats:
        """The twist (v; ω) = (angle · moment + slide · e; angle · e) about the axis' frame, shape (..., 6).

        Examples:
            >>> nk.screws.Screw.from_twist([0, -2, 1, 0, 0, 2]).twist
            array([ 0., -2.,  1.,  0.,  0.,  2.])
        """
        v, omega = self._parts()
        return np.concatenate([v, omega], axis=-1)

    @property
    def pose(self) -> Floats:
        """The displacement by this screw, exp of its twist, shape (..., 4, 4).

        Examples:
            >>> x_axis = nk.screws.lines.PluckerLine.through([0, 0, 0], [1, 0, 0])
            >>> nk.screws.Screw(x_axis, 0, 0.5).pose[:3, 3]
            array([0.5, 0. , 0. ])
        """
        return motion_of(*self._parts())

    def __getitem__(self, index: Any) -> Screw:
        """The screws at `index`, any NumPy index over the batch axes; IndexError outside them."""
        return Screw(self.axis[index], self.angle[index], self.slide[index])

    def __reduce__(self) -> tuple[Any, ...]:
        # Default pickling would give the copy writable arrays.
        return Screw, (self.axis, self.angle, self.slide)

    def _parts(self) -> tuple[Floats, Floats]:
        about_origin = self.axis.transfer_to((0.0, 0.0, 0.0))
        angle, slide, e = self.angle[..., None], self.slide[..., None], about_origin.direction
        return angle * about_origin.moment + slide * e, angle * e
