"""The contents of a URDF: links, joints, inertias and shapes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from types import MappingProxyType
from typing import IO, Any
from xml.etree import ElementTree as ET

import numpy as np

from nao_kin._core.arrays import Floats, Vector, join_poses
from nao_kin._core.text import abbreviated, fresh_name, one_line_repr, quoted
from nao_kin.robot.semantics import Mimic
from nao_kin.robot.urdf.document import Packages, finite_numbers
from nao_kin.rotations import exp, matrix_from_quat, matrix_from_rpy, quat_from_xyzw, rpy_from_matrix

# --- The `<visual>` and `<collision>` elements of a URDF: pose, shape and colour.

Rgba = tuple[float, float, float, float]


class UnreadableShape(Exception):
    """The reason why a shape of a link is left out: its element or its mesh file cannot be read."""


@dataclass(frozen=True)
class Origin:
    """A pose as a URDF writes it.

    Attributes:
        xyz: position [m].
        rpy: orientation, R = Rz(yaw) Ry(pitch) Rx(roll) [rad].

    Examples:
        >>> Origin(xyz=(0.0, 0.0, 0.1)).matrix[:3, 3]
        array([0. , 0. , 0.1])
    """

    xyz: Vector = (0.0, 0.0, 0.0)
    rpy: Vector = (0.0, 0.0, 0.0)

    @property
    def matrix(self) -> Floats:
        """The pose as a matrix, shape (4, 4) [m]."""
        return join_poses(matrix_from_rpy(self.rpy), np.array(self.xyz))

    @staticmethod
    def of(T: Floats) -> Origin:
        """Return the origin of a pose given as a matrix (4, 4), with 0 in place of −0."""
        (x, y, z), (roll, pitch, yaw) = ((part + 0.0).tolist() for part in (T[:3, 3], rpy_from_matrix(T[:3, :3])))
        return Origin((x, y, z), (roll, pitch, yaw))


@dataclass(frozen=True)
class Box:
    """A box with its centre at the origin; edge lengths along x, y, z [m]."""

    size: Vector


@dataclass(frozen=True)
class Cylinder:
    """A cylinder about z with its centre at the origin [m]."""

    radius: float
    length: float


@dataclass(frozen=True)
class Sphere:
    """A sphere about the origin [m]."""

    radius: float


@dataclass(frozen=True)
class MeshFile:
    """A mesh file by its name in the URDF, with scale factors along its axes."""

    filename: str
    scale: Vector = (1.0, 1.0, 1.0)

    def path(self, packages: Packages) -> Path:
        """Return the file; raise `UnreadableShape` if it does not exist."""
        path = packages.file(self.filename)
        if path is None:
            raise UnreadableShape(f"its mesh {quoted(self.filename)} is not there")
        return path

    def unit(self, packages: Packages) -> float:
        """Return the unit of the file [m]; 1 for a file that cannot be read, or whose unit is no length."""
        try:
            return mesh_unit(self.path(packages)) if self.filename.lower().endswith(_WITH_UNITS) else 1.0
        except UnreadableShape:
            return 1.0


# Formats with units, COLLADA's <unit meter="…"> and 3MF's <model unit="…">; meshes in others are taken to be in metres.
_COLLADA = ".dae"
_WITH_UNITS = (_COLLADA, ".3mf")
# Source: 3MF Core Specification, 3.4 <model>.
_UNITS_OF_3MF = {"micron": 1e-6, "millimeter": 1e-3, "centimeter": 0.01, "inch": 0.0254, "foot": 0.3048, "meter": 1.0}


def mesh_unit(path: Path) -> float:
    """Return the unit of a mesh file [m], 1 for a format without units; only the beginning of the file is read."""
    suffix = path.suffix.lower()
    if suffix not in _WITH_UNITS:
        return 1.0
    import zipfile

    try:
        if suffix == _COLLADA:
            with path.open("rb") as file:
                text = next(_units_of_collada(file), "1")
        else:
            with zipfile.ZipFile(path) as archive, archive.open("3D/3dmodel.model") as file:
                _, root = next(iter(ET.iterparse(file, ("start",))))
            text = root.get("unit", "millimeter")
            text = str(_UNITS_OF_3MF.get(text, text))
    except (OSError, KeyError, StopIteration, ET.ParseError, zipfile.BadZipFile):
        return 1.0  # the reader of the whole file says what is wrong
    numbers = finite_numbers(text)
    if len(numbers) != 1 or numbers[0] <= 0.0:
        raise UnreadableShape(f"its unit {quoted(text)} is no length in metres")
    return numbers[0]


def _units_of_collada(file: IO[bytes]) -> Iterator[str]:
    """Yield the unit in the first `<asset>`, that of the file."""
    for event, element in ET.iterparse(file, ("start", "end")):
        name = str(element.tag).rpartition("}")[2]
        if name == "unit" and event == "start":
            yield element.get("meter", "1")
        if name == "asset" and event == "end":
            return


Geometry = Box | Cylinder | Sphere | MeshFile


@dataclass(frozen=True)
class Visual:
    """A visual shape of a link.

    Attributes:
        link: name of the link.
        origin: pose of the shape in the link's frame.
        geometry: the shape.
        material: name of its material, "" without one.
        rgba: colour and opacity of that material, each in [0, 1]; None if the URDF gives none.
        name: name of the visual, "" without one.
    """

    link: str
    origin: Origin
    geometry: Geometry
    material: str = ""
    rgba: Rgba | None = None
    name: str = ""


@dataclass(frozen=True)
class Collision:
    """A shape of a link for contacts.

    Attributes:
        link: name of the link.
        origin: pose of the shape in the link's frame.
        geometry: the shape.
        name: its name, "" without one.
    """

    link: str
    origin: Origin
    geometry: Geometry
    name: str = ""


# An origin farther away is an error of the file, and would lose the digits of a millimetre [m].
_FARTHEST = 1e6
_LEFT_OUT = {"visual": "a visual of {} is not shown", "collision": "a collision shape of {} is left out"}


def read_shapes(document: ET.Element, links: Mapping[str, ET.Element]) -> dict[str, Any]:
    """Return the visuals, the collision shapes and the notes on unreadable shapes, by the fields of `UrdfTree`."""
    quaternions = has_quaternions(document)
    colours = {material.get("name", ""): rgba for material in document.findall("material") if (rgba := _rgba(material))}
    found = {field: list[Any]() for tag in _LEFT_OUT for field in (f"{tag}s", f"{tag}_notes")}
    for link, element in links.items():
        for part in element:
            if part.tag not in _LEFT_OUT:
                continue
            try:
                placed, own = _placed(part, quaternions), part.get("name", "")
                if part.tag == "collision":
                    found["collisions"] += [Collision(link, *shape, own) for shape in placed]
                else:
                    material = part.find("material")
                    name = "" if material is None else material.get("name", "")
                    rgba = None if material is None else _rgba(material) or colours.get(name)
                    found["visuals"] += [Visual(link, *shape, name, rgba, own) for shape in placed]
            except UnreadableShape as reason:
                found[f"{part.tag}_notes"].append(f"{_LEFT_OUT[part.tag].format(abbreviated(link))}: {reason}")
    return {field: tuple(values) for field, values in found.items()}


def has_quaternions(document: ET.Element) -> bool:
    """Return whether the `<robot>` is of a version of URDF, 1.1 or later, in which an origin may be a quaternion."""
    return finite_numbers(document.get("version", "1.0").replace(".", " ")) >= [1, 1]


def read_origin(element: ET.Element | None, quaternions: bool) -> Origin:
    """Return the pose of an `<origin>`; its quat_xyzw, of any length, counts only if the file has `quaternions`."""
    if element is None:
        return Origin()
    xyz = _vector(element, "xyz", "0 0 0")
    if max(map(abs, xyz)) > _FARTHEST:
        raise UnreadableShape(f"origin has xyz {quoted(element.get('xyz'))}, farther than {_FARTHEST:g} m")
    if not quaternions or element.get("quat_xyzw") is None:
        return Origin(xyz, _vector(element, "rpy", "0 0 0"))
    if element.get("rpy") is not None:
        raise UnreadableShape("origin has both rpy and quat_xyzw")
    xyzw = _numbers(element, "quat_xyzw", 4)
    length = math.hypot(*xyzw)
    if not 1e-9 < length < 1e9:
        raise UnreadableShape(f"origin has quat_xyzw {quoted(element.get('quat_xyzw'))}, which is no rotation")
    R = matrix_from_quat(quat_from_xyzw(np.array(xyzw) / length))
    return Origin.of(join_poses(R, np.array(xyz)))


def _placed(element: ET.Element, quaternions: bool) -> list[tuple[Origin, Geometry]]:
    """Return the pose and the geometry of the shapes that make a visual or a collision: three for a capsule."""
    geometry = element.find("geometry")
    shape = next(iter(geometry), None) if geometry is not None else None
    if shape is None:
        raise UnreadableShape("no geometry")
    place = read_origin(element.find("origin"), quaternions)
    if shape.tag != "capsule":
        return [(place, _geometry(shape))]
    radius, length = (_numbers(shape, size, 1)[0] for size in ("radius", "length"))
    if not (radius > 0.0 and length >= 0.0):
        raise UnreadableShape(f"capsule has radius {radius:g} and length {length:g}")
    return [(Origin.of(T), part) for T, part in capsule_parts(place.matrix, radius, length)]


def capsule_parts(T_link_capsule: Floats, radius: float, length: float) -> Iterator[tuple[Floats, Geometry]]:
    """Yield the shapes that make a capsule about z, with their poses: a cylinder, and a sphere at each of its ends."""
    if length:
        yield T_link_capsule, Cylinder(radius, length)
    for end in (0.5 * length, -0.5 * length) if length else (0.0,):
        yield T_link_capsule @ join_poses(np.eye(3), np.array([0.0, 0.0, end])), Sphere(radius)


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


# --- Links, joints and inertias.

# The entries of a tensor, in the order of `Inertial.inertia`.
TENSOR_LABELS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


@dataclass(frozen=True)
class Inertial:
    """Mass and inertia of a link.

    Attributes:
        mass: mass [kg].
        origin: centre of mass, and the axes of the tensor, in the link's frame.
        inertia: ixx, ixy, ixz, iyy, iyz, izz about the centre of mass [kg m²].
    """

    mass: float
    origin: Origin
    inertia: tuple[float, float, float, float, float, float]


@dataclass(frozen=True)
class UrdfJoint:
    """A joint of a tree.

    Attributes:
        name: its name.
        kind: "revolute", "prismatic" or "fixed"; a `continuous` joint is a revolute one without limits.
        parent: the link that carries it.
        child: the link it moves.
        origin: its frame, with the joint at zero, in the parent link's frame.
        axis: unit vector of the axis.
        lower: smallest value [rad or m].
        upper: largest value [rad or m].
        velocity: largest speed, above 0; ∞ without a limit.
        effort: largest torque or force.
        damping: viscous torque or force per unit of speed.
        friction: dry friction torque or force.
        mimic: the joint it follows, None for an independent joint.
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
        """Its coupling to a coordinate; an independent joint follows itself."""
        return self.mimic or Mimic(self.name)

    def travel(self, value: float) -> Floats:
        """Return the pose of the joint's frame at a value, in its frame at zero, shape (4, 4)."""
        T = np.eye(4)
        if self.kind == "prismatic":
            T[:3, 3] = value * np.array(self.axis)
        elif value:
            T[:3, :3] = exp(value * np.array(self.axis))
        return T


