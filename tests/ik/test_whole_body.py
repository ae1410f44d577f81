"""Poses of the whole NAO on its feet."""

from __future__ import annotations

import gc
import itertools
import math
import os
import subprocess
import sys
import weakref
from dataclasses import replace

import numpy as np
import pytest
from ik_checks import pose_errors
from loops import full
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from whole_body_samples import Standing, is_above, sensors, standing_poses

import nao_kin as nk
from nao_kin.errors import BadArgument, NotARotation, NotFinite, UnknownName, WrongShape
from nao_kin.ik import Reason, WholeBodyResult, whole_body
from nao_kin.ik.body_errors import Plan, errors_at, new_state, place_all, stand_on_both
from nao_kin.ik.body_targets import BodyTarget, feet_beyond, margin_beyond, prepared, target_beyond
from nao_kin.ik.limit_regions import TABLE, limit_rows, outside
from nao_kin.ik.quadratic_program import quadratic_program
from nao_kin.ik.targets import checked_reference
from nao_kin.robot import SupportPolygon

Floats = NDArray[np.float64]
FEET = ("LLeg", "RLeg")


def crouching(nao: nk.RobotModel) -> tuple[Floats, dict[str, Floats]]:
    """A posture with bent knees, and its feet."""
    q = nao.posture("StandInit")
    return q, dict(zip("LR", nao.fk(q, FEET), strict=True))


def assert_stands(nao: nk.RobotModel, found: WholeBodyResult, feet: dict[str, Floats]) -> None:
    """Check that the feet have their poses to 1e-10, and that every joint is inside its limits."""
    for side, T in feet.items():
        errors = pose_errors(found.torso @ nao.fk(found.q, f"{side}Leg"), T)
        assert errors.max() < 1e-10, errors.max(axis=tuple(range(errors.ndim - 1)))
    assert nao.within_limits(found.q).all()


def feasible(nao: nk.NaoModel, poses: Standing, *, both: bool) -> tuple[WholeBodyResult, dict[str, Floats]]:
    """Solve for all kinds of targets, taken from feasible poses."""
    camera = poses.pose(nao, "CameraTop")
    feet = {"L": poses.feet[:, 0]} | ({"R": poses.feet[:, 1]} if both else {})
    targets = {hand: poses.pose(nao, hand) for hand in ("LArm", "RArm")}
    if not both:
        targets["RLeg"] = poses.feet[:, 1]
    seen = camera[:, :3, 3] + camera[:, :3, 0]
    found = whole_body(nao, targets, feet=feet, com="support", gaze=seen)
    assert_stands(nao, found, feet)
    for name, T in targets.items():
        errors = pose_errors((found.torso @ nao.fk(found.q, name))[found.success], T[found.success])
        assert errors.max() < 1e-6
    camera = found.torso @ nao.fk(found.q, "CameraTop")
    d = np.einsum("nji,nj->ni", camera[:, :3, :3], seen - camera[:, :3, 3])
    angles = np.arctan2(np.linalg.norm(d[:, 1:], axis=-1), d[:, 0])
    assert angles[found.success].max() < 1e-6
    com = np.einsum("nij,nj->ni", found.torso[:, :3, :3], nao.com(found.q)) + found.torso[:, :3, 3]
    np.testing.assert_allclose(found.com, com, atol=1e-12)
    corners = sensors(nao, found.torso, found.q, "LR" if both else "L")[:, :, :2]
    middle = corners.mean(axis=1)
    inside = is_above(corners, middle + (1.0 - 1e-6) * (com[:, :2] - middle))
    assert inside[found.success].all()
    return found, feet


@pytest.mark.full
@pytest.mark.parametrize("both", [False, True], ids=["one foot", "both feet"])
def test_every_feasible_pose_is_found_from_neutral(nao: nk.NaoModel, both: bool) -> None:
    found, _ = feasible(nao, standing_poses(nao, 1000, both=both), both=both)
    assert np.all(found.success), found
    assert np.mean(found.starts == 1) > 0.7


@pytest.mark.parametrize("version", ["v3.2", *full("v3.3", "v4", "v5")])
def test_every_version_stands(version: str) -> None:
    nao = nk.load_nao(version)
    found, _ = feasible(nao, standing_poses(nao, 20, both=True, seed=3), both=True)
    assert np.all(found.success), found


def test_the_right_foot_may_stand_alone(nao: nk.NaoModel) -> None:
    q, feet = crouching(nao)
    lifted = feet["L"].copy()
    lifted[2, 3] += 0.03
    found = whole_body(nao, {"LLeg": lifted}, feet={"R": feet["R"]}, com="support", margin=0.01, near=q)
    assert found.success, found
    assert_stands(nao, found, {"R": feet["R"]})
    assert found.margin >= 0.01 - 1e-8
    assert found.standing == ("R",)
    assert pose_errors(found.torso @ nao.fk(found.q, "LLeg"), lifted).max() < 1e-7


def test_without_targets_the_robot_stands_as_it_was(nao: nk.NaoModel) -> None:
    for q in (nao.posture("StandInit"), nao.clamp(nao.neutral())):
        found = whole_body(nao, {}, near=q)
        assert found.success
        np.testing.assert_allclose(found.q, q, atol=1e-12)
        assert found.iterations == 0
        assert found.gives_way == ""


