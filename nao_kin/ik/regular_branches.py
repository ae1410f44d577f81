"""Branches of targets whose answers are all solutions with independent axes: verified, inside the limits and sorted.

Most targets are such. `analytic` completes the others, for which answers may be missing.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import LIMIT_TOLERANCE, Floats
from nao_kin._kernels.cache import CachedKernel, Floats2, IntRow, Row, both_ways
from nao_kin._kernels.chains import Chain, to_frame
from nao_kin._kernels.rows import copied, in_lists, run_rows
from nao_kin.ik.least_squares import ANGLE_WEIGHT, rotation_error
from nao_kin.ik.limit_regions import TABLE, LimitRegion, Region, range_at
from nao_kin.ik.quadratic_program import cholesky

# Errors [m, rad] below which an answer is left as it is.
PRECISE = 1e-13
# Angle [rad] up to which two answers are one.
SAME = 1e-6
# Joints with a range of more turns get their whole turns from `near`.
TURNS = 3.0
# No axis depends on others if the determinant of JᵀJ, with lengths in units of `ANGLE_WEIGHT`, is above this.
REGULAR = 1e-6
# Most answers of EAIK, and most branches with their whole turns that are written for a target.
_ANSWERS, _MOST = 16, 256
# Indices of a report: the number of branches, or −1 for a target that has to be completed; and the errors of the first.
_COUNT, _POSITION, _ANGLE = range(3)
# A thread is worthwhile only for this many targets.
_PER_THREAD = 500


class Rules(NamedTuple):
    """What makes an answer a branch: with `enforce`, to be inside the limits, and errors up to a tolerance [m, rad]."""

    enforce: bool
    tolerance: float


class _Scratch(NamedTuple):
    """Working memory of a target with c joints."""

    T: Row
    axes: Row
    origins: Row
    turn: Row
    J: Row
    gram: Row
    values: Row
    kept: Row
    errors: Row
    first: Row
    last: Row
    distances: Row
    sources: Row


@both_ways
def _new_scratch(c: int, most: int) -> _Scratch:
    """Allocate the working memory of a target."""
    kept = _ANSWERS + 1
    return _Scratch(
        np.empty(12), np.empty(3 * c), np.empty(3 * c), np.empty(3), np.empty(6 * c), np.empty(c * c), np.empty(c),
        np.empty(kept * c), np.empty(2 * kept), np.empty(c), np.empty(c), np.empty(most), np.empty(most),
    )  # fmt: skip


@both_ways
def _write_branches(
    chain: Chain,
    region: Region,
    rules: Rules,
    target: Row,
    near: Row,
    fixed: Row,
    answers: Row,
    scratch: _Scratch,
    found: Row,
    report: Row,
) -> None:
    """Write the branches of a target, nearest to `near` first, and a report on them, from answers one after another."""
    c = len(near)
    report[_COUNT] = -1.0
    kept = _verify(chain, rules, target, near, answers, scratch)
    count = 0
    for k in range(kept):
        count = _add_turns(chain, region, rules, near, fixed, k, scratch, found, count)
        if count * c > len(found):
            return
    if count > 0:
        report[_COUNT] = count
        first = int(scratch.sources[0])
        report[_POSITION], report[_ANGLE] = scratch.errors[2 * first], scratch.errors[2 * first + 1]


@both_ways
def _verify(chain: Chain, rules: Rules, target: Row, near: Row, answers: Row, scratch: _Scratch) -> int:
    """Keep `near` if it is a solution, and the answers that differ from it and each other; return their number.

    It is 0 if one of the answers is no solution, or has dependent axes.
    """
    c, kept = len(near), 0
    count, values, T, turn = len(answers) // c, scratch.values, scratch.T, scratch.turn
    if count > _ANSWERS:
        return 0
    for k in range(-1, count):
        for j in range(c):
            values[j] = near[j] if k < 0 else answers[c * k + j]
        to_frame(chain, values, 0, 0, scratch)
        rotation_error(T, target, 0, turn)
        dx, dy, dz = target[3] - T[3], target[7] - T[7], target[11] - T[11]
        position = math.sqrt(dx * dx + dy * dy + dz * dz)
        angle = math.sqrt(turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2])
        worst = max(position, angle)
        if k < 0 and worst > rules.tolerance:
            continue
        if k >= 0 and (worst > min(PRECISE, rules.tolerance) or _gram_determinant(c, scratch) < REGULAR):
            return 0
        known = False
        for other in range(kept):
            apart = 0.0
            for j in range(c):
                turns = (values[j] - scratch.kept[c * other + j]) * chain.ratio[j] / (2.0 * math.pi)
                apart = max(apart, abs(turns - round(turns)))
            known = known or 2.0 * math.pi * apart < SAME
        if known:
            continue
        for j in range(c):
            scratch.kept[c * kept + j] = values[j]
        scratch.errors[2 * kept], scratch.errors[2 * kept + 1] = position, angle
        kept += 1
    return kept if count > 0 else 0


@both_ways
def _gram_determinant(c: int, scratch: _Scratch) -> float:
    """Return the determinant of JᵀJ, with lengths in units of `ANGLE_WEIGHT`, by Cholesky's decomposition."""
    T, axes, origins, J, gram = scratch.T, scratch.axes, scratch.origins, scratch.J, scratch.gram
    for k in range(c):
        x, y, z = axes[3 * k], axes[3 * k + 1], axes[3 * k + 2]
        dx = (T[3] - origins[3 * k]) / ANGLE_WEIGHT
        dy = (T[7] - origins[3 * k + 1]) / ANGLE_WEIGHT
        dz = (T[11] - origins[3 * k + 2]) / ANGLE_WEIGHT
        J[6 * k], J[6 * k + 1], J[6 * k + 2] = y * dz - z * dy, z * dx - x * dz, x * dy - y * dx
        J[6 * k + 3], J[6 * k + 4], J[6 * k + 5] = x, y, z
    for k in range(c):
        for i in range(k + 1):
            gram[c * k + i] = 0.0
            for j in range(6):
                gram[c * k + i] += J[6 * k + j] * J[6 * i + j]
    if not cholesky(gram, c, c, 0.0):
        return 0.0
    determinant = 1.0
    for k in range(c):
        determinant *= gram[c * k + k] * gram[c * k + k]
    return determinant


