"""Scripts for NAOqi, unmodified, each in a process of its own, over TCP."""

from __future__ import annotations

import json
import math
import os
import re
import subprocess
import sys
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from loops import full

import nao_kin as nk
from nao_kin.cli.app import run
from nao_kin.naoqi import QiServer, VirtualNao, run_script
from nao_kin.naoqi.compat import FOLDER, almath

pytest.importorskip("qi")

EXAMPLES = Path(__file__).resolve().parents[2] / "examples" / "naoqi"
SPEED = 4.0
# A script learns of the end of a call by a message, which may be late: the first call loads its kernel, and the machine
# may be busy.
_SECONDS_LATE = 60.0

Check = Callable[[VirtualNao, str], None]
_CHECKS: dict[str, Check] = {}


def _checked_by(name: str) -> Callable[[Check], Check]:
    def note(check: Check) -> Check:
        _CHECKS[name] = check
        return check

    return note


@pytest.fixture(scope="module")
def robot() -> Iterator[tuple[VirtualNao, str]]:
    with VirtualNao(speed=SPEED, posture="StandInit") as virtual, QiServer(virtual, port=0, quiet=True) as server:
        yield virtual, server.endpoint


def _run(script: Path, endpoint: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "NAO_KIN_ENDPOINT": endpoint}
    command = [sys.executable, str(FOLDER), str(script), *arguments]
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120)


def _angles(nao: VirtualNao, *names: str) -> list[float]:
    return [float(value) for value in nao.call("ALMotion", "getAngles", list(names), True)]


def _seconds(output: str, before: str) -> float:
    """Seconds of robot time that a script measured."""
    found = re.search(rf"{before} (-?[\d.]+) s", output)
    assert found, output
    return float(found[1]) * SPEED


def _took(output: str, before: str, expected: float) -> None:
    """Check that a call took the expected time. The script may hear of its end later, if the machine is slow.

    It may seem shorter too: on a busy machine robot time falls behind the wall clock and then catches up.
    """
    assert 0.5 * expected <= _seconds(output, before) <= expected + _SECONDS_LATE * SPEED


def _number(output: str, before: str) -> float:
    found = re.search(rf"{re.escape(before)} (-?[\d.]+)", output)
    assert found, output
    return float(found[1])


@_checked_by("head_angles")
def _head_angles(nao: VirtualNao, output: str) -> None:
    assert _angles(nao, "HeadYaw", "HeadPitch") == pytest.approx([0.1, -0.2], abs=1e-6)
    _took(output, "one angle took", 1.0)
    _took(output, "two lists took", 3.0)


@_checked_by("head_set_angles")
def _head_set_angles(nao: VirtualNao, output: str) -> None:
    assert _angles(nao, "HeadYaw", "HeadPitch") == pytest.approx([-0.35, -0.3], abs=1e-6)


@_checked_by("arm_with_speed")
def _arm_with_speed(nao: VirtualNao, output: str) -> None:
    arm = ["LShoulderPitch", "LShoulderRoll", "LElbowYaw", "LElbowRoll", "LWristYaw", "LHand"]
    assert f"the arm is {arm}" in output
    assert _angles(nao, *arm) == pytest.approx([0.5, 0.4, -1.0, -0.8, 0.3, 1.0], abs=1e-6)
    assert _angles(nao, "RShoulderPitch", "RElbowRoll") == pytest.approx([0.7, 1.1], abs=1e-6)


@_checked_by("relative_angles")
def _relative_angles(nao: VirtualNao, output: str) -> None:
    assert _angles(nao, "HeadYaw", "HeadPitch") == pytest.approx([0.2 + 0.15, 0.1 - 0.2], abs=1e-6)


@_checked_by("hands")
def _hands(nao: VirtualNao, output: str) -> None:
    assert "open: [1.0, 1.0]" in output
    assert _angles(nao, "LHand", "RHand") == pytest.approx([0.33, 0.1], abs=1e-6)


@_checked_by("stiffness")
def _stiffness(nao: VirtualNao, output: str) -> None:
    assert "limp at [0.0] commanded [0.7]" in output
    _took(output, "stiff after", 1.0)
    assert "stiffnesses [1.0, 1.0]" in output
    assert _angles(nao, "HeadYaw") == pytest.approx([0.4], abs=1e-6)


