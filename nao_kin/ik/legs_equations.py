"""Both legs on the motor of HipYawPitch: the joints of a leg for a given HipYawPitch, and where both feet are met.

With the names of `leg`: let e = Ry(q₁) x be the axis of HipRoll, p the ankle from the hip and n the normal of the sole.
The plane of the leg contains e and p, so its normal is along p × e, and the foot's x-axis, in this plane and
perpendicular to n, is along

    u = (p × e) × n = e (p · n) − p (e · n).

p and n can be met for every q₁. The foot is then turned about n by the angle ψ of u relative to the target's x-axis,

    tan ψ = Y / X,  X = u · x_foot,  Y = u · y_foot,

both linear in (cos q₁, sin q₁). ψ is monotonic, because X Y' − Y X' is constant; one foot is exact where Y = 0, at two
values of q₁ half a turn apart. Both feet are exact where one q₁ is a root of both. Otherwise ankle and normal of both
soles stay exact, and q₁ is the value with the smallest turns ψ inside the limits.
"""

from __future__ import annotations

import math
from typing import NamedTuple, TypeAlias

import numpy as np

from nao_kin._core.arrays import LIMIT_TOLERANCE
from nao_kin._kernels.cache import Row, both_ways
from nao_kin.ik.branches import (
    ANGLE_ERROR,
    BEST,
    EXTRAS,
    JOINT,
    LIMIT_ROUNDING,
    NO_OBSTACLE,
    NO_REASON,
    NOT_RIGID,
    OUT_OF_REACH,
    POSITION_ERROR,
    REASON,
    VERIFIED,
    Pose,
    Ranges,
    Selection,
    Workspace,
    add_branch,
    finish_report,
    is_inside,
    is_outside,
    joint_difference,
    least,
    local_minima,
    reason_of,
    squared_distance,
    start_report,
    table_range,
    turned_towards,
    wrapped,
    write_reason,
)
from nao_kin.ik.leg import Leg, foot_of, knee_of, leg_errors, solve_leg
from nao_kin.ik.results import Family, Reason

# Values of the joints of one leg.
Joints: TypeAlias = tuple[float, float, float, float, float, float]

# HipYawPitch, and five joints of each leg.
JOINTS, OF_ONE = 11, 6
# The product of two values of HipYawPitch and, for each leg, two knees and two rolls of the hip.
MAX_BRANCHES = 32
# Where the parts of a target begin.
LEFT, RIGHT, PRIORITY = 0, 16, 32
# Numbers of a report after the joints: errors of both feet in position, angle and yaw; the leg that fails; the move of
# the torso.
LEFT_FOOT = BEST + JOINTS
RIGHT_FOOT, FAILED_LEG, MOVED, MORE = LEFT_FOOT + 3, LEFT_FOOT + 6, LEFT_FOOT + 7, 8
NEITHER, LEFT_LEG, RIGHT_LEG = -1.0, 0.0, 1.0

_ALONE = float(Family.NONE)
# Turn of a foot [rad] up to which a solution is tried; its errors are verified.
_YAW_TOLERANCE = 1e-9
# A slope ψ' below which HipYawPitch does not turn a foot.
FLAT = 1e-11
# Rounding of Y [m].
_ROUNDING = 1e-15
# If the ankle is nearer than this to the axis of HipRoll [m], it determines the roll less precisely than the foot does.
_ALONG = 1e-4


class Legs(NamedTuple):
    """The geometry of both legs."""

    left: Leg
    right: Leg
    turn: float  # the value of the right HipYawPitch minus that of the left one [rad]


class LegsRanges(NamedTuple):
    """Limits of the six joints of each leg."""

    left: Ranges
    right: Ranges


class FootYaw(NamedTuple):
    """The turn ψ of a foot about its normal: X = x_cos cos q₁ + x_sin sin q₁, Y = y_cos cos q₁ + y_sin sin q₁."""

    x_cos: float
    x_sin: float
    y_cos: float
    y_sin: float


