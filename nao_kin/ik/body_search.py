"""The search for a whole-body pose: Levenberg–Marquardt steps inside the limits, with the standing feet fixed.

After each step, `_stand` restores the feet. A step is accepted if it decreases the sum of squares plus a penalty on the
excess of the legs over their limits. The penalty is steeper than the slope of any target.

Source: Nielsen, Damping parameter in Marquardt's method, IMM-REP-1999-05; Nocedal and Wright, Numerical Optimization,
18.3, for the merit function and the second-order correction.
"""

from __future__ import annotations

import math
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._kernels.cache import CachedKernel, Floats2, Floats3, Floats4, Ints1, both_ways, numba_type
from nao_kin.ik.body_errors import (
    BOTH,
    DEFAULT_POSTURE,
    DEFAULT_WEIGHTS,
    TARGET_ROWS,
    Body,
    Plan,
    SecondLeg,
    State,
    add_chain,
    errors_at,
    new_state,
    place_all,
    stand_on_both,
    torso_over_foot,
)
from nao_kin.ik.closed_form import limb_types
from nao_kin.ik.leg import JOINTS, Leg
from nao_kin.ik.limit_regions import Region, clipped, limit_rows, max_rows, outside
from nao_kin.ik.quadratic_program import quadratic_program

# --- The step from a configuration.
#
# A step δ of the joint values, with s the distance by which the centre of mass misses its margin, solves
#
#     min ½‖e + J δ‖² + ½ w_s² s² + ½ w_p² ‖x + δ − x_posture‖² + ½ λ ‖δ‖²
#
# subject to three conditions: a second foot stays fixed to first order, all joints stay inside their limits, and no
# joint moves by more than half a radian.

# A smaller excess over the limits than this counts as inside [rad].
INSIDE = 2e-10
_MAX_STEP = 0.5
# Indices in the sums of a state.
SUM_ERRORS, SUM_POSTURE, SUM_OUTSIDE, SUM_SHORTFALL = range(4)


class Problem(NamedTuple):
    """One pose to find."""

    plan: Plan
    feet: Floats  # T_world_foot, shape (2, 4, 4)
    frames: Floats  # as in `errors_at`, like the next one
    targets: Floats
    planes: Floats  # (n_x, n_y, d) with n·com ≥ d inside the margin, shape (edges, 3)
    posture: Floats  # preferred variables
    pull: float  # weight of the posture [per rad]; 0 for the targets alone


@both_ways
def evaluate(body: Body, problem: Problem, limits: Region, state: State) -> None:
    """Write errors, derivatives and sums into a state with known x and T."""
    plan, sums = problem.plan, state.sums
    errors_at(body, plan, problem.frames, problem.targets, state)
    sums[SUM_SHORTFALL] = margin_shortfall(problem.planes, state.com) if plan.support > 0.0 else 0.0
    sums[SUM_OUTSIDE] = outside(limits, state.x)
    sums[SUM_POSTURE] = 0.0
    for v in range(body.moving):
        sums[SUM_POSTURE] += 0.5 * (problem.pull * (state.x[v] - problem.posture[v])) ** 2
    sums[SUM_ERRORS] = 0.5 * (plan.support * sums[SUM_SHORTFALL]) ** 2
    for i in range(len(state.e)):
        sums[SUM_ERRORS] += 0.5 * state.e[i] * state.e[i]


@both_ways
def copy_state(new: State, old: State) -> None:
    """Write one state over another."""
    old.x[:], old.T[:], old.e[:], old.J[:] = new.x, new.T, new.e, new.J
    old.residuals[:], old.com[:], old.com_J[:], old.sums[:] = new.residuals, new.com, new.com_J, new.sums


@both_ways
def margin_shortfall(planes: Floats, com: Floats) -> float:
    """Return the distance by which the centre of mass misses its margin [m]."""
    s = 0.0
    for k in range(len(planes)):
        s = max(s, planes[k, 2] - planes[k, 0] * com[0] - planes[k, 1] * com[1])
    return float(s)


@both_ways
def is_reached(state: State, tolerance: float) -> bool:
    """Return whether all targets are met inside the limits."""
    if state.sums[SUM_OUTSIDE] > INSIDE or state.sums[SUM_SHORTFALL] > tolerance:
        return False
    for t in range(len(state.residuals)):
        if state.residuals[t, 0] > tolerance or state.residuals[t, 1] > tolerance:
            return False
    return True


