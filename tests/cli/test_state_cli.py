"""`nao-kin state`, as people use it: logs with and without sensors, a motion, and wrong words."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import partial
from pathlib import Path

import command_line
import numpy as np
import pytest
from command_line import Capture

import nao_kin as nk
from nao_kin.cli.app import run
from nao_kin.rotations import rpy_from_matrix

MEASURED = ("left", "right", "gx", "gy", "gz")

said = partial(command_line.said_with_notes, "state")
refused = partial(command_line.refused, "state")


def rows(capsys: Capture, path: str, *arguments: str) -> tuple[Mapping[str, np.ndarray], str]:
    """Return the columns that the command writes, and its notes."""
    out = Path(path).with_suffix(".npz")
    _, notes = said(capsys, path, *arguments, "-o", str(out), "--force")
    return np.load(out), notes


def walk(nao: nk.NaoModel) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return times, configurations that lift one foot after the other, forces, and the values of a gyrometer."""
    times = 0.02 * np.arange(60)
    swing = 0.3 * np.sin(5.0 * times)
    q = np.tile(nao.posture("StandInit"), (60, 1))
    for name, sign in (("LKneePitch", 1.0), ("RKneePitch", -1.0)):
        q[:, nao.joint_names.index(name)] += np.maximum(sign * swing, 0.0)
    left = np.cos(5.0 * times) > 0.0
    gyro = 0.1 + 0.01 * np.sin(times[:, None] + np.arange(3.0))
    measured = np.column_stack([5.4 * left, 5.4 * ~left, gyro])
    return times, q, measured


def log(path: Path, nao: nk.NaoModel, *, more: bool = True) -> str:
    times, q, measured = walk(nao)
    head = ("time", *nao.joint_names, *(MEASURED if more else ()))
    rows = np.column_stack([times, q, measured] if more else [times, q])
    path.write_text("".join(",".join(map(str, row)) + "\n" for row in (head, *rows.tolist())))
    return str(path)


def assert_is(table: Mapping[str, np.ndarray], found: nk.world.State, *, degrees: bool = False) -> None:
    """The rows are this trajectory, to 12 digits."""
    angles = rpy_from_matrix(found.T_world_base[:, :3, :3])
    wanted = np.column_stack([found.times, found.T_world_base[:, :3, 3], np.degrees(angles) if degrees else angles])
    names = ("time", "x", "y", "z", *(f"{name}{'_deg' * degrees}" for name in ("roll", "pitch", "yaw")))
    np.testing.assert_allclose(np.column_stack([table[name] for name in names]), wanted, rtol=1e-12, atol=1e-12)
    assert table["support"].tolist() == found.support.tolist()


def test_a_log_of_joints_gives_the_trajectory(capsys: Capture, tmp_path: Path, nao: nk.NaoModel) -> None:
    times, q, _ = walk(nao)
    path = log(tmp_path / "log.csv", nao, more=False)
    found = nk.world.state(nao, q, times)
    assert len(set(found.support.tolist())) == 3
    assert_is(rows(capsys, path)[0], found)
    assert_is(rows(capsys, path, "--sole", "RLeg")[0], nk.world.state(nao, q, times, soles=["RLeg"]))


def test_a_posture_gives_the_joints_that_a_motion_does_not_name(
    capsys: Capture, tmp_path: Path, nao: nk.NaoModel
) -> None:
    motion = nk.Motion([0.0, 1.0, 2.0], ["LKneePitch", "RKneePitch"], [[0.1, 0.1], [0.3, 0.1], [0.1, 0.3]])
    file = str(tmp_path / "steps.json")
    nk.motion.write_motion(motion, file)
    found = []
    for more, missing in (((), "StandInit"), (("--posture", "Stand"), "Stand")):
        trajectory = motion.configurations(nao, rate=10.0, missing=missing)
        found.append(rows(capsys, file, "--rate", "10", *more)[0])
        assert_is(found[-1], nk.world.state(nao, trajectory.q, trajectory.times))
    assert not np.allclose(found[0]["x"], found[1]["x"])


def columns(**names: str) -> list[str]:
    """Return the words that say what columns of other names are."""
    return [word for name, heading in names.items() for word in ("--columns", f"{name}={heading}")]


