"""What a shell gets when somebody presses the tab key."""

from __future__ import annotations

import os
import select
import shlex
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from command_line import Capture

from nao_kin.cli.app import run
from nao_kin.cli.parsing import SETUP, VARIABLE

ROOT = Path(__file__).resolve().parents[2]
NAO_KIN = [sys.executable, "-m", "nao_kin"]


@pytest.fixture
def asked(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> Callable[..., tuple[int, str]]:
    """What the program answers to a shell: its exit code, and what it prints."""

    def answer(shell: str, **words: str) -> tuple[int, str]:
        for name, text in {VARIABLE: shell, **words}.items():
            monkeypatch.setenv(name, text)
        code = run([])
        out, err = capsys.readouterr()
        assert err == ""
        return code, out

    return answer


@pytest.fixture
def env(tmp_path: Path) -> dict[str, str]:
    """The environment of a user with an empty home, who has the program."""
    program = tmp_path / "nao-kin"
    program.write_text(f'#!/bin/sh\nexec {shlex.join(NAO_KIN)} "$@"\n')
    program.chmod(0o755)
    home = {"HOME": str(tmp_path), "XDG_CONFIG_HOME": str(tmp_path / ".config"), "TERM": "xterm"}
    return {**os.environ, **home, "PYTHONPATH": str(ROOT), "PATH": f"{tmp_path}:{os.environ['PATH']}"}


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
        ("fk --frame LArm,CameraTop_o", ["LArm,CameraTop_optical_frame"]),
        ("fk --nao v3", ["v3.2", "v3.3"]),
        ("fk --robot na", ["nao"]),
        ("motion convert --to bhu", []),  # which is only read
        ("motion convert --from bhu", ["bhuman"]),
        ("motion plot --joint LHipY", ["LHipYawPitch"]),
        ("sample wa", ["walk.csv", "wave.xar"]),
        ("fk wal", []),  # bash then completes names of files
        ("nothing ", []),
        ("--version ", None),
    ],
)
def test_bash_completes(line: str, expected: list[str] | None, asked: Callable[..., tuple[int, str]]) -> None:
    words = f"nao-kin {line}"
    found = asked("complete_bash", COMP_WORDS=words, COMP_CWORD=str(words.count(" ")))[1].split()
    if expected is None:
        assert {"fk", "ik", "motion"} <= set(found)
    else:
        assert found == expected


@pytest.mark.full
@pytest.mark.skipif(shutil.which("bash") is None, reason="bash is not installed")
def test_bash_gets_the_names_by_the_script(env: dict[str, str]) -> None:
    script = f"""
        eval "$({VARIABLE}=source_bash nao-kin)"
        COMP_WORDS=(nao-kin fk --frame LArm,CameraTop_o) COMP_CWORD=3
        _nao_kin_completion nao-kin
        printf '%s\\n' "${{COMPREPLY[@]}}"
        complete -p nao-kin
    """
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, env=env)
    declared = "complete -o default -F _nao_kin_completion nao-kin"
    assert (done.stderr, done.stdout.splitlines()) == ("", ["LArm,CameraTop_optical_frame", declared])


def test_zsh_and_fish_get_names_with_their_help(asked: Callable[..., tuple[int, str]]) -> None:
    zsh = asked("complete_zsh", _TYPER_COMPLETE_ARGS="nao-kin export --forc")[1]
    assert zsh.startswith("""_arguments '*: :(("--force":"Replace""")
    fish = asked("complete_fish", _TYPER_COMPLETE_ARGS="nao-kin do", _TYPER_COMPLETE_FISH_ACTION="get-args")[1]
    assert fish.startswith("doctor\tPrint versions")
    assert "compdef _nao_kin_completion nao-kin" in asked("source_zsh")[1]
    assert "complete --command nao-kin" in asked("source_fish")[1]


@pytest.mark.parametrize(("line", "code"), [("nao-kin do", 0), ("nao-kin fk wal", 1)])
def test_fish_completes_files_where_there_are_no_names(
    line: str, code: int, asked: Callable[..., tuple[int, str]]
) -> None:
    assert asked("complete_fish", _TYPER_COMPLETE_ARGS=line, _TYPER_COMPLETE_FISH_ACTION="is-args")[0] == code


@pytest.mark.parametrize("name", ["none.urdf", "pipe.urdf", "code.urdf.xacro"])
def test_a_robot_that_does_not_load_completes_nothing_and_says_nothing(
    tmp_path: Path, name: str, asked: Callable[..., tuple[int, str]]
) -> None:
    os.mkfifo(tmp_path / "pipe.urdf")  # which would wait for ever
    ran = tmp_path / "ran"
    link = f"""<link name="L${{open('{ran}', 'w').close()}}"/>"""
    head = '<robot name="a" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="a" value="b"/>'
    (tmp_path / "code.urdf.xacro").write_text(f"{head}{link}</robot>")
    words = f"nao-kin fk --urdf {tmp_path / name} --frame L"
    assert asked("complete_bash", COMP_WORDS=words, COMP_CWORD="5")[1].strip() == ""
    assert not ran.exists()


@pytest.mark.full
@pytest.mark.skipif(shutil.which("fish") is None, reason="fish is not installed")
def test_fish_completes_after_the_line_of_the_page(env: dict[str, str]) -> None:
    page = (ROOT / "docs/command_line.md").read_text(encoding="utf-8")
    assert all(line in page.splitlines() for line in SETUP.values())
    subprocess.run(["sh", "-c", SETUP["fish"]], env=env, check=True)
    for typed, found in (
        ("fk --frame LArm,CameraTop_o", ["LArm,CameraTop_optical_frame"]),
        ("sample wal", ["walk.csv"]),
    ):
        done = subprocess.run(
            ["fish", "-c", f"complete --do-complete 'nao-kin {typed}'"], capture_output=True, text=True, env=env
        )
        assert (done.stdout.split(), done.stderr) == (found, "")


@pytest.mark.full
@pytest.mark.skipif(shutil.which("zsh") is None, reason="zsh is not installed")
def test_zsh_completes_after_the_line_of_the_page(env: dict[str, str], tmp_path: Path) -> None:
    (tmp_path / ".zshrc").write_text("PROMPT='ready> '; autoload -Uz compinit; compinit -u\n")
    subprocess.run(["sh", "-c", SETUP["zsh"]], env=env, check=True)
    import pty

    terminal, inside = pty.openpty()
    with subprocess.Popen(
        ["zsh", "-i"], stdin=inside, stdout=inside, stderr=inside, env=env, start_new_session=True
    ) as shell:
        os.close(inside)
        try:
            assert _shown(terminal, "ready> ")
            os.write(terminal, b"nao-kin fk --frame LArm,CameraTop_o\t")
            assert _shown(terminal, "optical_frame")
        finally:
            shell.kill()
            os.close(terminal)


def _shown(terminal: int, text: str) -> bool:
    """Return whether a text is printed in a terminal, at last after a minute."""
    printed, end = "", time.monotonic() + 60.0
    while text not in printed and time.monotonic() < end:
        if select.select([terminal], [], [], 1.0)[0]:
            printed += os.read(terminal, 4096).decode(errors="replace")
    return text in printed


def test_install_completion_names_the_line_for_the_shell(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    for shell, line in (*SETUP.items(), ("dash", SETUP["bash"])):
        monkeypatch.setenv("SHELL", f"/usr/bin/{shell}")
        for words in (["--install-completion"], ["fk", "--show-completion", "zsh"]):
            assert run(words) == 2
            assert capsys.readouterr().err.endswith(f"-completion (to set up completion: {line})\n")
