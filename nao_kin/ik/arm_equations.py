"""The arm: four real branches for a pose of the hand that five joints can make, and up to eight for five numbers of it.

ShoulderPitch about y and ShoulderRoll about z meet in the shoulder; ElbowYaw about x, ElbowRoll about z and WristYaw
about x meet in the elbow, at e = (e_x, e_y, 0) in the upper arm. With the frame at h from the elbow in the hand's axes,

    R = Ry(q₁) Rz(q₂) Rx(q₃) Rz(q₄) Rx(q₅),  p = shoulder + Ry(q₁) Rz(q₂) e + R h.

The pose fixes the elbow, p − R h; the arm makes it only where that is |e| from the shoulder. Its direction gives the
shoulder (two ways), what is then left of R the three others (two ways).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from nao_kin._kernels.cache import both_ways
from nao_kin.ik.compiling import Row
from nao_kin.ik.ranges import (
    NEEDED,
    NOT_ENOUGH_JOINTS,
    NOT_RIGID,
    OUT_OF_REACH,
    REASON,
    ROUNDING,
    VERIFIED,
    Ranges,
    admitted,
    angle_of_chord,
    begun,
    concluded,
    distance,
    entered,
    excess,
    is_inside,
    is_outside,
    locked_pair,
    rigid,
    wrapped,
)
from nao_kin.ik.results import Family

JOINTS = 5
MOST_BRANCHES = 8

_ALONE, _ELBOW_LOCK = float(Family.NONE), float(Family.ELBOW_LOCK)
_SHOULDER_AXIS = float(Family.SHOULDER_AXIS)
# How far [m] the elbow may be from where the arm can have it, and from the axis of ShoulderPitch to be on it.
_REACHED, _ON_AXIS = 1e-11, 1e-12
# Sine of ElbowRoll up to which the axes of ElbowYaw and WristYaw are one.
_PARALLEL = 1e-12
# Below this, or as near to half a turn, the elbow's two places on its circle are one.
_ONE_TURN = 1e-7
# Steps of the search in a family, and halvings after it.
_STEPS, _HALVINGS = 180, 48


class Arm(NamedTuple):
    """What the closed form needs to know of an arm.

    Attributes:
        x: the shoulder in the torso, three numbers [m].
        y: see there.
        z: see there.
        elbow_x: the elbow in the upper arm [m].
        elbow_y: see there.
        hand_x: the frame's origin, from the elbow in the axes of the hand, three numbers [m].
        hand_y: see there.
        hand_z: see there.
        weight: what a radian counts where a pose is not met [m].
        turned: whether the frame is turned against the hand, 0 or 1.
        a00: its rotation in the hand, nine numbers by rows.
        a01: see there.
        a02: see there.
        a10: see there.
        a11: see there.
        a12: see there.
        a20: see there.
        a21: see there.
        a22: see there.
    """

    x: float
    y: float
    z: float
    elbow_x: float
    elbow_y: float
    hand_x: float
    hand_y: float
    hand_z: float
    weight: float
    turned: float
    a00: float
    a01: float
    a02: float
    a10: float
    a11: float
    a12: float
    a20: float
    a21: float
    a22: float


class Hand(NamedTuple):
    """A target: orientation of the hand by rows, and place of the frame seen from the shoulder."""

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
def hand_of(arm: Arm, target: Row) -> tuple[bool, Hand]:
    """Whether the sixteen numbers of a pose are rigid, and the pose as that of the hand."""
    fine, a, b, c, d, e, f, g, h, i = rigid(target)
    if arm.turned != 0.0:
        a, b, c = (
            a * arm.a00 + b * arm.a01 + c * arm.a02,
            a * arm.a10 + b * arm.a11 + c * arm.a12,
            a * arm.a20 + b * arm.a21 + c * arm.a22,
        )
        d, e, f = (
            d * arm.a00 + e * arm.a01 + f * arm.a02,
            d * arm.a10 + e * arm.a11 + f * arm.a12,
            d * arm.a20 + e * arm.a21 + f * arm.a22,
        )
        g, h, i = (
            g * arm.a00 + h * arm.a01 + i * arm.a02,
            g * arm.a10 + h * arm.a11 + i * arm.a12,
            g * arm.a20 + h * arm.a21 + i * arm.a22,
        )
    return fine, Hand(a, b, c, d, e, f, g, h, i, target[3] - arm.x, target[7] - arm.y, target[11] - arm.z)


@both_ways
def out_of_reach(arm: Arm, x: float, y: float, z: float, report: Row) -> bool:
    """Whether a place seen from the shoulder is out of reach of the frame, which is then reported with the distance."""
    upper = math.sqrt(arm.elbow_x * arm.elbow_x + arm.elbow_y * arm.elbow_y)
    lower = math.sqrt(arm.hand_x * arm.hand_x + arm.hand_y * arm.hand_y + arm.hand_z * arm.hand_z)
    far = math.sqrt(x * x + y * y + z * z)
    beyond = max(far - upper - lower, abs(upper - lower) - far)
    if beyond <= _ON_AXIS:
        return False
    report[REASON], report[NEEDED] = OUT_OF_REACH, beyond
    return True


@both_ways
def solve_arm(
    arm: Arm, ranges: Ranges, target: Row, reference: Row, enforce: bool, q: Row, found: Row, report: Row
) -> int:
    """All branches of an arm for the pose of its frame; see `ranges` for the arguments."""
    begun(report)
    fine, hand = hand_of(arm, target)
    if not fine:
        report[REASON] = NOT_RIGID
        return 0
    if out_of_reach(arm, hand.x, hand.y, hand.z, report):
        return 0
    count = arm_branches(arm, ranges, hand, reference, enforce, q, found, report, 0)
    concluded(found, JOINTS, count, report)
    return count


class Circle(NamedTuple):
    """Where the elbow is, seen from the shoulder, when the forearm lies along n and the frame stands at its place.

    Attributes:
        x: the frame, three numbers [m].
        y: see there.
        z: see there.
        nx: the direction n of the forearm, a unit vector.
        ny: see there.
        nz: see there.
        vx: a unit vector across, towards the middle of the circle.
        vy: see there.
        vz: see there.
        along: the middle of the circle along n [m].
        across: its distance from the line through the shoulder along n [m].
        radius: of the circle [m]: how far the frame is from the axis of the forearm.
    """

    x: float
    y: float
    z: float
    nx: float
    ny: float
    nz: float
    vx: float
    vy: float
    vz: float
    along: float
    across: float
    radius: float


@both_ways
def circle_of(arm: Arm, target: Row) -> Circle:
    """The circle of the elbow for the place of the frame and a direction that is not zero, six numbers."""
    nx, ny, nz = target[3], target[4], target[5]
    length = math.sqrt(nx * nx + ny * ny + nz * nz)
    nx, ny, nz = nx / length, ny / length, nz / length
    x, y, z = target[0] - arm.x, target[1] - arm.y, target[2] - arm.z
    ux, uy, uz = x - arm.hand_x * nx, y - arm.hand_x * ny, z - arm.hand_x * nz
    along = ux * nx + uy * ny + uz * nz
    vx, vy, vz = ux - along * nx, uy - along * ny, uz - along * nz
    across = math.sqrt(vx * vx + vy * vy + vz * vz)
    size = across
    if across <= _ON_AXIS:
        # Any direction across will do.
        sx, sy, sz = (1.0, 0.0, 0.0) if abs(nx) < 0.7 else (0.0, 1.0, 0.0)
        part = sx * nx + sy * ny + sz * nz
        vx, vy, vz = sx - part * nx, sy - part * ny, sz - part * nz
        size = math.sqrt(vx * vx + vy * vy + vz * vz)
    radius = math.sqrt(arm.hand_y * arm.hand_y + arm.hand_z * arm.hand_z)
    return Circle(x, y, z, nx, ny, nz, vx / size, vy / size, vz / size, along, across, radius)


@both_ways
def hand_on_circle(arm: Arm, circle: Circle, turn: float) -> Hand:
    """The pose of the hand with which the elbow is at an angle on its circle, from the side of the shoulder."""
    c, s = math.cos(turn), math.sin(turn)
    nx, ny, nz, vx, vy, vz = circle.nx, circle.ny, circle.nz, circle.vx, circle.vy, circle.vz
    # From the elbow's circle to the frame, and across to that and the direction.
    kx = c * vx + s * (ny * vz - nz * vy)
    ky = c * vy + s * (nz * vx - nx * vz)
    kz = c * vz + s * (nx * vy - ny * vx)
    ox, oy, oz = ny * kz - nz * ky, nz * kx - nx * kz, nx * ky - ny * kx
    beta = math.atan2(arm.hand_z, arm.hand_y)
    c, s = math.cos(beta), math.sin(beta)
    return Hand(
        nx, c * kx - s * ox, s * kx + c * ox,
        ny, c * ky - s * oy, s * ky + c * oy,
        nz, c * kz - s * oz, s * kz + c * oz,
        circle.x, circle.y, circle.z,
    )  # fmt: skip


@both_ways
def solve_direction(
    arm: Arm, ranges: Ranges, target: Row, reference: Row, enforce: bool, q: Row, found: Row, report: Row
) -> int:
    """All branches for the place of the frame and the direction of the forearm, six numbers.

    Where the circle of the elbow meets the sphere about the shoulder, the hand's whole orientation follows.
    """
    begun(report)
    if not abs(target[3]) + abs(target[4]) + abs(target[5]) > 0.0:
        report[REASON] = NOT_RIGID
        return 0
    circle = circle_of(arm, target)
    if out_of_reach(arm, circle.x, circle.y, circle.z, report):
        return 0
    upper = math.sqrt(arm.elbow_x * arm.elbow_x + arm.elbow_y * arm.elbow_y)
    near = math.sqrt(circle.along * circle.along + (circle.across - circle.radius) * (circle.across - circle.radius))
    far = math.sqrt(circle.along * circle.along + (circle.across + circle.radius) * (circle.across + circle.radius))
    if near > upper + _REACHED or far < upper - _REACHED:
        report[REASON] = NOT_ENOUGH_JOINTS
        return 0
    ahead, behind = max(0.0, (upper - near) * (upper + near)), max(0.0, (far - upper) * (far + upper))
    turn = 2.0 * math.atan2(math.sqrt(ahead), math.sqrt(behind))
    count = arm_branches(arm, ranges, hand_on_circle(arm, circle, turn), reference, enforce, q, found, report, 0)
    if _ONE_TURN < turn < math.pi - _ONE_TURN:
        hand = hand_on_circle(arm, circle, -turn)
        count = arm_branches(arm, ranges, hand, reference, enforce, q, found, report, count)
    concluded(found, JOINTS, count, report)
    return count


@both_ways
def arm_branches(
    arm: Arm, ranges: Ranges, hand: Hand, reference: Row, enforce: bool, q: Row, found: Row, report: Row, count: int
) -> int:
    """Enter the branches for a pose of the hand, if the elbow is where the arm can have it."""
    # The elbow, seen from the shoulder.
    wx = hand.x - (hand.r00 * arm.hand_x + hand.r01 * arm.hand_y + hand.r02 * arm.hand_z)
    wy = hand.y - (hand.r10 * arm.hand_x + hand.r11 * arm.hand_y + hand.r12 * arm.hand_z)
    wz = hand.z - (hand.r20 * arm.hand_x + hand.r21 * arm.hand_y + hand.r22 * arm.hand_z)
    upper = math.sqrt(arm.elbow_x * arm.elbow_x + arm.elbow_y * arm.elbow_y)
    if not abs(math.sqrt(wx * wx + wy * wy + wz * wz) - upper) <= _REACHED:
        report[REASON] = NOT_ENOUGH_JOINTS
        return count
    before = count
    count = _branches(arm, ranges, hand, (wx, wy, wz), reference, enforce, enforce, q, found, report, count)
    if count == before and enforce:
        # Which joint is in the way: all branches, to see which of them is nearest to the limits.
        count = _branches(arm, ranges, hand, (wx, wy, wz), reference, True, False, q, found, report, count)
    return count


@both_ways
def _branches(
    arm: Arm,
    ranges: Ranges,
    hand: Hand,
    elbow: tuple[float, float, float],
    reference: Row,
    enforce: bool,
    prune: bool,
    q: Row,
    found: Row,
    report: Row,
    count: int,
) -> int:
    """Enter all branches; with `prune` one is left as soon as a joint is seen outside its limits, without report."""
    wx, wy, wz = elbow
    aside = math.sqrt(wx * wx + wz * wz)
    epsilon = math.atan2(arm.elbow_y, arm.elbow_x)
    if aside <= _ON_AXIS:
        q[1] = wrapped(math.atan2(wy, aside) - epsilon)
        for other in range(2):
            count = _about_shoulder_axis(arm, ranges, hand, other, reference, enforce, q, found, report, count)
        return count
    for side in range(2):
        q[0] = math.atan2(-wz, wx) if side == 0 else math.atan2(wz, -wx)
        q[1] = wrapped(math.atan2(wy, aside if side == 0 else -aside) - epsilon)
        if prune and (is_outside(ranges, 0, q[0]) or is_outside(ranges, 1, q[1])):
            continue
        family = elbow_angles(ranges, hand, reference, enforce, q)
        for other in range(2 if family == _ALONE else 1):
            if other == 1:
                other_triple(q)
            if prune and not is_inside(ranges, q):
                continue
            if prune or admitted(ranges, enforce, q, report):
                errors = arm_errors(arm, hand, q)
                if errors[0] <= VERIFIED and errors[1] <= VERIFIED:
                    count = entered(reference, q, enforce, errors, family, found, count)
    return count


@both_ways
def elbow_angles(ranges: Ranges, hand: Hand, reference: Row, enforce: bool, q: Row) -> float:
    """The angles q₃ to q₅ from what the shoulder leaves of the hand's orientation; returns their family.

    With B = Rx(q₃) Rz(q₄) Rx(q₅), the first column of B is (cos q₄, cos q₃ sin q₄, sin q₃ sin q₄). The first turn is
    taken from it and undone; the other two follow from what is left, with every digit also beside lock.
    """
    c1, s1, c2, s2 = math.cos(q[0]), math.sin(q[0]), math.cos(q[1]), math.sin(q[1])
    # B = Rz(−q₂) Ry(−q₁) R
    a0, a1, a2 = c1 * hand.r00 - s1 * hand.r20, c1 * hand.r01 - s1 * hand.r21, c1 * hand.r02 - s1 * hand.r22
    b00 = c2 * a0 + s2 * hand.r10
    b10, b11, b12 = c2 * hand.r10 - s2 * a0, c2 * hand.r11 - s2 * a1, c2 * hand.r12 - s2 * a2
    b20 = s1 * hand.r00 + c1 * hand.r20
    b21 = s1 * hand.r01 + c1 * hand.r21
    b22 = s1 * hand.r02 + c1 * hand.r22
    sine = math.sqrt(b10 * b10 + b20 * b20)
    q[3] = math.atan2(sine, b00)
    if sine <= _PARALLEL:
        if b00 > 0.0:
            locked_pair(ranges, (2, 4), math.atan2(b21 - b12, b11 + b22), 1.0, reference, enforce, q)
        else:
            locked_pair(ranges, (2, 4), math.atan2(-b12 - b21, b22 - b11), -1.0, reference, enforce, q)
        return _ELBOW_LOCK
    q[2] = math.atan2(b20, b10)
    q[4] = math.atan2(b10 * b21 - b20 * b11, b10 * b22 - b20 * b12)
    return _ALONE


@both_ways
def other_triple(q: Row) -> None:
    """The angles that make the same orientation: Rx(q₃ + π) Rz(−q₄) Rx(q₅ + π)."""
    q[2], q[3], q[4] = wrapped(q[2] + math.pi), -q[3], wrapped(q[4] + math.pi)


@both_ways
def _about_shoulder_axis(
    arm: Arm,
    ranges: Ranges,
    hand: Hand,
    other: int,
    reference: Row,
    enforce: bool,
    q: Row,
    found: Row,
    report: Row,
    count: int,
) -> int:
    """Enter the member of a family with the elbow on the axis of ShoulderPitch, about which the arm may turn."""
    low, high = reference[0] - math.pi, reference[0] + math.pi
    if enforce:
        low, high = ranges.lower[0], ranges.upper[0]
    step = (high - low) / _STEPS
    best, at = math.inf, low
    for i in range(-1, _STEPS + 1):
        pitch = min(max(reference[0], low), high) if i < 0 else low + step * i
        cost = _cost_of_pitch(ranges, hand, other, pitch, reference, enforce, q)
        if cost < best:
            best, at = cost, pitch
    width = step
    for _ in range(_HALVINGS):
        for pitch in (max(low, at - width), min(high, at + width)):
            cost = _cost_of_pitch(ranges, hand, other, pitch, reference, enforce, q)
            if cost < best:
                best, at = cost, pitch
        width *= 0.5
    if _cost_of_pitch(ranges, hand, other, at, reference, enforce, q) == math.inf:
        return count
    if admitted(ranges, enforce, q, report):
        errors = arm_errors(arm, hand, q)
        if errors[0] <= VERIFIED and errors[1] <= VERIFIED:
            return entered(reference, q, enforce, errors, _SHOULDER_AXIS, found, count)
    return count


@both_ways
def _cost_of_pitch(
    ranges: Ranges, hand: Hand, other: int, pitch: float, reference: Row, enforce: bool, q: Row
) -> float:
    """What a member of the family is away from the reference; far more where it is outside the limits."""
    q[0] = pitch
    family = elbow_angles(ranges, hand, reference, enforce, q)
    if other == 1:
        if family != _ALONE:
            return math.inf  # the two triples belong to one family
        other_triple(q)
    outside = excess(ranges, q) if enforce else 0.0
    return distance(reference, q, JOINTS, enforce) if outside <= ROUNDING else 1e3 * (1.0 + outside)


@both_ways
def arm_errors(arm: Arm, hand: Hand, q: Row) -> tuple[float, float]:
    """How far the frame is from its target by forward kinematics: distance [m] and angle [rad]."""
    made = forward(arm, q)
    dx, dy, dz = made.x - hand.x, made.y - hand.y, made.z - hand.z
    a, b, c = made.r00 - hand.r00, made.r01 - hand.r01, made.r02 - hand.r02
    d, e, f = made.r10 - hand.r10, made.r11 - hand.r11, made.r12 - hand.r12
    g, h, i = made.r20 - hand.r20, made.r21 - hand.r21, made.r22 - hand.r22
    squares = a * a + b * b + c * c + d * d + e * e + f * f + g * g + h * h + i * i
    return math.sqrt(dx * dx + dy * dy + dz * dz), angle_of_chord(squares)


@both_ways
def forward(arm: Arm, q: Row) -> Hand:
    """Orientation of the hand and place of the frame, seen from the shoulder."""
    s1, c1, s2, c2 = math.sin(q[0]), math.cos(q[0]), math.sin(q[1]), math.cos(q[1])
    s3, c3, s4, c4 = math.sin(q[2]), math.cos(q[2]), math.sin(q[3]), math.cos(q[3])
    s5, c5 = math.sin(q[4]), math.cos(q[4])
    # The forearm in the upper arm, Rx(q₃) Rz(q₄), then the hand, … Rx(q₅).
    b00, b10, b20 = c4, c3 * s4, s3 * s4
    n01, n11, n21 = -s4, c3 * c4, s3 * c4
    b01, b11, b21 = n01 * c5, n11 * c5 - s3 * s5, n21 * c5 + c3 * s5
    b02, b12, b22 = -n01 * s5, -n11 * s5 - s3 * c5, c3 * c5 - n21 * s5
    mx = arm.elbow_x + b00 * arm.hand_x + b01 * arm.hand_y + b02 * arm.hand_z
    my = arm.elbow_y + b10 * arm.hand_x + b11 * arm.hand_y + b12 * arm.hand_z
    mz = b20 * arm.hand_x + b21 * arm.hand_y + b22 * arm.hand_z
    # Ry(q₁) Rz(q₂)
    u00, u10, u20 = c1 * c2, s2, -s1 * c2
    u01, u11, u21 = -c1 * s2, c2, s1 * s2
    return Hand(
        u00 * b00 + u01 * b10 + s1 * b20, u00 * b01 + u01 * b11 + s1 * b21, u00 * b02 + u01 * b12 + s1 * b22,
        u10 * b00 + u11 * b10, u10 * b01 + u11 * b11, u10 * b02 + u11 * b12,
        u20 * b00 + u21 * b10 + c1 * b20, u20 * b01 + u21 * b11 + c1 * b21, u20 * b02 + u21 * b12 + c1 * b22,
        u00 * mx + u01 * my + s1 * mz, u10 * mx + u11 * my, u20 * mx + u21 * my + c1 * mz,
    )  # fmt: skip
