"""ALMotion's whole-body control: the constraints of feet and balance, the tasks that keep them, and the methods."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np

from nao_kin import ik
from nao_kin._core.arrays import LOWER, Floats, join_poses
from nao_kin.errors import BadArgument
from nao_kin.naoqi.conventions import ARMS, FRAME_ROBOT, FRAME_TORSO, LEGS, TORSO, AxisMask, joint_names
from nao_kin.naoqi.virtual.arguments import Duration, Flag, Point, Share, one_of
from nao_kin.naoqi.virtual.cartesian import (
    NOTEWORTHY,
    RADIAN,
    CartesianControl,
    CartesianState,
    EffectorRequest,
    LimbSolution,
    axis_weights,
    hold_still,
)
from nao_kin.naoqi.virtual.engine import TICK, Call
from nao_kin.naoqi.virtual.machine import ON_TIME, Machine, MotionTask
from nao_kin.naoqi.virtual.steps import smooth
from nao_kin.robot import NaoModel
from nao_kin.rotations import exp, log, matrix_from_rpy

# --- The constraints of whole-body control, and joint values that satisfy them.

# Effector → pose (4, 4) or position (3,) in the world, and its weights, as in `nk.ik.whole_body`.
Targets = dict[str, tuple[Floats, Any]]

FootState = Annotated[str, one_of("foot state", ("Fixed", "Plane", "Free"))]
Support = Annotated[str, one_of("support leg", ("Legs", *LEGS))]
_SENSORS = ("FrontLeft", "FrontRight", "RearLeft", "RearRight")
# The weight of a lifted foot that must keep its pose, relative to other targets.
_HELD = 100.0
# The distance of the centre of mass from the edge of the support polygon [m].
_MARGIN = 0.005
# The largest number of times that targets are moved nearer so that joints are not too fast.
_MAX_HALVINGS = 7
# The residual that counts for targets that were moved nearer: metres, and radians times 0.1.
_NOTEWORTHY_IN_BALANCE = 2e-3


@dataclass
class BalanceControl:
    """The constraints of whole-body control."""

    enabled: bool = False
    # "Fixed", "Plane" or "Free".
    feet: dict[str, str] = field(default_factory=lambda: dict.fromkeys(LEGS, "Fixed"))
    support: str | None = None  # "Legs", "LLeg" or "RLeg" below the centre of mass; None for no constraint


class WholeBodyTask(MotionTask):
    """A task of all joints except the hands, with the feet in place and the centre of mass above its support."""

    keeps_feet = True

    def __init__(self, nao: Machine, name: str, balance: BalanceControl) -> None:
        super().__init__(name, joint_names(nao.robot, "Joints"))
        self._robot, self._balance = nao.robot, balance

    def start(self, nao: Machine, time: float) -> None:
        """Note the initial state and the joints without stiffness."""
        super().start(nao, time)
        self._initial = CartesianState(nao)
        # The largest movement of each joint in a tick; infinite for joints that another task takes.
        self._max_step = nao.robot.velocity_limits * TICK

    def command(self, nao: Machine, targets: Targets, missed: str, *, com: Floats | None = None) -> Floats | None:
        """Command joint values for targets that can be reached in this tick, and return them; None as from `solve`.

        Near the limit of the robot's reach, the solution may be far from the current joint values. The distance of the
        targets is then halved until no joint is too fast: joints that come late would let the feet slip.
        """
        q = nao.joints.q(sensor=False)
        T_world_torso = nao.base.torso(q)
        above = com_above(self._robot, q, T_world_torso)
        joints, missing = q, 0.0
        nearer = targets
        for halving in range(_MAX_HALVINGS):
            share = 0.5**halving
            if halving:
                nearer = {
                    name: (_part(T_world_torso @ self._robot.fk(q, name), wanted, share), weights)
                    for name, (wanted, weights) in targets.items()
                }
            solution = self.solve(nearer, q, com=None if com is None else above + share * (com - above))
            if solution is None:
                return None
            # Targets that were moved nearer count as missed.
            missing = max(missing, _NOTEWORTHY_IN_BALANCE) if halving else solution.missing
            if np.all(np.abs(solution.q - q) <= self._max_step):
                joints = solution.q
                break
        if missing > NOTEWORTHY:
            self.notes.once("missed", missed)
        nao.joints.set(self.columns, nao.robot.to_body(joints)[self.columns], self.notes)
        return joints

    def solve(self, targets: Targets, q: Floats, *, com: Floats | None = None) -> LimbSolution | None:
        """Return joint values of the whole robot, near q, shape (nq,); None if no foot stands.

        A foot with a target is not fixed. `com` is the centre of mass on the floor, (2,); None for any above the
        support.
        """
        feet, balance = dict(zip(LEGS, self._initial.T_world_feet, strict=True)), self._balance
        fixed = {foot: T for foot, T in feet.items() if foot not in targets and balance.feet[foot] != "Free"}
        standing = {balance.support: fixed[balance.support]} if com is None and balance.support in fixed else fixed
        if not standing:
            return None
        rows = dict(targets)
        rows |= {foot: (T, (_HELD, RADIAN * _HELD)) for foot, T in fixed.items() if foot not in standing}
        weights = {"torso" if name == TORSO else name: weight for name, (_, weight) in rows.items()}
        torso, _ = rows.pop(TORSO, (None, None))
        supported = com is None and balance.support is not None
        result = ik.whole_body(
            self._robot,
            {name: T for name, (T, _) in rows.items()},
            feet={foot[0]: T for foot, T in standing.items()},
            com="support" if supported else com,
            margin=_MARGIN if supported else 0.0,
            torso=torso,
            weights=weights,
            near=q,
            posture=self._initial.q,
            restarts=0,
        )
        if not np.isfinite(result.q).all():
            return LimbSolution(np.array(q), np.inf)
        errors = [np.hypot(away, RADIAN * turn) for away, turn in result.residuals.values()]
        return LimbSolution(result.q, float(np.linalg.norm(errors)))


def com_above(robot: NaoModel, q: Floats, T_world_torso: Floats) -> Floats:
    """Return the projection of the centre of mass onto the floor, shape (2,) [m]."""
    return np.asarray((T_world_torso[:3, :3] @ robot.com(q) + T_world_torso[:3, 3])[:2])


def _part(now: Floats, wanted: Floats, share: float) -> Floats:
    """Return the pose at a fraction of the path from a pose (4, 4) to a pose or a position (3,)."""
    if wanted.ndim == 1:
        return np.asarray(now[:3, 3] + share * (wanted - now[:3, 3]))
    R = now[:3, :3] @ exp(share * log(now[:3, :3].T @ wanted[:3, :3]))
    return join_poses(R, now[:3, 3] + share * (wanted[:3, 3] - now[:3, 3]))


# --- The motion tasks of whole-body control: to balance, along paths, and effectors held in FRAME_ROBOT.

Held = Annotated[str, one_of("effector", ("Head", *ARMS))]
# The speeds at which targets of held effectors move [m/s, rad/s].
_PLACE_SPEED, _TURN_SPEED = 0.2, 0.8
# The shortest time of a movement at a fraction of the joints' speeds [s].
_MIN_DURATION = 0.1


class GoToBalance(WholeBodyTask):
    """wbGoToBalance: move the centre of mass above `support` in `duration` [s], or longer for a speed `fraction`."""

    def __init__(
        self,
        nao: Machine,
        name: str,
        control: BalanceControl,
        support: str,
        duration: float,
        fraction: float | None = None,
    ) -> None:
        super().__init__(nao, name, BalanceControl(enabled=True))
        self._control, self._feet = control, LEGS if support == "Legs" else (support,)
        self._duration, self._fraction = duration, fraction
        nao.base.check_stands()
        self.value = False

    def start(self, nao: Machine, time: float) -> None:
        """Find the path of the centre of mass, which ends above the middle of the feet's pressure sensors."""
        super().start(nao, time)
        state = self._initial
        sensors = nao.robot.fk(state.q, [f"{foot[0]}Foot/FSR/{sensor}" for foot in self._feet for sensor in _SENSORS])
        self._to = (state.T_world_torso @ sensors)[:, :2, 3].mean(axis=0)
        self._from = com_above(nao.robot, state.q, state.T_world_torso)
        if self._fraction is not None:
            goal = self.solve({}, state.q, com=self._to)
            assert goal is not None
            ways = np.abs(goal.q - state.q) / (self._fraction * nao.robot.velocity_limits)
            # The largest speed of the smooth movement is 15/8 of the mean.
            self._duration = max(self._duration, 1.875 * float(ways.max()))

    def advance(self, nao: Machine, time: float) -> bool:
        """Solve the whole robot for this tick's position of the centre of mass."""
        share = min((time - self.begin) / self._duration, 1.0)
        place = self._from + float(smooth(np.array(share))) * (self._to - self._from)
        q = self.command(nao, {}, "the centre of mass goes as near to its target as it can", com=place)
        assert q is not None
        done = share >= 1.0 - ON_TIME
        if done:
            T_world_torso = nao.base.torso(q)
            away = com_above(nao.robot, q, T_world_torso) - self._to
            stiff = bool((nao.joints.stiffness[self.columns] > 0.0).all())
            heights = (T_world_torso @ nao.robot.fk(q, self._feet))[:, 2, 3]
            for foot, height in zip(self._feet, heights.tolist(), strict=True):
                if height > LOWER:
                    self.notes.once(foot, f"{foot} is {1e3 * height:.1f} mm above the floor: no balance on it")
            self.value = stiff and float(np.linalg.norm(away)) <= NOTEWORTHY and bool((heights <= LOWER).all())
            if self.value:  # the robot stands on these feet, also on one that was "Free"
                self._control.feet.update(dict.fromkeys(self._feet, "Fixed"))
        return done


