"""Files that a robot's file names: beside it, in folders given, and where ROS and Gazebo keep their packages."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

import nao_kin as nk
from nao_kin.errors import BadArgument
from nao_kin.robot.urdf import Packages

VARIABLES = ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH", "CMAKE_PREFIX_PATH", "GAZEBO_MODEL_PATH", "GZ_SIM_RESOURCE_PATH")


@pytest.fixture(autouse=True)
def _no_ros(monkeypatch: pytest.MonkeyPatch) -> None:
    for variable in VARIABLES:
        monkeypatch.delenv(variable, raising=False)


def _file(path: Path) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("solid")
    return path


def _package(folder: Path, name: str) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "package.xml").write_text(f'<package format="3"><name>{name}</name></package>')
    return _file(folder / "meshes" / "arm.stl")


@pytest.mark.parametrize(
    ("variable", "below"),
    [
        ("ROS_PACKAGE_PATH", "arm_description"),
        ("ROS_PACKAGE_PATH", "stack/of/stacks/arm_description"),
        ("AMENT_PREFIX_PATH", "share/arm_description"),
        ("CMAKE_PREFIX_PATH", "share/arm_description"),
        ("GAZEBO_MODEL_PATH", "arm_description"),
    ],
)
def test_a_package_is_found_where_ros_and_gazebo_look(
    tmp_path: Path, variable: str, below: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    mesh = _file(tmp_path / "ws" / below / "meshes" / "arm.stl")
    packages = Packages(tmp_path / "urdf" / "robot.urdf")
    assert packages.file("package://arm_description/meshes/arm.stl") is None
    monkeypatch.setenv(variable, os.pathsep.join(["/nowhere", str(tmp_path / "ws")]))
    packages = Packages(tmp_path / "urdf" / "robot.urdf")
    for scheme in ("package", "model"):
        assert packages.file(f"{scheme}://arm_description/meshes/arm.stl") == mesh
    assert packages.folder("arm_description") == tmp_path / "ws" / below


def test_a_workspace_finds_a_package_by_what_it_calls_itself(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = _package(tmp_path / "src" / "arm-main", "arm_description")
    _package(tmp_path / "src" / "arm-main" / "inner", "hidden")  # packages hold no packages
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "src"))
    packages = Packages(tmp_path / "robot.urdf")
    assert packages.file("package://arm_description/meshes/arm.stl") == mesh
    assert packages.folder("hidden") is None


@pytest.mark.parametrize("given", ["", "arm_description", "arm-main"])
def test_folders_given_hold_packages_or_are_one(tmp_path: Path, given: str) -> None:
    mesh = _package(tmp_path / "x" / (given or "arm_description"), "arm_description")
    packages = Packages(tmp_path / "robot.urdf", [tmp_path / "x" / given])
    assert packages.file("package://arm_description/meshes/arm.stl") == mesh


@pytest.mark.parametrize("below", ["arm-main", "stack/of/stacks/arm-main"])
def test_folders_given_hold_packages_by_what_they_call_themselves(tmp_path: Path, below: str) -> None:
    mesh = _package(tmp_path / "x" / below, "arm_description")
    packages = Packages(tmp_path / "urdf" / "robot.urdf", [tmp_path / "x"])
    assert packages.file("package://arm_description/meshes/arm.stl") == mesh
    assert packages.folder("arm_description") == tmp_path / "x" / below


def test_the_name_of_a_package_is_the_element_and_no_comment(tmp_path: Path) -> None:
    _package(tmp_path / "src" / "arm-main", "arm_description")
    text = '<package><!-- <name>other</name> --><name kind="x">\n arm_description</name></package>'
    (tmp_path / "src" / "arm-main" / "package.xml").write_text(text)
    packages = Packages(tmp_path / "robot.urdf", [tmp_path / "src" / "arm-main"])
    assert packages.file("package://arm_description/meshes/arm.stl") is not None
    assert packages.file("package://other/meshes/arm.stl") is None


def test_addresses_of_packages_may_be_written_with_percents(tmp_path: Path) -> None:
    mesh = _file(tmp_path / "p" / "a b.stl")
    assert Packages(tmp_path / "robot.urdf").file("package://p/a%20b.stl") == mesh


def test_a_workspace_named_from_where_the_process_is_stays_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mesh = _file(tmp_path / "ws" / "p" / "a.stl")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ROS_PACKAGE_PATH", "ws")
    packages = Packages(tmp_path / "else" / "robot.urdf")
    assert packages.folder("p") == mesh.parent
    monkeypatch.chdir("/")
    assert packages.file("package://p/a.stl") == mesh


def test_folders_given_come_before_those_above_and_those_of_ros(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = "package://p/a.stl"
    ros, above, given = (_file(tmp_path / place / "p" / "a.stl") for place in ("ros", "home", "given"))
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "ros"))
    robot = tmp_path / "home" / "urdf" / "robot.urdf"
    robot.parent.mkdir()
    assert Packages(robot, [tmp_path / "given"]).file(name) == given
    assert Packages(robot).file(name) == above
    above.unlink()
    assert Packages(robot).file(name) == ros  # a place without the file does not hide one that has it


def test_a_urdf_inside_a_package_of_another_folder_name_finds_its_own_meshes(tmp_path: Path) -> None:
    mesh = _package(tmp_path / "downloaded-1.2", "arm_description")
    urdf = tmp_path / "downloaded-1.2" / "urdf" / "arm.urdf"
    assert Packages(urdf).file("package://arm_description/meshes/arm.stl") == mesh


@pytest.mark.parametrize("name", ["a b.stl", "file://{}/a%20b.stl", "file://{}/a b.stl", "{}/a b.stl"])
def test_plain_names_and_file_addresses_are_found(tmp_path: Path, name: str) -> None:
    mesh = _file(tmp_path / "a b.stl")
    assert Packages(tmp_path / "robot.urdf").file(name.format(tmp_path)) == mesh


@pytest.mark.parametrize("name", ["", "package://", "package://no_such", "http://a.org/b.stl", "x" * 5000, "a\0b"])
def test_names_that_mean_no_file_are_not_found(tmp_path: Path, name: str) -> None:
    (tmp_path / "no_such").mkdir()
    assert Packages(tmp_path / "robot.urdf", [tmp_path]).file(name) is None


def test_a_link_to_a_robots_file_finds_what_lies_beside_the_file(tmp_path: Path) -> None:
    mesh = _file(tmp_path / "robot" / "a.stl")
    (tmp_path / "robot" / "robot.urdf").touch()
    (tmp_path / "link.urdf").symlink_to(tmp_path / "robot" / "robot.urdf")
    assert Packages(tmp_path / "link.urdf").file("a.stl") == mesh


def test_a_robot_keeps_the_folders_that_it_was_given(tmp_path: Path) -> None:
    _file(tmp_path / "far" / "arm" / "a.stl")
    path = tmp_path / "near" / "robot.urdf"
    path.parent.mkdir()
    mesh = '<visual><geometry><mesh filename="package://arm/a.stl"/></geometry></visual>'
    path.write_text(f'<robot name="r"><link name="l">{mesh}</link></robot>')
    assert "mesh files are missing" in nk.RobotModel.from_urdf(path).load_notes[0]
    robot = nk.RobotModel.from_urdf(path, package_dirs=[tmp_path / "far"])
    assert robot.load_notes == ()
    assert robot.tree.packages.file("package://arm/a.stl") is not None


@pytest.mark.parametrize("folders", ["/tmp", ["/nowhere/at/all"]])
def test_what_are_no_folders_is_refused(nao: nk.NaoModel, folders: object) -> None:
    with pytest.raises(BadArgument, match="package_dirs"):
        nk.RobotModel.from_urdf(nao.urdf_path, package_dirs=folders)  # type: ignore[arg-type]
