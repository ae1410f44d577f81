"""Signed distances between segments and boxes, the cores of collision shapes, and the least one of each configuration.

A shape is a core grown by a radius: a point, a segment or a box with its centre and half lengths. The functions take
vectors as three components, each a number or an array of numbers, and have no branches: NumPy runs them on arrays, and
compiled code on numbers. Distances of cores are negative if they overlap: the least translation that separates them.
"""

from __future__ import annotations

from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats
from nao_kin._kernels.cache import CachedKernel, Floats1, Floats2, Floats3, Floats4, Ints1, Ints2, both_ways

Components: TypeAlias = tuple[Any, Any, Any]
Indices: TypeAlias = NDArray[np.signedinteger[Any]]

# Squared lengths below this are zero [m⁴]: 0.1 nm each.
_TINY = 1e-40
# Subtracted from a numerator [m²], so that the cross product of parallel directions is no direction.
_PARALLEL = 1e-13


@both_ways
def dot(a: Components, b: Components) -> Any:
    """Return a · b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@both_ways
def plus(a: Components, s: Any, b: Components) -> Components:
    """Return a + s b."""
    return a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]


@both_ways
def within(x: Any, most: Any) -> Any:
    """Return x moved into [−most, most]."""
    return np.minimum(np.maximum(x, -most), most)


@both_ways
def segments_squared(r: Components, u: Components, v: Components) -> Any:
    """Return the least |r + s u − t v|² for s and t in [−1, 1]: two segments, r from the second centre to the first.

    A segment may be a point, and the two may be parallel. Source: Ericson, Real-Time Collision Detection, 5.1.9.
    """
    a, e, b, c, f = dot(u, u), dot(v, v), dot(u, v), dot(u, r), dot(v, r)
    s = within((b * f - c * e) / np.maximum(a * e - b * b, _TINY), 1.0)
    t = within((f + s * b) / np.maximum(e, _TINY), 1.0)
    s = within((t * b - c) / np.maximum(a, _TINY), 1.0)
    between = plus(plus(r, s, u), -t, v)
    return dot(between, between)


# --- A segment with the centre p and the half vector d, in the axes of a box with the half lengths h.


@both_ways
def segment_box_overlap(p: Components, d: Components, h: Components) -> Any:
    """Return the largest gap of the projections on one axis: the depth, negative, where the two overlap.

    The axes are the normals of the faces of the Minkowski difference: those of the box, and edge × segment.
    """
    gap = np.maximum(np.abs(p[0]) - h[0] - np.abs(d[0]), np.abs(p[1]) - h[1] - np.abs(d[1]))
    gap = np.maximum(gap, np.abs(p[2]) - h[2] - np.abs(d[2]))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        away = np.abs(p[j] * d[k] - p[k] * d[j]) - h[j] * np.abs(d[k]) - h[k] * np.abs(d[j]) - _PARALLEL
        gap = np.maximum(gap, away / np.maximum(np.sqrt(d[j] * d[j] + d[k] * d[k]), _TINY))
    return gap


@both_ways
def segment_box_squared(p: Components, d: Components, h: Components) -> Any:
    """Return the squared distance of the two where they are apart: of the ends, or to one of the twelve edges."""
    one, other = plus(p, 1.0, d), plus(p, -1.0, d)
    least = np.minimum(_point_box_squared(one, h), _point_box_squared(other, h))
    zero = 0.0 * h[0]
    for j in (-1.0, 1.0):
        for k in (-1.0, 1.0):
            r = p[0], p[1] - j * h[1], p[2] - k * h[2]
            least = np.minimum(least, segments_squared(r, d, (h[0], zero, zero)))
            r = p[0] - j * h[0], p[1], p[2] - k * h[2]
            least = np.minimum(least, segments_squared(r, d, (zero, h[1], zero)))
            r = p[0] - j * h[0], p[1] - k * h[1], p[2]
            least = np.minimum(least, segments_squared(r, d, (zero, zero, h[2])))
    return least


@both_ways
def _point_box_squared(p: Components, h: Components) -> Any:
    away = p[0] - within(p[0], h[0]), p[1] - within(p[1], h[1]), p[2] - within(p[2], h[2])
    return dot(away, away)


# --- Two boxes: the second has the centre p, the axes X, Y, Z and the half lengths g in the axes of the first.


@both_ways
def boxes_overlap(p: Components, X: Components, Y: Components, Z: Components, h: Components, g: Components) -> Any:
    """Return the largest gap of the projections on one axis, as `segment_box_overlap`: 15 axes."""
    gap = np.abs(p[0]) - h[0] - g[0] * np.abs(X[0]) - g[1] * np.abs(Y[0]) - g[2] * np.abs(Z[0])
    for i in range(1, 3):
        reach = h[i] + g[0] * np.abs(X[i]) + g[1] * np.abs(Y[i]) + g[2] * np.abs(Z[i])
        gap = np.maximum(gap, np.abs(p[i]) - reach)
    for one, two, three, a, b, c in ((X, Y, Z, 0, 1, 2), (Y, Z, X, 1, 2, 0), (Z, X, Y, 2, 0, 1)):
        reach = g[a] + h[0] * np.abs(one[0]) + h[1] * np.abs(one[1]) + h[2] * np.abs(one[2])
        gap = np.maximum(gap, np.abs(dot(p, one)) - reach)
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            # Along e_i × one; e_i × one · two = −three[i], and the other way round.
            reach = h[j] * np.abs(one[k]) + h[k] * np.abs(one[j]) + g[b] * np.abs(three[i]) + g[c] * np.abs(two[i])
            away = np.abs(p[j] * one[k] - p[k] * one[j]) - reach - _PARALLEL
            gap = np.maximum(gap, away / np.maximum(np.sqrt(one[j] * one[j] + one[k] * one[k]), _TINY))
    return gap


@both_ways
def edges_box_squared(p: Components, X: Components, Y: Components, Z: Components, h: Components, g: Components) -> Any:
    """Return the least squared distance between the edges of the second box and the first box, if they are apart."""
    least = segment_box_squared(plus(plus(p, g[1], Y), g[2], Z), (g[0] * X[0], g[0] * X[1], g[0] * X[2]), h)
    for one, two, three, a, b, c in ((X, Y, Z, 0, 1, 2), (Y, Z, X, 1, 2, 0), (Z, X, Y, 2, 0, 1)):
        half = g[a] * one[0], g[a] * one[1], g[a] * one[2]
        for j in (-1.0, 1.0):
            for k in (-1.0, 1.0):
                centre = plus(plus(p, j * g[b], two), k * g[c], three)
                least = np.minimum(least, segment_box_squared(centre, half, h))
    return least


# --- The least distance of many pairs of shapes.

SEGMENT, BOX = 0, 1


class ShapeTable(NamedTuple):
    """The shapes of a robot: link of each (s,), SEGMENT or BOX; centre (s, 3), axes as columns (s, 3, 3) in the link.

    `half`: half lengths along the axes (s, 3), a segment's along its third axis; `radius` by which the core is grown
    (s,); `reach`: radius of the sphere about the centre that contains the shape (s,) [m].
    """

    link: Ints1
    kind: Ints1
    centre: Floats2
    axes: Floats3
    half: Floats2
    radius: Floats1
    reach: Floats1


@both_ways
def _vector(rows: Floats, column: int) -> Components:
    return rows[0, column], rows[1, column], rows[2, column]


@both_ways
def _along(axes: Floats, p: Components) -> Components:
    """Return p in axes given as columns."""
    return dot(p, _vector(axes, 0)), dot(p, _vector(axes, 1)), dot(p, _vector(axes, 2))


@both_ways
def _core_gap(r: Components, one: Floats, h: Floats, kind: int, two: Floats, g: Floats, other: int, most: float) -> Any:
    """Return the distance of two cores with axes and half lengths, r from the first to the second; or more than most.

    If one of the two is a segment, it is the second.
    """
    z = _vector(two, 2)
    v = g[2] * z[0], g[2] * z[1], g[2] * z[2]
    if kind == SEGMENT:
        y = _vector(one, 2)
        return np.sqrt(segments_squared(r, v, (h[2] * y[0], h[2] * y[1], h[2] * y[2])))
    first, p = (h[0], h[1], h[2]), _along(one, r)
    if other == SEGMENT:
        d = _along(one, v)
        gap = segment_box_overlap(p, d, first)
        return np.sqrt(segment_box_squared(p, d, first)) if 0.0 < gap < most else gap
    second = g[0], g[1], g[2]
    X, Y, Z = _along(one, _vector(two, 0)), _along(one, _vector(two, 1)), _along(one, z)
    gap = boxes_overlap(p, X, Y, Z, first, second)
    if gap <= 0.0 or gap >= most:
        return gap
    least = edges_box_squared(p, X, Y, Z, first, second)
    away = _along(two, r)
    rows = (X[0], Y[0], Z[0]), (X[1], Y[1], Z[1]), (X[2], Y[2], Z[2])
    back = edges_box_squared((-away[0], -away[1], -away[2]), rows[0], rows[1], rows[2], second, first)
    return np.sqrt(np.minimum(least, back))


def _clearances(poses: Floats4, shapes: ShapeTable, pairs: Ints2, below: float, gaps: Floats1, which: Ints1) -> None:
    """Write the least distance of pairs (m, 2) of shapes at poses (n, links, 4, 4), and which pair has it.

    Only distances below `below` are found: else this number, and −1. In a pair a box is before a segment.
    """
    count = len(shapes.link)
    centre, axes = np.empty((count, 3)), np.empty((count, 3, 3))
    for sample in range(len(poses)):
        for s in range(count):
            T = poses[sample, shapes.link[s]]
            for i in range(3):
                centre[s, i] = T[i, 3]
                for k in range(3):
                    centre[s, i] += T[i, k] * shapes.centre[s, k]
                    axes[s, i, k] = 0.0
                    for m in range(3):
                        axes[s, i, k] += T[i, m] * shapes.axes[s, m, k]
        best, found = below, -1
        for pair in range(len(pairs)):
            a, b = pairs[pair, 0], pairs[pair, 1]
            r = centre[b, 0] - centre[a, 0], centre[b, 1] - centre[a, 1], centre[b, 2] - centre[a, 2]
            bound = best + shapes.reach[a] + shapes.reach[b]
            if bound <= 0.0 or dot(r, r) >= bound * bound:
                continue
            grown = shapes.radius[a] + shapes.radius[b]
            kinds = shapes.kind[a], shapes.kind[b]
            gap = _core_gap(r, axes[a], shapes.half[a], kinds[0], axes[b], shapes.half[b], kinds[1], best + grown)
            if gap - grown < best:
                best, found = gap - grown, pair
        gaps[sample], which[sample] = best, found


clearances = CachedKernel(_clearances, "the kernel of self-collisions", "collision kernel, clearances", seconds=3.0)


def pair_gaps(centres: Floats, axes: Floats, shapes: ShapeTable, pairs: Indices, at: Indices) -> Floats:
    """Return the distances of pairs (k, 2) of shapes in configurations `at` (k,), in NumPy, shape (k,).

    `centres` (n, s, 3) and `axes` (n, s, 3, 3) are those of the shapes in each configuration.
    """
    gaps = np.empty(len(pairs))
    for kinds in ((SEGMENT, SEGMENT), (BOX, SEGMENT), (BOX, BOX)):
        rows = np.flatnonzero((shapes.kind[pairs] == kinds).all(axis=1))
        if not len(rows):
            continue
        a, b, n = pairs[rows, 0], pairs[rows, 1], at[rows]
        r = _components(centres[n, b] - centres[n, a])
        h, g = _components(shapes.half[a]), _components(shapes.half[b])
        X, Y, Z = (_components(axes[n, b, :, k]) for k in range(3))
        if kinds == (SEGMENT, SEGMENT):
            u = _components(shapes.half[a, 2:] * axes[n, a, :, 2])
            core = np.sqrt(segments_squared(r, (g[2] * Z[0], g[2] * Z[1], g[2] * Z[2]), u))
        else:
            turned = [_components(np.einsum("nik,ni->nk", axes[n, a], np.transpose(w))) for w in (r, X, Y, Z)]
            p, X, Y, Z = turned
            if kinds == (BOX, SEGMENT):
                d = g[2] * Z[0], g[2] * Z[1], g[2] * Z[2]
                core = _apart(segment_box_overlap(p, d, h), segment_box_squared(p, d, h))
            else:
                back = _components(-np.einsum("nik,ni->nk", axes[n, b], np.transpose(r)))
                first, second, third = ((X[i], Y[i], Z[i]) for i in range(3))
                squared = np.minimum(
                    edges_box_squared(p, X, Y, Z, h, g), edges_box_squared(back, first, second, third, g, h)
                )
                core = _apart(boxes_overlap(p, X, Y, Z, h, g), squared)
        gaps[rows] = core - shapes.radius[a] - shapes.radius[b]
    return gaps


def _components(vectors: Floats) -> Components:
    x, y, z = np.moveaxis(vectors, -1, 0)
    return x, y, z


def _apart(overlap: Any, squared: Any) -> Any:
    return np.where(overlap > 0.0, np.sqrt(squared), overlap)
