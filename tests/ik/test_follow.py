"""`nk.ik.follow`: paths of targets, the branches chosen along them, jumps, speeds, and what is refused."""

from __future__ import annotations

import copy
import dataclasses
import itertools
import math
import os
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nao_kin as nk
from nao_kin._core.arrays import Floats
from nao_kin.errors import BadArgument, NotARotation, NotFinite, UnknownName, WrongShape, ZeroNorm
from nao_kin.ik import Reason, follow_branches as branch_choice, follow_limbs as limb_paths
from nao_kin.ik.targets import checked_reference
from nao_kin.rotations import matrix_from_rpy, rot_z


def line(first: Floats, last: Floats, n: int) -> Floats:
    """Return configurations on the straight line from one to another."""
    return np.asarray(first + np.linspace(0.0, 1.0, n)[:, None] * (last - first))


def way(nao: nk.NaoModel, seed: int | np.random.Generator, n: int) -> Floats:
    """Return configurations on a straight line inside the limits."""
    rng = np.random.default_rng(seed)
    while True:
        q = line(*nao.random(rng, 2), n)
        if nao.within_limits(q).all():
            return q


def swinging(nao: nk.NaoModel, effector: str, n: int) -> Floats:
    """Poses of an effector of the standing robot that go round once, 4 cm wide."""
    T = np.tile(nao.fk(nao.posture("StandInit"), effector), (n, 1, 1))
    s = np.linspace(0.0, 2.0 * math.pi, n)
    T[:, 0, 3] += 0.04 * np.sin(s)
    T[:, 2, 3] += 0.02 * (1.0 - np.cos(s))
    return T


def squared_motion(nao: nk.NaoModel, q: Floats) -> float:
    """Σ (Δq_j / v_j)² over the path."""
    return float(((np.diff(q, axis=0) / nao.velocity_limits) ** 2).sum())


def arm_branches(nao: nk.NaoModel, T: Floats, reference: Floats) -> nk.ik.IKResult:
    """All branches of the left arm for places and directions."""
    return nk.ik.arm(nao, "L", T[..., :3, 3], direction=T[..., :3, 0], near=reference)


def one_branch(nao: nk.NaoModel, T: Floats) -> Floats:
    """The branch of the left arm that a first pose has alone, continued by the nearest solution of each pose."""
    q = arm_branches(nao, T[0], nao.clamp(nao.neutral())).q
    rows = [q]
    for pose in T[1:]:
        q = arm_branches(nao, pose, q).q
        rows.append(q)
    return np.array(rows)


def along(nao: nk.NaoModel, q: Floats, direction: Floats, most: int = 400) -> Floats:
    """Configurations from q in a direction, by steps of 0.01 rad, as far as the limits let."""
    rows = q + 0.01 * np.arange(most)[:, None] * direction
    outside = np.flatnonzero(~nao.within_limits(rows))
    return rows[: outside[0]] if len(outside) else rows


def crossing(nao: nk.NaoModel, seed: int) -> tuple[Floats, Floats, Floats]:
    """Poses of the left hand along which a first branch ends and a second begins; the branches of the middle pose.

    Returns:
        Poses (n, 4, 4), how many branches there are at each (n,), the two branches of the pose that both have (2, nq).
    """
    rng = np.random.default_rng(seed)
    while True:
        q = nao.random(rng)
        both = arm_branches(nao, nao.fk(q, "LArm"), q)
        if both.count != 2 or np.abs(both.branches[1] - both.branches[0]).max() < 0.5:
            continue
        ways, counts = [], []
        for branch in both.solutions:
            direction = np.zeros(nao.nq)
            direction[list(both.columns)] = rng.uniform(-1.0, 1.0, 5)
            way = along(nao, branch, direction / np.abs(direction).max())
            counts.append(arm_branches(nao, nao.fk(way, "LArm"), way).count)
            ways.append(way)
        if all(count[-1] == 1 and (np.diff(count) <= 0).all() and len(count) > 20 for count in counts):
            T = np.concatenate([nao.fk(ways[0][::-1], "LArm"), nao.fk(ways[1][1:], "LArm")])
            return T, np.concatenate([counts[0][::-1], counts[1][1:]]), both.solutions


# --- the path is met --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("effector", ["LLeg", "RLeg", "LArm", "RArm"])
def test_a_way_of_the_joints_is_found_again_from_its_poses(each_nao: nk.NaoModel, effector: str) -> None:
    q = way(each_nao, 3, 60)
    found = nk.ik.follow(each_nao, {effector: each_nao.fk(q, effector)}, near=q)
    assert found.success
    assert not found.jumps
    np.testing.assert_allclose(found.q, q, atol=1e-8)
    limb = list(found.limbs[0].columns)
    assert found.motion == pytest.approx(((np.diff(q[:, limb], axis=0) / each_nao.velocity_limits[limb]) ** 2).sum())


