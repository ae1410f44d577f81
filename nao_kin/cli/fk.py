"""`nao-kin fk`: where the frames are at given joint values."""

from __future__ import annotations

import math
import sys
from typing import TYPE_CHECKING, Annotated

import typer

from nao_kin._common.arrays import Floats
from nao_kin._common.scalars import decimal
from nao_kin._text import abbreviated, quoted
from nao_kin.cli.options import DegOption, JsonOption, RobotOption, UrdfOption, VersionOption, load
from nao_kin.cli.poses import Pieces, PoseFormat, PosePrinter
from nao_kin.errors import BadArgument, CouplingViolated, OutsideLimits

if TYPE_CHECKING:
    from nao_kin.robot import LimitPolicy, RobotModel

# One pass of the progress bar; small enough to move often, large enough to cost nothing.
_CHUNK = 2000
_WORLD = "world"


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
    as_: Annotated[PoseFormat, typer.Option("--as", help="How to print a pose.")] = PoseFormat.rpy,
    deg: DegOption = False,
    clamp: Annotated[bool, typer.Option("--clamp", help="Move joints outside their limits to the limit.")] = False,
    ignore_limits: Annotated[bool, typer.Option("--ignore-limits", help="Take joints wherever they are.")] = False,
    csv: Annotated[bool, typer.Option("--csv", help="Print CSV.")] = False,
    json: JsonOption = False,
    version: VersionOption = "v6",
    urdf: UrdfOption = None,
    robot: RobotOption = None,
) -> None:
    """Poses of frames at given joint values: one configuration, or every row of a file.

    Values are radians (hands: 0 closed to 1 open) unless --deg is given. A file names all joints in its header or
    keys, in any order: the 25 joints, or NAOqi's 26.
    """
    model = load(version, urdf, robot)
    limits: LimitPolicy = "clamp" if clamp else "ignore" if ignore_limits else "raise"
    if file is None:
        q, many = one_configuration(model, posture, joint or [], deg, limits)[None], False
    else:
        from nao_kin.configuration_files import read_configurations

        q, many = read_configurations(model, file, limits=limits, degrees=deg)
    frames = frame or _default_frames(model)
    # Before anything is printed.
    model.frame_ids(frames if reference is None or _is_world(model, reference) else [*frames, reference])
    poses = _poses(model, q, frames, reference)
    printer = PosePrinter(frames, as_, deg)
    if json:
        printer.print_json(poses, model.name, reference, many=many)
    elif csv:
        printer.print_csv(poses)
    elif many:
        printer.print_lines(poses)
    else:
        printer.print_table(poses)


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
        q = model.posture(posture)
        given = model.configuration(values, limits="ignore")
        drivers = {model.mimics[name].joint if name in model.mimics else name for name in values}
        columns = [model.joint_names.index(name) for name in drivers]
        q[columns] = given[columns]
        return q if limits == "ignore" else model.clamp(q) if limits == "clamp" else model.check_limits(q)
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


def _poses(model: RobotModel, q: Floats, frames: list[str], reference: str | None) -> Pieces:
    """First row and poses (n, frames, 4, 4) of one piece after another, with a progress bar when there are many."""
    starts = range(0, len(q), _CHUNK)
    if len(starts) == 1:
        yield 0, model.fk(q, frames, reference=reference)
        return
    from rich.console import Console
    from rich.progress import track

    errors = Console(file=sys.stderr)
    for start in track(starts, "forward kinematics", console=errors, disable=not errors.is_terminal, transient=True):
        yield start, model.fk(q[start : start + _CHUNK], frames, reference=reference)
