"""Joint values for effectors of which only some axes are asked for, from where the joints are.

NAOqi solves Cartesian control by the pseudo-inverse of the Jacobian of the controlled axes, from cycle to cycle. So
does this: damped least squares from the joint values of before, so that along a path joints move as little as they can.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nao_kin._common.arrays import Floats
from nao_kin.robot import RobotModel
from nao_kin.rotations import log

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


def descend(robot: RobotModel, targets: Sequence[Target], columns: Sequence[int], q: Floats) -> Solution:
    """The joint values near by that bring frames to their targets, inside all limits.

    Where the targets cannot be met from here, these are the nearest that steps downhill lead to.

    Args:
        robot: with a fixed base.
        targets: what is asked for.
        columns: the joints that may move, as places in q.
        q: where to begin, inside the limits, shape (nq,).
    """
    free = np.array(columns)
    best, e = np.array(q), _errors(robot, targets, q)
    damping = _DAMPING
    for _ in range(_MOST_STEPS):
        if float(np.abs(e).max(initial=0.0)) < _MET or damping > _MOST_DAMPING:
            break
        J = np.concatenate([target.rows(robot, best) for target in targets])[:, free]
        step = _step(robot, J, e, free, best, damping)
        if float(np.abs(step).max(initial=0.0)) < _SMALLEST_STEP:
            break
        candidate = best.copy()
        candidate[free] += step
        candidate = robot.clamp(candidate)
        left = _errors(robot, targets, candidate)
        if left @ left < e @ e:
            best, e, damping = candidate, left, max(0.1 * damping, 1e-12)
        else:
            damping *= 10.0
    return Solution(best, float(np.linalg.norm(e)))


def _errors(robot: RobotModel, targets: Sequence[Target], q: Floats) -> Floats:
    return np.concatenate([target.missing(robot, q) for target in targets])


def _step(robot: RobotModel, J: Floats, e: Floats, free: NDArray[np.int64], q: Floats, damping: float) -> Floats:
    """Jᵀ (J Jᵀ + λ 1)⁻¹ e over the joints that are not pressed against a limit by it."""
    moving = np.ones(len(free), dtype=np.bool_)
    step = np.zeros(len(free))
    for _ in range(len(free)):
        active = J[:, moving]
        step = np.zeros(len(free))
        step[moving] = active.T @ np.linalg.solve(active @ active.T + damping * np.eye(len(e)), e)
        pressed = _at_limits(robot, q, free, step) & moving
        if not pressed.any():
            break
        moving &= ~pressed
    return step


def _at_limits(robot: RobotModel, q: Floats, free: NDArray[np.int64], step: Floats) -> NDArray[np.bool_]:
    """Which joints stand at a limit, coupled ones included, that the step would take them beyond."""
    nudged = q.copy()
    nudged[free] += np.sign(step) * 1e-9
    return np.asarray((step != 0.0) & (np.abs(robot.clamp(nudged)[free] - q[free]) < 1e-10))
