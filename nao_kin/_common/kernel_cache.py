"""Functions compiled by Numba once on a machine, and kept on its disk.

The folder is the user's own cache, so that the package may be installed where nobody can write. Its name changes with
the sources of the kernels, with the compiler and with the processor. Where nothing can be kept, kernels are compiled in
every process, with one warning.
"""

from __future__ import annotations

import hashlib
import os
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from nao_kin._common.warn import warn_caller
from nao_kin._text import abbreviated, quoted
from nao_kin.errors import NotCachedWarning

_LOCK = threading.RLock()  # one thread compiles, the others wait
_announced: set[str] = set()


@dataclass(frozen=True)
class KernelState:
    """A kernel that is ready to run.

    Attributes:
        name: which one.
        seconds: how long it took to get it ready.
        compiled: whether it had to be compiled, and was not found on disk.
        folder: where it is kept; None where it could not be kept.
    """

    name: str
    seconds: float
    compiled: bool
    folder: Path | None


class KeptKernel:
    """A function that is compiled, or read from the disk, when it is first needed.

    Args:
        function: plain Python that Numba can compile; run as it stands where NUMBA_DISABLE_JIT is set.
        what: what is being compiled, for the line on standard error.
        name: name of the file that says that the kernel has been kept.
        sources: the folder of all files that the function depends on.
        signature: its types; None for those of the first call, which all others must then have too.
    """

    def __init__(
        self,
        function: Callable[..., Any],
        what: str,
        name: str,
        sources: Path,
        signature: Callable[[], Any] | None = None,
    ) -> None:
        self._function, self._what, self._name = function, what, name
        self._sources, self._signature = sources, signature
        self._compiled: Callable[..., Any] | None = None

    def warm_up(self) -> KernelState:
        """Get it ready now; it must have been made with its signature."""
        found, started = self.kept_in is not None, time.perf_counter()
        self.ready()
        return KernelState(self._name, time.perf_counter() - started, not found, self.kept_in)

    @property
    def kept_in(self) -> Path | None:
        """The folder where it is kept; None where it is not."""
        mark = self._mark()
        return mark.parent if mark.exists() else None

    @property
    def in_memory(self) -> bool:
        """Whether it can be called at once."""
        return self._compiled is not None

    def __call__(self, *arguments: Any) -> Any:
        """The result of the function."""
        return (self._compiled or self.ready(*arguments))(*arguments)

    def ready(self, *arguments: Any) -> Callable[..., Any]:
        """The compiled function, for arguments of these types where it was made without a signature."""
        with _LOCK:
            if self._compiled is None:
                import numba

                if numba.config.DISABLE_JIT:
                    self._compiled = self._function
                else:
                    signature = self._signature() if self._signature else tuple(map(numba.typeof, arguments))
                    self._compiled = self._made(signature)
            return self._compiled

    def _made(self, signature: Any) -> Callable[..., Any]:
        import numba

        mark = self._mark()
        try:
            mark.parent.mkdir(parents=True, exist_ok=True)
            if not mark.exists():
                _announce(self._what)
            before, numba.config.CACHE_DIR = numba.config.CACHE_DIR, str(mark.parent)
            try:
                made: Callable[..., Any] = numba.njit(signature, nogil=True, error_model="numpy", cache=True)(
                    self._function
                )
            finally:
                numba.config.CACHE_DIR = before
            mark.touch()
            return made
        except (OSError, RuntimeError) as error:  # Numba says that a folder is not writable by a RuntimeError
            warn_caller(
                f"compiled kernels cannot be kept in {quoted(str(mark.parent))}: {abbreviated(str(error))}; each "
                "process compiles them anew (NUMBA_CACHE_DIR names another folder)",
                NotCachedWarning,
                subject="cache",
            )
            _announce(self._what)
            uncached: Callable[..., Any] = numba.njit(signature, nogil=True, error_model="numpy")(self._function)
            return uncached

    def _mark(self) -> Path:
        return cache_folder() / _fingerprint(self._sources) / self._name


def cache_folder() -> Path:
    """Where compiled kernels are kept: below NUMBA_CACHE_DIR if that is set, else in the user's cache directory."""
    named = os.environ.get("NUMBA_CACHE_DIR")
    if named:
        return Path(named) / "nao_kin"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "nao_kin"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "nao_kin"


def _announce(what: str) -> None:
    """Say once in a process why it takes a while."""
    if what not in _announced and sys.stderr is not None:
        print(f"nao_kin: compiling {what}, once on this machine …", file=sys.stderr)  # noqa: T201
    _announced.add(what)


@cache
def _fingerprint(sources: Path) -> str:
    """What compiled kernels depend on, in sixteen letters."""
    import llvmlite.binding
    import numba

    parts = [numba.__version__, llvmlite.binding.get_host_cpu_name()]
    parts += [path.read_text(encoding="utf-8") for path in sorted(sources.glob("*.py"))]
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:16]
