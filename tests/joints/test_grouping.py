from __future__ import annotations

import math

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, strategies as st
from loops import for_all
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.joints import JointAxes, group_joints
from nao_kin.joints.grouping import RULES, partition, unmerged_joints
from nao_kin.robot.semantics import Mimic
from nao_kin.screws import lines

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def shape(groups) -> dict[str, str]:
    return {joint.name: joint.pair.name for joint in groups}


def both(*parts: str) -> list[str]:
    return ["+".join(f"{side}{part}" for part in parts) for side in "LR"]


def miss(robot: nk.RobotModel, joint, q: np.ndarray) -> float:
    """Return how far apart the axes of a joint are, computed from the URDF, in configurations q [m]."""
    axes = JointAxes(robot)
    drawn = axes.lines(q)[..., [axes.names.index(name) for name in joint.joints]]
    pairs = [(i, k) for i in range(len(joint.joints)) for k in range(i)]
    return max(float(lines.distance(drawn[..., i], drawn[..., k]).max()) for i, k in pairs)


# --- the NAO ----------------------------------------------------------------------------------------------------------


def test_coincident_centres_give_fifteen_joints(each_nao) -> None:
    expected = {"HeadYaw+HeadPitch": "universal"}
    expected |= dict.fromkeys(both("ShoulderPitch", "ShoulderRoll"), "universal")
    expected |= dict.fromkeys(both("ElbowYaw", "ElbowRoll"), "universal")
    expected |= dict.fromkeys(both("AnklePitch", "AnkleRoll"), "universal")
    expected |= dict.fromkeys(both("HipYawPitch", "HipRoll", "HipPitch"), "spherical")
    expected |= dict.fromkeys(both("WristYaw") + both("KneePitch") + both("Hand"), "revolute")
    groups = group_joints(each_nao)
    assert shape(groups) == expected
    assert len(groups) == 15
    assert groups.mobility == 25
    assert groups.summary == "25 DOF = 2×3 + 7×2 + 6×1 − 1"


def test_concurrent_axes_make_the_elbow_spherical_from_v33_on() -> None:
    for version in ("v3.3", "v4", "v5", "v6"):
        groups = group_joints(nk.load_nao(version), rule="concurrent")
        merged = shape(groups)
        for elbow in both("ElbowYaw", "ElbowRoll", "WristYaw"):
            assert merged.pop(elbow) == "spherical"
        for shoulder in both("ShoulderPitch", "ShoulderRoll"):
            assert merged.pop(shoulder) == "universal"
        others = {name: pair for name, pair in shape(group_joints(nk.load_nao(version))).items() if name in merged}
        assert merged == others
        assert groups.summary == "25 DOF = 4×3 + 5×2 + 4×1 − 1"


def test_concurrent_axes_make_the_shoulder_of_v32_spherical() -> None:
    groups = group_joints(nk.load_nao("v3.2"), rule="concurrent")
    merged = shape(groups)
    assert [merged[name] for name in both("ShoulderPitch", "ShoulderRoll", "ElbowYaw")] == ["spherical"] * 2
    assert [merged[name] for name in both("ElbowRoll", "WristYaw")] == ["universal"] * 2
    assert np.allclose(groups["LElbowYaw"].centre, (0, 0.098, 0.1), rtol=0, atol=1e-15)
    assert np.allclose(groups["RWristYaw"].centre, (0.09, -0.098, 0.1), rtol=0, atol=1e-15)
    assert groups.mobility == 25


@for_all("rule", RULES)
def test_axes_of_a_merged_joint_meet_in_every_configuration(each_nao, rule) -> None:
    q = np.random.default_rng(1).uniform(-3, 3, (200, 25))
    for joint in group_joints(each_nao, rule=rule):
        if len(joint.joints) > 1:
            assert miss(each_nao, joint, q) < 1e-15
            assert joint.residual < 1e-16


@for_all("rule", RULES)
def test_neighbours_left_apart_do_not_meet(each_nao, rule) -> None:
    axes = JointAxes(each_nao)
    at_zero = axes.lines(each_nao.neutral())
    groups = group_joints(each_nao, rule=rule)
    apart = [
        (groups[chain[i]], groups[chain[i + 1]], chain[i], chain[i + 1])
        for chain in each_nao.chains.values()
        for i in range(len(chain) - 1)
        if groups[chain[i]] is not groups[chain[i + 1]]
    ]
    assert apart
    for inner, outer, first, second in apart:
        near, far = (at_zero[axes.names.index(name)] for name in (first, second))
        centres = {name: each_nao.position(each_nao.neutral(), name) for name in (first, second)}
        overlap = len(inner.joints) + len(outer.joints) > 3
        if rule == "coincident" and not overlap:
            assert np.linalg.norm(centres[first] - centres[second]) > 0.01
        elif not overlap:
            parallel = abs(float(near.direction @ far.direction)) > 1 - 1e-12
            assert parallel or lines.distance(near, far) > 0.01