@both_ways
def _add_turns(
    chain: Chain,
    region: Region,
    rules: Rules,
    near: Row,
    fixed: Row,
    k: int,
    scratch: _Scratch,
    found: Row,
    count: int,
) -> int:
    """Add a kept answer with all whole turns inside the limits to the branches; return their new number."""
    c = len(near)
    values, first, last = scratch.values, scratch.first, scratch.last
    for j in range(c):
        turn, u = 2.0 * math.pi / abs(chain.ratio[j]), scratch.kept[c * k + j]
        low, high = region.lower[j] - LIMIT_TOLERANCE, region.upper[j] + LIMIT_TOLERANCE
        if rules.enforce and region.upper[j] - region.lower[j] < TURNS * turn:
            first[j], last[j] = math.ceil((low - u) / turn), math.floor((high - u) / turn)
            if first[j] > last[j]:
                return count
        else:
            first[j] = round((near[j] - u) / turn)
            if rules.enforce and u + turn * first[j] < low:
                first[j] = math.ceil((low - u) / turn)
            if rules.enforce and u + turn * first[j] > high:
                first[j] = math.floor((high - u) / turn)
            last[j] = first[j]
        values[j] = first[j]  # the number of whole turns, which goes from the first to the last one
    most = len(found) // c
    while True:
        if count == most:
            return most + 1
        at = c * count
        distance = 0.0
        for j in range(c):
            found[at + j] = scratch.kept[c * k + j] + values[j] * (2.0 * math.pi / abs(chain.ratio[j]))
            distance += (found[at + j] - near[j]) * (found[at + j] - near[j])
        if not rules.enforce or _is_inside(region, fixed, found, at, c):
            # Move farther branches up, which keeps the order of equal ones.
            place = count
            while place > 0 and scratch.distances[place - 1] > distance:
                scratch.distances[place] = scratch.distances[place - 1]
                scratch.sources[place] = scratch.sources[place - 1]
                for j in range(c):
                    found[c * place + j], found[c * (place - 1) + j] = found[c * (place - 1) + j], found[c * place + j]
                place -= 1
            scratch.distances[place], scratch.sources[place] = distance, k
            count += 1
        j = c - 1
        while j >= 0 and values[j] == last[j]:
            values[j] = first[j]
            j -= 1
        if j < 0:
            return count
        values[j] += 1.0


