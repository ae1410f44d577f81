from __future__ import annotations

import itertools
import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, strategies as st
from ik_checks import BESIDE, Floats, assert_solved, distance_to_solutions, pose_errors
from loops import for_all, full
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin.errors import BadArgument, MissingExtra, NotARotation, OutsideLimits, UnknownName, WrongShape
from nao_kin.ik import Family, IKResult, Reason, analytic
from nao_kin.ik.least_squares import descended
from nao_kin.rotations import exp, rot_x

pytest.importorskip("eaik")

SIDES = ("L", "R")
LIMITS = ("enforce", "ignore")


def assert_same_branches(found: IKResult, wanted: IKResult, closeness: float = 1e-7) -> None:
    """Check that both results have the same branches up to whole turns, for targets without families of solutions."""
    turn = 2.0 * math.pi
    for one, other in ((found, wanted), (wanted, found)):
        for index in np.ndindex(*one.count.shape):
            apart = one.branches[index][:, None] - other.branches[index][None]
            apart = apart - turn * np.round(apart / turn)
            nearest = np.nanmin(np.abs(apart).max(axis=-1), axis=1, initial=math.inf)[: one.count[index]]
            assert nearest.max(initial=0.0) < closeness, (index, one.count[index], other.count[index], nearest)


def at_limits(nao: nk.NaoModel, side: str, n: int) -> Floats:
    """Configurations with some joint of a leg at a limit, its own or the coupled one."""
    rng = np.random.default_rng(2)
    q = nao.random(rng, n)
    columns = [nao.joint_names.index(name) for name in nao.joint_names if name.startswith((side, "LHipYaw"))][:6]
    for row in q:
        column = rng.choice(columns)
        row[column] = rng.choice([nao.lower[column], nao.upper[column]])
    return nao.clamp(q)


# --- The legs of a NAO, by its own closed form ----------------------------------------------------------------------


@for_all("limits", LIMITS)
@for_all("side", SIDES)
def test_on_a_nao_the_branches_of_a_leg_are_those_of_its_closed_form(
    each_nao: nk.NaoModel, side: str, limits: Any
) -> None:
    q = np.concatenate([each_nao.random(7, 400), at_limits(each_nao, side, 200)])
    T = each_nao.fk(q, side + "Leg")
    found, wanted = (analytic(each_nao, side + "Leg", T, limits=limits), nk.ik.leg(each_nao, side, T, limits=limits))
    assert_solved(each_nao, side + "Leg", T, found, inside=limits == "enforce")
    np.testing.assert_array_equal(found.count, wanted.count)
    assert_same_branches(found, wanted)
    away = np.linalg.norm(found.branches - found.near[:, None, list(found.columns)], axis=-1)
    assert not (np.diff(away, axis=-1) < -1e-9).any()
    assert (found.families == Family.NONE).all()
    assert found.notes == ()


@given(st.sampled_from(SIDES), st.sampled_from(LIMITS), st.data())
def test_anywhere_the_branches_of_a_leg_are_those_of_its_closed_form(
    nao: nk.NaoModel, side: str, limits: Any, data: st.DataObject
) -> None:
    share = data.draw(st.lists(st.floats(0.0, 1.0), min_size=25, max_size=25))
    q = nao.clamp(nao.lower + np.array(share) * (nao.upper - nao.lower))
    T = nao.fk(q, side + "Leg")
    found, wanted = analytic(nao, side + "Leg", T, limits=limits), nk.ik.leg(nao, side, T, limits=limits)
    knee = abs(q[nao.joint_names.index(side + "KneePitch")])
    assert_same_branches(found, wanted, 1e-7 if knee > 1e-6 else 1e-5)


@for_all("beside", BESIDE)
@for_all("side", SIDES)
def test_a_straight_knee_and_beside_it(nao: nk.NaoModel, side: str, beside: float) -> None:
    knee = {f"{side}KneePitch": beside, f"{side}HipPitch": -0.3, f"{side}HipRoll": 0.05, "LHipYawPitch": -0.2}
    T = nao.fk(nao.configuration(knee, limits="ignore"), side + "Leg")
    for limits in LIMITS:
        found, wanted = analytic(nao, side + "Leg", T, limits=limits), nk.ik.leg(nao, side, T, limits=limits)
        assert_solved(nao, side + "Leg", T, found, inside=limits == "enforce")
        # Near zero the angle of the knee is a square root of what rounding has left.
        assert_same_branches(found, wanted, 1e-5)
        assert set(found.families.ravel()) == {Family.NONE}


