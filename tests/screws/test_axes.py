from __future__ import annotations

import math
import pickle
from functools import partial

import numpy as np
import pytest
import scipy.spatial.transform
from hypothesis import given
from rotation_samples import PROPERTY, integer_rotations
from screw_samples import ANGLES, EPS, length, long_twists, random_twists, twists

from nao_kin import rotations, screws
from nao_kin.errors import BadArgument, WrongShape, ZeroNorm
from nao_kin.screws import Screw, lines
from nao_kin.screws.lines import PluckerLine

assert_near = partial(np.testing.assert_allclose, rtol=0)
UPRIGHT = PluckerLine.from_point_direction([1, 0, 0], [0, 0, 1])
MANY = screws.exp(random_twists(60, 1))
OTHERS = screws.exp(random_twists(60, 2))


# --- the screw of a motion


@pytest.mark.parametrize("s", [1, -1])
def test_points_of_the_axis_slide_along_it_and_all_others_turn_about_it(s) -> None:
    twist = random_twists(60, 3)
    screw = Screw.from_twist(s * twist)
    T, e = screws.exp(s * twist), screw.axis.direction
    on_axis = screw.axis.point + 0.7 * e
    assert_near(screws.transform_point(T, on_axis), on_axis + screw.slide[:, None] * e, atol=1e-12)
    p = np.array([0.3, 2.0, -1.0])
    arm, moved = (x - screw.axis.closest_point(x) for x in (np.tile(p, (60, 1)), screws.transform_point(T, p)))
    assert_near(
        np.einsum("ni,ni->n", np.cross(arm, moved), e), np.sum(arm**2, axis=1) * np.sin(screw.angle), atol=1e-11
    )
    assert_near(screw.pitch * screw.angle, screw.slide, atol=1e-14)
    assert (screw.angle >= 0).all()


@PROPERTY
@given((twists | long_twists).filter(lambda twist: not 0.0 < length(twist[3:]) < 1e-200))
def test_the_screw_of_a_twist_gives_it_back(twist) -> None:
    screw = Screw.from_twist(twist)
    assert_near(screw.twist, twist, atol=8 * EPS * (length(twist[:3]) + length(twist[3:])))
    assert_near(screw.angle, 0.0 if np.isinf(screw.pitch) else length(twist[3:]), atol=4 * EPS * length(twist[3:]))


@pytest.mark.parametrize("angle", [a for a in ANGLES if a > 1e-12])
def test_the_screw_of_a_displacement_gives_it_back_however_far_away_its_axis_is(angle) -> None:
    T = screws.exp(random_twists(10, 4, angle))
    screw = Screw.from_pose(T)
    assert_near(screw.angle, angle, atol=min(6 * EPS, 1e-14 * angle))
    assert_near(screw.pose, T, atol=20 * EPS * (1 + np.abs(T[:, :3, 3]).max()))
    if angle > 1e-3:
        assert_near(screw.axis.transformed(T).coordinates, screw.axis.coordinates, atol=1e-11 / angle)


def test_a_screw_with_a_known_axis_pitch_and_angle_is_found_again() -> None:
    for angle in (1e-6, 0.5, 3.0):
        for slide in (-0.4, 0.0, 0.3):
            found = Screw.from_pose(Screw(UPRIGHT, angle, slide).pose)
            assert_near(found.axis.coordinates, UPRIGHT.coordinates, atol=4e-16 / min(angle, 1.0))
            assert_near([found.angle, found.slide], [angle, slide], atol=1e-15)
            assert_near(found.pitch, slide / angle, atol=1e-15 / min(angle, 1.0) ** 2)
    # Turned the other way, the axis points the other way.
    back = Screw.from_pose(Screw(UPRIGHT, -0.5, 0.3).pose)
    assert_near(back.axis.coordinates, -UPRIGHT.coordinates, atol=1e-15)
    assert_near([back.angle, back.slide], [0.5, -0.3], atol=1e-15)


