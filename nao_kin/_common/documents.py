"""A document and the files that it names, put beside each other whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from nao_kin._common import atomic
from nao_kin._common.ending import uninterrupted
from nao_kin._common.folders import filled_folder, is_there
from nao_kin._text import abbreviated
from nao_kin.errors import BadArgument


def check_replaceable(path: Path | str, *, overwrite: bool) -> None:
    """Raise what `write_document` would raise for the document alone, before the work whose result it is.

    Raises:
        BadArgument: no path, a file that is there, or one that cannot be written.
    """
    atomic.check_writable(path)
    target = atomic.replaced_file(path)
    if target is not None and target.exists() and not overwrite:
        raise is_there(path)


def write_document(
    path: Path | str, content: bytes, beside: Mapping[str, bytes] | None = None, *, overwrite: bool = False
) -> tuple[Path, ...]:
    """Write a document, and files in its folder that it names.

    All of them are written to a folder of their own first and get to their places by renames, the document last. Files
    beside it that are there already with the same content stay as they are.

    Args:
        path: the document.
        content: what it holds.
        beside: name relative to the document's folder, with "/" between folders → content.
        overwrite: replace what is there.

    Returns:
        The document, and the files beside it in the given order.

    Raises:
        BadArgument: no path, a file is there and may not be replaced, or one cannot be written.
    """
    beside = beside or {}
    check_replaceable(path, overwrite=overwrite)
    target = atomic.replaced_file(path)
    if target is None:
        if beside:
            raise BadArgument(f"{abbreviated(path)} takes one file, and {len(beside)} are to stand beside it")
        atomic.write_bytes(path, content)
        return (Path(path),)
    folder = Path(path).parent
    with atomic.errors_naming(path):
        fresh = {name: data for name, data in beside.items() if not _is_there(folder / name, data, overwrite)}
        _put(folder, fresh, path, content)
    return (Path(path), *(folder / name for name in beside))


def _is_there(file: Path, data: bytes, overwrite: bool) -> bool:
    """Whether the file is there with this content.

    Raises:
        BadArgument: it is there with another one, and may not be replaced.
    """
    if not file.exists():
        return False
    if file.is_file() and file.stat().st_size == len(data) and file.read_bytes() == data:
        return True
    if not overwrite or not file.is_file():
        raise is_there(file, "with another content")
    return False


def _put(folder: Path, beside: Mapping[str, bytes], path: Path | str, content: bytes) -> None:
    if not beside:
        atomic.write_bytes(path, content)
        return
    made: list[Path] = []
    with filled_folder(folder, beside) as fresh, uninterrupted():
        try:
            for name in beside:
                _make_folders((folder / name).parent, made)
                if not (folder / name).exists():
                    made.append(folder / name)
                os.replace(fresh / name, folder / name)
            atomic.write_bytes(path, content)
        except BaseException:
            for there in reversed(made):
                there.rmdir() if there.is_dir() else there.unlink(missing_ok=True)
            raise


def _make_folders(folder: Path, made: list[Path]) -> None:
    missing = [parent for parent in (folder, *folder.parents) if not parent.exists()]
    for parent in reversed(missing):
        parent.mkdir()
        made.append(parent)
