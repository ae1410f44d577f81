"""Compare whole-body poses with pink, if it is installed, on the same feasible targets.

The targets come from random configurations inside the limits that stand on flat feet with the centre of mass above
them. Both contenders get both hands and the feet as full poses, and the same starts: neutral, and a configuration
0.1 rad from the one that defines the targets. In pink, feet and hands are frame tasks, the feet with a hundred times
the weight; it respects the ranges of the joints, and the shared hip motor as far as its model does, but neither the
centre of mass nor the coupled limits. A pose counts as found if hands and feet are reached to 1e-6 m and rad inside all
limits. Times are of single calls, the best of several rounds; medians and means over the poses include failures.

Example:
    python benchmarks/bench_whole_body.py
    python benchmarks/bench_whole_body.py --poses 20 --json
"""

from __future__ import annotations

import argparse
import contextlib
import json
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

import nao_kin as nk

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "_helpers"))
from whole_body_samples import Standing, standing_poses  # type: ignore[import-not-found]

Floats = NDArray[np.float64]
# Maps pose i and a start to a configuration with a floating base; the first seven numbers are the base.
Solver = Callable[[int, Floats], Floats]

TOLERANCE = 1e-6
STEPS = 100
HANDS = ("LArm", "RArm")
FEET = ("LLeg", "RLeg")


@dataclass(frozen=True)
class Timing:
    """The result of one contender.

    Attributes:
        feet, start, contender: the measured case.
        success: share of the poses found.
        median_ms: of a call.
        mean_ms: of a call.
        ratio: mean as a multiple of this library's.
    """

    feet: str
    start: str
    contender: str
    success: float
    median_ms: float
    mean_ms: float
    ratio: float


def ours(robot: nk.RobotModel, poses: Standing, both: bool, com: str | None, restarts: int) -> Solver:
    """This library: the feet are satisfied exactly, the hands are targets."""
    hands = {hand: poses.pose(robot_fixed(), hand) for hand in HANDS}

    def solve(i: int, start: Floats) -> Floats:
        feet = {"L": poses.feet[i, 0]} | ({"R": poses.feet[i, 1]} if both else {})
        targets = {hand: T[i] for hand, T in hands.items()} | ({} if both else {"RLeg": poses.feet[i, 1]})
        return nk.ik.whole_body(robot, targets, feet=feet, com=com, near=start, restarts=restarts).q

    return solve


def robot_fixed() -> nk.NaoModel:
    """Return the robot with a fixed trunk."""
    return nk.load_nao()


def with_pink(robot: nk.RobotModel, poses: Standing) -> Solver:
    """Quadratic programs of pink; raises ImportError if pink is not installed."""
    import daqp  # noqa: F401
    import pink
    from pink.limits import ConfigurationLimit
    from pink.tasks import FrameTask

    wanted = {hand: poses.pose(robot_fixed(), hand) for hand in HANDS}
    wanted |= {foot: poses.feet[:, k] for k, foot in enumerate(FEET)}
    names = {frame: robot.model.frames[robot.frame_table[frame]].name for frame in wanted}
    limits = [ConfigurationLimit(robot.model, config_limit_gain=1.0)]

    def solve(i: int, start: Floats) -> Floats:
        configuration = pink.Configuration(robot.model, robot.model.createData(), start)
        tasks = []
        for frame, T in wanted.items():
            weight = 100.0 if frame in FEET else 1.0
            task = FrameTask(names[frame], position_cost=weight, orientation_cost=0.1 * weight, lm_damping=1e-2)
            task.set_target(pin.SE3(T[i]))
            tasks.append(task)
        for _ in range(STEPS):
            if max(np.linalg.norm(task.compute_error(configuration)) for task in tasks) < 0.5 * TOLERANCE:
                break
            # With a damping of 1e-9 and these weights, daqp ends short of the targets.
            speeds = pink.solve_ik(
                configuration, tasks, 1.0, solver="daqp", limits=limits, damping=1e-6, safety_break=False
            )
            configuration.integrate_inplace(speeds, 1.0)
        return np.asarray(configuration.q)

    return solve


