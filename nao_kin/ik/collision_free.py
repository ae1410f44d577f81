"""Solutions without links that overlap, chosen among those of another solver."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np

from nao_kin._core.arrays import flag
from nao_kin.ik.results import IKResult, Reason
from nao_kin.robot import RobotModel

_Result = TypeVar("_Result", bound=IKResult)


def without_collisions(robot: RobotModel, result: _Result, wanted: bool = True) -> _Result:
    """Return a result without the solutions in which links overlap, and with a note on their number, if `wanted`.

    If links overlap in all solutions of a target, `best` is the one with the largest clearance.
    """
    if wanted is False or not flag(wanted, "collisions"):
        return result
    q = result.solutions
    exists = np.arange(q.shape[-2]) < result.count[..., None]
    found = robot.clearance(np.where(exists[..., None], q, robot.neutral()))
    keep = exists & found.is_free
    left_out = int(np.count_nonzero(exists & ~keep))
    if not left_out:
        return result
    order = np.argsort(~keep, axis=-1, kind="stable")
    count = keep.sum(axis=-1)
    gone = np.arange(q.shape[-2]) >= count[..., None]
    branches = np.take_along_axis(result.branches, order[..., None], axis=-2)
    families = np.take_along_axis(result.families, order, axis=-1)
    lost = (result.count > 0) & (count == 0)
    widest = np.argmax(np.where(exists, found.distance, -np.inf), axis=-1)[..., None]
    overlapping = np.take_along_axis(result.branches, widest[..., None], axis=-2)[..., 0, :]
    best = np.where((count > 0)[..., None], branches[..., 0, :], np.where(lost[..., None], overlapping, result.best))
    branches[gone], families[gone] = np.nan, 0
    pair = np.take_along_axis(found.pair_index, widest, axis=-1)[..., 0]
    depth = np.take_along_axis(-found.distance, widest, axis=-1)[..., 0]
    obstacles = replace(
        result.obstacles,
        needed=np.where(lost, depth, result.obstacles.needed),
        links=np.where(lost, pair, -1),
        pairs=found.pairs,
    )
    note = f"{left_out} of {np.count_nonzero(exists)} solutions are left out: links overlap"
    return replace(
        result,
        best=best,
        branches=branches,
        families=families,
        count=count,
        reasons=np.where(lost, np.int8(Reason.COLLISION), result.reasons),
        obstacles=obstacles,
        notes=(*result.notes, note),
    )
