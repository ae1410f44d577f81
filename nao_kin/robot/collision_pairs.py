"""Pairs of links that need no check for collisions: MoveIt's rules, and proofs that two links touch nowhere."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Collection
from itertools import combinations, product

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats, cross, dot, norm
from nao_kin._kernels.hulls import between_segments
from nao_kin.robot.kinematic_robot import KinematicRobot
from nao_kin.robot.urdf import UrdfJoint, UrdfTree

# Two names in alphabetical order.
LinkPair = tuple[str, str]
# Link → capsules that contain its shapes, in its frame: the ends (2, 3) and the radius of each [m].
Capsules = dict[str, list[tuple[Floats, float]]]

# --- The rules of MoveIt's setup assistant.
#
# Source: MoveIt Setup Assistant, "Generate Self-Collision Matrix"; moveit_setup_srdf_plugins,
# compute_default_collisions.

ADJACENT, DEFAULT, ALWAYS, NEVER = "Adjacent", "Default", "Always", "Never"
# A pair that touches in more than this share of the configurations is assumed to touch always.
ALWAYS_FROM = 0.95
# Number of samples that decide on "Always", for which contacts must be counted to the end.
_COUNTED = 1000
# Configurations tested together: few, because many pairs are soon decided.
_TESTED_AT_ONCE = 50


def disabled_collisions(
    robot: KinematicRobot,
    shaped: tuple[LinkPair, ...],
    capsules: Capsules,
    count: Callable[..., dict[LinkPair, int]],
    *,
    samples: int,
    seed: int,
) -> dict[LinkPair, str]:
    """Return the pairs of links with shapes that need no collision check, and the reason.

    "Adjacent": `adjacent_links`. "Default": they touch in the start posture, or without one with every joint at zero,
    or in the middle of its range if zero is outside; or two hinges are between them, and they touch in some posture.
    "Always": they touch in more than 95 % of random configurations, at most 1000 of the samples. "Never": they touch in
    none of these, and a proof that examines at most as many configurations as there are samples shows that they touch
    nowhere within the joint limits. `shaped` are the pairs of links with shapes, `capsules` contain the shapes, and
    `count` is `LinkShapes.count`.
    """
    adjacent = adjacent_links(robot.tree, capsules)
    reasons = {pair: ADJACENT for pair in shaped if pair in adjacent}
    unknown = set(shaped) - set(reasons)
    names = robot.posture_names
    postures = np.array([robot.posture(name) for name in names]).reshape(len(names), robot.nq)
    near = unknown & _two_joints_apart(robot.tree)
    for configurations, pairs in ((_default(robot)[None], unknown), (postures, near)):
        touching = count(configurations, pairs, limit=1)
        reasons |= {pair: DEFAULT for pair in pairs if touching[pair]}
    unknown -= set(reasons)

    counted = min(samples, _COUNTED)
    q, counts = robot.random(seed, counted), dict.fromkeys(unknown, 0)
    for start in range(0, counted, _TESTED_AT_ONCE):
        # A pair that has touched, but too rarely for "Always", is decided.
        undecided = {
            pair for pair in unknown if not counts[pair] or counted - start + counts[pair] > ALWAYS_FROM * counted
        }
        for pair, times in count(q[start : start + _TESTED_AT_ONCE], undecided).items():
            counts[pair] += times
    reasons |= {pair: ALWAYS for pair in unknown if counts[pair] > ALWAYS_FROM * counted}
    unseen = [pair for pair in unknown if not counts[pair]]
    reasons |= {pair: NEVER for pair in unseen if never_touch(robot, capsules, pair, samples)}
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


def _default(robot: KinematicRobot) -> Floats:
    if robot.semantics.start:
        return robot.posture(robot.semantics.start)
    values = {
        name: 0.0 if lower <= 0.0 <= upper else (lower + upper) / 2.0
        for name, lower, upper in zip(robot.joint_names, robot.lower, robot.upper, strict=True)
    }
    return robot.configuration(values, limits="ignore")


# --- Proofs that two links touch nowhere within the joint limits: branch and bound over the ranges of the joints.

# Boxes examined at once, and corners of the first box examined before them.
_AT_ONCE, _CORNERS = 1024, 200
# Capsules nearer than this are not proven apart [m].
_ROUNDING = 1e-9


def never_touch(robot: KinematicRobot, capsules: Capsules, pair: tuple[str, str], boxes: int) -> bool:
    """Return whether it is proven that the capsules of two links touch nowhere within the joint limits.

    The ranges of the joints between the links are a box in the space of joint values. Two capsules are apart in all of
    it if, at its centre, the distance between their segments is larger than both radii and the motions of the ends
    along the normal (`_motions`). Otherwise the box is halved, across the joint that moves the ends farthest. The
    search ends without a proof if capsules touch at the centre of a box or at a corner of the first one, or after the
    given number of boxes. Coupled limits are ignored: the configurations that they exclude are examined, too.
    """
    between = _Between(robot, capsules, pair)
    low, high = between.ranges
    if not np.isfinite(high - low).all():
        return False
    corners = np.where(np.random.default_rng(0).random((_CORNERS, len(low))) < 0.5, low, high)
    if between.near(corners, np.zeros_like(corners)) is None:
        return False
    waiting = [(0.5 * (low + high)[None], 0.5 * (high - low)[None])]
    while waiting:
        centre, half = waiting.pop()
        boxes -= len(centre)
        found = between.near(centre, half) if boxes >= 0 else None
        if found is None:
            return False
        near, motions = found
        if not near.any():
            continue
        centre, half, widest = centre[near], half[near].copy(), (np.arange(near.sum()), motions[near].argmax(axis=1))
        step = np.zeros_like(half)
        half[widest] *= 0.5
        step[widest] = half[widest]
        centre, half = np.concatenate([centre - step, centre + step]), np.concatenate([half, half])
        waiting += [(centre[k : k + _AT_ONCE], half[k : k + _AT_ONCE]) for k in range(0, len(centre), _AT_ONCE)]
    return True


class _Between:
    """The joints between two links, the ranges of their coordinates, and all combinations of the links' capsules."""

    def __init__(self, robot: KinematicRobot, capsules: Capsules, pair: tuple[str, str]) -> None:
        joints = robot.joints
        a, b = joints.paths(*(robot.frame_placement(link)[0] for link in pair))
        rows = [*a, *b]
        self._robot, self._sides = robot, [(~joints.slides[side], joints.axes[side]) for side in (a, b)]
        self._links = [*(joints.links[row] for row in rows), *pair]
        coordinates, multipliers = joints.coordinates[rows] - robot.nq_base, joints.multipliers[rows]
        columns = list(dict.fromkeys(coordinates.tolist()))
        self._names = [robot.joint_names[column] for column in columns]
        # Speed of each joint over that of each coordinate.
        self._ratios = multipliers[:, None] * (coordinates[:, None] == np.array(columns, dtype=np.intp))
        low, high = robot.lower[columns], robot.upper[columns]
        turns = ~joints.slides[rows] & (np.abs(multipliers) == 1.0)
        whole = ~np.isfinite(high - low) & ~(~turns @ (self._ratios != 0.0))  # all turns of joints without limits
        self.ranges = np.where(whole, -np.pi, low), np.where(whole, np.pi, high)
        both = list(product(*(capsules[link] for link in pair)))
        self._ends = [np.array([capsule[side][0] for capsule in both]) for side in (0, 1)]
        self._radii = np.array([one[1] + other[1] for one, other in both])

    def near(self, centre: Floats, half: Floats) -> tuple[NDArray[np.bool_], Floats] | None:
        """Return which boxes may hold contacts, and how far each coordinate moves the ends; None if capsules touch.

        Boxes are given by their centres and half edges, both of shape (n, coordinates).
        """
        q = self._robot.configuration(dict(zip(self._names, centre.T, strict=True)), limits="ignore")
        T = self._robot.fk(np.broadcast_to(q, (len(centre), q.shape[-1])), self._links)
        one, other = (
            np.einsum("nij,mej->nmei", T[:, k, :3, :3], ends) + T[:, k, None, None, :3, 3]
            for k, ends in zip((-2, -1), self._ends, strict=True)
        )
        middles = one.mean(axis=2) - other.mean(axis=2)
        along = [0.5 * (ends[:, :, 1] - ends[:, :, 0]) for ends in (one, other)]
        parts = [tuple(np.moveaxis(vectors, -1, 0)) for vectors in (middles, *along)]
        normals = np.stack(between_segments(*parts), axis=-1)
        gaps = norm(normals)
        if (gaps <= self._radii).any():
            return None
        normals /= gaps[..., None]
        steps = half @ np.abs(self._ratios).T
        count = len(self._sides[0][0])
        to_a, motions_a = _motions(*self._sides[0], T[:, :count], steps[:, :count], one, normals)
        to_b, motions_b = _motions(*self._sides[1], T[:, count:-2], steps[:, count:], other, normals)
        lowest = (dot(one, normals[:, :, None]) - to_a).min(axis=-1)
        highest = (dot(other, normals[:, :, None]) + to_b).max(axis=-1)
        near = (lowest - highest - self._radii <= _ROUNDING).any(axis=1)
        return near, np.concatenate([motions_a, motions_b], axis=1) @ (self._ratios != 0.0)