def test_forces_contacts_and_gyrometer_are_columns_of_the_log(
    capsys: Capture, tmp_path: Path, nao: nk.NaoModel
) -> None:
    times, q, measured = walk(nao)
    path = log(tmp_path / "log.csv", nao)
    feet, gyro = measured[:, :2], measured[:, 2:]
    out, err = rows(capsys, path, *columns(left="LFsr", right="RFsr"), "--ignore-other")
    assert_is(out, nk.world.state(nao, q, times, forces=feet))
    assert "columns of sensors, by their names: forces left, right\n" in err
    turning = columns(gx="GyroX", gy="GyroY", gz="GyroZ")
    for names, given in ((("left", "right"), feet), (("right", "left"), feet[:, ::-1])):
        soles = dict(zip(names, ("LLeg/Contact", "RLeg/Contact"), strict=True))
        out, err = rows(capsys, path, *columns(**soles), *turning)
        assert_is(out, nk.world.state(nao, q, times, contacts=given, gyro=gyro))
        assert f"contacts {', '.join(names)}" in err


# --- Logs of some joints, with sensors in other columns and in other units.

SENSORS = ("LFsr", "RFsr", "AngleX [deg]", "AngleY [deg]", "GyroX [deg/s]", "GyroY [deg/s]", "GyroZ [deg/s]")


def sensor_log(path: Path, nao: nk.NaoModel, joints: list[str], *, empty: int | None = None) -> tuple[str, dict]:
    """Write a log of some joints with sensors; return its name and the arguments of `state`."""
    times, q, measured = walk(nao)
    rng = np.random.default_rng(0)
    angles, gyro = rng.normal(0.0, 0.01, (60, 2)), rng.normal(0.0, 0.05, (60, 3))
    forces = np.where(measured[:, :2] > 0.0, 4.0, 0.5)
    columns = [nao.joint_names.index(name) for name in joints]
    rows = np.column_stack([times, q[:, columns], forces, np.degrees(angles), np.degrees(gyro)]).tolist()
    if empty is not None:
        rows[empty][1 + joints.index("LKneePitch")] = ""
    path.write_text("".join(",".join(map(str, row)) + "\n" for row in (("time", *joints, *SENSORS), *rows)))
    return str(path), {"q": q, "times": times, "forces": forces, "angles": angles, "gyro": gyro}


def legs_of(nao: nk.NaoModel) -> list[str]:
    return [name for name in nao.joint_names if any(part in name for part in ("Hip", "Knee", "Ankle"))]


def test_a_log_of_the_legs_is_enough_and_of_the_head_needs_the_others(
    capsys: Capture, tmp_path: Path, nao: nk.NaoModel
) -> None:
    path, given = sensor_log(tmp_path / "legs.csv", nao, legs_of(nao))
    wanted = nk.world.state(nao, **given)
    assert_is(rows(capsys, path)[0], wanted)
    assert_is(rows(capsys, path, "--missing", "Stand")[0], wanted)
    head, given = sensor_log(tmp_path / "head.csv", nao, ["HeadYaw"])
    says = refused(capsys, head)
    assert "missing joints: HeadPitch, LHipYawPitch" in says
    assert "(--missing) gives their values" in says
    q = np.tile(nao.posture("StandInit"), (60, 1))
    still = nk.world.state(nao, **given | {"q": q})
    assert_is(rows(capsys, head, "--missing", "StandInit")[0], still)


def test_a_row_without_a_value_of_a_leg_has_no_pose(capsys: Capture, tmp_path: Path, nao: nk.NaoModel) -> None:
    path, _ = sensor_log(tmp_path / "legs.csv", nao, legs_of(nao), empty=20)
    for missing in ((), ("--missing", "Crouch")):
        table, _ = rows(capsys, path, *missing)
        assert np.flatnonzero(np.isnan(table["x"])).tolist() == [20]
        assert json.loads(said(capsys, path, *missing, "--json")[0])["segments"] == 1
    gaps = json.loads(said(capsys, path, "--json", "--longest-gap", "0.03")[0])
    assert gaps["segments"] == 2
    assert run(["state", path, "--longest-gap", "-1"]) == 2
    assert "longest_gap must be a number" in capsys.readouterr().err


