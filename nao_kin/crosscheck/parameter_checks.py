"""Invariants, quaternions, exponential and logarithm against Pinocchio."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from nao_kin._common.arrays import Floats
from nao_kin.crosscheck.comparisons import (
    LEFT_OUT,
    Check,
    Conversions,
    difference,
    direction_difference,
    largest,
    outside,
    rotation_vector_difference,
)
from nao_kin.crosscheck.samples import RotationSample, each, matrices_from_natural, matrices_from_quaternions

# Closer to π, rounding of sin φ e turns the axis by more than 1e-16/1e-3.
_SINE = 1e-3
_RIGHT_ANGLE = 1e-9


def parameter_checks() -> list[Check]:
    """The rows of this module."""
    return [
        Check("matrix_from_natural", "pin.AngleAxis", _matrix_from_natural),
        Check("natural_invariants", "pin.AngleAxis", _natural_invariants),
        Check(
            "matrix_from_linear",
            "pin.AngleAxis",
            _matrix_from_linear,
            note="rotations within 1e-3 of π left out: their linear invariants do not hold the axis",
        ),
        Check("linear_invariants", "pin.AngleAxis", _linear_invariants),
        Check("matrix_from_euler_rodrigues", "pin.Quaternion", _matrix_from_euler_rodrigues),
        Check("euler_rodrigues", "pin.Quaternion", _euler_rodrigues),
        Check("exp", "pin.exp3", _exp),
        Check("log", "pin.AngleAxis", _log),
        Check(
            "log",
            "pin.log3",
            _log_against_log3,
            note="angles from π − 0.3 to π − 0.003 left out: there pin.log3 takes an arccos and errs by up to 7e-11",
        ),
        Check("matrix_from_quat", "pin.Quaternion", _matrix_from_quat),
        Check("quat_from_matrix", "pin.Quaternion", _quat_from_matrix),
        Check("quat_multiply", "pin.Quaternion", _quat_multiply),
        Check("quat_conjugate", "pin.Quaternion", _quat_conjugate),
        Check("quat_to_xyzw", "pin.Quaternion.coeffs", _quat_to_xyzw),
        Check("quat_from_xyzw", "pin.Quaternion.coeffs", _quat_from_xyzw),
        Check(
            "slerp",
            "pin.Quaternion.slerp",
            _slerp,
            note="quaternions at a right angle left out: both ways round are as short",
        ),
    ]


def _matrix_from_natural(sample: RotationSample, conversions: Conversions) -> Floats:
    axes, angles = sample.natural
    return difference(conversions.matrix_from_natural(axes, angles), matrices_from_natural(axes, angles))


def _natural_invariants(sample: RotationSample, conversions: Conversions) -> Floats:
    axis, angle = (np.asarray(part) for part in conversions.natural_invariants(sample.R))
    axes, angles = sample.natural
    if axis.shape != axes.shape or angle.shape != angles.shape:
        return np.full(len(angles), np.inf)
    length = np.sqrt(np.square(axis).sum(axis=1))
    return largest(
        rotation_vector_difference(axis * angle[:, None], axes * angles[:, None]),
        np.abs(angle - angles),
        np.where(angle > 0.0, np.abs(length - 1.0), length),
        difference(matrices_from_natural(axis, angle), sample.R),
    )


def _matrix_from_linear(sample: RotationSample, conversions: Conversions) -> Floats:
    axes, angles = sample.natural
    used = (np.cos(angles) > 0.0) | (np.sin(angles) > _SINE)
    axes, angles = axes[used], angles[used]
    apart = np.full(len(used), LEFT_OUT)
    ours = conversions.matrix_from_linear(np.sin(angles)[:, None] * axes, np.cos(angles))
    apart[used] = difference(ours, matrices_from_natural(axes, angles))
    return apart


def _linear_invariants(sample: RotationSample, conversions: Conversions) -> Floats:
    q, q0 = conversions.linear_invariants(sample.R)
    axes, angles = sample.natural
    return np.maximum(difference(q, np.sin(angles)[:, None] * axes), difference(q0, np.cos(angles)))


def _matrix_from_euler_rodrigues(sample: RotationSample, conversions: Conversions) -> Floats:
    theirs = sample.quaternions
    ours = conversions.matrix_from_euler_rodrigues(theirs[:, 1:], theirs[:, 0])
    return difference(ours, matrices_from_quaternions(theirs))


def _euler_rodrigues(sample: RotationSample, conversions: Conversions) -> Floats:
    r, r0 = (np.asarray(part) for part in conversions.euler_rodrigues(sample.R))
    if r.shape != (len(sample.R), 3) or r0.shape != (len(sample.R),):
        return np.full(len(sample.R), np.inf)
    return _canonical_difference(np.concatenate([r0[:, None], r], axis=1), sample.quaternions)


def _exp(sample: RotationSample, conversions: Conversions) -> Floats:
    # Longer vectors than a logarithm has, too: up to one and a half turns.
    vectors = sample.logarithms * np.where(sample.spread < 0.5, 1.0, 3.0)[:, None]
    return difference(conversions.exp(vectors), each(pin.exp3, (3, 3), vectors))


def _log(sample: RotationSample, conversions: Conversions) -> Floats:
    axes, angles = sample.natural
    ours = np.asarray(conversions.log(sample.R))
    apart = rotation_vector_difference(ours, axes * angles[:, None])
    if ours.shape != axes.shape:
        return apart
    length = np.sqrt(np.square(ours).sum(axis=1))
    return largest(apart, outside(length, 0.0, np.pi), difference(each(pin.exp3, (3, 3), ours), sample.R))


def _log_against_log3(sample: RotationSample, conversions: Conversions) -> Floats:
    short_of_pi = np.pi - sample.natural[1]
    used = (short_of_pi < 0.003) | (short_of_pi > 0.3)
    return np.where(used, rotation_vector_difference(conversions.log(sample.R), sample.logarithms), LEFT_OUT)


def _matrix_from_quat(sample: RotationSample, conversions: Conversions) -> Floats:
    return difference(conversions.matrix_from_quat(sample.quaternions), matrices_from_quaternions(sample.quaternions))


def _quat_from_matrix(sample: RotationSample, conversions: Conversions) -> Floats:
    return _canonical_difference(np.asarray(conversions.quat_from_matrix(sample.R)), sample.quaternions)


def _quat_multiply(sample: RotationSample, conversions: Conversions) -> Floats:
    p, q = sample.quaternions, np.roll(sample.quaternions, 1, axis=0)
    return difference(conversions.quat_multiply(p, q), each(_product, (4,), p, q))


def _quat_conjugate(sample: RotationSample, conversions: Conversions) -> Floats:
    theirs = each(lambda q: _wxyz(pin.Quaternion(*q).conjugate()), (4,), sample.quaternions)
    return difference(conversions.quat_conjugate(sample.quaternions), theirs)


def _quat_to_xyzw(sample: RotationSample, conversions: Conversions) -> Floats:
    theirs = each(lambda q: pin.Quaternion(*q).coeffs(), (4,), sample.quaternions)
    return difference(conversions.quat_to_xyzw(sample.quaternions), theirs)


def _quat_from_xyzw(sample: RotationSample, conversions: Conversions) -> Floats:
    coefficients = sample.quaternions[:, [1, 2, 3, 0]]
    theirs = each(lambda xyzw: _wxyz(pin.Quaternion(xyzw)), (4,), coefficients)
    return difference(conversions.quat_from_xyzw(coefficients), theirs)


def _slerp(sample: RotationSample, conversions: Conversions) -> Floats:
    p, q = sample.quaternions, np.roll(sample.quaternions, 1, axis=0)
    parts = np.floor(9.0 * sample.spread) / 8.0
    theirs = each(lambda a, b, t: _wxyz(pin.Quaternion(*a).slerp(t, pin.Quaternion(*b))), (4,), p, q, parts)
    used = np.abs((p * q).sum(axis=1)) > _RIGHT_ANGLE
    return np.where(used, difference(conversions.slerp(p, q, parts), theirs), LEFT_OUT)


def _canonical_difference(ours: Floats, theirs: Floats) -> Floats:
    """Difference of quaternions, of which q and −q mean the same, and how far ours is from r0 ≥ 0."""
    apart = direction_difference(ours, theirs)
    return apart if ours.shape != theirs.shape else np.maximum(apart, np.maximum(-ours[:, 0], 0.0))


def _product(p: Floats, q: Floats) -> Floats:
    return _wxyz(pin.Quaternion(*p) * pin.Quaternion(*q))


def _wxyz(quaternion: pin.Quaternion) -> Floats:
    return np.array([quaternion.w, quaternion.x, quaternion.y, quaternion.z])
