from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from ik_checks import BESIDE, Floats, assert_solved, derivatives, distance_to_solutions, pose_errors
from loops import for_all

import nao_kin as nk
from nao_kin.errors import BadArgument, NotFinite, UnknownName, WrongShape
from nao_kin.ik import Family, Reason
from nao_kin.rotations import exp, matrix_from_quat, rot_y

SIDES = ("L", "R")


def bent(nao: nk.NaoModel, side: str, **angles: float) -> Floats:
    """A configuration with a bent leg, some of its joints as given."""
    values = {"HipRoll": 0.05, "HipPitch": -0.5, "KneePitch": 0.9, "AnklePitch": -0.4, "AnkleRoll": 0.03} | angles
    named = {side + joint: value for joint, value in values.items() if joint != "HipYawPitch"}
    named["LHipYawPitch"] = values.get("HipYawPitch", -0.2)
    return nao.configuration(named, limits="ignore")


@for_all("side", SIDES)
def test_every_configuration_is_among_the_solutions_of_its_pose(each_nao: nk.NaoModel, side: str) -> None:
    q = each_nao.random(7, 4000)
    T = each_nao.fk(q, side + "Leg")
    found = nk.ik.leg(each_nao, side, T)
    assert_solved(each_nao, side + "Leg", T, found)
    assert distance_to_solutions(found, q).max() < 1e-8
    assert set(found.count.tolist()) == {1, 2}


@for_all("side", SIDES)
def test_without_limits_there_are_eight_branches(nao: nk.NaoModel, side: str) -> None:
    T = nao.fk(nao.random(3, 500), side + "Leg")
    found = nk.ik.leg(nao, side, T, limits="ignore")
    assert_solved(nao, side + "Leg", T, found, inside=False)
    assert (found.count == 8).all()
    # All different: the nearest two of them.
    pairs = np.array(list(itertools.combinations(range(8), 2)))
    apart = np.abs(found.branches[:, pairs[:, 0]] - found.branches[:, pairs[:, 1]]).max(axis=-1)
    assert apart.min() > 1e-4


@pytest.mark.full
def test_all_solutions_of_an_exhaustive_search_are_found(nao: nk.NaoModel) -> None:
    optimize = pytest.importorskip("scipy.optimize")
    rng = np.random.default_rng(11)
    for side in SIDES:
        T = nao.fk(nao.random(rng), side + "Leg")
        found = nk.ik.leg(nao, side, T, limits="ignore")
        columns = list(found.columns)

        def error(values: Floats, T: Floats = T, side: str = side, columns: list[int] = columns) -> Floats:
            q = np.zeros((*values.shape[:-1], 25))
            q[..., columns] = np.mod(values + math.pi, 2 * math.pi) - math.pi
            entries = (nao.fk(q, side + "Leg") - T)[..., :3, :] * [1.0, 1.0, 1.0, 10.0]
            return entries.reshape(*values.shape[:-1], 12)

        seen = set()
        for start in rng.uniform(-math.pi, math.pi, (250, 6)):
            end = optimize.least_squares(error, start, derivatives(error), xtol=1e-14, ftol=1e-14, gtol=1e-14)
            if end.cost < 1e-20:
                wrapped = np.mod(end.x + math.pi, 2 * math.pi) - math.pi
                gaps = np.abs(np.mod(found.branches - wrapped + math.pi, 2 * math.pi) - math.pi).max(axis=-1)
                assert gaps.min() < 1e-6, wrapped
                seen.add(int(np.argmin(gaps)))
        assert len(seen) == found.count == 8


@for_all("side", SIDES)
def test_the_edges_of_the_limits_belong_to_them(each_nao: nk.NaoModel, side: str) -> None:
    nao, rng = each_nao, np.random.default_rng(2)
    q = nao.random(rng, 1500)
    columns = list(nk.ik.leg(nao, side, nao.fk(q[0], side + "Leg")).columns)
    for row in q:
        column = rng.choice(columns[:5])
        row[column] = rng.choice([nao.lower[column], nao.upper[column]])
    table = next(table for table in nao.coupled_limits if table.joint == side + "AnkleRoll")
    low, high = table.range(q[:, columns[4]])
    box = nao.lower[columns[5]], nao.upper[columns[5]]
    ends = np.clip(np.where(rng.random(len(q)) < 0.5, low, high), *box)
    q[:, columns[5]] = np.where(rng.random(len(q)) < 0.5, ends, np.clip(q[:, columns[5]], *np.clip([low, high], *box)))
    assert nao.within_limits(q).all()
    T = nao.fk(q, side + "Leg")
    found = nk.ik.leg(nao, side, T)
    assert_solved(nao, side + "Leg", T, found)
    assert distance_to_solutions(found, q).max() < 1e-7


