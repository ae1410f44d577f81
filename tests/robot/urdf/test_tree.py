"""The tree read from a URDF: its numbers, names and defaults, without a model made of it."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

from nao_kin._core.text import fresh_name, with_underscores
from nao_kin.errors import BadModel
from nao_kin.robot.semantics import Mimic
from nao_kin.robot.urdf import TENSOR_LABELS, Box, Collision, Origin, UrdfJoint, UrdfTree
from nao_kin.robot.urdf.reader import read_urdf


def _joint(name: str, parent: str, child: str, inside: str = "", kind: str = "revolute") -> str:
    limit = "" if "<limit" in inside or kind == "fixed" else '<limit lower="-1" upper="1" velocity="2" effort="3"/>'
    return f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{limit}{inside}</joint>'


def _read(folder: Path, *parts: str, links: str = "base a b c") -> UrdfTree:
    path = folder / "robot.urdf"
    bodies = "".join(f'<link name="{link}"/>' for link in links.split())
    path.write_text(f'<robot name="r">{bodies}{"".join(parts)}</robot>', encoding="utf-8")
    return read_urdf(path)


def _by_name(tree: UrdfTree) -> dict[str, UrdfJoint]:
    return {joint.name: joint for joint in tree.joints}


def test_an_axis_without_numbers_is_x(tmp_path: Path) -> None:
    (joint,) = _read(tmp_path, _joint("A", "base", "a", "<axis/>"), links="base a").joints
    assert joint.axis == (1.0, 0.0, 0.0)


def test_a_mimic_without_numbers_follows_one_to_one(tmp_path: Path) -> None:
    follower = _joint("B", "base", "b", '<mimic joint="A"/>')
    tree = _read(tmp_path, _joint("A", "base", "a"), follower, links="base a b")
    assert tree.mimics == {"B": Mimic("A", 1.0, 0.0)}


def test_without_endings_a_name_gets_the_first_number_that_makes_it_new() -> None:
    assert fresh_name("a", {"b"}) == "a"
    assert fresh_name("a", {"a", "a_3"}) == "a_2"
    assert fresh_name("a", {"a", "a_2", "a_3"}) == "a_4"
    assert with_underscores("a", {"a", "a_"}) == "a__"


@pytest.mark.parametrize(("others", "fresh"), [("", "J_link"), ("J_link", "J_frame"), ("J_link J_frame", "J_frame_2")])
@pytest.mark.parametrize("as_joints", [True, False])
def test_a_fresh_name_is_that_of_no_link_and_of_no_joint(
    tmp_path: Path, others: str, fresh: str, as_joints: bool
) -> None:
    names = others.split()
    ends = [f"l{i}" if as_joints else name for i, name in enumerate(names)]
    joints = [_joint(name if as_joints else f"j{i}", "base", ends[i]) for i, name in enumerate(names)]
    tree = _read(tmp_path, _joint("J", "base", "J"), *joints, links=" ".join(["base", "J", *ends]))
    assert tree.shared_names == {"J": fresh}
    assert _by_name(tree)["J"].child == fresh
    assert {*tree.links} & {*_by_name(tree)} == set()


def test_what_hangs_on_a_renamed_link_hangs_on_its_new_name(tmp_path: Path) -> None:
    inertial = '<link name="J"><inertial><mass value="2"/></inertial></link>'
    tree = _read(tmp_path, inertial, _joint("J", "base", "J"), _joint("K", "J", "a"), links="base a")
    assert _by_name(tree)["K"].parent == "J_link"
    assert tree.inertials["J_link"].mass == 2.0


def test_damping_and_friction_are_their_own_and_none_where_they_mean_nothing(tmp_path: Path) -> None:
    (joint,) = _read(
        tmp_path, _joint("A", "base", "a", '<dynamics damping="0.5" friction="0.25"/>'), links="base a"
    ).joints
    assert (joint.damping, joint.friction) == (0.5, 0.25)
    tree = _read(tmp_path, _joint("A", "base", "a", '<dynamics damping="-1" friction="much"/>'), links="base a")
    assert (tree.joints[0].damping, tree.joints[0].friction) == (0.0, 0.0)
    assert tree.notes == ("joint 'A' has damping '-1': taken as none", "joint 'A' has friction 'much': taken as none")


def test_a_mass_below_zero_is_refused(tmp_path: Path) -> None:
    body = '<link name="d"><inertial><mass value="-1"/></inertial></link>'
    with pytest.raises(BadModel, match="link 'd' has mass -1"):
        _read(tmp_path, body, links="")


def test_a_range_of_one_value_is_a_range(tmp_path: Path) -> None:
    limit = '<limit lower="0.5" upper="0.5" velocity="2" effort="3"/>'
    tree = _read(tmp_path, _joint("A", "base", "a", limit), links="base a")
    assert (tree.joints[0].lower, tree.joints[0].upper, tree.notes) == (0.5, 0.5, ())


@pytest.mark.parametrize("scheme", ["package://", "package:///"])
def test_a_mesh_of_a_package_is_found_from_a_folder_inside_of_it(tmp_path: Path, scheme: str) -> None:
    (tmp_path / "shapes" / "urdf").mkdir(parents=True)
    (tmp_path / "shapes" / "a.stl").touch()
    mesh = f'<link name="d"><visual><geometry><mesh filename="{scheme}shapes/a.stl"/></geometry></visual></link>'
    assert _read(tmp_path / "shapes" / "urdf", mesh, links="").notes == ()
    (note,) = _read(tmp_path / "shapes" / "urdf", mesh.replace("a.stl", "b.stl"), links="").notes
    assert note == f"1 of 1 mesh files are missing, first '{scheme}shapes/b.stl'"


@pytest.mark.parametrize(
    ("elements", "kinds"),
    [
        ('<loop_joint name="k" type="spherical"><link1 link="a"/><link2 link="b"/></loop_joint>', "1 .*: <loop_joint>"),
        ("<gazebo><joint name='k' type='revolute'/></gazebo><gazebo/><gazebo reference='a'><mu1/></gazebo>",
         "1 .*: <gazebo><joint>"),
        ("<drake:ball_constraint/><drake:linear_bushing_rpy/><drake:ball_constraint/>",
         "3 .*: <drake:ball_constraint>, <drake:linear_bushing_rpy>"),
    ],
)  # fmt: skip
def test_a_loop_that_stays_open_is_said(tmp_path: Path, elements: str, kinds: str) -> None:
    joints = _joint("A", "base", "a"), _joint("B", "base", "b"), "<transmission/><gazebo><plugin/></gazebo>"
    assert _read(tmp_path, *joints, links="base a b").notes == ()
    (note,) = _read(tmp_path, *joints, elements, links="base a b").notes
    assert re.fullmatch(kinds.replace(".*", "elements that close loops are left out, and the loops stay open"), note)


def _limited(lower: float, upper: float, effort: float = 3.0, kind: str = "revolute") -> str:
    limit = f'<limit lower="{lower}" upper="{upper}" velocity="2" effort="{effort}"/>'
    return _joint("A", "base", "a", limit).replace('"revolute"', f'"{kind}"')


@pytest.mark.parametrize(
    ("joint", "note"),
    [
        (_limited(-1, 1, effort=0.0), "joint 'A' has an effort limit of 0"),
        (_limited(0, 0), "joint 'A' has lower and upper limits of 0, and cannot move"),
        (_limited(-90, 0), "joint 'A' has limits that seem to be in degrees"),
        (_limited(0, 90), "joint 'A' has limits that seem to be in degrees"),
        (_limited(0, 90, kind="prismatic"), None),
        (_limited(-6.3, 6.3), None),  # a UR10
        (_limited(-1e16, 1e16), None),  # a rotor of Iris: unlimited
    ],
)
def test_limits_that_no_robot_has_are_said(tmp_path: Path, joint: str, note: str | None) -> None:
    tree = _read(tmp_path, joint, links="base a")
    assert tree.notes == ((note,) if note else ())


@pytest.mark.parametrize(
    ("mass", "tensor", "possible"),
    [
        (1.0, (1.0, 0.0, 0.0, 1.0, 0.0, 2.0), True),  # a flat disc, the limit of the triangle inequality
        (1.0, (1.0, 0.0, 0.0, 1.0, 0.0, 2.01), False),
        (1.0, (1.0, 0.9, 0.0, 1.0, 0.0, 1.0), False),  # principal moments 0.1, 1 and 1.9
        (1.0, (-1.0, 0.0, 0.0, -1.0, 0.0, -1.0), False),
        (1e-6, (1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6), True),  # a placeholder, as in several quadrupeds
    ],
)
def test_a_tensor_that_no_body_has_is_said(
    tmp_path: Path, mass: float, tensor: tuple[float, ...], possible: bool
) -> None:
    values = " ".join(f'{name}="{value!r}"' for name, value in zip(TENSOR_LABELS, tensor, strict=True))
    body = f'<link name="d"><inertial><mass value="{mass!r}"/><inertia {values}/></inertial></link>'
    notes = () if possible else ("link 'd' has an inertia tensor that no body has",)
    assert _read(tmp_path, body, links="").notes == notes


# --- couplings --------------------------------------------------------------------------------------------------------


def _limit(lower: float, upper: float, velocity: float = 2.0) -> str:
    return f'<limit lower="{lower}" upper="{upper}" velocity="{velocity}" effort="3"/>'


def test_a_chain_of_followers_is_composed_from_the_inside_out(tmp_path: Path) -> None:
    tree = _read(
        tmp_path,
        _joint("A", "base", "a", _limit(-9, 9)),
        _joint("B", "base", "b", _limit(-99, 99) + '<mimic joint="A" multiplier="2" offset="0.5"/>'),
        _joint("C", "base", "c", _limit(-99, 99) + '<mimic joint="B" multiplier="-3" offset="0.25"/>'),
    )
    assert tree.mimics == {"B": Mimic("A", 2.0, 0.5), "C": Mimic("A", -6.0, -1.25)}
    assert "joint 'C' follows 'B', which follows 'A': made to follow 'A' directly" in tree.notes


@pytest.mark.parametrize("names", ["ABC", "CBA", "BCA"])
def test_the_branch_of_a_driving_joint_comes_before_those_that_follow(tmp_path: Path, names: str) -> None:
    driver, middle, last = names
    tree = _read(
        tmp_path,
        _joint(driver, "base", "a", _limit(-9, 9)),
        _joint(middle, "base", "b", _limit(-9, 9) + f'<mimic joint="{driver}"/>'),
        _joint(last, "base", "c", _limit(-9, 9) + f'<mimic joint="{driver}"/>'),
    )
    assert tree.joints[0].name == driver
    assert set(tree.mimics) == {middle, last}


def test_a_driver_that_keeps_its_own_range_still_shares_the_speed(tmp_path: Path) -> None:
    tree = _read(
        tmp_path,
        _joint("A", "base", "a", _limit(0, 0.8, velocity=2)),
        _joint("B", "base", "b", _limit(0, 0.8, velocity=1) + '<mimic joint="A" multiplier="-4"/>'),
        links="base a b",
    )
    driver = _by_name(tree)["A"]
    assert (driver.lower, driver.upper, driver.velocity) == (0.0, 0.8, 0.25)


def test_a_constant_follower_confines_nobody(tmp_path: Path) -> None:
    tree = _read(
        tmp_path,
        _joint("A", "base", "a"),
        _joint("B", "base", "b", _limit(0.5, 0.75) + '<mimic joint="A" multiplier="0" offset="0.5"/>'),
        links="base a b",
    )
    assert (_by_name(tree)["A"].lower, _by_name(tree)["A"].upper, tree.notes) == (-1.0, 1.0, ())


@pytest.mark.parametrize(("driver", "follower"), [((0.5, 0.5), (-1.0, 0.25)), ((-1.0, 0.25), (0.5, 0.5))])
def test_a_joint_that_cannot_move_alone_must_suit_the_other(
    tmp_path: Path, driver: tuple[float, float], follower: tuple[float, float]
) -> None:
    with pytest.raises(BadModel, match="'B' follows 'A', and no value is inside the limits of both of them"):
        _read(
            tmp_path,
            _joint("A", "base", "a", _limit(*driver)),
            _joint("B", "base", "b", _limit(*follower) + '<mimic joint="A"/>'),
            links="base a b",
        )


def test_limits_that_differ_by_rounding_confine_nobody(tmp_path: Path) -> None:
    limits = math.nextafter(-0.3, 0.0), math.nextafter(0.3, 0.0)
    tree = _read(
        tmp_path,
        _joint("A", "base", "a", _limit(-0.3, 0.3)),
        _joint("B", "base", "b", _limit(*limits) + '<mimic joint="A"/>'),
        links="base a b",
    )
    assert (_by_name(tree)["A"].lower, _by_name(tree)["A"].upper, tree.notes) == (-0.3, 0.3, ())


# --- looks ------------------------------------------------------------------------------------------------------------


def test_the_colour_of_a_visual_comes_before_that_of_its_name(tmp_path: Path) -> None:
    red = '<material name="m"><color rgba="1 0 0 1"/></material>'
    shape = '<geometry><sphere radius="1"/></geometry>'
    own = f'<visual>{shape}<material name="m"><color rgba="0 1 0 1"/></material></visual>'
    named = f'<visual>{shape}<material name="m"/></visual>'
    tree = _read(tmp_path, red, f'<link name="d">{own}{named}</link>', links="")
    assert [visual.rgba for visual in tree.visuals] == [(0.0, 1.0, 0.0, 1.0), (1.0, 0.0, 0.0, 1.0)]


def test_collision_shapes_are_read_as_data(tmp_path: Path) -> None:
    box = '<collision name="b"><origin xyz="1 2 3"/><geometry><box size="1 2 3"/></geometry></collision>'
    wrong = '<collision><geometry><sphere radius="big"/></geometry></collision>'
    tree = _read(tmp_path, "", f'<link name="d">{box}{wrong}</link>', links="")
    assert tree.collisions == (Collision("d", Origin((1.0, 2.0, 3.0)), Box((1.0, 2.0, 3.0)), "b"),)
    assert tree.collision_notes == (
        "a collision shape of d is left out: sphere has radius 'big', expected 1 finite numbers",
    )
