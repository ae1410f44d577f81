"""Webots' .motion: poses of some joints at times, * for joints that are not commanded.

    #WEBOTS_MOTION,V1.0,HeadYaw,LShoulderPitch
    00:00:000,Pose1,0.0,1.4
    00:00:040,Pose2,0.1,*

Source: cyberbotics/webots, src/controller/c/motion.c. Times are [[minutes:]seconds:]milliseconds and ascend, angles are
in radians. A pose has a name and one value for each joint; straight lines connect the poses. An empty line ends the
file. Some files have the names on a second line, which Webots does not read.
Webots' own motions of the NAO name the eight motors of each hand, LPhalanx1 to LPhalanx8: 0 closed, 1 rad open.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._core.text import MAX_SHOWN, quoted
from nao_kin._core.warn import warn_caller
from nao_kin.errors import BadArgument
from nao_kin.motion.files.key_frames import held_keys
from nao_kin.motion.files.source import FilePosition, Format, MotionFileWarning, MotionSource, has_line
from nao_kin.motion.files.tracks import Track, check_times, milliseconds, motion_of, straight_rows
from nao_kin.motion.motion import Motion

_HEADER, _VERSION = "#WEBOTS_MOTION", "V1.0"
_TIME = re.compile(r"(?:(?:(\d{1,9}):)?(\d{1,9}):)?(\d{1,9})", re.ASCII)
_HOLD = "*"
_FINGER = re.compile(r"([LR])Phalanx[1-8]")
_EQUAL = 1e-6
# Webots reads a line into a buffer of 4096 characters.
_MAX_LINE = 4094


def read(source: MotionSource) -> Motion:
    """Read the motion in a Webots file.

    A cell with * is not a key: before its first value a joint has no key, between two values it keeps the first one up
    to the last *, after the last value it is at rest. (Webots commands nothing next to a *, and jumps where this motion
    follows a straight line from the last * to the next value.)
    """
    lines = source.lines
    names, first = _names(source, lines)
    head = first.line
    count = next((row for row, line in enumerate(lines) if row and not line.strip()), len(lines))
    for row in range(count, len(lines)):
        if lines[row].strip():
            raise source.error("a line after an empty line, where Webots stops reading", FilePosition(row + 1))
    times, rows = [], []
    for number, line in enumerate(lines[head:count], start=head + 1):
        fields = line.split(",")
        if len(fields) == len(names) + 3 and not fields[-1].strip():
            del fields[-1]
        if len(fields) != len(names) + 2:
            got = f"{len(fields)} fields"
            raise source.error(f"{got}, expected a time, a pose name and {len(names)} values", FilePosition(number))
        times.append(_seconds(source, fields[0], number))
        rows.append(source.decimals(fields[2:], names, FilePosition(number, 3).field, _HOLD))
    if not rows:
        raise source.error("a header and no poses", FilePosition(1))
    stamps = check_times(source, np.array(times), lambda row: FilePosition(row + head + 1, 1))
    table = np.array(rows)
    if np.isnan(table).all():
        raise source.error("no pose has a value")
    # A last pose without any value still sets the duration.
    ends_empty = np.isnan(table[-1]).all()
    tracks = []
    for joint, place, column in _columns(source, names, first, table):
        at, keys = held_keys(column)
        if not len(at):
            warn_caller(f"{source.name}: {joint} has no value in any pose and is left out", MotionFileWarning)
            continue
        if ends_empty:
            at, keys = np.append(at, len(stamps) - 1), np.append(keys, keys[-1])
        own = stamps if len(at) == len(stamps) else stamps[at]
        tracks.append(Track(joint, own, keys, place=place))
    return motion_of(source, tracks)


def _columns(
    source: MotionSource, names: list[str], first: FilePosition, table: Floats
) -> Iterator[tuple[str, FilePosition, Floats]]:
    """Yield each joint, its place and its values; the motors of a hand become one joint with their mean."""
    fingers: dict[str, list[int]] = {}
    for column, name in enumerate(names):
        hand = _hand_of(source, name)
        if hand is None or hand in names:
            yield name, first.field(column), table[:, column]
        else:
            fingers.setdefault(hand, []).append(column)
    for hand, columns in fingers.items():
        values = table[:, columns]
        count = (~np.isnan(values)).sum(axis=1)
        mean = np.divide(np.nansum(values, axis=1), count, out=np.full(len(values), math.nan), where=count > 0)
        off = float(np.nanmax(np.abs(values - mean[:, None]), initial=0.0))
        if off > _EQUAL:
            warn_caller(
                f"{source.name}: {hand} is the mean of its {len(columns)} motors, which differ from it by up to "
                f"{off:.3g} rad",
                MotionFileWarning,
            )
        yield hand, first.field(columns[0]), mean


def _hand_of(source: MotionSource, name: str) -> str | None:
    """Return the hand that a motor of Webots moves, if the robot has that hand and no joint of the motor's name."""
    match = _FINGER.fullmatch(name)
    hand = None if match is None or name in source.joints else f"{match[1]}Hand"
    return hand if hand in source.joints else None


