"""Calibrated robots: offsets of joints and frames, in everything that is made of a robot."""

from __future__ import annotations

import json
import pickle
import warnings
from pathlib import Path

import numpy as np
import pytest
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin._core.files import read_toml
from nao_kin.cli.app import run
from nao_kin.crosscheck.steps import steps_of
from nao_kin.errors import (
    BadArgument,
    BadInputFile,
    DegreesWarning,
    NaoKinWarning,
    OtherRobotWarning,
    UnknownName,
    WrongShape,
)
from nao_kin.naoqi import VirtualNao
from nao_kin.rotations import matrix_from_rpy

JOINTS = {"HeadYaw": 0.01, "LHipYawPitch": -0.02, "RHipYawPitch": 0.015, "RKneePitch": 0.03, "LElbowRoll": -0.04}
CAMERA = (0.001, -0.002, 0.003, 0.01, -0.02, 0.03)
T_CAMERA = nk.screws.pose(matrix_from_rpy(CAMERA[3:]), CAMERA[:3])


@pytest.fixture(scope="module")
def calibrated() -> nk.NaoModel:
    return nk.load_nao(offsets={"joints": JOINTS, "frames": {"CameraTop": CAMERA, "LArm": (0, 0, 0.002, 0, 0, 0)}})


def _expected(nao: nk.NaoModel, q: np.ndarray, frame: str) -> np.ndarray:
    """The pose with every joint at its reported value plus its offset: 26 joints, the hips apart, by the tree alone."""
    joints = {joint.child: joint for joint in nao.tree.joints}
    chain, link = [], nao.tree.shared_names.get(frame, frame)
    while link in joints:
        chain.insert(0, joints[link])
        link = joints[link].parent
    angles, T = nao.angles(q), np.eye(4)
    for joint in chain:
        T = T @ nk.screws.pose(matrix_from_rpy(joint.origin.rpy), joint.origin.xyz)
        if joint.kind == "revolute":
            mimic = nao.mimics.get(joint.name)
            value = angles[joint.name] if mimic is None else mimic.multiplier * angles[mimic.joint] + mimic.offset
            value += JOINTS.get(joint.name, 0.0)
            T = T @ nk.screws.pose(nk.rotations.exp(value * np.array(joint.axis)), np.zeros(3))
        if joint.child == "CameraTop":
            T = T @ T_CAMERA
    return T


def test_a_joint_s_true_angle_is_the_reported_one_plus_its_offset(nao: nk.NaoModel, calibrated: nk.NaoModel) -> None:
    for q in nao.random(5, 8):
        for frame in ("Head", "LLeg", "RLeg", "RArm", "CameraTop", "CameraTop_optical_frame", "CameraBottom"):
            assert np.abs(calibrated.fk(q, frame) - _expected(nao, q, frame)).max() < 1e-12


def test_the_note_on_a_frame_s_offset_shows_no_rounding_errors(nao: nk.NaoModel) -> None:
    mine = nao.with_offsets(frames={"CameraTop": (1e-16, -1e-16, 0.002, 0, 1e-15, 0)})
    assert mine.load_notes == ("frame CameraTop: offset (0, 0, 2) mm and 0°",)


def test_a_frame_s_offset_is_its_true_pose_in_the_frame_of_before(nao: nk.NaoModel, calibrated: nk.NaoModel) -> None:
    q = nao.posture("Stand")
    T_head_nominal, T_head_true = (robot.fk(q, "CameraTop", reference="Head") for robot in (nao, calibrated))
    assert np.abs(T_head_true - T_head_nominal @ T_CAMERA).max() < 1e-12
    measured = nk.screws.pose(matrix_from_rpy([0.0, 0.03, 0.0]), [0.06, 0.001, 0.062])
    placed = nao.with_offsets(frames={"CameraTop": np.linalg.solve(T_head_nominal, measured)})
    assert np.abs(placed.fk(q, "CameraTop", reference="Head") - measured).max() < 1e-12


