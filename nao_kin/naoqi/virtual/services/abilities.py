"""The autonomous abilities, which scripts switch off before they begin: kept, and nothing moves by itself here."""

from __future__ import annotations

from typing import Any, ClassVar

from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual.service import Kept, Service, keeps, method


class _Ability(Service):
    """An autonomous ability; ALAutonomousLife keeps whether it is enabled, and it does nothing here."""

    ability: ClassVar[str]

    @method
    def setEnabled(self, enabled: Any) -> None:
        """Kept; the ability does nothing here."""
        self.nao.services["ALAutonomousLife"].invoke("setAutonomousAbilityEnabled", self.ability, enabled)

    @method
    def isEnabled(self) -> bool:
        """As it was set; at first True."""
        return bool(self.nao.services["ALAutonomousLife"].invoke("getAutonomousAbilityEnabled", self.ability))

    @method
    def isRunning(self, id: Any = None) -> bool:
        """Whether the ability does something: False; with an id, whether a motion task is not over."""
        return False if id is None else super().isRunning(id)


class ALBasicAwareness(_Ability):
    """The ability to look at people; it sees none here."""

    name, ability = "ALBasicAwareness", "BasicAwareness"
    absent = tuple(
        "engagePerson getEngagementMode setEngagementMode getTrackingMode setTrackingMode getParameter setParameter "
        "resetAllParameters isStimulusDetectionEnabled setStimulusDetectionEnabled pauseAwareness"
        " resumeAwareness".split()
    )

    @method
    def startAwareness(self) -> None:
        """The same as setEnabled(True), under its name before NAOqi 2.5."""
        self.setEnabled(True)

    @method
    def stopAwareness(self) -> None:
        """The same as setEnabled(False), under its name before NAOqi 2.5."""
        self.setEnabled(False)

    @method
    def isAwarenessRunning(self) -> bool:
        """The same as isRunning, under its name before NAOqi 2.5."""
        return False


def _strategy(value: Any, what: str) -> str:
    return arguments.choice(value, what, ("none", "backToNeutral"))


@keeps(
    Kept("ExpressiveListeningEnabled", "Kept; the robot does not listen here.", True, ("enable",), arguments.flag),
    Kept("BackgroundStrategy", 'Kept: "none" or "backToNeutral".', "backToNeutral", ("strategy",), _strategy),
)
class ALAutonomousMoves(Service):
    """Moves between the moves of scripts, before NAOqi 2.5; there are none here."""

    name = "ALAutonomousMoves"


ABILITIES: tuple[type[Service], ...] = (
    ALBasicAwareness,
    *(
        type(f"AL{ability}", (_Ability,), {"name": f"AL{ability}", "ability": ability})
        for ability in ("AutonomousBlinking", "BackgroundMovement", "ListeningMovement", "SpeakingMovement")
    ),
    ALAutonomousMoves,
)
