"""Rigid bodies that roll to rest on a level floor, as NumPy for one and compiled for many.

With the direction down d and points p relative to the centre of mass, the height of the centre is max over p of d·p. A
body rests where this height has a local minimum: where the centre is above the hull of the points on the floor.
"""

from __future__ import annotations

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._kernels.cache import CachedKernel, Floats1, Floats2, Floats3, Ints1, Row, both_ways
from nao_kin._kernels.rows import run_rows

# While a body rolls over an edge, points within this distance of the lowest one touch the floor [m].
ROLLING = 1e-5
# Most rolls from one edge to the next; no body needs so many.
_MOST_ROLLS = 300


@both_ways
def nearest_of_hull(u: Row, v: Row) -> tuple[float, float]:
    """Return the point of the convex hull of points (u, v) that is nearest to the origin; (0, 0) if that is inside."""
    best, x, y = np.inf, u[0], v[0]
    if len(u) > 2:
        angles = np.sort(np.arctan2(v, u))
        if max((angles[1:] - angles[:-1]).max(), angles[0] + 2.0 * np.pi - angles[-1]) <= np.pi:
            return 0.0, 0.0
    # On the segment between some two points: on an edge of the hull, as others are farther away.
    for i in range(len(u) - 1):
        along_u, along_v = u - u[i], v - v[i]
        square = along_u * along_u + along_v * along_v
        share = np.minimum(np.maximum(-(u[i] * along_u + v[i] * along_v) / np.maximum(square, 1e-300), 0.0), 1.0)
        near_u, near_v = u[i] + share * along_u, v[i] + share * along_v
        squares = near_u * near_u + near_v * near_v
        k = squares.argmin()
        if squares[k] < best:
            best, x, y = squares[k], near_u[k], near_v[k]
    return x, y


@both_ways
def settled(x: Row, y: Row, z: Row, down: Row, most: float) -> tuple[float, float, float, float]:
    """Roll a body with points (x, y, z), relative to its centre of mass, from a direction down until it rests.

    It rolls over the edge nearest to its centre of mass until the centre is above the contacts: each roll lowers the
    centre. A roll that would turn it by more than `most` from the beginning does not take place [rad].

    Returns:
        The direction down (3 numbers), and the distance of the centre from the contacts, seen from above, 0 if it rests
        [m].
    """
    a, b, c = down[0], down[1], down[2]
    away = 0.0
    for _ in range(_MOST_ROLLS):
        # Two horizontal directions, as in `level_axes`.
        sign = 1.0 if c <= 0.0 else -1.0
        scale = -1.0 / (sign - c)
        ux, uy, uz = 1.0 + sign * a * a * scale, sign * a * b * scale, sign * a
        vx, vy, vz = a * b * scale, sign + b * b * scale, b
        depths = a * x + b * y + c * z
        floor = depths.max()
        on = depths >= floor - ROLLING
        on_x, on_y, on_z = x[on], y[on], z[on]
        p, q = nearest_of_hull(ux * on_x + uy * on_y + uz * on_z, vx * on_x + vy * on_y + vz * on_z)
        away = np.hypot(p, q)
        if away < ROLLING:
            away = 0.0
            break
        sx, sy, sz = -(p * ux + q * vx) / away, -(p * uy + q * vy) / away, -(p * uz + q * vz) / away
        # The angle at which the next point comes to the floor.
        ahead, above = sx * x + sy * y + sz * z + away, floor - depths
        new = (above > ROLLING) | (ahead > ROLLING)
        if not new.any():
            break
        angle = np.arctan2(1.0, np.where(new, ahead / above, -np.inf).max())
        cos, sin = np.cos(angle), np.sin(angle)
        na, nb, nc = cos * a + sin * sx, cos * b + sin * sy, cos * c + sin * sz
        length = np.sqrt(na * na + nb * nb + nc * nc)
        na, nb, nc = na / length, nb / length, nc / length
        if angle >= np.pi or na * down[0] + nb * down[1] + nc * down[2] < np.cos(most):
            break
        a, b, c = na, nb, nc
    return a, b, c, away


def settle(points: Floats, centres: Floats, starts: Floats, most: Floats) -> tuple[Floats, Floats, Ints1]:
    """Settle bodies (n, k, 3) with centres of mass (n, 3) from directions down (n, m, 3), NaN for none.

    `most` is the largest angle by which each is turned, shape (n, m), as in `settled`.

    Returns:
        The direction down, shape (n, 3), and the distance of the centre from the contacts, 0 if the body rests, shape
        (n,) [m]: from the first direction if the body comes to rest from there, else where it rests with the z axis
        most upright, or, if it comes to rest from none, where the centre is nearest to the contacts. The index of the
        direction, −1 for none, shape (n,).
    """
    bodies = np.ascontiguousarray(np.moveaxis(points - centres[:, None], 1, 2))
    begin, limits = np.ascontiguousarray(starts), np.ascontiguousarray(most)
    down, away = np.full((len(points), 3), np.nan), np.full(len(points), np.inf)
    chosen = np.full(len(points), -1, dtype=np.int64)
    parts = bodies, begin, limits, down, away, chosen
    run_rows(settle_rows, lambda function, part: function(*(array[part] for array in parts)), len(points), 1)
    return down, away, chosen


def rows_that_settle(
    bodies: Floats3, starts: Floats3, most: Floats2, down: Floats2, away: Floats1, chosen: Ints1
) -> None:
    """Write the results of `settle` for each row; the coordinates of its points are rows of `bodies`, (n, 3, k)."""
    for row in range(bodies.shape[0]):
        x, y, z = bodies[row, 0], bodies[row, 1], bodies[row, 2]
        best = np.inf
        for i in range(starts.shape[1]):
            if starts[row, i, 0] != starts[row, i, 0] or (chosen[row] == 0 and away[row] == 0.0):
                continue
            a, b, c, distance = settled(x, y, z, starts[row, i], most[row, i])
            cost = 10.0 + distance if distance > 0.0 else c
            if cost < best:
                best, away[row], chosen[row] = cost, distance, i
                down[row, 0], down[row, 1], down[row, 2] = a, b, c


settle_rows = CachedKernel(
    rows_that_settle, "the kernel of bodies that roll to rest", "world kernel, settling", seconds=10.0
)
