"""Motion files of many kinds: which there are, which one a file is, reading and writing."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from nao_kin._core.arrays import choice
from nao_kin._core.files import check_writable, read_bytes, replaced_file, write_bytes
from nao_kin._core.text import abbreviated
from nao_kin.errors import BadArgument, BadInputFile
from nao_kin.motion.files.bhuman import BHUMAN, NAODEVILS
from nao_kin.motion.files.choregraphe import XAR
from nao_kin.motion.files.csv_table import CSV, NPZ
from nao_kin.motion.files.hulks import HULKS, MOTION2
from nao_kin.motion.files.json_keys import JSON
from nao_kin.motion.files.python_scripts import NAOQI, PYTHON
from nao_kin.motion.files.runswift import RUNSWIFT
from nao_kin.motion.files.source import Format, MotionFileWarning, Source, file_name
from nao_kin.motion.files.webots import WEBOTS
from nao_kin.motion.motion import Motion, check_motion
from nao_kin.robot import RobotModel, check_robot
from nao_kin.robot.nao import BODY_ORDER

__all__ = [
    "FORMATS",
    "MotionFileWarning",
    "read_motion",
    "write_motion",
]


# --- Reading motions: which format a file has, told by its content first, then by its suffix.

_FORMATS = (CSV, JSON, NPZ, WEBOTS, RUNSWIFT, HULKS, MOTION2, NAODEVILS, BHUMAN, PYTHON, XAR, NAOQI)
FORMATS: Mapping[str, Format] = MappingProxyType({known.name: known for known in _FORMATS})


def read_motion(
    path: Path | str,
    *,
    format: str | None = None,
    degrees: bool = False,
    timeline: str | int | None = None,
    robot: RobotModel | None = None,
    ignore_other: bool = False,
) -> Motion:
    """The motion in a file.

    Args:
        path: the file, or "-" for standard input.
        format: one of `FORMATS`; None finds out by the content, and by the suffix where the content does not say.
        degrees: turning joints are in degrees where neither the file nor its format says so: "csv" without units,
            "json" without "units", "naoqi" and "python". Elsewhere it changes nothing.
        timeline: which of several motions of a "xar", "python" or "bhuman" file: its name, or its number from 1.
        robot: whose joints may occur; None for the NAO.
        ignore_other: leave out what names no joint of the robot, with a `MotionFileWarning`.

    Raises:
        BadArgument: no file name.
        BadInputFile: one line that names the file and, where the format has them, line and column: unreadable, of
            unknown format, malformed, a joint unknown or given twice, a value that is no finite number, times that do
            not ascend, several motions and none chosen.
        UnknownName: no such format.

    Examples:
        >>> nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
        >>> nk.motion.write_motion(nod, "nod.json")
        >>> nk.motion.read_motion("nod.json").sample(0.5).tolist()
        [0.3]
    """
    name = file_name(path)
    if robot is not None:
        check_robot(robot)
    joints = BODY_ORDER if robot is None else (*robot.joint_names, *robot.mimics)
    which = None if timeline is None else str(timeline)
    source = Source(name, read_bytes(name, unpack=False), joints, degrees, which, ignore_other)
    if format is not None:
        return FORMATS[choice(format, FORMATS, "motion format")].read(source)
    if not source.data or source.data.isspace():
        raise BadInputFile(name, f"empty; expected a motion: {described_formats()}")
    return _recognised(source).read(source)


def formats_of_suffix(name: str) -> list[Format]:
    """The formats whose files end as a name does."""
    suffix = Path(name).suffix.lower()
    return [known for known in FORMATS.values() if suffix in known.suffixes]


def described_formats(*, written: bool = False) -> str:
    """All formats, or only those that are written, and their suffixes, for messages."""
    chosen = [known for known in FORMATS.values() if known.write is not None or not written]
    return ", ".join(f"{known.name} ({' '.join(known.suffixes)})" for known in chosen)


def _recognised(source: Source) -> Format:
    """The format of a file.

    Raises:
        BadInputFile: none or several of them.
    """
    by_suffix = formats_of_suffix(source.name)
    fitting = [known for known in FORMATS.values() if looks_like(known, source)]
    if len(fitting) > 1:
        fitting = [known for known in fitting if known in by_suffix] or fitting
    if len(fitting) == 1:
        return fitting[0]
    if fitting:
        listed = ", ".join(known.name for known in fitting)
        raise source.error(f"may be {listed}; choose one with format= or --from")
    if len(by_suffix) == 1:
        return by_suffix[0]
    if by_suffix or source.data.lstrip()[:1] in (b"{", b"["):
        _ = source.json  # malformed JSON is the more helpful news
    raise source.error(f"no motion file of a known format; expected {abbreviated(described_formats(), 400)}")


def looks_like(known: Format, source: Source) -> bool:
    """Whether a file has the content of a format."""
    try:
        return known.recognises(source)
    except BadInputFile:
        return False


# --- Writing motions: the format by its name or suffix, nothing overwritten unasked, all of a file or none of it.


def write_motion(
    motion: Motion,
    path: Path | str,
    *,
    format: str | None = None,
    rate: float | None = None,
    overwrite: bool = False,
) -> None:
    """Write a motion to a file.

    What a format cannot hold is an error where the file would be of no use, as joints that it has no place for, and
    else a `MotionFileWarning`, as curves in a format that knows straight lines only.

    Args:
        motion: what is written.
        path: the file.
        format: one of `FORMATS`, of which "bhuman" and "naodevils" are only read; None for the one that the suffix
            names, ".json" being "json".
        rate: write samples, so many a second, in the place of the keys.
        overwrite: an existing file may be replaced.

    Raises:
        BadArgument: no format, a file that exists or cannot be written, a motion that the format cannot hold.
        UnknownName: no such format.

    Examples:
        >>> nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
        >>> nk.motion.write_motion(nod, "nod.xar")
        >>> nk.motion.read_motion("nod.xar").joint_names
        ('HeadPitch',)
    """
    check_motion(motion)
    name = file_name(path)
    known = formats_of_suffix(name) if format is None else [FORMATS[choice(format, FORMATS, "motion format")]]
    if not known:
        raise BadArgument(
            f"no motion format for {abbreviated(path)}; name one with format= or --to, or end it in one of: "
            f"{described_formats(written=True)}"
        )
    chosen = known[0]
    if chosen.write is None:
        raise BadArgument(f"{chosen.name} files are only read; write one of: {described_formats(written=True)}")
    check_writable(path)
    target = replaced_file(path)
    if not overwrite and target is not None and target.exists():
        raise BadArgument(f"{abbreviated(path)} exists; overwrite=True replaces it")
    write_bytes(path, chosen.write(motion, rate))


# --- Whether a file holds a motion, or configurations without times.

# Configurations have these endings too; of a file with another one the ending tells.
_SHARED = (".csv", ".tsv", ".txt", ".json", "")
# A table may be larger than memory: its beginning tells.
_HEAD = 1 << 16
_JSON = re.compile(rb"(?:\xef\xbb\xbf)?\s*[\[{]")
# Long lists of configurations need not be read to the end.
_CONFIGURATIONS = re.compile(rb"(?:\xef\xbb\xbf)?\s*\[\s*\{")


def is_motion_file(path: Path | str, data: bytes | None = None) -> bool:
    """Whether a file is a motion file by its content, or by an ending that nothing else has.

    A table of joint values without a time column, and JSON objects of joint values, are none: they are what
    `nao_kin.stream.tables` reads. Nor is a file that cannot be read, or a pipe, which can be read only once.

    Args:
        path: the file.
        data: its content, where that has been read.

    Raises:
        BadArgument: path is no text and no Path.
    """
    if isinstance(path, str) and not path:
        return False
    suffix = Path(file_name(path)).suffix.lower()
    if suffix not in _SHARED and any(suffix in known.suffixes for known in FORMATS.values()):
        return True
    try:
        beginning = _beginning(path) if data is None else _cut(data)
    except (OSError, ValueError):
        return False
    if not beginning or _CONFIGURATIONS.match(beginning):
        return False
    source = Source(str(path), beginning, ())
    return any(looks_like(known, source) for known in FORMATS.values())


def _beginning(path: Path | str) -> bytes:
    """As much of a file as tells what it is: of JSON all, of anything else whole lines at its beginning."""
    if not Path(path).is_file():
        return b""
    with Path(path).open("rb") as file:
        head = file.read(_HEAD + 1)
        return head + file.read() if _JSON.match(head) and not _CONFIGURATIONS.match(head) else _cut(head)


def _cut(data: bytes) -> bytes:
    if len(data) <= _HEAD or _JSON.match(data):
        return data
    return data[: data.rfind(b"\n", 0, _HEAD) + 1] or data[:_HEAD]
