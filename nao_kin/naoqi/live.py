"""The joints of a running robot, read repeatedly over qi or LoLA; nothing is ever commanded."""

from __future__ import annotations

import math
import socket
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np
import umsgpack
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, as_floats, shaped
from nao_kin._core.text import one_line_repr, quoted
from nao_kin.errors import BadArgument, NaoKinError, NotFinite
from nao_kin.motion import Motion
from nao_kin.naoqi._qi import load_qi
from nao_kin.naoqi.conventions import from_order
from nao_kin.robot import RobotModel
from nao_kin.rotations import matrix_from_rpy

# --- LoLA, the RoboCup interface of the NAO6: frames of sensors, MessagePack maps over a Unix socket.
#
# A robot sends a frame every 12 ms to a client of its socket /tmp/robocup. This module decodes and encodes frames, and
# sends nothing to a robot. Joints are in the order `BODY_ORDERS["LoLA"]`.
#
# Sources: names and lengths of a frame's entries as teams publish them (UNSWComputing/rUNSWift-2023-release,
# IntelligentRoboticsLab/nidhogg, ros-sports/nao_lola).

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
# Keywords of `StateEstimator.update` and their entries. The eight FSR are in the order of the robot's `force_sensors`.
_STATE_ENTRIES = {"forces": "FSR", "angles": "Angles", "gyro": "Gyroscope"}
# BodyId, BodyVersion, HeadId, HeadVersion.
_CONFIG, _CONFIG_LENGTH = "RobotConfig", 4
# The length of the longest frame; a map that claims to be longer is not a frame, and is not read to its end.
_MAX_BYTES = 65536
_UNREADABLE = (umsgpack.UnpackException, RecursionError, MemoryError, ValueError, TypeError)

LolaFrame = dict[str, "Floats | tuple[str, ...]"]


def decode_lola(content: bytes) -> LolaFrame:
    """Return the entries of a frame.

    Args:
        content: one MessagePack map.

    Returns:
        Name → numbers, shape (n,) with the n of `LOLA_ENTRIES`; "RobotConfig" → four strings. Missing entries are left
            out; only "Position" is required.

    Raises:
        BadArgument: the content is not such a map, or an entry has another length.

    Examples:
        >>> frame = {name: np.zeros(n) for name, n in nk.naoqi.LOLA_ENTRIES.items()}
        >>> frame["Battery"][0] = 0.5
        >>> nk.naoqi.decode_lola(nk.naoqi.encode_lola(frame))["Battery"].tolist()
        [0.5, 0.0, 0.0, 0.0]
    """
    try:
        frame = umsgpack.unpackb(content)
    except _UNREADABLE as error:
        raise BadArgument(f"a LoLA frame must be a MessagePack map, not these {len(content)} bytes: {error}") from None
    return _checked(frame)


def encode_lola(frame: Mapping[str, ArrayLike | tuple[str, ...]]) -> bytes:
    """Return the bytes of a frame, numbers as floats of 32 bits as a robot sends them; "Status" as whole numbers.

    Args:
        frame: entries as `decode_lola` returns them.

    Examples:
        >>> frame = {name: np.zeros(n) for name, n in nk.naoqi.LOLA_ENTRIES.items()}
        >>> len(nk.naoqi.encode_lola(frame)) > 500
        True
    """
    document: dict[str, object] = {}
    for name, values in _checked(dict(frame)).items():
        document[name] = [int(value) for value in values] if name == "Status" else np.asarray(values).tolist()
    return bytes(umsgpack.packb(document, force_float_precision="single"))


class _Readable(Protocol):
    def read(self, count: int, /) -> bytes: ...


def lola_frames(stream: _Readable) -> Iterator[LolaFrame]:
    """Yield the frames of a stream of bytes until it ends; an incomplete last frame is dropped.

    Args:
        stream: its `read(count)` returns bytes, b"" only at the end.

    Raises:
        BadArgument: as `decode_lola`.

    Examples:
        >>> import io
        >>> frame = {name: np.zeros(n) for name, n in nk.naoqi.LOLA_ENTRIES.items()}
        >>> content = nk.naoqi.encode_lola(frame)
        >>> len(list(nk.naoqi.lola_frames(io.BytesIO(content * 3))))
        3
    """
    while True:
        try:
            frame = umsgpack.unpack(_Bounded(stream))
        except (umsgpack.InsufficientDataException, OSError):
            return
        except _UNREADABLE as error:
            raise BadArgument(f"a LoLA frame must be a MessagePack map: {error}") from None
        yield _checked(frame)


