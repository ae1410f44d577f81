"""Export of the SRDF that MoveIt needs in addition to a URDF."""

from __future__ import annotations

import functools
import re
from collections import Counter, defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations, product
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import coal
import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats, choice, whole_number
from nao_kin._core.text import abbreviated, fresh_name, quoted
from nao_kin.export.inertia import hosts
from nao_kin.export.pipeline import UTF_8, Exported, Target, xml_text
from nao_kin.export.variants import Variant, joint_values, link_of, name_frames, named_semantics, new_names
from nao_kin.robot import RobotModel, shape_geometry
from nao_kin.robot.semantics import Posture, Semantics
from nao_kin.robot.urdf import UnreadableShape, UrdfJoint, UrdfTree

# --- Groups of joints and end effectors for MoveIt, from the chains and effectors of a robot's semantics.


@dataclass(frozen=True)
class Group:
    """A planning group."""

    name: str
    chain: tuple[str, str] | None = None  # base link and tip link; None for a group that is not a chain
    joints: tuple[str, ...] = ()
    links: tuple[str, ...] = ()  # each with the joint that attaches it
    groups: tuple[str, ...] = ()  # the groups that it contains
    own: tuple[str, ...] = ()  # its joints with their own values, in the order of the URDF


@dataclass(frozen=True)
class EndEffector:
    """An end effector."""

    name: str
    parent_link: str  # the link to which it is attached, which its group must not contain
    group: str  # the group of its own joints and links
    parent_group: str  # the group that moves the parent link; "" without one


