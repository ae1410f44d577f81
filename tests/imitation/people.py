"""People of simple shapes who walk, squat and clap, as points with known places."""

from __future__ import annotations

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin.imitation import Skeleton
from nao_kin.rotations import rot_y


def walker(
    seconds: float = 4.0,
    *,
    rate: float = 20.0,
    step: float = 0.15,
    period: float = 2.4,
    squat: float = 0.15,
    lift: float = 0.12,
    noise: float = 0.0,
) -> Skeleton:
    """A person of 1.7 m who steps left and right, bends the knees and the trunk, and swings the arms."""
    times = np.arange(0.0, seconds, 1.0 / rate)
    phase, count = (times / period) % 1.0, np.floor(times / period)
    ones = np.ones(len(times))
    feet = []
    for side, first in ((1.0, 0.1), (-1.0, 0.6)):
        u = np.clip((phase - first) / 0.3, 0.0, 1.0)
        ahead = step * (count + u * u * (3.0 - 2.0 * u))
        feet.append(np.stack([ahead, 0.1 * side * ones, 0.09 + lift * np.sin(np.pi * u) ** 2], axis=1))
    low = squat * np.clip(np.sin(4.0 * np.pi * times / seconds), 0.0, 1.0)
    sway = 0.03 * np.sin(2.0 * np.pi * times / period)
    pelvis = np.stack([(feet[0][:, 0] + feet[1][:, 0]) / 2.0, sway, 0.92 - low], axis=1)
    trunk = rot_y(0.15 * np.sin(2.0 * np.pi * times / seconds))
    points: dict[str, Floats] = {}
    for name, side, ankle in (("left", 1.0, feet[0]), ("right", -1.0, feet[1])):
        hip = pelvis + np.array([0.0, 0.1 * side, 0.0])
        half = np.linalg.norm(hip - ankle, axis=1) / 2.0
        bend = np.sqrt(np.maximum(0.45**2 - half**2, 0.0))
        knee = (hip + ankle) / 2.0 + np.stack([bend, 0.0 * bend, 0.0 * bend], axis=1)
        shoulder = pelvis + trunk @ (0.0, 0.19 * side, 0.5)
        swing = 0.4 * side * np.sin(2.0 * np.pi * times / period)
        upper, fore = (
            np.stack([np.sin(swing + more), 0.2 * side * ones, -np.cos(swing + more)], axis=1) for more in (0.0, 0.6)
        )
        points |= {f"{name}_hip": hip, f"{name}_knee": knee, f"{name}_ankle": ankle}
        points |= {f"{name}_toe": ankle + np.array([0.2, 0.05 * side, -0.06]), f"{name}_shoulder": shoulder}
        points |= {f"{name}_elbow": shoulder + 0.28 * upper, f"{name}_wrist": shoulder + 0.28 * upper + 0.25 * fore}
        points |= {f"{name}_ear": pelvis + trunk @ (0.0, 0.08 * side, 0.72)}
    points["nose"] = pelvis + trunk @ (0.12, 0.0, 0.7)
    rng = np.random.default_rng(0)
    return Skeleton(times, {name: p + rng.normal(0.0, noise, p.shape) for name, p in points.items()})
