"""Contact tests between links with the collision library coal, and the pairs of links that need no check."""

from __future__ import annotations

import functools
from collections import defaultdict
from collections.abc import Collection, Iterator
from itertools import combinations, product
from typing import TYPE_CHECKING, Any, Protocol

import coal
import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats
from nao_kin._core.text import abbreviated
from nao_kin.robot.geometry import capsules, shape_geometry
from nao_kin.robot.separation import Capsules, covering_capsule, never_touch
from nao_kin.robot.urdf import UnreadableShape, UrdfJoint, UrdfTree

if TYPE_CHECKING:
    from nao_kin.robot.model import RobotModel

# --- Contacts between links, counted in many configurations with the collision library coal.

# Margin of boxes around shapes [m]: coal reports shapes within its tolerance as touching.
_MARGIN = 1e-5
# Batches of this size are computed by Pinocchio, without compiling a kernel.
_POSED_AT_ONCE = 50
# Number of planes to try between two meshes, and of configurations above which this is worth the time.
_PLANES, _FEW = 8, 4
_DISTANCE = coal.DistanceRequest()
# Two names in alphabetical order.
LinkPair = tuple[str, str]


class LinkContacts:
    """The collision shapes of a robot, prepared for contact tests between pairs of links."""

    def __init__(self, robot: RobotModel) -> None:
        self._robot, tree = robot, robot.tree
        self.notes: list[str] = []
        self._shapes: dict[str, list[int]] = defaultdict(list)
        self._geometries: list[Any] = []
        self.capsules: Capsules = defaultdict(list)
        owners, placements = [], []
        packages = tree.packages
        caps = {cap for both in capsules(tree.collisions).values() for cap in both}
        for index, collision in enumerate(tree.collisions):
            try:
                geometry = shape_geometry(collision.geometry, packages)
            except UnreadableShape as reason:
                self.notes.append(f"a collision shape of {abbreviated(collision.link)} is left out: {reason}")
                continue
            geometry.computeLocalAABB()
            self._shapes[collision.link].append(len(self._geometries))
            self._geometries.append(geometry)
            owners.append(collision.link)
            placements.append(T := collision.origin.matrix)
            if index not in caps:  # the cap of a cylinder is inside the capsule around that
                ends, radius = _capsule_around(geometry)
                self.capsules[collision.link].append((ends @ T[:3, :3].T + T[:3, 3], radius))
        self.links = tuple(link for link in tree.links if link in self._shapes)
        self.pairs: tuple[LinkPair, ...] = tuple(combinations(sorted(self.links), 2))
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

    def count(self, q: Floats, pairs: set[LinkPair], *, limit: int | None = None) -> dict[LinkPair, int]:
        """Return the number of configurations, of n (n, nq), in which the links of each pair touch, at most `limit`."""
        counts = dict.fromkeys(sorted(pairs), 0)
        for pair, _ in self.touching(q, pairs, limit=limit):
            counts[pair] += 1
        return counts

    def touching(self, q: Floats, pairs: set[LinkPair], *, limit: int | None = None) -> set[tuple[LinkPair, int]]:
        """Return which pairs touch in which of n configurations (n, nq), for each pair at most `limit` of them."""
        counts = dict.fromkeys(sorted(pairs), 0)
        both = [(pair, a, b) for pair in counts for a in self._shapes[pair[0]] for b in self._shapes[pair[1]]]
        seen: set[tuple[LinkPair, int]] = set()
        if not both or not len(q):
            return seen
        parts = [q[start : start + _POSED_AT_ONCE] for start in range(0, len(q), _POSED_AT_ONCE)]
        T_root_link = np.concatenate([self._robot.fk(part, list(self.links)) for part in parts])
        T_root_shape = T_root_link[:, self._columns] @ self._T_link_shape
        place = functools.cache(lambda sample, shape: _transform(T_root_shape[sample, shape]))
        for index, samples in self._near(T_root_shape, np.array([row[1:] for row in both]).T):
            pair, a, b = both[index]
            if limit is not None and counts[pair] >= limit:
                continue
            for sample in samples[~self._separate(a, b, T_root_shape[samples])].tolist():
                if (limit is not None and counts[pair] >= limit) or (pair, sample) in seen:
                    continue
                if self._touch(a, place(sample, a), b, place(sample, b)):
                    seen.add((pair, sample))
                    counts[pair] += 1
        return seen

    def _near(self, T_root_shape: Floats, shapes: NDArray[np.intp]) -> Iterator[tuple[int, NDArray[np.intp]]]:
        """Yield the pairs of shapes that may touch, each as index into `shapes`, with their configurations.

        Two shapes do not touch if their bounding spheres do not, or if the projections of their boxes on an edge of one
        of the boxes do not overlap.
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

    def _separate(self, a: int, b: int, T_root_shape: Floats) -> NDArray[np.bool_]:
        """Return the configurations in which a plane separates two meshes; in the others they may touch or not.

        The plane between the two hulls in one configuration, fixed to the first mesh, often separates them in many.
        """
        separate, tried = np.zeros((2, len(T_root_shape)), bool)
        corners_a, corners_b = self._corners[a], self._corners[b]
        if corners_a is None or corners_b is None or len(separate) < _FEW:
            return separate
        T_root_a, T_root_b = T_root_shape[:, a], T_root_shape[:, b]
        for _ in range(_PLANES):
            sample = int(np.argmin(separate | tried))
            if separate[sample] or tried[sample]:
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
            separate |= lowest > (corners_a @ normal).max() + _MARGIN
        return separate

    def _touch(self, a: int, place_a: Any, b: int, place_b: Any) -> bool:
        """Return whether two shapes touch; their convex hulls, which are tested first, are much faster."""
        return _collide(self._hulls[a], place_a, self._hulls[b], place_b) and (
            (self._hulls[a] is self._geometries[a] and self._hulls[b] is self._geometries[b])
            or _collide(self._geometries[a], place_a, self._geometries[b], place_b)
        )


def _capsule_around(geometry: Any) -> tuple[Floats, float]:
    """Return ends (2, 3) and radius of a capsule that contains a shape, in the shape's frame."""
    if isinstance(geometry, coal.Sphere | coal.Cylinder | coal.Capsule):
        half = getattr(geometry, "halfLength", 0.0)
        return np.array([[0.0, 0.0, -half], [0.0, 0.0, half]]), geometry.radius
    hull, box = _hull(geometry), geometry.aabb_local
    corners = hull.points() if hull is not geometry else list(product(*zip(box.min_, box.max_, strict=True)))
    return covering_capsule(np.array(corners))