def test_the_shared_hip_motor_is_the_one_coupling_and_fingers_are_no_joints(each_nao) -> None:
    groups = group_joints(each_nao)
    assert groups.mimics == {"RHipYawPitch": Mimic("LHipYawPitch", 1.0, 0.0)}
    assert len(groups.driven) == 16
    assert set(groups.driven) == set(each_nao.mimics) - {"RHipYawPitch"}


def test_centres_stand_at_the_joints_and_carry_their_neighbours(nao) -> None:
    groups = group_joints(nao)
    for joint in groups:
        for part in joint.joints:
            assert np.array_equal(joint.centre, nao.position(nao.neutral(), part))
    assert groups["LKneePitch"].parent == "LHipYawPitch+LHipRoll+LHipPitch"
    assert groups["HeadPitch"].parent == ""
    assert groups["RHand"].parent == "RWristYaw"


def test_axes_are_those_of_the_urdf_and_at_right_angles(each_nao) -> None:
    axes = JointAxes(each_nao)
    drawn = axes.lines(each_nao.neutral())
    for joint in group_joints(each_nao, rule="concurrent"):
        index = [axes.names.index(name) for name in joint.joints]
        assert np.allclose(joint.lines.coordinates, drawn[index].coordinates, rtol=0, atol=1e-15)
        assert np.allclose(joint.angles_between, math.pi / 2, rtol=0, atol=1e-15)
        assert not joint.axes.flags.writeable


def test_limits_are_the_robots_and_the_mimic_has_its_drivers(nao) -> None:
    hip = group_joints(nao)["RHipRoll"]
    lower = dict(zip(nao.joint_names, nao.lower, strict=True))
    assert hip.lower == (lower["LHipYawPitch"], lower["RHipRoll"], lower["RHipPitch"])
    assert group_joints(nao)["LHand"].units == ("1",)


# --- singularities ----------------------------------------------------------------------------------------------------


@for_all(
    ("version", "rule", "part", "degrees", "margin"),
    [
        ("v6", "coincident", "LHipRoll", (-45, 135), 45 - 21.74),
        ("v4", "coincident", "LHipRoll", (-45, 135), 45 - 21.74),
        ("v6", "concurrent", "LElbowRoll", (0, 180), 2),
        ("v3.2", "concurrent", "LShoulderRoll", (-90, 90), 90 - 94.5),
    ],
)
def test_singular_configurations_and_how_far_the_limits_keep_off(version, rule, part, degrees, margin) -> None:
    singularity = group_joints(nk.load_nao(version), rule=rule)[part].singularity
    assert singularity.joint == part
    assert np.degrees(singularity.at) == pytest.approx(degrees, abs=1e-12)
    assert math.degrees(singularity.margin) == pytest.approx(margin, abs=1e-9)
    assert singularity.reachable == (margin <= 0)


@for_all("rule", RULES)
def test_at_a_singular_value_the_axes_span_a_plane_and_beside_it_space(each_nao, rule) -> None:
    names = list(each_nao.joint_names)
    rng = np.random.default_rng(4)
    for joint in group_joints(each_nao, rule=rule):
        if len(joint.joints) < 3:
            assert joint.singularity is None
            continue
        axes = JointAxes(each_nao)
        index = [axes.names.index(name) for name in joint.joints]

        def smallest(value: float, joint=joint, axes=axes, index=index) -> float:
            q = rng.uniform(-3, 3, 25)
            q[names.index(joint.singularity.joint)] = value
            return float(np.linalg.svd(axes.lines(q)[index].direction)[1][-1])

        for value in joint.singularity.at:
            assert smallest(value) < 1e-15
            assert smallest(value + 1e-3) == pytest.approx(1e-3 / math.sqrt(2), rel=1e-3)
        middle = sum(joint.singularity.at) / 2
        assert smallest(middle) == pytest.approx(1.0, abs=1e-12)


# --- other robots -----------------------------------------------------------------------------------------------------


