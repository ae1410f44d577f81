"""Times at which a path can be followed without any joint exceeding its speed limit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.errors import BadArgument
from nao_kin.robot import RobotModel


@dataclass(frozen=True)
class Stretch:
    """A segment that takes longer than was asked.

    Attributes:
        index: it is between this sample and the next one.
        joint: the joint that needs the time.
        given: the time that was asked for [s].
        needed: the time that it takes [s].

    Examples:
        >>> nao = nk.load_nao()
        >>> path = np.linspace([0.15, 0.12, 0.0], [0.15, 0.12, 0.05], 5)
        >>> result = nk.ik.follow(nao, {"LArm": path}, times=np.linspace(0.0, 0.01, 5))
        >>> stretch = result.stretched[0]
        >>> stretch.index, stretch.given < stretch.needed
        (0, True)
    """

    index: int
    joint: str
    given: float
    needed: float

    def describe(self) -> str:
        """The segment in a sentence.

        Examples:
            >>> nk.ik.Stretch(0, "LElbowYaw", given=0.1, needed=0.25).describe()
            'LElbowYaw needs 0.25 s instead of 0.1 s after sample 0'
        """
        return f"{self.joint} needs {self.needed:.3g} s instead of {self.given:.3g} s after sample {self.index}"


@dataclass(frozen=True, eq=False)
class Timing:
    """Times of n samples.

    Attributes:
        times: shape (n,) [s].
        shares: speed of each joint in each segment as a share of its limit, shape (n − 1, joints).
        stretched: the segments that take longer than was asked.
    """

    times: Floats
    shares: Floats
    stretched: tuple[Stretch, ...]


def scaled(robot: RobotModel, joints: Floats, times: Floats | None, speed: float) -> Timing:
    """The times of samples, stretched where a joint would be too fast; or the least times.

    Segment by segment dt = max(given, max_j |Δq_j| / (speed · v_j)).

    Args:
        robot: whose speed limits v_j.
        joints: values of all joints, shape (n, joints).
        times: as asked, shape (n,), increasing; None for the least.
        speed: the share of the limits that may be used.

    Raises:
        BadArgument: a joint is to move whose speed limit is zero.
    """
    moved = np.abs(np.diff(joints, axis=0))
    stuck = (moved > 0.0).any(axis=0) & (robot.velocity_limits <= 0.0)
    if stuck.any():
        joint = robot.joint_names[int(np.argmax(stuck))]
        raise BadArgument(f"{joint} is to move, and its speed limit is 0: no time is long enough")
    limits = np.where(moved.any(axis=0), robot.velocity_limits, np.inf)
    least = moved / limits
    needed = least.max(axis=1, initial=0.0) / speed
    given = np.zeros(len(moved)) if times is None else np.diff(times)
    # Differences of times are rounded: what is too short by no more than that is kept as it is.
    short = needed > given * (1.0 + 1e-12) + (0.0 if times is None else 4.0 * np.spacing(np.abs(times).max()))
    taken = np.where(short, needed, given)
    begin = 0.0 if times is None else float(times[0])
    if times is not None and not short.any():
        found = np.array(times)
    else:
        found = begin + np.concatenate([[0.0], np.cumsum(taken)])
    shares = np.divide(least, taken[:, None], out=np.zeros_like(least), where=taken[:, None] > 0.0)
    stretched: tuple[Stretch, ...] = ()
    if times is not None:
        stretched = tuple(
            Stretch(int(i), robot.joint_names[int(np.argmax(least[i]))], float(given[i]), float(needed[i]))
            for i in np.flatnonzero(short)
        )
    return Timing(found, shares, stretched)


def between_samples(values: Floats) -> Floats:
    """Columns of values with what is missing put between the samples beside it, or equal to the only one beside it.

    Args:
        values: shape (n, c); nan where missing. A column of nothing else stays so.
    """
    filled = np.array(values)
    places = np.arange(len(values))
    for column in np.flatnonzero(np.isnan(values).any(axis=0)):
        known = ~np.isnan(values[:, column])
        if known.any():
            filled[:, column] = np.interp(places, places[known], values[known, column])
    return filled
