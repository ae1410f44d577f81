"""What the documentation says that a block prints, or a command says, is what is printed."""

from __future__ import annotations

import contextlib
import io
import itertools
import math
import os
import re
import shlex
import shutil
import socket
import subprocess
import sys
from pathlib import Path

import pytest

import nao_kin as nk
from nao_kin._common import kernel_cache

DOCS = Path(__file__).resolve().parent.parent / "docs"
# Pages on which every Python block that prints is followed by a block with what it prints.
SHOWN = ["coming_from.md", "getting_started.md", "logs.md", "troubleshooting.md"]
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
# The command line where matplotlib is not installed.
WITHOUT_EXTRA = "import runpy, sys; sys.modules['matplotlib'] = None; runpy.run_module('nao_kin', run_name='__main__')"


def _blocks(page: str) -> list[tuple[str, str]]:
    return BLOCK.findall((DOCS / page).read_text(encoding="utf-8"))


@pytest.mark.parametrize("page", SHOWN)
def test_blocks_print_what_stands_under_them(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {"__name__": "example"}
    printed = 0
    for (kind, code), (shown_kind, shown) in itertools.pairwise([*_blocks(page), ("", "")]):
        if kind != "python":
            continue
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(compile(code, page, "exec"), names)
        if out.getvalue():
            assert shown_kind == "text", f"{page} shows nothing under:\n{code}"
            assert [line.rstrip() for line in out.getvalue().splitlines()] == shown.splitlines(), code
            printed += 1
    assert printed or page == "coming_from.md"


def _commands() -> list[tuple[str, list[str]]]:
    shown = [text.splitlines() for kind, text in _blocks("troubleshooting.md") if kind == "text"]
    return [(lines[0].removeprefix("$ "), lines[1:]) for lines in shown if lines[0].startswith("$ nao-kin ")]


@pytest.mark.parametrize(("command", "said"), _commands(), ids=lambda value: str(value)[:60])
def test_commands_say_what_stands_under_them(command: str, said: list[str], tmp_path: Path) -> None:
    _write_faulty_files(tmp_path)
    with socket.socket() as other:
        with contextlib.suppress(OSError):  # then another program has the port
            other.bind(("127.0.0.1", 7000))
            other.listen()
        done = subprocess.run(
            [sys.executable, "-c", WITHOUT_EXTRA, *shlex.split(command)[1:]],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            env={**os.environ, "PYTHONPATH": str(DOCS.parent), "PATH": str(tmp_path), "NAO_KIN_BROWSER": ""},
            timeout=60,
        )
    assert (done.returncode == 0) == (tmp_path / "nao.html").exists()  # which is shown without the missing meshes
    assert done.stderr.splitlines() == said


def _write_faulty_files(folder: Path) -> None:
    nao = nk.load_nao("v6")
    shutil.copy(nao.urdf_path, folder / "alone.urdf")
    q = nao.posture("Stand").round(2)
    body = dict(zip(nao.body_order, nao.to_body(q).tolist(), strict=True)) | {"RHipYawPitch": 0.1}
    joints = dict(zip(nao.joint_names, q.tolist(), strict=True))
    _write_table(folder / "hips.csv", body)
    _write_table(folder / "nan.csv", joints | {"LHipRoll": math.nan})
    _write_table(folder / "short.csv", joints)
    with (folder / "short.csv").open("a", encoding="utf-8") as table:
        table.write(",".join(["0.0"] * (nao.nq - 1)) + "\n")
    wave = nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [0.5]])
    nk.motion.write_motion(wave, folder / "wave.json")


def _write_table(path: Path, row: dict[str, float]) -> None:
    path.write_text(f"{','.join(row)}\n{','.join(map(str, row.values()))}\n", encoding="utf-8")


def _twice(x: float) -> float:
    return 2.0 * x


def test_the_page_quotes_what_is_said_where_kernels_cannot_be_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    numba = pytest.importorskip("numba")
    taken = tmp_path / "a file"
    taken.touch()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(taken))
    monkeypatch.setattr(kernel_cache, "_said", set())
    kernel = kernel_cache.KeptKernel(_twice, "a test", "test", tmp_path, lambda: numba.float64(numba.float64))
    with pytest.warns(nk.errors.NotCachedWarning) as caught:
        kernel.ready()
    page = (DOCS / "troubleshooting.md").read_text(encoding="utf-8")
    for part in re.split(r"\(.*?\)", str(caught[0].message), maxsplit=1):
        assert part in page


def test_the_cheat_sheet_to_print_is_that_of_the_page() -> None:
    script = DOCS.parent / "scripts" / "make_cheat_sheet.py"
    done = subprocess.run([sys.executable, str(script), "--check"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    pdf = (DOCS / "_static" / "cheat_sheet.pdf").read_bytes()
    assert len(pdf) < 150_000
    assert len(re.findall(rb"/Type\s*/Page\b", pdf)) == 1
