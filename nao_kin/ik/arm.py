"""`arm`: the five joints of an arm, for a pose of the hand, its place and direction, or its place alone."""

from __future__ import annotations

import dataclasses
import math
from functools import partial
from typing import Literal, NamedTuple, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import (
    LARGEST,
    Floats,
    as_floats,
    as_numbers,
    as_vectors,
    check_tolerance,
    choice,
    common_batch,
    unit,
)
from nao_kin._kernels.cache import both_ways
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.ik.arm_equations import (
    JOINTS,
    MOST_BRANCHES,
    Arm,
    circle_of,
    elbow_of,
    forward,
    hand_of,
    hand_on_circle,
    out_of_reach,
    solve_arm,
    solve_direction,
    write_elbow,
    write_other_elbow,
    write_shoulder,
)
from nao_kin.ik.compiling import Row
from nao_kin.ik.geometry import (
    ClosedForm,
    Limb,
    X,
    Y,
    Z,
    chain_at_zero,
    check_side,
    kept_limb,
    limb_of,
    limb_types,
    solved,
)
from nao_kin.ik.quadratic_program import cholesky, solve_cholesky
from nao_kin.ik.ranges import (
    ANGLE_ERROR,
    BEST,
    LIMIT_ROUNDING,
    NOT_ENOUGH_JOINTS,
    NOT_RIGID,
    POSITION_ERROR,
    REASON,
    Pose,
    Selection,
    Workspace,
    add_branch,
    farthest_outside,
    finish_report,
    report_limit,
    squared_distance,
    start_report,
    wrapped,
)
from nao_kin.ik.results import Family, IKResult
from nao_kin.ik.targets import Limits, as_poses, as_reference, check_threads, is_enforced, refuse_not_rigid
from nao_kin.robot import RobotModel

# Criteria of a position, as a number in its target.
NEAREST, LIMITS, MANIPULABILITY = 0.0, 1.0, 2.0
Criterion = Literal["nearest", "limits", "manipulability"]
_CRITERIA = {"nearest": NEAREST, "limits": LIMITS, "manipulability": MANIPULABILITY}
_WEIGHT = 0.1
_JOINTS = ("ShoulderPitch", "ShoulderRoll", "ElbowYaw", "ElbowRoll", "WristYaw")


