"""The module `motion` that old scripts import: NAOqi's numbers for spaces and axes."""

from __future__ import annotations

import math

from nao_kin.naoqi import spaces

# FRAME_TORSO, AXIS_MASK_VEL …
_NUMBERS = {name: value for name, value in vars(spaces).items() if name.startswith(("FRAME_", "AXIS_MASK_"))}
globals().update(_NUMBERS)

# The spaces as they were called up to NAOqi 1.10.
SPACE_TORSO, SPACE_WORLD, SPACE_NAO = spaces.FRAME_TORSO, spaces.FRAME_WORLD, spaces.FRAME_ROBOT

PI, PI_2 = math.pi, math.pi / 2.0
TO_RAD, TO_DEG = math.pi / 180.0, 180.0 / math.pi

__all__ = [*_NUMBERS, "PI", "PI_2", "SPACE_NAO", "SPACE_TORSO", "SPACE_WORLD", "TO_DEG", "TO_RAD"]
