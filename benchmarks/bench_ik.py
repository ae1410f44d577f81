"""Compare the closed forms with damped least squares in Pinocchio, pink, TRAC-IK and EAIK, in one run.

The targets are poses of random configurations inside the limits, the same for all contenders. Libraries that are not
installed are left out. The aims: a leg in a batch, inside the limits and verified, in half a microsecond, and a hundred
times as fast as damped least squares; one call with all checks in 10 µs; every target solved.

Example:
    python benchmarks/bench_ik.py
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import sys
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from ik_contenders import CONTENDERS, success_rate

import nao_kin as nk

# Limits [µs]: a limb in a batch, inside the limits and verified, on all cores; and one call with all checks.
LIMIT_BATCH, LIMIT_ONE = 0.5, 10.0
# The least ratio of the time of damped least squares to ours.
LIMIT_RATIO = 100
# The largest ratios of the time of `nk.ik.analytic` to that of EAIK without verification: of a batch, of single calls.
LIMIT_ANALYTIC = 5.0, 50.0
# The number of targets for contenders that solve one target after the other.
_FEW = 300


def best_seconds(run: Callable[[], Any], rounds: int) -> float:
    """Return the best time of a call [s]."""
    times = []
    for _ in range(rounds):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return min(times)


def figures(limb: str, solve: Any, targets: int, rounds: int) -> dict[str, Any]:
    """Return times per target [µs], and the shares of solved targets."""
    nao = nk.load_nao("v6")
    side, frame = limb[0], limb
    T = nao.fk(nao.random(0, targets), frame)
    found = solve(nao, side, T)
    few = T[:_FEW]

    def one_by_one() -> None:
        for pose in few:
            solve(nao, side, pose)

    def per_target(run: Callable[[], Any], count: int) -> float:
        return 1e6 / count * best_seconds(run, rounds)

    batch = per_target(lambda: solve(nao, side, T), targets)
    figures: dict[str, Any] = {
        "batch, µs": round(batch, 3),
        "batch, one thread, µs": round(per_target(lambda: solve(nao, side, T, threads=1), targets), 3),
        "batch, limits ignored, µs": round(per_target(lambda: solve(nao, side, T, limits="ignore"), targets), 3),
        "one call, µs": round(per_target(one_by_one, len(few)), 1),
        "solved": float(np.mean(found.success)),
        "largest error, m and rad": [float(value) for value in found.residual.max(axis=0)],
        "others": {},
    }
    for name, made in CONTENDERS.items():
        try:
            contender = made(nao, frame, found)
        except ImportError:
            continue
        taken = 1e6 / len(few) * best_seconds(partial(contender, few), 2)
        figures["others"][name] = {
            "µs": round(taken, 1),
            "× batch": round(taken / batch),
            "× one call": round(taken / figures["one call, µs"], 1),
            "solved": success_rate(nao, frame, contender(few), few),
        }
    return figures


def figures_of_both_legs(pairs: int, rounds: int) -> dict[str, Any]:
    """Return times per pair of feet [µs] that one HipYawPitch can reach, and the share of solved pairs."""
    nao = nk.load_nao("v6")
    feet = nao.fk(nao.random(0, pairs), ["LLeg", "RLeg"])
    left, right = feet[:, 0], feet[:, 1]
    found = nk.ik.legs(nao, left, right)

    def one_by_one() -> None:
        for one, other in feet[:_FEW]:
            nk.ik.legs(nao, one, other)

    return {
        "batch, µs": round(1e6 / pairs * best_seconds(lambda: nk.ik.legs(nao, left, right), rounds), 3),
        "one call, µs": round(1e6 / _FEW * best_seconds(one_by_one, rounds), 1),
        "solved": float(np.mean(found.success)),
        "largest error, m and rad": [float(value) for value in found.residual.max(axis=0)],
    }


def figures_of_analytic(targets: int, rounds: int) -> dict[str, Any]:
    """Return times per target [µs] of `nk.ik.analytic` for a leg, and how many times as long as EAIK alone it takes."""
    nao, frame = nk.load_nao("v6"), "LLeg"
    q = nao.random(0, targets)
    T = nao.fk(q, frame)
    nk.ik.analytic(nao, frame, T, near=q)
    analytic = importlib.import_module("nao_kin.ik.analytic")
    limb = analytic._limb_of(nao, frame, "torso")
    poses, cores = list(analytic._for_eaik(T, limb.turn)), os.cpu_count() or 1

    def rows(call: Callable[[int], object]) -> Callable[[], object]:
        return lambda: [call(k) for k in range(_FEW)]

    runs: dict[str, tuple[int, Callable[[], Any]]] = {
        "EAIK, batch": (targets, lambda: limb.solver.IK_batched(poses, cores)),
        "batch": (targets, lambda: nk.ik.analytic(nao, frame, T, near=q)),
        "EAIK, one call": (_FEW, rows(lambda k: limb.solver.IK(poses[k]))),
        "one call": (_FEW, rows(lambda k: nk.ik.analytic(nao, frame, T[k], near=q[k]))),
    }
    times: dict[str, list[float]] = {name: [] for name in runs}
    for _ in range(rounds):  # in turns, for a machine is not equally fast all the time
        for name, (count, run) in runs.items():
            times[name].append(1e6 / count * best_seconds(run, 1))
    best = {name: min(each) for name, each in times.items()}
    return {f"{name}, µs": round(value, 2) for name, value in best.items()} | {
        f"{name}, × EAIK": round(best[name] / best[f"EAIK, {name}"], 1) for name in ("batch", "one call")
    }


def main() -> int:
    """Print the figures as JSON; return 1 if a limit is exceeded."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--targets", type=int, default=100_000, help="targets of a batch (default 1e5)")
    parser.add_argument("--rounds", type=int, default=7, help="rounds of each call; the best one is used (default 7)")
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
    slow += [
        f"{limb}: {name} only {other['× batch']} times as long"
        for limb, row in results.items()
        for name, other in row["others"].items()
        if name.startswith("Pinocchio") and other["× batch"] < LIMIT_RATIO
    ]
    both = figures_of_both_legs(arguments.targets, arguments.rounds)
    beside = {} if importlib.util.find_spec("eaik") is None else figures_of_analytic(2000, arguments.rounds)
    slow += [
        f"analytic, {name}: {beside[f'{name}, × EAIK']} times as long as EAIK"
        for name, limit in zip(("batch", "one call"), LIMIT_ANALYTIC, strict=True)
        if beside and beside[f"{name}, × EAIK"] > limit
    ]
    print(
        json.dumps(
            {"cores": os.cpu_count(), "limbs": results, "both legs": both, "analytic": beside, "too slow": slow},
            indent=2,
            ensure_ascii=False,
        )
    )
    return 1 if slow else 0


if __name__ == "__main__":
    sys.exit(main())
