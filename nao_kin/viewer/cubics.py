"""A motion of a robot as cubics between common key times, which another program evaluates without its joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats
from nao_kin.motion import Motion
from nao_kin.robot import RobotModel

# Numbers of the handles of one motion, 32 MB.
_MAX_NUMBERS = 4_000_000
_THIRD = 1.0 / 3.0


@dataclass(frozen=True, eq=False)
class Cubics:
    """Configurations at all key times of a motion, and the curves between them.

    Attributes:
        times: ascending, from 0, shape (n,) [s].
        q: configurations at these times, shape (n, nq).
        handles: P, Q, a and b of `nao_kin.motion.interpolation` for each segment and column, shape (n − 1, nq, 4); None
            if all segments are straight lines.
    """

    times: Floats
    q: Floats
    handles: Floats | None


def cubics(motion: Motion, robot: RobotModel, missing: str | ArrayLike) -> Cubics | None:
    """Return the curves of a robot's coordinates, as `Motion.configurations` evaluates them, up to rounding.

    None if there are none, because a motor follows the average of Bezier curves with different handles in time,
    or if they are too large.
    """
    found = motion.configurations(robot, missing=missing)
    times = found.times - found.times[0]
    if motion.interpolation == "linear" or len(times) == 1:
        return Cubics(times, found.q, None)
    if (len(times) - 1) * robot.nq * 4 > _MAX_NUMBERS:
        return None
    names = motion.joint_names
    # Motor values are affine in the values of the joints: one row of weights for each joint.
    units = dict(zip(names, np.vstack([np.zeros(len(names)), np.eye(len(names))]).T, strict=True))
    handles = np.zeros((len(times) - 1, robot.nq, 4))
    handles[..., 2:] = _THIRD
    pieces = [_divided(curve, keys, found.times) for curve, keys in zip(motion.segments, motion.times, strict=True)]
    for joint, values in robot.motor_values(units).items():
        column = handles[:, robot.nq_base + robot.joint_names.index(joint)]
        weights = values[1:] - values[0]
        used = [(weight, piece) for weight, piece in zip(weights, pieces, strict=True) if weight != 0.0]
        for weight, piece in used:
            if np.abs(piece[:, 2:] - used[0][1][:, 2:]).max() > 1e-12:
                return None
            column[:, :2] += weight * piece[:, :2]
            column[:, 2:] = piece[:, 2:]
    return Cubics(times, found.q, handles)


def _divided(curve: Any, keys: Floats, times: Floats) -> Floats:
    """Return P, Q, a and b of the parts of a joint's curve between times, shape (len(times) − 1, 4)."""
    parts = np.zeros((len(times) - 1, 4))
    parts[:, 2:] = _THIRD
    if len(keys) == 1:
        return parts
    # Before the first and after the last key u equals v, and the part is a point.
    segment = curve.at(times[:-1])
    u, v = curve.parameter(segment, times[:-1]), curve.parameter(segment, times[1:])
    begin, one, two, end = curve.part(segment, u, v)
    parts[:, :2] = np.stack([one[1] - begin[1], two[1] - begin[1]], axis=-1)
    if curve.lengths is not None:
        width = np.where(end[0] > begin[0], end[0] - begin[0], 1.0)
        parts[:, 2:] = np.clip(np.stack([one[0] - begin[0], end[0] - two[0]], axis=-1) / width[:, None], 0.0, 1.0)
    return parts
