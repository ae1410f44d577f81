"""A robot as a model for Gazebo, which Drake reads too."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree as ET

from nao_kin._core.arrays import choice
from nao_kin._core.text import quoted, with_underscores
from nao_kin.errors import BadArgument
from nao_kin.export.inertia import HERE, hosts
from nao_kin.export.meshes import taken_meshes
from nao_kin.export.pipeline import Exported, Target, add_texts, xml_text
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
    Sphere as Ball,
    UrdfJoint,
    UrdfTree,
    Visual,
    srdf as writing,
)

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


# Name of a frame that is no link → the link it is on, and where.
Frames = Mapping[str, tuple[str, Origin]]


def frames_of(tree: UrdfTree, bodies: UrdfTree) -> Frames:
    """The links of a tree that are not among the bodies, as frames on these.

    Args:
        tree: the robot with all its links.
        bodies: the same robot with one link for each body.
    """
    gone = set(tree.links) - set(bodies.links)
    places = hosts(tree, gone)
    if tree.root in gone:  # it has given way to the one link that it holds at its own place
        places[tree.root] = bodies.root, HERE
    return {link: places[link] for link in tree.links if link in gone}


def sdf_document(
    bodies: UrdfTree, frames: Frames, meshes: Mapping[str, str] | None, *, held: bool
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
        add_texts(fixed, {"parent": WORLD, "child": new[bodies.root]})
    for link in (bodies.root, *(joint.child for joint in bodies.joints)):
        element = ET.SubElement(model, "link", name=new[link])
        if link in above:
            ET.SubElement(element, "pose", relative_to=above[link].name).text = _pose(HERE)
        _add_body(element, bodies, link, meshes, changes)
        if link in above:
            _add_joint(model, above[link], new)
    for name, (link, origin) in frames.items():
        frame = ET.SubElement(model, "frame", name=new[name], attached_to=new[link])
        add_texts(frame, {"pose": _pose(origin)})
    return xml_text(root), tuple(changes)


def _fresh_names(bodies: UrdfTree, frames: Frames, changes: list[str]) -> dict[str, str]:
    """Link or frame → a name that no joint has: links, joints and frames share one set of names."""
    joints = {joint.name for joint in bodies.joints}
    places = (*bodies.links, *frames)
    for name in (bodies.name, *joints, *(place for place in places if place != WORLD)):
        if _SEPARATOR in name or name in _RESERVED or (name.startswith("__") and name.endswith("__")):
            raise BadArgument(f"SDFormat keeps the name {quoted(name)} for itself")
    double = sorted(joints & frames.keys())
    if double:
        raise BadArgument(f"SDFormat gives a name once, and {quoted(double[0])} is a joint and a frame")
    taken = {*joints, *places}
    new = {place: place for place in places}
    if WORLD in new:
        new[WORLD] = with_underscores(f"{WORLD}_link", taken)
        changes.append(f"link {WORLD} is called {new[WORLD]}: SDFormat keeps that name for itself")
    for link in bodies.links:
        if link in joints:
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
    add_texts(inertial, {"pose": _pose(body.origin), "mass": writing.number(body.mass)})
    tensor = zip(writing.TENSOR_LABELS, map(writing.number, body.inertia), strict=True)
    add_texts(ET.SubElement(inertial, "inertia"), dict(tensor))
    shapes: Mapping[str, tuple[Visual | Collision, ...]] = {"visual": tree.visuals, "collision": tree.collisions}
    for tag, several in shapes.items():
        taken: set[str] = set()
        for shape in several:
            if shape.link == link and not (meshes is None and isinstance(shape.geometry, MeshFile)):
                name = with_underscores(shape.name or f"{link}_{tag}", taken)
                taken.add(name)
                _add_shape(ET.SubElement(element, tag, name=name), shape, meshes or {})


def _add_shape(element: ET.Element, shape: Visual | Collision, meshes: Mapping[str, str]) -> None:
    add_texts(element, {"pose": _pose(shape.origin)})
    tag, texts = _geometry(shape.geometry, meshes)
    add_texts(ET.SubElement(ET.SubElement(element, "geometry"), tag), texts)
    if isinstance(shape, Visual) and shape.rgba is not None:
        add_texts(
            ET.SubElement(element, "material"), dict.fromkeys(("ambient", "diffuse"), writing.numbers(shape.rgba))
        )


def _geometry(shape: Geometry, meshes: Mapping[str, str]) -> tuple[str, dict[str, str]]:
    """The element of a shape, and the texts in it."""
    if isinstance(shape, Box):
        return "box", {"size": writing.numbers(shape.size)}
    if isinstance(shape, Ball):
        return "sphere", {"radius": writing.number(shape.radius)}
    if isinstance(shape, Cylinder):
        return "cylinder", {"radius": writing.number(shape.radius), "length": writing.number(shape.length)}
    return "mesh", {"uri": meshes[shape.filename], "scale": writing.numbers(shape.scale)}


def _add_joint(model: ET.Element, joint: UrdfJoint, new: Mapping[str, str]) -> None:
    endless = joint.kind == "revolute" and not math.isfinite(joint.upper - joint.lower)
    element = ET.SubElement(model, "joint", name=joint.name, type="continuous" if endless else joint.kind)
    ET.SubElement(element, "pose", relative_to=new[joint.parent]).text = _pose(joint.origin)
    add_texts(element, {"parent": new[joint.parent], "child": new[joint.child]})
    if joint.kind == "fixed":
        return
    axis = ET.SubElement(element, "axis")
    add_texts(axis, {"xyz": writing.numbers(joint.axis)})
    bounds = {} if endless else {"lower": joint.lower, "upper": joint.upper}
    bounds |= {"effort": joint.effort, "velocity": joint.velocity}
    limits = {name: writing.number(value) for name, value in bounds.items() if math.isfinite(value)}
    add_texts(ET.SubElement(axis, "limit"), limits)
    if joint.damping or joint.friction:
        losses = {"damping": writing.number(joint.damping), "friction": writing.number(joint.friction)}
        add_texts(ET.SubElement(axis, "dynamics"), losses)
    if joint.mimic is not None:
        ratio = {"multiplier": writing.number(joint.mimic.multiplier), "offset": writing.number(joint.mimic.offset)}
        add_texts(ET.SubElement(axis, "mimic", joint=joint.mimic.joint), ratio | {"reference": "0"})
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
    add_texts(model, {"name": name, "version": "1.0"})
    ET.SubElement(model, "sdf", version=VERSION).text = "model.sdf"
    add_texts(model, {"description": f"The robot {name}, written by nao_kin."})
    return xml_text(model)
