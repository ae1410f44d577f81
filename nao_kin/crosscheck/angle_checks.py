"""Three angles: roll-pitch-yaw, all 24 sequences, and turns about the axes of NAO's hips.

Matrices are compared everywhere, angles as far as they are determined: towards lock any floating-point matrix loses the
digits of the outer two, which count in proportion to h = |cos β|, or |sin β| where the outer axes are the same.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from nao_kin._common.arrays import Floats
from nao_kin.crosscheck.comparisons import Check, Conversions, angle_difference, difference, largest, outside
from nao_kin.crosscheck.samples import RotationSample, axis_numbers, each, matrices_from_moving, turns_about
from nao_kin.rotations import SEQUENCES

_HALF, _ROOT = math.pi / 2.0, math.sqrt(0.5)
# Distances from lock: what is nearer than the first is locked, what is farther than the second is not. The library's
# own bound lies between them, and there rounding decides.
_SURELY_LOCKED, _SURELY_FREE = 2.0 * 2.0**-52, 8.0 * 2.0**-52
_X, _Y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)


def three_angle_checks() -> list[Check]:
    """The rows of this module."""
    checks = [
        Check("matrix_from_rpy", "pin.rpy.rpyToMatrix", _matrix_from_rpy),
        Check("rpy_from_matrix", "pin.rpy.matrixToRpy", _rpy_from_matrix),
    ]
    for axes in ("moving", "fixed"):
        oracle = "eigenpy" if axes == "moving" else "eigenpy, reversed"
        for sequence in SEQUENCES:
            euler = _EulerCheck(sequence, axes)
            checks += [
                Check(f"matrix_from_euler {sequence} {axes}", oracle, euler.to_matrix),
                Check(f"euler_from_matrix {sequence} {axes}", oracle, euler.to_angles),
            ]
    for hip in (
        _HipCheck("left hip", (0.0, _ROOT, -_ROOT), _HALF / 2.0),
        _HipCheck("right hip", (0.0, _ROOT, _ROOT), -_HALF / 2.0),
    ):
        checks += [
            Check(f"matrix_from_davenport {hip.name}", "pin.AngleAxis", hip.to_matrix),
            Check(f"davenport_angles {hip.name}", "pin.AngleAxis and eigenpy", hip.to_angles),
        ]
    return checks


def _matrix_from_rpy(sample: RotationSample, conversions: Conversions) -> Floats:
    return difference(conversions.matrix_from_rpy(sample.rpy), each(pin.rpy.rpyToMatrix, (3, 3), sample.rpy))


def _rpy_from_matrix(sample: RotationSample, conversions: Conversions) -> Floats:
    ours = np.asarray(conversions.rpy_from_matrix(sample.R))
    if ours.shape != sample.rpy.shape:
        return np.full(len(sample.R), np.inf)
    h = _euler_lock_distance(sample.R, "zyx")
    return largest(
        difference(each(pin.rpy.rpyToMatrix, (3, 3), ours), sample.R),
        _weighted(ours, sample.rpy, np.abs(np.cos(sample.rpy[:, 1]))),
        _out_of_range(ours, -_HALF, _HALF),
        np.where(h < _SURELY_LOCKED, np.abs(ours[:, 2]), 0.0),
    )


class _EulerCheck:
    """One of the 24: eigenpy knows moving axes; turns about fixed axes are the same turns in the opposite order."""

    def __init__(self, sequence: str, axes: str) -> None:
        self.sequence, self.axes = sequence, axes
        self.moving = sequence if axes == "moving" else sequence[::-1]
        self.symmetric = sequence[0] == sequence[2]

    def to_matrix(self, sample: RotationSample, conversions: Conversions) -> Floats:
        """Both implementations on the oracle's angles."""
        theirs = sample.moving_angles(self.moving)
        ours = conversions.matrix_from_euler(self._written(theirs), self.sequence, axes=self.axes)
        return difference(ours, sample.moving_matrices(self.moving))

    def to_angles(self, sample: RotationSample, conversions: Conversions) -> Floats:
        """Our first triple gives R by eigenpy's formula and is principal, also at lock; one of the two is eigenpy's."""
        found = conversions.euler_from_matrix(sample.R, self.sequence, axes=self.axes)
        angles, other = np.asarray(found.angles), np.asarray(found.other)
        theirs = sample.moving_angles(self.moving)
        if angles.shape != theirs.shape or other.shape != theirs.shape:
            return np.full(len(sample.R), np.inf)
        first, second = self._written(angles), self._written(other)
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

    def _written(self, triple: Floats) -> Floats:
        """From the order as written to the order about moving axes, or back."""
        return triple if self.axes == "moving" else np.ascontiguousarray(triple[:, ::-1])


