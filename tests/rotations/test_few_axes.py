from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from loops import for_all
from rotation_samples import (
    DISTANCES,
    many_angles,
    many_axes,
    many_rotation_vectors,
    random_rotations,
    scipy_matrix,
    worst,
)
from scipy.spatial.transform import Rotation

from nao_kin.errors import BadArgument, UnknownName, WrongShape, ZeroNorm
from nao_kin.rotations import (
    angle_between,
    davenport_angles,
    linear_invariants,
    matrix_from_davenport,
    matrix_from_euler,
    matrix_from_natural,
    nearest_davenport,
    nearest_euler,
    rot_x,
    rot_y,
    rot_z,
)

X, Y, Z = np.eye(3)
TURN = {"x": rot_x, "y": rot_y, "z": rot_z}
ONE_OR_TWO = [*"xyz", *(a + b for a in "xyz" for b in "xyz" if a != b)]
each_sequence = for_all(("sequence", "axes_"), list(itertools.product(ONE_OR_TWO, ("moving", "fixed"))))


def wrapped(angle):
    return np.angle(np.exp(1j * np.asarray(angle)))


@each_sequence
def test_one_or_two_turns_are_composed_and_found_again(sequence, axes_):
    given_ = many_angles((500, len(sequence)))
    R = matrix_from_euler(given_, sequence, axes=axes_)
    factors = [TURN[name](angle) for name, angle in zip(sequence, given_.T, strict=True)]
    expected = factors[0] if len(factors) == 1 else factors[0] @ factors[1]
    if axes_ == "fixed":
        expected = factors[-1] @ factors[0] if len(factors) == 2 else factors[0]
    assert worst(R, expected) < 1e-15
    found = nearest_euler(R, sequence, axes=axes_)
    assert worst(wrapped(found.angles - given_), 0.0) < 4e-15
    assert found.residual.max() < 1.5e-15
    assert np.abs(found.angles).max() <= math.pi


@each_sequence
def test_no_other_angles_come_nearer(sequence, axes_):
    R = random_rotations(60, seed=1)
    found = nearest_euler(R, sequence, axes=axes_)
    own = angle_between(matrix_from_euler(found.angles, sequence, axes=axes_), R)
    assert worst(own, found.residual) < 2e-15
    grid = np.linspace(-math.pi, math.pi, 25)
    others = np.stack(np.meshgrid(*[grid] * len(sequence)), axis=-1).reshape(-1, 1, len(sequence))
    others = np.concatenate([others + 0 * found.angles, found.angles + 1e-3 * np.sign(others[:60])])
    apart = angle_between(matrix_from_euler(others, sequence, axes=axes_), R)
    assert (apart >= found.residual - 1e-14).all()
    assert found.residual.max() <= (math.pi if len(sequence) == 1 else math.pi / 2) + 1e-15


def test_two_arbitrary_axes_come_as_near_as_any():
    R = scipy_matrix(many_rotation_vectors(500))
    a1, a2 = many_axes(500, seed=2), many_axes(500, seed=3)
    apart = np.linalg.norm(np.cross(a1, a2), axis=-1) >= 1e-3
    R, a1, a2 = R[apart], a1[apart], a2[apart]
    found = nearest_davenport(R, 3.0 * a1, 1e-6 * a2)
    assert worst(angle_between(matrix_from_davenport(found.angles, a1, a2), R), found.residual) < 3e-15
    steps = np.random.default_rng(0).normal(size=(40, 1, 2)) * np.repeat([1e-3, 0.1, 1, 3], 10)[:, None, None]
    others = matrix_from_davenport(found.angles + steps, a1, a2)
    assert (angle_between(others, R) >= found.residual - 1e-14).all()


def test_one_axis_gives_the_twist_and_leaves_a_swing_normal_to_it():
    R, a1 = scipy_matrix(many_rotation_vectors(500)), many_axes(500, seed=2)
    found = nearest_davenport(R, a1)
    swing = matrix_from_davenport(-found.angles, a1) @ R
    assert worst(angle_between(swing, np.eye(3)), found.residual) < 3e-15
    # The axis of the swing is normal to a1: what is antisymmetric in it has nothing along a1.
    assert np.abs((linear_invariants(swing)[0] * a1).sum(axis=-1)).max() < 2e-15


@for_all("distance", DISTANCES)
def test_a_rotation_beside_such_turns_leaves_its_distance(distance):
    for tilt, sequence in ((Y, "z"), (X, "z")):
        R = rot_z(0.7) @ matrix_from_natural(tilt, distance)
        assert abs(nearest_euler(R, sequence, axes="moving").residual - distance) < 1e-15
        turned_over = rot_z(0.7) @ matrix_from_natural(tilt, math.pi - distance)
        assert abs(nearest_euler(turned_over, sequence, axes="moving").residual - (math.pi - distance)) < 1e-15
    # At right angles to both families of neighbours the residual is the distance itself.
    R = rot_z(math.pi / 2) @ rot_y(distance)
    assert nearest_euler(R, "zy", axes="moving").residual < 1e-15


