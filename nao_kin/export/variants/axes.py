"""Joint axes: as published, or each along an axis of its joint's frame."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

from nao_kin._common.arrays import Vector
from nao_kin._common.choices import choice
from nao_kin._common.free_names import with_underscores
from nao_kin.export.variants.placement import composed, rpy_of
from nao_kin.rotations import rotation_between
from nao_kin.urdf import Origin, UrdfJoint, UrdfTree

Axes = Literal["published", "aligned"]
AXES: tuple[Axes, ...] = ("published", "aligned")

_ALONG_AN_AXIS = ("revolute", "prismatic")
_Z: Vector = (0.0, 0.0, 1.0)


def align_axes(tree: UrdfTree, axes: str) -> tuple[UrdfTree, tuple[str, ...]]:
    """The tree without oblique axes: every joint axis is plus or minus x, y or z of its joint's frame.

    Some tools know joints about the axes of the frame only. In a joint whose axis is oblique, a link without mass is
    put between: the joint carries it, with its z axis along the joint's axis, and a fixed joint turns back to the link
    that was carried. Every link of the robot stays where it was in every configuration, and every joint keeps its
    name, its limits and its value.

    Args:
        tree: the robot.
        axes: "published" changes nothing, or "aligned".

    Returns:
        The tree, and one line for each joint that is turned.

    Raises:
        UnknownName: no such choice.

    Examples:
        >>> from nao_kin.export.variants.axes import align_axes
        >>> align_axes(nk.load_nao("v6").tree, "aligned")[1][0]
        'LHipYawPitch: its frame is turned until its axis is z; LHipYawPitch_axis stands between torso and LPelvis'
    """
    choice(axes, AXES, "choice of axes")
    if axes == "published":
        return tree, ()
    taken = {*tree.links, *(joint.name for joint in tree.joints)}
    joints, links, changes = list[UrdfJoint](), list(tree.links), list[str]()
    for joint in tree.joints:
        if joint.kind not in _ALONG_AN_AXIS or sorted(map(abs, joint.axis)) == [0.0, 0.0, 1.0]:
            joints.append(joint)
            continue
        between = with_underscores(f"{joint.name}_axis", taken)
        R = rotation_between(_Z, joint.axis)
        turned = composed(joint.origin, Origin(rpy=rpy_of(R)))
        joints.append(replace(joint, origin=turned, axis=_Z, child=between))
        back = with_underscores(f"{joint.name}_axis_fixedjoint", taken)
        taken |= {between, back}
        joints.append(UrdfJoint(back, "fixed", between, joint.child, Origin(rpy=rpy_of(R.T))))
        links.insert(links.index(joint.child), between)
        changes.append(
            f"{joint.name}: its frame is turned until its axis is z; "
            f"{between} stands between {joint.parent} and {joint.child}"
        )
    return replace(tree, links=tuple(links), joints=tuple(joints)), tuple(changes)
