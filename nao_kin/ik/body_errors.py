"""What the targets of a whole-body pose are off by, with the exact derivatives.

Errors are numbers that are zero where a target is met, each times its weight:

    a place   p_target − p, in the world
    a pose    R_tᵀ (p_t − p) and log(Rᵀ R_t), as in `nao_kin.ik.numeric`
    a gaze    φ (d_y, d_z)/sin φ, the turn from the x axis of the camera to the direction d of the point
    the com   the horizontal part of p_target − com

The support polygon is no error but a set of inequalities; see `body_search`.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats
from nao_kin._kernels.cache import both_ways
from nao_kin.ik.body import (
    Body,
    add_chain,
    centre_of_mass,
    com_velocities,
    frame_pose,
    inverted,
    multiplied,
    place_all,
    place_chain,
)
from nao_kin.ik.leg import JOINTS, MOST_BRANCHES, Leg, solve_leg
from nao_kin.ik.quadratic_program import cholesky, solve_cholesky
from nao_kin.ik.ranges import BEST, EXTRAS, NEEDED, OUT_OF_REACH, REASON, Ranges, Selection, Workspace

PLACE, POSE, GAZE, COM = range(4)
MOST_ROWS = 6
# Under this angle, closed forms lose digits and two terms of their series are exact [rad].
_SMALL = 1e-2


class Plan(NamedTuple):
    """What is asked for, without the numbers that differ from pose to pose.

    Attributes:
        kind: PLACE, POSE, GAZE or COM of each target, shape (t,).
        row: the row of the body that carries the frame, shape (t,).
        T_row_frame: of the frame in it, shape (t, 4, 4).
        weights: of what is measured in metres and in radians, shape (t, 2).
        support: weight of the distance by which the centre of mass lacks the margin; 0 where it is free.
        posture: weight of the differences to the posture [per rad].
    """

    kind: NDArray[np.int64]
    row: NDArray[np.int64]
    T_row_frame: Floats
    weights: Floats
    support: float
    posture: float


def plan_types() -> Any:
    """Numba's type of `Plan`."""
    from numba import types

    integers, number = types.int64[::1], types.float64
    parts = integers, integers, types.float64[:, :, ::1], types.float64[:, ::1], number, number
    return types.NamedTuple(parts, Plan)


