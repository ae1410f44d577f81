"""The robot in the formats of other tools."""

from nao_kin.export.exported import Exported
from nao_kin.export.formats import FORMATS, check_options, options, write
from nao_kin.export.gltf_scene import gltf
from nao_kin.export.mujoco import mjcf
from nao_kin.export.ros_package import ros2
from nao_kin.export.sdf_model import sdf
from nao_kin.export.srdf_document import srdf
from nao_kin.export.urdf_export import urdf, variant

__all__ = [
    "FORMATS",
    "Exported",
    "check_options",
    "gltf",
    "mjcf",
    "options",
    "ros2",
    "sdf",
    "srdf",
    "urdf",
    "variant",
    "write",
]
