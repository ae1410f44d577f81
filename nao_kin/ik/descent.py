"""Damped least squares for a pose of one frame or of several, scalar code for one start after the other.

With the target (R_t, p_t) and the pose (R, p) of each frame, ½‖e‖² is made small for e = w · (R_tᵀ (p_t − p);
log(Rᵀ R_t)), whose derivative is exact: ∂e/∂q = −w · (R_tᵀ J_v; J_l⁻¹(log(Rᵀ R_t)) Rᵀ J_ω).

A step solves (JᵀJ + λ 1) δ = −Jᵀe for the directions that the limits leave open, with λ in proportion to ‖e‖²
(quadratic convergence also where J is singular), is shortened to 1 rad, and projected onto the limits. λ follows the
ratio of the decrease found to the one the linear model promised.

Source: Sugihara, Solvability-unconcerned inverse kinematics by the Levenberg–Marquardt method, IEEE T-RO 2011; Nielsen,
Damping parameter in Marquardt's method, IMM-REP-1999-05; Barfoot, State Estimation for Robotics, 7.1.5 (J_l⁻¹).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from nao_kin._kernels.cache import both_ways
from nao_kin.ik.compiling import Row

# --- Limits of the joints that move a frame, for scalar code: boxes, and plane regions of coupled limits.
#
# The numbers are those of a `LimitRegion`; what is done with them is the same, one configuration after the other.

# Tables that share a joint are obeyed in turn, so often at most.
MOST_TURNS = 20
# Directions are probed by a step of this length [rad or m]: far above rounding, far below the bends of a table.
PROBE = 1e-6
# Numbers of a table: the places of the joint that is depended on and of the one that depends, −1 for one that does not
# move; the first of its bends, and the one behind the last.
TABLE = 4


class Region(NamedTuple):
    """Where m joints may be.

    Attributes:
        lower: smallest values, m numbers.
        upper: largest values.
        winding: 1 for a joint that turns without limits and is the same after a whole turn.
        tables: four whole numbers for each coupled limit.
        at: bends of all tables: values of the joint that is depended on.
        low: smallest value of the other one there, inside its box.
        high: largest value there.
        shared: whether two tables share a joint.
    """

    lower: Row
    upper: Row
    winding: Row
    tables: Row
    at: Row
    low: Row
    high: Row
    shared: bool


@both_ways
def project(region: Region, values: Row, still: Row, inside: Row) -> None:
    """The nearest values inside the limits; `still` has for each table the value of its joint that does not move."""
    for j in range(len(region.lower)):
        inside[j] = min(max(values[j], region.lower[j]), region.upper[j])
    count = len(region.tables) // TABLE
    # What a plane's nearest point is asked for are the values as given: clipping them first would move the point.
    for t in range(count):
        of, joint = region.tables[TABLE * t], region.tables[TABLE * t + 1]
        if of >= 0 and joint >= 0:
            inside[of], inside[joint] = nearest_point(region, t, values[of], values[joint])
    for t in range(count):
        if region.tables[TABLE * t] < 0 or region.tables[TABLE * t + 1] < 0:
            obey(region, t, still, inside)
    if region.shared:
        for _ in range(MOST_TURNS):
            changed = False
            for t in range(count):
                changed = obey(region, t, still, inside) or changed
            if not changed:
                break


@both_ways
def obey(region: Region, t: int, still: Row, values: Row) -> bool:
    """Take the moving joints of a table into its region; whether that changed them."""
    of, joint = region.tables[TABLE * t], region.tables[TABLE * t + 1]
    if of >= 0 and joint >= 0:
        x, y = nearest_point(region, t, values[of], values[joint])
        changed = bool(x != values[of] or y != values[joint])
        values[of], values[joint] = x, y
        return changed
    if joint >= 0:
        low, high = range_at(region, t, still[t])
        y = min(max(values[joint], low), high)
        changed = bool(y != values[joint])
        values[joint] = y
        return changed
    x = nearest_of(region, t, values[of], still[t])
    changed = bool(x != values[of])
    values[of] = x
    return changed


@both_ways
def range_at(region: Region, t: int, of: float) -> tuple[float, float]:
    """Smallest and largest value of the joint of a table where the other is at `of`; constant outside the table."""
    first, last = region.tables[TABLE * t + 2], region.tables[TABLE * t + 3] - 1
    if of <= region.at[first]:
        return region.low[first], region.high[first]
    if of >= region.at[last]:
        return region.low[last], region.high[last]
    right = first + 1
    while region.at[right] < of:
        right += 1
    left = right - 1
    share = (of - region.at[left]) / (region.at[right] - region.at[left])
    low = region.low[left] + share * (region.low[right] - region.low[left])
    return low, region.high[left] + share * (region.high[right] - region.high[left])


@both_ways
def nearest_point(region: Region, t: int, of: float, joint: float) -> tuple[float, float]:
    """The nearest point of a plane region: on one of the segments of its boundary, if it is not inside."""
    first, last = region.tables[TABLE * t + 2], region.tables[TABLE * t + 3] - 1
    low, high = range_at(region, t, of)
    if region.at[first] <= of <= region.at[last] and low <= joint <= high:
        return of, joint
    best, x, y = math.inf, of, joint
    for side in range(2):
        bound = region.low if side == 0 else region.high
        for i in range(first, last):
            dx, dy = region.at[i + 1] - region.at[i], bound[i + 1] - bound[i]
            square = dx * dx + dy * dy
            share = ((of - region.at[i]) * dx + (joint - bound[i]) * dy) / square if square > 0.0 else 0.0
            share = min(max(share, 0.0), 1.0)
            foot_x, foot_y = region.at[i] + share * dx, bound[i] + share * dy
            away = (of - foot_x) * (of - foot_x) + (joint - foot_y) * (joint - foot_y)
            if away < best:
                best, x, y = away, foot_x, foot_y
    for side in range(2):
        i = first if side == 0 else last
        foot = min(max(joint, region.low[i]), region.high[i])
        away = (of - region.at[i]) * (of - region.at[i]) + (joint - foot) * (joint - foot)
        if away < best:
            best, x, y = away, region.at[i], foot
    # The foot of a perpendicular lies on the boundary to rounding; the last bit is clipped away.
    low, high = range_at(region, t, x)
    return x, min(max(y, low), high)


@both_ways
def nearest_of(region: Region, t: int, of: float, joint: float) -> float:
    """The nearest value of the joint that is depended on at which the other may be at `joint`; `of` if there is none.

    Between two bends the allowed values are an interval, given by two linear inequalities.
    """
    first, last = region.tables[TABLE * t + 2], region.tables[TABLE * t + 3] - 1
    best, found = math.inf, of
    for i in range(first, last):
        start, end = 0.0, 1.0
        for side in range(2):
            # sign · (joint − bound) ≥ 0 with bound = left + share · rise.
            sign = 1.0 if side == 0 else -1.0
            left, right = (region.low[i], region.low[i + 1]) if side == 0 else (region.high[i], region.high[i + 1])
            rise, room = sign * (right - left), sign * (joint - left)
            if rise > 0.0:
                end = min(end, room / rise)
            elif rise < 0.0:
                start = max(start, room / rise)
            elif room < 0.0:
                end = -1.0
        if start <= end:
            width = region.at[i + 1] - region.at[i]
            value = min(max(of, region.at[i] + start * width), region.at[i] + end * width)
            if abs(value - of) < best:
                best, found = abs(value - of), value
    return found


@both_ways
def open_directions(
    region: Region, values: Row, still: Row, wanted: Row, ahead: Row, inside: Row, is_open: Row, along: Row
) -> bool:
    """Along which directions a step may go that wants to go along `wanted`; whether all are open.

    A joint held at its limit is not (`is_open` 0); of two joints at the edge of their plane region only the direction
    along the edge is, which `along` has for each table, (2, 0) where the two are free.
    """
    count, width = len(region.tables) // TABLE, len(region.lower)
    for j in range(width):
        ahead[j] = 1.0 if wanted[j] > 0.0 else -1.0 if wanted[j] < 0.0 else 0.0
    for t in range(count):
        of, joint = region.tables[TABLE * t], region.tables[TABLE * t + 1]
        along[2 * t], along[2 * t + 1] = 2.0, 0.0
        if of >= 0 and joint >= 0:
            length = math.sqrt(wanted[of] * wanted[of] + wanted[joint] * wanted[joint])
            if length > 0.0:
                ahead[of], ahead[joint] = wanted[of] / length, wanted[joint] / length
    for j in range(width):
        ahead[j] = values[j] + PROBE * ahead[j]
    project(region, ahead, still, inside)
    everything = True
    for j in range(width):
        free = abs(inside[j] - values[j]) >= 0.5 * PROBE or ahead[j] == values[j]
        is_open[j] = 1.0 if free else 0.0
        everything = everything and bool(inside[j] == ahead[j])
    if everything:
        return True
    for t in range(count):
        of, joint = region.tables[TABLE * t], region.tables[TABLE * t + 1]
        if of >= 0 and joint >= 0:
            is_open[of], is_open[joint] = 1.0, 1.0
            x, y = (inside[of] - values[of]) / PROBE, (inside[joint] - values[joint]) / PROBE
            off = max(abs(inside[of] - ahead[of]), abs(inside[joint] - ahead[joint])) / PROBE
            if off > 1e-3:
                length = math.sqrt(x * x + y * y)
                along[2 * t] = x / length if length > 1e-3 else 0.0
                along[2 * t + 1] = y / length if length > 1e-3 else 0.0
    return False


# --- Damped least squares for a pose of one frame or of several, scalar code for one start after the other.

# Damping is this share of the squared error at first; it grows where a step fails, and shrinks where one succeeds.
FIRST_DAMPING = 0.1
LEAST_DAMPING, MOST_DAMPING = 1e-6, 1e12
# A step that lessens the error by less than this share of what its linear model promised has failed.
LEAST_GAIN = 1e-3
# No joint moves by more in one step [rad or m]: beyond, the linear model says nothing.
LONGEST_STEP = 1.0
# A slope of this share of the steepest there could be is flat.
FLAT = 1e-7
# Under this angle the closed form of J_l⁻¹ loses digits, and two terms of its series are exact [rad].
SMALL_ANGLE = 1e-2
# A floor against rounding keeps the linear system regular where damping vanishes with the error.
_FLOOR, _TINY = 1e-15, 1e-300

# Places in what is reported of a start: half the squared error, whether the target is met, whether nothing lessens the
# error any more, and the errors in position and angle of what was asked for.
COST, MET, SETTLED, POSITION, ANGLE = range(5)


class Chain(NamedTuple):
    """n joints that m coordinates move, as `SerialChain` has them, from the base to each frame in turn.

    Attributes:
        joints: how many are on the way to each frame.
        links: the placements, one more than joints for each frame, twelve numbers for each, 3×4 by rows.
        slides: 1 for a joint that slides.
        place: which coordinate moves a joint, −1 for none.
        ratio: value of a joint = ratio · coordinate + offset.
        offset: see there.
    """

    joints: Row
    links: Row
    slides: Row
    place: Row
    ratio: Row
    offset: Row


class Goal(NamedTuple):
    """What counts as met.

    Attributes:
        weights: of the six errors of each frame; 0 for what does not matter.
        tolerance: of position and angle [m, rad].
        steps: the most.
    """

    weights: Row
    tolerance: float
    steps: int


class Bench(NamedTuple):
    """Room for what a step computes."""

    T: Row
    axes: Row
    origins: Row
    e: Row
    e_ahead: Row
    turn: Row
    J: Row
    J_ahead: Row
    J_open: Row
    wanted: Row
    ahead: Row
    inside: Row
    is_open: Row
    along: Row
    step: Row
    normal: Row
    right: Row


@both_ways
def room_for(frames: int, joints: int, moving: int, tables: int) -> tuple[int, ...]:
    """How many numbers each part of a `Bench` takes."""
    rows = 6 * frames
    size = min(rows, moving)
    return (
        12, 3 * joints, 3 * joints, rows, rows, 3, rows * moving, rows * moving, rows * moving,
        moving, moving, moving, moving, 2 * max(1, tables), moving, size * size, size,
    )  # fmt: skip


@both_ways
def descend(
    chain: Chain, region: Region, goal: Goal, target: Row, still: Row, values: Row, bench: Bench, report: Row
) -> None:
    """Search from `values`, which are inside the limits, and leave there where it ended."""
    m, rows = len(region.lower), len(bench.e)
    cost = errors_at(chain, goal, target, values, bench, bench.e, bench.J)
    damping, growth, settled = FIRST_DAMPING, 2.0, False
    met = is_met(goal, bench.e)
    for _ in range(goal.steps):
        if met or settled:
            break
        for j in range(m):
            slope = 0.0
            for i in range(rows):
                slope += bench.J[i * m + j] * bench.e[i]
            bench.wanted[j] = -slope
        restrict(region, values, still, bench)
        damped_step(m, 2.0 * damping * cost, bench)
        longest = 0.0
        for j in range(m):
            longest = max(longest, abs(bench.step[j]))
        shorter = max(1.0, longest / LONGEST_STEP)
        for j in range(m):
            bench.ahead[j] = values[j] + bench.step[j] / shorter
        project(region, bench.ahead, still, bench.inside)
        # Where projection has changed the step, the model is asked about what is left of it.
        promised, squares = 0.0, 0.0
        for i in range(rows):
            change = 0.0
            for j in range(m):
                change += bench.J[i * m + j] * (bench.inside[j] - values[j])
                squares += bench.J[i * m + j] * bench.J[i * m + j]
            promised -= bench.e[i] * change + 0.5 * change * change
        # What the open directions could gain is rounding: this is a minimum inside the limits.
        slopes = 0.0
        for j in range(m):
            slope = 0.0
            for i in range(rows):
                slope += bench.J_open[i * m + j] * bench.e[i]
            slopes += slope * slope
        settled = slopes <= FLAT * FLAT * squares * 2.0 * cost
        cost_ahead = errors_at(chain, goal, target, bench.inside, bench, bench.e_ahead, bench.J_ahead)
        gain = (cost - cost_ahead) / promised if promised > 0.0 else 0.0
        if cost_ahead < cost and gain > LEAST_GAIN:
            steeper = 2.0 * min(max(gain, 0.0), 2.0) - 1.0
            damping *= max(1.0 / 3.0, 1.0 - steeper * steeper * steeper)
            growth = 2.0
            for j in range(m):
                values[j] = bench.inside[j]
                if region.winding[j] != 0.0:
                    values[j] -= 2.0 * math.pi * math.floor(values[j] / (2.0 * math.pi) + 0.5)
            for i in range(rows):
                bench.e[i] = bench.e_ahead[i]
            for i in range(rows * m):
                bench.J[i] = bench.J_ahead[i]
            cost = cost_ahead
            met = is_met(goal, bench.e)
        else:
            damping *= growth
            growth *= 2.0
        damping = min(max(damping, LEAST_DAMPING), MOST_DAMPING)
        settled = settled or damping >= MOST_DAMPING
    report[COST], report[MET], report[SETTLED] = cost, 1.0 if met else 0.0, 1.0 if settled else 0.0
    report[POSITION], report[ANGLE] = errors_asked(goal, bench.e)


@both_ways
def is_met(goal: Goal, e: Row) -> bool:
    """Whether weighted errors are small enough."""
    position, angle = errors_asked(goal, e)
    return position <= goal.tolerance and angle <= goal.tolerance


@both_ways
def errors_asked(goal: Goal, e: Row) -> tuple[float, float]:
    """Errors in position and angle of what has a weight [m, rad], from weighted ones."""
    position, angle = 0.0, 0.0
    for first in range(0, len(e), 6):
        for i in range(3):
            if goal.weights[i] != 0.0:
                position += (e[first + i] / goal.weights[i]) * (e[first + i] / goal.weights[i])
            if goal.weights[3 + i] != 0.0:
                angle += (e[first + 3 + i] / goal.weights[3 + i]) * (e[first + 3 + i] / goal.weights[3 + i])
    return math.sqrt(position), math.sqrt(angle)


@both_ways
def errors_at(chain: Chain, goal: Goal, target: Row, values: Row, bench: Bench, e: Row, J: Row) -> float:
    """Weighted errors (6 for each frame) and their derivative (.., m) at joint values; half their square."""
    first, m, cost = 0, len(values), 0.0
    for frame in range(len(chain.joints)):
        last = first + chain.joints[frame]
        to_frame(chain, values, bench, frame, first, last)
        T, at, row = bench.T, 16 * frame, 6 * frame
        dx, dy, dz = target[at + 3] - T[3], target[at + 7] - T[7], target[at + 11] - T[11]
        for i in range(at, at + 3):
            e[row + i - at] = goal.weights[i - at] * (target[i] * dx + target[4 + i] * dy + target[8 + i] * dz)
        turn_left(T, target, at, bench.turn)
        for i in range(3):
            e[row + 3 + i] = goal.weights[3 + i] * bench.turn[i]
        for i in range(row, row + 6):
            cost += 0.5 * e[i] * e[i]
        derivative(chain, goal, target, bench, J, m, frame, first, last)
        first = last
    return cost


@both_ways
def to_frame(chain: Chain, values: Row, bench: Bench, frame: int, first: int, last: int) -> None:
    """The pose of a frame, and axes and origins of the joints on the way to it, onto the bench."""
    T, origins, axes = bench.T, bench.origins, bench.axes
    # Before each frame there is one link more than joints.
    a = 12 * (first + frame)
    for i in range(12):
        T[i] = chain.links[a + i]
    for k in range(first, last):
        value = chain.offset[k]
        if chain.place[k] >= 0:
            value += chain.ratio[k] * values[chain.place[k]]
        for i in range(3):
            axes[3 * k + i], origins[3 * k + i] = T[4 * i + 2], T[4 * i + 3]
        if chain.slides[k] != 0.0:
            for i in range(3):
                T[4 * i + 3] += value * T[4 * i + 2]
        else:
            cosine, sine = math.cos(value), math.sin(value)
            for i in range(0, 12, 4):
                T[i], T[i + 1] = cosine * T[i] + sine * T[i + 1], cosine * T[i + 1] - sine * T[i]
        a += 12
        for i in range(0, 12, 4):
            x, y, z = T[i], T[i + 1], T[i + 2]
            T[i] = x * chain.links[a] + y * chain.links[a + 4] + z * chain.links[a + 8]
            T[i + 1] = x * chain.links[a + 1] + y * chain.links[a + 5] + z * chain.links[a + 9]
            T[i + 2] = x * chain.links[a + 2] + y * chain.links[a + 6] + z * chain.links[a + 10]
            T[i + 3] += x * chain.links[a + 3] + y * chain.links[a + 7] + z * chain.links[a + 11]


@both_ways
def derivative(
    chain: Chain, goal: Goal, target: Row, bench: Bench, J: Row, m: int, frame: int, first: int, last: int
) -> None:
    """∂e/∂q of a frame whose pose is on the bench."""
    T, turn, w = bench.T, bench.turn, goal.weights
    at, row = 16 * frame, 6 * frame * m
    u, v, z = turn[0], turn[1], turn[2]
    square = u * u + v * v + z * z
    angle = math.sqrt(square)
    # J_l⁻¹ = 1 − ½ [v×] + c [v×]²
    c = 1.0 / 12.0 + square / 720.0
    if angle > SMALL_ANGLE:
        c = (1.0 - 0.5 * angle * math.cos(0.5 * angle) / math.sin(0.5 * angle)) / square
    for i in range(row, row + 6 * m):
        J[i] = 0.0
    for k in range(first, last):
        j = chain.place[k]
        if j < 0:
            continue
        ratio = chain.ratio[k]
        ax, ay, az = ratio * bench.axes[3 * k], ratio * bench.axes[3 * k + 1], ratio * bench.axes[3 * k + 2]
        j += row
        if chain.slides[k] != 0.0:
            vx, vy, vz = ax, ay, az
        else:
            rx, ry, rz = T[3] - bench.origins[3 * k], T[7] - bench.origins[3 * k + 1], T[11] - bench.origins[3 * k + 2]
            vx, vy, vz = ay * rz - az * ry, az * rx - ax * rz, ax * ry - ay * rx
            # The axis as the frame sees it, Rᵀ a, and what the logarithm makes of it.
            bx = T[0] * ax + T[4] * ay + T[8] * az
            by = T[1] * ax + T[5] * ay + T[9] * az
            bz = T[2] * ax + T[6] * ay + T[10] * az
            cx, cy, cz = v * bz - z * by, z * bx - u * bz, u * by - v * bx
            dx, dy, dz = v * cz - z * cy, z * cx - u * cz, u * cy - v * cx
            J[3 * m + j] -= w[3] * (bx - 0.5 * cx + c * dx)
            J[4 * m + j] -= w[4] * (by - 0.5 * cy + c * dy)
            J[5 * m + j] -= w[5] * (bz - 0.5 * cz + c * dz)
        for i in range(3):
            J[i * m + j] -= w[i] * (target[at + i] * vx + target[at + 4 + i] * vy + target[at + 8 + i] * vz)


@both_ways
def turn_left(T: Row, target: Row, at: int, turn: Row) -> None:
    """log(Rᵀ R_t) of 3×4 transforms, the target's from `at` on, by the unit quaternion: accurate at 0 and at π."""
    m00 = T[0] * target[at] + T[4] * target[at + 4] + T[8] * target[at + 8]
    m11 = T[1] * target[at + 1] + T[5] * target[at + 5] + T[9] * target[at + 9]
    m22 = T[2] * target[at + 2] + T[6] * target[at + 6] + T[10] * target[at + 10]
    m01 = T[0] * target[at + 1] + T[4] * target[at + 5] + T[8] * target[at + 9]
    m10 = T[1] * target[at] + T[5] * target[at + 4] + T[9] * target[at + 8]
    m02 = T[0] * target[at + 2] + T[4] * target[at + 6] + T[8] * target[at + 10]
    m20 = T[2] * target[at] + T[6] * target[at + 4] + T[10] * target[at + 8]
    m12 = T[1] * target[at + 2] + T[5] * target[at + 6] + T[9] * target[at + 10]
    m21 = T[2] * target[at + 1] + T[6] * target[at + 5] + T[10] * target[at + 9]
    trace = m00 + m11 + m22
    # Four times the products of the largest component with all of them.
    if trace >= max(m00, m11, m22):
        s, x, y, z = 1.0 + trace, m21 - m12, m02 - m20, m10 - m01
    elif m00 >= max(m11, m22):
        s, x, y, z = m21 - m12, 1.0 + m00 - m11 - m22, m01 + m10, m02 + m20
    elif m11 >= m22:
        s, x, y, z = m02 - m20, m01 + m10, 1.0 + m11 - m00 - m22, m12 + m21
    else:
        s, x, y, z = m10 - m01, m02 + m20, m12 + m21, 1.0 + m22 - m00 - m11
    if s < 0.0:
        s, x, y, z = -s, -x, -y, -z
    length = math.sqrt(x * x + y * y + z * z)
    # Of a small angle the vector is twice the quaternion's.
    scale = 2.0 * math.atan2(length, s) / length if length > 1e-150 else 2.0 / s
    turn[0], turn[1], turn[2] = scale * x, scale * y, scale * z


