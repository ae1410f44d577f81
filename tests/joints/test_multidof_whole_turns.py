"""Joints that turn more than once, and followers that ride on carriers: what a typed configuration must not lose."""

from __future__ import annotations

import numpy as np
import pytest
from made_up_robots import J, made_up
from test_multidof_model import composite_mass_matrix, inverse_dynamics_mass_matrix, mass_matrix

import nao_kin as nk
from nao_kin.errors import DisagreeingJoints
from nao_kin.joints import MultiDofModel

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
AWAY = (0.2, 0.0, 0.0)
BALL = [J("j0", Z, limits=(-6.28, 6.28)), J("j1", X, limits=(-1.4, 1.4)), J("j2", Y, limits=(-1.4, 1.4))]


def differences(robot: nk.RobotModel, typed: MultiDofModel, q: np.ndarray) -> tuple[float, float]:
    """Return the largest difference of to_q(from_q(q)) from q, and of its poses from those of q."""
    back = typed.to_q(typed.from_q(q))
    names = robot.frame_names
    return float(np.abs(back - q).max()), float(np.abs(robot.fk(back, names) - robot.fk(q, names)).max())


def test_the_driver_of_a_half_speed_follower_keeps_its_whole_turns(tmp_path) -> None:
    robot = made_up(tmp_path, *BALL, J("j3", Z, AWAY, follows=("j0", 0.5, 0.0), limits=(-9, 9)), J("j4", Z, AWAY))
    typed = MultiDofModel(robot)
    q = np.array([4.0, 0.3, 0.2, 0.1])
    assert max(differences(robot, typed, q)) < 1e-13
    assert typed.violations(typed.from_q(q)) == ()
    # The ball alone says as well 4 − 2π, with which the follower is half a turn off.
    assert typed.to_q(typed.from_q(q), couplings="nearest")[0] == pytest.approx(4.0, abs=1e-13)


def test_a_carrier_that_knows_the_angle_decides_the_whole_turn(tmp_path) -> None:
    robot = made_up(tmp_path, *BALL, J("j4", Z, AWAY))
    typed = MultiDofModel(robot)
    q = robot.random(1, 500)
    assert np.abs(q[:, 0]).max() > 6.0
    assert differences(robot, typed, q)[0] < 1e-12


@pytest.mark.parametrize("value", [0.0, 400.0])
def test_a_carrier_that_nobody_has_set_leaves_the_joint_inside_its_limits(tmp_path, value) -> None:
    robot = made_up(tmp_path, *BALL, J("j4", Z, AWAY))
    typed = MultiDofModel(robot)
    q = robot.random(1, 200)
    q_typed = typed.from_q(q)
    q_typed[:, typed.columns["j0"]] = value
    back = typed.to_q(q_typed)
    assert np.all((back >= robot.lower - 1e-9) & (back <= robot.upper + 1e-9))
    assert np.allclose(robot.fk(back, "j4_l"), robot.fk(q, "j4_l"), rtol=0, atol=1e-13)


def test_a_carrier_just_outside_the_limits_is_not_followed_there(tmp_path) -> None:
    first = J("j0", Z, limits=(0.0, 2 * np.pi + 5e-4))
    typed = MultiDofModel(made_up(tmp_path, first, *BALL[1:]))
    q_typed = typed.from_q([8e-4, 0.3, 0.2])
    q_typed[typed.columns["j0"]] += 2 * np.pi
    assert typed.to_q(q_typed)[0] == pytest.approx(8e-4, abs=1e-13)


@pytest.mark.parametrize("lower", [-np.pi, 0.1, -0.7])
@pytest.mark.parametrize("short", [0.0, 1e-9])
def test_a_joint_of_exactly_one_turn_stays_at_either_end(tmp_path, lower, short) -> None:
    ends = lower, lower + 2 * np.pi - short
    typed = MultiDofModel(made_up(tmp_path, J("j0", Z, limits=ends), *BALL[1:]))
    for others in np.random.default_rng(1).uniform(-1.3, 1.3, (20, 2)):
        for end in ends:
            q = np.array([end, *others])
            assert np.allclose(typed.to_q(typed.from_q(q)), q, rtol=0, atol=1e-13)


def test_a_joint_without_limits_stands_where_its_carrier_says(tmp_path) -> None:
    robot = made_up(tmp_path, *(J(name, axis, kind="continuous") for name, axis in (("a", Z), ("b", X), ("c", Y))))
    typed = MultiDofModel(robot)
    back = typed.to_q(typed.from_q([40.0, 0.2, 1.5 + 4 * np.pi]))
    assert np.allclose(back, [40.0, 0.2, 1.5], rtol=0, atol=1e-13)


