"""Photos of a chessboard, rendered by OpenCV, with a log of the head's joints."""

from __future__ import annotations

import json
import math
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nao_kin as nk
from nao_kin.calibration import calibrate, from_photos
from nao_kin.cli.app import run
from nao_kin.errors import BadArgument, BadInputFile, NaoKinWarning

cv2 = pytest.importorskip("cv2", reason="OpenCV is not installed")

COLUMNS, ROWS, SQUARE, CELL = 6, 4, 0.05, 24
LENS = [299.02503, 299.26374, 159.5, 119.5]  # the one that took the photos
BOARD: dict[str, Any] = {"board": (COLUMNS, ROWS), "square": SQUARE}
T_TORSO_BOARD = nk.screws.pose(
    nk.rotations.matrix_from_rpy([0.0, 0.15, 0.1]) @ np.array([[0, 0, 1.0], [-1, 0, 0], [0, -1, 0]]), [0.75, 0.12, 0.27]
)
ANGLES = [(yaw, pitch) for yaw in (-0.2, 0.0, 0.2) for pitch in (-0.1, 0.1)]


def photo(robot: nk.RobotModel, q: np.ndarray) -> np.ndarray:
    """Render what the top camera sees of the board, in 320 × 240 pixels."""
    camera = nk.world.camera(robot, "CameraTop", "QVGA")
    sheet = np.full(((ROWS + 3) * CELL, (COLUMNS + 3) * CELL), 255, np.uint8)
    for row in range(ROWS + 1):
        for column in range(COLUMNS + 1):
            if (row + column) % 2 == 0:
                sheet[(row + 1) * CELL : (row + 2) * CELL, (column + 1) * CELL : (column + 2) * CELL] = 0
    # Four corners of the sheet; its first inner corner is at (2, 2) cells, between pixels.
    cells = np.array([[0, 0], [COLUMNS + 3, 0], [COLUMNS + 3, ROWS + 3], [0, ROWS + 3]], dtype=np.float32)
    points = np.pad(SQUARE * (cells - 2.0), ((0, 0), (0, 1)))
    T = nk.screws.inverse(robot.fk(q, camera.frame)) @ T_TORSO_BOARD
    seen = camera.project(nk.screws.transform_point(T, points))
    M = cv2.getPerspectiveTransform(cells * CELL - 0.5, seen.astype(np.float32))
    image = cv2.warpPerspective(sheet, M, (320, 240), flags=cv2.INTER_AREA, borderValue=128)
    return np.asarray(cv2.GaussianBlur(image, (3, 3), 0))


@pytest.fixture(scope="module")
def true(nao: nk.NaoModel) -> nk.RobotModel:
    return nao.with_offsets({"HeadPitch": 0.02}, {"CameraTop": (0, 0, 0, 0.01, -0.02, 0.015)})


