"""`nao-kin serve` in a process of its own, and scripts that drive it over TCP from another."""

from __future__ import annotations

import http.client
import json
import os
import signal
import socket
import subprocess
import sys
import textwrap
import threading
import time
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from free_ports import free_port
from loops import full

import nao_kin as nk
from nao_kin._kernels.cache import compiles
from nao_kin.cli.app import run
from nao_kin.cli.naoqi import VirtualOptions, follow, served as served_nao
from nao_kin.cli.options import RobotOptions
from nao_kin.cli.view import LivePage
from nao_kin.errors import BadArgument, MissingExtra
from nao_kin.naoqi import OpenToOthersWarning, QiServer, VirtualNao

pytest.importorskip("qi")
pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals")

ENVIRONMENT = {**os.environ, "PYTHONPATH": str(Path(nk.__file__).parent.parent)}
SECONDS = 60.0
# Every script begins so, and prints what it finds out as JSON.
HEAD = """
import json, sys, time
import qi
qi.logging.setLevel(qi.logging.FATAL)
session = qi.Session()
session.connect(sys.argv[1])
motion, memory = session.service("ALMotion"), session.service("ALMemory")
def timed(call, *arguments):
    begin = memory.getData("DCM/Time")
    call(*arguments)
    return 0.001 * (memory.getData("DCM/Time") - begin)
def refused(call, *arguments):
    try:
        call(*arguments)
    except RuntimeError as error:
        return str(error)
found = {}
"""


class Served:
    """A `nao-kin serve` that runs."""

    def __init__(self, *options: str) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "nao_kin", "serve", "--port", "0", "--json", *options],
            env=ENVIRONMENT,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
            preexec_fn=_unignored,
        )
        assert self.process.stdout is not None
        line = self.process.stdout.readline()  # all of the document, as whoever starts a server reads it
        assert line, self.process.stderr.read() if self.process.stderr else ""
        where = json.loads(line)
        self.endpoint: str = where["endpoint"]
        self.url: str = where.get("url", "")

    def end(self, number: int = signal.SIGTERM) -> tuple[int, str]:
        """Return the exit code, and standard error without the lines about compiled kernels."""
        self.process.send_signal(number)
        _, errors = self.process.communicate(timeout=SECONDS)
        self.about_kernels = [line for line in errors.splitlines() if "kernel" in line]
        return self.process.returncode, "".join(line for line in errors.splitlines(True) if "kernel" not in line)


def _unignored() -> None:
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)


@pytest.fixture
def serve() -> Iterator[Callable[..., Served]]:
    running: list[Served] = []

    def start(*options: str) -> Served:
        running.append(Served(*options))
        return running[-1]

    yield start
    for served in running:
        if served.process.poll() is None:
            served.process.kill()
        served.process.communicate()


@pytest.fixture(scope="module")
def shared() -> Iterator[Served]:
    served = Served("--speed", "10")
    yield served
    code, errors = served.end()
    assert code == 143
    # Some scripts command a robot that another has let rest.
    assert all("without stiffness: no movement" in line for line in errors.splitlines())