def test_angles_of_half_turns_and_right_angles_come_back():
    quarters = np.array(list(itertools.product(np.arange(-2, 3) * math.pi / 2, repeat=2)))
    for sequence in ("xy", "zx", "yz"):
        for axes_ in ("moving", "fixed"):
            R = matrix_from_euler(quarters, sequence, axes=axes_)
            found = nearest_euler(R, sequence, axes=axes_)
            assert found.residual.max() < 1e-15
            assert worst(matrix_from_euler(found.angles, sequence, axes=axes_), R) < 1e-15


def test_axes_in_batches_are_taken_apart_as_each_alone():
    rng = np.random.default_rng(2)
    R = random_rotations(4, seed=3)
    a1, a2 = rng.normal(size=(2, 5, 1, 3))
    b2 = np.array([1.0, -1.0, 1.0, -1.0, -1.0])[:, None, None] * np.cross(a1, a2)
    found, near = davenport_angles(R, a1, b2, a2), nearest_davenport(R, a1, a2)
    assert (found.angles.shape, near.angles.shape, near.residual.shape) == ((5, 4, 3), (5, 4, 2), (5, 4))
    assert worst(matrix_from_davenport(found.angles, a1, b2, a2), R) < 4e-15
    assert worst(matrix_from_davenport(found.other, a1, b2, a2), R) < 4e-15
    for i, j in itertools.product(range(5), range(4)):
        alone = davenport_angles(R[j], a1[i, 0], b2[i, 0], a2[i, 0])
        assert worst(found.angles[i, j], alone.angles) < 1e-14
        assert worst(found.other[i, j], alone.other) < 1e-14
        assert worst(near.angles[i, j], nearest_davenport(R[j], a1[i, 0], a2[i, 0]).angles) < 1e-14
    assert davenport_angles(R[:0], X, Y, Z).angles.shape == (0, 3)
    assert davenport_angles(R[0], np.zeros((0, 3)), Y, Z).angles.shape == (0, 3)


def test_one_two_and_three_arbitrary_axes_compose_as_scipy_does():
    rng = np.random.default_rng(4)
    a1 = rng.normal(size=3)
    a2 = np.cross(a1, rng.normal(size=3))
    a3 = np.cross(a2, rng.normal(size=3))
    for count in (1, 2, 3):
        chosen = [a1, a2, a3][:count]
        values = rng.uniform(-3, 3, (20, count))
        units = np.array([a / np.linalg.norm(a) for a in chosen])
        expected = Rotation.from_davenport(units, "intrinsic", values).as_matrix()
        assert worst(matrix_from_davenport(values, *chosen), expected) < 3e-15


def test_each_of_many_leaning_axes_is_named():
    with pytest.raises(BadArgument, match=r"axes a2 and a3 at index \[1\] must be perpendicular.*is 45°"):
        davenport_angles(np.eye(3), X, [Y, Y, Y], [Z, [0, 1, 1], Z])
    with pytest.raises(BadArgument, match=r"axes a1 and a2 at index \[1\] must not be parallel"):
        nearest_davenport(np.eye(3), X, [Y, -2.0 * X])
    with pytest.raises(ZeroNorm, match="axis a2"):
        nearest_davenport(np.eye(3), X, [Y, 0 * X])
    with pytest.raises(WrongShape, match="R and the axes"):
        nearest_davenport(random_rotations(3), [X, Y])
    with pytest.raises(WrongShape, match="angles and axes"):
        matrix_from_davenport(np.ones((3, 1)), [X, Y])
    with pytest.raises(WrongShape, match="angles"):
        matrix_from_davenport([0.1, 0.2, 0.3], X, Y)


@for_all("sequence", ["xx", "X", "ZY", "", "w", None])
def test_other_sequences_are_refused(sequence):
    with pytest.raises(UnknownName, match="unknown sequence"):
        nearest_euler(np.eye(3), sequence, axes="moving")


def test_three_axes_and_missing_axes_are_said():
    with pytest.raises(UnknownName, match="`euler_from_matrix` takes three axes"):
        nearest_euler(np.eye(3), "zyx", axes="moving")
    with pytest.raises(BadArgument, match="axes= must be given"):
        nearest_euler(np.eye(3), "z")
    with pytest.raises(UnknownName, match="unknown axes"):
        nearest_euler(np.eye(3), "z", axes="intrinsic")
    with pytest.raises(UnknownName, match="letter case carries no meaning"):
        nearest_euler(np.eye(3), "ZY", axes="moving")
    with pytest.raises(WrongShape, match=r"angles must have shape \(..., 2\)"):
        matrix_from_euler([0.1, 0.2, 0.3], "zy", axes="moving")
