"""`leg`: all branches of one leg for the pose of its foot."""

from __future__ import annotations

import math
from functools import partial
from typing import NamedTuple, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats
from nao_kin._kernels.cache import both_ways
from nao_kin.ik.compiling import Row, limb_types
from nao_kin.ik.geometry import (
    Limb,
    X,
    Y,
    chain_at_zero,
    check_side,
    found_for,
    kappa_of,
    kept_limb,
    limb_of,
    result_of,
    solved,
)
from nao_kin.ik.nearest_feet import brought_into_reach, missed, nearest_feet
from nao_kin.ik.ranges import (
    NEEDED,
    NOT_RIGID,
    OUT_OF_REACH,
    REASON,
    ROUNDING,
    VERIFIED,
    Ranges,
    admitted,
    angle_of_chord,
    begun,
    closed_form,
    concluded,
    distance,
    entered,
    excess,
    falls_short,
    is_inside,
    is_outside,
    locked_pair,
    rigid,
    table_range,
    wrapped,
)
from nao_kin.ik.results import Family, IKResult
from nao_kin.ik.targets import Limits, as_poses, as_reference, check_threads, is_enforced, refuse_not_rigid
from nao_kin.robot import RobotModel

# --- The leg: eight real branches from the pose of the foot.
#
# The axes of the three hip joints, a₁ = (0, cos κ, sin κ), x and y at zero, meet in the hip; those of KneePitch and
# AnklePitch are y; AnklePitch and AnkleRoll, about x, meet in the ankle. With F the orientation of the foot and h the
# hip as the foot sees it from the ankle,
#
#     h = Rx(−q₆) w,  w = L₁ (−sin(q₄ + q₅), cos(q₄ + q₅)) + L₂ (−sin q₅, cos q₅)  in the plane of x and z,
#     F = Rx(κ) Ry(q₁) Rx(q₂ − κ) Ry(q₃) · Ry(q₄ + q₅) Rx(q₆).
#
# |h| gives the knee (two signs), the direction of h the ankle's roll (two) and then its pitch, and what is left of F
# the three angles of the hip (two).

MOST_BRANCHES = 8
JOINTS = 6

_ALONE, _HIP_LOCK, _ANKLE_AXIS = float(Family.NONE), float(Family.HIP_LOCK), float(Family.ANKLE_AXIS)
# A distance [m] that rounding may add to the reach of the leg, and below which the hip is on the axis of AnkleRoll.
_ROUNDING = 1e-12
# A straight leg solves targets that are out of reach by up to this [m]: poses rounded to float32, for instance.
STRETCHED = 1e-6
# Below this the knee is stretched or folded: its angle is a square root, of which rounding leaves half the digits.
_STRAIGHT = 1e-7
# Sine of the angle between the axes of HipYawPitch and HipPitch up to which they are parallel.
_PARALLEL = 1e-12
# Steps of the search in a family, and halvings after it.
_STEPS, _HALVINGS = 180, 48
# Where the hip is nearer to the axis of AnkleRoll [m], rounding may put the roll outside its limits.
_NEAR_AXIS = 1e-5


class Leg(NamedTuple):
    """What the closed form needs to know of a leg.

    Attributes:
        hip_x: the hip in the torso, three numbers [m].
        hip_y: see there.
        hip_z: see there.
        kappa: the axis of HipYawPitch is (0, cos κ, sin κ) [rad].
        cos_kappa: see there.
        sin_kappa: see there.
        thigh: L₁, from hip to knee [m].
        tibia: L₂, from knee to ankle [m].
        turned: whether the frame that is asked for is turned against the foot, 0 or 1.
        a00: its rotation in the foot, nine numbers by rows.
        a01: see there.
        a02: see there.
        a10: see there.
        a11: see there.
        a12: see there.
        a20: see there.
        a21: see there.
        a22: see there.
        x: its origin in the foot, seen from the ankle, three numbers [m].
        y: see there.
        z: see there.
    """

    hip_x: float
    hip_y: float
    hip_z: float
    kappa: float
    cos_kappa: float
    sin_kappa: float
    thigh: float
    tibia: float
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
    x: float
    y: float
    z: float