def _script(served: Served | str, code: str) -> subprocess.Popen[str]:
    """Start a script that drives a robot, which may be given by its address."""
    body = f"{HEAD}{textwrap.dedent(code)}\nprint(json.dumps(found))"
    endpoint = served if isinstance(served, str) else served.endpoint
    return subprocess.Popen(
        [sys.executable, "-c", body, endpoint], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def _result(script: subprocess.Popen[str]) -> dict[str, Any]:
    out, errors = script.communicate(timeout=SECONDS)
    assert script.returncode == 0, errors
    return json.loads(out.splitlines()[-1])


def _found(served: Served | str, code: str) -> dict[str, Any]:
    return _result(_script(served, code))


def test_a_script_moves_the_head_as_on_a_robot(shared: Served) -> None:
    found = _found(
        shared,
        """
        motion.wakeUp()
        motion.angleInterpolation(["HeadYaw", "HeadPitch"], [0.0, 0.0], 1.0, True)
        found["took"] = timed(motion.angleInterpolation, ["HeadYaw", "HeadPitch"], [[0.5, 0.25], [-0.2]],
                              [[5.0, 10.0], [10.0]], True)
        found["angles"] = motion.getAngles("Head", True)
        key = "Device/SubDeviceList/HeadYaw/Position/Sensor/Value"
        found["memory"] = memory.getData(key)
        found["posture"] = session.service("ALRobotPosture").goToPosture("StandInit", 0.8)
        found["names"] = motion.getBodyNames("Body")
        found["limits"] = motion.getLimits("HeadYaw")
        found["said"] = timed(session.service("ALTextToSpeech").say, "x" * 140)
        session.service("ALLeds").fadeRGB("FaceLeds", 0xFF0000, 0.5)
        """,
    )
    assert found["took"] >= 9.9  # seconds of the robot
    assert found["angles"] == pytest.approx([0.25, -0.2], abs=1e-9)
    assert found["memory"] == pytest.approx(0.25, abs=1e-9)
    assert found["posture"] is True
    assert len(found["names"]) == 26
    assert found["limits"][0][2] == pytest.approx(8.26797)
    assert found["said"] >= 10.2


@pytest.mark.full
def test_the_first_walk_is_not_overtaken_while_kernels_load(serve: Callable[..., Served]) -> None:
    served = serve("--posture", "StandInit")
    found = _found(
        served,
        """
        motion.setStiffnesses("Body", 1.0)
        walk = motion.moveTo(0.1, 0.0, 0.0, _async=True)
        motion.waitUntilMoveIsFinished()
        found["place"] = motion.getRobotPosition(True)
        walk.wait(60_000)  # its reply may come after that of the call that waited for it
        found["walked"] = walk.isFinished()
        """,
    )
    assert found["walked"]
    assert found["place"] == pytest.approx([0.1, 0.0, 0.0], abs=1e-6)
    assert served.end() == (143, "")
    if compiles():
        assert sum("ALMotion::moveTo waits for compiled kernels" in line for line in served.about_kernels) == 1


@pytest.mark.full
def test_calls_of_a_script_keep_their_order_within_and_across_services(shared: Served) -> None:
    found = _found(
        shared,
        """
        battery, key = session.service("ALBattery"), "Device/SubDeviceList/Battery/Charge/Sensor/Value"
        within, across = [], []
        for n in range(1500):
            answers = []
            for value in (n, n + 1, n + 2):
                memory.insertData("test/order", value, _async=True)
                answers.append(memory.getData("test/order", _async=True))
            within += [answer.value() == value for answer, value in zip(answers, (n, n + 1, n + 2))]
            memory.insertData(key, (n % 100) / 100.0, _async=True)
            across.append(battery.getBatteryCharge() == n % 100)
        memory.removeData(key)
        found["within"], found["across"] = within.count(False), across.count(False)
        """,
    )
    assert found == {"within": 0, "across": 0}


def test_calls_that_wait_hold_no_thread_and_may_be_cancelled(shared: Served) -> None:
    found = _found(
        shared,
        """
        motion.wakeUp()
        begin = memory.getData("DCM/Time")
        joints = motion.getBodyNames("Joints")
        calls = [motion.angleInterpolation(joint, 0.1, 10.0, True, _async=True) for joint in joints for _ in range(2)]
        motion.getAngles("Body", True)
        found["meanwhile"] = calls[-1].isRunning()
        qi.futureBarrier(calls).value()
        found["took"] = 0.001 * (memory.getData("DCM/Time") - begin)
        endless = motion.angleInterpolation("HeadYaw", 0.0, 1000.0, True, _async=True)
        while not motion.getTaskList() and endless.isRunning():
            time.sleep(0.01)
        found["listed"] = motion.getTaskList()
        endless.cancel()
        endless.wait(5000)
        found["finished"] = endless.isFinished()
        found["left"] = motion.getTaskList()
        """,
    )
    assert found["took"] >= 19.8  # two after the other, 10 s each
    assert found["meanwhile"]
    assert [task[0] for task in found["listed"]] == ["angleInterpolation"]
    assert found["finished"]
    assert found["left"] == []


def test_whatever_waits_may_be_cancelled(shared: Served) -> None:
    found = _found(
        shared,
        """
        motion.wakeUp()
        for name, future in {
            "rest": lambda: motion.rest(_async=True),
            "event": lambda: memory.getDataOnChange("Demo/Never", 0, _async=True),
            "wait": lambda: motion.wait(motion.getTaskList()[0][1], 0, _async=True),
        }.items():
            motion.angleInterpolation("HeadYaw", 0.1, 100.0, True, _async=True)
            while not motion.getTaskList():
                time.sleep(0.01)
            waiting = future()
            time.sleep(0.2)
            waiting.cancel()
            waiting.wait(5000)
            found[name] = not waiting.isRunning()
            motion.killAll()
        found["stiffness"] = motion.getStiffnesses("HeadYaw")
        """,
    )
    assert found == {"rest": True, "event": True, "wait": True, "stiffness": [0.0]}


def test_what_is_refused_arrives_in_naoqis_two_lines_without_a_traceback(shared: Served) -> None:
    found = _found(
        shared,
        """
        found["joint"] = refused(motion.setAngles, "HeadYow", 0.1, 0.1)
        found["nan"] = refused(motion.setAngles, "HeadYaw", float("nan"), 0.1)
        found["count"] = refused(motion.angleInterpolation, "Head", [0.1], [1.0], True)
        found["none"] = refused(motion.angleInterpolation, None, None, None, None)
        found["few"] = refused(motion.setAngles, "HeadYaw")
        found["absent"] = refused(motion.updateTrackerTarget, 0.1, 0.1, 10, False)
        found["dict"] = refused(motion.getAngles, {"a": [1, {"b": 2}]}, True)
        found["key"] = refused(memory.getData, "nothing")
        found["camera"] = refused(session.service("ALPhotoCapture").takePicture, "here", "picture")
        try:
            motion.fly()
        except AttributeError:
            found["missing"] = True
        """,
    )
    assert found.pop("missing")
    for name, text in found.items():
        assert text is not None, name
        first, second = text.split("\n")
        assert first.startswith(("ALMotion::", "ALMemory::", "ALPhotoCapture::"))
        assert second.startswith("\t")
        assert "Traceback" not in text
    assert "nearest: HeadYaw" in found["joint"]
    assert "not in this virtual NAO; it has: " in found["absent"]
    assert "it neither stores nor analyses pictures; there are: ALMotion, " in found["camera"]


def test_events_reach_other_scripts(shared: Served) -> None:
    listener = _script(
        shared,
        """
        heard, called = [], []
        subscriber = memory.subscriber("greeting")
        number = subscriber.signal.connect(heard.append)
        class Listener:
            def on_greeting(self, key, value, message):
                called.append([key, value, message])
        session.listen("tcp://127.0.0.1:0")
        session.registerService("Listener", Listener())
        memory.subscribeToEvent("greeting", "Listener", "on_greeting")
        memory.raiseEvent("ready", 1)
        end = time.monotonic() + 20
        while (len(heard) < 2 or len(called) < 2) and time.monotonic() < end:
            time.sleep(0.01)
        memory.unsubscribeToEvent("greeting", "Listener")
        found.update(heard=heard, called=called)
        """,
    )
    _found(
        shared,
        """
        end = time.monotonic() + 20
        while "ready" not in memory.getDataList("ready") and time.monotonic() < end:
            time.sleep(0.01)
        memory.raiseEvent("greeting", "hello")
        memory.raiseEvent("greeting", [1, 2.5, "three"])
        """,
    )
    found = _result(listener)
    assert found["heard"] == ["hello", [1, 2.5, "three"]]
    assert sorted(found["called"], key=str) == sorted(
        [["greeting", "hello", "Listener"], ["greeting", [1, 2.5, "three"], "Listener"]], key=str
    )


def test_a_script_killed_in_the_middle_of_a_call_leaves_the_robot_to_the_others(shared: Served) -> None:
    script = _script(
        shared,
        """
        motion.wakeUp()
        subscriber = memory.subscriber("news")
        subscriber.signal.connect(print)
        print("moving", flush=True)
        motion.angleInterpolation("LElbowYaw", -1.0, 5.0, True)
        """,
    )
    assert script.stdout is not None
    assert script.stdout.readline() == "moving\n"
    time.sleep(0.1)
    script.kill()
    script.communicate()
    found = _found(
        shared,
        """
        memory.raiseEvent("news", 1)
        end = time.monotonic() + 20
        while ["angleInterpolation"] in [task[:1] for task in motion.getTaskList()] and time.monotonic() < end:
            time.sleep(0.01)
        found["angle"] = motion.getAngles("LElbowYaw", True)
        motion.angleInterpolation("LElbowYaw", -0.9, 1.0, True)  # and the next call is answered
        """,
    )
    assert found["angle"] == pytest.approx([-1.0], abs=1e-9)  # what was begun is finished


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), *full((signal.SIGTERM, 143))])
def test_a_signal_ends_it_and_whoever_waits_gets_an_error(
    serve: Callable[..., Served], number: signal.Signals, code: int
) -> None:
    served = serve()
    script = _script(
        served,
        """
        motion.wakeUp()
        print("waiting", flush=True)
        found["refused"] = refused(motion.angleInterpolation, "HeadYaw", 1.0, 1000.0, True)
        """,
    )
    assert script.stdout is not None
    assert script.stdout.readline() == "waiting\n"
    time.sleep(0.1)
    begin = time.monotonic()
    assert served.end(number) == (code, "")
    assert time.monotonic() - begin < 5.0
    assert _result(script)["refused"]
    # The port is free again.
    with socket.socket() as again:
        again.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        again.bind(("127.0.0.1", int(served.endpoint.rpartition(":")[2])))


