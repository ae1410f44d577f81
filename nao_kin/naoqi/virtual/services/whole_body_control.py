"""ALMotion's whole-body control: balance, feet that stay, effectors that the whole robot holds."""

from __future__ import annotations

from typing import Any

import numpy as np

from nao_kin._common.arrays import as_floats
from nao_kin.errors import BadArgument
from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual.calls import Call
from nao_kin.naoqi.virtual.service import Service, method
from nao_kin.naoqi.virtual.whole_body.balance import FOOT_STATES, SUPPORTS, Balance
from nao_kin.naoqi.virtual.whole_body.tasks import HELD, EffectorControl, GoToBalance

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
