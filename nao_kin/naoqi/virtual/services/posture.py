"""ALRobotPosture: the predefined postures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.errors import UnknownName
from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual.calls import Call
from nao_kin.naoqi.virtual.interpolation import Interpolation, at_speed
from nao_kin.naoqi.virtual.service import Service, method

if TYPE_CHECKING:
    from nao_kin.naoqi.virtual.virtual_nao import VirtualNao

# A joint this far from a posture's is still in it [rad]; NAOqi's own measure is not published.
_NEAR = 0.1
_HANDS = ("LHand", "RHand")
_FAMILIES = {
    "Stand": "Standing",
    "StandInit": "Standing",
    "StandZero": "Standing",
    "Crouch": "Crouching",
    "Sit": "Sitting",
    "SitRelax": "Sitting",
    "LyingBelly": "LyingBelly",
    "LyingBack": "LyingBack",
}
_BENT_KNEES = 1.5


class GoToPosture(Interpolation):
    """Joints go to a posture, and the robot stands up, sits or lies down with them.

    Args:
        name: NAOqi's method.
        posture: which posture.
        nao: the virtual NAO.
        fraction: of the maximum speeds.
    """

    def __init__(self, name: str, posture: str, nao: VirtualNao, fraction: float) -> None:
        joints = nao.joints.names
        self._posture = posture
        self._q = nao.robot.clamp(nao.robot.posture(posture))
        target = nao.robot.to_body(self._q)
        speeds = fraction * nao.joints.max_speed
        super().__init__(name, joints, lambda start: at_speed(joints, target, start, speeds))
        self.value = False

    def start(self, nao: VirtualNao, time: float) -> None:
        """Note how the robot stands or lies."""
        super().start(nao, time)
        rest = nao.robot.semantics.postures[self._posture].up
        self._from_feet, self._to_feet = nao.base.support is not None, rest is None
        self._up_before = nao.base.vertical(nao.joints.q())
        self._up_after = nao.base.vertical_on_feet(self._q) if rest is None else np.array(rest)

    def advance(self, nao: VirtualNao, time: float) -> bool:
        """Move the joints, and turn the vertical as far as they have come."""
        done = super().advance(nao, time)
        if not (self._from_feet and self._to_feet) and nao.joints.stiffness.any():
            share = 1.0 if done else (time - self._start) / self._end
            nao.base.rest(_between(self._up_before, self._up_after, share), nao.joints.q())
        return done

    def end(self, nao: VirtualNao, *, killed: bool) -> None:
        """Say whether the posture is reached, and stand on a foot where it stands on feet."""
        if killed or self.started is None:
            return
        # The last command is taken at the end of this tick; what matters is whether the joints could follow.
        step = nao.joints.max_speed * 0.01 * (nao.joints.stiffness > 0.0)
        target = nao.robot.to_body(self._q)
        near = np.abs(nao.joints.sensor - target) <= step + 1e-6
        # Hands do not count, as for getPosture: openHand and closeHand leave them without stiffness.
        near[nao.joints.columns(_HANDS)] = True
        self.value = bool(near.all())
        if not self._from_feet and self._to_feet and nao.joints.stiffness.any():
            nao.base.stand_on(nao.base.standing_foot(self._q), self._q)
        nao.log.change("posture", self._posture)
        if self.value:
            nao.announce("PostureChanged", self._posture)
            nao.announce("PostureFamilyChanged", _FAMILIES.get(self._posture, "Unknown"))


class ALRobotPosture(Service):
    """Predefined postures, each reached on straight lines in the space of joints.

    NAOqi plans a way from posture to posture; here all joints set out together and arrive together, the one with the
    longest way at the given fraction of its maximum speed.
    """

    name = "ALRobotPosture"
    absent = ("getRobotPosture", "isStandCompatible")

    @method
    def getPostureList(self) -> list[str]:
        """Names of the predefined postures."""
        return list(self.nao.robot.posture_names)

    @method
    def getPostureFamilyList(self) -> list[str]:
        """Names of the families of postures."""
        return list(dict.fromkeys(_FAMILIES.values()))

    @method
    def getPosture(self) -> str:
        """The predefined posture that all joints but the hands are within 0.1 rad of; "Unknown" for none."""
        body = self.nao.joints.sensor
        looked_at = [index for index, name in enumerate(self.nao.joints.names) if name not in _HANDS]
        distances = {
            name: float(np.abs(self.nao.robot.to_body(self.nao.robot.posture(name)) - body)[looked_at].max())
            for name in self.nao.robot.posture_names
        }
        nearest = min(distances, key=lambda name: distances[name])
        return nearest if distances[nearest] <= _NEAR else "Unknown"

    @method
    def getPostureFamily(self) -> str:
        """The family of the posture; between postures, of what the robot does: stand, crouch, or "Unknown"."""
        posture = self.getPosture()
        if posture in _FAMILIES:
            return _FAMILIES[posture]
        if self.nao.base.support is None:
            return "Unknown"
        knees = self.nao.joints.sensor[self.nao.joints.columns(("LKneePitch", "RKneePitch"))]
        return "Crouching" if float(knees.min()) > _BENT_KNEES else "Standing"

    @method
    def goToPosture(self, postureName: Any, maxSpeedFraction: Any) -> Call | bool:
        """Go to a posture; True when it is reached, False where it is unknown, killed, or joints have no stiffness.

        The hands go there too, but do not count: openHand and closeHand leave them without stiffness.

        Args:
            postureName: one of getPostureList.
            maxSpeedFraction: above 0; more than 1 counts as 1, with a line in the log.
        """
        return self._go("goToPosture", postureName, maxSpeedFraction)

    @method
    def applyPosture(self, postureName: Any, maxSpeedFraction: Any) -> Call | bool:
        """The same; NAOqi's goes without planning its way."""
        return self._go("applyPosture", postureName, maxSpeedFraction)

    @method
    def stopMove(self) -> None:
        """End the way to a posture where it is, and those that wait for it."""
        for number in [task.id for task in reversed(self.nao.tasks.all) if isinstance(task, GoToPosture)]:
            self.nao.tasks.kill(number)

    @method
    def setMaxTryNumber(self, pMaxTryNumber: Any) -> None:
        """Taken and left: a posture is reached at the first try here."""
        arguments.whole(pMaxTryNumber, "pMaxTryNumber")

    def _go(self, name: str, posture: Any, fraction: Any) -> Call | bool:
        wanted = arguments.text(posture, "postureName")
        given = arguments.number(fraction, "maxSpeedFraction")
        share = arguments.fraction(min(given, 1.0), "maxSpeedFraction", positive=True)
        if given > 1.0:
            self.nao.log.write(f"{name}: maxSpeedFraction = {given:g} is clipped to 1")
        if wanted not in self.nao.robot.posture_names:
            self.nao.log.write(f"{name}: {UnknownName('posture', wanted, self.nao.robot.posture_names)}")
            return False
        return self.go_to(name, wanted, share)

    def go_to(self, name: str, posture: str, fraction: float) -> Call:
        """Start going to a posture, under any name."""
        return self.nao.start_task(GoToPosture(name, posture, self.nao, fraction))


def _between(one: Floats, other: Floats, share: float) -> Floats:
    """A direction on the arc between two; the second half of the way by the side where they are opposite."""
    mixed = (1.0 - share) * one + share * other
    length = float(np.linalg.norm(mixed))
    return other if length < 1e-6 else mixed / length
