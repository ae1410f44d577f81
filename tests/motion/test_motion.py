"""Motions: their curves beside scipy's, and the configurations that come of them."""

from __future__ import annotations

import copy
import pickle
import warnings
from typing import Any, get_args

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.interpolate import BPoly, CubicHermiteSpline, PchipInterpolator

import nao_kin as nk
from nao_kin._core.sides import other_sides, side_of
from nao_kin.motion.interpolation import INTERPOLATIONS, smooth_slopes

NAMES = ["HeadYaw", "HeadPitch", "LHand"]


def random_motion(seed: int, interpolation: str, *, joints: int = 3, most: int = 8, room: float = 1.0) -> nk.Motion:
    """A motion whose joints begin and end at different times, with handles of any length."""
    rng = np.random.default_rng(seed)
    times, keys, handles = [], [], []
    for _ in range(joints):
        k = int(rng.integers(1, most))
        column = np.cumsum(rng.uniform(0.05, 1.0, k)) + rng.uniform(-1.0, 1.0)
        offsets = rng.normal(size=(k, 2, 2)) * 0.3
        width = np.diff(column)
        offsets[:, 0, 0], offsets[:, 1, 0] = 0.0, 0.0
        offsets[1:, 0, 0] = -width * rng.uniform(0.0, room, k - 1)
        offsets[:-1, 1, 0] = width * rng.uniform(0.0, room, k - 1)
        times.append(column)
        keys.append(rng.normal(size=k) * 0.4)
        handles.append(offsets)
    names = ["HeadYaw", "LShoulderPitch", "RElbowRoll", "LHand", "RKneePitch"][:joints]
    return nk.Motion(times, names, keys, interpolation, handles if interpolation == "bezier" else None)  # type: ignore[arg-type]


# --- interpolation ----------------------------------------------------------------------------------------------------


def test_linear_is_a_straight_line_between_keys_and_constant_outside() -> None:
    motion = nk.Motion([1.0, 2.0, 4.0], ["HeadYaw"], [[0.0], [1.0], [-1.0]])
    assert np.array_equal(motion.sample([0.0, 1.0, 1.25, 2.0, 3.0, 4.0, 9.0])[:, 0], [0, 0, 0.25, 1, 0, -1, -1])
    assert np.allclose(motion.speed([0.0, 1.0, 2.0, 4.0, 9.0])[:, 0], [0, 1, -1, -1, 0], rtol=0, atol=1e-15)


def test_smooth_is_scipys_pchip_inside_and_at_rest_at_both_ends() -> None:
    rng = np.random.default_rng(1)
    times = np.cumsum(rng.uniform(0.01, 1.0, 60))
    keys = np.cumsum(rng.normal(size=(60, 3)), axis=0)
    keys[20:24] = keys[20]  # a plateau, where slopes are zero
    motion = nk.Motion(times, NAMES, keys, "smooth")
    t = np.linspace(times[1], times[-2], 5000)
    assert np.allclose(motion.sample(t), PchipInterpolator(times, keys)(t), rtol=0, atol=1e-12)
    assert np.allclose(
        motion.speed(t[1:-1]), PchipInterpolator(times, keys).derivative()(t[1:-1]), rtol=1e-9, atol=1e-9
    )
    assert np.allclose(motion.speed([times[0], times[-1]]), 0.0, rtol=0, atol=1e-14)
    slopes = np.stack([smooth_slopes(times, column) for column in keys.T], axis=-1)
    whole = np.linspace(times[0], times[-1], 5000)
    assert np.allclose(motion.sample(whole), CubicHermiteSpline(times, keys, slopes)(whole), rtol=0, atol=1e-12)


def test_smooth_between_two_keys_is_the_cubic_from_rest_to_rest() -> None:
    motion = nk.Motion([0.0, 2.0], ["HeadYaw"], [[0.0], [1.0]], "smooth")
    s = np.linspace(0.0, 1.0, 11)
    assert np.allclose(motion.sample(2.0 * s)[:, 0], 3 * s**2 - 2 * s**3, rtol=0, atol=1e-15)


