"""A robot that follows a person while they move."""

from __future__ import annotations

import json

import numpy as np
import pytest

import nao_kin as nk
from nao_kin.errors import BadArgument, UnknownName, WrongShape
from nao_kin.imitation import Imitator, Skeleton, imitate


@pytest.fixture(scope="module")
def landmarks() -> np.ndarray:
    with open(nk.imitation.SAMPLES["bow"], encoding="utf-8") as file:
        return np.array(json.load(file)["landmarks"])


def test_a_person_who_stays_is_reached_within_speed_limits(nao: nk.NaoModel, landmarks: np.ndarray) -> None:
    follower, rows = Imitator(nao, weights={"upper_arm": 2.0}), [nao.posture("StandInit")]
    for k in range(40):
        rows.append(follower.step(landmarks[0], 0.04 * k))
    speeds = np.abs(np.diff(rows, axis=0)) / 0.04
    limits = np.array([nao.joints.limits(name)[2] for name in nao.joint_names])
    assert (speeds <= limits + 1e-9).all()
    assert speeds.max() > 1.0
    still = Skeleton.from_landmarks(landmarks[0], "mediapipe")
    wanted = imitate(nao, still, legs="ignore", collisions=False, cutoff=0.0, weights={"upper_arm": 2.0}).q[0]
    np.testing.assert_allclose(rows[-1], wanted, atol=1e-6)


def test_frames_of_a_person_who_moves_are_followed_closely(nao: nk.NaoModel, landmarks: np.ndarray) -> None:
    follower = Imitator(nao, cutoff=0.0)
    seen = landmarks * (1.0, 1.0, 1.0, 0.0) + (0.0, 0.0, 0.0, 1.0)
    follower.step(seen[0], -2.0)
    q = [follower.step(frame, 2.0 * k) for k, frame in enumerate(seen)]  # slow enough for all joints
    whole = Skeleton.from_landmarks(seen, "mediapipe", times=2.0 * np.arange(len(seen)))
    made = imitate(nao, whole, legs="ignore", collisions=False, cutoff=0.0)
    # ElbowYaw of a straight arm differs: frames alone do not know the next ones.
    for side in "LR":
        for frame in ("Elbow", "WristYaw"):
            own, whole_path = (nao.fk(np.array(each), side + frame)[:, :3, 3] for each in (q, made.q))
            assert np.linalg.norm(own - whole_path, axis=1).max() < 0.01


def test_named_points_and_a_mirror(nao: nk.NaoModel, landmarks: np.ndarray) -> None:
    seen = Skeleton.from_landmarks(landmarks[10], "mediapipe")
    points = {name: p[0] for name, p in seen.points.items()}
    one, other, image_of = (Imitator(nao, cutoff=0.0, mirror=mirror) for mirror in (False, False, True))
    for time in (0.0, 2.0):
        own, same, image = (
            follower.step(frame, time)
            for follower, frame in ((one, points), (other, landmarks[10]), (image_of, landmarks[10]))
        )
    np.testing.assert_allclose(own, same, atol=1e-12)
    columns = [nao.joint_names.index(name) for name in one.joints]
    assert np.abs(one.q - nao.mirror(image))[columns].max() < 1e-9


def test_arms_or_head_may_stay(nao: nk.NaoModel, landmarks: np.ndarray) -> None:
    whole, without_arms, without_head = Imitator(nao), Imitator(nao, arms=False), Imitator(nao, head=False)
    for follower in (whole, without_arms, without_head):
        follower.step(landmarks[0], 0.0)
        follower.step(landmarks[-1], 2.0)
    head, stand = [nao.joint_names.index(name) for name in ("HeadYaw", "HeadPitch")], nao.posture("StandInit")
    arms = [k for k, name in enumerate(nao.joint_names) if name in whole.joints and k not in head]
    for still, moving, q in ((arms, head, without_arms.q), (head, arms, without_head.q)):
        np.testing.assert_allclose(q[still], stand[still], atol=1e-12)
        np.testing.assert_allclose(q[moving], whole.q[moving], atol=1e-12)
        assert np.abs(whole.q - stand)[still].max() > 0.02


def test_points_that_are_lost_keep_their_places(nao: nk.NaoModel, landmarks: np.ndarray) -> None:
    follower = Imitator(nao)
    for k in range(50):
        follower.step(landmarks[0], 0.04 * k)
    before = follower.q
    lost = landmarks[0].copy()
    lost[:, :3] += np.random.default_rng(0).normal(0.0, 1.0, (33, 3))
    lost[:, 3] = 0.1
    np.testing.assert_allclose(follower.step(lost, 2.1), before, atol=1e-6)
    lost[:, 0] = np.nan
    np.testing.assert_allclose(follower.step(lost, 2.2), before, atol=1e-6)


