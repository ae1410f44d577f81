"""Both legs if no value of HipYawPitch meets both feet: the best value inside the limits.

Ankle and normal of both soles stay exact. HipYawPitch is the value with the smallest rotations ψ of the feet about
their normals, weighted by the priority, in the intervals that the limits of both legs allow. Each leg is first solved
alone, to find the reason of a failure.
"""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._kernels.cache import Row, both_ways
from nao_kin.ik.branches import (
    EXTRAS,
    JOINT,
    NO_OBSTACLE,
    NO_REASON,
    OUT_OF_REACH,
    POSITION_ERROR,
    REASON,
    Pose,
    Ranges,
    Selection,
    Workspace,
    add_branch,
    add_roots,
    crossing,
    is_inside,
    is_outside,
    joint_difference,
    least,
    reason_of,
    squared_distance,
    table_range,
    turned_towards,
    wrapped,
    write_reason,
)
from nao_kin.ik.leg import solve_leg
from nao_kin.ik.legs_equations import (
    FAILED_LEG,
    FLAT,
    JOINTS,
    LEFT,
    LEFT_LEG,
    MAX_BRANCHES,
    MOVED,
    NEITHER,
    OF_ONE,
    PRIORITY,
    RIGHT,
    RIGHT_LEG,
    Branch,
    FootYaw,
    Joints,
    Legs,
    LegTask,
    Tasks,
    errors_of_feet,
    hip_of,
    report_feet,
    slope,
    sole_joints,
    tasks_of,
    write_joints,
)
from nao_kin.ik.results import Family, Reason

# --- The values of HipYawPitch inside the limits of a leg, for a given ankle and normal of the sole.
#
# For each branch of a leg (knee, signs of hip and ankle) they are a few intervals, here called pieces. A joint is at
# its limit at the roots of a linear or quadratic form in (cos q₁, sin q₁), found to full precision; only the roots
# where AnkleRoll is at its coupled limit are bracketed.

# Space for the pieces of all branches of a leg, and for the ends of one branch's pieces, without and with the table's.
MAX_PIECES, _MAX_ENDS = 128, 384
# Numbers of a piece: its ends, the sign of ψ's branch, the knee, the signs of hip and ankle (0 for any).
FROM, TO, SIGN, KNEE, HIP_SIGN, ANKLE_SIGN, PIECE = range(7)
# Steps of HipYawPitch between two ends in which roots of the coupled limit are bracketed.
_TABLE_STEPS = 8


@both_ways
def write_pieces(task: LegTask, ranges: Ranges, enforce: bool, pieces: Floats) -> int:
    """Write the pieces of HipYawPitch in which ankle and normal are met inside the limits; return their number."""
    if not enforce:
        for side in range(2):
            pieces[side] = np.array((-math.pi, math.pi, 2.0 * side - 1.0, task.knee[0], 0.0, 0.0))
        return 2
    count, ends = 0, np.empty(_MAX_ENDS)
    for bend in range(task.knee[1]):
        knee = task.knee[0] if bend == 0 else -task.knee[0]
        if is_outside(ranges, 3, knee):
            continue
        boxes = _write_ends(task, ranges, knee, ends)
        for hip_sign in (1.0, -1.0):
            for ankle_sign in (1.0, -1.0):
                branch = Branch(knee, hip_sign, ankle_sign)
                last = _add_ends_of_table(task, ranges, branch, ends, boxes)
                count = _add_pieces(task, ranges, branch, ends[boxes:last], pieces, count)
    return count


