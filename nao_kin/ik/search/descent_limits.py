"""Limits of the joints that move a frame, for scalar code: boxes, and plane regions of coupled limits.

The numbers are those of a `LimitRegion`; what is done with them is the same, one configuration after the other.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from nao_kin.ik.compiling import Row, both_ways

# Tables that share a joint are obeyed in turn, so often at most.
MOST_TURNS = 20
# Directions are probed by a step of this length [rad or m]: far above rounding, far below the bends of a table.
PROBE = 1e-6
# Numbers of a table: the places of the joint that is depended on and of the one that depends, −1 for one that does not
# move; the first of its bends, and the one behind the last.
TABLE = 4


class Region(NamedTuple):
    """Where m joints may be.

    Attributes:
        lower: smallest values, m numbers.
        upper: largest values.
        winding: 1 for a joint that turns without limits and is the same after a whole turn.
        tables: four whole numbers for each coupled limit.
        at: bends of all tables: values of the joint that is depended on.
        low: smallest value of the other one there, inside its box.
        high: largest value there.
        shared: whether two tables share a joint.
    """

    lower: Row
    upper: Row
    winding: Row
    tables: Row
    at: Row
    low: Row
    high: Row
    shared: bool


@both_ways
def project(region: Region, values: Row, still: Row, inside: Row) -> None:
    """The nearest values inside the limits; `still` has for each table the value of its joint that does not move."""
    for j in range(len(region.lower)):
        inside[j] = min(max(values[j], region.lower[j]), region.upper[j])
    count = len(region.tables) // TABLE
    # What a plane's nearest point is asked for are the values as given: clipping them first would move the point.
    for t in range(count):
        of, joint = region.tables[TABLE * t], region.tables[TABLE * t + 1]
        if of >= 0 and joint >= 0:
            inside[of], inside[joint] = nearest_point(region, t, values[of], values[joint])
    for t in range(count):
        if region.tables[TABLE * t] < 0 or region.tables[TABLE * t + 1] < 0:
            obey(region, t, still, inside)
    if region.shared:
        for _ in range(MOST_TURNS):
            changed = False
            for t in range(count):
                changed = obey(region, t, still, inside) or changed
            if not changed:
                break


@both_ways
def obey(region: Region, t: int, still: Row, values: Row) -> bool:
    """Take the moving joints of a table into its region; whether that changed them."""
    of, joint = region.tables[TABLE * t], region.tables[TABLE * t + 1]
    if of >= 0 and joint >= 0:
        x, y = nearest_point(region, t, values[of], values[joint])
        changed = bool(x != values[of] or y != values[joint])
        values[of], values[joint] = x, y
        return changed
    if joint >= 0:
        low, high = range_at(region, t, still[t])
        y = min(max(values[joint], low), high)
        changed = bool(y != values[joint])
        values[joint] = y
        return changed
    x = nearest_of(region, t, values[of], still[t])
    changed = bool(x != values[of])
    values[of] = x
    return changed


@both_ways
def range_at(region: Region, t: int, of: float) -> tuple[float, float]:
    """Smallest and largest value of the joint of a table where the other is at `of`; constant outside the table."""
    first, last = region.tables[TABLE * t + 2], region.tables[TABLE * t + 3] - 1
    if of <= region.at[first]:
        return region.low[first], region.high[first]
    if of >= region.at[last]:
        return region.low[last], region.high[last]
    right = first + 1
    while region.at[right] < of:
        right += 1
    left = right - 1
    share = (of - region.at[left]) / (region.at[right] - region.at[left])
    low = region.low[left] + share * (region.low[right] - region.low[left])
    return low, region.high[left] + share * (region.high[right] - region.high[left])


@both_ways
def nearest_point(region: Region, t: int, of: float, joint: float) -> tuple[float, float]:
    """The nearest point of a plane region: on one of the segments of its boundary, if it is not inside."""
    first, last = region.tables[TABLE * t + 2], region.tables[TABLE * t + 3] - 1
    low, high = range_at(region, t, of)
    if region.at[first] <= of <= region.at[last] and low <= joint <= high:
        return of, joint
    best, x, y = math.inf, of, joint
    for side in range(2):
        bound = region.low if side == 0 else region.high
        for i in range(first, last):
            dx, dy = region.at[i + 1] - region.at[i], bound[i + 1] - bound[i]
            square = dx * dx + dy * dy
            share = ((of - region.at[i]) * dx + (joint - bound[i]) * dy) / square if square > 0.0 else 0.0
            share = min(max(share, 0.0), 1.0)
            foot_x, foot_y = region.at[i] + share * dx, bound[i] + share * dy
            away = (of - foot_x) * (of - foot_x) + (joint - foot_y) * (joint - foot_y)
            if away < best:
                best, x, y = away, foot_x, foot_y
    for side in range(2):
        i = first if side == 0 else last
        foot = min(max(joint, region.low[i]), region.high[i])
        away = (of - region.at[i]) * (of - region.at[i]) + (joint - foot) * (joint - foot)
        if away < best:
            best, x, y = away, region.at[i], foot
    # The foot of a perpendicular lies on the boundary to rounding; the last bit is clipped away.
    low, high = range_at(region, t, x)
    return x, min(max(y, low), high)


@both_ways
def nearest_of(region: Region, t: int, of: float, joint: float) -> float:
    """The nearest value of the joint that is depended on at which the other may be at `joint`; `of` if there is none.

    Between two bends the allowed values are an interval, given by two linear inequalities.
    """
    first, last = region.tables[TABLE * t + 2], region.tables[TABLE * t + 3] - 1
    best, found = math.inf, of
    for i in range(first, last):
        start, end = 0.0, 1.0
        for side in range(2):
            # sign · (joint − bound) ≥ 0 with bound = left + share · rise.
            sign = 1.0 if side == 0 else -1.0
            left, right = (region.low[i], region.low[i + 1]) if side == 0 else (region.high[i], region.high[i + 1])
            rise, room = sign * (right - left), sign * (joint - left)
            if rise > 0.0:
                end = min(end, room / rise)
            elif rise < 0.0:
                start = max(start, room / rise)
            elif room < 0.0:
                end = -1.0
        if start <= end:
            width = region.at[i + 1] - region.at[i]
            value = min(max(of, region.at[i] + start * width), region.at[i] + end * width)
            if abs(value - of) < best:
                best, found = abs(value - of), value
    return found


@both_ways
def open_directions(
    region: Region, values: Row, still: Row, wanted: Row, ahead: Row, inside: Row, is_open: Row, along: Row
) -> bool:
    """Along which directions a step may go that wants to go along `wanted`; whether all are open.

    A joint held at its limit is not (`is_open` 0); of two joints at the edge of their plane region only the direction
    along the edge is, which `along` has for each table, (2, 0) where the two are free.
    """
    count, width = len(region.tables) // TABLE, len(region.lower)
    for j in range(width):
        ahead[j] = 1.0 if wanted[j] > 0.0 else -1.0 if wanted[j] < 0.0 else 0.0
    for t in range(count):
        of, joint = region.tables[TABLE * t], region.tables[TABLE * t + 1]
        along[2 * t], along[2 * t + 1] = 2.0, 0.0
        if of >= 0 and joint >= 0:
            length = math.sqrt(wanted[of] * wanted[of] + wanted[joint] * wanted[joint])
            if length > 0.0:
                ahead[of], ahead[joint] = wanted[of] / length, wanted[joint] / length
    for j in range(width):
        ahead[j] = values[j] + PROBE * ahead[j]
    project(region, ahead, still, inside)
    everything = True
    for j in range(width):
        free = abs(inside[j] - values[j]) >= 0.5 * PROBE or ahead[j] == values[j]
        is_open[j] = 1.0 if free else 0.0
        everything = everything and bool(inside[j] == ahead[j])
    if everything:
        return True
    for t in range(count):
        of, joint = region.tables[TABLE * t], region.tables[TABLE * t + 1]
        if of >= 0 and joint >= 0:
            is_open[of], is_open[joint] = 1.0, 1.0
            x, y = (inside[of] - values[of]) / PROBE, (inside[joint] - values[joint]) / PROBE
            off = max(abs(inside[of] - ahead[of]), abs(inside[joint] - ahead[joint])) / PROBE
            if off > 1e-3:
                length = math.sqrt(x * x + y * y)
                along[2 * t] = x / length if length > 1e-3 else 0.0
                along[2 * t + 1] = y / length if length > 1e-3 else 0.0
    return False
