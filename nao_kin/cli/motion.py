"""`nao-kin motion`: motion files converted, checked, described and drawn."""

from __future__ import annotations

import io
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nao_kin._core import files as atomic
from nao_kin._core.arrays import Floats
from nao_kin._core.files import read_bounded
from nao_kin._core.text import abbreviated, quoted
from nao_kin.cli.options import (
    HipsOption,
    IgnoreOtherOption,
    JsonOption,
    RobotOptions,
    TimelineOption,
    command,
    print_json,
    print_note,
    print_table,
)
from nao_kin.errors import BadArgument, BadInputFile

if TYPE_CHECKING:
    from nao_kin._core.csv_numbers import TableColumns
    from nao_kin.motion import Change, Motion, MotionReport, MotionViolation, Trajectory
    from nao_kin.robot import LimitPolicy, RobotModel
    from nao_kin.stream import Clamped


# --- Motion files as commands take them beside plain configuration files.


def is_motion(file: str) -> bool:
    """Whether a file, "-" for standard input, holds a motion; standard input can be read again afterwards.

    Raises:
        BadInputFile: standard input is a pipe or device of more than 2³⁰ bytes, which may have no end.
    """
    from nao_kin.motion import is_motion_file

    if file != "-":
        return is_motion_file(file)
    if sys.stdin is None:
        return False
    try:
        data = read_bounded(sys.stdin.buffer, file)
    except OSError:
        return False  # which is said where it is read
    sys.stdin = io.TextIOWrapper(io.BytesIO(data), encoding="utf-8")
    return is_motion_file("-", data)


def log_columns(model: RobotModel, file: str, columns: dict[str, str | None] | None) -> TableColumns | None:
    """The columns of a file whose rows are whole configurations; None for other files, and input not read yet."""
    from nao_kin.stream import log_columns

    data = None
    if file == "-":
        buffer = getattr(sys.stdin, "buffer", None)
        if not isinstance(buffer, io.BytesIO):
            return None
        data = buffer.getvalue()
    return log_columns(model, file, columns=columns, data=data)


def refuse_motion_options(file: str | None, **given: object) -> None:
    """Refuse options that only a motion file takes, where there is another file or none.

    Raises:
        BadArgument: with the first of them that is not None.
    """
    for option, value in given.items():
        if value is None:
            continue
        if file is None:
            raise BadArgument(f"--{option} is for a motion; name its FILE")
        if option == "posture":
            raise BadArgument("a file gives whole configurations; leave out --posture and --joint")
        raise BadArgument(f"--{option} is for a motion, and {quoted(file)} has no times: it gives whole configurations")


def read(
    model: RobotModel,
    file: str,
    *,
    deg: bool,
    timeline: str | None = None,
    format_: str | None = None,
    ignore_other: bool = False,
) -> Motion:
    """The motion in a file, of joints of a robot."""
    from nao_kin.motion import read_motion

    return read_motion(file, format=format_, degrees=deg, timeline=timeline, robot=model, ignore_other=ignore_other)


def trajectory(
    model: RobotModel, motion: Motion, *, posture: str | None, hips: str | None, rate: float | None
) -> Trajectory:
    """The configurations that a motion goes through."""
    from nao_kin.motion import HOLD

    check_posture(model, posture)
    return motion.configurations(
        model,
        rate=rate,
        fill=HOLD if posture is None else posture,
        hips="average" if hips is None else hips,  # type: ignore[arg-type]
    )


def check_posture(model: RobotModel, posture: str | None) -> None:
    """Refuse a posture of a robot that has none."""
    if posture is not None and not model.posture_names:
        raise BadArgument(f"--posture {quoted(posture)}: {model.name} has no predefined postures")


def clamped(model: RobotModel, q: Floats) -> Floats:
    """Configurations moved inside the limits, and a note that says how many, and how far."""
    from nao_kin import stream

    inside, changes = stream.clamp(model, q)
    note_clamped(model, changes, len(q))
    return inside


def note_clamped(model: RobotModel, changes: Clamped, rows: int) -> None:
    """Say what --clamp has changed."""
    if changes.rows:
        unit = model.unit(changes.joint)
        most = f"{changes.most:.3g}{'' if unit == '1' else f' {unit}'}"
        print_note(f"--clamp moved {changes.rows} of {rows} rows to the limits, by at most {most} ({changes.joint})")


