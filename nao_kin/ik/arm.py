"""`arm`: the five joints of an arm, for a pose of the hand, its position and direction, or its position alone."""

from __future__ import annotations

import math
from functools import partial
from typing import Literal, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, SolverLimits, as_floats, choice, unit
from nao_kin._kernels.cache import Row, both_ways
from nao_kin.errors import BadArgument
from nao_kin.ik.arm_equations import (
    JOINTS,
    MAX_BRANCHES,
    Arm,
    forward,
    out_of_reach,
    solve_arm,
    solve_direction,
    upper_arm,
)
from nao_kin.ik.branches import (
    LIMIT_ROUNDING,
    NOT_ENOUGH_JOINTS,
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
from nao_kin.ik.closed_form import (
    ClosedForm,
    Limb,
    cached_limb,
    chain_at_zero,
    check_side,
    limb_of,
    limb_types,
    solve,
    unlimited_branches,
)
from nao_kin.ik.least_squares import ANGLE_WEIGHT, nearest_values
from nao_kin.ik.results import Family, IKResult, without_collisions
from nao_kin.ik.targets import Options, as_options, as_poses, broadcast, is_pose, refuse_not_rigid
from nao_kin.robot import CollisionRule, RobotModel
from nao_kin.rotations import nearest_rotation, rot_x, rotation_between

# Codes of the criteria; the target of a position has one of them after x, y and z.
NEAREST, LIMITS, MANIPULABILITY = 0.0, 1.0, 2.0
Criterion = Literal["nearest", "limits", "manipulability"]
_CRITERION: Criterion = "nearest"
_CRITERIA: dict[str, float] = {_CRITERION: NEAREST, "limits": LIMITS, "manipulability": MANIPULABILITY}
_JOINTS = ("ShoulderPitch", "ShoulderRoll", "ElbowYaw", "ElbowRoll", "WristYaw")


def arm(
    robot: RobotModel,
    side: str,
    target: ArrayLike,
    *,
    direction: ArrayLike | None = None,
    criterion: Criterion = _CRITERION,
    frame: str | None = None,
    near: ArrayLike | None = None,
    limits: SolverLimits = "enforce",
    threads: SupportsIndex | None = None,
    collisions: bool | CollisionRule = False,
) -> IKResult:
    """Compute joint values of an arm for a pose of its hand, for position and direction, or for a position.

    - A pose (..., 4, 4) is six numbers for five joints: it is possible only if the distance of the elbow from the
      shoulder is the length of the upper arm. The result has all branches, up to four.
    - A position (..., 3) with a `direction` of the forearm, which is also that of the hand, is five numbers: up to
      eight branches.
    - A position alone leaves two joints free; the result has the best solution by `criterion`.

    If a target is not met, `reason` says why, and `best` and `q` are the joint values with the smallest
    √(distance² + (0.1 m · angle)²) that a search finds, inside the limits if these are enforced.

    Args:
        robot: a NAO of any version, or another robot with arms of its geometry.
        side: "L" or "R", or the end effector "LArm" or "RArm".
        target: poses of the frame in the torso, shape (..., 4, 4), or positions of its origin, shape (..., 3) [m].
        direction: with positions: the direction of the forearm's x-axis in the torso, of any length but zero; shape
            (..., 3), broadcasts with the positions.
        criterion: with positions alone: "nearest" to `near`, "limits" for the largest distance to the nearest
            limit as a share of that joint's range, or "manipulability" for the largest √det(J_v J_vᵀ). The solution is
            searched for on a grid, and refined to 1e-9 rad.
        frame: a frame on the hand; None for the end effector "LArm" or "RArm".
        near: as in all solvers, see `nao_kin.ik`.
        limits: as in all solvers; with criterion "limits", ignored limits leave joints within ±π.
        threads: as in all solvers.
        collisions: as in all solvers.

    Returns:
        Solutions meet the target to within 1e-10 m and rad. Five joints cannot meet a pose that is rounded, for
        instance to float32: its reason is `NOT_ENOUGH_JOINTS`, and `q` are the nearest joint values, some 1e-8 m and
        rad off. A family of solutions is listed once. There are three families: the elbow on the axis of ShoulderPitch
        (`SHOULDER_AXIS`), the stretched arm (`ELBOW_LOCK`), and a position alone (`REDUNDANT`).

    Raises:
        BadArgument: the robot has no such arm; the message says what is missing. Or the last row of a target is not
            0, 0, 0, 1, or a direction is given with poses.
        NotARotation: the 3×3 part of a target is not a rotation; the error has the argument, its index and its defect.
        ZeroNorm: a direction is zero.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = nao.posture("StandInit")
        >>> result = nk.ik.arm(nao, "L", nao.fk(q, "LArm"))
        >>> bool(np.abs(nao.fk(result.q, "LArm") - nao.fk(q, "LArm")).max() < 1e-9)
        True
    """
    limb = arm_limb(robot, check_side(side, "Arm"), frame)
    wanted = NEAREST if criterion is _CRITERION else _CRITERIA[choice(criterion, _CRITERIA, "criterion")]
    if is_pose(target, "target"):
        if direction is not None:
            raise BadArgument("a direction requires positions (..., 3): a pose (..., 4, 4) includes a direction")
        T = as_poses(target, "target")
        rows = T.reshape(*T.shape[:-2], 16)
        options = as_options(robot, limb.rest, near, T.shape[:-2], limits, threads)
        nearest = partial(_nearest, robot, _POSE, limb)
        result = solve(_POSE, limb, rows, options, lambda: refuse_not_rigid(T, "target"), nearest)
        return without_collisions(robot, result, collisions)
    places = as_floats(target, (3,), "target")
    if direction is None:
        form, rows = _POSITION, np.concatenate([places, np.full((*places.shape[:-1], 1), wanted)], axis=-1)
    else:
        towards = as_floats(direction, (3,), "direction")
        wanted_shape = f"{places.shape} as the positions, or (3,)"
        batch = broadcast("direction", places.shape[:-1], towards.shape[:-1], wanted_shape, towards.shape)
        form, rows = _DIRECTION, np.empty((*batch, 6))
        rows[..., :3], rows[..., 3:] = places, unit(towards, "direction")[0]
    options = as_options(robot, limb.rest, near, rows.shape[:-1], limits, threads)
    result = solve(form, limb, rows, options, nearest=partial(_nearest, robot, form, limb))
    return without_collisions(robot, result, collisions)


def _nearest(robot: RobotModel, form: ClosedForm, limb: Limb, rows: Floats, options: Options) -> tuple[Floats, Floats]:
    """Return the coordinates nearest to n targets, shape (n, c), and their errors, shape (n, 2) [m, rad]."""
    geometry, n = limb.numbers, len(rows)
    rotation, weight = np.reshape(geometry.rotation, (3, 3)), 0.0 if form is _POSITION else ANGLE_WEIGHT
    T = np.tile(np.eye(4), (n, 1, 1))
    T[:, :3, 3] = rows[:, 3:12:4] if form is _POSE else rows[:, :3]
    hands: list[Floats] = []
    if form is _POSE:
        hands = [nearest_rotation(rows.reshape(n, 4, 4)[:, :3, :3]) @ rotation.T]
    elif form is _DIRECTION:
        ahead = rotation_between([1.0, 0.0, 0.0], rows[:, 3:])
        hands = [ahead @ rot_x(0.5 * math.pi * quarter) for quarter in range(4)]
    lower, upper = np.clip([limb.ranges.lower, limb.ranges.upper], -math.pi, math.pi)
    rolls = (0.1, 0.9) if form is _POSITION else (0.5,)
    shares = np.array([[pitch, roll, yaw, 0.4, 0.5] for pitch in _OUTER for roll in rolls for yaw in _OUTER])
    starts = [limb.coordinates(lower + share * (upper - lower)) for share in shares]
    for R in hands:
        # The pose with the elbow moved to where the upper arm reaches it.
        elbow = T[:, :3, 3] - geometry.shoulder - R @ geometry.place
        far = np.maximum(np.linalg.norm(elbow, axis=-1, keepdims=True), 1e-9)
        moved = np.array(T)
        moved[:, :3, :3], moved[:, :3, 3] = R @ rotation, T[:, :3, 3] + elbow * (upper_arm(geometry) / far - 1.0)
        starts += unlimited_branches(_POSE, limb, moved.reshape(n, 16))
    if hands:
        T[:, :3, :3] = hands[0]
    return nearest_values(
        robot, (limb.frame,), limb, T[:, None], starts, options,
        weight=weight, directed=form is _DIRECTION, rotation=geometry.rotation,
    )  # fmt: skip


def arm_limb(robot: RobotModel, side: str, frame: str | None) -> Limb:
    """Return an arm of a robot for the closed form."""
    return cached_limb(robot, _arm_of, side, f"{side}Arm" if frame is None else frame)


def _arm_of(robot: RobotModel, side: str, frame: str) -> Limb:
    chain = chain_at_zero(robot, "arm", tuple(side + joint for joint in _JOINTS), "yzxzx", frame)
    chain.require_meeting((0, 1), (2, 3))
    shoulder, elbow, wrist = chain.points[0], chain.points[2], chain.points[4]
    chain.require_zero("the axis of WristYaw misses the elbow", (wrist - elbow)[1:])
    chain.require_zero("the elbow is out of the plane of the upper arm", (elbow - shoulder)[2:])
    x, y, _ = (elbow - shoulder).tolist()
    return limb_of(chain, frame, Arm(tuple(shoulder.tolist()), x, y, *chain.frame_in_link(elbow)))


# --- Searches of an arm: the nearest pose, and the best solution for a position alone.
# Damped least squares within the limits find the nearest pose. The search starts from the branches that would meet the
# pose if the elbow could be moved; for a direction, from the branches for four turns of the hand about it. For a
# position, the search is over ElbowYaw and WristYaw; the other three joints follow in closed form (two values of
# ElbowRoll, two of the shoulder), and meet the position to rounding.

_REDUNDANT = float(Family.REDUNDANT)
# Fractions of the ranges of ShoulderPitch and ElbowYaw at which searches for the nearest joint values begin: searches
# from the reference alone end in local minima for a tenth of the positions out of reach.
_OUTER = (0.2, 0.8)
# Grid values of ElbowYaw and of WristYaw, and how many valleys of the grid are searched.
_GRID, _BEST = 15, 6
# Steps of the search in a valley: the size of the last one, the factor on the size after a failure, the rotation of the
# directions after a failure [rad], and the largest number of steps.
_LAST_STEP, _SHORTER, _TURN, _MAX_STEPS = 1e-9, 0.7, 0.3, 400
# Costs of joint values outside the limits, and of those that cannot meet the position.
_OUTSIDE, _IMPOSSIBLE = 1e3, 1e6


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
    xx, yy, zz, xy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(JOINTS):
        u, v, w = (made.x, made.y, made.z) if j < 2 else (made.x - ex, made.y - ey, made.z - ez)
        ax, ay, az = axes[j]
        x, y, z = ay * w - az * v, az * u - ax * w, ax * v - ay * u
        xx, yy, zz, xy, xz, yz = xx + x * x, yy + y * y, zz + z * z, xy + x * y, xz + x * z, yz + y * z
    return math.sqrt(max(0.0, xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)))


_types = partial(limb_types, Arm, JOINTS)
_POSE = ClosedForm("arms by pose", solve_arm, _types, MAX_BRANCHES, alone=solve_arm)
_DIRECTION = ClosedForm("arms by place and direction", solve_direction, _types, MAX_BRANCHES, alone=solve_direction)
_POSITION = ClosedForm("arms by place", solve_position, _types, 1, alone=None)
