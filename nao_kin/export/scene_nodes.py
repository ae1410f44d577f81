"""A robot as the nodes of a scene: for each joint one that stands where the joint is, and in it one that moves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.rotations import matrix_from_rpy, quat_from_matrix, quat_to_xyzw
from nao_kin.urdf import Origin, UrdfJoint, UrdfTree

# From z up, as robots have it, to y up, as glTF has it: a quarter turn about x. Order x, y, z, w.
Y_UP = (-np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5))


@dataclass(frozen=True)
class Node:
    """A node of a scene.

    Attributes:
        name: its name, which no other node has.
        parent: the name of the node that carries it; "" for the first.
        position: of it in its parent [m].
        quaternion: of it in its parent, in the order x, y, z, w.
        joint: the joint whose value moves it, None for a node that stands still.
        link: the link that stands on it, "" for none.
    """

    name: str
    parent: str
    position: Floats
    quaternion: Floats
    joint: UrdfJoint | None = None
    link: str = ""

    def extras(self) -> dict[str, Any]:
        """What glTF has no word for: the joint, its axis and its limits."""
        if self.joint is None:
            return {}
        row: dict[str, Any] = {"joint": self.joint.name, "kind": self.joint.kind, "axis": list(self.joint.axis)}
        if np.isfinite(self.joint.upper - self.joint.lower):
            row |= {"lower": self.joint.lower, "upper": self.joint.upper}
        if self.joint.mimic is not None:
            mimic = self.joint.mimic
            row["mimic"] = {"joint": mimic.joint, "multiplier": mimic.multiplier, "offset": mimic.offset}
        return row


def scene_nodes(tree: UrdfTree, values: Mapping[str, float], base: Floats) -> tuple[Node, ...]:
    """The nodes of a robot, parents first.

    Args:
        tree: the robot.
        values: the value of every moving joint.
        base: where the root link is: position and quaternion x, y, z, w, shape (7,).
    """
    taken = {*tree.links}
    top = _fresh(tree.name, taken)
    nodes = [
        Node(top, "", np.zeros(3), np.array(Y_UP)),
        Node(tree.root, top, base[:3], base[3:], link=tree.root),
    ]
    for joint in tree.joints:
        position, quaternion = _placed(joint.origin)
        if joint.kind == "fixed":
            nodes.append(Node(joint.child, joint.parent, position, quaternion, link=joint.child))
            continue
        stand = _fresh(joint.name, taken)
        nodes.append(Node(stand, joint.parent, position, quaternion))
        moved, turned = motion_of(joint, np.array(values[joint.name]))
        nodes.append(Node(joint.child, stand, moved, turned, joint, joint.child))
    return tuple(nodes)


def motion_of(joint: UrdfJoint, values: Floats) -> tuple[Floats, Floats]:
    """Position (..., 3) and quaternion x, y, z, w (..., 4) that a joint at values (...) gives what it moves."""
    axis = np.array(joint.axis)
    if joint.kind == "prismatic":
        return values[..., None] * axis, np.broadcast_to([0.0, 0.0, 0.0, 1.0], (*values.shape, 4))
    half = values[..., None] / 2.0
    # No canonical sign: along a motion the quaternion must not jump to its opposite.
    return np.zeros((*values.shape, 3)), np.concatenate([np.sin(half) * axis, np.cos(half)], axis=-1)


def _placed(origin: Origin) -> tuple[Floats, Floats]:
    return np.array(origin.xyz), quat_to_xyzw(quat_from_matrix(matrix_from_rpy(origin.rpy)))


def _fresh(name: str, taken: set[str]) -> str:
    while name in taken:
        name += "_joint"
    taken.add(name)
    return name
