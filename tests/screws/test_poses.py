from __future__ import annotations

import math
from functools import partial

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, strategies as st
from rotation_samples import PROPERTY
from screw_samples import EPS, EXACT, as_array, exact_ad, exact_pose, power_series, random_twists, twists

import nao_kin as nk
from nao_kin import rotations, screws
from nao_kin.errors import BadArgument, NotARotation, UnknownName
from nao_kin.screws import lines

assert_near = partial(np.testing.assert_allclose, rtol=0)
MANY = screws.exp(random_twists(60, 1))
OTHERS = screws.exp(random_twists(60, 2))


# --- poses


def test_a_pose_holds_its_rotation_and_its_point_and_shares_nothing_with_them() -> None:
    R, p = rotations.rot_x(0.3), np.array([1.0, 2.0, 3.0])
    T = screws.pose(R, p)
    np.testing.assert_array_equal(T[:3, :3], R)
    np.testing.assert_array_equal(T[:, 3], [1, 2, 3, 1])
    R[:], p[:] = 0.0, 0.0
    assert T[0, 0] == 1.0
    assert T[0, 3] == 1.0


def test_a_pose_of_what_is_no_rotation_is_refused_with_its_index() -> None:
    with pytest.raises(NotARotation, match=r"at index \[1\]"):
        screws.pose([np.eye(3), 1.01 * np.eye(3)], [0, 0, 0])


def test_inverses_and_points_are_those_of_pinocchio() -> None:
    for T, S in zip(MANY, OTHERS, strict=True):
        A = pin.SE3(T)
        assert_near(screws.inverse(T), A.inverse().homogeneous, atol=1e-15)
        assert_near(screws.transform_point(T, S[:3, 3]), A.act(S[:3, 3]), atol=1e-14)
    assert_near(MANY @ screws.inverse(MANY), np.tile(np.eye(4), (60, 1, 1)), atol=1e-14)


def test_the_nearest_pose_repairs_what_rounding_and_typing_did() -> None:
    rng = np.random.default_rng(0)
    for defect in (1e-12, 1e-7, 1e-3):
        M = MANY + defect * rng.normal(size=MANY.shape) * [[1], [1], [1], [1e-2]]
        found = screws.nearest_pose(M)
        np.testing.assert_array_equal(found[:, :3, 3], M[:, :3, 3])
        np.testing.assert_array_equal(found[:, :3, :3], rotations.nearest_rotation(M[:, :3, :3]))
        np.testing.assert_array_equal(found[:, 3], np.tile([0, 0, 0, 1], (60, 1)))
        # No pose beside it is nearer.
        near = np.linalg.norm(found - M, axis=(-2, -1))
        for step in 1e-2 * np.vstack([np.eye(6), -np.eye(6)]):
            beside = found @ screws.exp(step)
            assert (np.linalg.norm(beside - M, axis=(-2, -1)) > near).all()


def test_a_transposed_pose_is_no_pose_with_an_odd_last_row() -> None:
    T = screws.pose(np.eye(3), [0.1, 0, 0])
    with pytest.raises(BadArgument, match=r"the last row of the matrix at index \[1\] must be \(0, 0, 0, 1\) to 1e-03"):
        screws.nearest_pose(np.stack([T, T.T]))


# --- twists and wrenches in other frames


def test_twists_and_wrenches_are_carried_over_as_pinocchio_does() -> None:
    twist, other, wrench = (random_twists(60, seed) for seed in (4, 5, 6))
    for i, T in enumerate(MANY):
        pose, motion, force = pin.SE3(T), pin.Motion(twist[i]), pin.Force(wrench[i])
        assert_near(screws.adjoint(T), pose.toActionMatrix(), atol=1e-15)
        assert_near(screws.transform_twist(T, twist[i]), pose.act(motion).vector, atol=1e-14)
        assert_near(screws.transform_wrench(T, wrench[i]), pose.act(force).vector, atol=1e-14)
        assert_near(screws.bracket(twist[i], other[i]), motion.cross(pin.Motion(other[i])).vector, atol=1e-14)
        assert_near(screws.dual_bracket(twist[i], wrench[i]), motion.cross(force).vector, atol=1e-14)


