"""A robot as a folder for MuJoCo: its file, a scene beside it, and its meshes."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from nao_kin._common.folders import check_folder, write_folder
from nao_kin._common.optional import need_extra
from nao_kin._text import abbreviated
from nao_kin.errors import BadModel, UnknownName
from nao_kin.export.exported import Exported
from nao_kin.export.mujoco.actuators import add_actuators
from nao_kin.export.mujoco.bodies import Bodies, bodies_of, give_the_root_mass
from nao_kin.export.mujoco.contacts import add_excludes
from nao_kin.export.mujoco.exact import exact_xml
from nao_kin.export.mujoco.feet import on_their_soles
from nao_kin.export.mujoco.keyframes import add_keyframes
from nao_kin.export.mujoco.mesh_files import FOLDER, MeshFiles
from nao_kin.export.mujoco.scene import NAME, scene_xml
from nao_kin.export.mujoco.sensors import add_sites
from nao_kin.export.mujoco.shapes import Shapes
from nao_kin.export.mujoco.skeleton import add_bodies
from nao_kin.export.variants.coupling import Coupling, couple
from nao_kin.export.variants.frames import FRAMES, Frames
from nao_kin.export.variants.inertia import InertiaChoice, make_physical
from nao_kin.export.variants.typed import check_typed
from nao_kin.joints import group_joints
from nao_kin.robot import RobotModel, check_robot
from nao_kin.urdf import UrdfTree

_MESHES = ("relative", "none")
_BASES = ("floating", "fixed")


def mjcf(
    robot: RobotModel,
    folder: Path | str,
    *,
    base: str = "floating",
    frames: Frames = "all",
    coupling: Coupling = "mimic",
    inertia: InertiaChoice = "physical",
    meshes: str = "relative",
    typed: bool = False,
    overwrite: bool = False,
) -> Exported:
    """A robot for MuJoCo: a folder with its file, `scene.xml` that puts it on a floor, and its meshes in `assets/`.

    Names are the robot's own: a joint has its name, and so has the position actuator that drives it; a body has the
    name of its link, and every other link is a site. Forward kinematics is the robot's to rounding. Key frames are its
    postures, with the robot set down on the floor z = 0, and controls that hold it there.

    Sensors are named by what they belong to and what they say: `<joint>_position` and `<joint>_velocity`,
    `<frame>_acceleration`, `<frame>_angular_velocity`, `<frame>_force`, and `<root>_orientation`.

    Gains, damping and rotor inertias are estimates from the published efforts and speeds:
    `nao_kin.export.mujoco.actuators` says how. docs/mujoco.md tells how to use what is written.

    Args:
        robot: any robot.
        folder: where to; the folder it lies in must be there.
        base: "floating" for a free joint at the root, or "fixed".
        frames: which links that move with another one are sites: "all", "effectors" for those that the semantics name,
            or "none". Frames of sensors are sites always.
        coupling: "mimic" makes an equality of each joint that follows another, "locked" fixes both, "independent" gives
            the follower an actuator of its own.
        inertia: "physical" mends what no body can have, and MuJoCo refuses; "published" leaves them as they are.
        meshes: "relative" copies mesh files, "none" leaves out the shapes that need them.
        typed: make one body of what carries several axes through one point: two hinges of one body for a universal
            joint, a ball for a spherical one. MuJoCo couples joints of one coordinate only, so that a spherical joint
            with a coupled axis stays three hinges, of one body; with coupling="independent" it is a ball. Links between
            such axes are held to the body before.
        overwrite: replace a folder that is there.

    Returns:
        The path of the scene, the files, and what differs from the robot.

    Raises:
        BadArgument: no robot, a mesh is not there or cannot be read, the folder is there or cannot be written.
        UnknownName: no such choice.
        BadModel: MuJoCo refuses the robot.
        MissingExtra: MuJoCo is not installed.

    Examples:
        >>> import mujoco
        >>> done = nk.export.mjcf(nk.load_nao("v6"), "nao_mujoco")
        >>> model = mujoco.MjModel.from_xml_path(str(done.path))
        >>> model.nu, model.key(0).name, round(float(model.body_mass.sum()), 2)
        (25, 'StandInit', 5.36)
    """
    check_robot(robot)
    check_folder(folder, overwrite=overwrite)
    for what, value, valid in (
        ("base", base, _BASES),
        ("choice of meshes", meshes, _MESHES),
        ("choice of frames", frames, FRAMES),
    ):
        if value not in valid:
            raise UnknownName(what, value, valid)
    check_typed(typed)
    need_extra("the export for MuJoCo", "mujoco")
    import mujoco

    tree, coupled = couple(robot.tree, coupling)
    tree, mended = make_physical(tree, inertia)
    bodies = bodies_of(tree, group_joints(RobotModel(tree)) if typed else None)
    if base == "floating" and inertia == "physical":
        mended += give_the_root_mass(bodies)
    tree, lowered = on_their_soles(tree, bodies, robot.semantics)
    files = MeshFiles(tree) if meshes == "relative" else None
    spec = mujoco.MjSpec()
    notes = _fill(spec, robot, tree, bodies, files, frames=frames, floating=base == "floating")
    try:
        add_keyframes(spec, robot, bodies, floating=base == "floating")
        apart = add_excludes(spec)
        model = spec.compile()
    except ValueError as error:
        hint = "" if inertia == "physical" else "; inertia='physical' mends what no body can have"
        raise BadModel(f"MuJoCo refuses {tree.name}: {abbreviated(error)}{hint}") from None
    name = _file_name(tree.name)
    contents = {NAME: scene_xml(name, model).encode(), name: exact_xml(spec).encode()}
    contents |= {f"{FOLDER}/{mesh}": content for mesh, content in (files.contents if files else {}).items()}
    written = write_folder(folder, contents, overwrite=overwrite)
    return Exported(
        Path(folder) / NAME, written, (*coupled, *mended, *_merged(bodies, typed), *lowered, *notes, *apart)
    )


def _fill(
    spec: Any,
    robot: RobotModel,
    tree: UrdfTree,
    bodies: Bodies,
    files: MeshFiles | None,
    *,
    frames: str,
    floating: bool,
) -> tuple[str, ...]:
    """Write the robot into an empty specification; one line for each thing that is not as the robot has it."""
    import mujoco

    spec.modelname = tree.name
    spec.compiler.degree = False
    spec.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE
    spec.meshdir = FOLDER
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 10.0  # feet do not creep
    added = add_bodies(spec, bodies, floating=floating)
    shapes = Shapes(spec, added, bodies, files).add(tree)
    if files is not None:
        spec.assets = {f"{FOLDER}/{name}": content for name, content in files.contents.items()}
    sites = add_sites(spec, added, bodies, tree, robot.semantics, frames)
    return (*shapes, *sites, *add_actuators(spec, bodies.joints()))


def _merged(bodies: Bodies, typed: bool) -> tuple[str, ...]:
    """One line for the links between merged axes, and one for each three axes that no ball is made of, and why."""
    notes = [
        f"{', '.join(joint.name for joint in body.joints)} stay three hinges of one body, for MuJoCo couples no balls; "
        "coupling='independent' (--coupling independent) makes a ball of them"
        for body in bodies.bodies
        if len(body.joints) == 3
    ]
    if bodies.between:
        notes.append(f"{', '.join(sorted(bodies.between))} stand between merged axes: held to the bodies before them")
    if typed and not any(
        len(body.joints) > 1 or "ball" in {joint.kind for joint in body.joints} for body in bodies.bodies
    ):
        notes.append("no joints have one centre: there is nothing to merge")
    return tuple(notes)


def _file_name(robot: str) -> str:
    """Name of the robot's file: letters, digits, dot, dash and underscore, and not that of the scene."""
    stem = re.sub(r"[^A-Za-z0-9._-]+", "_", robot).strip("._") or "robot"
    return f"{stem}.xml" if f"{stem}.xml" != NAME else "robot.xml"