def test_a_translation_has_infinite_pitch_and_the_line_through_the_origin_along_it() -> None:
    T = screws.pose(np.eye(3), [[0, 3, 4], [0, 0, -1e-20], [0, 0, 0]])
    screw = Screw.from_pose(T)
    np.testing.assert_array_equal(screw.angle, 0)
    np.testing.assert_array_equal(screw.slide, [5, 1e-20, 0])
    np.testing.assert_array_equal(screw.pitch, [np.inf, np.inf, 0])
    assert_near(screw.axis.coordinates[:2], [[0, 0.6, 0.8, 0, 0, 0], [0, 0, -1, 0, 0, 0]], atol=EPS)
    # The identity has no line; it is given one.
    np.testing.assert_array_equal(screw.axis.coordinates[2], [0, 0, 1, 0, 0, 0])
    np.testing.assert_array_equal(screw.twist[:, :3], T[:, :3, 3])
    assert Screw(UPRIGHT, 0.0, -2.0).pitch == -np.inf


def test_a_slide_far_longer_than_the_way_round_leaves_the_axis_a_line() -> None:
    e = np.array([0.36, 0.48, 0.8])
    across = np.array([0.8, -0.6, 0.0])
    screw = Screw.from_twist(np.r_[1e3 * e + 1e-9 * across, 1e-9 * e])
    assert_near(screw.axis.direction, e, atol=4 * EPS)
    assert abs(screw.axis.direction @ screw.axis.moment) < 1e-9


@pytest.mark.parametrize("shape", [(), (4, 3)])
def test_axis_angle_and_slide_broadcast_and_are_copies(shape) -> None:
    angle = np.full(shape, 0.5)
    screw = Screw(PluckerLine.through(np.zeros(3), np.eye(3), origin=[1, 2, 3]), angle, 0.1)
    assert screw.pitch.shape == screw.axis.batch_shape == screw.slide.shape == (*shape[:-1], 3)
    assert screw.pose.shape == (*shape[:-1], 3, 4, 4)
    angle[...] = 7
    np.testing.assert_array_equal(screw.angle, 0.5)
    with pytest.raises(ValueError, match="read-only"):
        screw.angle[...] = 1


def test_screws_are_picked_by_index_and_their_copies_are_as_immutable() -> None:
    batch = Screw.from_twist(random_twists(6, 8).reshape(2, 3, 6))
    np.testing.assert_array_equal(batch[1, 2].twist, batch.twist[1, 2])
    np.testing.assert_array_equal(batch[:, 1:].pitch, batch.pitch[:, 1:])
    with pytest.raises(IndexError):
        batch[2]
    again = pickle.loads(pickle.dumps(batch))
    np.testing.assert_array_equal(again.twist, batch.twist)
    assert not again.slide.flags.writeable


def test_where_the_moment_of_the_axis_is_taken_does_not_matter() -> None:
    elsewhere = UPRIGHT.transfer_to([3, -2, 7])
    np.testing.assert_array_equal(Screw(elsewhere, 0.5, 0.3).twist, Screw(UPRIGHT, 0.5, 0.3).twist)


# --- dual quaternions


def naive_power(q: np.ndarray, s: float) -> np.ndarray:
    """q^s of a unit dual quaternion by its dual angle and dual axis (Kavan et al.), fine away from 0 and π."""
    (w, *vector), (dw, *dvector) = q[:4], q[4:]
    vector, dvector, sine = np.array(vector), np.array(dvector), np.linalg.norm(vector)
    half, pitch = math.atan2(sine, w), -dw / sine
    axis = vector / sine
    moment = (dvector - pitch * w * axis) / sine
    half, pitch = s * half, s * pitch
    real = [math.cos(half), *(math.sin(half) * axis)]
    return np.r_[real, -pitch * math.sin(half), math.sin(half) * moment + pitch * math.cos(half) * axis]


