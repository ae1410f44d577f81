"""Planted offsets are found within the stated covariance, and what cannot be found is said by name."""

from __future__ import annotations

import re
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from calibration_samples import (
    ANGLES,
    IN_PLACE,
    MARKS,
    looking,
    measured,
    misread,
    pixels_of,
    planted,
    seen,
    whole_body,
)
from hypothesis import given, strategies as st
from loops import full
from scipy.special import gammaincinv

import nao_kin as nk
from nao_kin._core.files import read_toml
from nao_kin.calibration import Calibration, Contacts, Pixels, Poses, calibrate
from nao_kin.calibration.problem import _pose_of_points
from nao_kin.errors import BadArgument, OtherRobotWarning, UnknownName

HEAD_AND_ARM = ["HeadYaw", "HeadPitch", "LShoulderPitch", "LShoulderRoll", "LElbowYaw", "LElbowRoll"]
SEEDS = 100
TOP = {"CameraTop": IN_PLACE["CameraTop"]}


def squared_error(found: Calibration, numbers: np.ndarray) -> float:
    """eᵀ Σ⁻¹ e of the offsets: χ² with as many degrees of freedom as there are offsets."""
    n = len(numbers)
    e = found.values[:n] - numbers
    return float(e @ np.linalg.solve(found.covariance[:n, :n], e))


def chi_squared(freedom: int, *shares: float) -> np.ndarray:
    """The values of χ² below which it is in these shares of the cases. SciPy's `stats` takes a second to import."""
    return np.asarray(2.0 * gammaincinv(freedom / 2, shares))


def head_and_arm(nao: nk.NaoModel, seed: int, postures: int = 30, **more: Any) -> tuple[Calibration, np.ndarray]:
    rng = np.random.default_rng(seed)
    true, numbers = planted(nao, rng, HEAD_AND_ARM, ["CameraTop"])
    q = looking(true, rng, postures, ["LArm"])
    pixels = misread([seen(true, measured(nao), q, "LArm", rng)], rng)
    found = calibrate(nao, pixels, joints=HEAD_AND_ARM, frames={"CameraTop": ANGLES}, prior=TOP, **more)
    return found, numbers


def test_planted_offsets_of_head_arm_and_camera_are_found(nao: nk.NaoModel) -> None:
    errors = []
    for seed in range(2):
        found, numbers = head_and_arm(nao, seed)
        assert not found.held
        assert not found.outliers
        errors.append(squared_error(found, numbers))
        assert np.abs(found.values - numbers).max() < 0.015 < np.abs(numbers).max()
    low, high = chi_squared(2 * len(numbers), 1e-4, 1 - 1e-4)
    assert low < sum(errors) < high


@pytest.mark.full
@pytest.mark.filterwarnings("ignore::nao_kin.errors.DegreesWarning")  # cameras are off by up to three times 5°
@pytest.mark.parametrize("case", ["head and arm", "whole body"])
def test_the_squared_errors_of_many_robots_are_chi_squared(nao: nk.NaoModel, case: str) -> None:
    from scipy import stats  # takes a second, in each process

    method = head_and_arm if case == "head and arm" else whole_body
    errors, freedom, deviations, held = [], 0, [], 0
    for seed in range(SEEDS):
        try:
            found, numbers = method(nao, 1000 + seed)
        except BadArgument:  # one of 23 zeros is beyond four standard deviations
            continue
        held += bool(found.held)  # the error of a number that is held has the prior's deviation
        freedom = len(numbers)
        errors.append(squared_error(found, numbers))
        deviations.append((found.values - numbers) / np.sqrt(np.diag(found.covariance)))
    assert len(errors) > 0.95 * SEEDS
    assert held < 0.1 * SEEDS
    assert stats.kstest(errors, stats.chi2(freedom).cdf).pvalue > 1e-3
    low, high = chi_squared(len(errors) * freedom, 1e-3, 1 - 1e-3)
    assert low < sum(errors) < high
    # Each number alone, too: no one is biased or overrated.
    assert np.abs(np.mean(deviations, axis=0)).max() < 4.0 / np.sqrt(SEEDS)
    narrow, wide = np.sqrt(chi_squared(len(errors) - 1, 1e-5, 1 - 1e-5) / len(errors))
    spread = np.std(deviations, axis=0)
    assert spread.min() > narrow
    assert spread.max() < wide


