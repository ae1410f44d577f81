from __future__ import annotations

import math
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from ik_checks import Floats
from loops import for_all

import nao_kin as nk
from nao_kin.errors import BadArgument, NotARotation, UnknownName
from nao_kin.ik import Family, IKResult, Obstacles, Reason
from nao_kin.ik.results import deferred_result

JOINTS = ("LKneePitch", "LAnklePitch")


def _legs(nao: nk.NaoModel, T: Floats, **options: Any) -> IKResult:
    return nk.ik.legs(nao, nao.fk(nao.posture("StandInit"), "LLeg"), T, **options)


def _torso(nao: nk.NaoModel, T: Floats, **options: Any) -> IKResult:
    T_left, T_right = (nao.fk(nao.posture("StandInit"), foot) for foot in ("LLeg", "RLeg"))
    return nk.ik.legs(nao, T_left, T_right, torso=T, base="floating", **options)


# What takes poses: the argument, a frame, and the solver.
POSES: list[tuple[str, str, Callable[..., IKResult]]] = [
    ("target", "LLeg", lambda nao, T, **options: nk.ik.leg(nao, "L", T, **options)),
    ("T_right", "RLeg", _legs),
    ("torso", "torso", _torso),
    ("target", "LArm", lambda nao, T, **options: nk.ik.arm(nao, "L", T, **options)),
    ("target", "Head", lambda nao, T, **options: nk.ik.head(nao, T[..., :3, :3], **options)),
    ("target", "LLeg", lambda nao, T, **options: nk.ik.numeric(nao, "LLeg", T, restarts=0, **options)),
]
# The same without limits, from configurations to targets that they meet.
CLOSED_FORMS: list[Callable[..., IKResult]] = [
    lambda nao, q, **options: nk.ik.leg(nao, "L", nao.fk(q, "LLeg"), **options),
    lambda nao, q, **options: nk.ik.leg(nao, "R", nao.fk(q, "RLeg"), **options),
    lambda nao, q, **options: nk.ik.legs(nao, nao.fk(q, "LLeg"), nao.fk(q, "RLeg"), **options),
    lambda nao, q, **options: nk.ik.arm(nao, "L", nao.fk(q, "LArm"), **options),
    lambda nao, q, **options: nk.ik.arm(
        nao, "R", nao.position(q, "RArm"), direction=nao.rotation(q, "RArm")[..., 0], **options
    ),
    lambda nao, q, **options: nk.ik.arm(nao, "L", nao.position(q, "LArm"), **options),
    lambda nao, q, **options: nk.ik.head(nao, nao.rotation(q, "Head"), **options),
    lambda nao, q, **options: nk.ik.look_at(
        nao, nao.position(q, "CameraTop") + nao.rotation(q, "CameraTop")[..., 0], **options
    ),
]


def test_a_posture_is_named_instead_of_its_configuration(nao: nk.NaoModel) -> None:
    q = nao.posture("StandInit")
    for solved in (
        *(lambda near, form=form: form(nao, q, near=near) for form in CLOSED_FORMS),
        lambda near: nk.ik.numeric(nao, "LArm", target=nao.fk(q, "LArm"), near=near),
        lambda near: nk.ik.analytic(nao, "LLeg", target=nao.fk(q, "LLeg"), near=near),
        lambda near: nk.ik.whole_body(nao, {"LArm": nao.position(q, "LArm")}, near=near),
        lambda near: nk.ik.follow(nao, {"LArm": nao.fk(q, "LArm")[None]}, near=near),
    ):
        assert np.array_equal(solved("Crouch").q, solved(nao.posture("Crouch")).q)
    with pytest.raises(UnknownName, match="unknown posture 'Stan' .nearest: Stand"):
        nk.ik.leg(nao, "L", nao.fk(q, "LLeg"), near="Stan")


