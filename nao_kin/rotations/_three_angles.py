"""The 24 three-angle conventions: 12 sequences of axes, moving or fixed; Davenport angles; rates of angles."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, as_floats, choice, common_batch, cross, dot, first_index, norm, unit
from nao_kin._core.kernels import Functions, Kernel, Number, evaluate, rescaled
from nao_kin._core.text import one_line_repr
from nao_kin._core.warn import warn_of_degrees
from nao_kin.errors import BadArgument, SingularMatrix, UnknownName, at_index
from nao_kin.rotations._checks import as_rotations, evaluate_rotations
from nao_kin.rotations._invariants import matrix_from_natural
from nao_kin.rotations._quaternions import matrix_from_quat, quat_from_matrix

Axes = Literal["moving", "fixed"]
AtLock = Literal["first", "third"]
Side = Literal["fixed", "moving"]

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
    found = _CONVENTIONS.get((sequence, axes))
    if found is not None:
        return found
    if sequence not in SEQUENCES:
        short = sequence in SHORT_SEQUENCES
        raise _unknown_sequence(sequence, SEQUENCES, "`nearest_euler` takes one or two axes" if short else "")
    raise _unknown_axes(axes)


def find_any_convention(sequence: str, axes: Axes) -> tuple[Convention, int]:
    """Return the convention and the number of angles; for one or two axes, a convention whose other angles are zero."""
    if sequence not in (*SEQUENCES, *SHORT_SEQUENCES):
        raise _unknown_sequence(sequence, (*SEQUENCES, *SHORT_SEQUENCES))
    rest = "".join(axis for axis in "xyz" if axis not in sequence)
    return find_convention((sequence + rest)[:3], axes), len(sequence)


def find_short_sequence(sequence: str, axes: Axes) -> tuple[int, ...]:
    """Return the one or two axes as numbers, in the order in which moving axes give the same rotation."""
    if sequence not in SHORT_SEQUENCES:
        full = sequence in SEQUENCES
        raise _unknown_sequence(sequence, SHORT_SEQUENCES, "`euler_from_matrix` takes three axes" if full else "")
    if axes not in ("moving", "fixed"):
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
    values = as_floats(angles, (count,), "angles")
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


def rpy_from_matrix(R: ArrayLike) -> Floats:
    """Roll, pitch and yaw of a rotation, R = Rz(yaw) Ry(pitch) Rx(roll), with pitch in [−π/2, π/2].

    The principal solution of `euler_from_matrix(R, "xyz", axes="fixed")`, which also gives the other one. Yaw is zero
    where pitch = ±π/2.

    Args:
        R: rotation matrices, shape (..., 3, 3).

    Returns:
        (roll, pitch, yaw), shape (..., 3) [rad].

    Examples:
        >>> nk.rotations.rpy_from_matrix(nk.rotations.rot_z(0.3) @ nk.rotations.rot_x(0.1))
        array([0.1, 0. , 0.3])
    """
    return euler_from_matrix(R, "xyz", axes="fixed").angles


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
        BadArgument: |cos| of consecutive axes above 1e-9; names the two axes, the angle between them, and the index.

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
    values = as_floats(angles, (len(axes),), "angles")
    warn_of_degrees(values, "angle")
    common_batch("angles and axes", values.shape[:-1], *(axis.shape[:-1] for axis in axes))
    found, *others = (matrix_from_natural(axis, values[..., i]) for i, axis in enumerate(axes))
    for turn in others:
        found = found @ turn
    return found


def scaled_axis(axis: ArrayLike, what: str) -> Floats:
    """Return the axis with a length from 1 to √3, shape (..., 3); refuse zero."""
    return rescaled(as_floats(axis, (3,), what), what)


def _refuse_leaning(a: Floats, b: Floats, what: str) -> None:
    # Written component by component, so that a batch is rounded like each pair alone.
    a0, a1, a2 = (a[..., i] for i in range(3))
    b0, b1, b2 = (b[..., i] for i in range(3))
    lengths = np.sqrt((a0 * a0 + a1 * a1 + a2 * a2) * (b0 * b0 + b1 * b1 + b2 * b2))
    leaning = np.asarray(np.abs(a0 * b0 + a1 * b1 + a2 * b2) > _PERPENDICULAR * lengths)
    if leaning.any():
        index = first_index(leaning)
        one, two = np.broadcast_to(a, (*leaning.shape, 3))[index], np.broadcast_to(b, (*leaning.shape, 3))[index]
        between = math.degrees(math.atan2(float(norm(cross(one, two))), float(one @ two)))
        raise BadArgument(
            f"{what}{at_index(index)} must be perpendicular, or their turns do not reach every rotation; "
            f"the angle between them is {between:.9g}°"
        )


def _wrapped(angle: Floats) -> Floats:
    """Wrap an angle in (−2π, 2π] to [−π, π]."""
    return np.where(angle > math.pi, angle - 2.0 * math.pi, np.where(angle < -math.pi, angle + 2.0 * math.pi, angle))


# --- The rates of three angles and the angular velocity: the Jacobians of the 24 conventions, and their inverses.


def euler_rate_jacobian(
    angles: ArrayLike, sequence: str, *, axes: Axes = REQUIRED, expressed_in: Side = REQUIRED
) -> Floats:
    """The matrix J from the rates of three angles to the angular velocity, ω = J (α̇, β̇, γ̇).

    Its columns are the current axes of the three rotations: for moving axes "ijk", in the fixed frame, eᵢ, Ri(α) eⱼ and
    Ri(α) Rj(β) eₖ; in the moving frame J is multiplied by Rᵀ. With R = `matrix_from_euler(angles, ...)`, ω in the fixed
    frame is the vector of Ṙ Rᵀ, in the moving frame that of Rᵀ Ṙ. det J is ± cos β, or ± sin β if the first and third
    axes are the same: at lock these axes coincide, and J has rank two.

    Args:
        angles: shape (..., 3) [rad], in the order of the sequence.
        sequence: three of "x", "y", "z", neighbours different, lower case.
        axes: "moving" or "fixed", the axes of the rotations; required.
        expressed_in: "fixed" or "moving", the frame of the angular velocity; required.

    Returns:
        Matrices, shape (..., 3, 3); columns in the order of the sequence.

    Source: Diebel, Representing attitude, Stanford University, 2006.

    Examples:
        >>> J = nk.rotations.euler_rate_jacobian([0.1, 0.2, 0.3], "xyz", axes="fixed", expressed_in="fixed")
        >>> J @ [0.0, 0.0, 2.0]  # the last of three fixed axes does not move
        array([0., 0., 2.])
    """
    convention, body = find_convention(sequence, axes), is_moving(expressed_in)
    values = as_floats(angles, (3,), "angles")
    return evaluate(_jacobian(convention, body), [values], (3, 3))[0]


def euler_rate_jacobian_inverse(
    angles: ArrayLike, sequence: str, *, axes: Axes = REQUIRED, expressed_in: Side = REQUIRED
) -> Floats:
    """The matrix J⁻¹ from the angular velocity to the rates of three angles, (α̇, β̇, γ̇) = J⁻¹ ω.

    The inverse of `euler_rate_jacobian`, in closed form. Near lock it grows as 1/cos β, or 1/sin β if the first and
    third axes are the same.

    Args:
        angles: shape (..., 3) [rad], in the order of the sequence.
        sequence: three of "x", "y", "z", neighbours different, lower case.
        axes: "moving" or "fixed", the axes of the rotations; required.
        expressed_in: "fixed" or "moving", the frame of the angular velocity; required.

    Returns:
        Matrices, shape (..., 3, 3); rows in the order of the sequence.

    Raises:
        SingularMatrix: at lock, |cos β| (|sin β| for equal outer axes) up to 4 × 2⁻⁵²; carries the index.

    Source: Diebel, Representing attitude, Stanford University, 2006.

    Examples:
        >>> convention = {"sequence": "zyx", "axes": "moving", "expressed_in": "moving"}
        >>> J = nk.rotations.euler_rate_jacobian([0.1, 0.2, 0.3], **convention)
        >>> np.allclose(nk.rotations.euler_rate_jacobian_inverse([0.1, 0.2, 0.3], **convention) @ J, np.eye(3))
        True
    """
    convention, body = find_convention(sequence, axes), is_moving(expressed_in)
    values = as_floats(angles, (3,), "angles")
    found, determinant = evaluate(_inverse(convention, body), [values], (3, 3), ())
    locked = np.asarray(np.abs(determinant) <= LOCK)
    if locked.any():
        outer = "sin β = 0" if convention.symmetric else "cos β = 0"
        raise SingularMatrix("Jacobian of the angles' rates", f"the angles are at lock, {outer}", first_index(locked))
    return found


def is_moving(expressed_in: Side) -> bool:
    if expressed_in is None:
        raise BadArgument("expressed_in= must be given: 'fixed' or 'moving', the frame of the vector's components")
    return choice(expressed_in, ("fixed", "moving"), "expressed_in") == "moving"


def _sines(f: Functions, convention: Convention, body: bool, angles: tuple[Number, ...]) -> tuple[Number, ...]:
    """Cosines and sines of the two angles that J depends on, for moving axes in the fixed frame.

    In the moving frame, Rᵀ consists of rotations by the negative angles in the opposite order.
    """
    first, middle, third = angles[::-1] if convention.reversed else angles
    if body:
        first, middle = 0.0 - third, 0.0 - middle
    return f.cos(first), f.sin(first), f.cos(middle), f.sin(middle)


def _order(convention: Convention, body: bool) -> tuple[int, int, int, float, bool]:
    """The axes i, j, k and their sign, as for J in the fixed frame, and whether the angles are in the same order."""
    i, k, sign = convention.i, convention.k, convention.sign
    if body and not convention.symmetric:
        i, k, sign = k, i, -sign
    return i, convention.j, k, sign, convention.reversed == body


def _jacobian(convention: Convention, body: bool) -> Kernel:
    i, j, k, s, in_order = _order(convention, body)

    def kernel(f: Functions, *angles: Number) -> tuple[Number, ...]:
        ca, sa, cb, sb = _sines(f, convention, body, angles)
        m: list[Number] = [0.0] * 9
        first, last = (0, 2) if in_order else (2, 0)
        m[3 * i + first] = 1.0
        m[3 * j + 1], m[3 * k + 1] = ca, s * sa
        if convention.symmetric:
            m[3 * i + last], m[3 * j + last], m[3 * k + last] = cb, sa * sb, 0.0 - s * ca * sb
        else:
            m[3 * i + last], m[3 * j + last], m[3 * k + last] = s * sb, 0.0 - s * sa * cb, ca * cb
        return tuple(m)

    return kernel


def _inverse(convention: Convention, body: bool) -> Kernel:
    i, j, k, s, in_order = _order(convention, body)

    def kernel(f: Functions, *angles: Number) -> tuple[Number, ...]:
        ca, sa, cb, sb = _sines(f, convention, body, angles)
        # The component of the last axis along the first, and the one across it.
        along, across = (cb, 0.0 - s * sb) if convention.symmetric else (s * sb, cb)
        divisor = f.where(across == 0.0, 1.0, across)
        gj, gk = 0.0 - s * sa / divisor, ca / divisor
        m: list[Number] = [0.0] * 9
        first, last = (0, 6) if in_order else (6, 0)
        m[first + i], m[first + j], m[first + k] = 1.0, 0.0 - along * gj, 0.0 - along * gk
        m[3 + j], m[3 + k] = ca, s * sa
        m[last + j], m[last + k] = gj, gk
        return *m, across

    return kernel
