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

    [stall_torques]
    l_elbow = 2.6                        # for a moment, where it is more than the effort in the URDF [N m]

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
from collections.abc import Callable, Iterable, Mapping
from dataclasses import MISSING, dataclass, field, fields
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats, Vector, as_floats, as_numbers, check_kind, is_several, positive, shaped
from nao_kin._core.files import read_toml
from nao_kin._core.guesses import public_attributes as _public_attributes
from nao_kin._core.text import nearest_names, one_line_repr, quoted
from nao_kin.errors import BadArgument, BadInputFile, NaoKinError

__all__ = ["CoupledLimit", "Mimic", "Posture", "Semantics", "View", "read_semantics"]

globals().update(_public_attributes(__name__))

UNITS = ("rad", "m", "1")
# What a file may say about an inertial unit, and how many numbers each has.
INERTIAL_UNIT = {"mounting": 2, "gyro_bias": 3, "accelerometer_bias": 3}
# The fields of `Semantics` that are names of frames.
FRAME_FIELDS = ("end_effectors", "soles", "cameras", "accelerometers", "gyrometers", "force_sensors")


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

    def value(self, driver: Floats | float) -> Floats:
        """Return values of the mimic joint for values of the driving joint, any shape."""
        values = as_numbers(driver, "values of a joint")
        with np.errstate(over="ignore", invalid="ignore"):  # they may be infinite
            return np.asarray(self.multiplier * values + self.offset)

    def driver_value(self, value: Floats | float) -> Floats:
        """Return values of the driving joint for values of the mimic joint; the multiplier must not be zero."""
        values = as_numbers(value, "values of a joint")
        with np.errstate(over="ignore", invalid="ignore"):
            return np.asarray((values - self.offset) / self.multiplier)

    def through(self, driver: Mimic) -> Mimic:
        """Return how this joint follows the driver of its driving joint; `driver` is the mimic of the driving joint."""
        return Mimic(driver.joint, self.multiplier * driver.multiplier, self.offset + self.multiplier * driver.offset)

    def inverted(self, follower: str) -> Mimic:
        """Return how the driving joint follows the `follower`; the multiplier must not be zero."""
        return Mimic(follower, 1.0 / self.multiplier, -self.offset / self.multiplier)

    def range(self, lower: float, upper: float) -> tuple[float, float]:
        """Return the range of the mimic joint for a range of the driving joint."""
        if self.multiplier == 0.0:
            return self.offset, self.offset
        ends = sorted(self.multiplier * end + self.offset for end in (lower, upper))
        return ends[0], ends[1]

    def driver_range(self, lower: float, upper: float) -> tuple[float, float]:
        """Return the range of the driving joint for a range of the mimic joint; the multiplier must not be zero."""
        ends = sorted((end - self.offset) / self.multiplier for end in (lower, upper))
        return ends[0], ends[1]


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
        BadArgument: columns of different lengths, `at` not ascending, a lower bound above its upper bound, a joint that
            depends on itself.

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
            object.__setattr__(self, name, _numbers(getattr(self, name), f"{name} of {what}"))
        if not (len(self.at) == len(self.lower) == len(self.upper) > 0):
            counts = f"{len(self.at)}, {len(self.lower)} and {len(self.upper)}"
            raise BadArgument(f"{what} must have equally many at, lower and upper, got {counts}")
        if not np.all(np.diff(self.at) > 0.0):
            raise BadArgument(f"{what} must have at in ascending order")
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
        angles = _mapping(self.angles, "angles of a posture").items()
        numbers = {name: float(shaped(value, (), f"{name} in a posture")) for name, value in angles}
        object.__setattr__(self, "angles", MappingProxyType(numbers))
        if self.up is not None:
            object.__setattr__(self, "up", _direction(self.up, "up of a posture"))

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
        object.__setattr__(self, "direction", _direction(self.direction, "direction of a view"))
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
        lenses: camera → (width, height, fx, fy, cx, cy[, k1, k2, p1, p2 …]) [pixel], if its lens was measured.
        sensors: what was measured of its sensors: "mounting" → (roll, pitch) of the root link in the axes of the
            inertial unit, R = Ry(pitch) Rx(roll) [rad]; "gyro_bias" (x, y, z) [rad/s] and "accelerometer_bias"
            (x, y, z) [m/s²] in these axes; force sensor → (zero, gain): its force is gain · (reported value − zero).
        postures: predefined postures by name.
        start: the posture shown first; "" for all joints at zero, or at the limit nearest to it.
        coupled_limits: tables in which one joint's range depends on another's value.
        units: joint → "rad", "m" or "1", if it is not "rad" for a turning joint or "m" for a sliding one.
        stall_torques: joint → the torque that its motor has for a moment, at rest [N m, or N], if this is more than the
            effort in the URDF, such as where that is the torque that the motor can give for long.
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
    lenses: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    sensors: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    stall_torques: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("start", "version", "root"):
            check_kind(getattr(self, name), name, str)
        for name, kind in {"postures": Posture, "units": str, "views": View, "ros_names": str}.items():
            object.__setattr__(self, name, _mapping(getattr(self, name), name, kind))
        for name in FRAME_FIELDS:
            object.__setattr__(self, name, _several(getattr(self, name), name, str))
        object.__setattr__(self, "coupled_limits", _several(self.coupled_limits, "coupled_limits", CoupledLimit))
        rows = _several(self.disabled_collisions, "disabled_collisions", Iterable)
        rows = tuple(_several(row, "a row of disabled_collisions", str) for row in rows)
        if any(len(row) != 3 for row in rows):
            raise BadArgument("a row of disabled_collisions must be two links and a reason")
        object.__setattr__(self, "disabled_collisions", rows)
        made: dict[str, Callable[[object, str], Any]] = {"chains": _chain, "fields_of_view": _view_angles}
        made |= {"resolutions": _size, "lenses": _lens, "sensors": _sensor, "outlines": _corners}
        made["stall_torques"] = _torque
        for name, make in made.items():
            values = _mapping(getattr(self, name), name)
            object.__setattr__(self, name, MappingProxyType({key: make(each, key) for key, each in values.items()}))
        for joint, unit in self.units.items():
            if unit not in UNITS:
                raise BadArgument(f"unit of {joint} must be one of {', '.join(UNITS)}, got {quoted(unit)}")

    def joints(self) -> dict[str, tuple[str, str]]:
        """Return every joint named in the semantics, with the kind and the name of the part that names it first."""
        parts: list[tuple[Iterable[str], tuple[str, str]]] = []
        parts += [(joints, ("chain", name)) for name, joints in self.chains.items()]
        parts += [(posture.angles, ("posture", name)) for name, posture in self.postures.items()]
        parts += [((table.joint, table.of), ("a coupled limit", "")) for table in self.coupled_limits]
        parts += [(self.units, ("the units", "")), (self.stall_torques, ("the stall torques", ""))]
        parts += [(view.joints, ("view", name)) for name, view in self.views.items()]
        return _named_first(parts)

    def frames(self) -> dict[str, tuple[str, str]]:
        """Return every frame named in the semantics, with the field that names it first."""
        return _named_first(
            (getattr(self, field), (field, "")) for field in (*FRAME_FIELDS, "fields_of_view", "lenses", "outlines")
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


def _numbers(values: object, what: str) -> tuple[float, ...]:
    """Return a list of finite numbers as a tuple."""
    return tuple(as_floats(_several(values, what, object), (), what).tolist())


def _direction(values: object, what: str) -> Vector:
    """Return a vector other than zero as a tuple."""
    x, y, z = shaped(values, (3,), what).tolist()  # type: ignore[arg-type]
    if not (x or y or z):
        raise BadArgument(f"{what} must not be zero")
    return x, y, z


def _chain(values: object, name: str) -> tuple[str, ...]:
    return _several(values, f"chain {quoted(name)}", str)


def _view_angles(values: object, camera: str) -> tuple[float, ...]:
    pair = _numbers(values, f"field of view of {camera}")
    if len(pair) != 2 or not all(0.0 < angle < math.pi for angle in pair):
        raise BadArgument(f"field of view of {camera} must be two angles in (0, π), got {quoted(values)}")
    return pair


def _torque(value: object, joint: str) -> float:
    return float(positive(value, f"stall torque of {joint}"))  # type: ignore[arg-type]


def _size(values: object, resolution: str) -> tuple[int, int]:
    """Return the width and the height of an image, whole numbers from 1."""
    pair = _numbers(values, f"resolution {resolution}")
    if len(pair) != 2 or not all(size >= 1 and size == int(size) for size in pair):
        raise BadArgument(f"resolution {resolution} must be a width and a height in pixels, got {quoted(values)}")
    return int(pair[0]), int(pair[1])


def _lens(values: object, camera: str) -> tuple[float, ...]:
    numbers = _numbers(values, f"lens of {camera}")
    if len(numbers) not in (6, 10, 11, 14):
        what = "width, height, fx, fy, cx, cy and perhaps 4, 5 or 8 coefficients of the distortion"
        raise BadArgument(f"lens of {camera} must be {what}, got {len(numbers)} numbers")
    return numbers


def _sensor(values: object, name: str) -> tuple[float, ...]:
    numbers = _numbers(values, name)
    if len(numbers) != INERTIAL_UNIT.get(name, 2):
        raise BadArgument(f"{name} must be {INERTIAL_UNIT.get(name, 2)} numbers, got {len(numbers)}")
    if name not in INERTIAL_UNIT and numbers[1] <= 0.0:
        raise BadArgument(f"the gain of {name} must be positive, got {numbers[1]:g}")
    return numbers


def _corners(values: object, sole: str) -> tuple[tuple[float, ...], ...]:
    """Return the corners of an outline as pairs or triples of finite numbers, at least three."""
    what = f"the outline of {sole}"
    points = tuple(_numbers(corner, what) for corner in _several(values, what, object))
    if len(points) < 3 or {len(p) for p in points} - {2, 3}:
        raise BadArgument(f"{what} must be three or more pairs or triples of numbers, got {quoted(values)}")
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
        parts = _entries(document, Semantics, "")
        for name, kind in {"postures": Posture, "views": View}.items():
            if name in parts:
                tables = _mapping(parts[name], name).items()
                parts[name] = {key: kind(**_entries(each, kind, f"{name}.{key}.")) for key, each in tables}
        rows = _several(parts.get("coupled_limits", ()), "coupled_limits", object)
        parts["coupled_limits"] = tuple(
            CoupledLimit(**_entries(row, CoupledLimit, f"coupled_limits[{k}].")) for k, row in enumerate(rows)
        )
        return Semantics(**parts)
    except NaoKinError as error:
        raise BadInputFile(str(path), str(error)) from None


def _entries(table: object, kind: type, where: str) -> dict[str, Any]:
    """Return the entries of a table, which are fields of a dataclass; all fields without a default must be there."""
    values, known = dict(_mapping(table, where.rstrip("."))), {one.name: one for one in fields(kind)}
    for name in values:
        if name not in known:
            near = ", ".join(nearest_names(name, known) or sorted(known))
            raise BadArgument(f"unknown entry {quoted(where + name)} (nearest: {near})")
    for name, one in known.items():
        if name not in values and one.default is one.default_factory is MISSING:
            raise BadArgument(f"{where.rstrip('.')} has no {name!r}")
    return values
