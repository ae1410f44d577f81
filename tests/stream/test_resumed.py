"""An interrupted run leaves no corrupt file and resumes where it stopped: real processes, signals and full disks."""

from __future__ import annotations

import csv
import fcntl
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pyarrow.csv
import pyarrow.feather
import pyarrow.parquet
import pytest
from forked import Forks, forks
from loops import full
from viewer_pages import PATIENCE, until

import nao_kin as nk
from nao_kin.cli import app, fk
from nao_kin.errors import BadArgument, BadInputFile, StartedOverWarning
from nao_kin.stream import parts, run, sources as csv_source, sources as table_sources

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals")

ENVIRONMENT = {**os.environ, "PYTHONPATH": str(Path(nk.__file__).parent.parent)}
FEET = ("--frame", "LLeg", "--frame", "RLeg")
Command = Callable[..., tuple[int, str, str]]

# The program with parts of a few rows, and something that happens on the way.
_PROGRAM = """
import os, signal, sys, time
from nao_kin.stream import parts, run, sinks, sources
from nao_kin.cli import fk
sinks._FEW_ROWS = 0
sources.BYTES_AT_ONCE, sources.ROWS_AT_ONCE, run._BLOCKS_OF_PART, fk._CHUNK = 20_000, 40, 2, 100
{happening}
from nao_kin.cli import main
main(sys.argv[1:])
"""


_SLOW = """
add = parts.PartFolder.add
parts.PartFolder.add = lambda *arguments: (add(*arguments), time.sleep(0.05))
"""

# The disk is full for files of this many bytes.
_LIMITED = """
import resource
resource.setrlimit(resource.RLIMIT_FSIZE, ({size}, {size}))
"""

# Two parts are finished, and then nothing happens until a signal comes.
_HELD = """
add, finished = parts.PartFolder.add, []
def held(*arguments):
    add(*arguments)
    finished.append(1)
    if len(finished) == 2:
        time.sleep(600)
parts.PartFolder.add = held
"""


@pytest.fixture(autouse=True, scope="module")
def compiled(nao: nk.NaoModel) -> None:
    """Compile the kernels first, because compiling prints a note on standard error."""
    for dtype in (np.float64, np.float32):
        nao.fk(nao.random(0, 10), "Head", dtype=dtype, threads=1)


@pytest.fixture(scope="module")
def programs(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Forks]:
    """A process that has loaded what `nao-kin fk` needs."""
    imports = """
import pyarrow.feather, pyarrow.parquet
import nao_kin as nk
from nao_kin.cli import app
app.run(["fk"])
nao = nk.load_nao()
nao.fk(nao.random(0, 100), threads=1)
"""
    with forks(imports, tmp_path_factory.mktemp("programs")) as programs:
        yield programs


def _program(happening: str) -> str:
    return _PROGRAM.format(happening=happening)


@pytest.fixture(autouse=True)
def small_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(csv_source, "BYTES_AT_ONCE", 20_000)
    monkeypatch.setattr(table_sources, "ROWS_AT_ONCE", 40)
    monkeypatch.setattr(run, "_BLOCKS_OF_PART", 2)


@pytest.fixture
def walk(nao: nk.NaoModel, tmp_path: Path) -> Path:
    """A file of 500 rows, six parts or seven."""
    path = tmp_path / "walk.csv"
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(nao.joint_names)
        writer.writerows(nao.random(0, 500).tolist())
    np.save(tmp_path / "walk.npy", nao.random(0, 500))
    return path


@pytest.fixture
def command(walk: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture) -> Command:
    """Return a function that runs a command in this process, in the folder of the walk."""
    monkeypatch.chdir(walk.parent)
    monkeypatch.setattr("nao_kin.stream.sinks._FEW_ROWS", 0)
    monkeypatch.setattr(fk, "_CHUNK", 100)

    def called(*arguments: str) -> tuple[int, str, str]:
        return app.run(list(arguments)), *capsys.readouterr()

    return called


