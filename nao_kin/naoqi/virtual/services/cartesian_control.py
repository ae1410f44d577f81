"""ALMotion's Cartesian control: poses of effectors read, set, and interpolated."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.naoqi.poses import position6d, transform_list
from nao_kin.naoqi.spaces import pose_in, space_number
from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual.calls import Call
from nao_kin.naoqi.virtual.cartesian import effectors as limbs
from nao_kin.naoqi.virtual.cartesian.forms import ToPoses, Wish, positions, single, transforms, wishes
from nao_kin.naoqi.virtual.cartesian.tasks import PathTask, Scene, TogetherTask, hold_still, moves_legs, needed_joints
from nao_kin.naoqi.virtual.service import Service, method
from nao_kin.naoqi.virtual.whole_body.balance import Balance
from nao_kin.naoqi.virtual.whole_body.tasks import MASKS, WholePathTask

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
