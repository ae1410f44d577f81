"""The six effectors of Cartesian control, each with the joints that move it, and the solvers that know them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nao_kin import ik
from nao_kin._core.arrays import Floats, rigid_inverse
from nao_kin.naoqi.names import joint_names
from nao_kin.naoqi.spaces import AXIS_MASK_ALL, AXIS_MASK_ROT, AXIS_MASK_VEL, controlled_axes, pose, position6d
from nao_kin.robot import NaoModel, RobotModel
from nao_kin.rotations import log

# --- Joint values for effectors of which only some axes are asked for, from where the joints are.
#
# NAOqi solves Cartesian control by the pseudo-inverse of the Jacobian of the controlled axes, from cycle to cycle. So
# does this: damped least squares from the joint values of before, so that along a path joints move as little as they
# can.

# One radian counts as much as 0.1 m.
RADIAN = 0.1
_MOST_STEPS = 60
_MET = 1e-10
_SMALLEST_STEP = 1e-11
_DAMPING = 1e-6
_MOST_DAMPING = 1e3


@dataclass(frozen=True, eq=False)
class Target:
    """Where a frame of the robot is to be, as seen from the torso or from the sole that stands.

    Attributes:
        frame: the robot's name of it.
        T_reference_target: shape (4, 4).
        axes: which of x, y, z, wx, wy, wz count, along the axes of the space, shape (6,).
        R_reference_space: these axes in the reference, shape (3, 3).
        reference: the frame that stays in place: "Torso", or a foot whose leg moves with the joints too.
    """

    frame: str
    T_reference_target: Floats
    axes: NDArray[np.bool_]
    R_reference_space: Floats
    reference: str = "Torso"

    def errors(self, T_reference_frame: Floats) -> Floats:
        """What is missing along the axes that count: metres, and radians times `RADIAN`, shape (k,)."""
        R = self.R_reference_space.T
        away = R @ (self.T_reference_target[:3, 3] - T_reference_frame[:3, 3])
        turn = R @ log(self.T_reference_target[:3, :3] @ T_reference_frame[:3, :3].T)
        return np.concatenate([away, RADIAN * turn])[self.axes]

    def missing(self, robot: RobotModel, q: Floats) -> Floats:
        """As `errors`, in a configuration."""
        return self.errors(robot.fk(q, self.frame, reference=self.reference))

    def rows(self, robot: RobotModel, q: Floats) -> Floats:
        """The rows of the Jacobian that belong to them, shape (k, nv)."""
        J = robot.jacobian(q, self.frame)
        if self.reference != "Torso":
            T_torso_frame, T_torso_reference = robot.fk(q, [self.frame, self.reference])
            J_reference, away = robot.jacobian(q, self.reference), T_torso_frame[:3, 3] - T_torso_reference[:3, 3]
            # What a point moves as seen from a reference that moves itself: v − v_reference − ω_reference × away.
            carried = J_reference[:3] - np.cross(away, J_reference[3:], axis=0)
            R_reference_torso = T_torso_reference[:3, :3].T
            J = np.concatenate([R_reference_torso @ (J[:3] - carried), R_reference_torso @ (J[3:] - J_reference[3:])])
        R = self.R_reference_space.T
        return np.concatenate([R @ J[:3], RADIAN * (R @ J[3:])])[self.axes]


@dataclass(frozen=True, eq=False)
class Solution:
    """Joint values and what they leave.

    Attributes:
        q: configuration inside the limits, shape (nq,).
        missing: the length of all errors together: metres, and radians times 0.1.
    """

    q: Floats
    missing: float


def descend(robot: RobotModel, target: Target, columns: Sequence[int], q: Floats) -> Solution:
    """The joint values near by that bring a frame to its target, inside all limits.

    Where the target cannot be met from here, these are the nearest that steps downhill lead to.

    Args:
        robot: with a fixed base.
        target: what is asked for.
        columns: the joints that may move, as places in q.
        q: where to begin, inside the limits, shape (nq,).
    """
    free = np.array(columns)
    best, e, damping = np.array(q), target.missing(robot, q), _DAMPING
    for _ in range(_MOST_STEPS):
        if np.abs(e).max(initial=0.0) < _MET or damping > _MOST_DAMPING:
            break
        step = _step(robot, target.rows(robot, best)[:, free], e, free, best, damping)
        if np.abs(step).max(initial=0.0) < _SMALLEST_STEP:
            break
        trial = best.copy()
        trial[free] += step
        trial = robot.clamp(trial)
        left = target.missing(robot, trial)
        if left @ left < e @ e:
            best, e, damping = trial, left, max(0.1 * damping, 1e-12)
        else:
            damping *= 10.0
    return Solution(best, float(np.linalg.norm(e)))


def _step(robot: RobotModel, J: Floats, e: Floats, free: NDArray[np.int64], q: Floats, damping: float) -> Floats:
    """Jᵀ (J Jᵀ + λ 1)⁻¹ e over the joints that it does not press against a limit, coupled ones included."""
    moving = np.ones(len(free), dtype=np.bool_)
    step = np.zeros(len(free))
    for _ in range(len(free)):
        step = np.where(moving, J, 0.0).T @ np.linalg.solve(J[:, moving] @ J[:, moving].T + damping * np.eye(len(e)), e)
        nudged = q.copy()
        nudged[free] += np.sign(step) * 1e-9
        pressed = (step != 0.0) & (np.abs(robot.clamp(nudged)[free] - q[free]) < 1e-10)
        if not pressed.any():
            break
        moving &= ~pressed
    return step


# --- The six effectors of Cartesian control, each with the joints that move it, and the solvers that know them.

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


def near(robot: NaoModel, target: Target, q: Floats) -> Solution:
    """Joint values beside those of now: what a path is followed with."""
    return descend(robot, target, columns_of(robot, [target.frame]), q)


def anywhere(robot: NaoModel, target: Target, q: Floats) -> Solution:
    """Joint values for one limb, wherever they are: the nearest to those of now, or where none are, the nearest pose.

    Whole poses of arms and legs, places of hands and directions of the head go by their closed forms; other masks by
    descents, from the joints of now and from others.
    """
    found = near(robot, target, q)
    if found.missing <= MET:
        return found
    closed = _closed_form(robot, target, q)
    is_known = closed is not None and bool(np.isfinite(closed).all())
    if closed is not None and target.reference == TORSO:
        missing = float(np.linalg.norm(target.missing(robot, closed))) if is_known else np.inf
        return min(found, Solution(closed, missing), key=lambda one: one.missing)
    columns = columns_of(robot, [target.frame])
    starts = robot.random(np.random.default_rng(0), _STARTS)
    if is_known:  # it holds for the torso as it is now
        starts[0] = closed
    others = []
    for start in starts:
        begin = q.copy()
        begin[columns] = start[columns]
        others.append(descend(robot, target, columns, robot.clamp(begin)))
    reached = [one for one in others if one.missing <= MET]
    if reached:
        return min(reached, key=lambda one: float(np.abs(one.q - q).max()))
    return min(found, *others, key=lambda one: one.missing)


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
    asked_torso = T_world_torso
    for _ in range(_MOST_TURNS):
        # A batch of one, for which the kernel is compiled; without it every tick would take as long as it lasts.
        found = ik.legs(robot, left[None], right, base="floating", torso=asked_torso, free="yaw", reference=q)
        if not np.all(found.success):
            return Solution(found.q[0] if np.isfinite(found.q).all() else np.array(q), np.inf)
        torso = np.asarray(found.torso)[0]
        # The yaw gives way about the middle of the hips, which takes a leaning torso with it: back to its place.
        six = position6d(T_world_torso)
        six[5] = position6d(torso)[5]
        asked_torso = pose(six)
        if np.abs(asked_torso[:3, 3] - torso[:3, 3]).max() < _IN_PLACE:
            break
    target = Target(TORSO, T_world_torso, np.ones(6, dtype=np.bool_), np.eye(3))
    return Solution(found.q[0], float(np.linalg.norm(target.errors(torso))))


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


def in_torso(T_world_torso: Floats, T_world: Floats) -> Floats:
    """A pose in the world as the torso sees it."""
    return np.asarray(rigid_inverse(T_world_torso) @ T_world)
