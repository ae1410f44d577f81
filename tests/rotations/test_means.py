from __future__ import annotations

import math

import numpy as np
import pytest
from rotation_samples import integer_rotations, many_angles, many_axes, many_rotations, random_rotations, worst
from scipy.spatial.transform import Rotation

from nao_kin.errors import BadArgument, NotARotation, NotFinite, UnknownName, WrongShape
from nao_kin.rotations import (
    angle_between,
    exp,
    log,
    matrix_from_natural,
    mean_rotation,
    natural_invariants,
    power,
    random_rotation,
    random_rotation_near,
    rot_x,
    rot_y,
    rot_z,
)

METHODS = ["geodesic", "chordal"]
each_method = pytest.mark.parametrize("method", METHODS)


def scattered(sigma, shape, seed=0):
    rng = np.random.default_rng(seed)
    return random_rotation_near(random_rotation(rng), sigma, rng, shape)


def _error_of_svd(M):
    """Return ‖U Σ Vᵀ − M‖ of NumPy's singular values, which differs with LAPACK's version and the processor."""
    U, sigma, Vt = np.linalg.svd(M)
    return np.linalg.norm(U * sigma[:, None] @ Vt - M, axis=(-2, -1))


@each_method
def test_the_mean_of_two_rotations_lies_half_way(method):
    angle = np.minimum(np.abs(many_angles((600,), seed=3)), math.pi - 1e-3)
    A, e = many_rotations(600), many_axes(600, seed=4)
    B = A @ matrix_from_natural(e, angle)
    mean = mean_rotation(np.stack([A, B], axis=1), method=method)
    off = np.abs(mean.rotation - A @ matrix_from_natural(e, angle / 2)).max(axis=(-2, -1))
    # An error E of the sum M turns its nearest rotation by at most √2 ‖E‖ / (σ₂ + σ₃), with σ₂ = σ₃ = cos(angle / 2).
    # E are a few roundings, and for the chordal mean the error of the SVD, which differs between versions of LAPACK.
    M = 0.5 * (A + B)
    largest = np.abs(M).max(axis=(-2, -1))
    of_svd = largest * _error_of_svd(M / largest[:, None, None]) if method == "chordal" else 0.0
    few = 8.0 * np.finfo(float).eps
    assert (off <= (math.sqrt(2.0) * of_svd + few) / (2.0 * np.cos(angle / 2)) + few).all()
    room = 1e-15 / (math.pi - angle)
    assert (np.abs(mean.spread - angle / 2) < room + 3e-15).all()
    expected = (angle**2 / 4)[:, None, None] * e[:, :, None] * e[:, None, :]
    assert (np.abs(mean.covariance - expected).max(axis=(-2, -1)) < 10.0 * room).all()


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9, 1.0])
def test_a_weight_moves_the_geodesic_mean_that_part_of_the_way(share):
    A, B = random_rotations(2, seed=4)
    mean = mean_rotation([A, B], weights=[7.0 * (1 - share), 7.0 * share])
    assert worst(mean.rotation, A @ power(A.T @ B, share)) < 5e-15
    angle = float(angle_between(A, B))
    assert mean.spread == pytest.approx(angle * math.sqrt(share * (1 - share)), abs=1e-14)


@each_method
def test_whole_weights_count_as_so_many_rotations(method):
    R = scattered(0.5, 4)
    several = np.concatenate([R[[0]], R[[1]], R[[1]], R[[2]], R[[2]], R[[2]]])
    weighted = mean_rotation(R, [1, 2, 3, 0], method=method)
    plain = mean_rotation(several, method=method)
    assert worst(weighted.rotation, plain.rotation) < 3e-15
    assert worst(weighted.spread, plain.spread) < 3e-15
    assert worst(weighted.covariance, plain.covariance) < 3e-15


@pytest.mark.parametrize("sigma", [1e-9, 1e-3, 0.3, 1.0])
def test_the_chordal_mean_is_scipys(sigma):
    R = scattered(sigma, 50, seed=1)
    weights = np.random.default_rng(2).uniform(0.0, 1.0, 50)
    for given_ in (None, weights):
        expected = Rotation.from_matrix(R).mean(given_).as_matrix()
        assert worst(mean_rotation(R, given_, method="chordal").rotation, expected) < 1e-14


