"""Wrong arguments and damaged files are answered by errors of this package, with a short message, and at once."""

from __future__ import annotations

import inspect
import os
import subprocess
import sys
from pathlib import Path

import fuzz
import numpy as np
import pytest
from loops import for_all
from public_names import called

import nao_kin as nk

NAO, STAND = nk.load_nao(), nk.load_nao().posture("Stand")
LIMIT = nk.semantics.CoupledLimit("HeadPitch", "HeadYaw", (0.0, 1.0), (-0.1, -0.2), (0.1, 0.2))
MIMIC = nk.semantics.Mimic("LHand", 0.5, 0.1)
FOUND = nk.ik.arm(NAO, "L", NAO.fk(STAND, "LArm"))
# What was answered by another error, by a wrong result, or not at all. Found by fuzz.py, and by people.
REFUSED = (
    *(f"MIMIC.{name}({value})" for name in ("value", "driver_value") for value in ("None", "'abc'", "1j")),
    *(f"LIMIT.range({value})" for value in ("'abc'", "10**400", "np.nan")),
    "nk.semantics.CoupledLimit(np.zeros(2), 'HeadYaw', (0.0, 1.0), (-0.1, -0.2), (0.1, 0.2))",
    "nk.semantics.CoupledLimit('HeadPitch', 'HeadYaw', np.zeros(2, complex), (-0.1, -0.2), (0.1, 0.2))",
    *(f"nk.semantics.Semantics({field}=np.array(1.0))" for field in nk.semantics.Semantics.__dataclass_fields__),
    "nk.semantics.Posture({}, (0.0, np.inf, 1.0))",
    "nk.semantics.View((np.nan, 0.0, 0.0), ('HeadYaw',))",
    "nk.semantics.View((1.0, 0.0, 0.0), np.array(1.0))",
    "NAO.random(np.eye(3).view(np.matrix))",
    "NAO.random(fuzz.bad_values.in_itself())",
    "NAO.fill_missing([0.1], 'Stand')",
    "NAO.fill_missing({'LHnd': [0.1]}, 'Stand')",
    "NAO.mass_of('LArm')",
    "NAO.motor_values({'foo': 1.0})",
    "NAO.motor_values({'LHipYawPitch': [0.1] * 3, 'RHipYawPitch': [0.1, 0.2]})",
    "NAO.joints.path(1.5)",
    "NAO.joints.path(99)",
    "NAO.joints.values(np.zeros(3))",
    "FOUND.describe(3)",
    "FOUND.describe('a')",
    "nk.cli.main(['fk', 1])",
    "nk.ik.velocity(NAO, STAND, np.zeros(6), 'LArm', length=np.timedelta64(1, 's'))",
    "nk.imitation.Imitator(NAO).step({}, [[]])",
    "nk.imitation.Imitator(NAO).step({'pelvis': np.zeros((0, 3)), 'head': np.zeros(3)}, 0.1)",
    "nk.motion.plot(NAO, nk.Motion([0.0, 1.0], ['HeadYaw'], [[0.0, 1.0]]), balance={})",
    "nk.naoqi.joint_names(NAO, np.array(1.0))",
    "nk.naoqi.limits(NAO, np.broadcast_to('Body', (10**12,)))",
    "nk.naoqi.VirtualNao(NAO, stepped=True).call('ALMotion', 'getBodyNames', fuzz.bad_values.structured())",
    "nk.naoqi.recorded(np.array(1.0), NAO)",
    "nk.robot.SupportPolygon.of_soles([])",
    "nk.robot.SupportPolygon.of_soles([(np.stack([np.eye(4)] * 2), np.zeros((3, 3)))])",
    "nk.world.balance(NAO, STAND, tolerance=np.timedelta64(1, 's'))",
    "nk.rotations.check_rotation(np.zeros((3, 3)), name='L' * 100_000)",
    "nk.rotations.check_rotation(np.zeros((3, 3)), name='a\\0\\x1b[31m')",
    "nk.rotations.random_rotation(0, 2**63)",
    "nk.rotations.RotationSpline(np.arange(3), nk.rotations.rot_x([0.0, 1.0, 3.0]), end=[0, 2**63, 0])",
    "nk.world.dynamic_balance(NAO, np.linspace(0.0, 1e200, 5), np.zeros((5, 25)))",
    "nk.reach.workspace(NAO, 'LArm', samples=100).coarser(10**20)",
    "nk.rotations.random_rotation('L' * 100_000)",
    "nk.rotations.rot_z(np.longdouble('1e4000'))",
    "nk.stream.Targets.of(np.zeros((1, 6)), frames=10**400)",
    "nk.stream.fk(NAO, 'no_such.csv', 3, 'out.csv')",
    "nk.stream.fk(NAO, ['\\ud800', 'walk.csv'], 'LArm', 'out.csv')",
    "nk.stream.read_targets(NAO, 'no_such.csv', [])",
    "nk.Viewer(NAO).show_image('CameraTop', [[0, 1], [2]])",
    "nk.warm_up(np.array(1.0))",
    "nk.world.own_body(1, STAND, [0.0, 0.0], nk.world.camera(NAO, 'CameraTop'))",
    "nk.world.project(NAO, STAND, [1.0, 0.0, 0.0], 1)",
)


