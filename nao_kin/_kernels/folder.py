"""The folders of compiled kernels: where they are, whether they can be trusted, their locks, and their fingerprints.

Numba stores kernels as pickles, and whoever can write a pickle runs code as the user who reads it. Folders and files
are therefore trusted only if they belong to this user or to root and nobody else may write them.
"""

from __future__ import annotations

import ast
import hashlib
import inspect
import os
import platform
import re
import stat
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any

import numpy as np

from nao_kin._core.text import quoted

try:
    import fcntl
    import grp
    import pwd
except ImportError:
    # Windows, where nothing is compiled: locks and owners of files are different there.
    IS_POSIX = False
else:
    IS_POSIX = True

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


# --- Fingerprints of kernels, which change only with the code, the compiler and the processor.

_CONSTANTS = (bool, int, float, complex, str, bytes, tuple, dict, np.generic, type(None))
_DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
# The lines of /proc/cpuinfo that identify the kind of processor.
_PROCESSOR_LINES = ("model name", "flags", "CPU part", "Features")


def fingerprint(function: Callable[..., Any], name: str) -> str:
    """Return sixteen hexadecimal digits that identify a kernel, given by its Python function and its name.

    They depend on Python, Numba, NumPy, the processor, the syntax trees of all modules from which the function takes
    functions and classes, also indirectly, and the constants it uses; not on comments, docstrings, lines and paths.
    """
    modules, constants = _dependencies(function)
    parts = [name, str(sys.implementation.cache_tag), _version("numba"), np.__version__, _processor()]
    parts += [os.environ.get(variable, "") for variable in ("NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES")]
    parts += [f"{module}: {_tree(module)}" for module in sorted(modules)]
    parts += sorted(constants)
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:16]


def _dependencies(function: Callable[..., Any]) -> tuple[set[str], set[str]]:
    """Return the modules of a function and of everything it uses from its own package, and the constants it uses."""
    package = function.__module__.partition(".")[0]
    modules: set[str] = set()
    constants: set[str] = set()
    seen: set[int] = set()
    waiting: list[Any] = [function]
    while waiting:
        value = waiting.pop()
        # A function compiled by Numba holds the Python function in an attribute.
        value = getattr(value, "py_func", None) or getattr(value, "__wrapped__", value)
        if id(value) in seen:
            continue
        seen.add(id(value))
        if str(getattr(value, "__module__", "")).partition(".")[0] != package:
            continue
        if isinstance(value, type):
            modules.add(value.__module__)
            waiting += vars(value).values()
        elif isinstance(value, FunctionType):
            modules.update((value.__module__, value.__globals__["__name__"]))  # a factory may set another __module__
            for place, used in _globals_used(value):
                name = f"{value.__module__}.{place}"
                if isinstance(used, np.ndarray):
                    constants.add(f"{name}: {used.dtype} {used.shape} {used.tobytes().hex()}")
                elif isinstance(used, _CONSTANTS):
                    constants.add(f"{name}: {used!r}")
                else:
                    waiting.append(used)
    return modules, constants


def _globals_used(function: FunctionType) -> Iterator[tuple[str, Any]]:
    """Yield the globals and enclosing variables that a function names in its code or its annotations."""
    names = set(_names(function.__code__))
    for annotation in function.__annotations__.values():
        names.update(re.findall(r"\w+", str(annotation)))
    for name in sorted(names & function.__globals__.keys()):
        yield name, function.__globals__[name]
    for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        with suppress(ValueError):  # a variable that has no value yet
            yield name, cell.cell_contents


def _names(code: CodeType) -> Iterator[str]:
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _names(constant)


@cache
def _tree(module: str) -> str:
    """Return the syntax tree of a module without docstrings."""
    tree = ast.parse(inspect.getsource(sys.modules[module]))
    for node in ast.walk(tree):
        if isinstance(node, _DOCUMENTED) and ast.get_docstring(node, clean=False) is not None:
            del node.body[0]
    return ast.dump(tree)


@cache
def _version(package: str) -> str:
    """Return the version of a package without importing it."""
    import importlib.metadata  # takes a tenth of the time to import this package

    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return ""


@cache
def _processor() -> str:
    """Return the kind of processor. Numba compares it more closely when it reads a kernel; to ask LLVM takes 0.1 s."""
    try:
        first = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").split("\n\n")[0]
    except OSError:
        return f"{platform.machine()} {platform.processor()}"
    return "\n".join(line for line in first.splitlines() if line.startswith(_PROCESSOR_LINES)) or platform.machine()
