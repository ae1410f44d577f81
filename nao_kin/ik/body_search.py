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
    BOTH,
    DEFAULT_POSTURE,
    DEFAULT_WEIGHTS,
    POSE,
    Legs,
    Plan,
    Point,
    errors_at,
    legs_types,
    new_point,
    plan_types,
    stand_on_both,
    torso_over_foot,
)
from nao_kin.ik.compiling import kept
from nao_kin.ik.leg import JOINTS
from nao_kin.ik.limit_regions import Region, clipped, limit_rows, most_rows, outside
from nao_kin.ik.quadratic_program import quadratic_program

# --- One pose to find, what is known of a configuration on the way, and the step from it.
#
# A step δ of the joint values, with s the distance by which the centre of mass lacks its margin, solves
#
#     min ½‖e + J δ‖² + ½ w_s² s² + ½ w_p² ‖x + δ − x_posture‖² + ½ λ ‖δ‖²
#
# such that a second foot stays where it is to first order, all joints stay inside their limits, and no joint moves by
# more than half a radian.

# A configuration outside by less is inside [rad].
INSIDE = 2e-10
_LONGEST_STEP = 0.5
# Places in the sums of a point.
SUM_ERRORS, SUM_POSTURE, SUM_OUTSIDE, SUM_LACKING = range(4)


class Task(NamedTuple):
    """One pose to find.

    Attributes:
        plan: what is asked for.
        feet: T_world_foot, shape (2, 4, 4).
        targets: as `errors_at` takes them.
        planes: (n_x, n_y, d) with n·com ≥ d where the margin is kept, shape (edges, 3).
        posture: variables to be pulled to.
        pull: weight of that [per rad]; 0 for the targets alone.
    """

    plan: Plan
    feet: Floats
    targets: Floats
    planes: Floats
    posture: Floats
    pull: float


@both_ways
def evaluate(body: Body, task: Task, limits: Region, point: Point) -> None:
    """All that is known of a configuration that stands."""
    plan, sums = task.plan, point.sums
    errors_at(body, plan, task.targets, point)
    sums[SUM_LACKING] = lacking(task.planes, point.com) if plan.support > 0.0 else 0.0
    sums[SUM_OUTSIDE] = outside(limits, point.x)
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
def step_rows(body: Body, task: Task, limits: Region, point: Point, A: Floats, b: Floats) -> tuple[int, int]:
    """What a step (δ, s) has to obey, as A (δ, s) ≥ b: number of equations, which are first, and of all rows."""
    n, count = body.moving, 0
    if task.plan.stance == BOTH:  # the second foot stays where it is
        rows = len(body.parent)
        R, p, twists = np.empty((rows, 3, 3)), np.empty((rows, 3)), np.zeros((6, n))
        place_all(body, point.x, point.T, R, p)
        add_chain(body, body.legs[0, JOINTS - 1], -1.0, R, p, twists)
        add_chain(body, body.legs[1, JOINTS - 1], 1.0, R, p, twists)
        A[:6, :n] = twists
        A[:6, n], b[:6] = 0.0, 0.0
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
    return equal, limit_rows(limits, point.x, np.empty(0), np.full(n, _LONGEST_STEP), A, b, count)


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
_OUTSIDE_COST = 1e9
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
def _stand(body: Body, legs: Legs, task: Task, x: Floats, T: Floats) -> bool:
    """Put the torso, and with both feet standing the legs, where the feet belong."""
    if task.plan.stance == BOTH:
        return stand_on_both(body, legs, task.feet, x, T)
    rows = len(body.parent)
    torso_over_foot(body, task.plan.stance, task.feet, x, np.zeros((rows, 3, 3)), np.zeros((rows, 3)), T)
    return True


