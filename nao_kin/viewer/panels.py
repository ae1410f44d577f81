"""What a program shows in panels of the page: series of numbers over time, and images of the robot's cameras."""

from __future__ import annotations

import itertools
import secrets
import struct
import threading
import time
import zlib
from collections import deque
from collections.abc import Mapping, Sequence

import numpy as np
import umsgpack
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import LARGEST, Floats, choice
from nao_kin._core.text import abbreviated, quoted
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.viewer.messages import NamedMessages, RetainedMessages, named_key, packed, panel_message, typed_array
from nao_kin.viewer.overlays import checked_name, number

MAX_POINTS = 100_000
_MAX_LINES = 64
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


# --- Images of the robot's cameras, as PNG or JPEG.

Image = NDArray[np.uint8] | bytes

_MAX_PIXELS = 16_000_000
_MAX_BYTES = 64_000_000
_PNG = b"\x89PNG\r\n\x1a\n"
_JPEG = b"\xff\xd8"
# Markers of JPEG without a length: fill bytes, restarts, start of the image.
_BARE = (0x01, *range(0xD0, 0xD9))
_NO_FRAME = (0xC4, 0xC8, 0xCC)


class Images:
    """The images of a viewer, one for each camera of the robot at most."""

    def __init__(self, messages: RetainedMessages, lock: threading.RLock, cameras: Sequence[str]) -> None:
        self._lock, self._cameras = lock, cameras
        self._shown = NamedMessages(messages, "image", "images", "cameras")

    def show(self, camera: str, image: Image | None) -> bool:
        """Show an image in place of a camera's drawn view, None to remove it; return whether it is the first one."""
        name = choice(camera, self._cameras, "camera")
        message = None if image is None else _message(name, image)
        with self._lock:
            is_new = message is not None and name not in self._shown.names
            if message is None:
                self._shown.drop(name)
            else:
                self._shown.put(name, message)
        return is_new


def _message(camera: str, image: Image) -> bytes:
    if isinstance(image, (bytes, bytearray)):
        kind, data = _checked_file(bytes(image)), bytes(image)
    else:
        kind, data = "image/png", png_file(image)
    content = {"camera": camera, "format": kind, "data": typed_array(np.frombuffer(data, np.uint8))}
    return panel_message("image", content)


def _check_size(width: int, height: int) -> None:
    if width == 0 or height == 0:
        raise BadArgument("image is empty")
    if width * height > _MAX_PIXELS:
        raise BadArgument(f"image has {width} × {height} pixels; at most {_MAX_PIXELS / 1e6:g} megapixels are shown")


def _checked_file(data: bytes) -> str:
    """Return the type of a PNG or JPEG file; refuse other contents and large images, by the size in the header."""
    if len(data) > _MAX_BYTES:
        raise BadArgument(f"image has {len(data) / 1e6:.0f} MB; at most {_MAX_BYTES / 1e6:g} MB are shown")
    if data.startswith(_PNG) and data[12:16] == b"IHDR" and len(data) >= 24:
        _check_size(*struct.unpack(">II", data[16:24]))
        return "image/png"
    size = _jpeg_size(data) if data.startswith(_JPEG) else None
    if size is None:
        raise BadArgument(f"image must be an array, or the bytes of a PNG or JPEG file, got {quoted(data[:16])}")
    _check_size(*size)
    return "image/jpeg"


def _jpeg_size(data: bytes) -> tuple[int, int] | None:
    """Return width and height from the frame header of a JPEG file; None if there is none. Source: ITU-T T.81, B.2."""
    at = 2
    while at + 9 <= len(data) and data[at] == 0xFF:
        marker = data[at + 1]
        if marker == 0xFF or marker in _BARE:
            at += 1 if marker == 0xFF else 2
        elif 0xC0 <= marker <= 0xCF and marker not in _NO_FRAME:
            height, width = struct.unpack(">HH", data[at + 5 : at + 9])
            return width, height
        else:
            at += 2 + int(struct.unpack(">H", data[at + 2 : at + 4])[0])
    return None


def png_file(image: NDArray[np.uint8]) -> bytes:
    """Return an array (h, w, 3) or (h, w) as a PNG file, packed fast rather than small."""
    try:
        array = np.asarray(image) if isinstance(image, (np.ndarray, list, tuple)) else None
    except ValueError:  # rows of different lengths
        array = None
    if array is None or array.dtype.kind not in "uifb":
        raise BadArgument(f"image must be an array, or the bytes of a PNG or JPEG file, got {quoted(image, 60)}")
    if not (array.ndim == 2 or (array.ndim == 3 and array.shape[2] == 3)):
        raise WrongShape("image", "(h, w, 3) or (h, w)", array.shape)
    if array.dtype != np.uint8:
        raise BadArgument(f"image must have the type uint8, values from 0 to 255, got {array.dtype}")
    height, width = array.shape[:2]
    _check_size(width, height)
    rows = np.zeros((height, 1 + array[0].size), np.uint8)  # each row begins with its filter, 0 for none
    rows[:, 1:] = array.reshape(height, -1)
    header = struct.pack(">IIBBBBB", width, height, 8, 0 if array.ndim == 2 else 2, 0, 0, 0)
    return _PNG + _chunk(b"IHDR", header) + _chunk(b"IDAT", zlib.compress(rows.tobytes(), 1)) + _chunk(b"IEND", b"")


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
