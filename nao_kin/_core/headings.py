"""Headings of tables of joint values: names and units, keys of NAOqi's devices, times, and an index.

time [s], HeadYaw [deg], LHand (%)
timestamp, Device/SubDeviceList/HeadYaw/Position/Sensor/Value

Times are numbers, or dates and times of ISO 8601. ROS messages of joint states are read as JSON lines, CSV without
headings and YAML, as tools print them:

{"header": {"stamp": {"sec": 7, "nanosec": 500000000}}, "name": ["HeadYaw"], "position": [0.1]}

7,500000000,,HeadYaw,0.1,0.0,0.0

header:
  stamp:
    sec: 7
    nanosec: 500000000
name:
- HeadYaw
position: [0.1]
---
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats, finite_decimal
from nao_kin._core.files import read_json
from nao_kin._core.text import MAX_SHOWN, quoted
from nao_kin.errors import BadInputFile

# Units that a heading may name, for joints whose values are in rad, m or ratios.
JOINT_UNITS = {"rad": ("rad", "deg", "°"), "m": ("m",), "1": ("1", "%")}
# Units that a heading may name for columns of sensors, the default first; those of others may be any.
SENSOR_UNITS = {"gyro": ("rad/s", "deg/s", "°/s"), "angles": ("rad", "deg", "°")}
# Columns of an inertial unit, in the order in which they are read.
INERTIAL = {
    "gyro": ("GyroX", "GyroY", "GyroZ"),
    "angles": ("AngleX", "AngleY"),
    "accelerometer": ("AccX", "AccY", "AccZ"),
}
# Units of times, and how many of each are in a second.
TIME_UNITS = {"s": 1.0, "ms": 1e3, "us": 1e6, "µs": 1e6, "ns": 1e9}
# The same units as others write them: spelled out (OptiTrack), with another letter µ, and in names such as time_s.
_SPELLED = {
    **{unit: unit for unit in TIME_UNITS},
    **dict.fromkeys(("sec", "secs", "second", "seconds"), "s"),
    **dict.fromkeys(("msec", "msecs", "millis", "millisecond", "milliseconds"), "ms"),
    **dict.fromkeys(("usec", "usecs", "micros", "microsecond", "microseconds", "\N{GREEK SMALL LETTER MU}s"), "us"),
    **dict.fromkeys(("nsec", "nsecs", "nanos", "nanosec", "nanosecond", "nanoseconds"), "ns"),
}
# Names of columns of times: of logs, PlotJuggler's, of a flattened ROS message, and with the unit at the end.
_TIME = re.compile(
    rf"(?:__)?(?:time|timestamp|t|stamp|header\.stamp)(?:_(?P<unit>{'|'.join(_SPELLED)}))?", re.IGNORECASE
)
# Words in names that are probably those of times, too.
_LIKE_TIME = re.compile(r"(?:^|[^a-z])(?:time|stamp|timestamp|clock)(?:$|[^a-z])", re.IGNORECASE)
_HEADING = re.compile(r"(?P<name>[^\[\]()]*?)\s*(?:[\[(]\s*(?P<unit>[^\[\]()]*?)\s*[\])])?")
# A longer text is no heading; matching it would take the square of its length.
LONGEST_HEADING = 200
_DEVICE = re.compile(r"(?:Device/SubDeviceList/)?(?P<joint>\w+)/Position/(?:Sensor|Actuator)/Value")
# Patterns are compiled when they are first used: most commands read no sensors.
# Names of sensors, of ALMemory, LoLA, ROS (Imu, nao_lola's messages) and rUNSWift, after the path to them.
_PATH = r"(?:.*[/.]|InertialSensor_)?"
_INERTIAL = (
    rf"{_PATH}(?:(?P<Gyro>gyro(?:scope)?|angular_velocity)|(?P<Acc>acc(?:elerometer)?|linear_acceleration)"
    r"|(?P<Angle>angles?))[/._]?(?P<axis>[xyz012])"
)
_FORCE = rf"{_PATH}(?P<side>[lr])_?foot(?:[/_]fsr)?[/_](?P<end>front|rear|back)_?(?P<half>left|right)"
_SOLE = rf"{_PATH}(?P<side>[lr])(?:fsr|(?:eft|ight)?_?foot(?:[/_]fsr)?[/_]?(?:total_?weight|(?P<contact>contact)))"
# Values in lists of LoLA and in vectors of ROS, and columns beside those of sensors that are never read.
_ENTRY = re.compile(r"(?P<list>.+)\[(?P<at>\d\d?|[xyz])\]")
_LIST = rf"{_PATH}(?P<list>position|fsr)s?"
_UNREAD = (
    rf"/.*|Device/SubDeviceList/.*|{_PATH}effectors/.*"
    rf"|{_PATH}(?:stiffness|temperature|current|status|battery|sonar|touch|robotconfig)\[\d+\]"
    rf"|{_PATH}(?:orientation[/._][xyzw]|\w+_covariance[\[/._]?\d\]?|header[/.\[].*)"
)
_PLOTTED = re.compile(r"(?P<topic>.*)/(?P<joint>[^/]+)/position")
# Headings of the index of pandas: in CSV, in CSV that pandas read and wrote again, and in Parquet.
_INDEX_NAMES = ("", "Unnamed: 0", "__index_level_0__")
# Clocks since 1970 show these seconds from 2001 until 2049; their rows follow each other faster than this [s].
_SINCE_1970, _LONGEST_STEP = (1e9, 2.5e9), 100.0
# A time step [s] above this is in a smaller unit: of frames, and of a log or a motion, whose keys may be farther apart.
_FRAME_STEP, _KEY_STEP = 1.0, 5.0
# Fewer rows than these may be keys at any distance.
_FEW_ROWS = 10
# The longest motion or skeleton [s], and the rates of its frames [Hz].
LONGEST, _RATES = 86_400.0, (1.0, 1000.0)
# The first times show the unit, so that it does not depend on how much of a log is read at once.
FIRST_TIMES = 100
_ISO_TIME = re.compile(
    r"(?P<date>\d{4}-\d\d-\d\d)[T ](?P<time>\d\d:\d\d(?::\d\d(?:[.,](?P<fraction>\d+))?)?) ?"
    r"(?P<zone>Z|(?P<sign>[+-])(?P<hours>[01]\d|2[0-3]):?(?P<minutes>[0-5]\d)?)?",
    re.ASCII,
)
_EPOCH = datetime(1970, 1, 1)


@dataclass(frozen=True)
class Heading:
    """The heading of a column: a name ("time", a joint, or another one), and the unit in brackets after it, or None."""

    name: str
    unit: str | None = None

    @property
    def is_time(self) -> bool:
        """Whether the column contains times."""
        return _TIME.fullmatch(self.name) is not None

    @property
    def time_unit(self) -> str | None:
        """The unit of times, one of `TIME_UNITS` if it is known: in brackets, or at the end of a name like time_s."""
        match = _TIME.fullmatch(self.name)
        unit = self.unit or (match and match["unit"])
        return None if unit is None else _SPELLED.get(unit.lower(), unit)


def read_heading(text: str) -> Heading:
    """Return the name and the unit of a heading; for a key of NAOqi's devices, the joint."""
    text = text.strip()
    match = _HEADING.fullmatch(text) if len(text) <= LONGEST_HEADING else None
    name, unit = (text, None) if match is None else (match["name"], match["unit"])
    device = _DEVICE.fullmatch(name)
    return Heading(name if device is None else device["joint"], unit)


