"""The parts of a URDF as XML: numbers as the shortest text that reads back as the same float, always in one order."""

from __future__ import annotations

from collections.abc import Iterable
from xml.etree import ElementTree as ET

from nao_kin.semantics import Mimic
from nao_kin.urdf.tree import Inertial
from nao_kin.urdf.visuals import Box, Cylinder, Geometry, MeshFile, Origin, Rgba, Sphere

# The entries of a tensor, in the order of `Inertial.inertia`.
TENSOR_LABELS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def number(value: float) -> str:
    """The shortest text that reads back as the same float; no sign on zero."""
    text = repr(float(value) + 0.0)
    return text[:-2] if text.endswith(".0") else text


def numbers(values: Iterable[float]) -> str:
    """Several numbers with blanks between them."""
    return " ".join(map(number, values))


def add_origin(element: ET.Element, origin: Origin) -> None:
    """Write where something stands."""
    ET.SubElement(element, "origin", xyz=numbers(origin.xyz), rpy=numbers(origin.rpy))


def add_ends(joint: ET.Element, parent: str, child: str, origin: Origin) -> None:
    """Write which links a joint connects, and where."""
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)
    add_origin(joint, origin)


def add_inertial(link: ET.Element, body: Inertial) -> None:
    """Write mass, centre of mass and tensor of a link."""
    inertial = ET.SubElement(link, "inertial")
    add_origin(inertial, body.origin)
    ET.SubElement(inertial, "mass", value=number(body.mass))
    ET.SubElement(inertial, "inertia", {k: number(v) for k, v in zip(TENSOR_LABELS, body.inertia, strict=True)})


def add_geometry(element: ET.Element, shape: Geometry) -> None:
    """Write a shape; of a mesh the name of the file as it is, and its scale where it has one."""
    geometry = ET.SubElement(element, "geometry")
    if isinstance(shape, Box):
        ET.SubElement(geometry, "box", size=numbers(shape.size))
    elif isinstance(shape, Cylinder):
        ET.SubElement(geometry, "cylinder", radius=number(shape.radius), length=number(shape.length))
    elif isinstance(shape, Sphere):
        ET.SubElement(geometry, "sphere", radius=number(shape.radius))
    elif isinstance(shape, MeshFile):
        scale = {} if shape.scale == (1.0, 1.0, 1.0) else {"scale": numbers(shape.scale)}
        ET.SubElement(geometry, "mesh", {"filename": shape.filename, **scale})


def add_colour(robot: ET.Element, name: str, rgba: Rgba) -> None:
    """Write a material of the robot."""
    ET.SubElement(ET.SubElement(robot, "material", name=name), "color", rgba=numbers(rgba))


def add_mimic(joint: ET.Element, mimic: Mimic) -> None:
    """Write which joint a joint follows, and how."""
    ratio = {"multiplier": number(mimic.multiplier), "offset": number(mimic.offset)}
    ET.SubElement(joint, "mimic", {"joint": mimic.joint, **ratio})


def document_text(robot: ET.Element) -> str:
    """The document, indented, with its declaration and a newline at its end."""
    ET.indent(robot)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ET.tostring(robot, encoding="unicode") + "\n"
