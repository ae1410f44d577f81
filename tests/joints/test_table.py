from __future__ import annotations

import json
import math
from xml.etree import ElementTree

import numpy as np
import pytest
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.joints import ANATOMY, JointAxes, group_joints, joint_table


def test_untyped_there_is_a_row_for_every_joint_of_the_urdf_chain_by_chain(each_nao) -> None:
    table = joint_table(each_nao)
    assert [row.joint for row in table.rows] == [name for chain in each_nao.chains.values() for name in chain]
    assert {row.chain: row.parts for row in table.rows}.keys() == each_nao.chains.keys()
    assert {row.pair for row in table.rows} == {"revolute"}
    assert table.summary == "25 DOF = 26×1 − 1"
    assert table.dof == 25


def test_typed_there_are_fifteen_rows(each_nao) -> None:
    table = joint_table(each_nao, typed=True)
    assert len(table.rows) == 15
    assert sum(row.freedoms for row in table.rows) - 1 == table.dof == 25
    assert [row.chain for row in table.rows] == ["Head"] + ["LArm"] * 4 + ["LLeg"] * 3 + ["RLeg"] * 3 + ["RArm"] * 4
    assert table.summary == "25 DOF = 2×3 + 7×2 + 6×1 − 1"


def test_the_rule_and_the_tolerance_reach_the_merging(nao) -> None:
    assert len(joint_table(nao, typed=True, rule="concurrent").rows) == 13
    assert joint_table(nao, typed=True, rule="concurrent", tolerance=1e-6).tolerance == 1e-6
    with pytest.raises(UnknownName):
        joint_table(nao, typed=True, rule="none")
    with pytest.raises(BadArgument):
        joint_table(nao, typed=True, tolerance=-1)


@pytest.mark.parametrize("typed", [False, True])
def test_screws_are_the_plucker_coordinates_of_the_axes(each_nao, typed) -> None:
    axes = JointAxes(each_nao)
    drawn = axes.lines(each_nao.neutral()).coordinates
    for row in joint_table(each_nao, typed=typed).rows:
        expected = drawn[[axes.names.index(part) for part in row.parts]]
        assert np.allclose(row.screws, expected, rtol=0, atol=1e-15)
        assert np.allclose(row.axes, expected[:, :3], rtol=0, atol=1e-15)
        assert np.allclose(np.cross(row.centre, row.axes), expected[:, 3:], rtol=0, atol=1e-15)


def test_rows_speak_anatomy(nao) -> None:
    rows = {row.joint: (row.body, row.anatomical) for row in joint_table(nao, typed=True).rows}
    assert rows["HeadYaw+HeadPitch"] == ("neck", "saddle")
    assert rows["LHipYawPitch+LHipRoll+LHipPitch"] == ("left hip", "ball and socket")
    assert rows["RKneePitch"] == ("right knee", "hinge")
    assert rows["RWristYaw"] == ("right wrist", "pivot")
    elbow = joint_table(nao, typed=True, rule="concurrent").rows[2]
    assert (elbow.joint, elbow.body, elbow.anatomical) == (
        "LElbowYaw+LElbowRoll+LWristYaw",
        "left elbow",
        "ball and socket",
    )


def test_limits_units_and_the_shared_motor_are_in_the_rows(nao) -> None:
    rows = {row.joint: row for row in joint_table(nao).rows}
    column = nao.joint_names.index("LHipYawPitch")
    assert rows["RHipYawPitch"].lower == rows["LHipYawPitch"].lower == (nao.lower[column],)
    assert rows["RHipYawPitch"].coupled_to == ("LHipYawPitch",)
    assert rows["LHipYawPitch"].coupled_to == ()
    assert rows["LHand"].units == ("1",)
    assert rows["LHand"].upper == (1.0,)


