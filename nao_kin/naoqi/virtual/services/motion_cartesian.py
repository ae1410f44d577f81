"""ALMotion's Cartesian control: poses of effectors read, set, and interpolated."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats, as_floats
from nao_kin.errors import BadArgument
from nao_kin.naoqi.spaces import pose_in, position6d, space_number, transform_list
from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual import limb_solvers as limbs
from nao_kin.naoqi.virtual.cartesian import (
    PathTask,
    Scene,
    TogetherTask,
    ToPoses,
    Wish,
    hold_still,
    moves_legs,
    needed_joints,
    positions,
    single,
    transforms,
    wishes,
)
from nao_kin.naoqi.virtual.engine import Call
from nao_kin.naoqi.virtual.service import Service, method
from nao_kin.naoqi.virtual.whole_body import (
    FOOT_STATES,
    HELD,
    MASKS,
    SUPPORTS,
    Balance,
    EffectorControl,
    GoToBalance,
    WholePathTask,
)

_NOTEWORTHY = 1e-3


# Compiled kernels of nk.ik that effectors need, by a part of their names.
_KERNELS = {
    "Arm": ("arms by pose", "arms by place"),
    "Torso": ("both legs", "projections onto limits", "damped least squares"),
}


class CartesianControl(Service):
    """The methods of ALMotion that move effectors by poses.

    Effectors are Head, LArm, RArm, LLeg, RLeg and Torso. A position is Position6D (x, y, z, wx, wy, wz), a transform
    its 4 x 4 matrix row by row, 16 numbers or 12. The axis mask says what counts, along the axes of the space: 7 for
    the place, 56 for the rotation, 63 for both.

    - The interpolations go from where the effector is commanded to be: to one target on a straight line, through
      several along a monotone cubic of x, y and z, turning about one axis from key to key; at rest at both ends, at
      each key in time. FRAME_ROBOT is taken where it is at the beginning.
    - setPositions and its relatives find joint values for the target and send the joints there, all arriving together,
      none faster than the fraction of its maximum speed: not on a straight line in space.
    - A relative target adds to the place, and turns about the axes of the space.
    - Torso moves the legs with the feet where they are; its yaw gives way where the one motor of both hips asks for it.
      A leg that is moved takes the other hip with it, as on the robot; in FRAME_WORLD and FRAME_ROBOT the other foot
      stays in place.
    - What is out of reach raises nothing: the effector goes as near as it can, and the log says so.
    """

    def kernels_for(self, name: str, given: tuple[Any, ...]) -> frozenset[str]:
        """Arms go by their closed form where they are set, and the torso by that of both legs."""
        moves = ("setPosition", "setTransform", "changePosition", "changeTransform", "positionInt", "transformInt")
        named = str(given[:1]) if name.startswith(moves) else ""
        needed = {kernel for part, kernels in _KERNELS.items() if part in named for kernel in kernels}
        return super().kernels_for(name, given) | needed

    @method
    def getPosition(self, name: Any, space: Any, useSensorValues: Any) -> list[float]:
        """Position6D of an effector, joint, sensor or camera [m, rad].

        Args:
            name: which.
            space: FRAME_TORSO 0, FRAME_WORLD 1, FRAME_ROBOT 2.
            useSensorValues: True for where the joints are, False for what they are commanded.
        """
        return [float(value) for value in position6d(self._pose(name, space, useSensorValues))]

    @method
    def getTransform(self, name: Any, space: Any, useSensorValues: Any) -> list[float]:
        """The same as a 4 x 4 matrix row by row, 16 numbers."""
        return [float(value) for value in transform_list(self._pose(name, space, useSensorValues))]

    # --- in time --------------------------------------------------------------------------------------------------

    @method
    def positionInterpolations(
        self, effectorNames: Any, space: Any, paths: Any, axisMasks: Any, times: Any, isAbsolute: Any = True
    ) -> Call:
        """Move effectors through positions at times; returns when the last is reached.

        Args:
            effectorNames: an effector, or a list of them.
            space: one for all, or a list of one for each.
            paths: a list of a path for each effector, a path being a list of positions or one position; of a single
                effector also its path alone.
            axisMasks: one for all, or a list of one for each.
            times: of one effector a time or a list of times, of several a list for each or one for all [s].
            isAbsolute: False for changes of where the effectors are at the beginning.
        """
        asked = (effectorNames, space, paths, axisMasks, times)
        return self._follow("positionInterpolations", positions, asked, isAbsolute)

    @method
    def positionInterpolation(
        self, chainName: Any, space: Any, path: Any, axisMask: Any, durations: Any, isAbsolute: Any = True
    ) -> Call:
        """The same for one effector."""
        arguments.text(chainName, "chainName")
        asked = (chainName, space, path, axisMask, durations)
        return self._follow("positionInterpolation", positions, asked, isAbsolute)

    @method
    def transformInterpolations(
        self, effectorNames: Any, space: Any, paths: Any, axisMasks: Any, times: Any, isAbsolute: Any = True
    ) -> Call:
        """Move effectors through transforms at times; else as positionInterpolations."""
        asked = (effectorNames, space, paths, axisMasks, times)
        return self._follow("transformInterpolations", transforms, asked, isAbsolute)

    @method
    def transformInterpolation(
        self, chainName: Any, space: Any, path: Any, axisMask: Any, duration: Any, isAbsolute: Any = True
    ) -> Call:
        """The same for one effector."""
        arguments.text(chainName, "chainName")
        asked = (chainName, space, path, axisMask, duration)
        return self._follow("transformInterpolation", transforms, asked, isAbsolute)

    # --- at once --------------------------------------------------------------------------------------------------

    @method
    def setPositions(self, effectorNames: Any, space: Any, position: Any, fractionMaxSpeed: Any, axisMask: Any) -> None:
        """Send effectors to positions at a fraction of the joints' maximum speeds; returns at once.

        Args:
            effectorNames: an effector, or a list of them.
            space: one for all, or a list of one for each.
            position: a position, or a list of one for each.
            fractionMaxSpeed: above 0, at most 1.
            axisMask: one for all, or a list of one for each.
        """
        self._send("setPositions", single(effectorNames, space, position, axisMask, positions), fractionMaxSpeed)

    @method
    def setPosition(self, chainName: Any, space: Any, position: Any, fractionMaxSpeed: Any, axisMask: Any) -> None:
        """The same for one effector."""
        arguments.text(chainName, "chainName")
        self._send("setPosition", single(chainName, space, position, axisMask, positions), fractionMaxSpeed)

    @method
    def changePosition(
        self, effectorName: Any, space: Any, positionChange: Any, fractionMaxSpeed: Any, axisMask: Any
    ) -> None:
        """Change an effector's position from where it is commanded to be; else as setPosition."""
        arguments.text(effectorName, "effectorName")
        found = single(effectorName, space, positionChange, axisMask, positions, relative=True)
        self._send("changePosition", found, fractionMaxSpeed)

    @method
    def setTransforms(
        self, effectorNames: Any, space: Any, transform: Any, fractionMaxSpeed: Any, axisMask: Any
    ) -> None:
        """Send effectors to transforms; else as setPositions."""
        self._send("setTransforms", single(effectorNames, space, transform, axisMask, transforms), fractionMaxSpeed)

    @method
    def setTransform(self, chainName: Any, space: Any, transform: Any, fractionMaxSpeed: Any, axisMask: Any) -> None:
        """The same for one effector."""
        arguments.text(chainName, "chainName")
        self._send("setTransform", single(chainName, space, transform, axisMask, transforms), fractionMaxSpeed)

    @method
    def changeTransform(self, chainName: Any, space: Any, transform: Any, fractionMaxSpeed: Any, axisMask: Any) -> None:
        """Change an effector's transform from where it is commanded to be; else as setTransform."""
        arguments.text(chainName, "chainName")
        found = single(chainName, space, transform, axisMask, transforms, relative=True)
        self._send("changeTransform", found, fractionMaxSpeed)

    # --- inside ---------------------------------------------------------------------------------------------------

    def _pose(self, name: Any, space: Any, use_sensors: Any) -> Floats:
        q = self.nao.joints.q(sensor=arguments.flag(use_sensors, "useSensorValues"))
        number = space_number(space)
        return pose_in(self.nao.robot, q, arguments.text(name, "name"), number, torso_in_world=self.nao.base.torso(q))

    def _follow(self, name: str, poses: ToPoses, asked: tuple[Any, Any, Any, Any, Any], is_absolute: Any) -> Call:
        """Have effectors follow paths, of which `poses` reads positions or transforms.

        `asked` are names, space, paths, masks and times, as the methods take them.
        """
        relative = not arguments.flag(is_absolute, "isAbsolute")
        found = wishes(*asked, poses, relative=relative)
        balance: Balance | None = getattr(self, "balance", None)
        if balance is not None and balance.enabled and all(wish.mask in MASKS for wish in found):
            return self.nao.start_task(WholePathTask(name, self.nao, found, balance))
        return self.nao.start_task(PathTask(name, self.nao, found))

    def _send(self, name: str, found: Sequence[Wish], fraction: Any) -> None:
        """Solve for all effectors, the torso and legs first, and send the joints there."""
        share = arguments.fraction(fraction, "fractionMaxSpeed", positive=True)
        hold_still(self.nao, found)
        scene = Scene(self.nao)
        q, T_world_torso = scene.q, scene.T_world_torso
        feet = np.stack([T_world_torso @ self.nao.robot.fk(q, foot) for foot in limbs.LEGS])
        first = (limbs.TORSO, *limbs.LEGS)
        missed: list[str] = []
        for wish in sorted(found, key=lambda one: first.index(one.effector) if one.effector in first else len(first)):
            T = scene.path(wish)[-1]
            if wish.effector == limbs.TORSO:
                solution = limbs.torso_over_feet(self.nao.robot, T, feet, q)
            else:
                solution = limbs.anywhere(self.nao.robot, scene.target(wish, T, T_world_torso), q)
            q = solution.q
            missed += [wish.effector] if solution.missing > _NOTEWORTHY else []
            if wish.effector in first:
                T_world_torso = self.nao.base.torso(q)
        if missed:
            self.nao.log.write(f"{name}: {', '.join(missed)} cannot reach the target and goes as near as it can")
        joints = needed_joints(self.nao, found)
        targets = self.nao.robot.to_body(q)[self.nao.joints.columns(joints)]
        task = TogetherTask(name, joints, targets, share)
        task.keeps_feet = moves_legs(found)
        self.nao.start_task(task)