@for_all("beside", BESIDE)
@for_all("side", SIDES)
def test_a_straight_knee_and_beside_it(nao: nk.NaoModel, side: str, beside: float) -> None:
    for sign in (1.0, -1.0):
        q = bent(nao, side, KneePitch=sign * beside)
        T = nao.fk(q, side + "Leg")
        for limits in ("enforce", "ignore"):
            found = nk.ik.leg(nao, side, T, limits=limits)
            assert_solved(nao, side + "Leg", T, found, inside=limits == "enforce")
            # Near zero the angle of the knee is a square root of what rounding has left.
            assert distance_to_solutions(found, q) < 2e-7
            straight = 4 if beside < 1e-8 else 8 if beside > 1e-6 else found.count
            assert limits == "enforce" or found.count == straight


@for_all("beside", BESIDE)
@for_all(("side", "lock"), [("L", -math.pi / 4), ("L", 3 * math.pi / 4), ("R", math.pi / 4)])
def test_a_locked_hip_and_beside_it(nao: nk.NaoModel, side: str, lock: float, beside: float) -> None:
    for sign in (1.0, -1.0):
        q = bent(nao, side, HipRoll=lock + sign * beside)
        T = nao.fk(q, side + "Leg")
        found = nk.ik.leg(nao, side, T, limits="ignore", near=q)
        assert_solved(nao, side + "Leg", T, found, inside=False)
        assert distance_to_solutions(found, q) < (1e-11 if beside < 1e-12 else 1e-15 / beside + 1e-12)
        if beside < 1e-13:
            assert found.family is Family.HIP_LOCK
        if beside > 1e-11:
            assert found.family is Family.NONE


def test_a_member_of_a_locked_hip_is_the_nearest_to_the_reference(nao: nk.NaoModel) -> None:
    q = bent(nao, "L", HipRoll=-math.pi / 4)
    T = nao.fk(q, "LLeg")
    reference = nao.configuration({"LHipYawPitch": 0.3, "LHipPitch": -0.2}, limits="ignore")
    found = nk.ik.leg(nao, "L", T, limits="ignore", near=reference)
    yaw, pitch = found.columns[0], found.columns[2]
    best = found.q
    # What rounding leaves of the sum is the only thing that matters to the pose.
    for shift in (-1e-4, 1e-4):
        other = best.copy()
        other[yaw] += shift
        for step in (-shift, shift):
            other[pitch] = best[pitch] + step
            if np.abs(nao.fk(other, "LLeg") - T).max() < 1e-9:
                assert np.linalg.norm(other - reference) > np.linalg.norm(best - reference)
                break
        else:
            pytest.fail("no neighbour in the family")


def on_ankle_axis(nao: nk.NaoModel, side: str, ankle_pitch: float) -> Floats:
    """A configuration with the hip on the axis of AnkleRoll: L₂ cos q₅ + L₁ cos(q₄ + q₅) = 0."""
    hip, knee_at, ankle = (
        nao.position(nao.neutral(), side + joint) for joint in ("HipPitch", "KneePitch", "AnklePitch")
    )
    thigh, tibia = np.linalg.norm(hip - knee_at), np.linalg.norm(knee_at - ankle)
    knee = math.acos(-tibia * math.cos(ankle_pitch) / thigh) - ankle_pitch
    return bent(nao, side, AnklePitch=ankle_pitch, KneePitch=knee, AnkleRoll=0.02, HipPitch=-0.3)


@for_all("beside", BESIDE)
@for_all("side", SIDES)
def test_the_hip_on_the_axis_of_ankle_roll_and_beside_it(nao: nk.NaoModel, side: str, beside: float) -> None:
    q = on_ankle_axis(nao, side, 0.85)
    assert not [row for row in nao.limit_violations(q) if "Elbow" not in row.joint]
    for sign in (1.0, -1.0):
        near = q.copy()
        near[nk.ik.leg(nao, side, nao.fk(q, side + "Leg")).columns[4]] += sign * beside
        T = nao.fk(near, side + "Leg")
        for limits in ("enforce", "ignore"):
            found = nk.ik.leg(nao, side, T, near=near, limits=limits)
            assert_solved(nao, side + "Leg", T, found, inside=limits == "enforce")
            assert distance_to_solutions(found, near) < (1e-9 if beside < 1e-11 else 1e-15 / beside + 1e-9)
            if beside < 1e-13:
                assert found.family is Family.ANKLE_AXIS


