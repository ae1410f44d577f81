"""Motions on the command line: `nao-kin motion`, and wherever a trajectory is taken."""

from __future__ import annotations

import csv
import io
import json
import os
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import Capture, refused_line as _refused

import nao_kin as nk
from nao_kin.cli.app import run
from nao_kin.motion import FORMATS, check, read_motion, write_motion
from nao_kin.motion.files import is_motion_file

COMMANDS = ("convert", "check", "info", "plot")


def _nod() -> nk.Motion:
    return nk.Motion([[0.0, 0.5, 1.0], [0.2, 0.8]], ["HeadYaw", "LHand"], [[0.0, 0.4, 0.0], [0.0, 1.0]], "smooth")


def _wild() -> nk.Motion:
    names = ["HeadYaw", "HeadPitch", "LHipYawPitch", "RHipYawPitch", "LHand"]
    return nk.Motion([0.0, 0.1, 1.0], names, [[0, 0, 0, 0, 0], [1.6, 0.5, -0.2, -0.3, 1.5], [0, 0, 0, 0, 0]], "bezier")


@pytest.fixture
def nod(tmp_path: Path) -> str:
    write_motion(_nod(), tmp_path / "nod.json")
    return str(tmp_path / "nod.json")


@pytest.fixture
def wild(tmp_path: Path) -> str:
    write_motion(_wild(), tmp_path / "wild.json")
    return str(tmp_path / "wild.json")


