from __future__ import annotations

import itertools
import math

import mpmath
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, strategies as st
from loops import for_all
from rotation_samples import CONVENTIONS, DISTANCES, PROPERTY, axes, rotation_vectors, worst

from nao_kin.errors import BadArgument, SingularMatrix, UnknownName
from nao_kin.rotations import (
    euler_rate_jacobian,
    euler_rate_jacobian_inverse,
    exp,
    left_jacobian,
    left_jacobian_inverse,
    log,
    matrix_from_euler,
    right_jacobian,
    right_jacobian_inverse,
    skew,
    vee,
)

AXIS = np.array([0.48, -0.6, 0.64])
SIDES = ["fixed", "moving"]
each_convention = for_all(
    ("sequence", "axes_", "side"), [(s, a, side) for (s, a), side in itertools.product(CONVENTIONS, SIDES)]
)


@PROPERTY
@given(v=rotation_vectors, w=rotation_vectors)
def test_the_skew_matrix_crosses_and_comes_back(v, w):
    assert worst(skew(v) @ w, np.cross(v, w)) < 4e-15
    assert worst(vee(skew(v)), v) < 1e-300
    assert worst(skew(v), pin.skew(v)) == 0.0


def test_skew_matrices_of_rotations_that_turn():
    W = exp([0.0, 0.0, 1e-9]) - np.eye(3)
    assert worst(vee(W), [0, 0, 1e-9]) < 1e-24
    assert vee(np.zeros((2, 3, 3))).tolist() == [[0.0] * 3] * 2


def test_of_entries_that_differ_by_rounding_the_mean_is_taken_at_every_scale():
    for scale in (1e-6, 1.0, 1e6):
        W = scale * (skew([1, 2, 3]) + np.array([[0, 0, 0], [1e-7, 0, 0], [0, 3e-7, 0]]))
        assert worst(vee(W) / scale, [1 + 1.5e-7, 2, 3 + 0.5e-7]) < 1e-15
        with pytest.raises(BadArgument, match="not skew-symmetric"):
            vee(scale * (skew([1, 2, 3]) + 1e-5 * np.eye(3)))


def test_a_matrix_that_is_not_skew_symmetric_is_refused_with_its_index():
    with pytest.raises(BadArgument, match=r"matrix at index \[1\] is not skew-symmetric"):
        vee([skew([1, 2, 3]), np.eye(3)])
    with pytest.raises(BadArgument, match="W \\+ Wᵀ is 1e-05"):
        vee(skew([1, 0, 0]) + 0.5e-5 * np.eye(3))


def exact_left(v):
    """The left Jacobian in many digits, and its inverse."""
    with mpmath.workdps(700):
        x = [mpmath.mpf(float(c)) for c in v]
        phi = mpmath.sqrt(sum(c * c for c in x))
        K = mpmath.matrix([[0, -x[2], x[1]], [x[2], 0, -x[0]], [-x[1], x[0], 0]])
        J = mpmath.eye(3) + (1 - mpmath.cos(phi)) / phi**2 * K + (phi - mpmath.sin(phi)) / phi**3 * K * K
        c = (1 - phi / 2 * mpmath.cot(phi / 2)) / phi**2
        inverse = mpmath.eye(3) - K / 2 + c * K * K
        return (np.array(M.tolist(), dtype=np.float64) for M in (J, inverse))


@for_all("angle", [*DISTANCES[1:], 0.0099, 0.0101, 0.5, 1.0, 2.0, 3.0])
def test_the_jacobians_are_exact_near_zero_and_between(angle):
    v = angle * AXIS
    J, inverse = exact_left(v)
    assert worst(left_jacobian(v), J) < 5e-16
    assert worst(left_jacobian_inverse(v), inverse) < 1e-15
    # What is not on the diagonal carries the small angles.
    assert worst(left_jacobian(v) - left_jacobian(v).T, J - J.T) < 5e-16 * angle


@for_all("angle", [*DISTANCES[2:], 0.0099, 0.0101, 0.3, 1.0, 2.0, 3.1, 3.2, 5.0])
def test_small_entries_of_the_jacobians_have_all_their_digits(angle):
    # About an axis in the plane of x and y each entry is a single term, however small.
    v = angle * np.array([0.6, 0.8, 0.0])
    for found, exact in zip((left_jacobian(v), left_jacobian_inverse(v)), exact_left(v), strict=True):
        single = (exact != 0.0) & ~np.eye(3, dtype=bool)
        assert single.sum() == 6
        assert (np.abs(found - exact)[single] < 2e-15 * np.abs(exact)[single]).all()


@for_all("distance", [-d for d in DISTANCES] + DISTANCES)
def test_nothing_happens_to_the_jacobians_at_half_a_turn(distance):
    v = (math.pi + distance) * AXIS
    J, inverse = exact_left(v)
    assert worst(left_jacobian(v), J) < 1e-15
    assert worst(left_jacobian_inverse(v), inverse) < 2e-15


@for_all("turns", [1, 2, 7])
@for_all("distance", [1e-12, 1e-9, 1e-6, 1e-3, -1e-12, -1e-6, -1e-2])
def test_beside_whole_turns_the_inverse_has_the_digits_that_the_distance_has(turns, distance):
    v = (2 * math.pi * turns + distance) * AXIS
    J, inverse = exact_left(v)
    assert worst(left_jacobian(v), J) < 2e-15 * turns
    assert worst(left_jacobian_inverse(v) / np.abs(inverse).max(), inverse / np.abs(inverse).max()) < (
        4e-15 * turns / abs(distance) + 4e-15
    )


