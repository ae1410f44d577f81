from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st
from rotation_samples import DISTANCES, PROPERTY, many_axes, matrices, random_rotations, worst
from scipy.spatial.transform import Rotation

from nao_kin.errors import BadArgument, DegeneratePoints, NotFinite, WrongShape, ZeroNorm
from nao_kin.rotations import (
    check_rotation,
    exp,
    matrix_from_natural,
    natural_invariants,
    rot_x,
    rot_y,
    rot_z,
    rotation_between,
    rotation_from_directions,
    rotation_from_points,
)

X, Y, Z = np.eye(3)


def aside(a):
    """Unit vectors normal to those of a."""
    normal = np.cross(a, np.eye(3)[np.abs(a).argmin(axis=-1)])
    return normal / np.linalg.norm(normal, axis=-1, keepdims=True)


def times(R, v):
    return np.einsum("...ij,...j->...i", R, v)


def test_the_rotation_between_two_directions_takes_one_to_the_other_about_their_normal():
    a, b = many_axes(500, seed=0), many_axes(500, seed=1)
    R = rotation_between(a, b)
    check_rotation(R, 3e-15)
    assert worst(times(R, a), b) < 1.5e-15
    _, angle = natural_invariants(R)
    assert worst(angle, np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), (a * b).sum(axis=-1))) < 2e-15
    either = angle > math.pi - 1e-14
    assert worst(rotation_between(b, a)[~either], np.swapaxes(R, -1, -2)[~either]) < 2e-15


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_directions_nearly_equal_or_opposite_are_met_as_well(side):
    a, distance = many_axes(500, seed=2), 10.0 ** np.linspace(-18.0, -0.5, 500)
    b = side * np.cos(distance)[:, None] * a + np.sin(distance)[:, None] * aside(a)
    R = rotation_between(a, b)
    assert worst(times(R, a), b / np.linalg.norm(b, axis=-1, keepdims=True)) < 2e-15
    check_rotation(R, 3e-15)
    _, angle = natural_invariants(R)
    assert worst(angle, distance if side > 0 else math.pi - distance) < 2e-15


def test_small_angles_between_directions_keep_their_relative_accuracy():
    for distance in DISTANCES[2:13]:
        R = rotation_between(X, [1.0, distance, 0.0])
        assert R[1, 0] == pytest.approx(math.sin(math.atan(distance)), rel=1e-15, abs=0.0)
    assert worst(rotation_between(X, X), np.eye(3)) == 0.0
    a = np.array([0.3, -0.2, 7.0])
    assert worst(rotation_between(a, 3.0 * a), np.eye(3)) < 3e-16


def test_beside_opposite_directions_the_axis_is_their_normal():
    for distance in (1e-12, 1e-9, 1e-6, 1e-3):
        R = rotation_between(X, [-math.cos(distance), math.sin(distance), 0.0], axis=Y)
        assert worst(R, rot_z(math.pi - distance)) < 2e-15


@pytest.mark.parametrize(
    ("a", "turn"),
    [(X, rot_y), (-X, rot_y), (Y, rot_x), (Z, rot_x), (-Z, rot_x), ([0, 1, 1], rot_x), ([2, 0, 3], rot_y)],
)
def test_opposite_directions_are_joined_by_a_half_turn_about_the_farthest_coordinate_axis(a, turn):
    assert worst(rotation_between(a, -5.0 * np.asarray(a)), turn(math.pi)) < 1e-15


def test_opposite_directions_take_the_axis_that_is_given():
    a, e = many_axes(500, seed=3), many_axes(500, seed=4)
    part = e - (e * a).sum(axis=-1, keepdims=True) * a
    lean = np.linalg.norm(part, axis=-1)
    a, e, part, lean = (x[lean >= 1e-6] for x in (a, e, part, lean))
    R = rotation_between(a, -a, axis=e)
    assert worst(times(R, a), -a) < 2e-15
    assert (np.abs(R - matrix_from_natural(part, math.pi)).max(axis=(-2, -1)) < 2e-15 / lean + 1e-15).all()
    assert worst(times(rotation_between(a, -a), a), -a) < 2e-15


