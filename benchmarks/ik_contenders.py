"""Other solvers for the joint values of a limb: Pinocchio's damped least squares, pink, TRAC-IK, EAIK.

Each is a function of poses (n, 4, 4) that returns configurations (n, nq), NaN where it found no solution. It solves one
target after the other, as these tools are called from Python. All start in the middle of the limits.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

import nao_kin as nk

Floats = NDArray[np.float64]
Solver = Callable[[Floats], Floats]

TOLERANCE = 1e-6
STEPS, DAMPING = 100, 1e-3


def damped_least_squares(robot: nk.RobotModel, frame: str, limb: nk.ik.IKResult, restarts: int = 0) -> Solver:
    """δ = −Jᵀ (J Jᵀ + λ²)⁻¹ log(T⁻¹ T_target), the loop of Pinocchio's documentation, on a model of the limb alone.

    All other joints are locked, which minimises the time of a step; joints are clipped to their ranges.
    """
    rest, columns = robot.clamp(robot.neutral()), list(limb.columns)
    whole = pin.buildModelFromUrdf(str(robot.urdf_path))  # each hip with a coordinate of its own
    others = [i for i in range(1, whole.njoints) if whole.names[i] not in limb.joints]
    model = pin.buildReducedModel(whole, others, pin.neutral(whole))
    data, frame_id = model.createData(), model.getFrameId(robot.model.frames[robot.frame_table[frame]].name)
    low, high = model.lowerPositionLimit, model.upperPositionLimit
    middle, damping = 0.5 * (low + high), DAMPING**2 * np.eye(6)
    starts = [middle, *np.random.default_rng(0).uniform(low, high, (restarts, model.nq))]

    def solved(target: pin.SE3, q: Floats) -> Floats | None:
        for _ in range(STEPS):
            pin.forwardKinematics(model, data, q)
            error = pin.updateFramePlacement(model, data, frame_id).actInv(target)
            e = pin.log6(error).vector
            if e @ e < TOLERANCE**2:
                return q
            J = -pin.Jlog6(error.inverse()) @ pin.computeFrameJacobian(model, data, q, frame_id, pin.LOCAL)
            q = np.minimum(np.maximum(q - J.T @ np.linalg.solve(J @ J.T + damping, e), low), high)
        return None

    def solve(T: Floats) -> Floats:
        answers = np.full((len(T), robot.nq), np.nan)
        for k, target in enumerate(map(pin.SE3, T)):
            for start in starts:
                found = solved(target, start)
                if found is not None:
                    answers[k] = rest
                    answers[k, columns] = found
                    break
        return answers

    return solve


def with_pink(robot: nk.RobotModel, frame: str, limb: nk.ik.IKResult) -> Solver:
    """Quadratic programs of pink with configuration limits; raises ImportError if pink is not installed."""
    import pink
    from pink.limits import ConfigurationLimit
    from pink.tasks import FrameTask

    name = robot.model.frames[robot.frame_table[frame]].name
    limits = [ConfigurationLimit(robot.model, config_limit_gain=1.0)]
    start = _middle(robot, list(limb.columns))

    def solve(T: Floats) -> Floats:
        answers = np.full((len(T), robot.nq), np.nan)
        for k, target in enumerate(T):
            configuration = pink.Configuration(robot.model, robot.model.createData(), start)
            task = FrameTask(name, position_cost=1.0, orientation_cost=0.1, lm_damping=1e-2)
            task.set_target(pin.SE3(target))
            for _ in range(STEPS):
                if np.linalg.norm(task.compute_error(configuration)) < TOLERANCE:
                    answers[k] = configuration.q
                    break
                speeds = pink.solve_ik(
                    configuration, [task], 1.0, solver="daqp", limits=limits, damping=1e-9, safety_break=False
                )
                configuration.integrate_inplace(speeds, 1.0)
        return answers

    return solve


def with_trac_ik(robot: nk.RobotModel, frame: str, limb: nk.ik.IKResult) -> Solver:
    """TRAC-IK for at most 5 ms, its default; raises ImportError if it is not installed."""
    from trac_ik import TracIK

    solver: Any = TracIK(robot.tree.root, frame, str(robot.urdf_path), epsilon=TOLERANCE)
    rest, columns = robot.clamp(robot.neutral()), list(limb.columns)
    middle = _middle(robot, columns)[columns]

    def solve(T: Floats) -> Floats:
        answers = np.full((len(T), robot.nq), np.nan)
        for k, target in enumerate(T):
            found = solver.ik(target[:3, 3].copy(), target[:3, :3].copy(), middle)
            if found is not None:
                answers[k] = rest
                answers[k, columns] = found
        return answers

    return solve


def with_eaik(robot: nk.RobotModel, frame: str, limb: nk.ik.IKResult) -> Solver:
    """All branches from EAIK, verified by `nk.ik.analytic`; raises ImportError if EAIK is not installed."""
    nk.ik.analytic(robot, frame, robot.fk(robot.neutral(), frame))
    return lambda T: nk.ik.analytic(robot, frame, T).q


CONTENDERS: dict[str, Callable[[nk.RobotModel, str, nk.ik.IKResult], Solver]] = {
    "Pinocchio, damped least squares": damped_least_squares,
    "the same, 30 restarts": lambda robot, frame, limb: damped_least_squares(robot, frame, limb, 30),
    "pink": with_pink,
    "TRAC-IK": with_trac_ik,
    "EAIK (nk.ik.analytic)": with_eaik,
}


def success_rate(robot: nk.RobotModel, frame: str, q: Floats, T: Floats) -> float:
    """Return the share of targets reached to 1e-6 m and rad inside all limits, including coupled ones."""
    found = np.logical_not(np.isnan(q).any(axis=-1))
    q = np.where(found[:, None], q, robot.neutral())
    poses = robot.fk(q, frame)
    near = np.linalg.norm(poses[:, :3, 3] - T[:, :3, 3], axis=-1) <= 2.0 * TOLERANCE
    turn = nk.rotations.log(poses[:, :3, :3].swapaxes(-1, -2) @ T[:, :3, :3])
    inside = np.asarray(robot.within_limits(q))
    return float(np.mean(found & near & (np.linalg.norm(turn, axis=-1) <= 2.0 * TOLERANCE) & inside))


def _middle(robot: nk.RobotModel, columns: list[int]) -> Floats:
    q = robot.clamp(robot.neutral())
    q[columns] = 0.5 * (robot.lower + robot.upper)[columns]
    return robot.clamp(q)
