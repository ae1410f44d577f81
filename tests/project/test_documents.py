"""The code in the README and the documentation runs as it is shown."""

from __future__ import annotations

import importlib
import inspect
import re
import shutil
from pathlib import Path
from typing import Any

import pytest
from doc_commands import ENDS_WITH, SKIPPED, check, commands_of, run_page, why_skipped
from doc_pages import PAGES, PRINTED, ROOT, blocks_of
from public_names import called

import nao_kin as nk

# What these print is compared with the page, in tests/cli/test_printed_output.py, which runs their command lines too.
WITH_PYTHON = [page for page in PAGES if page not in PRINTED and blocks_of(page, "python")]
WITH_COMMANDS = [page for page in PAGES if page not in (ROOT / "README.md", *PRINTED) and commands_of(page)]

# What is read first runs in every test, all other pages in the full ones.
FIRST = ("README.md", "getting_started.md", "command_line.md")


def first(pages: list[Path]) -> list[Any]:
    return [pytest.param(page, marks=() if page.name in FIRST else pytest.mark.full) for page in pages]


@pytest.mark.parametrize("page", first(WITH_PYTHON), ids=lambda page: page.name)
def test_pages_run_as_they_are_written(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copy(nk.load_nao().urdf_path, tmp_path / "robot.urdf")
    monkeypatch.chdir(tmp_path)
    check(run_page(page, python=True))


@pytest.mark.parametrize("page", first(WITH_COMMANDS), ids=lambda page: page.name)
def test_command_lines_run_as_they_are_written(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    check(run_page(page))


def test_few_command_lines_are_left_out_and_each_for_a_reason() -> None:
    lines = [line for page in PAGES for line in commands_of(page)]
    left_out = [line for line in lines if why_skipped(line)]
    assert len(lines) > 120
    assert len(left_out) < 15
    for pattern in SKIPPED:
        assert any(re.search(pattern, line) for line in left_out), pattern
    assert set(lines) >= ENDS_WITH.keys()


def test_the_readme_is_short_and_has_its_five_examples_and_a_picture() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(text.splitlines()) < 100
    assert len(blocks_of(ROOT / "README.md", "python")) == 5
    assert "](docs/images/view.jpg)" in text
    assert not re.search(r"<(?:img|a)\b", text)


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


def _is_error(value: object) -> bool:
    return isinstance(value, type) and issubclass(value, BaseException)


def test_every_argument_that_replaces_a_guess_exists() -> None:
    lines = (ROOT / "docs" / "guesses.md").read_text(encoding="utf-8").splitlines()
    rows = [line.split(" | ") for line in lines if line.startswith("| ")]
    assert len(rows) > 50
    assert all(len(row) == 5 for row in rows)
    last = " ".join(row[4] for row in rows)
    parameters = {name for _, value in called() if not _is_error(value) for name in inspect.signature(value).parameters}
    assert set(re.findall(r"`(\w+)=", last)) - {"scale"} <= parameters  # an attribute of a URDF
    sources = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "nao_kin" / "cli").glob("*.py"))
    for option in set(re.findall(r"`--([a-z-]+)`", last)):
        assert f'"--{option}"' in sources or re.search(rf"\b{option.replace('-', '_')}: ", sources), option
