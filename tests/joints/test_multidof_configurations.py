"""From typed configurations back to the robot's: branches, locks, couplings."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, strategies as st
from made_up_robots import J, made_up
from scipy.spatial.transform import Rotation

import nao_kin as nk
from nao_kin.errors import BadArgument, CouplingViolated, DisagreeingJoints
from nao_kin.joints import MultiDofModel

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
NAO = nk.load_nao()
TYPED = MultiDofModel(NAO)
ARMS = MultiDofModel(NAO, rule="concurrent")
HIP = {side: "+".join(f"{side}{part}" for part in ("HipYawPitch", "HipRoll", "HipPitch")) for side in "LR"}
LOCK = {"L": -math.pi / 4, "R": math.pi / 4}
# The links that a ball does not see: they turn with its inner angles.
INSIDE = {"LPelvis", "LHip", "RPelvis", "RHip", "LHipYawPitch", "LHipRoll", "RHipYawPitch", "RHipRoll"}
OUTSIDE = [name for name in NAO.frame_names if name not in INSIDE]
COLUMN = {name: index for index, name in enumerate(NAO.joint_names)}

turn = st.floats(-3.1, 3.1)
distance = st.one_of(st.just(0.0), st.floats(-17.0, -3.0).map(lambda e: 10.0**e), st.floats(1e-3, 1.0))


def nao(**values: float) -> np.ndarray:
    return NAO.configuration(values, limits="ignore")


def with_ball(q_typed: np.ndarray, side: str, xyzw: np.ndarray) -> np.ndarray:
    changed = q_typed.copy()
    changed[..., TYPED.columns[HIP[side]]] = xyzw
    return changed


def turned(side: str, *angles: float) -> np.ndarray:
    """The quaternion of a hip's three angles, by scipy."""
    axes = NAO_AXES[side]
    product = Rotation.identity()
    for axis, angle in zip(axes, angles, strict=True):
        product = product * Rotation.from_rotvec(np.array(axis) * angle)
    return product.as_quat()


NAO_AXES = {
    "L": ((0, math.sqrt(0.5), -math.sqrt(0.5)), (1, 0, 0), (0, 1, 0)),
    "R": ((0, math.sqrt(0.5), math.sqrt(0.5)), (1, 0, 0), (0, 1, 0)),
}


# --- there and back ---------------------------------------------------------------------------------------------------


def test_inside_the_limits_the_way_back_needs_no_reference(each_nao) -> None:
    q = each_nao.random(1, 1000)
    typed = MultiDofModel(each_nao)
    assert np.allclose(typed.to_q(typed.from_q(q)), q, rtol=0, atol=1e-14)


def test_with_itself_as_reference_every_configuration_comes_back() -> None:
    q = np.random.default_rng(1).uniform(-9, 9, (1000, 25))
    for typed in (TYPED, ARMS):
        assert np.allclose(typed.to_q(typed.from_q(q), near=q), q, rtol=0, atol=1e-10)


def test_one_reference_serves_a_whole_batch() -> None:
    q = NAO.random(3, (2, 3))
    assert TYPED.to_q(TYPED.from_q(q), near=NAO.posture("StandInit")).shape == (2, 3, 25)
    many = TYPED.to_q(TYPED.from_q(q[0, 0]), near=q)
    assert np.allclose(many, np.broadcast_to(many[0, 0], many.shape), rtol=0, atol=1e-12)


@given(turn, turn, turn)
def test_the_quaternion_is_scipys_product_of_the_three_turns(first, middle, third) -> None:
    q_typed = TYPED.from_q(nao(LHipYawPitch=first, LHipRoll=middle, LHipPitch=third, RHipRoll=-middle, RHipPitch=third))
    for side, roll in (("L", middle), ("R", -middle)):
        mine = q_typed[TYPED.columns[HIP[side]]]
        theirs = turned(side, first, roll, third)
        assert min(np.abs(mine - theirs).max(), np.abs(mine + theirs).max()) < 1e-15


