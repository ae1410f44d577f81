from __future__ import annotations

import math

import numpy as np
import pytest
from ik_checks import BESIDE, Floats, assert_solved, derivatives, distance_to_solutions, pose_errors
from loops import for_all

import nao_kin as nk
from nao_kin.errors import BadArgument, UnknownName, WrongShape, ZeroNorm
from nao_kin.ik import Family, Reason
from nao_kin.ik.follow_branches import _cause
from nao_kin.ik.follow_limbs import LimbPath
from nao_kin.rotations import exp, log, matrix_from_quat

SIDES = ("L", "R")


def bent(nao: nk.NaoModel, side: str, **angles: float) -> Floats:
    """A configuration with a bent arm, some of its joints as given; for a right arm mirrored."""
    values = {"ShoulderPitch": 0.4, "ShoulderRoll": 0.3, "ElbowYaw": -0.6, "ElbowRoll": -0.7, "WristYaw": 0.2} | angles
    sign = 1.0 if side == "L" else -1.0
    turned = {joint: value * (1.0 if joint == "ShoulderPitch" else sign) for joint, value in values.items()}
    return nao.configuration({side + joint: value for joint, value in turned.items()}, limits="ignore")


@for_all("side", SIDES)
def test_every_configuration_is_among_the_solutions_of_its_pose(each_nao: nk.NaoModel, side: str) -> None:
    q = each_nao.random(7, 4000)
    T = each_nao.fk(q, side + "Arm")
    found = nk.ik.arm(each_nao, side, T)
    assert_solved(each_nao, side + "Arm", T, found)
    assert np.array_equal(nk.ik.arm(each_nao, side + "Arm", T).q, found.q)
    assert distance_to_solutions(found, q).max() < 1e-9


@for_all("side", SIDES)
def test_without_limits_there_are_four_branches(each_nao: nk.NaoModel, side: str) -> None:
    T = each_nao.fk(each_nao.random(3, 500), side + "Arm")
    found = nk.ik.arm(each_nao, side, T, limits="ignore")
    assert_solved(each_nao, side + "Arm", T, found, inside=False)
    assert (found.count == 4).all()


@pytest.mark.full
def test_all_solutions_of_an_exhaustive_search_are_found(nao: nk.NaoModel) -> None:
    optimize = pytest.importorskip("scipy.optimize")
    rng = np.random.default_rng(11)
    q = nao.random(rng)
    T = nao.fk(q, "LArm")
    for direction in (False, True):
        options = {"direction": T[:3, 0]} if direction else {}
        found = nk.ik.arm(nao, "L", T[:3, 3] if direction else T, limits="ignore", **options)
        columns, part = list(found.columns), np.s_[..., :3, [0, 3]] if direction else np.s_[..., :3, :]

        def error(values: Floats, part: object = part, columns: list[int] = columns) -> Floats:
            there = np.zeros((*values.shape[:-1], 25))
            there[..., columns] = np.mod(values + math.pi, 2 * math.pi) - math.pi
            return (nao.fk(there, "LArm") - T)[part].reshape(*values.shape[:-1], -1)  # type: ignore[index]

        seen = set()
        for start in rng.uniform(-math.pi, math.pi, (150, 5)):
            end = optimize.least_squares(error, start, derivatives(error), xtol=1e-14, ftol=1e-14, gtol=1e-14)
            if end.cost < 1e-20:
                gaps = np.abs(np.mod(found.branches - end.x + math.pi, 2 * math.pi) - math.pi).max(axis=-1)
                assert gaps.min() < 1e-6, end.x
                seen.add(int(np.argmin(gaps)))
        assert len(seen) == found.count == (8 if direction else 4)


@for_all("side", SIDES)
def test_a_place_and_a_direction_bring_the_configuration_back(each_nao: nk.NaoModel, side: str) -> None:
    q = each_nao.random(8, 3000)
    T = each_nao.fk(q, side + "Arm")
    found = nk.ik.arm(each_nao, side, T[:, :3, 3], direction=7.0 * T[:, :3, 0])
    assert np.all(found.success)
    assert distance_to_solutions(found, q).max() < 1e-7
    for k in range(found.branches.shape[1]):
        real = found.count > k
        made = each_nao.fk(found.solutions[real, k], side + "Arm")
        assert np.abs(made[:, :3, [0, 3]] - T[real][:, :3, [0, 3]]).max() < 1e-10
        assert each_nao.within_limits(found.solutions[real, k]).all()


