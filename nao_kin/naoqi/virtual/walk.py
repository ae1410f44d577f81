"""The motion task of the walk."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from itertools import accumulate
from typing import TYPE_CHECKING, Any

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin.errors import BadArgument
from nao_kin.naoqi.names import joint_names
from nao_kin.naoqi.spaces import position6d, robot_frame
from nao_kin.naoqi.virtual.engine import TICK, Call, Task
from nao_kin.naoqi.virtual.steps import (
    Gait,
    Step,
    StepMotion,
    between,
    body_beside,
    bounded,
    composed,
    first_side,
    next_step,
    other,
    ready_motion,
    seen_from,
    stands_beside,
    step_motion,
)

if TYPE_CHECKING:
    from nao_kin.naoqi.virtual.virtual_nao import VirtualNao


# --- Where a walk goes next: to targets, at a velocity, or by given footsteps.

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


# --- The motion task of the walk.

_FEET = {"L": "LLeg", "R": "RLeg"}
_PLACE = [0, 1, 5]


class Walk(Task):
    """A kinematic walk: step after step, the standing foot fixed, the other one lifted, the torso between the feet.

    Nothing balances: the centre of mass does not go over the standing foot, as a real robot's does. Before the first
    step the torso is brought over the feet where they stand.

    Args:
        name: NAOqi's method.
        nao: the virtual NAO.
        plan: where to.
    """

    def __init__(self, name: str, nao: VirtualNao, plan: Plan) -> None:
        super().__init__(name, joint_names(nao.robot, "Legs"))
        self.plan = self._first = plan
        self._limp = False
        self._motion: Floats = np.empty((0, nao.robot.nq))
        self._at = 0
        self._begun = False
        self.over = False
        self.step: Step | None = None
        self.walker = Walker({}, np.zeros(3))

    def start(self, nao: VirtualNao, time: float) -> None:
        """Bring the torso over the feet.

        Raises:
            BadArgument: the robot does not stand on its feet, or so that it cannot walk.
        """
        if nao.base.support is None:
            raise BadArgument("the robot does not stand on its feet; goToPosture takes it there")
        self._columns = nao.joints.columns(joint_names(nao.robot, "Legs"))
        nao.joints.note_limp(self._columns, self.notes)
        q = nao.joints.q(sensor=False)
        self.plan.begin(body_of(nao, q))
        self._take(ready_motion(nao.robot, feet_of(nao, q), nao.base.torso(q), q, TICK))

    def advance(self, nao: VirtualNao, time: float) -> bool:
        """Command the next configuration; with the last of a step, plan the next one from there."""
        if self._at >= len(self._motion) and not self._next(nao, nao.joints.q(sensor=False)):
            return True
        q = self._motion[self._at]
        self._at += 1
        nao.joints.set(self._columns, nao.robot.to_body(q)[self._columns], self.notes)
        return self._at == len(self._motion) and not self._next(nao, q)

    def take_over(self, nao: VirtualNao, plan: Plan) -> Call:
        """Go on with another plan after this step; the call ends with the walk."""
        self.plan = plan
        if self.started is not None:
            plan.begin(self.walker.body if self._begun else body_of(nao, nao.joints.q(sensor=False)))
        return self.follow(lambda: self._answer(plan))

    def follow(self, answer: Callable[[], object] = lambda: None) -> Call:
        """Return a call that ends with the walk, with an answer of that moment; its `cancel` stops the walk."""

        def end(walk: Future[Any]) -> None:
            error = walk.exception()
            if error is None:
                call.finish(answer())
            else:
                call.fail(error)

        call = Call(lambda: self.plan.stop())
        self.call.add_done_callback(end)
        return call

    def _next(self, nao: VirtualNao, q: Floats) -> bool:
        """Plan a step from a configuration; whether there is one."""
        feet = feet_of(nao, q)
        if not self._begun:
            self.walker, self._begun = Walker(feet, body_of(nao, q)), True
        self.walker.feet = feet
        self.step = self.plan.step(self.walker)
        if self.step is None:
            return False
        self.keeps_feet = True
        nao.base.stand_on(_FEET["R" if self.step.side == "L" else "L"], q)
        self._take(step_motion(nao.robot, self.step, q, TICK))
        return True

    def _take(self, motion: StepMotion) -> None:
        if not motion.reached:
            raise BadArgument(f"the legs cannot make this step: {motion.message}")
        self._motion, self._at = motion.q, 0

    def end(self, nao: VirtualNao, *, killed: bool) -> None:
        """Note that the walk is over: its call ends a moment later."""
        self.over = True
        self._limp = self.started is not None and bool((nao.joints.stiffness[self._columns] == 0.0).any())
        self.value = self._answer(self._first)

    def _answer(self, plan: Plan) -> bool | None:
        """What the call that gave a plan answers: whether the robot is where it was to go."""
        return None if plan.arrived is None else plan.arrived and not self._limp

    def step_made(self) -> list[tuple[str, Floats, float]]:
        """The step that is made: its side, where the foot comes down relative to the other one, and its duration."""
        if self.step is None:
            return []
        return [(self.step.side, seen_from(self.step.support, self.step.end), len(self._motion) * TICK)]

    def next_body(self) -> Floats:
        """Where FRAME_ROBOT is after the step that is made, shape (3,)."""
        assert self.step is not None
        return between(self.step.support, self.step.end)

    @property
    def velocity(self) -> Floats:
        """Velocity of FRAME_ROBOT in its own axes, the mean of the step that is made, shape (3,) [m/s, rad/s]."""
        if self.step is None:
            return np.zeros(3)
        before = between(self.step.support, self.step.start)
        return np.asarray(seen_from(before, self.next_body()) / (len(self._motion) * TICK))


def feet_of(nao: VirtualNao, q: Floats) -> dict[str, Floats]:
    """Where the feet are on the floor, by "L" and "R", shape (3,)."""
    T_world_feet = nao.base.torso(q) @ nao.robot.fk(q, list(_FEET.values()))
    return dict(zip(_FEET, position6d(T_world_feet)[:, _PLACE], strict=True))


def body_of(nao: VirtualNao, q: Floats) -> Floats:
    """FRAME_ROBOT in the world on the floor, shape (3,)."""
    return position6d(robot_frame(nao.robot, q, torso_in_world=nao.base.torso(q)))[_PLACE]