@both_ways
def restrict(region: Region, values: Row, still: Row, bench: Bench) -> None:
    """The derivative along the directions that the limits leave open, into `J_open`."""
    m, rows = len(region.lower), len(bench.e)
    for i in range(rows * m):
        bench.J_open[i] = bench.J[i]
    if open_directions(region, values, still, bench.wanted, bench.ahead, bench.inside, bench.is_open, bench.along):
        return
    for i in range(rows):
        for j in range(m):
            bench.J_open[i * m + j] *= bench.is_open[j]
    for t in range(len(region.tables) // TABLE):
        x, y = bench.along[2 * t], bench.along[2 * t + 1]
        if x <= 1.0:
            of, joint = region.tables[TABLE * t], region.tables[TABLE * t + 1]
            for i in range(rows):
                part = bench.J_open[i * m + of] * x + bench.J_open[i * m + joint] * y
                bench.J_open[i * m + of], bench.J_open[i * m + joint] = part * x, part * y


@both_ways
def damped_step(m: int, damping: float, bench: Bench) -> None:
    """−(JᵀJ + λ 1)⁻¹ Jᵀe = −Jᵀ (J Jᵀ + λ 1)⁻¹ e for the open directions, by whichever system is smaller."""
    J, N, y = bench.J_open, bench.normal, bench.right
    rows = len(bench.e)
    size = min(rows, m)
    trace = 0.0
    for a in range(size):
        for b in range(a + 1):
            total = 0.0
            if m <= rows:
                for i in range(rows):
                    total += J[i * m + a] * J[i * m + b]
            else:
                for j in range(m):
                    total += J[a * m + j] * J[b * m + j]
            N[a * size + b] = total
        trace += N[a * size + a]
        y[a] = 0.0
        if m <= rows:
            for i in range(rows):
                y[a] += J[i * m + a] * bench.e[i]
        else:
            y[a] = bench.e[a]
    floor = _FLOOR * trace + _TINY
    for a in range(size):
        N[a * size + a] += damping + floor
    # Cholesky: N = L Lᵀ, then forwards and backwards.
    for a in range(size):
        for b in range(a + 1):
            total = N[a * size + b]
            for k in range(b):
                total -= N[a * size + k] * N[b * size + k]
            N[a * size + b] = math.sqrt(max(total, floor)) if a == b else total / N[b * size + b]
    for a in range(size):
        for k in range(a):
            y[a] -= N[a * size + k] * y[k]
        y[a] /= N[a * size + a]
    for a in range(size - 1, -1, -1):
        for k in range(a + 1, size):
            y[a] -= N[k * size + a] * y[k]
        y[a] /= N[a * size + a]
    for j in range(m):
        if m <= rows:
            bench.step[j] = -y[j]
        else:
            total = 0.0
            for i in range(rows):
                total += J[i * m + j] * y[i]
            bench.step[j] = -total
