"""`nao-kin motion`: convert, check, describe and draw motion files."""

from __future__ import annotations

import io
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import typer

from nao_kin._core import files as atomic
from nao_kin._core.sides import Hips
from nao_kin._core.text import abbreviated
from nao_kin.cli.options import (
    ALLOW,
    COLUMNS,
    EXACT,
    HIPS,
    JSON,
    MISSING,
    OUTSIDE,
    TOLERANCE,
    Group,
    OutOptions,
    OutputOptions,
    RobotOptions,
    command,
    flag,
    option,
)
from nao_kin.cli.output import degrees_per, print_json, print_note, print_table, print_written
from nao_kin.cli.sources import MotionFile, check_posture, pairs_of, recorded, refuse_both
from nao_kin.errors import BadArgument

if TYPE_CHECKING:
    from nao_kin.motion import Motion, MotionReport, MotionViolation
    from nao_kin.robot import RobotModel


app = typer.Typer(
    name="motion",
    cls=Group,
    epilog="Example: nao-kin motion convert wave.xar wave.csv --limits clamp --slow-down",
    invoke_without_command=True,
    rich_markup_mode=None,
)


@app.callback()
def _motion(context: typer.Context) -> None:
    """Convert, check, describe and draw motion files.

    Formats are recognised by content and suffix: csv, json, npz, webots, runswift, hulks, motion2, python (Choregraphe
    export), xar and naoqi (arguments of angleInterpolation); naodevils, bhuman and xap can only be read.
    """
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


@command("motion convert", "Example: nao-kin motion convert wave.xar wave.csv --limits clamp --slow-down")
def convert(
    *,
    source: MotionFile,
    target: OutOptions,
    to: str | None = option("FORMAT", "Format of OUT. Default: by its suffix."),
    hips: Hips | None = HIPS,
    posture: str | None = option("NAME", "Add the joints that are not in the motion, at rest in this posture."),
    mirror: bool = flag("Exchange left and right."),
    reverse: bool = flag("Play the motion backwards."),
    stretch: float | None = option("F", "Multiply the duration by F."),
    loop: int | None = option("N", "Repeat the motion N times."),
    gap: float | None = option("S", "With --loop: seconds from each end to the next beginning."),
    limits: Literal["clamp", "ignore"] = option(None, OUTSIDE, default="ignore"),
    slow_down: bool = flag("Slow down where a joint would be too fast."),
    balance: bool = flag("With --slow-down: also until the robot does not tip."),
    rate: float | None = option("N", "Write N samples per second instead of the keys."),
    written: OutputOptions,
    robot: RobotOptions,
) -> None:
    """Write a motion in another format, with optional changes, which are reported.

    Each format has its unit of angles, or the file says it; --deg writes csv in degrees, with [deg] in its headings.
    The changes are applied in this order: --hips, --posture, --mirror, --reverse, --stretch, --loop, --limits,
    --slow-down, --rate.
    """
    from nao_kin import motion as motions

    if gap is not None and loop is None:
        raise BadArgument("--gap is the pause of --loop; give both")
    if balance and not slow_down:
        raise BadArgument("--balance is for --slow-down")
    if stretch is not None and not 0.0 < stretch < math.inf:
        raise BadArgument(f"--stretch must be a positive number, got {stretch:g}")
    if loop is not None and loop < 1:
        raise BadArgument(f"--loop must be at least 1, got {loop}")
    sink = target.path
    written.check({"": sink})
    model = robot.load()
    check_posture(model, posture)
    motion = source.read(model)
    changes = list[motions.Change]()

    def mended(found: Any) -> Motion:
        changes.extend(found.changes)
        motion: Motion = found.motion
        return motion

    if hips is not None:
        motion = mended(motions.share_motors(model, motion, hips))
    if posture is not None:
        motion = motions.complete(model, motion, posture)
    motion = motions.mirror(model, motion) if mirror else motion
    motion = motions.reverse(motion) if reverse else motion
    motion = motion if stretch is None else motions.time_warp(motion, stretch)
    motion = motion if loop is None else motions.loop(motion, loop, gap=gap or 0.0)
    motion = mended(motions.clamp(model, motion)) if limits == "clamp" else motion
    motion = mended(motions.slow_down(model, motion, balance=balance)) if slow_down else motion
    motions.write_motion(motion, sink, format=to, rate=rate, degrees=source.deg, overwrite=True)
    if written.json:
        print_json(
            {
                **_facts(motion),
                "output": sink,
                "changes": [_in_unit(change.as_dict(), source.deg) for change in changes],
            }
        )
        return
    print_note(*(change.describe(degrees=source.deg) for change in changes))
    print_written(sink)


