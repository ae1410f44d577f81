"""What a robot does, row by row: it stands, sits, lies, falls, or is held in the air.

Each rule uses the rows before only. A decision that needs some time also says from which row on it holds, so that a log
that is known to its end has it from there.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

# Tilt of the root link from which a robot that does not stand flat on a sole is falling, lies, and is upright again,
# and from which it lies in any case; up to which it sits. Between a standing robot that bends (up to 60° in Aldebaran's
# animations) and one that lies (83 to 90° in NAO's postures); NAO's postures that sit lean by 9 and 18°.
_FALLING, _LYING, _UPRIGHT_AGAIN, _SURELY_LYING, _SEATED = np.radians([30.0, 50.0, 30.0, 80.0, 60.0]).tolist()
# A fall lasts longer than _BRIEF and less than _SHORT [s]: a NAO falls from its soles to the floor in 0.6 to 0.8 s. A
# robot sits, or is in a state that is not known, after _SITS and _SHORT.
_BRIEF, _SHORT, _SITS = 0.1, 1.0, 0.5
# Who falls turns faster than _FAST somewhere, at first faster than _TURNING [rad/s], in the mean over a time [s]. A
# pendulum of NAO's height that falls over its toes turns with 2.8 rad/s at a tilt of 30°, and with 4.6 rad/s at 50°; a
# person who tilts a robot by 90° within a second, with 2.9 rad/s.
_TURNING, _FAST, _OVER = 1.5, 3.2, 0.1
# A robot that sits carries this share of its weight on its soles, or its trunk was quiet within this time [s]; one that
# stands carries more than HALF.
_LEGS_REST, _CALM, HALF = 0.05, 0.5, 0.5
# Soles that carry less than this share of the weight for _LIFTED have no contact, and have it again after _DOWN [s].
# Source of the times: B-Human's groundContactDetector.cfg (d89d603), maxTimeWithoutPressure, minTimeWithPressure.
UNLOADED, _LIFTED, _DOWN = 0.2, 0.2, 0.1
# Steps of a walk follow each other within this time [s], and in each of them the legs lift a sole by this height [m]:
# in a robot that rocks from foot to foot, they do not.
_LONGEST_STEP, _LIFTS = 1.0, 0.01


# What a robot does.
DOINGS = "standing", "walking", "sitting", "lying", "falling", "lifted", "carried", "unknown"


class Rule(Protocol):
    """A rule that decides what is so `now`, and returns the row, counted from 0, from which on this holds."""

    now: Any

    def row(self, *values: Any) -> int:
        """Decide about the next row."""


def decided(rule: Rule, *columns: NDArray[Any]) -> NDArray[Any]:
    """Return what a rule says of each of the next n rows, shape (n,), with all that it says of them later."""
    if len(columns[0]) == 1:  # a fifth of the time
        rule.row(*(column.tolist()[0] for column in columns))
        return np.array([rule.now])
    found: list[Any] = []
    for k, row in enumerate(zip(*(column.tolist() for column in columns), strict=True)):
        before, since = rule.now, rule.row(*row)
        found.append(rule.now)
        if rule.now != before:
            found[since:] = [rule.now] * (k + 1 - since)
    return np.array(found)


class Contact:
    """Whether the soles carry: lost after 0.2 s without load, and found after 0.1 s with it."""

    def __init__(self) -> None:
        self.now: bool | None = None
        self._count, self._other = 0, (0, 0.0)

    def row(self, loaded: bool, moment: float) -> int:
        """Decide about the next row."""
        k, self._count = self._count, self._count + 1
        if self.now is None:
            self.now = loaded
        if loaded == self.now:
            self._other = k + 1, np.inf
            return k
        if self._other[0] == k:
            self._other = k, moment
        if moment - self._other[1] >= (_LIFTED if self.now else _DOWN):
            self.now, since = loaded, self._other[0]
            self._other = k + 1, np.inf
            return since
        return k


class Walk:
    """Whether a robot walks: its steps follow each other within a second.

    A step is a change of the support, before which the legs have lifted one sole from the other.
    """

    def __init__(self) -> None:
        self.now = False
        self._count, self._support, self._heights = 0, -1, (0.0, 0.0)
        self._begun = self._stepped = (0, -np.inf)  # row and time of the last change, and of the last step

    def row(self, moment: float, support: int, height: float) -> int:
        """Decide about the next row by its support, −1 for none, and the height of one sole over the other."""
        k, self._count = self._count, self._count + 1
        since, (lowest, highest) = self._begun[0], self._heights
        if support != self._support:
            lifted = self._support >= 0 and highest - lowest >= _LIFTS
            if lifted and moment - self._begun[1] <= _LONGEST_STEP:
                self.now, self._stepped = True, (k, moment)
            self._begun, self._support, lowest, highest = (k, moment), support, height, height
        self._heights = min(lowest, height), max(highest, height)
        if self.now and (support < 0 or moment - self._stepped[1] > _LONGEST_STEP):
            self.now, since = False, self._stepped[0]
        return since


class Seen(NamedTuple):
    """What is seen of a robot in a row.

    `up` is the vertical in the root link, NaN if it is not known; `stands` whether the soles have contact, `flat`
    whether one that carries is level; `share` of the weight on the soles, NaN if it is not known; `low` whether the
    hips are low over the soles; `quiet` whether the trunk is, None if no sensor shows it.
    """

    moment: float
    up: tuple[float, float, float]
    stands: bool
    flat: bool
    share: float
    low: bool
    quiet: bool | None


class Doing:
    """What a robot with an inertial unit does.

    It stands on soles that carry and are flat. It sits if its hips are low and its trunk is quiet, or its legs rest on
    the floor; or if its soles carry less than half of its weight and its trunk is quiet, as on a chair. Otherwise it
    has left its soles: without load it is lifted, or carried if it is tilted; if it turns fast, it falls, for a second
    at most, and then lies. Who is carried lies as soon as the trunk is quiet.
    """

    def __init__(self) -> None:
        self.now = "unknown"
        self._count, self._kind, self._down = 0, "unknown", False
        self._begun = self._left = (0, 0.0)  # row and time of the kind, and since it has left its soles
        self._quiet_at = self._light_at = -np.inf
        self._rises, self._fastest, self._fell = False, 0.0, -1
        self._ups: deque[tuple[float, float, float, float]] = deque()

    def row(self, *values: Any) -> int:
        """Decide about the next row by the values of `Seen`."""
        seen = Seen(*values)
        moment, up, stands, _, share, _, quiet = seen
        k, self._count = self._count, self._count + 1
        if quiet:
            self._quiet_at = moment
        if not share < HALF:
            self._light_at = moment
        kind, turning = self._kind_of(seen), self._turning(moment, up)
        if kind != self._kind:
            rises = (self._kind, self.now) in (("down", "lying"), ("sitting", "sitting"))
            if rises or self._kind in ("standing", "unknown"):
                self._left, self._fell, self._fastest, self._rises = (k, moment), -1, 0.0, rises
            if self._kind == "unknown":  # what was before is not known
                self._fastest = np.inf
            self._kind, self._begun = kind, (k, moment)
        self._fastest = max(self._fastest, turning)
        lasted, left = moment - self._begun[1], moment - self._left[1]
        if kind in ("standing", "unknown"):
            return self._is(kind, k)
        if kind == "sitting":
            return self._is(kind, self._begun[0]) if lasted >= _SITS else k
        if kind == "down":
            down = up[2] < math.cos(_SURELY_LYING)
            if self.now != "lying" and not down and self._fastest > _FAST and turning > _TURNING:
                return self._is("falling", k if self.now == "falling" else self._left[0])
            if self.now == "lying" or self._fastest > _FAST or quiet is None or self._quiet_at >= self._begun[1]:
                return self._is("lying", k)
            if lasted < _SITS:
                return k
            # In the hands of a person, or it lies down by itself.
            since = self._left[0] if self.now == "falling" else self._begun[0]
            return self._is("unknown" if stands else "carried", since)
        if self._rises and (stands or left < _SHORT):
            return self._is("unknown", k)
        if kind == "lifted":
            return self._is("falling", k) if left < _SHORT and self._fell >= 0 else self._is("lifted", self._begun[0])
        if left < _SHORT and (kind == "tipped" or self._fastest > _TURNING or quiet is None):
            if self._fell < 0 and (lasted >= _BRIEF or self._fastest > _FAST):
                self._fell = self._left[0]
            return k if self._fell < 0 else self._is("falling", self._fell)
        if (stands and lasted < _SHORT and self._fell < 0) or lasted < _BRIEF:
            return k
        since = self._begun[0] if self._fell < 0 else self._fell
        self._fell = -1
        return self._is("unknown" if stands else "carried", since)

    def _is(self, name: str, since: int) -> int:
        self.now = name
        return since

    def _turning(self, moment: float, up: tuple[float, float, float]) -> float:
        """Return how fast the vertical turns [rad/s], 0 if it is not known."""
        ups = self._ups
        ups.append((moment, *up))
        while moment - ups[0][0] > _OVER and len(ups) > 1:
            ups.popleft()
        begin, x, y, z = ups[0]
        turned = math.dist((x, y, z), up)
        return turned / (moment - begin) if moment - begin > 0.5 * _OVER and turned == turned else 0.0

    def _kind_of(self, seen: Seen) -> str:
        """Return the kind of a row by its values alone, but for lying, which lasts until it is upright."""
        moment, up, stands, flat, share, low, quiet = seen
        blind = quiet is None
        tilt = math.acos(min(max(up[2], -1.0), 1.0)) if up[2] == up[2] else math.nan
        if tilt != tilt:
            return "unknown"
        supported = stands and flat and (share > HALF or not low)
        if supported or tilt < _UPRIGHT_AGAIN:
            self._down = False
        elif tilt > _LYING:
            self._down = True
        if tilt > _SURELY_LYING:
            self._down = True
            return "down"
        calm = blind or moment - self._quiet_at < _CALM
        light = not blind and calm and moment > self._light_at
        if supported and not light:
            return "standing"
        if tilt < _SEATED and (supported or (low and (calm or share > _LEGS_REST))):
            return "sitting"
        if self._down:
            return "down"
        if tilt > _FALLING:
            return "tilted"
        return "tipped" if stands else "lifted"