def sensor_name(text: str) -> str:
    """Return the name of the sensor that a heading may name: AngleX, GyroX, AccX, LFoot/FSR/FrontLeft, LLeg/Contact.

    Names of the two soles of a NAO, such as LFsr, become LLeg/TotalWeight; a name of no sensor remains.
    """
    name = read_heading(text).name.removesuffix("/Sensor/Value")
    if match := re.fullmatch(_INERTIAL, name, re.IGNORECASE):
        kind = next(kind for kind in ("Gyro", "Acc", "Angle") if match[kind])
        return kind + "XYZXYZ"["xyz012".index(match["axis"].lower())]
    if match := re.fullmatch(_FORCE, name, re.IGNORECASE):
        end = "Front" if match["end"].lower() == "front" else "Rear"
        return f"{match['side'].upper()}Foot/FSR/{end}{match['half'].title()}"
    if match := re.fullmatch(_SOLE, name, re.IGNORECASE):
        return f"{match['side'].upper()}Leg/{'Contact' if match['contact'] else 'TotalWeight'}"
    return name


def entry_name(text: str, joints: Sequence[str], force_sensors: Sequence[str]) -> str:
    """Return the joint or sensor of a value in a list of LoLA or a vector of ROS, such as FSR[3]; or the text itself.

    `joints` and `force_sensors` are in the order of the lists.
    """
    match = None if "effectors" in text else _ENTRY.fullmatch(text.strip())
    if match is None:
        return text
    of_list, at = re.fullmatch(_LIST, match["list"], re.IGNORECASE), match["at"]
    if of_list is not None:
        names = joints if of_list["list"].lower() == "position" else force_sensors
        return names[int(at)] if at.isdigit() and int(at) < len(names) else text
    name = sensor_name(f"{match['list']}/{at}")
    return text if "/" in name else name