@dataclass(frozen=True)
class _HipCheck:
    """Turns about a hip's axis a, about x and about y: Davenport angles that are no Euler angles.

    a = Rot(x, −δ) y, so that the angles of R = Rot(x, −δ) S are (α, β − δ, γ) where (α, β, γ) are the yxy Euler angles
    of S. Half of the rotations are compared as they are, half as S: those lock where S does.

    Attributes:
        name: which hip.
        axis: its axis a.
        delta: the angle from a to y about x; the principal middle angle is in the half turn from −δ, or to it, that
            holds zero.
    """

    name: str
    axis: tuple[float, float, float]
    delta: float

    def to_matrix(self, sample: RotationSample, conversions: Conversions) -> Floats:
        """Both implementations on the oracle's angles."""
        angles = sample.moving_angles("zyx")
        return difference(conversions.matrix_from_davenport(angles, self.axis, _X, _Y), self._matrices(angles))

    def to_angles(self, sample: RotationSample, conversions: Conversions) -> Floats:
        """Our first triple gives R and is principal, also at lock; one of the two is eigenpy's where it knows R."""
        turned = sample.spread < 0.5
        R = np.where(turned[:, None, None], turns_about(_X, np.array([-self.delta])) @ sample.R, sample.R)
        found = conversions.davenport_angles(R, self.axis, _X, _Y)
        angles, other = np.asarray(found.angles), np.asarray(found.other)
        if angles.shape != (len(R), 3) or other.shape != (len(R), 3):
            return np.full(len(R), np.inf)
        theirs = sample.moving_angles("yxy") - [0.0, self.delta, 0.0]
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
        first, second, third = (turns_about(axis, angles[:, i]) for i, axis in enumerate((self.axis, _X, _Y)))
        return np.asarray(first @ second @ third)


def _weighted(ours: Floats, theirs: Floats, weight: Floats) -> Floats:
    """Largest difference of three angles, the outer two counted by their weight."""
    apart = angle_difference(ours, theirs)
    return np.maximum(apart[:, 1], weight * np.maximum(apart[:, 0], apart[:, 2]))


def _other_branch(angles: Floats, other: Floats, mirrored: float) -> Floats:
    """How far the other triple is from (α + π, mirrored − β, γ + π), which gives the same rotation as the first."""
    expected = np.stack([angles[:, 0] + math.pi, mirrored - angles[:, 1], angles[:, 2] + math.pi], axis=1)
    return np.asarray(angle_difference(other, expected).max(axis=1))


def _out_of_range(angles: Floats, lower: float, upper: float) -> Floats:
    """How far the middle angle is outside [lower, upper], or an outer one outside [−π, π]."""
    ranges = ((-math.pi, math.pi), (lower, upper), (-math.pi, math.pi))
    return largest(*(outside(angles[:, i], *limits) for i, limits in enumerate(ranges)))


def _euler_lock_distance(R: Floats, moving: str) -> Floats:
    """The distance from lock, h = |cos β|, or |sin β| where the outer axes are the same, from two entries of R."""
    i, j, _ = axis_numbers(moving)
    k = 3 - i - j
    pair = (R[:, j, i], R[:, k, i]) if moving[0] == moving[2] else (R[:, j, k], R[:, k, k])
    return np.hypot(*pair)


def _lock_difference(h: Floats, angles: Floats, locked: Any) -> Floats:
    """0 where lock is reported where it is and the third angle is zero there; else 1, or that angle."""
    mask: NDArray[np.bool_] = np.asarray(locked, dtype=np.bool_)
    if mask.shape != h.shape:
        return np.full(len(h), np.inf)
    misreported = (mask & (h > _SURELY_FREE)) | (~mask & (h < _SURELY_LOCKED))
    return np.where(misreported, 1.0, np.where(mask, np.abs(angles[:, 2]), 0.0))
