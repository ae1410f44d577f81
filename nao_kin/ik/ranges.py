"""Which branches are inside the limits, and their order: what all closed forms share.

A solver is a function `solve(limb, target, selection, work) → count`: it writes the values of each branch into
`work.q`, asks `check_limits` whether they are inside the limits, computes their errors by its own forward kinematics,
and hands both to `add_branch`.

`work.found` holds a row of c + 4 numbers for each branch: the joint values, the squared distance to the reference, the
errors in position and angle, and the family. `work.report` holds the numbers that the constants below name, from `BEST`
on the joint values of the nearest pose.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple, TypeAlias

from nao_kin._kernels.cache import both_ways
from nao_kin.ik.compiling import Row
from nao_kin.ik.results import Reason
from nao_kin.robot import LIMIT_TOLERANCE

# Places in a report.
REASON, JOINT, NEEDED, LIMIT, EXCESS, POSITION_ERROR, ANGLE_ERROR, BEST = range(8)
# What a report says beside the numbers of `Reason`.
NOT_RIGID = -1.0
REACHED, OUT_OF_REACH = float(Reason.REACHED), float(Reason.OUT_OF_REACH)
NOT_ENOUGH_JOINTS, NOT_CONVERGED = float(Reason.NOT_ENOUGH_JOINTS), float(Reason.NOT_CONVERGED)
JOINT_LIMIT, COUPLED_LIMIT = float(Reason.JOINT_LIMIT), float(Reason.COUPLED_LIMIT)

# How many numbers follow the joint values in a row of `found`.
EXTRAS = 4
# A branch whose pose is off by more, in m or rad, is no solution.
VERIFIED = 1e-10
# How far a rotation may be from one, as everywhere in the library.
RIGID = 1e-6
# Rotations that are closer to one are left as they are.
ROUNDING = 1e-14
# A search passes a limit by no more [rad].
LIMIT_ROUNDING = 1e-9
# Whole turns are added up to a reference of this size [rad]: beyond, they would cost digits of the solution.
MOST_TURNED = 1e4
# The most values at which the range of a joint that depends on another may bend.
MOST_BENDS = 24

Vector: TypeAlias = tuple[float, float, float]
Rotation: TypeAlias = tuple[float, float, float, float, float, float, float, float, float]


class Ranges(NamedTuple):
    """Limits of the c joints of a limb, as values of these joints.

    Tuples, for compiled code counts who uses an array, which threads would wait for.

    Attributes:
        lower: smallest values, c numbers [rad].
        upper: largest values.
        bends: at how many values of joint `of` the range of `joint` bends; 0 where none depends on another.
        at: these values, and zeros up to `MOST_BENDS`.
        low: its smallest values there.
        high: its largest values there.
        joint: the joint whose range depends on another.
        of: the joint that it depends on.
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
    """Which branches of a target are returned, and in which order.

    Attributes:
        ranges: limits of the joints; of two limbs those of each.
        reference: joint values; the branch nearest to them comes first.
        enforce: whether branches outside the limits are left out.
    """

    ranges: Any
    reference: Row
    enforce: bool


class Workspace(NamedTuple):
    """What a solver writes into.

    Attributes:
        q: the joint values of one branch.
        found: the branches.
        report: the reason, and the nearest pose.
    """

    q: Row
    found: Row
    report: Row


class Pose(NamedTuple):
    """A rotation by rows, and a place [m]."""

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
    """An angle from within (−3π, 3π] taken into (−π, π]."""
    if angle > math.pi:
        return angle - 2.0 * math.pi
    if angle <= -math.pi:
        return angle + 2.0 * math.pi
    return angle


@both_ways
def turned_towards(value: float, near: float) -> float:
    """The same angle with the whole turns that bring it within half a turn of another."""
    if abs(near) > MOST_TURNED:
        return value
    return value + 2.0 * math.pi * math.floor((near - value) / (2.0 * math.pi) + 0.5)


@both_ways
def table_range(ranges: Ranges, of: float) -> tuple[float, float]:
    """The range of the joint that depends on another, at a value of the latter; constant outside the table."""
    at, last = ranges.at, ranges.bends - 1
    if of <= at[0]:
        return ranges.low[0], ranges.high[0]
    if of >= at[last]:
        return ranges.low[last], ranges.high[last]
    right = 1
    while at[right] < of:
        right += 1
    left = right - 1
    share = (of - at[left]) / (at[right] - at[left])
    low = ranges.low[left] + share * (ranges.low[right] - ranges.low[left])
    return low, ranges.high[left] + share * (ranges.high[right] - ranges.high[left])