@one_line_repr
@dataclass(frozen=True)
class UrdfTree:
    """A URDF as read and repaired.

    In the joints, shapes and inertias, an `origin` is a pose, with `xyz` [m], `rpy` [rad] and `matrix`, shape (4, 4);
    a `geometry` is a box with a `size`, a cylinder with `radius` and `length`, a sphere with a `radius`, or a mesh with
    `filename` and `scale`.

    Attributes:
        path: the file.
        name: name of the robot.
        root: the link that no joint moves.
        links: link names in order of the file.
        inertials: link → its mass and inertia, if it has them: `mass` [kg], `origin` (centre of mass, and the axes of
            the tensor), and `inertia`, ixx, ixy, ixz, iyy, iyz, izz about the centre of mass [kg m²].
        joints: all joints in depth-first order, those of added frames last, every driving joint before its mimic
            joints. Each has a `name`, `kind` ("revolute", "prismatic" or "fixed"), `parent` and `child` links, `origin`
            (its frame in the parent link's, at zero), unit vector `axis`, `lower`, `upper`, `velocity`, `effort`,
            `damping`, `friction`, and `mimic`, the joint that it follows, or None.
        visuals: the visual shapes, each with its `link`, `origin`, `geometry`, `material`, `rgba` and `name`.
        shared_names: name that the file gives to a link and to a joint → the name of the link in this tree.
        notes: repairs, one line each.
        visual_notes: visual shapes that cannot be read, one line each.
        collisions: the shapes for contacts, each with its `link`, `origin`, `geometry` and `name`.
        collision_notes: collision shapes that cannot be read, one line each.
        package_dirs: folders that are searched first for packages.
        expanded: the URDF text made from a xacro source; "" if the file is a URDF.
        offsets: joints with a calibrated origin, and those of added frames → that origin.
        added: link that is not in the file, because `RobotModel.with_frame` added it → the link that carries it.

    Examples:
        >>> tree = nk.load_nao().tree
        >>> tree.name, tree.root, tree.moving_joints[0].name
        ('nao_v6', 'base_link', 'HeadYaw')
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
    added: Mapping[str, str] = field(default_factory=dict, repr=False)
    # What is made from this tree once for all robots: the Pinocchio model of each base, the points that touch a floor.
    made: dict[Any, Any] = field(default_factory=dict, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        # Read-only, because all robots made from a tree share the tree.
        for name in ("inertials", "shared_names", "offsets", "added"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))

    def __reduce__(self) -> tuple[Any, ...]:
        # Mapping proxies do not pickle.
        values = (getattr(self, field.name) for field in fields(self) if field.init)
        return UrdfTree, tuple(dict(value) if isinstance(value, MappingProxyType) else value for value in values)

    @property
    def packages(self) -> Packages:
        """The search for the mesh files of the tree."""
        return Packages(self.path, self.package_dirs)

    @property
    def moving_joints(self) -> tuple[UrdfJoint, ...]:
        """The joints that are not fixed."""
        return tuple([joint for joint in self.joints if joint.kind != "fixed"])

    @property
    def fixed_joints(self) -> frozenset[str]:
        """The names of the joints that cannot move."""
        return frozenset([joint.name for joint in self.joints if joint.kind == "fixed"])

    @property
    def mimics(self) -> dict[str, Mimic]:
        """The joints that follow another one, by name."""
        return {joint.name: joint.mimic for joint in self.joints if joint.mimic is not None}

    def link_of(self, frame: str) -> str:
        """Return the link at a frame: of this name, or the one that the joint with this name moves.

        Examples:
            >>> nk.load_nao().tree.link_of("HeadPitch")
            'Head'
        """
        moved = (joint.child for joint in self.joints if joint.name == frame)
        return frame if frame in self.links else self.shared_names.get(frame) or next(moved, frame)

    def joints_to(self, link: str, base: str = "") -> list[UrdfJoint]:
        """Return the joints from a link `base` to another link; from the root if the base does not carry it.

        Examples:
            >>> [joint.name for joint in nk.load_nao().tree.joints_to("Head", "torso")]
            ['HeadYaw', 'HeadPitch']
        """
        above, found = {joint.child: joint for joint in self.joints}, list[UrdfJoint]()
        while link in above and link != base:
            found.append(above[link])
            link = above[link].parent
        return found[::-1]


# --- Links that share their name with a joint.


def rename_links(links: Iterable[str], joints: Iterable[str], notes: list[str]) -> dict[str, str]:
    """Return new names for links that share theirs with a joint: "…_link", or "…_frame" if that is taken; note them."""
    links, joints = tuple(links), frozenset(joints)
    taken = joints.union(links)
    renamed: dict[str, str] = {}
    for name in links:
        if name in joints:
            renamed[name] = fresh_name(name, taken, "_link", "_frame")
            notes.append(f"link {quoted(name)} renamed {quoted(renamed[name])}: a joint has the same name")
    return renamed
