"""Joint values for one effector of Cartesian control: descents for any axes, and closed forms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nao_kin import ik
from nao_kin._core.arrays import Floats
from nao_kin.naoqi.names import ARMS, LEFT_HIP, LEGS, RIGHT_HIP, joint_names
from nao_kin.naoqi.spaces import TORSO, AxisMask, controlled_axes, pose, position6d
from nao_kin.robot import NaoModel
from nao_kin.rotations import log

# --- Joint values for targets that control some axes only.
#
# NAOqi solves Cartesian control with the pseudo-inverse of the Jacobian of the controlled axes, from cycle to cycle.
# So does this module: damped least squares from the joint values of the cycle before, which keeps joint motion along a
# path small.

# One radian has the weight of 0.1 m.
RADIAN = 0.1
_MAX_STEPS = 60
_CONVERGED = 1e-10


def axis_weights(mask: int) -> Floats:
    """Return the weights of x, y, z, wx, wy, wz, 0 for those that a mask does not control, shape (6,)."""
    return np.repeat([1.0, RADIAN], 3) * controlled_axes(mask)


@dataclass(frozen=True, eq=False)
class LimbTarget:
    """The target pose of a frame, relative to the torso or to the sole of the standing foot."""

    frame: str
    T_reference_target: Floats
    mask: int  # which of x, y, z, wx, wy, wz, along the axes of the space, are controlled
    R_reference_space: Floats
    reference: str = TORSO  # the frame that stays in place: "Torso", or a foot, whose leg then moves too


@dataclass(frozen=True, eq=False)
class LimbSolution:
    """A configuration inside the limits, shape (nq,), and the norm of its errors: metres, radians times `RADIAN`."""

    q: Floats
    missing: float


def descend(robot: NaoModel, target: LimbTarget, q: Floats) -> LimbSolution:
    """Return joint values of one limb near q, inside all limits, that bring it to its target or to a local minimum."""
    joints = tuple(robot.joint_names[column] for column in columns_of(robot, [target.frame]))
    frames, weights = (target.frame, target.reference), axis_weights(target.mask)
    T, R = target.T_reference_target, target.R_reference_space
    return LimbSolution(*ik.descended_along(robot, joints, frames, T, R, weights, _CONVERGED, _MAX_STEPS, q))


# --- The six effectors of Cartesian control, each with its joints and its solvers.

# The residual below which a target counts as reached [m].
MET = 1e-6
# The largest number of corrections of the torso's position, and the position error that ends them [m].
_MAX_CORRECTIONS, _IN_PLACE = 5, 1e-9
# The number of random starts after a descent from the current joints that misses its target.
_STARTS = 12


def joints_of(robot: NaoModel, effectors: Sequence[str]) -> tuple[str, ...]:
    """Return the joints that move effectors, each once, by their 26 names, without the hands."""
    chains = ["Legs" if effector == TORSO else effector for effector in effectors]
    return tuple(joint for joint in dict.fromkeys(joint_names(robot, chains)) if robot.unit(joint) != "1")


def columns_of(robot: NaoModel, effectors: Sequence[str]) -> list[int]:
    """Return the columns of these joints in q; LHipYawPitch and RHipYawPitch share one."""
    names = [LEFT_HIP if joint == RIGHT_HIP else joint for joint in joints_of(robot, effectors)]
    return [robot.joint_names.index(name) for name in dict.fromkeys(names)]


def anywhere(robot: NaoModel, target: LimbTarget, q: Floats) -> LimbSolution:
    """Return joint values for one limb: of the solution nearest to the current ones, or else of the nearest pose.

    Poses of arms and legs, positions of hands and orientations of the head are solved in closed form, other masks by
    descents from the current joint values and from random ones.
    """
    near = descend(robot, target, q)
    if near.missing <= MET:
        return near
    columns = columns_of(robot, [target.frame])
    starts = np.tile(q, (_STARTS, 1))
    starts[:, columns] = robot.random(np.random.default_rng(0), _STARTS)[:, columns]
    closed = _closed_form(robot, target, q)
    if closed is not None and np.isfinite(closed).all():  # a solution for the torso's current pose only
        starts[0] = closed
    if closed is not None and target.reference == TORSO:
        starts = starts[: int(np.isfinite(closed).all())]
    others = [descend(robot, target, robot.clamp(start)) for start in starts]
    reached = [one for one in others if one.missing <= MET]
    if reached:
        return min(reached, key=lambda one: float(np.abs(one.q - q).max()))
    return min(near, *others, key=lambda one: one.missing)


def torso_over_feet(robot: NaoModel, T_world_torso: Floats, T_world_feet: Floats, q: Floats) -> LimbSolution:
    """Return joint values near q for fixed poses of the left and right foot (2, 4, 4) and the nearest torso pose.

    The yaw of the torso is adapted, because one motor drives both hips. If limits exclude that pose, the torso goes to
    the nearest one for which both feet hold. `missing` is the torso's error, its yaw included; infinite if a foot does
    not reach its pose.
    """
    q_legs, adapted = _with_fitting_yaw(robot, T_world_torso, T_world_feet, q)
    if q_legs is None or not robot.within_limits(q_legs):
        # One descent with the feet as constraints.
        feet = dict(zip("LR", T_world_feet, strict=True))
        solution = ik.whole_body(robot, {}, feet=feet, torso=adapted, weights={"posture": 0.0}, near=q, restarts=0)
        if not np.isfinite(solution.q).all():
            return LimbSolution(np.array(q), np.inf)
        q_legs, adapted = solution.q, solution.torso
    turn = log(T_world_torso[:3, :3].T @ adapted[:3, :3])
    away = T_world_torso[:3, 3] - adapted[:3, 3]
    return LimbSolution(q_legs, float(np.linalg.norm([away, RADIAN * turn])))


def _with_fitting_yaw(
    robot: NaoModel, T_world_torso: Floats, T_world_feet: Floats, q: Floats
) -> tuple[Floats | None, Floats]:
    """Return joint values for both feet, regardless of limits, and the torso with the nearest yaw that fits the hips.

    If a leg is too short, return None and the torso as it is.
    """
    left, right = T_world_feet
    target = T_world_torso
    for _ in range(_MAX_CORRECTIONS):
        # A batch of one uses the compiled kernel: in Python, a tick of 10 ms would take longer than 10 ms to compute.
        solution = ik.legs(robot, left[None], right, base="floating", torso=target, free="yaw", near=q, limits="ignore")
        if not np.all(solution.success):
            return None, T_world_torso
        torso = np.asarray(solution.torso)[0]
        # The solver adapts the yaw about the middle of the hips, which displaces a leaning torso: correct its position.
        six = position6d(T_world_torso)
        six[5] = position6d(torso)[5]
        target = pose(six)
        if np.abs(target[:3, 3] - torso[:3, 3]).max() < _IN_PLACE:
            break
    return solution.q[0], torso


def _closed_form(robot: NaoModel, target: LimbTarget, q: Floats) -> Floats | None:
    T, frame, axes = target.T_reference_target, target.frame, target.mask
    if target.reference != TORSO:
        T = robot.fk(q, target.reference) @ T
    if frame in ARMS and axes in (AxisMask.ALL, AxisMask.VEL):
        return ik.arm(robot, frame[0], T if axes == AxisMask.ALL else T[:3, 3], near=q).q
    if frame in LEGS and axes == AxisMask.ALL:
        return ik.leg(robot, frame[0], T, near=q).q
    if frame == "Head" and axes in (AxisMask.ROT, AxisMask.ALL):
        return ik.head(robot, T[:3, :3], near=q).q
    return None