@both_ways
def coupled_range(ranges: Ranges, joint: int, of: float) -> tuple[float, float]:
    """The range of a joint at a value of the joint that it may depend on, inside its own range."""
    low, high = ranges.lower[joint], ranges.upper[joint]
    if ranges.bends > 0:
        bounds = table_range(ranges, of)
        low, high = min(max(low, bounds[0]), high), max(min(high, bounds[1]), low)
    return low, high


@both_ways
def farthest_outside(ranges: Ranges, q: Row) -> tuple[float, float, int, float]:
    """How far a joint is outside its limits, less than 0 where all are inside; why, which joint, and the limit.

    The joint is the one that is farthest outside. A table counts only for a joint that is inside its own range.
    """
    worst, reason, joint, limit = -math.inf, JOINT_LIMIT, 0, 0.0
    for j in range(len(ranges.lower)):
        below, above = ranges.lower[j] - q[j], q[j] - ranges.upper[j]
        if max(below, above) > worst:
            worst, joint, limit = max(below, above), j, ranges.lower[j] if below > above else ranges.upper[j]
    if ranges.bends > 0 and not is_outside(ranges, ranges.joint, q[ranges.joint]):
        low, high = table_range(ranges, q[ranges.of])
        below, above = low - q[ranges.joint], q[ranges.joint] - high
        if max(below, above) > worst:
            worst, reason, joint = max(below, above), COUPLED_LIMIT, ranges.joint
            limit = low if below > above else high
    return worst, reason, joint, limit


@both_ways
def is_outside(ranges: Ranges, joint: int, value: float) -> bool:
    """Whether a joint is outside its own range."""
    return value < ranges.lower[joint] - LIMIT_TOLERANCE or value > ranges.upper[joint] + LIMIT_TOLERANCE


@both_ways
def angle_of_chord(squares: float) -> float:
    """The angle between two rotations from the sum of the squared differences of their entries.

    ‖R − F‖ = 2 √2 sin(angle / 2)
    """
    half = math.sqrt(0.125 * squares)
    # Of a small angle the sine is the angle itself.
    return 2.0 * half if half < 1e-9 else 2.0 * math.asin(min(1.0, half))


@both_ways
def check_limits(selection: Selection, q: Row, report: Row) -> bool:
    """Whether a branch may be returned; if not, its limit is reported where none before was less outside."""
    if not selection.enforce or is_inside(selection.ranges, q):
        return True
    outside = farthest_outside(selection.ranges, q)[0]
    if outside < report[EXCESS]:
        report[EXCESS] = outside
        report_limit(selection.ranges, q, report)
    return False


@both_ways
def is_inside(ranges: Ranges, q: Row) -> bool:
    """Whether all joints are inside their limits."""
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
    """Write two joints about one line into q, of which only first + sign · third = total is determined.

    They are the pair that is nearest to the reference, inside the ranges if there is one.
    """
    ranges, reference, enforce = selection
    i, j = pair
    if not enforce:
        # What the reference has too much, up to whole turns, is shared by both.
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
    """How far a value is from that of the reference; without limits, to the nearest of its whole turns."""
    return (value if enforce else turned_towards(value, near)) - near


@both_ways
def squared_distance(q: Row, reference: Row, enforce: bool) -> float:
    """Squared distance of joint values to those of the reference, as `joint_difference` has it."""
    total = 0.0
    for j in range(len(reference)):
        difference = joint_difference(q[j], reference[j], enforce)
        total += difference * difference
    return total


@both_ways
def branch_cost(selection: Selection, q: Row) -> float:
    """How far a member of a family is from the reference; far more where it is outside the limits."""
    outside = farthest_outside(selection.ranges, q)[0] if selection.enforce else 0.0
    if outside > LIMIT_ROUNDING:
        return 1e3 * (1.0 + outside)
    return squared_distance(q, selection.reference, selection.enforce)


