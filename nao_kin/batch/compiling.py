"""The kernel in the precisions it is compiled for: of what is given, and of what is computed."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nao_kin._common.kernel_cache import KeptKernel, cache_folder

_DOUBLE, _SINGLE = np.dtype(np.float64), np.dtype(np.float32)
_PRECISIONS = {(_DOUBLE, _DOUBLE): "double", (_DOUBLE, _SINGLE): "double to single", (_SINGLE, _SINGLE): "single"}
_kernels: dict[tuple[np.dtype[Any], np.dtype[Any]], KeptKernel] = {}

__all__ = ["KernelState", "cache_folder", "given_precision", "is_ready", "kernel", "warm_up"]


@dataclass(frozen=True)
class KernelState:
    """A kernel that is ready to run.

    Attributes:
        precision: "double", "single", or "double to single" for numbers given in the one and computed in the other.
        seconds: how long it took to get it ready.
        compiled: whether it had to be compiled, and was not found on disk.
        folder: where it is kept; None where it could not be kept.
    """

    precision: str
    seconds: float
    compiled: bool
    folder: Path | None


def is_ready(given: np.dtype[Any], computed: np.dtype[Any]) -> bool:
    """Whether the kernel of these precisions is in memory."""
    found = _kernels.get((given, computed))
    return found is not None and found.is_ready


def given_precision(inputs: Sequence[NDArray[Any]], computed: np.dtype[Any]) -> np.dtype[Any]:
    """The precision in which a kernel reads these: double, but single where that is all there is."""
    return computed if all(values.dtype == computed for values in inputs) else _DOUBLE


def kernel(given: np.dtype[Any], computed: np.dtype[Any]) -> KeptKernel:
    """`nao_kin.batch.kernel.run` for numbers given in one precision, computed in it or in single precision."""
    found = _kernels.get((given, computed))
    if found is None:
        from nao_kin.batch.kernel import run, signature

        name = _PRECISIONS[given, computed]
        made = KeptKernel(
            run,
            f"the batch kernel ({name} precision, about ten seconds)",
            f"batch kernel, {name} precision",
            Path(__file__).parent,
            lambda: signature(given, computed),
        )
        found = _kernels.setdefault((given, computed), made)
    return found


def warm_up() -> tuple[KernelState, ...]:
    """Get the kernels of all precisions ready, so that no later call has to wait for them."""
    states = []
    for precisions, name in _PRECISIONS.items():
        run = kernel(*precisions)
        found = run.kept_in is not None
        started = time.perf_counter()
        run.ready()
        states.append(KernelState(name, time.perf_counter() - started, not found, run.kept_in))
    return tuple(states)
