from __future__ import annotations

import math

import numpy as np
import pinocchio as pin
import pytest
from loops import for_all
from rotation_samples import (
    CONVENTIONS,
    DISTANCES,
    integer_rotations,
    many_angles,
    many_rotation_vectors,
    random_rotations,
    scipy_matrix,
    worst,
)
from scipy.spatial.transform import Rotation

from nao_kin import rotations
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.rotations import (
    euler_from_matrix,
    euler_from_quat,
    matrix_from_euler,
    matrix_from_rpy,
    quat_from_euler,
    rot_x,
    rot_y,
    rot_z,
    rpy_from_matrix,
)

TURN = {"x": rot_x, "y": rot_y, "z": rot_z}
ROUND_TRIP = 4e-15

each_convention = for_all(("sequence", "axes"), CONVENTIONS)


def product_of_turns(sequence, axes, triple):
    first, second, third = (TURN[axis](angle) for axis, angle in zip(sequence, triple, strict=True))
    return first @ second @ third if axes == "moving" else third @ second @ first


def scipy_sequence(sequence, axes):
    return sequence.upper() if axes == "moving" else sequence


def poles(sequence):
    return (0.0, math.pi) if sequence[0] == sequence[2] else (math.pi / 2, -math.pi / 2)


def beside_lock(sequence, rng):
    """Triples at every distance from both poles, on both sides, with random, zero and right outer angles."""
    rows = []
    for pole in poles(sequence):
        for distance in DISTANCES:
            for side in (-1.0, 1.0):
                outer = [rng.uniform(-math.pi, math.pi, 2) for _ in range(6)]
                outer += [np.zeros(2), np.array([math.pi / 2, -math.pi]), np.array([1e-9, 3.0])]
                rows += [(a, pole + side * distance, c) for a, c in outer]
    return np.array(rows)


@each_convention
def test_matrix_agrees_with_scipy(sequence, axes):
    triples = np.random.default_rng(1).uniform(-7.0, 7.0, (200, 3))
    expected = Rotation.from_euler(scipy_sequence(sequence, axes), triples).as_matrix()
    assert worst(matrix_from_euler(triples, sequence, axes=axes), expected) < 2e-15


@for_all("at_lock", ["first", "third"])
@each_convention
def test_both_triples_give_the_matrix_back_at_every_distance_from_lock(sequence, axes, at_lock):
    triples = beside_lock(sequence, np.random.default_rng(2))
    for R in (
        matrix_from_euler(triples, sequence, axes=axes),
        Rotation.from_euler(scipy_sequence(sequence, axes), triples).as_matrix(),
    ):
        found = euler_from_matrix(R, sequence, axes=axes, at_lock=at_lock)
        assert worst(matrix_from_euler(found.angles, sequence, axes=axes), R) <= ROUND_TRIP
        assert worst(matrix_from_euler(found.other, sequence, axes=axes), R) <= ROUND_TRIP


@each_convention
def test_both_triples_of_any_rotation_give_it_back(sequence, axes):
    R = scipy_matrix(many_rotation_vectors(500))
    found = euler_from_matrix(R, sequence, axes=axes)
    assert worst(product_of_turns(sequence, axes, found.angles.T), R) <= ROUND_TRIP
    assert worst(product_of_turns(sequence, axes, found.other.T), R) <= ROUND_TRIP


@for_all("at_lock", ["first", "third"])
@each_convention
def test_integer_rotations_come_back(sequence, axes, at_lock):
    R = integer_rotations()
    found = euler_from_matrix(R, sequence, axes=axes, at_lock=at_lock)
    for triple in (found.angles, found.other):
        assert worst(matrix_from_euler(triple, sequence, axes=axes), R) <= 4e-16
        assert worst(triple / (math.pi / 2), np.round(triple / (math.pi / 2))) == 0.0


@each_convention
def test_angles_agree_with_scipy_away_from_lock(sequence, axes):
    R = random_rotations(300, seed=3)
    expected = Rotation.from_matrix(R).as_euler(scipy_sequence(sequence, axes))
    found = euler_from_matrix(R, sequence, axes=axes)
    clear = np.abs(expected[:, 1:2] - np.array(poles(sequence))).min(axis=1) > 0.1
    assert clear.sum() > 200
    assert worst(found.angles[clear], expected[clear]) < 1e-13
    assert not found.locked.any()


@each_convention
def test_the_two_triples_keep_their_ranges_and_are_two(sequence, axes):
    found = euler_from_matrix(scipy_matrix(many_rotation_vectors(500, seed=1)), sequence, axes=axes)
    low, high = (0.0, math.pi) if sequence[0] == sequence[2] else (-math.pi / 2, math.pi / 2)
    assert low <= found.angles[:, 1].min()
    assert found.angles[:, 1].max() <= high
    assert np.abs(found.angles).max() <= math.pi
    assert np.abs(found.other).max() <= math.pi
    # The outer angles of the two triples are half a turn apart.
    assert worst(np.abs(found.angles - found.other)[:, [0, 2]], math.pi) < 1e-15


@for_all(("at_lock", "zero"), [("first", 0), ("third", 2)])
@each_convention
def test_at_lock_the_chosen_outer_angle_is_zero(sequence, axes, at_lock, zero):
    for pole in poles(sequence):
        R = matrix_from_euler([0.4, pole, -1.1], sequence, axes=axes)
        found = euler_from_matrix(R, sequence, axes=axes, at_lock=at_lock)
        assert found.locked
        assert found.angles[zero] == 0.0
        assert abs(found.angles[2 - zero]) > 0.1
        assert found.angles[1] == pytest.approx(pole, abs=1e-15)


