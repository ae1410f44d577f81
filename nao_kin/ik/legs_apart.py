"""Both legs where no value of HipYawPitch meets both feet: the best of those that the limits leave.

Ankle and normal of both soles stay exact, and of HipYawPitch the value is taken with the least turns ψ of the feet
about their normals, as the priority weighs them; it lies within pieces of both legs. What the target asks of each leg
alone is looked at first, for the reason.
"""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._kernels.cache import both_ways
from nao_kin.ik.compiling import Row
from nao_kin.ik.leg import solve_leg
from nao_kin.ik.legs_equations import (
    BLAMED,
    JOINTS,
    LEFT,
    LEFT_LEG,
    LEVEL,
    MORE,
    MOST_BRANCHES,
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
    level_joints,
    report_feet,
    slope,
    tasks_of,
    write_joints,
)
from nao_kin.ik.ranges import (
    ANGLE_ERROR,
    BEST,
    EXTRAS,
    JOINT,
    LIMIT,
    NEEDED,
    NOT_CONVERGED,
    OUT_OF_REACH,
    POSITION_ERROR,
    REACHED,
    REASON,
    Pose,
    Ranges,
    Selection,
    Workspace,
    add_branch,
    is_inside,
    is_outside,
    joint_difference,
    squared_distance,
    table_range,
    turned_towards,
    wrapped,
)
from nao_kin.ik.results import Family, Reason
from nao_kin.ik.searches import add_roots, crossing, least

# --- The values of HipYawPitch that the limits of a leg leave, where its ankle and the normal of its sole are given.
#
# For each branch of a leg (knee, way of HipRoll, way of the ankle) they are a few pieces. Where a joint is at its
# limit is a root of a linear or quadratic form in (cos q₁, sin q₁), with every digit; only where AnkleRoll is at a
# limit that AnklePitch leaves it, it is bracketed.

# Pieces of all branches of a leg together, and ends of the pieces of one branch, before and after the table.
MOST_PIECES, _MOST_ENDS = 128, 384
# Places in a piece: its ends, the sign of ψ's branch, the knee, the ways of HipRoll and of the ankle (0 for any).
FROM, TO, SIGN, KNEE, WAY, ANKLE, PIECE = range(7)
# Values of HipYawPitch that a table is looked at between two bends.
_LOOKS = 8


@both_ways
def write_pieces(task: LegTask, ranges: Ranges, enforce: bool, pieces: Floats) -> int:
    """Write the pieces of HipYawPitch with which ankle and normal are met inside the limits; their number."""
    count = 0
    if not enforce:
        for sign in (-1.0, 1.0):
            pieces[count] = np.array((-math.pi, math.pi, sign, task.knee[0], 0.0, 0.0))
            count += 1
        return count
    ends = np.empty(_MOST_ENDS)
    for bend in range(task.knee[1]):
        knee = task.knee[0] if bend == 0 else -task.knee[0]
        if is_outside(ranges, 3, knee):
            continue
        boxes = _write_ends(task, ranges, knee, ends)
        for way in (1.0, -1.0):
            for ankle in (1.0, -1.0):
                branch = Branch(knee, way, ankle)
                last = _add_ends_of_table(task, ranges, branch, ends, boxes)
                count = _add_pieces(task, ranges, branch, ends[boxes:last], pieces, count)
    return count


@both_ways
def _add_pieces(task: LegTask, ranges: Ranges, branch: Branch, ends: Floats, pieces: Floats, count: int) -> int:
    """Join what is inside between ends, and ends that are inside by themselves."""
    joined, begin = False, 0.0
    for i in range(len(ends)):
        after = i + 1 < len(ends) and _is_level_inside(task, ranges, branch, 0.5 * (ends[i] + ends[i + 1]))
        if after and not joined:
            begin = ends[i]
        elif not joined and _is_level_inside(task, ranges, branch, ends[i]):
            begin, joined = ends[i], True
        if joined and not after and count < len(pieces):
            knee, way, ankle = branch
            pieces[count] = np.array((begin, ends[i], -way * ankle, knee, way, ankle))
            count += 1
        joined = after
    return count


