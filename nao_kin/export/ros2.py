"""Export of a robot as a ROS 2 package."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np

from nao_kin._core.arrays import choice
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument, BadModel
from nao_kin.export.meshes import MESH_FOLDER, coloured, taken_meshes
from nao_kin.export.pipeline import Destination, Exported, add_texts, filled, xml_text
from nao_kin.export.srdf import srdf_document
from nao_kin.export.urdf import urdf_document
from nao_kin.export.variants import Variant, joint_values
from nao_kin.robot import RobotModel
from nao_kin.robot.urdf import UrdfTree

# --- The texts of a ROS 2 package that describes a robot, to build it and to show it in RViz.
#
# Sources: REP 149 (package.xml, format 3); ament_cmake user documentation; urdf_launch and the ROS 2 tutorials on
# URDF, for the nodes; MoveIt, "Time Parameterization", for joint_limits.yaml.

FOLDERS = ("config", "launch", "meshes", "rviz", "urdf")


def package_xml(name: str, description: str, maintainer: tuple[str, str], license: str, file: str) -> str:
    """Return the text of package.xml; `file` is the name of the license's text, "" without one."""
    root = ET.Element("package", format="3")
    add_texts(root, {"name": name, "version": _VERSION, "description": description})
    ET.SubElement(root, "maintainer", email=maintainer[1]).text = maintainer[0]
    ET.SubElement(root, "license", {"file": file} if file else {}).text = license
    add_texts(root, {"buildtool_depend": "ament_cmake"})
    nodes = ("joint_state_publisher_gui", "robot_state_publisher", "rviz2")
    for needed in ("ament_index_python", *nodes, "launch", "launch_ros"):
        add_texts(root, {"exec_depend": needed})
    add_texts(ET.SubElement(root, "export"), {"build_type": "ament_cmake"})
    return xml_text(root)


def joint_limits(tree: UrdfTree) -> str:
    """Return MoveIt's file of largest speeds; accelerations, which a URDF lacks, are left out."""
    lines = [
        "# For MoveIt. Acceleration limits are unknown: set has_acceleration_limits to true where you know them.",
        "default_velocity_scaling_factor: 0.1",
        "default_acceleration_scaling_factor: 0.1",
        "joint_limits:",
    ]
    own = [joint for joint in tree.moving_joints if joint.mimic is None]
    for joint in own:
        limited = math.isfinite(joint.velocity)
        lines += [
            f"  {json.dumps(joint.name)}:",
            f"    has_velocity_limits: {'true' if limited else 'false'}",
            f"    max_velocity: {joint.velocity if limited else 0.0!r}",
            "    has_acceleration_limits: false",
            "    max_acceleration: 0.0",
        ]
    return "\n".join(lines) + "\n" if own else lines[0] + "\njoint_limits: {}\n"


def slider_starts(values: Mapping[str, float]) -> str:
    """Return the parameters of joint_state_publisher: the initial positions of its sliders, `zeros`."""
    lines = ["/**:", "  ros__parameters:", "    zeros:" if values else "    rate: 10"]
    return "\n".join([*lines, *(f"      {json.dumps(name)}: {value!r}" for name, value in values.items())]) + "\n"


# --- The export.

MESHES = ("package", "none")

# REP 149 and its schema; REP 144 requires at least two characters.
_NAME = re.compile(r"[a-z](_?[a-z0-9]+)*", re.ASCII)
_VERSION = "0.1.0"
_PERSON = re.compile(r"\s*([^<>]*[^<>\s])\s*<([-\w.+]+@[-\w]+(?:\.[-\w]+)*)>\s*")

_TO_FILL_IN = "TODO <todo@todo.todo>"
_NO_LICENCE = "TODO: License declaration"


