"""ALAutonomousLife and its abilities, which do nothing here, and the small services of the system."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual.arguments import Flag, one_of
from nao_kin.naoqi.virtual.engine import Call
from nao_kin.naoqi.virtual.machine import Machine
from nao_kin.naoqi.virtual.service import Service, stored

_ABILITIES = ("AutonomousBlinking", "BackgroundMovement", "BasicAwareness", "ListeningMovement", "SpeakingMovement")
Ability = Annotated[str, one_of("ability", _ABILITIES)]
LifeState = Annotated[str, one_of("state", ("solitary", "interactive", "disabled", "safeguard"))]


class ALAutonomousLife(Service):
    """The state of autonomous life, which is stored; the robot does nothing by itself.

    As on a real NAO, "disabled" makes the robot rest, and "solitary" and "interactive" wake it up.
    """

    name = "ALAutonomousLife"

    def __init__(self, nao: Machine) -> None:
        super().__init__(nao)
        self._state = "disabled"

    def getState(self) -> str:
        """One of "solitary", "interactive", "safeguard" and, initially, "disabled"."""
        return self._state

    def setState(self, state: LifeState) -> Call | None:
        """Change the state; with "disabled", returns when the robot is at rest."""
        before, self._state = self._state, state
        self.nao.log.change("life", state)
        self.nao.announce("AutonomousLife/State", state)
        motion = self.nao.services["ALMotion"]
        if state == "disabled" and before != "disabled":
            answer: Call = motion.invoke("rest")
            return answer
        if state in ("solitary", "interactive") and before == "disabled":
            motion.invoke("wakeUp")
        return None

    def getAutonomousAbilitiesStatus(self) -> list[list[Any]]:
        """[name, enabled, running] of each ability; none runs."""
        return [[ability, self.stored.get(ability, True), False] for ability in _ABILITIES]

    def setAutonomousAbilityEnabled(self, autonomousAbility: Ability, enabled: Flag) -> None:
        """Stored; no ability does anything here."""
        self.stored[autonomousAbility] = enabled

    def getAutonomousAbilityEnabled(self, autonomousAbility: Ability) -> bool:
        """The stored value; initially True."""
        return bool(self.stored.get(autonomousAbility, True))

    setRobotOffsetFromFloor, getRobotOffsetFromFloor = stored("offset from the floor", arguments.number, 0.0)

    def focusedActivity(self) -> str:
        """The activity in focus: none here."""
        return ""

    def stopAll(self) -> None:
        """End all activities: there are none here."""


class ALBattery(Service):
    """A full battery, unless a script inserts another charge in ALMemory."""

    name = "ALBattery"

    def getBatteryCharge(self) -> int:
        """The charge in per cent."""
        value = self.nao.services["ALMemory"].invoke("getData", "Device/SubDeviceList/Battery/Charge/Sensor/Value")
        return round(100.0 * arguments.number(value, "the battery's charge"))


# --- The autonomous abilities, which scripts switch off first: stored, without effect.


class _Ability(Service):
    """An autonomous ability, which does nothing here; ALAutonomousLife stores whether it is enabled."""

    ability: ClassVar[str]

    def setEnabled(self, enabled: Any) -> None:
        """Stored; the ability does nothing here."""
        self.nao.services["ALAutonomousLife"].invoke("setAutonomousAbilityEnabled", self.ability, enabled)

    def isEnabled(self) -> bool:
        """The stored value; initially True."""
        return bool(self.nao.services["ALAutonomousLife"].invoke("getAutonomousAbilityEnabled", self.ability))

    def isRunning(self, id: Any = None) -> bool:
        """False: no ability does anything here."""
        return False


class ALBasicAwareness(_Ability):
    """The ability to look at people; there are none here."""

    name, ability = "ALBasicAwareness", "BasicAwareness"

    isAwarenessRunning = _Ability.isRunning  # the name before NAOqi 2.5, as the next two

    def startAwareness(self) -> None:
        """The same as setEnabled(True)."""
        self.setEnabled(True)

    def stopAwareness(self) -> None:
        """The same as setEnabled(False)."""
        self.setEnabled(False)


ABILITIES: tuple[type[Service], ...] = (
    ALBasicAwareness,
    *(
        type(f"AL{ability}", (_Ability,), {"name": f"AL{ability}", "ability": ability})
        for ability in ("AutonomousBlinking", "BackgroundMovement", "ListeningMovement", "SpeakingMovement")
    ),
)