@pytest.fixture
def plain(tmp_path: Path, nao: nk.NaoModel) -> str:
    """Configurations without times, as they have always been read."""
    with (tmp_path / "plain.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(nao.joint_names)
        writer.writerows(nao.random(0, 4).tolist())
    return str(tmp_path / "plain.csv")


def _json(capsys: Capture, *arguments: str, code: int = 0) -> Any:
    assert run(arguments) == code
    return json.loads(capsys.readouterr().out)


# --- nao-kin motion ---------------------------------------------------------------------------------------------------


def test_motion_alone_says_what_there_is(capsys: Capture) -> None:
    assert run(["motion"]) == 0
    out = capsys.readouterr().out
    assert all(command in out for command in COMMANDS)
    assert all(f" {name}" in " ".join(out.split()) for name in FORMATS)


def test_convert_writes_to_standard_output_for_a_hyphen(
    capfd: Capture, monkeypatch: pytest.MonkeyPatch, nod: str, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["motion", "convert", nod, "-", "--to", "naoqi"]) == 0
    out, _ = capfd.readouterr()
    assert json.loads(out)[0] == ["HeadYaw", "LHand"]
    assert [path.name for path in tmp_path.iterdir()] == ["nod.json"]
    assert run(["motion", "convert", nod, "-"]) == 2
    assert "name one with format= or --to" in capfd.readouterr().err


def test_columns_that_name_no_joint_are_left_out_when_asked(capsys: Capture, tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    log.write_text("time,HeadYaw,Battery\n0,0.1,12\n1,0.2,12\n", encoding="utf-8")
    assert "--ignore-other of nao-kin motion, fk and view, leaves it out" in _refused(
        capsys, "motion", "info", str(log)
    )
    for command, *more in (["info"], ["check"], ["convert", str(tmp_path / "nod.json")]):
        assert run(["motion", command, str(log), *more, "--ignore-other", "--json"]) == 0
        out, err = capsys.readouterr()
        assert json.loads(out)["joints"] == ["HeadYaw"]
        assert "left out names that are not joints: Battery" in err


def test_fk_and_view_leave_out_columns_of_a_motion_that_name_no_joint(capsys: Capture, tmp_path: Path) -> None:
    motion, clean = tmp_path / "log.csv", tmp_path / "clean.csv"
    motion.write_text("time,HeadYaw,state\n0,0.1,walk\n1,0.2,stand\n", encoding="utf-8")
    clean.write_text("time,HeadYaw\n0,0.1\n1,0.2\n", encoding="utf-8")
    for options in (["--rate", "4"], ["--posture", "Stand"], ["-o", "-"]):
        assert run(["fk", str(clean), "--frame", "Head", *options]) == 0
        expected = capsys.readouterr().out
        assert "--ignore-other" in _refused(capsys, "fk", str(motion), "--frame", "Head", *options)
        assert run(["fk", str(motion), "--frame", "Head", *options, "--ignore-other"]) == 0
        out, err = capsys.readouterr()
        assert out == expected
        assert "left out names that are not joints: state" in err
    page = str(tmp_path / "page.html")
    assert "--ignore-other" in _refused(capsys, "view", str(motion), "--html", page)
    assert run(["view", str(motion), "--html", page, "--ignore-other"]) == 0
    assert "left out names that are not joints: state" in capsys.readouterr().err
    assert "--columns is for whole" in _refused(capsys, "fk", str(motion), "--columns", "state=", "--frame", "Head")


def test_info_has_joints_keys_times_and_ranges(capsys: Capture, nod: str) -> None:
    document = _json(capsys, "motion", "info", nod, "--json")
    assert document["joints"] == ["HeadYaw", "LHand"]
    assert (document["start"], document["end"], document["keys"], document["interpolation"]) == (0.0, 1.0, 5, "smooth")
    yaw, hand = document["rows"]
    assert yaw == {"joint": "HeadYaw", "keys": 3, "start": 0.0, "end": 1.0, "least": 0.0, "most": 0.4, "unit": "rad"}
    assert hand["unit"] == "1"
    assert run(["motion", "info", nod, "--deg"]) == 0
    out = capsys.readouterr().out
    assert "22.918" in out
    assert "2 joints, smooth, 1 s" in out


def test_check_says_what_is_wrong_and_exits_with_1(capsys: Capture, wild: str, nao: nk.NaoModel) -> None:
    document = _json(capsys, "motion", "check", wild, "--json", code=1)
    assert document == json.loads(json.dumps(check(nao, _wild()).as_dict()))
    assert {row["kind"] for row in document["violations"]} == {"limit", "coupled limit", "speed", "motor"}
    assert run(["motion", "check", wild, "--deg"]) == 1
    out = capsys.readouterr().out
    assert "LHand" in out
    assert "at HeadYaw =" in out
    assert "as LHipYawPitch =" in out
    assert "1000 times per second" in out


def test_check_lists_every_stretch_if_asked_to(capsys: Capture, tmp_path: Path) -> None:
    path = str(tmp_path / "twice.csv")
    write_motion(nk.Motion([0.0, 1.0, 2.0, 3.0, 4.0], ["LHand"], [[0.0], [1.5], [0.0], [1.2], [0.0]]), path)
    assert run(["motion", "check", path]) == 1
    out = capsys.readouterr().out
    assert "1.5" in out
    assert "and 1 more intervals of these joints (--all lists them)" in out
    assert run(["motion", "check", path, "--all"]) == 1
    out = capsys.readouterr().out
    assert "1.2" in out
    assert "more intervals" not in out


def test_check_is_content_with_a_good_motion(capsys: Capture, nod: str) -> None:
    assert run(["motion", "check", nod]) == 0
    assert capsys.readouterr().out == "nao_v6 can perform the motion: 2 joints, 0 to 1 s\n"
    assert _json(capsys, "motion", "check", nod, "--json")["ok"]


def test_check_fills_in_what_coupled_limits_need(capsys: Capture, tmp_path: Path) -> None:
    write_motion(nk.Motion([0.0], ["LAnkleRoll"], [[0.7]]), tmp_path / "roll.csv")
    assert run(["motion", "check", str(tmp_path / "roll.csv")]) == 0
    assert run(["motion", "check", str(tmp_path / "roll.csv"), "--posture", "Crouch"]) == 1


def test_convert_mends_and_says_by_how_much(capsys: Capture, wild: str, tmp_path: Path, nao: nk.NaoModel) -> None:
    out = str(tmp_path / "tame.npz")
    options = ("--hips", "left", "--limits", "clamp", "--slow-down", "--posture", "Crouch")
    document = _json(capsys, "motion", "convert", wild, out, *options, "--json")
    kinds = {change["kind"] for change in document["changes"]}
    assert kinds == {"one motor", "clamped", "resampled", "slower"}
    tame = read_motion(out)
    report = check(nao, tame)
    assert report.ok, report.describe()
    assert {*tame.joint_names} >= {*nao.joint_names}
    assert tame.duration > 1.0


def test_convert_prints_the_file_and_notes_what_changed(capsys: Capture, wild: str, tmp_path: Path) -> None:
    out = str(tmp_path / "tame.json")
    assert run(["motion", "convert", wild, out, "--limits", "clamp", "--deg"]) == 0
    printed, noted = capsys.readouterr()
    assert printed == f"{out}\n"
    assert "LHand: moved into its limits by up to 0.5 (0.1 s)" in noted


def test_convert_edits_in_the_order_it_says(capsys: Capture, nod: str, tmp_path: Path) -> None:
    out = str(tmp_path / "edited.json")
    options = ("--mirror", "--reverse", "--stretch", "2", "--loop", "2", "--gap", "1", "--lead", "0.5")
    assert run(["motion", "convert", nod, out, *options]) == 0
    capsys.readouterr()
    found = read_motion(out)
    assert found.joint_names == ("HeadYaw", "RHand")
    assert found.duration == pytest.approx(5.0)
    t = np.linspace(0.0, 1.0, 50)
    expected = _nod().sample(1.0 - t) * (-1.0, 1.0)
    for start in (0.5, 3.5):
        assert np.allclose(found.sample(start + 2.0 * t), expected, rtol=0, atol=1e-9)


def test_convert_writes_samples_where_a_rate_is_given(capsys: Capture, nod: str, tmp_path: Path) -> None:
    out = str(tmp_path / "nod.csv")
    assert run(["motion", "convert", nod, out, "--rate", "10"]) == 0
    found = read_motion(out)
    assert np.allclose(found.times[0], np.linspace(0.0, 1.0, 11))
    assert np.allclose(found.sample(found.times[0]), _nod().sample(found.times[0]), rtol=0, atol=1e-6)


def test_nothing_is_overwritten_without_force(capsys: Capture, nod: str, tmp_path: Path) -> None:
    out = tmp_path / "there.json"
    out.write_text("mine", encoding="utf-8")
    assert "overwrite=True (--force) replaces it" in _refused(capsys, "motion", "convert", nod, str(out))
    picture = tmp_path / "there.png"
    picture.write_text("mine", encoding="utf-8")
    assert "overwrite=True (--force) replaces it" in _refused(capsys, "motion", "plot", nod, str(picture))
    assert out.read_text(encoding="utf-8") == picture.read_text(encoding="utf-8") == "mine"
    assert run(["motion", "convert", nod, str(out), "--force"]) == 0
    assert read_motion(out) == _nod()


@pytest.mark.full
def test_plot_draws_a_png_and_an_svg(capsys: Capture, wild: str, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    assert run(["motion", "plot", wild, str(tmp_path / "wild.png")]) == 0
    assert (tmp_path / "wild.png").read_bytes().startswith(b"\x89PNG")
    assert run(["motion", "plot", wild, str(tmp_path / "wild.svg"), "--speed", "--joint", "LHand"]) == 0
    assert "<svg" in (tmp_path / "wild.svg").read_text(encoding="utf-8")
    capsys.readouterr()
    assert "nearest: LHand" in _refused(capsys, "motion", "plot", wild, str(tmp_path / "x.png"), "--joint", "LHnad")
    assert "end the name in .png or .svg" in _refused(capsys, "motion", "plot", wild, str(tmp_path / "x.pdf"))


def test_a_figure_has_the_curves_limits_and_what_is_outside(nao: nk.NaoModel) -> None:
    pytest.importorskip("matplotlib")
    figure = nk.motion.plot(nao, _wild(), joints=["LHand"])
    (axes,) = figure.axes
    assert axes.get_title() == "LHand"
    t, values = axes.lines[0].get_data()
    assert np.allclose(values, _wild().sample(t)[:, 4])
    assert [line.get_ydata()[0] for line in axes.lines[1:3]] == [0.0, 1.0]
    (stretch,) = (row for row in check(nao, _wild()).violations if row.joint == "LHand" and row.kind == "limit")
    (patch,) = axes.patches
    assert patch.get_x() == pytest.approx(stretch.start)


def test_without_matplotlib_the_extra_is_named(
    capsys: Capture, nod: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert "pip install 'nao-kin[plot]'" in _refused(capsys, "motion", "plot", nod, str(tmp_path / "nod.png"))
    assert not (tmp_path / "nod.png").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("check", "nowhere.json"), "cannot be read"),
        (("info", "{nod}", "--from", "gif"), "unknown motion format 'gif'"),
        (("info", "{plain}"), "time"),
        (("convert", "{nod}", "{folder}/no/x.csv"), "cannot write"),
        (("convert", "{nod}", "{folder}/x.csv", "--gap", "1"), "--gap needs --loop"),
        (("convert", "{nod}", "{folder}/x.csv", "--loop", "0"), "--loop must be at least 1, got 0"),
        (("convert", "{nod}", "{folder}/x.csv", "--loop", "2"), "would jump"),
        (("convert", "{nod}", "{folder}/x.csv", "--stretch", "-1"), "--stretch must be a positive number, got -1"),
        (("convert", "{nod}", "/dev/stdout", "--to", "csv", "--json"), "both write to standard output"),
        (
            ("info", "{nod}", "--timeline", "3"),
            "--timeline chooses one of several, in files of xar, xap, python, bhuman",
        ),
    ],
)
def test_bad_input_is_one_line(
    capsys: Capture, nod: str, plain: str, tmp_path: Path, arguments: tuple[str, ...], words: str
) -> None:
    # LHand opens and stays open: without a gap it would jump.
    filled = [argument.format(nod=nod, plain=plain, folder=tmp_path) for argument in arguments]
    assert words in _refused(capsys, "motion", *filled)
    assert not list(tmp_path.glob("x.*"))


# --- where trajectories are taken -------------------------------------------------------------------------------------


def test_fk_takes_a_motion_at_its_key_times_or_a_rate(capsys: Capture, nod: str, nao: nk.NaoModel) -> None:
    for extra, chosen in (((), {}), (("--rate", "7", "--posture", "Crouch"), {"rate": 7.0, "missing": "Crouch"})):
        document = _json(capsys, "fk", nod, "--frame", "LArm", "--as", "matrix", "--json", *extra)
        q = _nod().configurations(nao, **chosen).q  # type: ignore[arg-type]
        found = [row["LArm"] for row in document["configurations"]]
        assert np.array_equal(found, nao.fk(q, "LArm"))


def test_fk_reads_a_motion_from_standard_input(
    capsys: Capture, nod: str, monkeypatch: pytest.MonkeyPatch, plain: str
) -> None:
    expected = {}
    for file in (nod, plain):
        assert run(["fk", file, "--frame", "Head", "--csv"]) == 0
        expected[file] = capsys.readouterr().out
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(Path(file).read_bytes())))
        assert run(["fk", "-", "--frame", "Head", "--csv"]) == 0
        assert capsys.readouterr().out == expected[file]


