"""Read and write motion files of many formats, and recognise the formats."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from types import MappingProxyType

import numpy as np

from nao_kin._core.arrays import choice, flag
from nao_kin._core.files import check_replaceable, read_bytes, write_bytes
from nao_kin._core.text import abbreviated
from nao_kin.errors import BadArgument, BadInputFile
from nao_kin.motion.editing import resample
from nao_kin.motion.files.choregraphe import XAP, XAR
from nao_kin.motion.files.hulks import HULKS, MOTION2
from nao_kin.motion.files.key_frames import BHUMAN, NAODEVILS
from nao_kin.motion.files.own import CSV, JSON, NPZ, write_csv
from nao_kin.motion.files.python_scripts import NAOQI, PYTHON
from nao_kin.motion.files.runswift import RUNSWIFT
from nao_kin.motion.files.source import Format, MotionSource, file_name
from nao_kin.motion.files.webots import WEBOTS
from nao_kin.motion.motion import Motion
from nao_kin.robot import RobotModel
from nao_kin.robot.nao import BODY_ORDER

# --- Reading: the formats of the suffix are tried first, then all others, each by the content.

_FORMATS = (CSV, JSON, NPZ, WEBOTS, RUNSWIFT, HULKS, MOTION2, NAODEVILS, BHUMAN, PYTHON, XAR, XAP, NAOQI)
# Formats whose files may contain several motions.
_OF_SEVERAL = (XAR, XAP, PYTHON, BHUMAN)
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
    """Read the motion in a file.

    `nk.stream.read_log` reads a table of all joints as configurations.

    Args:
        path: the file, or "-" for standard input.
        format: one of `FORMATS`; None recognises it by the suffix, if the content is that of its format, or else by
            the content.
        degrees: turning joints are in degrees if neither the file nor its format says otherwise: "csv" without units,
            "json" without "units", "naoqi" and "python".
        timeline: one of several motions of a "xar", "python" or "bhuman" file, or one of several poses of a "xap" file:
            its name, or its number from 1.
        robot: the robot whose joints are accepted; None for the NAO.
        ignore_other: leave out names that are not joints of the robot, with a `MotionFileWarning`.

    Raises:
        BadInputFile: the file is unreadable, of unknown format or malformed; a joint is unknown or given twice; a value
            is not a finite number; times do not ascend; or there are several motions and `timeline` chooses none. The
            message is one line, with the file and, if possible, line and column.

    Examples:
        >>> nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
        >>> nk.motion.write_motion(nod, "nod.json")
        >>> nk.motion.read_motion("nod.json").sample(0.5).tolist()
        [0.3]
    """
    name = file_name(path)
    joints = BODY_ORDER if robot is None else (*robot.joint_names, *robot.mimics)
    which = None if timeline is None else str(timeline)
    source = MotionSource(name, read_bytes(name, unpack=False), joints, degrees, which, ignore_other)
    if format is not None:
        known = FORMATS[choice(format, FORMATS, "motion format")]
    elif not source.data or source.data.isspace():
        raise BadInputFile(name, f"empty; expected a motion: {described_formats()}")
    else:
        known = _recognised(source)
    if which is not None and known not in _OF_SEVERAL:
        listed = ", ".join(other.name for other in _OF_SEVERAL)
        raise source.error(f"one motion, and timeline= or --timeline chooses one of several, in files of {listed}")
    with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is refused
        return known.read(source)


def formats_of_suffix(name: str) -> list[Format]:
    """Return the formats with the suffix of a name."""
    suffix = Path(name).suffix.lower()
    return [known for known in FORMATS.values() if suffix in known.suffixes]


def described_formats(*, written: bool = False) -> str:
    """Return all formats, or only those that are written, with their suffixes, for messages."""
    chosen = [known for known in FORMATS.values() if known.write is not None or not written]
    return ", ".join(f"{known.name} ({' '.join(known.suffixes)})" for known in chosen)


def _recognised(source: MotionSource) -> Format:
    """Return the format of a file."""
    if _is_package(source.data):
        raise source.error("a package of Choregraphe; unpack it (ar, tar or unzip) and read the behavior.xar in it")
    by_suffix = formats_of_suffix(source.name)
    fitting = [known for known in by_suffix if looks_like(known, source)]
    fitting = fitting or [known for known in FORMATS.values() if looks_like(known, source)]
    if len(fitting) == 1:
        return fitting[0]
    if fitting:
        listed = ", ".join(known.name for known in fitting)
        raise source.error(f"may be {listed}; choose one with format= or --from")
    if len(by_suffix) == 1:
        return by_suffix[0]
    if by_suffix or source.data.lstrip()[:1] in (b"{", b"["):
        _ = source.json  # raises the more helpful error for malformed JSON
    raise source.error(f"no motion file of a known format; expected {abbreviated(described_formats(), 400)}")


def _is_package(data: bytes) -> bool:
    """Return whether a file is one of Choregraphe's packages: a Debian archive (.crg), or a zip file (.pkg)."""
    return data.startswith(b"!<arch>\n") or (data.startswith(b"PK\x03\x04") and b"manifest.xml" in data)