def test_the_log_says_what_happens(serve: Callable[..., Served]) -> None:
    served = serve("--log", "--speed", "10", "--nao", "v5", "--posture", "Stand")
    _found(
        served,
        """
        session.service("ALTextToSpeech").say("hello")
        found["posture"] = session.service("ALRobotPosture").getPosture()
        motion.setAngles("HeadYaw", 3.0, 1.0)
        """,
    )
    _, errors = served.end(signal.SIGINT)
    lines = errors.splitlines()
    assert all(line.startswith("nao-kin: ") for line in lines)
    assert any(line.endswith("s: says: hello") for line in lines)
    assert any("HeadYaw = 3 is clipped" in line for line in lines)


@pytest.mark.full
def test_it_may_begin_awake_with_a_page_and_says_of_a_chain_once_that_it_does_not_move(
    serve: Callable[..., Served],
) -> None:
    begun_awake = """
        found["awake"] = motion.robotIsWakeUp()
        motion.setAngles("Head", 0.1, 1.0)
        motion.setAngles("HeadYaw", 0.1, 1.0)
        """
    awake, asleep = serve("--awake", "--speed", "10", "--view"), serve("--speed", "10")
    assert _found(awake, begun_awake) == {"awake": True}
    assert _found(asleep, begun_awake) == {"awake": False}
    with urllib.request.urlopen(awake.url, timeout=SECONDS) as page:
        assert b"nao" in page.read()
    assert awake.end(signal.SIGINT) == (130, "")
    errors = asleep.end()[1]
    assert errors.count("\n") == 1
    assert "setAngles (task 1): HeadYaw, HeadPitch without stiffness: no movement" in errors


