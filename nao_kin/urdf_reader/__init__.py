"""Reading URDF files that others wrote."""

from nao_kin.urdf_reader.reader import read_urdf
from nao_kin.urdf_reader.tree import Mimic, UrdfInertial, UrdfJoint, UrdfTree

__all__ = ["Mimic", "UrdfInertial", "UrdfJoint", "UrdfTree", "read_urdf"]