@both_ways
def _add_pieces(task: LegTask, ranges: Ranges, branch: Branch, ends: Floats, pieces: Floats, count: int) -> int:
    """Add a branch's pieces: joined intervals between ends, and single ends, that are inside the limits."""
    joined, begin = False, 0.0
    for i in range(len(ends)):
        after = i + 1 < len(ends) and is_inside(ranges, sole_joints(task, branch, 0.5 * (ends[i] + ends[i + 1])))
        if after and not joined:
            begin = ends[i]
        elif not joined and is_inside(ranges, sole_joints(task, branch, ends[i])):
            begin, joined = ends[i], True
        if joined and not after and count < len(pieces):
            knee, hip_sign, ankle_sign = branch
            pieces[count] = np.array((begin, ends[i], -hip_sign * ankle_sign, knee, hip_sign, ankle_sign))
            count += 1
        joined = after
    return count


@both_ways
def _write_ends(task: LegTask, ranges: Ranges, knee: float, ends: Floats) -> int:
    """Write all values of HipYawPitch that may put a joint at a limit or a table's row, sorted; return their number."""
    leg, foot = task.leg, task.foot
    ends[0], ends[1], count = ranges.lower[0], ranges.upper[0], 2
    x, y, z = foot.x, foot.y, foot.z
    n0, n1, n2 = foot.r02, foot.r12, foot.r22
    square, up = x * x + y * y + z * z, x * n0 + y * n1 + z * n2
    vx, vz = -leg.tibia * math.sin(knee), -leg.thigh - leg.tibia * math.cos(knee)
    w0, w2 = n1 * z - n2 * y, n0 * y - n1 * x
    for limits in (ranges.lower, ranges.upper):
        # HipRoll: y cos ρ + z' sin ρ = 0.
        rho = limits[1] - leg.kappa
        count = _add_angles(1, z * math.sin(rho), x * math.sin(rho), -y * math.cos(rho), ends, count)
        # HipPitch: the ankle's x after HipYawPitch.
        count = _add_angles(1, x, -z, vx * math.cos(limits[2]) + vz * math.sin(limits[2]), ends, count)
        # AnkleRoll: (n · (p × e))² = sin² q₆ |p × e|².
        part = math.sin(limits[5]) ** 2
        a, b = w0 * w0 - part * (square - x * x), -2.0 * (w0 * w2 + part * x * z)
        count = _add_form(a, b, w2 * w2 - part * (square - z * z), ends, count)
    # AnklePitch: (u · p)² = h_x² |u|², with the hip at h_x along the foot.
    g0, g2 = up * x - square * n0, up * z - square * n2
    u00 = up * up - 2.0 * up * x * n0 + square * n0 * n0
    u02 = 2.0 * (up * (x * n2 + z * n0) - square * n0 * n2)
    u22 = up * up - 2.0 * up * z * n2 + square * n2 * n2
    bx, bz = -leg.thigh * math.sin(knee), leg.tibia + leg.thigh * math.cos(knee)
    for k in range(ranges.bends + 2):
        pitch = ranges.at[k] if k < ranges.bends else (ranges.lower if k == ranges.bends else ranges.upper)[4]
        part = (bx * math.cos(pitch) - bz * math.sin(pitch)) ** 2
        count = _add_form(g0 * g0 - part * u00, -2.0 * g0 * g2 - part * u02, g2 * g2 - part * u22, ends, count)
    ends[:count] = np.sort(ends[:count])
    return count


@both_ways
def _add_form(a: float, b: float, c: float, ends: Floats, count: int) -> int:
    """Add the q₁ with a cos² q₁ + b cos q₁ sin q₁ + c sin² q₁ = 0, a linear form in cosine and sine of 2 q₁."""
    return _add_angles(2, a - c, b, -(a + c), ends, count)


@both_ways
def _add_angles(times: int, cosine: float, sine: float, value: float, ends: Floats, count: int) -> int:
    """Add the q₁ between the first two ends with cosine · cos(times · q₁) + sine · sin(times · q₁) = value."""
    size = math.sqrt(cosine * cosine + sine * sine)
    # A double root that rounding has removed is restored.
    if size > 0.0 and abs(value) <= size * (1.0 + 1e-14):
        middle, half = math.atan2(sine, cosine), math.acos(min(1.0, max(-1.0, value / size)))
        for angle in (middle - half, middle + half):
            for turn in range(times):
                hip = wrapped(angle / times + math.pi * turn)
                if ends[0] < hip < ends[1] and count < len(ends):
                    ends[count] = hip
                    count += 1
    return count


