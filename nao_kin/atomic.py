"""Files that are either the old ones or the new ones, never half of each."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from nao_kin.errors import BadArgument


def write_text(path: Path | str, text: str) -> None:
    """Write `text` (UTF-8) to `path` through a temporary file in the same folder and one rename.

    Raises:
        BadArgument: no path, or the folder does not exist or cannot be written to.
    """
    write_bytes(path, text.encode("utf-8"))


def write_bytes(path: Path | str, content: bytes) -> None:
    """Write `content` to `path` through a temporary file in the same folder and one rename.

    Raises:
        BadArgument: no path, or the folder does not exist or cannot be written to.
    """
    temporary = ""
    try:
        target = Path(path)
        if not target.name:
            raise ValueError("no file name")
        with tempfile.NamedTemporaryFile("wb", dir=target.parent, prefix=f".{target.name}.", delete=False) as file:
            temporary = file.name
            file.write(content)
        # Temporary files are private; the result has the permissions any new file would have.
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(temporary, 0o666 & ~mask)
        os.replace(temporary, target)
    except (OSError, ValueError, TypeError) as error:
        if temporary:
            Path(temporary).unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise BadArgument(f"cannot write {path}: {error.strerror or error}") from None
        raise BadArgument(f"cannot write {path!r}: {error}") from None
