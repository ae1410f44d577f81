"""A motion, or a configuration, seen in a mirror: what the left did the right does."""

from __future__ import annotations

import numpy as np

from nao_kin.errors import BadArgument, UnknownName
from nao_kin.motion.configurations import check_joints
from nao_kin.motion.motion import Motion, check_motion
from nao_kin.motion.sides import other_side
from nao_kin.robot import RobotModel, check_robot

# Axes of two sides, mirrored onto each other, must be parallel to this sine.
_PARALLEL = 1e-3
_MIRROR = np.array([1.0, -1.0, 1.0])


def mirror(robot: RobotModel, motion: Motion) -> Motion:
    """The motion mirrored at the plane between left and right, y = 0.

    What LShoulderPitch did RShoulderPitch does; mirrored twice a motion is itself again. A joint that turns about the
    axis a, seen in the mirror M = diag(1, −1, 1), turns about −M a: its value changes sign where that is the opposite
    of the axis of the joint on the other side. A sliding joint slides along M a; ratios, such as a hand's, stay.

    Args:
        robot: whose axes say what changes sign.
        motion: which; names say left and right as in LHand, l_hand, hand_l or left_hand.

    Raises:
        UnknownName: the robot has no such joint.
        BadArgument: a joint has no other side, or one that is not its mirror image.

    Examples:
        >>> wave = nk.Motion([0.0, 1.0], ["LShoulderRoll"], [[0.0], [0.5]])
        >>> mirrored = nk.motion.mirror(nk.load_nao(), wave)
        >>> mirrored.joint_names, mirrored.sample(1.0).tolist()
        (('RShoulderRoll',), [-0.5])
    """
    check_robot(robot)
    check_motion(motion)
    check_joints(robot, motion)
    names = tuple(other_side(name) for name in motion.joint_names)
    signs = [_sign(robot, name, other) for name, other in zip(motion.joint_names, names, strict=True)]
    # Adding zero takes the sign off a negative zero.
    keys = [sign * column + 0.0 for sign, column in zip(signs, motion.keys, strict=True)]
    handles = None
    if motion.handles is not None:
        handles = [offsets * (1.0, sign) + 0.0 for sign, offsets in zip(signs, motion.handles, strict=True)]
    return Motion(motion.times, names, keys, motion.interpolation, handles)


def mirrored_joints(robot: RobotModel) -> dict[str, tuple[str, float]]:
    """What shows a configuration of a robot in a mirror, at the plane between left and right, y = 0.

    Args:
        robot: whose joints; those that follow another one are named as the other side of one, never by themselves.

    Returns:
        Joint → (the joint on the other side, sign): the mirror image has the sign times the other joint's value. A
        joint on neither side is its own other.

    Raises:
        UnknownName: a joint has no other side.
        BadArgument: one that is not its mirror image.

    Examples:
        >>> nk.motion.mirrored_joints(nk.load_nao())["LShoulderRoll"]
        ('RShoulderRoll', -1.0)
    """
    check_robot(robot)
    return {name: (other, _sign(robot, name, other)) for name in robot.joint_names for other in (other_side(name),)}


def _sign(robot: RobotModel, name: str, other: str) -> float:
    """What the value of a joint is multiplied with to be that of its mirror image."""
    if other not in robot.joint_names and other not in robot.mimics:
        raise UnknownName("joint", other, (*robot.joint_names, *robot.mimics), f"the other side of {name}")
    if robot.unit(name) != robot.unit(other):
        raise BadArgument(f"{name} and {other} are no mirror images: one is in {robot.unit(name)}, the other is not")
    if robot.unit(name) == "1":
        return 1.0
    kinds = {joint.name: joint for joint in robot.tree.moving_joints}
    axes = []
    for joint in (kinds[name], kinds[other]):
        R_root_link = robot.rotation(robot.neutral(), joint.child)
        axis = R_root_link @ np.asarray(joint.axis)
        axes.append(axis / np.linalg.norm(axis))
    image = _MIRROR * axes[0] * (1.0 if kinds[name].kind == "prismatic" else -1.0)
    if np.linalg.norm(np.cross(image, axes[1])) > _PARALLEL:
        raise BadArgument(f"{name} and {other} are no mirror images: their axes are not")
    return float(np.sign(image @ axes[1]))