@PROPERTY
@given(twists, twists, twists)
def test_matrices_do_what_the_functions_do_and_power_stays(by, twist, wrench) -> None:
    T = screws.exp(by)
    size = (1 + np.abs(T).max()) * (1 + np.abs(twist).max()) * (1 + np.abs(wrench).max())
    moved, force = screws.transform_twist(T, twist), screws.transform_wrench(T, wrench)
    assert_near(screws.adjoint(T) @ twist, moved, atol=10 * EPS * size)
    assert_near(lines.motion_matrix(T) @ wrench, force, atol=10 * EPS * size)
    assert_near(moved @ force, twist @ wrench, atol=40 * EPS * size**2)
    assert_near(screws.dual_bracket(by, wrench) @ twist, -wrench @ screws.bracket(by, twist), atol=40 * EPS * size**2)


def test_the_adjoint_of_an_exponential_is_the_exponential_of_the_bracket() -> None:
    for twist in random_twists(10, 7):
        assert_near(screws.adjoint(screws.exp(twist)), as_array(power_series(exact_ad(twist))), atol=1e-14)
        for other in np.eye(6):
            assert_near(screws.bracket(twist, other), as_array(exact_ad(twist)) @ other, atol=0)


def test_the_bracket_is_that_of_the_matrices_and_obeys_jacobi() -> None:
    a, b, c = (random_twists(40, seed) for seed in (8, 9, 10))
    A, B = screws.hat(a), screws.hat(b)
    bracket = screws.bracket
    assert_near(bracket(a, b), screws.vee(A @ B - B @ A), atol=1e-14)
    assert_near(bracket(a, bracket(b, c)) + bracket(b, bracket(c, a)) + bracket(c, bracket(a, b)), 0, atol=1e-13)
    assert_near(bracket(a, a), 0, atol=1e-15)


def test_a_unit_turn_about_a_line_is_its_coordinates_with_the_halves_exchanged_and_a_force_is_not() -> None:
    rng = np.random.default_rng(11)
    line = lines.PluckerLine.through(*rng.normal(size=(2, 60, 3)))
    moved = line.transformed(MANY)
    turn, moved_turn = (np.roll(each.coordinates, 3, axis=-1) for each in (line, moved))
    assert_near(screws.transform_twist(MANY, turn), moved_turn, atol=1e-13)
    assert_near(screws.transform_wrench(MANY, line.coordinates), moved.coordinates, atol=1e-13)
    np.testing.assert_array_equal(screws.Screw(line, 1.0, 0.0).twist, turn)


def test_the_jacobian_of_the_nao_has_twists_for_columns(nao: nk.NaoModel) -> None:
    q = nao.random(0)
    T = nao.fk(q, "LArm")
    seen_from_hand, seen_from_torso = (nao.jacobian(q, "LArm", expressed_in=frame) for frame in ("frame", "root"))
    assert_near(screws.transform_twist(T, seen_from_hand.T).T, seen_from_torso, atol=1e-14)
    # Moving by a small step of the joints is moving by the twist of the step.
    step = 1e-6 * np.random.default_rng(1).normal(size=q.shape)
    moved = screws.inverse(T) @ nao.fk(q + step, "LArm")
    assert_near(screws.log(moved), seen_from_hand @ step, atol=1e-10)


# --- from pose to pose


def test_the_way_along_a_screw_is_pinocchios_interpolation() -> None:
    for T, S in zip(MANY, OTHERS, strict=True):
        for s in (-0.5, 0.0, 0.3, 1.0, 1.7):
            theirs = pin.SE3.Interpolate(pin.SE3(T), pin.SE3(S), s).homogeneous
            assert_near(screws.sclerp(T, S, s), theirs, atol=1e-12)


