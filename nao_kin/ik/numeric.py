"""Inverse kinematics of any robot and frame: damped least squares inside the limits, from several starts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple, SupportsIndex
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import (
    LARGEST,
    MOST_SEARCHES,
    Floats,
    as_floats,
    check_tolerance,
    choice,
    common_batch,
    whole_number,
)
from nao_kin._core.warn import need_extra
from nao_kin.errors import BadArgument
from nao_kin.ik.descent import FrameMotion, Goal, Minimum, descended
from nao_kin.ik.geometry import cached_limb
from nao_kin.ik.limit_regions import LimitRegion
from nao_kin.ik.results import Codes, Family, IKResult, Integers, Obstacles, Reason
from nao_kin.ik.targets import Limits, check_threads, inside_limits, is_enforced, rigid_poses, with_unit_quaternion
from nao_kin.robot import CROSSOVER, RobotModel, check_robot
from nao_kin.rotations import log

# --- The search for a pose: from a reference, then from random configurations that are near; and why it fails.

Rows = NDArray[np.intp]
Mask = NDArray[np.bool_]
_Kept = dict[tuple[str, int, int], tuple[Floats, Floats]]

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


class Found(NamedTuple):
    """What was found for n targets.

    Attributes:
        minimum: configurations that meet the targets, or come nearest.
        reasons: a `Reason` for each, shape (n,).
        joint: the joint that stands in the way, as in `Obstacles`, shape (n,).
        needed: what it would have to be, or how far the target is out of reach, shape (n,).
        limit: its limit, shape (n,).
        first: the first search, from the reference, has met the target, shape (n,).
    """

    minimum: Minimum
    reasons: Codes
    joint: Integers
    needed: Floats
    limit: Floats
    first: Mask


@dataclass(frozen=True, eq=False)
class PoseSearch:
    """Searches for poses of one frame.

    Attributes:
        motion: what moves the frame.
        weights: of the six errors, shape (6,); zero for what does not matter.
        enforced: whether limits hold.
        tolerance: errors of position and rotation that are small enough [m, rad].
        iterations: steps of one search, at most.
        restarts: starts beside the reference, at most.
        seed: of the random starts.
        threads: how many threads may work; None for all cores where that is worthwhile.
        minimise: how one search is made, `minimise` or `minimise_with_pink`.
    """

    motion: FrameMotion
    weights: Floats
    enforced: bool
    tolerance: float
    iterations: int
    restarts: int
    seed: int
    threads: int | None
    minimise: Callable[[PoseSearch, LimitRegion, Floats, Floats], Minimum]

    def solve(self, targets: Floats, reference: Floats) -> Found:
        """Configurations for n targets, shape (n, 4, 4), from references inside the limits, shape (n, nq)."""
        motion, region = self.motion, self.motion.limited if self.enforced else self.motion.free
        minimum = self.minimise(self, region, targets, reference)
        first, n = minimum.reached.copy(), len(targets)
        found = Found(
            minimum, np.zeros(n, dtype=np.int8), np.full(n, -1, dtype=np.int64), np.zeros(n), np.zeros(n), first
        )
        if not first.all():
            beyond = np.where(first, 0.0, self._beyond(targets, reference))
            far = beyond > 0.0
            found.reasons[far], found.needed[far] = Reason.OUT_OF_REACH, beyond[far]
            self._restart(minimum, region, targets, self.restarts)
            lost = np.flatnonzero(~minimum.reached & ~far)
            if lost.size:
                self._explain(found, targets, lost)
        region.unwind(motion.joint_values(minimum.q), motion.joint_values(reference))
        return found

    def _beyond(self, targets: Floats, reference: Floats) -> Floats:
        """How far targets are farther away than the stretched limb, shape (n,) [m]; 0 where they are not."""
        if not self.weights[:3].all():
            return np.zeros(len(targets))
        beyond = self.motion.beyond(targets, reference)
        # What counts as met may lie so far outside.
        return np.where(beyond > 2.0 * self.tolerance, beyond, 0.0)

    def _restart(self, found: Minimum, region: LimitRegion, targets: Floats, restarts: int) -> None:
        """Search on from other starts for targets not met, until one meets the target.

        Which start that is does not depend on how many are run side by side.
        """
        done = 0
        while done < restarts:
            rows = np.flatnonzero(~found.reached)
            if not rows.size:
                return
            together = min(restarts - done, max(1, _SIDE_BY_SIDE // rows.size))
            starts = [self._start(found.q[rows], region, targets[rows], done + k) for k in range(together)]
            tried = self.minimise(self, region, np.tile(targets[rows], (together, 1, 1)), np.concatenate(starts))
            for k in range(together):
                found.take(rows, tried, slice(k * rows.size, (k + 1) * rows.size))
            done += together

    def _start(self, q: Floats, region: LimitRegion, targets: Floats, number: int) -> Floats:
        """For each target, the one of some random configurations whose pose is nearest, or any; shape (n, nq)."""
        motion = self.motion
        drawn, poses = _candidates(motion, self.seed, number)
        if number % 2 == 1:
            drawn, poses = drawn[:1], poses[:1]
        features, wanted = self._features(poses), self._features(motion.in_base(targets, q))
        # ‖a − b‖² without ‖a‖², which is the same for all.
        distances = np.square(features).sum(axis=-1) - 2.0 * wanted @ features.T
        starts: Floats = q.copy()
        starts[:, motion.columns] = drawn[np.argmin(distances, axis=-1)]
        # Ranges may depend on joints that stay where they are.
        values = motion.joint_values(starts)
        values[...] = region.project(values)
        return starts

    def _features(self, poses: Floats) -> Floats:
        """Twelve numbers of each pose, with distances like those of the weighted errors: ‖R − R_t‖² ≈ 2 φ²."""
        position, turn = self.weights[:3].mean(), self.weights[3:].mean() / np.sqrt(2.0)
        return np.concatenate([position * poses[:, :3, 3], turn * poses[:, :3, :3].reshape(-1, 9)], axis=-1)

    def _explain(self, found: Found, targets: Floats, lost: Rows) -> None:
        """Say why targets in reach are not met, after a last search from where one without limits ends."""
        motion, limited, unlimited, minimum = self.motion, self.motion.limited, self.motion.free, found.minimum
        # A search that was stopped tells nothing of the joints.
        too_few = minimum.settled[lost] & (len(motion.joints) < np.count_nonzero(self.weights))
        found.reasons[lost] = np.where(too_few, Reason.NOT_ENOUGH_JOINTS, Reason.NOT_CONVERGED)
        if not self.enforced:
            return
        free = self.minimise(self, unlimited, targets[lost], minimum.q[lost])
        self._restart(free, unlimited, targets[lost], min(self.restarts, _RESTARTS_WITHOUT_LIMITS))
        values = motion.joint_values(free.q)
        bounded = np.isfinite(limited.lower) & np.isfinite(limited.upper)
        middle = 0.5 * np.where(bounded, limited.lower, 0.0) + 0.5 * np.where(bounded, limited.upper, 0.0)
        unlimited.unwind(values, np.broadcast_to(middle, values.shape))
        worst = limited.worst(values)
        # What ends beside a limit may have a solution on it, and what ends inside is one.
        values[...] = limited.project(values)
        minimum.take(lost, self.minimise(self, limited, targets[lost], free.q), slice(None))
        found.reasons[lost[minimum.reached[lost]]] = Reason.REACHED
        outside = free.reached & ~minimum.reached[lost] & worst.outside
        rows = lost[outside]
        found.reasons[rows] = np.where(worst.coupled[outside], Reason.COUPLED_LIMIT, Reason.JOINT_LIMIT)
        place = np.full(len(motion.robot.joint_names), -1, dtype=np.int64)
        place[motion.joints] = np.arange(len(motion.joints))
        found.joint[rows] = place[worst.joint[outside]]
        found.needed[rows], found.limit[rows] = worst.value[outside], worst.limit[outside]


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


def minimise(search: PoseSearch, region: LimitRegion, targets: Floats, q: Floats) -> Minimum:
    """Lessen ½‖e(q)‖² from starts (n, nq) inside the limits, one for each of the targets (n, 4, 4)."""
    motion = search.motion
    poses, still = motion.in_base(targets, q).reshape(len(q), 16), region.still_values(motion.joint_values(q))
    goal = Goal(search.weights, search.tolerance, search.iterations)
    found = descended(motion.chain, region, goal, poses, still, q[:, motion.columns], search.threads)
    ends: Floats = np.array(q)
    ends[:, motion.columns] = found.q
    return replace(found, q=ends)


# --- Steps by the quadratic programs of pink, where it is installed, in the place of damped least squares.

# Damping of pink's task in proportion to the squared error, and of every joint.
_TASK_DAMPING, _JOINT_DAMPING = 1e-2, 1e-9
# A step by less has arrived [rad or m].
_ARRIVED = 1e-9


def minimise_with_pink(search: PoseSearch, region: LimitRegion, targets: Floats, q: Floats) -> Minimum:
    """As `minimise`, one start after the other, with the boxes as limits of each quadratic program.

    pink knows no coupled limits: after every step the joints are projected onto them.
    """
    import pink
    import pinocchio as pin
    from pink.limits import ConfigurationLimit
    from pink.tasks import FrameTask

    motion, weights = search.motion, search.weights
    model = motion.robot.model.copy()  # pink hangs its limits on the model
    name = model.frames[motion.robot.frame_table[motion.frame]].name
    limits = [ConfigurationLimit(model, config_limit_gain=1.0)] if region.enforced else []
    ends: Floats = q.copy()
    settled = np.zeros(len(q), dtype=np.bool_)
    for k, target in enumerate(targets):
        task = FrameTask(name, weights[:3], weights[3:], lm_damping=_TASK_DAMPING)
        task.set_target(pin.SE3(target[:3, :3], target[:3, 3]))
        for _ in range(search.iterations):
            if (_residual(search, target[None], ends[k : k + 1]) <= search.tolerance).all():
                break
            configuration = pink.Configuration(model, model.createData(), ends[k])
            step = pink.solve_ik(
                configuration,
                [task],
                1.0,
                solver="quadprog",
                damping=_JOINT_DAMPING,
                limits=limits,
                safety_break=False,
            )
            ahead = ends[k : k + 1].copy()
            ahead[:, motion.columns] += step[motion.velocity_columns]
            values = motion.joint_values(ahead)
            values[...] = region.project(values)
            region.unwind(values)
            settled[k] = np.abs(ahead[0] - ends[k]).max() < _ARRIVED
            ends[k] = ahead[0]
            if settled[k]:
                break
    residual = _residual(search, targets, ends)
    cost = 0.5 * np.square(weights * pose_errors(motion.poses(ends), targets)).sum(axis=-1)
    return Minimum(ends, cost, residual, np.asarray((residual <= search.tolerance).all(axis=-1)), settled)


def _residual(search: PoseSearch, targets: Floats, q: Floats) -> Floats:
    """Errors in position and angle of what has a weight, shape (n, 2) [m, rad]."""
    errors = pose_errors(search.motion.poses(q), targets) * (search.weights > 0.0)
    return np.asarray(np.linalg.norm(errors.reshape(-1, 2, 3), axis=-1))


def pose_errors(poses: Floats, targets: Floats) -> Floats:
    """(R_tᵀ (p_t − p); log(Rᵀ R_t)) of poses (n, 4, 4) and targets (n, 4, 4), shape (n, 6) [m, rad]."""
    R, R_target = poses[:, :3, :3], targets[:, :3, :3]
    away = np.einsum("nji,nj->ni", R_target, targets[:, :3, 3] - poses[:, :3, 3])
    return np.concatenate([away, log(R.swapaxes(-1, -2) @ R_target)], axis=-1)


# --- Inverse kinematics of any robot and frame: damped least squares inside the limits, from several starts.

Solver = Literal["least squares", "pink"]
_SOLVERS = ("least squares", "pink")

# Targets that are worked on at a time: few enough for their arrays to stay in a processor's cache.
_BLOCK = 2048


def numeric(
    robot: RobotModel,
    frame: str,
    T: ArrayLike,
    *,
    reference: ArrayLike | None = None,
    limits: Limits = "enforce",
    weights: ArrayLike = (1.0, 0.1),
    restarts: SupportsIndex = 30,
    tolerance: float = 1e-8,
    iterations: SupportsIndex = 100,
    seed: SupportsIndex = 0,
    solver: Solver = "least squares",
    threads: SupportsIndex | None = None,
) -> IKResult:
    """Joint values that take a frame to a pose, for any robot, by damped least squares.

    With the target (R_t, p_t) and the pose (R, p) of the frame, ½‖w · (R_tᵀ (p_t − p); log(Rᵀ R_t))‖² is made small by
    Levenberg–Marquardt steps with its exact derivative, inside boxes and coupled limits, first from `reference`, then
    from other starts until one search meets the target. Only joints between the base and the frame move; all others,
    and a floating base, stay at `reference`. The same arguments give the same answer, in any batch to rounding.

    A target that is not met raises nothing: `best` is then the nearest pose that was found, by the sum above. That no
    solution was found does not prove that there is none, except where the target is farther away than the stretched
    limb (`OUT_OF_REACH`). If a search without limits meets the target, the reason is the joint that is then farthest
    outside its own (`JOINT_LIMIT`, `COUPLED_LIMIT`).

    Args:
        robot: any robot.
        frame: the frame to place.
        T: targets T_root_frame, shape (..., 4, 4) [m]; with a floating base the root is the world.
        reference: where the search begins and what the other joints are at, shape (..., nq); broadcasts with T. None
            for `robot.neutral()`. Outside the limits it is projected onto them, and `notes` says so.
        limits: "enforce" or "ignore" for boxes and coupled limits.
        weights: of position errors [1/m] and of rotation errors [1/rad], two numbers; or six for x, y, z and the turns
            about x, y, z in the axes of the target. Zero for what does not matter: (1, 1, 1, 0, 0.1, 0.1) leaves the
            turn about the target's x axis free.
        restarts: other starts to try, at most.
        tolerance: a target is met when the position is off by at most so many metres and the rotation by at most so
            many radians, in what has a weight.
        iterations: steps of one search, at most.
        seed: of the random starts.
        solver: "least squares" as above; "pink" for steps by the quadratic programs of pink, one target after the
            other, where the extra is installed.
        threads: how many threads may work on a batch; None for all cores where that is worthwhile.

    Returns:
        One solution for each target that is met.

    Raises:
        UnknownName: no such frame, or no such choice of limits or solver.
        MissingExtra: pink is asked for and not installed.
        NotARotation: a target has no rotation; names the argument, its index and its defect.
        BadArgument: no robot, a frame that nothing moves, a last row other than (0, 0, 0, 1), numbers of T, or
            of T times weights, beyond ±1e150, or options that make no sense.
        WrongShape, NotFinite: wrong or mismatched shapes, NaN or infinity.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = nao.posture("StandInit")
        >>> result = nk.ik.numeric(nao, "LArm", nao.fk(q, "LArm"))
        >>> bool(result.success)
        True
    """
    check_robot(robot)
    enforced = is_enforced(limits)
    if choice(solver, _SOLVERS, "solver") == "pink":
        need_extra('solver="pink"', "pink")
    motion, six = cached_limb(robot, FrameMotion, frame), _six_weights(weights)
    check_tolerance(tolerance)
    search = PoseSearch(
        motion,
        six,
        enforced,
        float(tolerance),
        restarts=whole_number(restarts, "restarts", 0, MOST_SEARCHES),
        iterations=whole_number(iterations, "iterations", 1, MOST_SEARCHES),
        seed=whole_number(seed, "seed", 0),
        threads=check_threads(threads),
        minimise=minimise_with_pink if solver == "pink" else minimise,
    )
    targets = rigid_poses(T, "T")
    if max(1.0, np.abs(targets).max(initial=0.0)) * six.max() > LARGEST:
        raise BadArgument(f"T times weights must not exceed {LARGEST:.0e} in magnitude")
    notes: tuple[str, ...] = ()
    if reference is None:  # where zero is outside the limits, as NAO's elbows are, is nothing the caller has done
        start = motion.start if enforced else robot.neutral()
    elif enforced:
        start, notes = inside_limits(robot, reference)
    else:
        start = with_unit_quaternion(robot, reference)
    batch = common_batch("T and reference", targets.shape[:-2], start.shape[:-1])
    T_rows = np.broadcast_to(targets, (*batch, 4, 4)).reshape(-1, 4, 4)
    reference_rows = np.array(np.broadcast_to(start, (*batch, robot.nq)).reshape(-1, robot.nq))
    parts = [slice(begin, begin + _BLOCK) for begin in range(0, max(1, len(T_rows)), _BLOCK)]
    found = [search.solve(T_rows[part], reference_rows[part]) for part in parts]
    return _result(search, reference_rows, found, batch, notes)


def _result(
    search: PoseSearch, reference: Floats, parts: list[Found], batch: tuple[int, ...], notes: tuple[str, ...]
) -> IKResult:
    """The parts of a batch as one answer."""
    motion, width = search.motion, len(search.motion.joints)
    minima = (vars(part.minimum).values() for part in parts)
    q, _, residual, met, settled = (np.concatenate(arrays) for arrays in zip(*minima, strict=True))
    columns = list(zip(*parts, strict=True))[1:]
    reasons, joint, needed, limit, first = (np.concatenate(arrays) for arrays in columns)
    best, reached = q[:, motion.columns], reasons == Reason.REACHED
    later = np.count_nonzero(reached & ~first)
    if later and reached.size > 1:
        notes = (*notes, f"{later} of {reached.size} targets were reached only after restarts")
    stopped = np.count_nonzero(~(met | settled))
    if stopped:
        notes = (*notes, f"{stopped} of {reached.size} searches were stopped while they still came nearer")
    family = Family.REDUNDANT if np.count_nonzero(search.weights) < width else Family.NONE
    return IKResult(
        joints=motion.names,
        columns=tuple(motion.columns.tolist()),
        reference=reference.reshape(*batch, reference.shape[-1]),
        best=best.reshape(*batch, width),
        branches=np.where(reached[:, None], best, np.nan).reshape(*batch, 1, width),
        families=np.where(reached, family, Family.NONE).astype(np.int8).reshape(*batch, 1),
        count=reached.astype(np.int64).reshape(batch),
        reasons=reasons.reshape(batch),
        residual=residual.reshape(*batch, 2),
        obstacles=Obstacles(joint.reshape(batch), needed.reshape(batch), limit.reshape(batch)),
        notes=notes,
        units=tuple(motion.robot.joint_units[index] for index in motion.joints),
    )


def _six_weights(weights: ArrayLike) -> Floats:
    with np.errstate(over="ignore"):
        values = as_floats(weights, (), "weights")
    if values.shape == (2,):
        values = np.repeat(values, 3)
    if values.shape != (6,) or (values < 0.0).any() or not values.any():
        raise BadArgument(f"weights must be two or six numbers ≥ 0, and not all of them 0, got {values.tolist()}")
    return values
