"""`nao-kin view`."""

from __future__ import annotations

import csv
import json
import os
import signal
import socket
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import command_line
import numpy as np
import pytest
from command_line import Capture
from forked import Forks, forks
from loops import full
from viewer_pages import PATIENCE, messages_of, processes, read_png, until

import nao_kin as nk
from nao_kin._core.process import find_browsers
from nao_kin.cli.app import run
from nao_kin.errors import BadArgument, NoBrowser
from nao_kin.viewer import Viewer


def _shown(path: Path) -> tuple[np.ndarray, dict]:
    """Return the configuration in a page, and the message that contains it."""
    (message,) = (m for m in messages_of(path.read_text(encoding="utf-8")) if m.get("kind") == "joints")
    return np.frombuffer(message["q"].data, dtype=np.float64), message


_refused = partial(command_line.refused, "view")


def _write(path: Path, names: tuple[str, ...], rows: np.ndarray) -> Path:
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([names, *rows.tolist()])
    return path


def test_it_writes_the_page_and_ends(capsys: Capture, tmp_path: Path, nao: nk.NaoModel) -> None:
    path = tmp_path / "nao.html"
    assert run(["view", "--html", str(path)]) == 0
    assert capsys.readouterr() == (f"{path}\n", "")
    assert path.read_text(encoding="utf-8") == _with_camera(nao)
    assert run(["view", "--html", str(path), "--force", "--json", "--no-wait"]) == 0
    assert json.loads(capsys.readouterr().out) == {"html": str(path)}


def _with_camera(nao: nk.NaoModel) -> str:
    viewer = Viewer(nao)
    viewer.camera("three-quarter")
    return viewer.static_html()


def test_postures_and_joints_are_shown(tmp_path: Path, nao: nk.NaoModel) -> None:
    path = str(tmp_path / "nao.html")
    assert run(["view", "--posture", "Crouch", "--html", path]) == 0
    q, message = _shown(Path(path))
    assert np.array_equal(q, nao.posture("Crouch"))
    assert message["up"] is None
    assert run(["view", "--posture", "LyingBack", "--joint", "HeadYaw=30", "--deg", "--html", path, "--force"]) == 0
    q, message = _shown(Path(path))
    expected = nao.angles(nao.posture("LyingBack")) | {"HeadYaw": np.radians(30.0)}
    assert np.allclose(q, nao.configuration(expected, limits="ignore"))
    assert message["up"] is None  # the page finds how it lies
    assert run(["view", "--joint", "RHipYawPitch=-0.2", "--nao", "v4", "--html", path, "--force"]) == 0
    assert _shown(Path(path))[0][nao.joint_names.index("LHipYawPitch")] == -0.2


@pytest.mark.parametrize(("text", "up"), [("0,0,-2", [0, 0, -1]), *full((" 1, 0 ,0", [1, 0, 0]), ("LyingBack", None))])
def test_the_direction_up_is_given_in_numbers_or_as_a_posture(
    tmp_path: Path, text: str, up: list[float] | None
) -> None:
    path = str(tmp_path / "nao.html")
    expected = Viewer(nk.load_nao()).rest("LyingBack") if up is None else up
    for what in (["--posture", "Sit"], []):
        assert run(["view", *what, "--up", text, "--html", path, "--force"]) == 0
        assert _shown(Path(path))[1]["up"] == pytest.approx(np.divide(expected, np.linalg.norm(expected)).tolist())


@pytest.mark.parametrize("text", ["1,2", *full("a,b,c", "0,0,0", "nan,0,1", "Lying", "", ",,")])
def test_another_direction_up_is_refused(capsys: Capture, text: str) -> None:
    _refused(capsys, "--up", text, "--html", "x.html")


@pytest.mark.parametrize("many", [True, False])
def test_a_trajectory_is_played(tmp_path: Path, nao: nk.NaoModel, many: bool) -> None:
    page = tmp_path / "nao.html"
    qs = np.linspace(nao.posture("Stand"), nao.posture("Crouch"), 5)
    if many:
        path = _write(tmp_path / "walk.csv", nao.body_order, nao.to_body(qs))
    else:
        path = tmp_path / "one.json"
        path.write_text(json.dumps(nao.angles(qs[0])), encoding="utf-8")
    balance = ["--balance"] if many else []
    assert run(["view", str(path), "--fps", "50", "--html", str(page), *balance]) == 0
    assert [m["margins"] for m in messages_of(page.read_text(encoding="utf-8")) if m.get("kind") == "plot"] == [
        True
    ] * many
    clips = [m for m in messages_of(page.read_text(encoding="utf-8")) if m.get("kind") == "clip"]
    assert len(clips) == many
    if many:
        assert clips[0]["fps"] == 50.0
        values = np.frombuffer(clips[0]["q"].data, dtype=np.float32).reshape(5, 25)
        assert np.allclose(values, qs, atol=1e-6)


