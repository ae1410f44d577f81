"""The rows about rotations: three angles, invariants, quaternions, exponential and logarithm.

Matrices are always compared, angles as far as they are determined. Towards lock, any floating-point matrix loses digits
of the outer two angles, so their errors are weighted by h = |cos β|, or |sin β| if the outer axes are the same.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from nao_kin._core.arrays import Floats, Vector
from nao_kin.crosscheck.report import (
    LEFT_OUT,
    Check,
    Conversions,
    angle_difference,
    difference,
    direction_difference,
    largest,
    outside,
    rotation_vector_difference,
    shaped,
)
from nao_kin.crosscheck.samples import (
    RotationSample,
    axis_numbers,
    each,
    matrices_from_moving,
    matrices_from_natural,
    matrices_from_quaternions,
    turns_about,
)
from nao_kin.rotations import SEQUENCES

_HALF, _ROOT = math.pi / 2.0, math.sqrt(0.5)
# Distances from lock: a rotation nearer than the first is locked, one farther than the second is not. The library's
# bound is between them, where rounding decides.
_SURELY_LOCKED, _SURELY_FREE = 2.0 * 2.0**-52, 8.0 * 2.0**-52
_X, _Y, _Z = _AXES = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
Comparison = Callable[[RotationSample, Conversions], Floats]


def three_angle_checks() -> list[Check]:
    """Return the rows about three angles."""
    checks = [
        Check("matrix_from_rpy", "pin.rpy.rpyToMatrix", _matrix_from_rpy),
        Check("rpy_from_matrix", "pin.rpy.matrixToRpy", _rpy_from_matrix),
    ]
    for axes, oracle in (("moving", "eigenpy"), ("fixed", "eigenpy, reversed")):
        for sequence in SEQUENCES:
            euler = _EulerCheck(sequence, axes)
            checks.append(Check(f"matrix_from_euler {sequence} {axes}", oracle, euler.to_matrix))
            checks.append(Check(f"euler_from_matrix {sequence} {axes}", oracle, euler.to_angles))
    for name, z in (("left hip", -_ROOT), ("right hip", _ROOT)):
        hip = _HipCheck((0.0, _ROOT, z), -math.copysign(_HALF / 2.0, z))
        checks.append(Check(f"matrix_from_davenport {name}", "pin.AngleAxis", hip.to_matrix))
        checks.append(Check(f"davenport_angles {name}", "pin.AngleAxis and eigenpy", hip.to_angles))
    return checks


def _matrix_from_rpy(sample: RotationSample, conversions: Conversions) -> Floats:
    return difference(conversions.matrix_from_rpy(sample.rpy), each(pin.rpy.rpyToMatrix, (3, 3), sample.rpy))


def _rpy_from_matrix(sample: RotationSample, conversions: Conversions) -> Floats:
    ours = shaped(conversions.rpy_from_matrix(sample.R), sample.rpy.shape)
    h = _euler_lock_distance(sample.R, "zyx")
    return largest(
        difference(each(pin.rpy.rpyToMatrix, (3, 3), ours), sample.R),
        _weighted(ours, sample.rpy, np.abs(np.cos(sample.rpy[:, 1]))),
        _out_of_range(ours, -_HALF, _HALF),
        np.where(h < _SURELY_LOCKED, np.abs(ours[:, 2]), 0.0),
    )


class _EulerCheck:
    """One of the 24 sequences; for fixed axes, eigenpy's angles about moving axes are taken in the opposite order."""

    def __init__(self, sequence: str, axes: str) -> None:
        self.sequence, self.axes = sequence, axes
        self.moving = sequence if axes == "moving" else sequence[::-1]
        self.symmetric = sequence[0] == sequence[2]

    def to_matrix(self, sample: RotationSample, conversions: Conversions) -> Floats:
        """Compare both implementations on the oracle's angles."""
        theirs = sample.moving_angles(self.moving)
        ours = conversions.matrix_from_euler(self.written(theirs), self.sequence, axes=self.axes)
        return difference(ours, sample.moving_matrices(self.moving))

    def to_angles(self, sample: RotationSample, conversions: Conversions) -> Floats:
        """Check that our first triple gives R and is principal, also at lock, and that one of our two is eigenpy's."""
        found = conversions.euler_from_matrix(sample.R, self.sequence, axes=self.axes)
        theirs = sample.moving_angles(self.moving)
        angles, other = (shaped(triple, theirs.shape) for triple in (found.angles, found.other))
        first, second = self.written(angles), self.written(other)
        weight = np.abs((np.sin if self.symmetric else np.cos)(theirs[:, 1]))
        lower, upper = (0.0, math.pi) if self.symmetric else (-_HALF, _HALF)
        return largest(
            difference(matrices_from_moving(first, self.moving), sample.R),
            np.minimum(_weighted(first, theirs, weight), _weighted(second, theirs, weight)),
            _out_of_range(angles, lower, upper),
            _out_of_range(other, -math.pi, math.pi),
            _other_branch(angles, other, 0.0 if self.symmetric else math.pi),
            _lock_difference(_euler_lock_distance(sample.R, self.moving), angles, found.locked),
        )

    def rates(self, sample: RotationSample) -> tuple[Floats, Floats]:
        """Return angles as written, and their axes in the fixed frame as columns, shape (n, 3, 3)."""
        angles = sample.moving_angles(self.moving)
        turned, columns = np.tile(np.eye(3), (len(angles), 1, 1)), []
        for i, axis in enumerate(axis_numbers(self.moving)):
            columns.append(turned[:, :, axis])
            turned = turned @ turns_about(_AXES[axis], angles[:, i])
        return self.written(angles), np.stack(columns if self.axes == "moving" else columns[::-1], axis=2)

    def written(self, triple: Floats) -> Floats:
        """Return a triple in the order about moving axes from the order as written, or the reverse."""
        return triple if self.axes == "moving" else np.ascontiguousarray(triple[:, ::-1])


