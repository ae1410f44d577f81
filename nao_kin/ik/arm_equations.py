"""The arm: four real branches for a feasible pose of the hand, and up to eight for its position and direction.

ShoulderPitch about y and ShoulderRoll about z meet in the shoulder; ElbowYaw about x, ElbowRoll about z and WristYaw
about x meet in the elbow, at e = (e_x, e_y, 0) in the upper arm. With h from elbow to frame, in the axes of the hand,

    R = Ry(q₁) Rz(q₂) Rx(q₃) Rz(q₄) Rx(q₅),  p = shoulder + Ry(q₁) Rz(q₂) e + R h.

The pose determines the elbow, p − R h, which must be at |e| from the shoulder. The direction of the elbow from
the shoulder gives the shoulder joints (two solutions), and the rest of R the three others (two solutions).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from nao_kin._kernels.cache import Row, both_ways
from nao_kin.ik.branches import (
    NEEDED,
    NOT_ENOUGH_JOINTS,
    NOT_RIGID,
    OUT_OF_REACH,
    REASON,
    Pose,
    Rotation,
    Selection,
    Vector,
    Workspace,
    add_branch,
    angle_of_chord,
    branch_cost,
    check_limits,
    finish_report,
    is_inside,
    is_outside,
    least,
    link_rotation,
    locked_pair,
    start_report,
    wrapped,
)
from nao_kin.ik.results import Family

JOINTS = 5
MAX_BRANCHES = 8

_ALONE, _ELBOW_LOCK = float(Family.NONE), float(Family.ELBOW_LOCK)
_SHOULDER_AXIS = float(Family.SHOULDER_AXIS)
# Tolerances of the elbow [m]: of its distance to the shoulder, and to the axis of ShoulderPitch.
_REACHED, _ON_AXIS = 1e-11, 1e-12
# Sine of ElbowRoll up to which the axes of ElbowYaw and WristYaw coincide.
_PARALLEL = 1e-12
# Within this angle of zero or of half a turn, the elbow's two positions on its circle coincide [rad].
_ONE_TURN = 1e-7
# Steps of the search in a family.
_STEPS = 180


class Arm(NamedTuple):
    """The geometry of an arm: shoulder in the torso, elbow in the upper arm, frame in the hand from the elbow [m]."""

    shoulder: Vector
    elbow_x: float
    elbow_y: float
    turned: float  # 1 if the frame is rotated in the hand
    rotation: Rotation
    place: Vector


@both_ways
def hand_of(arm: Arm, target: Row) -> tuple[bool, Pose]:
    """Return whether a pose is rigid, the hand's rotation, and the frame's position from the shoulder."""
    is_rigid, (a, b, c, d, e, f, g, h, i) = link_rotation(arm, target)
    x, y, z = arm.shoulder
    return is_rigid, Pose(a, b, c, d, e, f, g, h, i, target[3] - x, target[7] - y, target[11] - z)


@both_ways
def elbow_of(arm: Arm, hand: Pose) -> Vector:
    """Return the position of the elbow from the shoulder for a pose of the hand."""
    x, y, z = arm.place
    return (
        hand.x - (hand.r00 * x + hand.r01 * y + hand.r02 * z),
        hand.y - (hand.r10 * x + hand.r11 * y + hand.r12 * z),
        hand.z - (hand.r20 * x + hand.r21 * y + hand.r22 * z),
    )


@both_ways
def upper_arm(arm: Arm) -> float:
    """Return the length of the upper arm [m]."""
    return math.sqrt(arm.elbow_x * arm.elbow_x + arm.elbow_y * arm.elbow_y)


@both_ways
def out_of_reach(arm: Arm, x: float, y: float, z: float, report: Row) -> bool:
    """Return whether a position from the shoulder is out of reach of the frame; if so, report by how much."""
    hx, hy, hz = arm.place
    upper, lower, far = upper_arm(arm), math.sqrt(hx * hx + hy * hy + hz * hz), math.sqrt(x * x + y * y + z * z)
    beyond = max(far - upper - lower, abs(upper - lower) - far)
    if beyond <= _ON_AXIS:
        return False
    report[REASON], report[NEEDED] = OUT_OF_REACH, beyond
    return True


@both_ways
def solve_arm(arm: Arm, target: Row, selection: Selection, work: Workspace) -> int:
    """Find all branches of an arm for the pose of its frame, as `branches` describes."""
    start_report(work.report)
    is_rigid, hand = hand_of(arm, target)
    if not is_rigid:
        work.report[REASON] = NOT_RIGID
        return 0
    if out_of_reach(arm, hand.x, hand.y, hand.z, work.report):
        return 0
    count = _add_for_hand(arm, hand, selection, work, 0)
    finish_report(work, JOINTS, count)
    return count


class Circle(NamedTuple):
    """The circle of the elbow, relative to the shoulder, for a position of the frame and a direction n of the forearm.

    Its centre is along · n + across · v [m], with v perpendicular to n; its radius is the distance of the frame from
    the axis of the forearm [m].
    """

    frame: Vector
    n: Vector
    v: Vector
    along: float
    across: float
    radius: float


@both_ways
def circle_of(arm: Arm, target: Row) -> Circle:
    """Return the circle of the elbow for the position of the frame and a direction, six numbers."""
    nx, ny, nz = target[3], target[4], target[5]
    length = math.sqrt(nx * nx + ny * ny + nz * nz)
    nx, ny, nz = nx / length, ny / length, nz / length
    x, y, z = target[0] - arm.shoulder[0], target[1] - arm.shoulder[1], target[2] - arm.shoulder[2]
    hx, hy, hz = arm.place
    ux, uy, uz = x - hx * nx, y - hx * ny, z - hx * nz
    along = ux * nx + uy * ny + uz * nz
    vx, vy, vz = ux - along * nx, uy - along * ny, uz - along * nz
    across = math.sqrt(vx * vx + vy * vy + vz * vz)
    size = across
    if across <= _ON_AXIS:
        # Any perpendicular direction will do.
        sx, sy, sz = (1.0, 0.0, 0.0) if abs(nx) < 0.7 else (0.0, 1.0, 0.0)
        part = sx * nx + sy * ny + sz * nz
        vx, vy, vz = sx - part * nx, sy - part * ny, sz - part * nz
        size = math.sqrt(vx * vx + vy * vy + vz * vz)
    radius = math.sqrt(hy * hy + hz * hz)
    return Circle((x, y, z), (nx, ny, nz), (vx / size, vy / size, vz / size), along, across, radius)


@both_ways
def hand_on_circle(arm: Arm, circle: Circle, turn: float) -> Pose:
    """Return the pose of the hand for an angle of the elbow on its circle, zero on the side of the shoulder."""
    c, s = math.cos(turn), math.sin(turn)
    (nx, ny, nz), (vx, vy, vz) = circle.n, circle.v
    # k from the elbow's circle to the frame, and o = n × k.
    kx = c * vx + s * (ny * vz - nz * vy)
    ky = c * vy + s * (nz * vx - nx * vz)
    kz = c * vz + s * (nx * vy - ny * vx)
    ox, oy, oz = ny * kz - nz * ky, nz * kx - nx * kz, nx * ky - ny * kx
    beta = math.atan2(arm.place[2], arm.place[1])
    c, s = math.cos(beta), math.sin(beta)
    x, y, z = circle.frame
    return Pose(
        nx, c * kx - s * ox, s * kx + c * ox,
        ny, c * ky - s * oy, s * ky + c * oy,
        nz, c * kz - s * oz, s * kz + c * oz,
        x, y, z,
    )  # fmt: skip


@both_ways
def solve_direction(arm: Arm, target: Row, selection: Selection, work: Workspace) -> int:
    """Find all branches for the position of the frame and the direction of the forearm, six numbers.

    Each intersection of the elbow's circle and the sphere about the shoulder gives an orientation of the hand.
    """
    report = work.report
    start_report(report)
    if not abs(target[3]) + abs(target[4]) + abs(target[5]) > 0.0:
        report[REASON] = NOT_RIGID
        return 0
    circle = circle_of(arm, target)
    x, y, z = circle.frame
    if out_of_reach(arm, x, y, z, report):
        return 0
    upper = upper_arm(arm)
    near = math.sqrt(circle.along * circle.along + (circle.across - circle.radius) * (circle.across - circle.radius))
    far = math.sqrt(circle.along * circle.along + (circle.across + circle.radius) * (circle.across + circle.radius))
    if near > upper + _REACHED or far < upper - _REACHED:
        report[REASON] = NOT_ENOUGH_JOINTS
        return 0
    ahead, behind = max(0.0, (upper - near) * (upper + near)), max(0.0, (far - upper) * (far + upper))
    turn = 2.0 * math.atan2(math.sqrt(ahead), math.sqrt(behind))
    count = _add_for_hand(arm, hand_on_circle(arm, circle, turn), selection, work, 0)
    if _ONE_TURN < turn < math.pi - _ONE_TURN:
        count = _add_for_hand(arm, hand_on_circle(arm, circle, -turn), selection, work, count)
    finish_report(work, JOINTS, count)
    return count


@both_ways
def _add_for_hand(arm: Arm, hand: Pose, selection: Selection, work: Workspace, before: int) -> int:
    """Add the branches for a pose of the hand, if the elbow is at the right distance from the shoulder."""
    x, y, z = elbow_of(arm, hand)
    if not abs(math.sqrt(x * x + y * y + z * z) - upper_arm(arm)) <= _REACHED:
        work.report[REASON] = NOT_ENOUGH_JOINTS
        return before
    count = _branches(arm, hand, selection, selection.enforce, work, before)
    if count == before and selection.enforce:
        # No branch is inside the limits: find the one nearest to them, which gives the reason.
        count = _branches(arm, hand, selection, False, work, count)
    return count


@both_ways
def _branches(arm: Arm, hand: Pose, selection: Selection, prune: bool, work: Workspace, count: int) -> int:
    """Add all branches; with `prune`, drop a branch, and report nothing, as soon as a joint is outside its limits."""
    ranges, q = selection.ranges, work.q
    wx, wy, wz = elbow_of(arm, hand)
    aside = math.sqrt(wx * wx + wz * wz)
    if aside <= _ON_AXIS:
        q[1] = wrapped(math.atan2(wy, aside) - math.atan2(arm.elbow_y, arm.elbow_x))
        for other in range(2):
            count = _add_about_shoulder_axis(arm, hand, other, selection, work, count)
        return count
    for side in range(2):
        write_shoulder(arm, (wx, wy, wz), side, q)
        if prune and (is_outside(ranges, 0, q[0]) or is_outside(ranges, 1, q[1])):
            continue
        family = write_elbow(hand, selection, q)
        for other in range(2 if family == _ALONE else 1):
            if other == 1:
                write_other_elbow(q)
            if prune and not is_inside(ranges, q):
                continue
            if prune or check_limits(selection, q, work.report):
                count = add_branch(selection, work, _errors(arm, hand, q), family, count)
    return count


@both_ways
def write_shoulder(arm: Arm, elbow: Vector, side: int, q: Row) -> None:
    """Write q₁ and q₂ for a direction of the elbow, one of two solutions."""
    x, y, z = elbow
    aside = math.sqrt(x * x + z * z)
    q[0] = math.atan2(-z, x) if side == 0 else math.atan2(z, -x)
    q[1] = wrapped(math.atan2(y, aside if side == 0 else -aside) - math.atan2(arm.elbow_y, arm.elbow_x))


@both_ways
def write_elbow(hand: Pose, selection: Selection, q: Row) -> float:
    """Write q₃ to q₅ for the hand's orientation and given q₁ and q₂; return their family.

    The first column of B = Rx(q₃) Rz(q₄) Rx(q₅) is (cos q₄, cos q₃ sin q₄, sin q₃ sin q₄). It gives q₃; the other two
    follow from Rx(−q₃) B, to full precision near lock too.
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
            locked_pair((2, 4), math.atan2(b21 - b12, b11 + b22), 1.0, selection, q)
        else:
            locked_pair((2, 4), math.atan2(-b12 - b21, b22 - b11), -1.0, selection, q)
        return _ELBOW_LOCK
    q[2] = math.atan2(b20, b10)
    q[4] = math.atan2(b10 * b21 - b20 * b11, b10 * b22 - b20 * b12)
    return _ALONE


