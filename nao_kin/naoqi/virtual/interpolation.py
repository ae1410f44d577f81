"""Tasks that move joints: along keys in time, or towards angles at limited speed."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin.motion import Motion
from nao_kin.naoqi.virtual.arguments import check_duration
from nao_kin.naoqi.virtual.engine import TICK, Task

if TYPE_CHECKING:
    from nao_kin.naoqi.virtual.virtual_nao import VirtualNao


# A motion is sampled for so many ticks at once, which takes little longer than for one.
_TICKS_AHEAD = 64
# A task ends in the tick that misses its end by less, from rounding [s].
ON_TIME = 1e-9


class Interpolation(Task):
    """Joints follow a motion; what angleInterpolation and its relatives do.

    Args:
        name: NAOqi's method.
        joints: which joints, each once.
        plan: makes the motion when the joints are free, from what they are commanded then, shape (joints,). The motion
            has these joints, in this order, and begins at time zero.
    """

    def __init__(self, name: str, joints: Sequence[str], plan: Callable[[Floats], Motion]) -> None:
        super().__init__(name, joints)
        self.joints = tuple(joints)
        self._plan = plan

    def start(self, nao: VirtualNao, time: float) -> None:
        """Make the motion from where the joints are commanded to be."""
        self._columns = nao.joints.columns(self.joints)
        self._motion = self._plan(nao.joints.command[self._columns])
        self._start, self._end = time, self._motion.end
        self._ahead: deque[Floats] = deque()
        extremes = np.array([[row.min() for row in self._motion.keys], [row.max() for row in self._motion.keys]])
        nao.joints.note_outside(self._columns, extremes, self.notes)
        nao.joints.note_limp(self._columns, self.notes)

    def advance(self, nao: VirtualNao, time: float) -> bool:
        """Command what the motion has at this time."""
        t = time - self._start
        if not self._ahead:
            self._ahead.extend(self._motion.sample(t + TICK * np.arange(_TICKS_AHEAD)))
        values, done = self._ahead.popleft(), t >= self._end - ON_TIME
        nao.joints.set(self._columns, self._motion.sample(self._end) if done else values, self.notes)
        return done


class AtSpeed(Interpolation):
    """Joints go straight to targets, and all arrive together; what angleInterpolationWithSpeed does.

    The joint with the longest way goes at its speed: the motion takes max |target − start| / speed.

    Args:
        name: NAOqi's method.
        nao: the virtual NAO.
        joints: which joints, each once.
        targets: where to, shape (joints,).
        fraction: of each joint's maximum speed.
    """

    def __init__(self, name: str, nao: VirtualNao, joints: Sequence[str], targets: Floats, fraction: float) -> None:
        speeds = fraction * nao.joints.max_speed[nao.joints.columns(joints)]

        def plan(start: Floats) -> Motion:
            duration = float(np.max(np.abs(targets - start) / speeds))
            check_duration(duration, "the time to the targets")
            if duration == 0.0:
                return Motion([0.0], joints, targets[None])
            return Motion([0.0, duration], joints, np.stack([start, targets]))

        super().__init__(name, joints, plan)


class HandMove(AtSpeed):
    """A hand opens or closes with full stiffness, and then has none; what openHand and closeHand do."""

    def start(self, nao: VirtualNao, time: float) -> None:
        """Give the hand stiffness now, not before: the task that it waited for may have been a hand's too."""
        nao.joints.set_stiffness(nao.joints.columns(self.joints), 1.0)
        super().start(nao, time)

    def end(self, nao: VirtualNao, *, killed: bool) -> None:
        """Let go of the motor."""
        if self.started is None:
            return
        if killed:
            nao.joints.set_stiffness(self._columns, 0.0)
        else:
            nao.joints.release(self._columns)


class Approach(Task):
    """Joints go to angles, each at its own speed; what setAngles and changeAngles do.

    Args:
        name: NAOqi's method.
        joints: which joints, each once.
        targets: where to, shape (joints,).
        fraction: of each joint's maximum speed.
        relative: the targets are changes of what the joints are commanded when they are free.
    """

    reactive = True

    def __init__(
        self, name: str, joints: Sequence[str], targets: Floats, fraction: float, *, relative: bool = False
    ) -> None:
        super().__init__(name, joints)
        self._joints, self._targets = list(joints), np.array(targets)
        self._fraction, self._relative = fraction, relative

    def start(self, nao: VirtualNao, time: float) -> None:
        """Note where the joints are commanded to be."""
        self._columns = nao.joints.columns(self._joints)
        self._at = nao.joints.command[self._columns]
        if self._relative:
            self._targets = self._at + self._targets
        self._step = self._fraction * nao.joints.max_speed[self._columns] * TICK
        nao.joints.note_outside(self._columns, self._targets[None], self.notes)
        self._targets = np.clip(self._targets, nao.joints.lower[self._columns], nao.joints.upper[self._columns])
        nao.joints.note_limp(self._columns, self.notes)

    def advance(self, nao: VirtualNao, time: float) -> bool:
        """One tick's way towards the targets."""
        missing = self._targets - self._at
        near = np.abs(missing) <= self._step * (1.0 + ON_TIME)
        self._at = np.where(near, self._targets, self._at + np.clip(missing, -self._step, self._step))
        nao.joints.set(self._columns, self._at, self.notes)
        return bool(near.all())

    def give_up(self, resources: frozenset[str]) -> None:
        """Leave some joints to another task."""
        super().give_up(resources)
        kept = [index for index, joint in enumerate(self._joints) if joint not in resources]
        self._joints, self._targets = [self._joints[index] for index in kept], self._targets[kept]
        if self.started is not None:
            self._columns = [self._columns[index] for index in kept]
            self._at, self._step = self._at[kept], self._step[kept]


class StiffnessRamp(Task):
    """Stiffnesses follow a motion, on a straight line from key to key; what stiffnessInterpolation does.

    Args:
        joints: which joints, each once.
        times: of each joint's keys [s].
        keys: its stiffnesses there.
    """

    def __init__(self, joints: Sequence[str], times: Sequence[Floats], keys: Sequence[Floats]) -> None:
        super().__init__("stiffnessInterpolation", [f"{joint}/Stiffness" for joint in joints])
        self._joints, self._times, self._keys = tuple(joints), times, keys

    def start(self, nao: VirtualNao, time: float) -> None:
        """Begin at the stiffnesses of now."""
        self._columns = nao.joints.columns(self._joints)
        self._motion = through(self._joints, self._times, self._keys, nao.joints.stiffness[self._columns], "linear")
        self._start = time

    def advance(self, nao: VirtualNao, time: float) -> bool:
        """Set what the motion has at this time."""
        done = time - self._start >= self._motion.end - ON_TIME
        nao.joints.set_stiffness(self._columns, self._motion.sample(self._motion.end if done else time - self._start))
        return done


def through(
    joints: Sequence[str],
    times: Sequence[Floats],
    keys: Sequence[Floats],
    start: Floats,
    kind: Literal["smooth", "linear", "bezier"] = "smooth",
    handles: Sequence[Floats] | None = None,
) -> Motion:
    """The motion from `start` at time zero through keys, all after time zero.

    Args:
        joints: n names.
        times: n arrays (k,) [s].
        keys: n arrays (k,).
        start: shape (n,).
        kind: "smooth", "linear" or "bezier".
        handles: n arrays (k + 1, 2, 2) for "bezier".
    """
    with_start = [np.concatenate([[first], row]) for first, row in zip(start, keys, strict=True)]
    return Motion([np.concatenate([[0.0], row]) for row in times], joints, with_start, kind, handles)
