"""`nao-kin export`: a robot in the formats of other tools."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from nao_kin._core import files as atomic
from nao_kin.cli.options import RobotOptions, command, flag, one_output, option
from nao_kin.cli.output import print_json, print_note, print_written
from nao_kin.cli.shared import FORCE, JSON, OUT, OUTPUT, TIMELINE
from nao_kin.cli.sources import MotionFile
from nao_kin.errors import BadArgument

# Ending of a file → its format; the other formats are folders.
_FORMATS = {".urdf": "urdf", ".srdf": "srdf", ".glb": "gltf"}


@dataclass(frozen=True)
class ExportOptions:
    """The options of all formats; None means the default of the format."""

    frames: str | None = option("WHICH", "Links on fixed joints: all, effectors or none.")
    names: str | None = option("WHOSE", "Names of links and joints: naoqi or ros.")
    meshes: str | None = option(
        "HOW", "Paths of meshes: relative (copied), absolute, package://NAME or none; for ros2 package or none."
    )
    coupling: str | None = option("HOW", "Mimic joints: mimic, locked or independent.")
    inertia: str | None = option("WHICH", "Inertias: published, or physical (corrected for simulators).")
    typed: bool | None = flag("Merge three joints with one centre into a spherical joint.", default=None)
    axes: str | None = option("HOW", "Joint axes: published, or aligned (without oblique axes).")
    base: str | None = option("HOW", "The root: floating or fixed.")
    samples: int | None = option("N", "srdf, ros2: largest number of configurations examined for each pair of links.")
    seed: int | None = option("N", "srdf, ros2: seed of these configurations.")
    package: str | None = option("NAME", "ros2: name of the package.")
    package_version: str | None = option("X.Y.Z", "ros2: version of the package.")
    maintainer: str | None = option("WHO", "ros2: maintainer of the package, as 'Name <name@example.org>'.")
    license: str | None = option("NAME", "ros2: licence of the package.")
    posture: str | None = option("NAME", "gltf: the posture of the robot.")
    motion: str | None = option("FILE", "gltf: a motion for the animation.")
    timeline: str | None = TIMELINE
    fps: float | None = option("N", "gltf: poses per second in the animation.")


@command(
    "export",
    "Example: nao-kin export nao.urdf --format urdf --frames none --inertia physical --nao v6",
    without=("package_dir",),
)
def export(
    *,
    out: str | None = OUT,
    output: str | None = option("FILE", "The same as OUT.", *OUTPUT),
    format_: str | None = option(
        "FORMAT",
        "urdf, mjcf, srdf, ros2, sdf or gltf. Default: by the ending of OUT, if that is .urdf, .srdf or .glb.",
    ),
    options: ExportOptions,
    force: bool = FORCE,
    json: bool = JSON,
    robot: RobotOptions,
) -> None:
    """Write a robot for another tool. Every difference between the file and the robot is reported."""
    from nao_kin import export as exports

    path = one_output(out, output)
    if format_ is None:
        format_ = _FORMATS.get(Path(path).suffix.lower())
    if format_ is None:
        raise BadArgument(f"--format is missing: give one of {', '.join(exports.FORMATS)}")
    if atomic.leads_to_standard_output(path) and json:
        raise BadArgument(f"{path} and --json both write to standard output; give one")
    chosen = {name: value for name, value in vars(options).items() if value is not None}
    timeline = chosen.pop("timeline", None)
    exports.check_options(format_, chosen)
    if timeline is not None and options.motion is None:
        raise BadArgument("--timeline chooses a motion in the file of --motion; give both")
    model = robot.load()
    if options.motion is not None and timeline is not None:
        chosen["motion"] = MotionFile(options.motion, timeline=timeline).read(model)
    done = exports.write(model, path, format_, overwrite=force, **chosen)
    print_note(*done.changes)
    if json:
        files = [str(file) for file in done.files]
        print_json({"path": str(done.path), "format": format_, "files": files, "changes": list(done.changes)})
    else:
        print_written(done.path)