@pytest.mark.parametrize("named", ["both", "world", "marker"])
def test_motion_capture_finds_offsets_mounting_and_world(nao: nk.NaoModel, named: str) -> None:
    rng, joints = np.random.default_rng(2), ["RHipRoll", "RHipPitch", "RKneePitch", "RAnklePitch"]
    true, numbers = planted(nao, rng, joints)
    q = nao.random(rng, 40)
    world = np.eye(4) if named == "marker" else nk.screws.pose(nk.rotations.random_rotation(rng=3), (3.0, -2.0, 1.0))
    marker = np.eye(4) if named == "world" else nk.screws.pose(nk.rotations.random_rotation(rng=4), (0.1, 0.0, 0.05))
    noise = np.concatenate((rng.normal(0, 1e-3, (40, 3)), rng.normal(0, 5e-3, (40, 3))), axis=1)
    wrong = nk.screws.pose(nk.rotations.exp(noise[:, 3:]), noise[:, :3])
    measured = Poses(
        q, "r_ankle", world @ true.fk(q, "r_ankle") @ marker @ wrong,
        world=None if named == "marker" else "room", marker=None if named == "world" else "cluster", noise=(1e-3, 5e-3),
    )  # fmt: skip
    found = calibrate(nao, [measured], joints=joints, joint_noise=0.0)
    assert not found.held
    assert squared_error(found, numbers) < chi_squared(len(numbers), 1 - 1e-4)[0]
    predicted = (
        found.poses.get("room", np.eye(4)) @ found.calibrated().fk(q, "r_ankle") @ found.poses.get("cluster", np.eye(4))
    )
    assert np.abs(predicted - world @ true.fk(q, "r_ankle") @ marker)[:, :3, 3].max() < 3e-3
    assert found.initial_residuals[0].std() > 1.5 > 1.1 > found.residuals[0].std() > 0.9


def test_a_board_in_an_unknown_place_is_found_from_any_side(nao: nk.NaoModel) -> None:
    camera, rng = measured(nao), np.random.default_rng(5)
    true = nao.with_offsets({"HeadPitch": 0.04}, {"CameraTop": (0, 0, 0, 0.02, 0, 0)})
    q = nao.posture("StandInit", HeadYaw=rng.uniform(-0.2, 0.2, 12), HeadPitch=rng.uniform(-0.2, 0.2, 12))
    cube = np.concatenate((MARKS - (0.03, 0, 0), [[0.0, 0.0, 0.06], [0.03, 0.02, 0.05]]))
    for points in (MARKS, cube):
        for turn in nk.rotations.random_rotation(rng=6, shape=3):
            T_board = nk.screws.pose(turn, (0.5, 0.02, 0.15))
            T = nk.screws.inverse(true.fk(q, "CameraTop")) @ T_board
            in_camera = np.einsum("nij,kj->nki", T[:, :3, :3], points) + T[:, None, :3, 3]
            pixels = camera.project(in_camera) + rng.normal(0, 0.1, (12, len(points), 2))
            one = Pixels(q, camera, pixels, points, board="cube", noise=0.1)
            found = calibrate(nao, [one], joints=["HeadPitch"], frames={"CameraTop": ["roll"]})
            assert not found.outliers
            six = np.linalg.norm(found.poses["cube"] - T_board)
            assert six < 0.02, f"{six}"


def test_soles_on_one_floor_find_offsets_of_the_legs(nao: nk.NaoModel) -> None:
    from scipy.optimize import least_squares  # takes half a second, in each process

    true = nao.with_offsets({"RAnkleRoll": 0.03, "LKneePitch": -0.04})
    rng = np.random.default_rng(1)
    moved = [nao.joint_names.index(name) for name in nao.chains["RLeg"][1:]]
    q = nao.posture("StandInit") + rng.uniform(-0.08, 0.08, (20, nao.nq))
    for row in q:

        def off(values: np.ndarray, row: np.ndarray = row) -> np.ndarray:
            row[moved] = values
            T = true.fk(row, "RLeg", reference="LLeg")
            return np.array((T[2, 3], T[0, 2], T[1, 2]))

        off(least_squares(off, row[moved], xtol=1e-15, ftol=1e-15, gtol=1e-15).x)
    q = q[np.abs(true.fk(q, "RLeg", reference="LLeg")[:, 2] - (0, 0, 1, 0)).max(axis=-1) < 1e-12]
    assert len(q) > 10  # the others' legs are too short
    found = calibrate(nao, [Contacts(q, "RLeg", "LLeg")], joints=["RAnkleRoll", "LKneePitch"], prior="none")
    assert found.joints == pytest.approx({"RAnkleRoll": 0.03, "LKneePitch": -0.04}, abs=1e-5)


