from __future__ import annotations

from pathlib import Path

import pytest

import nao_kin as nk
from nao_kin.errors import MissingExtra
from nao_kin.joints import JointAxes
from nao_kin.robot import topology
from nao_kin.robot.semantics import Mimic

VERSIONS = ["v3.2", "v3.3", "v4", "v5", "v6"]


def joint(name: str, parent: str, child: str, mimic: str = "") -> str:
    return (
        f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/><axis xyz="0 0 1"/>'
        f'<limit lower="-1" upper="1" effort="1" velocity="1"/>{mimic}</joint>'
    )


def robot_from(tmp_path: Path, *joints: str, links: str) -> nk.RobotModel:
    path = tmp_path / "robot.urdf"
    bodies = "".join(f'<link name="{name}"/>' for name in links.split())
    path.write_text(f'<robot name="r">{bodies}{"".join(joints)}</robot>', encoding="utf-8")
    return nk.RobotModel.from_urdf(path)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("base", ["fixed", "floating"])
def test_the_nao_is_one_tree_of_five_serial_chains_with_one_coupling(version, base) -> None:
    nao = nk.load_nao(version, base=base)
    structure = topology(nao)
    assert structure.degrees_of_freedom == 25
    assert structure.closed_loops == 0
    assert set(structure.chains) == set(nao.chains.values())
    assert sum(len(chain) for chain in structure.chains) == 26
    assert structure.couplings_between_limbs == {"RHipYawPitch": Mimic("LHipYawPitch")}


def test_chains_end_where_the_tree_branches(tmp_path) -> None:
    robot = robot_from(
        tmp_path,
        joint("waist", "base", "chest"),
        joint("neck", "chest", "head"),
        joint("arm", "chest", "upper"),
        joint("elbow", "upper", "lower"),
        links="base chest head upper lower",
    )
    assert set(topology(robot).chains) == {("waist",), ("neck",), ("arm", "elbow")}
    assert topology(robot).couplings == {}


def test_a_follower_between_two_joints_of_its_limb_does_not_break_the_chain(tmp_path) -> None:
    robot = robot_from(
        tmp_path,
        joint("a", "base", "one"),
        joint("b", "one", "two", mimic='<mimic joint="a"/>'),
        joint("c", "two", "three"),
        joint("other", "base", "side", mimic='<mimic joint="a" multiplier="2"/>'),
        links="base one two three side",
    )
    structure = topology(robot)
    assert set(structure.chains) == {("a", "c"), ("other",)}
    assert structure.couplings == {"b": Mimic("a"), "other": Mimic("a", 2.0)}
    assert structure.couplings_between_limbs == {"other": Mimic("a", 2.0)}
    assert structure.degrees_of_freedom == 2


def test_romeo_has_six_chains() -> None:
    try:
        romeo = nk.load_robot("romeo")
    except MissingExtra:
        pytest.skip("example-robot-data is not installed")
    structure = topology(romeo)
    assert sorted(len(chain) for chain in structure.chains) == [1, 4, 6, 6, 8, 8]
    assert structure.closed_loops == 0


def test_the_structure_needs_no_file_any_more(tmp_path) -> None:
    robot = robot_from(tmp_path, joint("a", "base", "one"), links="base one")
    robot.urdf_path.unlink()
    assert topology(robot).closed_loops == 0
    assert JointAxes(robot).names == ("a",)


def test_joints_between_two_links_begin_at_the_root_if_the_first_does_not_carry_the_second(tmp_path: Path) -> None:
    tree = robot_from(tmp_path, joint("j", "a", "b"), joint("k", "b", "c"), joint("l", "b", "d"), links="a b c d").tree
    assert [[row.name for row in tree.joints_to("c", base=base)] for base in "abcd"] == [
        ["j", "k"],
        ["k"],
        [],
        ["j", "k"],
    ]
