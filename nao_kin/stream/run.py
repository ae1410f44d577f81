"""Forward kinematics from file to file."""

from __future__ import annotations

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
from typing import Any, BinaryIO, Literal, get_args

import numpy as np
from numpy.typing import DTypeLike, NDArray

from nao_kin._core import __version__, files as atomic
from nao_kin._core.arrays import Floats, LimitPolicy, choice, flag, float_dtype, limit_policy, single_number, texts
from nao_kin._core.headings import TIME_UNITS
from nao_kin._core.process import usable_cores
from nao_kin._core.sides import Hips, check_hips
from nao_kin._core.text import abbreviated, quoted
from nao_kin._core.warn import warn_caller
from nao_kin.errors import BadArgument, BadInputFile, DegreesWarning, StartedOverWarning
from nao_kin.robot import PoseForm, RobotModel
from nao_kin.stream.parts import MAX_LISTED, BadRow, PartFolder, Progress, StreamResult, digest_of
from nao_kin.stream.sinks import PoseColumns, Sink, sink_class
from nao_kin.stream.sources import Block, Configurations, TableSource, found_files, open_source
from nao_kin.stream.tables import JointColumns, TableOptions

# --- Progress of a long run: rows, rate, and the time left.


class ProgressBar:
    """A bar on standard error in the context `shown`, if it is `wanted` and standard error is a terminal."""

    def __init__(self, wanted: bool) -> None:
        from rich.console import Console
        from rich.progress import Progress, TextColumn

        console = Console(file=sys.stderr)
        description, bar, share, left = Progress.get_default_columns()
        columns = description, bar, share, TextColumn("{task.fields[rows]}"), left
        hidden = not (wanted and console.is_terminal)
        self.shown = self._bar = Progress(*columns, console=console, disable=hidden, transient=True)
        self._task = self._bar.add_task("forward kinematics", total=None, rows="")
        self._first, self._start = 0, time.monotonic()

    def start(self, rows: int, fraction: float | None) -> None:
        """Begin after `rows` of an earlier run."""
        self._first, self._start = rows, time.monotonic()
        self._bar.update(self._task, total=None if fraction is None else 1.0, completed=fraction or 0.0)

    def show(self, rows: int, fraction: float | None) -> None:
        """Show the number of finished rows, and their fraction of the source if it is known."""
        if self._bar.disable:
            return
        rate = (rows - self._first) / max(1e-9, time.monotonic() - self._start)
        self._bar.update(self._task, completed=fraction or 0.0, rows=f"{rows:,} rows, {rate:,.0f}/s")

    def joining(self) -> None:
        """Show that the parts are being joined."""
        self._bar.update(self._task, description="joining the parts", total=None)


# --- Forward kinematics from file to file.

ErrorPolicy = Literal["stop", "skip", "nan"]

# An interrupted run loses at most the work on this many blocks.
_BLOCKS_OF_PART = 4
# Blocks that are read in advance.
_BLOCKS_AHEAD = 3
# Entries of homogeneous matrices in one call.
_MOST_ENTRIES = 1 << 21
_TURN = 2.0 * np.pi

_Poses = tuple[NDArray[np.int64], Floats, Floats | None]


