"""What the documentation says that a block prints is what it prints."""

from __future__ import annotations

import contextlib
import io
import itertools
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

import nao_kin as nk

DOCS = Path(__file__).resolve().parent.parent / "docs"
# Pages on which every Python block that prints is followed by a block with what it prints.
SHOWN = ["coming_from.md", "getting_started.md", "logs.md", "troubleshooting.md"]
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)


def _blocks(page: str) -> list[tuple[str, str]]:
    return BLOCK.findall((DOCS / page).read_text(encoding="utf-8"))


@pytest.mark.parametrize("page", SHOWN)
def test_blocks_print_what_stands_under_them(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    blocks = [*_blocks(page), ("", "")]
    names: dict[str, object] = {"__name__": "example"}
    for (kind, code), (shown_kind, shown) in itertools.pairwise(blocks):
        if kind != "python":
            continue
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(compile(code, page, "exec"), names)
        if out.getvalue():
            assert shown_kind == "text", f"{page} shows nothing under:\n{code}"
            assert [line.rstrip() for line in out.getvalue().splitlines()] == shown.splitlines(), code


def _refusals() -> list[tuple[str, list[str]]]:
    shown = [text.splitlines() for kind, text in _blocks("troubleshooting.md") if kind == "text"]
    return [(lines[0].removeprefix("$ "), lines[1:]) for lines in shown if lines[0].startswith("$ nao-kin ")]


@pytest.mark.parametrize(("command", "said"), _refusals(), ids=lambda value: str(value)[:60])
def test_commands_are_refused_as_the_page_says(command: str, said: list[str], tmp_path: Path) -> None:
    (tmp_path / "broken.urdf").write_text(nk.load_nao().urdf_path.read_text(encoding="utf-8"), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "nao_kin", *shlex.split(command)[1:]], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode != 0
    assert done.stderr.splitlines() == said
