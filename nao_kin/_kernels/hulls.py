"""Convex hulls: signed distances between hulls grown by a radius, and hulls of points in a plane.

A hull in space is given by its vertices and a radius, which may be zero: a ball has one vertex, a capsule two, a box
eight. The algorithm of Gilbert, Johnson and Keerthi finds distances; expanding polytopes find penetration depths.

Source: Gilbert, Johnson, Keerthi, A fast procedure for computing the distance between complex objects in
three-dimensional space, IEEE J. Robotics and Automation 4(2), 1988; van den Bergen, Collision Detection in Interactive
3D Environments, 2004, chapter 4; Ericson, Real-Time Collision Detection, 2005, chapter 5.
"""

from __future__ import annotations

from typing import Any, NamedTuple, TypeAlias

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._kernels.cache import (
    CachedKernel,
    Floats1,
    Floats2,
    Floats3,
    Floats4,
    IntRow,
    Ints1,
    Ints2,
    Row,
    both_ways,
)
from nao_kin._kernels.rows import run_rows

Components: TypeAlias = tuple[Any, Any, Any]

# Distances are exact to about this length, and a difference of hulls that is thinner than this has depth zero [m].
_EXACT = 1e-10
# Bound of rounding errors [m].
_ROUNDING = 1e-13
# After this number of steps a search ends with its last result; hulls of a few hundred vertices take far fewer.
_STEPS = 100
# Largest number of vertices and of faces of an expanding polytope.
_CORNERS, _FACES = 128, 512


class HullTable(NamedTuple):
    """The hulls of a robot, s of them; those that are parts of another hull come last."""

    link: Ints1  # the link of each hull
    first: Ints1  # index in `points` of the first vertex of each hull, then the number of points, shape (s + 1,)
    points: Floats2  # vertices in the frames of their links, shape (p, 3) [m]
    radius: Floats1  # by which each hull is grown [m]
    ends: Floats2  # ends of the segment of a capsule that contains the hull, in its link, shape (s, 6) [m]
    width: Floats1  # radius of that capsule [m]
    parts: Ints2  # the hulls that count for each: itself, or the range of its parts, which it contains, shape (s, 2)


@both_ways
def _dot(a: Components, b: Components) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@both_ways
def _minus(a: Components, b: Components) -> Components:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@both_ways
def _plus(a: Components, s: Any, b: Components) -> Components:
    """Return a + s b."""
    return a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]


@both_ways
def _cross(a: Components, b: Components) -> Components:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@both_ways
def _row(rows: Any, k: int) -> Components:
    return rows[k, 0], rows[k, 1], rows[k, 2]


@both_ways
def _column(rows: Any, k: int) -> Components:
    return rows[0, k], rows[1, k], rows[2, k]


@both_ways
def _unit(axis: int) -> Components:
    return 1.0 * (axis == 0), 1.0 * (axis == 1), 1.0 * (axis == 2)


@both_ways
def _clipped(x: Any) -> Any:
    return np.minimum(np.maximum(x, -1.0), 1.0)


@both_ways
def between_segments(r: Components, u: Components, v: Components) -> Components:
    """Return the shortest vector from the second of two segments to the first, r + s u − t v with s and t in [−1, 1].

    r goes from the second centre to the first; u and v go from the centres to an end. Segments may be points, or
    parallel.
    Source: Ericson, Real-Time Collision Detection, 5.1.9.
    """
    a, e, b, c, f = _dot(u, u), _dot(v, v), _dot(u, v), _dot(u, r), _dot(v, r)
    s = _clipped((b * f - c * e) / np.maximum(a * e - b * b, 1e-40))
    t = _clipped((f + s * b) / np.maximum(e, 1e-40))
    s = _clipped((t * b - c) / np.maximum(a, 1e-40))
    return _plus(_plus(r, s, u), -t, v)


@both_ways
def segments_squared(r: Components, u: Components, v: Components) -> Any:
    """Return the squared distance of two segments, given as for `between_segments`."""
    between = between_segments(r, u, v)
    return _dot(between, between)


@both_ways
def _farthest(points: Any, first: int, last: int, d: Components) -> Components:
    """Return the vertex of a hull that is farthest along d."""
    best, found = -np.inf, first
    for k in range(first, last):
        along = _dot(_row(points, k), d)
        if along > best:
            best, found = along, k
    return _row(points, found)


@both_ways
def _support(points: Any, one: Any, other: Any, R: Any, t: Components, d: Components) -> Components:
    """Return the point of the first hull minus the second that is farthest along d; R and t place the second."""
    a = _farthest(points, one[0], one[1], d)
    turned = -_dot(_column(R, 0), d), -_dot(_column(R, 1), d), -_dot(_column(R, 2), d)
    b = _farthest(points, other[0], other[1], turned)
    return _minus(_minus(a, t), (_dot(_row(R, 0), b), _dot(_row(R, 1), b), _dot(_row(R, 2), b)))


