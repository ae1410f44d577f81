"""`nao-kin fk`: where the frames are at given joint values."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from enum import Enum
from typing import TYPE_CHECKING, Annotated

import typer

from nao_kin._arrays import Floats
from nao_kin._scalars import decimal
from nao_kin.cli.options import Deg, Json, Robot, Urdf, Version, load
from nao_kin.cli.output import print_json, print_json_list, print_table
from nao_kin.cli.poses import PoseFormat, pose_columns, pose_numbers
from nao_kin.errors import BadArgument, CouplingViolated, OutsideLimits

if TYPE_CHECKING:
    from nao_kin.robot import RobotModel
    from nao_kin.robot.model import LimitPolicy

# One pass of the progress bar; small enough to move often, large enough to cost nothing.
_CHUNK = 2000


class As(str, Enum):
    """How a pose is printed."""

    matrix = "matrix"
    position6d = "position6d"
    rpy = "rpy"
    quaternion = "quaternion"


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("fk", epilog="Example: nao-kin fk --posture StandInit --joint HeadYaw=0.3 --frame CameraTop --json")(fk)


def fk(
    file: Annotated[
        str | None, typer.Argument(metavar="FILE", help="CSV or JSON file of configurations, - for standard input.")
    ] = None,
    posture: Annotated[str | None, typer.Option(metavar="NAME", help="Start from a predefined posture.")] = None,
    joint: Annotated[
        list[str] | None, typer.Option(metavar="NAME=VALUE", help="Set a joint; repeatable. Others are at zero.")
    ] = None,
    frame: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="A frame to locate; repeatable. Default: the effectors.")
    ] = None,
    reference: Annotated[str | None, typer.Option(metavar="NAME", help="The frame to express poses in.")] = None,
    as_: Annotated[As, typer.Option("--as", help="How to print a pose.")] = As.rpy,
    deg: Deg = False,
    clamp: Annotated[bool, typer.Option("--clamp", help="Move joints outside their limits to the limit.")] = False,
    ignore_limits: Annotated[bool, typer.Option("--ignore-limits", help="Take joints wherever they are.")] = False,
    csv: Annotated[bool, typer.Option("--csv", help="Print CSV.")] = False,
    json: Json = False,
    version: Version = "v6",
    urdf: Urdf = None,
    robot: Robot = None,
) -> None:
    """Poses of frames at given joint values: one configuration, or every row of a file.

    Values are radians (hands: 0 closed to 1 open) unless --deg is given. A file names all joints in its header or
    keys, in any order: the 25 joints, or NAOqi's 26.
    """
    if csv and json:
        raise BadArgument("--csv and --json are two formats; give one")
    if clamp and ignore_limits:
        raise BadArgument("--clamp and --ignore-limits contradict each other; give one")
    if file is not None and (posture is not None or joint):
        raise BadArgument("a file gives whole configurations; leave out --posture and --joint")
    model = load(version, urdf, robot)
    limits: LimitPolicy = "clamp" if clamp else "ignore" if ignore_limits else "raise"
    if file is None:
        try:
            q, many = one_configuration(model, posture, joint or [], deg, limits)[None], False
        except (OutsideLimits, CouplingViolated) as error:
            raise BadArgument(error.describe(degrees=deg)) from None
    else:
        from nao_kin.configuration_files import read_configurations

        q, many = read_configurations(model, file, limits=limits, degrees=deg)
    frames = frame or _default_frames(model)
    model.fk(q[0], frames, reference=reference)  # refuses unknown frames before anything is printed
    chunks = _poses(model, q, frames, reference)
    style = PoseFormat(as_.value)
    if json:
        _print_json(model, chunks, frames, reference, style, deg, many)
    elif csv:
        _print_csv(chunks, frames, style, deg)
    else:
        _print_table(chunks, frames, style, deg, many)


def one_configuration(
    model: RobotModel, posture: str | None, settings: list[str], deg: bool, limits: LimitPolicy
) -> Floats:
    """The configuration that --posture and --joint describe; without a posture only the named joints face limits."""
    from nao_kin.nao import NaoModel

    values: dict[str, float] = {}
    for setting in settings:
        name, separator, text = setting.partition("=")
        name = name.strip()
        try:
            value = decimal(text)
        except ValueError:
            separator = ""
        if not separator:
            raise BadArgument(f"--joint {setting!r}: expected NAME=VALUE with a number, as in HeadYaw=0.3")
        if name in values:
            raise BadArgument(f"--joint names {name} twice")
        values[name] = math.radians(value) if deg and model.unit(name) == "rad" else value
    if posture is None:
        return model.configuration(values, limits=limits)
    if not isinstance(model, NaoModel):
        raise BadArgument(f"--posture is for NAO; {model.name} has no predefined postures")
    start = model.angles(model.posture(posture))
    for name in values:
        start.pop(model.mimics[name].joint if name in model.mimics else name, None)
    return model.configuration({**start, **values}, limits=limits)


def _default_frames(model: RobotModel) -> list[str]:
    effectors = ["Head", "LArm", "RArm", "LLeg", "RLeg", "CameraTop", "CameraBottom"]
    return effectors if set(effectors) <= set(model.frame_names) else list(model.link_names)


def _poses(model: RobotModel, q: Floats, frames: list[str], reference: str | None) -> Iterator[tuple[int, Floats]]:
    """First row and poses (n, frames, 4, 4) of one chunk after another, with a progress bar when there are many."""
    starts = range(0, len(q), _CHUNK)
    if len(starts) == 1:
        yield 0, model.fk(q, frames, reference=reference)
        return
    from rich.console import Console
    from rich.progress import track

    errors = Console(file=sys.stderr)
    for start in track(starts, "forward kinematics", console=errors, disable=not errors.is_terminal, transient=True):
        yield start, model.fk(q[start : start + _CHUNK], frames, reference=reference)


def _print_json(
    model: RobotModel,
    chunks: Iterator[tuple[int, Floats]],
    frames: list[str],
    reference: str | None,
    style: PoseFormat,
    deg: bool,
    many: bool,
) -> None:
    head = {
        "robot": model.name,
        "reference": reference or "root",
        "as": style.value,
        "units": {"length": "m", "angle": "deg" if deg else "rad"},
    }
    poses = (
        {name: _as_json(row, style, deg) for name, row in zip(frames, rows, strict=True)}
        for _, chunk in chunks
        for rows in pose_numbers(chunk, style, degrees=deg).tolist()
    )
    if many:
        print_json_list(head, "configurations", poses)
    else:
        print_json({**head, "poses": next(poses)})


def _as_json(row: list[float], style: PoseFormat, deg: bool) -> object:
    if style is PoseFormat.MATRIX:
        return [row[i : i + 4] for i in range(0, 16, 4)]
    return dict(zip(pose_columns(style, degrees=deg), row, strict=True))


def _print_csv(chunks: Iterator[tuple[int, Floats]], frames: list[str], style: PoseFormat, deg: bool) -> None:
    import csv

    writer = csv.writer(sys.stdout, lineterminator="\n")
    writer.writerow(("row", "frame", *pose_columns(style, degrees=deg)))
    for start, poses in chunks:
        for offset, rows in enumerate(pose_numbers(poses, style, degrees=deg).tolist()):
            writer.writerows((start + offset, name, *row) for name, row in zip(frames, rows, strict=True))


def _print_table(
    chunks: Iterator[tuple[int, Floats]], frames: list[str], style: PoseFormat, deg: bool, many: bool
) -> None:
    if many:
        _print_lines(chunks, frames, style, deg)
        return
    matrix = style is PoseFormat.MATRIX
    columns = ("x axis", "y axis", "z axis", "origin\n[m]") if matrix else _headings(style, deg)
    rows = []
    for _, poses in chunks:
        for name, row in zip(frames, pose_numbers(poses[0], style, degrees=deg).tolist(), strict=True):
            cells = [_fixed(value) for value in row]
            if matrix:  # the 4×4 matrix as it is written on paper; its columns are the axes and the origin
                cells = ["\n".join(cells[column::4]) for column in range(4)]
            rows.append([name, *cells])
    print_table(["frame", *columns], rows, numbers=columns)


def _print_lines(chunks: Iterator[tuple[int, Floats]], frames: list[str], style: PoseFormat, deg: bool) -> None:
    """One line per row and frame as they come: nobody waits for a table of many thousand rows to be laid out."""
    width = max(5, *map(len, frames))
    columns = pose_columns(style, degrees=deg)
    print(f"{'row':>7}  {'frame':{width}}" + "".join(f"{name:>11}" for name in columns))
    for start, poses in chunks:
        for offset, numbers in enumerate(pose_numbers(poses, style, degrees=deg).tolist()):
            for name, row in zip(frames, numbers, strict=True):
                print(f"{start + offset:>7}  {name:{width}}" + "".join(f"{_fixed(value):>11}" for value in row))


def _fixed(value: float) -> str:
    # Adding zero takes the sign off a negative zero.
    return f"{round(value, 5) + 0.0:.5f}"


def _headings(style: PoseFormat, deg: bool) -> tuple[str, ...]:
    unit = "" if style is PoseFormat.QUATERNION else "\n[°]" if deg else "\n[rad]"
    names = pose_columns(style, degrees=False)
    return (*(f"{name}\n[m]" for name in names[:3]), *(name + unit for name in names[3:]))
