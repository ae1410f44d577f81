"""`nao-kin sample`: small files to try the other commands with."""

from __future__ import annotations

from pathlib import Path

from nao_kin._core import files as atomic
from nao_kin._core.arrays import choice
from nao_kin.cli.options import OutputOptions, argument, command, option
from nao_kin.cli.output import print_json, print_table, print_written
from nao_kin.errors import BadArgument

# Name of a sample, a file or a folder → what it is.
SAMPLES = {
    "walk.csv": "log of a walk: times and the 25 joints",
    "log.csv": "log of the same walk by sensors: 26 joints, forces on the soles, inertial unit",
    "wave.xar": "motion, a timeline of Choregraphe: the right arm waves",
    "kick.motion": "motion, a file of Webots: a kick with the right foot",
    "circles.bvh": "motion capture of a person, for imitate",
    "observations.json": "corners of a chessboard in pictures of a head camera, for calibrate",
    "photos": "folder with photos of this chessboard, for calibrate",
    "head.csv": "log of the head's joints while these photos were taken",
}
_ALL = "all"
# What the command takes.
NAMES = (*SAMPLES, _ALL)


@command("sample", "Example: nao-kin sample walk.csv wave.xar; nao-kin sample all -o samples")
def sample(
    *,
    sample_names: list[str] | None = argument(
        "NAME", "A sample; several, or all. Default: list them, or with -o write all.", None
    ),
    output: str | None = option(
        "FOLDER", "Write the files into this folder; it is made if needed. Default: the current one."
    ),
    written: OutputOptions,
) -> None:
    """Write small files to try the other commands with, or list them."""
    if output == "-":
        raise BadArgument("--output is the folder for the samples, and - is not one; leave it out for this folder")
    if not sample_names and output is None:
        if written.json:
            print_json({"samples": [{"name": name, "purpose": purpose} for name, purpose in SAMPLES.items()]})
        else:
            print_table(("name", "what it is"), SAMPLES.items())
        return
    names = [choice(name, NAMES, "sample") for name in sample_names or [_ALL]]
    folder = output or "."
    with atomic.errors_naming(folder):
        Path(folder).mkdir(parents=True, exist_ok=True)
    paths = [Path(folder, name) for name in dict.fromkeys(SAMPLES if _ALL in names else names)]
    for path in paths:
        check = atomic.check_replaceable if path.suffix else atomic.check_folder
        check(path, overwrite=written.force)
    for path in paths:
        source = _source(path.name)
        if source.is_dir():
            photos = {photo.name: photo.read_bytes() for photo in source.iterdir()}
            atomic.write_folder(path, photos, overwrite=True)
        else:
            atomic.write_bytes(path, source.read_bytes())
    if written.json:
        print_json({"files": [str(path) for path in paths]})
    else:
        print_written(*paths)


def _source(name: str) -> Path:
    """Return the file or folder of a sample in this package."""
    if name == "circles.bvh":
        from nao_kin.imitation import SAMPLES as people

        return people["circles"]
    return Path(__file__).with_name("samples") / name
