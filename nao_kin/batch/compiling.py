"""The kernel in the precisions it is compiled for: of what is given, and of what is computed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nao_kin._common.compiler import has_numba, need_numba
from nao_kin._common.kernel_cache import KeptKernel, KernelState, cache_folder

_DOUBLE, _SINGLE = np.dtype(np.float64), np.dtype(np.float32)
_PRECISIONS: dict[tuple[np.dtype[Any], np.dtype[Any]], str] = {
    (_DOUBLE, _DOUBLE): "double",
    (_DOUBLE, _SINGLE): "double to single",
    (_SINGLE, _SINGLE): "single",
}
_kernels: dict[tuple[np.dtype[Any], np.dtype[Any]], KeptKernel] = {}

__all__ = ["KernelState", "cache_folder", "given_precision", "kernel", "warm_up"]


def given_precision(inputs: Sequence[NDArray[Any]], computed: np.dtype[Any]) -> np.dtype[Any]:
    """The precision in which a kernel reads these: double, but single where that is all there is."""
    return computed if all(values.dtype == computed for values in inputs) else _DOUBLE


def kernel(given: np.dtype[Any], computed: np.dtype[Any]) -> KeptKernel:
    """`nao_kin.batch.program_kernel.run` for numbers given in one precision, computed in it or in single precision.

    Raises:
        MissingExtra: Numba is not installed.

    Examples:
        >>> double = np.dtype(np.float64)
        >>> nk.batch.kernel(double, double) is nk.batch.kernel(double, double)
        True
    """
    need_numba("a batch kernel")
    found = _kernels.get((given, computed))
    if found is None:
        from nao_kin.batch.program_kernel import run, signature

        name = _PRECISIONS[given, computed]
        made = KeptKernel(
            run,
            f"the batch kernel, {name} precision",
            f"batch kernel, {name} precision",
            lambda: signature(given, computed),
        )
        found = _kernels.setdefault((given, computed), made)
    return found


def warm_up() -> tuple[KernelState, ...]:
    """Get the kernels of all precisions ready, so that no later call has to wait for them.

    Returns:
        The state of each; none where Numba is not installed, for nothing is compiled then.

    Examples:
        >>> [state.name for state in nk.batch.warm_up()]
        ['batch kernel, double precision', 'batch kernel, double to single precision', 'batch kernel, single precision']
    """
    if not has_numba():
        return ()
    return tuple(kernel(*precisions).warm_up() for precisions in _PRECISIONS)
