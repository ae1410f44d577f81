"""Remove child processes, temporary files and folders when a signal ends the program.

Cleanup actions are registered here. `end_on_signals`, which only the command line calls, makes INT, TERM and HUP run
them and exit immediately. It raises no exception: an exception would be lost in an import, a destructor or a callback
from C, and the program would continue.
"""

from __future__ import annotations

import _thread
import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from types import FrameType
from typing import NoReturn

_SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP")
# Cleanup takes milliseconds; if a disk or a lock delays it, the program exits without it.
_MAX_SECONDS = 0.8
_LOOK_SECONDS = 0.1

_registered: dict[object, Callable[[], object]] = {}
_uninterrupted: set[object] = set()
_postponed: list[int] = []
_ending: list[int] = []


def end_on_signals() -> None:
    """From now on, clean up and exit with code 128 + n when signal n arrives: INT (2), TERM (15) or HUP (1).

    An ignored signal, as under nohup and in background jobs of shells, remains ignored. Call this in the main thread.
    """
    for name in _SIGNALS:
        number = getattr(signal, name, None)
        # None means a handler that Python does not know and could not restore.
        if number is not None and signal.getsignal(number) not in (signal.SIG_IGN, None):
            signal.signal(number, _answer)


def before_ending(action: Callable[[], object]) -> ExitStack:
    """Run `action` if a signal ends the program before the returned context ends; the newest action runs first."""
    key, registered = object(), ExitStack()
    _registered[key] = action
    registered.callback(_registered.pop, key, None)
    return registered


@contextmanager
def uninterrupted() -> Iterator[Callable[[], bool]]:
    """Delay signals during a few quick steps; the yielded function, for longer steps, tells whether one is waiting."""
    key = object()
    _uninterrupted.add(key)
    try:
        yield lambda: bool(_postponed)
    finally:
        _uninterrupted.discard(key)
        if _postponed and not _uninterrupted:
            _end(_postponed[0])


def wait_for_signal() -> NoReturn:
    """Wait until a signal ends the program."""
    # One long wait would miss a signal that arrives just before it or in another thread.
    while True:
        time.sleep(_LOOK_SECONDS)


def _answer(number: int, frame: FrameType | None) -> None:
    if _uninterrupted:
        _postponed.append(number)
    else:
        _end(number)


def _end(number: int) -> None:
    if _ending:
        return
    _ending.append(number)
    with suppress(RuntimeError):  # no new thread while the interpreter is exiting
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