class Planning:
    """Groups and end effectors of a robot; `groups` starts with the group of all joints, `notes` names losses.

    Each chain is a group with its name. If the joints of a chain without the last ones move the frame of an end
    effector, as the arm without its gripper moves the hand's frame, a second group ends in that frame, because a
    planner solves inverse kinematics for the last link of a group. The rest of the effector's link is its own group:
    the gripper and its fingers, or fixed links.
    """

    def __init__(self, tree: UrdfTree, semantics: Semantics) -> None:
        self._tree, self._semantics = tree, semantics
        self._above = {joint.child: joint for joint in tree.joints}
        self._joints = {joint.name: joint for joint in tree.joints}
        self._bodies = hosts(tree, {joint.child for joint in tree.joints if joint.kind == "fixed"})
        self.groups: dict[str, Group] = {}
        self.end_effectors: list[EndEffector] = []
        frames = {link_of(tree, name): name for name in semantics.end_effectors}
        # End effector → the moving joints between the root and it.
        self._ends = {link: self._moving_above(link) for link in frames if link in tree.links}
        lacking = [name for link, name in frames.items() if link not in tree.links]
        self.notes = [f"end effector {name} is left out: the URDF has no such link" for name in lacking]
        for name, joints in semantics.chains.items():
            moving = tuple(joint for joint in joints if joint in self._joints and self._joints[joint].kind != "fixed")
            if moving:
                self._add_chain(name, moving)
            else:
                self.notes.append(f"chain {name} is left out: none of its joints moves")
        if tree.moving_joints:
            whole = self._whole()
            self.groups = {whole.name: whole, **self.groups}
        for link, path in self._ends.items():
            self._add_effector(link, path)

    def _path(self, link: str) -> list[UrdfJoint]:
        """Return the joints from the root to a link."""
        path = []
        while link in self._above:
            path.append(self._above[link])
            link = self._above[link].parent
        return path[::-1]

    def _moving_above(self, link: str) -> tuple[str, ...]:
        return tuple(joint.name for joint in self._path(link) if joint.kind != "fixed")

    def _own(self, joints: Iterable[str]) -> tuple[str, ...]:
        named = set(joints)
        return tuple(joint.name for joint in self._tree.moving_joints if joint.name in named and joint.mimic is None)

    def _add_chain(self, name: str, joints: tuple[str, ...]) -> None:
        base, last = self._joints[joints[0]].parent, self._joints[joints[-1]].child
        before = self._moving_above(base)
        if self._moving_above(last) != (*before, *joints):
            # The joints are on different branches, or the chain leaves out a joint between them.
            self.groups[name] = Group(name, joints=joints, own=self._own(joints))
            return
        tips = [link for link, path in self._ends.items() if path == (*before, *joints)]
        self.groups[name] = Group(name, chain=(base, tips[0] if tips else last), own=self._own(joints))
        for link, path in self._ends.items():
            part = path[len(before) :]
            inside = path[: len(before)] == before and 0 < len(part) < len(joints) and part == joints[: len(part)]
            if inside and part not in self._semantics.chains.values():
                within = self._fresh(f"{name}_without_{'_'.join(joints[len(part) :])}")
                self.groups[within] = Group(within, chain=(base, link), own=self._own(part))

    def _whole(self) -> Group:
        """Return the group of all joints: the chains as groups, and the joints in none of them."""
        chains = tuple(name for name in self.groups if name in self._semantics.chains)
        inside = {joint for name in chains for joint in self._semantics.chains[name]}
        rest = tuple(joint.name for joint in self._tree.moving_joints if joint.name not in inside)
        own = self._own(joint.name for joint in self._tree.moving_joints)
        return Group(self._fresh("whole_body"), joints=rest, groups=chains, own=own)

    def _fresh(self, name: str) -> str:
        return fresh_name(name, {*self.groups, *self._semantics.chains})

    def _add_effector(self, link: str, path: tuple[str, ...]) -> None:
        parent, name = link, self._fresh(f"{link}_effector".replace("/", "_"))
        group = self._gripper(link, path, name)
        links = tuple(joint.child for joint in self._tree.joints if joint.parent == link and joint.kind == "fixed")
        if group is None and links:
            group = Group(name, links=links)
        elif group is None:
            joint = self._above.get(link)
            if joint is None or joint.kind != "fixed":
                self.notes.append(f"end effector {link} is left out: nothing is attached to that link")
                return
            # A frame at the end of its branch is itself the end effector.
            group, parent = Group(name, links=(link,)), joint.parent
            self.notes.append(f"end effector {link} is attached to {parent}: nothing else is there")
        self.groups[name] = group
        holding = [other for other in self.groups.values() if other.chain and self._holds(other.chain, parent)]
        fewest = min(holding, key=lambda other: len(other.own), default=None)
        self.end_effectors.append(EndEffector(link.replace("/", "_"), parent, name, fewest.name if fewest else ""))

    def _gripper(self, link: str, path: tuple[str, ...], name: str) -> Group | None:
        """Return the moving joints beyond the body of an end effector, if they move no other effector."""
        body = {other for other, (host, _) in self._bodies.items() if host == self._bodies[link][0]}
        beyond = tuple(
            joint.name
            for joint in self._tree.moving_joints
            if any(step.parent in body and step.kind != "fixed" for step in self._path(joint.child))
        )
        others = {joint for end, above in self._ends.items() if end != link for joint in above}
        if not path or not beyond or others & set(beyond):
            return None
        return Group(name, joints=beyond, own=self._own(beyond))

    def _holds(self, chain: tuple[str, str], link: str) -> bool:
        """Return whether a chain moves a link, which is behind the base and not beyond the tip."""
        base, tip = map(self._path, chain)
        return link in {joint.child for joint in tip[len(base) :]}


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
            placements.append(collision.origin.matrix)
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
            if limit is not None and counts[pair] >= limit:
                continue
            for sample in samples[~self._separate(a, b, T_root_shape[samples])].tolist():
                if (limit is not None and counts[pair] >= limit) or (pair, sample) in seen:
                    continue
                if self._touch(a, place(sample, a), b, place(sample, b)):
                    seen.add((pair, sample))
                    counts[pair] += 1
        return counts

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

ADJACENT, DEFAULT, ALWAYS, NEVER = "Adjacent", "Default", "Always", "Never"
# A pair that touches in more than this share of the configurations is assumed to touch always.
ALWAYS_FROM = 0.95
# Number of samples that decide on "Always", for which contacts must be counted to the end.
_COUNTED = 1000
# Configurations tested together: few at first, because many pairs are soon decided.
_AT_ONCE, _REST_AT_ONCE = 50, 500


