"""The 24 three-angle conventions: 12 sequences of axes, about moving or fixed axes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, as_batch, choice, common_batch, cross, dot, first_index, norm, unit
from nao_kin._core.kernels import Functions, Kernel, Number, evaluate, rescaled
from nao_kin._core.text import one_line_repr
from nao_kin._core.warn import warn_of_degrees
from nao_kin.errors import BadArgument, UnknownName, at_index
from nao_kin.rotations._checks import as_rotations, evaluate_rotations
from nao_kin.rotations._invariants import matrix_from_natural
from nao_kin.rotations._quaternions import matrix_from_quat, quat_from_matrix

Axes = Literal["moving", "fixed"]
AtLock = Literal["first", "third"]

SEQUENCES = tuple(a + b + c for a in "xyz" for b in "xyz" for c in "xyz" if a != b != c)

# Sequences of one or two axes, which do not reach every rotation.
SHORT_SEQUENCES = (*"xyz", *(a + b for a in "xyz" for b in "xyz" if a != b))

# Below this value the two matrix entries that distinguish the first and third angles are rounding errors.
LOCK = 4.0 * 2.0**-52

# The default of required keywords such as `axes=`; without them the functions raise BadArgument.
REQUIRED: Any = None


@dataclass(frozen=True)
class Convention:
    """One of the 24 conventions as a sequence about moving axes i, j, then i or the remaining axis k."""

    i: int
    j: int
    k: int
    sign: float  # +1 where (i, j, k) is an even permutation of (x, y, z), −1 where it is odd
    symmetric: bool  # whether the third turn is about i again (proper Euler angles)
    reversed: bool  # whether the angles are given in the opposite order (fixed axes)


def _convention(sequence: str, axes: str) -> Convention:
    # Rotations about fixed axes equal those about moving axes in the opposite order.
    i, j, third = ("xyz".index(axis) for axis in (sequence if axes == "moving" else sequence[::-1]))
    return Convention(i, j, 3 - i - j, 1.0 if (j - i) % 3 == 1 else -1.0, third == i, axes == "fixed")


_CONVENTIONS = {(s, axes): _convention(s, axes) for s in SEQUENCES for axes in ("moving", "fixed")}


def find_convention(sequence: str, axes: Axes) -> Convention:
    """Return the convention of that name; refuse anything that is not exactly one of the 24."""
    if isinstance(sequence, str) and isinstance(axes, str):
        found = _CONVENTIONS.get((sequence, axes))
        if found is not None:
            return found
    if not isinstance(sequence, str) or sequence not in SEQUENCES:
        short = isinstance(sequence, str) and sequence in SHORT_SEQUENCES
        raise _unknown_sequence(sequence, SEQUENCES, "`nearest_euler` takes one or two axes" if short else "")
    raise _unknown_axes(axes)


def find_any_convention(sequence: str, axes: Axes) -> tuple[Convention, int]:
    """Return the convention and the number of angles; for one or two axes, a convention whose other angles are zero."""
    count = len(sequence) if isinstance(sequence, str) else 0
    if isinstance(sequence, str) and sequence in SHORT_SEQUENCES:
        rest = "".join(axis for axis in "xyz" if axis not in sequence)
        return find_convention((sequence + rest)[:3], axes), count
    if not isinstance(sequence, str) or sequence not in SEQUENCES:
        raise _unknown_sequence(sequence, (*SEQUENCES, *SHORT_SEQUENCES))
    return find_convention(sequence, axes), count


def find_short_sequence(sequence: str, axes: Axes) -> tuple[int, ...]:
    """Return the one or two axes as numbers, in the order in which moving axes give the same rotation."""
    if not isinstance(sequence, str) or sequence not in SHORT_SEQUENCES:
        full = isinstance(sequence, str) and sequence in SEQUENCES
        raise _unknown_sequence(sequence, SHORT_SEQUENCES, "`euler_from_matrix` takes three axes" if full else "")
    if not isinstance(axes, str) or axes not in ("moving", "fixed"):
        raise _unknown_axes(axes)
    places = tuple("xyz".index(axis) for axis in sequence)
    return places if axes == "moving" else places[::-1]


def _unknown_sequence(sequence: object, valid: tuple[str, ...], hint: str = "") -> UnknownName:
    if isinstance(sequence, str) and sequence.lower() in valid:
        hint = "letter case carries no meaning: write it in lower case and say axes='moving' or axes='fixed'"
    return UnknownName("sequence", sequence, valid, hint)


def _unknown_axes(axes: object) -> BadArgument | UnknownName:
    if axes is None:
        return BadArgument("axes= must be given: 'moving' (each axis moved by the previous rotations) or 'fixed'")
    return UnknownName("axes", axes, ("moving", "fixed"))


def composition(convention: Convention) -> Kernel:
    """The kernel (α, β, γ in the order written) → the nine entries of R."""
    i, j, k, s = convention.i, convention.j, convention.k, convention.sign

    def kernel(f: Functions, *angles: Number) -> tuple[Number, ...]:
        first, middle, third = angles[::-1] if convention.reversed else angles
        # An odd permutation of the axes mirrors space, which changes the sign of every angle.
        ca, sa = f.cos(first), s * f.sin(first)
        cb, sb = f.cos(middle), s * f.sin(middle)
        cc, sc = f.cos(third), s * f.sin(third)
        m: list[Number] = [0.0] * 9
        if convention.symmetric:
            m[3 * i + i], m[3 * i + j], m[3 * i + k] = cb, sb * sc, sb * cc
            m[3 * j + i], m[3 * k + i] = sa * sb, 0.0 - ca * sb
            u, v = ca * cb, sa * cb
            m[3 * j + j], m[3 * j + k] = ca * cc - v * sc, 0.0 - ca * sc - v * cc
            m[3 * k + j], m[3 * k + k] = sa * cc + u * sc, u * cc - sa * sc
        else:
            m[3 * i + i], m[3 * i + j], m[3 * i + k] = cb * cc, 0.0 - cb * sc, sb
            m[3 * j + k], m[3 * k + k] = 0.0 - sa * cb, ca * cb
            u, v = ca * sb, sa * sb
            m[3 * j + i], m[3 * j + j] = ca * sc + v * cc, ca * cc - v * sc
            m[3 * k + i], m[3 * k + j] = sa * sc - u * cc, sa * cc + u * sc
        return tuple(m)

    return kernel


def extraction(convention: Convention, third_is_zero: bool) -> Kernel:
    """The kernel from nine entries to both triples and the lock mask; `third_is_zero` refers to moving axes."""
    i, j, k, s = convention.i, convention.j, convention.k, convention.sign
    positive = s > 0.0

    def signed(value: Number) -> Number:
        # Adding 0.0 turns −0.0 into 0.0, which keeps atan2 off −π.
        return 0.0 + value if positive else 0.0 - value

    def kernel(f: Functions, *m: Number) -> tuple[Number, ...]:
        if convention.symmetric:
            y, x = 0.0 + m[3 * j + i], m[3 * k + i] * -s
        else:
            y, x = 0.0 - signed(m[3 * j + k]), m[3 * k + k]
        h = f.sqrt(x * x + y * y)
        locked = h <= LOCK
        some_locked = f.some(locked)
        if some_locked:
            x = f.where(locked, m[3 * j + j] if third_is_zero else 1.0, x)
            y = f.where(locked, signed(m[3 * k + j]) if third_is_zero else 0.0, y)
        first = f.atan2(y, x)
        # (x, y) is h (cos, sin) of the first angle: removing it needs no division, because atan2 ignores the scale.
        y = signed(y)
        cosine = x * m[3 * j + j] + y * m[3 * k + j]
        if convention.symmetric:
            middle = f.atan2(h, m[3 * i + i])
            third = f.atan2(0.0 - signed(x * m[3 * j + k] + y * m[3 * k + k]), cosine)
            other_middle = 0.0 - middle
        else:
            middle = f.atan2(signed(m[3 * i + k]), h)
            third = f.atan2(signed(x * m[3 * j + i] + y * m[3 * k + i]), cosine)
            other_middle = f.where(middle < 0.0, -math.pi, math.pi) - middle
        if some_locked and third_is_zero:
            third = f.where(locked, 0.0, third)
        other_first, other_third = _opposite(f, first), _opposite(f, third)
        if convention.reversed:
            first, third, other_first, other_third = third, first, other_third, other_first
        return first, middle, third, other_first, other_middle, other_third, locked

    return kernel


def _opposite(f: Functions, angle: Number) -> Number:
    return angle + f.where(angle > 0.0, -math.pi, math.pi)


# --- Rotations from three angles and back.


@one_line_repr
@dataclass(frozen=True, eq=False)
class EulerAngles:
    """The two triples of angles that give one rotation.

    Attributes:
        angles: the principal triple, shape (..., 3) [rad], in the order of the sequence as written: middle angle in
            [−π/2, π/2], or in [0, π] if the first and third axes are the same; the outer two in [−π, π].
        other: the other triple, shape (..., 3) [rad], all three in [−π, π].
        locked: shape (...); True where only the sum or the difference of the outer angles is determined.
    """

    angles: Floats
    other: Floats
    locked: NDArray[np.bool_]


def matrix_from_euler(angles: ArrayLike, sequence: str, *, axes: Axes = REQUIRED) -> Floats:
    """Rotation matrix of one, two or three rotations about coordinate axes.

    For a sequence "ijk" and angles (α, β, γ), in that order:
    moving axes, R = Ri(α) Rj(β) Rk(γ); fixed axes, R = Rk(γ) Rj(β) Ri(α).
    For "ij": moving axes, R = Ri(α) Rj(β); fixed axes, R = Rj(β) Ri(α). For "i": R = Ri(α).

    Args:
        angles: shape (..., n) for a sequence of n letters [rad]; in its order.
        sequence: one to three of "x", "y", "z", neighbours different, lower case.
        axes: "moving" or "fixed"; required.

    Returns:
        Rotation matrices, shape (..., 3, 3), active.

    Source: Craig, Introduction to Robotics, 2.8 and appendix B.

    Examples:
        >>> R = nk.rotations.matrix_from_euler([0.2, 0.3], "zy", axes="moving")
        >>> np.allclose(R, nk.rotations.rot_z(0.2) @ nk.rotations.rot_y(0.3))
        True
    """
    return _composed(angles, sequence, axes)


def _composed(angles: ArrayLike, sequence: str, axes: Axes) -> Floats:
    convention, count = find_any_convention(sequence, axes)
    values = as_batch(angles, (count,), "angles")
    warn_of_degrees(values, "angle", 2)
    if count < 3:
        values = np.concatenate([values, np.zeros((*values.shape[:-1], 3 - count))], axis=-1)
    return evaluate(composition(convention), [values], (3, 3))[0]


def quat_from_euler(angles: ArrayLike, sequence: str, *, axes: Axes = REQUIRED) -> Floats:
    """Unit quaternion of one, two or three rotations about coordinate axes.

    Args:
        angles: as in `matrix_from_euler` [rad].
        sequence: as in `matrix_from_euler`.
        axes: as in `matrix_from_euler`.

    Returns:
        Quaternions (r0, r1, r2, r3), scalar first, in canonical sign, shape (..., 4).

    Examples:
        >>> nk.rotations.quat_from_euler([0.0, 0.0, np.pi / 2], "xyz", axes="moving").round(4)
        array([0.7071, 0.    , 0.    , 0.7071])
    """
    return quat_from_matrix(_composed(angles, sequence, axes))


def euler_from_quat(q: ArrayLike, sequence: str, *, axes: Axes = REQUIRED, at_lock: AtLock = "third") -> EulerAngles:
    """Both triples of angles of the rotation of a quaternion.

    Args:
        q: quaternions (r0, r1, r2, r3), scalar first, of any length but zero, shape (..., 4).
        sequence: as in `euler_from_matrix`.
        axes: as in `euler_from_matrix`.
        at_lock: as in `euler_from_matrix`.

    Returns:
        Principal triple, other triple and lock mask.

    Examples:
        >>> nk.rotations.euler_from_quat([1.0, 0.0, 0.0, 1.0], "zyx", axes="moving").angles.round(4)
        array([1.5708, 0.    , 0.    ])
    """
    return euler_from_matrix(matrix_from_quat(q), sequence, axes=axes, at_lock=at_lock)


def euler_from_matrix(R: ArrayLike, sequence: str, *, axes: Axes = REQUIRED, at_lock: AtLock = "third") -> EulerAngles:
    """Both triples of angles of a rotation, exact at every distance from lock.

    The first angle is an atan2; its rotation is removed from the matrix, and the remaining matrix gives the other two
    by one atan2 each. They compensate the error of the first, so that the matrix of the angles differs from R by a few
    1e-16 even where single angles are ill-conditioned. For moving axes x, y, z:

        α = atan2(−r23, r33),  β = atan2(r13, √(r23² + r33²)),
        γ = atan2(cos α r21 + sin α r31, cos α r22 + sin α r32).

    The other triple is (α + π, π − β, γ + π), or (α + π, −β, γ + π) if the first and third axes are the same.

    Args:
        R: rotation matrices, shape (..., 3, 3).
        sequence: three of "x", "y", "z", neighbours different, lower case; angles are returned in this order.
        axes: "moving" or "fixed"; required.
        at_lock: which outer angle is zero at lock, the "first" or the "third" as written. At lock the matrix does not
            distinguish the outer angles: |cos β| (|sin β| for equal outer axes) up to 4 × 2⁻⁵².

    Returns:
        Principal triple, other triple and lock mask.

    Examples:
        >>> R = nk.rotations.matrix_from_euler([0.1, 0.2, 0.3], "zyx", axes="moving")
        >>> nk.rotations.euler_from_matrix(R, "xyz", axes="fixed").angles
        array([0.3, 0.2, 0.1])
    """
    convention = find_convention(sequence, axes)
    choice(at_lock, ("first", "third"), "at_lock")
    kernel = extraction(convention, third_is_zero=(at_lock == "third") != convention.reversed)
    angles, other, locked = evaluate_rotations(kernel, R, (3,), (3,), ())
    return EulerAngles(angles, other, locked.astype(np.bool_))


def matrix_from_rpy(rpy: ArrayLike) -> Floats:
    """Rotation matrix of roll, pitch and yaw, R = Rz(yaw) Ry(pitch) Rx(roll).

    Rotations about the fixed axes x, y, z, in this order: the convention of URDF, Pinocchio and NAOqi's Position6D.

    Args:
        rpy: (roll, pitch, yaw), shape (..., 3) [rad].

    Returns:
        Rotation matrices, shape (..., 3, 3).

    Examples:
        >>> R = nk.rotations.matrix_from_rpy([0.1, 0.2, 0.3])
        >>> np.allclose(R, nk.rotations.rot_z(0.3) @ nk.rotations.rot_y(0.2) @ nk.rotations.rot_x(0.1))
        True
    """
    return _composed(rpy, "xyz", "fixed")


def rpy_from_matrix(R: ArrayLike, *, at_lock: AtLock = "third") -> Floats:
    """Roll, pitch and yaw of a rotation, R = Rz(yaw) Ry(pitch) Rx(roll), with pitch in [−π/2, π/2].

    The principal solution of `euler_from_matrix(R, "xyz", axes="fixed")`, which also gives the other one.

    Args:
        R: rotation matrices, shape (..., 3, 3).
        at_lock: which angle is zero where pitch = ±π/2: the "first", roll, or the "third", yaw.

    Returns:
        (roll, pitch, yaw), shape (..., 3) [rad].

    Examples:
        >>> nk.rotations.rpy_from_matrix(nk.rotations.rot_z(0.3) @ nk.rotations.rot_x(0.1))
        array([0.1, 0. , 0.3])
    """
    return euler_from_matrix(R, "xyz", axes="fixed", at_lock=at_lock).angles


# --- Rotations about arbitrary axes, consecutive ones perpendicular: Davenport angles.

# |cos| up to which two axes count as perpendicular; the matrix of the angles has an error of the same size.
_PERPENDICULAR = 1e-9
# Normalising two parallel axes of any lengths leaves at most this sine between them.
_PARALLEL = 4.0 * 2.0**-52


def davenport_angles(
    R: ArrayLike, a1: ArrayLike, a2: ArrayLike, a3: ArrayLike, *, at_lock: AtLock = "third"
) -> EulerAngles:
    """Both triples of angles with R = Rot(a1, α) Rot(a2, β) Rot(a3, γ), exact at every distance from lock.

    Each rotation is about its axis as moved by the previous ones. With δ the angle from a1 to a3 about a2 and the
    frames B = [a1, a2, a1 × a2], C = [a3, a2, a3 × a2], the matrix Bᵀ R C is a rotation by α about x, β + δ about y and
    γ about x, a proper Euler sequence. The coordinate axes give the 12 moving Euler sequences.

    Args:
        R: rotation matrices, shape (..., 3, 3).
        a1: first axis, shape (..., 3), of any length but zero; batch axes broadcast with those of R.
        a2: second axis, perpendicular to the first and the third.
        a3: third axis.
        at_lock: which outer angle is zero at lock, the "first" or the "third". At lock a3, as moved, is parallel to a1:
            |sin(β + δ)| up to 4 × 2⁻⁵².

    Returns:
        Principal triple (its β in [−δ, π − δ] for δ ≥ 0, else in [−π − δ, −δ]: the half turn that contains β = 0), the
        other triple (its β in the other half turn), and the lock mask. All angles are in [−π, π]. First and third axes
        with |sin δ| ≤ 4 × 2⁻⁵² count as parallel: δ is 0 or π.

    Raises:
        BadArgument: axes that `are_davenport_axes` refuses; names the two axes that are not perpendicular, the angle
            between them, and their index.

    Source: Shuster and Markley, Generalization of the Euler angles, J. Astronautical Sciences 51(2), 2003.

    Examples:
        >>> left_hip = [0, 1, -1], [1, 0, 0], [0, 1, 0]
        >>> R = nk.rotations.matrix_from_davenport([-0.3, 0.2, -0.5], *left_hip)
        >>> nk.rotations.davenport_angles(R, *left_hip).angles
        array([-0.3,  0.2, -0.5])
    """
    choice(at_lock, ("first", "third"), "at_lock")
    axes = [scaled_axis(axis, f"axis a{i}") for i, axis in enumerate((a1, a2, a3), 1)]
    matrices = as_rotations(R)
    common_batch("R and the axes", matrices.shape[:-2], *(axis.shape[:-1] for axis in axes))
    for i in range(2):
        _refuse_leaning(axes[i], axes[i + 1], f"axes a{i + 1} and a{i + 2}")
    first, second, third = (unit(axis, "axis")[0] for axis in axes)
    sine = dot(second, cross(first, third))
    # Nearly parallel axes are taken as parallel, so that no rounding error's sign decides on the principal triple.
    delta = np.arctan2(np.where(np.abs(sine) <= _PARALLEL, 0.0, sine), dot(first, third))
    # Reversing the second axis puts the half turn that contains β = 0 into the principal triple.
    side = np.where(delta >= 0.0, 1.0, -1.0)
    second, delta = side[..., np.newaxis] * second, side * delta
    B = np.stack(np.broadcast_arrays(first, second, cross(first, second)), axis=-2)
    C = np.stack(np.broadcast_arrays(third, second, cross(third, second)), axis=-1)
    kernel = extraction(find_convention("xyx", "moving"), third_is_zero=at_lock == "third")
    turned = B @ matrices @ C
    angles, other, locked = evaluate(kernel, [turned.reshape(*turned.shape[:-2], 9)], (3,), (3,), ())
    for triple in (angles, other):
        triple[..., 1] = side * _wrapped(triple[..., 1] - delta) + 0.0
    return EulerAngles(angles, other, locked.astype(np.bool_))


def are_davenport_axes(a1: ArrayLike, a2: ArrayLike, a3: ArrayLike) -> NDArray[np.bool_]:
    """Return whether rotations about three axes reach every rotation: a1 ⟂ a2 and a2 ⟂ a3, with |cos| up to 1e-9.

    Args:
        a1: first axes, shape (..., 3), of any length but zero.
        a2: second axes; batch axes broadcast.
        a3: third axes.

    Returns:
        Booleans, shape (...).

    Source: Davenport, Rotations about nonorthogonal axes, AIAA Journal 11(6), 1973, doi:10.2514/3.6842.

    Examples:
        >>> nk.rotations.are_davenport_axes([0, 1, -1], [1, 0, 0], [[0, 1, 0], [1, 1, 0]])
        array([ True, False])
    """
    first, second, third = (scaled_axis(axis, f"axis a{i}") for i, axis in enumerate((a1, a2, a3), 1))
    common_batch("axes a1, a2 and a3", first.shape[:-1], second.shape[:-1], third.shape[:-1])
    return np.asarray(_are_perpendicular(first, second) & _are_perpendicular(second, third))


def matrix_from_davenport(
    angles: ArrayLike, a1: ArrayLike, a2: ArrayLike | None = None, a3: ArrayLike | None = None
) -> Floats:
    """Rotation matrix of one, two or three rotations about arbitrary axes, R = Rot(a1, α) Rot(a2, β) Rot(a3, γ).

    Args:
        angles: (α, β, γ), shape (..., 3), or (..., 2) or (..., 1) for fewer axes [rad].
        a1: first axis, shape (..., 3), of any length but zero; the axes need not be perpendicular. Batch axes
            broadcast with those of the angles.
        a2: second axis, as moved by the first rotation; None for one rotation.
        a3: third axis, as moved by the first two rotations; None for two rotations.

    Returns:
        Rotation matrices, shape (..., 3, 3).

    Examples:
        >>> R = nk.rotations.matrix_from_davenport([0.2, 0.3], [0, 0, 1], [1, 0, 0])
        >>> np.allclose(R, nk.rotations.rot_z(0.2) @ nk.rotations.rot_x(0.3))
        True
    """
    if a2 is None and a3 is not None:
        raise BadArgument("axis a2 is missing, and a3 is given")
    given = [a1, *(axis for axis in (a2, a3) if axis is not None)]
    axes = [unit(scaled_axis(axis, f"axis a{i}"), "axis")[0] for i, axis in enumerate(given, 1)]
    values = as_batch(angles, (len(axes),), "angles")
    warn_of_degrees(values, "angle")
    common_batch("angles and axes", values.shape[:-1], *(axis.shape[:-1] for axis in axes))
    found, *others = (matrix_from_natural(axis, values[..., i]) for i, axis in enumerate(axes))
    for turn in others:
        found = found @ turn
    return found


def scaled_axis(axis: ArrayLike, what: str) -> Floats:
    """Return the axis with a length from 1 to √3, shape (..., 3); refuse zero."""
    return rescaled(as_batch(axis, (3,), what), what)


def _refuse_leaning(a: Floats, b: Floats, what: str) -> None:
    leaning = ~np.asarray(_are_perpendicular(a, b))
    if leaning.any():
        index = first_index(leaning)
        one, two = np.broadcast_to(a, (*leaning.shape, 3))[index], np.broadcast_to(b, (*leaning.shape, 3))[index]
        between = math.degrees(math.atan2(float(norm(cross(one, two))), float(one @ two)))
        raise BadArgument(
            f"{what}{at_index(index)} must be perpendicular, or their turns do not reach every rotation; "
            f"the angle between them is {between:.9g}°"
        )


def _are_perpendicular(a: Floats, b: Floats) -> NDArray[np.bool_]:
    """Written component by component, so that a batch is rounded like each pair alone."""
    a0, a1, a2 = (a[..., i] for i in range(3))
    b0, b1, b2 = (b[..., i] for i in range(3))
    lengths = np.sqrt((a0 * a0 + a1 * a1 + a2 * a2) * (b0 * b0 + b1 * b1 + b2 * b2))
    return np.asarray(np.abs(a0 * b0 + a1 * b1 + a2 * b2) <= _PERPENDICULAR * lengths)


def _wrapped(angle: Floats) -> Floats:
    """Wrap an angle in (−2π, 2π] to [−π, π]."""
    return np.where(angle > math.pi, angle - 2.0 * math.pi, np.where(angle < -math.pi, angle + 2.0 * math.pi, angle))