class Foot(NamedTuple):
    """A target: orientation of the foot and place of the ankle, seen from the hip, in axes turned by κ about x."""

    f00: float
    f01: float
    f02: float
    f10: float
    f11: float
    f12: float
    f20: float
    f21: float
    f22: float
    x: float
    y: float
    z: float


@both_ways
def foot_of(leg: Leg, target: Row) -> tuple[bool, Foot]:
    """Whether a target is a rigid transform, and its foot."""
    fine, a, b, c, d, e, f, g, h, i = rigid(target)
    if leg.turned != 0.0:
        a, b, c = (
            a * leg.a00 + b * leg.a01 + c * leg.a02,
            a * leg.a10 + b * leg.a11 + c * leg.a12,
            a * leg.a20 + b * leg.a21 + c * leg.a22,
        )
        d, e, f = (
            d * leg.a00 + e * leg.a01 + f * leg.a02,
            d * leg.a10 + e * leg.a11 + f * leg.a12,
            d * leg.a20 + e * leg.a21 + f * leg.a22,
        )
        g, h, i = (
            g * leg.a00 + h * leg.a01 + i * leg.a02,
            g * leg.a10 + h * leg.a11 + i * leg.a12,
            g * leg.a20 + h * leg.a21 + i * leg.a22,
        )
    x = target[3] - leg.hip_x - (a * leg.x + b * leg.y + c * leg.z)
    y = target[7] - leg.hip_y - (d * leg.x + e * leg.y + f * leg.z)
    z = target[11] - leg.hip_z - (g * leg.x + h * leg.y + i * leg.z)
    C, S = leg.cos_kappa, leg.sin_kappa
    return fine, Foot(
        a, b, c,
        C * d + S * g, C * e + S * h, C * f + S * i,
        C * g - S * d, C * h - S * e, C * i - S * f,
        x, C * y + S * z, C * z - S * y,
    )  # fmt: skip


@both_ways
def within_reach(leg: Leg, foot: Foot, stretched: float) -> tuple[Foot, float]:
    """The foot with its ankle moved onto the reach of the leg, where it is out of it by up to `stretched`; how far."""
    far = math.sqrt(foot.x * foot.x + foot.y * foot.y + foot.z * foot.z)
    reached = min(max(far, abs(leg.thigh - leg.tibia)), leg.thigh + leg.tibia)
    short = abs(far - reached)
    if short <= _ROUNDING or short > stretched or far == 0.0:
        return foot, 0.0
    scale = reached / far
    return Foot(
        foot.f00, foot.f01, foot.f02,
        foot.f10, foot.f11, foot.f12,
        foot.f20, foot.f21, foot.f22,
        foot.x * scale, foot.y * scale, foot.z * scale,
    ), short  # fmt: skip


@both_ways
def knee_of(leg: Leg, foot: Foot, report: Row) -> tuple[float, int]:
    """The angle of the knee, and in how many ways it bends; none where the ankle is out of reach, which is reported."""
    far = math.sqrt(foot.x * foot.x + foot.y * foot.y + foot.z * foot.z)
    longest, shortest = leg.thigh + leg.tibia, abs(leg.thigh - leg.tibia)
    if far > longest + _ROUNDING or far < shortest - _ROUNDING:
        report[REASON] = OUT_OF_REACH
        report[NEEDED] = far - longest if far > longest else shortest - far
        return 0.0, 0
    stretched = math.sqrt(max(0.0, (longest - far) * (longest + far)))
    folded = math.sqrt(max(0.0, (far - shortest) * (far + shortest)))
    knee = 2.0 * math.atan2(stretched, folded)
    if knee < _STRAIGHT:
        return 0.0, 1
    if knee > math.pi - _STRAIGHT:
        return math.pi, 1
    return knee, 2