@both_ways
def _is_level_inside(task: LegTask, ranges: Ranges, branch: Branch, hip: float) -> bool:
    return is_inside(ranges, level_joints(task, branch, hip))


# --- where joints are at their limits ---------------------------------------------------------------------------------


@both_ways
def _write_ends(task: LegTask, ranges: Ranges, knee: float, ends: Floats) -> int:
    """Sorted, all values of HipYawPitch inside its range that may put a joint at a limit or at a bend of the table."""
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
    """Add the q₁ with a cos² q₁ + b cos q₁ sin q₁ + c sin² q₁ = 0, which is linear in cosine and sine of 2 q₁."""
    return _add_angles(2, a - c, b, -(a + c), ends, count)


@both_ways
def _add_angles(times: int, cosine: float, sine: float, value: float, ends: Floats, count: int) -> int:
    """Add the q₁ between the first two ends with cosine · cos(times · q₁) + sine · sin(times · q₁) = value."""
    size = math.sqrt(cosine * cosine + sine * sine)
    # A double root, by rounding none, is one.
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
    """Behind the ends of boxes, add the same with those where AnkleRoll meets its coupled limit, sorted; the number."""
    count = 2 * boxes
    ends[boxes:count] = ends[:boxes]
    if ranges.bends == 0:
        return count
    for i in range(boxes - 1):
        low, high = ends[i], ends[i + 1]
        q = level_joints(task, branch, 0.5 * (low + high))
        if is_outside(ranges, 1, q[1]) or is_outside(ranges, 2, q[2]) or is_outside(ranges, 4, q[4]):
            continue
        for side in range(2):
            count = add_roots(_beyond, (task, ranges, branch, side), low, high, _LOOKS, ends, count)
    ends[boxes:count] = np.sort(ends[boxes:count])
    return count


@both_ways
def _beyond(given: tuple[LegTask, Ranges, Branch, int], hip: float) -> float:
    """How far AnkleRoll is beyond one side of its coupled limit."""
    task, ranges, branch, side = given
    q = level_joints(task, branch, hip)
    low, high = table_range(ranges, q[4])
    return low - q[5] if side == 0 else q[5] - high


# --- The least turns ψ of both feet about their normals, between two values of HipYawPitch.
#
# They are at an end, at a root of ψ, or where ψ ψ' of both feet are opposite: the last are bracketed between values
# that are spaced evenly in q₁ and in ψ of either foot, so that none is steep between two of them.

# How both feet turn, each with the sign of its branch.
Yaws: TypeAlias = tuple[FootYaw, FootYaw]

# Priorities, as a number in a target.
BALANCED, LEFT_FIRST, RIGHT_FIRST = 0.0, 1.0, 2.0
# Turns of the feet [rad] that differ by less are equal.
EQUAL = 1e-11
# Values of HipYawPitch between two ends, evenly in q₁ and in ψ of each foot, and how many that makes at most.
_EVENLY = 24
MOST_VALUES = 5 * _EVENLY + 6


@both_ways
def is_more(cost: tuple[float, float], than: tuple[float, float]) -> bool:
    """Whether turns of the feet are worse than others: the first, or where these are equal the second."""
    if abs(cost[0] - than[0]) > EQUAL:
        return cost[0] > than[0]
    return cost[1] > than[1] + EQUAL


@both_ways
def cost_of(yaws: Yaws, priority: float, hip: float) -> tuple[float, float]:
    """The turns of the feet as they are compared: both together, or the preferred first."""
    left, right = abs(_turn(yaws[0], hip)[0]), abs(_turn(yaws[1], hip)[0])
    if priority == LEFT_FIRST:
        return left, right
    if priority == RIGHT_FIRST:
        return right, left
    return math.sqrt(left * left + right * right), 0.0


