"""A robot that runs, mirrored and recorded: robots in processes of their own, read over qi and LoLA."""

from __future__ import annotations

import io
import json
import re
import signal
import socket
import subprocess
import sys
import textwrap
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from viewer_pages import PATIENCE

import nao_kin as nk
from nao_kin.cli.app import run
from nao_kin.errors import BadArgument
from nao_kin.motion import read_motion
from nao_kin.naoqi import LolaSource, NaoqiSource, from_order, readings, recorded, vertical
from nao_kin.rotations import matrix_from_rpy

# Sends frames in which HeadYaw grows by 0.001 each, to whoever connects, as often as it is told to.
LOLA_ROBOT = """
    import os, socket, sys, time
    import numpy as np
    from nao_kin.naoqi import encode_lola
    path, count, times = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    if os.path.exists(path):
        os.remove(path)
    listener = socket.socket(socket.AF_UNIX)
    listener.bind(path)
    listener.listen()
    print("ready", flush=True)
    number = 0
    for _ in range(times):
        robot, _ = listener.accept()
        try:
            for _ in range(count):
                position = np.zeros(25)
                position[0] = 0.001 * number
                position[hands] = float("nan")
                robot.sendall(encode_lola({"Position": position, "Angles": [0.0, 0.5]}))
                number += 1
                if number == 100:
                    print("sent a hundred", flush=True)
                time.sleep(0.01)
            robot.setblocking(False)
            try:
                got = robot.recv(1)
                print("was sent something" if got else "left", flush=True)
            except BlockingIOError:
                print("was sent nothing", flush=True)
        except OSError:
            print("left", flush=True)
        robot.close()
"""

DEVICE, END = "Device/SubDeviceList/", "/Sensor/Value"


