"""ALMotion's locomotion: the plans of a walk, its motion task, and the methods."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from itertools import accumulate
from typing import Annotated, Any

import numpy as np

from nao_kin._core.arrays import Floats, as_floats
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument
from nao_kin.naoqi.conventions import ARMS, LEGS, joint_names, position6d, robot_frame
from nao_kin.naoqi.virtual import arguments, steps
from nao_kin.naoqi.virtual.arguments import Flag, Fraction, Number, Text
from nao_kin.naoqi.virtual.engine import TICK, Call
from nao_kin.naoqi.virtual.machine import Machine, MotionTask
from nao_kin.naoqi.virtual.service import Service

# --- The plans of a walk: to targets, at a velocity, or by given footsteps.

_THERE = 1e-9


@dataclass(eq=False)
class Walker:
    """The state of a walking robot; poses on the floor, shape (3,)."""

    feet: dict[str, Floats]  # by "L" and "R"
    body: Floats  # the pose at the start of the next step
    side: str | None = None  # the foot that moves next; None for either


class WalkPlan(ABC):
    """The plan of a walk, step by step; `arrived` says whether it was completed, None for a plan without a goal."""

    arrived: bool | None = None

    def begin(self, body: Floats) -> None:  # noqa: B027
        """Begin the walk, or take over a running one, with FRAME_ROBOT at the pose `body` on the floor."""

    @abstractmethod
    def step(self, walker: Walker) -> steps.Footstep | None:
        """Return the next step, and set `walker.body` and `walker.side` for the step after it; None at the end."""

    @abstractmethod
    def stop(self) -> None:
        """Put the feet side by side, and end."""


class ToTargets(WalkPlan):
    """Walk to poses (3,) one after the other, straight and turning evenly, and end with the feet side by side.

    The first target is relative to FRAME_ROBOT at the beginning, every other one to its predecessor.
    """

    def __init__(self, targets: Sequence[Floats], gait: steps.Gait) -> None:
        self._targets, self._gait = [np.array(target) for target in targets], gait
        self._closes, self._stopped = bool(targets), False
        self.arrived = False if targets else None

    def begin(self, body: Floats) -> None:
        """Transform the targets into the world."""
        self._targets = list(accumulate(self._targets, steps.composed, initial=np.array(body)))[1:]

    def step(self, walker: Walker) -> steps.Footstep | None:
        """Return a step towards the first target that is not reached yet."""
        while self._targets and np.abs(steps.seen_from(walker.body, self._targets[0])).max() < _THERE:
            walker.body = self._targets.pop(0)
        if not self._targets and (not self._closes or steps.stands_beside(walker.feet, walker.body)):
            if self.arrived is not None:
                self.arrived = not self._stopped
            return None
        return _step_to(walker, self._targets[0] if self._targets else walker.body, self._gait)

    def stop(self) -> None:
        """Forget the targets."""
        self._stopped = self._stopped or bool(self._targets)
        self._targets = []


class AtVelocity(WalkPlan):
    """Walk at a velocity of the body in its own frame, shape (3,) [m/s, m/s, rad/s], until stopped."""

    def __init__(self, velocity: Floats, gait: steps.Gait) -> None:
        self._velocity, self._gait = np.array(velocity), gait
        self._stopped = not self._velocity.any()

    def begin(self, body: Floats) -> None:
        """Begin the body's moving target at the body's pose."""
        self._target = np.array(body)

    def step(self, walker: Walker) -> steps.Footstep | None:
        """Return a step towards the place of the body's moving target at the end of the step."""
        if self._stopped:
            return None if steps.stands_beside(walker.feet, walker.body) else _step_to(walker, walker.body, self._gait)
        side = walker.side or steps.first_side(self._velocity)
        advance = steps.arc(self._velocity * steps.period(self._gait[side]))
        # A delay of more than one step is dropped, so that it does not accumulate.
        late = np.clip(steps.seen_from(walker.body, self._target), -np.abs(advance), np.abs(advance))
        self._target = steps.composed(steps.composed(walker.body, late), advance)
        return _step_to(walker, self._target, self._gait)

    def stop(self) -> None:
        """End the walk when the feet are side by side."""
        self._stopped = True


