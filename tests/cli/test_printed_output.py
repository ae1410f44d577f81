"""The output of code blocks and commands is the output that the documentation shows."""

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
from command_line import Capture
from doc_commands import FAILING, check, lines_of, run_line, why_skipped
from doc_pages import DOCS, PRINTED, ROOT, blocks

import nao_kin as nk
from nao_kin._kernels import cache as kernel_cache
from nao_kin.cli.app import run

pytestmark = pytest.mark.full


@pytest.mark.parametrize("page", PRINTED, ids=lambda page: page.name)
def test_blocks_print_what_stands_under_them(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {"__name__": "example"}
    printed = 0
    for (kind, code), (shown_kind, shown) in itertools.pairwise([*blocks(page), ("", "")]):
        if page.name != FAILING:
            check(run_line(line) for line in lines_of(kind, code) if why_skipped(line) is None)
        if kind != "python":
            continue
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(compile(code, page.name, "exec"), names)
        if out.getvalue():
            assert shown_kind == "text", f"{page.name} shows nothing under:\n{code}"
            assert [line.rstrip() for line in out.getvalue().splitlines()] == shown.splitlines(), code
            printed += 1
    assert printed or page.name == "coming_from.md"


def _commands() -> list[tuple[str, list[str]]]:
    shown = [text.splitlines() for kind, text in blocks(DOCS / "installation.md") if kind == "text"]
    return [(lines[0].removeprefix("$ "), lines[1:]) for lines in shown if lines[0].startswith("$ nao-kin ")]


@pytest.mark.parametrize(("command", "said"), _commands(), ids=lambda value: str(value)[:60])
def test_commands_say_what_stands_under_them(
    command: str, said: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: Capture
) -> None:
    _write_faulty_files(tmp_path)
    words = shlex.split(command)[1:]
    if "plot" in words:  # in a process where matplotlib is hidden
        environment = {"PYTHONPATH": os.pathsep.join((str(ROOT / "tests" / "hidden"), str(ROOT)))}
        command_line = [sys.executable, "-m", "nao_kin", *words]
        done = subprocess.run(
            command_line,
            cwd=tmp_path,
            capture_output=True,
            text=True,
            env=os.environ | environment | {"NAO_KIN_HIDDEN": "matplotlib"},
            timeout=60,
        )
        assert (done.returncode, done.stderr.splitlines()) == (2, said)
        return
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("NAO_KIN_BROWSER", "")
    monkeypatch.setattr("nao_kin._core.process._MAC_BROWSERS", ())
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        taken = str(other.getsockname()[1])  # for 7000 may be anybody's
        code = run([word.replace("7000", taken) for word in words])
    assert (code == 0) == (tmp_path / "nao.html").exists()  # which is shown without the missing meshes
    assert capfd.readouterr().err.replace(taken, "7000").splitlines() == said


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
    monkeypatch.setattr(kernel_cache, "_printed", set())
    monkeypatch.setattr(kernel_cache, "KERNELS", {})
    kernel = kernel_cache.CachedKernel(_twice, "a test", "test", lambda: numba.float64(numba.float64))
    with pytest.warns(nk.errors.NotCachedWarning) as caught:
        kernel.ready()
    page = (DOCS / "installation.md").read_text(encoding="utf-8")
    for part in re.split(r"\(.*?\)", str(caught[0].message), maxsplit=1):
        assert part in page


def test_the_cheat_sheet_to_print_is_that_of_the_page() -> None:
    script = ROOT / "scripts" / "make_cheat_sheet.py"
    done = subprocess.run([sys.executable, str(script), "--check"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    pdf = (DOCS / "_static" / "cheat_sheet.pdf").read_bytes()
    assert len(pdf) < 150_000
    assert len(re.findall(rb"/Type\s*/Page\b", pdf)) == 1
