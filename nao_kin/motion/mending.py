"""Move motions into a robot's limits, make joints of one motor agree, and slow motions down."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import LIMIT_TOLERANCE, Floats, eased, runs
from nao_kin._core.sides import Hips, check_hips, joints_of_side
from nao_kin._core.text import one_line_repr
from nao_kin.errors import BadArgument
from nao_kin.motion.checking import bends, check, interval
from nao_kin.motion.curves import JointCurves, pieces_of
from nao_kin.motion.editing import cut, resample, time_warp
from nao_kin.motion.motion import HOLD, Motion, check_joints, sampling_times
from nao_kin.robot import RobotModel
from nao_kin.robot.semantics import CoupledLimit

# --- The changes of a motion.

# Keys per second of a motion made linear.
LINEAR_RATE = 100.0

Kind = Literal["clamped", "resampled", "one motor", "slower"]


@dataclass(frozen=True)
class Change:
    """A change of a joint in a time interval.

    Attributes:
        kind: "clamped": keys or handles were moved into the limits. "resampled": the motion became linear, with more
            keys. "one motor": the joint got the value of its motor. "slower": the motion takes longer.
        joint: name of the joint; "" for all.
        start: beginning, in the original motion [s].
        end: end [s].
        amount: the largest change of a value; for "slower", the factor of the duration.
        unit: the unit of the amount: "rad", "m" or "1"; "" for a factor.
    """

    kind: Kind
    joint: str
    start: float
    end: float
    amount: float
    unit: str

    def describe(self, *, degrees: bool = False) -> str:
        """Return the change in words, with angles in degrees if wanted.

        Examples:
            >>> nao = nk.load_nao()
            >>> turn = nk.Motion([0.0, 2.0], ["HeadYaw"], [[0.0], [3.0]])
            >>> nk.motion.clamp(nao, turn).changes[0].describe()
            'HeadYaw: moved into its limits by up to 0.914 rad (2 s)'
        """
        turns = degrees and self.unit == "rad"
        amount = f"{math.degrees(self.amount) if turns else self.amount:.3g}"
        amount += "°" if turns else "" if self.unit == "1" else f" {self.unit}"
        words = {
            "clamped": f"moved into its limits by up to {amount}",
            "resampled": f"made linear with {LINEAR_RATE:g} keys per second, which moved values by up to {amount}",
            "one motor": f"set to the value of its motor, which changed it by up to {amount}",
            "slower": f"takes {self.amount:.4g} times as long",
        }
        return f"{self.joint or 'all joints'}: {words[self.kind]} ({interval(self.start, self.end)})"

    def as_dict(self) -> dict[str, Any]:
        """Return the fields for JSON."""
        return dict(self.__dict__)


@one_line_repr
@dataclass(frozen=True, eq=False)
class MendedMotion:
    """A motion that was changed.

    Attributes:
        motion: the changed motion; the original one if nothing had to be changed.
        changes: the changes made. Each has a `kind` ("clamped", "resampled", "one motor" or "slower"), a `joint` (""
            for all), the interval from `start` to `end` in the original motion [s], and an `amount`, the largest change
            of a value, with its `unit`; for "slower" it is the factor of the duration. `describe()` says it in words.
    """

    motion: Motion
    changes: tuple[Change, ...]

    def describe(self, *, degrees: bool = False) -> str:
        """Return one line for each change, or a line for no change."""
        return "\n".join(change.describe(degrees=degrees) for change in self.changes) or "nothing had to be changed"


def changes_of(kind: Kind, joint: str, times: Floats, miss: Floats, unit: str) -> list[Change]:
    """Return a change for each run of moved keys, with its largest amount."""
    size = np.abs(miss)
    return [
        Change(kind, joint, float(times[run.start]), float(times[run.stop - 1]), float(size[run].max()), unit)
        for run in runs(size > LIMIT_TOLERANCE)
    ]


def made_linear(robot: RobotModel, motion: Motion) -> tuple[Motion, Change]:
    """Return a linear motion with the same keys and 100 more per second, and the resulting change."""
    grid = np.union1d(sampling_times(motion, LINEAR_RATE, None), motion.key_times)
    linear = resample(motion, times=grid)
    middle = 0.5 * (grid[:-1] + grid[1:])
    turning = [robot.unit(joint) == "rad" for joint in motion.joint_names]
    miss = np.abs(linear.sample(middle) - motion.sample(middle))[:, turning]
    return linear, Change("resampled", "", motion.start, motion.end, float(miss.max(initial=0.0)), "rad")


# --- Motions moved into the limits, and joints of one motor made to agree.


def clamp(robot: RobotModel, motion: Motion, *, missing: str | ArrayLike = HOLD) -> MendedMotion:
    """Return the motion with its keys moved into the limits, then into the coupled limits.

    A key outside the range of its joint is moved to the end of the range. The ends of the handles of a Bezier segment
    that overshoots are moved too: a curve stays within the hull of its control points. If a joint then leaves the range
    that depends on another joint, a linear motion gets more keys, and a smooth or Bezier motion becomes linear, with
    100 keys per second and one wherever a coupled limit bends. These keys are moved into the range.

    Args:
        robot: has all the joints named.
        motion: the motion to change.
        missing: values of the joints that the motion does not name, as in `Motion.configurations`.

    Raises:
        BadArgument: the motion moves a joint and thereby violates the coupled limit of a joint that it does not name.

    Examples:
        >>> nao = nk.load_nao()
        >>> turn = nk.Motion([0.0, 2.0], ["HeadYaw"], [[0.0], [3.0]])
        >>> float(nk.motion.clamp(nao, turn).motion.sample(2.0)[0].round(4))
        2.0857
    """
    check_joints(robot, motion)
    clamped, changes = _into_ranges(robot, motion)
    coupled = [row for row in check(robot, clamped, missing=missing).violations if row.kind == "coupled limit"]
    if not coupled:
        return MendedMotion(clamped if changes else motion, tuple(changes))
    fixed = next((row for row in coupled if row.joint not in motion.joint_names), None)
    if fixed is not None:
        raise BadArgument(
            f"the motion moves {fixed.of} and not {fixed.joint}, which would be outside: {fixed.describe()}; "
            "fill it in from another posture, or add it to the motion"
        )
    if clamped.interpolation != "linear":
        clamped, change = made_linear(robot, clamped)
        changes.append(change)
    for table in robot.coupled_limits:
        if table.joint in clamped.joint_names:
            clamped, moved = _into_table(robot, clamped, table, missing)
            changes += moved
    return MendedMotion(clamped, tuple(changes))


def share_motors(robot: RobotModel, motion: Motion, hips: Hips = "average") -> MendedMotion:
    """Return the motion with joints of one motor, such as the two HipYawPitch, made to agree.

    For "left" or "right" that curve is copied. The average of smooth or Bezier curves is exact if both have keys at the
    same times, and the motion becomes a Bezier one; else the motion becomes linear, with 100 keys per second.

    Args:
        robot: has all the joints named.
        motion: the motion to change.
        hips: the joint to follow, as in `Motion.configurations`.

    Examples:
        >>> nao = nk.load_nao()
        >>> split = nk.Motion([0.0, 1.0], ["LHipYawPitch", "RHipYawPitch"], [[0.0, 0.0], [-0.2, -0.4]])
        >>> nk.motion.share_motors(nao, split).motion.sample(1.0).round(9).tolist()
        [-0.3, -0.3]
    """
    check_joints(robot, motion)
    check_hips(hips)
    differing = {row.of for row in check(robot, motion).violations if row.kind == "motor"}
    groups = [joints for joints in robot.joints_by_motor(motion.joint_names).values() if joints[0] in differing]
    if not groups:
        return MendedMotion(motion, ())
    mended = motion if motion.interpolation == "linear" else motion.as_bezier()
    changes = list[Change]()
    if mended.handles is not None and not all(_same_times(mended, joints_of_side(joints, hips)) for joints in groups):
        mended, change = made_linear(robot, motion)
        changes.append(change)
    times, keys, handles = list(mended.times), list(mended.keys), list(mended.handles or ())
    for joints in groups:
        sources = [mended.joint_names.index(joint) for joint in joints_of_side(joints, hips)]
        knots = np.unique(np.concatenate([mended.times[column] for column in sources]))
        values = dict(zip(mended.joint_names, mended.sample(knots).T, strict=True))
        ((_, motor),) = robot.motor_values({name: values[name] for name in joints}, hips).items()
        moves = {joint: robot.mimics[joint].multiplier if joint in robot.mimics else 1.0 for joint in joints}
        for joint in joints:
            column, mimic = mended.joint_names.index(joint), robot.mimics.get(joint)
            times[column], keys[column] = knots, motor if mimic is None else mimic.value(motor)
            if mended.handles is not None:
                offsets = [mended.handles[s] * (1.0, moves[joint] / moves[mended.joint_names[s]]) for s in sources]
                handles[column] = np.mean(offsets, axis=0)
            miss = keys[column] - values[joint]
            changes += changes_of("one motor", joint, knots, miss, robot.unit(joint))
    return MendedMotion(Motion(times, mended.joint_names, keys, mended.interpolation, handles or None), tuple(changes))


def _same_times(motion: Motion, joints: list[str]) -> bool:
    """Return whether the keys of some joints, and the ends of their handles, are at the same times."""
    columns = [motion.joint_names.index(joint) for joint in joints]
    handles = motion.handles or ()
    return all(
        np.array_equal(motion.times[column], motion.times[columns[0]])
        and np.allclose(handles[column][..., 0], handles[columns[0]][..., 0], rtol=1e-12, atol=0.0)
        for column in columns[1:]
    )


def _into_ranges(robot: RobotModel, motion: Motion) -> tuple[Motion, list[Change]]:
    """Return the motion with keys and handles moved into the joints' own ranges, and the changes."""
    keys, handles = list[Floats](), list[Floats]()
    changes = list[Change]()
    for column, joint in enumerate(motion.joint_names):
        lower, upper, _ = robot.joints.limits(joint)
        given = motion.keys[column]
        outside = (given < lower - LIMIT_TOLERANCE) | (given > upper + LIMIT_TOLERANCE)
        clipped = np.where(outside, np.clip(given, lower, upper), given)
        miss = np.abs(clipped - given)
        if motion.handles is not None:
            offsets = np.array(motion.handles[column])
            # The end of a handle stays in place, or is moved to the end of the range if its segment overshoots.
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
        changes += changes_of("clamped", joint, motion.times[column], miss, robot.unit(joint))
    if not changes:
        return motion, []
    return Motion(motion.times, motion.joint_names, keys, motion.interpolation, handles or None), changes