def test_one_foot_goes_round_and_all_else_stands_still(nao: nk.NaoModel) -> None:
    q, T = nao.posture("StandInit"), swinging(nao, "LLeg", 80)
    found = nk.ik.follow(nao, {"LLeg": T}, near=q)
    assert found.reached.all()
    np.testing.assert_allclose(nao.fk(found.q, "LLeg"), T, atol=1e-10)
    others = [column for column in range(nao.nq) if column not in found.limbs[0].columns]
    np.testing.assert_array_equal(found.q[:, others], np.broadcast_to(q[others], (80, len(others))))


def test_both_feet_share_the_motor_of_the_hips(nao: nk.NaoModel) -> None:
    q = way(nao, 5, 40)
    path = {"LLeg": nao.fk(q, "LLeg"), "RLeg": nao.fk(q, "RLeg")}
    found = nk.ik.follow(nao, path, near=nao.posture("StandInit"))
    assert found.success
    assert [limb.name for limb in found.limbs] == ["legs"]
    for effector, T in path.items():
        np.testing.assert_allclose(nao.fk(found.q, effector), T, atol=1e-9)


def test_one_target_stands_for_all_samples(nao: nk.NaoModel) -> None:
    q = nao.posture("StandInit")
    still = nao.fk(q, "RLeg")
    path = {"LArm": nao.fk(q, "LArm")[:3, 3] + np.linspace(0, 0.03, 7)[:, None] * [1.0, 0.0, 0.0], "RLeg": still}
    found = nk.ik.follow(nao, path, near=q)
    assert found.success
    np.testing.assert_allclose(nao.fk(found.q, "RLeg"), np.broadcast_to(still, (7, 4, 4)), atol=1e-10)


def test_places_of_a_hand_are_met_and_each_follows_from_the_one_before(nao: nk.NaoModel) -> None:
    q = nao.posture("StandInit")
    s = np.linspace(0.0, 2.0 * math.pi, 40)
    places = nao.fk(q, "LArm")[:3, 3] + 0.02 * np.stack([0.0 * s, np.sin(s), np.sin(2.0 * s)], axis=-1)
    found = nk.ik.follow(nao, {"LArm": places}, near=q)
    assert found.success
    np.testing.assert_allclose(nao.fk(found.q, "LArm")[:, :3, 3], places, atol=1e-10)
    before = q
    for i in range(40):
        before = nk.ik.arm(nao, "L", places[i], near=before).q
        np.testing.assert_allclose(found.q[i], before, atol=1e-7)


def test_places_with_directions_are_met(nao: nk.NaoModel) -> None:
    T = nao.fk(way(nao, 8, 50), "RArm")
    found = nk.ik.follow(nao, {"RArm": T[:, :3, 3]}, directions={"RArm": 3.0 * T[:, :3, 0]})
    assert found.success
    reached = nao.fk(found.q, "RArm")
    np.testing.assert_allclose(reached[:, :3, 3], T[:, :3, 3], atol=1e-10)
    np.testing.assert_allclose(reached[:, :3, 0], T[:, :3, 0], atol=1e-9)


def test_the_head_turns_and_looks(nao: nk.NaoModel) -> None:
    q = line(nao.configuration({"HeadYaw": -0.5}), nao.configuration({"HeadYaw": 0.6, "HeadPitch": 0.2}), 20)
    found = nk.ik.follow(nao, {"Head": nao.rotation(q, "Head")})
    np.testing.assert_allclose(found.q[:, :2], q[:, :2], atol=1e-9)
    points = np.array([1.0, 0.0, 0.0]) + np.linspace(-0.5, 0.5, 20)[:, None] * [0.0, 1.0, 0.2]
    found = nk.ik.follow(nao, {"CameraBottom": points})
    assert found.success
    T = nao.fk(found.q, "CameraBottom")
    away = points - T[:, :3, 3]
    np.testing.assert_allclose(T[:, :3, 0], away / np.linalg.norm(away, axis=1)[:, None], atol=1e-9)


