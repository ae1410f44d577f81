"""The functions that all closed forms share: limits, the order of branches, reports, rotations of targets, searches.

A solver is a function `solve(limb, target, selection, work) → count`: it writes the values of each branch into
`work.q`, checks them with `check_limits`, computes their errors by its own forward kinematics, and calls `add_branch`.

`work.branches` has a row of c + 4 numbers for each branch: the joint values, the squared distance to the reference, the
errors in position and angle, and the family. `work.report` has the numbers that the constants below name, from `BEST`
on the joint values of the nearest pose.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias

from nao_kin._core.arrays import LIMIT_TOLERANCE, Floats
from nao_kin._kernels.cache import Row, both_ways
from nao_kin.ik.results import Reason

# Indices in a report.
REASON, JOINT, NEEDED, LIMIT, EXCESS, POSITION_ERROR, ANGLE_ERROR, BEST = range(8)
# A reason in a report, in addition to those of `Reason`.
NOT_RIGID = -1.0
REACHED, OUT_OF_REACH = float(Reason.REACHED), float(Reason.OUT_OF_REACH)
NOT_ENOUGH_JOINTS, NOT_CONVERGED = float(Reason.NOT_ENOUGH_JOINTS), float(Reason.NOT_CONVERGED)
JOINT_LIMIT, COUPLED_LIMIT = float(Reason.JOINT_LIMIT), float(Reason.COUPLED_LIMIT)

# Numbers after the joint values in a row of `branches`.
EXTRAS = 4
# Largest error of a solution [m, rad].
VERIFIED = 1e-10
# Largest defect of a rotation, as everywhere in the library.
RIGID = 1e-6
# Rotations with a smaller defect than this are not corrected.
ROUNDING = 1e-14
# A search exceeds a limit by at most this [rad].
LIMIT_ROUNDING = 1e-9
# Whole turns are added up to a reference of this size [rad]: beyond it, the solution would lose digits.
MAX_TURNED = 1e4
# Largest number of rows in the table of a coupled limit.
MAX_BENDS = 24

# A reason, with the joint, the value that it needs and the limit that it exceeds.
Why: TypeAlias = tuple[float, float, float, float]
NO_REASON, NO_OBSTACLE = (NOT_CONVERGED, -1.0, 0.0, 0.0), (REACHED, -1.0, 0.0, 0.0)

Vector: TypeAlias = tuple[float, float, float]
Rotation: TypeAlias = tuple[float, float, float, float, float, float, float, float, float]


class Ranges(NamedTuple):
    """Limits of the c joints of a limb, as values of these joints [rad].

    If a limit is coupled, the range of `joint` depends on joint `of`: at the first `bends` values of `at` it is from
    `low` to `high`; zeros follow up to `MAX_BENDS`. Tuples, because compiled code counts references to arrays, and
    threads would wait for each other.
    """

    lower: tuple[float, ...]
    upper: tuple[float, ...]
    bends: int
    at: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    joint: int
    of: int


class Selection(NamedTuple):
    """Limits (`LegsRanges` for two legs), joint values to sort branches by, and whether to enforce the limits."""

    ranges: Any
    reference: Row
    enforce: bool


class Workspace(NamedTuple):
    """Arrays for a solver's results: the joint values of one branch, all branches, and the report."""

    q: Row
    branches: Row
    report: Row


class Pose(NamedTuple):
    """A rotation by rows, and a position [m]."""

    r00: float
    r01: float
    r02: float
    r10: float
    r11: float
    r12: float
    r20: float
    r21: float
    r22: float
    x: float
    y: float
    z: float


@both_ways
def wrapped(angle: float) -> float:
    """Return an angle from (−3π, 3π] wrapped into (−π, π]."""
    if angle > math.pi:
        return angle - 2.0 * math.pi
    if angle <= -math.pi:
        return angle + 2.0 * math.pi
    return angle


