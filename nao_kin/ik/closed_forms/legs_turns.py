"""The least turns ψ of both feet about their normals, between two values of HipYawPitch.

They are at an end, at a root of ψ, or where ψ ψ' of both feet are opposite: the last are bracketed between values that
are spaced evenly in q₁ and in ψ of either foot, so that none is steep between two of them.
"""

from __future__ import annotations

import math

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.ik.closed_forms.legs_equations import FootYaw, hip_of
from nao_kin.ik.closed_forms.ranges import wrapped
from nao_kin.ik.compiling import both_ways

# Priorities, as a number in a target.
BALANCED, LEFT_FIRST, RIGHT_FIRST = 0.0, 1.0, 2.0
# Turns of the feet [rad] that differ by less are equal.
EQUAL = 1e-11
# Values of HipYawPitch between two ends, evenly in q₁ and in ψ of each foot, and how many that makes at most.
_EVENLY = 24
MOST_VALUES = 5 * _EVENLY + 6
_HALVINGS = 60


@both_ways
def is_more(cost: tuple[float, float], than: tuple[float, float]) -> bool:
    """Whether turns of the feet are worse than others: the first, or where these are equal the second."""
    if abs(cost[0] - than[0]) > EQUAL:
        return cost[0] > than[0]
    return cost[1] > than[1] + EQUAL


@both_ways
def cost_of(
    yaws: tuple[FootYaw, FootYaw], signs: tuple[float, float], priority: float, hip: float
) -> tuple[float, float]:
    """The turns of the feet as they are compared: both together, or the preferred first."""
    left, right = abs(_turn(yaws[0], signs[0], hip)[0]), abs(_turn(yaws[1], signs[1], hip)[0])
    if priority == LEFT_FIRST:
        return left, right
    if priority == RIGHT_FIRST:
        return right, left
    return math.sqrt(left * left + right * right), 0.0


@both_ways
def least_turns(
    yaws: tuple[FootYaw, FootYaw],
    signs: tuple[float, float],
    priority: float,
    low: float,
    high: float,
    hips: Floats,
) -> float:
    """The value of HipYawPitch within [low, high] with the least turns; `hips` has room for `MOST_VALUES`."""
    best, cost = low, cost_of(yaws, signs, priority, low)
    hips[0] = high
    count = 1
    for foot in range(2):
        for half in range(2):
            hip = wrapped(hip_of(yaws[foot]) + math.pi * half)
            if low < hip < high:
                hips[count] = hip
                count += 1
    for k in range(count):
        other = cost_of(yaws, signs, priority, hips[k])
        if is_more(cost, other):
            best, cost = hips[k], other
    if priority != BALANCED or low == high:
        return best
    hips[count] = low
    count += 1
    for k in range(1, _EVENLY):
        hips[count] = low + (high - low) * k / _EVENLY
        count += 1
    for foot in range(2):
        count = _evenly_turned(yaws[foot], signs[foot], low, high, hips, count)
    hips[:count] = np.sort(hips[:count])
    growth = _growth(yaws, signs, low)
    for k in range(1, count):
        grows = _growth(yaws, signs, hips[k])
        if growth < 0.0 <= grows:
            hip = _lowest(yaws, signs, hips[k - 1], hips[k])
            other = cost_of(yaws, signs, priority, hip)
            if other[0] < cost[0]:
                best, cost = hip, other
        growth = grows
    return best


@both_ways
def _turn(yaw: FootYaw, sign: float, hip: float) -> tuple[float, float]:
    """ψ of a branch, and its slope ψ'."""
    c, s = math.cos(hip), math.sin(hip)
    x, y = sign * (yaw.x_cos * c + yaw.x_sin * s), sign * (yaw.y_cos * c + yaw.y_sin * s)
    square = x * x + y * y
    return math.atan2(y, x), (yaw.x_cos * yaw.y_sin - yaw.x_sin * yaw.y_cos) / square if square > 0.0 else 0.0


@both_ways
def _growth(yaws: tuple[FootYaw, FootYaw], signs: tuple[float, float], hip: float) -> float:
    """Half the derivative of the sum of the squares of both turns."""
    left, right = _turn(yaws[0], signs[0], hip), _turn(yaws[1], signs[1], hip)
    return left[0] * left[1] + right[0] * right[1]


@both_ways
def _lowest(yaws: tuple[FootYaw, FootYaw], signs: tuple[float, float], low: float, high: float) -> float:
    """Where the sum of squares is least between two values between which it falls and rises."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if _growth(yaws, signs, middle) < 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@both_ways
def _evenly_turned(yaw: FootYaw, sign: float, low: float, high: float, hips: Floats, count: int) -> int:
    """Enter values of HipYawPitch between which a foot turns evenly."""
    first, last = _turn(yaw, sign, low)[0], _turn(yaw, sign, high)[0]
    grows = yaw.x_cos * yaw.y_sin - yaw.x_sin * yaw.y_cos
    if grows > 0.0 and last < first:
        last += 2.0 * math.pi
    if grows < 0.0 and last > first:
        last -= 2.0 * math.pi
    for k in range(1, _EVENLY):
        turn = first + (last - first) * k / _EVENLY
        c, s = math.cos(turn), math.sin(turn)
        # X sin ψ = Y cos ψ
        hip = math.atan2(yaw.y_cos * c - yaw.x_cos * s, yaw.x_sin * s - yaw.y_sin * c)
        for half in range(2):
            hip = wrapped(hip + math.pi * half)
            if low < hip < high:
                hips[count] = hip
                count += 1
    return count