def result(reasons: list[int] | int, **others: object) -> IKResult:
    """Two joints of a robot with four, at most one solution each."""
    codes = np.array(reasons, dtype=np.int8)
    shape = codes.shape
    reached = codes == Reason.REACHED
    values = np.where(reached[..., None], [0.5, -0.25], np.nan)
    arguments: dict[str, object] = {
        "joints": JOINTS,
        "columns": (2, 0),
        "near": np.array([9.0, 1.0, 9.0, 2.0]),
        "best": values,
        "branches": values[..., None, :],
        "families": np.zeros((*shape, 1), dtype=np.int8),
        "count": reached.astype(np.int64),
        "reasons": codes,
        "residual": np.where(reached[..., None], 0.0, np.full(2, np.nan)),
        "obstacles": Obstacles(np.full(shape, -1), np.zeros(shape), np.zeros(shape)),
    }
    return IKResult(**{**arguments, **others})  # type: ignore[arg-type]


def test_attributes_that_are_made_later_are_made_once_and_copied_with_the_result() -> None:
    whole = result([0, 1])
    asked: list[None] = []

    def parts() -> dict[str, Any]:
        asked.append(None)
        return {**vars(whole), "best": whole.best.copy()}

    later = deferred_result(parts, ("a note",))
    assert (later.notes, asked) == (("a note",), [])
    assert later.best is later.best
    assert later.reason.tolist() == [0, 1]
    assert asked == [None]
    copied = pickle.loads(pickle.dumps(nk.ik.head(nk.load_nao(), np.eye(3))))
    assert copied.success == nk.ik.head(nk.load_nao(), np.eye(3)).success
    with pytest.raises(AttributeError, match="'IKResult' object has no attribute 'values'"):
        _ = later.values


def test_of_one_target_success_reason_and_message_are_single_values() -> None:
    found = result(0)
    assert found.success is True
    assert found.reason is Reason.REACHED
    assert found.family is Family.NONE
    assert found.message == "reached, 1 solution"


def test_solutions_are_merged_into_the_reference() -> None:
    found = result(0)
    np.testing.assert_array_equal(found.q, [-0.25, 1.0, 0.5, 2.0])
    np.testing.assert_array_equal(found.solutions, [[-0.25, 1.0, 0.5, 2.0]])


def test_where_there_is_no_solution_all_of_q_is_nan() -> None:
    found = result([0, 1])
    np.testing.assert_array_equal(found.success, [True, False])
    np.testing.assert_array_equal(np.isnan(found.q).all(axis=-1), [False, True])
    np.testing.assert_array_equal(np.isnan(found.solutions).all(axis=(-2, -1)), [False, True])
    assert not np.isnan(found.q[0]).any()


def test_what_is_merged_is_a_copy() -> None:
    reference = np.zeros(4)
    found = result(0, near=reference)
    found.q[...] = 7.0
    found.solutions[...] = 7.0
    assert not reference.any()


@for_all(
    ("needed", "words"),
    [
        (1.5, "1.5 m"),
        (2.5e-6, "2.5 µm"),
        (1e-9, "1 nm"),
        (0.0, "0 nm"),
        # Rounded before the unit is chosen.
        (0.99996, "1 m"),
        (0.99994, "999.9 mm"),
        (999.94e-6, "999.9 µm"),
    ],
)
def test_a_distance_is_said_in_the_unit_in_which_people_say_it(needed: float, words: str) -> None:
    found = result(1, obstacles=Obstacles(np.array(-1), np.array(needed), np.array(0.0)))
    assert found.message == f"out of reach by at least {words}"


def test_a_target_in_millimetres_is_guessed() -> None:
    found = result(1, obstacles=Obstacles(np.array(-1), np.array(180.0), np.array(0.0)))
    assert found.message == "out of reach by at least 180 m; targets are in metres"


def test_the_joint_that_is_in_the_way_is_named_with_the_value_it_needs() -> None:
    found = result(3, obstacles=Obstacles(np.array(0), np.array(2.31), np.array(2.11)))
    assert found.message == "LKneePitch needs 2.31 rad, limit 2.11"
    found = result(4, obstacles=Obstacles(np.array(1), np.array(0.31), np.array(0.21)))
    assert found.message == "LAnklePitch needs 0.31 rad, coupled limit there 0.21"


