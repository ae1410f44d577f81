"""Inverse kinematics: the closed forms beside damped least squares with Pinocchio, on the same targets.

Targets are the poses of random configurations inside the limits. Damped least squares starts from the middle of the
limits, clamps to them after each step, and has 100 steps (Pinocchio's own example of inverse kinematics, with limits).

Example:
    python benchmarks/bench_ik.py
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin

import nao_kin as nk
from nao_kin.ik import IKResult

# A leg, in a batch, inside the limits and verified, on all cores; and one call with all checks [µs].
LIMIT_BATCH, LIMIT_ONE = 0.5, 30.0
_DAMPING, _STEPS, _REACHED = 1e-6, 100, 1e-6


def best_seconds(run: Callable[[], Any], rounds: int) -> float:
    """The best time of a call [s]."""
    times = []
    for _ in range(rounds):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return min(times)


def damped_least_squares(nao: nk.NaoModel, frame: str, columns: list[int], T: Any) -> bool:
    """Whether Pinocchio's Jacobians lead to a pose from the middle of the limits, in Python as its example has it."""
    model, data = nao.model, nao.model.createData()
    frame_id = nao.frame_ids([frame])[0]
    target = pin.SE3(T)
    q = nao.clamp(0.5 * (nao.lower + nao.upper))
    for _ in range(_STEPS):
        pin.framesForwardKinematics(model, data, q)
        error = pin.log6(data.oMf[frame_id].actInv(target)).vector
        if np.linalg.norm(error) < _REACHED:
            return True
        J = pin.computeFrameJacobian(model, data, q, frame_id, pin.LOCAL)[:, columns]
        q[columns] += J.T @ np.linalg.solve(J @ J.T + _DAMPING * np.eye(6), error)
        q[columns] = np.clip(q[columns], nao.lower[columns], nao.upper[columns])
    return False


def figures(limb: str, solve: Callable[..., IKResult], targets: int, rounds: int) -> dict[str, Any]:
    """Times per target [µs], and shares of targets solved."""
    nao = nk.load_nao("v6")
    side, frame = limb[0], limb
    T = nao.fk(nao.random(0, targets), frame)
    found = solve(nao, side, T)
    few = T[:300]
    numeric: list[bool] = []
    columns = [int(column) for column in found.columns]

    def one_by_one() -> None:
        for pose in few:
            solve(nao, side, pose)

    def numerically() -> None:
        numeric[:] = [damped_least_squares(nao, frame, columns, pose) for pose in few]

    batch = 1e6 / targets * best_seconds(lambda: solve(nao, side, T), rounds)
    damped = 1e6 / len(few) * best_seconds(numerically, 1)
    return {
        "batch, µs": round(batch, 3),
        "batch, one thread, µs": round(1e6 / targets * best_seconds(lambda: solve(nao, side, T, threads=1), rounds), 3),
        "batch, limits ignored, µs": round(
            1e6 / targets * best_seconds(lambda: solve(nao, side, T, limits="ignore"), rounds), 3
        ),
        "one call, µs": round(1e6 / len(few) * best_seconds(one_by_one, rounds), 1),
        "solved": float(np.mean(found.success)),
        "largest error, m and rad": [float(value) for value in found.residual.max(axis=0)],
        "damped least squares, µs": round(damped, 1),
        "damped least squares, solved": float(np.mean(numeric)),
        "ratio": round(damped / batch),
    }


def main() -> int:
    """Print the figures as JSON; 1 when a limit is exceeded."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--targets", type=int, default=100_000, help="targets of a batch (default 1e5)")
    parser.add_argument("--rounds", type=int, default=7, help="rounds of each, of which the best counts (default 7)")
    arguments = parser.parse_args()
    results = {
        limb: figures(limb, nk.ik.leg if limb.endswith("Leg") else nk.ik.arm, arguments.targets, arguments.rounds)
        for limb in ("LLeg", "RLeg", "LArm", "RArm")
    }
    slow = [
        f"{limb}: {name} {row[name]} > {limit}"
        for limb, row in results.items()
        for name, limit in (("batch, µs", LIMIT_BATCH), ("one call, µs", LIMIT_ONE))
        if row[name] > limit
    ]
    print(json.dumps({"cores": os.cpu_count(), "limbs": results, "too slow": slow}, indent=2, ensure_ascii=False))
    return 1 if slow else 0


if __name__ == "__main__":
    sys.exit(main())
