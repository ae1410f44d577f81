"""Run scalar code on rows of arrays: as Python for one row, compiled by Numba for many.

Functions marked with `both_ways` use floats and index flat sequences of floats: lists in Python, rows of arrays when
compiled. Numba is imported for the first batch.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any, TypeVar

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._core.process import usable_cores
from nao_kin._kernels.cache import CachedKernel, first_rows

_Numbers = TypeVar("_Numbers", bound=tuple[Any, ...])

# Starting a thread is worthwhile only for this many rows.
_PER_THREAD = 2000


def borrowed(array: Any) -> Any:
    """Return, in compiled code, the array without reference counting.

    Counting would take a sixth of the time of a leg. The original array must be used again after the last use of the
    returned array.
    """
    return array


@cache
def register_borrowed() -> None:
    """Let compiled code call `borrowed`."""
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


def packed(numbers: Any) -> Floats:
    """Return the numbers of nested tuples in one array: a call of a kernel takes 3 µs to read a hundred from tuples."""

    def each(part: Any) -> Iterator[float]:
        if isinstance(part, tuple):
            for inner in part:
                yield from each(inner)
        else:
            yield part

    return np.fromiter(each(numbers), dtype=np.float64)


def register_unpacking(unpacked: Callable[[Any], Any], parts: tuple[Any, ...]) -> None:
    """Let compiled code call `unpacked`: it makes of an array, as from `packed`, a tuple of these types of Numba.

    The code becomes a part of its caller: as a function, it would have the same symbol in several kernels on the disk,
    and the process that loads them would take one for another.
    """
    from numba.core import types
    from numba.extending import lower_builtin, type_callable

    def read(context: Any, builder: Any, kind: Any, numbers: Any, places: Iterator[int]) -> Any:
        if isinstance(kind, types.BaseTuple):
            inner = [read(context, builder, part, numbers, places) for part in kind]
            return context.make_tuple(builder, kind, inner)
        place = context.get_constant(types.intp, next(places))
        return context.cast(builder, builder.load(builder.gep(numbers, [place])), types.float64, kind)

    @lower_builtin(unpacked, types.Array)  # type: ignore[untyped-decorator]
    def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        numbers = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        return read(context, builder, signature.return_type, numbers, itertools.count())

    type_callable(unpacked)(lambda _: lambda numbers: types.BaseTuple.from_types(parts))


def in_lists(numbers: _Numbers) -> _Numbers:
    """Return a named tuple with its arrays as lists, which Python reads faster."""
    return type(numbers)(*(part.tolist() if isinstance(part, np.ndarray) else part for part in numbers))


def copied(numbers: _Numbers) -> _Numbers:
    """Return a named tuple with copies of its arrays: threads would wait for each other's reference counting."""
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
    """Run `count` rows with the compiled kernel, or as Python while that is quicker than waiting for the kernel.

    `run` takes a function and a slice of rows. `uncompiled`, for a quicker way in Python, takes a slice of one row.
    Without `threads`, all cores are used if each gets `per_thread` rows; `each` is as in `first_rows`.
    """
    done = first_rows([kernel], uncompiled or (lambda part: run(kernel.uncompiled, part)), count, each=each)
    left = count - done
    if not left:
        return
    function = kernel.ready()  # in this thread, so that Ctrl-C ends it
    useful = left // per_thread if threads is None else min(left, threads)
    if useful <= 1:
        run(function, slice(done, count))
        return
    workers = min(useful, usable_cores()) if threads is None else useful
    # More parts than threads, because some targets take longer than others.
    edges = [done + left * i // (4 * workers) for i in range(4 * workers + 1)]
    from concurrent.futures import ThreadPoolExecutor  # it loads logging, which few calls need

    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(lambda ends: run(function, slice(*ends)), itertools.pairwise(edges)))
