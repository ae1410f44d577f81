"""The code in the README and the documentation runs as it is shown."""

from __future__ import annotations

import importlib
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from doc_pages import PAGES, PRINTED, ROOT, blocks_of

import nao_kin as nk
from nao_kin.cli.app import run

# What these print is compared with the page, in tests/cli/test_printed_output.py.
WITH_PYTHON = [page for page in PAGES if page not in PRINTED and blocks_of(page, "python")]


def _at_once(page: str, command: str = "") -> tuple[pytest.MarkDecorator, ...]:
    """Return the marks of a page or a command: `make test` runs the README, `make test-all` the other pages.

    An export for ROS, which takes seconds to prove which links never touch, is left to `make test-all` too.
    """
    return () if page == "README.md" and "ros2" not in command else (pytest.mark.full,)


@pytest.mark.parametrize("page", [pytest.param(page, id=page.name, marks=_at_once(page.name)) for page in WITH_PYTHON])
def test_python_examples_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copy(nk.load_nao().urdf_path, tmp_path / "robot.urdf")
    monkeypatch.chdir(tmp_path)
    exec(compile("\n".join(blocks_of(page, "python")), str(page), "exec"), {"__name__": "example"})


def _commands() -> dict[str, str]:
    """Return each command and its first page; commands of the tutorial need its files and have their own test."""
    found = dict[str, str]()
    for page in PAGES:
        for block in blocks_of(page, "sh", "console") if page.name != "getting_started.md" else ():
            for line in block.splitlines():
                command = line.removeprefix("$ ").split("  #")[0].strip()
                # Commands that open a live page wait for a user; they are tested with the viewer.
                ends = " view " not in command or "--html" in command or "--png" in command
                if "nao-kin " in command and "pip" not in command and ends:
                    found.setdefault(command, page.name)
    return found


COMMANDS = _commands()


def _write_inputs(folder: Path, nao: nk.NaoModel) -> None:
    shutil.copy(nao.urdf_path, folder / "nao.urdf")
    names = ",".join(nao.joint_names)
    rows = [f"{0.1 * k},{','.join(map(str, row))}" for k, row in enumerate(nao.random(0, 3, collision_free=True))]
    (folder / "walk.csv").write_text("\n".join([f"time,{names}", *rows]) + "\n")
    measured = "LFsr,RFsr,GyroX,GyroY,GyroZ,AngleX,AngleY,AccX,AccY,AccZ"
    stand = ",".join(map(str, nao.posture("Stand")))
    still = [f"{0.1 * k},{stand},20,30,0,0,0,0,0.02,0,0,9.8" for k in range(3)]
    (folder / "log.csv").write_text("\n".join([f"time,{names},{measured}", *still]) + "\n")
    for file, joints in (("head.csv", nao.chains["Head"]), ("legs.csv", (*nao.chains["LLeg"], *nao.chains["RLeg"]))):
        text = "\n".join(f"{0.1 * k},{'0.1,' * len(joints)}20,30" for k in range(3))
        (folder / file).write_text(f"time,{','.join(joints)},LFsr,RFsr\n{text}\n")
    (folder / "walk.json").write_text(json.dumps([nao.angles(row) for row in nao.random(0, 3)]))
    wave = nk.Motion([[0.0, 1.0, 2.0], [0.5, 1.5]], ["LShoulderRoll", "LHand"], [[0.2, 1.0, 0.2], [0.0, 1.0]], "smooth")
    nk.motion.write_motion(wave, folder / "wave.xar")


def _needs_a_shell(command: str) -> bool:
    return any(sign in shlex.split(command) for sign in ("|", ">", "<", "&&"))


@pytest.mark.full
@pytest.mark.parametrize("command", [*filter(_needs_a_shell, COMMANDS)])
def test_commands_run_in_a_shell(command: str, tmp_path: Path, nao: nk.NaoModel) -> None:
    _write_inputs(tmp_path, nao)
    program = f"{shlex.quote(sys.executable)} -m nao_kin"
    done = subprocess.run(
        ["bash", "-c", re.sub(r"\bnao-kin\b", program, command)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert done.returncode == 0, done.stderr


# In this process, where the library is loaded already; as a process the program runs above, and in the tutorial.
@pytest.mark.parametrize(
    "command",
    [
        pytest.param(command, id=f"{page}-{command}", marks=_at_once(page, command))
        for command, page in COMMANDS.items()
        if not _needs_a_shell(command)
    ],
)
def test_commands_run(
    command: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    nao: nk.NaoModel,
    capfd: pytest.CaptureFixture[str],
) -> None:
    _write_inputs(tmp_path, nao)
    monkeypatch.chdir(tmp_path)
    program, *words = shlex.split(command)
    assert program == "nao-kin"
    assert run(words) == 0, capfd.readouterr().err


def test_the_readme_is_short_and_has_its_five_examples() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(text.splitlines()) < 100
    assert len(blocks_of(ROOT / "README.md", "python")) == 5


def test_the_readme_leads_to_files_that_are_here() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    targets = [target for target in re.findall(r"\]\(([^)]+)\)", text) if not target.startswith("https://")]
    assert "docs/images/view.jpg" in targets
    for target in targets:
        assert (ROOT / target).is_file(), target
    assert not re.search(r"<(?:img|a)\b", text)
    assert "nao-kin/nao_kin" not in text


def test_the_readme_begins_with_the_commands_that_work_on_a_fresh_machine() -> None:
    first, second = blocks_of(ROOT / "README.md", "sh", "console")
    assert [line.split()[:2] for line in first.splitlines()] == [["make", "demo"], ["make", "test"]]
    assert second.startswith("$ pip install . ")


def test_pictures_are_described_in_one_line() -> None:
    # A line break in a description leaves no space between its words.
    for page in PAGES:
        for words in re.findall(r"!\[([^\]]*)\]", page.read_text(encoding="utf-8")):
            assert words.strip(), page.name
            assert "\n" not in words, f"{page.name}: {words}"


def test_no_page_leads_outside_the_project() -> None:
    for page in PAGES:
        for target in re.findall(r"\]\((?!https?://|#)([^)]+)\)", page.read_text(encoding="utf-8")):
            assert (page.parent / target.split("#")[0]).exists(), f"{page.name}: {target}"


def test_the_page_of_places_leads_to_files_that_are_here() -> None:
    text = (ROOT / "docs" / "where_is.md").read_text(encoding="utf-8")
    places = [*re.findall(r"`([^` ]*(?:/|\.py))`", text), "Makefile", "scripts/faults.tsv"]
    assert len(places) > 40
    outside = ("tests/", "web/", "scripts/", ".ci/", ".github/", "Makefile", "nao_kin/")
    for place in places:
        assert (ROOT / ("" if place.startswith(outside) else "nao_kin") / place).exists(), place


def test_the_citation_names_the_last_release_and_the_version_is_newer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(ROOT / "scripts")
    problems = importlib.import_module("check_release").problems
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    last = re.findall(r"^## \[(\d+\.\d+\.\d+)\]", changelog, re.M)[0]
    assert problems(f"v{last}") in ([], [f"the tag is v{last}, the version of the package is {nk.__version__}"])
    if "## [Unreleased]" in changelog:  # what is installed from here is no release, and says so
        assert nk.__version__.endswith(".dev0")
        assert tuple(map(int, nk.__version__.split(".")[:3])) > tuple(map(int, last.split(".")))
    wrong = problems("v9.9")
    assert len(wrong) == 4
    assert "is no release" in wrong[1]
