"""The kinds of rows that the robot's numbers stand in, each with its unit and the code of its source."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, TypeVar, get_args

from nao_kin._core.arrays import Vector
from nao_kin.errors import UnknownName

Version = Literal["v3.2", "v3.3", "v4", "v5", "v6"]
VERSIONS: tuple[Version, ...] = get_args(Version)

ShapeKind = Literal["sphere", "cylinder", "box"]


@dataclass(frozen=True)
class Offset:
    """A distance between two joints, as a coordinate: `-THIGH_LENGTH` points against the axis.

    Attributes:
        name: Aldebaran's name of the distance.
        sign: 1.0 along the axis, -1.0 against it.
    """

    name: str
    sign: float = 1.0

    def __neg__(self) -> Offset:
        return replace(self, sign=-self.sign)

    def __str__(self) -> str:
        return self.name if self.sign > 0 else f"-{self.name}"


# A coordinate is a number [m] or an offset.
Coordinate = float | Offset


@dataclass(frozen=True, kw_only=True)
class VersionedRow:
    """A row that a version's page can change.

    Attributes:
        versions: the versions it holds for, the oldest first; filled in when the pages are laid over each other.
    """

    versions: tuple[Version, ...] = ()

    @property
    def key(self) -> str:
        """What it is about, its first field; a table holds one row of a key for each version."""
        return str(getattr(self, next(iter(self.__match_args__))))

    @property
    def place(self) -> str | None:
        """The joint that carries it, where rows may come and go; None where every version has the row."""
        return getattr(self, "parent", None)


@dataclass(frozen=True)
class OffsetRow(VersionedRow):
    """The length of an offset.

    Attributes:
        offset: the distance.
        value_mm: length [mm].

    Examples:
        >>> row = nk.parameters.OFFSETS[0]
        >>> row.offset.name, row.value_mm
        ('NeckOffsetZ', 126.5)
    """

    offset: Offset
    value_mm: float
    source: str

    @property
    def name(self) -> str:
        """Aldebaran's name of it."""
        return self.offset.name


@dataclass(frozen=True)
class JointRow:
    """A joint: where it sits in the frame of its parent joint and the axis it turns about.

    Attributes:
        name: NAOqi's name.
        chain: NAOqi's chain.
        parent: the joint that carries it, or "torso".
        link: the link it moves, by its name in the official ROS description.
        origin: position in the parent's joint frame, in terms of offsets.
        axis: direction of the axis in the torso-parallel joint frame, not yet normalised.
        motion: what it does, in words.
        mimic: the joint whose motor also drives this one.
    """

    name: str
    chain: str
    parent: str
    link: str
    origin: tuple[Coordinate, Coordinate, Coordinate]
    axis: Vector
    motion: str
    source: str
    mimic: str | None = None


@dataclass(frozen=True)
class FingerRow:
    """A phalanx joint, driven by the opening of the hand.

    Attributes:
        name: name without the side ("Finger11").
        parent: the phalanx that carries it, or "WristYaw".
        xyz_m: position in the parent's frame [m].
        rpy: orientation in the parent's frame at opening 0 [rad].
    """

    name: str
    parent: str
    xyz_m: Vector
    rpy: Vector
    source: str


@dataclass(frozen=True)
class LimitRow(VersionedRow):
    """Range of one joint.

    Attributes:
        joint: the joint.
        lower: smallest value, in `unit`.
        upper: largest value, in `unit`.
        unit: "deg" for turning joints, "1" for the opening of a hand.

    Examples:
        >>> row = nk.parameters.LIMITS[0]
        >>> row.joint, row.lower, row.upper, row.unit
        ('HeadYaw', -119.5, 119.5, 'deg')
    """

    joint: str
    lower: float
    upper: float
    unit: Literal["deg", "1"]
    source: str


@dataclass(frozen=True)
class ActuatorRow(VersionedRow):
    """Speed and torque of one joint as the official URDF prints them.

    Attributes:
        joint: the joint.
        velocity: largest speed [rad/s; 1/s for a hand].
        effort: largest torque [N m].
    """

    joint: str
    velocity: float
    effort: float
    source: str


