"""The path of both arms through a person's frames: candidates of each frame, the shortest path, and its descent.

The candidates of a frame are the minima of its cost that descents find from the closed-form solutions, each joint
clipped to its range, and from a few other configurations, and the same with WristYaw at its limits. The path of least
cost through the candidates, with the cost of steps, is where the descent of the whole path begins: it spreads a step
over frames, and settles what the directions of a frame leave open, such as ElbowYaw of a straight arm.
"""

from __future__ import annotations

import math

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._core.layers import reached, traced
from nao_kin.imitation.arm_cost import Paths, descend

# The weight of steps that decides between equal configurations.
_TIE = 1e-14
# Steps of the descent of candidates: the path that begins with them descends to the end.
_STEPS = 6
# Where some of these descents begin: shares of half the ranges from their middle.
_SPREAD = 0.6 * np.array([[-1, 0, -1, 0, 0], [-1, 0, 1, 0, 0], [1, 0, -1, 0, 0], [1, 0, 1, 0, 0]])


def _into(angles: Floats, paths: Paths, first: int) -> Floats:
    """Return the values in the ranges of joints, from the first one on, nearest to angles on the circle."""
    lower, upper = (ends[..., first : first + angles.shape[-1]] for ends in (paths.lower, paths.upper))
    middle, turn = 0.5 * (lower + upper), 2.0 * math.pi
    return np.clip(middle + (angles - middle + math.pi) % turn - math.pi, lower, upper)


def _seeds(paths: Paths) -> Floats:
    """Return where the descents of each frame begin, shape (m, n, 6, 5).

    These are the closed-form solutions of shoulder and elbow, each joint clipped, and four configurations that differ
    in ShoulderPitch and ElbowYaw. Unknown directions keep the joints of the frame before the first one.
    """
    m, n = paths.roots.shape[:2]
    seeds = np.broadcast_to(paths.before[:, None, None], (m, n, 6, 5)).copy()
    (ux, uy, uz), f = np.moveaxis(paths.targets[:, :, 0], -1, 0), paths.targets[:, :, 1]
    pitch, roll = np.arctan2(-uz, ux), np.arctan2(uy, np.hypot(ux, uz))
    lower, upper = np.moveaxis(paths.lower, -1, 0), np.moveaxis(paths.upper, -1, 0)
    sign = np.where(lower[3] + upper[3] < 0.0, -1.0, 1.0)  # of ElbowRoll
    knows_upper, knows_fore = (paths.roots[..., k] > 0.0 for k in range(2))
    for k, (q1, q2) in enumerate(((pitch, roll), (pitch + math.pi, math.pi - roll))):
        seeds[knows_upper, k, :2] = _into(np.stack([q1, q2 - paths.tilt], axis=-1), paths, 0)[knows_upper]
        (s1, s2), (c1, c2) = (np.moveaxis(part(seeds[:, :, k, :2]), -1, 0) for part in (np.sin, np.cos))
        level, away = c1 * f[..., 0] - s1 * f[..., 2], s1 * f[..., 0] + c1 * f[..., 2]
        ahead, side = c2 * level + s2 * f[..., 1], c2 * f[..., 1] - s2 * level
        yaw, bend = np.arctan2(sign * away, sign * side), sign * np.arctan2(np.hypot(side, away), ahead)
        seeds[knows_fore, k, 2:4] = _into(np.stack([yaw, bend], axis=-1), paths, 2)[knows_fore]
    middle, half = 0.5 * (paths.lower + paths.upper)[:, :, None], 0.5 * (paths.upper - paths.lower)[:, :, None]
    knows = np.repeat(np.stack([knows_upper, knows_fore], axis=-1), 2, axis=-1)[:, :, None]
    seeds[:, :, 2:, :4] = np.where(knows, (middle + _SPREAD * half)[..., :4], seeds[:, :, 2:, :4])
    return seeds


def _alone(paths: Paths, count: int) -> Paths:
    """Return `count` paths of one frame for each frame, drawn to the frame before the first one."""
    m, n = paths.roots.shape[:2]
    arms, frames = np.repeat(np.arange(m), n * count), np.tile(np.repeat(np.arange(n), count), m)
    targets, roots = paths.targets[arms, frames][:, None], paths.roots[arms, frames][:, None]
    own = (paths.tilt[arms], paths.share[arms], paths.lower[arms], paths.upper[arms])
    return Paths(*own, targets, roots, np.full((len(arms), 1, 5), _TIE), paths.before[arms])


def candidates(paths: Paths) -> tuple[Floats, Floats]:
    """Return minima of the cost of each frame, also with WristYaw at its limits, (m, n, 18, 5), and their costs."""
    m, n = paths.roots.shape[:2]
    seeds = _seeds(paths)
    count = seeds.shape[2]
    found = descend(_alone(paths, count), seeds.reshape(-1, 1, 5), _STEPS).reshape(seeds.shape)
    values = np.tile(found, (1, 1, 3, 1))
    values[:, :, count : 2 * count, 4], values[:, :, 2 * count :, 4] = paths.lower[..., 4:], paths.upper[..., 4:]
    return values, _alone(paths, 3 * count).frame_costs(values.reshape(-1, 1, 5)).reshape(m, n, 3 * count)


def shortest(values: Floats, costs: Floats, pull: Floats, before: Floats) -> Floats:
    """Return the path of least cost through candidates (n, k, 5) with costs (n, k), shape (n, 5)."""
    cost, last, backs = np.zeros(1), before[None], []
    for own, layer, weights in zip(costs, values, np.sqrt(pull), strict=True):
        up_to, back = reached(cost, last, layer, weights)
        cost, last = up_to + own, layer
        backs.append(back)
    return values[np.arange(len(values)), traced(backs, int(np.argmin(cost)))]


def followed(paths: Paths) -> Floats:
    """Return a path of each arm at a minimum of its cost, shape (m, n, 5)."""
    chosen = [shortest(*one) for one in zip(*candidates(paths), paths.pull, paths.before, strict=True)]
    return descend(paths, np.stack(chosen))
