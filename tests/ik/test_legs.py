from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from ik_checks import BESIDE, Floats, derivatives, distance_to_solutions, pose_errors
from legs_scan import least_turns, scanned
from loops import for_all
from scipy.optimize import least_squares

import nao_kin as nk
from nao_kin.errors import BadArgument, UnknownName, WrongShape
from nao_kin.ik import Family, LegsResult, Reason
from nao_kin.rotations import log, rot_x, rot_y, rot_z

FEET = ("LLeg", "RLeg")
HIP = "LHipYawPitch"


def feet_of(nao: nk.RobotModel, q: Floats) -> tuple[Floats, Floats]:
    """The poses of both feet in the torso."""
    T = nao.fk(q, list(FEET), reference="torso")
    return T[..., 0, :, :], T[..., 1, :, :]


def moved(nao: nk.NaoModel, q: Floats, **angles: float | Floats) -> Floats:
    """Configurations with other values of some joints."""
    q = np.array(q)
    for joint, value in angles.items():
        q[..., nao.joint_names.index(joint)] = value
    return q


def disagreeing(nao: nk.NaoModel, seed: int, count: int) -> tuple[Floats, Floats]:
    """Poses of feet with different values of HipYawPitch, some of their joints at limits."""
    rng = np.random.default_rng(seed)
    q, column = nao.random(rng, count), nao.joint_names.index(HIP)
    for row in q[::3]:
        joint = rng.choice([i for i, name in enumerate(nao.joint_names) if "Hip" in name or "Ankle" in name])
        row[joint] = rng.choice([nao.lower[joint], nao.upper[joint]])
    q = nao.clamp(q)
    other = q.copy()
    other[:, column] += rng.normal(size=count) * np.where(rng.random(count) < 0.5, 0.1, 1.0)
    return feet_of(nao, q)[0], feet_of(nao, nao.clamp(other))[1]


def turned(T: Floats, angle: float) -> Floats:
    """A foot that is turned about its normal."""
    turn = np.eye(4)
    turn[:3, :3] = rot_z(angle)
    return np.asarray(T @ turn)


def assert_met(nao: nk.RobotModel, T: tuple[Floats, Floats], found: LegsResult, *, inside: bool = True) -> None:
    """Both feet are met by every solution to 1e-10, inside the limits."""
    assert np.all(found.success), found
    solutions = found.solutions
    real = ~np.isnan(solutions).any(axis=-1)
    np.testing.assert_array_equal(real.sum(axis=-1), found.count)
    rows = solutions[real]
    for mine, wanted in zip(feet_of(nao, rows), T, strict=True):
        wanted = np.broadcast_to(wanted[..., None, :, :], (*real.shape, 4, 4))[real]
        assert pose_errors(mine, wanted).max() < 1e-10
    if inside:
        assert nao.within_limits(rows).all()
    assert max(found.residual.max(), found.foot_residuals.max(), np.abs(found.yaw_errors).max()) < 1e-10


def assert_level(nao: nk.NaoModel, T: tuple[Floats, Floats], found: LegsResult, *, inside: bool = True) -> None:
    """Check that ankles and normals are met, and that the reported turns of the feet are right."""
    known = ~np.isnan(found.yaw_errors).any(axis=-1)
    rows = found.q[known]
    sizes = []
    for side, (mine, wanted) in enumerate(zip(feet_of(nao, rows), (T[0][known], T[1][known]), strict=True)):
        errors = pose_errors(mine, wanted)
        assert errors[:, 0].max() < 1e-14  # the effectors are on the normal through the ankle
        assert np.abs(mine[:, :3, 2] - wanted[:, :3, 2]).max() < 1e-14
        np.testing.assert_allclose(found.foot_residuals[known][:, side], errors, rtol=0, atol=1e-13)
        turned = wanted @ np.pad(rot_z(found.yaw_errors[known][:, side]), ((0, 0), (0, 1), (0, 1)))
        np.testing.assert_allclose(mine[:, :3, :3], turned[:, :3, :3], rtol=0, atol=1e-13)
        sizes.append(errors)
    np.testing.assert_allclose(found.residual[known], np.maximum(*sizes), rtol=0, atol=1e-13)
    if inside:
        assert nao.within_limits(rows).all()


# --- feet that agree --------------------------------------------------------------------------------------------------


def test_every_configuration_is_among_the_solutions_of_its_feet(each_nao: nk.NaoModel) -> None:
    q = each_nao.random(7, 3000)
    T = feet_of(each_nao, q)
    found = nk.ik.legs(each_nao, *T)
    assert_met(each_nao, T, found)
    assert distance_to_solutions(found, q).max() < 1e-8
    assert set(found.count.tolist()) == {1, 2, 4}


