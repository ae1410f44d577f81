"""A joint that follows another one: the one type for it, wherever it is read, composed or turned round."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nao_kin._common.arrays import Floats


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: value = multiplier · value of the driving joint + offset.

    Attributes:
        joint: the driving joint.
        multiplier: ratio of the two values.
        offset: value when the driving joint is at zero.
    """

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0

    def value(self, driver: Floats | float) -> Floats:
        """Values of the follower for values of the driving joint, any shape."""
        return np.asarray(self.multiplier * driver + self.offset)

    def driver_value(self, value: Floats | float) -> Floats:
        """Values of the driving joint for values of the follower; the multiplier must not be zero."""
        return np.asarray((value - self.offset) / self.multiplier)

    def through(self, driver: Mimic) -> Mimic:
        """The mimic of the last driver, where the driving joint itself follows: a = m b + o and b = driver(c)."""
        return Mimic(driver.joint, self.multiplier * driver.multiplier, self.offset + self.multiplier * driver.offset)

    def inverted(self, follower: str) -> Mimic:
        """How the driving joint follows the `follower`; the multiplier must not be zero."""
        return Mimic(follower, 1.0 / self.multiplier, -self.offset / self.multiplier)

    def range(self, lower: float, upper: float) -> tuple[float, float]:
        """Range of the follower for a range of the driving joint."""
        if self.multiplier == 0.0:
            return self.offset, self.offset
        ends = sorted(self.multiplier * end + self.offset for end in (lower, upper))
        return ends[0], ends[1]

    def driver_range(self, lower: float, upper: float) -> tuple[float, float]:
        """Range of the driving joint for a range of the follower; the multiplier must not be zero."""
        ends = sorted((end - self.offset) / self.multiplier for end in (lower, upper))
        return ends[0], ends[1]
