"""URDF files: any of them read once into one tree, leniently and with a note for everything that had to change."""

from nao_kin.urdf.reader import read_urdf
from nao_kin.urdf.srdf import read_srdf
from nao_kin.urdf.tree import Inertial, UrdfJoint, UrdfTree
from nao_kin.urdf.visuals import Geometry, Origin, Visual

__all__ = [
    "Geometry",
    "Inertial",
    "Origin",
    "UrdfJoint",
    "UrdfTree",
    "Visual",
    "read_srdf",
    "read_urdf",
]
