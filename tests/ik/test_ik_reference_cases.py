"""Poses that NAOqi itself reported; each case names its public source."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from ik_checks import pose_errors

import nao_kin as nk
from nao_kin.rotations import matrix_from_rpy

CASES = json.loads((Path(__file__).parents[1] / "data" / "reference_cases.json").read_text(encoding="utf-8"))[
    "ik_targets"
]


def pose_of(row: dict) -> np.ndarray:
    T = np.eye(4)
    if "rotation" in row:
        T[:3, :3], T[:3, 3] = row["rotation"], row["position_m"]
    else:
        x, y, z, roll, pitch, yaw = row["position6d"]
        T[:3, :3], T[:3, 3] = matrix_from_rpy([roll, pitch, yaw]), (x, y, z)
    return T


def cases_of(effector: str) -> list:
    return [pytest.param(case, id=case["id"]) for case in CASES if effector in case["effector"]]


@pytest.mark.parametrize("case", cases_of("Arm"))
def test_a_hand_is_where_naoqi_said(nao: nk.NaoModel, case: dict) -> None:
    T, tolerance = pose_of(case.get("pose", case)), case["tolerance"]
    # Rounded numbers are of no pose that five joints make exactly: the nearest is meant.
    found = nk.ik.arm(nao, case["effector"][0], T)
    assert found.residual[0] < tolerance["position_m"]
    assert found.residual[1] < tolerance["rotation_rad"]
    (error,) = pose_errors(nao.fk(found.q, case["effector"])[None], T[None])
    assert error[0] < tolerance["position_m"]
    assert error[1] < tolerance["rotation_rad"]
    expected = [case["one_solution_rad"][joint] for joint in found.joints]
    # The pose is met to its tolerance; how well that determines the joints depends on the arm's Jacobian.
    np.testing.assert_allclose(found.best, expected, rtol=0, atol=40.0 * tolerance["rotation_rad"])


@pytest.mark.parametrize("case", cases_of("Head"))
def test_a_head_is_turned_as_naoqi_said(nao: nk.NaoModel, case: dict) -> None:
    found = nk.ik.head(nao, pose_of(case["pose"])[:3, :3])
    assert found.residual[1] < case["tolerance"]["rotation_rad"]
    expected = [case["one_solution_rad"][joint] for joint in found.joints]
    np.testing.assert_allclose(found.best, expected, rtol=0, atol=2.0 * case["tolerance"]["rotation_rad"])


@pytest.mark.parametrize("case", cases_of("LLeg+RLeg"))
def test_feet_are_where_naoqi_said(nao: nk.NaoModel, case: dict) -> None:
    T, tolerance = [pose_of(case["pose"][side + "Leg"]) for side in "LR"], case["tolerance"]
    q = nao.configuration(case["one_solution_rad"], limits="ignore")
    options = {"near": q, "limits": "ignore"}
    # Rounded numbers are of feet whose hips differ a little.
    for found, feet in (
        (nk.ik.leg(nao, "L", T[0], **options), slice(0, 1)),
        (nk.ik.leg(nao, "R", T[1], **options), slice(1, 2)),
        (nk.ik.legs(nao, *T, **options), slice(0, 2)),
    ):
        errors = pose_errors(nao.fk(found.q, ["LLeg", "RLeg"][feet]), np.array(T[feet]))
        assert errors[:, 0].max() < tolerance["position_m"]
        assert errors[:, 1].max() < tolerance["rotation_rad"]
        np.testing.assert_allclose(found.q, q, rtol=0, atol=1e-4)
