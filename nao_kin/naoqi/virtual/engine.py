"""The engine of the virtual NAO: calls that take time, the lock, the clock, and messages."""

from __future__ import annotations

import heapq
import itertools
import logging
import math
import threading
from collections import deque
from collections.abc import Callable, Hashable
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any

from nao_kin.errors import BadArgument, NaoKinError
from nao_kin.naoqi.virtual.arguments import number


class NaoqiError(NaoKinError):
    """An error of a service's method, with a text of two lines as in NAOqi.

    The text is `ALMotion::setAngles`, a line break, a tab and the reason, as NAOqi sends it and scripts parse it. It is
    the only error of the library with more than one line.

    Attributes:
        service: "ALMotion" …
        method: "setAngles" …
        reason: one line.
    """

    def __init__(self, service: str, method: str, reason: str) -> None:
        self.service, self.method, self.reason = service, method, " ".join(reason.split())
        Exception.__init__(self, f"{service}::{method}\n\t{self.reason}")


class Call(Future[Any]):
    """The result of a blocking method, available when the robot has done the task; `stop` ends the task.

    If its task is killed, the call ends without an error, as in NAOqi; a call that reports success then returns False,
    any other None.
    """

    def __init__(self, stop: Callable[[], object] | None = None) -> None:
        super().__init__()
        self._stop = stop

    def cancel(self) -> bool:
        """Stop the task; return whether there was a task to stop."""
        if self.done():
            return False
        if self._stop is None:
            return super().cancel()
        self._stop()
        return True

    def finish(self, value: Any = None) -> None:
        """Set the result; without effect if there is one already."""
        with suppress(InvalidStateError):
            self.set_result(value)

    def fail(self, error: BaseException) -> None:
        """Set an error as the result; without effect if there is a result already."""
        with suppress(InvalidStateError):
            self.set_exception(error)


class Monitor:
    """The lock for all state; callbacks run when the lock is free again.

    A callback may wait for another thread, which may wait for the lock. So `later` stores calls of external functions
    until the thread leaves the outermost `with`.
    """

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._depth = 0
        self._later: list[Callable[[], object]] = []

    def later(self, action: Callable[[], object]) -> None:
        """Call `action` when the lock is free again; only for a thread that holds the lock."""
        self._later.append(action)

    def __enter__(self) -> Monitor:
        self._lock.acquire()
        self._depth += 1
        return self

    def __exit__(self, *_: object) -> None:
        self._depth -= 1
        actions: list[Callable[[], object]] = []
        if self._depth == 0:
            actions, self._later = self._later, actions
        self._lock.release()
        for action in actions:
            try:
                action()
            except Exception:  # a callback must not stop the robot's time
                logging.getLogger("nao_kin.naoqi").exception("a callback of the virtual NAO failed")


# --- Robot time: counted in ticks that follow the wall clock at some speed, or are stepped explicitly.

TICKS_PER_SECOND = 100
TICK = 1.0 / TICKS_PER_SECOND
# Rounding that is ignored when times are converted to ticks [ticks].
_ROUNDING = 1e-6
# The longest step, and the robot time after which a stepped call counts as endless [s].
MAX_SECONDS = 3600.0
# The largest delay that is caught up, as after the machine was busy; the rest of a longer delay is dropped [s].
_MAX_SECONDS_BEHIND = 1.0


