"""Files larger than memory: poses for every row of a file, written to a file, and resumed after a kill."""

from nao_kin.stream.columns import FEW_ROWS, PoseColumns, PoseStyle
from nao_kin.stream.csv_text import csv_header, pose_lines
from nao_kin.stream.results import BadRow, Clamped, StreamResult, clamp
from nao_kin.stream.run import ErrorPolicy, fk
from nao_kin.stream.table_sources import Configurations

__all__ = [
    "FEW_ROWS",
    "BadRow",
    "Clamped",
    "Configurations",
    "ErrorPolicy",
    "PoseColumns",
    "PoseStyle",
    "StreamResult",
    "clamp",
    "csv_header",
    "fk",
    "pose_lines",
]
