"""The search for a whole-body pose: Levenberg–Marquardt steps inside the limits, the standing feet met after each.

After each step of `body_step`, `stance` puts the feet where they belong. A step is taken when it lessens the sum of
the squares; what the legs are outside their limits after it counts with a weight against which no target prevails.

Source: Nielsen, Damping parameter in Marquardt's method, IMM-REP-1999-05; Nocedal and Wright, Numerical Optimization,
18.3, for the merit function and the second-order correction.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._kernels.cache import both_ways
from nao_kin.ik.body import Body, Ints, add_chain, body_types, place_all
from nao_kin.ik.body_errors import (
    MOST_ROWS,
    Legs,
    Plan,
    clipped,
    errors_at,
    legs_types,
    limit_rows,
    outside,
    plan_types,
    stand_on_both,
    torso_over_foot,
)
from nao_kin.ik.compiling import kept
from nao_kin.ik.leg import JOINTS
from nao_kin.ik.quadratic_program import quadratic_program

# --- One pose to find, what is known of a configuration on the way, and the step from it.
#
# A step δ of the joint values, with s the distance by which the centre of mass lacks its margin, solves
#
#     min ½‖e + J δ‖² + ½ w_s² s² + ½ w_p² ‖x + δ − x_posture‖² + ½ λ ‖δ‖²
#
# such that a second foot stays where it is to first order, all joints stay inside their limits, and no joint moves by
# more than half a radian.

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


# --- The search for a whole-body pose: Levenberg–Marquardt steps inside the limits, the standing feet met after each.

# How a search ended.
SETTLED, REACHED, STOPPED, NOT_STANDING = range(4)
# Places in a report.
STATUS, STEPS, START, LACKING = range(4)

_FIRST_DAMPING, _LEAST_DAMPING, _MOST_DAMPING, _FLOOR = 0.1, 1e-6, 1e9, 1e-10
_LEAST_GAIN, _GOOD_GAIN = 1e-3, 0.75
# What legs are outside their limits after a step weighs this times the slope of the errors.
_PENALTY, _LEAST_PENALTY = 3.0, 1e-3
# A pose outside the limits is worse than any inside.
_OUT_OF_THE_QUESTION = 1e9
# While the posture pulls, the knees of the search are bent by this, and the search begins with more [rad].
_LEAST_BEND, _FIRST_BEND = 0.02, 0.3
# The posture has done its part when a step lessens the sum by less than this share.
_ENOUGH = 0.02
_MOST_WITH_POSTURE = 20
# The step that lessens the sum by less than this share of it, and of nothing else, is the last.
_FLAT = 1e-6
_FOOT_TOLERANCE = 1e-6
# What standing may change of a configuration that stands already [rad].
_ROUNDING = 1e-9


@both_ways
def _stand(body: Body, legs: Legs, stance: int, feet: Floats, x: Floats, T: Floats) -> bool:
    """Put the torso, and with both feet standing the legs, where the feet belong."""
    if stance == BOTH:
        return stand_on_both(body, legs, feet, x, T)
    rows = len(body.parent)
    torso_over_foot(body, stance, feet, x, np.zeros((rows, 3, 3)), np.zeros((rows, 3)), T)
    return True


@both_ways
def search(
    body: Body, legs: Legs, task: Task, tolerance: float, most: int, here: Point, there: Point
) -> tuple[int, int]:
    """Lessen the errors from a configuration that stands; how that ended, and after how many steps.

    Args:
        body: the robot.
        legs: the closed forms of its legs.
        task: what to find.
        tolerance: of a target that is met [m, rad].
        most: steps.
        here: where the search begins, with x and T; and ends.
        there: for configurations that are tried.
    """
    n = body.moving
    most_rows = 7 + 2 * n + len(task.planes) + 2 * body.table.shape[0] * (body.table.shape[2] + 1)
    A, rooms, b = np.zeros((most_rows, n + 1)), np.zeros(most_rows), np.zeros(most_rows)
    normal, gradient, step = np.empty((n, n)), np.empty(n), np.empty(n + 1)
    lower = body.lower.copy()
    if task.pull > 0.0:
        for side in range(2):
            knee = body.variable[body.legs[side, 3]]
            lower[knee] = max(lower[knee], _LEAST_BEND)
    evaluate(body, task, lower, here)
    there.x[:] = here.x
    damping, growth, is_new = _FIRST_DAMPING, 2.0, True
    equal, count, penalty = 0, 0, 0.0
    for iteration in range(most):
        if task.pull == 0.0 and is_reached(here, tolerance):
            return REACHED, iteration
        if is_new:
            # No target prevails against a limit with this weight.
            penalty = _LEAST_PENALTY + _PENALTY * normal_equations(body, here, normal, gradient)
            equal, count = step_rows(body, task, lower, here, A, rooms)
            is_new = False
        sums = here.sums
        cost = sums[SUM_ERRORS] + sums[SUM_POSTURE] + penalty * sums[SUM_OUTSIDE]
        b[:] = rooms
        better, gain, promised, lessened = False, 0.0, 0.0, 0.0
        for correction in range(2):
            solve_step(
                task, here, 2.0 * damping * sums[SUM_ERRORS] + _FLOOR, normal, gradient, A, b, count, equal, step
            )
            promised = cost - sum_after(task, here, step)
            for v in range(n):
                there.x[v] = here.x[v] + step[v]
            clipped(body, lower, there.x)
            if not _stand(body, legs, task.stance, task.feet, there.x, there.T):
                break
            evaluate(body, task, lower, there)
            lessened = cost - there.sums[SUM_ERRORS] - there.sums[SUM_POSTURE] - penalty * there.sums[SUM_OUTSIDE]
            gain = lessened / promised if promised > 0.0 else 0.0
            better = lessened > 0.0 and gain > _LEAST_GAIN
            if correction == 1 or there.sums[SUM_OUTSIDE] <= INSIDE or gain > _GOOD_GAIN:
                break
            # The legs are curved ways: their joints end elsewhere than the step says, and the next one allows for it.
            for i in range(equal + 1, count):
                if A[i, n] == 0.0:
                    for v in range(n):
                        b[i] -= A[i, v] * (there.x[v] - here.x[v] - step[v])
        if better:
            copy_point(there, here)
            is_new = True
            damping = max(_LEAST_DAMPING, damping * max(1.0 / 3.0, 1.0 - (2.0 * min(gain, 2.0) - 1.0) ** 3))
            growth = 2.0
            if task.pull > 0.0 and lessened <= _ENOUGH * cost:
                return SETTLED, iteration + 1
        else:
            damping, growth = damping * growth, 2.0 * growth
        if promised <= _FLAT * cost or damping >= _MOST_DAMPING:
            return (REACHED if is_reached(here, tolerance) else SETTLED), iteration + 1
    return (REACHED if is_reached(here, tolerance) else STOPPED), most


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
    body: Body, legs: Legs, plan: Plan, task: Task, x: Floats, T: Floats, most: int
) -> tuple[bool, int]:  # fmt: skip
    """Change x until all feet that stand are where they belong; whether they are, and steps taken.

    A second foot that is not near its place is searched for first, as a target of the robot on the other foot.
    """
    feet = task.feet
    if task.stance != BOTH:
        return _stand(body, legs, task.stance, feet, x, T), 0
    here, there = new_point(body, 1), new_point(body, 1)
    here.x[:] = x
    if stand_on_both(body, legs, feet, here.x, T) and outside(body, body.lower, here.x) <= INSIDE:
        x[:] = here.x
        return True, 0
    here.x[:] = x
    _stand(body, legs, 0, feet, here.x, here.T)
    none = np.zeros((0, 3))
    _, steps = search(
        body, legs, Task(plan, 0, feet, feet[1:], none, x, plan.posture), 0.0, _MOST_WITH_POSTURE, here, there
    )
    status, more = search(body, legs, Task(plan, 0, feet, feet[1:], none, x, 0.0), _FOOT_TOLERANCE, most, here, there)
    x[:] = here.x
    return status == REACHED and stand_on_both(body, legs, feet, x, T), steps + more


@both_ways
def _is_fine_as_it_is(body: Body, legs: Legs, task: Task, tolerance: float, here: Point, there: Point) -> bool:
    """Whether a configuration stands and meets all targets already."""
    there.x[:] = here.x
    if not _stand(body, legs, task.stance, task.feet, here.x, here.T):
        return False
    if np.abs(here.x - there.x).max() > _ROUNDING or outside(body, body.lower, here.x) > INSIDE:
        return False
    evaluate(body, task, body.lower, here)
    return is_reached(here, tolerance)


@both_ways
def _only_worst_limb(body: Body, plan: Plan, best: Point, x: Floats) -> None:
    """Keep of a new start the joints that carry the target that is farthest off; all others as in the best pose."""
    worst, largest = -1, plan.support * best.sums[SUM_LACKING]
    for t in range(len(plan.kind)):
        size = math.hypot(plan.weights[t, 0] * best.residuals[t, 0], plan.weights[t, 1] * best.residuals[t, 1])
        if size > largest and plan.row[t] > 0:
            worst, largest = t, size
    if worst < 0:  # the centre of mass, or the torso: that is everything
        return
    kept = x.copy()
    x[:] = best.x
    row = plan.row[worst]
    while row > 0:
        x[body.variable[row]] = kept[body.variable[row]]
        row = body.parent[row]


@both_ways
def solve_body(
    body: Body, legs: Legs, feet_plan: Plan, task: Task, starts: Floats, as_is: bool, tolerance: float, most: int,
    best: Point, report: Floats,
) -> None:  # fmt: skip
    """Search from one start after the other until the targets are met; the best that was found.

    Args:
        body: the robot.
        legs: the closed forms of its legs.
        feet_plan: the second foot as a target.
        task: what to find.
        starts: variables to begin with, the first of them the reference, shape (starts, variables).
        as_is: whether a reference that meets all targets is left as it is.
        tolerance: of a target that is met [m, rad].
        most: steps of one search.
        best: for the result.
        report: for what the constants above name.
    """
    here, there = new_point(body, len(task.plan.kind)), new_point(body, len(task.plan.kind))
    alone = Task(task.plan, task.stance, task.feet, task.targets, task.planes, task.posture, 0.0)
    least, steps = math.inf, 0
    report[STATUS], report[START], report[LACKING] = NOT_STANDING, -1.0, 0.0
    for start in range(len(starts)):
        here.x[:] = starts[start]
        status = REACHED
        if not (start == 0 and as_is and _is_fine_as_it_is(body, legs, alone, tolerance, here, there)):
            here.x[:] = starts[start]
            if start % 2 == 1 and least < math.inf:
                _only_worst_limb(body, task.plan, best, here.x)
            _bend(body, here.x)
            stands, more = _take_stance(body, legs, feet_plan, task, here.x, here.T, most)
            steps += more
            if not stands:
                continue
            # A pull would lead every start back to where the first one got stuck.
            if task.pull > 0.0 and start == 0:
                _, more = search(body, legs, task, tolerance, _MOST_WITH_POSTURE, here, there)
                steps += more
            status, more = search(body, legs, alone, tolerance, most, here, there)
            steps += more
        cost = here.sums[SUM_ERRORS] + (_OUT_OF_THE_QUESTION if here.sums[SUM_OUTSIDE] > INSIDE else 0.0)
        if cost < least or status == REACHED:
            least = cost
            copy_point(here, best)
            report[STATUS], report[START], report[LACKING] = float(status), float(start), here.sums[SUM_LACKING]
        if status == REACHED:
            break
    report[STEPS] = float(steps)


def _types() -> Any:
    from numba import types

    plan, integer = plan_types(), types.int64
    two, three, four = (types.Array(types.float64, axes, "C") for axes in (2, 3, 4))
    sizes = types.int64[::1]
    return types.void(
        body_types(), legs_types(), plan, plan, integer,
        four, four, three, sizes, two, three, types.boolean, types.float64, integer,
        two, three, three, two, two,
    )  # fmt: skip


@kept("bodies", _types, 60.0)
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
    x: Floats,
    T_world_torso: Floats,
    residuals: Floats,
    com: Floats,
    report: Floats,
) -> None:
    """`solve_body` for each of many poses; of `planes` (n, k, 3), pose i has the first `edges[i]`."""
    best = new_point(body, len(plan.kind))
    for i in range(len(x)):
        task = Task(plan, stance, feet[i], targets[i], planes[i, : edges[i]], posture[i], plan.posture)
        solve_body(body, legs, feet_plan, task, starts[i], as_is, tolerance, most, best, report[i])
        x[i], T_world_torso[i], residuals[i], com[i] = best.x, best.T, best.residuals, best.com
