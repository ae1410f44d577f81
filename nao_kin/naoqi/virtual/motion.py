"""ALMotion, joined from its topics.

The methods for joints, stiffness and general tools are in this file. The module `cartesian` has those that move
effectors (setPositions …), `whole_body` those that begin with wb, and `walk` those that walk (moveTo …).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Annotated, Any

import numpy as np

from nao_kin._core.arrays import Floats, rigid_inverse
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument
from nao_kin.motion import Motion
from nao_kin.naoqi.conventions import ARMS, GROUPS, HANDS, LEGS, TORSO, chain_names, joint_names, limits, torso_in
from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual.arguments import Flag, Share, Text, Whole, one_of
from nao_kin.naoqi.virtual.body import WHOLE, mass_and_com
from nao_kin.naoqi.virtual.engine import Call
from nao_kin.naoqi.virtual.machine import AtSpeed, HandMove, Interpolation, StiffnessRamp, through
from nao_kin.naoqi.virtual.movements import GoToPosture
from nao_kin.naoqi.virtual.service import Service, SetterAndGetter, stored
from nao_kin.naoqi.virtual.walk import Locomotion
from nao_kin.naoqi.virtual.whole_body import WholeBodyControl
from nao_kin.robot import SupportPolygon

# --- ALMotion's joint control: angles read, set, and interpolated.


Hand = Annotated[str, one_of("hand", HANDS)]


class JointControl(Service):
    """The methods of ALMotion that move joints by angles.

    angleInterpolation and angleInterpolationBezier reach the keys in time; a joint that is too slow lags behind, as the
    log says. angleInterpolationWithSpeed moves all joints so that they arrive together, setAngles and changeAngles each
    joint at its own speed. The blocking methods return when the command is at its last key.
    """

    def getAngles(self, names: Any, useSensors: Flag) -> list[float]:
        """Measured or commanded angles of a joint, chain or group, or of a list of these [rad; 0 to 1 for hands]."""
        columns = self.nao.joints.columns(joint_names(self.nao.robot, names))
        return list(map(float, (self.nao.joints.sensor if useSensors else self.nao.joints.command)[columns]))

    def setAngles(self, names: Any, angles: Any, fractionMaxSpeed: Share) -> None:
        """Send joints to angles at a fraction of their maximum speeds, above 0; returns immediately.

        angles is one angle for all joints, or a list of one angle for each [rad].
        """
        self._approach("setAngles", names, angles, fractionMaxSpeed)

    def changeAngles(self, names: Any, changes: Any, fractionMaxSpeed: Share) -> None:
        """Change the commanded angles; otherwise the same as setAngles."""
        self._approach("changeAngles", names, changes, fractionMaxSpeed)

    def angleInterpolation(self, names: Any, angleLists: Any, timeLists: Any, isAbsolute: Flag) -> Call:
        """Move joints through angles at times; returns when the last angle is reached.

        angleLists is one angle, a list of one angle for each joint, or a list of one list for each joint; for one joint
        also just its list [rad]. timeLists has a time for each angle, ascending, above 0 [s]. With isAbsolute False,
        angles are relative to the commanded ones.
        """
        joints = self.joints(names)
        angles, times = arguments.timed(angleLists, timeLists, joints, "angles")

        def plan(start: Floats) -> Motion:
            keys = angles if isAbsolute else [row + first for row, first in zip(angles, start, strict=True)]
            return through(joints, times, keys, start)

        return self.nao.tasks.add(Interpolation("angleInterpolation", joints, plan))

    def angleInterpolationWithSpeed(self, names: Any, targetAngles: Any, maxSpeedFraction: Share) -> Call:
        """Move joints to angles, the slowest at a fraction of its maximum speed; returns at the end.

        targetAngles is one angle for all joints, or a list of one angle for each [rad].
        """
        joints = self.joints(names)
        targets = arguments.one_each(targetAngles, joints, "targetAngles")
        return self.nao.tasks.add(AtSpeed("angleInterpolationWithSpeed", self.nao, joints, targets, maxSpeedFraction))

    def angleInterpolationBezier(self, jointNames: Any, times: Any, controlPoints: Any) -> Call:
        """Move joints along Bezier curves in time and angle; returns when the last key is reached.

        times and controlPoints have a list for each joint. Times ascend and are above 0 [s]. For each time there is a
        point: an angle, or [angle, handle before, handle after]. A handle is [type, offset in time, offset in angle]
        [s, rad]; its type is ignored. A missing handle is horizontal, with a third of the length of its segment.
        """
        joints = self.joints(jointNames, "jointNames")
        rows = arguments.list_each(times, joints, "times")
        arguments.check_times(rows, joints)
        lists = arguments.entries(controlPoints, "controlPoints", len(joints))
        points = [_points(*row) for row in zip(lists, rows, joints, strict=True)]
        keys, handles = [row[0] for row in points], [row[1] for row in points]

        def plan(start: Floats) -> Motion:
            return through(joints, rows, keys, start, "bezier", handles)

        plan(np.array([row[0] for row in keys]))  # rejects handles outside their segments, before any joint moves
        return self.nao.tasks.add(Interpolation("angleInterpolationBezier", joints, plan))

    def openHand(self, handName: Hand) -> Call:
        """Open a hand at its maximum speed, and remove its stiffness."""
        return self.nao.tasks.add(HandMove("openHand", self.nao, (handName,), np.ones(1), 1.0))

    def closeHand(self, handName: Hand) -> Call:
        """Close a hand at its maximum speed, and remove its stiffness."""
        return self.nao.tasks.add(HandMove("closeHand", self.nao, (handName,), np.zeros(1), 1.0))

    # --- inside ---------------------------------------------------------------------------------------------------

    def _approach(self, name: str, names: Any, values: Any, fraction: float) -> None:
        joints, relative = self.joints(names), name == "changeAngles"
        targets = arguments.one_each(values, joints, "changes" if relative else "angles")
        task = AtSpeed(name, self.nao, joints, targets, fraction, relative=relative, together=False, reactive=True)
        self.nao.tasks.add(task)


def _points(points: Any, times: Floats, joint: str) -> tuple[Floats, Floats]:
    """Return angles (k,) and handles (k + 1, 2, 2) of one joint, the handles at its start first."""
    what = f"controlPoints of {joint}"
    keys, handles = np.empty(len(times)), np.zeros((len(times) + 1, 2, 2))
    gaps = np.diff(times, prepend=0.0) * (1.0 / 3.0)
    handles[1:, 0, 0], handles[:-1, 1, 0] = -gaps, gaps
    for index, point in enumerate(arguments.entries(points, what, len(times))):
        entry, parts = f"entry {index}", list(point) if arguments.is_list(point) else [point]
        if len(parts) not in (1, 3):
            raise BadArgument(f"{what}: {entry} must be an angle or [angle, handle, handle], got {quoted(point, 60)}")
        keys[index] = arguments.number(parts[0], f"{what}: angle {index}")
        for side, handle in enumerate(parts[1:]):
            of = f"{what}: handle of {entry}"
            handles[index + 1, side] = [arguments.number(value, of) for value in arguments.entries(handle, of, 3)[1:]]
    return keys, handles


# --- ALMotion's stiffness control.

# The share of the maximum speeds at which the robot crouches to rest.
REST_SPEED = 0.3


class StiffnessControl(Service):
    """The methods of ALMotion that set stiffness, from 0 to 1; a joint without stiffness does not move or sink."""

    def wakeUp(self) -> None:
        """Switch on the stiffness of all joints and keep their values, as a NAO does."""
        self.nao.joints.hold()
        self._awake(True)

    def rest(self) -> Call | None:
        """End all tasks, move to Crouch at three tenths of the maximum speeds, and remove the stiffness."""
        self.nao.tasks.kill()
        if not self.nao.joints.stiffness.any():
            self._awake(False)
            return None

        def release(_: object) -> None:
            with self.nao.monitor:
                self._awake(False)
            done.finish()

        crouching = self.nao.tasks.add(GoToPosture("rest", "Crouch", self.nao, REST_SPEED))
        done = Call(crouching.cancel)
        crouching.add_done_callback(release)
        return done

    def _awake(self, awake: bool) -> None:
        self.nao.joints.set_stiffness(range(len(self.nao.joints.names)), float(awake))
        self.nao.log.change("awake", awake)
        self.nao.announce("robotIsWakeUp", awake)

    def robotIsWakeUp(self) -> bool:
        """Whether all joints of the legs have stiffness."""
        columns = self.nao.joints.columns(self.joints("Legs"))
        return bool((self.nao.joints.stiffness[columns] > 0.0).all())

    def setStiffnesses(self, names: Any, stiffnesses: Any) -> None:
        """Set stiffnesses from 0 to 1 immediately: one for all joints, or a list of one for each."""
        joints = self.joints(names)
        values = arguments.one_each(stiffnesses, joints, "stiffnesses")
        _check_stiffnesses(joints, values)
        self.nao.joints.set_stiffness(self.nao.joints.columns(joints), values)

    def getStiffnesses(self, jointName: Any) -> list[float]:
        """Stiffnesses of a joint, a chain, "Body", or a list of these, from 0 to 1."""
        stiffness = self.nao.joints.stiffness
        return [float(stiffness[column]) for column in self.nao.joints.columns(self.joints(jointName))]

    def stiffnessInterpolation(self, names: Any, stiffnessLists: Any, timeLists: Any) -> Call:
        """Change stiffnesses on straight lines through values at times; returns when the last value is reached.

        stiffnessLists and timeLists have the forms of angleLists and timeLists of angleInterpolation.
        """
        joints = self.joints(names)
        keys, times = arguments.timed(stiffnessLists, timeLists, joints, "stiffnesses")
        _check_stiffnesses(joints, keys)
        return self.nao.tasks.add(StiffnessRamp(joints, times, keys))

    def setMotionConfig(self, config: Any) -> None:
        """Accepted and logged, without effect."""
        self.nao.log.write(f"setMotionConfig: {config!r} changes nothing here")


def _check_stiffnesses(joints: Sequence[str], rows: Iterable[Floats | float]) -> None:
    for joint, row in zip(joints, rows, strict=True):
        for value in np.ravel(row).tolist():
            arguments.fraction(value, f"stiffness of {joint}")


# --- General tools: names, limits, masses, tasks, and switches of reflexes, which are not simulated.

_ARMS = ("Arms", *ARMS)
_IDLE = ("Body", "Legs", *_ARMS, "Head")
_BREATH = {"Bpm": 12.0, "Amplitude": 0.5}


def _switches(what: str, of: Sequence[str], initially: bool = True, answer: bool | None = None) -> SetterAndGetter:
    """Return the setter and the getter of a switch that is only stored for chains; for any name if `of` is empty."""

    def read(chain: Any) -> str:
        return arguments.choice(chain, "chain", of) if of else arguments.text(chain, "pName")

    def setter(self: Service, chain: Any, enable: Any) -> bool | None:
        chosen, on = read(chain), arguments.flag(enable, "the last argument")
        chains = (chosen, *ARMS) if chosen == "Arms" else (chosen,)
        self.stored |= dict.fromkeys([(what, each) for each in chains], on)
        self.nao.log.write(f"{what} of {chosen} = {on}: stored, without effect")
        return answer

    def getter(self: Service, chain: Any) -> bool:
        return bool(self.stored.get((what, read(chain)), initially))

    setter.__doc__ = f"Switch {what} on or off; stored, without effect."
    getter.__doc__ = f"The stored value; initially {initially}."
    return setter, getter


class GeneralTools(Service):
    """The methods of ALMotion about the robot and its tasks; switches of reflexes are only stored."""

    # --- the robot ------------------------------------------------------------------------------------------------

    def getBodyNames(self, name: Text) -> list[str]:
        """Names of the joints of a chain or group; of all chains for "Chains"."""
        if name == "Chains":
            return list(chain_names(self.nao.robot))
        return list(joint_names(self.nao.robot, name))

    getJointNames = getBodyNames  # the name before NAOqi 1.14

    def getSensorNames(self) -> list[str]:
        """Names of the sensors for getPosition."""
        frames = [name.removesuffix("_frame") for name in self.nao.robot.frame_names if name.endswith("_frame")]
        return sorted(name.removeprefix("ImuTorso") for name in frames)

    def getLimits(self, name: Any) -> list[list[float]]:
        """[minAngle, maxAngle, maxVelocity, maxTorque] of a joint, or of each joint of a chain or group."""
        return [[float(value) for value in row] for row in limits(self.nao.robot, name)]

    def getMotionCycleTime(self) -> int:
        """The period of ALMotion's cycle as NAOqi documents it: 20 ms; a tick of the virtual NAO takes 10 ms."""
        return 20

    def getRobotConfig(self) -> list[list[Any]]:
        """Names and values of the robot's configuration."""
        # NAOqi writes VERSION_60 for a V6, VERSION_33 for a V3.3.
        version = f"VERSION_{self.nao.robot.version.removeprefix('v').replace('.', ''):0<2}"
        config = {"Model Type": "naoH25", "Head Version": version, "Body Version": version, "Laser": False}
        config |= dict.fromkeys(("Legs", "Arms", "Extended Arms", "Hands"), True)
        config |= {"Arm Version": version, "Number of Legs": 2, "Number of Arms": 2, "Number of Hands": 2}
        return [list(config), list(config.values())]

    def getSummary(self) -> str:
        """Joints, stiffnesses, commands and sensors as a table."""
        joints = self.nao.joints
        lines = [f"{'Joint':<16}{'Stiffness':>10}{'Command':>12}{'Sensor':>12}"]
        rows = zip(joints.names, joints.stiffness, joints.command, joints.sensor, strict=True)
        lines += [f"{name:<16}{stiff:>10.2f}{command:>12.6f}{sensor:>12.6f}" for name, stiff, command, sensor in rows]
        tasks = ", ".join(f"{task.name} ({task.id})" for task in self.nao.tasks.all) or "none"
        return "\n".join([*lines, f"Tasks: {tasks}", ""])

    def getMass(self, pName: Text) -> float:
        """Mass of a joint's segment, a chain, "Torso", or of all: "Body", "Joints" or "Com" [kg]."""
        return mass_and_com(self.nao.robot, self.nao.joints.q(), self._part(pName))[0]

    def getCOM(self, pName: Text, pSpace: Any, pUseSensorValues: Flag) -> list[float]:
        """Centre of mass of a part, as in getMass, measured or commanded, in a space [m]."""
        q = self.nao.joints.q(sensor=pUseSensorValues)
        _, com = mass_and_com(self.nao.robot, q, self._part(pName))
        T = torso_in(self.nao.robot, q, pSpace, torso_in_world=self.nao.base.torso(q))
        return [float(value) for value in T[:3, :3] @ com + T[:3, 3]]

    def getSupportPolygon(self, frame: Any, useSensorValues: Flag) -> list[list[float]]:
        """Corners [x, y] of the support polygon of the soles on the floor, counter-clockwise, in a space [m].

        The corners of a sole are its pressure sensors; empty if the robot does not stand on its feet.
        """
        robot, base = self.nao.robot, self.nao.base
        q = self.nao.joints.q(sensor=useSensorValues)
        space = torso_in(robot, q, frame, torso_in_world=base.torso(q)) @ rigid_inverse(base.torso(q))
        down = () if base.support is None else [foot for foot in LEGS if base.is_down(foot, q)]
        if not down:
            return []
        feet = {foot: base.torso(q) @ robot.fk(q, foot) for foot in down}
        corners = SupportPolygon.of_soles((T, robot.sole_outline(foot, "sensors")) for foot, T in feet.items()).vertices
        # The corners are on the floor, z = 0.
        return [[float(value) for value in row] for row in corners @ space[:2, :2].T + space[:2, 3]]

    def _part(self, name: str) -> str:
        parts = ("Torso", *WHOLE, *chain_names(self.nao.robot), *GROUPS, *self.nao.joints.names)
        return arguments.choice(name, "part", parts)

    # --- tasks ----------------------------------------------------------------------------------------------------

    def getTaskList(self) -> list[list[Any]]:
        """[name, id] of each motion task, waiting ones last."""
        return [[task.name, task.id] for task in self.nao.tasks.all]

    def areResourcesAvailable(self, resourceNames: Any) -> bool:
        """True if no blocking task has reserved any of these joints."""
        return self.nao.tasks.booked().isdisjoint(self.joints(resourceNames, "resourceNames"))

    def killTask(self, motionTaskID: Whole) -> bool:
        """End a task before it is done; returns whether there was one with this id."""
        return self.nao.tasks.kill(lambda task: task.id == motionTaskID)

    def killTasksUsingResources(self, resourceNames: Any) -> None:
        """End the blocking tasks that hold these joints or wait for them; as in NAOqi, reactive tasks continue."""
        needed = frozenset(self.joints(resourceNames, "resourceNames"))
        self.nao.tasks.kill(lambda task: not task.reactive and not needed.isdisjoint(task.joints))

    def killAll(self) -> None:
        """End all tasks before they are done."""
        self.nao.tasks.kill()

    setEnableNotifications, areNotificationsEnabled = stored("switch of notifications", arguments.flag, True)

    # --- reflexes, which are not simulated ------------------------------------------------------------------------

    setFallManagerEnabled, getFallManagerEnabled = stored("fall manager", arguments.flag, True)
    setSmartStiffnessEnabled, getSmartStiffnessEnabled = stored("smart stiffness", arguments.flag, True, answer=True)
    setDiagnosisEffectEnabled, getDiagnosisEffectEnabled = stored("diagnosis effect", arguments.flag, True)
    setPushRecoveryEnabled, getPushRecoveryEnabled = stored("push recovery", arguments.flag, True)
    setCollisionProtectionEnabled, getCollisionProtectionEnabled = _switches("collision protection", _ARMS, answer=True)
    setExternalCollisionProtectionEnabled, getExternalCollisionProtectionEnabled = _switches("external protection", ())
    setBreathEnabled, getBreathEnabled = _switches("breath", _IDLE, initially=False)
    setIdlePostureEnabled, getIdlePostureEnabled = _switches("idle posture", _IDLE, initially=False)
    setOrthogonalSecurityDistance, getOrthogonalSecurityDistance = stored(
        "orthogonal security distance", arguments.duration, 0.4
    )
    setTangentialSecurityDistance, getTangentialSecurityDistance = stored(
        "tangential security distance", arguments.duration, 0.1
    )

    def isCollision(self, pChainName: Annotated[str, one_of("chain", _ARMS)]) -> str:
        """Always "none": collisions are not detected here."""
        return "none"

    def setBreathConfig(self, pConfig: Any) -> None:
        """Stored: [["Bpm", 5 to 30], ["Amplitude", 0 to 1]]."""
        for name, value in arguments.pairs(pConfig, "pConfig"):
            key = arguments.choice(name, "parameter", tuple(_BREATH))
            self.stored[key] = arguments.number(value, key)

    def getBreathConfig(self) -> list[list[Any]]:
        """The stored values."""
        return [[key, self.stored.get(key, value)] for key, value in _BREATH.items()]


# --- ALMotion, joined from its topics.

# The beginnings of the methods that need compiled kernels of nk.ik.
_PATHS = ("positionInterpolation", "transformInterpolation")
_MOVES = ("setPosition", "setTransform", "changePosition", "changeTransform", *_PATHS)
_WALKS = ("move", "walk", "setFootSteps", "setWalkTarget")


class ALMotion(JointControl, StiffnessControl, WholeBodyControl, Locomotion, GeneralTools):
    """The service that moves joints, stiffness, effectors and the whole robot."""

    name = "ALMotion"

    def kernels_for(self, name: str, given: tuple[Any, ...]) -> frozenset[str]:
        """Return the kernels that a call needs to move effectors, to walk, or for the whole body."""
        moves, walks = name.startswith(_MOVES), name.startswith(_WALKS) and not name.endswith("Active")
        on_feet = self.balance.enabled or any(part in str(given[:1]) for part in (TORSO, "Leg"))
        bodies = name.startswith("wb") or (moves and on_feet)
        needed = {"damped least squares": moves, "both legs": walks, "bodies": bodies}
        return frozenset(kernel for kernel, is_needed in needed.items() if is_needed)