def test_the_axis_of_a_half_turn_may_lean_and_not_lie_along():
    lean = [1.0, 0.0, 1e-10]
    assert worst(rotation_between(X, -X, axis=lean), rot_z(math.pi)) < 1e-15
    with pytest.raises(BadArgument, match=r"opposite directions at index \[1\] must not lie along them"):
        rotation_between([X, X], [Y, -X], axis=-3.0 * X)
    # Where it is not needed it may.
    assert worst(rotation_between(X, Y, axis=X), rot_z(math.pi / 2)) < 1e-15


def test_directions_broadcast_and_have_any_length():
    a, b = np.random.default_rng(0).normal(size=(2, 20, 3))
    R = rotation_between(a[:, None], b)
    assert R.shape == (20, 20, 3, 3)
    assert worst(R[3, 5], rotation_between(1e-6 * a[3], 1e6 * b[5])) < 1e-15
    assert rotation_between(X, -X, axis=[Y, Z]).shape == (2, 3, 3)
    with pytest.raises(WrongShape, match="a, b and axis"):
        rotation_between([X, Y], Z, axis=[X, Y, Z])
    for bad in ((0 * X, X, None), (X, 0 * X, None), (X, -X, 0 * X)):
        with pytest.raises(ZeroNorm):
            rotation_between(bad[0], bad[1], axis=bad[2])


def test_one_of_many_opposite_pairs_does_not_change_the_others():
    a, b = np.random.default_rng(1).normal(size=(2, 30, 3))
    alone = rotation_between(a, b)
    b[7] = -2.0 * a[7]
    together = rotation_between(a, b, axis=Z)
    rest = np.arange(30) != 7
    assert worst(together[rest], alone[rest]) == 0.0
    assert worst(together[7] @ a[7], -a[7]) < 1e-14


def noisy(n, sigma, seed):
    rng = np.random.default_rng(seed)
    R = random_rotations(1, seed=seed)[0]
    before = rng.normal(size=(n, 3))
    after = np.einsum("nij,nj->ni", exp(sigma * rng.normal(size=(n, 3))), before @ R.T)
    return R, before, after


@PROPERTY
@given(R=matrices, seed=st.integers(0, 10**6), n=st.integers(2, 9))
def test_directions_of_a_turned_body_give_its_rotation(R, seed, n):
    before = np.random.default_rng(seed).normal(size=(n, 3))
    if np.linalg.svd(before, compute_uv=False)[1] < 0.05:
        return
    fit = rotation_from_directions(before, before @ R.T)
    assert worst(fit.rotation, R) < 2e-12
    assert fit.residual < 1e-14
    assert fit.angles.max() < 1e-14


@pytest.mark.parametrize("sigma", [1e-6, 1e-2, 0.5])
@pytest.mark.parametrize("n", [2, 3, 10])
def test_the_fit_is_scipys(n, sigma):
    for seed in range(10):
        _, before, after = noisy(n, sigma, seed)
        weights = np.random.default_rng(seed).uniform(0.1, 5.0, n)
        a, b = (v / np.linalg.norm(v, axis=-1, keepdims=True) for v in (before, after))
        expected, rssd = Rotation.align_vectors(b, a, weights)
        fit = rotation_from_directions(3.0 * before, after, weights)
        assert worst(fit.rotation, expected.as_matrix()) < 1e-12
        assert fit.residual == pytest.approx(rssd / math.sqrt(weights.sum()), abs=1e-7)


def test_the_residual_and_the_angles_are_what_is_left():
    _, before, after = noisy(6, 0.2, 3)
    weights = np.array([1, 2, 3, 4, 5, 0.0])
    fit = rotation_from_directions(before, after, weights)
    a, b = (v / np.linalg.norm(v, axis=-1, keepdims=True) for v in (before, after))
    turned = a @ fit.rotation.T
    assert fit.angles == pytest.approx(
        [math.atan2(np.linalg.norm(np.cross(u, v)), u @ v) for u, v in zip(turned, b, strict=True)]
    )
    chords = np.square(turned - b).sum(axis=-1)
    assert fit.residual == pytest.approx(math.sqrt(weights @ chords / weights.sum()), rel=1e-14)
    for change in exp(np.concatenate([1e-3 * np.eye(3), -1e-3 * np.eye(3)])):
        assert weights @ np.square(a @ (change @ fit.rotation).T - b).sum(axis=-1) > weights @ chords


