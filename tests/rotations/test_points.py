from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st
from rotation_samples import PROPERTY, matrices, random_rotations, worst
from scipy.spatial.transform import Rotation

from nao_kin.errors import DegeneratePoints, NotFinite, UnknownName, WrongShape
from nao_kin.rotations import check_rotation, euler_from_matrix, rotation_from_points

S = math.sqrt(3.0)
BEFORE = np.array([[0.0, 10.0, 0.0], [7.0, 0.0, 0.0], [-7.0, 0.0, 0.0]])
AFTER = np.array(
    [
        [390 / 4, (4030 - 5 * S) / 4, (1615 + 10 * S) / 4],
        [(800 + 14 * S) / 8, (8021 + 14 * S) / 8, (3214 - 21 * S) / 8],
        [(800 - 14 * S) / 8, (7979 - 14 * S) / 8, (3186 + 21 * S) / 8],
    ]
)
METHODS = ["least_squares", "triads"]


@pytest.mark.parametrize("method", METHODS)
def test_the_aircraft_of_the_paper_is_turned_as_printed(method):
    Q = rotation_from_points(BEFORE, AFTER, method=method)
    printed = [
        [0.433012701892, -0.25, 0.866025403784],
        [0.808012701892, 0.533493649054, -0.25],
        [-0.399519052838, 0.808012701892, 0.433012701892],
    ]
    assert worst(Q, printed) < 1e-12
    assert worst(Q @ (BEFORE[1] - BEFORE[2]), AFTER[1] - AFTER[2]) < 1e-12
    found = euler_from_matrix(Q, "xyz", axes="moving")
    assert np.degrees(found.angles) == pytest.approx([30, 60, 30], abs=1e-11)
    assert np.degrees(found.other) == pytest.approx([-150, 120, -150], abs=1e-11)
    middle, middle_after = BEFORE[1:].mean(axis=0), AFTER[1:].mean(axis=0)
    tail = middle_after + Q @ (np.array([0.0, 8.0, 2.0]) - middle)
    assert tail == pytest.approx([99.732050807569, 1003.767949192431, 407.330127018922], abs=1e-11)


def clouds(least, most):
    count = st.integers(least, most)
    return st.builds(lambda n, seed: np.random.default_rng(seed).uniform(-1, 1, (n, 3)), count, st.integers(0, 10**6))


@pytest.mark.parametrize("method", METHODS)
@PROPERTY
@given(R=matrices, points=clouds(3, 3), shift=st.floats(-5, 5))
def test_three_points_of_a_rigid_body_give_its_rotation(method, R, points, shift):
    area = np.linalg.norm(np.cross(points[1] - points[0], points[2] - points[0]))
    if area > 0.05:
        after = points @ R.T + [shift, 1.0, -shift]
        assert worst(rotation_from_points(points, after, method=method), R) < 2e-13


@PROPERTY
@given(R=matrices, points=clouds(5, 40))
def test_many_points_of_a_rigid_body_give_its_rotation(R, points):
    assert worst(rotation_from_points(points, points @ R.T + 3.0), R) < 1e-13


def test_least_squares_agrees_with_scipy_on_noisy_points():
    rng = np.random.default_rng(0)
    for R in random_rotations(30):
        before = rng.normal(size=(12, 3))
        after = before @ R.T + 0.1 * rng.normal(size=(12, 3))
        expected, _ = Rotation.align_vectors(after - after.mean(axis=0), before - before.mean(axis=0))
        assert worst(rotation_from_points(before, after), expected.as_matrix()) < 1e-12


def test_least_squares_answers_a_mirrored_body_with_a_rotation():
    before = np.random.default_rng(1).normal(size=(8, 3)) * [3.0, 2.0, 1.0]
    R = rotation_from_points(before, before * [1, 1, -1])
    assert check_rotation(R).orthogonality < 1e-14
    centred = before - before.mean(axis=0)
    expected, _ = Rotation.align_vectors(centred * [1, 1, -1], centred)
    assert worst(R, expected.as_matrix()) < 1e-13


def test_triads_map_the_line_of_the_last_two_points_exactly_even_for_a_bent_body():
    after = BEFORE + np.array([[0.0, 1.0, 0.5], [0.0, 0.0, 0.0], [0.0, 0.0, 0.3]])
    R = rotation_from_points(BEFORE, after, method="triads")
    along = after[1] - after[2]
    assert worst(R @ [1.0, 0.0, 0.0], along / np.linalg.norm(along)) < 1e-15


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_the_size_of_the_body_does_not_matter(method, scale):
    R = random_rotations(1)[0]
    assert worst(rotation_from_points(scale * BEFORE, scale * BEFORE @ R.T, method=method), R) < 1e-14


