"""`nao_kin.urdf` under its former name."""

from nao_kin.semantics import Mimic
from nao_kin.urdf import UrdfJoint, UrdfTree, read_urdf

__all__ = ["Mimic", "UrdfJoint", "UrdfTree", "read_urdf"]