class _Bounded:
    """A stream that refuses to read more bytes than a frame can have."""

    def __init__(self, stream: _Readable) -> None:
        self._stream, self._left = stream, _MAX_BYTES

    def read(self, count: int) -> bytes:
        self._left -= count
        if self._left < 0:
            raise ValueError(f"more than {_MAX_BYTES} bytes")
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
    entries: LolaFrame = {}
    for name, values in frame.items():
        if name == _CONFIG:
            texts = values if isinstance(values, (list, tuple)) else ()
            if len(texts) != _CONFIG_LENGTH or not all(isinstance(text, str) for text in texts):
                raise BadArgument(f"a LoLA frame's {_CONFIG} must be {_CONFIG_LENGTH} texts, got {quoted(values)}")
            entries[name] = tuple(texts)
        elif name in LOLA_ENTRIES:
            entries[name] = _numbers(name, values)
    return entries


def _numbers(name: str, values: object) -> Floats:
    """Return the numbers of an entry: a broken sensor must not hide the joints; positions may be NaN, not infinite."""
    count, what = LOLA_ENTRIES[name], f"a LoLA frame's {name}"
    if name == "Position":
        return np.array(as_floats(np.asarray(values, dtype=object).tolist(), (count,), what, gaps=True))
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        array = np.zeros(0)
    if array.shape != (count,):
        raise BadArgument(f"{what} must be {count} numbers, got {quoted(values)}")
    return array


# --- The joints of a running robot, read repeatedly over qi or LoLA.

PORT = 9559
_KEY = "Device/SubDeviceList/{}/Sensor/Value"
_ANGLES, _GYRO = (
    [_KEY.format(f"InertialSensor/{name}{axis}") for axis in axes]
    for name, axes in (("Angle", "XY"), ("Gyroscope", "XYZ"))
)
# The time after which a robot that does not answer counts as lost [s].
_PATIENCE = 3.0
# The interval at which a waiting source checks whether it is still wanted.
_SLICE_MILLISECONDS = 50
# The pauses between attempts to connect [s].
_FIRST_PAUSE, _LONGEST_PAUSE = 0.2, 2.0


@one_line_repr
@dataclass(frozen=True)
class JointReading:
    """The sensors' values at one moment.

    Attributes:
        time: since the first reading [s].
        q: configuration, shape (nq,); if the two hips disagree, LHipYawPitch is used.
        up: the vertical in the torso's frame, shape (3,), from the robot's inertial sensor; None without one.
        sensors: forces, angles and gyro, as far as the source has them, as `StateEstimator.update` of
            `nk.world` takes them.
    """

    time: float
    q: Floats
    up: Floats | None
    sensors: Mapping[str, Floats] = field(default_factory=dict)


class Lost(NaoKinError):
    """The robot does not answer."""


class JointSource(ABC):
    """A source of readings.

    Attributes:
        address: the robot's address, for messages.
        wanted: called while the source waits; returns whether to continue.
        missing: values of joints that are NaN, as in `from_order`.
        sensors: those of the last reading, as `JointReading.sensors`.

    Examples:
        >>> issubclass(nk.naoqi.LolaSource, nk.naoqi.JointSource)
        True
    """

    address: str
    wanted: Callable[[], bool] = staticmethod(lambda: True)
    missing: str | float | None = None
    sensors: Mapping[str, Floats] = MappingProxyType({})

    @abstractmethod
    def connect(self) -> None:
        """Connect to the robot.

        Raises:
            Lost: the robot does not answer.
        """

    @abstractmethod
    def read(self, robot: RobotModel) -> tuple[Floats, Floats | None]:
        """Return the current configuration and vertical.

        Raises:
            Lost: the robot no longer answers.
        """

    @abstractmethod
    def close(self) -> None:
        """Close the connection."""


