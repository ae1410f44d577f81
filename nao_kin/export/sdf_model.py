"""A robot as a model for Gazebo, which Drake reads too."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree as ET

from nao_kin._common.folders import check_folder, write_folder
from nao_kin.errors import UnknownName
from nao_kin.export.exported import Exported
from nao_kin.export.meshes import MESH_FOLDER, mesh_names, read_files
from nao_kin.export.sdf_document import VERSION, frames_of, sdf_document
from nao_kin.export.urdf_export import variant
from nao_kin.robot import RobotModel, check_robot

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
    check_robot(robot)
    check_folder(path, overwrite=overwrite)
    for what, given, valid in (("meshes", meshes, MESHES), ("base", base, BASES)):
        if given not in valid:
            raise UnknownName(f"choice of {what}" if what == "meshes" else what, given, valid)
    whole, _ = variant(robot, frames=frames, names=names, coupling=coupling)
    bodies, changes = variant(robot, frames="none", names=names, coupling=coupling, inertia=inertia)
    inside, copied, left_out = ({}, {}, ()) if meshes == "none" else mesh_names(bodies)
    addresses = {mesh: f"{MESH_FOLDER}/{file}" for mesh, file in inside.items()}
    text, unsaid = sdf_document(
        bodies,
        frames_of(whole, bodies),
        addresses if meshes == "relative" else None,
        held=base == "fixed",
    )
    files = {"model.config": _config(bodies.name).encode(), "model.sdf": text.encode()}
    files |= {f"{MESH_FOLDER}/{name}": content for name, content in read_files(copied).items()}
    written = write_folder(path, files, overwrite=overwrite)
    return Exported(Path(path) / "model.sdf", written, (*changes, *unsaid, *left_out))


def _config(name: str) -> str:
    """What Gazebo lists of a model."""
    model = ET.Element("model")
    ET.SubElement(model, "name").text = name
    ET.SubElement(model, "version").text = "1.0"
    ET.SubElement(model, "sdf", version=VERSION).text = "model.sdf"
    ET.SubElement(model, "description").text = f"The robot {name}, written by nao_kin."
    ET.indent(model)
    return '<?xml version="1.0"?>\n' + ET.tostring(model, encoding="unicode") + "\n"