@both_ways
def write_other_elbow(q: Row) -> None:
    """Replace q₃ to q₅ by the other solution, Rx(q₃ + π) Rz(−q₄) Rx(q₅ + π)."""
    q[2], q[3], q[4] = wrapped(q[2] + math.pi), -q[3], wrapped(q[4] + math.pi)


@both_ways
def _add_about_shoulder_axis(
    arm: Arm, hand: Pose, other: int, selection: Selection, work: Workspace, count: int
) -> int:
    """Add the best member of the family with the elbow on the axis of ShoulderPitch, about which the arm may turn."""
    near = selection.reference[0]
    low, high = near - math.pi, near + math.pi
    if selection.enforce:
        low, high = selection.ranges.lower[0], selection.ranges.upper[0]
    given = hand, other, selection, work.q
    pitch = least(_cost_of_pitch, given, low, high, near, _STEPS)
    if _cost_of_pitch(given, pitch) < math.inf and check_limits(selection, work.q, work.report):
        count = add_branch(selection, work, _errors(arm, hand, work.q), _SHOULDER_AXIS, count)
    return count


@both_ways
def _cost_of_pitch(given: tuple[Pose, int, Selection, Row], pitch: float) -> float:
    """Write a member of the family into q; return its cost."""
    hand, other, selection, q = given
    q[0] = pitch
    family = write_elbow(hand, selection, q)
    if other == 1:
        if family != _ALONE:
            return math.inf  # both solutions belong to one family
        write_other_elbow(q)
    return branch_cost(selection, q)


