"""A robot's tree as the text of a URDF: the same text every time, its numbers the shortest that read back."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from xml.etree import ElementTree as ET

from nao_kin._common.free_names import fresh_name
from nao_kin.urdf import Collision, MeshFile, Rgba, UrdfJoint, UrdfTree, Visual, writing

# URDF has no word for "without bound": this stands for it [m, m/s, rad/s, N, N m].
UNBOUNDED = 1e9

# What a visual has for its colour: name of the material, "" for none, and the colour.
Paint = tuple[str, Rgba]


def urdf_document(tree: UrdfTree, meshes: Mapping[str, str] | None = None) -> tuple[str, tuple[str, ...]]:
    """The URDF of a tree.

    Each link stands before the joint that moves it, and joints are in the order of the tree, so that a joint comes
    after the one that drives it. Colours are materials of the robot, one name for each.

    Args:
        tree: the robot.
        meshes: name of a mesh in the tree → the name to write; None leaves out what is a mesh.

    Returns:
        The document, ending in a newline, and one line for each thing that a URDF cannot say.
    """
    changes: list[str] = []
    materials = _materials(tree)
    robot = ET.Element("robot", name=tree.name)
    for (_, rgba), name in materials.items():
        writing.add_colour(robot, name, rgba)
    joints = {joint.name: joint for joint in tree.joints}
    robot.append(_link(tree, tree.root, materials, meshes))
    for joint in tree.joints:
        robot.append(_link(tree, joint.child, materials, meshes))
        robot.append(_joint(joint, joints, changes))
    if meshes is None:
        left = {visual.link for visual in tree.visuals if isinstance(visual.geometry, MeshFile)}
        left |= {shape.link for shape in tree.collisions if isinstance(shape.geometry, MeshFile)}
        if left:
            changes.append(f"the meshes of {len(left)} links are left out")
    return writing.document_text(robot), tuple(changes)


def _materials(tree: UrdfTree) -> dict[Paint, str]:
    """Name and colour of a visual → name of its material: its own, or another one where two colours share a name."""
    found: dict[Paint, str] = {}
    for visual in tree.visuals:
        if visual.rgba is not None and (visual.material, visual.rgba) not in found:
            found[visual.material, visual.rgba] = fresh_name(visual.material or "colour", found.values())
    return found


def _link(tree: UrdfTree, name: str, materials: Mapping[Paint, str], meshes: Mapping[str, str] | None) -> ET.Element:
    link = ET.Element("link", name=name)
    if name in tree.inertials:
        writing.add_inertial(link, tree.inertials[name])
    for visual in tree.visuals:
        if visual.link == name:
            element = _add_shape(link, "visual", visual, meshes)
            # A material without a colour anywhere is an error to most readers.
            if element is not None and visual.rgba is not None:
                ET.SubElement(element, "material", name=materials[visual.material, visual.rgba])
    for shape in tree.collisions:
        if shape.link == name:
            _add_shape(link, "collision", shape, meshes)
    return link


def _add_shape(
    link: ET.Element, tag: str, shape: Visual | Collision, meshes: Mapping[str, str] | None
) -> ET.Element | None:
    geometry = shape.geometry
    if isinstance(geometry, MeshFile):
        if meshes is None:
            return None
        geometry = replace(geometry, filename=meshes[geometry.filename])
    element = ET.SubElement(link, tag, {"name": shape.name} if shape.name else {})
    writing.add_origin(element, shape.origin)
    writing.add_geometry(element, geometry)
    return element


def _joint(joint: UrdfJoint, joints: Mapping[str, UrdfJoint], changes: list[str]) -> ET.Element:
    element = ET.Element("joint", name=joint.name, type=joint.kind)
    writing.add_ends(element, joint.parent, joint.child, joint.origin)
    if joint.kind not in ("revolute", "prismatic"):
        return element
    ET.SubElement(element, "axis", xyz=writing.numbers(joint.axis))
    limits = _limits(joint, joints, changes)
    if "lower" not in limits:
        element.set("type", "continuous")
    if limits:
        ET.SubElement(element, "limit", {name: writing.number(value) for name, value in limits.items()})
    if joint.mimic is not None:
        writing.add_mimic(element, joint.mimic)
    if joint.damping or joint.friction:
        losses = {"damping": writing.number(joint.damping), "friction": writing.number(joint.friction)}
        ET.SubElement(element, "dynamics", losses)
    return element


def _limits(joint: UrdfJoint, joints: Mapping[str, UrdfJoint], changes: list[str]) -> dict[str, float]:
    """The limits to write; without lower and upper for a joint that is continuous."""
    lower, upper = joint.lower, joint.upper
    if joint.mimic is not None and not math.isfinite(upper - lower):
        # A continuous joint may not follow one with limits.
        driver = joints[joint.mimic.joint]
        lower, upper = joint.mimic.range(driver.lower, driver.upper)
    bounds = {"velocity": joint.velocity, "effort": joint.effort}
    if math.isfinite(upper - lower):
        bounds = {"lower": lower, "upper": upper} | bounds
    elif joint.kind == "prismatic":
        bounds = {"lower": -UNBOUNDED, "upper": UNBOUNDED} | bounds
        changes.append(f"{joint.name} slides without limits: written as ±{UNBOUNDED:g}")
    elif not any(map(math.isfinite, bounds.values())):
        return {}
    endless = [name for name, value in bounds.items() if math.isinf(value)]
    if endless:
        changes.append(f"{joint.name} has no bound on {' and '.join(endless)}: written as {UNBOUNDED:g}")
    return {name: min(value, UNBOUNDED) if name in endless else value for name, value in bounds.items()}
