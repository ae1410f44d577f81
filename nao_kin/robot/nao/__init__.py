"""The NAO's numbers: typed rows with unit and source, and the resolved numbers of one version.

`nao_parameters` gives the numbers of a version in SI units. The tables contain the published rows of all versions, each
with its versions.
"""

from nao_kin.robot.nao.parameters import (
    INERTIALS,
    LIMITS,
    OFFSETS,
    Finger,
    Frame,
    Joint,
    NaoParameters,
    nao_parameters,
    ros_names,
)
from nao_kin.robot.nao.rows import (
    SOURCES,
    VERSIONS,
    CameraRow,
    CoupledLimitRow,
    InertialRow,
    LimitRow,
    Offset,
    OffsetRow,
    ShapeRow,
    Version as Version,
    VisualRow,
)
from nao_kin.robot.nao.v6 import (
    BODY_ORDER,
    CAMERAS as CAMERAS,
    CHAINS,
    COLOURS,
    COUPLED_LIMITS,
    JOINTS as JOINTS,
    OPTICAL_RPY as OPTICAL_RPY,
    RESOLUTIONS as RESOLUTIONS,
)

__all__ = [
    "BODY_ORDER",
    "CHAINS",
    "COLOURS",
    "COUPLED_LIMITS",
    "INERTIALS",
    "LIMITS",
    "OFFSETS",
    "SOURCES",
    "VERSIONS",
    "CameraRow",
    "CoupledLimitRow",
    "Finger",
    "Frame",
    "InertialRow",
    "Joint",
    "LimitRow",
    "NaoParameters",
    "Offset",
    "OffsetRow",
    "ShapeRow",
    "VisualRow",
    "nao_parameters",
    "ros_names",
]