@pytest.mark.full
def test_a_calibrated_robot_is_served_and_shown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "mine.toml"
    path.write_text("[joints]\nHeadYaw = 0.1\n\n[frames]\nCameraTop = [0.01, 0, 0, 0, 0.02, 0]\n")
    mine = nk.load_nao(offsets=path)
    T_torso_camera = mine.fk(mine.posture("StandInit"), "CameraTop")
    shown: list[nk.RobotModel] = []
    true_viewer = LivePage.viewer
    monkeypatch.setattr(LivePage, "viewer", lambda page, robot: shown.append(robot) or true_viewer(page, robot))
    virtual = VirtualOptions(page_port=0, posture="StandInit", view=True)
    given = {"host": "127.0.0.1", "port": 0, "awake": False}
    with served_nao(RobotOptions(offsets=str(path)), virtual, kinds=(), **given) as served:
        found = _found(served["endpoint"], "found['camera'] = motion.getTransform('CameraTop', 0, True)")
        assert np.allclose(np.reshape(found["camera"], (4, 4)), T_torso_camera, atol=1e-6)
        assert shown[0].base == "floating"
        assert np.allclose(shown[0].fk(shown[0].posture("StandInit"), "CameraTop"), T_torso_camera)


def test_the_live_page_follows_the_robot_through_the_world(nao: nk.NaoModel) -> None:
    ended, viewer = threading.Event(), nk.Viewer(nk.load_nao(base="floating"))
    with VirtualNao(nao, stepped=True) as virtual:
        thread = threading.Thread(target=follow, args=(virtual, viewer, ended))
        thread.start()
        virtual.call("ALMotion", "wakeUp")
        for posture in ("Stand", "LyingBack"):
            virtual.call("ALRobotPosture", "goToPosture", posture, 1.0)
            state, end = virtual.state(), time.monotonic() + 5.0
            while not np.array_equal(viewer.q[7:], state.q) and time.monotonic() < end:
                time.sleep(0.01)
            frames = ["LLeg", "Head", "Torso"]
            expected = state.T_world_torso @ nao.fk(state.q, frames)
            assert np.allclose(viewer.robot.fk(viewer.q, frames), expected, atol=1e-12)
        ended.set()
        thread.join(5.0)
        assert not thread.is_alive()