@_checked_by("postures")
def _postures(nao: VirtualNao, output: str) -> None:
    for name, family in (
        ("StandInit", "Standing"),
        ("Sit", "Sitting"),
        ("Crouch", "Crouching"),
        ("StandZero", "Standing"),
    ):
        assert f"{name}: True, of the family {family}" in output
    assert "no such posture: False" in output
    q = nao.robot.clamp(nao.robot.posture("StandZero"))
    assert nao.state().q == pytest.approx(q, abs=1e-6)


@_checked_by("timeline")
def _timeline(nao: VirtualNao, output: str) -> None:
    assert output == ""
    names = "HeadPitch", "RElbowRoll", "RHand", "RShoulderPitch"
    assert _angles(nao, *names) == pytest.approx([0.05, 0.9, 0.2, 1.4], abs=1e-6)


@_checked_by("cartesian_arm")
def _cartesian_arm(nao: VirtualNao, output: str) -> None:
    moved = eval(output.split("moved by ")[1])
    assert moved == pytest.approx([0.03, 0.02, 0.05], abs=1e-3)
    _took(output, "took", 1.5)


@_checked_by("cartesian_both_arms")
def _cartesian_both_arms(nao: VirtualNao, output: str) -> None:
    assert _number(output, "LArm misses by") < 1e-3
    assert _number(output, "RArm misses by") < 1e-3
    _took(output, "took", 2.0)


@_checked_by("set_positions")
def _set_positions(nao: VirtualNao, output: str) -> None:
    assert _number(output, "misses by") < 1e-3


@_checked_by("transforms")
def _transforms(nao: VirtualNao, output: str) -> None:
    moved = [float(value) for value in output.split("moved by ")[1].split()[:3]]
    assert moved == pytest.approx([0.01, 0.0, -0.02], abs=1e-3)
    assert eval(output.split("turned by ")[1]) == pytest.approx([0.0, 0.0, 0.0], abs=1e-3)
    _took(output, "took", 1.0)


@_checked_by("walk_to")
def _walk_to(nao: VirtualNao, output: str) -> None:
    walked = [float(value) for value in output.split("walked ")[1].split()]
    assert walked == pytest.approx([0.2, 0.05, np.pi / 6.0], abs=1e-3)


@_checked_by("walk_velocity")
def _walk_velocity(nao: VirtualNao, output: str) -> None:
    assert output.count("walking: True") == 1
    assert output.count("walking: False") == 1
    assert _angles(nao, "HeadYaw") == pytest.approx([0.5], abs=1e-6)


@_checked_by("whole_body_arm")
def _whole_body_arm(nao: VirtualNao, output: str) -> None:
    assert _number(output, "misses by") < 1e-3


@_checked_by("whole_body_balance")
def _whole_body_balance(nao: VirtualNao, output: str) -> None:
    numbers = [[float(value) for value in re.findall(r"(-?\d+\.\d+) m", line)] for line in output.splitlines()]
    (com_left, left), (com_both, _) = numbers
    assert com_left == pytest.approx(left, abs=0.02)
    assert com_both == pytest.approx(0.0, abs=0.01)


@_checked_by("tasks")
def _tasks(nao: VirtualNao, output: str) -> None:
    assert "tasks: ['angleInterpolation', 'angleInterpolation']" in output
    _took(output, "first after", 1.5)
    assert "second running: True" in output
    _took(output, "second after", 2.5)
    assert "killed angleInterpolation: True" in output
    assert _angles(nao, "HeadYaw") == pytest.approx([0.25], abs=1e-6)


@_checked_by("async_calls")
def _async_calls(nao: VirtualNao, output: str) -> None:
    _took(output, "all after", 2.0)
    assert "failed: True" in output
    assert "HeadYaw" in output.split("failed: True")[1]
    names = "HeadYaw", "LShoulderPitch", "RShoulderPitch", "RShoulderRoll"
    assert _angles(nao, *names) == pytest.approx([0.3, 0.9, 0.8, -0.4], abs=1e-6)


@_checked_by("memory_events")
def _memory_events(nao: VirtualNao, output: str) -> None:
    assert "memory: [42, 'NAO', [1, 2.5, 'three']]" in output
    assert "keys: ['Demo/Answer', 'Demo/List', 'Demo/Name']" in output
    # libqi hands events to several threads, here and on a robot: two may change places.
    touched = re.search(r"touched: \[(.*)\]", output)
    assert touched is not None
    assert sorted(touched[1].split(", ")) == ["0.0", "1.0", "1.0"]
    assert "sensor 0.350000, actuator 0.350000" in output


