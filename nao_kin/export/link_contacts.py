"""Which links of a robot touch each other, found by trying many configurations with the collision library coal."""

from __future__ import annotations

import functools
from collections import defaultdict
from collections.abc import Iterator
from itertools import combinations
from typing import Any

import coal
import numpy as np
from numpy.typing import NDArray

from nao_kin._common.arrays import Floats
from nao_kin._text import abbreviated
from nao_kin.export.variants.placement import transform
from nao_kin.robot import RobotModel, UnreadableShape, shape_geometry

# By how much boxes around shapes are larger than them [m]: coal takes shapes within its tolerance for touching.
_MARGIN = 1e-5
# So few configurations at once are posed by Pinocchio: no kernel has to be compiled for them.
_POSED_AT_ONCE = 50
# How many planes between two meshes are tried, and in how few configurations it is not worth while.
_PLANES, _FEW = 8, 4
_DISTANCE = coal.DistanceRequest()
# Two names, the one that comes first in the alphabet first.
LinkPair = tuple[str, str]


class LinkContacts:
    """The collision shapes of a robot, ready to be held against each other.

    Attributes:
        links: the links that have shapes, in the order of the URDF.
        notes: one line for each shape that cannot be read.
    """

    def __init__(self, robot: RobotModel) -> None:
        self._robot, tree = robot, robot.tree
        self.notes: list[str] = []
        self._shapes: dict[str, list[int]] = defaultdict(list)
        self._geometries: list[Any] = []
        owners, placements = [], []
        packages = tree.packages
        for collision in tree.collisions:
            try:
                geometry = shape_geometry(collision.geometry, packages)
            except UnreadableShape as reason:
                self.notes.append(f"a collision shape of {abbreviated(collision.link)} is left out: {reason}")
                continue
            geometry.computeLocalAABB()
            self._shapes[collision.link].append(len(self._geometries))
            self._geometries.append(geometry)
            owners.append(collision.link)
            placements.append(transform(collision.origin))
        self.links = tuple(link for link in tree.links if link in self._shapes)
        self._columns = [self.links.index(link) for link in owners]
        self._T_link_shape = np.array(placements).reshape(-1, 4, 4)
        self._centres = np.array([[*shape.aabb_center, 1.0] for shape in self._geometries]).reshape(-1, 4, 1)
        self._radii = np.array([shape.aabb_radius for shape in self._geometries])
        boxes = [shape.aabb_local for shape in self._geometries]
        self._hulls = [_hull(shape) for shape in self._geometries]
        self._corners = [
            None if hull is shape else np.array(hull.points())
            for hull, shape in zip(self._hulls, self._geometries, strict=True)
        ]
        self._halves = np.array([(box.max_ - box.min_) / 2.0 for box in boxes]).reshape(-1, 3) + _MARGIN

    def pairs(self) -> Iterator[LinkPair]:
        """Every two links that have shapes."""
        yield from combinations(sorted(self.links), 2)

    def count(self, q: Floats, pairs: set[LinkPair], *, most: int | None = None) -> dict[LinkPair, int]:
        """In how many of several configurations the links of each pair touch.

        Args:
            q: configurations, shape (n, nq).
            pairs: the pairs to look at.
            most: stop looking at a pair after so many.
        """
        counts = dict.fromkeys(sorted(pairs), 0)
        both = [(pair, a, b) for pair in counts for a in self._shapes[pair[0]] for b in self._shapes[pair[1]]]
        if not both or not len(q):
            return counts
        parts = [q[start : start + _POSED_AT_ONCE] for start in range(0, len(q), _POSED_AT_ONCE)]
        T_root_link = np.concatenate([self._robot.fk(part, list(self.links)) for part in parts])
        T_root_shape = T_root_link[:, self._columns] @ self._T_link_shape
        place = functools.cache(lambda sample, shape: _transform(T_root_shape[sample, shape]))
        seen: set[tuple[LinkPair, int]] = set()
        for index, samples in self._near(T_root_shape, np.array([row[1:] for row in both]).T):
            pair, a, b = both[index]
            if most is not None and counts[pair] >= most:
                continue
            for sample in samples[~self._apart(a, b, T_root_shape[samples])].tolist():
                if (most is not None and counts[pair] >= most) or (pair, sample) in seen:
                    continue
                if self._touch(a, place(sample, a), b, place(sample, b)):
                    seen.add((pair, sample))
                    counts[pair] += 1
        return counts

    def _near(self, T_root_shape: Floats, shapes: NDArray[np.intp]) -> Iterator[tuple[int, NDArray[np.intp]]]:
        """Yield the pairs of shapes that need a closer look, each as its place in `shapes` with its configurations.

        Two shapes are apart where the spheres around them are, or their boxes when seen along an edge of one of them.
        """
        a, b = shapes
        centres = (T_root_shape @ self._centres)[..., :3, 0]
        gaps = np.linalg.norm(centres[:, a] - centres[:, b], axis=-1) - self._radii[a] - self._radii[b]
        pair, sample = np.nonzero(gaps.T <= 0.0)
        a, b = a[pair], b[pair]
        R_root_a, R_root_b = T_root_shape[sample, a, :3, :3], T_root_shape[sample, b, :3, :3]
        R_ab = R_root_a.transpose(0, 2, 1) @ R_root_b
        between = (centres[sample, b] - centres[sample, a])[:, None, :]
        along_a, along_b = np.abs(between @ R_root_a)[:, 0], np.abs(between @ R_root_b)[:, 0]
        reach = np.abs(R_ab)
        is_near = (along_a <= self._halves[a] + np.einsum("nij,nj->ni", reach, self._halves[b])).all(axis=1)
        is_near &= (along_b <= self._halves[b] + np.einsum("nij,ni->nj", reach, self._halves[a])).all(axis=1)
        pair, sample = pair[is_near], sample[is_near]
        starts = np.flatnonzero(np.diff(pair, prepend=-1))
        yield from zip(pair[starts].tolist(), np.split(sample, starts)[1:], strict=True)

    def _apart(self, a: int, b: int, T_root_shape: Floats) -> NDArray[np.bool_]:
        """Find the configurations in which a plane separates two meshes; in the others they may touch or not.

        The plane between the two hulls in one configuration, held to the first mesh, often separates them in many.
        """
        apart, tried = np.zeros(len(T_root_shape), bool), np.zeros(len(T_root_shape), bool)
        corners_a, corners_b = self._corners[a], self._corners[b]
        if corners_a is None or corners_b is None or len(apart) < _FEW:
            return apart
        T_root_a, T_root_b = T_root_shape[:, a], T_root_shape[:, b]
        for _ in range(_PLANES):
            sample = int(np.argmin(apart | tried))
            if apart[sample] or tried[sample]:
                break
            tried[sample] = True
            result = coal.DistanceResult()
            places = _transform(T_root_a[sample]), _transform(T_root_b[sample])
            if coal.distance(self._hulls[a], places[0], self._hulls[b], places[1], _DISTANCE, result) <= _MARGIN:
                continue
            normal = T_root_a[sample, :3, :3].T @ (result.getNearestPoint2() - result.getNearestPoint1())
            normal /= np.linalg.norm(normal)
            normals = T_root_a[:, :3, :3] @ normal  # the plane's normal in the root's frame, shape (n, 3)
            origins = ((T_root_b - T_root_a)[:, :3, 3] * normals).sum(axis=1)
            lowest = ((normals[:, None] @ T_root_b[:, :3, :3])[:, 0] @ corners_b.T).min(axis=1) + origins
            apart |= lowest > (corners_a @ normal).max() + _MARGIN
        return apart

    def _touch(self, a: int, place_a: Any, b: int, place_b: Any) -> bool:
        """Whether two shapes touch: not where their convex hulls are apart, which is found much sooner."""
        return _collide(self._hulls[a], place_a, self._hulls[b], place_b) and (
            (self._hulls[a] is self._geometries[a] and self._hulls[b] is self._geometries[b])
            or _collide(self._geometries[a], place_a, self._geometries[b], place_b)
        )


def _transform(T: Floats) -> Any:
    return coal.Transform3s(T[:3, :3], T[:3, 3])


def _collide(a: Any, place_a: Any, b: Any, place_b: Any) -> bool:
    return bool(coal.collide(a, place_a, b, place_b, coal.CollisionRequest(), coal.CollisionResult()))


def _hull(shape: Any) -> Any:
    """Return the convex hull of a mesh, or the shape itself where it is no mesh or has no hull, as a flat one."""
    try:
        shape.buildConvexHull(True, "Qt")
        hull = shape.convex
        hull.computeLocalAABB()
    except (AttributeError, RuntimeError, ValueError):
        return shape
    return hull