def test_a_heavy_weight_pulls_the_fit_to_its_direction():
    before, after = [Z, X], [Z, [math.cos(0.1), 0.0, math.sin(0.1)]]
    heavy = rotation_from_directions(before, after, [1e6, 1.0])
    assert heavy.angles[0] < 1e-6
    assert heavy.angles[1] == pytest.approx(0.1, abs=1e-6)
    even = rotation_from_directions(before, after)
    assert even.angles == pytest.approx([0.05, 0.05])
    assert worst(even.rotation, rot_y(-0.05)) < 1e-15
    # Without weight a direction does not count, wherever it points.
    assert worst(rotation_from_directions([X, Y, Z], [Y, -X, X], [1, 1, 0]).rotation, rot_z(math.pi / 2)) < 1e-15


def test_directions_to_points_about_their_middle_are_fitted_as_the_points():
    rng = np.random.default_rng(8)
    points = rng.normal(size=(4, 3))
    points = np.concatenate([points, -points])
    points /= np.linalg.norm(points, axis=-1, keepdims=True)
    after = points @ random_rotations(1)[0].T + 0.05 * np.concatenate([np.eye(3), np.eye(3), np.ones((2, 3))])
    after = np.concatenate([after[:4], -after[:4]])
    after /= np.linalg.norm(after, axis=-1, keepdims=True)
    assert worst(rotation_from_directions(points, after).rotation, rotation_from_points(points, after)) < 1e-14


def test_fits_in_batches():
    _, before, after = noisy(5, 0.1, 4)
    fit = rotation_from_directions(before, np.stack([after, before]), np.ones((3, 1, 5)))
    assert (fit.rotation.shape, fit.residual.shape, fit.angles.shape) == ((3, 2, 3, 3), (3, 2), (3, 2, 5))
    assert worst(fit.rotation[2, 0], rotation_from_directions(before, after).rotation) < 1e-15
    assert worst(fit.rotation[:, 1], np.eye(3)) < 1e-15
    assert rotation_from_directions(np.ones((0, 2, 3)), [X, Y]).residual.shape == (0,)


def test_directions_that_do_not_tell_a_rotation_are_refused():
    for before, after in (([X, -X], [X, -X]), ([X, Y], [X, X]), ([X, [1, 1e-7, 0]], [X, Y])):
        with pytest.raises(DegeneratePoints, match="directions (before|after) lie on one line"):
            rotation_from_directions(before, after)
    with pytest.raises(DegeneratePoints, match="directions before lie on one line"):
        rotation_from_directions([X, Y], [X, Y], [1.0, 0.0])
    with pytest.raises(DegeneratePoints, match="no single rotation fits the directions best"):
        rotation_from_directions([X, Y, Z], -np.eye(3))
    with pytest.raises(DegeneratePoints, match="at least two"):
        rotation_from_directions([X], [X])
    with pytest.raises(WrongShape, match="as many as before"):
        rotation_from_directions([X, Y], [X, Y, Z])
    with pytest.raises(WrongShape, match="directions before"):
        rotation_from_directions(X, [X, Y])
    with pytest.raises(WrongShape, match="weights"):
        rotation_from_directions([X, Y], [X, Y], [1, 2, 3])
    with pytest.raises(BadArgument, match="weights must not be negative"):
        rotation_from_directions([X, Y], [X, Y], [1, -2])
    with pytest.raises(ZeroNorm, match=r"directions after must not be zero at index \[1\]"):
        rotation_from_directions([X, Y], [X, 0 * Y])
    with pytest.raises(NotFinite):
        rotation_from_directions([X, Y], [X, math.nan * Y])