@both_ways
def normal_equations(body: Body, state: State, normal: Floats, gradient: Floats) -> float:
    """Write the lower triangle of JᵀJ into (n, n) and Jᵀe into (n,); return ‖Jᵀe‖."""
    n, J = body.moving, state.J
    gradient[:] = 0.0
    normal[:] = 0.0
    for i in range(len(state.e)):
        for v in range(n):
            value = J[i, v]
            if value != 0.0:
                gradient[v] += value * state.e[i]
                for w in range(v + 1):
                    normal[v, w] += value * J[i, w]
    squares = 0.0
    for v in range(n):
        squares += gradient[v] * gradient[v]
    return math.sqrt(squares)


@both_ways
def step_rows(body: Body, problem: Problem, limits: Region, state: State, A: Floats, b: Floats) -> tuple[int, int]:
    """Write the constraints A (δ, s) ≥ b of a step; return the numbers of equations, which are first, and of rows."""
    n, count = body.moving, 0
    if problem.plan.stance == BOTH:  # the second foot stays fixed
        rows = len(body.parent)
        R, p, twists = np.empty((rows, 3, 3)), np.empty((rows, 3)), np.zeros((6, n))
        place_all(body, state.x, state.T, R, p)
        add_chain(body, body.legs[0, JOINTS - 1], -1.0, R, p, twists)
        add_chain(body, body.legs[1, JOINTS - 1], 1.0, R, p, twists)
        A[:6, :n] = twists
        A[:6, n], b[:6] = 0.0, 0.0
        count = 6
    equal = count
    A[count] = 0.0
    A[count, n], b[count] = 1.0, 0.0  # s ≥ 0
    count += 1
    if problem.plan.support > 0.0:  # n·(com + J δ) + s ≥ d
        planes = problem.planes
        for k in range(len(planes)):
            for v in range(n):
                A[count, v] = planes[k, 0] * state.com_J[0, v] + planes[k, 1] * state.com_J[1, v]
            A[count, n] = 1.0
            b[count] = planes[k, 2] - planes[k, 0] * state.com[0] - planes[k, 1] * state.com[1]
            count += 1
    return equal, limit_rows(limits, state.x, np.empty(0), np.full(n, _MAX_STEP), A, b, count)


@both_ways
def solve_step(
    problem: Problem, state: State, damping: float, normal: Floats, gradient: Floats,
    A: Floats, b: Floats, count: int, equal: int, step: Floats,
) -> None:  # fmt: skip
    """Write the step (δ, s) into (n + 1,)."""
    n = len(gradient)
    H, g = np.zeros((n + 1, n + 1)), np.zeros(n + 1)
    squared, support = problem.pull * problem.pull, problem.plan.support
    for _ in range(2):
        for v in range(n):
            for w in range(v + 1):
                H[v, w] = normal[v, w]
            H[v, v] += squared + damping
            g[v] = gradient[v] + squared * (state.x[v] - problem.posture[v])
            H[n, v] = 0.0
        H[n, n] = support * support if support > 0.0 else 1.0
        if quadratic_program(H, g, A, b, count, equal, step):
            return
        # Limits that cannot be reached in one step are at least not exceeded further.
        for i in range(equal, count):
            if A[i, n] == 0.0:
                b[i] = min(b[i], 0.0)
    step[:] = 0.0


@both_ways
def sum_after(problem: Problem, state: State, step: Floats) -> float:
    """Return the sum after a step by the linear model."""
    n = len(step) - 1
    model: float = 0.5 * (problem.plan.support * step[n]) ** 2
    for i in range(len(state.e)):
        value = state.e[i]
        for v in range(n):
            value += state.J[i, v] * step[v]
        model += 0.5 * value * value
    for v in range(n):
        model += 0.5 * (problem.pull * (state.x[v] + step[v] - problem.posture[v])) ** 2
    return model


# --- The search for a whole-body pose.

# How a search ended.
SETTLED, REACHED, STOPPED, NOT_STANDING = range(4)
# Indices in a report.
STATUS, STEPS, START, SHORTFALL = range(4)

