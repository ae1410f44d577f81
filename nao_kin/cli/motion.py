"""`nao-kin motion` and `imitate`: motion files, converted, checked, described, drawn, or made of a person's motion."""

from __future__ import annotations

import csv
import io
import math
from contextlib import closing
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import typer

from nao_kin._core import files as atomic
from nao_kin._core.sides import Hips
from nao_kin._core.text import abbreviated
from nao_kin.cli import options as shared
from nao_kin.cli.options import OutOptions, OutputOptions, RobotOptions, argument, command, flag, option
from nao_kin.cli.output import degrees_per, print_json, print_note, print_table, print_written, progress
from nao_kin.cli.sources import MotionFile, OverlapOptions, check_motion_file, number_settings, recorded, settings
from nao_kin.errors import BadArgument, BadInputFile

if TYPE_CHECKING:
    from nao_kin.imitation import Imitation
    from nao_kin.motion import Motion, MotionReport, MotionViolation
    from nao_kin.robot import RobotModel


@command(
    "motion convert",
    "Example: nao-kin motion convert wave.xar wave.csv --limits clamp --slow-down",
    needs={"gap": "loop", "balance": "slow_down"},
)
def convert(
    *,
    source: MotionFile,
    target: OutOptions,
    to: str | None = option("FORMAT", "Format of OUT. Default: by its suffix."),
    hips: Hips | None = shared.HIPS,
    posture: str | None = option("NAME", "Add the joints that are not in the motion, at rest in this posture."),
    mirror: bool = flag("Exchange left and right."),
    reverse: bool = flag("Play the motion backwards."),
    stretch: float | None = option("F", "Multiply the duration by F."),
    loop: int | None = option("N", "Repeat the motion N times."),
    gap: float | None = option("S", "With --loop: seconds from each end to the next beginning."),
    limits: Literal["clamp", "ignore"] = option(None, shared.OUTSIDE, default="ignore"),
    slow_down: bool = flag("Slow down where a joint would be too fast."),
    balance: bool = flag("With --slow-down: also until the robot does not tip."),
    lead: float = option("S", "Begin so many seconds later: NAOqi refuses keys at 0 s.", default=0.0),
    rate: float | None = option("N", "Write N samples per second instead of the keys."),
    written: OutputOptions,
    robot: RobotOptions,
) -> None:
    """Write a motion in another format, with optional changes, which are reported.

    Each format has its unit of angles, or the file says it; --deg writes csv in degrees, with [deg] in its headings.
    The changes are applied in this order: --hips, --posture, --mirror, --reverse, --stretch, --loop, --limits,
    --slow-down, --lead, --rate.
    """
    from nao_kin import motion as motions

    if stretch is not None and stretch <= 0.0:
        raise BadArgument(f"--stretch must be a positive number, got {stretch:g}")
    if loop is not None and loop < 1:
        raise BadArgument(f"--loop must be at least 1, got {loop}")
    sink = target.path
    written.check({"": sink})
    model = robot.load()
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
    motion = motions.time_warp(motion, lambda times: times + lead) if lead else motion
    motions.write_motion(motion, sink, format=to, rate=rate, degrees=source.deg, overwrite=True)
    if written.json:
        rows = [_in_unit(change.as_dict(), source.deg) for change in changes]
        print_json({**_facts(motion), "output": sink, "changes": rows})
        return
    print_note(*(change.describe(degrees=source.deg) for change in changes))
    print_written(sink)


