"""Export of a robot as an SDFormat model, for Gazebo and Drake."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree as ET

from nao_kin._core.arrays import choice
from nao_kin._core.text import quoted, with_underscores
from nao_kin.errors import BadArgument
from nao_kin.export.inertia import IDENTITY, hosts
from nao_kin.export.meshes import taken_meshes
from nao_kin.export.pipeline import Destination, Exported, add_texts, number_texts, numbers, primitive_texts, xml_text
from nao_kin.export.variants import Variant
from nao_kin.robot import RobotModel
from nao_kin.robot.urdf import TENSOR_LABELS, Collision, Inertial, MeshFile, Origin, UrdfJoint, UrdfTree, Visual

# --- The text of an SDFormat model, as Gazebo and Drake read it.
#
# Source: SDFormat specification 1.11 (sdformat.org/spec), "Specifying pose in SDFormat", "Mimic joints"; Drake,
# "Parsing Models for MultibodyPlant", `drake:mimic`.

VERSION = "1.11"
DRAKE = "http://drake.mit.edu"
# Reserved names, and the separator of names of nested models.
WORLD = "world"
_RESERVED = (WORLD, "__root__", "__model__")
_SEPARATOR = "::"
# The inertia of a root without mass, because SDFormat assumes 1 kg.
_NEGLIGIBLE = Inertial(1e-3, IDENTITY, (1e-7, 0.0, 0.0, 1e-7, 0.0, 1e-7))


# Name of a frame that is not a link → its link, and its pose there.
Frames = Mapping[str, tuple[str, Origin]]


def frames_of(tree: UrdfTree, bodies: UrdfTree) -> Frames:
    """Return the links of a tree that are not among the bodies, as frames on these."""
    gone = set(tree.links) - set(bodies.links)
    places = hosts(tree, gone)
    if tree.root in gone:  # replaced by the link at the same pose
        places[tree.root] = bodies.root, IDENTITY
    return {link: places[link] for link in tree.links if link in gone}


def sdf_document(
    bodies: UrdfTree, frames: Frames, meshes: Mapping[str, str] | None, *, fixed: bool
) -> tuple[str, tuple[str, ...]]:
    """Return the SDFormat model of a robot with one link for each body, and one line for each change.

    `meshes` maps mesh names in the tree to addresses, None leaves meshes out; `fixed` attaches the root to the world.
    """
    changes: list[str] = []
    new = _fresh_names(bodies, frames, changes)
    ET.register_namespace("drake", DRAKE)
    root = ET.Element("sdf", {"version": VERSION, "xmlns:drake": DRAKE})
    model = ET.SubElement(root, "model", name=bodies.name, canonical_link=new[bodies.root])
    above = {joint.child: joint for joint in bodies.joints}
    if fixed:
        taken = {*new.values(), *(joint.name for joint in bodies.joints)}
        joint = ET.SubElement(model, "joint", name=with_underscores("world_joint", taken), type="fixed")
        add_texts(joint, {"parent": WORLD, "child": new[bodies.root]})
    for link in (bodies.root, *(joint.child for joint in bodies.joints)):
        element = ET.SubElement(model, "link", name=new[link])
        if link in above:
            ET.SubElement(element, "pose", relative_to=above[link].name).text = _pose(IDENTITY)
        _add_body(element, bodies, link, meshes, changes)
        if link in above:
            _add_joint(model, above[link], new)
    for name, (link, origin) in frames.items():
        frame = ET.SubElement(model, "frame", name=new[name], attached_to=new[link])
        add_texts(frame, {"pose": _pose(origin)})
    return xml_text(root), tuple(changes)


def _fresh_names(bodies: UrdfTree, frames: Frames, changes: list[str]) -> dict[str, str]:
    """Return link or frame → a name that no joint has: names of links, joints and frames must be unique."""
    joints = {joint.name for joint in bodies.joints}
    places = (*bodies.links, *frames)
    for name in (bodies.name, *joints, *(place for place in places if place != WORLD)):
        if _SEPARATOR in name or name in _RESERVED or (name.startswith("__") and name.endswith("__")):
            raise BadArgument(f"SDFormat reserves the name {quoted(name)}")
    double = sorted(joints & frames.keys())
    if double:
        raise BadArgument(f"in SDFormat names are unique, and {quoted(double[0])} is a joint and a frame")
    taken = {*joints, *places}
    new = {place: place for place in places}
    if WORLD in new:
        new[WORLD] = with_underscores(f"{WORLD}_link", taken)
        changes.append(f"link {WORLD} is called {new[WORLD]}: SDFormat reserves that name")
    for link in bodies.links:
        if link in joints:
            new[link] = with_underscores(f"{link}_link", taken)
            changes.append(f"link {link} is called {new[link]}: in SDFormat names are unique, and a joint has this one")
    return new


def _add_body(
    element: ET.Element, tree: UrdfTree, link: str, meshes: Mapping[str, str] | None, changes: list[str]
) -> None:
    body = tree.inertials.get(link)
    if body is None or body.mass <= 0.0:
        if link != tree.root:
            raise BadArgument(f"link {link} has no mass, which SDFormat refuses; inertia='physical' gives it one")
        body = _NEGLIGIBLE
        changes.append(f"{link} has no mass: written as {body.mass:g} kg")
    inertial = ET.SubElement(element, "inertial")
    add_texts(inertial, {"pose": _pose(body.origin), **number_texts({"mass": body.mass})})
    tensor = dict(zip(TENSOR_LABELS, body.inertia, strict=True))
    add_texts(ET.SubElement(inertial, "inertia"), number_texts(tensor))
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
    geometry = shape.geometry
    if isinstance(geometry, MeshFile):
        tag, texts = "mesh", {"uri": meshes[geometry.filename], "scale": numbers(geometry.scale)}
    else:
        tag, texts = primitive_texts(geometry)
    add_texts(ET.SubElement(ET.SubElement(element, "geometry"), tag), texts)
    if isinstance(shape, Visual) and shape.rgba is not None:
        colour = numbers(shape.rgba)
        add_texts(ET.SubElement(element, "material"), {"ambient": colour, "diffuse": colour})


def _add_joint(model: ET.Element, joint: UrdfJoint, new: Mapping[str, str]) -> None:
    endless = joint.kind == "revolute" and not math.isfinite(joint.upper - joint.lower)
    element = ET.SubElement(model, "joint", name=joint.name, type="continuous" if endless else joint.kind)
    ET.SubElement(element, "pose", relative_to=new[joint.parent]).text = _pose(joint.origin)
    add_texts(element, {"parent": new[joint.parent], "child": new[joint.child]})
    if joint.kind == "fixed":
        return
    axis = ET.SubElement(element, "axis")
    add_texts(axis, {"xyz": numbers(joint.axis)})
    bounds = {} if endless else {"lower": joint.lower, "upper": joint.upper}
    bounds |= {"effort": joint.effort, "velocity": joint.velocity}
    limits = {name: value for name, value in bounds.items() if math.isfinite(value)}
    add_texts(ET.SubElement(axis, "limit"), number_texts(limits))
    if joint.damping or joint.friction:
        losses = number_texts({"damping": joint.damping, "friction": joint.friction})
        add_texts(ET.SubElement(axis, "dynamics"), losses)
    if joint.mimic is not None:
        ratio = number_texts({"multiplier": joint.mimic.multiplier, "offset": joint.mimic.offset})
        add_texts(ET.SubElement(axis, "mimic", joint=joint.mimic.joint), ratio | {"reference": "0"})
        # Drake has another element for mimic joints.
        ET.SubElement(element, "drake:mimic", {"joint": joint.mimic.joint, **ratio})


def _pose(origin: Origin) -> str:
    return f"{numbers(origin.xyz)} {numbers(origin.rpy)}"


# --- The export.

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

    Each body is a link; links on fixed joints are frames on it. Mimic joints are coupled by `mimic` (SDFormat 1.11,
    Gazebo), and for Drake by `drake:mimic`.

    Args:
        robot: any robot.
        path: the folder; Gazebo finds it as model://NAME in a folder of GZ_SIM_RESOURCE_PATH.
        frames: which links on fixed joints become frames: "all", "effectors" or "none", as in `urdf`.
        names: as in `urdf`.
        meshes: "relative" copies them to the folder, "none" leaves them out.
        coupling: as in `urdf`.
        inertia: "physical" or "published", as in `urdf`; SDFormat has no links without mass.
        base: "floating", or "fixed" to attach the root link to the world.
        overwrite: replace the folder, if it contains only such a model.

    Returns:
        model.sdf, all files written, and their differences from the robot.

    Raises:
        BadArgument: a name that SDFormat reserves, a link without mass, a missing mesh, or an existing folder.

    Examples:
        >>> done = nk.export.sdf(nk.load_nao("v6"), "nao", frames="effectors", meshes="none")
        >>> [file.name for file in done.files]
        ['model.config', 'model.sdf']
    """
    target = Destination(path, overwrite=overwrite, folder=True)
    choice(meshes, MESHES, "choice of meshes")
    choice(base, BASES, "base")
    whole, _ = Variant(frames, names, coupling).tree_of(robot)
    bodies, changes = Variant("none", names, coupling, inertia).tree_of(robot)
    taken = taken_meshes(bodies, meshes)
    text, losses = sdf_document(bodies, frames_of(whole, bodies), taken.names, fixed=base == "fixed")
    files = {"model.config": _config(bodies.name).encode(), "model.sdf": text.encode(), **taken.files}
    return target.write(files, (*changes, *losses, *taken.notes), "model.sdf")


def _config(name: str) -> str:
    """Return the description of a model for Gazebo's list."""
    model = ET.Element("model")
    add_texts(model, {"name": name, "version": "1.0"})
    ET.SubElement(model, "sdf", version=VERSION).text = "model.sdf"
    add_texts(model, {"description": f"The robot {name}, written by nao_kin."})
    return xml_text(model)
