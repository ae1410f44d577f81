"""What a shell gets when somebody presses the tab key."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from nao_kin.cli.completion import VARIABLE

ROOT = Path(__file__).resolve().parents[2]
NAO_KIN = [sys.executable, "-m", "nao_kin"]


def _asked(shell: str, **words: str) -> subprocess.CompletedProcess[str]:
    env = {**os.environ, "PYTHONPATH": str(ROOT), VARIABLE: shell, **words}
    return subprocess.run(NAO_KIN, capture_output=True, text=True, env=env)


@pytest.mark.skipif(shutil.which("bash") is None, reason="bash is not installed")
@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("mo", ["motion"]),
        ("motion ch", ["check"]),
        ("fk --po", ["--posture"]),
        ("fk --deg --limits ", ["enforce", "clamp", "ignore", "measured"]),
        ("fk --posture StandI", ["StandInit"]),
        ("fk --posture Stand --frame CameraTop_", ["CameraTop_frame", "CameraTop_optical_frame"]),
        ("ik LLe", ["LLeg"]),
        ("fk --nao v3.2 --posture Crouch --posture Lying", ["LyingBelly", "LyingBack"]),
        ("fk wal", []),  # bash then completes names of files
        ("nothing ", []),
        ("--version ", None),
    ],
)
def test_bash_completes(line: str, expected: list[str] | None, tmp_path: Path) -> None:
    program = tmp_path / "nao-kin"
    program.write_text(f'#!/bin/sh\nexec {shlex.join(NAO_KIN)} "$@"\n')
    program.chmod(0o755)
    words = ["nao-kin", *line.split(" ")]
    script = f"""
        eval "$({VARIABLE}=source_bash nao-kin)"
        COMP_WORDS=({shlex.join(words)}) COMP_CWORD={len(words) - 1}
        _nao_kin_completion nao-kin
        printf '%s\\n' "${{COMPREPLY[@]}}"
        complete -p nao-kin
    """
    env = {**os.environ, "PYTHONPATH": str(ROOT), "PATH": f"{tmp_path}:{os.environ['PATH']}"}
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, env=env)
    assert done.stderr == ""
    *found, declared = done.stdout.splitlines()
    assert declared == "complete -o default -F _nao_kin_completion nao-kin"
    if expected is None:
        assert {"fk", "ik", "motion"} <= set(found)
        assert not any(word[0].isdigit() for word in found)
    else:
        assert found == (expected or [""])


def test_zsh_and_fish_get_names_with_their_help() -> None:
    zsh = _asked("complete_zsh", _TYPER_COMPLETE_ARGS="nao-kin export --forc")
    assert zsh.stdout.startswith("""_arguments '*: :(("--force":"Replace""")
    fish = _asked("complete_fish", _TYPER_COMPLETE_ARGS="nao-kin do", _TYPER_COMPLETE_FISH_ACTION="get-args")
    assert fish.stdout.startswith("doctor\tPrint versions")
    assert "compdef _nao_kin_completion nao-kin" in _asked("source_zsh").stdout
    assert "complete --command nao-kin" in _asked("source_fish").stdout


@pytest.mark.parametrize(("line", "code"), [("nao-kin do", 0), ("nao-kin fk wal", 1)])
def test_fish_completes_files_where_there_are_no_names(line: str, code: int) -> None:
    done = _asked("complete_fish", _TYPER_COMPLETE_ARGS=line, _TYPER_COMPLETE_FISH_ACTION="is-args")
    assert (done.returncode, done.stderr) == (code, "")


def test_a_robot_that_does_not_load_completes_nothing_and_says_nothing() -> None:
    done = _asked("complete_bash", COMP_WORDS="nao-kin fk --urdf none.urdf --frame L", COMP_CWORD="5")
    assert (done.stdout.strip(), done.stderr) == ("", "")
