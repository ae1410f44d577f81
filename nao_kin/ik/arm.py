"""`arm`: the five joints of an arm, for a pose of the hand, its position and direction, or its position alone."""

from __future__ import annotations

import dataclasses
import math
from functools import partial
from typing import Literal, NamedTuple, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import LARGEST, Floats, as_floats, as_numbers, as_vectors, check_tolerance, choice, unit
from nao_kin._kernels.cache import both_ways
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.ik.arm_equations import (
    JOINTS,
    MAX_BRANCHES,
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
from nao_kin.ik.geometry import ClosedForm, Limb, cached_limb, chain_at_zero, check_side, limb_of, limb_types, solve
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
from nao_kin.ik.targets import Limits, as_options, as_poses, broadcast, refuse_not_rigid
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
    """Compute joint values of an arm for a pose of its hand, for position and direction, or for a position.

    - A pose (..., 4, 4) is six numbers for five joints: it is possible only if the distance of the elbow from the
      shoulder is the length of the upper arm. The result has all branches, up to four.
    - A position (..., 3) and a `direction` of the forearm, which is that of the hand, are five: up to eight branches.
    - A position alone leaves two joints free; the result has the best solution by `criterion`.

    If a target is not met, `reason` says why, and `best` and `q` are the nearest joint values, inside the limits if
    these are enforced: with the smallest √(distance² + (angle_weight · angle)²).

    Args:
        robot: a NAO of any version, or another robot with arms of its geometry.
        side: "L" or "R".
        target: poses of the frame in the torso, shape (..., 4, 4), or positions of its origin, shape (..., 3) [m].
        direction: with positions: the direction of the forearm's x-axis in the torso, of any length but zero; shape
            (..., 3), broadcasts with the positions.
        criterion: with positions alone: "nearest" to the reference, "limits" for the largest distance to the nearest
            limit as a share of that joint's range, or "manipulability" for the largest √det(J_v J_vᵀ). The solution is
            searched for on a grid, and refined to 1e-9 rad.
        angle_weight: the weight of one radian [m]: with 0.1, 0.1 rad has the weight of 10 mm.
        frame: a frame on the hand; None for the end effector "LArm" or "RArm".
        reference: configurations that broadcast with the targets, shape (..., nq): solutions are sorted by their
            distance to it, and its joints of other limbs are used. None for all joints at zero, or at the limit nearest
            to it.
        limits: "enforce" leaves out branches with a joint outside its limits; "ignore" returns all, each joint with the
            whole turns that bring it within half a turn of the reference; with criterion "limits" within ±π.
        threads: how many threads may work on a batch; None for all cores if that is worthwhile.

    Returns:
        Solutions to within 1e-10 m and rad. Five joints cannot make a rounded pose, of float32 for instance: its reason
        is `NOT_ENOUGH_JOINTS`, and `q` the nearest, some 1e-8 m and rad off. A family of solutions is listed once: the
        elbow on the axis of ShoulderPitch (`SHOULDER_AXIS`), the stretched arm (`ELBOW_LOCK`), a position alone
        (`REDUNDANT`).

    Raises:
        BadArgument: the robot has no such arm; the message says what is missing. Or the last row of a target is not
            0, 0, 0, 1, a number is beyond ±1e150, or a direction is given with poses.
        NotARotation: the rotation of a target is not one; has the argument, its index and its defect.
        ZeroNorm: a direction is zero.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = nao.posture("StandInit")
        >>> result = nk.ik.arm(nao, "L", nao.fk(q, "LArm"))
        >>> bool(np.abs(nao.fk(result.q, "LArm") - nao.fk(q, "LArm")).max() < 1e-9)
        True
    """
    check_side(side)
    limb = arm_limb(robot, side, frame)
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
            raise BadArgument("a direction is given with positions (..., 3), a pose (..., 4, 4) includes one")
        T = as_poses(numbers, "target")
        rows = T.reshape(*T.shape[:-2], 16)
        options = as_options(robot, limb.rest, reference, T.shape[:-2], limits, threads)
        return solve(_POSE, limb, rows, options, lambda: refuse_not_rigid(T, "target"))
    if numbers.shape[-1:] != (3,):
        raise WrongShape("target", "(..., 4, 4) for poses or (..., 3) for positions", numbers.shape)
    places = as_vectors(numbers, "target")
    if direction is None:
        form, rows = _POSITION, np.concatenate([places, np.full((*places.shape[:-1], 1), wanted)], axis=-1)
    else:
        towards = as_floats(direction, (3,), "direction")
        wanted_shape = f"{places.shape} as the positions, or (3,)"
        batch = broadcast("direction", places.shape[:-1], towards.shape[:-1], wanted_shape, towards.shape)
        form, rows = _DIRECTION, np.empty((*batch, 6))
        rows[..., :3], rows[..., 3:] = places, unit(towards, "direction")[0]
    return solve(form, limb, rows, as_options(robot, limb.rest, reference, rows.shape[:-1], limits, threads))


def arm_limb(robot: RobotModel, side: str, frame: str | None) -> Limb:
    """Return an arm of a robot for the closed form."""
    return cached_limb(robot, _arm_of, side, f"{side}Arm" if frame is None else frame)


def _arm_of(robot: RobotModel, side: str, frame: str) -> Limb:
    chain = chain_at_zero(robot, "arm", tuple(side + joint for joint in _JOINTS), frame)
    chain.require_axes("yzxzx")
    chain.require_meeting((0, 1), (2, 3))
    shoulder, elbow, wrist = chain.points[0], chain.points[2], chain.points[4]
    chain.require_zero("the axis of WristYaw passes the elbow", (wrist - elbow)[1:])
    chain.require_zero("the elbow is out of the plane of the upper arm", (elbow - shoulder)[2:])
    x, y, _ = (elbow - shoulder).tolist()
    return limb_of(chain, frame, Arm(tuple(shoulder.tolist()), x, y, _WEIGHT, *chain.frame_in_link(elbow)))


# --- Searches of an arm: the nearest pose, and the best solution for a position alone.
# Damped least squares within the limits find the nearest pose, from the branches that would meet it if the elbow could
# be moved. For a position, ElbowYaw and WristYaw are free and searched over; the other three joints follow in closed
# form (two values of ElbowRoll, two of the shoulder), and meet the position to rounding.

_REDUNDANT = float(Family.REDUNDANT)
_ITERATIONS = 200
# Length of the last step of damped least squares [rad].
_SETTLED = 1e-12
# Grid values of ElbowYaw and of WristYaw, and how many valleys of the grid are searched.
_GRID, _BEST = 15, 6
# Steps of that search: the last one, the factor after a failure, the rotation of the directions then [rad], the
# maximum.
_LAST_STEP, _SHORTER, _TURN, _MAX_STEPS = 1e-9, 0.7, 0.3, 400
# Costs of joint values outside the limits, and of those that cannot meet the position.
_OUTSIDE, _IMPOSSIBLE = 1e3, 1e6


class Objective(NamedTuple):
    """The objective of the search for the nearest pose of the hand, and the lowest cost so far, one number.

    `directed`: whether only the direction of the forearm counts, not the rotation about it; `weight` of a radian [m].
    """

    hand: Pose
    directed: bool
    weight: float
    best: Floats


@both_ways
def report_nearest_pose(arm: Arm, target: Row, selection: Selection, report: Row) -> None:
    """Report the joint values with the smallest √(distance² + (weight · angle)²) to a pose."""
    objective = Objective(hand_of(arm, target)[1], False, arm.weight, np.full(1, math.inf))
    _from_branches(arm, objective, selection, report)
    _from_corners(arm, objective, selection, report)


@both_ways
def report_nearest_direction(arm: Arm, target: Row, selection: Selection, report: Row) -> None:
    """Report the same for a position and a direction; the angle is that between the directions."""
    circle, best = circle_of(arm, target), np.full(1, math.inf)
    objective = Objective(hand_on_circle(arm, circle, 0.0), True, arm.weight, best)
    for quarter in range(4):  # rotations that change neither position nor direction
        objective = Objective(hand_on_circle(arm, circle, 0.5 * math.pi * quarter), True, arm.weight, best)
        _from_branches(arm, objective, selection, report)
    _from_corners(arm, objective, selection, report)


@both_ways
def _from_branches(arm: Arm, objective: Objective, selection: Selection, report: Row) -> None:
    """Search from the branches with the elbow in the right direction."""
    elbow, q = elbow_of(arm, objective.hand), np.empty(JOINTS)
    for side in range(2):
        write_shoulder(arm, elbow, side, q)
        write_elbow(objective.hand, selection, q)
        _descend(arm, objective, selection, q.copy(), report)
        write_other_elbow(q)
        _descend(arm, objective, selection, q.copy(), report)


@both_ways
def _from_corners(arm: Arm, objective: Objective, selection: Selection, report: Row) -> None:
    """Search from the reference, and from eight configurations spread over the ranges, against local minima."""
    ranges, q = selection.ranges, np.empty(JOINTS)
    q[:] = selection.reference
    _descend(arm, objective, selection, q, report)
    for corner in range(8):
        for j in range(JOINTS):
            low, high = max(ranges.lower[j], -math.pi), min(ranges.upper[j], math.pi)
            q[j] = low + (0.25 if (corner >> (j % 3)) & 1 else 0.75) * (high - low)
        _descend(arm, objective, selection, q, report)


@both_ways
def _descend(arm: Arm, objective: Objective, selection: Selection, q: Floats, report: Row) -> None:
    """Run damped least squares within the limits from q; report its end if it is the best so far."""
    ranges, enforce = selection.ranges, selection.enforce
    trial, step, gradient = np.empty(JOINTS), np.empty(JOINTS), np.empty(JOINTS)
    rows, residual, scratch = np.empty((6, JOINTS)), np.empty(6), np.empty(6)
    A = np.empty((JOINTS, JOINTS))
    _clamp(selection, q)
    cost, damping = _residual(arm, objective, q, residual), 1e-3
    for _ in range(_ITERATIONS):
        _jacobian(arm, objective.directed, objective.weight, q, rows)
        for i in range(JOINTS):
            gradient[i] = 0.0
            for r in range(6):
                gradient[i] += rows[r, i] * residual[r]
        moved = math.inf
        while damping < 1e12:
            for i in range(JOINTS):
                # A joint at its limit does not move outwards.
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
            _clamp(selection, trial)
            trial_cost = _residual(arm, objective, trial, scratch)
            if trial_cost < cost:
                moved = np.max(np.abs(trial - q))
                q[:], residual[:] = trial, scratch
                cost, damping = trial_cost, max(0.2 * damping, 1e-12)
                break
            damping *= 5.0
        if moved == math.inf or moved < _SETTLED:
            break
    if cost < objective.best[0]:
        objective.best[0] = cost
        for i in range(JOINTS):
            report[BEST + i] = q[i] if enforce else math.atan2(math.sin(q[i]), math.cos(q[i]))
        report[POSITION_ERROR] = math.sqrt(residual[0] ** 2 + residual[1] ** 2 + residual[2] ** 2)
        turned = math.sqrt(residual[3] ** 2 + residual[4] ** 2 + residual[5] ** 2)
        report[ANGLE_ERROR] = turned / objective.weight if objective.weight > 0.0 else 0.0


@both_ways
def _clamp(selection: Selection, q: Row) -> None:
    if selection.enforce:
        for i in range(JOINTS):
            q[i] = min(max(q[i], selection.ranges.lower[i]), selection.ranges.upper[i])


@both_ways
def _residual(arm: Arm, objective: Objective, q: Row, residual: Floats) -> float:
    """Write the position error [m] and the weighted rotation vector from the target; return their squared norm."""
    hand, made = objective.hand, forward(arm, q)
    residual[0], residual[1], residual[2] = made.x - hand.x, made.y - hand.y, made.z - hand.z
    vx = hand.r10 * made.r20 - hand.r20 * made.r10
    vy = hand.r20 * made.r00 - hand.r00 * made.r20
    vz = hand.r00 * made.r10 - hand.r10 * made.r00
    cosine = hand.r00 * made.r00 + hand.r10 * made.r10 + hand.r20 * made.r20
    if not objective.directed:
        # Of E = made · targetᵀ, half the antisymmetric part, ½ Σ target column × made column, and (trace − 1)/2.
        vx += hand.r11 * made.r21 - hand.r21 * made.r11 + hand.r12 * made.r22 - hand.r22 * made.r12
        vy += hand.r21 * made.r01 - hand.r01 * made.r21 + hand.r22 * made.r02 - hand.r02 * made.r22
        vz += hand.r01 * made.r11 - hand.r11 * made.r01 + hand.r02 * made.r12 - hand.r12 * made.r02
        cosine += hand.r01 * made.r01 + hand.r11 * made.r11 + hand.r21 * made.r21
        cosine += hand.r02 * made.r02 + hand.r12 * made.r12 + hand.r22 * made.r22
        vx, vy, vz, cosine = 0.5 * vx, 0.5 * vy, 0.5 * vz, 0.5 * (cosine - 1.0)
    sine = math.sqrt(vx * vx + vy * vy + vz * vz)
    angle = math.atan2(sine, cosine)
    if sine > 1e-14:
        scale = objective.weight * angle / sine
        residual[3], residual[4], residual[5] = scale * vx, scale * vy, scale * vz
    else:
        residual[3], residual[4], residual[5] = objective.weight * angle, 0.0, 0.0
    total = 0.0
    for r in range(6):
        total += residual[r] * residual[r]
    return total


@both_ways
def _jacobian(arm: Arm, directed: bool, weight: float, q: Row, rows: Floats) -> None:
    """Write the derivative of the residual by the joints, shape (6, 5)."""
    made = forward(arm, q)
    s1, c1, s2, c2 = math.sin(q[0]), math.cos(q[0]), math.sin(q[1]), math.cos(q[1])
    s3, c3 = math.sin(q[2]), math.cos(q[2])
    axes = (
        (0.0, 1.0, 0.0),
        (s1, 0.0, c1),
        (c1 * c2, s2, -s1 * c2),
        # Ry(q₁) Rz(q₂) Rx(q₃) z = Ry(q₁) Rz(q₂) (0, −sin q₃, cos q₃)
        (c1 * s2 * s3 + s1 * c3, -c2 * s3, c1 * c3 - s1 * s2 * s3),
        (made.r00, made.r10, made.r20),
    )
    ex = c1 * c2 * arm.elbow_x - c1 * s2 * arm.elbow_y
    ey = s2 * arm.elbow_x + c2 * arm.elbow_y
    ez = -s1 * c2 * arm.elbow_x + s1 * s2 * arm.elbow_y
    for j in range(JOINTS):
        x, y, z = (made.x, made.y, made.z) if j < 2 else (made.x - ex, made.y - ey, made.z - ez)
        ax, ay, az = axes[j]
        rows[0, j], rows[1, j], rows[2, j] = ay * z - az * y, az * x - ax * z, ax * y - ay * x
        if directed:
            # A turn about the forearm does not change its direction.
            part = ax * made.r00 + ay * made.r10 + az * made.r20
            ax, ay, az = ax - part * made.r00, ay - part * made.r10, az - part * made.r20
        rows[3, j], rows[4, j], rows[5, j] = weight * ax, weight * ay, weight * az


@both_ways
def solve_position(arm: Arm, target: Row, selection: Selection, work: Workspace) -> int:
    """Find the best joint values for a position of the frame and a criterion, four numbers."""
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
            # With criterion "limits", whole turns would move a joint out of the middle of its range.
            unturned = Selection(selection.ranges, reference, enforce or target[3] == LIMITS)
            if add_branch(unturned, work, errors, _REDUNDANT, 0) > 0:
                finish_report(work, JOINTS, 1)
                return 1
        report[REASON] = NOT_ENOUGH_JOINTS
        if cost < _IMPOSSIBLE:
            report_limit(selection.ranges, q, report)
    objective = Objective(hand, True, 0.0, np.full(1, math.inf))
    _from_corners(arm, objective, selection, report)
    return 0


@both_ways
def _search(arm: Arm, hand: Pose, criterion: float, selection: Selection, q: Row) -> float:
    """Write the best solution over ElbowYaw and WristYaw, by a grid and its valleys, into q; return its cost."""
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
            # A valley is the lowest of its neighbours.
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
        while step > _LAST_STEP and count < _MAX_STEPS:
            count += 1
            better = False
            for i in range(8):
                angle = 0.25 * math.pi * i + turn
                one = min(max(yaw + step * math.cos(angle), low3), high3)
                two = min(max(wrist + step * math.sin(angle), low5), high5)
                trial_cost = _cost(arm, hand, criterion, selection, one, two, q)
                if trial_cost < cost:
                    cost, yaw, wrist, better = trial_cost, one, two, True
                    break
            # Along a ridge a step may fail in all eight directions: turn them. After a success, steps grow again.
            step, turn = (min(2.0 * step, longest), turn) if better else (_SHORTER * step, turn + _TURN)
        if cost < best:
            best, best_yaw, best_wrist = cost, yaw, wrist
    return _cost(arm, hand, criterion, selection, best_yaw, best_wrist, q)


@both_ways
def _cost(arm: Arm, hand: Pose, criterion: float, selection: Selection, yaw: float, wrist: float, q: Row) -> float:
    """Write the best of the four solutions with this ElbowYaw and WristYaw into q; return its cost."""
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
    """Return the criterion of joint values that meet a position, to be minimised."""
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
    """Return √det(J_v J_vᵀ) of the frame's position, J_v of shape (3, 5)."""
    rows = np.empty((6, JOINTS))
    _jacobian(arm, False, 0.0, q, rows)
    xx, yy, zz, xy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(JOINTS):
        x, y, z = rows[0, j], rows[1, j], rows[2, j]
        xx, yy, zz, xy, xz, yz = xx + x * x, yy + y * y, zz + z * z, xy + x * y, xz + x * z, yz + y * z
    return math.sqrt(max(0.0, xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)))


@both_ways
def _solve_pose(arm: Arm, target: Row, selection: Selection, work: Workspace) -> int:
    """Run `solve_arm`, and report the nearest pose if there is no branch."""
    count = solve_arm(arm, target, selection, work)
    if count == 0 and work.report[REASON] != NOT_RIGID:
        report_nearest_pose(arm, target, selection, work.report)
    return count


@both_ways
def _solve_directed(arm: Arm, target: Row, selection: Selection, work: Workspace) -> int:
    """Run `solve_direction`, and report the nearest position and direction if there is no branch."""
    count = solve_direction(arm, target, selection, work)
    if count == 0:
        report_nearest_direction(arm, target, selection, work.report)
    return count


_types = partial(limb_types, Arm, JOINTS)
_POSE = ClosedForm("arms by pose", _solve_pose, _types, MAX_BRANCHES, alone=solve_arm)
_DIRECTION = ClosedForm("arms by place and direction", _solve_directed, _types, MAX_BRANCHES, alone=solve_direction)
_POSITION = ClosedForm("arms by place", solve_position, _types, 1, alone=None)