@dataclass(frozen=True)
class CoupledLimitRow:
    """Range of one joint that depends on where another one stands: Aldebaran's anti-collision table.

    Attributes:
        joint: the joint whose range this is.
        of: the joint it depends on.
        table_deg: rows (value of `of`, lower, upper) [deg], linear in between, constant outside.

    Examples:
        >>> row = nk.parameters.COUPLED_LIMITS[0]
        >>> row.joint, row.of
        ('HeadPitch', 'HeadYaw')
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

    Examples:
        >>> row = nk.parameters.INERTIALS[0]
        >>> row.link, row.mass_kg
        ('torso', 1.04956)
    """

    link: str
    mass_kg: float
    com_m: Vector
    inertia: tuple[float, float, float, float, float, float]
    source: str


@dataclass(frozen=True)
class FrameRow(VersionedRow):
    """A sensor or effector frame.

    Attributes:
        name: NAOqi's name.
        ros_name: its link in the official ROS description, None where that has no such link.
        parent: the joint that carries it, or "torso".
        xyz: position in the parent's joint frame, numbers [m] or offsets.
        rpy: orientation, R = Rz(yaw) Ry(pitch) Rx(roll) [rad].
    """

    name: str
    ros_name: str | None
    parent: str
    xyz: tuple[Coordinate, Coordinate, Coordinate]
    rpy: Vector
    source: str


@dataclass(frozen=True)
class ShapeRow:
    """A primitive shape fixed to the link that a joint moves.

    Attributes:
        name: name of the shape.
        parent: the joint that moves the link, or "torso".
        kind: "sphere", "cylinder" or "box".
        size_m: (radius,), (radius, length) or the three edge lengths [m].
        center_m: centre in the joint frame [m].
        axis: direction of a cylinder's axis, not yet normalised.

    Examples:
        >>> row = nk.parameters.nao_parameters("v6").collision_shapes[0]
        >>> row.kind, row.size_m
        ('sphere', (0.04,))
    """

    name: str
    parent: str
    kind: ShapeKind
    size_m: tuple[float, ...]
    center_m: Vector
    axis: Vector
    source: str


