"""What the README and the documentation show is run as it stands."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import nao_kin as nk

ROOT = Path(__file__).resolve().parent.parent
# Those of the folder lecture are written from the notebooks, which run by themselves.
PAGES = [
    ROOT / "README.md",
    *sorted((ROOT / "docs").glob("[!_]*.md")),
    *(page for page in sorted((ROOT / "docs").glob("[!_]*/*.md")) if page.parent.name != "lecture"),
]


def _blocks(page: Path, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("page", [page for page in PAGES if _blocks(page, "python")], ids=lambda page: page.name)
def test_python_examples_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copy(nk.load_nao().urdf_path, tmp_path / "robot.urdf")
    monkeypatch.chdir(tmp_path)
    exec(compile("\n".join(_blocks(page, "python")), str(page), "exec"), {"__name__": "example"})


def _commands() -> list[tuple[str, str]]:
    found = []
    for page in PAGES:
        lines = [
            line.removeprefix("$ ")
            for kind in ("sh", "console")
            for block in _blocks(page, kind)
            for line in block.split("\n")
        ]
        found += [
            (page.name, line.split("  #")[0].strip()) for line in lines if "nao-kin " in line and "pip" not in line
        ]
    # A live page waits for a person and a browser; that it does is tested with the viewer.
    return [
        (page, command)
        for page, command in found
        if " view " not in command or "--html" in command or "--png" in command
    ]


@pytest.mark.parametrize(("page", "command"), _commands(), ids=lambda value: value)
def test_commands_run(page: str, command: str, tmp_path: Path, nao: nk.NaoModel) -> None:
    import json

    shutil.copy(nao.urdf_path, tmp_path / "nao.urdf")
    names = ",".join(nao.joint_names)
    rows = "\n".join(",".join(map(str, row)) for row in nao.random(0, 3))
    (tmp_path / "walk.csv").write_text(f"{names}\n{rows}\n")
    (tmp_path / "walk.json").write_text(json.dumps([nao.angles(row) for row in nao.random(0, 3)]))
    wave = nk.Motion([[0.0, 1.0, 2.0], [0.5, 1.5]], ["LShoulderRoll", "LHand"], [[0.2, 1.0, 0.2], [0.0, 1.0]], "smooth")
    nk.motion.write_motion(wave, tmp_path / "wave.xar")
    program = f"{shlex.quote(sys.executable)} -m nao_kin"
    done = subprocess.run(
        ["bash", "-c", re.sub(r"\bnao-kin\b", program, command)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert done.returncode == 0, done.stderr


def test_the_readme_is_short_and_has_its_five_examples() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(text.splitlines()) < 120
    assert len(_blocks(ROOT / "README.md", "python")) == 5


def test_the_readme_shows_the_same_on_the_package_index() -> None:
    # There it stands alone: what it shows and leads to has an address of its own, that of a file which is here.
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    targets = re.findall(r"\]\(([^)]+)\)", text)
    assert targets
    for target in targets:
        assert target.startswith("https://"), target
        ours = re.match(r"https://(?:raw\.githubusercontent|github)\.com/nao-kin/nao_kin/(?:blob/)?main/(.+)", target)
        assert ours is None or (ROOT / ours.group(1)).is_file(), target
    assert not re.search(r"<(?:img|a)\b", text)


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


def test_the_citation_names_this_version() -> None:
    assert f"\nversion: {nk.__version__}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
