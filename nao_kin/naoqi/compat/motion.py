"""The module `motion` that old scripts import: NAOqi's numbers for spaces and axes."""

from __future__ import annotations

import math

from nao_kin.naoqi.spaces import (
    AXIS_MASK_ALL,
    AXIS_MASK_NONE,
    AXIS_MASK_ROT,
    AXIS_MASK_VEL,
    AXIS_MASK_WX,
    AXIS_MASK_WY,
    AXIS_MASK_WYWZ,
    AXIS_MASK_WZ,
    AXIS_MASK_X,
    AXIS_MASK_XY,
    AXIS_MASK_Y,
    AXIS_MASK_Z,
    FRAME_ROBOT,
    FRAME_TORSO,
    FRAME_WORLD,
)

__all__ = [
    "AXIS_MASK_ALL",
    "AXIS_MASK_NONE",
    "AXIS_MASK_ROT",
    "AXIS_MASK_VEL",
    "AXIS_MASK_WX",
    "AXIS_MASK_WY",
    "AXIS_MASK_WYWZ",
    "AXIS_MASK_WZ",
    "AXIS_MASK_X",
    "AXIS_MASK_XY",
    "AXIS_MASK_Y",
    "AXIS_MASK_Z",
    "FRAME_ROBOT",
    "FRAME_TORSO",
    "FRAME_WORLD",
    "PI",
    "PI_2",
    "SPACE_NAO",
    "SPACE_TORSO",
    "SPACE_WORLD",
    "TO_DEG",
    "TO_RAD",
]


# The spaces as they were called up to NAOqi 1.10.
SPACE_TORSO, SPACE_WORLD, SPACE_NAO = FRAME_TORSO, FRAME_WORLD, FRAME_ROBOT

PI, PI_2 = math.pi, math.pi / 2.0
TO_RAD, TO_DEG = math.pi / 180.0, 180.0 / math.pi
