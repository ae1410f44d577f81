"""Poses of a standing NAO that are known to be possible, made without the solver that is to find them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

import nao_kin as nk

Floats = NDArray[np.float64]
SENSORS = ("FrontLeft", "FrontRight", "RearLeft", "RearRight")
_RIGHT = ("RHipRoll", "RHipPitch", "RKneePitch", "RAnklePitch", "RAnkleRoll")


@dataclass(frozen=True, eq=False)
class Standing:
    """Configurations whose left sole lies in the world's origin, and with `both` the right one on the same floor.

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


def sensor_hull_contains(corners: Floats, point: Floats) -> bool:
    """Whether a point is in the convex hull of others: in some triangle of three of them, by brute force."""
    n = len(corners)
    for i in range(n):
        for j in range(i):
            for k in range(j):
                a, b, c = corners[[i, j, k]]
                M = np.array([b - a, c - a]).T
                if abs(np.linalg.det(M)) < 1e-12:
                    continue
                u, v = np.linalg.solve(M, point - a)
                if u >= 0.0 and v >= 0.0 and u + v <= 1.0:
                    return True
    return False


def corners_of(nao: nk.RobotModel, torso: Floats, q: Floats, sides: str) -> Floats:
    """The pressure sensors of feet in the world, xy only, shape (4 feet, 2)."""
    names = [f"{side}Foot/FSR/{name}" for side in sides for name in SENSORS]
    return np.asarray((torso @ nao.fk(q, names))[:, :2, 3])


def standing_poses(nao: nk.RobotModel, count: int, *, both: bool, seed: int = 0) -> Standing:
    """Random configurations inside the limits with the centre of mass above the soles that stand."""
    rng = np.random.default_rng(seed)
    found: list[tuple[Floats, Floats, Floats]] = []
    columns = [nao.joint_names.index(name) for name in _RIGHT]
    while len(found) < count:
        for q in nao.random(rng, 4000):
            torso = np.linalg.inv(nao.fk(q, "LLeg"))
            if torso[2, 2] < 0.3:  # the torso is not to hang upside down
                continue
            if both and not _put_right_foot_down(nao, q, torso, columns):
                continue
            com = torso[:2, :3] @ nao.com(q) + torso[:2, 3]
            if not sensor_hull_contains(corners_of(nao, torso, q, "LR" if both else "L"), com):
                continue
            found.append((q, torso, torso @ nao.fk(q, ["LLeg", "RLeg"])))
            if len(found) == count:
                break
    q, torso, feet = (np.array(part) for part in zip(*found, strict=True))
    return Standing(q, torso, feet)


def _put_right_foot_down(nao: nk.RobotModel, q: Floats, torso: Floats, columns: list[int]) -> bool:
    """Change the right leg so that its sole lies on the floor; whether that is possible inside the limits."""

    def off(values: Floats) -> Floats:
        q[columns] = values
        T = torso @ nao.fk(q, "RLeg")
        return np.array([T[2, 3], 0.1 * T[0, 2], 0.1 * T[1, 2]])

    bounds = nao.lower[columns], nao.upper[columns]
    start = np.clip(q[columns], bounds[0] + 1e-6, bounds[1] - 1e-6)
    done = least_squares(off, start, bounds=bounds, xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=30)
    q[columns] = done.x
    T = torso @ nao.fk(q, "RLeg")
    return bool(np.abs(done.fun).max() < 1e-12 and T[2, 2] > 0.0 and nao.within_limits(q))
