"""Former options work for a release and warn; the help shows the new ones alone."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import nao_kin as nk
from nao_kin._core.warn import FORMER_NAMES, FormerName
from nao_kin.cli import options
from nao_kin.cli.app import run

OUTSIDE = ("--joint", "HeadYaw=3")
TARGET = ("--target", "0.15 0.12 0.05")
FILES = ("{folder}/wave.json", "{folder}/tame.json", "--force")
# A command line for each former option and each command that had it, with {} in place of the option.
LINES: dict[str, dict[str, tuple[str, ...]]] = {
    "--clamp": {"fk": (*OUTSIDE, "{}"), "balance": (*OUTSIDE, "{}"), "motion convert": (*FILES, "{}")},
    "--ignore-limits": {
        "fk": (*OUTSIDE, "{}"),
        "ik": ("LArm", *TARGET, "{}"),
        "balance": (*OUTSIDE, "{}"),
        "collisions": (*OUTSIDE, "{}"),
        "camera": (*OUTSIDE, "{}"),
    },
    "--reference": {"ik": ("LArm", *TARGET, "{}", "Crouch")},
    "--frames": {"view": ("{}", "LHand,RHand", "--html", "{folder}/nao.html", "--force")},
    "--record": {"live": ("--lola", "{folder}/none", "{}", "{folder}/none/wave.json")},
    "--version": {"info": ("{}", "v5"), "fk": ("{}=v5",), "motion check": ("{folder}/wave.json", "{}", "v5")},
}
ROWS = [row for row in FORMER_NAMES if row.where.startswith("nao-kin")]
CASES = [(row, command) for row in ROWS for command in LINES[row.old]]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("former")
    nk.motion.write_motion(nk.Motion([0.0, 1.0], ["HeadYaw"], np.array([[0.0], [2.5]])), path / "wave.json")
    return path


@pytest.mark.parametrize(("row", "command"), CASES, ids=lambda value: str(getattr(value, "old", value)))
def test_a_former_option_does_the_same_and_warns(
    row: FormerName, command: str, folder: Path, capsys: pytest.CaptureFixture
) -> None:
    answers = []
    for name in (row.old, row.new):
        words = [word for text in LINES[row.old][command] for word in text.replace("{}", name).split(" ")]
        if command == "ik":  # --target is one word
            words = [word.replace("{}", name) for word in LINES[row.old][command]]
            words = [part for word in words for part in (word.split(" ") if word == name else [word])]
        code = run([*command.split(), *(word.replace("{folder}", str(folder)) for word in words)])
        answers.append((code, *capsys.readouterr()))
    (code, out, err), (new_code, new_out, new_err) = answers
    warning = f"nao-kin: {row.old} is now {row.new}; the next release does not accept {row.old}\n"
    assert err.count(warning) == 1
    assert (code, out, err.replace(warning, "")) == (new_code, new_out, new_err)
    assert row.old not in new_err


def test_every_former_option_of_every_command_is_tried() -> None:
    for row in ROWS:
        commands = row.where.removeprefix("nao-kin").strip()
        assert not commands or set(commands.split(", ")) == set(LINES[row.old])


def test_no_help_shows_a_former_option(capsys: pytest.CaptureFixture) -> None:
    for name in options.COMMANDS:
        assert run([*name.split(), "--help"]) == 0
        shown = set(re.findall(r"(?<![\w-])--[a-z-]+", capsys.readouterr().out))
        former = {row.old for row in ROWS if not row.where[8:] or name in row.where[8:].split(", ")}
        assert not former & shown, name


def test_a_former_option_is_none_of_another_command(capsys: pytest.CaptureFixture) -> None:
    assert run(["fk", "--record", "x.json"]) == 2
    assert "no such option: --record" in capsys.readouterr().err
    assert run(["collisions", "--clamp"]) == 2
    assert "no such option: --clamp" in capsys.readouterr().err
