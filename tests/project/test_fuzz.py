"""Wrong arguments and damaged files neither crash nor hang the interpreter, and commands print no traceback."""

from __future__ import annotations

import inspect
import os
import subprocess
import sys
from pathlib import Path

import fuzz
import pytest
from loops import for_all
from public_names import called


@pytest.mark.full
def test_wrong_calls_of_many_functions_and_commands_end() -> None:
    command = [sys.executable, fuzz.__file__, *"--seed 2 --calls 20 --names 100".split()]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


BROKEN = """
import os, sys, fuzz, pathlib, nao_kin as nk
def broken(angle):
    {body}
case = fuzz.Case(broken, ["broken(1.0)"], {{"broken": broken}})
fuzz.SECONDS = 1
print(*fuzz.fuzz("broken", case, 3, 3, pathlib.Path("."))[1], sep="\\n")
"""


@pytest.mark.full
@for_all(
    ("body", "said"),
    (
        ("os.abort()", "ended the process with -6"),
        ("while True: pass", "ended the process with 1: Timeout"),
        ("print('Traceback (most recent call last):', file=sys.stderr)", "a traceback on standard error"),
    ),
)
def test_a_crash_a_hang_and_a_traceback_are_reported(body: str, said: str, tmp_path: Path) -> None:
    paths = os.pathsep.join(filter(None, (str(Path(fuzz.__file__).parent), os.environ.get("PYTHONPATH"))))
    command = [sys.executable, "-c", BROKEN.format(body=body)]
    environment = {**os.environ, "PYTHONPATH": paths}
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, env=environment, check=True)
    lines = done.stdout.splitlines()
    assert lines
    assert all(line.startswith("broken: angle") and said in line for line in lines)


def test_each_public_function_and_method_is_called_or_left_out_for_a_reason() -> None:
    found = {fuzz.code_of(case.function) for case in fuzz.cases().values()}
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
    eval(call, fuzz.cases()[call].names)
