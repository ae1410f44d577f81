"""The robot in the formats of other tools."""

from nao_kin._core.guesses import public_attributes as _public_attributes
from nao_kin.export.formats import FORMATS, options, write
from nao_kin.export.gltf import gltf
from nao_kin.export.mjcf import mjcf
from nao_kin.export.pipeline import Exported
from nao_kin.export.ros2 import ros2
from nao_kin.export.sdf import sdf
from nao_kin.export.srdf import srdf
from nao_kin.export.urdf import urdf

__all__ = ["FORMATS", "Exported", "gltf", "mjcf", "options", "ros2", "sdf", "srdf", "urdf", "write"]

globals().update(_public_attributes(__name__))
