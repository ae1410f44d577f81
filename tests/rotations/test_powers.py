from __future__ import annotations

import math

import mpmath
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

from nao_kin.errors import BadArgument, WrongShape, ZeroNorm
from nao_kin.rotations import (
    angle_between,
    exp,
    log,
    matrix_from_natural,
    matrix_from_quat,
    power,
    quat_canonical,
    quat_conjugate,
    quat_exp,
    quat_from_matrix,
    quat_log,
    quat_multiply,
    quat_power,
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
    for angle in (1e-200, 1e-12, 1e-8):
        assert power(rot_x(angle), 0.25)[2, 1] == pytest.approx(0.25 * angle, rel=1e-15, abs=0.0)


def test_exponents_broadcast_with_rotations_and_keep_their_digits():
    assert power(random_rotations(3)[:, None], np.zeros(4)).shape == (3, 4, 3, 3)
    with pytest.raises(BadArgument, match=r"exponent must not exceed 1e\+15"):
        power(np.eye(3), 1e16)
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
    for scale in (1.0, -3.0, 1e-200, 1e200):
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


def exact_exponential(q):
    with mpmath.workdps(400):
        w, *r = (mpmath.mpf(float(x)) for x in q)
        theta = mpmath.sqrt(sum(x * x for x in r))
        factor = mpmath.sin(theta) / theta if theta else mpmath.mpf(1)
        return [float(mpmath.exp(w) * c) for c in (mpmath.cos(theta), *(factor * x for x in r))]


def exact_logarithm(q):
    with mpmath.workdps(400):
        w, *r = (mpmath.mpf(float(x)) for x in q)
        length = mpmath.sqrt(sum(x * x for x in r))
        theta = mpmath.atan2(length, w)
        return [float(mpmath.log(mpmath.sqrt(w * w + length * length))), *(float(theta * x / length) for x in r)]


AXIS = np.array([0.48, -0.6, 0.64])


@pytest.mark.parametrize("scalar", [0.0, 1.0, -3.0, 1e-9])
@pytest.mark.parametrize("place", [0.0, math.pi / 2, math.pi, 2 * math.pi])
def test_the_exponential_of_a_quaternion_is_exact_at_every_distance_from_whole_and_half_turns(place, scalar):
    for distance in DISTANCES:
        q = np.array([scalar, *((place + distance) * AXIS)])
        assert worst(quat_exp(q), exact_exponential(q)) < 2e-15 * math.exp(scalar)


@pytest.mark.parametrize("length", [1.0, 1e-3, 7.0, 1e-200, 1e200])
def test_the_logarithm_of_a_quaternion_is_exact_near_zero_near_pi_and_between(length):
    for theta in (*DISTANCES[1:], 0.5, 1.0, 2.0, *(math.pi - d for d in DISTANCES)):
        for scalar in (math.cos(theta), -math.cos(theta)):
            q = length * np.array([scalar, *(max(math.sin(theta), 1e-100) * AXIS)])
            found, expected = quat_log(q), exact_logarithm(q)
            assert worst(found[1:], expected[1:]) < 1e-15
            assert abs(found[0] - expected[0]) < 1e-15 * max(1.0, abs(expected[0]))
            if scalar > 0.0:  # small vector parts keep their relative accuracy
                assert found[1:] == pytest.approx(expected[1:], rel=1e-15, abs=0.0)


def test_the_vector_of_a_quaternion_beside_a_whole_turn_keeps_its_direction():
    for size in (1e-12, 1e-160, 1e-200, 1e-300):
        assert worst(quat_log([-1.0, *(size * AXIS)])[1:], math.pi * AXIS) < 1e-15 + size


def test_a_whole_turn_is_about_x_for_the_logarithm():
    assert quat_log([-1, 0, 0, 0]).tolist() == [0.0, math.pi, 0.0, 0.0]
    assert quat_log([[-1, 0, 0, 0], [-2, 0, 0, 0]])[:, 1].tolist() == [math.pi, math.pi]
    assert quat_log([1, 0, 0, 0]).tolist() == [0.0, 0.0, 0.0, 0.0]
    assert worst(quat_power([-1, 0, 0, 0], 0.5), [0, 1, 0, 0]) < 1e-15


def test_powers_of_quaternions_are_powers_of_their_rotations():
    q, t = quat_canonical(many_quaternions(600)), np.random.default_rng(1).uniform(-3.0, 3.0, 600)
    less = q[:, 0] > 1e-12  # than half a turn
    expected = power(matrix_from_quat(q[less]), t[less])
    assert worst(matrix_from_quat(quat_power(q[less], t[less])), expected) < 1e-14
    assert worst(quat_power(q, 2.0), quat_multiply(q, q)) < 3e-15
    assert worst(quat_exp(quat_log(q)), q) < 2e-15


def test_powers_of_unit_quaternions_are_unit_quaternions_however_large_the_exponent():
    q = many_quaternions(600)
    for exponent in (1e3, -1e9, 1e15, -1e15):
        assert worst(np.linalg.norm(quat_power(q, exponent), axis=-1), 1.0) < 1e-14
    assert np.linalg.norm(quat_power(1.0001 * q, 1e3), axis=-1) == pytest.approx(1.0001**1e3, rel=1e-12)


def test_powers_multiply_lengths_and_follow_the_quaternion():
    q = 3.0 * quat_exp([0.0, *(1.9 * AXIS)])  # 3.8 rad, more than half a turn
    assert worst(quat_power(q, 2.0), quat_multiply(q, q)) < 2e-14
    half = quat_power(q, 0.5)
    assert worst(quat_multiply(half, half), q) < 2e-15
    assert worst(log(matrix_from_quat(half)), 1.9 * AXIS) < 2e-15
    assert quat_power(q, np.zeros((2, 1))).shape == (2, 1, 4)


def test_half_a_rotation_vector_makes_the_quaternion():
    v = np.random.default_rng(5).uniform(-1.5, 1.5, (100, 3))
    q = quat_exp(np.concatenate([np.zeros((100, 1)), v / 2], axis=-1))
    assert worst(q, quat_from_matrix(exp(v))) < 1e-15
    assert worst(q, Rotation.from_rotvec(v).as_quat(scalar_first=True)) < 1e-15


def test_what_would_overflow_is_refused_with_its_index():
    with pytest.raises(BadArgument, match=r"quaternion at index \[1\] is too large for its exponential"):
        quat_exp([[0, 1, 2, 3], [701, 0, 0, 0]])
    with pytest.raises(BadArgument, match="too large"):
        quat_exp([0, 1e140, 0, 0])
    with pytest.raises(BadArgument, match="too large"):
        quat_power([10.0, 0, 0, 0], 1000.0)
    assert quat_exp([-1000, 1, 0, 0]).tolist() == [0.0, 0.0, 0.0, 0.0]
    with pytest.raises(ZeroNorm):
        quat_log([[1, 0, 0, 0], [0, 0, 0, 0]])


def test_the_angle_of_a_rotation_beside_half_a_turn_is_exact():
    for distance in DISTANCES:
        R = matrix_from_natural(AXIS, math.pi - distance)
        assert abs(angle_between(np.eye(3), R) - (math.pi - distance)) < 1e-15
        assert abs(angle_between(rot_z(0.7), rot_z(0.7) @ R) - (math.pi - distance)) < 1e-15
