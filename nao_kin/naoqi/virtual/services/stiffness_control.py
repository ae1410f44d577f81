"""ALMotion's stiffness control: awake, at rest, and everything between."""

from __future__ import annotations

from typing import Any

from nao_kin.errors import BadArgument
from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual.calls import Call
from nao_kin.naoqi.virtual.interpolation import StiffnessRamp
from nao_kin.naoqi.virtual.service import Service, method

# How fast the robot crouches on its way to rest, as a share of the maximum speeds.
REST_SPEED = 0.3


class StiffnessControl(Service):
    """The methods of ALMotion that give and take power; 1 is full stiffness, 0 is none.

    A joint without stiffness does not move, and does not sink either.
    """

    @method
    def wakeUp(self) -> None:
        """Give all joints stiffness and have them stay where they are, as a NAO does."""
        self.nao.joints.hold()
        self.nao.joints.set_stiffness(range(len(self.nao.joints.names)), 1.0)
        self._awake(True)

    @method
    def rest(self) -> Call:
        """End all that moves, go to Crouch at three tenths of the maximum speeds, and take the stiffness away."""
        self.nao.tasks.kill_all()
        posture = self.nao.services["ALRobotPosture"]
        stiff = bool((self.nao.joints.stiffness > 0.0).any())

        def let_go(_: object = None) -> None:
            with self.nao.monitor:
                self.nao.joints.set_stiffness(range(len(self.nao.joints.names)), 0.0)
                self._awake(False)
            done.finish()

        if not stiff:
            done = Call()
            self.nao.monitor.later(let_go)
        else:
            crouching: Call = posture.go_to("rest", "Crouch", REST_SPEED)  # type: ignore[attr-defined]
            done = Call(crouching.cancel)
            crouching.add_done_callback(let_go)
        return done

    def _awake(self, awake: bool) -> None:
        self.nao.log.change("awake", awake)
        self.nao.announce("robotIsWakeUp", awake)

    @method
    def robotIsWakeUp(self) -> bool:
        """Whether all joints of the legs have stiffness."""
        columns = self.nao.joints.columns(self.joints("Legs"))
        return bool((self.nao.joints.stiffness[columns] > 0.0).all())

    @method
    def setStiffnesses(self, names: Any, stiffnesses: Any) -> None:
        """Set stiffnesses at once.

        Args:
            names: a joint, a chain, "Body", or a list of these.
            stiffnesses: one for all, or a list of one for each, from 0 to 1.
        """
        joints = self.joints(names)
        values = arguments.one_each(stiffnesses, joints, "stiffnesses")
        for joint, value in zip(joints, values.tolist(), strict=True):
            arguments.fraction(value, f"stiffness of {joint}")
        self.nao.joints.set_stiffness(self.nao.joints.columns(joints), values)

    @method
    def getStiffnesses(self, jointName: Any) -> list[float]:
        """Stiffnesses of a joint, a chain, "Body", or a list of these, from 0 to 1."""
        stiffness = self.nao.joints.stiffness
        return [float(stiffness[column]) for column in self.nao.joints.columns(self.joints(jointName))]

    @method
    def stiffnessInterpolation(self, names: Any, stiffnessLists: Any, timeLists: Any) -> Call:
        """Change stiffnesses on straight lines through values at times; returns when the last is reached.

        Args:
            names: a joint, a chain, "Body", or a list of these.
            stiffnessLists: a stiffness, a list of one for each joint, or of a list for each.
            timeLists: the same of times from now, ascending, above 0 [s].
        """
        joints = self.joints(names)
        keys = arguments.list_each(stiffnessLists, joints, "stiffnesses")
        times = arguments.list_each(timeLists, joints, "times")
        arguments.check_lengths(keys, times, joints, "stiffnesses")
        arguments.check_times(times, joints)
        for joint, row in zip(joints, keys, strict=True):
            if row.min() < 0.0 or row.max() > 1.0:
                outside = row.min() if row.min() < 0.0 else row.max()
                raise BadArgument(f"stiffness of {joint} must be between 0 and 1, got {outside:g}")
        return self.nao.start_task(StiffnessRamp(joints, times, keys))

    @method
    def setMotionConfig(self, config: Any) -> None:
        """Taken and logged; nothing here can be configured."""
        self.nao.log.write(f"setMotionConfig: {config!r} changes nothing here")