@pytest.mark.parametrize("name", ["anymal-kinova", "kinova"])
def test_published_arms_of_several_turns_come_back(name) -> None:
    robot = nk.load_robot(name)
    for rule in ("coincident", "concurrent"):
        typed = MultiDofModel(robot, rule=rule)
        last = {joint.joints[-1] for joint in typed.pairs if joint.pair.name == "spherical"}
        known = [i for i, name in enumerate(robot.joint_names) if name not in last]
        q = robot.random(1, 300)
        back = typed.to_q(typed.from_q(q))
        # The file's axes are perpendicular to 1e-10 only, and so is what a ball of them holds.
        assert np.allclose(back[:, known], q[:, known], rtol=0, atol=1e-9)
        assert np.allclose(robot.fk(back), robot.fk(q), rtol=0, atol=1e-9)


def follower_of_a_ball(tmp_path, parent: str) -> MultiDofModel:
    first = J("j0", Z, limits=(-1.0, 1.0))
    follower = J("j3", Z, AWAY, parent=parent, follows=("j0", 1.0, 0.0))
    return MultiDofModel(made_up(tmp_path, first, *BALL[1:], follower, J("j4", Z, AWAY)))


@pytest.mark.parametrize(("parent", "says"), [("j2", "j3"), ("base", "j0")])
def test_a_follower_that_disagrees_with_the_ball_it_follows_is_refused(tmp_path, parent, says) -> None:
    # Behind the ball it has a coordinate of its own, on another limb it mimics the carrier.
    typed = follower_of_a_ball(tmp_path, parent)
    q_typed = typed.from_q([0.3, 0.3, 0.2, 0.1])
    assert typed.violations(q_typed) == ()
    q_typed[typed.columns[says]] += 0.7
    with pytest.raises(DisagreeingJoints) as caught:
        typed.to_q(q_typed)
    assert (caught.value.primary, caught.value.mimic) == ("j0", "j3")
    assert caught.value.primary_value == pytest.approx(0.3, abs=1e-14)
    assert caught.value.mimic_value == pytest.approx(1.0, abs=1e-14)
    assert typed.to_q(q_typed, couplings="nearest")[0] == pytest.approx(0.65, abs=1e-14)


def test_a_sliding_follower_is_not_compared_by_whole_turns(tmp_path) -> None:
    robot = made_up(tmp_path, *BALL, J("s", Z, AWAY, kind="prismatic", follows=("j2", 3.0, 0.0), limits=(-50, 50)))
    typed = MultiDofModel(robot)
    q_typed = typed.from_q([0.3, 0.3, 0.2])
    q_typed[typed.columns["s"]] += 2 * np.pi
    assert len(typed.violations(q_typed)) == 1


BEHIND = [J("j3", Z, (0.1, 0.0, 0.0), follows=("j0", 2.0, 0.0))]
BALL_BEHIND = [J("j1", X, AWAY, follows=("j0", 2.0, 0.0)), J("j2", Y), J("j3", Z)]
BETWEEN = {
    "driver before a universal": [J("j0", Z), J("j1", X, AWAY), J("j2", Y), *BEHIND],
    "driver before a ball": [J("j0", Z), J("j1", X, AWAY), J("j2", Y), J("j2b", X), *BEHIND],
    "driver on another limb": [J("j0", Z), J("j1", X, AWAY, parent="base"), J("j2", Y), *BEHIND],
    "carriers behind a follower": [J("j0", Z), J("f", Y, AWAY, follows=("j0", 0.5, 0.0)), *BALL_BEHIND],
    "a branching follower": [J("j0", Z), J("f", Y, AWAY, follows=("j0", 0.5, 0.0)), J("a", X), J("b", Z, parent="f")],
    "driver in a universal elsewhere": [J("m", X), J("j0", Z), J("j1", X, AWAY, parent="base"), J("j2", Y), *BEHIND],
}


@pytest.mark.parametrize("name", BETWEEN)
def test_the_mass_matrix_is_right_where_pinocchios_mimic_joints_would_mislead_it(tmp_path, name) -> None:
    robot = made_up(tmp_path, *BETWEEN[name], base="floating")
    typed = MultiDofModel(robot)
    for q in robot.random(1, (5,)):
        E, expected = typed.velocity_matrix(q), mass_matrix(robot.model, q)
        for algorithm in (mass_matrix, composite_mass_matrix, inverse_dynamics_mass_matrix):
            M = E.T @ algorithm(typed.model, typed.from_q(q)) @ E
            assert np.allclose(M, expected, rtol=0, atol=1e-12), algorithm.__name__


@pytest.mark.parametrize("lean", [0.0, 0.5e-9, 1.01e-9, 1e-3])
def test_whatever_is_merged_to_a_ball_can_be_taken_apart(tmp_path, lean) -> None:
    rng = np.random.default_rng(1)
    balls = 0
    for _ in range(8):
        turn = rng.normal(size=3)
        a, b, c = np.linalg.qr(rng.normal(size=(3, 3)))[0].T
        axes = (a, b, c + lean * b) if rng.random() < 0.5 else (a + lean * b, b, c)
        robot = made_up(
            tmp_path,
            J("root", Z, rpy=tuple(turn)),
            *(J(f"j{i}", tuple(v), AWAY if not i else (0, 0, 0)) for i, v in enumerate(axes)),
        )
        typed = MultiDofModel(robot)
        q = robot.random(1)
        assert np.allclose(typed.to_q(typed.from_q(q)), q, rtol=0, atol=1e-7)
        balls += any(joint.pair.name == "spherical" for joint in typed.pairs)
    # Above 0.9e-9 no turns about these axes reach every rotation.
    assert balls == (8 if lean < 0.9e-9 else 0)