def _overshoots(motion: Motion, column: int, lower: float, upper: float) -> NDArray[np.bool_]:
    """Return which segments of a joint leave its range, keys included."""
    curve = motion.segments[column]
    pieces = pieces_of(curve, "value", np.arange(len(curve.start)))
    outside = ((pieces.values < lower - LIMIT_TOLERANCE) | (pieces.values > upper + LIMIT_TOLERANCE)).any(axis=1)
    result = np.zeros(len(curve.start), dtype=np.bool_)
    result[pieces.segment[outside]] = True
    return result


def _into_table(
    robot: RobotModel, motion: Motion, table: CoupledLimit, missing: str | ArrayLike
) -> tuple[Motion, list[Change]]:
    """Return a linear motion with one joint moved into its coupled limit, and the changes."""
    joint = table.joint
    curves = JointCurves(motion, missing, robot, LINEAR_RATE)
    times = np.unique(curves.common_times(table.joint, table.of, bends=bends(curves[table.of], table)))
    given = curves.values(joint, times)
    wanted = np.clip(given, *table.range(curves.values(table.of, times)))
    moved = np.abs(wanted - given) > LIMIT_TOLERANCE
    if not moved.any():
        return motion, []
    # Keys next to the moved ones keep the rest of the curve as it was.
    column = motion.joint_names.index(joint)
    near = moved.copy()
    near[1:] |= moved[:-1]
    near[:-1] |= moved[1:]
    keep = near | np.isin(times, motion.times[column])
    new_times, keys = list(motion.times), list(motion.keys)
    new_times[column], keys[column] = times[keep], np.where(moved, wanted, given)[keep]
    changes = changes_of("clamped", joint, times, wanted - given, robot.unit(joint))
    return Motion(new_times, motion.joint_names, keys), changes


