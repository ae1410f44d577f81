"""The robot in the formats of other tools."""

from nao_kin.export.exported import Exported
from nao_kin.export.mujoco import mjcf

__all__ = ["Exported", "mjcf"]