def test_the_table_is_json_even_without_limits(tmp_path, nao) -> None:
    def refuse(value: str) -> None:
        raise AssertionError(value)

    limitless = made_up(tmp_path, J("a", (0, 0, 1), kind="continuous"), J("s", (0, 1, 0), kind="prismatic"))
    for robot in (nao, limitless, nk.load_robot("romeo", base="floating")):
        for typed in (False, True):
            table = joint_table(robot, typed=typed)
            again = json.loads(json.dumps(table.as_dict(), allow_nan=False), parse_constant=refuse)
            assert [row["joint"] for row in again["rows"]] == [row.joint for row in table.rows]
            assert again["summary"] == table.summary
    row = joint_table(limitless).as_dict()["rows"][0]
    assert row["lower"] == row["upper"] == (None,)


def test_zeros_have_no_sign(each_nao) -> None:
    for row in joint_table(each_nao, typed=True).rows:
        numbers = np.array([*np.ravel(row.axes), *row.centre, *np.ravel(row.screws)])
        assert not np.any((numbers == 0) & np.signbit(numbers))


def test_chains_of_other_robots_go_by_their_semantics_or_their_first_joint() -> None:
    romeo = nk.load_robot("romeo")
    rows = joint_table(romeo, typed=True).rows
    chains = list(dict.fromkeys(row.chain for row in rows))
    assert chains == ["r_leg", "l_leg", "TrunkYaw", "LShoulderPitch", "NeckYaw", "RShoulderPitch"]
    bare = nk.RobotModel.from_urdf(romeo.urdf_path, semantics=nk.semantics.Semantics())
    rows = joint_table(bare, typed=True).rows
    chains = list(dict.fromkeys(row.chain for row in rows))
    assert chains == ["LHipYaw", "RHipYaw", "TrunkYaw", "LShoulderPitch", "NeckYaw", "RShoulderPitch"]
    assert [row.joint for row in rows if row.chain == "NeckYaw"] == ["NeckYaw+NeckPitch", "HeadPitch+HeadRoll"]


def test_a_free_base_is_a_row_without_axes() -> None:
    row = joint_table(nk.load_nao("v6", base="floating")).rows
    free = next(r for r in row if r.pair == "free")
    assert (free.axes, free.screws, free.freedoms) == ((), (), 6)
    assert math.isinf(free.upper[0])


# --- in a terminal and in a notebook ----------------------------------------------------------------------------------


def test_joints_groups_and_tables_print_in_one_short_line(each_nao) -> None:
    groups = group_joints(each_nao)
    for thing in (groups, groups["LHipRoll"], joint_table(each_nao, typed=True)):
        assert "\n" not in repr(thing)
        assert len(repr(thing)) < 120
    assert "2×3 + 7×2 + 6×1 − 1" in repr(groups)
    assert "spherical at (0, 0.05, -0.085) m" in repr(groups["LHipRoll"])


def test_anatomy_prints_as_the_table_it_is() -> None:
    lines = repr(ANATOMY).splitlines()
    assert len(lines) == 2 + len(ANATOMY)
    assert lines[0].split() == ["joint", "moves", "like", "freedoms", "example"]
    assert [line.split("  ")[0] for line in lines[2:]] == [kind.name for kind in ANATOMY]
    assert isinstance(ANATOMY, tuple)


def test_notebooks_show_tables_with_a_row_for_every_joint(nao) -> None:
    shown = {group_joints(nao): 15, joint_table(nao): 26, joint_table(nao, typed=True): 15, ANATOMY: 6}
    for thing, rows in shown.items():
        table = ElementTree.fromstring(thing._repr_html_())
        assert len(table.findall("tbody/tr")) == rows
        widths = {len(row) for row in table.iter("tr")}
        assert len(widths) == 1


def test_names_are_escaped_in_notebooks(tmp_path) -> None:
    robot = made_up(tmp_path, J("a&lt;script&gt;alert(1)&lt;/script&gt;"), J("b", (1, 0, 0)))
    for thing in (group_joints(robot), joint_table(robot), joint_table(robot, typed=True)):
        html = thing._repr_html_()
        assert "<script" not in html
        assert "&lt;script&gt;alert(1)" in html


def test_earlier_names_are_the_same_things() -> None:
    assert nk.joints.LowerPair is nk.joints.KinematicPair
