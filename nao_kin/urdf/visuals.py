"""The `<visual>` and `<collision>` elements of a URDF as data: where each stands, what it is, what colour it has."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from xml.etree import ElementTree as ET

from nao_kin._common.arrays import Vector
from nao_kin._common.scalars import decimal
from nao_kin._text import abbreviated, quoted

Rgba = tuple[float, float, float, float]


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
        >>> tree = nk.urdf.read_urdf(nk.load_nao().urdf_path)
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
    visuals: list[Visual] = []
    notes: list[str] = []
    for link, element in links:
        for visual in element.findall("visual"):
            try:
                visuals.append(_visual(link, visual, colours))
            except _Unreadable as reason:
                notes.append(f"a visual of {abbreviated(link)} is not shown: {reason}")
    return tuple(visuals), tuple(notes)


def read_collisions(links: Iterable[tuple[str, ET.Element]]) -> tuple[tuple[Collision, ...], tuple[str, ...]]:
    """The collision shapes of a URDF, and one line for each that cannot be read.

    Args:
        links: name and element of each link.
    """
    shapes: list[Collision] = []
    notes: list[str] = []
    for link, element in links:
        for collision in element.findall("collision"):
            try:
                origin, geometry = _placed(collision)
            except _Unreadable as reason:
                notes.append(f"a collision shape of {abbreviated(link)} is left out: {reason}")
            else:
                shapes.append(Collision(link, origin, geometry, collision.get("name", "")))
    return tuple(shapes), tuple(notes)


class _Unreadable(Exception):
    """Why a shape is left out."""


def _visual(link: str, element: ET.Element, colours: dict[str, Rgba]) -> Visual:
    origin, geometry = _placed(element)
    material = element.find("material")
    name = "" if material is None else material.get("name", "")
    rgba = None if material is None else _rgba(material) or colours.get(name)
    return Visual(link, origin, geometry, name, rgba, element.get("name", ""))


def _placed(element: ET.Element) -> tuple[Origin, Geometry]:
    """Where the shape of a visual or a collision stands, and what it is."""
    geometry = element.find("geometry")
    shape = next(iter(geometry), None) if geometry is not None else None
    if shape is None:
        raise _Unreadable("no geometry")
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
    raise _Unreadable(f"geometry {quoted(shape.tag)} is unknown")


def _rgba(material: ET.Element) -> Rgba | None:
    colour = material.find("color")
    if colour is None:
        return None
    try:
        r, g, b, a = (min(max(value, 0.0), 1.0) for value in _numbers(colour, "rgba", 4))
    except _Unreadable:
        return None
    return r, g, b, a


def _vector(element: ET.Element, attribute: str, default: str = "") -> Vector:
    x, y, z = _numbers(element, attribute, 3, default)
    return x, y, z


def _numbers(element: ET.Element, attribute: str, count: int, default: str = "") -> list[float]:
    text = element.get(attribute, default)
    try:
        values = [decimal(word) for word in text.split()]
    except ValueError:
        values = []
    if len(values) != count or not all(map(math.isfinite, values)):
        raise _Unreadable(f"{element.tag} has {attribute} {quoted(text)}, expected {count} finite numbers")
    return values