class LegTask(NamedTuple):
    """A leg, its target, the angle of the knee with its number of signs, and the turn of the foot."""

    leg: Leg
    foot: Pose
    knee: tuple[float, int]
    yaw: FootYaw


class Branch(NamedTuple):
    """A branch of a leg whose ankle and normal are met."""

    knee: float
    hip_sign: float  # 1 for the leg below the axis of HipRoll, −1 for above
    ankle_sign: float  # that of cos AnkleRoll


Tasks: TypeAlias = tuple[LegTask, LegTask]


@both_ways
def tasks_of(legs: Legs, target: Row, report: Row) -> tuple[bool, Tasks]:
    """Return whether the poses of both feet are rigid, and the tasks of the legs; report a leg that is too short."""
    right_rigid, right = foot_of(legs.right, target[RIGHT:PRIORITY])
    right_knee = knee_of(legs.right, right, report)
    left_rigid, left = foot_of(legs.left, target[LEFT:RIGHT])
    left_knee = knee_of(legs.left, left, report)
    return left_rigid and right_rigid, (
        LegTask(legs.left, left, left_knee, foot_yaw(left)),
        LegTask(legs.right, right, right_knee, foot_yaw(right)),
    )


@both_ways
def solve_legs(legs: Legs, target: Row, selection: Selection, work: Workspace) -> int:
    """Find all joint values that meet the poses of both feet, as `branches` describes."""
    report = work.report
    start_report(report)
    report[FAILED_LEG], report[MOVED] = NEITHER, 0.0
    is_rigid, tasks = tasks_of(legs, target, report)
    left, right = tasks
    if not is_rigid:
        report[REASON] = NOT_RIGID
        return 0
    if left.knee[1] == 0 or right.knee[1] == 0:
        report[FAILED_LEG] = LEFT_LEG if left.knee[1] == 0 else RIGHT_LEG
        return 0
    if slope(left.yaw) < FLAT and slope(right.yaw) < FLAT:
        return 0  # a family, which needs a search
    hip, count = common_hip(left.yaw, right.yaw), 0
    c, s = math.cos(hip), math.sin(hip)
    if yaw_sine(left.yaw, c, s) > _YAW_TOLERANCE or yaw_sine(right.yaw, c, s) > _YAW_TOLERANCE:
        return 0
    for value in (hip, wrapped(hip + math.pi)):
        count = _add_with_hip(tasks, value, selection, work, count)
    if count > 0:
        finish_report(work, JOINTS, count)
        for yaw, place in ((left.yaw, LEFT_FOOT), (right.yaw, RIGHT_FOOT)):
            x, y = yaw.x_cos * c + yaw.x_sin * s, yaw.y_cos * c + yaw.y_sin * s
            report[place + 2] = math.copysign(report[place + 1], x * y)
    return count


@both_ways
def _add_with_hip(tasks: Tasks, hip: float, selection: Selection, work: Workspace, count: int) -> int:
    """Add all solutions with a value of HipYawPitch, and report the errors of both feet in the best one."""
    ranges, reference, enforce = selection
    branches, report = work.branches, work.report
    left, right = tasks
    if enforce and (is_outside(ranges.left, 0, hip) or is_outside(ranges.right, 0, hip)):
        return count
    for branch in range(2 * left.knee[1]):
        fits, errors, joints = _exact(left, ranges.left, hip, branch, reference[1], enforce)
        if not fits:
            continue
        for other in range(2 * right.knee[1]):
            fits, others, right_joints = _exact(right, ranges.right, hip, other, reference[OF_ONE], enforce)
            if fits:
                write_joints(joints, right_joints, work.q)
                nearest = branches[JOINTS] if count > 0 else math.inf
                both = max(errors[0], others[0]), max(errors[1], others[1])
                count = add_branch(selection, work, both, _ALONE, count)
                if branches[JOINTS] < nearest:
                    report[LEFT_FOOT], report[LEFT_FOOT + 1] = errors
                    report[RIGHT_FOOT], report[RIGHT_FOOT + 1] = others
    return count