def test_the_offset_of_an_optical_frame_moves_its_camera(nao: nk.NaoModel) -> None:
    optical, q = "CameraTop_optical_frame", nao.posture("StandInit")
    mine = nao.with_offsets(frames={optical: CAMERA})
    assert np.abs(mine.fk(q, optical) - nao.fk(q, optical) @ T_CAMERA).max() < 1e-12
    assert np.abs(mine.fk(q, optical, reference="CameraTop") - nao.fk(q, optical, reference="CameraTop")).max() < 1e-15
    assert mine.load_notes == ("frame CameraTop_optical_frame: offset (1, -2, 3) mm and 2.148°, moves CameraTop",)
    pixel = np.array([320.0, 300.0])
    places = [nk.world.pixel_to_ground(r, q, pixel, nk.world.camera(nao, "CameraTop")).points for r in (nao, mine)]
    assert np.linalg.norm(places[1] - places[0]) > 0.05
    ros = nao.with_offsets(frames={"CameraTop_frame": CAMERA})  # the name of the body frame in ROS
    assert np.abs(ros.fk(q, "CameraTop") - nao.fk(q, "CameraTop") @ T_CAMERA).max() < 1e-12
    for frames in ({optical: CAMERA, "CameraTop": CAMERA}, {"CameraTop": CAMERA, optical: CAMERA}):
        with pytest.raises(BadArgument, match="two offsets move CameraTop; give one, of CameraTop or of its optical"):
            nao.with_offsets(frames=frames)


def test_kernels_jacobians_typed_models_and_copies_know_the_offsets(nao: nk.NaoModel, calibrated: nk.NaoModel) -> None:
    q = nao.random(6, 200)
    frames = ["CameraTop", "LLeg", "RLeg", "LArm"]
    many = calibrated.fk(q, frames)
    one_by_one = np.array([calibrated.fk(row, frames) for row in q[:20]])
    assert np.abs(many[:20] - one_by_one).max() < 1e-12
    assert np.abs(many - nao.fk(q, frames)).max() > 1e-3
    copy = pickle.loads(pickle.dumps(calibrated))
    assert (type(copy), copy.version, copy.load_notes) == (nk.NaoModel, "v6", calibrated.load_notes)
    assert np.array_equal(copy.fk(q[0]), calibrated.fk(q[0]))
    typed = nk.joints.MultiDofModel(calibrated)
    assert np.abs(typed.fk(typed.from_q(q[0]), "CameraTop") - many[0, 0]).max() < 1e-12


def test_the_robot_it_was_made_from_stays_and_offsets_add_up(nao: nk.NaoModel) -> None:
    before = nao.fk(nao.neutral())
    twice = nao.with_offsets({"HeadYaw": 0.01}).with_offsets({"HeadYaw": 0.02})
    q = nao.configuration({"HeadYaw": 0.1})
    assert np.abs(twice.fk(q, "Head") - nao.fk(nao.configuration({"HeadYaw": 0.13}), "Head")).max() < 1e-12
    assert twice.load_notes == ("joint HeadYaw: offset 0.01", "joint HeadYaw: offset 0.02")
    assert np.array_equal(nao.fk(nao.neutral()), before)
    assert nao.load_notes == ()
    assert np.array_equal(twice.lower, nao.lower)
    assert np.array_equal(nao.with_offsets().fk(q), nao.fk(q))


def test_a_floating_base_and_a_joint_that_slides_have_offsets_too(tmp_path: Path) -> None:
    floating = nk.load_nao("v5", base="floating", offsets={"joints": {"HeadYaw": 0.2}})
    assert (floating.base, floating.version) == ("floating", "v5")
    robot = made_up(tmp_path, J("lift", kind="prismatic", axis=(0.0, 0.6, 0.8)), J("turn", axis=(1.0, 0.0, 0.0)))
    mine = robot.with_offsets({"lift": 0.05, "turn": -0.1})
    q = np.array([0.2, 0.3])
    assert np.abs(mine.fk(q, "turn_l") - robot.fk(q + np.array([0.05, -0.1]), "turn_l")).max() < 1e-12


@pytest.mark.full
def test_the_cross_check_agrees_about_a_calibrated_robot(calibrated: nk.NaoModel) -> None:
    report = nk.crosscheck.run(calibrated, samples=30)
    assert report.ok, report.failures
    assert any("yourdfpy" in row.against for row in report.rows)


def test_a_forgotten_offset_is_seen_by_the_cross_check(calibrated: nk.NaoModel, nao: nk.NaoModel) -> None:
    report = nk.crosscheck.run(calibrated, samples=10, steps=steps_of(nao))
    assert not report.ok


@pytest.mark.full
def test_an_exported_urdf_brings_the_offsets_back(calibrated: nk.NaoModel, tmp_path: Path) -> None:
    done = nk.export.urdf(calibrated, tmp_path / "mine.urdf", meshes="none")
    again = nk.RobotModel.from_urdf(done.path)
    frames = [name for name in calibrated.link_names if name in again.frame_names]
    columns = [again.joint_names.index(name) for name in calibrated.joint_names]
    for q in calibrated.random(8, 5):
        reordered = np.empty_like(q)
        reordered[columns] = q
        assert np.abs(again.fk(reordered, frames) - calibrated.fk(q, frames)).max() < 1e-12