@both_ways
def search(body: Body, legs: Legs, task: Task, current: Point, trial: Point) -> tuple[int, int]:
    """Lessen the errors from a configuration that stands; how that ended, and after how many steps.

    Args:
        body: the robot.
        legs: the closed forms of its legs.
        task: what to find.
        current: where the search begins, with x and T; and ends.
        trial: for configurations that are tried.
    """
    n, tolerance = body.moving, task.plan.tolerance
    limits, most = body.limits, task.plan.steps
    if task.pull > 0.0:
        limits, most = _with_bent_knees(body), _MOST_WITH_POSTURE
    size = 7 + len(task.planes) + most_rows(limits)
    A, slack, b = np.zeros((size, n + 1)), np.zeros(size), np.zeros(size)
    normal, gradient, step = np.empty((n, n)), np.empty(n), np.empty(n + 1)
    evaluate(body, task, limits, current)
    trial.x[:] = current.x
    damping, growth, is_new = _FIRST_DAMPING, 2.0, True
    equal, count, penalty = 0, 0, 0.0
    for iteration in range(most):
        if task.pull == 0.0 and is_reached(current, tolerance):
            return REACHED, iteration
        if is_new:
            # No target prevails against a limit with this weight.
            penalty = _LEAST_PENALTY + _PENALTY * normal_equations(body, current, normal, gradient)
            equal, count = step_rows(body, task, limits, current, A, slack)
            is_new = False
        sums = current.sums
        cost = sums[SUM_ERRORS] + sums[SUM_POSTURE] + penalty * sums[SUM_OUTSIDE]
        b[:] = slack
        better, gain, promised, lessened = False, 0.0, 0.0, 0.0
        for correction in range(2):
            weight = 2.0 * damping * sums[SUM_ERRORS] + _FLOOR
            solve_step(task, current, weight, normal, gradient, A, b, count, equal, step)
            promised = cost - sum_after(task, current, step)
            for v in range(n):
                trial.x[v] = current.x[v] + step[v]
            clipped(limits, trial.x)
            if not _stand(body, legs, task, trial.x, trial.T):
                break
            evaluate(body, task, limits, trial)
            lessened = cost - trial.sums[SUM_ERRORS] - trial.sums[SUM_POSTURE] - penalty * trial.sums[SUM_OUTSIDE]
            gain = lessened / promised if promised > 0.0 else 0.0
            better = lessened > 0.0 and gain > _LEAST_GAIN
            if correction == 1 or trial.sums[SUM_OUTSIDE] <= INSIDE or gain > _GOOD_GAIN:
                break
            # The legs are curved ways: their joints end elsewhere than the step says, and the next one allows for it.
            for i in range(equal + 1, count):
                if A[i, n] == 0.0:
                    for v in range(n):
                        b[i] -= A[i, v] * (trial.x[v] - current.x[v] - step[v])
        if better:
            copy_point(trial, current)
            is_new = True
            damping = max(_LEAST_DAMPING, damping * max(1.0 / 3.0, 1.0 - (2.0 * min(gain, 2.0) - 1.0) ** 3))
            growth = 2.0
            if task.pull > 0.0 and lessened <= _ENOUGH * cost:
                return SETTLED, iteration + 1
        else:
            damping, growth = damping * growth, 2.0 * growth
        if promised <= _FLAT * cost or damping >= _MOST_DAMPING:
            return (REACHED if is_reached(current, tolerance) else SETTLED), iteration + 1
    return (REACHED if is_reached(current, tolerance) else STOPPED), most


@both_ways
def _with_bent_knees(body: Body) -> Region:
    """The limits of a robot whose knees stay bent."""
    limits, lower = body.limits, body.limits.lower.copy()
    for side in range(2):
        knee = body.variable[body.legs[side, 3]]
        lower[knee] = max(lower[knee], _LEAST_BEND)
    return Region(lower, limits.upper, limits.winding, limits.tables, limits.at, limits.low, limits.high, limits.shared)


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
    clipped(body.limits, x)


@both_ways
def _take_stance(body: Body, legs: Legs, task: Task, x: Floats, T: Floats) -> tuple[bool, int]:
    """Change x until all feet that stand are where they belong; whether they are, and steps taken.

    A second foot that is not near its place is searched for first, as a target of the robot on the other foot.
    """
    if task.plan.stance != BOTH:
        return _stand(body, legs, task, x, T), 0
    current, trial = new_point(body, len(x), 1), new_point(body, len(x), 1)
    current.x[:] = x
    if _stand(body, legs, task, current.x, T) and outside(body.limits, current.x) <= INSIDE:
        x[:] = current.x
        return True, 0
    current.x[:] = x
    weights = np.empty((1, 2))
    weights[0, 0], weights[0, 1] = DEFAULT_WEIGHTS
    plan = Plan(
        np.full(1, POSE), np.full(1, body.legs[1, JOINTS - 1]), body.ankle_to_sole[1:], weights,
        0.0, DEFAULT_POSTURE, 0, False, _FOOT_TOLERANCE, task.plan.steps,
    )  # fmt: skip
    foot = Task(plan, task.feet, task.feet[1:], np.zeros((0, 3)), x, plan.posture)
    _stand(body, legs, foot, current.x, current.T)
    _, first = search(body, legs, foot, current, trial)
    status, second = search(body, legs, without_pull(foot), current, trial)
    x[:] = current.x
    return status == REACHED and _stand(body, legs, task, x, T), first + second