@both_ways
def errors_at(
    body: Body,
    plan: Plan,
    targets: Floats,
    stance: int,
    x: Floats,
    T_world_torso: Floats,
    e: Floats,
    J: Floats,
    residuals: Floats,
    com: Floats,
    com_J: Floats,
) -> None:
    """Weighted errors and derivatives of all targets.

    Args:
        body: the robot.
        plan: what is asked for.
        targets: of each target its pose, or its place in the last column, shape (t, 4, 4).
        stance: row of the last joint of a leg that stands.
        x: the variables.
        T_world_torso: where the torso is with them.
        e: for the errors, six of each target, 0 where it has fewer, shape (6 t,).
        J: for their derivatives, shape (6 t, moving).
        residuals: for the distances and angles without weights, shape (t, 2) [m, rad].
        com: for the centre of mass, shape (3,).
        com_J: for its derivative, shape (3, moving).
    """
    n, rows = body.moving, len(body.parent)
    R, p, below = np.empty((rows, 3, 3)), np.empty((rows, 3)), np.empty((rows, 4))
    place_all(body, x, T_world_torso, R, p)
    torso = np.zeros((6, n))
    add_chain(body, stance, -1.0, R, p, torso)
    centre_of_mass(body, R, p, below, com)
    com_velocities(body, R, p, torso, below, com, com_J)
    e[:] = 0.0
    J[:] = 0.0
    twists, T = np.empty((6, n)), np.empty((4, 4))
    for t in range(len(plan.kind)):
        first = MOST_ROWS * t
        metres, radians = plan.weights[t, 0], plan.weights[t, 1]
        residuals[t, 0] = residuals[t, 1] = 0.0
        if plan.kind[t] == COM:
            for i in range(2):
                e[first + i] = metres * (targets[t, i, 3] - com[i])
                for k in range(n):
                    J[first + i, k] = -metres * com_J[i, k]
            residuals[t, 0] = math.hypot(targets[t, 0, 3] - com[0], targets[t, 1, 3] - com[1])
            continue
        frame_pose(R, p, plan.row[t], plan.T_row_frame[t], T)
        twists[:] = torso
        add_chain(body, plan.row[t], 1.0, R, p, twists)
        # From the velocity at the world's origin to that of the frame's own.
        for k in range(n):
            w0, w1, w2 = twists[3, k], twists[4, k], twists[5, k]
            twists[0, k] += w1 * T[2, 3] - w2 * T[1, 3]
            twists[1, k] += w2 * T[0, 3] - w0 * T[2, 3]
            twists[2, k] += w0 * T[1, 3] - w1 * T[0, 3]
        if plan.kind[t] == GAZE:
            residuals[t, 1] = _gaze(T, targets[t], twists, radians, n, e[first : first + 2], J[first : first + 2])
            continue
        if plan.kind[t] == PLACE:
            for i in range(3):
                e[first + i] = metres * (targets[t, i, 3] - T[i, 3])
                for k in range(n):
                    J[first + i, k] = -metres * twists[i, k]
        else:
            if metres > 0.0:
                _position(T, targets[t], twists, metres, n, e[first : first + 3], J[first : first + 3])
            if radians > 0.0:
                residuals[t, 1] = _turn(
                    T, targets[t], twists, radians, n, e[first + 3 : first + 6], J[first + 3 : first + 6]
                )
        if metres > 0.0:
            d0, d1, d2 = targets[t, 0, 3] - T[0, 3], targets[t, 1, 3] - T[1, 3], targets[t, 2, 3] - T[2, 3]
            residuals[t, 0] = math.sqrt(d0 * d0 + d1 * d1 + d2 * d2)


@both_ways
def _position(T: Floats, target: Floats, twists: Floats, weight: float, n: int, e: Floats, J: Floats) -> None:
    """Errors w · R_tᵀ (p_t − p) and their derivatives."""
    for i in range(3):
        e[i] = 0.0
        for j in range(3):
            e[i] += weight * target[j, i] * (target[j, 3] - T[j, 3])
        for k in range(n):
            J[i, k] = -weight * (
                target[0, i] * twists[0, k] + target[1, i] * twists[1, k] + target[2, i] * twists[2, k]
            )


@both_ways
def _turn(T: Floats, target: Floats, twists: Floats, weight: float, n: int, e: Floats, J: Floats) -> float:
    """Errors w · log(Rᵀ R_t) and their derivatives −w · J_l⁻¹ Rᵀ ω; the angle.

    J_l(v)⁻¹ = 1 − ½ [v×] + c [v×]² with c = (1 − (φ/2) cot(φ/2))/φ²; Barfoot, State Estimation for Robotics, 7.1.5.
    """
    M = np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            M[i, j] = T[0, i] * target[0, j] + T[1, i] * target[1, j] + T[2, i] * target[2, j]
    v0, v1, v2 = rotation_vector(M)
    squares = v0 * v0 + v1 * v1 + v2 * v2
    angle = math.sqrt(squares)
    c = (1.0 - 0.5 * angle / math.tan(0.5 * angle)) / squares if angle > _SMALL else 1.0 / 12.0 + squares / 720.0
    e[0], e[1], e[2] = weight * v0, weight * v1, weight * v2
    d = 1.0 - c * squares  # [v×]² = v vᵀ − φ² 1
    for k in range(n):
        w0, w1, w2 = twists[3, k], twists[4, k], twists[5, k]
        u0 = T[0, 0] * w0 + T[1, 0] * w1 + T[2, 0] * w2
        u1 = T[0, 1] * w0 + T[1, 1] * w1 + T[2, 1] * w2
        u2 = T[0, 2] * w0 + T[1, 2] * w1 + T[2, 2] * w2
        along = c * (v0 * u0 + v1 * u1 + v2 * u2)
        J[0, k] = -weight * (d * u0 + along * v0 - 0.5 * (v1 * u2 - v2 * u1))
        J[1, k] = -weight * (d * u1 + along * v1 - 0.5 * (v2 * u0 - v0 * u2))
        J[2, k] = -weight * (d * u2 + along * v2 - 0.5 * (v0 * u1 - v1 * u0))
    return angle