@pytest.mark.parametrize("sigma", [1e-9, 1e-3, 0.3, 0.7, 1.5])
def test_at_the_geodesic_mean_the_rotation_vectors_add_up_to_nothing(sigma):
    R = scattered(sigma, (20, 30), seed=3)
    weights = np.random.default_rng(4).uniform(0.0, 1.0, (20, 30))
    mean = mean_rotation(R, weights)
    arms = log(np.swapaxes(mean.rotation, -1, -2)[:, None] @ R)
    shares = weights / weights.sum(axis=-1, keepdims=True)
    assert np.abs(np.einsum("bn,bni->bi", shares, arms)).max() < 3e-15
    assert worst(mean.covariance, np.einsum("bn,bni,bnj->bij", shares, arms, arms)) < 1e-15
    assert worst(np.square(mean.spread), np.trace(mean.covariance, axis1=-2, axis2=-1)) < 5e-15


def test_the_geodesic_mean_of_rotations_within_a_right_angle_has_least_squares():
    rng = np.random.default_rng(5)
    for _ in range(20):
        vectors = rng.normal(size=(5, 3))
        vectors *= rng.uniform(0.0, 1.5, (5, 1)) / np.linalg.norm(vectors, axis=-1, keepdims=True)
        R = exp(vectors)
        mean = mean_rotation(R)
        others = random_rotation_near(mean.rotation, 1.0, rng, 300)
        assert np.square(angle_between(others[:, None], R)).mean(axis=-1).min() >= mean.spread**2


@each_method
def test_the_mean_turns_with_the_rotations(method):
    R, A, B = scattered(0.6, 9, seed=6), *random_rotations(2, seed=7)
    mean, turned = mean_rotation(R, method=method), mean_rotation(A @ R @ B, method=method)
    assert worst(turned.rotation, A @ mean.rotation @ B) < 5e-15
    assert worst(turned.covariance, B.T @ mean.covariance @ B) < 5e-15
    assert worst(mean_rotation(R[::-1], method=method).rotation, mean.rotation) < 5e-15


@each_method
def test_one_rotation_is_its_own_mean_and_about_one_axis_the_angles_have_theirs(method):
    R = random_rotations(5)
    alone = mean_rotation(R[:, None], method=method)
    assert worst(alone.rotation, R) < 2e-15
    assert alone.spread.max() < 2e-15
    if method == "geodesic":
        angles = np.array([0.1, -0.4, 1.3, 0.2])
        mean = mean_rotation(rot_x(angles))
        assert worst(mean.rotation, rot_x(angles.mean())) < 2e-15
        assert mean.spread == pytest.approx(angles.std(), abs=1e-15)
        assert worst(mean.covariance, np.diag([angles.var(), 0, 0])) < 1e-15


@each_method
def test_rotations_without_a_single_mean_are_refused_with_their_index(method):
    thirds = rot_z(np.arange(3) * 2 * math.pi / 3)
    for R in ([np.eye(3), rot_x(math.pi)], integer_rotations(), thirds):
        with pytest.raises(BadArgument, match="no single mean"):
            mean_rotation(R, method=method)
    with pytest.raises(BadArgument, match=r"at index \[1\]"):
        mean_rotation([[np.eye(3), rot_x(1.0)], [np.eye(3), rot_y(math.pi)]], method=method)


@each_method
def test_batches_of_means_and_of_weights(method):
    R = scattered(0.3, (2, 3, 7))
    mean = mean_rotation(R, method=method)
    assert (mean.rotation.shape, mean.spread.shape, mean.covariance.shape) == ((2, 3, 3, 3), (2, 3), (2, 3, 3, 3))
    assert worst(mean.rotation[1, 2], mean_rotation(R[1, 2], method=method).rotation) < 2e-15
    assert mean_rotation(R[0, 0], np.ones((5, 7)), method=method).rotation.shape == (5, 3, 3)
    assert mean_rotation(R[:0], method=method).spread.shape == (0, 3)
    assert isinstance(mean_rotation(R[0, 0], method=method).spread, np.ndarray)


