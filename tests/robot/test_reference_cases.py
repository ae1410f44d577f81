"""Poses that others published, measured or computed; every case names its source and the tolerance that it supports."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import nao_kin as nk
from nao_kin.robot.nao import VERSIONS
from nao_kin.rotations import matrix_from_rpy

CASES = json.loads((Path(__file__).parents[1] / "data" / "reference_cases.json").read_text())
# Which of our versions a case speaks of.
SPEAKS_OF = {"V3.3..V6": ("v3.3", "v4", "v5", "v6"), "V3.3/V4 H25": ("v3.3", "v4"), "V6": ("v6",), "V3.2": ("v3.2",)}
MODELS = {version: nk.load_nao(version) for version in VERSIONS}


def _frame(case: dict, effector: str) -> str:
    if effector.startswith("link:"):
        return effector.removeprefix("link:")
    if effector in ("LLeg", "RLeg"):
        # Cases by the documentation's table have its foot height; those by NAOqi and the official URDF have NAOqi's.
        height = (
            case["pose"]["position_m"][2] if not case.get("angles_rad") and "one_solution_rad" not in case else None
        )
        return f"{effector[0]}Foot/Sole" if height == pytest.approx(-0.33309, abs=1e-9) else effector
    return effector


def _assert_pose(nao: nk.NaoModel, angles: dict, frame: str, pose: dict, tolerance: dict) -> None:
    q = nao.configuration(angles, limits="ignore")
    T = nao.fk(q, frame)
    rotation = np.array(pose["rotation"]) if "rotation" in pose else matrix_from_rpy(pose["position6d"][3:])
    position = pose.get("position_m", pose["position6d"][:3])
    assert np.linalg.norm(T[:3, 3] - position) <= tolerance["position_m"]
    # ‖R − S‖ / √2 is the angle between two rotations that are close to each other.
    assert np.linalg.norm(T[:3, :3] - rotation) / np.sqrt(2) <= tolerance["rotation_rad"]


@pytest.mark.parametrize("case", CASES["fk"], ids=lambda case: case["id"])
def test_forward_kinematics_meets_the_published_pose(case: dict) -> None:
    assert case["frame"] == "FRAME_TORSO"
    for version in SPEAKS_OF[case["version"]]:
        _assert_pose(
            MODELS[version], case["angles_rad"], _frame(case, case["effector"]), case["pose"], case["tolerance"]
        )


@pytest.mark.parametrize("case", CASES["ik_targets"], ids=lambda case: case["id"])
def test_forward_kinematics_meets_what_naoqi_reported(case: dict) -> None:
    angles, tolerance = case["one_solution_rad"], case["tolerance"]
    if case["effector"].startswith("LLeg+RLeg"):
        for leg in ("LLeg", "RLeg"):
            _assert_pose(MODELS["v6"], angles, leg, case["pose"][leg], tolerance)
    else:
        pose = case.get("pose", {"position6d": case.get("position6d")})
        _assert_pose(MODELS["v6"], angles, case["effector"], pose, tolerance)


@pytest.mark.parametrize("case", CASES["com"], ids=lambda case: f"{case['version']}-{case['posture']}")
def test_the_centre_of_mass_meets_the_published_one(case: dict) -> None:
    nao = MODELS[case["version"].lower()]
    q = nao.neutral() if case["posture"] == "all zero" else nao.posture(case["posture"])
    assert np.linalg.norm(nao.com(q) - case["com_m"]) <= case["tolerance_m"]
    assert nao.mass == pytest.approx(case["mass_kg"], abs=1e-9)


def test_no_case_was_lost() -> None:
    assert (len(CASES["fk"]), len(CASES["ik_targets"]), len(CASES["com"])) == (71, 22, 5)
