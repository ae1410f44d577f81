"""The robot in the formats of other tools."""

from nao_kin.export.exported import Exported
from nao_kin.export.formats import FORMATS, check_options, options, write
from nao_kin.export.mujoco import mjcf
from nao_kin.export.urdf_export import urdf, variant

__all__ = ["FORMATS", "Exported", "check_options", "mjcf", "options", "urdf", "variant", "write"]