def test_the_state_is_summed_up_and_written_in_every_format(capsys: Capture, tmp_path: Path, nao: nk.NaoModel) -> None:
    path, given = sensor_log(tmp_path / "legs.csv", nao, legs_of(nao), empty=20)
    given["q"][20, nao.joint_names.index("LKneePitch")] = np.nan
    wanted = nk.world.state(nao, given.pop("q"), **given)
    summary = json.loads(said(capsys, path, "--json")[0])
    assert summary["seconds"] == pytest.approx(wanted.seconds)
    assert summary["steps"] == wanted.odometry.steps.sum() > 0
    assert summary["distance"] == pytest.approx(wanted.odometry.distance, abs=1e-12)
    assert (summary["segments"], summary["rows"], summary["valid_rows"]) == (1, 60, 59)
    table, _ = said(capsys, path)
    assert "standing" in table
    assert f"{wanted.odometry.distance:.3f} m" in table
    files = {ending: tmp_path / f"state{ending}" for ending in (".csv", ".npz", ".parquet", ".feather")}
    for out in files.values():
        assert said(capsys, path, "-o", str(out))[0].startswith(f"{out}\n")
    archive = np.load(files[".npz"])
    assert archive["doing"].tolist() == wanted.doing.tolist()
    assert archive["roll"] == pytest.approx(wanted.roll_pitch[:, 0], abs=1e-12)
    T = wanted.T_world_base
    assert np.allclose(archive["z"], T[:, 2, 3], rtol=0.0, atol=1e-12, equal_nan=True)
    variances = [*wanted.odometry.covariance.diagonal(0, 1, 2).T, *wanted.covariance.diagonal(0, 1, 2).T]
    for name, variance in zip(("x", "y", "yaw", "roll", "pitch", "z"), variances, strict=True):
        assert np.allclose(archive[f"sigma_{name}"] ** 2, variance, equal_nan=True), name
    for name, speed in zip(("vx", "vy", "vyaw"), wanted.odometry.velocity.T, strict=True):
        assert np.allclose(archive[name], speed, equal_nan=True), name
    head, *lines = files[".csv"].read_text().splitlines()
    assert head == ",".join(archive.files)
    assert "RLeg_force" in head
    x = [line.split(",")[archive.files.index("x")] for line in lines]
    assert [float(text or "nan") for text in x] == pytest.approx(T[:, 0, 3], abs=1e-12, nan_ok=True)
    assert lines[20].count(",,") > 5
    from pyarrow import feather, parquet

    for read, ending in ((parquet.read_table, ".parquet"), (feather.read_table, ".feather")):
        columns = read(files[ending])
        assert columns.column_names == archive.files
        assert columns.column("support").to_pylist() == wanted.support.tolist()
    degrees = json.loads(said(capsys, path, "--json", "-o", str(tmp_path / "more.npz"))[0])
    assert degrees["units"]["angle"] == "rad"


def test_wrong_words_of_state_are_refused_in_one_line(capsys: Capture, tmp_path: Path, nao: nk.NaoModel) -> None:
    path, _ = sensor_log(tmp_path / "legs.csv", nao, legs_of(nao))
    assert "LFot" in refused(capsys, path, "--sole", "LFot")
    (tmp_path / "untimed.csv").write_text(",".join(nao.joint_names) + "\n" + ",".join(["0.0"] * 25) + "\n")
    assert "no column of times" in refused(capsys, str(tmp_path / "untimed.csv"))
    assert "the ending names the format" in refused(capsys, path, "-o", str(tmp_path / "state.txt"))
    assert not (tmp_path / "state.txt").exists()
    text = (tmp_path / "legs.csv").read_text().replace("GyroX [deg/s]", "GyroX [rpm]")
    (tmp_path / "rpm.csv").write_text(text)
    says = refused(capsys, str(tmp_path / "rpm.csv"))
    assert "unit 'rpm' of GyroX [rpm], expected one of rad/s, deg/s, °/s" in says
    assert "line 1" in says
    assert "Example: nao-kin state" in said(capsys, "--help")[0]