# --- The point of a simplex that is nearest to the origin. The corners of the simplex are the first rows of W.


@both_ways
def _of_segment(W: Any, i: int, j: int) -> Any:
    """Return the point of an edge nearest to the origin, and the corners that span it, −1 for each other corner."""
    a, b = _row(W, i), _row(W, j)
    ab = _minus(b, a)
    along, length = -_dot(a, ab), _dot(ab, ab)
    if along <= 0.0:
        return a, (i, -1, -1)
    if along >= length:
        return b, (j, -1, -1)
    return _plus(a, along / length, ab), (i, j, -1)


@both_ways
def _of_triangle(W: Any, i: int, j: int, k: int) -> Any:
    """Return the point of a face nearest to the origin, and the corners that span it, −1 for each other corner."""
    a, b, c = _row(W, i), _row(W, j), _row(W, k)
    ab, ac = _minus(b, a), _minus(c, a)
    normal = _cross(ab, ac)
    size = _dot(normal, normal)
    # Twice the area of the triangle of each edge and the origin's projection, times the length of the normal.
    u, v, w = _dot(_cross(b, c), normal), _dot(_cross(c, a), normal), _dot(_cross(a, b), normal)
    if size > 0.0 and u > 0.0 and v > 0.0 and w > 0.0:
        share = _dot(a, normal) / size
        return (share * normal[0], share * normal[1], share * normal[2]), (i, j, k)
    best = _of_segment(W, i, j)
    for found in (_of_segment(W, j, k), _of_segment(W, k, i)):
        if _dot(found[0], found[0]) < _dot(best[0], best[0]):
            best = found
    return best


@both_ways
def _nearest(W: Any, count: int) -> Any:
    """Return the point of a simplex of 2 to 4 corners nearest to the origin, and the number of corners that span it.

    These corners are moved to the first rows of W; the number is 4 if the origin is inside.
    """
    if count == 2:
        v, corners = _of_segment(W, 0, 1)
    elif count == 3:
        v, corners = _of_triangle(W, 0, 1, 2)
    else:
        v, corners = (0.0, 0.0, 0.0), (-1, -1, -1)
        best = np.inf
        a = _row(W, 0)
        ab, ac, ad = _minus(_row(W, 1), a), _minus(_row(W, 2), a), _minus(_row(W, 3), a)
        volume = _dot(ab, _cross(ac, ad))
        size = max(_dot(ab, ab), _dot(ac, ac), _dot(ad, ad))
        flat = volume * volume <= 1e-24 * size * size * size
        for i, j, k, other in ((0, 1, 2, 3), (0, 1, 3, 2), (0, 2, 3, 1), (1, 2, 3, 0)):
            p = _row(W, i)
            normal = _cross(_minus(_row(W, j), p), _minus(_row(W, k), p))
            if flat or _dot(p, normal) * _dot(_minus(p, _row(W, other)), normal) <= 0.0:
                found = _of_triangle(W, i, j, k)
                squared = _dot(found[0], found[0])
                if squared < best:
                    best = squared
                    v, corners = found
        if corners[0] < 0:
            return v, 4
    kept = 0
    moved = _row(W, corners[0]), _row(W, max(corners[1], 0)), _row(W, max(corners[2], 0))
    for number in range(3):
        if corners[number] >= 0:
            for axis in range(3):
                W[kept, axis] = moved[number][axis]
            kept += 1
    return v, kept


# --- Distance and depth of two hulls.


@both_ways
def _distance(points: Any, one: Any, other: Any, R: Any, t: Components, most: float, W: Any) -> tuple[float, int]:
    """Return the distance of two hulls, 0 if they overlap; if it is at least `most`, return any number from `most` on.

    The second result is the number of corners in W of a simplex of the hulls' difference.
    """
    v = _support(points, one, other, R, t, (-t[0], -t[1], -t[2]))
    W[0] = v
    count, apart = 1, 0.0
    squared = _dot(v, v)
    for _ in range(_STEPS):
        if squared <= _EXACT * _EXACT:
            return 0.0, count
        w = _support(points, one, other, R, t, (-v[0], -v[1], -v[2]))
        along, length = _dot(v, w), np.sqrt(squared)
        apart = max(apart, along / length)
        if apart >= most or squared - along <= _EXACT * length:
            return (apart if apart >= most else length), count
        W[count] = w
        v, count = _nearest(W, count + 1)
        if count == 4:
            return 0.0, 4
        before, squared = squared, _dot(v, v)
        if squared >= before:  # not nearer, because of rounding
            return length, count
    return np.sqrt(squared), count


