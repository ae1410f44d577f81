"""Series of numbers over time that a program plots in the page."""

from __future__ import annotations

import itertools
import secrets
import threading
import time
from collections import deque
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import LARGEST, choice
from nao_kin._core.text import abbreviated
from nao_kin.errors import BadArgument
from nao_kin.viewer.messages import RetainedMessages, named_key, panel_message, typed_array
from nao_kin.viewer.overlays import checked_name, number

MAX_POINTS = 100_000
_MAX_LINES = 64
# Points of a message, and the time between two messages of the same points [s].
_POINTS = 500
_PAUSE = 0.05


class _Stream:
    """The lines of one plot: the points from number `first` on, for one message, and where earlier messages begin."""

    def __init__(self, name: str, lines: tuple[str, ...], run: int) -> None:
        self.name, self.lines, self.run = name, lines, run
        self.first, self.sent = 0, deque[int]()
        self.times: list[float] = []
        self.rows: list[list[float]] = []
        self.last = -np.inf

    def key(self, first: int) -> str:
        return f"{named_key('plot', self.name)} {first:012d}"

    def message(self) -> bytes:
        content = {"name": self.name, "lines": list(self.lines), "run": self.run, "first": self.first}
        numbers = {"times": np.array(self.times), "values": np.array(self.rows).reshape(-1)}
        return panel_message("plot", content | {key: typed_array(array) for key, array in numbers.items()})


class Streams:
    """The plots of a viewer; safe for several threads.

    Points are sent in messages of 500, at most twenty times a second; a timer sends the points that still wait.
    """

    def __init__(self, messages: RetainedMessages) -> None:
        self._messages, self._lock = messages, threading.RLock()
        self._streams: dict[str, _Stream] = {}
        # The numbers let a page that has another program's points distinguish them from these.
        self._runs = itertools.count(secrets.randbelow(1 << 30))
        self._waiting: dict[str, None] = {}
        self._sent = -_PAUSE
        self._timer: threading.Timer | None = None
        self.restart()

    def restart(self) -> None:
        """Count the time of points from now."""
        self._began = time.monotonic()

    def add(self, name: str, value: ArrayLike | Mapping[str, ArrayLike], at: ArrayLike | None) -> dict[str, float]:
        """Add a point to each line of a plot; return the points' values, by line."""
        now = time.monotonic() - self._began if at is None else number(at, "time")
        name = checked_name(name)
        values = _values(name, value)
        with self._lock:
            stream = self._streams.get(name)
            if stream is not None:
                for line in values:
                    choice(line, stream.lines, "line", f"viewer.plot({name!r}, None) removes the plot")
            if stream is None or now < stream.last:
                stream = self._begin(name, tuple(values) if stream is None else stream.lines)
            stream.last = now
            stream.times.append(now)
            stream.rows.append([values.get(line, np.nan) for line in stream.lines])
            self._waiting[name] = None
            if len(stream.times) >= _POINTS:
                self._close(stream)
            self._send_soon()
        return values

    def remove(self, name: str) -> None:
        """Remove a plot."""
        with self._lock:
            del self._streams[choice(name, self._streams, "plot")]
            self._waiting.pop(name, None)
            self._messages.drop(f"{named_key('plot', name)} ")
            self._list()

    def flush(self) -> None:
        """Send all points that wait."""
        with self._lock:
            waiting, self._waiting = self._waiting, {}
            self._sent = time.monotonic()
            for name in waiting:
                stream = self._streams[name]
                if stream.times:
                    self._messages.put(stream.key(stream.first), stream.message())

    def _begin(self, name: str, lines: tuple[str, ...]) -> _Stream:
        """Begin a plot, or begin it anew after its time went back."""
        count = sum(len(stream.lines) for other, stream in self._streams.items() if other != name)
        if count + len(lines) > _MAX_LINES:
            raise BadArgument(f"at most {_MAX_LINES} lines are plotted; remove some plots before {abbreviated(name)}")
        self._messages.drop(f"{named_key('plot', name)} ")
        self._streams[name] = stream = _Stream(name, lines, next(self._runs))
        self._list()
        return stream

    def _close(self, stream: _Stream) -> None:
        """Send the points of a message that is full, and drop the oldest message if there are too many."""
        self._messages.put(stream.key(stream.first), stream.message())
        stream.sent.append(stream.first)
        stream.first += len(stream.times)
        stream.times, stream.rows = [], []
        while stream.first - stream.sent[0] > MAX_POINTS:
            self._messages.drop(stream.key(stream.sent.popleft()))

    def _send_soon(self) -> None:
        wait = self._sent + _PAUSE - time.monotonic()
        if wait <= 0.0:
            self.flush()
        elif self._timer is None:
            self._timer = threading.Timer(wait, self._send_late)
            self._timer.daemon = True
            self._timer.start()

    def _send_late(self) -> None:
        with self._lock:
            self._timer = None
            self.flush()

    def _list(self) -> None:
        """Send the list of plots: a page removes all others, even if it has missed messages."""
        self._messages.put("plots", panel_message("plots", {"names": list(self._streams)}))


def _values(name: str, value: ArrayLike | Mapping[str, ArrayLike]) -> dict[str, float]:
    if isinstance(value, Mapping):
        if not value:
            raise BadArgument(f"plot {abbreviated(name)} has no values")
        found = {checked_name(line): number(single, f"value {line}") for line, single in value.items()}
    else:
        found = {name: number(value, "value")}
    for line, single in found.items():
        if abs(single) > LARGEST:
            raise BadArgument(f"value {abbreviated(line)} is {single:g}; values up to {LARGEST:g} are plotted")
    return found