def is_never_read(text: str) -> bool:
    """Return whether a heading that names no joint and no sensor is one of ROS, ALMemory or LoLA."""
    return re.fullmatch(_UNREAD, text, re.IGNORECASE) is not None


def resembles_time(text: str) -> bool:
    """Return whether a heading that is not known to be that of times may be one, such as sample_time."""
    return _LIKE_TIME.search(text) is not None


def is_index(text: str) -> bool:
    """Return whether a heading says that the first column contains row numbers."""
    return text.strip() in _INDEX_NAMES


def joint_state_columns(headings: Sequence[str], first: Sequence[str]) -> dict[str, str | None]:
    """Return heading → joint, or None to skip it, of ROS messages of joint states in CSV; other tables give nothing.

    As `rostopic echo -p` prints them, the joint of column field.position3 is in column field.name3 of every row;
    `first` is the first one. PlotJuggler writes a column /joint_states/HeadYaw/position.
    """
    plotted = {heading: match for heading in headings if (match := _PLOTTED.fullmatch(heading))}
    if plotted:
        topics = tuple({f"{match['topic']}/" for match in plotted.values()})
        others = {heading: None for heading in headings if heading.startswith(topics)}
        return others | {heading: match["joint"] for heading, match in plotted.items()}
    at = {heading: index for index, heading in enumerate(headings)}
    joints = {}
    for heading in headings:
        place = at.get(heading.replace("position", "name"))
        if heading.startswith("field.position") and place is not None and place < len(first):
            joints[heading] = first[place]
    return {heading: None for heading in headings if joints and heading.startswith("field.")} | joints


def is_joint_state(value: object) -> bool:
    """Return whether a JSON value is a ROS JointState, or the message of rosbridge that contains one."""
    message = _message(value)
    return isinstance(message, dict) and all(isinstance(message.get(name), list) for name in ("name", "position"))


def joint_state_values(value: Any) -> dict[str, Any]:
    """Return joint → position, and the time if the header has a stamp, of a JSON value with `is_joint_state`.

    Raises ValueError unless there is one position for each name.
    """
    message = _message(value)
    names, positions = message["name"], message["position"]
    if len(names) != len(positions) or not all(isinstance(name, str) for name in names):
        raise ValueError(f"a JointState with {len(positions)} positions for {len(names)} names")
    found = dict(zip(names, positions, strict=True))
    if len(found) < len(names):
        raise ValueError("a JointState that names a joint twice")
    header = message.get("header")
    stamp = header.get("stamp") if isinstance(header, dict) else None
    if isinstance(stamp, dict):
        whole, rest = (stamp.get(ros_2, stamp.get(ros_1)) for ros_2, ros_1 in (("sec", "secs"), ("nanosec", "nsecs")))
        if type(whole) is int and type(rest) is int:
            found["time [s]"] = whole + rest / TIME_UNITS["ns"]
    return found


def _message(value: Any) -> Any:
    return value.get("msg", value) if isinstance(value, dict) else value


_NOT_A_NUMBER = ("nan", ".nan")
# Fields of `ros2 topic echo --csv` before the names: seconds, nanoseconds, and the frame.
_BEFORE = 3
_ROW = re.compile(r"\d{1,19},\d{1,9},[^,]*,[A-Za-z_]", re.ASCII)
_FIRST_KEYS = ("header:", "---\n", "name:")
_STAMP = re.compile(r"\b(n?secs?|nanosec): *(\d{1,19})", re.ASCII)


def printed_messages(name: str, text: str) -> list[Any] | None:
    """Return the JSON objects of JSON lines, or the joint states that `topic echo` printed; None for other texts."""
    begin = text.lstrip()
    if begin.startswith("{") or _ROW.match(begin):
        lines = {at: line for at, line in enumerate(map(str.strip, text.splitlines()), start=1) if line}
        if not begin.startswith("{"):
            return [_of_csv(name, line, at) for at, line in lines.items()]
        several = len(lines) > 1 and all(line.startswith("{") and line.endswith("}") for line in lines.values())
        return [_of_json(name, line, at) for at, line in lines.items()] if several else None
    if begin.startswith(_FIRST_KEYS):
        return [_of_yaml(part) for part in re.split(r"^---$", text, flags=re.MULTILINE) if part.strip()]
    return None


