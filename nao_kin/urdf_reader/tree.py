"""What a URDF says once it has been read: a tree of joints, each tied to at most one other."""

from __future__ import annotations

import math
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: value = multiplier · value of the driving joint + offset.

    Attributes:
        joint: the driving joint.
        multiplier: ratio of the two values.
        offset: value when the driving joint is at zero.
    """

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class UrdfInertial:
    """Mass and inertia of a link as read.

    Attributes:
        mass: mass [kg].
        xyz: centre of mass in the link's frame [m].
        rpy: orientation of the axes of the tensor in the link's frame [rad].
        inertia: ixx, ixy, ixz, iyy, iyz, izz about the centre of mass [kg m²].
    """

    mass: float
    xyz: tuple[float, float, float]
    rpy: tuple[float, float, float]
    inertia: tuple[float, float, float, float, float, float]


@dataclass(frozen=True)
class UrdfJoint:
    """A joint as read.

    Attributes:
        name: its name.
        kind: "revolute", "prismatic" or "fixed"; a `continuous` joint is a revolute one without limits.
        parent: the link that carries it.
        child: the link it moves.
        xyz: position in the parent link's frame [m], three numbers as text.
        rpy: orientation in the parent link's frame [rad], three numbers as text.
        axis: unit vector of the axis.
        lower: smallest value [rad or m].
        upper: largest value [rad or m].
        velocity: largest speed.
        effort: largest torque or force.
        mimic: the coupling to another joint, None for a joint of its own.
    """

    name: str
    kind: str
    parent: str
    child: str
    xyz: str
    rpy: str
    axis: tuple[float, float, float]
    lower: float = -math.inf
    upper: float = math.inf
    velocity: float = math.inf
    effort: float = math.inf
    mimic: Mimic | None = None


@dataclass(frozen=True)
class UrdfTree:
    """A URDF as read and mended.

    Attributes:
        name: name of the robot.
        root: the link that no joint moves.
        links: link names in order of the file.
        inertials: mass and inertia of each link that has them.
        joints: all joints, every driving joint before those that follow it, as a depth-first walk meets them.
        notes: what was changed, one line each.
    """

    name: str
    root: str
    links: tuple[str, ...]
    inertials: dict[str, UrdfInertial] = field(repr=False)
    joints: tuple[UrdfJoint, ...]
    notes: tuple[str, ...]