def test_a_virtual_nao_with_calibrated_legs_and_head_walks_looks_and_balances(nao: nk.NaoModel) -> None:
    mine = nao.with_offsets(JOINTS | {"LHipRoll": 0.01}, {"CameraTop": CAMERA})
    with VirtualNao(mine, stepped=True, posture="StandInit") as virtual:
        virtual.call("ALMotion", "wakeUp")
        feet = []
        for _ in range(2):
            state = virtual.state()
            feet.append(state.T_world_torso @ mine.fk(state.q, ["LLeg", "RLeg"]))
            assert virtual.call("ALMotion", "moveTo", 0.05, 0.0, 0.0)
        assert (feet[1] - feet[0])[:, 0, 3].mean() == pytest.approx(0.05, abs=1e-3)
        assert np.abs(feet[1][:, 2, 3]).max() < 1e-4  # both soles are on the ground
        point = np.array([1.0, 0.3, 0.2])
        virtual.call("ALTracker", "lookAt", point.tolist(), 0, 0.5, False)
        T_torso_camera = mine.fk(virtual.state().q, "CameraTop")
        seen = nk.screws.transform_point(nk.screws.inverse(T_torso_camera), point)
        assert np.abs(seen[1:]).max() < 1e-6
        virtual.call("ALMotion", "wbEnable", True)
        assert virtual.call("ALMotion", "wbGoToBalance", "LLeg", 1.0)
        state = virtual.state()
        com, foot = mine.com(state.q), mine.fk(state.q, "LLeg")
        assert np.linalg.norm((nk.screws.transform_point(nk.screws.inverse(foot), com))[:2]) < 0.03