@for_all("call", REFUSED)
def test_what_was_once_answered_otherwise_is_refused(call: str) -> None:
    with pytest.raises(nk.NaoKinError) as refused:
        eval(call, {**globals(), "np": np, "nk": nk})
    assert fuzz.unreadable(str(refused.value).replace("\n\t", " ")) == ""


@for_all("call", ("rotations.right_jacobian_inverse(endless)", "ik.numeric(NAO, 'LArm', endless)"))
def test_a_view_of_more_rows_than_memory_has_ends_at_once(call: str) -> None:
    endless = np.broadcast_to(0.0, (10**12, 3))
    with pytest.raises((nk.NaoKinError, MemoryError)):
        eval(f"nk.{call}", {**globals(), "endless": endless})


def fuzzed(*options: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(Path(fuzz.__file__)), *options]
    return subprocess.run(command, capture_output=True, text=True)


def test_wrong_calls_of_a_few_functions_are_refused() -> None:
    done = fuzzed("--seed", "1", "--calls", "30", "--names", "40")
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.full
def test_wrong_calls_of_many_functions_and_commands_are_refused() -> None:
    done = fuzzed("--seed", "2", "--calls", "20", "--names", "100")
    assert done.returncode == 0, done.stdout + done.stderr


BROKEN = """
import os, sys, fuzz, pathlib, nao_kin as nk
def broken(angle):
    {body}
case = fuzz.Case(broken, ["broken(1.0)"], {{"broken": broken}})
fuzz.SECONDS = 1
print(*fuzz.fuzz("broken", case, 3, 3, pathlib.Path("."))[1], sep="\\n")
"""


@for_all(
    ("body", "said"),
    (
        ("raise KeyError(1)", "KeyError: '1'"),
        ("os.abort()", "ended the process with -6"),
        ("while True: pass", "ended the process with 1: Timeout"),
        ("raise nk.NaoKinError('x ' * 600)", "a message of 1199 characters"),
        ("print('Traceback (most recent call last):', file=sys.stderr)", "a traceback on standard error"),
    ),
)
def test_another_error_a_crash_a_hang_and_a_long_message_are_reported(body: str, said: str, tmp_path: Path) -> None:
    paths = os.pathsep.join(filter(None, (str(Path(fuzz.__file__).parent), os.environ.get("PYTHONPATH"))))
    command = [sys.executable, "-c", BROKEN.format(body=body)]
    environment = {**os.environ, "PYTHONPATH": paths}
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, env=environment, check=True)
    lines = done.stdout.splitlines()
    assert len(lines) == 3
    assert all(line.startswith("broken: angle") and said in line for line in lines)


CASES = fuzz.cases()


def test_each_public_function_and_method_is_called_or_left_out_for_a_reason() -> None:
    found = {fuzz.code_of(case.function) for case in CASES.values()}
    # Classes that no example makes are results, and a method without arguments cannot be called wrongly.
    names = {
        name
        for name, function in called()
        if not inspect.isclass(function) and [*inspect.signature(function).parameters] not in ([], ["self"])
    }
    assert names - {name for name, function in called() if fuzz.code_of(function) in found} == set(fuzz.LEFT_OUT)


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("files")
    fuzz.write_files(folder)
    return folder


# `from_photos` has no photos, and commands end in other ways than by an error.
RIGHT = [call for call in map(str.strip, fuzz.CALLS.strip().splitlines()) if "from_photos" not in call]


@for_all("call", RIGHT)
def test_the_right_calls_succeed(call: str, files: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(files)
    eval(call, CASES[call].names)