def _names(source: MotionSource, lines: list[str]) -> tuple[list[str], FilePosition]:
    """Return the names of the joints, and the place of the first: on the first line, or alone on the second."""
    fields, first = [field.strip() for field in lines[0].split(",")], FilePosition(1, 3)
    if fields[0] != _HEADER:
        raise source.error(f"expected {_HEADER}, got {quoted(fields[0], MAX_SHOWN)}", FilePosition(1, 1))
    if len(fields) < 2 or fields[1] != _VERSION:
        got = quoted(fields[1], MAX_SHOWN) if len(fields) > 1 else "nothing"
        raise source.error(f"expected version {_VERSION}, got {got}", FilePosition(1, 2))
    if not any(fields[2:]) and len(lines) > 1 and not _TIME.match(lines[1]):
        fields, first = [*fields[:2], *(field.strip() for field in lines[1].split(","))], FilePosition(2, 1)
    names = fields[2:-1] if len(fields) > 3 and not fields[-1] else fields[2:]
    if not any(names):
        raise source.error("the header names no joints", FilePosition(1))
    for column, name in enumerate(names):
        if _hand_of(source, name) is None or f"{name[0]}Hand" in names:
            source.check_joint(name, first.field(column))
        if name in names[:column]:
            raise source.error(f"joint {name} is given twice", first.field(column))
    return names, first


def _seconds(source: MotionSource, field: str, line: int) -> float:
    match = _TIME.fullmatch(field.strip())
    if match is None:
        shown = quoted(field.strip(), MAX_SHOWN)
        raise source.error(f"time {shown}, expected minutes:seconds:milliseconds", FilePosition(line, 1))
    minutes, seconds, thousandths = (int(group or 0) for group in match.groups())
    return (minutes * 60000 + seconds * 1000 + thousandths) / 1000


def write(motion: Motion, original: Motion) -> bytes:
    """Write a pose at each key time; a joint has * before its first and after its last key in the original motion."""
    times, values = straight_rows(motion, "Webots motion")
    stamps = milliseconds(times, "Webots motion")
    for joint in motion.joint_names:
        if not re.fullmatch(r"[^,\r\n]+", joint) or joint != joint.strip():
            raise BadArgument(f"a Webots motion file cannot hold the joint {quoted(joint)}")
    free = np.stack([(times < own[0]) | (times > own[-1]) for own in original.times], axis=-1)
    lines = [",".join([_HEADER, _VERSION, *motion.joint_names])]
    rows = zip(stamps, values.tolist(), free.tolist(), strict=True)
    for number, (stamp, row, holds) in enumerate(rows, start=1):
        minutes, rest = divmod(stamp, 60000)
        cells = (_HOLD if hold else repr(value) for value, hold in zip(row, holds, strict=True))
        lines.append(",".join([f"{minutes:02d}:{rest // 1000:02d}:{rest % 1000:03d}", f"Pose{number}", *cells]))
    longest = max(map(len, lines))
    if longest > _MAX_LINE:
        raise BadArgument(f"Webots reads lines of at most {_MAX_LINE} characters, one here has {longest}")
    return ("\n".join(lines) + "\n").encode()


WEBOTS = Format("webots", (".motion",), "Webots' motion file", has_line(re.compile(rf"\A{_HEADER}")), read, write)
