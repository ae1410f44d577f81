"""ALMotion's locomotion: where a walk goes next, the motion task of the walk, and the methods."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from itertools import accumulate
from typing import TYPE_CHECKING, Any

import numpy as np

from nao_kin._core.arrays import Floats, as_floats
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument
from nao_kin.naoqi.names import joint_names
from nao_kin.naoqi.spaces import position6d, robot_frame
from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual.engine import TICK, Call, Task
from nao_kin.naoqi.virtual.service import Service, formerly
from nao_kin.naoqi.virtual.steps import (
    Gait,
    Step,
    between,
    body_beside,
    bounded,
    composed,
    first_side,
    gait_of,
    move_config,
    next_step,
    other,
    ready_motion,
    seen_from,
    stands_beside,
    step_motion,
    turned_by,
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

    def begin(self, body: Floats) -> None:  # noqa: B027
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
        self._closes, self._stopped = bool(targets), False
        self.arrived = False if targets else None

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

    Attributes:
        steps: those that are left.
    """

    def __init__(self, steps: Sequence[tuple[str, Floats, float]], gait: Gait) -> None:
        self.steps, self._gait = list(steps), gait

    def step(self, walker: Walker) -> Step | None:
        """The next of them."""
        if not self.steps:
            return None
        side, wanted, period = self.steps.pop(0)
        gait, support = self._gait.of(side), walker.feet[other(side)]
        end = composed(support, bounded(wanted, side, gait))
        walker.body, walker.side = body_beside(end, side), other(side)
        return Step(side, support.copy(), walker.feet[side].copy(), end, gait.step_height, max(period, gait.period))

    def stop(self) -> None:
        """Make no more steps."""
        self.steps = []


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
        self.over = False
        self.step: Step | None = None
        self.walker: Walker | None = None

    def start(self, nao: VirtualNao, time: float) -> None:
        """Bring the torso over the feet.

        Raises:
            BadArgument: the robot does not stand on its feet, or so that it cannot walk.
        """
        nao.base.check_stands()
        self._columns = nao.joints.columns(joint_names(nao.robot, "Legs"))
        nao.joints.note_limp(self._columns, self.notes)
        q = nao.joints.q(sensor=False)
        self.plan.begin(body_of(nao, q))
        self._motion = ready_motion(nao.robot, feet_of(nao, q), nao.base.torso(q), q)

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
            plan.begin(self.walker.body if self.walker else body_of(nao, nao.joints.q(sensor=False)))
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
        if self.walker is None:
            self.walker = Walker(feet, body_of(nao, q))
        self.walker.feet = feet
        self.step = self.plan.step(self.walker)
        if self.step is None:
            return False
        self.keeps_feet = True
        nao.base.stand_on(_FEET[other(self.step.side)], q)
        self._motion, self._at = step_motion(nao.robot, self.step, q), 0
        return True

    def end(self, nao: VirtualNao, *, killed: bool) -> None:
        """Note that the walk is over: its call ends a moment later."""
        self.over = True
        self._limp = self.started is not None and bool((nao.joints.stiffness[self._columns] == 0.0).any())
        self.value = self._answer(self._first)

    def _answer(self, plan: Plan) -> bool | None:
        """What the call that gave a plan answers: whether the robot is where it was to go."""
        return None if plan.arrived is None else plan.arrived and not self._limp

    @property
    def step_time(self) -> float:
        """How long the step that is made takes [s]."""
        return len(self._motion) * TICK


def feet_of(nao: VirtualNao, q: Floats) -> dict[str, Floats]:
    """Where the feet are on the floor, by "L" and "R", shape (3,)."""
    T_world_feet = nao.base.torso(q) @ nao.robot.fk(q, list(_FEET.values()))
    return dict(zip(_FEET, position6d(T_world_feet)[:, _PLACE], strict=True))


def body_of(nao: VirtualNao, q: Floats) -> Floats:
    """FRAME_ROBOT in the world on the floor, shape (3,)."""
    return position6d(robot_frame(nao.robot, q, torso_in_world=nao.base.torso(q)))[_PLACE]


# --- The methods.

_ARMS = ("LArm", "RArm")
# The distance between the feet side by side, which MaxStepY is counted from [m].
_STANCE = 0.1
# How far a target may be [m], and how long a step may take [s].
_FARTHEST, _LONGEST_STEP = 1000.0, 60.0