@both_ways
def _first_corners(points: Any, one: Any, other: Any, R: Any, t: Components, V: Any, count: int) -> bool:
    """Write four points that span a volume in the difference of two hulls; return False if the difference is flat."""
    if count == 4:
        ab, ac = _minus(_row(V, 1), _row(V, 0)), _minus(_row(V, 2), _row(V, 0))
        normal = _cross(ab, ac)
        if abs(_dot(normal, _minus(_row(V, 3), _row(V, 0)))) > 1e-6 * np.sqrt(_dot(normal, normal)):
            return True
    size = 0.0
    for axis in range(3):
        d = _unit(axis)
        high = _support(points, one, other, R, t, d)
        low = _support(points, one, other, R, t, (-d[0], -d[1], -d[2]))
        if high[axis] - low[axis] > size:
            V[0], V[1], size = high, low, high[axis] - low[axis]
    if size <= _EXACT:
        return False
    a = _row(V, 0)
    edge = _minus(_row(V, 1), a)
    flattest = 0 if abs(edge[0]) <= min(abs(edge[1]), abs(edge[2])) else 1 if abs(edge[1]) <= abs(edge[2]) else 2
    across = _cross(edge, _unit(flattest))
    for turn in range(4):  # both directions along two lines across the edge
        if turn == 2:
            across = _cross(edge, across)
        sign = 1.0 - 2.0 * (turn % 2)
        V[2] = _support(points, one, other, R, t, (sign * across[0], sign * across[1], sign * across[2]))
        normal = _cross(edge, _minus(_row(V, 2), a))
        length = np.sqrt(_dot(normal, normal))
        if length > _EXACT * np.sqrt(_dot(edge, edge)):
            break
    else:
        return False
    for sign in (1.0, -1.0):
        V[3] = _support(points, one, other, R, t, (sign * normal[0], sign * normal[1], sign * normal[2]))
        if abs(_dot(_minus(_row(V, 3), a), normal)) > _EXACT * length:
            return True
    return False


@both_ways
def _add_face(V: Any, i: int, j: int, k: int, face: int, F: Any, N: Any) -> None:
    """Write a face whose normal points outwards if its corners are counter-clockwise seen from outside."""
    a = _row(V, i)
    normal = _cross(_minus(_row(V, j), a), _minus(_row(V, k), a))
    length = np.sqrt(_dot(normal, normal))
    F[face, 0], F[face, 1], F[face, 2], F[face, 3] = i, j, k, 0
    if length <= 1e-30:  # a face without area is never the nearest one
        N[face, 0] = N[face, 1] = N[face, 2] = 0.0
        N[face, 3] = np.inf
        return
    for axis in range(3):
        N[face, axis] = normal[axis] / length
    N[face, 3] = _dot(a, normal) / length


@both_ways
def _open_up(nearest: int, w: Components, faces: int, F: Any, N: Any, E: Any) -> int:
    """Mark with 2 the nearest face and the faces around it that w sees; return the number of edges around all these."""
    for face in range(faces):
        F[face, 3] = _dot(_row(N, face), w) > N[face, 3] + _ROUNDING or N[face, 3] == np.inf
    # Each face is next to a marked one: all are connected, although rounding blurs which faces w sees.
    edges, going = 0, nearest
    while going >= 0:
        F[going, 3] = 2
        for side in range(3):
            i, j = F[going, side], F[going, (side + 1) % 3]
            twin = _edge(E, edges, j, i)
            if twin >= 0:  # an edge between two marked faces
                edges -= 1
                E[twin, 0], E[twin, 1] = E[edges, 0], E[edges, 1]
            else:
                E[edges, 0], E[edges, 1] = i, j
                edges += 1
        going = -1
        for face in range(faces):
            if F[face, 3] == 1:
                for side in range(3):
                    if _edge(E, edges, F[face, (side + 1) % 3], F[face, side]) >= 0:
                        going = face
                if going >= 0:
                    break
    return edges


@both_ways
def _edge(E: Any, edges: int, i: int, j: int) -> int:
    for edge in range(edges):
        if E[edge, 0] == i and E[edge, 1] == j:
            return edge
    return -1