def within_limits(model: RobotModel, file: str, path: Trajectory, limits: LimitPolicy, *, deg: bool) -> Floats:
    """The configurations of a motion, none outside the limits.

    Raises:
        BadInputFile: one is; says when.
    """
    if limits == "ignore":
        return path.q
    if limits == "clamp":
        return clamped(model, path.q)
    violations = model.limit_violations(path.q, most=1)
    if violations:
        first = violations[0]
        when = f"{path.times[first.index[0]]:.6g} s"
        reason = f"at {when} outside the joint limits: {first.describe(degrees=deg, index=False)}"
        raise BadInputFile(file, f"{reason}; nao-kin motion check lists all, --clamp and --ignore-limits take it")
    return path.q


# --- `nao-kin motion`: motion files converted, checked, described and drawn.

FileArgument = Annotated[str, typer.Argument(metavar="FILE", help="A motion file of any format, - for standard input.")]
FromOption = Annotated[
    str | None, typer.Option("--from", metavar="FORMAT", help="Format of FILE. Default: by its content.")
]
PostureOption = Annotated[
    str | None, typer.Option("--posture", metavar="NAME", help="Where joints are that the motion does not name.")
]
InputDegOption = Annotated[
    bool, typer.Option("--deg", help="Angles of FILE in degrees, where it does not say; and of what is printed.")
]

app = typer.Typer(
    name="motion",
    epilog="Example: nao-kin motion convert wave.xar wave.csv --clamp --slow-down",
    invoke_without_command=True,
    rich_markup_mode=None,
)


@app.callback()
def _motion(context: typer.Context) -> None:
    """Motion files: converted, checked, described and drawn.

    Formats are told by content and suffix: csv, json, npz, webots, runswift, hulks, motion2, naodevils, bhuman
    (both only read), python (Choregraphe export), xar and naoqi (arguments of angleInterpolation).
    """
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


@command("motion convert", "Example: nao-kin motion convert wave.xar wave.csv --clamp --slow-down")
def convert(
    *,
    source: Annotated[str, typer.Argument(metavar="IN", help="A motion file, - for standard input.")],
    sink: Annotated[str, typer.Argument(metavar="OUT", help="The file to write, - for standard output.")],
    from_: FromOption = None,
    to: Annotated[
        str | None, typer.Option("--to", metavar="FORMAT", help="Format of OUT. Default: by its suffix.")
    ] = None,
    deg: InputDegOption = False,
    timeline: TimelineOption = None,
    ignore_other: IgnoreOtherOption = False,
    hips: HipsOption = None,
    posture: Annotated[
        str | None, typer.Option("--posture", metavar="NAME", help="Add the joints it does not name, at rest there.")
    ] = None,
    mirror: Annotated[bool, typer.Option("--mirror", help="Exchange left and right.")] = False,
    reverse: Annotated[bool, typer.Option("--reverse", help="Run it backwards.")] = False,
    stretch: Annotated[
        float | None, typer.Option("--stretch", metavar="F", help="Let it take F times as long.")
    ] = None,
    loop: Annotated[int | None, typer.Option("--loop", metavar="N", help="Repeat it N times.")] = None,
    gap: Annotated[
        float | None, typer.Option("--gap", metavar="S", help="With --loop: seconds from the end to the beginning.")
    ] = None,
    clamp: Annotated[bool, typer.Option("--clamp", help="Move it into the limits and the coupled limits.")] = False,
    slow_down: Annotated[
        bool, typer.Option("--slow-down", help="Stretch time where a joint would be too fast.")
    ] = False,
    rate: Annotated[
        float | None, typer.Option("--rate", metavar="N", help="Write N samples per second instead of the keys.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace OUT where it exists.")] = False,
    json: JsonOption = False,
    robot: RobotOptions,
) -> None:
    """Write a motion in another format, changed on the way if asked for; what is changed is said.

    In this order: --hips, --posture, --mirror, --reverse, --stretch, --loop, --clamp, --slow-down, --rate.
    """
    from nao_kin import motion as motions

    if gap is not None and loop is None:
        raise BadArgument("--gap is the pause of --loop; give both")
    sink = "/dev/stdout" if sink == "-" else sink
    _check_sink(sink, force, json)
    model = robot.load()
    check_posture(model, posture)
    motion = read(model, source, deg=deg, timeline=timeline, format_=from_, ignore_other=ignore_other)
    changes = list[motions.Change]()
    if hips is not None:
        motion = _mended(motions.share_motors(model, motion, hips), changes)  # type: ignore[arg-type]
    if posture is not None:
        motion = motions.complete(model, motion, posture)
    motion = motions.mirror(model, motion) if mirror else motion
    motion = motions.reverse(motion) if reverse else motion
    motion = motion if stretch is None else motions.time_warp(motion, stretch)
    motion = motion if loop is None else motions.loop(motion, loop, gap=gap or 0.0)
    motion = _mended(motions.clamp(model, motion), changes) if clamp else motion
    motion = _mended(motions.slow_down(model, motion), changes) if slow_down else motion
    motions.write_motion(motion, sink, format=to, rate=rate, overwrite=True)
    if json:
        print_json({**_facts(motion), "output": sink, "changes": [change.as_dict() for change in changes]})
        return
    for change in changes:
        print_note(change.describe(degrees=deg))
    if not atomic.leads_to_standard_output(sink):
        print(sink)


