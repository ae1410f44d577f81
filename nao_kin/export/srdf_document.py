"""SRDF: what MoveIt asks about a robot beside its URDF."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree as ET

from nao_kin._common.arrays import Floats
from nao_kin._common.documents import check_replaceable, write_document
from nao_kin._common.free_names import fresh_name
from nao_kin._common.scalars import whole_number
from nao_kin._text import abbreviated, quoted
from nao_kin.errors import UnknownName
from nao_kin.export.disabled_collisions import disabled_collisions
from nao_kin.export.exported import Exported
from nao_kin.export.joint_values import joint_values
from nao_kin.export.link_contacts import LinkContacts, LinkPair
from nao_kin.export.planning_groups import Group, Planning, planning
from nao_kin.export.urdf_export import variant
from nao_kin.export.variants.names import name_frames, named_semantics, new_names
from nao_kin.robot import RobotModel, check_robot
from nao_kin.semantics import Posture, Semantics
from nao_kin.urdf import UrdfTree, writing

BASES = ("fixed", "floating", "planar")
WORLD = "world"

# MoveIt, "URDF and SRDF": characters that joint names should not contain.
_TROUBLESOME = re.compile(r"[-\[\](),]")
_MOST_SAMPLES = 1_000_000
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
    """Write an SRDF: planning groups, end effectors, postures, and the collision checks that a planner may leave out.

    Groups are the robot's chains, as `nao_kin.semantics` names them, and "whole_body"; a chain whose last joint moves
    a gripper has a second group without it, which ends in the frame of the end effector. Postures are group states
    without the joints that follow others, which are passive joints. A pair of links is not checked when the two are
    adjacent, touch in the posture the robot starts in, touch in more than 95 % of the configurations tried, or in none
    of them. A robot without chains has the group of all its joints; one without collision shapes leaves out no check.

    Args:
        robot: the robot.
        path: the file.
        names: "naoqi" for the names of the robot's own URDF, "ros" for those of its ROS description: as in the URDF
            beside it.
        frames: "all", "effectors" or "none": which frames the URDF beside it has.
        coupling: "mimic", "locked" or "independent": as in the URDF beside it.
        base: what holds the root link in the frame "world": "fixed", "floating" or "planar"; None for what the
            robot was loaded with.
        samples: how many configurations are tried for contacts.
        seed: of the random numbers; the same seed gives the same file.
        overwrite: replace a file that is there.

    Returns:
        The file, and one line for everything that an SRDF cannot say.

    Raises:
        UnknownName: no such names, frames, coupling or base.
        BadArgument: no robot, no ROS names known, no count of samples, a file is there, or it cannot be written.

    Examples:
        >>> nao = nk.load_nao("v6")
        >>> done = nk.export.srdf(nao, "nao.srdf", samples=100)
        >>> again = nk.RobotModel.from_urdf(nao.urdf_path, semantics="nao.srdf")
        >>> again.chains["LLeg"] == nao.chains["LLeg"], again.posture_names == nao.posture_names
        (True, True)
    """
    check_replaceable(path, overwrite=overwrite)
    document = srdf_document(
        robot, names=names, frames=frames, coupling=coupling, base=base, samples=samples, seed=seed
    )
    return Exported(Path(path), write_document(path, document.text.encode(), overwrite=overwrite), document.changes)


@dataclass(frozen=True)
class SrdfDocument:
    """An SRDF that is not written yet, and what it cannot say, one line each."""

    text: str
    changes: tuple[str, ...]


def srdf_document(
    robot: RobotModel,
    *,
    names: str = "naoqi",
    frames: str = "all",
    coupling: str = "mimic",
    base: str | None = None,
    samples: int = 10_000,
    seed: int = 0,
) -> SrdfDocument:
    """The text of an SRDF; arguments and errors as `srdf`."""
    check_robot(robot)
    held = ("floating" if robot.base == "floating" else "fixed") if base is None else base
    if held not in BASES:
        raise UnknownName("base", base, BASES)
    count = whole_number(samples, "samples", 1, _MOST_SAMPLES)
    own, _ = variant(robot, frames=frames, coupling=coupling)
    tree, _ = name_frames(own, names, robot.semantics)
    body = _as_written(robot, own)
    plan = planning(tree, named_semantics(robot.semantics, names))
    contacts = LinkContacts(body)
    reasons = disabled_collisions(body, contacts, samples=count, seed=whole_number(seed, "seed", 0))
    new = new_names(robot.semantics, names)
    unchecked = {(new.get(a, a), new.get(b, b)): reason for (a, b), reason in reasons.items()}
    states = {name: joint_values(robot, robot.posture(name), names) for name in robot.posture_names}
    root = _robot(tree, states, plan, unchecked, held)
    found = _found(contacts, reasons, count)
    return SrdfDocument(
        writing.document_text(root),
        (*plan.notes, *contacts.notes, found, *_unsaid(body, plan, contacts, set(reasons), new)),
    )


def _as_written(robot: RobotModel, tree: UrdfTree) -> RobotModel:
    """The robot as the tree of a variant moves it, with what of its meaning is asked here."""
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
    held: str,
) -> ET.Element:
    root = ET.Element("robot", name=tree.name)
    root.append(ET.Comment(" Written by nao_kin; the URDF of the same name has the links and joints. "))
    for group in plan.groups:
        _add_group(root, group)
    # Pinocchio keeps the first state of a name: that of all joints.
    for group in plan.groups:
        for name, values in states.items():
            _add_state(root, name, group, values)
    for effector in plan.end_effectors:
        element = ET.SubElement(root, "end_effector", name=effector.name, parent_link=effector.parent_link)
        element.set("group", effector.group)
        if effector.parent_group:
            element.set("parent_group", effector.parent_group)
    virtual = fresh_name("virtual_joint", {joint.name for joint in tree.joints})
    ET.SubElement(root, "virtual_joint", name=virtual, type=held, parent_frame=WORLD, child_link=tree.root)
    for follower in tree.mimics:
        ET.SubElement(root, "passive_joint", name=follower)
    for (first, second), reason in unchecked.items():
        ET.SubElement(root, "disable_collisions", link1=first, link2=second, reason=reason)
    return root


def _add_group(root: ET.Element, group: Group) -> None:
    element = ET.SubElement(root, "group", name=group.name)
    if group.chain is not None:
        ET.SubElement(element, "chain", base_link=group.chain[0], tip_link=group.chain[1])
    for tag, names in (("joint", group.joints), ("link", group.links), ("group", group.groups)):
        for name in names:
            ET.SubElement(element, tag, name=name)


def _add_state(root: ET.Element, name: str, group: Group, values: Mapping[str, Floats]) -> None:
    if group.own:
        state = ET.SubElement(root, "group_state", name=name, group=group.name)
        for joint in group.own:
            ET.SubElement(state, "joint", name=joint, value=repr(float(values[joint])))


def _found(contacts: LinkContacts, reasons: Mapping[LinkPair, str], samples: int) -> str:
    pairs = sum(1 for _ in contacts.pairs())
    if not pairs:
        return "no two links have collision shapes: a planner finds no contacts of the robot with itself"
    counts = ", ".join(f"{count} {reason}" for reason, count in sorted(Counter(reasons.values()).items()))
    return (
        f"{len(reasons)} of {pairs} pairs of links with collision shapes are not checked "
        f"({counts}; {samples} configurations tried)"
    )


def _unsaid(
    robot: RobotModel, plan: Planning, contacts: LinkContacts, unchecked: set[LinkPair], new: Mapping[str, str]
) -> list[str]:
    """What a planner will not know, or not like."""
    lines = []
    if robot.coupled_limits:
        names = ", ".join(dict.fromkeys(table.joint for table in robot.coupled_limits))
        lines.append(f"coupled limits are left out, a planner knows one range for each joint: {names}")
    checked = set(contacts.pairs()) - unchecked
    for name in robot.posture_names:
        touching = contacts.count(robot.posture(name)[None], checked)
        found = [pair for pair, count in touching.items() if count]
        pairs = ", ".join(f"{new.get(first, first)} and {new.get(second, second)}" for first, second in found)
        if pairs:
            lines.append(f"in posture {quoted(name)} shapes touch that are checked, no plan can start there: {pairs}")
    for group in plan.groups:
        if not _PARAMETER.fullmatch(group.name):
            lines.append(f"group {quoted(group.name)} is no name for a parameter of ROS: letters, digits and _")
    joints = [joint.name for joint in robot.tree.moving_joints if _TROUBLESOME.search(joint.name)]
    if joints:
        lines.append(f"MoveIt warns of the characters in {len(joints)} names of joints, first {quoted(joints[0])}")
    return [abbreviated(line, 400) for line in lines]
