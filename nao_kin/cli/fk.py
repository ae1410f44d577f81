"""`nao-kin fk`: where the frames are at given joint values."""

from __future__ import annotations

import math
import sys
import tempfile
from contextlib import ExitStack
from enum import Enum
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from nao_kin._common import atomic
from nao_kin._common.arrays import Floats
from nao_kin._common.processors import usable_cores
from nao_kin._common.scalars import decimal
from nao_kin._text import abbreviated, quoted
from nao_kin.cli.motion_input import is_motion, read, refuse_motion_options, trajectory, within_limits
from nao_kin.cli.options import (
    DegOption,
    HipsOption,
    JsonOption,
    OffsetsOption,
    PackageDirOption,
    RateOption,
    RobotOption,
    TimelineOption,
    UrdfOption,
    VersionOption,
    load,
)
from nao_kin.cli.output import print_json, print_note
from nao_kin.cli.poses import STYLES, Pieces, PoseFormat, PosePrinter
from nao_kin.errors import BadArgument, CouplingViolated, OutsideLimits

if TYPE_CHECKING:
    from nao_kin.robot import LimitPolicy, RobotModel
    from nao_kin.stream import PoseColumns, StreamResult

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


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("fk", epilog=_EXAMPLES)(fk)


def fk(
    file: Annotated[
        str | None,
        typer.Argument(metavar="FILE", help="CSV or JSON file of configurations, or a motion; - for standard input."),
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
        typer.Option("--output", "-o", metavar="FILE", help="Write .parquet, .arrow, .feather, .npy or .csv."),
    ] = None,
    on_error: Annotated[
        ErrorChoice | None, typer.Option("--on-error", help="With -o: what to do with a bad row. Default: stop.")
    ] = None,
    dtype: Annotated[
        NumberChoice | None, typer.Option("--dtype", help="With -o: size of the numbers. Default: float64.")
    ] = None,
    rate: RateOption = None,
    hips: HipsOption = None,
    timeline: TimelineOption = None,
    json: JsonOption = False,
    version: VersionOption = "v6",
    urdf: UrdfOption = None,
    robot: RobotOption = None,
    package_dir: PackageDirOption = None,
    offsets: OffsetsOption = None,
) -> None:
    """Poses of frames at given joint values: one configuration, or every row of a file.

    Values are radians (hands: 0 closed to 1 open) unless --deg is given. A file names all joints in its header or
    keys, in any order: the 25 joints, or NAOqi's 26. A motion file of any format (see nao-kin motion) names those that
    it moves; there is a row for each of its key times, or --rate a second.

    With -o, the file may be larger than memory, and also be .npy, .parquet, .arrow or .feather. What is ended
    half-way goes on where it was when it is called again.
    """
    for option, value in (("--on-error", on_error), ("--dtype", dtype)):
        if output is None and value is not None:
            raise BadArgument(f"{option} is for files; name one with --output")
    if output is not None:
        _check_output(file, output, json)
    # Standard input may be larger than memory with -o, and is then not looked into.
    moves = file is not None and not (file == "-" and output is not None) and is_motion(file)
    if not moves:
        only_file = {} if file is None else {"posture": posture}
        refuse_motion_options(file, **only_file, rate=rate, hips=hips, timeline=timeline)
    model = load(version, urdf, robot, package_dir, offsets)
    limits: LimitPolicy = "clamp" if clamp else "ignore" if ignore_limits else "raise"
    motion_q: Floats | None = None
    if moves and file is not None:
        path = trajectory(model, read(model, file, deg=deg, timeline=timeline), posture=posture, hips=hips, rate=rate)
        motion_q = within_limits(model, file, path, limits, deg=deg)
    if output is not None and file is not None:
        from nao_kin import stream

        with ExitStack() as context:
            source, taken = file, limits
            if motion_q is not None:
                folder = context.enter_context(tempfile.TemporaryDirectory(prefix="nao_kin-"))
                source, taken = f"{folder}/configurations.npy", "ignore"
                np.save(source, motion_q)
            result = stream.fk(
                model,
                source,
                frame or _default_frames(model),
                output,
                reference=reference,
                as_=STYLES[as_],
                dtype=np.float64 if dtype is None else dtype.value,
                limits=taken,
                degrees=deg,
                on_error="stop" if on_error is None else on_error.value,
                progress=True,
            )
        _report(result, json)
        return
    if file is None:
        q, many = one_configuration(model, posture, joint or [], deg, limits)[None], False
    elif motion_q is not None:
        q, many = motion_q, True
    else:
        from nao_kin.configuration_files import read_configurations

        q, many = read_configurations(model, file, limits=limits, degrees=deg)
    frames = frame or _default_frames(model)
    # Before anything is printed.
    model.frame_ids(frames if reference is None or _is_world(model, reference) else [*frames, reference])
    printer = PosePrinter(frames, as_, deg)
    poses = _poses(model, q, frames, reference, printer.columns)
    if json:
        printer.print_json(poses, model.name, reference, many=many)
    elif csv:
        printer.print_csv(poses)
    elif many:
        printer.print_lines(poses)
    else:
        printer.print_table(poses)


def _check_output(file: str | None, output: str, json: bool) -> None:
    """Refuse a file that could not be written, before anything is loaded."""
    if file is None:
        raise BadArgument("--output is for the rows of a file; name the FILE to read")
    atomic.check_writable(output)
    if json and atomic.leads_to_standard_output(output):
        raise BadArgument(f"--output {output} and --json both write to standard output; give one")


def _report(result: StreamResult, json: bool) -> None:
    """What was written, and on standard error what could not be."""
    if json:
        print_json(result.as_dict())
    elif not atomic.leads_to_standard_output(result.sink):  # which has the poses, and nothing behind them
        print(result.sink)
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
    except (OutsideLimits, CouplingViolated) as error:
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
