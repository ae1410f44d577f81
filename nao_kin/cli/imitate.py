"""`nao-kin imitate`: a person's skeleton from motion capture or a webcam as a motion of the robot."""

from __future__ import annotations

from contextlib import closing
from typing import TYPE_CHECKING, Literal

import typer

from nao_kin._core.text import quoted
from nao_kin.cli.options import (
    ALLOW,
    EXACT,
    TOLERANCE,
    OutOptions,
    OutputOptions,
    RobotOptions,
    argument,
    command,
    flag,
    option,
)
from nao_kin.cli.output import print_json, print_written, progress
from nao_kin.cli.sources import check_motion_file, pairs_of
from nao_kin.errors import BadArgument

if TYPE_CHECKING:
    from nao_kin.imitation import Imitation
    from nao_kin.robot import RobotModel

_FPS = 30.0


@command("imitate", "Example: nao-kin imitate circles.bvh -o circles.xar --html circles.html --legs follow")
def imitate(
    *,
    file: str = argument("FILE", "BVH, JSON, CSV, .npy or .npz file of a skeleton; - for standard input."),
    target: OutOptions,
    to: str | None = option("FORMAT", "Format of OUT, as in nao-kin motion. Default: by its suffix."),
    html: str | None = option("PAGE", "Also write a page of the robot beside the person as a stick figure."),
    source: str | None = option("NAME", "Naming or order of points: mediapipe, mixamo, cmu … Default: found."),
    names: list[str] | None = option("POINT=JOINT", "The joint of FILE that is a point; repeatable."),
    rate: float | None = option("HZ", "Frames per second of a file without times, or instead of its times."),
    units: str | None = option("UNIT", "m, cm, mm, inch or cmu. Default: by the size of the trunk."),
    up: str | None = option("AXIS", "The axis that points up: z, y, -y … Default: that of the source."),
    start: float | None = option("S", "Leave out the frames before this time [s]."),
    end: float | None = option("S", "Leave out the frames after this time [s]."),
    legs: Literal["stand", "follow", "ignore"] = option(
        None, "stand: feet in place; follow: the person's steps; ignore: arms and head alone.", default="stand"
    ),
    mirror: bool = flag("Imitate as a mirror image, such as of a person who faces the robot."),
    hands: Literal["direction", "place", "mixed"] = option(
        None, "Directions of the arms, places of the hands, or places where hands are near.", default="direction"
    ),
    cutoff: float = option("HZ", "Filter out motion above this frequency; 0 for no filter.", default=4.0),
    tolerance: float = TOLERANCE,
    allow: list[str] | None = ALLOW,
    exact: bool = EXACT,
    written: OutputOptions,
    robot: RobotOptions,
) -> None:
    """Write a person's motion as one that the robot can play; exit code 1 if it still violates a limit.

    Arms and head take the person's directions, legs lean the trunk or make steps, arms make room for other links, and
    the motion takes longer where a joint would be too fast or the robot would tip. The report says how far it is from
    the person.
    """
    from nao_kin import imitation
    from nao_kin.motion import write_motion
    from nao_kin.robot import CollisionRule

    sink = target.path
    written.check({"": sink, "--html": html})
    check_motion_file(sink, to)
    model = robot.load()
    skeleton = imitation.read_skeleton(file, source=source, names=_pairs(names), rate=rate, units=units, up=up).between(
        start, end
    )
    with progress("imitate", shown=not written.json):
        made = imitation.imitate(
            model,
            skeleton,
            legs=legs,
            mirror=mirror,
            target=hands,
            cutoff=cutoff,
            collisions=CollisionRule(tolerance, pairs_of(allow), exact),
        )
    write_motion(made.motion, sink, format=to, overwrite=True)
    if html is not None:
        _write_page(model, made, html, overwrite=written.force)
    if written.json:
        print_json({"output": sink, "html": html, **made.as_dict()})
    else:
        print_written(sink, *([] if html is None else [html]))
        typer.echo(made.describe(), err=True)
    if not made.ok:
        raise typer.Exit(1)


def _pairs(names: list[str] | None) -> dict[str, str] | None:
    """Return the values of --names, point → joint."""
    found = {}
    for text in names or ():
        point, sign, joint = text.partition("=")
        if not (point and sign and joint):
            raise BadArgument(f"--names {quoted(text)}: expected POINT=JOINT, as in left_wrist=LeftHand")
        found[point.strip()] = joint.strip()
    return found or None


def _write_page(model: RobotModel, made: Imitation, path: str, *, overwrite: bool) -> None:
    from nao_kin.viewer import Viewer

    clip = made.motion.configurations(model, rate=_FPS, fill=made.q[0])
    with closing(Viewer(model)) as viewer:
        viewer.animate(clip.q, _FPS, balance=bool(made.report.balance), figure=made.figure(clip.times))
        viewer.camera("front")
        viewer.save_html(path, overwrite=overwrite)