@command("motion check", "Example: nao-kin motion check log.csv --missing Stand --limits measured --ignore-other")
def check(
    *,
    source: MotionFile,
    posture: str | None = option("NAME", "Values of the joints that are not in the motion."),
    rate: float | None = option("N", "Samples per second for curves without a closed form, and for collisions."),
    collisions: bool = flag("Also list links that overlap."),
    balance: bool = flag("Also say which soles carry, and where the robot tips at this speed."),
    tolerance: float = TOLERANCE,
    allow: list[str] | None = ALLOW,
    exact: bool = EXACT,
    limits: Literal["enforce", "measured"] = option(
        None, "measured: accept joints past their limits by the noise of sensors.", default="enforce"
    ),
    columns: list[str] | None = COLUMNS,
    hips: Hips | None = HIPS,
    missing: str | None = MISSING,
    every: bool = flag("List every violation, not only the worst of a joint.", "--all"),
    json: bool = JSON,
    robot: RobotOptions,
) -> None:
    """Check limits, coupled limits, speeds, and joints of one motor, also between keys; exit code 1 for violations."""
    from nao_kin import motion as motions
    from nao_kin.robot import CollisionRule

    model = robot.load()
    check_posture(model, posture)
    chosen: dict[str, Any] = {} if rate is None else {"rate": rate}
    fill = "hold" if posture is None else posture
    if not collisions and (tolerance or allow or exact):
        raise BadArgument("--tolerance, --allow and --exact are for --collisions")
    rule = CollisionRule(tolerance, pairs_of(allow), exact) if collisions else False
    refuse_both(posture, missing)
    motion = recorded(source, model, columns=columns, hips=hips, missing=missing)
    report = motions.check(model, motion, fill=fill, collisions=rule, balance=balance, limits=limits, **chosen)
    if json:
        document = report.as_dict()
        rows = {name: [_in_unit(row, source.deg) for row in document[name]] for name in ("violations", "accepted")}
        print_json(document | rows)
    else:
        _print_report(report, deg=source.deg, every=every)
    if not report.ok:
        raise typer.Exit(1)


@command("motion info", "Example: nao-kin motion info wave.xar --json")
def info(*, source: MotionFile, json: bool = JSON, robot: RobotOptions) -> None:
    """Print joints, keys, times and ranges of a motion."""
    model = robot.load()
    motion = source.read(model)
    rows = _joint_rows(model, motion, deg=source.deg)
    if json:
        print_json({**_facts(motion), "rows": rows})
        return
    columns = ("joint", "keys", "from\n[s]", "to\n[s]", "least", "most", "unit")
    print_table(columns, [[_cell(value) for value in row.values()] for row in rows], numbers=columns[1:6])
    count = len(rows)
    print(f"{count} joint{'s' if count > 1 else ''}, {motion.interpolation}, {motion.duration:.6g} s")


@command("motion plot", "Example: nao-kin motion plot wave.xar wave.png --joint RShoulderRoll", without=("deg",))
def plot(
    *,
    source: MotionFile,
    target: OutOptions,
    joints: list[str] | None = option("NAME", "Draw this joint; repeatable. Default: all.", "--joint"),
    speed: bool = flag("Draw speeds instead of values."),
    balance: bool = flag("Also draw the margins of the balance."),
    written: OutputOptions,
    robot: RobotOptions,
) -> None:
    """Draw every joint over time, in degrees, with its limits, as .png or .svg; values outside are red."""
    from nao_kin.motion import plot as draw

    picture = target.path
    kind = Path(picture).suffix.lower().removeprefix(".")
    if kind not in ("png", "svg"):
        raise BadArgument(f"cannot write {abbreviated(picture)}: end the name in .png or .svg")
    written.check({"": picture})
    model = robot.load()
    motion = source.read(model)
    content = io.BytesIO()
    draw(model, motion, joints=joints, speed=speed, balance=balance).savefig(content, format=kind, dpi=120)
    atomic.write_bytes(picture, content.getvalue())
    if written.json:
        print_json({"picture": picture, "joints": list(joints or motion.joint_names)})
    else:
        print(picture)


def _in_unit(row: dict[str, Any], deg: bool) -> dict[str, Any]:
    """Return a row of JSON that has a unit; with `deg` in degrees instead of radians."""
    scale = degrees_per(row["unit"].partition("/")[0], deg)
    if scale == 1.0:
        return row
    numbers = ("value", "lower", "upper", "excess", "of_value", "amount")
    found = {name: row[name] * scale for name in numbers if isinstance(row.get(name), float)}
    return row | found | {"unit": row["unit"].replace("rad", "deg")}


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
    for name, times, keys in zip(motion.joint_names, motion.times, motion.keys, strict=True):
        unit = model.unit(name)
        scale = degrees_per(unit, deg)
        rows.append(
            {
                "joint": name,
                "keys": len(keys),
                "start": float(times[0]),
                "end": float(times[-1]),
                "least": float(keys.min()) * scale,
                "most": float(keys.max()) * scale,
                "unit": unit if scale == 1.0 else "deg",
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
            print(f"and {more} more intervals of these joints (--all lists them)")
    lines = report.describe(degrees=deg).splitlines()
    print(lines[0])
    print(
        "".join(f"{line}\n" for line in lines[1:] if " sampled " in line or line.startswith(("accepted", "balance: "))),
        end="",
    )


def _report_cells(row: MotionViolation, deg: bool) -> list[str]:
    scale = degrees_per(row.unit.partition("/")[0], deg)
    unit = {"1": "", "1/s": " /s"}.get(row.unit, f" {row.unit}") if scale == 1.0 else row.unit.replace("rad", "°")
    if row.kind == "motor":
        allowed = f"as {row.of} = {_cell(row.lower * scale)}"
    elif row.kind in ("collision", "balance"):
        return [
            row.kind,
            f"{row.joint}, {row.of}{' edge' if row.kind == 'balance' else ''}",
            *map(_cell, (row.start, row.end, row.time, row.value)),
            "0 m … ",
            f"{row.excess:.3g} m",
        ]
    else:
        allowed = f"{_cell(row.lower * scale)} … {_cell(row.upper * scale)}"
        allowed += f" at {row.of} = {_cell(row.of_value * scale)}" if row.of is not None else ""
    times = [_cell(value) for value in (row.start, row.end, row.time)]
    return [row.kind, row.joint, *times, _cell(row.value * scale), allowed, f"{row.excess * scale:.3g}{unit}"]


def _cell(value: object) -> str:
    return f"{value + 0.0:.5g}" if isinstance(value, float) else str(value)