@formerly(
    walkInit="moveInit",
    walkTo="moveTo",
    stopWalk="stopMove",
    killWalk="killMove",
    waitUntilWalkIsFinished="waitUntilMoveIsFinished",
    walkIsActive="moveIsActive",
    setWalkArmsEnabled="setMoveArmsEnabled",
)
class Locomotion(Service):
    """The methods of ALMotion that walk.

    The walk is kinematic: one foot stands, the other is lifted along a smooth arc and put down, the torso is level and
    between them, and the legs follow by their closed form. There is no balance and no sway, and the arms do not swing.

    - Steps are those of the move configuration, [[name, value], …] of getMoveConfig: MaxStepX, MaxStepY, MaxStepTheta,
      MaxStepFrequency and StepHeight; with "Left" or "Right" before the name of one foot. TorsoWx and TorsoWy are kept
      and not walked with. A step lasts 0.42 s at frequency 1 and 0.6 s at 0, and longer where joints would be too fast.
    - Feet step outwards: of sideways and turning motion every second step only closes up, as the one motor of both
      hips and the feet themselves demand.
    - A path is straight, turning evenly. The robot ends with its feet side by side, FRAME_ROBOT at the target.
    - A walk that is under way takes a new command over after the step it makes; whoever waits for the first one waits
      until the robot stands.
    """

    _walk: Walk | None = None
    _arms = (True, True)

    def kernels_for(self, name: str, given: tuple[Any, ...]) -> frozenset[str]:
        """Both legs follow the walk."""
        walks = name.startswith(("move", "walk", "setFootSteps", "setWalkTarget")) and not name.endswith("Active")
        return super().kernels_for(name, given) | (frozenset({"both legs"}) if walks else frozenset())

    # --- walking --------------------------------------------------------------------------------------------------

    def moveInit(self) -> Call:
        """Bring the torso over the feet, level and at walking height; returns when it is there."""
        return self._start("moveInit", ToTargets([], Gait()))

    def moveTo(self, x: Any, y: Any = None, theta: Any = None, moveConfig: Any = None) -> Call:
        """Walk to a pose relative to where the robot is; returns when it stands.

        True where it arrived; False where the walk was stopped or killed, another command took it over, or a leg has no
        stiffness.

        Args:
            x: forwards [m]; or a list of poses [x, y, theta], each relative to the one before, as Aldebaran's tutorial
                of Dubins curves has them.
            y: to the left [m]; after a list of poses, the move configuration.
            theta: to the left, along the shorter arc [rad].
            moveConfig: the move configuration.
        """
        if arguments.is_list(x):
            targets, config = _poses(x), y
        else:
            targets, config = [_motion(x, y, theta)], moveConfig
        for target in targets:
            if max(abs(target[0]), abs(target[1])) > _FARTHEST:
                place = f"x {target[0]:g} m, y {target[1]:g} m"
                raise BadArgument(f"a target must be at most {_FARTHEST:g} m away along each axis, got {place}")
        return self._start("moveTo", ToTargets(targets, gait_of(config)))

    def move(self, x: Any, y: Any, theta: Any, moveConfig: Any = None) -> None:
        """Walk at a velocity until it is changed or stopped; returns at once.

        Args:
            x: forwards [m/s].
            y: to the left [m/s].
            theta: to the left [rad/s].
            moveConfig: the move configuration.
        """
        self._start("move", AtVelocity(_motion(x, y, theta), gait_of(moveConfig)))

    def moveToward(self, x: Any, y: Any, theta: Any, moveConfig: Any = None) -> None:
        """Walk at a share of the largest velocity; returns at once.

        Args:
            x: from -1, backwards, to 1, forwards.
            y: from -1, to the right, to 1.
            theta: from -1, to the right, to 1.
            moveConfig: the move configuration, in which the frequency may be called "Frequency".
        """
        shares, gait = _motion(x, y, theta, _share), gait_of(moveConfig)
        foot = gait.left
        # Of sideways and turning motion a pair of steps makes one.
        reach = np.array([foot.max_step_x, 0.5 * (foot.max_step_y - _STANCE), 0.5 * foot.max_step_theta])
        self._start("move", AtVelocity(shares * reach / foot.period, gait))

    def stopMove(self) -> Call | bool:
        """Put the feet side by side; returns True when the robot stands."""
        walk = self._under_way()
        if walk is None:
            return True
        walk.plan.stop()
        return walk.follow(lambda: True)

    def killMove(self) -> None:
        """End the walk at once, in the middle of a step."""
        walk = self._under_way()
        if walk is not None:
            self.nao.tasks.kill(walk.id)

    def waitUntilMoveIsFinished(self) -> Call | None:
        """Wait until the robot stands."""
        walk = self._under_way()
        return None if walk is None else walk.follow()

    def moveIsActive(self) -> bool:
        """Whether the robot walks."""
        return self._under_way() is not None

    # --- footsteps ------------------------------------------------------------------------------------------------

    def setFootSteps(self, legName: Any, footSteps: Any, timeList: Any, clearExisting: Any) -> None:
        """Make given steps, and stay as the feet then are; returns at once.

        Args:
            legName: "LLeg" or "RLeg" of each step.
            footSteps: of each, [x, y, theta] of the foot relative to the other one; brought into what a foot can do.
            timeList: when each step is over, from the first one's beginning [s].
            clearExisting: True to forget the steps that are not begun.
        """
        legs, poses = _legs(legName), _poses(footSteps)
        times = as_floats(timeList, (), "timeList")
        if times.shape != (len(legs),) or len(poses) != len(legs):
            counts = f"{len(poses)} and {times.size}"
            raise BadArgument(f"footSteps and timeList must be {len(legs)} as legName, got {counts}")
        durations = np.diff(times, prepend=0.0)
        if (durations <= 0.0).any():
            raise BadArgument("timeList must ascend, from above 0 s")
        self._make_steps("setFootSteps", legs, poses, durations, clearExisting)

    def setFootStepsWithSpeed(self, legName: Any, footSteps: Any, fractionMaxSpeed: Any, clearExisting: Any) -> Call:
        """Make given steps, each at a fraction of the highest frequency; returns when they are made.

        Args:
            legName: "LLeg" or "RLeg" of each step.
            footSteps: as for setFootSteps.
            fractionMaxSpeed: of each step, above 0, at most 1.
            clearExisting: True to forget the steps that are not begun.
        """
        legs, poses = _legs(legName), _poses(footSteps)
        shares = arguments.one_each(fractionMaxSpeed, legs, "fractionMaxSpeed")
        if len(poses) != len(legs):
            raise BadArgument(f"footSteps must be {len(legs)} as legName, got {len(poses)}")
        for share in shares:
            arguments.fraction(float(share), "fractionMaxSpeed", positive=True)
        durations = Gait().left.period / shares
        return self._make_steps("setFootStepsWithSpeed", legs, poses, durations, clearExisting)

    def getFootSteps(self) -> list[list[Any]]:
        """Where the feet are in the world, the step that is made, and those that come after it.

        A step is [leg, duration, [x, y, theta] of the foot relative to the other one] [s, m, rad]. Only setFootSteps
        and setFootStepsWithSpeed know more than one step ahead.
        """
        feet, walk = feet_of(self.nao, self.nao.joints.q()), self._under_way()
        made, coming = [], []
        if walk is not None and walk.step is not None:
            made = [(walk.step.side, seen_from(walk.step.support, walk.step.end), walk.step_time)]
        if walk is not None and isinstance(walk.plan, ByFootsteps):
            coming = walk.plan.steps
        lists = [[[_FEET[side], float(time), pose.tolist()] for side, pose, time in steps] for steps in (made, coming)]
        return [[feet["L"].tolist(), feet["R"].tolist()], *lists]

    # --- where the robot is ---------------------------------------------------------------------------------------

    def getRobotPosition(self, useSensors: Any) -> list[float]:
        """FRAME_ROBOT in FRAME_WORLD: [x, y, theta] [m, rad].

        Args:
            useSensors: True for where the joints are, False for what they are commanded.
        """
        return _pose(body_of(self.nao, self.nao.joints.q(sensor=arguments.flag(useSensors, "useSensors"))))

    def getNextRobotPosition(self) -> list[float]:
        """Where FRAME_ROBOT will be after the step that is made."""
        walk = self._under_way()
        if walk is None or walk.step is None:
            return _pose(body_of(self.nao, self.nao.joints.q(sensor=False)))
        return _pose(between(walk.step.support, walk.step.end))

    def getRobotVelocity(self) -> list[float]:
        """Velocity of FRAME_ROBOT in its own axes, the mean of the step that is made: [vx, vy, vtheta] [m/s, rad/s]."""
        walk = self._under_way()
        if walk is None or walk.step is None:
            return [0.0, 0.0, 0.0]
        before, after = (between(walk.step.support, foot) for foot in (walk.step.start, walk.step.end))
        return [float(value) for value in seen_from(before, after) / walk.step_time]

    def getMoveConfig(self, config: Any) -> list[list[Any]]:
        """The move configuration: "Default", "Min" or "Max"."""
        return move_config(arguments.text(config, "config"))

    # --- arms -----------------------------------------------------------------------------------------------------

    def setMoveArmsEnabled(self, leftArmEnabled: Any, rightArmEnabled: Any) -> None:
        """Kept; the arms do not swing here."""
        left = arguments.flag(leftArmEnabled, "leftArmEnabled")
        self._arms = left, arguments.flag(rightArmEnabled, "rightArmEnabled")

    def getMoveArmsEnabled(self, chainName: Any) -> bool:
        """As it was set, of "LArm", "RArm", or both for "Arms"; at first True."""
        arm = arguments.choice(chainName, "chain", (*_ARMS, "Arms"))
        return all(self._arms) if arm == "Arms" else self._arms[_ARMS.index(arm)]

    # --- names before NAOqi 1.14 ----------------------------------------------------------------------------------

    def setWalkTargetVelocity(self, x: Any, y: Any, theta: Any, frequency: Any, moveConfig: Any = None) -> None:
        """As moveToward, with the frequency from 0 to 1."""
        share = arguments.fraction(frequency, "frequency")
        self.moveToward(x, y, theta, [*(moveConfig or []), ["MaxStepFrequency", share]])

    def getWalkArmsEnabled(self) -> list[bool]:
        """Of the left and of the right arm."""
        return list(self._arms)

    # --- inside ---------------------------------------------------------------------------------------------------

    def _under_way(self) -> Walk | None:
        return None if self._walk is None or self._walk.call.done() or self._walk.over else self._walk

    def _start(self, name: str, plan: Plan) -> Call:
        """Walk by a plan, or have the walk that is under way take it over."""
        walk = self._under_way()
        if walk is not None:
            return walk.take_over(self.nao, plan)
        self.nao.base.check_stands()
        self._walk = Walk(name, self.nao, plan)
        return self.nao.start_task(self._walk)

    def _make_steps(
        self, name: str, legs: Sequence[str], poses: Sequence[Floats], durations: Floats, clear: Any
    ) -> Call:
        clears = arguments.flag(clear, "clearExisting")
        if max(durations) > _LONGEST_STEP:
            raise BadArgument(f"a step must take at most {_LONGEST_STEP:g} s, got {max(durations):g} s")
        plan = ByFootsteps(list(zip((leg[0] for leg in legs), poses, durations.tolist(), strict=True)), Gait())
        walk = self._under_way()
        if walk is not None and isinstance(walk.plan, ByFootsteps):
            walk.plan.steps = [*([] if clears else walk.plan.steps), *plan.steps]
            return walk.follow()
        return self._start(name, plan)


