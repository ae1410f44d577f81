"""What the links of a robot look like, read from its URDF: primitives and meshes, with their colours."""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree import ElementTree as ET

import numpy as np

from nao_kin._arrays import Floats
from nao_kin.errors import BadModel
from nao_kin.robot import RobotModel
from nao_kin.rotations import matrix_from_rpy
from nao_kin.urdf_reader import UrdfTree
from nao_kin.viewer.meshes import Mesh, Rgba, UnreadableMesh, load_meshes, mesh_path

_GREY: Rgba = (0.75, 0.77, 0.8, 1.0)


@dataclass(frozen=True)
class Box:
    """A box with its centre at the origin; edge lengths along x, y, z [m]."""

    size: tuple[float, float, float]


@dataclass(frozen=True)
class Cylinder:
    """A cylinder about z with its centre at the origin [m]."""

    radius: float
    length: float


@dataclass(frozen=True)
class Sphere:
    """A sphere about the origin [m]."""

    radius: float


Shape = Box | Cylinder | Sphere | Mesh


@dataclass(frozen=True, eq=False)
class Visual:
    """One shape of one link.

    Attributes:
        link: name of the link.
        T_link_shape: pose of the shape in the link's frame.
        shape: what it is.
        rgba: its colour and opacity, each in [0, 1].
    """

    link: str
    T_link_shape: Floats
    shape: Shape
    rgba: Rgba


class _Skipped(Exception):
    """Why a visual is left out."""


def read_visuals(robot: RobotModel, tree: UrdfTree) -> tuple[tuple[Visual, ...], tuple[str, ...]]:
    """The visuals of a robot, and what could not be shown, one line each.

    Args:
        robot: any robot.
        tree: its URDF as read, which knows under what names the links go.

    Raises:
        BadModel: the URDF can no longer be read.
    """
    try:
        document = ET.parse(robot.urdf_path).getroot()
    except (OSError, ET.ParseError) as error:
        raise BadModel(f"{robot.urdf_path} can no longer be read: {error}") from None
    palette = {material.get("name", ""): rgba for material in document.findall("material") if (rgba := _rgba(material))}
    visuals: list[Visual] = []
    missing: list[str] = []
    notes: list[str] = []
    for name, link in zip(tree.links, document.findall("link"), strict=True):
        for element in link.findall("visual"):
            try:
                visuals += _visuals_of(name, element, palette, robot, missing)
            except _Skipped as reason:
                notes.append(f"a visual of {name} is not shown: {reason}")
    if missing:
        more = f" and {len(missing) - 1} more" if len(missing) > 1 else ""
        notes.insert(0, f"mesh files not found: {missing[0]}{more}")
    return tuple(visuals), tuple(notes)


def carriers(tree: UrdfTree, visuals: tuple[Visual, ...]) -> dict[str, str]:
    """Link without a shape → the nearest link with one that carries it through fixed joints alone."""
    seen = {visual.link for visual in visuals}
    found: dict[str, str] = {}
    for joint in tree.joints:
        if joint.kind == "fixed" and joint.child not in seen:
            carrier = joint.parent if joint.parent in seen else found.get(joint.parent)
            if carrier is not None:
                found[joint.child] = carrier
    return found


def _visuals_of(
    link: str, element: ET.Element, palette: dict[str, Rgba], robot: RobotModel, missing: list[str]
) -> list[Visual]:
    geometry = element.find("geometry")
    shape = next(iter(geometry), None) if geometry is not None else None
    if shape is None:
        raise _Skipped("no geometry")
    T_link_shape = _pose(element.find("origin"))
    material = element.find("material")
    rgba = None if material is None else _rgba(material) or palette.get(material.get("name", ""))
    if shape.tag != "mesh":
        return [Visual(link, T_link_shape, _primitive(shape), rgba or _GREY)]
    filename = shape.get("filename", "")
    path = mesh_path(robot.urdf_path, filename)
    if path is None:
        missing.append(filename)
        return []
    try:
        meshes = load_meshes(path, np.array(_floats(shape, "scale", 3, "1 1 1")))
    except UnreadableMesh as reason:
        raise _Skipped(f"{path.name}: {reason}") from None
    return [Visual(link, T_link_shape, mesh, rgba or mesh.colour or _GREY) for mesh in meshes]


def _primitive(shape: ET.Element) -> Shape:
    if shape.tag == "box":
        x, y, z = _floats(shape, "size", 3)
        return Box((x, y, z))
    if shape.tag == "cylinder":
        return Cylinder(_floats(shape, "radius", 1)[0], _floats(shape, "length", 1)[0])
    if shape.tag == "sphere":
        return Sphere(_floats(shape, "radius", 1)[0])
    raise _Skipped(f"geometry {shape.tag!r} is unknown")


def _pose(origin: ET.Element | None) -> Floats:
    T = np.eye(4)
    if origin is not None:
        T[:3, 3] = _floats(origin, "xyz", 3, "0 0 0")
        T[:3, :3] = matrix_from_rpy(_floats(origin, "rpy", 3, "0 0 0"))
    return T


def _rgba(material: ET.Element) -> Rgba | None:
    colour = material.find("color")
    if colour is None:
        return None
    try:
        r, g, b, a = (min(max(value, 0.0), 1.0) for value in _floats(colour, "rgba", 4))
    except _Skipped:
        return None
    return r, g, b, a


def _floats(element: ET.Element, attribute: str, count: int, default: str = "") -> list[float]:
    text = element.get(attribute, default)
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        values = []
    if len(values) != count or not np.isfinite(values).all():
        raise _Skipped(f"{element.tag} has {attribute} {text!r}, expected {count} finite numbers")
    return values