def disabled_collisions(robot: RobotModel, contacts: LinkContacts, *, samples: int, seed: int) -> dict[LinkPair, str]:
    """Return the pairs of links with shapes that need no collision check, and the reason.

    "Adjacent": `adjacent_links`. "Default": they touch in the start posture, or without one with every joint at zero,
    or in the middle of its range if zero is outside. "Always": they touch in more than 95 % of `samples` random
    configurations inside the limits. "Never": they touch in none of them, and in no posture.
    """
    adjacent = adjacent_links(robot.tree, contacts.links)
    reasons = {pair: ADJACENT for pair in contacts.pairs if pair in adjacent}
    unknown = set(contacts.pairs) - set(reasons)
    touching = contacts.count(_default(robot)[None], unknown)
    reasons |= {pair: DEFAULT for pair in unknown if touching[pair]}
    unknown -= set(reasons)

    q, counts = robot.random(seed, samples), dict.fromkeys(unknown, 0)
    counted = min(samples, _COUNTED)
    for start in range(0, counted, _AT_ONCE):
        # A pair that has touched, but too rarely for "Always", is decided.
        undecided = {
            pair for pair in unknown if not counts[pair] or counted - start + counts[pair] > ALWAYS_FROM * counted
        }
        for pair, count in contacts.count(q[start : min(start + _AT_ONCE, counted)], undecided).items():
            counts[pair] += count
    reasons |= {pair: ALWAYS for pair in unknown if counts[pair] > ALWAYS_FROM * counted}
    rest = np.array([*(robot.posture(name) for name in robot.posture_names), *q[counted:]])
    unseen = {pair for pair in unknown if not counts[pair]}
    for start in range(0, len(rest), _REST_AT_ONCE):
        touching = contacts.count(rest[start : start + _REST_AT_ONCE], unseen, limit=1)
        unseen = {pair for pair in unseen if not touching[pair]}
    return dict(sorted((reasons | dict.fromkeys(unseen, NEVER)).items()))


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


# --- The document.

BASES = ("fixed", "floating", "planar")
WORLD = "world"

# MoveIt, "URDF and SRDF": characters that joint names should not contain.
_TROUBLESOME = re.compile(r"[-\[\](),]")
_MAX_SAMPLES = 1_000_000
# Names of groups become names of parameters.
_PARAMETER = re.compile(r"[A-Za-z]\w*", re.ASCII)


def srdf(
    robot: RobotModel,
    path: Path | str,
    *,
    names: str = "naoqi",
    frames: str = "all",
    coupling: str = "mimic",
    base: str | None = None,
    samples: int = 10_000,
    seed: int = 0,
    overwrite: bool = False,
) -> Exported:
    """Write an SRDF: planning groups, end effectors, postures, and the collision checks that a planner may skip.

    Groups are the robot's chains, as `nk.semantics` names them, and "whole_body"; a chain whose last joint moves a
    gripper has a second group without it, which ends in the frame of the end effector. Postures are group states
    without mimic joints, which are passive joints. A pair of links is not checked if the two are adjacent, touch in the
    start posture, touch in more than 95 % of the tested configurations, or in none of them. A robot without chains has
    one group of all its joints; without collision shapes no check is skipped.

    Args:
        robot: any robot.
        path: the file.
        names: "naoqi" or "ros", as in the corresponding URDF.
        frames: "all", "effectors" or "none", as in that URDF.
        coupling: "mimic", "locked" or "independent", as in that URDF.
        base: how the root link is attached to the frame "world": "fixed", "floating" or "planar"; None for the base of
            the loaded robot.
        samples: number of configurations tested for contacts.
        seed: seed of the random configurations; the same seed gives the same file.
        overwrite: replace an existing file.

    Returns:
        The file, and one line for each property of the robot that an SRDF cannot express.

    Raises:
        BadArgument: the robot has no ROS names, or the file exists.

    Examples:
        >>> nao = nk.load_nao("v6")
        >>> done = nk.export.srdf(nao, "nao.srdf", samples=100)
        >>> again = nk.RobotModel.from_urdf(nao.urdf_path, semantics="nao.srdf")
        >>> again.chains["LLeg"] == nao.chains["LLeg"], again.posture_names == nao.posture_names
        (True, True)
    """
    target = Target(robot, path, overwrite=overwrite)
    chosen = Variant(frames, names, coupling)
    text, changes = srdf_document(robot, chosen, base=base, samples=samples, seed=seed)
    return target.write({"": text.encode()}, changes)


def srdf_document(
    robot: RobotModel, chosen: Variant, *, base: str | None = None, samples: int = 10_000, seed: int = 0
) -> tuple[str, tuple[str, ...]]:
    """Return the text of an SRDF for a variant of the robot, and its losses; arguments and errors as `srdf`."""
    attached = robot.base if base is None else choice(base, BASES, "base")
    count = whole_number(samples, "samples", 1, _MAX_SAMPLES)
    own, _ = Variant(chosen.frames, coupling=chosen.coupling).tree_of(robot)
    tree = own if chosen.names == "naoqi" else name_frames(own, robot.semantics)[0]
    body = _as_written(robot, own)
    plan = Planning(tree, named_semantics(robot.semantics, chosen.names))
    contacts = LinkContacts(body)
    reasons = disabled_collisions(body, contacts, samples=count, seed=whole_number(seed, "seed", 0))
    new = new_names(robot.semantics, chosen.names)
    unchecked = {(new.get(a, a), new.get(b, b)): reason for (a, b), reason in reasons.items()}
    states = {name: joint_values(robot, robot.posture(name), chosen.names) for name in robot.posture_names}
    root = _robot(tree, states, plan, unchecked, attached)
    notes = (
        *plan.notes,
        *contacts.notes,
        _found(contacts, reasons, count),
        *_losses(body, plan, contacts, set(reasons), new),
    )
    return xml_text(root, UTF_8), notes


