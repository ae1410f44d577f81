"""The shapes of the links as convex hulls, and the distances between them.

Distances are negative where shapes overlap: the least translation that separates them.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import coal
import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import CROSSOVER, Floats, join_poses
from nao_kin._core.text import abbreviated, quoted
from nao_kin._kernels.cache import may_compile
from nao_kin._kernels.hulls import HullTable, clearances, segments_squared
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.robot.collision_meshes import LinkMeshes
from nao_kin.robot.collision_pairs import ALWAYS, DEFAULT, Capsules, LinkPair, disabled_collisions
from nao_kin.robot.collisions import Clearance, CollisionRule, Contact, Obstacle
from nao_kin.robot.geometry import capsules, check_points, check_size, read_mesh, shape_geometry, warn_of_shapes
from nao_kin.robot.joint_arrays import ROOT
from nao_kin.robot.urdf import (
    Box,
    Collision,
    Cylinder,
    Geometry,
    MeshFile,
    Packages,
    Sphere,
    UnreadableShape,
    UrdfTree,
    Visual,
)

if TYPE_CHECKING:
    from nao_kin.robot.model import RobotModel

# Random configurations, and boxes in a proof, that sort the pairs of a robot whose semantics do not.
_SAMPLES = 1000
_CHUNK = 4096
# Configurations whose pairs are tested for nearness at once.
_FEW = 64
# Shapes at this distance may touch: coal reports shapes within its tolerance as touching [m].
_TOUCHING = 1e-5
# Sides of the prism around a cylinder: it is larger by 0.5 % of the radius.
_SIDES = 32
# Overlaps that differ by less are equal: coal and the kernel find them to some tolerance [m].
_SAME = 1e-5
# Hulls flatter than this, or than this share of their extent, have no volume [m, 1]: in coal they end the process.
_THIN = 1e-6
_SIGNED = coal.DistanceRequest()
_SIGNED.enable_signed_distance = True
_SIGNED.gjk_tolerance = _SIGNED.epa_tolerance = 1e-10


@dataclass(frozen=True, eq=False)
class Shape:
    """A shape of a link: coal's geometry and its pose in the link, and points whose hull, grown, contains it [m].

    The hull grown by the radius is the shape, except for a flat-ended cylinder (two points) and a concave mesh.
    """

    link: str
    points: Floats  # one with a radius is a ball, two a capsule; a hull of more has no radius
    radius: float
    geometry: Any
    T_link_geometry: Floats
    triangles: tuple[Any, Floats] | None = None  # coal's mesh of which `geometry` is the hull, if it counts; its pose
    parts: tuple[Shape, ...] = ()  # shapes of other links, such as fingers, inside this one; if given, they count


def round_shape(link: str, ends: Floats, radius: float) -> Shape:
    """Return a ball, or a capsule: its ends in the link, shape (2, 3), and its radius [m]."""
    T, along = np.eye(4), ends[1] - ends[0]
    length = float(np.linalg.norm(along))
    T[:3, 3] = 0.5 * (ends[0] + ends[1])
    if length <= _THIN:
        return Shape(link, T[None, :3, 3], radius + 0.5 * length, coal.Sphere(radius + 0.5 * length), T)
    axes = np.linalg.svd(along[None])[2][[1, 2, 0]].T
    T[:3, :3] = np.linalg.det(axes) * axes
    return Shape(link, ends, radius, coal.Capsule(radius, length), T)


def hull_shape(link: str, points: Floats) -> Shape:
    """Return the convex hull of points in a link, shape (n, 3) [m]: the only way to coal's hulls.

    Points in a plane, on a line or in one point get a thickness of 2 µm, or of 2 millionths of their extent.
    """
    centre = check_points(points).mean(axis=0)
    local, extent = points - centre, float(np.ptp(points, axis=0).max())
    axes = np.linalg.svd(np.concatenate([local, np.zeros((3, 3))]), full_matrices=False)[2]
    thin = _THIN * max(1.0, extent)
    flat = [axis for axis in axes if np.ptp(local @ axis) < thin]
    if flat:
        local = np.unique(local, axis=0)
    elif np.abs(centre).max() < extent:  # a more distant origin costs qhull its digits
        local, centre = points, np.zeros(3)
    for axis in flat:
        local = np.concatenate([local - thin * axis, local + thin * axis])
    mesh = coal.BVHModelOBBRSS()
    mesh.beginModel(0, 0)
    mesh.addVertices(local)
    mesh.endModel()
    mesh.buildConvexHull(True, "Qt Pp")  # Pp: coal gives qhull no file for its warnings, and that ends the process
    corners = np.array(mesh.convex.points()).reshape(-1, 3) + centre
    return Shape(link, corners, 0.0, mesh.convex, join_poses(np.eye(3), centre))


def exact_shape(link: str, T: Floats, shape: Geometry, tree: UrdfTree) -> Shape:
    """Return a box, a cylinder with flat ends, or a mesh with its triangles; T is the pose in the link."""
    geometry, radius = shape_geometry(shape, tree.packages), 0.0
    if isinstance(shape, MeshFile):
        corners = np.array(geometry.vertices()) @ T[:3, :3].T + T[:3, 3]
        return replace(hull_shape(link, corners), triangles=(geometry, T))
    if isinstance(shape, Cylinder):
        points, radius = np.array([[0.0, 0.0, -0.5 * shape.length], [0.0, 0.0, 0.5 * shape.length]]), shape.radius
    else:
        points = _corners(shape, tree.packages)
    return Shape(link, points @ T[:3, :3].T + T[:3, 3], radius, geometry, T)


def _hull_of(link: str, T: Floats, shape: Geometry, tree: UrdfTree) -> Shape:
    return hull_shape(link, _corners(shape, tree.packages) @ T[:3, :3].T + T[:3, 3])


def _obstacle_shape(obstacle: Obstacle) -> Shape:
    if isinstance(obstacle.geometry, Sphere):
        return round_shape(obstacle.name, np.zeros((2, 3)), obstacle.geometry.radius)
    return hull_shape(obstacle.name, _corners(obstacle.geometry, Packages(Path())))


def shapes_of(tree: UrdfTree) -> Iterator[Shape]:
    """Yield the hulls of the collision shapes of a tree, or else of the visual ones; warn of those left out."""
    notes = list(tree.collision_notes if tree.collisions else (*tree.collision_notes, *tree.visual_notes))
    yield from _shapes(tree.collisions or tree.visuals, tree, _hull_of, notes)
    warn_of_shapes(tree, notes)


def _shapes(
    rows: tuple[Visual | Collision, ...], tree: UrdfTree, make: Callable[..., Shape], notes: list[str]
) -> Iterator[Shape]:
    """Yield the shapes of rows, with capsules joined; add a note for each that cannot be read."""
    round_ended = capsules(rows)
    caps = {cap for both in round_ended.values() for cap in both}
    for index, row in enumerate(rows):
        T, shape = row.origin.matrix, row.geometry
        if index in caps:
            continue
        try:
            check_points(T[None, :3, 3])
            if isinstance(shape, Sphere) or index in round_ended:
                check_size(shape)  # type: ignore[arg-type]
                half = 0.5 * shape.length * T[:3, 2] if isinstance(shape, Cylinder) else np.zeros(3)
                yield round_shape(row.link, np.array([T[:3, 3] - half, T[:3, 3] + half]), shape.radius)  # type: ignore[union-attr]
            else:
                yield make(row.link, T, shape, tree)
        except UnreadableShape as reason:
            kind = "visual" if isinstance(row, Visual) else "collision"
            notes.append(f"a {kind} shape of {abbreviated(row.link)} is left out: {reason}")


def _corners(shape: Geometry, packages: Packages) -> Floats:
    """Return points whose hull is a box or a mesh, or contains a cylinder."""
    if isinstance(shape, MeshFile):
        corners = read_mesh(shape.path(packages), lambda scene: np.array(scene.to_mesh().vertices))
        return check_points(corners * np.array(shape.scale), f"its mesh {quoted(shape.filename)}")
    check_size(shape)
    if isinstance(shape, Box):
        return np.array(list(product((-0.5, 0.5), repeat=3))) * shape.size
    assert isinstance(shape, Cylinder)
    angles = 2.0 * np.pi / _SIDES * np.arange(_SIDES)
    x, y = shape.radius / np.cos(np.pi / _SIDES) * np.array([np.cos(angles), np.sin(angles)])
    return np.concatenate(
        [np.column_stack([x, y, np.full(_SIDES, z)]) for z in (-0.5 * shape.length, 0.5 * shape.length)]
    )


def hulls_in(text: str) -> Iterator[Shape]:
    """Yield the shapes of an OBJ file: the hull of each object, in the link after which it is named ("torso.2").

    "l_wrist.Fingers.LThumb1_link" is a part of the object "l_wrist.Fingers", in the link LThumb1_link.
    """
    hulls, parts = dict[str, Shape](), defaultdict[str, list[Shape]](list)
    for block in text.split("\no ")[1:]:
        name, *lines = block.splitlines()
        points = np.array([line.split()[1:] for line in lines if line.startswith("v ")], dtype=float)
        owner, *others = name.split(".")
        if len(others) == 2:
            parts[f"{owner}.{others[0]}"].append(hull_shape(others[1], points))
        else:
            hulls[name] = hull_shape(owner, points)
    yield from (replace(shape, parts=tuple(parts[name])) for name, shape in hulls.items())


def covering_capsule(points: Floats) -> tuple[Floats, float]:
    """Return ends (2, 3) and radius of a capsule that contains points (n, 3), along their longest principal axis."""
    if len(points) <= 2:
        return points[[0, -1]], 0.0
    axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2].T[:, ::-1]
    low, high = (points @ axes).min(axis=0), (points @ axes).max(axis=0)
    local = points @ axes - (low + high) / 2.0
    across = np.linalg.norm(local[:, :2], axis=1)
    radius = float(across.max())
    # Each point is within the radius of the segment if this reaches so far along the axis.
    half = max(float((np.abs(local[:, 2]) - np.sqrt(np.maximum(radius**2 - across**2, 0.0))).max()), 0.0)
    centre = axes @ (low + high) / 2.0
    return np.array([centre - half * axes[:, 2], centre + half * axes[:, 2]]), radius


class LinkShapes:
    """The shapes of a robot's links, in the links' order, and the distances between the `pairs` that are checked."""

    def __init__(
        self,
        robot: RobotModel,
        disabled: dict[LinkPair, str] | None = None,  # the other pairs, and the reason
        shapes: Iterable[Shape] | None = None,
        obstacles: tuple[Obstacle, ...] = (),
    ) -> None:
        self._robot, self.notes = robot, list[str]()
        own = list(robot._collision_shapes() if shapes is None else shapes)
        if shapes is None and not own:
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
            self._last = LinkShapes(self._robot, self.disabled, self.shapes, wanted)
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
    def exact(cls, robot: RobotModel) -> LinkShapes:
        """Return the collision elements as they are, for tests of contact; `notes` says which are left out."""
        notes: list[str] = []
        made = cls(robot, {}, list(_shapes(robot.tree.collisions, robot.tree, exact_shape, notes)))
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
        return disabled_collisions(self._robot, self, samples=samples, seed=seed)

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
        return LinkMeshes(self._robot, self.links, self._robot._exact_shapes())

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
        exact: bool = False,
    ) -> Clearance:
        """Return the clearance of configurations (..., nq); a distance of `below` or more is `below`, of no pair.

        `checked` is which pairs are checked, shape (pairs,); None for all. If `exact`, the meshes of links whose hulls
        overlap decide.
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
        if exact:
            self._by_meshes(rows, below, checked, gaps, which)
        shape = q.shape[:-1]
        return Clearance(gaps.reshape(shape), which.reshape(shape), self.pairs, tolerance, tuple(self.notes))

    def _by_meshes(
        self, q: Floats, below: float, checked: NDArray[np.bool_] | None, gaps: Floats, which: NDArray[np.int64]
    ) -> None:
        """Let the meshes decide where hulls overlap; mostly the links whose hulls overlap most do touch."""
        overlapping = np.flatnonzero((gaps < 0.0) & (which >= 0))
        every = self.meshes.poses(q[overlapping])
        poses = {k: {link: T[row] for link, T in every.items()} for row, k in enumerate(overlapping.tolist())}
        apart = [k for k in poses if not self.meshes.touch(self.pairs[which[k]], poses[k])]
        depths: dict[int, dict[int, float]] = {k: {} for k in apart}
        for row, pair, result in self.near(q[apart], 0.0, None if checked is None else ~checked):
            known = depths[apart[row]]
            known[pair] = min(result.min_distance, known.get(pair, 0.0))
        for k, found in depths.items():
            others = sorted((depth, pair) for pair, depth in found.items() if pair != which[k])
            least = next((one for one in others if self.meshes.touch(self.pairs[one[1]], poses[k])), None)
            if least is None:
                rest = np.ones(len(self.pairs), dtype=np.bool_) if checked is None else checked.copy()
                rest[list(found)] = False
                other = self.clearance(q[k], checked=rest)
                meshes = ((self.meshes.nearest(self.pairs[pair], poses[k]).min_distance, pair) for pair in found)
                least = min((float(other.distance), int(other.pair_index)), *meshes)
            gaps[k], which[k] = least if least[0] < below else (below, -1)

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

    def _place(self, T: Floats, s: int, T_link_geometry: Floats | None = None) -> Any:
        """Return the pose of a shape's geometry, or of another one in its link, for coal, at poses of the links."""
        placed = T[self._table.link[s]] @ (self._all[s].T_link_geometry if T_link_geometry is None else T_link_geometry)
        return coal.Transform3s(placed[:3, :3], placed[:3, 3])

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
        if not _collide(one.geometry, other.geometry, self._place(T, a), self._place(T, b)):
            return False
        if one.parts or other.parts:
            return any(self._touch(T, *both) for both in product(self._counting[a], self._counting[b]))
        if one.triangles is None and other.triangles is None:
            return True
        meshes = [shape.triangles or (shape.geometry, shape.T_link_geometry) for shape in (one, other)]
        places = [self._place(T, s, T_mesh) for s, (_, T_mesh) in zip((a, b), meshes, strict=True)]
        return _collide(meshes[0][0], meshes[1][0], *places)

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

    def contacts(self, q: Floats, margin: float, rule: CollisionRule | None = None) -> tuple[Contact, ...]:
        """Return the pairs of links nearer than a margin, by configuration (..., nq) and distance."""
        rows = q.reshape(-1, q.shape[-1])
        nearest: dict[tuple[int, int], Any] = {}
        skipped = None if rule is None else self.allowed(rule)
        for sample, owner, result in self.near(rows, margin, skipped):
            if rule is not None and rule.exact and result.min_distance < 0.0:
                pair, poses = self.pairs[owner], self.meshes.poses(rows[sample])
                result = result if self.meshes.touch(pair, poses) else self.meshes.nearest(pair, poses)
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


def _collide(one: Any, other: Any, T_one: Any, T_other: Any) -> bool:
    return bool(coal.collide(one, T_one, other, T_other, coal.CollisionRequest(), coal.CollisionResult()))
