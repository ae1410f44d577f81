"""Export of a robot as MuJoCo's format, MJCF."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree as ET
from xml.sax.saxutils import quoteattr

import numpy as np

from nao_kin._core.arrays import Floats, choice
from nao_kin._core.text import abbreviated
from nao_kin._core.warn import need_extra
from nao_kin.errors import BadModel
from nao_kin.export.meshes import FOLDER, TakenMeshes, assets
from nao_kin.export.pipeline import Destination, Exported, filled, numbers
from nao_kin.export.urdf import UNBOUNDED
from nao_kin.export.variants import Variant
from nao_kin.joints import group_joints
from nao_kin.robot import RobotModel

if TYPE_CHECKING:
    from nao_kin.export.mjcf_model import Bodies

# --- The scene of the robot: a floor, light, and a viewpoint.

NAME = "scene.xml"


def scene_xml(robot_file: str, model: Any, floor: float) -> str:
    """Return a scene that includes the robot's file, at the scale of the compiled robot, with a floor at a height."""
    extent = float(model.stat.extent)
    return filled(
        "scene.xml",
        title=quoteattr(f"{robot_file.removesuffix('.xml')} on a floor"),
        file=quoteattr(robot_file),
        extent=f"{extent:.3g}",
        floor=f"{floor:g}",
        centre=f"{floor + 0.4 * extent:.3g}",
        above=f"{floor + 1.5 * extent:.3g}",
    )


# --- Full precision: MuJoCo writes six digits, an error of some micrometres at the feet.

# Element → its list in the specification, its parent in the document, and attributes with the same names in both.
_EXACT = {
    "body": ("bodies", "worldbody", ("pos", "quat")),
    "joint": ("joints", "worldbody", ("axis", "range", "damping", "armature", "frictionloss")),
    "geom": ("geoms", "worldbody", ("pos", "quat", "size")),
    "site": ("sites", "worldbody", ("pos", "quat", "size")),
    "camera": ("cameras", "worldbody", ("pos", "quat", "fovy")),
    "position": ("actuators", "actuator", ("ctrlrange", "forcerange")),
    "key": ("keys", "keyframe", ("qpos", "ctrl")),
}
_DEFAULTS = {"pos": (0.0, 0.0, 0.0), "quat": (1.0, 0.0, 0.0, 0.0)}
# MuJoCo's text must have the same number, to its six digits.
_ROUNDED = 2e-5


def exact_xml(spec: Any) -> str:
    """Return the XML of a compiled specification, with its numbers at full precision."""
    root = ET.fromstring(spec.to_xml())
    for actuator, element in _pairs(spec.actuators, root.iterfind("actuator/general")):
        _as_position(element, kp=actuator.gainprm[0], kv=-actuator.biasprm[2])
    for tag, (source, part, attributes) in _EXACT.items():
        for one, element in _pairs(getattr(spec, source), root.iterfind(f"{part}//{tag}")):
            for attribute in attributes:
                _put(element, attribute, np.atleast_1d(getattr(one, attribute)))
    for body, element in _pairs(spec.bodies, root.iterfind("worldbody//body")):
        inertial = element.find("inertial")
        if inertial is not None:
            values = {"pos": body.ipos, "mass": [body.mass], "fullinertia": body.fullinertia}
            inertial.attrib = {name: numbers(value) for name, value in values.items()}
    for equality, element in _pairs(spec.equalities, root.iterfind("equality/joint")):
        element.set("polycoef", numbers(equality.data[:5]))
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def _pairs(named: Iterable[Any], elements: Iterable[ET.Element]) -> Iterator[tuple[Any, ET.Element]]:
    """Yield each named element with the part of the specification of that name; skip elements of a class."""
    by_name = {one.name: one for one in named}
    return ((by_name[element.get("name", "")], element) for element in elements if element.get("name"))


def _as_position(element: ET.Element, *, kp: float, kv: float) -> None:
    """Make a position actuator of a general one; MuJoCo 4 writes `input="pos"`, which early MuJoCo 3 refuses."""
    for attribute in ("input", "gaintype", "biastype", "gainprm", "biasprm"):
        element.attrib.pop(attribute, None)
    element.tag = "position"
    element.attrib |= {"kp": numbers([kp]), "kv": numbers([kv])}


def _put(element: ET.Element, attribute: str, exact: Floats) -> None:
    written = element.get(attribute)
    if written is None:
        default = _DEFAULTS.get(attribute)
        if default is not None and tuple(exact) != default and np.allclose(exact, default, atol=_ROUNDED):
            element.set(attribute, numbers(exact))
        return
    rough = [float(word) for word in written.split()]
    exact = exact[: len(rough)]
    if np.allclose(rough, exact, rtol=_ROUNDED, atol=1e-12):
        element.set(attribute, numbers(exact))


# --- The export.

_MESHES = ("relative", "none")
_BASES = ("floating", "fixed")


