"""Damped least squares from many starts: `descent_equations` run as Python on one, compiled on many."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nao_kin._common.arrays import Floats
from nao_kin.ik.compiling import copied, in_lists, kept, run_rows
from nao_kin.ik.search.descent_equations import COST, MET, SETTLED, Bench, Chain, Goal, descend, room_for
from nao_kin.ik.search.descent_limits import TABLE, Region
from nao_kin.ik.search.limit_regions import LimitRegion, region_type
from nao_kin.ik.search.pose_errors import PoseErrors

Rows = NDArray[np.intp]

# What is reported of a start.
_REPORT = 5
# Below this many starts another thread is not worth its own start.
_PER_THREAD = 64


@dataclass(frozen=True, eq=False)
class Minimum:
    """Where searches have ended, n of them.

    Attributes:
        q: configurations, shape (n, nq).
        cost: half the squared weighted error, shape (n,).
        reached: the error was as small as asked, shape (n,).
        settled: no direction inside the limits lessens the error any more, shape (n,).
    """

    q: Floats
    cost: Floats
    reached: NDArray[np.bool_]
    settled: NDArray[np.bool_]

    def take(self, rows: Rows, other: Minimum, part: slice) -> None:
        """Take over what another search found for these rows, where it is the first to succeed or nearer."""
        better = ~self.reached[rows] & (other.reached[part] | (other.cost[part] < self.cost[rows]))
        good = rows[better]
        self.q[good], self.cost[good] = other.q[part][better], other.cost[part][better]
        self.reached[good], self.settled[good] = other.reached[part][better], other.settled[part][better]


def minimise(
    errors: PoseErrors,
    region: LimitRegion,
    q: Floats,
    rows: Rows,
    tolerance: float,
    steps: int,
    threads: int | None = None,
) -> Minimum:
    """Lessen ½‖e(q)‖² from every start, inside the limits.

    Args:
        errors: the targets and the weights.
        region: the limits; the starts are inside.
        q: starts, shape (n, nq).
        rows: the target of each start, shape (n,).
        tolerance: errors in position and angle that are small enough, in what has a weight [m, rad].
        steps: stop a search after so many.
        threads: how many; None for all cores where that is worthwhile.

    Returns:
        Where the searches ended.
    """
    motion = errors.motion
    targets = motion.in_base(errors.targets[rows], q).reshape(len(q), 16)
    still = region.still_values(motion.joint_values(q))
    goal = Goal(errors.weights, tolerance, steps)
    found = descended(motion.chain, region, goal, targets, still, q[:, motion.columns], threads)
    ends: Floats = np.array(q)
    ends[:, motion.columns] = found.q
    return replace(found, q=ends)


def descended(
    chain: Chain,
    region: LimitRegion,
    goal: Goal,
    targets: Floats,
    still: Floats,
    starts: Floats,
    threads: int | None = None,
) -> Minimum:
    """The same for the m joints of a region, of one frame or of several.

    Args:
        chain: the way to each of F frames.
        region: the limits; the starts are inside.
        goal: weights, tolerance, and the most steps.
        targets: poses of the frames in the base for each start, shape (n, 16 F).
        still: as `LimitRegion.still_values` has them, shape (n, t).
        starts: shape (n, m).
        threads: how many; None for all cores where that is worthwhile.

    Returns:
        Where the searches ended; `q` has shape (n, m).
    """
    limits, targets = region.numbers, np.array(targets, order="C")  # its own, for kernels take no read-only arrays
    found, reports = np.array(starts, order="C"), np.empty((len(starts), _REPORT))

    def one_in_lists(part: slice) -> None:
        values, report = found[part.start].tolist(), [0.0] * _REPORT
        sizes = room_for(len(chain.joints), len(chain.place), len(values), len(limits.tables) // TABLE)
        bench = Bench(*([0.0] * size for size in sizes))
        lists = in_lists(chain), in_lists(limits), in_lists(goal)
        descend(*lists, targets[part.start].tolist(), still[part.start].tolist(), values, bench, report)
        found[part], reports[part] = values, report

    def solve(function: Callable[..., object], part: slice) -> None:
        numbers = copied(chain), copied(limits), copied(goal)
        function(*numbers, targets[part], still[part], found[part], reports[part])

    if len(starts) == 1 and not _descents.in_memory:
        one_in_lists(slice(0, 1))
    else:
        run_rows(_descents, solve, len(starts), threads, _PER_THREAD, one_in_lists)
    return Minimum(found, reports[:, COST].copy(), reports[:, MET] == 1.0, reports[:, SETTLED] == 1.0)


def _arguments() -> tuple[Any, ...]:
    from numba import types

    row, whole, rows = types.float64[::1], types.int64[::1], types.float64[:, ::1]
    return (
        types.NamedTuple((whole, row, row, whole, row, row), Chain),
        region_type(),
        types.NamedTuple((row, types.float64, types.int64), Goal),
        rows,
        rows,
        rows,
        rows,
    )


@kept("damped least squares", _arguments)
def _descents(
    chain: Chain, region: Region, goal: Goal, targets: Floats, still: Floats, values: Floats, reports: Floats
) -> None:
    n, m, t = len(chain.place), len(region.lower), len(region.tables) // TABLE
    sizes = room_for(len(chain.joints), n, m, t)
    bench = Bench(
        np.empty(sizes[0]), np.empty(sizes[1]), np.empty(sizes[2]), np.empty(sizes[3]), np.empty(sizes[4]),
        np.empty(sizes[5]), np.empty(sizes[6]), np.empty(sizes[7]), np.empty(sizes[8]), np.empty(sizes[9]),
        np.empty(sizes[10]), np.empty(sizes[11]), np.empty(sizes[12]), np.empty(sizes[13]), np.empty(sizes[14]),
        np.empty(sizes[15]), np.empty(sizes[16]),
    )  # fmt: skip
    for i in range(values.shape[0]):
        descend(chain, region, goal, targets[i], still[i], values[i], bench, reports[i])


DESCENT_KERNELS = (_descents,)
