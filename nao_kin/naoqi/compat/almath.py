"""The module `almath` that old scripts import: its constants, and poses in the plane and in space.

Aldebaran's own module (BSD-3) has no wheels for current Python; scripts get it if it is installed. This module has
`Pose2D`, `Position3D`, `Position6D` and `Transform` with their products and inverses.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats, join_poses, rigid_inverse
from nao_kin.naoqi.compat.motion import *  # noqa: F403
from nao_kin.naoqi.conventions import pose, position6d


class _Numbers:
    """Named numbers, given as separate arguments or as one sequence; all zero without arguments."""

    _names: tuple[str, ...] = ()

    def __init__(self, *values: Any) -> None:
        given = values[0] if len(values) == 1 and isinstance(values[0], (Sequence, np.ndarray)) else values
        if len(given) not in (0, len(self._names)):
            raise RuntimeError(f"{type(self).__name__} takes {len(self._names)} numbers, got {len(given)}")
        for name, value in zip(self._names, given or (0.0,) * len(self._names), strict=True):
            setattr(self, name, float(value))

    def toVector(self) -> list[float]:
        """The numbers as a list."""
        return [getattr(self, name) for name in self._names]

    def isNear(self, other: _Numbers, epsilon: float = 1e-4) -> bool:
        """Whether all numbers agree within epsilon."""
        return all(abs(a - b) <= epsilon for a, b in zip(self.toVector(), other.toVector(), strict=True))

    def __iter__(self) -> Any:
        return iter(self.toVector())

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and isinstance(other, _Numbers) and self.toVector() == other.toVector()

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        values = ", ".join(f"{name}={getattr(self, name):g}" for name in self._names)
        return f"{type(self).__name__}({values})"


class _Vector(_Numbers):
    """Numbers with element-wise addition and scaling."""

    def __add__(self, other: _Vector) -> Any:
        return type(self)([a + b for a, b in zip(self, other, strict=True)])

    def __sub__(self, other: _Vector) -> Any:
        return type(self)([a - b for a, b in zip(self, other, strict=True)])

    def __neg__(self) -> Any:
        return type(self)([-a for a in self])

    def __mul__(self, factor: float) -> Any:
        return type(self)([a * factor for a in self])

    __rmul__ = __mul__

    def __truediv__(self, divisor: float) -> Any:
        return type(self)([a / divisor for a in self])

    def norm(self) -> float:
        """Euclidean length."""
        return math.sqrt(sum(a * a for a in self))


class Position3D(_Vector):
    """A point or a vector in space [m]."""

    _names = ("x", "y", "z")


class Position6D(_Vector):
    """A pose as six numbers, R = Rz(wz) Ry(wy) Rx(wx) [m, rad]."""

    _names = ("x", "y", "z", "wx", "wy", "wz")


class Pose2D(_Numbers):
    """A pose on the floor [m, rad]; the product composes two poses."""

    _names = ("x", "y", "theta")
    x: float
    y: float
    theta: float

    def __mul__(self, other: Pose2D) -> Pose2D:
        c, s = math.cos(self.theta), math.sin(self.theta)
        x, y = c * other.x - s * other.y, s * other.x + c * other.y
        return Pose2D(self.x + x, self.y + y, self.theta + other.theta)

    def inverse(self) -> Pose2D:
        """The inverse: pose * pose.inverse() is zero."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        return Pose2D(-c * self.x - s * self.y, s * self.x - c * self.y, -self.theta)

    def distance(self, other: Pose2D) -> float:
        """Distance of the positions."""
        return math.hypot(self.x - other.x, self.y - other.y)


