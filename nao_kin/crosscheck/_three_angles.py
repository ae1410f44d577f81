"""Three angles: roll-pitch-yaw, all 24 sequences, and turns about the axes of NAO's hips.

Matrices are compared everywhere, angles as far as they are determined: towards lock any floating-point matrix loses the
digits of the outer two, which count in proportion to h = |cos β|, or |sin β| where the outer axes are the same.
"""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
import pinocchio as pin

from nao_kin._arrays import Floats
from nao_kin.crosscheck._check import Check
from nao_kin.crosscheck._gaps import angle_gap, beyond, gap, largest
from nao_kin.crosscheck._sample import Sample, axis_numbers, each, matrices_from_moving, turns_about
from nao_kin.crosscheck.conversions import Conversions
from nao_kin.rotations import SEQUENCES

_HALF, _ROOT = math.pi / 2.0, math.sqrt(0.5)
# First axis of each hip; the range of the middle angle that the principal triple has with the axes x and y behind it.
_HIPS = {
    "left hip": ((0.0, _ROOT, -_ROOT), (-math.pi / 4, 3 * math.pi / 4)),
    "right hip": ((0.0, _ROOT, _ROOT), (-3 * math.pi / 4, math.pi / 4)),
}
_X, _Y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
# Where a sequence locks, by the library's own definition; between these bounds rounding decides.
_SURELY_LOCKED, _SURELY_FREE = 2.0 * 2.0**-52, 8.0 * 2.0**-52


def three_angle_checks() -> list[Check]:
    """The rows of this module."""
    checks = [
        Check("matrix_from_rpy", "pin.rpy.rpyToMatrix", _matrix_from_rpy),
        Check("rpy_from_matrix", "pin.rpy.matrixToRpy", _rpy_from_matrix),
    ]
    for axes in ("moving", "fixed"):
        oracle = "eigenpy" if axes == "moving" else "eigenpy, reversed"
        for sequence in SEQUENCES:
            convention = _Convention(sequence, axes)
            name = f"{sequence} {axes}"
            checks += [
                Check(f"matrix_from_euler {name}", oracle, convention.to_matrix),
                Check(f"euler_from_matrix {name}", oracle, convention.to_angles),
            ]
    for side in _HIPS:
        checks += [
            Check(f"matrix_from_davenport {side}", "pin.AngleAxis", functools.partial(_hip_to_matrix, side)),
            Check(f"davenport_angles {side}", "pin.AngleAxis", functools.partial(_hip_to_angles, side)),
        ]
    return checks


def _matrix_from_rpy(sample: Sample, conversions: Conversions) -> Floats:
    return gap(conversions.matrix_from_rpy(sample.rpy), each(pin.rpy.rpyToMatrix, (3, 3), sample.rpy))


def _rpy_from_matrix(sample: Sample, conversions: Conversions) -> Floats:
    ours = np.asarray(conversions.rpy_from_matrix(sample.R))
    if ours.shape != sample.rpy.shape:
        return np.full(len(sample.R), np.inf)
    rebuilt = gap(each(pin.rpy.rpyToMatrix, (3, 3), ours), sample.R)
    weight = np.abs(np.cos(sample.rpy[:, 1]))
    return largest(rebuilt, _weighted(ours, sample.rpy, weight), beyond(ours[:, 1], -_HALF, _HALF))


class _Convention:
    """One of the 24: eigenpy knows moving axes; turns about fixed axes are the same turns in the opposite order."""

    def __init__(self, sequence: str, axes: str) -> None:
        self.sequence, self.axes = sequence, axes
        self.moving = sequence if axes == "moving" else sequence[::-1]
        self.symmetric = sequence[0] == sequence[2]

    def to_matrix(self, sample: Sample, conversions: Conversions) -> Floats:
        """Both implementations on the oracle's angles."""
        theirs = sample.moving_angles(self.moving)
        ours = conversions.matrix_from_euler(self._written(theirs), self.sequence, axes=self.axes)
        return gap(ours, matrices_from_moving(theirs, self.moving))

    def to_angles(self, sample: Sample, conversions: Conversions) -> Floats:
        """Both of our triples give R by eigenpy's formula; one is eigenpy's; the first is principal, also at lock."""
        found = conversions.euler_from_matrix(sample.R, self.sequence, axes=self.axes)
        angles, other = np.asarray(found.angles), np.asarray(found.other)
        theirs = sample.moving_angles(self.moving)
        if angles.shape != theirs.shape or other.shape != theirs.shape:
            return np.full(len(sample.R), np.inf)
        first, second = self._written(angles), self._written(other)
        weight = np.abs((np.sin if self.symmetric else np.cos)(theirs[:, 1]))
        lower, upper = (0.0, math.pi) if self.symmetric else (-_HALF, _HALF)
        return largest(
            *(gap(matrices_from_moving(triple, self.moving), sample.R) for triple in (first, second)),
            np.minimum(_weighted(first, theirs, weight), _weighted(second, theirs, weight)),
            beyond(angles[:, 1], lower, upper),
            self._lock_gap(sample.R, angles, found.locked),
        )

    def _lock_gap(self, R: Floats, angles: Floats, locked: Any) -> Floats:
        """Whether lock is told where it is, and the third angle as written is zero there."""
        i, j, _ = axis_numbers(self.moving)
        k = 3 - i - j
        pair = (R[:, j, i], R[:, k, i]) if self.symmetric else (R[:, j, k], R[:, k, k])
        h = np.hypot(*pair)
        mask = np.asarray(locked, dtype=np.bool_)
        mistold = (mask & (h > _SURELY_FREE)) | (~mask & (h < _SURELY_LOCKED))
        return np.where(mistold, 1.0, np.where(mask, np.abs(angles[:, 2]), 0.0))

    def _written(self, triple: Floats) -> Floats:
        """From the order as written to the order about moving axes, or back."""
        return triple if self.axes == "moving" else np.ascontiguousarray(triple[:, ::-1])


def _weighted(ours: Floats, theirs: Floats, weight: Floats) -> Floats:
    """Largest difference of three angles, the outer two counted by their weight."""
    apart = angle_gap(ours, theirs)
    return np.maximum(apart[:, 1], weight * np.maximum(apart[:, 0], apart[:, 2]))


def _hip_to_matrix(side: str, sample: Sample, conversions: Conversions) -> Floats:
    angles = sample.moving_angles("zyx")
    axis = _HIPS[side][0]
    return gap(conversions.matrix_from_davenport(angles, axis, _X, _Y), _hip_matrices(axis, angles))


def _hip_to_angles(side: str, sample: Sample, conversions: Conversions) -> Floats:
    axis, (lower, upper) = _HIPS[side]
    found = conversions.davenport_angles(sample.R, axis, _X, _Y)
    triples = [np.asarray(found.angles), np.asarray(found.other)]
    if any(triple.shape != (len(sample.R), 3) for triple in triples):
        return np.full(len(sample.R), np.inf)
    rebuilt = [gap(_hip_matrices(axis, triple), sample.R) for triple in triples]
    return largest(*rebuilt, beyond(triples[0][:, 1], lower, upper))


def _hip_matrices(axis: tuple[float, float, float], angles: Floats) -> Floats:
    first, second, third = (turns_about(a, angles[:, i]) for i, a in enumerate((axis, _X, _Y)))
    return np.asarray(first @ second @ third)
