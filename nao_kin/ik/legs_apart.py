"""Both legs where no value of HipYawPitch meets both feet: the best of those that the limits leave."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._kernels.cache import both_ways
from nao_kin.ik.compiling import Row
from nao_kin.ik.leg import Foot, Leg, foot_of, knee_of, solve_leg
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
    FootYaw,
    Joints,
    Legs,
    LegsRanges,
    errors_of,
    feet_reported,
    foot_yaw,
    hip_of,
    level_joints,
    slope,
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
    VERIFIED,
    Ranges,
    apart,
    entered,
    is_inside,
    is_outside,
    table_range,
    turned_towards,
    wrapped,
)
from nao_kin.ik.results import Family, Reason

# --- The values of HipYawPitch that the limits of a leg leave, where its ankle and the normal of its sole are given.
#
# For each branch of a leg (knee, way of HipRoll, way of the ankle) they are a few pieces. Where a joint is at its
# limit is a root of a linear or quadratic form in (cos q₁, sin q₁), with every digit; only where AnkleRoll is at a
# limit that AnklePitch leaves it, it is bracketed.

# Pieces of all branches of a leg together, and ends of the pieces of one branch, before and after the table.
MOST_PIECES, _MOST_ENDS = 128, 384
# Places in a piece: its ends, the sign of ψ's branch, the knee, the ways of HipRoll and of the ankle (0 for any).
FROM, TO, SIGN, KNEE, WAY, ANKLE, PIECE = range(7)
# Values of HipYawPitch that a table is looked at between two bends, and halvings of a bracket.
_LOOKS, _BRACKET_HALVINGS = 8, 60
# The golden section.
_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


@both_ways
def admitted_pieces(
    leg: Leg, ranges: Ranges, foot: Foot, knee: tuple[float, int], enforce: bool, pieces: Floats
) -> int:
    """Write the pieces of HipYawPitch with which ankle and normal are met inside the limits; their number."""
    count = 0
    if not enforce:
        for sign in (-1.0, 1.0):
            count = _add_piece(pieces, count, -math.pi, math.pi, sign, knee[0], 0.0, 0.0)
        return count
    ends = np.empty(_MOST_ENDS)
    for bend in range(knee[1]):
        bent = knee[0] if bend == 0 else -knee[0]
        if is_outside(ranges, 3, bent):
            continue
        boxes = _ends_of_boxes(leg, ranges, foot, bent, ends)
        for branch in range(4):
            way, ankle = 1.0 if branch < 2 else -1.0, 1.0 if branch % 2 == 0 else -1.0
            every = _ends_of_table(leg, ranges, foot, bent, way, ankle, ends, boxes)
            count = _pieces_of_branch(leg, ranges, foot, (bent, way, ankle), ends[boxes : boxes + every], pieces, count)
    return count


@both_ways
def _add_piece(
    pieces: Floats, count: int, low: float, high: float, sign: float, knee: float, way: float, ankle: float
) -> int:
    if count < len(pieces):
        row = pieces[count]
        row[FROM], row[TO], row[SIGN], row[KNEE], row[WAY], row[ANKLE] = low, high, sign, knee, way, ankle
        count += 1
    return count


@both_ways
def _pieces_of_branch(
    leg: Leg,
    ranges: Ranges,
    foot: Foot,
    branch: tuple[float, float, float],
    ends: Floats,
    pieces: Floats,
    count: int,
) -> int:
    """Join what is inside between ends, and ends that are inside by themselves."""
    knee, way, ankle = branch
    sign, joined, begin = -way * ankle, False, 0.0
    for i in range(len(ends)):
        after = False
        if i + 1 < len(ends):
            after = is_inside(ranges, level_joints(leg, foot, 0.5 * (ends[i] + ends[i + 1]), knee, way, ankle))
        if joined and not after:
            count = _add_piece(pieces, count, begin, ends[i], sign, knee, way, ankle)
        elif after and not joined:
            begin = ends[i]
        elif not joined and is_inside(ranges, level_joints(leg, foot, ends[i], knee, way, ankle)):
            count = _add_piece(pieces, count, ends[i], ends[i], sign, knee, way, ankle)
        joined = after
    return count


# --- where joints are at their limits ---------------------------------------------------------------------------------


@both_ways
def _ends_of_boxes(leg: Leg, ranges: Ranges, foot: Foot, knee: float, ends: Floats) -> int:
    """Sorted, all values of HipYawPitch inside its range that may put a joint at a limit or at a bend of the table."""
    low, high = ranges.lower[0], ranges.upper[0]
    ends[0], ends[1], count = low, high, 2
    x, y, z = foot.x, foot.y, foot.z
    n0, n1, n2 = foot.f02, foot.f12, foot.f22
    square, up = x * x + y * y + z * z, x * n0 + y * n1 + z * n2
    # HipRoll: y cos ρ + z' sin ρ = 0.
    for side in range(2):
        rho = (ranges.lower[1] if side == 0 else ranges.upper[1]) - leg.kappa
        count = _linear(z * math.sin(rho), x * math.sin(rho), -y * math.cos(rho), low, high, ends, count)
    # HipPitch: the ankle's x after HipYawPitch.
    vx, vz = -leg.tibia * math.sin(knee), -leg.thigh - leg.tibia * math.cos(knee)
    for side in range(2):
        pitch = ranges.lower[2] if side == 0 else ranges.upper[2]
        count = _linear(x, -z, vx * math.cos(pitch) + vz * math.sin(pitch), low, high, ends, count)
    # AnkleRoll: (n · (p × e))² = sin² q₆ |p × e|².
    w0, w2 = n1 * z - n2 * y, n0 * y - n1 * x
    for side in range(2):
        sine = math.sin(ranges.lower[5] if side == 0 else ranges.upper[5])
        part = sine * sine
        count = _quadratic(
            w0 * w0 - part * (square - x * x),
            -2.0 * (w0 * w2 + part * x * z),
            w2 * w2 - part * (square - z * z),
            low, high, ends, count,
        )  # fmt: skip
    # AnklePitch: (u · p)² = h_x² |u|², with the hip at h_x along the foot.
    g0, g2 = up * x - square * n0, up * z - square * n2
    u00 = up * up - 2.0 * up * x * n0 + square * n0 * n0
    u02 = 2.0 * (up * (x * n2 + z * n0) - square * n0 * n2)
    u22 = up * up - 2.0 * up * z * n2 + square * n2 * n2
    bx, bz = -leg.thigh * math.sin(knee), leg.tibia + leg.thigh * math.cos(knee)
    for k in range(ranges.bends + 2):
        pitch = ranges.at[k] if k < ranges.bends else (ranges.lower if k == ranges.bends else ranges.upper)[4]
        along = bx * math.cos(pitch) - bz * math.sin(pitch)
        part = along * along
        count = _quadratic(
            g0 * g0 - part * u00, -2.0 * g0 * g2 - part * u02, g2 * g2 - part * u22, low, high, ends, count
        )
    ends[:count] = np.sort(ends[:count])
    return count


@both_ways
def _linear(cosine: float, sine: float, value: float, low: float, high: float, ends: Floats, count: int) -> int:
    """Enter the q₁ between two values with cosine · cos q₁ + sine · sin q₁ = value."""
    size = math.sqrt(cosine * cosine + sine * sine)
    if size > 0.0 and abs(value) <= size * (1.0 + 1e-14):
        middle, half = math.atan2(sine, cosine), math.acos(min(1.0, max(-1.0, value / size)))
        for q in (middle - half, middle + half):
            count = _enter(wrapped(q), low, high, ends, count)
    return count


@both_ways
def _quadratic(a: float, b: float, c: float, low: float, high: float, ends: Floats, count: int) -> int:
    """Enter the q₁ between two values with a cos² q₁ + b cos q₁ sin q₁ + c sin² q₁ = 0."""
    size = math.sqrt((a - c) * (a - c) + b * b)
    # A double root, by rounding none, is one.
    if size > 0.0 and abs(a + c) <= size * (1.0 + 1e-14):
        middle, half = math.atan2(b, a - c), math.acos(min(1.0, max(-1.0, -(a + c) / size)))
        for q in (0.5 * (middle - half), 0.5 * (middle + half)):
            count = _enter(wrapped(q), low, high, ends, count)
            count = _enter(wrapped(q + math.pi), low, high, ends, count)
    return count


@both_ways
def _enter(q: float, low: float, high: float, ends: Floats, count: int) -> int:
    if low < q < high and count < len(ends):
        ends[count] = q
        count += 1
    return count


@both_ways
def _ends_of_table(
    leg: Leg, ranges: Ranges, foot: Foot, knee: float, way: float, ankle: float, ends: Floats, boxes: int
) -> int:
    """Behind the ends of boxes, the same with those where AnkleRoll meets its coupled limit, sorted; their number."""
    count = boxes
    for i in range(boxes):
        if count < len(ends):
            ends[count] = ends[i]
            count += 1
    if ranges.bends == 0:
        return count - boxes
    for i in range(boxes - 1):
        low, high = ends[i], ends[i + 1]
        q = level_joints(leg, foot, 0.5 * (low + high), knee, way, ankle)
        if is_outside(ranges, 1, q[1]) or is_outside(ranges, 2, q[2]) or is_outside(ranges, 4, q[4]):
            continue
        for side in range(2):
            count = _crossings(leg, ranges, foot, (knee, way, ankle), side, low, high, ends, count)
    ends[boxes:count] = np.sort(ends[boxes:count])
    return count - boxes


@both_ways
def _crossings(
    leg: Leg,
    ranges: Ranges,
    foot: Foot,
    branch: tuple[float, float, float],
    side: int,
    low: float,
    high: float,
    ends: Floats,
    count: int,
) -> int:
    """Enter where AnkleRoll meets one side of the table between two values of HipYawPitch, touching included."""
    step = (high - low) / _LOOKS
    here = _beyond(leg, ranges, foot, branch, side, low)
    before = here
    for i in range(_LOOKS + 1):
        at = low + step * i
        after = _beyond(leg, ranges, foot, branch, side, at + step) if i < _LOOKS else here
        if (here > 0.0) != (after > 0.0):
            count = _enter(_root(leg, ranges, foot, branch, side, at, at + step, here > 0.0), low, high, ends, count)
        # Where a value is nearer to the limit than those beside it, the limit may be touched, or passed twice.
        elif (
            (here > 0.0) == (before > 0.0)
            and abs(here) <= min(abs(before), abs(after))
            and abs(here) <= abs(before - here) + abs(after - here)
        ):
            left, right = max(low, at - step), min(high, at + step)
            peak = _nearest(leg, ranges, foot, branch, side, left, right, here > 0.0)
            if (_beyond(leg, ranges, foot, branch, side, peak) > 0.0) != (here > 0.0):
                one = _root(leg, ranges, foot, branch, side, left, peak, here > 0.0)
                two = _root(leg, ranges, foot, branch, side, peak, right, here <= 0.0)
                count = _enter(two, low, high, ends, _enter(one, low, high, ends, count))
            count = _enter(peak, low, high, ends, count)
        before, here = here, after
    return count


@both_ways
def _beyond(leg: Leg, ranges: Ranges, foot: Foot, branch: tuple[float, float, float], side: int, hip: float) -> float:
    """How far AnkleRoll is beyond one side of its coupled limit."""
    q = level_joints(leg, foot, hip, branch[0], branch[1], branch[2])
    low, high = table_range(ranges, q[4])
    return low - q[5] if side == 0 else q[5] - high


@both_ways
def _root(
    leg: Leg,
    ranges: Ranges,
    foot: Foot,
    branch: tuple[float, float, float],
    side: int,
    low: float,
    high: float,
    falls: bool,
) -> float:
    """Where the limit is passed, bracketed."""
    for _ in range(_BRACKET_HALVINGS):
        middle = 0.5 * (low + high)
        if (_beyond(leg, ranges, foot, branch, side, middle) > 0.0) == falls:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@both_ways
def _nearest(
    leg: Leg,
    ranges: Ranges,
    foot: Foot,
    branch: tuple[float, float, float],
    side: int,
    low: float,
    high: float,
    beyond: bool,
) -> float:
    """Where AnkleRoll is least beyond its limit, or least inside of it, by golden sections."""
    sign = 1.0 if beyond else -1.0
    one, two = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    first = sign * _beyond(leg, ranges, foot, branch, side, one)
    second = sign * _beyond(leg, ranges, foot, branch, side, two)
    for _ in range(_BRACKET_HALVINGS):
        if first <= second:
            high, two, second = two, one, first
            one = high - _GOLDEN * (high - low)
            first = sign * _beyond(leg, ranges, foot, branch, side, one)
        else:
            low, one, first = one, two, second
            two = low + _GOLDEN * (high - low)
            second = sign * _beyond(leg, ranges, foot, branch, side, two)
    return 0.5 * (low + high)


# --- The least turns ψ of both feet about their normals, between two values of HipYawPitch.
#
# They are at an end, at a root of ψ, or where ψ ψ' of both feet are opposite: the last are bracketed between values
# that are spaced evenly in q₁ and in ψ of either foot, so that none is steep between two of them.

# Priorities, as a number in a target.
BALANCED, LEFT_FIRST, RIGHT_FIRST = 0.0, 1.0, 2.0
# Turns of the feet [rad] that differ by less are equal.
EQUAL = 1e-11
# Values of HipYawPitch between two ends, evenly in q₁ and in ψ of each foot, and how many that makes at most.
_EVENLY = 24
MOST_VALUES = 5 * _EVENLY + 6
_TURN_HALVINGS = 60


@both_ways
def is_more(cost: tuple[float, float], than: tuple[float, float]) -> bool:
    """Whether turns of the feet are worse than others: the first, or where these are equal the second."""
    if abs(cost[0] - than[0]) > EQUAL:
        return cost[0] > than[0]
    return cost[1] > than[1] + EQUAL


@both_ways
def cost_of(
    yaws: tuple[FootYaw, FootYaw], signs: tuple[float, float], priority: float, hip: float
) -> tuple[float, float]:
    """The turns of the feet as they are compared: both together, or the preferred first."""
    left, right = abs(_turn(yaws[0], signs[0], hip)[0]), abs(_turn(yaws[1], signs[1], hip)[0])
    if priority == LEFT_FIRST:
        return left, right
    if priority == RIGHT_FIRST:
        return right, left
    return math.sqrt(left * left + right * right), 0.0


@both_ways
def least_turns(
    yaws: tuple[FootYaw, FootYaw],
    signs: tuple[float, float],
    priority: float,
    low: float,
    high: float,
    hips: Floats,
) -> float:
    """The value of HipYawPitch within [low, high] with the least turns; `hips` has room for `MOST_VALUES`."""
    best, cost = low, cost_of(yaws, signs, priority, low)
    hips[0] = high
    count = 1
    for foot in range(2):
        for half in range(2):
            hip = wrapped(hip_of(yaws[foot]) + math.pi * half)
            if low < hip < high:
                hips[count] = hip
                count += 1
    for k in range(count):
        other = cost_of(yaws, signs, priority, hips[k])
        if is_more(cost, other):
            best, cost = hips[k], other
    if priority != BALANCED or low == high:
        return best
    hips[count] = low
    count += 1
    for k in range(1, _EVENLY):
        hips[count] = low + (high - low) * k / _EVENLY
        count += 1
    for foot in range(2):
        count = _evenly_turned(yaws[foot], signs[foot], low, high, hips, count)
    hips[:count] = np.sort(hips[:count])
    growth = _growth(yaws, signs, low)
    for k in range(1, count):
        grows = _growth(yaws, signs, hips[k])
        if growth < 0.0 <= grows:
            hip = _lowest(yaws, signs, hips[k - 1], hips[k])
            other = cost_of(yaws, signs, priority, hip)
            if other[0] < cost[0]:
                best, cost = hip, other
        growth = grows
    return best


@both_ways
def _turn(yaw: FootYaw, sign: float, hip: float) -> tuple[float, float]:
    """ψ of a branch, and its slope ψ'."""
    c, s = math.cos(hip), math.sin(hip)
    x, y = sign * (yaw.x_cos * c + yaw.x_sin * s), sign * (yaw.y_cos * c + yaw.y_sin * s)
    square = x * x + y * y
    return math.atan2(y, x), (yaw.x_cos * yaw.y_sin - yaw.x_sin * yaw.y_cos) / square if square > 0.0 else 0.0


