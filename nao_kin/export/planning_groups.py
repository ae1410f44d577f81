"""Groups of joints and end effectors for MoveIt, from the chains and effectors of a robot's semantics."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from nao_kin._common.free_names import fresh_name
from nao_kin.semantics import Semantics
from nao_kin.urdf import UrdfJoint, UrdfTree


@dataclass(frozen=True)
class Group:
    """A planning group.

    Attributes:
        name: its name.
        chain: base link and tip link of a chain, None for a group of other kinds.
        joints: further joints.
        links: further links, each with the joint that holds it.
        groups: groups that it holds.
        own: the joints with a value of their own in it, in the order of the URDF.
    """

    name: str
    chain: tuple[str, str] | None = None
    joints: tuple[str, ...] = ()
    links: tuple[str, ...] = ()
    groups: tuple[str, ...] = ()
    own: tuple[str, ...] = ()


@dataclass(frozen=True)
class EndEffector:
    """An end effector.

    Attributes:
        name: its name.
        parent_link: the link it is attached to, which its group must not contain.
        group: the group of what it consists of.
        parent_group: the group that moves the parent link; "" without one.
    """

    name: str
    parent_link: str
    group: str
    parent_group: str


@dataclass(frozen=True)
class Planning:
    """Groups and end effectors of a robot, the group of all joints first; and one line for what cannot be said."""

    groups: tuple[Group, ...]
    end_effectors: tuple[EndEffector, ...]
    notes: tuple[str, ...]


def planning(tree: UrdfTree, semantics: Semantics) -> Planning:
    """Groups and end effectors for a robot.

    Each chain is a group of its name. Where the frame of an end effector is moved by all but the last joints of a
    chain, as a hand's frame is by the arm without its gripper, a second group ends in that frame: the inverse
    kinematics of a planner is asked for the last link of a group. What else hangs on the link of the effector is the
    effector's own group: the gripper and its fingers, or the fixed links there.
    """
    return _Planner(tree, semantics).planning()


class _Planner:
    def __init__(self, tree: UrdfTree, semantics: Semantics) -> None:
        self.tree, self.semantics = tree, semantics
        self.above = {joint.child: joint for joint in tree.joints}
        self.joints = {joint.name: joint for joint in tree.joints}
        self.groups: dict[str, Group] = {}
        self.effectors: list[EndEffector] = []
        # End effector → the moving joints between the root and it.
        self.ends: dict[str, tuple[str, ...]] = {}
        self.notes: list[str] = []

    def planning(self) -> Planning:
        frames = {self._link(name): name for name in self.semantics.end_effectors}
        self.ends = {link: self._moving_above(link) for link in frames if link in self.tree.links}
        lacking = [name for link, name in frames.items() if link not in self.tree.links]
        self.notes += [f"end effector {name} is left out: the URDF has no such link" for name in lacking]
        for name, joints in self.semantics.chains.items():
            moving = tuple(joint for joint in joints if joint in self.joints and self.joints[joint].kind != "fixed")
            if moving:
                self._chain(name, moving)
            else:
                self.notes.append(f"chain {name} is left out: none of its joints moves")
        whole = self._whole() if self.tree.moving_joints else None
        for link, path in self.ends.items():
            self._effector(link, path)
        groups = (*((whole,) if whole else ()), *self.groups.values())
        return Planning(groups, tuple(self.effectors), tuple(self.notes))

    def _link(self, frame: str) -> str:
        """The link of a frame: of a joint's, the link that it moves."""
        frame = self.tree.shared_names.get(frame, frame)
        return self.joints[frame].child if frame in self.joints and frame not in self.tree.links else frame

    def _path(self, link: str) -> list[UrdfJoint]:
        """The joints from the root to a link."""
        path = []
        while link in self.above:
            path.append(self.above[link])
            link = self.above[link].parent
        return path[::-1]

    def _moving_above(self, link: str) -> tuple[str, ...]:
        return tuple(joint.name for joint in self._path(link) if joint.kind != "fixed")

    def _own(self, joints: Iterable[str]) -> tuple[str, ...]:
        named = set(joints)
        return tuple(joint.name for joint in self.tree.moving_joints if joint.name in named and joint.mimic is None)

    def _chain(self, name: str, joints: tuple[str, ...]) -> None:
        base, last = self.joints[joints[0]].parent, self.joints[joints[-1]].child
        before = self._moving_above(base)
        if self._moving_above(last) != (*before, *joints):
            # Joints beside each other, or with a joint between them that the chain leaves out.
            self.groups[name] = Group(name, joints=joints, own=self._own(joints))
            return
        tips = [link for link, path in self.ends.items() if path == (*before, *joints)]
        self.groups[name] = Group(name, chain=(base, tips[0] if tips else last), own=self._own(joints))
        for link, path in self.ends.items():
            part = path[len(before) :]
            inside = path[: len(before)] == before and 0 < len(part) < len(joints) and part == joints[: len(part)]
            if inside and part not in self.semantics.chains.values():
                within = self._fresh(f"{name}_without_{'_'.join(joints[len(part) :])}")
                self.groups[within] = Group(within, chain=(base, link), own=self._own(part))

    def _whole(self) -> Group:
        """All joints: the chains as groups, and what is in none of them."""
        chains = tuple(name for name in self.groups if name in self.semantics.chains)
        inside = {joint for name in chains for joint in self.semantics.chains[name]}
        rest = tuple(joint.name for joint in self.tree.moving_joints if joint.name not in inside)
        own = self._own(joint.name for joint in self.tree.moving_joints)
        return Group(self._fresh("whole_body"), joints=rest, groups=chains, own=own)

    def _fresh(self, name: str) -> str:
        return fresh_name(name, {*self.groups, *self.semantics.chains})

    def _effector(self, link: str, path: tuple[str, ...]) -> None:
        parent, name = link, self._fresh(f"{link}_effector".replace("/", "_"))
        group = self._gripper(link, path, name) or self._fixed_beyond(link, name)
        if group is None:
            held = self.above.get(link)
            if held is None or held.kind != "fixed":
                self.notes.append(f"end effector {link} is left out: nothing is attached to that link")
                return
            # The frame is a last one: it is itself what is attached.
            group, parent = Group(name, links=(link,)), held.parent
            self.notes.append(f"end effector {link} is attached to {parent}: nothing else is there")
        self.groups[name] = group
        holding = [g for g in self.groups.values() if g.chain is not None and parent in self._links(g.chain)]
        fewest = min(holding, key=lambda g: len(g.own), default=None)
        self.effectors.append(EndEffector(link.replace("/", "_"), parent, name, fewest.name if fewest else ""))

    def _gripper(self, link: str, path: tuple[str, ...], name: str) -> Group | None:
        """The moving joints outwards of the body that an end effector is part of, if they move no other effector."""
        body = self._body(link)
        beyond = tuple(
            joint.name
            for joint in self.tree.moving_joints
            if any(step.parent in body and step.kind != "fixed" for step in self._path(joint.child))
        )
        others = {joint for end, above in self.ends.items() if end != link for joint in above}
        if not path or not beyond or others & set(beyond):
            return None
        return Group(name, joints=beyond, own=self._own(beyond))

    def _fixed_beyond(self, link: str, name: str) -> Group | None:
        held = tuple(joint.child for joint in self.tree.joints if joint.parent == link and joint.kind == "fixed")
        return Group(name, links=held) if held else None

    def _body(self, link: str) -> set[str]:
        """The links that are fixed to a link."""
        while link in self.above and self.above[link].kind == "fixed":
            link = self.above[link].parent
        body = {link}
        for joint in self.tree.joints:  # parents come before children
            if joint.kind == "fixed" and joint.parent in body:
                body.add(joint.child)
        return body

    def _links(self, chain: tuple[str, str]) -> set[str]:
        base, link = chain
        found = set()
        while link != base:
            found.add(link)
            link = self.above[link].parent
        return found
