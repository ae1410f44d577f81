"""The search for a pose: from a reference, then from random configurations that are near; and why it fails."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, cast
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument
from nao_kin.ik.compiling import copied, in_lists, kept, run_rows
from nao_kin.ik.descent import COST, MET, SETTLED, TABLE, Bench, Chain, Goal, Region, descend, room_for
from nao_kin.ik.limit_regions import LimitRegion, region_type
from nao_kin.ik.results import Obstacles, Reason
from nao_kin.robot import CROSSOVER, Expression, RobotModel, serial_chain
from nao_kin.robot.semantics import Mimic
from nao_kin.rotations import left_jacobian_inverse, log, matrix_from_quat, quat_from_xyzw

# --- How far a frame is from where it should be, with the exact derivative.


class FrameMotion:
    """What moves a frame: some joints of a robot. All other joints and a floating base stay where they are.

    Attributes:
        frame: the frame.
        joints: places of the joints that move it in `RobotModel.joint_names`, from the base outwards, shape (m,).
        names: their names.
        columns: their places in q, shape (m,).
        velocity_columns: their places in velocities, shape (m,).

    Raises:
        UnknownName: no such frame.
        BadArgument: no joint moves the frame.
    """

    def __init__(self, robot: RobotModel, frame: str) -> None:
        # What is kept of a robot must not keep the robot.
        self._robot, self.frame = weakref.ref(robot), frame
        self._serial_chain = serial_chain(robot, robot.tree.root, frame)
        self.names = self._serial_chain.coordinates
        if not self.names:
            raise BadArgument(f"no joint moves {quoted(frame)}")
        self.joints = np.array([robot.joint_names.index(name) for name in self.names], dtype=np.intp)
        self._offset = robot.nq - len(robot.joint_names)
        self.columns = self._offset + self.joints
        self.velocity_columns = robot.nv - len(robot.joint_names) + self.joints

    @property
    def robot(self) -> RobotModel:
        """Whose frame it is."""
        return cast(RobotModel, self._robot())  # whoever asks has it

    @cached_property
    def chain(self) -> Chain:
        """The joints from the base to the frame, for scalar code."""
        chain = self._serial_chain
        place = {name: k for k, name in enumerate(self.names)}
        return Chain(
            joints=np.array([len(chain.drivers)], dtype=np.int64),
            links=chain.placements.reshape(-1).copy(),
            slides=np.array(chain.slides, dtype=np.float64),
            place=np.array([place.get(driver.joint, -1) for driver in chain.drivers], dtype=np.int64),
            ratio=np.array([driver.multiplier for driver in chain.drivers], dtype=np.float64),
            offset=np.array([driver.offset for driver in chain.drivers], dtype=np.float64),
        )

    def joint_values(self, q: Floats) -> Floats:
        """The values of all joints, shape (n, joints); a view."""
        return q[:, self._offset :]

    def poses(self, q: Floats) -> Floats:
        """T_root_frame, shape (n, 4, 4)."""
        if len(q) == 1:  # one configuration is answered in fewer steps
            return np.asarray(self.robot.fk(q[0], self.frame))[None]
        return np.asarray(self.robot.fk(q, self.frame))

    def jacobians(self, q: Floats, expressed_in: Expression = "mixed") -> Floats:
        """Twists of the frame for unit speeds of the joints that move it, shape (n, 6, m)."""
        if len(q) == 1:
            return np.asarray(self.robot.jacobian(q[0], self.frame, expressed_in)[None, :, self.velocity_columns])
        return np.asarray(self.robot.jacobian(q, self.frame, expressed_in)[..., self.velocity_columns])

    def moved(self, q: Floats, steps: Floats) -> Floats:
        """Configurations after steps of shape (n, m), limits not looked at."""
        result: Floats = q.copy()
        result[:, self.columns] += steps
        return result

    def in_base(self, poses: Floats, q: Floats) -> Floats:
        """T_base_frame from T_root_frame, shape (n, 4, 4): the same with a fixed base."""
        if self.robot.base == "fixed":
            return poses
        R = matrix_from_quat(quat_from_xyzw(q[:, 3:7])).swapaxes(-1, -2)
        moved: Floats = poses.copy()
        moved[:, :3, :3] = R @ poses[:, :3, :3]
        moved[:, :3, 3] = np.einsum("nij,nj->ni", R, poses[:, :3, 3] - q[:, :3])
        return moved

    def reach(self, q: Floats) -> tuple[Floats, float]:
        """Where the frame can be at most: a point that stays, shape (n, 3), and a distance from it [m].

        The point is the first joint's; the distance is that of the chain drawn out to a straight line, which the frame
        cannot exceed whatever the joints do. Infinite with a sliding joint that has no limits.
        """
        robot, model = self.robot, self.robot.model
        place = model.frames[robot.frame_ids([self.frame])[0]]
        chain, joint_id = [], int(place.parentJoint)
        while joint_id > 0 and (joint_id > 1 or robot.base == "fixed"):
            chain.append(joint_id)
            joint_id = int(model.parents[joint_id])
        distance = float(np.linalg.norm(place.placement.translation))
        distance += sum(float(np.linalg.norm(model.jointPlacements[index].translation)) for index in chain[:-1])
        slides = {joint.name for joint in robot.tree.moving_joints if joint.kind == "prismatic"}
        for name in slides & {str(model.names[index]) for index in chain}:
            mimic = robot.mimics.get(name, Mimic(name))
            driver = robot.joint_names.index(mimic.joint)
            ends = mimic.range(float(robot.lower[driver]), float(robot.upper[driver]))
            distance += max(map(abs, ends))
        first: Floats = np.broadcast_to(model.jointPlacements[chain[-1]].translation, (len(q), 3))
        if robot.base == "floating":
            R = matrix_from_quat(quat_from_xyzw(q[:, 3:7]))
            first = q[:, :3] + np.einsum("nij,nj->ni", R, first)
        return first, distance


class PoseErrors:
    """Weighted differences between the poses of a frame and its targets, in the axes of the targets.

    With the target (R_t, p_t) and the pose (R, p), e = w · (R_tᵀ (p_t − p); log(Rᵀ R_t)). The logarithm is the turn
    that is left to make; its coordinates are the same in the axes of the frame and of the target.

    Attributes:
        motion: what moves the frame.
        targets: T_root_target, shape (n, 4, 4).
        weights: of the six numbers, shape (6,).
    """

    def __init__(self, motion: FrameMotion, targets: Floats, weights: Floats) -> None:
        self.motion, self.targets, self.weights = motion, targets, weights

    def __call__(self, q: Floats, rows: NDArray[np.intp]) -> tuple[Floats, Floats]:
        """Errors and their derivatives.

        Args:
            q: configurations, shape (n, nq).
            rows: the target of each, shape (n,).

        Returns:
            Weighted errors, shape (n, 6), and what they change by for each unit of a step, shape (n, 6, m).
        """
        targets, poses = self.targets[rows], self.motion.poses(q)
        errors = _pose_errors(poses, targets)
        J = self.motion.jacobians(q)
        derivatives = np.empty_like(J)
        derivatives[:, :3] = -targets[:, :3, :3].swapaxes(-1, -2) @ J[:, :3]
        # The turn left to make is Rᵀ R_t, which a rotation of the frame changes from the left.
        derivatives[:, 3:] = -(left_jacobian_inverse(errors[:, 3:]) @ poses[:, :3, :3].swapaxes(-1, -2)) @ J[:, 3:]
        return errors * self.weights, derivatives * self.weights[:, None]

    def met(self, errors: Floats, tolerance: float) -> NDArray[np.bool_]:
        """Which weighted errors (n, 6) are small enough in what has a weight, shape (n,)."""
        scale = np.divide(1.0, self.weights, out=np.zeros(6), where=self.weights > 0.0)
        squares = np.square(errors * scale)
        return np.asarray((squares[:, :3].sum(axis=-1) <= tolerance**2) & (squares[:, 3:].sum(axis=-1) <= tolerance**2))

    def residuals(self, q: Floats) -> Floats:
        """Errors without weights of one configuration for each target, shape (n, 6) [m, rad]."""
        return _pose_errors(self.motion.poses(q), self.targets)


def _pose_errors(poses: Floats, targets: Floats) -> Floats:
    """(R_tᵀ (p_t − p); log(Rᵀ R_t)) of poses (n, 4, 4) and targets (n, 4, 4), shape (n, 6) [m, rad]."""
    R, R_target = poses[:, :3, :3], targets[:, :3, :3]
    errors = np.empty((len(poses), 6))
    errors[:, :3] = np.einsum("nji,nj->ni", R_target, targets[:, :3, 3] - poses[:, :3, 3])
    errors[:, 3:] = log(R.swapaxes(-1, -2) @ R_target)
    return errors


# --- Damped least squares from many starts: `descent_equations` run as Python on one, compiled on many.

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


# --- The search for a pose: from a reference, then from random configurations that are near; and why it fails.

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