@both_ways
def _growth(yaws: tuple[FootYaw, FootYaw], signs: tuple[float, float], hip: float) -> float:
    """Half the derivative of the sum of the squares of both turns."""
    left, right = _turn(yaws[0], signs[0], hip), _turn(yaws[1], signs[1], hip)
    return left[0] * left[1] + right[0] * right[1]


@both_ways
def _lowest(yaws: tuple[FootYaw, FootYaw], signs: tuple[float, float], low: float, high: float) -> float:
    """Where the sum of squares is least between two values between which it falls and rises."""
    for _ in range(_TURN_HALVINGS):
        middle = 0.5 * (low + high)
        if _growth(yaws, signs, middle) < 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@both_ways
def _evenly_turned(yaw: FootYaw, sign: float, low: float, high: float, hips: Floats, count: int) -> int:
    """Enter values of HipYawPitch between which a foot turns evenly."""
    first, last = _turn(yaw, sign, low)[0], _turn(yaw, sign, high)[0]
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
        for half in range(2):
            hip = wrapped(hip + math.pi * half)
            if low < hip < high:
                hips[count] = hip
                count += 1
    return count


# --- Both legs where no value of HipYawPitch meets both feet: the best of those that the limits leave.
#
# Ankle and normal of both soles stay exact, and of HipYawPitch the value is taken with the least turns ψ of the feet
# about their normals, as the priority weighs them; it lies within pieces of both legs. What the target asks of each
# leg alone is looked at first, for the reason.

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
    row = OF_ONE + EXTRAS
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
    width = JOINTS + EXTRAS
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
