"""ALMotion's whole-body control: to go to balance, to hold effectors, and the methods."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin.errors import BadArgument
from nao_kin.naoqi.conventions import ARMS, FRAME_WORLD, LEGS, AxisMask
from nao_kin.naoqi.virtual.arguments import Duration, Flag, Point, one_of
from nao_kin.naoqi.virtual.cartesian import (
    NOTEWORTHY,
    BalanceControl,
    CartesianControl,
    CartesianState,
    EffectorRequest,
    PathTask,
    Target,
    axis_weights,
    com_above,
    part_of_way,
)
from nao_kin.naoqi.virtual.engine import TICK, Call
from nao_kin.naoqi.virtual.machine import ON_TIME, Machine
from nao_kin.naoqi.virtual.steps import smooth
from nao_kin.rotations import log, matrix_from_rpy

# --- The motion tasks: the centre of mass goes above a support, and effectors are held.

FootState = Annotated[str, one_of("foot state", ("Fixed", "Plane", "Free"))]
Support = Annotated[str, one_of("support leg", ("Legs", *LEGS))]
Held = Annotated[str, one_of("effector", ("Head", *ARMS))]
_SENSORS = ("FrontLeft", "FrontRight", "RearLeft", "RearRight")
# The speeds at which targets of held effectors move [m/s, rad/s].
_PLACE_SPEED, _TURN_SPEED = 0.2, 0.8


class GoToBalance(PathTask):
    """wbGoToBalance: move the centre of mass above `support` in `duration` [s]."""

    def __init__(self, nao: Machine, control: BalanceControl, support: str, duration: float) -> None:
        super().__init__("wbGoToBalance", nao, (), BalanceControl(enabled=True))
        self._control, self._feet = control, LEGS if support == "Legs" else (support,)
        self._duration = duration
        nao.base.check_stands()
        self.value = False

    def start(self, nao: Machine, time: float) -> None:
        """Find the path of the centre of mass, which ends above the middle of the feet's pressure sensors."""
        super().start(nao, time)
        state = self.initial
        sensors = nao.robot.fk(state.q, [f"{foot[0]}Foot/FSR/{sensor}" for foot in self._feet for sensor in _SENSORS])
        self._to = (state.T_world_torso @ sensors)[:, :2, 3].mean(axis=0)
        self._from = com_above(nao.robot, state.q, state.T_world_torso)
        self._end = self._duration

    def solve(self, nao: Machine, time: float, q: Floats) -> tuple[Floats, list[str]]:
        """Return joint values for the position of the centre of mass at a time; at the end, set the result."""
        share = min(time / self._duration, 1.0)
        place = self._from + float(smooth(np.array(share))) * (self._to - self._from)
        q, missed = self.stand(nao, {}, q, place)
        if time >= self._end - ON_TIME:
            away = com_above(nao.robot, q, nao.base.torso(q)) - self._to
            stiff = bool((nao.joints.stiffness[self.columns] > 0.0).all())
            down = [foot for foot in self._feet if nao.base.is_down(foot, q)]
            for foot in [foot for foot in self._feet if foot not in down]:
                self.notes.once(foot, f"{foot} is above the floor: no balance on it")
            self.value = stiff and float(np.linalg.norm(away)) <= NOTEWORTHY and len(down) == len(self._feet)
            if self.value:  # the robot stands on these feet, also on one that was "Free"
                self._control.feet.update(dict.fromkeys(self._feet, "Fixed"))
        return q, missed


class EffectorControl(PathTask):
    """The whole robot holds effectors at their last goals: wbSetEffectorControl.

    Targets move to the goals at 0.2 m/s and 0.8 rad/s.
    """

    reactive = True

    def __init__(self, nao: Machine, balance: BalanceControl) -> None:
        super().__init__("wbEnableEffectorControl", nao, (), balance)
        self._now: dict[str, Floats] = {}  # the moving targets, T_world_effector

    def start(self, nao: Machine, time: float) -> None:
        """Begin to hold, without an end."""
        super().start(nao, time)
        self._end = np.inf

    def hold(self, nao: Machine, effector: str) -> None:
        """Hold an effector at its current pose."""
        state = CartesianState(nao)
        T = self._now[effector] = state.T_world_torso @ nao.robot.fk(state.q, effector)
        mask = AxisMask.ROT if effector == "Head" else AxisMask.VEL
        self.requests[effector] = EffectorRequest(effector, FRAME_WORLD, mask, T[None], np.ones(1), False)

    def send(self, nao: Machine, effector: str, target: Floats) -> None:
        """Set the goal of an effector, shape (3,) in FRAME_ROBOT: [x, y, z], or [wx, wy, wz] for the head."""
        T_world_robot, goal = CartesianState(nao).T_world_robot, self._now[effector].copy()
        if effector == "Head":
            goal[:3, :3] = T_world_robot[:3, :3] @ matrix_from_rpy(target)
        else:
            goal[:3, 3] = T_world_robot[:3, :3] @ target + T_world_robot[:3, 3]
        self.requests[effector] = replace(self.requests[effector], poses=goal[None])

    def release(self, effector: str) -> None:
        """Hold an effector no longer; end with the last one."""
        self.requests.pop(effector, None)
        if not self.requests:
            self.call.cancel()

    def _target(self, effector: str, time: float, T_world_torso: Floats) -> Target:
        """Return the target of an effector after one tick more."""
        now, (goal,) = self._now[effector], self.requests[effector].poses
        turn, way = (float(np.linalg.norm(v)) for v in (log(now[:3, :3].T @ goal[:3, :3]), goal[:3, 3] - now[:3, 3]))
        ticks = max(1.0, way / (_PLACE_SPEED * TICK), turn / (_TURN_SPEED * TICK))
        T = self._now[effector] = part_of_way(now, goal, 1.0 / ticks)
        return T, (axis_weights(self.requests[effector].mask), np.eye(3))


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
        return self.nao.tasks.add(GoToBalance(self.nao, self.balance, supportLeg, duration))

    def wbEnableEffectorControl(self, effectorName: Held, isEnabled: Flag) -> None:
        """Hold "Head", "LArm" or "RArm" with the whole robot, first at its current pose; False releases it.

        It switches whole-body control on.
        """
        control = self.nao.tasks.of(EffectorControl)
        if not isEnabled:
            if control is not None:
                control.release(effectorName)
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
        if control is None or effectorName not in control.requests:
            raise BadArgument(f"{effectorName} is not held: call wbEnableEffectorControl({effectorName!r}, True) first")
        control.send(self.nao, effectorName, targetCoordinate)

    def wbEnableEffectorOptimization(self, effectorName: Optimized, isActive: Flag) -> None:
        """Accepted without effect: an effector with a distant target moves as near as it can in any case."""
