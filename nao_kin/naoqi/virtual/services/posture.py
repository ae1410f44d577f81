"""ALRobotPosture and the small services: ALAutonomousLife, ALSystem, ALBattery, ALRobotModel."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin.errors import UnknownName
from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual.engine import Call
from nao_kin.naoqi.virtual.interpolation import Interpolation, at_speed
from nao_kin.naoqi.virtual.service import Kept, Service, keeps, method

if TYPE_CHECKING:
    from nao_kin.naoqi.virtual.virtual_nao import VirtualNao


# A joint this far from a posture's is still in it [rad]; NAOqi's own measure is not published.
_NEAR = 0.1
_HANDS = ("LHand", "RHand")
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


class GoToPosture(Interpolation):
    """Joints go to a posture, and the robot stands up, sits or lies down with them.

    Args:
        name: NAOqi's method.
        posture: which posture.
        nao: the virtual NAO.
        fraction: of the maximum speeds.
    """

    def __init__(self, name: str, posture: str, nao: VirtualNao, fraction: float) -> None:
        joints = nao.joints.names
        self._posture = posture
        self._q = nao.robot.clamp(nao.robot.posture(posture))
        target = nao.robot.to_body(self._q)
        speeds = fraction * nao.joints.max_speed
        super().__init__(name, joints, lambda start: at_speed(joints, target, start, speeds))
        self.value = False

    def start(self, nao: VirtualNao, time: float) -> None:
        """Note how the robot stands or lies."""
        super().start(nao, time)
        rest = nao.robot.semantics.postures[self._posture].up
        self._from_feet, self._to_feet = nao.base.support is not None, rest is None
        self._up_before = nao.base.vertical(nao.joints.q())
        self._up_after = nao.base.vertical_on_feet(self._q) if rest is None else np.array(rest)

    def advance(self, nao: VirtualNao, time: float) -> bool:
        """Move the joints, and turn the vertical as far as they have come."""
        done = super().advance(nao, time)
        if not (self._from_feet and self._to_feet) and nao.joints.stiffness.any():
            share = 1.0 if done else (time - self._start) / self._end
            nao.base.rest(_between(self._up_before, self._up_after, share), nao.joints.q())
        return done

    def end(self, nao: VirtualNao, *, killed: bool) -> None:
        """Say whether the posture is reached, and stand on a foot where it stands on feet."""
        if killed or self.started is None:
            return
        # The last command is taken at the end of this tick; what matters is whether the joints could follow.
        step = nao.joints.max_speed * 0.01 * (nao.joints.stiffness > 0.0)
        target = nao.robot.to_body(self._q)
        near = np.abs(nao.joints.sensor - target) <= step + 1e-6
        # Hands do not count, as for getPosture: openHand and closeHand leave them without stiffness.
        near[nao.joints.columns(_HANDS)] = True
        self.value = bool(near.all())
        if not self._from_feet and self._to_feet and nao.joints.stiffness.any():
            nao.base.stand_on(nao.base.standing_foot(self._q), self._q)
        nao.log.change("posture", self._posture)
        if self.value:
            nao.announce("PostureChanged", self._posture)
            nao.announce("PostureFamilyChanged", _FAMILIES.get(self._posture, "Unknown"))


class ALRobotPosture(Service):
    """Predefined postures, each reached on straight lines in the space of joints.

    NAOqi plans a way from posture to posture; here all joints set out together and arrive together, the one with the
    longest way at the given fraction of its maximum speed.
    """

    name = "ALRobotPosture"
    absent = ("getRobotPosture", "isStandCompatible")

    @method
    def getPostureList(self) -> list[str]:
        """Names of the predefined postures."""
        return list(self.nao.robot.posture_names)

    @method
    def getPostureFamilyList(self) -> list[str]:
        """Names of the families of postures."""
        return list(dict.fromkeys(_FAMILIES.values()))

    @method
    def getPosture(self) -> str:
        """The predefined posture that all joints but the hands are within 0.1 rad of; "Unknown" for none."""
        body = self.nao.joints.sensor
        looked_at = [index for index, name in enumerate(self.nao.joints.names) if name not in _HANDS]
        distances = {
            name: float(np.abs(self.nao.robot.to_body(self.nao.robot.posture(name)) - body)[looked_at].max())
            for name in self.nao.robot.posture_names
        }
        nearest = min(distances, key=lambda name: distances[name])
        return nearest if distances[nearest] <= _NEAR else "Unknown"

    @method
    def getPostureFamily(self) -> str:
        """The family of the posture; between postures, of what the robot does: stand, crouch, or "Unknown"."""
        posture = self.getPosture()
        if posture in _FAMILIES:
            return _FAMILIES[posture]
        if self.nao.base.support is None:
            return "Unknown"
        knees = self.nao.joints.sensor[self.nao.joints.columns(("LKneePitch", "RKneePitch"))]
        return "Crouching" if float(knees.min()) > _BENT_KNEES else "Standing"

    @method
    def goToPosture(self, postureName: Any, maxSpeedFraction: Any) -> Call | bool:
        """Go to a posture; True when it is reached, False where it is unknown, killed, or joints have no stiffness.

        The hands go there too, but do not count: openHand and closeHand leave them without stiffness.

        Args:
            postureName: one of getPostureList.
            maxSpeedFraction: above 0; more than 1 counts as 1, with a line in the log.
        """
        return self._go("goToPosture", postureName, maxSpeedFraction)

    @method
    def applyPosture(self, postureName: Any, maxSpeedFraction: Any) -> Call | bool:
        """The same; NAOqi's goes without planning its way."""
        return self._go("applyPosture", postureName, maxSpeedFraction)

    @method
    def stopMove(self) -> None:
        """End the way to a posture where it is, and those that wait for it."""
        for number in [task.id for task in reversed(self.nao.tasks.all) if isinstance(task, GoToPosture)]:
            self.nao.tasks.kill(number)

    @method
    def setMaxTryNumber(self, pMaxTryNumber: Any) -> None:
        """Taken and left: a posture is reached at the first try here."""
        arguments.whole(pMaxTryNumber, "pMaxTryNumber")

    def _go(self, name: str, posture: Any, fraction: Any) -> Call | bool:
        wanted = arguments.text(posture, "postureName")
        given = arguments.number(fraction, "maxSpeedFraction")
        share = arguments.fraction(min(given, 1.0), "maxSpeedFraction", positive=True)
        if given > 1.0:
            self.nao.log.write(f"{name}: maxSpeedFraction = {given:g} is clipped to 1")
        if wanted not in self.nao.robot.posture_names:
            self.nao.log.write(f"{name}: {UnknownName('posture', wanted, self.nao.robot.posture_names)}")
            return False
        return self.go_to(name, wanted, share)

    def go_to(self, name: str, posture: str, fraction: float) -> Call:
        """Start going to a posture, under any name."""
        return self.nao.start_task(GoToPosture(name, posture, self.nao, fraction))