@dataclass(frozen=True)
class _HipCheck:
    """Rotations about a hip's axis a, about x and about y: Davenport angles that are not Euler angles.

    a = Rot(x, −δ) y, so the angles of R = Rot(x, −δ) S are (α, β − δ, γ) where (α, β, γ) are the yxy Euler angles of S.
    Half of the samples are used as R, the other half as S, so that R is at lock where S is; only these are compared
    with eigenpy's angles. The principal middle angle is in the half turn from −δ, or to −δ, that contains zero.
    """

    axis: tuple[float, float, float]
    delta: float

    def to_matrix(self, sample: RotationSample, conversions: Conversions) -> Floats:
        """Compare both implementations on the oracle's angles."""
        angles = sample.moving_angles("zyx")
        return difference(conversions.matrix_from_davenport(angles, self.axis, _X, _Y), self._matrices(angles))

    def to_angles(self, sample: RotationSample, conversions: Conversions) -> Floats:
        """Check that our first triple gives R and is principal, also at lock, and for S that one equals eigenpy's."""
        turned = sample.spread < 0.5
        R = np.where(turned[:, None, None], turns_about(_X, np.array([-self.delta])) @ sample.R, sample.R)
        found = conversions.davenport_angles(R, self.axis, _X, _Y)
        theirs = sample.moving_angles("yxy") - [0.0, self.delta, 0.0]
        angles, other = (shaped(triple, theirs.shape) for triple in (found.angles, found.other))
        weight = np.where(turned, np.abs(np.sin(theirs[:, 1] + self.delta)), 0.0)
        matched = np.minimum(_weighted(angles, theirs, weight), _weighted(other, theirs, weight))
        lower = -self.delta if self.delta >= 0.0 else -self.delta - math.pi
        # At lock the third axis, carried along, is parallel to the first.
        h = np.sqrt(np.square(np.cross(R[:, :, 1], self.axis)).sum(axis=1))
        return largest(
            difference(self._matrices(angles), R),
            np.where(turned, matched, 0.0),
            _out_of_range(angles, lower, lower + math.pi),
            _out_of_range(other, -math.pi, math.pi),
            _other_branch(angles, other, -2.0 * self.delta),
            _lock_difference(h, angles, found.locked),
        )

    def _matrices(self, angles: Floats) -> Floats:
        return _turned((self.axis, _X, _Y), angles)