def test_a_straight_robot_crouches(nao: nk.NaoModel) -> None:
    feet = dict(zip("LR", nao.fk(nao.neutral(), FEET), strict=True))
    for depth in (1e-6, 1e-3, 0.02, 0.09):
        found = whole_body(nao, {}, torso=[0.0, 0.0, -depth], com=(0.0, 0.0))
        assert found.success, found
        assert_stands(nao, found, feet)
        np.testing.assert_allclose(found.torso[:3, 3], [0.0, 0.0, -depth], atol=1e-7)


def test_a_crouching_robot_stretches(nao: nk.NaoModel) -> None:
    q, _ = crouching(nao)
    feet = dict(zip("LR", nao.fk(nao.neutral(), FEET), strict=True))
    found = whole_body(nao, {}, feet=feet, torso=np.eye(4), near=q, tolerance=1e-6)
    assert found.success, found
    assert_stands(nao, found, feet)


def test_hands_stay_where_they_are_while_the_robot_crouches(nao: nk.NaoModel) -> None:
    q, feet = crouching(nao)
    hands = {hand: nao.fk(q, hand)[:3, 3] for hand in ("LArm", "RArm")}
    found = whole_body(nao, hands, feet=feet, com="support", margin=0.02, torso=[-0.02, 0.0, -0.03], near=q)
    assert found.success, found
    assert_stands(nao, found, feet)
    for hand, place in hands.items():
        np.testing.assert_allclose((found.torso @ nao.fk(found.q, hand))[:3, 3], place, atol=1e-7)


def test_the_world_may_be_anywhere(nao: nk.NaoModel) -> None:
    q, feet = crouching(nao)
    away = np.eye(4)
    away[:3, :3] = nk.rotations.matrix_from_rpy([0.0, 0.0, 2.0])
    away[:3, 3] = 30.0, -20.0, 1.0
    hand = nao.fk(q, "LArm")
    hand[:3, 3] += 0.02
    here = whole_body(nao, {"LArm": hand}, feet=feet, com="support", near=q)
    there = whole_body(
        nao, {"LArm": away @ hand}, feet={side: away @ T for side, T in feet.items()}, com="support", near=q
    )
    assert here.success, here
    assert there.success, there
    np.testing.assert_allclose(there.q, here.q, atol=1e-9)
    np.testing.assert_allclose(there.torso, away @ here.torso, atol=1e-9)


def test_a_floating_base_is_part_of_the_answer() -> None:
    nao = nk.load_nao("v6", base="floating")
    q = nao.posture("StandInit")
    q[:7] = 1.0, 2.0, 0.3, 0.0, 0.0, math.sin(0.4), math.cos(0.4)
    hand = nao.fk(q, "LArm")
    hand[2, 3] += 0.02
    found = whole_body(nao, {"LArm": hand}, near=q, com="support")
    assert found.success, found
    np.testing.assert_allclose(nao.fk(found.q, FEET), nao.fk(q, FEET), atol=1e-10)
    np.testing.assert_allclose(nao.fk(found.q, "LArm"), hand, atol=1e-7)
    np.testing.assert_allclose(nao.com(found.q), found.com, atol=1e-10)


def test_a_batch_is_the_single_calls(nao: nk.NaoModel) -> None:
    q, feet = crouching(nao)
    places = nao.fk(q, "RArm")[:3, 3] + 0.02 * np.random.default_rng(0).normal(size=(2, 3, 3))
    references = q + np.zeros((3, 25))
    found = whole_body(nao, {"RArm": places}, feet=feet, com="support", near=references, threads=2)
    assert found.q.shape == (2, 3, 25)
    assert found.residuals["RArm"].shape == (2, 3, 2)
    for index in np.ndindex(2, 3):
        one = whole_body(nao, {"RArm": places[index]}, feet=feet, com="support", near=q)
        np.testing.assert_array_equal(one.q, found.q[index])
        assert one.message == found.describe(index)
    none = whole_body(nao, {"RArm": places[:0]}, feet=feet)
    assert none.q.shape == (0, 3, 25)
    assert none.success.shape == (0, 3)  # type: ignore[union-attr]


def test_feet_of_a_batch_have_polygons_of_their_own(nao: nk.NaoModel) -> None:
    q, feet = crouching(nao)
    right = np.repeat(feet["R"][None], 3, axis=0)
    right[:, 0, 3] += [-0.03, 0.0, 0.03]
    found = whole_body(nao, {}, feet={"L": feet["L"], "R": right}, com="support", margin=0.02, near=q)
    assert np.all(found.success), found
    assert_stands(nao, found, {"L": feet["L"], "R": right})
    for i in range(3):
        one = whole_body(nao, {}, feet={"L": feet["L"], "R": right[i]}, com="support", margin=0.02, near=q)
        assert one.margin == pytest.approx(found.margin[i], abs=1e-12)


