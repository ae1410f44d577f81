"""The step inside the limits: a strictly convex quadratic program of some twenty variables, solved exactly.

min ½ xᵀ H x + gᵀ x  such that  aᵢ·x = bᵢ for the first rows and aᵢ·x ≥ bᵢ for all others,

by the dual active-set method of Goldfarb and Idnani: it begins at the minimum without constraints and takes in the one
that is violated most, giving up those that pull the wrong way, until none is violated. No start inside is needed, and
rows that depend on each other do no harm.

Source: Goldfarb and Idnani, A numerically stable dual method for solving strictly convex quadratic programs,
Mathematical Programming 27, 1983. Here the small system of the active rows is factored anew each time.
"""

from __future__ import annotations

import math

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._kernels.cache import both_ways

# A row that is violated by less holds [rad].
_VIOLATED = 1e-12
# A row whose part across the active ones is a smaller share of it depends on them.
_DEPENDENT = 1e-11
# A row that depends on the active ones and is violated by less than this counts as one that holds [rad].
_ROUNDING = 1e-9


@both_ways
def cholesky(A: Floats, n: int) -> bool:
    """A = L Lᵀ of the leading n rows in place, L in the lower triangle; whether A is positive definite."""
    for j in range(n):
        d = A[j, j]
        for k in range(j):
            d -= A[j, k] * A[j, k]
        if not d > 0.0:
            return False
        d = math.sqrt(d)
        A[j, j] = d
        for i in range(j + 1, n):
            s = A[i, j]
            for k in range(j):
                s -= A[i, k] * A[j, k]
            A[i, j] = s / d
    return True


@both_ways
def solve_cholesky(L: Floats, n: int, b: Floats) -> None:
    """(L Lᵀ)⁻¹ b, in place of b."""
    for i in range(n):
        s = b[i]
        for k in range(i):
            s -= L[i, k] * b[k]
        b[i] = s / L[i, i]
    for i in range(n - 1, -1, -1):
        s = b[i]
        for k in range(i + 1, n):
            s -= L[k, i] * b[k]
        b[i] = s / L[i, i]


@both_ways
def quadratic_program(H: Floats, g: Floats, A: Floats, b: Floats, count: int, equal: int, x: Floats) -> bool:
    """The minimum, written into x (n,); False where the rows contradict each other.

    Args:
        H: positive definite, shape (n, n); destroyed.
        g: shape (n,).
        A: rows aᵢ, of which `count` count.
        b: least values bᵢ.
        count: how many rows.
        equal: how many of these, the first, are equations.
        x: for the result.
    """
    n = len(g)
    if not cholesky(H, n):
        return False
    for i in range(n):
        x[i] = -g[i]
    solve_cholesky(H, n, x)
    most = n + 1
    active = np.empty(most, np.int64)
    force = np.zeros(most)
    across = np.empty((most, n))  # H⁻¹ of each active row
    gram, factor = np.empty((most, most)), np.empty((most, most))
    share, step = np.empty(most), np.empty(n)
    is_active, dependent = np.zeros(count, np.bool_), np.zeros(count, np.bool_)
    k = 0
    for _ in range(20 * count + 50):
        row, violation, towards = -1, -_VIOLATED, 1.0
        for i in range(count):
            if is_active[i] or dependent[i]:
                continue
            slack = -b[i]
            for j in range(n):
                slack += A[i, j] * x[j]
            if i < equal:
                row, violation, towards = i, -abs(slack), -1.0 if slack > 0.0 else 1.0
                break
            if slack < violation:
                row, violation = i, slack
        if row < 0:
            return True
        pull = 0.0
        while True:
            # The new row seen through H⁻¹, and what the active rows have to give for it.
            for j in range(n):
                step[j] = towards * A[row, j]
            solve_cholesky(H, n, step)
            own = 0.0
            for j in range(n):
                own += towards * A[row, j] * step[j]
                across[k, j] = step[j]
            for i in range(k):
                s = 0.0
                for j in range(n):
                    s += towards * A[row, j] * across[i, j]
                share[i] = gram[k, i] = s
                for j in range(i + 1):
                    factor[i, j] = gram[i, j]
            gram[k, k] = own
            if k > 0:
                if not cholesky(factor, k):
                    return False
                solve_cholesky(factor, k, share)
            rise = own
            for i in range(k):
                rise -= share[i] * gram[k, i]
                for j in range(n):
                    step[j] -= share[i] * across[i, j]
            is_free = rise > _DEPENDENT * own and k < n
            longest, leaving = math.inf, -1
            for i in range(k):
                if active[i] >= equal and share[i] > 0.0 and force[i] < longest * share[i]:
                    longest, leaving = force[i] / share[i], i
            full = -violation / rise if is_free else math.inf
            length = min(full, longest)
            if length == math.inf:
                if -violation < _ROUNDING:
                    dependent[row] = True
                    break
                return False
            for i in range(k):
                force[i] -= length * share[i]
            pull += length
            if is_free:
                for j in range(n):
                    x[j] += length * step[j]
                violation += length * rise
            if full <= longest:
                active[k], force[k], is_active[row] = row, pull, True
                k += 1
                break
            k -= 1
            is_active[active[leaving]] = False
            for i in range(leaving, k):
                active[i], force[i] = active[i + 1], force[i + 1]
                for j in range(n):
                    across[i, j] = across[i + 1, j]
                for j in range(k):
                    gram[i, j] = gram[i + 1, j if j < leaving else j + 1]
    return False
