from __future__ import annotations

import math

import numpy as np
import pytest
from loops import for_all
from rotation_samples import (
    DISTANCES,
    integer_rotations,
    many_angles,
    many_axes,
    many_rotations,
    random_rotations,
    worst,
)

from nao_kin.errors import BadArgument, NotARotation, WrongShape, ZeroNorm
from nao_kin.rotations import (
    davenport_angles,
    euler_from_matrix,
    matrix_from_davenport,
    matrix_from_euler,
    matrix_from_natural,
)

X, Y, Z = np.eye(3)
HIPS = {
    "left": (np.array([0.0, 1.0, -1.0]) / math.sqrt(2.0), X, Y),
    "right": (np.array([0.0, 1.0, 1.0]) / math.sqrt(2.0), X, Y),
}
ROUND_TRIP = 4e-15


def perpendicular_axes(count):
    """Three unit axes with a1 ⟂ a2 ⟂ a3: any a2, and two directions normal to it."""
    a2 = many_axes(count, seed=2)
    side = np.cross(a2, np.eye(3)[np.abs(a2).argmin(axis=-1)])
    side /= np.linalg.norm(side, axis=-1, keepdims=True)
    up = np.cross(a2, side)
    a1, a3 = (np.cos(t) * side + np.sin(t) * up for t in many_angles((2, count, 1), seed=3))
    return a1, a2, a3


def test_both_triples_about_any_perpendicular_axes_give_the_matrix_back():
    R, axes_ = many_rotations(1000), perpendicular_axes(1000)
    found = davenport_angles(R, *axes_)
    assert worst(matrix_from_davenport(found.angles, *axes_), R) <= ROUND_TRIP
    assert worst(matrix_from_davenport(found.other, *axes_), R) <= ROUND_TRIP
    assert np.abs([found.angles, found.other]).max() <= math.pi


@for_all("at_lock", ["first", "third"])
@for_all("side", HIPS)
def test_the_hip_comes_back_at_every_distance_from_lock(side, at_lock):
    axes_ = HIPS[side]
    rng = np.random.default_rng(0)
    lock = -math.pi / 4 if side == "left" else math.pi / 4
    triples = np.array(
        [
            (a, pole + sign * distance, c)
            for pole in (lock, lock + math.pi)
            for distance in DISTANCES
            for sign in (-1, 1)
            for a, c in [*rng.uniform(-math.pi, math.pi, (5, 2)), (0.0, 0.0)]
        ]
    )
    R = matrix_from_davenport(triples, *axes_)
    found = davenport_angles(R, *axes_, at_lock=at_lock)
    assert worst(matrix_from_davenport(found.angles, *axes_), R) <= ROUND_TRIP
    assert worst(matrix_from_davenport(found.other, *axes_), R) <= ROUND_TRIP
    assert found.locked.any()
    assert not found.locked.all()
    assert (found.angles[found.locked][:, 0 if at_lock == "first" else 2] == 0.0).all()


@for_all("side", HIPS)
def test_the_principal_triple_of_the_hip_is_the_one_within_its_joints_reach(side):
    rng = np.random.default_rng(1)
    triples = rng.uniform([-1.1, -0.37, -1.5], [0.7, 0.37, 0.4], (200, 3))
    found = davenport_angles(matrix_from_davenport(triples, *HIPS[side]), *HIPS[side])
    assert worst(found.angles, triples) < 1e-14
    assert worst(found.other, triples) > 1.0


@for_all("sequence", [a + b + c for a in "xyz" for b in "xyz" for c in "xyz" if a != b != c])
def test_coordinate_axes_give_the_moving_euler_angles(sequence):
    axes_ = [np.eye(3)["xyz".index(name)] for name in sequence]
    R = np.concatenate([random_rotations(200, seed=3), integer_rotations()])
    ours, euler = davenport_angles(R, *axes_), euler_from_matrix(R, sequence, axes="moving")
    assert worst(np.exp(1j * ours.angles), np.exp(1j * euler.angles)) < 1e-13
    assert worst(np.exp(1j * ours.other), np.exp(1j * euler.other)) < 1e-13
    assert (ours.locked == euler.locked).all()
    triples = np.random.default_rng(4).uniform(-3, 3, (20, 3))
    expected = matrix_from_euler(triples, sequence, axes="moving")
    assert worst(matrix_from_davenport(triples, *axes_), expected) < 1e-15


def test_the_length_of_the_axes_does_not_matter():
    R = random_rotations(10)
    scaled = davenport_angles(R, 7.0 * X, 1e-3 * Y, 1e4 * Z)
    assert worst(scaled.angles, davenport_angles(R, X, Y, Z).angles) == 0.0


