"""ALMotion, put together from its topics."""

from __future__ import annotations

from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument
from nao_kin.motion import Motion
from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual.engine import Call
from nao_kin.naoqi.virtual.interpolation import Approach, HandMove, Interpolation, StiffnessRamp, at_speed, through
from nao_kin.naoqi.virtual.service import Service, method
from nao_kin.naoqi.virtual.services.motion_cartesian import CartesianControl, WholeBodyControl
from nao_kin.naoqi.virtual.services.motion_tools import GeneralTools
from nao_kin.naoqi.virtual.services.motion_walk import Locomotion

# --- ALMotion's joint control: angles read, set, and interpolated.

_HANDS = ("LHand", "RHand")
_THIRD = 1.0 / 3.0


class JointControl(Service):
    """The methods of ALMotion that move joints by angles.

    - angleInterpolation goes from what the joints are commanded when they are free through the keys, each at its time,
      along a monotone cubic that is at rest at both ends.
    - angleInterpolationWithSpeed goes straight: the joint with the longest way at the fraction of its maximum speed,
      the others so that all arrive together.
    - angleInterpolationBezier goes along NAOqi's handles; on the way to the first key, it leaves at rest.
    - setAngles and changeAngles return at once; each joint goes at the fraction of its own maximum speed.

    Where keys ask for more than a joint's maximum speed, the command is at the keys in time, and the joint follows
    late; the log says so. The blocking methods return when the command is at its last key.
    """

    @method
    def getAngles(self, names: Any, useSensors: Any) -> list[float]:
        """Angles of joints [rad; 0 to 1 for the hands].

        Args:
            names: a joint, a chain, "Body", "Joints", "Actuators", or a list of these.
            useSensors: True for where the joints are, False for what they are commanded.
        """
        columns = self.nao.joints.columns(self._several(names))
        sensor = arguments.flag(useSensors, "useSensors")
        values: Floats = (self.nao.joints.sensor if sensor else self.nao.joints.command)[columns]
        return [float(value) for value in values]

    @method
    def setAngles(self, names: Any, angles: Any, fractionMaxSpeed: Any) -> None:
        """Send joints to angles, each at a fraction of its maximum speed; returns at once.

        Args:
            names: a joint, a chain, "Body", or a list of these.
            angles: one for all, or a list of one for each [rad].
            fractionMaxSpeed: above 0, at most 1.
        """
        self._approach("setAngles", names, angles, "angles", fractionMaxSpeed)

    @method
    def changeAngles(self, names: Any, changes: Any, fractionMaxSpeed: Any) -> None:
        """Change angles from what the joints are commanded now; else as setAngles."""
        self._approach("changeAngles", names, changes, "changes", fractionMaxSpeed, relative=True)

    @method
    def angleInterpolation(self, names: Any, angleLists: Any, timeLists: Any, isAbsolute: Any) -> Call:
        """Move joints through angles at times; returns when the last is reached.

        Args:
            names: a joint, a chain, "Body", or a list of these.
            angleLists: an angle, a list of one for each joint, or of a list for each; of one joint also its list [rad].
            timeLists: the same of times from now, ascending, above 0 [s]; one time for each angle.
            isAbsolute: False for angles relative to what the joints are commanded at the beginning.
        """
        joints = self.joints(names)
        angles = arguments.list_each(angleLists, joints, "angles")
        times = arguments.list_each(timeLists, joints, "times")
        absolute = arguments.flag(isAbsolute, "isAbsolute")
        arguments.check_lengths(angles, times, joints, "angles")
        arguments.check_times(times, joints)

        def plan(start: Floats) -> Motion:
            keys = angles if absolute else [row + first for row, first in zip(angles, start, strict=True)]
            return through(joints, times, keys, start)

        return self.nao.start_task(Interpolation("angleInterpolation", joints, plan))

    @method
    def angleInterpolationWithSpeed(self, names: Any, targetAngles: Any, maxSpeedFraction: Any) -> Call:
        """Move joints to angles, the one with the longest way at a fraction of its maximum speed; returns at the end.

        Args:
            names: a joint, a chain, "Body", or a list of these.
            targetAngles: one for all, or a list of one for each [rad].
            maxSpeedFraction: above 0, at most 1.
        """
        joints = self.joints(names)
        targets = arguments.one_each(targetAngles, joints, "targetAngles")
        fraction = arguments.fraction(maxSpeedFraction, "maxSpeedFraction", positive=True)
        return self.go_at_speed("angleInterpolationWithSpeed", joints, targets, fraction)

    @method
    def angleInterpolationBezier(self, jointNames: Any, times: Any, controlPoints: Any) -> Call:
        """Move joints along Bezier curves in time and angle; returns when the last key is reached.

        Args:
            jointNames: a list of joints.
            times: a list of times for each joint, ascending, above 0 [s].
            controlPoints: a list for each joint, for each time the angle, or [angle, handle before, handle after], a
                handle being [type, offset in time, offset in angle] [s, rad]. The type counts for nothing: the offsets
                say it all. A handle that is left out is a third of its segment long, without slope.
        """
        joints = self.joints(jointNames, "jointNames")
        rows = arguments.list_each(times, joints, "times")
        arguments.check_times(rows, joints)
        if not isinstance(controlPoints, (list, tuple)) or len(controlPoints) != len(joints):
            count = len(controlPoints) if isinstance(controlPoints, (list, tuple)) else quoted(controlPoints, 60)
            raise BadArgument(f"controlPoints must be {len(joints)} lists, one for each joint, got {count}")
        points = [_points(*row) for row in zip(controlPoints, rows, joints, strict=True)]
        keys, handles = [row[0] for row in points], [row[1] for row in points]

        def plan(start: Floats) -> Motion:
            return Motion(
                [np.concatenate([[0.0], row]) for row in rows],
                joints,
                [np.concatenate([[first], row]) for first, row in zip(start, keys, strict=True)],
                "bezier",
                handles,
            )

        plan(np.array([row[0] for row in keys]))  # refuses handles that leave their segments, before any joint moves
        return self.nao.start_task(Interpolation("angleInterpolationBezier", joints, plan))

    @method
    def openHand(self, handName: Any) -> Call:
        """Open a hand at its maximum speed, and let go of its motor."""
        return self._hand("openHand", handName, 1.0)

    @method
    def closeHand(self, handName: Any) -> Call:
        """Close a hand at its maximum speed, and let go of its motor."""
        return self._hand("closeHand", handName, 0.0)

    # --- for the other topics -------------------------------------------------------------------------------------

    def go_at_speed(self, name: str, joints: tuple[str, ...], targets: Floats, fraction: float) -> Call:
        """Start what angleInterpolationWithSpeed does, under any name."""
        speeds = fraction * self.nao.joints.max_speed[self.nao.joints.columns(joints)]
        return self.nao.start_task(Interpolation(name, joints, lambda start: at_speed(joints, targets, start, speeds)))

    def _approach(
        self, name: str, names: Any, values: Any, what: str, fraction: Any, *, relative: bool = False
    ) -> None:
        joints = self.joints(names)
        targets = arguments.one_each(values, joints, what)
        share = arguments.fraction(fraction, "fractionMaxSpeed", positive=True)
        self.nao.start_task(Approach(name, joints, targets, share, relative=relative))

    def _hand(self, name: str, hand: Any, opening: float) -> Call:
        chosen = arguments.choice(hand, "hand", _HANDS)
        speed = float(self.nao.joints.max_speed[self.nao.joints.column[chosen]])
        return self.nao.start_task(HandMove(name, chosen, opening, speed))

    def _several(self, names: Any) -> tuple[str, ...]:
        """Joints by names, of which a list may repeat some."""
        from nao_kin.naoqi.names import joint_names

        return joint_names(self.nao.robot, names)


