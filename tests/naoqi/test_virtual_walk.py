"""The walk of the virtual NAO: steps a NAO can make, feet that stand, soles above the floor, targets that are met."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from loops import full
from naoqi_script import Script
from scipy.linalg import expm

from nao_kin.errors import BadArgument, NotFinite, UnknownName
from nao_kin.naoqi.virtual import Call, NaoqiError, VirtualNao
from nao_kin.naoqi.virtual.steps import (
    DEFAULT,
    HIGHEST,
    LOWEST,
    NEAREST,
    Gait,
    along,
    bounded,
    composed,
    first_side,
    foot_beside,
    gait_of,
    move_config,
    period,
    seen_from,
)
from nao_kin.naoqi.virtual.walk import AtVelocity, ToTargets, Walker, WalkPlan

LEGS = ["LLeg", "RLeg"]
poses = st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-3.0, 3.0))
STEPS = ("MaxStepX", "MaxStepY", "MaxStepTheta")
configs = st.fixed_dictionaries({name: st.floats(LOWEST[name], HIGHEST[name]) for name in STEPS})
# Smaller steps reach every target, too, and take long.
LEAST = {"MaxStepX": 0.01, "MaxStepY": 0.12, "MaxStepTheta": 0.02}


class Walking(Script):
    """A script that watches what the feet do."""

    def watch(self, call: Call) -> tuple[float, int, float]:
        """Let time pass until a call is over; return the time, the number of steps and the largest height of the feet.

        In every tick: no sole is below the floor, the foot that stands has not moved, joints are inside their limits
        and not faster than they can be, and where they are commanded to be.
        """
        begin, steps, highest = self.nao.clock.now, 0, 0.0
        before, standing, joints = self.feet(), self.nao.base.support, self.nao.joints.sensor
        while not call.done():
            self.nao.step(0.01)
            feet, q = self.feet(), self.nao.joints.q()
            assert feet[:, 2, 3].min() > -1e-6
            assert np.abs(feet[:, 2, :3] - [0.0, 0.0, 1.0]).max() < 1e-6
            steps += standing != self.nao.base.support
            if standing == self.nao.base.support:
                assert np.abs(feet - before)[LEGS.index(standing)].max() < 1e-6
            assert self.nao.robot.within_limits(q).all()
            assert (np.abs(self.nao.joints.sensor - joints) <= self.nao.joints.max_speed * 0.01 * (1 + 1e-9)).all()
            assert np.abs(self.nao.joints.sensor - self.nao.joints.command).max() < 1e-9
            highest = max(highest, feet[:, 2, 3].max())
            before, standing, joints = feet, self.nao.base.support, self.nao.joints.sensor
        call.result()
        return self.nao.clock.now - begin, steps, highest


@pytest.fixture
def script() -> Iterator[Walking]:
    with Walking() as made:
        yield made


def off(found: np.ndarray, expected: np.ndarray) -> float:
    return float(np.abs(seen_from(expected, found)).max())


# --- poses on the floor -----------------------------------------------------------------------------------------------


@given(poses, poses)
def test_seen_from_takes_back_what_composed_does(a: tuple, b: tuple) -> None:
    assert np.abs(seen_from(a, composed(a, b)) - b).max() < 1e-12
    assert composed((1.0, 2.0, np.pi / 2), (0.3, 0.1, 0.2)) == pytest.approx([0.9, 2.3, np.pi / 2 + 0.2], abs=1e-12)


@given(poses, poses)
def test_between_two_poses_the_way_is_straight_and_the_turn_short(a: tuple, b: tuple) -> None:
    start, goal = np.array(a), np.array(b)
    half = along(start, goal, 0.5)
    assert np.abs(half[:2] - 0.5 * (start + goal)[:2]).max() < 1e-12
    assert abs(half[2] - start[2]) <= np.pi / 2 + 1e-12
    assert off(along(start, goal, 1.0), goal) < 1e-12


@pytest.mark.parametrize(
    ("motion", "side"), [((1, 0, 0), "L"), ((0, -1, 0), "R"), ((0, 0, -1), "R"), ((0, 1, -1), "L")]
)
def test_the_foot_that_opens_goes_first(motion: tuple, side: str) -> None:
    assert first_side(motion) == side


@given(poses, st.sampled_from("LR"), configs)
def test_steps_are_brought_into_what_a_foot_can_do(step: tuple, side: str, config: dict) -> None:
    gait = gait_of(config)[side]
    x, y, theta = bounded(step, side, gait)
    outwards = 1.0 if side == "L" else -1.0
    assert abs(x) <= gait["MaxStepX"]
    assert NEAREST <= outwards * y <= gait["MaxStepY"]
    assert -0.12 <= outwards * theta <= gait["MaxStepTheta"]


def _walked(plan: WalkPlan, gait: Gait, most: int = 3000) -> tuple[list[Any], Walker]:
    """The steps of a plan from the origin, each within what its foot can do."""
    walker = Walker({side: foot_beside(np.zeros(3), side) for side in "LR"}, np.zeros(3))
    plan.begin(walker.body)
    steps = []
    while (step := plan.step(walker)) is not None and len(steps) < most:
        relative = seen_from(step.support, step.end)
        assert np.abs(bounded(relative, step.side, gait[step.side]) - relative).max() < 1e-9
        assert not steps or steps[-1].side != step.side
        walker.feet[step.side] = step.end
        steps.append(step)
    return steps, walker


@pytest.mark.full
@given(poses, configs)
@settings(max_examples=60, deadline=None)
def test_every_target_is_met_exactly_by_steps_within_bounds(target: tuple, config: dict) -> None:
    gait = gait_of({name: max(value, LEAST[name]) for name, value in config.items()})
    _, walker = _walked(ToTargets([np.array(target)], gait), gait)
    for side, foot in walker.feet.items():
        assert off(foot, foot_beside(target, side)) < 2e-6


# --- the move configuration -------------------------------------------------------------------------------------------


def test_the_default_configuration_is_the_documented_one() -> None:
    assert move_config("Default") == [
        ["MaxStepX", 0.04],
        ["MaxStepY", 0.14],
        ["MaxStepTheta", 0.349],
        ["MaxStepFrequency", 1.0],
        ["StepHeight", 0.02],
        ["TorsoWx", 0.0],
        ["TorsoWy", 0.0],
    ]
    assert gait_of(move_config("Default")) == gait_of([]) == {"L": DEFAULT, "R": DEFAULT}
    assert period(DEFAULT) == pytest.approx(0.42)
    assert period(gait_of([["Frequency", 0.0]])["L"]) == pytest.approx(0.6)
    # 9.5 cm/s, as the NAO is said to walk.
    assert DEFAULT["MaxStepX"] / period(DEFAULT) == pytest.approx(0.0952, abs=1e-4)


def test_numbers_outside_of_their_range_are_brought_into_it_and_sides_kept_apart() -> None:
    gait = gait_of([["MaxStepX", 9.0], ["LeftStepHeight", 0.03], ["RightStepHeight", -1.0]])
    assert gait["L"]["MaxStepX"] == gait["R"]["MaxStepX"] == 0.08
    assert (gait["L"]["StepHeight"], gait["R"]["StepHeight"]) == (0.03, 0.005)


def test_configurations_that_make_no_sense_are_refused() -> None:
    with pytest.raises(UnknownName, match="nearest: MaxStepX"):
        gait_of([["maxstepx", 0.04]])
    for wrong in ("MaxStepX", [["MaxStepX"]], [["MaxStepX", "fast"]], [["MaxStepX", float("nan")]], 3, ["MaxStepX", 1]):
        with pytest.raises((BadArgument, NotFinite)):
            gait_of(wrong)
    with pytest.raises(UnknownName, match="move configuration"):
        move_config("Fast")


# --- walking ----------------------------------------------------------------------------------------------------------


FAR = [(0.3, 0.0, 0.0), (0.0, 0.15, 0.0), (0.0, 0.0, 3.1)]


@pytest.mark.parametrize(
    "target",
    [(-0.12, 0.0, 0.0), (0.0, -0.1, -1.2), (0.2, 0.1, 0.6), *full(*((target,) for target in FAR))],
)
def test_a_walk_ends_at_its_target_on_feet_that_never_slip(script: Walking, target: tuple) -> None:
    script("moveInit")
    start = script.place()
    time, steps, highest = script.watch(script.nao.post("ALMotion", "moveTo", *target))
    assert off(script.place(), composed(start, target)) < 1e-6
    assert highest == pytest.approx(0.02, abs=1e-3)
    assert steps >= 2
    # No joint is too fast for the documented step of 0.42 s.
    assert time / 0.42 == pytest.approx(round(time / 0.42), abs=1e-6)
    left, right = (seen_from(script.place(), _floor(T)) for T in script.feet())
    assert left == pytest.approx([0.0, 0.05, 0.0], abs=1e-6)
    assert right == pytest.approx([0.0, -0.05, 0.0], abs=1e-6)


def _floor(T: np.ndarray) -> np.ndarray:
    return np.array([T[0, 3], T[1, 3], np.arctan2(T[1, 0], T[0, 0])])


def test_a_walk_obeys_its_configuration(script: Walking) -> None:
    script("moveInit")
    config = [["MaxStepX", 0.02], ["StepHeight", 0.03], ["MaxStepFrequency", 0.0]]
    call = script.nao.post("ALMotion", "moveTo", 0.1, 0.0, 0.0, config)
    time, _, highest = script.watch(call)
    # Five steps forwards by 2 cm each, and one that closes up, each 0.6 s.
    assert time == pytest.approx(6 * 0.6, abs=1e-9)
    assert highest == pytest.approx(0.03, abs=1e-3)
    assert script("getTaskList") == []


def test_both_feet_are_on_the_floor_for_a_third_of_a_step(script: Walking) -> None:
    script("moveInit")
    call = script.nao.post("ALMotion", "moveTo", 0.2, 0.0, 0.0)
    heights = []
    while not call.done():
        script.nao.step(0.01)
        heights.append(script.feet()[:, 2, 3].max())
    first = np.array(heights[:42])
    # The swing begins after a sixth of 0.42 s and ends a sixth before its end.
    assert (first[:7] < 1e-9).all()
    assert (first[7:34] > 0.0).all()
    assert (first[35:] < 1e-9).all()


def test_joints_that_would_be_too_fast_make_a_step_longer(script: Walking) -> None:
    script("moveInit")
    start = script.place()
    call = script.nao.post("ALMotion", "moveTo", 0.3, 0.0, 0.0, [["MaxStepX", 0.08], ["StepHeight", 0.04]])
    time, _, _ = script.watch(call)
    assert time / 0.42 > 5.1
    assert off(script.place(), composed(start, (0.3, 0.0, 0.0))) < 1e-6


def test_several_targets_are_walked_to_in_turn(script: Walking) -> None:
    start = script.place()
    script("moveTo", [[0.1, 0.0, 0.5 * np.pi], [0.05, 0.0, 0.0], [0.0, 0.03, -0.3]], [["StepHeight", 0.01]])
    # Each from the one before: 0.1 m ahead, a quarter turn, 0.05 m that way, and 0.03 m to the left of that, backwards.
    assert off(script.place(), composed(start, (0.07, 0.05, 0.5 * np.pi - 0.3))) < 1e-6


@pytest.mark.parametrize("posture", ["Stand", "StandZero", "Crouch"])
def test_a_walk_begins_in_every_posture_on_feet(posture: str) -> None:
    script = Script(posture)
    start = script.place()
    script("moveTo", 0.1, 0.02, -0.2)
    assert off(script.place(), composed(start, (0.1, 0.02, -0.2))) < 1e-6
    script.nao.close()


def test_a_robot_that_sits_does_not_walk() -> None:
    script = Script("Sit")
    for name, *rest in (("moveTo", 0.1, 0, 0), ("moveInit",), ("move", 0.1, 0, 0)):
        with pytest.raises(NaoqiError, match="does not stand"):
            script(name, *rest)
    script.nao.close()


def test_move_init_brings_a_level_torso_to_walking_height(script: Walking) -> None:
    feet = script.feet()
    script.watch(script.nao.post("ALMotion", "moveInit"))
    six = np.array(script("getPosition", "Torso", 2, True))
    height = -script.nao.robot.fk(script.nao.robot.posture("StandInit"), "LLeg")[2, 3]
    assert six[:5] == pytest.approx([0.0, 0.0, height, 0.0, 0.0], abs=1e-9)
    assert np.abs(script.feet() - feet).max() < 1e-9


# --- velocities -------------------------------------------------------------------------------------------------------


VELOCITIES = [(0.08, 0.0, 0.0), (0.05, 0.0, 0.3), *full(((-0.05, 0.0, 0.0),), ((0.0, 0.03, 0.0),))]


@pytest.mark.parametrize("velocity", VELOCITIES)
def test_a_velocity_is_kept_and_changed_after_a_step(script: Walking, velocity: tuple) -> None:
    script("moveInit")
    start, begin = script.place(), script.nao.clock.now
    script("move", *velocity)
    assert script("moveIsActive")
    script.nao.step(20 * 0.42)
    elapsed = script.nao.clock.now - begin
    expected = np.zeros(3)
    for _ in range(1000):  # along an arc
        expected = composed(expected, np.array(velocity) * elapsed / 1000)
    step = 0.42 * np.abs(velocity).sum()
    assert off(script.place(), composed(start, expected)) < 1.5 * step
    script("move", 0.0, 0.0, 0.0)
    script.watch(script.nao.post("ALMotion", "waitUntilMoveIsFinished"))
    assert not script("moveIsActive")
    assert script("getRobotVelocity") == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("velocity", [(0.04, 0.0, 0.2), (-0.03, 0.01, 0.1), (0.05, 0.0, 0.0)])
def test_a_walk_at_a_velocity_follows_the_arc(velocity: tuple) -> None:
    plan, gait = AtVelocity(np.array(velocity), gait_of([])), gait_of([])
    walker = Walker({side: foot_beside(np.zeros(3), side) for side in "LR"}, np.zeros(3))
    plan.begin(walker.body)
    x, y, turn = velocity
    generator = np.array([[0.0, -turn, x], [turn, 0.0, y], [0.0, 0.0, 0.0]])
    time = 0.0
    for _ in range(16):
        step = plan.step(walker)
        assert step is not None
        walker.feet[step.side] = step.end
        time += period(gait["L"])
        exact = expm(time * generator)
        assert walker.body == pytest.approx([exact[0, 2], exact[1, 2], turn * time], abs=1e-9)


def test_full_speed_forwards_is_a_step_each_time(script: Walking) -> None:
    script("moveInit")
    script("moveToward", 1.0, 0.0, 0.0)
    script.nao.step(4 * 0.42)
    assert script("getRobotVelocity") == pytest.approx([0.04 / 0.42, 0.0, 0.0], abs=1e-9)
    before = script.place()
    script.nao.step(2 * 0.42)
    assert seen_from(before, script.place()) == pytest.approx([0.08, 0.0, 0.0], abs=1e-9)


def test_stop_puts_the_feet_side_by_side(script: Walking) -> None:
    script("moveToward", 0.5, 0.2, 0.2, [["Frequency", 0.5]])
    script.nao.step(3.0)
    script.watch(script.nao.post("ALMotion", "stopMove"))
    left, right = (seen_from(script.place(), _floor(T)) for T in script.feet())
    assert left == pytest.approx([0.0, 0.05, 0.0], abs=1e-6)
    assert right == pytest.approx([0.0, -0.05, 0.0], abs=1e-6)
    script("stopMove")  # and again, where nothing moves


def test_a_later_target_takes_the_walk_over(script: Walking) -> None:
    script("moveInit")
    script("move", 0.05, 0.0, 0.0)
    script.nao.step(1.0)
    first = script.nao.post("ALMotion", "waitUntilMoveIsFinished")
    next_place = np.array(script("getNextRobotPosition"))
    script.watch(script.nao.post("ALMotion", "moveTo", 0.1, 0.0, 0.5))
    assert first.done()
    # From where the body was to be after the step that was under way: the next stance, half a step on.
    assert np.linalg.norm(seen_from(next_place, script.place())[:2]) == pytest.approx(0.1, abs=0.03)
    assert seen_from(next_place, script.place())[2] == pytest.approx(0.5, abs=1e-6)


def test_a_killed_walk_stops_in_the_middle_of_a_step(script: Walking) -> None:
    call = script.nao.post("ALMotion", "moveTo", 0.3, 0.0, 0.0)
    script.nao.step(1.2)
    script("killMove")
    script.nao.step(0.01)
    assert call.done()
    assert not script("moveIsActive")
    joints = script.nao.joints.sensor
    script.nao.step(0.5)
    assert np.array_equal(script.nao.joints.sensor, joints)


def test_joints_of_the_legs_wait_for_the_walk_and_those_of_the_arms_do_not(script: Walking) -> None:
    script.nao.post("ALMotion", "moveTo", 0.2, 0.0, 0.0)
    arm = script.nao.post("ALMotion", "angleInterpolation", "LShoulderPitch", 1.0, 0.5, True)
    leg = script.nao.post("ALMotion", "angleInterpolation", "LKneePitch", 0.8, 0.5, True)
    script.nao.step(1.0)
    assert arm.done()
    assert not leg.done()
    script("waitUntilMoveIsFinished")
    script.nao.step(0.6)
    assert leg.done()


# --- footsteps --------------------------------------------------------------------------------------------------------


def test_footsteps_are_made_as_given(script: Walking) -> None:
    script("moveInit")
    steps = [[0.03, 0.11, 0.1], [0.02, -0.1, -0.05]]
    call = script.nao.post("ALMotion", "setFootStepsWithSpeed", ["LLeg", "RLeg"], steps, [1.0, 0.5], False)
    script.nao.step(0.1)
    now, made, coming = script("getFootSteps")
    assert len(now) == 2
    assert made[0][0] == "LLeg"
    assert made[0][2] == pytest.approx(steps[0], abs=1e-9)
    assert coming[0][0] == "RLeg"
    time, _, _ = script.watch(call)
    assert time == pytest.approx(0.42 + 0.84 - 0.1, abs=1e-9)
    left, right = (_floor(T) for T in script.feet())
    assert seen_from(left, right) == pytest.approx(steps[1], abs=1e-6)


def test_footsteps_take_the_time_they_are_given_and_no_less_than_a_step_needs(script: Walking) -> None:
    script("moveInit")
    script("setFootSteps", ["LLeg", "RLeg"], [[0.02, 0.1, 0.0], [0.02, -0.1, 0.0]], [0.8, 0.9], True)
    time, _, _ = script.watch(script.nao.post("ALMotion", "waitUntilMoveIsFinished"))
    assert time == pytest.approx(0.8 + 0.42, abs=1e-9)


# Aldebaran documentation 2.1, locomotion control: "Footsteps clipping" gives the extremal values of a step.
@pytest.mark.parametrize(
    ("given", "made", "clipped"),
    [
        ((0.06, 0.1, 0.0), (0.06, 0.1, 0.0), False),
        ((-0.08, 0.16, 0.524), (-0.08, 0.16, 0.524), False),
        ((0.2, 0.3, 0.9), (0.08, 0.16, 0.524), True),
    ],
)
def test_footsteps_are_clipped_to_the_documented_extremes_and_told_as_they_are_made(
    script: Walking, given: tuple, made: tuple, clipped: bool
) -> None:
    script("moveInit")
    begun = [[0.0, -0.1, 0.0], list(given)]
    script("setFootSteps", ["RLeg", "LLeg"], begun, [0.6, 1.2], False)
    script.nao.step(0.1)
    _, _, coming = script("getFootSteps")
    assert coming[0][2] == pytest.approx(made, abs=1e-9)
    script.watch(script.nao.post("ALMotion", "waitUntilMoveIsFinished"))
    left, right = (_floor(T) for T in script.feet())
    assert seen_from(right, left) == pytest.approx(made, abs=1e-6)
    lines = [line for _, line in script.nao.log.lines if "is clipped to" in line]
    expected = "setFootSteps: LLeg [0.2, 0.3, 0.9] is clipped to [0.08, 0.16, 0.524]"
    assert lines == ([expected] if clipped else [])


def test_values_of_a_move_configuration_that_are_clipped_are_logged(script: Walking) -> None:
    config = [["MaxStepX", 0.2], ["MaxStepFrequency", 5.0], ["LeftStepHeight", 0.5], ["MaxStepY", 0.14]]
    script.nao.post("ALMotion", "moveTo", 0.02, 0.0, 0.0, config)
    assert [line for _, line in script.nao.log.lines] == [
        "moveTo: MaxStepX = 0.2 is clipped to 0.08",
        "moveTo: MaxStepFrequency = 5 is clipped to 1",
        "moveTo: LeftStepHeight = 0.5 is clipped to 0.04",
    ]


# --- what is kept, and errors -----------------------------------------------------------------------------------------


def test_arms_are_remembered(script: Walking) -> None:
    assert script("getMoveArmsEnabled", "Arms")
    script("setMoveArmsEnabled", True, False)
    assert [script("getMoveArmsEnabled", arm) for arm in ("LArm", "RArm", "Arms")] == [True, False, False]
    assert script("getWalkArmsEnabled") == [True, False]


def test_names_of_old_do_the_same(script: Walking) -> None:
    script("walkInit")
    start = script.place()
    script("walkTo", 0.05, 0.0, 0.0)
    assert off(script.place(), composed(start, (0.05, 0.0, 0.0))) < 1e-6
    script("setWalkTargetVelocity", 0.5, 0.0, 0.0, 0.5, [["StepHeight", 0.03]], [["StepHeight", 0.01]])
    assert script("walkIsActive")
    heights = []
    for _ in range(30):
        script.nao.step(0.05)
        heights.append(script.feet()[:, 2, 3])
    assert np.max(heights, axis=0) == pytest.approx([0.03, 0.01], abs=2e-3)
    script("stopWalk")
    script("waitUntilWalkIsFinished")
    assert not script("walkIsActive")


def test_a_velocity_that_stands_still_makes_no_step() -> None:
    steps, _ = _walked(AtVelocity(np.zeros(3), gait_of([])), gait_of([]))
    assert steps == []


# --- answers ----------------------------------------------------------------------------------------------------------


def test_a_walk_that_arrives_is_true(script: Walking) -> None:
    assert script("moveTo", 0.05, 0.0, 0.0) is True
    assert script("walkTo", [[0.02, 0.0, 0.0], [0.0, 0.0, 0.1]]) is True
    assert script("moveTo", 0.0, 0.0, 0.0) is True
    assert script("moveInit") is None
    assert script("waitUntilMoveIsFinished") is None


@pytest.mark.parametrize("interrupt", ["stopMove", "stopWalk", "killMove", "killAll"])
def test_a_walk_that_is_interrupted_is_false(script: Walking, interrupt: str) -> None:
    walk = script.nao.post("ALMotion", "moveTo", 0.3, 0.0, 0.0)
    script.nao.step(1.2)
    answer = script(interrupt)
    assert answer is (True if interrupt.startswith("stop") else None)
    script.nao.step(0.01)
    assert walk.result(0) is False


def test_a_walk_that_is_taken_over_is_false_and_the_one_that_takes_it_over_is_true(script: Walking) -> None:
    first = script.nao.post("ALMotion", "moveTo", 0.3, 0.0, 0.0)
    script.nao.step(1.2)
    assert script("moveTo", 0.05, 0.0, 0.0) is True
    assert first.result(0) is False


def test_a_walk_on_limp_legs_is_false() -> None:
    with VirtualNao(stepped=True, posture="StandInit") as nao:
        assert nao.call("ALMotion", "moveTo", 0.05, 0.0, 0.0) is False


def test_a_killed_walk_has_no_velocity(script: Walking) -> None:
    script("move", 0.05, 0.0, 0.0)
    script.nao.step(2.0)
    assert script("getRobotVelocity")[0] > 0.0
    ((_, number),) = script("getTaskList")
    assert script("killTask", number) is True
    assert script("getRobotVelocity") == [0.0, 0.0, 0.0]
    assert script("killTask", number) is False