def _weighted(ours: Floats, theirs: Floats, weight: Floats) -> Floats:
    """Return the largest difference of three angles, the outer two multiplied by their weight."""
    differences = angle_difference(ours, theirs)
    return np.maximum(differences[:, 1], weight * np.maximum(differences[:, 0], differences[:, 2]))


def _other_branch(angles: Floats, other: Floats, mirrored: float) -> Floats:
    """Return the error of the other triple, which must be (α + π, mirrored − β, γ + π)."""
    expected = np.stack([angles[:, 0] + math.pi, mirrored - angles[:, 1], angles[:, 2] + math.pi], axis=1)
    return np.asarray(angle_difference(other, expected).max(axis=1))


def _out_of_range(angles: Floats, lower: float, upper: float) -> Floats:
    """Return how far the middle angle is outside [lower, upper], or an outer one outside [−π, π]."""
    ranges = ((-math.pi, math.pi), (lower, upper), (-math.pi, math.pi))
    return largest(*(outside(angles[:, i], *limits) for i, limits in enumerate(ranges)))


def _euler_lock_distance(R: Floats, moving: str) -> Floats:
    """Return the distance from lock, h = |cos β|, or |sin β| for equal outer axes, from two entries of R."""
    i, j, _ = axis_numbers(moving)
    k = 3 - i - j
    pair = (R[:, j, i], R[:, k, i]) if moving[0] == moving[2] else (R[:, j, k], R[:, k, k])
    return np.hypot(*pair)


def _lock_difference(h: Floats, angles: Floats, locked: Any) -> Floats:
    """Return 0 if lock is reported correctly with a third angle of zero; otherwise 1, or that angle."""
    mask = shaped(locked, h.shape) != 0.0
    misreported = (mask & (h > _SURELY_FREE)) | (~mask & (h < _SURELY_LOCKED))
    return np.where(misreported, 1.0, np.where(mask, np.abs(angles[:, 2]), 0.0))


# --- Invariants, quaternions, exponential and logarithm against Pinocchio.

# Closer to π than this, rounding of sin φ e turns the axis by more than 1e-16/1e-3.
_SINE = 1e-3
_RIGHT_ANGLE = 1e-9
# Above this angle the axis of a rotation may have either sign; above the second one, means are ill-conditioned.
_HALF_TURN, _FAR = math.pi - 1e-9, 2.74
_SMALL = 0.01


PARAMETER_CHECKS: list[Check] = []
"""The rows about parameters of rotations."""


def _row(against: str, convention: str = "", note: str = "") -> Callable[[Comparison], Comparison]:
    """Register a comparison as a row about the convention of its name, or about another one."""

    def register(compared: Comparison) -> Comparison:
        PARAMETER_CHECKS.append(Check(convention or compared.__name__.strip("_"), against, compared, note))
        return compared

    return register


@_row("pin.AngleAxis")
def _matrix_from_natural(sample: RotationSample, conversions: Conversions) -> Floats:
    axes, angles = sample.natural
    return difference(conversions.matrix_from_natural(axes, angles), matrices_from_natural(axes, angles))


@_row("pin.AngleAxis")
def _natural_invariants(sample: RotationSample, conversions: Conversions) -> Floats:
    axis, angle = conversions.natural_invariants(sample.R)
    axes, angles = sample.natural
    axis, angle = shaped(axis, axes.shape), shaped(angle, angles.shape)
    length = np.sqrt(np.square(axis).sum(axis=1))
    return largest(
        rotation_vector_difference(axis * angle[:, None], axes * angles[:, None]),
        np.abs(angle - angles),
        np.where(angle > 0.0, np.abs(length - 1.0), length),
        difference(matrices_from_natural(axis, angle), sample.R),
    )


@_row("pin.AngleAxis", note="rotations within 1e-3 of π left out: their linear invariants do not determine the axis")
def _matrix_from_linear(sample: RotationSample, conversions: Conversions) -> Floats:
    axes, angles = sample.natural
    used = (np.cos(angles) > 0.0) | (np.sin(angles) > _SINE)
    axes, angles = axes[used], angles[used]
    ours = conversions.matrix_from_linear(np.sin(angles)[:, None] * axes, np.cos(angles))
    return _used(used, difference(ours, matrices_from_natural(axes, angles)))