def test_batches_broadcast():
    R = random_rotations(6).reshape(2, 3, 3, 3)
    after = np.einsum("...ij,nj->...ni", R, BEFORE)
    for method in METHODS:
        assert worst(rotation_from_points(BEFORE, after, method=method), R) < 1e-14
    assert rotation_from_points(np.zeros((0, 3, 3)), np.zeros((0, 3, 3))).shape == (0, 3, 3)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    "line",
    [
        np.zeros((3, 3)),
        np.full((3, 3), 0.1),
        np.array([[0, 0, 0], [1, 1, 1], [2, 2, 2]]),
        np.array([[0.1, 0.2, 0.3], [0.1, 0.2, 0.3], [2, 5, 1]]),
        np.array([[0, 0, 0], [1, 1e-10, 0], [2, 0, 0]]),
        1e6 + np.array([[0, 0, 0], [1.2e-10, 0, 0], [0, 1.2e-10, 0]]),
        1e3 + np.array([[0.1, 0.1, 0.1], [0.2, 0.2, 0.2], [0.7, 0.7, 0.7]]),
    ],
)
def test_points_on_one_line_are_refused(method, line):
    for before, after, which in ((line, BEFORE, "before"), (BEFORE, line, "after")):
        with pytest.raises(DegeneratePoints, match=f"points {which} lie on one line"):
            rotation_from_points(before, after, method=method)
    with pytest.raises(DegeneratePoints, match=r"points before at index \[1\]"):
        rotation_from_points([BEFORE, line], BEFORE, method=method)


def thin_cloud(thinness, seed):
    """Three points in the plane, or six in space, of that ratio of width to length."""
    rng = np.random.default_rng(seed)
    count, depth = (3, 0.0) if seed % 2 else (6, 0.5)
    points = rng.normal(size=(count, 3))
    U, _, Vt = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    return U @ np.diag([1.0, thinness, depth * thinness]) @ Vt


@pytest.mark.parametrize(
    ("method", "thinness"),
    [("least_squares", 10.0**-k) for k in range(1, 6)]
    + [("least_squares", 1.01e-6)]
    + [("triads", 10.0**-k) for k in range(1, 8)]
    + [("triads", 1.1e-8)],
)
def test_points_near_one_line_give_the_turn_about_it_to_the_digits_they_have(method, thinness):
    power = 2 if method == "least_squares" else 1
    for seed, R in enumerate(random_rotations(40)):
        points = thin_cloud(thinness, seed)
        if method == "least_squares" or len(points) == 3:
            assert worst(rotation_from_points(points, points @ R.T, method=method), R) < 1e-15 / thinness**power


@pytest.mark.parametrize("thinness", [*(10.0**-k for k in range(8)), 1.1e-8])
def test_triads_give_a_rotation_to_the_last_digits_however_thin_the_points(thinness):
    for seed, R in enumerate(random_rotations(100, seed=5)):
        points = thin_cloud(thinness, 2 * seed + 1)
        defects = check_rotation(rotation_from_points(points, points @ R.T, method="triads"))
        assert defects.orthogonality < 2e-15
        assert abs(defects.determinant) < 2e-15


@pytest.mark.parametrize(
    ("method", "thinness"),
    [("least_squares", 0.99e-6), ("least_squares", 1e-7), ("least_squares", 1e-12), ("triads", 0.9e-8)],
)
def test_points_too_near_one_line_are_refused_as_on_it(method, thinness):
    for seed, R in enumerate(random_rotations(20)):
        points = thin_cloud(thinness, seed)
        if method == "least_squares" or len(points) == 3:
            with pytest.raises(DegeneratePoints, match="points before lie on one line"):
                rotation_from_points(points, points @ R.T, method=method)
    flat = np.array([[0, 0, 0], [1, 0, 0], [0.3, 1e-7, 0]])
    with pytest.raises(DegeneratePoints, match="points after lie on one line"):
        rotation_from_points(BEFORE, flat)
    with pytest.raises(DegeneratePoints, match="points before lie on one line"):
        rotation_from_points(flat, flat)


def test_points_that_no_single_rotation_fits_best_are_refused():
    corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=float)
    with pytest.raises(DegeneratePoints, match="no single rotation fits the points best"):
        rotation_from_points(corners, -corners)


def test_too_few_points_and_wrong_shapes_are_refused():
    with pytest.raises(DegeneratePoints, match="at least three, got 2"):
        rotation_from_points(BEFORE[:2], AFTER[:2])
    with pytest.raises(WrongShape, match="as many as before"):
        rotation_from_points(BEFORE, np.vstack([AFTER, AFTER]))
    with pytest.raises(WrongShape):
        rotation_from_points(np.ones((3, 2)), AFTER)
    with pytest.raises(WrongShape):
        rotation_from_points(np.ones(3), AFTER)
    with pytest.raises(WrongShape, match="two triads"):
        rotation_from_points(np.eye(4)[:, :3], np.eye(4)[:, :3], method="triads")
    with pytest.raises(WrongShape, match="batch axes"):
        rotation_from_points([BEFORE] * 2, [AFTER] * 3)
    with pytest.raises(UnknownName, match="unknown method"):
        rotation_from_points(BEFORE, AFTER, method="svd")
    with pytest.raises(NotFinite):
        rotation_from_points(BEFORE, AFTER * [1, math.nan, 1])
