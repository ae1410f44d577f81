"""`nao-kin export`: a robot in the formats of other tools."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import typer

from nao_kin._core import files as atomic
from nao_kin.cli.motion import read
from nao_kin.cli.options import (
    JsonOption,
    RobotOptions,
    TimelineOption,
    command,
    print_json,
    print_note,
)
from nao_kin.errors import BadArgument


@dataclass(frozen=True)
class ExportOptions:
    """The options of all formats; one that is None is left to the format."""

    frames: Annotated[
        str | None, typer.Option("--frames", metavar="WHICH", help="Links on fixed joints: all, effectors or none.")
    ] = None
    names: Annotated[
        str | None, typer.Option("--names", metavar="WHOSE", help="Names of links and joints: naoqi or ros.")
    ] = None
    meshes: Annotated[
        str | None,
        typer.Option(
            "--meshes",
            metavar="HOW",
            help="relative (copied), absolute, package://NAME or none; for ros2 package or none.",
        ),
    ] = None
    coupling: Annotated[
        str | None,
        typer.Option("--coupling", metavar="HOW", help="Joints that follow others: mimic, locked or independent."),
    ] = None
    inertia: Annotated[
        str | None, typer.Option("--inertia", metavar="WHICH", help="published, or physical: mended for simulators.")
    ] = None
    typed: Annotated[
        bool | None, typer.Option("--typed", help="Three joints with one centre as one spherical joint.")
    ] = None
    axes: Annotated[
        str | None, typer.Option("--axes", metavar="HOW", help="published, or aligned: no joint axis is oblique.")
    ] = None
    base: Annotated[str | None, typer.Option("--base", metavar="HOW", help="The root: floating or fixed.")] = None
    samples: Annotated[
        int | None, typer.Option("--samples", metavar="N", help="srdf, ros2: configurations tried for contacts.")
    ] = None
    seed: Annotated[int | None, typer.Option("--seed", metavar="N", help="srdf, ros2: of their random numbers.")] = None
    package: Annotated[str | None, typer.Option("--package", metavar="NAME", help="ros2: name of the package.")] = None
    package_version: Annotated[
        str | None, typer.Option("--package-version", metavar="X.Y.Z", help="ros2: version of the package.")
    ] = None
    maintainer: Annotated[
        str | None, typer.Option("--maintainer", metavar="WHO", help="ros2: as 'Name <name@example.org>'.")
    ] = None
    license: Annotated[
        str | None, typer.Option("--license", metavar="NAME", help="ros2: of what is in the package.")
    ] = None
    posture: Annotated[
        str | None, typer.Option("--posture", metavar="NAME", help="gltf: the posture it stands in.")
    ] = None
    motion: Annotated[
        str | None, typer.Option("--motion", metavar="FILE", help="gltf: a motion, to be the animation.")
    ] = None
    timeline: TimelineOption = None
    fps: Annotated[
        float | None, typer.Option("--fps", metavar="F", help="gltf: poses per second in the animation.")
    ] = None


@command(
    "export",
    "Example: nao-kin export nao.urdf --format urdf --frames none --inertia physical --version v6",
    without=("package_dir",),
)
def export(
    *,
    output: Annotated[str, typer.Argument(metavar="OUTPUT", help="The file or folder, - for standard output.")],
    format_: Annotated[
        str, typer.Option("--format", metavar="FORMAT", help="Which format: urdf, mjcf, srdf, ros2, sdf or gltf.")
    ],
    options: ExportOptions,
    force: Annotated[bool, typer.Option("--force", help="Replace OUTPUT where it exists.")] = False,
    json: JsonOption = False,
    robot: RobotOptions,
) -> None:
    """Write a robot for another tool; what differs from the robot is said, line by line."""
    from nao_kin import export as exports

    output = "/dev/stdout" if output == "-" else output
    if atomic.leads_to_standard_output(output) and json:
        raise BadArgument(f"{output} and --json both write to standard output; give one")
    chosen = {name: value for name, value in vars(options).items() if value is not None}
    timeline = chosen.pop("timeline", None)
    exports.check_options(format_, chosen)
    if timeline is not None and options.motion is None:
        raise BadArgument("--timeline is one of the motions in the file of --motion; give both")
    model = robot.load()
    if options.motion is not None and timeline is not None:
        chosen["motion"] = read(model, options.motion, deg=False, timeline=timeline)
    done = exports.write(model, output, format_, overwrite=force, **chosen)
    for change in done.changes:
        print_note(change)
    if json:
        files = [str(file) for file in done.files]
        print_json({"path": str(done.path), "format": format_, "files": files, "changes": list(done.changes)})
    elif not atomic.leads_to_standard_output(output):
        print(done.path)