def arm(
    robot: RobotModel,
    side: str,
    target: ArrayLike,
    *,
    direction: ArrayLike | None = None,
    criterion: Criterion = "nearest",
    angle_weight: float = _WEIGHT,
    frame: str | None = None,
    reference: ArrayLike | None = None,
    limits: Limits = "enforce",
    threads: SupportsIndex | None = None,
) -> IKResult:
    """Joint values of an arm for a pose of its hand, for place and direction, or for a place.

    - A pose (..., 4, 4) is six numbers, one more than there are joints: the arm makes it where the elbow that it asks
      for is as far from the shoulder as the upper arm is long. Then all branches are given, up to four.
    - A place (..., 3) and a `direction` of the forearm, which is that of the hand, are five: up to eight branches.
    - A place alone leaves two joints free: the one member of that family that is best by `criterion`.

    Where a target is not met, `best` and `q` are the joint values nearest to it, inside the limits if these are
    enforced: with the smallest √(distance² + (angle_weight · angle)²); `residual` has the distance and the angle.
    `success` is then False and `reason` says why.

    Args:
        robot: a NAO of any version, or another robot with arms of its geometry.
        side: "L" or "R".
        target: poses of the frame in the torso, shape (..., 4, 4), or places of its origin, shape (..., 3) [m].
        direction: with places: where the forearm's x axis is to point, in the torso, of any length but zero; shape
            (..., 3), broadcasts with the places.
        criterion: with places alone: "nearest" to the reference, "limits" for the largest distance to the nearest
            limit as a share of that joint's range, or "manipulability" for the largest √det(J_v J_vᵀ). The choice is
            searched for on a grid, and from its valleys by steps down to 1e-9 rad.
        angle_weight: what one radian counts [m]: 0.1 makes 0.1 rad as bad as 10 mm.
        frame: a frame on the hand; None for the end effector "LArm" or "RArm".
        reference: configurations that broadcast with the targets, shape (..., nq): solutions are sorted by their
            distance to it, and take from it the joints that are not of this arm. None for all joints at zero, or at
            the limit nearest to it.
        limits: "enforce" leaves out branches with a joint outside its limits; "ignore" gives all, each joint with the
            whole turns that bring it within half a turn of the reference; with criterion "limits" within ±π.
        threads: how many threads may work on a batch; None for all cores where that is worthwhile.

    Returns:
        Solutions to within 1e-10 m and rad. Five joints make no pose that is rounded, to float32 for instance: its
        reason is `NOT_ENOUGH_JOINTS`, `q` the nearest, and `residual` what is left, some 1e-8 m and rad. A family of
        solutions is there once: the elbow on the axis of ShoulderPitch (`SHOULDER_AXIS`), the stretched arm
        (`ELBOW_LOCK`), a place alone (`REDUNDANT`).

    Raises:
        UnknownName: no such side, frame, criterion or policy.
        BadArgument: the robot has no such arm; the message says what is missing. Or the last row of a target is not
            0, 0, 0, 1, a number is beyond ±1e150, `angle_weight` no length above zero, or a direction comes with poses.
        NotARotation: a target has no rotation; names the argument, its index and its defect.
        ZeroNorm: a direction is zero.
        WrongShape, NotFinite: arrays of other shapes, NaN or infinity.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = nao.posture("StandInit")
        >>> result = nk.ik.arm(nao, "L", nao.fk(q, "LArm"))
        >>> bool(np.abs(nao.fk(result.q, "LArm") - nao.fk(q, "LArm")).max() < 1e-9)
        True
    """
    check_side(side)
    limb = arm_limb(robot, side, frame)
    enforce, workers = is_enforced(limits), check_threads(threads)
    wanted = _CRITERIA[choice(criterion, _CRITERIA, "criterion")]
    if angle_weight is not _WEIGHT:
        check_tolerance(angle_weight, "angle_weight")
        weight = float(angle_weight)
        if not 0.0 < weight <= LARGEST:
            raise BadArgument(
                f"angle_weight must be a length above zero, and at most {LARGEST:.0e}, got {angle_weight}"
            )
        limb = dataclasses.replace(limb, numbers=limb.numbers._replace(weight=weight))
    numbers = as_numbers(target, "target")
    if numbers.shape[-2:] == (4, 4):
        if direction is not None:
            raise BadArgument("a direction goes with places (..., 3), a pose (..., 4, 4) has one")
        T = as_poses(numbers, "target")
        rows = T.reshape(*T.shape[:-2], 16)
        references = as_reference(robot, limb.rest, reference, T.shape[:-2], enforce)
        return solved(_POSE, limb, rows, references, enforce, workers, lambda: refuse_not_rigid(T, "target"))
    if numbers.shape[-1:] != (3,):
        raise WrongShape("target", "(..., 4, 4) for poses or (..., 3) for places", numbers.shape)
    places = as_vectors(numbers, "target")
    if direction is None:
        form, rows = _POSITION, np.concatenate([places, np.full((*places.shape[:-1], 1), wanted)], axis=-1)
    else:
        towards = as_floats(direction, (3,), "direction")
        try:
            batch = common_batch("direction", places.shape[:-1], towards.shape[:-1])
        except WrongShape:
            raise WrongShape("direction", f"{places.shape} as the places, or (3,)", towards.shape) from None
        form, rows = _DIRECTION, np.empty((*batch, 6))
        rows[..., :3], rows[..., 3:] = places, unit(towards, "direction")[0]
    references = as_reference(robot, limb.rest, reference, rows.shape[:-1], enforce)
    return solved(form, limb, rows, references, enforce, workers)


def arm_limb(robot: RobotModel, side: str, frame: str | None) -> Limb:
    """An arm of a robot as the closed form takes it.

    Raises:
        BadArgument: the robot has none of this geometry.
        UnknownName: no such frame.
    """
    return kept_limb(robot, _arm_of, side, f"{side}Arm" if frame is None else frame)


