"""The meshes of the links, which tell whether two links touch whose hulls overlap."""

from __future__ import annotations

from collections import defaultdict
from copy import copy
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import coal
import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin.robot.geometry import shape_geometry
from nao_kin.robot.urdf import Collision, Packages, UnreadableShape, Visual

if TYPE_CHECKING:
    from nao_kin.robot.collision_pairs import LinkPair
    from nao_kin.robot.collisions import Obstacle
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
        self._standing = dict[str, Floats]()

    def among(self, obstacles: tuple[Obstacle, ...]) -> LinkMeshes:
        """Return these meshes among obstacles."""
        made = copy(self)
        made._standing = {obstacle.name: obstacle.T for obstacle in obstacles}
        geometries = {obstacle.name: shape_geometry(obstacle.geometry, Packages(Path())) for obstacle in obstacles}
        made._own = self._own | {name: [(name, geometry, np.eye(4))] for name, geometry in geometries.items()}
        return made

    def _add(self, link: str, links: tuple[str, ...], parents: dict[str, str], geometry: Any, T: Floats) -> None:
        owner: str | None = link
        while owner is not None and owner not in links:
            owner = parents.get(owner)
        if owner is not None:
            self._own[owner].append((link, geometry, T))

    def poses(self, q: Floats) -> dict[str, Floats]:
        """Return the poses of the links with shapes and of the obstacles, shape (..., 4, 4) each."""
        poses = dict(zip(self.links, np.moveaxis(self._robot.fk(q, self.links), -3, 0), strict=True))
        return poses | {name: np.broadcast_to(T, (*q.shape[:-1], 4, 4)) for name, T in self._standing.items()}

    def _pairs(self, pair: LinkPair, poses: dict[str, Floats]) -> list[Any]:
        ours, others = (
            [(geometry, _transform(poses[link] @ T)) for link, geometry, T in self._own[owner]] for owner in pair
        )
        return list(product(ours, others))

    def touch(self, pair: LinkPair, poses: dict[str, Floats]) -> bool:
        """Return whether the shapes of two links touch; so they do if one has none."""
        pairs = self._pairs(pair, poses)
        return not pairs or any(_touch(*one, *other) for one, other in pairs)

    def nearest(self, pair: LinkPair, poses: dict[str, Floats]) -> Any:
        """Return coal's distance of the shapes of two links that do not touch."""
        pairs = self._pairs(pair, poses)
        results = [coal.DistanceResult() for _ in pairs]
        for (one, other), result in zip(pairs, results, strict=True):
            coal.distance(*one, *other, coal.DistanceRequest(), result)
        return min(results, key=lambda result: result.min_distance)


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