_FIRST_DAMPING, _MIN_DAMPING, _MAX_DAMPING, _FLOOR = 0.1, 1e-6, 1e9, 1e-10
_MIN_GAIN, _GOOD_GAIN = 1e-3, 0.75
# Weight of the legs' excess over their limits after a step, as a multiple of the slope of the errors.
_PENALTY, _MIN_PENALTY = 3.0, 1e-3
# This cost makes a pose outside the limits worse than any pose inside.
_OUTSIDE_COST = 1e9
# While the posture pulls, knees stay bent by at least the first angle; the search starts with the second [rad].
_MIN_BEND, _FIRST_BEND = 0.02, 0.3
# The search with the posture ends when a step decreases the sum by a smaller share than this.
_ENOUGH = 0.02
_MAX_WITH_POSTURE = 20
# The search ends when a step is predicted to decrease the sum by a smaller share than this.
_FLAT = 1e-6
_FOOT_TOLERANCE = 1e-6
# How much `_stand` may change a configuration that already stands [rad].
_ROUNDING = 1e-9


@both_ways
def _stand(body: Body, second_leg: SecondLeg, problem: Problem, x: Floats, T: Floats) -> bool:
    """Meet the feet: write the torso's pose, and with both feet standing change the legs in x; False if impossible."""
    if problem.plan.stance == BOTH:
        return stand_on_both(body, second_leg, problem.feet, x, T)
    rows = len(body.parent)
    torso_over_foot(body, problem.plan.stance, problem.feet, x, np.zeros((rows, 3, 3)), np.zeros((rows, 3)), T)
    return True


@both_ways
def descend(body: Body, second_leg: SecondLeg, problem: Problem, current: State, trial: State) -> tuple[int, int]:
    """Decrease the errors from a standing configuration, `current` with x and T; return how it ended, and the steps."""
    n, tolerance = body.moving, problem.plan.tolerance
    limits, max_steps = body.limits, problem.plan.steps
    if problem.pull > 0.0:
        limits, max_steps = _with_bent_knees(body), _MAX_WITH_POSTURE
    size = 7 + len(problem.planes) + max_rows(limits)
    A, slack, b = np.zeros((size, n + 1)), np.zeros(size), np.zeros(size)
    normal, gradient, step = np.empty((n, n)), np.empty(n), np.empty(n + 1)
    evaluate(body, problem, limits, current)
    trial.x[:] = current.x
    damping, growth, is_new = _FIRST_DAMPING, 2.0, True
    equal, count, penalty = 0, 0, 0.0
    for iteration in range(max_steps):
        if problem.pull == 0.0 and is_reached(current, tolerance):
            return REACHED, iteration
        if is_new:
            # With this weight, no target outweighs a limit.
            penalty = _MIN_PENALTY + _PENALTY * normal_equations(body, current, normal, gradient)
            equal, count = step_rows(body, problem, limits, current, A, slack)
            is_new = False
        sums = current.sums
        cost = sums[SUM_ERRORS] + sums[SUM_POSTURE] + penalty * sums[SUM_OUTSIDE]
        b[:] = slack
        better, gain, promised, decrease = False, 0.0, 0.0, 0.0
        for correction in range(2):
            weight = 2.0 * damping * sums[SUM_ERRORS] + _FLOOR
            solve_step(problem, current, weight, normal, gradient, A, b, count, equal, step)
            promised = cost - sum_after(problem, current, step)
            for v in range(n):
                trial.x[v] = current.x[v] + step[v]
            clipped(limits, trial.x)
            if not _stand(body, second_leg, problem, trial.x, trial.T):
                break
            evaluate(body, problem, limits, trial)
            decrease = cost - trial.sums[SUM_ERRORS] - trial.sums[SUM_POSTURE] - penalty * trial.sums[SUM_OUTSIDE]
            gain = decrease / promised if promised > 0.0 else 0.0
            better = decrease > 0.0 and gain > _MIN_GAIN
            if correction == 1 or trial.sums[SUM_OUTSIDE] <= INSIDE or gain > _GOOD_GAIN:
                break
            # Restoring the feet moves the legs off the linear step; the second-order correction allows for it.
            for i in range(equal + 1, count):
                if A[i, n] == 0.0:
                    for v in range(n):
                        b[i] -= A[i, v] * (trial.x[v] - current.x[v] - step[v])
        if better:
            copy_state(trial, current)
            is_new = True
            damping = max(_MIN_DAMPING, damping * max(1.0 / 3.0, 1.0 - (2.0 * min(gain, 2.0) - 1.0) ** 3))
            growth = 2.0
            if problem.pull > 0.0 and decrease <= _ENOUGH * cost:
                return SETTLED, iteration + 1
        else:
            damping, growth = damping * growth, 2.0 * growth
        if promised <= _FLAT * cost or damping >= _MAX_DAMPING:
            return (REACHED if is_reached(current, tolerance) else SETTLED), iteration + 1
    return (REACHED if is_reached(current, tolerance) else STOPPED), max_steps