@_checked_by("memory_module")
def _memory_module(nao: VirtualNao, output: str) -> None:
    assert "hits: [('LeftBumperPressed', 1.0), ('LeftBumperPressed', 0.0)]" in output


@_checked_by("lights_and_speech")
def _lights_and_speech(nao: VirtualNao, output: str) -> None:
    _took(output, "eyes after", 1.0)
    assert "volume 0.6, language English" in output
    leds = nao.state().leds
    eyes = [colour for name, colour in leds.items() if name.startswith("Face") and "Ear" not in name]
    assert eyes
    for colour in eyes:
        assert colour == pytest.approx((1.0, 128.0 / 255.0, 0.0), abs=1e-6)


@_checked_by("robot_facts")
def _robot_facts(nao: VirtualNao, output: str) -> None:
    assert "26 joints in Body, chains ['Head', 'LArm', 'LLeg', 'RLeg', 'RArm']" in output
    assert "HeadYaw: min -2.0857, max 2.0857, speed 8.268, torque 1.547" in output
    assert f"mass {nao.robot.mass:.5f} kg" in output
    com = eval(output.split("centre of mass ")[1])
    assert com == pytest.approx(nao.robot.com(nao.state().q), abs=1e-5)


def test_every_script_is_held_to_something() -> None:
    assert sorted(path.stem for path in EXAMPLES.glob("*.py")) == sorted(_CHECKS)
    assert len(_CHECKS) >= 20


@pytest.mark.parametrize("name", [min(_CHECKS), *full(*sorted(_CHECKS)[1:])])
def test_a_script_runs_and_does_what_it_should(robot: tuple[VirtualNao, str], name: str) -> None:
    nao, endpoint = robot
    nao.call("ALMotion", "killAll")
    nao.call("ALMotion", "setStiffnesses", "Body", 0.0)
    done = _run(EXAMPLES / f"{name}.py", endpoint)
    assert done.returncode == 0, done.stderr
    _CHECKS[name](nao, done.stdout)


PYTHON_2 = """\
    # -*- coding: latin-1 -*-
    # Tabs, print without brackets, an exception with a comma: Gr\u00fc\u00dfe.
    import sys
    from naoqi import ALProxy
    try:
    \tmotion = ALProxy("ALMotion", "192.168.1.7", 9559)
    except Exception, e:
    \tprint "no proxy", e
    \tsys.exit(1)
    if motion.getBodyNames("Body").__len__() <> 26:
            print >>sys.stderr, "not a NAO"
    motion.setStiffnesses("Head", 1.0)
    motion.angleInterpolation("HeadYaw", 0.125, 0.4, True)
    print "at", motion.getAngles("HeadYaw", True)[0], len(sys.argv)
    raise SystemExit(7)
"""


def test_a_script_without_a_walk_loads_no_kernel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    monkeypatch.setattr("nao_kin.naoqi.virtual.service.warm_up", asked.extend)
    monkeypatch.setattr("nao_kin.naoqi.virtual.service._ready", set())
    script = tmp_path / "hello.py"
    with VirtualNao(speed=SPEED, posture="StandInit") as virtual, QiServer(virtual, port=0, quiet=True) as server:
        for calls, kernels in (("motion.setAngles('HeadYaw', 0.1, 0.5)", []), ("motion.moveInit()", ["both legs"])):
            script.write_text(f"from naoqi import ALProxy\nmotion = ALProxy('ALMotion', '127.0.0.1', 9559)\n{calls}\n")
            assert run_script(script, endpoint=server.endpoint) == 0
            assert asked == [f"ik kernel, {kernel}" for kernel in kernels]


