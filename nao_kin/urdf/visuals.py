"""What the links of a URDF look like: primitives and mesh files, where they stand, in which colours."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from xml.etree import ElementTree as ET

from nao_kin._text import abbreviated, quoted

Vector = tuple[float, float, float]
Rgba = tuple[float, float, float, float]


@dataclass(frozen=True)
class Origin:
    """A pose as a URDF writes it.

    Attributes:
        xyz: position [m].
        rpy: orientation, R = Rz(yaw) Ry(pitch) Rx(roll) [rad].
    """

    xyz: Vector = (0.0, 0.0, 0.0)
    rpy: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Geometry:
    """A shape.

    Attributes:
        kind: "box", "cylinder", "sphere" or "mesh".
        size: edge lengths of a box, (radius, length) of a cylinder about z, (radius,) of a sphere [m]; the scale of a
            mesh along x, y, z.
        filename: of a mesh, as the URDF writes it; "" for the others.
    """

    kind: str
    size: tuple[float, ...]
    filename: str = ""


@dataclass(frozen=True)
class Visual:
    """One shape of one link.

    Attributes:
        link: name of the link.
        origin: pose of the shape in the link's frame.
        geometry: the shape.
        rgba: its colour and opacity, each in [0, 1]; None where the URDF gives none.
    """

    link: str
    origin: Origin
    geometry: Geometry
    rgba: Rgba | None


class _Unreadable(Exception):
    """Why a visual is left out."""


def read_visuals(document: ET.Element, links: Iterable[tuple[str, ET.Element]]) -> tuple[list[Visual], list[str]]:
    """The visuals of a URDF, and a note for each one that cannot be read: looks never keep a robot from loading.

    Args:
        document: the <robot> element, which may name materials.
        links: name and element of each link.
    """
    palette = {material.get("name", ""): rgba for material in document.findall("material") if (rgba := _rgba(material))}
    visuals: list[Visual] = []
    notes: list[str] = []
    for link, element in links:
        for visual in element.findall("visual"):
            try:
                visuals.append(_visual(link, visual, palette))
            except _Unreadable as reason:
                notes.append(f"a visual of {abbreviated(link)} is not shown: {reason}")
    return visuals, notes


def _visual(link: str, element: ET.Element, palette: Mapping[str, Rgba]) -> Visual:
    geometry = element.find("geometry")
    shape = next(iter(geometry), None) if geometry is not None else None
    if shape is None:
        raise _Unreadable("no geometry")
    material, origin = element.find("material"), element.find("origin")
    pose = Origin() if origin is None else Origin(_vector(origin, "xyz"), _vector(origin, "rpy"))
    rgba = None if material is None else _rgba(material) or palette.get(material.get("name", ""))
    return Visual(link, pose, _geometry(shape), rgba)


def _geometry(shape: ET.Element) -> Geometry:
    if shape.tag == "box":
        return Geometry("box", _floats(shape, "size", 3))
    if shape.tag == "cylinder":
        return Geometry("cylinder", _floats(shape, "radius", 1) + _floats(shape, "length", 1))
    if shape.tag == "sphere":
        return Geometry("sphere", _floats(shape, "radius", 1))
    if shape.tag == "mesh":
        return Geometry("mesh", _floats(shape, "scale", 3, "1 1 1"), shape.get("filename", ""))
    raise _Unreadable(f"geometry {quoted(shape.tag)} is unknown")


def _rgba(material: ET.Element) -> Rgba | None:
    colour = material.find("color")
    if colour is None:
        return None
    try:
        r, g, b, a = (min(max(value, 0.0), 1.0) for value in _floats(colour, "rgba", 4))
    except _Unreadable:
        return None
    return r, g, b, a


def _vector(element: ET.Element, attribute: str) -> Vector:
    x, y, z = _floats(element, attribute, 3, "0 0 0")
    return x, y, z


def _floats(element: ET.Element, attribute: str, count: int, default: str = "") -> tuple[float, ...]:
    text = element.get(attribute, default)
    try:
        values = tuple(float(word) for word in text.split())
    except ValueError:
        values = ()
    if len(values) != count or not all(map(math.isfinite, values)):
        raise _Unreadable(f"{element.tag} has {attribute} {quoted(text)}, expected {count} finite numbers")
    return values
