"""ALMotion's general tools: names, limits, masses, tasks, and switches of what is not simulated."""

from __future__ import annotations

from typing import Any

from nao_kin.errors import BadArgument, UnknownName
from nao_kin.naoqi import names as language
from nao_kin.naoqi.names import limits
from nao_kin.naoqi.spaces import torso_in
from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual.body import WHOLE, mass_and_com
from nao_kin.naoqi.virtual.service import Kept, Service, keeps, method

_ARMS = ("Arms", "LArm", "RArm")
_IDLE = ("Body", "Legs", "Arms", "LArm", "RArm", "Head")


def _switch(name: str, log: str, note: str, *of: str, **more: Any) -> Kept:
    names = {"pChainName": ("chain", _ARMS), "pChain": ("chain", _IDLE)}.get("".join(of))
    takes = (*of, "pIsEnabled" if of == ("pChain",) else "pEnable")
    what = "the second argument" if of else "the argument"
    return Kept(f"{name}Enabled", note, "pChain" not in of, takes, arguments.flag, what, names, log, **more)


_COLLIDES = 'Kept for "Arms", "LArm" or "RArm"; nothing collides here.'
_OUTSIDE = "ExternalCollisionProtection", "external collision protection"


@keeps(
    _switch("FallManager", "fall manager", "Kept; nothing falls here."),
    _switch("SmartStiffness", "smart stiffness", "Kept; stiffness is as it is set here. Always True.", answer=True),
    _switch("DiagnosisEffect", "diagnosis effect", "Kept; nothing breaks here."),
    _switch("CollisionProtection", "collision protection", _COLLIDES, "pChainName", answer=True),
    _switch(*_OUTSIDE, "Kept; there is nothing to collide with here.", "pName"),
    _switch("PushRecovery", "push recovery", "Kept; nobody pushes here."),
    _switch("Breath", "breath", "Kept; the robot does not breathe here.", "pChain"),
    _switch("IdlePosture", "idle posture", "Kept; an idle robot stays as it is here.", "pChain"),
    Kept("OrthogonalSecurityDistance", "Kept [m].", 0.4, ("securityDistance",), arguments.duration),
    Kept("TangentialSecurityDistance", "Kept [m].", 0.1, ("securityDistance",), arguments.duration),
)
class GeneralTools(Service):
    """The methods of ALMotion that tell about the robot and its tasks.

    Reflexes are not simulated: nothing falls, nothing collides and nothing breathes. Their switches are kept, and read
    back as they were set.
    """

    def __init__(self, nao: Any) -> None:
        super().__init__(nao)
        self._breath: dict[str, float] = {"Bpm": 12.0, "Amplitude": 0.5}

    # --- the robot ------------------------------------------------------------------------------------------------

    @method
    def getBodyNames(self, name: Any) -> list[str]:
        """Names of the joints of a chain or group; of all chains for "Chains"."""
        if name == "Chains":
            return list(language.chain_names(self.nao.robot))
        return list(language.joint_names(self.nao.robot, arguments.text(name, "name")))

    @method
    def getJointNames(self, name: Any) -> list[str]:
        """The same under its name before NAOqi 1.14."""
        return self.getBodyNames(name)

    @method
    def getSensorNames(self) -> list[str]:
        """Names of the sensors whose poses getPosition gives."""
        frames = [name.removesuffix("_frame") for name in self.nao.robot.frame_names if name.endswith("_frame")]
        return sorted(name.removeprefix("ImuTorso") for name in frames)

    @method
    def getLimits(self, name: Any) -> list[list[float]]:
        """[minAngle, maxAngle, maxVelocity, maxTorque] of each joint of a joint, chain or group."""
        return [[float(value) for value in row] for row in limits(self.nao.robot, name)]

    @method
    def getMotionCycleTime(self) -> int:
        """Milliseconds of ALMotion's cycle, as NAOqi documents them: 20; the virtual NAO moves in ticks of 10."""
        return 20

    @method
    def getRobotConfig(self) -> list[list[Any]]:
        """Names and values of what the robot is."""
        # As NAOqi writes them: VERSION_60 of a V6, VERSION_33 of a V3.3.
        version = f"VERSION_{self.nao.robot.version.removeprefix('v').replace('.', ''):0<2}"
        config: dict[str, Any] = {
            "Model Type": "naoH25",
            "Head Version": version,
            "Body Version": version,
            "Laser": False,
            "Legs": True,
            "Arms": True,
            "Extended Arms": True,
            "Hands": True,
            "Arm Version": version,
            "Number of Legs": 2,
            "Number of Arms": 2,
            "Number of Hands": 2,
        }
        return [list(config), list(config.values())]

    @method
    def getSummary(self) -> str:
        """Joints, stiffnesses, commands and sensors as a table."""
        joints = self.nao.joints
        lines = [f"{'Joint':<16}{'Stiffness':>10}{'Command':>12}{'Sensor':>12}"]
        rows = zip(joints.names, joints.stiffness, joints.command, joints.sensor, strict=True)
        lines += [f"{name:<16}{stiff:>10.2f}{command:>12.6f}{sensor:>12.6f}" for name, stiff, command, sensor in rows]
        tasks = ", ".join(f"{name} ({number})" for name, number in self.nao.tasks.listing()) or "none"
        return "\n".join([*lines, f"Tasks: {tasks}", ""])

    @method
    def getMass(self, pName: Any) -> float:
        """Mass of a joint's segment, a chain, "Torso", or of all: "Body", "Joints" or "Com" [kg]."""
        return mass_and_com(self.nao.robot, self.nao.joints.q(), self._part(pName))[0]

    @method
    def getCOM(self, pName: Any, pSpace: Any, pUseSensorValues: Any) -> list[float]:
        """Centre of mass of a joint's segment, a chain, "Torso", or of all: "Body", "Joints" or "Com" [m].

        Args:
            pName: the part.
            pSpace: FRAME_TORSO 0, FRAME_WORLD 1, FRAME_ROBOT 2.
            pUseSensorValues: True for where the joints are, False for what they are commanded.
        """
        sensor = arguments.flag(pUseSensorValues, "pUseSensorValues")
        q = self.nao.joints.q(sensor=sensor)
        _, com = mass_and_com(self.nao.robot, q, self._part(pName))
        T = torso_in(self.nao.robot, q, pSpace, torso_in_world=self.nao.base.torso(q))
        return [float(value) for value in T[:3, :3] @ com + T[:3, 3]]

    def _part(self, name: Any) -> str:
        part = arguments.text(name, "pName")
        parts = ("Torso", *WHOLE, *language.chain_names(self.nao.robot), *language.GROUPS, *self.nao.joints.names)
        if part not in parts:
            raise UnknownName("part", part, parts)
        return part

    # --- tasks ----------------------------------------------------------------------------------------------------

    @method
    def getTaskList(self) -> list[list[Any]]:
        """[name, id] of each motion task, those that wait for joints last."""
        return self.nao.tasks.listing()

    @method
    def areResourcesAvailable(self, resourceNames: Any) -> bool:
        """Whether no blocking task holds any of these joints."""
        return self.nao.tasks.available(self.joints(resourceNames, "resourceNames"))

    @method
    def killTask(self, motionTaskID: Any) -> bool:
        """End a task where it is; whether there was one with this id."""
        return self.nao.tasks.kill(arguments.whole(motionTaskID, "motionTaskID"))

    @method
    def killTasksUsingResources(self, resourceNames: Any) -> None:
        """End the blocking tasks that hold any of these joints, or wait for them."""
        joints = self.joints(resourceNames, "resourceNames")
        self.nao.tasks.kill_using([*joints, *(f"{joint}/Stiffness" for joint in joints)])

    @method
    def killAll(self) -> None:
        """End all tasks where they are."""
        self.nao.tasks.kill_all()

    # --- what is not simulated ------------------------------------------------------------------------------------

    @method
    def isCollision(self, pChainName: Any) -> str:
        """Always "none": collisions are not looked for here."""
        arguments.choice(pChainName, "chain", _ARMS)
        return "none"

    @method
    def setBreathConfig(self, pConfig: Any) -> None:
        """Kept: [["Bpm", 5 to 30], ["Amplitude", 0 to 1]]."""
        pairs = pConfig if isinstance(pConfig, (list, tuple)) else [pConfig]
        for pair in pairs:
            if not isinstance(pair, (list, tuple)) or len(pair) != 2:
                raise BadArgument('pConfig must be pairs such as ["Bpm", 12]')
            key = arguments.choice(pair[0], "parameter", tuple(self._breath))
            self._breath[key] = arguments.number(pair[1], key)

    @method
    def getBreathConfig(self) -> list[list[Any]]:
        """As it was set."""
        return [[key, value] for key, value in self._breath.items()]
