"""The six effectors of Cartesian control, each with the joints that move it, and the solvers that know them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nao_kin import NaoModel, ik
from nao_kin._common.arrays import Floats
from nao_kin._common.vectors import rigid_inverse
from nao_kin.naoqi.axis_mask import AXIS_MASK_ALL, AXIS_MASK_ROT, AXIS_MASK_VEL, controlled_axes
from nao_kin.naoqi.names import joint_names
from nao_kin.naoqi.poses import pose, position6d
from nao_kin.naoqi.virtual.cartesian.descent import RADIAN, Solution, Target, descend
from nao_kin.rotations import log

TORSO = "Torso"
LEGS = ("LLeg", "RLeg")
ARMS = ("LArm", "RArm")
_LEFT_HIP, _RIGHT_HIP = "LHipYawPitch", "RHipYawPitch"
# What is left of a target that counts as met [m].
MET = 1e-6
# How often the place of a torso is mended whose yaw gives way, and to what [m].
_MOST_TURNS = 5
_IN_PLACE = 1e-9
# Other starts where the descent from the joints of now ends beside its target.
_STARTS = 12


def resources(effector: str) -> tuple[str, ...]:
    """The joints that a task for an effector needs, by their 26 names."""
    return ("LLeg", "RLeg") if effector == TORSO else (effector,)


def joints_of(robot: NaoModel, effectors: Sequence[str]) -> tuple[str, ...]:
    """The joints that move effectors, each once, hands left out."""
    chains = dict.fromkeys(chain for effector in effectors for chain in resources(effector))
    found = dict.fromkeys(joint for chain in chains for joint in joint_names(robot, chain))
    return tuple(joint for joint in found if robot.unit(joint) != "1")


def columns_of(robot: NaoModel, effectors: Sequence[str]) -> list[int]:
    """The same as places in q: the two hips are one."""
    names = ["LHipYawPitch" if joint == _RIGHT_HIP else joint for joint in joints_of(robot, effectors)]
    return [robot.joint_names.index(name) for name in dict.fromkeys(names)]


def near(robot: NaoModel, targets: Sequence[Target], q: Floats) -> Solution:
    """Joint values beside those of now: what a path is followed with."""
    return descend(robot, targets, columns_of(robot, [target.frame for target in targets]), q)


def anywhere(robot: NaoModel, target: Target, q: Floats) -> Solution:
    """Joint values for one limb, wherever they are: the nearest to those of now, or where none are, the nearest pose.

    Whole poses of arms and legs, places of hands and directions of the head go by their closed forms; other masks by
    descents, from the joints of now and from others.
    """
    found = near(robot, [target], q)
    if found.missing <= MET:
        return found
    closed = _closed_form(robot, target, q)
    if closed is not None and target.reference == TORSO:
        return _better(_judged(robot, target, closed), found)
    rng = np.random.default_rng(0)
    columns = columns_of(robot, [target.frame])
    reached: list[Solution] = []
    starts = robot.random(rng, _STARTS)
    if closed is not None and np.isfinite(closed).all():  # which holds for the torso as it is now
        starts[0] = closed
    for start in starts:
        begin = q.copy()
        begin[columns] = start[columns]
        other = descend(robot, [target], columns, robot.clamp(begin))
        if other.missing <= MET:
            reached.append(other)
        found = _better(other, found)
    return min(reached, key=lambda one: float(np.abs(one.q - q).max())) if reached else found


def torso_over_feet(robot: NaoModel, T_world_torso: Floats, T_world_feet: Floats, q: Floats) -> Solution:
    """Both legs with the feet in place and the torso in a pose, whose yaw gives way to the one motor of the hips.

    Args:
        robot: a NAO.
        T_world_torso: shape (4, 4).
        T_world_feet: left and right, shape (2, 4, 4).
        q: the joints of now, shape (nq,).

    Returns:
        What is missing is where the torso is beside the pose, its yaw included; infinite where a foot is not in place.
    """
    left, right = T_world_feet
    wished = T_world_torso
    for _ in range(_MOST_TURNS):
        # A batch of one, for which the kernel is compiled; without it every tick would take as long as it lasts.
        found = ik.legs(robot, left[None], right, base="floating", torso=wished, free="yaw", reference=q)
        if not np.all(found.success):
            return Solution(found.q[0] if np.isfinite(found.q).all() else np.array(q), np.inf)
        torso = np.asarray(found.torso)[0]
        # The yaw gives way about the middle of the hips, which takes a leaning torso with it: back to its place.
        six = position6d(T_world_torso)
        six[5] = position6d(torso)[5]
        wished = pose(six)
        if np.abs(wished[:3, 3] - torso[:3, 3]).max() < _IN_PLACE:
            break
    away = np.linalg.norm(torso[:3, 3] - T_world_torso[:3, 3])
    turn = np.linalg.norm(log(torso[:3, :3] @ T_world_torso[:3, :3].T))
    return Solution(found.q[0], float(np.hypot(away, RADIAN * turn)))


def completed(T_space_wanted: Floats, T_space_now: Floats, mask: int) -> Floats:
    """The pose with the controlled coordinates of one and the others of another, as Position6D has them."""
    six = np.where(controlled_axes(mask), position6d(T_space_wanted), position6d(T_space_now))
    return pose(six)


def _closed_form(robot: NaoModel, target: Target, q: Floats) -> Floats | None:
    axes = int(np.dot(target.axes, 1 << np.arange(6)))
    T, frame = target.T_reference_target, target.frame
    if target.reference != TORSO:
        T = robot.fk(q, target.reference) @ T
    if frame in ARMS and axes == AXIS_MASK_ALL:
        return ik.arm(robot, frame[0], T, reference=q).q
    if frame in ARMS and axes == AXIS_MASK_VEL:
        return ik.arm(robot, frame[0], T[:3, 3], reference=q).q
    if frame in LEGS and axes == AXIS_MASK_ALL:
        return ik.leg(robot, frame[0], T, reference=q).q
    if frame == "Head" and axes in (AXIS_MASK_ROT, AXIS_MASK_ALL):
        return ik.head(robot, T[:3, :3], reference=q).q
    return None


def _judged(robot: NaoModel, target: Target, q: Floats) -> Solution:
    if not np.isfinite(q).all():
        return Solution(q, np.inf)
    return Solution(q, float(np.linalg.norm(target.missing(robot, q))))


def _better(one: Solution, other: Solution) -> Solution:
    return one if one.missing < other.missing else other


def in_torso(T_world_torso: Floats, T_world: Floats) -> Floats:
    """A pose in the world as the torso sees it."""
    return np.asarray(rigid_inverse(T_world_torso) @ T_world)
