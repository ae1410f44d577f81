"""Where a walk goes next: to targets, at a velocity, or by given footsteps."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.naoqi.virtual.walk.footsteps import (
    Step,
    body_beside,
    bounded,
    composed,
    first_side,
    next_step,
    other,
    seen_from,
    stands_beside,
)
from nao_kin.naoqi.virtual.walk.gait import Gait

_THERE = 1e-9


@dataclass(eq=False)
class Walker:
    """Where a walking robot is; poses on the floor, shape (3,).

    Attributes:
        feet: by "L" and "R".
        body: the pose that the next step starts from.
        side: the foot that moves next; None where any may.
    """

    feet: dict[str, Floats]
    body: Floats
    side: str | None = None


class Plan(ABC):
    """What steps a walk makes.

    Attributes:
        arrived: whether it was walked to its end; None where it has none.
    """

    arrived: bool | None = None

    @abstractmethod
    def begin(self, body: Floats) -> None:
        """The walk begins, or takes this plan over; FRAME_ROBOT is there on the floor."""

    @abstractmethod
    def step(self, walker: Walker) -> Step | None:
        """The next step, after which `walker.body` and `walker.side` are those of the step after; None at the end."""

    @abstractmethod
    def stop(self) -> None:
        """Put the feet side by side, and end."""


class ToTargets(Plan):
    """Walk to poses one after the other, straight and turning evenly, and stand there with the feet side by side.

    Args:
        targets: poses of shape (3,), the first relative to FRAME_ROBOT at the beginning, each other to the one before.
        gait: of the steps.
    """

    def __init__(self, targets: Sequence[Floats], gait: Gait) -> None:
        self._targets, self._gait = [np.array(target) for target in targets], gait
        self._closes = bool(self._targets)
        if self._targets:
            self.arrived = False
        self._stopped = False

    def begin(self, body: Floats) -> None:
        """Take the targets into the world."""
        self._targets = list(accumulate(self._targets, composed, initial=np.array(body)))[1:]

    def step(self, walker: Walker) -> Step | None:
        """A step towards the first target that is not reached."""
        while self._targets and np.abs(seen_from(walker.body, self._targets[0])).max() < _THERE:
            walker.body = self._targets.pop(0)
        if not self._targets and (not self._closes or stands_beside(walker.feet, walker.body)):
            if self.arrived is not None:
                self.arrived = not self._stopped
            return None
        return _step_to(walker, self._targets[0] if self._targets else walker.body, self._gait)

    def stop(self) -> None:
        """Forget the targets."""
        self._stopped = self._stopped or bool(self._targets)
        self._targets = []


class AtVelocity(Plan):
    """Walk at a velocity until it is stopped.

    Feet step outwards only: of sideways and turning motion, every second step makes up for the one before.

    Args:
        velocity: of the body in its own frame, shape (3,) [m/s, m/s, rad/s].
        gait: of the steps.
    """

    def __init__(self, velocity: Floats, gait: Gait) -> None:
        self._velocity, self._gait = np.array(velocity), gait
        self._stopped = not self._velocity.any()

    def begin(self, body: Floats) -> None:
        """Begin to count where the body should be."""
        self._wanted = np.array(body)

    def step(self, walker: Walker) -> Step | None:
        """A step as far as the body should be after it."""
        if self._stopped:
            return None if stands_beside(walker.feet, walker.body) else _step_to(walker, walker.body, self._gait)
        advance = self._velocity * self._gait.of(walker.side or first_side(self._velocity)).period
        # What could not be made in the last two steps is given up, so that it does not add up.
        late = seen_from(walker.body, self._wanted)
        self._wanted = composed(walker.body, np.clip(late, -np.abs(advance), np.abs(advance)))
        self._wanted = composed(self._wanted, advance)
        return _step_to(walker, self._wanted, self._gait)

    def stop(self) -> None:
        """No further than now."""
        self._stopped = True


class ByFootsteps(Plan):
    """Make given steps, and stay as the feet then are.

    Args:
        steps: of each its side, the pose of the foot relative to the other one, shape (3,), and how long it takes [s].
        gait: what steps may be, and how high they are.
    """

    def __init__(self, steps: Sequence[tuple[str, Floats, float]], gait: Gait) -> None:
        self._steps, self._gait = list(steps), gait

    def begin(self, body: Floats) -> None:
        """Steps are relative to the feet."""

    def add(self, later: ByFootsteps, *, clear: bool) -> None:
        """Add the steps of another plan after these, or in their place."""
        self._steps = [*([] if clear else self._steps), *later._steps]

    @property
    def coming(self) -> list[tuple[str, Floats, float]]:
        """The steps that are left."""
        return list(self._steps)

    def step(self, walker: Walker) -> Step | None:
        """The next of them."""
        if not self._steps:
            return None
        side, wanted, period = self._steps.pop(0)
        gait, support = self._gait.of(side), walker.feet[other(side)]
        end = composed(support, bounded(wanted, side, gait))
        walker.body, walker.side = body_beside(end, side), other(side)
        return Step(side, support.copy(), walker.feet[side].copy(), end, gait.step_height, max(period, gait.period))

    def stop(self) -> None:
        """Make no more steps."""
        self._steps = []


def _step_to(walker: Walker, goal: Floats, gait: Gait) -> Step:
    side = walker.side or first_side(seen_from(walker.body, goal))
    step, walker.body = next_step(walker.feet, side, walker.body, goal, gait)
    walker.side = other(side)
    return step
