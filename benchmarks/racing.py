"""Time a function, or two functions with the same result in turns."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any


def race(ours: Callable[[], Any], theirs: Callable[[], Any], loops: int, repeats: int) -> tuple[float, float]:
    """Return the seconds per call of each function, the best of its turns: a busy machine slows both equally."""
    best = [float("inf"), float("inf")]
    for _ in range(repeats):
        for i, call in enumerate((ours, theirs)):
            start = time.perf_counter()
            for _ in range(loops):
                call()
            best[i] = min(best[i], (time.perf_counter() - start) / loops)
    return best[0], best[1]


def best(call: Callable[[], object], rounds: int) -> float:
    """Return the best processor time of a call, summed over threads [s]: other programs disturb it little."""
    times = []
    for _ in range(rounds):
        start = time.process_time()
        call()
        times.append(time.process_time() - start)
    return min(times)
