from __future__ import annotations

import functools
import math

import mpmath
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, strategies as st
from rotation_samples import (
    PROPERTY,
    axes,
    beside,
    integer_rotations,
    many_rotations,
    turns,
    worst,
)

from nao_kin.errors import BadArgument, ZeroNorm
from nao_kin.rotations import (
    euler_rodrigues,
    exp,
    linear_invariants,
    log,
    matrix_from_euler_rodrigues,
    matrix_from_linear,
    matrix_from_natural,
    natural_invariants,
    rot_x,
    rot_y,
    rot_z,
)

EXACT_AXES = [
    (1, 0, 0),
    (0, 1, 0),
    (0, 0, -1),
    (1, 1, 1),
    (-1, 2, -3),
    (1e-9, 1, 0),
    (1, -1e-5, 1e-12),
    (0.3, 0.4, 0.8),
]
SMALL = [1e-20, 1e-12, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2]


def exact_rotation(axis, angle):
    """The rotation matrix in 60 digits, each entry rounded once, with its unit axis."""
    with mpmath.workdps(400):
        e = mpmath.matrix([mpmath.mpf(float(x)) for x in axis])
        e /= mpmath.norm(e)
        s, c = mpmath.sin(angle), mpmath.cos(angle)
        x, y, z = e
        E = mpmath.matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        R = mpmath.eye(3) + s * E + (1 - c) * E * E
        return np.array(R.tolist(), dtype=np.float64), np.array(list(e), dtype=np.float64)


@functools.cache
def exact_cases():
    """Axis, angle in many digits, matrix: near 0, in between, near π and on it."""
    with mpmath.workdps(400):
        angles = [mpmath.mpf(a) for a in [*SMALL, 0.1, 1.0, math.pi / 2, 2.0, 3.0]]
        angles += [mpmath.pi - mpmath.mpf(a) for a in SMALL]
    return [(angle, *exact_rotation(axis, angle)) for axis in EXACT_AXES for angle in angles]


def test_natural_invariants_are_exact_near_zero_near_pi_and_between():
    for angle, R, e in exact_cases():
        axis, found = natural_invariants(R)
        near_pi = float(mpmath.pi - angle)
        sign = -1.0 if near_pi < 1e-15 and axis @ e < 0.0 else 1.0
        assert worst(sign * axis, e) < 5e-16
        with mpmath.workdps(400):
            error = abs(mpmath.mpf(float(found)) - angle)
            assert error < 6e-16
            assert error / angle < 6e-16


def test_logarithm_is_exact_near_zero_near_pi_and_between():
    for angle, R, e in exact_cases():
        v = log(R)
        sign = -1.0 if float(mpmath.pi - angle) < 1e-15 and v @ e < 0.0 else 1.0
        assert worst(sign * v, e * float(angle)) < 1.2e-15 * min(float(angle), 1.0)


def test_exponential_is_exact_near_zero_near_pi_and_between():
    for angle, R, e in exact_cases():
        found = exp(e * float(angle))
        assert worst(found, R) < 1.2e-15
        # The antisymmetric part carries the small angles, and keeps their relative accuracy.
        difference = (found - found.T) - (R - R.T)
        assert np.abs(difference).max() < 3e-15 * min(float(angle), 1.0)


@PROPERTY
@given(v=st.builds(lambda e, a: e * a, axes, turns))
def test_exponential_and_logarithm_agree_with_pinocchio(v):
    R = exp(v)
    assert worst(R, pin.exp3(v)) < 2e-15
    # Near half a turn only the sign of the axis is open: matrices are compared.
    assert worst(exp(log(R)), R) < 3e-15
    angle = np.linalg.norm(v)
    if 1e-3 < angle < 3.0:
        assert worst(log(R), pin.log3(R)) < 1e-12


def test_every_invariant_gives_the_matrix_back():
    R = many_rotations(600)
    assert worst(matrix_from_natural(*natural_invariants(R)), R) < 3e-15
    assert worst(matrix_from_euler_rodrigues(*euler_rodrigues(R)), R) < 3e-15
    assert worst(exp(log(R)), R) < 3e-15
    q, q0 = linear_invariants(R)
    sine = np.linalg.norm(q, axis=-1)
    held = (q0 > -0.5) | (sine > 1e-7)
    off = np.abs(matrix_from_linear(q[held], q0[held]) - R[held]).max(axis=(-2, -1))
    assert (off < 3e-15 + np.where(q0 > -0.5, 0.0, 4e-16 / np.where(q0 > -0.5, 1.0, sine))[held]).all()