def test_a_pipe_of_configurations_is_read_once_and_whole(capsys: Capture, plain: str, tmp_path: Path) -> None:
    assert run(["fk", plain, "--frame", "Head", "--csv"]) == 0
    expected = capsys.readouterr().out
    os.mkfifo(tmp_path / "pipe")
    writer = threading.Thread(target=(tmp_path / "pipe").write_bytes, args=(Path(plain).read_bytes(),))
    writer.start()
    assert run(["fk", str(tmp_path / "pipe"), "--frame", "Head", "--csv"]) == 0
    writer.join()
    assert capsys.readouterr().out == expected


@pytest.mark.parametrize("command", ["fk - --frame Head", "view - --html view.html", "info --urdf /dev/stdin"])
def test_standard_input_without_an_end_is_refused_in_one_line(
    capsys: Capture, command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("nao_kin._core.files.MAX_BYTES", 1 << 20)
    with subprocess.Popen(["yes"], stdout=subprocess.PIPE) as endless:
        try:
            assert endless.stdout is not None
            monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(endless.stdout))
            words = command.replace("/dev/stdin", f"/dev/fd/{endless.stdout.fileno()}").split()
            assert "more than 1048576 bytes" in _refused(capsys, *words)
        finally:
            endless.kill()
    assert list(tmp_path.iterdir()) == []


