"""Scalar mathematics that is written once, and runs as Python for one target and compiled by Numba for many.

The functions marked with `both_ways` use floats, and flat sequences of floats that they index: lists in Python, rows of
arrays when compiled. Numba is imported when the first batch comes.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any, TypeAlias, TypeVar

import numpy as np

from nao_kin._core.process import usable_cores
from nao_kin._kernels.cache import CachedKernel, first_rows

# A flat sequence of floats that may be written to: a list, or compiled a row of an array.
Row: TypeAlias = Any

_Numbers = TypeVar("_Numbers", bound=tuple[Any, ...])

# What the names of this room's kernels begin with.
KERNEL = "ik kernel, "

# Below this many targets another thread is not worth its start.
_PER_THREAD = 2000


def kept(
    name: str, signature: Callable[[], Any], seconds: float = 10.0
) -> Callable[[Callable[..., Any]], CachedKernel]:
    """A kernel of this room, kept on disk; the signature is made when Numba has been imported.

    Args:
        name: what it solves.
        signature: makes the types of its arguments.
        seconds: about how long it takes to compile [s].
    """

    def made(function: Callable[..., Any]) -> CachedKernel:
        def registered() -> Any:
            _register_borrowed()
            return signature()

        what = f"a kernel of inverse kinematics, {name}"
        return CachedKernel(function, what, f"{KERNEL}{name}", registered, seconds)

    return made


def borrowed(array: Any) -> Any:
    """The same array, whose users compiled code does not count: that takes a sixth of the time of a leg.

    The array that it is borrowed from has to be used once more after the last use of what is returned.
    """
    return array


@cache
def _register_borrowed() -> None:
    from numba.core import cgutils
    from numba.extending import intrinsic, overload

    @intrinsic  # type: ignore[untyped-decorator]
    def uncounted(_: Any, array: Any) -> tuple[Any, Callable[..., Any]]:
        def view(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            made = context.make_array(array)(context, builder, arguments[0])
            made.meminfo = cgutils.get_null_value(made.meminfo.type)
            return made._getvalue()

        return array(array), view

    overload(borrowed)(lambda array: lambda array: uncounted(array))


def in_lists(numbers: _Numbers) -> _Numbers:
    """A named tuple with its arrays as lists, which Python reads faster."""
    return type(numbers)(*(part.tolist() if isinstance(part, np.ndarray) else part for part in numbers))


def copied(numbers: _Numbers) -> _Numbers:
    """A named tuple with arrays of its own: threads wait for each other to count who uses one."""
    return type(numbers)(*(part.copy() if isinstance(part, np.ndarray) else part for part in numbers))


def run_rows(
    kernel: CachedKernel,
    run: Callable[[Callable[..., Any], slice], object],
    count: int,
    threads: int | None,
    per_thread: int = _PER_THREAD,
    uncompiled: Callable[[slice], object] | None = None,
    each: float = 0.0,
) -> None:
    """Work on rows: by the compiled kernel, but as Python where that is quicker than to wait for the kernel.

    Args:
        kernel: the kernel.
        run: called with the function to use and a slice of the rows.
        count: how many rows there are.
        threads: how many threads may work; see `in_threads`.
        per_thread: how many rows are worth a thread.
        uncompiled: works on one row as Python, where there is a quicker way than `run`.
        each: see `first_rows`.
    """
    done = first_rows([kernel], uncompiled or (lambda part: run(kernel.uncompiled, part)), count, each=each)
    if done < count:
        function = kernel.ready()  # here, and not in a thread, where nobody listens

        def rest(part: slice) -> None:
            run(function, slice(done + part.start, done + part.stop))

        in_threads(rest, count - done, threads, per_thread)


def in_threads(run: Callable[[slice], None], count: int, threads: int | None, per_thread: int = _PER_THREAD) -> None:
    """Call `run` with slices that together make `count` targets, in this many threads.

    None is for all cores, as far as each of them gets `per_thread` targets.
    """
    useful = count // per_thread if threads is None else min(count, threads)
    if useful <= 1:
        run(slice(0, count))
        return
    parts = min(useful, usable_cores()) if threads is None else useful
    # More parts than threads, for some targets take longer than others.
    pieces = 4 * parts
    edges = [count * i // pieces for i in range(pieces + 1)]
    with ThreadPoolExecutor(parts) as pool:
        list(pool.map(run, (slice(a, b) for a, b in itertools.pairwise(edges))))
