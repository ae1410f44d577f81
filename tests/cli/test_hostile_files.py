"""Small files that state huge or nonsensical contents: each is one line and exit code 2, in little memory and time."""

from __future__ import annotations

import io
import json
import os
import struct
import subprocess
import sys
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import Capture

from nao_kin.cli.app import run

ROOT = Path(__file__).resolve().parents[2]
# Address space of the process that reads all files, and the time for each: importing the libraries takes most of both.
MEMORY, SECONDS = 4 << 30, 10

_RUN = """
import contextlib, io, json, resource, signal, sys
resource.setrlimit(resource.RLIMIT_AS, ({memory}, {memory}))
from nao_kin.cli.app import run
def late(*_):
    raise SystemExit("too late")  # is no error of the library
for words in json.load(sys.stdin):
    signal.signal(signal.SIGALRM, late)
    signal.alarm({seconds})
    said = io.StringIO()
    try:
        with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
            code = run(words)
    except BaseException as error:
        code = repr(error)
    signal.alarm(0)
    print(json.dumps([code, said.getvalue()]), flush=True)
"""


def png(width: int, height: int) -> bytes:
    """A black and white picture; if it is large, only its first row."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = zlib.compress(bytes(1 + (width + 7) // 8) * (height if width * height < 1 << 24 else 1))
    head = struct.pack(">IIBBBBB", width, height, 1, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", rows) + chunk(b"IEND", b"")


def npy(shape: tuple[int, ...], kind: str = "<f8", data: bytes = b"") -> bytes:
    """An array with a header that states more than follows."""
    file = io.BytesIO()
    np.lib.format.write_array_header_1_0(file, {"descr": kind, "fortran_order": False, "shape": shape})
    return file.getvalue() + data


def npz(parts: dict[str, bytes]) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in parts.items():
            archive.writestr(f"{name}.npy", data)
    return file.getvalue()


def motion_npz(**parts: bytes) -> bytes:
    def whole(array: Any) -> bytes:
        file = io.BytesIO()
        np.lib.format.write_array(file, np.array(array))
        return file.getvalue()

    known = {"joint_names": ["HeadYaw"], "counts": [2], "times": [0.0, 1.0], "keys": [0.0, 0.1]}
    return npz({**{name: whole(array) for name, array in known.items()}, "interpolation": whole("linear"), **parts})


def keys(times: list[float]) -> bytes:
    document = {"joint_names": ["HeadYaw"], "times": times, "keys": [[0.0] for _ in times]}
    return json.dumps(document).encode()


_LAUGHS = "".join(f'<!ENTITY l{k} "{f"&l{k - 1};" * 10}">' for k in range(1, 12))
_BOMB = f'<!DOCTYPE r [<!ENTITY l0 "ha">{_LAUGHS}]>'
_LOG = b"time [s],HeadYaw\n0.4,0\n0.6,0.1\n"

# Name → the content of the file, or how to make it, and the words of the command, in which {} is the file.
HOSTILE: dict[str, tuple[str, bytes | Callable[[], bytes], str]] = {
    "11 days between two rows": ("m.csv", b"time,HeadYaw\n0,0\n1000000,0.5\n", "motion check {} --balance"),
    "30 000 years": ("m.csv", b"time [s],HeadYaw\n0,0\n1e12,0.5\n", "motion check {} --balance"),
    "no stamp in the first row": (
        "m.csv",
        b"time,HeadYaw\n0,0\n" + b"".join(b"%.2f,0.1\n" % (1.7e9 + 0.02 * k) for k in range(20)),
        "motion check {} --balance",
    ),
    "JSON of 11 days": ("m.json", keys([0.0, 1e6]), "motion check {} --balance"),
    "Webots of 19 years": ("m.motion", b"#WEBOTS_MOTION,V1.0,HeadYaw\n0:0:0,a,0\n9999999:0:0,b,1\n", "motion info {}"),
    "JSON nested 100 000 deep": ("m.json", b'{"joint_names":' + b"[" * 100_000, "motion info {}"),
    "a number of 10 000 digits": (
        "m.json",
        b'{"joint_names":["HeadYaw"],"times":[' + b"9" * 10_000 + b"]}",
        "motion info {}",
    ),
    "entities in a .xar": (
        "m.xar",
        f"<?xml version='1.0'?>{_BOMB}<ChoregrapheProject>&l11;</ChoregrapheProject>".encode(),
        "motion info {}",
    ),
    "an .npz of 134 million keys": (
        "m.npz",
        lambda: motion_npz(keys=npy((1 << 27,), "|i1", bytes(1 << 27))),
        "motion info {}",
    ),
    "an .npz that states 8 TB": ("m.npz", motion_npz(keys=npy((1 << 40,))), "motion info {}"),
    "an .npz of nothing": ("m.npz", motion_npz(joint_names=npy((1 << 40,), "<U0")), "motion info {}"),
    "targets that state 8 TB": ("t.npy", npy((1 << 40, 3)), "ik LArm {}"),
    "targets of a negative shape": ("t.npy", npy((-1, -3), data=bytes(24)), "ik LArm {}"),
    "configurations that state 8 TB": ("q.npy", npy((1 << 37, 25)), "fk {} -o {}.out.npy --frame Head"),
    "a map that states 8 TB": ("map.npz", npz({"format": npy((1 << 41,), "<U1")}), "reach LArm --samples 10 -o {}"),
    "a heading of 20 000 blanks": (
        "l.csv",
        b"a" + b" " * 20_000 + b"b,HeadYaw\n0,0\n",
        "fk {} --frame Head --ignore-other",
    ),
    "a heading of 100 000 letters, of a skeleton": (
        "l.csv",
        b"a" + b"_" * 100_000 + b"b,time\n0,0\n",
        "imitate {} -o {}.out.json",
    ),
    "a heading of 20 000 brackets, of a motion": ("l.csv", b"time," + b"[" * 20_000 + b"\n0,0\n", "motion info {}"),
    "headings of targets": ("t.csv", b"x,y," + b" " * 20_000 + b"z\n0,0,0\n", "ik LArm {}"),
    "a photo of 1.6 gigapixels": ("top_0.500.png", png(40_000, 40_000), "calibrate"),
    "a photo of 1 000 000 × 1": ("top_0.500.png", png(1_000_000, 1), "calibrate"),
    "an empty photo": ("top_0.500.png", b"", "calibrate"),
    "a pipe among photos": ("top_0.500.png", b"|", "calibrate"),
    "offsets nested 10 000 deep": ("o.toml", b"a = " + b"[" * 10_000, "info --offsets {}"),
    "entities in a URDF": (
        "r.urdf",
        f"<?xml version='1.0'?>{_BOMB}<robot name='a'>&l11;</robot>".encode(),
        "info --urdf {}",
    ),
    "a table of Parquet cut off": (
        "q.parquet",
        b"PAR1" + bytes(100) + b"\xff\xff\xff\x7fPAR1",
        "fk {} --frame Head -o {}.out.csv",
    ),
}


def _words(folder: Path, name: str, content: bytes | Callable[[], bytes], command: str) -> list[str]:
    """Write the file, and return the words of the command."""
    folder.mkdir()
    file = folder / name
    os.mkfifo(file) if content == b"|" else file.write_bytes(content if isinstance(content, bytes) else content())
    if command != "calibrate":
        return [word.replace("{}", str(file)) for word in command.split()]
    log = folder / "head.csv"
    log.write_bytes(_LOG)
    options = ["--photos", str(folder), "--log", str(log), "--board", "9x6", "--square", "0.03"]
    return ["calibrate", *options, "--missing", "StandInit"]


@pytest.fixture(scope="module")
def answers(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Any, str]]:
    """The exit code and the error of each command, from one process with little memory."""
    folder = tmp_path_factory.mktemp("hostile")
    words = [_words(folder / str(number), *case) for number, case in enumerate(HOSTILE.values())]
    program = [sys.executable, "-c", _RUN.format(memory=MEMORY, seconds=SECONDS)]
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    given = {"input": json.dumps(words), "env": env, "cwd": folder, "timeout": 300}
    done = subprocess.run(program, capture_output=True, text=True, **given)
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    unknown = [None, f"the process ended: {done.stderr[-500:]}"]
    return dict(zip(HOSTILE, [*lines, *[unknown] * (len(words) - len(lines))], strict=True))


@pytest.mark.parametrize("case", HOSTILE)
def test_a_hostile_file_is_one_line(answers: dict[str, tuple[Any, str]], case: str) -> None:
    if HOSTILE[case][2] == "calibrate":
        pytest.importorskip("cv2", reason="OpenCV is not installed")
    code, said = answers[case]
    *notes, message = said.splitlines()
    assert code == 2, said[-500:]
    assert message.startswith("nao-kin: ")
    assert len(message) < 500
    assert len(notes) <= 1
    assert all("taken as" in note for note in notes)
    assert HOSTILE[case][0].partition(".")[0] in message


@pytest.mark.parametrize("error", [MemoryError(), np.zeros], ids=["bare", "of NumPy"])
def test_too_little_memory_is_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: Capture, error: MemoryError | Callable[..., Any]
) -> None:
    def load(*_: object, **__: object) -> None:
        if isinstance(error, MemoryError):
            raise error
        error(1 << 50)

    monkeypatch.setattr("nao_kin.robot.load_nao", load)
    assert run(["info"]) == 2
    assert capsys.readouterr().err.startswith("nao-kin: not enough memory")
