"""Files of configurations: the output of `nao-kin fk FILE`, printed and written, and what all commands do alike."""

from __future__ import annotations

import contextlib
import csv
import io
import itertools
import json
import warnings
from collections.abc import Callable
from pathlib import Path

import command_line
import numpy as np
import pytest
from command_line import Capture
from loops import full
from scipy.spatial.transform import Rotation

import nao_kin as nk
from nao_kin.cli.app import run

FRAMES = ("LArm", "RLeg")
TIMES = (0.0, 0.5, 1.25)
KINDS = ("plain.csv", "plain.json", "plain.npy", "plain.parquet", "timed.csv", "units.csv", "few.csv", "motion.json")
KINDS += ("motion.xar", "motion.py")
# Formats that standard output refuses, and formats that --output refuses.
ONLY_OUTPUT, ONLY_PRINTED = ("plain.npy", "plain.parquet"), ("plain.json",)
STYLES = ("matrix", "rpy", "quaternion")
PLACES = ((), ("--reference", "LLeg", "--limits", "clamp"))


def _q(nao: nk.NaoModel, *, inside: bool) -> np.ndarray:
    """Three configurations; without `inside`, two joints of the last are outside their limits."""
    q = np.stack([nao.posture("StandInit"), nao.posture("Crouch"), nao.posture("Stand")])
    if not inside:
        q[2, nao.joint_names.index("HeadYaw")] = 2.4
        q[2, nao.joint_names.index("LHand")] = 1.3
    return q


def _file(nao: nk.NaoModel, folder: Path, kind: str, q: np.ndarray, *, deg: bool) -> str:
    """The configurations in a file; formats without units of their own are in degrees where `deg` says so."""
    path = folder / kind
    turning = np.array([unit == "rad" for unit in nao.joint_units])
    values = np.where(turning, np.degrees(q), q) if deg else q
    names = list(nao.joint_names)
    if kind == "plain.npy":
        np.save(path, values)
    elif kind == "plain.json":
        path.write_text(json.dumps([dict(zip(names, row, strict=True)) for row in values.tolist()]))
    elif kind == "plain.parquet":
        pa = pytest.importorskip("pyarrow")
        pytest.importorskip("pyarrow.parquet").write_table(pa.table(dict(zip(names, values.T, strict=True))), path)
    elif kind.startswith("motion."):
        # JSON and xar say their unit; Python is in the one that --file-deg tells.
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "NAOqi refuses keys at 0 s")
            nk.motion.write_motion(nk.Motion(TIMES, names, values if kind == "motion.py" else q), path, overwrite=True)
    else:
        if kind == "units.csv":  # says its units itself, others than the option does
            values = np.where(turning, q, 100.0 * q) if deg else np.where(turning, np.degrees(q), 100.0 * q)
            turn = "rad" if deg else "deg"
            names = [f"{name} [{turn if turns else '%'}]" for name, turns in zip(names, turning, strict=True)]
        if kind == "few.csv":  # the joints that differ from the posture that --posture names
            kept = [column for column in range(nao.nq) if np.ptp(q[:, column]) or column < 2]
            names, values = [names[column] for column in kept], values[:, kept]
        if kind != "plain.csv":
            names, values = ["time", *names], np.column_stack([TIMES, values])
        lines = [names, *([repr(value) for value in row] for row in values.tolist())]
        path.write_text("\n".join(",".join(line) for line in lines) + "\n")
    return str(path)