@pytest.mark.parametrize("intermediate", ["keep", "drop"])
def test_two_balls_of_one_motor_find_the_turn_that_both_know(tmp_path, intermediate) -> None:
    # Nothing but the two rotations says how many turns the motor has made.
    first = [J("j0", Z, limits=(-1.4, 1.4)), J("j1", X, limits=(-1.4, 1.4)), J("j2", Y, limits=(-20.0, 20.0))]
    follower = J("j5", Y, follows=("j2", 0.3, 0.0), limits=(-7.0, 7.0))
    second = [J("j3", Z, AWAY, limits=(-1.4, 1.4)), J("j4", X, limits=(-1.4, 1.4)), follower]
    robot = made_up(tmp_path, *first, *second, J("tip", Z, AWAY))
    typed = MultiDofModel(robot, intermediate=intermediate)
    assert [joint.pair.name for joint in typed.pairs] == ["spherical", "spherical", "revolute"]
    q = robot.random(1, 300)
    assert np.abs(q[:, 2]).max() > 19.0
    assert np.allclose(typed.to_q(typed.from_q(q)), q, rtol=0, atol=1e-11)


# --- locks without carriers -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("last", [Z, (0.0, 0.0, -1.0)])
def test_at_a_lock_the_outer_angles_stay_inside_unequal_limits(tmp_path, last) -> None:
    joints = [J("a", Z, limits=(-0.2, 0.2)), J("b", X, limits=(-1.0, 1.0)), J("c", last, limits=(-2.0, 2.0))]
    robot = made_up(tmp_path, *joints)
    typed = MultiDofModel(robot, intermediate="drop")
    for first, third in ((0.1, 1.9), (-0.2, -1.5), (0.0, 1.99), (0.15, -1.7)):
        q = np.array([first, 0.0, third])
        back = typed.to_q(typed.from_q(q))
        assert np.all((back >= robot.lower - 1e-9) & (back <= robot.upper + 1e-9))
        assert np.allclose(robot.fk(back, "c_l"), robot.fk(q, "c_l"), rtol=0, atol=1e-14)
    # No pair of angles inside the limits makes this sum; both are then outside by as much.
    back = typed.to_q(typed.from_q([0.6, 0.0, 2.0 * last[2]]))
    assert back == pytest.approx([0.4, 0.0, 2.2 * last[2]], abs=1e-14)


def three_balls(tmp_path, first: J, second: J, third: J) -> MultiDofModel:
    """Three balls of joints about z, x and z, locked where the middle angle is zero."""
    balls = [[joint, J(f"{joint.name}m", X), J(f"{joint.name}o", Z)] for joint in (first, second, third)]
    return MultiDofModel(
        made_up(tmp_path, *(joint for ball in balls for joint in ball), J("tip", X, AWAY)), intermediate="drop"
    )


def test_a_locked_ball_passes_on_what_it_learns_from_another_motor(tmp_path) -> None:
    # c's rotation gives the last angle of a, with it the first one, and that the first of b.
    typed = three_balls(
        tmp_path, J("a", Z), J("b", Z, AWAY, follows=("a", 1.0, 0.0)), J("c", Z, AWAY, follows=("ao", 1.0, 0.0))
    )
    q = typed.robot.configuration({"a": 0.7, "am": 0.0, "ao": -0.4, "bm": 0.0, "bo": 0.9, "cm": 0.5, "co": 0.3})
    assert np.allclose(typed.to_q(typed.from_q(q)), q, rtol=0, atol=1e-13)


def test_a_locked_ball_that_has_learnt_one_angle_from_a_motor_is_free_no_more(tmp_path) -> None:
    # a gives the first angle of b, and so the last one; c disagrees.
    typed = three_balls(
        tmp_path, J("a", Z), J("b", Z, AWAY, follows=("a", 1.0, 0.0)), J("c", Z, AWAY, follows=("bo", 1.0, 0.0))
    )
    names = {"a": 0.7, "am": 0.5, "ao": -0.4, "bm": 0.0, "bo": 0.9, "cm": 0.5, "co": 0.3}
    q_typed = typed.from_q(typed.robot.configuration(names))
    assert typed.violations(q_typed) == ()
    other = typed.from_q(typed.robot.configuration({**names, "bo": 1.2}))
    column = typed.columns["c+cm+co"]
    q_typed[column] = other[column]
    (row,) = typed.violations(q_typed)
    assert (row.primary, row.mimic) == ("bo", "c")
    assert (row.primary_value, row.mimic_value) == (pytest.approx(0.9, abs=1e-13), pytest.approx(1.2, abs=1e-13))