@pytest.mark.parametrize("seed", range(5))
def test_bezier_with_equal_handles_is_scipys_bernstein_polynomial(seed: int) -> None:
    rng = np.random.default_rng(seed)
    times, keys = np.cumsum(rng.uniform(0.1, 1.0, 9)), rng.normal(size=9)
    handles = np.zeros((9, 2, 2))
    handles[1:, 0, 0], handles[:-1, 1, 0] = -np.diff(times) / 3.0, np.diff(times) / 3.0
    handles[..., 1] = rng.normal(size=(9, 2))
    motion = nk.Motion(times, ["HeadYaw"], keys[:, None], "bezier", [handles])
    controls = np.stack([keys[:-1], keys[:-1] + handles[:-1, 1, 1], keys[1:] + handles[1:, 0, 1], keys[1:]])
    t = np.linspace(times[0], times[-1], 1000)
    assert np.allclose(motion.sample(t)[:, 0], BPoly(controls, times)(t), rtol=0, atol=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_bezier_goes_through_the_points_that_the_parametric_cubic_has(seed: int) -> None:
    motion = random_motion(seed, "bezier", most=12)
    u = np.linspace(0.0, 1.0, 101)[:, None]
    weights = np.hstack([(1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u**2 * (1 - u), u**3])
    for column, (times, keys, handles) in enumerate(zip(motion.times, motion.keys, motion.handles or (), strict=True)):
        for k in range(len(times) - 1):
            points = np.array(
                [times[k], times[k] + handles[k, 1, 0], times[k + 1] + handles[k + 1, 0, 0], times[k + 1]]
            )
            values = np.array([keys[k], keys[k] + handles[k, 1, 1], keys[k + 1] + handles[k + 1, 0, 1], keys[k + 1]])
            found = motion.sample(weights @ points)[:, column]
            # Where the curve is steep, rounding of the time moves the value.
            steep = np.abs(motion.speed(weights @ points)[:, column])
            room = 1e-11 * (1.0 + np.where(np.isfinite(steep), steep, 1e3))
            assert np.all(np.abs(found - weights @ values) < room)


@pytest.mark.parametrize("seed", range(5))
def test_the_time_of_a_bezier_curve_is_solved_to_a_trillionth(seed: int) -> None:
    motion = random_motion(seed, "bezier", most=20, joints=1)
    times, curve = motion.times[0], motion.segments[0]
    t = np.random.default_rng(seed).uniform(times[0], times[-1], 20_000)
    segment = curve.at(t)
    assert np.abs(curve.time(segment, curve.parameter(segment, t)) - t).max() < 1e-12


def test_handles_that_meet_in_the_middle_are_solved_too() -> None:
    # Both as long as the segment: time stands still in the middle, where the curve is vertical.
    handles = np.zeros((2, 2, 2))
    handles[0, 1, 0], handles[1, 0, 0] = 1.0, -1.0
    motion = nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [1.0]], "bezier", [handles])
    values = motion.sample(np.linspace(0.0, 1.0, 1001))[:, 0]
    assert np.all(np.diff(values) >= 0.0)
    assert values[500] == pytest.approx(0.5, abs=1e-5)
    assert motion.speed(0.5)[0] == np.inf


def test_handles_of_no_length_make_a_straight_line_of_finite_speed() -> None:
    motion = nk.Motion([0.0, 2.0], ["HeadYaw"], [[0.0], [1.0]], "bezier", [np.zeros((2, 2, 2))])
    t = np.linspace(0.0, 2.0, 21)
    assert np.allclose(motion.sample(t)[:, 0], t / 2.0, rtol=0, atol=1e-12)
    assert np.allclose(motion.speed(t)[:, 0], 0.5, rtol=0, atol=1e-9)


def test_bezier_without_handles_is_the_smooth_curve() -> None:
    rng = np.random.default_rng(4)
    times, keys = np.cumsum(rng.uniform(0.1, 1.0, 20)), rng.normal(size=(20, 3))
    smooth, bezier = nk.Motion(times, NAMES, keys, "smooth"), nk.Motion(times, NAMES, keys, "bezier")
    t = np.linspace(times[0] - 1.0, times[-1] + 1.0, 2000)
    assert np.allclose(smooth.sample(t), bezier.sample(t), rtol=0, atol=1e-12)
    assert bezier.handles is not None
    assert np.allclose(bezier.handles[0][:-1, 1, 0], np.diff(times) / 3.0)


