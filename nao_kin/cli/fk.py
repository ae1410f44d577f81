"""`nao-kin fk`: the poses of frames at given joint values."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from nao_kin._core import files as atomic
from nao_kin._core.arrays import Floats, LimitPolicy
from nao_kin._core.process import usable_cores
from nao_kin._core.text import quoted
from nao_kin.cli.options import RobotOptions, argument, check_outputs, command, option
from nao_kin.cli.output import fixed, print_json, print_json_list, print_note, print_table, print_written, progress
from nao_kin.cli.shared import CSV, DEG, FORCE, FRAME, JSON, LIMITS, OUTPUT, REFERENCE
from nao_kin.cli.sources import FileOptions, JointOptions, frame_names, is_motion
from nao_kin.errors import BadArgument, BadInputFile

if TYPE_CHECKING:
    from nao_kin.motion import Trajectory
    from nao_kin.robot import RobotModel
    from nao_kin.stream import Configurations, PoseColumns, StreamResult


# --- Output of poses: JSON, CSV, a table, or lines as they come.

# First row and numbers of the poses (n, frames, k) of one chunk after another.
Chunks = Iterator[tuple[int, Floats]]

# matrix: the 16 entries of the homogeneous matrix, row by row, like NAOqi's getTransform. position6d: x, y, z, wx, wy,
# wz with R = Rz(wz) Ry(wy) Rx(wx), like NAOqi's getPosition. rpy: the same numbers, as roll, pitch, yaw. quaternion:
# x, y, z and the unit quaternion, scalar first.
PoseFormat = Literal["matrix", "position6d", "rpy", "quaternion"]


@dataclass(frozen=True)
class PosePrinter:
    """Prints poses of named frames in a format; `times` are those of the rows, shape (n,) [s]."""

    frames: Sequence[str]
    style: PoseFormat
    columns: PoseColumns
    times: Floats | None = None

    def print_json(self, chunks: Chunks, robot: str, reference: str | None, *, many: bool) -> None:
        """Print one document: the poses of the single configuration, or with `many` those of each in a list."""
        head: dict[str, Any] = {
            "robot": robot,
            "reference": reference or "root",
            "as": self.style,
            "units": {"length": "m", "angle": "deg" if self.columns.degrees else "rad"},
        }
        if self.times is not None:
            head["times"] = self.times.tolist()
        poses = (dict(zip(self.frames, map(self._json_pose, rows), strict=True)) for _, rows in _rows(chunks))
        if many:
            print_json_list(head, "configurations", poses)
        else:
            print_json({**head, "poses": next(poses)})

    def _json_pose(self, row: list[float]) -> object:
        if self.style == "matrix":
            return [row[i : i + 4] for i in range(0, 16, 4)]
        return dict(zip(self.columns.names, row, strict=True))

    def print_csv(self, chunks: Chunks) -> None:
        """Print a header, and one line per configuration and frame."""
        from nao_kin.stream import csv_header, pose_lines

        sys.stdout.write(csv_header(self.columns.names, timed=self.times is not None))
        for start, numbers in chunks:
            rows = np.arange(start, start + len(numbers))
            times = None if self.times is None else self.times[start : start + len(numbers)]
            sys.stdout.write(pose_lines(rows, self.frames, numbers, times).decode())

    def print_table(self, chunks: Chunks) -> None:
        """Print the poses of one configuration as a table."""
        turns = self.columns.orientation
        if self.style == "matrix":
            columns = ["x axis", "y axis", "z axis", "origin\n[m]"]
        else:
            unit = "" if self.style == "quaternion" else "\n[°]" if self.columns.degrees else "\n[rad]"
            columns = [f"{name}\n[m]" for name in self.columns.names[: -len(turns)]]
            columns += [name.removesuffix("_deg") + unit for name in turns]
        table = []
        for _, rows in _rows(chunks):
            for name, row in zip(self.frames, rows, strict=True):
                cells = [fixed(value) for value in row]
                if self.style == "matrix":  # as usually written: the columns are the axes and the origin
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

# Rows between two updates of the progress bar: small enough to move often, large enough to cost no time.
_CHUNK = 8192

_EXAMPLES = (
    "Example: nao-kin fk --posture StandInit --joint HeadYaw=0.3 --frame CameraTop --json; "
    "nao-kin fk big.csv --frame LLeg -o poses.parquet"
)


@dataclass(frozen=True)
class StreamOptions:
    """The options of poses that are written to a file."""

    output: str | None = option("FILE", "Write .parquet, .arrow, .feather, .npy or .csv; - prints CSV.", *OUTPUT)
    on_error: Literal["stop", "skip", "nan"] | None = option(None, "With -o: treatment of bad rows. Default: stop.")
    dtype: Literal["float32", "float64"] | None = option(None, "With -o: type of the numbers. Default: float64.")
    force: bool = FORCE

    def check(self, files: list[str], json: bool) -> None:
        """Refuse contradictory options, and a file that may not be written, before anything is loaded."""
        for name, value in (("--on-error", self.on_error), ("--dtype", self.dtype)):
            if self.output is None and value is not None:
                raise BadArgument(f"{name} is for files; name one with --output")
        if self.output is None and len(files) > 1:
            raise BadArgument(f"{len(files)} files; several files need --output")
        if self.output is not None and not files:
            raise BadArgument("--output is for the rows of a file; name the FILE to read")
        outputs, printed = {"--output": self.sink}, "--json" if json else None
        check_outputs(outputs, force=self.force, printed=printed, continued=self._continued)

    @property
    def sink(self) -> str | None:
        """The file to write; None for none."""
        return "/dev/stdout" if self.output == "-" else self.output

    @property
    def _continued(self) -> bool:
        """Whether an interrupted run has left parts of the output."""
        target = None if self.sink is None else atomic.replaced_file(self.sink)
        return target is not None and target.with_name(f"{target.name}.parts").is_dir()


@command("fk", _EXAMPLES)
def fk(
    *,
    file: list[str] | None = argument(
        "FILE", "CSV or JSON file of configurations, or a motion; - for standard input. With -o, several files.", None
    ),
    joints: JointOptions,
    frame: list[str] | None = FRAME,
    reference: str | None = REFERENCE,
    as_: PoseFormat = option(None, "Format of a pose.", default="rpy"),
    deg: bool = DEG,
    limits: LimitPolicy = LIMITS,
    csv: bool = CSV,
    written: StreamOptions,
    given: FileOptions,
    json: bool = JSON,
    robot: RobotOptions,
) -> None:
    """Print poses of frames at given joint values: of one configuration, or of every row of a file.

    Without --frame, the frames are the effectors and the cameras. Values are in radians (hands: 0 closed to 1 open),
    unless --deg or the heading says otherwise, as in HeadYaw [deg].
    A file names all joints in its header or keys, in any order: the 25 joints, or NAOqi's 26, also as keys of ALMemory;
    times are copied to the output. A motion file of any format (see nao-kin motion) names only the joints that it
    moves; it gives one row for each of its key times, or --rate rows per second.

    With -o, the file may be larger than memory, and may also be a .csv.gz, .npy, .parquet, .arrow or .feather file. Run
    the same command again to continue an interrupted run.
    """
    files = file or []
    written.check(files, json)
    first = files[0] if files else None
    one = first if len(files) == 1 else None
    # With -o, standard input may be larger than memory, and is not read here.
    unseen = one == "-" and written.output is not None
    moves = one is not None and not unseen and is_motion(one)
    given.check(first, joints.posture, moves=moves)
    from nao_kin import stream

    model = robot.load()
    clamp = limits == "clamp"
    as_motion = joints.posture is not None or given.rate is not None or given.timeline is not None
    log = None if one is None or as_motion else given.log_columns(model, one)
    moves = moves and log is None
    timed = log is not None and log.timed
    if moves and given.renamed:
        raise BadArgument(f"--columns is for whole configurations; {quoted(one)} is read as a motion")
    rule: Any = "average" if given.hips is None and timed else given.hips  # as for a motion
    rows: Configurations | None = None
    if moves and one is not None:
        path = given.trajectory(model, one, deg=deg, posture=joints.posture, rate=given.rate)
        rows = stream.Configurations(_within_limits(model, one, path, limits, deg=deg), path.times, one)
    chosen = frame_names(model, frame)
    chosen = chosen or [*model.semantics.end_effectors, *model.semantics.cameras] or list(model.link_names)
    style: Any = "position_quaternion" if as_ == "quaternion" else as_
    if written.sink is not None:
        result = stream.fk(
            model,
            files if rows is None else rows,
            chosen,
            written.sink,
            reference=reference,
            as_=style,
            dtype=written.dtype or "float64",
            limits=limits if rows is None else "ignore",
            degrees=deg,
            on_error=written.on_error or "stop",
            columns=given.renamed,
            ignore_other=given.ignore_other,
            hips=rule if rows is None else None,
            progress=True,
            overwrite=True,  # checked above, where a continued file is recognised
        )
        _report(model, result, json)
        return
    times: Floats | None = None
    if rows is not None:
        q, times, many = rows.q, rows.times, True
    elif one is not None:
        found = given.log(model, one, deg=deg, limits="ignore" if clamp else limits, hips=rule)
        q, times, many = _clamped(model, found.q) if clamp else found.q, found.times, found.many
        print_note(*found.notes)
    else:
        q, many = joints.configuration(model, deg=deg, limits=limits)[None], False
    # Refuse unknown frames before anything is printed.
    model.frame_ids(chosen if reference is None else [*chosen, reference])
    printer = PosePrinter(chosen, as_, stream.PoseColumns(style, deg), times)
    poses = _poses(model, q, chosen, reference, printer.columns)
    if json:
        printer.print_json(poses, model.name, reference, many=many)
    elif csv:
        printer.print_csv(poses)
    elif many:
        printer.print_lines(poses)
    else:
        printer.print_table(poses)


def _report(model: RobotModel, result: StreamResult, json: bool) -> None:
    """Print a summary of the output, and on standard error the omitted and changed rows."""
    if json:
        print_json(result.as_dict())
    else:
        print_written(result.sink)
    print_note(*result.notes)
    _note_clamped(model, result.clamped, result.rows_read)
    if result.rows_resumed:
        print_note(f"the first {result.rows_resumed} rows had been done by an earlier run")
    if result.bad_rows:
        done = "left out" if result.rows_written < result.rows_read else "written as nan"
        print_note(f"{result.bad_rows} bad rows of {result.rows_read} {done}:")
        for bad in result.first_bad_rows:
            print_note(f"  {bad}")
        if result.bad_rows > len(result.first_bad_rows):
            print_note(f"  and {result.bad_rows - len(result.first_bad_rows)} more")


def _within_limits(model: RobotModel, file: str, path: Trajectory, limits: LimitPolicy, *, deg: bool) -> Floats:
    """Return the configurations of a motion, clamped if requested; refuse the first one outside the limits."""
    if limits == "clamp":
        return _clamped(model, path.q)
    violations = model.limit_violations(path.q, max_configurations=1) if limits == "enforce" else ()
    if violations:
        from nao_kin.stream import look_like_degrees

        first = violations[0]
        when = f"{path.times[first.index[0]]:.6g} s"
        reason = f"at {when} outside the joint limits: {first.describe(degrees=deg, index=False)}"
        advice = "nao-kin motion check lists all, --limits clamp or --limits ignore accepts them"
        if not deg and look_like_degrees(model, model.joint_names, path.q[first.index[0], model.nq_base :]):
            advice = "are these degrees (--deg)?"
        raise BadInputFile(file, f"{reason}; {advice}")
    return path.q


def _clamped(model: RobotModel, q: Floats) -> Floats:
    """Return configurations moved inside the limits, and print a note on their number and the largest change."""
    from nao_kin import stream

    inside, changes = stream.clamp(model, q)
    _note_clamped(model, changes, len(q))
    return inside


def _note_clamped(model: RobotModel, changes: Any, rows: int) -> None:
    """Print a note on the changes of --limits clamp."""
    if changes.rows:
        unit = model.unit(changes.joint)
        largest = f"{changes.largest:.3g}{'' if unit == '1' else f' {unit}'}"
        moved = f"{changes.rows} of {rows} rows to the limits, by at most {largest} ({changes.joint})"
        print_note(f"--limits clamp moved {moved}")


def _poses(model: RobotModel, q: Floats, frames: list[str], reference: str | None, columns: PoseColumns) -> Chunks:
    """Yield first row and poses (n, frames, k) of one chunk after another, with a progress bar for many."""
    from nao_kin import stream

    many = len(q) > stream.FEW_ROWS
    with progress("forward kinematics", shown=many) as say:
        for start in range(0, len(q), _CHUNK):
            part = q[start : start + _CHUNK]
            yield start, columns.poses(model, part, frames, reference, threads=usable_cores() if many else None)
            say(start + len(part), len(q))