# --- Motions slowed down to the speed limits.

# Sums of times are rounded; a check allows ten times as much.
_SLACK = 1.0 + 1e-10


# Where a motion tips the robot, its time is stretched by the share _MORE, less and less up to _EASE [s] before and
# after, and this is done up to so many times, until it tilts by less than _MOST_TILT [rad]: joints do not follow a
# motion exactly (docs/balance.md). The stretch changes at keys, and at _GRID times a second that are
# farther from them than _APART [s].
_MOST_TILT = math.radians(2.0)
_TRIES, _MORE, _EASE, _GRID, _APART = 15, 0.15, 0.3, 20.0, 0.005


def slow_down(
    robot: RobotModel,
    motion: Motion,
    *,
    balance: bool = False,
    missing: str | ArrayLike = HOLD,
) -> MendedMotion:
    """Return the motion with time stretched until every joint satisfies its speed limit.

    A segment in which a joint with the limit v_max has the largest speed v takes v / v_max times as long, if this
    factor is above one. The time of that segment is stretched by this factor for all joints, that of overlapping
    segments by the largest factor.

    The joints pass through the same configurations, so coupled limits and shared motors are respected.
    The speed jumps where the factor changes; a joint without a key there gets one, and a smooth motion
    becomes a Bezier one.

    Args:
        robot: has all the joints named.
        motion: the motion to change; its first key stays in place.
        balance: then stretch time where the robot begins to tilt, and 0.3 s before and after, until it tilts by less
            than 2°, as `check(balance=True)` finds it.
        missing: with `balance`, values of the joints that the motion does not name, as in `Motion.configurations`.

    Raises:
        BadArgument: a joint has to move but its speed limit is zero, or it moves in no time; with `balance`, the robot
            falls or tilts by more than 2° also when it moves slowly.

    Examples:
        >>> nao = nk.load_nao()
        >>> turn = nk.Motion([0.0, 0.1], ["HeadYaw"], [[0.0], [1.5]])
        >>> mended = nk.motion.slow_down(nao, turn)
        >>> mended.motion.end > 0.1, nk.motion.check(nao, mended.motion).ok
        (True, True)
    """
    check_joints(robot, motion)
    mended = _within_speeds(robot, motion)
    return _upright(robot, mended, missing) if balance else mended


