"""The file of one robot: lenses, sensors, version, and the calibrations of RoboCup teams."""

from __future__ import annotations

import json
import pickle
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import nao_kin as nk
from nao_kin._core.files import read_toml
from nao_kin.cli.app import run
from nao_kin.errors import BadArgument, BadInputFile, UnknownName

LENS = {
    "resolution": [640, 480],
    "fx": 558.0,
    "fy": 560.0,
    "cx": 317.0,
    "cy": 243.0,
    "distortion": [-0.1, 0.02, 0.0, 0.0],
}
MOUNTING, GYRO_BIAS, ACCELEROMETER_BIAS = (0.02, -0.05), (0.011, -0.017, 0.004), (0.1, 0.2, -0.3)
FILE = {
    "version": "v5",
    "body_id": "P0000073A06S8CP00054",
    "joints": {"HeadYaw": 0.01},
    "frames": {"CameraTop": [0.0, 0.0, 0.002, 0.0, 0.02, 0.0]},
    "cameras": {"CameraTop": LENS},
    "inertial_unit": {"mounting": MOUNTING, "gyro_bias": GYRO_BIAS, "accelerometer_bias": ACCELEROMETER_BIAS},
    "foot_sensors": {"LFoot/FSR/FrontLeft": [0.4, 1.1], "RFoot/FSR/RearRight": [-0.2, 0.9]},
}


@pytest.fixture
def path(tmp_path: Path) -> Path:
    remarks = {"lens of CameraTop": "± 1 pixel", "HeadYaw": "± 0.002"}
    return nk.robot.write_offsets(tmp_path / "robot.toml", FILE, about={"robot": "nao_v5"}, remarks=remarks)


def test_a_file_of_one_robot_is_written_and_read_again(path: Path) -> None:
    lens = [640, 480, 558.0, 560.0, 317.0, 243.0, -0.1, 0.02, 0.0, 0.0]
    read = nk.robot.read_offsets(path)
    assert read["cameras"] == {"CameraTop": lens}
    sensors = {**FILE["inertial_unit"], **FILE["foot_sensors"]}
    assert read["sensors"] == {name: list(values) for name, values in sensors.items()}
    assert (read["version"], read["body_id"], read["found_for"]) == ("v5", FILE["body_id"], "nao_v5")
    assert read_toml(path)["cameras"] == {"CameraTop": LENS}
    assert "# ± 1 pixel" in path.read_text()
    again = nk.robot.write_offsets(path.with_name("again.toml"), read, about={"robot": "nao_v5"})
    assert read_toml(again) == read_toml(path)