@pytest.mark.full
@for_all("side", SIDES)
@for_all("criterion", ["nearest", "limits", "manipulability"])
def test_every_place_that_the_hand_can_be_is_found(each_nao: nk.NaoModel, side: str, criterion: str) -> None:
    q = each_nao.random(9, 30)
    places = each_nao.position(q, side + "Arm")
    found = nk.ik.arm(each_nao, side, places, criterion=criterion)  # type: ignore[arg-type]
    assert np.all(found.success)
    assert np.all(found.family == Family.REDUNDANT)
    assert np.abs(each_nao.position(found.q, side + "Arm") - places).max() < 1e-10
    assert each_nao.within_limits(found.q).all()


def margin(nao: nk.NaoModel, q: Floats, columns: list[int]) -> Floats:
    """Distance to the nearest limit as a share of the range."""
    low, high = nao.lower[columns], nao.upper[columns]
    return np.asarray((np.minimum(q[..., columns] - low, high - q[..., columns]) / (high - low)).min(axis=-1))


def test_the_criterion_decides_which_member_it_is(nao: nk.NaoModel) -> None:
    q = nao.random(10, 40)
    places = nao.position(q, "LArm")
    near, far, strong = (
        nk.ik.arm(nao, "L", places, criterion=name, near=None)  # type: ignore[arg-type]
        for name in ("nearest", "limits", "manipulability")
    )
    columns = list(near.columns)
    reference = near.near[columns]

    def away(row: Floats) -> Floats:
        return np.asarray(np.linalg.norm(row[..., columns] - reference, axis=-1))

    def ability(row: Floats) -> Floats:
        J = nao.jacobian(row, "LArm")[..., :3, nk.ik.arm(nao, "L", places[0]).columns]
        return np.asarray(np.sqrt(np.linalg.det(J @ J.swapaxes(-1, -2))))

    # Better than the member of the place that is known, and than those of the other criteria.
    for other in (q, far.q, strong.q):
        assert (away(near.q) <= away(other) + 1e-6).all()
    for other in (q, near.q, strong.q):
        assert (margin(nao, far.q, columns) >= margin(nao, other, columns) - 1e-6).all()
    for other in (q, near.q, far.q):
        assert (ability(strong.q) >= ability(other) - 1e-9).all()


def test_a_place_is_answered_by_the_reference_that_is_there(nao: nk.NaoModel) -> None:
    q = nao.random(11, 100)
    found = nk.ik.arm(nao, "R", nao.position(q, "RArm"), near=q)
    np.testing.assert_allclose(found.q, q, atol=1e-8)


@for_all("beside", BESIDE)
@for_all("side", SIDES)
def test_a_stretched_arm_and_beside_it(each_nao: nk.NaoModel, side: str, beside: float) -> None:
    for sign in (1.0, -1.0):
        q = bent(each_nao, side, ElbowRoll=sign * beside)
        T = each_nao.fk(q, side + "Arm")
        found = nk.ik.arm(each_nao, side, T, limits="ignore", near=q)
        assert_solved(each_nao, side + "Arm", T, found, inside=False)
        assert distance_to_solutions(found, q) < (1e-11 if beside < 1e-12 else 2e-15 / beside + 1e-12)
        if beside < 1e-13:
            assert found.family is Family.ELBOW_LOCK
            assert found.count == 2 + (found.families == Family.NONE).sum() / 2


@for_all("beside", BESIDE)
def test_an_elbow_on_the_axis_of_the_shoulder_and_beside_it(beside: float) -> None:
    # In V3.2 there is no offset at the elbow: the arm spread out, which is inside its limits.
    nao = nk.load_nao("v3.2")
    for sign in (1.0, -1.0):
        q = bent(nao, "L", ShoulderRoll=math.pi / 2 + sign * beside)
        T = nao.fk(q, "LArm")
        for limits in ("enforce", "ignore"):
            found = nk.ik.arm(nao, "L", T, near=q, limits=limits)
            assert_solved(nao, "LArm", T, found, inside=limits == "enforce")
            assert distance_to_solutions(found, q) < (1e-9 if beside < 1e-11 else 1e-15 / beside + 1e-9)
            if beside < 1e-13:
                assert found.family is Family.SHOULDER_AXIS