@pytest.mark.parametrize("base", ["fixed", "floating"])
def test_targets_in_the_world_are_met_from_a_moving_torso(base: Any) -> None:
    nao = nk.load_nao("v6", base=base)
    fixed = nk.load_nao("v6")
    q = way(fixed, 11, 30)
    torso = np.tile(np.eye(4), (30, 1, 1))
    torso[:, :3, :3] = matrix_from_rpy(np.linspace([2.5, 0.0, 0.0], [4.0, 0.2, 0.3], 30))
    torso[:, :3, 3] = np.linspace([0.0, 0.1, 0.3], [0.1, 0.0, 0.32], 30)
    T = torso[:, None] @ fixed.fk(q, ["LLeg", "LArm", "Head", "RArm"])
    path = {"LLeg": T[:, 0], "LArm": T[:, 1, :3, 3], "Head": T[:, 2, :3, :3], "RArm": T[:, 3, :3, 3]}
    found = nk.ik.follow(nao, path, torso=torso, directions={"RArm": T[:, 3, :3, 0]})
    assert found.success
    np.testing.assert_array_equal(found.torso, torso)
    joints = found.q[:, -25:]
    world = torso[:, None] @ fixed.fk(joints, ["LLeg", "LArm", "Head", "RArm"])
    np.testing.assert_allclose(world[:, 0], T[:, 0], atol=1e-9)
    np.testing.assert_allclose(world[:, 1, :3, 3], T[:, 1, :3, 3], atol=1e-9)
    np.testing.assert_allclose(world[:, 2, :3, :3], T[:, 2, :3, :3], atol=1e-9)
    np.testing.assert_allclose(world[:, 3, :3, 0], T[:, 3, :3, 0], atol=1e-9)
    if base == "floating":
        np.testing.assert_allclose(nao.fk(found.q, "LLeg", reference="world"), T[:, 0], atol=1e-9)
        # A turn by more than half a circle, and no quaternion changes its sign on the way.
        assert (np.einsum("ni,ni->n", found.q[1:, 3:7], found.q[:-1, 3:7]) > 0.9).all()


@pytest.mark.parametrize("free", ["yaw", "lean"])
def test_the_torso_gives_way_where_both_feet_disagree(free: Any) -> None:
    nao = nk.load_nao("v6", base="floating")
    q = nao.posture("StandInit")
    feet = {effector: nao.fk(q, effector) for effector in ("LLeg", "RLeg")}
    torso = np.tile(nao.fk(q, "torso"), (8, 1, 1))
    torso[:, 1, 3] += np.linspace(0.0, 0.03, 8)  # aside, and leant as it is in this posture
    hand = nao.position(q, "LArm") + np.array([0.02, 0.0, 0.02])
    stiff = nk.ik.follow(nao, feet, torso=torso, near=q)
    assert list(stiff.reached) == [True, *[False] * 7]
    assert (stiff.reasons["legs"][1:] == Reason.HIPS_DISAGREE).all()
    assert "the hips disagree by" in stiff.message
    assert np.isfinite(stiff.q).all()
    found = nk.ik.follow(nao, {**feet, "LArm": hand}, torso=torso, near=q, free=free)
    assert found.success
    assert found.torso is not None
    np.testing.assert_allclose(nao.fk(found.q, "torso"), found.torso, atol=1e-12)
    for effector, T in feet.items():
        np.testing.assert_allclose(nao.fk(found.q, effector), np.broadcast_to(T, (8, 4, 4)), atol=1e-9)
    np.testing.assert_allclose(nao.position(found.q, "LArm"), np.broadcast_to(hand, (8, 3)), atol=1e-9)
    assert 1e-3 < np.abs(found.torso - torso).max() < 0.2


def test_frames_on_the_effectors_may_be_followed(nao: nk.NaoModel) -> None:
    q = way(nao, 12, 20)
    found = nk.ik.follow(nao, {"LLeg": nao.fk(q, "LFoot")}, frames={"LLeg": "LFoot"}, near=q)
    np.testing.assert_allclose(found.q, q, atol=1e-8)


# --- branches ---------------------------------------------------------------------------------------------------------


# Without limits, branches around a reference may be more than a full turn from zero.
@pytest.mark.full
@pytest.mark.filterwarnings("ignore::nao_kin.errors.DegreesWarning")
@pytest.mark.parametrize("effector", ["LLeg", "LArm"])
def test_no_combination_of_branches_moves_less(nao: nk.NaoModel, effector: str) -> None:
    rng = np.random.default_rng(21)
    for _ in range(3):
        T = nao.fk(nao.random(rng, 4), effector)
        start = nao.random(rng)
        solve = nk.ik.leg if effector == "LLeg" else nk.ik.arm
        for reference in (None, start):
            every = solve(nao, "L", T, limits="ignore", near=reference)
            limb = list(every.columns)
            branches = [every.branches[i, : every.count[i]] / nao.velocity_limits[limb] for i in range(4)]
            pairs = itertools.pairwise(branches)
            steps = [((after[None] - before[:, None]) ** 2).sum(axis=-1) for before, after in pairs]
            first = ((branches[0] - start[limb] / nao.velocity_limits[limb]) ** 2).sum(axis=-1)
            begin = 0.0 * first if reference is None else first
            least = min(
                begin[choice[0]] + sum(step[pair] for step, pair in zip(steps, itertools.pairwise(choice), strict=True))
                for choice in itertools.product(*(range(count) for count in every.count))
            )
            found = nk.ik.follow(nao, {effector: T}, limits="ignore", near=reference)
            assert found.motion == pytest.approx(least, rel=1e-9)
            rows = (
                found.q
                if reference is None
                else np.concatenate([[with_limb_of(every, reference, found.q[0])], found.q])
            )
            assert squared_motion(nao, rows) == pytest.approx(least, rel=1e-9)