@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
def test_every_motion_is_a_bezier_one(interpolation: str) -> None:
    motion = random_motion(3, interpolation)
    t = np.linspace(motion.start - 0.5, motion.end + 0.5, 1001)
    assert motion.as_bezier().interpolation == "bezier"
    assert np.allclose(motion.as_bezier().sample(t), motion.sample(t), rtol=0, atol=1e-12)


@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
@pytest.mark.parametrize("seed", range(3))
def test_speed_is_the_difference_quotient(interpolation: str, seed: int) -> None:
    motion = random_motion(seed, interpolation, room=0.5)
    t = np.random.default_rng(seed).uniform(motion.start, motion.end, 2000)
    t = t[np.abs(t[:, None] - motion.key_times).min(axis=1) > 1e-3]  # speeds jump at keys
    quotient = (motion.sample(t + 1e-6) - motion.sample(t - 1e-6)) / 2e-6
    speed = motion.speed(t)
    assert np.all(np.abs(speed - quotient) <= 1e-5 * (1.0 + speed**2))


@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
def test_curves_go_through_their_keys_exactly(interpolation: str) -> None:
    motion = random_motion(8, interpolation, joints=5)
    for column, (times, keys) in enumerate(zip(motion.times, motion.keys, strict=True)):
        assert np.array_equal(motion.sample(times)[:, column], keys)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.tuples(st.floats(1e-3, 10.0), st.floats(-3.0, 3.0)), min_size=1, max_size=12),
    st.lists(st.floats(-5.0, 150.0), min_size=1, max_size=20),
)
def test_linear_and_smooth_never_leave_the_range_of_the_two_keys(
    rows: list[tuple[float, float]], at: list[float]
) -> None:
    times = np.cumsum([width for width, _ in rows])
    keys = np.array([key for _, key in rows])
    for interpolation in ("linear", "smooth"):
        values = nk.Motion(times, ["HeadYaw"], keys[:, None], interpolation).sample(at)[:, 0]
        before = np.clip(np.searchsorted(times, at, side="right") - 1, 0, None)
        after = np.minimum(before + 1, len(times) - 1)
        before = np.where(np.array(at) < times[0], 0, before)
        after = np.where(np.array(at) < times[0], 0, after)
        low, high = np.minimum(keys[before], keys[after]), np.maximum(keys[before], keys[after])
        assert np.all((values >= low - 1e-12) & (values <= high + 1e-12))


def test_any_shape_of_times_is_answered_in_that_shape() -> None:
    motion = random_motion(0, "smooth")
    assert motion.sample(0.3).shape == motion.speed(0.3).shape == (3,)
    assert motion.sample(np.zeros((4, 0, 2))).shape == (4, 0, 2, 3)
    t = np.linspace(0.0, 2.0, 6).reshape(2, 3)
    assert np.array_equal(motion.sample(t)[1, 2], motion.sample(t[1, 2]))


@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
def test_a_million_keys_are_no_trouble(interpolation: str) -> None:
    times = np.arange(1_000_000) * 0.01
    motion = nk.Motion(times, ["HeadYaw"], np.sin(times)[:, None], interpolation)
    t = np.linspace(1.0, 9998.0, 1000)
    assert np.allclose(motion.sample(t)[:, 0], np.sin(t), rtol=0, atol=1e-4)


# --- what a motion is -------------------------------------------------------------------------------------------------


def test_one_list_of_times_serves_all_joints_and_each_may_have_its_own() -> None:
    rows = nk.Motion([0.0, 1.0], ["HeadYaw", "LHand"], [[0.1, 0.2], [0.3, 0.4]])
    lists = nk.Motion([[0.0, 1.0], [0.0, 1.0]], ["HeadYaw", "LHand"], [[0.1, 0.3], [0.2, 0.4]])
    assert rows == lists
    assert rows.times[0] is rows.times[1]
    own = nk.Motion([[0.0, 1.0], [0.5]], ["HeadYaw", "LHand"], [[0.1, 0.3], [0.2]])
    assert (own.start, own.end, own.duration) == (0.0, 1.0, 1.0)
    assert np.array_equal(own.key_times, [0.0, 0.5, 1.0])
    assert np.array_equal(own.sample(0.7)[1], 0.2)