def fk(
    robot: RobotModel,
    source: Path | str | Sequence[Path | str] | Configurations,
    sink: Path | str,
    *,
    frame: str | Sequence[str] | None = None,
    reference: str | None = None,
    as_: PoseForm = "matrix",
    dtype: DTypeLike = np.float64,
    limits: LimitPolicy = "enforce",
    degrees: bool = False,
    poses_in_degrees: bool = False,
    on_error: ErrorPolicy = "stop",
    columns: Mapping[str, str | None] | None = None,
    ignore_other: bool = False,
    hips: Hips | None = None,
    missing: str | float | None = None,
    progress: bool = False,
    overwrite: bool = False,
) -> StreamResult:
    """Write the poses of frames for every row of a file, however large, to a file.

    The suffixes of the names are the formats. A source is CSV (.csv; also without a suffix, and "-" for standard
    input), packed CSV (.csv.gz), a NumPy array of configurations (N, nq) (.npy), Parquet (.parquet) or Arrow IPC
    (.arrow, .feather). Tables have one column per joint, in any order, and perhaps one of times: numbers, timestamps of
    Arrow, or in CSV dates and times of ISO 8601, which become seconds from the first row of the first file. Numbers
    without a unit are in seconds, or in another unit if the first ones then are times since 1970; all files must agree
    in it, otherwise the run fails before it begins. The output
    is CSV, Parquet or Arrow with one record for each row and frame (the index of the row, its time [s] if the source
    has times, the frame's name, and the numbers of the pose), or a NumPy array of shape (N, frames, 4, 4), or
    (N, frames, 7 or 6), without the axis of frames for a single name.

    Memory does not grow with the files. The output appears, or is replaced, when it is complete. Until then finished
    parts are in a folder next to it, "….parts". If a run is ended by a signal, an exception or a full disk, the next
    run with the same source and arguments resumes after these parts, with the same result. If the source or an argument
    has changed, it starts over and warns. Bad input leaves no parts.

    Args:
        robot: its joints are named in the source.
        source: the file of configurations; several files, or a pattern such as `logs/*.csv`, with continuous row
            numbers; or `Configurations` in memory.
        sink: the file of poses, or "-" for CSV on standard output. A device or a pipe is written at the end.
        frame: a frame name, several, or None for all links, as in `RobotModel.fk`.
        reference: the frame to express the poses in, as in `RobotModel.fk`.
        as_: the numbers of a pose: "matrix", the 16 entries of the homogeneous matrix, t11 … t44 row by row;
            "quaternion", x, y, z, r0, r1, r2, r3, scalar first; or "rpy", x, y, z, roll, pitch, yaw with R =
            Rz(yaw) Ry(pitch) Rx(roll).
        dtype: float64, or float32 for half the size.
        limits: "enforce" makes a row with a joint outside its limits a bad row; "clamp" moves the joint to the limit;
            "ignore" accepts it, "measured" up to what sensors show, 5° or 0.02 of a ratio.
        degrees: turning joints of a source file are in degrees if it does not give their unit, as in `read_log`.
        poses_in_degrees: angles of poses are written in degrees, under names that end in _deg.
        on_error: "stop" raises at a bad row, "skip" leaves it out, "nan" writes poses of NaN.
        columns: headings of columns with other names, as in `read_log`.
        ignore_other: leave out columns that name no joint and no time.
        hips: value of a motor whose two joints differ, as in `read_log`.
        missing: values of joints without a column, and for empty cells and NaN, as in `read_log`.
        progress: show a bar with rate and time left on standard error, if it is a terminal.
        overwrite: replace an existing output.

    Returns:
        The counts of rows read and written, and the first bad rows with their lines.

    Raises:
        BadInputFile: the source cannot be read, or changes during the run, or, with on_error="stop", has a bad row.
        BadArgument: the output exists or cannot be written, or is the source.
        MissingExtra: pyarrow is not installed, and a file is Parquet or Arrow, or a CSV source of more than 100 MB.

    Examples:
        >>> from pathlib import Path
        >>> nao = nk.load_nao()
        >>> lines = nao.joint_names, map(str, nao.posture("Stand"))
        >>> _ = Path("q.csv").write_text(chr(10).join(map(",".join, lines)))
        >>> _ = nk.stream.fk(nao, "q.csv", "poses.npy", frame=["LArm", "RArm"])
        >>> np.load("poses.npy").shape
        (1, 2, 4, 4)
    """
    files = source if isinstance(source, Configurations) else _paths(source)
    sink = _path(sink, "sink")
    sink = "/dev/stdout" if sink == "-" else sink
    if hips is not None:
        check_hips(hips)
    limits = limit_policy(limits)
    choice(on_error, get_args(ErrorPolicy), "policy for bad rows")
    names = robot.link_names if frame is None else (frame,) if isinstance(frame, str) else texts(frame, "frame")
    if not names:
        raise BadArgument("no frames; expected at least one name, or None for all links")
    numbers = PoseColumns(as_, flag(poses_in_degrees, "poses_in_degrees"))
    kind = float_dtype(dtype)
    if not isinstance(files, Configurations):
        _check_apart(files, sink)
    atomic.check_replaceable(sink, overwrite=overwrite)
    shape = numbers.shape if isinstance(frame, str) else (len(names), *numbers.shape)
    sink_kind = sink_class(sink)
    # Unknown frames are refused before anything is read.
    robot.frame_ids(names if reference is None else (*names, reference))
    if not (missing is None or isinstance(missing, str)):
        missing = single_number(missing, "missing")
    with closing(open_source(files, robot, TableOptions(degrees, columns, ignore_other, missing))) as opened:
        joints = [JointColumns(robot, file.table, limits, hips, file.whole, missing) for file in opened.files]
        writer = sink_kind(names, numbers, shape, kind, opened.table.timed)
        job = _PoseRun(robot, opened, joints, names, reference, numbers, writer, on_error)
        arguments = {
            "frames": list(names),
            "reference": reference,
            "form": [as_, list(shape)],
            "dtype": str(kind),
            "limits": limits,
            "degrees": degrees,
            "poses in degrees": poses_in_degrees,
            "bad rows": on_error,
            "columns": None if columns is None else dict(columns),
            "other columns": ignore_other,
            "time unit": opened.table.time_unit,
            "hips": hips,
            "missing": missing,
            "format": type(writer).__name__,
        }
        identity = _identity(files)
        run = None
        if identity is not None:
            run = {"version of nao_kin": __version__, "robot": digest_of(robot), "source": identity, **arguments}
        result = _to_sink(job, files, sink, run, progress)
    if limits == "measured":
        result.clamped.warn(robot.unit)
    return result