@both_ways
def turned_towards(value: float, near: float) -> float:
    """Return an angle with the whole turns that bring it within half a turn of another."""
    if abs(near) > MAX_TURNED:
        return value
    return value + 2.0 * math.pi * math.floor((near - value) / (2.0 * math.pi) + 0.5)


@both_ways
def table_range(ranges: Ranges, of: float) -> tuple[float, float]:
    """Return the coupled range of `ranges.joint` with the other joint at `of`; constant outside the table."""
    # As `range_at` of limit_regions; a function shared by both would copy the tuples, which takes longer than the rest.
    at, low, high, last = ranges.at, ranges.low, ranges.high, ranges.bends - 1
    if of <= at[0]:
        return low[0], high[0]
    if of >= at[last]:
        return low[last], high[last]
    right = 1
    while at[right] < of:
        right += 1
    left = right - 1
    share = (of - at[left]) / (at[right] - at[left])
    return low[left] + share * (low[right] - low[left]), high[left] + share * (high[right] - high[left])


@both_ways
def coupled_range(ranges: Ranges, joint: int, of: float) -> tuple[float, float]:
    """Return the range of a joint, narrowed by its table, if any, with the other joint at `of`."""
    low, high = ranges.lower[joint], ranges.upper[joint]
    if ranges.bends > 0:
        bounds = table_range(ranges, of)
        low, high = min(max(low, bounds[0]), high), max(min(high, bounds[1]), low)
    return low, high


@both_ways
def farthest_outside(ranges: Ranges, q: Row) -> tuple[float, float, int, float]:
    """Return the largest excess over the limits (negative if all are inside), the reason, the joint, and the limit.

    A table counts only for a joint that is inside its own range.
    """
    worst, reason, joint, limit = -math.inf, JOINT_LIMIT, 0, 0.0
    for j in range(len(ranges.lower)):
        excess, bound = _excess(q[j], ranges.lower[j], ranges.upper[j])
        if excess > worst:
            worst, joint, limit = excess, j, bound
    if ranges.bends > 0 and not is_outside(ranges, ranges.joint, q[ranges.joint]):
        low, high = table_range(ranges, q[ranges.of])
        excess, bound = _excess(q[ranges.joint], low, high)
        if excess > worst:
            worst, reason, joint, limit = excess, COUPLED_LIMIT, ranges.joint, bound
    return worst, reason, joint, limit


@both_ways
def _excess(value: float, low: float, high: float) -> tuple[float, float]:
    """Return how far a value is outside a range, negative inside, and the nearer end of the range."""
    return (low - value, low) if low - value > value - high else (value - high, high)


@both_ways
def is_outside(ranges: Ranges, joint: int, value: float) -> bool:
    """Return whether a joint is outside its own range."""
    return value < ranges.lower[joint] - LIMIT_TOLERANCE or value > ranges.upper[joint] + LIMIT_TOLERANCE


@both_ways
def angle_of_chord(squares: float) -> float:
    """Return the angle between two rotations, ‖R − F‖ = 2 √2 sin(angle / 2), from ‖R − F‖²."""
    half = math.sqrt(0.125 * squares)
    # The sine of a small angle is the angle.
    return 2.0 * half if half < 1e-9 else 2.0 * math.asin(min(1.0, half))


@both_ways
def check_limits(selection: Selection, q: Row, report: Row) -> bool:
    """Return whether a branch satisfies the limits; if it exceeds them the least so far, report its limit."""
    if not selection.enforce or is_inside(selection.ranges, q):
        return True
    outside = farthest_outside(selection.ranges, q)[0]
    if outside < report[EXCESS]:
        report[EXCESS] = outside
        report_limit(selection.ranges, q, report)
    return False


@both_ways
def is_inside(ranges: Ranges, q: Row) -> bool:
    """Return whether all joints are inside their limits."""
    for j in range(len(ranges.lower)):
        if q[j] < ranges.lower[j] - LIMIT_TOLERANCE or q[j] > ranges.upper[j] + LIMIT_TOLERANCE:
            return False
    if ranges.bends > 0:
        low, high = table_range(ranges, q[ranges.of])
        value: float = q[ranges.joint]
        return low - LIMIT_TOLERANCE <= value <= high + LIMIT_TOLERANCE
    return True