def _as_written(robot: RobotModel, tree: UrdfTree) -> RobotModel:
    """Return the robot of a variant's tree, with the postures and limits that the contact tests need."""
    own = {joint.name for joint in tree.moving_joints if joint.mimic is None}
    values = {name: joint_values(robot, robot.posture(name)) for name in robot.posture_names}
    postures = {name: Posture({joint: float(q[joint]) for joint in own}) for name, q in values.items()}
    limits = tuple(table for table in robot.coupled_limits if {table.joint, table.of} <= own)
    meaning = Semantics(postures=postures, start=robot.semantics.start, coupled_limits=limits)
    return RobotModel(tree, meaning, base=robot.base)


def _robot(
    tree: UrdfTree,
    states: Mapping[str, Mapping[str, Floats]],
    plan: Planning,
    unchecked: Mapping[LinkPair, str],
    attached: str,
) -> ET.Element:
    root = ET.Element("robot", name=tree.name)
    root.append(ET.Comment(" Written by nao_kin; the URDF of the same name has the links and joints. "))
    for group in plan.groups.values():
        element = ET.SubElement(root, "group", name=group.name)
        if group.chain is not None:
            ET.SubElement(element, "chain", base_link=group.chain[0], tip_link=group.chain[1])
        for tag, names in (("joint", group.joints), ("link", group.links), ("group", group.groups)):
            for name in names:
                ET.SubElement(element, tag, name=name)
    # First, because Pinocchio keeps the first state of each name.
    for group, (name, values) in product(plan.groups.values(), states.items()):
        if group.own:
            state = ET.SubElement(root, "group_state", name=name, group=group.name)
            for joint in group.own:
                ET.SubElement(state, "joint", name=joint, value=repr(float(values[joint])))
    for effector in plan.end_effectors:
        written = {name: text for name, text in vars(effector).items() if text}
        ET.SubElement(root, "end_effector", written)
    virtual = fresh_name("virtual_joint", {joint.name for joint in tree.joints})
    ET.SubElement(root, "virtual_joint", name=virtual, type=attached, parent_frame=WORLD, child_link=tree.root)
    for follower in tree.mimics:
        ET.SubElement(root, "passive_joint", name=follower)
    for (first, second), reason in unchecked.items():
        ET.SubElement(root, "disable_collisions", link1=first, link2=second, reason=reason)
    return root


def _found(contacts: LinkContacts, reasons: Mapping[LinkPair, str], samples: int) -> str:
    if not contacts.pairs:
        return "no two links have collision shapes: a planner finds no contacts of the robot with itself"
    counts = ", ".join(f"{count} {reason}" for reason, count in sorted(Counter(reasons.values()).items()))
    return (
        f"{len(reasons)} of {len(contacts.pairs)} pairs of links with collision shapes are not checked "
        f"({counts}; {samples} configurations tried)"
    )


def _losses(
    robot: RobotModel, plan: Planning, contacts: LinkContacts, unchecked: set[LinkPair], new: Mapping[str, str]
) -> list[str]:
    """Return one line for each property that a planner does not know, or refuses."""
    lines = []
    if robot.coupled_limits:
        names = ", ".join(dict.fromkeys(table.joint for table in robot.coupled_limits))
        lines.append(f"coupled limits are left out, because a planner has one range for each joint: {names}")
    checked = set(contacts.pairs) - unchecked
    for name in robot.posture_names:
        touching = contacts.count(robot.posture(name)[None], checked)
        pairs = ", ".join(f"{new.get(a, a)} and {new.get(b, b)}" for (a, b), count in touching.items() if count)
        if pairs:
            lines.append(f"in posture {quoted(name)} checked shapes touch, so no plan can start there: {pairs}")
    for group in plan.groups:
        if not _PARAMETER.fullmatch(group):
            lines.append(f"group {quoted(group)} is not a valid name of a ROS parameter: letters, digits and _")
    joints = [joint.name for joint in robot.tree.moving_joints if _TROUBLESOME.search(joint.name)]
    if joints:
        lines.append(f"MoveIt warns of the characters in {len(joints)} names of joints, first {quoted(joints[0])}")
    return [abbreviated(line, 400) for line in lines]