@command(
    "motion check",
    "Example: nao-kin motion check log.csv --missing Stand --limits measured --ignore-other",
    needs={"tolerance": "collisions", "allow": "collisions", "exact": "collisions"},
)
def check(
    *,
    source: MotionFile,
    posture: str | None = option("NAME", "Values of the joints that are not in the motion."),
    rate: float | None = option("N", "Samples per second for curves without a closed form, and for collisions."),
    collisions: bool = flag("Also list links that overlap."),
    balance: bool = flag("Also say which soles carry, and where the robot tips at this speed."),
    accepted: OverlapOptions,
    limits: Literal["enforce", "measured"] = option(
        None, "measured: accept joints past their limits by the noise of sensors.", default="enforce"
    ),
    columns: list[str] | None = shared.COLUMNS,
    hips: Hips | None = shared.HIPS,
    missing: str | None = shared.MISSING,
    every: bool = flag("List every violation, not only the worst of a joint.", "--all"),
    json: bool = shared.JSON,
    robot: RobotOptions,
) -> None:
    """Check limits, coupled limits, speeds, and joints of one motor, also between keys; exit code 1 for violations."""
    from nao_kin import motion as motions

    model = robot.load()
    chosen: dict[str, Any] = {} if rate is None else {"rate": rate}
    rest = "hold" if posture is None else posture
    rule = accepted.rule if collisions else False
    motion = recorded(source, model, columns=columns, hips=hips, missing=missing)
    report = motions.check(model, motion, missing=rest, collisions=rule, balance=balance, limits=limits, **chosen)
    if json:
        document = report.as_dict()
        rows = {name: [_in_unit(row, source.deg) for row in document[name]] for name in ("violations", "accepted")}
        print_json(document | rows)
    else:
        _print_report(report, deg=source.deg, every=every)
    if not report.ok:
        raise typer.Exit(1)


