"""`leg`: all branches of one leg for the pose of its foot: the call, what is read off the robot, and the equations."""

from __future__ import annotations

import math
from functools import partial
from typing import NamedTuple, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats
from nao_kin._kernels.cache import both_ways
from nao_kin.ik.compiling import Row
from nao_kin.ik.descent import FrameMotion, Goal, descended
from nao_kin.ik.geometry import (
    ClosedForm,
    Limb,
    X,
    Y,
    chain_at_zero,
    check_side,
    found_for,
    kept_limb,
    limb_of,
    limb_types,
    result_of,
    torso_in_trunk,
)
from nao_kin.ik.ranges import (
    MOST_TURNED,
    NEEDED,
    NOT_RIGID,
    OUT_OF_REACH,
    REASON,
    Pose,
    Rotation,
    Selection,
    Vector,
    Workspace,
    add_branch,
    add_shortfall,
    angle_of_chord,
    branch_cost,
    check_limits,
    coupled_range,
    finish_report,
    is_inside,
    is_outside,
    link_rotation,
    locked_pair,
    start_report,
    wrapped,
)
from nao_kin.ik.results import Family, IKResult
from nao_kin.ik.searches import least
from nao_kin.ik.targets import Limits, as_poses, as_reference, check_threads, is_enforced, refuse_not_rigid
from nao_kin.robot import RobotModel
from nao_kin.rotations import log, nearest_rotation

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


# --- What the closed form needs to know of a leg, read off a robot.


class Leg(NamedTuple):
    """What the closed form needs to know of a leg.

    Attributes:
        hip: the hip in the torso [m].
        kappa: the axis of HipYawPitch is (0, cos κ, sin κ) [rad].
        cos_kappa: the y of this axis.
        sin_kappa: its z.
        thigh: L₁, from hip to knee [m].
        tibia: L₂, from knee to ankle [m].
        stretched: how far a target may be out of reach of the straight leg [m].
        turned: whether the frame that is asked for is turned against the foot, 0 or 1.
        rotation: its rotation in the foot, nine numbers by rows.
        place: its origin in the foot, seen from the ankle [m].
    """

    hip: Vector
    kappa: float
    cos_kappa: float
    sin_kappa: float
    thigh: float
    tibia: float
    stretched: float
    turned: float
    rotation: Rotation
    place: Vector


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
    _, cosine, sine = chain.axes[0].tolist()
    kappa = math.atan2(sine, cosine)
    chain.require_axis(0, (0.0, math.cos(kappa), math.sin(kappa)))
    chain.require_meeting(0, 1)
    chain.require_meeting(0, 2)
    chain.require_meeting(4, 5)
    hip, knee, ankle = chain.points[0], chain.points[3], chain.points[4]
    thigh, tibia = hip - knee, knee - ankle
    chain.require_zero("knee and ankle are not below the hip", np.concatenate([thigh[:2], tibia[:2]]))
    if min(thigh[2], tibia[2]) <= 0.0:
        raise chain.missing("knee and ankle are not below the hip")
    lengths = float(thigh[2]), float(tibia[2])
    turned, rotation, place = chain.frame_in_link(ankle)
    numbers = Leg(tuple(hip.tolist()), kappa, cosine, sine, *lengths, _STRETCHED, turned, rotation, place)
    return limb_of(chain, frame, numbers)


# --- Eight real branches from the pose of the foot.
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
_STRETCHED = 1e-6
# Below this the knee is stretched or folded: its angle is a square root, of which rounding leaves half the digits.
_STRAIGHT = 1e-7
# Sine of the angle between the axes of HipYawPitch and HipPitch up to which they are parallel.
_PARALLEL = 1e-12
# Steps of the search in a family.
_STEPS = 180
# Where the hip is nearer to the axis of AnkleRoll [m], rounding may put the roll outside its limits.
_NEAR_AXIS = 1e-5


