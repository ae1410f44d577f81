"""One pose to find, what is known of a configuration on the way, and the step from it.

A step δ of the joint values, with s the distance by which the centre of mass lacks its margin, solves

    min ½‖e + J δ‖² + ½ w_s² s² + ½ w_p² ‖x + δ − x_posture‖² + ½ λ ‖δ‖²

such that a second foot stays where it is to first order, all joints stay inside their limits, and no joint moves by
more than half a radian.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.ik.body.body import Body, add_chain, place_all
from nao_kin.ik.body.body_errors import MOST_ROWS, Plan, errors_at
from nao_kin.ik.body.limit_rows import limit_rows, outside
from nao_kin.ik.body.quadratic_program import quadratic_program
from nao_kin.ik.closed_forms.leg_equations import JOINTS
from nao_kin.ik.compiling import both_ways

BOTH = 2
# A configuration outside by less is inside [rad].
INSIDE = 2e-10
_LONGEST_STEP = 0.5
# Places in the sums of a point.
SUM_ERRORS, SUM_POSTURE, SUM_OUTSIDE, SUM_LACKING = range(4)


class Task(NamedTuple):
    """One pose to find.

    Attributes:
        plan: what is asked for.
        stance: 0 for the left foot, 1 for the right one, 2 for both.
        feet: T_world_foot, shape (2, 4, 4).
        targets: see `errors_at`.
        planes: (n_x, n_y, d) with n·com ≥ d where the margin is kept, shape (edges, 3).
        posture: variables to be pulled to.
        pull: weight of that [per rad]; 0 for the targets alone.
    """

    plan: Plan
    stance: int
    feet: Floats
    targets: Floats
    planes: Floats
    posture: Floats
    pull: float


class Point(NamedTuple):
    """A configuration and what is known there.

    Attributes:
        x: the variables.
        T: T_world_torso, shape (4, 4).
        e: weighted errors.
        J: their derivatives.
        residuals: distances and angles, shape (t, 2).
        com: the centre of mass.
        com_J: its derivative.
        sums: half the squares of the errors and of the margin that is lacking; half those of the posture; what the
            joints are outside their limits; what the margin lacks, shape (4,).
    """

    x: Floats
    T: Floats
    e: Floats
    J: Floats
    residuals: Floats
    com: Floats
    com_J: Floats
    sums: Floats


@both_ways
def new_point(body: Body, targets: int) -> Point:
    """A place for a configuration."""
    n, m = body.moving, MOST_ROWS * targets
    return Point(
        np.zeros(len(body.lower)), np.zeros((4, 4)), np.zeros(m), np.zeros((m, n)), np.zeros((targets, 2)),
        np.zeros(3), np.zeros((3, n)), np.zeros(4),
    )  # fmt: skip


@both_ways
def evaluate(body: Body, task: Task, lower: Floats, point: Point) -> None:
    """All that is known of a configuration that stands."""
    plan, sums = task.plan, point.sums
    last = body.legs[0 if task.stance == BOTH else task.stance, JOINTS - 1]
    errors_at(
        body, plan, task.targets, last, point.x, point.T, point.e, point.J, point.residuals, point.com, point.com_J
    )
    sums[SUM_LACKING] = lacking(task.planes, point.com) if plan.support > 0.0 else 0.0
    sums[SUM_OUTSIDE] = outside(body, lower, point.x)
    sums[SUM_POSTURE] = 0.0
    for v in range(body.moving):
        sums[SUM_POSTURE] += 0.5 * (task.pull * (point.x[v] - task.posture[v])) ** 2
    sums[SUM_ERRORS] = 0.5 * (plan.support * sums[SUM_LACKING]) ** 2
    for i in range(len(point.e)):
        sums[SUM_ERRORS] += 0.5 * point.e[i] * point.e[i]


@both_ways
def copy_point(point: Point, other: Point) -> None:
    """Write one configuration over another."""
    other.x[:], other.T[:], other.e[:], other.J[:] = point.x, point.T, point.e, point.J
    other.residuals[:], other.com[:], other.com_J[:], other.sums[:] = (
        point.residuals, point.com, point.com_J, point.sums,
    )  # fmt: skip


@both_ways
def lacking(planes: Floats, com: Floats) -> float:
    """By how much the centre of mass lacks its margin [m]."""
    s = 0.0
    for k in range(len(planes)):
        s = max(s, planes[k, 2] - planes[k, 0] * com[0] - planes[k, 1] * com[1])
    return float(s)


@both_ways
def is_reached(point: Point, tolerance: float) -> bool:
    """Whether all targets are met inside the limits."""
    if point.sums[SUM_OUTSIDE] > INSIDE or point.sums[SUM_LACKING] > tolerance:
        return False
    for t in range(len(point.residuals)):
        if point.residuals[t, 0] > tolerance or point.residuals[t, 1] > tolerance:
            return False
    return True


@both_ways
def normal_equations(body: Body, point: Point, normal: Floats, gradient: Floats) -> float:
    """JᵀJ, its lower triangle, and Jᵀe, written into (n, n) and (n,); the length of the latter."""
    n, J = body.moving, point.J
    gradient[:] = 0.0
    normal[:] = 0.0
    for i in range(len(point.e)):
        for v in range(n):
            value = J[i, v]
            if value != 0.0:
                gradient[v] += value * point.e[i]
                for w in range(v + 1):
                    normal[v, w] += value * J[i, w]
    squares = 0.0
    for v in range(n):
        squares += gradient[v] * gradient[v]
    return math.sqrt(squares)


@both_ways
def step_rows(body: Body, task: Task, lower: Floats, point: Point, A: Floats, b: Floats) -> tuple[int, int]:
    """What a step (δ, s) has to obey, as A (δ, s) ≥ b: number of equations, which are first, and of all rows."""
    n, count = body.moving, 0
    if task.stance == BOTH:  # the second foot stays where it is
        rows = len(body.parent)
        R, p, twists = np.empty((rows, 3, 3)), np.empty((rows, 3)), np.zeros((6, n))
        place_all(body, point.x, point.T, R, p)
        add_chain(body, body.legs[0, JOINTS - 1], -1.0, R, p, twists)
        add_chain(body, body.legs[1, JOINTS - 1], 1.0, R, p, twists)
        for i in range(6):
            A[i, :n] = twists[i]
            A[i, n], b[i] = 0.0, 0.0
        count = 6
    equal = count
    A[count] = 0.0
    A[count, n], b[count] = 1.0, 0.0  # s ≥ 0
    count += 1
    if task.plan.support > 0.0:  # n·(com + J δ) + s ≥ d
        planes = task.planes
        for k in range(len(planes)):
            for v in range(n):
                A[count, v] = planes[k, 0] * point.com_J[0, v] + planes[k, 1] * point.com_J[1, v]
            A[count, n] = 1.0
            b[count] = planes[k, 2] - planes[k, 0] * point.com[0] - planes[k, 1] * point.com[1]
            count += 1
    return equal, limit_rows(body, lower, point.x, _LONGEST_STEP, A, b, count)


@both_ways
def solve_step(
    task: Task, point: Point, damping: float, normal: Floats, gradient: Floats,
    A: Floats, b: Floats, count: int, equal: int, step: Floats,
) -> None:  # fmt: skip
    """The step (δ, s), written into (n + 1,)."""
    n = len(gradient)
    H, g = np.zeros((n + 1, n + 1)), np.zeros(n + 1)
    squared, support = task.pull * task.pull, task.plan.support
    for _ in range(2):
        for v in range(n):
            for w in range(v + 1):
                H[v, w] = normal[v, w]
            H[v, v] += squared + damping
            g[v] = gradient[v] + squared * (point.x[v] - task.posture[v])
            H[n, v] = 0.0
        H[n, n] = support * support if support > 0.0 else 1.0
        if quadratic_program(H, g, A, b, count, equal, step):
            return
        # Limits that cannot be reached in one step are at least not left further.
        for i in range(equal, count):
            if A[i, n] == 0.0:
                b[i] = min(b[i], 0.0)
    step[:] = 0.0


@both_ways
def sum_after(task: Task, point: Point, step: Floats) -> float:
    """What the linear model makes of the sum after a step."""
    n = len(step) - 1
    model: float = 0.5 * (task.plan.support * step[n]) ** 2
    for i in range(len(point.e)):
        value = point.e[i]
        for v in range(n):
            value += point.J[i, v] * step[v]
        model += 0.5 * value * value
    for v in range(n):
        model += 0.5 * (task.pull * (point.x[v] + step[v] - task.posture[v])) ** 2
    return model
