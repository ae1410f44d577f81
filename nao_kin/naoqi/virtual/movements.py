"""ALRobotPosture, ALTracker, ALBehaviorManager and ALAnimationPlayer."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np

from nao_kin import ik
from nao_kin._core.arrays import Floats, rigid_inverse
from nao_kin.errors import BadArgument, NaoKinError, UnknownName
from nao_kin.motion import Motion, read_motion
from nao_kin.naoqi.conventions import ARMS, FRAME_TORSO, HANDS, torso_in
from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual.arguments import Number, Point, Share, Text, Whole, one_of
from nao_kin.naoqi.virtual.engine import TICK, Call
from nao_kin.naoqi.virtual.machine import AtSpeed, Interpolation, Machine
from nao_kin.naoqi.virtual.service import Service

# --- ALRobotPosture: the robot moves to a posture.

# The tolerance of a posture [rad]; NAOqi's own is not published.
_NEAR = 0.1
_FAMILIES = {
    "Stand": "Standing",
    "StandInit": "Standing",
    "StandZero": "Standing",
    "Crouch": "Crouching",
    "Sit": "Sitting",
    "SitRelax": "Sitting",
    "LyingBelly": "LyingBelly",
    "LyingBack": "LyingBack",
}
_BENT_KNEES = 1.5


class GoToPosture(AtSpeed):
    """Joints move to a posture, while the robot stands up, sits or lies down."""

    def __init__(self, name: str, posture: str, nao: Machine, fraction: float) -> None:
        self._posture = posture
        self._q = nao.robot.clamp(nao.robot.posture(posture))
        self._target = nao.robot.to_body(self._q)
        super().__init__(name, nao, nao.joints.names, self._target, fraction)
        self.value = False

    def start(self, nao: Machine, time: float) -> None:
        """Note whether the robot stands or lies."""
        super().start(nao, time)
        rest = nao.robot.semantics.postures[self._posture].up
        self._from_feet, self._to_feet = nao.base.support is not None, rest is None
        self.keeps_feet = not self._from_feet  # its end puts a foot in place
        self._up_before = nao.base.vertical(nao.joints.q())
        foot = nao.base.standing_foot(self._q)
        self._up_after = nao.robot.fk(self._q, foot)[:3, 2] if rest is None else np.array(rest)

    def advance(self, nao: Machine, time: float) -> bool:
        """Move the joints, and turn the vertical with them."""
        done = super().advance(nao, time)
        if not (self._from_feet and self._to_feet) and nao.joints.stiffness.any():
            share = 1.0 if done else (time - self.begin) / self._end
            nao.base.rest(_between(self._up_before, self._up_after, share), nao.joints.q())
        return done

    def end(self, nao: Machine, *, killed: bool) -> None:
        """Set the result to whether the posture was reached; if it is a posture on the feet, stand on a foot."""
        super().end(nao, killed=killed)
        if killed or self.started is None:
            return
        # The last command is applied at the end of this tick; check whether the joints could follow.
        step = nao.joints.max_speed * TICK * (nao.joints.stiffness > 0.0)
        near = np.abs(nao.joints.sensor - self._target) <= step + 1e-6
        # Hands do not count, as for getPosture: openHand and closeHand leave them without stiffness.
        near[nao.joints.columns(HANDS)] = True
        self.value = bool(near.all())
        if not self._from_feet and self._to_feet and nao.joints.stiffness.any():
            nao.base.stand_up(nao.base.standing_foot(self._q), self._q)
        nao.log.change("posture", self._posture)
        if self.value:
            nao.announce("PostureChanged", self._posture)
            nao.announce("PostureFamilyChanged", _FAMILIES.get(self._posture, "Unknown"))


class ALRobotPosture(Service):
    """Predefined postures, each reached on a straight line in joint space.

    NAOqi plans a path from posture to posture; here all joints start and arrive together, the slowest at the given
    fraction of its maximum speed.
    """

    name = "ALRobotPosture"

    def getPostureList(self) -> list[str]:
        """Names of the predefined postures."""
        return list(self.nao.robot.posture_names)

    def getPostureFamilyList(self) -> list[str]:
        """Names of the families of postures."""
        return list(dict.fromkeys(_FAMILIES.values()))

    def getPosture(self) -> str:
        """The predefined posture from which no joint differs by more than 0.1 rad, except the hands; or "Unknown"."""
        body = self.nao.joints.sensor
        checked = [index for index, name in enumerate(self.nao.joints.names) if name not in HANDS]
        distances = {
            name: float(np.abs(self.nao.robot.to_body(self.nao.robot.posture(name)) - body)[checked].max())
            for name in self.nao.robot.posture_names
        }
        nearest = min(distances, key=lambda name: distances[name])
        return nearest if distances[nearest] <= _NEAR else "Unknown"

    def getPostureFamily(self) -> str:
        """The family of the predefined posture; in any other posture "Standing", "Crouching" or "Unknown"."""
        posture = self.getPosture()
        if posture in _FAMILIES:
            return _FAMILIES[posture]
        if self.nao.base.support is None:
            return "Unknown"
        knees = self.nao.joints.sensor[self.nao.joints.columns(("LKneePitch", "RKneePitch"))]
        return "Crouching" if float(knees.min()) > _BENT_KNEES else "Standing"

    def goToPosture(self, postureName: Text, maxSpeedFraction: Number) -> Call | bool:
        """Move to a posture at a fraction of the maximum speeds, above 0; a fraction above 1 counts as 1.

        Returns True if the posture is reached; False if it is unknown, the task was killed, or joints have no
        stiffness. The hands move too, but do not count: openHand and closeHand leave them without stiffness.
        """
        share = arguments.fraction(min(maxSpeedFraction, 1.0), "maxSpeedFraction", positive=True)
        if maxSpeedFraction > 1.0:
            self.nao.log.write(f"goToPosture: maxSpeedFraction = {maxSpeedFraction:g} is clipped to 1")
        if postureName not in self.nao.robot.posture_names:
            self.nao.log.write(f"goToPosture: {UnknownName('posture', postureName, self.nao.robot.posture_names)}")
            return False
        return self.nao.tasks.add(GoToPosture("goToPosture", postureName, self.nao, share))

    applyPosture = goToPosture  # in NAOqi, without path planning

    def stopMove(self) -> None:
        """End the movements to postures, running and waiting."""
        self.nao.tasks.kill(lambda task: isinstance(task, GoToPosture))

    def setMaxTryNumber(self, pMaxTryNumber: Whole) -> None:
        """Accepted without effect: a posture is reached at the first try here."""


def _between(one: Floats, other: Floats, share: float) -> Floats:
    """Return the direction at a fraction of the arc between two directions; the second one if they are opposite."""
    mixed = (1.0 - share) * one + share * other
    length = float(np.linalg.norm(mixed))
    return other if length < 1e-6 else mixed / length


# --- ALTracker: the head looks at a point, or an arm points at it.

_HEAD = ("HeadYaw", "HeadPitch")
_CAMERA = "CameraTop"
_TASKS = ("lookAt", "pointAt")
SomeArm = Annotated[str, one_of("effector", (*ARMS, "Arms"))]


class ALTracker(Service):
    """Looks and points at given positions; targets that require vision are not tracked."""

    name = "ALTracker"

    def lookAt(self, pPosition: Point, pFrame: Any, pMaxSpeed: Any, pUseWholeBody: Any = None) -> Call:
        """Turn the head until a point [x, y, z] [m] is in the centre of the top camera's image, as far as limits allow.

        Without pFrame, as in old scripts, the point is in FRAME_TORSO. pUseWholeBody has no effect: only the head
        turns.
        """
        if pUseWholeBody is None:
            pFrame, pMaxSpeed, pUseWholeBody = FRAME_TORSO, pFrame, pMaxSpeed
        point = self._in_torso(pPosition, pFrame)
        share = arguments.fraction(pMaxSpeed, "pMaxSpeed", positive=True)
        if arguments.flag(pUseWholeBody, "pUseWholeBody"):
            self.nao.log.write("lookAt: the head turns alone, without the whole body")
        result = ik.look_at(self.nao.robot, point, _CAMERA)
        if not result.success:
            self.nao.log.write(f"lookAt: the head cannot look at the point: {result.reason}; it turns as far as it can")
        angles = self.nao.robot.to_body(result.q)[self.nao.joints.columns(_HEAD)]
        return self.nao.tasks.add(AtSpeed("lookAt", self.nao, _HEAD, angles, share))

    def pointAt(self, pEffector: SomeArm, pPosition: Point, pFrame: Any, pMaxSpeed: Share) -> Call:
        """Stretch an arm towards a point [x, y, z] [m], so that shoulder, hand and point are in line, if limits allow.

        pEffector is "LArm", "RArm", or "Arms" for the one on the point's side.
        """
        point = self._in_torso(pPosition, pFrame)
        side = pEffector[0] if pEffector != "Arms" else "L" if point[1] >= 0.0 else "R"
        q = self.nao.joints.q(sensor=False)
        shoulder = self.nao.robot.position(q, f"{side}ShoulderPitch")
        way = point - shoulder
        distance = float(np.linalg.norm(way))
        if distance < 1e-6:
            raise BadArgument("pPosition is in the shoulder, so it has no direction from there")
        # A place one metre away is out of reach: the arm stretches towards it.
        arm = ik.arm(self.nao.robot, side, shoulder + way / distance, near=q)
        return self.nao.tasks.add(AtSpeed("pointAt", self.nao, arm.joints, arm.best, pMaxSpeed))

    def registerTarget(self, pTarget: Text, pParams: Any = None) -> None:
        """Name a target in the log; it would be followed by vision, which is not here."""
        self.nao.log.write(f"registerTarget: {pTarget} would need vision; lookAt and pointAt take places")

    def stopTracker(self) -> None:
        """End lookAt and pointAt."""
        self.nao.tasks.kill(lambda task: task.name in _TASKS)

    def _in_torso(self, point: Floats, frame: Any) -> Floats:
        q = self.nao.joints.q()
        T_torso_frame = rigid_inverse(torso_in(self.nao.robot, q, frame, torso_in_world=self.nao.base.torso(q)))
        return np.asarray(T_torso_frame[:3, :3] @ point + T_torso_frame[:3, 3])


# --- ALBehaviorManager and ALAnimationPlayer: the timelines of Choregraphe's behaviours, played.

# The name of Choregraphe's files; the folder names the behaviour.
_FILE = "behavior"
# The replacements for [posture] in ALAnimationPlayer.
_POSTURES = {"Standing": "Stand", "Sitting": "Sit"}


class Playing(Interpolation):
    """Joints follow the timeline of a behaviour."""

    def __init__(self, name: str, behavior: str, motion: Motion) -> None:
        super().__init__(name, motion.joint_names, lambda start: led_in(motion, start))
        self.behavior = behavior


class ALBehaviorManager(Service):
    """The behaviours (.xar) in the folder of `nao-kin serve --behaviors FOLDER`, or of `VirtualNao(behaviors=FOLDER)`.

    The file dance/behavior_1/behavior.xar is the behaviour dance/behavior_1, the file wave.xar is wave. Its timeline is
    played: joints move from their commanded values to its first keys, and then through the others. If a file has
    several timelines, wave/1 is the first one, and wave/NAME the one of a box. Boxes and scripts are not run.
    """

    name = "ALBehaviorManager"

    def getInstalledBehaviors(self) -> list[str]:
        """Names of all behaviours in the folder; `isBehaviorInstalled` tells which can be played."""
        return sorted(self._files())

    def isBehaviorInstalled(self, name: Text) -> bool:
        """Whether there is such a behaviour and it can be played; if it cannot, the log says why."""
        try:
            self._motion(name)
        except NaoKinError as error:
            self.nao.log.write(f"isBehaviorInstalled: {error}")
            return False
        return True

    def runBehavior(self, name: Text) -> Call:
        """Play a behaviour; returns at its end."""
        return self._play("runBehavior", name)

    def startBehavior(self, name: Text) -> None:
        """Play a behaviour; returns immediately."""
        self._play("startBehavior", name)

    def stopBehavior(self, name: Text) -> None:
        """End a behaviour; does nothing if it is not running."""
        self.nao.tasks.kill(lambda task: isinstance(task, Playing) and task.behavior == name)

    def stopAllBehaviors(self) -> None:
        """End all behaviours."""
        self.nao.tasks.kill(lambda task: isinstance(task, Playing))

    def isBehaviorRunning(self, name: Text) -> bool:
        """Whether a behaviour is running, or waits for its joints."""
        return name in self.getRunningBehaviors()

    def getRunningBehaviors(self) -> list[str]:
        """Names of the running behaviours."""
        return sorted(task.behavior for task in self.nao.tasks.all if isinstance(task, Playing))

    def preloadBehavior(self, name: Text) -> bool:
        """Without effect; returns whether there is such a behaviour."""
        return self.isBehaviorInstalled(name)

    # Behaviours are not preloaded here.
    isBehaviorLoaded, getLoadedBehaviors = isBehaviorRunning, getRunningBehaviors
    # The names before NAOqi 1.22.
    getBehaviorNames, isBehaviorPresent = getInstalledBehaviors, isBehaviorInstalled

    def _play(self, task: str, name: str) -> Call:
        """Start a behaviour as a task of this name; reject unknown, running and unreadable behaviours."""
        if self.isBehaviorRunning(name):
            raise BadArgument(f"{name} is running already")
        return self.nao.tasks.add(Playing(task, name, self._motion(name)))

    def _motion(self, name: str) -> Motion:
        """Return the motion of a behaviour; raise an error for one that is unknown or cannot be played."""
        files = self._files()
        if self.nao.behaviors is None:
            raise BadArgument("no behaviours are installed; give nao-kin serve or run --behaviors FOLDER")
        file = max((file for file in files if f"{name}/".startswith(f"{file}/")), key=len, default=None)
        if file is None:
            raise UnknownName("behaviour", name, tuple(files))
        return read_motion(files[file], format="xar", timeline=name[len(file) + 1 :] or None, robot=self.nao.robot)

    def _files(self) -> dict[str, Path]:
        folder = self.nao.behaviors
        if folder is None:
            return {}
        files = {}
        for path in folder.rglob("*.xar"):
            name = path.relative_to(folder).with_suffix("")
            files[(name.parent if name.name == _FILE and name.parent.name else name).as_posix()] = path
        return files


class ALAnimationPlayer(Service):
    """Plays behaviours of ALBehaviorManager; Aldebaran's animations are not part of nao_kin."""

    name = "ALAnimationPlayer"

    def run(self, path: Text) -> Call:
        """Play a behaviour; returns at its end. In its name, [robot] stands for Nao, [posture] for Stand or Sit."""
        name = path.replace("[robot]", "Nao")
        if "[posture]" in name:
            family = self.nao.services["ALRobotPosture"].invoke("getPostureFamily")
            if family not in _POSTURES:
                raise BadArgument(f"[posture] stands for Stand or Sit, but the robot's family of postures is {family}")
            name = name.replace("[posture]", _POSTURES[family])
        return self.nao.services["ALBehaviorManager"]._play("ALAnimationPlayer.run", name)  # type: ignore[no-any-return]


def led_in(motion: Motion, start: Floats) -> Motion:
    """Return the motion with a key of every joint at time zero: its value in `start` (n,), with horizontal handles."""
    curves = motion.as_bezier()
    assert curves.handles is not None
    times, keys, handles = list(curves.times), list(curves.keys), list(curves.handles)
    for joint, first in enumerate(start):
        gap = float(times[joint][0])
        if gap > 0.0:
            times[joint] = np.insert(times[joint], 0, 0.0)
            keys[joint] = np.insert(keys[joint], 0, first)
            handles[joint] = np.insert(handles[joint], 0, np.zeros((2, 2)), axis=0)
            handles[joint][0, 1, 0], handles[joint][1, 0] = gap / 3.0, (-gap / 3.0, 0.0)
    return Motion(times, motion.joint_names, keys, "bezier", handles)
