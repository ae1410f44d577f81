"""The NAO's numbers: typed rows with unit, version and source, and all of them together for one version."""

from nao_kin.parameters.frames import CAMERAS, FRAMES, OPTICAL_RPY
from nao_kin.parameters.inertials import INERTIALS, PLACEHOLDER
from nao_kin.parameters.joints import FINGER_RATIO, FINGERS, JOINTS
from nao_kin.parameters.limits import ACTUATORS, COUPLED_LIMITS, LIMITS
from nao_kin.parameters.meaning import END_EFFECTORS, REST, SOLES, VIEWS
from nao_kin.parameters.nao import Frame, Joint, NaoParameters, nao_parameters, version_named
from nao_kin.parameters.offsets import OFFSETS
from nao_kin.parameters.postures import BODY_ORDER, CHAINS, POSTURES
from nao_kin.parameters.rows import VERSIONS, Version
from nao_kin.parameters.shapes import COLLISION_SHAPES
from nao_kin.parameters.sources import SOURCES
from nao_kin.parameters.visuals import COLOURS, VISUALS

__all__ = [
    "ACTUATORS",
    "BODY_ORDER",
    "CAMERAS",
    "CHAINS",
    "COLLISION_SHAPES",
    "COLOURS",
    "COUPLED_LIMITS",
    "END_EFFECTORS",
    "FINGERS",
    "FINGER_RATIO",
    "FRAMES",
    "INERTIALS",
    "JOINTS",
    "LIMITS",
    "OFFSETS",
    "OPTICAL_RPY",
    "PLACEHOLDER",
    "POSTURES",
    "REST",
    "SOLES",
    "SOURCES",
    "VERSIONS",
    "VIEWS",
    "VISUALS",
    "Frame",
    "Joint",
    "NaoParameters",
    "Version",
    "nao_parameters",
    "version_named",
]