def test_a_motion_plays_at_the_rate_of_its_samples(tmp_path: Path) -> None:
    nk.motion.write_motion(nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [0.5]]), tmp_path / "turn.json")
    page = tmp_path / "nao.html"
    assert run(["view", str(tmp_path / "turn.json"), "--rate", "10", "--html", str(page)]) == 0
    (clip,) = (m for m in messages_of(page.read_text(encoding="utf-8")) if m.get("kind") == "clip")
    assert clip["fps"] == 10.0


def test_frames_may_be_listed_or_repeated(tmp_path: Path) -> None:
    path = tmp_path / "nao.html"
    assert run(["view", "--frame", "LArm, RArm", "--frame", "CameraTop", "--html", str(path)]) == 0
    (message,) = (m for m in messages_of(path.read_text(encoding="utf-8")) if m.get("kind") == "frames")
    assert message["names"] == ["LArm", "RArm", "CameraTop"]


def test_joints_outside_their_limits_are_shown_and_named(capsys: Capture, tmp_path: Path) -> None:
    assert run(["view", "--posture", "StandInit", "--joint", "HeadYaw=3", "--html", str(tmp_path / "x.html")]) == 0
    assert capsys.readouterr().err == "nao-kin: outside the joint limits, shown in red: HeadYaw\n"


def test_missing_meshes_are_named(capsys: Capture, tmp_path: Path) -> None:
    urdf = tmp_path / "a.urdf"
    mesh = '<visual><geometry><mesh filename="no.stl"/></geometry></visual>'
    urdf.write_text(f'<robot name="a"><link name="l">{mesh}</link></robot>', encoding="utf-8")
    assert run(["view", "--urdf", str(urdf), "--html", str(tmp_path / "a.html")]) == 0
    assert capsys.readouterr().err == "nao-kin: mesh files not found: no.stl\n"


