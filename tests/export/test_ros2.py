"""The ROS 2 package: it builds, ROS tools accept its files, and its names resolve."""

from __future__ import annotations

import ast
import importlib.util
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from loops import full
from made_up_robots import J, made_up
from moveit_rules import violations

import nao_kin as nk
from nao_kin.export.meshes import coloured
from nao_kin.export.variants import Variant
from nao_kin.robot.semantics import Posture, Semantics
from nao_kin.robot.urdf import MeshFile, Origin, UrdfTree, Visual
from nao_kin.robot.urdf.reader import read_urdf

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def nao() -> nk.NaoModel:
    return nk.load_nao("v6")


@pytest.fixture(scope="module")
def package(nao: nk.NaoModel, tmp_path_factory: pytest.TempPathFactory) -> nk.export.Exported:
    folder = tmp_path_factory.mktemp("src") / "nao_description"
    return nk.export.ros2(nao, folder, package="nao_description", maintainer="A. Person <a.p@lab.org>", samples=1)


def _yaml(path: Path) -> Any:
    yaml = pytest.importorskip("yaml")
    return yaml.safe_load(path.read_text(encoding="utf-8"))


def _tree(package: nk.export.Exported) -> UrdfTree:
    (urdf,) = (package.path / "urdf").iterdir()
    return read_urdf(urdf)


# --- what builds and installs it --------------------------------------------------------------------------------------


def test_the_package_has_its_files(package: nk.export.Exported) -> None:
    there = {file.relative_to(package.path).as_posix() for file in package.path.rglob("*") if file.is_file()}
    assert there == {file.relative_to(package.path).as_posix() for file in package.files}
    assert {name for name in there if not name.startswith("meshes/")} == {
        "CMakeLists.txt",
        "LICENSE",
        "README.md",
        "config/joint_limits.yaml",
        "config/joint_state_publisher.yaml",
        "config/naoh25v60.srdf",
        "launch/display.launch.py",
        "package.xml",
        "rviz/naoh25v60.rviz",
        "urdf/naoh25v60.urdf",
    }
    assert (package.path / "LICENSE").read_bytes() == (ROOT / "LICENSE").read_bytes()


def test_catkin_pkg_takes_the_manifest(package: nk.export.Exported) -> None:
    catkin = pytest.importorskip("catkin_pkg.package")
    warnings: list[str] = []
    parsed = catkin.parse_package(str(package.path), warnings=warnings)
    parsed.validate(warnings=warnings)
    assert warnings == []
    assert (parsed.name, parsed.version, parsed.package_format) == ("nao_description", "0.1.0", 3)
    assert parsed.get_build_type() == "ament_cmake"
    assert [(person.name, person.email) for person in parsed.maintainers] == [("A. Person", "a.p@lab.org")]
    assert [(str(license), license.file) for license in parsed.licenses] == [("BSD-3-Clause", "LICENSE")]


def test_the_manifest_has_its_elements_in_the_order_of_the_schema(package: nk.export.Exported) -> None:
    # package_format3.xsd of REP 149: a sequence, with the dependencies in any order between authors and exports.
    root = ET.parse(package.path / "package.xml").getroot()
    assert (root.tag, root.get("format")) == ("package", "3")
    head = ["name", "version", "description", "maintainer", "license"]
    tags = [element.tag for element in root]
    assert tags[: len(head)] == head
    assert set(tags[len(head) : -1]) <= {"buildtool_depend", "exec_depend"}
    assert tags[-1] == "export"
    needed = {element.text for element in root.findall("exec_depend")}
    launch = (package.path / "launch" / "display.launch.py").read_text(encoding="utf-8")
    imported = {node.module.split(".")[0] for node in ast.walk(ast.parse(launch)) if isinstance(node, ast.ImportFrom)}
    started = {package for package in needed if f'package="{package}"' in launch}
    assert (imported - {"pathlib"}) | started == needed


