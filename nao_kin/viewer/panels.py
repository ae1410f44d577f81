"""What a program shows in panels of the page: controls, series of numbers over time, and images of cameras."""

from __future__ import annotations

import itertools
import secrets
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
import umsgpack
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, choice
from nao_kin._core.files import png
from nao_kin._core.text import abbreviated, quoted
from nao_kin.errors import BadArgument, NaoKinError
from nao_kin.viewer.messages import RetainedMessages, named_key, packed, panel_message, typed_array
from nao_kin.viewer.overlays import checked_name, number
from nao_kin.viewer.shown_scene import Listed, Listing

MAX_POINTS = 100_000
# Title of the plot of margins.
_MARGINS = "Balance"
# Points of a message, and the time between two messages of the same points [s].
_POINTS = 500
_PAUSE = 0.05


class _Stream:
    """The lines of one plot: the points from number `first` on, for one message, and where earlier messages begin."""

    def __init__(self, name: str, lines: tuple[str, ...], run: int) -> None:
        self.name, self.lines, self.run, self.margins = name, lines, run, False
        self.first, self.sent = 0, deque[int]()
        self.times: list[float] = []
        self.rows: list[list[float]] = []
        self.last = -np.inf

    def key(self, first: int) -> str:
        return f"{named_key('plot', self.name)} {first:012d}"

    def message(self) -> bytes:
        content = {"name": self.name, "lines": list(self.lines), "run": self.run, "first": self.first}
        content |= {"margins": self.margins}
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
        self._first_run = secrets.randbelow(1 << 30)
        self._runs = itertools.count(self._first_run)
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

    def show_margins(self, margins: tuple[Floats, Mapping[str, Floats]] | None) -> None:
        """Plot times [s] and margins of the clip [mm], which a page shows with it; None removes them."""
        with self._lock:
            for name in [name for name, stream in self._streams.items() if stream.margins]:
                self.remove(name)
            if margins is not None:
                times, lines = margins
                stream = self._begin(_MARGINS, tuple(lines))
                stream.margins, stream.times = True, times.tolist()
                stream.rows = np.column_stack(list(lines.values())).tolist()
                self._close(stream)

    def saved(self) -> list[bytes]:
        """Return all messages for a file, in which plots have the same numbers whatever program writes it."""
        self.flush()
        found = {key: self._messages.get(key) for key in self._messages.names()}
        for key in [key for key, message in found.items() if message and key.startswith("plot ")]:
            content = umsgpack.unpackb(found[key])
            found[key] = packed({**content, "run": content["run"] - self._first_run})
        return [message for message in found.values() if message is not None]

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
        return {checked_name(line): number(single, f"value {line}") for line, single in value.items()}
    return {name: number(value, "value")}


# --- Images of the robot's cameras, as PNG or JPEG.

Image = NDArray[np.uint8] | bytes

# The first bytes of a file → its type.
_TYPES = {b"\x89PNG\r\n\x1a\n": "image/png", b"\xff\xd8": "image/jpeg"}


def image_message(camera: str, image: Image) -> bytes:
    """Return the message that shows an image in place of a camera's drawn view."""
    data = bytes(image) if isinstance(image, (bytes, bytearray)) else png(image)
    kind = next((kind for begin, kind in _TYPES.items() if data.startswith(begin)), None)
    if kind is None:
        raise BadArgument(f"image must be an array, or the bytes of a PNG or JPEG file, got {quoted(data[:16])}")
    content = {"camera": camera, "format": kind, "data": typed_array(np.frombuffer(data, np.uint8))}
    return panel_message("image", content)


# --- Controls: a program's own buttons, sliders, selects and texts.

# Presses of a button that wait for a slow callback; further ones are counted, but cause no call.
_MAX_WAITING = 16

Value = float | int | str


class Control(Listed):
    """A button, slider, select or text in the panel of the page, made by `Viewer.add_button` and the like.

    Attributes:
        name: its name in the page.

    Examples:
        >>> viewer = nk.Viewer(nk.load_nao())
        >>> speed = viewer.add_slider("speed", 0.0, 2.0, 1.0, unit="m/s")
        >>> speed
        <Control speed: 1.0>
    """

    def __init__(
        self,
        name: str,
        row: Mapping[str, Any],
        value: Value,
        checked: Callable[[Any], Value],
        callback: Callable[..., object] | None,
        controls: Controls,
    ) -> None:
        super().__init__(name, value, controls)
        self._row, self._checked, self._callback = row, checked, callback

    @property
    def value(self) -> Any:
        """The current value: the number of a slider, the option of a select, a text, or how often a button was pressed.

        Setting it changes it in all pages, and does not call `on_change`. That of a button cannot be set.

        Raises:
            BadArgument: the new value is outside the slider's range or no text, or the control was removed or replaced.
            UnknownName: the new value is not an option.

        Examples:
            >>> speed = nk.Viewer(nk.load_nao()).add_slider("speed", 0.0, 2.0)
            >>> speed.value = 1.5
            >>> speed.value
            1.5
        """
        return self._value

    @value.setter
    def value(self, value: Value) -> None:
        if self._row["kind"] == "button":
            raise BadArgument(f"{abbreviated(self.name)} is a button: its value counts its presses and cannot be set")
        self._listing.set(self, self._checked(value), self._listing.source())

    def remove(self) -> None:
        """Remove the control from the page; does nothing the second time.

        Examples:
            >>> nk.Viewer(nk.load_nao()).add_button("go").remove()
        """
        self._listing.remove(self)

    def __repr__(self) -> str:
        return f"<Control {self.name}{f': {self._value}' if self._listing.has(self) else ', removed'}>"


class Controls(Listing[Control]):
    """The controls of a viewer, by name, in the order in which they were added."""

    def add(
        self,
        name: str,
        row: Mapping[str, Any],
        value: Value,
        checked: Callable[[Any], Value],
        callback: Callable[..., object] | None,
    ) -> Control:
        """Add a control, instead of the one of the same name; `checked` returns a value that it can have, or raises."""
        return self.put(Control(name, row, checked(value), checked, callback, self))

    def receive(self, name: object, value: object, source: str) -> None:
        """Take a value that a user set in a page, and call the function of the control; other values are ignored."""
        control = self.named(name)
        if control is None or (control._row.get("edited") is False):
            return
        with self._lock:
            try:
                pressed = control._row["kind"] == "button"
                self.set(control, control._value + 1 if pressed else control._checked(value), source)
            except NaoKinError:
                return
        if control._callback is not None:
            what = f"{'on_click' if pressed else 'on_change'} of {control.name}"
            key = (control, control._value % _MAX_WAITING) if pressed else control
            self._changes.call(key, partial(self._tell, control, pressed), what)

    def _tell(self, control: Control, pressed: bool) -> None:
        if self.has(control) and control._callback is not None:
            control._callback(*(() if pressed else (control.value,)))

    def _rows(self) -> list[dict[str, Any]]:
        return [
            {"name": control.name, "value": control._value, "source": control._source, **control._row}
            for control in self._items.values()
        ]


def in_range(ends: tuple[float, float], value: float) -> float:
    """Return the value of a slider."""
    found = number(value, "value")
    if not ends[0] <= found <= ends[1]:
        raise BadArgument(f"value must be from {ends[0]:g} to {ends[1]:g}, got {found:g}")
    return found


def text(value: str) -> str:
    """Return a text that pages can show; it may come from one."""
    if not isinstance(value, str):
        raise BadArgument(f"a text is needed, got {quoted(value, 60)}")
    packed(value)  # refuses texts that cannot be sent
    return value
