"""What was changed in a motion, and by how much."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.motion.configurations import sampling_times
from nao_kin.motion.editing import resample
from nao_kin.motion.motion import Motion
from nao_kin.robot import LIMIT_TOLERANCE, RobotModel

# Keys per second of what is made straight.
STRAIGHT_RATE = 100.0

Kind = Literal["clamped", "resampled", "one motor", "slower"]


@dataclass(frozen=True)
class Change:
    """What was done to a joint in a stretch of time.

    Attributes:
        kind: "clamped": keys or handles were moved into the limits. "resampled": all became straight lines between more
            keys. "one motor": it was given what its motor does. "slower": it takes longer.
        joint: which; "" for all.
        start: from when, in the motion as it was given [s].
        end: until when [s].
        amount: the largest change of a value; for "slower", the factor by which the time grows.
        unit: of the amount: "rad", "m" or "1"; "" for a factor.

    Examples:
        >>> nao = nk.load_nao()
        >>> turn = nk.Motion([0.0, 0.1], ["HeadYaw"], [[0.0], [1.5]])
        >>> change = nk.motion.slow_down(nao, turn).changes[0]
        >>> change.kind, change.unit
        ('slower', '')
    """

    kind: Kind
    joint: str
    start: float
    end: float
    amount: float
    unit: str

    def describe(self, *, degrees: bool = False) -> str:
        """The change in words, with angles in degrees if wanted.

        Examples:
            >>> nao = nk.load_nao()
            >>> turn = nk.Motion([0.0, 2.0], ["HeadYaw"], [[0.0], [3.0]])
            >>> nk.motion.clamp(nao, turn).changes[0].describe()
            'HeadYaw: moved into its limits by up to 0.914 rad (2 s)'
        """
        turns = degrees and self.unit == "rad"
        amount = f"{math.degrees(self.amount) if turns else self.amount:.3g}"
        amount += "°" if turns else "" if self.unit == "1" else f" {self.unit}"
        when = f"{self.start:.6g} s" if self.start == self.end else f"{self.start:.6g} to {self.end:.6g} s"
        words = {
            "clamped": f"moved into its limits by up to {amount}",
            "resampled": f"made linear with {STRAIGHT_RATE:g} keys per second, which moved values by up to {amount}",
            "one motor": f"given what its motor does, up to {amount} away",
            "slower": f"takes {self.amount:.4g} times as long",
        }
        return f"{self.joint or 'all joints'}: {words[self.kind]} ({when})"

    def as_dict(self) -> dict[str, Any]:
        """For JSON.

        Examples:
            >>> nao = nk.load_nao()
            >>> turn = nk.Motion([0.0, 2.0], ["HeadYaw"], [[0.0], [3.0]])
            >>> nk.motion.clamp(nao, turn).changes[0].as_dict()["kind"]
            'clamped'
        """
        return dict(self.__dict__)


@dataclass(frozen=True, eq=False)
class Mended:
    """A motion that was changed.

    Attributes:
        motion: as it is now; the one that was given if nothing had to be changed.
        changes: what was done.

    Examples:
        >>> nao = nk.load_nao()
        >>> turn = nk.Motion([0.0, 2.0], ["HeadYaw"], [[0.0], [3.0]])
        >>> mended = nk.motion.clamp(nao, turn)
        >>> len(mended.changes), float(mended.motion.sample(2.0)[0].round(4))
        (1, 2.0857)
    """

    motion: Motion
    changes: tuple[Change, ...]

    def describe(self, *, degrees: bool = False) -> str:
        """One line for each change, or that there was none.

        Examples:
            >>> nao = nk.load_nao()
            >>> turn = nk.Motion([0.0, 2.0], ["HeadYaw"], [[0.0], [3.0]])
            >>> nk.motion.clamp(nao, turn).describe()
            'HeadYaw: moved into its limits by up to 0.914 rad (2 s)'
        """
        return "\n".join(change.describe(degrees=degrees) for change in self.changes) or "nothing had to be changed"


def changed_stretches(kind: Kind, joint: str, times: Floats, miss: Floats, unit: str) -> list[Change]:
    """The stretches of keys that were moved, each with the largest change."""
    size = np.abs(miss)
    moved = np.flatnonzero(size > LIMIT_TOLERANCE)
    if not len(moved):
        return []
    breaks = np.flatnonzero(np.diff(moved) > 1) + 1
    changes = []
    for group in np.split(moved, breaks):
        largest = float(size[group].max())
        changes.append(Change(kind, joint, float(times[group[0]]), float(times[group[-1]]), largest, unit))
    return changes


def straightened(robot: RobotModel, motion: Motion) -> tuple[Motion, Change]:
    """A linear motion in its place, and what that changed."""
    grid = np.union1d(sampling_times(motion, STRAIGHT_RATE, None), motion.key_times)
    straight = resample(motion, times=grid)
    middle = 0.5 * (grid[:-1] + grid[1:])
    turning = [robot.unit(joint) == "rad" for joint in motion.joint_names]
    apart = np.abs(straight.sample(middle) - motion.sample(middle))[:, turning]
    return straight, Change("resampled", "", motion.start, motion.end, float(apart.max(initial=0.0)), "rad")