@both_ways
def _exact(
    task: LegTask, ranges: Ranges, hip: float, branch: int, roll: float, enforce: bool
) -> tuple[bool, tuple[float, float], Joints]:
    """Return whether a branch of a leg is a solution with this value of HipYawPitch, its errors, and its joints."""
    leg, foot = task.leg, task.foot
    bent = task.knee[0] if branch < 2 else -task.knee[0]
    if enforce and is_outside(ranges, 3, bent):
        return False, (0.0, 0.0), (hip, 0.0, 0.0, bent, 0.0, 0.0)
    cosine, sine = _roll(foot, hip, 1.0 if branch % 2 == 0 else -1.0, roll - leg.kappa)
    hip_roll = wrapped(leg.kappa + math.atan2(sine, cosine))
    if enforce and is_outside(ranges, 1, hip_roll):
        return False, (0.0, 0.0), (hip, hip_roll, 0.0, bent, 0.0, 0.0)
    q = _exact_joints(leg, foot, hip, hip_roll, bent, cosine, sine)
    if enforce and not is_inside(ranges, q):
        return False, (0.0, 0.0), q
    errors = leg_errors(leg, foot, q)
    return errors[0] <= VERIFIED and errors[1] <= VERIFIED, errors, q


@both_ways
def write_joints(left: Joints, right: Joints, q: Row) -> None:
    """Write the joints of both legs into one row."""
    q[0], q[1], q[2], q[3], q[4], q[5] = left
    _, q[6], q[7], q[8], q[9], q[10] = right


@both_ways
def errors_of_feet(tasks: Tasks, q: Row) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the errors of the left and the right foot in position and angle [m, rad]."""
    left, right = tasks
    return (
        leg_errors(left.leg, left.foot, (q[0], q[1], q[2], q[3], q[4], q[5])),
        leg_errors(right.leg, right.foot, (q[0], q[6], q[7], q[8], q[9], q[10])),
    )


@both_ways
def report_feet(tasks: Tasks, q: Row, report: Row) -> None:
    """Report joint values as the best, with the errors of both feet."""
    report[BEST : BEST + JOINTS] = q[:JOINTS]
    one, two = errors_of_feet(tasks, q)
    report[LEFT_FOOT], report[LEFT_FOOT + 1] = one
    report[RIGHT_FOOT], report[RIGHT_FOOT + 1] = two
    report[LEFT_FOOT + 2] = math.copysign(one[1], _yaw_of(tasks[0].yaw, q[0], one[1]))
    report[RIGHT_FOOT + 2] = math.copysign(two[1], _yaw_of(tasks[1].yaw, q[0], two[1]))
    report[POSITION_ERROR], report[ANGLE_ERROR] = max(one[0], two[0]), max(one[1], two[1])


# --- HipYawPitch and the turn of a foot.


@both_ways
def foot_yaw(foot: Pose) -> FootYaw:
    """Return X and Y of a target."""
    x = foot.x * foot.r00 + foot.y * foot.r10 + foot.z * foot.r20
    y = foot.x * foot.r01 + foot.y * foot.r11 + foot.z * foot.r21
    n = foot.x * foot.r02 + foot.y * foot.r12 + foot.z * foot.r22
    return FootYaw(
        foot.r00 * n - x * foot.r02,
        x * foot.r22 - foot.r20 * n,
        foot.r01 * n - y * foot.r02,
        y * foot.r22 - foot.r21 * n,
    )


@both_ways
def _yaw_of(yaw: FootYaw, hip: float, angle: float) -> float:
    """Return the turn ψ of the foot about its normal [rad], for the sign of the ankle with |ψ| nearer to `angle`."""
    c, s = math.cos(hip), math.sin(hip)
    turn = math.atan2(yaw.y_cos * c + yaw.y_sin * s, yaw.x_cos * c + yaw.x_sin * s)
    other = wrapped(turn + math.pi)
    return turn if abs(abs(turn) - angle) <= abs(abs(other) - angle) else other


@both_ways
def hip_of(yaw: FootYaw) -> float:
    """Return a value of HipYawPitch with which the foot is exact; the other one is half a turn away."""
    return math.atan2(-yaw.y_cos, yaw.y_sin)


@both_ways
def slope(yaw: FootYaw) -> float:
    """Return |ψ'| where ψ = 0; infinite if ψ is undefined there."""
    # With Y = ‖Y‖ sin (q₁ − root), X at the root is the constant X Y' − Y X' over ‖Y‖.
    square = yaw.y_cos * yaw.y_cos + yaw.y_sin * yaw.y_sin
    constant = abs(yaw.x_cos * yaw.y_sin - yaw.x_sin * yaw.y_cos)
    return square / constant if constant > 0.0 else math.inf if square > 0.0 else 0.0


