"""Motions that are too fast for a robot, slowed down."""

from __future__ import annotations

from typing import Literal

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.motion.changes import Change, Mended
from nao_kin.motion.checking import largest_speed
from nao_kin.motion.configurations import check_joints
from nao_kin.motion.cutting import cut
from nao_kin.motion.editing import time_warp
from nao_kin.motion.monotone import pieces_of
from nao_kin.motion.motion import Motion, check_motion
from nao_kin.robot import RobotModel, check_robot

# Times are rounded when they are added up; a check allows ten times as much.
_FITS = 1.0 + 1e-10


def slow_down(robot: RobotModel, motion: Motion, *, how: Literal["local", "uniform"] = "local") -> Mended:
    """The motion with time stretched until every joint keeps its speed limit.

    A segment with the largest speed v of a joint of limit v_max needs v / v_max times its time, if that is more than
    one. "local" gives all time during it that factor, of overlapping segments the largest: every joint is slowed down
    together, and only where one is too fast. "uniform" stretches all by one factor.

    The joints go through the same configurations in either way, and so keep coupled limits and shared motors. With
    "local" the speed jumps where the factor changes; a joint without a key there gets one, and a smooth motion becomes
    a Bezier one.

    Args:
        robot: which has all the joints named.
        motion: what to change; its first key stays where it is.
        how: "local" or "uniform".

    Raises:
        UnknownName: the robot has no such joint, or there is no such way.
        BadArgument: a joint is to move whose limit is zero, or moves in no time.

    Examples:
        >>> nao = nk.load_nao()
        >>> turn = nk.Motion([0.0, 0.1], ["HeadYaw"], [[0.0], [1.5]])
        >>> mended = nk.motion.slow_down(nao, turn)
        >>> mended.motion.end > 0.1, nk.motion.check(nao, mended.motion).ok
        (True, True)
    """
    check_robot(robot)
    check_motion(motion)
    check_joints(robot, motion)
    if not isinstance(how, str) or how not in ("local", "uniform"):
        raise UnknownName("way to slow down", how, ("local", "uniform"))
    knots, factors = _needed(robot, motion)
    if how == "uniform":
        factors = np.full_like(factors, factors.max(initial=1.0))
    if not (factors > 1.0).any():
        return Mended(motion, ())
    new = np.concatenate([[motion.start], motion.start + np.cumsum(np.diff(knots) * factors)])
    changes = knots[1:-1][factors[1:] != factors[:-1]]
    result = time_warp(cut(motion, changes) if len(changes) else motion, _Stretched(knots, new))
    # The sum of many times is rounded.
    left = float(_needed(robot, result)[1].max(initial=1.0))
    return Mended(result if left == 1.0 else time_warp(result, left), _slower(knots, factors * left))


class _Stretched:
    """Time that runs slower between some knots, and as before outside of them."""

    def __init__(self, knots: Floats, new: Floats) -> None:
        self._knots, self._new = knots, new

    def __call__(self, times: Floats) -> Floats:
        inside = np.interp(times, self._knots, self._new)
        before, after = np.minimum(times - self._knots[0], 0.0), np.maximum(times - self._knots[-1], 0.0)
        return np.asarray(inside + before + after)


def _needed(robot: RobotModel, motion: Motion) -> tuple[Floats, Floats]:
    """All key times, and the factor by which the time between each two of them must grow."""
    knots = motion.key_times
    factors = np.ones(max(len(knots) - 1, 0))
    for column, joint in enumerate(motion.joint_names):
        curve = motion.segments[column]
        if not len(curve.start):
            continue
        pieces = pieces_of(curve, "speed", np.arange(len(curve.start)))
        fastest = np.zeros(len(curve.start))
        np.maximum.at(fastest, pieces.segment, np.abs(pieces.values).max(axis=1))
        _check_possible(robot, motion, joint, fastest)
        limit = largest_speed(robot, joint)
        share = np.divide(fastest, limit, out=np.zeros_like(fastest), where=fastest > 0.0)
        # The intervals between knots that a segment covers are consecutive.
        covers = np.clip(np.searchsorted(curve.start, knots[:-1], side="right") - 1, 0, None)
        during = (knots[:-1] >= motion.times[column][0]) & (knots[:-1] < motion.times[column][-1])
        factors = np.maximum(factors, np.where(during, share[covers], 1.0))
    return knots, np.where(factors > _FITS, factors, 1.0)


def _check_possible(robot: RobotModel, motion: Motion, joint: str, fastest: Floats) -> None:
    times = motion.times[motion.joint_names.index(joint)]
    if not np.isfinite(fastest).all():
        place = int(np.argmin(np.isfinite(fastest)))
        raise BadArgument(
            f"{joint} moves in no time between its keys {place} and {place + 1} ({times[place]:.6g} to "
            f"{times[place + 1]:.6g} s): its handles are vertical, and no time is long enough"
        )
    if largest_speed(robot, joint) <= 0.0 and fastest.any():
        raise BadArgument(f"{joint} is to move, and its speed limit is 0: no time is long enough")


def _slower(knots: Floats, factors: Floats) -> tuple[Change, ...]:
    """The stretches of time that take longer than they did, by a factor between each two knots."""
    changes = list[Change]()
    for start, end, factor in zip(knots[:-1].tolist(), knots[1:].tolist(), factors.tolist(), strict=True):
        if factor <= 1.0 + 1e-9:
            continue
        last = changes[-1] if changes else None
        if last is not None and last.end == start and abs(last.amount - factor) < 1e-9 * factor:
            changes[-1] = Change("slower", "", last.start, end, last.amount, "")
        else:
            changes.append(Change("slower", "", start, end, factor, ""))
    return tuple(changes)
