"""ALMotion's locomotion: walks to targets, at velocities and by footsteps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats, as_floats
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument
from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual.engine import Call
from nao_kin.naoqi.virtual.service import Service, formerly, method
from nao_kin.naoqi.virtual.steps import Gait, gait_of, move_config, turned_by
from nao_kin.naoqi.virtual.walk import AtVelocity, ByFootsteps, Plan, ToTargets, Walk, body_of, feet_of

_ARMS = ("LArm", "RArm")
_FEET = {"LLeg": "L", "RLeg": "R"}
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

    @method
    def moveInit(self) -> Call:
        """Bring the torso over the feet, level and at walking height; returns when it is there."""
        return self._start("moveInit", ToTargets([], Gait()))

    @method
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
        if isinstance(x, (list, tuple, np.ndarray)):
            targets = _poses(x)
            _check_near(targets)
            return self._start("moveTo", ToTargets(targets, gait_of([] if y is None else y)))
        target = np.array([arguments.number(v, name) for v, name in ((x, "x"), (y, "y"), (theta, "theta"))])
        _check_near([target])
        return self._start("moveTo", ToTargets([target], gait_of([] if moveConfig is None else moveConfig)))

    @method
    def move(self, x: Any, y: Any, theta: Any, moveConfig: Any = None) -> None:
        """Walk at a velocity until it is changed or stopped; returns at once.

        Args:
            x: forwards [m/s].
            y: to the left [m/s].
            theta: to the left [rad/s].
            moveConfig: the move configuration.
        """
        velocity = np.array([arguments.number(v, name) for v, name in ((x, "x"), (y, "y"), (theta, "theta"))])
        self._start("move", AtVelocity(velocity, gait_of([] if moveConfig is None else moveConfig)))

    @method
    def moveToward(self, x: Any, y: Any, theta: Any, moveConfig: Any = None) -> None:
        """Walk at a share of the largest velocity; returns at once.

        Args:
            x: from -1, backwards, to 1, forwards.
            y: from -1, to the right, to 1.
            theta: from -1, to the right, to 1.
            moveConfig: the move configuration, in which the frequency may be called "Frequency".
        """
        shares = np.array([_share(v, name) for v, name in ((x, "x"), (y, "y"), (theta, "theta"))])
        gait = gait_of([] if moveConfig is None else moveConfig)
        foot = gait.left
        # Of sideways and turning motion a pair of steps makes one.
        reach = np.array([foot.max_step_x, 0.5 * (foot.max_step_y - _STANCE), 0.5 * foot.max_step_theta])
        self._start("move", AtVelocity(shares * reach / foot.period, gait))

    @method
    def stopMove(self) -> Call:
        """Put the feet side by side; returns True when the robot stands."""
        walk = self._under_way()
        if walk is None:
            return _done(True)
        walk.plan.stop()
        return walk.follow(lambda: True)

    @method
    def killMove(self) -> None:
        """End the walk at once, in the middle of a step."""
        walk = self._under_way()
        if walk is not None:
            self.nao.tasks.kill(walk.id)

    @method
    def waitUntilMoveIsFinished(self) -> Call:
        """Wait until the robot stands."""
        walk = self._under_way()
        return _done() if walk is None else walk.follow()

    @method
    def moveIsActive(self) -> bool:
        """Whether the robot walks."""
        return self._under_way() is not None

    # --- footsteps ------------------------------------------------------------------------------------------------

    @method
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

    @method
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

    @method
    def getFootSteps(self) -> list[list[Any]]:
        """Where the feet are in the world, the step that is made, and those that come after it.

        A step is [leg, duration, [x, y, theta] of the foot relative to the other one] [s, m, rad]. Only setFootSteps
        and setFootStepsWithSpeed know more than one step ahead.
        """
        feet = feet_of(self.nao, self.nao.joints.q())
        names = {side: leg for leg, side in _FEET.items()}
        walk = self._under_way()
        made = [] if walk is None else walk.step_made()
        coming = walk.plan.coming if walk is not None and isinstance(walk.plan, ByFootsteps) else []
        lists = [[[names[side], float(time), _floats(pose)] for side, pose, time in steps] for steps in (made, coming)]
        return [[_floats(feet["L"]), _floats(feet["R"])], *lists]

    # --- where the robot is ---------------------------------------------------------------------------------------

    @method
    def getRobotPosition(self, useSensors: Any) -> list[float]:
        """FRAME_ROBOT in FRAME_WORLD: [x, y, theta] [m, rad].

        Args:
            useSensors: True for where the joints are, False for what they are commanded.
        """
        return _pose(body_of(self.nao, self.nao.joints.q(sensor=arguments.flag(useSensors, "useSensors"))))

    @method
    def getNextRobotPosition(self) -> list[float]:
        """Where FRAME_ROBOT will be after the step that is made."""
        walk = self._under_way()
        if walk is None or walk.step is None:
            return _pose(body_of(self.nao, self.nao.joints.q(sensor=False)))
        return _pose(walk.next_body())

    @method
    def getRobotVelocity(self) -> list[float]:
        """Velocity of FRAME_ROBOT in its own axes, the mean of the step that is made: [vx, vy, vtheta] [m/s, rad/s]."""
        walk = self._under_way()
        return [0.0, 0.0, 0.0] if walk is None else _floats(walk.velocity)

    @method
    def getMoveConfig(self, config: Any) -> list[list[Any]]:
        """The move configuration: "Default", "Min" or "Max"."""
        return move_config(arguments.text(config, "config"))

    # --- arms -----------------------------------------------------------------------------------------------------

    @method
    def setMoveArmsEnabled(self, leftArmEnabled: Any, rightArmEnabled: Any) -> None:
        """Kept; the arms do not swing here."""
        left = arguments.flag(leftArmEnabled, "leftArmEnabled")
        self._arms = left, arguments.flag(rightArmEnabled, "rightArmEnabled")

    @method
    def getMoveArmsEnabled(self, chainName: Any) -> bool:
        """As it was set, of "LArm", "RArm", or both for "Arms"; at first True."""
        arm = arguments.choice(chainName, "chain", (*_ARMS, "Arms"))
        return all(self._arms) if arm == "Arms" else self._arms[_ARMS.index(arm)]

    # --- names before NAOqi 1.14 ----------------------------------------------------------------------------------

    @method
    def setWalkTargetVelocity(self, x: Any, y: Any, theta: Any, frequency: Any, moveConfig: Any = None) -> None:
        """As moveToward, with the frequency from 0 to 1."""
        share = arguments.fraction(frequency, "frequency")
        pairs = list(moveConfig or [])
        self.moveToward(x, y, theta, [*pairs, ["MaxStepFrequency", share]])

    @method
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
        if self.nao.base.support is None:
            raise BadArgument("the robot does not stand on its feet; goToPosture takes it there")
        self._walk = Walk(name, self.nao, plan)
        return self.nao.start_task(self._walk)

    def _make_steps(
        self, name: str, legs: Sequence[str], poses: Sequence[Floats], durations: Floats, clear: Any
    ) -> Call:
        clears = arguments.flag(clear, "clearExisting")
        if max(durations) > _LONGEST_STEP:
            raise BadArgument(f"a step must take at most {_LONGEST_STEP:g} s, got {max(durations):g} s")
        sides = [_FEET[leg] for leg in legs]
        plan = ByFootsteps(list(zip(sides, poses, durations.tolist(), strict=True)), Gait())
        walk = self._under_way()
        if walk is not None and isinstance(walk.plan, ByFootsteps):
            walk.plan.add(plan, clear=clears)
            return walk.follow()
        return self._start(name, plan)


def _done(answer: object = None) -> Call:
    call = Call()
    call.finish(answer)
    return call


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


def _check_near(targets: Sequence[Floats]) -> None:
    for target in targets:
        if max(abs(target[0]), abs(target[1])) > _FARTHEST:
            place = f"x {target[0]:g} m, y {target[1]:g} m"
            raise BadArgument(f"a target must be at most {_FARTHEST:g} m away along each axis, got {place}")


def _legs(value: Any) -> tuple[str, ...]:
    names = (value,) if isinstance(value, str) else value
    if not isinstance(names, (list, tuple)) or not names:
        raise BadArgument(f"legName must be LLeg or RLeg of each step, got {quoted(value, 60)}")
    return tuple(arguments.choice(name, "leg", tuple(_FEET)) for name in names)


def _pose(place: Floats) -> list[float]:
    return [float(place[0]), float(place[1]), turned_by(float(place[2]))]


def _floats(values: Floats) -> list[float]:
    return [float(value) for value in values]