def test_what_is_left_open_stays_near_the_posture(nao: nk.NaoModel) -> None:
    q, feet = crouching(nao)
    hand = nao.fk(q, "LArm")[:3, 3] + [0.02, 0.0, 0.02]
    right = [nao.joint_names.index(name) for name in nao.chains["RArm"] if "Hand" not in name]
    found = whole_body(nao, {"LArm": hand}, feet=feet, near=q)
    assert np.abs(found.q - q)[right].max() < 0.02
    other = nao.clamp(nao.configuration({"RShoulderPitch": 0.5}, limits="ignore"))
    found = whole_body(nao, {"LArm": hand}, feet=feet, near=q, posture=other)
    assert np.abs(found.q - other)[right].max() < 0.05


@pytest.mark.parametrize("axes", [None, nk.rotations.exp([0.3, 0.5, -1.0])], ids=["target", "others"])
def test_weights_choose_the_axes_that_are_met(nao: nk.NaoModel, axes: Floats | None) -> None:
    q, feet = crouching(nao)
    T = nao.fk(q, "LArm")
    T[:3, 3] += 0.02
    T[:3, :3] = T[:3, :3] @ nk.rotations.exp([0.2, -0.1, 0.3])
    R_axes = T[:3, :3] if axes is None else axes
    for mask in range(64):
        used = np.array([mask >> bit & 1 for bit in range(6)], np.bool_)
        weights = {"LArm": 0.5 * used if axes is None else (0.5 * used, axes)}
        found = whole_body(nao, {"LArm": T}, feet=feet, com="support", near=q, weights=weights, restarts=3)
        assert found.success, (mask, found)
        assert_stands(nao, found, feet)
        reached = found.torso @ nao.fk(found.q, "LArm")
        turn = T[:3, :3] @ Rotation.from_matrix(reached[:3, :3].T @ T[:3, :3]).as_rotvec()
        errors = np.where(used, np.concatenate([(T - reached)[:3, 3] @ R_axes, turn @ R_axes]), 0.0)
        assert np.abs(errors).max() < 1e-7, mask
        np.testing.assert_allclose(found.residuals["LArm"], np.linalg.norm(errors.reshape(2, 3), axis=1), atol=1e-12)


def test_a_factor_and_a_pair_are_short_forms_of_six_weights(nao: nk.NaoModel) -> None:
    q, feet = crouching(nao)
    T = nao.fk(q, "LArm")
    T[:3, 3] += 0.02
    forms = [(2.0, (2.0, 2.0, 2.0, 0.2, 0.2, 0.2)), ((3.0, 0.5), (3.0, 3.0, 3.0, 0.5, 0.5, 0.5))]
    for form, six in forms:
        short, long = (
            whole_body(nao, {"LArm": T}, feet=feet, gaze=T[:3, 3], near=q, weights={"LArm": weight, "gaze": weight})
            for weight in (form, six)
        )
        np.testing.assert_array_equal(short.q, long.q)


# --- what cannot be met ----------------------------------------------------------------------------------------------


def test_a_hand_out_of_reach_gives_way(nao: nk.NaoModel) -> None:
    q, feet = crouching(nao)
    found = whole_body(nao, {"LArm": [1.0, 0.0, 0.0]}, feet=feet, near=q, restarts=3)
    assert not found.success
    assert found.reason is Reason.OUT_OF_REACH
    assert found.gives_way == "LArm"
    assert found.message.startswith("LArm gives way by ")
    assert "mm: out of reach" in found.message
    assert_stands(nao, found, feet)
    place = (found.torso @ nao.fk(found.q, "LArm"))[:3, 3]
    assert found.residuals["LArm"][0] == pytest.approx(np.linalg.norm(place - [1.0, 0.0, 0.0]), abs=1e-12)


def test_of_two_targets_that_disagree_the_lighter_gives_way(nao: nk.NaoModel) -> None:
    q, feet = crouching(nao)
    places = {"LArm": [0.13, 0.35, 0.1], "RArm": [0.13, -0.35, 0.1]}
    for heavy, light in (("LArm", "RArm"), ("RArm", "LArm")):
        found = whole_body(nao, places, feet=feet, near=q, weights={heavy: 30.0}, restarts=3)
        assert not found.success
        assert found.reason is Reason.TARGETS_DISAGREE
        assert found.residuals[heavy][0] < 0.1 * found.residuals[light][0]
        assert found.gives_way == light
        assert "met without the other targets, not with them" in found.message
        assert_stands(nao, found, feet)


def test_a_target_that_is_met_does_not_give_way_however_heavy(nao: nk.NaoModel) -> None:
    q, feet = crouching(nao)
    places = {"LArm": [0.13, 0.3, 0.1], "RArm": [0.13, -0.3, 0.1]}
    found = whole_body(nao, places, feet=feet, near=q, weights={"LArm": 1e12}, restarts=2)
    assert not found.success
    for name, residual in found.residuals.items():
        if (residual <= 1e-8).all():
            assert found.gives_way != name
    assert found.residuals[str(found.gives_way)].max() > 1e-8
    exact = whole_body(nao, {"LArm": nao.fk(q, "LArm")[:3, 3] + 0.01}, feet=feet, near=q, tolerance=1e-30)
    assert "gives way by :" not in str(exact.message)


