"""Left and right in the names of joints."""

from __future__ import annotations

import re
from typing import Literal

Side = Literal["left", "right"]

_OTHER = {"L": "R", "R": "L", "l": "r", "r": "l"}
_WORDS = {"left": "right", "right": "left", "Left": "Right", "Right": "Left", "LEFT": "RIGHT", "RIGHT": "LEFT"}
_SIDE = re.compile(
    r"""
    ^[LR](?=[A-Z])                                    # LShoulderPitch
    | ^[lr](?=_) | (?<=_)[lrLR]$                      # l_elbow, elbow_l
    | ^(?:left|right)(?![a-z]) | (?<![A-Za-z])(?:left|right)$  # left_elbow, leftElbow, elbow_left
    | ^(?:Left|Right)(?![a-z]) | (?:Left|Right)$      # LeftElbow, elbowLeft
    | (?<![A-Za-z])(?:LEFT|RIGHT)(?![A-Za-z])         # LEFT_ELBOW
    """,
    re.VERBOSE,
)


def side_of(name: str) -> Side | None:
    """The side that a name says, as LElbowRoll, l_elbow, elbow_l or left_elbow do; None for none."""
    match = _SIDE.search(name)
    if match is None:
        return None
    return "left" if match.group()[0] in "lL" else "right"


def other_side(name: str) -> str:
    """The name with left and right exchanged; the same where it says neither."""
    return _SIDE.sub(lambda match: _WORDS.get(match.group()) or _OTHER[match.group()], name, count=1)