@both_ways
def report_limit(ranges: Ranges, q: Row, report: Row) -> None:
    """Report the joint that is farthest outside its limits."""
    _, report[REASON], joint, report[LIMIT] = farthest_outside(ranges, q)
    report[JOINT], report[NEEDED] = float(joint), q[joint]


@both_ways
def locked_pair(pair: tuple[int, int], total: float, sign: float, selection: Selection, q: Row) -> None:
    """Write two joints about one line, first + sign · third = total, nearest to the reference, in range if possible."""
    ranges, reference, enforce = selection
    i, j = pair
    if not enforce:
        # Take half of the reference's excess over the total, up to whole turns, from each joint.
        half = 0.5 * turned_towards(reference[i] + sign * reference[j] - total, 0.0)
        q[i], q[j] = reference[i] - half, reference[j] - sign * half
        return
    low1, high1, low3, high3 = ranges.lower[i], ranges.upper[i], ranges.lower[j], ranges.upper[j]
    best_outside, best = math.inf, math.inf
    for turns in range(-2, 3):
        # third = sign (total − first) + shift
        shift = 2.0 * math.pi * turns
        one, two = total - sign * (low3 - shift), total - sign * (high3 - shift)
        low, high = max(low1, min(one, two)), min(high1, max(one, two))
        first = 0.5 * (reference[i] + total + sign * (shift - reference[j]))
        first = min(max(first, low), high) if low <= high else min(max(0.5 * (low + high), low1), high1)
        third = sign * (total - first) + shift
        outside = max(0.0, low3 - third, third - high3)
        away = (first - reference[i]) * (first - reference[i]) + (third - reference[j]) * (third - reference[j])
        if outside < best_outside - LIMIT_ROUNDING or (outside < best_outside + LIMIT_ROUNDING and away < best):
            best_outside, best = outside, away
            q[i], q[j] = first, third


@both_ways
def joint_difference(value: float, near: float, enforce: bool) -> float:
    """Return the difference of a value to the reference's; without limits, up to whole turns."""
    return (value if enforce else turned_towards(value, near)) - near


@both_ways
def squared_distance(q: Row, reference: Row, enforce: bool) -> float:
    """Return the squared distance of joint values to those of the reference, by `joint_difference`."""
    total = 0.0
    for j in range(len(reference)):
        difference = joint_difference(q[j], reference[j], enforce)
        total += difference * difference
    return total


@both_ways
def branch_cost(selection: Selection, q: Row) -> float:
    """Return the cost of a member of a family: its distance to the reference, and much more outside the limits."""
    outside = farthest_outside(selection.ranges, q)[0] if selection.enforce else 0.0
    if outside > LIMIT_ROUNDING:
        return 1e3 * (1.0 + outside)
    return squared_distance(q, selection.reference, selection.enforce)


@both_ways
def add_branch(selection: Selection, work: Workspace, errors: tuple[float, float], family: float, count: int) -> int:
    """Insert the branch in `q` into `branches`, sorted by the distance to the reference; return the new number.

    Skip a branch whose errors in position and angle are too large. Without limits, turn each joint by whole turns to
    within half a turn of the reference.
    """
    if not (errors[0] <= VERIFIED and errors[1] <= VERIFIED):
        return count
    reference, q, branches = selection.reference, work.q, work.branches
    joints = len(reference)
    width = joints + EXTRAS
    last, away = count * width, 0.0
    for j in range(joints):
        value = q[j] if selection.enforce else turned_towards(q[j], reference[j])
        branches[last + j] = value
        away += (value - reference[j]) * (value - reference[j])
    branches[last + joints] = away
    branches[last + joints + 1] = errors[0]
    branches[last + joints + 2] = errors[1]
    branches[last + joints + 3] = family
    while last > 0 and branches[last - width + joints] > away:
        for j in range(last, last + width):
            branches[j], branches[j - width] = branches[j - width], branches[j]
        last -= width
    return count + 1


