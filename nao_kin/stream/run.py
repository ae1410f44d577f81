"""Forward kinematics from file to file."""

from __future__ import annotations

import hashlib
import os
import stat
import sys
import time
import warnings
from collections import deque
from collections.abc import Generator, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import closing, nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO, Literal, get_args

import numpy as np
from numpy.typing import DTypeLike, NDArray

from nao_kin._core import __version__, files as atomic
from nao_kin._core.arrays import Floats, choice, float_dtype
from nao_kin._core.headings import time_unit_of
from nao_kin._core.process import usable_cores
from nao_kin._core.text import abbreviated, quoted
from nao_kin._core.warn import warn_caller
from nao_kin.errors import BadArgument, BadInputFile, DegreesWarning, StartedOverWarning
from nao_kin.robot import Hips, LimitPolicy, RobotModel, check_hips, check_robot
from nao_kin.stream.parts import PartFolder, Progress
from nao_kin.stream.results import MOST_LISTED, BadRow, StreamResult
from nao_kin.stream.sinks import PoseColumns, PoseStyle, Sink, sink_class
from nao_kin.stream.sources import Block, Configurations, Source, found_files, open_source
from nao_kin.stream.tables import JointColumns, TableOptions, times_in_seconds

# --- How far a long run has come, for whoever sits in front of it: rows, rate, and the time that is left.


class ProgressBar:
    """A bar on standard error, when it is wanted and standard error is a terminal; otherwise nothing.

    A context manager: the bar disappears at its end.
    """

    def __init__(self, wanted: bool) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

        console = Console(file=sys.stderr)
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TaskProgressColumn(),
            TextColumn("{task.fields[rows]}"),
            TimeRemainingColumn(),
            console=console,
            disable=not (wanted and console.is_terminal),
            transient=True,
        )
        self._task = self._bar.add_task("forward kinematics", total=None, rows="")
        self._first, self._start = 0, time.monotonic()

    def start(self, rows: int, fraction: float | None) -> None:
        """Begin behind `rows` that an earlier run has done."""
        self._first, self._start = rows, time.monotonic()
        self._bar.update(self._task, total=None if fraction is None else 1.0, completed=fraction or 0.0)

    def show(self, rows: int, fraction: float | None) -> None:
        """So many rows are done, which is this much of the source, if that is known."""
        if self._bar.disable:
            return
        rate = (rows - self._first) / max(1e-9, time.monotonic() - self._start)
        self._bar.update(self._task, completed=fraction or 0.0, rows=f"{rows:,} rows, {rate:,.0f}/s")

    def joining(self) -> None:
        """All rows are done; the parts are being joined."""
        self._bar.update(self._task, description="joining the parts", total=None)

    def __enter__(self) -> ProgressBar:
        self._bar.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._bar.stop()


# --- Forward kinematics from file to file.

ErrorPolicy = Literal["stop", "skip", "nan"]

# A kill costs no more than the work on so many blocks.
_BLOCKS_OF_PART = 4
# Read while the kernels are loaded, and while one is worked on.
_BLOCKS_AHEAD = 3
# Entries of the homogeneous matrices that are computed at once.
_MOST_ENTRIES = 1 << 21
_TURN = 2.0 * np.pi

_Poses = tuple[NDArray[np.int64], Floats, Floats | None]


