"""Folders of files that are written whole or not at all, and that never take away what somebody else has put there."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from nao_kin._common.atomic import errors_naming
from nao_kin._common.ending import before_ending, uninterrupted
from nao_kin._text import abbreviated, quoted
from nao_kin.errors import BadArgument


def check_folder(path: Path | str, *, overwrite: bool) -> None:
    """Raise what `write_folder` would raise whatever the files are, before the work whose result they are.

    Raises:
        BadArgument: no path, a file is there, the folder is there and may not be replaced, or none can be there.
    """
    with errors_naming(path):
        _target_of(path, overwrite)


def write_folder(path: Path | str, files: Mapping[str, bytes], *, overwrite: bool = False) -> tuple[Path, ...]:
    """Make `path` a folder with these files and no others.

    The files are written to a temporary folder first. A new folder is that one, by one rename; one that is there
    already stays, with its mode, for somebody may be working in it, and files get into it by renames. Files there are
    replaced only where that is asked for, and only where there are none of other names.

    Args:
        path: the folder; the one it lies in must be there.
        files: name relative to the folder, with "/" between folders → content.
        overwrite: replace the files of a folder that is there.

    Returns:
        The files, in the given order.

    Raises:
        BadArgument: no path, a file is there, the folder is there and may not be replaced, or it cannot be written.
    """
    with errors_naming(path):
        target = _target_of(path, overwrite)
        if target.is_dir():
            _check_names(target, files)
            _swap(target, files)
        else:
            with filled_folder(target.parent, files) as fresh:
                fresh.rename(target)
    return tuple(Path(path) / name for name in files)


@contextmanager
def filled_folder(parent: Path, files: Mapping[str, bytes]) -> Iterator[Path]:
    """A new folder in `parent` that holds the files; whatever happens, nothing of that name is left afterwards."""
    fresh = parent / f".nao_kin-{secrets.token_hex(8)}"

    def remove() -> None:
        shutil.rmtree(fresh, ignore_errors=True)

    take_back = before_ending(remove)
    try:
        fresh.mkdir()
        for name, content in files.items():
            file = fresh / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(content)
        yield fresh
    finally:
        remove()
        take_back()


def is_there(path: Path | str, how: str = "already") -> BadArgument:
    """What to raise for a path that is there and may not be replaced."""
    return BadArgument(f"{abbreviated(path)} is there {how}; overwrite=True (--force) replaces it")


def _target_of(path: Path | str, overwrite: bool) -> Path:
    """The folder that a path leads to, as far as it may be filled whatever the files are."""
    if not os.fspath(path):
        raise ValueError("no folder name")
    target = Path(os.path.realpath(path))
    if target.is_dir():
        if not overwrite and next(_files_in(target), None) is not None:
            raise is_there(target)
    elif os.path.exists(path):
        raise BadArgument(f"cannot write {abbreviated(path)}: it is a file, and a folder is to be written")
    else:
        os.stat(f"{target.parent}{os.sep}")  # with a separator at its end, a file is an error
    return target


def _check_names(target: Path, files: Mapping[str, bytes]) -> None:
    there = sorted(file.relative_to(target).as_posix() for file in _files_in(target))
    strange = [name for name in there if name not in files]
    if strange:
        raise BadArgument(
            f"cannot replace {abbreviated(target)}: it holds {len(strange)} other files, first {quoted(strange[0])}"
        )


def _files_in(folder: Path) -> Iterator[Path]:
    """All that is no folder, links to folders too."""
    return (path for path in folder.rglob("*") if path.is_symlink() or not path.is_dir())


def _swap(target: Path, files: Mapping[str, bytes]) -> None:
    """Put what is at the top of the new folder in the place of what is there; all of it, or nothing."""
    tops = dict.fromkeys(name.split("/")[0] for name in files)
    with filled_folder(target, {f"new/{name}": content for name, content in files.items()}) as fresh, uninterrupted():
        (fresh / "old").mkdir()
        done: list[tuple[Path, Path]] = []
        try:
            for top in tops:
                if os.path.lexists(target / top):
                    done.append((target / top, (target / top).rename(fresh / "old" / top)))
                done.append((fresh / "new" / top, (fresh / "new" / top).rename(target / top)))
        except BaseException:
            for before, after in reversed(done):
                after.rename(before)
            raise
