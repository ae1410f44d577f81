"""Searches over one variable: the minimum of a function, and its roots.

A function is called as `function(given, value)`; `given` are its other arguments.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from nao_kin._core.arrays import Floats
from nao_kin._kernels.cache import both_ways

# Halvings of the steps of `least`; iterations of a bisection or golden-section search.
_FINER, _HALVINGS = 48, 60
_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


@both_ways
def least(function: Callable[..., float], given: Any, low: float, high: float, near: float, steps: int) -> float:
    """Return the minimiser of a function: the best of even steps and of `near`, refined by halved steps."""
    step = (high - low) / steps
    lowest, best = math.inf, low
    for k in range(-1, steps + 1):
        value = min(max(near, low), high) if k < 0 else low + step * k
        found = function(given, value)
        if found < lowest:
            lowest, best = found, value
    for _ in range(_FINER):
        for value in (max(low, best - step), min(high, best + step)):
            found = function(given, value)
            if found < lowest:
                lowest, best = found, value
        step *= 0.5
    return best


@both_ways
def crossing(function: Callable[..., float], given: Any, low: float, high: float, falls: bool) -> float:
    """Return where a function falls, or rises, through zero between two values, by bisection."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if (function(given, middle) > 0.0) == falls:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@both_ways
def nearest_to_zero(function: Callable[..., float], given: Any, low: float, high: float, sign: float) -> float:
    """Return where a function of one sign is nearest to zero, or passes it farthest, by golden sections."""
    one, two = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    first, second = sign * function(given, one), sign * function(given, two)
    for _ in range(_HALVINGS):
        if first <= second:
            high, two, second = two, one, first
            one = high - _GOLDEN * (high - low)
            first = sign * function(given, one)
        else:
            low, one, first = one, two, second
            two = low + _GOLDEN * (high - low)
            second = sign * function(given, two)
    return 0.5 * (low + high)


@both_ways
def add_roots(
    function: Callable[..., float], given: Any, low: float, high: float, steps: int, roots: Floats, count: int
) -> int:
    """Add the roots of f between two values, and the minima of |f| between even steps; return the new number."""
    step = (high - low) / steps
    current = previous = function(given, low)
    for k in range(steps + 1):
        at = low + step * k
        following = function(given, at + step) if k < steps else current
        above = current > 0.0
        if above != (following > 0.0):
            count = _add(crossing(function, given, at, at + step, above), low, high, roots, count)
        # A minimum of |f|: there may be a double root, or two roots.
        elif (
            above == (previous > 0.0)
            and abs(current) <= min(abs(previous), abs(following))
            and abs(current) <= abs(previous - current) + abs(following - current)
        ):
            left, right = max(low, at - step), min(high, at + step)
            nearest = nearest_to_zero(function, given, left, right, 1.0 if above else -1.0)
            if (function(given, nearest) > 0.0) != above:
                count = _add(crossing(function, given, left, nearest, above), low, high, roots, count)
                count = _add(crossing(function, given, nearest, right, not above), low, high, roots, count)
            count = _add(nearest, low, high, roots, count)
        previous, current = current, following
    return count


@both_ways
def _add(root: float, low: float, high: float, roots: Floats, count: int) -> int:
    if low < root < high and count < len(roots):
        roots[count] = root
        count += 1
    return count
