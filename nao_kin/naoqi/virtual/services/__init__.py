"""The services by name: the implemented ones, and the missing ones, whose methods only return an error."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nao_kin._core.text import quoted
from nao_kin.naoqi.virtual.engine import NaoqiError
from nao_kin.naoqi.virtual.service import ABSENT, Service
from nao_kin.naoqi.virtual.services.expression import ALLeds, ALTextToSpeech
from nao_kin.naoqi.virtual.services.life import (
    ABILITIES,
    ALAutonomousLife,
    ALBattery,
    ALPreferenceManager,
    ALRobotModel,
    ALSystem,
)
from nao_kin.naoqi.virtual.services.memory import ALMemory, ALSonar, ALTouch
from nao_kin.naoqi.virtual.services.motion import ALMotion
from nao_kin.naoqi.virtual.services.movements import ALAnimationPlayer, ALBehaviorManager, ALRobotPosture, ALTracker

if TYPE_CHECKING:
    from nao_kin.naoqi.virtual.virtual_nao import VirtualNao


class Missing(Service):
    """A service that this virtual NAO does not have."""

    def __init__(self, nao: VirtualNao, name: str, why: str, methods: str) -> None:
        self.name, self._why = name, why
        super().__init__(nao)
        self._methods, self.absent = {}, tuple(dict.fromkeys(methods.replace("*", ABSENT["extractor"]).split()))

    def _no_method(self, name: str) -> NaoqiError:
        others = ", ".join(other for other, service in self.nao.services.items() if not isinstance(service, Missing))
        return NaoqiError(self.name, quoted(name)[1:-1], f"not in this virtual NAO: {self._why}; there are: {others}")


SERVICES: tuple[type[Service], ...] = (
    ALMotion,
    ALRobotPosture,
    ALMemory,
    ALLeds,
    ALTextToSpeech,
    ALAutonomousLife,
    ALSystem,
    ALBattery,
    ALPreferenceManager,
    ALTouch,
    ALSonar,
    ALRobotModel,
    ALTracker,
    ALBehaviorManager,
    ALAnimationPlayer,
    *ABILITIES,
)


def make_services(nao: VirtualNao) -> dict[str, Service]:
    """Every service by its name, missing ones last."""
    found: dict[str, Service] = {kind.name: kind(nao) for kind in SERVICES}
    for why, services in ABSENT["missing"].items():
        found |= {name: Missing(nao, name, why, methods) for name, methods in services.items()}
    return found
