"""A limb and its targets along a path: how they are solved, what lies between two of them, what of the pose counts."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.ik.closed_forms.arm import arm
from nao_kin.ik.closed_forms.head import head, look_at
from nao_kin.ik.closed_forms.leg import leg
from nao_kin.ik.closed_forms.legs import legs
from nao_kin.ik.geometry import torso_frame
from nao_kin.ik.results import IKResult
from nao_kin.robot import RobotModel
from nao_kin.rotations import exp, log

# Points are compared this far from a frame's origin [m]: one radian counts as much as 0.1 m, as in `arm`.
_LEVER = 0.1

Targets = tuple[Floats, ...]


@dataclass(frozen=True, eq=False)
class LimbPath(ABC):
    """Targets of one limb along a path, in the torso.

    Attributes:
        robot: whose limb.
        name: what it is called in reports.
        frames: the frames that are asked for.
        targets: arrays of n targets each.
        options: what else its solver is called with.
    """

    robot: RobotModel
    name: str
    frames: tuple[str, ...]
    targets: Targets
    options: dict[str, Any]

    @property
    def follows_only(self) -> bool:
        """Whether every target has a family of solutions, so that each sample follows from the one before."""
        return False

    @abstractmethod
    def solve(self, reference: Floats, **changed: Any) -> IKResult:
        """All solutions for the targets, with references of shape (n, nq) and options changed."""

    @abstractmethod
    def points(self, q: Floats) -> Floats:
        """Points that stand for what is asked of the pose, shape (n, p, 3) [m]."""

    def at(self, *rows: int) -> LimbPath:
        """The same for some of the targets, in any order and number."""
        return replace(self, targets=tuple(array[list(rows)] for array in self.targets))

    @abstractmethod
    def between(self, first: Floats, second: Floats, shares: Floats) -> LimbPath:
        """Targets on the way from the pose in one configuration to that in another.

        Places go straight, orientations turn about a fixed axis.

        Args:
            first: the whole robot, shape (nq,).
            second: the whole robot.
            shares: how far each target is on its way, in [0, 1], shape (m,).
        """

    def _poses(self, q: Floats) -> Floats:
        return np.asarray(self.robot.fk(q, self.frames, reference=torso_frame(self.robot)))


@dataclass(frozen=True, eq=False)
class LegPath(LimbPath):
    """One foot."""

    def solve(self, reference: Floats, **changed: Any) -> IKResult:
        """As `LimbPath.solve`."""
        return leg(
            self.robot,
            self.name[0],
            self.targets[0],
            frame=self.frames[0],
            reference=reference,
            **(self.options | changed),
        )

    def points(self, q: Floats) -> Floats:
        """The origin and a point on each axis."""
        return _pose_points(self._poses(q))

    def between(self, first: Floats, second: Floats, shares: Floats) -> LimbPath:
        """As `LimbPath.between`."""
        T = self._poses(np.stack([first, second]))
        return replace(self, targets=(_between(T[0, 0], T[1, 0], shares),))


@dataclass(frozen=True, eq=False)
class LegsPath(LimbPath):
    """Both feet, on the one motor of the hips."""

    def solve(self, reference: Floats, **changed: Any) -> IKResult:
        """As `LimbPath.solve`."""
        left, right = self.targets
        frames = (self.frames[0], self.frames[1])
        return legs(self.robot, left, right, frames=frames, reference=reference, **(self.options | changed))

    def points(self, q: Floats) -> Floats:
        """The origins and a point on each axis, of both."""
        return _pose_points(self._poses(q))

    def between(self, first: Floats, second: Floats, shares: Floats) -> LimbPath:
        """As `LimbPath.between`."""
        T = self._poses(np.stack([first, second]))
        return replace(self, targets=tuple(_between(T[0, foot], T[1, foot], shares) for foot in range(2)))


@dataclass(frozen=True, eq=False)
class ArmPath(LimbPath):
    """One hand: poses, places, or places and directions as a second array."""

    @property
    def follows_only(self) -> bool:
        """Places alone leave two joints free."""
        return len(self.targets) == 1 and self.targets[0].ndim == 2

    def solve(self, reference: Floats, **changed: Any) -> IKResult:
        """As `LimbPath.solve`; of a place alone, the solution nearest to the reference."""
        direction = self.targets[1] if len(self.targets) == 2 else None
        return arm(
            self.robot,
            self.name[0],
            self.targets[0],
            direction=direction,
            frame=self.frames[0],
            reference=reference,
            **(self.options | changed),
        )

    def points(self, q: Floats) -> Floats:
        """The origin; with a direction a point along it, with a pose on each axis."""
        points = _pose_points(self._poses(q))
        if self.targets[0].ndim == 3:
            return points
        return points[:, : len(self.targets)]

    def between(self, first: Floats, second: Floats, shares: Floats) -> LimbPath:
        """Places, and directions of the forearm where more than places are asked for.

        Poses between two that five joints make are none that they make; place and direction are five numbers.
        """
        q = np.stack([first, second])
        place = self._poses(q)[:, 0, :3, 3]
        places = _between(place[0], place[1], shares)
        if self.follows_only:
            return replace(self, targets=(places,))
        forearm = f"{self.name[0]}WristYaw"
        direction = self.robot.rotation(q, forearm, reference=torso_frame(self.robot))[:, :, 0]
        return replace(self, targets=(places, _between(direction[0], direction[1], shares)))


@dataclass(frozen=True, eq=False)
class HeadPath(LimbPath):
    """Orientations of the head."""

    def solve(self, reference: Floats, **changed: Any) -> IKResult:
        """As `LimbPath.solve`."""
        options = self.options | changed
        return head(self.robot, self.targets[0], frame=self.frames[0], reference=reference, **options)

    def points(self, q: Floats) -> Floats:
        """A point on each axis, seen from the origin."""
        points = _pose_points(self._poses(q))
        return np.asarray(points[:, 1:] - points[:, :1])

    def between(self, first: Floats, second: Floats, shares: Floats) -> LimbPath:
        """As `LimbPath.between`."""
        T = self._poses(np.stack([first, second]))[:, 0]
        return replace(self, targets=(_between(T[0, :3, :3], T[1, :3, :3], shares),))


@dataclass(frozen=True, eq=False)
class GazePath(LimbPath):
    """Points that a camera looks at."""

    def solve(self, reference: Floats, **changed: Any) -> IKResult:
        """As `LimbPath.solve`."""
        return look_at(self.robot, self.targets[0], self.frames[0], reference=reference, **(self.options | changed))

    def points(self, q: Floats) -> Floats:
        """A point on the optical axis, seen from the camera."""
        points = _pose_points(self._poses(q))
        return np.asarray(points[:, 1:2] - points[:, :1])

    def between(self, first: Floats, second: Floats, shares: Floats) -> LimbPath:
        """Orientations of the camera: what it looks at is the same for two of them."""
        T = self._poses(np.stack([first, second]))[:, 0]
        turns = _between(T[0, :3, :3], T[1, :3, :3], shares)
        return HeadPath(self.robot, self.name, self.frames, (turns,), self.options)


def _pose_points(T: Floats) -> Floats:
    """Origin, and points on the axes x, y and z, of poses (n, f, 4, 4): shape (n, 4 f, 3), frame by frame."""
    origin = T[..., None, :3, 3]
    axes = np.swapaxes(T[..., :3, :3], -1, -2)
    return np.concatenate([origin, origin + _LEVER * axes], axis=-2).reshape(len(T), -1, 3)


def _between(first: Floats, second: Floats, shares: Floats) -> Floats:
    """Poses, rotations or vectors on the way from one to another."""
    if first.ndim == 1:
        return np.asarray(first + shares[:, None] * (second - first))
    turn = log(first[:3, :3].T @ second[:3, :3])
    R = first[:3, :3] @ exp(shares[:, None] * turn)
    if first.shape == (3, 3):
        return np.asarray(R)
    T = np.tile(np.eye(4), (len(shares), 1, 1))
    T[:, :3, :3] = R
    T[:, :3, 3] = _between(first[:3, 3], second[:3, 3], shares)
    return T