class ByFootsteps(WalkPlan):
    """Make given steps: side, pose relative to the other foot (3,), duration [s]; do not close the feet at the end."""

    def __init__(self, given: Sequence[tuple[str, Floats, float]]) -> None:
        self.steps = list(given)

    def step(self, walker: Walker) -> steps.Footstep | None:
        """Return the next given step."""
        if not self.steps:
            return None
        side, relative, period = self.steps.pop(0)
        support = walker.feet[steps.other(side)]
        end = steps.composed(support, relative)
        walker.body, walker.side = steps.body_beside(end, side), steps.other(side)
        height = steps.DEFAULT["StepHeight"]
        return steps.Footstep(side, support.copy(), walker.feet[side].copy(), end, height, period)

    def stop(self) -> None:
        """Make no more steps."""
        self.steps = []


def _step_to(walker: Walker, goal: Floats, gait: steps.Gait) -> steps.Footstep:
    side = walker.side or steps.first_side(steps.seen_from(walker.body, goal))
    step, walker.body = steps.next_step(walker.feet, side, walker.body, goal, gait)
    walker.side = steps.other(side)
    return step


# --- The motion task of the walk.

_FEET = dict(zip("LR", LEGS, strict=True))
_PLACE = [0, 1, 5]


class Walk(MotionTask):
    """A kinematic walk: in each step, one foot stands, the other is lifted, and the torso moves between the feet."""

    def __init__(self, name: str, nao: Machine, plan: WalkPlan) -> None:
        super().__init__(name, joint_names(nao.robot, "Legs"))
        self.plan = self._first = plan
        self._limp = False
        self.motion: Floats = np.empty((0, nao.robot.nq))
        self._at = 0
        self.step: steps.Footstep | None = None
        self.walker: Walker | None = None

    def start(self, nao: Machine, time: float) -> None:
        """Bring the torso over the feet, or reject a robot that cannot walk from its configuration."""
        nao.base.check_stands()
        super().start(nao, time)
        q = nao.joints.q(sensor=False)
        self.plan.begin(body_of(nao, q))
        self.motion = steps.ready_motion(nao.robot, feet_of(nao, q), q)

    def advance(self, nao: Machine, time: float) -> bool:
        """Command the next configuration; after the last one of a step, plan the next step from there."""
        if self._at >= len(self.motion) and not self._next(nao, nao.joints.q(sensor=False)):
            return True
        q = self.motion[self._at]
        self._at += 1
        nao.joints.set(self.columns, nao.robot.to_body(q)[self.columns], self.notes)
        return self._at == len(self.motion) and not self._next(nao, q)

    def take_over(self, nao: Machine, plan: WalkPlan) -> Call:
        """Continue with another plan after the current step; return a call that ends when the walk ends."""
        self.plan = plan
        if self.started is not None:
            plan.begin(self.walker.body if self.walker else body_of(nao, nao.joints.q(sensor=False)))
        return self.follow(lambda: self._answer(plan))

    def follow(self, answer: Callable[[], object] = lambda: None) -> Call:
        """Return a call that ends with the walk and then returns `answer()`; cancelling it stops the walk."""

        def end(walk: Future[Any]) -> None:
            error = walk.exception()
            if error is None:
                call.finish(answer())
            else:
                call.fail(error)

        call = Call(lambda: self.plan.stop())
        self.call.add_done_callback(end)
        return call

    def _next(self, nao: Machine, q: Floats) -> bool:
        """Plan a step from a configuration; return whether there is one."""
        feet = feet_of(nao, q)
        if self.walker is None:
            self.walker = Walker(feet, body_of(nao, q))
        self.walker.feet = feet
        self.step = self.plan.step(self.walker)
        if self.step is None:
            return False
        self.keeps_feet = True
        nao.base.stand_on(_FEET[steps.other(self.step.side)], q)
        self.motion, self._at = steps.step_motion(nao.robot, self.step, q), 0
        return True

    def end(self, nao: Machine, *, killed: bool) -> None:
        """Set the result of the walk's call, which ends a moment later."""
        self._limp = self.started is not None and bool((nao.joints.stiffness[self.columns] == 0.0).any())
        self.value = self._answer(self._first)

    def _answer(self, plan: WalkPlan) -> bool | None:
        """Return the result of the call that gave a plan: whether the robot reached its goal."""
        return None if plan.arrived is None else plan.arrived and not self._limp


def feet_of(nao: Machine, q: Floats) -> dict[str, Floats]:
    """Return the poses of the feet on the floor, by "L" and "R", shape (3,)."""
    T_world_feet = nao.base.torso(q) @ nao.robot.fk(q, list(_FEET.values()))
    return dict(zip(_FEET, position6d(T_world_feet)[:, _PLACE], strict=True))