@both_ways
def common_hip(left: FootYaw, right: FootYaw) -> float:
    """Return the value of HipYawPitch, between a root of the left and one of the right foot, with the least sum of ψ².

    Near a singularity rounding displaces a root, but ψ hardly changes there, so the slopes are the weights.
    """
    hip = hip_of(left)
    # The distance to the other root: sine and cosine of the difference of two arctangents, within ±π/2.
    sine = left.y_cos * right.y_sin - left.y_sin * right.y_cos
    cosine = left.y_cos * right.y_cos + left.y_sin * right.y_sin
    gap = math.atan2(sine, cosine) if cosine >= 0.0 else math.atan2(-sine, -cosine)
    # As `slope`, without a denominator that may be zero.
    one = (left.y_cos * left.y_cos + left.y_sin * left.y_sin) * (right.x_cos * right.y_sin - right.x_sin * right.y_cos)
    two = (right.y_cos * right.y_cos + right.y_sin * right.y_sin) * (left.x_cos * left.y_sin - left.x_sin * left.y_cos)
    one, two = one * one, two * two
    return wrapped(hip + gap * (two / (one + two))) if one + two > 0.0 else hip


@both_ways
def yaw_sine(yaw: FootYaw, c: float, s: float) -> float:
    """Return |sin ψ|, up to rounding, from cosine and sine of HipYawPitch."""
    x, y = yaw.x_cos * c + yaw.x_sin * s, yaw.y_cos * c + yaw.y_sin * s
    size = math.sqrt(x * x + y * y)
    return max(0.0, abs(y) - _ROUNDING) / size if size > 0.0 else 0.0


# --- The other five joints.


@both_ways
def _roll(foot: Pose, hip: float, hip_sign: float, default: float) -> tuple[float, float]:
    """Return cos and sin of ρ, the leg plane's turn about HipRoll's axis that meets the foot; `default` for any ρ."""
    c, s = math.cos(hip), math.sin(hip)
    # The ankle and the foot's x-axis, perpendicular to the axis.
    py, pz = foot.y, s * foot.x + c * foot.z
    fy, fz = foot.r10, s * foot.r00 + c * foot.r20
    aside, turned = math.sqrt(py * py + pz * pz), math.sqrt(fy * fy + fz * fz)
    if aside > _ALONG or (aside >= turned and aside > 0.0):
        return -hip_sign * pz / aside, hip_sign * py / aside
    if turned > 0.0:
        return -hip_sign * fz / turned, hip_sign * fy / turned
    return math.cos(default), math.sin(default)


