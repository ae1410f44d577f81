from __future__ import annotations

import math

import numpy as np
import pytest
from rotation_samples import (
    DISTANCES,
    integer_rotations,
    many_angles,
    many_axes,
    many_quaternions,
    many_rotations,
    random_rotations,
    worst,
)
from scipy.spatial.transform import Rotation

from nao_kin.errors import WrongShape, ZeroNorm
from nao_kin.rotations import (
    angle_between,
    matrix_from_natural,
    matrix_from_quat,
    power,
    quat_conjugate,
    quat_multiply,
    quat_rotate,
    rot_x,
    rot_z,
)


def test_a_power_turns_by_that_many_times_the_angle():
    e, angle = many_axes(600), np.minimum(np.abs(many_angles((600,))), math.pi)
    exponents = np.random.default_rng(0).uniform(-3.0, 3.0, 600)
    exponents[::3] = np.resize([0.0, 1.0, -1.0, 2.0, 0.5], 200)
    found = power(matrix_from_natural(e, angle), exponents)
    one, other = (np.abs(found - matrix_from_natural(e, s * exponents * angle)).max(axis=(-2, -1)) for s in (1, -1))
    # At half a turn both ways round are the same rotation.
    assert np.where(math.pi - angle < 1e-14, np.minimum(one, other), one).max() < 4e-15


def test_powers_agree_with_scipy():
    R = random_rotations(200)
    for t in (-2.5, -1.0, 0.0, 0.3, 1.0, 2.0, 7.0):
        # Not `Rotation ** t`, which is off by 3e-8 in scipy 1.15.
        expected = Rotation.from_rotvec(t * Rotation.from_matrix(R).as_rotvec()).as_matrix()
        assert worst(power(R, t), expected) < 2e-14


def test_whole_powers_are_products_and_the_inverse_is_the_transpose():
    R = np.concatenate([random_rotations(50), integer_rotations()])
    assert worst(power(R, 3), R @ R @ R) < 5e-15
    assert worst(power(R, -1), np.swapaxes(R, -1, -2)) < 3e-15
    assert worst(power(R, 0), np.eye(3)) == 0.0
    assert worst(power(R, 0.5) @ power(R, 0.5), R) < 5e-15


def test_powers_of_small_turns_keep_their_relative_accuracy():
    for angle in (1e-12, 1e-8):
        assert power(rot_x(angle), 0.25)[2, 1] == pytest.approx(0.25 * angle, rel=1e-15, abs=0.0)


def test_exponents_broadcast_with_rotations():
    assert power(random_rotations(3)[:, None], np.zeros(4)).shape == (3, 4, 3, 3)
    with pytest.raises(WrongShape, match="R and t"):
        power(random_rotations(3), np.zeros(4))


def test_the_angle_between_two_rotations_is_the_one_put_between_them():
    angle = np.minimum(np.abs(many_angles((600,), seed=3)), math.pi)
    A = many_rotations(600)
    B = A @ matrix_from_natural(many_axes(600, seed=2), angle)
    assert worst(angle_between(A, B), angle) < 2e-15
    assert worst(angle_between(B, A), angle) < 2e-15


def test_the_angle_between_rotations_agrees_with_scipy_and_broadcasts():
    A, B = random_rotations(60, seed=1), random_rotations(60, seed=2)
    expected = (Rotation.from_matrix(A).inv() * Rotation.from_matrix(B)).magnitude()
    assert worst(angle_between(A, B), expected) < 5e-15
    assert angle_between(A[:, None], B[:7]).shape == (60, 7)
    assert angle_between(A, A).max() < 1e-15
    with pytest.raises(WrongShape, match="rotations A and B"):
        angle_between(A, B[:7])


def test_a_quaternion_turns_a_vector_as_its_matrix_does():
    q, v = many_quaternions(600), np.random.default_rng(0).uniform(-9.0, 9.0, (600, 3))
    expected = np.einsum("nij,nj->ni", matrix_from_quat(q), v)
    for scale in (1.0, -3.0):
        assert worst(quat_rotate(scale * q, v), expected) < 1.5e-14
    pure = quat_multiply(quat_multiply(q, np.concatenate([np.zeros((600, 1)), v], axis=-1)), quat_conjugate(q))
    assert worst(quat_rotate(q, v), pure[:, 1:]) < 1.5e-14


def test_turned_vectors_agree_with_scipy_in_batches():
    turns_ = Rotation.random(30, random_state=np.random.default_rng(3))
    v = np.random.default_rng(4).normal(size=(30, 3))
    q = turns_.as_quat(scalar_first=True)
    assert worst(quat_rotate(q, v), turns_.apply(v)) < 3e-15
    assert quat_rotate(q[:, None], v[:5]).shape == (30, 5, 3)
    with pytest.raises(ZeroNorm):
        quat_rotate([0, 0, 0, 0], [1, 0, 0])
    with pytest.raises(WrongShape, match="quaternions and vectors"):
        quat_rotate(q, v[:5])


AXIS = np.array([0.48, -0.6, 0.64])


def test_the_angle_of_a_rotation_beside_half_a_turn_is_exact():
    for distance in DISTANCES:
        R = matrix_from_natural(AXIS, math.pi - distance)
        assert abs(angle_between(np.eye(3), R) - (math.pi - distance)) < 1e-15
        assert abs(angle_between(rot_z(0.7), rot_z(0.7) @ R) - (math.pi - distance)) < 1e-15
