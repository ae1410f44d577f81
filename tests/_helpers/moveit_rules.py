"""MoveIt's rules for an SRDF; each message names the part that breaks a rule.

Sources: "URDF and SRDF" and "MoveIt Setup Assistant" (moveit.picknik.ai, main); what srdfdom calls an error
(moveit/srdfdom, src/model.cpp); what the robot model reports on building groups, states and end effectors
(moveit/moveit2, moveit_core/robot_model); what the setup assistant refuses to save (end_effectors_widget).
"""

from __future__ import annotations

from xml.etree import ElementTree as ET

from nao_kin.robot.urdf import UrdfTree

REASONS = ("Adjacent", "Default", "Always", "Never", "User")


def violations(text: str, tree: UrdfTree) -> list[str]:
    """Return every rule that an SRDF breaks, given its URDF; an empty list for a valid one."""
    return _Checker(ET.fromstring(text), tree).violations()


class _Checker:
    def __init__(self, root: ET.Element, tree: UrdfTree) -> None:
        self.root, self.tree = root, tree
        self.links, self.found = set(tree.links), list[str]()
        self.joints = {joint.name: joint for joint in tree.joints}
        self.above = {joint.child: joint for joint in tree.joints}
        self.virtual = {element.get("name") for element in root.findall("virtual_joint")}
        self.groups = {element.get("name", ""): element for element in root.findall("group")}

    def violations(self) -> list[str]:
        self.need(self.root.tag == "robot", "the root element is <robot>")
        self.need(self.root.get("name") == self.tree.name, "the SRDF is of the robot that the URDF is of")
        self.need(len(self.groups) == len(self.root.findall("group")), "a group of a name is there once")
        for name, group in self.groups.items():
            self.check_group(name, group)
        for element in self.root.findall("group_state"):
            self.check_state(element)
        for element in self.root.findall("end_effector"):
            self.check_end_effector(element)
        for element in self.root.findall("virtual_joint"):
            self.check_virtual_joint(element)
        for element in self.root.findall("passive_joint"):
            self.need(
                element.get("name") in {*self.joints, *self.virtual}, f"passive joint {element.get('name')} is known"
            )
        self.check_disabled()
        return self.found

    def need(self, holds: bool, rule: str) -> None:
        if not holds:
            self.found.append(rule)

    def check_group(self, name: str, group: ET.Element) -> None:
        self.need(bool(name), "a group has a name")
        for element in group:
            known = {"link": self.links, "joint": {*self.joints, *self.virtual}, "group": self.groups}
            if element.tag == "chain":
                base, tip = element.get("base_link", ""), element.get("tip_link", "")
                self.need({base, tip} <= self.links, f"group {name}: both ends of a chain are links")
                self.need(base in self.carriers(tip), f"group {name}: {base} and {tip} are ends of a chain")
            else:
                self.need(element.get("name") in known[element.tag], f"group {name}: {element.get('name')} is known")
        self.need(bool(self.members(name)), f"group {name} has at least one joint")

    def carriers(self, link: str) -> list[str]:
        found = []
        while link in self.above:
            link = self.above[link].parent
            found.append(link)
        return found

    def members(self, name: str, inside: tuple[str, ...] = ()) -> set[str]:
        """The joints of a group."""
        if name in inside or name not in self.groups:
            return set()
        joints: set[str] = set()
        for element in self.groups[name]:
            member = element.get("name", "")
            if element.tag == "joint":
                joints.add(member)
            elif element.tag == "link" and member in self.above:
                joints.add(self.above[member].name)
            elif element.tag == "group":
                joints |= self.members(member, (*inside, name))
            elif element.tag == "chain":
                link = element.get("tip_link", "")
                while link != element.get("base_link") and link in self.above:
                    joints.add(self.above[link].name)
                    link = self.above[link].parent
        return joints

    def member_links(self, name: str) -> set[str]:
        return {self.joints[joint].child for joint in self.members(name) if joint in self.joints}

    def check_state(self, state: ET.Element) -> None:
        what, group = f"state {state.get('name')} of {state.get('group')}", state.get("group", "")
        self.need(bool(state.get("name")) and group in self.groups, f"{what}: it has a name and a known group")
        named = [element.get("name", "") for element in state.findall("joint")]
        members = self.members(group)
        active = {
            name
            for name in members & set(self.joints)
            if self.joints[name].kind != "fixed" and self.joints[name].mimic is None
        }
        self.need(set(named) <= members, f"{what}: its joints are in the group")
        self.need(active <= set(named), f"{what}: no active joint of the group is left out")
        self.need(len(set(named)) == len(named), f"{what}: a joint is named once")
        self.need(not {*named} & {*self.tree.mimics}, f"{what}: joints that follow are left out")
        for element in state.findall("joint"):
            self.need(len(element.get("value", "").split()) == 1, f"{what}: {element.get('name')} has one value")

    def check_end_effector(self, element: ET.Element) -> None:
        what, parent = f"end effector {element.get('name')}", element.get("parent_link", "")
        group, parent_group = element.get("group", ""), element.get("parent_group", "")
        self.need(bool(element.get("name")) and group in self.groups, f"{what}: it has a name and a known group")
        self.need(parent in self.links, f"{what}: its parent link is known")
        self.need(parent not in self.member_links(group), f"{what}: its parent link is not in its own group")
        if parent_group:
            self.need(parent_group in self.groups, f"{what}: its parent group is known")
            self.need(parent_group != group, f"{what}: its group is not its parent group")
            self.need(parent in self.member_links(parent_group), f"{what}: its parent group has its parent link")

    def check_virtual_joint(self, element: ET.Element) -> None:
        self.need(element.get("type") in ("fixed", "floating", "planar"), "the virtual joint has a known type")
        self.need(element.get("child_link") == self.tree.root, "the virtual joint holds the root link")
        self.need(bool(element.get("parent_frame")), "the virtual joint has a parent frame")
        self.need(
            bool(element.get("name")) and element.get("name") not in self.joints, "the virtual joint has a fresh name"
        )

    def check_disabled(self) -> None:
        seen = set()
        shaped = {collision.link for collision in self.tree.collisions}
        for element in self.root.findall("disable_collisions"):
            pair = (element.get("link1", ""), element.get("link2", ""))
            self.need(set(pair) <= self.links, f"disabled pair {pair}: both links are known")
            self.need(set(pair) <= shaped, f"disabled pair {pair}: both links have shapes")
            self.need(pair[0] != pair[1] and frozenset(pair) not in seen, f"disabled pair {pair} is there once")
            self.need(element.get("reason") in REASONS, f"disabled pair {pair}: MoveIt knows the reason")
            seen.add(frozenset(pair))