def test_numbers_that_the_data_cannot_tell_apart_are_named_and_held(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(8)
    true = nao.with_offsets({"HeadYaw": 0.04})
    camera = measured(nao)
    q = nao.posture("StandInit", HeadYaw=rng.uniform(-0.3, 0.3, 15))
    T_board = nk.screws.pose(nk.rotations.matrix_from_rpy((1.5, 0.2, -1.4)), (0.6, 0.0, 0.2))
    pixels = pixels_of(true, camera, q, np.repeat(T_board[None], 15, axis=0))
    one = Pixels(q, camera, pixels, MARKS, board="board")
    with pytest.raises(
        BadArgument, match=r"cannot tell apart HeadYaw offset, x of board, y of board, z of board, pitch"
    ):
        calibrate(nao, [one], joints=["HeadYaw"], indistinguishable="refuse")
    found = calibrate(nao, [one], joints=["HeadYaw"])
    assert found.held == ("HeadYaw offset",)
    assert found.joints == {"HeadYaw": 0.0}
    assert found.standard_deviations["HeadYaw offset"] == np.radians(1.0)
    assert np.abs(found.residuals[0]).max() < 1e-6  # the board takes the place of the offset

    # A camera that turns about the head's axis: known points tell the sum of both apart from everything else.
    upright = replace(one, board=None, points=(T_board[:3, :3] @ MARKS.T).T + T_board[:3, 3])
    found = calibrate(nao, [upright], joints=["HeadYaw", "LKneePitch"], frames={"CameraTop": ANGLES}, prior="none")
    assert found.held == ("LKneePitch offset",)
    note, others = found.notes
    assert note.startswith(
        "the data say nothing about LKneePitch offset: LKneePitch offset is held at 0 ± 11°; observe"
    )
    assert others == (
        "zero of HeadPitch, x of CameraTop's mounting, y of CameraTop's mounting are unknown too, and in the standard "
        "deviations; name them in joints and frames to have them in the result"
    )
    assert found.joints["HeadYaw"] == pytest.approx(0.04, abs=1e-6)


def test_a_whole_mounting_takes_the_place_of_the_joint_below_it(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(9)
    true = nao.with_offsets({"HeadPitch": 0.04, "HeadYaw": 0.02})
    q = looking(true, rng, 12, ["LArm"])
    one = seen(true, measured(nao), q, "LArm", rng)
    found = calibrate(nao, [one], joints=["HeadYaw", "HeadPitch"], frames=["CameraTop"])
    assert len(found.held) == 1
    assert "cannot tell apart HeadPitch offset, " in found.notes[0]
    assert "pitch of CameraTop's mounting" in found.notes[0]
    fewer = calibrate(nao, [one], joints=["HeadYaw", "HeadPitch"], frames={"CameraTop": ANGLES}, prior=TOP)
    assert not fewer.held


def test_outliers_are_named_and_do_not_bend_the_result(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(3)
    true, numbers = planted(nao, rng, HEAD_AND_ARM, ["CameraTop"])
    q = looking(true, rng, 20, ["LArm"])
    one = seen(true, measured(nao), q, "LArm", rng)
    pixels = np.array(one.pixels)
    pixels[3, 2] += (80.0, -40.0)
    pixels[11] += 25.0
    bad = replace(one, pixels=pixels)
    found = calibrate(nao, [bad], joints=HEAD_AND_ARM, frames={"CameraTop": ANGLES}, prior=TOP)
    assert {outlier.item for outlier in found.outliers} == {
        "posture 3, point 2",
        *(f"posture 11, point {k}" for k in range(9)),
    }
    assert found.outliers[0].item == "posture 3, point 2"
    assert found.outliers[0].sigmas == pytest.approx(np.hypot(160, 80), rel=0.05)
    assert (
        "10 of 180 observed items are beyond their noise: observation 0 (pixels), posture 3, point 2" in found.notes[0]
    )
    assert np.abs((found.values - numbers) / np.sqrt(np.diag(found.covariance))).max() < 5.0


def test_squares_bend_towards_outliers(nao: nk.NaoModel) -> None:
    q = nao.random(0, 10)
    poses = nao.with_offsets({"LElbowRoll": 0.02}).fk(q, "LArm")
    poses[3, :3, 3] += 0.02
    one, errors = Poses(q, "LArm", poses), []
    for loss in ("huber", "linear"):
        found = calibrate(nao, [one], joints=["LElbowRoll"], loss=loss)  # type: ignore[arg-type]
        errors.append(abs(found.joints["LElbowRoll"] - 0.02))
    assert errors[0] < 0.003 < errors[1]


def test_observations_that_contradict_each_other_are_refused_by_name(nao: nk.NaoModel) -> None:
    q = nao.random(0, 10)
    poses = nao.fk(q, "LArm")
    poses[::2, :3, 3] += (0.05, 0.0, 0.0)
    with pytest.raises(BadArgument, match=r"contradict each other: \d+ of 10 .*observation 0 \(poses\), posture \d"):
        calibrate(nao, [Poses(q, "LArm", poses)], joints=["LElbowRoll"])


GRID = np.array([[x, y, 0.0] for x in range(4) for y in range(5)], dtype=float)


@pytest.mark.filterwarnings("ignore::nao_kin.errors.DegreesWarning")
@pytest.mark.parametrize(
    ("mistake", "board", "says"),
    [  # the unknown pose of a board takes up a reversed order and, but for the way of the camera, a size
        *full(("reversed", None, r"they agree if the points are in reverse order in observation 0$")),
        ("some reversed", None, r"reverse order in posture 1, 4, 7 of observation 0$"),
        *full(("some reversed", "chessboard", r"reverse order in posture 1, 4, 7 of observation 0$")),
        ("another lens", None, r"they agree if the lens is not the one given$"),
        *full(("another lens", "chessboard", r"they agree if the lens is not the one given$")),
        *full(("millimetres", None, r"they agree if the points are in mm, not in metres$")),
        ("25 mm", None, r"they agree if the points are 1\.[12]\d* times as far apart \(is the size of a square right"),
        ("degrees", None, r"they agree if joint values are in degrees, not in radians$"),
        *full(("degrees", "chessboard", r"they agree if joint values are in degrees, not in radians$")),
        *full(("QVGA", None, r"they agree if the pixels are in images of 1/2 of the size of the camera's$")),
        *full(("QVGA", "chessboard", r"they agree if the pixels are in images of 1/2 of the size of the camera's$")),
        ("4VGA", None, r"^observation 0: \d+ pixels are outside .* if the pixels are in images of 2 times the"),
        *full(("a wrong posture", None, r"too small, or a point, a posture or the time of an image wrong \(moving")),
    ],
)  # fmt: skip
def test_a_usual_mistake_with_a_board_is_named(nao: nk.NaoModel, mistake: str, board: str | None, says: str) -> None:
    camera, rng = measured(nao), np.random.default_rng(5)
    true = nao.with_offsets({"HeadPitch": 0.03, "HeadYaw": 0.02})
    q = nao.posture("StandInit", HeadYaw=rng.uniform(-0.2, 0.2, 12), HeadPitch=rng.uniform(-0.15, 0.15, 12))
    T_root_board = nk.screws.pose(nk.rotations.matrix_from_rpy([0.3, -1.5, 0.2]), (0.5, 0.02, 0.15))
    T_camera_board = nk.screws.inverse(true.fk(q, "CameraTop")) @ T_root_board
    real = replace(camera, fx=0.93 * camera.fx, fy=0.93 * camera.fy) if mistake == "another lens" else camera
    pixels = real.project(nk.screws.transform_point(T_camera_board[:, None], 0.03 * GRID))
    pixels += rng.normal(0.0, 0.3, pixels.shape)
    pixels[~camera.sees(pixels)] = np.nan
    points = 0.03 * GRID
    if mistake == "reversed":
        pixels = pixels[:, ::-1]
    elif mistake == "some reversed":
        pixels[[1, 4, 7]] = pixels[[1, 4, 7], ::-1]
    elif mistake == "25 mm":
        points = 0.025 * GRID
    elif mistake == "degrees":
        q = np.degrees(q)
    elif mistake in ("QVGA", "4VGA"):
        pixels = (pixels + 0.5) * (0.5 if mistake == "QVGA" else 2.0) - 0.5
    elif mistake == "a wrong posture":
        q = np.roll(q, 1, axis=0)
    points = points if board else nk.screws.transform_point(T_root_board, points)
    points = 1000.0 * points if mistake == "millimetres" else points
    one = Pixels(q, camera, pixels, points, board=board, noise=0.3)
    try:
        said = " ".join(calibrate(nao, [one], joints=["HeadYaw", "HeadPitch"]).notes)
    except BadArgument as error:
        said = str(error)
    assert re.search(says, said), said


def test_steps_of_a_search_that_lead_nowhere_warn_of_nothing(nao: nk.NaoModel) -> None:
    camera, rng = measured(nao), np.random.default_rng(0)
    q = nao.posture("StandInit", HeadYaw=rng.uniform(-0.2, 0.2, 12), HeadPitch=rng.uniform(-0.15, 0.15, 12))
    T_root_board = nk.screws.pose(nk.rotations.matrix_from_rpy([0.3, -1.5, 0.2]), (0.5, 0.02, 0.15))
    points = nk.screws.transform_point(T_root_board, 0.03 * GRID)
    T_camera_root = nk.screws.inverse(nao.fk(q, "CameraTop"))
    reverse = camera.project(nk.screws.transform_point(T_camera_root[:, None], points))[:, ::-1]
    with warnings.catch_warnings():
        warnings.simplefilter("error", nk.errors.DegreesWarning)
        with pytest.raises(BadArgument, match="they agree if the points are in reverse order"):
            calibrate(
                nao,
                [Pixels(q, camera, reverse, points, noise=0.3)],
                joints=["HeadYaw", "HeadPitch"],
                frames={"CameraTop": ["roll", "pitch", "yaw"]},
            )


def test_noise_stated_too_small_is_noted(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(3)
    q = looking(nao, rng, 20, ["LArm"])
    one = seen(nao, measured(nao), q, "LArm", rng, noise=0.8)
    (note,) = [
        n
        for n in calibrate(nao, [replace(one, noise=0.5)], joints=["HeadYaw"], loss="linear").notes
        if "stated noise" in n
    ]
    assert "residuals are 1." in note


def test_points_that_are_not_seen_count_nothing(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(3)
    q = looking(nao, rng, 12, ["LArm"])
    one = seen(nao, measured(nao), q, "LArm", rng)
    pixels = np.array(one.pixels)
    pixels[:, 4:] = np.nan
    pixels[5] = np.nan
    kept = [i for i in range(12) if i != 5]
    some = replace(one, pixels=pixels)
    same = replace(one, q=q[kept], pixels=pixels[kept][:, :4], points=MARKS[:4])
    assert np.allclose(
        calibrate(nao, [some], joints=["HeadYaw"]).values, calibrate(nao, [same], joints=["HeadYaw"]).values, atol=1e-12
    )
    # The last residual belongs to the last posture.
    pixels[11, 3] += 100.0
    (outlier,) = calibrate(nao, [replace(one, pixels=pixels)], joints=["HeadYaw"]).outliers
    assert outlier.item == "posture 11, point 3"


def test_a_camera_beside_the_robot_and_a_board_in_its_hand_are_found_alone(nao: nk.NaoModel) -> None:
    exp, log = nk.screws.exp, nk.screws.log
    board, robot = exp([0.03, 0.01, -0.02, 0.3, -0.2, 0.5]), exp([1.2, 0.3, 0.4, 0.2, 0.1, 2.6])  # in hand and camera
    q = nao.random(rng=1, n=20)
    seen = np.linalg.inv(robot) @ nao.fk(q, "LArm") @ board
    found = calibrate(nao, [Poses(q, "LArm", seen, world="cam", marker="board")])
    assert found.poses["cam"] == pytest.approx(np.linalg.inv(robot), abs=1e-9)
    assert found.poses["board"] == pytest.approx(board, abs=1e-9)
    assert (found.labels, found.notes, found.offsets) == ((), (), {"joints": {}, "frames": {}})
    for seed in range(3):
        rng = np.random.default_rng(seed)
        noise = exp(np.concatenate([rng.normal(0.0, 0.001, (20, 3)), rng.normal(0.0, 0.005, (20, 3))], axis=1))
        read = q + rng.normal(0.0, 0.001, q.shape)
        poses = Poses(read, "LArm", seen @ noise, noise=(0.001, 0.005), world="cam", marker="board")
        found = calibrate(nao, [poses])
        for one, true in ((found.poses["cam"], np.linalg.inv(robot)), (found.poses["board"], board)):
            assert np.abs(log(np.linalg.inv(true) @ one)).max() < 0.006
        assert 0.6 < found.rms_after < 1.2
        assert not found.outliers


def test_turns_about_one_axis_do_not_tell_where_a_board_in_the_hand_is(nao: nk.NaoModel) -> None:
    q = np.tile(nao.neutral(), (12, 1))
    q[:, nao.joint_names.index("LElbowYaw")] = np.linspace(-1.0, 1.0, 12)
    found = calibrate(nao, [Poses(q, "LArm", nao.fk(q, "LArm"), world="cam", marker="board")])
    assert found.held
    assert any("cannot tell apart" in note for note in found.notes)


@pytest.mark.parametrize(
    ("wrong", "error", "message"),
    [
        ({"joints": ["RHipYawPitch"]}, BadArgument, "RHipYawPitch follows LHipYawPitch .* calibrate LHipYawPitch"),
        ({"joints": ["HeadYa"]}, UnknownName, r"unknown joint 'HeadYa' \(nearest: HeadYaw"),
        ({"frames": ["CameraTpo"]}, UnknownName, r"unknown frame 'CameraTpo' \(nearest: CameraTop"),
        ({"frames": ["Head"]}, BadArgument, "frame 'Head' is moved by HeadPitch"),
        ({"frames": ["torso"]}, BadArgument, "frame 'torso' carries the joint HeadYaw"),
        ({"frames": ["CameraTop_optical_frame"]}, BadArgument, "another frame of CameraTop: calibrate CameraTop"),
        ({"frames": ["base_link"]}, BadArgument, "frame 'base_link' is the root link"),
        ({"frames": {"CameraTop": ["rol"]}}, UnknownName, r"'rol' \(nearest: roll"),
        ({}, BadArgument, "nothing to calibrate: name joints or frames, or unknown poses"),
        ({"joints": ["HeadYaw"], "start": {"bord": np.eye(4)}}, UnknownName, "unknown board, marker or world 'bord'"),
        ({"joints": ["HeadYaw"], "loss": "hubber"}, UnknownName, "hubber"),
        ({"joints": ["HeadYaw"], "indistinguishable": "drop"}, UnknownName, "drop"),
        ({"joints": np.array(None)}, BadArgument, "joints must be a list of texts, got array"),
        ({"frames": np.array(None)}, BadArgument, "frames must be a list of texts, got array"),
        ({"joints": ["HeadYaw"], "observations": [Poses(np.zeros(25), None, np.eye(4))]}, UnknownName, "frame 'None'"),  # type: ignore[arg-type]
        ({"joints": ["HeadYaw"], "observations": [Contacts(np.zeros(25), None, "LLeg")]}, UnknownName, "frame 'None'"),  # type: ignore[arg-type]
        ({"joints": ["LElbowRoll"], "few": True}, BadArgument, "too few observations: 6 numbers for 12 of"),
    ],
)  # fmt: skip
def test_wrong_questions_are_refused_by_name(
    nao: nk.NaoModel, wrong: dict[str, Any], error: type[Exception], message: str
) -> None:
    few = wrong.pop("few", False)
    q, unknown = nao.random(0, 1 if few else 5), {"world": "w", "marker": "m"} if few else {}
    arguments = {"observations": [Poses(q, "LArm", nao.fk(q, "LArm"), **unknown)], **wrong}
    with pytest.raises(error, match=message):
        calibrate(nao, **arguments)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"pixels": np.zeros((3, 8, 2))}, "pixels must have shape"),
        ({"pixels": np.zeros((9, 3, 2))}, r"pixels must have shape \(3, 9, 2\), got \(9, 3, 2\)"),
        ({"points": np.zeros((3, 9, 3))}, r"points must have shape \(k, 3\)"),
        ({"frame": "LHnd"}, "unknown frame 'LHnd'"),
        ({"noise": 0.0}, "noise of pixels must be positive, got 0.0"),
        ({"noise": (1.0, 1.0)}, "noise of pixels must have shape"),
        ({"pixels": np.full((3, 9, 2), np.inf)}, "pixels must not be infinite"),
        ({"points": MARKS * np.nan}, "points must be finite"),
        ({"q": np.zeros((3, 7))}, "q must have shape"),
        ({"frame": None, "points": MARKS - (1.0, 0.0, 0.0)}, "points seen are behind the camera"),
        ({"board": "b", "pixels": np.full((3, 9, 2), [[50.0, 50.0]] * 3 + [[np.nan] * 2] * 6)}, "four of its points"),
        ({"board": "b"}, "four of its points"),  # all at one pixel
    ],
)
def test_wrong_pixels_are_refused(nao: nk.NaoModel, change: dict[str, Any], message: str) -> None:
    q = np.repeat(nao.posture("StandInit")[None], 3, axis=0)
    one = Pixels(q, measured(nao), np.full((3, 9, 2), 50.0), MARKS)
    with pytest.raises(nk.NaoKinError, match=message):
        calibrate(nao, [replace(one, **change)], joints=["HeadYaw"])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"poses": np.zeros((3, 4, 4))}, "poses: not a rotation matrix at index [0]"),
        ({"poses": np.tile(np.diag([1.0, 1.0, 1.0, 2.0]), (3, 1, 1))}, "last row is 0, 0, 0, 2"),
        ({"noise": 0.001}, "noise of poses must have shape (2,)"),
        ({"world": "a", "marker": "a"}, "'a' names a world of the root and a marker on LArm"),
    ],
)
def test_wrong_poses_are_refused(nao: nk.NaoModel, change: dict[str, Any], message: str) -> None:
    q = nao.random(0, 3)
    with pytest.raises(nk.NaoKinError, match=re.escape(message)):
        calibrate(nao, [replace(Poses(q, "LArm", nao.fk(q, "LArm")), **change)], joints=["LElbowYaw"])


