"""The names of a robot's published ROS description instead of those of its URDF here."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Literal

from nao_kin._common.choices import choice
from nao_kin.errors import BadArgument
from nao_kin.export.variants.frames import merged
from nao_kin.export.variants.placement import HERE
from nao_kin.semantics import Semantics, meaning
from nao_kin.urdf import UrdfTree

Names = Literal["naoqi", "ros"]
NAMES: tuple[Names, ...] = ("naoqi", "ros")


def name_frames(tree: UrdfTree, names: str, semantics: Semantics) -> tuple[UrdfTree, tuple[str, ...]]:
    """The tree with the names of the robot's ROS description, `semantics.ros_names`.

    Where two links that a fixed joint holds at one place get one name, they become one link. A link and a joint may
    have one name afterwards, as in ros-naoqi's nao_description.

    Args:
        tree: the robot.
        names: "naoqi" changes nothing: these are the names of the robot's own file; or "ros".
        semantics: what the robot means.

    Returns:
        The tree, and one line for what has changed.

    Raises:
        UnknownName: no such choice.
        BadArgument: no ROS names are known of this robot, or two links of the tree cannot both have theirs.

    Examples:
        >>> from nao_kin.export.variants.names import name_frames
        >>> nao = nk.load_nao("v5")
        >>> tree, _ = name_frames(nao.tree, "ros", nao.semantics)
        >>> [joint.child for joint in tree.joints if joint.name in ("LLeg_effector_fixedjoint", "LAnklePitch")]
        ['LAnklePitch', 'l_sole']
    """
    choice(names, NAMES, "choice of names")
    if names == "naoqi":
        return tree, ()
    new = new_names(semantics, names)
    if not new:
        raise BadArgument(f"{tree.name}: no ROS names are known of this robot; leave out names='ros' (--names ros)")
    twins = [
        joint.child
        for joint in tree.joints
        if joint.kind == "fixed"
        and new.get(joint.child, joint.child) == new.get(joint.parent, joint.parent)
        and joint.origin == HERE
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
    """Name of a link or joint → its name by that choice, for those that get another one.

    Examples:
        >>> from nao_kin.export.variants.names import new_names
        >>> new_names(nk.load_nao().semantics, "ros")["Accelerometer"]
        'ImuTorsoAccelerometer_frame'
    """
    return semantics.ros_names if names == "ros" else {}


def named_semantics(semantics: Semantics, names: str) -> Semantics:
    """What a robot means by a choice of names, to stand beside the tree of `name_frames`.

    Examples:
        >>> from nao_kin.export.variants.names import named_semantics
        >>> named_semantics(nk.load_nao().semantics, "ros").soles
        ('l_sole', 'r_sole')
    """
    new = new_names(semantics, names)
    frames: dict[str, Any] = {
        name: tuple(new.get(frame, frame) for frame in getattr(semantics, name)) for name in meaning.FRAME_FIELDS
    }
    views = {new.get(camera, camera): angles for camera, angles in semantics.fields_of_view.items()}
    return replace(semantics, **frames, fields_of_view=views)


def _renamed(tree: UrdfTree, new: Mapping[str, str]) -> UrdfTree:
    def named(name: str) -> str:
        return new.get(name, name)

    joints = tuple(
        replace(
            joint,
            name=named(joint.name),
            parent=named(joint.parent),
            child=named(joint.child),
            mimic=None if joint.mimic is None else replace(joint.mimic, joint=named(joint.mimic.joint)),
        )
        for joint in tree.joints
    )
    return replace(
        tree,
        name=named(tree.name),
        root=named(tree.root),
        links=tuple(map(named, tree.links)),
        joints=joints,
        inertials={named(link): body for link, body in tree.inertials.items()},
        visuals=tuple(replace(visual, link=named(visual.link)) for visual in tree.visuals),
        collisions=tuple(replace(shape, link=named(shape.link)) for shape in tree.collisions),
        shared_names={},
    )