def test_romeo_has_a_spherical_wrist_and_with_concurrent_axes_a_human_arm() -> None:
    romeo = nk.load_robot("romeo")
    coincident, concurrent = (group_joints(romeo, rule=rule) for rule in RULES)
    assert coincident.mobility == concurrent.mobility == romeo.nv == 33
    assert shape(coincident)["LWristRoll+LWristYaw+LWristPitch"] == "spherical"
    assert shape(coincident)["LShoulderPitch+LShoulderYaw"] == "universal"
    arm = [joint.pair.symbol for joint in concurrent if joint.joints[0].startswith("R") and joint.centre[2] > 0.19]
    assert arm == ["S", "R", "S", "R"]
    q = np.random.default_rng(1).uniform(-3, 3, (50, 33))
    for joint in concurrent:
        if len(joint.joints) > 1:
            assert miss(romeo, joint, q) < 1e-14


def test_a_floating_base_is_a_free_joint_of_six_freedoms() -> None:
    groups = group_joints(nk.load_nao("v6", base="floating"))
    assert groups.joints[0].pair.name == "free"
    assert groups.joints[0].axes.shape == (0, 3)
    assert groups.mobility == 31
    assert groups.summary == "31 DOF = 1×6 + 2×3 + 7×2 + 6×1 − 1"
    assert groups["HeadYaw"].parent == groups.joints[0].name


def test_unmerged_joints_are_those_of_the_urdf(each_nao) -> None:
    groups = unmerged_joints(each_nao)
    assert [joint.name for joint in groups] == [
        name for name in each_nao.model.names if name in (*each_nao.joint_names, "RHipYawPitch")
    ]
    assert groups.summary == "25 DOF = 26×1 − 1"


# --- made-up chains ---------------------------------------------------------------------------------------------------


def test_a_prismatic_joint_breaks_a_run(tmp_path) -> None:
    robot = made_up(tmp_path, J("a", Z), J("b", X), J("slide", Y, kind="prismatic"), J("c", Z), J("d", X))
    assert shape(group_joints(robot)) == {"a+b": "universal", "slide": "prismatic", "c+d": "universal"}
    assert group_joints(robot).mobility == 5


@pytest.mark.parametrize("rule", RULES)
def test_parallel_axes_are_not_merged_even_on_one_line(tmp_path, rule) -> None:
    for sign in (1.0, -1.0):
        robot = made_up(tmp_path, J("a", Z), J("b", (0.0, 0.0, sign)), J("c", Z, xyz=(0.3, 0, 0)))
        assert set(shape(group_joints(robot, rule=rule)).values()) == {"revolute"}


def test_axes_that_meet_away_from_their_centres_are_concurrent_only(tmp_path) -> None:
    robot = made_up(tmp_path, J("a", Z, xyz=(0.4, 0.5, 0.6)), J("b", X, xyz=(0.3, 0, 0.2)), J("c", Z, xyz=(-0.3, 0, 0)))
    assert len(group_joints(robot)) == 3
    (joint,) = group_joints(robot, rule="concurrent")
    assert joint.pair.name == "spherical"
    assert np.allclose(joint.centre, (0.4, 0.5, 0.8), rtol=0, atol=1e-15)
    assert miss(robot, joint, np.random.default_rng(0).uniform(-3, 3, (100, 3))) < 1e-14


def test_centres_count_and_not_axes_where_centres_are_to_coincide(tmp_path) -> None:
    # Each centre lies 0.7 mm from the point between them, each axis 0.5 mm.
    robot = made_up(tmp_path, J("a", Z), J("b", X, xyz=(1e-3, 0.0, 1e-3)))
    assert len(group_joints(robot, tolerance=6e-4)) == 2
    assert len(group_joints(robot, tolerance=8e-4)) == 1
    assert len(group_joints(robot, tolerance=1e-12, rule="concurrent")) == 1


@pytest.mark.parametrize(("lean", "expected"), [(8e-10, 1), (1e-8, 2), (5e-3, 2)])
def test_a_ball_asks_for_right_angles_to_rounding(tmp_path, lean, expected) -> None:
    robot = made_up(tmp_path, J("a", Z), J("b", (1.0, 0.0, lean)), J("c", Y))
    assert len(group_joints(robot)) == expected


def test_axes_that_meet_only_at_zero_are_not_concurrent(tmp_path) -> None:
    # c passes through the meeting point of a and b at zero, but turns away with b.
    robot = made_up(tmp_path, J("a", Z), J("b", X, xyz=(0.0, 0.2, 0.0)), J("c", Y, xyz=(0.0, 0.3, 0.0)))
    assert shape(group_joints(robot, rule="concurrent")) == {"a": "revolute", "b+c": "universal"}