def test_the_offsets_are_written_as_load_nao_takes_them(nao: nk.NaoModel, tmp_path: Path) -> None:
    rng, q = np.random.default_rng(0), nao.random(0, 30)
    joints = {"LHipYawPitch": 0.05, "RHipYawPitch": 0.05, "RKneePitch": -0.03}
    true = nao.with_offsets(joints, {"LFoot/FSR/FrontLeft": (0.001, 0, 0, 0, 0.02, 0)})
    observations = [Poses(q, name, true.fk(q, name)) for name in ("RLeg", "LFoot/FSR/FrontLeft")]
    found = calibrate(
        nao,
        observations,
        joints=["LHipYawPitch", "RKneePitch"],
        frames={"LFoot/FSR/FrontLeft": ["x", "pitch"]},
        prior="none",
    )
    path = found.save(tmp_path / "offsets.toml")
    again = nk.load_nao(offsets=path)
    for frame in ("RLeg", "LFoot/FSR/FrontLeft", "LFoot/FSR/FrontRight"):
        assert np.abs(again.fk(q, frame) - true.fk(q, frame)).max() < 1e-9
        assert np.array_equal(again.fk(q, frame), found.calibrated().fk(q, frame))
    with pytest.raises(BadArgument, match="already exists"):
        found.save(path)
    found.save(path, overwrite=True)
    onto = calibrate(true, [replace(observations[0], q=q + 0 * rng.normal())], joints=["RKneePitch"])
    with pytest.raises(BadArgument, match="had offsets before"):
        onto.save(tmp_path / "more.toml")
    tool = nk.load_nao().with_frame("Pen", "LArm", (0.08, 0.0, 0.02, 0.0, 0.0, 0.1))
    held = calibrate(tool, observations, joints=["RKneePitch"], prior="none")
    again = nk.load_nao(offsets=held.save(tmp_path / "tool.toml"))
    assert np.allclose(again.fk(q, "Pen"), held.calibrated().fk(q, "Pen"), atol=1e-9)