def test_without_limits_there_are_thirty_two_branches(nao: nk.NaoModel) -> None:
    q = nao.random(3, 200)
    T = feet_of(nao, q)
    found = nk.ik.legs(nao, *T, limits="ignore")
    assert_met(nao, T, found, inside=False)
    assert (found.count == 32).all()
    assert distance_to_solutions(found, q).max() < 1e-8
    pairs = np.array(list(itertools.combinations(range(32), 2)))
    apart = np.abs(found.branches[:, pairs[:, 0]] - found.branches[:, pairs[:, 1]]).max(axis=-1)
    assert apart.min() > 1e-4


def test_the_solutions_are_the_pairs_of_solutions_of_each_leg(nao: nk.NaoModel) -> None:
    T = feet_of(nao, nao.random(4, 100))
    for limits in ("enforce", "ignore"):
        both = nk.ik.legs(nao, *T, limits=limits)
        left, right = (nk.ik.leg(nao, side, pose, limits=limits) for side, pose in zip("LR", T, strict=True))
        for i in range(100):
            wanted = {
                (*np.round(one, 6), *np.round(two[1:], 6))
                for one in left.branches[i, : left.count[i]]
                for two in right.branches[i, : right.count[i]]
                if abs(math.remainder(one[0] - two[0], 2.0 * math.pi)) < 1e-8
            }
            rows = both.branches[i, : both.count[i]]
            assert len(rows) == len(wanted)
            expected = np.array(sorted(wanted))
            gaps = np.abs(np.mod(rows[:, None] - expected + math.pi, 2 * math.pi) - math.pi).max(axis=-1)
            assert gaps.min(axis=1).max() < 2e-6
            assert gaps.min(axis=0).max() < 2e-6


def test_solutions_are_sorted_by_their_distance_over_eleven_joints(nao: nk.NaoModel) -> None:
    q = nao.random(6, 300)
    T = feet_of(nao, q)
    np.testing.assert_allclose(nk.ik.legs(nao, *T, near=q).q, q, atol=1e-8)
    found = nk.ik.legs(nao, *T, limits="ignore", near=nao.posture("StandInit"))
    assert len(found.joints) == 11
    distances = np.linalg.norm(found.branches - found.near[..., list(found.columns)], axis=-1)
    assert (np.diff(distances, axis=-1) >= 0.0).all()


def test_the_edges_of_the_limits_belong_to_them(each_nao: nk.NaoModel) -> None:
    nao, rng = each_nao, np.random.default_rng(2)
    q = nao.random(rng, 600)
    legs = [i for i, name in enumerate(nao.joint_names) if "Hip" in name or "Knee" in name or "AnklePitch" in name]
    for row in q:
        for column in rng.choice(legs, 3, replace=False):
            row[column] = rng.choice([nao.lower[column], nao.upper[column]])
    for table in nao.coupled_limits[1:]:
        roll, pitch = (nao.joint_names.index(joint) for joint in (table.joint, table.of))
        q[:, roll] = np.where(rng.random(len(q)) < 0.5, *table.range(q[:, pitch]))
    q = nao.clamp(q)
    T = feet_of(nao, q)
    found = nk.ik.legs(nao, *T)
    assert_met(nao, T, found)
    assert distance_to_solutions(found, q).max() < 1e-7


@for_all("beside", BESIDE)
def test_straight_knees_and_beside_them(nao: nk.NaoModel, beside: float) -> None:
    rng = np.random.default_rng(8)
    for knees in (("LKneePitch",), ("RKneePitch",), ("LKneePitch", "RKneePitch")):
        q = nao.random(rng, 12)
        q = moved(nao, q, **{knee: beside * rng.choice([-1.0, 1.0], 12) for knee in knees})
        T = feet_of(nao, q)
        for limits in ("enforce", "ignore"):
            found = nk.ik.legs(nao, *T, limits=limits)
            assert_met(nao, T, found, inside=limits == "enforce")
            # Near zero the angle of a knee is a square root of what rounding has left.
            assert distance_to_solutions(found, q).max() < 4e-7


def on_ankle_axis(nao: nk.NaoModel, sides: str, q: Floats, ankle: float) -> Floats:
    """Configurations with the hip on the axis of AnkleRoll: L₂ cos q₅ + L₁ cos(q₄ + q₅) = 0."""
    for side in sides:
        hip, knee, foot = (
            nao.position(nao.neutral(), side + joint) for joint in ("HipPitch", "KneePitch", "AnklePitch")
        )
        share = np.linalg.norm(knee - foot) / np.linalg.norm(hip - knee)
        bend = math.acos(-share * math.cos(ankle)) - ankle
        values = {"HipPitch": -0.3, "KneePitch": bend, "AnklePitch": ankle, "AnkleRoll": 0.02 if side == "L" else -0.02}
        q = moved(nao, q, **{side + joint: value for joint, value in values.items()})
    return q


