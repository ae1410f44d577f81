"""Programs run on arrays: any layout and precision in, blocks of rows to one thread or several."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
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
Run = Callable[..., int]

# Rows that are brought into order at a time: few enough to stay in the processor's cache.
_BLOCK = 2048
# Rows from which on a second thread is worth its start.
_WORTH_A_THREAD = 8192


def execute(program: Program, inputs: Sequence[Array], out: Array, threads: int | None = None) -> float:
    """Run a program on configurations, and on velocities and accelerations where it takes them.

    Args:
        program: what to compute.
        inputs: arrays of one batch shape, (..., numbers), in any layout and precision.
        out: where the results go, shape (n, numbers), contiguous, in the precision to compute in.
        threads: how many to use; None for all cores, where there are rows enough.

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
    count = len(out)
    if threads is None:
        threads = min(usable_cores(), count // _WORTH_A_THREAD)
    given = given_precision(inputs, out.dtype)
    run = kernel(given, out.dtype).ready()  # here, and not in a thread, where nobody listens
    # Every thread begins with a full tile.
    tile = tile_width(out.dtype)
    share = -(-count // max(threads, 1))
    share = max(tile, -(-share // tile) * tile)
    parts = [slice(start, min(start + share, count)) for start in range(0, count, share)]
    if len(parts) < 2:
        return max((_execute(run, program, inputs, given, out, part) for part in parts), default=0.0)
    from concurrent.futures import ThreadPoolExecutor

    # Started for this call alone: threads that waited for the next one would not be there after a fork.
    with ThreadPoolExecutor(len(parts)) as pool:
        peaks = list(pool.map(lambda part: _execute(run, program, inputs, given, out, part), parts))
    return float(np.max(peaks))  # which hands on NaN


def _execute(
    run: Run, program: Program, inputs: Sequence[Array], given: np.dtype[Any], out: Array, part: slice
) -> float:
    dtype = out.dtype
    memory, far = _scratch(program, dtype), _far(program, dtype)
    ready = all(values.flags.c_contiguous and values.flags.aligned and values.dtype == given for values in inputs)
    step = part.stop - part.start if ready else _BLOCK
    peak = 0
    for start in range(part.start, part.stop, step):
        block = slice(start, min(start + step, part.stop))
        rows = [np.require(_rows(values, block), given, ("C", "A")).reshape(-1) for values in inputs]
        rows += [np.empty(0, given)] * (3 - len(rows))
        peak = max(peak, run(*rows, program.tables, memory, out[block].reshape(-1), far))
    bits: Any = np.array(peak, np.int64 if dtype.itemsize == 8 else np.int32)
    return float(bits.view(dtype))


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


def _far(program: Program, dtype: np.dtype[Any]) -> int:
    """Bits of the largest number of an input that cannot make an angle too large for the polynomials."""
    from nao_kin._kernels.operations import FARTHEST

    ratio, offset = program.farthest_input
    if ratio == 0.0:
        return int(np.iinfo(np.int64).max)
    largest = np.array(max(0.0, (FARTHEST[dtype.itemsize] - offset) / ratio), dtype)
    bits: Any = largest.view(np.int64 if dtype.itemsize == 8 else np.int32)
    return int(bits)
