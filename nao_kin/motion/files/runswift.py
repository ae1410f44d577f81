"""rUNSWift's .pos: all joints in degrees, milliseconds to reach each pose, short names as a comment.

      HY    HP    LSP  …  LH    RH    DUR
    $ 0.5   1     1    …  1     1
    ! 0     30    90   …  0     0     500

Source: UNSWComputing/rUNSWift-2023-release, robot/motion/generator/ActionGenerator.cpp and
image/home/nao/data/pos/README.md. Lines that begin with ! are poses: 25 numbers in degrees, hands too, in the order of
LoLA, and the duration of the straight line to the pose in whole milliseconds. The first line starts at the robot's
current pose. Lines that begin with $ are the stiffnesses of the next pose; all other lines are comments.
"""

from __future__ import annotations

import math
import re

import numpy as np

from nao_kin._core.text import MAX_SHOWN, quoted
from nao_kin.motion.files.source import Format, MotionSource, Place, has_line
from nao_kin.motion.files.tracks import Track, check_times, milliseconds, motion_of, nao_rows
from nao_kin.motion.motion import Motion
from nao_kin.robot.nao import BODY_ORDER

# Of the NAO's 25 motors, hands last; the short name of a joint is its capital letters.
_HANDS = ("LHand", "RHand")
_JOINTS = (*(joint for joint in BODY_ORDER if joint not in ("RHipYawPitch", *_HANDS)), *_HANDS)
SHORT_NAMES = {"".join(filter(str.isupper, joint)): joint for joint in _JOINTS}
_DURATION = "DUR"
_POSE = re.compile(r"^![ \t]*[-+.\d]", re.MULTILINE | re.ASCII)
_WORD = re.compile(r"[^\s!$]+")
_WIDTH = 6


def read(source: MotionSource) -> Motion:
    """Read the motion in a .pos file; a comment with all short names sets the order of the numbers after it."""
    order = list(SHORT_NAMES)
    rows, lines = list[list[float]](), list[int]()
    for number, line in enumerate(source.lines, start=1):
        if line.startswith("!"):
            values = _numbers(source, line, number, [*order, _DURATION])
            duration = values.pop()
            if duration < 0.0 or duration != math.floor(duration) or (duration == 0.0 and rows):
                column = list(_WORD.finditer(line))[-1].start() + 1
                raise source.error(
                    f"{_DURATION} is {duration:g} ms, expected whole milliseconds > 0", Place(number, column)
                )
            row = dict(zip(order, values, strict=True))
            rows.append([row[short] for short in SHORT_NAMES] + [duration])
            lines.append(number)
        elif line.startswith("$"):
            for value in _numbers(source, line, number, order):
                if not 0.0 <= value <= 1.0:
                    raise source.error(f"stiffness {value:g}, expected 0 to 1", Place(number))
        else:
            order = _order(source, line, number) or order
    if not rows:
        raise source.error("no pose: no line begins with !")
    table = np.array(rows)
    times = np.cumsum(table[:, -1]) / 1e3
    check_times(source, times, lambda row: Place(lines[row]))
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
            raise source.error(f"{shown} among the short names of joints", Place(number, word.start() + 1))
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise source.error(f"joint {twice} is given twice", Place(number))
    missing = [short for short in SHORT_NAMES if short not in names]
    if missing:
        raise source.error(f"the row of short names lacks {', '.join(missing)}", Place(number))
    return names


def _numbers(source: MotionSource, line: str, number: int, names: list[str]) -> list[float]:
    """Return the numbers after ! or $."""
    words = list(_WORD.finditer(line))
    if len(words) != len(names):
        what = "values and a duration" if names[-1] == _DURATION else "values"
        raise source.error(f"{len(words)} numbers, expected {len(SHORT_NAMES)} {what}", Place(number))
    return source.decimals([word[0] for word in words], names, lambda at: Place(number, words[at].start() + 1))


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


RUNSWIFT = Format("runswift", (".pos",), "rUNSWift's poses", has_line(_POSE), read, write)