def _arm_of(robot: RobotModel, side: str, frame: str) -> Limb:
    chain = chain_at_zero(robot, "arm", tuple(side + joint for joint in _JOINTS), frame)
    for index, axis in enumerate((Y, Z, X, Z, X)):
        chain.require_axis(index, axis)
    chain.require_meeting(0, 1)
    chain.require_meeting(2, 3)
    shoulder, elbow, wrist = chain.points[0], chain.points[2], chain.points[4]
    chain.require_zero("the axis of WristYaw passes the elbow", (wrist - elbow)[1:])
    chain.require_zero("the elbow is out of the plane of the upper arm", (elbow - shoulder)[2:])
    x, y, _ = (elbow - shoulder).tolist()
    return limb_of(chain, frame, Arm(tuple(shoulder.tolist()), x, y, _WEIGHT, *chain.frame_in_link(elbow)))


# --- What an arm does where no formula answers: the nearest pose, and the best of many for a position alone.
#
# The nearest pose is found by damped least squares from the branches that would meet it if the elbow could be moved,
# within the limits. For a position, ElbowYaw and WristYaw are chosen freely, the other three joints follow in closed
# form (two ways for ElbowRoll, two for the shoulder), and the best choice is searched for: the position is met to
# rounding.

_REDUNDANT = float(Family.REDUNDANT)
_ITERATIONS = 200
# A step of damped least squares [rad] after which there are no more.
_SETTLED = 1e-12
# Choices of ElbowYaw and WristYaw that are tried each, and around how many valleys of theirs is searched.
_GRID, _BEST = 15, 6
# Steps of that search: the last, what one is shortened by, by how much their directions then turn [rad], and the most.
_LAST_STEP, _SHORTER, _TURN, _MOST_STEPS = 1e-9, 0.7, 0.3, 400
# Costs of what is outside the limits, and of choices with which the position cannot be met.
_OUTSIDE, _IMPOSSIBLE = 1e3, 1e6


# --- the nearest pose -------------------------------------------------------------------------------------------------


class Aim(NamedTuple):
    """What the nearest pose is searched for.

    Attributes:
        hand: the pose of the hand that is wanted.
        directed: whether only the direction of the forearm counts, and not the turn about it.
        weight: what a radian counts [m].
        best: the cost of the nearest pose so far, one number.
    """

    hand: Pose
    directed: bool
    weight: float
    best: Floats


@both_ways
def report_nearest_pose(arm: Arm, target: Row, selection: Selection, report: Row) -> None:
    """Report the joint values with the smallest √(distance² + (weight · angle)²) to a pose."""
    aim = Aim(hand_of(arm, target)[1], False, arm.weight, np.full(1, math.inf))
    _from_branches(arm, aim, selection, report)
    _from_corners(arm, aim, selection, report)


@both_ways
def report_nearest_direction(arm: Arm, target: Row, selection: Selection, report: Row) -> None:
    """The same for a place and a direction; the angle is that between the directions."""
    circle, best = circle_of(arm, target), np.full(1, math.inf)
    aim = Aim(hand_on_circle(arm, circle, 0.0), True, arm.weight, best)
    for quarter in range(4):  # of every turn place and direction are the same
        aim = Aim(hand_on_circle(arm, circle, 0.5 * math.pi * quarter), True, arm.weight, best)
        _from_branches(arm, aim, selection, report)
    _from_corners(arm, aim, selection, report)


@both_ways
def _from_branches(arm: Arm, aim: Aim, selection: Selection, report: Row) -> None:
    """Search from the branches with the elbow in the right direction, and from the reference."""
    elbow, q = elbow_of(arm, aim.hand), np.empty(JOINTS)
    for side in range(2):
        write_shoulder(arm, elbow, side, q)
        write_elbow(aim.hand, selection, q)
        _descend(arm, aim, selection, q.copy(), report)
        write_other_elbow(q)
        _descend(arm, aim, selection, q.copy(), report)
    for j in range(JOINTS):
        q[j] = selection.reference[j]
    _descend(arm, aim, selection, q, report)


@both_ways
def _from_corners(arm: Arm, aim: Aim, selection: Selection, report: Row) -> None:
    """Search from eight configurations spread over the ranges: far away all others may end in one dead end."""
    ranges, q = selection.ranges, np.empty(JOINTS)
    for corner in range(8):
        for j in range(JOINTS):
            low, high = max(ranges.lower[j], -math.pi), min(ranges.upper[j], math.pi)
            q[j] = low + (0.25 if (corner >> (j % 3)) & 1 else 0.75) * (high - low)
        _descend(arm, aim, selection, q, report)