def test_a_first_frame_without_a_person_leaves_the_robot_as_it_is(nao: nk.NaoModel) -> None:
    follower = Imitator(nao)
    for time in (0.0, 1.0):
        q = follower.step(np.full((33, 3), np.nan), time)
        np.testing.assert_allclose(q, nao.posture("StandInit"), atol=1e-12)


def test_names_and_arrays_may_take_turns(nao: nk.NaoModel, landmarks: np.ndarray) -> None:
    seen = landmarks * (1.0, 1.0, 1.0, 0.0) + (0.0, 0.0, 0.0, 1.0)
    whole = Skeleton.from_landmarks(seen, "mediapipe", times=2.0 * np.arange(len(seen)))
    arrays, turns, few = (Imitator(nao, cutoff=0.0) for _ in range(3))
    for k, frame in enumerate(seen):
        named = {name: whole.points[name][k] for name in reversed(whole.names)}
        left = {name: point for name, point in named.items() if name.startswith("left") or "shoulder" in name}
        q = arrays.step(frame, 2.0 * k)
        np.testing.assert_allclose(turns.step(named if k % 2 else frame, 2.0 * k), q, atol=1e-9)
        if k % 2:
            few.step(left, 2.0 * k)
        else:
            np.testing.assert_allclose(few.step(frame, 2.0 * k), q, atol=0.2)


def test_a_configuration_that_is_changed_outside_changes_nothing(nao: nk.NaoModel, landmarks: np.ndarray) -> None:
    one, other = Imitator(nao), Imitator(nao)
    for k, frame in enumerate(landmarks.copy()):
        q = one.step(frame, 0.1 * k)
        np.testing.assert_array_equal(other.step(frame, 0.1 * k), q)
        q += 1.0
        one.q[:] = 2.0
        frame[:] = np.nan  # a camera that writes into one buffer
    with pytest.raises(AttributeError):
        one.q = q  # type: ignore[misc]


def test_smpl_may_have_hands_or_none(nao: nk.NaoModel) -> None:
    joints = np.random.default_rng(0).normal(size=(24, 3))
    whole, body = (Imitator(nao, "smpl", up="y").step(joints[:count], 0.0) for count in (24, 22))
    np.testing.assert_allclose(whole, body)


def test_the_axis_that_points_up_may_be_stated(nao: nk.NaoModel, landmarks: np.ndarray) -> None:
    usual, turned = Imitator(nao), Imitator(nao, up="-z")  # mediapipe has -y, which the axes in another order call -z
    seen = landmarks[10][:, :3].copy()
    seen[23:25] = np.nan  # without hips, the trunk is taken as vertical
    for time in (0.0, 2.0):
        q = usual.step(seen, time)
        np.testing.assert_allclose(turned.step(seen[:, [2, 0, 1]], time), q, atol=1e-9)
    assert np.abs(q - nao.posture("StandInit")).max() > 0.1


def test_fast_motion_is_damped_as_by_a_filter_of_first_order(nao: nk.NaoModel, landmarks: np.ndarray) -> None:
    first, second = (landmarks[k][:, :3] for k in (0, 10))
    damped, direct = Imitator(nao, cutoff=0.4), Imitator(nao, cutoff=0.0)
    share = 1.0 - np.exp(-2.0 * np.pi * 0.4 * 0.3)
    for follower, seen in ((damped, second), (direct, first + share * (second - first))):
        follower.step(first, 0.0)
        follower.step(seen, 0.3)
    np.testing.assert_allclose(damped.q, direct.q, atol=1e-9)


def test_confidence_is_in_the_levels_of_the_source(nao: nk.NaoModel) -> None:
    points = np.random.default_rng(0).normal(size=(25, 3))
    for confidence, seen in ((0.9, False), (1.0, True)):  # of 2 at most, for a Kinect
        follower = Imitator(nao, "kinect_v2")
        for time in (0.0, 2.0):
            q = follower.step(np.column_stack([points, np.full(25, confidence)]), time)
        assert (np.abs(q - nao.posture("StandInit")).max() > 0.01) == seen


def test_wrong_input_is_refused(nao: nk.NaoModel, landmarks: np.ndarray) -> None:
    with pytest.raises(UnknownName, match="unknown source 'mediapip' .nearest: mediapipe."):
        Imitator(nao, "mediapip")
    with pytest.raises(BadArgument, match="coco17 has no fixed axes"):
        Imitator(nao, "coco17")
    assert Imitator(nao, "coco17", up="-y").step(np.random.default_rng(0).normal(size=(17, 3)), 0.0).shape == (25,)
    follower = Imitator(nao)
    follower.step(landmarks[0], 1.0)
    with pytest.raises(BadArgument, match="time must be later than 1 s"):
        follower.step(landmarks[0], 1.0)
    with pytest.raises(WrongShape, match="33, 3 or 4"):
        follower.step(landmarks[0, :, :2], 2.0)
    with pytest.raises(UnknownName, match="unknown point 'left_elbo'"):
        follower.step({"left_elbo": [0.0, 0.0, 0.0]}, 2.0)