def mjcf(
    robot: RobotModel,
    folder: Path | str,
    *,
    base: str = "floating",
    frames: str = "all",
    coupling: str = "mimic",
    inertia: str = "physical",
    meshes: str = "relative",
    typed: bool = False,
    overwrite: bool = False,
) -> Exported:
    """Write a folder for MuJoCo: the robot's file, `scene.xml` with the robot on a floor, and its meshes in `assets/`.

    Names are the robot's: a joint has its name, and so has the position actuator that drives it; a body has the name of
    its link, and every other link is a site. Forward kinematics is the robot's to rounding. Key frames are its
    postures, with the robot on the floor z = 0, and controls that hold it there.

    Sensors are named after their part and quantity: `<joint>_position` and `<joint>_velocity`,
    `<frame>_acceleration`, `<frame>_angular_velocity`, `<frame>_force`, and `<root>_orientation`.

    Gains, damping and rotor inertias are estimates from the published efforts and speeds, described in
    `nao_kin.export.mjcf_model`. docs/mujoco.md shows how to use the files.

    Args:
        robot: any robot.
        folder: the folder to write; its parent must exist.
        base: "floating" for a free joint at the root, or "fixed", with a floor below all key frames.
        frames: which links without a body of their own are sites: "all", "effectors" for those named in the semantics,
            or "none". Frames of sensors are always sites.
        coupling: "mimic" makes an equality for each mimic joint, "locked" fixes it and its driver, "independent" gives
            the mimic joint its own actuator.
        inertia: "physical" corrects impossible inertias, which MuJoCo refuses; "published" does not change them.
        meshes: "relative" copies mesh files, "none" leaves out the shapes that need them.
        typed: make one body of several joints with axes through one point: two hinges of one body for a universal
            joint, a ball for a spherical one. MuJoCo couples only joints of one coordinate, so a spherical joint with a
            coupled axis stays three hinges of one body; with coupling="independent" it is a ball. Links between such
            axes are fixed to the body before them.
        overwrite: replace an existing folder.

    Returns:
        The path of the scene, the files, and the differences from the robot.

    Raises:
        BadArgument: a mesh is missing or cannot be read, or the folder exists.
        BadModel: MuJoCo refuses the robot.
        MissingExtra: MuJoCo is not installed.

    Examples:
        >>> import mujoco
        >>> done = nk.export.mjcf(nk.load_nao("v6"), "nao_mujoco")
        >>> model = mujoco.MjModel.from_xml_path(str(done.path))
        >>> model.nu, model.key(0).name, round(float(model.body_mass.sum()), 2)
        (25, 'StandInit', 5.36)
    """
    target = Destination(folder, overwrite=overwrite, folder=True)
    floating = choice(base, _BASES, "base") == "floating"
    choice(meshes, _MESHES, "choice of meshes")
    chosen = Variant(frames, coupling=coupling, inertia=inertia, typed=typed)
    need_extra("the export for MuJoCo", "mujoco")
    import mujoco

    from nao_kin.export import mjcf_model

    # Links on fixed joints become sites, and merged joints are joints of one body.
    tree, changes = replace(chosen, frames="all", typed=False).tree_of(robot)
    groups = group_joints(RobotModel(tree)) if typed else None
    bodies = mjcf_model.bodies_of(tree, groups, robot.semantics.stall_torques)
    if floating and inertia == "physical":
        changes += mjcf_model.give_the_root_mass(bodies)
    tree, lowered = mjcf_model.on_their_soles(tree, bodies, robot.semantics)
    taken = assets(tree) if meshes == "relative" else TakenMeshes(None)
    spec = mujoco.MjSpec()
    spec.modelname = tree.name
    spec.compiler.degree = False
    spec.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE
    spec.meshdir = FOLDER
    spec.assets = dict(taken.files)
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 10.0  # feet do not creep
    added = mjcf_model.add_bodies(spec, bodies, floating=floating)
    halves = (row for row in tree.moving_joints if row.mimic is None and np.isfinite([row.lower, row.upper]).sum() == 1)
    notes = (
        *taken.notes,
        *(f"{row.name} has one limit, and the other is written as ±{UNBOUNDED:g}" for row in halves),
        *mjcf_model.add_shapes(spec, added, bodies, tree, taken.names),
        *mjcf_model.add_sites(spec, added, bodies, tree, robot.semantics, frames),
        *mjcf_model.add_actuators(spec, bodies.joints()),
    )
    try:
        mjcf_model.add_keyframes(spec, robot, bodies, floating=floating)
        excludes = mjcf_model.add_excludes(spec)
        model = spec.compile()
    except ValueError as error:
        hint = "" if inertia == "physical" else "; inertia='physical' corrects impossible inertias"
        raise BadModel(f"MuJoCo refuses {tree.name}: {abbreviated(error)}{hint}") from None
    # Letters, digits, dot, dash and underscore, different from the name of the scene.
    stem = re.sub(r"[^A-Za-z0-9._-]+", "_", tree.name).strip("._") or "robot"
    name = f"{stem}.xml" if f"{stem}.xml" != NAME else "robot.xml"
    floor = 0.0 if floating else mjcf_model.floor_below(model)
    files = {NAME: scene_xml(name, model, floor).encode(), name: exact_xml(spec).encode(), **taken.files}
    return target.write(files, (*changes, *_merging_notes(bodies, typed), *lowered, *notes, *excludes), NAME)


def _merging_notes(bodies: Bodies, typed: bool) -> tuple[str, ...]:
    """Return one line for the links between merged axes, and one for each set of three axes that cannot be a ball."""
    notes = [
        f"{', '.join(joint.name for joint in body.joints)} stay three hinges of one body, because MuJoCo couples no "
        "balls; coupling='independent' (--coupling independent) makes a ball of them"
        for body in bodies.bodies
        if len(body.joints) == 3
    ]
    if bodies.between:
        notes.append(f"{', '.join(sorted(bodies.between))} are between merged axes: fixed to the bodies before them")
    if typed and not any(sum(len(joint.axes) for joint in body.joints) > 1 for body in bodies.bodies):
        notes.append("no joints have one centre: there is nothing to merge")
    return tuple(notes)
