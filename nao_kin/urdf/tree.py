"""What a URDF says once it has been read: links, joints, inertias and looks, as numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from types import MappingProxyType
from typing import Any

from nao_kin.semantics import Mimic
from nao_kin.urdf.packages import Packages
from nao_kin.urdf.visuals import Collision, Origin, Visual


@dataclass(frozen=True)
class Inertial:
    """Mass and inertia of a link as read.

    Attributes:
        mass: mass [kg].
        origin: centre of mass, and the axes of the tensor, in the link's frame.
        inertia: ixx, ixy, ixz, iyy, iyz, izz about the centre of mass [kg m²].

    Examples:
        >>> tree = nk.urdf.read_urdf(nk.load_nao().urdf_path)
        >>> tree.inertials["torso"].mass
        1.04956
    """

    mass: float
    origin: Origin
    inertia: tuple[float, float, float, float, float, float]


@dataclass(frozen=True)
class UrdfJoint:
    """A joint as read.

    Attributes:
        name: its name.
        kind: "revolute", "prismatic" or "fixed"; a `continuous` joint is a revolute one without limits.
        parent: the link that carries it.
        child: the link it moves.
        origin: its frame, with the joint at zero, in the parent link's frame.
        axis: unit vector of the axis.
        lower: smallest value [rad or m].
        upper: largest value [rad or m].
        velocity: largest speed.
        effort: largest torque or force.
        damping: viscous torque or force per unit of speed.
        friction: dry friction torque or force.
        mimic: the joint it follows, None for a joint of its own.

    Examples:
        >>> tree = nk.urdf.read_urdf(nk.load_nao().urdf_path)
        >>> joint = next(joint for joint in tree.joints if joint.name == "RHipYawPitch")
        >>> joint.kind, joint.mimic.joint
        ('revolute', 'LHipYawPitch')
    """

    name: str
    kind: str
    parent: str
    child: str
    origin: Origin
    axis: tuple[float, float, float] = (1.0, 0.0, 0.0)
    lower: float = -math.inf
    upper: float = math.inf
    velocity: float = math.inf
    effort: float = math.inf
    damping: float = 0.0
    friction: float = 0.0
    mimic: Mimic | None = None


@dataclass(frozen=True)
class UrdfTree:
    """A URDF as read and mended.

    Attributes:
        path: the file.
        name: name of the robot.
        root: the link that no joint moves.
        links: link names in order of the file.
        inertials: mass and inertia of each link that has them.
        joints: all joints, every driving joint before those that follow it, as a depth-first walk meets them.
        visuals: what the links look like.
        shared_names: name that the file gives to a link and to a joint → the name the link has here.
        notes: what was changed, one line each.
        visual_notes: what of the looks cannot be read, one line each.
        collisions: the shapes that stand for the links in contacts.
        collision_notes: what of them cannot be read, one line each.
        package_dirs: folders in which packages that the file names are searched first.
        expanded: the URDF that the file became, where the file is a xacro source; "" where it is what was read.
        offsets: joints whose origin is calibrated and not that of the file → the origin they have here.

    Examples:
        >>> tree = nk.urdf.read_urdf(nk.load_nao().urdf_path)
        >>> tree.name, tree.root
        ('nao_v6', 'base_link')
    """

    path: Path
    name: str
    root: str
    links: tuple[str, ...]
    inertials: Mapping[str, Inertial] = field(repr=False)
    joints: tuple[UrdfJoint, ...] = field(repr=False)
    visuals: tuple[Visual, ...] = field(repr=False)
    shared_names: Mapping[str, str] = field(repr=False)
    notes: tuple[str, ...]
    visual_notes: tuple[str, ...] = field(default=(), repr=False)
    collisions: tuple[Collision, ...] = field(default=(), repr=False)
    collision_notes: tuple[str, ...] = field(default=(), repr=False)
    package_dirs: tuple[Path, ...] = field(default=(), repr=False)
    expanded: str = field(default="", repr=False)
    offsets: Mapping[str, Origin] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        # One tree serves every robot made of it.
        for name in ("inertials", "shared_names", "offsets"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))

    def __reduce__(self) -> tuple[Any, ...]:
        # Mapping proxies do not pickle.
        values = (getattr(self, field.name) for field in fields(self))
        return UrdfTree, tuple(dict(value) if isinstance(value, MappingProxyType) else value for value in values)

    @property
    def packages(self) -> Packages:
        """The search for the mesh files that the file names."""
        return Packages(self.path, self.package_dirs)

    @property
    def moving_joints(self) -> tuple[UrdfJoint, ...]:
        """The joints that are not fixed."""
        return tuple(joint for joint in self.joints if joint.kind != "fixed")

    @property
    def mimics(self) -> dict[str, Mimic]:
        """The joints that follow another one, by name."""
        return {joint.name: joint.mimic for joint in self.joints if joint.mimic is not None}