@pytest.fixture(scope="module")
def folder(true: nk.RobotModel, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Photos at 10.0, 10.5 … s, while the head moves on between them, and a log of the head at 20 Hz."""
    folder = tmp_path_factory.mktemp("photos")
    for k, (yaw, pitch) in enumerate(ANGLES):
        image = photo(true, true.configuration({"HeadYaw": yaw, "HeadPitch": pitch}))
        cv2.imwrite(str(folder / f"top_{10.0 + 0.5 * k:.3f}.png"), image)
    times = np.arange(9.97, 13.0, 0.05)  # the photos are between rows
    moments = 10.0 + 0.5 * np.arange(len(ANGLES))
    yaws, pitches = (np.interp(times, moments, [angles[k] for angles in ANGLES]) for k in (0, 1))
    # Each photo's angles are held from 0.1 s before to 0.1 s after it.
    near = np.abs(times[:, None] - moments) < 0.11
    held = near.argmax(axis=1)
    for values, k in ((yaws, 0), (pitches, 1)):
        values[near.any(axis=1)] = np.array(ANGLES)[held, k][near.any(axis=1)]
    rows = [f"{t:.3f},{y:.9f},{p:.9f}" for t, y, p in zip(times, yaws, pitches, strict=True)]
    (folder / "head.csv").write_text("time,HeadYaw,HeadPitch\n" + "\n".join(rows) + "\n")
    return folder


def test_the_corners_in_photos_are_those_of_the_board(nao: nk.NaoModel, true: nk.RobotModel, folder: Path) -> None:
    seen = from_photos(nao, folder, folder / "head.csv", **BOARD, missing=0.0)
    q, pixels = np.asarray(seen.q), np.asarray(seen.pixels)
    assert np.allclose(q[:, :2], ANGLES, atol=1e-6)
    T = nk.screws.inverse(true.fk(q, "CameraTop")) @ T_TORSO_BOARD
    expected = seen.camera.project(nk.screws.transform_point(T[:, None], np.asarray(seen.points)))
    assert np.abs(pixels - expected).max() < 0.4
    assert np.abs(pixels - expected).mean() < 0.1
    assert (seen.camera.width, seen.camera.height, seen.board, seen.frame) == (320, 240, "chessboard", None)


def test_photos_find_the_camera_and_what_they_cannot_is_named(
    nao: nk.NaoModel, true: nk.RobotModel, folder: Path
) -> None:
    frames = {"CameraTop": ["roll", "pitch", "yaw"]}
    unknown = from_photos(nao, folder, folder / "head.csv", **BOARD, missing=0.0, noise=0.1, lens=LENS)
    found = calibrate(nao, [unknown], joints=["HeadYaw", "HeadPitch"], frames=frames)
    assert found.held == ("HeadYaw offset", "HeadPitch offset")
    known = from_photos(
        nao, folder, folder / "head.csv", **BOARD, missing=0.0, noise=0.1, place=T_TORSO_BOARD, lens=LENS
    )
    found = calibrate(nao, [known], joints=["HeadYaw", "HeadPitch"], frames=frames)
    assert found.held == ("HeadPitch offset",)
    axes = [robot.fk(np.asarray(known.q), "CameraTop")[:, :3, 0] for robot in (true, found.calibrated())]
    assert np.abs(axes[0] - axes[1]).max() < 0.002


def shown_parts(nao: nk.NaoModel, folder: Path, photos: list[np.ndarray]) -> np.ndarray:
    """The corners in some photos, and in one of the whole board before them, shape (n + 1, corners, 2)."""
    paths = [folder / f"top_{10 + k}.png" for k in range(len(photos) + 1)]
    for path, image in zip(paths, [photo(nao, nao.neutral()), *photos], strict=True):
        cv2.imwrite(str(path), image)
    log = folder / "still.csv"
    log.write_text("time,HeadYaw\n0,0\n" + "".join(f"{k / 4},0\n" for k in range(1, 4 * (len(paths) + 11))))
    return np.asarray(from_photos(nao, paths, log, **BOARD, missing=0.0).pixels)


@pytest.mark.filterwarnings("ignore:.* photos show")
def test_of_a_board_that_the_edge_of_a_photo_cuts_the_corners_that_are_seen_count(
    nao: nk.NaoModel, tmp_path: Path
) -> None:
    # The board goes out of the photo at the right, left, lower and upper edge, and at two of them.
    turns = [(0.38, 0.0), (-0.45, 0.1), (0.0, -0.3), (0.0, 0.22), (-0.38, 0.22), (0.3, -0.3)]
    heads = nao.configuration({"HeadYaw": [t[0] for t in turns], "HeadPitch": [t[1] for t in turns]})
    found = shown_parts(nao, tmp_path, [photo(nao, q) for q in heads])[1:]
    camera = nk.world.camera(nao, "CameraTop", "QVGA")
    x, y = (line.ravel() for line in np.meshgrid(SQUARE * np.arange(COLUMNS), SQUARE * np.arange(ROWS)))
    T = nk.screws.inverse(nao.fk(heads, "CameraTop")) @ T_TORSO_BOARD
    expected = camera.project(nk.screws.transform_point(T[:, None], np.stack((x, y, 0.0 * x), axis=-1)))
    counts = np.isfinite(found[..., 0]).sum(axis=1)
    assert counts.tolist() == [16, 12, 18, 18, 12, 15]
    assert np.nanmax(np.abs(found - expected)) < 0.5


def test_which_part_of_a_board_is_seen_must_be_clear(nao: nk.NaoModel, tmp_path: Path) -> None:
    hidden, both, other = (photo(nao, nao.neutral()) for _ in range(3))
    left = int(shown_parts(nao, tmp_path, [])[0, 1, 0]) + 4
    hidden[:, :left] = 128  # by a hand: the edge of the photo cuts nothing
    both = both[:, left : left + 90]  # both edges do
    both = np.asarray(cv2.copyMakeBorder(both, 0, 0, 0, 0, cv2.BORDER_CONSTANT))
    wide = np.full_like(other, 128)
    wide[:, : both.shape[1]] = both
    other = 255 - photo(nao, nao.configuration({"HeadYaw": 0.38}))  # not the colours of the board
    with pytest.warns(NaoKinWarning, match=r"3 of 4 photos show no chessboard with 6 × 4 inner"):
        found = shown_parts(nao, tmp_path, [hidden, wide, other])
    assert np.isnan(found[1:]).all()
    assert np.isfinite(found[0]).all()


def test_times_are_numbers_in_names_or_a_table(nao: nk.NaoModel, folder: Path, tmp_path: Path) -> None:
    names = sorted(path.name for path in folder.glob("*.png"))
    table = tmp_path / "times.csv"
    table.write_text("file;time\n" + "".join(f"{name};{10.0 + 0.5 * k}\n" for k, name in enumerate(names)))
    log = folder / "head.csv"
    plain = from_photos(nao, folder, log, **BOARD, missing=0.0)
    by_table = from_photos(nao, folder, log, **BOARD, missing=0.0, times=table)
    mapped = from_photos(
        nao, folder, log, **BOARD, missing=0.0, times={name: 10.0 + 0.5 * k for k, name in enumerate(names)}
    )
    for other in (by_table, mapped):
        assert np.array_equal(np.asarray(other.q), np.asarray(plain.q))
    # In milliseconds; listed in another order.
    paths = []
    for k, name in enumerate(names):
        paths.append(tmp_path / f"{10000 + 500 * k}.png")
        paths[-1].write_bytes((folder / name).read_bytes())
    assert np.array_equal(np.asarray(from_photos(nao, paths[::-1], log, **BOARD, missing=0.0).q), np.asarray(plain.q))


def test_joint_values_are_interpolated_between_the_rows_of_the_log(
    nao: nk.NaoModel, folder: Path, tmp_path: Path
) -> None:
    log = tmp_path / "turning.csv"
    log.write_text("time,HeadYaw,HeadPitch\n9.9,0.1,0\n10.1,0.3,-0.2\n10.4,0.3,0.2\n10.6,0.1,0.4\n")
    photos = [folder / "top_10.000.png", folder / "top_10.500.png"]
    q = np.asarray(from_photos(nao, photos, log, **BOARD, missing=0.0).q)
    assert np.allclose(q[:, :2], [(0.2, -0.1), (0.2, 0.3)])


def test_a_photo_without_a_board_is_named_and_counts_nothing(nao: nk.NaoModel, folder: Path, tmp_path: Path) -> None:
    paths = sorted(folder.glob("*.png"))[:2]
    empty = tmp_path / "top_11.000.png"
    cv2.imwrite(str(empty), np.full((240, 320), 90, np.uint8))
    with pytest.warns(
        NaoKinWarning, match=r"1 of 3 photos show no chessboard with 6 × 4 inner corners: top_11\.000\.png"
    ):
        seen = from_photos(nao, [*paths, empty], folder / "head.csv", **BOARD, missing=0.0)
    assert np.isnan(np.asarray(seen.pixels)[2]).all()
    with pytest.raises(BadArgument, match="none of 1 photos shows a whole chessboard"):
        from_photos(nao, [empty], folder / "head.csv", **BOARD, missing=0.0)


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"photos": "nowhere"}, BadArgument, "no folder of photos: 'nowhere'"),
        ({"photos": []}, BadArgument, "photos must have at least one path"),
        ({"photos": ["broken_10.1.png"]}, BadInputFile, "broken_10.1.png.* is no image that OpenCV reads"),
        ({"photos": ["x.png"]}, BadArgument, "the photo x.png has not a time at the end of its name"),
        (
            {"photos": ["top_99.0.png"]},
            BadArgument,
            r"photo top_99.0.png is of 99.000000 s, and the log from 9.97\d* to",
        ),
        (
            {"photos": ["big_10.0.png", "top_10.500.png"]},
            BadArgument,
            "photos must have one size: top_10.500.png has 320",
        ),
        ({"board": (6, 2)}, BadArgument, "rows of board must be at least 3"),
        ({"board": (6, 4, 3)}, BadArgument, r"board must be the columns and rows of inner corners, got \(6, 4, 3\)"),
        ({"square": 0.0}, BadArgument, "square must be positive"),
        ({"camera": "CameraTp"}, nk.errors.UnknownName, "unknown camera of nao_v6 'CameraTp'"),
        ({"lens": [500.0]}, BadArgument, "lens must be fx, fy, cx, cy and perhaps a distortion, got 1 numbers"),
        (
            {"lens": [560, 560, 320, 240]},
            BadArgument,
            "intrinsics are of images of about 640 × 480 pixels, not 320 × 240",
        ),
        ({"times": {"a.png": 1.0}}, nk.errors.UnknownName, "unknown photo in times 'top_10.000.png'"),
        ({"times": "bad.csv"}, BadInputFile, r"bad.csv: line 2: expected the columns file and time"),
        ({"place": [1, 2, 3]}, nk.errors.WrongShape, "place must have shape"),
        ({"missing": None}, BadInputFile, "missing"),
    ],
)
def test_wrong_photos_are_refused(
    nao: nk.NaoModel,
    folder: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    change: dict[str, Any],
    error: type[Exception],
    message: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("top_10.000.png", "top_10.500.png"):
        Path(name).write_bytes((folder / name).read_bytes())
        Path("x.png").write_bytes((folder / name).read_bytes())
        Path("top_99.0.png").write_bytes((folder / name).read_bytes())
    Path("broken_10.1.png").write_bytes(b"no image")
    cv2.imwrite("big_10.0.png", np.full((480, 640), 90, np.uint8))
    Path("bad.csv").write_text("file,time\ntop_10.000.png,ten\n")
    given = {"photos": ["top_10.000.png", "top_10.500.png"], "missing": 0.0, **BOARD, **change}
    with pytest.raises(error, match=message):
        from_photos(nao, given.pop("photos"), folder / "head.csv", **given)


def test_a_log_with_a_gap_at_a_photo_is_refused(nao: nk.NaoModel, folder: Path, tmp_path: Path) -> None:
    lines = (folder / "head.csv").read_text().splitlines()
    log = tmp_path / "gap.csv"
    log.write_text("\n".join([*lines[:5], *lines[30:]]) + "\n")
    with pytest.raises(BadArgument, match=r"the log has a gap of more than 0.5 s around the photo top_10\.500\.png"):
        from_photos(nao, folder, log, **BOARD, missing=0.0)
    log.write_text("HeadYaw,HeadPitch\n0,0\n")
    with pytest.raises(BadInputFile, match="no column of times, which photos need"):
        from_photos(nao, folder, log, **BOARD, missing=0.0)


def test_the_command_calibrates_from_photos(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log, output = str(folder / "head.csv"), tmp_path / "mine.toml"
    words = ["calibrate", "--photos", str(folder), "--board", "6x4", "--square", str(SQUARE), "--log", log]
    lens = ["--lens", ",".join(map(str, LENS))]
    assert run([*words, *lens, "--missing", "0", "-o", str(output), "--json"]) == 0
    out, err = capsys.readouterr()
    found = json.loads(out)
    assert "HeadYaw offset" in found["held"]
    assert "HeadYaw offset is held at 0 ± 1°; observe points at measured places" in err
    assert "# HeadYaw: not determined" in output.read_text(encoding="utf-8")
    six = [*T_TORSO_BOARD[:3, 3], *nk.rotations.rpy_from_matrix(T_TORSO_BOARD[:3, :3])]
    printed = []
    for unit, options in ((1.0, ("--json",)), (math.degrees(1.0), ("--deg",))):
        place = ",".join(f"{value:.6f}" for value in (*six[:3], *(unit * angle for angle in six[3:])))
        assert run([*words, *lens, "--missing", "0", "--place", place, *options]) == 0
        printed.append(capsys.readouterr())
    assert "HeadYaw offset" in printed[1].out
    assert printed[1].out.count("not determined") == 1  # HeadPitch beside the pitch of the camera
    yaw = math.degrees(json.loads(printed[0].out)["joints"]["HeadYaw"])
    assert float(re.search(r"HeadYaw offset +(\S+)", printed[1].out)[1]) == pytest.approx(yaw, abs=1e-3)
    # A log in degrees without units is read with --file-deg; otherwise its angles turn the head by more than a turn.
    times, *rows = (folder / "head.csv").read_text().splitlines()
    degrees = [line.split(",") for line in rows]
    text = "".join(f"{row[0]},{','.join(str(math.degrees(float(x))) for x in row[1:])}\n" for row in degrees)
    (tmp_path / "deg.csv").write_text(f"{times}\n{text}")
    assert run([*words[:-1], str(tmp_path / "deg.csv"), *lens, "--missing", "0", "--json", "--file-deg"]) == 0
    again = json.loads(capsys.readouterr().out)
    assert again["joints"]["HeadPitch"] == pytest.approx(found["joints"]["HeadPitch"], abs=1e-9)
    for wrong, message in (
        (["calibrate"], "give a FILE of observations, or --photos"),
        (["calibrate", "--board", "6x4"], "--board needs --photos"),
        (["calibrate", "--photos", str(folder)], "--photos needs --board"),
        ([*words[:4], "six", *words[5:]], "--board six: expected columns and rows of inner corners, as in 9x6"),
        ([*words, "--place", "1,2"], "--place '1,2': 2 numbers, expected 6"),
        ([*words, "--lens", "a"], "--lens 'a': 'a' is not a finite number"),
    ):
        assert run(wrong) == 2
        out, err = capsys.readouterr()
        assert (out, err.count("\n")) == ("", 1)
        assert message in err


def test_without_opencv_one_line_says_how_to_get_it(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "cv2", None)
    words = ["--photos", str(folder), "--board", "9x6", "--square", "0.03", "--log", "x.csv"]
    assert run(["calibrate", *words]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert "needs opencv-python-headless: pip install 'nao-kin[photos]'" in err


def test_the_camera_its_lens_the_board_and_the_log_s_unit_are_as_stated(
    nao: nk.NaoModel, folder: Path, tmp_path: Path
) -> None:
    lens = [280.0, 281.0, 160.0, 120.0, -0.1, 0.01, 0.0, 0.0]
    stated = {"camera": "CameraBottom", "lens": lens, "frame": "LArm", "name": "wall"}
    plain = from_photos(nao, folder, folder / "head.csv", **BOARD, missing=0.0)
    seen = from_photos(nao, folder, folder / "head.csv", **BOARD, missing=0.0, **stated)
    camera = nk.world.Camera.from_matrix([[280, 0, 160], [0, 281, 120], [0, 0, 1]], lens[4:], frame="", size=(320, 240))
    assert (seen.camera.frame, seen.frame, seen.board) == ("CameraBottom", "LArm", "wall")
    assert np.array_equal(seen.camera.matrix, camera.matrix)
    assert seen.camera.distortion == camera.distortion
    assert np.array_equal(np.asarray(seen.pixels), np.asarray(plain.pixels))
    rows = np.loadtxt(folder / "head.csv", delimiter=",", skiprows=1) * [1.0, *np.degrees([1.0, 1.0])]
    np.savetxt(tmp_path / "deg.csv", rows, delimiter=",", header="time,HeadYaw,HeadPitch", comments="")
    turned = from_photos(nao, folder, tmp_path / "deg.csv", **BOARD, missing=0.0, degrees=True)
    assert np.allclose(np.asarray(turned.q), np.asarray(plain.q), atol=1e-12)


def test_boards_in_the_dark_are_found(nao: nk.NaoModel, folder: Path, tmp_path: Path) -> None:
    name = "top_10.000.png"
    image = cv2.imread(str(folder / name), cv2.IMREAD_GRAYSCALE)
    cv2.imwrite(str(tmp_path / name), (0.05 * image).astype(np.uint8))
    bright, dark = (
        from_photos(nao, [place / name], folder / "head.csv", **BOARD, missing=0.0).pixels
        for place in (folder, tmp_path)
    )
    assert np.abs(np.asarray(bright) - dark).max() < 0.5
