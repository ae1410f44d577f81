from __future__ import annotations

import math
from functools import partial

import mpmath
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from rotation_samples import PROPERTY
from screw_samples import ANGLES, EPS, EXACT, as_array, exact_ad, long_twists, power_series, random_twists, twists

from nao_kin import screws
from nao_kin.errors import SingularMatrix

assert_near = partial(np.testing.assert_allclose, rtol=0)
FUNCTIONS = {
    "left": (screws.left_jacobian, screws.left_jacobian_inverse, 1.0),
    "right": (screws.right_jacobian, screws.right_jacobian_inverse, -1.0),
}


def exact_jacobian(twist: np.ndarray) -> mpmath.matrix:
    """The left Jacobian, the mean of the adjoints on the way; the right one for −ξ."""
    with mpmath.workdps(60):
        return power_series(exact_ad(twist), 1)


def check(side: str, twist: np.ndarray, roundings: float) -> None:
    jacobian, inverse, sign = FUNCTIONS[side]
    size = 1 + np.abs(twist).max()
    exact = exact_jacobian(sign * twist)
    assert_near(jacobian(twist), as_array(exact), atol=roundings * EPS * size)
    with mpmath.workdps(60):
        undone = as_array(exact**-1)
    # The inverse moves with the rounding of the angle, and more so towards a whole turn: its block of translations has
    # the slope of 1 / sin², which is 1 / sin³.
    distance = abs(math.sin(np.linalg.norm(twist[3:]) / 2)) if np.linalg.norm(twist[3:]) > 1 else 1.0
    assert_near(inverse(twist), undone, atol=roundings * EPS * size / distance**3)


@pytest.mark.parametrize("side", FUNCTIONS)
@settings(EXACT, max_examples=10)
@given(twists)
def test_jacobians_are_the_mean_of_the_adjoints_on_the_way_and_their_inverses_undo_them(side, twist) -> None:
    check(side, twist, 8)


@pytest.mark.parametrize("side", FUNCTIONS)
@settings(EXACT, max_examples=6)
@given(long_twists)
def test_jacobians_hold_past_half_a_turn(side, twist) -> None:
    if abs(math.sin(np.linalg.norm(twist[3:]) / 2)) < 1e-3:
        return
    check(side, twist, 60)


@pytest.mark.parametrize("side", FUNCTIONS)
def test_jacobians_are_exact_at_and_beside_every_special_angle(side) -> None:
    for seed, angle in enumerate(ANGLES[::2]):
        check(side, random_twists(1, seed, angle)[0], 8)


def test_where_closed_forms_take_over_nothing_jumps() -> None:
    # Series up to half a turn, closed forms from there.
    e, v = np.array([0.36, 0.48, 0.8]), np.array([0.3, -1.0, 0.7])
    below, above = (np.r_[v, a * e] for a in (math.pi * (1 - 2 * EPS), math.pi * (1 + 2 * EPS)))
    for function in (screws.exp, screws.left_jacobian, screws.left_jacobian_inverse):
        assert_near(function(below), function(above), atol=2e-14)


@pytest.mark.parametrize("side", FUNCTIONS)
@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-4, 0.7, 2.0, math.pi, 4.0, 9.0])
def test_jacobians_say_how_the_exponential_changes(side, angle) -> None:
    jacobian, inverse, _ = FUNCTIONS[side]
    twist = random_twists(1, 3, angle)[0]
    T, J = screws.exp(twist), jacobian(twist)
    step = 1e-5
    for i in range(6):
        ahead, behind = (screws.exp(twist + h * np.eye(6)[i]) for h in (step, -step))
        moved = [M @ screws.inverse(T) if side == "left" else screws.inverse(T) @ M for M in (ahead, behind)]
        assert_near((screws.log(moved[0]) - screws.log(moved[1])) / (2 * step), J[:, i], atol=1e-9)
        if angle < 3.0:
            change = [screws.exp(h * np.eye(6)[i]) for h in (step, -step)]
            near = [screws.log(D @ T if side == "left" else T @ D) for D in change]
            assert_near((near[0] - near[1]) / (2 * step), inverse(twist)[:, i], atol=1e-9)


def test_pinocchios_jacobians_are_the_right_ones_where_it_keeps_its_digits() -> None:
    for twist in random_twists(100, 4):
        if np.linalg.norm(twist[3:]) < 0.5:
            continue
        T = screws.exp(twist)
        assert_near(screws.right_jacobian(twist), pin.Jexp6(pin.Motion(twist)), atol=1e-13)
        assert_near(screws.right_jacobian_inverse(twist), pin.Jlog6(pin.SE3(T)), atol=1e-12)


@PROPERTY
@given(twists)
def test_left_and_right_differ_by_the_adjoint_of_the_motion(twist) -> None:
    size = (1 + np.abs(twist).max()) ** 2
    left, right = screws.left_jacobian(twist), screws.right_jacobian(twist)
    assert_near(left, screws.adjoint(screws.exp(twist)) @ right, atol=20 * EPS * size)
    assert_near(left @ twist, twist, atol=20 * EPS * size)


@pytest.mark.parametrize("turns", [1, -1, 2, 7])
def test_at_whole_turns_there_is_no_inverse_and_beside_them_there_is(turns) -> None:
    whole = np.array([0.3, 0.2, 0.1, 0, 0, 2 * math.pi * turns])
    for inverse in (screws.left_jacobian_inverse, screws.right_jacobian_inverse):
        with pytest.raises(SingularMatrix, match=r"has no inverse at index \[1\]: ‖ω‖ is a multiple of 2π"):
            inverse(np.stack([np.ones(6), whole]))
        beside = whole * (1 + 1e-6)
        J = screws.left_jacobian(beside if inverse is screws.left_jacobian_inverse else -beside)
        assert_near(inverse(beside) @ J, np.eye(6), atol=1e-3)
    np.testing.assert_array_equal(screws.left_jacobian_inverse(np.zeros(6)), np.eye(6))
