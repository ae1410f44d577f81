"""The types of rows for the robot's numbers, each with its unit and the code of its source."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, TypeVar, get_args

from nao_kin._core.arrays import Vector
from nao_kin.errors import UnknownName

Version = Literal["v3.2", "v3.3", "v4", "v5", "v6"]
VERSIONS: tuple[Version, ...] = get_args(Version)

Colour = tuple[float, float, float, float]  # red, green, blue, opacity
ShapeKind = Literal["sphere", "cylinder", "capsule", "box"]


# A coordinate is a number [m], or the name of an offset, after a minus sign where it points against the axis.
Coordinate = float | str


@dataclass(frozen=True, kw_only=True)
class VersionedRow:
    """A row that may differ between versions; `versions`, the oldest first, is set when the tables are merged."""

    versions: tuple[Version, ...] = ()

    @property
    def key(self) -> str:
        """The first field; a table has one row per key and version."""
        return str(getattr(self, next(iter(self.__match_args__))))

    @property
    def place(self) -> str | None:
        """The joint that carries the object; None for tables in which every version has the same keys."""
        return getattr(self, "parent", None)


@dataclass(frozen=True)
class OffsetRow(VersionedRow):
    """The length of an offset, a distance between two joints.

    Attributes:
        name: Aldebaran's name of the offset.
        value_mm: length [mm].
    """

    name: str
    value_mm: float
    source: str


@dataclass(frozen=True)
class JointRow:
    """A joint with its position in the frame of its parent joint, and its axis."""

    name: str  # NAOqi's name
    chain: str  # NAOqi's chain
    parent: str  # the joint that carries it, or "torso"
    link: str  # the link it moves, by its name in the official ROS description
    origin: tuple[Coordinate, Coordinate, Coordinate]  # position in the parent's joint frame, in terms of offsets
    axis: Vector  # in the torso-parallel joint frame, not normalised
    motion: str  # in words
    source: str
    mimic: str | None = None  # the joint whose motor also drives this one


@dataclass(frozen=True)
class FingerRow:
    """A phalanx joint, driven by the opening of the hand."""

    name: str  # without the side ("Finger11")
    parent: str  # the phalanx that carries it, or "WristYaw"
    xyz_m: Vector  # position in the parent's frame [m]
    rpy: Vector  # orientation in the parent's frame at opening 0 [rad]
    source: str


@dataclass(frozen=True)
class LimitRow(VersionedRow):
    """Range of one joint.

    Attributes:
        joint: the joint.
        lower: smallest value, in `unit`.
        upper: largest value, in `unit`.
        unit: "deg" for turning joints, "1" for the opening of a hand.
    """

    joint: str
    lower: float
    upper: float
    unit: Literal["deg", "1"]
    source: str


@dataclass(frozen=True)
class ActuatorRow(VersionedRow):
    """Largest speed [rad/s; 1/s for a hand] and torque [N m] of one joint in the official URDF."""

    joint: str
    velocity: float
    effort: float
    source: str


@dataclass(frozen=True)
class CoupledLimitRow:
    """Range of one joint that depends on the value of another one: Aldebaran's anti-collision table.

    Attributes:
        joint: the joint whose range this is.
        of: the joint it depends on.
        table_deg: rows (value of `of`, lower, upper) [deg], linear in between, constant outside.
    """

    joint: str
    of: str
    table_deg: tuple[Vector, ...]
    source: str


@dataclass(frozen=True)
class InertialRow(VersionedRow):
    """Mass, centre of mass and inertia of the link that a joint moves.

    Attributes:
        link: the joint that moves the link, or "torso".
        mass_kg: mass [kg].
        com_m: centre of mass in the joint frame [m].
        inertia: ixx, ixy, ixz, iyy, iyz, izz about the centre of mass, axes parallel to the joint frame [kg m²].
    """

    link: str
    mass_kg: float
    com_m: Vector
    inertia: tuple[float, float, float, float, float, float]
    source: str


@dataclass(frozen=True)
class FrameRow(VersionedRow):
    """A sensor or effector frame."""

    name: str  # NAOqi's name
    ros_name: str | None  # its link in the official ROS description
    parent: str  # the joint that carries it, or "torso"
    xyz: tuple[Coordinate, Coordinate, Coordinate]  # position in the parent's joint frame, numbers [m] or offsets
    rpy: Vector  # orientation, R = Rz(yaw) Ry(pitch) Rx(roll) [rad]
    source: str


@dataclass(frozen=True)
class CameraRow(VersionedRow):
    """The image sensor and the lens of one camera; its pose is a `FrameRow`.

    Attributes:
        camera: name of the camera's frame.
        sensor: the image sensor.
        field_of_view_deg: horizontal and vertical angle of the whole image [deg].
        largest: name of the largest resolution.
    """

    camera: str
    sensor: str
    field_of_view_deg: tuple[float, float]
    largest: str
    source: str


@dataclass(frozen=True)
class ResolutionRow:
    """The size of an image: NAOqi's name without its k, width and height [pixel]."""

    name: str
    width: int
    height: int
    source: str


