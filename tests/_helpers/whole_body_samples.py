"""Feasible poses of a standing NAO, made without the solver under test."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import nao_kin as nk

Floats = NDArray[np.float64]
SENSORS = ("FrontLeft", "FrontRight", "RearLeft", "RearRight")


@dataclass(frozen=True, eq=False)
class Standing:
    """Configurations with the left sole at the world's origin and, with `both`, the right sole on the same floor.

    Attributes:
        q: shape (n, 25).
        torso: T_world_torso, shape (n, 4, 4).
        feet: T_world_foot of both, shape (n, 2, 4, 4).
    """

    q: Floats
    torso: Floats
    feet: Floats

    def pose(self, nao: nk.RobotModel, frame: str) -> Floats:
        """T_world_frame, shape (n, 4, 4)."""
        return np.asarray(self.torso @ nao.fk(self.q, frame))


def is_above(corners: Floats, points: Floats) -> NDArray[np.bool_]:
    """Return whether points (n, 2) are in the convex hull of corners (n, k, 2), that is, in a triangle of three."""
    inside = np.zeros(len(points), dtype=np.bool_)
    for i, j, k in itertools.combinations(range(corners.shape[1]), 3):
        a, b, c = corners[:, i], corners[:, j], corners[:, k]
        turns = [_turn(a, b, points), _turn(b, c, points), _turn(c, a, points)]
        inside |= np.all(np.array(turns) >= 0.0, axis=0) | np.all(np.array(turns) <= 0.0, axis=0)
    return inside


def _turn(a: Floats, b: Floats, p: Floats) -> Floats:
    return np.asarray((b - a)[:, 0] * (p - a)[:, 1] - (b - a)[:, 1] * (p - a)[:, 0])


def sensors(nao: nk.RobotModel, torso: Floats, q: Floats, sides: str) -> Floats:
    """Return the positions of the feet's pressure sensors in the world, shape (n, 4 feet, 3)."""
    names = [f"{side}Foot/FSR/{name}" for side in sides for name in SENSORS]
    return np.asarray((torso[:, None] @ nao.fk(q, names))[:, :, :3, 3])


def standing_poses(nao: nk.RobotModel, count: int, *, both: bool, seed: int = 0) -> Standing:
    """Random configurations inside the limits with the centre of mass above the soles that stand."""
    rng = np.random.default_rng(seed)
    found: list[tuple[Floats, Floats]] = []
    while sum(len(q) for q, _ in found) < count:
        q = nao.random(rng, 20000)
        q[:, [nao.joint_names.index(hand) for hand in ("LHand", "RHand")]] = 0.0  # no target moves the hands
        torso = np.linalg.inv(nao.fk(q, "LLeg"))
        if both:
            q = _with_right_foot_down(nao, q, torso)
        fine = nao.within_limits(q) & (torso[:, 2, 2] > 0.3)  # the torso must not be upside down
        q, torso = q[fine], torso[fine]
        com = np.einsum("nij,nj->ni", torso[:, :2, :3], nao.com(q)) + torso[:, :2, 3]
        above = is_above(sensors(nao, torso, q, "LR" if both else "L")[:, :, :2], com)
        found.append((q[above], torso[above]))
    q, torso = (np.concatenate(part)[:count] for part in zip(*found, strict=True))
    return Standing(q, torso, torso[:, None] @ nao.fk(q, ["LLeg", "RLeg"]))


def _with_right_foot_down(nao: nk.RobotModel, q: Floats, torso: Floats) -> Floats:
    """Turn the right ankle so that the sole is level, and the right knee so that the sole is at height zero.

    If no knee angle does that, the configuration gets values outside the limits.
    """
    q = q.copy()
    knee, pitch, roll = (nao.joint_names.index(name) for name in ("RKneePitch", "RAnklePitch", "RAnkleRoll"))

    def height(bend: Floats) -> Floats:
        q[:, knee] = bend
        up = np.einsum(
            "nji,nj->ni", (torso @ nao.fk(q, "RTibia"))[:, :3, :3], np.broadcast_to([0.0, 0, 1], (len(q), 3))
        )
        # Ry(pitch) Rx(roll) z = the vertical in the frame of the shin.
        q[:, roll] = -np.arcsin(np.clip(up[:, 1], -1.0, 1.0))
        q[:, pitch] = np.arctan2(up[:, 0], up[:, 2])
        return np.asarray((torso @ nao.fk(q, "RLeg"))[:, 2, 3])

    low, high = np.full(len(q), nao.lower[knee]), np.full(len(q), nao.upper[knee])
    at_low = height(low)
    crosses = at_low * height(high) < 0.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        same = height(middle) * at_low > 0.0
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    height(0.5 * (low + high))
    q[~crosses, knee] = np.pi
    return q