@both_ways
def _gaze(T: Floats, target: Floats, twists: Floats, weight: float, n: int, e: Floats, J: Floats) -> float:
    """Errors w · φ (d_y, d_z)/sin φ and their derivatives; the angle φ between the x axis and the point."""
    u = np.empty(3)
    for i in range(3):
        u[i] = 0.0
        for j in range(3):
            u[i] += T[j, i] * (target[j, 3] - T[j, 3])
    far = math.sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2])
    if far < 1e-9:  # a camera in the point itself looks at it
        return 0.0
    dx, dy, dz = u[0] / far, u[1] / far, u[2] / far
    sine = math.hypot(dy, dz)
    angle = math.atan2(sine, dx)
    if sine > _SMALL:
        ratio = angle / sine
        slope = (1.0 - ratio * dx) / (sine * sine)  # d(φ/sin φ)/dφ = slope · sin φ
    elif dx > 0.0:
        ratio, slope = 1.0 + sine * sine / 6.0, 1.0 / 3.0
    else:  # straight behind, every way round is as long as any other
        ratio, slope, dy, dz = math.pi / _SMALL, 0.0, max(dy, _SMALL), dz
    e[0], e[1] = weight * ratio * dy, weight * ratio * dz
    for k in range(n):
        w0, w1, w2 = twists[3, k], twists[4, k], twists[5, k]
        a0 = T[0, 0] * w0 + T[1, 0] * w1 + T[2, 0] * w2
        a1 = T[0, 1] * w0 + T[1, 1] * w1 + T[2, 1] * w2
        a2 = T[0, 2] * w0 + T[1, 2] * w1 + T[2, 2] * w2
        v0 = (T[0, 0] * twists[0, k] + T[1, 0] * twists[1, k] + T[2, 0] * twists[2, k]) / far
        v1 = (T[0, 1] * twists[0, k] + T[1, 1] * twists[1, k] + T[2, 1] * twists[2, k]) / far
        v2 = (T[0, 2] * twists[0, k] + T[1, 2] * twists[1, k] + T[2, 2] * twists[2, k]) / far
        # The direction turns by d × ω − v/|u| across itself.
        g0, g1, g2 = dy * a2 - dz * a1 - v0, dz * a0 - dx * a2 - v1, dx * a1 - dy * a0 - v2
        along = g0 * dx + g1 * dy + g2 * dz
        g0, g1, g2 = g0 - along * dx, g1 - along * dy, g2 - along * dz
        # −d(cos φ) = sin φ dφ, so that d(φ/sin φ) = −slope · d(cos φ).
        change = -slope * g0
        J[0, k] = weight * (ratio * g1 + change * dy)
        J[1, k] = weight * (ratio * g2 + change * dz)
    return angle


@both_ways
def rotation_vector(M: Floats) -> tuple[float, float, float]:
    """Log of a rotation, by its unit quaternion: with every digit at all angles."""
    m00, m11, m22 = M[0, 0], M[1, 1], M[2, 2]
    # Four times the quaternion times one of its components, the largest.
    if m00 + m11 + m22 >= max(m00, m11, m22):
        w, a, b, c = 1.0 + m00 + m11 + m22, M[2, 1] - M[1, 2], M[0, 2] - M[2, 0], M[1, 0] - M[0, 1]
    elif m00 >= m11 and m00 >= m22:
        w, a, b, c = M[2, 1] - M[1, 2], 1.0 + m00 - m11 - m22, M[0, 1] + M[1, 0], M[0, 2] + M[2, 0]
    elif m11 >= m22:
        w, a, b, c = M[0, 2] - M[2, 0], M[0, 1] + M[1, 0], 1.0 + m11 - m00 - m22, M[1, 2] + M[2, 1]
    else:
        w, a, b, c = M[1, 0] - M[0, 1], M[0, 2] + M[2, 0], M[1, 2] + M[2, 1], 1.0 + m22 - m00 - m11
    length = math.sqrt(a * a + b * b + c * c)
    if length == 0.0:
        return 0.0, 0.0, 0.0
    if w < 0.0:
        w, a, b, c = -w, -a, -b, -c
    factor = 2.0 * math.atan2(length, w) / length
    return factor * a, factor * b, factor * c