@both_ways
def foot_of(leg: Leg, target: Row) -> tuple[bool, Pose]:
    """Whether a target is rigid; the foot's rotation and the ankle, seen from the hip in axes turned by κ about x."""
    fine, (a, b, c, d, e, f, g, h, i) = link_rotation(leg, target)
    px, py, pz = leg.place
    x = target[3] - leg.hip[0] - (a * px + b * py + c * pz)
    y = target[7] - leg.hip[1] - (d * px + e * py + f * pz)
    z = target[11] - leg.hip[2] - (g * px + h * py + i * pz)
    C, S = leg.cos_kappa, leg.sin_kappa
    return fine, Pose(
        a, b, c,
        C * d + S * g, C * e + S * h, C * f + S * i,
        C * g - S * d, C * h - S * e, C * i - S * f,
        x, C * y + S * z, C * z - S * y,
    )  # fmt: skip


@both_ways
def within_reach(leg: Leg, foot: Pose) -> tuple[Pose, float]:
    """The foot with its ankle moved onto the reach of the leg, where it is out of it by a little; how far."""
    far = math.sqrt(foot.x * foot.x + foot.y * foot.y + foot.z * foot.z)
    reached = min(max(far, abs(leg.thigh - leg.tibia)), leg.thigh + leg.tibia)
    short = abs(far - reached)
    if short <= _ROUNDING or short > leg.stretched or far == 0.0:
        return foot, 0.0
    scale = reached / far
    return Pose(
        foot.r00, foot.r01, foot.r02,
        foot.r10, foot.r11, foot.r12,
        foot.r20, foot.r21, foot.r22,
        foot.x * scale, foot.y * scale, foot.z * scale,
    ), short  # fmt: skip


@both_ways
def knee_of(leg: Leg, foot: Pose, report: Row) -> tuple[float, int]:
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
def solve_leg(leg: Leg, target: Row, selection: Selection, work: Workspace) -> int:
    """All branches of a leg for the pose of its frame; see `ranges` for the arguments."""
    start_report(work.report)
    fine, foot = foot_of(leg, target)
    if not fine:
        work.report[REASON] = NOT_RIGID
        return 0
    foot, short = within_reach(leg, foot)
    knee = knee_of(leg, foot, work.report)
    if knee[1] == 0:
        return 0
    count = _branches(leg, foot, knee, selection, selection.enforce, work)
    if count == 0 and selection.enforce:
        # Which joint is in the way: all branches, to see which of them is nearest to the limits.
        count = _branches(leg, foot, knee, selection, False, work)
    add_shortfall(work.found, JOINTS, count, short)
    finish_report(work, JOINTS, count)
    return count


@both_ways
def _branches(leg: Leg, foot: Pose, knee: tuple[float, int], selection: Selection, prune: bool, work: Workspace) -> int:
    """Add all branches, given the angle of the knee and in how many ways it bends.

    With `prune` a branch is left as soon as a joint is seen outside its limits, and nothing is reported of it.
    """
    ranges, q = selection.ranges, work.q
    # The hip, seen in the foot.
    hx = -(foot.r00 * foot.x + foot.r10 * foot.y + foot.r20 * foot.z)
    hy = -(foot.r01 * foot.x + foot.r11 * foot.y + foot.r21 * foot.z)
    hz = -(foot.r02 * foot.x + foot.r12 * foot.y + foot.r22 * foot.z)
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
                count = _add_about_ankle_axis(leg, foot, other, selection, work, count)
        return count
    near_axis = selection.enforce and height < _NEAR_AXIS
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
                # Onto the limit of AnkleRoll, where the foot hardly moves by that.
                low, high = coupled_range(ranges, 5, q[4])
                inside = min(max(roll, low), high)
                if abs(inside - roll) * height < _ROUNDING:
                    q[5] = inside
                if prune and is_outside(ranges, 5, q[5]):
                    continue
                s6, c6 = math.sin(q[5]), math.cos(q[5])
            turn = q[3] + q[4]
            ankle = math.sin(turn), math.cos(turn), s6, c6
            family = _write_hip(leg, foot, ankle, selection, q)
            errors = -1.0, -1.0
            for other in range(2 if family == _ALONE else 1):
                if other == 1:
                    _write_other_hip(leg, q)
                if prune and not is_inside(ranges, q):
                    continue
                if prune or check_limits(selection, q, work.report):
                    if errors[0] < 0.0:  # both triples make the same rotation
                        errors = _errors(leg, foot, (s4, cosine), ankle, q)
                    count = add_branch(selection, work, errors, family, count)
    return count


