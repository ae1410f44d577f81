"""Strictly convex quadratic programs of some twenty variables, by the dual active-set method of Goldfarb and Idnani.

    min ½ xᵀ H x + gᵀ x  subject to  aᵢ·x = bᵢ for the first rows and aᵢ·x ≥ bᵢ for all others

It starts at the minimum without constraints, adds the most violated constraint and drops those with a wrong sign, until
none is violated. It needs no feasible start, and handles linearly dependent rows.

Source: Goldfarb and Idnani, A numerically stable dual method for solving strictly convex quadratic programs,
Mathematical Programming 27, 1983. Here the small system of the active rows is factored anew each time.
"""

from __future__ import annotations

import math

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._kernels.cache import Row, both_ways

# A smaller violation of a row than this counts as zero [rad].
_VIOLATED = 1e-12
# A row depends linearly on the active rows if its share perpendicular to them is smaller than this.
_DEPENDENT = 1e-11
# A smaller violation of a dependent row than this counts as zero [rad].
_ROUNDING = 1e-9


@both_ways
def cholesky(A: Row, n: int, width: int, floor: float) -> bool:
    """Factor the leading n rows in place, A = L Lᵀ with L in the lower triangle; False if not positive definite.

    A has its rows, `width` numbers each, one after another; `floor` is the least squared entry on the diagonal of L.
    """
    for j in range(n):
        d = A[j * width + j]
        for k in range(j):
            d -= A[j * width + k] * A[j * width + k]
        d = max(d, floor)
        if not d > 0.0:
            return False
        d = math.sqrt(d)
        A[j * width + j] = d
        for i in range(j + 1, n):
            s = A[i * width + j]
            for k in range(j):
                s -= A[i * width + k] * A[j * width + k]
            A[i * width + j] = s / d
    return True


@both_ways
def solve_cholesky(L: Row, n: int, width: int, b: Row) -> None:
    """Write (L Lᵀ)⁻¹ b into b."""
    for i in range(n):
        s = b[i]
        for k in range(i):
            s -= L[i * width + k] * b[k]
        b[i] = s / L[i * width + i]
    for i in range(n - 1, -1, -1):
        s = b[i]
        for k in range(i + 1, n):
            s -= L[k * width + i] * b[k]
        b[i] = s / L[i * width + i]


@both_ways
def quadratic_program(H: Floats, g: Floats, A: Floats, b: Floats, count: int, equal: int, x: Floats) -> bool:
    """Write the minimum into x and overwrite H; False if the `count` rows contradict each other.

    The first `equal` rows of A and b are equations, the others up to `count` inequalities.
    """
    n = len(g)
    size, L = n + 1, H.reshape(-1)
    if not cholesky(L, n, n, 0.0):
        return False
    for i in range(n):
        x[i] = -g[i]
    solve_cholesky(L, n, n, x)
    active, force = np.empty(size, np.int64), np.zeros(size)
    across = np.empty((size, n))  # H⁻¹ of each active row
    gram, factor = np.empty((size, size)), np.empty(size * size)
    share, step = np.empty(size), np.empty(n)
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
            # H⁻¹ of the new row, and the change of the active rows' multipliers.
            for j in range(n):
                step[j] = towards * A[row, j]
            solve_cholesky(L, n, n, step)
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
                    factor[i * size + j] = gram[i, j]
            gram[k, k] = own
            if k > 0:
                if not cholesky(factor, k, size, 0.0):
                    return False
                solve_cholesky(factor, k, size, share)
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
