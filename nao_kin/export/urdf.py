"""Export of a robot as a URDF for other tools."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree as ET

from nao_kin.errors import UnknownName
from nao_kin.export.meshes import MESH_FOLDER, Paint, paint_names, shapes_of, taken_meshes
from nao_kin.export.pipeline import UTF_8, Destination, Exported, number_texts, numbers, primitive_texts, xml_text
from nao_kin.export.variants import Variant
from nao_kin.robot import RobotModel
from nao_kin.robot.urdf import TENSOR_LABELS, Collision, Inertial, MeshFile, Origin, UrdfJoint, UrdfTree, Visual

# --- The text of a URDF: deterministic, with the shortest numbers that read back exactly.

# URDF cannot express "without bound"; this is written instead [m, m/s, rad/s, N, N m].
UNBOUNDED = 1e9


def urdf_document(
    tree: UrdfTree, meshes: Mapping[str, str] | None = None, paints: Iterable[Paint] = ()
) -> tuple[str, tuple[str, ...]]:
    """Return the URDF of a tree, ending in a newline, and one line for each loss.

    Links come before the joints that move them, and joints in the order of the tree, so that a follower comes after its
    driver. `meshes` maps mesh names in the tree to the names to write; None leaves out meshes. `paints` are written
    first.
    """
    changes: list[str] = []
    materials = paint_names((*paints, *((seen.material, seen.rgba) for seen in tree.visuals if seen.rgba is not None)))
    robot = ET.Element("robot", name=tree.name)
    for (_, rgba), name in materials.items():
        ET.SubElement(ET.SubElement(robot, "material", name=name), "color", rgba=numbers(rgba))
    joints = {joint.name: joint for joint in tree.joints}
    robot.append(_link(tree, tree.root, materials, meshes))
    for joint in tree.joints:
        robot.append(_link(tree, joint.child, materials, meshes))
        robot.append(_joint(joint, joints, changes))
    if meshes is None:
        omitted = {shape.link for shape in shapes_of(tree) if isinstance(shape.geometry, MeshFile)}
        if omitted:
            changes.append(f"the meshes of {len(omitted)} links are left out")
    return xml_text(robot, UTF_8), tuple(changes)


def _link(tree: UrdfTree, name: str, materials: Mapping[Paint, str], meshes: Mapping[str, str] | None) -> ET.Element:
    link = ET.Element("link", name=name)
    body = tree.inertials.get(name)
    if body is not None:
        inertial = ET.SubElement(link, "inertial")
        _add_origin(inertial, body.origin)
        ET.SubElement(inertial, "mass", number_texts({"value": body.mass}))
        ET.SubElement(inertial, "inertia", number_texts(dict(zip(TENSOR_LABELS, body.inertia, strict=True))))
    for visual in tree.visuals:
        if visual.link == name:
            element = _add_shape(link, "visual", visual, meshes)
            # Most readers refuse a material without a colour.
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
    if not isinstance(geometry, MeshFile):
        kind, texts = primitive_texts(geometry)
    elif meshes is None:
        return None
    else:
        kind, texts = "mesh", {"filename": meshes[geometry.filename]}
        if geometry.scale != (1.0, 1.0, 1.0):
            texts["scale"] = numbers(geometry.scale)
    element = ET.SubElement(link, tag, {"name": shape.name} if shape.name else {})
    _add_origin(element, shape.origin)
    ET.SubElement(ET.SubElement(element, "geometry"), kind, texts)
    return element


def _add_origin(element: ET.Element, origin: Origin) -> None:
    ET.SubElement(element, "origin", xyz=numbers(origin.xyz), rpy=numbers(origin.rpy))


def _joint(joint: UrdfJoint, joints: Mapping[str, UrdfJoint], changes: list[str]) -> ET.Element:
    element = ET.Element("joint", name=joint.name, type=joint.kind)
    ET.SubElement(element, "parent", link=joint.parent)
    ET.SubElement(element, "child", link=joint.child)
    _add_origin(element, joint.origin)
    if joint.kind not in ("revolute", "prismatic"):
        return element
    ET.SubElement(element, "axis", xyz=numbers(joint.axis))
    limits = _limits(joint, joints, changes)
    if "lower" not in limits:
        element.set("type", "continuous")
    if limits:
        ET.SubElement(element, "limit", number_texts(limits))
    if joint.mimic is not None:
        ratio = number_texts({"multiplier": joint.mimic.multiplier, "offset": joint.mimic.offset})
        ET.SubElement(element, "mimic", {"joint": joint.mimic.joint, **ratio})
    if joint.damping or joint.friction:
        ET.SubElement(element, "dynamics", number_texts({"damping": joint.damping, "friction": joint.friction}))
    return element


def _limits(joint: UrdfJoint, joints: Mapping[str, UrdfJoint], changes: list[str]) -> dict[str, float]:
    """Return the limits to write; without lower and upper for a continuous joint."""
    lower, upper = joint.lower, joint.upper
    if joint.mimic is not None and not math.isfinite(upper - lower):
        # A continuous joint must not mimic a joint with limits.
        driver = joints[joint.mimic.joint]
        lower, upper = joint.mimic.range(driver.lower, driver.upper)
    bounds = {"velocity": joint.velocity, "effort": joint.effort}
    if math.isfinite(upper - lower):
        bounds = {"lower": lower, "upper": upper} | bounds
    elif joint.kind == "prismatic" or math.isfinite(lower) or math.isfinite(upper):
        bounds = {"lower": max(lower, -UNBOUNDED), "upper": min(upper, UNBOUNDED)} | bounds
        what = "slides without limits:" if lower == -upper else "has one limit, and the other is"
        changes.append(f"{joint.name} {what} written as ±{UNBOUNDED:g}")
    elif not any(map(math.isfinite, bounds.values())):
        return {}
    unbounded = [name for name, value in bounds.items() if math.isinf(value)]
    if unbounded:
        changes.append(f"{joint.name} has no bound on {' and '.join(unbounded)}: written as {UNBOUNDED:g}")
    return {name: min(value, UNBOUNDED) if name in unbounded else value for name, value in bounds.items()}


# --- The export.

MESHES = ("relative", "absolute", "none", "package://NAME")


def urdf(
    robot: RobotModel,
    path: Path | str,
    *,
    frames: str = "all",
    names: str = "naoqi",
    meshes: str = "relative",
    coupling: str = "mimic",
    inertia: str = "published",
    typed: bool = False,
    axes: str = "published",
    overwrite: bool = False,
) -> Exported:
    """Write a robot as a URDF.

    With the defaults, links, joints, inertias and shapes are those that were read, and meshes are copied.

    Args:
        robot: any robot.
        path: the file to write.
        frames: which links on fixed joints to keep: "all"; "effectors", those that the semantics name: end effectors,
            soles, cameras, sensors; or "none", one link for each body. The mass of the other links is added to the
            links that carry them.
        names: "naoqi", those of the robot's own file, or "ros", those of its published ROS description.
        meshes: "relative" copies them to a folder "meshes" next to the file; "absolute" refers to the original files;
            "package://NAME" refers to the folder "meshes" of a ROS package, "package://NAME/FOLDER" to another folder
            of it, and copies nothing; "none" leaves meshes out and keeps boxes, cylinders and spheres.
        coupling: mimic joints "mimic" their driver, are "locked" together with it, or are "independent".
        inertia: "published", or "physical": the nearest possible inertias, as `nao_kin.export.inertia.make_physical`
            describes, and an explicit mass of 0 for a link without mass, because PyBullet assumes 1 kg.
        typed: write three joints with one centre as `type="spherical"`, which PyBullet and MuJoCo read and most others
            do not.
        axes: "published", as in the robot's file; "aligned" turns the frame of a joint with an oblique axis until the
            axis is its z axis, for tools that accept only axes of the frame. Links do not change.
        overwrite: replace existing files.

    Returns:
        The file, all files written, and their differences from the robot.

    Raises:
        BadArgument: a mesh is missing, the robot has no ROS names, or a file exists.

    Examples:
        >>> done = nk.export.urdf(nk.load_nao("v6"), "nao.urdf", frames="none", meshes="none", inertia="physical")
        >>> done.path.name, done.changes[0]
        ('nao.urdf', 'base_link has neither mass nor shapes: torso is the root instead')
        >>> nk.RobotModel.from_urdf("nao.urdf").link_names[0]
        'torso'
    """
    target = Destination(path, overwrite=overwrite)
    tree, changes = Variant(frames, names, coupling, inertia, typed, axes).tree_of(robot)
    if inertia == "physical":
        nothing = Inertial(0.0, Origin(), (0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
        massless = [link for link in tree.links if link not in tree.inertials and link != tree.root]
        tree = replace(tree, inertials={**tree.inertials, **dict.fromkeys(massless, nothing)})
        changes += (f"{len(massless)} links without mass get an explicit mass of 0",) if massless else ()
    taken = taken_meshes(tree, meshes, _package(meshes))
    text, losses = urdf_document(tree, taken.names)
    return target.write({"": text.encode(), **taken.files}, (*changes, *losses, *taken.notes))


def _package(meshes: str) -> str:
    """Return the folder of meshes that a `package://` names; "" for the choices without one."""
    if meshes in ("relative", "absolute", "none"):
        return ""
    before, scheme, inside = meshes.partition("package://")
    inside = inside.strip("/")
    if before or not inside or set(inside) & set(" \t\n\\"):
        raise UnknownName("choice of meshes", meshes, MESHES)
    return scheme + (inside if "/" in inside else f"{inside}/{MESH_FOLDER}")