def _of_json(name: str, line: str, at: int) -> Any:
    """Return the JSON value in a line."""
    try:
        return read_json(name, line)
    except BadInputFile as error:
        raise BadInputFile(name, error.reason, at, error.column) from None


def _of_csv(name: str, line: str, at: int) -> dict[str, Any]:
    """Return the joint state in a row: names, as many positions, and perhaps velocities and efforts."""
    if not _ROW.match(line):
        expected = "seconds, nanoseconds, a frame, names and positions, as in the first row"
        raise BadInputFile(name, f"expected {expected}, got {quoted(line, MAX_SHOWN)}", at)
    fields = line.split(",")
    values = fields[_BEFORE:]
    count = next((k for k, field in enumerate(values) if is_decimal(field) or field in _NOT_A_NUMBER), len(values))
    stamp = {"sec": int(fields[0]), "nanosec": int(fields[1])}
    return _joint_state(stamp, values[:count], values[count : 2 * count])


def _of_yaml(text: str) -> dict[str, Any]:
    """Return the joint state in a document of `ros2 topic echo` or `rostopic echo`."""
    lists: dict[str, list[str]] = {}
    current: list[str] = []
    for line in text.splitlines():
        key, sign, rest = line.partition(":")
        if sign and not line.startswith((" ", "-")):
            current = lists.setdefault(key, [])
            current += [entry.strip(" '\"") for entry in rest.strip(" []").split(",") if entry.strip()]
        elif line.lstrip().startswith("- "):
            current.append(line.strip()[2:].strip("'\""))
    stamp = {key: int(value) for key, value in _STAMP.findall(text)}
    return _joint_state(stamp, lists.get("name", []), lists.get("position", []))


def _joint_state(stamp: dict[str, int], names: list[str], positions: list[str]) -> dict[str, Any]:
    """Return the joint state as JSON has it; a position that is no number remains a text, which its reader refuses."""
    numbers = [math.nan if one in _NOT_A_NUMBER else finite_decimal(one) for one in positions]
    values = [one if number is None else number for one, number in zip(positions, numbers, strict=True)]
    return {"header": {"stamp": stamp}, "name": names, "position": values}


def in_si_units(values: Floats, units: Sequence[str]) -> Floats:
    """Convert values (n, k), with one unit for each column, to rad, rad/s, m and ratios."""
    given = np.array(units)
    degrees, percent = np.isin(given, ("deg", "°", "deg/s", "°/s")), given == "%"
    if not degrees.any() and not percent.any():
        return values
    values = np.where(degrees, np.radians(values), values)
    return np.where(percent, values / 100.0, values)


COLUMN_ADVICE = "a heading such as time [s], or columns= (--columns), says otherwise"


def guessed_time_unit(times: Floats, *, frames: bool = False, advice: str = COLUMN_ADVICE) -> tuple[str, str]:
    """Return the unit of times for which a file states none, and a note if it is not plain seconds.

    The size of the first times decides if it is that of a clock since 1970; else their step, which is at most 1 s for
    `frames` of a recording, and 5 s for rows that may also be the keys of a motion. `advice` ends the note.
    """
    first = times[np.isfinite(times)][:FIRST_TIMES]
    size = float(np.median(np.abs(first))) if first.size else 0.0
    step = float(np.median(np.abs(np.diff(first)))) if len(first) > 1 else 0.0
    units = ("s", "ms", "us", "ns")
    low, high = _SINCE_1970
    since = [
        unit for unit in units if low <= size / TIME_UNITS[unit] < high and step <= _LONGEST_STEP * TIME_UNITS[unit]
    ]
    if since:
        unit, how = since[0], "since 1970, by their size"
    elif frames or len(first) >= _FEW_ROWS:
        longest = (_FRAME_STEP if frames else _KEY_STEP, *(_FRAME_STEP * TIME_UNITS[unit] for unit in units[1:-1]))
        unit, how = units[sum(step > limit for limit in longest)], f"by their step of {step:.6g}"
    else:
        unit, how = "s", ""
    if unit != "s":
        return unit, f"times are taken as {unit} {how}; {advice}"
    odd = step > _FRAME_STEP and not since
    return unit, f"times are taken as s, {step:.6g} s from row to row; {advice}" if odd else ""


