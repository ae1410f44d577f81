"""The distances between the shapes of the links, as convex hulls and as the meshes that they contain.

Distances are negative where shapes overlap: the least translation that separates them.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from copy import copy
from dataclasses import replace
from functools import cached_property
from itertools import combinations, product
from pathlib import Path
from typing import Any

import coal
import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import CROSSOVER, Floats, generator
from nao_kin._core.text import abbreviated, quoted
from nao_kin._kernels.cache import may_compile
from nao_kin._kernels.hulls import HullTable, clearances, segments_squared
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.robot.collision_pairs import ALWAYS, DEFAULT, Capsules, LinkPair, disabled_collisions
from nao_kin.robot.collisions import Clearance, CollisionRule, Contact, Obstacle
from nao_kin.robot.geometry import (
    Shape,
    covering_capsule,
    exact_shape,
    hull_corners,
    hull_shape,
    link_shapes_of,
    round_shape,
    shape_geometry,
)
from nao_kin.robot.joint_arrays import ROOT
from nao_kin.robot.kinematic_robot import KinematicRobot
from nao_kin.robot.urdf import Collision, MeshFile, Packages, Sphere, UnreadableShape, Visual

# Random configurations, and boxes in a proof, that sort the pairs of a robot whose semantics do not.
_SAMPLES = 1000
_CHUNK = 4096
# Configurations whose pairs are tested for nearness at once.
_FEW = 64
# Shapes at this distance may touch: coal reports shapes within its tolerance as touching [m].
_TOUCHING = 1e-5
# Overlaps that differ by less are equal: coal and the kernel find them to some tolerance [m].
_SAME = 1e-5
# Overlap of hulls up to which meshes decide by default [m]: hardly any deeper overlap of the NAO's hulls is a false
# alarm, and a comparison of meshes takes as long as ten of hulls.
_SHALLOW = 0.003
# Least and largest number of random configurations drawn at a time, and drawn without success before giving up.
_DRAWN, _MOST_AT_ONCE, _MOST_DRAWN = 256, 4096, 100_000
_SIGNED = coal.DistanceRequest()
_SIGNED.enable_signed_distance = True
_SIGNED.gjk_tolerance = _SIGNED.epa_tolerance = 1e-10


def _obstacle_shape(obstacle: Obstacle) -> Shape:
    if isinstance(obstacle.geometry, Sphere):
        return round_shape(obstacle.name, np.zeros((2, 3)), obstacle.geometry.radius)
    return hull_shape(obstacle.name, hull_corners(obstacle.geometry, Packages(Path())))


class LinkShapes:
    """The shapes of a robot's links, in the links' order, and the distances between the `pairs` that are checked."""

    def __init__(
        self,
        robot: KinematicRobot,
        shapes: Iterable[Shape],
        meshes: tuple[Visual | Collision, ...] = (),  # the shapes that the hulls contain
        disabled: dict[LinkPair, str] | None = None,  # the other pairs, and the reason
        obstacles: tuple[Obstacle, ...] = (),
    ) -> None:
        self._robot, self._meshes, self.notes = robot, meshes, list[str]()
        own = list(shapes)
        if disabled is None and not own:
            raise BadArgument(f"{robot.name} has no shapes: its links have neither collisions nor visuals")
        self.links = tuple(link for link in robot.link_names if any(shape.link == link for shape in own))
        own.sort(key=lambda shape: self.links.index(shape.link))
        self.obstacles, names = obstacles, [obstacle.name for obstacle in obstacles]
        self.shapes = (*own, *map(_obstacle_shape, obstacles))
        parts = [part for shape in self.shapes for part in shape.parts]
        self._all, self._posed = (*self.shapes, *parts), (*self.links, *dict.fromkeys(part.link for part in parts))
        self._standing = np.array([obstacle.T for obstacle in obstacles]).reshape(-1, 4, 4)
        place = {name: index for index, name in enumerate((*self._posed, *names))}
        link = np.array([place[shape.link] for shape in self._all], dtype=np.int64)
        first = np.cumsum([0, *(len(shape.points) for shape in self._all)])
        radius = np.array([shape.radius for shape in self._all])
        around = [covering_capsule(shape.points) for shape in self._all]
        ends = np.array([ends for ends, _ in around]).reshape(-1, 6)
        width = radius + np.array([width for _, width in around])
        points = np.concatenate([*(shape.points for shape in self._all), np.empty((0, 3))])
        behind = len(self.shapes) + np.cumsum([0, *(len(shape.parts) for shape in self.shapes)])
        self._counting = [
            range(behind[s], behind[s + 1]) if shape.parts else range(s, s + 1) for s, shape in enumerate(self._all)
        ]
        ranges = np.array([(own.start, own.stop) for own in self._counting]).reshape(-1, 2)
        self._table = HullTable(link, first, points, radius, ends, width, ranges)
        self.capsules: Capsules = {link: [] for link in (*self.links, *names)}
        for shape, segment, size in zip(self.shapes, ends, width.tolist(), strict=False):
            self.capsules[shape.link].append((segment.reshape(2, 3), size))
        self.pairs: tuple[LinkPair, ...] = tuple(combinations(sorted(self.links), 2))
        self.disabled = self._disabled() if disabled is None else disabled
        self.pairs = tuple(pair for pair in self.pairs if pair not in self.disabled)
        self.pairs += tuple((min(pair), max(pair)) for pair in product(self.links, names))
        self._places, self._owner = self._pairs_of_shapes(self.pairs)
        self._some: dict[Any, NDArray[np.bool_]] = {}  # by the columns of q, or the pairs that are allowed
        self._last: LinkShapes | None = None  # these shapes among the obstacles of the last question
        self._alone = self  # these shapes without obstacles

    def among(self, obstacles: Sequence[Obstacle]) -> LinkShapes:
        """Return the shapes of a robot alone among obstacles; they share its meshes."""
        wanted = tuple(obstacles)
        if wanted == self.obstacles:
            return self
        if self._last is None or self._last.obstacles != wanted:
            names = [obstacle.name for obstacle in wanted]
            for name in names:
                if name in self._robot.tree.links or names.count(name) > 1:
                    raise BadArgument(f"the name of obstacle {quoted(name)} is that of a link or of another obstacle")
            self._last = LinkShapes(self._robot, self.shapes, (), self.disabled, wanted)
            self._last._alone, self._last.notes = self, self.notes
        return self._last

    @property
    def hulls(self) -> tuple[tuple[str, ...], HullTable, NDArray[np.int64]]:
        """The links that the hulls of the table refer to, the table, and the pairs of hulls checked, shape (p, 2)."""
        return self._posed, self._table, self._places

    def _poses(self, q: Floats) -> Floats:
        """Return the poses of links, parts and obstacles, shape (n, links, 4, 4), in the frame of `RobotModel.fk`."""
        T = self._robot.fk(q, self._posed)
        if not self.obstacles:
            return np.ascontiguousarray(T)
        return np.concatenate([T, np.broadcast_to(self._standing, (len(q), *self._standing.shape))], axis=1)

    @classmethod
    def exact(cls, robot: KinematicRobot) -> LinkShapes:
        """Return the collision elements as they are, for tests of contact; `notes` says which are left out."""
        notes: list[str] = []
        made = cls(robot, list(link_shapes_of(robot.tree.collisions, robot.tree, exact_shape, notes)), disabled={})
        made.notes = notes
        return made

    def _disabled(self) -> dict[LinkPair, str]:
        rows = self._robot.semantics.disabled_collisions
        for name in (name for row in rows for name in row[:2]):
            if name not in self._robot.tree.links:
                raise UnknownName("link in disabled_collisions", name, self._robot.tree.links)
        if rows:
            return {(min(a, b), max(a, b)): reason for a, b, reason in rows}
        found = self.found_disabled(_SAMPLES, 0)
        touching = [f"{a} and {b}" for (a, b), reason in found.items() if reason in (DEFAULT, ALWAYS)]
        if touching:
            self.notes.append(
                f"{len(touching)} pairs of links are not checked, because their shapes touch in the start posture or "
                f"always: {abbreviated(', '.join(touching), 200)}; an SRDF says which pairs to check"
            )
        return found

    def found_disabled(self, samples: int, seed: int) -> dict[LinkPair, str]:
        """Return the pairs of links that need no check, and the reason, by the rules of `disabled_collisions`."""
        return disabled_collisions(self._robot, self.pairs, self.capsules, self.count, samples=samples, seed=seed)

    def _pairs_of_shapes(self, pairs: Iterable[LinkPair]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return the pairs of shapes of pairs of links, shape (p, 2), and the index of the pair of links of each."""
        of_link = defaultdict(list)
        for place, shape in enumerate(self.shapes):
            of_link[shape.link].append(place)
        rows = [(a, b, owner) for owner, pair in enumerate(pairs) for a in of_link[pair[0]] for b in of_link[pair[1]]]
        table = np.array(rows, dtype=np.int64).reshape(-1, 3)
        return np.ascontiguousarray(table[:, :2]), table[:, 2]

    @cached_property
    def meshes(self) -> LinkMeshes:
        """The meshes of the links and of the obstacles; those of the links are read once."""
        if self.obstacles:
            return self._alone.meshes.among(self.obstacles)
        return LinkMeshes(self._robot, self.links, self._meshes)

    @cached_property
    def _shallow(self) -> Floats:
        """Overlaps of hulls up to which the meshes decide by default, shape (pairs,) [m]; zero without meshes.

        They are less than the thickness of both shapes: a mesh inside another one, which touches nothing, is deeper.
        The extent along a principal axis is at most √3 times the thickness of a cube, whose axes are undetermined.
        """
        if not any(isinstance(row.geometry, MeshFile) for row in self._alone._meshes):
            return np.zeros(len(self.pairs))
        thickness = np.array([2.0 * shape.radius + 0.5 * _least_extent(shape.points) for shape in self._all])
        thinnest = np.array([thickness[own.start : own.stop].min() for own in self._counting])
        shallow = np.full(len(self.pairs), _SHALLOW)
        np.minimum.at(shallow, self._owner, thinnest[self._places].min(axis=1))
        return shallow

    def _decided_by_meshes(self, exact: bool | None) -> Floats:
        """Return up to which overlap of their hulls the meshes of each pair decide, shape (pairs,) [m]."""
        return self._shallow if exact is None else np.full(len(self.pairs), np.inf if exact else 0.0)

    def allowed(self, rule: CollisionRule) -> NDArray[np.bool_]:
        """Return which pairs a rule allows to overlap, shape (pairs,)."""
        if not rule.allowed:
            return np.zeros(len(self.pairs), dtype=np.bool_)
        if rule.allowed not in self._some:
            for name in (name for pair in rule.allowed for name in pair):
                if name not in self._robot.tree.links and all(name != obstacle.name for obstacle in self.obstacles):
                    raise UnknownName("link", name, self.links)
            self._some[rule.allowed] = np.array([pair in rule.allowed for pair in self.pairs], dtype=np.bool_)
        return self._some[rule.allowed]

    def moved(self, columns: Sequence[int]) -> NDArray[np.bool_]:
        """Return which pairs the coordinates in these columns of q move relative to each other, shape (pairs,)."""
        key = tuple(sorted(columns))
        if key not in self._some:
            model, joints = self._robot.model, self._robot.joints
            rows = {name: row for row, name in enumerate(joints.names)}
            bodies = (model.names[model.frames[i].parentJoint] for i in self._robot.frame_ids(self.links))
            of_link = dict(zip(self.links, (rows.get(name, ROOT) for name in bodies), strict=True))
            paths = (joints.paths(of_link.get(a, ROOT), of_link.get(b, ROOT)) for a, b in self.pairs)
            moved = [not {*joints.coordinates[[*one, *other]].tolist()}.isdisjoint(key) for one, other in paths]
            if key and key[0] < self._robot.nq_base:  # the base moves all links past the obstacles
                moved = [known or not {*pair} <= {*self.links} for known, pair in zip(moved, self.pairs, strict=True)]
            self._some[key] = np.array(moved, dtype=np.bool_)
        return self._some[key]

    def clearance(
        self,
        q: Floats,
        below: float = np.inf,
        *,
        tolerance: float = 0.0,
        checked: NDArray[np.bool_] | None = None,
        exact: bool | None = False,
    ) -> Clearance:
        """Return the clearance of configurations (..., nq); a distance of `below` or more is `below`, of no pair.

        `checked` is which pairs are checked, shape (pairs,); None for all. `exact` is that of a `CollisionRule`.
        """
        rows, places, owner = q.reshape(-1, q.shape[-1]), self._places, self._owner
        if checked is not None and not checked.all():
            own = checked[owner]
            places, owner = places[own], owner[own]
        gaps, which = np.full(len(rows), below), np.full(len(rows), -1, dtype=np.int64)
        compiled = clearances.in_memory or (len(rows) >= CROSSOVER and may_compile())
        for start in range(0, len(rows) if len(places) else 0, _CHUNK):
            part = slice(start, start + _CHUNK)
            if compiled:
                clearances(self._poses(rows[part]), self._table, places, float(below), gaps[part], which[part])
            else:
                self._by_coal(rows[part], places, gaps[part], which[part])
        which = np.where(which >= 0, owner[which], -1) if len(places) else which
        if exact is not False:
            self._by_meshes(rows, below, checked, exact, gaps, which)
        shape = q.shape[:-1]
        return Clearance(gaps.reshape(shape), which.reshape(shape), self.pairs, tolerance, tuple(self.notes))

    def _by_meshes(
        self,
        q: Floats,
        below: float,
        checked: NDArray[np.bool_] | None,
        exact: bool | None,
        gaps: Floats,
        which: NDArray[np.int64],
    ) -> None:
        """Let the meshes decide where hulls overlap; if they are apart, the next pair may be nearer."""
        rows = np.flatnonzero((gaps < 0.0) & (which >= 0))
        rows = rows[gaps[rows] > -self._decided_by_meshes(exact)[which[rows]]]
        if not len(rows):
            return
        poses, apart = self.meshes.poses(q[rows]), defaultdict[int, dict[int, float]](dict)
        for row, k in enumerate(rows.tolist()):
            if (found := self.meshes.apart(self.pairs[which[k]], poses, row)) is not None:
                apart[int(which[k])][k] = found.min_distance
        for pair, distances in apart.items():
            own, distance = list(distances), np.array(list(distances.values()))
            rest = np.ones(len(self.pairs), dtype=np.bool_) if checked is None else checked.copy()
            rest[pair] = False
            other = self.clearance(q[own], below, checked=rest, exact=exact)
            which[own] = np.where(distance < other.distance, pair, other.pair_index)
            gaps[own] = np.minimum(distance, other.distance)

    def clearance_from(self, q: Floats, near: Floats, rule: CollisionRule, columns: Sequence[int]) -> Clearance:
        """Return the clearance of configurations whose columns of q were found by a solver, over the pairs they move.

        Pairs that overlap in `near`, which broadcasts with q, count only where they overlap more.
        """
        if rule.obstacles != self.obstacles:
            return self.among(rule.obstacles).clearance_from(q, near, rule, columns)
        tolerance, checked = rule.tolerance, self.moved(columns) & ~self.allowed(rule)
        before = self.clearance(near, -tolerance, checked=checked, exact=rule.exact)
        if np.all(before.pair_index < 0):
            return self.clearance(q, tolerance=tolerance, checked=checked, exact=rule.exact)
        overlapping = np.zeros(len(self.pairs), dtype=np.bool_)
        rows = near[before.pair_index >= 0]
        overlapping[[owner for _, owner, _ in self.near(rows, -tolerance) if checked[owner]]] = True
        found = self.clearance(q, tolerance=tolerance, checked=checked & ~overlapping, exact=rule.exact)
        distance, pair_index = found.distance.copy(), found.pair_index.copy()
        for pair in np.flatnonzero(overlapping).tolist():
            own = np.arange(len(self.pairs)) == pair
            now, then = (self.clearance(each, checked=own, exact=rule.exact).distance for each in (q, near))
            worse = (now < np.minimum(then, -tolerance) - _SAME) & (now < distance)
            distance[worse], pair_index[worse] = now[worse], pair
        return Clearance(distance, pair_index, self.pairs, tolerance, tuple(self.notes))

    def random_free(self, rule: CollisionRule, rng: np.random.Generator | int | None, n: Any) -> Floats:
        """Return random configurations in which no links overlap; those that overlap are drawn again."""
        robot, shapes, tolerance = self._robot, self.among(rule.obstacles), rule.tolerance
        options: Any = {"tolerance": tolerance, "checked": ~shapes.allowed(rule), "exact": rule.exact}
        wanted = robot.random(rng, n)  # checks the arguments
        drawn = generator(rng)
        rows = wanted.reshape(-1, robot.nq)
        filled = vain = 0
        while filled < len(rows):
            q = robot.random(drawn, min(max(_DRAWN, len(rows) - filled), _MOST_AT_ONCE))
            q = q[shapes.clearance(q, -tolerance, **options).is_free][: len(rows) - filled]
            vain = 0 if len(q) else vain + _DRAWN
            if vain > _MOST_DRAWN:
                raise BadArgument(
                    f"{robot.name} collides in each of {vain} random configurations: are its shapes too large?"
                )
            rows[filled : filled + len(q)] = q
            filled += len(q)
        return rows.reshape(wanted.shape)

    def _by_coal(self, q: Floats, places: NDArray[np.int64], gaps: Floats, which: NDArray[np.int64]) -> None:
        for sample, T, least in self._bounds(q, places):
            for pair in np.argsort(least):
                if least[pair] >= gaps[sample]:
                    break
                gap = self._coals(T, places[pair], gaps[sample]).min_distance
                if gap < gaps[sample]:
                    gaps[sample], which[sample] = gap, pair

    def _bounds(self, q: Floats, places: NDArray[np.int64]) -> Iterator[tuple[int, Floats, Floats]]:
        """Yield index, poses of the links (links, 4, 4) and least possible distances of the pairs of shapes."""
        (a, b), width = places.T, self._table.width
        for start in range(0, len(q) if len(places) else 0, _FEW):
            T = self._poses(q[start : start + _FEW])
            placed = T[:, self._table.link]
            ends = placed[..., None, :3, :3] @ self._table.ends.reshape(-1, 2, 3, 1)
            one, other = ends[..., 0].transpose(2, 3, 0, 1)
            centre, half = 0.5 * (one + other) + np.moveaxis(placed[..., :3, 3], -1, 0), 0.5 * (other - one)
            r = centre[..., a] - centre[..., b]
            between = np.sqrt(segments_squared(tuple(r), tuple(half[..., a]), tuple(half[..., b])))
            yield from zip(range(start, start + _FEW), T, between - width[a] - width[b], strict=False)

    def _place(self, T: Floats, s: int) -> Any:
        """Return the pose of a shape's geometry for coal, at poses of the links."""
        return _transform(T[self._table.link[s]] @ self._all[s].T_link_geometry)

    def _coals(self, T: Floats, pair: Any, most: float) -> Any:
        """Return coal's distance of a pair of shapes and their nearest points, at poses of the links.

        If the shapes are at least `most` apart, so are their parts, and their own distance is returned.
        """
        whole, (ours, others) = self._distance(T, *pair), (self._counting[s] for s in pair)
        if whole.min_distance >= most or not any(self._all[s].parts for s in pair):
            return whole
        return min((self._distance(T, *both) for both in product(ours, others)), key=lambda found: found.min_distance)

    def _distance(self, T: Floats, a: int, b: int) -> Any:
        result, one, other = coal.DistanceResult(), self._all[a].geometry, self._all[b].geometry
        coal.distance(one, self._place(T, a), other, self._place(T, b), _SIGNED, result)
        return result

    def _touch(self, T: Floats, a: int, b: int) -> bool:
        """Return whether two shapes touch; the hulls of meshes, which are tested first, are much faster."""
        one, other = self._all[a], self._all[b]
        if not _collide(one.geometry, self._place(T, a), other.geometry, self._place(T, b)):
            return False
        if one.parts or other.parts:
            return any(self._touch(T, *both) for both in product(self._counting[a], self._counting[b]))
        if one.triangles is None and other.triangles is None:
            return True
        meshes = [shape.triangles or (shape.geometry, shape.T_link_geometry) for shape in (one, other)]
        places = [_transform(T[self._table.link[s]] @ T_mesh) for s, (_, T_mesh) in zip((a, b), meshes, strict=True)]
        return _collide(meshes[0][0], places[0], meshes[1][0], places[1])

    def touching(self, q: Floats, pairs: set[LinkPair], *, limit: int | None = None) -> set[tuple[LinkPair, int]]:
        """Return which pairs touch in which of n configurations (n, nq), for each pair in at most `limit` of them."""
        counts, names = dict.fromkeys(sorted(pairs), 0), sorted(pairs)
        places, owner = self._pairs_of_shapes(names)
        seen: set[tuple[LinkPair, int]] = set()
        for sample, T, least in self._bounds(q, places):
            for k in np.flatnonzero(least <= _TOUCHING).tolist():
                pair = names[owner[k]]
                if (pair, sample) in seen or (limit is not None and counts[pair] >= limit):
                    continue
                if self._touch(T, *places[k]):
                    seen.add((pair, sample))
                    counts[pair] += 1
        return seen

    def count(self, q: Floats, pairs: set[LinkPair], *, limit: int | None = None) -> dict[LinkPair, int]:
        """Return the number of configurations (n, nq) in which the links of each pair touch, at most `limit`."""
        counts = dict.fromkeys(sorted(pairs), 0)
        for pair, _ in self.touching(q, pairs, limit=limit):
            counts[pair] += 1
        return counts

    def near(
        self, q: Floats, margin: float, skipped: NDArray[np.bool_] | None = None
    ) -> Iterator[tuple[int, int, Any]]:
        """Yield configuration, pair of links and coal's distance of those nearer than a margin; q (n, nq)."""
        for sample, T, least in self._bounds(q, self._places):
            for pair in np.flatnonzero(least < margin).tolist():
                if skipped is not None and skipped[self._owner[pair]]:
                    continue
                result = self._coals(T, self._places[pair], margin)
                if result.min_distance < margin:
                    yield sample, int(self._owner[pair]), result

    def contacts(self, q: Floats, margin: float, rule: CollisionRule) -> tuple[Contact, ...]:
        """Return the pairs of links nearer than a margin, by configuration (..., nq) and distance."""
        rows = q.reshape(-1, q.shape[-1])
        nearest, decided = dict[tuple[int, int], Any](), self._decided_by_meshes(rule.exact)
        for sample, owner, result in self.near(rows, margin, self.allowed(rule)):
            if -decided[owner] < result.min_distance < 0.0:
                result = self.meshes.apart(self.pairs[owner], self.meshes.poses(rows[[sample]]), 0) or result
                if result.min_distance >= margin:
                    continue
            known = nearest.get((sample, owner))
            if known is None or result.min_distance < known.min_distance:
                nearest[sample, owner] = result
        found = []
        for (sample, owner), result in sorted(nearest.items(), key=lambda item: (item[0][0], item[1].min_distance)):
            index = tuple(map(int, np.unravel_index(sample, q.shape[:-1])))
            points = np.array([result.getNearestPoint1(), result.getNearestPoint2()])
            found.append(Contact(self.pairs[owner], float(result.min_distance), points, index))
        return tuple(found)


