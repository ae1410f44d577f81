"""`nao-kin fk`: where the frames are at given joint values."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

from nao_kin._core import files as atomic
from nao_kin._core.arrays import Floats, decimal
from nao_kin._core.process import usable_cores
from nao_kin._core.text import abbreviated, quoted
from nao_kin.cli.motion import (
    clamped,
    is_motion,
    log_columns,
    note_clamped,
    read,
    refuse_motion_options,
    trajectory,
    within_limits,
)
from nao_kin.cli.options import (
    ColumnsOption,
    DegOption,
    HipsOption,
    IgnoreOtherOption,
    JsonOption,
    RateOption,
    RobotOptions,
    TimelineOption,
    check_sinks,
    columns_of,
    command,
    print_json,
    print_json_list,
    print_note,
    print_table,
    without_sign_of_zero,
)
from nao_kin.errors import BadArgument, CouplingViolated, OutsideLimits

if TYPE_CHECKING:
    from nao_kin.robot import LimitPolicy, RobotModel
    from nao_kin.stream import Configurations, PoseColumns, PoseStyle, StreamResult


# --- Poses as the numbers people write down, and their printing: JSON, CSV, a table, or lines as they come.

# First row and numbers of the poses (n, frames, k) of one piece after another.
Pieces = Iterator[tuple[int, Floats]]


class PoseFormat(str, Enum):
    """How a pose is written.

    matrix: the 16 entries of the homogeneous matrix, row by row, as NAOqi's getTransform has them.
    position6d: x, y, z, wx, wy, wz with R = Rz(wz) Ry(wy) Rx(wx), as NAOqi's getPosition has them.
    rpy: x, y, z, roll, pitch, yaw with R = Rz(yaw) Ry(pitch) Rx(roll).
    quaternion: x, y, z and the unit quaternion r0, r1, r2, r3, scalar first.
    """

    matrix = "matrix"
    position6d = "position6d"
    rpy = "rpy"
    quaternion = "quaternion"


STYLES: dict[PoseFormat, PoseStyle] = {
    PoseFormat.matrix: "matrix",
    PoseFormat.position6d: "position6d",
    PoseFormat.rpy: "rpy",
    PoseFormat.quaternion: "position_quaternion",
}


@dataclass(frozen=True)
class PosePrinter:
    """Prints poses of named frames.

    Attributes:
        frames: the names.
        style: how a pose is written.
        degrees: angles in degrees.
        times: of the rows, shape (n,) [s]; None for none.
    """

    frames: Sequence[str]
    style: PoseFormat
    degrees: bool
    times: Floats | None = None

    @property
    def columns(self) -> PoseColumns:
        """The numbers of a pose and their names."""
        from nao_kin.stream import PoseColumns  # which loads Pinocchio; an installation without it must get this far

        return PoseColumns(STYLES[self.style], self.degrees)

    def print_json(self, pieces: Pieces, robot: str, reference: str | None, *, many: bool) -> None:
        """One document: the poses of the one configuration, or of each of `many`."""
        head: dict[str, Any] = {
            "robot": robot,
            "reference": reference or "root",
            "as": self.style.value,
            "units": {"length": "m", "angle": "deg" if self.degrees else "rad"},
        }
        if self.times is not None:
            head["times"] = self.times.tolist()
        poses = (dict(zip(self.frames, map(self._json_pose, rows), strict=True)) for _, rows in self._rows(pieces))
        if many:
            print_json_list(head, "configurations", poses)
        else:
            print_json({**head, "poses": next(poses)})

    def print_csv(self, pieces: Pieces) -> None:
        """One line per configuration and frame, with a header."""
        from nao_kin.stream import csv_header, pose_lines

        sys.stdout.write(csv_header(self.columns.names, timed=self.times is not None))
        for start, numbers in pieces:
            rows = np.arange(start, start + len(numbers))
            times = None if self.times is None else self.times[start : start + len(numbers)]
            sys.stdout.write(pose_lines(rows, self.frames, numbers, times).decode())

    def print_table(self, pieces: Pieces) -> None:
        """The poses of one configuration, laid out for a reader."""
        matrix = self.style is PoseFormat.matrix
        columns = ("x axis", "y axis", "z axis", "origin\n[m]") if matrix else self._headings()
        table = []
        for _, rows in self._rows(pieces):
            for name, row in zip(self.frames, rows, strict=True):
                cells = [_fixed(value) for value in row]
                if matrix:  # the 4×4 matrix as it is written on paper; its columns are the axes and the origin
                    cells = ["\n".join(cells[column::4]) for column in range(4)]
                table.append([name, *cells])
        print_table(["frame", *columns], table, numbers=columns)

    def print_lines(self, pieces: Pieces) -> None:
        """One line per row and frame as they come: no waiting until a table of many thousand rows is laid out."""
        width = max(5, *map(len, self.frames))
        times = [] if self.times is None else [f"{time:.6f}" for time in self.times.tolist()]
        wide = max(map(len, ("time", *times)))
        print(f"{'row':>7}" + (f"  {'time':>{wide}}" if times else "") + f"  {'frame':{width}}", end="")
        print("".join(f"{name:>11}" for name in self.columns.names))
        for index, rows in self._rows(pieces):
            start = f"{index:>7}" + (f"  {times[index]:>{wide}}" if times else "")
            for name, row in zip(self.frames, rows, strict=True):
                print(f"{start}  {name:{width}}" + "".join(f"{_fixed(value):>11}" for value in row))

    def _rows(self, pieces: Pieces) -> Iterator[tuple[int, list[list[float]]]]:
        """Index of every configuration, and the numbers of each frame."""
        for start, numbers in pieces:
            yield from enumerate(numbers.tolist(), start)

    def _json_pose(self, row: list[float]) -> object:
        if self.style is PoseFormat.matrix:
            return [row[i : i + 4] for i in range(0, 16, 4)]
        return dict(zip(self.columns.names, row, strict=True))

    def _headings(self) -> tuple[str, ...]:
        unit = "" if self.style is PoseFormat.quaternion else "\n[°]" if self.degrees else "\n[rad]"
        columns = self.columns
        position = columns.names[: -len(columns.orientation)]
        orientation = (name.removesuffix("_deg") for name in columns.orientation)
        return (*(f"{name}\n[m]" for name in position), *(name + unit for name in orientation))


def _fixed(value: float) -> str:
    return f"{without_sign_of_zero(value, 5):.5f}"


# --- `nao-kin fk`: where the frames are at given joint values.

# One pass of the progress bar; small enough to move often, large enough to cost nothing.
_CHUNK = 8192
_WORLD = "world"


class ErrorChoice(str, Enum):
    """What to do with a row from which no configuration can be made."""

    stop = "stop"
    skip = "skip"
    nan = "nan"


class NumberChoice(str, Enum):
    """Size of the numbers of a file."""

    float32 = "float32"
    float64 = "float64"


_EXAMPLES = (
    "Example: nao-kin fk --posture StandInit --joint HeadYaw=0.3 --frame CameraTop --json; "
    "nao-kin fk big.csv --frame LLeg -o poses.parquet"
)


@command("fk", _EXAMPLES)
def fk(
    *,
    file: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="FILE",
            help="CSV or JSON file of configurations, or a motion; - for standard input. With -o, several too.",
        ),
    ] = None,
    posture: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Start from a predefined posture; of a motion: of joints it does not name."),
    ] = None,
    joint: Annotated[
        list[str] | None, typer.Option(metavar="NAME=VALUE", help="Set a joint; repeatable. Others are at zero.")
    ] = None,
    frame: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="A frame to locate; repeatable. Default: the effectors.")
    ] = None,
    reference: Annotated[str | None, typer.Option(metavar="NAME", help="The frame to express poses in.")] = None,
    as_: Annotated[PoseFormat, typer.Option("--as", help="How to print a pose.")] = PoseFormat.rpy,
    deg: DegOption = False,
    clamp: Annotated[bool, typer.Option("--clamp", help="Move joints outside their limits to the limit.")] = False,
    ignore_limits: Annotated[bool, typer.Option("--ignore-limits", help="Take joints wherever they are.")] = False,
    csv: Annotated[bool, typer.Option("--csv", help="Print CSV.")] = False,
    output: Annotated[
        str | None,
        typer.Option(
            "--output", "-o", metavar="FILE", help="Write .parquet, .arrow, .feather, .npy or .csv; - prints CSV."
        ),
    ] = None,
    on_error: Annotated[
        ErrorChoice | None, typer.Option("--on-error", help="With -o: what to do with a bad row. Default: stop.")
    ] = None,
    dtype: Annotated[
        NumberChoice | None, typer.Option("--dtype", help="With -o: size of the numbers. Default: float64.")
    ] = None,
    columns: ColumnsOption = None,
    ignore_other: IgnoreOtherOption = False,
    rate: RateOption = None,
    hips: HipsOption = None,
    timeline: TimelineOption = None,
    json: JsonOption = False,
    robot: RobotOptions,
) -> None:
    """Poses of frames at given joint values: one configuration, or every row of a file.

    Values are radians (hands: 0 closed to 1 open) unless --deg or the heading says otherwise, as in HeadYaw [deg]. A
    file names all joints in its header or keys, in any order: the 25 joints, or NAOqi's 26, also as keys of ALMemory;
    times are carried to the output. A motion file of any format (see nao-kin motion) names those that it moves; there
    is a row for each of its key times, or --rate a second.

    With -o, the file may be larger than memory, and also be .csv.gz, .npy, .parquet, .arrow or .feather. What is ended
    half-way goes on where it was when it is called again.
    """
    for option, value in (("--on-error", on_error), ("--dtype", dtype)):
        if output is None and value is not None:
            raise BadArgument(f"{option} is for files; name one with --output")
    output = "/dev/stdout" if output == "-" else output
    files = file or []
    if output is not None:
        _check_output(files, output, json)
    elif len(files) > 1:
        raise BadArgument(f"{len(files)} files; several go into one --output")
    one = files[0] if len(files) == 1 else None
    # Standard input may be larger than memory with -o, and is then not looked into.
    moves = one is not None and not (one == "-" and output is not None) and is_motion(one)
    if not moves:
        refuse_motion_options(
            one or (files[0] if files else None), **_only(files, posture), rate=rate, timeline=timeline
        )
    if not files and (columns or ignore_other):
        raise BadArgument("--columns and --ignore-other are for a file; name it")
    from nao_kin import stream
    from nao_kin.stream import read_log

    model = robot.load()
    limits: LimitPolicy = "clamp" if clamp else "ignore" if ignore_limits else "raise"
    renamed = columns_of(columns)
    as_motion = posture is not None or rate is not None or timeline is not None
    log = None if one is None or as_motion else log_columns(model, one, renamed)
    moves = moves and log is None
    timed = log is not None and log.timed
    if not (moves or timed or (one == "-" and output is not None)):
        refuse_motion_options(one or (files[0] if files else None), hips=hips)
    if moves and renamed:
        raise BadArgument(f"--columns is for whole configurations; {quoted(one)} is read as a motion")
    rule: Any = "average" if hips is None and timed else hips  # as of a motion
    rows: Configurations | None = None
    if moves and one is not None:
        motion = read(model, one, deg=deg, timeline=timeline, ignore_other=ignore_other)
        path = trajectory(model, motion, posture=posture, hips=hips, rate=rate)
        rows = stream.Configurations(within_limits(model, one, path, limits, deg=deg), path.times, one)
    if output is not None:
        result = stream.fk(
            model,
            files if rows is None else rows,
            frame or _default_frames(model),
            output,
            reference=reference,
            as_=STYLES[as_],
            dtype=np.float64 if dtype is None else dtype.value,
            limits=limits if rows is None else "ignore",
            degrees=deg,
            on_error="stop" if on_error is None else on_error.value,
            columns=renamed,
            ignore_other=ignore_other,
            hips=rule if rows is None else None,
            progress=True,
        )
        _report(model, result, json)
        return
    times: Floats | None = None
    if rows is not None:
        q, times, many = rows.q, rows.times, True
    elif one is not None:
        found = read_log(
            model,
            one,
            limits="ignore" if clamp else limits,
            degrees=deg,
            columns=renamed,
            ignore_other=ignore_other,
            hips=rule,
        )
        q, times, many = clamped(model, found.q) if clamp else found.q, found.times, found.many
        for note in found.notes:
            print_note(note)
    else:
        q, many = one_configuration(model, posture, joint or [], deg, limits)[None], False
    frames = frame or _default_frames(model)
    # Before anything is printed.
    model.frame_ids(frames if reference is None or _is_world(model, reference) else [*frames, reference])
    printer = PosePrinter(frames, as_, deg, times)
    poses = _poses(model, q, frames, reference, printer.columns)
    if json:
        printer.print_json(poses, model.name, reference, many=many)
    elif csv:
        printer.print_csv(poses)
    elif many:
        printer.print_lines(poses)
    else:
        printer.print_table(poses)


def _only(files: list[str], posture: str | None) -> dict[str, str | None]:
    """The options that go with a motion alone where there is a file."""
    return {"posture": posture} if files else {}


def _check_output(files: list[str], output: str, json: bool) -> None:
    """Refuse a file that could not be written, before anything is loaded."""
    if not files:
        raise BadArgument("--output is for the rows of a file; name the FILE to read")
    check_sinks("--json" if json else None, output=output)


def _report(model: RobotModel, result: StreamResult, json: bool) -> None:
    """What was written, and on standard error what could not be, and what was changed."""
    if json:
        print_json(result.as_dict())
    elif not atomic.leads_to_standard_output(result.sink):  # which has the poses, and nothing behind them
        print(result.sink)
    for note in result.notes:
        print_note(note)
    note_clamped(model, result.clamped, result.rows_read)
    if result.rows_resumed:
        print_note(f"the first {result.rows_resumed} rows had been done by an earlier run")
    if result.bad_rows:
        done = "left out" if result.rows_written < result.rows_read else "written as nan"
        print_note(f"{result.bad_rows} bad rows of {result.rows_read} {done}:")
        for bad in result.first_bad_rows:
            print_note(f"  {bad}")
        if result.bad_rows > len(result.first_bad_rows):
            print_note(f"  and {result.bad_rows - len(result.first_bad_rows)} more")


def one_configuration(
    model: RobotModel, posture: str | None, settings: list[str], deg: bool, limits: LimitPolicy
) -> Floats:
    """The configuration that --posture and --joint describe; without a posture only the named joints face limits."""
    values = _joint_values(model, settings, deg)
    try:
        if posture is None:
            return model.configuration(values, limits=limits)
        if not model.posture_names:
            raise BadArgument(f"--posture {quoted(posture)}: {model.name} has no predefined postures")
        return model.posture(posture, values, limits=limits)
    except OutsideLimits as error:
        advice = "; --clamp and --ignore-limits take it"
        # So large an angle is one in degrees.
        advice += ", --deg?" if not deg and any(abs(value) > 2.0 * math.pi for value in values.values()) else ""
        raise BadArgument(error.describe(degrees=deg) + advice) from None
    except CouplingViolated as error:
        raise BadArgument(error.describe(degrees=deg)) from None


def _joint_values(model: RobotModel, settings: list[str], deg: bool) -> dict[str, float]:
    """The values that --joint gives, by name [rad, m or ratio]."""
    values: dict[str, float] = {}
    for setting in settings:
        name, _, text = setting.partition("=")
        name = name.strip()
        try:
            value = decimal(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise BadArgument(f"--joint {quoted(setting)}: expected NAME=VALUE with a number, as in HeadYaw=0.3")
        if name in values:
            raise BadArgument(f"--joint names {abbreviated(name)} twice")
        values[name] = math.radians(value) if deg and model.unit(name) == "rad" else value
    return values


def _default_frames(model: RobotModel) -> list[str]:
    return [*model.semantics.end_effectors, *model.semantics.cameras] or list(model.link_names)


def _is_world(model: RobotModel, reference: str) -> bool:
    """Whether `reference` is the world, and not a link of that name."""
    return reference == _WORLD and _WORLD not in model.frame_names


def _poses(model: RobotModel, q: Floats, frames: list[str], reference: str | None, columns: PoseColumns) -> Pieces:
    """First row and poses (n, frames, k) of one piece after another, with a progress bar when there are many."""
    from rich.console import Console
    from rich.progress import track

    from nao_kin import stream

    many = len(q) > stream.FEW_ROWS
    threads = usable_cores() if many else None
    errors = Console(file=sys.stderr)
    hidden = not many or not errors.is_terminal
    starts = range(0, len(q), _CHUNK)
    for start in track(starts, "forward kinematics", console=errors, disable=hidden, transient=True):
        yield start, columns.poses(model, q[start : start + _CHUNK], frames, reference, threads=threads)