class Transform(_Numbers):
    """A rigid transform as the numbers r1_c1 … r3_c4, made from twelve, sixteen, or the three of a translation."""

    _names = tuple(f"r{row}_c{column}" for row in (1, 2, 3) for column in (1, 2, 3, 4))

    def __init__(self, *values: Any) -> None:
        given = values[0] if len(values) == 1 else values
        given = list(given)[:12] if len(given) == 16 else given
        if len(values) in (0, 3):
            given = join_poses(np.eye(3), np.array(values or np.zeros(3)))[:3].ravel()
        super().__init__(*given)

    def matrix(self) -> Floats:
        """The matrix, shape (4, 4)."""
        return np.array([*super().toVector(), 0.0, 0.0, 0.0, 1.0]).reshape(4, 4)

    def toVector(self) -> list[float]:
        """The sixteen numbers row by row, as NAOqi's getTransform gives them."""
        return [float(number) for number in self.matrix().ravel()]

    def inverse(self) -> Transform:
        """The inverse transform."""
        return Transform(rigid_inverse(self.matrix()).ravel())

    def __mul__(self, other: Transform) -> Transform:
        return Transform((self.matrix() @ other.matrix()).ravel())

    @staticmethod
    def fromPosition(x: float, y: float, z: float, wx: float = 0.0, wy: float = 0.0, wz: float = 0.0) -> Transform:
        """The transform of a position and three angles as in `Position6D`."""
        return Transform(pose([x, y, z, wx, wy, wz]).ravel())

    @staticmethod
    def fromRotX(angle: float) -> Transform:
        """A rotation about x."""
        return Transform.fromPosition(0.0, 0.0, 0.0, wx=angle)

    @staticmethod
    def fromRotY(angle: float) -> Transform:
        """A rotation about y."""
        return Transform.fromPosition(0.0, 0.0, 0.0, wy=angle)

    @staticmethod
    def fromRotZ(angle: float) -> Transform:
        """A rotation about z."""
        return Transform.fromPosition(0.0, 0.0, 0.0, wz=angle)


def transformFromPosition6D(position: Position6D) -> Transform:
    """The transform of six numbers."""
    return Transform.fromPosition(*position)


def position6DFromTransform(transform: Transform) -> Position6D:
    """The six numbers of a transform."""
    return Position6D(position6d(transform.matrix()).tolist())


def transformFromPosition3D(position: Position3D) -> Transform:
    """A translation."""
    return Transform.fromPosition(*position)


def transformFromPose2D(pose2d: Pose2D) -> Transform:
    """The transform of a pose on the floor."""
    return Transform.fromPosition(pose2d.x, pose2d.y, 0.0, wz=pose2d.theta)


def pose2DFromTransform(transform: Transform) -> Pose2D:
    """The pose on the floor of a transform."""
    x, y, *_, wz = position6DFromTransform(transform)
    return Pose2D(x, y, wz)


pose2DInverse = Pose2D.inverse
transformInverse = Transform.inverse
transformFromRotX = Transform.fromRotX
transformFromRotY = Transform.fromRotY
transformFromRotZ = Transform.fromRotZ


def modulo2PI(angle: float) -> float:
    """The same angle in [−π, π] [rad]."""
    return math.remainder(angle, 2.0 * math.pi)


def clipData(low: float, high: float, value: float) -> float:
    """The value, clipped to the bounds."""
    return min(max(value, low), high)


def getDubinsSolutions(pTargetPose: Pose2D, pCircleRadius: float) -> list[Pose2D]:
    """Return the shortest path of an arc, a line and an arc from the origin, heading along x, to a pose.

    The three poses returned are the ends of these parts.

    The target is at least four radii away; at this distance no path of three arcs is shorter.

    Source: L. E. Dubins, On curves of minimal length with a constraint on average curvature, 1957.
    """
    radius, (x, y, theta) = float(pCircleRadius), pTargetPose
    if not radius > 0.0 or math.hypot(x, y) < 4.0 * radius:
        raise RuntimeError("getDubinsSolutions: the target must be at least 4 radii away, and the radius positive")
    ways = []
    for first in (1.0, -1.0):  # 1 turns left, -1 right
        for second in (1.0, -1.0):
            dx = x - second * radius * math.sin(theta)
            dy = y + second * radius * math.cos(theta) - first * radius
            # The inner tangent joins circles of opposite senses; it is inclined to the line between the centres.
            distance = math.hypot(dx, dy)
            sine = clipData(-1.0, 1.0, (first - second) * radius / distance)
            heading = math.atan2(dy, dx) + math.asin(sine)
            arc, last = _turned(first * heading), _turned(second * (theta - heading))
            length = radius * (arc + last) + distance * math.sqrt(1.0 - sine**2)
            ways.append((length, first, second, first * arc))
    _, first, second, heading = min(ways)
    sine, cosine = math.sin(heading), math.cos(heading)
    begin = Pose2D(first * radius * sine, first * radius * (1.0 - cosine), heading)
    end = Pose2D(
        x + second * radius * (sine - math.sin(theta)), y - second * radius * (cosine - math.cos(theta)), heading
    )
    return [begin, end, Pose2D(x, y, theta)]


def _turned(angle: float) -> float:
    """The same angle in [0, 2π); rounding below zero counts as zero [rad]."""
    turned = angle % math.tau
    return 0.0 if math.tau - turned < 1e-9 else turned
