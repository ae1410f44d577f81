"""The curves of a motion's joints over its whole duration, combinations of two of them, and the times above a bound."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats
from nao_kin.motion.interpolation import Segments, segments
from nao_kin.motion.motion import Motion, filled
from nao_kin.robot import RobotModel


class JointCurves:
    """The curve of every joint of a robot during a motion; joints that are not named stand still."""

    def __init__(self, motion: Motion, missing: str | ArrayLike, robot: RobotModel, rate: float) -> None:
        """Prepare the curves; `missing` is that of `Motion.configurations`, `rate` in samples per second."""
        self._motion, self._robot, self._rate = motion, robot, rate
        self._missing = filled(robot, missing)[robot.nq_base :]
        self._cache: dict[str, Segments] = {}
        self.sampled = False  # whether common times of Bezier curves, which have to be sampled, were requested

    def __getitem__(self, joint: str) -> Segments:
        """Return the curve of a joint, from the first key of the motion to the last."""
        if joint not in self._cache:
            self._cache[joint] = self._curve(joint)
        return self._cache[joint]

    def values(self, joint: str, times: Floats) -> Floats:
        """Return values (n,) of a joint at times (n,)."""
        curve = self[joint]
        segment = curve.at(times)
        return curve.value(segment, curve.parameter(segment, times))

    def values_at(self, time: float, *joints: str) -> list[float]:
        """Return the values of joints at one time."""
        return [float(self.values(joint, np.array([time]))[0]) for joint in joints]

    def common_times(self, *joints: str, bends: Floats | None = None) -> Floats:
        """Return times, including `bends`, between which each joint's curve is one cubic; Bezier curves are sampled."""
        motion = self._motion
        times = [np.array([motion.start, motion.end])]
        times += [motion.times[motion.joint_names.index(joint)] for joint in joints if joint in motion.joint_names]
        times += [] if bends is None else [bends]
        if motion.handles is not None:
            self.sampled = True
            steps = int(np.ceil(motion.duration * self._rate))
            times.append(np.linspace(motion.start, motion.end, steps + 1))
        result = np.unique(np.concatenate(times))
        return result if len(result) > 1 else np.repeat(result, 2)

    def _curve(self, joint: str) -> Segments:
        motion = self._motion
        if joint in motion.joint_names:
            column = motion.joint_names.index(joint)
            times, keys, curve = motion.times[column], motion.keys[column], motion.segments[column]
        else:
            times, keys = np.array([motion.start]), self._missing[[self._robot.joint_names.index(joint)]]
            curve = segments("linear", times, keys, None)
        return held(curve, times, keys, motion.start, motion.end)


def held(curve: Segments, times: Floats, keys: Floats, start: float, end: float) -> Segments:
    """Return the segments between keys, and one before and after them with the joint at rest, at least one in all."""
    before, after = times[0] - start, end - times[-1]
    first = before > 0.0 or (len(keys) == 1 and after <= 0.0)
    if not first and after <= 0.0:
        return curve
    count = int(first), int(after > 0.0)
    lengths = None if curve.lengths is None else np.pad(curve.lengths, (count, (0, 0)), constant_values=1.0 / 3.0)
    return Segments(
        np.concatenate([[start][: count[0]], curve.start, times[-1:][: count[1]]]),
        np.concatenate([[before][: count[0]], curve.width, [after][: count[1]]]),
        np.concatenate([keys[:1][: count[0]], curve.first, keys[-1:][: count[1]]]),
        np.pad(curve.controls, (count, (0, 0))),
        lengths,
    )


def combination(one: Segments, other: Segments, times: Floats, slope: Floats, values: Floats) -> Segments:
    """Return one − slope · other − constant as cubics, from its values and times (m + 1,) and the slope (m,)."""
    width, rise = np.diff(times), np.diff(values)
    middle = times[:-1] + 0.5 * width
    inner = []
    for end in (times[:-1], times[1:]):
        with np.errstate(invalid="ignore"):
            speed = _speed_within(one, middle, end) - slope * _speed_within(other, middle, end)
        # A straight line where the speed is infinite.
        inner.append(np.where(np.isfinite(speed), speed * width, rise) / 3.0)
    return Segments(times[:-1], width, values[:-1], np.stack([inner[0], rise - inner[1], rise], axis=-1))


def _speed_within(curve: Segments, middle: Floats, end: Floats) -> Floats:
    """Return the speed at one end of intervals, in the segment that contains their middle."""
    segment = curve.at(middle)
    return curve.speed(segment, curve.parameter(segment, end))


# --- Times at which a curve of cubic segments is above a bound: found exactly, from monotone pieces.

# Halvings of a piece, which locate a crossing up to rounding.
_HALVINGS = 54

Quantity = Literal["value", "speed"]


@dataclass(frozen=True, eq=False)
class Pieces:
    """Monotone pieces of a curve, n of them in order of time."""

    curve: Segments  # the segments that were divided
    quantity: Quantity
    segment: NDArray[np.intp]  # of each piece
    ends: Floats  # parameters u of its two ends, shape (n, 2)
    times: Floats  # of its two ends, shape (n, 2) [s]
    values: Floats  # the quantity at its two ends, shape (n, 2)

    def crossings(self, pieces: NDArray[Any], level: Floats | float) -> Floats:
        """Return the times at which some pieces, with ends on both sides of `level`, cross it [s]."""
        low, high = self.ends[pieces].T
        rises = self.values[pieces, 1] > self.values[pieces, 0]
        segment = self.segment[pieces]
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            before = (_quantity(self.curve, self.quantity, segment, middle) < level) == rises
            low, high = np.where(before, middle, low), np.where(before, high, middle)
        return self.curve.time(segment, 0.5 * (low + high))


