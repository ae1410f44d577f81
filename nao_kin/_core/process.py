"""Leaves no child process, temporary file or folder behind when the program is ended from outside.

Actions that tidy up are registered here. `end_on_signals`, which only the command line calls, makes INT, TERM and HUP
run them and leave at once. It raises nothing: an exception would be lost in an import, a destructor or a callback from
C, and the program would go on.
"""

from __future__ import annotations

import _thread
import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from types import FrameType

_SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP")
# Tidying up takes milliseconds; if a disk or a lock delays it, the program leaves without it.
_MAX_SECONDS = 0.8

_registered: dict[object, Callable[[], object]] = {}
_uninterrupted: set[object] = set()
_postponed: list[int] = []
_ending: list[int] = []


def end_on_signals() -> None:
    """Tidy up and leave with exit code 128 + n on the signals INT (2), TERM (15) and HUP (1), from now on.

    An ignored signal, as for nohup and background jobs of shells, stays ignored. A second signal while the first is
    handled changes nothing. Only for the main thread.
    """
    for name in _SIGNALS:
        number = getattr(signal, name, None)
        # None: a handler that Python does not know and could not restore.
        if number is not None and signal.getsignal(number) not in (signal.SIG_IGN, None):
            signal.signal(number, _answer)


def before_ending(action: Callable[[], object]) -> ExitStack:
    """Run `action` before a signal ends the program, newest first, until the end of the returned context."""
    key, registered = object(), ExitStack()
    _registered[key] = action
    registered.callback(_registered.pop, key, None)
    return registered


@contextmanager
def uninterrupted() -> Iterator[Callable[[], bool]]:
    """Delay signals until the end of a few quick steps that belong together, such as starting and registering.

    Longer steps poll the function that this yields: whether a signal waits.
    """
    key = object()
    _uninterrupted.add(key)
    try:
        yield lambda: bool(_postponed)
    finally:
        _uninterrupted.discard(key)
        if _postponed and not _uninterrupted:
            _end(_postponed[0])


def _answer(number: int, frame: FrameType | None) -> None:
    if _uninterrupted:
        _postponed.append(number)
    else:
        _end(number)


def _end(number: int) -> None:
    if _ending:
        return
    _ending.append(number)
    with suppress(RuntimeError):  # no new thread while the interpreter is already leaving
        _thread.start_new_thread(_leave_anyway, (number,))
    for action in reversed(tuple(_registered.values())):
        with suppress(Exception):
            action()
    os._exit(128 + number)


def _leave_anyway(number: int) -> None:
    time.sleep(_MAX_SECONDS)
    os._exit(128 + number)


# --- Processors.


def usable_cores() -> int:
    """Return the number of cores that this process may use, which may be fewer than the machine has."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # macOS
        return os.cpu_count() or 1