def _least_extent(points: Floats) -> float:
    """Return the extent of points along their shortest principal axis."""
    axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2]
    return float(np.ptp(points @ axes[-1]))


def _collide(one: Any, T_one: Any, other: Any, T_other: Any) -> bool:
    return bool(coal.collide(one, T_one, other, T_other, coal.CollisionRequest(), coal.CollisionResult()))


# --- The meshes of the links, which tell whether two links touch whose hulls overlap.


class LinkMeshes:
    """The shapes of a robot as they are: triangles of meshes, balls, boxes and cylinders.

    A shape of a link without a hull, as of a finger, belongs to the next link towards the root that has one.
    """

    def __init__(self, robot: KinematicRobot, links: tuple[str, ...], rows: tuple[Visual | Collision, ...]) -> None:
        self._robot, owners = robot, {link: link for link in links}
        for joint in robot.tree.joints:  # outwards
            if joint.parent in owners:
                owners.setdefault(joint.child, owners[joint.parent])
        found: list[Shape] = []
        meshes: dict[str, list[tuple[Any, Floats]]] = defaultdict(list)
        for row in rows:
            try:
                geometry = shape_geometry(row.geometry, robot.tree.packages)
            except UnreadableShape:
                continue
            if isinstance(geometry, coal.BVHModelBase):
                meshes[row.link].append((geometry, row.origin.matrix))
            else:
                found.append(_shape(row.link, geometry, row.origin.matrix))
        found += [_shape(link, _joined(parts), np.eye(4)) for link, parts in meshes.items()]
        self._own: dict[str, list[Shape]] = defaultdict(list)
        for shape in found:
            if shape.link in owners:
                self._own[owners[shape.link]].append(shape)
        self.links = tuple(dict.fromkeys(shape.link for shapes in self._own.values() for shape in shapes))
        self._standing = dict[str, Floats]()

    def among(self, obstacles: tuple[Obstacle, ...]) -> LinkMeshes:
        """Return these meshes among obstacles."""
        made = copy(self)
        made._standing = {obstacle.name: obstacle.T for obstacle in obstacles}
        geometries = {obstacle.name: shape_geometry(obstacle.geometry, Packages(Path())) for obstacle in obstacles}
        made._own = self._own | {name: [_shape(name, geometry, np.eye(4))] for name, geometry in geometries.items()}
        return made

    def poses(self, q: Floats) -> dict[str, Floats]:
        """Return the poses of the links with shapes and of the obstacles, shape (..., 4, 4) each."""
        poses = dict(zip(self.links, np.moveaxis(self._robot.fk(q, self.links), -3, 0), strict=True))
        return poses | {name: np.broadcast_to(T, (*q.shape[:-1], 4, 4)) for name, T in self._standing.items()}

    def apart(self, pair: LinkPair, poses: dict[str, Floats], row: int) -> Any:
        """Return coal's distance of two links at a row of the poses, None if they touch, or if one has no shape.

        It is that of the hulls of their meshes or, where these overlap, of the meshes.
        """
        results = []
        for shapes in product(*(self._own[owner] for owner in pair)):
            one, other = ((s.geometry, _transform(poses[s.link][row] @ s.T_link_geometry)) for s in shapes)
            result = _measured(*one, *other)
            if result.min_distance <= _TOUCHING:
                meshes = (s.triangles or (s.geometry, s.T_link_geometry) for s in shapes)
                placed = zip(shapes, meshes, strict=True)
                one, other = ((mesh, _transform(poses[s.link][row] @ T)) for s, (mesh, T) in placed)
                if _collide(*one, *other):
                    return None
                result = _measured(*one, *other)
            results.append(result)
        return min(results, key=lambda result: result.min_distance, default=None)


def _shape(link: str, geometry: Any, T: Floats) -> Shape:
    """Return a shape, of a mesh with its triangles, at a pose in the link; its points are not needed."""
    if isinstance(geometry, coal.BVHModelBase):
        hull = hull_shape(link, np.array(geometry.vertices()))
        return replace(hull, T_link_geometry=T @ hull.T_link_geometry, triangles=(geometry, T))
    return Shape(link, np.empty((0, 3)), 0.0, geometry, T)


def _measured(*placed: Any) -> Any:
    result = coal.DistanceResult()
    coal.distance(*placed, coal.DistanceRequest(), result)
    return result


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