@command("motion check", "Example: nao-kin motion check wave.motion --deg")
def check(
    *,
    file: FileArgument,
    from_: FromOption = None,
    deg: InputDegOption = False,
    timeline: TimelineOption = None,
    ignore_other: IgnoreOtherOption = False,
    posture: PostureOption = None,
    rate: Annotated[
        float | None, typer.Option("--rate", metavar="N", help="Samples per second of what has no closed form.")
    ] = None,
    every: Annotated[bool, typer.Option("--all", help="List every stretch, not only the worst of a joint.")] = False,
    json: JsonOption = False,
    robot: RobotOptions,
) -> None:
    """Limits, coupled limits, speeds, and joints of one motor, between the keys too; exit 1 when one is not kept."""
    from nao_kin import motion as motions

    model = robot.load()
    check_posture(model, posture)
    motion = read(model, file, deg=deg, timeline=timeline, format_=from_, ignore_other=ignore_other)
    chosen: dict[str, Any] = {} if rate is None else {"rate": rate}
    report = motions.check(model, motion, fill=motions.HOLD if posture is None else posture, **chosen)
    if json:
        print_json(report.as_dict())
    else:
        _print_report(report, deg=deg, every=every)
    if not report.ok:
        raise typer.Exit(1)


@command("motion info", "Example: nao-kin motion info wave.xar --json")
def info(
    *,
    file: FileArgument,
    from_: FromOption = None,
    deg: InputDegOption = False,
    timeline: TimelineOption = None,
    ignore_other: IgnoreOtherOption = False,
    json: JsonOption = False,
    robot: RobotOptions,
) -> None:
    """Joints, keys, times and ranges of a motion."""
    model = robot.load()
    motion = read(model, file, deg=deg, timeline=timeline, format_=from_, ignore_other=ignore_other)
    rows = _joint_rows(model, motion, deg=deg)
    if json:
        print_json({**_facts(motion), "rows": rows})
        return
    columns = ("joint", "keys", "from\n[s]", "to\n[s]", "least", "most", "unit")
    print_table(columns, [[_cell(value) for value in row.values()] for row in rows], numbers=columns[1:6])
    count = len(rows)
    print(f"{count} joint{'s' if count > 1 else ''}, {motion.interpolation}, {motion.duration:.6g} s")