class Excess(NamedTuple):
    """A time interval in which a quantity is above a bound."""

    start: float  # [s]
    end: float  # [s]
    time: float  # of the largest quantity [s]
    value: float  # of the quantity at that time


def pieces_of(curve: Segments, quantity: Quantity, chosen: NDArray[Any]) -> Pieces:
    """Return the monotone pieces of some segments, given in ascending order.

    The value turns where its derivative by u, a quadratic, is zero. So does the speed value′ / x′: of value″ x′ −
    value′ x″ the cubic term cancels.
    """
    value, time = curve.slopes(chosen), curve.time_slopes(chosen)
    a, b, c = value[0] - 2.0 * value[1] + value[2], value[1] - value[0], value[0]
    if quantity == "speed":
        a1, b1, c1 = time[0] - 2.0 * time[1] + time[2], time[1] - time[0], time[0]
        a, b, c = a * b1 - b * a1, 0.5 * (a * c1 - c * a1), b * c1 - c * b1
    # A missing root, or one outside, gives a piece of zero length.
    turns = np.sort(np.clip(_roots(a, b, c), 0.0, 1.0), axis=0)
    if quantity == "speed":
        # The speed is also unbounded next to the parameter with x′ = 0.
        turns = np.sort(np.concatenate([turns, slowest(time)[None]]), axis=0)
    bounds = np.concatenate([np.zeros((1, len(chosen))), turns, np.ones((1, len(chosen)))])
    ends = np.stack([bounds[:-1], bounds[1:]], axis=-1)
    length = ends[..., 1] > ends[..., 0]
    ends = np.swapaxes(ends, 0, 1)[length.T]
    segment = np.repeat(np.asarray(chosen, dtype=np.intp), length.sum(axis=0))
    times = np.stack([curve.time(segment, u) for u in ends.T], axis=-1)
    values = np.stack([_quantity(curve, quantity, segment, u) for u in ends.T], axis=-1)
    return Pieces(curve, quantity, segment, ends, times, values)


def excesses(curve: Segments, quantity: Quantity, bound: float, sign: float, tolerance: float) -> list[Excess]:
    """Return the time intervals, in order, with sign · quantity > sign · bound + tolerance."""
    if not np.isfinite(bound):
        return []
    chosen = np.flatnonzero(_may_exceed(curve, quantity, bound, sign, tolerance))
    pieces = pieces_of(curve, quantity, chosen)
    over = sign * (pieces.values - bound)
    outside = over > tolerance
    touched = np.flatnonzero(outside.any(axis=1))
    if not len(touched):
        return []
    over, outside = over[touched], outside[touched]
    # An interval continues in the next piece if both are outside at their common end.
    neighbours = (np.diff(touched) == 1) & (np.diff(pieces.segment[touched]) <= 1)
    continues = outside[:-1, 1] & outside[1:, 0] & neighbours
    first = np.flatnonzero(np.concatenate([[True], ~continues]))
    last = np.concatenate([first[1:], [len(touched)]]) - 1
    peaks = over.max(axis=1)
    times = pieces.times[touched]
    start, end = times[first, 0], times[last, 1]
    for moments, piece, side in ((start, first, 0), (end, last, 1)):
        passes = over[piece, side] < 0.0
        moments[passes] = pieces.crossings(touched[piece[passes]], bound)
    rows = []
    for row, (begin, finish) in enumerate(zip(first.tolist(), last.tolist(), strict=True)):
        place = begin + int(np.argmax(peaks[begin : finish + 1]))
        side = int(np.argmax(over[place]))
        value = float(pieces.values[touched[place], side])
        rows.append(Excess(float(start[row]), float(end[row]), float(times[place, side]), value))
    return rows


def _quantity(curve: Segments, quantity: Quantity, segment: NDArray[Any], u: Floats) -> Floats:
    return curve.value(segment, u) if quantity == "value" else curve.speed(segment, u)


def _may_exceed(curve: Segments, quantity: Quantity, bound: float, sign: float, tolerance: float) -> NDArray[np.bool_]:
    """Return which segments may exceed a bound, by their control points."""
    if quantity == "value":
        reach = sign * curve.first + np.maximum((sign * curve.controls).max(axis=1), 0.0)
        return np.asarray(reach > sign * bound + tolerance)
    every = np.arange(len(curve.start))
    fastest = (sign * curve.slopes(every)).max(axis=0)
    slowest = curve.time_slopes(every).min(axis=0)
    allowed = (sign * bound + tolerance) * curve.width * slowest
    return np.asarray((fastest > allowed) | (slowest <= 0.0))


def _roots(a: Floats, b: Floats, c: Floats) -> Floats:
    """Return both solutions of a u² + 2 b u + c = 0, shape (2, n); 0 for a complex one."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        # First the sum of two terms with equal signs: no digits cancel.
        sum_ = -(b + np.copysign(np.sqrt(b * b - a * c), b))
        roots = np.stack([sum_ / a, c / sum_])
    return np.where(np.isfinite(roots), roots, 0.0)


def slowest(time: Floats) -> Floats:
    """Return the u of the least dx/du, given its Bernstein coefficients (3, n); 0 if it is least at an end."""
    bend = time[0] - 2.0 * time[1] + time[2]
    with np.errstate(divide="ignore", invalid="ignore"):
        u = (time[0] - time[1]) / bend
    return np.asarray(np.where((bend > 0.0) & (u > 0.0) & (u < 1.0), u, 0.0))