@both_ways
def least_turns(yaws: Yaws, priority: float, low: float, high: float, hips: Floats) -> float:
    """The value of HipYawPitch within [low, high] with the least turns; `hips` has room for `MOST_VALUES`."""
    best, cost = low, cost_of(yaws, priority, low)
    hips[0], count = high, 1
    for yaw in yaws:
        count = _add_both(hip_of(yaw), low, high, hips, count)
    for k in range(count):
        other = cost_of(yaws, priority, hips[k])
        if is_more(cost, other):
            best, cost = hips[k], other
    if priority != BALANCED or low == high:
        return best
    for k in range(_EVENLY):
        hips[count] = low + (high - low) * k / _EVENLY
        count += 1
    for yaw in yaws:
        count = _add_evenly_turned(yaw, low, high, hips, count)
    hips[:count] = np.sort(hips[:count])
    growth = _growth(yaws, low)
    for k in range(1, count):
        grows = _growth(yaws, hips[k])
        if growth < 0.0 <= grows:
            hip = crossing(_growth, yaws, hips[k - 1], hips[k], False)
            other = cost_of(yaws, priority, hip)
            if other[0] < cost[0]:
                best, cost = hip, other
        growth = grows
    return best


@both_ways
def _turn(yaw: FootYaw, hip: float) -> tuple[float, float]:
    """ψ of a branch, and its slope ψ'."""
    c, s = math.cos(hip), math.sin(hip)
    x, y = yaw.x_cos * c + yaw.x_sin * s, yaw.y_cos * c + yaw.y_sin * s
    square = x * x + y * y
    return math.atan2(y, x), (yaw.x_cos * yaw.y_sin - yaw.x_sin * yaw.y_cos) / square if square > 0.0 else 0.0


@both_ways
def _growth(yaws: Yaws, hip: float) -> float:
    """Half the derivative of the sum of the squares of both turns."""
    left, right = _turn(yaws[0], hip), _turn(yaws[1], hip)
    return left[0] * left[1] + right[0] * right[1]


@both_ways
def _add_evenly_turned(yaw: FootYaw, low: float, high: float, hips: Floats, count: int) -> int:
    """Add values of HipYawPitch between which a foot turns evenly."""
    first, last = _turn(yaw, low)[0], _turn(yaw, high)[0]
    grows = yaw.x_cos * yaw.y_sin - yaw.x_sin * yaw.y_cos
    if grows > 0.0 and last < first:
        last += 2.0 * math.pi
    if grows < 0.0 and last > first:
        last -= 2.0 * math.pi
    for k in range(1, _EVENLY):
        turn = first + (last - first) * k / _EVENLY
        c, s = math.cos(turn), math.sin(turn)
        # X sin ψ = Y cos ψ
        hip = math.atan2(yaw.y_cos * c - yaw.x_cos * s, yaw.x_sin * s - yaw.y_sin * c)
        count = _add_both(hip, low, high, hips, count)
    return count


@both_ways
def _add_both(hip: float, low: float, high: float, hips: Floats, count: int) -> int:
    """Add a value and the one half a turn away, as far as they are between two others."""
    for half in range(2):
        value = wrapped(hip + math.pi * half)
        if low < value < high:
            hips[count] = value
            count += 1
    return count


# --- The best of what the limits leave to both legs.

_HIPS_DISAGREE = float(Reason.HIPS_DISAGREE)
_ALONE, _HIP_LOCK, _ANKLE_AXIS = float(Family.NONE), float(Family.HIP_LOCK), float(Family.ANKLE_AXIS)
# Pieces that are this far apart [rad] meet.
_MEET = 1e-10
# Turns of the feet [rad] that may be none: verified is the pose.
_NEARLY = 1e-9
# Solutions that are nearer to each other [rad] are one.
_SAME = 1e-7
# Steps over a family of HipYawPitch.
_STEPS = 120


