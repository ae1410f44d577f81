from __future__ import annotations

import importlib.metadata
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import Capture

from nao_kin.cli import doctor, doctor as probes
from nao_kin.cli.app import run
from nao_kin.cli.doctor import inspect_installation

pytestmark = pytest.mark.full


def test_a_sound_installation_has_no_problems() -> None:
    state = inspect_installation({k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "CONDA"))})
    assert state["problems"] == []
    pin = next(library for library in state["libraries"] if library["name"] == "pin")
    assert pin["version"] == importlib.metadata.version("pin")
    assert Path(pin["location"] or "").name == "pinocchio"


def test_doctor_prints_what_it_found(capsys: Capture, request: pytest.FixtureRequest) -> None:
    assert run(["doctor"]) == 0
    out = capsys.readouterr().out
    assert "No problems found." in out
    assert "yourdfpy" in out
    request.getfixturevalue("loads")
    assert run(["doctor", "--json"]) == 0
    assert {"python", "libraries", "browser", "problems"} <= json.loads(capsys.readouterr().out).keys()


@pytest.fixture
def loads(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let all libraries load at once."""
    monkeypatch.setattr(probes, "_PROBE", "print('25 ')")
    monkeypatch.setattr(probes, "_NUMBA_PROBE", "")


@pytest.mark.usefixtures("loads")
def test_a_ros_workspace_in_the_path_is_named() -> None:
    state = inspect_installation({**os.environ, "PYTHONPATH": "/opt/ros/jazzy/lib/python3.12/site-packages"})
    assert any("/opt/ros/jazzy" in problem and "unset PYTHONPATH" in problem for problem in state["problems"])


@pytest.mark.usefixtures("loads")
def test_the_browser_of_doctor_is_the_one_that_draws_pictures(tmp_path: Path) -> None:
    for name in ("firefox", "chrome"):
        (tmp_path / name).write_text("#!/bin/sh\n")
        (tmp_path / name).chmod(0o755)
    here = {**os.environ, "PATH": str(tmp_path), "NAO_KIN_BROWSER": ""}
    assert inspect_installation(here)["browser"] == str(tmp_path / "chrome")
    (tmp_path / "chrome").unlink()
    assert inspect_installation(here)["browser"] is None  # Firefox draws no pictures
    named = inspect_installation({**here, "NAO_KIN_BROWSER": "/no/browser"})
    assert named["browser"] is None
    assert any("NAO_KIN_BROWSER" in problem and "/no/browser" in problem for problem in named["problems"])


@pytest.mark.usefixtures("loads")
def test_two_pinocchios_in_one_conda_environment_are_named(tmp_path: Path) -> None:
    (tmp_path / "conda-meta").mkdir()
    (tmp_path / "conda-meta" / "pinocchio-3.2.0-py311.json").touch()
    state = inspect_installation({**os.environ, "CONDA_PREFIX": str(tmp_path)})
    assert any("conda" in problem and "both bring Pinocchio" in problem for problem in state["problems"])


def test_the_other_project_called_pinocchio_and_old_or_missing_libraries_are_named(monkeypatch) -> None:
    versions = {"pin": "2.7.0", "pinocchio": "0.4.3", "numpy": "2.0"}

    def version(name: str) -> str:
        if name not in versions:
            raise importlib.metadata.PackageNotFoundError(name)
        return versions[name]

    monkeypatch.setattr(importlib.metadata, "version", version)
    monkeypatch.setattr(doctor.importlib.util, "find_spec", lambda name: None)
    problems = " | ".join(inspect_installation()["problems"])
    assert "pin 2.7.0 is too old" in problems
    assert "'pinocchio' 0.4.3 from PyPI is another project" in problems
    assert "meshcat is not installed: pip install meshcat" in problems


def test_a_model_that_does_not_load_is_a_problem_and_code_1(monkeypatch, capsys: Capture) -> None:
    monkeypatch.setattr(probes, "_NUMBA_PROBE", "")
    monkeypatch.setattr(probes, "_PROBE", "raise ImportError('numpy.core failed')")
    assert run(["doctor"]) == 1
    assert "problem: the NAO does not load: ImportError: numpy.core failed" in capsys.readouterr().out
    monkeypatch.setattr(probes, "_PROBE", "import os; os.abort()")
    assert run(["doctor", "--json"]) == 1
    assert "the process ended with code -6" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "code", "error"),
    [
        (["--help"], 0, ""),
        (["motion", "--help"], 0, ""),
        (["doctor"], 1, ""),
        (["fk", "--posture", "Sit"], 2, "nao-kin: libboost is missing (see nao-kin doctor)\n"),
    ],
)
def test_where_pinocchio_does_not_load_the_program_says_so(
    tmp_path: Path, arguments: list[str], code: int, error: str
) -> None:
    (tmp_path / "pinocchio.py").write_text("raise ImportError('libboost is missing')")
    environment = {**os.environ, "PYTHONPATH": f"{tmp_path}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"}
    command = [sys.executable, "-m", "nao_kin", *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, env=environment)
    assert (done.returncode, done.stderr) == (code, error)


def test_a_system_without_libgomp_is_told_the_package_that_brings_it(tmp_path: Path) -> None:
    lacking = "libgomp.so.1: cannot open shared object file: No such file or directory"
    (tmp_path / "pinocchio.py").write_text(f"raise ImportError({lacking!r})")
    environment = {**os.environ, "PYTHONPATH": f"{tmp_path}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"}
    for words in (["-m", "nao_kin", "fk", "--posture", "Sit"], ["-c", "import nao_kin as nk; nk.load_nao()"]):
        done = subprocess.run([sys.executable, *words], capture_output=True, text=True, env=environment)
        assert done.returncode != 0
        assert "apt-get install libgomp1" in done.stderr.splitlines()[-1]
