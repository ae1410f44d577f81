"""Compare numerical inverse kinematics with Pinocchio's damped least squares, and with pink if it is installed.

All contenders get the same reachable poses of random configurations inside the limits, start from the same
configuration, and must reach position and rotation to 1e-6 m and rad inside the limits, including coupled ones. A
solution outside the limits counts as a failure. Pinocchio's loop is that of its documentation, with steps of full
length, clipped to the joint ranges; "restarts" starts again up to 30 times at random configurations. Times are per
target, including failures, the best of several rounds; only their ratios are significant.

Example:
    python benchmarks/bench_ik_numeric.py
    python benchmarks/bench_ik_numeric.py --targets 200 --robots nao --json
"""

from __future__ import annotations

import argparse
import contextlib
import json
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

import nao_kin as nk
from nao_kin.ik import numeric

Floats = NDArray[np.float64]
Solver = Callable[[Floats, Floats], Floats]

TOLERANCE = 1e-6
STEPS, RESTARTS, DAMPING = 100, 30, 1e-3
# The largest number of targets for contenders that solve one target at a time.
LOOPED = 200
FRAMES = {"nao": ("Head", "LArm", "LLeg"), "romeo": ("l_wrist", "r_sole"), "panda": ("panda_link8",)}


@dataclass(frozen=True)
class Timing:
    """The result of one contender.

    Attributes:
        robot, frame, contender: the measured case.
        success: share of the targets reached inside the limits.
        microseconds: for each target.
        ratio: time as a multiple of that of this library's batch.
    """

    robot: str
    frame: str
    contender: str
    success: float
    microseconds: float
    ratio: float


def damped_least_squares(robot: nk.RobotModel, frame: str, restarts: int) -> Solver:
    """Pinocchio's documented loop, δ = −Jᵀ (J Jᵀ + λ)⁻¹ log(T⁻¹ T_target), one target after the other."""
    model, data, frame_id = robot.model, robot.model.createData(), robot.frame_table[frame]
    low, high = model.lowerPositionLimit, model.upperPositionLimit
    starts = robot.random(0, max(1, restarts))

    def solved(target: pin.SE3, q: Floats) -> Floats | None:
        for _ in range(STEPS):
            pin.forwardKinematics(model, data, q)
            error = pin.updateFramePlacement(model, data, frame_id).actInv(target)
            e = pin.log6(error).vector
            if np.linalg.norm(e) < 0.5 * TOLERANCE:
                return q if robot.within_limits(q) else None
            J = -pin.Jlog6(error.inverse()) @ pin.computeFrameJacobian(model, data, q, frame_id, pin.LOCAL)
            step = -J.T @ np.linalg.solve(J @ J.T + DAMPING**2 * np.eye(6), e)
            q = np.clip(pin.integrate(model, q, step), low, high)
        return None

    def solve(T: Floats, reference: Floats) -> Floats:
        answers = np.tile(reference, (len(T), 1))
        for k, target in enumerate(T):
            for start in (reference, *starts[:restarts]):
                found = solved(pin.SE3(target), start.copy())
                if found is not None:
                    answers[k] = found
                    break
        return answers

    return solve


def with_pink(robot: nk.RobotModel, frame: str) -> Solver:
    """Quadratic programs of pink with configuration limits; raises ImportError if pink is not installed."""
    import pink
    from pink.limits import ConfigurationLimit
    from pink.tasks import FrameTask

    name = robot.model.frames[robot.frame_table[frame]].name
    limits = [ConfigurationLimit(robot.model, config_limit_gain=1.0)]

    def solve(T: Floats, reference: Floats) -> Floats:
        answers = np.empty((len(T), robot.nq))
        for k, target in enumerate(T):
            configuration = pink.Configuration(robot.model, robot.model.createData(), reference)
            task = FrameTask(name, position_cost=1.0, orientation_cost=0.1, lm_damping=1e-2)
            task.set_target(pin.SE3(target))
            for _ in range(STEPS):
                if np.linalg.norm(task.compute_error(configuration)) < 0.5 * TOLERANCE:
                    break
                speeds = pink.solve_ik(
                    configuration, [task], 1.0, solver="daqp", limits=limits, damping=1e-9, safety_break=False
                )
                configuration.integrate_inplace(speeds, 1.0)
            answers[k] = configuration.q
        return answers

    return solve