@both_ways
def _descend(arm: Arm, aim: Aim, selection: Selection, q: Floats, report: Row) -> None:
    """Damped least squares within the limits from q; report where it ends if that is the best so far."""
    ranges, enforce = selection.ranges, selection.enforce
    trial, step, gradient = np.empty(JOINTS), np.empty(JOINTS), np.empty(JOINTS)
    rows, residual, scratch = np.empty((6, JOINTS)), np.empty(6), np.empty(6)
    A = np.empty((JOINTS, JOINTS))
    _into_ranges(selection, q)
    cost, damping = _residual(arm, aim, q, residual), 1e-3
    for _ in range(_ITERATIONS):
        _jacobian(arm, aim.directed, aim.weight, q, rows)
        for i in range(JOINTS):
            gradient[i] = 0.0
            for r in range(6):
                gradient[i] += rows[r, i] * residual[r]
        moved = math.inf
        while damping < 1e12:
            for i in range(JOINTS):
                # A joint at its limit that would go on stays there.
                free = not enforce or (ranges.lower[i] < q[i] or gradient[i] < 0.0)
                free = free and (not enforce or q[i] < ranges.upper[i] or gradient[i] > 0.0)
                for j in range(JOINTS):
                    A[i, j] = 0.0
                    for r in range(6):
                        A[i, j] += rows[r, i] * rows[r, j]
                A[i, i] *= 1.0 + damping
                A[i, i] += 1e-12
                step[i] = -gradient[i]
                if not free:
                    step[i], A[i, i] = 0.0, 1e18
            if not cholesky(A, JOINTS):
                damping *= 5.0
                continue
            solve_cholesky(A, JOINTS, step)
            for i in range(JOINTS):
                trial[i] = q[i] + step[i]
            _into_ranges(selection, trial)
            tried = _residual(arm, aim, trial, scratch)
            if tried < cost:
                moved = 0.0
                for i in range(JOINTS):
                    moved = max(moved, abs(trial[i] - q[i]))
                    q[i] = trial[i]
                for r in range(6):
                    residual[r] = scratch[r]
                cost, damping = tried, max(0.2 * damping, 1e-12)
                break
            damping *= 5.0
        if moved == math.inf or moved < _SETTLED:
            break
    if cost < aim.best[0]:
        aim.best[0] = cost
        for i in range(JOINTS):
            report[BEST + i] = q[i] if enforce else math.atan2(math.sin(q[i]), math.cos(q[i]))
        report[POSITION_ERROR] = math.sqrt(residual[0] ** 2 + residual[1] ** 2 + residual[2] ** 2)
        turned = math.sqrt(residual[3] ** 2 + residual[4] ** 2 + residual[5] ** 2)
        report[ANGLE_ERROR] = turned / aim.weight if aim.weight > 0.0 else 0.0


@both_ways
def _into_ranges(selection: Selection, q: Row) -> None:
    if selection.enforce:
        for i in range(JOINTS):
            q[i] = min(max(q[i], selection.ranges.lower[i]), selection.ranges.upper[i])


@both_ways
def _residual(arm: Arm, aim: Aim, q: Row, residual: Floats) -> float:
    """Difference of places [m] and weighted rotation vector from the target to what is made; their squared norm."""
    hand, made = aim.hand, forward(arm, q)
    residual[0], residual[1], residual[2] = made.x - hand.x, made.y - hand.y, made.z - hand.z
    if aim.directed:
        vx = hand.r10 * made.r20 - hand.r20 * made.r10
        vy = hand.r20 * made.r00 - hand.r00 * made.r20
        vz = hand.r00 * made.r10 - hand.r10 * made.r00
        cosine = hand.r00 * made.r00 + hand.r10 * made.r10 + hand.r20 * made.r20
    else:
        # Of E = made · targetᵀ, half the antisymmetric part and (trace − 1)/2.
        e01 = made.r00 * hand.r10 + made.r01 * hand.r11 + made.r02 * hand.r12
        e10 = made.r10 * hand.r00 + made.r11 * hand.r01 + made.r12 * hand.r02
        e02 = made.r00 * hand.r20 + made.r01 * hand.r21 + made.r02 * hand.r22
        e20 = made.r20 * hand.r00 + made.r21 * hand.r01 + made.r22 * hand.r02
        e12 = made.r10 * hand.r20 + made.r11 * hand.r21 + made.r12 * hand.r22
        e21 = made.r20 * hand.r10 + made.r21 * hand.r11 + made.r22 * hand.r12
        vx, vy, vz = 0.5 * (e21 - e12), 0.5 * (e02 - e20), 0.5 * (e10 - e01)
        trace = made.r00 * hand.r00 + made.r01 * hand.r01 + made.r02 * hand.r02
        trace += made.r10 * hand.r10 + made.r11 * hand.r11 + made.r12 * hand.r12
        trace += made.r20 * hand.r20 + made.r21 * hand.r21 + made.r22 * hand.r22
        cosine = 0.5 * (trace - 1.0)
    sine = math.sqrt(vx * vx + vy * vy + vz * vz)
    angle = math.atan2(sine, cosine)
    if sine > 1e-14:
        scale = aim.weight * angle / sine
        residual[3], residual[4], residual[5] = scale * vx, scale * vy, scale * vz
    else:
        residual[3], residual[4], residual[5] = aim.weight * angle, 0.0, 0.0
    total = 0.0
    for r in range(6):
        total += residual[r] * residual[r]
    return total


