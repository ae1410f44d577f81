"""The limits around a configuration as linear inequalities for a step, and how far a configuration is outside."""

from __future__ import annotations

from nao_kin._common.arrays import Floats
from nao_kin.ik.body.body import Body
from nao_kin.ik.compiling import both_ways

_SAME = 1e-12


@both_ways
def table_bounds(body: Body, k: int, of: float) -> tuple[float, float]:
    """The range of the joint of table k at a value of the joint it depends on; constant outside the table."""
    at, low, high, last = body.table[k, 0], body.table[k, 1], body.table[k, 2], body.bends[k] - 1
    if of <= at[0]:
        return low[0], high[0]
    if of >= at[last]:
        return low[last], high[last]
    right = 1
    while at[right] < of:
        right += 1
    share = (of - at[right - 1]) / (at[right] - at[right - 1])
    return (
        low[right - 1] + share * (low[right] - low[right - 1]),
        high[right - 1] + share * (high[right] - high[right - 1]),
    )


@both_ways
def outside(body: Body, lower: Floats, x: Floats) -> float:
    """The sum of what the variables are outside their limits by [rad]."""
    total = 0.0
    for v in range(body.moving):
        total += max(0.0, lower[v] - x[v], x[v] - body.upper[v])
    for k in range(len(body.bends)):
        if body.bends[k] > 0:
            low, high = table_bounds(body, k, x[body.bent[k, 1]])
            value = x[body.bent[k, 0]]
            total += max(0.0, low - value, value - high)
    return total


@both_ways
def clipped(body: Body, lower: Floats, x: Floats) -> None:
    """What rounding and the bends of tables have left outside, taken back: boxes first, then tables."""
    for v in range(body.moving):
        x[v] = min(max(x[v], lower[v]), body.upper[v])
    for k in range(len(body.bends)):
        if body.bends[k] > 0:
            low, high = table_bounds(body, k, x[body.bent[k, 1]])
            v = body.bent[k, 0]
            x[v] = min(max(x[v], low, lower[v]), high, body.upper[v])


@both_ways
def limit_rows(body: Body, lower: Floats, x: Floats, longest: float, A: Floats, b: Floats, count: int) -> int:
    """Rows A δ ≥ b that keep a step δ inside the limits and no longer than `longest`; their number with those before.

    A variable that is outside is brought back as far as a step may go. Of a table every segment within a step's reach
    gives a row, except where its line would cut away what is allowed here: the region need not be convex.
    """
    for v in range(body.moving):
        for side in range(2):
            sign = 1.0 if side == 0 else -1.0
            room = lower[v] - x[v] if side == 0 else x[v] - body.upper[v]
            A[count] = 0.0
            A[count, v] = sign
            b[count] = min(max(room, -longest), longest)
            count += 1
    for k in range(len(body.bends)):
        bends = body.bends[k]
        if bends == 0:
            continue
        joint, of = body.bent[k, 0], body.bent[k, 1]
        at = body.table[k, 0]
        here = table_bounds(body, k, x[of])
        for segment in range(-1, bends):
            first, last = max(segment, 0), min(segment + 1, bends - 1)
            begins = at[first] if segment >= 0 else x[of]
            ends = at[last] if segment < bends - 1 else x[of]
            if (segment < 0 and x[of] - longest > at[0]) or (segment == bends - 1 and x[of] + longest < at[last]):
                continue
            if begins > x[of] + longest or ends < x[of] - longest:
                continue
            for side in range(2):
                sign = 1.0 if side == 0 else -1.0
                bound = body.table[k, 1 + side]
                slope = (bound[last] - bound[first]) / (at[last] - at[first]) if last > first else 0.0
                line = bound[first] + slope * (x[of] - at[first])
                if sign * (line - here[side]) > _SAME:
                    continue
                A[count] = 0.0
                A[count, joint] = sign
                A[count, of] = -sign * slope
                b[count] = min(sign * (line - x[joint]), longest)
                count += 1
    return count