def test_fk_says_when_a_motion_leaves_its_limits(capsys: Capture, wild: str, nao: nk.NaoModel) -> None:
    words = _refused(capsys, "fk", wild, "--frame", "Head")
    assert "wild.json: at 0.1 s outside the joint limits: LHand = 1.5 not in [0, 1]" in words
    clamped = _json(capsys, "fk", wild, "--frame", "Head", "--limits", "clamp", "--as", "matrix", "--json")
    q = nao.clamp(_wild().configurations(nao).q)
    assert np.array_equal([row["Head"] for row in clamped["configurations"]], nao.fk(q, "Head"))
    left = _json(
        capsys, "fk", wild, "--frame", "LLeg", "--limits", "ignore", "--hips", "left", "--json", "--as", "matrix"
    )
    q = _wild().configurations(nao, hips="left").q
    assert np.array_equal([row["LLeg"] for row in left["configurations"]], nao.fk(q, "LLeg"))


@pytest.mark.parametrize("command", ["fk", "view"])
@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("{plain}", "--posture", "Stand"), "gives whole configurations; leave out --posture"),
        (("{nod}", "--joint", "HeadYaw=1"), "gives whole configurations; leave out --posture"),
        (("{plain}", "--rate", "10"), "gives whole configurations"),
        (("--hips", "left"), "--hips needs FILE"),
        (("{nod}", "--rate", "-1"), "rate must be positive"),
        (("{nod}", "--hips", "both"), "expected one of average, left, right"),
    ],
)
def test_options_of_motions_are_for_motions(
    capsys: Capture, nod: str, plain: str, tmp_path: Path, command: str, options: Any, words: str
) -> None:
    filled = [option.format(nod=nod, plain=plain) for option in options]
    extra = ["--html", str(tmp_path / "x.html")] if command == "view" else []
    assert words in _refused(capsys, command, *filled, *extra)