def fk(
    robot: RobotModel,
    source: Path | str | Sequence[Path | str] | Configurations,
    frames: str | Sequence[str] | None,
    sink: Path | str,
    *,
    reference: str | None = None,
    as_: PoseStyle = "matrix",
    dtype: DTypeLike = np.float64,
    limits: LimitPolicy = "raise",
    degrees: bool = False,
    on_error: ErrorPolicy = "stop",
    columns: Mapping[str, str | None] | None = None,
    ignore_other: bool = False,
    hips: Hips | None = None,
    progress: bool = False,
) -> StreamResult:
    """Poses of frames for every row of a file, however large, written to a file.

    The endings of the names say what the files are. A source is CSV (.csv; also without an ending, and "-" for standard
    input), packed CSV (.csv.gz), a NumPy array of configurations (N, nq) (.npy), Parquet (.parquet) or Arrow IPC
    (.arrow, .feather); tables have one column per joint, in any order, and may have one of times: numbers, stamps of
    Arrow, or in CSV dates and times of ISO 8601, which are seconds from the first row of the first file. A sink is CSV,
    Parquet or Arrow with one record for each row and frame (the row, counted from 0, its time [s] if the source has
    times, the frame's name, and the numbers of the pose), or a NumPy array of shape (N, frames, 4, 4), or
    (N, frames, 7 or 6); without the axis of frames for one name that is no list.

    Memory stays the same whatever the size of the files. The sink appears, or is replaced, when it is complete. Until
    then finished parts stand in a folder beside it, "….parts"; when a run has been ended by a signal, an exception or a
    full disk, the next one with the same source and arguments goes on behind them, and the result is the same. When
    the source or an argument has changed, it starts over and warns. Bad input leaves no parts.

    Args:
        robot: whose joints the source names.
        source: the file of configurations; several, or a pattern such as `logs/*.csv`, whose rows are counted on; or
            `Configurations` in memory.
        frames: a frame name, several, or None for all links, as in `RobotModel.fk`.
        sink: the file of poses, or "-" for CSV on standard output. A device or a pipe is written to when all is done.
        reference: the frame to express the poses in, as in `RobotModel.fk`.
        as_: the numbers of a pose: "matrix", the 16 entries of the homogeneous matrix, t11 … t44 row by row;
            "position_quaternion", x, y, z, r0, r1, r2, r3, scalar first; "position6d", x, y, z, wx, wy, wz with
            R = Rz(wz) Ry(wy) Rx(wx); or "rpy", the same numbers as x, y, z, roll, pitch, yaw.
        dtype: float64, or float32 for half the size.
        limits: "raise" makes a row with a joint outside its limits a bad one; "clamp" moves it to the limit; "ignore"
            takes it as it is.
        degrees: turning joints of a source file are in degrees where it does not say their unit, and so are the angles
            of the sink.
        on_error: what to do with a row from which no configuration can be made: "stop" raises, "skip" leaves it out,
            "nan" writes poses of NaN.
        columns: what to read columns as that have other names, as in `read_log`.
        ignore_other: leave out columns that name no joint and no time.
        hips: how to settle two joints of one motor whose values differ, as in `read_log`.
        progress: show a bar with rate and time left on standard error, if it is a terminal.

    Returns:
        What was read and written, and the first bad rows with their lines.

    Raises:
        BadInputFile: the source cannot be read, or has changed meanwhile; with on_error="stop", the first bad row.
        BadArgument: the sink cannot be written; contradictory files; no such dtype.
        UnknownName: no such frame, form of a pose or policy.
        MissingExtra: the files need pyarrow, and it is not installed.

    Examples:
        >>> from pathlib import Path
        >>> nao = nk.load_nao()
        >>> lines = nao.joint_names, map(str, nao.posture("Stand"))
        >>> _ = Path("q.csv").write_text(chr(10).join(map(",".join, lines)))
        >>> _ = nk.stream.fk(nao, "q.csv", ["LArm", "RArm"], "poses.npy")
        >>> np.load("poses.npy").shape
        (1, 2, 4, 4)
    """
    check_robot(robot)
    files = source if isinstance(source, Configurations) else _paths(source)
    sink = _path(sink, "sink")
    sink = "/dev/stdout" if sink == "-" else sink
    if hips is not None:
        check_hips(hips)
    choice(on_error, get_args(ErrorPolicy), "policy for bad rows")
    names = robot.link_names if frames is None else (frames,) if isinstance(frames, str) else tuple(frames)
    if not names:
        raise BadArgument("no frames; expected at least one name, or None for all links")
    numbers = PoseColumns(as_, degrees)
    kind = float_dtype(dtype)
    atomic.check_writable(sink)
    shape = numbers.shape if isinstance(frames, str) else (len(names), *numbers.shape)
    sink_kind = sink_class(sink)
    # Names the frame that does not exist, before anything is read.
    robot.frame_ids(names if reference is None else (*names, reference))
    if not isinstance(files, Configurations):
        _check_apart(files, sink)
    with closing(open_source(files, robot, TableOptions(degrees, columns, ignore_other))) as opened:
        joints = [JointColumns(robot, file.table, limits, hips, file.whole) for file in opened.files]
        writer = sink_kind(names, numbers.names, shape, kind, opened.table.timed)
        work = _Work(robot, opened, joints, names, reference, numbers, writer, on_error)
        arguments = {
            "frames": list(names),
            "reference": reference,
            "form": [as_, list(shape)],
            "dtype": str(kind),
            "limits": limits,
            "degrees": degrees,
            "bad rows": on_error,
            "columns": None if columns is None else dict(columns),
            "other columns": ignore_other,
            "hips": hips,
            "format": type(writer).__name__,
        }
        identity = _identity(files)
        run = None if identity is None else {**_provenance(robot), "source": identity, **arguments}
        return _to_sink(work, files, sink, run, progress)