def _motion(x: Any, y: Any, theta: Any, read: Callable[[Any, str], float] = arguments.number) -> Floats:
    """x, y and theta, shape (3,)."""
    return np.array([read(x, "x"), read(y, "y"), read(theta, "theta")])


def _share(value: Any, what: str) -> float:
    number = arguments.number(value, what)
    if not -1.0 <= number <= 1.0:
        raise BadArgument(f"{what} must be from -1 to 1, got {number:g}")
    return number


def _poses(value: Any) -> list[Floats]:
    """Poses [x, y, theta], of which there is one at least."""
    found = as_floats(list(value) if isinstance(value, (list, tuple)) else value, (3,), "poses [x, y, theta]")
    if found.ndim != 2 or not len(found):
        raise BadArgument(f"expected a list of poses [x, y, theta], got {quoted(value, 60)}")
    return [np.array(row) for row in found]


def _legs(value: Any) -> tuple[str, ...]:
    names = (value,) if isinstance(value, str) else value
    if not isinstance(names, (list, tuple)) or not names:
        raise BadArgument(f"legName must be LLeg or RLeg of each step, got {quoted(value, 60)}")
    return tuple(arguments.choice(name, "leg", tuple(_FEET.values())) for name in names)


def _pose(place: Floats) -> list[float]:
    return [float(place[0]), float(place[1]), turned_by(float(place[2]))]
