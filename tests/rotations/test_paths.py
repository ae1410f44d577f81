from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from rotation_samples import PROPERTY, quaternions, random_rotations, worst
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, RotationSpline as ScipySpline

from nao_kin.errors import BadArgument, NotARotation, NotFinite, UnknownName, WrongShape, ZeroNorm
from nao_kin.rotations import (
    RotationSpline,
    _spline as _spline_velocities,
    exp,
    log,
    matrix_from_quat,
    quat_from_matrix,
    quat_unwrap,
    random_rotation_near,
    rot_x,
    rot_z,
    slerp,
    vee,
)

ONE = np.array([1.0, 0.0, 0.0, 0.0])
AXIS = np.array([0.48, -0.6, 0.64])


def about(axis, angle):
    return np.array([math.cos(angle / 2), *(math.sin(angle / 2) * np.asarray(axis))])


@PROPERTY
@given(p=quaternions, q=quaternions)
def test_the_longer_arc_ends_where_the_shorter_one_does_and_makes_it_a_circle(p, q):
    if min(worst(p, q), worst(p, -q)) < 1e-12:
        return
    shorter, longer = slerp(p, q, 0.5), slerp(p, q, 0.5, arc="longer")
    assert worst(matrix_from_quat(slerp(p, q, 1.0, arc="longer")), matrix_from_quat(q)) < 1e-14
    assert worst(slerp(p, q, 0.0, arc="longer"), p / np.linalg.norm(p)) < 1e-15
    # The middles of the two arcs are opposite points of one circle: half a turn apart.
    assert abs(shorter @ longer) < 1e-15 / min(worst(p, q), worst(p, -q)) + 1e-15
    assert abs(np.linalg.norm(longer) - 1.0) < 1e-15


@pytest.mark.parametrize("angle", [1e-9, 1e-3, 0.5, 2.0, 3.1, math.pi - 1e-9, math.pi])
def test_the_longer_arc_turns_the_other_way_by_the_rest_of_a_turn(angle):
    q = about(AXIS, angle)
    for t in (0.0, 0.3, 0.5, 1.0, 1.5):
        found = slerp(ONE, q, t, arc="longer")
        expected = about(AXIS, -t * (2 * math.pi - angle))
        if angle == math.pi:
            expected = min((expected, about(AXIS, t * math.pi)), key=lambda x: worst(x, found))
        assert worst(found, expected) < 1e-15 + 1e-15 / angle
        assert worst(slerp(ONE, -q, t, arc="longer"), found) < 1e-15 + 1e-15 / angle or angle == math.pi


def test_the_longer_arc_between_equal_rotations_is_refused():
    for q in (ONE, -ONE, 7.0 * ONE):
        with pytest.raises(BadArgument, match="the longer arc between two equal rotations is a whole turn"):
            slerp(ONE, q, 0.5, arc="longer")
    with pytest.raises(BadArgument, match=r"at index \[1\]"):
        slerp(ONE, [about(AXIS, 1.0), ONE], 0.5, arc="longer")
    with pytest.raises(UnknownName, match="unknown arc"):
        slerp(ONE, ONE, 0.5, arc="long")


def wavering_path(n, seed=0):
    rng = np.random.default_rng(seed)
    steps = rng.normal(scale=0.3, size=(n, 3))
    path = [ONE]
    for step in steps[1:]:
        path.append(quat_from_matrix(matrix_from_quat(path[-1]) @ exp(step)))
    return np.array(path)


def test_a_path_of_quaternions_is_unwrapped_to_be_continuous():
    smooth = quat_unwrap(wavering_path(200))
    assert ((smooth[1:] * smooth[:-1]).sum(axis=-1) > 0.5).all()
    flips = np.random.default_rng(1).choice([-1.0, 1.0], 200)
    flips[0] = 1.0
    assert (quat_unwrap(flips[:, None] * smooth) == smooth).all()
    assert (quat_unwrap(-flips[:, None] * smooth) == -smooth).all()


def test_a_whole_turn_ends_at_the_negative_of_its_beginning():
    angles = np.linspace(0.0, 2 * math.pi, 50)
    q = quat_unwrap(quat_from_matrix(rot_z(angles)))
    assert worst(q, [about([0, 0, 1], a) for a in angles]) < 1e-15