def seconds_of(
    name: str, times: Floats, unit: str | None = None, *, frames: bool = False, advice: str = COLUMN_ADVICE
) -> tuple[Floats, str]:
    """Return the times of a file in seconds, and a note if their unit is guessed, as by `guessed_time_unit`.

    Raises:
        BadInputFile: times that do not ascend, or of more than a day; for `frames` also a rate outside 1 to 1000 Hz.
    """
    guessed, note = guessed_time_unit(times, frames=frames, advice=advice)
    seconds = times / TIME_UNITS[unit or guessed]
    steps = np.diff(seconds)
    if not (steps > 0.0).all():
        row = int(np.argmin(steps > 0.0)) + 1
        raise BadInputFile(name, f"times must ascend, but {times[row]:.9g} follows {times[row - 1]:.9g} (time {row})")
    refuse_long(name, seconds)
    rate = 1.0 / float(np.median(steps)) if len(steps) else _RATES[0]
    # A rate that is rounded to milliseconds may be somewhat beyond.
    if frames and not 0.99 * _RATES[0] <= rate <= 1.01 * _RATES[1]:
        raise BadInputFile(name, f"{rate:.6g} frames per second, expected 1 to 1000; {advice}")
    return seconds, "" if unit else note


def refuse_long(name: str, seconds: Floats) -> None:
    """Refuse ascending times that last more than a day: what is done for each moment would not end."""
    if len(seconds) and seconds[-1] - seconds[0] > LONGEST:
        steps = np.diff(seconds)
        row = int(steps.argmax())
        step = f"{steps[row]:.6g} s of them from {seconds[row]:.9g} s to the next"
        lasts = f"lasts {seconds[-1] - seconds[0]:.6g} s, {step}"
        raise BadInputFile(name, f"{lasts}; expected at most a day, {LONGEST:g} s (is the unit of the times stated?)")


@dataclass(frozen=True)
class IsoTimes:
    """ISO 8601 times, such as 2026-03-01T12:00:00.5Z, as seconds from the first one."""

    start: int  # the first time, in nanoseconds since 1970; in UTC if it has a time zone
    zoned: bool  # whether all times have a time zone: Z or an offset from UTC

    @classmethod
    def of(cls, texts: Iterable[str]) -> IsoTimes | None:
        """Return the reader of a column whose first time or number is an ISO 8601 time; None if it is a number."""
        for text in texts:
            found = _iso_time(text)
            if found is not None:
                return cls(*found)
            if is_decimal(text):
                return None
        return None

    def seconds(self, text: str) -> float:
        """Return a time in seconds since the first; ValueError if invalid, or if only one has a time zone."""
        found = _iso_time(text)
        shown = quoted(text.strip(), MAX_SHOWN)
        if found is None:
            raise ValueError(f"is {shown}, expected a time such as 2026-03-01T12:00:00.5")
        if found[1] != self.zoned:
            has, first = ("no time zone", "has one") if self.zoned else ("a time zone", "has none")
            raise ValueError(f"is {shown}, which has {has}; the first time {first}")
        return (found[0] - self.start) / 1e9

    def all_seconds(self, texts: Iterable[str]) -> list[float]:
        """Return `seconds` of many texts; NaN for each invalid one."""
        found = map(_iso_time, texts)
        return [math.nan if one is None or one[1] != self.zoned else (one[0] - self.start) / 1e9 for one in found]


def is_decimal(text: str) -> bool:
    """Return whether a text is a decimal number, with a point or a comma."""
    return finite_decimal(text.replace(",", ".")) is not None


def is_iso_time(text: str) -> bool:
    """Return whether a text is a date and a time of ISO 8601."""
    return _iso_time(text) is not None


def _iso_time(text: str) -> tuple[int, bool] | None:
    """Return the nanoseconds since 1970, and whether the text gives a time zone; None if it is not a time."""
    match = _ISO_TIME.fullmatch(text.strip())
    if match is None:
        return None
    date, time, fraction, zone, sign, hours, minutes = match.groups()
    try:
        since = datetime.fromisoformat(f"{date}T{time[:8]}") - _EPOCH
    except ValueError:  # the 30th of February
        return None
    if sign:
        offset = timedelta(hours=int(hours), minutes=int(minutes or 0))
        since += offset if sign == "-" else -offset
    nanoseconds = int(fraction[:9].ljust(9, "0")) if fraction else 0
    return (since.days * 86400 + since.seconds) * 10**9 + nanoseconds, zone is not None
