"""Tasks that move joints: along keys in time, or towards angles at limited speed."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin.motion import Motion
from nao_kin.naoqi.virtual.arguments import check_duration
from nao_kin.naoqi.virtual.engine import TICK
from nao_kin.naoqi.virtual.machine import Machine, MotionTask

# The number of ticks for which a motion is sampled in one call, which takes little longer than sampling one tick.
_TICKS_AHEAD = 64
# The longest handle of a joint that begins with a velocity away from its next key [s].
_BRAKING = 0.1
# The rounding that a task ignores in its last tick [s].
ON_TIME = 1e-9


class Interpolation(MotionTask):
    """Joints follow a motion: angleInterpolation and its relatives.

    When the joints are free, `plan` makes their motion, from time zero, given their commanded values, shape (joints,).
    """

    def __init__(self, name: str, joints: Sequence[str], plan: Callable[[Floats], Motion]) -> None:
        super().__init__(name, joints)
        self._plan = plan

    def start(self, nao: Machine, time: float) -> None:
        """Make the motion from the commanded joint values."""
        super().start(nao, time)
        self._motion = self._plan(nao.joints.command[self.columns])
        velocity = nao.joints.velocity_left(self.columns, nao.clock.ticks)
        if velocity.any() and self._motion.interpolation != "linear":
            self._motion = _begun_moving(self._motion, velocity)
        self._end = self._motion.end
        self._ahead: deque[Floats] = deque()
        extremes = np.array([[row.min() for row in self._motion.keys], [row.max() for row in self._motion.keys]])
        nao.joints.note_outside(self.columns, extremes, self.notes)

    def advance(self, nao: Machine, time: float) -> bool:
        """Command the motion's values at this time."""
        t = time - self.begin
        if not self._ahead:
            self._ahead.extend(self._motion.sample(t + TICK * np.arange(_TICKS_AHEAD)))
        values, done = self._ahead.popleft(), t >= self._end - ON_TIME
        nao.joints.set(self.columns, self._motion.sample(self._end) if done else values, self.notes)
        return done

    def end(self, nao: Machine, *, killed: bool) -> None:
        """Note the velocity of joints whose movement is killed."""
        if killed and self.started is not None:
            velocity = self._motion.speed(nao.clock.now - self.begin)
            nao.joints.leave_moving(self.columns, velocity, nao.clock.ticks)


def _begun_moving(motion: Motion, velocity: Floats) -> Motion:
    """Return the motion with velocities (n,) at its beginning; joints brake before they pass their next keys, or soon.

    A joint that moves towards its next key keeps within it; any other brakes within a tenth of a second.
    """
    curves = motion.as_bezier()
    assert curves.handles is not None
    handles = [np.array(rows) for rows in curves.handles]
    for joint, speed in enumerate(velocity.tolist()):
        if speed != 0.0:
            gap, way = float(curves.times[joint][1] - curves.times[joint][0]), np.diff(curves.keys[joint][:2])[0]
            longest = way / speed if way * speed > 0.0 else _BRAKING
            length = min(gap / 3.0, longest)
            handles[joint][0, 1] = length, speed * length
    return Motion(curves.times, motion.joint_names, curves.keys, "bezier", handles)


class AtSpeed(Interpolation):
    """Joints move straight to targets and arrive together, after max |target − start| / (fraction · max_speed)."""

    def __init__(self, name: str, nao: Machine, joints: Sequence[str], targets: Floats, fraction: float) -> None:
        speeds = fraction * nao.joints.max_speed[nao.joints.columns(joints)]

        def plan(start: Floats) -> Motion:
            duration = float(np.max(np.abs(targets - start) / speeds))
            check_duration(duration, "the time to the targets")
            if duration == 0.0:
                return Motion([0.0], joints, targets[None])
            return Motion([0.0, duration], joints, np.stack([start, targets]))

        super().__init__(name, joints, plan)


class HandMove(AtSpeed):
    """A hand opens or closes with full stiffness, and then has none: openHand and closeHand."""

    def start(self, nao: Machine, time: float) -> None:
        """Set full stiffness only now: a task that this one waited for may have removed it at its end."""
        nao.joints.set_stiffness(nao.joints.columns(self.joints), 1.0)
        super().start(nao, time)

    def end(self, nao: Machine, *, killed: bool) -> None:
        """Remove the stiffness."""
        super().end(nao, killed=killed)
        if self.started is None:
            return
        if killed:
            nao.joints.set_stiffness(self.columns, 0.0)
        else:
            nao.joints.release(self.columns)


class Approach(MotionTask):
    """Joints move to angles, or with `relative` by changes, each at a fraction of its own maximum speed: setAngles."""

    reactive = True

    def __init__(
        self, name: str, joints: Sequence[str], targets: Floats, fraction: float, *, relative: bool = False
    ) -> None:
        super().__init__(name, joints)
        self._targets, self._fraction, self._relative = np.array(targets), fraction, relative

    def start(self, nao: Machine, time: float) -> None:
        """Begin at the commanded joint values."""
        super().start(nao, time)
        self._at = nao.joints.command[self.columns]
        if self._relative:
            self._targets = self._at + self._targets
        self._step = self._fraction * nao.joints.max_speed[self.columns] * TICK
        nao.joints.note_outside(self.columns, self._targets[None], self.notes)
        self._targets = np.clip(self._targets, nao.joints.lower[self.columns], nao.joints.upper[self.columns])

    def advance(self, nao: Machine, time: float) -> bool:
        """Move the joints towards the targets for one tick."""
        way = self._targets - self._at
        near = np.abs(way) <= self._step * (1.0 + ON_TIME)
        self._at = np.where(near, self._targets, self._at + np.clip(way, -self._step, self._step))
        nao.joints.set(self.columns, self._at, self.notes)
        return bool(near.all())

    def give_up(self, resources: frozenset[str]) -> None:
        """Leave some joints to another task."""
        kept = [joint not in resources for joint in self.joints]
        super().give_up(resources)
        self._targets = self._targets[kept]
        if self.started is not None:
            self._at, self._step = self._at[kept], self._step[kept]


class StiffnessRamp(MotionTask):
    """Stiffnesses follow a motion, on straight lines from key to key: stiffnessInterpolation."""

    def __init__(self, joints: Sequence[str], times: Sequence[Floats], keys: Sequence[Floats]) -> None:
        super().__init__("stiffnessInterpolation", [f"{joint}/Stiffness" for joint in joints])
        self.joints, self._times, self._keys = tuple(joints), times, keys

    def start(self, nao: Machine, time: float) -> None:
        """Begin at the current stiffnesses."""
        self.columns, self.begin = nao.joints.columns(self.joints), time
        self._motion = through(self.joints, self._times, self._keys, nao.joints.stiffness[self.columns], "linear")

    def advance(self, nao: Machine, time: float) -> bool:
        """Set the motion's values at this time."""
        done = time - self.begin >= self._motion.end - ON_TIME
        nao.joints.set_stiffness(self.columns, self._motion.sample(self._motion.end if done else time - self.begin))
        return done


def through(
    joints: Sequence[str],
    times: Sequence[Floats],
    keys: Sequence[Floats],
    start: Floats,
    kind: Literal["smooth", "linear", "bezier"] = "smooth",
    handles: Sequence[Floats] | None = None,
) -> Motion:
    """Return the motion from `start` (n,) through n lists of keys (k,) at times > 0 [s], with handles (k + 1, 2, 2)."""
    with_start = [np.concatenate([[first], row]) for first, row in zip(start, keys, strict=True)]
    return Motion([np.concatenate([[0.0], row]) for row in times], joints, with_start, kind, handles)