@pytest.mark.filterwarnings("ignore::nao_kin.errors.DegreesWarning")
@PROPERTY
@given(e=axes, a=st.one_of(st.floats(-20.0, 20.0), beside(0.0, math.pi, 2 * math.pi, -math.pi)))
def test_natural_matrix_agrees_with_pinocchios_angle_axis(e, a):
    assert worst(matrix_from_natural(e, a), pin.AngleAxis(a, e).toRotationMatrix()) < 2e-15
    assert worst(matrix_from_natural(17.0 * e, a), pin.AngleAxis(a, e).toRotationMatrix()) < 2e-15


def test_invariants_satisfy_their_definitions():
    R = many_rotations(600)
    e, angle = natural_invariants(R)
    r, r0 = euler_rodrigues(R)
    q, q0 = linear_invariants(R)
    assert angle.min() >= 0.0
    assert angle.max() <= math.pi
    assert r0.min() >= 0.0
    assert worst(np.linalg.norm(e, axis=-1), np.where(angle == 0.0, 0.0, 1.0)) < 1e-15
    assert worst(np.einsum("nij,nj->ni", R, e), e) < 1e-15
    assert worst(r, np.sin(angle / 2)[:, np.newaxis] * e) < 1e-15
    assert worst(r0, np.cos(angle / 2)) < 1e-15
    assert worst(q, np.sin(angle)[:, np.newaxis] * e) < 2e-15
    assert worst(q0, np.cos(angle)) < 2e-15


def test_the_identity_has_no_axis_and_says_so_with_zero():
    axis, angle = natural_invariants(np.eye(3))
    assert axis.tolist() == [0.0, 0.0, 0.0]
    assert angle == 0.0
    assert log(np.eye(3)).tolist() == [0.0, 0.0, 0.0]
    assert not np.signbit(log(np.eye(3))).any()
    assert worst(matrix_from_natural(axis, angle), np.eye(3)) == 0.0


def test_half_turns_have_an_axis_whose_first_nonzero_component_is_positive():
    rng = np.random.default_rng(0)
    axes_ = np.concatenate([rng.normal(size=(50, 3)), np.eye(3), -np.eye(3), [[0, 1, -1], [0, -1, 1], [-1, 0, 1]]])
    axes_ /= np.linalg.norm(axes_, axis=1, keepdims=True)
    for e in axes_:
        R = 2.0 * np.outer(e, e) - np.eye(3)
        axis, angle = natural_invariants(R)
        assert angle == math.pi
        expected = e * np.sign(e[np.nonzero(e)[0][0]])
        assert worst(axis, expected) < 5e-16
        assert worst(log(R), math.pi * expected) < 2e-15


def test_integer_rotations_have_the_angles_of_the_cube():
    _, angle = natural_invariants(integer_rotations())
    degrees = np.degrees(angle)
    counts = {a: int((np.abs(degrees - a) < 1e-13).sum()) for a in (0, 90, 120, 180)}
    assert counts == {0: 1, 90: 6, 120: 8, 180: 9}


def test_linear_invariants_lose_the_axis_at_half_a_turn_and_refuse_to_guess_it():
    for R in (rot_x(math.pi), np.diag([-1.0, 1.0, -1.0]), exp([0.0, 0.0, math.pi - 1e-9])):
        with pytest.raises(BadArgument, match="rotation by π, whose axis they do not contain"):
            matrix_from_linear(*linear_invariants(R))
    with pytest.raises(BadArgument, match=r"at index \[1\]"):
        matrix_from_linear(*linear_invariants([np.eye(3), rot_x(math.pi)]))


def test_linear_invariants_near_half_a_turn_are_as_good_as_the_axis_they_hold():
    for distance in (1e-7, 1e-6, 1e-4, 1e-2):
        for angle in (math.pi - distance, math.pi + distance):
            R = matrix_from_natural([1.0, -2.0, 3.0], angle)
            assert worst(matrix_from_linear(*linear_invariants(R)), R) < 1e-15 + 4e-16 / distance