# --- Standing: where the torso is when feet stay where they are, and the legs with it.
#
# The leg of the first foot carries the torso: its six joint values are the torso's pose. The leg of a second foot
# follows in closed form (`solve_leg`), the branch nearest to where it was, and asks for a value of
# HipYawPitch of its own. Both hips have one motor, so the torso is moved until both ask for the same: Newton's method
# on h₂ − h₁ over the joints of the first leg. Both feet are then met to rounding.

# Hips that differ by less agree [rad]; with rounding in the way, by less than the second.
_AGREE, _NEARLY = 1e-14, 1e-12
_MOST_STEPS = 15
# No joint of the first leg moves by more in one step [rad].
_LONGEST = 0.3


class Legs(NamedTuple):
    """The closed forms of both legs: their geometry and limits."""

    left: Leg
    right: Leg
    left_ranges: Ranges
    right_ranges: Ranges


def legs_types() -> Any:
    """Numba's type of `Legs`."""
    from numba import types

    from nao_kin.ik.geometry import limb_types

    leg, ranges = limb_types(Leg, JOINTS)
    return types.NamedTuple((leg, leg, ranges, ranges), Legs)


@both_ways
def torso_over_foot(
    body: Body, side: int, feet: Floats, x: Floats, R: Floats, p: Floats, T_world_torso: Floats
) -> None:
    """Where the torso is when a foot is where it should be.

    Args:
        body: the robot.
        side: 0 for the left foot.
        feet: T_world_foot, shape (2, 4, 4).
        x: the variables.
        R: for the rotations of this leg's joints in the torso.
        p: for their places.
        T_world_torso: for the result.
    """
    T_torso_foot, T_foot_torso = np.empty((4, 4)), np.empty((4, 4))
    foot_in_torso(body, side, x, R, p, T_torso_foot)
    inverted(T_torso_foot, T_foot_torso)
    multiplied(feet[side], T_foot_torso, T_world_torso)


@both_ways
def foot_in_torso(body: Body, side: int, x: Floats, R: Floats, p: Floats, T: Floats) -> None:
    """T_torso_foot by the joints of a leg, which are placed in R and p."""
    for i in range(3):
        p[0, i] = 0.0
        for j in range(3):
            R[0, i, j] = 1.0 if i == j else 0.0
    for k in range(JOINTS):
        place_chain(body, body.legs[side, k], x, R, p)
    frame_pose(R, p, body.legs[side, JOINTS - 1], body.ankle_to_sole[side], T)


