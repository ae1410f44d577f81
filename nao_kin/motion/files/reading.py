"""Reading motions: which format a file has, told by its content first, then by its suffix."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from nao_kin._text import abbreviated
from nao_kin.errors import BadInputFile, UnknownName
from nao_kin.motion.files.bhuman import BHUMAN
from nao_kin.motion.files.choregraphe_python import PYTHON
from nao_kin.motion.files.choregraphe_xar import XAR
from nao_kin.motion.files.csv_table import CSV
from nao_kin.motion.files.format import Format
from nao_kin.motion.files.hulks import HULKS
from nao_kin.motion.files.hulks_motion2 import MOTION2
from nao_kin.motion.files.json_keys import JSON
from nao_kin.motion.files.naodevils import NAODEVILS
from nao_kin.motion.files.naoqi_arguments import NAOQI
from nao_kin.motion.files.npz import NPZ
from nao_kin.motion.files.runswift import RUNSWIFT
from nao_kin.motion.files.source import Source, file_name, read_bytes
from nao_kin.motion.files.webots import WEBOTS
from nao_kin.motion.motion import Motion
from nao_kin.parameters import BODY_ORDER
from nao_kin.robot import RobotModel, check_robot

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
    source = Source(name, read_bytes(name), joints, degrees, which, ignore_other)
    if format is not None:
        return format_named(format).read(source)
    if not source.data or source.data.isspace():
        raise BadInputFile(name, f"empty; expected a motion: {described_formats()}")
    return _recognised(source).read(source)


def format_named(name: str) -> Format:
    """The format of a name.

    Raises:
        UnknownName: there is none.
    """
    if not isinstance(name, str) or name not in FORMATS:
        raise UnknownName("motion format", name, tuple(FORMATS))
    return FORMATS[name]


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
        assert source.json  # malformed JSON is the more helpful news
    raise source.error(f"no motion file of a known format; expected {abbreviated(described_formats(), 400)}")


def looks_like(known: Format, source: Source) -> bool:
    """Whether a file has the content of a format."""
    try:
        return known.recognises(source)
    except BadInputFile:
        return False