@EXACT
@given(twists, twists, st.floats(-1.0, 2.0))
def test_the_way_begins_and_ends_at_the_poses_and_is_as_fast_everywhere(start, way, s) -> None:
    T_0 = exact_pose(start)
    T_1 = T_0 @ exact_pose(way)
    size = 1 + np.abs([*start[:3], *way[:3]]).max()
    assert_near(screws.sclerp(T_0, T_1, 0), T_0, atol=20 * EPS * size)
    assert_near(screws.sclerp(T_0, T_1, 1), T_1, atol=20 * EPS * size)
    here, there = screws.sclerp(T_0, T_1, [s, s + 0.25])
    quarter = screws.sclerp(T_0, T_1, 0.25)
    done = screws.inverse(here) @ there
    assert_near(done, screws.inverse(T_0) @ quarter, atol=100 * EPS * size)
    orientation = rotations.matrix_from_quat(
        rotations.slerp(rotations.quat_from_matrix(T_0[:3, :3]), rotations.quat_from_matrix(T_1[:3, :3]), s)
    )
    if np.linalg.norm(way[3:]) < math.pi - 1e-6:
        assert_near(here[:3, :3], orientation, atol=40 * EPS)


@pytest.mark.parametrize("arc", ["shorter", "longer"])
def test_the_way_is_the_same_seen_from_another_frame_and_of_another_frame(arc: str) -> None:
    S = screws.exp(random_twists(60, 12))
    way = screws.sclerp(MANY, OTHERS, 0.3, arc=arc)
    assert_near(screws.sclerp(S @ MANY, S @ OTHERS, 0.3, arc=arc), S @ way, atol=1e-12)
    assert_near(screws.sclerp(MANY @ S, OTHERS @ S, 0.3, arc=arc), way @ S, atol=1e-12)


@pytest.mark.parametrize("angle", [1e-9, 1e-3, 1.0, 3.0, math.pi - 1e-9])
def test_the_longer_way_is_about_the_same_line_the_other_way_round(angle) -> None:
    # About the upright line through (1, 0, 0), up by 0.4; the longer way turns by angle − 2π.
    line = lines.PluckerLine.from_point_direction([1, 0, 0], [0, 0, 1])
    end = screws.Screw(line, angle, 0.4).pose
    for s in (0.0, 0.25, 1.0, 1.5):
        found = screws.sclerp(np.eye(4), end, s, arc="longer")
        expected = screws.Screw(line, s * (angle - 2 * math.pi), s * 0.4).pose
        # A line is known as well as the rounding of the poses tells it from the turn.
        assert_near(found, expected, atol=1e-15 / min(1.0, angle) + 1e-14)
        shorter = screws.sclerp(np.eye(4), end, s)
        assert_near(shorter, screws.Screw(line, s * angle, s * 0.4).pose, atol=1e-15 / min(1.0, angle))


def test_the_longer_way_of_a_translation_is_refused() -> None:
    T = screws.pose(rotations.rot_z([0.5, 0.0]), [1, 2, 3])
    with pytest.raises(BadArgument, match=r"the poses at index \[1\] differ by a translation alone"):
        screws.sclerp(np.eye(4), T, 0.5, arc="longer")
    with pytest.raises(BadArgument, match="differ by a translation alone"):
        screws.sclerp(T[0], T[0], 0.5, arc="longer")
    with pytest.raises(UnknownName, match="unknown arc 'long'"):
        screws.sclerp(T[0], T[1], 0.5, arc="long")
    assert_near(screws.sclerp(np.eye(4), T[1], 0.5), screws.pose(np.eye(3), [0.5, 1, 1.5]), atol=EPS)


def test_poses_close_together_far_from_the_origin_lose_nothing() -> None:
    # Numbers that 1e6 more does not round.
    R_0, R_1, step, far = rotations.rot_x(0.3), rotations.rot_x(0.301), np.array([0.5, 0.25, -0.5]), [1e6, -2e6, 3e6]
    T_0, T_1 = screws.pose(R_0, far), screws.pose(R_1, far + step)
    found = screws.sclerp(T_0, T_1, 1000)
    near = screws.sclerp(screws.pose(R_0, [0, 0, 0]), screws.pose(R_1, step), 1000)
    assert_near(found[:3, 3] - far, near[:3, 3], atol=1e-9)
