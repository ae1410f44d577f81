"""The robot as arrays, and errors of the targets of a whole-body pose, with exact derivatives.

The six errors of a target, each times its weight, are zero when the target is met:

    position   R_tᵀ (p_t − p), of a frame or of the centre of mass
    rotation   log(Rᵀ R_t); or φ (0, −d_z, d_y)/sin φ, from the x axis of a frame that aims at p_t to its direction d

The support polygon is a set of inequalities in `body_search`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._kernels.cache import Floats1, Floats2, Floats3, Ints1, Ints2, both_ways
from nao_kin._kernels.chains import inverse_jacobian_factor, rotation_vector
from nao_kin.ik.branches import BEST, EXTRAS, NEEDED, OUT_OF_REACH, REASON, Ranges, Selection, Workspace
from nao_kin.ik.leg import JOINTS, MAX_BRANCHES, Leg, solve_leg
from nao_kin.ik.limit_regions import Region
from nao_kin.ik.quadratic_program import cholesky, solve_cholesky

# --- Poses and velocities of its bodies in the world.
#
# Row 0 is the torso; every other row is a joint with all that is fixed to it, after its parent. Twists refer to the
# world's origin, so that the columns of the joints add up along a chain. If a foot is fixed, the torso's twist is minus
# the sum over the chain of that foot.

SIDES = ("L", "R")


class Body(NamedTuple):
    """A robot for the compiled search. Variables are joint values, first the `moving` ones, then fixed ones."""

    parent: Ints1  # row of the parent; −1 for the torso, shape (rows,)
    rotation: Floats3  # of each joint in its parent at zero, shape (rows, 3, 3)
    place: Floats2  # of each joint in its parent at zero, shape (rows, 3) [m]
    axis: Floats2  # shape (rows, 3)
    variable: Ints1  # index of the variable that moves each joint; −1 for the torso
    multiplier: Floats1  # joint value = multiplier · variable + offset [rad]
    offset: Floats1
    mass: Floats1  # of each body [kg]
    lever: Floats2  # its centre of mass, shape (rows, 3) [m]
    legs: Ints2  # rows of the joints of the legs, from the hip outwards, shape (2, 6)
    ankle_to_sole: Floats3  # pose of the sole's frame in the last joint of each leg, shape (2, 4, 4)
    moving: int
    limits: Region  # of the moving variables


@both_ways
def place_chain(body: Body, row: int, x: Floats, R: Floats, p: Floats) -> None:
    """Write the pose of a joint whose parent has been placed into R (rows, 3, 3) and p (rows, 3)."""
    above = body.parent[row]
    angle = body.multiplier[row] * x[body.variable[row]] + body.offset[row]
    c, s = math.cos(angle), math.sin(angle)
    a0, a1, a2 = body.axis[row, 0], body.axis[row, 1], body.axis[row, 2]
    v = 1.0 - c
    t00, t01, t02 = c + v * a0 * a0, v * a0 * a1 - s * a2, v * a0 * a2 + s * a1
    t10, t11, t12 = v * a0 * a1 + s * a2, c + v * a1 * a1, v * a1 * a2 - s * a0
    t20, t21, t22 = v * a0 * a2 - s * a1, v * a1 * a2 + s * a0, c + v * a2 * a2
    # As numbers: counting the references to slices would take a tenth of the search.
    f = body.rotation
    f00, f01, f02 = f[row, 0, 0], f[row, 0, 1], f[row, 0, 2]
    f10, f11, f12 = f[row, 1, 0], f[row, 1, 1], f[row, 1, 2]
    f20, f21, f22 = f[row, 2, 0], f[row, 2, 1], f[row, 2, 2]
    p0, p1, p2 = body.place[row, 0], body.place[row, 1], body.place[row, 2]
    for i in range(3):
        u0, u1, u2 = R[above, i, 0], R[above, i, 1], R[above, i, 2]
        w0 = u0 * f00 + u1 * f10 + u2 * f20
        w1 = u0 * f01 + u1 * f11 + u2 * f21
        w2 = u0 * f02 + u1 * f12 + u2 * f22
        R[row, i, 0] = w0 * t00 + w1 * t10 + w2 * t20
        R[row, i, 1] = w0 * t01 + w1 * t11 + w2 * t21
        R[row, i, 2] = w0 * t02 + w1 * t12 + w2 * t22
        p[row, i] = p[above, i] + u0 * p0 + u1 * p1 + u2 * p2


@both_ways
def place_all(body: Body, x: Floats, T_world_torso: Floats, R: Floats, p: Floats) -> None:
    """Write the poses of all joints in the world into R and p."""
    for i in range(3):
        p[0, i] = T_world_torso[i, 3]
        for j in range(3):
            R[0, i, j] = T_world_torso[i, j]
    for row in range(1, len(body.parent)):
        place_chain(body, row, x, R, p)


@both_ways
def frame_pose(R: Floats, p: Floats, row: int, T_row_frame: Floats, T: Floats) -> None:
    """Write T_world_frame of a frame on a body into T (4, 4)."""
    for i in range(3):
        T[i, 3] = p[row, i]
        for k in range(3):
            T[i, 3] += R[row, i, k] * T_row_frame[k, 3]
        for j in range(3):
            T[i, j] = (
                R[row, i, 0] * T_row_frame[0, j] + R[row, i, 1] * T_row_frame[1, j] + R[row, i, 2] * T_row_frame[2, j]
            )
        T[3, i] = 0.0
    T[3, 3] = 1.0


@both_ways
def multiplied(A: Floats, B: Floats, T: Floats) -> None:
    """Write the rigid transform A B into T (4, 4)."""
    for i in range(3):
        for j in range(4):
            T[i, j] = A[i, 0] * B[0, j] + A[i, 1] * B[1, j] + A[i, 2] * B[2, j]
        T[i, 3] += A[i, 3]
        T[3, i] = 0.0
    T[3, 3] = 1.0


@both_ways
def inverted(A: Floats, T: Floats) -> None:
    """Write A⁻¹ of a rigid transform into T (4, 4)."""
    for i in range(3):
        for j in range(3):
            T[i, j] = A[j, i]
        T[i, 3] = -(A[0, i] * A[0, 3] + A[1, i] * A[1, 3] + A[2, i] * A[2, 3])
        T[3, i] = 0.0
    T[3, 3] = 1.0


@both_ways
def add_chain(body: Body, row: int, sign: float, R: Floats, p: Floats, twists: Floats) -> None:
    """Add sign · the twists of a body relative to the torso, per unit of each variable, to `twists` (6, n)."""
    while row > 0:
        k = body.variable[row]
        if k < body.moving:
            m = sign * body.multiplier[row]
            a0, a1, a2 = world_axis(body, row, R)
            p0, p1, p2 = p[row, 0], p[row, 1], p[row, 2]
            twists[0, k] += m * (p1 * a2 - p2 * a1)
            twists[1, k] += m * (p2 * a0 - p0 * a2)
            twists[2, k] += m * (p0 * a1 - p1 * a0)
            twists[3, k] += m * a0
            twists[4, k] += m * a1
            twists[5, k] += m * a2
        row = body.parent[row]


@both_ways
def world_axis(body: Body, row: int, R: Floats) -> tuple[float, float, float]:
    """Return the axis of a joint in the world."""
    a = body.axis[row]
    return (
        R[row, 0, 0] * a[0] + R[row, 0, 1] * a[1] + R[row, 0, 2] * a[2],
        R[row, 1, 0] * a[0] + R[row, 1, 1] * a[1] + R[row, 1, 2] * a[2],
        R[row, 2, 0] * a[0] + R[row, 2, 1] * a[1] + R[row, 2, 2] * a[2],
    )


@both_ways
def centre_of_mass(body: Body, R: Floats, p: Floats, below: Floats, com: Floats) -> None:
    """Write the centre of mass into com (3,), and the mass and mass · centre that each joint moves into `below`."""
    rows = len(body.parent)
    for row in range(rows):
        m = body.mass[row]
        lever = body.lever[row]
        below[row, 0] = m
        for i in range(3):
            place = p[row, i] + R[row, i, 0] * lever[0] + R[row, i, 1] * lever[1] + R[row, i, 2] * lever[2]
            below[row, i + 1] = m * place
    for row in range(rows - 1, 0, -1):
        for i in range(4):
            below[body.parent[row], i] += below[row, i]
    for i in range(3):
        com[i] = below[0, i + 1] / below[0, 0]


@both_ways
def com_velocities(body: Body, R: Floats, p: Floats, torso: Floats, below: Floats, com: Floats, J: Floats) -> None:
    """Write velocities of the centre of mass per unit of each variable into J (3, n), from twists `torso` (6, n)."""
    for k in range(body.moving):
        w0, w1, w2 = torso[3, k], torso[4, k], torso[5, k]
        J[0, k] = torso[0, k] + w1 * com[2] - w2 * com[1]
        J[1, k] = torso[1, k] + w2 * com[0] - w0 * com[2]
        J[2, k] = torso[2, k] + w0 * com[1] - w1 * com[0]
    for row in range(1, len(body.parent)):
        k = body.variable[row]
        if k < body.moving and below[row, 0] > 0.0:
            share = body.multiplier[row] / below[0, 0]
            a0, a1, a2 = world_axis(body, row, R)
            # m · (centre of the bodies below the joint − joint)
            r0 = below[row, 1] - below[row, 0] * p[row, 0]
            r1 = below[row, 2] - below[row, 0] * p[row, 1]
            r2 = below[row, 3] - below[row, 0] * p[row, 2]
            J[0, k] += share * (a1 * r2 - a2 * r1)
            J[1, k] += share * (a2 * r0 - a0 * r2)
            J[2, k] += share * (a0 * r1 - a1 * r0)


# --- Errors of the targets, with their derivatives.

# The stance on both feet; 0 is the left foot alone, 1 the right one.
BOTH = 2
TARGET_ROWS = 6
# Weights of errors of position [1/m] and of rotation [1/rad], as in `numeric`; and of the posture [1/rad].
DEFAULT_WEIGHTS = (1.0, 1.0, 1.0, 0.1, 0.1, 0.1)
DEFAULT_POSTURE = 0.01
# Below this angle, closed forms lose digits and two terms of their series are exact [rad].
_SMALL = 1e-2


class Plan(NamedTuple):
    """The targets of all poses, without the numbers that differ from pose to pose."""

    row: Ints1  # the body that carries the frame of each target; −1 for the centre of mass, shape (t,)
    aims: Ints1  # 1 if the frame's x axis points at the target's position, shape (t,)
    weights: Floats2  # of the six errors, shape (t, 6)
    support: float  # weight of the distance by which the centre of mass misses its margin; 0 without a support target
    posture: float  # weight of the differences to the posture [per rad]
    stance: int  # 0 for the left foot, 1 for the right one, 2 for both
    as_is: bool  # whether to keep a start that meets all targets
    tolerance: float  # the largest error of a target that is met [m, rad]
    steps: int  # largest number of steps of one search


class State(NamedTuple):
    """A configuration and its errors, for t targets."""

    x: Floats  # the variables
    T: Floats  # T_world_torso
    e: Floats  # weighted errors, six of each target, shape (6 t,)
    J: Floats  # their derivatives, shape (6 t, moving)
    residuals: Floats  # distance and angle in the components with a weight, and the norm of e, shape (t, 3) [m, rad]
    com: Floats
    com_J: Floats  # shape (3, moving)
    sums: Floats  # ½ (Σ e² + missing margin²), ½ Σ posture², excess of joints over limits, missing margin; shape (4,)


@both_ways
def new_state(body: Body, variables: int, targets: int) -> State:
    """Allocate a state."""
    n, m = body.moving, TARGET_ROWS * targets
    return State(
        np.zeros(variables), np.zeros((4, 4)), np.zeros(m), np.zeros((m, n)), np.zeros((targets, 3)),
        np.zeros(3), np.zeros((3, n)), np.zeros(4),
    )  # fmt: skip


@both_ways
def errors_at(body: Body, plan: Plan, frames: Floats, targets: Floats, state: State) -> None:
    """Write the weighted errors of all targets and their derivatives into a state with known x and T.

    `frames` are the poses of the frames in the bodies that carry them, `targets` those in the world, shape (t, 4, 4).
    """
    n, rows = body.moving, len(body.parent)
    e, J, com, com_J = state.e, state.J, state.com, state.com_J
    R, p, below = np.empty((rows, 3, 3)), np.empty((rows, 3)), np.empty((rows, 4))
    place_all(body, state.x, state.T, R, p)
    torso = np.zeros((6, n))
    standing = 0 if plan.stance == BOTH else plan.stance
    add_chain(body, body.legs[standing, JOINTS - 1], -1.0, R, p, torso)
    centre_of_mass(body, R, p, below, com)
    com_velocities(body, R, p, torso, below, com, com_J)
    e[:] = 0.0
    J[:] = 0.0
    twists, T = np.empty((6, n)), np.empty((4, 4))
    for t in range(len(plan.row)):
        weights, first = plan.weights[t], TARGET_ROWS * t
        if plan.row[t] < 0:
            T[:] = np.eye(4)
            T[:3, 3], twists[:3], twists[3:] = com, com_J, 0.0
        else:
            frame_pose(R, p, plan.row[t], frames[t], T)
            twists[:] = torso
            add_chain(body, plan.row[t], 1.0, R, p, twists)
            # From the velocity at the world's origin to that at the frame's origin.
            for k in range(n):
                w0, w1, w2 = twists[3, k], twists[4, k], twists[5, k]
                twists[0, k] += w1 * T[2, 3] - w2 * T[1, 3]
                twists[1, k] += w2 * T[0, 3] - w0 * T[2, 3]
                twists[2, k] += w0 * T[1, 3] - w1 * T[0, 3]
        _position(T, targets[t], twists, weights, e[first : first + 3], J[first : first + 3])
        if plan.aims[t] == 1:
            _aim(T, targets[t], twists, weights, e[first : first + 6], J[first : first + 6])
        elif weights[3] > 0.0 or weights[4] > 0.0 or weights[5] > 0.0:
            _turn(T, targets[t], twists, weights, e[first + 3 : first + 6], J[first + 3 : first + 6])
        state.residuals[t] = 0.0
        for i in range(TARGET_ROWS):
            if weights[i] > 0.0:
                state.residuals[t, i // 3] += (e[first + i] / weights[i]) ** 2
                state.residuals[t, 2] += e[first + i] ** 2
        state.residuals[t] = np.sqrt(state.residuals[t])


@both_ways
def _position(T: Floats, target: Floats, twists: Floats, weights: Floats, e: Floats, J: Floats) -> None:
    """Write errors w · R_tᵀ (p_t − p) and their derivatives."""
    d0, d1, d2 = target[0, 3] - T[0, 3], target[1, 3] - T[1, 3], target[2, 3] - T[2, 3]
    for i in range(3):
        if weights[i] > 0.0:
            a0, a1, a2 = weights[i] * target[0, i], weights[i] * target[1, i], weights[i] * target[2, i]
            e[i] = a0 * d0 + a1 * d1 + a2 * d2
            for k in range(twists.shape[1]):
                J[i, k] = -(a0 * twists[0, k] + a1 * twists[1, k] + a2 * twists[2, k])


@both_ways
def _turn(T: Floats, target: Floats, twists: Floats, weights: Floats, e: Floats, J: Floats) -> None:
    """Write errors w · log(Rᵀ R_t) and their derivatives −w · J_l⁻¹ Rᵀ ω."""
    M = np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            M[i, j] = T[0, i] * target[0, j] + T[1, i] * target[1, j] + T[2, i] * target[2, j]
    v0, v1, v2 = rotation_vector(M[0, 0], M[0, 1], M[0, 2], M[1, 0], M[1, 1], M[1, 2], M[2, 0], M[2, 1], M[2, 2])
    squares = v0 * v0 + v1 * v1 + v2 * v2
    c = inverse_jacobian_factor(squares)
    x, y, z = weights[3], weights[4], weights[5]
    e[0], e[1], e[2] = x * v0, y * v1, z * v2
    d = 1.0 - c * squares  # [v×]² = v vᵀ − φ² 1
    for k in range(twists.shape[1]):
        w0, w1, w2 = twists[3, k], twists[4, k], twists[5, k]
        u0 = T[0, 0] * w0 + T[1, 0] * w1 + T[2, 0] * w2
        u1 = T[0, 1] * w0 + T[1, 1] * w1 + T[2, 1] * w2
        u2 = T[0, 2] * w0 + T[1, 2] * w1 + T[2, 2] * w2
        along = c * (v0 * u0 + v1 * u1 + v2 * u2)
        J[0, k] = -x * (d * u0 + along * v0 - 0.5 * (v1 * u2 - v2 * u1))
        J[1, k] = -y * (d * u1 + along * v1 - 0.5 * (v2 * u0 - v0 * u2))
        J[2, k] = -z * (d * u2 + along * v2 - 0.5 * (v0 * u1 - v1 * u0))


@both_ways
def _aim(T: Floats, target: Floats, twists: Floats, weights: Floats, e: Floats, J: Floats) -> None:
    """Write errors w · φ (−d_z, d_y)/sin φ about the y and z axes, and their derivatives, into the last two of six."""
    u = np.empty(3)
    for i in range(3):
        u[i] = 0.0
        for j in range(3):
            u[i] += T[j, i] * (target[j, 3] - T[j, 3])
    far = math.sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2])
    if far < 1e-9:  # a camera at the point itself sees it
        return
    dx, dy, dz = u[0] / far, u[1] / far, u[2] / far
    sine = math.hypot(dy, dz)
    if sine > _SMALL:
        ratio = math.atan2(sine, dx) / sine
        slope = (1.0 - ratio * dx) / (sine * sine)  # d(φ/sin φ)/dφ = slope · sin φ
    elif dx > 0.0:
        ratio, slope = 1.0 + sine * sine / 6.0, 1.0 / 3.0
    else:  # straight behind the camera, all rotations have the same angle
        ratio, slope, dy = math.pi / _SMALL, 0.0, max(dy, _SMALL)
    y, z = weights[4], weights[5]
    e[4], e[5] = -y * ratio * dz, z * ratio * dy
    for k in range(twists.shape[1]):
        w0, w1, w2 = twists[3, k], twists[4, k], twists[5, k]
        a0 = T[0, 0] * w0 + T[1, 0] * w1 + T[2, 0] * w2
        a1 = T[0, 1] * w0 + T[1, 1] * w1 + T[2, 1] * w2
        a2 = T[0, 2] * w0 + T[1, 2] * w1 + T[2, 2] * w2
        v0 = (T[0, 0] * twists[0, k] + T[1, 0] * twists[1, k] + T[2, 0] * twists[2, k]) / far
        v1 = (T[0, 1] * twists[0, k] + T[1, 1] * twists[1, k] + T[2, 1] * twists[2, k]) / far
        v2 = (T[0, 2] * twists[0, k] + T[1, 2] * twists[1, k] + T[2, 2] * twists[2, k]) / far
        # The direction changes by the part of d × ω − v/|u| perpendicular to itself.
        g0, g1, g2 = dy * a2 - dz * a1 - v0, dz * a0 - dx * a2 - v1, dx * a1 - dy * a0 - v2
        along = g0 * dx + g1 * dy + g2 * dz
        g0, g1, g2 = g0 - along * dx, g1 - along * dy, g2 - along * dz
        # −d(cos φ) = sin φ dφ, so that d(φ/sin φ) = −slope · d(cos φ).
        change = -slope * g0
        J[4, k] = -y * (ratio * g2 + change * dz)
        J[5, k] = z * (ratio * g1 + change * dy)


# --- Standing: the torso and the legs for fixed feet.
#
# The six joints of the first foot's leg determine the pose of the torso. The leg of a second foot follows in closed
# form (`solve_leg`), by the branch nearest to its last values, and needs its own value of HipYawPitch. Both hips share
# one motor, so the torso is moved until both values agree: Newton's method on h₂ − h₁ over the joints of the first leg.
# Both feet are then met to rounding.

# Hips agree if they differ by less than the first [rad]; the second applies if rounding prevents the first.
_AGREE, _NEARLY = 1e-14, 1e-12
_MAX_STEPS = 15
# Largest change of a joint of the first leg in one step [rad].
_MAX_CHANGE = 0.3


class SecondLeg(NamedTuple):
    """The right leg, for the closed form, whose value = multiplier · variable + offset."""

    leg: Leg
    ranges: Ranges
    multiplier: tuple[float, ...]
    offset: tuple[float, ...]


@both_ways
def torso_over_foot(
    body: Body, side: int, feet: Floats, x: Floats, R: Floats, p: Floats, T_world_torso: Floats
) -> None:
    """Write the pose of the torso for which a foot (0 for the left) is met; R and p as in `foot_in_torso`."""
    T_torso_foot, T_foot_torso = np.empty((4, 4)), np.empty((4, 4))
    foot_in_torso(body, side, x, R, p, T_torso_foot)
    inverted(T_torso_foot, T_foot_torso)
    multiplied(feet[side], T_foot_torso, T_world_torso)


@both_ways
def foot_in_torso(body: Body, side: int, x: Floats, R: Floats, p: Floats, T: Floats) -> None:
    """Write T_torso_foot for the joints of a leg into T, and the poses of these joints into R and p."""
    for i in range(3):
        p[0, i] = 0.0
        for j in range(3):
            R[0, i, j] = 1.0 if i == j else 0.0
    for k in range(JOINTS):
        place_chain(body, body.legs[side, k], x, R, p)
    frame_pose(R, p, body.legs[side, JOINTS - 1], body.ankle_to_sole[side], T)


@both_ways
def stand_on_both(body: Body, second_leg: SecondLeg, feet: Floats, x: Floats, T_world_torso: Floats) -> bool:
    """Change the joints of both legs so that both feet are met; False if that fails nearby."""
    rows, n = len(body.parent), body.moving
    R, p = np.zeros((rows, 3, 3)), np.zeros((rows, 3))
    T_torso_world, T_torso_foot = np.empty((4, 4)), np.empty((4, 4))
    target, values, width = np.empty(16), np.empty(JOINTS), JOINTS + EXTRAS
    q, branches, report = np.empty(JOINTS), np.empty(MAX_BRANCHES * width), np.empty(BEST + JOINTS)
    first, second = np.empty((6, n)), np.empty((6, n))
    hip = body.legs[1, 0]
    shared = body.variable[hip]
    last = math.inf
    for _ in range(_MAX_STEPS):
        torso_over_foot(body, 0, feet, x, R, p, T_world_torso)
        inverted(T_world_torso, T_torso_world)
        multiplied(T_torso_world, feet[1], T_torso_foot)
        for i in range(4):
            for j in range(4):
                target[4 * i + j] = T_torso_foot[i, j]
        for k in range(JOINTS):
            values[k] = second_leg.multiplier[k] * x[body.variable[body.legs[1, k]]] + second_leg.offset[k]
        selection = Selection(second_leg.ranges, values, False)
        count = solve_leg(second_leg.leg, target, selection, Workspace(q, branches, report))
        first[:] = 0.0
        add_chain(body, body.legs[0, JOINTS - 1], 1.0, R, p, first)
        if count == 0:
            if report[REASON] != OUT_OF_REACH or not _nearer(body, T_torso_foot, report[NEEDED], p[hip], first, x):
                return False
            continue
        for k in range(1, JOINTS):
            x[body.variable[body.legs[1, k]]] = (branches[k] - second_leg.offset[k]) / second_leg.multiplier[k]
        asked = (branches[0] - second_leg.offset[0]) / second_leg.multiplier[0]
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
    """Take one step of Newton's method on the difference of the two hips.

    With both feet fixed, a twist ξ of the torso requires S₂ q̇ = −ξ of the second leg. Its hip then moves by −y·ξ,
    where S₂ᵀ y = (1, 0, …, 0), and ξ = −S₁ q̇₁. Straight knees make S₂ singular without changing y·ξ: hence the
    damping.
    """
    gram, y = np.zeros(36), np.empty(6)
    for i in range(6):
        y[i] = second[i, shared]
        for j in range(6):
            for k in range(JOINTS):
                v = body.variable[body.legs[1, k]]
                gram[6 * i + j] += second[i, v] * second[j, v]
        gram[7 * i] += 1e-10
    if not cholesky(gram, 6, 6, 0.0):
        return False
    solve_cholesky(gram, 6, 6, y)
    slope = np.empty(JOINTS)
    for k in range(JOINTS):
        v = body.variable[body.legs[0, k]]
        slope[k] = -1.0 if v == shared else 0.0
        for i in range(6):
            slope[k] += y[i] * first[i, v]
    return _change_leg(body, -gap, slope, x)


@both_ways
def _nearer(body: Body, T_torso_foot: Floats, missing: float, hip: Floats, first: Floats, x: Floats) -> bool:
    """Move the torso so that the second hip gets nearer to its ankle by the missing distance."""
    T_foot_ankle, T_torso_ankle = np.empty((4, 4)), np.empty((4, 4))
    inverted(body.ankle_to_sole[1], T_foot_ankle)
    multiplied(T_torso_foot, T_foot_ankle, T_torso_ankle)
    towards = T_torso_ankle[:3, 3] - hip
    far = math.sqrt(towards[0] * towards[0] + towards[1] * towards[1] + towards[2] * towards[2])
    slope = np.empty(JOINTS)
    for k in range(JOINTS):
        v = body.variable[body.legs[0, k]]
        v0 = first[0, v] + first[4, v] * hip[2] - first[5, v] * hip[1]
        v1 = first[1, v] + first[5, v] * hip[0] - first[3, v] * hip[2]
        v2 = first[2, v] + first[3, v] * hip[1] - first[4, v] * hip[0]
        slope[k] = -(towards[0] * v0 + towards[1] * v1 + towards[2] * v2) / far
    return _change_leg(body, missing + 1e-9, slope, x)


@both_ways
def _change_leg(body: Body, wanted: float, slope: Floats, x: Floats) -> bool:
    """Apply the smallest change of the first leg's joints that changes a number with gradient `slope` by `wanted`."""
    squares = 0.0
    for k in range(JOINTS):
        squares += slope[k] * slope[k]
    if not squares > 1e-12:
        return False
    factor = wanted / squares
    largest = 0.0
    for k in range(JOINTS):
        largest = max(largest, abs(factor * slope[k]))
    if largest > _MAX_CHANGE:
        factor *= _MAX_CHANGE / largest
    for k in range(JOINTS):
        x[body.variable[body.legs[0, k]]] += factor * slope[k]
    return True