@for_all("opposite", [1.0, -1.0])
def test_the_length_of_parallel_outer_axes_does_not_choose_the_branch(opposite):
    rng = np.random.default_rng(5)
    a1 = np.array([-0.2694581835180821, 0.7849222527916708, -1.0827223760427476])
    a2 = np.array([-0.7819084623568421, -0.2571922406188707, 0.008142180518343508])
    random = rng.normal(size=(2, 300, 3))
    a, b = np.vstack([a1, random[0]]), np.vstack([a2, np.cross(random[0], random[1])])
    triple = [0.1, 0.5 * opposite, 0.2]  # β from 0 to π where a3 is along a1, from −π to 0 where it is opposite
    R = matrix_from_davenport(triple, a, b, opposite * a)
    for scale in (1.0, 3.0, 0.1, *rng.uniform(0.1, 10.0, 5)):
        for outer in ((scale * a, opposite * a), (a, scale * opposite * a)):
            found = davenport_angles(R, outer[0], b, outer[1])
            assert worst(found.angles, triple) < 1e-14
            assert worst(matrix_from_davenport(found.other, a, b, opposite * a), R) <= ROUND_TRIP


def test_outer_axes_that_are_nearly_parallel_keep_their_angle():
    R = random_rotations(50)
    for tilt in (1e-15, -1e-15, 1e-12, -1e-9, 1e-5):
        for a3 in ([math.cos(tilt), 0.0, -math.sin(tilt)], [-math.cos(tilt), 0.0, math.sin(tilt)]):
            found = davenport_angles(R, X, Y, a3)
            assert worst(matrix_from_davenport(found.angles, X, Y, a3), R) <= ROUND_TRIP
            assert worst(matrix_from_davenport(found.other, X, Y, a3), R) <= ROUND_TRIP


@for_all(
    ("axes_", "message"),
    [
        ((X, X, Z), "axes a1 and a2 must be perpendicular.*reach every rotation; the angle between them is 0°"),
        ((X, Y, Y), "axes a2 and a3 must be perpendicular.*is 0°"),
        (([1.0, 1.0, 0.0], Y, Z), "axes a1 and a2.*is 45°"),
        ((X, Y, [0.0, 1e-6, 1.0]), "axes a2 and a3.*89.99994"),
    ],
)
def test_axes_that_cannot_reach_every_rotation_are_refused(axes_, message):
    with pytest.raises(BadArgument, match=message):
        davenport_angles(np.eye(3), *axes_)


@for_all("scale", [1.0, 3.0])
@for_all("tilt", [0.0, 0.99e-9, -0.99e-9, 1.01e-9, -1.01e-9, 1e-8, 1e-4, 1e-2])
def test_axes_count_as_perpendicular_to_1e_9(tilt, scale):
    fine = abs(tilt) < 1e-9
    for turn in [np.eye(3), *random_rotations(5)]:
        leaning = scale * (turn @ [tilt, math.sqrt(1.0 - tilt * tilt), 0.0])
        x, z = turn @ X, turn @ Z
        for axes_ in ((x, leaning, z), (z, leaning, x)):
            if fine:
                davenport_angles(np.eye(3), *axes_)
            else:
                with pytest.raises(BadArgument, match="must be perpendicular"):
                    davenport_angles(np.eye(3), *axes_)


def test_bad_axes_are_refused():
    with pytest.raises(ZeroNorm, match="axis a2"):
        davenport_angles(np.eye(3), X, [0, 0, 0], Z)
    with pytest.raises(WrongShape, match="R and the axes"):
        davenport_angles([np.eye(3)] * 3, X, Y, [Z, Z])
    with pytest.raises(BadArgument, match="a2 is missing"):
        matrix_from_davenport([0, 0], X, a3=Z)
    with pytest.raises(WrongShape, match="axis a1"):
        matrix_from_davenport([0, 0, 0], [1, 0], Y, Z)


def test_what_is_no_rotation_is_refused_with_its_own_defect():
    with pytest.raises(NotARotation, match=r"at index \[1\]: det R − 1 = 0.331"):
        davenport_angles([np.eye(3), 1.1 * np.eye(3)], *HIPS["left"])


def test_composition_takes_axes_that_are_not_perpendicular():
    R = matrix_from_davenport([0.3, 0.4, 0.5], X, [1.0, 1.0, 0.0], X)
    expected = matrix_from_natural(X, 0.3) @ matrix_from_natural([1, 1, 0], 0.4) @ matrix_from_natural(X, 0.5)
    assert worst(R, expected) < 1e-15
