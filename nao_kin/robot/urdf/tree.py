"""What a URDF says once it has been read: links, joints, inertias and looks, as numbers."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar
from xml.etree import ElementTree as ET

import numpy as np

from nao_kin._core.arrays import Floats, Vector, join_poses
from nao_kin._core.text import abbreviated, fresh_name, quoted
from nao_kin.robot.semantics import Mimic
from nao_kin.robot.urdf.document import Packages, finite_numbers
from nao_kin.rotations import exp, matrix_from_rpy

# --- The `<visual>` and `<collision>` elements of a URDF as data: where each stands, what it is, what colour it has.

Rgba = tuple[float, float, float, float]


class UnreadableShape(Exception):
    """Why a shape of a link is left out: its element or its mesh file cannot be read.

    Examples:
        >>> raise nk.urdf.UnreadableShape("its mesh 'hand.stl' is not there")
        Traceback (most recent call last):
        nao_kin.robot.urdf.tree.UnreadableShape: its mesh 'hand.stl' is not there
    """


@dataclass(frozen=True)
class Origin:
    """A pose as a URDF writes it.

    Attributes:
        xyz: position [m].
        rpy: orientation, R = Rz(yaw) Ry(pitch) Rx(roll) [rad].

    Examples:
        >>> nk.urdf.Origin(xyz=(0.0, 0.0, 0.1)).rpy
        (0.0, 0.0, 0.0)
    """

    xyz: Vector = (0.0, 0.0, 0.0)
    rpy: Vector = (0.0, 0.0, 0.0)

    @property
    def matrix(self) -> Floats:
        """The pose as a matrix, shape (4, 4) [m].

        Examples:
            >>> nk.urdf.Origin(xyz=(0.0, 0.0, 0.1)).matrix[:3, 3]
            array([0. , 0. , 0.1])
        """
        return join_poses(matrix_from_rpy(self.rpy), np.array(self.xyz))


@dataclass(frozen=True)
class Box:
    """A box with its centre at the origin; edge lengths along x, y, z [m].

    Examples:
        >>> nk.urdf.Box((0.1, 0.2, 0.3)).size
        (0.1, 0.2, 0.3)
    """

    size: Vector


@dataclass(frozen=True)
class Cylinder:
    """A cylinder about z with its centre at the origin [m].

    Examples:
        >>> nk.urdf.Cylinder(radius=0.02, length=0.1).length
        0.1
    """

    radius: float
    length: float


@dataclass(frozen=True)
class Sphere:
    """A sphere about the origin [m].

    Examples:
        >>> nk.urdf.Sphere(0.05).radius
        0.05
    """

    radius: float


@dataclass(frozen=True)
class MeshFile:
    """A mesh by the name that the URDF has for its file, scaled along its axes.

    Examples:
        >>> nk.urdf.MeshFile("meshes/torso.stl").scale
        (1.0, 1.0, 1.0)
    """

    filename: str
    scale: Vector = (1.0, 1.0, 1.0)


Geometry = Box | Cylinder | Sphere | MeshFile
_Shape = TypeVar("_Shape")


@dataclass(frozen=True)
class Visual:
    """A visual of a link as read.

    Attributes:
        link: name of the link.
        origin: pose of the shape in the link's frame.
        geometry: what it is.
        material: name of its material, "" without one.
        rgba: colour and opacity of that material, each in [0, 1]; None where the URDF gives none.
        name: its own name, "" without one.

    Examples:
        >>> tree = nk.load_nao().tree
        >>> visual = tree.visuals[0]
        >>> visual.link, type(visual.geometry).__name__
        ('torso', 'MeshFile')
    """

    link: str
    origin: Origin
    geometry: Geometry
    material: str = ""
    rgba: Rgba | None = None
    name: str = ""


@dataclass(frozen=True)
class Collision:
    """A shape of a link that stands for it in contacts, as read.

    Attributes:
        link: name of the link.
        origin: pose of the shape in the link's frame.
        geometry: what it is.
        name: its own name, "" without one.

    Examples:
        >>> shape = nk.load_nao().tree.collisions[0]
        >>> shape.link, shape.geometry
        ('torso', Sphere(radius=0.04))
    """

    link: str
    origin: Origin
    geometry: Geometry
    name: str = ""


def read_visuals(
    document: ET.Element, links: Iterable[tuple[str, ET.Element]]
) -> tuple[tuple[Visual, ...], tuple[str, ...]]:
    """The visuals of a URDF, and one line for each that cannot be read: looks never keep a robot from loading.

    Args:
        document: the `<robot>`, which may name materials.
        links: name and element of each link.
    """
    colours = {material.get("name", ""): rgba for material in document.findall("material") if (rgba := _rgba(material))}

    def visual(link: str, element: ET.Element) -> Visual:
        material = element.find("material")
        name = "" if material is None else material.get("name", "")
        rgba = None if material is None else _rgba(material) or colours.get(name)
        return Visual(link, *_placed(element), name, rgba, element.get("name", ""))

    return _read_shapes(links, "visual", visual, "a visual of {} is not shown")


def read_collisions(links: Iterable[tuple[str, ET.Element]]) -> tuple[tuple[Collision, ...], tuple[str, ...]]:
    """The collision shapes of a URDF, and one line for each that cannot be read.

    Args:
        links: name and element of each link.
    """

    def collision(link: str, element: ET.Element) -> Collision:
        return Collision(link, *_placed(element), element.get("name", ""))

    return _read_shapes(links, "collision", collision, "a collision shape of {} is left out")


def _read_shapes(
    links: Iterable[tuple[str, ET.Element]], tag: str, read: Callable[[str, ET.Element], _Shape], left_out: str
) -> tuple[tuple[_Shape, ...], tuple[str, ...]]:
    shapes, notes = list[_Shape](), list[str]()
    for link, element in links:
        for part in element.findall(tag):
            try:
                shapes.append(read(link, part))
            except UnreadableShape as reason:
                notes.append(f"{left_out.format(abbreviated(link))}: {reason}")
    return tuple(shapes), tuple(notes)


def _placed(element: ET.Element) -> tuple[Origin, Geometry]:
    """Where the shape of a visual or a collision stands, and what it is."""
    geometry = element.find("geometry")
    shape = next(iter(geometry), None) if geometry is not None else None
    if shape is None:
        raise UnreadableShape("no geometry")
    origin = element.find("origin")
    place = Origin() if origin is None else Origin(_vector(origin, "xyz", "0 0 0"), _vector(origin, "rpy", "0 0 0"))
    return place, _geometry(shape)


def _geometry(shape: ET.Element) -> Geometry:
    if shape.tag == "box":
        return Box(_vector(shape, "size"))
    if shape.tag == "cylinder":
        return Cylinder(_numbers(shape, "radius", 1)[0], _numbers(shape, "length", 1)[0])
    if shape.tag == "sphere":
        return Sphere(_numbers(shape, "radius", 1)[0])
    if shape.tag == "mesh":
        return MeshFile(shape.get("filename", ""), _vector(shape, "scale", "1 1 1"))
    raise UnreadableShape(f"geometry {quoted(shape.tag)} is unknown")


def _rgba(material: ET.Element) -> Rgba | None:
    colour = material.find("color")
    if colour is None:
        return None
    try:
        r, g, b, a = (min(max(value, 0.0), 1.0) for value in _numbers(colour, "rgba", 4))
    except UnreadableShape:
        return None
    return r, g, b, a


def _vector(element: ET.Element, attribute: str, default: str = "") -> Vector:
    x, y, z = _numbers(element, attribute, 3, default)
    return x, y, z


def _numbers(element: ET.Element, attribute: str, count: int, default: str = "") -> list[float]:
    text = element.get(attribute, default)
    values = finite_numbers(text)
    if len(values) != count:
        raise UnreadableShape(f"{element.tag} has {attribute} {quoted(text)}, expected {count} finite numbers")
    return values


# --- What a URDF says once it has been read: links, joints, inertias and looks, as numbers.


@dataclass(frozen=True)
class Inertial:
    """Mass and inertia of a link as read.

    Attributes:
        mass: mass [kg].
        origin: centre of mass, and the axes of the tensor, in the link's frame.
        inertia: ixx, ixy, ixz, iyy, iyz, izz about the centre of mass [kg m²].

    Examples:
        >>> tree = nk.load_nao().tree
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
        >>> tree = nk.load_nao().tree
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

    @property
    def coupling(self) -> Mimic:
        """How it follows a coordinate: a joint of its own follows itself."""
        return self.mimic or Mimic(self.name)

    def travel(self, value: float) -> Floats:
        """Return the pose of the joint's frame at a value, in its frame at zero, shape (4, 4).

        Examples:
            >>> joint = nk.load_nao().tree.moving_joints[0]
            >>> joint.travel(np.pi / 2)[:3, 0].round(9).tolist()
            [0.0, 1.0, 0.0]
        """
        T = np.eye(4)
        if self.kind == "prismatic":
            T[:3, 3] = value * np.array(self.axis)
        elif value:
            T[:3, :3] = exp(value * np.array(self.axis))
        return T


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
        >>> tree = nk.load_nao().tree
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
        return tuple([joint for joint in self.joints if joint.kind != "fixed"])

    @property
    def mimics(self) -> dict[str, Mimic]:
        """The joints that follow another one, by name."""
        return {joint.name: joint.mimic for joint in self.joints if joint.mimic is not None}


# --- Names that no two parts of a robot share.


def names_apart(links: Iterable[str], joints: Iterable[str], notes: list[str]) -> dict[str, str]:
    """New names for links that share theirs with a joint: "…_link", or "…_frame" where that is taken.

    Args:
        links: names of the links.
        joints: names of the joints.
        notes: gets a line for each.
    """
    links, joints = tuple(links), frozenset(joints)
    taken = joints.union(links)
    renamed: dict[str, str] = {}
    for name in links:
        if name in joints:
            renamed[name] = fresh_name(name, taken, "_link", "_frame")
            notes.append(f"link {quoted(name)} renamed {quoted(renamed[name])}: a joint has the same name")
    return renamed