@command("motion info", "Example: nao-kin motion info wave.xar --json")
def info(*, source: MotionFile, json: bool = shared.JSON, robot: RobotOptions) -> None:
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
    first, *lines = report.describe(degrees=deg).splitlines()
    print(
        first, *(line for line in lines if " sampled " in line or line.startswith(("accepted", "balance: "))), sep="\n"
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


# --- `nao-kin imitate`.

# Configurations per second of the page.
_FPS = 30.0
# Formats that NAOqi plays: seconds to the first key, frames per second, and how far lines between keys may be from them
# [rad].
_FOR_NAOQI, _LEAD, _FRAMES, _WITHIN = ("python", "naoqi", "xar"), 1.0, 100.0, math.radians(0.5)


@command("imitate", "Example: nao-kin imitate circles.bvh -o circles.xar --html circles.html --legs follow")
def imitate(
    *,
    file: str = argument("FILE", "BVH, JSON, CSV, TRC, C3D, .skeleton, .npy or .npz file of a skeleton, or a folder."),
    target: OutOptions,
    to: str | None = option("FORMAT", "Format of OUT, as in nao-kin motion. Default: by its suffix."),
    html: str | None = option("PAGE", "Also write a page of the robot beside the person as a stick figure."),
    source: str | None = option("NAME", "Order of points: mediapipe, kinect_v2, body25 … Default: found."),
    names: list[str] | None = option(
        "POINT=JOINT", "The joint of FILE that is a point; repeatable. Or a JSON or CSV file of points and joints."
    ),
    rate: float | None = option("HZ", "Frames per second of a file without times, or instead of its times."),
    units: str | None = option("UNIT", "m, cm, mm, inch or cmu. Default: by the size of the trunk."),
    up: str | None = option("AXIS", "The axis that points up: z, y, -y … Default: that of the source."),
    start: float | None = option("S", "Leave out the frames before this time [s]."),
    end: float | None = option("S", "Leave out the frames after this time [s]."),
    legs: Literal["stand", "follow", "ignore"] = option(
        None, "stand: feet in place; follow: the person's steps; ignore: arms and head alone.", default="stand"
    ),
    mirror: bool = flag("Imitate as a mirror image, such as of a person who faces the robot."),
    weight: list[str] | None = option(
        "NAME=X", "Weight of upper_arm, forearm, hand, place or speed in the cost of arms; repeatable."
    ),
    lead: float | None = option(
        "S",
        "Move from StandInit to the first frame, and back, in so many seconds. Default: 1 for .py and .xar, else 0.",
    ),
    cutoff: float = option("HZ", "Filter out motion above this frequency; 0 for no filter.", default=4.0),
    accepted: OverlapOptions,
    written: OutputOptions,
    robot: RobotOptions,
) -> None:
    """Write a person's motion as one that the robot can play; exit code 1 if it still violates a limit.

    Arms and head take the person's directions, legs lean the trunk or make steps, arms make room for other links, and
    the motion takes longer where a joint would be too fast or the robot would tip. The report says how far it is from
    the person.

    Files for NAOqi (.py, .xar) get no more keys than straight lines within 0.5° of 100 frames per second need. An .npz
    also has the floating base in the person's own time, in the layout of BeyondMimic, mjlab and GMR.
    """
    from nao_kin import imitation
    from nao_kin.motion import write_motion

    sink = target.path
    written.check({"": sink, "--html": html})
    written_as = check_motion_file(sink, to)
    thin = written_as in _FOR_NAOQI
    model = robot.load()
    points = _named_points(names) or None
    skeleton = imitation.read_skeleton(file, source=source, names=points, rate=rate, units=units, up=up)
    skeleton = skeleton.between(start, end)
    with progress("imitate", shown=not written.json):
        made = imitation.imitate(
            model,
            skeleton,
            legs=legs,
            mirror=mirror,
            weights=number_settings(weight, "--weight", "NAME=X with a number, as in place=10"),
            cutoff=cutoff,
            collisions=accepted.rule,
            lead=(_LEAD if thin else 0.0) if lead is None else lead,
        )
    written_motion, thinned = _with_few_keys(model, made.motion) if thin else (made.motion, {})
    if written_as == "npz":
        with TemporaryDirectory() as folder:
            write_motion(written_motion, Path(folder, "motion.npz"))
            with np.load(Path(folder, "motion.npz")) as own:
                content, arrays = io.BytesIO(), {**own, **made.clip(model)}
        np.savez_compressed(content, **arrays)
        atomic.write_bytes(sink, content.getvalue())
    else:
        write_motion(written_motion, sink, format=to, overwrite=True)
    if html is not None:
        _write_page(model, made, html, overwrite=written.force)
    if written.json:
        print_json({"output": sink, "html": html, **thinned, **made.as_dict()})
    else:
        print_written(sink, *([] if html is None else [html]))
        typer.echo(made.describe(), err=True)
        if thinned:
            typer.echo("keys: {keys}, {error_deg:.2g}° away at most".format(**thinned), err=True)
    if not made.ok:
        raise typer.Exit(1)


def _with_few_keys(model: RobotModel, motion: Motion) -> tuple[Motion, dict[str, Any]]:
    """Return a motion with few keys, and how many it has and how far it is from the other.

    It consists of straight Bezier curves, for NAOqi rounds the corners of angleInterpolation.
    """
    from nao_kin.motion import resample

    frames = np.arange(math.floor(motion.start * _FRAMES), math.ceil(motion.end * _FRAMES) + 1)
    few = resample(motion, times=frames[frames > 0] / _FRAMES, tolerance=_WITHIN, robot=model)
    error = float(np.abs(few.sample(motion.key_times) - motion.sample(motion.key_times)).max())
    return few.as_bezier(), {"keys": sum(map(len, few.keys)), "error_deg": math.degrees(error)}


def _named_points(texts: list[str] | None) -> dict[str, str]:
    """Return point → joint of --names, whose files are an object point → joint in JSON, or two columns in CSV."""
    given = []
    for text in texts or ():
        if not text.lower().endswith((".json", ".csv")) or "=" in text:
            given.append(text)
            continue
        content, is_json = atomic.read_table_text(text, "points and joints")
        document = atomic.read_json(text, content) if is_json else None
        rows = (
            [*document.items()] if isinstance(document, dict) else [*csv.reader(content.splitlines())] * (not is_json)
        )
        if not rows or not all(len(row) == 2 and all(isinstance(name, str) for name in row) for row in rows):
            raise BadInputFile(text, 'expected {"left_wrist": "LeftHand", …}, or rows such as left_wrist,LeftHand')
        given += [f"{point}={joint}" for point, joint in rows]
    return settings(given, "--names", "POINT=JOINT, as in left_wrist=LeftHand")


def _write_page(model: RobotModel, made: Imitation, path: str, *, overwrite: bool) -> None:
    from nao_kin.viewer import Viewer

    clip = made.motion.configurations(model, rate=_FPS, missing=made.q[0])
    with closing(Viewer(model)) as viewer:
        viewer.animate(clip.q, _FPS, balance=bool(made.report.balance), figure=made.figure(clip.times))
        viewer.camera("front")
        viewer.save_html(path, overwrite=overwrite)
