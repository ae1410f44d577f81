"""Motions as configurations of a robot: sampling times, and values for absent joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, as_floats
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument, UnknownName, WrongShape
from nao_kin.robot import RobotModel

if TYPE_CHECKING:
    from nao_kin.motion.motion import Motion


HOLD = "hold"
# Configurations, samples or keys of a joint: 800 MB for 25 joints.
MAX_SAMPLES = 4_000_000
# A last step shorter than this share of a step is rounding.
_ROUNDING = 1e-6


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Configurations at times.

    Attributes:
        times: shape (n,) [s].
        q: configurations, shape (n, nq).
    """

    times: Floats
    q: Floats

    def __len__(self) -> int:
        return len(self.times)

    def __repr__(self) -> str:
        span = f", {self.times[0]:g} to {self.times[-1]:g} s" if len(self.times) else ""
        return f"<Trajectory of {len(self.times)} configurations{span}>"


def sampling_times(motion: Motion, rate: float | None, times: ArrayLike | None) -> Floats:
    """Return the sampling times (n,): the given times, times at a rate, or the key times."""
    if times is not None:
        if rate is not None:
            raise BadArgument("rate and times both set the times; give one")
        at = np.array(as_floats(times, (), "times"))
        if at.ndim != 1:
            raise WrongShape("times", "(n,)", at.shape)
        return at
    if rate is None:
        return motion.key_times
    number = checked_rate(rate)
    steps = motion.duration * number
    if not steps < MAX_SAMPLES:
        raise BadArgument(
            f"{motion.duration:g} s at {number:g} per second are {steps:.3g} samples, "
            f"more than {MAX_SAMPLES}; give a smaller rate"
        )
    at = motion.start + np.arange(int(steps + _ROUNDING) + 1) / number
    # A duration that rounds to a whole number of steps has no short step at its end.
    if steps - (len(at) - 1) > _ROUNDING:
        return np.append(at, motion.end)
    at[-1] = motion.end
    return at


def interval(start: float, end: float) -> str:
    """Return a time interval in words."""
    return f"{start:.6g} s" if start == end else f"{start:.6g} to {end:.6g} s"


def checked_rate(rate: float) -> float:
    """Return a rate, which must be a number above zero."""
    number = as_floats(rate, (), "rate")
    if isinstance(rate, bool) or number.shape != () or not number > 0.0:
        raise BadArgument(f"rate must be a number above zero, got {quoted(rate)}")
    return float(number)


def filled(robot: RobotModel, fill: str | ArrayLike) -> Floats:
    """Return the configuration (nq,) with the values of the joints that a motion does not name."""
    if isinstance(fill, str):
        if fill != HOLD:
            if fill not in robot.posture_names:
                raise UnknownName("posture", fill, (*robot.posture_names, HOLD))
            return robot.posture(fill)
        start = robot.semantics.start
        return robot.posture(start) if start in robot.posture_names else robot.clamp(robot.neutral())
    q = as_floats(fill, (), "fill")
    if q.shape != (robot.nq,):
        raise WrongShape("fill", f"({robot.nq},), or be the name of a posture", q.shape)
    return np.array(robot.checked(q))
