"""All parameters of one NAO version, in SI units, gathered from the rows."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Protocol, TypeVar

from nao_kin.errors import UnknownName
from nao_kin.parameters.frames import FRAMES
from nao_kin.parameters.inertials import INERTIALS
from nao_kin.parameters.joints import JOINTS
from nao_kin.parameters.limits import ACTUATORS, COUPLED_LIMITS, LIMITS
from nao_kin.parameters.offsets import OFFSETS
from nao_kin.parameters.rows import VERSIONS, Coordinate, InertialRow, Vector, Version
from nao_kin.semantics import CoupledLimit


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
        mimic: the joint whose motor drives this one too, at the same value; None for a motor of its own.
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


@dataclass(frozen=True)
class NaoParameters:
    """The numbers of one NAO version, SI units.

    Attributes:
        version: "v3.2" … "v6".
        offsets: Aldebaran's named distances [m].
        joints: the 26 joints in NAOqi's Body order.
        inertials: mass, centre of mass and inertia by the joint that moves the link, and "torso".
        frames: sensor and effector frames.
        coupled_limits: the anti-collision tables.
    """

    version: Version
    offsets: Mapping[str, float]
    joints: tuple[Joint, ...]
    inertials: Mapping[str, InertialRow]
    frames: tuple[Frame, ...]
    coupled_limits: tuple[CoupledLimit, ...]

    @property
    def mass(self) -> float:
        """Mass of all bodies [kg]; the placeholders of massless links, 0.05 g in all, not counted."""
        return math.fsum(row.mass_kg for row in self.inertials.values())


class _Versioned(Protocol):
    @property
    def versions(self) -> tuple[Version, ...]: ...


_Row = TypeVar("_Row", bound=_Versioned)


def version_named(name: str) -> Version:
    """The version called `name`, whatever its letter case and with or without the v.

    Raises:
        UnknownName: no such version.
    """
    wanted = str(name).strip().lower()
    for version in VERSIONS:
        if wanted in (version, version[1:], f"{version}.0", f"{version[1:]}.0"):
            return version
    raise UnknownName("NAO version", name, VERSIONS)


@functools.cache
def nao_parameters(version: str = "v6") -> NaoParameters:
    """The parameters of one version.

    Raises:
        UnknownName: no such version.
    """
    known = version_named(version)
    offsets = {row.name: row.value_mm / 1000 for row in _of(OFFSETS, known)}

    def resolve(xyz: tuple[Coordinate, Coordinate, Coordinate]) -> Vector:
        x, y, z = (_metres(coordinate, offsets) for coordinate in xyz)
        return x, y, z

    limits = {row.joint: row for row in _of(LIMITS, known)}
    actuators = {row.joint: row for row in _of(ACTUATORS, known)}
    joints = []
    for row in JOINTS:
        limit, actuator = limits[row.mimic or row.name], actuators[row.mimic or row.name]
        turns = limit.unit == "deg"
        joints.append(
            Joint(
                name=row.name,
                chain=row.chain,
                parent=row.parent,
                link=row.link,
                xyz=resolve(row.origin),
                axis=_unit(row.axis),
                lower=math.radians(limit.lower) if turns else limit.lower,
                upper=math.radians(limit.upper) if turns else limit.upper,
                unit="rad" if turns else limit.unit,
                velocity=actuator.velocity,
                effort=actuator.effort,
                mimic=row.mimic,
            )
        )
    return NaoParameters(
        version=known,
        offsets=MappingProxyType(offsets),
        joints=tuple(joints),
        inertials=MappingProxyType({row.link: row for row in _of(INERTIALS, known)}),
        frames=tuple(
            Frame(row.name, row.ros_name, row.parent, resolve(row.xyz), row.rpy) for row in _of(FRAMES, known)
        ),
        coupled_limits=tuple(
            CoupledLimit(
                row.joint, row.of, *(tuple(map(math.radians, column)) for column in zip(*row.table_deg, strict=True))
            )
            for row in COUPLED_LIMITS
        ),
    )


def _of(rows: Iterable[_Row], version: Version) -> list[_Row]:
    return [row for row in rows if version in row.versions]


def _metres(coordinate: Coordinate, offsets: Mapping[str, float]) -> float:
    if isinstance(coordinate, str):
        return -offsets[coordinate[1:]] if coordinate.startswith("-") else offsets[coordinate]
    return coordinate


def _unit(axis: Vector) -> Vector:
    length = math.hypot(*axis)
    x, y, z = (component / length for component in axis)
    return x, y, z
