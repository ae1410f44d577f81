"""Whether a file holds a motion, or configurations without times."""

from __future__ import annotations

from pathlib import Path

from nao_kin.errors import BadInputFile
from nao_kin.motion.files import FORMATS
from nao_kin.motion.files.source import Source

# Configurations have these endings too, and may be too large to be read for this alone: the beginning tells.
_TABLES = (".csv", ".tsv", ".txt", "")
_HEAD = 1 << 16
# Endings of configurations, of which only the content can say that they are a motion.
_SHARED = (*_TABLES, ".json")


def is_motion_file(path: Path | str, data: bytes | None = None) -> bool:
    """Whether a file is a motion file by its content, or by an ending that nothing else has.

    A table of joint values without a time column, and JSON objects of joint values, are none: they are what
    `nao_kin.configuration_files` reads. Nor is a file that cannot be read.

    Args:
        path: the file.
        data: its content, where that has been read.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in _SHARED and any(suffix in known.suffixes for known in FORMATS.values()):
        return True
    if data is None:
        try:
            with Path(path).open("rb") as file:
                data = file.read(_HEAD if suffix in _TABLES else -1)
        except (OSError, ValueError):
            return False
        if len(data) == _HEAD:
            data = data[: data.rfind(b"\n") + 1] or data
    source = Source(str(path), data, ())
    return bool(data) and any(_recognised(known.name, source) for known in FORMATS.values())


def _recognised(name: str, source: Source) -> bool:
    try:
        return FORMATS[name].recognises(source)
    except BadInputFile:
        return False