@dataclass
class _Work:
    """What is done with every block.

    Attributes:
        joints: what the columns of each file of the source stand for.
        warned: a warning of degrees was given; one is enough, and that of every block would have another number in it.
        notes: what was understood of the source that it does not say.
    """

    robot: RobotModel
    source: Source
    joints: Sequence[JointColumns]
    frames: tuple[str, ...]
    reference: str | None
    columns: PoseColumns
    sink: Sink
    on_error: str
    warned: bool = False
    notes: list[str] = field(default_factory=list)
    _time_units: dict[int, str] = field(default_factory=dict)

    def poses(self, block: Block, before: Progress) -> tuple[_Poses, Progress]:
        """Rows (n,), numbers (n, frames, k) and times (n,) of a block's poses, and how far the run has then come."""
        joints = self.joints[block.file]
        values = block.values
        if block.times is not None and not np.isfinite(block.times).all():
            values = np.where(np.isfinite(block.times)[:, None], values, np.nan)
        q, good, clamped = joints.configurations(values)
        times = self._seconds(block)
        # Of a file of several blocks, the kernels answer every row: the same bits wherever a run began. For a file
        # that is one block, loading them need not pay.
        alone = block.last and not before.rows_read
        numbers = self._numbers(q, None if alone else usable_cores())
        rows = before.rows_read + np.arange(len(good))
        bad = np.flatnonzero(~good)
        listed = before.first_bad_rows
        if len(bad):
            listed += self._bad_rows(block, bad[: MOST_LISTED - len(listed)], before.rows_read)
            if self.on_error == "stop":
                advice = "" if int(bad[0]) in block.problems else joints.advice(block.values[bad[0]])
                first = listed[0]
                reason = f"{'' if first.line else f'row {first.row}: '}{first.reason}{advice}"
                raise BadInputFile(self.source.files[block.file].path, reason, first.line, first.column)
            if self.on_error == "skip":
                rows = rows[good]
                times = None if times is None else times[good]
            else:
                all_numbers = np.full((len(good), *numbers.shape[1:]), np.nan, numbers.dtype)
                all_numbers[good] = numbers
                numbers = all_numbers
        after = Progress(
            block.end,
            before.rows_read + len(good),
            before.rows_written + len(rows),
            before.bad_rows + len(bad),
            listed,
            before.clamped.and_then(clamped),
        )
        return (rows, numbers, times), after

    def _seconds(self, block: Block) -> Floats | None:
        """The times of a block [s]."""
        if block.times is None:
            return None
        unit = self.joints[block.file].table.time_unit or self._time_units.get(block.file)
        times, note = times_in_seconds(block.times, unit)
        if unit is None:
            # The first block tells, and all that follow are read alike.
            self._time_units[block.file] = time_unit_of(block.times)
            self.notes += [note] if note and note not in self.notes else []
        return times

    def _numbers(self, q: Floats, threads: int | None) -> Floats:
        """The numbers of the poses, shape (n, frames, k)."""
        numbers = np.empty((len(q), len(self.frames), len(self.columns.names)), self.sink.dtype)
        step = max(1, _MOST_ENTRIES // (16 * len(self.frames)))
        with warnings.catch_warnings() if self.warned else nullcontext():
            if self.warned:
                warnings.simplefilter("ignore", DegreesWarning)
            for start in range(0, len(q), step):
                rows = q[start : start + step]
                poses = self.columns.poses(self.robot, rows, self.frames, self.reference, self.sink.dtype, threads)
                numbers[start : start + step] = poses
        self.warned = self.warned or float(np.abs(q).max(initial=0.0)) > _TURN
        return numbers

    def _bad_rows(self, block: Block, bad: NDArray[np.intp], before: int) -> tuple[BadRow, ...]:
        joints, found = self.joints[block.file], []
        file = self.source.files[block.file].path if len(self.source.files) > 1 else ""
        for row in bad.tolist():
            if row in block.problems:
                column, reason = block.problems[row]
            elif block.times is not None and not np.isfinite(block.times[row]):
                column, reason = 0, f"time is {float(block.times[row])}, expected a finite number"
            else:
                column, reason = joints.problem(block.values[row])
                column = joints.table.places[column] + 1 if column >= 0 and not joints.whole else 0
            line = 0 if block.lines is None else block.lines[row]
            found.append(BadRow(before + row, line, column if line else 0, reason, file))
        return tuple(found)


def _to_sink(
    work: _Work, source: Sequence[str] | Configurations, sink: str, run: dict[str, Any] | None, progress: bool
) -> StreamResult:
    folder = None
    try:
        folder = PartFolder(atomic.replaced_file(sink))
        changed = folder.resume(run)
        if changed:
            warn_caller(
                f"{abbreviated(folder.path)} holds parts of an earlier run, and {changed} changed: starting over",
                StartedOverWarning,
            )
        resumed = folder.last.rows_read if folder.last else 0
        with ProgressBar(progress) as bar:
            done = _write_parts(work, folder, bar)
            now = _identity(source)
            if run is not None and now != run["source"]:
                folder.kept = False
                changed = next(file["path"] for file in run["source"] if file not in (now or ()))
                raise BadInputFile(str(changed), "changed while it was read")
            bar.joining()
            with folder.unfinished.open("wb") as file:
                work.sink.join(folder.parts, file, done.rows_written)
        atomic.move_into_place(folder.unfinished, sink)
        folder.kept = False
    except BadInputFile as error:
        # What could not be read this time may be read the next time; what is wrong stays wrong.
        if folder is not None and not isinstance(error.__cause__, OSError):
            folder.kept = False
        raise
    except BrokenPipeError:
        raise  # whoever read the pipe has seen enough
    except OSError as error:
        advice = ""
        if folder is not None and folder.kept and folder.last is not None:
            advice = f"; run the same again to go on from row {folder.last.rows_read}"
        raise BadArgument(f"cannot write {abbreviated(sink)}: {error.strerror or error}{advice}") from None
    finally:
        if folder is not None:
            folder.close()
    return StreamResult(
        sink,
        work.frames,
        work.columns.names,
        done.rows_read,
        done.rows_written,
        resumed,
        done.bad_rows,
        done.first_bad_rows,
        done.clamped,
        tuple(work.notes),
    )


def _write_parts(work: _Work, folder: PartFolder, bar: ProgressBar) -> Progress:
    """Work through the source from where the finished parts end."""
    done = folder.last or Progress(work.source.start)
    bar.start(done.rows_read, work.source.fraction(done.end))
    parts = _PartWriter(work.sink, folder)
    # Numbers become text, and go to the disk, while the next block is worked on.
    with closing(parts), ThreadPoolExecutor(1, "nao_kin-writer") as writer:
        writing: Future[None] | None = None
        with closing(_read_ahead(work.source.blocks(done.end), work.source.path)) as source:
            for block in source:
                poses, done = work.poses(block, done)
                if writing is not None:
                    writing.result()
                writing = writer.submit(parts.write, poses, done)
                bar.show(done.rows_read, work.source.fraction(done.end))
        if writing is not None:
            writing.result()
        parts.finish()
    return done


class _PartWriter:
    """Blocks to parts, in turn."""

    def __init__(self, sink: Sink, folder: PartFolder) -> None:
        self._sink, self._folder = sink, folder
        self._file: BinaryIO | None = None
        self._blocks = 0
        self._done: Progress | None = None

    def write(self, poses: _Poses, done: Progress) -> None:
        """Append a block, with which the run has come so far; the part is finished when it has blocks enough."""
        with self._folder.busy:
            self._file = self._file or self._folder.unfinished.open("wb")
            self._sink.write(self._file, *poses)
            self._blocks += 1
            self._done = done
            if self._blocks == _BLOCKS_OF_PART:
                self.finish()

    def finish(self) -> None:
        """Finish the part that is begun, if one is."""
        if self._file is not None and self._done is not None:
            self._folder.add(self._file, self._done)
            self._file, self._blocks = None, 0

    def close(self) -> None:
        """Write no more."""
        if self._file is not None:
            self._file.close()


def _read_ahead(blocks: Iterator[Block], path: str) -> Generator[Block, None, None]:
    """The same blocks; the next ones are read while one is worked on."""
    with ThreadPoolExecutor(1, "nao_kin-reader") as reader:
        following = deque(reader.submit(next, blocks, None) for _ in range(_BLOCKS_AHEAD))
        try:
            while (block := following.popleft().result()) is not None:
                following.append(reader.submit(next, blocks, None))
                yield block
        except OSError as error:
            raise BadInputFile(path, f"cannot be read: {error.strerror or error}") from error
        finally:
            reader.shutdown(cancel_futures=True)


def _identity(source: Sequence[str] | Configurations) -> list[dict[str, Any]] | None:
    """What tells files from others and from themselves after a change; None for what is no file and read once."""
    if isinstance(source, Configurations):
        return None
    found = []
    for path in source:
        try:
            state = None if path == "-" else os.stat(path)
        except OSError:
            found.append({"path": os.path.realpath(path), "gone": True})
            continue
        if state is None or not stat.S_ISREG(state.st_mode):
            return None
        found.append({"path": os.path.realpath(path), "size": state.st_size, "modified": state.st_mtime_ns})
    return found


def _provenance(robot: RobotModel) -> dict[str, Any]:
    """What else the poses depend on: the robot, by its joints, limits and some poses, and the version."""
    digest = hashlib.sha256()
    sample = np.stack([robot.neutral(), *robot.random(0, 2)])
    for array in (robot.lower, robot.upper, robot.fk(sample)):
        digest.update(array.tobytes())
    digest.update(repr((robot.base, robot.joint_names, robot.joint_units, sorted(robot.mimics.items()))).encode())
    digest.update(repr(robot.coupled_limits).encode())
    return {"version of nao_kin": __version__, "robot": digest.hexdigest()}


def _check_apart(sources: Sequence[str], sink: str) -> None:
    for source in sources:
        if source != "-" and os.path.exists(source) and os.path.exists(sink) and os.path.samefile(source, sink):
            raise BadArgument(f"{abbreviated(sink)} is the source too; the poses need another file")


def _paths(source: Path | str | Sequence[Path | str]) -> list[str]:
    """The files of a name, a pattern, or several of them."""
    several = [source] if isinstance(source, (str, os.PathLike)) or not isinstance(source, Sequence) else source
    if not several:
        raise BadArgument("no source; expected at least one file")
    return [file for one in several for file in found_files(_path(one, "source"))]


def _path(path: Path | str, what: str) -> str:
    if not isinstance(path, (str, os.PathLike)) or not os.fspath(path):
        raise BadArgument(f"{what} must be the name of a file, got {quoted(path)}")
    return str(path)