class Clock:
    """Robot time, from zero in ticks of 10 ms; `speed` is seconds of robot time per second of the wall clock.

    The clock does not tick by itself: its owner asks for the number of due ticks, and makes them one by one.
    """

    def __init__(self, speed: float = 1.0) -> None:
        self.speed = number(speed, "speed")
        if self.speed <= 0.0:
            raise BadArgument(f"speed must be positive, got {self.speed:g}")
        self.ticks = 0
        self._timers: list[tuple[int, int, Future[Any], Callable[[], None]]] = []
        self._numbers = itertools.count()
        self._wall_start: float | None = None
        self._made = 0
        self._rest = 0.0

    @property
    def now(self) -> float:
        """Robot time [s]."""
        return self.ticks / TICKS_PER_SECOND

    def tick(self) -> list[Callable[[], None]]:
        """Make one tick; return the actions that are due, in order."""
        self.ticks += 1
        due = []
        while self._timers and self._timers[0][0] <= self.ticks:
            *_, timer, action = heapq.heappop(self._timers)
            if not timer.cancelled():
                due.append(action)
        return due

    def after(self, seconds: float, action: Callable[[], None]) -> Future[Any]:
        """Schedule `action` for the first tick `seconds` of robot time from now or later, unless it is cancelled."""
        ticks = max(1, math.ceil(seconds * TICKS_PER_SECOND - _ROUNDING))
        timer = Future[Any]()
        heapq.heappush(self._timers, (self.ticks + ticks, next(self._numbers), timer, action))
        return timer

    def due(self, wall: float) -> int:
        """Return by how many ticks robot time is behind the wall clock; `wall` [s] may count from any origin."""
        if self._wall_start is None:
            self._wall_start = wall
        rate = self.speed * TICKS_PER_SECOND
        behind = (wall - self._wall_start) * rate - self._made
        if behind > _MAX_SECONDS_BEHIND * rate:
            self._wall_start += behind / rate - _MAX_SECONDS_BEHIND
            behind = _MAX_SECONDS_BEHIND * rate
        count = max(0, math.floor(behind + _ROUNDING))
        self._made += count
        return count

    def step(self, seconds: float) -> int:
        """Return the number of ticks in some seconds of robot time; the fraction left is added to the next step."""
        dt = number(seconds, "a step")
        if not 0.0 <= dt <= MAX_SECONDS:
            raise BadArgument(f"a step must be from 0 to {MAX_SECONDS:g} s, got {dt:g} s")
        self._rest += dt * TICKS_PER_SECOND
        count = math.floor(self._rest + _ROUNDING)
        self._rest = max(0.0, self._rest - count)
        return count


# --- Messages of the virtual NAO: commands that were clipped, joints that are late, words spoken.


@dataclass(frozen=True)
class Event:
    """An event that a watcher of the virtual NAO receives.

    Attributes:
        time: robot time [s].
        kind: "log", "limp", "leds", "speech", "posture", "life" …
        value: a text for "log" and for "limp" (a command to joints without stiffness); otherwise as documented by the
            service that makes the change.
    """

    time: float
    kind: str
    value: Any


class EventLog:
    """The last thousand lines of the log; a watcher receives every line and every other `Event`."""

    def __init__(self, clock: Clock, monitor: Monitor, watcher: Callable[[Event], object] | None) -> None:
        self._clock, self._monitor, self._watcher = clock, monitor, watcher
        self._lines: deque[tuple[float, str]] = deque(maxlen=1000)

    @property
    def lines(self) -> list[tuple[float, str]]:
        """Robot time and text of the last thousand lines, newest last."""
        return list(self._lines)

    def write(self, message: str) -> None:
        """Add a line."""
        line = " ".join(message.split())
        self._lines.append((self._clock.now, line))
        self.change("log", line)

    def change(self, kind: str, value: Any) -> None:
        """Notify the watcher of a change, when the lock is free."""
        if self._watcher is not None:
            with self._monitor:
                self._monitor.later(partial(self._watcher, Event(self._clock.now, kind, value)))


class Notes:
    """Remarks on one command, each written once, however many ticks the command lasts; lines begin with the subject."""

    def __init__(self, log: EventLog, subject: str) -> None:
        self._log, self._subject = log, subject
        self._made: set[Hashable] = set()

    def once(self, key: Hashable, message: str) -> None:
        """Write a message, unless one with this key was written."""
        if key not in self._made:
            self._made.add(key)
            self._log.write(f"{self._subject}: {message}")

    def notify(self, kind: str, message: str) -> None:
        """Notify the watcher with a kind of change other than "log"."""
        self._log.change(kind, f"{self._subject}: {message}")
