"""`nao-kin reach`, as people use it: files that exist already, signals, pipes, wrong words."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import command_line
import numpy as np
import pytest
import trimesh
from command_line import Capture
from viewer_pages import messages_of

import nao_kin as nk

ENVIRONMENT = {**os.environ, "PYTHONPATH": str(Path(nk.__file__).parent.parent)}
FEW = ("--samples", "3000", "--voxel", "0.03")


said = partial(command_line.said, "reach")
refused = partial(command_line.refused, "reach")


def test_it_says_where_the_hand_can_be(capsys: Capture, nao: nk.NaoModel) -> None:
    out = said(capsys, "LArm", *FEW)
    found = nk.reach.workspace(nao, "LArm", 3000, voxel=0.03)
    assert "LArm in torso of nao_v6, 3000 samples, seed 0" in out
    assert f"{len(found.count)} voxels of 30 mm" in out
    assert f"best manipulability {found.best.max():.4g}" in out


def test_json_holds_the_same_and_the_files(capsys: Capture, nao: nk.NaoModel, tmp_path: Path) -> None:
    path = str(tmp_path / "a.npz")
    document = json.loads(said(capsys, "RLeg", *FEW, "--seed", "7", "--reference", "Head", "-o", path, "--json"))
    found = nk.reach.workspace(nao, "RLeg", 3000, voxel=0.03, seed=7, reference="Head")
    assert nk.reach.load(path) == found
    assert document["files"] == [path]
    assert document["samples"] == 3000
    assert document["reference"] == "Head"
    assert document["joints"] == list(found.settings.joints)
    assert document["voxels"] == len(found.count)
    assert document["volume"] == pytest.approx(found.volume)
    assert document["best"]["manipulability"] == pytest.approx(found.best.max())
    assert found.best_at(document["best"]["position"]) == found.best.max()
    assert (found.centres > document["lower"]).all()
    assert (found.centres < document["upper"]).all()


def test_a_picture_shows_the_map(capsys: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[tuple[str, bool]] = []

    def draw(viewer: nk.Viewer, path: str, *, overwrite: bool) -> None:
        page = viewer.save_html(tmp_path / "page.html").read_text("utf-8")
        drawn.append((path, any(message.get("kind") == "reach" for message in messages_of(page))))

    monkeypatch.setattr(nk.Viewer, "save_png", draw)
    path = str(tmp_path / "r.png")
    assert path in said(capsys, "LArm", *FEW, "-o", path, "--by", "mean")
    assert drawn == [(path, True)]


def test_a_later_run_goes_on_from_the_file(capsys: Capture, nao: nk.NaoModel, tmp_path: Path) -> None:
    path = str(tmp_path / "a.npz")
    part = nk.reach.workspace(nao, "LArm", (1000, 2000), voxel=0.03)
    part.save(path)
    said(capsys, "LArm", *FEW, "-o", path)
    assert nk.reach.load(path) == nk.reach.workspace(nao, "LArm", 3000, voxel=0.03)
    before = Path(path).read_bytes()
    said(capsys, "LArm", *FEW, "-o", path)
    assert Path(path).read_bytes() == before


def test_nobodys_samples_are_thrown_away(capsys: Capture, tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    said(capsys, "LArm", *FEW, "-o", str(path))
    before = path.read_bytes()
    assert "is of another voxel: 0.03 instead of 0.01" in refused(capsys, "LArm", "-o", str(path))
    assert path.read_bytes() == before


def test_vtk_ply_and_page_are_written(capsys: Capture, nao: nk.NaoModel, tmp_path: Path) -> None:
    found = nk.reach.workspace(nao, "LArm", 3000, voxel=0.03)
    coloured = {"a.vtk": (), "a.PLY": ("--by", "coverage")}  # a .vtk file has all quantities
    for name, by in coloured.items():
        out = said(capsys, "LArm", *FEW, "-o", str(tmp_path / name), *by)
        assert out.endswith(f"{tmp_path / name}\n")
    for name, by in coloured.items():
        before = (tmp_path / name).read_bytes()
        message = refused(capsys, "LArm", "--samples", "5", "-o", str(tmp_path / name))
        assert message.endswith(f"{name} already exists; overwrite=True (--force) replaces it\n")
        assert (tmp_path / name).read_bytes() == before
        said(capsys, "LArm", *FEW, "-o", str(tmp_path / name), *by, "--force")
        assert (tmp_path / name).read_bytes() == before
    found.save_vtk(tmp_path / "b.vtk")
    assert (tmp_path / "a.vtk").read_bytes() == (tmp_path / "b.vtk").read_bytes()
    assert "overwrite=True (--force) replaces it" in refused(capsys, "LArm", *FEW, "-o", str(tmp_path / "a.vtk"))
    colours = trimesh.load(found.save_ply(tmp_path / "b.ply", by="coverage")).colors
    with (tmp_path / "a.PLY").open("rb") as file:
        assert np.array_equal(trimesh.load(file, file_type="ply").colors, colours)
    said(capsys, "LArm", *FEW, "--html", str(tmp_path / "a.html"))
    assert "replaces it" in refused(capsys, "LArm", *FEW, "--html", str(tmp_path / "a.html"))
    (message,) = (m for m in messages_of((tmp_path / "a.html").read_text("utf-8")) if m.get("kind") == "reach")
    assert message["frame"] == found.settings.reference
    assert len(message["values"].data) == 2 * len(found.count)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("LArm", "--samples", "1.5"), "--samples '1.5': expected a whole number"),
        (("LArm", "--seed", "-1"), "seed must be at least 0"),
        (("LArm", "--by", "bset", "--html", "a.html"), "--by 'bset': expected one of best"),
        (("LArm", "-o", "map.csv"), "cannot write map.csv: end the name in .npz, .vtk, .ply"),
        (("LArm", "-o", "no/map.npz"), "cannot write no/map.npz"),
        (("LArm", "-o", "/dev/stdout", "--json"), "both write to standard output"),
    ],
)
def test_wrong_words_are_one_line(
    capsys: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], message: str
) -> None:
    monkeypatch.chdir(tmp_path)
    assert message in refused(capsys, *arguments)
    assert list(tmp_path.iterdir()) == []


def program(folder: Path, *arguments: str) -> subprocess.Popen:
    return subprocess.Popen(
        [sys.executable, "-m", "nao_kin", "reach", *arguments],
        cwd=folder,
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )


def interrupted(folder: Path, number: signal.Signals, *arguments: str) -> tuple[int, str, str]:
    """Let the program count for a while, then send the signal; return its exit code, output and messages."""
    process = program(folder, *arguments)
    try:
        tasks = Path(f"/proc/{process.pid}/task")
        end = time.monotonic() + 60
        while time.monotonic() < end and not counting(tasks):
            time.sleep(0.05)
        time.sleep(0.1)
        process.send_signal(number)
        out, err = process.communicate(timeout=30)
        return process.returncode, out, err
    finally:
        process.kill()


def counting(tasks: Path) -> bool:
    """Whether a worker thread has used half a second of a processor, which one sample does not take."""
    for task in tasks.glob("*/stat"):
        if task.parent.name != tasks.parent.name:
            fields = task.read_text().rpartition(")")[2].split()
            if int(fields[11]) + int(fields[12]) >= 0.5 * os.sysconf("SC_CLK_TCK"):
                return True
    return False


@pytest.mark.full
@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="needs /proc")
def test_ctrl_c_keeps_what_is_done_and_a_later_run_goes_on(capsys: Capture, nao: nk.NaoModel, tmp_path: Path) -> None:
    code, out, err = interrupted(tmp_path, signal.SIGINT, "LArm", "--samples", "4e9", "--threads", "1", "-o", "a.npz")
    assert (code, out) == (130, "")
    part = nk.reach.load(tmp_path / "a.npz")
    assert 0 < part.samples < 4_000_000_000
    assert err == f"nao-kin: ended after {part.samples} of 4000000000 samples; kept in a.npz\n"
    assert [path.name for path in tmp_path.iterdir()] == ["a.npz"]
    some = part.ranges[-1][1] + 1000
    out = said(capsys, "LArm", "--samples", str(some), "-o", str(tmp_path / "a.npz"), "--json")
    assert json.loads(out)["samples"] == some
    assert nk.reach.load(tmp_path / "a.npz") == nk.reach.workspace(nao, "LArm", some)


@pytest.mark.full
@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="needs /proc")
def test_sigterm_without_a_file_says_that_nothing_is_kept(tmp_path: Path) -> None:
    code, out, err = interrupted(tmp_path, signal.SIGTERM, "LArm", "--samples", "4e9")
    assert (code, out) == (143, "")
    assert err.startswith("nao-kin: ended after ")
    assert err.endswith(" of 4000000000 samples; without -o FILE nothing is kept\n")
