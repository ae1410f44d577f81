"""A robot as a URDF that another tool loads right."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree as ET

from nao_kin.errors import UnknownName
from nao_kin.export.meshes import MESH_FOLDER, Paint, paint_names, shapes_of, taken_meshes
from nao_kin.export.pipeline import Exported, Target
from nao_kin.export.variants import Variant
from nao_kin.robot import RobotModel
from nao_kin.robot.urdf import Collision, Inertial, MeshFile, Origin, UrdfJoint, UrdfTree, Visual, srdf as writing

# --- A robot's tree as the text of a URDF: the same text every time, its numbers the shortest that read back.

# URDF has no word for "without bound": this stands for it [m, m/s, rad/s, N, N m].
UNBOUNDED = 1e9


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
    materials = paint_names((shown.material, shown.rgba) for shown in tree.visuals if shown.rgba is not None)
    robot = ET.Element("robot", name=tree.name)
    for (_, rgba), name in materials.items():
        writing.add_colour(robot, name, rgba)
    joints = {joint.name: joint for joint in tree.joints}
    robot.append(_link(tree, tree.root, materials, meshes))
    for joint in tree.joints:
        robot.append(_link(tree, joint.child, materials, meshes))
        robot.append(_joint(joint, joints, changes))
    if meshes is None:
        left = {shape.link for shape in shapes_of(tree) if isinstance(shape.geometry, MeshFile)}
        if left:
            changes.append(f"the meshes of {len(left)} links are left out")
    return writing.document_text(robot), tuple(changes)


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


# --- A robot as a URDF that another tool loads right.

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

    With the defaults it is what was read: the same links, joints, inertias and shapes, its meshes copied.

    Args:
        robot: any robot.
        path: the file to write.
        frames: which links on fixed joints stay: "all"; "effectors", those that the semantics name: end effectors,
            soles, cameras, sensors; or "none", one link for each body. The mass of the others goes to what carries
            them.
        names: "naoqi", those of the robot's own file, or "ros", those of its published ROS description.
        meshes: "relative" copies them to a folder "meshes" beside the file; "absolute" names them where they are;
            "package://NAME" names them in the folder "meshes" of a ROS package, "package://NAME/FOLDER" in a folder of
            it, and copies nothing; "none" leaves meshes out and keeps boxes, cylinders and spheres.
        coupling: joints that follow another one "mimic" it, are "locked" together with it, or are "independent".
        inertia: "published", or "physical": the nearest that bodies can have, see
            `nao_kin.export.inertia.make_physical`; and a mass of 0 in words where a link has none, for
            PyBullet takes silence for 1 kg.
        typed: write three joints with one centre as `type="spherical"`, which PyBullet and MuJoCo read and most others
            do not.
        axes: "published", as in the robot's file; "aligned" turns the frame of a joint whose axis is oblique until the
            axis is its z axis, for tools that take no other axes than those of the frame. Links stay as they are.
        overwrite: replace files that are there.

    Returns:
        The file, all files written, and what in them differs from the robot.

    Raises:
        UnknownName: no such choice of an option.
        BadArgument: a mesh is missing, the robot has no ROS names, a file is there, or it cannot be written.

    Examples:
        >>> done = nk.export.urdf(nk.load_nao("v6"), "nao.urdf", frames="none", meshes="none", inertia="physical")
        >>> done.path.name, done.changes[0]
        ('nao.urdf', 'base_link has neither mass nor shapes: torso is the root instead of it')
        >>> nk.RobotModel.from_urdf("nao.urdf").link_names[0]
        'torso'
    """
    target = Target(robot, path, overwrite=overwrite)
    tree, changes = Variant(frames, names, coupling, inertia, typed, axes).tree_of(robot)
    if inertia == "physical":
        tree, massless = _said_massless(tree)
        changes = (*changes, *massless)
    taken = taken_meshes(tree, meshes, _package(meshes))
    text, unsaid = urdf_document(tree, taken.names)
    return target.write({"": text.encode(), **taken.files}, (*changes, *unsaid, *taken.notes))


def _said_massless(tree: UrdfTree) -> tuple[UrdfTree, tuple[str, ...]]:
    """The tree with a mass of 0 for every link but the root that has no word about its mass."""
    nothing = Inertial(0.0, Origin(), (0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    silent = [link for link in tree.links if link not in tree.inertials and link != tree.root]
    tree = replace(tree, inertials={**tree.inertials, **dict.fromkeys(silent, nothing)})
    return tree, (f"{len(silent)} links without mass are given a mass of 0 in words",) if silent else ()


def _package(meshes: object) -> str:
    """The folder of meshes that a `package://` names; "" for the choices without one.

    Raises:
        UnknownName: neither.
    """
    if meshes in ("relative", "absolute", "none"):
        return ""
    start = "package://"
    inside = meshes.removeprefix(start).strip("/") if isinstance(meshes, str) else ""
    if not isinstance(meshes, str) or not meshes.startswith(start) or not inside or set(inside) & set(" \t\n\\"):
        raise UnknownName("choice of meshes", meshes, MESHES)
    return start + (inside if "/" in inside else f"{inside}/{MESH_FOLDER}")
