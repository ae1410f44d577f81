"""Functions compiled by Numba once on a machine, and kept on its disk.

The folder is the user's own cache, so that the package may be installed where nobody can write. Its name changes with
all that compiled code depends on. Kernels are read from a folder that cannot be written, too, as in an image of a
container. Where nothing can be kept, they are compiled in every process, with one warning.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from nao_kin._common.compiler import compiles, note_slowness
from nao_kin._common.warn import warn_caller
from nao_kin._text import abbreviated, quoted
from nao_kin.errors import NotCachedWarning

_LOCK = threading.RLock()  # one thread compiles, the others wait
_said: set[str] = set()


@dataclass(frozen=True)
class KernelState:
    """A kernel that is ready to run.

    Attributes:
        name: which one.
        seconds: how long it took to get it ready.
        compiled: whether it had to be compiled, and was not found on disk.
        folder: where it is kept; None where it could not be kept.

    Examples:
        >>> state = nk.batch.warm_up()[0]
        >>> isinstance(state.name, str), state.seconds >= 0
        (True, True)
    """

    name: str
    seconds: float
    compiled: bool
    folder: Path | None


class KeptKernel:
    """A function that is compiled, or read from the disk, when it is first needed.

    Args:
        function: plain Python that Numba can compile; run as it stands where Numba is not installed or
            NUMBA_DISABLE_JIT is set.
        what: what is being compiled, for the line on standard error.
        name: name of the file that says that the kernel has been kept.
        sources: the folder of all files that the function depends on.
        signature: its types.
    """

    def __init__(
        self, function: Callable[..., Any], what: str, name: str, sources: Path, signature: Callable[[], Any]
    ) -> None:
        self._function, self._what, self._name = function, what, name
        self._sources, self._signature = sources, signature
        self._compiled: Callable[..., Any] | None = None

    @property
    def name(self) -> str:
        """Name of the file that says that the kernel has been kept."""
        return self._name

    @property
    def in_memory(self) -> bool:
        """Whether it is compiled and can be called at once."""
        return self._compiled is not None

    def __call__(self, *arguments: Any) -> Any:
        """The result of the function."""
        return (self._compiled or self.ready())(*arguments)

    def ready(self) -> Callable[..., Any]:
        """The function to call: compiled where that can be, else as it stands."""
        if self._compiled is not None:
            return self._compiled
        if not compiles():
            return self._uncompiled
        with _LOCK:
            if self._compiled is None:
                self._compiled = self._made()
            return self._compiled

    def _uncompiled(self, *arguments: Any) -> Any:
        started = time.thread_time()
        with np.errstate(all="ignore"):  # compiled code does not warn of infinities
            result = self._function(*arguments)
        note_slowness(time.thread_time() - started)
        return result

    def warm_up(self) -> KernelState:
        """Get it ready now."""
        found, started = self._is_kept(), time.perf_counter()
        self.ready()
        seconds = time.perf_counter() - started
        return KernelState(self._name, seconds, not found, self._folder() if self._is_kept() else None)

    def _made(self) -> Callable[..., Any]:
        folder, obstacle = self._folder(), "there is no home directory"
        if folder is not None:
            if self._is_kept():
                # Whatever is wrong with files that a crash or another program has damaged: they are made anew.
                with suppress(Exception), _readable(folder) as source:
                    return self._by_numba(source)
                shutil.rmtree(folder, ignore_errors=True)
            try:
                folder.mkdir(parents=True, exist_ok=True)
                with tempfile.TemporaryFile(dir=folder):
                    pass
                _say(f"compiling {self._what}, once on this machine …")
                made = self._by_numba(folder)
                (folder / self._name).touch()
                return made
            except (OSError, RuntimeError) as error:  # Numba says that a folder is not writable by a RuntimeError
                obstacle = f"{quoted(str(folder))}: {error}"
        if "warning" not in _said:
            _said.add("warning")
            warn_caller(
                f"compiled kernels cannot be kept ({abbreviated(obstacle)}); each process compiles them anew "
                "(NUMBA_CACHE_DIR names another folder)",
                NotCachedWarning,
            )
        _say(f"compiling {self._what} …")
        return self._by_numba(None)

    def _by_numba(self, folder: Path | None) -> Callable[..., Any]:
        """The function compiled, or read from a folder; kept there unless it is None."""
        import numba

        before = numba.config.CACHE_DIR
        if folder is not None:
            numba.config.CACHE_DIR = str(folder)  # which Numba reads when it is given a function
        try:
            made: Callable[..., Any] = numba.njit(
                self._signature(), nogil=True, error_model="numpy", cache=folder is not None
            )(self._function)
        finally:
            numba.config.CACHE_DIR = before
        return made

    def _is_kept(self) -> bool:
        folder = self._folder()
        return folder is not None and (folder / self._name).exists()

    def _folder(self) -> Path | None:
        parent = cache_folder()
        return None if parent is None else parent / _fingerprint(self._sources)


def cache_folder() -> Path | None:
    """Where compiled kernels are kept: below NUMBA_CACHE_DIR if that is set, else in the user's cache directory.

    None where the user has no home.

    Examples:
        >>> folder = nk.batch.cache_folder()
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
def _readable(folder: Path) -> Iterator[Path]:
    """The folder, or a copy of it for as long as it is read: Numba reads only where it may write."""
    if os.access(folder, os.W_OK):
        yield folder
        return
    with tempfile.TemporaryDirectory(prefix="nao_kin_") as name:
        copy = Path(name) / "kernels"
        shutil.copytree(folder, copy, copy_function=shutil.copyfile)
        for path in (copy, *copy.rglob("*")):
            path.chmod(0o700)
        yield copy


def _say(message: str) -> None:
    """Say once in a process why it takes a while, where anybody listens."""
    if message not in _said and sys.stderr is not None:
        with suppress(OSError, ValueError):
            print(f"nao_kin: {message}", file=sys.stderr)  # noqa: T201
    _said.add(message)


@cache
def _fingerprint(sources: Path) -> str:
    """What compiled kernels depend on, in sixteen letters: Python, Numba, the processor, the place and the sources."""
    import llvmlite.binding
    import numba

    parts = [str(sys.implementation.cache_tag), numba.__version__, llvmlite.binding.get_host_cpu_name(), str(sources)]
    parts += [path.read_text(encoding="utf-8") for path in sorted(sources.rglob("*.py"))]
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:16]