def _motions(
    turns: NDArray[np.bool_], axes: Floats, T: Floats, steps: Floats, ends: Floats, normals: Floats
) -> tuple[Floats, Floats]:
    """Return bounds of the motions of points p (n, m, 2, 3) along normals (n, m, 3), if joints move by up to steps.

    Joints 1 … k are given from the first link outwards: whether they turn, their axes (k, 3) in the links that they
    move, and the poses (n, k, 4, 4) of these links. Joint j turns by up to h_j about the axis a_j through o_j. Let
    g_j = a_j × (p − o_j), and c_j = 2 sin(h_j/2) the chord. The distance of p from this axis is up to
    r_j = |g_j| + Σ_{i>j} c_i r_i, and p moves by up to Σ c_j r_j. Because ∂²p/∂q_i∂q_j = a_i × g_j for i ≤ j, it moves
    along the normal n by up to Σ |n · g_j| h_j + Σ r_j h_j (h_j/2 + Σ_{i<j} h_i). Sliding joints have g_j = a_j,
    c_j = h_j, r_j = 1, and they do not change distances from their own axes.

    Returns:
        The smaller bound for each point, shape (n, m, 2), and the largest motion by each joint, shape (n, k) [m].
    """
    axes = np.einsum("nkij,kj->nki", T[..., :3, :3], axes)[:, :, None, None]
    levers = np.where(turns[:, None, None, None], cross(axes, ends[:, None] - T[:, :, None, None, :3, 3]), axes)
    reach, moved = norm(levers), np.zeros(ends.shape[:-1])
    angles = np.where(turns, np.minimum(steps, np.pi), steps)
    chords = np.where(turns, 2.0 * np.sin(0.5 * angles), steps)[:, :, None, None]
    for j in reversed(range(len(turns))):
        reach[:, j] += moved * turns[j]
        moved = moved + chords[:, j] * reach[:, j]
    before = np.cumsum(angles * turns, axis=1) - 0.5 * angles * turns
    along = np.abs(dot(levers, normals[:, None, :, None])) + reach * before[:, :, None, None]
    along *= angles[:, :, None, None]
    return np.minimum(moved, along.sum(axis=1)), np.minimum(chords * reach, along).max(axis=(2, 3))