@both_ways
def without_pull(task: Task) -> Task:
    """The same for the targets alone."""
    return Task(task.plan, task.feet, task.targets, task.planes, task.posture, 0.0)


@both_ways
def _is_fine_as_it_is(body: Body, legs: Legs, task: Task, current: Point, trial: Point) -> bool:
    """Whether a configuration stands and meets all targets already."""
    trial.x[:] = current.x
    if not _stand(body, legs, task, current.x, current.T):
        return False
    if np.abs(current.x - trial.x).max() > _ROUNDING or outside(body.limits, current.x) > INSIDE:
        return False
    evaluate(body, task, body.limits, current)
    return is_reached(current, task.plan.tolerance)


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
def solve_body(body: Body, legs: Legs, task: Task, starts: Floats, best: Point, report: Floats) -> None:
    """Search from one start after the other until the targets are met; the best that was found.

    Args:
        body: the robot.
        legs: the closed forms of its legs.
        task: what to find.
        starts: variables to begin with, the first of them the reference, shape (starts, variables).
        best: for the result.
        report: for what the constants above name.
    """
    variables, targets = len(best.x), len(task.plan.kind)
    current, trial = new_point(body, variables, targets), new_point(body, variables, targets)
    alone = without_pull(task)
    least, steps = math.inf, 0
    report[STATUS], report[START], report[LACKING] = NOT_STANDING, -1.0, 0.0
    for start in range(len(starts)):
        current.x[:] = starts[start]
        status = REACHED
        if not (start == 0 and task.plan.as_is and _is_fine_as_it_is(body, legs, alone, current, trial)):
            current.x[:] = starts[start]
            if start % 2 == 1 and least < math.inf:
                _only_worst_limb(body, task.plan, best, current.x)
            _bend(body, current.x)
            stands, more = _take_stance(body, legs, task, current.x, current.T)
            steps += more
            if not stands:
                continue
            # A pull would lead every start back to where the first one got stuck.
            if task.pull > 0.0 and start == 0:
                _, more = search(body, legs, task, current, trial)
                steps += more
            status, more = search(body, legs, alone, current, trial)
            steps += more
        cost = current.sums[SUM_ERRORS] + (_OUTSIDE_COST if current.sums[SUM_OUTSIDE] > INSIDE else 0.0)
        if cost < least or status == REACHED:
            least = cost
            copy_point(current, best)
            report[STATUS], report[START], report[LACKING] = float(status), float(start), current.sums[SUM_LACKING]
        if status == REACHED:
            break
    report[STEPS] = float(steps)


class Poses(NamedTuple):
    """n poses to find, by the t targets of one plan.

    Attributes:
        feet: T_world_foot, shape (n, 2, 4, 4).
        targets: as `errors_at` takes them, shape (n, t, 4, 4).
        planes: half planes of the support polygons, shape (n, k, 3).
        edges: how many of them count, shape (n,).
        posture: variables to be pulled to, shape (n, variables).
        starts: variables where searches begin, shape (n, starts, variables).
    """

    feet: Floats
    targets: Floats
    planes: Floats
    edges: Ints
    posture: Floats
    starts: Floats


class Found(NamedTuple):
    """Where the searches for n poses have ended.

    Attributes:
        x: variables, shape (n, variables).
        T_world_torso: shape (n, 4, 4).
        residuals: distances and angles without weights, shape (n, t, 2) [m, rad].
        com: centres of mass, shape (n, 3).
        report: what the constants above name, shape (n, 4).
    """

    x: Floats
    T_world_torso: Floats
    residuals: Floats
    com: Floats
    report: Floats


def _types() -> Any:
    from numba import types

    two, three, four = (types.Array(types.float64, axes, "C") for axes in (2, 3, 4))
    poses = types.NamedTuple((four, four, three, types.int64[::1], two, three), Poses)
    return types.void(
        body_types(), legs_types(), plan_types(), poses, types.NamedTuple((two, three, three, two, two), Found)
    )


@kept("bodies", _types, 60.0)
def whole_bodies(body: Body, legs: Legs, plan: Plan, poses: Poses, found: Found) -> None:
    """`solve_body` for each of many poses."""
    for i in range(len(found.x)):
        best = new_point(body, found.x.shape[1], len(plan.kind))
        planes = poses.planes[i, : poses.edges[i]]
        task = Task(plan, poses.feet[i], poses.targets[i], planes, poses.posture[i], plan.posture)
        solve_body(body, legs, task, poses.starts[i], best, found.report[i])
        found.x[i], found.T_world_torso[i], found.residuals[i], found.com[i] = best.x, best.T, best.residuals, best.com