@both_ways
def _write_hip(leg: Leg, foot: Pose, ankle: tuple[float, float, float, float], selection: Selection, q: Row) -> float:
    """Write the hip's angles q₁ to q₃ that knee and ankle leave of the foot's orientation; their family.

    With M = Ry(q₁) Rx(ρ) Ry(q₃), ρ = q₂ − κ, the second column of M is (sin q₁ sin ρ, cos ρ, cos q₁ sin ρ). The first
    turn is taken from it and undone; the other two follow from what is left, with every digit also beside lock.
    """
    s, c, sine, cosine = ankle
    # M = F Rx(−q₆) Ry(−q₄ − q₅), as far as it is needed.
    m01 = foot.r01 * cosine - foot.r02 * sine
    m11 = foot.r11 * cosine - foot.r12 * sine
    m21 = foot.r21 * cosine - foot.r22 * sine
    third0 = foot.r01 * sine + foot.r02 * cosine
    third2 = foot.r21 * sine + foot.r22 * cosine
    m00, m02 = foot.r00 * c + third0 * s, third0 * c - foot.r00 * s
    m20, m22 = foot.r20 * c + third2 * s, third2 * c - foot.r20 * s
    sin_rho = math.sqrt(m01 * m01 + m21 * m21)
    q[1] = wrapped(leg.kappa + math.atan2(sin_rho, m11))
    if sin_rho <= _PARALLEL:
        if m11 > 0.0:
            locked_pair((0, 2), math.atan2(m02 - m20, m00 + m22), 1.0, selection, q)
        else:
            locked_pair((0, 2), math.atan2(-m02 - m20, m00 - m22), -1.0, selection, q)
        return _HIP_LOCK
    q[0] = math.atan2(m01, m21)
    # Ry(−q₁) M, whose first row is (cos q₃, 0, sin q₃).
    q[2] = math.atan2(m21 * m02 - m01 * m22, m21 * m00 - m01 * m20)
    return _ALONE


@both_ways
def _write_other_hip(leg: Leg, q: Row) -> None:
    """Replace the hip's angles by those that make the same orientation: Ry(q₁ + π) Rx(−ρ) Ry(q₃ + π)."""
    q[0], q[1], q[2] = wrapped(q[0] + math.pi), wrapped(2.0 * leg.kappa - q[1]), wrapped(q[2] + math.pi)


@both_ways
def _add_about_ankle_axis(leg: Leg, foot: Pose, other: int, selection: Selection, work: Workspace, count: int) -> int:
    """Add the member of a family with the hip on the axis of AnkleRoll: every q₆ meets the pose with its own hip."""
    q, near = work.q, selection.reference[5]
    low, high = near - math.pi, near + math.pi
    if selection.enforce:
        low, high = coupled_range(selection.ranges, 5, q[4])
    given = leg, foot, other, selection, q
    # The reference's own roll is tried too: an axis that is met within rounding does not change a member that fits.
    roll = least(_cost_of_roll, given, low, high, near, _STEPS)
    if _cost_of_roll(given, roll) < math.inf and check_limits(selection, q, work.report):
        count = add_branch(selection, work, leg_errors(leg, foot, q), _ANKLE_AXIS, count)
    return count