def test_a_centre_of_mass_beyond_the_feet_gives_way(nao: nk.NaoModel) -> None:
    q, feet = crouching(nao)
    found = whole_body(nao, {}, feet=feet, near=q, com=(0.5, 0.0), restarts=1)
    assert found.gives_way == "com"
    assert found.reason is Reason.OUT_OF_REACH
    assert found.residuals["com"][0] == pytest.approx(np.linalg.norm(found.com[:2] - [0.5, 0.0]))
    assert found.margin < 0.0
    assert "com gives way by" in found.message


def test_a_margin_that_no_place_has_lacks(nao: nk.NaoModel) -> None:
    q, feet = crouching(nao)
    found = whole_body(nao, {}, feet=feet, near=q, com="support", margin=0.2, restarts=1)
    assert found.gives_way == "com"
    assert found.residuals["com"][0] == pytest.approx(0.2 - found.margin)
    assert_stands(nao, found, feet)


def test_feet_that_are_too_far_apart_are_said_so(nao: nk.NaoModel) -> None:
    q, feet = crouching(nao)
    far = feet["R"].copy()
    far[1, 3] -= 0.6
    found = whole_body(nao, {}, feet={"L": feet["L"], "R": far}, near=q, restarts=2)
    assert not found.success
    assert found.gives_way == "feet"
    assert np.isnan(found.q).all()
    assert np.isnan(found.torso).all()
    assert found.reason is Reason.OUT_OF_REACH
    assert 0.1 < found.beyond < 0.2
    assert found.message.startswith("the feet cannot both be stood on: too far apart by at least 1")
    assert "metres" not in found.message
    both = whole_body(nao, {}, feet={"L": feet["L"], "R": np.array([feet["R"], far])}, near=q, restarts=2)
    assert both.success.tolist() == [True, False]  # type: ignore[union-attr]
    assert list(both.gives_way) == ["", "feet"]


def test_millimetres_are_suspected(nao: nk.NaoModel) -> None:
    found = whole_body(nao, {"LArm": [218.7, 113.0, 87.7]}, restarts=0)
    assert "targets are in metres" in found.message
    _, feet = crouching(nao)
    far = feet["R"].copy()
    far[1, 3] -= 100.0
    found = whole_body(nao, {}, feet={"L": feet["L"], "R": far}, restarts=0)
    assert found.gives_way == "feet"
    assert "targets are in metres" in found.message


def test_lengths_are_said_in_plain_figures(nao: nk.NaoModel) -> None:
    found = whole_body(nao, {"LArm": [1000.8, 0.0, 0.0]}, restarts=0)
    assert found.message.startswith("LArm gives way by 1000 m: out of reach"), found


def test_only_what_is_farther_than_the_stretched_robot_is_called_out_of_reach(nao: nk.NaoModel) -> None:
    """A search without a solution does not prove that there is none, whether it was stopped or got stuck."""
    q, feet = crouching(nao)
    reachable = nao.fk(q, "LArm")[:3, 3] + [0.0, 0.1, 0.1]
    for targets in ({"LArm": reachable}, {"LArm": reachable, "RArm": nao.fk(q, "RArm")[:3, 3]}):
        found = whole_body(nao, targets, feet=feet, near=q, restarts=1, tolerance=1e-30)
        assert found.reason is Reason.NOT_CONVERGED
        assert "no pose found that meets it" in found.message
        assert found.beyond == 0.0


def test_feet_that_may_be_stood_on_somehow_are_not_called_out_of_reach(nao: nk.NaoModel) -> None:
    q, feet = crouching(nao)
    turned = feet["R"].copy()
    turned[:3, :3] = turned[:3, :3] @ nk.rotations.rot_x(math.pi)
    found = whole_body(nao, {}, feet={"L": feet["L"], "R": turned}, near=q, restarts=1)
    assert found.gives_way == "feet"
    assert found.reason is Reason.NOT_CONVERGED
    assert np.isnan(found.margin)
    assert "no pose found that stands on both feet" in found.message


@pytest.mark.parametrize("both", [False, True], ids=["one foot", "both feet"])
def test_no_pose_is_beyond_the_stretched_robot(nao: nk.NaoModel, both: bool) -> None:
    ready = prepared(nao)
    poses = standing_poses(nao, 200, both=both)
    sides = ("L", "R") if both else ("L",)
    for frame in ("LArm", "RLeg", "CameraTop", "torso", "LHandFinger13", "LThigh"):
        row, T = ready.frame(nao, frame)
        target = BodyTarget(frame, row, T, np.eye(4), np.ones(6))
        places = poses.pose(nao, frame)
        assert not target_beyond(ready.body, target, sides, poses.feet, places).any()
        places[:, 0, 3] += 2.0
        assert (target_beyond(ready.body, target, sides, poses.feet, places) > 0.5).all()
        on_a_plane = replace(target, weights=np.array([0.0, 0.0, 1.0, 1.0, 1.0, 1.0]))
        places[:, :3, :3] = np.eye(3)
        assert not target_beyond(ready.body, on_a_plane, sides, poses.feet, places).any()
    assert not feet_beyond(ready.body, poses.feet).any()
    com = np.tile(np.eye(4), (200, 1, 1))
    com[:, :3, 3] = np.einsum("nij,nj->ni", poses.torso[:, :3, :3], nao.com(poses.q)) + poses.torso[:, :3, 3]
    target = BodyTarget("com", -1, np.eye(4), np.eye(4), np.array([1.0, 1.0, 0.0, 0.0, 0.0, 0.0]))
    assert not target_beyond(ready.body, target, sides, poses.feet, com).any()
    square = SupportPolygon.around([[0, 0], [2, 0], [2, 1], [0, 1]])
    assert margin_beyond(square, 0.5) == 0.0
    assert margin_beyond(square, 0.7) == pytest.approx(0.2)