@both_ways
def add_shortfall(branches: Row, joints: int, count: int, short: float) -> None:
    """Add the distance by which the target was moved into reach [m] to the branches' errors in position."""
    if short > 0.0:
        for k in range(count):
            branches[k * (joints + EXTRAS) + joints + 1] += short


@both_ways
def reason_of(report: Row) -> Why:
    """Return the reason in a report, with its joint, needed value and limit."""
    return report[REASON], report[JOINT], report[NEEDED], report[LIMIT]


@both_ways
def write_reason(report: Row, why: Why) -> None:
    """Write a reason into a report."""
    report[REASON], report[JOINT], report[NEEDED], report[LIMIT] = why


@both_ways
def start_report(report: Row) -> None:
    """Clear a report."""
    write_reason(report, NO_REASON)
    report[EXCESS] = math.inf
    for j in range(POSITION_ERROR, len(report)):
        report[j] = math.nan


@both_ways
def finish_report(work: Workspace, joints: int, count: int) -> None:
    """Report the best of the branches, if there is one."""
    branches, report = work.branches, work.report
    if count > 0:
        write_reason(report, NO_OBSTACLE)
        report[POSITION_ERROR], report[ANGLE_ERROR] = branches[joints + 1], branches[joints + 2]
        for j in range(joints):
            report[BEST + j] = branches[j]


@both_ways
def write_values(motors: Row, coordinates: Row, values: Row) -> None:
    """Write the values in the closed form for coordinates of the c joints, multiplier · coordinate + offset.

    `motors` has the multipliers, the offsets, and the values of the joints from which the closed form counts.
    """
    joints = len(values)
    for j in range(joints):
        values[j] = motors[j] * coordinates[j] + motors[joints + j]


@both_ways
def write_coordinates(motors: Row, selection: Selection, work: Workspace, count: int) -> None:
    """Replace the values of the closed form by coordinates in the branches, and in the report by those of the joints.

    Without limits, the nearest pose of a target that is missed is first turned to within half a turn of the reference.
    """
    branches, report, joints = work.branches, work.report, len(selection.reference)
    if count == 0 and not selection.enforce:
        for j in range(joints):
            if report[BEST + j] == report[BEST + j]:  # not NaN
                report[BEST + j] = turned_towards(report[BEST + j], selection.reference[j])
    for j in range(joints):
        multiplier, offset = motors[j], motors[joints + j]
        report[BEST + j] = (report[BEST + j] - offset) / multiplier
        for k in range(j, count * (joints + EXTRAS), joints + EXTRAS):
            branches[k] = (branches[k] - offset) / multiplier
    if report[JOINT] >= 0.0:
        zero = motors[2 * joints + int(report[JOINT])]
        report[NEEDED] += zero
        report[LIMIT] += zero


@both_ways
def write_branches(branches: Row, count: int, joints: int, out: Row) -> None:
    """Write the branches of one target into a row, as far as it has space, then nan."""
    width = joints + EXTRAS
    written = min(len(out), count * width)
    for j in range(written):
        out[j] = branches[j]
    for first in range(written, len(out), width):
        for j in range(joints):
            out[first + j] = math.nan
        for j in range(joints, width):
            out[first + j] = 0.0


