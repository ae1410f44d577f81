"""Xacro sources, expanded on reading if the caller asks for it."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest

import nao_kin as nk
from nao_kin.errors import BadArgument, BadModel
from nao_kin.robot.urdf.reader import read_urdf

pytest.importorskip("xacro", reason="xacro expands its sources")

MACRO = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:macro name="arm" params="side length">
  <link name="${side}_arm"/><joint name="${side}_j" type="revolute"><parent link="base"/><child link="${side}_arm"/>
  <origin xyz="${length / 2} 0 0"/><axis xyz="0 0 1"/><limit lower="${-pi / 2}" upper="1" velocity="1" effort="1"/>
  </joint></xacro:macro></robot>"""
ROBOT = """<robot name="two" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="length" default="2"/>
  <xacro:include filename="{}"/><link name="base"/>
  <xacro:arm side="l" length="$(arg length)"/><xacro:arm side="r" length="$(arg length)"/></robot>"""


@pytest.fixture
def source(tmp_path: Path) -> Path:
    (tmp_path / "arm_description" / "urdf").mkdir(parents=True)
    (tmp_path / "arm_description" / "urdf" / "arm.xacro").write_text(MACRO)
    path = tmp_path / "robot.urdf.xacro"
    path.write_text(ROBOT.format("$(find arm_description)/urdf/arm.xacro"))
    return path


def test_a_source_is_read_as_what_it_becomes(source: Path) -> None:
    robot = nk.RobotModel.from_urdf(source)
    assert robot.joint_names == ("l_j", "r_j")
    assert robot.lower.tolist() == pytest.approx([-1.5707963267948966] * 2)
    assert robot.position(robot.neutral(), "l_arm").tolist() == [1.0, 0.0, 0.0]
    assert robot.load_notes == ()
    assert robot.urdf_path == source
    assert "l_arm" in robot.tree.expanded


def test_a_comment_may_precede_the_declaration_of_a_source(source: Path) -> None:
    source.write_text(f'<!-- a licence -->\n<?xml version="1.0"?>\n{source.read_text()}')
    robot = nk.RobotModel.from_urdf(source)
    assert robot.joint_names == ("l_j", "r_j")
    assert nk.crosscheck.run(robot, 2).ok


