"""Files larger than memory: poses for every row of a file, written to a file, with resumable runs."""

from nao_kin._core.guesses import public_attributes as _public_attributes
from nao_kin.stream.parts import StreamResult
from nao_kin.stream.run import ErrorPolicy, fk
from nao_kin.stream.sinks import PoseColumns as PoseColumns
from nao_kin.stream.sources import Configurations
from nao_kin.stream.tables import log_columns as log_columns, read_log, unit_note as unit_note
from nao_kin.stream.targets import Targets, read_targets

__all__ = ["Configurations", "ErrorPolicy", "StreamResult", "Targets", "fk", "read_log", "read_targets"]

globals().update(_public_attributes(__name__))