@both_ways
def _exact_joints(leg: Leg, foot: Pose, hip: float, hip_roll: float, knee: float, cosine: float, sine: float) -> Joints:
    """Return the joints of a leg that meets its pose at a value of HipYawPitch, from cosine and sine of ρ."""
    c, s = math.cos(hip), math.sin(hip)
    px, pz = c * foot.x - s * foot.z, s * foot.x + c * foot.z
    fx, fz = c * foot.r00 - s * foot.r20, s * foot.r00 + c * foot.r20
    nz, yz = s * foot.r02 + c * foot.r22, s * foot.r01 + c * foot.r21
    turn = math.atan2(foot.r10 * sine - fz * cosine, fx)
    ankle_roll = math.atan2(-foot.r12 * cosine - nz * sine, foot.r11 * cosine + yz * sine)
    pitch = _hip_pitch(leg, px, pz * cosine - foot.y * sine, knee)
    return hip, hip_roll, pitch, knee, wrapped(turn - pitch - knee), ankle_roll


@both_ways
def sole_joints(task: LegTask, branch: Branch, hip: float) -> Joints:
    """Return the joints with which ankle and normal are met, whatever the turn of the foot."""
    leg, foot = task.leg, task.foot
    knee, hip_sign, ankle_sign = branch
    c, s = math.cos(hip), math.sin(hip)
    px, py, pz = c * foot.x - s * foot.z, foot.y, s * foot.x + c * foot.z
    aside = math.sqrt(py * py + pz * pz)
    cosine, sine = (-hip_sign * pz / aside, hip_sign * py / aside) if aside > 0.0 else (hip_sign, 0.0)
    nx, nz = c * foot.r02 - s * foot.r22, s * foot.r02 + c * foot.r22
    up = nz * cosine - foot.r12 * sine
    turn = math.atan2(ankle_sign * nx, ankle_sign * up)
    ankle_roll = math.atan2(-foot.r12 * cosine - nz * sine, ankle_sign * math.sqrt(nx * nx + up * up))
    pitch = _hip_pitch(leg, px, pz * cosine - py * sine, knee)
    hip_roll = wrapped(leg.kappa + math.atan2(sine, cosine))
    return hip, hip_roll, pitch, knee, wrapped(turn - pitch - knee), ankle_roll


@both_ways
def _hip_pitch(leg: Leg, x: float, z: float, knee: float) -> float:
    """Return the HipPitch with which the ankle is at (x, z) in the plane of the leg."""
    vx, vz = -leg.tibia * math.sin(knee), -leg.thigh - leg.tibia * math.cos(knee)
    return math.atan2(vz * x - vx * z, vx * x + vz * z)


# --- Feet that disagree: the value of HipYawPitch that turns them least.
#
# For one value of HipYawPitch each leg takes the branch inside its limits that turns its foot least; of equal ones the
# nearest to the reference. So the turns of both feet, weighted by the priority, are a function of HipYawPitch alone,
# with the excess over the limits as a penalty. Its local minima between even steps, and between the values that meet a
# foot, are refined. That the least of these is the least of all is tested on fine scans, and not proved.

# Codes of the priorities in a target.
BALANCED, LEFT_FIRST, RIGHT_FIRST = 0.0, 1.0, 2.0
# Turns of the feet that differ by less than this [rad] are equal; the weight of the other foot in a search.
_EQUAL, _SECOND = 1e-11, 1e-9
# Costs outside the limits begin here.
_OUTSIDE = 1e3
# Solutions with a smaller difference than this [rad] are equal.
_SAME = 1e-7
# Even steps of the search; steps of the search in a family of HipYawPitch.
_STEPS, _FAMILY_STEPS = 64, 120
# Instead of a branch of a leg: the best of all, or the first of those that turn the foot least; their largest number.
_ALL, _FIRST, _BRANCHES = -1, -2, 8

_HIPS_DISAGREE = float(Reason.HIPS_DISAGREE)
_HIP_LOCK, _ANKLE_AXIS = float(Family.HIP_LOCK), float(Family.ANKLE_AXIS)