def body_of(nao: Machine, q: Floats) -> Floats:
    """Return the pose of FRAME_ROBOT on the floor, shape (3,)."""
    return position6d(robot_frame(nao.robot, q, torso_in_world=nao.base.torso(q)))[_PLACE]


# --- The methods.

SomeArms = Annotated[str, arguments.one_of("chain", (*ARMS, "Arms"))]
# The distance between the feet side by side, from which MaxStepY is measured [m].
_STANCE = 0.1


class Locomotion(Service):
    """The methods of ALMotion that walk kinematically, without balance, sway or swinging arms.

    - Steps follow the move configuration, a list [[name, value], …] as getMoveConfig returns it: MaxStepX, MaxStepY,
      MaxStepTheta, MaxStepFrequency and StepHeight, or for one foot with "Left" or "Right" before the name. TorsoWx and
      TorsoWy have no effect. A step lasts 0.42 s at frequency 1 and 0.6 s at 0, and longer if joints would be too fast.
    - Feet step outwards only, because of the shared hip motor and so that they do not meet: when the robot walks
      sideways or turns, every second step only brings the feet together.
    - A new command takes over a running walk after its current step.
    """

    # --- walking --------------------------------------------------------------------------------------------------

    def moveInit(self) -> Call:
        """Bring the torso over the feet, level and at walking height; returns at the end."""
        return self._start("moveInit", ToTargets([], steps.gait_of([])))

    def moveTo(self, x: Any, y: Any = None, theta: Any = None, moveConfig: Any = None) -> Call:
        """Walk to a pose relative to the robot; returns when it stands.

        x is forwards, y to the left [m], theta to the left along the shorter arc [rad]. Instead, x may be a list of
        poses [x, y, theta], each relative to the one before, as in Aldebaran's tutorial of Dubins curves; y is then the
        move configuration. Returns False if the walk was stopped, killed or taken over, or if a leg has no stiffness.
        """
        if arguments.is_list(x):
            targets, config = _poses(x), y
        else:
            rows = (("x", x), ("y", y), ("theta", theta))
            targets, config = [np.array([arguments.number(value, what) for what, value in rows])], moveConfig
        return self._start("moveTo", ToTargets(targets, self._gait("moveTo", config)))

    def move(self, x: Number, y: Number, theta: Number, moveConfig: Any = None) -> None:
        """Walk at a velocity [m/s, rad/s], positive forwards and to the left, until stopped; returns immediately."""
        self._start("move", AtVelocity(np.array([x, y, theta]), self._gait("move", moveConfig)))

    def moveToward(self, x: Number, y: Number, theta: Number, moveConfig: Any = None) -> None:
        """Walk at a share of the largest velocity, from -1 (backwards, right) to 1 (forwards, left).

        Returns immediately. In the move configuration, the frequency may be called "Frequency".
        """
        shares, gait = np.array([x, y, theta]), self._gait("moveToward", moveConfig)
        for what, share in zip(("x", "y", "theta"), shares.tolist(), strict=True):
            if abs(share) > 1.0:
                raise BadArgument(f"{what} must be from -1 to 1, got {share:g}")
        foot = gait["L"]
        # When the robot walks sideways or turns, every second step only brings the feet together.
        reach = np.array([foot["MaxStepX"], 0.5 * (foot["MaxStepY"] - _STANCE), 0.5 * foot["MaxStepTheta"]])
        self._start("move", AtVelocity(shares * reach / steps.period(foot), gait))

    def stopMove(self) -> Call | bool:
        """Put the feet side by side; returns True when the robot stands."""
        walk = self.nao.tasks.of(Walk)
        if walk is None:
            return True
        walk.plan.stop()
        return walk.follow(lambda: True)

    def killMove(self) -> None:
        """End the walk immediately, even in the middle of a step."""
        self.nao.tasks.kill(lambda task: isinstance(task, Walk))

    def waitUntilMoveIsFinished(self) -> Call | None:
        """Wait until the robot stands."""
        walk = self.nao.tasks.of(Walk)
        return None if walk is None else walk.follow()

    def moveIsActive(self) -> bool:
        """Whether the robot walks."""
        return self.nao.tasks.of(Walk) is not None

    # --- footsteps ------------------------------------------------------------------------------------------------

    def setFootSteps(self, legName: Any, footSteps: Any, timeList: Any, clearExisting: Flag) -> None:
        """Make given steps, and leave the feet as they are at the end; returns immediately.

        For each step, legName has "LLeg" or "RLeg", footSteps the pose [x, y, theta] of the foot relative to the other
        one, and timeList the time of its end, from the beginning of the first step [s]. Poses are clipped to the bounds
        of getMoveConfig("Max"), with 88 mm between the feet and 0.12 rad inwards, and a step lasts at least 0.42 s; the
        log names steps that change. clearExisting discards the steps that have not begun.
        """
        legs, poses = _legs(legName), _poses(footSteps)
        times = as_floats(timeList, (), "timeList")
        if times.shape != (len(legs),) or len(poses) != len(legs):
            counts = f"{len(poses)} and {times.size}"
            raise BadArgument(f"footSteps and timeList must have as many entries as legName, {len(legs)}, got {counts}")
        durations = np.diff(times, prepend=0.0)
        if (durations <= 0.0).any():
            raise BadArgument("timeList must ascend, from a time above 0 s")
        self._make_steps("setFootSteps", legs, poses, durations, clearExisting)

    def setFootStepsWithSpeed(self, legName: Any, footSteps: Any, fractionMaxSpeed: Any, clearExisting: Flag) -> Call:
        """Make given steps, each at a fraction of the highest frequency, above 0; returns at the end.

        Otherwise the same as setFootSteps.
        """
        legs, poses = _legs(legName), _poses(footSteps)
        shares = arguments.one_each(fractionMaxSpeed, legs, "fractionMaxSpeed")
        if len(poses) != len(legs):
            raise BadArgument(f"footSteps must have as many entries as legName, {len(legs)}, got {len(poses)}")
        for share in shares:
            arguments.fraction(float(share), "fractionMaxSpeed", positive=True)
        durations = steps.period(steps.DEFAULT) / shares
        return self._make_steps("setFootStepsWithSpeed", legs, poses, durations, clearExisting)

    def getFootSteps(self) -> list[list[Any]]:
        """The feet in the world, the current step, and the known steps after it.

        A step is [leg, duration, [x, y, theta] of the foot relative to the other one] [s, m, rad]. Later steps are
        known only in a walk of setFootSteps or setFootStepsWithSpeed.
        """
        feet, walk = feet_of(self.nao, self.nao.joints.q()), self.nao.tasks.of(Walk)
        step, duration = self._current_step()
        current = [] if step is None else [(step.side, steps.seen_from(step.support, step.end), duration)]
        coming = walk.plan.steps if walk is not None and isinstance(walk.plan, ByFootsteps) else []
        lists = [[[_FEET[s], float(time), pose.tolist()] for s, pose, time in rows] for rows in (current, coming)]
        return [[feet["L"].tolist(), feet["R"].tolist()], *lists]

    # --- position of the robot ------------------------------------------------------------------------------------

    def getRobotPosition(self, useSensors: Flag) -> list[float]:
        """FRAME_ROBOT in FRAME_WORLD, from the sensors or the commands: [x, y, theta] [m, rad]."""
        return _pose(body_of(self.nao, self.nao.joints.q(sensor=useSensors)))

    def getNextRobotPosition(self) -> list[float]:
        """FRAME_ROBOT in FRAME_WORLD after the current step."""
        step, _ = self._current_step()
        return self.getRobotPosition(False) if step is None else _pose(steps.along(step.support, step.end, 0.5))

    def getRobotVelocity(self) -> list[float]:
        """Mean velocity of FRAME_ROBOT in its own axes during the current step: [vx, vy, vtheta] [m/s, rad/s]."""
        step, duration = self._current_step()
        if step is None:
            return [0.0, 0.0, 0.0]
        before, after = (steps.along(step.support, foot, 0.5) for foot in (step.start, step.end))
        return [float(value) for value in steps.seen_from(before, after) / duration]

    def getMoveConfig(self, config: Text) -> list[list[Any]]:
        """The move configuration: "Default", "Min" or "Max"."""
        return steps.move_config(config)

    # --- arms -----------------------------------------------------------------------------------------------------

    def setMoveArmsEnabled(self, leftArmEnabled: Flag, rightArmEnabled: Flag) -> None:
        """Stored; the arms do not swing here."""
        self.stored |= {"LArm": leftArmEnabled, "RArm": rightArmEnabled}

    def getMoveArmsEnabled(self, chainName: SomeArms) -> bool:
        """The stored value of "LArm" or "RArm", or whether both are enabled for "Arms"; initially True."""
        return all(self.stored.get(arm, True) for arm in ARMS if chainName in (arm, "Arms"))

    # --- names before NAOqi 1.14 ----------------------------------------------------------------------------------

    walkInit, walkTo, stopWalk, killWalk = moveInit, moveTo, stopMove, killMove
    waitUntilWalkIsFinished, walkIsActive = waitUntilMoveIsFinished, moveIsActive
    setWalkArmsEnabled, getFootGaitConfig = setMoveArmsEnabled, getMoveConfig

    def setWalkTargetVelocity(
        self, x: Number, y: Number, theta: Number, frequency: Fraction, left: Any = None, right: Any = None
    ) -> None:
        """The same as moveToward, with the frequency from 0 to 1; one move configuration for both feet, or two."""
        config = list(left or [])
        if right is not None:
            sides = zip(steps.SIDES.values(), (left, right), strict=True)
            config = [[side + name, value] for side, given in sides for name, value in arguments.pairs(given, "config")]
        self.moveToward(x, y, theta, [*config, ["MaxStepFrequency", frequency]])

    def getWalkArmsEnabled(self) -> list[bool]:
        """The stored values of the left and of the right arm."""
        return [self.stored.get(arm, True) for arm in ARMS]

    # --- inside ---------------------------------------------------------------------------------------------------

    def _current_step(self) -> tuple[steps.Footstep | None, float]:
        """Return the current step, None if there is none, and its duration [s]."""
        walk = self.nao.tasks.of(Walk)
        return (None, 0.0) if walk is None else (walk.step, len(walk.motion) * TICK)

    def _gait(self, name: str, config: Any) -> steps.Gait:
        """Return the gait of a move configuration, and log the values that are clipped."""
        return steps.gait_of(config, lambda change: self.nao.log.write(f"{name}: {change}"))

    def _start(self, name: str, plan: WalkPlan) -> Call:
        """Walk by a plan, or continue the current walk by this plan."""
        walk = self.nao.tasks.of(Walk)
        if walk is not None:
            return walk.take_over(self.nao, plan)
        self.nao.base.check_stands()
        return self.nao.tasks.add(Walk(name, self.nao, plan))

    def _make_steps(
        self, name: str, legs: Sequence[str], poses: Sequence[Floats], durations: Floats, clears: bool
    ) -> Call:
        shortest, changed = steps.period(steps.DEFAULT), []
        plan = ByFootsteps([])
        for leg, wanted, duration in zip(legs, poses, durations.tolist(), strict=True):
            made, period = steps.bounded(wanted, leg[0], steps.HIGHEST), max(duration, shortest)
            if not np.allclose(made, wanted, rtol=0.0, atol=_THERE):
                changed.append(f"{leg} {_listed(wanted)} is clipped to {_listed(made)}")
            if period > duration + _THERE:
                changed.append(f"{leg} in {duration:g} s takes {period:g} s")
            plan.steps.append((leg[0], made, period))
        if changed:
            more = f" and {len(changed) - 1} more" if len(changed) > 1 else ""
            self.nao.log.write(f"{name}: {changed[0]}{more}")
        walk = self.nao.tasks.of(Walk)
        if walk is not None and isinstance(walk.plan, ByFootsteps):
            walk.plan.steps = [*([] if clears else walk.plan.steps), *plan.steps]
            return walk.follow()
        return self._start(name, plan)


def _poses(value: Any) -> list[Floats]:
    """Return a list of poses [x, y, theta], at least one."""
    poses = as_floats(list(value) if isinstance(value, (list, tuple)) else value, (3,), "poses [x, y, theta]")
    if poses.ndim != 2 or not len(poses):
        raise BadArgument(f"expected a list of poses [x, y, theta], got {quoted(value, 60)}")
    return [np.array(row) for row in poses]


def _legs(value: Any) -> tuple[str, ...]:
    names = (value,) if isinstance(value, str) else value
    if not isinstance(names, (list, tuple)) or not names:
        raise BadArgument(f"legName must be LLeg or RLeg for each step, got {quoted(value, 60)}")
    return tuple(arguments.choice(name, "leg", tuple(_FEET.values())) for name in names)


def _listed(pose: Floats) -> str:
    return f"[{', '.join(f'{value:g}' for value in pose)}]"


def _pose(place: Floats) -> list[float]:
    return [float(place[0]), float(place[1]), steps.wrapped(float(place[2]))]
