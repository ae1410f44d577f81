"""Motions that are too fast for a robot, slowed down."""

from __future__ import annotations

from typing import Literal

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.motion.changes import Change, Mended
from nao_kin.motion.checking import largest_speed
from nao_kin.motion.configurations import check_joints
from nao_kin.motion.editing import time_warp
from nao_kin.motion.monotone import pieces_of
from nao_kin.motion.motion import Motion
from nao_kin.robot import RobotModel, check_robot

# Smooth curves change with their times, and are stretched again.
_MOST_ROUNDS = 40
# Times are rounded when they are added up; a check allows ten times as much.
_FITS = 1.0 + 1e-10


def slow_down(robot: RobotModel, motion: Motion, *, how: Literal["local", "uniform"] = "local") -> Mended:
    """The motion with time stretched until every joint keeps its speed limit.

    A segment with the largest speed v of a joint of limit v_max needs v / v_max times its time, if that is more than
    one. "local" gives all time during it that factor, of overlapping segments the largest: every joint is slowed down
    together, and only where one is too fast. Smooth curves change shape with their times and are stretched again until
    they fit. "uniform" stretches all by one factor, and keeps the shape of every curve over time.

    Args:
        robot: which has all the joints named.
        motion: what to change; its first key stays where it is.
        how: "local" or "uniform".

    Raises:
        UnknownName: the robot has no such joint, or there is no such way.
        BadArgument: a joint is to move whose limit is zero, or moves in no time.
    """
    check_robot(robot)
    check_joints(robot, motion)
    if how not in ("local", "uniform"):
        raise UnknownName("way to slow down", how, ("local", "uniform"))
    result = motion
    rounds = 0 if how == "uniform" else _MOST_ROUNDS if motion.interpolation == "smooth" else 1
    for _ in range(rounds):
        knots, factors = _needed(robot, result)
        if factors.max(initial=1.0) <= _FITS:
            break
        new = np.concatenate([[result.start], result.start + np.cumsum(np.diff(knots) * factors)])
        result = time_warp(result, _Stretched(knots, new))
    left = float(_needed(robot, result)[1].max(initial=1.0))
    if left > _FITS:
        result = time_warp(result, left)
    return Mended(result, _slower(motion, result))


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
    return knots, factors


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


def _slower(before: Motion, after: Motion) -> tuple[Change, ...]:
    """The stretches of time that take longer than they did."""
    old, new = before.key_times, after.key_times
    factors = np.diff(new) / np.diff(old)
    changes = list[Change]()
    for start, end, factor in zip(old[:-1].tolist(), old[1:].tolist(), factors.tolist(), strict=True):
        if factor <= 1.0 + 1e-9:
            continue
        last = changes[-1] if changes else None
        if last is not None and last.end == start and abs(last.amount - factor) < 1e-9 * factor:
            changes[-1] = Change("slower", "", last.start, end, last.amount, "")
        else:
            changes.append(Change("slower", "", start, end, factor, ""))
    return tuple(changes)