def _transform(T: Floats) -> Any:
    return coal.Transform3s(T[:3, :3], T[:3, 3])


def _collide(a: Any, place_a: Any, b: Any, place_b: Any) -> bool:
    return bool(coal.collide(a, place_a, b, place_b, coal.CollisionRequest(), coal.CollisionResult()))


def _hull(shape: Any) -> Any:
    """Return the convex hull of a mesh, or the shape itself if it is not a mesh, or is flat and has no hull."""
    try:
        shape.buildConvexHull(True, "Qt")
        hull = shape.convex
        hull.computeLocalAABB()
    except (AttributeError, RuntimeError, ValueError):
        return shape
    return hull


# --- Pairs of links that a planner need not check, by the rules of MoveIt's setup assistant.
#
# Source: MoveIt Setup Assistant, "Generate Self-Collision Matrix"; moveit_setup_srdf_plugins,
# compute_default_collisions.


class Contacts(Protocol):
    """Links with shapes, and a test in how many configurations their pairs touch."""

    links: tuple[str, ...]
    pairs: tuple[LinkPair, ...]
    capsules: Capsules

    def count(self, q: Floats, pairs: set[LinkPair], *, limit: int | None = None) -> dict[LinkPair, int]:
        """Return the number of configurations (n, nq) in which the links of each pair touch, at most `limit`."""


ADJACENT, DEFAULT, ALWAYS, NEVER = "Adjacent", "Default", "Always", "Never"
# A pair that touches in more than this share of the configurations is assumed to touch always.
ALWAYS_FROM = 0.95
# Number of samples that decide on "Always", for which contacts must be counted to the end.
_COUNTED = 1000
# Configurations tested together: few, because many pairs are soon decided.
_AT_ONCE = 50


