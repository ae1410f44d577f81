"""Stands in for the solver of both legs until that is there: branches of single legs whose hips agree."""

from __future__ import annotations

from typing import Any

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.ik.leg import leg
from nao_kin.ik.results import IKResult, Obstacles
from nao_kin.robot import RobotModel

_AGREE = 1e-7


def legs(
    robot: RobotModel, T_left: Floats, T_right: Floats, *, frames: Any, reference: Any, limits: Any, **_: Any
) -> Any:
    """Both legs."""
    a = leg(robot, "L", T_left, frame=frames[0], reference=reference, limits=limits)
    b = leg(robot, "R", T_right, frame=frames[1], reference=reference, limits=limits)
    n, width = len(T_left), 11
    branches, count = np.full((n, 16, width), np.nan), np.zeros(n, dtype=np.int64)
    for i in range(n):
        for x in a.branches[i, : a.count[i]]:
            for y in b.branches[i, : b.count[i]]:
                if abs(x[0] - y[0]) < _AGREE:
                    branches[i, count[i]] = [*x, *y[1:]]
                    count[i] += 1
    families = np.zeros((n, 16), dtype=np.int8)
    reasons = np.where(count > 0, 0, np.maximum(a.reasons, b.reasons)).astype(np.int8)
    reasons[(count == 0) & (reasons == 0)] = 5
    return IKResult(
        (*a.joints, *b.joints[1:]),
        (*a.columns, *b.columns[1:]),
        np.asarray(reference),
        branches[:, 0],
        branches,
        families,
        count,
        reasons,
        np.where(count[:, None] > 0, 0.0, np.full((n, 2), np.nan)),
        Obstacles.none((n,)),
    )
