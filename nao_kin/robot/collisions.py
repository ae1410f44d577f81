"""Self-collision: the shapes of the links as segments and boxes grown by a radius, and distances between them.

Distances are negative where shapes overlap: the least translation that separates them.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING, Any

import coal
import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats, finite_or_none
from nao_kin._core.text import abbreviated
from nao_kin._kernels.cache import may_compile
from nao_kin._kernels.capsules import BOX, SEGMENT, ShapeTable, clearances, pair_gaps
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.robot.answers import CROSSOVER
from nao_kin.robot.contacts import LinkPair, disabled_collisions
from nao_kin.robot.geometry import capsules, mesh_path, read_mesh, warn_of_shapes
from nao_kin.robot.urdf import Box, Collision, Cylinder, MeshFile, Sphere, UnreadableShape, UrdfTree, Visual

if TYPE_CHECKING:
    from nao_kin.robot.model import RobotModel

# --- The answers.


@dataclass(frozen=True)
class Contact:
    """Two links that are nearer to each other than a margin.

    Attributes:
        links: their names.
        distance: distance of their shapes, negative if they overlap [m].
        points: the nearest point of each, or the deepest one if they overlap, in the root's frame, shape (2, 3) [m].
        index: index of the configuration in the batch.
    """

    links: LinkPair
    distance: float
    points: Floats
    index: tuple[int, ...] = ()

    def describe(self) -> str:
        """Return links and distance in words.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.configuration({"LShoulderRoll": -0.3, "LElbowRoll": -1.5, "RElbowRoll": 0.04})
            >>> nao.collisions(q)[0].describe()
            'RBicep and l_wrist overlap by 19.1 mm'
        """
        apart = "overlap by" if self.distance < 0.0 else "are apart by"
        where = f" (configuration {', '.join(map(str, self.index))})" if self.index else ""
        return f"{self.links[0]} and {self.links[1]} {apart} {abs(self.distance) * 1e3:.1f} mm{where}"

    def as_dict(self) -> dict[str, Any]:
        """Return the fields for JSON [m]."""
        return {"links": list(self.links), "distance": self.distance, "points": self.points.tolist()}


@dataclass(frozen=True, eq=False)
class Clearance:
    """The least distance between links of a robot, for configurations of a batch shape (...); () for one.

    Attributes:
        distance: negative if some links overlap; infinite without links to check; shape (...) [m].
        pair_index: which of `pairs` has it, −1 for none, shape (...).
        pairs: the pairs of links that are checked.
    """

    distance: Floats
    pair_index: NDArray[np.int64]
    pairs: tuple[LinkPair, ...] = field(repr=False)

    @property
    def pair(self) -> LinkPair | NDArray[np.object_] | None:
        """The two nearest links, None without links to check; of a batch an array of these, shape (...)."""
        if self.pair_index.ndim == 0:
            return self.pairs[int(self.pair_index)] if self.pair_index >= 0 else None
        found = np.empty(self.pair_index.shape, dtype=object)
        for index, pair in np.ndenumerate(self.pair_index):
            found[index] = self.pairs[pair] if pair >= 0 else None
        return found

    @property
    def is_free(self) -> bool | NDArray[np.bool_]:
        """Whether no links overlap: a bool, or of a batch an array of shape (...)."""
        free = self.distance >= 0.0
        return bool(free) if free.ndim == 0 else free

    def as_dict(self) -> dict[str, Any]:
        """Return the clearance of one configuration for JSON [m]; None without links to check."""
        pair = self.pairs[int(self.pair_index)] if self.pair_index >= 0 else None
        return {"distance": finite_or_none(float(self.distance)), "pair": pair and list(pair)}


# --- The shapes of the links.

# Samples that sort the pairs of a robot whose semantics do not.
_SAMPLES = 1000
_CHUNK = 4096
_FEW = 64


@dataclass(frozen=True)
class Shape:
    """A segment or a box in a link: centre, axes as columns, half lengths and radius [m]."""

    kind: int
    link: str
    centre: Floats
    axes: Floats
    half: tuple[float, ...]
    radius: float


def shapes_of(tree: UrdfTree) -> Iterator[Shape]:
    """Yield the collision shapes of a tree, or the visual shapes if it has none; warn of those left out.

    A cylinder is a capsule with hemispheres at its ends: with two spheres of its radius there, as a URDF writes a
    capsule, exactly, and alone a little more. A mesh is the capsule that contains it.
    """
    notes = [] if tree.collisions else list(tree.visual_notes)
    rows: tuple[Visual | Collision, ...] = tree.collisions or tree.visuals
    caps = {cap for both in capsules(rows).values() for cap in both}
    for row in (row for index, row in enumerate(rows) if index not in caps):
        T, shape = row.origin.matrix, row.geometry
        place = row.link, T[:3, 3], T[:3, :3]
        if isinstance(shape, Box):
            yield Shape(BOX, *place, tuple(0.5 * length for length in shape.size), 0.0)
        elif isinstance(shape, Cylinder):
            yield Shape(SEGMENT, *place, (0.0, 0.0, 0.5 * shape.length), shape.radius)
        elif isinstance(shape, Sphere):
            yield Shape(SEGMENT, *place, (0.0, 0.0, 0.0), shape.radius)
        else:
            try:
                corners = _corners(shape, tree)
            except UnreadableShape as reason:
                notes.append(f"a shape of {abbreviated(row.link)} is left out: {reason}")
            else:
                yield covering_capsule(corners @ T[:3, :3].T + T[:3, 3], row.link)
    warn_of_shapes(tree, notes)


def _corners(mesh: MeshFile, tree: UrdfTree) -> Floats:
    corners = read_mesh(mesh_path(mesh, tree.packages), lambda scene: np.array(scene.to_geometry().vertices))
    return np.asarray(corners * np.array(mesh.scale))


def covering_capsule(points: Floats, link: str = "") -> Shape:
    """Return a capsule that contains points (n, 3): its segment is along the longest principal axis of the points."""
    middle = points.mean(axis=0)
    axes = np.linalg.svd(points - middle, full_matrices=False)[2].T[:, ::-1] if len(points) > 2 else np.eye(3)
    low, high = (points @ axes).min(axis=0), (points @ axes).max(axis=0)
    local = points @ axes - (low + high) / 2.0
    across = np.linalg.norm(local[:, :2], axis=1)
    radius = float(across.max())
    # Each point is within the radius of the segment if this reaches so far along the axis.
    half = max(float((np.abs(local[:, 2]) - np.sqrt(radius**2 - across**2)).max()), 0.0)
    return Shape(SEGMENT, link, axes @ (low + high) / 2.0, axes, (0.0, 0.0, half), radius)


class LinkShapes:
    """The shapes of a robot's links, and the distances between the pairs of links that are checked.

    Attributes:
        links: the links with shapes.
        pairs: the pairs of links that are checked.
        disabled: the other pairs, and the reason.
    """

    def __init__(self, robot: RobotModel, disabled: dict[LinkPair, str] | None = None) -> None:
        self._robot = robot
        shapes = list(shapes_of(robot.tree))
        self.links = tuple(link for link in robot.link_names if any(shape.link == link for shape in shapes))
        if not shapes:
            raise BadArgument(f"{robot.name} has no shapes: its links have neither collisions nor visuals")
        self.shapes = tuple(sorted(shapes, key=lambda shape: (self.links.index(shape.link), -shape.kind)))
        numbers = ([getattr(shape, name) for shape in self.shapes] for name in ("kind", "centre", "half", "radius"))
        kind, centre, half, radius = map(np.array, numbers)
        link = np.array([self.links.index(shape.link) for shape in self.shapes])
        axes = np.ascontiguousarray([shape.axes for shape in self.shapes])
        reach = np.linalg.norm(half, axis=1) + radius
        self._table = ShapeTable(link, kind, centre, axes, half, radius, reach)
        self.pairs: tuple[LinkPair, ...] = tuple(combinations(sorted(self.links), 2))
        self.disabled = self._disabled() if disabled is None else disabled
        self.pairs = tuple(pair for pair in self.pairs if pair not in self.disabled)
        self._choose(self.pairs)

    def _disabled(self) -> dict[LinkPair, str]:
        rows = self._robot.semantics.disabled_collisions
        for name in (name for row in rows for name in row[:2]):
            if name not in self._robot.tree.links:
                raise UnknownName("link in disabled_collisions", name, self._robot.tree.links)
        if rows:
            return {(min(a, b), max(a, b)): reason for a, b, reason in rows}
        return disabled_collisions(self._robot, self, samples=_SAMPLES, seed=0)

    def _choose(self, pairs: tuple[LinkPair, ...]) -> None:
        """Prepare the pairs of shapes of pairs of links, those with boxes last: a near pair leaves them out."""
        of_link = defaultdict(list)
        for place, shape in enumerate(self.shapes):
            of_link[shape.link].append(place)
        kind = self._table.kind
        rows = [
            ((a, b) if kind[a] >= kind[b] else (b, a), owner)
            for owner, pair in enumerate(pairs)
            for a in of_link[pair[0]]
            for b in of_link[pair[1]]
        ]
        rows.sort(key=lambda row: int(kind[row[0][0]] + kind[row[0][1]]))
        self._places = np.array([row[0] for row in rows], dtype=np.int64).reshape(-1, 2)
        self._owner = np.array([row[1] for row in rows], dtype=np.int64)

    def clearance(self, q: Floats, below: float = np.inf) -> Clearance:
        """Return the clearance of configurations (..., nq); distances from `below` on are this number, of no pair."""
        rows = q.reshape(-1, q.shape[-1])
        gaps, which = np.full(len(rows), below), np.full(len(rows), -1, dtype=np.int64)
        compiled = clearances.in_memory or (len(rows) >= CROSSOVER and may_compile())
        for start in range(0, len(rows) if len(self._places) else 0, _CHUNK):
            part = slice(start, start + _CHUNK)
            if compiled:
                poses = np.ascontiguousarray(self._robot.fk(rows[part], self.links))
                clearances(poses, self._table, self._places, float(below), gaps[part], which[part])
            else:
                self._by_numpy(rows[part], below, gaps[part], which[part])
        which = np.where(which >= 0, self._owner[which], -1) if len(self._places) else which
        shape = q.shape[:-1]
        return Clearance(gaps.reshape(shape), which.reshape(shape), self.pairs)

    def _by_numpy(self, q: Floats, below: float, gaps: Floats, which: NDArray[np.int64]) -> None:
        for start in range(0, len(q), _FEW):
            centres, axes = self._placed(q[start : start + _FEW])
            between = self._between(centres)
            radius = self._table.radius[self._places].sum(axis=1)
            # Each centre is in its shape, with all that is within its radius: no clearance is more than this.
            most = np.minimum((between - radius).min(axis=1), below)
            near = between - self._table.reach[self._places].sum(axis=1) <= most[:, None]
            at, pair = np.nonzero(near)
            found = pair_gaps(centres, axes, self._table, self._places[pair], at)
            order = np.lexsort((-found, -at))[::-1]  # the least of each configuration is the first of it
            at, pair, found = at[order], pair[order], found[order]
            first = np.flatnonzero(np.diff(at, prepend=-1))
            first = first[found[first] < below]
            gaps[start + at[first]], which[start + at[first]] = found[first], pair[first]

    def _placed(self, q: Floats) -> tuple[Floats, Floats]:
        T = self._robot.fk(q, self.links)[:, self._table.link]
        R, centre = T[..., :3, :3], self._table.centre[..., None]
        return (R @ centre)[..., 0] + T[..., :3, 3], R @ self._table.axes

    def _between(self, centres: Floats) -> Floats:
        a, b = self._places.T
        return np.asarray(np.linalg.norm(centres[:, a] - centres[:, b], axis=-1))

    def near(self, q: Floats, margin: float) -> Iterator[tuple[int, int, int, float]]:
        """Yield configuration, pair of links, pair of shapes and distance of those nearer than a margin; q (n, nq)."""
        for start in range(0, len(q), _FEW):
            centres, axes = self._placed(q[start : start + _FEW])
            at, pair = np.nonzero(self._between(centres) - self._table.reach[self._places].sum(axis=1) < margin)
            gaps = pair_gaps(centres, axes, self._table, self._places[pair], at)
            close = gaps < margin
            columns = at[close] + start, self._owner[pair[close]], pair[close], gaps[close]
            yield from zip(*(column.tolist() for column in columns), strict=True)

    def count(self, q: Floats, pairs: set[LinkPair], *, limit: int | None = None) -> dict[LinkPair, int]:
        """Return the number of configurations (n, nq) in which the links of each pair overlap, at most `limit`."""
        chosen = tuple(sorted(pairs))
        self._choose(chosen)
        seen = {(sample, owner) for sample, owner, *_ in self.near(q, 0.0)}
        counts = np.bincount([owner for _, owner in seen], minlength=len(chosen))
        return {pair: min(int(n), limit or len(q)) for pair, n in zip(chosen, counts, strict=True)}

    def contacts(self, q: Floats, margin: float) -> tuple[Contact, ...]:
        """Return the pairs of links nearer than a margin, by configuration (..., nq) and distance; points by coal."""
        rows = q.reshape(-1, q.shape[-1])
        nearest: dict[tuple[int, int], tuple[float, int]] = {}
        for sample, owner, pair, gap in self.near(rows, margin):
            nearest[sample, owner] = min(nearest.get((sample, owner), (np.inf, -1)), (gap, pair))
        found = []
        for (sample, owner), (gap, pair) in sorted(nearest.items(), key=lambda item: (item[0][0], item[1][0])):
            index = tuple(map(int, np.unravel_index(sample, q.shape[:-1])))
            found.append(Contact(self.pairs[owner], gap, self._points(rows[sample], owner, pair), index))
        return tuple(found)

    def _points(self, q: Floats, owner: int, pair: int) -> Floats:
        """Return the nearest points of a pair of shapes, in the order of the links."""
        a, b = self._places[pair].tolist()
        if self.shapes[a].link != self.pairs[owner][0]:
            a, b = b, a
        centres, axes = self._placed(q[None])
        places = [coal.Transform3s(axes[0, s], centres[0, s]) for s in (a, b)]
        request, result = coal.DistanceRequest(), coal.DistanceResult()
        request.enable_signed_distance = True
        coal.distance(self.geometries[a], places[0], self.geometries[b], places[1], request, result)
        return np.array([result.getNearestPoint1(), result.getNearestPoint2()])

    @cached_property
    def geometries(self) -> tuple[Any, ...]:
        """The shapes as coal's."""
        return tuple(
            coal.Box(*(2.0 * half for half in shape.half))
            if shape.kind == BOX
            else coal.Capsule(shape.radius, 2.0 * shape.half[2])
            if shape.half[2]
            else coal.Sphere(shape.radius)
            for shape in self.shapes
        )


# Random configurations drawn at once, and in vain before giving up.
_DRAWN, _MOST_DRAWN = 256, 100_000


def random_free(
    robot: RobotModel, shapes: LinkShapes, rng: np.random.Generator | int | None, n: int | tuple[int, ...] | None
) -> Floats:
    """Return random configurations in which no links overlap: others are drawn again."""
    wanted = robot.random(rng, n)  # checks the arguments
    generator = np.random.default_rng(rng)
    rows = wanted.reshape(-1, robot.nq)
    filled = vain = 0
    while filled < len(rows):
        q = robot.random(generator, min(max(_DRAWN, len(rows) - filled), _CHUNK))
        q = q[shapes.clearance(q, 0.0).is_free][: len(rows) - filled]
        vain = 0 if len(q) else vain + _DRAWN
        if vain > _MOST_DRAWN:
            raise BadArgument(
                f"{robot.name} collides in each of {vain} random configurations: are its shapes too large?"
            )
        rows[filled : filled + len(q)] = q
        filled += len(q)
    return rows.reshape(wanted.shape)