def _between(one: Floats, other: Floats, share: float) -> Floats:
    """A direction on the arc between two; the second half of the way by the side where they are opposite."""
    mixed = (1.0 - share) * one + share * other
    length = float(np.linalg.norm(mixed))
    return other if length < 1e-6 else mixed / length


# --- The small services: ALAutonomousLife, ALSystem, ALBattery, ALRobotModel and ALPreferenceManager.

_STATES = ("solitary", "interactive", "disabled", "safeguard")


_ABILITIES = ("AutonomousBlinking", "BackgroundMovement", "BasicAwareness", "ListeningMovement", "SpeakingMovement")
_ABILITY = Kept(
    "AutonomousAbilityEnabled",
    "Kept; no ability does anything here.",
    True,
    ("autonomousAbility", "enabled"),
    arguments.flag,
    of=("ability", _ABILITIES),
)


@keeps(_ABILITY, Kept("RobotOffsetFromFloor", "Kept [m].", 0.0, ("offset",), arguments.number))
class ALAutonomousLife(Service):
    """A robot without a life of its own: the state is kept, and nothing is done by itself.

    As on the robot, "disabled" lets it rest, and solitary and interactive wake it up.
    """

    name = "ALAutonomousLife"
    absent = tuple(
        "switchFocus getActivityNature getLaunchpadPluginsForGroup getEnabledLaunchpadPlugins getFocusHistory "
        "getStateHistory startMonitoringLaunchpadConditions stopFocus".split()
    )

    def __init__(self, nao: VirtualNao) -> None:
        super().__init__(nao)
        self._state = "disabled"

    @method
    def getState(self) -> str:
        """One of "solitary", "interactive", "safeguard" and, at first, "disabled"."""
        return self._state

    @method
    def setState(self, state: Any) -> Call | None:
        """Change the state; "disabled" rests and returns when the robot does."""
        wanted = arguments.choice(state, "state", _STATES)
        before, self._state = self._state, wanted
        self.nao.log.change("life", wanted)
        self.nao.announce("AutonomousLife/State", wanted)
        motion = self.nao.services["ALMotion"]
        if wanted == "disabled" and before != "disabled":
            answer: Call = motion.invoke("rest")
            return answer
        if wanted in ("solitary", "interactive") and before == "disabled":
            motion.invoke("wakeUp")
        return None

    @method
    def focusedActivity(self) -> str:
        """The activity in focus: none here."""
        return ""

    @method
    def stopAll(self) -> None:
        """End all activities: there are none here."""

    @method
    def getAutonomousAbilitiesStatus(self) -> list[list[Any]]:
        """[name, enabled, running] of each ability; none runs."""
        return [[ability, self.kept(_ABILITY, ability), False] for ability in _ABILITIES]