def _whole(nao: nk.NaoModel, source: Path | list[Path], path: Path) -> bytes:
    """Return the output of a run without interruption."""
    nk.stream.fk(nao, source, path, frame=["LLeg", "RLeg"], as_="rpy", overwrite=True)
    content = path.read_bytes()
    path.unlink()
    return content


def _interrupt(nao: nk.NaoModel, source: Path | list[Path], sink: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """End a run as Ctrl-C ends Python, at the eighth block."""
    work, calls = run._PoseRun.poses, []

    def interrupted(self, *arguments):
        calls.append(1)
        if len(calls) == 8:
            raise KeyboardInterrupt
        return work(self, *arguments)

    with monkeypatch.context() as patched:
        patched.setattr(run._PoseRun, "poses", interrupted)
        with pytest.raises(KeyboardInterrupt):
            nk.stream.fk(nao, source, sink, frame=["LLeg", "RLeg"], as_="rpy")


@pytest.mark.parametrize("number", [signal.SIGINT, *full(signal.SIGTERM, signal.SIGKILL)])
def test_a_signal_leaves_the_finished_parts_and_nothing_else(
    command: Command, nao: nk.NaoModel, programs: Forks, walk: Path, tmp_path: Path, number: signal.Signals
) -> None:
    poses = tmp_path / "poses.csv"
    expected = _whole(nao, walk, poses)
    process = programs.start(_program(_HELD), "fk", "walk.csv", *FEET, "-o", "poses.csv", cwd=tmp_path)
    assert until((tmp_path / "poses.csv.parts" / "part-000001.json").exists)
    os.kill(process, number)
    assert programs.end() == (-number if number == signal.SIGKILL else 128 + number, "", "")
    assert not poses.exists()
    left = {path.name for path in (tmp_path / "poses.csv.parts").iterdir()}
    assert "part-000001.json" in left
    assert number == signal.SIGKILL or "unfinished" not in left
    code, out, err = command("fk", "walk.csv", *FEET, "-o", "poses.csv")
    assert (code, out) == (0, "poses.csv\n")
    assert "rows had been done by an earlier run" in err
    assert poses.read_bytes() == expected
    assert sorted(path.name for path in tmp_path.iterdir()) == ["poses.csv", "walk.csv", "walk.npy"]


def test_ctrl_c_before_the_first_part_leaves_nothing(programs: Forks, walk: Path, tmp_path: Path) -> None:
    happening = "run._BLOCKS_OF_PART = 10**9\nrun._PoseRun.poses = lambda *_: time.sleep(600)\n"
    process = programs.start(_program(happening), "fk", "walk.csv", *FEET, "-o", "poses.csv", cwd=tmp_path)
    assert until((tmp_path / "poses.csv.parts" / "run.json").exists)
    os.kill(process, signal.SIGINT)
    assert programs.end() == (130, "", "")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["walk.csv", "walk.npy"]


def test_an_exception_in_python_leaves_the_finished_parts(
    nao: nk.NaoModel, walk: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    poses = tmp_path / "poses.parquet"
    expected = _whole(nao, walk, poses)
    _interrupt(nao, walk, poses, monkeypatch)
    assert not poses.exists()
    result = nk.stream.fk(nao, walk, poses, frame=["LLeg", "RLeg"], as_="rpy", overwrite=True)
    assert 0 < result.rows_resumed < 500
    assert poses.read_bytes() == expected


@pytest.mark.full
def test_a_full_disk_is_named_and_the_next_run_goes_on(
    nao: nk.NaoModel, programs: Forks, walk: Path, tmp_path: Path
) -> None:
    poses = tmp_path / "poses.csv"
    expected = _whole(nao, walk, poses)
    limited = _program(_LIMITED.format(size=60_000))  # parts fit, the whole file does not
    code, out, err = programs.run(limited, "fk", "walk.csv", *FEET, "-o", "poses.csv", cwd=tmp_path)
    assert (code, out) == (2, "")
    assert err == "nao-kin: cannot write poses.csv: File too large; run it again to resume from row 500\n"
    assert not poses.exists()
    assert not (tmp_path / "poses.csv.parts" / "unfinished").exists()
    assert nk.stream.fk(nao, walk, poses, frame=["LLeg", "RLeg"], as_="rpy").rows_resumed == 500
    assert poses.read_bytes() == expected


@pytest.mark.full
@pytest.mark.parametrize("sink", ["csv", *full("npy", "parquet", "arrow")])
def test_a_disk_that_is_full_at_once_leaves_the_old_file(
    programs: Forks, walk: Path, tmp_path: Path, sink: str
) -> None:
    poses = tmp_path / f"poses.{sink}"
    poses.write_bytes(b"old")
    limited = _program(_LIMITED.format(size=3_000))
    ended = programs.run(limited, "fk", "walk.npy", *FEET, "-o", poses.name, "--force", cwd=tmp_path)
    assert ended == (2, "", f"nao-kin: cannot write {poses.name}: File too large\n")
    assert poses.read_bytes() == b"old"
    assert not list(tmp_path.glob("*.parts"))


def test_a_resumed_run_writes_times_in_the_unit_of_the_whole_file(
    nao: nk.NaoModel, walk: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # A clock in ns passes 100 s, where the size of its times would be that of ms since 1970.
    header, *rows = walk.read_text().splitlines()
    walk.write_text("\n".join([f"time,{header}", *(f"{index * 10**9},{row}" for index, row in enumerate(rows))]))
    poses = tmp_path / "poses.csv"
    expected = _whole(nao, walk, poses)
    _interrupt(nao, walk, poses, monkeypatch)
    result = nk.stream.fk(nao, walk, poses, frame=["LLeg", "RLeg"], as_="rpy", overwrite=True)
    assert 100 < result.rows_resumed < 500
    assert poses.read_bytes() == expected
    assert len(result.notes) == 1


# --- what has changed ---------------------------------------------------------------------------------------------


def test_a_run_over_several_files_goes_on_where_it_was(
    nao: nk.NaoModel, walk: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    files = [walk, walk.with_name("again.csv")]
    files[1].write_bytes(walk.read_bytes())
    poses = tmp_path / "poses.csv"
    whole = _whole(nao, files, poses)
    _interrupt(nao, files, poses, monkeypatch)
    result = nk.stream.fk(nao, files, poses, frame=["LLeg", "RLeg"], as_="rpy")
    assert result.rows_resumed > 0
    assert poses.read_bytes() == whole


@pytest.fixture
def half_done(nao: nk.NaoModel, walk: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of a run that was ended after some parts."""
    _interrupt(nao, walk, walk.with_name("poses.csv"), monkeypatch)
    return walk.with_name("poses.csv.parts")


@pytest.mark.parametrize(
    ("arguments", "changed"),
    [
        ({"frame": ["LLeg"]}, "frames, form"),
        ({"as_": "quaternion"}, "form"),
        ({"reference": "Head"}, "reference"),
        ({"dtype": np.float32}, "dtype"),
        ({"limits": "clamp"}, "limits"),
        ({"on_error": "nan"}, "bad rows"),
        ({"robot": "v3.3"}, "robot"),
        ({"touched": True}, "source"),
        ({"version": True}, "version of nao_kin"),
    ],
)
def test_other_arguments_or_another_source_start_over_and_say_so(
    nao: nk.NaoModel, walk: Path, half_done: Path, monkeypatch: pytest.MonkeyPatch, arguments: dict, changed: str
) -> None:
    poses = walk.with_name("poses.csv")
    if arguments.pop("touched", False):
        os.utime(walk, ns=(1, 1))
    if arguments.pop("version", False):
        monkeypatch.setattr(run, "__version__", "0.0.0")
    robot = nk.load_nao(arguments.pop("robot", "v6"))
    given = {"frame": ["LLeg", "RLeg"], "as_": "rpy"} | arguments
    with pytest.warns(StartedOverWarning) as caught:
        result = nk.stream.fk(robot, walk, sink=poses, **given, overwrite=True)
    message = f"{half_done} holds parts of an earlier run, and {changed} changed: starting over"
    assert [str(warning.message) for warning in caught] == [message]
    assert result.rows_resumed == 0
    content = poses.read_bytes()
    nk.stream.fk(robot, walk, sink=poses, **given, overwrite=True)
    assert poses.read_bytes() == content


def test_a_finished_file_is_replaced_only_by_force_and_a_run_half_done_goes_on(
    command: Command, half_done: Path
) -> None:
    poses = half_done.with_suffix("")
    poses.write_bytes(b"old")
    arguments = ("fk", "walk.csv", *FEET, "-o", "poses.csv")
    code, out, err = command(*arguments)
    assert (code, out) == (0, "poses.csv\n")
    assert "had been done by an earlier run" in err
    finished = poses.read_bytes()
    code, out, err = command(*arguments, "--deg")
    assert (code, out) == (2, "")
    assert err.endswith("; overwrite=True (--force) replaces it\n")
    assert poses.read_bytes() == finished
    assert command(*arguments, "--deg", "--force", "--limits", "ignore")[0] == 0
    assert poses.read_bytes() != finished


@pytest.mark.parametrize(
    "damage",
    [
        *("a flipped bit", "zeros", "an empty record", "a record of a later version", "a wrong count"),
        "truncated",
        *full("no record", "half a record", "a record of another part", "no run", "half a run"),
    ],
)
def test_damaged_parts_are_done_again(nao: nk.NaoModel, walk: Path, half_done: Path, damage: str) -> None:
    poses, part = walk.with_name("poses.csv"), half_done / "part-000001"
    record = half_done / "part-000001.json"
    if damage == "a flipped bit":
        content = bytearray(part.read_bytes())
        content[len(content) // 2] ^= 1
        part.write_bytes(content)
    elif damage == "zeros":
        part.write_bytes(bytes(part.stat().st_size))
    elif damage == "an empty record":
        record.write_text("{}")
    elif damage == "a record of a later version":
        record.write_text(record.read_text().replace('"rows_read"', '"later": 1, "rows_read"'))
    elif damage == "a wrong count":
        last = max(half_done.glob("part-*.json"))
        last.write_text(last.read_text().replace('"rows_read": ', '"rows_read": 1'))
    elif damage == "a record of another part":
        record.write_bytes((half_done / "part-000000.json").read_bytes())
    elif damage == "truncated":
        os.truncate(part, 10)
    elif damage == "no record":
        record.unlink()
    elif damage == "half a record":
        record.write_text('{"end": [1')
    elif damage == "no run":
        for path in half_done.iterdir():
            if path.name not in ("lock", "unfinished"):
                path.unlink()
    else:
        (half_done / "run.json").write_text("{")
    result = nk.stream.fk(nao, walk, poses, frame=["LLeg", "RLeg"], as_="rpy", overwrite=True)
    assert (result.rows_resumed > 0) == (damage not in ("no run", "half a run"))
    content = poses.read_bytes()
    assert content == _whole(nao, walk, poses)


def test_a_source_that_changes_while_it_is_read_is_refused(
    nao: nk.NaoModel, walk: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    add = parts.PartFolder.add
    monkeypatch.setattr(parts.PartFolder, "add", lambda *a: (add(*a), os.utime(walk, ns=(1, time.monotonic_ns()))))
    with pytest.raises(BadInputFile, match=r"walk\.csv: changed while it was read"):
        nk.stream.fk(nao, walk, walk.with_name("poses.csv"), frame="Head")
    assert sorted(path.name for path in walk.parent.iterdir()) == ["walk.csv", "walk.npy"]


def test_two_processes_do_not_write_one_file(nao: nk.NaoModel, walk: Path, half_done: Path) -> None:
    with (half_done / "lock").open("wb") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        with pytest.raises(BadArgument, match=r"poses\.csv: another process is writing it"):
            nk.stream.fk(nao, walk, walk.with_name("poses.csv"), frame=["LLeg", "RLeg"], as_="rpy")
    assert (half_done / "part-000001.json").exists()


@pytest.mark.parametrize("folder", [True, False])
def test_what_is_not_ours_is_not_touched(nao: nk.NaoModel, walk: Path, folder: bool) -> None:
    theirs = walk.with_name("poses.csv.parts")
    if folder:
        theirs.mkdir()
        (theirs / "part-1").write_text("theirs")
    else:
        theirs.write_text("theirs")
    with pytest.raises(BadArgument, match="poses.csv"):
        nk.stream.fk(nao, walk, walk.with_name("poses.csv"), frame="Head")
    assert (theirs / "part-1" if folder else theirs).read_text() == "theirs"
    assert not walk.with_name("poses.csv").exists()


# --- where it is written ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["pipe", *full("pipe.csv", "pipe.parquet")])
def test_a_pipe_gets_the_whole_file(nao: nk.NaoModel, walk: Path, tmp_path: Path, name: str) -> None:
    pipe, received = tmp_path / name, []
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: received.append(pipe.read_bytes()), daemon=True)
    reader.start()
    nk.stream.fk(nao, walk, pipe, frame="Head")
    reader.join(10.0)
    nk.stream.fk(nao, walk, tmp_path / f"x{pipe.suffix or '.csv'}", frame="Head")
    assert received == [(tmp_path / f"x{pipe.suffix or '.csv'}").read_bytes()]
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted(
        ["walk.csv", "walk.npy", name, f"x{pipe.suffix or '.csv'}"]
    )


@pytest.mark.full
@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="needs /proc")
def test_standard_input_and_output_are_files_too(
    command: Command, nao: nk.NaoModel, walk: Path, tmp_path: Path
) -> None:
    expected = _whole(nao, walk, tmp_path / "poses.csv")
    program = [sys.executable, "-c", _program(""), "fk", "-", *FEET, "-o", "/dev/stdout"]
    with walk.open("rb") as file:
        done = subprocess.run(program, stdin=file, capture_output=True, env=ENVIRONMENT, cwd=tmp_path, check=True)
    assert (done.stdout, done.stderr) == (expected, b"")
    code, _, err = command(*program[3:], "--json")
    assert code == 2
    assert "both write to standard output" in err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["walk.csv", "walk.npy"]


# --- the command line ---------------------------------------------------------------------------------------------


@pytest.mark.full
def test_the_file_is_what_is_printed(command: Command, tmp_path: Path) -> None:
    code, printed, _ = command("fk", "walk.csv", *FEET, "--csv", "--deg", "--limits", "ignore")
    assert code == 0
    code, out, err = command("fk", "walk.csv", *FEET, "-o", "poses.csv", "--deg", "--limits", "ignore", "--json")
    assert (code, err) == (0, "")
    assert (tmp_path / "poses.csv").read_text() == printed
    assert json.loads(out) == {
        "sink": "poses.csv",
        "frames": ["LLeg", "RLeg"],
        "columns": ["x", "y", "z", "roll_deg", "pitch_deg", "yaw_deg"],
        "rows_read": 500,
        "rows_written": 500,
        "rows_resumed": 0,
        "bad_rows": 0,
        "first_bad_rows": [],
        "clamped": {"rows": 0, "largest": 0.0, "joint": "", "joints": {}},
        "notes": [],
    }


@pytest.mark.full
@pytest.mark.parametrize(("policy", "done"), [("skip", "left out"), ("nan", "written as nan")])
def test_bad_rows_are_reported_on_standard_error(
    command: Command, walk: Path, tmp_path: Path, policy: str, done: str
) -> None:
    lines = walk.read_text().splitlines()
    for row in range(100, 130):
        lines[row + 1] = "x" + lines[row + 1]
    walk.write_text("\n".join(lines))
    arguments = ("fk", "walk.csv", *FEET, "-o", "poses.parquet", "--on-error", policy, "--dtype", "float32")
    code, out, err = command(*arguments)
    assert (code, out) == (0, "poses.parquet\n")
    first, second, *_, last = err.splitlines()
    assert first == f"nao-kin: 30 bad rows of 500 {done}:"
    assert second.startswith("nao-kin: line 102, column 1: HeadYaw is 'x")
    assert last == "nao-kin: and 10 more"
    assert len(err.splitlines()) == 22
    table = pyarrow.parquet.read_table(tmp_path / "poses.parquet")
    assert table.num_rows == 2 * (470 if policy == "skip" else 500)
    assert str(table.schema.field("yaw").type) == "float"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("walk.csv", "-o", "x.csv", "--csv"), "--csv and --output exclude each other"),
        (("-o", "x.csv"), "--output needs FILE"),
        (("--posture", "Stand", "-o", "x.csv"), "--output needs FILE"),
        (("walk.csv", "--on-error", "skip"), "--on-error needs --output"),
        (("walk.csv", "--dtype", "float32"), "--dtype needs --output"),
        (("walk.csv", "-o", ""), "--output is empty"),
        (("walk.csv", "-o", "x.csv", "-o", "y.csv"), "--output is given twice"),
        (("walk.csv", "-o", "x.csv", "--on-error", "ignore"), "--on-error 'ignore': expected one of"),
        (("walk.json", "-o", "x.csv"), "JSON is read whole"),
    ],
)
def test_what_contradicts_is_refused_in_one_line(
    walk: Path, capsys: pytest.CaptureFixture, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], message: str
) -> None:
    from nao_kin.cli.app import run as program

    monkeypatch.chdir(walk.parent)
    assert program(["fk", *arguments]) == 2
    printed = capsys.readouterr()
    assert message in printed.err
    assert (printed.out, printed.err.count("\n")) == ("", 1)
    assert sorted(path.name for path in walk.parent.iterdir()) == ["walk.csv", "walk.npy"]


@pytest.mark.full
def test_a_terminal_shows_rows_rate_and_time_left(walk: Path, tmp_path: Path) -> None:
    import pty

    ours, theirs = pty.openpty()
    happening = _SLOW.replace("0.05", "0.3")
    env = {"TERM": "xterm", "COLUMNS": "120"}
    command = [sys.executable, "-c", _program(happening), "fk", "walk.csv", *FEET, "-o", "poses.csv"]
    process = subprocess.Popen(
        command, cwd=tmp_path, env={**ENVIRONMENT, **env}, stdout=subprocess.DEVNULL, stderr=theirs
    )
    os.close(theirs)
    printed = b""
    try:
        while data := os.read(ours, 4096):
            printed += data
    except OSError:  # how Linux reports the end of a terminal
        pass
    finally:
        os.close(ours)
    assert process.wait(PATIENCE) == 0
    assert b"forward kinematics" in printed
    assert b" rows, " in printed
    assert b"/s" in printed
    assert b"0:00:0" in printed


_PEAK = """
import resource
import numpy as np
import nao_kin as nk
from nao_kin.stream import (sinks)
sinks._ROWS_OF_GROUP = 10_000
nao = nk.load_nao("v6")
for rows in (30_000, 150_000):
    with open("q.npy", "wb") as file:
        np.lib.format.write_array_header_1_0(file, {"descr": "<f8", "fortran_order": False, "shape": (rows, 25)})
        for _ in range(rows // 1000):
            file.write(bytes(25 * 8 * 1000))
    nk.stream.fk(nao, "q.npy", "poses.csv", frame="LLeg", limits="ignore", overwrite=True)
    nk.stream.fk(nao, "q.npy", "poses.parquet", frame="LLeg", limits="ignore", overwrite=True)
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
"""


@pytest.mark.full
def test_memory_does_not_grow_with_the_rows(tmp_path: Path) -> None:
    command = [sys.executable, "-c", _PEAK]
    done = subprocess.run(command, cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True, check=True)
    few, many = map(float, done.stdout.split())
    assert many - few < 9.0  # MB; there are 24 more to read, and 16 more to write