@dataclass(frozen=True)
class ShapeRow:
    """A primitive shape fixed to the link that a joint moves.

    Attributes:
        name: name of the shape.
        parent: the joint that moves the link, or "torso".
        kind: "sphere", "cylinder", "capsule" or "box".
        size_m: (radius,), (radius, length) or the three edge lengths; a capsule is longer by its hemispheres [m].
        center_m: centre in the joint frame [m].
        axis: direction of the axis of a cylinder or capsule, not normalised.
    """

    name: str
    parent: str
    kind: ShapeKind
    size_m: tuple[float, ...]
    center_m: Vector
    axis: Vector
    source: str


@dataclass(frozen=True)
class OutlineRow:
    """The area of a sole that touches the floor."""

    sole: str  # NAOqi's name of the sole's frame
    corners_m: tuple[tuple[float, float], ...]  # x and y of its corners in that frame, counter-clockwise [m]
    source: str


@dataclass(frozen=True)
class VisualRow(VersionedRow):
    """The meshes of one link: a file per colour, in the frame of the joint that moves the link.

    Attributes:
        parent: the joint that moves the link, "torso", or a phalanx without its side ("Finger11").
        part: name of the part.
        colours: its colours; the file of a colour is `{part}_{colour}.obj`.
    """

    parent: str
    part: str
    colours: tuple[str, ...]
    source: str = "GEN"

    @property
    def key(self) -> str:
        """The joint and the part."""
        return f"{self.parent}/{self.part}"

    @property
    def meshes(self) -> tuple[str, ...]:
        """Names of the meshes, in the order of the colours."""
        return tuple(f"{self.part}_{colour}" for colour in self.colours)


@dataclass(frozen=True)
class PostureRow:
    """A predefined posture: the 26 joint values in NAOqi's Body order [rad; 0 to 1 for the hands]."""

    name: str
    body: tuple[float, ...]
    source: str


# --- The numbers of one version as changes of those of another.

_Row = TypeVar("_Row", bound=VersionedRow)


@dataclass(frozen=True, kw_only=True)
class VersionTables:
    """All rows of one version that may differ in another version."""

    offsets: tuple[OffsetRow, ...] = ()
    limits: tuple[LimitRow, ...] = ()
    actuators: tuple[ActuatorRow, ...] = ()
    inertials: tuple[InertialRow, ...] = ()
    frames: tuple[FrameRow, ...] = ()
    cameras: tuple[CameraRow, ...] = ()
    visuals: tuple[VisualRow, ...] = ()
    placeholder: InertialRow | None = None  # inertia of links without a published mass; None for no inertia
    colours: Mapping[str, Colour] = field(default_factory=dict)  # the colours of the meshes, by name


@dataclass(frozen=True, kw_only=True)
class VersionPage(VersionTables):
    """The rows in which one version differs from `base`; a row replaces the row of the base with the same key.

    Frames and visuals may also be added, and left out by their names or keys, "joint/part". A placeholder of None means
    that of the base.
    """

    version: Version
    base: Version
    without_frames: tuple[str, ...] = ()
    without_visuals: tuple[str, ...] = ()

    def over(self, base: VersionTables) -> VersionTables:
        """Return the tables of this version from those of `base`."""
        tables: dict[str, Any] = {}
        for name in ("offsets", "limits", "actuators", "inertials", "frames", "cameras", "visuals"):
            what = f"{name.removesuffix('s')} of {self.base}, which {self.version} is laid over"
            without = getattr(self, f"without_{name}", ())
            tables[name] = overlaid(what, getattr(base, name), getattr(self, name), without)
        colours = {**base.colours, **self.colours}
        return VersionTables(**tables, placeholder=self.placeholder or base.placeholder, colours=colours)


def overlaid(what: str, base: Iterable[_Row], changes: Sequence[_Row], without: Sequence[str]) -> tuple[_Row, ...]:
    """Return the rows of `base` with some of them changed, left out (by key) or added.

    A new row takes the position of the first row of the same place that was left out, or follows the last row of that
    place. Only changes of existing rows are possible in a table without places.
    """
    rows = {row.key: [row] for row in base}
    places = {key: row.place for key, (row,) in rows.items()}
    for key in without:
        if key not in rows:
            raise UnknownName(what, key, tuple(rows))
        rows[key] = []
    for row in changes:
        if row.key in rows:
            rows[row.key] = [row]
        else:
            same_place = [key for key, place in places.items() if place is not None and place == row.place]
            if not same_place:
                raise UnknownName(what, row.key, tuple(rows))
            rows[next((key for key in same_place if key in without), same_place[-1])].append(row)
    return tuple(row for group in rows.values() for row in group)
