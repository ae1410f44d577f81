"""Spherical linear interpolation between two quaternions, along the shorter arc or the longer one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats
from nao_kin._common.kernels import Functions, Number, evaluate, rescaled
from nao_kin._common.vectors import as_batch, common_batch, first_index, unit
from nao_kin.errors import BadArgument, UnknownName, at_index
from nao_kin.rotations._checks import as_exponent

Arc = Literal["shorter", "longer"]

# The sine of half the angle up to which two rotations count as equal.
_SAME = 4.0 * 2.0**-52


def slerp(p: ArrayLike, q: ArrayLike, t: ArrayLike, *, arc: Arc = "shorter") -> Floats:
    """The rotation a part t of the way from p to q along the shorter or the longer arc, at constant angular velocity.

    cos(t θ) p + sin(t θ) w/‖w‖, with w = q − (p·q) p the part of q at right angles to p and θ = atan2(‖w‖, p·q) the
    angle between the unit quaternions, q replaced by −q where p·q < 0. It is (sin((1 − t) θ) p + sin(t θ) q)/sin θ,
    but of unit length for every t. Where p·q = 0 (half a turn apart) both arcs are equally long; q is taken as given
    by the shorter one, −q by the longer. The longer arc turns the other way round, by 2π less the angle between p and
    q; between equal rotations it is a whole turn about no axis in particular, and is refused.

    Args:
        p: quaternions at t = 0, shape (..., 4), of any length but zero.
        q: quaternions at t = 1, shape (..., 4); broadcasts with p.
        t: shape (...), broadcasts with p and q; outside [0, 1] the motion goes on past its ends.
        arc: "shorter" or "longer".

    Returns:
        Unit quaternions, shape (..., 4); continuous in t, so not of canonical sign.

    Raises:
        ZeroNorm: a zero quaternion; carries its index.
        UnknownName: no such arc.
        BadArgument: the longer arc between rotations that are equal to rounding (the sine of half the angle between
            them is at most 4 × 2⁻⁵²), with the index; not numbers, t outside ±1e15.
        WrongShape, NotFinite: wrong or mismatched shapes, NaN or infinity.

    Source: Shoemake, Animating rotation with quaternion curves, SIGGRAPH 1985.

    Examples:
        >>> quarter = nk.rotations.quat_from_matrix(nk.rotations.rot_z(np.pi / 2))
        >>> half_way = nk.rotations.slerp([1, 0, 0, 0], quarter, 0.5)
        >>> nk.rotations.natural_invariants(nk.rotations.matrix_from_quat(half_way))
        (array([0., 0., 1.]), array(0.7854))
        >>> long_way = nk.rotations.slerp([1, 0, 0, 0], quarter, 0.5, arc="longer")
        >>> nk.rotations.natural_invariants(nk.rotations.matrix_from_quat(long_way))
        (array([ 0.,  0., -1.]), array(2.3562))
    """
    if not isinstance(arc, str) or arc not in ("shorter", "longer"):
        raise UnknownName("arc", arc, ("shorter", "longer"))
    P, Q, parts = as_batch(p, (4,), "quaternion p"), as_batch(q, (4,), "quaternion q"), as_exponent(t, "t")
    batch = common_batch("quaternions p and q and t", P.shape[:-1], Q.shape[:-1], parts.shape)
    ends = [unit(rescaled(side, name), name)[0] for side, name in ((P, "quaternion p"), (Q, "quaternion q"))]
    inputs = [*(np.broadcast_to(end, (*batch, 4)) for end in ends), np.broadcast_to(parts, batch)[..., np.newaxis]]
    if arc == "shorter":
        return evaluate(_slerp, inputs, (4,))[0]
    found, sine = evaluate(_longer, inputs, (4,), ())
    if (sine <= _SAME).any():
        where = at_index(first_index(np.asarray(sine <= _SAME)))
        raise BadArgument(f"the longer arc between two equal rotations{where} is a whole turn about no axis")
    return found


def _slerp(f: Functions, *components: Number) -> tuple[Number, ...]:
    p, t = components[:4], components[8]
    aside, sine, shift = _apart(f, p, components[4:8])
    theta = f.atan2(sine, 1.0 + shift)
    # Where the squares have underflowed the arc is a straight line.
    same = sine == 0.0
    along = f.cos(t * theta)
    across = f.where(same, t, f.sin(t * theta) / f.where(same, 1.0, sine))
    return tuple(along * a + across * w for a, w in zip(p, aside, strict=True))


def _longer(f: Functions, *components: Number) -> tuple[Number, ...]:
    p, t = components[:4], components[8]
    aside, sine, shift = _apart(f, p, components[4:8])
    # To the negative of what the shorter arc goes to, and so the other way.
    theta = f.atan2(sine, -1.0 - shift)
    along = f.cos(t * theta)
    across = f.sin(t * theta) / f.where(sine == 0.0, -1.0, -sine)
    return *(along * a + across * w for a, w in zip(p, aside, strict=True)), sine


def _apart(f: Functions, p: Sequence[Number], q: Sequence[Number]) -> tuple[list[Number], Number, Number]:
    """The part of ±q at right angles to p, its length, and p·(±q) − 1; of ±q the one nearer to p."""
    sign = f.where(_inner(p, q) < 0.0, -1.0, 1.0)
    difference = [sign * b - a for a, b in zip(p, q, strict=True)]
    # From the difference, which is exact where the two are nearly equal.
    shift = _inner(p, difference)
    aside = [d - shift * a for a, d in zip(p, difference, strict=True)]
    return aside, f.sqrt(_inner(aside, aside)), shift


def _inner(a: Sequence[Number], b: Sequence[Number]) -> Number:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
