"""Motion files of many kinds: which there are, which one a file is, reading and writing."""

from nao_kin.motion.files.reading import FORMATS, read_motion
from nao_kin.motion.files.source import MotionFileWarning
from nao_kin.motion.files.writing import write_motion

__all__ = ["FORMATS", "MotionFileWarning", "read_motion", "write_motion"]