@both_ways
def _depth(points: Any, one: Any, other: Any, R: Any, t: Components, least: float, work: Any, count: int) -> Any:
    """Return the length of the least translation that separates two overlapping hulls.

    If it is less than `least`, return any number up to `least`. A polytope inside the difference of the hulls grows at
    its face nearest to the origin, until this face is also a face of the difference.
    """
    V, N, F, E = work
    if not _first_corners(points, one, other, R, t, V, count):
        return 0.0
    a = _row(V, 0)
    flip = _dot(_cross(_minus(_row(V, 1), a), _minus(_row(V, 2), a)), _minus(_row(V, 3), a)) > 0.0
    faces = corners = 4
    for face in range(4):
        i, j, k = (0, 1, 2) if face == 0 else (0, 3, 1) if face == 1 else (0, 2, 3) if face == 2 else (1, 3, 2)
        if flip:
            i, j = j, i
        _add_face(V, i, j, k, face, F, N)
    bound = np.inf
    while True:
        nearest = 0
        for face in range(1, faces):
            if N[face, 3] < N[nearest, 3]:
                nearest = face
        n, depth = _row(N, nearest), N[nearest, 3]
        w = _support(points, one, other, R, t, n)
        along = _dot(n, w)
        bound = min(bound, along)
        if bound <= least or along - depth <= _EXACT or corners == _CORNERS:
            return max(bound, 0.0)
        V[corners] = w
        corners += 1
        edges = _open_up(nearest, w, faces, F, N, E)
        kept = 0
        for face in range(faces):
            if F[face, 3] != 2:
                for column in range(4):
                    F[kept, column], N[kept, column] = F[face, column], N[face, column]
                kept += 1
        if kept + edges > _FACES:
            return max(bound, 0.0)
        for edge in range(edges):
            _add_face(V, E[edge, 0], E[edge, 1], corners - 1, kept + edge, F, N)
        faces = kept + edges


# --- The smallest distance of many pairs of hulls.


def _clearances(poses: Floats4, hulls: HullTable, pairs: Ints2, below: float, gaps: Floats1, which: Ints1) -> None:
    """Write the smallest distance of pairs (m, 2) of hulls at each of the poses and its pair, or `below` and −1."""
    count = len(hulls.link)
    centre, half = np.empty((count, 3)), np.empty((count, 3))
    least, R = np.empty(len(pairs)), np.empty((3, 3))
    work = (
        np.empty((_CORNERS, 3)),
        np.empty((_FACES, 4)),
        np.empty((_FACES, 4), np.int64),
        np.empty((3 * _FACES, 2), np.int64),
    )
    for sample in range(len(poses)):
        for s in range(count):
            T = poses[sample, hulls.link[s]]
            for i in range(3):
                centre[s, i], half[s, i] = T[i, 3], 0.0
                for k in range(3):
                    centre[s, i] += 0.5 * T[i, k] * (hulls.ends[s, k] + hulls.ends[s, k + 3])
                    half[s, i] += 0.5 * T[i, k] * (hulls.ends[s, k + 3] - hulls.ends[s, k])
        best, found, first, smallest = below, -1, 0, np.inf
        for pair in range(len(pairs)):
            a, b = pairs[pair, 0], pairs[pair, 1]
            r = _minus(_row(centre, a), _row(centre, b))
            least[pair] = np.sqrt(segments_squared(r, _row(half, a), _row(half, b))) - hulls.width[a] - hulls.width[b]
            if least[pair] < smallest and hulls.parts[a, 0] == a and hulls.parts[b, 0] == b:
                first, smallest = pair, least[pair]
        for number in range(-1, len(pairs)):  # the pair that is likely to be nearest goes first
            pair = number if number >= 0 else first
            if least[pair] >= best or number == first:
                continue
            for a in range(hulls.parts[pairs[pair, 0], 0], hulls.parts[pairs[pair, 0], 1]):
                for b in range(hulls.parts[pairs[pair, 1], 0], hulls.parts[pairs[pair, 1], 1]):
                    grown = hulls.radius[a] + hulls.radius[b]
                    r, size = _minus(_row(centre, a), _row(centre, b)), hulls.width[a] + hulls.width[b]
                    if np.sqrt(segments_squared(r, _row(half, a), _row(half, b))) - size >= best:
                        continue
                    A, B = poses[sample, hulls.link[a]], poses[sample, hulls.link[b]]
                    away = _minus(_column(B, 3), _column(A, 3))
                    for i in range(3):
                        for k in range(3):
                            R[i, k] = _dot(_column(A, i), _column(B, k))
                    t = _dot(_column(A, 0), away), _dot(_column(A, 1), away), _dot(_column(A, 2), away)
                    one, other = (hulls.first[a], hulls.first[a + 1]), (hulls.first[b], hulls.first[b + 1])
                    gap, corners = _distance(hulls.points, one, other, R, t, max(best + grown, _EXACT), work[0])
                    if gap == 0.0:
                        gap = -_depth(hulls.points, one, other, R, t, -(best + grown), work, corners)
                    if gap - grown < best:
                        best, found = gap - grown, pair
        gaps[sample], which[sample] = best, found


clearances = CachedKernel(_clearances, "the kernel of self-collisions", "collision kernel, clearances", seconds=8.0)


# --- Convex hulls of points in a plane, and distances from their edges, as Python for one and compiled for many.

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

    run_rows(hull_rows, lambda function, part: function(*(array[part] for array in parts)), len(points), 1)
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