def test_feet_that_cross_are_noted(nao: nk.NaoModel) -> None:
    q, feet = crouching(nao)
    swapped = {"L": feet["R"], "R": feet["L"]}
    found = whole_body(nao, {}, feet=swapped, near=q)
    assert found.success
    assert found.notes == ("the feet cross: the left ankle is to the right of the right one",)
    several = {side: np.stack([feet[side], swapped[side]]) for side in "LR"}
    (note,) = whole_body(nao, {}, feet=several, near=q).notes
    assert note.endswith("in 1 of 2 poses, first at index [1]")
    assert whole_body(nao, {}, feet=feet, near=q).notes == ()


def test_feet_far_from_the_origin_are_stood_on_as_near_it(nao: nk.NaoModel) -> None:
    q, feet = crouching(nao)
    away = np.eye(4)
    away[:2, 3] = 1e7, 3.3e6
    far = {side: away @ T for side, T in feet.items()}
    here = whole_body(nao, {}, feet=feet, com="support", margin=0.02, near=q)
    there = whole_body(nao, {}, feet=far, com="support", margin=0.02, near=q)
    assert there.success
    assert there.margin == pytest.approx(here.margin, abs=1e-7)
    square = np.array([[0.0, 0.0], [0.1, 0.0], [0.1, 0.05], [0.0, 0.05]]) + away[:2, 3]
    middle = square.mean(axis=0)
    assert SupportPolygon.around(square).signed_distance(middle) == pytest.approx(0.025, abs=1e-8)


def test_a_reference_outside_the_limits_is_projected_and_noted(nao: nk.NaoModel) -> None:
    q, feet = crouching(nao)
    q[nao.joint_names.index("LElbowRoll")] = 1.0
    found = whole_body(nao, {}, feet=feet, near=q)
    assert found.success
    assert nao.within_limits(found.q)
    assert len(found.notes) == 1
    assert "LElbowRoll" in found.notes[0]


def test_a_coupled_limit_is_left_by_the_shortest_way(nao: nk.NaoModel) -> None:
    """Compare for the head, whose pitch depends on its yaw: `clamp` keeps the yaw, the nearest point has another."""
    _, feet = crouching(nao)
    head = nao.configuration({"HeadYaw": 1.0, "HeadPitch": 0.5}, limits="ignore")
    nearest, _ = checked_reference(nao, head, True)
    assert np.abs(nearest - nao.clamp(head)).max() > 0.01
    found = whole_body(nao, {}, feet=feet, posture=head)
    (note,) = found.notes
    assert note.startswith("posture projected into the limits: HeadPitch = 0.5")
    np.testing.assert_allclose(found.q[:2], nearest[:2], atol=1e-3)
    found = whole_body(nao, {}, feet=feet, near=head)
    np.testing.assert_allclose(found.q[:2], nearest[:2], atol=1e-12)
    assert found.notes[0].startswith("near projected into the limits: HeadPitch = 0.5")


def test_limits_may_be_ignored(nao: nk.NaoModel) -> None:
    q, feet = crouching(nao)
    backwards = q.copy()
    backwards[nao.joint_names.index("HeadYaw")] = 2.5
    T = nao.fk(backwards, "CameraTop")
    found = whole_body(nao, {"CameraTop": T}, feet=feet, torso=np.eye(4), near=q, restarts=2)
    assert not found.success
    assert "at their limits: HeadYaw" in found.message
    found = whole_body(nao, {"CameraTop": T}, feet=feet, torso=np.eye(4), near=q, limits="ignore")
    assert found.success, found
    assert found.q[nao.joint_names.index("HeadYaw")] == pytest.approx(2.5)


def test_ignored_limits_let_joints_go_round(nao: nk.NaoModel) -> None:
    q, feet = crouching(nao)
    head, wrist, pitch = (nao.joint_names.index(name) for name in ("HeadYaw", "LWristYaw", "HeadPitch"))
    q[head], q[wrist] = 4.0, -5.0
    still = whole_body(nao, {}, feet=feet, near=q, limits="ignore")
    np.testing.assert_allclose(still.q, q, atol=1e-12)
    assert not still.at_limits.any()
    assert still.notes == ()
    hand = nao.fk(q, "LArm")[:3, 3] + [0.0, 0.01, 0.01]
    moved = whole_body(nao, {"LArm": hand}, feet=feet, near=q, limits="ignore")
    assert moved.success
    np.testing.assert_allclose((moved.torso @ nao.fk(moved.q, "LArm"))[:3, 3], hand, atol=1e-7)
    np.testing.assert_allclose(moved.q[[head, wrist]], [4.0, -5.0], atol=0.2)
    assert not moved.at_limits.any()
    # Across half a turn, where values once ended.
    turned = q.copy()
    turned[[head, pitch]] = 3.3, 0.1
    q[head] = 3.0
    found = whole_body(nao, {"Head": nao.fk(turned, "Head")}, feet=feet, torso=np.eye(4), near=q, limits="ignore")
    assert found.success
    np.testing.assert_allclose(found.q[[head, pitch]], [3.3, 0.1], atol=1e-6)


