"""The meshes of the links, which tell whether two links touch whose hulls overlap."""

from __future__ import annotations

from collections import defaultdict
from itertools import product
from typing import TYPE_CHECKING, Any

import coal
import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin.robot.geometry import shape_geometry
from nao_kin.robot.urdf import Collision, UnreadableShape, Visual

if TYPE_CHECKING:
    from nao_kin.robot.collision_pairs import LinkPair
    from nao_kin.robot.model import RobotModel


class LinkMeshes:
    """The shapes of a robot as they are: triangles of meshes, balls, boxes and cylinders.

    A shape of a link without a hull, as of a finger, belongs to the next link towards the root that has one.
    """

    def __init__(self, robot: RobotModel, links: tuple[str, ...], rows: tuple[Visual | Collision, ...]) -> None:
        self._robot, parents = robot, {joint.child: joint.parent for joint in robot.tree.joints}
        self._own: dict[str, list[tuple[str, Any, Floats]]] = defaultdict(list)
        meshes: dict[str, list[tuple[Any, Floats]]] = defaultdict(list)
        for row in rows:
            try:
                geometry = shape_geometry(row.geometry, robot.tree.packages)
            except UnreadableShape:
                continue
            if isinstance(geometry, coal.BVHModelBase):
                meshes[row.link].append((geometry, row.origin.matrix))
            else:
                self._add(row.link, links, parents, geometry, row.origin.matrix)
        for link, parts in meshes.items():
            self._add(link, links, parents, _joined(parts), np.eye(4))
        self.links = tuple(dict.fromkeys(link for shapes in self._own.values() for link, _, _ in shapes))

    def _add(self, link: str, links: tuple[str, ...], parents: dict[str, str], geometry: Any, T: Floats) -> None:
        owner: str | None = link
        while owner is not None and owner not in links:
            owner = parents.get(owner)
        if owner is not None:
            self._own[owner].append((link, geometry, T))

    def poses(self, q: Floats) -> dict[str, Floats]:
        """Return the poses of the links with shapes in one configuration."""
        return dict(zip(self.links, self._robot.fk(q, self.links), strict=True))

    def nearest(self, pair: LinkPair, poses: dict[str, Floats]) -> Any:
        """Return coal's distance of the shapes of two links; None if they touch, or if one has none."""
        ours, others = (
            [(geometry, _transform(poses[link] @ T)) for link, geometry, T in self._own[owner]] for owner in pair
        )
        pairs = list(product(ours, others))
        if any(_touch(*one, *other) for one, other in pairs):
            return None
        results = [coal.DistanceResult() for _ in pairs]
        for (one, other), result in zip(pairs, results, strict=True):
            coal.distance(*one, *other, coal.DistanceRequest(), result)
        return min(results, key=lambda result: result.min_distance, default=None)


def _touch(first: Any, T_first: Any, second: Any, T_second: Any) -> bool:
    return bool(coal.collide(first, T_first, second, T_second, coal.CollisionRequest(), coal.CollisionResult()))


def _transform(T: Floats) -> Any:
    return coal.Transform3s(T[:3, :3], T[:3, 3])


def _joined(parts: list[tuple[Any, Floats]]) -> Any:
    """Return one mesh of several, each at a pose in the link."""
    joined = coal.BVHModelOBBRSS()
    joined.beginModel(0, 0)
    for mesh, T in parts:
        points, triangles = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
        for point in np.asarray(mesh.vertices()) @ T[:3, :3].T + T[:3, 3]:
            points.append(point)
        for k in range(mesh.num_tris):
            triangles.append(mesh.tri_indices(k))
        joined.addSubModel(points, triangles)
    joined.endModel()
    return joined