def test_cmake_installs_every_folder(package: nk.export.Exported, tmp_path: Path) -> None:
    cmake = shutil.which("cmake")
    if cmake is None:
        pytest.skip("cmake is not installed")
    # A stand-in for ament: what is looked at is what this package asks of CMake itself.
    (tmp_path / "ament_cmakeConfig.cmake").write_text(
        "function(ament_package)\n  install(FILES package.xml DESTINATION share/${PROJECT_NAME})\nendfunction()\n"
    )
    build, prefix = tmp_path / "build", tmp_path / "install"
    found = f"-Dament_cmake_DIR={tmp_path}"
    subprocess.run(
        [cmake, "-S", package.path, "-B", build, found, f"-DCMAKE_INSTALL_PREFIX={prefix}", "-Werror=dev"],
        check=True,
        capture_output=True,
    )
    subprocess.run([cmake, "--install", build], check=True, capture_output=True)
    share = prefix / "share" / "nao_description"
    installed = {file.relative_to(share).as_posix() for file in share.rglob("*") if file.is_file()}
    ours = {file.relative_to(package.path).as_posix() for file in package.files}
    assert ours - installed == {"CMakeLists.txt", "LICENSE", "README.md"}


# --- what shows it ----------------------------------------------------------------------------------------------------


class _Call:
    """The arguments of a call of the launch library."""

    def __init__(self, *given: Any, **named: Any) -> None:
        self.given, self.named = given, named