@contextmanager
def _lola_robot(
    folder: Path, count: int, times: int = 1, without: Sequence[int] = ()
) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """A robot without values of the joints of these numbers."""
    path = folder / "robocup"
    program = textwrap.dedent(LOLA_ROBOT).replace("[hands]", f"[{list(without)}]")
    command = [sys.executable, "-c", program, str(path), str(count), str(times)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "ready\n"
            yield str(path), process
        finally:
            process.kill()


@contextmanager
def _virtual_nao(port: int = 0) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    pytest.importorskip("qi")
    command = [sys.executable, "-m", "nao_kin", "serve", "--port", str(port), "--posture", "StandInit", "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            text = ""
            while not text.rstrip().endswith("}"):
                text += process.stdout.readline()
            yield json.loads(text)["endpoint"], process
        finally:
            process.kill()


def _live(*arguments: str) -> subprocess.CompletedProcess[str]:
    with redirect_stdout(io.StringIO()) as out, redirect_stderr(io.StringIO()) as err:
        code = run(["live", "--no-view", *arguments])
    return subprocess.CompletedProcess(arguments, code, out.getvalue(), err.getvalue())


def test_the_frames_of_a_nao6_become_configurations(nao: nk.NaoModel, short_folder: Path) -> None:
    with _lola_robot(short_folder, 5) as (path, process):
        found = []
        for reading in readings(LolaSource(path), nao, rate=1e6, wanted=lambda: len(found) < 5):
            found.append(reading)
        assert process.stdout is not None
        process.wait(PATIENCE)
        assert process.stdout.readline() in ("left\n", "was sent nothing\n")
    values = [nao.angles(reading.q)["HeadYaw"] for reading in found]
    assert values == pytest.approx([0.0, 0.001, 0.002, 0.003, 0.004], abs=1e-8)
    times = np.array([reading.time for reading in found])
    assert times[0] == 0.0
    assert (np.diff(times) > 0.0).all()
    up = found[0].up
    assert up is not None
    assert up == pytest.approx([-np.sin(0.5), 0.0, np.cos(0.5)], abs=1e-7)
    # What the frames have of forces, angles and gyrometer feeds the estimator.
    estimator = nk.world.StateEstimator(nao)
    now = [estimator.update(reading.q, reading.time, **reading.sensors) for reading in found][-1]
    assert {"angles"} <= set(found[0].sensors) <= {"forces", "angles", "gyro"}
    assert now.up[0] == pytest.approx(up, abs=1e-7)


def test_a_robot_that_is_lost_is_found_again(nao: nk.NaoModel, short_folder: Path) -> None:
    lines: list[str] = []
    with _lola_robot(short_folder, 3, times=2) as (path, _):
        found: list[float] = []
        source = LolaSource(path)
        for reading in readings(source, nao, rate=1e6, wanted=lambda: len(found) < 6, on_state=lines.append):
            found.append(float(reading.q[nao.joint_names.index("HeadYaw")]))
    assert found == pytest.approx(0.001 * np.arange(6), abs=1e-8)
    assert [line.split()[0] for line in lines] == ["connected", path, "connected"]
    assert "trying again" in lines[1]


def test_hands_without_a_sensor_do_not_hide_the_robot(nao: nk.NaoModel, short_folder: Path) -> None:
    names = nk.naoqi.BODY_ORDERS["LoLA"]
    hands = [names.index(name) for name in ("LHand", "RHand")]
    with _lola_robot(short_folder, 5, without=hands) as (path, _):
        found: list[nk.naoqi.JointReading] = []
        for reading in readings(LolaSource(path), nao, rate=1e6, wanted=lambda: len(found) < 3, missing="StandInit"):
            found.append(reading)
    for row, yaw in zip(found, (0.0, 0.001, 0.002), strict=True):
        angles = nao.angles(row.q)
        assert angles["LHand"] == angles["RHand"] == 0.25
        assert angles["HeadYaw"] == pytest.approx(yaw, abs=1e-8)
    with _lola_robot(short_folder, 100, without=hands) as (path, _):
        done = _live("--lola", path, "--seconds", "0.2", "--missing", "0.5", "--json")
        assert json.loads(done.stdout)["last"]["LHand"] == 0.5
    # Without a value for them the robot is not shown, and the reason is said.
    with _lola_robot(short_folder, 100, without=hands) as (path, _):
        done = _live("--lola", path, "--seconds", "0.2", "--json")
        assert done.returncode == 2
        assert "LHand" in done.stderr
        assert "missing" in done.stderr
    refused = _live("--lola", path, "--missing", "Sand")
    assert refused.returncode == 2
    assert "unknown posture 'Sand' (nearest: Stand" in refused.stderr


def test_no_more_readings_than_wanted(nao: nk.NaoModel, short_folder: Path) -> None:
    with _lola_robot(short_folder, 40) as (path, _):
        found = []
        for reading in readings(LolaSource(path), nao, rate=20.0, wanted=lambda: len(found) < 4):
            found.append(reading.time)
    assert (np.diff(found) >= 0.05 - 1e-3).all()


def test_a_virtual_nao_is_mirrored_as_it_moves(nao: nk.NaoModel) -> None:
    qi = pytest.importorskip("qi")
    with _virtual_nao() as (endpoint, _):
        session = qi.Session()
        session.connect(endpoint)
        motion = session.service("ALMotion")
        motion.setStiffnesses("Head", 1.0)
        motion.setAngles("HeadYaw", 0.5, 0.1)
        found = []
        end = time.monotonic() + PATIENCE

        def wanted() -> bool:
            return time.monotonic() < end and (not found or found[-1].q[0] < 0.5)

        for reading in readings(NaoqiSource(endpoint), nao, rate=50.0, wanted=wanted):
            found.append(reading)
        yaw = np.array([reading.q[nao.joint_names.index("HeadYaw")] for reading in found])
        session.close()
    assert yaw[-1] == pytest.approx(0.5, abs=1e-6)
    assert (np.diff(yaw) >= 0.0).all()
    assert ((yaw > 0.0) & (yaw < 0.5)).sum() > 5
    still = from_order(nao, nao.to_body(nao.posture("StandInit")), "H25")
    assert found[-1].q[2:] == pytest.approx(still[2:], abs=1e-6)
    # In StandInit the hip, knee and ankle add up to −0.1: on level soles the torso leans forward by as much.
    assert found[-1].up == pytest.approx([-np.sin(0.1), 0.0, np.cos(0.1)], abs=1e-6)


def test_naoqi_gives_all_sensors_that_a_robot_has(nao: nk.NaoModel, monkeypatch: pytest.MonkeyPatch) -> None:
    """Forces in the order of the robot, the gyrometer once it has shown anything, and None for what does not exist."""
    pytest.importorskip("qi")
    memory: dict[str, object] = {f"AngleX{END}": 0.1, f"AngleY{END}": 0.2}
    memory |= {f"{name}{END}": 0.1 * k for k, name in enumerate(nao.semantics.force_sensors)}
    source, body = NaoqiSource("nao.local"), nao.to_body(nao.posture("Stand")).tolist()
    source._motion = SimpleNamespace(getAngles=lambda *_, **__: body)
    listed = lambda keys, **_: [memory.get(key.removeprefix(DEVICE).removeprefix("InertialSensor/")) for key in keys]  # noqa: E731
    source._memory = SimpleNamespace(getListData=listed)
    monkeypatch.setattr(NaoqiSource, "_answer", lambda _, value: value)
    source.read(nao)
    assert set(source.sensors) == {"angles", "forces"}
    assert source.sensors["forces"] == pytest.approx(0.1 * np.arange(8))
    for gyro in (0.0, 0.3, 0.0):
        memory |= {f"Gyroscope{axis}{END}": gyro for axis in "XYZ"}
        source.read(nao)
    assert source.sensors["gyro"].tolist() == [0.0, 0.0, 0.0]


@pytest.mark.full
def test_a_recording_is_a_motion_that_can_be_read(nao: nk.NaoModel, short_folder: Path) -> None:
    file = short_folder / "nod.json"
    with _lola_robot(short_folder, 200) as (path, _):
        done = _live("--lola", path, "-o", str(file), "--seconds", "0.4", "--rate", "50")
        assert done.returncode == 0, done.stderr
        assert done.stdout == f"{file}\n"
        again = _live("--lola", path, "-o", str(file), "--seconds", "0.2")
        assert again.returncode == 2
        assert again.stderr.startswith(f"nao-kin: {file} ")
        assert again.stderr.endswith("; overwrite=True (--force) replaces it\n")
    motion = read_motion(file)
    assert motion.joint_names == nao.joint_names
    assert motion.start == 0.0
    times = motion.times[0]
    assert times[-2] < 0.4 <= times[-1]
    yaw = motion.keys[motion.joint_names.index("HeadYaw")]
    assert (np.diff(yaw) > 0.0).all()


def test_the_page_says_what_the_robot_does(short_folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    texts, add = [], nk.Viewer.add_text
    monkeypatch.setattr(nk.Viewer, "add_text", lambda *given: texts.append(add(*given)) or texts[-1])
    with _lola_robot(short_folder, 50) as (path, _):
        assert run(["live", "--lola", path, "--seconds", "0.3"]) == 0
    (state,) = texts
    assert re.fullmatch(r"\w+(, on .+)?(; .* m, .*°)?", state.value), state.value


@pytest.mark.full
def test_what_was_read_until_ctrl_c_is_kept(short_folder: Path) -> None:
    file = short_folder / "nod.json"
    with _lola_robot(short_folder, 2000) as (path, robot):
        command = [sys.executable, "-m", "nao_kin", "live", "--no-view", "--lola", path, "-o", str(file), "--json"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
            assert process.stderr is not None
            assert process.stdout is not None
            assert "connected" in process.stderr.readline()
            assert robot.stdout is not None
            assert robot.stdout.readline() == "sent a hundred\n"
            process.send_signal(signal.SIGINT)
            try:
                assert process.wait(PATIENCE) == 130
            finally:
                process.kill()
            document = json.loads(process.stdout.read())
    assert document["record"] == str(file)
    assert document["readings"] > 3
    assert len(read_motion(file).times[0]) == document["readings"]


@pytest.mark.full
def test_a_robot_that_does_not_answer_is_asked_again_until_ctrl_c(short_folder: Path) -> None:
    silent = socket.socket(socket.AF_UNIX)
    silent.bind(str(short_folder / "silent"))
    silent.listen()
    command = [sys.executable, "-m", "nao_kin", "live", "--no-view", "--lola", str(short_folder / "silent")]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        assert "connected" in process.stderr.readline()
        assert "sends nothing for 3 s; trying again" in process.stderr.readline()
        process.send_signal(signal.SIGINT)
        try:
            assert process.wait(PATIENCE) == 130
        finally:
            process.kill()
    silent.close()


def test_a_robot_that_never_answers_is_given_up_after_the_seconds_asked_for(short_folder: Path) -> None:
    silent = short_folder / "silent"
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(str(silent))
        listening.listen()
        for address in (str(silent), str(short_folder / "nobody")):
            done = _live("--lola", address, "--seconds", "0.3", "-o", str(short_folder / "nod.json"))
            assert done.returncode == 2
            assert done.stdout == ""
            assert done.stderr.endswith(f"\nnao-kin: {address} gave no reading within 0.3 s\n")
    assert not (short_folder / "nod.json").exists()


def test_a_robot_that_is_lost_for_the_seconds_asked_for_ends_the_recording(short_folder: Path) -> None:
    file = short_folder / "nod.json"
    with _lola_robot(short_folder, 20) as (path, _):
        done = _live("--lola", path, "--seconds", "2", "-o", str(file), "--json")
    assert done.returncode == 0, done.stderr
    assert "trying again" in done.stderr
    assert len(read_motion(file).times[0]) == json.loads(done.stdout)["readings"] > 0


def test_a_robot_that_refuses_is_asked_again_until_a_signal() -> None:
    pytest.importorskip("qi")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"  # bound, and nobody listens
        command = [sys.executable, "-m", "nao_kin", "live", "--no-view", address]
        with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
            assert process.stderr is not None
            line = process.stderr.readline()
            assert "refused" in line
            assert line.endswith("; trying again\n")
            process.send_signal(signal.SIGTERM)
            try:
                assert process.wait(PATIENCE) == 143
            finally:
                process.kill()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "give the address of a robot, as in tcp://nao.local:9559, or --lola SOCKET"),
        (("tcp://a:1", "--lola", "x"), "give the address of a robot, as in tcp://nao.local:9559, or --lola SOCKET"),
        (("udp://a:1",), "address must be like tcp://nao.local:9559, got 'udp://a:1'"),
        (("--lola", "x", "--rate", "0"), "rate must be a positive number, got 0"),
        (("--lola", "x", "--seconds", "-1"), "--seconds must be a positive number, got -1"),
        (("--lola", "x", "-o", "/no/such/folder/x.json"), "cannot write /no/such/folder/x.json: "),
    ],
)
def test_bad_input_is_one_line(arguments: tuple[str, ...], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["live", "--no-view", *arguments]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"nao-kin: {message}")
    assert error.count("\n") == 1


@pytest.mark.parametrize(
    ("address", "endpoint"),
    [
        ("nao.local", "tcp://nao.local:9559"),
        ("nao.local:1", "tcp://nao.local:1"),
        ("tcp://10.0.0.1", "tcp://10.0.0.1:9559"),
        ("tcps://10.0.0.1:9503", "tcps://10.0.0.1:9503"),
        ("[::1]", "tcp://[::1]:9559"),
    ],
)
def test_an_address_may_be_short(address: str, endpoint: str) -> None:
    pytest.importorskip("qi")
    assert NaoqiSource(address).address == endpoint


@pytest.mark.parametrize(
    ("roll", "pitch"), [(0.0, 0.0), (0.3, 0.0), (0.0, -0.4), (0.3, -0.4), (np.pi, 0.1), (0.2, np.pi / 2)]
)
def test_the_vertical_is_that_of_the_turned_torso(roll: float, pitch: float) -> None:
    R_world_torso = matrix_from_rpy([roll, pitch, 0.7])
    assert vertical(roll, pitch) == pytest.approx(R_world_torso.T @ [0.0, 0.0, 1.0], abs=1e-15)


def test_nothing_read_is_no_motion(nao: nk.NaoModel) -> None:
    with pytest.raises(BadArgument, match="no readings"):
        recorded([], nao)