def test_a_limit_that_is_hardly_passed_is_told_apart_from_the_value() -> None:
    found = result(3, obstacles=Obstacles(np.array(0), np.array(2.11254653), np.array(2.11254651)))
    assert found.message == "LKneePitch needs 2.11254653 rad, limit 2.11254651"


def test_a_nearest_pose_comes_with_its_errors() -> None:
    found = result(2, best=np.zeros(2), residual=np.array([0.003, 0.05]))
    assert found.message == "2 joints do not make this pose; the nearest pose is off by 3 mm and 0.05 rad"


def test_a_family_is_named() -> None:
    found = result(0, families=np.array([Family.HIP_LOCK], dtype=np.int8))
    assert found.family is Family.HIP_LOCK
    assert found.message == "reached, 1 solution, of the family HIP_LOCK"


def test_a_solution_of_a_redundant_limb_is_said_to_be_one_of_many(nao: nk.NaoModel) -> None:
    found = nk.ik.arm(nao, "L", nao.position(nao.posture("StandInit"), "LArm"))
    assert found.family is Family.REDUNDANT
    assert found.message == "reached, one of infinitely many solutions"


def test_a_batch_has_a_message_for_each_target() -> None:
    found = result([[0, 1], [5, 6]])
    lines = found.message.splitlines()
    assert len(lines) == 4
    assert (lines[0], lines[3]) == ("reached, 1 solution", "no solution found") == (found.describe((0, 0)), lines[-1])
    assert repr(found) == "<IKResult of LKneePitch, LAnklePitch: 1 of 4 targets reached>"


# --- what all solvers have in common ----------------------------------------------------------------------------------


@for_all(("argument", "frame", "solve"), POSES)
def test_writing_into_one_result_changes_no_later_answer(
    nao: nk.NaoModel, argument: str, frame: str, solve: Callable[..., IKResult]
) -> None:
    T = nao.fk(nao.posture("StandInit"), frame)
    found = solve(nao, T)
    expected = found.q
    found.near[...] = 1.5
    np.testing.assert_array_equal(solve(nao, T).q, expected)


@for_all(("argument", "frame", "solve"), POSES)
def test_a_target_without_a_rotation_is_named_with_its_index_and_its_defect(
    nao: nk.NaoModel, argument: str, frame: str, solve: Callable[..., IKResult]
) -> None:
    T = np.tile(nao.fk(nao.posture("StandInit"), frame), (2, 3, 1, 1))
    T[1, 2, :3, :3] *= 1.1
    with pytest.raises(NotARotation, match=rf"^{argument}: not a rotation matrix at index \[1, 2\]: det R") as error:
        solve(nao, T)
    assert error.value.index == (1, 2)
    assert error.value.determinant_defect == pytest.approx(1.1**3 - 1.0)
    if frame == "Head":
        return
    T = np.tile(nao.fk(nao.posture("StandInit"), frame), (2, 1, 1))
    T[1, 3, 0] = 1.0
    with pytest.raises(
        BadArgument, match=rf"^{argument} at index \[1\] is not a rigid transform: its last row is 1, 0, 0, 1"
    ):
        solve(nao, T)


@for_all(("argument", "frame", "solve"), POSES)
def test_an_empty_batch_is_one(nao: nk.NaoModel, argument: str, frame: str, solve: Callable[..., IKResult]) -> None:
    found = solve(nao, np.empty((3, 0, 4, 4)))
    assert found.q.shape == (3, 0, 25)
    assert np.shape(found.success) == (3, 0)
    assert found.message == ""


@for_all(("argument", "frame", "solve"), POSES)
@for_all("policy", ["enforced", None])
def test_a_limits_policy_that_is_no_name_is_refused(
    nao: nk.NaoModel, argument: str, frame: str, solve: Callable[..., IKResult], policy: object
) -> None:
    with pytest.raises(UnknownName, match="limits policy"):
        solve(nao, np.eye(4), limits=policy)


