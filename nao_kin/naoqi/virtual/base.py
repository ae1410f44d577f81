"""Where the torso is in the world, while the joints move: one sole stays on the floor, or the robot rests on it."""

from __future__ import annotations

import math

import numpy as np

from nao_kin import NaoModel
from nao_kin._common.arrays import Floats
from nao_kin._common.vectors import rigid_inverse
from nao_kin.naoqi.spaces import robot_frame
from nao_kin.rotations import rot_z

FEET = ("LLeg", "RLeg")
# The other foot takes over where its sole is lower by more than this; less is two feet on one floor.
_LOWER = 1e-3
# How far the shell of a limb reaches from its joints, on average; what a resting robot lies on.
_SHELL = 0.04


class Base:
    """The torso's pose in the world: kinematics alone, without weight or balance.

    On its feet the robot stands on one sole, flat on the floor z = 0; at first the left one. When the other comes to be
    lower by more than 1 mm, it becomes the one: with its position and yaw of that moment, and flat. Where the feet are
    inclined to each other, so that each is lower than the other when that one is flat, the foot stays the same. A walk
    names the foot itself (`plant`).

    The sole stays where it is while the other is lifted, by more than 1 mm, and during tasks that plan with a foot in
    place (`Task.keeps_feet`). Otherwise both soles are down and slide alike, and FRAME_ROBOT between them stays.

    In a posture on the floor (Sit, LyingBack …) the vertical is the one that the posture has in the torso's frame, and
    the torso is so high that the lowest joint is 40 mm above the floor, or the lowest sole on it: an estimate, where
    the shells are not looked at. The torso's x, y and yaw in the world stay. On the way into such a posture and out of
    it the vertical turns with the movement.

    Args:
        robot: a NAO.
        q: configuration to begin with, shape (25,); the world's origin is then on the floor at FRAME_ROBOT's x and y,
            and its x axis along FRAME_ROBOT's.
        posture: the posture that this is, if it is one.

    Attributes:
        support: the foot that stands, "LLeg" or "RLeg"; None where the robot rests on the floor.
    """

    def __init__(self, robot: NaoModel, q: Floats, posture: str | None = None) -> None:
        self._robot = robot
        self._points = list(robot.body_order)
        self.support: str | None = None
        self._T_world_sole = np.eye(4)
        self._up: Floats = np.array([0.0, 0.0, 1.0])
        self._place, self._yaw = np.zeros(2), 0.0
        up = None if posture is None else robot.semantics.postures[posture].up
        if up is None:
            self.stand_on(self.standing_foot(q), q, np.eye(4))
            T_world_robot = robot_frame(robot, q, torso_in_world=self.torso(q))
            T_world_robot[2, 3] = 0.0
            self._T_world_sole = rigid_inverse(T_world_robot) @ self._T_world_sole
        else:
            self.rest(up, q, np.eye(4))

    def torso(self, q: Floats) -> Floats:
        """T_world_torso in a configuration, with what stands on the floor as it is now; shape (4, 4)."""
        if self.support is not None:
            T_torso_sole = self._robot.fk(q, self.support)
            return np.asarray(self._T_world_sole @ rigid_inverse(T_torso_sole))
        T = np.eye(4)
        T[:3, :3] = rot_z(self._yaw) @ _upright(self._up)
        T[:2, 3] = self._place
        heights = self._robot.fk(q, self._points)[:, :3, 3] @ T[2, :3]
        soles = self._robot.fk(q, list(FEET))[:, :3, 3] @ T[2, :3]
        T[2, 3] = -min(float(heights.min()) - _SHELL, float(soles.min()))
        return T

    def update(self, q: Floats, before: Floats | None = None) -> None:
        """The joints have moved: change the foot if the other sole is lower now.

        Args:
            q: configuration, shape (25,).
            before: the configuration before, to hold FRAME_ROBOT while both soles are down; None to hold the sole.
        """
        if self.support is None:
            return
        foot = self.standing_foot(q, self.support)
        if foot != self.support:
            self.stand_on(foot, q)
        elif before is not None and self._both_down(before) and self._both_down(q):
            T_world_before, T_world_after = (
                robot_frame(self._robot, one, torso_in_world=self.torso(one)) for one in (before, q)
            )
            change = T_world_before @ rigid_inverse(T_world_after)
            change[2, 3] = 0.0  # along the floor
            self._T_world_sole = change @ self._T_world_sole

    def stand_on(self, foot: str, q: Floats, T_world_torso: Floats | None = None) -> None:
        """Put a foot flat on the floor where it is, to stay there.

        Args:
            foot: "LLeg" or "RLeg".
            q: configuration, shape (25,).
            T_world_torso: the torso's pose before; None for what `torso` says.
        """
        before = self.torso(q) if T_world_torso is None else T_world_torso
        self.plant(foot, _flat(before @ self._robot.fk(q, foot)))

    def plant(self, foot: str, T_world_sole: Floats) -> None:
        """Have a foot stand with its sole in any pose, to stay there: what a walk does at each step."""
        self.support, self._T_world_sole = foot, np.array(T_world_sole)

    def rest(self, up: Floats | tuple[float, float, float], q: Floats, T_world_torso: Floats | None = None) -> None:
        """Rest on the floor.

        Args:
            up: the vertical in the torso's frame, shape (3,).
            q: configuration, shape (25,).
            T_world_torso: the torso's pose before; None for what `torso` says.
        """
        before = self.torso(q) if T_world_torso is None else T_world_torso
        if self.support is not None or T_world_torso is not None:
            # The yaw is what is left of the torso's rotation when its vertical has been made upright.
            level = before[:3, :3] @ _upright(before[2, :3]).T
            self._place, self._yaw = before[:2, 3].copy(), math.atan2(level[1, 0], level[0, 0])
        self.support = None
        vertical = np.asarray(up, dtype=np.float64)
        self._up = vertical / np.linalg.norm(vertical)

    def vertical(self, q: Floats) -> Floats:
        """The world's vertical in the torso's frame, as an accelerometer at rest shows it; shape (3,)."""
        return np.array(self.torso(q)[2, :3])

    def vertical_on_feet(self, q: Floats) -> Floats:
        """The vertical in the torso's frame if the robot stood on its lower sole in a configuration; shape (3,)."""
        return np.array(self._robot.fk(q, self.standing_foot(q))[:3, 2])

    def _both_down(self, q: Floats) -> bool:
        """Whether the other sole is not lifted from the floor that the standing one is on."""
        assert self.support is not None
        T_torso_sole, T_torso_other = self._robot.fk(q, [self.support, FEET[1 - FEET.index(self.support)]])
        return bool((rigid_inverse(T_torso_sole) @ T_torso_other)[2, 3] <= _LOWER)

    def standing_foot(self, q: Floats, before: str = FEET[0]) -> str:
        """The foot that carries the robot: `before`, unless the other is lower, and is so on its own sole too."""
        other = FEET[1 - FEET.index(before)]
        T_torso_before, T_torso_other = self._robot.fk(q, [before, other])
        T_before_other = rigid_inverse(T_torso_before) @ T_torso_other
        lower = T_before_other[2, 3] < -_LOWER and rigid_inverse(T_before_other)[2, 3] > -_LOWER
        return other if lower else before


def _flat(T: Floats) -> Floats:
    """The pose on the floor below, with the same yaw."""
    flat = np.eye(4)
    flat[:3, :3] = rot_z(math.atan2(T[1, 0], T[0, 0]))
    flat[:2, 3] = T[:2, 3]
    return flat


def _upright(up: Floats) -> Floats:
    """The smallest rotation that makes `up` the z axis, shape (3, 3); about y where up points down."""
    x, y, z = (float(component) for component in up)
    if z < -1.0 + 1e-9:
        return np.diag([-1.0, 1.0, -1.0])
    # Rodrigues with axis up × z and cosine z.
    cross = np.array([[0.0, 0.0, -x], [0.0, 0.0, -y], [x, y, 0.0]])
    return np.array(np.eye(3) + cross + cross @ cross / (1.0 + z))