@pytest.mark.full
def test_bad_input_is_refused_in_one_line(
    capsys: Capture, tmp_path: Path, nao: nk.NaoModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    html = ("--html", str(tmp_path / "x.html"))
    assert "nearest: front" in _refused(capsys, "--camera", "frnt", *html)
    short = _write(tmp_path / "short.csv", nao.joint_names[:20], nao.random(1, 2)[:, :20])
    assert "missing joints" in _refused(capsys, str(short), *html)
    assert "--balance needs FILE" in _refused(capsys, "--posture", "Stand", "--balance", *html)
    assert not (tmp_path / "x.html").exists()
    monkeypatch.setenv("NAO_KIN_BROWSER", str(tmp_path / "no-browser"))
    assert "which is not a program" in _refused(capsys, "--png", str(tmp_path / "x.png"))
    monkeypatch.delenv("NAO_KIN_BROWSER")
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr("nao_kin._core.process._MAC_BROWSERS", ())
    assert "none was found: install one" in _refused(capsys, "--png", str(tmp_path / "x.png"))
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        assert "is in use" in _refused(capsys, "--port", str(taken.getsockname()[1]))


def test_files_that_cannot_be_written_are_refused_before_anything_is_loaded_or_drawn(
    capsys: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def drawn(*_: object, **__: object) -> None:
        raise AssertionError("too late")

    monkeypatch.setattr("nao_kin.cli.options.RobotOptions.load", drawn)
    monkeypatch.setattr("nao_kin.viewer.browser.start_browser", drawn)
    (tmp_path / "old.png").touch(0o444)
    for option in ("--html", "--png"):
        assert f"cannot write {tmp_path}: it is a folder" in _refused(capsys, option, str(tmp_path))
        assert "old.png: it is read-only (mode 0444)" in _refused(capsys, option, str(tmp_path / "old.png"))
        assert "No such file or directory" in _refused(capsys, option, str(tmp_path / "no" / "x"))
    for name in ("x.jpg", "x.jpeg", "x.svg", "x.png.txt"):
        path = tmp_path / name
        assert f"cannot write {path}: a picture is written as PNG; end the name in .png" in _refused(
            capsys, "--png", str(path)
        )
    assert "--video needs FILE" in _refused(capsys, "--video", str(tmp_path / "x.webm"))
    assert "end the name in .webm" in _refused(capsys, "a.csv", "--video", str(tmp_path / "x.mp4"))
    assert "expected one .html, .png, .webm or .zip file" in _refused(capsys, "--output", str(tmp_path / "x.mp4"))
    for other in ("--png", "--video"):
        one = ["--html", str(tmp_path / "x"), other, str(tmp_path / "." / "x")]
        between = ["--png", str(tmp_path / "y.png")] if other == "--video" else []
        assert f"--html and {other} name one file" in _refused(capsys, "a.csv", *one[:2], *between, *one[2:])
    assert "x.jpg: a page is written as HTML; end the name in .html" in _refused(capsys, "--html", "x.jpg")
    assert [path.name for path in tmp_path.iterdir()] == ["old.png"]
    viewer = Viewer(nk.load_nao())
    with pytest.raises(BadArgument, match=r"end the name in \.png"):
        viewer.save_png(tmp_path / "x.jpg")
    with pytest.raises(BadArgument, match=r"end the name in \.html"):
        viewer.save_html(tmp_path / "x.jpg")
    with pytest.raises(BadArgument, match="timeout must be 0 s or more, got -1"):
        viewer.save_png(tmp_path / "x.png", timeout=-1)


def test_a_page_and_a_picture_that_are_there_are_replaced_only_by_force(capsys: Capture, tmp_path: Path) -> None:
    for option in ("--html", "--png"):
        path = tmp_path / option
        path.write_text("mine", encoding="utf-8")
        if option == "--png":
            path = path.rename(tmp_path / "x.png")
        # A URDF that is not there: the robot is not loaded before the file is looked at.
        assert "overwrite=True (--force) replaces it" in _refused(capsys, "--urdf", "no.urdf", option, str(path))
        assert path.read_text(encoding="utf-8") == "mine"
    assert run(["view", "--html", str(tmp_path / "--html"), "--force"]) == 0
    assert (tmp_path / "--html").stat().st_size > 1_000_000


@pytest.mark.full
def test_a_picture_is_written(capsys: Capture, tmp_path: Path) -> None:
    try:
        find_browsers()
    except NoBrowser as error:
        pytest.skip(f"no browser to draw with: {error}")
    path = tmp_path / "nao.png"
    assert run(["view", "--posture", "Crouch", "--png", str(path), "--camera", "side"]) == 0
    assert capsys.readouterr() == (f"{path}\n", "")
    picture = read_png(path.read_bytes())
    assert picture.shape == (800, 1280, 3)
    assert picture.std() > 8.0


@pytest.mark.full
def test_without_files_it_serves_until_interrupted() -> None:
    process = subprocess.Popen(
        [sys.executable, "-m", "nao_kin", "view", "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout is not None
        url = json.loads("".join(process.stdout.readline() for _ in range(3)))["url"]
        with urllib.request.urlopen(url, timeout=PATIENCE) as response:
            assert b"<title>nao_v6</title>" in response.read()
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=PATIENCE)
        assert (process.returncode, out, err) == (130, "", "")
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()


def test_a_machine_without_a_browser_says_so(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("webbrowser.open", lambda url: False)
    assert run(["view", "--open"]) == 2
    out, err = capsys.readouterr()
    assert out.startswith("http://127.0.0.1:")
    assert err.startswith("nao-kin: no web browser to open http://127.0.0.1:")


def test_an_address_that_is_dead_at_once_is_refused(capsys: Capture) -> None:
    assert "--no-wait without --open shows nothing" in _refused(capsys, "--no-wait")


@pytest.fixture(scope="module")
def programs(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Forks]:
    """A process that has loaded what `nao-kin view` needs."""
    imports = "import nao_kin as nk, nao_kin.cli.app, nao_kin.viewer.browser\nnk.Viewer(nk.load_nao())"
    with forks(imports, tmp_path_factory.mktemp("programs")) as programs:
        yield programs


@pytest.mark.full
@pytest.mark.skipif(os.name != "posix", reason="signals")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_picture_cut_short_leaves_nothing_behind(programs: Forks, short_folder: Path, number: signal.Signals) -> None:
    try:
        find_browsers()
    except NoBrowser as error:
        pytest.skip(f"no browser to draw with: {error}")

    def running() -> bool:
        return processes(str(short_folder)) != []

    code = "from nao_kin.cli import main\nmain()"
    process = programs.start(code, "view", "--png", "x.png", cwd=short_folder, TMPDIR=str(short_folder))
    assert until(running)
    os.kill(process, number)
    assert programs.end() == (128 + number, "", "")
    assert not running()
    assert list(short_folder.iterdir()) == []
