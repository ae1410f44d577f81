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


def given_precision(inputs: Sequence[NDArray[Any]], computed: np.dtype[Any]) -> np.dtype[Any]:
    """The precision in which a kernel reads these: double, but single where that is all there is."""
    return computed if all(values.dtype == computed for values in inputs) else _DOUBLE


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
_NONE = {kind: np.empty(0, kind) for kind in (np.dtype(np.float64), np.dtype(np.float32))}


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
    given = given_precision(inputs, dtype)
    run = _ready.get((given, dtype))
    if run is None:  # here, and not in a thread, where nobody listens
        run = _ready[given, dtype] = kernel(given, dtype).ready()
    far = program.far[dtype.itemsize]
    if threads is None:
        threads = count * program.length // _WORTH_A_THREAD
        threads = min(usable_cores(), threads) if threads > 1 else 1

    def work(part: slice) -> int:
        return _execute(run, program, inputs, given, out[part], part, far)

    if threads < 2:
        peak = _execute(run, program, inputs, given, out, slice(0, count), far) if count else 0
    else:
        # Every thread begins with a full tile.
        tile = tile_width(dtype)
        share = max(tile, -(-count // (threads * tile)) * tile)
        parts = [slice(start, min(start + share, count)) for start in range(0, count, share)]
        peak = max(_threads.map(work, parts), default=0)
    bits, number = _BITS[dtype.itemsize]
    largest: float = number.unpack(bits.pack(peak))[0]
    return largest


def _execute(
    run: Callable[..., int],
    program: Program,
    inputs: Sequence[Array],
    given: np.dtype[Any],
    out: Array,
    part: slice,
    far: int,
) -> int:
    spare, none = program.spare[out.itemsize], _NONE[given]
    try:
        memory = spare.pop()
    except IndexError:
        memory = _scratch(program, out.dtype)
    ready = all((kept := x.flags).c_contiguous and kept.aligned and x.dtype == given for x in inputs)
    peak, step = 0, len(out) if ready else _BLOCK
    for start in range(part.start, part.stop, step):
        block = slice(start, min(start + step, part.stop))
        rows = [_rows(values, block) for values in inputs]
        flat = [(x if ready else np.require(x, given, ("C", "A"))).reshape(-1) for x in rows]
        q, v, a = flat + [none] * (3 - len(flat))
        results = out[start - part.start : block.stop - part.start].reshape(-1)
        peak = max(peak, run(q, v, a, program.tables, memory, results, far))
    spare.append(memory)
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