@both_ways
def _jacobian(arm: Arm, directed: bool, weight: float, q: Row, rows: Floats) -> None:
    """How the residual changes with the joints, shape (6, 5)."""
    made = forward(arm, q)
    s1, c1, s2, c2 = math.sin(q[0]), math.cos(q[0]), math.sin(q[1]), math.cos(q[1])
    s3, c3 = math.sin(q[2]), math.cos(q[2])
    axes = np.empty((JOINTS, 3))
    axes[0, 0], axes[0, 1], axes[0, 2] = 0.0, 1.0, 0.0
    axes[1, 0], axes[1, 1], axes[1, 2] = s1, 0.0, c1
    axes[2, 0], axes[2, 1], axes[2, 2] = c1 * c2, s2, -s1 * c2
    # Ry(q₁) Rz(q₂) Rx(q₃) z = Ry(q₁) Rz(q₂) (0, −sin q₃, cos q₃)
    axes[3, 0], axes[3, 1], axes[3, 2] = c1 * s2 * s3 + s1 * c3, -c2 * s3, c1 * c3 - s1 * s2 * s3
    axes[4, 0], axes[4, 1], axes[4, 2] = made.r00, made.r10, made.r20
    ex = c1 * c2 * arm.elbow_x - c1 * s2 * arm.elbow_y
    ey = s2 * arm.elbow_x + c2 * arm.elbow_y
    ez = -s1 * c2 * arm.elbow_x + s1 * s2 * arm.elbow_y
    for j in range(JOINTS):
        x, y, z = (made.x, made.y, made.z) if j < 2 else (made.x - ex, made.y - ey, made.z - ez)
        ax, ay, az = axes[j, 0], axes[j, 1], axes[j, 2]
        rows[0, j], rows[1, j], rows[2, j] = ay * z - az * y, az * x - ax * z, ax * y - ay * x
        if directed:
            # A turn about the forearm does not change where it points.
            part = ax * made.r00 + ay * made.r10 + az * made.r20
            ax, ay, az = ax - part * made.r00, ay - part * made.r10, az - part * made.r20
        rows[3, j], rows[4, j], rows[5, j] = weight * ax, weight * ay, weight * az


# --- a position alone -------------------------------------------------------------------------------------------------


@both_ways
def solve_position(arm: Arm, target: Row, selection: Selection, work: Workspace) -> int:
    """The best joint values for a place of the frame, by a criterion; four numbers."""
    reference, enforce = selection.reference, selection.enforce
    q, report = work.q, work.report
    start_report(report)
    x, y, z = target[0] - arm.shoulder[0], target[1] - arm.shoulder[1], target[2] - arm.shoulder[2]
    hand = Pose(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, x, y, z)
    if not out_of_reach(arm, x, y, z, report):
        cost = _search(arm, hand, target[3], selection, q)
        if cost < _OUTSIDE:
            made = forward(arm, q)
            dx, dy, dz = made.x - x, made.y - y, made.z - z
            errors = math.sqrt(dx * dx + dy * dy + dz * dz), 0.0
            # Whole turns would take a joint out of the range in the middle of which it was wanted.
            as_they_are = Selection(selection.ranges, reference, enforce or target[3] == LIMITS)
            if add_branch(as_they_are, work, errors, _REDUNDANT, 0) > 0:
                finish_report(work, JOINTS, 1)
                return 1
        report[REASON] = NOT_ENOUGH_JOINTS
        if cost < _IMPOSSIBLE:
            report_limit(selection.ranges, q, report)
    aim = Aim(hand, True, 0.0, np.full(1, math.inf))
    start = np.empty(JOINTS)
    for j in range(JOINTS):
        start[j] = reference[j]
    _descend(arm, aim, selection, start, report)
    _from_corners(arm, aim, selection, report)
    return 0