def test_at_exactly_half_a_turn_the_sign_relative_to_the_one_before_stays():
    one, minus_one = [1.0, 0.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0]
    x, minus_x = [0.0, 1.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0]
    assert quat_unwrap([one, x, one]).tolist() == [one, x, one]
    assert quat_unwrap([one, minus_x]).tolist() == [one, minus_x]
    assert quat_unwrap([one, minus_one, x, minus_x]).tolist() == [one, one, minus_x, minus_x]


def test_many_paths_are_unwrapped_each_alone():
    paths = np.stack([wavering_path(30, seed) for seed in range(4)])
    expected = np.stack([quat_unwrap(path) for path in paths])
    assert (quat_unwrap(paths) == expected).all()
    for shape in ((0, 4), (3, 0, 4), (0, 3, 4), (1, 4)):
        assert quat_unwrap(np.ones(shape)).shape == shape


def test_what_is_no_path_of_quaternions_is_refused():
    with pytest.raises(WrongShape, match="path"):
        quat_unwrap(ONE)
    with pytest.raises(WrongShape):
        quat_unwrap(np.ones((5, 3)))
    with pytest.raises(NotFinite):
        quat_unwrap([ONE, [1, math.nan, 0, 0]])
    with pytest.raises(ZeroNorm, match=r"at index \[1\]"):
        quat_unwrap([ONE, np.zeros(4)])


def keys(n, sigma, seed=0):
    rng = np.random.default_rng(seed)
    path = [np.eye(3)]
    for _ in range(n - 1):
        path.append(random_rotation_near(path[-1], sigma, rng))
    return np.cumsum(rng.uniform(0.5, 2.0, n)), np.array(path)


@pytest.mark.parametrize("n", [2, 3, 4, 5, 8, 21])
def test_the_spline_is_scipys_where_that_has_converged(n):
    times, path = keys(n, 0.2)
    ours, theirs = RotationSpline(times, path), ScipySpline(times, Rotation.from_matrix(path))
    t = np.linspace(times[0], times[-1], 301)
    assert worst(ours(t), theirs(t).as_matrix()) < 1e-11
    assert worst(ours.angular_velocity(t, expressed_in="moving"), theirs(t, 1)) < 1e-10
    assert worst(ours.angular_acceleration(t, expressed_in="moving"), theirs(t, 2)) < 1e-9


@pytest.mark.parametrize("sigma", [0.1, 0.8, 2.0])
@pytest.mark.parametrize("n", [3, 4, 9, 40])
def test_the_spline_meets_its_keys_and_nothing_jumps_at_them(n, sigma):
    times, path = keys(n, sigma, seed=n)
    spline = RotationSpline(times, path)
    assert worst(spline(times), path) < 2e-15
    before, after = times[1:-1] - 1e-9, times[1:-1] + 1e-9
    for derivative in (spline.angular_velocity, spline.angular_acceleration):
        for side in ("fixed", "moving"):
            jump = derivative(after, expressed_in=side) - derivative(before, expressed_in=side)
            assert np.abs(jump).max() < 1e-6


def test_a_few_steps_of_newton_are_enough_for_many_keys(monkeypatch):
    monkeypatch.setattr(_spline_velocities, "_MAX_STEPS", 5)
    for n in (50, 101):
        times, path = keys(n, 0.8, seed=n)
        assert RotationSpline(times, path).velocities.shape == (n, 3)


def test_velocities_and_accelerations_are_derivatives():
    times, path = keys(6, 1.0, seed=3)
    spline, h = RotationSpline(times, path), 1e-5
    t = np.random.default_rng(0).uniform(times[0] + h, times[-1] - h, 200)
    change = (spline(t + h) - spline(t - h)) / (2 * h)
    R = spline(t)
    for side, W in (("fixed", change @ np.swapaxes(R, -1, -2)), ("moving", np.swapaxes(R, -1, -2) @ change)):
        found = spline.angular_velocity(t, expressed_in=side)
        assert worst(vee((W - np.swapaxes(W, -1, -2)) / 2), found) < 1e-7
        ahead, behind = (spline.angular_velocity(t + s * h, expressed_in=side) for s in (1, -1))
        assert worst((ahead - behind) / (2 * h), spline.angular_acceleration(t, expressed_in=side)) < 1e-5


