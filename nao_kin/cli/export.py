"""`nao-kin export`: a robot in the formats of other tools."""

from __future__ import annotations

import inspect
import re
from dataclasses import make_dataclass
from functools import cache
from pathlib import Path
from typing import Any

from nao_kin._core import files as atomic
from nao_kin._core.arrays import choice
from nao_kin.cli import options as shared
from nao_kin.cli.options import OutOptions, OutputOptions, RobotOptions, command, flag, option
from nao_kin.cli.output import print_json, print_note, print_written
from nao_kin.cli.sources import MotionFile
from nao_kin.errors import BadArgument

# Ending of a file → its format; the other formats are folders.
_FORMATS = {".urdf": "urdf", ".srdf": "srdf", ".glb": "gltf"}


@cache
def export_options() -> type:
    """Return the class of the options of all formats, as the signatures and docstrings of their functions state them.

    None means the default of the format.
    """
    from nao_kin.export import FORMATS, options

    names = dict.fromkeys(name for key in FORMATS for name in options(key))
    return make_dataclass("ExportOptions", [_field(name) for name in names], frozen=True)


def _field(name: str) -> tuple[str, Any, Any]:
    """Return the field of an option of one or several formats: its name, its type and the `option`."""
    from nao_kin.export import FORMATS, options

    texts, defaults = dict[str, list[str]](), dict[str, list[str]]()  # text → formats
    for key in (key for key in FORMATS if name in options(key)):
        entry = re.search(rf"^    {name}: (.+?)\.(\s|$)", str(inspect.getdoc(FORMATS[key])), re.MULTILINE | re.DOTALL)
        text = (
            "" if entry is None else re.sub(r'["`]', "", " ".join(entry[1].split())).replace("None for", "by default")
        )
        # A reference to the description in another format does not stand in the help.
        texts.setdefault(next(iter(texts), text) if "as in" in text else text, []).append(key)
        defaults.setdefault(str(options(key)[name]), []).append(key)
    places = {text: "" if len(keys) == len(FORMATS) else f"{', '.join(keys)}: " for text, keys in texts.items()}
    help = " ".join(f"{place}{text}." for text, place in places.items())
    known = {value: keys for value, keys in defaults.items() if value not in ("None", "False")}
    usual = "; ".join(f"{value} ({', '.join(keys)})" if n else value for n, (value, keys) in enumerate(known.items()))
    help += f" Default: {usual}." if usual else ""
    annotation = inspect.signature(FORMATS[next(iter(texts.values()))[0]]).parameters[name].annotation
    kind: Any = {"bool": bool, "int": int, "float": float}.get(annotation, str)
    metavar = "FILE" if "Path" in annotation else "NAME" if kind is str else "N"
    return name, kind | None, flag(help, default=None) if kind is bool else option(metavar, help)


@command(
    "export",
    "Example: nao-kin export nao.urdf --format urdf --frames none --inertia physical --nao v6",
    without=("package_dir",),
    needs={"timeline": "motion", "file_deg": "motion"},
)
def export(
    *,
    target: OutOptions,
    format_: str | None = option(
        "FORMAT",
        "urdf, mjcf (MuJoCo), srdf (MoveIt), ros2, sdf (Gazebo) or gltf (Blender). Default: by the ending of OUT, if "
        "that is .urdf, .srdf or .glb.",
    ),
    options: export_options(),  # type: ignore[valid-type]  # evaluated when the command is called
    timeline: str | None = shared.TIMELINE,
    file_deg: bool = shared.FILE_DEG,
    written: OutputOptions,
    robot: RobotOptions,
) -> None:
    """Write a robot for another tool. Every difference between the file and the robot is reported."""
    from nao_kin import export as exports

    path = target.path
    format_ = format_ or _FORMATS.get(Path(path).suffix.lower())
    if format_ is None:
        raise BadArgument(f"--format is missing: give one of {', '.join(exports.FORMATS)}")
    if atomic.leads_to_standard_output(path) and written.json:
        raise BadArgument(f"{path} and --json both write to standard output; give one")
    chosen = {name: value for name, value in vars(options).items() if value is not None}
    known = exports.options(format_)
    for name in chosen:
        choice(name, known, f"option of the format {format_}")
    model = robot.load()
    if "motion" in chosen:
        chosen["motion"] = MotionFile(chosen["motion"], timeline=timeline, file_deg=file_deg).read(model)
    done = exports.write(model, path, format_, overwrite=written.force, **chosen)
    print_note(*done.changes)
    if written.json:
        files = [str(file) for file in done.files]
        print_json({"path": str(done.path), "format": format_, "files": files, "changes": list(done.changes)})
    else:
        print_written(done.path)
