"""Joints that follow another one: kept, fixed together with what drives them, or set free."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

from nao_kin._common.choices import choice
from nao_kin.export.variants.placement import moved
from nao_kin.urdf import UrdfJoint, UrdfTree

Coupling = Literal["mimic", "locked", "independent"]
COUPLINGS: tuple[Coupling, ...] = ("mimic", "locked", "independent")


def couple(tree: UrdfTree, coupling: str) -> tuple[UrdfTree, tuple[str, ...]]:
    """The tree with its couplings kept, locked or taken away.

    A tool that does not know couplings moves each joint alone. "locked" gives it joints that cannot be moved wrongly:
    the driving joint and all that follow it are fixed, where the driving joint is at zero, or at the limit nearest to
    zero. "independent" leaves it to whoever sets the joints to set them alike.

    Args:
        tree: the robot.
        coupling: "mimic" changes nothing, "locked" or "independent".

    Returns:
        The tree, and one line for each group of coupled joints.

    Raises:
        UnknownName: no such choice.

    Examples:
        >>> from nao_kin.export.variants.coupling import couple
        >>> tree, changes = couple(nk.load_nao("v6").tree, "independent")
        >>> len(tree.moving_joints), len(tree.mimics)
        (42, 0)
        >>> changes[1]
        'RHipYawPitch no longer follows LHipYawPitch: each is moved alone'
    """
    choice(coupling, COUPLINGS, "coupling")
    if coupling == "mimic" or not tree.mimics:
        return tree, ()
    followers: dict[str, list[str]] = {}
    for joint in tree.joints:
        if joint.mimic is not None:
            followers.setdefault(joint.mimic.joint, []).append(joint.name)
    changes: list[str] = []
    if coupling == "independent":
        for driver, names in followers.items():
            what = "no longer follows" if len(names) == 1 else "no longer follow"
            changes.append(f"{', '.join(names)} {what} {driver}: each is moved alone")
        return replace(tree, joints=tuple(replace(joint, mimic=None) for joint in tree.joints)), tuple(changes)
    values = {joint.name: _at_rest(joint) for joint in tree.joints if joint.name in followers}
    for driver, names in followers.items():
        changes.append(f"{driver} is fixed at {values[driver]:g}, and with it what follows it: {', '.join(names)}")
    values |= {name: float(mimic.value(values[mimic.joint])) for name, mimic in tree.mimics.items()}
    joints = (_fixed(joint, values[joint.name]) if joint.name in values else joint for joint in tree.joints)
    return replace(tree, joints=tuple(joints)), tuple(changes)


def _at_rest(joint: UrdfJoint) -> float:
    return min(max(0.0, joint.lower), joint.upper)


def _fixed(joint: UrdfJoint, value: float) -> UrdfJoint:
    origin = moved(joint.origin, joint.kind, joint.axis, value)
    return UrdfJoint(joint.name, "fixed", joint.parent, joint.child, origin)