@both_ways
def _add_ends_of_table(task: LegTask, ranges: Ranges, branch: Branch, ends: Floats, boxes: int) -> int:
    """After the ends from boxes, write these again with the coupled limit's roots, sorted; return the total number."""
    count = 2 * boxes
    ends[boxes:count] = ends[:boxes]
    if ranges.bends == 0:
        return count
    for i in range(boxes - 1):
        low, high = ends[i], ends[i + 1]
        q = sole_joints(task, branch, 0.5 * (low + high))
        if is_outside(ranges, 1, q[1]) or is_outside(ranges, 2, q[2]) or is_outside(ranges, 4, q[4]):
            continue
        for side in range(2):
            count = add_roots(_table_excess, (task, ranges, branch, side), low, high, _TABLE_STEPS, ends, count)
    ends[boxes:count] = np.sort(ends[boxes:count])
    return count


@both_ways
def _table_excess(given: tuple[LegTask, Ranges, Branch, int], hip: float) -> float:
    """Return how far AnkleRoll is beyond one side of its coupled limit."""
    task, ranges, branch, side = given
    q = sole_joints(task, branch, hip)
    low, high = table_range(ranges, q[4])
    return low - q[5] if side == 0 else q[5] - high


# --- The least turns ψ of both feet about their normals, between two values of HipYawPitch.
#
# They are at an end, at a root of ψ, or at a root of the sum of ψ ψ' over both feet. Roots of this sum are bracketed
# between values of q₁ in even steps of q₁ and in even steps of ψ of either foot: no function is steep between two of
# these values.

# The turns of both feet, each with the sign of its branch.
FootYaws: TypeAlias = tuple[FootYaw, FootYaw]

# Codes of the priorities in a target.
BALANCED, LEFT_FIRST, RIGHT_FIRST = 0.0, 1.0, 2.0
# Turns of the feet that differ by less than this [rad] are equal.
EQUAL = 1e-11
# Even steps between two ends, in q₁ and in ψ of each foot, and the most values of HipYawPitch that they give.
_EVEN_STEPS = 24
MAX_VALUES = 5 * _EVEN_STEPS + 6


@both_ways
def is_worse(cost: tuple[float, float], than: tuple[float, float]) -> bool:
    """Return whether a pair of costs is worse than another by the first costs, or by the second if these are equal."""
    if abs(cost[0] - than[0]) > EQUAL:
        return cost[0] > than[0]
    return cost[1] > than[1] + EQUAL


@both_ways
def cost_of(yaws: FootYaws, priority: float, hip: float) -> tuple[float, float]:
    """Return the turns of the feet for a comparison: the norm of both, or the preferred foot first."""
    left, right = abs(_yaw_at(yaws[0], hip)[0]), abs(_yaw_at(yaws[1], hip)[0])
    if priority == LEFT_FIRST:
        return left, right
    if priority == RIGHT_FIRST:
        return right, left
    return math.sqrt(left * left + right * right), 0.0


@both_ways
def hip_with_least_turns(yaws: FootYaws, priority: float, low: float, high: float, hips: Floats) -> float:
    """Return the value of HipYawPitch in [low, high] with the least turns; `hips` has space for `MAX_VALUES`."""
    best, cost = low, cost_of(yaws, priority, low)
    hips[0], count = high, 1
    for yaw in yaws:
        count = _add_half_turns(hip_of(yaw), low, high, hips, count)
    for k in range(count):
        other = cost_of(yaws, priority, hips[k])
        if is_worse(cost, other):
            best, cost = hips[k], other
    if priority != BALANCED or low == high:
        return best
    for k in range(_EVEN_STEPS):
        hips[count] = low + (high - low) * k / _EVEN_STEPS
        count += 1
    for yaw in yaws:
        count = _add_evenly_turned(yaw, low, high, hips, count)
    hips[:count] = np.sort(hips[:count])
    growth = _cost_slope(yaws, low)
    for k in range(1, count):
        grows = _cost_slope(yaws, hips[k])
        if growth < 0.0 <= grows:
            hip = crossing(_cost_slope, yaws, hips[k - 1], hips[k], False)
            other = cost_of(yaws, priority, hip)
            if other[0] < cost[0]:
                best, cost = hip, other
        growth = grows
    return best


