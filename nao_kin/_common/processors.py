"""The processors that this process may use."""

from __future__ import annotations

import os


def usable_cores() -> int:
    """How many cores this process may use, which may be fewer than the machine has."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # macOS
        return os.cpu_count() or 1
