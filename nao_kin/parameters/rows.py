"""The kinds of rows the robot's numbers stand in: each with its unit, the robot versions it holds for, and its source."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Version = Literal["v3.2", "v3.3", "v4", "v5", "v6"]
VERSIONS: tuple[Version, ...] = ("v3.2", "v3.3", "v4", "v5", "v6")

# A coordinate is a number [m], or the name of an offset, with a minus sign where it points backwards.
Coordinate = float | str
Vector = tuple[float, float, float]
ShapeKind = Literal["sphere", "cylinder", "box"]


@dataclass(frozen=True)
class OffsetRow:
    """A distance between two joints.

    Attributes:
        name: Aldebaran's name of it.
        value_mm: length [mm].
    """

    name: str
    value_mm: float
    versions: tuple[Version, ...]
    source: str


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
class LimitRow:
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
    versions: tuple[Version, ...]
    source: str


@dataclass(frozen=True)
class ActuatorRow:
    """Speed and torque of one joint as the official URDF prints them.

    Attributes:
        joint: the joint.
        velocity: largest speed [rad/s; 1/s for a hand].
        effort: largest torque [N m].
    """

    joint: str
    velocity: float
    effort: float
    versions: tuple[Version, ...]
    source: str


@dataclass(frozen=True)
class CoupledLimitRow:
    """Range of one joint that depends on where another one stands: Aldebaran's anti-collision table.

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
class InertialRow:
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
    versions: tuple[Version, ...]
    source: str


@dataclass(frozen=True)
class FrameRow:
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
    versions: tuple[Version, ...]
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
    """

    name: str
    parent: str
    kind: ShapeKind
    size_m: tuple[float, ...]
    center_m: Vector
    axis: Vector
    source: str


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