class NaoqiSource(JointSource):
    """A robot or a virtual NAO, read over NAOqi's own protocol: its joints, and its inertial and force sensors.

    Args:
        address: "tcp://nao.local:9559", or "nao.local" with every robot's default port.

    Raises:
        MissingExtra: qi is not installed.
        BadArgument: an invalid address.
    """

    def __init__(self, address: str) -> None:
        self.address = _endpoint(address)
        self._qi = load_qi("reading a robot's joints over NAOqi")
        self._qi.logging.setLevel(self._qi.logging.FATAL)
        self._session: Any = None
        self._alive = {"angles"}

    def connect(self) -> None:
        """Connect to the robot."""
        session = self._qi.Session()
        self._answer(session.connect(self.address, _async=True))
        self._motion = self._answer(session.service("ALMotion", _async=True))
        self._session = session
        try:
            self._memory = self._answer(session.service("ALMemory", _async=True))
            self._answer(self._memory.getListData(_ANGLES, _async=True))
        except Lost:
            self._memory = None

    def read(self, robot: RobotModel) -> tuple[Floats, Floats | None]:
        """Return the current configuration and vertical."""
        body = self._answer(self._motion.getAngles("Body", True, _async=True))
        names = "H25" if len(body) == 26 else "H21"
        up = None
        if self._memory is not None:
            forces = [_KEY.format(name) for name in robot.semantics.force_sensors]
            keys = {"angles": _ANGLES, "gyro": _GYRO, "forces": forces}
            values = iter(self._answer(self._memory.getListData([*_ANGLES, *_GYRO, *forces], _async=True)))
            rows = {name: [next(values) for _ in own] for name, own in keys.items()}
            known = {name: row for name, row in rows.items() if all(isinstance(v, (int, float)) for v in row)}
            # Sensors that are always exactly zero are those of a virtual robot.
            self._alive |= {name for name, row in known.items() if any(row)}
            self.sensors = {name: np.array(row, dtype=float) for name, row in known.items() if name in self._alive}
            if "angles" in known:
                up = vertical(*map(float, known["angles"]))
        return _configuration(robot, body, names, self.missing), up

    def close(self) -> None:
        """Close the connection."""
        session, self._session = self._session, None
        if session is not None:
            session.close(_async=True)

    def _answer(self, future: Any) -> Any:
        """Return the answer of a call, or raise `Lost`."""
        end = time.monotonic() + _PATIENCE
        try:
            while future.isRunning():
                if not self.wanted() or time.monotonic() > end:
                    future.cancel()
                    raise Lost(f"{self.address} gives no answer within {_PATIENCE:g} s")
                future.wait(_SLICE_MILLISECONDS)
            return future.value()
        except RuntimeError as error:
            raise Lost(f"{self.address}: {' '.join(str(error).split())}") from None


class LolaSource(JointSource):
    """A NAO6, read over its RoboCup interface, a Unix socket `path` to which it writes frames.

    Examples:
        >>> nk.naoqi.LolaSource("/tmp/robocup").address
        '/tmp/robocup'
    """

    def __init__(self, path: Path | str = LOLA_SOCKET) -> None:
        self.address = str(path)
        self._socket: socket.socket | None = None
        self._frames: Iterator[LolaFrame] = iter(())

    def connect(self) -> None:
        """Connect to the robot.

        Examples:
            >>> nk.naoqi.LolaSource("/no/such/socket").connect()
            Traceback (most recent call last):
                ...
            nao_kin.naoqi.live.Lost: /no/such/socket: No such file or directory
        """
        connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        connection.settimeout(_SLICE_MILLISECONDS / 1000.0)
        try:
            connection.connect(self.address)
        except OSError as error:
            connection.close()
            raise Lost(f"{self.address}: {error.strerror or error}") from None
        self._socket = connection
        self._frames = lola_frames(_Received(connection, self))

    def read(self, robot: RobotModel) -> tuple[Floats, Floats | None]:
        """Return configuration and vertical of the next frame."""
        try:
            frame = next(self._frames, None)
        except NaoKinError as error:
            raise Lost(f"{self.address}: {error}") from None
        if frame is None:
            raise Lost(f"{self.address} sends no more frames")
        entries = ((name, frame.get(entry)) for name, entry in _STATE_ENTRIES.items())
        self.sensors = {name: values for name, values in entries if isinstance(values, np.ndarray)}
        angles = frame.get("Angles")
        known = isinstance(angles, np.ndarray) and bool(np.isfinite(angles).all())
        up = vertical(float(angles[0]), float(angles[1])) if known and angles is not None else None
        return _configuration(robot, frame["Position"], "LoLA", self.missing), up

    def close(self) -> None:
        """Close the connection."""
        connection, self._socket = self._socket, None
        if connection is not None:
            connection.close()


class _Received:
    """A robot's frames from a socket, as a stream that waits while the source is wanted."""

    def __init__(self, connection: socket.socket, source: JointSource) -> None:
        self._connection, self._source = connection, source

    def read(self, count: int) -> bytes:
        """Return at most `count` bytes; none at the end."""
        end = time.monotonic() + _PATIENCE
        while True:
            try:
                return self._connection.recv(count)
            except TimeoutError:
                if not self._source.wanted() or time.monotonic() > end:
                    raise Lost(f"{self._source.address} sends nothing for {_PATIENCE:g} s") from None
            except OSError as error:
                raise Lost(f"{self._source.address}: {error.strerror or error}") from None


