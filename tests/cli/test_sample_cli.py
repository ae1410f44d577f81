"""`nao-kin sample`: small files to try the other commands with."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from command_line import Capture, refused, said
from doc_commands import Ran, check, run_line, why_skipped
from doc_pages import DOCS
from loops import full

import nao_kin as nk
from nao_kin.cli.app import run
from nao_kin.cli.options import COMMANDS
from nao_kin.cli.sample import SAMPLES


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """All samples."""
    folder = tmp_path_factory.mktemp("samples")
    assert run(["sample", "all", "-o", str(folder)]) == 0
    return folder


@pytest.fixture(autouse=True)
def inside(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def contents(folder: Path) -> dict[str, bytes]:
    """Return all files below a folder."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_the_samples_are_small_and_the_same_each_time(folder: Path, capsys: Capture) -> None:
    found = contents(folder)
    assert sum(map(len, found.values())) < 300_000
    printed = said("sample", capsys, "--output", "again/and")
    assert printed.splitlines() == [f"again/and/{name}" for name in SAMPLES]
    assert contents(Path("again/and")) == found


def test_without_names_they_are_listed_as_on_the_page(capsys: Capture) -> None:
    lines = [line.rstrip() for line in said("sample", capsys).splitlines()]
    assert "\n".join(lines[:-1]) in (DOCS / "command_line.md").read_text(encoding="utf-8")
    listed = json.loads(said("sample", capsys, "--json"))["samples"]
    assert [row["name"] for row in listed] == list(SAMPLES)
    assert not contents(Path())


def test_files_are_replaced_with_force_alone_and_otherwise_none_is_written(capsys: Capture) -> None:
    for kept, asked in (("wave.xar", "wave.xar"), ("photos/top_1.000.png", "photos")):
        Path(kept).parent.mkdir(exist_ok=True)
        Path(kept).write_bytes(b"mine")
        assert "already exists; overwrite=True (--force) replaces it" in refused("sample", capsys, "head.csv", asked)
        assert Path(kept).read_bytes() == b"mine"
        assert not Path("head.csv").exists()
    assert json.loads(said("sample", capsys, "wave.xar", "photos", "--force", "--json")) == {
        "files": ["wave.xar", "photos"]
    }
    assert Path("wave.xar").read_bytes() != b"mine"
    assert "unknown sample 'walk' (nearest: walk.csv" in refused("sample", capsys, "walk")
    assert "--output is the folder for the samples, and - is not one" in refused(
        "sample", capsys, "walk.csv", "-o", "-"
    )
    assert "cannot write wave.xar: File exists" in refused("sample", capsys, "head.csv", "-o", "wave.xar")


def test_lines_that_do_not_need_a_missing_extra_are_checked_all_the_same() -> None:
    lacks = Ran("nao-kin fk walk.csv -o feet.parquet", 2, "nao-kin: pip install 'nao-kin[stream]'")
    needs_it = Ran("nao-kin view feet.parquet", 2, "feet.parquet: cannot be read")
    Path("walk.csv").touch()  # it has been there for all lines
    with pytest.raises(pytest.skip.Exception, match=r"feet\.parquet: nao-kin: pip install .*; nao-kin view"):
        check([lacks, needs_it, Ran("nao-kin fk walk.csv", 0, "")])
    with pytest.raises(AssertionError):
        check([lacks, Ran("nao-kin fk walk.csv", 2, "wrong")])
    check([Ran("nao-kin info", 0, "")])


EXAMPLES = [line for one in COMMANDS.values() for line in one.example.removeprefix("Example: ").split("; ")]


@pytest.mark.parametrize(
    "line",
    [
        # Processes of their own take a second each, and other tests start them.
        full(line)[0] if re.search(r" \| | doctor", line) else line
        for line in EXAMPLES
        if why_skipped(line) is None and " warmup" not in line
    ],
)
def test_the_examples_in_the_help_of_commands_are_not_refused(line: str, folder: Path, tmp_path: Path) -> None:
    if " sample " not in line:
        shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    ran = run_line(line)
    check([ran._replace(code=0) if ran.code == 1 else ran])  # links overlap, or a target is out of reach


def test_the_motions_are_sound(folder: Path, nao: nk.NaoModel) -> None:
    for name in ("walk.csv", "kick.motion", "wave.xar"):
        motion = nk.motion.read_motion(folder / name, robot=nao)
        assert nk.motion.check(nao, motion, balance=True, collisions=True, rate=50).ok, name


def offsets(found: nk.calibration.Calibration) -> list[float]:
    """Return what was found, in degrees."""
    return [*np.degrees([*found.joints.values(), *found.frames["CameraTop"][3:]])]


def test_the_observations_and_the_photos_show_how_far_the_head_is_off(folder: Path, nao: nk.NaoModel) -> None:
    pytest.importorskip("scipy")
    shown = re.search(r"head is off by (1)° and −(0.7)°, and whose camera by (0.7)°, (1.7)° and −(0.85)°", page())
    assert shown
    true = np.array([float(number) for number in shown.groups()]) * [1, -1, 1, 1, -1]
    # The simulated camera is where it should be: otherwise HeadPitch is not determined beside its pitch.
    prior = {"CameraTop": [1e-5, 1e-5, 1e-5, *np.radians([1.0, 5.0, 2.0])]}
    arguments = nk.calibration.read_observations(nao, folder / "observations.json")
    found = nk.calibration.calibrate(nao, **arguments, prior=prior)
    assert not found.held
    np.testing.assert_allclose(offsets(found), true, atol=0.15)
    pytest.importorskip("cv2", reason="OpenCV is not installed")
    place, lens = re.search(r"--place=(\S+)", page()), re.search(r"--lens=(\S+)", page())
    assert place
    assert lens
    place_numbers = [float(number) for number in place[1].split(",")]
    seen = nk.calibration.from_photos(
        nao,
        folder / "photos",
        folder / "head.csv",
        board=(9, 6),
        square=0.03,
        missing="StandInit",
        place=[*place_numbers[:3], *np.radians(place_numbers[3:])],  # as with --deg
        lens=[float(number) for number in lens[1].split(",")],
    )
    assert np.isfinite(seen.pixels).all()
    found = nk.calibration.calibrate(
        nao, [seen], joints=["HeadYaw", "HeadPitch"], frames={"CameraTop": ("roll", "pitch", "yaw")}, prior=prior
    )
    np.testing.assert_allclose(offsets(found), true, atol=0.05)


def page() -> str:
    """Return the text of the page of calibration in one line."""
    return " ".join((DOCS / "calibration.md").read_text(encoding="utf-8").split())