def _launched(package: nk.export.Exported, monkeypatch: pytest.MonkeyPatch) -> list[_Call]:
    """Return the description in the launch file, made with stand-ins for the packages of ROS."""
    names = {
        "ament_index_python.packages": {"get_package_share_directory": lambda name: str(package.path)},
        "launch": {"LaunchDescription": list},
        "launch.actions": {"DeclareLaunchArgument": _Call},
        "launch.conditions": {"IfCondition": _Call},
        "launch.substitutions": {"LaunchConfiguration": _Call},
        "launch_ros.actions": {"Node": _Call},
        "launch_ros.parameter_descriptions": {"ParameterValue": _Call},
    }
    for module, members in names.items():
        for name in (module.split(".")[0], module):
            stand_in = sys.modules.get(name) or ModuleType(name)
            monkeypatch.setitem(sys.modules, name, stand_in)
        for member, value in members.items():
            setattr(sys.modules[module], member, value)
    path = package.path / "launch" / "display.launch.py"
    spec = importlib.util.spec_from_file_location("display", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    spec.loader.exec_module(module)
    return list(module.generate_launch_description())


def test_the_launch_file_starts_three_nodes_whose_files_are_there(
    package: nk.export.Exported, monkeypatch: pytest.MonkeyPatch
) -> None:
    actions = _launched(package, monkeypatch)
    arguments = {action.given[0]: action.named["default_value"] for action in actions if action.given}
    assert arguments == {"sliders": "true", "rviz": "true"}
    nodes = {action.named["package"]: action.named for action in actions if not action.given}
    assert set(nodes) == {"robot_state_publisher", "joint_state_publisher_gui", "rviz2"}
    assert all(named["executable"] == name for name, named in nodes.items())
    (parameters,) = nodes["robot_state_publisher"]["parameters"]
    (urdf,) = (package.path / "urdf").iterdir()
    described = parameters["robot_description"]
    assert described.given == (urdf.read_text(encoding="utf-8"),)
    assert described.named == {"value_type": str}
    (sliders,) = nodes["joint_state_publisher_gui"]["parameters"]
    assert Path(sliders).is_file()
    option, view = nodes["rviz2"]["arguments"]
    assert option == "-d"
    assert Path(view).is_file()
    conditions = {name: named["condition"].given[0].given[0] for name, named in nodes.items() if "condition" in named}
    assert conditions == {"joint_state_publisher_gui": "sliders", "rviz2": "rviz"}


def test_rviz_finds_the_robot_on_its_topic_and_a_frame_that_stands_still(package: nk.export.Exported) -> None:
    manager = _yaml(package.path / "rviz" / "naoh25v60.rviz")["Visualization Manager"]
    displays = {display["Name"]: display for display in manager["Displays"]}
    model = displays["RobotModel"]
    assert model["Class"] == "rviz_default_plugins/RobotModel"
    # robot_state_publisher sends the description once, to whoever comes later too.
    assert model["Description Topic"]["Value"] == "/robot_description"
    assert model["Description Topic"]["Durability Policy"] == "Transient Local"
    assert manager["Global Options"]["Fixed Frame"] == _tree(package).root == "base_link"
    assert all(display["Class"].startswith("rviz_default_plugins/") for display in displays.values())
    view = manager["Views"]["Current"]
    assert 0.3 < view["Distance"] < 3.0
    assert set(view["Focal Point"]) == {"X", "Y", "Z"}


def test_the_sliders_begin_in_the_posture_the_robot_starts_in(package: nk.export.Exported, nao: nk.NaoModel) -> None:
    zeros = _yaml(package.path / "config" / "joint_state_publisher.yaml")["/**"]["ros__parameters"]["zeros"]
    assert zeros == nao.angles(nao.posture("StandInit"))


def test_moveit_gets_the_largest_speeds(package: nk.export.Exported, nao: nk.NaoModel) -> None:
    limits = _yaml(package.path / "config" / "joint_limits.yaml")["joint_limits"]
    assert {name: row["max_velocity"] for name, row in limits.items()} == dict(
        zip(nao.joint_names, nao.velocity_limits.tolist(), strict=True)
    )
    assert all(row["has_velocity_limits"] is True for row in limits.values())
    assert all(row["has_acceleration_limits"] is False for row in limits.values())


# --- the robot in it --------------------------------------------------------------------------------------------------


def test_every_mesh_is_found_in_the_package(package: nk.export.Exported) -> None:
    tree = _tree(package)
    assert not any("mesh" in note for note in tree.notes)
    names = {visual.geometry.filename for visual in tree.visuals if isinstance(visual.geometry, MeshFile)}
    assert len(names) > 50
    assert all(name.startswith("package://nao_description/meshes/") for name in names)
    found = {tree.packages.file(name) for name in names}
    assert found <= {file.resolve() for file in package.files}


def test_the_robot_in_it_moves_as_the_robot(package: nk.export.Exported, nao: nk.NaoModel) -> None:
    again = nk.RobotModel(_tree(package))
    assert again.name == "NaoH25V60"
    q = nao.random(5, 10)
    theirs = again.configuration(nao.angles(q), limits="ignore")
    for link, name in (("l_sole", "LLeg"), ("CameraTop_optical_frame",) * 2, ("l_wrist",) * 2, ("r_ankle", "RFoot")):
        np.testing.assert_allclose(again.fk(theirs, link), nao.fk(q, name), atol=1e-12)


def test_the_srdf_in_it_obeys_the_rules_of_moveit(package: nk.export.Exported) -> None:
    text = (package.path / "config" / "naoh25v60.srdf").read_text(encoding="utf-8")
    urdf = ET.parse(package.path / "urdf" / "naoh25v60.urdf").getroot()
    tree, _ = Variant(names="ros").tree_of(nk.load_nao("v6"))
    assert {link.get("name") for link in urdf.findall("link")} == set(tree.links)
    assert violations(text, tree) == []


@pytest.mark.parametrize("coupling", ["independent", *full("locked")])
def test_urdf_and_srdf_agree_for_other_couplings(nao: nk.NaoModel, tmp_path: Path, coupling: str) -> None:
    folder = tmp_path / "nao_description"
    options = {"coupling": coupling, "frames": "none", "names": "naoqi", "meshes": "none"}
    nk.export.ros2(nao, folder, package="nao_description", samples=1, **options)
    (urdf,), (srdf,) = (folder / "urdf").iterdir(), (folder / "config").glob("*.srdf")
    assert violations(srdf.read_text(encoding="utf-8"), read_urdf(urdf)) == []
    assert not (folder / "meshes").exists()
    assert "meshes" not in (folder / "CMakeLists.txt").read_text(encoding="utf-8")
    zeros = _yaml(folder / "config" / "joint_state_publisher.yaml")["/**"]["ros__parameters"]["zeros"]
    assert ("RHipYawPitch" in zeros) == (coupling == "independent")


def test_meshes_carry_the_colours_of_the_urdf(package: nk.export.Exported) -> None:
    import trimesh

    tree = _tree(package)
    colours = {v.geometry.filename: v.rgba for v in tree.visuals if isinstance(v.geometry, MeshFile)}
    for name in ("torso_white", "torso_led", "head_black"):
        mesh: Any = trimesh.load(package.path / "meshes" / f"{name}.obj", process=False)
        rgba = colours[f"package://nao_description/meshes/{name}.obj"]
        np.testing.assert_allclose(mesh.visual.material.diffuse / 255.0, rgba, atol=0.5 / 255.0 + 1e-9)
    assert "64 meshes have their colours in nao_description.mtl: RViz ignores those of a URDF" in package.changes


def test_a_mesh_with_a_material_or_several_colours_stays_as_it_is(nao: nk.NaoModel) -> None:
    tree, _ = Variant().tree_of(nao)
    names = {v.geometry.filename: Path(v.geometry.filename).name for v in tree.visuals}  # type: ignore[union-attr]
    files = dict.fromkeys(names.values(), b"v 0 0 0\n") | {"torso_white.obj": b"o a\nusemtl own\n"}
    twice = next(visual for visual in tree.visuals if visual.material == "dark")
    both = replace(tree, visuals=(*tree.visuals, replace(twice, rgba=(1.0, 0.0, 0.0, 1.0))))
    made, changes = coloured(both, names, files, "a.mtl")
    assert made["torso_white.obj"] == files["torso_white.obj"]
    several = Path(twice.geometry.filename).name  # type: ignore[union-attr]
    assert made[several] == files[several]
    assert changes[1] == f"{several} has several colours in the URDF, and none in RViz"
    assert made["head_led.obj"] == b"mtllib a.mtl\nusemtl led\nv 0 0 0\n"


def test_a_colour_is_written_with_its_opacity_and_a_name_of_its_own(nao: nk.NaoModel) -> None:
    looks = [("red", (1.0, 0.0, 0.0, 0.25)), ("red", (0.5, 0.0, 0.0, 1.0))]
    visuals = tuple(
        Visual("torso", Origin(), MeshFile(f"{index}.obj"), rgba=rgba, material=word)
        for index, (word, rgba) in enumerate(looks)
    )
    tree = replace(nao.tree, visuals=visuals, collisions=())
    made, _ = coloured(tree, {f"{i}.obj": f"{i}.obj" for i in range(2)}, {f"{i}.obj": b"" for i in range(2)}, "a.mtl")
    assert made["0.obj"] == b"mtllib a.mtl\nusemtl red\n"
    name = made["1.obj"].split()[-1].decode()
    assert name != "red"
    rows = {row.split("\n")[0]: row.split("\n")[1:4] for row in made["a.mtl"].decode().split("newmtl ")[1:]}
    assert rows == {"red": ["Ka 1 0 0", "Kd 1 0 0", "d 0.25"], name: ["Ka 0.5 0 0", "Kd 0.5 0 0", "d 1"]}


def test_only_an_obj_gets_a_colour_of_its_own(nao: nk.NaoModel) -> None:
    visual = Visual("torso", Origin(), MeshFile("a.stl"), rgba=(1.0, 0.0, 0.0, 1.0), material="red")
    tree = replace(nao.tree, visuals=(visual,), collisions=())
    assert coloured(tree, {"a.stl": "a.stl"}, {"a.stl": b"solid"}, "a.mtl") == ({"a.stl": b"solid"}, ())


# --- other robots and bad input ---------------------------------------------------------------------------------------


def test_a_robot_from_elsewhere_is_not_given_a_license(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a"), J("b", kind="continuous"))
    done = nk.export.ros2(robot, tmp_path / "made_up_description", samples=1)
    manifest = ET.parse(done.path / "package.xml").getroot()
    assert manifest.findtext("name") == "made_up_description"
    assert manifest.findtext("license") == "TODO: License declaration"
    assert not (done.path / "LICENSE").exists()
    assert done.changes[-2:] == ("package.xml: fill in the maintainer", "package.xml: fill in the license")
    own = nk.export.ros2(robot, tmp_path / "other", package="other", license="MIT", maintainer="B <b@c.de>", samples=1)
    assert ET.parse(own.path / "package.xml").getroot().findtext("license") == "MIT"
    assert not any("fill in" in line for line in own.changes)


def test_a_robot_without_postures_has_texts_that_parse(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("yes"), J("no: #1", kind="continuous"))
    done = nk.export.ros2(robot, tmp_path / "p1", package="p1", samples=1)
    assert set(_yaml(done.path / "config" / "joint_limits.yaml")["joint_limits"]) == {"yes", "no: #1"}
    assert "zeros" not in _yaml(done.path / "config" / "joint_state_publisher.yaml")["/**"]["ros__parameters"]
    still = made_up(tmp_path, J("a", kind="fixed"))
    done = nk.export.ros2(still, tmp_path / "p2", package="p2", samples=1)
    assert _yaml(done.path / "config" / "joint_limits.yaml")["joint_limits"] == {}


def test_the_start_posture_of_any_robot_is_where_the_sliders_begin(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a"), J("b", follows=("a", 2.0, 0.0)))
    meaning = Semantics(postures={"up": Posture({"a": 0.25})}, start="up")
    robot = nk.RobotModel.from_urdf(robot.urdf_path, semantics=meaning)
    done = nk.export.ros2(robot, tmp_path / "p1", package="p1", samples=1)
    zeros = _yaml(done.path / "config" / "joint_state_publisher.yaml")["/**"]["ros__parameters"]["zeros"]
    assert zeros == {"a": 0.25}