def test_quaternions_are_continuous_along_a_path() -> None:
    path = np.linspace(-7, 7, 4001)
    q_typed = TYPED.from_q(NAO.configuration({"LHipYawPitch": path, "LHipRoll": 2 * path}, limits="ignore"))
    steps = np.diff(q_typed[:, TYPED.columns[HIP["L"]]], axis=0)
    assert np.linalg.norm(steps, axis=1).max() < 0.01


def test_the_sign_of_a_quaternion_does_not_matter() -> None:
    q = NAO.random(4, 20)
    q_typed = TYPED.from_q(q)
    for side in "LR":
        flipped = with_ball(q_typed, side, -q_typed[:, TYPED.columns[HIP[side]]])
        assert np.allclose(TYPED.to_q(flipped), q, rtol=0, atol=1e-14)


def test_where_the_limits_decide_carriers_do_not_count_and_are_set_right() -> None:
    q = NAO.random(5, 10)
    q_typed = TYPED.from_q(q)
    wrong = q_typed.copy()
    for carrier in ("LHipYawPitch", "LHipRoll", "RHipRoll"):
        wrong[:, TYPED.columns[carrier]] = 0.77
    assert np.array_equal(TYPED.to_q(wrong), TYPED.to_q(q_typed))
    assert np.allclose(TYPED.from_q(TYPED.to_q(wrong)), q_typed, rtol=0, atol=1e-14)


SHOULDERS = MultiDofModel(nk.load_nao("v3.2"), rule="concurrent")


@given(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5), distance, st.sampled_from([-1, 1]))
def test_carriers_tell_a_shoulder_its_side_of_the_lock_and_its_outer_angles_at_it(pitch, yaw, d, sign) -> None:
    q = SHOULDERS.robot.configuration(
        {"LShoulderPitch": pitch, "LShoulderRoll": math.pi / 2 + sign * min(d, 0.05), "LElbowYaw": yaw}
    )
    assert np.allclose(SHOULDERS.to_q(SHOULDERS.from_q(q)), q, rtol=0, atol=1e-12)


# --- branches ---------------------------------------------------------------------------------------------------------


@given(turn, turn, turn)
def test_both_triples_of_a_ball_turn_it_alike(first, middle, third) -> None:
    q_typed = TYPED.from_q(nao(LHipYawPitch=first, LHipRoll=middle, LHipPitch=third))
    found = TYPED.ball_angles(q_typed, "LHipRoll")
    assert np.array_equal(found.angles, TYPED.ball_angles(q_typed, HIP["L"]).angles)
    quaternion = q_typed[TYPED.columns[HIP["L"]]]
    for triple in (found.angles, found.other):
        again = turned("L", *triple)
        assert min(np.abs(again - quaternion).max(), np.abs(again + quaternion).max()) < 1e-14
    if not found.locked:
        middle = found.angles[1] + math.pi / 4
        assert math.sin(middle) * math.sin(found.other[1] + math.pi / 4) <= 1e-15


def test_the_reference_picks_the_branch_and_the_turn() -> None:
    q = nao(LHipYawPitch=0.2, LHipRoll=0.3, LHipPitch=-0.4, RHipRoll=-0.1, RHipPitch=0.5)
    q_typed = TYPED.from_q(q)
    seen = []
    for branch in itertools.product((0, 1), repeat=2):
        reference = q.copy()
        for side, other in zip("LR", branch, strict=True):
            found = TYPED.ball_angles(q_typed, HIP[side])
            triple = found.other if other else found.angles
            reference[COLUMN[f"{side}HipRoll"]] = triple[1]
            reference[COLUMN[f"{side}HipPitch"]] = triple[2] + 4 * math.pi
            if side == "L":
                reference[COLUMN["LHipYawPitch"]] = triple[0]
        back = TYPED.to_q(q_typed, near=reference)
        seen.append(tuple(np.round(back, 6)))
        assert np.allclose(TYPED.fk(TYPED.from_q(back), OUTSIDE), NAO.fk(q, OUTSIDE), rtol=0, atol=1e-14)
        assert abs(back[COLUMN["RHipPitch"]] - reference[COLUMN["RHipPitch"]]) <= math.pi
    # One motor: the hips change branches together.
    assert len(set(seen)) == 2


