"""The semantics of a robot: mimic joints, coupled limits, chains, effectors, postures and the like, by name.

They may be written in a small TOML file beside the URDF:

.. code-block:: toml

    end_effectors = ["l_hand", "r_hand"]
    soles = ["l_sole", "r_sole"]
    cameras = ["camera"]
    accelerometers = ["imu"]
    gyrometers = ["imu"]
    force_sensors = ["l_sole", "r_sole"]
    start = "stand"
    root = "pelvis"

    [chains]
    left_arm = ["l_shoulder", "l_elbow"]

    [postures.stand]
    angles = { l_elbow = -0.4 }          # rad, m or ratio; joints not named are at zero

    [postures.lie]
    angles = { l_elbow = -0.1 }
    up = [1.0, 0.0, 0.0]                 # if it does not stand on its soles

    [[coupled_limits]]
    joint = "head_pitch"
    of = "head_yaw"
    at = [-1.0, 0.0, 1.0]
    lower = [-0.2, -0.5, -0.2]
    upper = [0.2, 0.5, 0.2]

    [units]
    l_gripper = "1"

    [fields_of_view]
    camera = [0.98, 0.76]                # horizontal and vertical [rad]

    [resolutions]
    HD = [1280, 720]                     # width and height of an image [pixel]

    [outlines]
    l_sole = [[0.1, 0.04], [-0.05, 0.04], [-0.05, -0.04], [0.1, -0.04]]  # corners: x, y, z if not 0 [m]

    [ros_names]
    l_hand = "l_gripper"                 # if the ROS description has another name

    [views.hands]
    direction = [1.0, 0.2, 0.5]
    joints = ["l_wrist", "r_wrist"]
"""

from __future__ import annotations

import math
import numbers
import sys
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats, Vector, as_floats, as_numbers, check_kind, is_several, shaped
from nao_kin._core.files import read_toml
from nao_kin._core.guesses import public_attributes as _public_attributes
from nao_kin._core.text import nearest_names, one_line_repr, quoted
from nao_kin.errors import BadArgument, BadInputFile

__all__ = ["CoupledLimit", "Mimic", "Posture", "Semantics", "View", "read_semantics"]

globals().update(_public_attributes(__name__))

UNITS = ("rad", "m", "1")
# The fields of `Semantics` that are names of frames.
FRAME_FIELDS = ("end_effectors", "soles", "cameras", "accelerometers", "gyrometers", "force_sensors")


