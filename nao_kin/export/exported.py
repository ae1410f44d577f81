"""What an export has written."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from nao_kin._text import abbreviated, quoted
from nao_kin.errors import BadArgument


@dataclass(frozen=True)
class Exported:
    """An export that is done.

    Attributes:
        path: the file to load, or the folder of the package.
        files: every file that was written.
        changes: what in them differs from the robot, one line each.
    """

    path: Path
    files: tuple[Path, ...]
    changes: tuple[str, ...] = ()


def check_free(path: Path | str, *, force: bool) -> None:
    """Raise where a file is there and may not be replaced.

    Raises:
        BadArgument: it is there and `force` is not given; or no path.
    """
    try:
        there = os.path.lexists(path)
    except (TypeError, ValueError) as error:
        raise BadArgument(f"cannot write {quoted(path)}: {error}") from None
    if there and not force:
        raise BadArgument(f"{abbreviated(path)} is there already; force=True (--force) replaces it")
