"""Programs run on arrays: any layout and precision in, blocks of rows to one thread or several."""

from __future__ import annotations

import math
import os
import struct
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.process import usable_cores
from nao_kin._kernels.cache import KeptKernel, need_numba
from nao_kin._kernels.program import Program, aligned_empty, tile_width

_DOUBLE = np.dtype(np.float64)


def kernel(given: np.dtype[Any], computed: np.dtype[Any]) -> KeptKernel:
    """`nao_kin._kernels.operations.run` for numbers given in one precision, computed in it or in single precision.

    Raises:
        MissingExtra: Numba is not installed.

    Examples:
        >>> double = np.dtype(np.float64)
        >>> nk._kernels.kernel(double, double) is nk._kernels.kernel(double, double)
        True
    """
    need_numba("a batch kernel")
    from nao_kin._kernels.operations import RUNS

    return RUNS[given, computed]


# --- Programs run on arrays: any layout and precision in, blocks of rows to one thread or several.

Array = NDArray[Any]

# Rows that are brought into order at a time: few enough to stay in the processor's cache.
_BLOCK = 2048
# Rows × length of the program from which on a second thread is worth waking, for it may have to wait for a core.
_WORTH_A_THREAD = 4_000_000
_BITS = {8: (struct.Struct("q"), struct.Struct("d")), 4: (struct.Struct("i"), struct.Struct("f"))}
_NONE = {kind: (np.empty(0, kind),) * 3 for kind in (np.dtype(np.float64), np.dtype(np.float32))}


class _Threads:
    """Threads that wait for work: made when first needed, and anew after a fork, which leaves the child without."""

    def __init__(self) -> None:
        self.pool: ThreadPoolExecutor | None = None
        if hasattr(os, "register_at_fork"):
            os.register_at_fork(after_in_child=self._forget)

    def _forget(self) -> None:
        self.pool = None

    def map(self, function: Callable[[slice], int], parts: Sequence[slice]) -> list[int]:
        """`function` of all parts; the calling thread works, too."""
        if self.pool is None:
            self.pool = ThreadPoolExecutor(max(1, usable_cores() - 1), "nao_kin_batch")
        try:
            others = [self.pool.submit(function, part) for part in parts[1:]]
        except RuntimeError:  # the interpreter is ending
            return [function(part) for part in parts]
        return [function(parts[0]), *(other.result() for other in others)]


_threads = _Threads()
_ready: dict[tuple[np.dtype[Any], np.dtype[Any]], Callable[..., int]] = {}


def execute(program: Program, inputs: Sequence[Array], out: Array, threads: int | None = None) -> float:
    """Run a program on configurations, and on velocities and accelerations where it takes them.

    Args:
        program: what to compute.
        inputs: arrays of one batch shape, (..., numbers), in any layout and precision.
        out: where the results go, shape (n, numbers), contiguous, in the precision to compute in.
        threads: how many to use; None for all cores, where there is work enough.

    Returns:
        The largest magnitude among the inputs: NaN or infinity if there is one.

    Examples:
        >>> turn = nk._kernels.TreeJoint("revolute", -1, np.eye(3), np.zeros(3), (0.0, 0.0, 1.0), 0, 0)
        >>> tree = nk._kernels.JointTree(1, 1, (turn,))
        >>> tip = nk._kernels.TreeFrame(0, np.eye(3), np.array([0.1, 0.0, 0.0]))
        >>> program = nk._kernels.poses_program(tree, [tip], form="position")
        >>> out = np.empty((3, 3))
        >>> _ = nk._kernels.execute(program, [np.zeros((3, 1))], out, threads=1)
        >>> out[0].tolist()
        [0.1, 0.0, 0.0]
    """
    count, dtype = len(out), out.dtype
    given = dtype
    for x in inputs:
        if x.dtype != dtype:
            given = _DOUBLE
    run = _ready.get((given, dtype))
    if run is None:  # here, and not in a thread, where nobody listens
        made = kernel(given, dtype)
        compiled = made.ready()
        run = _ready[given, dtype] = made.quick or compiled
    if threads is None:
        threads = count * program.length // _WORTH_A_THREAD
        threads = min(usable_cores(), threads) if threads > 1 else 1

    if threads < 2:
        peak = _execute(run, program, inputs, given, out, slice(0, count)) if count else 0
    else:
        # Every thread begins with a full tile.
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
        memory = program.spare[size].pop()
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
        q, v, a = (*[x.ravel() for x in flat], *_NONE[given][len(flat) :])
        results = out[start : start + step].ravel()
        peak = max(peak, run(q, v, a, program.tables, memory, results, program.far[size]))
    program.spare[size].append(memory)
    return peak


def _rows(values: Array, block: slice) -> Array:
    """A block of the rows of an array of any batch shape; only what is not in order is copied, and only this block."""
    if values.ndim == 2:
        return values[block]
    batch = values.shape[:-1]
    if values.flags.c_contiguous:
        return values.reshape(math.prod(batch), values.shape[-1])[block]
    places: Array = values[np.unravel_index(np.arange(block.start, block.stop), batch)]
    return places


def _scratch(program: Program, dtype: np.dtype[Any]) -> Array:
    """Memory for one thread, with the constants in their rows."""
    width = tile_width(dtype)
    memory = aligned_empty(program.rows * width, dtype)
    memory.fill(0.0)
    memory[: program.constants.size * width].reshape(-1, width)[...] = program.constants.reshape(-1, 1)
    return memory
