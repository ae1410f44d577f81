"""Both legs on the motor of HipYawPitch: the joints of a leg for a given HipYawPitch, and where both feet are met.

With the names of `leg`: let e = Ry(q₁) x be the axis of HipRoll, p the ankle from the hip and n the normal of the sole.
The plane of the leg contains e and p, so its normal is along p × e, and the foot's x-axis, in this plane and
perpendicular to n, is along

    u = (p × e) × n = e (p · n) − p (e · n).

p and n can be met for every q₁. The foot is then turned about n by the angle ψ of u relative to the target's x-axis,

    tan ψ = Y / X,  X = u · x_foot,  Y = u · y_foot,

both linear in (cos q₁, sin q₁). ψ is monotonic, because X Y' − Y X' is constant; one foot is exact where Y = 0, at two
values of q₁ half a turn apart. Both feet are exact where one q₁ is a root of both.
"""

from __future__ import annotations

import math
from typing import NamedTuple, TypeAlias

from nao_kin._kernels.cache import Row, both_ways
from nao_kin.ik.branches import (
    ANGLE_ERROR,
    BEST,
    NOT_RIGID,
    POSITION_ERROR,
    REASON,
    VERIFIED,
    Pose,
    Ranges,
    Selection,
    Workspace,
    add_branch,
    finish_report,
    is_inside,
    is_outside,
    start_report,
    wrapped,
)
from nao_kin.ik.leg import Leg, foot_of, knee_of, leg_errors
from nao_kin.ik.results import Family

# Values of the joints of one leg.
Joints: TypeAlias = tuple[float, float, float, float, float, float]

# HipYawPitch, and five joints of each leg.
JOINTS, OF_ONE = 11, 6
# The product of two values of HipYawPitch and, for each leg, two knees and two rolls of the hip.
MAX_BRANCHES = 32
# Where the parts of a target begin.
LEFT, RIGHT, PRIORITY = 0, 16, 32
# Numbers of a report after the joints: errors of both feet in position, angle and yaw; the leg that fails; the move of
# the torso.
LEFT_FOOT = BEST + JOINTS
RIGHT_FOOT, FAILED_LEG, MOVED, MORE = LEFT_FOOT + 3, LEFT_FOOT + 6, LEFT_FOOT + 7, 8
NEITHER, LEFT_LEG, RIGHT_LEG = -1.0, 0.0, 1.0

_ALONE = float(Family.NONE)
# Turn of a foot [rad] up to which a solution is tried; its errors are verified.
_YAW_TOLERANCE = 1e-9
# A slope ψ' below which HipYawPitch does not turn a foot.
FLAT = 1e-11
# Rounding of Y [m].
_ROUNDING = 1e-15
# If the ankle is nearer than this to the axis of HipRoll [m], it determines the roll less precisely than the foot does.
_ALONG = 1e-4


class Legs(NamedTuple):
    """The geometry of both legs."""

    left: Leg
    right: Leg
    turn: float  # the value of the right HipYawPitch minus that of the left one [rad]


class LegsRanges(NamedTuple):
    """Limits of the six joints of each leg."""

    left: Ranges
    right: Ranges


class FootYaw(NamedTuple):
    """The turn ψ of a foot about its normal: X = x_cos cos q₁ + x_sin sin q₁, Y = y_cos cos q₁ + y_sin sin q₁."""

    x_cos: float
    x_sin: float
    y_cos: float
    y_sin: float


class LegTask(NamedTuple):
    """A leg, its target, the angle of the knee with its number of signs, and the turn of the foot."""

    leg: Leg
    foot: Pose
    knee: tuple[float, int]
    yaw: FootYaw


class Branch(NamedTuple):
    """A branch of a leg whose ankle and normal are met."""

    knee: float
    hip_sign: float  # 1 for the leg below the axis of HipRoll, −1 for above
    ankle_sign: float  # that of cos AnkleRoll


Tasks: TypeAlias = tuple[LegTask, LegTask]


@both_ways
def tasks_of(legs: Legs, target: Row, report: Row) -> tuple[bool, Tasks]:
    """Return whether the poses of both feet are rigid, and the tasks of the legs; report a leg that is too short."""
    right_rigid, right = foot_of(legs.right, target[RIGHT:PRIORITY])
    right_knee = knee_of(legs.right, right, report)
    left_rigid, left = foot_of(legs.left, target[LEFT:RIGHT])
    left_knee = knee_of(legs.left, left, report)
    return left_rigid and right_rigid, (
        LegTask(legs.left, left, left_knee, foot_yaw(left)),
        LegTask(legs.right, right, right_knee, foot_yaw(right)),
    )


