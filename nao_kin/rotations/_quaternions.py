"""Unit quaternions, scalar first: (r0, r1, r2, r3) = (cos φ/2, e sin φ/2), the Euler–Rodrigues parameters."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, as_floats, choice, common_batch, dot, first_index, unit
from nao_kin._core.kernels import Functions, Number, evaluate, rescaled
from nao_kin.errors import BadArgument, WrongShape, ZeroNorm, at_index
from nao_kin.rotations._checks import evaluate_normalised, evaluate_rotations
from nao_kin.rotations._elementary import from_quaternion

# --- Kernels from matrices to quaternions, and from quaternions to axes and half angles.


def quaternion_of(f: Functions, *m: Number) -> tuple[Number, ...]:
    """The kernel from nine entries to the unit quaternion in canonical sign."""
    m00, m01, m02, m10, m11, m12, m20, m21, m22 = m
    # The symmetric matrix 4 r rᵀ.
    plus, minus = 1.0 + m00, 1.0 - m00
    sum_, difference = m11 + m22, m11 - m22
    d0, d1, d2, d3 = plus + sum_, plus - sum_, minus + difference, minus - difference
    d01, d02, d03 = m21 - m12, m02 - m20, m10 - m01
    d12, d13, d23 = m10 + m01, m02 + m20, m21 + m12
    upper = d0 >= d1
    a0, a1 = f.where(upper, d0, d01), f.where(upper, d01, d1)
    a2, a3 = f.where(upper, d02, d12), f.where(upper, d03, d13)
    lower = d2 >= d3
    b0, b1 = f.where(lower, d02, d03), f.where(lower, d12, d13)
    b2, b3 = f.where(lower, d2, d23), f.where(lower, d23, d3)
    first_pair = f.larger(d0, d1) >= f.larger(d2, d3)
    r0, r1 = f.where(first_pair, a0, b0), f.where(first_pair, a1, b1)
    r2, r3 = f.where(first_pair, a2, b2), f.where(first_pair, a3, b3)
    scale = _canonical_sign(f, r0, r1, r2) / f.sqrt(r0 * r0 + r1 * r1 + r2 * r2 + r3 * r3)
    # Adding 0.0 turns −0.0 into 0.0.
    return r0 * scale + 0.0, r1 * scale + 0.0, r2 * scale + 0.0, r3 * scale + 0.0


def axis_and_half_angle(f: Functions, r0: Number, r1: Number, r2: Number, r3: Number) -> tuple[Number, ...]:
    """The kernel from a quaternion to the unit vector along r, zero if r is zero, and atan2(‖r‖, r0)."""
    norm = f.sqrt(r1 * r1 + r2 * r2 + r3 * r3)
    divisor = f.where(norm > 0.0, norm, 1.0)
    return r1 / divisor, r2 / divisor, r3 / divisor, f.atan2(norm, r0)


def _canonical_sign(f: Functions, r0: Number, r1: Number, r2: Number) -> Number:
    # Where these three are zero, the last component is the largest: it is a diagonal entry of 4 r rᵀ, and positive.
    first, zero = r0, r0 == 0.0
    if f.some(zero):
        first = f.where(zero, f.where(r1 != 0.0, r1, r2), r0)
    return f.where(first < 0.0, -1.0, 1.0)


# --- Unit quaternions, scalar first: (r0, r1, r2, r3) = (cos φ/2, e sin φ/2), the Euler–Rodrigues parameters.


def quat_from_matrix(R: ArrayLike) -> Floats:
    """Unit quaternion of a rotation, in canonical sign.

    4 r rᵀ is linear in R; its row with the largest diagonal entry, normalised, is r. No component is ever divided by a
    small one, so each is accurate to a few 1e-16, and for small angles the vector part also relative to its own size.

    Args:
        R: rotation matrices, shape (..., 3, 3).

    Returns:
        Quaternions (r0, r1, r2, r3), shape (..., 4), whose first non-zero component is positive.

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 2.3.6.

    Examples:
        >>> nk.rotations.quat_from_matrix(nk.rotations.rot_z(np.pi / 2))
        array([0.7071, 0.    , 0.    , 0.7071])
    """
    return evaluate_rotations(quaternion_of, R, (4,))[0]


def matrix_from_quat(q: ArrayLike) -> Floats:
    """Rotation matrix of a quaternion, R = (r0² − r·r) 1 + 2 r rᵀ + 2 r0 [r×] with (r0, r) = q/‖q‖.

    Args:
        q: quaternions (r0, r1, r2, r3) of any length but zero, shape (..., 4).

    Returns:
        Rotation matrices, shape (..., 3, 3).

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 2.3.6.

    Examples:
        >>> nk.rotations.matrix_from_quat([1, 0, 0, 1])[0].round(12) + 0.0  # 90° about z
        array([ 0., -1.,  0.])
    """
    return evaluate_normalised(from_quaternion, as_floats(q, (4,), "quaternion"), "quaternion")


def quat_multiply(p: ArrayLike, q: ArrayLike) -> Floats:
    """Hamilton's product p q = (p0 q0 − p·q, p0 q + q0 p + p × q): first the rotation q, then p.

    Args:
        p: quaternions, shape (..., 4), of any length.
        q: quaternions, shape (..., 4); broadcasts with p.

    Returns:
        Quaternions, shape (..., 4); ‖p q‖ = ‖p‖ ‖q‖.

    Source: Angeles, Fundamentals of Robotic Mechanical Systems, 2.3.6.

    Examples:
        >>> nk.rotations.quat_multiply([0, 1, 0, 0], [0, 0, 1, 0])  # i j = k
        array([0., 0., 0., 1.])
    """
    P, Q = as_floats(p, (4,), "quaternion p"), as_floats(q, (4,), "quaternion q")
    batch = common_batch("quaternions p and q", P.shape[:-1], Q.shape[:-1])
    return evaluate(_product, [np.broadcast_to(side, (*batch, 4)) for side in (P, Q)], (4,))[0]


def quat_conjugate(q: ArrayLike) -> Floats:
    """The conjugate (r0, −r1, −r2, −r3); for a unit quaternion the inverse rotation.

    Args:
        q: quaternions, shape (..., 4).

    Returns:
        Quaternions, shape (..., 4).

    Examples:
        >>> nk.rotations.quat_conjugate([0.8, 0.6, 0.0, 0.0])
        array([ 0.8, -0.6,  0. ,  0. ])
    """
    return as_floats(q, (4,), "quaternion") * [1.0, -1.0, -1.0, -1.0] + 0.0


def quat_canonical(q: ArrayLike) -> Floats:
    """Return q or −q, which are the same rotation: the one whose first non-zero component is positive.

    Args:
        q: quaternions of any length but zero, shape (..., 4).

    Returns:
        Quaternions of the same length, shape (..., 4).

    Examples:
        >>> nk.rotations.quat_canonical([-0.8, 0.6, 0.0, 0.0])
        array([ 0.8, -0.6,  0. ,  0. ])
    """
    quats = as_floats(q, (4,), "quaternion")
    nonzero = quats != 0.0
    if not nonzero.any(axis=-1).all():
        raise ZeroNorm("quaternion", first_index(~nonzero.any(axis=-1)))
    first = np.take_along_axis(quats, nonzero.argmax(axis=-1)[..., np.newaxis], axis=-1)
    return np.where(first < 0.0, -quats, quats) + 0.0


def quat_rotate(q: ArrayLike, v: ArrayLike) -> Floats:
    """The vector rotated by a quaternion, q v q⁻¹ = v + r0 t + r × t with t = 2 r × v and (r0, r) = q/‖q‖.

    Args:
        q: quaternions (r0, r1, r2, r3) of any length but zero, shape (..., 4).
        v: vectors, shape (..., 3); broadcasts with q.

    Returns:
        Vectors, shape (..., 3): `matrix_from_quat(q) @ v`.

    Examples:
        >>> nk.rotations.quat_rotate([1, 0, 0, 1], [1.0, 0.0, 2.0]).round(12) + 0.0  # 90° about z
        array([0., 1., 2.])
    """
    quats, vectors = as_floats(q, (4,), "quaternion"), as_floats(v, (3,), "vector")
    batch = common_batch("quaternions and vectors", quats.shape[:-1], vectors.shape[:-1])
    quats, vectors = np.broadcast_to(quats, (*batch, 4)), np.broadcast_to(vectors, (*batch, 3))
    return evaluate_normalised(_rotated, quats, "quaternion", vectors, tail=(3,))


def quat_to_xyzw(q: ArrayLike) -> Floats:
    """(r0, r1, r2, r3) → (r1, r2, r3, r0): the order of Pinocchio's and Eigen's `coeffs()`, scipy and ROS.

    Args:
        q: quaternions, scalar first, shape (..., 4).

    Returns:
        Quaternions, scalar last, shape (..., 4).

    Examples:
        >>> nk.rotations.quat_to_xyzw([1, 2, 3, 4])
        array([2., 3., 4., 1.])
    """
    return as_floats(q, (4,), "quaternion")[..., [1, 2, 3, 0]]


def quat_from_xyzw(xyzw: ArrayLike) -> Floats:
    """(x, y, z, w) → (w, x, y, z): from the order of Pinocchio's and Eigen's `coeffs()`, scipy and ROS.

    Args:
        xyzw: quaternions, scalar last, shape (..., 4).

    Returns:
        Quaternions, scalar first, shape (..., 4).

    Examples:
        >>> nk.rotations.quat_from_xyzw([2, 3, 4, 1])
        array([1., 2., 3., 4.])
    """
    return as_floats(xyzw, (4,), "quaternion xyzw")[..., [3, 0, 1, 2]]


def _rotated(f: Functions, *components: Number) -> tuple[Number, ...]:
    r0, r1, r2, r3, x, y, z = components
    scale = 2.0 / f.square(r0, r1, r2, r3)
    tx, ty, tz = scale * (r2 * z - r3 * y), scale * (r3 * x - r1 * z), scale * (r1 * y - r2 * x)
    return (
        x + r0 * tx + (r2 * tz - r3 * ty),
        y + r0 * ty + (r3 * tx - r1 * tz),
        z + r0 * tz + (r1 * ty - r2 * tx),
    )


def _product(f: Functions, *components: Number) -> tuple[Number, ...]:
    p0, p1, p2, p3, q0, q1, q2, q3 = components
    return (
        p0 * q0 - (p1 * q1 + p2 * q2 + p3 * q3),
        p0 * q1 + q0 * p1 + (p2 * q3 - p3 * q2),
        p0 * q2 + q0 * p2 + (p3 * q1 - p1 * q3),
        p0 * q3 + q0 * p3 + (p1 * q2 - p2 * q1),
    )


# --- Spherical linear interpolation between two quaternions, along the shorter arc or the longer one.

Arc = Literal["shorter", "longer"]

# Two rotations count as equal up to this sine of half the angle between them.
_SAME = 4.0 * 2.0**-52


def slerp(p: ArrayLike, q: ArrayLike, t: ArrayLike, *, arc: Arc = "shorter") -> Floats:
    """The rotation at a fraction t of the shorter or the longer arc from p to q, at constant angular velocity.

    The result is cos(t θ) p + sin(t θ) w/‖w‖. Here w = q − (p·q) p is the part of q perpendicular to p, θ =
    atan2(‖w‖, p·q) is the angle between the unit quaternions, and q is replaced by −q where p·q < 0. The result equals
    (sin((1 − t) θ) p + sin(t θ) q)/sin θ, but has unit length for every t. If p·q = 0 (half a turn apart) both arcs are
    equally long; the shorter uses q as given, the longer −q. The longer arc is the rotation in the opposite direction.

    Args:
        p: quaternions at t = 0, shape (..., 4), of any length but zero.
        q: quaternions at t = 1, shape (..., 4); broadcasts with p.
        t: shape (...), broadcasts with p and q; may be outside [0, 1].
        arc: "shorter" or "longer".

    Returns:
        Unit quaternions, shape (..., 4); continuous in t, so not of canonical sign.

    Raises:
        BadArgument: the longer arc between rotations that are equal to rounding (sin(φ/2) ≤ 4 × 2⁻⁵²), a whole turn
            without an axis.

    Source: Shoemake, Animating rotation with quaternion curves, SIGGRAPH 1985.

    Examples:
        >>> quarter = nk.rotations.quat_from_matrix(nk.rotations.rot_z(np.pi / 2))
        >>> half_way = nk.rotations.slerp([1, 0, 0, 0], quarter, 0.5)
        >>> nk.rotations.natural_invariants(nk.rotations.matrix_from_quat(half_way))
        (array([0., 0., 1.]), array(0.7854))
    """
    choice(arc, ("shorter", "longer"), "arc")
    P, Q, parts = as_floats(p, (4,), "quaternion p"), as_floats(q, (4,), "quaternion q"), as_floats(t, (), "t")
    batch = common_batch("quaternions p and q and t", P.shape[:-1], Q.shape[:-1], parts.shape)
    ends = [unit(rescaled(side, name), name)[0] for side, name in ((P, "quaternion p"), (Q, "quaternion q"))]
    inputs = [*(np.broadcast_to(end, (*batch, 4)) for end in ends), np.broadcast_to(parts, batch)[..., np.newaxis]]
    if arc == "shorter":
        return evaluate(_slerp, inputs, (4,))[0]
    found, sine = evaluate(_longer, inputs, (4,), ())
    if (sine <= _SAME).any():
        where = at_index(first_index(np.asarray(sine <= _SAME)))
        raise BadArgument(f"the longer arc between two equal rotations{where} is a whole turn without a definite axis")
    return found


def _slerp(f: Functions, *components: Number) -> tuple[Number, ...]:
    p, t = components[:4], components[8]
    aside, sine, shift = _apart(f, p, components[4:8])
    theta = f.atan2(sine, 1.0 + shift)
    # If the squares have underflowed, the arc is taken as a straight line.
    same = sine == 0.0
    along = f.cos(t * theta)
    across = f.where(same, t, f.sin(t * theta) / f.where(same, 1.0, sine))
    return tuple(along * a + across * w for a, w in zip(p, aside, strict=True))


def _longer(f: Functions, *components: Number) -> tuple[Number, ...]:
    p, t = components[:4], components[8]
    aside, sine, shift = _apart(f, p, components[4:8])
    # The longer arc ends at the negative of the end of the shorter arc, and so runs in the opposite direction.
    theta = f.atan2(sine, -1.0 - shift)
    along = f.cos(t * theta)
    across = f.sin(t * theta) / f.where(sine == 0.0, -1.0, -sine)
    return *(along * a + across * w for a, w in zip(p, aside, strict=True)), sine


def _apart(f: Functions, p: Sequence[Number], q: Sequence[Number]) -> tuple[list[Number], Number, Number]:
    """The part of ±q at right angles to p, its length, and p·(±q) − 1; ±q is q or −q, whichever is nearer to p."""
    sign = f.where(_inner(p, q) < 0.0, -1.0, 1.0)
    difference = [sign * b - a for a, b in zip(p, q, strict=True)]
    # Computed from the difference, which is exact if the two are nearly equal.
    shift = _inner(p, difference)
    aside = [d - shift * a for a, d in zip(p, difference, strict=True)]
    return aside, f.sqrt(_inner(aside, aside)), shift


def _inner(a: Sequence[Number], b: Sequence[Number]) -> Number:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]


# --- Signs of quaternions: q and −q are the same rotation.


def quat_unwrap(q: ArrayLike) -> Floats:
    """Return the quaternions of a path with signs that make it continuous: q · previous ≥ 0; the first keeps its sign.

    The rotations do not change. At exactly half a turn, where both signs are equally near, the sign relative to the
    previous quaternion stays as given.

    Args:
        q: quaternions of any length but zero along a path, shape (..., n, 4).

    Returns:
        Quaternions of the same lengths and shape.

    Examples:
        >>> nk.rotations.quat_unwrap([[1.0, 0.0, 0.0, 0.0], [-0.96, 0.0, 0.0, -0.28]])[:, 0].tolist()
        [1.0, 0.96]
    """
    quats = as_floats(q, (4,), "quaternion")
    if quats.ndim < 2:
        raise WrongShape("quaternions of a path", "(..., n, 4)", quats.shape)
    path = rescaled(quats, "quaternion")
    flips = np.ones(path.shape[:-1])
    flips[..., 1:] = np.where(dot(path[..., 1:, :], path[..., :-1, :]) < 0.0, -1.0, 1.0)
    return np.asarray(quats * np.cumprod(flips, axis=-1)[..., np.newaxis] + 0.0)
