"""Robot time: counted in ticks, that follow the wall clock at some speed or are stepped by hand."""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, field

from nao_kin.errors import BadArgument
from nao_kin.naoqi.virtual.arguments import check_duration, number

TICKS_PER_SECOND = 100
TICK = 1.0 / TICKS_PER_SECOND
# A time that misses a tick by less than this share of it, from rounding, is that tick's.
_SHARE = 1e-6
# Where the machine is busy, ticks are made up for; where it slept, robot time stands still meanwhile.
_MOST_SECONDS_BEHIND = 1.0


@dataclass(order=True)
class Timer:
    """An action to be done at a tick; `cancel` takes it back."""

    tick: int
    number: int
    action: Callable[[], None] | None = field(compare=False)

    def cancel(self) -> None:
        """Do not do it; without effect when it is done."""
        self.action = None


class Clock:
    """How far robot time has come.

    Time starts at zero and moves in ticks of 10 ms. The clock does not tick by itself: who owns it asks how many ticks
    are due, and makes them one by one.

    Args:
        speed: seconds of robot time in one second of the wall clock.

    Attributes:
        speed: as given.
        ticks: how many there were.

    Raises:
        BadArgument: a speed that is no positive number.
    """

    def __init__(self, speed: float = 1.0) -> None:
        self.speed = number(speed, "speed")
        if self.speed <= 0.0:
            raise BadArgument(f"speed must be positive, got {self.speed:g}")
        self.ticks = 0
        self._timers: list[Timer] = []
        self._numbers = itertools.count()
        self._wall_start: float | None = None
        self._made = 0
        self._rest = 0.0

    @property
    def now(self) -> float:
        """Robot time [s]."""
        return self.ticks / TICKS_PER_SECOND

    def tick(self) -> list[Callable[[], None]]:
        """One tick; returns the actions whose time has come, in order."""
        self.ticks += 1
        due = []
        while self._timers and self._timers[0].tick <= self.ticks:
            action = heapq.heappop(self._timers).action
            if action is not None:
                due.append(action)
        return due

    def after(self, seconds: float, action: Callable[[], None]) -> Timer:
        """Have `action` done at the first tick at or after so many seconds of robot time from now."""
        timer = Timer(self.ticks + max(1, ticks_in(seconds)), next(self._numbers), action)
        heapq.heappush(self._timers, timer)
        return timer

    def due(self, wall: float) -> int:
        """Ticks to be made so that robot time keeps up with the wall clock.

        Args:
            wall: what the wall clock says, from any start [s].
        """
        if self._wall_start is None:
            self._wall_start = wall
        behind = (wall - self._wall_start) * self.speed * TICKS_PER_SECOND - self._made
        most = _MOST_SECONDS_BEHIND * self.speed * TICKS_PER_SECOND
        if behind > most:
            self._wall_start += (behind - most) / (self.speed * TICKS_PER_SECOND)
            behind = most
        count = max(0, math.floor(behind + _SHARE))
        self._made += count
        return count

    def step(self, seconds: float) -> int:
        """Ticks in so many seconds of robot time; what is less than a tick counts with the next step.

        Raises:
            BadArgument: seconds that are no number, negative, or more than a day.
        """
        dt = number(seconds, "a step")
        if dt < 0.0:
            raise BadArgument(f"a step must not be negative, got {dt:g} s")
        check_duration(dt, "a step")
        self._rest += dt * TICKS_PER_SECOND
        count = math.floor(self._rest + _SHARE)
        self._rest = max(0.0, self._rest - count)
        return count


def ticks_in(seconds: float) -> int:
    """The first tick at or after a time, counted from tick zero."""
    return math.ceil(seconds * TICKS_PER_SECOND - _SHARE)
