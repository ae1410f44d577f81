"""The values of HipYawPitch that the limits of a leg leave, where its ankle and the normal of its sole are given.

For each branch of a leg (knee, way of HipRoll, way of the ankle) they are a few pieces. Where a joint is at its limit
is a root of a linear or quadratic form in (cos q₁, sin q₁), with every digit; only where AnkleRoll is at a limit that
AnklePitch leaves it, it is bracketed.
"""

from __future__ import annotations

import math

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.ik.closed_forms.leg_equations import Foot, Leg
from nao_kin.ik.closed_forms.legs_equations import level_joints
from nao_kin.ik.closed_forms.ranges import Ranges, is_inside, is_outside, table_range, wrapped
from nao_kin.ik.compiling import both_ways

# Pieces of all branches of a leg together, and ends of the pieces of one branch, before and after the table.
MOST_PIECES, _MOST_ENDS = 128, 384
# Places in a piece: its ends, the sign of ψ's branch, the knee, the ways of HipRoll and of the ankle (0 for any).
FROM, TO, SIGN, KNEE, WAY, ANKLE, PIECE = range(7)
# Values of HipYawPitch that a table is looked at between two bends, and halvings of a bracket.
_LOOKS, _HALVINGS = 8, 60
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
    for _ in range(_HALVINGS):
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
    for _ in range(_HALVINGS):
        if first <= second:
            high, two, second = two, one, first
            one = high - _GOLDEN * (high - low)
            first = sign * _beyond(leg, ranges, foot, branch, side, one)
        else:
            low, one, first = one, two, second
            two = low + _GOLDEN * (high - low)
            second = sign * _beyond(leg, ranges, foot, branch, side, two)
    return 0.5 * (low + high)