def test_plain_configurations_are_no_motion(plain: str, tmp_path: Path, nod: str, nao: nk.NaoModel) -> None:
    assert not is_motion_file(plain)
    assert not is_motion_file(tmp_path / "nowhere.csv")
    assert not is_motion_file(tmp_path)
    for name, text in (
        ("one.json", json.dumps(nao.angles(nao.posture("Stand")))),
        ("many.json", json.dumps([nao.angles(nao.posture("Stand"))] * 3)),
        ("broken.json", '{"HeadYaw": '),
        ("empty.csv", ""),
        ("noise.csv", "\x00\x01"),
        ("noise.txt", "\ufffe;;;"),
    ):
        (tmp_path / name).write_text(text, encoding="utf-8")
        assert not is_motion_file(tmp_path / name), name
    assert is_motion_file(nod)
    assert is_motion_file(tmp_path / "nowhere.xar")  # of which the reader says what is wrong
    (tmp_path / "long.csv").write_text("time,HeadYaw\n" + "0.1,0.2\n" * 20_000, encoding="utf-8")
    assert is_motion_file(tmp_path / "long.csv")
    write_motion(_nod(), tmp_path / "long.json", rate=5000.0)
    (tmp_path / "nameless").write_bytes((tmp_path / "long.json").read_bytes())
    assert is_motion_file(tmp_path / "nameless")


# --- the viewer -------------------------------------------------------------------------------------------------------


# --- Recordings of a robot.