@given(turn, turn, turn, turn, turn)
def test_any_consistent_typed_configuration_has_a_way_back(yaw, left_roll, left_pitch, right_roll, right_pitch) -> None:
    q = nao(LHipYawPitch=yaw, LHipRoll=left_roll, LHipPitch=left_pitch, RHipRoll=right_roll, RHipPitch=right_pitch)
    q_typed = TYPED.from_q(q)
    assert TYPED.violations(q_typed) == ()
    assert np.allclose(NAO.fk(TYPED.to_q(q_typed), OUTSIDE), NAO.fk(q, OUTSIDE), rtol=0, atol=1e-12)


# --- locks ------------------------------------------------------------------------------------------------------------


@given(turn, turn, turn, distance, distance, st.sampled_from([-1, 1]), st.booleans(), st.booleans())
def test_at_a_lock_and_beside_it_every_frame_comes_back(yaw, left, right, d, e, sign, left_far, right_far) -> None:
    q = nao(
        LHipYawPitch=yaw,
        LHipRoll=LOCK["L"] + sign * d + math.pi * left_far,
        LHipPitch=left,
        RHipRoll=LOCK["R"] + sign * e - math.pi * right_far,
        RHipPitch=right,
    )
    q_typed = TYPED.from_q(q)
    expected = NAO.fk(q, OUTSIDE)
    for back in (TYPED.to_q(q_typed), TYPED.to_q(q_typed, near=q), TYPED.to_q(q_typed, near=NAO.neutral())):
        assert np.allclose(NAO.fk(back, OUTSIDE), expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("locked", ["L", "R", "LR"])
def test_at_an_exact_lock_the_reference_decides_what_the_ball_cannot(locked) -> None:
    q = nao(
        LHipYawPitch=0.4,
        LHipRoll=LOCK["L"] if "L" in locked else 0.1,
        LHipPitch=0.2,
        RHipRoll=LOCK["R"] if "R" in locked else 0.1,
        RHipPitch=-0.3,
    )
    assert np.allclose(TYPED.to_q(TYPED.from_q(q), near=q), q, rtol=0, atol=1e-14)


@given(turn, turn, turn, distance, st.sampled_from([-1, 1]))
def test_beside_a_lock_the_reference_decides_what_rounding_leaves_open(yaw, left, right, d, sign) -> None:
    rolls = {each: LOCK[each] + sign * d for each in "LR"}
    q = nao(LHipYawPitch=yaw, LHipRoll=rolls["L"], LHipPitch=left, RHipRoll=rolls["R"], RHipPitch=right)
    assert np.allclose(TYPED.to_q(TYPED.from_q(q), near=q), q, rtol=0, atol=1e-12)


@pytest.mark.parametrize("locked", ["L", "R"])
def test_at_a_lock_the_free_hip_tells_the_locked_one_where_the_motor_stands(locked) -> None:
    rolls = {side: LOCK[side] if side == locked else 0.1 for side in "LR"}
    q = nao(LHipYawPitch=0.4, LHipRoll=rolls["L"], LHipPitch=0.2, RHipRoll=rolls["R"], RHipPitch=-0.3)
    back = TYPED.to_q(TYPED.from_q(q), near=NAO.neutral())
    assert np.allclose(back, q, rtol=0, atol=1e-14)


def test_with_both_hips_locked_and_no_reference_limits_decide() -> None:
    q = nao(LHipYawPitch=0.4, LHipRoll=LOCK["L"], LHipPitch=-1.0, RHipRoll=LOCK["R"], RHipPitch=-0.5)
    back = TYPED.to_q(TYPED.from_q(q))
    outside = {row.joint for row in NAO.limit_violations(back) if "Hip" in row.joint}
    assert outside == {"LHipRoll", "RHipRoll"}
    assert np.allclose(NAO.fk(back, OUTSIDE), NAO.fk(q, OUTSIDE), rtol=0, atol=1e-14)


# --- the shared motor -------------------------------------------------------------------------------------------------


def hips_at_odds(left: float, right: float) -> np.ndarray:
    q = NAO.configuration({"LHipYawPitch": left, "LHipRoll": 0.1, "LHipPitch": -0.2, "RHipPitch": 0.3})
    return with_ball(TYPED.from_q(q), "R", turned("R", right, 0.0, 0.3))


def test_hips_that_disagree_are_refused_with_both_values_and_the_nearest() -> None:
    with pytest.raises(DisagreeingJoints) as caught:
        TYPED.to_q(hips_at_odds(-0.2, -0.5))
    error = caught.value
    assert isinstance(error, CouplingViolated)
    assert (error.primary, error.mimic) == ("LHipYawPitch", "RHipYawPitch")
    assert error.primary_value == pytest.approx(-0.2, abs=1e-14)
    assert error.mimic_value == pytest.approx(-0.5, abs=1e-14)
    assert error.expected == pytest.approx(-0.2, abs=1e-14)
    assert error.nearest == pytest.approx(-0.35, abs=1e-14)
    assert "-0.2" in str(error)
    assert "-0.5" in str(error)
    assert "nearest consistent: LHipYawPitch = -0.35" in str(error)


def test_the_nearest_consistent_configuration_is_nearest_and_consistent() -> None:
    q_typed = hips_at_odds(-0.2, -0.5)
    q = TYPED.to_q(q_typed, couplings="nearest")
    assert NAO.angles(q)["LHipYawPitch"] == pytest.approx(-0.35, abs=1e-14)
    assert NAO.angles(q)["LHipRoll"] == pytest.approx(0.1, abs=1e-14)
    assert NAO.angles(q)["RHipPitch"] == pytest.approx(0.3, abs=1e-14)
    assert TYPED.violations(TYPED.from_q(q)) == ()


def test_violations_are_reported_by_configuration_and_do_not_raise() -> None:
    q_typed = np.stack([TYPED.from_q(NAO.neutral()), hips_at_odds(-0.2, -0.5), hips_at_odds(0.1, 0.2)]).reshape(
        3, 1, -1
    )
    rows = TYPED.violations(q_typed)
    assert [row.index for row in rows] == [(1, 0), (2, 0)]
    assert rows[1].nearest == pytest.approx(0.15, abs=1e-14)
    with pytest.raises(DisagreeingJoints, match=r"configuration 1, 0.*1 more"):
        TYPED.to_q(q_typed)
    assert TYPED.to_q(q_typed, couplings="nearest").shape == (3, 1, 25)


@pytest.mark.parametrize(("gap", "refused"), [(1e-9, False), (9e-7, False), (2e-6, True), (1e-3, True)])
def test_hips_agree_to_single_precision(gap, refused) -> None:
    rows = TYPED.violations(hips_at_odds(-0.2, -0.2 + gap))
    assert bool(rows) == refused
    if not refused:
        assert TYPED.to_q(hips_at_odds(-0.2, -0.2 + gap))[COLUMN["LHipYawPitch"]] == pytest.approx(-0.2, abs=1e-14)


def test_hips_a_whole_turn_apart_agree() -> None:
    q_typed = hips_at_odds(-0.2, -0.2 + 2 * math.pi)
    assert TYPED.to_q(q_typed)[COLUMN["LHipYawPitch"]] == pytest.approx(-0.2, abs=1e-14)


def test_single_precision_quaternions_are_good_enough() -> None:
    q = NAO.random(7, 200)
    rounded = TYPED.from_q(q).astype(np.float32)
    assert np.allclose(TYPED.to_q(rounded), q, rtol=0, atol=2e-6)


def test_a_universal_joint_can_disagree_with_its_motor_too(tmp_path) -> None:
    robot = made_up(tmp_path, J("m", Z), J("a", Z, parent="base", follows=("m", -0.5, 0.2)), J("b", X))
    typed = MultiDofModel(robot)
    q_typed = typed.from_q([0.4, 0.1])
    assert q_typed[typed.columns["a+b"]].tolist() == pytest.approx([0.0, 0.1], abs=1e-15)
    q_typed[typed.columns["a+b"].start] = 0.3
    with pytest.raises(DisagreeingJoints) as caught:
        typed.to_q(q_typed)
    m = caught.value.nearest
    # The nearest point of the line a = 0.2 − m/2 to (m, a) = (0.4, 0.3).
    assert m == pytest.approx(0.4 - 0.5 * 0.3 / 1.25, abs=1e-14)
    assert caught.value.expected == pytest.approx(0.0, abs=1e-15)
    assert typed.to_q(q_typed, couplings="nearest").tolist() == pytest.approx([m, 0.1], abs=1e-15)


def test_two_followers_of_one_motor_are_weighed_together(tmp_path) -> None:
    arms = [J("a", Z, parent="base", follows=("m", 1.0, 0.0)), J("b", X), J("c", Y)]
    legs = [J("d", Z, parent="base", follows=("m", 2.0, 0.0)), J("e", X), J("f", Y)]
    typed = MultiDofModel(made_up(tmp_path, J("m", Z), *arms, *legs))
    start = np.array([0.3, 0.1, 0.2, 0.4, 0.5])
    assert np.allclose(typed.to_q(typed.from_q(start), near=start), start, rtol=0, atol=1e-14)
    q_typed = typed.from_q(start)
    q_typed[typed.columns["m"]] = 0.9
    rows = typed.violations(q_typed, near=start)
    assert {row.mimic for row in rows} == {"a", "d"}
    # (m − 0.9)² + (m − 0.3)² + (2 m − 0.6)² is smallest at m = 2.4 / 6.
    assert [row.nearest for row in rows] == pytest.approx([0.4, 0.4], abs=1e-14)


# --- bad input --------------------------------------------------------------------------------------------------------


def test_every_reader_of_quaternions_refuses_a_wrong_norm_with_joint_norm_and_index() -> None:
    readers = [
        TYPED.to_q,
        TYPED.violations,
        TYPED.com,
        lambda q: TYPED.fk(q, "RFoot"),
        lambda q: TYPED.jacobian(q, "RFoot"),
        lambda q: TYPED.ball_angles(q, "LHipRoll"),
    ]
    for scale, norm in ((0.0, "0"), (1.5, "1.5")):
        q_typed = TYPED.from_q(NAO.neutral() * np.ones((2, 3, 1)))
        q_typed[1, 2, TYPED.columns[HIP["R"]]] *= scale
        for reader in readers:
            with pytest.raises(BadArgument, match=rf"^RHip.*\(x, y, z, w\), got one of norm {norm} at index \[1, 2\]$"):
                reader(q_typed)


def test_the_quaternion_of_a_floating_base_is_checked_and_normalised_like_a_balls() -> None:
    floating = MultiDofModel(nk.load_nao(base="floating"))
    q = floating.robot.neutral()
    q_typed = floating.from_q(q)
    for reader in (floating.to_q, floating.com, floating.fk, lambda q: floating.jacobian(q, "LFoot")):
        with pytest.raises(BadArgument, match=r"^base must be a unit quaternion .* norm 2$"):
            reader(np.concatenate([q_typed[:3], 2 * q_typed[3:7], q_typed[7:]]))
    q_typed[3:7] *= 1 + 9e-7
    before = q_typed.copy()
    R = floating.fk(q_typed, "LFoot")[:3, :3]
    assert np.allclose(R @ R.T, np.eye(3), rtol=0, atol=1e-15)
    assert np.allclose(floating.to_q(q_typed), q, rtol=0, atol=1e-15)
    assert np.array_equal(q_typed, before)