@both_ways
def _yaw_at(yaw: FootYaw, hip: float) -> tuple[float, float]:
    """Return ψ of a branch, and its slope ψ'."""
    c, s = math.cos(hip), math.sin(hip)
    x, y = yaw.x_cos * c + yaw.x_sin * s, yaw.y_cos * c + yaw.y_sin * s
    square = x * x + y * y
    return math.atan2(y, x), (yaw.x_cos * yaw.y_sin - yaw.x_sin * yaw.y_cos) / square if square > 0.0 else 0.0


@both_ways
def _cost_slope(yaws: FootYaws, hip: float) -> float:
    """Return half the derivative of the sum of squares of both turns."""
    left, right = _yaw_at(yaws[0], hip), _yaw_at(yaws[1], hip)
    return left[0] * left[1] + right[0] * right[1]


@both_ways
def _add_evenly_turned(yaw: FootYaw, low: float, high: float, hips: Floats, count: int) -> int:
    """Add values of HipYawPitch with even steps of a foot's turn."""
    first, last = _yaw_at(yaw, low)[0], _yaw_at(yaw, high)[0]
    grows = yaw.x_cos * yaw.y_sin - yaw.x_sin * yaw.y_cos
    if grows > 0.0 and last < first:
        last += 2.0 * math.pi
    if grows < 0.0 and last > first:
        last -= 2.0 * math.pi
    for k in range(1, _EVEN_STEPS):
        turn = first + (last - first) * k / _EVEN_STEPS
        c, s = math.cos(turn), math.sin(turn)
        # X sin ψ = Y cos ψ
        hip = math.atan2(yaw.y_cos * c - yaw.x_cos * s, yaw.x_sin * s - yaw.y_sin * c)
        count = _add_half_turns(hip, low, high, hips, count)
    return count


@both_ways
def _add_half_turns(hip: float, low: float, high: float, hips: Floats, count: int) -> int:
    """Add a value and the one half a turn away, if they are in (low, high)."""
    for half in range(2):
        value = wrapped(hip + math.pi * half)
        if low < value < high:
            hips[count] = value
            count += 1
    return count


# --- The best solution inside the limits of both legs.

_HIPS_DISAGREE = float(Reason.HIPS_DISAGREE)
_ALONE, _HIP_LOCK, _ANKLE_AXIS = float(Family.NONE), float(Family.HIP_LOCK), float(Family.ANKLE_AXIS)
# Pieces with a smaller gap than this [rad] touch.
_TOUCHING = 1e-10
# Turns of the feet [rad] up to which a pose may be met; its errors are verified.
_YAW_TOLERANCE = 1e-9
# Solutions with a smaller difference than this [rad] are equal.
_SAME = 1e-7
# Steps of the search in a family of HipYawPitch.
_STEPS = 120


