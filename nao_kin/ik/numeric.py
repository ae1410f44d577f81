"""Inverse kinematics of any robot and frame: damped least squares inside the limits, from several starts."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import NamedTuple, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import (
    CROSSOVER,
    MAX_SEARCHES,
    Floats,
    SolverLimits,
    as_floats,
    check_tolerance,
    common_batch,
    join_poses,
    whole_number,
)
from nao_kin.errors import BadArgument
from nao_kin.ik.closed_form import cached_limb
from nao_kin.ik.least_squares import FrameMotion, Goal, Minimum, descended
from nao_kin.ik.limit_regions import LimitRegion
from nao_kin.ik.results import Codes, Family, IKResult, Integers, Obstacles, Reason, without_collisions
from nao_kin.ik.targets import check_threads, checked_reference, is_enforced, is_pose, rigid_poses, rows_of
from nao_kin.robot import CollisionRule, RobotModel

# --- The search for a pose: from a start, then from random configurations; and the reason if it fails.

# Number of random configurations, of which a restart uses the one with the pose nearest to the target. Every second
# restart uses the first one, because the nearest ones may all lead to the same local minimum, such as an elbow bent the
# wrong way.
_CANDIDATES = 256
# Restarts that run together, because four cost little more than one.
_TOGETHER = 4
# Restarts whose candidates are cached: 40 kB each.
_MAX_CACHED = 500
# Restarts of the search without limits, which tells whether limits are the reason for a failure.
_RESTARTS_WITHOUT_LIMITS = 8


class PoseResults(NamedTuple):
    """Results for n targets: the minima, and arrays (n,)."""

    minimum: Minimum
    reasons: Codes  # as in `IKResult` and `Obstacles`, like the next three
    joint: Integers
    needed: Floats
    limit: Floats
    first: NDArray[np.bool_]  # whether the search from `near` met the target


@dataclass(frozen=True, eq=False)
class PoseSearch:
    """Searches for poses of one frame, with the options of `numeric`."""

    motion: FrameMotion
    weights: Floats
    enforced: bool
    tolerance: float
    iterations: int
    restarts: int
    seed: int
    threads: int | None

    def solve(self, targets: Floats, reference: Floats) -> PoseResults:
        """Solve for n targets (n, 4, 4) from configurations (n, nq) inside the limits."""
        motion, region = self.motion, self.motion.limited if self.enforced else self.motion.free
        minimum = self._minimised(region, targets, reference)
        first, n = minimum.reached.copy(), len(targets)
        reasons, joint = np.zeros(n, dtype=np.int8), np.full(n, -1, dtype=np.int64)
        results = PoseResults(minimum, reasons, joint, np.zeros(n), np.zeros(n), first)
        if not first.all():
            beyond = np.where(first, 0.0, self._beyond(targets, reference))
            far = beyond > 0.0
            results.reasons[far], results.needed[far] = Reason.OUT_OF_REACH, beyond[far]
            self._restart(minimum, region, targets, self.restarts)
            failed = np.flatnonzero(~minimum.reached & ~far)
            if failed.size:
                self._explain(results, targets, failed)
        region.unwind(motion.joint_values(minimum.q), motion.joint_values(reference))
        return results

    def _minimised(self, region: LimitRegion, targets: Floats, q: Floats) -> Minimum:
        """Minimise ½‖e(q)‖² for targets (n, 4, 4) from starts (n, nq) inside the limits."""
        motion = self.motion
        poses, fixed = motion.in_base(targets, q).reshape(len(q), 16), region.fixed_values(motion.joint_values(q))
        goal = Goal(self.weights, self.tolerance, self.iterations)
        minimum = descended(motion.chain, region, goal, poses, fixed, q[:, motion.columns], self.threads)
        ends: Floats = np.array(q)
        ends[:, motion.columns] = minimum.q
        return replace(minimum, q=ends)

    def _beyond(self, targets: Floats, reference: Floats) -> Floats:
        """Return the distances of targets beyond the stretched limb, shape (n,) [m]; 0 for others."""
        if not self.weights[:3].all():
            return np.zeros(len(targets))
        beyond = self.motion.beyond(targets, reference)
        # Nearer targets may be met within the tolerance.
        return np.where(beyond > 2.0 * self.tolerance, beyond, 0.0)

    def _restart(self, minimum: Minimum, region: LimitRegion, targets: Floats, restarts: int) -> None:
        """Search for unmet targets from other starts; the result does not depend on how many run together."""
        done = 0
        while done < restarts:
            rows = np.flatnonzero(~minimum.reached)
            if not rows.size:
                return
            together = min(restarts - done, max(1, _TOGETHER // rows.size))
            starts = [self._start(minimum.q[rows], region, targets[rows], done + k) for k in range(together)]
            tried = self._minimised(region, np.tile(targets[rows], (together, 1, 1)), np.concatenate(starts))
            for k in range(together):
                minimum.take(rows, tried, slice(k * rows.size, (k + 1) * rows.size))
            done += together

    def _start(self, q: Floats, region: LimitRegion, targets: Floats, number: int) -> Floats:
        """Return for each target the random configuration with the nearest pose, or the first one, shape (n, nq)."""
        motion = self.motion
        drawn, poses = _candidates(motion, self.seed, number)
        if number % 2 == 1:
            drawn, poses = drawn[:1], poses[:1]
        features, wanted = self._features(poses), self._features(motion.in_base(targets, q))
        # ‖a − b‖² without ‖a‖², which is the same for all candidates.
        distances = np.square(features).sum(axis=-1) - 2.0 * wanted @ features.T
        starts: Floats = q.copy()
        starts[:, motion.columns] = drawn[np.argmin(distances, axis=-1)]
        # Coupled limits may depend on joints that do not move.
        values = motion.joint_values(starts)
        values[...] = region.project(values)
        return starts

    def _features(self, poses: Floats) -> Floats:
        """Return twelve numbers per pose, with distances equal to weighted errors, because ‖R − R_t‖² ≈ 2 φ²."""
        position, turn = self.weights[:3].mean(), self.weights[3:].mean() / np.sqrt(2.0)
        return np.concatenate([position * poses[:, :3, 3], turn * poses[:, :3, :3].reshape(-1, 9)], axis=-1)

    def _explain(self, results: PoseResults, targets: Floats, failed: NDArray[np.intp]) -> None:
        """Write why targets in reach are not met, after a last search from the end of one without limits."""
        motion, limited, unlimited, minimum = self.motion, self.motion.limited, self.motion.free, results.minimum
        # A search that was stopped early does not tell whether there are enough joints.
        too_few = minimum.settled[failed] & (len(motion.joints) < np.count_nonzero(self.weights))
        results.reasons[failed] = np.where(too_few, Reason.NOT_ENOUGH_JOINTS, Reason.NOT_CONVERGED)
        if not self.enforced:
            return
        free = self._minimised(unlimited, targets[failed], minimum.q[failed])
        self._restart(free, unlimited, targets[failed], min(self.restarts, _RESTARTS_WITHOUT_LIMITS))
        values = motion.joint_values(free.q)
        bounded = np.isfinite(limited.lower) & np.isfinite(limited.upper)
        middle = 0.5 * np.where(bounded, limited.lower, 0.0) + 0.5 * np.where(bounded, limited.upper, 0.0)
        unlimited.unwind(values, np.broadcast_to(middle, values.shape))
        worst = limited.worst(values)
        # An end outside the limits may have a solution on them, and an end inside is a solution.
        values[...] = limited.project(values)
        minimum.take(failed, self._minimised(limited, targets[failed], free.q), slice(None))
        results.reasons[failed[minimum.reached[failed]]] = Reason.REACHED
        outside = free.reached & ~minimum.reached[failed] & worst.outside
        rows = failed[outside]
        results.reasons[rows] = np.where(worst.coupled[outside], Reason.COUPLED_LIMIT, Reason.JOINT_LIMIT)
        place = np.full(len(motion.robot.joint_names), -1, dtype=np.int64)
        place[motion.joints] = np.arange(len(motion.joints))
        results.joint[rows] = place[worst.joint[outside]]
        results.needed[rows], results.limit[rows] = worst.value[outside], worst.limit[outside]


@functools.lru_cache(maxsize=_MAX_CACHED)  # drawing them takes longer than a search
def _candidates(motion: FrameMotion, seed: int, number: int) -> tuple[Floats, Floats]:
    """Return random values of the moving joints inside their limits, (256, m), and poses in the base, (256, 4, 4)."""
    drawn = motion.robot.random(np.random.default_rng([seed, number]), _CANDIDATES)
    # In parts small enough for Pinocchio: the first target on a machine does not wait for a kernel.
    parts = np.array_split(drawn, _CANDIDATES // (CROSSOVER - 1) + 1)
    return drawn[:, motion.columns], np.concatenate([motion.poses(part) for part in parts])


# --- `numeric`.

_WEIGHTS = (1.0, 0.1)
# The default weights of a pose, with six errors, and of a position, with three.
_SIX_WEIGHTS = {6: np.repeat(_WEIGHTS, 3), 3: np.repeat((1.0, 0.0), 3)}

# Targets solved at a time: few enough for their arrays to stay in a processor's cache.
_BLOCK = 2048


def numeric(
    robot: RobotModel,
    frame: str,
    target: ArrayLike,
    *,
    near: ArrayLike | None = None,
    limits: SolverLimits = "enforce",
    weights: ArrayLike = _WEIGHTS,
    restarts: SupportsIndex = 30,
    tolerance: float = 1e-8,
    iterations: SupportsIndex = 100,
    seed: SupportsIndex = 0,
    threads: SupportsIndex | None = None,
    collisions: bool | CollisionRule = False,
) -> IKResult:
    """Return joint values that bring a frame to a pose or a position, for any robot, by damped least squares.

    With the target (R_t, p_t) and the pose (R, p) of the frame, Levenberg–Marquardt steps with the exact derivative
    minimise ½‖w · (R_tᵀ (p_t − p); log(Rᵀ R_t))‖² inside boxes and coupled limits, first from `near`, then from
    other starts until one search meets the target. Only joints between the base and the frame move; all others, and a
    floating base, stay at `near`. The same arguments give the same answer, in any batch to rounding.

    A target that is not met raises nothing: `best` is then the nearest pose that was found, by the sum above. A
    solution may still exist, except if the target is farther away than the stretched limb (`OUT_OF_REACH`). If a search
    without limits meets the target, the reason is the joint with the largest excess (`JOINT_LIMIT`, `COUPLED_LIMIT`).

    Args:
        robot: any robot.
        frame: the frame to place.
        target: poses T_root_frame, shape (..., 4, 4), or positions of the frame's origin in the root with any
            orientation, shape (..., 3) [m]; (3, 3) are three positions. With a floating base the root is the world.
        near: start of the search, and values of the other joints, shape (..., nq), or the name of a posture; broadcasts
            with the targets. None for `robot.neutral()`. Outside the limits it is projected onto them, and `notes` says
            so.
        weights: weights of position errors [1/m] and of rotation errors [1/rad], two numbers; or six for x, y, z and
            the rotations about x, y, z in the axes of the target. Zero frees a component: (1, 1, 1, 0, 0.1, 0.1) leaves
            the rotation about the target's x axis free. A position has the axes of the root, and no rotation errors.
        restarts: the maximum of other starts.
        tolerance: a target is met within this error of position [m] and rotation [rad], in components with a weight.
        iterations: largest number of steps of one search.
        seed: the seed of the random starts.
        limits: as in all solvers, see `nao_kin.ik`.
        threads: as in all solvers.
        collisions: as in all solvers; other solutions are not searched for.

    Returns:
        One solution for each target that is met.

    Raises:
        NotARotation: the 3×3 part of a target is not a rotation; the error has its index and its defect.
        BadArgument: a frame that no joint moves; positions without a weight.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = nao.posture("StandInit")
        >>> result = nk.ik.numeric(nao, "LArm", nao.fk(q, "LArm"))
        >>> bool(result.success)
        True
        >>> nao.position(nk.ik.numeric(nao, "LArm", [0.1, 0.15, 0.0]).q, "LArm").round(6).tolist()
        [0.1, 0.15, 0.0]
    """
    motion = cached_limb(robot, FrameMotion, frame)
    enforced = is_enforced(limits)
    poses = is_pose(target, "target")
    six = _six_weights(weights, 6 if poses else 3)
    check_tolerance(tolerance)
    search = PoseSearch(
        motion,
        six,
        enforced,
        float(tolerance),
        restarts=whole_number(restarts, "restarts", 0, MAX_SEARCHES),
        iterations=whole_number(iterations, "iterations", 1, MAX_SEARCHES),
        seed=whole_number(seed, "seed", 0),
        threads=check_threads(threads),
    )
    targets = rigid_poses(target, "target") if poses else join_poses(np.eye(3), as_floats(target, (3,), "target"))
    notes: tuple[str, ...] = ()
    if near is None:  # no note if zero is outside the limits, as for the NAO's elbows
        start = motion.start if enforced else robot.neutral()
    else:
        start, notes = checked_reference(robot, near, enforced)
    batch = common_batch("target and near", targets.shape[:-2], start.shape[:-1])
    T_rows, reference_rows = rows_of(targets, batch, 2), np.array(rows_of(start, batch, 1))
    parts = [slice(begin, begin + _BLOCK) for begin in range(0, max(1, len(T_rows)), _BLOCK)]
    results = [search.solve(T_rows[part], reference_rows[part]) for part in parts]
    result = _result(search, reference_rows, results, batch, notes)
    return without_collisions(robot, result, collisions)


def _result(
    search: PoseSearch, reference: Floats, parts: list[PoseResults], batch: tuple[int, ...], notes: tuple[str, ...]
) -> IKResult:
    """Join the parts of a batch."""
    motion, width = search.motion, len(search.motion.joints)
    rows = [(*vars(part.minimum).values(), *part[1:]) for part in parts]
    columns = rows[0] if len(rows) == 1 else map(np.concatenate, zip(*rows, strict=True))
    q, _, residual, met, settled, reasons, joint, needed, limit, first = columns
    best, reached = q[:, motion.columns], reasons == int(Reason.REACHED)
    later = np.count_nonzero(reached & ~first)
    if later and reached.size > 1:
        notes = (*notes, f"{later} of {reached.size} targets were reached only after restarts")
    stopped = np.count_nonzero(~(met | settled))
    if stopped:
        notes = (*notes, f"{stopped} of {reached.size} searches were stopped while they still converged")
    family = Family.REDUNDANT if np.count_nonzero(search.weights) < width else Family.NONE
    return IKResult(
        joints=motion.names,
        columns=tuple(motion.columns.tolist()),
        near=reference.reshape(*batch, reference.shape[-1]),
        best=best.reshape(*batch, width),
        branches=np.where(reached[:, None], best, np.nan).reshape(*batch, 1, width),
        families=np.where(reached, family, Family.NONE).astype(np.int8).reshape(*batch, 1),
        count=reached.astype(np.int64).reshape(batch),
        reasons=reasons.reshape(batch),
        residual=residual.reshape(*batch, 2),
        obstacles=Obstacles(joint.reshape(batch), needed.reshape(batch), limit.reshape(batch)),
        notes=notes,
        units=motion.units,
    )


def _six_weights(weights: ArrayLike, used: int) -> Floats:
    """Return six weights, of which all but the first `used` are 0."""
    if weights is _WEIGHTS:
        return _SIX_WEIGHTS[used]
    values = as_floats(weights, (), "weights")
    if values.shape == (2,):
        values = np.repeat(values, 3)
    if values.shape != (6,) or (values < 0.0).any() or not values[:used].any():
        which = "them" if used == 6 else "those of a position"
        raise BadArgument(f"weights must be two or six numbers ≥ 0, and not all of {which} 0, got {values.tolist()}")
    return np.where(np.arange(6) < used, values, 0.0)
