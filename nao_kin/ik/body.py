"""The whole robot as arrays: poses and velocities of its bodies in the world.

Row 0 is the torso; every other row is a joint with all that is fixed to it, after its parent. Twists refer to the
world's origin, so that the columns of the joints add up along a chain. If a foot is fixed, the torso's twist is minus
the sum over the chain of that foot.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from nao_kin._core.arrays import Floats
from nao_kin._kernels.cache import Floats1, Floats2, Floats3, Ints1, Ints2, both_ways
from nao_kin.ik.limit_regions import Region

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
    fixed = body.rotation[row]
    place = body.place[row]
    for i in range(3):
        u0, u1, u2 = R[above, i, 0], R[above, i, 1], R[above, i, 2]
        w0 = u0 * fixed[0, 0] + u1 * fixed[1, 0] + u2 * fixed[2, 0]
        w1 = u0 * fixed[0, 1] + u1 * fixed[1, 1] + u2 * fixed[2, 1]
        w2 = u0 * fixed[0, 2] + u1 * fixed[1, 2] + u2 * fixed[2, 2]
        R[row, i, 0] = w0 * t00 + w1 * t10 + w2 * t20
        R[row, i, 1] = w0 * t01 + w1 * t11 + w2 * t21
        R[row, i, 2] = w0 * t02 + w1 * t12 + w2 * t22
        p[row, i] = p[above, i] + u0 * place[0] + u1 * place[1] + u2 * place[2]


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
