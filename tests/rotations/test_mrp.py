from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from rotation_samples import DISTANCES, integer_rotations, many_rotations, random_rotations, worst
from scipy.spatial.transform import Rotation

from nao_kin.rotations import matrix_from_mrp, matrix_from_natural, mrp_from_matrix

AXIS = np.array([0.48, -0.6, 0.64])


def test_the_short_triple_of_a_rotation_and_the_other_one_both_give_it_back():
    R = many_rotations(600)
    p = mrp_from_matrix(R)
    assert np.linalg.norm(p, axis=-1).max() <= 1.0 + 1e-15
    assert worst(matrix_from_mrp(p), R) < 3e-15
    turning = np.abs(p).max(axis=-1) > 1e-30
    R, p = R[turning], p[turning]
    assert worst(matrix_from_mrp(-p / np.square(p).sum(axis=-1, keepdims=True)), R) < 3e-15


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
    assert worst(matrix_from_mrp(math.tan(angle / 4) * AXIS), matrix_from_natural(AXIS, angle)) < 1e-15


def test_half_turns_have_parameters_of_length_one_and_a_positive_first():
    p = mrp_from_matrix(integer_rotations())
    half = np.abs(np.linalg.norm(p, axis=-1) - 1.0) < 1e-15
    assert half.sum() == 9
    for row in p[half]:
        assert row[np.nonzero(row)[0][0]] > 0.0
    assert mrp_from_matrix(np.eye(3)).tolist() == [0.0, 0.0, 0.0]