@_row("pin.AngleAxis")
def _linear_invariants(sample: RotationSample, conversions: Conversions) -> Floats:
    q, q0 = conversions.linear_invariants(sample.R)
    axes, angles = sample.natural
    return np.maximum(difference(q, np.sin(angles)[:, None] * axes), difference(q0, np.cos(angles)))


@_row("pin.Quaternion")
def _matrix_from_euler_rodrigues(sample: RotationSample, conversions: Conversions) -> Floats:
    theirs = sample.quaternions
    ours = conversions.matrix_from_euler_rodrigues(theirs[:, 1:], theirs[:, 0])
    return difference(ours, matrices_from_quaternions(theirs))


@_row("pin.Quaternion")
def _euler_rodrigues(sample: RotationSample, conversions: Conversions) -> Floats:
    r, r0 = conversions.euler_rodrigues(sample.R)
    n = len(sample.R)
    return _canonical_difference(np.column_stack([shaped(r0, (n,)), shaped(r, (n, 3))]), sample.quaternions)


@_row("pin.exp3")
def _exp(sample: RotationSample, conversions: Conversions) -> Floats:
    # Include vectors longer than any logarithm: up to one and a half turns.
    vectors = sample.logarithms * np.where(sample.spread < 0.5, 1.0, 3.0)[:, None]
    return difference(conversions.exp(vectors), each(pin.exp3, (3, 3), vectors))


@_row("pin.AngleAxis")
def _log(sample: RotationSample, conversions: Conversions) -> Floats:
    axes, angles = sample.natural
    ours = shaped(conversions.log(sample.R), axes.shape)
    return largest(
        rotation_vector_difference(ours, axes * angles[:, None]),
        outside(np.sqrt(np.square(ours).sum(axis=1)), 0.0, np.pi),
        difference(each(pin.exp3, (3, 3), ours), sample.R),
    )


@_row(
    "pin.log3",
    "log",
    "angles from π − 0.3 to π − 0.003 left out: there pin.log3 uses an arccos, with errors of up to 7e-11",
)
def _log_against_log3(sample: RotationSample, conversions: Conversions) -> Floats:
    short_of_pi = np.pi - sample.natural[1]
    used = (short_of_pi < 0.003) | (short_of_pi > 0.3)
    return np.where(used, rotation_vector_difference(conversions.log(sample.R), sample.logarithms), LEFT_OUT)


@_row("pin.Quaternion")
def _matrix_from_quat(sample: RotationSample, conversions: Conversions) -> Floats:
    return difference(conversions.matrix_from_quat(sample.quaternions), matrices_from_quaternions(sample.quaternions))


@_row("pin.Quaternion")
def _quat_from_matrix(sample: RotationSample, conversions: Conversions) -> Floats:
    return _canonical_difference(conversions.quat_from_matrix(sample.R), sample.quaternions)


@_row("pin.Quaternion")
def _quat_multiply(sample: RotationSample, conversions: Conversions) -> Floats:
    p, q = sample.quaternions, np.roll(sample.quaternions, 1, axis=0)
    theirs = each(lambda p, q: _wxyz(pin.Quaternion(*p) * pin.Quaternion(*q)), (4,), p, q)
    return difference(conversions.quat_multiply(p, q), theirs)


@_row("pin.Quaternion")
def _quat_conjugate(sample: RotationSample, conversions: Conversions) -> Floats:
    theirs = each(lambda q: _wxyz(pin.Quaternion(*q).conjugate()), (4,), sample.quaternions)
    return difference(conversions.quat_conjugate(sample.quaternions), theirs)


@_row("pin.Quaternion.coeffs")
def _quat_to_xyzw(sample: RotationSample, conversions: Conversions) -> Floats:
    theirs = each(lambda q: pin.Quaternion(*q).coeffs(), (4,), sample.quaternions)
    return difference(conversions.quat_to_xyzw(sample.quaternions), theirs)


