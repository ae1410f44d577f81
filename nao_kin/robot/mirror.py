"""Mirror images at the plane between left and right, y = 0: of values of joints, and of configurations."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nao_kin._core.arrays import COUPLING_TOLERANCE, Floats, choice
from nao_kin._core.sides import other_sides
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.robot.kinematic_robot import KinematicRobot
from nao_kin.robot.semantics import Mimic

# How far a joint may be from the mirror image of the joint on the other side, as a share of the robot's size, and by
# how much the directions of their axes may differ [rad]: more than calibration finds.
_APART = 0.05
_MIRROR = np.array([1.0, -1.0, 1.0])
# Signs of a floating base: its position, and its quaternion (x, y, z, w), whose vector turns as an axis does.
_BASE = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0])


class _Image(NamedTuple):
    """How a joint of the mirror image follows the joint on the other side; how far it is from that joint's image."""

    of: Mimic
    metres: float = 0.0
    radians: float = 0.0
    fits: bool = True


def mirrored(robot: KinematicRobot, q: Floats) -> Floats:
    """Return the mirror images of configurations."""
    images = _images(robot)
    for name in robot.joint_names:
        _check(robot, name, images)
    return _mirrored(robot, q, images)


def mirror_image(robot: KinematicRobot, name: str) -> Mimic:
    """Return how a joint of the mirror image follows the joint on the other side; both must fit to their motors."""
    choice(name, (*robot.joint_names, *robot.mimics), "joint")
    images = _images(robot)
    _check(robot, name, images)
    return images[name].of


def _mirrored(robot: KinematicRobot, q: Floats, images: dict[str, _Image]) -> Floats:
    image = np.empty_like(q)
    image[..., : robot.nq_base] = _BASE[: robot.nq_base] * q[..., : robot.nq_base]
    column = {name: robot.nq_base + index for index, name in enumerate(robot.joint_names)}
    for name in robot.joint_names:
        of = _of_motor(robot, images[name].of)
        image[..., column[name]] = of.value(q[..., column[of.joint]])
    return image + 0.0  # takes the sign off a negative zero


def _of_motor(robot: KinematicRobot, of: Mimic) -> Mimic:
    """Return how the value follows the driving joint, if the joint that it follows has one."""
    return of.through(robot.mimics[of.joint]) if of.joint in robot.mimics else of


def _images(robot: KinematicRobot) -> dict[str, _Image]:
    """Pair the joints by names and by their places at zero; compare a random configuration with its mirror image."""
    joints = robot.tree.moving_joints
    if not joints:
        return {}
    names, links = [joint.name for joint in joints], [joint.child for joint in joints]
    rows = {name: row for row, name in enumerate(names)}
    axes = np.array([joint.axis for joint in joints])
    axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
    slides = np.array([joint.kind == "prismatic" for joint in joints])
    signs = np.where(slides[:, None], _MIRROR, -_MIRROR)  # what turns one way turns the other way in the mirror

    def placed(q: Floats) -> tuple[Floats, Floats]:
        T = robot.fk(q, links, reference=robot.tree.root)
        return T[:, :3, 3], np.einsum("nij,nj->ni", T[:, :3, :3], axes)

    q = robot.random(0)
    p, a = placed(np.where(np.arange(robot.nq) < robot.nq_base, q, 0.0))
    size = np.linalg.norm(p, axis=-1).max()
    others, images = [], {}
    for row, name in enumerate(names):
        candidates = [rows[other] for other in other_sides(name) if other in rows] or [row]
        others.append(min(candidates, key=lambda other: np.linalg.norm(p[other] - _MIRROR * p[row])))
        opposite = robot.unit(name) != "1" and signs[row] * a[others[row]] @ a[row] < 0.0
        images[name] = _Image(Mimic(names[others[row]], -1.0 if opposite else 1.0))
    (p_image, a_image), (p, a) = placed(_mirrored(robot, q, images)), placed(q)
    away = p_image - (_MIRROR * p)[others]
    # The origin of a joint that turns is anywhere on its axis, but a joint that is its own image must not lie aside.
    free = ~slides & (others != np.arange(len(joints)))
    away -= (free * np.sum(away * a_image, axis=-1))[:, None] * a_image
    multipliers = np.array([[image.of.multiplier] for image in images.values()])
    metres = np.linalg.norm(away, axis=-1)
    radians = np.linalg.norm(multipliers * a_image - (signs * a)[others], axis=-1)
    ratios = np.array([robot.unit(name) == "1" for name in names])
    fits = ratios | (metres <= _APART * size + 1e-9) & (radians <= _APART)
    found = zip(images.items(), metres.tolist(), radians.tolist(), fits.tolist(), strict=True)
    return {name: _Image(image.of, *apart) for (name, image), *apart in found}


def _check(robot: KinematicRobot, name: str, images: dict[str, _Image]) -> None:
    """Raise an error if a joint and the one on the other side are no mirror images, or do not follow as those."""
    image = images[name]
    other = image.of.joint
    if robot.unit(name) != robot.unit(other):
        raise BadArgument(f"{name} and {other} are not mirror images: one is in {robot.unit(name)}, the other is not")
    for one in (name, other):
        if one in robot.mimics:
            mimic = robot.mimics[one]
            found = _of_motor(robot, images[one].of)
            wanted = mimic.through(_of_motor(robot, images[mimic.joint].of))
            differ = max(abs(found.multiplier - wanted.multiplier), abs(found.offset - wanted.offset))
            if found.joint != wanted.joint or differ > COUPLING_TOLERANCE:
                how = f"{one} = {mimic.multiplier:g} {mimic.joint} {mimic.offset:+g}"
                raise BadArgument(f"no mirror image: {how} of the mimic joint would not hold in it")
    if image.fits:
        return
    apart = f"{image.metres:.3g} m and {image.radians:.3g} rad apart in a random configuration"
    if other != name:
        raise BadArgument(f"{name} and {other} are not mirror images at y = 0: {apart}")
    if sides := other_sides(name):
        hint = f"the other side of {name}, which is not its own mirror image at y = 0: {apart}"
        raise UnknownName("joint", sides[0], tuple(images), hint)
    raise BadArgument(f"{name} is not its own mirror image at y = 0, {apart}, and its name shows no side")
