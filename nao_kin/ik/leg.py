"""`leg`: all branches of one leg for the pose of its foot: the call, the geometry, and the equations."""

from __future__ import annotations

import math
from functools import partial
from typing import NamedTuple, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, SolverLimits
from nao_kin._kernels.cache import Row, both_ways
from nao_kin.ik.branches import (
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
    least,
    link_rotation,
    locked_pair,
    start_report,
    wrapped,
)
from nao_kin.ik.closed_form import (
    ClosedForm,
    Limb,
    cached_limb,
    chain_at_zero,
    check_side,
    limb_of,
    limb_types,
    solve,
    unlimited_branches,
)
from nao_kin.ik.least_squares import nearest_values
from nao_kin.ik.results import Family, IKResult, without_collisions
from nao_kin.ik.targets import Options, as_options, as_poses, refuse_not_rigid
from nao_kin.robot import CollisionRule, RobotModel

_JOINTS = ("HipYawPitch", "HipRoll", "HipPitch", "KneePitch", "AnklePitch", "AnkleRoll")


def leg(
    robot: RobotModel,
    side: str,
    target: ArrayLike,
    *,
    frame: str | None = None,
    near: ArrayLike | None = None,
    limits: SolverLimits = "enforce",
    threads: SupportsIndex | None = None,
    collisions: bool | CollisionRule = False,
) -> IKResult:
    """Compute all joint values of a leg that give its foot a pose: up to eight branches, each verified.

    If the target is not met, `best` and `q` are the joint values with the smallest √(distance² + (0.1 m · angle)²) that
    a search finds, inside the limits if these are enforced.

    Both legs share the motor of HipYawPitch: a solution of the right leg sets the coordinate LHipYawPitch, which also
    moves the left leg.

    Args:
        robot: a NAO of any version, or another robot with legs of its geometry.
        side: "L" or "R", or the end effector "LLeg" or "RLeg".
        target: the pose of the frame in the torso, shape (..., 4, 4) [m].
        frame: a frame on the foot; None for the end effector "LLeg" or "RLeg".
        near: as in all solvers, see `nao_kin.ik`.
        limits: as in all solvers.
        threads: as in all solvers.
        collisions: as in all solvers.

    Returns:
        Solutions meet the nearest rigid pose to within 1e-10 m and rad, so that poses rounded to float32, for instance,
        have solutions. For the same reason a straight leg solves a target that is out of its reach by up to 1e-6 m;
        `residual` includes this distance. A family of solutions is listed once, by its member inside the limits that is
        nearest to `near`. There are two families: the hip at lock (`HIP_LOCK`), and the hip on the axis of
        AnkleRoll (`ANKLE_AXIS`). A knee within 1e-7 rad of straight has one branch.

    Raises:
        BadArgument: the robot has no such leg; the message says what is missing. Or the last row of a target is not
            0, 0, 0, 1.
        NotARotation: the 3×3 part of a target is not a rotation; the error has the argument, its index and its defect.

    Source: the derivation is in docs/inverse_kinematics.md.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = nao.posture("StandInit")
        >>> result = nk.ik.leg(nao, "L", nao.fk(q, "LLeg"))
        >>> bool(result.success), result.solutions.shape
        (True, (1, 25))
    """
    limb = leg_limb(robot, check_side(side, "Leg"), frame)
    T = as_poses(target, "target")
    batch = T.shape[:-2]
    options = as_options(robot, limb.rest, near, batch, limits, threads)
    nearest = partial(nearest_foot, robot, limb)
    result = solve(_LEG, limb, T.reshape(*batch, 16), options, lambda: refuse_not_rigid(T, "target"), nearest)
    return without_collisions(robot, result, collisions)


# --- The geometry of a leg, read from a robot.


class Leg(NamedTuple):
    """The geometry of a leg: the hip in the torso, thigh L₁, tibia L₂, and the frame in the foot from the ankle [m]."""

    hip: Vector
    kappa: float  # κ: the axis of HipYawPitch is (0, cos κ, sin κ)
    cos_kappa: float
    sin_kappa: float
    thigh: float
    tibia: float
    stretched: float  # how far a target may be out of reach of the straight leg [m]
    turned: float  # 1 if the frame is rotated in the foot
    rotation: Rotation
    place: Vector


def leg_limb(robot: RobotModel, side: str, frame: str | None) -> Limb:
    """Return a leg of a robot for the closed form."""
    return cached_limb(robot, _leg_of, side, f"{side}Leg" if frame is None else frame)


