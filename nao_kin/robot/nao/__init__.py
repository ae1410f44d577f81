"""The NAO's numbers: typed rows with unit and source, and the resolved numbers of one version.

`nao_parameters` gives the numbers of a version in SI units. The tables contain the published rows of all versions, each
with its versions.
"""

from nao_kin._core.guesses import public_attributes as _public_attributes
from nao_kin.robot.nao.parameters import INERTIALS, LIMITS, OFFSETS, NaoParameters, nao_parameters, ros_names
from nao_kin.robot.nao.rows import VERSIONS, Version as Version
from nao_kin.robot.nao.tables import (
    BODY_ORDER as BODY_ORDER,
    CAMERAS as CAMERAS,
    CHAINS as CHAINS,
    COUPLED_LIMITS,
    JOINTS as JOINTS,
    OPTICAL_RPY as OPTICAL_RPY,
    RESOLUTIONS as RESOLUTIONS,
    SOURCES,
)

__all__ = [
    "COUPLED_LIMITS",
    "INERTIALS",
    "LIMITS",
    "OFFSETS",
    "SOURCES",
    "VERSIONS",
    "NaoParameters",
    "nao_parameters",
    "ros_names",
]

globals().update(_public_attributes(__name__))
