"""Closed solids in millimetres: balls, rods, lathed profiles, rounded boxes, and the cuts between them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np
from manifold3d import CrossSection, JoinType, Manifold, Mesh
from numpy.typing import ArrayLike, NDArray

Point = tuple[float, float, float]
Profile = Sequence[tuple[float, float]]
# A part of the robot: colour name of `NaoParameters.colours` → solid, in the frame of the link.
Part = dict[str, Manifold]

X: Point = (1.0, 0.0, 0.0)
Y: Point = (0.0, 1.0, 0.0)
Z: Point = (0.0, 0.0, 1.0)

# Larger than any part, so that cuts are complete.
FAR = 400.0


def from_triangles(vertices: ArrayLike, triangles: ArrayLike) -> Manifold:
    """Return the solid bounded by closed, outward triangles."""
    return Manifold(Mesh(np.ascontiguousarray(vertices, np.float32), np.ascontiguousarray(triangles, np.uint32)))


def lathe(profile: Profile, segments: int = 20) -> Manifold:
    """The solid that a closed profile of (radius, height) points sweeps about the z axis."""
    return _outline(np.array(profile, dtype=float)).revolve(segments)


def ball(radius: float, at: Point = (0.0, 0.0, 0.0), segments: int = 20) -> Manifold:
    """A sphere as a lathed half circle: its poles lie on z."""
    steps = segments // 2
    arc = [(radius * math.sin(math.pi * i / steps), -radius * math.cos(math.pi * i / steps)) for i in range(steps + 1)]
    arc[0], arc[-1] = (0.0, -radius), (0.0, radius)
    return lathe(arc, segments).translate(at)


def rod(start: Point, end: Point, radius: float, edge: float = 2.0, segments: int = 20) -> Manifold:
    """A cylinder from start to end, its rims rounded with radius `edge`; with edge = radius it is a capsule."""
    (a, b, c), (x, y, z) = start, end
    return place(lathe(pill(radius, math.dist(start, end), edge, edge), segments), start, (x - a, y - b, z - c))


def pill(radius: float, length: float, low_edge: float = 0.0, high_edge: float = 0.0, steps: int = 2) -> Profile:
    """Profile of a cylinder from height 0 to `length` with rounded rims, for `lathe`."""
    low, high = _rim(radius, low_edge, steps), _rim(radius, high_edge, steps)
    upper = [(r, length - h) for r, h in reversed(high)]
    return [(0.0, 0.0), *low, *upper, (0.0, length)]


def _rim(radius: float, edge: float, steps: int) -> list[tuple[float, float]]:
    """A quarter circle from the flat end of a cylinder to its side."""
    if edge == 0.0:
        return [(radius, 0.0)]
    angles = [math.pi / 2 * i / steps for i in range(steps + 1)]
    return [(radius - edge * (1 - math.sin(a)), edge * (1 - math.cos(a))) for a in angles]


def box(low: Point, high: Point, edge: float = 0.0, steps: int = 3) -> Manifold:
    """A box between two corners, its edges and corners rounded with radius `edge`."""
    if edge == 0.0:
        size = tuple(b - a for a, b in zip(low, high, strict=True))
        return Manifold.cube(size).translate(low)
    corners = [
        ball(edge, (x, y, z), 4 * steps)
        for x in (low[0] + edge, high[0] - edge)
        for y in (low[1] + edge, high[1] - edge)
        for z in (low[2] + edge, high[2] - edge)
    ]
    return Manifold.batch_hull(corners)


def prism(outline: Sequence[tuple[float, float]], low: float, high: float, corner: float = 0.0) -> Manifold:
    """A polygon in the x-z plane, its corners rounded with radius `corner`, extruded along y from low to high."""
    section = _outline(np.array([(x, -z) for x, z in outline], dtype=float))
    if corner:
        shrunk = section.offset(-corner, JoinType.Miter)
        section = shrunk.offset(corner, JoinType.Round, circular_segments=16)
    # Turned by -90° about x, (x, y, z) goes to (x, z, -y).
    return section.extrude(high - low).rotate((-90.0, 0.0, 0.0)).translate((0.0, low, 0.0))


def _outline(points: NDArray[np.float64]) -> CrossSection:
    """Return a polygon with its inside on the left, for any order of its points."""
    x, y = points.T
    area = x @ np.roll(y, -1) - y @ np.roll(x, -1)
    return CrossSection([points if area > 0 else points[::-1]])


def place(solid: Manifold, at: Point, towards: Point = Z) -> Manifold:
    """Turn the z axis of a solid towards a direction and move its origin to a point."""
    w = np.array(towards, dtype=float) / math.hypot(*towards)
    # The direction of x and y does not matter for lathed solids; for the others, y remains level if possible.
    v = np.cross(w, X if abs(w[2]) > 0.9 else Z)
    v /= math.hypot(*v)
    return solid.transform(np.column_stack([np.cross(v, w), v, w, np.array(at, dtype=float)]))


def slab(normal: Point, low: float, high: float) -> Manifold:
    """All points p with low ≤ normal · p ≤ high."""
    flat = Manifold.cube((2 * FAR, 2 * FAR, high - low)).translate((-FAR, -FAR, low))
    return place(flat, (0.0, 0.0, 0.0), normal)


def union(solids: Iterable[Manifold]) -> Manifold:
    """All of the solids as one."""
    return sum(solids, Manifold())


def both(solid: Manifold) -> Manifold:
    """A solid on the left and its mirror image on the right: y becomes -y."""
    return solid + solid.mirror(Y)