# --- what is refused --------------------------------------------------------------------------------------------------


def test_contradictions_by_form_are_refused_in_one_line(nao: nk.NaoModel) -> None:
    _, feet = crouching(nao)
    T = feet["L"]
    cases = [
        (lambda: whole_body(nao, {"LLeg": T}), BadArgument, "LLeg.* is on the left foot, which stands"),
        (lambda: whole_body(nao, {"RFoot": T}, feet={"R": T}), BadArgument, "RFoot.* is on the right foot"),
        (lambda: whole_body(nao, {"LArms": T}), UnknownName, "LArm"),
        (lambda: whole_body(nao, {}, feet={"left": T}), UnknownName, "unknown foot"),
        (lambda: whole_body(nao, {}, feet={}, com="support"), BadArgument, "feet names no foot"),
        (lambda: whole_body(nao, {"torso": np.eye(4)}, torso=np.eye(4)), BadArgument, "torso is given twice"),
        (lambda: whole_body(nao, {"Torso": T}, torso=np.eye(4)), BadArgument, "given twice.*Torso"),
        (lambda: whole_body(nao, {"base_link": T}, torso=np.eye(4)), BadArgument, "given twice.*base_link"),
        (lambda: whole_body(nao, {}, com="middle"), UnknownName, "support"),
        (lambda: whole_body(nao, {}, gaze=([1, 0, 0], "CameraFront")), UnknownName, "CameraTop|CameraBottom"),
        (lambda: whole_body(nao, {}, weights={"LArm": 1.0}), UnknownName, "unknown weight"),
        (lambda: whole_body(nao, {"LArm": T}, weights={"LArm": -1.0}), BadArgument, "none below 0"),
        (lambda: whole_body(nao, {"LArm": T}, weights={"LArm": (1, 1, 1)}), BadArgument, "or six"),
        (lambda: whole_body(nao, {"LArm": T}, weights={"LArm": (range(6), 2 * T[:3, :3])}), NotARotation, "weights"),
        (lambda: whole_body(nao, {}, com="support", weights={"com": (1, 2)}), BadArgument, "one factor"),
        (lambda: whole_body(nao, {}, margin=-0.1), BadArgument, "margin"),
        (lambda: whole_body(nao, {}, limits="some"), UnknownName, "enforce"),
        (lambda: whole_body(nk.load_robot("panda"), {}), BadArgument, "no leg that the closed form fits.*numeric"),
    ]
    for call, error, message in cases:
        with pytest.raises(error, match=message) as caught:
            call()  # type: ignore[no-untyped-call]
        assert "\n" not in str(caught.value)


def test_targets_that_are_no_poses_are_named(nao: nk.NaoModel) -> None:
    T = np.tile(np.eye(4), (3, 1, 1))
    T[1, 0, 0] = 1.1
    with pytest.raises(NotARotation, match=r"targets\[.*RArm.*\].*\[1\].*det R"):
        whole_body(nao, {"LArm": np.eye(4), "RArm": T})
    with pytest.raises(BadArgument, match=r"feet\[.*L.*\].*last row"):
        whole_body(nao, {}, feet={"L": np.diag([1.0, 1.0, 1.0, 2.0])})
    with pytest.raises(NotFinite, match=r"targets\[.*LArm"):
        whole_body(nao, {"LArm": [0.0, np.nan, 0.0]})
    with pytest.raises(WrongShape, match=r"targets\[.*LArm.*4, 4.*positions"):
        whole_body(nao, {"LArm": [0.0, 1.0]})
    with pytest.raises(WrongShape, match="com"):
        whole_body(nao, {}, com=[0.0, 0.0, 0.0])
    with pytest.raises(WrongShape, match="broadcast"):
        whole_body(nao, {"LArm": np.zeros((2, 3)), "RArm": np.zeros((3, 3))})


def test_what_is_no_array_is_refused_by_name(nao: nk.NaoModel) -> None:
    square = SupportPolygon.around([[0, 0], [1, 0], [1, 1], [0, 1]])
    cases = [
        (lambda: whole_body(nao, {"LArm": [[1, 2], [3]]}), BadArgument, r"targets\[.*LArm.*must be real numbers"),
        (lambda: whole_body(nao, {}, feet={"L": [[1, 2], [3]]}), BadArgument, r"feet\[.*must be real numbers"),
        (lambda: SupportPolygon.around("abc"), BadArgument, "points must be real numbers"),
        (lambda: SupportPolygon.around(0.5), WrongShape, r"points must have shape \(\.\.\., 2\)"),
        (lambda: square.signed_distance(0.5), WrongShape, r"points must have shape \(\.\.\., 2\)"),
        (lambda: square.signed_distance([0.5, math.nan]), NotFinite, "points"),
    ]
    for call, error, message in cases:
        with pytest.raises(error, match=message):
            call()  # type: ignore[no-untyped-call]


