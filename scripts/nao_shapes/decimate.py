"""Remove triangles from nearly flat surfaces: edges collapse in the order of the resulting error.

Source: Garland and Heckbert, Surface simplification using quadric error metrics, SIGGRAPH 1997. A vertex only moves
into a neighbour, so that the remaining vertices do not move, nor edges and the plane of symmetry.
"""

from __future__ import annotations

import heapq
import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Vector = tuple[float, float, float]

# Largest rotation of a triangle by a collapse, and largest ratio of its longest edge to its height.
_TURN = math.cos(math.radians(25.0))
_SLIVER = 12.0
_NEEDLE = 50.0
# A triangle with a smaller height is a sliver.
_THIN = 0.05


def decimated(vertices: Floats, triangles: Ints, tolerance: float) -> Ints:
    """Return the triangles of a closed surface after all collapses within a tolerance.

    Args:
        vertices: shape (V, 3).
        triangles: vertices of each triangle, anticlockwise from outside, shape (T, 3).
        tolerance: root of the sum of squared distances of a vertex from the planes of all triangles that it
            represents, in the unit of the vertices.

    Returns:
        The remaining triangles, with the same vertex numbers, shape (S, 3).
    """
    return _Surface(vertices, triangles).collapse(tolerance**2)


class _Surface:
    def __init__(self, vertices: Floats, triangles: Ints) -> None:
        self.at: list[Vector] = [tuple(vertex) for vertex in vertices.tolist()]
        self.corners: dict[int, tuple[int, int, int]] = dict(enumerate(map(tuple, triangles.tolist())))
        self.around: list[set[int]] = [set() for _ in self.at]
        for face, corners in self.corners.items():
            for vertex in corners:
                self.around[vertex].add(face)
        self.quadrics = _quadrics(vertices, triangles)
        self.age = [0] * len(self.at)

    def collapse(self, most: float) -> Ints:
        queue = [(self.cost(a, b), a, b, 0, 0) for a in range(len(self.at)) for b in self.neighbours(a)]
        queue = [entry for entry in queue if entry[0] <= most]
        heapq.heapify(queue)
        while queue:
            _, gone, kept, age_gone, age_kept = heapq.heappop(queue)
            if self.age[gone] != age_gone or self.age[kept] != age_kept or not self.allows(gone, kept):
                continue
            self.merge(gone, kept)
            for other in self.neighbours(kept):
                for a, b in ((kept, other), (other, kept)):
                    cost = self.cost(a, b)
                    if cost <= most:
                        heapq.heappush(queue, (cost, a, b, self.age[a], self.age[b]))
        self.flip_slivers()
        return np.array(list(self.corners.values()), dtype=np.int64).reshape(-1, 3)

    def flip_slivers(self) -> None:
        """Flip the longest edge of every sliver, which gives two better triangles."""
        for face in list(self.corners):
            a, b, c = self.corners[face]
            if _Shape(self.at[a], self.at[b], self.at[c]).height > _THIN:
                continue
            # Turned until c lies opposite to the longest edge.
            while math.dist(self.at[a], self.at[b]) < max(
                math.dist(self.at[b], self.at[c]), math.dist(self.at[c], self.at[a])
            ):
                a, b, c = b, c, a
            (beyond,) = (self.around[a] & self.around[b]) - {face}
            (d,) = set(self.corners[beyond]) - {a, b}
            new = (a, d, c), (d, b, c)
            if d in self.neighbours(c) or min(_Shape(*(self.at[v] for v in one)).height for one in new) < _THIN:
                continue
            for one in (face, beyond):
                for vertex in self.corners[one]:
                    self.around[vertex].discard(one)
            for one, corners in zip((face, beyond), new, strict=True):
                self.corners[one] = corners
                for vertex in corners:
                    self.around[vertex].add(one)

    def neighbours(self, vertex: int) -> set[int]:
        return {other for face in self.around[vertex] for other in self.corners[face]} - {vertex}

    def cost(self, gone: int, kept: int) -> float:
        """Return the sum of the squared distances of `kept` from the planes that both vertices represent."""
        x, y, z = self.at[kept]
        xx, xy, xz, xw, yy, yz, yw, zz, zw, ww = (
            p + q for p, q in zip(self.quadrics[gone], self.quadrics[kept], strict=True)
        )
        square = (
            x * (xx * x + 2 * (xy * y + xz * z + xw)) + y * (yy * y + 2 * (yz * z + yw)) + z * (zz * z + 2 * zw) + ww
        )
        return max(square, 0.0)

    def allows(self, gone: int, kept: int) -> bool:
        """Return whether a collapse keeps the surface closed and its orientation, and adds no slivers."""
        shared = self.around[gone] & self.around[kept]
        if len(shared) != 2 or len(self.neighbours(gone) & self.neighbours(kept)) != 2:
            return False
        for face in self.around[gone] - shared:
            old = _Shape(*(self.at[vertex] for vertex in self.corners[face]))
            new = _Shape(*(self.at[kept if vertex == gone else vertex] for vertex in self.corners[face]))
            if new.slenderness > max(_SLIVER, old.slenderness):
                return False
            # A sliver has no direction to preserve.
            if old.slenderness < _NEEDLE and _dot(old.normal, new.normal) < _TURN * old.area * new.area:
                return False
        return True

    def merge(self, gone: int, kept: int) -> None:
        for face in self.around[gone] & self.around[kept]:
            for vertex in self.corners.pop(face):
                self.around[vertex].discard(face)
        for face in self.around[gone]:
            a, b, c = self.corners[face]
            self.corners[face] = (kept if a == gone else a, kept if b == gone else b, kept if c == gone else c)
            self.around[kept].add(face)
        self.around[gone] = set()
        self.quadrics[kept] = tuple(p + q for p, q in zip(self.quadrics[gone], self.quadrics[kept], strict=True))
        self.age[gone] += 1
        self.age[kept] += 1


class _Shape:
    """The shape of a triangle.

    Attributes:
        normal: its normal vector, whose length is twice the area.
        area: that length.
        slenderness: the ratio of the longest edge to the height on it.
        height: the height on the longest edge.
    """

    def __init__(self, a: Vector, b: Vector, c: Vector) -> None:
        (ux, uy, uz), (vx, vy, vz) = ((q - p for p, q in zip(a, end, strict=True)) for end in (b, c))
        self.normal = (uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx)
        self.area = math.hypot(*self.normal)
        longest = max(ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz, math.dist(b, c) ** 2)
        self.slenderness = longest / self.area if self.area > 1e-9 else math.inf
        self.height = self.area / math.sqrt(longest)


def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _quadrics(vertices: Floats, triangles: Ints) -> list[tuple[float, ...]]:
    """Return for each vertex the sum over its triangles of p pᵀ, where p is the plane: ten numbers, row by row."""
    a, b, c = np.moveaxis(vertices[triangles], 1, 0)
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 1e-6)
    planes = np.column_stack([normals, -(normals * a).sum(axis=1)])
    rows, columns = np.triu_indices(4)
    products = planes[:, rows] * planes[:, columns]
    sums = np.zeros((len(vertices), 10))
    np.add.at(sums, triangles.reshape(-1), np.repeat(products, 3, axis=0))
    return [tuple(row) for row in sums.tolist()]
