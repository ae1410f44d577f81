"""Compare the map of a person's directions to arms and head with a user's own search by SciPy, frame by frame.

Example:
    python benchmarks/bench_imitation.py
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.optimize import least_squares

import nao_kin as nk
from nao_kin.imitation.directions import Directions
from nao_kin.imitation.limbs import LimbMap

# Limits [µs]: a frame of a batch, a frame alone, and a frame of a webcam, with its filter and speed limits.
LIMIT, ALONE_LIMIT, LIVE_LIMIT = 2000.0, 10_000.0, 10_000.0
ARMS = [(side, [side + joint for joint in ("ShoulderPitch", "ShoulderRoll", "ElbowYaw", "ElbowRoll")]) for side in "LR"]


def best(call: Callable[[], object], rounds: int) -> float:
    """Return the best processor time of a call, summed over threads [s]: other programs disturb it little."""
    times = []
    for _ in range(rounds):
        start = time.process_time()
        call()
        times.append(time.process_time() - start)
    return min(times)


def walk(nao: nk.NaoModel, count: int) -> np.ndarray:
    """Return configurations that swing between random ones, as those of a person in motion, shape (count, nq)."""
    keys = nao.random(1, count // 30 + 2)
    share = np.arange(count)[:, None] % 30 / 30.0
    at = np.arange(count) // 30
    return nao.clamp((1.0 - share) * keys[at] + share * keys[at + 1])


def person_of(nao: nk.NaoModel, q: np.ndarray) -> Directions:
    """Return the directions of a person with the robot's own points."""
    frames = {"shoulder": "Shoulder", "elbow": "Elbow", "wrist": "WristYaw", "hip": "HipPitch"}
    sides = {"left": "L", "right": "R"}
    points = {
        f"{side}_{name}": nao.fk(q, sides[side] + frame)[:, :3, 3] for side in sides for name, frame in frames.items()
    }
    turned = {f"{side}_hand": nao.fk(q, sides[side] + "WristYaw")[:, :3, :3] for side in sides}
    return Directions.of(points, turned | {"head": nao.fk(q, "Head")[:, :3, :3]})


def by_scipy(nao: nk.NaoModel, person: Directions, q: np.ndarray) -> np.ndarray:
    """Return the configurations of a user's own search for the arms, each from the one before."""
    found, now = [], q[0].copy()
    for i in range(len(q)):
        for k, (side, joints) in enumerate(ARMS):
            at = [nao.joint_names.index(name) for name in joints]
            frames = [side + name for name in ("Shoulder", "Elbow", "WristYaw")]

            def residuals(
                values: np.ndarray, i: int = i, k: int = k, at: list[int] = at, frames: list[str] = frames
            ) -> np.ndarray:
                row = now.copy()
                row[at] = values
                p = nao.fk(row, frames)[:, :3, 3]
                lines = (p[1:] - p[:-1]) / np.linalg.norm(p[1:] - p[:-1], axis=-1, keepdims=True)
                return np.ravel(lines - [person.upper_arms[i, k], person.forearms[i, k]])

            bounds = nao.lower[at], nao.upper[at]
            now[at] = least_squares(residuals, np.clip(now[at], bounds[0] + 1e-9, bounds[1] - 1e-9), bounds=bounds).x
        found.append(now.copy())
    return np.array(found)


def main() -> int:
    """Print the figures as JSON; return 1 if a limit is exceeded."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=3000, help="frames of the batch (default 3000)")
    parser.add_argument("--rounds", type=int, default=5, help="rounds of each call; the best one is used (default 5)")
    arguments = parser.parse_args()
    count, rounds = arguments.frames, arguments.rounds
    nao = nk.load_nao()
    q, solver = walk(nao, count), LimbMap(nao)
    person = person_of(nao, q)
    away = nk.rotations.rot_z(0.5) @ nk.rotations.rot_y(-0.4)
    outside = replace(
        person, upper_arms=person.upper_arms @ away, forearms=person.forearms @ away, gaze=person.gaze @ away
    )
    one, few = (
        Directions(*(getattr(person, name)[:n] for name in ("torso", "upper_arms", "forearms", "hands", "gaze")))
        for n in (1, max(1, count // 100))
    )
    n = len(few.gaze)
    with open(nk.imitation.SAMPLES["bow"], encoding="utf-8") as file:
        landmarks = np.array(json.load(file)["landmarks"])
    follower = nk.imitation.Imitator(nao, "mediapipe")
    moments = iter(np.arange(1_000_000) / 30.0)
    us = {
        "frame": best(lambda: solver.solve(person), rounds) / count,
        "frame_outside_the_limits": best(lambda: solver.solve(outside), rounds) / count,
        "directions": best(lambda: person_of(nao, q), 1) / count,
        "frame_alone": best(lambda: [solver.solve(one) for _ in range(20)], rounds) / 20,
        "frame_of_a_webcam": best(lambda: [follower.step(frame, next(moments)) for frame in landmarks], rounds)
        / len(landmarks),
        "arms_by_scipy": best(lambda: by_scipy(nao, few, q[:n]), 1) / n,
    }
    figures = {f"{name}_us": round(1e6 * value, 2) for name, value in us.items()}
    figures |= {
        "share_outside": round(float((solver.errors(outside, solver.solve(outside))[1] > 0).any(axis=1).mean()), 2),
        "times_faster_than_scipy": round(us["arms_by_scipy"] / us["frame"], 1),
        "largest_error": float(solver.errors(person, solver.solve(person))[0][:, [0, 1, 3, 4, 6]].max()),
        "met": 1e6 * us["frame"] <= LIMIT
        and 1e6 * us["frame_alone"] <= ALONE_LIMIT
        and 1e6 * us["frame_of_a_webcam"] <= LIVE_LIMIT,
    }
    print(json.dumps(figures, indent=2))
    return 0 if figures["met"] else 1


if __name__ == "__main__":
    sys.exit(main())