@both_ways
def _search(arm: Arm, hand: Pose, criterion: float, selection: Selection, q: Row) -> float:
    """The best choice of ElbowYaw and WristYaw, on a grid and then around the best of it; q and its cost."""
    ranges, reference, enforce = selection
    low3, high3, low5, high5 = -math.pi, math.pi, -math.pi, math.pi
    if enforce:
        low3, high3, low5, high5 = ranges.lower[2], ranges.upper[2], ranges.lower[4], ranges.upper[4]
    elif criterion == NEAREST:
        low3, high3 = reference[2] - math.pi, reference[2] + math.pi
        low5, high5 = reference[4] - math.pi, reference[4] + math.pi
    step3, step5 = (high3 - low3) / (_GRID - 1), (high5 - low5) / (_GRID - 1)
    costs = np.full((_GRID + 2, _GRID + 2), math.inf)
    for i in range(_GRID):
        for j in range(_GRID):
            yaw, wrist = low3 + i * step3, low5 + j * step5
            costs[i + 1, j + 1] = _cost(arm, hand, criterion, selection, yaw, wrist, q)
    valleys = np.full(_GRID * _GRID, math.inf)
    for i in range(_GRID):
        for j in range(_GRID):
            # The lowest of its neighbours: the best of all lie side by side in one valley.
            if costs[i + 1, j + 1] <= np.min(costs[i : i + 3, j : j + 3]):
                valleys[i * _GRID + j] = costs[i + 1, j + 1]
    order = np.argsort(valleys, kind="mergesort")
    best, best_yaw, best_wrist = math.inf, 0.0, 0.0
    for k in range(_BEST + 1):
        # From the lowest valleys, and from the reference.
        if k < _BEST:
            cost, yaw, wrist = valleys[order[k]], low3 + order[k] // _GRID * step3, low5 + order[k] % _GRID * step5
        else:
            yaw, wrist = min(max(reference[2], low3), high3), min(max(reference[4], low5), high5)
            cost = _cost(arm, hand, criterion, selection, yaw, wrist, q)
        if cost == math.inf:
            continue
        longest = 0.5 * max(step3, step5)
        step, turn, count = longest, 0.0, 0
        while step > _LAST_STEP and count < _MOST_STEPS:
            count += 1
            better = False
            for i in range(8):
                angle = 0.25 * math.pi * i + turn
                one = min(max(yaw + step * math.cos(angle), low3), high3)
                two = min(max(wrist + step * math.sin(angle), low5), high5)
                tried = _cost(arm, hand, criterion, selection, one, two, q)
                if tried < cost:
                    cost, yaw, wrist, better = tried, one, two, True
                    break
            # Along a ridge a step may fail in all eight directions: these turn, and after a success steps grow again.
            step, turn = (min(2.0 * step, longest), turn) if better else (_SHORTER * step, turn + _TURN)
        if cost < best:
            best, best_yaw, best_wrist = cost, yaw, wrist
    return _cost(arm, hand, criterion, selection, best_yaw, best_wrist, q)