@_row("pin.Quaternion.coeffs")
def _quat_from_xyzw(sample: RotationSample, conversions: Conversions) -> Floats:
    coefficients = sample.quaternions[:, [1, 2, 3, 0]]
    theirs = each(lambda xyzw: _wxyz(pin.Quaternion(xyzw)), (4,), coefficients)
    return difference(conversions.quat_from_xyzw(coefficients), theirs)


@_row("pin.Quaternion.slerp", note="quaternions at a right angle left out: both directions are equally short")
def _slerp(sample: RotationSample, conversions: Conversions) -> Floats:
    p, q = sample.quaternions, np.roll(sample.quaternions, 1, axis=0)
    parts = np.floor(9.0 * sample.spread) / 8.0
    used = np.abs((p * q).sum(axis=1)) > _RIGHT_ANGLE
    return np.where(used, difference(conversions.slerp(p, q, parts), _slerped(p, q, parts)), LEFT_OUT)


@_row("pin.Quaternion")
def _quat_rotate(sample: RotationSample, conversions: Conversions) -> Floats:
    q, v = sample.quaternions, np.roll(sample.R[:, :, 0], 1, axis=0)
    return difference(conversions.quat_rotate(q, v), (matrices_from_quaternions(q) @ v[..., None])[..., 0])


@_row("pin.AngleAxis")
def _matrix_from_mrp(sample: RotationSample, conversions: Conversions) -> Floats:
    axes, angles = sample.natural
    parameters = np.tan(angles / 4.0)[:, None] * axes
    return difference(conversions.matrix_from_mrp(parameters), matrices_from_natural(axes, angles))


@_row("pin.AngleAxis")
def _mrp_from_matrix(sample: RotationSample, conversions: Conversions) -> Floats:
    axes, angles = sample.natural
    theirs = np.tan(angles / 4.0)[:, None] * axes
    ours = conversions.mrp_from_matrix(sample.R)
    # By half a turn, p and −p are one rotation.
    return np.where(angles > _HALF_TURN, direction_difference(ours, theirs), difference(ours, theirs))


@_row("pin.AngleAxis")
def _power(sample: RotationSample, conversions: Conversions) -> Floats:
    axes, angles = sample.natural
    ours, turns = conversions.power(sample.R, sample.spread), sample.spread * angles
    one, other = (difference(ours, matrices_from_natural(axes, sign * turns)) for sign in (1.0, -1.0))
    return np.where(angles > _HALF_TURN, np.minimum(one, other), one)


@_row("pin.AngleAxis")
def _angle_between(sample: RotationSample, conversions: Conversions) -> Floats:
    _, quotient = _pairs(sample)
    return difference(conversions.angle_between(sample.R, np.roll(sample.R, 1, axis=0)), quotient.natural[1])


@_row("pin.Quaternion.FromTwoVectors", note="directions within 8° of opposite ones left out")
def _rotation_between(sample: RotationSample, conversions: Conversions) -> Floats:
    a, b = sample.R[:, :, 0], np.roll(sample.R[:, :, 1], 1, axis=0)
    used = (a * b).sum(axis=1) > -0.99
    theirs = each(lambda a, b: pin.Quaternion.FromTwoVectors(a, b).matrix(), (3, 3), a[used], b[used])
    return _used(used, difference(conversions.rotation_between(a[used], b[used]), theirs))


@_row("pin.skew")
def _skew(sample: RotationSample, conversions: Conversions) -> Floats:
    return difference(conversions.skew(sample.logarithms), each(pin.skew, (3, 3), sample.logarithms))


@_row("pin.unSkew")
def _vee(sample: RotationSample, conversions: Conversions) -> Floats:
    matrices = each(pin.skew, (3, 3), sample.logarithms)
    return difference(conversions.vee(matrices), each(pin.unSkew, (3,), matrices))


def _jacobian(name: str, sample: RotationSample, conversions: Conversions) -> Floats:
    used = (sample.natural[1] > _SMALL) | (sample.natural[1] == 0.0)
    v = sample.logarithms[used]
    theirs = each(pin.Jexp3, (3, 3), -v if name.startswith("left") else v)
    if name.endswith("inverse"):
        theirs = np.asarray(np.linalg.inv(theirs), dtype=np.float64)
    return _used(used, difference(getattr(conversions, name)(v), theirs))


