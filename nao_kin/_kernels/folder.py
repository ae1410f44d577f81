"""The folder of compiled kernels: where it is, whether it can be trusted, and the locks in it.

Numba stores kernels as pickles, and whoever can write a pickle runs code as the user who reads it. Folders and files
are therefore trusted only if they belong to this user or to root and nobody else may write them.
"""

from __future__ import annotations

import fcntl
import grp
import os
import pwd
import stat
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

from nao_kin._core.text import quoted

# The bytes of a lock file: one is locked while compiling, one while waiting to compile in the background.
COMPILING, WAITING = 0, 1


class NotTrusted(PermissionError):
    """A folder or file that another user may have written."""


def cache_folder() -> Path | None:
    """Return the folder of compiled kernels: below NUMBA_CACHE_DIR if set, otherwise in the user's cache directory.

    None if the user has no home directory.

    Examples:
        >>> folder = nk.cache_folder()
        >>> folder is None or folder.is_absolute()
        True
    """
    named = os.environ.get("NUMBA_CACHE_DIR")
    if named:
        return Path(named) / "nao_kin"
    try:
        if sys.platform == "darwin":
            return Path.home() / "Library" / "Caches" / "nao_kin"
        return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "nao_kin"
    except RuntimeError:
        return None


def folder_mode() -> int:
    """Return the mode of new folders; all users may read what root compiles, for example in a container image."""
    return 0o755 if os.geteuid() == 0 else 0o700


@contextmanager
def trusted(folder: Path) -> Iterator[Path]:
    """Open the folder of a kernel and yield a path to it; raise `NotTrusted` if others may have written there.

    The path stays that of the opened folder even if somebody who may write a folder farther up renames it meanwhile.
    """
    _check_parents(folder)
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        _check(os.fstat(descriptor), folder)
        with os.scandir(descriptor) as files:
            for file in files:
                _check(file.stat(follow_symlinks=False), folder / file.name)
        opened = Path(f"/proc/self/fd/{descriptor}")
        yield opened if os.path.isdir(opened) else folder
    finally:
        os.close(descriptor)


def _check_parents(folder: Path) -> None:
    """Raise `NotTrusted` if others may write the folder of all kernels or replace it in the folder that contains it.

    In a folder with a sticky bit, such as /tmp, nobody can replace what belongs to others. Folders farther up are not
    checked: who replaces one of them owns the new one, or finds only what belongs to this user.
    """
    kernels = folder.parent
    _check(kernels.parent.stat(), kernels.parent, sticky=True)
    _check(kernels.lstat(), kernels)


def _check(state: os.stat_result, path: Path, *, sticky: bool = False) -> None:
    """Raise `NotTrusted` unless a file belongs to this user or root, and nobody else may write it."""
    if state.st_uid not in (0, os.geteuid()):
        raise NotTrusted(f"user {state.st_uid} owns {quoted(str(path))}")
    shared = state.st_mode & stat.S_IWOTH or (state.st_mode & stat.S_IWGRP and not _is_private(state.st_gid))
    if shared and not (sticky and state.st_mode & stat.S_ISVTX):
        raise NotTrusted(f"other users may write to {quoted(str(path))}")


@cache
def _is_private(gid: int) -> bool:
    """Return whether a group is that of this user alone: Linux systems make one of the user's name, with umask 002."""
    try:
        group, user = grp.getgrgid(gid), pwd.getpwuid(os.geteuid())
    except KeyError:
        return False
    alone = group.gr_name == user.pw_name and set(group.gr_mem) <= {user.pw_name}
    # In containers, arbitrary users are in the group of root.
    return alone and gid == user.pw_gid and gid != 0


@contextmanager
def lock_file(folder: Path) -> Iterator[int]:
    """Open the file that is locked while a kernel is compiled, next to its folder, and yield the descriptor.

    The folder of all kernels is made if it does not exist. Raise `NotTrusted` if others may write there.
    """
    for parent in (folder.parent.parent, folder.parent):
        parent.mkdir(folder_mode(), parents=True, exist_ok=True)
    _check_parents(folder)
    # POSIX locks end with their process, and a forked process does not inherit them.
    descriptor = os.open(folder.with_suffix(".lock"), os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o600)
    try:
        yield descriptor
    finally:
        os.close(descriptor)


@contextmanager
def compile_lock(folder: Path, wait: Callable[[], object]) -> Iterator[None]:
    """Hold the lock of a kernel's folder; if another process has it, call `wait` and wait for it."""
    with lock_file(folder) as lock:
        try:
            fcntl.lockf(lock, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, COMPILING)
        except (BlockingIOError, PermissionError):
            wait()
            fcntl.lockf(lock, fcntl.LOCK_EX, 1, COMPILING)
        except OSError:
            pass  # a file system without locks: at worst two processes compile the same kernel
        os.pwrite(lock, b"1", 0)  # the file's time becomes that of the last attempt
        yield
