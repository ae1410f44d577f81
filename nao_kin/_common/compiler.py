"""Whether Numba is here: with it kernels are compiled, without it they run as the Python that they are written in."""

from __future__ import annotations

from functools import cache

from nao_kin._common.warn import warn_caller
from nao_kin._extras import command
from nao_kin._text import abbreviated
from nao_kin.errors import NotCompiledWarning

_REMEDY = command("batch")


@cache
def numba_problem() -> str:
    """Why Numba cannot be used; "" where it can. Importing it takes half a second, so ask where it is needed next."""
    try:
        import numba  # noqa: F401
    except ModuleNotFoundError as error:
        return "numba is not installed" if error.name == "numba" else f"numba does not load ({abbreviated(error)})"
    except ImportError as error:  # it refuses a NumPy newer than itself
        return f"numba does not load ({abbreviated(error)})"
    return ""


def has_numba() -> bool:
    """Whether Numba can be used, though it may be told not to compile (NUMBA_DISABLE_JIT)."""
    return not numba_problem()


def compiles() -> bool:
    """Whether functions are compiled: Numba is here, and NUMBA_DISABLE_JIT is not set."""
    if not has_numba():
        return False
    import numba

    return not numba.config.DISABLE_JIT


@cache
def warn_without_numba() -> None:
    """Say, once in a process, that much is computed without Numba; nothing where it is installed."""
    if not has_numba():
        warn_caller(
            f"{numba_problem()}: many at once are computed in plain Python, the same numbers more slowly; {_REMEDY}",
            NotCompiledWarning,
        )
