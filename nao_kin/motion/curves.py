"""The curves of a motion's joints over the whole of its time, and of what becomes of two of them together."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nao_kin._common.arrays import Floats
from nao_kin.errors import BadArgument
from nao_kin.motion.interpolation import Segments, segments
from nao_kin.motion.motion import Motion
from nao_kin.robot import RobotModel

_MOST_SAMPLES = 4_000_000


class JointCurves:
    """The curve of every joint of a robot while a motion lasts; joints not named stand still.

    Attributes:
        sampled: whether times of samples were asked for.
    """

    def __init__(self, motion: Motion, fill: Floats, robot: RobotModel, rate: float) -> None:
        """Prepare the curves.

        Args:
            motion: what is to be done.
            fill: values of all joints of the robot, shape (n,).
            robot: whose joints.
            rate: samples per second, where they are needed.
        """
        self._motion, self._fill, self._robot, self._rate = motion, fill, robot, rate
        self._kept: dict[str, Segments] = {}
        self.sampled = False

    def __getitem__(self, joint: str) -> Segments:
        """The curve of a joint, from the first key of the motion to the last."""
        if joint not in self._kept:
            # Few are asked for twice, and those of long motions are large.
            self._kept = dict(list(self._kept.items())[-1:])
            self._kept[joint] = self._curve(joint)
        return self._kept[joint]

    def values(self, joint: str, times: Floats) -> Floats:
        """Values of a joint, shape (n,)."""
        curve = self[joint]
        segment = np.clip(np.searchsorted(curve.start, times, side="right") - 1, 0, None)
        return curve.value(segment, curve.parameter(segment, times))

    def common_times(self, *joints: str, bends: Floats | None = None) -> Floats:
        """Times between which the curves of some joints are each one cubic; of Bezier curves, also those of samples.

        Args:
            joints: which.
            bends: further times.
        """
        motion = self._motion
        times = [np.array([motion.start, motion.end])]
        times += [motion.times[motion.joint_names.index(joint)] for joint in joints if joint in motion.joint_names]
        times += [] if bends is None else [bends]
        if motion.handles is not None:
            self.sampled = True
            steps = motion.duration * self._rate
            if steps > _MOST_SAMPLES:
                raise BadArgument(
                    f"{motion.duration:g} s at {self._rate:g} samples per second are too many; lower rate"
                )
            times.append(np.linspace(motion.start, motion.end, int(np.ceil(steps)) + 1))
        found = np.unique(np.concatenate(times))
        return found if len(found) > 1 else np.repeat(found, 2)

    def _curve(self, joint: str) -> Segments:
        motion = self._motion
        if joint not in motion.joint_names:
            times, keys = np.array([motion.start]), self._fill[[self._robot.joint_names.index(joint)]]
            return held(segments("linear", times, keys, None), times, keys, motion.start, motion.end)
        column = motion.joint_names.index(joint)
        times, keys = motion.times[column], motion.keys[column]
        handles = None if motion.handles is None else motion.handles[column]
        curve = segments(motion.interpolation, times, keys, handles)
        return held(curve, times, keys, motion.start, motion.end)


def held(curve: Segments, times: Floats, keys: Floats, start: float, end: float) -> Segments:
    """The segments between keys, and before and after them one each in which the joint stands still.

    There is always one, if of no width.

    Args:
        curve: the segments.
        times: of the keys, shape (k,) [s].
        keys: values there, shape (k,).
        start: when the first one begins [s].
        end: when the last one ends [s].
    """
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
    """The curve one − slope · other − constant between times: the cubic with its values and speeds at both ends.

    It is exact where both are cubics in time there.

    Args:
        one: the one curve.
        other: the other one.
        times: ascending, shape (m + 1,) [s].
        slope: on each interval, shape (m,).
        values: of the combination at the times, shape (m + 1,).
    """
    width, rise = np.diff(times), np.diff(values)
    middle = times[:-1] + 0.5 * width
    inner = []
    for end in (times[:-1], times[1:]):
        with np.errstate(invalid="ignore"):
            speed = _speed_within(one, middle, end) - slope * _speed_within(other, middle, end)
        # A speed without bound, and the straight line instead.
        inner.append(np.where(np.isfinite(speed), speed * width, rise) / 3.0)
    return Segments(times[:-1], width, values[:-1], np.stack([inner[0], rise - inner[1], rise], axis=-1))


def _speed_within(curve: Segments, middle: Floats, end: Floats) -> Floats:
    """Speed at one end of intervals, in the segment that the interval is part of."""
    segment: NDArray[np.intp] = np.clip(np.searchsorted(curve.start, middle, side="right") - 1, 0, None)
    return curve.speed(segment, curve.parameter(segment, end))