@both_ways
def split_turns(legs: Legs, target: Row, selection: Selection, work: Workspace) -> int:
    """The best of what meets ankles and normals, where `solve_legs` has found nothing; see `ranges`.

    Returns:
        How many solutions there are after all: members of a family, or feet that are met inside the limits only.
    """
    q, report = work.q, work.report
    gap = separate_legs(legs, target, selection, work)
    if report[REASON] == OUT_OF_REACH:
        return 0
    reason = report[REASON], report[JOINT], report[NEEDED], report[LIMIT], report[BLAMED]
    tasks = tasks_of(legs, target, report)[1]
    count = _over_pieces(tasks, target[PRIORITY], selection, work)
    if count > 0:
        for j in range(JOINTS):
            q[j] = work.found[j]
        report_feet(tasks, q, report)
        reason = REACHED, -1.0, 0.0, 0.0, NEITHER
    elif reason[4] == NEITHER:
        reason = _HIPS_DISAGREE, -1.0, gap, 0.0, NEITHER
    report[REASON], report[JOINT], report[NEEDED], report[LIMIT], report[BLAMED] = reason
    return count


@both_ways
def separate_legs(legs: Legs, target: Row, selection: Selection, work: Workspace) -> float:
    """Report the leg that does not reach its own target; returns how far the hips are apart where both do."""
    row = OF_ONE + EXTRAS
    reference, enforce = selection.reference, selection.enforce
    q, found, report = work.q, work.found, work.report
    left, right, gap = 0, 0, math.inf
    one, other = 0.0, 0.0
    reason = NOT_CONVERGED, -1.0, 0.0, 0.0
    q[OF_ONE] = reference[0]
    for side in range(2):
        for j in range(1, OF_ONE):
            q[OF_ONE + j] = reference[j if side == 0 else OF_ONE - 1 + j]
        leg, limits, first = (
            (legs.left, selection.ranges.left, LEFT) if side == 0 else (legs.right, selection.ranges.right, RIGHT)
        )
        own = Selection(limits, q[OF_ONE : 2 * OF_ONE], enforce)
        count = solve_leg(leg, target[first : first + 16], own, Workspace(q[:OF_ONE], found, report))
        if side == 0:
            # A foot is exact at two values of HipYawPitch, or in a family at more.
            left, one, other = count, found[0], found[0]
            for k in range(1, left):
                other = found[k * row] if abs(found[k * row] - one) > abs(other - one) else other
            reason = report[REASON], report[JOINT], report[NEEDED], report[LIMIT]
        else:
            right = count
    for k in range(right):
        for hip in (one, other):
            off = hip - found[k * row]
            gap = min(gap, abs(off if enforce else turned_towards(off, 0.0)))
    report[POSITION_ERROR], report[ANGLE_ERROR] = math.nan, math.nan
    for j in range(BEST, BEST + JOINTS + MORE):
        report[j] = math.nan
    report[MOVED] = 0.0
    # Of two legs that do not reach, one that is too short is named first.
    if left == 0 and (right > 0 or report[REASON] != OUT_OF_REACH or reason[0] == OUT_OF_REACH):
        report[BLAMED] = LEFT_LEG
        report[REASON], report[JOINT], report[NEEDED], report[LIMIT] = reason
    elif right == 0:
        report[BLAMED] = RIGHT_LEG
        if report[JOINT] > 0.0:
            report[JOINT] += OF_ONE - 1.0
    else:
        report[BLAMED] = NEITHER
        report[REASON], report[JOINT], report[NEEDED], report[LIMIT] = NOT_CONVERGED, -1.0, 0.0, 0.0
    return gap