def _leg_of(robot: RobotModel, side: str, frame: str) -> Limb:
    chain = chain_at_zero(robot, "leg", tuple(side + joint for joint in _JOINTS), "?xyyyx", frame)
    _, cosine, sine = chain.axes[0].tolist()
    kappa = math.atan2(sine, cosine)
    chain.require_axis(0, (0.0, math.cos(kappa), math.sin(kappa)))
    chain.require_meeting((0, 1), (0, 2), (4, 5))
    hip, knee, ankle = chain.points[0], chain.points[3], chain.points[4]
    thigh, tibia = hip - knee, knee - ankle
    chain.require_zero("knee and ankle are not below the hip", np.concatenate([thigh[:2], tibia[:2]]))
    if min(thigh[2], tibia[2]) <= 0.0:
        raise chain.error("knee and ankle are not below the hip")
    lengths = float(thigh[2]), float(tibia[2])
    turned, rotation, place = chain.frame_in_link(ankle)
    numbers = Leg(tuple(hip.tolist()), kappa, cosine, sine, *lengths, _STRETCHED, turned, rotation, place)
    return limb_of(chain, frame, numbers)


# --- Eight real branches from the pose of the foot.
#
# The axes of the three hip joints, a₁ = (0, cos κ, sin κ), x and y at zero, meet in the hip; those of KneePitch and
# AnklePitch are y; AnklePitch and AnkleRoll, about x, meet in the ankle. With F the orientation of the foot and h the
# hip from the ankle, in the axes of the foot,
#
#     h = Rx(−q₆) w,  w = L₁ (−sin(q₄ + q₅), cos(q₄ + q₅)) + L₂ (−sin q₅, cos q₅)  in the plane of x and z,
#     F = Rx(κ) Ry(q₁) Rx(q₂ − κ) Ry(q₃) · Ry(q₄ + q₅) Rx(q₆).
#
# |h| gives the knee (two signs). The direction of h gives the ankle's roll (two values) and then its pitch. The rest of
# F gives the three angles of the hip (two solutions).

MAX_BRANCHES = 8
JOINTS = 6

_ALONE, _HIP_LOCK, _ANKLE_AXIS = float(Family.NONE), float(Family.HIP_LOCK), float(Family.ANKLE_AXIS)
# A distance [m] that rounding may add to the reach of the leg, and below which the hip is on the axis of AnkleRoll.
_ROUNDING = 1e-12
# A straight leg solves targets out of its reach by up to this [m]: poses rounded to float32, for instance.
_STRETCHED = 1e-6
# Within this angle [rad] the knee counts as stretched or folded: its angle is a square root with half the digits.
_STRAIGHT = 1e-7
# Sine of the angle between the axes of HipYawPitch and HipPitch up to which they are parallel.
_PARALLEL = 1e-12
# Steps of the search in a family.
_STEPS = 180
# If the hip is nearer than this to the axis of AnkleRoll [m], rounding may move the roll outside its limits.
_NEAR_AXIS = 1e-5


@both_ways
def foot_of(leg: Leg, target: Row) -> tuple[bool, Pose]:
    """Return whether a target is rigid, and the foot with its ankle from the hip, in axes turned by κ about x."""
    is_rigid, (a, b, c, d, e, f, g, h, i) = link_rotation(leg, target)
    px, py, pz = leg.place
    x = target[3] - leg.hip[0] - (a * px + b * py + c * pz)
    y = target[7] - leg.hip[1] - (d * px + e * py + f * pz)
    z = target[11] - leg.hip[2] - (g * px + h * py + i * pz)
    C, S = leg.cos_kappa, leg.sin_kappa
    return is_rigid, Pose(
        a, b, c,
        C * d + S * g, C * e + S * h, C * f + S * i,
        C * g - S * d, C * h - S * e, C * i - S * f,
        x, C * y + S * z, C * z - S * y,
    )  # fmt: skip


@both_ways
def within_reach(leg: Leg, foot: Pose) -> tuple[Pose, float]:
    """Return the foot with its ankle moved into reach, if it is out of reach by at most `stretched`; and how far."""
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
    """Return the angle of the knee and its number of signs; 0 if the ankle is out of reach, with a report."""
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
    """Find all branches of a leg for the pose of its frame, as `branches` describes."""
    start_report(work.report)
    is_rigid, foot = foot_of(leg, target)
    if not is_rigid:
        work.report[REASON] = NOT_RIGID
        return 0
    foot, short = within_reach(leg, foot)
    knee = knee_of(leg, foot, work.report)
    if knee[1] == 0:
        return 0
    count = _branches(leg, foot, knee, selection, selection.enforce, work)
    if count == 0 and selection.enforce:
        # No branch is inside the limits: find the one nearest to them, which gives the reason.
        count = _branches(leg, foot, knee, selection, False, work)
    add_shortfall(work.branches, JOINTS, count, short)
    finish_report(work, JOINTS, count)
    return count


@both_ways
def _branches(leg: Leg, foot: Pose, knee: tuple[float, int], selection: Selection, prune: bool, work: Workspace) -> int:
    """Add all branches for the knee's angle and number of signs; with `prune` only those in limits, without report."""
    ranges, q = selection.ranges, work.q
    # The hip in the axes of the foot.
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
                # Move AnkleRoll to its limit if that hardly moves the foot.
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
                    if errors[0] < 0.0:  # both solutions give the same rotation
                        errors = _errors(leg, foot, (s4, cosine), ankle, q)
                    count = add_branch(selection, work, errors, family, count)
    return count