def test_between_two_configurations_the_motion_to_both_counts(nao: nk.NaoModel) -> None:
    T = nao.fk(nao.random(22, 3), "LLeg")
    limb = limb_paths.LimbPath(nao, "LLeg", ("LLeg",), (T,), {"limits": "ignore"})
    every = nk.ik.leg(nao, "L", T, limits="ignore")
    start, end = nao.random(23, 2)
    choice = branch_choice.choose(limb, np.tile(start, (3, 1)), 1.0 / nao.velocity_limits, start=start, end=end)
    least = math.inf
    for combination in itertools.product(*(range(count) for count in every.count)):
        q = np.tile(start, (5, 1))
        q[1:4, list(every.columns)] = every.branches[np.arange(3), combination]
        q[4, list(every.columns)] = end[list(every.columns)]
        least = min(least, squared_motion(nao, q))
    assert choice.cost == pytest.approx(least, rel=1e-9)


def with_limb_of(every: nk.ik.IKResult, reference: Floats, q: Floats) -> Floats:
    """The joints of a limb from a reference, all others from q."""
    found = np.array(q)
    found[list(every.columns)] = reference[list(every.columns)]
    return found


def test_the_branch_that_goes_on_is_taken_where_the_nearest_one_ends(nao: nk.NaoModel) -> None:
    T, _, both = crossing(nao, 2)
    middle = int(np.argmin(np.abs(nao.fk(both[0], "LArm") - T).max(axis=(1, 2))))
    path = T[middle:]  # from the pose that both branches have to where only the second is left
    free = nk.ik.follow(nao, {"LArm": path[:, :3, 3]}, directions={"LArm": path[:, :3, 0]})
    np.testing.assert_allclose(free.q[0, 8:13], both[1, 8:13], atol=1e-7)
    assert free.success
    # Always taking the solution nearest to the previous sample, starting on the first branch, leads to a jump.
    q, greedy = both[0], [both[0]]
    for pose in path:
        q = arm_branches(nao, pose, q).q
        greedy.append(q)
    assert np.abs(np.diff(free.q, axis=0)).max() < 0.1
    assert np.abs(np.diff(greedy, axis=0)).max() > 0.1


def test_the_way_from_the_reference_counts_and_without_one_it_does_not(nao: nk.NaoModel) -> None:
    T, _, both = crossing(nao, 2)
    middle = int(np.argmin(np.abs(nao.fk(both[0], "LArm") - T).max(axis=(1, 2))))
    path = T[middle : middle + 1]
    for branch in both:
        found = nk.ik.follow(nao, {"LArm": path[:, :3, 3]}, directions={"LArm": path[:, :3, 0]}, near=branch)
        np.testing.assert_allclose(found.q[0], branch, atol=1e-7)


def test_a_family_is_followed_by_the_member_nearest_to_the_sample_before() -> None:
    # V3.2 spreads its arms along the axis of ShoulderPitch, about which they may then turn.
    old = nk.load_nao("v3.2")
    spread = {"LShoulderRoll": math.pi / 2, "LElbowYaw": 2.0, "LElbowRoll": -0.6, "RShoulderRoll": -0.1}
    pitch = np.concatenate([np.linspace(0.3, 0.9, 6), np.linspace(0.8, 0.3, 5)])
    q = old.configuration({**spread, "RElbowRoll": 0.1, "LShoulderPitch": pitch})
    T = old.fk(q, "LArm")
    found = nk.ik.follow(old, {"LArm": T}, near=q[0])
    assert found.success
    before = q[0]
    for i in range(len(q)):
        alone = nk.ik.arm(old, "L", T[i], near=before)
        assert alone.family is nk.ik.Family.SHOULDER_AXIS
        np.testing.assert_allclose(found.q[i], alone.q, atol=1e-9)
        before = alone.q
    # Halfway ElbowYaw comes to its limit; the way back begins there, which a fixed reference does not know.
    assert np.abs(found.q - nk.ik.arm(old, "L", T, near=q[0]).q).max() > 0.1


# --- jumps ------------------------------------------------------------------------------------------------------------