@command("motion plot", "Example: nao-kin motion plot wave.xar wave.png --joint LShoulderRoll")
def plot(
    *,
    file: FileArgument,
    picture: Annotated[str, typer.Argument(metavar="PICTURE", help="The .png or .svg file to write.")],
    joints: Annotated[
        list[str] | None, typer.Option("--joint", metavar="NAME", help="Draw this joint; repeatable. Default: all.")
    ] = None,
    speed: Annotated[bool, typer.Option("--speed", help="Draw speeds instead of values.")] = False,
    from_: FromOption = None,
    deg: Annotated[bool, typer.Option("--deg", help="Angles of FILE in degrees, where it does not say.")] = False,
    timeline: TimelineOption = None,
    ignore_other: IgnoreOtherOption = False,
    force: Annotated[bool, typer.Option("--force", help="Replace PICTURE where it exists.")] = False,
    json: JsonOption = False,
    robot: RobotOptions,
) -> None:
    """Draw every joint over time between its limits, in degrees; what is outside in red."""
    from nao_kin.motion import plot as draw

    kind = Path(picture).suffix.lower().removeprefix(".")
    if kind not in ("png", "svg"):
        raise BadArgument(f"cannot write {abbreviated(picture)}: end the name in .png or .svg")
    _check_sink(picture, force, json)
    model = robot.load()
    motion = read(model, file, deg=deg, timeline=timeline, format_=from_, ignore_other=ignore_other)
    figure = draw(model, motion, joints=joints, speed=speed)
    content = io.BytesIO()
    figure.savefig(content, format=kind, dpi=120)
    atomic.write_bytes(picture, content.getvalue())
    if json:
        print_json({"picture": picture, "joints": list(joints or motion.joint_names)})
    else:
        print(picture)


def _check_sink(path: str, force: bool, json: bool) -> None:
    """Refuse a file that exists or cannot be written, before anything is read."""
    atomic.check_writable(path)
    target = atomic.replaced_file(path)
    if target is not None and target.exists() and not force:
        raise BadArgument(f"{abbreviated(path)} exists; --force replaces it")
    if json and atomic.leads_to_standard_output(path):
        raise BadArgument(f"{path} and --json both write to standard output; give one")


def _mended(mended: Any, changes: list[Change]) -> Motion:
    changes += mended.changes
    found: Motion = mended.motion
    return found


def _facts(motion: Motion) -> dict[str, Any]:
    return {
        "joints": list(motion.joint_names),
        "interpolation": motion.interpolation,
        "start": motion.start,
        "end": motion.end,
        "keys": sum(map(len, motion.keys)),
    }


def _joint_rows(model: RobotModel, motion: Motion, *, deg: bool) -> list[dict[str, Any]]:
    rows = []
    for column, name in enumerate(motion.joint_names):
        times, keys = motion.times[column], motion.keys[column]
        unit = model.unit(name)
        scale, unit = (math.degrees(1.0), "deg") if deg and unit == "rad" else (1.0, unit)
        span = {"start": float(times[0]), "end": float(times[-1])}
        rows.append(
            {
                "joint": name,
                "keys": len(keys),
                **span,
                "least": float(keys.min()) * scale,
                "most": float(keys.max()) * scale,
                "unit": unit,
            }
        )
    return rows


def _print_report(report: MotionReport, *, deg: bool, every: bool) -> None:
    if not report.ok:
        rows = report.violations if every else report.worst
        columns = ("what", "joint", "from\n[s]", "to\n[s]", "worst at\n[s]", "value", "allowed", "outside by")
        print_table(columns, [_report_cells(row, deg) for row in rows], numbers=(*columns[2:6], columns[7]))
        more = len(report.violations) - len(rows)
        if more:
            print(f"and {more} more stretches of these joints (--all lists them)")
    lines = report.describe(degrees=deg).splitlines()
    print(lines[0])
    if report.sampled is not None and not report.ok:
        print(lines[-1])


def _report_cells(row: MotionViolation, deg: bool) -> list[str]:
    turns = deg and row.unit.startswith("rad")
    scale = math.degrees(1.0) if turns else 1.0
    unit = row.unit.replace("rad", "°") if turns else {"1": "", "1/s": " /s"}.get(row.unit, f" {row.unit}")
    if row.kind == "motor":
        allowed = f"as {row.of} = {_cell(row.lower * scale)}"
    else:
        allowed = f"{_cell(row.lower * scale)} … {_cell(row.upper * scale)}"
        allowed += f" at {row.of} = {_cell(row.of_value * scale)}" if row.of is not None else ""
    times = [_cell(value) for value in (row.start, row.end, row.time)]
    return [row.kind, row.joint, *times, _cell(row.value * scale), allowed, f"{row.excess * scale:.3g}{unit}"]


def _cell(value: object) -> str:
    return f"{value + 0.0:.5g}" if isinstance(value, float) else str(value)
