"""A robot as a URDF that another tool loads right."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from nao_kin._common.documents import check_replaceable, write_document
from nao_kin._text import quoted
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.export.exported import Exported
from nao_kin.export.meshes import MESH_FOLDER, mesh_names, read_files
from nao_kin.export.urdf_document import urdf_document
from nao_kin.export.variants.axes import align_axes
from nao_kin.export.variants.coupling import couple
from nao_kin.export.variants.frames import keep_frames
from nao_kin.export.variants.inertia import make_physical
from nao_kin.export.variants.names import name_frames
from nao_kin.export.variants.typed import merge_balls
from nao_kin.robot import RobotModel
from nao_kin.urdf import Inertial, Origin, UrdfTree

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
            `nao_kin.export.variants.inertia.make_physical`; and a mass of 0 in words where a link has none, for
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
    check_replaceable(path, overwrite=overwrite)
    tree, changes = variant(
        robot, frames=frames, names=names, coupling=coupling, inertia=inertia, typed=typed, axes=axes
    )
    if inertia == "physical":
        tree, massless = _said_massless(tree)
        changes = (*changes, *massless)
    named, copied, left_out = _named_meshes(tree, meshes)
    text, unsaid = urdf_document(tree, named)
    files = write_document(path, text.encode(), read_files(copied), overwrite=overwrite)
    return Exported(Path(path), files, (*changes, *unsaid, *left_out))


def variant(
    robot: RobotModel,
    *,
    frames: str = "all",
    names: str = "naoqi",
    coupling: str = "mimic",
    inertia: str = "published",
    typed: bool = False,
    axes: str = "published",
) -> tuple[UrdfTree, tuple[str, ...]]:
    """The tree of a robot in a variant, and one line for each change.

    Args:
        robot: any robot.
        frames: as in `urdf`.
        names: as in `urdf`.
        coupling: as in `urdf`.
        inertia: as in `urdf`.
        typed: as in `urdf`.
        axes: as in `urdf`.

    Raises:
        UnknownName: no such choice of an option.
        BadArgument: the robot has no ROS names.

    Examples:
        >>> tree, changes = nk.export.variant(nk.load_nao("v6"), frames="none", coupling="locked")
        >>> len(tree.links), len(tree.moving_joints)
        (23, 22)
    """
    if not isinstance(robot, RobotModel):
        raise BadArgument(f"expected a robot model, got {quoted(robot)}")
    tree, locked = couple(robot.tree, coupling)
    tree, balls = merge_balls(tree, typed)
    tree, gone = keep_frames(tree, frames, robot.semantics)
    tree, mended = make_physical(tree, inertia)
    tree, renamed = name_frames(tree, names, robot.semantics)
    tree, turned = align_axes(tree, axes)
    return tree, (*locked, *balls, *gone, *mended, *renamed, *turned)


def _said_massless(tree: UrdfTree) -> tuple[UrdfTree, tuple[str, ...]]:
    """The tree with a mass of 0 for every link but the root that has no word about its mass."""
    nothing = Inertial(0.0, Origin(), (0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    silent = [link for link in tree.links if link not in tree.inertials and link != tree.root]
    if not silent:
        return tree, ()
    inertials = {**tree.inertials, **dict.fromkeys(silent, nothing)}
    return replace(tree, inertials=inertials), (f"{len(silent)} links without mass are given a mass of 0 in words",)


def _named_meshes(tree: UrdfTree, meshes: str) -> tuple[dict[str, str] | None, dict[str, Path], tuple[str, ...]]:
    """Name of each mesh in the tree → its name in the URDF, None to leave it out; files to copy; and what is not."""
    if meshes == "none":
        return None, {}, ()
    package = _package(meshes)
    names, files, left_out = mesh_names(tree)
    if meshes == "relative":
        copied = {f"{MESH_FOLDER}/{name}": path for name, path in files.items()}
        return {name: f"{MESH_FOLDER}/{inside}" for name, inside in names.items()}, copied, left_out
    if meshes == "absolute":
        return {name: str(files[inside]) for name, inside in names.items()}, {}, ()
    return {name: f"{package}/{inside}" for name, inside in names.items()}, {}, ()


def _package(meshes: object) -> str:
    """The folder of meshes that a `package://` names; "" for the choices without one.

    Raises:
        UnknownName: neither.
    """
    if meshes in ("relative", "absolute"):
        return ""
    start = "package://"
    inside = meshes.removeprefix(start).strip("/") if isinstance(meshes, str) else ""
    if not isinstance(meshes, str) or not meshes.startswith(start) or not inside or set(inside) & set(" \t\n\\"):
        raise UnknownName("choice of meshes", meshes, MESHES)
    return start + (inside if "/" in inside else f"{inside}/{MESH_FOLDER}")