# --- the parts --------------------------------------------------------------------------------------------------------


def test_places_and_centres_of_mass_are_those_of_the_model(nao: nk.NaoModel) -> None:
    ready = prepared(nao)
    for q in nao.random(0, 5):
        x, rows = q[ready.order], len(ready.body.parent)
        R, p = np.empty((rows, 3, 3)), np.empty((rows, 3))
        place_all(ready.body, x, np.eye(4), R, p)
        for frame in ("LArm", "RLeg", "CameraBottom", "LHandFinger13", "torso"):
            row, T = ready.frame(nao, frame)
            np.testing.assert_allclose(R[row] @ T[:3, 3] + p[row], nao.fk(q, frame)[:3, 3], atol=1e-14)
            np.testing.assert_allclose(R[row] @ T[:3, :3], nao.fk(q, frame)[:3, :3], atol=1e-14)


@pytest.mark.parametrize("stance", ["L", "R"])
def test_derivatives_are_those_of_the_errors(nao: nk.NaoModel, stance: str) -> None:
    ready, rng = prepared(nao), np.random.default_rng(5)
    body, side = ready.body, "LR".index(stance)
    names = "LArm", "RLeg" if stance == "L" else "LLeg", "RArm", "CameraTop", "torso"
    rows, frames = zip(*(ready.frame(nao, name) for name in names), (-1, np.eye(4)), strict=True)
    aims, weights = np.array([0, 0, 0, 1, 0, 0]), rng.uniform(0.3, 1.0, (6, 6))
    weights[2, 2:4], weights[5, 3:] = 0.0, 0.0
    plan = Plan(np.array(rows), aims, weights, 1.0, 0.0, side, False, 1e-8, 1)
    targets = np.tile(np.eye(4), (6, 1, 1))
    targets[:, :3, :3] = nk.rotations.exp(rng.normal(size=(6, 3)))
    targets[:, :3, 3] = rng.normal(size=(6, 3))

    def at(x: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        q = np.empty(25)
        q[ready.order] = x
        state = new_state(body, 25, 6)
        state.x[:], state.T[:] = x, np.linalg.inv(nao.fk(q, f"{stance}Leg"))
        errors_at(body, plan, np.array(frames), targets, state)
        missing = (state.e.reshape(-1, 6) / np.where(weights > 0.0, weights, np.inf)).reshape(-1, 2, 3)
        np.testing.assert_allclose(state.residuals[:, :2], np.linalg.norm(missing, axis=-1), atol=1e-14)
        return state.e, state.J, state.com, state.com_J

    for q in nao.random(rng, 3):
        x = q[ready.order]
        _, J, _, com_J = at(x)
        for k in range(body.moving):
            step = np.zeros(25)
            step[k] = 1e-6
            ahead, behind = at(x + step), at(x - step)
            np.testing.assert_allclose(J[:, k], (ahead[0] - behind[0]) / 2e-6, atol=2e-8)
            np.testing.assert_allclose(com_J[:, k], (ahead[2] - behind[2]) / 2e-6, atol=1e-9)


def test_the_torso_goes_where_both_hips_agree(nao: nk.NaoModel) -> None:
    ready, (q, feet) = prepared(nao), crouching(nao)
    rng = np.random.default_rng(1)
    T = np.array([feet["L"], feet["R"]])
    for _ in range(5):
        x = (q + 0.1 * rng.normal(size=25))[ready.order]
        torso = np.empty((4, 4))
        assert stand_on_both(ready.body, ready.second_leg, T, x, torso)
        moved = np.empty(25)
        moved[ready.order] = x
        np.testing.assert_allclose(torso @ nao.fk(moved, FEET), T, atol=1e-12)


def test_the_quadratic_program_meets_its_optimality_conditions() -> None:
    """Against all sets of active rows, by brute force."""
    rng = np.random.default_rng(2)
    for _ in range(60):
        n, count, equal = 4, 6, int(rng.integers(0, 3))
        root = rng.normal(size=(n, n))
        H, g, A = root @ root.T + 0.1 * np.eye(n), rng.normal(size=n), rng.normal(size=(count, n))
        b = A @ rng.normal(size=n) - np.where(np.arange(count) < equal, 0.0, rng.uniform(0.0, 1.0, count))
        best = math.inf
        for size in range(n - equal + 1):
            for others in itertools.combinations(range(equal, count), size):
                active = [*range(equal), *others]
                K = np.block([[H, A[active].T], [A[active], np.zeros((len(active), len(active)))]])
                x = np.linalg.lstsq(K, np.concatenate([-g, b[active]]), rcond=None)[0][:n]
                if (
                    np.abs(A[active] @ x - b[active]).max(initial=0.0) < 1e-9
                    and (A[equal:] @ x >= b[equal:] - 1e-9).all()
                ):
                    best = min(best, 0.5 * x @ H @ x + g @ x)
        found = np.empty(n)
        assert quadratic_program(H.copy(), g, A, b, count, equal, found)
        assert 0.5 * found @ H @ found + g @ found == pytest.approx(best, abs=1e-9)
        assert (A[equal:] @ found >= b[equal:] - 1e-9).all()
        np.testing.assert_allclose(A[:equal] @ found, b[:equal], atol=1e-9)


def test_rows_that_contradict_each_other_are_noticed() -> None:
    A, b = np.array([[1.0, 0.0], [-1.0, 0.0]]), np.array([1.0, 1.0])
    assert not quadratic_program(np.eye(2), np.zeros(2), A, b, 2, 0, np.empty(2))
    assert quadratic_program(np.eye(2), np.zeros(2), np.array([[1.0, 0.0], [2.0, 0.0]]), np.array([1.0, 2.0]), 2, 2, b)


def test_rows_of_limits_hold_for_the_steps_that_end_inside(nao: nk.NaoModel) -> None:
    """On the edges of the coupled tables, farther from their bends than a step is long, and at bends that jut out."""
    ready, rng, longest = prepared(nao), np.random.default_rng(3), 1e-3
    limits, moving, count = ready.body.limits, ready.body.moving, 0
    A, b = np.zeros((200, moving + 1)), np.zeros(200)
    middle = 0.5 * (nao.lower + nao.upper)[ready.order]
    for of, joint, first, end in limits.tables.reshape(-1, TABLE):
        at, *bounds = (part[first:end] for part in (limits.at, limits.low, limits.high))
        places = [(value, side) for value in at for side in range(2)]
        places += [(0.5 * (one + other), side) for one, other in itertools.pairwise(at) for side in range(2)]
        for value, side in places:
            x = middle.copy()
            x[of] = np.clip(value, limits.lower[of] + longest, limits.upper[of] - longest)
            x[joint] = np.interp(x[of], at, bounds[side])
            jut = [np.interp(x[of] + d, at, bounds[side]) - x[joint] for d in (-longest, longest)]
            if (sum(jut) < -1e-12) == (side == 0) and abs(sum(jut)) > 1e-12:
                continue
            if not limits.lower[joint] + longest < x[joint] < limits.upper[joint] - longest:
                continue
            rows = limit_rows(limits, x, np.empty(0), np.full(moving, longest), A, b, 0)
            for _ in range(20):
                step = np.zeros(len(x))
                step[[joint, of]] = 0.99 * longest * rng.uniform(-1.0, 1.0, 2)
                holds = (A[:rows, :moving] @ step[:moving] >= b[:rows] - 1e-12).all()
                q = np.empty(len(x))
                q[ready.order] = x + step
                excess = sum(violation.excess for violation in nao.limit_violations(q))
                assert outside(limits, x + step) == pytest.approx(excess, abs=1e-8)
                assert holds == (outside(limits, x + step) <= 1e-12)
                count += 1
    assert count > 300


def test_the_polygon_is_the_hull_of_the_sensors(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(0)
    points = rng.normal(size=(12, 2))
    polygon = SupportPolygon.around(points)
    queries = 2.0 * rng.normal(size=(500, 2))
    inside = is_above(np.repeat(points[None], 500, axis=0), queries)
    np.testing.assert_array_equal(polygon.signed_distance(queries) >= 0.0, inside)
    square = SupportPolygon.around([[0, 0], [2, 0], [2, 2], [0, 2], [1, 1], [1, 0]])
    assert square.vertices.shape == (4, 2)
    np.testing.assert_allclose(square.signed_distance([[1, 1], [1.5, 1], [3, 1], [3, 3]]), [1, 0.5, -1, -math.sqrt(2)])
    with pytest.raises(BadArgument, match="no area"):
        SupportPolygon.around([[0, 0], [1, 1], [2, 2]])


def test_soles_that_stand_upright_are_refused(nao: nk.NaoModel) -> None:
    T = np.eye(4)
    T[:3, :3] = nk.rotations.rot_y(math.pi / 2)
    with pytest.raises(BadArgument, match="upright"):
        whole_body(nao, {}, feet={"L": T})


def test_without_the_compiler_the_answer_is_the_same(nao: nk.NaoModel) -> None:
    code = (
        "import sys, numpy as np, nao_kin as nk\n"
        "nao = nk.load_nao('v6'); q = nao.posture('StandInit')\n"
        "found = nk.ik.whole_body(nao, {'LArm': nao.fk(q, 'LArm')[:3, 3] + 0.01}, com='support', near=q)\n"
        "assert found.success; print(found.q.tolist())"
    )
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, check=True, text=True)
    q = nao.posture("StandInit")
    compiled = whole_body(nao, {"LArm": nao.fk(q, "LArm")[:3, 3] + 0.01}, com="support", near=q)
    np.testing.assert_allclose(compiled.q, np.array(eval(done.stdout)), atol=1e-9)


def test_a_changed_model_is_seen(nao: nk.NaoModel) -> None:
    own = nk.load_nao("v6")
    before = whole_body(own, {}).com
    own.model.inertias[int(own.model.getJointId("HeadPitch"))].mass += 1.0
    after = whole_body(own, {}).com
    assert after[2] > before[2] + 0.01


def test_a_robot_that_nobody_has_is_let_go() -> None:
    own = nk.load_nao("v6")
    assert whole_body(own, {}).success
    gone = weakref.ref(own)
    del own
    gc.collect()
    assert gone() is None