@both_ways
def solve_leg(
    leg: Leg,
    ranges: Ranges,
    target: Row,
    reference: Row,
    enforce: bool,
    q: Row,
    found: Row,
    report: Row,
) -> int:
    """All branches of a leg for the pose of its frame, rounded poses included; see `ranges` for the arguments."""
    return _solved(leg, ranges, target, STRETCHED, reference, enforce, q, found, report)


@both_ways
def solve_leg_exactly(
    leg: Leg,
    ranges: Ranges,
    target: Row,
    reference: Row,
    enforce: bool,
    q: Row,
    found: Row,
    report: Row,
) -> int:
    """As `solve_leg`, without the targets that are out of reach by less than `STRETCHED`."""
    return _solved(leg, ranges, target, 0.0, reference, enforce, q, found, report)


@both_ways
def _solved(
    leg: Leg,
    ranges: Ranges,
    target: Row,
    stretched: float,
    reference: Row,
    enforce: bool,
    q: Row,
    found: Row,
    report: Row,
) -> int:
    """All branches for a target that is out of reach by up to `stretched`."""
    begun(report)
    fine, foot = foot_of(leg, target)
    if not fine:
        report[REASON] = NOT_RIGID
        return 0
    foot, short = within_reach(leg, foot, stretched)
    knee = knee_of(leg, foot, report)
    if knee[1] == 0:
        return 0
    count = _branches(leg, ranges, foot, knee, reference, enforce, enforce, q, found, report)
    if count == 0 and enforce:
        # Which joint is in the way: all branches, to see which of them is nearest to the limits.
        count = _branches(leg, ranges, foot, knee, reference, True, False, q, found, report)
    falls_short(found, JOINTS, count, short)
    concluded(found, JOINTS, count, report)
    return count


@both_ways
def _branches(
    leg: Leg,
    ranges: Ranges,
    foot: Foot,
    knee: tuple[float, int],
    reference: Row,
    enforce: bool,
    prune: bool,
    q: Row,
    found: Row,
    report: Row,
) -> int:
    """Enter all branches, given the angle of the knee and in how many ways it bends.

    With `prune` a branch is left as soon as a joint is seen outside its limits, and nothing is reported of it.
    """
    # The hip, seen in the foot.
    hx = -(foot.f00 * foot.x + foot.f10 * foot.y + foot.f20 * foot.z)
    hy = -(foot.f01 * foot.x + foot.f11 * foot.y + foot.f21 * foot.z)
    hz = -(foot.f02 * foot.x + foot.f12 * foot.y + foot.f22 * foot.z)
    height = math.sqrt(hy * hy + hz * hz)
    count = 0
    sine, cosine = math.sin(knee[0]), math.cos(knee[0])
    if height <= _ROUNDING:
        for k in range(knee[1]):
            q[3] = knee[0] if k == 0 else -knee[0]
            if prune and is_outside(ranges, 3, q[3]):
                continue
            bx, bz = -leg.thigh * (sine if k == 0 else -sine), leg.tibia + leg.thigh * cosine
            q[4] = math.atan2(-bz * hx, bx * hx)
            for other in range(2):
                count = _about_ankle_axis(leg, ranges, foot, other, reference, enforce, q, found, report, count)
        return count
    near_axis = enforce and height < _NEAR_AXIS
    for side in range(2):
        wz = height if side == 0 else -height
        roll = math.atan2(hy, hz) if side == 0 else math.atan2(-hy, -hz)
        if prune and not near_axis and is_outside(ranges, 5, roll):
            continue
        s6, c6 = math.sin(roll), math.cos(roll)
        for k in range(knee[1]):
            q[3], s4 = (knee[0], sine) if k == 0 else (-knee[0], -sine)
            if prune and is_outside(ranges, 3, q[3]):
                continue
            bx, bz = -leg.thigh * s4, leg.tibia + leg.thigh * cosine
            q[4], q[5] = math.atan2(bx * wz - bz * hx, bx * hx + bz * wz), roll
            if prune and is_outside(ranges, 4, q[4]):
                continue
            if near_axis:
                _put_on_limit(ranges, height, q)
                if prune and is_outside(ranges, 5, q[5]):
                    continue
                s6, c6 = math.sin(q[5]), math.cos(q[5])
            turn = q[3] + q[4]
            ankle = math.sin(turn), math.cos(turn), s6, c6
            family = hip_angles(leg, ranges, foot, ankle, reference, enforce, q)
            errors = -1.0, -1.0
            for other in range(2 if family == _ALONE else 1):
                if other == 1:
                    other_triple(leg, q)
                if prune and not is_inside(ranges, q):
                    continue
                if prune or admitted(ranges, enforce, q, report):
                    if errors[0] < 0.0:  # both triples make the same rotation
                        errors = leg_errors(leg, foot, (s4, cosine), ankle, q)
                    if errors[0] <= VERIFIED and errors[1] <= VERIFIED:
                        count = entered(reference, q, enforce, errors, family, found, count)
    return count