@both_ways
def stand_on_both(body: Body, legs: Legs, feet: Floats, x: Floats, T_world_torso: Floats) -> bool:
    """Change the joints of both legs so that both feet are met; whether that was possible near by."""
    rows, n = len(body.parent), body.moving
    R, p = np.zeros((rows, 3, 3)), np.zeros((rows, 3))
    T_torso_world, T_torso_foot = np.empty((4, 4)), np.empty((4, 4))
    target, values, width = np.empty(16), np.empty(JOINTS), JOINTS + EXTRAS
    q, found, report = np.empty(JOINTS), np.empty(MOST_BRANCHES * width), np.empty(BEST + JOINTS)
    first, second = np.empty((6, n)), np.empty((6, n))
    hip = body.legs[1, 0]
    shared = body.variable[hip]
    last = math.inf
    for _ in range(_MOST_STEPS):
        torso_over_foot(body, 0, feet, x, R, p, T_world_torso)
        inverted(T_world_torso, T_torso_world)
        multiplied(T_torso_world, feet[1], T_torso_foot)
        for i in range(4):
            for j in range(4):
                target[4 * i + j] = T_torso_foot[i, j]
        for k in range(JOINTS):
            row = body.legs[1, k]
            values[k] = body.multiplier[row] * x[body.variable[row]] + body.offset[row]
        count = solve_leg(legs.right, target, Selection(legs.right_ranges, values, False), Workspace(q, found, report))
        first[:] = 0.0
        add_chain(body, body.legs[0, JOINTS - 1], 1.0, R, p, first)
        if count == 0:
            if report[REASON] != OUT_OF_REACH or not _nearer(body, T_torso_foot, report[NEEDED], p[hip], first, x):
                return False
            continue
        for k in range(1, JOINTS):
            row = body.legs[1, k]
            x[body.variable[row]] = (found[k] - body.offset[row]) / body.multiplier[row]
        asked = (found[0] - body.offset[hip]) / body.multiplier[hip]
        gap = asked - x[shared]
        gap -= 2.0 * math.pi * round(gap / (2.0 * math.pi))
        if abs(gap) <= _AGREE or (abs(gap) <= _NEARLY and abs(gap) >= 0.5 * last):
            return True
        last = abs(gap)
        foot_in_torso(body, 1, x, R, p, T_torso_foot)
        second[:] = 0.0
        add_chain(body, body.legs[1, JOINTS - 1], 1.0, R, p, second)
        if not _agree(body, gap, shared, first, second, x):
            return False
    return last <= _NEARLY


@both_ways
def _agree(body: Body, gap: float, shared: int, first: Floats, second: Floats, x: Floats) -> bool:
    """One step of Newton's method on what the two hips differ by.

    With the foot at rest, a twist ξ of the torso asks the second leg for S₂ q̇ = −ξ, so for −y·ξ of the hip, where
    S₂ᵀ y = (1, 0, …, 0); and ξ = −S₁ q̇₁. Straight knees make S₂ singular but leave y·ξ as it is, hence the damping.
    """
    gram, y = np.zeros((6, 6)), np.empty(6)
    for i in range(6):
        y[i] = second[i, shared]
        for j in range(6):
            for k in range(JOINTS):
                v = body.variable[body.legs[1, k]]
                gram[i, j] += second[i, v] * second[j, v]
        gram[i, i] += 1e-10
    if not cholesky(gram, 6):
        return False
    solve_cholesky(gram, 6, y)
    slope = np.empty(JOINTS)
    for k in range(JOINTS):
        v = body.variable[body.legs[0, k]]
        slope[k] = -1.0 if v == shared else 0.0
        for i in range(6):
            slope[k] += y[i] * first[i, v]
    return _moved(body, -gap, slope, x)


@both_ways
def _nearer(body: Body, T_torso_foot: Floats, missing: float, hip: Floats, first: Floats, x: Floats) -> bool:
    """Move the torso so that the second hip comes nearer to its ankle by what is missing."""
    sole = body.ankle_to_sole[1]
    towards = np.empty(3)
    for i in range(3):
        towards[i] = T_torso_foot[i, 3] - hip[i]
        for j in range(3):  # from the sole back to the ankle
            for k in range(3):
                towards[i] -= T_torso_foot[i, j] * sole[k, j] * sole[k, 3]
    far = math.sqrt(towards[0] * towards[0] + towards[1] * towards[1] + towards[2] * towards[2])
    slope = np.empty(JOINTS)
    for k in range(JOINTS):
        v = body.variable[body.legs[0, k]]
        v0 = first[0, v] + first[4, v] * hip[2] - first[5, v] * hip[1]
        v1 = first[1, v] + first[5, v] * hip[0] - first[3, v] * hip[2]
        v2 = first[2, v] + first[3, v] * hip[1] - first[4, v] * hip[0]
        slope[k] = -(towards[0] * v0 + towards[1] * v1 + towards[2] * v2) / far
    return _moved(body, missing + 1e-9, slope, x)


