"""The folder of compiled kernels, to which only this user can write, and the fingerprints that name kernels in it.

Numba stores kernels as pickles, and whoever can write a pickle runs code as the user who reads it. The folder is
therefore refused unless it belongs to this user or to root and nobody else may write to it. Its files are reached only
through the opened folder: whoever may rename folders farther up cannot put another one in its place.
"""

from __future__ import annotations

import ast
import hashlib
import inspect
import os
import platform
import re
import sys
import time
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
except ImportError:
    # Windows, where nothing is compiled: locks and owners of files are different there.
    IS_POSIX = False
else:
    IS_POSIX = True

# After this time without use, a kernel is removed [s].
_UNUSED_SECONDS = 30 * 86400.0
_KERNEL = re.compile(r"[0-9a-f]{16}\.kernel")


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


@contextmanager
def private_folder(path: Path) -> Iterator[int]:
    """Open a folder, made if it does not exist, and yield its descriptor; PermissionError if others may write there."""
    # All users may read what root compiles, for example in a container image.
    path.mkdir(0o755 if os.geteuid() == 0 else 0o700, parents=True, exist_ok=True)
    folder = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        _check(folder, str(path))
        yield folder
    finally:
        os.close(folder)


def _check(descriptor: int, name: str) -> None:
    state = os.fstat(descriptor)
    if state.st_uid not in (0, os.geteuid()) or state.st_mode & 0o022:
        raise PermissionError(f"other users may write to {quoted(name)}")


def read_file(folder: int, name: str) -> bytes | None:
    """Return the content of a file and note its use, or None without it; PermissionError if others may write it."""
    try:
        descriptor = os.open(name, os.O_RDONLY | os.O_NOFOLLOW, dir_fd=folder)
    except FileNotFoundError:
        return None
    with open(descriptor, "rb") as file:
        _check(descriptor, name)
        with suppress(OSError):  # a read-only cache
            os.utime(descriptor)
        return file.read()


def write_file(folder: int, name: str, content: bytes) -> None:
    """Write a file by renaming a temporary one, and remove the kernels that have not been used for a month."""
    temporary = f"{name}.{os.urandom(8).hex()}"
    try:
        with open(os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o644, dir_fd=folder), "wb") as file:
            file.write(content)
        os.replace(temporary, name, src_dir_fd=folder, dst_dir_fd=folder)
    finally:
        with suppress(OSError):
            os.unlink(temporary, dir_fd=folder)
    for other in filter(_KERNEL.match, os.listdir(folder)):
        with suppress(OSError):
            if time.time() - os.stat(other, dir_fd=folder, follow_symlinks=False).st_mtime > _UNUSED_SECONDS:
                os.unlink(other, dir_fd=folder)


@contextmanager
def locked(folder: int, name: str, byte: int = 0, wait: Callable[[], object] | None = None) -> Iterator[int]:
    """Lock a byte of a file and yield its descriptor; the lock ends with the process.

    If another process has the lock, call `wait` and wait for it; without `wait`, raise OSError.
    """
    descriptor = os.open(name, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o600, dir_fd=folder)
    try:
        try:
            fcntl.lockf(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, byte)
        except (BlockingIOError, PermissionError):
            if wait is None:
                raise
            wait()
            fcntl.lockf(descriptor, fcntl.LOCK_EX, 1, byte)
        except OSError:
            pass  # a file system without locks: at worst two processes compile the same kernel
        yield descriptor
    finally:
        os.close(descriptor)


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
    trees = [f"{module}: {_tree(module)}" for module in sorted(modules)]
    parts = [name, *_machine(), *trees, *sorted(constants)]
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
def _machine() -> tuple[str, ...]:
    """Return the versions of the compilers and the kind of processor.

    Numba compares the processor more closely when it reads a kernel; to ask LLVM takes 0.1 s.
    """
    import importlib.metadata  # takes a tenth of the time to import this package

    try:
        first = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").split("\n\n")[0]
        lines = "\n".join(line for line in first.splitlines() if line.startswith(_PROCESSOR_LINES))
        processor = lines or platform.machine()
    except OSError:
        processor = f"{platform.machine()} {platform.processor()}"
    chosen = (os.environ.get(variable, "") for variable in ("NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES"))
    return str(sys.implementation.cache_tag), importlib.metadata.version("numba"), np.__version__, processor, *chosen
