"""Ranges that depend on another joint."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin._text import quoted
from nao_kin.errors import BadArgument


@dataclass(frozen=True)
class CoupledLimit:
    """Range of one joint as a piecewise linear function of another, constant outside its table.

    Attributes:
        joint: the joint whose range this is.
        of: the joint it depends on.
        at: values of `of` where the range bends, ascending [rad].
        lower: smallest value of `joint` there [rad].
        upper: largest value of `joint` there [rad].

    Raises:
        BadArgument: columns of different lengths or without numbers, `at` not ascending, a lower bound above its upper
            one, a joint that depends on itself.
    """

    joint: str
    of: str
    at: tuple[float, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...]

    def __post_init__(self) -> None:
        what = f"the coupled limit of {self.joint}"
        if self.joint == self.of:
            raise BadArgument(f"{what} depends on that joint itself")
        for name in ("at", "lower", "upper"):
            try:
                object.__setattr__(self, name, tuple(map(float, getattr(self, name))))
            except (TypeError, ValueError, OverflowError):
                raise BadArgument(f"{what} must have numbers in {name}, got {quoted(getattr(self, name))}") from None
        if not (len(self.at) == len(self.lower) == len(self.upper) > 0):
            counts = f"{len(self.at)}, {len(self.lower)} and {len(self.upper)}"
            raise BadArgument(f"{what} must have equally many at, lower and upper, got {counts}")
        if not np.all(np.diff(self.at) > 0.0) or not np.isfinite([self.at, self.lower, self.upper]).all():
            raise BadArgument(f"{what} must have finite numbers, at in ascending order")
        if np.any(np.greater(self.lower, self.upper)):
            raise BadArgument(f"{what} has a lower bound above the upper one")

    def range(self, of: Floats) -> tuple[Floats, Floats]:
        """Smallest and largest value of `joint` at values of `of`, any shape."""
        return np.asarray(np.interp(of, self.at, self.lower)), np.asarray(np.interp(of, self.at, self.upper))