def test_the_file_says_where_offsets_are_from_and_leaves_out_what_the_data_do_not_determine(
    nao: nk.NaoModel, tmp_path: Path
) -> None:
    q = nao.random(0, 12)
    hands = nao.with_offsets({"LHipYawPitch": 0.02, "RHipYawPitch": 0.02, "LKneePitch": 0.01}).fk(q, "LLeg")
    found = calibrate(nao, [Poses(q, "LLeg", hands)], joints=["LHipYawPitch", "LKneePitch", "HeadYaw"])
    path = found.save(tmp_path / "mine.toml")
    document = read_toml(str(path))
    about = document["calibration"]
    assert about["robot"] == "nao_v6"
    assert about["observations"] == "poses in 12 postures"
    assert about["items"] == 12
    assert about["rms_after"] < 0.1 < about["rms_before"]
    assert about["standard_deviations"] == found.standard_deviations
    assert document["joints"].keys() == {"LHipYawPitch", "LKneePitch", "RHipYawPitch"}
    assert "# HeadYaw: not determined, ± 0.017\n" in path.read_text(encoding="utf-8")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert np.allclose(nk.load_nao("v6", offsets=path).fk(q, "LLeg"), hands, atol=2e-3)
    with pytest.raises(BadArgument, match="on a NAO v6"):
        nk.load_nao("v4", offsets=path)
    with pytest.warns(OtherRobotWarning, match="found for nao_v6, and this robot is nao_v4"):
        nk.load_nao("v4").with_offsets(**found.offsets, found_for="nao_v6")


