"""The motion task of the walk."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from typing import TYPE_CHECKING, Any

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.errors import BadArgument
from nao_kin.naoqi.names import joint_names
from nao_kin.naoqi.poses import position6d
from nao_kin.naoqi.spaces import robot_frame
from nao_kin.naoqi.virtual.calls import Call
from nao_kin.naoqi.virtual.clock import TICK
from nao_kin.naoqi.virtual.tasks import Task
from nao_kin.naoqi.virtual.walk.footsteps import Step, between, seen_from
from nao_kin.naoqi.virtual.walk.plans import Plan, Walker
from nao_kin.naoqi.virtual.walk.stepping import StepMotion, ready_motion, step_motion

if TYPE_CHECKING:
    from nao_kin.naoqi.virtual.virtual_nao import VirtualNao

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