def test_a_path_that_must_jump_is_reported_where_both_branches_are(nao: nk.NaoModel) -> None:
    T, count, _ = crossing(nao, 2)
    places, directions = T[:, :3, 3], T[:, :3, 0]
    found = nk.ik.follow(nao, {"LArm": places}, directions={"LArm": directions})
    assert found.reached.all()
    assert len(found.jumps) == 1
    jump = found.jumps[0]
    both = np.flatnonzero(count == 2)
    assert both[0] - 1 <= jump.index <= both[-1]
    steps = np.diff(found.q, axis=0)
    assert int(np.argmax(np.abs(steps).max(axis=1))) == jump.index
    assert jump.size == pytest.approx(steps[jump.index, nao.joint_names.index(jump.joint)])
    assert jump.limb == "LArm"
    assert "its branch ends at sample" in jump.cause
    assert not found.success
    assert jump.describe() in found.message
    # No other place for one jump is cheaper: every switch from the branch before to the branch behind.
    left, right = one_branch(nao, T[: both[-1] + 1]), one_branch(nao, T[both[0] :][::-1])[::-1]
    costs = {
        i: squared_motion(nao, np.concatenate([left[: i + 1], right[i + 1 - both[0] :]]))
        for i in range(both[0] - 1, both[-1] + 1)
    }
    assert len(costs) > 10
    assert found.motion == pytest.approx(min(costs.values()), rel=1e-9)
    assert jump.index == min(costs, key=lambda i: costs[i])