@both_ways
def solve_disagreeing(legs: Legs, target: Row, selection: Selection, work: Workspace) -> int:
    """Find the best joint values that meet ankles and normals if `solve_legs` failed; return how many were found."""
    q, report = work.q, work.report
    gap = solve_separately(legs, target, selection, work)
    if report[REASON] == OUT_OF_REACH:
        return 0
    why, failed = reason_of(report), report[FAILED_LEG]
    tasks = tasks_of(legs, target, report)[1]
    count = _over_pieces(tasks, target[PRIORITY], selection, work)
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
def _over_pieces(tasks: Tasks, priority: float, selection: Selection, work: Workspace) -> int:
    """Report the joint values that minimise the yaw errors of the feet; add them as solutions if the feet are met."""
    q, (left, right) = work.q, tasks
    lefts, rights = np.empty((MAX_PIECES, PIECE)), np.empty((MAX_PIECES, PIECE))
    left_count = write_pieces(left, selection.ranges.left, selection.enforce, lefts)
    right_count = write_pieces(right, selection.ranges.right, selection.enforce, rights)
    flat = slope(left.yaw) < FLAT and slope(right.yaw) < FLAT
    family = _family_of(left.foot) if flat else _ALONE
    hips = np.empty(MAX_VALUES)
    count, best, away = 0, (math.inf, math.inf), math.inf
    for i in range(left_count):
        for j in range(right_count):
            low, high = max(lefts[i, FROM], rights[j, FROM]), min(lefts[i, TO], rights[j, TO])
            if low > high + _TOUCHING:
                continue
            high = max(low, high)
            yaws = _signed(left.yaw, lefts[i, SIGN]), _signed(right.yaw, rights[j, SIGN])
            given = tasks, lefts[i], rights[j], selection, q
            if flat:
                # HipYawPitch turns neither foot: take the value nearest to the reference.
                wanted = selection.reference[0]
                if not selection.enforce:
                    low, high = wanted - math.pi, wanted + math.pi
                hip = least(_nearest_branches, given, low, high, wanted, _STEPS)
            else:
                hip = hip_with_least_turns(yaws, priority, low, high, hips)
            cost = cost_of(yaws, priority, hip)
            if is_worse(cost, best):
                continue
            near = _nearest_branches(given, hip)
            if near == math.inf:
                continue
            if max(cost[0], cost[1]) < _YAW_TOLERANCE:
                count = _add_if_met(tasks, family, selection, work, count)
            if is_worse(best, cost) or near < away:
                best, away = cost, near
                report_feet(tasks, q, work.report)
    return count


@both_ways
def _signed(yaw: FootYaw, sign: float) -> FootYaw:
    return FootYaw(sign * yaw.x_cos, sign * yaw.x_sin, sign * yaw.y_cos, sign * yaw.y_sin)


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


@both_ways
def _nearest_branches(given: tuple[Tasks, Floats, Floats, Selection, Row], hip: float) -> float:
    """Write the joints of two pieces nearest to the reference at this HipYawPitch; return squared distance or inf."""
    (left, right), left_piece, right_piece, (ranges, reference, enforce), q = given
    away, joints = _nearest_branch(left, ranges.left, left_piece, hip, reference[1:OF_ONE], enforce)
    far, others = _nearest_branch(right, ranges.right, right_piece, hip, reference[OF_ONE:], enforce)
    write_joints(joints, others, q)
    off = joint_difference(hip, reference[0], enforce)
    return away + far + off * off


@both_ways
def _nearest_branch(
    task: LegTask, ranges: Ranges, piece: Floats, hip: float, reference: Row, enforce: bool
) -> tuple[float, Joints]:
    """Return the squared distance of five joints of one leg to the reference's, and the joints."""
    if piece[HIP_SIGN] != 0.0:
        q = sole_joints(task, Branch(piece[KNEE], piece[HIP_SIGN], piece[ANKLE_SIGN]), hip)
        inside = not enforce or is_inside(ranges, q)
        return squared_distance(q[1:], reference, enforce) if inside else math.inf, q
    best, nearest = sole_joints(task, Branch(task.knee[0], 1.0, -piece[SIGN]), hip), math.inf
    for branch in range(2 * task.knee[1]):
        sign = 1.0 if branch % 2 == 0 else -1.0
        q = sole_joints(task, Branch(task.knee[0] if branch < 2 else -task.knee[0], sign, -sign * piece[SIGN]), hip)
        away = squared_distance(q[1:], reference, enforce)
        if away < nearest:
            nearest, best = away, q
    return nearest, best