def test_about_one_axis_it_is_the_cubic_spline_of_the_angle():
    times, angles = np.array([0.0, 1.0, 1.5, 3.0]), np.array([0.0, 0.7, -0.4, 1.2])
    spline = RotationSpline(times, rot_x(angles), start=[0.5, 0, 0], end=[0, 0, 0])
    known = CubicSpline(times, angles, bc_type=((1, 0.5), (1, 0.0)))
    t = np.linspace(0.0, 3.0, 61)
    assert worst(spline(t), rot_x(known(t))) < 2e-15
    assert worst(spline.angular_velocity(t, expressed_in="fixed")[:, 0], known(t, 1)) < 1e-14
    assert worst(spline.velocities[[0, -1]], [[0.5, 0, 0], [0, 0, 0]]) == 0.0


def test_two_keys_without_velocities_are_joined_at_constant_velocity():
    p, q = np.array([0.5, 0.5, 0.5, 0.5]), quat_from_matrix(exp([0.6, -0.8, 1.8]))
    spline = RotationSpline([1.0, 3.0], matrix_from_quat(np.array([p, q])))
    t = np.linspace(0.0, 1.0, 11)
    assert worst(spline(1.0 + 2.0 * t), matrix_from_quat(slerp(p, q, t))) < 2e-15
    velocity = spline.angular_velocity(1.0 + 2.0 * t, expressed_in="moving")
    assert worst(velocity, log(matrix_from_quat(p).T @ matrix_from_quat(q)) / 2.0) < 1e-15


def test_the_ends_of_a_spline_have_the_velocities_given():
    times, path = keys(5, 0.7, seed=5)
    start, end = [0.1, -0.2, 0.3], [1.0, 0.0, -1.0]
    spline = RotationSpline(times, path, start=start, end=end)
    assert worst(spline.angular_velocity(times[0], expressed_in="moving"), start) < 1e-15
    assert worst(spline.angular_velocity(times[-1], expressed_in="moving"), end) < 5e-15
    assert worst(spline.angular_velocity(times[-1], expressed_in="fixed"), path[-1] @ end) < 5e-15


def test_paths_in_batches_share_their_times():
    times, _ = keys(6, 0.5)
    paths = np.stack([keys(6, 0.5, seed)[1] for seed in range(4)])
    together = RotationSpline(times, paths.reshape(2, 2, 6, 3, 3))
    t = np.linspace(times[0], times[-1], 10).reshape(5, 2)
    assert together(t).shape == (2, 2, 5, 2, 3, 3)
    assert together.angular_velocity(times[0], expressed_in="fixed").shape == (2, 2, 3)
    for i, path in enumerate(paths):
        alone = RotationSpline(times, path)
        assert worst(together(t)[i // 2, i % 2], alone(t)) < 1e-14
        assert worst(together.velocities[i // 2, i % 2], alone.velocities) < 1e-13
    assert RotationSpline(times, paths[:0])(t).shape == (0, 5, 2, 3, 3)


def test_what_makes_no_spline_is_refused():
    R = random_rotations(3)
    with pytest.raises(BadArgument, match="at least two"):
        RotationSpline([0.0], R[:1])
    with pytest.raises(BadArgument, match="times must increase, got 1 and then 1 at 2"):
        RotationSpline([0.0, 1.0, 1.0], R)
    with pytest.raises(WrongShape, match="one for each time"):
        RotationSpline([0.0, 1.0], R)
    with pytest.raises(NotARotation):
        RotationSpline([0.0, 1.0, 2.0], 2.0 * R)
    spline = RotationSpline([0.0, 1.0, 2.0], R)
    with pytest.raises(BadArgument, match=r"t must be from 0 to 2, got 2.5 at index \[1\]"):
        spline([0.0, 2.5])
    with pytest.raises(NotFinite):
        spline(math.nan)
    with pytest.raises(BadArgument, match="expressed_in="):
        spline.angular_velocity(1.0)
    with pytest.raises(ValueError, match="read-only"):
        spline.keys[0] = 0.0
