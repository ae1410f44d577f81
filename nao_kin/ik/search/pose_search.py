"""The search for a pose: from a reference, then from random configurations that are near; and why it fails."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from nao_kin._common.arrays import Floats
from nao_kin.ik.results import Obstacles, Reason
from nao_kin.ik.search.least_squares import Minimum, Rows, minimise
from nao_kin.ik.search.limit_regions import LimitRegion
from nao_kin.ik.search.pose_errors import FrameMotion, PoseErrors
from nao_kin.robot import CROSSOVER, RobotModel

_Kept = dict[tuple[str, int, int], tuple[Floats, Floats]]
Minimiser = Callable[[PoseErrors, LimitRegion, Floats, Rows, float, int, int | None], Minimum]
Mask = NDArray[np.bool_]

# Of so many random configurations, a restart begins at the one whose pose is nearest to the target. Every second one
# begins at a configuration just as it is drawn: the nearest ones may all lead to the same dead end, as those of an arm
# whose elbow would have to be bent the other way.
_CANDIDATES = 256
# So many searches are run side by side, for they cost little more than one.
_SIDE_BY_SIDE = 4
# Candidates of each robot are kept for so many starts: 40 kB each.
_MOST_KEPT = 500
_KEPT: WeakKeyDictionary[RobotModel, _Kept] = WeakKeyDictionary()
# Whether limits are to blame is asked of a search without limits, with so many restarts at most.
_RESTARTS_WITHOUT_LIMITS = 8


@dataclass(frozen=True, eq=False)
class Effort:
    """How long a search goes on.

    Attributes:
        restarts: starts beside the reference, at most.
        tolerance: errors of position and rotation that are small enough [m, rad].
        iterations: steps of one search, at most.
        seed: of the random starts.
        minimise: how one search is made.
        threads: how many threads may work; None for all cores where that is worthwhile.
    """

    restarts: int
    tolerance: float
    iterations: int
    seed: int
    minimise: Minimiser = minimise
    threads: int | None = None


@dataclass(frozen=True, eq=False)
class Found:
    """What was found for n targets.

    Attributes:
        q: configurations that meet the targets, or come nearest, shape (n, nq).
        residual: errors in position and rotation of what was asked for, shape (n, 2) [m, rad].
        reasons: a `Reason` for each, shape (n,).
        obstacles: what stood in the way.
        first: the first search, from the reference, has met the target, shape (n,).
        settled: the target is met or the pose is the nearest one around; else the search was stopped, shape (n,).
    """

    q: Floats
    residual: Floats
    reasons: NDArray[np.int8]
    obstacles: Obstacles
    first: Mask
    settled: Mask


@dataclass(frozen=True, eq=False)
class SearchSpace:
    """Where poses of a frame are searched for.

    Attributes:
        motion: what moves the frame.
        limited: the limits of the joints that do.
        free: without limits.
    """

    motion: FrameMotion
    limited: LimitRegion
    free: LimitRegion


def search_space(robot: RobotModel, frame: str) -> SearchSpace:
    """The joints that move a frame, and their limits.

    Raises:
        UnknownName: no such frame.
        BadArgument: no joint moves it.
    """
    motion = FrameMotion(robot, frame)
    return SearchSpace(motion, LimitRegion(robot, motion.joints), LimitRegion(robot, motion.joints, enforced=False))


class PoseSearch:
    """Searches for poses of one frame.

    Args:
        space: what moves the frame, and the limits.
        weights: of the six errors, shape (6,); zero for what does not matter.
        effort: how long to search.
        enforced: whether limits hold.
    """

    def __init__(self, space: SearchSpace, weights: Floats, effort: Effort, *, enforced: bool) -> None:
        self._motion, self._weights, self._effort, self._enforced = space.motion, weights, effort, enforced
        self._limited, self._free = space.limited, space.free
        self._asked = weights > 0.0

    def solve(self, targets: Floats, reference: Floats) -> Found:
        """Configurations for n targets, shape (n, 4, 4), from references inside the limits, shape (n, nq)."""
        motion, region = self._motion, self._limited if self._enforced else self._free
        errors = PoseErrors(motion, targets, self._weights)
        found = self._minimum(errors, region, reference, np.arange(len(targets)))
        first = found.reached.copy()
        reasons, obstacles = np.zeros(len(targets), dtype=np.int8), Obstacles.none((len(targets),))
        if not first.all():
            beyond = np.where(first, 0.0, self._beyond(targets, reference))
            far = beyond > 0.0
            reasons[far], obstacles.needed[far] = Reason.OUT_OF_REACH, beyond[far]
            self._restart(found, errors, region, self._effort.restarts)
            lost = np.flatnonzero(~found.reached & ~far)
            if lost.size:
                self._explain(found, errors, lost, reasons, obstacles)
        region.unwind(motion.joint_values(found.q), motion.joint_values(reference))
        off = errors.residuals(found.q) * self._asked
        residual = np.stack([np.linalg.norm(off[:, :3], axis=-1), np.linalg.norm(off[:, 3:], axis=-1)], axis=-1)
        return Found(found.q, residual, reasons, obstacles, first, found.reached | found.settled)

    def _minimum(self, errors: PoseErrors, region: LimitRegion, q: Floats, rows: Rows) -> Minimum:
        effort = self._effort
        return effort.minimise(errors, region, q, rows, effort.tolerance, effort.iterations, effort.threads)

    def _beyond(self, targets: Floats, reference: Floats) -> Floats:
        """How far targets are farther away than the stretched limb, shape (n,) [m]; not above 0 where they are not."""
        if not self._asked[:3].all():
            return np.zeros(len(targets))
        centre, distance = self._motion.reach(reference)
        beyond = np.linalg.norm(targets[:, :3, 3] - centre, axis=-1) - distance
        # What counts as met may lie so far outside.
        return np.where(beyond > 2.0 * self._effort.tolerance, beyond, 0.0)

    def _restart(self, found: Minimum, errors: PoseErrors, region: LimitRegion, restarts: int) -> None:
        """Search on from other starts for targets not met, until one meets the target.

        Which start that is does not depend on how many are run side by side.
        """
        done = 0
        while done < restarts:
            rows = np.flatnonzero(~found.reached)
            if not rows.size:
                return
            together = min(restarts - done, max(1, _SIDE_BY_SIDE // rows.size))
            starts = [self._start(found.q, errors, region, rows, number) for number in range(done, done + together)]
            tried = self._minimum(errors, region, np.concatenate(starts), np.tile(rows, together))
            for k in range(together):
                found.take(rows, tried, slice(k * rows.size, (k + 1) * rows.size))
            done += together

    def _start(self, q: Floats, errors: PoseErrors, region: LimitRegion, rows: Rows, number: int) -> Floats:
        """For each target, the one of some random configurations whose pose is nearest, or any; shape (n, nq)."""
        motion = self._motion
        drawn, poses = _candidates(motion, self._effort.seed, number)
        if number % 2 == 1:
            drawn, poses = drawn[:1], poses[:1]
        features, wanted = self._features(poses), self._features(motion.in_base(errors.targets[rows], q[rows]))
        # ‖a − b‖² without ‖a‖², which is the same for all.
        distances = np.square(features).sum(axis=-1) - 2.0 * wanted @ features.T
        starts: Floats = q[rows].copy()
        starts[:, motion.columns] = drawn[np.argmin(distances, axis=-1)]
        # Ranges may depend on joints that stay where they are.
        values = motion.joint_values(starts)
        values[...] = region.project(values)
        return starts

    def _features(self, poses: Floats) -> Floats:
        """Twelve numbers of each pose, with distances like those of the weighted errors: ‖R − R_t‖² ≈ 2 φ²."""
        position, turn = self._weights[:3].mean(), self._weights[3:].mean() / np.sqrt(2.0)
        return np.concatenate([position * poses[:, :3, 3], turn * poses[:, :3, :3].reshape(-1, 9)], axis=-1)

    def _explain(
        self, found: Minimum, errors: PoseErrors, lost: Rows, reasons: NDArray[np.int8], obstacles: Obstacles
    ) -> None:
        """Say why targets in reach are not met, after a last search from where one without limits ends."""
        motion, limited = self._motion, self._limited
        enough = len(motion.joints) >= np.count_nonzero(self._asked)
        # A search that was stopped tells nothing of the joints.
        reasons[lost] = np.where(found.settled[lost] & (not enough), Reason.NOT_ENOUGH_JOINTS, Reason.NOT_CONVERGED)
        if not self._enforced:
            return
        there = PoseErrors(motion, errors.targets[lost], self._weights)
        free = self._minimum(there, self._free, found.q[lost], np.arange(lost.size))
        restarts = min(self._effort.restarts, _RESTARTS_WITHOUT_LIMITS)
        self._restart(free, there, self._free, restarts)
        values = motion.joint_values(free.q)
        bounded = np.isfinite(limited.lower) & np.isfinite(limited.upper)
        middle = 0.5 * np.where(bounded, limited.lower, 0.0) + 0.5 * np.where(bounded, limited.upper, 0.0)
        self._free.unwind(values, np.broadcast_to(middle, values.shape))
        worst = limited.worst(values)
        # What ends beside a limit may have a solution on it, and what ends inside is one.
        values[...] = limited.project(values)
        found.take(lost, self._minimum(there, limited, free.q, np.arange(lost.size)), slice(None))
        reasons[lost[found.reached[lost]]] = Reason.REACHED
        outside = free.reached & ~found.reached[lost] & worst.outside
        rows = lost[outside]
        reasons[rows] = np.where(worst.coupled[outside], Reason.COUPLED_LIMIT, Reason.JOINT_LIMIT)
        place = np.full(len(motion.robot.joint_names), -1, dtype=np.int64)
        place[motion.joints] = np.arange(len(motion.joints))
        obstacles.joint[rows] = place[worst.joint[outside]]
        obstacles.needed[rows], obstacles.limit[rows] = worst.value[outside], worst.limit[outside]


def _candidates(motion: FrameMotion, seed: int, number: int) -> tuple[Floats, Floats]:
    """Random values inside the limits of the joints that move, (256, m), and the poses in the base, (256, 4, 4).

    They are kept with the robot, for drawing them takes longer than the search that begins at one of them.
    """
    kept, key = _KEPT.setdefault(motion.robot, {}), (motion.frame, seed, number)
    found = kept.get(key)
    if found is None:
        if len(kept) >= _MOST_KEPT:
            kept.clear()
        drawn = motion.robot.random(np.random.default_rng([seed, number]), _CANDIDATES)
        # In parts that Pinocchio answers: the first target on a machine waits for no kernel.
        parts = np.array_split(drawn, _CANDIDATES // (CROSSOVER - 1) + 1)
        found = kept[key] = drawn[:, motion.columns], np.concatenate([motion.poses(part) for part in parts])
    return found
