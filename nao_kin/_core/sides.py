"""Left and right in the names of joints, and which of two joints of one motor determines it."""

from __future__ import annotations

import re
from typing import Literal, get_args

from nao_kin._core.arrays import choice

Side = Literal["left", "right"]

_OTHER = {"l": "r", "r": "l", "left": "right", "right": "left"}
_OTHER |= {one.capitalize(): other.capitalize() for one, other in _OTHER.items()} | {"LEFT": "RIGHT", "RIGHT": "LEFT"}
_START, _END = "(?<![A-Za-z0-9])", "(?![A-Za-z0-9])"
_SIDE = re.compile(
    rf"""
    (?<![A-Za-z])(?:left|right)(?![a-z])                  # left_elbow, leftElbow, leg_left_1_joint
    | (?<![A-Z])(?:Left|Right)(?![a-z])                   # LeftElbow, elbowLeft
    | (?<![A-Za-z])(?:LEFT|RIGHT)(?![A-Za-z])             # LEFT_ELBOW
    | {_START}[lrLR]{_END}                                # l_elbow, elbow_l, arm.L.1
    | {_START}[LR](?=[A-Z])(?![LR]{_END})                 # LShoulderPitch, LF_HAA, but not RL_hip
    | (?i:{_START}[lr](?=[fhbr]{_END}))                   # lf_haa_joint, LR_hip: left front, left rear
    | (?i:(?<={_START}[fhbr])[lr]{_END})                  # FL_HAA, HL_HAA, bl_hip, RL_hip: front, hind, back, rear left
    """,
    re.VERBOSE,
)


def side_of(name: str) -> Side | None:
    """Return the side in a name such as LElbowRoll, l_elbow, arm_left_1 or FL_hip; None without one."""
    match = _SIDE.search(name)
    if match is None:
        return None
    return "left" if match.group()[0] in "lL" else "right"


def other_sides(name: str) -> list[str]:
    """Return the names with left and right exchanged, none without a side.

    If several parts of the name may be sides, each name has one of them exchanged, and the last one has all, as the
    mirror image of r_gripper_l_finger has.
    """
    marks = list(_SIDE.finditer(name))
    names = [name[: mark.start()] + _OTHER[mark.group()] + name[mark.end() :] for mark in marks]
    return names if len(marks) < 2 else [*names, _SIDE.sub(lambda mark: _OTHER[mark.group()], name)]


Hips = Literal["average", "left", "right"]


def check_hips(hips: str) -> None:
    """Raise `UnknownName` for an unknown rule for two joints of one motor."""
    choice(hips, get_args(Hips), "rule for the hips")


def joints_of_side(joints: list[str], hips: Hips) -> list[str]:
    """Return the joints that determine a motor: those on the side `hips`, or all joints if none is on that side."""
    return [joint for joint in joints if side_of(joint) == hips] or joints