def test_what_has_no_mean_is_refused():
    R = random_rotations(3)
    for weights, message in (([1, -1, 1], "must not be negative, got -1 at index"), ([0, 0, 0], "at least one weight")):
        with pytest.raises(BadArgument, match=message):
            mean_rotation(R, weights)
    with pytest.raises(BadArgument, match="at least one rotation"):
        mean_rotation(R[:0])
    for weights in ([1.0, 2.0], 1.0, np.ones((3, 1))):
        with pytest.raises(WrongShape, match="weights"):
            mean_rotation(R, weights)
    with pytest.raises(WrongShape, match=r"rotations must have shape \(..., n, 3, 3\)"):
        mean_rotation(np.eye(3))
    with pytest.raises(WrongShape, match="rotations and weights"):
        mean_rotation([R, R], np.ones((3, 3)))
    with pytest.raises(NotARotation):
        mean_rotation(2.0 * R)
    with pytest.raises(NotFinite):
        mean_rotation(R, [1, math.nan, 1])
    with pytest.raises(UnknownName, match="unknown method"):
        mean_rotation(R, method="median")


def test_random_rotations_are_uniform():
    from scipy import stats  # takes a second, in each process

    R = random_rotation(0, 20000)
    _, angle = natural_invariants(R)
    assert stats.kstest(angle, lambda a: (a - np.sin(a)) / math.pi).pvalue > 0.01
    for row in (R[:, 0, 0], R[:, 1, 2], (R @ [0.6, 0.0, 0.8])[:, 1]):
        assert stats.kstest(row, stats.uniform(-1, 2).cdf).pvalue > 0.01
    # A fixed rotation before or after changes nothing.
    _, turned = natural_invariants(rot_x(2.0) @ R @ rot_z(1.0))
    assert stats.kstest(turned, lambda a: (a - np.sin(a)) / math.pi).pvalue > 0.01


def test_rotations_near_one_scatter_normally_in_its_own_axes():
    from scipy import stats  # takes a second, in each process

    R, sigma = rot_y(1.0), np.array([0.1, 0.02, 0.3])
    vectors = log(R.T @ random_rotation_near(R, sigma, 1, 5000)) / sigma
    for i in range(3):
        assert stats.kstest(vectors[:, i], "norm").pvalue > 0.01
    assert np.abs(np.corrcoef(vectors.T) - np.eye(3)).max() < 0.05
    mean = mean_rotation(random_rotation_near(R, 0.01, 2, 5000))
    assert float(angle_between(mean.rotation, R)) < 1e-3
    assert mean.spread == pytest.approx(math.sqrt(3) * 0.01, rel=0.03)


def test_a_seed_and_a_generator_make_the_same_rotations_and_shapes_are_kept():
    R = random_rotations(2)
    for shape, expected in (((), ()), (5, (5,)), ((2, 3), (2, 3)), ([0], (0,)), (np.int64(2), (2,))):
        assert random_rotation(1, shape).shape == (*expected, 3, 3)
        assert random_rotation_near(R, 0.1, 1, shape).shape == (2, *expected, 3, 3)
    assert (random_rotation(7, 3) == random_rotation(np.random.default_rng(7), 3)).all()
    assert (random_rotation(7, 3) != random_rotation(8, 3)).any()
    assert (random_rotation() != random_rotation()).any()
    near = random_rotation_near(R, 1e-6, 1, 50)
    assert angle_between(R[:, None], near).max() < 1e-5


@pytest.mark.parametrize("sigma", [-0.1, [0.1, -0.1, 0.1]])
def test_a_scatter_that_is_none_is_refused(sigma):
    with pytest.raises(BadArgument, match="sigma must not be negative"):
        random_rotation_near(np.eye(3), sigma)
    with pytest.raises(WrongShape, match="sigma"):
        random_rotation_near(np.eye(3), [0.1, 0.2])


def test_rotations_near_any_rotation_are_rotations():
    R = many_rotations(300)
    assert worst(mean_rotation(random_rotation_near(R, 1e-12, 0, 5)).rotation, R) < 5e-12


def test_each_rotation_has_a_scatter_of_its_own():
    R = many_rotations(4)
    steps = log(np.swapaxes(R, -1, -2)[:, None] @ random_rotation_near(R, 0.1, 0, 3)).reshape(12, 3)
    assert np.linalg.norm(steps[:, None] - steps, axis=-1)[~np.eye(12, dtype=bool)].min() > 1e-3
