"""Images of the robot's cameras that a program shows, as PNG or JPEG."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence
from threading import RLock

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import choice
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.viewer.messages import NamedMessages, RetainedMessages, panel_message, typed_array

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

    def __init__(self, messages: RetainedMessages, lock: RLock, cameras: Sequence[str]) -> None:
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
        kind, data = "image/png", _png(image)
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


def _png(image: NDArray[np.uint8]) -> bytes:
    """Return an array (h, w, 3) or (h, w) as a PNG file, packed fast rather than small."""
    array = np.asarray(image) if isinstance(image, (np.ndarray, list, tuple)) else None
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