def test_arrays_are_copies_and_read_only() -> None:
    times, keys = np.array([0.0, 1.0]), np.zeros((2, 1))
    motion = nk.Motion(times, ["HeadYaw"], keys, "bezier")
    times[0], keys[0] = 5.0, 5.0
    assert motion.start == 0.0
    assert motion.keys[0][0] == 0.0
    assert motion.handles is not None
    for array in (motion.times[0], motion.keys[0], motion.handles[0]):
        with pytest.raises(ValueError):
            array[0] = 1.0
    times[0] = 0.0
    times[:] = [0.0, 1.0]  # what was given stays writable
    motion.sample([0.5])[0] = 1.0  # and what is returned is the caller's


@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
def test_motions_are_equal_to_their_copies_and_pickles_only(interpolation: str) -> None:
    motion = random_motion(5, interpolation)
    motion.sample(0.0)
    assert motion == copy.deepcopy(motion) == pickle.loads(pickle.dumps(motion))
    assert motion != random_motion(6, interpolation)
    assert motion != "a motion"
    assert "3 joints" in repr(motion)


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        (([], ["HeadYaw"], []), nk.errors.BadArgument, "times must have at least one"),
        (([0.0], [], [[]]), nk.errors.BadArgument, "at least one joint"),
        (([0.0], "HeadYaw", [[0.0]]), nk.errors.BadArgument, "a list of names"),
        (([0.0], ["HeadYaw", "HeadYaw"], [[0.0, 1.0]]), nk.errors.BadArgument, "'HeadYaw' twice"),
        (([0.0, 1.0, 1.0], ["a"], [[0], [1], [2]]), nk.errors.BadArgument, "at index [2] is the same as"),
        (([0.0, np.nan], ["a"], [[0], [1]]), nk.errors.NotFinite, "times must be finite"),
        (([0.0, 1.0], ["a", "b"], [[0, 1], [0, np.inf]]), nk.errors.NotFinite, "index [1, 1] (b)"),
        (([[0.0, 1.0]], ["b"], [[0, np.nan]]), nk.errors.NotFinite, "keys of b must be finite, got nan at index [1]"),
        (([0.0, 1.0, 2.0], ["a", "b"], np.zeros((2, 3))), nk.errors.WrongShape, "a row for each time"),
        (([[0.0, 1.0]], ["a"], [[0, 1, 2]]), nk.errors.BadArgument, "a has 2 times and 3 keys"),
        (([[0.0, 1.0]], ["a", "b"], [[0, 1], [0, 1]]), nk.errors.BadArgument, "for each of 2 joints, got 1"),
        (([0.0, 1.0], ["a"], [["x"], [1]]), nk.errors.BadArgument, "real numbers"),
        (([0.0, 1.0], ["a"], [[0], [1]], "cubic"), nk.errors.UnknownName, "unknown interpolation 'cubic'"),
        (([0.0, 1.0], ["a"], [[0], [1]], "linear", [np.zeros((2, 2, 2))]), nk.errors.BadArgument, "bezier"),
        (([0.0, 1.0], ["a"], [[0], [1]], "bezier", [np.zeros((3, 2, 2))]), nk.errors.WrongShape, "handles of a"),
    ],
)
def test_what_is_no_motion_is_refused_with_joint_and_index(arguments: Any, error: type, words: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(error) as caught:
            nk.Motion(*arguments)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("key", "side", "offset", "words"),
    [
        (0, 1, 1.1, "after key 0 is 1.1 s from it, expected between 0 and 1 s"),
        (0, 1, -0.1, "after key 0 is -0.1 s"),
        (1, 0, -1.1, "before key 1 is -1.1 s from it, expected between -1 and 0 s"),
        (1, 0, 0.1, "before key 1"),
    ],
)
def test_handles_stay_within_their_segment(key: int, side: int, offset: float, words: str) -> None:
    handles = np.zeros((2, 2, 2))
    handles[key, side, 0] = offset
    with pytest.raises(nk.errors.BadArgument) as caught:
        nk.Motion([0.0, 1.0], ["HeadYaw"], [[0], [1]], "bezier", [handles])
    assert words in str(caught.value)
    assert "HeadYaw" in str(caught.value)