@pytest.mark.parametrize(
    ("name", "inside"),
    [
        ("$(arg n)", '<xacro:arg name="n" default="hand"/>'),
        ("$(optenv NAO_KIN_NOT_SET hand)", ""),
        ("$(env NAO_KIN_SET)", ""),
        ("$(eval 'ha' + 'nd')", ""),
        ("hand", '<xacro:include filename="more.xacro"/>'),
    ],
)
def test_substitutions_and_what_is_included_make_a_source(
    tmp_path: Path, name: str, inside: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NAO_KIN_SET", "hand")
    names = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
    more = '<joint name="J" type="fixed"><parent link="hand"/><child link="tip"/></joint><link name="tip"/>'
    (tmp_path / "more.xacro").write_text(f"<robot {names}>{more}</robot>")
    path = tmp_path / "robot.xacro"
    path.write_text(f'<robot name="r" {names}>{inside}<link name="{name}"/></robot>')
    robot = nk.RobotModel.from_urdf(path)
    assert robot.link_names == (("hand", "tip") if "include" in inside else ("hand",))


def test_packages_are_found_by_the_search_for_meshes(
    source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (tmp_path / "arm_description").rename(elsewhere / "arm_description")
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    with pytest.raises(BadModel, match=r"xacro refuses it: .*'arm_description' is in none of the folders"):
        nk.RobotModel.from_urdf(source)
    assert nk.RobotModel.from_urdf(source, package_dirs=[elsewhere]).nv == 2
    (tmp_path / "share").symlink_to(elsewhere)
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    assert nk.RobotModel.from_urdf(source).nv == 2
    assert "ament_index_python" not in sys.modules


@pytest.mark.parametrize(
    ("inside", "reason"),
    [
        ('<link name="${1 / 0}"/>', "division by zero"),
        ('<xacro:include filename="gone"/>', "{}/gone"),
        ("<link name=\"${xacro.load_yaml('gone')}\"/>", "'{}/gone'"),
    ],
)
def test_what_xacro_refuses_is_refused_in_one_line(
    tmp_path: Path, inside: str, reason: str, capfd: pytest.CaptureFixture
) -> None:
    path = tmp_path / "robot.xacro"
    path.write_text(f'<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">{inside}</robot>')
    with pytest.raises(BadModel, match="xacro refuses it") as caught:
        nk.RobotModel.from_urdf(path)
    assert reason.format(tmp_path) in str(caught.value)
    assert "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")


def test_arguments_for_a_file_without_any_are_refused(nao: nk.NaoModel) -> None:
    with pytest.raises(BadArgument, match="takes arguments with xacro=True only, got length"):
        nk.RobotModel.from_urdf(nao.urdf_path, xacro_arguments={"length": 1})
    with pytest.raises(BadArgument, match="not a xacro source and takes no arguments, got length"):
        nk.RobotModel.from_urdf(nao.urdf_path, xacro=True, xacro_arguments={"length": 1})


def test_semantics_lie_beside_a_source_under_its_first_name(source: Path) -> None:
    source.with_name("robot.toml").write_text('end_effectors = ["l_arm"]')
    assert nk.RobotModel.from_urdf(source).semantics.end_effectors == ("l_arm",)


def test_the_cross_check_reads_what_the_source_became(source: Path) -> None:
    report = nk.crosscheck.run(nk.RobotModel.from_urdf(source), 20)
    assert report.ok, report.failures
    assert {"yourdfpy", "pin.buildModelFromUrdf"} <= {row.against for row in report.rows}


def test_truth_as_a_text_is_in_lower_case(tmp_path: Path) -> None:
    path = tmp_path / "robot.xacro"
    path.write_text('<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="$(arg n)"/></robot>')
    assert nk.RobotModel.from_urdf(path, xacro_arguments={"n": True}).link_names == ("true",)


def test_the_search_of_ros_itself_is_there_again_afterwards(source: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    theirs = ModuleType("ament_index_python")
    monkeypatch.setitem(sys.modules, "ament_index_python", theirs)
    assert nk.RobotModel.from_urdf(source).nv == 2
    assert sys.modules["ament_index_python"] is theirs


# Each reads a file named .urdf.
DOORS: dict[str, Callable[[Path], object]] = {
    "from_file": nk.RobotModel.from_file,
    "from_urdf": nk.RobotModel.from_urdf,
    "read_robot": nk.urdf.read_robot,
    "read_urdf": read_urdf,
    "from_file, xacro=False": lambda path: nk.RobotModel.from_file(
        path.rename(path.with_suffix(".xacro")), xacro=False
    ),
}
# Passes the guard of xacro, which looks for forbidden names in the outermost expression only.
EXPRESSION = "${(lambda: ().__class__.__base__.__subclasses__())()[0]}"


@pytest.mark.parametrize("value", [EXPRESSION, "$(env HOME)"])
@pytest.mark.parametrize("door", DOORS)
def test_no_code_of_a_file_runs_unless_its_expansion_is_asked_for(tmp_path: Path, door: str, value: str) -> None:
    path = tmp_path / "robot.urdf"
    path.write_text(f'<robot name="r"><link name="{value}"/></robot>')
    with pytest.raises(BadModel, match=r"xacro=True \(--xacro\) expands it, which runs the code of its author$"):
        DOORS[door](path)


def test_a_macro_that_a_plain_file_includes_is_not_read(tmp_path: Path) -> None:
    (tmp_path / "macros.xacro").write_text(f'<robot name="r"><link name="{EXPRESSION}"/></robot>')
    path = tmp_path / "robot.urdf"
    path.write_text('<robot name="r"><xacro:include filename="macros.xacro"/><link name="a"/></robot>')
    assert nk.RobotModel.from_urdf(path).link_names == ("a",)


def test_a_source_comes_through_a_pipe_when_its_expansion_is_asked_for(tmp_path: Path) -> None:
    def piped() -> Path:
        reader, writer = os.pipe()
        os.write(writer, b'\n<?xml version="1.0"?><robot name="r"><link name="${1 + 1}"/></robot>')
        os.close(writer)
        pipes.append(reader)
        return Path(f"/dev/fd/{reader}")

    pipes: list[int] = []
    try:
        with pytest.raises(BadModel, match=r"--xacro"):
            nk.RobotModel.from_file(piped())
        assert nk.RobotModel.from_file(piped(), xacro=True).link_names == ("2",)
    finally:
        for pipe in pipes:
            os.close(pipe)


def test_only_truth_asks_for_an_expansion(source: Path) -> None:
    with pytest.raises(BadArgument, match="xacro"):
        nk.RobotModel.from_urdf(source, xacro="yes")  # type: ignore[arg-type]


def test_packages_and_arguments_reach_a_source_with_any_name(source: Path, tmp_path: Path) -> None:
    elsewhere = tmp_path / "elsewhere"
    (tmp_path / "arm_description").rename(elsewhere)
    plain = source.rename(tmp_path / "robot.urdf")
    plain.write_text(plain.read_text().replace("arm_description", "elsewhere"))
    with pytest.raises(BadModel, match="xacro"):
        nk.urdf.read_robot(plain, package_dirs=[elsewhere])
    tree, _ = nk.urdf.read_robot(plain, package_dirs=[elsewhere], xacro=True, xacro_arguments={"length": 0.5})
    robot = nk.RobotModel.from_file(plain, package_dirs=[elsewhere], xacro=True, xacro_arguments={"length": 0.5})
    assert nk.RobotModel(tree).position([0.0, 0.0], "r_arm").tolist() == [0.25, 0.0, 0.0]
    assert robot.position([0.0, 0.0], "r_arm").tolist() == [0.25, 0.0, 0.0]
