"""The notebooks run from top to bottom, and the repository holds them with their outputs."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import nao_kin as nk

pytestmark = pytest.mark.full

FOLDER = Path(__file__).resolve().parents[2] / "examples"
# Outputs are kept, so that a reader who runs nothing sees the pictures, in the repository and in the documentation.
LECTURE = sorted((FOLDER / "notebooks").glob("*.ipynb"))
NOTEBOOKS = [*sorted(FOLDER.glob("*.ipynb")), *LECTURE]

# Each in a kernel of its own, two at a time; beside each result what went wrong.
RUN = """
import asyncio, sys, traceback
from pathlib import Path
import nbformat
from nbclient import NotebookClient

async def run(path, turns):
    notebook, folder = nbformat.read(path, as_version=4), {"metadata": {"path": str(path.parent)}}
    async with turns:
        try:
            await NotebookClient(notebook, timeout=300, kernel_name="python3", resources=folder).async_execute()
        except Exception:
            Path(path.stem + ".txt").write_text(traceback.format_exc(), "utf-8")
        else:
            nbformat.write(notebook, path.name)

async def main():
    turns = asyncio.Semaphore(2)
    await asyncio.gather(*(run(Path(path), turns) for path in sys.argv[1:]))

asyncio.run(main())
"""

NUMBER = re.compile(r"-?\d+\.?\d*(?:e[+-]\d+)?")


def cells(path: Path, kind: str = "code") -> list[dict[str, Any]]:
    return [cell for cell in json.loads(path.read_text("utf-8"))["cells"] if cell["cell_type"] == kind]


def printed(path: Path) -> list[str]:
    """Return the output of each cell and its warnings."""
    streams = [[output for output in cell["outputs"] if output["output_type"] == "stream"] for cell in cells(path)]
    return ["".join("".join(output["text"]) for output in outputs) for outputs in streams]


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Run all notebooks and return the folder with the results."""
    pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    pytest.importorskip("matplotlib")
    folder = tmp_path_factory.mktemp("runs")
    package = str(Path(nk.__file__).parent.parent)
    own = {name: str(folder / name) for name in ("IPYTHONDIR", "JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR")}
    done = subprocess.run(
        [sys.executable, "-c", RUN, *map(str, NOTEBOOKS)],
        cwd=folder,
        env={**os.environ, **own, "PYTHONPATH": package},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return folder


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(path: Path, runs: Path) -> None:
    wrong = runs / f"{path.stem}.txt"
    assert not wrong.exists(), wrong.read_text("utf-8")[-2000:]
    if path in LECTURE:
        for old, new in zip(printed(path), printed(runs / path.name), strict=True):
            assert NUMBER.sub("", old).split() == NUMBER.sub("", new).split()
            assert [float(number) for number in NUMBER.findall(new)] == pytest.approx(
                [float(number) for number in NUMBER.findall(old)], rel=1e-3, abs=2e-3
            )


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_stands_here_as_it_was_run_last(path: Path) -> None:
    assert [cell["execution_count"] for cell in cells(path)] == list(range(1, len(cells(path)) + 1))
    outputs = [output for cell in cells(path) for output in cell["outputs"]]
    assert outputs
    assert {output["output_type"] for output in outputs} <= {"stream", "display_data", "execute_result"}
    assert {output["name"] for output in outputs if output["output_type"] == "stream"} == {"stdout"}


def test_the_page_of_the_paper_names_every_error_that_its_notebook_refutes() -> None:
    refuted = re.findall(r"^! (.*?): printed: ", "".join(printed(FOLDER / "paper.ipynb")), re.MULTILINE)
    page = (FOLDER.parent / "docs" / "paper.md").read_text("utf-8")
    assert len(refuted) == 11
    assert sorted(refuted) == sorted(re.findall(r"^\| ((?:problem \d|appendix).*?) \|", page, re.MULTILINE))


def test_the_lecture_has_its_seven_notebooks() -> None:
    assert [path.stem[0] for path in LECTURE] == list("1234567")


@pytest.mark.parametrize("path", LECTURE, ids=lambda path: path.stem)
def test_a_notebook_of_the_lecture_stays_small(path: Path) -> None:
    assert path.stat().st_size < 450_000
    assert 20 <= len(cells(path)) + len(cells(path, "markdown")) <= 35


@pytest.mark.parametrize("path", LECTURE, ids=lambda path: path.stem)
def test_every_exercise_has_a_folded_solution_that_checks_itself(path: Path) -> None:
    exercises = sum("".join(cell["source"]).count("### Exercise") for cell in cells(path, "markdown"))
    solutions = [cell for cell in cells(path) if "solution" in cell["metadata"].get("tags", ())]
    assert len(solutions) >= 4
    assert exercises >= len(solutions)
    for cell in solutions:
        assert "\nassert " in "".join(cell["source"]) or "\n    assert " in "".join(cell["source"])
        assert cell["metadata"]["jupyter"]["source_hidden"]


@pytest.mark.parametrize("path", LECTURE, ids=lambda path: path.stem)
def test_pictures_are_described_in_words(path: Path) -> None:
    drawn = [cell for cell in cells(path) if any("image/png" in output.get("data", ()) for output in cell["outputs"])]
    assert len(drawn) >= 3
    for cell in drawn:
        assert len(cell["metadata"]["alt"]) > 20
