"""Sensors in logs, found by the names that NAOqi, LoLA, ROS and other programs give them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin.cli.app import run
from nao_kin.errors import BadInputFile
from nao_kin.stream import read_log

ROWS = 40
TIMES = 0.02 * np.arange(ROWS)
RNG = np.random.default_rng(5)
LEFT = np.sin(7.0 * TIMES)[:, None] > 0.0
FORCES = np.where(np.repeat(np.hstack([LEFT, ~LEFT]), 4, axis=1), 1.3, 0.05) + RNG.normal(0.0, 0.01, (ROWS, 8))
GYRO = RNG.normal(0.0, 0.05, (ROWS, 3))
ANGLES = RNG.normal(0.0, 0.01, (ROWS, 2))
ACCELERATION = RNG.normal((0.0, 0.0, 9.8), 0.1, (ROWS, 3))
PLACES = ("FrontLeft", "FrontRight", "RearLeft", "RearRight")
ROS_PLACES = ("front_left", "front_right", "back_left", "back_right")

# Names of a program → those of forces, gyrometer, angles, accelerometer.
# NAOqi: doc.aldebaran.com/2-1/family/nao_dcm/actuator_sensor_names.html. LoLA: a record of a frame, with lists.
# PlotJuggler: messages of ros-sports/nao_lola (FSR, Gyroscope, Angle, Accelerometer) and sensor_msgs/Imu, the columns
# as PlotJuggler and rosbag tools write them. rUNSWift: its enumeration of sensors.
KEY = "Device/SubDeviceList/{}/Sensor/Value"
NAMES = {
    "NAOqi": (
        [KEY.format(f"{side}Foot/FSR/{place}") for side in "LR" for place in PLACES],
        [KEY.format(f"InertialSensor/Gyroscope{axis}") for axis in "XYZ"],
        [KEY.format(f"InertialSensor/Angle{axis}") for axis in "XY"],
        [KEY.format(f"InertialSensor/Accelerometer{axis}") for axis in "XYZ"],
    ),
    "short": (
        [f"{side}Foot/FSR/{place}" for side in "LR" for place in PLACES],
        [f"Gyro{axis}" for axis in "XYZ"],
        [f"Angle{axis}" for axis in "XY"],
        [f"Acc{axis}" for axis in "XYZ"],
    ),
    "LoLA": (
        [f"FSR[{k}]" for k in range(8)],
        [f"Gyroscope[{k}]" for k in range(3)],
        [f"Angles[{k}]" for k in range(2)],
        [f"Accelerometer[{k}]" for k in range(3)],
    ),
    "nao_lola": (
        [f"/sensors/fsr/{side}_foot_{place}" for side in "lr" for place in ROS_PLACES],
        [f"/sensors/gyroscope/{axis}" for axis in "xyz"],
        [f"/sensors/angle/{axis}" for axis in "xy"],
        [f"/sensors/accelerometer/{axis}" for axis in "xyz"],
    ),
    "Imu": (
        [f"/fsr/{side}_foot_{place}" for side in "lr" for place in ROS_PLACES],
        [f"/imu/torso/angular_velocity/{axis}" for axis in "xyz"],
        [],
        [f"/imu/torso/linear_acceleration/{axis}" for axis in "xyz"],
    ),
    "rosbag": (
        [],
        [f"angular_velocity.{axis}" for axis in "xyz"],
        [],
        [f"linear_acceleration.{axis}" for axis in "xyz"],
    ),
    "rUNSWift": (
        [f"{side}Foot_FSR_{place}" for side in "LR" for place in PLACES],
        [f"InertialSensor_Gyroscope{axis}" for axis in "XYZ"],
        [f"InertialSensor_Angle{axis}" for axis in "XY"],
        [f"InertialSensor_Accelerometer{axis}" for axis in "XYZ"],
    ),
}
KINDS = {"forces": FORCES, "gyro": GYRO, "angles": ANGLES, "accelerometer": ACCELERATION}


def walk(nao: nk.NaoModel) -> np.ndarray:
    q = np.tile(nao.posture("StandInit"), (ROWS, 1))
    q[:, nao.joint_names.index("LKneePitch")] += np.where(LEFT[:, 0], 0.0, 0.2)
    q[:, nao.joint_names.index("RKneePitch")] += np.where(LEFT[:, 0], 0.2, 0.0)
    return q


def table(nao: nk.NaoModel, names: tuple[list[str], ...], q: np.ndarray) -> dict[str, np.ndarray]:
    """Return the columns of a log: times, joints and sensors of some names."""
    joints = dict(zip(nao.joint_names, q.T, strict=True))
    topic = next(iter(names[0] or names[1])).startswith("/")
    columns = {"__time" if topic else "time": TIMES}
    columns |= {f"/joint_states/{name}/position" if topic else name: column for name, column in joints.items()}
    for headings, values in zip(names, KINDS.values(), strict=True):
        columns |= dict(zip(headings, values.T, strict=False))
    return columns


def write(path: Path, columns: dict[str, np.ndarray]) -> Path:
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    path.write_text("\n".join(",".join(map(str, row)) for row in (tuple(columns), *rows)) + "\n")
    return path


@pytest.mark.parametrize("program", list(NAMES))
def test_every_program_s_names_of_sensors_are_known(nao: nk.NaoModel, tmp_path: Path, program: str) -> None:
    names, q = NAMES[program], walk(nao)
    columns = table(nao, names, q)
    order = RNG.permutation(len(columns))
    log = read_log(nao, write(tmp_path / "log.csv", {list(columns)[k]: list(columns.values())[k] for k in order}))
    assert np.array_equal(log.q, q)
    expected = {kind: KINDS[kind] for kind, headings in zip(KINDS, names, strict=True) if headings}
    if "angles" in expected:  # the accelerometer is the second choice
        del expected["accelerometer"]
    assert log.sensors.keys() == expected.keys()
    for kind, values in expected.items():
        assert np.array_equal(log.sensors[kind], values), kind
    note = log.notes[0]
    assert note.startswith("columns of sensors, by their names: ")
    for kind, headings in zip(KINDS, names, strict=True):
        assert (f"{kind} {', '.join(headings)}" in note) == (kind in expected)
    assert ("columns left out: " in " ".join(log.notes)) == ("angles" in expected)


def test_the_state_of_a_log_is_two_lines(nao: nk.NaoModel, tmp_path: Path) -> None:
    q = walk(nao)
    log = read_log(nao, write(tmp_path / "log.csv", table(nao, NAMES["NAOqi"], q)))
    found = nk.world.state(nao, log.q, times=log.times, **log.sensors)
    wanted = nk.world.state(nao, q, times=TIMES, forces=FORCES, gyro=GYRO, angles=ANGLES)
    assert np.array_equal(found.T_world_base, wanted.T_world_base)
    assert found.notes == wanted.notes


def test_records_of_lola_with_times_are_a_log(nao: nk.NaoModel, tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    """One frame on each line, as a logger writes `decode_lola` with a time of its own."""
    q = walk(nao)
    lola = nk.naoqi.to_order(nao, q, "LoLA")
    frames = [
        {"time": TIMES[k], "Position": lola[k].tolist(), "FSR": FORCES[k].tolist(), "Gyroscope": GYRO[k].tolist()}
        | {"Angles": ANGLES[k].tolist(), "Accelerometer": ACCELERATION[k].tolist(), "Stiffness": [0.8] * 25}
        | {"Touch": [0.0] * 14, "RobotConfig": ["P0000073A07S94700012", "6.0.0", "P0000074A05S93M00061", "6.0.0"]}
        for k in range(ROWS)
    ]
    path = tmp_path / "lola.json"
    for text in ("\n".join(map(json.dumps, frames)), json.dumps(frames)):
        path.write_text(text)
        log = read_log(nao, path)
        assert np.array_equal(log.q, q)
        assert log.times.tolist() == TIMES.tolist()
        assert np.array_equal(log.sensors["forces"], FORCES)
        assert np.array_equal(log.sensors["angles"], ANGLES)
        assert "Stiffness[0]" in log.notes[1]
        assert "and 34 more" in log.notes[1]
    assert run(["state", str(path), "--json"]) == 0
    out, err = capsys.readouterr()
    wanted = nk.world.state(nao, q, times=TIMES, forces=FORCES, gyro=GYRO, angles=ANGLES)
    assert json.loads(out)["seconds"] == pytest.approx(wanted.seconds)
    assert "gyro Gyroscope[0]" in err


def test_a_message_with_vectors_is_a_row(nao: nk.NaoModel, tmp_path: Path) -> None:
    q = nao.posture("Stand")
    turning = {"angular_velocity": {"x": 0.1, "y": None, "z": -0.2}, "orientation_covariance": [0.0] * 9}
    (tmp_path / "one.json").write_text(json.dumps(nao.angles(q) | turning))
    log = read_log(nao, tmp_path / "one.json")
    assert log.sensors["gyro"].tolist() == [pytest.approx([0.1, np.nan, -0.2], nan_ok=True)]
    assert not log.many


def test_sums_and_contacts_of_soles_are_used_without_their_sensors(nao: nk.NaoModel, tmp_path: Path) -> None:
    q, feet = walk(nao), np.hstack([LEFT, ~LEFT]).astype(float)
    columns = {"time": TIMES, **dict(zip(nao.joint_names, q.T, strict=True))}
    sums = (("LFsr", "RFsr"), ("leftFootTotalWeight", "rightFootTotalWeight"), ("RFoot/FSR/TotalWeight",) * 2)
    for left, right in sums:
        right = right.replace("RFoot", "LFoot") if left == right else right
        log = read_log(nao, write(tmp_path / "sums.csv", columns | {left: 4.0 * feet[:, 0], right: 4.0 * feet[:, 1]}))
        wanted = 4.0 * feet[:, ::-1] if left.startswith("RFoot") else 4.0 * feet
        assert np.array_equal(log.sensors["forces"], wanted)
    touching = {"leftFootContact": feet[:, 0], "rightFootContact": feet[:, 1]}
    assert np.array_equal(read_log(nao, write(tmp_path / "a.csv", columns | touching)).sensors["contacts"], feet)
    # Eight sensors are preferred to their sums, and forces to contacts; what is not used is named.
    every = columns | touching | {"LFsr": TIMES, "RFsr": TIMES} | dict(zip(NAMES["short"][0], FORCES.T, strict=True))
    log = read_log(nao, write(tmp_path / "all.csv", every))
    assert log.sensors.keys() == {"forces"}
    assert np.array_equal(log.sensors["forces"], FORCES)
    assert log.notes[1] == "columns left out: leftFootContact, rightFootContact, LFsr, RFsr"


def test_columns_of_other_names_become_sensors(tmp_path: Path, nao: nk.NaoModel) -> None:
    q = walk(nao)
    columns = {"time": TIMES, **dict(zip(nao.joint_names, q.T, strict=True)), "links": TIMES, "rechts": 2.0 * TIMES}
    path = write(tmp_path / "log.csv", columns)
    with pytest.raises(BadInputFile, match="unknown joint 'links'"):
        read_log(nao, path)
    assert read_log(nao, path, ignore_other=True).sensors == {}
    log = read_log(nao, path, columns={"links": "LLeg/TotalWeight", "rechts": "RLeg/TotalWeight"})
    assert np.array_equal(log.sensors["forces"], np.column_stack([TIMES, 2.0 * TIMES]))
    # Another robot's force sensors are those of its semantics, its soles by their names.
    made_up(tmp_path, J("knee"))
    robot = nk.RobotModel.from_urdf(tmp_path / "robot.urdf", semantics=nk.semantics.Semantics(soles=("knee_l",)))
    path = write(tmp_path / "other.csv", {"time": TIMES, "knee": 0.0 * TIMES, "knee_l/Contact": LEFT[:, 0] * 1.0})
    assert np.array_equal(read_log(robot, path).sensors["contacts"], LEFT)


def test_units_empty_cells_and_degrees_of_sensors(nao: nk.NaoModel, tmp_path: Path) -> None:
    joints = {name: np.zeros(3) for name in nao.joint_names}
    turning = {"GyroX [deg/s]": np.array([90.0, 0.0, 0.0]), "GyroY [°/s]": np.ones(3), "GyroZ": np.ones(3)}
    path = write(tmp_path / "log.csv", {"time_ms": 12.0 * np.arange(3), **joints, **turning})
    text = path.read_text().splitlines()
    text[2] = text[2].rpartition(",")[0] + ","
    path.write_text("\n".join(text))
    log = read_log(nao, path, limits="ignore")
    assert log.times.tolist() == [0.0, 0.012, 0.024]
    assert log.sensors["gyro"][0] == pytest.approx([np.pi / 2, np.pi / 180, 1.0])
    assert np.isnan(log.sensors["gyro"][1]).tolist() == [False, False, True]
    assert read_log(nao, path, limits="ignore", degrees=True).sensors["gyro"][0, 2] == pytest.approx(np.pi / 180)
    path.write_text("\n".join(text).replace("[°/s]", "[rpm]"))
    with pytest.raises(BadInputFile, match=r"line 1, column 28: unit 'rpm' of GyroY \[rpm\], expected one of rad/s"):
        read_log(nao, path, limits="ignore")


def test_poses_of_a_log_need_no_option_for_its_sensors(nao: nk.NaoModel, tmp_path: Path) -> None:
    q = walk(nao)
    path = write(tmp_path / "log.csv", table(nao, NAMES["nao_lola"], q) | {"/sensors/sonar/left": TIMES})
    result = nk.stream.fk(nao, path, tmp_path / "poses.npy", frame="Head")
    assert np.allclose(np.load(tmp_path / "poses.npy"), nao.fk(q, "Head"), rtol=0.0, atol=1e-12)
    assert "/sensors/sonar/left" in result.notes[1]


def test_what_is_commanded_is_not_what_was_measured(nao: nk.NaoModel, tmp_path: Path) -> None:
    """nao_lola publishes the joints as lists; /effectors has the commands in a list of the same name."""
    q = walk(nao)
    lola = nk.naoqi.to_order(nao, q, "LoLA")
    columns = {"__time": TIMES}
    for topic, values in (("effectors", 0.0 * lola), ("sensors", lola)):
        columns |= {f"/{topic}/joint_positions/positions[{k}]": column for k, column in enumerate(values.T)}
    log = read_log(nao, write(tmp_path / "log.csv", columns))
    assert np.array_equal(log.q, q)
    assert "/effectors/joint_positions/positions[0]" in log.notes[0]


@pytest.mark.parametrize("heading", ["cmd_gyro_x", "target_angle_x", "LFoot", "FSR[8]", "Position[25]", "AngleQ"])
def test_what_only_looks_like_a_sensor_is_refused(nao: nk.NaoModel, tmp_path: Path, heading: str) -> None:
    columns = {"time": TIMES, **dict(zip(nao.joint_names, walk(nao).T, strict=True)), heading: TIMES}
    with pytest.raises(BadInputFile, match="unknown joint"):
        read_log(nao, write(tmp_path / "log.csv", columns))
