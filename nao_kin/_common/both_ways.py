"""Functions that run as Python and that compiled code may call, too."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

_Function = TypeVar("_Function", bound=Callable[..., Any])
_waiting: list[Callable[..., Any]] = []


def both_ways(function: _Function) -> _Function:
    """The function itself, which compiled code may call too."""
    _waiting.append(function)
    return function


def register_parts() -> None:
    """Tell Numba of the functions marked with `both_ways`; to be called before a kernel is compiled or read."""
    from numba.extending import register_jitable

    while _waiting:
        register_jitable(error_model="numpy", no_cfunc_wrapper=True)(_waiting.pop())
