"""Whether Numba is here: with it kernels are compiled, without it they run as the Python that they are written in."""

from __future__ import annotations

import importlib.util
import os
import sys
from functools import cache

from nao_kin._common.optional import need_extra
from nao_kin._common.warn import warn_caller
from nao_kin._extras import command
from nao_kin.errors import MissingExtra, NotCompiledWarning

_FELT = 2.0  # s


@cache
def numba_problem() -> str:
    """Why Numba cannot be used; "" where it can. Importing it takes half a second, so ask where it is needed next."""
    try:
        need_numba("")
    except MissingExtra as error:
        return f"numba does not load ({error.reason})" if error.reason else "numba is not installed"
    return ""


def need_numba(purpose: str) -> None:
    """Refuse to go on without Numba.

    Args:
        purpose: what needs it, as the message begins.

    Raises:
        MissingExtra: it is not installed, or does not load: it refuses a NumPy newer than itself.
    """
    need_extra(purpose, "batch")


def has_numba() -> bool:
    """Whether Numba can be used, though it may be told not to compile (NUMBA_DISABLE_JIT)."""
    return not numba_problem()


def compiles() -> bool:
    """Whether functions are compiled: Numba is here, and NUMBA_DISABLE_JIT is not set."""
    if not has_numba():
        return False
    import numba

    return not numba.config.DISABLE_JIT


def may_compile() -> bool:
    """Whether functions are compiled, as far as that can be seen without importing Numba."""
    if "numba" in sys.modules:
        return compiles()
    return importlib.util.find_spec("numba") is not None and os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0")


class _Slowness:
    """What was computed where compiled code would have been quicker."""

    def __init__(self) -> None:
        self._seconds, self._said = 0.0, False

    def add(self, seconds: float) -> None:
        """Add up, and warn once when it is felt."""
        self._seconds += seconds
        if self._said or self._seconds < _FELT or has_numba():
            return
        self._said = True
        warn_caller(
            f"{numba_problem()}: this runs in plain Python, with the same result and slowly; {command('batch')}",
            NotCompiledWarning,
        )


note_slowness = _Slowness().add
"""Called with the seconds that something uncompiled took: after two of them in a process, a warning says so, once."""