def readings(
    source: JointSource,
    robot: RobotModel,
    *,
    rate: float = 25.0,
    wanted: Callable[[], bool] = lambda: True,
    on_state: Callable[[str], object] | None = None,
    missing: str | float | None = None,
) -> Iterator[JointReading]:
    """Read a robot's joints repeatedly; a lost connection is reestablished.

    Args:
        source: the source of the readings.
        robot: a NAO of the robot's version.
        rate: the largest number of readings per second.
        wanted: called repeatedly; returns whether to continue.
        on_state: receives a line whenever the robot is connected or lost.
        missing: values of joints whose sensors give none (NaN), such as hands: those of a posture, or a number.

    Yields:
        Readings with ascending times.
    """
    if not 0.0 < rate < math.inf:
        raise BadArgument(f"rate must be a positive number, got {quoted(rate)}")
    report = on_state or (lambda line: None)
    if missing is not None:
        robot.configuration({}, missing=missing)  # refuse it now, not as a robot that is lost
    source.wanted, source.missing = wanted, missing
    start: float | None = None
    last = -math.inf
    pause, silent = _FIRST_PAUSE, False
    try:
        while wanted():
            try:
                source.connect()
                report(f"connected to {source.address}")
                pause, silent = _FIRST_PAUSE, False
                while wanted():
                    q, up = source.read(robot)
                    now = time.monotonic()
                    # LoLA has a rate of its own; frames between two readings are read and dropped.
                    if now - last < 1.0 / rate and isinstance(source, LolaSource):
                        continue
                    start = now if start is None else start
                    last = now
                    yield JointReading(now - start, q, up, source.sensors)
                    if not isinstance(source, LolaSource):
                        _sleep(last + 1.0 / rate, wanted)
            except Lost as error:
                source.close()
                if not silent:
                    report(f"{error}; trying again")
                silent = True
                _sleep(time.monotonic() + pause, wanted)
                pause = min(2.0 * pause, _LONGEST_PAUSE)
    finally:
        source.close()


def recorded(found: Iterable[JointReading], robot: RobotModel) -> Motion:
    """Return readings as a motion from time zero, with linear interpolation.

    Raises:
        BadArgument: there are no readings.

    Examples:
        >>> found = [nk.naoqi.JointReading(0.04 * k, np.zeros(25), None) for k in range(3)]
        >>> nk.naoqi.recorded(found, nk.load_nao()).end
        0.08
    """
    rows = list(found)
    if not rows:
        raise BadArgument("a motion needs at least one reading: there are no readings")
    times = np.array([row.time for row in rows])
    values = np.array([row.q[robot.nq_base :] for row in rows])
    return Motion(times - times[0], robot.joint_names, values)


def vertical(roll: float, pitch: float) -> Floats:
    """Return the vertical in the torso's frame, shape (3,), from the angles of a NAO's inertial sensor.

    With the torso's rotation R = Ry(pitch) Rx(roll), the vertical is Rᵀ (0, 0, 1).

    Examples:
        >>> nk.naoqi.vertical(roll=0.0, pitch=0.5).round(3).tolist()
        [-0.479, 0.0, 0.878]
    """
    angles = shaped([roll, pitch], (2,), "roll and pitch")
    return np.array(matrix_from_rpy(np.append(angles, 0.0))[2])


def _configuration(
    robot: RobotModel, values: Sequence[float] | Floats | Any, order: str, missing: str | float | None
) -> Floats:
    try:
        return from_order(robot, values, order, hips="left", missing=missing)
    except NotFinite as error:
        advice = "missing= (--missing) gives them values"
        raise Lost(f"the robot has no values of some joints: {error}; {advice}") from None
    except NaoKinError as error:
        raise Lost(f"the robot's joint values are wrong: {error}") from None


def _sleep(until: float, wanted: Callable[[], bool]) -> None:
    while wanted():
        rest = until - time.monotonic()
        if rest <= 0.0:
            return
        time.sleep(min(rest, 0.05))


def _endpoint(address: str) -> str:
    """Return tcp://HOST:PORT for an address that may lack the scheme or the port."""
    scheme, _, rest = address.rpartition("://")
    host, separator, port = rest.rpartition(":")
    if not separator or "]" in port:  # no port, or the colons of an IPv6 address
        host, port = rest, str(PORT)
    if scheme not in ("", "tcp", "tcps") or not host or not port.isdecimal() or not 0 < int(port) < 65536:
        raise BadArgument(f"address must be like tcp://nao.local:{PORT}, got {quoted(address)}")
    return f"{scheme or 'tcp'}://{host}:{port}"