@both_ways
def _cost_of_roll(given: tuple[Leg, Pose, int, Selection, Row], roll: float) -> float:
    """Write a member of the family into q; its cost."""
    leg, foot, other, selection, q = given
    q[5] = roll
    turn = q[3] + q[4]
    family = _write_hip(leg, foot, (math.sin(turn), math.cos(turn), math.sin(roll), math.cos(roll)), selection, q)
    if other == 1:
        if family != _ALONE:
            return math.inf  # the two triples belong to one family
        _write_other_hip(leg, q)
    return branch_cost(selection, q)


@both_ways
def leg_errors(leg: Leg, foot: Pose, q: Row) -> tuple[float, float]:
    """How far the frame is from its target by forward kinematics: distance [m] and angle [rad]."""
    turn = q[3] + q[4]
    ankle = math.sin(turn), math.cos(turn), math.sin(q[5]), math.cos(q[5])
    return _errors(leg, foot, (math.sin(q[3]), math.cos(q[3])), ankle, q)


@both_ways
def _errors(
    leg: Leg, foot: Pose, knee: tuple[float, float], ankle: tuple[float, float, float, float], q: Row
) -> tuple[float, float]:
    """As `leg_errors`, given sine and cosine of q₄, q₄ + q₅ and q₆, which two triples of the hip share."""
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
    e00, e10, e20 = m00 * c5 - m02 * s5 - foot.r00, m10 * c5 - m12 * s5 - foot.r10, m20 * c5 - m22 * s5 - foot.r20
    n02, n12, n22 = m00 * s5 + m02 * c5, m10 * s5 + m12 * c5, m20 * s5 + m22 * c5
    e01, e11, e21 = m01 * c6 + n02 * s6 - foot.r01, m11 * c6 + n12 * s6 - foot.r11, m21 * c6 + n22 * s6 - foot.r21
    e02, e12, e22 = n02 * c6 - m01 * s6 - foot.r02, n12 * c6 - m11 * s6 - foot.r12, n22 * c6 - m21 * s6 - foot.r22
    px, py, pz = leg.place
    dx += e00 * px + e01 * py + e02 * pz
    dy += e10 * px + e11 * py + e12 * pz
    dz += e20 * px + e21 * py + e22 * pz
    squares = e00 * e00 + e10 * e10 + e20 * e20 + e01 * e01 + e11 * e11 + e21 * e21
    squares += e02 * e02 + e12 * e12 + e22 * e22
    return math.sqrt(dx * dx + dy * dy + dz * dz), angle_of_chord(squares)


# --- The nearest pose of a foot that no branch reaches.


def nearest_foot(
    robot: RobotModel, limb: Limb, T: Floats, reference: Floats, enforce: bool, threads: int | None
) -> tuple[Floats, Floats]:
    """Coordinates nearest to n targets, and their errors, shape (n, 2), as `nearest_feet`."""
    # From all branches for the targets brought into reach, whatever the limits.
    targets = _brought_into_reach(limb.numbers, T).reshape(-1, 16)
    solve = found_for(_LEG, limb, targets if len(T) > 1 else targets[0], limb.rest, False, None)
    branches = solve.branches[..., :JOINTS]
    if limb.follows:
        branches = (branches - limb.offset) / limb.multiplier
    starts = np.where(np.isnan(branches), limb.rest[limb.index], branches).swapaxes(0, 1)
    best, errors = nearest_feet(robot, (limb.frame,), limb, T[:, None], reference, list(starts), enforce, threads)
    return best, errors[:, 0]


def _brought_into_reach(leg: Leg, T: Floats) -> Floats:
    """Targets (n, 4, 4) of a leg, moved on the line through the hip until the ankle is in reach, with the knee bent."""
    R = T[:, :3, :3] @ np.reshape(leg.rotation, (3, 3)).T
    ankle = T[:, :3, 3] - R @ leg.place - leg.hip
    far = np.maximum(np.linalg.norm(ankle, axis=-1), 1e-9)
    reached = np.clip(far, 1.01 * abs(leg.thigh - leg.tibia), 0.999 * (leg.thigh + leg.tibia))
    moved = np.array(T)
    moved[:, :3, 3] += ankle * (reached / far - 1.0)[:, None]
    return moved