@for_all("beside", [1e-11, 1e-10, 1e-9, 1e-8, 1e-7])
@for_all("end", [0, 1])
def test_beside_the_axis_of_ankle_roll_rounding_puts_no_roll_outside_its_limits(
    nao: nk.NaoModel, end: int, beside: float
) -> None:
    rng = np.random.default_rng(20)
    table = next(table for table in nao.coupled_limits if table.joint == "LAnkleRoll")
    pitch, roll = (nao.joint_names.index(joint) for joint in ("LAnklePitch", "LAnkleRoll"))
    for _ in range(40):
        q = on_ankle_axis(nao, "L", rng.uniform(0.8, 0.9))
        q[pitch] += beside
        q[nao.joint_names.index("LHipPitch")] += rng.uniform(-0.2, 0.2)
        q[roll] = float(table.range(q[pitch])[end])
        T = nao.fk(q, "LLeg")
        found = nk.ik.leg(nao, "L", T)
        assert_solved(nao, "LLeg", T, found)


def test_the_member_about_the_ankle_axis_is_inside_the_limits_and_nearest(nao: nk.NaoModel) -> None:
    q = on_ankle_axis(nao, "L", 0.85)
    T = nao.fk(q, "LLeg")
    roll = nao.joint_names.index("LAnkleRoll")
    for wanted in (-0.3, 0.0, 0.04, 0.3):
        reference = q.copy()
        reference[roll] = wanted
        found = nk.ik.leg(nao, "L", T, near=reference)
        assert found.family is Family.ANKLE_AXIS
        assert_solved(nao, "L" + "Leg", T, found)
        inside = found.near
        away = np.linalg.norm(found.q - inside)
        # No other roll has a nearer member, by the closed form at a foot turned a little out of the family.
        for other in np.linspace(-0.02, 0.06, 41):
            start = q.copy()
            start[roll] = other
            rival = nk.ik.leg(nao, "L", T, near=start).q
            assert np.linalg.norm(rival - inside) > away - 1e-6