def _values(values: Floats | float, joint: str, of: str = "") -> Floats | float:
    """Return values of a joint as numbers; doubles, which kinematics asks for in its inner loops, as they are."""
    if type(values) is float or (isinstance(values, np.ndarray) and values.dtype == np.float64):
        return values
    return as_numbers(values, f"values of {of}{quoted(joint)}")


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: value = multiplier · value of the driving joint + offset.

    Attributes:
        joint: the driving joint.
        multiplier: ratio of the two values.
        offset: value when the driving joint is at zero.

    Examples:
        >>> finger = nk.semantics.Mimic("LHand", multiplier=2.0, offset=0.1)
        >>> finger.value(np.array([0.0, 1.0])).tolist(), finger.range(0.0, 0.5)
        ([0.1, 2.1], (0.1, 1.1))
    """

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0

    def __post_init__(self) -> None:
        check_kind(self.joint, "the driving joint", str)

    def value(self, driver: Floats | float) -> Floats:
        """Return values of the mimic joint for values of the driving joint, any shape."""
        values = _values(driver, self.joint)
        with np.errstate(over="ignore", invalid="ignore"):  # they may be infinite
            return np.asarray(self.multiplier * values + self.offset)

    def driver_value(self, value: Floats | float) -> Floats:
        """Return values of the driving joint for values of the mimic joint; the multiplier must not be zero."""
        values = _values(value, self.joint, "the joint that follows ")
        with np.errstate(over="ignore", invalid="ignore"):
            return np.asarray((values - self.offset) / self.multiplier)

    def through(self, driver: Mimic) -> Mimic:
        """Return how this joint follows the driver of its driving joint; `driver` is the mimic of the driving joint."""
        check_kind(driver, "driver", Mimic)
        return Mimic(driver.joint, self.multiplier * driver.multiplier, self.offset + self.multiplier * driver.offset)

    def inverted(self, follower: str) -> Mimic:
        """Return how the driving joint follows the `follower`; the multiplier must not be zero."""
        return Mimic(follower, 1.0 / self.multiplier, -self.offset / self.multiplier)

    def range(self, lower: float, upper: float) -> tuple[float, float]:
        """Return the range of the mimic joint for a range of the driving joint."""
        if self.multiplier == 0.0:
            return self.offset, self.offset
        ends = sorted(self.multiplier * end + self.offset for end in _ends(lower, upper))
        return ends[0], ends[1]

    def driver_range(self, lower: float, upper: float) -> tuple[float, float]:
        """Return the range of the driving joint for a range of the mimic joint; the multiplier must not be zero."""
        ends = sorted((end - self.offset) / self.multiplier for end in _ends(lower, upper))
        return ends[0], ends[1]


def _ends(lower: float, upper: float) -> list[float]:
    """Return the ends of a range, which may be infinite."""
    ends = as_numbers([lower, upper], "the ends of a range")
    if ends.shape != (2,) or np.isnan(ends).any():
        raise BadArgument(f"the ends of a range must be two numbers, got {quoted(lower)} and {quoted(upper)}")
    found: list[float] = ends.tolist()
    return found


@one_line_repr
@dataclass(frozen=True)
class CoupledLimit:
    """Range of one joint as a piecewise linear function of another, constant outside its table.

    Attributes:
        joint: the joint whose range this is.
        of: the joint it depends on.
        at: values of `of` where the range bends, ascending [rad].
        lower: smallest value of `joint` at each of these values [rad].
        upper: largest value of `joint` at each of these values [rad].

    Raises:
        BadArgument: columns of different lengths or without numbers, `at` not ascending, a lower bound above its upper
            bound, a joint that depends on itself.

    Examples:
        >>> ends = {"at": (-1.0, 1.0), "lower": (-0.2, -0.4), "upper": (0.2, 0.4)}
        >>> limit = nk.semantics.CoupledLimit("HeadPitch", "HeadYaw", **ends)
        >>> lower, upper = limit.range(np.array([0.0, 5.0]))
        >>> lower.round(9).tolist(), upper.round(9).tolist()
        ([-0.3, -0.4], [0.3, 0.4])
    """

    joint: str
    of: str
    at: tuple[float, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...]

    def __post_init__(self) -> None:
        for name in ("joint", "of"):
            check_kind(getattr(self, name), f"{name!r} of a coupled limit", str)
        what = f"the coupled limit of {self.joint}"
        if self.joint == self.of:
            raise BadArgument(f"{what} depends on that joint itself")
        for name in ("at", "lower", "upper"):
            try:
                values = tuple(getattr(self, name))
                if not all(isinstance(value, numbers.Real) for value in values):
                    raise TypeError
                object.__setattr__(self, name, tuple(map(float, values)))
            except (TypeError, ValueError, OverflowError):
                raise BadArgument(f"{what} must have numbers in {name}, got {quoted(getattr(self, name))}") from None
        if not (len(self.at) == len(self.lower) == len(self.upper) > 0):
            counts = f"{len(self.at)}, {len(self.lower)} and {len(self.upper)}"
            raise BadArgument(f"{what} must have equally many at, lower and upper, got {counts}")
        if not np.all(np.diff(self.at) > 0.0) or not np.isfinite([self.at, self.lower, self.upper]).all():
            raise BadArgument(f"{what} must have finite numbers, at in ascending order")
        if np.any(np.greater(self.lower, self.upper)):
            raise BadArgument(f"{what} has a lower bound above the upper one")

    def range(self, of: Floats) -> tuple[Floats, Floats]:
        """Return the smallest and largest value of `joint` at values of `of`, any shape."""
        of = as_floats(of, (), f"values of {self.of}")
        return np.asarray(np.interp(of, self.at, self.lower)), np.asarray(np.interp(of, self.at, self.upper))


@one_line_repr
@dataclass(frozen=True)
class Posture:
    """A predefined posture.

    Attributes:
        angles: joint → value; joints not named are at zero [rad, m or ratio].
        up: the vertical in the root's frame when the robot rests in this posture, as an accelerometer at rest shows it;
            None if it stands on its soles.
    """

    angles: Mapping[str, float]
    up: Vector | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "angles", _mapping(self.angles, "angles of a posture"))
        if self.up is not None:
            shaped(self.up, (3,), "up of a posture")

    def __reduce__(self) -> tuple[Any, ...]:
        return Posture, (dict(self.angles), self.up)  # mapping proxies do not pickle


@dataclass(frozen=True)
class View:
    """A close view of a part of the robot.

    Attributes:
        direction: from the robot to the camera, in the root's frame.
        joints: joints whose links are shown, with all that these links carry.
    """

    direction: Vector
    joints: tuple[str, ...]

    def __post_init__(self) -> None:
        shaped(self.direction, (3,), "direction of a view")
        object.__setattr__(self, "joints", _several(self.joints, "joints of a view", str))


@one_line_repr
@dataclass(frozen=True)
class Semantics:
    """The semantics of a robot, which its URDF does not contain; each part may be empty.

    Attributes:
        chains: name → joints from the trunk outwards.
        end_effectors: the frames whose poses are used most.
        soles: frames with the floor in their xy plane when the robot stands on them.
        cameras: frames of cameras that look along their x axis.
        fields_of_view: camera → its horizontal and vertical field of view [rad], each in (0, π), if they are known.
        resolutions: name → width and height of the images of the cameras [pixel].
        postures: predefined postures by name.
        start: the posture shown first; "" for all joints at zero, or at the limit nearest to it.
        coupled_limits: tables in which one joint's range depends on another's value.
        units: joint → "rad", "m" or "1", if it is not "rad" for a turning joint or "m" for a sliding one.
        views: close views by name.
        version: version of the robot; "" if there is only one.
        root: name of the frame in which poses are given; "" for the name of the root link.
        accelerometers: frames of sensors that measure acceleration along their axes.
        gyrometers: frames of sensors that measure angular velocity about their axes.
        force_sensors: frames of sensors that measure the force pressed on them from outside, along their z axis.
        outlines: sole → corners of the area that touches the floor, in the frame of the sole: x and y, and z if it is
            not 0; seen along z, they are those of a convex polygon [m].
        ros_names: link, joint or robot → its name in the robot's published ROS description, if it differs; links with
            the same name in that description are one link in it.
        disabled_collisions: pairs of links that need no check for collisions, each with the reason, as in an SRDF:
            (link, link, reason); empty if this is not known.

    Raises:
        BadArgument: a part of another kind, or a unit other than these three.

    Examples:
        >>> semantics = nk.semantics.Semantics(chains={"Head": ("HeadYaw", "HeadPitch")}, end_effectors=("Head",))
        >>> semantics.joints()["HeadPitch"]
        ('chain', 'Head')
    """

    chains: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    end_effectors: tuple[str, ...] = ()
    soles: tuple[str, ...] = ()
    cameras: tuple[str, ...] = ()
    postures: Mapping[str, Posture] = field(default_factory=dict)
    start: str = ""
    coupled_limits: tuple[CoupledLimit, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)
    views: Mapping[str, View] = field(default_factory=dict)
    version: str = ""
    root: str = ""
    fields_of_view: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    accelerometers: tuple[str, ...] = ()
    gyrometers: tuple[str, ...] = ()
    force_sensors: tuple[str, ...] = ()
    ros_names: Mapping[str, str] = field(default_factory=dict)
    outlines: Mapping[str, tuple[tuple[float, ...], ...]] = field(default_factory=dict)
    disabled_collisions: tuple[tuple[str, str, str], ...] = ()
    resolutions: Mapping[str, tuple[int, int]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        kinds = {"chains": Iterable, "postures": Posture, "units": str, "views": View, "ros_names": str}
        for name, kind in kinds.items():
            object.__setattr__(self, name, _mapping(getattr(self, name), name, kind))
        chains = {name: _several(joints, f"chain {quoted(name)}", str) for name, joints in self.chains.items()}
        object.__setattr__(self, "chains", MappingProxyType(chains))
        for name in FRAME_FIELDS:
            object.__setattr__(self, name, _several(getattr(self, name), name, str))
        object.__setattr__(self, "coupled_limits", _several(self.coupled_limits, "coupled_limits", CoupledLimit))
        rows = _several(self.disabled_collisions, "disabled_collisions", Iterable)
        rows = tuple(_several(row, "a row of disabled_collisions", str) for row in rows)
        if any(len(row) != 3 for row in rows):
            raise BadArgument("a row of disabled_collisions must be two links and a reason")
        object.__setattr__(self, "disabled_collisions", rows)
        fields = _mapping(self.fields_of_view, "fields_of_view", Iterable)
        for camera, angles in fields.items():
            pair = _several(angles, f"field of view of {camera}", (int, float))
            if len(pair) != 2 or not all(0.0 < angle < math.pi for angle in pair):
                raise BadArgument(f"field of view of {camera} must be two angles in (0, π), got {quoted(angles)}")
        object.__setattr__(self, "fields_of_view", MappingProxyType({k: tuple(v) for k, v in fields.items()}))
        sizes = _mapping(self.resolutions, "resolutions", Iterable)
        object.__setattr__(self, "resolutions", MappingProxyType({k: _size(v, k) for k, v in sizes.items()}))
        outlines = _mapping(self.outlines, "outlines", Iterable)
        object.__setattr__(self, "outlines", MappingProxyType({k: _corners(v, k) for k, v in outlines.items()}))
        for name in ("start", "version", "root"):
            check_kind(getattr(self, name), name, str)
        for joint, unit in self.units.items():
            if unit not in UNITS:
                raise BadArgument(f"unit of {joint} must be one of {', '.join(UNITS)}, got {quoted(unit)}")

    def joints(self) -> dict[str, tuple[str, str]]:
        """Return every joint named in the semantics, with the kind and the name of the part that names it first."""
        parts: list[tuple[Iterable[str], tuple[str, str]]] = []
        parts += [(joints, ("chain", name)) for name, joints in self.chains.items()]
        parts += [(posture.angles, ("posture", name)) for name, posture in self.postures.items()]
        parts += [((table.joint, table.of), ("a coupled limit", "")) for table in self.coupled_limits]
        parts += [(self.units, ("the units", ""))]
        parts += [(view.joints, ("view", name)) for name, view in self.views.items()]
        return _named_first(parts)

    def frames(self) -> dict[str, tuple[str, str]]:
        """Return every frame named in the semantics, with the field that names it first."""
        return _named_first(
            (getattr(self, field), (field, "")) for field in (*FRAME_FIELDS, "fields_of_view", "outlines")
        )

    def __getstate__(self) -> dict[str, object]:
        # Mapping proxies do not pickle.
        return {k: dict(v) if isinstance(v, MappingProxyType) else v for k, v in self.__dict__.items()}

    def __setstate__(self, state: dict[str, object]) -> None:
        self.__dict__.update(state)
        Semantics.__post_init__(self)


def _named_first(parts: Iterable[tuple[Iterable[str], tuple[str, str]]]) -> dict[str, tuple[str, str]]:
    """Return name → the first of the parts that contains it."""
    found: dict[str, tuple[str, str]] = {}
    for names, part in parts:
        for name in names:
            found.setdefault(name, part)
    return found


def _mapping(values: object, what: str, kind: type = object) -> Mapping[str, Any]:
    """Return a read-only copy of a mapping whose values have one type."""
    if not isinstance(values, Mapping):
        raise BadArgument(f"{what} must be a mapping of names, got {quoted(values)}")
    for name, value in values.items():
        check_kind(value, f"{what}: {name}", kind)
    return MappingProxyType(dict(values))


def _several(values: object, what: str, kind: type | tuple[type, ...]) -> tuple[Any, ...]:
    """Return a tuple of values of one type; a string is one value, not several letters."""
    if not is_several(values):
        raise BadArgument(f"{what} must be several, as in a list, got {quoted(values)}")
    found = tuple(values)
    for value in found:
        check_kind(value, what, kind)
    return found


def _size(values: Iterable[Any], resolution: str) -> tuple[int, int]:
    """Return the width and the height of an image, whole numbers from 1."""
    pair = _several(values, f"resolution {resolution}", (int, float))
    if len(pair) != 2 or not all(size >= 1 and size == int(size) for size in pair):
        raise BadArgument(f"resolution {resolution} must be a width and a height in pixels, got {quoted(values)}")
    return int(pair[0]), int(pair[1])


def _corners(values: Iterable[Any], sole: str) -> tuple[tuple[float, ...], ...]:
    """Return the corners of an outline as pairs or triples of finite numbers, at least three."""
    try:
        points = tuple(tuple(float(value) for value in corner) for corner in values)
    except (TypeError, ValueError, OverflowError):
        points = ()
    if len(points) < 3 or {len(p) for p in points} - {2, 3} or not all(np.isfinite(p).all() for p in points):
        raise BadArgument(
            f"the outline of {sole} must be three or more pairs or triples of finite numbers, got {quoted(values)}"
        )
    return points


# --- Semantics from a TOML file, often beside a URDF.


def read_semantics(path: Path | str) -> Semantics:
    """Return the semantics in a TOML file.

    Its joints and frames are not checked before a robot gets the semantics.

    Raises:
        BadInputFile: the file cannot be read, is no TOML, or has an entry that is unknown or of the wrong kind.

    Examples:
        >>> from pathlib import Path
        >>> _ = Path("robot.toml").write_text("end_effectors = ['gripper']")
        >>> nk.semantics.read_semantics("robot.toml").end_effectors
        ('gripper',)
    """
    document = read_toml(path)
    try:
        return Semantics(**_members(document, "", _READERS))
    except (_BadEntry, BadArgument) as error:
        raise BadInputFile(str(path), str(error)) from None


_LARGEST = sys.float_info.max


class _BadEntry(Exception):
    """A wrong entry; `read_semantics` adds the file's name."""


