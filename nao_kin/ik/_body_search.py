"""The search for a whole-body pose: Levenberg–Marquardt steps inside the limits, the standing feet met after each.

A step δ of the joint values solves

    min ½‖e + J δ‖² + ½ w_s² s² + ½ w_p² ‖x + δ − x_posture‖² + ½ λ ‖δ‖²

with s the distance by which the centre of mass lacks its margin, such that a second foot stays where it is to first
order, all joints stay inside their limits, and no joint moves by more than half a radian. `_stance` then puts the feet
where they belong. A step is taken when it lessens the sum of the squares; what the legs are outside their limits after
it counts with a weight against which no target prevails.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.ik._body import Body, Ints, add_chain, body_types, place_all
from nao_kin.ik._body_errors import MOST_ROWS, Plan, errors_at, plan_types
from nao_kin.ik._compiling import both_ways, kept
from nao_kin.ik._leg_equations import JOINTS
from nao_kin.ik._limit_rows import clipped, limit_rows, outside
from nao_kin.ik._quadratic_program import quadratic_program
from nao_kin.ik._stance import Legs, legs_types, stand_on_both, torso_over_foot

# How a search ended.
SETTLED, REACHED, STOPPED, NOT_STANDING = range(4)
# Places in a report.
STATUS, STEPS, START, SHORTAGE = range(4)
BOTH = 2

_LONGEST_STEP = 0.5
_FIRST_DAMPING, _LEAST_DAMPING, _MOST_DAMPING, _FLOOR = 0.1, 1e-6, 1e9, 1e-10
_LEAST_GAIN = 1e-3
# A configuration outside by less is inside [rad].
_INSIDE = 2e-10
# While the posture pulls, the knees of the search are bent by this, and the search begins with more [rad].
_LEAST_BEND, _FIRST_BEND = 0.02, 0.3
# The posture has done its part when a step lessens the sum by less than this share.
_ENOUGH = 0.02
_MOST_WITH_POSTURE = 20
# The step that lessens the sum by less than this share of it, and of nothing else, is the last.
_FLAT = 1e-10
_FOOT_TOLERANCE = 1e-6


@both_ways
def _stand(body: Body, legs: Legs, stance: int, feet: Floats, x: Floats, T: Floats) -> bool:
    """Put the torso, and with both feet standing the legs, where the feet belong."""
    if stance == BOTH:
        return stand_on_both(body, legs, feet, x, T)
    rows = len(body.parent)
    torso_over_foot(body, stance, feet, x, np.zeros((rows, 3, 3)), np.zeros((rows, 3)), T)
    return True


@both_ways
def _shortage(planes: Floats, com: Floats) -> float:
    """By how much the centre of mass lacks its margin [m]."""
    s = 0.0
    for k in range(len(planes)):
        s = max(s, planes[k, 2] - planes[k, 0] * com[0] - planes[k, 1] * com[1])
    return s


@both_ways
def _second_foot(body: Body, x: Floats, T: Floats, n: int, A: Floats) -> int:
    """Rows of a step that leave the second foot where it is; their number."""
    rows = len(body.parent)
    R, p = np.empty((rows, 3, 3)), np.empty((rows, 3))
    place_all(body, x, T, R, p)
    twists = np.zeros((6, n))
    add_chain(body, body.legs[0, JOINTS - 1], -1.0, R, p, twists)
    add_chain(body, body.legs[1, JOINTS - 1], 1.0, R, p, twists)
    for i in range(6):
        A[i, :n] = twists[i]
        A[i, n] = 0.0
    return 6


@both_ways
def _is_reached(residuals: Floats, tolerance: float) -> bool:
    for t in range(len(residuals)):
        if residuals[t, 0] > tolerance or residuals[t, 1] > tolerance:
            return False
    return True


@both_ways
def _search(
    body: Body,
    legs: Legs,
    plan: Plan,
    stance: int,
    feet: Floats,
    targets: Floats,
    planes: Floats,
    posture: Floats,
    pull: float,
    tolerance: float,
    most: int,
    x: Floats,
    T: Floats,
    residuals: Floats,
    com: Floats,
) -> tuple[int, int]:
    """Lessen the errors from x on, where the robot stands already; how that ended, and after how many steps.

    Args:
        body: the robot.
        legs: the closed forms of its legs.
        plan: what is asked for.
        stance: 0 for the left foot, 1 for the right one, 2 for both.
        feet: T_world_foot, shape (2, 4, 4).
        targets: see `errors_at`.
        planes: (n_x, n_y, d) with n·com ≥ d where the margin is kept, shape (edges, 3).
        posture: variables to be pulled to.
        pull: weight of that [per rad]; 0 for the targets alone.
        tolerance: of a target that is met [m, rad].
        most: steps.
        x: the variables, changed in place.
        T: T_world_torso, changed in place.
        residuals: for the distances and angles, shape (t, 2).
        com: for the centre of mass.
    """
    n, m, edges = body.moving, MOST_ROWS * len(plan.kind), len(planes)
    last = body.legs[0 if stance == BOTH else stance, JOINTS - 1]
    e, J, com_J = np.empty(m), np.empty((m, n)), np.empty((3, n))
    new_e, new_J, new_com_J = np.empty(m), np.empty((m, n)), np.empty((3, n))
    new_x, new_T = x.copy(), np.empty((4, 4))
    new_residuals, new_com = np.empty((len(plan.kind), 2)), np.empty(3)
    most_rows = 6 + 2 * n + 1 + edges + 2 * body.table.shape[0] * (body.table.shape[2] + 1)
    A, b = np.zeros((most_rows, n + 1)), np.empty(most_rows)
    H, normal = np.empty((n + 1, n + 1)), np.empty((n, n))
    g, gradient, step = np.empty(n + 1), np.empty(n), np.empty(n + 1)
    lower = body.lower.copy()
    if pull > 0.0:
        for side in range(2):
            knee = body.variable[body.legs[side, 3]]
            lower[knee] = max(lower[knee], _LEAST_BEND)
    penalty = max(1e-4, plan.support * plan.support)
    for t in range(len(plan.kind)):
        penalty = max(penalty, plan.weights[t, 0] ** 2, plan.weights[t, 1] ** 2)

    errors_at(body, plan, targets, last, x, T, e, J, residuals, com, com_J)
    short, out = _shortage(planes, com) if plan.support > 0.0 else 0.0, outside(body, lower, x)
    damping, growth = _FIRST_DAMPING, 2.0
    is_new = True
    for iteration in range(most):
        if pull == 0.0 and out <= _INSIDE and short <= tolerance and _is_reached(residuals, tolerance):
            return REACHED, iteration
        squares = (e * e).sum() + (plan.support * short) ** 2
        apart = 0.0
        for v in range(n):
            apart += (x[v] - posture[v]) ** 2
        cost = 0.5 * squares + 0.5 * pull * pull * apart + penalty * out
        if is_new:
            for v in range(n):
                gradient[v] = 0.0
                for w in range(v + 1):
                    normal[v, w] = 0.0
            for i in range(m):
                if e[i] != 0.0 or J[i].any():
                    for v in range(n):
                        if J[i, v] != 0.0:
                            gradient[v] += J[i, v] * e[i]
                            for w in range(v + 1):
                                normal[v, w] += J[i, v] * J[i, w]
            count = _second_foot(body, x, T, n, A) if stance == BOTH else 0
            equal = count
            b[:equal] = 0.0
            if plan.support > 0.0:
                for k in range(edges):
                    for v in range(n):
                        A[count, v] = planes[k, 0] * com_J[0, v] + planes[k, 1] * com_J[1, v]
                    A[count, n] = 1.0
                    b[count] = planes[k, 2] - planes[k, 0] * com[0] - planes[k, 1] * com[1]
                    count += 1
            A[count] = 0.0
            A[count, n] = 1.0
            b[count] = 0.0
            count = limit_rows(body, lower, x, _LONGEST_STEP, A, b, count + 1)
            is_new = False
        weight = damping * squares + _FLOOR * penalty
        for attempt in range(2):
            for v in range(n):
                for w in range(v + 1):
                    H[v, w] = normal[v, w]
                H[v, v] += pull * pull + weight
                g[v] = gradient[v] + pull * pull * (x[v] - posture[v])
                H[n, v] = 0.0
            H[n, n] = plan.support * plan.support if plan.support > 0.0 else 1.0
            g[n] = 0.0
            if quadratic_program(H, g, A, b, count, equal, step):
                break
            # Limits that cannot be met in one step are at least not left further.
            for i in range(equal + 1, count):
                b[i] = min(b[i], 0.0) if A[i, n] == 0.0 else b[i]
            step[:] = 0.0
        model = 0.5 * pull * pull * ((x[:n] + step[:n] - posture[:n]) ** 2).sum() + 0.5 * (plan.support * step[n]) ** 2
        for i in range(m):
            value = e[i]
            for v in range(n):
                value += J[i, v] * step[v]
            model += 0.5 * value * value
        promised = cost - model
        new_x[:] = x
        new_x[:n] += step[:n]
        clipped(body, lower, new_x)
        stands = _stand(body, legs, stance, feet, new_x, new_T)
        better, gain, new_cost, new_short, new_out = False, 0.0, math.inf, 0.0, 0.0
        if stands:
            errors_at(body, plan, targets, last, new_x, new_T, new_e, new_J, new_residuals, new_com, new_com_J)
            new_short = _shortage(planes, new_com) if plan.support > 0.0 else 0.0
            new_out = outside(body, lower, new_x)
            new_cost = 0.5 * ((new_e * new_e).sum() + (plan.support * new_short) ** 2) + penalty * new_out
            new_cost += 0.5 * pull * pull * ((new_x[:n] - posture[:n]) ** 2).sum()
            gain = (cost - new_cost) / promised if promised > 0.0 else 0.0
            better = new_cost < cost and gain > _LEAST_GAIN
        flat = promised <= _FLAT * cost
        if better:
            is_new = True
            lessened = cost - new_cost
            x[:], T[:], residuals[:], com[:] = new_x, new_T, new_residuals, new_com
            e[:], J[:], com_J[:] = new_e, new_J, new_com_J
            short, out = new_short, new_out
            damping = max(_LEAST_DAMPING, damping * max(1.0 / 3.0, 1.0 - (2.0 * min(gain, 2.0) - 1.0) ** 3))
            growth = 2.0
            if pull > 0.0 and lessened <= _ENOUGH * cost:
                return SETTLED, iteration + 1
        else:
            damping, growth = damping * growth, 2.0 * growth
        if flat or damping >= _MOST_DAMPING:
            reached = out <= _INSIDE and short <= tolerance and _is_reached(residuals, tolerance)
            return (REACHED if reached else SETTLED), iteration + 1
    reached = out <= _INSIDE and short <= tolerance and _is_reached(residuals, tolerance)
    return (REACHED if reached else STOPPED), most


@both_ways
def _bend(body: Body, x: Floats) -> None:
    """Bend knees that are nearly straight: a straight leg cannot tell how it would bend."""
    for side in range(2):
        knee = body.variable[body.legs[side, 3]]
        more = _FIRST_BEND - x[knee]
        if more > 0.0:
            x[knee] += more
            x[body.variable[body.legs[side, 2]]] -= 0.5 * more
            x[body.variable[body.legs[side, 4]]] -= 0.5 * more
    clipped(body, body.lower, x)


@both_ways
def _take_stance(
    body: Body, legs: Legs, feet_plan: Plan, stance: int, feet: Floats, x: Floats, T: Floats, most: int
) -> tuple[bool, int]:
    """Change x until both feet are where they belong, the second one searched for as a target; steps taken."""
    if stance != BOTH:
        return _stand(body, legs, stance, feet, x, T), 0
    near = x.copy()
    if stand_on_both(body, legs, feet, near, T) and outside(body, body.lower, near) <= _INSIDE:
        x[:] = near
        return True, 0
    none, residuals, com = np.zeros((0, 3)), np.empty((1, 2)), np.empty(3)
    steps = 0
    begin = x.copy()
    for pull in (feet_plan.posture, 0.0):
        torso_over_foot(body, 0, feet, x, np.zeros((len(body.parent), 3, 3)), np.zeros((len(body.parent), 3)), T)
        limit = _MOST_WITH_POSTURE if pull > 0.0 else most
        status, more = _search(
            body, legs, feet_plan, 0, feet, feet[1:], none, begin, pull, _FOOT_TOLERANCE, limit, x, T, residuals, com
        )
        steps += more
    if status != REACHED:
        return False, steps
    return stand_on_both(body, legs, feet, x, T), steps


@both_ways
def solve_body(
    body: Body,
    legs: Legs,
    plan: Plan,
    feet_plan: Plan,
    stance: int,
    feet: Floats,
    targets: Floats,
    planes: Floats,
    posture: Floats,
    starts: Floats,
    as_is: bool,
    tolerance: float,
    most: int,
    best: Floats,
    T_world_torso: Floats,
    residuals: Floats,
    com: Floats,
    report: Floats,
) -> None:
    """Search from one start after the other until the targets are met; the best that was found.

    Args:
        starts: variables to begin with, the first of them the reference, shape (starts, n).
        as_is: whether a reference that meets all targets is left as it is.
        best: for the variables.
        report: for what the constants above name.
        body, legs, plan, stance, feet, targets, planes, posture, tolerance, most, T_world_torso, residuals, com: see
            `_search`.
        feet_plan: the second foot as a target.
    """
    least, steps = math.inf, 0
    T, found, centre = np.empty((4, 4)), np.empty((len(plan.kind), 2)), np.empty(3)
    report[STATUS], report[STEPS], report[START], report[SHORTAGE] = NOT_STANDING, 0.0, -1.0, 0.0
    for start in range(len(starts)):
        x = starts[start].copy()
        is_standing, status = False, SETTLED
        if start == 0 and as_is:
            is_standing = _stand(body, legs, stance, feet, x, T) and outside(body, body.lower, x) <= _INSIDE
            is_standing = is_standing and np.abs(x - starts[start]).max() <= 1e-9
            if is_standing:
                status, more = _search(
                    body, legs, plan, stance, feet, targets, planes, posture, 0.0, tolerance, 1, x, T, found, centre
                )
                is_standing = status == REACHED
            if not is_standing:
                x[:] = starts[start]
        if not is_standing:
            _bend(body, x)
            stands, more = _take_stance(body, legs, feet_plan, stance, feet, x, T, most)
            steps += more
            if not stands:
                continue
            for stage in range(2):
                pull, limit = (plan.posture, _MOST_WITH_POSTURE) if stage == 0 else (0.0, most)
                if stage == 1 or pull > 0.0:
                    status, more = _search(
                        body, legs, plan, stance, feet, targets, planes, posture, pull, tolerance, limit, x, T, found,
                        centre,
                    )  # fmt: skip
                    steps += more
        cost = (plan.support * _shortage(planes, centre)) ** 2
        for t in range(len(plan.kind)):
            cost += (plan.weights[t, 0] * found[t, 0]) ** 2 + (plan.weights[t, 1] * found[t, 1]) ** 2
        if outside(body, body.lower, x) > _INSIDE:
            cost += 1e6
        if cost < least or status == REACHED:
            least = cost
            best[:], T_world_torso[:], residuals[:], com[:] = x, T, found, centre
            report[STATUS], report[START] = float(status), float(start)
            report[SHORTAGE] = _shortage(planes, centre)
        if status == REACHED:
            break
    report[STEPS] = float(steps)


def _types() -> Any:
    from numba import types

    plan, integer = plan_types(), types.int64
    one, two, three, four = (types.Array(types.float64, axes, "C") for axes in (1, 2, 3, 4))
    sizes = types.int64[::1]
    return types.void(
        body_types(), legs_types(), plan, plan, integer,
        four, four, three, sizes, two, three, types.boolean, types.float64, integer,
        two, three, three, two, two,
    )  # fmt: skip


@kept("bodies", _types)
def whole_bodies(
    body: Body,
    legs: Legs,
    plan: Plan,
    feet_plan: Plan,
    stance: int,
    feet: Floats,
    targets: Floats,
    planes: Floats,
    edges: Ints,
    posture: Floats,
    starts: Floats,
    as_is: bool,
    tolerance: float,
    most: int,
    best: Floats,
    T_world_torso: Floats,
    residuals: Floats,
    com: Floats,
    report: Floats,
) -> None:
    """`solve_body` for each of many poses; of `planes` (n, k, 3), pose i has the first `edges[i]`."""
    for i in range(len(best)):
        solve_body(
            body, legs, plan, feet_plan, stance, feet[i], targets[i], planes[i, : edges[i]], posture[i], starts[i],
            as_is, tolerance, most, best[i], T_world_torso[i], residuals[i], com[i], report[i],
        )  # fmt: skip


BODY_KERNELS = (whole_bodies,)