def test_python_2_runs_translated_and_its_exit_code_is_kept(
    robot: tuple[VirtualNao, str], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    script = tmp_path / "old.py"
    script.write_bytes(textwrap.dedent(PYTHON_2).encode("latin-1"))
    assert run_script(script, ["--flag", "x"], endpoint=robot[1]) == 7
    out, err = capfd.readouterr()
    assert "at 0.125 3" in out
    assert "nao-kin: old.py is Python 2, and runs translated" in err
    assert f"naoqi: {robot[1]} answers in place of tcp://192.168.1.7:9559" in err


LISTENER = """
import time
from naoqi import ALBroker, ALModule, ALProxy
class Listener(ALModule):
    def __init__(self, name):
        ALModule.__init__(self, name)
        self.BIND_PYTHON(self.getName(), "short")
        self.heard = {}
    def none(self): self.heard["none"] = ()
    def short(self, key, value): self.heard["short"] = key, value
    def full(self, key, value, message="?"): self.heard["full"] = key, value, message
    def any(self, *all): self.heard["any"] = all
    def broken(self, key): self.heard["broken"] = key; 1 / 0
broker = ALBroker("broker", "0.0.0.0", 0, "nao.local", 9559)
memory, listener = ALProxy("ALMemory"), Listener("listener")
for name in ("none", "short", "full", "any", "broken"):
    memory.subscribeToEvent("Demo/" + name, "listener", name)
    memory.raiseEvent("Demo/" + name, [name])
end = time.time() + 10
while len(listener.heard) < 5 and time.time() < end:
    time.sleep(0.01)
time.sleep(0.2)
for name in sorted(listener.heard): print(name, listener.heard[name])
"""


def test_a_modules_methods_take_of_an_event_what_they_need(robot: tuple[VirtualNao, str], tmp_path: Path) -> None:
    script = tmp_path / "listens.py"
    script.write_text(LISTENER)
    done = _run(script, robot[1])
    assert done.stdout.splitlines() == [
        "any ('Demo/any', ['any'], 'listener')",
        "broken Demo/broken",
        "full ('Demo/full', ['full'], 'listener')",
        "none ()",
        "short ('Demo/short', ['short'])",
    ], done.stderr
    assert "ZeroDivisionError" in done.stderr  # nobody else tells the script


def test_what_tutorials_ask_for_is_there(robot: tuple[VirtualNao, str], tmp_path: Path) -> None:
    script = tmp_path / "asks.py"
    script.write_text(
        "import almath\nfrom naoqi import ALProxy\nT = almath.Transform(0.1, 0.2, 0.3)\n"
        "print(T.toVector()[3::4], T.toVector()[0::5])\nvoice = ALProxy('ALTextToSpeech', 'nao.local', 9559)\n"
        "voice.setParameter('enableCompression', 0)\nprint(voice.getParameter('enableCompression'))\n"
    )
    done = _run(script, robot[1])
    assert done.stdout == "[0.1, 0.2, 0.3, 1.0] [1.0, 1.0, 1.0, 1.0]\n0.0\n", done.stderr


def test_numbers_of_motion_are_found_inside_naoqi_too(robot: tuple[VirtualNao, str], tmp_path: Path) -> None:
    script = tmp_path / "constants.py"
    script.write_text("from naoqi import ALProxy, motion\nprint(motion.FRAME_ROBOT, motion.AXIS_MASK_VEL)\n")
    done = _run(script, robot[1])
    assert (done.returncode, done.stdout) == (0, "2 7\n"), done.stderr


# From the tests of Aldebaran's libalmath (BSD-3): radius 0.1 m, target, first and second pose.
@pytest.mark.parametrize(
    ("target", "first", "second"),
    [
        ((0.5, 0.5, 0.0), (0.0777402, 0.0370996, 0.890525), (0.42226, 0.4629, 0.890525)),
        ((-0.5, 0.5, 0.3), (0.0207914, 0.197815, 2.93215), (-0.491239, 0.306652, 2.93215)),
        ((0.0, -1.0, 0.3), (0.0958873, -0.128384, -1.85859), (-0.125439, -0.876083, -1.85859)),
    ],
)
def test_dubins_ways_are_those_of_libalmath(
    target: tuple[float, ...], first: tuple[float, ...], second: tuple[float, ...]
) -> None:
    found = almath.getDubinsSolutions(almath.Pose2D(target), 0.1)
    assert np.allclose([pose.toVector() for pose in found], [first, second, target], atol=1e-6)


def test_a_dubins_way_is_two_arcs_and_the_shortest_line_between_them() -> None:
    rng = np.random.default_rng(5)
    for _ in range(200):
        radius, bearing, theta = rng.uniform(0.01, 0.2), *rng.uniform(-math.pi, math.pi, 2)
        away = radius * rng.uniform(4.0, 40.0)
        goal = almath.Pose2D(away * math.cos(bearing), away * math.sin(bearing), theta)
        begin, end, last = almath.getDubinsSolutions(goal, radius)
        assert last == goal
        # The line is along the heading, and each arc is a chord of a circle: the heading turns twice the chord's angle.
        along = begin.inverse() * end
        assert along.x > -1e-9
        assert abs(along.y) < 1e-9
        for chord in (begin, end.inverse() * goal):
            turn = math.atan2(chord.y, chord.x) if math.hypot(chord.x, chord.y) > 1e-9 else 0.0
            assert abs(math.remainder(chord.theta - 2.0 * turn, 2.0 * math.pi)) < 1e-6
            assert math.hypot(chord.x, chord.y) == pytest.approx(2.0 * radius * abs(math.sin(turn)), abs=1e-9)
    straight = almath.getDubinsSolutions(almath.Pose2D(1.0, 0.0, 0.0), 0.1)
    assert [pose.toVector() for pose in straight] == [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
    with pytest.raises(RuntimeError, match="at least 4 radii away"):
        almath.getDubinsSolutions(almath.Pose2D(0.39, 0.0, 0.0), 0.1)


def test_python_2_divides_whole_numbers_and_imports_what_is_beside_it(tmp_path: Path) -> None:
    (tmp_path / "helper.py").write_text("def half(x):\n    print 'half of', x\n    return x / 2\n")
    script = tmp_path / "old.py"
    script.write_text(
        "import helper\nn, d = 7, {'a': [5]}\nn /= 2\nd['a'][0] /= 2\n"
        "for i in range(n / 2): print i, 1 / 2, -1 / 2, 1.0 / 2, helper.half(5), n, d\n"
    )
    done = _run(script, "tcp://127.0.0.1:1")
    assert done.returncode == 0, done.stderr
    assert done.stdout == "half of 5\n0 0 -1 0.5 2 3 {'a': [2]}\n"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["helper.py", "old.py"]
    script.write_text("from __future__ import division\nprint 1 / 2\n")
    assert _run(script, "tcp://127.0.0.1:1").stdout == "0.5\n"


# What NAOqi 2.5 documents and Python 2 allows, and no Python 3 can parse, or has.
OLD_WORDS = {
    "async": "import qi\nprint(qi.async(lambda x: x + 1, 2).value())\n",
    "async of Python 2": "import qi\nprint qi.async(lambda x: x / 2, 7, delay=1000).value()\n",
    "a name": "def async(await=3): return await\nprint async(await=3)\n",
    "clock": "import time\nprint(3 if time.clock() >= 0 else 0)\n",
    "clock by name": "from time import clock\nprint 3 if clock() >= 0 else 0\n",
    "global": """
x = 1
def f():
    'A docstring.'
    print(x)
    for _ in range(1):
        global x
    x = 3
    def inner():
        global x, y
        y = x
    inner()
f()
print(y)
""",
}


@pytest.mark.parametrize("name", OLD_WORDS)
def test_words_that_python_3_has_taken_or_lost_still_run(tmp_path: Path, name: str) -> None:
    script = tmp_path / "old.py"
    script.write_text(OLD_WORDS[name])
    done = _run(script, "tcp://127.0.0.1:1")
    assert (done.returncode, done.stdout.split()[-1:]) == (0, ["3"]), done.stderr


def test_a_mistake_in_python_2_is_shown_where_python_2_stops(tmp_path: Path) -> None:
    script = tmp_path / "old.py"
    script.write_text("print 'a'\nprint 'b'\nif True print 'c'\n")
    done = _run(script, "tcp://127.0.0.1:1")
    assert done.returncode == 1
    assert "line 3" in done.stderr
    assert "if True print 'c'" in done.stderr
    script.write_text("print('a')\nif True print('c')\nprint(1, end='')\n")
    assert "line 2" in _run(script, "tcp://127.0.0.1:1").stderr


def test_python_2_beside_python_3_runs_translated_and_other_modules_do_not(tmp_path: Path) -> None:
    (tmp_path / "moves.py").write_text("def half(x):\n\tprint 'half of', x\n        return x / 2\n")
    (tmp_path / "new.py").write_text("def half(x):\n    return x / 2\n")
    script = tmp_path / "main.py"
    script.write_text("import moves, new\nprint(moves.half(5), new.half(5), 1 / 2)\n")
    done = _run(script, "tcp://127.0.0.1:1")
    assert done.returncode == 0, done.stderr
    assert done.stdout == "half of 5\n2 2.5 0.5\n"
    assert done.stderr == "nao-kin: moves.py is Python 2, and runs translated\n"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["main.py", "moves.py", "new.py"]


def test_scripts_find_the_documented_numbers_of_cameras(tmp_path: Path) -> None:
    """Aldebaran documentation 2.5, ALVideoDevice: indexes, resolutions, colour spaces and parameters of cameras."""
    documented = {"kBottomCamera": 1, "k960p": 3, "kQQQQVGA": 8, "kHSVColorSpace": 12, "kRawDepthColorSpace": 23}
    documented |= {"kCameraAecAlgorithmID": 22, "kCameraAutoFocusID": 40, "kMT9M114": 2}
    script = tmp_path / "camera.py"
    script.write_text(
        "import json, vision_definitions\nfrom vision_definitions import kVGA\n"
        f"print(json.dumps({{name: getattr(vision_definitions, name) for name in {list(documented)}}}))\n"
    )
    done = _run(script, "tcp://127.0.0.1:1")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == documented


@pytest.mark.parametrize(
    ("text", "translated"),
    [
        ("for i in xrange(1): print(3 / 2)", True),
        ("import ConfigParser\nprint(3 / 2)", True),
        ("print({1: 2}.has_key(1) and 3 / 2)", True),
        ("try:\n    xrange\nexcept NameError:\n    xrange = range\nprint(3 / 2)", False),
        ("try:\n    import Queue\nexcept ImportError:\n    import queue\nprint(3 / 2)", False),
        ("def xrange(n): return range(n)\nxrange(3)\nprint(3 / 2)", False),
        ("print(3 / 2, end='\\n')", False),
    ],
)
def test_python_2_that_python_3_can_read_is_known_by_what_only_it_has(
    tmp_path: Path, text: str, translated: bool
) -> None:
    script = tmp_path / "old.py"
    script.write_text(text)
    done = _run(script, "tcp://127.0.0.1:1")
    assert (done.returncode, done.stdout) == (0, "1\n" if translated else "1.5\n"), done.stderr
    assert ("runs translated" in done.stderr) == translated


@pytest.mark.parametrize(
    ("text", "code", "message"),
    [
        ("def", 1, "SyntaxError"),
        ("import naoqi\nnaoqi.ALProxy('ALMotion')", 0, ""),
        (
            "import naoqi\nnaoqi.ALProxy('ALMotin')",
            1,
            "Can't find service: ALMotin; there are: ALAnimatedSpeech, ALAnimationPlayer, ALAudioPlayer",
        ),
        ("import naoqi\nnaoqi.ALProxy('ALMotion').fly(1)", 1, "ALMotion has no method fly; it has: "),
        ("import naoqi\nnaoqi.ALProxy('ALMotion').getAngles('HeadYawn', useSensors=True)", 1, "nearest: HeadYaw"),
        ("1/0", 1, "ZeroDivisionError"),
        ("import os, signal\nos.kill(os.getpid(), signal.SIGKILL)", 137, ""),
    ],
)
def test_what_goes_wrong_in_a_script_is_said(
    robot: tuple[VirtualNao, str], tmp_path: Path, capfd: pytest.CaptureFixture[str], text: str, code: int, message: str
) -> None:
    script = tmp_path / "script.py"
    script.write_text(text)
    assert run_script(script, endpoint=robot[1]) == code
    err = capfd.readouterr().err
    assert message in err
    assert "compat" not in err.replace(str(FOLDER / "naoqi.py"), "")  # how the script was started is of no interest


def test_a_script_that_is_not_there_is_said_to_be_so(tmp_path: Path) -> None:
    with pytest.raises(nk.NaoKinError, match=r"no script '.*none\.py'"):
        run_script(tmp_path / "none.py")


def test_the_command_makes_a_robot_of_its_own(tmp_path: Path) -> None:
    script = tmp_path / "own.py"
    script.write_text(
        "import sys\nfrom naoqi import ALProxy\nmotion = ALProxy('ALMotion', sys.argv[1], 9559)\n"
        "print(round(motion.getAngles('LKneePitch', True)[0], 6), sys.argv[1:])\nsys.exit(3)\n"
    )
    command = [sys.executable, "-m", "nao_kin", "run", str(script), "--posture", "StandInit", "--", "nao.local", "--x"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (3, "0.7 ['nao.local', '--x']\n"), done.stderr


def test_the_robot_of_the_command_may_be_calibrated(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text("frames = {CameraTop = [0.01, 0, 0, 0, 0.02, 0]}")
    script = tmp_path / "camera.py"
    script.write_text(
        "from naoqi import ALProxy\nmotion = ALProxy('ALMotion', 'nao.local', 9559)\n"
        "print(*motion.getTransform('CameraTop', 0, True))\n"
    )
    command = [sys.executable, "-m", "nao_kin", "run", str(script), "--offsets", "mine.toml"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    mine = nk.load_nao(offsets=tmp_path / "mine.toml")
    expected = mine.fk(mine.clamp(mine.posture("Crouch")), "CameraTop")
    assert np.allclose(np.reshape([float(word) for word in done.stdout.split()], (4, 4)), expected, atol=1e-6)


@pytest.mark.parametrize("options", [(), *full((("--asleep",),))])
def test_a_script_that_never_asks_for_stiffness_moves_or_is_told_so(tmp_path: Path, options: tuple[str, ...]) -> None:
    script = tmp_path / "head.py"
    script.write_text(
        "from naoqi import ALProxy\nmotion = ALProxy('ALMotion', 'nao.local', 9559)\n"
        "motion.angleInterpolation('HeadYaw', 0.5, 0.5, True)\nprint(round(motion.getAngles('HeadYaw', True)[0], 6))\n"
    )
    command = [sys.executable, "-m", "nao_kin", "run", str(script), *options]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (0, "0.0\n" if options else "0.5\n"), done.stderr
    assert ("HeadYaw without stiffness: no movement" in done.stderr) is bool(options)


MANY = """
import os, qi
qi.logging.setLevel(qi.logging.FATAL)
sessions = []
for number in range(40):
    session = qi.Session()
    session.connect("tcp://nao.local:9559")
    session.service("ALMotion").angleInterpolation("HeadYaw", 0.1, 5.0, True, _async=True)
    sessions.append(session)
os._exit(5)
"""


@pytest.mark.full
@pytest.mark.parametrize("turn", range(3))
def test_a_robot_outlives_a_script_that_drops_many_sessions_and_ends_in_order(tmp_path: Path, turn: int) -> None:
    # While the sessions were taken down, closing the server crashed every second program, and its end every fourth.
    script = tmp_path / "many.py"
    script.write_text(MANY)
    command = [sys.executable, "-m", "nao_kin", "run", str(script)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (5, "", "")


@pytest.mark.parametrize(
    ("end", "code", "error"),
    [("", 0, ""), ("sys.exit()", 0, ""), ("sys.exit(300)", 44, ""), ("sys.exit('no arm')", 1, "no arm\n")],
)
def test_a_script_ends_with_its_own_code_and_all_that_it_printed(
    robot: tuple[VirtualNao, str], tmp_path: Path, end: str, code: int, error: str
) -> None:
    script = tmp_path / "ends.py"
    script.write_text(
        "import atexit, sys, threading, time, qi\natexit.register(print, 'tidied')\n"
        "threading.Thread(target=lambda: (time.sleep(0.2), print('thread'))).start()\n" + end
    )
    done = _run(script, robot[1])
    assert (done.returncode, done.stdout, done.stderr) == (code, "thread\ntidied\n", error)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("nothing.py",), "no script 'nothing.py'"),
        (("x.py", "--port", "1", "--speed", "2"), "--speed is for a virtual NAO of the script's own; leave out --port"),
        (("x.py", "--port", "0"), "port must be at least 1, got 0"),
        (("x.py", "--host", " "), "--host is empty"),
        (("x.py", "--port", "1", "--behaviors", "."), "--behaviors is for a virtual NAO of the script's"),
    ],
)
def test_bad_input_is_one_line(arguments: tuple[str, ...], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["run", *arguments]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"nao-kin: {message}")
    assert error.count("\n") == 1
