"""The text of a file that a user names, or of standard input."""

from __future__ import annotations

import sys
from pathlib import Path

from nao_kin._text import abbreviated
from nao_kin.errors import BadInputFile


def read_text(name: str, advice: str = "") -> str:
    """The text of a file, or of standard input for "-", without a byte order mark.

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
            return sys.stdin.buffer.read().decode("utf-8-sig")
        return Path(name).read_text(encoding="utf-8-sig")
    except OSError as error:
        raise BadInputFile(name, f"cannot be read: {error.strerror or error}") from None
    except UnicodeDecodeError as error:
        raise BadInputFile(name, f"not UTF-8 text (byte {error.start}){advice}") from None
    except ValueError as error:  # a NUL in its name
        raise BadInputFile(abbreviated(name), f"cannot be read: {error}") from None
