"""URDF files: any of them read once into one tree, leniently and with a note for everything that had to change."""

from nao_kin.urdf import writing
from nao_kin.urdf.reader import read_urdf
from nao_kin.urdf.srdf import read_srdf
from nao_kin.urdf.tree import Inertial, UrdfJoint, UrdfTree
from nao_kin.urdf.visuals import Box, Collision, Cylinder, Geometry, MeshFile, Origin, Rgba, Sphere, Visual, mesh_in

__all__ = [
    "Box",
    "Collision",
    "Cylinder",
    "Geometry",
    "Inertial",
    "MeshFile",
    "Origin",
    "Rgba",
    "Sphere",
    "UrdfJoint",
    "UrdfTree",
    "Visual",
    "mesh_in",
    "read_srdf",
    "read_urdf",
    "writing",
]
