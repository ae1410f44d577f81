"""Convex hulls of points in a plane and distances from their edges, as Python for one and compiled for many."""

from __future__ import annotations

from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._kernels.cache import CachedKernel, Floats1, Floats2, Floats3, IntRow, Ints1, Row, both_ways, first_rows

# Twice the area below which points count as collinear [m²].
_NO_AREA = 1e-12


@both_ways
def hull_of(x: Row, y: Row, count: int, hull: IntRow) -> int:
    """Write the indices of the corners of the hull of points, counter-clockwise from the first; return their number.

    The points are sorted by x, and by y where x is equal. Points that count as collinear have no corners.
    `hull` needs 2 count + 1 places.

    Source: Andrew, Another efficient algorithm for convex hulls in two dimensions, 1979.
    """
    k = 0
    for half in range(2):
        begin = k
        for step in range(count):
            i = step if half == 0 else count - 1 - step
            while k > begin + 1:
                a, b = hull[k - 2], hull[k - 1]
                if (x[b] - x[a]) * (y[i] - y[a]) - (y[b] - y[a]) * (x[i] - x[a]) > 0.0:
                    break
                k -= 1
            hull[k] = i
            k += 1
        k -= 1
    # Relative to the first corner, because a distant origin costs digits.
    a, area = hull[0], 0.0
    for j in range(1, k - 1):
        b, c = hull[j], hull[j + 1]
        area += (x[b] - x[a]) * (y[c] - y[a]) - (y[b] - y[a]) * (x[c] - x[a])
    return k if area >= _NO_AREA else 0


@both_ways
def from_edge(x: Any, y: Any, along_x: Any, along_y: Any) -> Any:
    """Return the distance of a point from the line of an edge, positive on its left, and the square of that from it.

    The point and the end of the edge are given from its beginning; all four may be arrays.
    """
    square = along_x * along_x + along_y * along_y
    share = np.minimum(np.maximum((x * along_x + y * along_y) / square, 0.0), 1.0)
    across_x, across_y = x - share * along_x, y - share * along_y
    return (along_x * y - along_y * x) / np.sqrt(square), across_x * across_x + across_y * across_y


def hulls(points: Floats, centres: Floats) -> tuple[Floats, Floats, Floats, Ints1]:
    """Return the hulls of points (n, m, 2), NaN for none, and distances of centres (n, 2) from them.

    Returns:
        Vertices, shape (n, m, 2), and signed distances of the centre from the line of the edge that begins at each,
        shape (n, m), NaN for none; the signed distance from the polygon's edge, positive inside, NaN for no area, and
        the index of the nearest edge, −1 for none, both of shape (n,).
    """
    points, centres = np.ascontiguousarray(points), np.ascontiguousarray(centres)
    vertices, distances = np.full_like(points, np.nan), np.full(points.shape[:2], np.nan)
    margins, nearest = np.full(len(points), np.nan), np.full(len(points), -1, dtype=np.int64)
    parts = points, centres, vertices, distances, margins, nearest

    def run(part: slice) -> None:
        hull_rows.uncompiled(*(array[part] for array in parts))

    done = first_rows([hull_rows], run, len(points))
    if done < len(points):
        hull_rows(*(array[done:] for array in parts))
    return vertices, distances, margins, nearest


def rows_of_hulls(
    points: Floats3, centres: Floats2, vertices: Floats3, distances: Floats2, margins: Floats1, nearest: Ints1
) -> None:
    """Write the results of `hulls` for each row whose points span an area."""
    size = points.shape[1]
    x, y = np.empty(size), np.empty(size)
    hull = np.empty(2 * size + 1, dtype=np.int64)
    for row in range(points.shape[0]):
        count = 0
        for i in range(size):
            new_x, new_y = points[row, i, 0], points[row, i, 1]
            if new_x == new_x:  # not NaN
                j = count
                while j > 0 and (x[j - 1] > new_x or (x[j - 1] == new_x and y[j - 1] > new_y)):
                    x[j], y[j] = x[j - 1], y[j - 1]
                    j -= 1
                x[j], y[j] = new_x, new_y
                count += 1
        corners = hull_of(x, y, count, hull)
        inside, edge, away, outer = np.inf, -1, np.inf, -1
        for j in range(corners):
            a, b = hull[j], hull[(j + 1) % corners]
            vertices[row, j, 0], vertices[row, j, 1] = x[a], y[a]
            distance, square = from_edge(centres[row, 0] - x[a], centres[row, 1] - y[a], x[b] - x[a], y[b] - y[a])
            distances[row, j] = distance
            if distance < inside:
                inside, edge = distance, j
            if square < away:
                away, outer = square, j
        if corners:
            margins[row] = inside if inside >= 0.0 else -np.sqrt(away)
            nearest[row] = edge if inside >= 0.0 else outer


hull_rows = CachedKernel(rows_of_hulls, "the kernel of support polygons", "world kernel, hulls", seconds=3.0)
