"""The kernel compiled: once on a machine for each precision, and kept on its disk.

The folder is the user's own cache, so that the package may be installed where nobody can write. Its name changes with
the sources of the kernel, with the compiler and with the processor.
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

import numpy as np

from nao_kin._common.warn import warn_caller
from nao_kin._text import abbreviated, quoted
from nao_kin.errors import NotCachedWarning

Run = Callable[..., int]

_PRECISION = {4: "single", 8: "double"}
_LOCK = threading.RLock()
_kernels: dict[np.dtype[Any], Run] = {}


@dataclass(frozen=True)
class KernelState:
    """A kernel that is ready to run.

    Attributes:
        precision: "double" or "single".
        seconds: how long it took to get it ready.
        compiled: whether it had to be compiled, and was not found on disk.
        folder: where it is kept; None where it could not be kept.
    """

    precision: str
    seconds: float
    compiled: bool
    folder: Path | None


def is_ready(dtype: np.dtype[Any]) -> bool:
    """Whether the kernel of this precision is in memory."""
    return dtype in _kernels


def kernel(dtype: np.dtype[Any]) -> Run:
    """`nao_kin.batch.kernel.run` for one precision, compiled or read from the cache at the first call."""
    found = _kernels.get(dtype)
    if found is None:
        with _LOCK:  # one thread compiles, the others wait
            found = _kernels.get(dtype)
            if found is None:
                found = _kernels[dtype] = _compiled(dtype)
    return found


def warm_up() -> tuple[KernelState, ...]:
    """Get the kernels of both precisions ready, so that no later call has to wait for them."""
    states = []
    for dtype in (np.dtype(np.float64), np.dtype(np.float32)):
        precision = _PRECISION[dtype.itemsize]
        kept = _mark(precision).exists()
        started = time.perf_counter()
        kernel(dtype)
        folder = _mark(precision).parent if _mark(precision).exists() else None
        states.append(KernelState(precision, time.perf_counter() - started, not kept, folder))
    return tuple(states)


def cache_folder() -> Path:
    """Where compiled kernels are kept: below NUMBA_CACHE_DIR if that is set, else in the user's cache directory."""
    named = os.environ.get("NUMBA_CACHE_DIR")
    if named:
        return Path(named) / "nao_kin"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "nao_kin"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "nao_kin"


def _compiled(dtype: np.dtype[Any]) -> Run:
    import numba

    from nao_kin.batch.kernel import run, signature

    if numba.config.DISABLE_JIT:
        return run
    precision = _PRECISION[dtype.itemsize]
    mark = _mark(precision)
    try:
        mark.parent.mkdir(parents=True, exist_ok=True)
        if not mark.exists():
            _announce(precision)
        before, numba.config.CACHE_DIR = numba.config.CACHE_DIR, str(mark.parent)
        try:
            made: Run = numba.njit(signature(dtype), nogil=True, error_model="numpy", cache=True)(run)
        finally:
            numba.config.CACHE_DIR = before
        mark.touch()
        return made
    except (OSError, RuntimeError) as error:  # Numba says that a folder is not writable by a RuntimeError
        warn_caller(
            f"compiled kernels cannot be kept in {quoted(str(mark.parent))}: {abbreviated(str(error))}; each process "
            "compiles them anew (NUMBA_CACHE_DIR names another folder)",
            NotCachedWarning,
            subject="cache",
        )
        _announce(precision)
        uncached: Run = numba.njit(signature(dtype), nogil=True, error_model="numpy")(run)
        return uncached


def _mark(precision: str) -> Path:
    """The file that says that a kernel has been kept."""
    return cache_folder() / _fingerprint() / f"{precision}-precision"


def _announce(precision: str) -> None:
    if sys.stderr is not None:
        print(f"nao_kin: compiling the kernel for {precision} precision, about ten seconds …", file=sys.stderr)  # noqa: T201


@cache
def _fingerprint() -> str:
    """What a compiled kernel depends on, in sixteen letters."""
    import llvmlite.binding
    import numba

    parts = [numba.__version__, llvmlite.binding.get_host_cpu_name()]
    parts += [path.read_text(encoding="utf-8") for path in sorted(Path(__file__).parent.glob("*.py"))]
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:16]