# Arguments of the search: the legs, the branch of each, the priority, the excess over limits that is accepted
# (infinite without limits), the selection, and space for joint values.
Given: TypeAlias = tuple[Tasks, tuple[int, int], float, float, Selection, Row]
# The excess over the limits, the cost of the preferred foot or both, that of the other, the distance to the reference.
Rank: TypeAlias = tuple[float, float, float, float]


@both_ways
def solve_disagreeing(legs: Legs, target: Row, selection: Selection, work: Workspace) -> int:
    """Find the best joint values that meet ankles and normals if `solve_legs` failed; return how many meet the feet."""
    q, report = work.q, work.report
    gap = solve_separately(legs, target, selection, work)
    if report[REASON] == OUT_OF_REACH:
        return 0
    why, failed = reason_of(report), report[FAILED_LEG]
    tasks = tasks_of(legs, target, report)[1]
    tolerance = LIMIT_ROUNDING if selection.enforce else math.inf
    count, excess = _search(tasks, target[PRIORITY], tolerance, selection, work)
    if 0.0 < excess <= LIMIT_TOLERANCE:
        # As far outside as necessary, plus rounding.
        count, _ = _search(tasks, target[PRIORITY], excess + 1.001 * LIMIT_ROUNDING, selection, work)
    if count > 0:
        q[:JOINTS] = work.branches[:JOINTS]
        report_feet(tasks, q, report)
        why, failed = NO_OBSTACLE, NEITHER
    elif failed == NEITHER:
        why = _HIPS_DISAGREE, -1.0, gap, 0.0
    write_reason(report, why)
    report[FAILED_LEG] = failed
    return count


@both_ways
def solve_separately(legs: Legs, target: Row, selection: Selection, work: Workspace) -> float:
    """Solve each leg alone, and report one that does not reach its target; return the disagreement of the hips."""
    row, (ranges, reference, enforce) = OF_ONE + EXTRAS, selection
    branches, report = work.branches, work.report
    own, near = Workspace(work.q[:OF_ONE], branches, report), work.q[OF_ONE : 2 * OF_ONE]
    for j in range(OF_ONE):
        near[j] = reference[j]
    left = solve_leg(legs.left, target[LEFT:RIGHT], Selection(ranges.left, near, enforce), own)
    left_why = reason_of(report)
    # A foot is met exactly at two values of HipYawPitch, or in a family at more.
    one, other = branches[0], branches[0]
    for k in range(1, left):
        other = branches[k * row] if abs(branches[k * row] - one) > abs(other - one) else other
    for j in range(1, OF_ONE):
        near[j] = reference[OF_ONE - 1 + j]
    right, gap = solve_leg(legs.right, target[RIGHT:PRIORITY], Selection(ranges.right, near, enforce), own), math.inf
    for k in range(right):
        for hip in (one, other):
            off = hip - branches[k * row]
            gap = min(gap, abs(off if enforce else turned_towards(off, 0.0)))
    for j in range(POSITION_ERROR, len(report)):
        report[j] = math.nan
    report[MOVED] = 0.0
    # If both legs fail, report one that is too short.
    if left == 0 and (right > 0 or report[REASON] != OUT_OF_REACH or left_why[0] == OUT_OF_REACH):
        report[FAILED_LEG] = LEFT_LEG
        write_reason(report, left_why)
    elif right == 0:
        report[FAILED_LEG] = RIGHT_LEG
        if report[JOINT] > 0.0:
            report[JOINT] += OF_ONE - 1.0
    else:
        report[FAILED_LEG] = NEITHER
        write_reason(report, NO_REASON)
    return gap


