"""Left and right in the names of joints, and which of two joints of one motor determines it."""

from __future__ import annotations

import re
from typing import Literal, get_args

from nao_kin._core.arrays import choice

Side = Literal["left", "right"]

_OTHER = {"L": "R", "R": "L", "l": "r", "r": "l"}
_WORDS = {"left": "right", "right": "left", "Left": "Right", "Right": "Left", "LEFT": "RIGHT", "RIGHT": "LEFT"}
_SIDE = re.compile(
    r"""
    (?<![A-Za-z])(?:LEFT|RIGHT)(?![A-Za-z])           # LEFT_ELBOW
    | ^[LR](?=[A-Z])                                  # LShoulderPitch
    | ^[lr](?=_) | (?<=_)[lrLR]$                      # l_elbow, elbow_l
    | ^(?:left|right)(?![a-z]) | (?<![A-Za-z])(?:left|right)$  # left_elbow, leftElbow, elbow_left
    | ^(?:Left|Right)(?![a-z]) | (?:Left|Right)$      # LeftElbow, elbowLeft
    """,
    re.VERBOSE,
)


def side_of(name: str) -> Side | None:
    """Return the side in a name such as LElbowRoll, l_elbow, elbow_l or left_elbow; None without one."""
    match = _SIDE.search(name)
    if match is None:
        return None
    return "left" if match.group()[0] in "lL" else "right"


def other_side(name: str) -> str:
    """Return the name with left and right exchanged; the same name without a side."""
    return _SIDE.sub(lambda match: _WORDS.get(match.group()) or _OTHER[match.group()], name, count=1)


Hips = Literal["average", "left", "right"]


def check_hips(hips: str) -> None:
    """Raise `UnknownName` for an unknown rule for two joints of one motor."""
    choice(hips, get_args(Hips), "rule for the hips")


def joints_of_side(joints: list[str], hips: Hips) -> list[str]:
    """Return the joints that determine a motor: those on the side `hips`, or all joints if none is on that side."""
    return [joint for joint in joints if side_of(joint) == hips] or joints