def _points(points: Any, times: Floats, joint: str) -> tuple[Floats, Floats]:
    """Angles (k,) and handles (k + 1, 2, 2) of one joint, the handles of where it begins before the others."""
    what = f"controlPoints of {joint}"
    if not isinstance(points, (list, tuple)) or len(points) != len(times):
        count = len(points) if isinstance(points, (list, tuple)) else quoted(points, 60)
        raise BadArgument(f"{what} must be a list of {len(times)}, one for each time, got {count}")
    keys, handles = np.empty(len(times)), np.zeros((len(times) + 1, 2, 2))
    gaps = np.diff(times, prepend=0.0) * _THIRD
    handles[1:, 0, 0], handles[:-1, 1, 0] = -gaps, gaps
    for index, point in enumerate(points):
        parts = list(point) if isinstance(point, (list, tuple)) else [point]
        if len(parts) not in (1, 3):
            raise BadArgument(
                f"{what}: entry {index} must be an angle or [angle, handle, handle], got {quoted(point, 60)}"
            )
        keys[index] = arguments.number(parts[0], f"{what}: angle {index}")
        for side, handle in enumerate(parts[1:]):
            if not isinstance(handle, (list, tuple)) or len(handle) != 3:
                raise BadArgument(
                    f"{what}: handle of entry {index} must be [type, time, angle], got {quoted(handle, 60)}"
                )
            for axis in (0, 1):
                handles[index + 1, side, axis] = arguments.number(handle[axis + 1], f"{what}: handle of entry {index}")
    return keys, handles


# --- ALMotion's stiffness control: awake, at rest, and everything between.

# How fast the robot crouches on its way to rest, as a share of the maximum speeds.
REST_SPEED = 0.3