def test_a_pose_that_five_joints_do_not_make_gets_the_nearest(nao: nk.NaoModel) -> None:
    optimize = pytest.importorskip("scipy.optimize")
    rng = np.random.default_rng(12)
    q = nao.random(rng, 10)
    T = nao.fk(q, "LArm")
    T[:, :3, 3] += rng.normal(scale=0.01, size=(10, 3))
    found = nk.ik.arm(nao, "L", T)
    assert not np.any(found.success)
    assert (found.reason == Reason.NOT_ENOUGH_JOINTS).all() or Reason.OUT_OF_REACH in found.reason
    assert nao.within_limits(found.q).all()
    np.testing.assert_allclose(pose_errors(nao.fk(found.q, "LArm"), T), found.residual, rtol=0, atol=1e-9)
    costs = np.hypot(found.residual[:, 0], 0.1 * found.residual[:, 1])
    columns = list(found.columns)
    low, high = nao.lower[columns], nao.upper[columns]
    for i in range(10):

        def error(values: Floats, T: Floats = T[i]) -> Floats:
            there = np.zeros(25)
            there[columns] = values
            made = nao.fk(there, "LArm")
            return np.concatenate([made[:3, 3] - T[:3, 3], 0.1 * log(made[:3, :3] @ T[:3, :3].T)])

        starts = [found.q[i, columns], q[i, columns], *rng.uniform(low, high, (6, 5))]
        ends = [optimize.least_squares(error, start, bounds=(low, high), xtol=1e-12, ftol=1e-12) for start in starts]
        best = min(math.sqrt(2.0 * end.cost) for end in ends)
        assert costs[i] < best + 1e-7, (costs[i], best)


def test_a_position_out_of_the_limits_gets_the_nearest_not_a_local_minimum() -> None:
    optimize = pytest.importorskip("scipy.optimize")
    old = nk.load_nao("v3.2")  # the smallest ranges
    places = np.array([[0.045, 0.205, 0.029], [-0.013, 0.199, 0.048], [0.046, 0.195, 0.098], [-0.076, 0.217, 0.082]])
    found = nk.ik.arm(old, "L", places)
    assert not np.any(found.success)
    columns = list(found.columns)
    low, high = old.lower[columns], old.upper[columns]
    rng = np.random.default_rng(3)

    def posed(values: Floats) -> Floats:
        q = np.zeros(old.nq)
        q[columns] = values
        return q

    def slopes(values: Floats) -> Floats:
        return old.jacobian(posed(values), "LArm", expressed_in="mixed")[:3, columns]

    for place, residual in zip(places, found.residual[:, 0], strict=True):

        def error(values: Floats, place: Floats = place) -> Floats:
            return old.position(posed(values), "LArm") - place

        starts = rng.uniform(low, high, (16, 5))
        ends = [optimize.least_squares(error, start, slopes, bounds=(low, high)) for start in starts]
        assert residual < min(math.sqrt(2.0 * end.cost) for end in ends) + 1e-6