@both_ways
def _cost(arm: Arm, hand: Pose, criterion: float, selection: Selection, yaw: float, wrist: float, q: Row) -> float:
    """Cost and joint values of the best of the four ways to meet a position with this ElbowYaw and WristYaw."""
    c3, s3, c5, s5 = math.cos(yaw), math.sin(yaw), math.cos(wrist), math.sin(wrist)
    # The frame from the elbow, before ElbowRoll.
    gx, gy, gz = arm.place[0], arm.place[1] * c5 - arm.place[2] * s5, arm.place[1] * s5 + arm.place[2] * c5
    far = hand.x * hand.x + hand.y * hand.y + hand.z * hand.z
    ex, ey = arm.elbow_x, arm.elbow_y
    squares = ex * ex + ey * ey + gx * gx + gy * gy + gz * gz
    # a cos q₄ + b sin q₄ = k from the distance of shoulder and frame
    a, b = ex * gx + ey * c3 * gy, ey * c3 * gx - ex * gy
    k = 0.5 * (far - squares) + ey * s3 * gz
    beyond = a * a + b * b - k * k
    if beyond < 0.0:
        return _IMPOSSIBLE * (1.0 - beyond)
    root, middle = math.atan2(math.sqrt(beyond), k), math.atan2(b, a)
    best, best0, best1, best3 = math.inf, 0.0, 0.0, 0.0
    for bend in range(2):
        roll = wrapped(middle + root) if bend == 0 else wrapped(middle - root)
        c4, s4 = math.cos(roll), math.sin(roll)
        vx, vy = c4 * gx - s4 * gy, s4 * gx + c4 * gy
        mx, my, mz = ex + vx, ey + c3 * vy - s3 * gz, s3 * vy + c3 * gz
        beyond = hand.x * hand.x + hand.z * hand.z - mz * mz
        if beyond < 0.0:
            best = min(best, _IMPOSSIBLE * (1.0 - beyond))
            continue
        for side in range(2):
            across = math.sqrt(beyond) if side == 0 else -math.sqrt(beyond)
            q[0] = math.atan2(mz * hand.x - across * hand.z, across * hand.x + mz * hand.z)
            q[1] = wrapped(math.atan2(hand.y, across) - math.atan2(my, mx))
            q[2], q[3], q[4] = yaw, roll, wrist
            outside = farthest_outside(selection.ranges, q)[0] if selection.enforce else 0.0
            cost = _OUTSIDE * (1.0 + outside) if outside > LIMIT_ROUNDING else _criterion(arm, criterion, selection, q)
            if cost < best:
                best, best0, best1, best3 = cost, q[0], q[1], q[3]
    q[0], q[1], q[2], q[3], q[4] = best0, best1, yaw, best3, wrist
    return best


@both_ways
def _criterion(arm: Arm, criterion: float, selection: Selection, q: Row) -> float:
    """What is to be small of configurations that meet a position."""
    ranges = selection.ranges
    if criterion == NEAREST:
        return squared_distance(q, selection.reference, selection.enforce)
    if criterion == LIMITS:
        least = math.inf
        for j in range(JOINTS):
            width = ranges.upper[j] - ranges.lower[j]
            if width == math.inf:
                continue
            least = min(least, (q[j] - ranges.lower[j]) / width, (ranges.upper[j] - q[j]) / width)
        return -least
    return -manipulability(arm, q)


@both_ways
def manipulability(arm: Arm, q: Row) -> float:
    """√det(J_v J_vᵀ) of the frame's place, J_v of shape (3, 5)."""
    rows = np.empty((6, JOINTS))
    _jacobian(arm, False, 0.0, q, rows)
    xx, yy, zz, xy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(JOINTS):
        x, y, z = rows[0, j], rows[1, j], rows[2, j]
        xx, yy, zz, xy, xz, yz = xx + x * x, yy + y * y, zz + z * z, xy + x * y, xz + x * z, yz + y * z
    return math.sqrt(max(0.0, xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)))


@both_ways
def _solve_pose(arm: Arm, target: Row, selection: Selection, work: Workspace) -> int:
    """As `solve_arm`; what is nearest to a pose that is not met is reported."""
    count = solve_arm(arm, target, selection, work)
    if count == 0 and work.report[REASON] != NOT_RIGID:
        report_nearest_pose(arm, target, selection, work.report)
    return count


@both_ways
def _solve_directed(arm: Arm, target: Row, selection: Selection, work: Workspace) -> int:
    """As `solve_direction`; what is nearest to a place and direction that are not met is reported."""
    count = solve_direction(arm, target, selection, work)
    if count == 0:
        report_nearest_direction(arm, target, selection, work.report)
    return count


_types = partial(limb_types, Arm, JOINTS)
_POSE = ClosedForm("arms by pose", _solve_pose, _types, MOST_BRANCHES, alone=solve_arm)
_DIRECTION = ClosedForm("arms by place and direction", _solve_directed, _types, MOST_BRANCHES, alone=solve_direction)
_POSITION = ClosedForm("arms by place", solve_position, _types, 1, alone=None)