@dataclass
class _PoseRun:
    """The work on every block."""

    robot: RobotModel
    source: TableSource
    joints: Sequence[JointColumns]  # meaning of the columns of each file of the source
    frames: tuple[str, ...]
    reference: str | None
    columns: PoseColumns
    sink: Sink
    on_error: str
    warned: bool = False  # of degrees: further blocks would repeat the warning with other numbers
    notes: dict[int, str] = field(default_factory=dict)  # on the unit of angles, by the index of the file

    def poses(self, block: Block, before: Progress) -> tuple[_Poses, Progress]:
        """Return rows (n,), numbers (n, frames, k) and times (n,) of a block's poses, and the progress after it."""
        joints = self.joints[block.file]
        values = block.values
        if block.times is not None and not np.isfinite(block.times).all():
            values = np.where(np.isfinite(block.times)[:, None], values, np.nan)
        q, good, clamped = joints.configurations(values)
        self.notes.setdefault(block.file, joints.unit_note(values))
        unit = joints.table.time_unit
        times = None if block.times is None or unit is None else block.times / TIME_UNITS[unit]
        # The kernels compute every row of a file of several blocks, so that the bits of a row do not depend on where
        # the run began. For a file of one block it may not be worthwhile to load the kernels.
        alone = block.last and not before.rows_read
        numbers = self._numbers(q, None if alone else usable_cores())
        rows = before.rows_read + np.arange(len(good))
        bad = np.flatnonzero(~good)
        listed = before.first_bad_rows
        if len(bad):
            listed += self._bad_rows(block, bad[: MAX_LISTED - len(listed)], before.rows_read)
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

    def _numbers(self, q: Floats, threads: int | None) -> Floats:
        """Return the numbers of the poses, shape (n, frames, k)."""
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
    job: _PoseRun, source: Sequence[str] | Configurations, sink: str, run: dict[str, Any] | None, progress: bool
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
        bar = ProgressBar(progress)
        with bar.shown:
            done = _write_parts(job, folder, bar)
            now = _identity(source)
            if run is not None and now != run["source"]:
                folder.resumable = False
                changed = next(file["path"] for file in run["source"] if file not in (now or ()))
                raise BadInputFile(str(changed), "changed while it was read")
            bar.joining()
            with folder.unfinished.open("wb") as file:
                job.sink.join(folder.parts, file, done.rows_written)
        atomic.move_into_place(folder.unfinished, sink)
        folder.resumable = False
    except BadInputFile as error:
        # A later run may succeed in reading the file, but wrong content stays wrong.
        if folder is not None and not isinstance(error.__cause__, OSError):
            folder.resumable = False
        raise
    except BrokenPipeError:
        raise  # the reader of the pipe has closed it
    except OSError as error:
        advice = ""
        if folder is not None and folder.resumable and folder.last is not None:
            advice = f"; run it again to resume from row {folder.last.rows_read}"
        raise BadArgument(f"cannot write {abbreviated(sink)}: {error.strerror or error}{advice}") from None
    finally:
        if folder is not None:
            folder.close()
    counts = {name: value for name, value in vars(done).items() if name != "end"}
    notes = dict.fromkeys(filter(None, (*job.source.table.notes, job.source.time_note, *job.notes.values())))
    return StreamResult(sink, job.frames, job.columns.names, rows_resumed=resumed, notes=tuple(notes), **counts)


