"""Variants of a robot's tree: functions that return another tree, and one line for each change."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats, Vector, choice, flag
from nao_kin._core.text import listed, with_underscores
from nao_kin.errors import BadArgument
from nao_kin.export.inertia import IDENTITY, body_of, composed, hosts, make_physical, moved, pseudo_inertia
from nao_kin.joints import MultiDofJoint, group_joints
from nao_kin.robot import RobotModel
from nao_kin.robot.semantics import Semantics
from nao_kin.robot.urdf import Inertial, Origin, UrdfJoint, UrdfTree
from nao_kin.rotations import rotation_between

# A tree and one line for each change.
Changed = tuple[UrdfTree, tuple[str, ...]]

# --- Joint axes along the axes of their frames.

_ALONG_AN_AXIS = ("revolute", "prismatic")
_Z: Vector = (0.0, 0.0, 1.0)


def align_axes(tree: UrdfTree) -> Changed:
    """Return the tree with every joint axis along plus or minus x, y or z of its joint's frame, as some tools require.

    A joint with an oblique axis carries an additional massless link whose z axis is along the axis; a fixed joint
    rotates back to the original link. All links keep their poses in every configuration; joints keep names, limits and
    values.
    """
    taken = {*tree.links, *(joint.name for joint in tree.joints)}
    joints, links, changes = list[UrdfJoint](), list(tree.links), list[str]()
    for joint in tree.joints:
        if joint.kind not in _ALONG_AN_AXIS or sorted(map(abs, joint.axis)) == [0.0, 0.0, 1.0]:
            joints.append(joint)
            continue
        between = with_underscores(f"{joint.name}_axis", taken)
        turn = np.eye(4)
        turn[:3, :3] = rotation_between(_Z, joint.axis)
        turned = composed(joint.origin, Origin.of(turn))
        joints.append(replace(joint, origin=turned, axis=_Z, child=between))
        back = with_underscores(f"{joint.name}_axis_fixedjoint", taken)
        taken |= {between, back}
        joints.append(UrdfJoint(back, "fixed", between, joint.child, Origin.of(turn.T)))
        links.insert(links.index(joint.child), between)
        changes.append(
            f"{joint.name}: its frame is turned until its axis is z; "
            f"{between} is between {joint.parent} and {joint.child}"
        )
    return replace(tree, links=tuple(links), joints=tuple(joints)), tuple(changes)


# --- Mimic joints: fixed together with their drivers, or made independent.


def couple(tree: UrdfTree, coupling: str) -> Changed:
    """Return the tree with its couplings "locked" or "independent", for tools that do not support couplings.

    "locked" fixes a driving joint and its mimic joints, the driver at zero or at its limit nearest to zero.
    """
    followers: defaultdict[str, list[str]] = defaultdict(list)
    for name, mimic in tree.mimics.items():
        followers[mimic.joint].append(name)
    if coupling == "independent":
        return replace(tree, joints=tuple(replace(joint, mimic=None) for joint in tree.joints)), tuple(
            f"{', '.join(names)} no longer {'follows' if len(names) == 1 else 'follow'} {driver}: each moves on its own"
            for driver, names in followers.items()
        )
    values = {joint.name: min(max(0.0, joint.lower), joint.upper) for joint in tree.joints if joint.name in followers}
    changes = tuple(
        f"{driver} is fixed at {values[driver]:g}, together with its followers: {', '.join(names)}"
        for driver, names in followers.items()
    )
    values |= {name: float(mimic.value(values[mimic.joint])) for name, mimic in tree.mimics.items()}
    joints = (_fixed(joint, values[joint.name]) if joint.name in values else joint for joint in tree.joints)
    return replace(tree, joints=tuple(joints)), changes


def _fixed(joint: UrdfJoint, value: float = 0.0) -> UrdfJoint:
    return UrdfJoint(joint.name, "fixed", joint.parent, joint.child, moved(joint, value))


# --- Links on fixed joints: all, those that the robot's semantics name, or none.


def keep_frames(tree: UrdfTree, frames: str, semantics: Semantics) -> Changed:
    """Return the tree with fewer links on fixed joints; the others are merged, mass and shapes, into their carriers.

    "effectors" keeps the frames that `semantics` names, "none" one link for each body. A root without mass and shapes,
    with a single fixed joint to a link at the same pose, becomes that link: simulators need the trunk's mass on the
    root.
    """
    named = set(semantics.frames()) if frames == "effectors" else set[str]()
    named |= {tree.shared_names[name] for name in named if name in tree.shared_names}
    changes: list[str] = []
    bare = _bare_root(tree)
    if bare is not None:
        changes.append(f"{tree.root} has neither mass nor shapes: {bare} is the root instead")
        tree = replace(
            tree,
            root=bare,
            links=tuple(name for name in tree.links if name != tree.root),
            joints=tuple(joint for joint in tree.joints if joint.child != bare),
            shared_names={old: new for old, new in tree.shared_names.items() if new != tree.root},
        )
    gone = [joint.child for joint in tree.joints if joint.kind == "fixed" and joint.child not in named]
    if gone:
        changes.append(f"{len(gone)} links on fixed joints are merged into the links that carry them: {listed(gone)}")
    return merged(tree, gone), tuple(changes)


def merged(tree: UrdfTree, gone: Collection[str]) -> UrdfTree:
    """Return the tree without the links `gone`, merged into the links that carry them by fixed joints."""
    away = set(gone)
    places = hosts(tree, away)

    def rehung(part: Any, on: str = "link") -> Any:
        host, place = places[getattr(part, on)]
        return replace(part, origin=composed(place, part.origin), **{on: host})

    return replace(
        tree,
        links=tuple(link for link in tree.links if link not in away),
        joints=tuple(rehung(joint, on="parent") for joint in tree.joints if joint.child not in away),
        inertials=_merged_inertias(tree, places),
        visuals=tuple(map(rehung, tree.visuals)),
        collisions=tuple(map(rehung, tree.collisions)),
        shared_names={old: new for old, new in tree.shared_names.items() if new not in away},
    )


def _merged_inertias(tree: UrdfTree, places: Mapping[str, tuple[str, Origin]]) -> dict[str, Inertial]:
    parts: defaultdict[str, list[tuple[Inertial, Origin]]] = defaultdict(list)
    for link in tree.links:
        if link in tree.inertials:
            host, place = places[link]
            parts[host].append((tree.inertials[link], place))
    return {
        # A single body keeps the numbers of the file.
        host: bodies[0][0]
        if len(bodies) == 1 and bodies[0][1] == IDENTITY
        else body_of(np.sum([pseudo_inertia(body, place) for body, place in bodies], axis=0))
        for host, bodies in parts.items()
    }


def _bare_root(tree: UrdfTree) -> str | None:
    """Return the only link on a root without mass and shapes, if it is fixed at the same pose."""
    joints = [joint for joint in tree.joints if joint.parent == tree.root]
    own = {*tree.inertials, *(visual.link for visual in tree.visuals), *(shape.link for shape in tree.collisions)}
    if len(joints) != 1 or joints[0].kind != "fixed" or joints[0].origin != IDENTITY or tree.root in own:
        return None
    return joints[0].child


# --- The names of a robot's published ROS description instead of those of its URDF.


def name_frames(tree: UrdfTree, semantics: Semantics) -> Changed:
    """Return the tree with the names of the robot's ROS description, `semantics.ros_names`.

    Two links with one name that a fixed joint connects at the same pose become one link. A link and a joint may have
    the same name afterwards, as in ros-naoqi's nao_description.
    """
    new = semantics.ros_names
    if not new:
        raise BadArgument(f"{tree.name}: no ROS names are known of this robot; leave out names='ros' (--names ros)")
    twins = [
        joint.child
        for joint in tree.joints
        if joint.kind == "fixed"
        and new.get(joint.child, joint.child) == new.get(joint.parent, joint.parent)
        and joint.origin == IDENTITY
    ]
    tree = merged(tree, twins)
    links = [new.get(link, link) for link in tree.links]
    double = sorted({name for name in links if links.count(name) > 1})
    if double:
        raise BadArgument(f"{tree.name}: two links would be named {', '.join(double)} in ROS")
    changed = [name for name in (*tree.links, *(joint.name for joint in tree.joints)) if new.get(name, name) != name]
    return _renamed(tree, new), (
        f"{len(changed)} links and joints have the names of the ROS description, "
        f"and {len(twins)} that would name one place a second time are left out",
    )


def new_names(semantics: Semantics, names: str) -> Mapping[str, str]:
    """Return old → new name of the links and joints that the choice `names` renames."""
    return semantics.ros_names if names == "ros" else {}


def _renamed(tree: UrdfTree, new: Mapping[str, str]) -> UrdfTree:
    def named(part: Any, *fields: str) -> Any:
        return replace(part, **{field: new.get(getattr(part, field), getattr(part, field)) for field in fields})

    joints = (named(joint, "name", "parent", "child") for joint in tree.joints)
    return replace(
        tree,
        name=new.get(tree.name, tree.name),
        root=new.get(tree.root, tree.root),
        links=tuple(new.get(link, link) for link in tree.links),
        joints=tuple(replace(joint, mimic=joint.mimic and named(joint.mimic, "joint")) for joint in joints),
        inertials={new.get(link, link): body for link, body in tree.inertials.items()},
        visuals=tuple(named(visual, "link") for visual in tree.visuals),
        collisions=tuple(named(shape, "link") for shape in tree.collisions),
        shared_names={},
    )


# --- Three revolute joints with one centre as a spherical joint.

SPHERICAL = "spherical"


def merge_balls(tree: UrdfTree) -> Changed:
    """Return the tree with joints of the kind "spherical" where `group_joints` finds them.

    The links between the three axes are fixed to the link before, at their poses with all joints at zero; the centre of
    mass is then no longer exact, but the poses of all other links are. A ball has no limits and no coupling; three
    joints are not merged if one of them drives or mimics another.
    """
    changes: list[str] = []
    coupled = tree.mimics.keys() | {mimic.joint for mimic in tree.mimics.values()}
    for group in group_joints(RobotModel(tree)):
        if group.pair.name != SPHERICAL:
            continue
        bound = [name for name in group.joints if name in coupled]
        if bound:
            names = ", ".join(group.joints)
            remedy = "coupling='independent' (--coupling independent) removes the coupling"
            changes.append(f"{names} are not merged, because {bound[0]} is coupled; {remedy}")
        else:
            tree = _with_ball(tree, group, changes)
    return tree, tuple(changes) or ("no three joints have one centre: there is nothing to merge",)


def _with_ball(tree: UrdfTree, group: MultiDofJoint, changes: list[str]) -> UrdfTree:
    by_name = {joint.name: joint for joint in tree.joints}
    first, second, third = (by_name[name] for name in group.joints)
    # There may be links on fixed joints between the axes.
    origin = third.origin
    for joint in reversed(tree.joints_to(third.parent, first.parent)):
        origin = composed(joint.origin, origin)
    ball = UrdfJoint(group.name, SPHERICAL, first.parent, third.child, origin)
    changes.append(
        f"{first.name}, {second.name}, {third.name} are one spherical joint, {ball.name}, without limits; "
        f"{first.child} and {second.child} stay where they are at zero"
    )
    new = {first.name: _fixed(first), second.name: _fixed(second), third.name: ball}
    return replace(tree, joints=tuple(new.get(joint.name, joint) for joint in tree.joints))


# --- The values of all joints of a robot, by their names in an export.


def joint_values(robot: RobotModel, q: Floats, names: str = "naoqi") -> dict[str, Floats]:
    """Return name → values, shape (...), of every joint, mimic joints included, in configurations (..., nq)."""
    own = {name: np.asarray(value) for name, value in robot.angles(q).items()}
    values = own | {name: mimic.value(own[mimic.joint]) for name, mimic in robot.mimics.items()}
    new = new_names(robot.semantics, names)
    return {new.get(name, name): value for name, value in values.items()}


# --- All choices together.

# Choice → its name in messages, and its values; the first value changes nothing.
CHOICES: Mapping[str, tuple[str, tuple[str, ...]]] = {
    "coupling": ("coupling", ("mimic", "locked", "independent")),
    "frames": ("choice of frames", ("all", "effectors", "none")),
    "inertia": ("choice of inertias", ("published", "physical")),
    "names": ("choice of names", ("naoqi", "ros")),
    "axes": ("choice of axes", ("published", "aligned")),
}


@dataclass(frozen=True)
class Variant:
    """The choices that make a variant of a robot, as `nk.export.urdf` describes them."""

    frames: str = "all"
    names: str = "naoqi"
    coupling: str = "mimic"
    inertia: str = "published"
    typed: bool = False
    axes: str = "published"

    def __post_init__(self) -> None:
        for name, (what, valid) in CHOICES.items():
            choice(getattr(self, name), valid, what)
        flag(self.typed, "typed")

    def tree_of(self, robot: RobotModel) -> Changed:
        """Return the tree of a robot in this variant, and one line for each change."""
        tree, changes, semantics = robot.tree, tuple[str, ...](), robot.semantics
        steps: tuple[tuple[bool, Callable[[UrdfTree], Changed]], ...] = (
            (self.coupling != "mimic", lambda tree: couple(tree, self.coupling)),
            (self.typed, merge_balls),
            (self.frames != "all", lambda tree: keep_frames(tree, self.frames, semantics)),
            (self.inertia != "published", make_physical),
            (self.names != "naoqi", lambda tree: name_frames(tree, semantics)),
            (self.axes != "published", align_axes),
        )
        for is_chosen, change in steps:
            if is_chosen:
                tree, made = change(tree)
                changes += made
        return tree, changes
