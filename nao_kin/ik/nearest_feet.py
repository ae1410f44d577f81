"""Joint values of a leg, or of both, nearest to feet that they do not reach: damped least squares inside the limits."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats
from nao_kin.ik.descent import FrameMotion, Goal, descended
from nao_kin.ik.geometry import Limb, kept_limb, torso_in_trunk
from nao_kin.ik.ranges import MOST_TURNED
from nao_kin.ik.results import IKResult
from nao_kin.robot import RobotModel
from nao_kin.rotations import log, nearest_rotation

# What one radian counts [m], as in `arm`.
ANGLE_WEIGHT = 0.1
_GOAL = Goal(np.repeat([1.0, ANGLE_WEIGHT], 3), 0.0, 200)


def missed(result: IKResult) -> NDArray[np.bool_]:
    """Which targets have no solution and no joint values yet, shape (...)."""
    return np.asarray((result.count == 0) & np.isnan(result.best).any(axis=-1))


def nearest_feet(
    robot: RobotModel,
    frames: tuple[str, ...],
    limb: Limb,
    T: Floats,
    reference: Floats,
    starts: list[Floats],
    enforce: bool,
    threads: int | None,
) -> tuple[Floats, Floats]:
    """The coordinates with the smallest Σ (distance² + (0.1 m · angle)²) over the feet that was found.

    Args:
        robot: whose feet.
        frames: F frames.
        limb: the leg or the legs.
        T: targets in the torso, shape (n, F, 4, 4).
        reference: configurations, shape (n, nq).
        starts: coordinates at which searches begin beside those of the reference, each of shape (n, c).
        enforce: keep limits.
        threads: as in `leg`.

    Returns:
        Coordinates of the limb, shape (n, c), and errors of each foot in position and angle, shape (n, F, 2) [m, rad].
    """
    motion = kept_limb(robot, FrameMotion, *frames)
    region = motion.limited if enforce else motion.free
    n, c = len(T), len(limb.columns)
    wanted = np.array(torso_in_trunk(robot) @ T)
    wanted[..., :3, :3] = nearest_rotation(wanted[..., :3, :3])
    near = reference[:, limb.index]
    began = np.stack([np.broadcast_to(start, (n, c)) for start in (near, *starts)])
    values = robot.neutral()[None].repeat(len(began) * n, axis=0)
    values[:, limb.index] = began.reshape(-1, c)
    values = region.project(motion.joint_values(values))
    targets = np.broadcast_to(wanted.reshape(n, -1), (len(began), n, 16 * len(frames))).reshape(len(values), -1)
    still, inside = region.still_values(values), values[:, region.moving]
    # A single start is searched from as Python where nothing is compiled yet.
    parts = [slice(k, k + 1) for k in range(len(inside))] if n == 1 else [slice(None)]
    found = [descended(motion.chain, region, _GOAL, targets[k], still[k], inside[k], threads) for k in parts]
    cost = np.concatenate([part.cost for part in found]).reshape(len(began), n)
    rows: NDArray[np.intp] = np.argmin(cost, axis=0) * n + np.arange(n)
    best = np.concatenate([part.q for part in found])[rows]
    # The limb alone decides, and whole turns do not change it.
    q = robot.neutral()[None].repeat(n, axis=0)
    q[:, limb.index] = best
    made = np.array(robot.fk(q, list(frames), reference=limb.torso))
    errors = made[..., :3, :3].swapaxes(-1, -2) @ nearest_rotation(T[..., :3, :3])
    away = np.linalg.norm(made[..., :3, 3] - T[..., :3, 3], axis=-1)
    if not enforce:
        turns = np.round((near - best) * limb.multiplier / (2.0 * math.pi))
        best += 2.0 * math.pi / limb.multiplier * np.where(np.abs(near) > MOST_TURNED, 0.0, turns)
    return best, np.stack([away, np.linalg.norm(log(errors), axis=-1)], axis=-1)