def test_a_gyrometer_in_degrees_without_a_unit_is_noted(capsys: Capture, tmp_path: Path, nao: nk.NaoModel) -> None:
    sensor_log(tmp_path / "legs.csv", nao, legs_of(nao))
    text = (tmp_path / "legs.csv").read_text().replace(" [deg/s]", "")
    (tmp_path / "plain.csv").write_text(text)
    assert "are these deg/s? A heading such as GyroX [deg/s] says so" in said(capsys, str(tmp_path / "plain.csv"))[1]


# --- Sensors that the headings of a log name.

PLACES = ("FrontLeft", "FrontRight", "RearLeft", "RearRight")
KEYS = {
    "forces": [f"{side}Foot/FSR/{place}" for side in "LR" for place in PLACES],
    "angles": ["AngleX", "AngleY"],
    "gyro": ["GyroscopeX", "GyroscopeY", "GyroscopeZ"],
    "accelerometer": ["AccelerometerX", "AccelerometerY", "AccelerometerZ"],
}  # fmt: skip


def almemory_log(path: Path, nao: nk.NaoModel, *, inertial: str = "InertialSensor/", short: bool = False) -> dict:
    """Write a log with the keys of ALMemory in a mixed order; return the arguments of `state`."""
    times, q, measured = walk(nao)
    rng = np.random.default_rng(1)
    given = {
        "forces": np.repeat(np.where(measured[:, :2] > 0.0, 1.2, 0.1), 4, axis=1) + rng.normal(0.0, 0.02, (60, 8)),
        "angles": rng.normal(0.0, 0.01, (60, 2)),
        "gyro": rng.normal(0.0, 0.05, (60, 3)),
        "accelerometer": rng.normal((0.0, 0.0, 9.8), 0.1, (60, 3)),
    }
    columns = {
        (name if short else f"Device/SubDeviceList/{'' if what == 'forces' else inertial}{name}/Sensor/Value"): column
        for what, names in KEYS.items()
        for name, column in zip(names, given[what].T, strict=True)
    }
    columns = dict(sorted(columns.items(), key=lambda column: column[0][::-1]))
    joints = {f"Device/SubDeviceList/{name}/Position/Sensor/Value": column
              for name, column in zip(nao.joint_names, q.T, strict=True)}  # fmt: skip
    columns |= {"timestamp": times} | joints
    if not short:
        columns["Device/SubDeviceList/HeadYaw/Temperature/Sensor/Value"] = np.full(60, 38.0)
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    path.write_text("".join(",".join(map(str, row)) + "\n" for row in (tuple(columns), *rows)))
    return {"q": q, "times": times, **given}


@pytest.mark.parametrize("short", [False, True])
def test_the_keys_of_almemory_are_found_without_an_option(
    capsys: Capture, tmp_path: Path, nao: nk.NaoModel, short: bool
) -> None:
    path, out = tmp_path / "almemory.csv", tmp_path / "state.npz"
    given = almemory_log(path, nao, short=short)
    accelerometer = given.pop("accelerometer")
    wanted = nk.world.state(nao, given.pop("q"), **given)
    _, err = said(capsys, str(path), "-o", str(out))
    order = [err.index(name) for name in KEYS["forces"] + KEYS["gyro"] + KEYS["angles"] + KEYS["accelerometer"]]
    assert order == sorted(order)
    assert err.index("left out") < order[-3]
    assert short or "HeadYaw/Temperature" in err
    found = np.load(out)
    assert found["roll"] == pytest.approx(wanted.roll_pitch[:, 0], abs=1e-12)
    assert found["LLeg_force"] == pytest.approx(wanted.forces[:, 0], abs=1e-12)
    assert found["x"] == pytest.approx(wanted.T_world_base[:, 0, 3], abs=1e-12)
    # Without a column of the angles the accelerometer is used.
    key = "AngleX" if short else "Device/SubDeviceList/InertialSensor/AngleX/Sensor/Value"
    _, err = said(capsys, str(path), "-o", str(out), "--force", "--columns", f"{key}=")
    assert err.index("accelerometer") < err.index("left out") < err.index("AngleY")
    del given["angles"]
    wanted = nk.world.state(nao, walk(nao)[1], accelerometer=accelerometer, **given)
    assert np.load(out)["roll"] == pytest.approx(wanted.roll_pitch[:, 0], abs=1e-12)


