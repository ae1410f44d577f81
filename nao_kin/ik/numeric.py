"""Inverse kinematics of any robot and frame: damped least squares inside the limits, from several starts."""

from __future__ import annotations

from typing import Literal, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike

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
from nao_kin.ik.geometry import kept_limb
from nao_kin.ik.limit_regions import LimitRegion
from nao_kin.ik.pose_search import (
    Effort,
    Found,
    FrameMotion,
    Minimum,
    PoseErrors,
    PoseSearch,
    Rows,
    minimise,
    search_space,
)
from nao_kin.ik.results import Family, IKResult, Obstacles, Reason
from nao_kin.ik.targets import Limits, check_threads, inside_limits, is_enforced, rigid_poses, with_unit_quaternion
from nao_kin.robot import RobotModel, check_robot

# --- Steps by the quadratic programs of pink, where it is installed, in the place of damped least squares.

# Damping of pink's task in proportion to the squared error, and of every joint.
_TASK_DAMPING, _JOINT_DAMPING = 1e-2, 1e-9
# A step by less has arrived [rad or m].
_STILL = 1e-9


def check_pink() -> None:
    """Refuse to go on without pink.

    Raises:
        MissingExtra: pink, or the solver of its quadratic programs, is not installed.
    """
    need_extra('solver="pink"', "pink")


def minimise_with_pink(
    errors: PoseErrors,
    region: LimitRegion,
    q: Floats,
    rows: Rows,
    tolerance: float,
    steps: int,
    threads: int | None = None,
) -> Minimum:
    """As `least_squares.minimise`, one start after the other, with the boxes as limits of each quadratic program.

    pink knows no coupled limits: after every step the joints are projected onto them.
    """
    import pink
    import pinocchio as pin
    from pink.limits import ConfigurationLimit
    from pink.tasks import FrameTask

    motion, weights = errors.motion, errors.weights
    model = motion.robot.model.copy()  # pink hangs its limits on the model
    name = model.frames[motion.robot.frame_table[motion.frame]].name
    limits = [ConfigurationLimit(model, config_limit_gain=1.0)] if region.enforced else []
    ends: Floats = q.copy()
    settled = np.zeros(len(q), dtype=np.bool_)
    for k, row in enumerate(rows):
        target = errors.targets[row]
        task = FrameTask(name, weights[:3], weights[3:], lm_damping=_TASK_DAMPING)
        task.set_target(pin.SE3(target[:3, :3], target[:3, 3]))
        for _ in range(steps):
            if errors.met(errors(ends[k : k + 1], rows[k : k + 1])[0], tolerance)[0]:
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
            ahead = motion.moved(ends[k : k + 1], step[None, motion.velocity_columns])
            values = motion.joint_values(ahead)
            values[...] = region.project(values)
            region.unwind(values)
            settled[k] = np.abs(ahead[0] - ends[k]).max() < _STILL
            ends[k] = ahead[0]
            if settled[k]:
                break
    residuals = errors(ends, rows)[0]
    return Minimum(ends, 0.5 * np.square(residuals).sum(axis=-1), errors.met(residuals, tolerance), settled)


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
        check_pink()
    space, six = kept_limb(robot, search_space, frame), _six_weights(weights)
    check_tolerance(tolerance)
    effort = Effort(
        whole_number(restarts, "restarts", 0, MOST_SEARCHES),
        float(tolerance),
        whole_number(iterations, "iterations", 1, MOST_SEARCHES),
        whole_number(seed, "seed", 0),
        minimise_with_pink if solver == "pink" else minimise,
        check_threads(threads),
    )
    targets = rigid_poses(T, "T")
    if max(1.0, np.abs(targets).max(initial=0.0)) * six.max() > LARGEST:
        raise BadArgument(f"T times weights must not exceed {LARGEST:.0e} in magnitude")
    start, notes = _start(robot, reference, enforced=enforced)
    batch = common_batch("T and reference", targets.shape[:-2], start.shape[:-1])
    T_rows = np.broadcast_to(targets, (*batch, 4, 4)).reshape(-1, 4, 4)
    reference_rows = np.array(np.broadcast_to(start, (*batch, robot.nq)).reshape(-1, robot.nq))
    search = PoseSearch(space, six, effort, enforced=enforced)
    parts = [slice(begin, begin + _BLOCK) for begin in range(0, max(1, len(T_rows)), _BLOCK)]
    found = [search.solve(T_rows[part], reference_rows[part]) for part in parts]
    redundant = np.count_nonzero(six) < len(space.motion.joints)
    family = Family.REDUNDANT if redundant else Family.NONE
    return _result(space.motion, reference_rows, found, family, batch, notes)


def _result(
    motion: FrameMotion,
    reference: Floats,
    found: list[Found],
    family: Family,
    batch: tuple[int, ...],
    notes: tuple[str, ...],
) -> IKResult:
    """The parts of a batch as one answer."""
    best = np.concatenate([part.q for part in found])[:, motion.columns]
    reasons = np.concatenate([part.reasons for part in found])
    joint, needed, limit = (
        np.concatenate([getattr(part.obstacles, name) for part in found]).reshape(batch)
        for name in ("joint", "needed", "limit")
    )
    reached = reasons == Reason.REACHED
    later = np.count_nonzero(reached & ~np.concatenate([part.first for part in found]))
    if later and reached.size > 1:
        notes = (*notes, f"{later} of {reached.size} targets were reached only after restarts")
    stopped = np.count_nonzero(~np.concatenate([part.settled for part in found]))
    if stopped:
        notes = (*notes, f"{stopped} of {reached.size} searches were stopped while they still came nearer")
    width = len(motion.joints)
    return IKResult(
        joints=motion.names,
        columns=tuple(motion.columns.tolist()),
        reference=reference.reshape(*batch, reference.shape[-1]),
        best=best.reshape(*batch, width),
        branches=np.where(reached[:, None], best, np.nan).reshape(*batch, 1, width),
        families=np.where(reached, family, Family.NONE).astype(np.int8).reshape(*batch, 1),
        count=reached.astype(np.int64).reshape(batch),
        reasons=reasons.reshape(batch),
        residual=np.concatenate([part.residual for part in found]).reshape(*batch, 2),
        obstacles=Obstacles(joint, needed, limit),
        notes=notes,
        units=tuple(motion.robot.joint_units[index] for index in motion.joints),
    )


def _start(robot: RobotModel, reference: ArrayLike | None, *, enforced: bool) -> tuple[Floats, tuple[str, ...]]:
    """Where searches begin, inside the limits if these are enforced, and a note where that is not the reference."""
    if reference is None:  # where zero is outside the limits, as NAO's elbows are, is nothing the caller has done
        return robot.clamp(robot.neutral()) if enforced else robot.neutral(), ()
    return inside_limits(robot, reference) if enforced else (with_unit_quaternion(robot, reference), ())


def _six_weights(weights: ArrayLike) -> Floats:
    with np.errstate(over="ignore"):
        values = as_floats(weights, (), "weights")
    if values.shape == (2,):
        values = np.repeat(values, 3)
    if values.shape != (6,) or (values < 0.0).any() or not values.any():
        raise BadArgument(f"weights must be two or six numbers ≥ 0, and not all of them 0, got {values.tolist()}")
    return values
