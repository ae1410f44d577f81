"""A robot as a ROS 2 package."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from nao_kin._common.folders import check_folder, write_folder
from nao_kin._text import quoted
from nao_kin.errors import BadArgument, BadModel, UnknownName
from nao_kin.export import ros_texts
from nao_kin.export.coloured_meshes import coloured
from nao_kin.export.exported import Exported
from nao_kin.export.joint_values import joint_values
from nao_kin.export.meshes import MESH_FOLDER, mesh_names, read_files
from nao_kin.export.srdf_document import srdf_document
from nao_kin.export.urdf_document import urdf_document
from nao_kin.export.urdf_export import variant
from nao_kin.robot import RobotModel, check_robot
from nao_kin.urdf import UrdfTree

MESHES = ("package", "none")

# REP 149 and its schema; REP 144 asks for two characters at least.
_NAME = re.compile(r"[a-z](_?[a-z0-9]+)*", re.ASCII)
_VERSION = re.compile(r"\d+\.\d+\.\d+", re.ASCII)
_PERSON = re.compile(r"\s*([^<>]*[^<>\s])\s*<([-\w.+]+@[-\w]+(?:\.[-\w]+)*)>\s*")

NOBODY = "TODO <todo@todo.todo>"
_NO_LICENCE = "TODO: License declaration"


def ros2(
    robot: RobotModel,
    path: Path | str,
    *,
    package: str | None = None,
    package_version: str = "0.1.0",
    maintainer: str = NOBODY,
    license: str | None = None,
    names: str | None = None,
    frames: str = "all",
    meshes: str = "package",
    coupling: str = "mimic",
    inertia: str = "published",
    samples: int = 10_000,
    seed: int = 0,
    overwrite: bool = False,
) -> Exported:
    """Write a ROS 2 package: the robot's URDF and meshes, its SRDF, and a launch file that shows it in RViz.

    The folder builds with colcon; `ros2 launch PACKAGE display.launch.py` then opens RViz with a slider for each joint.
    Meshes are named by `package://`, and .obj files get the colours that the URDF gives them, because RViz shows them
    grey otherwise.

    Args:
        robot: the robot.
        path: the folder, best named as the package.
        package: name of the package: lower-case letters, digits and single underscores, a letter first; None for the
            robot's name and "_description".
        package_version: three numbers.
        maintainer: "Name <mail address>".
        license: of the package's content, as SPDX calls it; None for the license of nao_kin's own files, and for a
            place to fill in where the robot came from elsewhere.
        names: "naoqi" or "ros", see `urdf`; None for "ros" where the robot has such names.
        frames: see `urdf`.
        meshes: "package", or "none" to leave them out.
        coupling: see `urdf`.
        inertia: see `urdf`.
        samples: see `srdf`.
        seed: see `srdf`.
        overwrite: replace the folder, if it holds nothing but such a package.

    Returns:
        The folder, its files, and what in them differs from the robot or is left to fill in.

    Raises:
        UnknownName: no such choice of an option.
        BadArgument: a name, version, maintainer or license that ROS does not take; a mesh is missing; the folder
            is there.

    Examples:
        >>> done = nk.export.ros2(nk.load_nao("v6"), "nao_description", package="nao_description", samples=100)
        >>> sorted({file.parent.name for file in done.files})
        ['config', 'launch', 'meshes', 'nao_description', 'rviz', 'urdf']
    """
    check_robot(robot)
    check_folder(path, overwrite=overwrite)
    person = _checked_person(maintainer)
    if not isinstance(package_version, str) or not _VERSION.fullmatch(package_version):
        raise BadArgument(f"package_version must be three numbers, as 1.0.0, got {quoted(package_version)}")
    if license is not None and not (isinstance(license, str) and license.strip() and license.isprintable()):
        raise BadArgument(f"license must be one line, as SPDX calls it, got {quoted(license)}")
    if meshes not in MESHES:
        raise UnknownName("choice of meshes", meshes, MESHES)
    chosen = ("ros" if robot.semantics.ros_names else "naoqi") if names is None else names
    tree, changes = variant(robot, frames=frames, names=chosen, coupling=coupling, inertia=inertia)
    name = _checked_name(package, tree)
    stem = _plain(tree.name)

    looks: dict[str, bytes] = {}
    painted: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()
    links: dict[str, str] | None = None
    if meshes == "package":
        inside, copied, left_out = mesh_names(tree)
        looks, painted = coloured(tree, inside, read_files(copied), f"{name}.mtl")
        links = {mesh: f"package://{name}/{MESH_FOLDER}/{file}" for mesh, file in inside.items()}
    urdf, unsaid = urdf_document(tree, links)
    semantic = srdf_document(robot, names=chosen, frames=frames, coupling=coupling, samples=samples, seed=seed)

    texts = {
        f"urdf/{stem}.urdf": urdf,
        f"config/{stem}.srdf": semantic.text,
        "config/joint_limits.yaml": ros_texts.joint_limits(tree),
        "config/joint_state_publisher.yaml": ros_texts.slider_starts(_start(robot, tree, chosen)),
        "launch/display.launch.py": ros_texts.display_launch(name, f"{stem}.urdf", f"{stem}.rviz"),
        f"rviz/{stem}.rviz": ros_texts.rviz_config(tree.root, *_view(robot)),
        "README.md": ros_texts.readme(name, tree.name),
    }
    folders = [folder for folder in ros_texts.FOLDERS if folder != MESH_FOLDER or looks]
    own = robot.parameters is not None and license is None
    said = ("BSD-3-Clause" if own else _NO_LICENCE) if license is None else license
    texts |= {"LICENSE": _license(robot)} if own else {}
    about = f"Description of the robot {tree.name}: URDF, meshes, SRDF and a view for RViz."
    texts["package.xml"] = ros_texts.package_xml(name, package_version, about, person, said, "LICENSE" if own else "")
    texts["CMakeLists.txt"] = ros_texts.cmake_lists(name, folders)

    files = {file: text.encode() for file, text in sorted(texts.items())}
    files |= {f"{MESH_FOLDER}/{file}": content for file, content in looks.items()}
    open_ends = [f"package.xml: fill in the {what}" for what in _open(maintainer, said)]
    written = write_folder(path, files, overwrite=overwrite)
    return Exported(Path(path), written, (*changes, *unsaid, *left_out, *painted, *semantic.changes, *open_ends))


def _checked_name(package: str | None, tree: UrdfTree) -> str:
    name = f"{_plain(tree.name)}_description" if package is None else package
    if not isinstance(name, str) or len(name) < 2 or not _NAME.fullmatch(name):
        raise BadArgument(
            f"package must be two or more lower-case letters, digits and single underscores between them, a letter "
            f"first, got {quoted(name)}; nearest: {_plain(name)}"
        )
    return name


def _plain(name: object) -> str:
    """A name made of what names of packages and files may have."""
    words = re.findall(r"[a-z0-9]+", str(name)[:100].lower())
    plain = "_".join(words)
    return plain if len(plain) > 1 and plain[0].isalpha() else f"robot_{plain}".rstrip("_")


def _checked_person(maintainer: str) -> tuple[str, str]:
    match = _PERSON.fullmatch(maintainer) if isinstance(maintainer, str) and maintainer.isprintable() else None
    if match is None:
        raise BadArgument(f"maintainer must be as 'Name <name@example.org>', got {quoted(maintainer)}")
    return match[1], match[2]


def _open(maintainer: str, license: str) -> list[str]:
    return [what for what, left in (("maintainer", maintainer == NOBODY), ("license", license == _NO_LICENCE)) if left]


def _license(robot: RobotModel) -> str:
    """The license of the robot's own files: beside them in a wheel, above them in a checkout."""
    folder = Path(robot.urdf_path).parent
    for file in (folder / "LICENSE", folder.parent / "LICENSE"):
        if file.is_file():
            return file.read_text(encoding="utf-8")
    raise BadModel(f"no file LICENSE in {folder}; reinstall nao-kin")


def _start(robot: RobotModel, tree: UrdfTree, names: str) -> dict[str, float]:
    """The posture that the robot starts in, as far as the exported joints have values of their own."""
    if not robot.semantics.start:
        return {}
    values = joint_values(robot, robot.posture(robot.semantics.start), names)
    return {joint.name: float(values[joint.name]) for joint in tree.moving_joints if joint.mimic is None}


def _view(robot: RobotModel) -> tuple[tuple[float, float, float], float]:
    """The middle of the links in the posture that the robot starts in, and a camera distance that shows them all."""
    start = robot.semantics.start
    points = robot.fk(robot.posture(start) if start else robot.neutral())[:, :3, 3]
    low, high = points.min(axis=0), points.max(axis=0)
    x, y, z = ((low + high) / 2.0).tolist()
    return (x, y, z), float(max(2.0 * np.linalg.norm(high - low), 0.3))
