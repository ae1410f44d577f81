"""Axis masks: which of x, y, z, wx, wy, wz a Cartesian call controls, one bit each, along the axes of its space.

Source: aldebaran/libalmath, almath/types/alaxismask.h (BSD-3-Clause).
"""

from __future__ import annotations

import operator
from types import MappingProxyType
from typing import SupportsIndex

import numpy as np
from numpy.typing import NDArray

from nao_kin._text import quoted
from nao_kin.errors import BadArgument, UnknownName

AXES: tuple[str, ...] = ("X", "Y", "Z", "WX", "WY", "WZ")
AXIS_MASK_X, AXIS_MASK_Y, AXIS_MASK_Z = 1, 2, 4
AXIS_MASK_WX, AXIS_MASK_WY, AXIS_MASK_WZ = 8, 16, 32
AXIS_MASK_XY = 3
AXIS_MASK_VEL = 7
AXIS_MASK_PLANEZ = 28
AXIS_MASK_WYWZ = 48
AXIS_MASK_ROT = 56
AXIS_MASK_ALL = 63
AXIS_MASK_NONE = 0

# NAOqi's name of each, without "AXIS_MASK_".
AXIS_MASKS: MappingProxyType[str, int] = MappingProxyType(
    {
        "X": AXIS_MASK_X,
        "Y": AXIS_MASK_Y,
        "Z": AXIS_MASK_Z,
        "WX": AXIS_MASK_WX,
        "WY": AXIS_MASK_WY,
        "WZ": AXIS_MASK_WZ,
        "XY": AXIS_MASK_XY,
        "VEL": AXIS_MASK_VEL,
        "PLANEZ": AXIS_MASK_PLANEZ,
        "WYWZ": AXIS_MASK_WYWZ,
        "ROT": AXIS_MASK_ROT,
        "ALL": AXIS_MASK_ALL,
        "NONE": AXIS_MASK_NONE,
    }
)


def axis_mask(mask: SupportsIndex | str) -> int:
    """A mask as a number from 0 to 63, from such a number or from a name: "VEL" or "AXIS_MASK_VEL".

    Raises:
        UnknownName: no such name.
        BadArgument: no such number.

    Examples:
        >>> nk.naoqi.axis_mask("VEL"), nk.naoqi.axis_mask(63)
        (7, 63)
    """
    if isinstance(mask, str):
        name = mask.removeprefix("AXIS_MASK_")
        if name not in AXIS_MASKS:
            raise UnknownName("axis mask", mask, tuple(AXIS_MASKS))
        return AXIS_MASKS[name]
    try:
        number = int(mask) if isinstance(mask, float) and mask.is_integer() else operator.index(mask)
    except TypeError:
        number = -1
    if not 0 <= number <= AXIS_MASK_ALL:
        raise BadArgument(
            f"axis mask must be a number from 0 to 63 (7 position, 56 rotation, 63 both), got {quoted(mask)}"
        )
    return number


def controlled_axes(mask: SupportsIndex | str) -> NDArray[np.bool_]:
    """Which of x, y, z, wx, wy, wz a mask controls, shape (6,).

    Raises:
        UnknownName, BadArgument: as `axis_mask`.

    Examples:
        >>> nk.naoqi.controlled_axes("VEL").tolist()
        [True, True, True, False, False, False]
    """
    return np.array([axis_mask(mask) >> bit & 1 for bit in range(6)], dtype=np.bool_)