@both_ways
def link_rotation(limb: Any, T: Row) -> tuple[bool, Rotation]:
    """Return whether the sixteen numbers of T are rigid, and the rotation of the link whose frame has pose T."""
    is_rigid, R = rigid_rotation(T)
    if limb.turned == 0.0:
        return is_rigid, R
    a, b, c, d, e, f, g, h, i = R
    r00, r01, r02, r10, r11, r12, r20, r21, r22 = limb.rotation
    return is_rigid, (
        a * r00 + b * r01 + c * r02, a * r10 + b * r11 + c * r12, a * r20 + b * r21 + c * r22,
        d * r00 + e * r01 + f * r02, d * r10 + e * r11 + f * r12, d * r20 + e * r21 + f * r22,
        g * r00 + h * r01 + i * r02, g * r10 + h * r11 + i * r12, g * r20 + h * r21 + i * r22,
    )  # fmt: skip


@both_ways
def rigid_rotation(T: Row) -> tuple[bool, Rotation]:
    """Return whether the sixteen numbers of T are a rigid transform, and the nearest rotation.

    One step of R ← R (3 − RᵀR)/2 reduces a defect δ ≤ 1e-6 to less than δ².
    """
    a, b, c, d, e, f, g, h, i = T[0], T[1], T[2], T[4], T[5], T[6], T[8], T[9], T[10]
    xx, yy, zz = 1.0 - (a * a + d * d + g * g), 1.0 - (b * b + e * e + h * h), 1.0 - (c * c + f * f + i * i)
    xy, xz, yz = -(a * b + d * e + g * h), -(a * c + d * f + g * i), -(b * c + e * f + h * i)
    defect = max(abs(xx), abs(yy), abs(zz), abs(xy), abs(xz), abs(yz))
    determinant = a * (e * i - f * h) + b * (f * g - d * i) + c * (d * h - e * g)
    below = abs(T[12]) + abs(T[13]) + abs(T[14]) + abs(T[15] - 1.0)
    # Comparisons with NaN are false.
    is_rigid = defect <= RIGID and abs(determinant - 1.0) <= RIGID and below <= RIGID
    is_rigid = is_rigid and abs(T[3]) + abs(T[7]) + abs(T[11]) < math.inf
    if is_rigid and defect > ROUNDING:
        return is_rigid, (
            a + 0.5 * (a * xx + b * xy + c * xz),
            b + 0.5 * (a * xy + b * yy + c * yz),
            c + 0.5 * (a * xz + b * yz + c * zz),
            d + 0.5 * (d * xx + e * xy + f * xz),
            e + 0.5 * (d * xy + e * yy + f * yz),
            f + 0.5 * (d * xz + e * yz + f * zz),
            g + 0.5 * (g * xx + h * xy + i * xz),
            h + 0.5 * (g * xy + h * yy + i * yz),
            i + 0.5 * (g * xz + h * yz + i * zz),
        )
    return is_rigid, (a, b, c, d, e, f, g, h, i)


# --- Searches over one variable: the least and the local minima of a function.
#
# A function is called as `function(given, value)`; `given` are its other arguments.

# Halvings of the steps of `least`.
_FINER = 48


@both_ways
def least(function: Callable[..., float], given: Any, low: float, high: float, near: float, steps: int) -> float:
    """Return the minimiser of a function: the best of even steps and of `near`, refined by halved steps."""
    step = (high - low) / steps
    lowest, best = math.inf, low
    for k in range(-1, steps + 1):
        value = min(max(near, low), high) if k < 0 else low + step * k
        result = function(given, value)
        if result < lowest:
            lowest, best = result, value
    for _ in range(_FINER):
        for value in (max(low, best - step), min(high, best + step)):
            result = function(given, value)
            if result < lowest:
                lowest, best = result, value
        step *= 0.5
    return best


@both_ways
def local_minima(function: Callable[..., float], given: Any, starts: Floats, minima: Floats) -> int:
    """Write the local minima of a function at ascending values, each refined between two; return their number."""
    count, last = 0, len(starts) - 1
    before = here = function(given, starts[0])
    for k in range(last + 1):
        after = function(given, starts[min(k + 1, last)])
        if here <= min(before, after):
            minima[count] = least(function, given, starts[max(k - 1, 0)], starts[min(k + 1, last)], starts[k], 2)
            count += 1
        before, here = here, after
    return count