@pytest.mark.filterwarnings("ignore::nao_kin.errors.DegreesWarning")  # of tilts that are rare
def test_the_covariance_of_held_offsets_is_that_of_before(nao: nk.NaoModel) -> None:
    """The errors of many robots have the covariance that one calibration states."""
    joints, errors = ["HeadPitch", "HeadYaw", "RElbowRoll"], []
    q = nao.posture("StandInit", HeadYaw=np.linspace(-0.3, 0.3, 5), HeadPitch=np.linspace(-0.2, 0.2, 5))
    for seed in range(20):
        rng = np.random.default_rng(seed)
        true, numbers = planted(nao, rng, joints, ["CameraTop"])
        noise = nk.screws.pose(nk.rotations.exp(rng.normal(0.0, 2e-3, (5, 3))), np.zeros((5, 3)))
        one = Poses(q, "CameraTop", true.fk(q, "CameraTop") @ noise, noise=(0.5, 2e-3))
        found = calibrate(nao, [one], joints=joints, frames={"CameraTop": ANGLES}, loss="linear")
        assert "RElbowRoll offset" in found.held
        errors.append(found.values - numbers)
    assert len(found.held) > 1  # a zero that the mounting takes over
    taken = np.sqrt(np.diag(found.covariance))
    assert taken[joints.index("RElbowRoll")] == np.radians(1.0)
    assert np.abs(np.std(errors, axis=0) / taken - 1.0).max() < 0.4
    worst = np.linalg.eigh(found.covariance / np.outer(taken, taken))
    narrow = (np.array(errors) / taken) @ worst[1][:, 0]  # the combination that is known best
    assert 0.5 < narrow.std() / np.sqrt(worst[0][0]) < 2.0