def _write_parts(job: _PoseRun, folder: PartFolder, bar: ProgressBar) -> Progress:
    """Process the source from the end of the finished parts."""
    done = folder.last or Progress(job.source.start)
    bar.start(done.rows_read, job.source.fraction(done.end))
    parts = _PartWriter(job.sink, folder)
    # Blocks are formatted and written while the next one is processed.
    with closing(parts), ThreadPoolExecutor(1, "nao_kin-writer") as writer:
        writing: Future[None] | None = None
        with closing(_read_ahead(job.source.blocks(done.end), job.source.path)) as source:
            for block in source:
                poses, done = job.poses(block, done)
                if writing is not None:
                    writing.result()
                writing = writer.submit(parts.write, poses, done)
                bar.show(done.rows_read, job.source.fraction(done.end))
        if writing is not None:
            writing.result()
        parts.finish()
    return done


class _PartWriter:
    """A writer that appends blocks to one part after the other."""

    def __init__(self, sink: Sink, folder: PartFolder) -> None:
        self._sink, self._folder = sink, folder
        self._file: BinaryIO | None = None
        self._blocks = 0
        self._done: Progress | None = None

    def write(self, poses: _Poses, done: Progress) -> None:
        """Append a block with the progress after it; a part is finished after some blocks."""
        with self._folder.busy:
            self._file = self._file or self._folder.unfinished.open("wb")
            self._sink.write(self._file, *poses)
            self._blocks += 1
            self._done = done
            if self._blocks == _BLOCKS_OF_PART:
                self.finish()

    def finish(self) -> None:
        """Finish the current part, if there is one."""
        if self._file is not None and self._done is not None:
            self._folder.add(self._file, self._done)
            self._file, self._blocks = None, 0

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()


def _read_ahead(blocks: Iterator[Block], path: str) -> Generator[Block, None, None]:
    """Yield the blocks, and read the next ones meanwhile."""
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
    """Return the data that identify files and their versions; None for other sources, which are read only once."""
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


def _check_apart(sources: Sequence[str], sink: str) -> None:
    for source in sources:
        if source != "-" and os.path.exists(source) and os.path.exists(sink) and os.path.samefile(source, sink):
            raise BadArgument(f"{abbreviated(sink)} is the source too; the poses need another file")


def _paths(source: Path | str | Sequence[Path | str]) -> list[str]:
    """Return the files that a name, a pattern, or a list of these stands for."""
    several = [source] if isinstance(source, (str, Path)) else source
    if not several:
        raise BadArgument("no source; expected at least one file")
    return [file for one in several for file in found_files(_path(one, "source"))]


def _path(path: Path | str, what: str) -> str:
    if not str(path):
        raise BadArgument(f"{what} must be the name of a file, got {quoted(path)}")
    return str(path)