@each_convention
def test_the_lock_mask_is_true_at_lock_and_false_beside_it(sequence, axes):
    for pole in poles(sequence):
        for distance, locked in [(0.0, True), (1e-16, True), (1e-14, False), (1e-12, False), (1e-3, False)]:
            R = matrix_from_euler([0.4, pole + distance, -1.1], sequence, axes=axes)
            assert bool(euler_from_matrix(R, sequence, axes=axes).locked) is locked


def test_identity_has_angles_zero_without_a_minus_sign():
    for sequence, axes in CONVENTIONS:
        found = euler_from_matrix(np.eye(3), sequence, axes=axes)
        assert not np.signbit(found.angles).any()
        assert (found.angles == 0.0).all()


def test_rpy_is_what_pinocchio_means_by_it():
    rng = np.random.default_rng(5)
    for rpy in rng.uniform([-3.1, -1.5, -3.1], [3.1, 1.5, 3.1], (100, 3)):
        R = matrix_from_rpy(rpy)
        assert worst(R, pin.rpy.rpyToMatrix(rpy)) < 1e-15
        assert worst(rpy_from_matrix(R), rpy) < 1e-13
        assert worst(pin.rpy.matrixToRpy(R), rpy) < 1e-13


def test_rpy_at_lock_keeps_yaw_at_zero():
    R = matrix_from_rpy([0.3, math.pi / 2, 0.1])
    assert worst(rpy_from_matrix(R), [0.2, math.pi / 2, 0.0]) < 1e-15


def test_the_fixed_axis_matrix_of_the_paper_has_both_its_solutions():
    s = math.sqrt(3.0)
    Q = [
        [s / 4, -s / 4 + 3 / 8, 1 / 4 + 3 * s / 8],
        [1 / 4, 3 / 4 + s / 8, -s / 4 + 3 / 8],
        [-s / 2, 1 / 4, s / 4],
    ]
    found = euler_from_matrix(Q, "xyz", axes="fixed")
    assert np.degrees(found.angles) == pytest.approx([30, 60, 30], abs=1e-12)
    assert np.degrees(found.other) == pytest.approx([-150, 120, -150], abs=1e-12)
    assert worst(matrix_from_rpy(np.radians([150, 120, 150])), Q) == pytest.approx(0.5, abs=1e-12)


@for_all("sequence", ["xyy", "ZYX", "xx", "", "xyzx", "abc", "x y z", None])
def test_a_malformed_sequence_is_refused_by_name(sequence):
    three = sorted({s for s, _ in CONVENTIONS})
    with pytest.raises(UnknownName, match="unknown sequence") as caught:
        euler_from_matrix(np.eye(3), sequence, axes="moving")
    assert caught.value.valid == tuple(three)
    with pytest.raises(UnknownName, match="unknown sequence") as caught:
        matrix_from_euler([0, 0, 0], sequence, axes="moving")
    assert caught.value.valid == (*three, "x", "y", "z", "xy", "xz", "yx", "yz", "zx", "zy")


@for_all("sequence", ["x", "zy"])
def test_the_angles_of_fewer_than_three_axes_are_another_functions(sequence):
    with pytest.raises(UnknownName, match="`nearest_euler` takes one or two axes"):
        euler_from_matrix(np.eye(3), sequence, axes="moving")


def test_an_upper_case_sequence_is_refused_with_the_advice_to_write_it_in_lower_case():
    with pytest.raises(UnknownName, match="nearest: zyx.*letter case carries no meaning"):
        matrix_from_euler([0, 0, 0], "ZYX", axes="moving")


def test_missing_axes_are_refused_with_both_choices():
    with pytest.raises(BadArgument, match=r"axes= must be given: 'moving' .* or 'fixed'"):
        matrix_from_euler([0, 0, 0], "zyx")
    with pytest.raises(BadArgument, match="axes="):
        euler_from_matrix(np.eye(3), "zyx")


@for_all("axes", ["intrinsic", "Moving", ""])
def test_unknown_axes_are_refused(axes):
    with pytest.raises(UnknownName, match="unknown axes"):
        matrix_from_euler([0, 0, 0], "zyx", axes=axes)


@for_all("at_lock", ["second", "", None])
def test_an_unknown_tie_break_is_refused(at_lock):
    with pytest.raises(UnknownName, match="at_lock"):
        euler_from_matrix(np.eye(3), "zyx", axes="moving", at_lock=at_lock)


@each_convention
def test_quaternions_and_three_angles_are_taken_for_each_other(sequence, axes):
    triples = np.concatenate([many_angles((200, 3)), beside_lock(sequence, np.random.default_rng(0))])
    q = quat_from_euler(triples, sequence, axes=axes)
    expected = Rotation.from_euler(scipy_sequence(sequence, axes), triples).as_quat(scalar_first=True)
    assert np.abs(np.abs(np.einsum("ni,ni->n", q, expected)) - 1.0).max() < 1e-14
    found = euler_from_quat(-2.0 * q, sequence, axes=axes)
    for angles in (found.angles, found.other):
        assert (
            worst(matrix_from_euler(angles, sequence, axes=axes), matrix_from_euler(triples, sequence, axes=axes))
            < 1e-14
        )


def test_quaternions_have_the_angles_of_their_matrices_at_lock():
    q = rotations.quat_from_matrix(matrix_from_euler([0.4, math.pi / 2, 0.3], "zyx", axes="moving"))
    R = rotations.matrix_from_quat(q)
    for at_lock in ("first", "third"):
        found = rotations.euler_from_quat(q, "zyx", axes="moving", at_lock=at_lock)
        assert np.array_equal(found.angles, euler_from_matrix(R, "zyx", axes="moving", at_lock=at_lock).angles)
    assert rotations.euler_from_quat(q, "zyx", axes="moving", at_lock="first").angles[0] != found.angles[0]