def disabled_collisions(robot: RobotModel, contacts: Contacts, *, samples: int, seed: int) -> dict[LinkPair, str]:
    """Return the pairs of links with shapes that need no collision check, and the reason.

    "Adjacent": `adjacent_links`. "Default": they touch in the start posture, or without one with every joint at zero,
    or in the middle of its range if zero is outside; or two hinges are between them, and they touch in some posture.
    "Always": they touch in more than 95 % of random configurations, at most 1000 of the samples. "Never": they touch in
    none of these, and a proof that examines at most as many configurations as there are samples shows that they touch
    nowhere within the joint limits.
    """
    adjacent = adjacent_links(robot.tree, contacts.links)
    reasons = {pair: ADJACENT for pair in contacts.pairs if pair in adjacent}
    unknown = set(contacts.pairs) - set(reasons)
    names = robot.posture_names
    postures = np.array([robot.posture(name) for name in names]).reshape(len(names), robot.nq)
    near = unknown & _two_joints_apart(robot.tree)
    for configurations, pairs in ((_default(robot)[None], unknown), (postures, near)):
        touching = contacts.count(configurations, pairs, limit=1)
        reasons |= {pair: DEFAULT for pair in pairs if touching[pair]}
    unknown -= set(reasons)

    counted = min(samples, _COUNTED)
    q, counts = robot.random(seed, counted), dict.fromkeys(unknown, 0)
    for start in range(0, counted, _AT_ONCE):
        # A pair that has touched, but too rarely for "Always", is decided.
        undecided = {
            pair for pair in unknown if not counts[pair] or counted - start + counts[pair] > ALWAYS_FROM * counted
        }
        for pair, count in contacts.count(q[start : start + _AT_ONCE], undecided).items():
            counts[pair] += count
    reasons |= {pair: ALWAYS for pair in unknown if counts[pair] > ALWAYS_FROM * counted}
    unseen = [pair for pair in unknown if not counts[pair]]
    reasons |= {pair: NEVER for pair in unseen if never_touch(robot, contacts.capsules, pair, samples)}
    return dict(sorted(reasons.items()))


def adjacent_links(tree: UrdfTree, shaped: Collection[str]) -> set[LinkPair]:
    """Return pairs of links that a joint connects directly, or across links without shapes at one point.

    The setup assistant treats any two links as adjacent if there are only links without shapes between them. With an
    upper arm without a shape, a planner could then move the forearm through the trunk.
    """
    joints_on: dict[str, list[UrdfJoint]] = defaultdict(list)
    for joint in tree.joints:
        joints_on[joint.parent].append(joint)
    pairs: set[LinkPair] = set()
    # Link → itself if it has shapes, else the links with shapes at the same point of it.
    nearest: dict[str, list[str]] = {}
    for link in reversed([tree.root, *(joint.child for joint in tree.joints)]):  # outer links first
        beyond = [nearest[joint.child] for joint in joints_on[link] if link in shaped or _at_one_point(joint)]
        if link in shaped:
            pairs |= {(min(link, other), max(link, other)) for others in beyond for other in others}
            nearest[link] = [link]
        else:
            several = combinations(beyond, 2)
            pairs |= {(min(a, b), max(a, b)) for first, second in several for a in first for b in second}
            nearest[link] = [other for others in beyond for other in others]
    return pairs


def _two_joints_apart(tree: UrdfTree) -> set[LinkPair]:
    """Return pairs of a link and the parent of its parent, both moved by hinges."""
    parents = {joint.child: joint.parent for joint in tree.joints if joint.kind == "revolute"}
    pairs = ((link, parents[parent]) for link, parent in parents.items() if parent in parents)
    return {(min(a, b), max(a, b)) for a, b in pairs}


def _at_one_point(joint: UrdfJoint) -> bool:
    """Return whether the joint's child keeps its position in the parent: the joint is at its origin, or fixed."""
    return joint.kind == "fixed" or (joint.kind == "revolute" and not any(joint.origin.xyz))


def _default(robot: RobotModel) -> Floats:
    if robot.semantics.start:
        return robot.posture(robot.semantics.start)
    values = {
        name: 0.0 if lower <= 0.0 <= upper else (lower + upper) / 2.0
        for name, lower, upper in zip(robot.joint_names, robot.lower, robot.upper, strict=True)
    }
    return robot.configuration(values, limits="ignore")