def _upright(robot: RobotModel, mended: MendedMotion, missing: str | ArrayLike) -> MendedMotion:
    """Return a motion that takes longer where it tips the robot, until the robot does not fall."""
    motion = mended.motion
    keys, grid = motion.key_times, np.linspace(motion.start, motion.end, math.ceil(_GRID * motion.duration) + 1)
    near = keys[np.searchsorted(keys, grid + _APART) - 1] > grid - _APART
    times = np.union1d(grid[~near], keys)
    now = times
    for _ in range(_TRIES):
        found = motion.balance(robot, missing=missing)
        tilts = [run for run in runs(found.rocking > 0.0) if (found.rocking[run] > _MOST_TILT).any()]
        if not tilts:
            break
        slower = np.zeros(len(times))
        for run in tilts:
            last = run.start + int((found.rocking[run] > _MOST_TILT).argmax())
            first, last = found.times[run.start], found.times[last]
            away = np.maximum(np.maximum(first - now, now - last), 0.0) / _EASE
            slower = np.maximum(slower, eased(1.0 - np.minimum(away, 1.0)))
        steps = np.diff(now) * (1.0 + _MORE * 0.5 * (slower[1:] + slower[:-1]))
        now = now[0] + np.concatenate([[0.0], np.cumsum(steps)])
        # With a key wherever the stretch changes, the joints pass through the same configurations.
        factors = np.diff(now) / np.diff(times)
        changes = times[1:-1][np.abs(np.diff(factors)) > 1e-9]
        motion = time_warp(cut(mended.motion, changes), partial(np.interp, xp=times, fp=now))
    else:
        worst = int((found.rocking > _MOST_TILT).argmax())
        outside = f": its centre of mass is {-1e3 * found.com_margin[worst]:.3g} mm outside its support"
        why = outside if -math.inf < found.com_margin[worst] < 0.0 else ""
        most = float(np.nanmax(found.rocking))
        does = "falls" if most > found.FALLS else f"tilts by {math.degrees(most):.2g}°"
        raise BadArgument(f"{robot.name} {does} at {found.times[worst]:.4g} s, also when it moves slowly{why}")
    if now is times:
        return mended
    longer = np.flatnonzero(np.diff(now) > (1.0 + 1e-9) * np.diff(times))
    start, end = longer[0], longer[-1] + 1
    factor = float((now[end] - now[start]) / (times[end] - times[start]))
    change = Change("slower", "", float(times[start]), float(times[end]), factor, "")
    return MendedMotion(motion, (*mended.changes, change))


