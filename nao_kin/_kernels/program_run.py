"""Run programs on arrays of any layout and precision, in blocks of rows, on one thread or several."""

from __future__ import annotations

import math
import os
import struct
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.process import usable_cores
from nao_kin._core.warn import need_extra
from nao_kin._kernels.cache import CachedKernel
from nao_kin._kernels.program import Program, aligned_empty, tile_width

if TYPE_CHECKING:
    from concurrent.futures import ThreadPoolExecutor

_DOUBLE = np.dtype(np.float64)


def kernel(given: np.dtype[Any], computed: np.dtype[Any]) -> CachedKernel:
    """Return the kernel for inputs in one precision, computed in the same or in single precision."""
    need_extra("a batch kernel", "batch")
    from nao_kin._kernels.operations import RUNS

    return RUNS[given, computed]


Array = NDArray[Any]

# Rows that are made contiguous at a time: few enough to stay in the processor's cache.
_BLOCK = 2048
# Number of rows times length of the program above which a second thread pays, even if it has to wait for a core.
_WORTH_A_THREAD = 4_000_000
_BITS = {8: (struct.Struct("q"), struct.Struct("d")), 4: (struct.Struct("i"), struct.Struct("f"))}
_UNUSED = {kind: (np.empty(0, kind),) * 3 for kind in (np.dtype(np.float64), np.dtype(np.float32))}


class _Threads:
    """A pool of threads: made when first needed, and again after a fork, since the child has none."""

    def __init__(self) -> None:
        self.pool: ThreadPoolExecutor | None = None
        if hasattr(os, "register_at_fork"):
            os.register_at_fork(after_in_child=self._forget)

    def _forget(self) -> None:
        self.pool = None

    def map(self, function: Callable[[slice], int], parts: Sequence[slice]) -> list[int]:
        """Return `function` of all parts; the calling thread takes the first."""
        try:
            if self.pool is None:
                from concurrent.futures import ThreadPoolExecutor

                self.pool = ThreadPoolExecutor(max(1, usable_cores() - 1), "nao_kin_batch")
            others = [self.pool.submit(function, part) for part in parts[1:]]
        except RuntimeError:  # the interpreter is ending
            return [function(part) for part in parts]
        return [function(parts[0]), *(other.result() for other in others)]


_threads = _Threads()
_ready: dict[tuple[np.dtype[Any], np.dtype[Any]], Callable[..., int]] = {}


def execute(program: Program, inputs: Sequence[Array], out: Array, threads: int | None = None) -> float:
    """Run a program on inputs (..., numbers) into contiguous `out` (n, numbers); return the largest magnitude read."""
    count, dtype = len(out), out.dtype
    given = dtype
    for x in inputs:
        if x.dtype != dtype:
            given = _DOUBLE
    run = _ready.get((given, dtype))
    if run is None:  # compiled here, because the warnings of a thread of the pool would be lost
        made = kernel(given, dtype)
        compiled = made.ready()
        run = _ready[given, dtype] = made.entry_point or compiled
    if threads is None:
        threads = count * program.length // _WORTH_A_THREAD
        threads = min(usable_cores(), threads) if threads > 1 else 1

    if threads < 2:
        peak = _execute(run, program, inputs, given, out, slice(0, count)) if count else 0
    else:
        # Every thread starts at the beginning of a tile.
        tile = tile_width(dtype)
        share = max(tile, -(-count // (threads * tile)) * tile)
        parts = [slice(start, min(start + share, count)) for start in range(0, count, share)]
        peak = max(_threads.map(lambda part: _execute(run, program, inputs, given, out[part], part), parts), default=0)
    bits, number = _BITS[dtype.itemsize]
    largest: float = number.unpack(bits.pack(peak))[0]
    return largest


def _execute(
    run: Callable[..., int], program: Program, inputs: Sequence[Array], given: np.dtype[Any], out: Array, part: slice
) -> int:
    size = out.itemsize
    try:
        memory = program.free_memory[size].pop()
    except IndexError:
        memory = _scratch(program, out.dtype)
    in_order, peak = True, 0
    for x in inputs:
        flags = x.flags
        in_order &= flags.c_contiguous and flags.aligned and x.dtype == given
    step = len(out) if in_order else _BLOCK
    for start in range(0, len(out), step):
        block = slice(part.start + start, min(part.start + start + step, part.stop))
        flat = [_rows(x, block) if in_order else np.require(_rows(x, block), given, ("C", "A")) for x in inputs]
        q, v, a = (*[x.ravel() for x in flat], *_UNUSED[given][len(flat) :])
        results = out[start : start + step].ravel()
        peak = max(peak, run(q, v, a, program.tables, memory, results, program.far_bits[size]))
    program.free_memory[size].append(memory)
    return peak


def _rows(values: Array, block: slice) -> Array:
    """Return a block of rows of an array of any batch shape; only a block that is not contiguous is copied."""
    if values.ndim == 2:
        return values[block]
    batch = values.shape[:-1]
    if values.flags.c_contiguous:
        return values.reshape(math.prod(batch), values.shape[-1])[block]
    places: Array = values[np.unravel_index(np.arange(block.start, block.stop), batch)]
    return places


def _scratch(program: Program, dtype: np.dtype[Any]) -> Array:
    """Return scratch memory for one thread, with the constants in their rows."""
    width = tile_width(dtype)
    memory = aligned_empty(program.rows * width, dtype)
    memory.fill(0.0)
    memory[: program.constants.size * width].reshape(-1, width)[...] = program.constants.reshape(-1, 1)
    return memory
