"""Where the feet go: poses on the floor, and steps along a path that a NAO's legs can make.

A pose on the floor is (x, y, theta), an array of shape (3,) [m, m, rad]. The body is the pose between the feet where
they stand side by side; each step puts a foot beside the pose that the body is to have next.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats
from nao_kin.naoqi.virtual.walk.gait import FootGait, Gait

# Feet stand below the hips, 50 mm beside the body, left positive (HipOffsetY).
HALF_STANCE = 0.05
# How near a foot may be put beside the other [m], and how far its toes may point inwards [rad].
NEAREST = 0.088
_TOES_INWARDS = 0.12
_DONE = 1e-9
# Feet that are so near to where they stand below a body stand there.
_TOGETHER = 1e-6
_SCANNED = 40
_HALVED = 30


def turned_by(theta: float) -> float:
    """The same angle within ±π."""
    return math.remainder(theta, 2.0 * math.pi)


def composed(a: ArrayLike, b: ArrayLike) -> Floats:
    """The pose that is b as seen from a."""
    ax, ay, angle = np.asarray(a, dtype=np.float64).tolist()
    bx, by, more = np.asarray(b, dtype=np.float64).tolist()
    c, s = math.cos(angle), math.sin(angle)
    return np.array([ax + c * bx - s * by, ay + s * bx + c * by, angle + more])


def seen_from(a: ArrayLike, b: ArrayLike) -> Floats:
    """The pose b as a sees it, the angle within ±π; `composed` with a takes it back."""
    ax, ay, angle = np.asarray(a, dtype=np.float64).tolist()
    bx, by, more = np.asarray(b, dtype=np.float64).tolist()
    c, s = math.cos(angle), math.sin(angle)
    x, y = bx - ax, by - ay
    return np.array([c * x + s * y, c * y - s * x, turned_by(more - angle)])


def foot_beside(body: ArrayLike, side: str) -> Floats:
    """Where a foot stands below a body."""
    return composed(body, (0.0, HALF_STANCE if side == "L" else -HALF_STANCE, 0.0))


def body_beside(foot: ArrayLike, side: str) -> Floats:
    """Where the body is whose foot stands there: the inverse of `foot_beside`."""
    return composed(foot, (0.0, -HALF_STANCE if side == "L" else HALF_STANCE, 0.0))


def between(left: Floats, right: Floats) -> Floats:
    """The pose half way between two."""
    middle = 0.5 * (left + right)
    middle[2] = left[2] + 0.5 * turned_by(float(right[2] - left[2]))
    return np.asarray(middle)


def other(side: str) -> str:
    """The other foot."""
    return "R" if side == "L" else "L"


@dataclass(frozen=True, eq=False)
class Step:
    """One step of the walk.

    Attributes:
        side: the foot that moves, "L" or "R"; the other one stands.
        support: where the standing foot is, shape (3,).
        start, end: where the moving foot leaves and comes down, shape (3,).
        height: how high the moving foot is lifted [m].
        period: how long the step lasts, if the joints are fast enough [s].
    """

    side: str
    support: Floats
    start: Floats
    end: Floats
    height: float
    period: float


def bounded(step: ArrayLike, side: str, gait: FootGait) -> Floats:
    """A foot's pose relative to the standing one, brought into what the gait and the one motor of the hips allow.

    Forwards and back up to MaxStepX; sideways from 88 mm to MaxStepY; turned outwards up to MaxStepTheta and inwards up
    to 0.12 rad, for the toes of a foot that is turned inwards come near those of the other.
    """
    x, y, theta = np.asarray(step, dtype=np.float64).tolist()
    outwards = 1.0 if side == "L" else -1.0
    wide = min(max(outwards * y, NEAREST), gait.max_step_y)
    turn = min(max(outwards * theta, -min(_TOES_INWARDS, gait.max_step_theta)), gait.max_step_theta)
    return np.array([min(max(x, -gait.max_step_x), gait.max_step_x), outwards * wide, outwards * turn])


def first_side(wish: ArrayLike) -> str:
    """The foot to begin with: the one that opens towards where the body goes or turns."""
    _, y, theta = np.asarray(wish, dtype=np.float64).tolist()
    return "R" if (y, theta) < (0.0, 0.0) or (y == 0.0 and theta < 0.0) else "L"


def along(start: Floats, goal: Floats, share: float) -> Floats:
    """Between two poses: straight, turning evenly along the shorter arc."""
    turn = turned_by(float(goal[2] - start[2]))
    if share == 1.0:
        return np.array([goal[0], goal[1], start[2] + turn])
    place = start[:2] + share * (goal[:2] - start[:2])
    return np.array([place[0], place[1], start[2] + share * turn])


def next_step(feet: dict[str, Floats], side: str, body: Floats, goal: Floats, gait: Gait) -> tuple[Step, Floats]:
    """The step that brings the body as far towards a goal as this foot can in one step.

    Args:
        feet: where the feet stand, by "L" and "R".
        side: the foot that moves.
        body: where the body is.
        goal: where it is to go.
        gait: of both feet.

    Returns:
        The step, and where the body then is: on the way from `body` to `goal`.
    """
    own = gait.of(side)
    support = feet[other(side)]

    def fits(share: float) -> bool:
        wanted = seen_from(support, foot_beside(along(body, goal, share), side))
        return float(np.abs(bounded(wanted, side, own) - wanted).max()) < _DONE

    share = _largest(fits)
    reached = along(body, goal, share)
    wanted = seen_from(support, foot_beside(reached, side))
    end = composed(support, bounded(wanted, side, own))
    return Step(side, support.copy(), feet[side].copy(), end, own.step_height, own.period), reached


def stands_beside(feet: dict[str, Floats], body: Floats) -> bool:
    """Whether both feet stand where they do below this body."""
    off = [float(np.abs(seen_from(foot_beside(body, side), foot)).max()) for side, foot in feet.items()]
    return max(off) < _TOGETHER


def _largest(fits: Callable[[float], bool]) -> float:
    """The largest share that fits; 0 where none does."""
    if fits(1.0):
        return 1.0
    low = next((k / _SCANNED for k in range(_SCANNED - 1, 0, -1) if fits(k / _SCANNED)), 0.0)
    high = low + 1.0 / _SCANNED
    for _ in range(_HALVED):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if fits(middle) else (low, middle)
    return low