def _within_speeds(robot: RobotModel, motion: Motion) -> MendedMotion:
    """Return the motion with time stretched until every joint satisfies its speed limit."""
    knots, factors = _stretch_factors(robot, motion)
    if not (factors > 1.0).any():
        return MendedMotion(motion, ())
    new = np.concatenate([[motion.start], motion.start + np.cumsum(np.diff(knots) * factors)])
    changes = knots[1:-1][factors[1:] != factors[:-1]]

    def stretched(times: Floats) -> Floats:
        before, after = np.minimum(times - knots[0], 0.0), np.maximum(times - knots[-1], 0.0)
        return np.asarray(np.interp(times, knots, new) + before + after)

    result = time_warp(cut(motion, changes) if len(changes) else motion, stretched)
    # The sum of many times is rounded.
    rest = float(_stretch_factors(robot, result)[1].max(initial=1.0))
    return MendedMotion(result if rest == 1.0 else time_warp(result, rest), _slower(knots, factors * rest))


def _stretch_factors(robot: RobotModel, motion: Motion) -> tuple[Floats, Floats]:
    """Return all key times, and the factors by which the time between each two must grow."""
    knots = motion.key_times
    factors = np.ones(max(len(knots) - 1, 0))
    for column, joint in enumerate(motion.joint_names):
        curve = motion.segments[column]
        if not len(curve.start):
            continue
        pieces = pieces_of(curve, "speed", np.arange(len(curve.start)))
        fastest = np.zeros(len(curve.start))
        np.maximum.at(fastest, pieces.segment, np.abs(pieces.values).max(axis=1))
        (*_, limit), own = robot.joints.limits(joint), motion.times[column]
        if not np.isfinite(fastest).all():
            place = int(np.argmin(np.isfinite(fastest)))
            raise BadArgument(
                f"{joint} moves in no time between its keys {place} and {place + 1} ({own[place]:.6g} to "
                f"{own[place + 1]:.6g} s): its handles are vertical, and no time is long enough"
            )
        if limit <= 0.0 and fastest.any():
            raise BadArgument(f"{joint} has to move, but its speed limit is 0: no time is long enough")
        share = np.divide(fastest, limit, out=np.zeros_like(fastest), where=fastest > 0.0)
        # A segment covers consecutive intervals between knots.
        covers = curve.at(knots[:-1])
        during = (knots[:-1] >= own[0]) & (knots[:-1] < own[-1])
        factors = np.maximum(factors, np.where(during, share[covers], 1.0))
    return knots, np.where(factors > _SLACK, factors, 1.0)


def _slower(knots: Floats, factors: Floats) -> tuple[Change, ...]:
    """Return the intervals with a factor above one, equal neighbours merged."""
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
