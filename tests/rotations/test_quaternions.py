from __future__ import annotations

import math

import mpmath
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, strategies as st
from rotation_samples import (
    PROPERTY,
    integer_rotations,
    many_quaternions,
    many_rotations,
    quaternions,
    random_rotations,
    worst,
)
from scipy.spatial.transform import Rotation, Slerp

from nao_kin.errors import ZeroNorm
from nao_kin.rotations import (
    exp,
    matrix_from_quat,
    natural_invariants,
    quat_canonical,
    quat_conjugate,
    quat_from_matrix,
    quat_from_xyzw,
    quat_multiply,
    quat_to_xyzw,
    rot_z,
    slerp,
)


def up_to_sign(p, q):
    """The largest component by which quaternions differ from others or their negatives."""
    return np.minimum(np.abs(p - q).max(axis=-1), np.abs(p + q).max(axis=-1)).max()


def test_matrix_to_quaternion_agrees_with_pinocchio():
    R = many_rotations(400)
    ours = quat_from_matrix(R)
    assert up_to_sign(ours, quat_from_xyzw([pin.Quaternion(each).coeffs() for each in R])) < 3e-15
    assert worst(np.linalg.norm(ours, axis=-1), 1.0) < 5e-16
    assert ours[:, 0].min() >= 0.0


def test_quaternion_to_matrix_agrees_with_pinocchio():
    q = many_quaternions(400)
    assert worst(matrix_from_quat(q), [pin.Quaternion(*each).toRotationMatrix() for each in q]) < 2e-15


def test_quaternion_and_its_negative_are_one_rotation_and_come_back_canonical():
    q = many_quaternions(600)
    R = matrix_from_quat(q)
    assert worst(matrix_from_quat(-q), R) == 0.0
    again = quat_from_matrix(R)
    assert up_to_sign(again, q) < 2e-15
    assert worst(matrix_from_quat(again), R) < 2e-15


def test_product_composes_rotations_and_agrees_with_pinocchio():
    p, q = many_quaternions(400, seed=0), many_quaternions(400, seed=5)
    pq = quat_multiply(p, q)
    assert worst(matrix_from_quat(pq), matrix_from_quat(p) @ matrix_from_quat(q)) < 3e-15
    theirs = [(pin.Quaternion(*a) * pin.Quaternion(*b)).coeffs() for a, b in zip(p, q, strict=True)]
    assert worst(quat_to_xyzw(pq), theirs) < 1e-15


def test_conjugate_is_the_inverse_rotation():
    q = many_quaternions(600)
    assert worst(matrix_from_quat(quat_conjugate(q)), np.swapaxes(matrix_from_quat(q), -1, -2)) < 1e-15
    assert worst(quat_multiply(q, quat_conjugate(q)), [1.0, 0.0, 0.0, 0.0]) < 1e-15


def test_product_multiplies_lengths_and_follows_the_formula():
    p, q = np.array([1.0, 2.0, 3.0, 4.0]), np.array([-0.5, 0.25, 6.0, -7.0])
    vector = p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])
    assert worst(quat_multiply(p, q), [p[0] * q[0] - p[1:] @ q[1:], *vector]) < 1e-14
    assert quat_multiply([0, 1, 0, 0], [0, 0, 1, 0]).tolist() == [0.0, 0.0, 0.0, 1.0]


def test_the_order_of_components_is_in_the_names():
    assert quat_to_xyzw([1, 2, 3, 4]).tolist() == [2.0, 3.0, 4.0, 1.0]
    assert quat_from_xyzw([1, 2, 3, 4]).tolist() == [4.0, 1.0, 2.0, 3.0]
    R = random_rotations(20)
    assert worst(quat_to_xyzw(quat_from_matrix(R)), Rotation.from_matrix(R).as_quat(canonical=True)) < 1e-15


def test_integer_rotations_have_exact_quaternions():
    q = quat_from_matrix(integer_rotations())
    known = np.array([0.0, 0.5, math.sqrt(0.5), 1.0])
    assert np.abs(np.abs(q)[..., None] - known).min(axis=-1).max() < 3e-16
    assert worst(matrix_from_quat(q), integer_rotations()) < 5e-16


def test_small_angles_keep_their_relative_accuracy():
    for angle in (1e-15, 1e-12, 1e-8, 1e-4):
        q = quat_from_matrix(exp([0.6 * angle, 0.0, -0.8 * angle]))
        assert q[1:] == pytest.approx([0.3 * angle, 0.0, -0.4 * angle], rel=1e-8 if angle > 1e-5 else 1e-15, abs=0.0)


def test_canonical_sign_is_that_of_the_first_component_that_is_not_zero():
    given_ = [[-1, 2, 3, 4], [0, -1, 2, 0], [0, 0, -3, 4], [-0.0, 0, 0, -2], [1, -2, 0, 0]]
    expected = [[1, -2, -3, -4], [0, 1, -2, 0], [0, 0, 3, -4], [0, 0, 0, 2], [1, -2, 0, 0]]
    found = quat_canonical(given_)
    assert found.tolist() == expected
    assert not np.signbit(found[found == 0.0]).any()


def test_half_turns_get_the_canonical_sign():
    for e in ([1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 2, 3], [0, -1, 5]):
        e = np.array(e) / np.linalg.norm(e)
        q = quat_from_matrix(2.0 * np.outer(e, e) - np.eye(3))
        assert worst(q, quat_canonical([0.0, *e])) < 4e-16