_EntryReader = Callable[[Any, str], Any]


def _members(
    table: Any, where: str, readers: Mapping[str, _EntryReader], required: tuple[str, ...] = ()
) -> dict[str, Any]:
    """Return the entries of a table, each read by the reader of its name."""
    values = _table(table, where)
    for name in values:
        if name not in readers:
            near = ", ".join(nearest_names(name, readers) or sorted(readers))
            raise _BadEntry(f"unknown entry {quoted(where + name)} (nearest: {near})")
    for name in required:
        if name not in values:
            raise _BadEntry(f"{where.rstrip('.')} has no {name!r}")
    return {name: readers[name](value, f"{where}{name}") for name, value in values.items()}


def _instance_of(kind: type, what: str) -> _EntryReader:
    def read(value: Any, where: str) -> Any:
        if not isinstance(value, kind):
            raise _BadEntry(f"{where.rstrip('.')} must be {what}, got {quoted(value)}")
        return value

    return read


_table, _text, _list = _instance_of(dict, "a table"), _instance_of(str, "text"), _instance_of(list, "a list")


def _number(value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) <= _LARGEST:
        raise _BadEntry(f"{where} must be a finite number, got {quoted(value)}")
    return float(value)


def _list_of(read: _EntryReader) -> _EntryReader:
    return lambda values, where: tuple(
        read(value, f"{where}[{index}]") for index, value in enumerate(_list(values, where))
    )