def _poses(text: str) -> tuple[list[str], np.ndarray]:
    """The header of a CSV of poses, and the numbers of the poses (rows, frames, k)."""
    header, *records = csv.reader(io.StringIO(text))
    first = header.index("frame") + 1
    numbers = np.array([list(map(float, record[first:])) for record in records])
    assert [record[first - 1] for record in records] == list(FRAMES) * (len(records) // len(FRAMES))
    return header, numbers.reshape(-1, len(FRAMES), len(header) - first)


def _matrices(numbers: np.ndarray, style: str, *, deg: bool) -> np.ndarray:
    """Homogeneous matrices of numbers (..., k), by SciPy."""
    if style == "matrix":
        return numbers.reshape(*numbers.shape[:-1], 4, 4)
    T = np.zeros((*numbers.shape[:-1], 4, 4))
    T[..., 3, 3], T[..., :3, 3] = 1.0, numbers[..., :3]
    turns = numbers[..., 3:].reshape(-1, numbers.shape[-1] - 3)
    quaternions = style == "quaternion"  # scalar first here, last in SciPy
    turned = Rotation.from_quat(np.roll(turns, -1, 1)) if quaternions else Rotation.from_euler("xyz", turns, deg)
    T[..., :3, :3] = turned.as_matrix().reshape(*numbers.shape[:-1], 3, 3)
    return T


@pytest.mark.full
@pytest.mark.parametrize("deg", [False, True], ids=["rad", "deg"])
@pytest.mark.parametrize("kind", KINDS)
def test_poses_are_the_same_on_standard_output_and_in_files(
    nao: nk.NaoModel, tmp_path: Path, capsys: Capture, kind: str, deg: bool
) -> None:
    for index, style in enumerate(STYLES):
        places = PLACES[(index + deg) % 2]
        q = _q(nao, inside="clamp" not in places)
        file = _file(nao, tmp_path, kind, q, deg=deg)
        options = [
            *itertools.chain(*(("--frame", name) for name in FRAMES)),
            "--as",
            style,
            *places,
            *["--deg", "--file-deg"] * deg,
        ]
        options += ["--posture", "StandInit"] if kind == "few.csv" else []
        reference = places[1] if "--reference" in places else None
        expected = nao.fk(nao.clamp(q), FRAMES, reference=reference)
        case = f"{kind} {' '.join(options)}"
        header: list[str] = []
        if kind not in ONLY_OUTPUT:
            assert run(["fk", file, *options, "--csv"]) == 0, case
            header, printed = _poses(capsys.readouterr().out)
            assert np.allclose(_matrices(printed, style, deg=deg), expected, rtol=0, atol=1e-9), case
        if kind in ONLY_PRINTED:
            continue
        for ending in ("csv", "npy") if style == "rpy" else ("csv",):
            out = tmp_path / f"poses.{ending}"
            assert run(["fk", file, *options, "-o", str(out), "--force"]) == 0, case
            capsys.readouterr()
            if ending == "csv":
                written, numbers = _poses(out.read_text())
                assert not header or written == header, case
            else:
                numbers = np.load(out)
                numbers = numbers.reshape(*numbers.shape[:2], -1)
            assert np.allclose(_matrices(numbers, style, deg=deg), expected, rtol=0, atol=1e-9), case


def test_a_row_of_a_long_file_has_its_own_number_and_time(
    nao: nk.NaoModel, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("nao_kin.cli.fk._CHUNK", 2)
    file = _file(nao, tmp_path, "timed.csv", _q(nao, inside=True), deg=False)
    assert run(["fk", file, "--frame", "LArm", "--csv"]) == 0
    rows = [line.split(",")[:2] for line in capsys.readouterr().out.splitlines()]
    assert rows == [["row", "time"], *([str(row), repr(time)] for row, time in enumerate(TIMES))]


@pytest.mark.parametrize(
    "arguments",
    [("fk",), ("fk", "--rate", "10"), ("collisions",), ("collisions", "--rate", "10"), ("balance",), ("state",),
     ("view", "--html", "{folder}/a.html")],
)  # fmt: skip
def test_a_file_of_degrees_is_answered_with_the_option_for_degrees(
    capsys: Capture, tmp_path: Path, nao: nk.NaoModel, arguments: tuple[str, ...]
) -> None:
    # As np.degrees gives them, of all joints: the hands too, which have no angles.
    rows = [np.degrees(nao.posture(name)) for name in ("Stand", "StandInit", "Sit")]
    text = "".join(f"{k / 10:.1f}," + ",".join(f"{v:.3f}" for v in row) + "\n" for k, row in enumerate(rows))
    file = tmp_path / "deg.csv"
    file.write_text(",".join(("time", *nao.joint_names)) + "\n" + text)
    command, *more = (word.format(folder=tmp_path) for word in arguments)
    run([command, str(file), *more])
    err = capsys.readouterr().err
    assert "are these degrees" in err
    assert "--file-deg" in err
    assert "clamp" not in err


READERS = (("fk",), ("balance",), ("collisions",), ("state",), ("view", "--html", "page.html", "--force"))


@pytest.fixture
def refused(tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> Callable[..., str]:
    """Run a command, which must refuse its input, in a folder of its own; return the line that it prints."""
    monkeypatch.chdir(tmp_path)
    return lambda command, *arguments: command_line.refused(command, capsys, *arguments)


@pytest.mark.parametrize("reader", READERS, ids=lambda reader: reader[0])
def test_every_command_refuses_columns_for_a_motion_and_names_unknown_ones(
    nao: nk.NaoModel, refused: Callable[..., str], reader: tuple[str, ...]
) -> None:
    nk.motion.write_motion(nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [0.5]]), "wave.json")
    command, *more = reader
    said = refused(command, "wave.json", *more, "--columns", "HeadYaw=HeadPitch")
    assert "--columns is for whole configurations; 'wave.json' is read as a motion" in said
    Path("log.csv").write_text(",".join(("time", *nao.joint_names)) + "\n0" + 25 * ",0.1" + "\n")
    assert "unknown column of log.csv 'yaw'" in refused(command, "log.csv", *more, "--columns", "yaw=HeadYaw")
    said = refused(command, "log.csv", *more, "--columns", "yaw=HeadYaw", "--rate", "5")
    assert "'log.csv' is read as a motion" in said


@pytest.mark.parametrize("reader", READERS[:3], ids=lambda reader: reader[0])
def test_every_command_with_limits_applies_them_to_a_motion(
    refused: Callable[..., str], capsys: Capture, reader: tuple[str, ...]
) -> None:
    nk.motion.write_motion(nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [2.5]]), "over.json")
    said = refused(reader[0], "over.json")
    assert "over.json: at 1 s outside the joint limits: HeadYaw = 2.5 not in [-2.08567, 2.08567] rad" in said
    assert "--limits clamp or --limits ignore accepts them" in said
    assert run([reader[0], "over.json", "--limits", "clamp"]) in (0, 1)
    moved = "nao-kin: --limits clamp moved 1 of 2 rows to the limits, by at most 0.414 rad (HeadYaw)\n"
    assert capsys.readouterr().err == moved
    assert run([reader[0], "over.json", "--limits", "ignore"]) in (0, 1)
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("reader", READERS, ids=lambda reader: reader[0])
def test_every_command_takes_the_average_of_the_hips_of_a_log_with_times(
    nao: nk.NaoModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, reader: tuple[str, ...]
) -> None:
    monkeypatch.chdir(tmp_path)
    body = nao.to_body(_q(nao, inside=True))
    body[:, nao.body_order.index("RHipYawPitch")] += 0.02
    rows = np.column_stack([np.divide(TIMES, 5.0), body]).tolist()
    text = "".join(",".join(map(str, row)) + "\n" for row in (("time", *nao.body_order), *rows))
    Path("log.csv").write_text(text)
    printed = []
    for hips in ((), ("--hips", "average"), ("--hips", "left")):
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            assert run([reader[0], "log.csv", *reader[1:], *hips, "--json"]) in (0, 1), hips
        printed.append(out.getvalue())
        if reader[0] == "view":
            printed[-1] = Path("page.html").read_text()
    assert printed[0] == printed[1] != printed[2]


