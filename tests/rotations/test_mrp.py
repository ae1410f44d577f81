from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from rotation_samples import DISTANCES, integer_rotations, many_rotations, random_rotations, worst
from scipy.spatial.transform import Rotation

from nao_kin.errors import BadArgument, ZeroNorm
from nao_kin.rotations import matrix_from_mrp, matrix_from_natural, mrp_from_matrix, mrp_shadow

AXIS = np.array([0.48, -0.6, 0.64])


def test_the_short_triple_of_a_rotation_and_its_shadow_both_give_it_back():
    R = many_rotations(600)
    p = mrp_from_matrix(R)
    assert np.linalg.norm(p, axis=-1).max() <= 1.0 + 1e-15
    assert worst(matrix_from_mrp(p), R) < 3e-15
    turning = np.abs(p).max(axis=-1) > 1e-300
    R, p = R[turning], p[turning]
    assert worst(matrix_from_mrp(mrp_shadow(p)), R) < 3e-15
    assert mrp_shadow(mrp_shadow(p)) == pytest.approx(p, rel=2e-15, abs=1e-300)


def test_parameters_agree_with_scipy():
    R = random_rotations(300)
    assert worst(mrp_from_matrix(R), Rotation.from_matrix(R).as_mrp()) < 2e-15
    p = np.random.default_rng(0).normal(scale=2.0, size=(300, 3))
    assert worst(matrix_from_mrp(p), Rotation.from_mrp(p).as_matrix()) < 2e-15


@pytest.mark.parametrize("angle", [*DISTANCES[1:], 1.0, 2.0, *(math.pi - d for d in DISTANCES)])
def test_parameters_are_the_tangent_of_a_quarter_of_the_angle(angle):
    p = mrp_from_matrix(matrix_from_natural(AXIS, angle))
    with mpmath.workdps(50):
        expected = float(mpmath.tan(mpmath.mpf(angle) / 4)) * AXIS
    assert min(worst(p, expected), worst(p, -expected) if math.pi - angle < 1e-15 else 1.0) < 5e-16
    if angle < 1e-8:
        assert p == pytest.approx(expected, rel=2e-15, abs=0.0)
    assert worst(matrix_from_mrp(expected), matrix_from_natural(AXIS, angle)) < 1e-15


@pytest.mark.parametrize("angle", [0.5, math.pi, 4.0, 6.0, 2 * math.pi - 1e-6, 2 * math.pi - 1e-12])
def test_past_half_a_turn_the_parameters_go_on_to_a_whole_one(angle):
    p = math.tan(angle / 4) * AXIS
    assert worst(matrix_from_mrp(p), matrix_from_natural(AXIS, angle)) < 1e-15
    other = math.tan((2 * math.pi - angle) / 4)
    assert worst(mrp_shadow(p) / other, -AXIS) < 1e-15 / min(other, 1.0)


def test_long_parameters_of_nearly_a_whole_turn_are_right():
    for length in (1e10, 1e150, 1e200, 1e307):
        R = matrix_from_mrp(length * AXIS)
        assert 0.5 * (R[2, 1] - R[1, 2]) == pytest.approx(-4.0 / length * AXIS[0], rel=1e-15, abs=0.0)
        assert worst(matrix_from_mrp([length * AXIS, 0.1 * AXIS])[0], R) == 0.0


def test_half_turns_have_parameters_of_length_one_and_a_positive_first():
    p = mrp_from_matrix(integer_rotations())
    half = np.abs(np.linalg.norm(p, axis=-1) - 1.0) < 1e-15
    assert half.sum() == 9
    for row in p[half]:
        assert row[np.nonzero(row)[0][0]] > 0.0


def test_the_identity_has_no_finite_shadow():
    assert mrp_from_matrix(np.eye(3)).tolist() == [0.0, 0.0, 0.0]
    assert worst(matrix_from_mrp(np.zeros(3)), np.eye(3)) == 0.0
    with pytest.raises(ZeroNorm, match=r"modified Rodrigues parameters must not be zero at index \[1\]"):
        mrp_shadow([AXIS, np.zeros(3)])
    with pytest.raises(BadArgument, match=r"at index \[1\] overflows"):
        mrp_shadow([AXIS, 1e-310 * AXIS])
