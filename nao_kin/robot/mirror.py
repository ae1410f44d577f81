"""Mirror images at the plane between left and right, y = 0: of values of joints, and of configurations."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nao_kin._core.arrays import COUPLING_TOLERANCE, Floats, choice
from nao_kin._core.sides import other_side
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.robot.semantics import Mimic

if TYPE_CHECKING:
    from nao_kin.robot.model import RobotModel

# Largest sine of the angle between an axis and the mirror image of the axis on the other side, and largest distance
# between them [m]: more than calibration finds.
_PARALLEL, _APART = 0.05, 0.02
_MIRROR = np.array([1.0, -1.0, 1.0])
# Signs of a floating base: its position, and its quaternion (x, y, z, w), whose vector turns as an axis does.
_BASE = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0])


def mirrored(robot: RobotModel, q: Floats) -> Floats:
    """Return the mirror images of configurations."""
    image = np.empty_like(q)
    image[..., : robot.nq_base] = _BASE[: robot.nq_base] * q[..., : robot.nq_base]
    column = {name: robot.nq_base + index for index, name in enumerate(robot.joint_names)}
    for name in robot.joint_names:
        of = _of_motor(robot, mirror_image(robot, name))
        image[..., column[name]] = of.value(q[..., column[of.joint]])
    return image + 0.0  # takes the sign off a negative zero


def mirror_image(robot: RobotModel, name: str) -> Mimic:
    """Return how a joint of the mirror image follows the joint on the other side; both must fit to their motors."""
    image = _image(robot, name)
    for one in (name, image.joint):
        if one in robot.mimics:
            mimic = robot.mimics[one]
            found = _of_motor(robot, _image(robot, one))
            wanted = mimic.through(_of_motor(robot, _image(robot, mimic.joint)))
            apart = abs(found.multiplier - wanted.multiplier), abs(found.offset - wanted.offset)
            if found.joint != wanted.joint or max(apart) > COUPLING_TOLERANCE:
                how = f"{one} = {mimic.multiplier:g} {mimic.joint} {mimic.offset:+g}"
                raise BadArgument(f"no mirror image: {how} of the mimic joint would not hold in it")
    return image


def _of_motor(robot: RobotModel, of: Mimic) -> Mimic:
    """Return how the value follows the driving joint, if the joint that it follows has one."""
    return of.through(robot.mimics[of.joint]) if of.joint in robot.mimics else of


def _image(robot: RobotModel, name: str) -> Mimic:
    """Return the same by the axes of the two joints alone."""
    joints = (*robot.joint_names, *robot.mimics)
    other = other_side(choice(name, joints, "joint"))
    if other not in joints:
        raise UnknownName("joint", other, joints, f"the other side of {name}")
    if robot.unit(name) != robot.unit(other):
        raise BadArgument(f"{name} and {other} are not mirror images: one is in {robot.unit(name)}, the other is not")
    if robot.unit(name) == "1":
        return Mimic(other)
    kinds = {joint.name: joint for joint in robot.tree.moving_joints}
    T_one, T_two = robot.fk(robot.neutral(), [kinds[joint].child for joint in (name, other)])
    one, two = (
        T[:3, :3] @ joint.axis / np.linalg.norm(joint.axis)
        for T, joint in ((T_one, kinds[name]), (T_two, kinds[other]))
    )
    slides = kinds[name].kind == "prismatic"
    image = _MIRROR * one * (1.0 if slides else -1.0)
    apart = 0.0 if slides else np.linalg.norm(np.cross(_MIRROR * T_one[:3, 3] - T_two[:3, 3], two))
    if np.linalg.norm(np.cross(image, two)) > _PARALLEL or apart > _APART:
        raise BadArgument(f"{name} and {other} are not mirror images: their axes are not")
    return Mimic(other, float(np.sign(image @ two)))
