"""The parameters of one version, gathered from the rows."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Iterator, Mapping
from types import MappingProxyType

from nao_kin.errors import UnknownName
from nao_kin.parameters.bodies import COLLISION_SHAPES
from nao_kin.parameters.overlay import with_versions
from nao_kin.parameters.ranges import COUPLED_LIMITS
from nao_kin.parameters.robot_parameters import Finger, Frame, Joint, NaoParameters
from nao_kin.parameters.rows import (
    VERSIONS,
    ActuatorRow,
    Coordinate,
    FrameRow,
    InertialRow,
    LimitRow,
    OffsetRow,
    Vector,
    Version,
    VisualRow,
)
from nao_kin.parameters.skeleton import FINGER_RATIO, FINGERS, JOINTS
from nao_kin.parameters.versions import TABLES
from nao_kin.semantics import CoupledLimit

# The rows of all versions, each with the versions it holds for.
OFFSETS: tuple[OffsetRow, ...] = with_versions({version: tables.offsets for version, tables in TABLES.items()})
LIMITS: tuple[LimitRow, ...] = with_versions({version: tables.limits for version, tables in TABLES.items()})
ACTUATORS: tuple[ActuatorRow, ...] = with_versions({version: tables.actuators for version, tables in TABLES.items()})
INERTIALS: tuple[InertialRow, ...] = with_versions({version: tables.inertials for version, tables in TABLES.items()})
FRAMES: tuple[FrameRow, ...] = with_versions({version: tables.frames for version, tables in TABLES.items()})
VISUALS: tuple[VisualRow, ...] = with_versions({version: tables.visuals for version, tables in TABLES.items()})
(PLACEHOLDER,) = with_versions(
    {version: (tables.placeholder,) if tables.placeholder else () for version, tables in TABLES.items()}
)


def version_named(name: str) -> Version:
    """The version called `name`, whatever its letter case and with or without the v: "v6", "V6", "6", "6.0", "3.2".

    The minor number is written where there is one and may be written as 0 where there is none; nothing follows it.

    Raises:
        UnknownName: no such version.
    """
    wanted = str(name).strip().lower().removeprefix("v")
    for version in VERSIONS:
        number = version.removeprefix("v")
        if wanted == number or ("." not in number and wanted == f"{number}.0"):
            return version
    raise UnknownName("NAO version", name, VERSIONS)


def nao_parameters(version: str = "v6") -> NaoParameters:
    """The parameters of one version.

    Raises:
        UnknownName: no such version.
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
        coupled_limits=tuple(
            CoupledLimit(
                row.joint, row.of, *(tuple(map(math.radians, column)) for column in zip(*row.table_deg, strict=True))
            )
            for row in COUPLED_LIMITS
        ),
        visuals=tuple(row for row in VISUALS if version in row.versions),
        collision_shapes=COLLISION_SHAPES,
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


def _fingers(hand: Joint, joints: Iterable[Joint]) -> Iterator[Finger]:
    """The phalanges of one hand."""
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
    x, y, z = (_metres(coordinate, offsets) for coordinate in xyz)
    return x, y, z


def _metres(coordinate: Coordinate, offsets: Mapping[str, float]) -> float:
    return coordinate if isinstance(coordinate, float) else coordinate.sign * offsets[coordinate.name]


def _unit(axis: Vector) -> Vector:
    length = math.hypot(*axis)
    x, y, z = (component / length for component in axis)
    return x, y, z