@pytest.mark.full
def test_a_program_may_end_right_after_it_has_closed_its_server() -> None:
    program = """
    from nao_kin.naoqi import QiServer, VirtualNao
    with VirtualNao() as nao, QiServer(nao, port=0, quiet=True) as server:
        print(server.endpoint)
    """
    for _ in range(4):
        command = [sys.executable, "-c", textwrap.dedent(program)]
        done = subprocess.run(command, env=ENVIRONMENT, capture_output=True, text=True, timeout=SECONDS)
        assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.full
def test_the_page_has_an_address_names_and_a_token_of_its_own(serve: Callable[..., Served]) -> None:
    port = free_port()
    served = serve("--view", "--page-host", "0.0.0.0", "--page-port", str(port), "--allow-host", "nao.example")
    assert served.url.startswith(f"http://127.0.0.1:{port}/?token=")
    for path, host, status in (
        (f"/?{served.url.partition('?')[2]}", "nao.example", 200),
        ("/", "nao.example", 403),
        (f"/?{served.url.partition('?')[2]}", "evil.example", 403),
    ):
        connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10.0)
        connection.request("GET", path, headers={"Host": host})
        assert connection.getresponse().status == status
        connection.close()
    code, errors = served.end(signal.SIGINT)
    assert (code, errors.count("\n")) == (130, 1)
    assert "put the name or the address of this one into the page's address" in errors


@pytest.mark.full
def test_a_script_is_shown_where_it_is_asked_for(tmp_path: Path) -> None:
    port = free_port()
    script = tmp_path / "looks.py"
    script.write_text(
        "import sys, urllib.request\n"
        "asked = urllib.request.Request(f'http://127.0.0.1:{sys.argv[1]}/', headers={'Host': 'nao.example'})\n"
        "print(urllib.request.urlopen(asked, timeout=10.0).status)\n"
    )
    options = ["--view", "--page-port", str(port), "--allow-host", "nao.example", "--no-token"]
    command = [sys.executable, "-m", "nao_kin", "run", str(script), *options, "--", str(port)]
    done = subprocess.run(command, env=ENVIRONMENT, capture_output=True, text=True, timeout=SECONDS)
    assert (done.returncode, done.stdout) == (0, "200\n")
    assert f"nao-kin: the virtual NAO is at http://127.0.0.1:{port}/\n" in done.stderr


def test_a_port_in_use_is_named(capsys: pytest.CaptureFixture[str], shared: Served) -> None:
    port = shared.endpoint.rpartition(":")[2]
    assert run(["serve", "--port", port]) == 2
    assert f"port {port}: Address already in use" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (("--port", "70000"), "port must be at most 65535"),
        (("--host", "no.such.host.invalid"), "is not an address"),
        (("--host", ""), "--host is empty"),
        (("--host", "192.0.2.1"), "cannot listen on 192.0.2.1"),
        (("--speed", "0"), "speed must be positive"),
        (("--speed", "nan"), "--speed 'nan': expected a number"),
        (("--offsets", "none.toml"), "none.toml"),
    ],
)
@pytest.mark.filterwarnings("ignore::nao_kin.naoqi.OpenToOthersWarning")
def test_bad_options_are_refused_in_one_line(
    capsys: pytest.CaptureFixture[str], options: tuple[str, ...], reason: str
) -> None:
    assert run(["serve", *options]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert reason in err.splitlines()[-1]
    assert all(line.startswith("nao-kin: ") for line in err.splitlines())


def test_others_are_let_in_with_a_warning_only(nao: nk.NaoModel) -> None:
    with VirtualNao(nao, stepped=True) as virtual:
        with pytest.warns(OpenToOthersWarning, match="no passwords"), QiServer(virtual, host="0.0.0.0", port=0):
            pass
        with QiServer(virtual, port=0) as server:  # a warning is an error here
            assert server.endpoint.startswith("tcp://127.0.0.1:")
            with pytest.raises(BadArgument, match="in use"):
                QiServer(virtual, port=int(server.endpoint.rpartition(":")[2]))
        server.close()


@pytest.mark.full
def test_without_qi_the_extra_is_named(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, nao: nk.NaoModel
) -> None:
    monkeypatch.setitem(sys.modules, "qi", None)
    with VirtualNao(nao, stepped=True) as virtual, pytest.raises(MissingExtra, match=r"nao-kin\[naoqi\]"):
        QiServer(virtual)
    assert run(["serve"]) == 2
    assert "pip install 'nao-kin[naoqi]'" in capsys.readouterr().err