def test_the_outermost_handles_may_have_any_length() -> None:
    # Choregraphe writes those of the first key as long as the time before it.
    handles = np.zeros((2, 2, 2))
    handles[0, 0, 0], handles[1, 1, 0] = -7.0, 7.0
    assert nk.Motion([0.0, 1.0], ["HeadYaw"], [[0], [1]], "bezier", [handles]).sample(0.5)[0] == 0.5


# --- configurations ---------------------------------------------------------------------------------------------------


def test_absent_joints_are_where_the_posture_has_them(nao: nk.NaoModel) -> None:
    motion = nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [0.5]])
    found = motion.configurations(nao, rate=10, missing="Crouch")
    expected = np.tile(nao.posture("Crouch"), (11, 1))
    expected[:, nao.joint_names.index("HeadYaw")] = np.linspace(0.0, 0.5, 11)
    assert np.allclose(found.q, expected, rtol=0, atol=1e-15)
    assert np.allclose(found.times, np.linspace(0.0, 1.0, 11))
    assert len(found) == 11


def test_held_joints_are_in_the_start_posture_or_nearest_to_zero(nao: nk.NaoModel) -> None:
    motion = nk.Motion([0.0], ["HeadYaw"], [[0.2]])
    q = nao.posture("StandInit")
    q[nao.joint_names.index("HeadYaw")] = 0.2
    assert np.array_equal(motion.configurations(nao).q, q[None])
    bare = nk.RobotModel(nao.tree)
    held = motion.configurations(bare).q[0]
    assert held[bare.joint_names.index("LElbowRoll")] == bare.upper[bare.joint_names.index("LElbowRoll")] < 0.0


def test_a_given_configuration_fills_in_with_the_base(nao: nk.NaoModel) -> None:
    floating = nk.load_nao(base="floating")
    fill = floating.neutral()
    fill[:3] = 1.0, 2.0, 3.0
    motion = nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [0.5]])
    q = motion.configurations(floating, missing=fill).q
    fill[7 + floating.joint_names.index("HeadYaw")] = 0.5
    assert np.array_equal(q[1], fill)
    assert q.shape == (2, 32)
    assert np.array_equal(motion.configurations(nao, missing=0.1).q[0], nao.configuration({"HeadYaw": 0}, missing=0.1))


@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
def test_two_hip_joints_follow_the_rule(nao: nk.NaoModel, interpolation: str) -> None:
    motion = nk.Motion(
        [[0.0, 1.0], [0.0, 2.0]],
        ["LHipYawPitch", "RHipYawPitch"],
        [[0.0, -0.2], [0.0, -0.4]],
        interpolation,  # type: ignore[arg-type]
    )
    column = nao.joint_names.index("LHipYawPitch")
    t = np.linspace(0.0, 2.0, 9)
    left, right = motion.sample(t).T
    expected = {"average": (left + right) / 2.0, "left": left, "right": right}
    for rule in get_args(nk.motion.Hips):
        assert np.allclose(motion.configurations(nao, times=t, hips=rule).q[:, column], expected[rule], atol=1e-15)


def test_a_joint_that_follows_drives_its_motor_alone(nao: nk.NaoModel) -> None:
    motion = nk.Motion([0.0], ["RHipYawPitch"], [[-0.3]])
    for rule in get_args(nk.motion.Hips):
        assert motion.configurations(nao, hips=rule).q[0, nao.joint_names.index("LHipYawPitch")] == -0.3


def test_any_mimic_joint_counts_with_its_ratio(nao: nk.NaoModel) -> None:
    follower = next(name for name, mimic in nao.mimics.items() if mimic.multiplier not in (0.0, 1.0))
    mimic = nao.mimics[follower]
    q = nk.Motion([0.0], [follower], [[0.5]]).configurations(nao).q[0]
    assert q[nao.joint_names.index(mimic.joint)] == pytest.approx((0.5 - mimic.offset) / mimic.multiplier)


