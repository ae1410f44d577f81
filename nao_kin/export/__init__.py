"""The robot in the formats of other tools."""

from nao_kin.export.exported import Exported

__all__ = ["Exported"]
