"""`nao-kin imitate`: files in, motions out, a page, a report, and one line for each error."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import nao_kin as nk
from nao_kin.cli.app import run

WAVE = str(nk.imitation.SAMPLES["wave"])
SHORT = ("--end", "0.5", "--legs", "ignore")


def test_a_motion_is_written_with_a_report(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "wave.xar"
    assert run(["imitate", WAVE, "-o", str(out), "--end", "0.5"]) == 0
    output = capsys.readouterr()
    assert output.out == f"{out}\n"
    assert "right forearm: " in output.err
    assert "can perform the motion" in output.err
    motion = nk.motion.read_motion(out)
    assert {"LHipYawPitch", "RShoulderPitch"} <= set(motion.joint_names)


def test_json_says_how_far_the_robot_is_from_the_person(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "wave.csv"
    assert run(["imitate", WAVE, str(out), *SHORT, "--mirror", "--json", "--weight", "place=1"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["output"] == str(out)
    assert report["frames"] == 11
    assert report["check"]["ok"] is True
    assert report["directions"]["left_forearm"].keys() == {"mean", "most", "outside_limits", "made_room"}
    assert report["least_lean"] is None


def test_a_page_shows_the_person_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = tmp_path / "wave.html"
    assert run(["imitate", WAVE, str(tmp_path / "wave.csv"), *SHORT, "--html", str(page)]) == 0
    assert str(page) in capsys.readouterr().out
    assert page.stat().st_size > 1_000_000


@pytest.mark.full
def test_the_same_call_gives_the_same_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    written = []
    for k in range(2):
        files = [tmp_path / f"wave {k}.json", tmp_path / f"wave {k}.html"]
        assert run(["imitate", WAVE, str(files[0]), "--end", "0.2", "--html", str(files[1])]) == 0
        written.append([file.read_bytes() for file in files])
    assert written[0] == written[1]
    capsys.readouterr()


def test_outputs_are_checked_before_the_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(nk.imitation, "read_skeleton", None)
    for arguments in (["out.mp4"], ["out.csv", "--to", "xap"], ["out.csv", "--html", "page.mp4"], ["out"]):
        assert run(["imitate", WAVE, *(str(tmp_path / word) if "." in word else word for word in arguments)]) == 2
        assert capsys.readouterr().err.count("\n") == 1


def test_a_motion_that_breaks_a_limit_is_exit_code_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(nk.imitation.Imitation, "ok", property(lambda self: False))
    assert run(["imitate", WAVE, str(tmp_path / "wave.csv"), *SHORT]) == 1
    capsys.readouterr()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nowhere.bvh", "out.csv"], "nowhere.bvh: "),
        ([WAVE, "out.csv", "--names", "left_wrist"], "--names 'left_wrist': expected POINT=JOINT"),
        ([WAVE, "out.csv", "--names", "left_wirst=LeftHand"], "unknown point 'left_wirst' (nearest: left_wrist"),
        ([WAVE, "out.csv", "--start", "9"], "no frame from 9 to 3.2 s; the skeleton has 0 to 3.2 s"),
        ([WAVE, "out.csv", "--legs", "walk"], "legs"),
        ([WAVE], "give one file or folder to write"),
    ],
)
def test_errors_are_one_line(
    arguments: list[str],
    message: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["imitate", *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert not list(tmp_path.iterdir())