@for_all(("side", "lock"), [("L", -math.pi / 4), ("L", 3 * math.pi / 4), ("R", math.pi / 4)])
def test_at_a_locked_hip_there_is_the_member_nearest_to_the_reference(nao: nk.NaoModel, side: str, lock: float) -> None:
    angles = {"LHipYawPitch": -0.2, f"{side}HipRoll": lock, f"{side}HipPitch": -0.5, f"{side}KneePitch": 0.9}
    T = nao.fk(nao.configuration(angles, limits="ignore"), side + "Leg")
    for reference in (None, nao.posture("Crouch"), nao.random(3)):
        found = analytic(nao, side + "Leg", T, limits="ignore", near=reference)
        wanted = nk.ik.leg(nao, side, T, limits="ignore", near=reference)
        assert_solved(nao, side + "Leg", T, found, inside=False)
        assert Family.SINGULAR in found.families[: found.count]
        assert wanted.family is Family.HIP_LOCK
        assert np.linalg.norm(found.q - found.near) < np.linalg.norm(wanted.q - wanted.near) + 1e-5


@for_all("roll", [-0.3, 0.0, 0.04, 0.3])
@for_all("limits", LIMITS)
def test_with_the_hip_on_the_axis_of_ankle_roll_there_is_the_member_nearest_to_the_reference(
    nao: nk.NaoModel, limits: Any, roll: float
) -> None:
    hip, knee, ankle = (nao.position(nao.neutral(), "L" + joint) for joint in ("HipPitch", "KneePitch", "AnklePitch"))
    thigh, tibia = np.linalg.norm(hip - knee), np.linalg.norm(knee - ankle)
    bend = math.acos(-tibia * math.cos(0.85) / thigh) - 0.85
    angles = {"LHipYawPitch": -0.2, "LHipRoll": 0.05, "LHipPitch": -0.3, "LKneePitch": bend, "LAnklePitch": 0.85}
    q = nao.configuration(angles | {"LAnkleRoll": 0.02}, limits="ignore")
    T = nao.fk(q, "LLeg")
    q[nao.joint_names.index("LAnkleRoll")] = roll
    found = analytic(nao, "LLeg", T, near=q, limits=limits)
    wanted = nk.ik.leg(nao, "L", T, near=q, limits=limits)
    assert_solved(nao, "LLeg", T, found, inside=limits == "enforce")
    assert found.family is Family.SINGULAR
    assert wanted.family is Family.ANKLE_AXIS
    assert np.linalg.norm(found.q - found.near) < np.linalg.norm(wanted.q - wanted.near) + 1e-4


def test_a_target_outside_the_limits_names_the_joint_of_the_closed_form(nao: nk.NaoModel) -> None:
    q = nao.configuration({"LKneePitch": 2.3, "LHipPitch": -0.8, "LAnklePitch": -0.6}, limits="ignore")
    T = nao.fk(q, "LLeg")
    found, wanted = analytic(nao, "LLeg", T), nk.ik.leg(nao, "L", T)
    assert found.reason is wanted.reason is Reason.JOINT_LIMIT
    assert found.describe().split(";")[0] == wanted.describe().split(";")[0]
    np.testing.assert_allclose(found.residual, wanted.residual, atol=1e-6)
    # The same inside the box of AnkleRoll and outside its coupled limit.
    q = nao.configuration({"LAnklePitch": -1.0, "LAnkleRoll": 0.25, "LKneePitch": 1.0}, limits="ignore")
    found, wanted = (
        solve for solve in (analytic(nao, "LLeg", nao.fk(q, "LLeg")), nk.ik.leg(nao, "L", nao.fk(q, "LLeg")))
    )
    assert found.reason is wanted.reason is Reason.COUPLED_LIMIT
    assert found.describe().split(";")[0] == wanted.describe().split(";")[0]


# --- Fewer joints than numbers of a pose ----------------------------------------------------------------------------


