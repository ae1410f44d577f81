"""The module `motion` that old scripts import: NAOqi's numbers for spaces and axes."""

from __future__ import annotations

import math

from nao_kin.naoqi.conventions import FRAME_ROBOT, FRAME_TORSO, FRAME_WORLD, SPACES, AxisMask

# FRAME_TORSO, AXIS_MASK_VEL …
_NUMBERS = {name: number for number, name in enumerate(SPACES)}
_NUMBERS |= {f"AXIS_MASK_{name}": int(mask) for name, mask in AxisMask.__members__.items()}
globals().update(_NUMBERS)

# The names of the spaces up to NAOqi 1.10.
SPACE_TORSO, SPACE_WORLD, SPACE_NAO = FRAME_TORSO, FRAME_WORLD, FRAME_ROBOT

PI, PI_2 = math.pi, math.pi / 2.0
TO_RAD, TO_DEG = math.pi / 180.0, 180.0 / math.pi

__all__ = [*_NUMBERS, "PI", "PI_2", "SPACE_NAO", "SPACE_TORSO", "SPACE_WORLD", "TO_DEG", "TO_RAD"]
