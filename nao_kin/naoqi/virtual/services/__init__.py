"""The services, one file each; ALMotion's split by topic as in NAOqi's documentation."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nao_kin.naoqi.virtual.service import Service
from nao_kin.naoqi.virtual.services.abilities import ABILITIES
from nao_kin.naoqi.virtual.services.behaviors import ALAnimationPlayer, ALBehaviorManager
from nao_kin.naoqi.virtual.services.leds import ALLeds
from nao_kin.naoqi.virtual.services.memory import ALMemory
from nao_kin.naoqi.virtual.services.missing import MISSING
from nao_kin.naoqi.virtual.services.motion import ALMotion
from nao_kin.naoqi.virtual.services.posture import (
    ALAutonomousLife,
    ALBattery,
    ALPreferenceManager,
    ALRobotModel,
    ALRobotPosture,
    ALSystem,
)
from nao_kin.naoqi.virtual.services.sensors import ALSonar, ALTouch
from nao_kin.naoqi.virtual.services.speech import ALTextToSpeech
from nao_kin.naoqi.virtual.services.tracker import ALTracker

if TYPE_CHECKING:
    from nao_kin.naoqi.virtual.virtual_nao import VirtualNao


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
    *MISSING,
)


def make_services(nao: VirtualNao) -> dict[str, Service]:
    """Every service by its name, those that only answer that they are missing last."""
    return {kind.name: kind(nao) for kind in SERVICES}
