"""Every example runs, and prints what the gallery shows."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import nao_kin as nk
from nao_kin._core.extras import EXTRAS

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

import generate_gallery  # noqa: E402 - found beside the other scripts

pytestmark = pytest.mark.full

EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
SHOWN = generate_gallery.printed_in(generate_gallery.pages_of())
# In a process of their own: one that draws with matplotlib, one that saves a page.
ALONE = {"gimbal_lock", "first_pose"}


def _by_name(path: Path) -> str:
    return path.stem


def _require(path: Path) -> None:
    extra = generate_gallery.read_example(path).extra
    if extra == "robots":
        try:
            nk.load_robot("romeo")
        except nk.errors.MissingExtra as error:
            pytest.skip(str(error))
    elif extra:
        for module in EXTRAS[extra].modules:
            pytest.importorskip(module, reason=f"needs nao-kin[{extra}]")


@pytest.fixture
def _drawing_without_a_window(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setenv("MPLBACKEND", "Agg")
    yield
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")


@pytest.mark.usefixtures("_drawing_without_a_window")
@pytest.mark.parametrize("path", [path for path in EXAMPLES if path.stem not in ALONE], ids=_by_name)
def test_an_example_prints_what_the_gallery_shows(path: Path, tmp_path: Path) -> None:
    _require(path)
    assert generate_gallery.run_example(path.stem, tmp_path) == SHOWN[path.stem]
    for name in re.findall(r"^see (\S+)$", SHOWN[path.stem], re.MULTILINE):
        assert (tmp_path / name).stat().st_size > 1000


@pytest.mark.parametrize("path", [path for path in EXAMPLES if path.stem in ALONE], ids=_by_name)
def test_an_example_runs_alone_and_draws_into_the_folder_given(path: Path, tmp_path: Path) -> None:
    _require(path)
    (tmp_path / "pictures").mkdir()
    done = subprocess.run(
        [sys.executable, str(path), "pictures"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT), "MPLBACKEND": "Agg"},
        capture_output=True,
        text=True,
        encoding="utf-8",
        timeout=120,
        check=False,
    )
    assert (done.returncode, done.stdout) == (0, SHOWN[path.stem].replace("see ", f"see pictures{os.sep}")), done.stderr
    assert [file.stem for file in (tmp_path / "pictures").iterdir()] == [path.stem]


NEEDING = [path for path in EXAMPLES if generate_gallery.read_example(path).required]


@pytest.mark.parametrize("path", NEEDING, ids=_by_name)
def test_an_example_whose_extra_is_missing_says_so_in_one_line(path: Path, tmp_path: Path) -> None:
    extra = EXTRAS[generate_gallery.read_example(path).extra]
    done = subprocess.run(
        [sys.executable, str(path)],
        cwd=tmp_path,
        env=os.environ
        | {
            "PYTHONPATH": os.pathsep.join((str(ROOT / "tests" / "hidden"), str(ROOT))),
            "NAO_KIN_HIDDEN": " ".join((*extra.packages, *extra.modules)),
        },
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert (done.returncode, len(done.stderr.splitlines())) == (1, 1), done.stderr
    assert f"pip install 'nao-kin[{extra.name}]'" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_there_are_thirty_three_examples_and_the_gallery_is_in_step_with_them() -> None:
    assert len(EXAMPLES) == 34
    assert generate_gallery.faults() == []
    assert generate_gallery.main(["--check"]) == 0


@pytest.mark.parametrize("path", EXAMPLES, ids=_by_name)
def test_an_example_fits_on_one_screen_and_says_what_one_learns(path: Path) -> None:
    assert 15 <= len(path.read_text(encoding="utf-8").splitlines()) <= 60
    example = generate_gallery.read_example(path)
    assert example.text.startswith("Learn ")
    assert example.extra in {"", *EXTRAS}


def test_an_example_that_differs_is_a_fault(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    docs = tmp_path
    shutil.copytree(generate_gallery.DOCS / "gallery", docs / "gallery")
    shutil.copy(generate_gallery.DOCS / "gallery.md", docs)
    page = docs / "gallery" / "first_pose.md"
    page.write_text(page.read_text(encoding="utf-8").replace("A first pose", "A pose"), "utf-8")
    assert generate_gallery.faults(docs) == [
        "docs/gallery/first_pose.md is not in step with the docstrings of the examples"
    ]
    monkeypatch.setitem(generate_gallery.SECTIONS, "Poses", ["first_pose", "second_pose"])
    found = generate_gallery.faults(docs)
    assert "hand_path is in no section of scripts/generate_gallery.py" in found
    assert "examples/second_pose.py does not exist" in found