@both_ways
def _with_bent_knees(body: Body) -> Region:
    """Return the limits with bent knees."""
    limits, lower = body.limits, body.limits.lower.copy()
    for side in range(2):
        knee = body.variable[body.legs[side, 3]]
        lower[knee] = max(lower[knee], _MIN_BEND)
    return Region(lower, limits.upper, limits.winding, limits.tables, limits.at, limits.low, limits.high, limits.shared)


@both_ways
def _bend(body: Body, x: Floats) -> None:
    """Bend knees that are nearly straight, because the derivative at a straight leg does not show how it bends."""
    for side in range(2):
        knee = body.variable[body.legs[side, 3]]
        more = _FIRST_BEND - x[knee]
        if more > 0.0:
            x[knee] += more
            x[body.variable[body.legs[side, 2]]] -= 0.5 * more
            x[body.variable[body.legs[side, 4]]] -= 0.5 * more
    clipped(body.limits, x)


@both_ways
def _take_stance(body: Body, second_leg: SecondLeg, problem: Problem, x: Floats, T: Floats) -> tuple[bool, int]:
    """Change x so that all standing feet are met; return whether they are, and the steps taken.

    If the second foot is not near its pose, the robot first stands on the other foot alone, with this pose as a target.
    """
    if problem.plan.stance != BOTH:
        return _stand(body, second_leg, problem, x, T), 0
    current, trial = new_state(body, len(x), 1), new_state(body, len(x), 1)
    current.x[:] = x
    if _stand(body, second_leg, problem, current.x, T) and outside(body.limits, current.x) <= INSIDE:
        x[:] = current.x
        return True, 0
    current.x[:] = x
    weights = np.empty((1, TARGET_ROWS))
    weights[0] = DEFAULT_WEIGHTS
    plan = Plan(
        np.full(1, body.legs[1, JOINTS - 1]), np.zeros(1, np.int64), weights,
        0.0, DEFAULT_POSTURE, 0, False, _FOOT_TOLERANCE, problem.plan.steps,
    )  # fmt: skip
    no_planes = np.zeros((0, 3))
    foot = Problem(plan, problem.feet, body.ankle_to_sole[1:], problem.feet[1:], no_planes, x, plan.posture)
    _stand(body, second_leg, foot, current.x, current.T)
    _, first = descend(body, second_leg, foot, current, trial)
    status, second = descend(body, second_leg, without_pull(foot), current, trial)
    x[:] = current.x
    return status == REACHED and _stand(body, second_leg, problem, x, T), first + second


@both_ways
def without_pull(problem: Problem) -> Problem:
    """Return the problem with the targets alone."""
    return Problem(problem.plan, problem.feet, problem.frames, problem.targets, problem.planes, problem.posture, 0.0)


@both_ways
def _is_solved(body: Body, second_leg: SecondLeg, problem: Problem, current: State, trial: State) -> bool:
    """Return whether a configuration already stands and meets all targets."""
    trial.x[:] = current.x
    if not _stand(body, second_leg, problem, current.x, current.T):
        return False
    if np.abs(current.x - trial.x).max() > _ROUNDING or outside(body.limits, current.x) > INSIDE:
        return False
    evaluate(body, problem, body.limits, current)
    return is_reached(current, problem.plan.tolerance)


@both_ways
def _only_worst_limb(body: Body, plan: Plan, best: State, x: Floats) -> None:
    """Keep those joints of a new start that carry the worst target; set all others as in the best state."""
    worst, largest = -1, plan.support * best.sums[SUM_SHORTFALL]
    for t in range(len(plan.row)):
        if best.residuals[t, 2] > largest and plan.row[t] > 0:
            worst, largest = t, best.residuals[t, 2]
    if worst < 0:  # the centre of mass or the torso, which all joints carry
        return
    start = x.copy()
    x[:] = best.x
    row = plan.row[worst]
    while row > 0:
        x[body.variable[row]] = start[body.variable[row]]
        row = body.parent[row]