def test_a_recording_of_a_robot_is_checked(
    nao: nk.NaoModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    monkeypatch.chdir(tmp_path)
    times = np.arange(0.0, 1.0, 0.02)
    body = nao.to_body(np.tile(nao.posture("Stand", LElbowRoll=0.0, limits="clamp"), (times.size, 1)))
    body += np.random.default_rng(0).normal(0.0, np.radians(0.1), body.shape)
    table = dict(zip(nao.body_order, body.T, strict=True)) | {"LHand": np.full(times.size, np.nan)}
    rows = np.column_stack([times, times + 26.0, *table.values()])
    header = ",".join(["time", "LFsr", *table])
    np.savetxt("log.csv", rows, delimiter=",", header=header, comments="")
    command = ("motion", "check", "log.csv", "--ignore-other")
    assert run(command) == 2
    assert "LHand is 'nan'" in capsys.readouterr().err
    strict = _json(capsys, *command, "--missing", "Stand", "--json", code=1)
    assert {row["kind"] for row in strict["violations"]} == {"limit"}
    report = _json(capsys, *command, "--missing", "Stand", "--limits", "measured", "--json")
    assert report["violations"] == []
    assert len(report["accepted"]) == len(strict["violations"])
    assert run([*command, "--missing", "Stand", "--limits", "measured", "--collisions", "--rate", "10"]) == 0
    assert "accepted as measured: 2 joints, most LKneePitch" in capsys.readouterr().out
    # Without missing values it is a motion, and the sensors of the hips differ.
    np.savetxt("whole.csv", np.nan_to_num(rows), delimiter=",", header=header, comments="")
    whole = ("motion", "check", "whole.csv", "--ignore-other", "--limits", "measured")
    assert {row["kind"] for row in _json(capsys, *whole, "--json", code=1)["violations"]} == {"motor"}
    assert run([*whole, "--hips", "left"]) == 0
    renamed = Path("log.csv").read_text().replace("HeadYaw", "yaw")
    Path("renamed.csv").write_text(renamed)
    options = ("--columns", "yaw=HeadYaw", "--columns", "LFsr=", "--missing", "0", "--limits", "measured")
    assert run(["motion", "check", "renamed.csv", *options]) == 0
    Path("still.csv").write_text("HeadYaw\n0.1\n")
    capsys.readouterr()
    for wrong, reason in (
        ((*command, "--missing", "Stand", "--posture", "Stand"), "--posture and --missing exclude each other"),
        ((*command, "--missing", "Stand", "--from", "csv"), "leave out --from and --timeline"),
        ((*command, "--missing", "Sand"), "unknown posture 'Sand' (nearest: Stand"),
        (("motion", "check", "still.csv", "--missing", "Stand"), "it has no times: a motion needs a column of them"),
        ((*whole, "--hips", "middle"), "middle"),
        ((*command, "--limits", "ignore"), "ignore"),
    ):
        assert run(wrong) == 2, wrong
        assert reason in capsys.readouterr().err


# --- Degrees: those that are printed and written, and those of a file.


def test_degrees_of_a_motion_are_printed_and_written_but_not_read(
    capsys: Capture, tmp_path: Path, nao: nk.NaoModel
) -> None:
    plain, out = tmp_path / "plain.csv", tmp_path / "out.csv"
    plain.write_text("time,LElbowRoll,LHand\n0,-1.01,0.5\n1,-0.5,1\n")
    assert run(["motion", "convert", str(plain), str(out), "--deg"]) == 0
    assert out.read_text().splitlines()[0] == "time [s],LElbowRoll [deg],LHand [1]"
    capsys.readouterr()
    for file in (plain, out):
        keys = nk.motion.read_motion(file).keys
        assert np.concatenate(keys) == pytest.approx([-1.01, -0.5, 0.5, 1.0], abs=1e-12)
        rows = _json(capsys, "motion", "info", str(file), "--deg", "--json")["rows"]
        assert (rows[0]["least"], rows[0]["unit"]) == (pytest.approx(np.degrees(-1.01)), "deg")
    for name in ("out.json", "out.motion", "out.npz"):  # formats with one unit, or none to choose
        assert run(["motion", "convert", str(plain), str(tmp_path / name), "--deg"]) == 0
        assert nk.motion.read_motion(tmp_path / name).keys[0].tolist() == [-1.01, -0.5]
    capsys.readouterr()
    plain.write_text("time,LElbowRoll,HeadYaw\n0,-60,100\n1,-30,-90\n")
    assert run(["motion", "convert", str(plain), str(out), "--file-deg", "--force"]) == 0
    assert capsys.readouterr().err == ""
    assert nk.motion.read_motion(out).keys[0] == pytest.approx(np.radians([-60.0, -30.0]))
    # Whoever forgets the option, or gives it to a file in radians, is asked; also by the commands that refuse nothing.
    for command in (["motion", "info"], ["motion", "check"], ["motion", "plot", "{}", str(tmp_path / "a.svg")]):
        words = [str(plain) if word == "{}" else word for word in command]
        run(words if "{}" in command else [*words, str(plain)])
        assert "are these degrees" in capsys.readouterr().err
    nk.motion.write_motion(nk.motion.read_motion(out), out, overwrite=True)
    out.write_text(out.read_text().replace(" [rad]", ""))
    assert run(["motion", "info", str(out), "--file-deg"]) == 0
    assert "are these radians" in capsys.readouterr().err


def test_json_of_violations_and_changes_is_in_the_unit_that_it_names(
    capsys: Capture, tmp_path: Path, wild: str
) -> None:
    documents = [_json(capsys, "motion", "check", wild, "--json", *more, code=1) for more in ((), ("--deg",))]
    plain, turned = (document["violations"] for document in documents)
    assert {row["unit"] for row in turned} >= {"deg"}
    for one, other in zip(plain, turned, strict=True):
        factor = np.degrees(1.0) if "rad" in one["unit"] else 1.0
        assert other["unit"] == one["unit"].replace("rad", "deg")
        for name in ("value", "upper", "excess"):
            assert one[name] is None or other[name] == pytest.approx(factor * one[name])