def test_dual_quaternions_give_their_pose_back_with_either_sign_and_at_any_length() -> None:
    T = np.concatenate([MANY, screws.pose(integer_rotations(), [1, 2, 3]), screws.exp(random_twists(20, 5, math.pi))])
    q = screws.dual_quat_from_pose(T)
    np.testing.assert_array_equal(q[:, :4], rotations.quat_from_matrix(T[:, :3, :3]))
    assert_near(np.einsum("ni,ni->n", q[:, :4], q[:, 4:]), 0, atol=1e-15)
    for scale in (1.0, -1.0, 7.0):
        assert_near(screws.pose_from_dual_quat(scale * q), T, atol=1e-14)


@pytest.mark.skipif(not hasattr(scipy.spatial.transform, "RigidTransform"), reason="scipy before 1.16")
def test_scipy_has_the_same_dual_quaternions() -> None:
    theirs = scipy.spatial.transform.RigidTransform.from_matrix(MANY).as_dual_quat(scalar_first=True)
    ours = screws.dual_quat_from_pose(MANY)
    sign = np.sign(np.einsum("ni,ni->n", ours[:, :4], theirs[:, :4]))[:, None]
    assert_near(ours, sign * theirs, atol=1e-14)


def test_dual_quaternions_multiply_as_the_motions_do() -> None:
    p, q = screws.dual_quat_from_pose(MANY), screws.dual_quat_from_pose(OTHERS)
    product = screws.dual_quat_multiply(p, q)
    assert_near(screws.pose_from_dual_quat(product), MANY @ OTHERS, atol=1e-14)


def test_the_power_of_a_dual_quaternion_is_the_way_along_the_screw() -> None:
    T = screws.exp(random_twists(60, 7, 2.0))
    for s in (0.0, 0.25, 0.5, 1.0, 1.4):
        power = [naive_power(q, s) for q in screws.dual_quat_from_pose(T)]
        assert_near(screws.pose_from_dual_quat(power), screws.sclerp(np.eye(4), T, s), atol=1e-14)


def test_eight_numbers_that_are_no_rigid_motion_are_refused() -> None:
    with pytest.raises(ZeroNorm, match=r"dual quaternion must not be zero at index \[1\]"):
        screws.pose_from_dual_quat([[1, 0, 0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 1, 0, 0, 0]])
    with pytest.raises(BadArgument, match=r"r·d of a unit dual quaternion must be zero, got 0.1"):
        screws.pose_from_dual_quat([2, 0, 0, 0, 0.2, 0, 0, 0])
    rounded = [2, 0, 0, 0, 1e-7, 0, 3, 0]
    np.testing.assert_array_equal(screws.pose_from_dual_quat(rounded)[:3, 3], [0, 3, 0])
    # Too far from zero begins at 1e-6.
    screws.pose_from_dual_quat([1, 0, 0, 0, 0.9e-6, 0, 1, 0])
    with pytest.raises(BadArgument, match=r"r·d of a unit dual quaternion must be zero, got 1.1e-06"):
        screws.pose_from_dual_quat([1, 0, 0, 0, 1.1e-6, 0, 1, 0])
    # How far from zero is too far grows with the shift, not with its square.
    screws.pose_from_dual_quat([1, 0, 0, 0, 5e-4, 1e3, 0, 0])
    with pytest.raises(BadArgument, match=r"r·d of a unit dual quaternion must be zero, got 0.01"):
        screws.pose_from_dual_quat([1, 0, 0, 0, 0.01, 1e3, 0, 0])


def test_a_screw_needs_numbers_that_fit_its_line() -> None:
    with pytest.raises(WrongShape, match="batch axes of axis, angle and slide"):
        Screw(UPRIGHT, np.zeros(2), np.zeros(3))
    assert lines.distance(Screw(UPRIGHT, 1, 2).axis, UPRIGHT) == 0
