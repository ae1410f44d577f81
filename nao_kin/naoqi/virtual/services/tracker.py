"""ALTracker: the head looks at a point, an arm points at it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats, as_floats, rigid_inverse
from nao_kin.errors import BadArgument
from nao_kin.naoqi.spaces import FRAME_TORSO, torso_in
from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual.engine import Call
from nao_kin.naoqi.virtual.service import Service, method
from nao_kin.robot import NaoModel

_HEAD = ("HeadYaw", "HeadPitch")
_CAMERA = "CameraTop"
_ARM = ("ShoulderPitch", "ShoulderRoll", "ElbowYaw", "ElbowRoll", "WristYaw")
_TASKS = ("lookAt", "pointAt")


class ALTracker(Service):
    """Looks and points at places that are given as numbers; targets that would have to be seen are not followed."""

    name = "ALTracker"
    absent = tuple(
        "track trackEvent registerTarget registerTargets unregisterTarget unregisterTargets unregisterAllTargets "
        "getRegisteredTargets getSupportedTargets getActiveTarget getTargetPosition getTargetNames "
        "getTargetCoordinates getRobotPosition isActive isNewTargetDetected isSearchEnabled isTargetLost setMode "
        "getMode getAvailableModes setEffector getEffector addEffector removeEffector setRelativePosition "
        "getRelativePosition setMaximumDistance setMoveConfig toggleSearch initialize setTimeOut getTimeOut "
        "setMaximumVelocity setMaximumAcceleration".split()
    )

    @method
    def lookAt(self, pPosition: Any, pFrame: Any, pMaxSpeed: Any, pUseWholeBody: Any = None) -> Call:
        """Turn the head so that the point is in the middle of the top camera's picture, or as near as limits allow.

        Args:
            pPosition: [x, y, z] [m].
            pFrame: FRAME_TORSO 0, FRAME_WORLD 1, FRAME_ROBOT 2; left out in calls of old scripts, and then FRAME_TORSO.
            pMaxSpeed: fraction of the maximum speed, above 0, at most 1.
            pUseWholeBody: True is taken and left: the head turns alone.
        """
        from nao_kin import ik

        if pUseWholeBody is None:
            pFrame, pMaxSpeed, pUseWholeBody = FRAME_TORSO, pFrame, pMaxSpeed
        point = self._in_torso(pPosition, pFrame)
        share = arguments.fraction(pMaxSpeed, "pMaxSpeed", positive=True)
        if arguments.flag(pUseWholeBody, "pUseWholeBody"):
            self.nao.log.write("lookAt: the head turns alone, without the whole body")
        result = ik.look_at(self.nao.robot, point, _CAMERA)
        if not result.success:
            self.nao.log.write(f"lookAt: the head cannot look at the point: {result.reason}; it turns as far as it can")
        angles = self.nao.robot.angles(result.q)
        return self._go("lookAt", _HEAD, np.array([angles[joint] for joint in _HEAD]), share)

    @method
    def pointAt(self, pEffector: Any, pPosition: Any, pFrame: Any, pMaxSpeed: Any) -> Call:
        """Stretch an arm towards a point: shoulder, hand and point are then in a line, as far as limits allow.

        Args:
            pEffector: "LArm", "RArm", or "Arms" for the one on the point's side.
            pPosition: [x, y, z] [m].
            pFrame: FRAME_TORSO 0, FRAME_WORLD 1, FRAME_ROBOT 2.
            pMaxSpeed: fraction of the maximum speed, above 0, at most 1.
        """
        effector = arguments.choice(pEffector, "effector", ("LArm", "RArm", "Arms"))
        point = self._in_torso(pPosition, pFrame)
        share = arguments.fraction(pMaxSpeed, "pMaxSpeed", positive=True)
        side = effector[0] if effector != "Arms" else "L" if point[1] >= 0.0 else "R"
        joints = tuple(f"{side}{joint}" for joint in _ARM)
        return self._go("pointAt", joints, pointing(self.nao.robot, side, point), share)

    @method
    def stopTracker(self) -> None:
        """End lookAt and pointAt where they are."""
        for number in [task.id for task in reversed(self.nao.tasks.all) if task.name in _TASKS]:
            self.nao.tasks.kill(number)

    def _in_torso(self, position: Any, frame: Any) -> Floats:
        point = as_floats(position, (3,), "pPosition")
        if point.shape != (3,):
            raise BadArgument(f"pPosition must be three numbers, got {point.size}")
        q = self.nao.joints.q()
        T_torso_frame = rigid_inverse(torso_in(self.nao.robot, q, frame, torso_in_world=self.nao.base.torso(q)))
        return np.asarray(T_torso_frame[:3, :3] @ point + T_torso_frame[:3, 3])

    def _go(self, name: str, joints: tuple[str, ...], targets: Floats, fraction: float) -> Call:
        motion = self.nao.services["ALMotion"]
        return motion.go_at_speed(name, joints, targets, fraction)  # type: ignore[attr-defined, no-any-return]


def pointing(robot: NaoModel, side: str, point: Floats) -> Floats:
    """The joint values with which a stretched arm points at a point.

    With pitch p and roll r of the shoulder the hand is at Ry(p) Rz(r) h from it, h being where it is at zero. The roll
    makes its y, and then the pitch its x and z, those of the direction to the point.

    Args:
        robot: a NAO.
        side: "L" or "R".
        point: in the torso, shape (3,) [m].

    Returns:
        ShoulderPitch, ShoulderRoll, ElbowYaw, ElbowRoll and WristYaw, limits of the shoulder left aside, shape (5,).

    Raises:
        BadArgument: the point is in the shoulder.
    """
    names = [f"{side}{joint}" for joint in _ARM]
    columns = [robot.joint_names.index(name) for name in names]
    q = robot.neutral()
    q[columns] = np.clip(0.0, robot.lower[columns], robot.upper[columns])
    stretched = q[columns]
    q[columns[:2]] = 0.0
    shoulder = robot.fk(q, names[0])[:3, 3]
    hand = robot.fk(q, f"{side}Arm")[:3, 3] - shoulder
    way = point - shoulder
    distance = float(np.linalg.norm(way))
    if distance < 1e-6:
        raise BadArgument("pPosition is in the shoulder")
    x, y, z = way * float(np.linalg.norm(hand)) / distance
    radius = math.hypot(hand[0], hand[1])
    roll = math.asin(min(max(y / radius, -1.0), 1.0)) - math.atan2(hand[1], hand[0])
    forward = math.cos(roll) * hand[0] - math.sin(roll) * hand[1]
    pitch = math.atan2(hand[2], forward) - math.atan2(z, x)
    return np.array([math.remainder(pitch, 2.0 * math.pi), roll, *stretched[2:]])
