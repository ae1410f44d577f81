"""Motions edited and mended: what each operation keeps, and what it changes by how much."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from loops import every_value, full
from made_up_robots import J, made_up
from test_checking import JOINTS, _motion
from test_motion import random_motion

import nao_kin as nk
from nao_kin.motion import (
    MendedMotion,
    check,
    clamp,
    complete,
    concatenate,
    loop,
    mirror,
    resample,
    reverse,
    share_motors,
    slow_down,
    time_warp,
)
from nao_kin.motion.interpolation import INTERPOLATIONS

SEEDS = st.integers(0, 10_000)
KINDS = st.sampled_from(INTERPOLATIONS)
MIRROR = np.diag([1.0, -1.0, 1.0, 1.0])


def _close(one: Any, other: Any, tolerance: float = 1e-9) -> bool:
    return bool(np.allclose(one, other, rtol=0, atol=tolerance))


def _between(motion: nk.Motion, count: int = 301) -> Any:
    return np.linspace(motion.start, motion.end, count)


# --- mirror -----------------------------------------------------------------------------------------------------------


@settings(max_examples=30)
@given(SEEDS, KINDS)
def test_mirrored_twice_a_motion_is_itself(nao: nk.NaoModel, seed: int, kind: str) -> None:
    motion = random_motion(seed, kind, joints=5)
    assert mirror(nao, mirror(nao, motion)) == motion


def test_names_and_axes_say_the_same_of_every_joint_of_a_nao(nao: nk.NaoModel) -> None:
    keys = np.random.default_rng(0).normal(size=(3, 26))
    motion = nk.Motion([0.0, 1.0, 2.0], nao.body_order, keys)
    signs = [1.0 if name.endswith(("Pitch", "Hand")) else -1.0 for name in nao.body_order]
    other = [{"L": "R", "R": "L"}.get(name[0], "H") + name[1:] for name in nao.body_order]
    assert mirror(nao, motion) == nk.Motion([0.0, 1.0, 2.0], other, keys * signs)
    hips = mirror(nao, nk.Motion([0.0], ["LHipYawPitch", "HeadPitch", "LHand"], [[-0.3, 0.1, 0.7]]))
    assert hips.joint_names == ("RHipYawPitch", "HeadPitch", "RHand")
    assert hips.sample(0.0).tolist() == [-0.3, 0.1, 0.7]


@pytest.mark.parametrize("version", ["v3.2", "v6"])
def test_hands_feet_and_head_of_the_mirrored_motion_are_the_mirrored_ones(version: str) -> None:
    nao = nk.load_nao(version)
    q = nao.random(3, 20)
    motion = nk.Motion(np.arange(20.0), nao.body_order, nao.to_body(q))
    mirrored = mirror(nao, motion).configurations(nao).q
    for frame, other in (("LArm", "RArm"), ("RArm", "LArm"), ("LLeg", "RLeg"), ("Head", "Head")):
        assert _close(nao.fk(mirrored, other), MIRROR @ nao.fk(q, frame) @ MIRROR, 1e-12), frame


def test_the_mirror_names_each_joints_other_side(nao: nk.NaoModel) -> None:
    assert nao.mirror_image("LShoulderRoll") == nk.semantics.Mimic("RShoulderRoll", -1.0)
    assert nao.mirror_image("RHipYawPitch") == nk.semantics.Mimic("LHipYawPitch", 1.0)
    assert nao.mirror_image("HeadYaw") == nk.semantics.Mimic("HeadYaw", -1.0)


def test_joints_of_another_robot_are_not_mirrored(nao: nk.NaoModel) -> None:
    motion = nk.Motion([0.0], ["LElbowRoll"], [[-0.3]])
    assert mirror(nao, motion) == nk.Motion([0.0], ["RElbowRoll"], [[0.3]])
    with pytest.raises(nk.errors.UnknownName):
        mirror(nao, nk.Motion([0.0], ["l_elbow"], [[0.1]]))


# --- reverse, warp, resample ------------------------------------------------------------------------------------------


@settings(max_examples=30)
@given(SEEDS, KINDS)
def test_a_reversed_motion_runs_through_the_same_values_backwards(seed: int, kind: str) -> None:
    motion = random_motion(seed, kind, room=0.9)
    back = reverse(motion)
    t = _between(motion)
    assert (back.start, back.end) == (pytest.approx(motion.start), pytest.approx(motion.end))
    assert _close(back.sample(motion.start + motion.end - t), motion.sample(t), 1e-6)
    assert _close(reverse(back).sample(t), motion.sample(t), 1e-6)


@settings(max_examples=30)
@given(SEEDS, KINDS, st.floats(0.05, 20.0))
def test_stretched_time_keeps_the_curve(seed: int, kind: str, factor: float) -> None:
    motion = random_motion(seed, kind, room=0.9)
    slow = time_warp(motion, factor)
    t = _between(motion)
    assert slow.duration == pytest.approx(factor * motion.duration)
    assert _close(slow.sample(motion.start + factor * (t - motion.start)), motion.sample(t), 1e-6)
    assert _close(time_warp(slow, 1.0 / factor).sample(t), motion.sample(t), 1e-6)


@pytest.mark.parametrize("kind", INTERPOLATIONS)
def test_any_rising_function_moves_the_keys_and_the_ends_of_handles(kind: str) -> None:
    motion = random_motion(4, kind)
    warped = time_warp(motion, np.exp)
    for before, after in zip(motion.times, warped.times, strict=True):
        assert np.array_equal(after, np.exp(before))
    assert [keys.tolist() for keys in warped.keys] == [keys.tolist() for keys in motion.keys]
    if motion.handles is not None and warped.handles is not None:
        ends = motion.times[0][:-1] + motion.handles[0][:-1, 1, 0]
        assert _close(warped.times[0][:-1] + warped.handles[0][:-1, 1, 0], np.exp(ends))
        assert np.array_equal(warped.handles[0][..., 1], motion.handles[0][..., 1])


@pytest.mark.parametrize(
    ("warp", "words"),
    [
        (0.0, "positive"),
        (-1.0, "positive"),
        (np.nan, "finite"),
        (lambda t: -t, "must ascend"),
        (lambda t: t[:0], "warped times"),
        (lambda t: t * np.nan, "finite"),
    ],
)
def test_time_never_runs_backwards(warp: Any, words: str) -> None:
    with pytest.raises(nk.NaoKinError, match=words):
        time_warp(nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [1.0]]), warp)


@pytest.mark.parametrize("kind", INTERPOLATIONS)
def test_resampled_motions_have_the_values_at_their_keys(kind: str) -> None:
    motion = random_motion(2, kind)
    found = resample(motion, 50.0)
    assert found.interpolation == "linear"
    assert np.array_equal(found.sample(found.times[0]), motion.sample(found.times[0]))
    assert (found.start, found.end) == (motion.start, motion.end)
    given_times = np.array([motion.start - 1.0, motion.start, motion.end + 1.0])
    assert np.array_equal(resample(motion, times=given_times).sample(given_times), motion.sample(given_times))
    with pytest.raises(nk.errors.BadArgument, match="a rate or times"):
        resample(motion)


# --- concatenate and loop ---------------------------------------------------------------------------------------------


@settings(max_examples=30)
@given(SEEDS, SEEDS, KINDS, KINDS, st.floats(0.1, 3.0))
def test_joined_with_a_gap_both_motions_keep_their_curves(
    seed: int, other: int, kind: str, other_kind: str, gap: float
) -> None:
    one, two = random_motion(seed, kind, room=0.9), random_motion(other, other_kind, room=0.9)
    both = concatenate([one, two], gap=gap)
    t, later = _between(one), _between(two)
    assert _close(both.sample(t), one.sample(t), 1e-6)
    assert _close(both.sample(later + one.end + gap - two.start), two.sample(later), 1e-6)
    assert both.duration == pytest.approx(one.duration + gap + two.duration)
    assert both.interpolation == ("linear" if kind == other_kind == "linear" else "bezier")


def test_a_gap_is_straight_between_lines_and_from_rest_to_rest_else() -> None:
    one = nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [1.0]])
    two = nk.Motion([0.0, 1.0], ["HeadYaw"], [[3.0], [0.0]])
    assert concatenate([one, two], gap=2.0).sample([1.5, 2.0, 3.0])[:, 0].tolist() == [1.5, 2.0, 3.0]
    smooth = concatenate([nk.Motion(one.times, one.joint_names, one.keys, "smooth"), two], gap=2.0)
    assert smooth.speed([1.0])[0, 0] == 0.0
    assert smooth.sample(2.0)[0] == pytest.approx(2.0)
    assert smooth.sample(1.5)[0] == pytest.approx(1.0 + 2.0 * (3 / 16 - 2 / 64))


def test_without_a_gap_motions_must_meet() -> None:
    one = nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [1.0]])
    two = nk.Motion([5.0, 6.0], ["HeadYaw"], [[1.0], [0.5]])
    both = concatenate([one, two])
    assert both.times[0].tolist() == [0.0, 1.0, 2.0]
    assert both.keys[0].tolist() == [0.0, 1.0, 0.5]
    with pytest.raises(nk.errors.BadArgument, match=r"HeadYaw would jump from 1 to 0 at 1 s"):
        concatenate([one, one])


def test_joints_that_only_one_of_them_names_stand_still_in_the_other() -> None:
    one = nk.Motion([[0.0, 1.0], [0.0, 0.5]], ["HeadYaw", "HeadPitch"], [[0.0, 1.0], [0.0, 0.2]])
    two = nk.Motion([0.0, 1.0], ["HeadPitch", "LHand"], [[0.3, 0.4], [0.0, 0.9]])
    both = concatenate([one, two], gap=1.0)
    assert both.joint_names == ("HeadYaw", "HeadPitch", "LHand")
    # HeadPitch holds until the end of the first motion, not only until its last key.
    expected = [[0.5, 0.2, 0.4], [1.0, 0.2, 0.4], [1.0, 0.25, 0.4], [1.0, 0.3, 0.4], [1.0, 0.0, 0.9]]
    assert _close(both.sample([0.5, 1.0, 1.5, 2.0, 3.0]), expected, 1e-15)


@pytest.mark.parametrize("kind", INTERPOLATIONS)
def test_a_blend_passes_from_the_one_to_the_other(kind: str) -> None:
    one, two = random_motion(1, kind), random_motion(2, kind)
    blend = 0.5 * min(one.duration, two.duration)
    both = concatenate([one, two], blend=blend)
    assert both.duration == pytest.approx(one.duration + two.duration - blend)
    shift = one.end - blend - two.start
    before, after = both.key_times <= one.end - blend, both.key_times >= one.end
    assert _close(both.sample(both.key_times[before]), one.sample(both.key_times[before]))
    assert _close(both.sample(both.key_times[after]), two.sample(both.key_times[after] - shift))
    middle = both.key_times[np.argmin(np.abs(both.key_times - (one.end - 0.5 * blend)))]
    s = (middle - one.end + blend) / blend
    w = 3 * s**2 - 2 * s**3
    assert _close(both.sample(middle), (1 - w) * one.sample(middle) + w * two.sample(middle - shift))


def test_keys_of_a_blend_that_rounding_tells_apart_are_one() -> None:
    one = nk.Motion([0.0, 0.64, 0.96, 1.28, 1.6, 1.92], ["HeadYaw"], np.zeros((6, 1)), "smooth")
    both = concatenate([one, one], blend=0.3)
    assert np.diff(both.key_times).min() > 1e-6
    assert both.duration == pytest.approx(2 * one.duration - 0.3)


@pytest.mark.parametrize(("n", "kind"), every_value([1, 2, 5, 8], INTERPOLATIONS))
def test_a_loop_does_the_same_again_and_again(kind: str, n: int) -> None:
    motion = random_motion(7, kind, room=0.9)
    found = loop(motion, n, gap=0.5)
    t, period = _between(motion), motion.duration + 0.5
    for turn in range(n):
        assert _close(found.sample(t + turn * period), motion.sample(t), 1e-6)
    assert found.duration == pytest.approx(n * period - 0.5)


def test_a_closed_loop_needs_no_gap() -> None:
    motion = nk.Motion([0.0, 1.0, 2.0], ["HeadYaw"], [[0.0], [1.0], [0.0]])
    assert loop(motion, 3).times[0].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    with pytest.raises(nk.errors.BadArgument, match="would jump"):
        loop(nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [1.0]]), 2)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda m: concatenate([]), "at least one"),
        (lambda m: concatenate([m, m], gap=-1.0), "gap must be a number ≥ 0"),
        (lambda m: concatenate([m, m], gap=1.0, blend=1.0), "give one"),
        (lambda m: concatenate([m, m], blend=1.5), "longer than a motion of 1 s"),
        (lambda m: loop(m, 0), "n must be at least 1"),
        (lambda m: loop(m, 1.5), "whole number"),
        (lambda m: loop(m, 10**30), "n must be at most 2000000"),
    ],
)
def test_what_cannot_be_joined_is_refused(call: Any, words: str) -> None:
    with pytest.raises(nk.errors.BadArgument, match=words):
        call(nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [1.0]]))


def test_completed_motions_name_every_motor_once(nao: nk.NaoModel) -> None:
    motion = nk.Motion([1.0, 2.0], ["RHipYawPitch"], [[0.0], [-0.1]], "bezier")
    found = complete(nao, motion, "Crouch")
    assert len(found.joint_names) == 25
    assert "LHipYawPitch" not in found.joint_names
    assert np.array_equal(found.configurations(nao).q, motion.configurations(nao, missing="Crouch").q)


# --- mending ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", [0, *full(1, 2)])
@pytest.mark.parametrize("kind", INTERPOLATIONS)
def test_clamped_motions_are_inside_all_limits(nao: nk.NaoModel, kind: str, seed: int) -> None:
    motion = _motion(nao, seed, kind)
    mended = clamp(nao, motion)
    found = {row.kind for row in check(nao, mended.motion).violations}
    assert found.isdisjoint({"limit", "coupled limit"})
    assert mended.changes
    again = clamp(nao, mended.motion)
    assert again.motion is mended.motion
    assert again.changes == ()
    # Configurations of what is clamped need no clamping.
    t = _between(mended.motion, 997)
    q = mended.motion.configurations(nao, times=t, hips="left").q
    columns = [nao.joint_names.index(joint) for joint in JOINTS if joint in nao.joint_names]
    assert nao.within_limits(q, per_joint=True)[:, columns].all()


SHORT = {
    "check": lambda nao, motion: check(nao, motion),
    "clamp": lambda nao, motion: clamp(nao, motion).motion,
    "slow_down": lambda nao, motion: slow_down(nao, motion).motion,
    "share_motors": lambda nao, motion: share_motors(nao, motion).motion,
    "complete": lambda nao, motion: complete(nao, motion),
    "mirror": lambda nao, motion: mirror(nao, motion),
    "loop": lambda nao, motion: loop(motion, 3, gap=0.5),
    "resample": lambda nao, motion: resample(motion, 10.0),
    "time_warp": lambda nao, motion: time_warp(motion, 2.0),
    "concatenate": lambda nao, motion: concatenate([motion, motion], gap=0.5),
    "reverse": lambda nao, motion: reverse(motion),
}


def _short_motions(count: int) -> Iterator[nk.Motion]:
    """Motions with one or two keys for each joint, many outside the limits and the coupled limits."""
    rng = np.random.default_rng(5)
    pairs = (("HeadYaw", "HeadPitch"), ("RAnklePitch", "RAnkleRoll"), ("LHipYawPitch", "RHipYawPitch"))
    for turn in range(count):
        names = [*pairs[turn % len(pairs)], "LHand"]
        sizes = [1] * len(names) if turn % 5 == 0 else rng.integers(1, 3, len(names)).tolist()
        times = [np.sort(rng.choice([0.0, 0.25, 0.5, 1.0], size, replace=False)) for size in sizes]
        kind = INTERPOLATIONS[turn // 3 % len(INTERPOLATIONS)]
        yield nk.Motion(times, names, [rng.uniform(-1.2, 1.2, size) for size in sizes], kind)


@pytest.mark.full
@pytest.mark.parametrize("name", SHORT)
def test_motions_of_one_and_two_keys_are_motions_like_any_other(nao: nk.NaoModel, name: str) -> None:
    mended = {"clamp": {"limit", "coupled limit"}, "share_motors": {"motor"}}
    for motion in _short_motions(18):
        found = SHORT[name](nao, motion)
        if isinstance(found, nk.Motion):
            left = {row.kind for row in check(nao, found).violations}
            assert left.isdisjoint(mended.get(name, {"speed"} if name.startswith("slow") else set()))


def test_one_key_outside_a_coupled_limit_is_moved_into_it(nao: nk.NaoModel) -> None:
    table = next(table for table in nao.coupled_limits if table.joint == "HeadPitch")
    for times in ([0.0], [0.0, 1.0]):
        motion = nk.Motion(times, ["HeadYaw", "HeadPitch"], [[1.5, 0.4]] * len(times))
        mended = clamp(nao, motion).motion
        wanted = float(np.interp(1.5, table.at, table.upper))
        assert _close(mended.sample(times), [[1.5, wanted]] * len(times))


def test_a_clamped_key_is_reported_with_its_time_and_amount(nao: nk.NaoModel) -> None:
    motion = nk.Motion([0.0, 1.0, 2.0], ["LHand"], [[0.5], [1.25], [-0.5]])
    mended = clamp(nao, motion)
    assert mended.motion.keys[0].tolist() == [0.5, 1.0, 0.0]
    (change,) = mended.changes
    assert (change.kind, change.joint, change.start, change.end, change.amount) == ("clamped", "LHand", 1.0, 2.0, 0.5)
    assert mended.describe() == "LHand: moved into its limits by up to 0.5 (1 to 2 s)"


def test_what_is_inside_is_not_touched(nao: nk.NaoModel) -> None:
    motion = nk.Motion([0.0, 10.0], ["HeadYaw", "HeadPitch"], [[0.0, 0.0], [0.5, 0.1]], "smooth")
    for mended in (clamp(nao, motion), slow_down(nao, motion), share_motors(nao, motion)):
        assert mended.motion is motion
        assert mended.describe() == "nothing had to be changed"


def test_only_handles_that_overshoot_are_moved(nao: nk.NaoModel) -> None:
    upper = float(nao.upper[nao.joint_names.index("HeadYaw")])
    handles = np.zeros((3, 2, 2))
    handles[:, 0, 0], handles[:, 1, 0] = -1.0, 1.0
    handles[0, 1, 1], handles[1, 0, 1] = 0.4, 0.4  # over the limit between the first two keys
    handles[1, 1, 1] = 0.05  # a control point above it, the curve is not
    keys = [[upper - 0.1], [upper - 0.01], [upper - 0.5]]
    motion = nk.Motion([0.0, 3.0, 6.0], ["HeadYaw"], keys, "bezier", [handles])
    mended = clamp(nao, motion).motion
    assert mended.handles is not None
    assert mended.handles[0][0, 1, 1] == pytest.approx(0.1)
    assert mended.handles[0][1, 0, 1] == pytest.approx(0.01)
    assert mended.handles[0][1, 1, 1] == 0.05
    assert check(nao, mended).ok


def test_a_linear_motion_keeps_all_that_was_inside_a_coupled_limit(nao: nk.NaoModel) -> None:
    motion = nk.Motion([0.0, 4.0], ["HeadYaw", "HeadPitch"], [[-2.0, 0.25], [0.4, 0.25]])
    mended = clamp(nao, motion)
    bad = [row for row in check(nao, motion).violations if row.kind == "coupled limit"]
    t = np.linspace(0.0, 4.0, 4001)
    outside = (t >= bad[0].start) & (t <= bad[-1].end)
    table = next(table for table in nao.coupled_limits if table.joint == "HeadPitch")
    yaw, pitch = mended.motion.sample(t).T
    assert np.all(pitch <= table.range(yaw)[1] + 1e-9)
    assert np.array_equal(mended.motion.sample(t)[:, 0], motion.sample(t)[:, 0])
    far = (t < bad[0].start - 1.0) | (t > bad[-1].end + 1.0)
    assert _close(pitch[far & ~outside], 0.25)


def test_a_joint_that_is_not_named_is_not_moved(nao: nk.NaoModel) -> None:
    motion = nk.Motion([0.0, 10.0], ["HeadYaw"], [[0.0], [1.5]])
    fill = nao.posture("StandInit")
    fill[nao.joint_names.index("HeadPitch")] = 0.4
    assert clamp(nao, motion).changes == ()
    with pytest.raises(nk.errors.BadArgument, match="the motion moves HeadYaw and not HeadPitch"):
        clamp(nao, motion, missing=fill)


@pytest.mark.full
@pytest.mark.parametrize("kind", INTERPOLATIONS)
@pytest.mark.parametrize("seed", range(2))
def test_slowed_motions_keep_every_speed_limit(nao: nk.NaoModel, kind: str, seed: int) -> None:
    motion = time_warp(_motion(nao, seed, kind), 0.3)
    mended = slow_down(nao, motion)
    assert not [row for row in check(nao, mended.motion).violations if row.kind == "speed"]
    assert mended.motion.start == motion.start
    assert mended.motion.duration > motion.duration
    assert sum(change.amount > 1.0 for change in mended.changes) == len(mended.changes) > 0


def _slowed(mended: MendedMotion, t: Any) -> Any:
    """When a slowed motion is where it was at times t."""
    longer = [(row.amount - 1.0) * np.clip(t - row.start, 0.0, row.end - row.start) for row in mended.changes]
    return t + sum(longer)


@pytest.mark.parametrize("kind", INTERPOLATIONS)
@pytest.mark.parametrize("seed", range(2))
def test_slowed_motions_go_through_the_same_configurations(nao: nk.NaoModel, kind: str, seed: int) -> None:
    motion = time_warp(_motion(nao, seed, kind), 0.3)
    mended = slow_down(nao, motion)
    t = np.linspace(motion.start, motion.end, 3001)
    assert _close(mended.motion.sample(_slowed(mended, t)), motion.sample(t), 1e-7)


@pytest.mark.parametrize("seed", range(6))
def test_what_is_clamped_and_slowed_down_keeps_coupled_limits(nao: nk.NaoModel, seed: int) -> None:
    rng = np.random.default_rng(seed)
    names = ["HeadYaw", "HeadPitch", "LShoulderPitch", "RElbowRoll"]
    times = [np.cumsum(rng.uniform(0.05, 0.2, 6)) for _ in names]
    motion = nk.Motion(times, names, [rng.uniform(-reach, reach, 6) for reach in (2.0, 0.6, 2.0, 1.5)])
    tame = clamp(nao, motion).motion
    assert slow_down(nao, tame).changes
    assert check(nao, slow_down(nao, tame).motion).ok


def test_a_curve_that_is_almost_vertical_is_slowed_down_as_it_is(nao: nk.NaoModel) -> None:
    """Its pieces would have handles that are longer than themselves, were it not cut where its time runs slowest."""
    steep = np.zeros((2, 2, 2))
    steep[0, 1], steep[1, 0] = (0.9, 0.01), (-0.95, -0.02)
    fast = nk.Motion([0.0, 0.5, 0.6, 1.0], ["LShoulderPitch"], [[0.0], [0.0], [1.5], [1.5]]).as_bezier()
    times, keys = [[0.0, 1.0], *fast.times], [[0.0, 0.05], *fast.keys]
    motion = nk.Motion(times, ["HeadYaw", "LShoulderPitch"], keys, "bezier", [steep, *(fast.handles or ())])
    mended = slow_down(nao, motion)
    t = np.linspace(0.0, 1.0, 3001)
    assert _close(mended.motion.sample(_slowed(mended, t)), motion.sample(t), 1e-7)


def test_a_straight_line_is_stretched_to_exactly_its_limit(nao: nk.NaoModel) -> None:
    limit = nao.velocity_limits[nao.joint_names.index("HeadYaw")]
    motion = nk.Motion([0.0, 1.0, 1.1, 2.0], ["HeadYaw"], [[0.0], [0.0], [1.8], [1.8]])
    mended = slow_down(nao, motion)
    assert _close(mended.motion.times[0], [0.0, 1.0, 1.0 + 1.8 / limit, 1.9 + 1.8 / limit], 1e-12)
    (change,) = mended.changes
    assert (change.start, change.end) == (1.0, 1.1)
    assert change.amount == pytest.approx(18.0 / limit)


def test_other_joints_are_slowed_down_with_the_one_that_is_too_fast(nao: nk.NaoModel) -> None:
    motion = nk.Motion([[0.0, 0.1], [0.0, 0.05, 0.1]], ["HeadYaw", "HeadPitch"], [[0.0, 1.6], [0.0, 0.1, 0.2]])
    mended = slow_down(nao, motion).motion
    assert mended.times[0][-1] == pytest.approx(mended.times[1][-1])
    t = np.linspace(0.0, 1.0, 11)
    assert _close(mended.sample(t * mended.end), motion.sample(t * motion.end))


def test_what_no_time_is_long_enough_for_is_refused(nao: nk.NaoModel, tmp_path: Path) -> None:
    handles = np.zeros((2, 2, 2))
    handles[0, 1] = 0.0, 0.5
    with pytest.raises(nk.errors.BadArgument, match="LHand moves in no time between its keys 0 and 1"):
        slow_down(nao, nk.Motion([0.0, 1.0], ["LHand"], [[0.0], [1.0]], "bezier", [handles]))
    held = made_up(tmp_path, J("a"), J("b", follows=("a", 0.0, 0.0)))
    with pytest.raises(nk.errors.BadArgument, match="its speed limit is 0"):
        slow_down(held, nk.Motion([0.0, 1.0], ["b"], [[0.0], [1.0]]))


@pytest.mark.full
@pytest.mark.parametrize("rule", get_args(nk.motion.Hips))
@pytest.mark.parametrize("kind", INTERPOLATIONS)
@pytest.mark.parametrize("seed", range(2))
def test_hips_that_share_a_motor_agree_as_the_rule_says(nao: nk.NaoModel, kind: str, seed: int, rule: Any) -> None:
    motion = _motion(nao, seed, kind)
    mended = share_motors(nao, motion, rule)
    assert not [row for row in check(nao, mended.motion).violations if row.kind == "motor"]
    t = _between(motion)
    column = nao.joint_names.index("LHipYawPitch")
    wanted = motion.configurations(nao, times=t, hips=rule).q[:, column]
    assert _close(mended.motion.configurations(nao, times=t).q[:, column], wanted, 0.02 if rule == "average" else 1e-9)
    assert {change.kind for change in mended.changes} <= {"one motor", "resampled"}


def test_the_average_of_curves_with_equal_key_times_is_exact(nao: nk.NaoModel) -> None:
    motion = nk.Motion(
        [0.0, 1.0, 3.0], ["LHipYawPitch", "RHipYawPitch"], [[0.0, 0.0], [0.2, 0.4], [-0.2, -0.3]], "smooth"
    )
    mended = share_motors(nao, motion).motion
    t = _between(motion)
    assert mended.interpolation == "bezier"
    assert _close(mended.sample(t), motion.sample(t).mean(axis=1, keepdims=True), 1e-12)


def _handles(rises: Any) -> Any:
    """Handles of half a second on both sides of three keys, one second apart, with rises (3, 2)."""
    handles = np.zeros((3, 2, 2))
    handles[1:, 0, 0], handles[:-1, 1, 0] = -0.5, 0.5
    handles[..., 1] = rises
    return handles


def test_the_average_of_bezier_curves_has_the_handles_of_both(nao: nk.NaoModel) -> None:
    rises = ([[0.0, 0.1], [-0.1, 0.05], [0.02, 0.0]], [[0.0, -0.08], [0.03, -0.02], [0.06, 0.0]])
    keys = [[0.0, -0.1], [-0.2, -0.3], [-0.1, -0.2]]
    motion = nk.Motion(
        [0.0, 1.0, 2.0], ["LHipYawPitch", "RHipYawPitch"], keys, "bezier", [_handles(rise) for rise in rises]
    )
    mended = share_motors(nao, motion).motion
    t = _between(motion)
    assert np.ptp(motion.sample(t), axis=1).max() > 0.1
    assert _close(mended.sample(t), motion.sample(t).mean(axis=1, keepdims=True), 1e-12)


@pytest.mark.parametrize("multiplier", [-2.0, 0.5])
@pytest.mark.parametrize("rule", get_args(nk.motion.Hips))
def test_the_handles_of_a_follower_are_scaled_as_its_values(tmp_path: Path, multiplier: float, rule: Any) -> None:
    robot = made_up(tmp_path, J("left_drive"), J("right_follow", follows=("left_drive", multiplier, 0.1)))
    rises = np.array([[0.0, 0.1], [-0.1, 0.05], [0.02, 0.0]])
    drive, follow = np.array([0.0, 0.3, 0.1]), np.array([0.2, 0.4, -0.1])
    motion = nk.Motion(
        [0.0, 1.0, 2.0],
        ["left_drive", "right_follow"],
        np.stack([drive, follow], axis=-1),
        "bezier",
        [_handles(rises), _handles(-0.4 * rises)],
    )
    mended = share_motors(robot, motion, rule).motion
    t = _between(motion)
    left, right = motion.sample(t).T
    both = {"left": left, "right": (right - 0.1) / multiplier}
    wanted = both.get(rule, 0.5 * (both["left"] + both["right"]))
    assert _close(mended.sample(t), np.stack([wanted, multiplier * wanted + 0.1], axis=-1), 1e-12)


def test_changes_are_said_in_degrees_and_as_json(nao: nk.NaoModel) -> None:
    motion = nk.Motion([0.0, 10.0], ["HeadYaw"], [[0.0], [math.radians(129.5)]])
    mended = clamp(nao, motion)
    assert mended.describe(degrees=True) == "HeadYaw: moved into its limits by up to 10° (10 s)"
    assert mended.changes[0].as_dict()["amount"] == pytest.approx(math.radians(10.0))


def test_a_blend_may_be_as_long_as_a_motion_and_begins_at_a_key() -> None:
    short = nk.Motion([0.0, 0.5], ["HeadYaw"], [[0.0], [0.2]])
    assert concatenate([short, short], blend=0.5).end == 0.5
    with pytest.raises(nk.errors.BadArgument, match="longer than a motion of 0.5 s"):
        concatenate([short, short], blend=0.5 + 1e-9)
    curved = nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [0.5]], "smooth")
    blended = concatenate([curved, curved], blend=0.1234567)
    begin = 1.0 - 0.1234567
    assert begin in blended.times[0]
    assert blended.sample(begin) == pytest.approx(curved.sample(begin), abs=1e-15)


def test_bezier_motions_that_meet_keep_the_handles_on_both_sides() -> None:
    handles = np.zeros((2, 2, 2))
    handles[0, 1], handles[1, 0] = (0.6, 0.3), (-0.5, -0.2)
    one = nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [1.0]], "bezier", [handles])
    two = nk.Motion([0.0, 1.0], ["HeadYaw"], [[1.0], [0.0]], "bezier", [handles])
    both = concatenate([one, two])
    assert len(both.keys[0]) == 3
    t = np.linspace(0.0, 1.0, 101)
    assert _close(both.sample(t), one.sample(t))
    assert _close(both.sample(1.0 + t), two.sample(t))


def test_only_what_is_too_fast_takes_longer(nao: nk.NaoModel) -> None:
    times = [0.0, 1.0, 2.0, 2.05, 3.0, 4.0]
    keys = [[0.0], [0.1], [0.2], [1.2], [1.3], [1.2]]
    for kind in INTERPOLATIONS:
        motion = nk.Motion(times, ["HeadYaw"], keys, kind)
        widths = np.diff(slow_down(nao, motion).motion.times[0])
        assert widths[2] > 0.1
        assert _close(widths[[0, 4]], 1.0, 1e-12), kind


def test_the_mirror_reads_the_axes_of_any_robot(tmp_path: Path) -> None:
    tilt = (0.3, 0.2, 0.1)
    robot = made_up(
        tmp_path,
        J("waist", axis=(0.0, 0.0, 1.0)),
        J("left_lift", kind="prismatic", axis=(0.0, 1.0, 1.0), xyz=(0.0, 0.1, 0.0), parent="waist"),
        J("right_lift", kind="prismatic", axis=(0.0, 1.0, -1.0), xyz=(0.0, -0.1, 0.0), parent="waist"),
        J("left_turn", axis=(1.0, 0.5, 0.2), rpy=tilt, xyz=(0.1, 0.2, 0.0), parent="left_lift"),
        J("right_turn", axis=(1.0, -0.5, 0.2), rpy=(-0.3, 0.2, -0.1), xyz=(0.1, -0.2, 0.0), parent="right_lift"),
        J("right_odd", axis=(1.0, 0.0, 0.0), parent="right_turn"),
        J("left_odd", axis=(0.0, 1.0, 0.0), parent="left_turn"),
    )
    names = ["waist", "left_lift", "right_lift", "left_turn", "right_turn"]
    motion = nk.Motion(np.arange(5.0), names, np.random.default_rng(0).normal(size=(5, 5)) * 0.5)
    mirrored = mirror(robot, motion)
    assert mirror(robot, mirrored) == motion
    q, images = motion.configurations(robot).q, mirrored.configurations(robot).q
    # The links' frames are not mirrored onto each other, but their origins are.
    for frame, other in (("left_turn", "right_turn"), ("right_turn", "left_turn"), ("left_lift", "right_lift")):
        assert _close(robot.position(images, other), robot.position(q, frame) * (1.0, -1.0, 1.0), 1e-12), frame
    with pytest.raises(nk.errors.BadArgument, match="left_odd and right_odd are not mirror images"):
        mirror(robot, nk.Motion([0.0], ["left_odd"], [[0.1]]))


def test_keys_within_a_tolerance_of_the_lines_between_others_are_left_out(nao: nk.NaoModel) -> None:
    times = np.arange(201) / 50.0
    swing = 0.4 * np.sin(2.0 * times)
    dense = nk.Motion(times, ["HeadYaw", "LElbowYaw"], np.stack([swing, 0.0 * times], axis=1))
    few = nk.motion.resample(dense, times=times, tolerance=0.01)
    assert np.abs(few.sample(times) - dense.sample(times)).max() <= 0.01
    assert 8 < len(few.times[0]) < 30
    assert few.times[1].tolist() == [0.0, 4.0]
    assert set(few.times[0]) <= set(times)
    for column in (0, 1):
        steepest = [np.abs(np.diff(m.keys[column]) / np.diff(m.times[column])).max() for m in (few, dense)]
        assert steepest[0] <= steepest[1] + 1e-12
    # An ankle that follows its narrowing range leaves it on the lines between few keys; not if the robot is known.
    pitch = np.linspace(-1.15, -0.4, 201)
    (table,) = (row for row in nao.coupled_limits if row.joint == "LAnkleRoll")
    edge = nk.Motion(times, ["LAnklePitch", "LAnkleRoll"], np.stack([pitch, table.range(pitch)[1]], axis=1))
    rolls = [nk.motion.resample(edge, times=times, tolerance=0.1, robot=robot) for robot in (None, nao)]
    over = [(m.sample(times)[:, 1] - table.range(m.sample(times)[:, 0])[1]).max() for m in rolls]
    assert over[0] > 1e-3
    assert over[1] <= 1e-6
    with pytest.raises(nk.errors.BadArgument, match="tolerance must be a number"):
        nk.motion.resample(dense, times=times, tolerance=-1.0)