class ALSystem(Service):
    """Names and versions; this machine's are not given away."""

    name = "ALSystem"
    absent = tuple(
        "reboot shutdown upgrade setRobotIcon robotIcon changePassword setTimezone timezone diskFree "
        "previousSystemVersion getDefaultRobotName".split()
    )

    def __init__(self, nao: VirtualNao) -> None:
        super().__init__(nao)
        self._name = "nao"

    @method
    def robotName(self) -> str:
        """The robot's name; at first "nao"."""
        return self._name

    @method
    def setRobotName(self, name: Any) -> bool:
        """Name the robot."""
        self._name = arguments.text(name, "name")
        return True

    @method
    def systemVersion(self) -> str:
        """The version of NAOqi whose documentation this follows: 2.8."""
        return "2.8"

    @method
    def systemInfo(self) -> list[list[str]]:
        """What this is."""
        return [["robot", self.nao.robot.name], ["python", sys.version.split()[0]]]

    @method
    def freeMemory(self) -> int:
        """0: not looked at here."""
        return 0

    @method
    def totalMemory(self) -> int:
        """0: not looked at here."""
        return 0


class ALBattery(Service):
    """A battery that is always full; what is inserted in ALMemory's key of its charge counts."""

    name = "ALBattery"
    absent = ("enablePowerMonitoring",)

    @method
    def getBatteryCharge(self) -> int:
        """Per cent of the charge."""
        value = self.nao.services["ALMemory"].invoke("getData", "Device/SubDeviceList/Battery/Charge/Sensor/Value")
        return round(100.0 * arguments.number(value, "the battery's charge"))


class ALRobotModel(Service):
    """What the robot is and has."""

    name = "ALRobotModel"

    @method
    def getRobotType(self) -> str:
        """The kind of robot: "Nao"."""
        return "Nao"

    @method
    def getConfig(self) -> str:
        """The robot as an XML document: its URDF; a robot has one of NAOqi's own."""
        return Path(self.nao.robot.urdf_path).read_text(encoding="utf-8")

    @method
    def hasArms(self) -> bool:
        """Whether it has arms: True."""
        return True

    @method
    def hasHands(self) -> bool:
        """Whether it has hands that open: True."""
        return True

    @method
    def hasLegs(self) -> bool:
        """Whether it has legs: True."""
        return True


class ALPreferenceManager(Service):
    """Preferences by domain and name, kept until the virtual NAO ends."""

    name = "ALPreferenceManager"
    absent = ("importPrefFile", "update")

    def __init__(self, nao: VirtualNao) -> None:
        super().__init__(nao)
        self._domains: dict[str, dict[str, tuple[Any, float]]] = {}

    @method
    def getValue(self, domain: Any, setting: Any) -> Any:
        """The value of a setting; None where there is none."""
        return self._domains.get(arguments.text(domain, "domain"), {}).get(_name(setting), (None,))[0]

    @method
    def setValue(self, domain: Any, setting: Any, value: Any) -> None:
        """Keep a value."""
        self._domains.setdefault(arguments.text(domain, "domain"), {})[_name(setting)] = (value, time.time())

    @method
    def getValueList(self, domain: Any) -> list[list[Any]]:
        """[setting, value] of a domain."""
        return [[name, value] for name, (value, _) in self._domains.get(arguments.text(domain, "domain"), {}).items()]

    @method
    def getDomainList(self) -> list[str]:
        """All domains, in alphabetical order."""
        return sorted(self._domains)

    @method
    def removeValue(self, domain: Any, setting: Any) -> None:
        """Forget a value."""
        values, name = self._domains.get(arguments.text(domain, "domain"), {}), _name(setting)
        if name not in values:
            raise UnknownName("setting", name, tuple(values))
        del values[name]

    @method
    def removeDomainValues(self, domain: Any) -> None:
        """Forget all values of a domain."""
        self._domains.pop(arguments.text(domain, "domain"), None)


def _name(setting: Any) -> str:
    return arguments.text(setting, "setting")