@for_all("turns", [1, 2, 5])
def test_at_whole_turns_one_direction_is_left_and_there_is_no_inverse(turns):
    v = 2 * math.pi * turns * np.array([0.0, 0.0, 1.0])
    assert worst(left_jacobian(v), np.diag([0, 0, 1])) < 1e-15
    for inverse, name in ((left_jacobian_inverse, "left"), (right_jacobian_inverse, "right")):
        with pytest.raises(SingularMatrix, match=rf"{name} Jacobian has no inverse at index \[1\]") as caught:
            inverse([AXIS, v])
        assert caught.value.index == (1,)


@PROPERTY
@given(v=rotation_vectors)
def test_left_and_right_are_transposed_inverse_and_agree_with_pinocchio(v):
    R, J = exp(v), right_jacobian(v)
    assert worst(left_jacobian(v), J.T) < 1e-15
    assert worst(left_jacobian(v), R @ J) < 3e-15
    assert worst(left_jacobian(-v), J) < 1e-15
    assert worst(right_jacobian_inverse(v) @ J, np.eye(3)) < 3e-15
    assert worst(left_jacobian_inverse(v) @ left_jacobian(v), np.eye(3)) < 3e-15
    if np.linalg.norm(v) > 1e-6:  # where Pinocchio's own formula keeps its digits
        assert worst(J, pin.Jexp3(v)) < 1e-9
    if 1e-2 < np.linalg.norm(v) < 3.0:
        assert worst(right_jacobian_inverse(v), pin.Jlog3(R)) < 1e-9


@PROPERTY
@given(e=axes, angle=st.floats(0.1, 3.0), d=axes)
def test_the_jacobians_are_the_derivatives_of_exp_and_log(e, angle, d):
    v, h = angle * e, 1e-5
    change = (exp(v + h * d) - exp(v - h * d)) / (2 * h)
    assert worst(vee_of(change @ exp(v).T), left_jacobian(v) @ d) < 1e-9
    assert worst(vee_of(exp(v).T @ change), right_jacobian(v) @ d) < 1e-9
    left = (log(exp(h * d) @ exp(v)) - log(exp(-h * d) @ exp(v))) / (2 * h)
    assert worst(left, left_jacobian_inverse(v) @ d) < 1e-8
    right = (log(exp(v) @ exp(h * d)) - log(exp(v) @ exp(-h * d))) / (2 * h)
    assert worst(right, right_jacobian_inverse(v) @ d) < 1e-8


def vee_of(W):
    return vee((W - np.swapaxes(W, -1, -2)) / 2)


@each_convention
def test_rates_of_angles_make_the_angular_velocity(sequence, axes_, side):
    triples = np.random.default_rng(0).uniform(-3.1, 3.1, (40, 3))
    J = euler_rate_jacobian(triples, sequence, axes=axes_, expressed_in=side)
    R = matrix_from_euler(triples, sequence, axes=axes_)
    h = 1e-5
    for i in range(3):
        step = h * np.eye(3)[i]
        change = matrix_from_euler(triples + step, sequence, axes=axes_)
        change = (change - matrix_from_euler(triples - step, sequence, axes=axes_)) / (2 * h)
        W = change @ np.swapaxes(R, -1, -2) if side == "fixed" else np.swapaxes(R, -1, -2) @ change
        assert worst(J[..., i], vee_of(W)) < 1e-9


@each_convention
def test_the_inverse_of_the_rates_is_exact_up_to_lock_and_refused_there(sequence, axes_, side):
    pole = 0.0 if sequence[0] == sequence[2] else math.pi / 2
    for distance in (1e-14, 1e-12, 1e-9, 1e-6, 1e-3, 0.3, 1.2):
        for sign in (-1, 1):
            triple = [0.4, pole + sign * distance, -1.1]
            J = euler_rate_jacobian(triple, sequence, axes=axes_, expressed_in=side)
            inverse = euler_rate_jacobian_inverse(triple, sequence, axes=axes_, expressed_in=side)
            assert worst(J @ inverse, np.eye(3)) < 1e-15 / distance + 1e-15
            assert abs(abs(np.linalg.det(J)) - math.sin(distance)) < 1e-15
    function = "cos" if pole else "sin"
    with pytest.raises(SingularMatrix, match=rf"at index \[1\]: the angles are at lock, {function} β = 0"):
        euler_rate_jacobian_inverse([[1, 1, 1], [0.4, pole, 1]], sequence, axes=axes_, expressed_in=side)


def test_the_frame_of_the_angular_velocity_must_be_given_and_known():
    for function in (euler_rate_jacobian, euler_rate_jacobian_inverse):
        with pytest.raises(BadArgument, match="expressed_in= must be given"):
            function([0.1, 0.2, 0.3], "xyz", axes="fixed")
        with pytest.raises(UnknownName, match="unknown expressed_in"):
            function([0.1, 0.2, 0.3], "xyz", axes="fixed", expressed_in="body")
        with pytest.raises(UnknownName, match="unknown sequence"):
            function([0.1, 0.2], "xy", axes="fixed", expressed_in="fixed")