@both_ways
def _write_hip(leg: Leg, foot: Pose, ankle: tuple[float, float, float, float], selection: Selection, q: Row) -> float:
    """Write q₁ to q₃ for the foot's orientation and given knee and ankle; return their family.

    The second column of M = Ry(q₁) Rx(ρ) Ry(q₃), ρ = q₂ − κ, is (sin q₁ sin ρ, cos ρ, cos q₁ sin ρ). It gives q₁; the
    other two follow from Ry(−q₁) M, to full precision near lock too.
    """
    s, c, sine, cosine = ankle
    # The entries of M = F Rx(−q₆) Ry(−q₄ − q₅) that are needed.
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
    """Replace q₁ to q₃ by the other solution, Ry(q₁ + π) Rx(−ρ) Ry(q₃ + π)."""
    q[0], q[1], q[2] = wrapped(q[0] + math.pi), wrapped(2.0 * leg.kappa - q[1]), wrapped(q[2] + math.pi)


@both_ways
def _add_about_ankle_axis(leg: Leg, foot: Pose, other: int, selection: Selection, work: Workspace, count: int) -> int:
    """Add the best member of the family with the hip on the axis of AnkleRoll, where every q₆ is possible."""
    q, near = work.q, selection.reference[5]
    low, high = near - math.pi, near + math.pi
    if selection.enforce:
        low, high = coupled_range(selection.ranges, 5, q[4])
    given = leg, foot, other, selection, q
    # The reference's roll is tried too: rounding of the axis must not change a reference that is a solution.
    roll = least(_cost_of_roll, given, low, high, near, _STEPS)
    if _cost_of_roll(given, roll) < math.inf and check_limits(selection, q, work.report):
        count = add_branch(selection, work, leg_errors(leg, foot, q), _ANKLE_AXIS, count)
    return count


@both_ways
def _cost_of_roll(given: tuple[Leg, Pose, int, Selection, Row], roll: float) -> float:
    """Write a member of the family into q; return its cost."""
    leg, foot, other, selection, q = given
    q[5] = roll
    turn = q[3] + q[4]
    family = _write_hip(leg, foot, (math.sin(turn), math.cos(turn), math.sin(roll), math.cos(roll)), selection, q)
    if other == 1:
        if family != _ALONE:
            return math.inf  # both solutions belong to one family
        _write_other_hip(leg, q)
    return branch_cost(selection, q)


@both_ways
def leg_errors(leg: Leg, foot: Pose, q: Row) -> tuple[float, float]:
    """Return the error of the frame by forward kinematics: distance [m] and angle [rad]."""
    turn = q[3] + q[4]
    ankle = math.sin(turn), math.cos(turn), math.sin(q[5]), math.cos(q[5])
    return _errors(leg, foot, (math.sin(q[3]), math.cos(q[3])), ankle, q)


@both_ways
def _errors(
    leg: Leg, foot: Pose, knee: tuple[float, float], ankle: tuple[float, float, float, float], q: Row
) -> tuple[float, float]:
    """Return `leg_errors`, given sine and cosine of q₄, q₄ + q₅ and q₆, which two solutions of the hip share."""
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
    # The ankle in the axes of the thigh.
    vx, vz = -leg.tibia * s4, -leg.thigh - leg.tibia * c4
    dx, dy, dz = m00 * vx + m02 * vz - foot.x, m10 * vx + m12 * vz - foot.y, m20 * vx + m22 * vz - foot.z
    # The foot, M Ry(q₄ + q₅) Rx(q₆), minus its target.
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


# --- The nearest joint values of one or both legs if feet are out of reach.


def nearest_foot(robot: RobotModel, limb: Limb, T: Floats, options: Options) -> tuple[Floats, Floats]:
    """Return the coordinates nearest to n targets, and their errors, shape (n, 2), as `nearest_values`."""
    T = T.reshape(-1, 4, 4)
    # Start from all branches, without limits, for the targets moved into reach.
    starts = unlimited_branches(_LEG, limb, _moved_into_reach(limb.numbers, T).reshape(-1, 16))
    return nearest_values(robot, (limb.frame,), limb, T[:, None], starts, options)


def _moved_into_reach(leg: Leg, T: Floats) -> Floats:
    """Return targets (n, 4, 4) moved towards or away from the hip until the ankle is in reach, with the knee bent."""
    R = T[:, :3, :3] @ np.reshape(leg.rotation, (3, 3)).T
    ankle = T[:, :3, 3] - R @ leg.place - leg.hip
    far = np.maximum(np.linalg.norm(ankle, axis=-1), 1e-9)
    reached = np.clip(far, 1.01 * abs(leg.thigh - leg.tibia), 0.999 * (leg.thigh + leg.tibia))
    moved = np.array(T)
    moved[:, :3, 3] += ankle * (reached / far - 1.0)[:, None]
    return moved


_LEG = ClosedForm("legs", solve_leg, partial(limb_types, Leg, JOINTS), MAX_BRANCHES, alone=solve_leg)