@both_ways
def _moved(body: Body, wanted: float, slope: Floats, x: Floats) -> bool:
    """The least change of the first leg's joints by which a number with this slope changes as wanted."""
    squares = 0.0
    for k in range(JOINTS):
        squares += slope[k] * slope[k]
    if not squares > 1e-12:
        return False
    factor = wanted / squares
    largest = 0.0
    for k in range(JOINTS):
        largest = max(largest, abs(factor * slope[k]))
    if largest > _LONGEST:
        factor *= _LONGEST / largest
    for k in range(JOINTS):
        x[body.variable[body.legs[0, k]]] += factor * slope[k]
    return True


# --- The limits around a configuration as linear inequalities for a step, and how far a configuration is outside.

_SAME = 1e-12


@both_ways
def table_bounds(body: Body, k: int, of: float) -> tuple[float, float]:
    """The range of the joint of table k at a value of the joint it depends on; constant outside the table."""
    at, low, high, last = body.table[k, 0], body.table[k, 1], body.table[k, 2], body.bends[k] - 1
    if of <= at[0]:
        return low[0], high[0]
    if of >= at[last]:
        return low[last], high[last]
    right = 1
    while at[right] < of:
        right += 1
    share = (of - at[right - 1]) / (at[right] - at[right - 1])
    return (
        low[right - 1] + share * (low[right] - low[right - 1]),
        high[right - 1] + share * (high[right] - high[right - 1]),
    )


@both_ways
def outside(body: Body, lower: Floats, x: Floats) -> float:
    """The sum of what the variables are outside their limits by [rad]."""
    total = 0.0
    for v in range(body.moving):
        total += max(0.0, lower[v] - x[v], x[v] - body.upper[v])
    for k in range(len(body.bends)):
        if body.bends[k] > 0:
            low, high = table_bounds(body, k, x[body.bent[k, 1]])
            value = x[body.bent[k, 0]]
            total += max(0.0, low - value, value - high)
    return total


@both_ways
def clipped(body: Body, lower: Floats, x: Floats) -> None:
    """What rounding and the bends of tables have left outside, taken back: boxes first, then tables."""
    for v in range(body.moving):
        x[v] = min(max(x[v], lower[v]), body.upper[v])
    for k in range(len(body.bends)):
        if body.bends[k] > 0:
            low, high = table_bounds(body, k, x[body.bent[k, 1]])
            v = body.bent[k, 0]
            x[v] = min(max(x[v], low, lower[v]), high, body.upper[v])


@both_ways
def limit_rows(body: Body, lower: Floats, x: Floats, longest: float, A: Floats, b: Floats, count: int) -> int:
    """Rows A δ ≥ b that keep a step δ inside the limits and no longer than `longest`; their number with those before.

    A variable that is outside is brought back as far as a step may go. Of a table every segment within a step's reach
    gives a row, except where its line would cut away what is allowed here: the region need not be convex.
    """
    for v in range(body.moving):
        for side in range(2):
            sign = 1.0 if side == 0 else -1.0
            room = lower[v] - x[v] if side == 0 else x[v] - body.upper[v]
            A[count] = 0.0
            A[count, v] = sign
            b[count] = min(max(room, -longest), longest)
            count += 1
    for k in range(len(body.bends)):
        bends = body.bends[k]
        if bends == 0:
            continue
        joint, of = body.bent[k, 0], body.bent[k, 1]
        at = body.table[k, 0]
        here = table_bounds(body, k, x[of])
        for segment in range(-1, bends):
            first, last = max(segment, 0), min(segment + 1, bends - 1)
            begins = at[first] if segment >= 0 else x[of]
            ends = at[last] if segment < bends - 1 else x[of]
            if (segment < 0 and x[of] - longest > at[0]) or (segment == bends - 1 and x[of] + longest < at[last]):
                continue
            if begins > x[of] + longest or ends < x[of] - longest:
                continue
            for side in range(2):
                sign = 1.0 if side == 0 else -1.0
                bound = body.table[k, 1 + side]
                slope = (bound[last] - bound[first]) / (at[last] - at[first]) if last > first else 0.0
                line = bound[first] + slope * (x[of] - at[first])
                if sign * (line - here[side]) > _SAME:
                    continue
                A[count] = 0.0
                A[count, joint] = sign
                A[count, of] = -sign * slope
                b[count] = min(sign * (line - x[joint]), longest)
                count += 1
    return count
