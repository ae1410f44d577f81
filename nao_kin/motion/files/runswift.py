"""rUNSWift's .pos: all joints in degrees, milliseconds to reach each pose, short names as a comment.

      HY    HP    LSP  …  LH    RH    DUR
    $ 0.5   1     1    …  1     1
    ! 0     30    90   …  0     0     500

Source: UNSWComputing/rUNSWift-2023-release, robot/motion/generator/ActionGenerator.cpp and
image/home/nao/data/pos/README.md. Lines that begin with ! are poses: 25 numbers in degrees, hands too, in the order of
LoLA, and the duration of the straight line to the pose in whole milliseconds. The first line starts at the robot's
current pose. Lines that begin with $ are the stiffnesses of the next pose; all other lines are comments.

Before 2019 (UNSWComputing/rUNSWift-2018-release, the same files) nothing marks a pose, comments begin with #, and each
hand comes after its wrist. A stiffness of -1 switches a motor off.
"""

from __future__ import annotations

import math
import re

import numpy as np

from nao_kin._core.text import MAX_SHOWN, quoted
from nao_kin.motion.files.source import FilePosition, Format, MotionSource
from nao_kin.motion.files.tracks import Track, check_times, milliseconds, motion_of, nao_rows
from nao_kin.motion.motion import Motion
from nao_kin.robot.nao import BODY_ORDER

# Of the NAO's 25 motors, hands last; the short name of a joint is its capital letters.
_HANDS = ("LHand", "RHand")
_JOINTS = (*(joint for joint in BODY_ORDER if joint not in ("RHipYawPitch", *_HANDS)), *_HANDS)
SHORT_NAMES = {"".join(filter(str.isupper, joint)): joint for joint in _JOINTS}
_DURATION = "DUR"
# The order before 2019.
_OLD_ORDER = ["".join(filter(str.isupper, joint)) for joint in BODY_ORDER if joint != "RHipYawPitch"]
_MARKED = re.compile(r"^![ \t]*[-+.\d]", re.MULTILINE | re.ASCII)
# A pose before 2019, in a file with a comment of short names.
_OLD_NAMES = re.compile(r"^[#\s]*HY[ \t]+HP[ \t]+LSP\b", re.MULTILINE)
_OLD_POSE = re.compile(r"^[ \t]*(?:[-+]?[.\d]+(?:[ \t]+|(?=[-+]))){25}\d+[ \t]*(?:#.*)?$", re.MULTILINE | re.ASCII)
# A sign begins a number also without a blank before it, for C++ reads `-33.2-89.9` as two.
_WORD = re.compile(r"[^\s!$](?:[^\s!$+-]|(?<=[eE])[-+])*")
_OFF = -1.0  # stiffness of a motor that is switched off
_WIDTH = 6


def _recognises(source: MotionSource) -> bool:
    """Return whether a line is a pose."""
    return bool(_MARKED.search(source.text) or (_OLD_NAMES.search(source.text) and _OLD_POSE.search(source.text)))


def read(source: MotionSource) -> Motion:
    """Read the motion in a .pos file; a comment with all short names sets the order of the numbers after it."""
    old = _MARKED.search(source.text) is None
    order = _OLD_ORDER if old else list(SHORT_NAMES)
    rows, lines = list[list[float]](), list[int]()
    for number, line in enumerate(source.lines, start=1):
        if line.startswith("!") or (old and line.lstrip()[:1] in tuple("+-.0123456789")):
            values = _numbers(source, line.partition("#")[0], number, [*order, _DURATION])
            duration = values.pop()
            if duration < 0.0 or duration != math.floor(duration) or (duration == 0.0 and rows):
                column = list(_WORD.finditer(line))[len(order)].start() + 1
                raise source.error(
                    f"{_DURATION} is {duration:g} ms, expected whole milliseconds > 0", FilePosition(number, column)
                )
            row = dict(zip(order, values, strict=True))
            rows.append([row[short] for short in SHORT_NAMES] + [duration])
            lines.append(number)
        elif line.startswith("$"):
            for value in _numbers(source, line.partition("#")[0], number, order):
                if not 0.0 <= value <= 1.0 and value != _OFF:
                    raise source.error(f"stiffness {value:g}, expected 0 to 1, or {_OFF:g}", FilePosition(number))
        else:
            order = _order(source, line, number) or order
    if not rows:
        raise source.error("no pose: no line begins with !, or is a row of 25 values and a duration")
    table = np.array(rows)
    times = np.cumsum(table[:, -1]) / 1e3
    check_times(source, times, lambda row: FilePosition(lines[row]))
    angles = np.radians(table[:, :-1].T)
    tracks = [Track(joint, times, keys) for joint, keys in zip(_JOINTS, angles, strict=True)]
    return motion_of(source, tracks)


def _order(source: MotionSource, line: str, number: int) -> list[str] | None:
    """Return the short names in a comment that is a row of them; None for any other comment."""
    words = line.strip("# \t").split()
    if len(words) < len(SHORT_NAMES) or words[0] not in SHORT_NAMES or words[1] not in SHORT_NAMES:
        return None
    names = words[:-1] if words[-1] == _DURATION else words
    for word in _WORD.finditer(line.replace("#", " ")):
        if word[0] not in SHORT_NAMES and word[0] != _DURATION:
            shown = quoted(word[0], MAX_SHOWN)
            raise source.error(f"{shown} among the short names of joints", FilePosition(number, word.start() + 1))
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise source.error(f"joint {twice} is given twice", FilePosition(number))
    missing = [short for short in SHORT_NAMES if short not in names]
    if missing:
        raise source.error(f"the row of short names lacks {', '.join(missing)}", FilePosition(number))
    return names


def _numbers(source: MotionSource, line: str, number: int, names: list[str]) -> list[float]:
    """Return the numbers after ! or $."""
    words = list(_WORD.finditer(line))
    if len(words) != len(names):
        what = "values and a duration" if names[-1] == _DURATION else "values"
        raise source.error(f"{len(words)} numbers, expected {len(SHORT_NAMES)} {what}", FilePosition(number))
    return source.decimals([word[0] for word in words], names, lambda at: FilePosition(number, words[at].start() + 1))


def write(motion: Motion, _: Motion) -> bytes:
    """Write a .pos file with a pose at each key time."""
    times, angles = nao_rows(motion, _JOINTS, "rUNSWift pos", one_hip=True)
    stamps = milliseconds(times, "rUNSWift pos")
    lines = [_line(" ", [*SHORT_NAMES, _DURATION])]
    for row, duration in zip(np.degrees(angles).tolist(), np.diff([0, *stamps]).tolist(), strict=True):
        lines.append(_line("!", [*(f"{value:.15g}" for value in row), str(duration)]))
    return ("\n".join(lines) + "\n").encode()


def _line(mark: str, words: list[str]) -> str:
    return f"{mark} {' '.join(word.ljust(_WIDTH - 1) for word in words)}".rstrip()


RUNSWIFT = Format("runswift", (".pos",), "rUNSWift's poses", _recognises, read, write)