@both_ways
def solve_body(
    body: Body, second_leg: SecondLeg, problem: Problem, starts: Floats, best: State, report: Floats
) -> None:
    """Search from one of `starts` (starts, variables), the reference first, after the other, until the targets are met.

    The best state goes into `best`, STATUS, STEPS, START and SHORTFALL into `report`.
    """
    variables, targets = len(best.x), len(problem.plan.row)
    current, trial = new_state(body, variables, targets), new_state(body, variables, targets)
    alone = without_pull(problem)
    least, steps = math.inf, 0
    report[STATUS], report[START], report[SHORTFALL] = NOT_STANDING, -1.0, 0.0
    for start in range(len(starts)):
        current.x[:] = starts[start]
        status = REACHED
        if not (start == 0 and problem.plan.as_is and _is_solved(body, second_leg, alone, current, trial)):
            current.x[:] = starts[start]
            if start % 2 == 1 and least < math.inf:
                _only_worst_limb(body, problem.plan, best, current.x)
            _bend(body, current.x)
            stands, more = _take_stance(body, second_leg, problem, current.x, current.T)
            steps += more
            if not stands:
                continue
            # The pull would lead every start back to the local minimum of the first one.
            if problem.pull > 0.0 and start == 0:
                _, more = descend(body, second_leg, problem, current, trial)
                steps += more
            status, more = descend(body, second_leg, alone, current, trial)
            steps += more
        cost = current.sums[SUM_ERRORS] + (_OUTSIDE_COST if current.sums[SUM_OUTSIDE] > INSIDE else 0.0)
        if cost < least or status == REACHED:
            least = cost
            copy_state(current, best)
            report[STATUS], report[START], report[SHORTFALL] = float(status), float(start), current.sums[SUM_SHORTFALL]
        if status == REACHED:
            break
    report[STEPS] = float(steps)


class Problems(NamedTuple):
    """n poses to find, with the t targets of one plan."""

    feet: Floats4  # T_world_foot, shape (n, 2, 4, 4)
    frames: Floats4  # as in `errors_at`, shape (n, t, 4, 4), like the next one
    targets: Floats4
    planes: Floats3  # half planes of the support polygons, shape (n, k, 3)
    edges: Ints1  # how many of the k half planes are used, shape (n,)
    posture: Floats2  # preferred variables, shape (n, variables)
    starts: Floats3  # initial variables, shape (n, starts, variables)


class Solutions(NamedTuple):
    """Results of n searches."""

    x: Floats2  # shape (n, variables)
    T_world_torso: Floats3
    residuals: Floats3  # as in `State`, shape (n, t, 3)
    com: Floats2  # shape (n, 3)
    report: Floats2  # STATUS, STEPS, START, SHORTFALL and 0, shape (n, 5)


def _types() -> tuple[Any, ...]:
    from numba import types

    of_joints = types.UniTuple(types.float64, JOINTS)
    second = types.NamedTuple((*limb_types(Leg, JOINTS), of_joints, of_joints), SecondLeg)
    return numba_type(Body), second, *map(numba_type, (Plan, Problems, Solutions))


@partial(
    CachedKernel,
    what="a kernel of inverse kinematics, bodies",
    name="ik kernel, bodies",
    signature=_types,
    seconds=30.0,
)
def whole_bodies(body: Body, second_leg: SecondLeg, plan: Plan, problems: Problems, solutions: Solutions) -> None:
    """Run `solve_body` for many poses."""
    for i in range(len(solutions.x)):
        best = new_state(body, solutions.x.shape[1], len(plan.row))
        planes = problems.planes[i, : problems.edges[i]]
        problem = Problem(
            plan, problems.feet[i], problems.frames[i], problems.targets[i], planes, problems.posture[i], plan.posture
        )
        solve_body(body, second_leg, problem, problems.starts[i], best, solutions.report[i])
        solutions.x[i], solutions.T_world_torso[i], solutions.residuals[i], solutions.com[i] = (
            best.x,
            best.T,
            best.residuals,
            best.com,
        )
