"""Searches over one number: the least value of a function, and its roots.

A function is called as `function(given, value)`; `given` are its other arguments.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from nao_kin._core.arrays import Floats
from nao_kin._kernels.cache import both_ways

# Halvings of the steps of `least`, of a bracket, and sections of a golden search.
_FINER, _HALVINGS = 48, 60
_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


@both_ways
def least(function: Callable[..., float], given: Any, low: float, high: float, near: float, steps: int) -> float:
    """Where a function is least: of even steps and the value nearest to `near`, and then ever nearer to the best."""
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
    """Where a function falls, or rises, through zero between two values, by halvings."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if (function(given, middle) > 0.0) == falls:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@both_ways
def nearest_to_zero(function: Callable[..., float], given: Any, low: float, high: float, sign: float) -> float:
    """Where a function of one sign is nearest to zero, or passes it farthest, by golden sections."""
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
    """Add where a function is zero strictly between two values, also where it touches zero; the new number of roots.

    Also added is where it is nearest to zero without touching, if that is between even steps.
    """
    step = (high - low) / steps
    here = before = function(given, low)
    for k in range(steps + 1):
        at = low + step * k
        after = function(given, at + step) if k < steps else here
        above = here > 0.0
        if above != (after > 0.0):
            count = _add(crossing(function, given, at, at + step, above), low, high, roots, count)
        # Where it is nearer to zero than beside, zero may be touched, or passed twice.
        elif (
            above == (before > 0.0)
            and abs(here) <= min(abs(before), abs(after))
            and abs(here) <= abs(before - here) + abs(after - here)
        ):
            left, right = max(low, at - step), min(high, at + step)
            nearest = nearest_to_zero(function, given, left, right, 1.0 if above else -1.0)
            if (function(given, nearest) > 0.0) != above:
                count = _add(crossing(function, given, left, nearest, above), low, high, roots, count)
                count = _add(crossing(function, given, nearest, right, not above), low, high, roots, count)
            count = _add(nearest, low, high, roots, count)
        before, here = here, after
    return count


@both_ways
def _add(root: float, low: float, high: float, roots: Floats, count: int) -> int:
    if low < root < high and count < len(roots):
        roots[count] = root
        count += 1
    return count