for _name in ("left_jacobian", "left_jacobian_inverse", "right_jacobian", "right_jacobian_inverse"):
    _row("pin.Jexp3", _name, "small rotations left out: there pin.Jexp3 loses digits")(
        functools.partial(_jacobian, _name)
    )


# --- Functions of several rotations against Pinocchio: means of two, and paths from one to the next.


@_row("pin.Quaternion.slerp", note="rotations more than 157° apart left out: their mean is ill-conditioned")
def _mean_rotation(sample: RotationSample, conversions: Conversions) -> Floats:
    keys, quotient = _pairs(sample)
    used, share = quotient.natural[1] < _FAR, sample.spread
    mean = conversions.mean_rotation(keys[used], np.stack([1.0 - share, share], axis=1)[used])
    spread = quotient.natural[1] * np.sqrt(share * (1.0 - share))
    theirs = _between(sample, share)[used]
    return _used(used, largest(difference(mean.rotation, theirs), difference(mean.spread, spread[used])))


@_row("pin.Quaternion.slerp", "RotationSpline", "two keys, at rest at both; rotations more than 157° apart left out")
def _rotation_spline(sample: RotationSample, conversions: Conversions) -> Floats:
    keys, quotient = _pairs(sample)
    axes, angles = quotient.natural
    used = angles < _FAR
    path = conversions.RotationSpline([0.0, 2.0], keys[used], start=np.zeros(3), end=np.zeros(3))
    # The share of the way, 3 u² − 2 u³, and its derivatives by the time, at u = 0.3.
    share, rate, bend = 0.216, 0.63, 0.6
    R, vector = _between(sample, np.full(len(used), share))[used], (angles[:, None] * axes)[used]
    fixed = (R @ vector[..., None])[..., 0]
    return _used(
        used,
        largest(
            difference(path(0.6), R),
            difference(path.angular_velocity(0.6, expressed_in="moving"), rate * vector),
            difference(path.angular_velocity(0.6, expressed_in="fixed"), rate * fixed),
            difference(path.angular_acceleration(0.6, expressed_in="fixed"), bend * fixed),
        ),
    )


def _pairs(sample: RotationSample) -> tuple[Floats, RotationSample]:
    """Return each rotation A with another one, B, shape (n, 2, 3, 3), and Aᵀ B."""
    keys = np.stack([sample.R, np.roll(sample.R, 1, axis=0)], axis=1)
    return keys, RotationSample(np.swapaxes(keys[:, 0], -1, -2) @ keys[:, 1])


def _between(sample: RotationSample, share: Floats) -> Floats:
    """Return the rotations at a share of the way from A to B by pin.Quaternion.slerp, shape (n, 3, 3)."""
    return matrices_from_quaternions(_slerped(sample.quaternions, np.roll(sample.quaternions, 1, axis=0), share))


def _slerped(p: Floats, q: Floats, parts: Floats) -> Floats:
    return each(lambda a, b, t: _wxyz(pin.Quaternion(*a).slerp(t, pin.Quaternion(*b))), (4,), p, q, parts)


def _used(used: Any, differences: Floats) -> Floats:
    """Return the differences of the rotations that are used, and `LEFT_OUT` for the others."""
    found = np.full(len(used), LEFT_OUT)
    found[used] = differences
    return found


# --- Further functions of three angles, each rotation by another of the 24 conventions.


def _by_convention(compared: Callable[[_EulerCheck, RotationSample, Conversions], Floats]) -> Comparison:
    # Those that the identity does not lock come first, for a robot with few rotations.
    sequences = sorted(SEQUENCES, key=lambda sequence: sequence[0] == sequence[2])
    checks = [_EulerCheck(sequence, axes) for sequence in sequences for axes in ("moving", "fixed")]

    @functools.wraps(compared)
    def comparison(sample: RotationSample, conversions: Conversions) -> Floats:
        found = np.full(len(sample.R), LEFT_OUT)
        for first, euler in enumerate(checks[: len(sample.R)]):
            part = slice(first, None, len(checks))
            found[part] = compared(euler, RotationSample(sample.R[part]), conversions)
        return found

    return comparison