class WholeBodyPathTask(WholeBodyTask):
    """Effectors follow paths with the whole robot: positionInterpolations."""

    def __init__(self, name: str, nao: Machine, requests: Sequence[EffectorRequest], balance: BalanceControl) -> None:
        super().__init__(nao, name, balance)
        self._requests = tuple(requests)

    def start(self, nao: Machine, time: float) -> None:
        """Begin at the commanded joint values."""
        hold_still(nao, self._requests)
        super().start(nao, time)
        initial = self._initial
        self._paths = [initial.curve(request) for request in self._requests]
        self._end = max(float(path.times[-1]) for path in self._paths)
        # The torso stays where it is if paths are relative to it: it would run away from a target that moves with it.
        self._held: Targets = {}
        if any(request.space == FRAME_TORSO for request in self._requests):
            self._held[TORSO] = initial.T_world_torso, 1.0
        self._axes = {FRAME_TORSO: initial.T_world_torso[:3, :3], FRAME_ROBOT: initial.T_world_robot[:3, :3]}

    def advance(self, nao: Machine, time: float) -> bool:
        """Solve the whole robot for this tick's poses."""
        t = time - self.begin
        targets = dict(self._held)
        for request, path in zip(self._requests, self._paths, strict=True):
            T, mask = path.pose(t), AxisMask.ALL if request.effector == TORSO else request.mask
            T = self._initial.T_world_torso @ T if request.space == FRAME_TORSO else T
            targets[request.effector] = T, (axis_weights(mask), self._axes.get(request.space, np.eye(3)))
        q = self.command(nao, targets, "an effector goes as near to its target as balance and the feet let it")
        if q is None:
            self.notes.once("feet", "no foot stands, so nothing moves (wbFootState sets which feet stay)")
        return t >= self._end - ON_TIME