@for_all("limits", LIMITS)
@for_all("side", SIDES)
def test_on_a_nao_the_branches_of_an_arm_are_those_of_its_closed_form(nao: nk.NaoModel, side: str, limits: Any) -> None:
    T = nao.fk(nao.random(9, 300), side + "Arm")
    found, wanted = analytic(nao, side + "Arm", T, limits=limits), nk.ik.arm(nao, side, T, limits=limits)
    assert_solved(nao, side + "Arm", T, found, inside=limits == "enforce")
    assert_same_branches(found, wanted)


def test_a_head_of_two_joints_is_solved(nao: nk.NaoModel) -> None:
    q = nao.random(9, 300)
    found = analytic(nao, "Head", nao.fk(q, "Head"))
    assert_solved(nao, "Head", nao.fk(q, "Head"), found)
    assert distance_to_solutions(found, q).max() < 1e-9


def test_least_squares_answers_are_no_solutions(nao: nk.NaoModel) -> None:
    T = nao.fk(nao.random(9, 40), "LArm")
    T[::2, :3, :3] = T[::2, :3, :3] @ exp([0.0, 0.3, 0.2])
    found = analytic(nao, "LArm", T)
    np.testing.assert_array_equal(found.success, np.arange(40) % 2 == 1)
    assert (found.reasons[::2] == Reason.NOT_ENOUGH_JOINTS).all()
    assert (found.count[::2] == 0).all()
    assert found.notes == ("20 of 40 targets are not reached, and have least-squares answers of EAIK only",)
    # The nearest pose is as near as that of the numeric search, whose errors have the same weights.
    wanted = nk.ik.numeric(nao, "LArm", T[::2])
    cost, least = (np.hypot(each[:, 0], 0.1 * each[:, 1]) for each in (found.residual[::2], wanted.residual))
    assert (cost < least + 1e-6).all()
    np.testing.assert_allclose(found.residual, pose_errors(nao.fk(found.q, "LArm"), T), atol=1e-9)
    assert nao.within_limits(found.q).all()


def test_a_tolerance_above_the_error_of_an_answer_makes_it_a_solution(nao: nk.NaoModel) -> None:
    T = nao.fk(nao.random(9), "LArm")
    T[:3, :3] = T[:3, :3] @ exp([0.0, 3e-7, 0.0])
    assert not analytic(nao, "LArm", T).success
    found = analytic(nao, "LArm", T, tolerance=1e-6)
    assert found.success
    assert 1e-8 < found.residual.max() < 1e-6


# --- Other robots ---------------------------------------------------------------------------------------------------

CHAINS: list[tuple[str, str, str | None, dict[str, float]]] = [
    ("romeo", "l_sole", None, {}),
    ("romeo", "RAnkleRoll", None, {}),
    ("romeo", "LWristPitch", "torso", {"LWristRoll": 0.2}),
    ("romeo", "RWristPitch", "torso", {"RElbowRoll": 0.7}),
    ("romeo", "RWristPitch", "torso", {"RShoulderPitch": -0.4}),
    ("romeo", "HeadRoll", None, {"TrunkYaw": 0.3}),
    ("icub", "l_sole", None, {}),
    ("icub", "r_ankle_roll", None, {}),
    ("panda", "panda_link8", None, {"panda_joint7": 0.3}),
    ("panda", "panda_link8", None, {"panda_joint5": 0.3}),
]