@both_ways
def _is_inside(region: Region, fixed: Row, values: Row, at: int, c: int) -> bool:
    """Return whether c values, from the index `at` on, are inside the limits."""
    for j in range(c):
        value = values[at + j]
        if value < region.lower[j] - LIMIT_TOLERANCE or value > region.upper[j] + LIMIT_TOLERANCE:
            return False
    for t in range(len(region.tables) // TABLE):
        of, joint = region.tables[TABLE * t], region.tables[TABLE * t + 1]
        low, high = range_at(region, t, values[at + of] if of >= 0 else fixed[t])
        value = values[at + joint] if joint >= 0 else fixed[t]
        if value < low - LIMIT_TOLERANCE or value > high + LIMIT_TOLERANCE:
            return False
    return True


def regular_branches(
    chain: Chain,
    limits: LimitRegion,
    rules: Rules,
    targets: Floats,
    near: Floats,
    fixed: Floats,
    firsts: NDArray[np.int64],
    answers: Floats,
    threads: int | None,
) -> tuple[Floats, NDArray[np.int64], Floats]:
    """Return branches (n, k, c) of n targets (n, 4, 4), their numbers (n,), and the errors of the first ones (n, 2).

    The answers (N, c) of target i are those from `firsts[i]` to `firsts[i + 1]`. The number is −1 for a target that has
    to be completed: one of its answers is not a solution, or has dependent axes, or none is inside the limits.
    """
    n, c = near.shape
    turns = limits.numbers.upper - limits.numbers.lower
    each = np.floor(np.minimum(turns, TURNS * 2.0 * math.pi) * np.abs(chain.ratio) / (2.0 * math.pi)) + 1.0
    most = int(min(_MOST, (_ANSWERS + 1) * np.prod(each if rules.enforce else 1.0)))
    found, reports = np.empty((n, most * c)), np.empty((n, 3))
    targets, answers = targets.reshape(n, 16), np.ascontiguousarray(answers)

    def one_in_lists(part: slice) -> None:
        i, report, branches = part.start, [0.0] * 3, [0.0] * (most * c)
        own = answers[firsts[i] : firsts[i + 1]].reshape(-1).tolist()
        target, preferred, constants = targets[i].tolist(), near[i].tolist(), fixed[i].tolist()
        lists = in_lists(chain), in_lists(limits.numbers), rules, target, preferred, constants, own
        _write_branches(*lists, in_lists(_new_scratch(c, most)), branches, report)
        found[i], reports[i] = branches, report

    def solve(function: Callable[..., object], part: slice) -> None:
        numbers = copied(chain), copied(limits.numbers), rules
        rows = targets[part], near[part], fixed[part]
        function(*numbers, *rows, firsts[part.start : part.stop + 1], answers, found[part], reports[part])

    run_rows(_branches, solve, n, threads, _PER_THREAD, one_in_lists)
    count = reports[:, _COUNT].astype(np.int64)
    branches = found.reshape(n, most, c)[:, : count.max(initial=0)].copy()  # not a view of all that it might be
    branches[np.arange(branches.shape[1]) >= count[:, None]] = np.nan
    return branches, count, reports[:, _POSITION:]


@partial(CachedKernel, what="a kernel of inverse kinematics, branches of analytic", name="ik kernel, analytic")
def _branches(
    chain: Chain,
    region: Region,
    rules: Rules,
    targets: Floats2,
    near: Floats2,
    fixed: Floats2,
    firsts: IntRow,
    answers: Floats2,
    found: Floats2,
    reports: Floats2,
) -> None:
    c = near.shape[1]
    scratch = _new_scratch(c, found.shape[1] // c)
    for i in range(near.shape[0]):
        own = answers[firsts[i] : firsts[i + 1]].reshape(-1)
        _write_branches(chain, region, rules, targets[i], near[i], fixed[i], own, scratch, found[i], reports[i])
