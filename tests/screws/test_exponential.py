from __future__ import annotations

import math
from functools import partial

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from rotation_samples import PROPERTY, integer_rotations
from screw_samples import ANGLES, EPS, EXACT, exact_pose, length, long_twists, points, random_twists, twists

from nao_kin import screws
from nao_kin.errors import BadArgument

assert_near = partial(np.testing.assert_allclose, rtol=0)


def assert_poses_near(T: np.ndarray, expected: np.ndarray, turn: float, shift: float) -> None:
    """Rotations to `turn`, translations to `shift`, the last row exactly."""
    assert_near(T[..., :3, :3], expected[..., :3, :3], atol=turn)
    assert_near(T[..., :3, 3], expected[..., :3, 3], atol=shift)
    np.testing.assert_array_equal(T[..., 3, :], np.broadcast_to([0, 0, 0, 1], (*T.shape[:-2], 4)))


def beside_special_angles() -> np.ndarray:
    return np.concatenate([random_twists(2, seed, angle) for seed, angle in enumerate(ANGLES)])


# --- the exponential


@EXACT
@given(twists)
def test_the_exponential_is_that_of_the_matrix(twist) -> None:
    size = length(twist[:3])
    assert_poses_near(screws.exp(twist), exact_pose(twist), 6 * EPS, 6 * EPS * size)


@EXACT
@given(long_twists)
def test_past_half_a_turn_the_angle_within_a_turn_is_what_is_left_of_its_digits(twist) -> None:
    size, angle = length(twist[:3]), np.linalg.norm(twist[3:])
    assert_poses_near(screws.exp(twist), exact_pose(twist), 6 * EPS * angle, 6 * EPS * angle * size)


def test_the_exponential_is_exact_at_and_beside_every_special_angle() -> None:
    found = screws.exp(beside_special_angles())
    for T, twist in zip(found, beside_special_angles(), strict=True):
        assert_poses_near(T, exact_pose(twist), 6 * EPS, 6 * EPS * length(twist[:3]))


def test_the_shift_that_a_small_turn_adds_is_right_relative_to_itself() -> None:
    for angle in (1e-3, 1e-8, 1e-12, 1e-100):
        T = screws.exp([2, 0, 0, 0, 0, angle])
        assert_near(T[1, 3], angle, atol=4 * EPS * angle + angle**3)
        assert_near(T[1, 0], math.sin(angle), atol=4 * EPS * angle)


@PROPERTY
@given(points)
def test_a_twist_without_a_turn_is_a_translation_to_the_last_bit(v) -> None:
    T = screws.exp(np.r_[v, 0, 0, 0])
    np.testing.assert_array_equal(T[:3, :3], np.eye(3))
    np.testing.assert_array_equal(T[:3, 3], v)
    np.testing.assert_array_equal(screws.log(T), np.r_[v, 0, 0, 0])


def test_pinocchio_has_the_same_exponential_and_logarithm_where_it_keeps_its_digits() -> None:
    for twist in random_twists(200):
        T = screws.exp(twist)
        assert_near(T, pin.exp6(twist).homogeneous, atol=1e-14 / min(1.0, np.linalg.norm(twist[3:])))
        if 0.3 < np.linalg.norm(twist[3:]) < 2.8:
            assert_near(screws.log(T), pin.log6(pin.SE3(T)).vector, atol=1e-13)


# --- the logarithm


@EXACT
@given(twists)
def test_the_logarithm_gives_the_twist_back(twist) -> None:
    if np.linalg.norm(twist[3:]) > math.pi - 1e-15:
        return  # there the opposite turn may come out
    found, size = screws.log(exact_pose(twist)), length(twist[:3])
    assert_near(found[3:], twist[3:], atol=6 * EPS)
    assert_near(found[:3], twist[:3], atol=12 * EPS * size)


def test_the_logarithm_is_right_at_and_beside_every_special_angle() -> None:
    for twist in beside_special_angles():
        found = screws.log(exact_pose(twist))
        size, angle = length(twist[:3]), np.linalg.norm(twist[3:])
        if angle > math.pi - 1e-15 and found[3:] @ twist[3:] < 0:
            # The twist of the opposite turn about the same line, with the same slide along it.
            e = twist[3:] / angle
            along = (twist[:3] @ e) * e
            twist = np.r_[along - (twist[:3] - along), -twist[3:]]
        assert_near(found[3:], twist[3:], atol=min(6 * EPS, 1e-14 * angle))
        assert_near(found[:3], twist[:3], atol=12 * EPS * size)


@EXACT
@given(twists)
def test_the_exponential_of_the_logarithm_is_the_pose(twist) -> None:
    T = exact_pose(twist)
    assert_poses_near(screws.exp(screws.log(T)), T, 12 * EPS, 12 * EPS * length(T[:3, 3]))


def test_half_turns_are_about_the_axis_whose_first_component_is_positive_and_come_back() -> None:
    R = integer_rotations()
    T = screws.pose(R, np.arange(72.0).reshape(24, 3))
    twist = screws.log(T)
    assert_near(screws.exp(twist), T, atol=200 * EPS)
    half = np.isclose(np.linalg.norm(twist[:, 3:], axis=-1), math.pi)
    assert half.sum() == 9
    for omega in twist[half, 3:]:
        assert omega[np.flatnonzero(np.abs(omega) > 1e-12)[0]] > 0


def test_the_logarithm_turns_by_no_more_than_half_a_turn() -> None:
    twist = random_twists(100, 1)
    longer = twist * (1 + 2 * math.pi / np.linalg.norm(twist[:, 3:], axis=-1, keepdims=True))
    found = screws.log(screws.exp(longer))
    assert (np.linalg.norm(found[:, 3:], axis=-1) <= math.pi).all()
    assert_near(screws.exp(found), screws.exp(longer), atol=1e-12)


# --- the matrix of a twist


@PROPERTY
@given(twists)
def test_the_matrix_of_a_twist_gives_it_back(twist) -> None:
    matrix = screws.hat(twist)
    np.testing.assert_array_equal(screws.vee(matrix), twist)
    p = np.array([0.3, -1.0, 2.0])
    assert_near(matrix @ [*p, 1], [*(twist[:3] + np.cross(twist[3:], p)), 0], atol=40 * EPS * (1 + np.abs(twist).max()))


def test_a_matrix_that_is_no_twist_is_refused_and_rounding_is_not() -> None:
    good = screws.hat([1, 2, 3, 4, 5, 6])
    for at in ((0, 0), (0, 1), (3, 0), (3, 3)):
        bad = good.copy()
        bad[at] += 1e-6
        with pytest.raises(BadArgument, match=r"must be \[\[\[ω×\], v\], \[0, 0\]\]"):
            screws.vee(bad)
        bad[at] -= 1e-6 - 1e-10
        assert_near(screws.vee(bad), [1, 2, 3, 4, 5, 6], atol=1e-9)
    with pytest.raises(BadArgument, match=r"at index \[1\] it differs from that form by 2"):
        screws.vee(np.stack([good, np.eye(4)]))