@pytest.mark.parametrize(
    ("prior", "error", "message"),
    [
        ("wide", UnknownName, "unknown prior 'wide'"),
        ({"HeadYa": 0.1}, UnknownName, r"calibrated joint or frame of prior: 'HeadYa' \(nearest: HeadYaw"),
        ({"HeadYaw": [0.1, 0.2]}, nk.errors.WrongShape, r"prior of HeadYaw must have shape \(\)"),
        ({"CameraTop": 0.1}, nk.errors.WrongShape, r"prior of CameraTop must have shape \(6,\)"),
        ({"HeadYaw": 0.0}, BadArgument, "prior of HeadYaw must be positive, got 0.0"),
        ({"HeadYaw": np.nan}, nk.NaoKinError, "prior of HeadYaw must be finite"),
    ],
)
def test_wrong_priors_are_refused(nao: nk.NaoModel, prior: Any, error: type[Exception], message: str) -> None:
    q = nao.random(0, 3)
    with pytest.raises(error, match=message):
        calibrate(nao, [Poses(q, "Head", nao.fk(q, "Head"))], joints=["HeadYaw"], frames=["CameraTop"], prior=prior)


def test_priors_are_typical_ones_or_yours(nao: nk.NaoModel) -> None:
    q = nao.random(0, 3)
    arguments: dict[str, Any] = {"joints": ["HeadYaw", "LHand"], "frames": {"CameraTop": ["x", "pitch"], "LArm": ["z"]}}
    for prior, expected in (
        ("typical", [np.radians(1.0), np.inf, 0.003, np.radians(5.0), np.inf]),
        ("none", [np.inf] * 5),
        ({"LHand": 0.05, "CameraTop": [0.001] * 6}, [np.radians(1.0), 0.05, 0.001, 0.001, np.inf]),
    ):
        found = calibrate(nao, [Poses(q, "CameraTop", nao.fk(q, "CameraTop"))], **arguments, prior=prior)  # type: ignore[arg-type]
        assert found.prior_deviations.tolist() == expected


def test_an_offset_far_beyond_its_prior_is_refused(nao: nk.NaoModel) -> None:
    q = nao.random(0, 20)
    # 3.4 and 5.2 degrees, of which a joint has 1 typically
    near, far = (
        Poses(q, "LArm", nao.with_offsets(joints={"LElbowRoll": offset}).fk(q, "LArm")) for offset in (0.06, 0.09)
    )
    assert calibrate(nao, [near], joints=["LElbowRoll"]).joints["LElbowRoll"] == pytest.approx(0.06, abs=0.003)
    with pytest.raises(BadArgument, match=r"LElbowRoll offset would be 5.1°, 5.1 times its prior .*, 1°; is the place"):
        calibrate(nao, [far], joints=["LElbowRoll"])
    found = calibrate(nao, [far], joints=["LElbowRoll"], prior={"LElbowRoll": 0.05})
    assert found.joints["LElbowRoll"] == pytest.approx(0.09, abs=0.003)