@pytest.mark.parametrize("rule", RULES)
def test_of_four_axes_through_a_point_the_first_three_are_spherical(tmp_path, rule) -> None:
    robot = made_up(tmp_path, J("a", Z), J("b", X), J("c", Y), J("d", X))
    groups = group_joints(robot, rule=rule)
    assert shape(groups) == {"a+b+c": "spherical", "d": "revolute"}
    assert groups.mobility == 4


def test_three_oblique_axes_are_no_ball_for_they_do_not_reach_every_rotation(tmp_path) -> None:
    robot = made_up(tmp_path, J("a", Z), J("b", (0.0, 1.0, 1.0)), J("c", Y))
    groups = group_joints(robot)
    assert shape(groups) == {"a+b": "universal", "c": "revolute"}
    assert math.degrees(groups["a"].angles_between[0]) == pytest.approx(45)


def test_fewest_joints_then_largest_then_closest_to_the_root(tmp_path) -> None:
    # Seven axes of a human arm: shoulder, its third axis through the elbow, elbow, forearm, wrist.
    arm = [J("s1", Y), J("s2", Z), J("s3", X), J("e", Z, xyz=(0.3, 0, 0))]
    arm += [J("w1", X, xyz=(0.1, 0, 0)), J("w2", Z, xyz=(0.2, 0, 0)), J("w3", Y)]
    assert [joint.name for joint in group_joints(made_up(tmp_path, *arm), rule="concurrent")] == [
        "s1+s2+s3",
        "e",
        "w1+w2+w3",
    ]
    # Either end of the run can have the middle axis: the root's does.
    robot = made_up(tmp_path, J("a", Z), J("b", X, xyz=(0, 0, 0.1)), J("c", Z, xyz=(0.1, 0, 0)))
    assert [joint.name for joint in group_joints(robot, rule="concurrent")] == ["a+b", "c"]


@given(st.lists(st.integers(1, 3), min_size=1, max_size=4), st.sets(st.tuples(st.integers(0, 11), st.integers(2, 3))))
def test_the_cut_of_a_run_is_the_best_of_all(lengths, extra) -> None:
    run = list(range(sum(lengths)))
    starts = [sum(lengths[:i]) for i in range(len(lengths))]
    allowed = {*zip(starts, lengths, strict=True), *extra}

    def cuts(start: int) -> list[list[int]]:
        if start == len(run):
            return [[]]
        return [
            [length, *rest]
            for length in (1, 2, 3)
            if start + length <= len(run) and (length == 1 or (start, length) in allowed)
            for rest in cuts(start + length)
        ]

    found = partition(run, lambda piece: (piece[0], len(piece)) in allowed, 3)
    best = min(cuts(0), key=lambda cut: (len(cut), -sum(n * n for n in cut), [-n for n in cut]))
    assert [len(piece) for piece in found] == best
    assert [item for piece in found for item in piece] == run


def test_a_branch_ends_a_run(tmp_path) -> None:
    robot = made_up(tmp_path, J("a", Z), J("b", X), J("c", Y, parent="a"))
    assert shape(group_joints(robot)) == dict.fromkeys("abc", "revolute")


def test_followers_at_the_end_of_a_branch_do_not_end_a_run(tmp_path) -> None:
    robot = made_up(tmp_path, J("a", Z), J("b", X), J("f", Y, parent="a", follows=("a", 2.0, 0.1)))
    groups = group_joints(robot)
    assert shape(groups) == {"a+b": "universal"}
    assert groups.driven == ("f",)


def test_joints_of_one_motor_are_not_merged_with_each_other(tmp_path) -> None:
    robot = made_up(tmp_path, J("a", Z), J("b", X, follows=("a", 1.0, 0.0)), J("c", Y))
    groups = group_joints(robot)
    assert shape(groups) == {"a": "revolute", "b+c": "universal"}
    assert groups.mobility == robot.nv == 2
    robot = made_up(
        tmp_path,
        J("m", Z),
        J("a", Z, parent="base", follows=("m", 1.0, 0.0)),
        J("b", X, follows=("m", 2.0, 0.0)),
        J("c", Y),
    )
    groups = group_joints(robot)
    assert shape(groups) == {"m": "revolute", "a": "revolute", "b+c": "universal"}
    assert groups.mobility == robot.nv == 2


def test_a_joint_that_follows_with_multiplier_zero_is_no_joint(tmp_path) -> None:
    robot = made_up(tmp_path, J("a", Z), J("still", X, follows=("a", 0.0, 0.4)), J("b", Y, xyz=(0, 0, 0.2)))
    groups = group_joints(robot)
    assert shape(groups) == {"a": "revolute", "b": "revolute"}
    assert groups.driven == ("still",)
    assert groups.mobility == 2
    expected = pin.exp3(np.array([0.4, 0, 0]))
    assert np.allclose(groups["b"].axes[0], expected @ Y, rtol=0, atol=1e-15)
    assert groups["b"].parent == "a"