@pytest.mark.parametrize(("name", "frame", "root", "locked"), CHAINS)
def test_every_configuration_is_among_the_solutions_of_its_pose(
    name: str, frame: str, root: str | None, locked: dict[str, float]
) -> None:
    robot = nk.load_robot(name)
    q = robot.random(3, 300)
    for joint, value in locked.items():
        q[:, robot.joint_names.index(joint)] = value
    base = robot.tree.root if root is None else root
    T = robot.fk(q, frame, reference=base)
    found = analytic(robot, frame, T, reference=root, locked=locked)
    assert found.success.all()
    assert set(found.joints).isdisjoint(locked)
    assert distance_to_solutions(found, q).max() < 1e-6
    rows = np.flatnonzero(~np.isnan(found.solutions).any(axis=-1).ravel())
    solutions, wanted = found.solutions.reshape(-1, robot.nq)[rows], T[rows // found.solutions.shape[1]]
    assert pose_errors(robot.fk(solutions, frame, reference=base), wanted).max() < 1e-8
    assert robot.within_limits(solutions).all()
    for joint, value in locked.items():
        assert (solutions[:, robot.joint_names.index(joint)] == value).all()


@for_all(("name", "frame"), [("romeo", "l_sole"), ("icub", "r_ankle_roll")])
def test_no_search_finds_a_branch_that_is_missing(name: str, frame: str) -> None:
    robot = nk.load_robot(name)
    T = robot.fk(robot.random(5, 3), frame)
    found = analytic(robot, frame, T, limits="ignore")
    starts = robot.random(6, 60)
    for k, target in enumerate(T):
        searched = nk.ik.numeric(robot, frame, np.repeat(target[None], 60, 0), near=starts, restarts=0, limits="ignore")
        ends = searched.q[searched.success][:, found.columns]
        turns = (ends[:, None] - found.branches[k, : found.count[k]]) / (2.0 * math.pi)
        assert (np.abs(turns - np.round(turns)).max(axis=-1).min(axis=-1) < 1e-6).all()
        assert len(ends) > 10


def test_a_branch_is_listed_with_all_whole_turns_inside_the_limits(tmp_path: Path) -> None:
    bounds = (-2.0 * math.pi, 2.0 * math.pi)
    robot = made_up(
        tmp_path,
        J("pan", limits=bounds),
        J("lift", axis=(0.0, 1.0, 0.0), xyz=(0.0, 0.0, 0.1)),
        J("elbow", axis=(0.0, 1.0, 0.0), xyz=(0.4, 0.0, 0.0), limits=(0.1, 3.0)),
        J("wrist", axis=(0.0, 1.0, 0.0), xyz=(0.4, 0.0, 0.0), limits=bounds),
        J("bend", xyz=(0.0, 0.1, 0.0), limits=(-9.0, 9.0)),
        J("tool", axis=(0.0, 1.0, 0.0), xyz=(0.0, 0.1, 0.1), kind="continuous"),
    )
    q = np.array([0.3, -0.5, 0.9, 0.4, 0.7, 5.0])
    T = robot.fk(q, "tool_l")
    found = analytic(robot, "tool_l", T, near=q)
    np.testing.assert_allclose(found.q, q, atol=1e-9)
    listed = found.branches[: found.count]
    for pan, wrist, bend in itertools.product((0, -1), (0, -1), (-1, 0, 1)):
        turned = q + 2.0 * math.pi * np.array([pan, 0, 0, wrist, bend, 0])
        assert (np.abs(listed - turned).max(axis=-1) < 1e-9).sum() == 1
    assert robot.within_limits(found.solutions[: found.count]).all()
    assert (np.abs(listed[:, 5] - 5.0) <= math.pi + 1e-9).all()
    away = np.linalg.norm(listed - q, axis=-1)
    assert (np.diff(away) >= 0.0).all()
    # Without limits, each branch once, with the turns nearest to the reference.
    free = analytic(robot, "tool_l", T, near=q + 20.0, limits="ignore")
    assert (np.abs(free.branches - q - 20.0) <= math.pi + 1e-9).all()
    assert len(np.unique(np.round(np.cos(free.branches), 6), axis=0)) == free.count


def test_mimic_joints_move_as_they_follow(tmp_path: Path) -> None:
    robot = made_up(
        tmp_path,
        J("drive", limits=(-1.0, 1.0), parent="base", xyz=(0.0, 0.5, 0.0)),
        J("pan", parent="base", follows=("drive", -2.0, 0.3)),
        J("lift", axis=(0.0, 1.0, 0.0), xyz=(0.0, 0.0, 0.1)),
        J("elbow", axis=(0.0, 1.0, 0.0), xyz=(0.4, 0.0, 0.0)),
    )
    q = robot.random(1, 50)
    T = robot.fk(q, "elbow_l")
    found = analytic(robot, "elbow_l", T)
    assert found.joints == ("drive", "lift", "elbow")
    assert found.notes == ()
    assert_solved(robot, "elbow_l", T, found)
    assert distance_to_solutions(found, q).max() < 1e-7


@for_all("beside", [3e-5, 1e-4, 1e-3, 1e-2])
def test_beside_a_stretched_elbow_all_branches_are_exact(beside: float) -> None:
    romeo = nk.load_robot("romeo")
    q = romeo.random(1, 10)
    q[:, [romeo.joint_names.index("LShoulderPitch"), romeo.joint_names.index("LElbowYaw")]] = 0.1, -beside
    T, locked = romeo.fk(q, "LWristPitch", reference="torso"), {"LShoulderPitch": 0.1}
    found = analytic(romeo, "LWristPitch", T, reference="torso", locked=locked, limits="ignore")
    assert (found.count == 8).all()
    assert found.notes == ()
    poses = romeo.fk(found.solutions, "LWristPitch", reference="torso")
    assert pose_errors(poses, np.broadcast_to(T[:, None], poses.shape)).max() < 1e-11
    inside = analytic(romeo, "LWristPitch", T, reference="torso", locked=locked)
    assert distance_to_solutions(inside, q).max() < 1e-9 / beside


@for_all("beside", [0.0, 1e-8, 1e-6])
def test_a_stretched_elbow_has_a_member_inside_the_limits(beside: float) -> None:
    romeo = nk.load_robot("romeo")
    q = romeo.random(1, 20)
    q[:, [romeo.joint_names.index("LShoulderPitch"), romeo.joint_names.index("LElbowYaw")]] = 0.1, -beside
    T = romeo.fk(q, "LWristPitch", reference="torso")
    found = analytic(romeo, "LWristPitch", T, reference="torso", locked={"LShoulderPitch": 0.1})
    # Between 1e-7 and 1e-6 rad a few searches fail; for a fifth, only a search has the member that is inside.
    assert found.success.all() or (beside == 1e-6 and found.success.mean() >= 0.95)
    assert (found.family == Family.SINGULAR).all() or beside == 1e-6  # where EAIK has some of the branches
    assert romeo.within_limits(found.q).all()
    assert found.residual[found.success].max() < 1e-8


# Chains with targets that have least-squares answers of EAIK, the joint that makes them singular at zero, and a joint
# to be locked.
SINGULAR = [
    ("panda", "panda_hand_tcp", "panda_joint2", "panda_joint7"),
    ("panda", "panda_hand_tcp", "panda_joint2", "panda_joint6"),
    ("panda", "panda_hand_tcp", "panda_joint2", "panda_joint5"),
    ("ur5_robot", "tool0", "wrist_2_joint", ""),
    ("ur10_robot", "tool0", "wrist_2_joint", ""),
]


def near_a_singularity(name: str, frame: str, joint: str, lock: str, beside: float) -> tuple[Any, Floats, Floats, Any]:
    """Return a robot, configurations beside a singularity, their poses by Pinocchio, and arguments of `analytic`."""
    robot, rng = nk.load_robot(name), np.random.default_rng(5)
    q = robot.random(rng, 4) if lock else rng.uniform(-1.5, 1.5, (2, 6))
    q[:, robot.joint_names.index(joint)] = beside
    if lock:
        q[:, robot.joint_names.index(lock)] = q[0, robot.joint_names.index(lock)]
    locked = {lock: float(q[0, robot.joint_names.index(lock)])} if lock else {}
    return robot, q, poses_by_pinocchio(robot, frame, q), {"reference": robot.tree.root, "locked": locked}


def poses_by_pinocchio(robot: Any, frame: str, q: Floats) -> Floats:
    data, index, poses = robot.model.createData(), robot.model.getFrameId(frame), []
    for row in q:
        pin.forwardKinematics(robot.model, data, row)
        poses.append(pin.updateFramePlacement(robot.model, data, index).homogeneous)
    return np.array(poses)


@pytest.mark.parametrize("beside", [0.0, 1e-9, 1e-6, 1e-3, *full(1e-12, 1e-7, 1e-5)])
@for_all(("name", "frame", "joint", "lock"), SINGULAR)
def test_where_two_axes_meet_the_reference_is_among_the_solutions(
    name: str, frame: str, joint: str, lock: str, beside: float
) -> None:
    robot, q, T, given = near_a_singularity(name, frame, joint, lock, beside)
    limits: Any = "enforce" if lock else "ignore"
    found = analytic(robot, frame, T, near=q, limits=limits, **given)
    np.testing.assert_allclose(found.branches[:, 0], q[:, list(found.columns)], atol=1e-7)
    for index, row in enumerate(found.branches):
        solutions = np.tile(q[index], (int(found.count[index]), 1))
        solutions[:, list(found.columns)] = row[: len(solutions)]
        np.testing.assert_allclose(
            poses_by_pinocchio(robot, frame, solutions), np.broadcast_to(T[index], (len(solutions), 4, 4)), atol=2e-8
        )
    if beside == 0.0:
        # The branch that EAIK misses is found without the reference, too.
        alone = analytic(robot, frame, T, limits=limits, **given)
        assert (alone.families == Family.SINGULAR).any(axis=-1).all()
        assert any("have solutions that EAIK misses" in note for note in alone.notes)


@for_all(("name", "frame", "joint", "lock"), SINGULAR)
def test_away_from_singularities_eaik_is_asked_once(
    monkeypatch: pytest.MonkeyPatch, name: str, frame: str, joint: str, lock: str
) -> None:
    robot, q, _, given = near_a_singularity(name, frame, joint, lock, 0.7)
    more = q[:1] + np.random.default_rng(6).uniform(-0.5, 0.5, (40, robot.nq))
    if lock:
        more[:, robot.joint_names.index(lock)] = q[0, robot.joint_names.index(lock)]
    asked: list[int] = []
    with monkeypatch.context() as patch:
        answer_with(patch, lambda Q: asked.append(len(Q)) or Q)
        found = analytic(robot, frame, poses_by_pinocchio(robot, frame, more), limits="ignore", **given)
    assert found.success.all()
    # Some targets have least-squares answers.
    assert sum(asked[-40:]) > found.count.sum()
    # Before, answers for four poses show whether EAIK solves the chain.
    assert len(asked) <= 40 + 4


@for_all("name", ["ur5_robot", "ur10_robot"])
def test_a_family_is_searched_for_once_and_listed_with_its_whole_turns(
    monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    robot, q, T, given = near_a_singularity(name, "tool0", "wrist_2_joint", "", 0.0)
    starts: dict[str, int] = {}
    found: dict[str, IKResult] = {}
    for limits in LIMITS:

        def counted(chain: Any, region: Any, goal: Any, targets: Floats, *rest: Any, limits: Any = limits) -> Any:
            starts[limits] = starts.get(limits, 0) + len(targets)
            return descended(chain, region, goal, targets, *rest)

        with monkeypatch.context() as patch:
            patch.setattr(sys.modules["nao_kin.ik.analytic"], "descended", counted)
            found[limits] = analytic(robot, "tool0", T, near=q, limits=limits, **given)
    assert starts["enforce"] < 1.5 * starts["ignore"]
    for index in range(len(T)):
        turned, members = (
            each.branches[index][each.families[index] == Family.SINGULAR]
            for each in (found["enforce"], found["ignore"])
        )
        turns = (turned[:, None] - members) / (2.0 * math.pi)
        same = (np.abs(turns - np.round(turns)) < 1e-4).all(axis=-1)
        assert (same.sum(axis=1) == 1).all()
        # Joints with limits of ±360° have two values inside them, wrist_2 at zero has three.
        assert (same.sum(axis=0) >= 2**5).all()
        assert (np.abs(turned) <= 2.0 * math.pi + 1e-9).all()


@for_all(("beside", "is_said"), [(0.0, False), (1e-9, False), (1e-7, True), (1e-3, False)])
def test_branches_that_may_be_missing_beside_a_singularity_are_said(beside: float, is_said: bool) -> None:
    robot, _, T, given = near_a_singularity("ur5_robot", "tool0", "wrist_2_joint", "", beside)
    found = analytic(robot, "tool0", T, limits="ignore", **given)
    note = "2 of 2 targets near a singularity may have more solutions: EAIK misses some, and a search for them failed"
    assert (note in found.notes) is is_said
    # 1 mm away none is missing.
    T[:, :3, 3] += 1e-3
    away = analytic(robot, "tool0", T, limits="ignore", **given)
    assert away.notes == ()
    assert (found.count < away.count).all() == (is_said or beside == 0.0)


def test_branches_near_each_other_are_no_family() -> None:
    romeo = nk.load_robot("romeo")
    q = romeo.neutral()
    arm = ("LShoulderPitch", "LShoulderYaw", "LElbowRoll", "LElbowYaw", "LWristRoll", "LWristYaw", "LWristPitch")
    values = (-1.131, -0.206931271, 1.364266415, -0.000454107, -2.436135163, 0.399145678, 0.077800372)
    q[[romeo.joint_names.index(joint) for joint in arm]] = values
    T = romeo.fk(q, "LWristPitch", reference="torso")
    found = analytic(romeo, "LWristPitch", T, reference="torso", locked={"LShoulderPitch": -1.131}, near=q)
    assert found.count == 2
    assert (found.families == Family.NONE).all()
    np.testing.assert_allclose(found.q, q, atol=1e-6)
    assert 0.05 < np.abs(found.branches[1] - found.branches[0]).max() < 0.1


def test_a_family_without_a_member_inside_the_limits_names_a_joint(nao: nk.NaoModel) -> None:
    q = nao.configuration({"LHipYawPitch": -0.2, "LHipRoll": -math.pi / 4, "LKneePitch": 0.9}, limits="ignore")
    found = analytic(nao, "LLeg", nao.fk(q, "LLeg"))
    assert found.reason is Reason.JOINT_LIMIT
    assert found.joints[int(found.obstacles.joint)] == "LHipRoll"


# --- Arguments ------------------------------------------------------------------------------------------------------


def test_batches_have_any_shape_and_references_of_their_own(nao: nk.NaoModel) -> None:
    q = nao.random(5, (2, 3))
    T = nao.fk(q, "RLeg")
    many = analytic(nao, "RLeg", T, near=nao.random(6, (2, 3)))
    assert many.q.shape == (2, 3, 25)
    for index in np.ndindex(2, 3):
        one = analytic(nao, "RLeg", T[index], near=many.near[index])
        assert one.success is True
        np.testing.assert_allclose(one.solutions, many.solutions[index][: one.count], atol=1e-9)
    empty = analytic(nao, "RLeg", np.zeros((0, 4, 4)))
    assert empty.q.shape == (0, 25)
    assert empty.count.shape == (0,)


def test_a_floating_base_and_a_root_of_the_chain() -> None:
    nao = nk.load_nao("v6", base="floating")
    q = nao.random(5)
    T = nao.fk(q, "LLeg", reference="torso")
    found = analytic(nao, "LLeg", T, near=q)
    np.testing.assert_allclose(found.q, q, atol=1e-9)
    # From the foot to the torso.
    back = analytic(nao, "torso", np.linalg.inv(T), reference="LLeg", near=q)
    np.testing.assert_allclose(back.q, q, atol=1e-9)
    assert back.count == found.count
    # From the head to the hand: seven joints, of which one of the head is locked.
    pitch = float(q[nao.nq_base + nao.joint_names.index("HeadPitch")])
    locked = {"HeadPitch": pitch}
    hand = analytic(nao, "LArm", nao.fk(q, "LArm", reference="Head"), reference="Head", locked=locked, near=q)
    np.testing.assert_allclose(hand.q, q, atol=1e-8)


def answer_with(monkeypatch: pytest.MonkeyPatch, changed: Callable[[Floats], Floats]) -> None:
    """Let EAIK give other answers."""
    from eaik.IK_HP import HPRobot

    given = HPRobot.IK

    def wrong(self: Any, pose: Floats) -> Any:
        found = given(self, pose)
        found.Q = changed(found.Q)
        return found

    monkeypatch.setattr(HPRobot, "IK", wrong)


def test_a_wrong_answer_of_eaik_is_left_out_and_counted(nao: nk.NaoModel, monkeypatch: pytest.MonkeyPatch) -> None:
    T = nao.fk(nao.random(5, 4), "LLeg")
    assert (analytic(nao, "LLeg", T, limits="ignore").count == 8).all()
    answer_with(monkeypatch, lambda Q: Q + 0.3 * np.eye(8, 6)[:, :1] * np.eye(6)[0])
    found = analytic(nao, "LLeg", T, limits="ignore")
    assert (found.count == 7).all()
    assert found.notes == ("answers of EAIK that are wrong are left out: 4",)
    assert_solved(nao, "LLeg", T, found, inside=False)


def test_solutions_that_eaik_misses_are_searched_for(nao: nk.NaoModel, monkeypatch: pytest.MonkeyPatch) -> None:
    T = nao.fk(nao.posture("StandInit"), "LLeg")
    assert analytic(nao, "LLeg", T).notes == ()
    answer_with(monkeypatch, lambda Q: np.zeros((0, 6)))
    found = analytic(nao, "LLeg", T, near=nao.posture("Crouch"))
    assert found.success
    assert found.notes == ("1 of 1 targets were reached by a search only, not by an answer of EAIK",)


SHOWN = {"robot": "nao", "frame": "LLeg", "target": np.eye(4)}
BAD: list[tuple[dict[str, Any], type[Exception], str]] = [
    ({"frame": "LLe"}, UnknownName, "LLeg"),
    ({"reference": "tors"}, UnknownName, "torso"),
    ({"frame": "torso"}, BadArgument, "no joint moves 'torso'"),
    ({"frame": "RLeg", "reference": "LLeg"}, BadArgument, "LHipYawPitch moves two of its joints.*numeric"),
    ({"frame": "LArm", "reference": "Head"}, BadArgument, "7 joints, and EAIK solves 6; lock .*numeric"),
    ({"locked": {"HeadYaw": 0.1}}, UnknownName, "only joints between torso and LLeg"),
    ({"locked": {"LKneePich": 0.1}}, UnknownName, "LKneePitch"),
    ({"locked": {"LKneePitch": 9.0}}, OutsideLimits, "LKneePitch"),
    ({"locked": {"LLeg": [0.0] * 6}}, BadArgument, "locked must have one value for each joint, got 'LLeg'"),
    ({"locked": {"LHipRoll": [0.1, 0.2]}}, BadArgument, "locked must have one value for each joint, got 'LHipRoll'"),
    ({"limits": "no"}, UnknownName, "limits policy"),
    ({"tolerance": -1.0}, BadArgument, "tolerance"),
    ({"target": np.diag([2.0, 1.0, 1.0, 1.0])}, NotARotation, "target"),
    ({"target": np.eye(3)}, WrongShape, "target"),
    ({"near": np.zeros(3)}, WrongShape, "near"),
    (
        {"robot": "icub", "frame": "neck_yaw"},
        BadArgument,
        "knows no decomposition for the axes of torso_pitch.*numeric",
    ),
    (
        {"robot": "romeo", "frame": "HeadRoll"},
        BadArgument,
        "TrunkYaw, NeckYaw always move together without moving 'HeadRoll'; lock one",
    ),
    ({"robot": "icub", "frame": "l_knee"}, BadArgument, "decomposition.*misses solutions.*numeric"),
    ({"robot": "tiago", "frame": "arm_4_link"}, BadArgument, "torso_lift_joint slides; lock it"),
]


@pytest.mark.parametrize(("changes", "error", "words"), BAD)
def test_bad_input_is_named(changes: dict[str, Any], error: type[Exception], words: str) -> None:
    arguments = SHOWN | changes
    name = arguments.pop("robot")
    robot = nk.load_nao("v6") if name == "nao" else nk.load_robot(name)
    with pytest.raises(error, match=words):
        analytic(robot, **arguments)


def test_a_sliding_joint_may_be_locked() -> None:
    tiago = nk.load_robot("tiago")
    q = tiago.random(2)
    q[tiago.joint_names.index("torso_lift_joint")] = 0.2
    T = tiago.fk(q, "arm_4_link")
    found = analytic(tiago, "arm_4_link", T, locked={"torso_lift_joint": 0.2}, near=q)
    assert distance_to_solutions(found, q) < 1e-7


def test_a_locked_mimic_joint_locks_the_motor_of_both_hips(nao: nk.NaoModel) -> None:
    q = nao.configuration({"LHipYawPitch": -0.3, "RHipPitch": -0.4, "RKneePitch": 0.8})
    found = analytic(nao, "RLeg", nao.fk(q, "RLeg"), locked={"RHipYawPitch": -0.3})
    assert "LHipYawPitch" not in found.joints
    np.testing.assert_allclose(found.q[list(found.columns)], q[list(found.columns)], atol=1e-8)
    assert found.q[nao.joint_names.index("LHipYawPitch")] == -0.3


def test_without_eaik_the_extra_is_named(nao: nk.NaoModel, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "eaik", None)
    with pytest.raises(MissingExtra, match=r"nao-kin\[analytic\]"):
        analytic(nao, "LLeg", np.eye(4))


def test_what_is_given_is_not_changed(nao: nk.NaoModel) -> None:
    T, reference = nao.fk(nao.random(1), "LLeg"), nao.random(2)
    T[:3, :3] = T[:3, :3] @ rot_x(0.0)
    before = T.copy(), reference.copy()
    analytic(nao, "LLeg", T, near=reference, locked={"LHipRoll": 0.1}).q[:] = 0.0
    np.testing.assert_array_equal(T, before[0])
    np.testing.assert_array_equal(reference, before[1])
