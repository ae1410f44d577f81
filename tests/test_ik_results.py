from __future__ import annotations

import numpy as np
import pytest

from nao_kin.ik import Family, IKResult, Obstacles, Reason

JOINTS = ("LKneePitch", "LAnklePitch")


def result(reasons: list[int] | int, **others: object) -> IKResult:
    """Two joints of a robot with four, at most one solution each."""
    codes = np.array(reasons, dtype=np.int8)
    shape = codes.shape
    reached = codes == Reason.REACHED
    values = np.where(reached[..., None], [0.5, -0.25], np.nan)
    arguments: dict[str, object] = {
        "joints": JOINTS,
        "columns": (2, 0),
        "reference": np.array([9.0, 1.0, 9.0, 2.0]),
        "best": values,
        "branches": values[..., None, :],
        "families": np.zeros((*shape, 1), dtype=np.int8),
        "count": reached.astype(np.int64),
        "reasons": codes,
        "residual": np.where(reached[..., None], 0.0, np.full(2, np.nan)),
        "obstacles": Obstacles.none(shape),
    }
    return IKResult(**{**arguments, **others})  # type: ignore[arg-type]


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
    found = result(0, reference=reference)
    found.q[...] = 7.0
    found.solutions[...] = 7.0
    assert not reference.any()


@pytest.mark.parametrize(
    ("needed", "words"),
    [(0.012, "12 mm"), (1e-9, "1 nm"), (2.5e-6, "2.5 µm"), (0.5, "500 mm"), (1.5, "1.5 m")],
)
def test_a_distance_is_said_in_the_unit_in_which_people_say_it(needed: float, words: str) -> None:
    found = result(1, obstacles=Obstacles(np.array(-1), np.array(needed), np.array(0.0)))
    assert found.message == f"out of reach by {words}"


def test_a_target_in_millimetres_is_guessed() -> None:
    found = result(1, obstacles=Obstacles(np.array(-1), np.array(180.0), np.array(0.0)))
    assert found.message == "out of reach by 180 m; targets are in metres"


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


def test_a_batch_has_a_message_for_each_target() -> None:
    found = result([[0, 1], [5, 6]])
    assert np.shape(found.message) == (2, 2)
    assert found.message[0][0] == "reached, 1 solution"  # type: ignore[index]
    assert found.message[1][1] == "no solution found"  # type: ignore[index]
    assert repr(found) == "<IKResult of LKneePitch, LAnklePitch: 1 of 4 targets reached>"
