"""From a solid to the text of a Wavefront OBJ file.

The triangles are rounded, welded and sorted, with normals that keep edges sharp, so that equal solids give equal text.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from manifold3d import Manifold
from numpy.typing import NDArray

from nao_shapes.decimate import decimated
from nao_shapes.solids import Y, Z

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
# Vertex and normal of one corner of a face.
Corner = tuple[int, int]

# Vertices are on a grid of 10 µm, so that the last bits of a platform's arithmetic do not affect the file.
_DECIMALS_MM = 2
_DECIMALS_NORMAL = 3
# Smallest detail to keep [mm], and largest movement of the surface to save triangles.
_DETAIL_MM = 0.02
TOLERANCE_MM = 0.4
# Faces that meet at a flatter angle than this share a normal and look like one curved surface.
_CREASE = math.radians(35.0)
_NOTHING = 1e-9


@dataclass(frozen=True)
class Surface:
    """Triangles with a normal at each of their corners.

    Attributes:
        vertices: shape (V, 3) [mm].
        triangles: vertices of each triangle, anticlockwise from outside, shape (T, 3).
        normals: unit vectors, shape (N, 3).
        corners: normals of each triangle's corners, shape (T, 3).
    """

    vertices: Floats
    triangles: Ints
    normals: Floats
    corners: Ints


def surface_of(solid: Manifold, *, mirror: Literal["y", "z"] | None = None, tolerance: float = TOLERANCE_MM) -> Surface:
    """Return the surface of a solid, with fewer triangles where it is nearly flat.

    Args:
        solid: the solid.
        mirror: make one half and mirror it along an axis, for a part that is its own mirror image.
        tolerance: largest movement of the surface [mm].
    """
    if mirror is not None:
        solid = solid.trim_by_plane(Y if mirror == "y" else Z, 0.0)
    mesh = solid.simplify(_DETAIL_MM).to_mesh()
    vertices = np.round(np.asarray(mesh.vert_properties, dtype=np.float64)[:, :3], _DECIMALS_MM) + 0.0
    vertices, dense = _canonical(vertices, np.asarray(mesh.tri_verts, dtype=np.int64))
    triangles = decimated(vertices, dense, tolerance)
    if mirror is not None:
        vertices, dense, triangles = _whole(vertices, "xyz".index(mirror), dense, triangles)
    return _with_normals(vertices, dense, triangles)


def _whole(vertices: Floats, axis: int, *surfaces: Ints) -> tuple[Any, ...]:
    """Return vertices and triangles of halves with their mirror images, without the cut between them."""
    flip = np.ones(3)
    flip[axis] = -1.0
    count = len(vertices)
    mirrored = np.where(vertices[:, axis] == 0.0, np.arange(count), np.arange(count) + count)
    found: list[Any] = [np.concatenate([vertices, vertices * flip + 0.0])]
    for triangles in surfaces:
        half = triangles[~(vertices[triangles, axis] == 0.0).all(axis=1)]
        # Mirroring turns triangles inside out, so they are listed the other way round.
        found.append(np.concatenate([half, mirrored[half[:, ::-1]]]))
    return tuple(found)


def _canonical(vertices: Floats, triangles: Ints) -> tuple[Floats, Ints]:
    """Weld equal vertices, remove collapsed triangles, and sort everything."""
    vertices, inverse = np.unique(vertices, axis=0, return_inverse=True)
    triangles = inverse.reshape(-1)[triangles]
    a, b, c = triangles.T
    triangles = _without_folds(triangles[(a != b) & (b != c) & (c != a)])
    used, inverse = np.unique(triangles, return_inverse=True)
    vertices, triangles = vertices[used], inverse.reshape(-1, 3)
    first = triangles.argmin(axis=1)
    triangles = np.take_along_axis(triangles, (first[:, None] + np.arange(3)) % 3, axis=1)
    return vertices, triangles[np.lexsort(triangles.T[::-1])]


def _without_folds(triangles: Ints) -> Ints:
    """Return the triangles without back-to-back pairs, which slivers leave after welding."""
    _, inverse, counts = np.unique(np.sort(triangles, axis=1), axis=0, return_inverse=True, return_counts=True)
    alone: Ints = triangles[counts[inverse.reshape(-1)] == 1]
    return alone


def _with_normals(vertices: Floats, dense: Ints, triangles: Ints) -> Surface:
    """Return the triangles with normals: for each corner the mean of the dense faces on its smooth side of the vertex.

    The shading is therefore that of the original surface, for any remaining triangles.
    """
    vertices, triangles, dense = _sorted(vertices, triangles, dense)
    facing, weight = _facing(vertices[dense])
    own, _ = _facing(vertices[triangles])
    vertex, face = dense.reshape(-1), np.repeat(np.arange(len(dense)), 3)
    order = np.argsort(vertex, kind="stable")
    groups = np.split(order, np.searchsorted(vertex[order], np.arange(1, len(vertices))))
    sides = [_sides(dense[face[here]], facing[face[here]], weight[here]) for here in groups[: triangles.max() + 1]]
    means = np.zeros((*triangles.shape, 3))
    for i, corners in enumerate(triangles):
        for k, corner in enumerate(corners):
            likeness = sides[corner] @ own[i]
            # If no side at the vertex has a similar direction, a triangle has its own direction.
            means[i, k] = sides[corner][likeness.argmax()] if likeness.max() > 0.3 else own[i]
    normals, inverse = np.unique(np.round(means.reshape(-1, 3), _DECIMALS_NORMAL) + 0.0, axis=0, return_inverse=True)
    return Surface(vertices[: len(sides)], triangles, normals, inverse.reshape(-1, 3))


def _sides(faces: Ints, facing: Floats, weight: Floats) -> Floats:
    """Return the unit normals of the smooth sides that meet at a vertex with these faces."""
    label = list(range(len(faces)))
    corners = [set(face) for face in faces.tolist()]
    smooth = facing @ facing.T > math.cos(_CREASE)
    for i, j in itertools.combinations(range(len(faces)), 2):
        if label[i] != label[j] and smooth[i, j] and len(corners[i] & corners[j]) == 2:
            label = [label[i] if one == label[j] else one for one in label]
    sums = np.array([weight[np.equal(label, one)] @ facing[np.equal(label, one)] for one in dict.fromkeys(label)])
    length = np.linalg.norm(sums, axis=1, keepdims=True)
    return np.asarray(sums / np.maximum(length, _NOTHING))


def _sorted(vertices: Floats, triangles: Ints, dense: Ints) -> tuple[Floats, Ints, Ints]:
    """Return only the vertices in use, first those of `triangles`, and the triangles in a fixed order."""
    used = np.unique(triangles)
    rank = np.full(len(vertices), -1)
    order = used[np.lexsort(vertices[used].T[::-1])]
    rank[order] = np.arange(len(order))
    rest = np.setdiff1d(np.unique(dense), used)
    rank[rest] = len(order) + np.arange(len(rest))
    triangles, dense = rank[triangles], rank[dense]
    first = triangles.argmin(axis=1)
    triangles = np.take_along_axis(triangles, (first[:, None] + np.arange(3)) % 3, axis=1)
    return vertices[np.concatenate([order, rest])], triangles[np.lexsort(triangles.T[::-1])], dense


def _facing(corners: Floats) -> tuple[Floats, Floats]:
    """Return unit normals of triangles, and their weights at their corners: the angle there, less for slivers."""
    ahead, behind = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    cross = np.cross(ahead, behind)
    sine, cosine = np.linalg.norm(cross, axis=-1), (ahead * behind).sum(axis=-1)
    weight = (np.arctan2(sine, cosine) * np.sqrt(sine[:, :1])).reshape(-1)
    return cross[:, 0] / np.maximum(sine[:, :1], _NOTHING), weight


def obj_text(name: str, surface: Surface, *, mirrored: bool = False) -> str:
    """The file of one surface: equal surfaces give equal text.

    Args:
        name: name of the object in the file.
        surface: the triangles.
        mirrored: write the mirror image, y negated and every face the other way round.
    """
    flip = np.array([1.0, -1.0 if mirrored else 1.0, 1.0])
    lines = ["# nao_kin: generated by scripts/generate_meshes.py", f"o {name}"]
    lines += ["v " + " ".join(_short(value / 1000, 5) for value in vertex) for vertex in surface.vertices * flip]
    lines += [
        "vn " + " ".join(_short(value, _DECIMALS_NORMAL) for value in normal) for normal in surface.normals * flip
    ]
    for face in _faces(surface):
        lines.append("f " + " ".join(f"{v + 1}//{n + 1}" for v, n in (face[::-1] if mirrored else face)))
    return "\n".join(lines) + "\n"


def _faces(surface: Surface) -> Iterator[list[Corner]]:
    """Return nearly flat pairs of triangles as faces with four corners, which saves a quarter of the text.

    The pairs with the longest edges are joined first, because those edges are the diagonals of the original
    quadrilaterals.
    """
    faces = [
        [(int(v), int(n)) for v, n in zip(triangle, corners, strict=True)]
        for triangle, corners in zip(surface.triangles, surface.corners, strict=True)
    ]
    edges: dict[tuple[Corner, Corner], tuple[int, int]] = {}
    for index, face in enumerate(faces):
        for k in range(3):
            edges[face[k], face[(k + 1) % 3]] = (index, k)
    pairs = []
    for (a, b), (index, k) in edges.items():
        if (b, a) in edges and a < b:
            other, m = edges[b, a]
            length = float(np.linalg.norm(surface.vertices[a[0]] - surface.vertices[b[0]]))
            pairs.append((-round(length, 3), index, k, other, m))
    free = [True] * len(faces)
    joined: dict[int, list[Corner]] = {}
    for _, index, k, other, m in sorted(pairs):
        if free[index] and free[other]:
            face = [faces[index][k], faces[other][(m + 2) % 3], faces[index][(k + 1) % 3], faces[index][(k + 2) % 3]]
            if _flat_and_convex(surface.vertices[[v for v, _ in face]]):
                free[index] = free[other] = False
                joined[index] = face
    for index, face in enumerate(faces):
        if index in joined:
            yield joined[index]
        elif free[index]:
            yield face


def _flat_and_convex(corners: Floats) -> bool:
    """Return whether the normals at the four corners of a face have nearly the same direction."""
    ahead = np.roll(corners, -1, axis=0) - corners
    turns = np.cross(np.roll(ahead, 1, axis=0), ahead)
    lengths = np.linalg.norm(turns, axis=1)
    if lengths.min() < 1e-3:
        return False
    turns /= lengths[:, None]
    return bool((turns @ turns.T).min() > 0.98)


def _short(value: float, decimals: int) -> str:
    text = f"{value:.{decimals}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text
