"""The NAO's numbers: typed rows with unit and source, and all of them together for one version.

`nao_parameters` gives the numbers of a version, resolved and in SI units. The tables hold the rows as published, those
of all versions, each with the versions that it holds for.
"""

from nao_kin._common.arrays import Vector
from nao_kin.parameters.bodies import COLLISION_SHAPES, COLOURS, colours_of
from nao_kin.parameters.frames import (
    ACCELEROMETERS,
    CAMERAS,
    END_EFFECTORS,
    FIELDS_OF_VIEW,
    FORCE_SENSORS,
    GYROMETERS,
    OPTICAL_RPY,
    SOLES,
    VIEWS,
)
from nao_kin.parameters.overlay import VersionPage
from nao_kin.parameters.postures import POSTURES, REST
from nao_kin.parameters.ranges import COUPLED_LIMITS
from nao_kin.parameters.robot_parameters import (
    ACTUATORS,
    FRAMES,
    INERTIALS,
    LIMITS,
    OFFSETS,
    PLACEHOLDER,
    VISUALS,
    Finger,
    Frame,
    Joint,
    NaoParameters,
    nao_parameters,
    version_named,
)
from nao_kin.parameters.ros_names import ros_names
from nao_kin.parameters.rows import (
    SOURCES,
    VERSIONS,
    ActuatorRow,
    CoupledLimitRow,
    FingerRow,
    FrameRow,
    InertialRow,
    JointRow,
    LimitRow,
    Offset,
    OffsetRow,
    PostureRow,
    ShapeRow,
    Version,
    VisualRow,
)
from nao_kin.parameters.skeleton import BODY_ORDER, CHAINS, FINGER_RATIO, FINGERS, JOINTS
from nao_kin.parameters.urdf_text import MESH_FOLDER, nao_urdf_path, urdf_name, urdf_text

__all__ = [
    "ACCELEROMETERS",
    "ACTUATORS",
    "BODY_ORDER",
    "CAMERAS",
    "CHAINS",
    "COLLISION_SHAPES",
    "COLOURS",
    "COUPLED_LIMITS",
    "END_EFFECTORS",
    "FIELDS_OF_VIEW",
    "FINGERS",
    "FINGER_RATIO",
    "FORCE_SENSORS",
    "FRAMES",
    "GYROMETERS",
    "INERTIALS",
    "JOINTS",
    "LIMITS",
    "MESH_FOLDER",
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
    "ActuatorRow",
    "CoupledLimitRow",
    "Finger",
    "FingerRow",
    "Frame",
    "FrameRow",
    "InertialRow",
    "Joint",
    "JointRow",
    "LimitRow",
    "NaoParameters",
    "Offset",
    "OffsetRow",
    "PostureRow",
    "ShapeRow",
    "Vector",
    "Version",
    "VersionPage",
    "VisualRow",
    "colours_of",
    "nao_parameters",
    "nao_urdf_path",
    "ros_names",
    "urdf_name",
    "urdf_text",
    "version_named",
]