def ours(robot: nk.RobotModel, frame: str, restarts: int = RESTARTS) -> Solver:
    """This library, all targets in one call."""
    return lambda T, q: numeric(robot, frame, T, near=q, restarts=restarts, tolerance=0.5 * TOLERANCE).q


def ours_one_by_one(robot: nk.RobotModel, frame: str) -> Solver:
    """This library, one call for each target."""
    solve = ours(robot, frame)
    return lambda T, q: np.array([solve(target, q) for target in T])


def success_rate(robot: nk.RobotModel, frame: str, q: Floats, T: Floats) -> float:
    """Return the share of targets that are reached inside the limits."""
    poses = robot.fk(q, frame)
    near = np.linalg.norm(poses[:, :3, 3] - T[:, :3, 3], axis=-1) <= TOLERANCE
    turn = nk.rotations.log(poses[:, :3, :3].swapaxes(-1, -2) @ T[:, :3, :3])
    return float((near & (np.linalg.norm(turn, axis=-1) <= TOLERANCE) & robot.within_limits(q)).mean())


def measure(name: str, robot: nk.RobotModel, frame: str, targets: int, rounds: int) -> list[Timing]:
    """Time all contenders in turns."""
    T = robot.fk(robot.random(1, targets), frame)
    reference = robot.clamp(robot.neutral())
    contenders: dict[str, Solver] = {
        "nao_kin, batch": ours(robot, frame),
        "nao_kin, batch, no restarts": ours(robot, frame, 0),
        "nao_kin, one by one": ours_one_by_one(robot, frame),
        "Pinocchio loop": damped_least_squares(robot, frame, 0),
        "Pinocchio loop, restarts": damped_least_squares(robot, frame, RESTARTS),
    }
    with contextlib.suppress(ImportError):
        contenders["pink"] = with_pink(robot, frame)
    best: dict[str, float] = {}
    success: dict[str, float] = {}
    for _ in range(rounds):
        for contender, solve in contenders.items():
            mine = T if "batch" in contender else T[:LOOPED]
            started = time.perf_counter()
            q = solve(mine, reference)
            taken = (time.perf_counter() - started) / len(mine)
            best[contender] = min(best.get(contender, np.inf), taken)
            success[contender] = success_rate(robot, frame, q, mine)
    first = best["nao_kin, batch"]
    return [Timing(name, frame, what, success[what], 1e6 * taken, taken / first) for what, taken in best.items()]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--targets", type=int, default=2000, help="poses of each frame (default: 2000)")
    parser.add_argument("--rounds", type=int, default=3, help="rounds; the best one is used (default: 3)")
    parser.add_argument("--robots", nargs="+", choices=FRAMES, default=list(FRAMES), help="default: all")
    parser.add_argument("--json", action="store_true", help="one JSON object for each row")
    arguments = parser.parse_args()
    for name in arguments.robots:
        robot: Any = nk.load_nao() if name == "nao" else nk.load_robot(name)
        for frame in FRAMES[name]:
            for row in measure(name, robot, frame, arguments.targets, arguments.rounds):
                if arguments.json:
                    print(json.dumps(asdict(row), ensure_ascii=False))
                else:
                    print(
                        f"{row.robot:6} {row.frame:12} {row.contender:28} {100 * row.success:6.1f} % "
                        f"{row.microseconds:10.1f} µs  × {row.ratio:.2f}",
                        flush=True,
                    )


if __name__ == "__main__":
    main()
