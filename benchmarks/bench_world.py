"""Compare balance with a loop over SciPy's hulls, and time pixels to the ground, `set_down`, odometry and the state.

Example:
    python benchmarks/bench_world.py
"""

from __future__ import annotations

import argparse
import json
import sys
from typing import Any

import numpy as np
from racing import best
from scipy.spatial import ConvexHull

import nao_kin as nk

# Limits [µs]: the margin of one configuration in a batch, one pixel without distortion to the ground, and the state of
# one row with forces, accelerometer and gyrometer.
LIMIT, PIXEL_LIMIT, STATE_LIMIT = 3.0, 1.0, 30.0


def by_scipy(nao: nk.NaoModel, q: np.ndarray) -> list[float]:
    """Return the margins from a user's own loop, one configuration after another."""
    outlines = [nao.sole_outline(sole) for sole in nao.semantics.soles]
    margins = []
    for one in q:
        T = nao.fk(one, nao.semantics.soles)
        up = T[:, :3, 2].sum(axis=0)
        R = nk.rotations.rotation_between(up, [0.0, 0.0, 1.0])
        points = np.concatenate(
            [points @ pose[:3, :3].T + pose[:3, 3] for pose, points in zip(T, outlines, strict=True)]
        )
        hull = ConvexHull((points @ R.T)[:, :2])
        margins.append(-float((hull.equations @ [*(R @ nao.com(one))[:2], 1.0]).max()))
    return margins


def main() -> int:
    """Print the figures as JSON; return 1 if a limit is exceeded."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=100_000, help="configurations (default 100000)")
    parser.add_argument("--rounds", type=int, default=5, help="rounds of each call; the best one is used (default 5)")
    arguments = parser.parse_args()
    count, rounds = arguments.count, arguments.rounds
    nao, rng = nk.load_nao(), np.random.default_rng(0)
    q = np.tile(nao.posture("Stand"), (count, 1)) + rng.normal(0.0, 0.01, (count, nao.nq))
    few, lying = q[: max(1, count // 100)], nao.random(rng, max(1, count // 1000))
    agree = float(np.abs(nk.world.margin(nao, few) - by_scipy(nao, few)).max())  # compiles
    times = 0.01 * np.arange(count)
    steps = (times // 0.25 % 2.0)[:, None] == [0.0, 1.0]  # four changes of the support in a second
    sensors: dict[str, Any] = {
        "forces": np.where(steps, 4.5, 0.8),
        "accelerometer": rng.normal([0.0, 0.0, 9.8], 0.3, (count, 3)),
        "gyro": rng.normal(0.0, 0.1, (count, 3)),
    }
    stand, top = nao.posture("StandInit"), nk.world.camera(nao, "CameraTop")
    lens = nk.world.Camera.from_matrix(top.matrix, (-0.25, 0.1, 0.002, -0.001, -0.02), frame=top.frame, size=(640, 480))
    pixels = rng.uniform([0.0, 0.0], [640.0, 480.0], (1_000_000, 2))
    us = {
        "margin": best(lambda: nk.world.margin(nao, q), rounds) / count,
        "margin_by_scipy": best(lambda: by_scipy(nao, few), rounds) / len(few),
        "balance": best(lambda: nk.world.balance(nao, q[: len(few) * 10]), rounds) / len(few) / 10,
        "set_down_standing": best(lambda: nao.set_down(q[: len(few) * 10]), rounds) / len(few) / 10,
        "set_down_anyhow": best(lambda: nao.set_down(lying), rounds) / len(lying),
        "pixel_to_ground": best(lambda: nk.world.pixel_to_ground(nao, stand, pixels, top), rounds) / len(pixels),
        "pixel_to_ground_with_distortion": best(lambda: nk.world.pixel_to_ground(nao, stand, pixels, lens), 1)
        / len(pixels),
        "odometry": best(lambda: nk.world.odometry(nao, times, q), rounds) / count,
        "dynamic_balance": best(lambda: nk.world.dynamic_balance(nao, times[:6000], q[:6000]), rounds) / len(q[:6000]),
        "state": best(lambda: nk.world.state(nao, q, times=times, **sensors), rounds) / count,
    }
    figures = {f"{name}_us": round(1e6 * value, 2) for name, value in us.items()}
    figures |= {
        "times_faster_than_scipy": round(us["margin_by_scipy"] / us["margin"], 1),
        "largest_difference": agree,
        "met": 1e6 * us["margin"] <= LIMIT
        and 1e6 * us["pixel_to_ground"] <= PIXEL_LIMIT
        and 1e6 * us["state"] <= STATE_LIMIT
        and agree < 1e-9,
    }
    print(json.dumps(figures, indent=2))
    return 0 if figures["met"] else 1


if __name__ == "__main__":
    sys.exit(main())
