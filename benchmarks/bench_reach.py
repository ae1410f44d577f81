"""Time reach maps: ten million samples, and the effect of threads and of finer voxels.

Example:
    python benchmarks/bench_reach.py
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time

import numpy as np

import nao_kin as nk

# The limit for ten million samples of an arm, with manipulability, on all cores [s].
LIMIT_SECONDS, LIMIT_SAMPLES = 15.0, 10_000_000


def seconds(
    samples: int, rounds: int, *, frame: str = "LArm", voxel: float = 0.01, threads: int | None = None
) -> float:
    """Return the best time of a map [s]."""
    nao = nk.load_nao()
    times = []
    for _ in range(rounds):
        start = time.perf_counter()
        nk.reach.workspace(nao, frame, samples, voxel=voxel, threads=threads)
        times.append(time.perf_counter() - start)
    return min(times)


def arrays_seconds(samples: int) -> float:
    """Return the time of a user's own code: positions, Jacobians and voxels from the robot's methods [s]."""
    nao = nk.load_nao()
    start = time.perf_counter()
    q = nao.random(0, samples)
    arm = [nao.joint_names.index(name) for name in nao.chains["LArm"][:5]]
    cells = np.floor(nao.position(q, "LArm") / 0.01).astype(int)
    J = nao.jacobian(q, "LArm")[:, :3, arm]
    manipulability = np.sqrt(np.linalg.det(J @ J.swapaxes(1, 2)))
    rows, place = np.unique(cells, axis=0, return_inverse=True)
    np.maximum.at(np.zeros(len(rows)), place.reshape(-1), manipulability)
    return time.perf_counter() - start


def main() -> int:
    """Print the figures as JSON; return 1 if the limit is exceeded."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", type=int, default=LIMIT_SAMPLES, help="samples of the large maps (default 1e7)")
    parser.add_argument("--rounds", type=int, default=2, help="rounds of each map; the best one is used (default 2)")
    arguments = parser.parse_args()
    samples, rounds = arguments.samples, arguments.rounds
    nk.reach.workspace(nk.load_nao(), "LArm", 1)  # compiles
    limit = LIMIT_SECONDS * samples / LIMIT_SAMPLES
    all_cores = seconds(samples, rounds)
    one = seconds(samples, rounds, threads=1)
    few = min(samples, 50_000)
    by_methods = min(arrays_seconds(few) for _ in range(rounds + 1))  # the first compiles
    figures = {
        "cores": os.cpu_count(),
        "samples": samples,
        "arm_seconds": round(all_cores, 2),
        "limit_seconds": round(limit, 2),
        "share_of_limit": round(all_cores / limit, 3),
        "met": all_cores <= limit,
        "one_thread_seconds": round(one, 2),
        "one_thread_by_all": round(one / all_cores, 2),
        "leg_seconds": round(seconds(samples, rounds, frame="LLeg"), 2),
        "three_millimetres_seconds": round(seconds(samples, rounds, voxel=0.003), 2),
        "times_faster_than_methods": round(by_methods / few / (one / samples), 1),
    }
    print(json.dumps(figures, indent=2))
    return 0 if figures["met"] else 1


if __name__ == "__main__":
    sys.exit(main())