@both_ways
def _search(
    tasks: Tasks, priority: float, tolerance: float, selection: Selection, work: Workspace
) -> tuple[int, float]:
    """Report the joint values that minimise the yaw errors of the feet; add them as solutions if the feet are met.

    Return the number of solutions and the smallest excess over the limits.
    """
    (left, right), (ranges, reference, enforce) = tasks, selection
    low, high = -math.pi, math.pi
    if enforce:
        low, high = max(ranges.left.lower[0], ranges.right.lower[0]), min(ranges.left.upper[0], ranges.right.upper[0])
    best, count = (math.inf, math.inf, math.inf, math.inf), 0
    if slope(left.yaw) < FLAT and slope(right.yaw) < FLAT:
        # HipYawPitch turns neither foot: of each pair of branches, take the value nearest to the reference.
        wanted, family = reference[0], _family_of(left.foot)
        if not enforce:
            low, high = wanted - math.pi, wanted + math.pi
        for pair in range(_BRANCHES * _BRANCHES):
            given = tasks, (pair // _BRANCHES, pair % _BRANCHES), priority, tolerance, selection, work.q
            hip = least(_distance, given, low, high, wanted, _FAMILY_STEPS)
            best, count = _compared(given, hip, best, family, work, count)
        return count, best[0]
    given = tasks, (_FIRST, _FIRST), priority, tolerance, selection, work.q
    all_branches = tasks, (_ALL, _ALL), priority, tolerance, selection, work.q
    hips, minima, n = np.empty(_STEPS + 5), np.empty(_STEPS + 5), 0
    for k in range(_STEPS + 5):
        hip = low + (high - low) / _STEPS * k
        if k > _STEPS:  # a value that meets one foot, where its turn may be steep
            hip = wrapped(hip_of(left.yaw if k <= _STEPS + 2 else right.yaw) + math.pi * (k % 2))
        if low <= hip <= high:
            hips[n] = hip
            n += 1
    for k in range(local_minima(_cost, given, np.sort(hips[:n]), minima)):
        best, count = _compared(all_branches, minima[k], best, _ALONE, work, count)
    return count, best[0]


@both_ways
def _compared(given: Given, hip: float, best: Rank, family: float, work: Workspace, count: int) -> tuple[Rank, int]:
    """Report this value of HipYawPitch if it is the best one, and add it if it meets both feet."""
    tasks, _, priority, _, selection, q = given
    outside, left, right, distance = _both(given, hip)
    if outside > 0.0:
        return (min(outside, best[0]), best[1], best[2], best[3]), count
    if max(left, right) < _YAW_TOLERANCE:
        count = _add_if_met(tasks, family, selection, work, count)
    one, two = math.sqrt(left * left + right * right), 0.0
    if priority != BALANCED:
        one, two = (left, right) if priority == LEFT_FIRST else (right, left)
    is_better = distance < best[3]
    for mine, other in ((two, best[2]), (one, best[1])):
        if abs(mine - other) > _EQUAL:
            is_better = mine < other
    if is_better:
        best = 0.0, one, two, distance
        report_feet(tasks, q, work.report)
    return best, count


@both_ways
def _cost(given: Given, hip: float) -> float:
    """Return the turns of both feet, weighted by the priority, or much more outside the limits."""
    tasks, _, priority, tolerance, _, _ = given
    if tolerance == math.inf:
        left, right = min(_turns(tasks[0].yaw, hip)), min(_turns(tasks[1].yaw, hip))
    else:
        outside, left, right, _ = _both(given, hip)
        if outside > 0.0:
            return _OUTSIDE * (1.0 + outside)
    if priority == BALANCED:
        return math.sqrt(left * left + right * right)
    return left + _SECOND * right if priority == LEFT_FIRST else right + _SECOND * left


@both_ways
def _distance(given: Given, hip: float) -> float:
    """Return the squared distance to the reference, or much more outside the limits."""
    outside, _, _, distance = _both(given, hip)
    return distance if outside == 0.0 else _OUTSIDE * (1.0 + outside)


@both_ways
def _turns(yaw: FootYaw, hip: float) -> tuple[float, float]:
    """Return |ψ| for both signs of u."""
    c, s = math.cos(hip), math.sin(hip)
    turn = abs(math.atan2(yaw.y_cos * c + yaw.y_sin * s, yaw.x_cos * c + yaw.x_sin * s))
    return turn, math.pi - turn


@both_ways
def _both(given: Given, hip: float) -> tuple[float, float, float, float]:
    """Write the joints of both legs for a value of HipYawPitch; return their excess, turns, and squared distance."""
    (left, right), (one, two), _, tolerance, (ranges, reference, enforce), q = given
    outside, turn, distance, joints = _one_leg(left, ranges.left, one, hip, reference[1:OF_ONE], tolerance)
    beyond, other, further, others = _one_leg(right, ranges.right, two, hip, reference[OF_ONE:], tolerance)
    write_joints(joints, others, q)
    off = joint_difference(hip, reference[0], enforce)
    return max(outside, beyond), turn, other, distance + further + off * off


@both_ways
def _one_leg(
    task: LegTask, ranges: Ranges, branch: int, hip: float, reference: Row, tolerance: float
) -> tuple[float, float, float, Joints]:
    """Return the excess over limits, |ψ|, squared distance and joints of a branch of a leg with this HipYawPitch."""
    enforce = tolerance < math.inf
    ahead, back = _turns(task.yaw, hip)
    best, joints = (math.inf, math.inf, math.inf), (hip, 0.0, 0.0, 0.0, 0.0, 0.0)
    for k in range(4 * task.knee[1]):
        knee = task.knee[0] if k // 2 % task.knee[1] == 0 else -task.knee[0]
        if (branch >= 0 and branch != k) or (enforce and is_outside(ranges, 3, knee)):
            continue
        # The branches with the smaller turn come first.
        hip_sign, is_ahead = 1.0 - 2.0 * (k % 2), (ahead <= back) == (k < 2 * task.knee[1])
        turn, ankle_sign = (ahead, -hip_sign) if is_ahead else (back, hip_sign)
        if best[0] == 0.0 and (turn > best[1] or branch == _FIRST):
            break
        q = sole_joints(task, Branch(knee, hip_sign, ankle_sign), hip)
        outside = max(0.0, _excess(ranges, q) - tolerance) if enforce else 0.0
        rank = outside, turn, squared_distance(q[1:], reference, enforce)
        if rank < best:
            best, joints = rank, q
    return best[0], best[1], best[2], joints


@both_ways
def _excess(ranges: Ranges, q: Joints) -> float:
    """Return how far joint values are outside their limits, also outside a table and their own range at once."""
    worst = -math.inf
    for j in range(OF_ONE):
        worst = max(worst, ranges.lower[j] - q[j], q[j] - ranges.upper[j])
    if ranges.bends > 0:
        low, high = table_range(ranges, q[ranges.of])
        worst = max(worst, low - q[ranges.joint], q[ranges.joint] - high)
    return worst


@both_ways
def _add_if_met(tasks: Tasks, family: float, selection: Selection, work: Workspace, count: int) -> int:
    """Add joint values that meet both feet, unless they are already in `work.branches`."""
    q, width = work.q, JOINTS + EXTRAS
    for k in range(count):
        off = 0.0
        for j in range(JOINTS):
            off = max(off, abs(turned_towards(work.branches[k * width + j] - q[j], 0.0)))
        if off < _SAME:
            return count
    if count == MAX_BRANCHES:
        return count
    one, two = errors_of_feet(tasks, q)
    return add_branch(selection, work, (max(one[0], two[0]), max(one[1], two[1])), family, count)


@both_ways
def _family_of(foot: Pose) -> float:
    """Return the family of a leg whose foot does not turn with HipYawPitch: the one whose singularity is nearer."""
    y = foot.x * foot.r01 + foot.y * foot.r11 + foot.z * foot.r21
    n = foot.x * foot.r02 + foot.y * foot.r12 + foot.z * foot.r22
    return _ANKLE_AXIS if y * y + n * n <= foot.y * foot.y else _HIP_LOCK