def test_the_last_configuration_is_at_the_last_key(nao: nk.NaoModel) -> None:
    motion = nk.Motion([0.5, 1.0], ["HeadYaw"], [[0.0], [0.5]])
    assert np.allclose(motion.configurations(nao, rate=4).times, [0.5, 0.75, 1.0])
    assert np.allclose(motion.configurations(nao, rate=3).times, [0.5, 0.5 + 1 / 3, 1.0])
    assert np.array_equal(motion.configurations(nao).times, [0.5, 1.0])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"rate": 0.0}, "rate must be positive"),
        ({"rate": 1e9}, "more than 4000000"),
        ({"rate": 1.0, "times": [0.0]}, "give one"),
        ({"times": [[0.0]]}, "times must have shape (n,)"),
        ({"missing": "Stan"}, "unknown posture 'Stan' (nearest: Stand"),
        ({"hips": "both"}, "valid: average, left, right"),
    ],
)
def test_bad_arguments_are_named(nao: nk.NaoModel, arguments: Any, words: str) -> None:
    motion = nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [0.5]])
    with pytest.raises(nk.NaoKinError) as caught:
        motion.configurations(nao, **arguments)
    assert words in str(caught.value)


def test_joints_that_the_robot_does_not_have_are_refused(nao: nk.NaoModel) -> None:
    with pytest.raises(nk.errors.UnknownName, match="HeadYaw"):
        nk.Motion([0.0], ["HeadJaw"], [[0.0]]).configurations(nao)


# --- sides ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("LHand", "RHand"),
        ("l_elbow", "r_elbow"),
        ("elbow_l", "elbow_r"),
        ("left_elbow", "right_elbow"),
        ("leftElbow", "rightElbow"),
        ("LEFT_ELBOW", "RIGHT_ELBOW"),
        ("L", "R"),
        ("leg_left_1_joint", "leg_right_1_joint"),
        ("jLeftHip", "jRightHip"),
        ("arm.l.2", "arm.r.2"),
        ("FL_hip", "FR_hip"),
        ("LF_HAA", "RF_HAA"),
    ],
)
def test_names_say_their_side(one: str, other: str) -> None:
    assert (other_sides(one), other_sides(other)) == ([other], [one])
    assert (side_of(one), side_of(other)) == ("left", "right")


def test_names_with_more_than_one_side_have_more_than_one_other_name() -> None:
    assert other_sides("RL_hip") == ["RR_hip"]
    assert set(other_sides("RR_hip")) > {"RL_hip", "LR_hip"}  # rear right, or right rear
    assert (side_of("RL_hip"), side_of("RR_hip"), side_of("LR_hip")) == ("left", "right", "left")
    assert {"l_gripper_r_finger", "l_gripper_l_finger"} < set(other_sides("r_gripper_l_finger"))
    assert "RLEG_HIP_R" in other_sides("LLEG_HIP_R")  # the last letter is for roll


@pytest.mark.parametrize(
    "name",
    ["HeadYaw", "Lever", "Rotor", "roll", "laser", "lefty", "", "leg1_l2", "Upright", "RearJoint", "hand_ring_joint"],
)
def test_names_without_a_side_stay(name: str) -> None:
    assert other_sides(name) == []
    assert side_of(name) is None


@pytest.mark.parametrize("keys", [[[0.0, 0.0], [45.0, 0.2], [90.0, -0.1]], [[0.0, 0.0], [-30.0, 20.0], [10.0, 5.0]]])
def test_keys_in_degrees_are_noticed(keys: list[list[float]]) -> None:
    with pytest.warns(nk.errors.DegreesWarning, match="HeadYaw = (45|30) rad") as caught:
        nk.Motion([0.0, 1.0, 2.0], ["HeadYaw", "HeadPitch"], keys)
    assert caught[0].filename == __file__
    nk.Motion([0.0, 1.0, 2.0], ["HeadYaw", "HeadPitch"], np.radians(keys))
    nk.Motion([0.0, 1.0], ["wheel"], [[0.0], [8.0 * np.pi]])  # four turns
