"""Rotations of the robot's frames, and what Pinocchio and eigenpy make of them, one rotation at a time."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import eigenpy
import numpy as np
import pinocchio as pin

from nao_kin._arrays import Floats


class Sample:
    """Rotation matrices R, shape (n, 3, 3), with the oracles' answers computed once for all checks."""

    def __init__(self, R: Floats) -> None:
        self.R = R

    @functools.cached_property
    def quaternions(self) -> Floats:
        """(w, x, y, z) of pin.Quaternion, shape (n, 4)."""
        return each(lambda R: pin.Quaternion(R).coeffs(), (4,), self.R)[:, [3, 0, 1, 2]]

    @functools.cached_property
    def natural(self) -> tuple[Floats, Floats]:
        """Axes (n, 3) and angles (n,) of pin.AngleAxis."""
        rows = each(_natural, (4,), self.R)
        return rows[:, :3], rows[:, 3]

    @functools.cached_property
    def logarithms(self) -> Floats:
        """pin.log3, shape (n, 3)."""
        return each(pin.log3, (3,), self.R)

    @functools.cached_property
    def rpy(self) -> Floats:
        """pin.rpy.matrixToRpy, shape (n, 3)."""
        return each(pin.rpy.matrixToRpy, (3,), self.R)

    def moving_angles(self, sequence: str) -> Floats:
        """eigenpy.toEulerAngles about moving axes, shape (n, 3); one of the two solutions."""
        if sequence not in self._moving:
            numbers = axis_numbers(sequence)
            self._moving[sequence] = each(lambda R: eigenpy.toEulerAngles(R, *numbers), (3,), self.R)
        return self._moving[sequence]

    @functools.cached_property
    def _moving(self) -> dict[str, Floats]:
        return {}


def each(function: Callable[..., Any], tail: tuple[int, ...], *arrays: Floats) -> Floats:
    """`function` of every row of the arrays, its results in one array (n, *tail)."""
    results = np.empty((len(arrays[0]), *tail))
    for index, row in enumerate(zip(*arrays, strict=True)):
        results[index] = function(*row)
    return results


def axis_numbers(sequence: str) -> tuple[int, ...]:
    """0 for x, 1 for y, 2 for z."""
    return tuple("xyz".index(axis) for axis in sequence)


def matrices_from_moving(angles: Floats, sequence: str) -> Floats:
    """eigenpy.fromEulerAngles about moving axes, shape (n, 3, 3)."""
    numbers = axis_numbers(sequence)
    return each(lambda row: eigenpy.fromEulerAngles(row, *numbers), (3, 3), angles)


def matrices_from_quaternions(wxyz: Floats) -> Floats:
    """pin.Quaternion to matrix, shape (n, 3, 3)."""
    return each(lambda q: pin.Quaternion(*q).matrix(), (3, 3), wxyz)


def matrices_from_natural(axes: Floats, angles: Floats) -> Floats:
    """pin.AngleAxis to matrix, shape (n, 3, 3)."""
    return each(lambda axis, angle: pin.AngleAxis(angle, axis).toRotationMatrix(), (3, 3), axes, angles)


def turns_about(axis: tuple[float, float, float], angles: Floats) -> Floats:
    """Turns about one axis by pin.AngleAxis, shape (n, 3, 3)."""
    direction = np.array(axis)
    return matrices_from_natural(np.broadcast_to(direction, (len(angles), 3)), angles)


def _natural(R: Floats) -> Floats:
    both = pin.AngleAxis(R)
    return np.append(both.axis, both.angle)
