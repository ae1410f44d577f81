"""Which links of a robot touch each other, found by trying many configurations with the collision library coal."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from itertools import combinations
from typing import Any

import coal
import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin._text import abbreviated
from nao_kin.export.variants.placement import transform
from nao_kin.robot import RobotModel, UnreadableShape, shape_geometry

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
        if not pairs or not len(q):
            return dict.fromkeys(pairs, 0)
        T_root_link = self._robot.fk(q, list(self.links))
        T_root_shape = T_root_link[:, self._columns] @ self._T_link_shape
        spheres = (T_root_shape @ self._centres)[..., :3, 0]
        return {pair: self._count(pair, T_root_shape, spheres, most) for pair in sorted(pairs)}

    def _count(self, pair: LinkPair, T_root_shape: Floats, spheres: Floats, most: int | None) -> int:
        touching: set[int] = set()
        for a in self._shapes[pair[0]]:
            for b in self._shapes[pair[1]]:
                # Shapes whose bounding spheres are apart are apart: most of them need no closer look.
                gaps = np.linalg.norm(spheres[:, a] - spheres[:, b], axis=-1) - self._radii[a] - self._radii[b]
                for sample in np.flatnonzero(gaps <= 0.0).tolist():
                    if most is not None and len(touching) >= most:
                        return len(touching)
                    if sample not in touching and self._touch(a, b, T_root_shape[sample]):
                        touching.add(sample)
        return len(touching)

    def _touch(self, a: int, b: int, T_root_shape: Floats) -> bool:
        request, result = coal.CollisionRequest(), coal.CollisionResult()
        T_a, T_b = (coal.Transform3s(T[:3, :3], T[:3, 3]) for T in (T_root_shape[a], T_root_shape[b]))
        return bool(coal.collide(self._geometries[a], T_a, self._geometries[b], T_b, request, result))