@pytest.mark.parametrize("reader", READERS, ids=lambda reader: reader[0])
@pytest.mark.parametrize("missing", ["Stand", *full("0.25")])
def test_every_command_gives_missing_joints_the_values_of_a_posture_or_a_number(
    nao: nk.NaoModel, refused: Callable[..., str], missing: str, reader: tuple[str, ...]
) -> None:
    command, *more = reader
    values = {"HeadYaw": [0.1, 0.2, np.nan], "LShoulderPitch": [np.nan, 1.0, 1.1]}
    q = nao.configuration(values, missing="Stand" if missing == "Stand" else 0.25)
    header = ",".join(("time", *nao.joint_names))
    table = np.column_stack([np.divide(TIMES, 5.0), q])
    np.savetxt("whole.csv", table, delimiter=",", header=header, comments="", fmt="%.17g")
    Path("part.csv").write_text("time,HeadYaw,LShoulderPitch,LFsr\n0,0.1,,3\n0.1,0.2,1,3\n0.25,NaN,1.1,3\n")
    printed = []
    for words in (("part.csv", "--missing", missing, "--ignore-other"), ("whole.csv", "--ignore-other")):
        out = io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(io.StringIO()):
            assert run([command, *words, *more, "--json"]) in (0, 1), words
        printed.append(Path("page.html").read_text() if command == "view" else out.getvalue())
    assert printed[0] == printed[1]
    said = refused(command, "part.csv", *more, "--ignore-other", "--missing", "Sand")
    assert "unknown posture 'Sand' (nearest: Stand" in said
    said = refused(command, "part.csv", *more, "--missing", "Stand", "--posture", "Stand")
    assert "--posture and --missing exclude each other" in said


@pytest.mark.parametrize("reader", READERS[:3], ids=lambda reader: reader[0])
@pytest.mark.parametrize("name", ["table.csv", "motion.json"])
def test_every_command_accepts_the_noise_of_sensors_by_name(
    nao: nk.NaoModel, refused: Callable[..., str], capsys: Capture, name: str, reader: tuple[str, ...]
) -> None:
    q = np.stack([nao.clamp(nao.posture("Stand"))] * 2)
    for excess, accepted in ((4.9, True), (5.1, False)):
        q[1, 0] = nao.upper[0] + np.radians(excess)
        if name == "table.csv":
            np.savetxt(name, q, delimiter=",", header=",".join(nao.joint_names), comments="", fmt="%.17g")
        else:
            nk.motion.write_motion(nk.Motion([0.0, 1.0], nao.joint_names, q), name, overwrite=True)
        if accepted:
            assert run([reader[0], name, "--limits", "measured"]) in (0, 1)
            text = "1 configuration has joints outside their limits, HeadYaw by 4.9°; accepted as measured"
            assert capsys.readouterr().err == f"nao-kin: {text}\n"
        else:
            assert "HeadYaw" in refused(reader[0], name, "--limits", "measured")