@both_ways
def solve_legs(legs: Legs, target: Row, selection: Selection, work: Workspace) -> int:
    """Find all joint values that meet the poses of both feet, as `branches` describes."""
    report = work.report
    start_report(report)
    report[FAILED_LEG], report[MOVED] = NEITHER, 0.0
    is_rigid, tasks = tasks_of(legs, target, report)
    left, right = tasks
    if not is_rigid:
        report[REASON] = NOT_RIGID
        return 0
    if left.knee[1] == 0 or right.knee[1] == 0:
        report[FAILED_LEG] = LEFT_LEG if left.knee[1] == 0 else RIGHT_LEG
        return 0
    if slope(left.yaw) < FLAT and slope(right.yaw) < FLAT:
        return 0  # a family, which needs a search
    hip, count = common_hip(left.yaw, right.yaw), 0
    c, s = math.cos(hip), math.sin(hip)
    if yaw_sine(left.yaw, c, s) > _YAW_TOLERANCE or yaw_sine(right.yaw, c, s) > _YAW_TOLERANCE:
        return 0
    for value in (hip, wrapped(hip + math.pi)):
        count = _add_with_hip(tasks, value, selection, work, count)
    if count > 0:
        finish_report(work, JOINTS, count)
        for yaw, place in ((left.yaw, LEFT_FOOT), (right.yaw, RIGHT_FOOT)):
            x, y = yaw.x_cos * c + yaw.x_sin * s, yaw.y_cos * c + yaw.y_sin * s
            report[place + 2] = math.copysign(report[place + 1], x * y)
    return count


@both_ways
def _add_with_hip(tasks: Tasks, hip: float, selection: Selection, work: Workspace, count: int) -> int:
    """Add all solutions with a value of HipYawPitch, and report the errors of both feet in the best one."""
    ranges, reference, enforce = selection
    branches, report = work.branches, work.report
    left, right = tasks
    if enforce and (is_outside(ranges.left, 0, hip) or is_outside(ranges.right, 0, hip)):
        return count
    for branch in range(2 * left.knee[1]):
        fits, errors, joints = _exact(left, ranges.left, hip, branch, reference[1], enforce)
        if not fits:
            continue
        for other in range(2 * right.knee[1]):
            fits, others, right_joints = _exact(right, ranges.right, hip, other, reference[OF_ONE], enforce)
            if fits:
                write_joints(joints, right_joints, work.q)
                nearest = branches[JOINTS] if count > 0 else math.inf
                both = max(errors[0], others[0]), max(errors[1], others[1])
                count = add_branch(selection, work, both, _ALONE, count)
                if branches[JOINTS] < nearest:
                    report[LEFT_FOOT], report[LEFT_FOOT + 1] = errors
                    report[RIGHT_FOOT], report[RIGHT_FOOT + 1] = others
    return count


@both_ways
def _exact(
    task: LegTask, ranges: Ranges, hip: float, branch: int, roll: float, enforce: bool
) -> tuple[bool, tuple[float, float], Joints]:
    """Return whether a branch of a leg is a solution with this value of HipYawPitch, its errors, and its joints."""
    leg, foot = task.leg, task.foot
    bent = task.knee[0] if branch < 2 else -task.knee[0]
    if enforce and is_outside(ranges, 3, bent):
        return False, (0.0, 0.0), (hip, 0.0, 0.0, bent, 0.0, 0.0)
    cosine, sine = _roll(foot, hip, 1.0 if branch % 2 == 0 else -1.0, roll - leg.kappa)
    hip_roll = wrapped(leg.kappa + math.atan2(sine, cosine))
    if enforce and is_outside(ranges, 1, hip_roll):
        return False, (0.0, 0.0), (hip, hip_roll, 0.0, bent, 0.0, 0.0)
    q = _exact_joints(leg, foot, hip, hip_roll, bent, cosine, sine)
    if enforce and not is_inside(ranges, q):
        return False, (0.0, 0.0), q
    errors = leg_errors(leg, foot, q)
    return errors[0] <= VERIFIED and errors[1] <= VERIFIED, errors, q