@both_ways
def _ankle(q: Row) -> tuple[float, float, float, float]:
    """Sine and cosine of q₄ + q₅ and of q₆."""
    turn = q[3] + q[4]
    return math.sin(turn), math.cos(turn), math.sin(q[5]), math.cos(q[5])


@both_ways
def _put_on_limit(ranges: Ranges, height: float, q: Row) -> None:
    """AnkleRoll onto its limit, where the hip is so near its axis that the foot hardly moves."""
    low, high = ranges.lower[5], ranges.upper[5]
    if ranges.bends > 0:
        bounds = table_range(ranges, q[4])
        low, high = max(low, bounds[0]), min(high, bounds[1])
    inside = min(max(q[5], low), high)
    if abs(inside - q[5]) * height < _ROUNDING:
        q[5] = inside


@both_ways
def hip_angles(
    leg: Leg,
    ranges: Ranges,
    foot: Foot,
    ankle: tuple[float, float, float, float],
    reference: Row,
    enforce: bool,
    q: Row,
) -> float:
    """The hip's angles q₁ to q₃ from what knee and ankle leave of the foot's orientation; returns their family.

    With M = Ry(q₁) Rx(ρ) Ry(q₃), ρ = q₂ − κ, the second column of M is (sin q₁ sin ρ, cos ρ, cos q₁ sin ρ). The first
    turn is taken from it and undone; the other two follow from what is left, with every digit also beside lock.
    """
    s, c, sine, cosine = ankle
    # M = F Rx(−q₆) Ry(−q₄ − q₅), as far as it is needed.
    m01 = foot.f01 * cosine - foot.f02 * sine
    m11 = foot.f11 * cosine - foot.f12 * sine
    m21 = foot.f21 * cosine - foot.f22 * sine
    third0 = foot.f01 * sine + foot.f02 * cosine
    third2 = foot.f21 * sine + foot.f22 * cosine
    m00, m02 = foot.f00 * c + third0 * s, third0 * c - foot.f00 * s
    m20, m22 = foot.f20 * c + third2 * s, third2 * c - foot.f20 * s
    sin_rho = math.sqrt(m01 * m01 + m21 * m21)
    q[1] = wrapped(leg.kappa + math.atan2(sin_rho, m11))
    if sin_rho <= _PARALLEL:
        if m11 > 0.0:
            locked_pair(ranges, (0, 2), math.atan2(m02 - m20, m00 + m22), 1.0, reference, enforce, q)
        else:
            locked_pair(ranges, (0, 2), math.atan2(-m02 - m20, m00 - m22), -1.0, reference, enforce, q)
        return _HIP_LOCK
    q[0] = math.atan2(m01, m21)
    # Ry(−q₁) M, whose first row is (cos q₃, 0, sin q₃).
    q[2] = math.atan2(m21 * m02 - m01 * m22, m21 * m00 - m01 * m20)
    return _ALONE


@both_ways
def other_triple(leg: Leg, q: Row) -> None:
    """The hip's angles that make the same orientation: Ry(q₁ + π) Rx(−ρ) Ry(q₃ + π)."""
    q[0], q[1], q[2] = wrapped(q[0] + math.pi), wrapped(2.0 * leg.kappa - q[1]), wrapped(q[2] + math.pi)


