"""`nao-kin odometry`, as people use it: logs with and without forces, a motion, and wrong words."""

from __future__ import annotations

import io
import json
from functools import partial
from pathlib import Path

import command_line
import numpy as np
import pytest

import nao_kin as nk
from nao_kin.rotations import rpy_from_matrix

MEASURED = ("left", "right", "gx", "gy", "gz")


said = partial(command_line.said, "odometry")
refused = partial(command_line.refused, "odometry")


def walk(nao: nk.NaoModel) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return times, configurations that lift one foot after the other, forces, and the values of a gyrometer."""
    times = 0.02 * np.arange(60)
    swing = 0.3 * np.sin(5.0 * times)
    q = np.tile(nao.posture("StandInit"), (60, 1))
    for name, sign in (("LKneePitch", 1.0), ("RKneePitch", -1.0)):
        q[:, nao.joint_names.index(name)] += np.maximum(sign * swing, 0.0)
    measured = np.column_stack([np.cos(5.0 * times) > 0.0, np.cos(5.0 * times) <= 0.0, np.full((60, 3), 0.1)])
    return times, q, measured


def log(path: Path, nao: nk.NaoModel, *, more: bool = True) -> str:
    times, q, measured = walk(nao)
    head = ("time", *nao.joint_names, *(MEASURED if more else ()))
    rows = np.column_stack([times, q, measured] if more else [times, q])
    path.write_text("".join(",".join(map(str, row)) + "\n" for row in (head, *rows.tolist())))
    return str(path)


def assert_is(text: str, path: nk.world.Odometry, *, degrees: bool = False) -> None:
    """The CSV is this trajectory, to 12 digits."""
    angles = rpy_from_matrix(path.T_world_base[:, :3, :3])
    wanted = np.column_stack([path.times, path.T_world_base[:, :3, 3], np.degrees(angles) if degrees else angles])
    head, *rows = text.splitlines()
    assert head == ",".join(
        ["time,x,y,z", *(f"{name}{'_deg' * degrees}" for name in ("roll", "pitch", "yaw")), "support"]
    )
    np.testing.assert_allclose(
        np.loadtxt(io.StringIO("\n".join(rows)), delimiter=",", usecols=range(7)), wanted, rtol=1e-12, atol=1e-12
    )
    assert [row.rsplit(",", 1)[1] for row in rows] == [path.soles[k] for k in path.support]


def test_a_log_of_joints_gives_the_trajectory(capsys: pytest.CaptureFixture, tmp_path: Path, nao: nk.NaoModel) -> None:
    times, q, _ = walk(nao)
    path = log(tmp_path / "log.csv", nao, more=False)
    found = nk.world.odometry(nao, times, q)
    assert len(set(found.support.tolist())) == 2
    assert_is(said(capsys, path), found)
    assert_is(said(capsys, path, "--sole", "RLeg"), nk.world.odometry(nao, times, q, soles=["RLeg"]))
    document = json.loads(said(capsys, path, "--json"))
    assert document["units"] == {"length": "m", "angle": "rad"}
    assert len(document["rows"]) == 60
    assert document["rows"][-1]["x"] == pytest.approx(found.T_world_base[-1, 0, 3], abs=1e-12)
    assert document["rows"][-1]["support"] == found.soles[found.support[-1]]


def test_a_posture_gives_the_joints_that_a_motion_does_not_name(
    capsys: pytest.CaptureFixture, tmp_path: Path, nao: nk.NaoModel
) -> None:
    motion = nk.Motion([0.0, 1.0, 2.0], ["LKneePitch", "RKneePitch"], [[0.7, 0.7], [0.9, 0.7], [0.7, 0.9]])
    file = str(tmp_path / "steps.json")
    nk.motion.write_motion(motion, file)
    trajectory = motion.configurations(nao, rate=10.0, fill="Crouch")
    assert_is(
        said(capsys, file, "--posture", "Crouch", "--rate", "10"),
        nk.world.odometry(nao, trajectory.times, trajectory.q),
    )
    assert said(capsys, file, "--rate", "10") != said(capsys, file, "--rate", "10", "--posture", "Crouch")


def test_forces_contacts_and_gyrometer_are_columns_of_the_log(
    capsys: pytest.CaptureFixture, tmp_path: Path, nao: nk.NaoModel
) -> None:
    times, q, measured = walk(nao)
    path = log(tmp_path / "log.csv", nao)
    feet, gyro = measured[:, :2], measured[:, 2:]
    assert_is(
        said(capsys, path, "--forces", "left,right", "--ignore-other"), nk.world.odometry(nao, times, q, forces=feet)
    )
    for order, columns in (("left, right", feet), ("right,left", feet[:, ::-1])):
        wanted = nk.world.odometry(nao, times, q, contacts=columns, gyro=gyro)
        assert_is(said(capsys, path, "--contacts", order, "--gyro", "gx,gy,gz"), wanted)


def test_the_trajectory_is_written_to_a_file(capsys: pytest.CaptureFixture, tmp_path: Path, nao: nk.NaoModel) -> None:
    times, q, _ = walk(nao)
    path, out = log(tmp_path / "log.csv", nao, more=False), tmp_path / "path.csv"
    assert said(capsys, path, "-o", str(out)) == f"{out}\n"
    assert_is(out.read_text(), nk.world.odometry(nao, times, q))
    assert "exists" in refused(capsys, path, "-o", str(out))
    says = "a trajectory is written as CSV; end the name in .csv"
    assert says in refused(capsys, path, "-o", str(tmp_path / "path.npy"))
    assert not (tmp_path / "path.npy").exists()
    assert json.loads(said(capsys, path, "-o", str(out), "--force", "--json", "--deg"))["units"]["angle"] == "deg"
    assert_is(out.read_text(), nk.world.odometry(nao, times, np.radians(q)), degrees=True)


def test_wrong_words_are_refused_in_one_line(capsys: pytest.CaptureFixture, tmp_path: Path, nao: nk.NaoModel) -> None:
    path = log(tmp_path / "log.csv", nao)
    assert "unknown column 'lef'" in refused(capsys, path, "--forces", "lef,right")
    assert "not both" in refused(capsys, path, "--forces", "left,right", "--contacts", "left,right", "--ignore-other")
    assert "name a file instead of -" in refused(capsys, "-", "--gyro", "gx,gy,gz")
    assert "LFot" in refused(capsys, path, "--sole", "LFot", "--ignore-other")
    untimed = tmp_path / "untimed.csv"
    untimed.write_text(",".join(nao.joint_names) + "\n" + ",".join(["0.0"] * 25) + "\n")
    assert "no column of times" in refused(capsys, str(untimed))
    asked = json.dumps([1, 2])
    (tmp_path / "log.json").write_text(asked)
    assert "is JSON" in refused(capsys, str(tmp_path / "log.json"), "--gyro", "gx,gy,gz")
    assert "Example: nao-kin odometry" in said(capsys, "--help")
