"""Folders of files that are written whole or not at all, and that never take away what somebody else has put there."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Mapping
from pathlib import Path

from nao_kin._common.ending import before_ending, uninterrupted
from nao_kin._text import abbreviated, quoted
from nao_kin.errors import BadArgument


def write_folder(path: Path | str, files: Mapping[str, bytes], *, force: bool = False) -> tuple[Path, ...]:
    """Make `path` a folder with these files and nothing else.

    The files are written beside it first and get there by one rename. A folder that is there already is replaced only
    where that is asked for, and only where it holds nothing but files of the same names.

    Args:
        path: the folder; the one it lies in must be there.
        files: name relative to the folder, with "/" between folders → content.
        force: replace a folder that is there and not empty.

    Returns:
        The files, in the given order.

    Raises:
        BadArgument: no path, a file is there, the folder is there and may not be replaced, or it cannot be written.
    """
    try:
        target = Path(os.path.realpath(path))
        _check_free(target, files, force)
        _put(target, files)
    except OSError as error:
        raise BadArgument(f"cannot write {abbreviated(path)}: {error.strerror or error}") from None
    except (ValueError, TypeError) as error:
        raise BadArgument(f"cannot write {quoted(path)}: {error}") from None
    return tuple(Path(path) / name for name in files)


def _check_free(target: Path, files: Mapping[str, bytes], force: bool) -> None:
    if not target.exists():
        return
    if not target.is_dir():
        raise BadArgument(f"cannot write {abbreviated(target)}: it is a file, and a folder is to be written")
    there = sorted(file.relative_to(target).as_posix() for file in target.rglob("*") if not _is_folder(file))
    if there and not force:
        raise BadArgument(f"{abbreviated(target)} is there already; force=True (--force) replaces it")
    strange = [name for name in there if name not in files]
    if strange:
        raise BadArgument(
            f"cannot replace {abbreviated(target)}: it holds {len(strange)} other files, first {quoted(strange[0])}"
        )


def _is_folder(path: Path) -> bool:
    return path.is_dir() and not path.is_symlink()


def _put(target: Path, files: Mapping[str, bytes]) -> None:
    fresh, former = (target.with_name(f".nao_kin-{secrets.token_hex(8)}") for _ in range(2))
    take_back = before_ending(lambda: shutil.rmtree(fresh, ignore_errors=True))
    try:
        fresh.mkdir()
        if target.exists():
            shutil.copystat(target, fresh)
        for name, content in files.items():
            file = fresh / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(content)
        with uninterrupted():
            if target.exists():
                target.rename(former)
            fresh.rename(target)
    finally:
        shutil.rmtree(fresh, ignore_errors=True)
        take_back()
    shutil.rmtree(former, ignore_errors=True)
