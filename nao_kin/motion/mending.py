"""Motions that leave the limits of a robot moved into them, and joints of one motor made to agree."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, choice
from nao_kin.errors import BadArgument
from nao_kin.motion.checking import bends, check, joint_range, largest_speed, shared_motors
from nao_kin.motion.configurations import (
    HOLD,
    Hips,
    check_hips,
    motor_values,
    sampling_times,
    side_of,
)
from nao_kin.motion.curves import JointCurves, pieces_of
from nao_kin.motion.editing import cut, resample, time_warp
from nao_kin.motion.motion import Motion, check_both
from nao_kin.robot import LIMIT_TOLERANCE, RobotModel
from nao_kin.robot.semantics import CoupledLimit

# --- What was changed in a motion, and by how much.

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


# --- Motions that leave the limits of a robot moved into them, and joints of one motor made to agree.


def clamp(robot: RobotModel, motion: Motion, *, fill: str | ArrayLike = HOLD) -> Mended:
    """The motion with keys moved into the limits, and then into the coupled ones.

    A key outside the range of its joint goes to the end of the range. A Bezier segment that overshoots has the ends of
    its handles moved too: a curve stays within the hull of its control points. Then, where a joint leaves the range
    that another one gives it, a linear motion gets further keys and a smooth or a Bezier one becomes linear, with 100
    keys per second and one wherever a coupled limit bends; and these keys are moved into the range.

    Args:
        robot: which has all the joints named.
        motion: what to change.
        fill: where joints are that the motion does not name, as in `Motion.configurations`.

    Raises:
        UnknownName: the robot has no such joint or posture.
        BadArgument: a joint that the motion does not name is where a coupled limit refuses one that it names.

    Examples:
        >>> nao = nk.load_nao()
        >>> turn = nk.Motion([0.0, 2.0], ["HeadYaw"], [[0.0], [3.0]])
        >>> float(nk.motion.clamp(nao, turn).motion.sample(2.0)[0].round(4))
        2.0857
    """
    check_both(robot, motion)
    boxed, changes = _into_boxes(robot, motion)
    coupled = [row for row in check(robot, boxed, fill=fill).violations if row.kind == "coupled limit"]
    if not coupled:
        return Mended(boxed if changes else motion, tuple(changes))
    fixed = next((row for row in coupled if row.joint not in motion.joint_names), None)
    if fixed is not None:
        raise BadArgument(
            f"the motion moves {fixed.of} and not {fixed.joint}, which would be outside: {fixed.describe()}; "
            "fill it in from another posture, or add it to the motion"
        )
    if boxed.interpolation != "linear":
        boxed, change = straightened(robot, boxed)
        changes.append(change)
    for table in robot.coupled_limits:
        if table.joint in boxed.joint_names:
            boxed, moved = _into_table(robot, boxed, table, fill)
            changes += moved
    return Mended(boxed, tuple(changes))


def share_motors(robot: RobotModel, motion: Motion, hips: Hips = "average") -> Mended:
    """The motion with joints of one motor, such as the two HipYawPitch, made to agree.

    The left or the right curve is copied. The average of smooth or Bezier curves is exact where both have their keys at
    the same times, the motion then being a Bezier one; else the motion becomes linear, with 100 keys per second.

    Args:
        robot: which has all the joints named.
        motion: what to change.
        hips: which of them is right, as in `Motion.configurations`.

    Raises:
        UnknownName: the robot has no such joint, or there is no such rule.

    Examples:
        >>> nao = nk.load_nao()
        >>> split = nk.Motion([0.0, 1.0], ["LHipYawPitch", "RHipYawPitch"], [[0.0, 0.0], [-0.2, -0.4]])
        >>> nk.motion.share_motors(nao, split).motion.sample(1.0).round(9).tolist()
        [-0.3, -0.3]
    """
    check_both(robot, motion)
    check_hips(hips)
    apart = {row.of for row in check(robot, motion).violations if row.kind == "motor"}
    groups = [joints for joints in shared_motors(robot, motion).values() if joints[0] in apart]
    if not groups:
        return Mended(motion, ())
    mended = motion if motion.interpolation == "linear" else motion.as_bezier()
    changes = list[Change]()
    if mended.handles is not None and not all(_same_times(mended, _chosen(joints, hips)) for joints in groups):
        mended, change = straightened(robot, motion)
        changes.append(change)
    times, keys, handles = list(mended.times), list(mended.keys), list(mended.handles or ())
    for joints in groups:
        sources = [mended.joint_names.index(joint) for joint in _chosen(joints, hips)]
        knots = np.unique(np.concatenate([mended.times[column] for column in sources]))
        values = dict(zip(mended.joint_names, mended.sample(knots).T, strict=True))
        ((_, motor),) = motor_values(robot, {name: values[name] for name in joints}, hips).items()
        for joint in joints:
            column, mimic = mended.joint_names.index(joint), robot.mimics.get(joint)
            times[column], keys[column] = knots, motor if mimic is None else mimic.value(motor)
            if handles:
                offsets = [
                    mended.handles[source] * (1.0, _scale(robot, mended.joint_names[source], joint))  # type: ignore[index]
                    for source in sources
                ]
                handles[column] = np.mean(offsets, axis=0)
            miss = keys[column] - values[joint]
            changes += changed_stretches("one motor", joint, knots, miss, robot.unit(joint))
    return Mended(Motion(times, mended.joint_names, keys, mended.interpolation, handles or None), tuple(changes))


def _chosen(joints: list[str], hips: Hips) -> list[str]:
    """Those joints of one motor that say what it does."""
    return [joint for joint in joints if side_of(joint) == hips] or joints


def _same_times(motion: Motion, joints: list[str]) -> bool:
    """Whether the keys of some joints, and the ends of their handles, are at the same times."""
    columns = [motion.joint_names.index(joint) for joint in joints]
    handles = motion.handles or ()
    return all(
        np.array_equal(motion.times[column], motion.times[columns[0]])
        and np.allclose(handles[column][..., 0], handles[columns[0]][..., 0], rtol=1e-12, atol=0.0)
        for column in columns[1:]
    )


def _scale(robot: RobotModel, source: str, joint: str) -> float:
    """How much a joint moves while another one of its motor moves by one."""
    moves = [robot.mimics[name].multiplier if name in robot.mimics else 1.0 for name in (joint, source)]
    return moves[0] / moves[1]


def _into_boxes(robot: RobotModel, motion: Motion) -> tuple[Motion, list[Change]]:
    keys, handles = list[Floats](), list[Floats]()
    changes = list[Change]()
    for column, joint in enumerate(motion.joint_names):
        lower, upper = joint_range(robot, joint)
        given = motion.keys[column]
        outside = (given < lower - LIMIT_TOLERANCE) | (given > upper + LIMIT_TOLERANCE)
        clipped = np.where(outside, np.clip(given, lower, upper), given)
        miss = np.abs(clipped - given)
        if motion.handles is not None:
            offsets = np.array(motion.handles[column])
            # The end of a handle stays where it was, or goes to the end of the range, if its segment overshoots.
            ends = given[:, None] + offsets[..., 1]
            offsets[..., 1] = np.where(outside[:, None], ends - clipped[:, None], offsets[..., 1])
            over = _overshoots(motion, column, lower, upper)
            for side, neighbours in ((0, slice(1, None)), (1, slice(None, -1))):
                wanted = np.clip(ends[neighbours, side], lower, upper)
                moved = over & (np.abs(wanted - ends[neighbours, side]) > LIMIT_TOLERANCE)
                offsets[neighbours, side, 1] = np.where(
                    moved, wanted - clipped[neighbours], offsets[neighbours, side, 1]
                )
                miss[neighbours] = np.maximum(miss[neighbours], moved * np.abs(wanted - ends[neighbours, side]))
            handles.append(offsets)
        keys.append(clipped)
        changes += changed_stretches("clamped", joint, motion.times[column], miss, robot.unit(joint))
    if not changes:
        return motion, []
    return Motion(motion.times, motion.joint_names, keys, motion.interpolation, handles or None), changes


def _overshoots(motion: Motion, column: int, lower: float, upper: float) -> NDArray[np.bool_]:
    """Which segments of a joint leave its range somewhere, its keys included."""
    curve = motion.segments[column]
    pieces = pieces_of(curve, "value", np.arange(len(curve.start)))
    outside = ((pieces.values < lower - LIMIT_TOLERANCE) | (pieces.values > upper + LIMIT_TOLERANCE)).any(axis=1)
    found = np.zeros(len(curve.start), dtype=np.bool_)
    found[pieces.segment[outside]] = True
    return found


def _into_table(
    robot: RobotModel, motion: Motion, table: CoupledLimit, fill: str | ArrayLike
) -> tuple[Motion, list[Change]]:
    """A linear motion with one joint moved into what another one leaves it."""
    joint = table.joint
    curves = JointCurves(motion, fill, robot, STRAIGHT_RATE)
    times = np.unique(curves.common_times(table.joint, table.of, bends=bends(curves[table.of], table)))
    given = curves.values(joint, times)
    wanted = np.clip(given, *table.range(curves.values(table.of, times)))
    moved = np.abs(wanted - given) > LIMIT_TOLERANCE
    if not moved.any():
        return motion, []
    # Beside what is moved, the keys that were there keep the rest as it was.
    column = motion.joint_names.index(joint)
    near = moved.copy()
    near[1:] |= moved[:-1]
    near[:-1] |= moved[1:]
    kept = near | np.isin(times, motion.times[column])
    new_times, keys = list(motion.times), list(motion.keys)
    new_times[column], keys[column] = times[kept], np.where(moved, wanted, given)[kept]
    changes = changed_stretches("clamped", joint, times, wanted - given, robot.unit(joint))
    return Motion(new_times, motion.joint_names, keys), changes


# --- Motions that are too fast for a robot, slowed down.

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
    check_both(robot, motion)
    choice(how, ("local", "uniform"), "way to slow down")
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
        limit, own = largest_speed(robot, joint), motion.times[column]
        if not np.isfinite(fastest).all():
            place = int(np.argmin(np.isfinite(fastest)))
            raise BadArgument(
                f"{joint} moves in no time between its keys {place} and {place + 1} ({own[place]:.6g} to "
                f"{own[place + 1]:.6g} s): its handles are vertical, and no time is long enough"
            )
        if limit <= 0.0 and fastest.any():
            raise BadArgument(f"{joint} is to move, and its speed limit is 0: no time is long enough")
        share = np.divide(fastest, limit, out=np.zeros_like(fastest), where=fastest > 0.0)
        # The intervals between knots that a segment covers are consecutive.
        covers = np.clip(np.searchsorted(curve.start, knots[:-1], side="right") - 1, 0, None)
        during = (knots[:-1] >= own[0]) & (knots[:-1] < own[-1])
        factors = np.maximum(factors, np.where(during, share[covers], 1.0))
    return knots, np.where(factors > _FITS, factors, 1.0)


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
