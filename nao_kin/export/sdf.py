"""A robot as a model for Gazebo, which Drake reads too."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree as ET

from nao_kin._core.arrays import choice
from nao_kin._core.text import quoted, with_underscores
from nao_kin.errors import BadArgument
from nao_kin.export.inertia import HERE, hosts
from nao_kin.export.meshes import taken_meshes
from nao_kin.export.pipeline import Exported, Target, xml_text
from nao_kin.export.variants import Variant
from nao_kin.robot import RobotModel
from nao_kin.robot.urdf import (
    Box,
    Collision,
    Cylinder,
    Geometry,
    Inertial,
    MeshFile,
    Origin,
    UrdfJoint,
    UrdfTree,
    Visual,
)
from nao_kin.robot.urdf import Sphere as Ball
from nao_kin.robot.urdf import srdf as writing

# --- A robot's tree as the text of an SDFormat model, as Gazebo and Drake read it.
#
# Source: SDFormat specification 1.11 (sdformat.org/spec), "Specifying pose in SDFormat", "Mimic joints"; Drake,
# "Parsing Models for MultibodyPlant", `drake:mimic`.

VERSION = "1.11"
DRAKE = "http://drake.mit.edu"
# Names that mean something of their own, and what separates the names of nested models.
WORLD = "world"
_RESERVED = (WORLD, "__root__", "__model__")
_SEPARATOR = "::"
# What a root without mass weighs, for SDFormat takes a link without one to weigh 1 kg.
_NEXT_TO_NOTHING = Inertial(1e-3, HERE, (1e-7, 0.0, 0.0, 1e-7, 0.0, 1e-7))


@dataclass(frozen=True)
class Frame:
    """A frame that is no link: its name, the link it is on, and where."""

    name: str
    link: str
    origin: Origin


def frames_of(tree: UrdfTree, bodies: UrdfTree) -> tuple[Frame, ...]:
    """The links of a tree that are not among the bodies, as frames on these.

    Args:
        tree: the robot with all its links.
        bodies: the same robot with one link for each body.
    """
    gone = set(tree.links) - set(bodies.links)
    places = hosts(tree, gone)
    if tree.root in gone:  # it has given way to the one link that it holds at its own place
        places[tree.root] = bodies.root, HERE
    return tuple(Frame(link, *places[link]) for link in tree.links if link in gone)


def sdf_document(
    bodies: UrdfTree, frames: tuple[Frame, ...], meshes: Mapping[str, str] | None, *, held: bool
) -> tuple[str, tuple[str, ...]]:
    """The SDFormat model.

    Args:
        bodies: the robot, one link for each body.
        frames: what else has a name on it.
        meshes: name of a mesh in the tree → its address in the file; None to leave meshes out.
        held: hold the root link in the world.

    Returns:
        The document, ending in a newline, and one line for each thing that had to change.

    Raises:
        BadArgument: names that SDFormat keeps for itself, or gives to one thing only; a body without mass.
    """
    changes: list[str] = []
    new = _fresh_names(bodies, frames, changes)
    ET.register_namespace("drake", DRAKE)
    root = ET.Element("sdf", {"version": VERSION, "xmlns:drake": DRAKE})
    model = ET.SubElement(root, "model", name=bodies.name, canonical_link=new[bodies.root])
    above = {joint.child: joint for joint in bodies.joints}
    if held:
        taken = {*new.values(), *(joint.name for joint in bodies.joints)}
        fixed = ET.SubElement(model, "joint", name=with_underscores("world_joint", taken), type="fixed")
        ET.SubElement(fixed, "parent").text = WORLD
        ET.SubElement(fixed, "child").text = new[bodies.root]
    for link in (bodies.root, *(joint.child for joint in bodies.joints)):
        element = ET.SubElement(model, "link", name=new[link])
        if link in above:
            ET.SubElement(element, "pose", relative_to=above[link].name).text = _pose(HERE)
        _add_body(element, bodies, link, meshes, changes)
        if link in above:
            _add_joint(model, above[link], new)
    for frame in frames:
        element = ET.SubElement(model, "frame", name=new[frame.name], attached_to=new[frame.link])
        ET.SubElement(element, "pose").text = _pose(frame.origin)
    return xml_text(root), tuple(changes)


def _fresh_names(bodies: UrdfTree, frames: tuple[Frame, ...], changes: list[str]) -> dict[str, str]:
    """Link or frame → a name that no joint has: links, joints and frames share one set of names."""
    joints = {joint.name for joint in bodies.joints}
    places = (*bodies.links, *(frame.name for frame in frames))
    for name in (bodies.name, *joints, *(place for place in places if place != WORLD)):
        if _SEPARATOR in name or name in _RESERVED or (name.startswith("__") and name.endswith("__")):
            raise BadArgument(f"SDFormat keeps the name {quoted(name)} for itself")
    named = [*joints, *(frame.name for frame in frames)]
    double = sorted({name for name in named if named.count(name) > 1})
    if double:
        raise BadArgument(f"SDFormat gives a name once, and {quoted(double[0])} is a joint and a frame")
    taken = {*joints, *places}
    new = {place: place for place in places}
    if WORLD in new:
        new[WORLD] = with_underscores(f"{WORLD}_link", taken)
        changes.append(f"link {WORLD} is called {new[WORLD]}: SDFormat keeps that name for itself")
    for link in bodies.links:
        if link in named:
            new[link] = with_underscores(f"{link}_link", taken)
            changes.append(f"link {link} is called {new[link]}: SDFormat gives a name once, and a joint has it")
    return new


def _add_body(
    element: ET.Element, tree: UrdfTree, link: str, meshes: Mapping[str, str] | None, changes: list[str]
) -> None:
    body = tree.inertials.get(link)
    if body is None or body.mass <= 0.0:
        if link != tree.root:
            raise BadArgument(f"link {link} has no mass, which SDFormat does not take; inertia='physical' gives it one")
        body = _NEXT_TO_NOTHING
        changes.append(f"{link} has no mass: written as {body.mass:g} kg")
    inertial = ET.SubElement(element, "inertial")
    ET.SubElement(inertial, "pose").text = _pose(body.origin)
    ET.SubElement(inertial, "mass").text = writing.number(body.mass)
    tensor = ET.SubElement(inertial, "inertia")
    for label, value in zip(writing.TENSOR_LABELS, body.inertia, strict=True):
        ET.SubElement(tensor, label).text = writing.number(value)
    shapes: tuple[tuple[str, tuple[Visual | Collision, ...]], ...] = (
        ("visual", tree.visuals),
        ("collision", tree.collisions),
    )
    for tag, several in shapes:
        taken: set[str] = set()
        for shape in several:
            if shape.link == link and not (meshes is None and isinstance(shape.geometry, MeshFile)):
                name = with_underscores(shape.name or f"{link}_{tag}", taken)
                taken.add(name)
                _add_shape(ET.SubElement(element, tag, name=name), shape, meshes or {})


def _add_shape(element: ET.Element, shape: Visual | Collision, meshes: Mapping[str, str]) -> None:
    ET.SubElement(element, "pose").text = _pose(shape.origin)
    _add_geometry(ET.SubElement(element, "geometry"), shape.geometry, meshes)
    if isinstance(shape, Visual) and shape.rgba is not None:
        material = ET.SubElement(element, "material")
        for kind in ("ambient", "diffuse"):
            ET.SubElement(material, kind).text = writing.numbers(shape.rgba)


def _add_geometry(element: ET.Element, shape: Geometry, meshes: Mapping[str, str]) -> None:
    if isinstance(shape, Box):
        ET.SubElement(ET.SubElement(element, "box"), "size").text = writing.numbers(shape.size)
    elif isinstance(shape, Ball):
        ET.SubElement(ET.SubElement(element, "sphere"), "radius").text = writing.number(shape.radius)
    elif isinstance(shape, Cylinder):
        cylinder = ET.SubElement(element, "cylinder")
        ET.SubElement(cylinder, "radius").text = writing.number(shape.radius)
        ET.SubElement(cylinder, "length").text = writing.number(shape.length)
    else:
        mesh = ET.SubElement(element, "mesh")
        ET.SubElement(mesh, "uri").text = meshes[shape.filename]
        ET.SubElement(mesh, "scale").text = writing.numbers(shape.scale)


def _add_joint(model: ET.Element, joint: UrdfJoint, new: Mapping[str, str]) -> None:
    endless = joint.kind == "revolute" and not math.isfinite(joint.upper - joint.lower)
    element = ET.SubElement(model, "joint", name=joint.name, type="continuous" if endless else joint.kind)
    ET.SubElement(element, "pose", relative_to=new[joint.parent]).text = _pose(joint.origin)
    ET.SubElement(element, "parent").text = new[joint.parent]
    ET.SubElement(element, "child").text = new[joint.child]
    if joint.kind == "fixed":
        return
    axis = ET.SubElement(element, "axis")
    ET.SubElement(axis, "xyz").text = writing.numbers(joint.axis)
    limit = ET.SubElement(axis, "limit")
    bounds = {"lower": joint.lower, "upper": joint.upper, "effort": joint.effort, "velocity": joint.velocity}
    for name, value in bounds.items():
        if math.isfinite(value) and not (endless and name in ("lower", "upper")):
            ET.SubElement(limit, name).text = writing.number(value)
    if joint.damping or joint.friction:
        dynamics = ET.SubElement(axis, "dynamics")
        ET.SubElement(dynamics, "damping").text = writing.number(joint.damping)
        ET.SubElement(dynamics, "friction").text = writing.number(joint.friction)
    if joint.mimic is not None:
        ratio = {"multiplier": writing.number(joint.mimic.multiplier), "offset": writing.number(joint.mimic.offset)}
        mimic = ET.SubElement(axis, "mimic", joint=joint.mimic.joint)
        for name, text in (ratio | {"reference": "0"}).items():
            ET.SubElement(mimic, name).text = text
        # Drake has a word of its own for it.
        ET.SubElement(element, "drake:mimic", {"joint": joint.mimic.joint, **ratio})


def _pose(origin: Origin) -> str:
    return f"{writing.numbers(origin.xyz)} {writing.numbers(origin.rpy)}"


# --- A robot as a model for Gazebo, which Drake reads too.

MESHES = ("relative", "none")
BASES = ("floating", "fixed")


def sdf(
    robot: RobotModel,
    path: Path | str,
    *,
    frames: str = "all",
    names: str = "naoqi",
    meshes: str = "relative",
    coupling: str = "mimic",
    inertia: str = "physical",
    base: str = "floating",
    overwrite: bool = False,
) -> Exported:
    """Write the folder of an SDFormat model: model.sdf, model.config and the meshes.

    Each body is a link; what fixed joints hold is a frame on it. Joints that follow others are coupled by `mimic`
    (SDFormat 1.11, Gazebo), and for Drake by `drake:mimic`.

    Args:
        robot: the robot.
        path: the folder; Gazebo finds it as model://NAME in a folder of GZ_SIM_RESOURCE_PATH.
        frames: which links on fixed joints become frames: "all", "effectors" or "none", see `urdf`.
        names: see `urdf`.
        meshes: "relative" copies them to the folder, "none" leaves them out.
        coupling: see `urdf`.
        inertia: "physical" or "published", see `urdf`; SDFormat has no links without mass.
        base: "floating", or "fixed" to hold the root link in the world.
        overwrite: replace the folder, if it holds nothing but such a model.

    Returns:
        model.sdf, all files written, and what in them differs from the robot.

    Raises:
        UnknownName: no such choice of an option.
        BadArgument: a name that SDFormat keeps for itself, a link without mass, a missing mesh, or the folder is there.

    Examples:
        >>> done = nk.export.sdf(nk.load_nao("v6"), "nao", frames="effectors", meshes="none")
        >>> [file.name for file in done.files]
        ['model.config', 'model.sdf']
    """
    target = Target(robot, path, overwrite=overwrite, folder=True)
    choice(meshes, MESHES, "choice of meshes")
    choice(base, BASES, "base")
    whole, _ = Variant(frames, names, coupling).tree_of(robot)
    bodies, changes = Variant("none", names, coupling, inertia).tree_of(robot)
    taken = taken_meshes(bodies, meshes)
    text, unsaid = sdf_document(bodies, frames_of(whole, bodies), taken.names, held=base == "fixed")
    files = {"model.config": _config(bodies.name).encode(), "model.sdf": text.encode(), **taken.files}
    return target.write(files, (*changes, *unsaid, *taken.notes), "model.sdf")


def _config(name: str) -> str:
    """What Gazebo lists of a model."""
    model = ET.Element("model")
    ET.SubElement(model, "name").text = name
    ET.SubElement(model, "version").text = "1.0"
    ET.SubElement(model, "sdf", version=VERSION).text = "model.sdf"
    ET.SubElement(model, "description").text = f"The robot {name}, written by nao_kin."
    return xml_text(model)