@both_ways
def _about_ankle_axis(
    leg: Leg,
    ranges: Ranges,
    foot: Foot,
    other: int,
    reference: Row,
    enforce: bool,
    q: Row,
    found: Row,
    report: Row,
    count: int,
) -> int:
    """Enter the member of a family with the hip on the axis of AnkleRoll: every q₆ meets the pose with its own hip."""
    low, high = reference[5] - math.pi, reference[5] + math.pi
    if enforce:
        low, high = ranges.lower[5], ranges.upper[5]
        if ranges.bends > 0:
            bounds = table_range(ranges, q[4])
            low, high = max(low, bounds[0]), max(low, min(high, bounds[1]))
    step = (high - low) / _STEPS
    best, at = math.inf, low
    # The reference's own roll is tried too: an axis that is met within rounding does not change a member that fits.
    for i in range(-1, _STEPS + 1):
        roll = min(max(reference[5], low), high) if i < 0 else low + step * i
        cost = _cost_of_roll(leg, ranges, foot, other, roll, reference, enforce, q)
        if cost < best:
            best, at = cost, roll
    width = step
    for _ in range(_HALVINGS):
        for roll in (max(low, at - width), min(high, at + width)):
            cost = _cost_of_roll(leg, ranges, foot, other, roll, reference, enforce, q)
            if cost < best:
                best, at = cost, roll
        width *= 0.5
    if _cost_of_roll(leg, ranges, foot, other, at, reference, enforce, q) == math.inf:
        return count
    if admitted(ranges, enforce, q, report):
        errors = leg_errors(leg, foot, (math.sin(q[3]), math.cos(q[3])), _ankle(q), q)
        if errors[0] <= VERIFIED and errors[1] <= VERIFIED:
            return entered(reference, q, enforce, errors, _ANKLE_AXIS, found, count)
    return count


@both_ways
def _cost_of_roll(
    leg: Leg,
    ranges: Ranges,
    foot: Foot,
    other: int,
    roll: float,
    reference: Row,
    enforce: bool,
    q: Row,
) -> float:
    """What a member of the family is away from the reference; far more where it is outside the limits."""
    q[5] = roll
    family = hip_angles(leg, ranges, foot, _ankle(q), reference, enforce, q)
    if other == 1:
        if family != _ALONE:
            return math.inf  # the two triples belong to one family
        other_triple(leg, q)
    outside = excess(ranges, q) if enforce else 0.0
    return distance(reference, q, JOINTS, enforce) if outside <= ROUNDING else 1e3 * (1.0 + outside)


@both_ways
def leg_errors(
    leg: Leg, foot: Foot, knee: tuple[float, float], ankle: tuple[float, float, float, float], q: Row
) -> tuple[float, float]:
    """How far the frame is from its target by forward kinematics: distance [m] and angle [rad].

    The sines and cosines of the knee and those of `_ankle` are given, for two triples of the hip share them.
    """
    s1, c1 = math.sin(q[0]), math.cos(q[0])
    rho = q[1] - leg.kappa
    s2, c2 = math.sin(rho), math.cos(rho)
    s3, c3 = math.sin(q[2]), math.cos(q[2])
    s4, c4 = knee
    s5, c5, s6, c6 = ankle
    # M = Ry(q₁) Rx(ρ) Ry(q₃)
    b0, b2 = s1 * c2, c1 * c2
    m01, m11, m21 = s1 * s2, c2, c1 * s2
    m00, m10, m20 = c1 * c3 - b0 * s3, s2 * s3, -s1 * c3 - b2 * s3
    m02, m12, m22 = c1 * s3 + b0 * c3, -s2 * c3, b2 * c3 - s1 * s3
    # The ankle, in the axes of the thigh.
    vx, vz = -leg.tibia * s4, -leg.thigh - leg.tibia * c4
    dx, dy, dz = m00 * vx + m02 * vz - foot.x, m10 * vx + m12 * vz - foot.y, m20 * vx + m22 * vz - foot.z
    # The foot, M Ry(q₄ + q₅) Rx(q₆), against its target.
    e00, e10, e20 = m00 * c5 - m02 * s5 - foot.f00, m10 * c5 - m12 * s5 - foot.f10, m20 * c5 - m22 * s5 - foot.f20
    n02, n12, n22 = m00 * s5 + m02 * c5, m10 * s5 + m12 * c5, m20 * s5 + m22 * c5
    e01, e11, e21 = m01 * c6 + n02 * s6 - foot.f01, m11 * c6 + n12 * s6 - foot.f11, m21 * c6 + n22 * s6 - foot.f21
    e02, e12, e22 = n02 * c6 - m01 * s6 - foot.f02, n12 * c6 - m11 * s6 - foot.f12, n22 * c6 - m21 * s6 - foot.f22
    dx += e00 * leg.x + e01 * leg.y + e02 * leg.z
    dy += e10 * leg.x + e11 * leg.y + e12 * leg.z
    dz += e20 * leg.x + e21 * leg.y + e22 * leg.z
    squares = e00 * e00 + e10 * e10 + e20 * e20 + e01 * e01 + e11 * e11 + e21 * e21
    squares += e02 * e02 + e12 * e12 + e22 * e22
    return math.sqrt(dx * dx + dy * dy + dz * dz), angle_of_chord(squares)


