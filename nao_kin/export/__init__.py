"""The robot in the formats of other tools."""

from nao_kin.export.exported import Exported
from nao_kin.export.srdf_document import srdf

__all__ = ["Exported", "srdf"]