@both_ways
def add_branch(selection: Selection, work: Workspace, errors: tuple[float, float], family: float, count: int) -> int:
    """Add the branch in `q` to those that were found, the nearest to the reference first; their new number.

    A branch whose errors in position and angle are too large is left out. Without limits, each joint is turned by whole
    turns to within half a turn of the reference.
    """
    if not (errors[0] <= VERIFIED and errors[1] <= VERIFIED):
        return count
    reference, q, found = selection.reference, work.q, work.found
    joints = len(reference)
    width = joints + EXTRAS
    last, away = count * width, 0.0
    for j in range(joints):
        value = q[j] if selection.enforce else turned_towards(q[j], reference[j])
        found[last + j] = value
        away += (value - reference[j]) * (value - reference[j])
    found[last + joints] = away
    found[last + joints + 1] = errors[0]
    found[last + joints + 2] = errors[1]
    found[last + joints + 3] = family
    while last > 0 and found[last - width + joints] > away:
        for j in range(last, last + width):
            found[j], found[j - width] = found[j - width], found[j]
        last -= width
    return count + 1


@both_ways
def add_shortfall(found: Row, joints: int, count: int, short: float) -> None:
    """Add to the errors in position of the branches what their target was moved by to be in reach [m]."""
    if short > 0.0:
        for k in range(count):
            found[k * (joints + EXTRAS) + joints + 1] += short


@both_ways
def start_report(report: Row) -> None:
    """Clear a report."""
    report[REASON], report[JOINT], report[NEEDED], report[LIMIT] = NOT_CONVERGED, -1.0, 0.0, 0.0
    report[EXCESS] = math.inf
    for j in range(POSITION_ERROR, len(report)):
        report[j] = math.nan


@both_ways
def finish_report(work: Workspace, joints: int, count: int) -> None:
    """Report the best of the branches, where there is one."""
    found, report = work.found, work.report
    if count > 0:
        report[REASON], report[JOINT], report[NEEDED], report[LIMIT] = REACHED, -1.0, 0.0, 0.0
        report[POSITION_ERROR], report[ANGLE_ERROR] = found[joints + 1], found[joints + 2]
        for j in range(joints):
            report[BEST + j] = found[j]


@both_ways
def write_branches(found: Row, count: int, joints: int, out: Row) -> None:
    """Write the branches of one target into a row, as far as it has room; nan for those that are missing."""
    width = joints + EXTRAS
    there = min(len(out), count * width)
    for j in range(there):
        out[j] = found[j]
    for first in range(there, len(out), width):
        for j in range(joints):
            out[first + j] = math.nan
        for j in range(joints, width):
            out[first + j] = 0.0


@both_ways
def link_rotation(limb: Any, T: Row) -> tuple[bool, Rotation]:
    """Whether the sixteen numbers of T are rigid, and the rotation of the link whose frame stands at T."""
    fine, R = _rigid(T)
    if limb.turned == 0.0:
        return fine, R
    a, b, c, d, e, f, g, h, i = R
    r00, r01, r02, r10, r11, r12, r20, r21, r22 = limb.rotation
    return fine, (
        a * r00 + b * r01 + c * r02, a * r10 + b * r11 + c * r12, a * r20 + b * r21 + c * r22,
        d * r00 + e * r01 + f * r02, d * r10 + e * r11 + f * r12, d * r20 + e * r21 + f * r22,
        g * r00 + h * r01 + i * r02, g * r10 + h * r11 + i * r12, g * r20 + h * r21 + i * r22,
    )  # fmt: skip


@both_ways
def _rigid(T: Row) -> tuple[bool, Rotation]:
    """Whether the sixteen numbers of T are a rigid transform, and the rotation nearest to what it has.

    One step of R ← R (3 − RᵀR)/2 leaves of a defect δ ≤ 1e-6 less than δ².
    """
    a, b, c, d, e, f, g, h, i = T[0], T[1], T[2], T[4], T[5], T[6], T[8], T[9], T[10]
    xx, yy, zz = 1.0 - (a * a + d * d + g * g), 1.0 - (b * b + e * e + h * h), 1.0 - (c * c + f * f + i * i)
    xy, xz, yz = -(a * b + d * e + g * h), -(a * c + d * f + g * i), -(b * c + e * f + h * i)
    defect = max(abs(xx), abs(yy), abs(zz), abs(xy), abs(xz), abs(yz))
    determinant = a * (e * i - f * h) + b * (f * g - d * i) + c * (d * h - e * g)
    below = abs(T[12]) + abs(T[13]) + abs(T[14]) + abs(T[15] - 1.0)
    # Comparisons with NaN are false.
    fine = defect <= RIGID and abs(determinant - 1.0) <= RIGID and below <= RIGID
    fine = fine and abs(T[3]) + abs(T[7]) + abs(T[11]) < math.inf
    if fine and defect > ROUNDING:
        return fine, (
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
    return fine, (a, b, c, d, e, f, g, h, i)