@both_ways
def write_joints(left: Joints, right: Joints, q: Row) -> None:
    """Write the joints of both legs into one row."""
    q[0], q[1], q[2], q[3], q[4], q[5] = left
    _, q[6], q[7], q[8], q[9], q[10] = right


@both_ways
def errors_of_feet(tasks: Tasks, q: Row) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the errors of the left and the right foot in position and angle [m, rad]."""
    left, right = tasks
    return (
        leg_errors(left.leg, left.foot, (q[0], q[1], q[2], q[3], q[4], q[5])),
        leg_errors(right.leg, right.foot, (q[0], q[6], q[7], q[8], q[9], q[10])),
    )


@both_ways
def report_feet(tasks: Tasks, q: Row, report: Row) -> None:
    """Report joint values as the best, with the errors of both feet."""
    report[BEST : BEST + JOINTS] = q[:JOINTS]
    one, two = errors_of_feet(tasks, q)
    report[LEFT_FOOT], report[LEFT_FOOT + 1] = one
    report[RIGHT_FOOT], report[RIGHT_FOOT + 1] = two
    report[LEFT_FOOT + 2] = math.copysign(one[1], _yaw_of(tasks[0].yaw, q[0], one[1]))
    report[RIGHT_FOOT + 2] = math.copysign(two[1], _yaw_of(tasks[1].yaw, q[0], two[1]))
    report[POSITION_ERROR], report[ANGLE_ERROR] = max(one[0], two[0]), max(one[1], two[1])


# --- HipYawPitch and the turn of a foot.


@both_ways
def foot_yaw(foot: Pose) -> FootYaw:
    """Return X and Y of a target."""
    x = foot.x * foot.r00 + foot.y * foot.r10 + foot.z * foot.r20
    y = foot.x * foot.r01 + foot.y * foot.r11 + foot.z * foot.r21
    n = foot.x * foot.r02 + foot.y * foot.r12 + foot.z * foot.r22
    return FootYaw(
        foot.r00 * n - x * foot.r02,
        x * foot.r22 - foot.r20 * n,
        foot.r01 * n - y * foot.r02,
        y * foot.r22 - foot.r21 * n,
    )


@both_ways
def _yaw_of(yaw: FootYaw, hip: float, angle: float) -> float:
    """Return the turn ψ of the foot about its normal [rad], for the sign of the ankle with |ψ| nearer to `angle`."""
    c, s = math.cos(hip), math.sin(hip)
    turn = math.atan2(yaw.y_cos * c + yaw.y_sin * s, yaw.x_cos * c + yaw.x_sin * s)
    other = wrapped(turn + math.pi)
    return turn if abs(abs(turn) - angle) <= abs(abs(other) - angle) else other


@both_ways
def hip_of(yaw: FootYaw) -> float:
    """Return a value of HipYawPitch with which the foot is exact; the other one is half a turn away."""
    return math.atan2(-yaw.y_cos, yaw.y_sin)


@both_ways
def slope(yaw: FootYaw) -> float:
    """Return |ψ'| where ψ = 0; infinite if ψ is undefined there."""
    # With Y = ‖Y‖ sin (q₁ − root), X at the root is the constant X Y' − Y X' over ‖Y‖.
    square = yaw.y_cos * yaw.y_cos + yaw.y_sin * yaw.y_sin
    constant = abs(yaw.x_cos * yaw.y_sin - yaw.x_sin * yaw.y_cos)
    return square / constant if constant > 0.0 else math.inf if square > 0.0 else 0.0


@both_ways
def common_hip(left: FootYaw, right: FootYaw) -> float:
    """Return the value of HipYawPitch, between a root of the left and one of the right foot, with the least sum of ψ².

    Near a singularity rounding displaces a root, but ψ hardly changes there, so the slopes are the weights.
    """
    hip = hip_of(left)
    # The distance to the other root: sine and cosine of the difference of two arctangents, within ±π/2.
    sine = left.y_cos * right.y_sin - left.y_sin * right.y_cos
    cosine = left.y_cos * right.y_cos + left.y_sin * right.y_sin
    gap = math.atan2(sine, cosine) if cosine >= 0.0 else math.atan2(-sine, -cosine)
    # As `slope`, without a denominator that may be zero.
    one = (left.y_cos * left.y_cos + left.y_sin * left.y_sin) * (right.x_cos * right.y_sin - right.x_sin * right.y_cos)
    two = (right.y_cos * right.y_cos + right.y_sin * right.y_sin) * (left.x_cos * left.y_sin - left.x_sin * left.y_cos)
    one, two = one * one, two * two
    return wrapped(hip + gap * (two / (one + two))) if one + two > 0.0 else hip