def test_offsets_of_mimics_do_not_move_the_axes(tmp_path) -> None:
    robot = made_up(
        tmp_path,
        J("m", Z, xyz=(1, 0, 0)),
        J("a", Z, parent="base", follows=("m", -2.0, 0.7), limits=(-9.0, 9.0)),
        J("b", X),
        J("c", Y),
    )
    ball = group_joints(robot)["b"]
    assert np.allclose(ball.axes, np.eye(3)[[2, 0, 1]], rtol=0, atol=1e-15)
    assert (ball.lower[0], ball.upper[0]) == (-2 * 3.0 + 0.7, 2 * 3.0 + 0.7)


@pytest.mark.parametrize("tolerance", [1e-12, 1e-3])
@pytest.mark.parametrize("rule", RULES)
def test_nearly_meeting_axes_are_merged_up_to_the_tolerance(tmp_path, tolerance, rule) -> None:
    for miss_, expected in ((1.9 * tolerance, 1), (2.1 * tolerance, 2)):
        # Halfway between the two, each axis misses the common point by half of this.
        robot = made_up(tmp_path, J("a", Z), J("b", X, xyz=(0, miss_, 0)))
        groups = group_joints(robot, rule=rule, tolerance=tolerance)
        assert len(groups) == expected
        assert groups.tolerance == tolerance
        if expected == 1:
            assert groups["a"].residual == pytest.approx(miss_ / 2, rel=1e-3)
            assert groups["a"].residual <= tolerance


def test_nearly_concurrent_triples_are_merged_up_to_the_tolerance(tmp_path) -> None:
    for size in (1e-12, 1e-8, 1e-4):
        robot = made_up(tmp_path, J("a", Z), J("b", X, xyz=(0.1, size, 0)), J("c", Y, xyz=(-0.1, 0.2, size)))
        assert len(group_joints(robot, rule="concurrent", tolerance=size)) == 1
        assert len(group_joints(robot, rule="concurrent", tolerance=size / 4)) == 3
        assert len(group_joints(robot, rule="coincident", tolerance=size)) == 3


def test_nearly_parallel_axes_have_no_meeting_point_worth_its_name(tmp_path) -> None:
    for angle, expected in ((1e-7, 2), (1e-5, 1)):
        robot = made_up(tmp_path, J("a", Z), J("b", (math.sin(angle), 0.0, math.cos(angle))))
        assert len(group_joints(robot)) == expected


# --- nothing to merge, and bad input ----------------------------------------------------------------------------------


def test_robots_without_revolutes_or_without_joints_have_nothing_to_merge(tmp_path) -> None:
    sliding = made_up(tmp_path, J("x", X, kind="prismatic"), J("y", Y, kind="prismatic"))
    assert group_joints(sliding).summary == "2 DOF = 2×1"
    nothing = group_joints(made_up(tmp_path))
    assert len(nothing) == 0
    assert nothing.summary == "0 DOF = 0"


def test_joints_without_limits_reach_their_singularity(tmp_path) -> None:
    robot = made_up(tmp_path, *(J(name, axis, kind="continuous") for name, axis in (("a", Z), ("b", X), ("c", Z))))
    singularity = group_joints(robot)["b"].singularity
    assert singularity.margin == -math.inf
    assert singularity.reachable


@pytest.mark.parametrize(
    ("limits", "margin"),
    [
        ((3.3, 6.0), 3.3 - math.pi),
        ((7.0, 8.0), 7.0 - 2 * math.pi),
        ((6.0, 7.0), -(2 * math.pi - 6.0)),
        ((-9.0, -7.0), 3 * math.pi - 9.0),
        ((-1.0, 2.0), -1.0),
    ],
)
def test_the_margin_counts_whole_turns(tmp_path, limits, margin) -> None:
    robot = made_up(tmp_path, J("a", Z), J("b", X, limits=limits), J("c", Z))
    assert group_joints(robot)["b"].singularity.margin == pytest.approx(margin, abs=1e-12)


@for_all("tolerance", [0, 0.011, math.nan])
def test_a_tolerance_that_is_none_is_refused(nao, tolerance) -> None:
    with pytest.raises(BadArgument, match="tolerance"):
        group_joints(nao, tolerance=tolerance)


def test_an_unknown_joint_is_refused_with_the_nearest(nao) -> None:
    with pytest.raises(UnknownName, match="LHipRoll"):
        group_joints(nao)["LHipRol"]
