"""Both legs where no value of HipYawPitch meets both feet: the best of those that the limits leave.

Ankle and normal of both soles stay exact, and of HipYawPitch the value is taken with the least turns ψ of the feet
about their normals, as the priority weighs them; it lies within pieces of both legs. What the target asks of each leg
alone is looked at first, for the reason.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.ik.closed_forms.leg_equations import Foot, Leg, foot_of, knee_of, solve_leg
from nao_kin.ik.closed_forms.legs_equations import (
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
    FootYaw,
    Joints,
    Legs,
    LegsRanges,
    errors_of,
    feet_reported,
    foot_yaw,
    level_joints,
    slope,
    write_joints,
)
from nao_kin.ik.closed_forms.legs_pieces import ANKLE, FROM, KNEE, MOST_PIECES, PIECE, SIGN, TO, WAY, admitted_pieces
from nao_kin.ik.closed_forms.legs_turns import MOST_VALUES, cost_of, is_more, least_turns
from nao_kin.ik.closed_forms.ranges import (
    ANGLE_ERROR,
    BESIDE,
    BEST,
    JOINT,
    LIMIT,
    NEEDED,
    NOT_CONVERGED,
    OUT_OF_REACH,
    POSITION_ERROR,
    REACHED,
    REASON,
    VERIFIED,
    Ranges,
    apart,
    entered,
    is_inside,
    turned_towards,
)
from nao_kin.ik.compiling import Row, both_ways
from nao_kin.ik.results import Family, Reason

_HIPS_DISAGREE = float(Reason.HIPS_DISAGREE)
_ALONE, _HIP_LOCK, _ANKLE_AXIS = float(Family.NONE), float(Family.HIP_LOCK), float(Family.ANKLE_AXIS)
# Pieces that are this far apart [rad] meet.
_MEET = 1e-10
# Turns of the feet [rad] that may be none: verified is the pose.
_NEARLY = 1e-9
# Solutions that are nearer to each other [rad] are one.
_SAME = 1e-7
# A family over HipYawPitch: values that are tried, and halvings of the step after it.
_STEPS, _HALVINGS = 120, 48


class Task(NamedTuple):
    """Both legs and what is asked of them.

    Attributes:
        legs: their geometry.
        ranges: their limits.
        left: the target of the left foot.
        right: that of the right one.
        left_knee: angle of the left knee, and in how many ways it bends.
        right_knee: the same of the right one.
        left_yaw: how the left foot turns with HipYawPitch.
        right_yaw: the same of the right one.
        enforce: whether limits are enforced.
    """

    legs: Legs
    ranges: LegsRanges
    left: Foot
    right: Foot
    left_knee: tuple[float, int]
    right_knee: tuple[float, int]
    left_yaw: FootYaw
    right_yaw: FootYaw
    enforce: bool


@both_ways
def split_turns(
    legs: Legs, ranges: LegsRanges, target: Row, reference: Row, enforce: bool, q: Row, found: Row, report: Row
) -> int:
    """The best of what meets ankles and normals, where `solve_legs` has found nothing; see `ranges`.

    Returns:
        How many solutions there are after all: members of a family, or feet that are met inside the limits only.
    """
    gap = alone(legs, ranges, target, reference, enforce, q, found, report)
    if report[REASON] == OUT_OF_REACH:
        return 0
    reason = report[REASON], report[JOINT], report[NEEDED], report[LIMIT], report[BLAMED]
    left, right = foot_of(legs.left, target[LEFT:RIGHT])[1], foot_of(legs.right, target[RIGHT:PRIORITY])[1]
    knees = knee_of(legs.left, left, report), knee_of(legs.right, right, report)
    task = Task(legs, ranges, left, right, knees[0], knees[1], foot_yaw(left), foot_yaw(right), enforce)
    count = _over_pieces(task, target[PRIORITY], reference, q, found, report)
    if count > 0:
        for j in range(JOINTS):
            q[j] = found[j]
        feet_reported(legs, (left, right), (task.left_yaw, task.right_yaw), q, report)
        reason = REACHED, -1.0, 0.0, 0.0, NEITHER
    elif reason[4] == NEITHER:
        reason = _HIPS_DISAGREE, -1.0, gap, 0.0, NEITHER
    report[REASON], report[JOINT], report[NEEDED], report[LIMIT], report[BLAMED] = reason
    return count


@both_ways
def alone(
    legs: Legs, ranges: LegsRanges, target: Row, reference: Row, enforce: bool, q: Row, found: Row, report: Row
) -> float:
    """Report the leg that does not reach its own target; returns how far the hips are apart where both do."""
    row = OF_ONE + BESIDE
    left, right, gap = 0, 0, math.inf
    one, other = 0.0, 0.0
    reason = NOT_CONVERGED, -1.0, 0.0, 0.0
    q[OF_ONE] = reference[0]
    for side in range(2):
        for j in range(1, OF_ONE):
            q[OF_ONE + j] = reference[j if side == 0 else OF_ONE - 1 + j]
        leg, limits, first = (legs.left, ranges.left, LEFT) if side == 0 else (legs.right, ranges.right, RIGHT)
        count = solve_leg(
            leg, limits, target[first : first + 16], q[OF_ONE : 2 * OF_ONE], enforce, q[:OF_ONE], found, report
        )
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
def _over_pieces(task: Task, priority: float, reference: Row, q: Row, found: Row, report: Row) -> int:
    """Report the least turns of the feet; where they are none, enter solutions."""
    rows = np.empty((2 * MOST_PIECES, PIECE))
    lefts, rights = rows[:MOST_PIECES], rows[MOST_PIECES:]
    left = admitted_pieces(task.legs.left, task.ranges.left, task.left, task.left_knee, task.enforce, lefts)
    right = admitted_pieces(task.legs.right, task.ranges.right, task.right, task.right_knee, task.enforce, rights)
    yaws = task.left_yaw, task.right_yaw
    level = slope(task.left_yaw) < LEVEL and slope(task.right_yaw) < LEVEL
    family = _family_of(task.left) if level else _ALONE
    hips = np.empty(MOST_VALUES)
    count, best, away = 0, (math.inf, math.inf), math.inf
    for i in range(left):
        for j in range(right):
            pieces = lefts[i], rights[j]
            low, high = max(lefts[i, FROM], rights[j, FROM]), min(lefts[i, TO], rights[j, TO])
            if low > high + _MEET:
                continue
            high = max(low, high)
            signs = lefts[i, SIGN], rights[j, SIGN]
            if level:
                hip = _nearest_hip(task, pieces, low, high, reference, q)
            else:
                hip = least_turns(yaws, signs, priority, low, high, hips)
            cost = cost_of(yaws, signs, priority, hip)
            if is_more(cost, best):
                continue
            near = _nearest_branches(task, pieces, hip, reference, q)
            if near == math.inf:
                continue
            if max(cost[0], cost[1]) < _NEARLY:
                count = _entered_if_met(task, reference, q, family, found, count)
            if is_more(best, cost) or near < away:
                best, away = cost, near
                feet_reported(task.legs, (task.left, task.right), yaws, q, report)
    return count


@both_ways
def _entered_if_met(task: Task, reference: Row, q: Row, family: float, found: Row, count: int) -> int:
    """Enter joint values that meet both feet, unless they are there."""
    width = JOINTS + BESIDE
    for k in range(count):
        off = 0.0
        for j in range(JOINTS):
            off = max(off, abs(turned_towards(found[k * width + j] - q[j], 0.0)))
        if off < _SAME:
            return count
    one = errors_of(task.legs.left, task.left, (q[0], q[1], q[2], q[3], q[4], q[5]))
    two = errors_of(task.legs.right, task.right, (q[0], q[6], q[7], q[8], q[9], q[10]))
    errors = max(one[0], two[0]), max(one[1], two[1])
    if count == MOST_BRANCHES or errors[0] > VERIFIED or errors[1] > VERIFIED:
        return count
    return entered(reference, q, task.enforce, errors, family, found, count)


@both_ways
def _family_of(foot: Foot) -> float:
    """The family of a leg whose foot does not turn with HipYawPitch: the one that is nearer."""
    y = foot.x * foot.f01 + foot.y * foot.f11 + foot.z * foot.f21
    n = foot.x * foot.f02 + foot.y * foot.f12 + foot.z * foot.f22
    return _ANKLE_AXIS if y * y + n * n <= foot.y * foot.y else _HIP_LOCK


@both_ways
def _nearest_hip(task: Task, pieces: tuple[Floats, Floats], low: float, high: float, reference: Row, q: Row) -> float:
    """Where HipYawPitch matters to neither foot: its value within [low, high] that is nearest to the reference."""
    if not task.enforce:
        low, high = reference[0] - math.pi, reference[0] + math.pi
    step = (high - low) / _STEPS
    nearest, best = math.inf, low
    # The reference's own value is tried too.
    for k in range(-1, _STEPS + 1):
        hip = min(max(reference[0], low), high) if k < 0 else low + step * k
        away = _nearest_branches(task, pieces, hip, reference, q)
        if away < nearest:
            nearest, best = away, hip
    for _ in range(_HALVINGS):
        for hip in (max(low, best - step), min(high, best + step)):
            away = _nearest_branches(task, pieces, hip, reference, q)
            if away < nearest:
                nearest, best = away, hip
        step *= 0.5
    return best


@both_ways
def _nearest_branches(task: Task, pieces: tuple[Floats, Floats], hip: float, reference: Row, q: Row) -> float:
    """Write the joints with this HipYawPitch of the branches of two pieces that are nearest to the reference.

    Returns:
        The squared distance; infinity where none is inside the limits.
    """
    legs, ranges = task.legs, task.ranges
    away, left = _nearest_branch(
        legs.left, ranges.left, task.left, task.left_knee, pieces[0], hip, reference, 1, task.enforce
    )
    far, right = _nearest_branch(
        legs.right, ranges.right, task.right, task.right_knee, pieces[1], hip, reference, OF_ONE, task.enforce
    )
    write_joints(left, right, q)
    off = apart(hip, reference[0], task.enforce)
    return away + far + off * off


@both_ways
def _nearest_branch(
    leg: Leg,
    ranges: Ranges,
    foot: Foot,
    knee: tuple[float, int],
    piece: Floats,
    hip: float,
    reference: Row,
    first: int,
    enforce: bool,
) -> tuple[float, Joints]:
    """The joints of one leg, and the squared distance of five of them to the reference's, from `first` on."""
    if piece[WAY] != 0.0:
        q = level_joints(leg, foot, hip, piece[KNEE], piece[WAY], piece[ANKLE])
        return math.inf if enforce and not is_inside(ranges, q) else _apart(q, reference, first, enforce), q
    best = level_joints(leg, foot, hip, knee[0], 1.0, -piece[SIGN])
    nearest = _apart(best, reference, first, enforce)
    for branch in range(1, 2 * knee[1]):
        way = 1.0 if branch % 2 == 0 else -1.0
        q = level_joints(leg, foot, hip, knee[0] if branch < 2 else -knee[0], way, -way * piece[SIGN])
        away = _apart(q, reference, first, enforce)
        if away < nearest:
            nearest, best = away, q
    return nearest, best


@both_ways
def _apart(q: Joints, reference: Row, first: int, enforce: bool) -> float:
    total: float = 0.0
    for j in range(1, OF_ONE):
        off = apart(q[j], reference[first + j - 1], enforce)
        total += off * off
    return total
