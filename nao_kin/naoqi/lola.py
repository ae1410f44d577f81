"""LoLA, the RoboCup interface of the NAO6: frames of sensors, MessagePack maps over a Unix socket.

A robot sends a frame every 12 ms to whoever connects to its socket /tmp/robocup. Here frames are decoded and encoded,
and nothing is ever sent to a robot. Joints are in the order `BODY_ORDERS["LoLA"]`.

Sources: names and lengths of a frame's entries as teams publish them (UNSWComputing/rUNSWift-2023-release,
IntelligentRoboticsLab/nidhogg, ros-sports/nao_lola).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Protocol

import numpy as np
import umsgpack
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats, as_floats
from nao_kin._text import quoted
from nao_kin.errors import BadArgument

LOLA_SOCKET = "/tmp/robocup"
_JOINTS = 25
# Numbers in each entry of a frame.
LOLA_ENTRIES: dict[str, int] = {
    "Position": _JOINTS,
    "Stiffness": _JOINTS,
    "Temperature": _JOINTS,
    "Current": _JOINTS,
    "Status": _JOINTS,
    "Battery": 4,
    "Accelerometer": 3,
    "Gyroscope": 3,
    "Angles": 2,
    "Sonar": 2,
    "FSR": 8,
    "Touch": 14,
}
# BodyId, BodyVersion, HeadId, HeadVersion.
_CONFIG, _CONFIG_LENGTH = "RobotConfig", 4
# No entry of a frame is longer: what claims to be is no frame, and is not read to its end.
_MOST_BYTES = 65536

LolaFrame = dict[str, "Floats | tuple[str, ...]"]


def decode_lola(content: bytes) -> LolaFrame:
    """The entries of one frame.

    Args:
        content: one MessagePack map.

    Returns:
        Name → numbers, shape (n,) with the n of `LOLA_ENTRIES`; "RobotConfig" → four texts. Entries that are not there
        are left out, but "Position" must be.

    Raises:
        BadArgument: no such map, or an entry of another length.
        NotFinite: a position that is no number.

    Examples:
        >>> frame = {name: np.zeros(n) for name, n in nk.naoqi.LOLA_ENTRIES.items()}
        >>> frame["Battery"][0] = 0.5
        >>> nk.naoqi.decode_lola(nk.naoqi.encode_lola(frame))["Battery"].tolist()
        [0.5, 0.0, 0.0, 0.0]
    """
    if not isinstance(content, bytes | bytearray | memoryview):
        raise BadArgument(f"a LoLA frame must be bytes, got {type(content).__name__}")
    try:
        frame = umsgpack.unpackb(content)
    except (umsgpack.UnpackException, RecursionError, MemoryError, ValueError, TypeError) as error:
        raise BadArgument(
            f"a LoLA frame must be a MessagePack map, got {len(content)} bytes of none: {error}"
        ) from None
    return _checked(frame)


def encode_lola(frame: Mapping[str, ArrayLike | tuple[str, ...]]) -> bytes:
    """The bytes of a frame, numbers as floats of 32 bits as a robot sends them; "Status" as whole numbers.

    Args:
        frame: as `decode_lola` gives it.

    Raises:
        BadArgument, WrongShape, NotFinite: entries that no frame has, or of another length.

    Examples:
        >>> frame = {name: np.zeros(n) for name, n in nk.naoqi.LOLA_ENTRIES.items()}
        >>> len(nk.naoqi.encode_lola(frame)) > 500
        True
    """
    if not isinstance(frame, Mapping):
        raise BadArgument(f"a frame must be a mapping, got {type(frame).__name__}")
    checked = _checked(dict(frame))
    document: dict[str, object] = {}
    for name, values in checked.items():
        if isinstance(values, tuple):
            document[name] = list(values)
        else:
            document[name] = [int(value) for value in values] if name == "Status" else values.tolist()
    return bytes(umsgpack.packb(document, force_float_precision="single"))


class _Readable(Protocol):
    def read(self, count: int, /) -> bytes: ...


def lola_frames(stream: _Readable) -> Iterator[LolaFrame]:
    """The frames that a stream of bytes holds, one after the other, until it ends.

    Args:
        stream: `read(count)` gives bytes, none at the end; fewer than asked for while there are more is no end.

    Raises:
        BadArgument, NotFinite: as `decode_lola`, or no stream; an end in the middle of a frame is one like any other.

    Examples:
        >>> import io
        >>> frame = {name: np.zeros(n) for name, n in nk.naoqi.LOLA_ENTRIES.items()}
        >>> content = nk.naoqi.encode_lola(frame)
        >>> len(list(nk.naoqi.lola_frames(io.BytesIO(content * 3))))
        3
    """
    if not callable(getattr(stream, "read", None)):
        raise BadArgument(f"stream must have a method read, got {quoted(stream)}")
    while True:
        try:
            frame = umsgpack.unpack(_Bounded(stream))
        except (umsgpack.InsufficientDataException, OSError):
            return
        except (umsgpack.UnpackException, RecursionError, MemoryError, ValueError, TypeError) as error:
            raise BadArgument(f"a LoLA frame must be a MessagePack map: {error}") from None
        yield _checked(frame)


class _Bounded:
    """A stream of which one frame takes no more bytes than a frame has."""

    def __init__(self, stream: _Readable) -> None:
        self._stream, self._left = stream, _MOST_BYTES

    def read(self, count: int) -> bytes:
        self._left -= count
        if self._left < 0:
            raise ValueError(f"more than {_MOST_BYTES} bytes")
        parts = []
        while count > 0:
            part = self._stream.read(count)
            if not part:
                break
            parts.append(part)
            count -= len(part)
        return b"".join(parts)


def _checked(frame: object) -> LolaFrame:
    if not isinstance(frame, dict):
        raise BadArgument(f"a LoLA frame must be a MessagePack map, got {type(frame).__name__}")
    if "Position" not in frame:
        raise BadArgument(f"a LoLA frame must have the entry Position, got {quoted(', '.join(map(str, frame)))}")
    found: LolaFrame = {}
    for name, values in frame.items():
        if name == _CONFIG:
            texts = values if isinstance(values, (list, tuple)) else ()
            if len(texts) != _CONFIG_LENGTH or not all(isinstance(text, str) for text in texts):
                raise BadArgument(f"a LoLA frame's {_CONFIG} must be {_CONFIG_LENGTH} texts, got {quoted(values)}")
            found[name] = tuple(texts)
        elif name in LOLA_ENTRIES:
            found[name] = _numbers(name, values)
    return found


def _numbers(name: str, values: object) -> Floats:
    """The numbers of an entry; only positions must all be numbers, for a broken sensor is no reason to show nothing."""
    count = LOLA_ENTRIES[name]
    if name == "Position":
        return np.array(as_floats(np.asarray(values, dtype=object).tolist(), (count,), f"a LoLA frame's {name}"))
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.zeros(0)
    if array.shape != (count,):
        raise BadArgument(f"a LoLA frame's {name} must be {count} numbers, got {quoted(values)}")
    return array