@for_all("beyond", [1e-9, 1e-3, 1.0])
def test_out_of_reach_is_said_with_the_distance_and_the_nearest(nao: nk.NaoModel, beyond: float) -> None:
    rng = np.random.default_rng(1)
    quaternions = rng.normal(size=(20, 4))
    hand = np.array([0.05595 + 0.05775, 0.0, -0.01231])
    reach = math.hypot(0.105, 0.015) + float(np.linalg.norm(hand))
    directions = rng.normal(size=(20, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    T = np.tile(np.eye(4), (20, 1, 1))
    T[:, :3, :3] = matrix_from_quat(quaternions / np.linalg.norm(quaternions, axis=1)[:, None])
    T[:, :3, 3] = nao.position(nao.neutral(), "LShoulderPitch") + (reach + beyond) * directions
    answers = [
        nk.ik.arm(nao, "L", T),
        nk.ik.arm(nao, "L", T[:, :3, 3]),
        nk.ik.arm(nao, "L", T[:, :3, 3], direction=directions),
    ]
    for found in answers:
        assert (found.reason == Reason.OUT_OF_REACH).all()
        np.testing.assert_allclose(found.obstacles.needed, beyond, rtol=0, atol=1e-15)
        assert nao.within_limits(found.q).all()
        assert (found.residual[:, 0] >= 0.999 * beyond).all()
        assert not np.isnan(found.residual).any()
    assert nk.ik.arm(nao, "L", T[0]).count == 0


@for_all("version", ["v3.2", "v6"])
@for_all("inside", [1e-9, 1e-3])
def test_a_place_inside_the_fold_is_out_of_reach(version: str, inside: float) -> None:
    nao = nk.load_nao(version)
    shoulder = nao.position(nao.neutral(), "LShoulderPitch")
    folded = nao.position(nao.neutral(), "LElbowYaw") - shoulder, nao.position(nao.neutral(), "LArm")
    elbow = nao.position(nao.neutral(), "LElbowYaw")
    upper, lower = float(np.linalg.norm(folded[0])), float(np.linalg.norm(folded[1] - elbow))
    far = abs(upper - lower) - inside
    place = shoulder + far * np.array([0.6, 0.0, 0.8])
    T = np.eye(4)
    T[:3, 3] = place
    for found in (nk.ik.arm(nao, "L", place), nk.ik.arm(nao, "L", T), nk.ik.arm(nao, "L", place, direction=[1, 0, 0])):
        assert found.reason is Reason.OUT_OF_REACH
        assert float(found.obstacles.needed) == pytest.approx(inside, abs=1e-12)


@pytest.mark.full
@for_all("criterion", ["limits", "nearest", "manipulability"])
def test_no_member_of_a_random_choice_is_better(nao: nk.NaoModel, criterion: str) -> None:
    rng = np.random.default_rng(21)
    places, reference = nao.position(nao.random(rng, 20), "LArm"), nao.random(rng, 20)
    found = nk.ik.arm(nao, "L", places, criterion=criterion, near=reference)  # type: ignore[arg-type]
    columns = list(found.columns)

    def worth(q: Floats, near: Floats) -> Floats:
        if criterion == "limits":
            return margin(nao, q, columns)
        if criterion == "nearest":
            return np.asarray(-np.square(q - near)[..., columns].sum(axis=-1))
        J = nao.jacobian(q, "LArm")[..., :3, columns]
        return np.asarray(np.sqrt(np.linalg.det(J @ J.swapaxes(-1, -2))))

    # From other references the search begins elsewhere.
    best = np.full(20, -np.inf)
    for _ in range(12):
        other = nk.ik.arm(nao, "L", places, criterion=criterion, near=nao.random(rng, 20))  # type: ignore[arg-type]
        best = np.maximum(best, worth(np.where(np.isnan(other.q), found.q, other.q), reference))
    slack = {"limits": 1e-4, "nearest": 1e-3, "manipulability": 1e-5}[criterion]
    assert (worth(found.q, reference) >= best - slack).all()


def test_of_poses_far_away_no_random_start_ends_nearer(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(5)
    T = nao.fk(nao.random(rng, 60), "LArm")
    T[:, :3, 3] += 0.5 * rng.normal(size=(60, 3))
    T[:, :3, :3] = T[:, :3, :3] @ exp(rng.normal(size=(60, 3)))
    found = nk.ik.arm(nao, "L", T)
    cost = np.square(found.residual * [1.0, 0.1]).sum(axis=-1)
    for _ in range(3):
        other = nk.ik.arm(nao, "L", T, near=nao.random(rng, 60))
        assert (cost <= np.square(other.residual * [1.0, 0.1]).sum(axis=-1) * (1.0 + 1e-4) + 1e-15).all()


def test_a_message_says_what_is_in_the_way(nao: nk.NaoModel) -> None:
    far = nk.ik.arm(nao, "L", nao.fk(bent(nao, "L", WristYaw=2.0), "LArm"))
    assert far.reason is Reason.JOINT_LIMIT
    assert str(far.message).startswith("LWristYaw needs 2 rad, limit 1.82; the nearest pose is off by")
    assert nao.within_limits(far.q).all()
    impossible = np.eye(4)
    impossible[:3, 3] = [0.15, 0.1, 0.1]
    said = nk.ik.arm(nao, "L", impossible)
    assert said.reason is Reason.NOT_ENOUGH_JOINTS
    assert str(said.message).startswith("5 joints do not make this pose; the nearest pose is off by")
    behind = nk.ik.arm(nao, "L", [-0.19, 0.098, 0.1])
    assert behind.reason is Reason.JOINT_LIMIT
    assert "needs" in str(behind.message)
    millimetres = nk.ik.arm(nao, "L", [150.0, 98.0, 100.0])
    assert "targets are in metres" in str(millimetres.message)


def test_any_frame_on_the_hand_may_be_asked_for(nao: nk.NaoModel) -> None:
    q = nao.random(12, 100)
    frame = "LWristYaw"
    T = nao.fk(q, frame)
    assert_solved(nao, frame, T, nk.ik.arm(nao, "L", T, frame=frame))
    with pytest.raises(BadArgument, match="not carried by LWristYaw"):
        nk.ik.arm(nao, "L", T[0], frame="LHipRoll")


def test_bad_targets_are_refused(nao: nk.NaoModel) -> None:
    T = nao.fk(nao.random(16, 3), "LArm")
    with pytest.raises(BadArgument, match="a pose .* includes a direction"):
        nk.ik.arm(nao, "L", T, direction=[1.0, 0.0, 0.0])
    with pytest.raises(WrongShape, match=r"\(\.\.\., 4, 4\) for poses or \(\.\.\., 3\) for positions"):
        nk.ik.arm(nao, "L", np.zeros(4))
    with pytest.raises(ZeroNorm, match=r"direction must not be zero at index \[1\]"):
        nk.ik.arm(nao, "L", T[:2, :3, 3], direction=[[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    with pytest.raises(WrongShape, match="direction"):
        nk.ik.arm(nao, "L", T[:2, :3, 3], direction=np.ones((3, 3)))
    with pytest.raises(UnknownName, match="manipulability"):
        nk.ik.arm(nao, "L", T[0, :3, 3], criterion="manipulabilty")  # type: ignore[arg-type]


def test_the_elbow_must_be_that_of_a_nao() -> None:
    nao = nk.load_nao("v6")
    nao.model.jointPlacements[nao.model.getJointId("LElbowYaw")].translation = np.array([0.105, 0.015, 0.002])
    with pytest.raises(BadArgument, match=r"no arm that the closed form fits: the elbow is out of the plane"):
        nk.ik.arm(nao, "L", np.eye(4))


def test_a_direction_may_have_any_length(nao: nk.NaoModel) -> None:
    q = nao.random(31, 4).reshape(4, 1, 25)
    place, direction = nao.position(q, "LArm"), nao.rotation(q, "LArm")[..., 0]
    lengths = np.array([1e-200, 1e-3, 1.0, 1e200]).reshape(4, 1, 1)
    found = nk.ik.arm(nao, "L", place, direction=lengths * direction, near=q)
    assert found.success.shape == q.shape[:-1]  # type: ignore[union-attr]
    np.testing.assert_allclose(found.q, q, rtol=0, atol=1e-6)


def test_by_the_middle_of_the_limits_a_joint_stays_in_its_range_without_limits(nao: nk.NaoModel) -> None:
    reference = nao.configuration({"LShoulderPitch": 3.0, "LElbowYaw": 3.0}, limits="ignore")
    place = nao.position(nao.posture("StandInit"), "LArm")
    free = nk.ik.arm(nao, "L", place, criterion="limits", limits="ignore", near=reference)
    found = nk.ik.arm(nao, "L", place, criterion="limits", near=reference)
    columns = [nao.joint_names.index(name) for name in nao.chains["LArm"][:5]]
    lower, upper = nao.lower[columns], nao.upper[columns]
    shares = [np.minimum(q - lower, upper - q) / (upper - lower) for q in (free.best, found.best)]
    # The ridge along which the least of them is largest is so flat that the joints themselves differ by 2e-3.
    np.testing.assert_allclose(shares[0].min(), shares[1].min(), rtol=0, atol=1e-6)
    assert min(map(np.min, shares)) > 0.36


def test_without_limits_they_end_no_branch_of_a_path(nao: nk.NaoModel) -> None:
    q = np.tile(nao.posture("StandInit"), (3, 1))
    q[:, nao.joint_names.index("LShoulderPitch")] = [2.0, 2.05, 2.2]
    targets = (nao.fk(q, "LArm"),)
    q[1:, nao.joint_names.index("LElbowYaw")] += 1.0  # another branch is taken up
    columns = list(nk.ik.arm(nao, "L", targets[0][0]).columns)
    causes = {
        limits: _cause(LimbPath(nao, "LArm", ("LArm",), targets, {"limits": limits}), q, 0, columns)
        for limits in ("enforce", "ignore")
    }
    assert "LShoulderPitch = 2.2 not in" in causes["enforce"]
    assert causes["ignore"].startswith("its branch continues")


def test_without_limits_a_path_across_half_a_turn_is_no_jump(nao: nk.NaoModel) -> None:
    q = np.tile(nao.posture("StandInit"), (21, 1))
    q[:, nao.joint_names.index("LShoulderPitch")] = np.linspace(3.0, 3.3, 21)
    found = nk.ik.follow(nao, {"LArm": nao.fk(q, "LArm")}, limits="ignore", near=q[0])
    assert found.jumps == ()
    np.testing.assert_allclose(found.q, q, rtol=0, atol=1e-9)