_LEG = ClosedForm("legs", solve_leg, partial(limb_types, Leg, JOINTS), MOST_BRANCHES, alone=solve_leg)


# --- The nearest joint values of a leg, or of both, where feet are out of reach: damped least squares in the limits.


# What one radian counts [m], as in `arm`.
ANGLE_WEIGHT = 0.1
_GOAL = Goal(np.repeat([1.0, ANGLE_WEIGHT], 3), 0.0, 200)


def missed(result: IKResult) -> NDArray[np.bool_]:
    """Which targets have no solution and no joint values yet, shape (...)."""
    return np.asarray((result.count == 0) & np.isnan(result.best).any(axis=-1))


def nearest_feet(
    robot: RobotModel,
    frames: tuple[str, ...],
    limb: Limb,
    T: Floats,
    reference: Floats,
    starts: list[Floats],
    enforce: bool,
    threads: int | None,
) -> tuple[Floats, Floats]:
    """The coordinates with the smallest Σ (distance² + (0.1 m · angle)²) over the feet that was found.

    Args:
        robot: whose feet.
        frames: F frames.
        limb: the leg or the legs.
        T: targets in the torso, shape (n, F, 4, 4).
        reference: configurations, shape (n, nq).
        starts: coordinates at which searches begin beside those of the reference, each of shape (n, c).
        enforce: keep limits.
        threads: as in `leg`.

    Returns:
        Coordinates of the limb, shape (n, c), and errors of each foot in position and angle, shape (n, F, 2) [m, rad].
    """
    motion = kept_limb(robot, FrameMotion, *frames)
    region = motion.limited if enforce else motion.free
    n, c = len(T), len(limb.columns)
    wanted = np.array(torso_in_trunk(robot) @ T)
    wanted[..., :3, :3] = nearest_rotation(wanted[..., :3, :3])
    near = reference[:, limb.index]
    began = np.stack([np.broadcast_to(start, (n, c)) for start in (near, *starts)])
    values = robot.neutral()[None].repeat(len(began) * n, axis=0)
    values[:, limb.index] = began.reshape(-1, c)
    values = region.project(motion.joint_values(values))
    targets = np.broadcast_to(wanted.reshape(n, -1), (len(began), n, 16 * len(frames))).reshape(len(values), -1)
    still, inside = region.still_values(values), values[:, region.moving]
    # A single start is searched from as Python where nothing is compiled yet.
    parts = [slice(k, k + 1) for k in range(len(inside))] if n == 1 else [slice(None)]
    found = [descended(motion.chain, region, _GOAL, targets[k], still[k], inside[k], threads) for k in parts]
    cost = np.concatenate([part.cost for part in found]).reshape(len(began), n)
    rows: NDArray[np.intp] = np.argmin(cost, axis=0) * n + np.arange(n)
    best = np.concatenate([part.q for part in found])[rows]
    # The limb alone decides, and whole turns do not change it.
    q = robot.neutral()[None].repeat(n, axis=0)
    q[:, limb.index] = best
    made = np.array(robot.fk(q, list(frames), reference=limb.torso))
    errors = made[..., :3, :3].swapaxes(-1, -2) @ nearest_rotation(T[..., :3, :3])
    away = np.linalg.norm(made[..., :3, 3] - T[..., :3, 3], axis=-1)
    if not enforce:
        turns = np.round((near - best) * limb.multiplier / (2.0 * math.pi))
        best += 2.0 * math.pi / limb.multiplier * np.where(np.abs(near) > MOST_TURNED, 0.0, turns)
    return best, np.stack([away, np.linalg.norm(log(errors), axis=-1)], axis=-1)