def ros2(
    robot: RobotModel,
    path: Path | str,
    *,
    package: str | None = None,
    maintainer: str = _TO_FILL_IN,
    license: str | None = None,
    names: str | None = None,
    frames: str = "all",
    meshes: str = "package",
    coupling: str = "mimic",
    inertia: str = "published",
    samples: int = 10_000,
    overwrite: bool = False,
) -> Exported:
    """Write a ROS 2 package: the robot's URDF and meshes, its SRDF, and a launch file that shows it in RViz.

    The folder builds with colcon; `ros2 launch PACKAGE display.launch.py` then opens RViz with a slider for each joint.
    Meshes are named by `package://`, and .obj files get the colours of the URDF, because RViz shows them grey
    otherwise.

    Args:
        robot: any robot.
        path: the folder, best named as the package.
        package: name of the package: lower-case letters, digits and single underscores, a letter first; None for the
            robot's name and "_description".
        maintainer: maintainer of the package, "Name <mail address>".
        license: license of the package's content, an SPDX identifier; None for the license of nao_kin's own files, or a
            placeholder if the robot is from elsewhere.
        names: "naoqi" or "ros", as in `urdf`; None for "ros" if the robot has such names.
        frames: as in `urdf`.
        meshes: "package", or "none" to leave them out.
        coupling: as in `urdf`.
        inertia: as in `urdf`.
        samples: as in `srdf`.
        overwrite: replace the folder, if it contains only such a package.

    Returns:
        The folder, its files, their differences from the robot, and the entries to fill in.

    Raises:
        BadArgument: a name, maintainer or license that ROS refuses; a missing mesh; an existing folder.

    Examples:
        >>> done = nk.export.ros2(nk.load_nao("v6"), "nao_description", package="nao_description", samples=100)
        >>> sorted({file.parent.name for file in done.files})
        ['config', 'launch', 'meshes', 'nao_description', 'rviz', 'urdf']
    """
    target = Destination(path, overwrite=overwrite, folder=True)
    person = _checked_person(maintainer)
    if license is not None and not (license.strip() and license.isprintable()):
        raise BadArgument(f"license must be one line, an SPDX identifier, got {quoted(license)}")
    choice(meshes, MESHES, "choice of meshes")
    default = "ros" if robot.semantics.ros_names else "naoqi"
    chosen = Variant(frames, default if names is None else names, coupling, inertia)
    tree, changes = chosen.tree_of(robot)
    name = _checked_name(package, tree)
    stem = _plain(tree.name)

    taken = taken_meshes(tree, "none" if meshes == "none" else "relative")
    looks, painted = coloured(tree, taken.names, taken.files, f"{name}.mtl") if taken.names else ({}, ())
    links = None if taken.names is None else {mesh: f"package://{name}/{file}" for mesh, file in taken.names.items()}
    urdf, urdf_losses = urdf_document(tree, links)
    semantic, srdf_losses = srdf_document(robot, chosen, samples=samples)
    folders = [folder for folder in FOLDERS if folder != MESH_FOLDER or looks]
    own = robot.parameters is not None and license is None
    stated = ("BSD-3-Clause" if own else _NO_LICENCE) if license is None else license
    about = f"Description of the robot {tree.name}: URDF, meshes, SRDF and a view for RViz."
    texts = {
        f"urdf/{stem}.urdf": urdf,
        f"config/{stem}.srdf": semantic,
        "config/joint_limits.yaml": joint_limits(tree),
        "config/joint_state_publisher.yaml": slider_starts(_start(robot, tree, chosen.names)),
        "launch/display.launch.py": filled("display.launch.py", package=name, urdf=f"{stem}.urdf", rviz=f"{stem}.rviz"),
        f"rviz/{stem}.rviz": filled("view.rviz", root=json.dumps(tree.root), **_view(robot)),
        "README.md": filled("README.md", package=name, robot=tree.name),
        "package.xml": package_xml(name, about, person, stated, "LICENSE" if own else ""),
        "CMakeLists.txt": filled("CMakeLists.txt", package=name, folders=" ".join(folders)),
    }
    if own:
        texts["LICENSE"] = _license(robot)
    files = {file: text.encode() for file, text in sorted(texts.items())}
    missing = {"maintainer": maintainer == _TO_FILL_IN, "license": stated == _NO_LICENCE}
    reminders = [f"package.xml: fill in the {what}" for what, is_missing in missing.items() if is_missing]
    return target.write(files | looks, (*changes, *urdf_losses, *taken.notes, *painted, *srdf_losses, *reminders))


def _checked_name(package: str | None, tree: UrdfTree) -> str:
    name = f"{_plain(tree.name)}_description" if package is None else package
    if len(name) < 2 or not _NAME.fullmatch(name):
        raise BadArgument(
            f"package must be two or more lower-case letters, digits and single underscores between them, a letter "
            f"first, got {quoted(name)}; nearest: {_plain(name)}"
        )
    return name


def _plain(name: str) -> str:
    """Return a name made of the characters that names of packages and files may have."""
    words = re.findall(r"[a-z0-9]+", name[:100].lower())
    plain = "_".join(words)
    return plain if len(plain) > 1 and plain[0].isalpha() else f"robot_{plain}".rstrip("_")


def _checked_person(maintainer: str) -> tuple[str, str]:
    match = _PERSON.fullmatch(maintainer) if maintainer.isprintable() else None
    if match is None:
        raise BadArgument(f"maintainer must have the form 'Name <name@example.org>', got {quoted(maintainer)}")
    return match[1], match[2]


def _license(robot: RobotModel) -> str:
    """Return the license of the robot's own files, which is next to them in a wheel and above them in a checkout."""
    folder = Path(robot.urdf_path).parent
    for file in (folder / "LICENSE", folder.parent / "LICENSE"):
        if file.is_file():
            return file.read_text(encoding="utf-8")
    raise BadModel(f"no file LICENSE in {folder}; reinstall nao-kin")


def _start(robot: RobotModel, tree: UrdfTree, names: str) -> dict[str, float]:
    """Return the initial posture, for exported joints with their own values."""
    if not robot.semantics.start:
        return {}
    values = joint_values(robot, robot.posture(robot.semantics.start), names)
    return {joint.name: float(values[joint.name]) for joint in tree.moving_joints if joint.mimic is None}


def _view(robot: RobotModel) -> dict[str, str]:
    """Return the centre of the robot in its initial posture, and a distance from which all links are visible [m]."""
    start = robot.semantics.start
    points = robot.fk(robot.posture(start) if start else robot.neutral())[:, :3, 3]
    low, high = points.min(axis=0), points.max(axis=0)
    numbers = (*(low + high) / 2.0, max(2.0 * np.linalg.norm(high - low), 0.3))
    return {name: f"{number:.4g}" for name, number in zip(("x", "y", "z", "distance"), numbers, strict=True)}
