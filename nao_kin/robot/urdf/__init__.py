"""Robot description files: URDF and MJCF files read into one tree, with a note for every repair."""

from nao_kin.robot.urdf.document import Packages
from nao_kin.robot.urdf.mjcf.reader import read_mjcf as read_mjcf
from nao_kin.robot.urdf.reader import file_format as file_format, read_robot, read_urdf as read_urdf
from nao_kin.robot.urdf.srdf import read_srdf as read_srdf
from nao_kin.robot.urdf.tree import (
    TENSOR_LABELS as TENSOR_LABELS,
    Box,
    Collision,
    Cylinder,
    Geometry as Geometry,
    Inertial,
    MeshFile,
    Origin,
    Rgba as Rgba,
    Sphere,
    UnreadableShape,
    UrdfJoint,
    UrdfTree,
    Visual,
)

__all__ = [
    "Box",
    "Collision",
    "Cylinder",
    "Inertial",
    "MeshFile",
    "Origin",
    "Packages",
    "Sphere",
    "UnreadableShape",
    "UrdfJoint",
    "UrdfTree",
    "Visual",
    "read_robot",
]