@dataclass(frozen=True)
class VisualRow(VersionedRow):
    """The meshes of one link: a file per colour, in the frame of the joint that moves the link.

    Attributes:
        parent: the joint that moves the link, "torso", or a phalanx without its side ("Finger11").
        part: name of the part.
        colours: its colours; colour c stands in the file `{part}_{c}.obj`.

    Examples:
        >>> nk.parameters.nao_parameters("v6").visuals[0].part
        'torso'
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
    """A predefined posture.

    Attributes:
        name: NAOqi's name.
        body: the 26 joint values in NAOqi's Body order [rad; 0 to 1 for the hands].
    """

    name: str
    body: tuple[float, ...]
    source: str


# The public source behind each code that a row carries.
SOURCES: dict[str, str] = {
    "L6": "Aldebaran documentation 2.8, NAO6 links: doc.aldebaran.com/2-8/family/nao_technical/links_naov6.html",
    "L33": "Aldebaran documentation 2.5, H25 V3.3 links: family/nao_h25/links_h25_v33.html",
    "L32": "Aldebaran documentation 2.5, V3.2 links: family/robots/links_robot_v32.html",
    "J6": "Aldebaran documentation 2.8, NAO6 joints: doc.aldebaran.com/2-8/family/nao_technical/joints_naov6.html",
    "J32": "Aldebaran documentation 2.4, V3.2 joints: doc.aldebaran.com/2-4/family/nao_h21/joints_h21_v32.html",
    "BP6": "Aldebaran documentation 2.8, NAO6 body parts: doc.aldebaran.com/2-8/family/nao_technical/bodyparts_naov6.html",
    "U6": "official URDF NAOH25V60 as published in HULKs/hulk, webots/protos/NAO.urdf",
    "U5": "official URDF NAOH25V50 as published in ros-naoqi/nao_robot, nao_description/urdf/naoV50_generated_urdf",
    "U4": "official URDF NAOH25V40 as published in ros-naoqi/nao_robot, nao_description/urdf/naoV40_generated_urdf",
    "U33": "official URDF NAOH25V33 as published in ros-naoqi/nao_robot, nao_description/urdf/naoV33_generated_urdf",
    "U32": "official URDF NAOH25V32 as published in ros-naoqi/nao_robot, nao_description/urdf/naoV32_generated_urdf",
    "QB": "softbankrobotics-research/qibullet, qibullet/robot_posture.py (Apache-2.0)",
    "MIM": "ALMotion.getPosition recordings of LennonNM/NaoMimic: the foot height that makes both feet fit one HipYawPitch",
    "GEN": "drawn for this library",
}


# --- How the numbers of one version are laid over those of another.

_Row = TypeVar("_Row", bound=VersionedRow)


@dataclass(frozen=True, kw_only=True)
class Tables:
    """All rows of one version that another version may have otherwise.

    Attributes:
        offsets: the distances between the joints.
        limits: the ranges of the joints.
        actuators: their speeds and torques.
        inertials: mass and inertia of the links.
        frames: sensor and effector frames.
        visuals: the meshes of the links.
        placeholder: what links without a mass of their own are given; None for nothing.
    """

    offsets: tuple[OffsetRow, ...] = ()
    limits: tuple[LimitRow, ...] = ()
    actuators: tuple[ActuatorRow, ...] = ()
    inertials: tuple[InertialRow, ...] = ()
    frames: tuple[FrameRow, ...] = ()
    visuals: tuple[VisualRow, ...] = ()
    placeholder: InertialRow | None = None


@dataclass(frozen=True, kw_only=True)
class VersionPage(Tables):
    """What one version has otherwise than another one.

    A row stands in the place of the base's row of the same key. Frames and visuals may also come and go.

    Attributes:
        version: the version.
        base: the version that it is laid over.
        offsets: distances that differ; likewise limits, actuators and inertials.
        frames: frames that differ, and those that the base does not have.
        without_frames: names of the base's frames that it does not have.
        visuals: meshes that the base does not have, or has in other colours.
        without_visuals: keys, "joint/part", of the base's meshes that it does not have.
        placeholder: what links without a mass of their own are given; None for what the base gives.
    """

    version: Version
    base: Version
    without_frames: tuple[str, ...] = ()
    without_visuals: tuple[str, ...] = ()

    def over(self, base: Tables) -> Tables:
        """The tables of this version.

        Args:
            base: the tables of the version `base`.

        Raises:
            UnknownName: the page changes or leaves out a row that the base does not have.
        """
        tables: dict[str, Any] = {}
        for name in ("offsets", "limits", "actuators", "inertials", "frames", "visuals"):
            what = f"{name.removesuffix('s')} of {self.base}, which {self.version} is laid over"
            without = getattr(self, f"without_{name}", ())
            tables[name] = overlaid(what, getattr(base, name), getattr(self, name), without)
        return Tables(**tables, placeholder=self.placeholder or base.placeholder)


def overlaid(
    what: str, base: Iterable[_Row], changes: Sequence[_Row] = (), without: Sequence[str] = ()
) -> tuple[_Row, ...]:
    """The rows of `base` with some of them changed, left out or added.

    A new row stands where the first row of the same place was left out, or else after the last row of that place.

    Args:
        what: what the rows are, for messages.
        base: the rows of the version underneath.
        changes: rows that differ, and new rows.
        without: keys of the rows to leave out.

    Raises:
        UnknownName: `without` names a row that is not there, or a row is new in a table whose rows every version has.
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
            beside = [key for key, place in places.items() if place is not None and place == row.place]
            if not beside:
                raise UnknownName(what, row.key, tuple(rows))
            rows[next((key for key in beside if key in without), beside[-1])].append(row)
    return tuple(row for group in rows.values() for row in group)