@for_all("beside", BESIDE)
@for_all("sides", ["L", "R", "LR"])
def test_hips_on_the_axis_of_ankle_roll_and_beside_it(nao: nk.NaoModel, sides: str, beside: float) -> None:
    rng = np.random.default_rng(9)
    for ankle, sign in itertools.product((0.83, 0.87), (-1.0, 1.0)):
        q = on_ankle_axis(nao, sides, moved(nao, nao.random(rng), LHipYawPitch=rng.uniform(-0.5, 0.3)), ankle)
        q = moved(nao, q, **{side + "AnklePitch": ankle + sign * beside for side in sides})
        assert nao.within_limits(q)
        T = feet_of(nao, q)
        for limits in ("enforce", "ignore"):
            found = nk.ik.legs(nao, *T, near=q, limits=limits)
            assert_met(nao, T, found, inside=limits == "enforce")
            if len(sides) == 1:  # the other leg fixes the motor
                assert distance_to_solutions(found, q) < 1e-8
                assert found.family is Family.NONE
            elif beside < 1e-13:
                assert found.family is Family.ANKLE_AXIS
                assert distance_to_solutions(found, q) < 1e-7
            else:
                assert distance_to_solutions(found, q) < 1e-14 / beside + 1e-8


@for_all("beside", BESIDE)
@for_all("sides", ["L", "R", "LR"])
def test_locked_hips_and_beside_them(nao: nk.NaoModel, sides: str, beside: float) -> None:
    rng = np.random.default_rng(10)
    for sign in (-1.0, 1.0):
        q = nao.random(rng)
        for side in sides:
            lock = -math.pi / 4 if side == "L" else math.pi / 4
            q = moved(nao, q, **{side + "HipRoll": lock + sign * beside})
        T = feet_of(nao, q)
        found = nk.ik.legs(nao, *T, near=q, limits="ignore")
        assert_met(nao, T, found, inside=False)
        if len(sides) == 1:
            assert distance_to_solutions(found, q) < 1e-8
        elif beside < 1e-13:
            assert found.family is Family.HIP_LOCK
            assert distance_to_solutions(found, q) < 1e-7
        else:
            assert distance_to_solutions(found, q) < 1e-14 / beside + 1e-8


@for_all("beside", BESIDE)
def test_a_leg_along_the_axis_of_hip_roll_and_beside_it(nao: nk.NaoModel, beside: float) -> None:
    rng = np.random.default_rng(11)
    knee = -0.08
    for sign in (-1.0, 1.0):
        # The line from hip to ankle is level, as far as HipPitch and HipRoll are concerned.
        hip, at, ankle = (nao.position(nao.neutral(), "L" + joint) for joint in ("HipPitch", "KneePitch", "AnklePitch"))
        thigh, tibia = np.linalg.norm(hip - at), np.linalg.norm(at - ankle)
        pitch = -0.5 * math.pi + sign * beside - math.atan2(tibia * math.sin(knee), thigh + tibia * math.cos(knee))
        q = moved(nao, nao.random(rng), LKneePitch=knee, LHipPitch=pitch, LAnklePitch=0.2, LAnkleRoll=0.05)
        T = feet_of(nao, q)
        found = nk.ik.legs(nao, *T, near=q)
        assert_met(nao, T, found)
        assert distance_to_solutions(found, q) < 1e-6