# --- ALMotion's whole-body control: balance, feet that stay, effectors that the whole robot holds.

_LEAST_DURATION = 0.1
# What NAOqi documents for wbEnableEffectorOptimization.
_OPTIMIZED = ("All", "Arms", "Legs", "Head", "LArm", "RArm", "LLeg", "RLeg", "Torso", "Com")


class WholeBodyControl(Service):
    """The methods of ALMotion that move the whole robot, with its feet in place and its balance kept.

    They go through `nk.ik.whole_body`: the feet that stand are met exactly, and with the balance constraint the centre
    of mass stays 5 mm inside the support polygon of their pressure sensors. It is balance at rest: nothing has inertia.

    - While it is on, positionInterpolations and transformInterpolations go through it too: all joints but the hands
      help, and a foot that is neither moved nor "Free" stays. Masks are then 7, 56 or 63; others move their own chain.
    - setAngles, angleInterpolation and setPositions move their own joints; the balance does not correct them.
    - "Plane" counts as "Fixed": a foot does not slide.
    - wbEnableEffectorOptimization changes nothing.
    """

    def __init__(self, nao: Any) -> None:
        super().__init__(nao)
        self.balance = Balance()
        self._control: EffectorControl | None = None

    def kernels_for(self, name: str, given: tuple[Any, ...]) -> frozenset[str]:
        """The whole body holds its balance, and while it is on, effectors too."""
        paths = name.startswith(("positionInterpolation", "transformInterpolation")) and self.balance.enabled
        needed = paths or name.startswith("wb")
        return super().kernels_for(name, given) | (frozenset({"bodies"}) if needed else frozenset())

    @method
    def wbEnable(self, isEnabled: Any) -> None:
        """Switch whole-body control on or off; off forgets all constraints."""
        on = arguments.flag(isEnabled, "isEnabled")
        if not on:
            self._release()
            self.balance = Balance()
        self.balance.enabled = on

    @method
    def wbFootState(self, stateName: Any, supportLeg: Any) -> None:
        """Say what a foot may do.

        Args:
            stateName: "Fixed", "Plane" or "Free".
            supportLeg: "LLeg", "RLeg" or "Legs" for both.
        """
        state = arguments.choice(stateName, "foot state", FOOT_STATES)
        leg = arguments.choice(supportLeg, "support leg", SUPPORTS)
        for foot in self.balance.feet:
            if leg in (foot, "Legs"):
                self.balance.feet[foot] = state

    @method
    def wbEnableBalanceConstraint(self, isEnable: Any, supportLeg: Any) -> None:
        """Keep the centre of mass above what supports it.

        Args:
            isEnable: False to let it go.
            supportLeg: "Legs" for anywhere above both feet, "LLeg" or "RLeg" for above that one.
        """
        leg = arguments.choice(supportLeg, "support leg", SUPPORTS)
        self.balance.support = leg if arguments.flag(isEnable, "isEnable") else None

    @method
    def wbGoToBalance(self, supportLeg: Any, duration: Any) -> Call:
        """Bring the centre of mass above the middle of what supports it; returns whether it is there.

        Args:
            supportLeg: "LLeg", "RLeg" or "Legs" for both.
            duration: how long it takes [s].
        """
        leg = arguments.choice(supportLeg, "support leg", SUPPORTS)
        seconds = arguments.duration(duration, "duration")
        self._check_stands()
        return self.nao.start_task(GoToBalance(self.nao, "wbGoToBalance", leg, seconds))

    @method
    def wbGoToBalanceWithSpeed(self, supportLeg: Any, fractionMaxSpeed: Any) -> Call:
        """The same, no joint faster than a fraction of its maximum speed."""
        leg = arguments.choice(supportLeg, "support leg", SUPPORTS)
        share = arguments.fraction(fractionMaxSpeed, "fractionMaxSpeed", positive=True)
        self._check_stands()
        return self.nao.start_task(GoToBalance(self.nao, "wbGoToBalanceWithSpeed", leg, _LEAST_DURATION, share))

    @method
    def wbEnableEffectorControl(self, effectorName: Any, isEnabled: Any) -> None:
        """Hold an effector by the whole robot, at first where it is; it switches whole-body control on.

        Args:
            effectorName: "Head", "LArm" or "RArm".
            isEnabled: False to let it go.
        """
        effector = arguments.choice(effectorName, "effector", HELD)
        if not arguments.flag(isEnabled, "isEnabled"):
            control = self._held()
            if control is not None and not control.release(effector):
                self._release()
            return
        self._check_stands()
        if not self.balance.enabled:
            self.balance.enabled, self.balance.support = True, "Legs"
        control = self._held()
        if control is None:
            control = self._control = EffectorControl(self.nao, self.balance)
            self.nao.start_task(control)
        control.hold(self.nao, effector)

    @method
    def wbSetEffectorControl(self, effectorName: Any, targetCoordinate: Any) -> None:
        """Tell where an effector that is held is to be; returns at once.

        Args:
            effectorName: "Head", "LArm" or "RArm".
            targetCoordinate: in FRAME_ROBOT: of an arm the place of its hand [x, y, z] [m], of the head its rotation
                [wx, wy, wz] [rad].
        """
        effector = arguments.choice(effectorName, "effector", HELD)
        target = as_floats(targetCoordinate, (3,), "targetCoordinate")
        if target.shape != (3,):
            raise BadArgument(f"targetCoordinate must be three numbers, got {target.size}")
        control = self._held()
        if control is None or not control.holds(effector):
            raise BadArgument(f"{effector} is not held: wbEnableEffectorControl({effector!r}, True) first")
        control.send(self.nao, effector, np.array(target))

    @method
    def wbEnableEffectorOptimization(self, effectorName: Any, isActive: Any) -> None:
        """Taken and left; an effector whose target is far goes as near as it can in any case."""
        arguments.choice(effectorName, "effector", _OPTIMIZED)
        arguments.flag(isActive, "isActive")

    def _held(self) -> EffectorControl | None:
        return None if self._control is None or self._control.over else self._control

    def _release(self) -> None:
        control = self._held()
        if control is not None:
            self.nao.tasks.kill(control.id)
        self._control = None

    def _check_stands(self) -> None:
        if self.nao.base.support is None:
            raise BadArgument("the robot does not stand on its feet; goToPosture takes it there")
