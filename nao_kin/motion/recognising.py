"""Whether a file holds a motion, or configurations without times."""

from __future__ import annotations

import re
from pathlib import Path

from nao_kin.motion.files.reading import FORMATS, looks_like
from nao_kin.motion.files.source import Source, file_name

# Configurations have these endings too; of a file with another one the ending tells.
_SHARED = (".csv", ".tsv", ".txt", ".json", "")
# A table may be larger than memory: its beginning tells.
_HEAD = 1 << 16
_JSON = re.compile(rb"(?:\xef\xbb\xbf)?\s*[\[{]")
# Long lists of configurations need not be read to the end.
_CONFIGURATIONS = re.compile(rb"(?:\xef\xbb\xbf)?\s*\[\s*\{")


def is_motion_file(path: Path | str, data: bytes | None = None) -> bool:
    """Whether a file is a motion file by its content, or by an ending that nothing else has.

    A table of joint values without a time column, and JSON objects of joint values, are none: they are what
    `nao_kin.configuration_files` reads. Nor is a file that cannot be read, or a pipe, which can be read only once.

    Args:
        path: the file.
        data: its content, where that has been read.

    Raises:
        BadArgument: path is no text and no Path.

    Examples:
        >>> nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
        >>> nk.motion.write_motion(nod, "nod.csv")
        >>> nk.motion.is_motion_file("nod.csv")
        True
    """
    if isinstance(path, str) and not path:
        return False
    suffix = Path(file_name(path)).suffix.lower()
    if suffix not in _SHARED and any(suffix in known.suffixes for known in FORMATS.values()):
        return True
    try:
        beginning = _beginning(path) if data is None else _cut(data)
    except (OSError, ValueError):
        return False
    if not beginning or _CONFIGURATIONS.match(beginning):
        return False
    source = Source(str(path), beginning, ())
    return any(looks_like(known, source) for known in FORMATS.values())


def _beginning(path: Path | str) -> bytes:
    """As much of a file as tells what it is: of JSON all, of anything else whole lines at its beginning."""
    if not Path(path).is_file():
        return b""
    with Path(path).open("rb") as file:
        head = file.read(_HEAD + 1)
        return head + file.read() if _JSON.match(head) and not _CONFIGURATIONS.match(head) else _cut(head)


def _cut(data: bytes) -> bytes:
    if len(data) <= _HEAD or _JSON.match(data):
        return data
    return data[: data.rfind(b"\n", 0, _HEAD) + 1] or data[:_HEAD]