def is_found(robot: nk.RobotModel, poses: Standing, q: Floats) -> NDArray[np.bool_]:
    """Return whether hands and feet are reached inside the limits, shape (n,)."""
    found: NDArray[np.bool_] = np.logical_not(np.isnan(q).any(axis=-1))
    q = np.where(found[:, None], q, robot.neutral())
    wanted = [poses.pose(robot_fixed(), hand) for hand in HANDS] + [poses.feet[:, k] for k in range(2)]
    for frame, T in zip((*HANDS, *FEET), wanted, strict=True):
        difference = robot.fk(q, frame) - T
        found &= np.linalg.norm(difference[:, :3, 3], axis=-1) <= TOLERANCE
        found &= np.linalg.norm(difference[:, :3, :3], axis=(-2, -1)) <= np.sqrt(2.0) * TOLERANCE
    return np.asarray(found & robot.within_limits(q))


def starts_of(robot: nk.RobotModel, poses: Standing) -> dict[str, Floats]:
    """Return the starts: neutral above the left foot, and near the solution; shape (n, nq)."""
    rng, fixed = np.random.default_rng(1), robot_fixed()
    joints = {
        "neutral": np.repeat(fixed.clamp(fixed.neutral())[None], len(poses.q), axis=0),
        "near": fixed.clamp(poses.q + rng.uniform(-0.1, 0.1, poses.q.shape)),
    }
    starts = {}
    for name, q in joints.items():
        T = poses.feet[:, 0] @ np.linalg.inv(fixed.fk(q, "LLeg"))
        turn = nk.rotations.quat_to_xyzw(nk.rotations.quat_from_matrix(T[:, :3, :3]))
        starts[name] = np.concatenate([T[:, :3, 3], turn, q], axis=1)
    return starts


def measure(both: bool, count: int, rounds: int) -> list[Timing]:
    """Time all contenders in turns."""
    robot = nk.load_nao(base="floating")
    poses = standing_poses(robot_fixed(), count, both=both)
    feet = "both" if both else "one"
    rows = []
    for start, starts in starts_of(robot, poses).items():
        contenders = {
            "nao_kin": ours(robot, poses, both, None, 50),
            "nao_kin, com above the feet": ours(robot, poses, both, "support", 50),
            "nao_kin, com, no restarts": ours(robot, poses, both, "support", 0),
        }
        with contextlib.suppress(ImportError):
            contenders["pink"] = with_pink(robot, poses)
        times = {name: np.full(count, np.inf) for name in contenders}
        success = {}
        for _ in range(rounds):
            for name, solve in contenders.items():
                q = np.empty((count, robot.nq))
                for i in range(count):
                    began = time.perf_counter()
                    q[i] = solve(i, starts[i])
                    times[name][i] = min(times[name][i], time.perf_counter() - began)
                success[name] = float(is_found(robot, poses, q).mean())
        first = times["nao_kin"].mean()
        for name, taken in times.items():
            median, mean = 1e3 * np.median(taken), 1e3 * taken.mean()
            ratio = float(taken.mean() / first)
            rows.append(Timing(feet, start, name, success[name], float(median), float(mean), ratio))
    return rows


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--poses", type=int, default=100, help="poses of each kind (default: 100)")
    parser.add_argument("--rounds", type=int, default=3, help="rounds; the best one is used (default: 3)")
    parser.add_argument("--json", action="store_true", help="one JSON object for each row")
    arguments = parser.parse_args()
    nk.ik.whole_body(robot_fixed(), {})  # compiles the kernel, or loads it from the cache
    for both in (True, False):
        for row in measure(both, arguments.poses, arguments.rounds):
            if arguments.json:
                print(json.dumps(asdict(row)))
            else:
                print(
                    f"{row.feet:4} feet from {row.start:7} {row.contender:28} {100 * row.success:6.1f} %  "
                    f"median {row.median_ms:7.2f} ms  mean {row.mean_ms:7.2f} ms  × {row.ratio:.2f}",
                    flush=True,
                )


if __name__ == "__main__":
    main()
