"""Reading URDF files that others wrote."""

from nao_kin.urdf_reader.reader import read_urdf
from nao_kin.urdf_reader.tree import Mimic, UrdfJoint, UrdfTree

__all__ = ["Mimic", "UrdfJoint", "UrdfTree", "read_urdf"]