def looks_like(known: Format, source: MotionSource) -> bool:
    """Return whether a file has the content of a format."""
    try:
        return known.recognises(source)
    except BadInputFile:
        return False


# --- Writing: the format is given, or determined by the suffix; a file is written completely or not at all.


def write_motion(
    motion: Motion,
    path: Path | str,
    *,
    format: str | None = None,
    rate: float | None = None,
    degrees: bool = False,
    overwrite: bool = False,
) -> None:
    """Write a motion to a file.

    Joints that a format does not support raise an error; a linear format loses curves, and NAOqi refuses keys at
    0 s, both with a `MotionFileWarning`.

    Args:
        motion: the motion to write.
        path: the file.
        format: one of `FORMATS` except "bhuman", "naodevils" and "xap", which are only read; None for the format of the
            suffix, which is "json" for ".json".
        rate: samples per second to write instead of the keys.
        degrees: write "csv" in degrees, as its headings then say; the other formats have one unit each.
        overwrite: replace an existing file.

    Raises:
        BadArgument: no format, a file that exists or cannot be written, a motion that the format cannot represent.

    Examples:
        >>> nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
        >>> nk.motion.write_motion(nod, "nod.xar")
        >>> nk.motion.read_motion("nod.xar").joint_names
        ('HeadPitch',)
    """
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
    check_replaceable(path, overwrite=overwrite)
    write = partial(write_csv, angle="deg") if flag(degrees, "degrees") and chosen is CSV else chosen.write
    write_bytes(path, write(motion if rate is None else resample(motion, rate), motion))


# --- Files with a motion, or with configurations without times.

# Suffixes that files of configurations have too; any other suffix is unambiguous.
_SHARED = (".csv", ".tsv", ".txt", ".json", "")
# Bytes to read of a table, which may be larger than memory.
_HEAD = 1 << 16
_JSON = re.compile(rb"(?:\xef\xbb\xbf)?\s*[\[{]")
# The beginning of a list of configurations, which is not read to its end.
_CONFIGURATIONS = re.compile(rb"(?:\xef\xbb\xbf)?\s*\[\s*\{")


def is_motion_file(path: Path | str, data: bytes | None = None) -> bool:
    """Return whether a file is a motion file, by its content or by an unambiguous suffix.

    Tables of joint values without a time column, and JSON objects of joint values, are not motion files:
    `nao_kin.stream` reads them. Nor are unreadable files, and pipes, which can be read only once. `data` is the
    content, if it has been read.
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
    source = MotionSource(str(path), beginning, ())
    return _is_package(beginning) or any(looks_like(known, source) for known in FORMATS.values())


def _beginning(path: Path | str) -> bytes:
    """Return the beginning of a file that shows its format: all of JSON, whole lines of anything else."""
    if not Path(path).is_file():
        return b""
    with Path(path).open("rb") as file:
        head = file.read(_HEAD + 1)
        return head + file.read() if _JSON.match(head) and not _CONFIGURATIONS.match(head) else _cut(head)


def _cut(data: bytes) -> bytes:
    if len(data) <= _HEAD or _JSON.match(data):
        return data
    return data[: data.rfind(b"\n", 0, _HEAD) + 1] or data[:_HEAD]