def test_odometry_takes_the_sums_on_the_soles_and_says_what_is_left_out(
    capsys: Capture, tmp_path: Path, nao: nk.NaoModel
) -> None:
    path, given = sensor_log(tmp_path / "legs.csv", nao, legs_of(nao))
    wanted = nk.world.state(nao, **given)
    out, err = rows(capsys, path)
    assert_is(out, wanted)
    assert "forces LFsr, RFsr; gyro GyroX [deg/s], GyroY" in err
    # A sole that is named is not the one that was measured.
    alone = nk.world.state(nao, soles=["RLeg"], **{name: given[name] for name in given if name != "forces"})
    out, err = rows(capsys, path, "--sole", "RLeg")
    assert_is(out, alone)
    assert "forces of each sole are not used with --sole" in err
    text = (
        (tmp_path / "legs.csv").read_text().replace("RFsr", "GyroX", 1).replace("GyroX [deg/s]", "RFoot/FSR/FrontLeft")
    )
    (tmp_path / "part.csv").write_text(text)
    _, err = rows(capsys, str(tmp_path / "part.csv"))
    assert "by their names: gyro GyroX," in err
    assert "columns left out: LFsr, RFoot/FSR/FrontLeft" in err


def test_a_sensor_in_two_columns_is_not_chosen(capsys: Capture, tmp_path: Path, nao: nk.NaoModel) -> None:
    path = tmp_path / "log.csv"
    almemory_log(path, nao)
    head, *lines = path.read_text().splitlines()
    key = "Device/SubDeviceList/InertialSensor/AngleX/Sensor/Value"
    path.write_text("\n".join([f"{head},AngleX", *(f"{line},0.5" for line in lines)]) + "\n")
    assert "angles" not in said(capsys, str(path))[1].partition("left out")[0]
    assert f"angles {key}," in said(capsys, str(path), "--columns", "AngleX=")[1]


def test_a_log_of_whole_configurations_may_be_checked_against_the_limits(
    capsys: Capture, tmp_path: Path, nao: nk.NaoModel
) -> None:
    times, q, _ = walk(nao)
    q[5, nao.joint_names.index("LElbowRoll")] = 0.2
    path = tmp_path / "log.csv"
    rows = np.column_stack([times, q]).tolist()
    path.write_text("".join(",".join(map(str, row)) + "\n" for row in (("time", *nao.joint_names), *rows)))
    plain, _ = said(capsys, str(path))
    says = refused(capsys, str(path), "--limits", "enforce")
    assert "line 7" in says
    assert "LElbowRoll = 0.2" in says
    assert run(["state", str(path), "--limits", "clamp"]) == 0
    out, err = capsys.readouterr()
    assert (out, "1 of 60 rows" in err) == (plain, True)


# --- Degrees that are printed are not those of the file.


def test_a_log_in_radians_is_the_same_walk_in_degrees(capsys: Capture, tmp_path: Path, nao: nk.NaoModel) -> None:
    path, out = log(tmp_path / "log.csv", nao, more=False), tmp_path / "state.npz"
    times, q, _ = walk(nao)
    assert_is(rows(capsys, path, "--deg")[0], nk.world.state(nao, q, times), degrees=True)
    words = (path, "--json", "-o", str(out), "--force")
    summary = [json.loads(said(capsys, *words, *more)[0]) for more in ((), ("--deg",))]
    assert summary[0]["distance"] == summary[1]["distance"] > 0.0
    assert np.load(out)["yaw_deg"] == pytest.approx(np.degrees(nk.world.state(nao, q, times=times).odometry.pose[:, 2]))
    # A file in degrees, with a gyrometer in degrees: the one option reads both.
    table = np.column_stack([times, np.degrees(q), np.full((60, 3), np.degrees(0.1))]).tolist()
    names = ("time", *nao.joint_names, "GyroX", "GyroY", "GyroZ")
    (tmp_path / "deg.csv").write_text("".join(",".join(map(str, row)) + "\n" for row in (names, *table)))
    assert_is(
        rows(capsys, str(tmp_path / "deg.csv"), "--file-deg")[0],
        nk.world.state(nao, q, times, gyro=np.full((60, 3), 0.1)),
    )