# --- `leg`: all branches of one leg for the pose of its foot, by the closed form of `leg_equations`.

_JOINTS = ("HipYawPitch", "HipRoll", "HipPitch", "KneePitch", "AnklePitch", "AnkleRoll")


def leg(
    robot: RobotModel,
    side: str,
    T_torso_foot: ArrayLike,
    *,
    frame: str | None = None,
    reference: ArrayLike | None = None,
    limits: Limits = "enforce",
    threads: SupportsIndex | None = None,
) -> IKResult:
    """All joint values of a leg with which its foot has a given pose: up to eight branches, each verified.

    Where the target is not met, `best` and `q` are the nearest joint values that a search finds, inside the limits if
    these are enforced: with the smallest √(distance² + (0.1 m · angle)²); `residual` has the distance and the angle.

    Both legs share the motor of their HipYawPitch: a solution of the right leg sets the coordinate LHipYawPitch, and
    with it moves the left leg.

    Args:
        robot: a NAO of any version, or another robot with legs of its geometry.
        side: "L" or "R".
        T_torso_foot: the pose of the frame in the torso, shape (..., 4, 4) [m].
        frame: a frame on the foot; None for the end effector "LLeg" or "RLeg".
        reference: configurations that broadcast with the targets, shape (..., nq): solutions are sorted by their
            distance to it, and take from it the joints that are not of this leg. None for all joints at zero, or at
            the limit nearest to it.
        limits: "enforce" leaves out branches with a joint outside its own or a coupled limit; "ignore" gives all, each
            joint with the whole turns that bring it within half a turn of the reference.
        threads: how many threads may work on a batch; None for all cores where that is worthwhile.

    Returns:
        Solutions to within 1e-10 m and rad, the errors in `residual`: of the rotation nearest to the one of the target,
        so that rounded poses, to float32 for instance, are met too. For the same reason a straight leg solves a target
        that is out of its reach by up to 1e-6 m, and `residual` says by how much. A family of solutions is there once,
        by its member that is inside the limits and nearest to the reference: the hip at lock (`HIP_LOCK`), or the hip
        on the axis of AnkleRoll (`ANKLE_AXIS`). A knee within 1e-7 rad of straight is straight: its two branches are
        one.

    Raises:
        UnknownName: no such side, frame or policy.
        BadArgument: the robot has no such leg; the message says what is missing. Or the last row of a target is not
            0, 0, 0, 1, or a number is beyond ±1e150.
        NotARotation: a target has no rotation; names the argument, its index and its defect.
        WrongShape, NotFinite: arrays of other shapes, NaN or infinity.

    Source: the derivation is in docs/inverse_kinematics.md.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = nao.posture("StandInit")
        >>> result = nk.ik.leg(nao, "L", nao.fk(q, "LLeg"))
        >>> bool(result.success), result.solutions.shape
        (True, (1, 25))
    """
    limb = leg_limb(robot, check_side(side), frame)
    T = as_poses(T_torso_foot, "T_torso_foot")
    enforce, workers, batch = is_enforced(limits), check_threads(threads), T.shape[:-2]
    references = as_reference(robot, limb.rest, reference, batch, enforce)
    targets = T.reshape(*batch, 16)
    refuse = partial(refuse_not_rigid, T, "T_torso_foot")
    found = found_for(_LEG, limb, targets, references[0], enforce, workers, refuse)
    result = result_of(limb, batch, found, references)
    if not found.is_complete:
        away = missed(result)
        near = np.broadcast_to(references[0], (*batch, robot.nq))[away]
        result.best[away], result.residual[away] = nearest_foot(robot, limb, T[away], near, enforce, workers)
    return result