@both_ways
def _over_pieces(tasks: Tasks, priority: float, selection: Selection, work: Workspace) -> int:
    """Report the least turns of the feet; where they are none, add solutions."""
    q, (left, right) = work.q, tasks
    lefts, rights = np.empty((MOST_PIECES, PIECE)), np.empty((MOST_PIECES, PIECE))
    left_count = write_pieces(left, selection.ranges.left, selection.enforce, lefts)
    right_count = write_pieces(right, selection.ranges.right, selection.enforce, rights)
    level = slope(left.yaw) < LEVEL and slope(right.yaw) < LEVEL
    family = _family_of(left.foot) if level else _ALONE
    hips = np.empty(MOST_VALUES)
    count, best, away = 0, (math.inf, math.inf), math.inf
    for i in range(left_count):
        for j in range(right_count):
            low, high = max(lefts[i, FROM], rights[j, FROM]), min(lefts[i, TO], rights[j, TO])
            if low > high + _MEET:
                continue
            high = max(low, high)
            yaws = _signed(left.yaw, lefts[i, SIGN]), _signed(right.yaw, rights[j, SIGN])
            given = tasks, lefts[i], rights[j], selection, q
            if level:
                # HipYawPitch matters to neither foot: its value that is nearest to the reference.
                wanted = selection.reference[0]
                if not selection.enforce:
                    low, high = wanted - math.pi, wanted + math.pi
                hip = least(_nearest_branches, given, low, high, wanted, _STEPS)
            else:
                hip = least_turns(yaws, priority, low, high, hips)
            cost = cost_of(yaws, priority, hip)
            if is_more(cost, best):
                continue
            near = _nearest_branches(given, hip)
            if near == math.inf:
                continue
            if max(cost[0], cost[1]) < _NEARLY:
                count = _add_if_met(tasks, family, selection, work, count)
            if is_more(best, cost) or near < away:
                best, away = cost, near
                report_feet(tasks, q, work.report)
    return count


@both_ways
def _signed(yaw: FootYaw, sign: float) -> FootYaw:
    return FootYaw(sign * yaw.x_cos, sign * yaw.x_sin, sign * yaw.y_cos, sign * yaw.y_sin)


@both_ways
def _add_if_met(tasks: Tasks, family: float, selection: Selection, work: Workspace, count: int) -> int:
    """Add joint values that meet both feet, unless they are there."""
    q, width = work.q, JOINTS + EXTRAS
    for k in range(count):
        off = 0.0
        for j in range(JOINTS):
            off = max(off, abs(turned_towards(work.found[k * width + j] - q[j], 0.0)))
        if off < _SAME:
            return count
    if count == MOST_BRANCHES:
        return count
    one, two = errors_of_feet(tasks, q)
    return add_branch(selection, work, (max(one[0], two[0]), max(one[1], two[1])), family, count)


@both_ways
def _family_of(foot: Pose) -> float:
    """The family of a leg whose foot does not turn with HipYawPitch: the one that is nearer."""
    y = foot.x * foot.r01 + foot.y * foot.r11 + foot.z * foot.r21
    n = foot.x * foot.r02 + foot.y * foot.r12 + foot.z * foot.r22
    return _ANKLE_AXIS if y * y + n * n <= foot.y * foot.y else _HIP_LOCK


@both_ways
def _nearest_branches(given: tuple[Tasks, Floats, Floats, Selection, Row], hip: float) -> float:
    """Write the joints with this HipYawPitch of the branches of two pieces that are nearest to the reference.

    Returns:
        The squared distance; infinity where none is inside the limits.
    """
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
    """The joints of one leg, and the squared distance of five of them to the reference's."""
    if piece[WAY] != 0.0:
        q = level_joints(task, Branch(piece[KNEE], piece[WAY], piece[ANKLE]), hip)
        inside = not enforce or is_inside(ranges, q)
        return squared_distance(q[1:], reference, enforce) if inside else math.inf, q
    best, nearest = level_joints(task, Branch(task.knee[0], 1.0, -piece[SIGN]), hip), math.inf
    for branch in range(2 * task.knee[1]):
        way = 1.0 if branch % 2 == 0 else -1.0
        q = level_joints(task, Branch(task.knee[0] if branch < 2 else -task.knee[0], way, -way * piece[SIGN]), hip)
        away = squared_distance(q[1:], reference, enforce)
        if away < nearest:
            nearest, best = away, q
    return nearest, best