@both_ways
def yaw_sine(yaw: FootYaw, c: float, s: float) -> float:
    """Return |sin ψ|, up to rounding, from cosine and sine of HipYawPitch."""
    x, y = yaw.x_cos * c + yaw.x_sin * s, yaw.y_cos * c + yaw.y_sin * s
    size = math.sqrt(x * x + y * y)
    return max(0.0, abs(y) - _ROUNDING) / size if size > 0.0 else 0.0


# --- The other five joints.


@both_ways
def _roll(foot: Pose, hip: float, hip_sign: float, default: float) -> tuple[float, float]:
    """Return cos and sin of ρ, the leg plane's turn about HipRoll's axis that meets the foot; `default` for any ρ."""
    c, s = math.cos(hip), math.sin(hip)
    # The ankle and the foot's x-axis, perpendicular to the axis.
    py, pz = foot.y, s * foot.x + c * foot.z
    fy, fz = foot.r10, s * foot.r00 + c * foot.r20
    aside, turned = math.sqrt(py * py + pz * pz), math.sqrt(fy * fy + fz * fz)
    if aside > _ALONG or (aside >= turned and aside > 0.0):
        return -hip_sign * pz / aside, hip_sign * py / aside
    if turned > 0.0:
        return -hip_sign * fz / turned, hip_sign * fy / turned
    return math.cos(default), math.sin(default)


@both_ways
def _exact_joints(leg: Leg, foot: Pose, hip: float, hip_roll: float, knee: float, cosine: float, sine: float) -> Joints:
    """Return the joints of a leg that meets its pose at a value of HipYawPitch, from cosine and sine of ρ."""
    c, s = math.cos(hip), math.sin(hip)
    px, pz = c * foot.x - s * foot.z, s * foot.x + c * foot.z
    fx, fz = c * foot.r00 - s * foot.r20, s * foot.r00 + c * foot.r20
    nz, yz = s * foot.r02 + c * foot.r22, s * foot.r01 + c * foot.r21
    turn = math.atan2(foot.r10 * sine - fz * cosine, fx)
    ankle_roll = math.atan2(-foot.r12 * cosine - nz * sine, foot.r11 * cosine + yz * sine)
    pitch = _hip_pitch(leg, px, pz * cosine - foot.y * sine, knee)
    return hip, hip_roll, pitch, knee, wrapped(turn - pitch - knee), ankle_roll


@both_ways
def sole_joints(task: LegTask, branch: Branch, hip: float) -> Joints:
    """Return the joints with which ankle and normal are met, whatever the turn of the foot."""
    leg, foot = task.leg, task.foot
    knee, hip_sign, ankle_sign = branch
    c, s = math.cos(hip), math.sin(hip)
    px, py, pz = c * foot.x - s * foot.z, foot.y, s * foot.x + c * foot.z
    aside = math.sqrt(py * py + pz * pz)
    cosine, sine = (-hip_sign * pz / aside, hip_sign * py / aside) if aside > 0.0 else (hip_sign, 0.0)
    nx, nz = c * foot.r02 - s * foot.r22, s * foot.r02 + c * foot.r22
    up = nz * cosine - foot.r12 * sine
    turn = math.atan2(ankle_sign * nx, ankle_sign * up)
    ankle_roll = math.atan2(-foot.r12 * cosine - nz * sine, ankle_sign * math.sqrt(nx * nx + up * up))
    pitch = _hip_pitch(leg, px, pz * cosine - py * sine, knee)
    hip_roll = wrapped(leg.kappa + math.atan2(sine, cosine))
    return hip, hip_roll, pitch, knee, wrapped(turn - pitch - knee), ankle_roll


@both_ways
def _hip_pitch(leg: Leg, x: float, z: float, knee: float) -> float:
    """Return the HipPitch with which the ankle is at (x, z) in the plane of the leg."""
    vx, vz = -leg.tibia * math.sin(knee), -leg.thigh - leg.tibia * math.cos(knee)
    return math.atan2(vz * x - vx * z, vx * x + vz * z)