def _table_of(read: _EntryReader) -> _EntryReader:
    return lambda values, where: {name: read(value, f"{where}.{name}") for name, value in _table(values, where).items()}


_names, _numbers = _list_of(_text), _list_of(_number)


def _vector(value: Any, where: str) -> Vector:
    numbers = _numbers(value, where)
    if len(numbers) != 3 or not any(numbers):
        raise _BadEntry(f"{where} must be three numbers, not all zero, got {quoted(value)}")
    return numbers[0], numbers[1], numbers[2]


def _object_of(kind: type, optional: Collection[str] = (), /, **readers: _EntryReader) -> _EntryReader:
    required = tuple(name for name in readers if name not in optional)
    return lambda value, where: kind(**_members(value, f"{where}.", readers, required))


_posture = _object_of(Posture, ("up",), angles=_table_of(_number), up=_vector)
_view = _object_of(View, direction=_vector, joints=_names)
_coupled_limit = _object_of(CoupledLimit, joint=_text, of=_text, at=_numbers, lower=_numbers, upper=_numbers)

_READERS: dict[str, _EntryReader] = {
    **dict.fromkeys(FRAME_FIELDS, _names),
    **dict.fromkeys(("start", "version", "root"), _text),
    "chains": _table_of(_names),
    "postures": _table_of(_posture),
    "coupled_limits": _list_of(_coupled_limit),
    "units": _table_of(_text),
    "views": _table_of(_view),
    "fields_of_view": _table_of(_numbers),
    "resolutions": _table_of(_numbers),
    "outlines": _table_of(_list_of(_numbers)),
    "ros_names": _table_of(_text),
    "disabled_collisions": _list_of(_names),
}