@pytest.mark.parametrize(
    ("joints", "frames", "error", "says"),
    [
        ({"HeadYaww": 0.1}, {}, UnknownName, r"HeadYaww.*HeadYaw"),
        ({}, {"CameraTpo": CAMERA}, UnknownName, "CameraTop"),
        ({}, {"Head": CAMERA}, BadArgument, r"'Head' is moved by the joint HeadPitch; give joints=\{'HeadPitch'"),
        ({}, {"base_link": CAMERA}, UnknownName, "base_link"),
        ({"HeadYaw": [0.1, 0.2]}, {}, WrongShape, "the offset of HeadYaw"),
        ({}, {"CameraTop": (0.1, 0.2, 0.3)}, WrongShape, r"\(6,\) or \(4, 4\)"),
        ({}, {"CameraTop": np.diag([1.0, 1.0, -1.0, 1.0])}, BadArgument, "the offset of CameraTop"),
    ],
)
def test_bad_offsets_are_named(nao: nk.NaoModel, joints: object, frames: object, error: type, says: str) -> None:
    with pytest.raises(error, match=says) as caught:
        nao.with_offsets(joints, frames)  # type: ignore[arg-type]
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "error", "says"),
    [
        ("[joint]\nHeadYaw = 0.1", BadInputFile, r"unknown entry 'joint' \(nearest: joints\)"),
        ("joints = 3", BadInputFile, "joints must be a table"),
        ("[joints]\nHeadYaww = 0.1", UnknownName, "HeadYaw"),
    ],
)
def test_bad_files_of_offsets_are_named(tmp_path: Path, text: str, error: type, says: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(text)
    with pytest.raises(error, match=says):
        nk.load_nao(offsets=path)


def test_commands_take_a_file_of_offsets(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    path = tmp_path / "mine.toml"
    path.write_text("[joints]\nHeadYaw = 0.01\n\n[frames]\nCameraTop = [0.001, 0, 0, 0, 0.02, 0]\n")
    mine = nk.load_nao(offsets=path)
    assert run(["fk", "--frame", "CameraTop", "--offsets", str(path), "--json", "--as", "matrix"]) == 0
    poses = json.loads(capsys.readouterr().out)["poses"]
    assert np.array_equal(poses["CameraTop"], mine.fk(mine.neutral(), "CameraTop"))
    assert run(["info", "--offsets", str(path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["load_notes"] == list(mine.load_notes)
    written = tmp_path / "out.urdf"
    assert run(["export", str(written), "--format", "urdf", "--offsets", str(path), "--meshes", "none"]) == 0
    again = nk.RobotModel.from_urdf(written)
    assert np.abs(again.fk(again.neutral(), "CameraTop") - mine.fk(mine.neutral(), "CameraTop")).max() < 1e-12
    path.write_text("[joints]\nHeadYaww = 0.01\n")
    capsys.readouterr()
    assert run(["joints", "--offsets", str(path)]) == 2
    assert "HeadYaww" in capsys.readouterr().err


def test_a_file_of_offsets_names_its_robot(nao: nk.NaoModel, tmp_path: Path) -> None:
    about = {"robot": "nao_v6", "rms_after": 0.9, "standard_deviations": {"HeadYaw offset": 0.002}}
    remarks = {"HeadYaw": "± 0.002", "HeadPitch": "not determined"}
    offsets = {"joints": {"HeadYaw": 0.01}, "frames": {"CameraTop": CAMERA}}
    path = nk.robot.write_offsets(tmp_path / "mine.toml", offsets, about=about, remarks=remarks)
    assert read_toml(path) == {"calibration": about, **offsets, "frames": {"CameraTop": list(CAMERA)}}
    lines = path.read_text(encoding="utf-8").splitlines()
    assert '"HeadYaw" = 0.01  # ± 0.002' in lines
    assert "# HeadPitch: not determined" in lines
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert nk.load_nao("v6", offsets=path).tree.offsets
    for version in ("v4", "v5"):
        with pytest.warns(OtherRobotWarning, match=f"found for nao_v6, and this robot is nao_{version}"):
            nk.load_nao(version, offsets=path)


# --- Offsets that no calibration finds.


@pytest.mark.parametrize(
    ("joints", "frames", "category", "named"),
    [
        ({"HeadYaw": 2.5}, {}, DegreesWarning, "HeadYaw by 143°"),
        ({}, {"CameraTop": nk.screws.pose(matrix_from_rpy([0.0, 0.3, 0.0]), [0.0] * 3)}, DegreesWarning, "by 17.2°"),
        ({}, {"CameraTop": (3.0, 2.0, 1.0, 0.0, 0.0, 0.0)}, NaoKinWarning, "CameraTop by 3.74 m"),
        ({"HeadYaw": 0.3}, {"CameraTop": (0.2, 0, 0, 0, 0, 0)}, DegreesWarning, "HeadYaw by 17.2°, CameraTop by 0.2 m"),
    ],
)
def test_large_offsets_are_accepted_with_one_warning(
    nao: nk.NaoModel,
    joints: dict[str, float],
    frames: dict[str, object],
    category: type[NaoKinWarning],
    named: str,
    tmp_path: Path,
) -> None:
    with pytest.warns(category, match=named) as caught:
        nao.with_offsets(joints, frames)  # type: ignore[arg-type]
    assert [warning.category for warning in caught] == [category]
    path = nk.robot.write_offsets(tmp_path / "mine.toml", {"joints": joints})
    if joints:
        with pytest.warns(DegreesWarning):
            nk.load_nao(offsets=path)


def test_offsets_of_calibrations_give_no_warning(nao: nk.NaoModel) -> None:
    nao.with_offsets({"HeadYaw": 0.2, "LKneePitch": -0.199}, {"CameraTop": (0.05, -0.05, 0.05, 0.19, -0.1, 0.1)})


@pytest.mark.parametrize(
    ("joints", "frames"),
    [({"HeadYaw": -3.2}, {}), ({}, {"CameraTop": (0.0, 0.0, 0.0, 0.0, 1.2, 20.0)})],
)
def test_more_than_half_a_turn_is_no_offset(
    nao: nk.NaoModel, joints: dict[str, float], frames: dict[str, tuple[float, ...]]
) -> None:
    with pytest.raises(BadArgument, match=r"half a turn.*offsets are in rad"):
        nao.with_offsets(joints, frames)


def test_a_slide_far_off_is_named_in_metres(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("lift", kind="prismatic", limits=(0.0, 1.0)), J("turn"))
    with pytest.warns(NaoKinWarning, match=r"lift by 4\b.* m") as caught:
        robot.with_offsets({"lift": 4.0})
    assert not issubclass(caught[0].category, DegreesWarning)


def test_offsets_found_for_another_robot_are_doubted(nao: nk.NaoModel) -> None:
    with pytest.warns(nk.errors.OtherRobotWarning, match="nao_v5"):
        mine = nao.with_offsets({"HeadYaw": 0.01}, found_for="nao_v5")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        own = nao.with_offsets({"HeadYaw": 0.01}, found_for=nao.name)
    assert np.array_equal(own.fk(nao.neutral()), mine.fk(nao.neutral()))
