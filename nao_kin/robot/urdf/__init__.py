"""Robots' files: a URDF or an MJCF read once into one tree, leniently and with a note for all that had to change."""

from nao_kin.robot.urdf.document import Packages, mesh_in
from nao_kin.robot.urdf.mjcf.reader import read_mjcf
from nao_kin.robot.urdf.reader import file_format, read_robot, read_urdf
from nao_kin.robot.urdf.srdf import read_srdf
from nao_kin.robot.urdf.tree import (
    Box,
    Collision,
    Cylinder,
    Geometry,
    Inertial,
    MeshFile,
    Origin,
    Rgba,
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
    "Geometry",
    "Inertial",
    "MeshFile",
    "Origin",
    "Packages",
    "Rgba",
    "Sphere",
    "UnreadableShape",
    "UrdfJoint",
    "UrdfTree",
    "Visual",
    "file_format",
    "mesh_in",
    "read_mjcf",
    "read_robot",
    "read_srdf",
    "read_urdf",
]
