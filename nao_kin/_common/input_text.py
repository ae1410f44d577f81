"""The text of a file that a user names, or of standard input."""

from __future__ import annotations

import gzip
import os
import stat
import sys
import zlib
from pathlib import Path
from typing import BinaryIO

from nao_kin._text import abbreviated
from nao_kin.errors import BadInputFile

# Of what is unpacked, and of a pipe or device, which may have no end.
MOST_BYTES = 1 << 30


def read_bounded(file: BinaryIO | gzip.GzipFile, name: str) -> bytes:
    """All of an open file.

    Raises:
        BadInputFile: it is no regular file, or is unpacked while it is read, and has more than 2³⁰ bytes.
    """
    try:
        regular = not isinstance(file, gzip.GzipFile) and stat.S_ISREG(os.fstat(file.fileno()).st_mode)
    except (OSError, ValueError):  # held in memory
        regular = True
    if regular:
        return file.read()
    data = file.read(MOST_BYTES + 1)
    if len(data) > MOST_BYTES:
        what = "when it is unpacked" if isinstance(file, gzip.GzipFile) else "and no regular file; it may have no end"
        raise BadInputFile(name, f"more than {MOST_BYTES} bytes {what}")
    return data


def read_text(name: str, advice: str = "") -> str:
    """The text of a file, unpacked where its name ends in .gz, or of standard input for "-"; no byte order mark.

    Args:
        name: which.
        advice: what the message says of a file that is no text.

    Raises:
        BadInputFile: it cannot be read, or is no UTF-8 text.
    """
    try:
        if name == "-":
            if sys.stdin is None:
                raise BadInputFile(name, "closed; there is nothing to read")
            return read_bounded(sys.stdin.buffer, name).decode("utf-8-sig")
        with gzip.open(name) if Path(name).suffix.lower() == ".gz" else Path(name).open("rb") as file:
            return read_bounded(file, name).decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except OSError as error:
        raise BadInputFile(name, f"cannot be read: {error.strerror or error}") from None
    except (EOFError, zlib.error) as error:
        raise BadInputFile(name, f"no whole gzip file: {error}") from None
    except UnicodeDecodeError as error:
        raise BadInputFile(name, f"not UTF-8 text (byte {error.start}){advice}") from None
    except ValueError as error:  # a NUL in its name
        raise BadInputFile(abbreviated(name), f"cannot be read: {error}") from None