@for_all("beyond", [1.01e-6, 1e-3, 1.0])
@for_all("side", SIDES)
def test_out_of_reach_is_said_with_the_distance(nao: nk.NaoModel, side: str, beyond: float) -> None:
    rng = np.random.default_rng(1)
    quaternions = rng.normal(size=(20, 4))
    R = matrix_from_quat(quaternions / np.linalg.norm(quaternions, axis=1)[:, None])
    hip = nao.position(nao.neutral(), side + "HipYawPitch")
    directions = rng.normal(size=(20, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    foot = nao.fk(nao.neutral(), side + "Leg", reference=side + "AnkleRoll")[:3, 3]
    T = np.tile(np.eye(4), (20, 1, 1))
    T[:, :3, :3] = R
    T[:, :3, 3] = hip + (0.2029 + beyond) * directions + R @ foot
    found = nk.ik.leg(nao, side, T, limits="ignore")
    assert (found.reason == Reason.OUT_OF_REACH).all()
    assert not np.any(found.success)
    assert (found.residual[:, 0] <= beyond + 0.06).all()
    np.testing.assert_allclose(found.obstacles.needed, beyond, rtol=0, atol=1e-15)
    one = nk.ik.leg(nao, side, T[0])
    assert one.reason is Reason.OUT_OF_REACH
    assert one.count == 0
    assert one.solutions.shape == (0, 25)
    # And nearer than the folded leg.
    T[:, :3, 3] = hip + max(0.0, 0.0029 - beyond) * directions + R @ foot
    found = nk.ik.leg(nao, side, T, limits="ignore")
    assert (found.reason == Reason.OUT_OF_REACH).all()
    np.testing.assert_allclose(found.obstacles.needed, min(beyond, 0.0029), rtol=0, atol=1e-15)


def test_a_message_says_what_is_in_the_way(nao: nk.NaoModel) -> None:
    far = nao.fk(nao.posture("StandZero"), "LLeg")
    far[2, 3] -= 0.012
    assert nk.ik.leg(nao, "L", far).message == "out of reach; the nearest pose is off by 12 mm"
    folded = bent(nao, "L", KneePitch=2.31)
    said = nk.ik.leg(nao, "L", nao.fk(folded, "LLeg"))
    assert said.reason is Reason.JOINT_LIMIT
    assert str(said.message).startswith("LKneePitch needs 2.31 rad, limit 2.11; the nearest pose is off by")
    rolled = bent(nao, "L", HipPitch=-0.1, KneePitch=0.8, AnklePitch=-0.9, AnkleRoll=0.4)
    said = nk.ik.leg(nao, "L", nao.fk(rolled, "LLeg"))
    assert said.reason is Reason.COUPLED_LIMIT
    assert "LAnkleRoll needs 0.4 rad, coupled limit there 0." in str(said.message)


def test_what_is_blamed_is_really_outside(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(6)
    q = nao.random(rng, 150)
    T = nao.fk(q, "LLeg")
    T[:, :3, :3] = T[:, :3, :3] @ rot_y(rng.uniform(-1.5, 1.5, 150))
    found = nk.ik.leg(nao, "L", T)
    every = nk.ik.leg(nao, "L", T, limits="ignore")
    for i in np.flatnonzero(found.reason >= Reason.JOINT_LIMIT):
        violations = [nao.limit_violations(row) for row in every.solutions[i]]
        assert all(violations)
        least = min(violations, key=lambda rows: max(v.excess for v in rows))
        worst = max(least, key=lambda v: v.excess)
        assert found.joints[found.obstacles.joint[i]].replace("R", "L", 1) == worst.joint.replace("R", "L", 1)
        np.testing.assert_allclose(found.obstacles.needed[i], worst.value, atol=1e-9)
        assert (found.reason[i] == Reason.COUPLED_LIMIT) == (worst.of is not None)


def test_a_right_leg_moves_the_motor_of_both_hips(nao: nk.NaoModel) -> None:
    q = nao.random(9)
    found = nk.ik.leg(nao, "R", nao.fk(q, "RLeg"), near=q)
    assert found.joints[0] == "RHipYawPitch"
    assert nao.joint_names[found.columns[0]] == "LHipYawPitch"
    np.testing.assert_allclose(found.q, q, atol=1e-9)


def test_solutions_take_the_other_joints_from_the_reference_and_the_nearest_is_first(nao: nk.NaoModel) -> None:
    q = nao.random(10, 300)
    T = nao.fk(q, "LLeg")
    found = nk.ik.leg(nao, "L", T, near=q)
    np.testing.assert_allclose(found.q, q, atol=1e-8)
    rest = nk.ik.leg(nao, "L", T)
    distances = np.linalg.norm(rest.branches - rest.near[..., list(rest.columns)], axis=-1)
    assert (np.diff(distances, axis=-1)[rest.count == 2] >= 0.0).all()


def test_a_reference_outside_a_coupled_limit_goes_to_the_nearest_point_of_the_plane_region(nao: nk.NaoModel) -> None:
    pitch, roll = (nao.joint_names.index(joint) for joint in ("LAnklePitch", "LAnkleRoll"))
    # A fine grid over the plane of the two joints, of what is inside.
    grid = np.stack(
        np.meshgrid(
            np.linspace(nao.lower[pitch], nao.upper[pitch], 801), np.linspace(nao.lower[roll], nao.upper[roll], 801)
        ),
        axis=-1,
    ).reshape(-1, 2)
    whole = np.tile(nao.posture("StandInit"), (len(grid), 1))
    whole[:, [pitch, roll]] = grid
    grid = grid[nao.within_limits(whole)]
    for at in ((0.7, 0.35), (-0.9, 0.3), (-1.1, -0.3), (0.85, -0.3), (-1.5, 0.9)):
        reference = nao.posture("StandInit")
        reference[[pitch, roll]] = at
        found = nk.ik.leg(nao, "L", nao.fk(nao.posture("StandInit"), "LLeg"), near=reference)
        assert nao.within_limits(found.near).all()
        away = np.linalg.norm(found.near[[pitch, roll]] - at)
        nearest = np.linalg.norm(grid - at, axis=-1).min()
        assert nearest - 2e-3 < away <= nearest + 1e-9
        clipped = nao.clamp(reference)[[pitch, roll]]
        assert away <= np.linalg.norm(clipped - at)


def test_any_frame_on_the_foot_may_be_asked_for(nao: nk.NaoModel) -> None:
    q = nao.random(12, 200)
    for frame in ("LFoot/Bumper/Left", "l_sole", "LFoot", "LAnkleRoll"):
        T = nao.fk(q, frame)
        assert_solved(nao, frame, T, nk.ik.leg(nao, "L", T, frame=frame))
    with pytest.raises(BadArgument, match="not carried by LAnkleRoll; its frames are LAnkleRoll"):
        nk.ik.leg(nao, "L", T[0], frame="RLeg")
    with pytest.raises(UnknownName, match="LLeg"):
        nk.ik.leg(nao, "L", T[0], frame="LLag")


def test_a_floating_base_stays_where_the_reference_has_it() -> None:
    nao = nk.load_nao("v6", base="floating")
    q = nao.random(13, 20)
    q[:, :7] = [1.0, 2.0, 3.0, 0.5, 0.5, 0.5, 0.5]
    T = nao.fk(q, "LLeg", reference="torso")
    found = nk.ik.leg(nao, "L", T, near=q)
    np.testing.assert_allclose(found.q, q, atol=1e-8)


def test_a_target_rounded_to_single_precision_is_met_at_the_nearest_rotation(nao: nk.NaoModel) -> None:
    T = nao.fk(nao.random(14, 500), "LLeg")
    rounded = T.astype(np.float32).astype(np.float64)
    found = nk.ik.leg(nao, "L", rounded)
    hit = found.success
    assert np.mean(hit) > 0.9  # the others are on the edge of the limits
    assert found.residual[hit].max() < 1e-10
    assert np.abs(nao.fk(found.q[hit], "LLeg") - rounded[hit]).max() < 1e-6


def test_a_calibrated_model_is_solved_with_its_own_lengths() -> None:
    nao = nk.load_nao("v6")
    q = nao.random(15, 50)
    nk.ik.leg(nao, "L", nao.fk(q, "LLeg"))
    nao.model.jointPlacements[nao.model.getJointId("LKneePitch")].translation = np.array([0.0, 0.0, -0.1021])
    T = nao.fk(q, "LLeg")
    assert_solved(nao, "LLeg", T, nk.ik.leg(nao, "L", T))
    # A knee beside the hip's axis bends another zero; one out of the plane of the leg is no knee of this geometry.
    nao.model.jointPlacements[nao.model.getJointId("LKneePitch")].translation = np.array([0.001, 0.0, -0.1])
    T = nao.fk(q, "LLeg")
    assert_solved(nao, "LLeg", T, nk.ik.leg(nao, "L", T))
    nao.model.jointPlacements[nao.model.getJointId("LKneePitch")].translation = np.array([0.0, 0.001, -0.1])
    with pytest.raises(BadArgument, match=r"knee and ankle are not below the hip.*nk\.ik\.numeric"):
        nk.ik.leg(nao, "L", T)


def test_targets_may_be_of_any_layout_and_read_only(nao: nk.NaoModel) -> None:
    T = nao.fk(nao.random(17, (4, 5)), "LLeg")
    wanted = nk.ik.leg(nao, "L", T).q
    frozen = T.copy()
    frozen.flags.writeable = False
    layouts = [frozen, np.asfortranarray(T), np.broadcast_to(T, (2, 4, 5, 4, 4))[1], T.tolist(), T[::-1][::-1]]
    for layout in layouts:
        np.testing.assert_array_equal(nk.ik.leg(nao, "L", layout).q, wanted)
    np.testing.assert_array_equal(nk.ik.leg(nao, "L", frozen[:1]).q, wanted[:1])
    np.testing.assert_array_equal(nk.ik.leg(nao, "L", T.swapaxes(0, 1)).q, wanted.swapaxes(0, 1))


def test_bad_targets_are_refused_with_their_index(nao: nk.NaoModel) -> None:
    T = nao.fk(nao.random(16, 3), "LLeg")
    T[0, 1, 3] = math.nan
    with pytest.raises(NotFinite, match="target"):
        nk.ik.leg(nao, "L", T)
    with pytest.raises(WrongShape, match="near"):
        nk.ik.leg(nao, "L", np.eye(4), near=np.zeros((2, 25)))


def test_wrong_names_are_refused_with_the_nearest(nao: nk.NaoModel) -> None:
    with pytest.raises(UnknownName, match=r"side 'left' .*valid: L, R"):
        nk.ik.leg(nao, "left", np.eye(4))
    with pytest.raises(BadArgument, match="threads"):
        nk.ik.leg(nao, "L", np.eye(4), threads=0)
    for side in (None, "LArm", "Leg"):
        with pytest.raises(UnknownName, match="side"):
            nk.ik.leg(nao, side, np.eye(4))  # type: ignore[arg-type]


def test_a_leg_is_called_by_its_end_effector_too(nao: nk.NaoModel) -> None:
    T = nao.fk(nao.posture("Crouch"), "RLeg")
    assert np.array_equal(nk.ik.leg(nao, "RLeg", T).q, nk.ik.leg(nao, "R", T).q)


def test_a_robot_that_is_no_nao_is_told_what_is_missing() -> None:
    pytest.importorskip("cmeel", reason="example-robot-data is absent")
    romeo = nk.load_robot("romeo")
    with pytest.raises(BadArgument, match=r"no leg .*no joint 'LHipYawPitch'; nk\.ik\.numeric takes any robot"):
        nk.ik.leg(romeo, "L", np.eye(4))


@for_all("side", SIDES)
def test_straight_legs_in_float32_are_solved_straight_with_what_they_are_short_of(nao: nk.NaoModel, side: str) -> None:
    q = nao.random(13, 2000)
    q[:, nao.joint_names.index(f"{side}KneePitch")] = 0.0
    T = nao.fk(q, f"{side}Leg").astype(np.float32).astype(np.float64)
    found = nk.ik.leg(nao, side, T)
    assert np.all(found.success | (found.reasons == Reason.JOINT_LIMIT) | (found.reasons == Reason.COUPLED_LIMIT))
    assert np.mean(found.success) > 0.99
    met = np.asarray(found.success)
    errors = pose_errors(nao.fk(found.q[met], f"{side}Leg"), T[met])
    assert (errors[:, 0] <= found.residual[met, 0] + 1e-10).all()
    assert found.residual[met].max() < 1e-7
    assert (found.residual[met, 0] > 1e-9).sum() > 500  # these are beyond the stretched leg
    one = nk.ik.leg(nao, side, T[met][0])
    np.testing.assert_allclose(one.residual, found.residual[met][0], rtol=0, atol=1e-12)


def test_a_leg_is_not_stretched_by_more_than_a_micrometre(nao: nk.NaoModel) -> None:
    T = nao.fk(nao.neutral(), "LLeg")
    for beyond, reason in ((0.9e-6, Reason.REACHED), (1.1e-6, Reason.OUT_OF_REACH)):
        further = T.copy()
        hip = nao.position(nao.neutral(), "LHipPitch")
        ankle = nao.position(nao.neutral(), "LAnklePitch")
        further[:3, 3] += beyond * (ankle - hip) / np.linalg.norm(ankle - hip)
        found = nk.ik.leg(nao, "L", further)
        assert found.reason is reason
        assert found.residual[0] == pytest.approx(beyond, rel=1e-3)
        assert nao.within_limits(found.q)


@for_all("limits", ["enforce", "ignore"])
@for_all("side", SIDES)
def test_a_foot_that_is_not_reached_gets_the_nearest_pose(nao: nk.NaoModel, side: str, limits: str) -> None:
    rng = np.random.default_rng(4)
    T = nao.fk(nao.random(rng, 30), f"{side}Leg")
    T[:, :3, 3] += rng.normal(scale=0.2, size=(30, 3))
    T[::2, :3, :3] = T[::2, :3, :3] @ exp(rng.normal(size=(15, 3)))
    reference = nao.random(rng, 30)
    found = nk.ik.leg(nao, side, T, near=reference, limits=limits)  # type: ignore[arg-type]
    missed = ~np.asarray(found.success)
    assert missed.sum() > 10
    assert limits == "ignore" or nao.within_limits(found.q).all()
    assert not found.count[missed].any()
    np.testing.assert_allclose(pose_errors(nao.fk(found.q, f"{side}Leg"), T), found.residual, rtol=0, atol=1e-7)
    # Damped least squares of any robot, from many starts.
    other = nk.ik.numeric(nao, f"{side}Leg", T, near=reference, limits=limits)  # type: ignore[arg-type]
    cost, best = (np.square(one.residual * [1.0, 0.1]).sum(axis=-1) for one in (found, other))
    assert (cost <= 1.02 * best + 1e-15).all()
    assert np.mean(cost <= best * (1.0 + 1e-4) + 1e-15) > 0.95
    k = int(np.flatnonzero(missed)[0])
    one = nk.ik.leg(nao, side, T[k], near=reference[k], limits=limits)  # type: ignore[arg-type]
    np.testing.assert_allclose(one.residual, found.residual[k], rtol=0, atol=1e-7)
    assert "the nearest pose is off by" in str(one.message)
