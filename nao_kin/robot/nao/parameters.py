"""The numbers of one NAO version in SI units, with all distances and names resolved."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TypeVar

from nao_kin._core.arrays import Vector, choice
from nao_kin.errors import UnknownName
from nao_kin.robot.nao.rows import (
    VERSIONS,
    ActuatorRow,
    CameraRow,
    Colour,
    Coordinate,
    InertialRow,
    LimitRow,
    ShapeRow,
    Version,
    VersionedRow,
    VersionTables,
    VisualRow,
)
from nao_kin.robot.nao.tables import (
    BODY_ALIASES,
    CAMERAS,
    COUPLED_LIMITS,
    FINGER_RATIO,
    FINGERS,
    FITTED_SHAPES,
    JOINTS,
    NAOQI_SHAPES,
    RESOLUTIONS,
    ROS_HANDS,
    ROS_JOINTS,
    ROS_LINKS,
    TABLES,
)
from nao_kin.robot.semantics import CoupledLimit, Mimic

_Row = TypeVar("_Row", bound=VersionedRow)


def _of_all_versions(table: Callable[[VersionTables], Iterable[_Row]]) -> tuple[_Row, ...]:
    """Return the rows of one table of all versions, each row once, with its versions.

    The rows of the newest version come in their order, each followed by those of older versions with the same key; rows
    that only older versions have come last.
    """
    held: dict[str, dict[_Row, list[Version]]] = {}
    for version in reversed(VERSIONS):
        for row in table(TABLES[version]):
            held.setdefault(row.key, {}).setdefault(row, []).insert(0, version)
    return tuple(replace(row, versions=tuple(found)) for rows in held.values() for row, found in rows.items())


# The rows of all versions, each with its versions.
OFFSETS = _of_all_versions(lambda tables: tables.offsets)
LIMITS = _of_all_versions(lambda tables: tables.limits)
ACTUATORS = _of_all_versions(lambda tables: tables.actuators)
INERTIALS = _of_all_versions(lambda tables: tables.inertials)
CAMERA_ROWS = _of_all_versions(lambda tables: tables.cameras)
FRAMES = _of_all_versions(lambda tables: tables.frames)
VISUALS = _of_all_versions(lambda tables: tables.visuals)
(PLACEHOLDER,) = _of_all_versions(lambda tables: (tables.placeholder,) if tables.placeholder else ())


@dataclass(frozen=True)
class Joint:
    """One joint of one version.

    Attributes:
        name: NAOqi's name.
        chain: NAOqi's chain.
        parent: the joint that carries it, or "torso".
        link: the link it moves.
        xyz: position in the parent's joint frame [m]; all joint frames are parallel to the torso at zero.
        axis: unit vector of the axis.
        lower: smallest value [rad; 1 for a hand].
        upper: largest value [rad; 1 for a hand].
        unit: "rad", or "1" for the opening of a hand.
        velocity: largest speed [rad/s; 1/s for a hand].
        effort: largest torque [N m].
        mimic: the joint whose motor also drives this one, at the same value; None for a joint with its own motor.
    """

    name: str
    chain: str
    parent: str
    link: str
    xyz: Vector
    axis: Vector
    lower: float
    upper: float
    unit: str
    velocity: float
    effort: float
    mimic: str | None


@dataclass(frozen=True)
class Finger:
    """The joint of one phalanx, which follows the opening of its hand: angle = multiplier · opening.

    Names begin with the hand, so that parsers that sort siblings by name find the driving joint first, as Pinocchio
    requires.

    Attributes:
        name: the joint, "LHandFinger11".
        phalanx: the phalanx without its side, "Finger11".
        parent: the joint that carries it: the wrist or the phalanx before.
        parent_link: the link that carries it.
        link: the link it moves, "LFinger11_link".
        driver: the joint of the hand, "LHand".
        multiplier: angle at opening 1 [rad].
        xyz: position in the parent's frame [m].
        rpy: orientation in the parent's frame at opening 0, R = Rz(yaw) Ry(pitch) Rx(roll) [rad].
        axis: unit vector of the axis, in the joint's own frame.
        lower: smallest angle [rad].
        upper: largest angle [rad].
        velocity: largest speed [rad/s].
        effort: largest torque [N m].
    """

    name: str
    phalanx: str
    parent: str
    parent_link: str
    link: str
    driver: str
    multiplier: float
    xyz: Vector
    rpy: Vector
    axis: Vector
    lower: float
    upper: float
    velocity: float
    effort: float


@dataclass(frozen=True)
class Frame:
    """One sensor or effector frame of one version.

    Attributes:
        name: NAOqi's name.
        ros_name: the official ROS link at the same place, if there is one.
        parent: the joint that carries it, or "torso".
        xyz: position in the parent's joint frame [m].
        rpy: orientation, R = Rz(yaw) Ry(pitch) Rx(roll) [rad].
    """

    name: str
    ros_name: str | None
    parent: str
    xyz: Vector
    rpy: Vector


@dataclass(frozen=True, repr=False)
class NaoParameters:
    """The numbers of one NAO version, SI units.

    Inertias, cameras, meshes and shapes also have the code of their `source`, a key of `SOURCES`, and, if they may
    differ between versions, the `versions` that have them.

    Attributes:
        version: one of `nk.parameters.VERSIONS`.
        offsets: Aldebaran's named distances [m].
        joints: the 26 joints in NAOqi's Body order, each with its `name`, `chain`, `parent` (a joint, or "torso"),
            `link`, position `xyz` in the parent's joint frame [m], unit vector `axis`, `lower`, `upper`, `unit` ("rad",
            or "1" for a hand), `velocity`, `effort` [N m] and `mimic`, the joint that it follows, or None.
        fingers: the 16 phalanges, left hand first, each after the phalanx that carries it, with `name`, `phalanx`,
            `parent`, `parent_link`, `link`, `driver` (the joint of the hand), `multiplier` (angle at opening 1 [rad]),
            `xyz` [m], `rpy` [rad], `axis`, `lower`, `upper`, `velocity` and `effort`.
        inertials: mass and inertia by the joint that moves the link, and "torso": `mass_kg`, centre of mass `com_m` in
            the joint frame, and `inertia`, ixx, ixy, ixz, iyy, iyz, izz about the centre of mass [kg m²].
        placeholder: inertia of links without a published mass; None for no inertia.
        frames: sensor and effector frames, each with its `name`, `ros_name`, `parent` (a joint, or "torso"), and its
            place in the parent's joint frame, `xyz` [m] and `rpy` [rad].
        cameras: the cameras, each with the name of its frame `camera`, its `sensor`, `field_of_view_deg` (horizontal
            and vertical [deg]) and `largest`, the name of its largest resolution.
        resolutions: name → width and height of the images that both cameras give [pixel].
        coupled_limits: the anti-collision tables.
        visuals: the meshes of the links, each with its `parent` (the joint that moves the link, "torso", or a phalanx
            without its side), `part`, `colours`, and the names `meshes` of its files.
        colours: the colours of the meshes, red, green, blue and opacity by name.
        collision_shapes: shapes that contain the meshes, for collisions, each with its `name`, `parent` (a joint, or
            "torso"), `kind` ("sphere", "cylinder", "capsule" or "box"), `size_m` (radius; radius and length; or edge
            lengths), `center_m` in the joint frame, and `axis`.
        naoqi_shapes: NAOqi's collision primitives, likewise.

    Examples:
        >>> parameters = nk.parameters.nao_parameters("v6")
        >>> parameters.offsets["ThighLength"], len(parameters.joints), parameters.joint("HeadYaw").axis
        (0.1, 26, (0.0, 0.0, 1.0))
        >>> parameters.frame("CameraTop").xyz
        (0.05871, 0.0, 0.06364)
    """

    version: Version
    offsets: Mapping[str, float]
    joints: tuple[Joint, ...]
    fingers: tuple[Finger, ...]
    inertials: Mapping[str, InertialRow]
    placeholder: InertialRow | None
    frames: tuple[Frame, ...]
    cameras: tuple[CameraRow, ...]
    resolutions: Mapping[str, tuple[int, int]]
    coupled_limits: tuple[CoupledLimit, ...]
    visuals: tuple[VisualRow, ...]
    colours: Mapping[str, Colour]
    collision_shapes: tuple[ShapeRow, ...]
    naoqi_shapes: tuple[ShapeRow, ...]

    def __repr__(self) -> str:
        return (
            f"<NaoParameters {self.version}: {len(self.joints)} joints, {len(self.fingers)} phalanges, "
            f"{len(self.frames)} frames, {self.mass:.3f} kg>"
        )

    @property
    def mass(self) -> float:
        """Mass of all bodies [kg], without the placeholders of massless links, 0.05 g in all."""
        return math.fsum(row.mass_kg for row in self.inertials.values())

    @property
    def mimics(self) -> Mapping[str, Mimic]:
        """The joints without their own motor, and the joints they follow: `RHipYawPitch` and the phalanges."""
        joints = {joint.name: Mimic(joint.mimic) for joint in self.joints if joint.mimic is not None}
        return MappingProxyType(joints | {row.name: Mimic(row.driver, row.multiplier) for row in self.fingers})

    def joint(self, name: str) -> Joint:
        """Return the joint with this name, one of `joints`."""
        return _named("joint", self.joints, name)

    def frame(self, name: str) -> Frame:
        """Return the sensor or effector frame with this name of NAOqi, one of `frames`."""
        return _named("frame", self.frames, name)


_Named = TypeVar("_Named", Joint, Frame)


def _named(kind: str, rows: Sequence[_Named], name: str) -> _Named:
    by_name = {row.name: row for row in rows}
    return by_name[choice(name, by_name, kind)]


def version_named(name: str) -> Version:
    """Return the version of a name, such as "v6", "V6", "6", "6.0", "3.2"; only a minor number of 0 is optional."""
    wanted = str(name).strip().lower().removeprefix("v")
    for version in VERSIONS:
        number = version.removeprefix("v")
        if wanted == number or ("." not in number and wanted == f"{number}.0"):
            return version
    is_file = wanted.endswith((".urdf", ".xml", ".xacro"))
    raise UnknownName("NAO version", name, VERSIONS, "RobotModel.from_file reads a file" if is_file else "")


def nao_parameters(version: str = "v6") -> NaoParameters:
    """Return the parameters of one version.

    Examples:
        >>> nk.parameters.nao_parameters("v3.2").version
        'v3.2'
    """
    return _gathered(version_named(version))


@functools.cache
def _gathered(version: Version) -> NaoParameters:
    tables = TABLES[version]
    offsets = {row.name: row.value_mm / 1000 for row in tables.offsets}
    joints = tuple(_joints(offsets, tables.limits, tables.actuators))
    return NaoParameters(
        version=version,
        offsets=MappingProxyType(offsets),
        joints=joints,
        fingers=tuple(finger for joint in joints if joint.unit == "1" for finger in _fingers(joint, joints)),
        inertials=MappingProxyType({row.link: row for row in INERTIALS if version in row.versions}),
        placeholder=PLACEHOLDER if version in PLACEHOLDER.versions else None,
        frames=tuple(
            Frame(row.name, row.ros_name, row.parent, _resolved(row.xyz, offsets), row.rpy) for row in tables.frames
        ),
        cameras=tuple(row for row in CAMERA_ROWS if version in row.versions),
        resolutions=MappingProxyType(_up_to(tables.cameras[0].largest)),
        coupled_limits=tuple(
            CoupledLimit(
                row.joint, row.of, *(tuple(map(math.radians, column)) for column in zip(*row.table_deg, strict=True))
            )
            for row in COUPLED_LIMITS
        ),
        visuals=tuple(row for row in VISUALS if version in row.versions),
        colours=MappingProxyType(dict(tables.colours)),
        collision_shapes=FITTED_SHAPES,
        naoqi_shapes=NAOQI_SHAPES,
    )


def _joints(
    offsets: Mapping[str, float], limits: Iterable[LimitRow], actuators: Iterable[ActuatorRow]
) -> Iterator[Joint]:
    limit_of = {row.joint: row for row in limits}
    actuator_of = {row.joint: row for row in actuators}
    for row in JOINTS:
        limit, actuator = limit_of[row.mimic or row.name], actuator_of[row.mimic or row.name]
        turns = limit.unit == "deg"
        yield Joint(
            name=row.name,
            chain=row.chain,
            parent=row.parent,
            link=row.link,
            xyz=_resolved(row.origin, offsets),
            axis=_unit(row.axis),
            lower=math.radians(limit.lower) if turns else limit.lower,
            upper=math.radians(limit.upper) if turns else limit.upper,
            unit="rad" if turns else limit.unit,
            velocity=actuator.velocity,
            effort=actuator.effort,
            mimic=row.mimic,
        )


def _up_to(largest: str) -> dict[str, tuple[int, int]]:
    """Return name → size of the resolutions up to the largest one of a sensor."""
    names = [row.name for row in RESOLUTIONS]
    return {row.name: (row.width, row.height) for row in RESOLUTIONS[: names.index(largest) + 1]}


def _fingers(hand: Joint, joints: Iterable[Joint]) -> Iterator[Finger]:
    """Yield the phalanges of one hand."""
    side = hand.name[0]
    (wrist_link,) = (joint.link for joint in joints if joint.name == hand.parent)
    for row in FINGERS:
        at_wrist = row.parent == "WristYaw"
        yield Finger(
            name=f"{hand.name}{row.name}",
            phalanx=row.name,
            parent=hand.parent if at_wrist else f"{hand.name}{row.parent}",
            parent_link=wrist_link if at_wrist else f"{side}{row.parent}_link",
            link=f"{side}{row.name}_link",
            driver=hand.name,
            multiplier=FINGER_RATIO,
            xyz=row.xyz_m,
            rpy=row.rpy,
            axis=(0.0, 0.0, 1.0),
            lower=0.0,
            upper=FINGER_RATIO,
            velocity=FINGER_RATIO * hand.velocity,
            effort=hand.effort,
        )


def _resolved(xyz: tuple[Coordinate, Coordinate, Coordinate], offsets: Mapping[str, float]) -> Vector:
    x, y, z = (at if isinstance(at, float) else _signed(at, offsets) for at in xyz)
    return x, y, z


def _signed(name: str, offsets: Mapping[str, float]) -> float:
    """Return the length of an offset, negative after a minus sign."""
    return -offsets[name[1:]] if name.startswith("-") else offsets[name]


def _unit(axis: Vector) -> Vector:
    length = math.hypot(*axis)
    x, y, z = (component / length for component in axis)
    return x, y, z


# --- The names of links and joints in ros-naoqi's `nao_description`, where they differ from those of this package.


def ros_names(parameters: NaoParameters) -> dict[str, str]:
    """Return name in the URDF of this package → name in `nao_description`, for the robot, its links and its joints.

    Two links that get the same name are one link in `nao_description`; in the URDF of this package the second link has
    NAOqi's name for the same frame.

    Args:
        parameters: the numbers of a version.

    Examples:
        >>> names = nk.parameters.ros_names(nk.parameters.nao_parameters("v6"))
        >>> names["CameraTop"], names["CameraTop_fixed"], names["LHandThumb1"]
        ('CameraTop_frame', 'CameraTop_sensor_fixedjoint', 'LThumb1')
    """
    digits = f"{parameters.version.removeprefix('v').replace('.', '')}0"[:2]
    names = {f"nao_{parameters.version}": f"NaoH25V{digits}"} | BODY_ALIASES | ROS_LINKS
    for frame in parameters.frames:
        if frame.ros_name is not None:
            names |= {frame.name: frame.ros_name, f"{frame.name}_fixed": f"{frame.name}_sensor_fixedjoint"}
    for camera in CAMERAS:
        names[f"{camera}_optical_frame_fixed"] = f"{camera}_optical_frame_fixedjoint"
    for finger in parameters.fingers:
        names[finger.name] = finger.name.replace("Hand", "", 1)
    del names["LArm"], names["RArm"], names["LArm_fixed"], names["RArm_fixed"]
    return names | ROS_HANDS | ROS_JOINTS