class EffectorControl(WholeBodyTask):
    """The whole robot holds effectors at their last goals: wbSetEffectorControl.

    Targets move to the `goals` in the world, hand positions (3,) or head rotation (3, 3), at 0.2 m/s and 0.8 rad/s.
    """

    reactive = True

    def __init__(self, nao: Machine, balance: BalanceControl) -> None:
        super().__init__(nao, "wbEnableEffectorControl", balance)
        self.goals: dict[str, Floats] = {}
        self._now: dict[str, Floats] = {}

    def hold(self, nao: Machine, effector: str) -> None:
        """Hold an effector at its current pose."""
        state = CartesianState(nao)
        T_world = state.T_world_torso @ nao.robot.fk(state.q, effector)
        self._now[effector] = self.goals[effector] = T_world[:3, :3] if effector == "Head" else T_world[:3, 3]

    def send(self, nao: Machine, effector: str, target: Floats) -> None:
        """Set the goal of an effector, shape (3,) in FRAME_ROBOT: [x, y, z], or [wx, wy, wz] for the head."""
        T_world_robot = CartesianState(nao).T_world_robot
        if effector == "Head":
            self.goals[effector] = T_world_robot[:3, :3] @ matrix_from_rpy(target)
        else:
            self.goals[effector] = T_world_robot[:3, :3] @ target + T_world_robot[:3, 3]

    def advance(self, nao: Machine, time: float) -> bool:
        """Move the targets towards their goals, and the whole robot with them."""
        targets: Targets = {}
        for effector, goal in self.goals.items():
            now = self._now[effector] = _towards(self._now[effector], goal)
            if effector == "Head":
                targets[effector] = join_poses(now, np.zeros(3)), (0.0, RADIAN)
            else:
                targets[effector] = now, 1.0
        if self.resources:
            self.command(nao, targets, "an effector goes as near to its target as balance lets it")
        return False

    def give_up(self, resources: frozenset[str]) -> None:
        """Leave some joints to another task."""
        super().give_up(resources)
        if self.started is not None:
            self._max_step[[index for index, name in enumerate(self._robot.joint_names) if name in resources]] = np.inf


def _towards(now: Floats, goal: Floats) -> Floats:
    """Return the target after one tick, for a position, shape (3,), or a rotation, shape (3, 3)."""
    is_place = now.ndim == 1
    way = goal - now if is_place else log(now.T @ goal)
    length, step = float(np.linalg.norm(way)), (_PLACE_SPEED if is_place else _TURN_SPEED) * TICK
    if length <= step:
        return goal
    way = (step / length) * way
    return np.asarray(now + way if is_place else now @ exp(way))