@both_ways
def _errors(arm: Arm, hand: Pose, q: Row) -> tuple[float, float]:
    """Return the error of the frame by forward kinematics: distance [m] and angle [rad]."""
    made = forward(arm, q)
    dx, dy, dz = made.x - hand.x, made.y - hand.y, made.z - hand.z
    a, b, c = made.r00 - hand.r00, made.r01 - hand.r01, made.r02 - hand.r02
    d, e, f = made.r10 - hand.r10, made.r11 - hand.r11, made.r12 - hand.r12
    g, h, i = made.r20 - hand.r20, made.r21 - hand.r21, made.r22 - hand.r22
    squares = a * a + b * b + c * c + d * d + e * e + f * f + g * g + h * h + i * i
    return math.sqrt(dx * dx + dy * dy + dz * dz), angle_of_chord(squares)


@both_ways
def forward(arm: Arm, q: Row) -> Pose:
    """Return the orientation of the hand and the position of the frame, from the shoulder."""
    s1, c1, s2, c2 = math.sin(q[0]), math.cos(q[0]), math.sin(q[1]), math.cos(q[1])
    s3, c3, s4, c4 = math.sin(q[2]), math.cos(q[2]), math.sin(q[3]), math.cos(q[3])
    s5, c5 = math.sin(q[4]), math.cos(q[4])
    # The forearm in the upper arm, Rx(q₃) Rz(q₄), then the hand, … Rx(q₅).
    b00, b10, b20 = c4, c3 * s4, s3 * s4
    n01, n11, n21 = -s4, c3 * c4, s3 * c4
    b01, b11, b21 = n01 * c5, n11 * c5 - s3 * s5, n21 * c5 + c3 * s5
    b02, b12, b22 = -n01 * s5, -n11 * s5 - s3 * c5, c3 * c5 - n21 * s5
    hx, hy, hz = arm.place
    mx = arm.elbow_x + b00 * hx + b01 * hy + b02 * hz
    my = arm.elbow_y + b10 * hx + b11 * hy + b12 * hz
    mz = b20 * hx + b21 * hy + b22 * hz
    # Ry(q₁) Rz(q₂)
    u00, u10, u20 = c1 * c2, s2, -s1 * c2
    u01, u11, u21 = -c1 * s2, c2, s1 * s2
    return Pose(
        u00 * b00 + u01 * b10 + s1 * b20, u00 * b01 + u01 * b11 + s1 * b21, u00 * b02 + u01 * b12 + s1 * b22,
        u10 * b00 + u11 * b10, u10 * b01 + u11 * b11, u10 * b02 + u11 * b12,
        u20 * b00 + u21 * b10 + c1 * b20, u20 * b01 + u21 * b11 + c1 * b21, u20 * b02 + u21 * b12 + c1 * b22,
        u00 * mx + u01 * my + s1 * mz, u10 * mx + u11 * my, u20 * mx + u21 * my + c1 * mz,
    )  # fmt: skip