@_row("eigenpy and pin.Quaternion")
@_by_convention
def _quat_from_euler(euler: _EulerCheck, sample: RotationSample, conversions: Conversions) -> Floats:
    angles = euler.written(sample.moving_angles(euler.moving))
    ours = conversions.quat_from_euler(angles, euler.sequence, axes=euler.axes)
    return _canonical_difference(ours, sample.quaternions)


@_row("eigenpy and pin.Quaternion")
@_by_convention
def _euler_from_quat(euler: _EulerCheck, sample: RotationSample, conversions: Conversions) -> Floats:
    found = conversions.euler_from_quat(sample.quaternions, euler.sequence, axes=euler.axes)
    triples = (euler.written(shaped(triple, (len(sample.R), 3))) for triple in (found.angles, found.other))
    return largest(*(difference(matrices_from_moving(triple, euler.moving), sample.R) for triple in triples))


@_row("pin.AngleAxis")
@_by_convention
def _euler_rate_jacobian(euler: _EulerCheck, sample: RotationSample, conversions: Conversions) -> Floats:
    angles, J = euler.rates(sample)
    fixed, moving = (
        conversions.euler_rate_jacobian(angles, euler.sequence, axes=euler.axes, expressed_in=side)
        for side in ("fixed", "moving")
    )
    return largest(difference(fixed, J), difference(moving, np.swapaxes(sample.R, -1, -2) @ J))


@_row("pin.AngleAxis", note="rotations within 1e-3 of lock left out: there the inverse has no digits")
@_by_convention
def _euler_rate_jacobian_inverse(euler: _EulerCheck, sample: RotationSample, conversions: Conversions) -> Floats:
    angles, J = euler.rates(sample)
    used = _euler_lock_distance(sample.R, euler.moving) > _SINE
    ours = conversions.euler_rate_jacobian_inverse(angles[used], euler.sequence, axes=euler.axes, expressed_in="fixed")
    return _used(used, difference(shaped(ours, J[used].shape) @ J[used], np.tile(np.eye(3), (used.sum(), 1, 1))))


@_row("pin.AngleAxis")
@_by_convention
def _nearest_euler(euler: _EulerCheck, sample: RotationSample, conversions: Conversions) -> Floats:
    two = euler.moving[:2]
    axes = [_AXES[axis] for axis in axis_numbers(two)]
    R = _turned(axes, sample.moving_angles(euler.moving))
    found = conversions.nearest_euler(R, two if euler.axes == "moving" else two[::-1], axes=euler.axes)
    again = _turned(axes, euler.written(shaped(found.angles, (len(R), 2))))
    return largest(difference(again, R), difference(found.residual, np.zeros(len(R))))


@_row("pin.AngleAxis")
def _nearest_davenport(sample: RotationSample, conversions: Conversions) -> Floats:
    axes = [(0.0, _ROOT, -_ROOT), _X]
    R = _turned(axes, sample.moving_angles("zyx"))
    found = conversions.nearest_davenport(R, *axes)
    again = _turned(axes, shaped(found.angles, (len(R), 2)))
    return largest(difference(again, R), difference(found.residual, np.zeros(len(R))))


def _turned(axes: Sequence[Vector], angles: Floats) -> Floats:
    """Return the product of turns about axes by pin.AngleAxis, shape (n, 3, 3)."""
    return functools.reduce(np.matmul, (turns_about(axis, angles[:, i]) for i, axis in enumerate(axes)))


def _canonical_difference(ours: Any, theirs: Floats) -> Floats:
    """Return the difference of quaternions, where q and −q are equivalent, and the error of r0 ≥ 0."""
    return largest(direction_difference(ours, theirs), outside(shaped(ours, theirs.shape)[:, 0], 0.0, np.inf))


def _wxyz(quaternion: pin.Quaternion) -> Floats:
    return np.array([quaternion.w, quaternion.x, quaternion.y, quaternion.z])
