"""Export of the SRDF that MoveIt needs in addition to a URDF."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from xml.etree import ElementTree as ET

from nao_kin._core.arrays import Floats, choice, whole_number
from nao_kin._core.text import abbreviated, fresh_name, quoted
from nao_kin.export.inertia import hosts
from nao_kin.export.pipeline import UTF_8, Destination, Exported, xml_text
from nao_kin.export.variants import Variant, joint_values, name_frames, new_names
from nao_kin.robot import LinkShapes, RobotModel
from nao_kin.robot.semantics import Posture, Semantics
from nao_kin.robot.urdf import UrdfTree

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

    Each chain is a group. If its last joints do not move the frame of an end effector, as a gripper does not move the
    hand's frame, a second group ends in that frame, because a planner solves inverse kinematics for the last link of a
    group. The rest of the effector's link is its own group: the gripper and its fingers, or fixed links.
    """

    def __init__(self, tree: UrdfTree, semantics: Semantics) -> None:
        self._tree, self._semantics = tree, semantics
        self._above = {joint.child: joint for joint in tree.joints}
        self._joints = {joint.name: joint for joint in tree.joints}
        self._bodies = hosts(tree, {joint.child for joint in tree.joints if joint.kind == "fixed"})
        self.groups: dict[str, Group] = {}
        self.end_effectors: list[EndEffector] = []
        frames = {tree.link_of(name): name for name in semantics.end_effectors}
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

    def _moving_above(self, link: str) -> tuple[str, ...]:
        return tuple(joint.name for joint in self._tree.joints_to(link) if joint.kind != "fixed")

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
            self.notes.append(f"end effector {link} is attached to {parent}, because it carries no link itself")
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
            if any(step.parent in body and step.kind != "fixed" for step in self._tree.joints_to(joint.child))
        )
        others = {joint for end, above in self._ends.items() if end != link for joint in above}
        if not path or not beyond or others & set(beyond):
            return None
        return Group(name, joints=beyond, own=self._own(beyond))

    def _holds(self, chain: tuple[str, str], link: str) -> bool:
        """Return whether a chain moves a link, which is behind the base and not beyond the tip."""
        base, tip = map(self._tree.joints_to, chain)
        return link in {joint.child for joint in tip[len(base) :]}


# --- The document.

BASES = ("fixed", "floating", "planar")
WORLD = "world"

# MoveIt, "URDF and SRDF": characters that joint names should not contain.
_TROUBLESOME = re.compile(r"[-\[\](),]")
_MAX_SAMPLES, _SEED = 1_000_000, 0
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
    overwrite: bool = False,
) -> Exported:
    """Write an SRDF: planning groups, end effectors, postures, and the collision checks that a planner may skip.

    Groups are the robot's chains, as `nk.semantics` names them, and "whole_body"; a chain whose last joint moves a
    gripper has a second group without that joint, which ends in the frame of the end effector. Postures are group
    states without mimic joints, which are passive joints. A pair of links is not checked if the two are adjacent, touch
    in the start posture, touch in more than 95 % of random configurations, or are proven to touch nowhere within the
    joint limits. A robot without chains has one group of all its joints; without collision shapes no check is skipped.

    Args:
        robot: any robot.
        path: the file.
        names: "naoqi" or "ros", as in the corresponding URDF.
        frames: "all", "effectors" or "none", as in that URDF.
        coupling: "mimic", "locked" or "independent", as in that URDF.
        base: how the root link is attached to the frame "world": "fixed", "floating" or "planar"; None for the base of
            the loaded robot.
        samples: largest number of configurations that the proof for a pair of links examines; the first 1000 random
            ones are also tested for contacts.
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
    target = Destination(path, overwrite=overwrite)
    chosen = Variant(frames, names, coupling)
    text, changes = srdf_document(robot, chosen, base=base, samples=samples)
    return target.write({"": text.encode()}, changes)


def srdf_document(
    robot: RobotModel, chosen: Variant, *, base: str | None = None, samples: int
) -> tuple[str, tuple[str, ...]]:
    """Return the text of an SRDF for a variant of the robot, and its losses; arguments and errors as `srdf`."""
    attached = robot.base if base is None else choice(base, BASES, "base")
    count = whole_number(samples, "samples", 1, _MAX_SAMPLES)
    own, _ = Variant(chosen.frames, coupling=chosen.coupling).tree_of(robot)
    tree = own if chosen.names == "naoqi" else name_frames(own, robot.semantics)[0]
    body = _as_written(robot, own)
    new = new_names(robot.semantics, chosen.names)
    effectors = tuple(new.get(name, name) for name in robot.semantics.end_effectors)
    plan = Planning(tree, replace(robot.semantics, end_effectors=effectors))
    contacts = LinkShapes.exact(body)
    reasons = contacts.found_disabled(count, _SEED)
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
    unchecked: Mapping[tuple[str, str], str],
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


def _found(contacts: LinkShapes, reasons: Mapping[tuple[str, str], str], samples: int) -> str:
    if not contacts.pairs:
        return "no two links have collision shapes: a planner finds no contacts of the robot with itself"
    counts = ", ".join(f"{count} {reason}" for reason, count in sorted(Counter(reasons.values()).items()))
    return (
        f"{len(reasons)} of {len(contacts.pairs)} pairs of links with collision shapes are not checked "
        f"({counts}; at most {samples} configurations examined for each pair)"
    )


def _losses(
    robot: RobotModel, plan: Planning, contacts: LinkShapes, unchecked: set[tuple[str, str]], new: Mapping[str, str]
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