@PROPERTY
@given(p=quaternions, q=quaternions, t=st.floats(0.0, 1.0))
def test_slerp_agrees_with_scipy(p, q, t):
    ours = matrix_from_quat(slerp(p, q, t))
    theirs = Slerp([0.0, 1.0], Rotation.from_quat([p, q], scalar_first=True))(t).as_matrix()
    assert abs(np.linalg.norm(slerp(p, q, t)) - 1.0) < 1e-14
    # Half a turn apart both arcs are the shorter one.
    if abs(p @ q) > 1e-6:
        assert worst(ours, theirs) < 1e-9
    _, whole = natural_invariants(matrix_from_quat(p).T @ matrix_from_quat(q))
    _, part = natural_invariants(matrix_from_quat(p).T @ ours)
    assert abs(part - t * whole) < 1e-14


def test_slerp_starts_at_p_and_ends_at_q_or_its_negative():
    p, q = many_quaternions(600, seed=0), many_quaternions(600, seed=5)
    assert worst(slerp(p, q, 0.0), p) < 1e-15
    assert up_to_sign(slerp(p, q, 1.0), q) < 1e-15


def test_slerp_between_equal_opposite_and_nearly_equal_quaternions():
    p = np.array([0.5, -0.5, 0.5, 0.5])
    assert worst(slerp(p, p, 0.3), p) < 1e-15
    assert worst(slerp(p, -p, 0.3), p) < 1e-15
    for tangent in (1e-12, 1e-8, 1e-7, 1e-6, 1e-5, 1e-3, 0.1):
        part = slerp([1, 0, 0, 0], [1, 0, 0, tangent], 0.25)
        assert part[3] == pytest.approx(math.sin(0.25 * math.atan(tangent)), rel=1e-15, abs=0.0)


def test_slerp_goes_on_outside_its_ends():
    p, q = quat_from_matrix(rot_z([0.1, 0.4]))
    assert worst(matrix_from_quat(slerp(p, q, [-1.0, 2.0])), rot_z([-0.2, 0.7])) < 1e-15


ANY_PART = [0.0, 1.0, 0.5, -0.3, 7.0, 123.456, -1e3, 1e6, -1e10]


def test_slerp_gives_unit_quaternions_for_every_part():
    p, q = (many_quaternions(600, seed)[:, np.newaxis] for seed in (0, 5))
    for end in (q, -q, p, -p):
        assert worst(np.linalg.norm(slerp(p, end, ANY_PART), axis=-1), 1.0) < 1e-15


@pytest.mark.parametrize("angle", [10.0**-k for k in range(17)])
def test_slerp_gives_unit_quaternions_between_nearly_equal_ends(angle):
    for p in quat_from_matrix(random_rotations(10, seed=11)):
        q = quat_multiply(p, quat_from_matrix(exp([0.6 * angle, 0.0, -0.8 * angle])))
        for end in (q, -q):
            assert np.abs(np.linalg.norm(slerp(p, end, ANY_PART), axis=-1) - 1.0).max() < 1e-15


def test_slerp_between_quaternions_at_a_right_angle_takes_the_second_as_given():
    h = math.sqrt(0.5)
    units = np.concatenate([np.eye(4), -np.eye(4)])
    for i, p in enumerate(units):
        for j, q in enumerate(units):
            if i % 4 != j % 4:
                assert worst(slerp(p, q, [0.5, 1.0]), [h * (p + q), q]) < 3e-16
    # Just beside a right angle the shorter arc is taken.
    for cosine in (1e-17, 1e-12):
        assert worst(slerp([1, 0, 0, 0], [cosine, 1, 0, 0], 1.0), [cosine, 1, 0, 0]) < 3e-16
        assert worst(slerp([1, 0, 0, 0], [-cosine, 1, 0, 0], 1.0), [cosine, -1, 0, 0]) < 3e-16


@pytest.mark.parametrize("angle", [10.0**-k for k in range(14)])
def test_slerp_goes_on_at_constant_velocity_however_small_the_angle(angle):
    for goal in (0.1, 1.0, 3.0, -20.0):
        t, q = goal / angle, [1.0, math.tan(angle), 0.0, 0.0]
        with mpmath.workdps(40):
            whole = mpmath.mpf(t) * mpmath.atan(mpmath.mpf(q[1]))
            expected = [float(mpmath.cos(whole)), float(mpmath.sin(whole)), 0.0, 0.0]
        assert worst(slerp([1, 0, 0, 0], q, t), expected) < 3e-16 * max(1.0, abs(goal))


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_the_length_of_a_quaternion_does_not_matter(scale):
    q = quat_from_matrix(random_rotations(5))
    assert worst(matrix_from_quat(scale * q), matrix_from_quat(q)) < 1e-15
    assert worst(matrix_from_quat(scale * q[0]), matrix_from_quat(q[0])) < 1e-15
    assert worst(slerp(scale * q, q[::-1], 0.3), slerp(q, q[::-1], 0.3)) < 1e-15


def test_a_zero_quaternion_is_refused_at_its_index():
    q = np.ones((2, 3, 4))
    q[1, 2] = 0.0
    for call in (matrix_from_quat, quat_canonical, lambda z: slerp(z, [1, 0, 0, 0], 0.5)):
        with pytest.raises(ZeroNorm, match=r"quaternion.* must not be zero at index \[1, 2\]"):
            call(q)
        with pytest.raises(ZeroNorm, match="quaternion.* must not be zero$"):
            call([0, 0, 0, 0])