def test_linear_invariants_of_no_rotation_are_refused():
    for q, q0 in (([0.5, 0.0, 0.0], 0.5), ([0, 0, 0], 0.0), ([1, 1, 0], 1)):
        with pytest.raises(BadArgument, match=r"‖q‖² \+ q0² = 1"):
            matrix_from_linear(q, q0)


def test_a_zero_axis_is_an_axis_only_of_the_zero_angle():
    assert worst(matrix_from_natural([[0, 0, 0], [0, 0, 2]], [0.0, 1.0]), [np.eye(3), rot_z(1.0)]) < 1e-15
    with pytest.raises(ZeroNorm, match=r"rotation axis must not be zero at index \[1\]") as caught:
        matrix_from_natural([[1, 0, 0], [0, 0, 0]], [0.1, 0.1])
    assert caught.value.index == (1,)


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_the_length_of_an_axis_or_of_parameters_does_not_matter(scale):
    e = np.array([1.0, -2.0, 2.0]) / 3.0
    R = matrix_from_natural(e, 1.2)
    assert worst(matrix_from_natural(scale * e, 1.2), R) < 1e-15
    assert worst(matrix_from_natural(np.array([scale * e, e]), 1.2), [R, R]) < 1e-15
    r, r0 = euler_rodrigues(R)
    assert worst(matrix_from_euler_rodrigues(scale * r, scale * r0), R) < 1e-15


def test_zero_parameters_are_refused():
    with pytest.raises(ZeroNorm):
        matrix_from_euler_rodrigues([0, 0, 0], 0)


def test_the_turn_of_thirty_and_thirty_degrees_has_the_papers_invariants():
    R = rot_z(math.pi / 6) @ rot_y(math.pi / 6)
    s = math.sqrt(3.0)
    assert worst(R, [[3 / 4, -1 / 2, s / 4], [s / 4, s / 2, 1 / 4], [-1 / 2, 0, s / 2]]) < 1e-15
    e, angle = natural_invariants(R)
    assert math.degrees(angle) == pytest.approx(42.181162357998204, abs=1e-12)
    assert e == pytest.approx([-0.186156787897, 0.694746590607, 0.694746590607], abs=1e-12)
    assert linear_invariants(R)[0] == pytest.approx([-0.125, 0.466506350946, 0.466506350946], abs=1e-12)


def test_the_rotating_body_of_the_paper_turns_about_the_diagonal_at_every_instant():
    for turn in [*np.linspace(-7.0, 7.0, 57), math.pi / 2, math.pi, 2 * math.pi]:
        c, s = math.cos(turn / 2), math.sin(turn / 2)
        rho = 2 * math.sqrt(3) / 3 * s * c
        d, u, v = c * c - s * s / 3, 2 * s * s / 3 - rho, 2 * s * s / 3 + rho
        R = np.array([[d, u, v], [v, d, u], [u, v, d]])
        assert worst(R, matrix_from_natural([1, 1, 1], turn)) < 1e-15
        r, r0 = euler_rodrigues(R)
        sign = 1.0 if c >= 0.0 else -1.0
        if abs(c) < 1e-15:
            sign = math.copysign(1.0, r[0] * s)
        assert worst(r, sign * s / math.sqrt(3) * np.ones(3)) < 1e-15
        assert abs(r0 - sign * c) < 1e-15


@pytest.mark.parametrize("length", [1e-12, 1e-3, 1.0, 2.0, 3.14, math.pi, 4.0, 6.28, 33.0, 1e3, 1e8, 1e14])
def test_the_exponential_is_right_to_the_digits_that_the_length_leaves(length):
    rng = np.random.default_rng(7)
    for _ in range(20):
        v = rng.normal(size=3)
        v *= length / np.linalg.norm(v)
        with mpmath.workdps(460):
            x = [mpmath.mpf(float(c)) for c in v]
            phi = mpmath.norm(x)
            K = mpmath.matrix([[0, -x[2], x[1]], [x[2], 0, -x[0]], [-x[1], x[0], 0]])
            odd = mpmath.sin(phi) / phi * K
            R = mpmath.eye(3) + odd + (1 - mpmath.cos(phi)) / phi**2 * K * K
            found = mpmath.matrix(exp(v).tolist())
            error = max(abs(e) for e in found - R)
            odd_error = max(abs(e) for e in (found - found.T) / 2 - odd)
        assert error <= 4e-16 * max(1.0, length)
        assert odd_error <= 4e-16 * length