# --- The methods.

# The effectors that NAOqi accepts in wbEnableEffectorOptimization.
Optimized = Annotated[str, one_of("effector", ("All", "Arms", "Legs", "Head", *ARMS, *LEGS, "Torso", "Com"))]


class WholeBodyControl(CartesianControl):
    """The methods of ALMotion that move the whole robot, with its feet in place and its balance kept.

    They use `nk.ik.whole_body`: with the balance constraint the centre of mass stays 5 mm inside the support polygon of
    the pressure sensors of the standing feet. The balance is static: nothing has inertia.

    - While whole-body control is on, positionInterpolations and transformInterpolations use it too: all joints except
      the hands help, and a foot that is neither moved nor "Free" stays. All masks work, along the axes of the
      space. In FRAME_TORSO the torso stays, unless the balance moves it.
    - setAngles, angleInterpolation and setPositions move their own joints; the balance does not correct them.
    - "Plane" is treated as "Fixed": a foot does not slide. wbEnableEffectorOptimization has no effect.
    """

    def __init__(self, nao: Machine) -> None:
        super().__init__(nao)
        self.balance = BalanceControl()

    def _path_task(self, name: str, requests: Sequence[EffectorRequest]) -> MotionTask:
        """Return a task of the whole robot if whole-body control is on."""
        if self.balance.enabled:
            return WholeBodyPathTask(name, self.nao, requests, self.balance)
        return super()._path_task(name, requests)

    def wbEnable(self, isEnabled: Flag) -> None:
        """Switch whole-body control on or off; switching it off removes all constraints."""
        if not isEnabled:
            self.nao.tasks.kill(lambda task: isinstance(task, EffectorControl))
            self.balance = BalanceControl()
        self.balance.enabled = isEnabled

    def wbFootState(self, stateName: FootState, supportLeg: Support) -> None:
        """Set the state of a foot: "Fixed", "Plane" or "Free" for "LLeg", "RLeg" or both ("Legs")."""
        for foot in self.balance.feet:
            if supportLeg in (foot, "Legs"):
                self.balance.feet[foot] = stateName

    def wbEnableBalanceConstraint(self, isEnable: Flag, supportLeg: Support) -> None:
        """Keep the centre of mass above "LLeg", "RLeg", or anywhere above both ("Legs"); False ends the constraint."""
        self.balance.support = supportLeg if isEnable else None

    def wbGoToBalance(self, supportLeg: Support, duration: Duration) -> Call:
        """Bring the centre of mass above the middle of "LLeg", "RLeg" or "Legs"; returns whether it got there.

        The robot then stands on these feet: they become "Fixed". A foot in the air does not support the robot.
        """
        return self.nao.tasks.add(GoToBalance(self.nao, "wbGoToBalance", self.balance, supportLeg, duration))

    def wbGoToBalanceWithSpeed(self, supportLeg: Support, fractionMaxSpeed: Share) -> Call:
        """The same as wbGoToBalance, with no joint faster than a fraction of its maximum speed."""
        name = "wbGoToBalanceWithSpeed"
        task = GoToBalance(self.nao, name, self.balance, supportLeg, _MIN_DURATION, fractionMaxSpeed)
        return self.nao.tasks.add(task)

    def wbEnableEffectorControl(self, effectorName: Held, isEnabled: Flag) -> None:
        """Hold "Head", "LArm" or "RArm" with the whole robot, first at its current pose; False releases it.

        It switches whole-body control on.
        """
        control = self.nao.tasks.of(EffectorControl)
        if not isEnabled:
            if control is not None:
                control.goals.pop(effectorName, None)
                if not control.goals:
                    control.call.cancel()
            return
        self.nao.base.check_stands()
        if not self.balance.enabled:
            self.balance.enabled, self.balance.support = True, "Legs"
        if control is None:
            control = EffectorControl(self.nao, self.balance)
            self.nao.tasks.add(control)
        control.hold(self.nao, effectorName)

    def wbSetEffectorControl(self, effectorName: Held, targetCoordinate: Point) -> None:
        """Send a held effector to a target in FRAME_ROBOT; returns immediately.

        The target of an arm is the position of its hand, [x, y, z] [m]; that of the head is its rotation, [wx, wy, wz]
        [rad].
        """
        control = self.nao.tasks.of(EffectorControl)
        if control is None or effectorName not in control.goals:
            raise BadArgument(f"{effectorName} is not held: call wbEnableEffectorControl({effectorName!r}, True) first")
        control.send(self.nao, effectorName, targetCoordinate)

    def wbEnableEffectorOptimization(self, effectorName: Optimized, isActive: Flag) -> None:
        """Accepted without effect: an effector with a distant target moves as near as it can in any case."""
