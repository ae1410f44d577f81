"""Every derivative of a residual beside finite differences, and every pose beside the robot with its offsets."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from calibration_samples import MARKS, looking, measured, seen
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin.calibration import Contacts, Pixels, Poses
from nao_kin.calibration.problem import Problem
from nao_kin.calibration.unknowns import Unknowns

STEP = 1e-6
LENS = (0.1, -0.2, 0.003, -0.004, 0.05, 0.2, -0.1, 0.3)


def worst_derivative(problem: Problem, x: np.ndarray) -> float:
    """The largest difference between J and central differences, over the largest entry of its column."""
    J = problem.jacobian(x)
    steps = STEP * np.eye(problem.size)
    slopes = np.stack([problem.residuals(x + h) - problem.residuals(x - h) for h in steps], axis=1) / (2.0 * STEP)
    assert np.abs(J).max(axis=0).min() > 0.0, "an unknown without effect proves nothing"
    return float((np.abs(J - slopes) / np.abs(J).max(axis=0)).max())


@pytest.fixture(scope="module")
def some(nao: nk.NaoModel) -> dict[str, Any]:
    rng = np.random.default_rng(4)
    q, top = looking(nao, rng, 6, ["LArm"]), measured(nao)
    T_board = nk.screws.pose(nk.rotations.matrix_from_rpy((0.3, -1.2, 0.4)), (0.5, 0.1, 0.2))
    T_world = nk.screws.pose(nk.rotations.random_rotation(rng=1), (1.0, 2.0, 3.0))
    T_marker = nk.screws.pose(nk.rotations.random_rotation(rng=2), (0.01, 0.02, 0.03))
    pixels = seen(nao, top, q, "LArm", rng)
    optical = replace(pixels, camera=replace(top, frame="CameraTop_optical_frame"))
    unknown = replace(top, distortion=LENS[:5], nominal=True)
    speeds = rng.uniform(-2.0, 2.0, q.shape)
    moving = lambda t: q + t * speeds + t**2 * speeds[::-1]  # noqa: E731
    board = Pixels(q[:2], top, np.full((2, 9, 2), 100.0), MARKS, board="board")
    markers = Poses(q, "RArm", T_world @ nao.fk(q, "RArm") @ T_marker, world="room", marker="marker")
    feet = Poses(q, "LLeg", nao.fk(q, "LLeg", reference="RLeg"), reference="RLeg")
    return {
        "pixels on a hand": ([pixels], ["HeadYaw", "LElbowYaw"], ["CameraTop", "LArm"], {}),
        "pixels through a lens": ([replace(pixels, camera=replace(top, distortion=LENS))], ["HeadPitch"], [], {}),
        "pixels at an optical frame": ([optical], ["HeadYaw", "LElbowYaw"], ["CameraTop", "LArm"], {}),
        "pixels through a lens that is not known": ([replace(pixels, camera=unknown)], ["HeadPitch"], [], {}),
        "a lens that is not known at moving joints": (
            [replace(pixels, camera=unknown, moving=moving)], ["LElbowYaw"], [], {}),
        "a board": ([board], ["HeadYaw", "HeadPitch"], {"CameraTop": ["x", "roll", "yaw"]}, {"board": T_board}),
        "markers": ([markers], ["RShoulderRoll", "RWristYaw"], ["RArm"], {"room": T_world, "marker": T_marker}),
        "one foot in the other": ([feet], ["LHipYawPitch", "RKneePitch", "LAnkleRoll"], {"LLeg": ["roll"]}, {}),
        "soles": ([Contacts(q, "RLeg", "LLeg")], ["LHipYawPitch", "LHipRoll", "RAnklePitch"], {"RLeg": ["z"]}, {}),
        "all": ([pixels, board, markers, feet], ["HeadYaw", "LElbowRoll", "RKneePitch"], ["CameraTop", "RArm"], {
            "board": T_board, "room": T_world, "marker": T_marker}),
    }  # fmt: skip


@pytest.mark.parametrize(
    "kind",
    [
        "pixels on a hand",
        "pixels through a lens",
        "pixels at an optical frame",
        "pixels through a lens that is not known",
        "a lens that is not known at moving joints",
        "a board",
        "markers",
        "one foot in the other",
        "soles",
        "all",
    ],
)
def test_every_derivative_is_that_of_finite_differences(nao: nk.NaoModel, some: dict[str, Any], kind: str) -> None:
    problem = Problem(nao, *some[kind])
    rng = np.random.default_rng(7)
    for size in (0.0, 0.1):
        assert worst_derivative(problem, size * rng.uniform(-1.0, 1.0, problem.size)) < 1e-6


@pytest.mark.parametrize("base", ["fixed", "floating"])
def test_poses_are_those_of_the_robot_with_these_offsets(base: Any) -> None:
    nao, rng = nk.load_nao(base=base), np.random.default_rng(3)
    frames = {"CameraTop": ("roll", "y"), "LArm": ("x", "yaw"), "l_gripper": ("z", "pitch")}
    unknowns = Unknowns(nao, ["HeadPitch", "LHipYawPitch"], frames, {})
    x = rng.uniform(-0.1, 0.1, len(unknowns.labels))
    top, hand, gripper = (0, x[2], 0, x[3], 0, 0), (x[4], 0, 0, 0, 0, x[5]), (0, 0, x[6], 0, x[7], 0)
    true = nao.with_offsets(
        {"HeadPitch": x[0], "LHipYawPitch": x[1], "RHipYawPitch": x[1]},
        {"CameraTop": top, "LArm": hand, "l_gripper": gripper},
    )
    q = nao.random(rng, 4)
    if base == "floating":
        q[:, :3] = rng.normal(size=(4, 3))
    for frame in ("CameraTop", "CameraTop_optical_frame", "CameraBottom", "LArm", "l_gripper", "LLeg", "HeadYaw"):
        assert np.abs(unknowns.at(x).frame(q, frame).T - true.fk(q, frame)).max() < 1e-12, frame


def test_sliding_joints_and_followers_have_derivatives_too(tmp_path: Path) -> None:
    robot = made_up(
        tmp_path,
        J("lift", (0.0, 0.6, 0.8), kind="prismatic"),
        J("turn", (0.0, 1.0, 0.0), (0.1, 0.2, 0.3)),
        J("finger", (1.0, 0.0, 0.0), (0.0, 0.1, 0.2), follows=("turn", -2.0, 0.3)),
    )
    q = robot.random(1, 5)
    problem = Problem(robot, [Poses(q, "finger_l", robot.fk(q, "finger_l"))], ["lift", "turn"], [], {})
    assert worst_derivative(problem, np.array([0.05, -0.07])) < 1e-6
    true = robot.with_offsets({"lift": 0.02, "turn": 0.05, "finger": -0.1})
    found = nk.calibration.calibrate(
        robot, [Poses(q, "finger_l", true.fk(q, "finger_l"))], joints=["lift", "turn"], prior="none"
    )
    assert found.joints == pytest.approx({"lift": 0.02, "turn": 0.05, "finger": -0.1}, abs=1e-8)
