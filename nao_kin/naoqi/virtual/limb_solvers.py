"""Joint values for one effector of Cartesian control: descents for any axes, and closed forms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nao_kin import ik
from nao_kin._core.arrays import Floats
from nao_kin.naoqi.names import joint_names
from nao_kin.naoqi.spaces import LEGS, TORSO, AxisMask, controlled_axes, pose, position6d
from nao_kin.robot import NaoModel, RobotModel
from nao_kin.rotations import log

# --- Joint values for targets that control some axes only.
#
# NAOqi solves Cartesian control with the pseudo-inverse of the Jacobian of the controlled axes, from cycle to cycle.
# So does this module: damped least squares from the joint values of the cycle before, which keeps joint motion along a
# path small.

# One radian has the weight of 0.1 m.
RADIAN = 0.1
_MAX_STEPS = 60
_MET = 1e-10
_SMALLEST_STEP = 1e-11
_DAMPING, _MAX_DAMPING = 1e-6, 1e3


@dataclass(frozen=True, eq=False)
class LimbTarget:
    """The target pose of a frame, relative to the torso or to the sole of the standing foot.

    Attributes:
        frame: the robot's name of the frame.
        T_reference_target: shape (4, 4).
        axes: the controlled ones of x, y, z, wx, wy, wz, along the axes of the space, shape (6,).
        R_reference_space: the rotation of the space, shape (3, 3).
        reference: the frame that stays in place: "Torso", or a foot, whose leg then moves too.
    """

    frame: str
    T_reference_target: Floats
    axes: NDArray[np.bool_]
    R_reference_space: Floats
    reference: str = "Torso"

    def errors(self, T_reference_frame: Floats) -> Floats:
        """Errors along the controlled axes: metres, and radians times `RADIAN`, shape (k,)."""
        R = self.R_reference_space.T
        away = R @ (self.T_reference_target[:3, 3] - T_reference_frame[:3, 3])
        turn = R @ log(self.T_reference_target[:3, :3] @ T_reference_frame[:3, :3].T)
        return np.concatenate([away, RADIAN * turn])[self.axes]

    def missing(self, robot: RobotModel, q: Floats) -> Floats:
        """Return the `errors` in a configuration."""
        return self.errors(robot.fk(q, self.frame, reference=self.reference))

    def rows(self, robot: RobotModel, q: Floats) -> Floats:
        """Return the rows of the Jacobian for the errors, shape (k, nv)."""
        J = robot.jacobian(q, self.frame)
        if self.reference != "Torso":
            T_torso_frame, T_torso_reference = robot.fk(q, [self.frame, self.reference])
            J_reference, away = robot.jacobian(q, self.reference), T_torso_frame[:3, 3] - T_torso_reference[:3, 3]
            # The velocity of a point relative to a moving reference is v − v_reference − ω_reference × away.
            carried = J_reference[:3] - np.cross(away, J_reference[3:], axis=0)
            R_reference_torso = T_torso_reference[:3, :3].T
            J = np.concatenate([R_reference_torso @ (J[:3] - carried), R_reference_torso @ (J[3:] - J_reference[3:])])
        R = self.R_reference_space.T
        return np.concatenate([R @ J[:3], RADIAN * (R @ J[3:])])[self.axes]


@dataclass(frozen=True, eq=False)
class LimbSolution:
    """A configuration inside the limits, shape (nq,), and the norm of its errors: metres, radians times `RADIAN`."""

    q: Floats
    missing: float


def descend(robot: RobotModel, target: LimbTarget, columns: Sequence[int], q: Floats) -> LimbSolution:
    """Return joint values inside all limits that bring a frame to its target, or the end of a descent towards it.

    `columns` are the indices in q of the joints that may move; q, shape (nq,), is inside the limits.
    """
    free = np.array(columns)
    best, e, damping = np.array(q), target.missing(robot, q), _DAMPING
    for _ in range(_MAX_STEPS):
        if np.abs(e).max(initial=0.0) < _MET or damping > _MAX_DAMPING:
            break
        step = _step(robot, target.rows(robot, best)[:, free], e, free, best, damping)
        if np.abs(step).max(initial=0.0) < _SMALLEST_STEP:
            break
        trial = best.copy()
        trial[free] += step
        trial = robot.clamp(trial)
        trial_errors = target.missing(robot, trial)
        if trial_errors @ trial_errors < e @ e:
            best, e, damping = trial, trial_errors, max(0.1 * damping, 1e-12)
        else:
            damping *= 10.0
    return LimbSolution(best, float(np.linalg.norm(e)))


def _step(robot: RobotModel, J: Floats, e: Floats, free: NDArray[np.int64], q: Floats, damping: float) -> Floats:
    """Return Jᵀ (J Jᵀ + λ 1)⁻¹ e over the joints that it does not move out of a limit, coupled limits included."""
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


# --- The six effectors of Cartesian control, each with its joints and its solvers.

ARMS = ("LArm", "RArm")
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
    names = ["LHipYawPitch" if joint == "RHipYawPitch" else joint for joint in joints_of(robot, effectors)]
    return [robot.joint_names.index(name) for name in dict.fromkeys(names)]


def near(robot: NaoModel, target: LimbTarget, q: Floats) -> LimbSolution:
    """Return joint values near the current ones, for following a path."""
    return descend(robot, target, columns_of(robot, [target.frame]), q)


def anywhere(robot: NaoModel, target: LimbTarget, q: Floats) -> LimbSolution:
    """Return joint values for one limb: the solution nearest to the current ones; without a solution, the nearest pose.

    Poses of arms and legs, positions of hands and orientations of the head are solved in closed form, other masks by
    descents from the current joints and from random ones.
    """
    found = near(robot, target, q)
    if found.missing <= MET:
        return found
    closed = _closed_form(robot, target, q)
    is_finite = closed is not None and bool(np.isfinite(closed).all())
    if closed is not None and target.reference == TORSO:
        missing = float(np.linalg.norm(target.missing(robot, closed))) if is_finite else np.inf
        return min(found, LimbSolution(closed, missing), key=lambda one: one.missing)
    columns = columns_of(robot, [target.frame])
    starts = np.tile(q, (_STARTS, 1))
    starts[:, columns] = robot.random(np.random.default_rng(0), _STARTS)[:, columns]
    if closed is not None and is_finite:  # it is a solution for the torso's current pose
        starts[0, columns] = closed[columns]
    others = [descend(robot, target, columns, robot.clamp(start)) for start in starts]
    reached = [one for one in others if one.missing <= MET]
    if reached:
        return min(reached, key=lambda one: float(np.abs(one.q - q).max()))
    return min(found, *others, key=lambda one: one.missing)


def torso_over_feet(robot: NaoModel, T_world_torso: Floats, T_world_feet: Floats, q: Floats) -> LimbSolution:
    """Solve both legs for a torso pose (4, 4) with free yaw, and the feet, left and right, in place (2, 4, 4).

    `missing` is the torso's error, its yaw included; infinite if a foot is not in place.
    """
    left, right = T_world_feet
    target_torso = T_world_torso
    for _ in range(_MAX_CORRECTIONS):
        # A batch of one runs compiled; interpreted, a tick would take longer than it lasts.
        found = ik.legs(robot, left[None], right, base="floating", torso=target_torso, free="yaw", reference=q)
        if not np.all(found.success):
            return LimbSolution(found.q[0] if np.isfinite(found.q).all() else np.array(q), np.inf)
        torso = np.asarray(found.torso)[0]
        # The yaw is relaxed about the middle of the hips, which displaces a leaning torso: correct its position.
        six = position6d(T_world_torso)
        six[5] = position6d(torso)[5]
        target_torso = pose(six)
        if np.abs(target_torso[:3, 3] - torso[:3, 3]).max() < _IN_PLACE:
            break
    target = LimbTarget(TORSO, T_world_torso, np.ones(6, dtype=np.bool_), np.eye(3))
    return LimbSolution(found.q[0], float(np.linalg.norm(target.errors(torso))))


def completed(T_space_wanted: Floats, T_space_now: Floats, mask: int) -> Floats:
    """Return a pose with the controlled coordinates of one pose and the others of another, in terms of Position6D."""
    six = np.where(controlled_axes(mask), position6d(T_space_wanted), position6d(T_space_now))
    return pose(six)


def _closed_form(robot: NaoModel, target: LimbTarget, q: Floats) -> Floats | None:
    axes = int(np.dot(target.axes, 1 << np.arange(6)))
    T, frame = target.T_reference_target, target.frame
    if target.reference != TORSO:
        T = robot.fk(q, target.reference) @ T
    if frame in ARMS and axes in (AxisMask.ALL, AxisMask.VEL):
        return ik.arm(robot, frame[0], T if axes == AxisMask.ALL else T[:3, 3], reference=q).q
    if frame in LEGS and axes == AxisMask.ALL:
        return ik.leg(robot, frame[0], T, reference=q).q
    if frame == "Head" and axes in (AxisMask.ROT, AxisMask.ALL):
        return ik.head(robot, T[:3, :3], reference=q).q
    return None