class StiffnessControl(Service):
    """The methods of ALMotion that give and take power; 1 is full stiffness, 0 is none.

    A joint without stiffness does not move, and does not sink either.
    """

    @method
    def wakeUp(self) -> None:
        """Give all joints stiffness and have them stay where they are, as a NAO does."""
        self.nao.joints.hold()
        self.nao.joints.set_stiffness(range(len(self.nao.joints.names)), 1.0)
        self._awake(True)

    @method
    def rest(self) -> Call:
        """End all that moves, go to Crouch at three tenths of the maximum speeds, and take the stiffness away."""
        self.nao.tasks.kill_all()
        posture = self.nao.services["ALRobotPosture"]
        stiff = bool((self.nao.joints.stiffness > 0.0).any())

        def let_go(_: object = None) -> None:
            with self.nao.monitor:
                self.nao.joints.set_stiffness(range(len(self.nao.joints.names)), 0.0)
                self._awake(False)
            done.finish()

        if not stiff:
            done = Call()
            self.nao.monitor.later(let_go)
        else:
            crouching: Call = posture.go_to("rest", "Crouch", REST_SPEED)  # type: ignore[attr-defined]
            done = Call(crouching.cancel)
            crouching.add_done_callback(let_go)
        return done

    def _awake(self, awake: bool) -> None:
        self.nao.log.change("awake", awake)
        self.nao.announce("robotIsWakeUp", awake)

    @method
    def robotIsWakeUp(self) -> bool:
        """Whether all joints of the legs have stiffness."""
        columns = self.nao.joints.columns(self.joints("Legs"))
        return bool((self.nao.joints.stiffness[columns] > 0.0).all())

    @method
    def setStiffnesses(self, names: Any, stiffnesses: Any) -> None:
        """Set stiffnesses at once.

        Args:
            names: a joint, a chain, "Body", or a list of these.
            stiffnesses: one for all, or a list of one for each, from 0 to 1.
        """
        joints = self.joints(names)
        values = arguments.one_each(stiffnesses, joints, "stiffnesses")
        for joint, value in zip(joints, values.tolist(), strict=True):
            arguments.fraction(value, f"stiffness of {joint}")
        self.nao.joints.set_stiffness(self.nao.joints.columns(joints), values)

    @method
    def getStiffnesses(self, jointName: Any) -> list[float]:
        """Stiffnesses of a joint, a chain, "Body", or a list of these, from 0 to 1."""
        stiffness = self.nao.joints.stiffness
        return [float(stiffness[column]) for column in self.nao.joints.columns(self.joints(jointName))]

    @method
    def stiffnessInterpolation(self, names: Any, stiffnessLists: Any, timeLists: Any) -> Call:
        """Change stiffnesses on straight lines through values at times; returns when the last is reached.

        Args:
            names: a joint, a chain, "Body", or a list of these.
            stiffnessLists: a stiffness, a list of one for each joint, or of a list for each.
            timeLists: the same of times from now, ascending, above 0 [s].
        """
        joints = self.joints(names)
        keys = arguments.list_each(stiffnessLists, joints, "stiffnesses")
        times = arguments.list_each(timeLists, joints, "times")
        arguments.check_lengths(keys, times, joints, "stiffnesses")
        arguments.check_times(times, joints)
        for joint, row in zip(joints, keys, strict=True):
            if row.min() < 0.0 or row.max() > 1.0:
                outside = row.min() if row.min() < 0.0 else row.max()
                raise BadArgument(f"stiffness of {joint} must be between 0 and 1, got {outside:g}")
        return self.nao.start_task(StiffnessRamp(joints, times, keys))

    @method
    def setMotionConfig(self, config: Any) -> None:
        """Taken and logged; nothing here can be configured."""
        self.nao.log.write(f"setMotionConfig: {config!r} changes nothing here")


# --- ALMotion, put together from its topics.

# Methods of ALMotion in NAOqi 1.14 to 2.8; what no topic offers is answered with a list of what there is.
_NAOQI = """
    changePosition changeTransform getChainClosestObstaclePosition getFootGaitConfig getFootSteps getMoveArmsEnabled
    getMoveConfig getNextRobotPosition getPosition getRobotPosition getRobotVelocity getTaskLog getTransform
    getWalkArmsEnable getWalkArmsEnabled killMove killWalk move moveInit moveIsActive moveTo moveToward
    positionInterpolation positionInterpolations setEnableNotifications setFootSteps setFootStepsWithSpeed
    setFootTrajectory setMoveArmsEnabled setPosition setPositions setTransform setTransforms setWalkArmsEnable
    setWalkArmsEnabled setWalkTargetVelocity stopAll stopMove stopTasksUsingResources stopWalk transformInterpolation
    transformInterpolations updateTrackerTarget waitUntilMoveIsFinished waitUntilWalkIsFinished walkInit walkIsActive
    walkTo wbEnable wbEnableBalanceConstraint wbEnableEffectorControl wbEnableEffectorOptimization wbFootState
    wbGoToBalance wbSetEffectorControl
""".split()


class ALMotion(JointControl, StiffnessControl, CartesianControl, Locomotion, WholeBodyControl, GeneralTools):
    """Everything that moves: joints, stiffness, effectors, tasks."""

    name = "ALMotion"
    absent = tuple(_NAOQI)
