from __future__ import annotations

import logging
import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin
import pytest
import yourdfpy
from loops import EACH_VERSION

import nao_kin as nk
from nao_kin.robot.nao.model import nao_urdf_path

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "scripts"))


ROS_NAMES = (
    "base_link torso Neck Head gaze LShoulder LBicep LElbow LForeArm l_wrist l_gripper LPelvis LHip LThigh LTibia "
    "LAnklePitch l_ankle l_sole RShoulder RBicep RElbow RForeArm r_wrist r_gripper RPelvis RHip RThigh RTibia "
    "RAnklePitch r_ankle r_sole CameraTop_frame CameraTop_optical_frame CameraBottom_frame "
    "CameraBottom_optical_frame ImuTorsoAccelerometer_frame ImuTorsoGyrometer_frame ChestButton_frame LSonar_frame "
    "RSonar_frame HeadTouchFront_frame HeadTouchMiddle_frame HeadTouchRear_frame LFootBumperLeft_frame "
    "RFootBumperRight_frame LFsrFL_frame LFsrFR_frame LFsrRL_frame LFsrRR_frame RFsrFL_frame RFsrFR_frame "
    "RFsrRL_frame RFsrRR_frame LHandTouchBack_frame LHandTouchLeft_frame LHandTouchRight_frame RHandTouchBack_frame "
    "LFinger11_link RThumb2_link "
).split()
NAOQI_NAMES = (
    "Head LArm RArm LLeg RLeg Torso LFoot RFoot CameraTop CameraBottom Gaze Accelerometer Gyrometer "
    "ChestBoard/Button Sonar/Left Sonar/Right Head/Touch/Front LFoot/Bumper/Left LFoot/FSR/FrontLeft "
    "RFoot/FSR/RearRight LFoot/Sole LHand/Touch/Back SpeakerLeft "
).split()


@pytest.fixture(params=EACH_VERSION)
def version(request: pytest.FixtureRequest) -> str:
    return request.param


@pytest.fixture
def document(version: str) -> ET.Element:
    return ET.parse(nao_urdf_path(version)).getroot()


def test_the_files_are_in_step_with_the_parameters() -> None:
    check = subprocess.run(
        [sys.executable, ROOT / "scripts/generate_urdf.py", "--check"], capture_output=True, text=True
    )
    assert check.returncode == 0, check.stderr


@pytest.mark.full
def test_check_notices_a_file_out_of_step(tmp_path: Path) -> None:
    script = [sys.executable, ROOT / "scripts/generate_urdf.py", "--output", tmp_path]
    assert subprocess.run(script, capture_output=True).returncode == 0
    path = tmp_path / "nao_v5.urdf"
    path.write_text(path.read_text().replace("0.1265", "0.1266"))
    check = subprocess.run([*script, "--check"], capture_output=True, text=True)
    assert check.returncode == 1
    assert "nao_v5.urdf" in check.stderr
    assert "nao_v6.urdf" not in check.stderr


def test_no_joint_shares_its_name_with_a_link(document: ET.Element) -> None:
    joints = [joint.get("name") for joint in document.findall("joint")]
    links = [link.get("name") for link in document.findall("link")]
    assert len(set(joints)) == len(joints)
    assert len(set(links)) == len(links)
    assert not set(joints) & set(links)


def test_no_joint_is_continuous_and_every_axis_is_a_unit_vector(document: ET.Element) -> None:
    for joint in document.findall("joint"):
        assert joint.get("type") in ("revolute", "fixed")
        if joint.get("type") == "revolute":
            axis = np.array(joint.find("axis").get("xyz").split(), dtype=float)
            assert np.linalg.norm(axis) == pytest.approx(1.0, abs=3e-16)


def test_pinocchio_reads_25_degrees_of_freedom_without_a_word(version: str, capfd: pytest.CaptureFixture) -> None:
    model = pin.buildModelFromUrdf(str(nao_urdf_path(version)), mimic=True)
    assert (model.nq, model.nv) == (25, 25)
    assert capfd.readouterr() == ("", "")


def test_yourdfpy_reads_it_without_a_warning(version: str, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        robot = yourdfpy.URDF.load(str(nao_urdf_path(version)))
    assert robot.num_dofs == 25
    assert caplog.records == []


@pytest.mark.skipif(shutil.which("check_urdf") is None, reason="check_urdf (Debian: liburdfdom-tools) is not installed")
def test_check_urdf_accepts_it(version: str) -> None:
    check = subprocess.run(["check_urdf", nao_urdf_path(version)], capture_output=True, text=True)
    assert check.returncode == 0
    assert "Successfully Parsed XML" in check.stdout
    assert check.stderr == ""


def test_frames_go_by_their_naoqi_and_their_ros_names(version: str) -> None:
    nao = nk.load_nao(version)
    missing = [name for name in (*ROS_NAMES, *NAOQI_NAMES) if name not in nao.frame_names]
    # The first hands have no touch sensors.
    assert missing == [
        name for name in (*ROS_NAMES, *NAOQI_NAMES) if version == "v3.2" and "Touch" in name and "Hand" in name
    ]


def test_the_two_names_of_a_place_are_one_place(nao: nk.NaoModel) -> None:
    pairs = [("LArm", "l_gripper"), ("RLeg", "r_sole"), ("CameraTop", "CameraTop_frame"), ("LFoot", "l_ankle")]
    for q in nao.random(0, 10):
        for ours, theirs in pairs:
            assert np.array_equal(nao.fk(q, ours), nao.fk(q, theirs))


def test_optical_frames_look_along_z_with_x_to_the_right_and_y_down(nao: nk.NaoModel) -> None:
    R = nao.rotation(nao.neutral(), "CameraTop_optical_frame", reference="CameraTop")
    assert np.allclose(R, [[0, 0, 1], [-1, 0, 0], [0, -1, 0]], atol=1e-15)


def test_the_hand_joint_opens_the_fingers_and_leaves_the_effector(nao: nk.NaoModel) -> None:
    for side in "LR":
        shut, open_ = nao.configuration({f"{side}Hand": 0.0}), nao.configuration({f"{side}Hand": 1.0})
        for frame in (f"{side}Arm", f"{side.lower()}_gripper", f"{side.lower()}_wrist"):
            assert np.array_equal(nao.fk(shut, frame), nao.fk(open_, frame))
        for finger in ("Finger11", "Finger12", "Finger13", "Finger21", "Finger22", "Finger23", "Thumb1", "Thumb2"):
            moved = nao.rotation(shut, f"{side}{finger}_link").T @ nao.rotation(open_, f"{side}{finger}_link")
            assert np.arccos((np.trace(moved) - 1) / 2) > 0.9


def test_open_fingers_are_straight(nao: nk.NaoModel) -> None:
    q = nao.configuration({"LHand": 1.0, "RHand": 1.0})
    for side in "LR":
        T = nao.fk(q, f"{side}Finger13_link", reference=f"{side}Finger11_link")
        assert np.allclose(T[:3, 3], [2 * 0.01436, 0, 0], atol=1e-12)
        assert np.allclose(T[:3, :3], np.eye(3), atol=1e-12)


def test_one_motor_turns_both_hips(nao: nk.NaoModel) -> None:
    q = nao.configuration({"LHipYawPitch": 0.3})
    left, right = nao.rotation(q, "LPelvis"), nao.rotation(q, "RPelvis")
    mirror = np.diag([1.0, -1.0, 1.0])
    assert np.allclose(left, mirror @ right @ mirror, atol=1e-15)
    # Positive values turn the toes inwards: the left foot's x axis points to the right, −y.
    assert left[1, 0] < 0 < right[1, 0]
