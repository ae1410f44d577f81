"""Which closed form a frame belongs to."""

from __future__ import annotations

from collections.abc import Callable

from nao_kin.errors import BadArgument
from nao_kin.ik.arm import arm_limb
from nao_kin.ik.geometry import Limb
from nao_kin.ik.head import head_limb
from nao_kin.ik.leg import leg_limb
from nao_kin.robot import RobotModel, check_robot

LIMBS: dict[str, Callable[[RobotModel, str], Limb]] = {
    "LLeg": lambda robot, frame: leg_limb(robot, "L", frame),
    "RLeg": lambda robot, frame: leg_limb(robot, "R", frame),
    "LArm": lambda robot, frame: arm_limb(robot, "L", frame),
    "RArm": lambda robot, frame: arm_limb(robot, "R", frame),
    "Head": lambda robot, frame: head_limb(robot, frame),
}


def limb_of_frame(robot: RobotModel, frame: str) -> str | None:
    """The limb whose closed form places a frame: "LLeg", "RLeg", "LArm", "RArm" or "Head"; None where none does.

    Args:
        robot: any robot.
        frame: one of its frames.

    Raises:
        UnknownName: no such frame.
    """
    check_robot(robot)
    robot.frame_ids([frame])
    for name, limb in LIMBS.items():
        try:
            limb(robot, frame)
        except BadArgument:
            continue
        return name
    return None
