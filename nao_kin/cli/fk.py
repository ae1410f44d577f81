"""`nao-kin fk`: the poses of frames at given joint values."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np

from nao_kin._core import files as atomic
from nao_kin._core.arrays import Floats, LimitPolicy
from nao_kin._core.process import usable_cores
from nao_kin.cli import options as shared
from nao_kin.cli.options import Needs, OutputOptions, RobotOptions, argument, command, option
from nao_kin.cli.output import (
    fixed,
    print_json,
    print_json_list,
    print_note,
    print_table,
    print_written,
    progress,
    units,
)
from nao_kin.cli.sources import FileOptions, frame_names, note_clamped
from nao_kin.errors import BadArgument

if TYPE_CHECKING:
    from nao_kin.robot import RobotModel
    from nao_kin.stream import PoseColumns


# --- Output of poses: JSON, CSV, a table, or lines as they come.

# First row and numbers of the poses (n, frames, k) of one chunk after another.
Chunks = Iterator[tuple[int, Floats]]


@dataclass(frozen=True)
class PosePrinter:
    """Prints poses of named frames in a format; `times` are those of the rows, shape (n,) [s]."""

    frames: Sequence[str]
    columns: PoseColumns
    times: Floats | None = None

    def print_json(self, chunks: Chunks, robot: str, reference: str | None, *, many: bool) -> None:
        """Print one document: the poses of the single configuration, or with `many` those of each in a list."""
        head: dict[str, Any] = {
            "robot": robot,
            "reference": reference or "root",
            "as": self.columns.style,
            "units": units(self.columns.degrees),
        }
        if self.times is not None:
            head["times"] = self.times.tolist()
        poses = (dict(zip(self.frames, map(self._json_pose, rows), strict=True)) for _, rows in _rows(chunks))
        if many:
            print_json_list(head, "configurations", poses)
        else:
            print_json({**head, "poses": next(poses)})

    def _json_pose(self, row: list[float]) -> object:
        if self.columns.style == "matrix":
            return [row[i : i + 4] for i in range(0, 16, 4)]
        return dict(zip(self.columns.names, row, strict=True))

    def print_csv(self, chunks: Chunks) -> None:
        """Print a header, and one line per configuration and frame."""
        sys.stdout.write(self.columns.csv_header(timed=self.times is not None))
        for start, numbers in chunks:
            rows = np.arange(start, start + len(numbers))
            times = None if self.times is None else self.times[start : start + len(numbers)]
            sys.stdout.write(self.columns.csv_lines(rows, self.frames, numbers, times).decode())

    def print_table(self, chunks: Chunks) -> None:
        """Print the poses of one configuration as a table."""
        turns = self.columns.orientation
        if self.columns.style == "matrix":
            columns = ["x axis", "y axis", "z axis", "origin\n[m]"]
        else:
            unit = "" if self.columns.style == "quaternion" else "\n[°]" if self.columns.degrees else "\n[rad]"
            columns = [f"{name}\n[m]" for name in self.columns.names[: -len(turns)]]
            columns += [name.removesuffix("_deg") + unit for name in turns]
        table = []
        for _, rows in _rows(chunks):
            for name, row in zip(self.frames, rows, strict=True):
                cells = [fixed(value) for value in row]
                if self.columns.style == "matrix":  # as usually written: the columns are the axes and the origin
                    cells = ["\n".join(cells[column::4]) for column in range(4)]
                table.append([name, *cells])
        print_table(["frame", *columns], table, numbers=columns)

    def print_lines(self, chunks: Chunks) -> None:
        """Print one line per row and frame as they come, without waiting for the layout of a long table."""
        width = max(5, *map(len, self.frames))
        times = [] if self.times is None else [f"{time:.6f}" for time in self.times.tolist()]
        wide = max(map(len, ("time", *times)))
        print(f"{'row':>7}" + (f"  {'time':>{wide}}" if times else "") + f"  {'frame':{width}}", end="")
        print("".join(f"{name:>11}" for name in self.columns.names))
        for index, rows in _rows(chunks):
            start = f"{index:>7}" + (f"  {times[index]:>{wide}}" if times else "")
            for name, row in zip(self.frames, rows, strict=True):
                print(f"{start}  {name:{width}}" + "".join(f"{fixed(value):>11}" for value in row))


def _rows(chunks: Chunks) -> Iterator[tuple[int, list[list[float]]]]:
    """Yield the index of every configuration, and the numbers of each frame."""
    for start, numbers in chunks:
        yield from enumerate(numbers.tolist(), start)


# --- The command.

# Rows between two updates of the progress bar; with more rows, the compiled kernels compute.
_CHUNK = 10_000

_EXAMPLES = (
    "Example: nao-kin fk --posture StandInit --joint HeadYaw=0.3 --frame CameraTop --json; "
    "nao-kin fk walk.csv --frame LLeg -o poses.parquet"
)


@dataclass(frozen=True)
class PoseOptions:
    """The options of the poses of a configuration."""

    frame: list[str] | None = shared.FRAME
    reference: str | None = shared.REFERENCE
    as_: Literal["matrix", "quaternion", "rpy"] = option(None, "Format of a pose.", default="rpy")

    def frames(self, model: RobotModel) -> list[str]:
        """Return the frames of --frame, by default the effectors and the cameras."""
        effectors = [*model.semantics.end_effectors, *model.semantics.cameras]
        return frame_names(model, self.frame) or effectors or list(model.link_names)


@dataclass(frozen=True)
class StreamOptions:
    """The options of poses that are written to a file."""

    output: str | None = option("FILE", "Write .parquet, .arrow, .feather, .npy or .csv; - prints CSV.")
    on_error: Literal["stop", "skip", "nan"] = option(None, "With -o: treatment of bad rows.", default="stop")
    dtype: Literal["float32", "float64"] = option(None, "With -o: type of the numbers.", default="float64")

    needs: ClassVar[Needs] = {"on_error": "output", "dtype": "output", "output": "file"}

    @property
    def sink(self) -> str | None:
        """The file to write; None for none."""
        return "/dev/stdout" if self.output == "-" else self.output


@command("fk", _EXAMPLES)
def fk(
    *,
    file: list[str] | None = argument(
        "FILE", "CSV or JSON file of configurations, or a motion; - for standard input. With -o, several files.", None
    ),
    given: FileOptions,
    wanted: PoseOptions,
    limits: LimitPolicy = shared.LIMITS,
    csv: bool = shared.CSV,
    streamed: StreamOptions,
    written: OutputOptions,
    robot: RobotOptions,
) -> None:
    """Print poses of frames at given joint values: of one configuration, or of every row of a file.

    Without --frame, the frames are the effectors and the cameras. Values are in radians (hands: 0 closed to 1 open),
    unless the heading says otherwise, as in HeadYaw [deg], or --file-deg of a file, --deg of --joint.
    A file names all joints in its header or keys, in any order: the 25 joints, or NAOqi's 26, also as keys of ALMemory;
    times are copied to the output. A motion file of any format (see nao-kin motion) names only the joints that it
    moves; it gives one row for each of its key times, or --rate rows per second.

    With -o, the file may be larger than memory, and may also be a .csv.gz, .npy, .parquet, .arrow or .feather file. Run
    the same command again to continue an interrupted run.
    """
    files = file or []
    if streamed.sink is not None:
        target = atomic.replaced_file(streamed.sink)
        # An interrupted run, which is continued, has left parts of the output.
        continued = target is not None and target.with_name(f"{target.name}.parts").is_dir()
        written.check({"--output": streamed.sink}, continued=continued)
        _stream(robot.load(), files, given, wanted, streamed, limits, json=written.json)
        return
    if len(files) > 1:
        raise BadArgument(f"{len(files)} files; several files need --output, which names the file to write")
    from nao_kin.stream import PoseColumns

    model = robot.load()
    q, times, many, _ = given.configurations(model, next(iter(files), None), limits=limits)
    frames, reference = wanted.frames(model), wanted.reference
    # Refuse unknown frames before anything is printed.
    model.frame_ids(frames if reference is None else [*frames, reference])
    printer = PosePrinter(frames, PoseColumns(wanted.as_, given.deg), times)
    poses = _poses(model, q, frames, reference, printer.columns)
    if written.json:
        printer.print_json(poses, model.name, reference, many=many)
    elif csv:
        printer.print_csv(poses)
    elif many:
        printer.print_lines(poses)
    else:
        printer.print_table(poses)


def _stream(
    model: RobotModel,
    files: list[str],
    given: FileOptions,
    wanted: PoseOptions,
    streamed: StreamOptions,
    limits: LimitPolicy,
    *,
    json: bool,
) -> None:
    """Write the poses of files, which may be larger than memory; print a summary, and notes on bad and clamped rows."""
    from nao_kin import stream

    one = files[0] if len(files) == 1 else None
    path, hips = given.motion(model, files[0], limits=limits, unread=one in (None, "-"))
    result = stream.fk(
        model,
        files if path is None else stream.Configurations(path.q, path.times, str(one)),
        str(streamed.sink),
        frame=wanted.frames(model),
        reference=wanted.reference,
        as_=wanted.as_,
        dtype=streamed.dtype,
        limits=limits if path is None else "ignore",
        degrees=given.file_deg,
        poses_in_degrees=given.deg,
        on_error=streamed.on_error,
        columns=given.renamed,
        ignore_other=given.ignore_other,
        missing=given.value_of_missing,
        hips=hips,
        progress=True,
        overwrite=True,  # checked before, where a continued file is recognised
    )
    if json:
        print_json(result.as_dict())
    else:
        print_written(result.sink)
    print_note(*result.notes)
    note_clamped(model, result.clamped, result.rows_read)
    if result.rows_resumed:
        print_note(f"the first {result.rows_resumed} rows had been done by an earlier run")
    if result.bad_rows:
        done = "left out" if result.rows_written < result.rows_read else "written as nan"
        print_note(f"{result.bad_rows} bad rows of {result.rows_read} {done}:")
        print_note(*(f"  {bad}" for bad in result.first_bad_rows))
        if result.bad_rows > len(result.first_bad_rows):
            print_note(f"  and {result.bad_rows - len(result.first_bad_rows)} more")


def _poses(model: RobotModel, q: Floats, frames: list[str], reference: str | None, columns: PoseColumns) -> Chunks:
    """Yield first row and poses (n, frames, k) of one chunk after another, with a progress bar for many."""
    many = len(q) > _CHUNK
    with progress("forward kinematics", shown=many) as say:
        for start in range(0, len(q), _CHUNK):
            part = q[start : start + _CHUNK]
            yield start, columns.poses(model, part, frames, reference, threads=usable_cores() if many else None)
            say(start + len(part), len(q))