def nearest_foot(
    robot: RobotModel, limb: Limb, T: Floats, reference: Floats, enforce: bool, threads: int | None
) -> tuple[Floats, Floats]:
    """Coordinates nearest to n targets, and their errors, shape (n, 2), as `nearest_feet`."""
    starts = _branches_in_reach(robot, limb, T)
    best, errors = nearest_feet(robot, (limb.frame,), limb, T[:, None], reference, starts, enforce, threads)
    return best, errors[:, 0]


def _branches_in_reach(robot: RobotModel, limb: Limb, T: Floats) -> list[Floats]:
    """The coordinates of all branches for n targets brought into reach, each of shape (n, c); whatever the limits."""
    targets = brought_into_reach(limb.numbers, T).reshape(-1, 16)
    references = np.broadcast_to(limb.rest, (len(T), robot.nq)), ()
    if len(T) == 1:
        found = solved(_LEG, limb, targets[0], (limb.rest, ()), False, None, lambda: None).branches[None]
    else:
        found = solved(_LEG, limb, targets, references, False, None, lambda: None).branches
    branches = np.where(np.isnan(found), limb.rest[limb.index], found)
    return list(branches.swapaxes(0, 1))


def leg_limb(robot: RobotModel, side: str, frame: str | None) -> Limb:
    """A leg of a robot as the closed form takes it.

    Raises:
        BadArgument: the robot has none of this geometry.
        UnknownName: no such frame.
    """
    return kept_limb(robot, _leg_of, side, f"{side}Leg" if frame is None else frame)


def _leg_of(robot: RobotModel, side: str, frame: str) -> Limb:
    chain = chain_at_zero(robot, "leg", tuple(side + joint for joint in _JOINTS), frame)
    for index, axis in ((1, X), (2, Y), (3, Y), (4, Y), (5, X)):
        chain.require_axis(index, axis)
    kappa = kappa_of(chain.axes[0])
    chain.require_axis(0, (0.0, float(np.cos(kappa)), float(np.sin(kappa))))
    chain.require_meeting(0, 1)
    chain.require_meeting(0, 2)
    chain.require_meeting(4, 5)
    hip, knee, ankle = chain.points[0], chain.points[3], chain.points[4]
    thigh, tibia = hip - knee, knee - ankle
    chain.require_zero("knee and ankle are not below the hip", np.concatenate([thigh[:2], tibia[:2]]))
    if min(thigh[2], tibia[2]) <= 0.0:
        raise chain.missing("knee and ankle are not below the hip")
    turned = 0.0 if np.array_equal(chain.rotation, np.eye(3)) else 1.0
    numbers = (*hip, kappa, *chain.axes[0][1:], thigh[2], tibia[2], turned)
    rest = (*chain.rotation.ravel(), *(chain.point - ankle))
    return limb_of(chain, frame, Leg(*(float(value) for value in (*numbers, *rest))))


_LEG = closed_form("legs", solve_leg, lambda: limb_types(Leg, JOINTS), MOST_BRANCHES, alone=solve_leg)
