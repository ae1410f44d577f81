from __future__ import annotations

import math

import numpy as np
import pytest
from loops import for_all
from rotation_samples import integer_rotations, many_angles, many_rotations, random_rotations, worst
from scipy.linalg import polar
from scipy.spatial.transform import Rotation

from nao_kin.errors import BadArgument, NotARotation, NotFinite
from nao_kin.rotations import (
    SEQUENCES,
    check_rotation,
    davenport_angles,
    euler_from_matrix,
    exp,
    is_rotation,
    log,
    matrix_from_davenport,
    matrix_from_euler,
    matrix_from_natural,
    matrix_from_quat,
    natural_invariants,
    nearest_rotation,
    quat_from_matrix,
    rot_x,
    rot_y,
    rot_z,
)

X = np.eye(3)
NO_ROTATIONS = {
    "zero": np.zeros((3, 3)),
    "scaled": 1.001 * np.eye(3),
    "stretched and squeezed, determinant 1": np.diag([2.0, 0.5, 1.0]),
    "sheared, determinant 1": np.array([[1.0, 0.01, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
    **{f"column {i} sheared along {j}": np.eye(3) + 1e-5 * np.outer(X[i], X[j]) for i in range(3) for j in range(3)},
    "reflection": np.diag([1.0, 1.0, -1.0]),
    "inversion": -np.eye(3),
    "two columns swapped": np.eye(3)[:, [1, 0, 2]],
}


@for_all(("turn", "axis"), [(rot_x, "x"), (rot_y, "y"), (rot_z, "z")])
def test_elementary_turns_agree_with_scipy(turn, axis):
    angle = many_angles((1000,))
    assert worst(turn(angle), Rotation.from_euler(axis, angle[:, np.newaxis]).as_matrix()) < 5e-16


def test_a_turn_by_zero_has_no_minus_signs_on_its_zeros():
    for turn in (rot_x, rot_y, rot_z):
        assert not np.signbit(turn(0.0)).any()
        assert not np.signbit(turn([0.0, 0.0])).any()


def test_rotations_pass_and_their_defects_are_reported():
    R = many_rotations(600)
    assert is_rotation(R).all()
    defects = check_rotation(R)
    assert worst(defects.determinant, np.linalg.det(R) - 1.0) < 2e-15
    assert worst(defects.orthogonality, np.abs(np.swapaxes(R, -1, -2) @ R - np.eye(3)).max(axis=(-2, -1))) < 1e-15


@for_all("name", NO_ROTATIONS)
def test_what_is_no_rotation_is_refused_with_its_defects(name):
    M = NO_ROTATIONS[name]
    assert not is_rotation(M)
    with pytest.raises(NotARotation) as caught:
        check_rotation(M)
    assert caught.value.index == ()
    assert caught.value.determinant_defect == pytest.approx(np.linalg.det(M) - 1.0, abs=1e-12)
    assert caught.value.orthogonality_defect == pytest.approx(np.abs(M.T @ M - np.eye(3)).max(), abs=1e-12)


@for_all("name", NO_ROTATIONS)
def test_one_bad_matrix_of_many_is_found_at_its_index(name):
    R = random_rotations(20000).reshape(4, 5000, 3, 3)
    R[2, 4321] = NO_ROTATIONS[name]
    R[3, 0] = NO_ROTATIONS[name]
    expected = np.ones((4, 5000), dtype=bool)
    expected[2, 4321] = expected[3, 0] = False
    assert (is_rotation(R) == expected).all()
    for call in (check_rotation, log):
        with pytest.raises(NotARotation, match=r"at index \[2, 4321\]"):
            call(R)


def test_rotations_rounded_to_single_precision_pass_and_to_five_digits_do_not():
    R = random_rotations(2000)
    assert is_rotation(R.astype(np.float32)).all()
    assert worst(log(R.astype(np.float32)), log(R)) < 1e-3
    assert not is_rotation(np.round(R, 5)).all()


def test_the_tolerance_decides():
    R = np.eye(3) + 1e-4 * np.array([[0, 1, 0], [0, 0, 0], [0, 0, 0]])
    assert not is_rotation(R)
    assert is_rotation(R, tolerance=1.1e-4)
    assert not is_rotation(R, tolerance=0.9e-4)
    assert is_rotation(R, tolerance=np.float32(1.1e-4))
    check_rotation(R, tolerance=1.1e-4)
    with pytest.raises(NotARotation):
        check_rotation(R, tolerance=0.9e-4)


@for_all("tolerance", [-1.0, math.nan, "tight", None])
def test_a_tolerance_that_is_no_number_from_zero_on_is_refused(tolerance):
    for call in (is_rotation, check_rotation):
        with pytest.raises(BadArgument, match="tolerance"):
            call(np.eye(3), tolerance)


def test_a_matrix_with_nan_is_no_rotation():
    M = np.stack([np.eye(3), np.eye(3), np.eye(3)])
    M[1, 0, 2] = math.nan
    M[2, 0, 2] = math.inf
    assert is_rotation(M).tolist() == [True, False, False]
    with pytest.raises(NotFinite, match=r"at index \[1, 0, 2\]"):
        check_rotation(M)


def test_a_rotation_is_its_own_nearest():
    R = np.concatenate([random_rotations(200), integer_rotations()])
    assert worst(nearest_rotation(R), R) < 3e-15


def test_nearest_rotation_is_the_orthogonal_polar_factor():
    M = random_rotations(100) + 0.1 * np.random.default_rng(7).normal(size=(100, 3, 3))
    for m, R in zip(M, nearest_rotation(M), strict=True):
        assert worst(R, polar(m)[0]) < 5e-15


def test_no_rotation_is_nearer_than_the_nearest_one():
    rng = np.random.default_rng(8)
    candidates = random_rotations(5000, seed=9)
    for M in rng.normal(size=(50, 3, 3)):
        R = nearest_rotation(M)
        assert check_rotation(R).orthogonality < 2e-15
        distance = np.linalg.norm(M - R)
        assert distance <= np.linalg.norm(M - candidates, axis=(1, 2)).min()
        nearby = R @ np.array([rot_x(1e-4), rot_y(-1e-4), rot_z(1e-4), rot_x(-1e-4)])
        assert distance < np.linalg.norm(M - nearby, axis=(1, 2)).min()


@for_all("M", [np.zeros((3, 3)), np.diag([1.0, 0.0, 0.0]), -np.eye(3), np.diag([3.0, 1.0, -1.0]), np.ones((3, 3))])
def test_a_matrix_without_a_single_nearest_rotation_is_refused(M):
    with pytest.raises(BadArgument, match="no single nearest rotation: singular values"):
        nearest_rotation(M)
    with pytest.raises(BadArgument, match=r"at index \[1\]"):
        nearest_rotation([np.eye(3), M])


def test_a_matrix_of_rank_two_still_has_one():
    assert worst(nearest_rotation(np.diag([2.0, 1.0, 0.0])), np.eye(3)) < 1e-15


def off(size, seed=0):
    """Rotations, at lock and everywhere else, with errors of that size in every entry."""
    rng = np.random.default_rng(seed)
    triples = rng.uniform(-3.0, 3.0, (300, 3))
    triples[:150, 1] = math.pi / 2 + np.repeat([0.0, 1e-9, size], 50)
    R = matrix_from_euler(triples, "zyx", axes="moving")
    return R + rng.uniform(-size, size, R.shape)


@for_all("size", [1e-13, 1e-10, 1e-8, 1e-7, 2e-7])
def test_what_is_a_rotation_only_nearly_is_answered_for_the_nearest_one(size):
    R = off(size)
    nearest = nearest_rotation(R)
    for sequence in SEQUENCES:
        found = euler_from_matrix(R, sequence, axes="moving")
        assert worst(matrix_from_euler(found.angles, sequence, axes="moving"), nearest) < 8e-15
        assert worst(matrix_from_euler(found.other, sequence, axes="moving"), nearest) < 8e-15
    assert worst(matrix_from_quat(quat_from_matrix(R)), nearest) < 8e-15
    assert worst(exp(log(R)), nearest) < 8e-15
    assert worst(matrix_from_natural(*natural_invariants(R)), nearest) < 8e-15
    hip = ([0, 1, -1], [1, 0, 0], [0, 1, 0])
    assert worst(matrix_from_davenport(davenport_angles(R, *hip).angles, *hip), nearest) < 8e-15


def test_a_single_matrix_in_single_precision_is_answered_as_one_of_many():
    R = random_rotations(20).astype(np.float32)
    together = log(R)
    for matrix, v in zip(R, together, strict=True):
        assert worst(log(matrix), v) < 1e-15
        assert worst(exp(v), nearest_rotation(matrix)) < 5e-15


def test_exact_rotations_beside_inexact_ones_keep_their_last_digit():
    axes = np.random.default_rng(1).normal(size=(50, 3))
    half_turns = np.array([matrix_from_natural(e, math.pi) for e in axes])
    half_turns = 0.5 * (half_turns + np.swapaxes(half_turns, -1, -2))
    mixed = np.concatenate([half_turns, off(1e-7)])
    assert (log(mixed)[:50] == log(half_turns)).all()
    assert (quat_from_matrix(mixed)[:50] == quat_from_matrix(half_turns)).all()


def test_the_error_names_the_argument():
    with pytest.raises(NotARotation, match=r"^T_hand: not a rotation"):
        check_rotation(np.diag([1.0, 1.0, -1.0]), name="T_hand")