@for_all("solve", CLOSED_FORMS)
def test_without_limits_a_reference_that_is_a_solution_is_the_best_whatever_its_turns(
    nao: nk.NaoModel, solve: Callable[..., IKResult]
) -> None:
    q = np.random.default_rng(5).uniform(-6.0, 6.0, (40, nao.nq))
    many = solve(nao, q, near=q, limits="ignore")
    one = solve(nao, q[0], near=q[0], limits="ignore")
    assert np.all(many.success)
    np.testing.assert_allclose(many.q, q, rtol=0, atol=1e-6)
    np.testing.assert_allclose(one.q, q[0], rtol=0, atol=1e-6)
    away = many.branches - q[:, None, many.columns]
    assert np.nanmax(np.abs(away)) < math.pi + 1e-9
    distances = np.linalg.norm(away, axis=-1)
    assert np.all(np.diff(np.where(np.isnan(distances), np.inf, distances)[..., :2], axis=-1) >= 0.0)


@for_all("solve", CLOSED_FORMS[:2])
def test_without_limits_a_member_of_a_family_may_be_whole_turns_away(
    nao: nk.NaoModel, solve: Callable[..., IKResult]
) -> None:
    q = np.zeros((2, 3, nao.nq))
    q[..., nao.joint_names.index("LHipRoll")] = -math.pi / 4
    q[..., nao.joint_names.index("RHipRoll")] = math.pi / 4
    q[..., [nao.joint_names.index("LKneePitch"), nao.joint_names.index("RKneePitch")]] = 0.5
    q[..., nao.joint_names.index("LHipYawPitch")] = [3.1, 3.3, -5.0]
    found = solve(nao, q, near=q, limits="ignore")
    np.testing.assert_array_equal(found.families[..., 0], Family.HIP_LOCK)
    np.testing.assert_allclose(found.q, q, rtol=0, atol=1e-9)


def test_without_limits_every_branch_is_within_half_a_turn_of_any_reference(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(5)
    reference, q = rng.uniform(-6.0, 6.0, (60, nao.nq)), nao.random(rng, 60)
    for found in (
        nk.ik.arm(nao, "R", nao.fk(q, "RArm"), near=reference, limits="ignore"),
        nk.ik.head(nao, nao.rotation(q, "Head"), near=reference, limits="ignore"),
        nk.ik.leg(nao, "L", nao.fk(q, "LLeg"), near=reference, limits="ignore"),
    ):
        away = np.abs(found.solutions - reference[:, None])[..., found.columns]
        assert np.nanmax(away) <= math.pi + 1e-9
        assert np.nanmax(away) > 0.95 * math.pi


def test_without_limits_every_nearest_pose_is_within_half_a_turn_of_any_reference(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(3)
    reference, q = rng.uniform(-6.0, 6.0, (60, nao.nq)), nao.random(rng, 60)
    hands, feet, beside = nao.fk(q, "LArm"), nao.fk(q, ["LLeg", "RLeg"]), nao.position(nao.neutral(), "Head") + 0.01
    hands[:, :3, 3] += 0.02
    feet[..., :3, 3] *= 1.5
    for found in (
        nk.ik.arm(nao, "L", hands, near=reference, limits="ignore"),
        nk.ik.head(nao, nk.rotations.random_rotation(rng, 60), near=reference, limits="ignore"),
        nk.ik.look_at(nao, np.tile(beside, (60, 1)), near=reference, limits="ignore"),
        nk.ik.leg(nao, "R", feet[:, 1], near=reference, limits="ignore"),
        nk.ik.legs(nao, feet[:, 0], feet[:, 1], near=reference, limits="ignore"),
    ):
        missed = ~np.asarray(found.success)
        assert missed.sum() > 20
        away = np.abs(found.q - reference)[missed][:, found.columns]
        assert away.max() <= math.pi + 1e-9
        assert away.max() > 0.95 * math.pi


def test_a_reference_of_very_many_turns_takes_no_digits(nao: nk.NaoModel) -> None:
    q = nao.posture("StandInit")
    reference = q.copy()
    reference[nao.joint_names.index("LKneePitch")] = 1e9
    found = nk.ik.leg(nao, "L", nao.fk(q, "LLeg"), near=reference, limits="ignore")
    assert np.abs(nao.fk(found.solutions, "LLeg") - nao.fk(q, "LLeg")).max() < 1e-10