def test_the_next_posture_is_that_whose_observation_shrinks_the_uncertainty_most(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(6)
    q = looking(nao, rng, 6, ["LArm"])
    camera = measured(nao)
    one = seen(nao, camera, q, "LArm", rng)
    arguments: dict[str, Any] = {"joints": HEAD_AND_ARM, "frames": {"CameraTop": ANGLES}, "loss": "linear"}
    found = calibrate(nao, [one], **arguments)
    candidates = np.concatenate((looking(nao, rng, 6, ["LArm"]), nao.posture("StandInit")[None]))
    best = nk.calibration.next_posture(found, candidates)
    assert best.gain[-1] == pytest.approx(0.0, abs=1e-9)  # no mark in sight
    assert best.index == best.gain.argmax()
    now = np.linalg.slogdet(found.covariance)[1]
    for k in range(6):
        # The calibrated robot sees the candidate without noise: the covariance of a calibration with it in.
        extra = seen(found.calibrated(), camera, candidates[k : k + 1], "LArm", rng, noise=0.0)
        then = calibrate(nao, [one, replace(extra, noise=0.5)], **arguments)
        assert 0.5 * (now - np.linalg.slogdet(then.covariance)[1]) == pytest.approx(best.gain[k], rel=5e-3)
    assert list(best.standard_deviations) == list(found.labels)
    assert all(after <= found.standard_deviations[name] for name, after in best.standard_deviations.items())
    random = nk.calibration.next_posture(found, rng=0, count=300)
    assert nao.within_limits(random.q)
    assert np.array_equal(random.q, nk.calibration.next_posture(found, rng=0, count=300).q)


def test_the_next_posture_refuses_what_it_cannot_answer(nao: nk.NaoModel) -> None:
    q = nao.posture("StandInit", HeadYaw=[0.0, 0.1])
    soles = calibrate(nao, [Contacts(q, "RLeg", "LLeg")], joints=["RAnkleRoll"])
    with pytest.raises(BadArgument, match="give candidates"):
        nk.calibration.next_posture(soles)
    assert nk.calibration.next_posture(soles, q).gain.shape == (2,)
    hand = calibrate(nao, [Poses(q[[0, 0]], "LArm", nao.fk(q[[0, 0]], "LArm"))], joints=["LElbowRoll"])
    with pytest.raises(BadArgument, match="no joint differed"):
        nk.calibration.next_posture(hand)
    with pytest.raises(UnknownName, match="LElbowRol"):
        nk.calibration.next_posture(hand, joints=["LElbowRol"])
    nothing = calibrate(nao, [Poses(q, "LArm", nao.fk(q, "LArm"))], joints=["RKneePitch"])
    assert nothing.held == ("RKneePitch offset",)
    with pytest.raises(BadArgument, match="no candidate shows any"):
        nk.calibration.next_posture(nothing, rng=0)
    camera, ahead = measured(nao), np.array([[2.0, 0.0, 0.2]])
    pixels = camera.project(nk.screws.transform_point(nk.screws.inverse(nao.fk(q, camera.frame)), ahead))[:, None]
    away = calibrate(nao, [Pixels(q, camera, pixels, ahead)], joints=["HeadYaw"])
    with pytest.raises(BadArgument, match="no candidate shows any"):
        nk.calibration.next_posture(away, nao.posture("StandInit", HeadYaw=2.0))
    unseen = calibrate(nao, [Poses(q, "LArm", nao.fk(q, "LArm"), world="room")], joints=["LShoulderPitch"])
    assert unseen.held == ("LShoulderPitch offset",)
    with pytest.raises(BadArgument, match=r"tells more about the offsets; .* observe points at measured places, or"):
        nk.calibration.next_posture(unseen, rng=0)
    moved = nk.calibration.next_posture(hand, joints=["LElbowRoll"], rng=1)
    assert np.flatnonzero(moved.q != q[0]).tolist() == [nao.joint_names.index("LElbowRoll")]


def test_any_batch_shape_is_the_same_calibration(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(3)
    q = looking(nao, rng, 6, ["LArm"])
    one = seen(nao, measured(nao), q, "LArm", rng)
    hand = Poses(q, "LArm", nao.fk(q, "LArm"))
    flat = calibrate(nao, [one, hand], joints=["HeadYaw", "LElbowYaw"])
    batch = [replace(one, q=q.reshape(2, 3, 25), pixels=np.reshape(one.pixels, (2, 3, 9, 2)))]
    batch += [replace(hand, q=row, poses=nao.fk(row, "LArm")) for row in q]
    assert np.allclose(calibrate(nao, batch, joints=["HeadYaw", "LElbowYaw"]).values, flat.values, atol=1e-9)


@given(seed=st.integers(0, 10**6), rank=st.sampled_from([2, 3]), size=st.sampled_from([1e-2, 0.1, 1.0]))
def test_the_pose_of_points_is_found_from_their_rays(seed: int, rank: int, size: float) -> None:
    rng = np.random.default_rng(seed)
    points = size * rng.uniform(-1.0, 1.0, (8, 3)) * (1.0, 1.0, rank == 3) @ nk.rotations.random_rotation(rng)
    T = nk.screws.pose(nk.rotations.random_rotation(rng), size * rng.uniform((4, -1, -1), (9, 1, 1)))
    places = nk.screws.transform_point(T, points + size)
    found = _pose_of_points(points + size, places / np.linalg.norm(places, axis=1)[:, None])
    assert found is not None
    assert np.abs(found - T)[:3, :3].max() < 1e-6
    assert np.abs(found - T)[:3, 3].max() < 1e-5 * size
    assert _pose_of_points(points[:3], places[:3]) is None
    assert _pose_of_points(np.outer(np.arange(8.0), (1.0, 2.0, 3.0)), places) is None  # on one line
