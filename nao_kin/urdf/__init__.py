"""Robots' files: a URDF or an MJCF read once into one tree, leniently and with a note for all that had to change."""

from nao_kin.urdf.format import file_format, read_robot
from nao_kin.urdf.mjcf import read_mjcf
from nao_kin.urdf.packages import Packages, mesh_in
from nao_kin.urdf.reader import read_urdf
from nao_kin.urdf.srdf import read_srdf
from nao_kin.urdf.tree import Inertial, UrdfJoint, UrdfTree
from nao_kin.urdf.visuals import Box, Collision, Cylinder, Geometry, MeshFile, Origin, Rgba, Sphere, Visual

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