def test_ways_of_the_joints_have_no_jumps_however_coarse(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(31)
    for n in (6, 11, 101):
        for effector in ("LLeg", "RArm"):
            q = way(nao, rng, n)
            found = nk.ik.follow(nao, {effector: nao.fk(q, effector)}, near=q)
            assert found.jumps == ()


def test_a_knee_that_goes_through_straight_does_not_jump(nao: nk.NaoModel) -> None:
    bent = nao.configuration({"LHipPitch": -0.4, "LKneePitch": 0.8, "LAnklePitch": -0.4})
    through = nao.configuration({"LHipPitch": 0.02, "LKneePitch": -0.05, "LAnklePitch": 0.03})
    for n in (9, 50, 400):
        found = nk.ik.follow(nao, {"LLeg": nao.fk(line(bent, through, n), "LLeg")})
        assert found.success, found.message


def test_other_joints_of_the_reference_do_not_make_jumps(nao: nk.NaoModel) -> None:
    T, _, _ = crossing(nao, 2)
    reference = np.tile(nao.clamp(nao.neutral()), (len(T), 1))
    reference[:, 0] = 0.5 * (-1.0) ** np.arange(len(T))
    path = {"LArm": T[:, :3, 3]}
    alone = nk.ik.follow(nao, path, directions={"LArm": T[:, :3, 0]}, near=reference[0])
    found = nk.ik.follow(nao, path, directions={"LArm": T[:, :3, 0]}, near=reference)
    assert found.jumps == alone.jumps
    assert len(found.jumps) == 1


def test_a_target_that_leaps_is_no_jump_of_the_branches(nao: nk.NaoModel) -> None:
    q = nao.posture("StandInit")
    T = np.tile(nao.fk(q, "LLeg"), (4, 1, 1))
    T[2:, 2, 3] += 0.05
    assert nk.ik.follow(nao, {"LLeg": T}, near=q).jumps == ()


# --- what is not reached ----------------------------------------------------------------------------------------------


def test_samples_beyond_a_limit_are_reported_and_only_these(nao: nk.NaoModel) -> None:
    inside = nao.configuration({"LHipPitch": -0.4, "LKneePitch": 1.9, "LAnklePitch": -0.4})
    outside = np.array(inside)
    outside[nao.joint_names.index("LKneePitch")] = 2.3
    q = line(inside, outside, 21)
    found = nk.ik.follow(nao, {"LLeg": nao.fk(q, "LLeg")}, near=inside)
    limit = nao.upper[nao.joint_names.index("LKneePitch")]
    beyond = q[:, nao.joint_names.index("LKneePitch")] > limit
    np.testing.assert_array_equal(found.reached, ~beyond)
    assert (found.reasons["LLeg"][beyond] == Reason.JOINT_LIMIT).all()
    first = int(np.argmax(beyond))
    assert f"LLeg does not reach sample {first} and {beyond.sum() - 1} more: LKneePitch needs" in found.message
    assert set(found.limbs[0].messages) == set(np.flatnonzero(beyond))
    columns = list(found.limbs[0].columns)
    assert nao.within_limits(found.q).all()  # at the nearest pose
    np.testing.assert_allclose(found.q[beyond][:, columns[3]], limit, atol=0.02)
    assert (found.limbs[0].residual[beyond, 0] < 0.05).all()
    assert np.isfinite(found.sampled(50.0)).all()


def test_a_limb_without_any_value_cannot_be_played(nao: nk.NaoModel, monkeypatch: pytest.MonkeyPatch) -> None:
    solve = limb_paths.leg

    def leg(*arguments: Any, **options: Any) -> nk.ik.IKResult:
        found = solve(*arguments, **options)
        return dataclasses.replace(found, best=np.full(found.best.shape, np.nan))

    monkeypatch.setattr(limb_paths, "leg", leg)
    T = np.tile(np.eye(4), (3, 1, 1))
    T[:, 2, 3] = -2.0
    found = nk.ik.follow(nao, {"LLeg": T})
    assert not found.reached.any()
    assert (found.reasons["LLeg"] == Reason.OUT_OF_REACH).all()
    with pytest.raises(BadArgument, match="LLeg has no values at any sample.*out of reach"):
        found.sampled()


def test_a_path_begins_where_its_solver_first_has_values(nao: nk.NaoModel, monkeypatch: pytest.MonkeyPatch) -> None:
    solve = limb_paths.arm

    def arm(robot: nk.RobotModel, side: str, target: Floats, **options: Any) -> nk.ik.IKResult:
        found = solve(robot, side, target, **options)
        far = target[:, 0] > 1.0
        return dataclasses.replace(found, best=np.where(far[:, None], np.nan, found.best))

    monkeypatch.setattr(limb_paths, "arm", arm)
    q = nao.posture("StandInit")
    places = np.tile(nao.position(q, "LArm"), (4, 1))
    places[:2, 0] = 5.0
    found = nk.ik.follow(nao, {"LArm": places}, near=q)
    assert list(found.reached) == [False, False, True, True]
    np.testing.assert_allclose(nao.position(found.q[2:], "LArm"), places[2:], atol=1e-10)
    assert np.isnan(found.q[:2, list(found.limbs[0].columns)]).all()


def test_a_hand_that_five_joints_do_not_place_goes_to_the_nearest_pose(nao: nk.NaoModel) -> None:
    q = nao.posture("StandInit")
    T = np.tile(nao.fk(q, "LArm"), (6, 1, 1))
    T[:, 0, 3] += np.linspace(0.0, 0.02, 6)
    found = nk.ik.follow(nao, {"LArm": T}, near=q)
    assert list(found.reached) == [True, *[False] * 5]
    assert np.isfinite(found.q).all()
    assert "5 joints do not make this pose; the nearest pose is off" in found.limbs[0].messages[5]
    away = np.linalg.norm(nao.fk(found.q, "LArm")[:, :3, 3] - T[:, :3, 3], axis=1)
    np.testing.assert_allclose(found.limbs[0].residual[:, 0], away, atol=1e-9)


# --- times and speeds -------------------------------------------------------------------------------------------------


def test_segments_that_are_too_fast_are_stretched_and_no_others(nao: nk.NaoModel) -> None:
    q = nao.posture("StandInit")
    T = swinging(nao, "LLeg", 41)
    times = 3.0 + np.linspace(0.0, 1.0, 41)
    times[20:] -= 0.0245  # the twentieth segment has 0.5 ms
    found = nk.ik.follow(nao, {"LLeg": T}, near=q, times=times)
    assert [segment.index for segment in found.stretched] == [19]
    given, taken = np.diff(times), np.diff(found.times)
    step = np.abs(np.diff(found.q, axis=0)) / nao.velocity_limits
    np.testing.assert_allclose(taken, np.maximum(given, step.max(axis=1)), rtol=1e-9)
    segment = found.stretched[0]
    assert segment.given == pytest.approx(0.0005)
    assert segment.needed == pytest.approx(step[19].max())
    assert segment.joint == nao.joint_names[int(np.argmax(step[19]))]
    assert segment.describe() in found.message
    assert found.times[0] == 3.0
    assert found.largest_speed_share == pytest.approx(1.0)
    np.testing.assert_allclose(found.speed_shares, step / taken[:, None], rtol=1e-9)


def test_times_that_suffice_are_kept_to_the_bit(nao: nk.NaoModel) -> None:
    times = np.linspace(0.0, 2.0, 41)
    found = nk.ik.follow(nao, {"LLeg": swinging(nao, "LLeg", 41)}, times=times)
    np.testing.assert_array_equal(found.times, times)
    assert found.stretched == ()
    assert found.largest_speed_share < 1.0


@pytest.mark.parametrize("speed", [1.0, 0.25, 2.0])
def test_without_times_the_least_are_taken(nao: nk.NaoModel, speed: float) -> None:
    found = nk.ik.follow(nao, {"RLeg": swinging(nao, "RLeg", 30)}, speed=speed)
    step = np.abs(np.diff(found.q, axis=0)) / nao.velocity_limits
    np.testing.assert_allclose(np.diff(found.times), step.max(axis=1) / speed, rtol=1e-9, atol=1e-12)
    assert found.largest_speed_share == pytest.approx(speed)
    assert found.stretched == ()


def test_joints_of_the_reference_keep_their_limits_too(nao: nk.NaoModel) -> None:
    reference = np.tile(nao.posture("StandInit"), (3, 1))
    reference[:, 0] = [0.0, 1.0, 0.0]
    found = nk.ik.follow(nao, {"LLeg": nao.fk(reference[0], "LLeg")}, near=reference)
    np.testing.assert_allclose(np.diff(found.times), 1.0 / nao.velocity_limits[0])


def test_sampled_steps_are_equal_and_no_faster(nao: nk.NaoModel) -> None:
    found = nk.ik.follow(nao, {"LLeg": swinging(nao, "LLeg", 30)}, speed=0.5)
    frames = found.sampled(200.0)
    assert len(frames) == math.ceil(found.duration * 200.0) + 1
    np.testing.assert_array_equal(frames[0], found.q[0])
    np.testing.assert_allclose(frames[-1], found.q[-1], atol=1e-12)
    assert (np.abs(np.diff(frames, axis=0)) * 200.0 <= 0.5 * nao.velocity_limits * (1.0 + 1e-9)).all()
    at = np.arange(len(frames) - 1) / 200.0
    expected = [np.interp(at, found.times, found.q[:, column]) for column in range(nao.nq)]
    np.testing.assert_allclose(frames[:-1], np.stack(expected, axis=1), atol=1e-12)
    with nk.Viewer(nao) as viewer:
        viewer.animate(frames, 200.0)


def test_sampled_turns_the_base_at_constant_speed() -> None:
    nao = nk.load_nao("v6", base="floating")
    torso = np.tile(np.eye(4), (2, 1, 1))
    torso[1, :3, :3] = rot_z(1.0)
    torso[1, :3, 3] = [0.1, 0.0, 0.0]
    q = nao.posture("StandInit")
    T = torso @ nao.fk(q, "LArm", reference="torso")
    found = nk.ik.follow(nao, {"LArm": T[:, :3, 3]}, torso=torso, times=[0.0, 1.0], near=q)
    frames = found.sampled(4.0)
    np.testing.assert_allclose(frames[:, 0], [0.0, 0.025, 0.05, 0.075, 0.1], atol=1e-12)
    for frame, angle in zip(frames, [0.0, 0.25, 0.5, 0.75, 1.0], strict=True):
        np.testing.assert_allclose(nao.rotation(frame, "torso"), rot_z(angle), atol=1e-9)


# --- the script -------------------------------------------------------------------------------------------------------


@pytest.mark.full
def test_the_script_walks_and_draws_and_writes_a_clip(tmp_path: Path) -> None:
    root = Path(__file__).resolve().parents[2]
    command = [sys.executable, str(root / "scripts" / "walk_and_draw.py"), "--html", "walk.html"]
    environment = {**os.environ, "PYTHONPATH": str(root)}
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    answers = [line.split()[0] for line in done.stdout.splitlines() if line.startswith("  ")]
    assert answers == ["yes"] * 12
    clip = tmp_path / "walk.html"
    assert 1_000_000 < clip.stat().st_size < 2_700_000  # a page of 2.5 MB, and what moves in it


# --- small and wrong input --------------------------------------------------------------------------------------------


def test_a_single_sample_is_solved_as_by_itself(nao: nk.NaoModel) -> None:
    q = nao.posture("StandInit")
    T = nao.fk(q, "LLeg")
    for targets in (T, T[None]):
        found = nk.ik.follow(nao, {"LLeg": targets}, near=q)
        np.testing.assert_allclose(found.q, q[None], atol=1e-9)
        assert found.duration == 0.0
        assert found.sampled(30.0).shape == (1, nao.nq)
        assert "1 of 1 sample reached" in repr(found)


def test_a_reference_beyond_a_coupled_limit_goes_to_the_nearest_point(nao: nk.NaoModel) -> None:
    """As everywhere in inverse kinematics; `clamp` would keep the yaw of the head, on which its pitch depends."""
    reference = nao.configuration({"HeadYaw": 1.0, "HeadPitch": 0.5}, limits="ignore")
    nearest, notes = checked_reference(nao, reference, True)
    assert np.abs(nearest - nao.clamp(reference)).max() > 0.01
    T = swinging(nao, "LLeg", 3)
    found = nk.ik.follow(nao, {"LLeg": T}, near=reference)
    np.testing.assert_allclose(found.q[:, :2], np.tile(nearest[:2], (3, 1)), atol=1e-12)
    assert found.notes == notes
    several = np.stack([nearest, reference, reference])
    found = nk.ik.follow(nao, {"LLeg": T}, near=several)
    np.testing.assert_allclose(found.q[:, :2], np.tile(nearest[:2], (3, 1)), atol=1e-12)
    assert found.notes[0].endswith("(configuration 1)")


def test_a_followed_path_is_stored_and_copied(nao: nk.NaoModel) -> None:
    T = np.tile(np.eye(4), (3, 1, 1))
    T[:, 2, 3] = -2.0
    found = nk.ik.follow(nao, {"LLeg": T, "CameraTop": [1.0, 0.0, 0.0]})
    for other in (pickle.loads(pickle.dumps(found)), copy.deepcopy(found)):
        np.testing.assert_array_equal(other.q, found.q)
        assert other.message == found.message
        assert other.limbs[0].messages == found.limbs[0].messages


def test_wrong_paths_are_refused_with_effector_and_sample(nao: nk.NaoModel) -> None:
    T = swinging(nao, "LLeg", 5)
    with pytest.raises(UnknownName, match=r"effector 'LLag' \(nearest: LLeg"):
        nk.ik.follow(nao, {"LLag": T})
    arm = nk.load_robot("ur10_robot")
    with pytest.raises(UnknownName, match=r"effector 'tool0' \(there are none\); ur10 needs nk\.ik\.numeric"):
        nk.ik.follow(arm, {"tool0": T})
    with pytest.raises(BadArgument, match="path names no effector"):
        nk.ik.follow(nao, {})
    with pytest.raises(BadArgument, match=r"path\['LLeg'\] has no samples"):
        nk.ik.follow(nao, {"LLeg": T[:0]})
    with pytest.raises(BadArgument, match=r"path\['LLeg'\] has 5 samples and path\['RArm'\] has 4"):
        nk.ik.follow(nao, {"LLeg": T, "RArm": T[:4]})
    with pytest.raises(BadArgument, match=r"path\['LLeg'\] has 5 samples and torso has 2"):
        nk.ik.follow(nao, {"LLeg": T}, torso=T[:2])
    with pytest.raises(WrongShape, match=r"path\['LLeg'\] must have shape \(n, 4, 4\), or \(4, 4\)"):
        nk.ik.follow(nao, {"LLeg": T[:, :3, 3]})
    with pytest.raises(WrongShape, match=r"path\['Head'\] must have shape \(n, 3, 3\)"):
        nk.ik.follow(nao, {"Head": T})
    with pytest.raises(BadArgument, match="both move the head"):
        nk.ik.follow(nao, {"Head": np.eye(3), "CameraTop": [1.0, 0.0, 0.0]})
    stretched = T.copy()
    stretched[3, :3, :3] *= 1.01
    with pytest.raises(NotARotation, match=r"path\['LLeg'\]: not a rotation matrix at index \[3\]"):
        nk.ik.follow(nao, {"LLeg": stretched})


def test_wrong_times_and_options_are_refused(nao: nk.NaoModel) -> None:
    T = swinging(nao, "LLeg", 4)
    with pytest.raises(BadArgument, match=r"times must increase, got 0.2 and then 0.2 at index \[2\]"):
        nk.ik.follow(nao, {"LLeg": T}, times=[0.0, 0.2, 0.2, 0.3])
    with pytest.raises(BadArgument, match="times has 3"):
        nk.ik.follow(nao, {"LLeg": T}, times=[0.0, 0.2, 0.3])
    with pytest.raises(NotFinite, match="times"):
        nk.ik.follow(nao, {"LLeg": T}, times=[0.0, 0.2, math.nan, 0.3])
    for speed in (0.0, -1.0):
        with pytest.raises(BadArgument, match="speed must be positive"):
            nk.ik.follow(nao, {"LLeg": T}, speed=speed)
    with pytest.raises(BadArgument, match="free requires torso"):
        nk.ik.follow(nao, {"LLeg": T}, free="lean")
    with pytest.raises(BadArgument, match="rate"):
        nk.ik.follow(nao, {"LLeg": T}).sampled(0.0)
    with pytest.raises(UnknownName, match="unknown priority"):
        nk.ik.follow(nao, {"LLeg": T}, priority="both")  # type: ignore[arg-type]
    with pytest.raises(UnknownName, match="effector of the path"):
        nk.ik.follow(nao, {"LLeg": T}, frames={"RLeg": "RFoot"})


def test_wrong_directions_are_refused(nao: nk.NaoModel) -> None:
    places = swinging(nao, "LArm", 4)[:, :3, 3]
    with pytest.raises(UnknownName, match="arm 'RArm'"):
        nk.ik.follow(nao, {"LArm": places}, directions={"RArm": [1.0, 0.0, 0.0]})
    with pytest.raises(BadArgument, match="a pose includes a direction"):
        nk.ik.follow(nao, {"LArm": swinging(nao, "LArm", 4)}, directions={"LArm": [1.0, 0.0, 0.0]})
    zero = np.ones((4, 3))
    zero[2] = 0.0
    with pytest.raises(ZeroNorm, match=r"directions\['LArm'\] must not be zero at index \[2\]"):
        nk.ik.follow(nao, {"LArm": places}, directions={"LArm": zero})
