"""What the targets of a whole-body pose are off by, with the exact derivatives.

Errors are numbers that are zero where a target is met, each times its weight:

    a place   p_target − p, in the world
    a pose    R_tᵀ (p_t − p) and log(Rᵀ R_t), as in `nao_kin.ik.search.numeric`
    a gaze    φ (d_y, d_z)/sin φ, the turn from the x axis of the camera to the direction d of the point
    the com   the horizontal part of p_target − com

The support polygon is no error but a set of inequalities; see `body_search`.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from nao_kin._common.arrays import Floats
from nao_kin.ik.body.body import Body, add_chain, centre_of_mass, com_velocities, frame_pose, place_all
from nao_kin.ik.compiling import both_ways

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
