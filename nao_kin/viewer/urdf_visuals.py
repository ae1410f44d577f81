"""The `<visual>` elements of a URDF as data: where each stands, what it is, what colour it has."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree as ET

from nao_kin._scalars import decimal
from nao_kin._text import abbreviated, quoted
from nao_kin.errors import BadModel

Rgba = tuple[float, float, float, float]
Triple = tuple[float, float, float]


@dataclass(frozen=True)
class Box:
    """A box with its centre at the origin; edge lengths along x, y, z [m]."""

    size: Triple


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
    """A mesh by the name that the URDF has for its file, scaled along its axes."""

    filename: str
    scale: Triple = (1.0, 1.0, 1.0)


Geometry = Box | Cylinder | Sphere | MeshFile


@dataclass(frozen=True)
class UrdfVisual:
    """A visual of a link as read.

    Attributes:
        link: name of the link.
        xyz: position in the link's frame [m].
        rpy: orientation in the link's frame, R = Rz(yaw) Ry(pitch) Rx(roll) [rad].
        geometry: what it is.
        material: name of its material, "" without one.
        rgba: colour and opacity of that material, each in [0, 1]; None where the URDF gives none.
    """

    link: str
    xyz: Triple
    rpy: Triple
    geometry: Geometry
    material: str = ""
    rgba: Rgba | None = None


def read_visuals(path: Path, links: Sequence[str]) -> tuple[tuple[UrdfVisual, ...], tuple[str, ...]]:
    """The visuals of a URDF file, and one line for each that cannot be read.

    Args:
        path: the file.
        links: the names that the links go by, in order of the file.

    Raises:
        BadModel: the file can no longer be read.
    """
    try:
        document = ET.parse(path).getroot()
    except (OSError, ET.ParseError) as error:
        raise BadModel(f"{path} can no longer be read: {error}") from None
    return visuals_in(document, links)


def visuals_in(document: ET.Element, links: Sequence[str]) -> tuple[tuple[UrdfVisual, ...], tuple[str, ...]]:
    """The same of a URDF that is parsed already: `document` is its `<robot>`."""
    colours = {material.get("name", ""): rgba for material in document.findall("material") if (rgba := _rgba(material))}
    visuals: list[UrdfVisual] = []
    notes: list[str] = []
    for link, element in zip(links, document.findall("link"), strict=True):
        for visual in element.findall("visual"):
            try:
                visuals.append(_visual(link, visual, colours))
            except _Unreadable as reason:
                notes.append(f"a visual of {abbreviated(link)} is not shown: {reason}")
    return tuple(visuals), tuple(notes)


class _Unreadable(Exception):
    """Why a visual is left out."""


def _visual(link: str, element: ET.Element, colours: dict[str, Rgba]) -> UrdfVisual:
    geometry = element.find("geometry")
    shape = next(iter(geometry), None) if geometry is not None else None
    if shape is None:
        raise _Unreadable("no geometry")
    origin, material = element.find("origin"), element.find("material")
    name = "" if material is None else material.get("name", "")
    return UrdfVisual(
        link=link,
        xyz=_triple(origin, "xyz", "0 0 0"),
        rpy=_triple(origin, "rpy", "0 0 0"),
        geometry=_geometry(shape),
        material=name,
        rgba=None if material is None else _rgba(material) or colours.get(name),
    )


def _geometry(shape: ET.Element) -> Geometry:
    if shape.tag == "box":
        return Box(_triple(shape, "size"))
    if shape.tag == "cylinder":
        return Cylinder(_numbers(shape, "radius", 1)[0], _numbers(shape, "length", 1)[0])
    if shape.tag == "sphere":
        return Sphere(_numbers(shape, "radius", 1)[0])
    if shape.tag == "mesh":
        return MeshFile(shape.get("filename", ""), _triple(shape, "scale", "1 1 1"))
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


def _triple(element: ET.Element | None, attribute: str, default: str = "") -> Triple:
    x, y, z = _numbers(element if element is not None else ET.Element("origin"), attribute, 3, default)
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
