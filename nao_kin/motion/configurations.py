"""Motions as configurations of a robot: absent joints filled in, two joints of one motor made one."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, as_floats, choice
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument, UnknownName, WrongShape
from nao_kin.robot import RobotModel

if TYPE_CHECKING:
    from nao_kin.motion.motion import Motion


# --- Left and right in the names of joints.

Side = Literal["left", "right"]

_OTHER = {"L": "R", "R": "L", "l": "r", "r": "l"}
_WORDS = {"left": "right", "right": "left", "Left": "Right", "Right": "Left", "LEFT": "RIGHT", "RIGHT": "LEFT"}
_SIDE = re.compile(
    r"""
    (?<![A-Za-z])(?:LEFT|RIGHT)(?![A-Za-z])           # LEFT_ELBOW
    | ^[LR](?=[A-Z])                                  # LShoulderPitch
    | ^[lr](?=_) | (?<=_)[lrLR]$                      # l_elbow, elbow_l
    | ^(?:left|right)(?![a-z]) | (?<![A-Za-z])(?:left|right)$  # left_elbow, leftElbow, elbow_left
    | ^(?:Left|Right)(?![a-z]) | (?:Left|Right)$      # LeftElbow, elbowLeft
    """,
    re.VERBOSE,
)


def side_of(name: str) -> Side | None:
    """The side that a name says, as LElbowRoll, l_elbow, elbow_l or left_elbow do; None for none."""
    match = _SIDE.search(name)
    if match is None:
        return None
    return "left" if match.group()[0] in "lL" else "right"


def other_side(name: str) -> str:
    """The name with left and right exchanged; the same where it says neither."""
    return _SIDE.sub(lambda match: _WORDS.get(match.group()) or _OTHER[match.group()], name, count=1)


# --- Motions as configurations of a robot: absent joints filled in, two joints of one motor made one.

Hips = Literal["average", "left", "right"]
HIPS: tuple[Hips, ...] = ("average", "left", "right")
HOLD = "hold"
# Configurations, samples or keys of a joint at once: 25 joints of them are 800 MB.
MOST_SAMPLES = 4_000_000
# A last step of less than this share of one is rounding.
_ROUNDING = 1e-6


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Configurations at times.

    Attributes:
        times: shape (n,) [s].
        q: configurations, shape (n, nq).

    Examples:
        >>> nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
        >>> trajectory = nod.configurations(nk.load_nao(), rate=10.0)
        >>> trajectory.times[:3].tolist(), trajectory.q.shape
        ([0.0, 0.1, 0.2], (11, 25))
    """

    times: Floats
    q: Floats

    def __len__(self) -> int:
        return len(self.times)

    def __repr__(self) -> str:
        span = f", {self.times[0]:g} to {self.times[-1]:g} s" if len(self.times) else ""
        return f"<Trajectory of {len(self.times)} configurations{span}>"


def check_hips(hips: str) -> None:
    """Refuse what is no rule for two joints of one motor."""
    choice(hips, HIPS, "rule for the hips")


def sampling_times(motion: Motion, rate: float | None, times: ArrayLike | None) -> Floats:
    """The times (n,) to sample at: those given, or at a rate, or those of the keys.

    Raises:
        BadArgument: both given, no positive rate, or a number of samples that no memory holds.
        WrongShape, NotFinite: no list of finite times.
    """
    if times is not None:
        if rate is not None:
            raise BadArgument("rate and times both say when to sample; give one")
        at = np.array(as_floats(times, (), "times"))
        if at.ndim != 1:
            raise WrongShape("times", "(n,)", at.shape)
        return at
    if rate is None:
        return motion.key_times
    number = checked_rate(rate)
    steps = motion.duration * number
    if not steps < MOST_SAMPLES:
        raise BadArgument(
            f"{motion.duration:g} s at {number:g} per second are {steps:.3g} samples, "
            f"more than {MOST_SAMPLES}; give a smaller rate"
        )
    at = motion.start + np.arange(int(steps + _ROUNDING) + 1) / number
    # A duration that is a whole number of steps but for rounding has no short step at its end.
    if steps - (len(at) - 1) > _ROUNDING:
        return np.append(at, motion.end)
    at[-1] = motion.end
    return at


def checked_rate(rate: float) -> float:
    """A rate, refused if it is no number above zero."""
    number = as_floats(rate, (), "rate")
    if isinstance(rate, bool) or number.shape != () or not number > 0.0:
        raise BadArgument(f"rate must be a number above zero, got {quoted(rate)}")
    return float(number)


def filled(robot: RobotModel, fill: str | ArrayLike) -> Floats:
    """The configuration (nq,) that joints are in which a motion does not name.

    Raises:
        UnknownName: no such posture.
        WrongShape, NotFinite, BadArgument: no configuration.
    """
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


def motor_values(robot: RobotModel, values: Mapping[str, Floats], hips: Hips) -> dict[str, Floats]:
    """Values of joints with a motor of their own, from values of any joints.

    A joint that follows another one gives the value of the driving joint, (value − offset) / multiplier. Where several
    joints of one motor are given the rule `hips` makes them one.

    Args:
        robot: whose joints.
        values: joint → values, all of one shape.
        hips: "average" of all; "left" or "right": of those whose names say that side, where there are any.
    """
    motors: dict[str, dict[str, Floats]] = {}
    for name, column in values.items():
        mimic = robot.mimics.get(name)
        if mimic is None:
            motors.setdefault(name, {})[name] = column
        elif mimic.multiplier != 0.0:
            motors.setdefault(mimic.joint, {})[name] = mimic.driver_value(column)
    found = {}
    for joint, sources in motors.items():
        chosen = [column for name, column in sources.items() if side_of(name) == hips] or list(sources.values())
        found[joint] = chosen[0] if len(chosen) == 1 else np.mean(chosen, axis=0)
    return found