def test_rounding_of_targets_makes_no_feet_disagree(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(12)
    T = feet_of(nao, nao.random(rng, 2000))
    noisy = []
    for pose in T:
        pose = np.array(pose)
        pose[:, :3] += 1e-14 * rng.normal(size=(2000, 3, 4))
        noisy.append(pose)
    found = nk.ik.legs(nao, *noisy, limits="ignore")
    assert found.success.all()
    assert found.residual.max() < 1e-10
    assert np.mean(nk.ik.legs(nao, *noisy).success) > 0.999


# --- feet that disagree -----------------------------------------------------------------------------------------------


@pytest.mark.full
@for_all("limits", ["enforce", "ignore"])
def test_no_hip_yaw_pitch_of_a_fine_scan_turns_the_feet_less(nao: nk.NaoModel, limits: str) -> None:
    T, enforce = disagreeing(nao, 13, 24), limits == "enforce"
    scans = [least_turns(nao, T[0][i], T[1][i], 1501, enforce=enforce) for i in range(24)]
    for priority in ("balanced", "left", "right"):
        found = nk.ik.legs(nao, *T, limits=limits, priority=priority)  # type: ignore[arg-type]
        assert (found.reasons == Reason.HIPS_DISAGREE).sum() > 15
        assert_level(nao, T, found, inside=enforce)
        for mine, (left, right) in zip(np.abs(found.yaw_errors), (scan[priority] for scan in scans), strict=True):
            if np.isnan(mine).any():
                assert left == math.inf
            elif left < math.inf:
                cost, least = {
                    "balanced": (np.hypot(*mine), np.hypot(left, right)),
                    "left": (mine[0], left),
                    "right": (mine[1], right),
                }[priority]
                assert cost <= least + 1e-9, priority


def test_the_scan_meets_ankles_and_normals(nao: nk.NaoModel) -> None:
    T = feet_of(nao, nao.random(14))
    for side, wanted in zip("LR", T, strict=True):
        q, turns = scanned(nao, side, wanted, np.linspace(-1.1, 0.7, 40), enforce=False)
        mine = nao.fk(q, side + "Leg")
        assert np.abs(mine[..., :3, 3] - wanted[:3, 3]).max() < 1e-14
        chord = wanted[:3, :3] @ rot_z(turns) - mine[..., :3, :3]
        assert np.abs(chord).max() < 1e-13


def test_the_foot_that_is_preferred_is_exact(nao: nk.NaoModel) -> None:
    q = nao.configuration({HIP: -0.3, "LHipPitch": -0.4, "LKneePitch": 0.8, "RHipPitch": -0.4, "RKneePitch": 0.8})
    T = feet_of(nao, q)[0], feet_of(nao, moved(nao, q, LHipYawPitch=-0.1))[1]
    said = {priority: nk.ik.legs(nao, *T, priority=priority) for priority in ("left", "right", "balanced")}  # type: ignore[arg-type]
    for priority, found in said.items():
        assert not found.success
        assert found.reason is Reason.HIPS_DISAGREE
        np.testing.assert_allclose(found.obstacles.needed, 0.2, atol=1e-12)
        assert str(found.message).startswith("the hips disagree by 0.2 rad; the feet are turned by ")
        assert_level(nao, T, found)
        assert found.count == 0
        column = nao.joint_names.index(HIP)
        expected = {"left": -0.3, "right": -0.1}.get(priority, -0.2)
        np.testing.assert_allclose(found.q[column], expected, atol=1e-10 if priority != "balanced" else 0.02)
    assert abs(said["left"].yaw_errors[0]) < 1e-14
    assert abs(said["right"].yaw_errors[1]) < 1e-14
    sizes = {priority: np.linalg.norm(found.yaw_errors) for priority, found in said.items()}
    assert sizes["balanced"] < 0.75 * min(sizes["left"], sizes["right"])


def test_a_way_as_narrow_as_a_point_is_found(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(15)
    rolls = [nao.joint_names.index(side + "HipRoll") for side in "LR"]
    pitches = [nao.joint_names.index(side + "AnklePitch") for side in "LR"]
    count = 0
    for _ in range(50):
        q = nao.random(rng)
        for columns in (rolls, pitches):
            for column in columns:
                q[column] = rng.choice([nao.lower[column], nao.upper[column]])
        q = nao.clamp(q)
        T = feet_of(nao, q)
        # A turned foot changes nothing of where ankles and normals can be met.
        found = nk.ik.legs(nao, turned(T[0], 0.3), T[1])
        assert not np.isnan(found.yaw_errors).any()
        assert nao.within_limits(found.q)
        hips = q[nao.joint_names.index(HIP)] + np.linspace(-0.02, 0.02, 41)[np.arange(41) != 20]
        ways = [
            np.isfinite(scanned(nao, side, pose, hips, enforce=True)[1]).any(axis=0)
            for side, pose in zip("LR", T, strict=True)
        ]
        count += not (ways[0] & ways[1]).any()
    assert count > 5  # of these the limits leave one value


def test_a_leg_that_does_not_reach_is_named(nao: nk.NaoModel) -> None:
    q = nao.posture("StandInit")
    T_left, T_right = feet_of(nao, q)
    far = T_right.copy()
    far[2, 3] -= 0.1
    found = nk.ik.legs(nao, T_left, far)
    alone = nk.ik.leg(nao, "R", far)
    assert found.reason is Reason.OUT_OF_REACH
    why, _ = str(alone.message).split(";")
    assert str(found.message).startswith(f"right leg: {why}; the nearest feet are off by")
    assert found.leg == 1
    assert nao.within_limits(found.q)
    assert found.residual[0] == found.foot_residuals[:, 0].max() > 0.01
    folded = moved(nao, q, LKneePitch=2.31)
    found = nk.ik.legs(nao, feet_of(nao, folded)[0], T_right)
    assert found.reason is Reason.JOINT_LIMIT
    assert str(found.message).startswith("left leg: LKneePitch needs 2.31 rad, limit 2.11; the nearest feet")
    rolled = moved(nao, q, RHipPitch=-0.1, RKneePitch=0.8, RAnklePitch=-0.9, RAnkleRoll=-0.4)
    found = nk.ik.legs(nao, T_left, feet_of(nao, rolled)[1])
    assert found.reason is Reason.COUPLED_LIMIT
    assert str(found.message).startswith("right leg: RAnkleRoll needs -0.4 rad, coupled limit there -0.")
    assert found.leg == 1
    both = nk.ik.legs(nao, np.array([far, T_left]), np.array([far, far]))
    assert both.leg.tolist() == [0, 1]
    T_far = T_left.copy()
    T_far[:3, 3] *= 1000.0
    assert "targets are in metres" in str(nk.ik.legs(nao, T_far, T_right).message)


def test_a_leg_that_reaches_only_with_a_turned_foot_says_so(nao: nk.NaoModel) -> None:
    q = nao.posture("StandInit")
    T_left, T_right = feet_of(nao, moved(nao, q, LHipRoll=-0.5))[0], feet_of(nao, q)[1]
    found = nk.ik.legs(nao, T_left, T_right)
    assert found.reason is Reason.JOINT_LIMIT
    assert "left leg: LHipRoll needs -0.5 rad, limit -0.379; the feet are turned by" in str(found.message)
    assert_level(nao, (T_left[None], T_right[None]), nk.ik.legs(nao, T_left[None], T_right[None]))


def test_the_hips_are_apart_by_the_difference_of_both_legs(nao: nk.NaoModel) -> None:
    T = disagreeing(nao, 16, 200)
    found = nk.ik.legs(nao, *T)
    left, right = (nk.ik.leg(nao, side, pose) for side, pose in zip("LR", T, strict=True))
    apart = np.nanmin(np.abs(left.branches[:, :, None, 0] - right.branches[:, None, :, 0]), axis=(1, 2))
    assert (found.reasons == Reason.HIPS_DISAGREE).sum() > 120
    which = found.reasons == Reason.HIPS_DISAGREE
    np.testing.assert_allclose(found.obstacles.needed[which], apart[which], rtol=0, atol=1e-9)


def test_feet_that_cross_are_said_to(nao: nk.NaoModel) -> None:
    T_left, T_right = feet_of(nao, nao.posture("StandInit"))
    crossed = T_left.copy()
    crossed[1, 3] = T_right[1, 3] - 0.02
    assert nk.ik.legs(nao, T_left, T_right).notes == ()
    (note,) = nk.ik.legs(nao, crossed, T_right).notes
    assert note == "the feet cross: the left ankle is to the right of the right one"
    (note,) = nk.ik.legs(nao, [T_left, crossed, crossed], T_right).notes
    assert note.endswith("in 2 of 3 targets, first at index [1]")


# --- feet in the world ------------------------------------------------------------------------------------------------


def placed(T: Floats, yaw: float | Floats = 0.4) -> Floats:
    """Poses carried into a world in which the torso stands elsewhere, turned and leaning."""
    away = np.eye(4)
    away[:3, :3] = rot_z(yaw) @ rot_y(0.1) @ rot_x(-0.07)
    away[:3, 3] = 0.3, -0.2, 0.33
    return np.asarray(away @ T)


def test_feet_that_agree_leave_the_torso_where_it_is_wished(nao: nk.NaoModel) -> None:
    q = nao.random(17, 300)
    T = feet_of(nao, q)
    wished = placed(np.eye(4))
    for free in ("height", "lean", "yaw"):
        found = nk.ik.legs(nao, placed(T[0]), placed(T[1]), base="floating", torso=wished, free=free, near=q)  # type: ignore[arg-type]
        assert_met(nao, T, found)
        assert found.torso is not None
        np.testing.assert_allclose(found.torso, np.broadcast_to(wished, (300, 4, 4)), rtol=0, atol=1e-15)
        np.testing.assert_allclose(found.q, q, atol=1e-8)


@for_all("free", ["height", "lean", "yaw"])
def test_the_torso_gives_way_until_both_feet_are_met(nao: nk.NaoModel, free: str) -> None:
    rng = np.random.default_rng(18)
    q = nao.clamp(nao.posture("StandInit") + rng.uniform(-0.15, 0.15, (400, nao.nq)))
    T = feet_of(nao, q)
    truth = placed(np.eye(4))
    amount = rng.uniform(-0.03, 0.03, 400) if free == "height" else rng.uniform(-0.2, 0.2, 400)
    wished = moved_torso(nao, truth, free, amount)
    found = nk.ik.legs(nao, placed(T[0]), placed(T[1]), base="floating", torso=wished, free=free)  # type: ignore[arg-type]
    assert found.success.all()
    assert found.torso is not None
    in_torso = np.linalg.inv(found.torso)
    assert_met(nao, (in_torso @ placed(T[0]), in_torso @ placed(T[1])), found)
    # Only the number that was given free has changed, and no farther than back to where the feet were made.
    back = amount_of(nao, wished, found.torso, free)
    np.testing.assert_allclose(moved_torso(nao, wished, free, back), found.torso, rtol=0, atol=1e-12)
    assert (np.abs(back) <= np.abs(amount) + 1e-9).all()
    assert np.mean(np.abs(back + amount) < 1e-7) > 0.5


def middle_of_hips(nao: nk.NaoModel) -> Floats:
    return np.asarray(0.5 * sum(nao.position(nao.neutral(), side + "HipYawPitch") for side in "LR"))


def moved_torso(nao: nk.NaoModel, T: Floats, free: str, amount: Floats) -> Floats:
    """A torso that is higher, leaning or turned."""
    hips = middle_of_hips(nao)
    moved_by = np.tile(np.eye(4), (*np.shape(amount), 1, 1))
    if free == "height":
        moved_by[..., 2, 3] = amount
        return np.asarray(moved_by @ T)
    pivot = hips if free == "lean" else T[..., :3, :3] @ hips + T[..., :3, 3]
    R = rot_y(amount) if free == "lean" else rot_z(amount)
    moved_by[..., :3, :3] = R
    moved_by[..., :3, 3] = pivot - np.einsum("...ij,...j->...i", R, np.broadcast_to(pivot, (*R.shape[:-2], 3)))
    return np.asarray(T @ moved_by if free == "lean" else moved_by @ T)


def amount_of(nao: nk.NaoModel, before: Floats, after: Floats, free: str) -> Floats:
    """Return by how much the free coordinate of a torso has changed."""
    if free == "height":
        return np.asarray(after[..., 2, 3] - before[..., 2, 3])
    R, S = before[..., :3, :3], after[..., :3, :3]
    if free == "lean":
        turn = R.swapaxes(-1, -2) @ S
        return np.asarray(np.arctan2(turn[..., 0, 2], turn[..., 0, 0]))
    turn = S @ R.swapaxes(-1, -2)
    return np.asarray(np.arctan2(turn[..., 1, 0], turn[..., 0, 0]))


@for_all("free", ["height", "lean", "yaw"])
def test_no_smaller_change_of_the_torso_meets_both_feet(nao: nk.NaoModel, free: str) -> None:
    rng = np.random.default_rng(19)
    q = nao.clamp(nao.posture("StandInit") + rng.uniform(-0.2, 0.2, (6, nao.nq)))
    T = feet_of(nao, q)
    truth = placed(np.eye(4))
    wished = moved_torso(nao, truth, free, rng.uniform(-0.02, 0.02, 6) if free == "height" else np.full(6, 0.15))
    found = nk.ik.legs(nao, placed(T[0]), placed(T[1]), base="floating", torso=wished, free=free)  # type: ignore[arg-type]
    assert found.torso is not None
    for i in range(6):
        back = float(amount_of(nao, wished[i], found.torso[i], free))
        shares = np.linspace(-0.999, 0.999, 400) * abs(back)
        torsos = np.linalg.inv(moved_torso(nao, wished[i], free, shares))
        hips = []
        for side, pose in zip("LR", (placed(T[0][i]), placed(T[1][i])), strict=True):
            each = nk.ik.leg(nao, side, torsos @ pose)
            hips.append(np.where(each.count > 0, each.best[:, 0], np.nan))
        gap = hips[0] - hips[1]
        known = gap[np.isfinite(gap)]
        assert (known > 0.0).all() or (known < 0.0).all()


def test_a_stance_is_kept_where_no_torso_is_wished(nao: nk.NaoModel) -> None:
    q = nao.posture("StandInit")
    T = feet_of(nao, q)
    found = nk.ik.legs(nao, placed(T[0]), placed(T[1]), base="floating", near=q)
    assert found.success
    assert found.torso is not None
    np.testing.assert_allclose(found.torso, placed(np.eye(4)), atol=1e-14)
    np.testing.assert_allclose(found.q, q, atol=1e-8)
    # Feet farther apart: the torso stays over their middle.
    wide = placed(T[0]) @ np.block([[np.eye(3), np.array([[0.0], [0.02], [0.0]])], [np.zeros(3), 1.0]])
    found = nk.ik.legs(nao, wide, placed(T[1]), base="floating", near=q)
    assert found.success
    rows = feet_of(nao, found.q)
    np.testing.assert_allclose(found.torso @ rows[0], wide, atol=1e-12)
    np.testing.assert_allclose(found.torso @ rows[1], placed(T[1]), atol=1e-12)


def test_a_torso_that_is_wished_too_high_comes_down_to_straight_legs(nao: nk.NaoModel) -> None:
    q = nao.posture("StandInit")
    T = feet_of(nao, q)
    wished = np.eye(4)
    wished[2, 3] = 0.1
    found = nk.ik.legs(nao, *T, base="floating", torso=wished, near=q)
    assert found.success
    assert found.torso is not None
    again = feet_of(nao, found.q)
    np.testing.assert_allclose(found.torso @ again[0], T[0], atol=1e-10)
    higher = found.torso + np.array([[0.0] * 4, [0.0] * 4, [0.0, 0.0, 0.0, 3e-6], [0.0] * 4])
    assert not nk.ik.legs(nao, *(np.linalg.inv(higher) @ pose for pose in T)).success


def test_a_robot_with_a_floating_base_gets_its_base_too() -> None:
    nao = nk.load_nao("v6", base="floating")
    q = nao.random(20, 30)
    q[:, :7] = [1.0, 2.0, 3.0, 0.1, -0.2, 0.3, math.sqrt(1.0 - 0.14)]
    T = nao.fk(q, list(FEET), reference="world")
    torso = nao.fk(q, "torso", reference="world")
    found = nk.ik.legs(nao, T[:, 0], T[:, 1], base="floating", torso=torso, near=q)
    assert found.success.all()
    np.testing.assert_allclose(found.q, q, atol=1e-8)
    assert pose_errors(nao.fk(found.q, list(FEET), reference="world"), T).max() < 1e-10
    assert found.solutions.shape[-1] == nao.nq
    np.testing.assert_allclose(found.solutions[:, 0], found.q, atol=0)


def test_feet_that_no_torso_meets_say_how_far_the_hips_are_apart(nao: nk.NaoModel) -> None:
    q = nao.posture("StandInit")
    T_left, T_right = feet_of(nao, q)
    # One foot only turned outwards: a height changes little of that.
    T_left = turned(T_left, 0.6)
    found = nk.ik.legs(nao, T_left, T_right, base="floating", torso=np.eye(4), near=q)
    assert found.reason is Reason.HIPS_DISAGREE
    assert found.torso is not None
    heights = np.tile(np.eye(4), (400, 1, 1))
    heights[:, 2, 3] = np.linspace(-0.12, 0.05, 400)
    down = np.linalg.inv(heights)
    scan = nk.ik.legs(nao, down @ T_left, down @ T_right)
    known = scan.reasons == Reason.HIPS_DISAGREE
    assert found.obstacles.needed <= scan.obstacles.needed[known].min() + 1e-9
    there = np.linalg.inv(found.torso)
    np.testing.assert_allclose(nk.ik.legs(nao, there @ T_left, there @ T_right).yaw_errors, found.yaw_errors, atol=1e-9)


# --- what callers give ------------------------------------------------------------------------------------------------


def test_any_frames_on_the_feet_may_be_asked_for(nao: nk.NaoModel) -> None:
    q = nao.random(21, 100)
    frames = "LFoot/Bumper/Left", "r_sole"
    T = nao.fk(q, list(frames))
    found = nk.ik.legs(nao, T[:, 0], T[:, 1], frames=frames, near=q)
    assert found.success.all()
    np.testing.assert_allclose(found.q, q, atol=1e-8)
    with pytest.raises(BadArgument, match="not carried by RAnkleRoll"):
        nk.ik.legs(nao, np.eye(4), np.eye(4), frames=("LLeg", "LLeg"))
    with pytest.raises(BadArgument, match="two names"):
        nk.ik.legs(nao, np.eye(4), np.eye(4), frames="LLeg")
    with pytest.raises(UnknownName, match="RLeg"):
        nk.ik.legs(nao, np.eye(4), np.eye(4), frames=("LLeg", "RLag"))


def test_targets_and_references_broadcast(nao: nk.NaoModel) -> None:
    q = nao.random(22, 4)
    T_left, T_right = feet_of(nao, moved(nao, q, LHipYawPitch=-0.2))
    found = nk.ik.legs(nao, T_left[:, None], T_right, near=q)
    assert found.q.shape == (4, 4, 25)
    assert found.success.all()
    np.testing.assert_array_equal(found.q[2, :, 0], q[:, 0])
    with pytest.raises(WrongShape, match="T_right"):
        nk.ik.legs(nao, T_left, T_right[:3])
    with pytest.raises(WrongShape, match="torso"):
        nk.ik.legs(nao, T_left, T_right, base="floating", torso=T_left[:3])


def test_wrong_names_are_refused_with_the_valid_ones(nao: nk.NaoModel) -> None:
    T = np.eye(4), np.eye(4)
    with pytest.raises(UnknownName, match="priority 'lift'.*left"):
        nk.ik.legs(nao, *T, priority="lift")  # type: ignore[arg-type]
    with pytest.raises(UnknownName, match="base 'float'.*floating"):
        nk.ik.legs(nao, *T, base="float")  # type: ignore[arg-type]
    with pytest.raises(UnknownName, match="free 'hight'.*height"):
        nk.ik.legs(nao, *T, free="hight")  # type: ignore[arg-type]
    with pytest.raises(BadArgument, match="floating"):
        nk.ik.legs(nao, *T, torso=np.eye(4))


def test_straight_legs_in_float32_are_nearly_met(nao: nk.NaoModel) -> None:
    q = nao.random(13, 500)
    q[:, [nao.joint_names.index(f"{side}KneePitch") for side in "LR"]] = 0.0
    left, right = (nao.fk(q, f"{side}Leg").astype(np.float32).astype(np.float64) for side in "LR")
    found = nk.ik.legs(nao, left, right)
    assert np.isfinite(found.q).all()
    assert np.mean((found.reasons == Reason.REACHED) | (found.reasons == Reason.HIPS_DISAGREE)) > 0.98
    met = (found.reasons == Reason.REACHED) | (found.reasons == Reason.HIPS_DISAGREE)
    assert found.foot_residuals[met, :, 0].max() < 1e-7
    for foot, (frame, T) in enumerate((("LLeg", left), ("RLeg", right))):
        away = np.linalg.norm(nao.position(found.q[met], frame) - T[met, :3, 3], axis=-1)
        assert (away <= found.foot_residuals[met, foot, 0] + 1e-10).all()


@for_all("limits, moved", [("enforce", 2e-6), ("ignore", 2e-5)])
def test_rounding_of_feet_that_are_not_reached_does_not_move_the_nearest_pose(
    nao: nk.NaoModel, limits: str, moved: float
) -> None:
    rng = np.random.default_rng(5)
    feet = [nao.fk(nao.random(seed, 200), foot) for seed, foot in ((0, "LLeg"), (1000, "RLeg"))]
    for T in feet:
        T[::4, :3, 3] *= 1.2
    rounded = [T * (1.0 + 2.0**-52 * np.pad(rng.integers(-4, 5, (200, 3, 4)), ((0, 0), (0, 1), (0, 0)))) for T in feet]
    exact, other = (nk.ik.legs(nao, *pair, limits=limits) for pair in (feet, rounded))
    missed = np.isnan(exact.yaw_errors[:, 0]) & (exact.count == 0)
    assert missed.sum() > 40
    assert np.abs(exact.best - other.best)[missed].max() < moved
    one = np.flatnonzero(missed)[0]
    assert np.allclose(nk.ik.legs(nao, *(T[one] for T in feet), limits=limits).best, exact.best[one], atol=moved)


@pytest.mark.full
def test_feet_that_are_not_reached_get_the_nearest_pose_of_both(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(2)
    reference, q = nao.random(rng, 12), nao.random(rng, 12)
    T = nao.fk(q, ["LLeg", "RLeg"])
    T[:, 0, :3, 3] += rng.normal(scale=0.2, size=(12, 3))
    found = nk.ik.legs(nao, T[:, 0], T[:, 1], near=reference)
    rows = np.flatnonzero(np.isnan(found.yaw_errors).any(axis=-1))
    assert rows.size > 4
    assert nao.within_limits(found.q).all()
    columns = list(found.columns)
    low, high = nao.lower[columns], nao.upper[columns]
    for k in rows:

        def errors(values: Floats, k: int = int(k)) -> Floats:
            q = np.tile(reference[k], (*values.shape[:-1], 1))
            q[..., columns] = values
            made = nao.fk(q, ["LLeg", "RLeg"])
            turns = log(made[..., :3, :3].swapaxes(-1, -2) @ T[k, :, :3, :3])
            both = np.concatenate([(made - T[k])[..., :3, 3], 0.1 * turns], axis=-1)
            return both.reshape(*values.shape[:-1], 12)

        ours = np.square(found.foot_residuals[k] * [1.0, 0.1]).sum()
        assert ours == pytest.approx(np.square(errors(found.q[k, columns])).sum(), rel=1e-6)
        for start in rng.uniform(low, high, (4, len(low))):
            end = least_squares(errors, start, derivatives(errors), bounds=(low, high))
            other = reference[k].copy()
            other[columns] = end.x
            if nao.within_limits(other):  # coupled limits are unknown to SciPy
                assert ours <= 2.0 * end.cost * (1.0 + 1e-4)
    message = found.describe((int(rows[0]),))
    assert "the nearest feet are off by" in message
