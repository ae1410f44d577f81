"""Semantics from an SRDF, the file that MoveIt keeps beside a URDF: groups, end effectors, group states."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree as ET

from nao_kin._common.scalars import decimal
from nao_kin._text import abbreviated, quoted
from nao_kin.errors import BadArgument, BadModel
from nao_kin.semantics import Posture, Semantics
from nao_kin.urdf.document import file_content, read_document
from nao_kin.urdf.tree import UrdfJoint, UrdfTree


def read_srdf(path: Path | str, tree: UrdfTree, notes: list[str]) -> Semantics:
    """Chains, end effectors and postures of an SRDF.

    A group is a chain when its moving joints lie one behind the other. A group state is a posture; states of one name
    for several groups are one posture. An SRDF often serves several variants of a robot: what this one does not have
    is left out with a note, and so is the value of a floating base.

    Args:
        path: the SRDF file.
        tree: the robot's URDF as read.
        notes: gets a line for what was left out.

    Raises:
        BadModel: the file cannot be read or is no SRDF.
        BadArgument: no tree, or no list.

    Examples:
        >>> tree = nk.urdf.read_urdf(nk.load_nao().urdf_path)
        >>> from pathlib import Path
        >>> neck = "<group name='neck'><chain base_link='torso' tip_link='Head'/></group>"
        >>> _ = Path("nao.srdf").write_text(f"<robot name='nao'>{neck}</robot>")
        >>> nk.urdf.read_srdf("nao.srdf", tree, notes=[]).chains["neck"]
        ('HeadYaw', 'HeadPitch')
    """
    if not isinstance(tree, UrdfTree):
        raise BadArgument(f"tree must be a UrdfTree, got {quoted(tree)}")
    if not isinstance(notes, list):
        raise BadArgument(f"notes must be a list, got {quoted(notes)}")
    document, _ = read_document(path, file_content(path), notes)
    if document.tag != "robot":
        raise BadModel(f"{path}: the root element is <{abbreviated(document.tag)}>, an SRDF has <robot>")
    reader = _Groups(document, tree)
    ends = [reader.link(element.get("parent_link", "")) for element in document.findall("end_effector")]
    semantics = Semantics(
        chains=reader.chains(),
        end_effectors=tuple(dict.fromkeys(end for end in ends if end in tree.links)),
        postures=_postures(document, tree, reader.missing),
    )
    missing = dict.fromkeys([*reader.missing, *(end for end in ends if end not in tree.links)])
    if missing:
        names = abbreviated(", ".join(missing), 100)
        notes.append(f"{Path(path).name} names {len(missing)} joints and links that the robot does not have: {names}")
    return semantics


class _Groups:
    """The groups of joints of an SRDF.

    Attributes:
        missing: joints and links it names and the robot does not have.
    """

    def __init__(self, document: ET.Element, tree: UrdfTree) -> None:
        self.missing: list[str] = []
        self._elements: Mapping[str, ET.Element] = {
            element.get("name", ""): element for element in document.findall("group")
        }
        self._joints = {joint.name: joint for joint in tree.joints}
        self._above = {joint.child: joint for joint in tree.joints}
        self._links = set(tree.links)
        self._renamed = tree.shared_names
        self._order = {joint.name: index for index, joint in enumerate(tree.joints)}

    def chains(self) -> dict[str, tuple[str, ...]]:
        """Group → its moving joints from the root outwards, where they lie one behind the other."""
        found = {}
        for name, element in self._elements.items():
            members = {joint.name for joint in self._members(element, (name,)) if joint.kind != "fixed"}
            ordered = sorted(members, key=self._order.__getitem__)
            if ordered and members <= {joint.name for joint in self._path(self._joints[ordered[-1]].child, "")}:
                found[name] = tuple(ordered)
        return found

    def link(self, name: str) -> str:
        """The name here of a link that the files call `name`: another one where a joint has that name, too."""
        return self._renamed.get(name, name)

    def _members(self, group: ET.Element, inside: tuple[str, ...]) -> list[UrdfJoint]:
        members: list[UrdfJoint] = []
        for element in group:
            name = element.get("name", "")
            if element.tag == "joint":
                members += self._known(name, self._joints)
            elif element.tag == "link":
                members += self._known(self.link(name), self._above)
            elif element.tag == "chain":
                members += self._path(self.link(element.get("tip_link", "")), self.link(element.get("base_link", "")))
            elif element.tag == "group" and name in self._elements and name not in inside:
                members += self._members(self._elements[name], (*inside, name))
        return members

    def _known(self, name: str, joints: Mapping[str, UrdfJoint]) -> list[UrdfJoint]:
        if name in joints:
            return [joints[name]]
        if name not in self._links:  # the root link is known and has no joint
            self.missing.append(name)
        return []

    def _path(self, tip: str, base: str) -> list[UrdfJoint]:
        """The joints from the tip back to the base link; to the root where the base does not carry the tip."""
        self.missing += [name for name in (tip, base) if name and name not in self._links]
        path = []
        while tip in self._above and tip != base:
            path.append(self._above[tip])
            tip = self._above[tip].parent
        return path


def _postures(document: ET.Element, tree: UrdfTree, missing: list[str]) -> dict[str, Posture]:
    moving = {joint.name: joint for joint in tree.moving_joints}
    angles: dict[str, dict[str, float]] = {}
    for state in document.findall("group_state"):
        values = angles.setdefault(state.get("name", ""), {})
        for element in state.findall("joint"):
            name = element.get("name", "")
            if name in moving:
                value = _value(element.get("value", ""))
                if value is None:
                    raise BadModel(
                        f"group state {quoted(state.get('name', ''))}: {quoted(name)} is "
                        f"{quoted(element.get('value', ''))}, expected a number"
                    )
                values[name] = value
            elif len(element.get("value", "").split()) == 1:
                missing.append(name)
    return {name: Posture(values) for name, values in angles.items() if values}


def _value(text: str) -> float | None:
    """A joint's value; two numbers are cosine and sine of an angle, as Pinocchio writes unlimited joints."""
    try:
        numbers = [decimal(word) for word in text.split()]
    except ValueError:
        return None
    if not all(map(math.isfinite, numbers)):
        return None
    if len(numbers) == 2:
        return math.atan2(numbers[1], numbers[0])
    return numbers[0] if len(numbers) == 1 else None
