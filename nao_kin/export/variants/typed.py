"""Three revolute joints with one centre as the one spherical joint that they are together."""

from __future__ import annotations

from dataclasses import replace

from nao_kin._common.choices import flag
from nao_kin.export.variants.placement import composed
from nao_kin.joints import MultiDofJoint, group_joints
from nao_kin.robot import RobotModel
from nao_kin.urdf import UrdfJoint, UrdfTree

SPHERICAL = "spherical"


def merge_balls(tree: UrdfTree, typed: bool = True) -> tuple[UrdfTree, tuple[str, ...]]:
    """The tree with joints of the kind "spherical" where `nao_kin.joints.group_joints` finds them.

    The links between the three axes have no place in a ball: with their mass and all that is fixed to them they stay
    on the link before, where they are with all joints at zero. So the centre of mass is no longer exact, and poses of
    everything else are. A ball has no limits and follows nothing; three joints of which one drives or follows another
    are left as they are.

    Args:
        tree: the robot.
        typed: False changes nothing.

    Returns:
        The tree, and one line for each spherical joint.

    Raises:
        BadArgument: `typed` is neither True nor False.

    Examples:
        >>> from nao_kin.export.variants.coupling import couple
        >>> from nao_kin.export.variants.typed import merge_balls
        >>> tree, changes = merge_balls(couple(nk.load_nao("v6").tree, "independent")[0])
        >>> [joint.name for joint in tree.joints if joint.kind == "spherical"]
        ['LHipYawPitch+LHipRoll+LHipPitch', 'RHipYawPitch+RHipRoll+RHipPitch']
    """
    check_typed(typed)
    if not typed:
        return tree, ()
    changes: list[str] = []
    coupled = tree.mimics.keys() | {mimic.joint for mimic in tree.mimics.values()}
    for group in group_joints(RobotModel(tree)):
        if group.pair.name != SPHERICAL:
            continue
        bound = [name for name in group.joints if name in coupled]
        if bound:
            names = ", ".join(group.joints)
            changes.append(
                f"{names} are not merged, for {bound[0]} is coupled; coupling='independent' (--coupling independent) "
                "sets it free"
            )
            continue
        tree = _merged(tree, group, changes)
    return tree, tuple(changes) or ("no three joints have one centre: there is nothing to merge",)


def check_typed(typed: object) -> None:
    """Refuse what is neither True nor False: every other text is true to Python.

    Raises:
        BadArgument: neither.
    """
    flag(typed, "typed")


def _merged(tree: UrdfTree, group: MultiDofJoint, changes: list[str]) -> UrdfTree:
    by_name = {joint.name: joint for joint in tree.joints}
    first, second, third = (by_name[name] for name in group.joints)
    # Links of fixed joints may stand between the axes.
    origin, link = third.origin, third.parent
    above = {joint.child: joint for joint in tree.joints}
    while link != first.parent:
        origin, link = composed(above[link].origin, origin), above[link].parent
    ball = UrdfJoint(group.name, SPHERICAL, first.parent, third.child, origin)
    changes.append(
        f"{first.name}, {second.name}, {third.name} are one spherical joint, {ball.name}, without limits; "
        f"{first.child} and {second.child} stay where they are at zero"
    )
    new = {
        first.name: UrdfJoint(first.name, "fixed", first.parent, first.child, first.origin),
        second.name: UrdfJoint(second.name, "fixed", second.parent, second.child, second.origin),
        third.name: ball,
    }
    return replace(tree, joints=tuple(new.get(joint.name, joint) for joint in tree.joints))