def test_the_version_of_a_file_is_that_of_the_robot(path: Path, capsys: pytest.CaptureFixture) -> None:
    mine = nk.load_nao(offsets=path)
    assert (mine.version, nk.load_nao("v5", offsets=path).version, nk.load_nao().version) == ("v5", "v5", "v6")
    assert "body P0000073A06S8CP00054" in mine.load_notes
    assert "camera CameraTop: a measured lens" in mine.load_notes
    assert "gyro_bias: 0.011, -0.017, 0.004" in mine.load_notes
    with pytest.raises(BadArgument, match="measured on a NAO v5, and this robot is nao_v6"):
        nk.load_nao("v6", offsets=path)
    with pytest.raises(BadArgument, match="measured on a NAO v4"):
        mine.with_offsets(version="v4", body_id="P")
    assert run(["info", "--offsets", str(path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["version"] == "v5"
    assert run(["info", "--nao", "v4", "--offsets", str(path)]) == 2
    assert "measured on a NAO v5" in capsys.readouterr().err


def test_a_camera_has_the_measured_lens_at_any_resolution(path: Path) -> None:
    mine, nominal = nk.load_nao(offsets=path), nk.load_nao("v5")
    vga, small = (nk.world.camera(mine, "CameraTop", size) for size in ("VGA", "QVGA"))
    assert (vga.fx, vga.fy, vga.cx, vga.cy, vga.distortion) == (558.0, 560.0, 317.0, 243.0, (-0.1, 0.02, 0.0, 0.0))
    assert small == vga.resized((320, 240))
    assert small.project([1.0, 0.2, 0.1]) == pytest.approx((vga.project([1.0, 0.2, 0.1]) + 0.5) / 2.0 - 0.5)
    bottom = nk.world.camera(mine, "CameraBottom")
    assert bottom == nk.world.camera(nominal, "CameraBottom")
    assert (vga.nominal, bottom.nominal) == (False, True)
    copy = pickle.loads(pickle.dumps(mine))
    assert nk.world.camera(copy, "CameraTop") == vga
    with pytest.raises(UnknownName, match="camera of nao_v5"):
        mine.with_offsets(cameras={"Camera": (640, 480, 558.0, 560.0, 317.0, 243.0)})
    lenses = nk.robot.read_offsets(path)["cameras"]
    assert nk.world.camera(nominal.with_offsets(cameras=lenses), "CameraTop") == vga
    # More offsets keep what was measured before.
    assert nk.world.camera(mine.with_offsets({"HeadYaw": 0.01}), "CameraTop") == vga


def test_sensors_of_a_robot_are_corrected_in_state_and_odometry(path: Path) -> None:
    """What a unit that is mounted askew and has biases reports is, with the file, what a perfect one reports."""
    mine, rng = nk.load_nao(offsets=path), np.random.default_rng(3)
    perfect = mine.with_offsets(
        sensors={"mounting": (0, 0), "gyro_bias": (0, 0, 0), "accelerometer_bias": (0, 0, 0)}
        | dict.fromkeys(FILE["foot_sensors"], (0.0, 1.0))
    )
    times = 0.02 * np.arange(300)
    q = np.tile(mine.posture("StandInit"), (300, 1)) + rng.normal(0.0, 0.001, (300, 25))
    tilt = Rotation.from_euler("yx", np.column_stack([0.05 * np.sin(times), 0.03 * np.cos(times)]))
    in_unit = Rotation.from_euler("YX", MOUNTING[::-1])  # the root link in the axes of the unit
    up, turning = tilt.inv().apply([0.0, 0.0, 9.81]), rng.normal(0.0, 0.1, (300, 3))
    # 0.7 kg on each sensor.
    forces = np.full((300, 8), 0.7) + rng.normal(0.0, 0.01, (300, 8))
    names, reported = mine.semantics.force_sensors, forces.copy()
    for name, (zero, gain) in FILE["foot_sensors"].items():
        reported[:, names.index(name)] = forces[:, names.index(name)] / gain + zero
    unit = tilt * in_unit.inv()
    yaw, pitch, roll = unit.as_euler("ZYX").T
    assert np.abs(yaw).max() < 0.01
    true = tilt.as_euler("ZYX")[:, ::-1]
    for given, wanted in (
        ({"angles": np.column_stack([roll, pitch])}, {"angles": true[:, :2]}),
        ({"accelerometer": in_unit.apply(up) + ACCELEROMETER_BIAS}, {"accelerometer": up}),
    ):
        gyro = in_unit.apply(turning) + GYRO_BIAS
        found = nk.world.state(mine, q, times=times, forces=reported, gyro=gyro, **given)
        expected = nk.world.state(perfect, q, times=times, forces=forces, gyro=turning, **wanted)
        assert np.allclose(found.up, expected.up, rtol=0.0, atol=2e-3 if "angles" in given else 1e-9)
        assert np.allclose(found.forces, expected.forces, rtol=0.0, atol=1e-12)
        assert found.notes == expected.notes
    walked = nk.world.odometry(mine, q, times, forces=reported, gyro=in_unit.apply(turning) + GYRO_BIAS)
    assert np.allclose(
        walked.T_world_base, nk.world.odometry(perfect, q, times, forces=forces, gyro=turning).T_world_base
    )
    blank = np.column_stack([roll, pitch])
    blank[:10] = np.nan
    assert np.isnan(nk.world.state(mine, q, times=times, angles=blank, longest_gap=0.05).up[0]).all()


def test_an_offset_of_the_motor_of_both_hips_turns_both_legs(nao: nk.NaoModel) -> None:
    """HULKs' body P0000073A19S31T00003 has one number for both legs."""
    q = nao.posture("Stand")
    both = nao.with_offsets({"LHipYawPitch": 0.1})
    moved = nao.configuration(nao.angles(q) | {"LHipYawPitch": 0.1 + nao.angles(q)["LHipYawPitch"]}, hips="left")
    for foot in ("LLeg", "RLeg"):
        assert np.allclose(both.fk(q, foot), nao.fk(moved, foot), rtol=0.0, atol=1e-12)
    assert "RHipYawPitch: the offset of the motor that moves them, too" in both.load_notes
    left = nao.with_offsets({"LHipYawPitch": 0.1, "RHipYawPitch": 0.0})
    assert np.allclose(left.fk(q, "RLeg"), nao.fk(q, "RLeg"), rtol=0.0, atol=1e-15)


# --- Files of teams. The camera's rotation is compared with the team's own product of rotations.

TOP_TILT = np.radians(1.2)


def rotation(path: Path, frame: str = "CameraTop") -> np.ndarray:
    robot = nk.load_nao("v6", offsets=path)
    return np.asarray(robot.fk(robot.neutral(), frame)[:3, :3])


def R(axes: str, *angles: float) -> np.ndarray:
    return np.asarray(Rotation.from_euler(axes, angles).as_matrix())


# torchipeppo/spqrnao2022-autonomous-calibration (B-Human 2021), NaoDevils/CodeRelease, and B-Human's names of before.
B_HUMAN = {
    "2021": """cameraRotationCorrections = {
  upper = {x = -0.344806deg; y = -2.73751deg; z = 0deg;};
  lower = {x = -0.122207deg; y = -1.83746deg; z = 0deg;};
};
bodyRotationCorrection = {x = 1.62013deg; y = 0.298351deg;};
""",
    "2016": """lowerCameraRotationCorrection = {
  x = -0.1deg;
  y = -5.4deg;
  z = 0deg;
};
upperCameraRotationCorrection = {
  x = 0.1deg;
  y = -6.0deg;
  z = 0.5deg;
};
bodyRotationCorrection = { // roll and pitch
  x = 0.7deg;
  y = 1.4deg;
};
""",
    "2013": """lowerCameraTiltCorrection = 0;
lowerCameraRollCorrection = 0;
lowerCameraPanCorrection = 0;
upperCameraRollCorrection = 0.01;
upperCameraTiltCorrection = -0.05;
upperCameraPanCorrection = 0.02;
bodyTiltCorrection = 0.03;
bodyRollCorrection = 0;
bodyTranslationCorrection = {x = 0; y = 0; z = 0;};
colorTemperature = default;
""",
}


@pytest.mark.parametrize(
    ("year", "x", "y", "z", "body"),
    [
        ("2021", np.radians(-0.344806), np.radians(-2.73751), 0.0, np.radians([1.62013, 0.298351])),
        ("2016", np.radians(0.1), np.radians(-6.0), np.radians(0.5), np.radians([0.7, 1.4])),
        ("2013", 0.01, -0.05, 0.02, [0.0, 0.03]),
    ],
)
def test_camera_calibrations_of_b_human_are_read(
    tmp_path: Path, year: str, x: float, y: float, z: float, body: list[float]
) -> None:
    path = tmp_path / "cameraCalibration.cfg"
    path.write_text(B_HUMAN[year])
    theirs = R("Y", TOP_TILT + y) @ R("X", x) @ R("Z", z)
    assert rotation(path) == pytest.approx(theirs, abs=1e-6)
    assert nk.robot.read_offsets(path)["sensors"]["mounting"] == pytest.approx(body)


def test_joint_calibrations_of_b_human_are_read(tmp_path: Path, nao: nk.NaoModel) -> None:
    path = tmp_path / "jointCalibration.cfg"
    path.write_text(
        "joints = {\n  headYaw = {\n    offset = 1.5deg;\n    minAngle = -119.5deg;\n  };\n"
        "  lHand = {\n    offset = 0;\n  };\n  lHipYawPitch = { offset = -0.5deg; };\n"
        "  rHipYawPitch = { offset = 0deg; };\n};\n"
    )
    read = nk.robot.read_offsets(path)
    assert read == {
        "joints": {"HeadYaw": pytest.approx(-np.radians(1.5)), "LHipYawPitch": np.radians(0.5), "RHipYawPitch": 0.0},
        "frames": {},
    }
    q = nao.posture("Stand")
    assert np.allclose(nk.load_nao(offsets=path).fk(q, "RLeg"), nao.fk(q, "RLeg"), rtol=0.0, atol=1e-14)
    path.write_text("offsets = { headPitch = 2deg; };\n")  # B-Human since 2021
    assert nk.robot.read_offsets(path)["joints"] == {"HeadPitch": pytest.approx(-np.radians(2.0))}


# HULKs/hulk, etc/parameters: head.P0000074A10S41M00047.json, body.P0000073A19S31T00003.json;
# etc/configuration: head.P0000074A05S99M00009.json.
HULKS_HEAD = {
    "camera_matrix_parameters": {
        "calibration": {
            "correction_in_camera_top": [-0.013626644387841225, 0.08048115670681, 0.02839617989957333],
            "correction_in_robot": [-0.007559316232800484, -0.005503971595317125, -0.018711920827627185],
        },
        "vision_top": {"extrinsic_rotations": [-5.9292778968811035, -1.461201310157776, -1.0342803001403809]},
    },
    "player_number": "Five",
}


def test_calibrations_of_hulks_are_read(tmp_path: Path) -> None:
    path = tmp_path / "head.json"
    path.write_text(json.dumps(HULKS_HEAD))
    given = HULKS_HEAD["camera_matrix_parameters"]
    C = R("xyz", *given["calibration"]["correction_in_camera_top"])
    E = R("xyz", *np.radians(given["vision_top"]["extrinsic_rotations"]))
    head_to_camera = C @ E @ R("x", TOP_TILT) @ R("y", -np.pi / 2) @ R("x", np.pi / 2)
    assert rotation(path, "CameraTop_optical_frame") == pytest.approx(head_to_camera.T, abs=1e-6)
    # An upright robot's torso is turned by the inverse of their correction in its axes.
    roll, pitch = nk.robot.read_offsets(path)["sensors"]["mounting"]
    up = R("xyz", *given["calibration"]["correction_in_robot"]) @ [0.0, 0.0, 1.0]
    assert pytest.approx(up, abs=1e-12) == (R("YX", pitch, roll).T @ [0.0, 0.0, 1.0])
    before = {"vision_top": {"camera_matrix_parameters": {"extrinsic_rotations": [0, -4.8, 0]}}, "player_number": "Two"}
    path.write_text(json.dumps(before))
    assert rotation(path) == pytest.approx(R("Y", TOP_TILT - np.radians(4.8)), abs=1e-6)
    hips = {"left_leg": {"hip_yaw_pitch": -0.2}, "right_leg": {"hip_yaw_pitch": -0.2}}
    path.write_text(json.dumps({"joint_calibration_offsets": hips | {"head": {"yaw": 0.01}}, "step_planner": {}}))
    joints = {"LHipYawPitch": 0.2, "RHipYawPitch": 0.2, "HeadYaw": -0.01}
    assert nk.robot.read_offsets(path)["joints"] == joints
    path.write_text(json.dumps({"parameters": {"joint_calibration_offsets_deg": {"left_arm": {"elbow_yaw": 2.0}}}}))
    assert nk.robot.read_offsets(path)["joints"] == {"LElbowYaw": pytest.approx(-np.radians(2.0))}


def test_two_files_of_a_team_become_the_file_of_a_robot(tmp_path: Path) -> None:
    head, body = tmp_path / "cameraCalibration.cfg", tmp_path / "jointCalibration.cfg"
    head.write_text(B_HUMAN["2021"])
    body.write_text("joints = { headYaw = { offset = 1deg; }; };\n")
    cameras, joints = (nk.robot.read_offsets(one) for one in (head, body))
    path = nk.robot.write_offsets(tmp_path / "robot.toml", cameras | {"joints": joints["joints"], "version": "v5"})
    mine = nk.load_nao(offsets=path)
    assert mine.version == "v5"
    assert (
        mine.tree.offsets.keys()
        == nk.load_nao("v5", offsets=cameras | {"joints": joints["joints"]}).tree.offsets.keys()
    )


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('{"camera_matrix_parameters": {"vision_top": {"extrinsic_rotations": [-3, 0, 0]}}}', 'an empty "calibration"'),
        ('{"step_planner": {}}', "no offsets of joints or cameras"),
        ("walkSpeed = 3;\n", "no offsets of joints or cameras"),
        ('{"vision_top": [1]}', "not a calibration as B-Human or HULKs write it"),
        ("offsets = { headYaw = wide; };\n", "not a calibration as B-Human or HULKs write it: could not convert"),
        ("[cameras]\nCameraTop = {fx = 3.0}\n", "the lens of CameraTop must have resolution"),
        ("[inertial_unit]\nmounting = [0.1]\n", "mounting must be 2 numbers, got 1"),
        ('[foot_sensors]\n"LFoot/FSR/FrontLeft" = [0.1, -1.0]\n', "gain of LFoot/FSR/FrontLeft must be positive"),
        ("[inertial_unit]\ngyro = [0, 0, 0]\n", "unknown sensor of nao_v6 'gyro' (nearest: gyro_bias"),
        ("[inertial]\nmounting = [0, 0]\n", "unknown entry 'inertial' (nearest: inertial_unit)"),
        ('version = "v7"\n', "v7"),
    ],
)
def test_what_a_file_cannot_mean_is_refused(tmp_path: Path, text: str, says: str) -> None:
    path = tmp_path / "robot.toml"
    path.write_text(text)
    with pytest.raises((BadInputFile, BadArgument, UnknownName)) as refused:
        nk.load_nao(offsets=path)
    assert says in str(refused.value)
