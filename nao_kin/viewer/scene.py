"""A robot as a tree of scene nodes, so that the browser composes the transforms.

Every moving joint is a node with its fixed placement in the link that carries it; the link it moves is a child of that
node whose rotation, or translation, is the joint's. Nothing else ever changes, so a configuration is all that has to
be sent.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.robot import RobotModel
from nao_kin.rotations import exp
from nao_kin.urdf import UrdfJoint, UrdfTree
from nao_kin.viewer.messages import node_name, set_object, set_transform
from nao_kin.viewer.visuals import Drawable

ROBOT = "robot"


def link_paths(tree: UrdfTree) -> dict[str, str]:
    """Path of every link's node, parents first."""
    paths = {tree.root: f"{ROBOT}/{node_name('link', tree.root)}"}
    for joint in tree.joints:
        paths[joint.child] = f"{_holder(paths, joint)}/{node_name('link', joint.child)}"
    return paths


def scene_messages(robot: RobotModel, tree: UrdfTree, drawables: tuple[Drawable, ...]) -> Iterator[tuple[str, bytes]]:
    """Key and message of everything that stands still: placements and shapes."""
    paths = link_paths(tree)
    for joint, T_parent_joint in _placements(robot, tree):
        path = paths[joint.child] if joint.kind == "fixed" else _holder(paths, joint)
        yield f"place {path}", set_transform(path, T_parent_joint)
    count: dict[str, int] = {}
    for drawable in drawables:
        index = count[drawable.link] = count.get(drawable.link, -1) + 1
        path = f"{paths[drawable.link]}/visual:{index}"
        yield f"shape {path}", set_object(path, drawable.shape, drawable.rgba)
        yield f"place {path}", set_transform(path, drawable.T_link_shape)


def motion(joint: UrdfJoint, value: float) -> Floats:
    """What a joint value does: the pose of the moved link in the joint's node."""
    T = np.eye(4)
    if joint.kind == "prismatic":
        T[:3, 3] = value * np.array(joint.axis)
    elif joint.kind == "revolute":
        T[:3, :3] = exp(value * np.array(joint.axis))
    return T


def _holder(paths: dict[str, str], joint: UrdfJoint) -> str:
    """The node that holds the moved link: the joint's own, or for a fixed joint the carrying link itself."""
    parent = paths[joint.parent]
    return parent if joint.kind == "fixed" else f"{parent}/{node_name('joint', joint.name)}"


def _placements(robot: RobotModel, tree: UrdfTree) -> Iterator[tuple[UrdfJoint, Floats]]:
    """T_parent_joint of every joint, from the model's own forward kinematics: what was calibrated stays calibrated."""
    poses = dict(zip(robot.link_names, robot.fk(robot.neutral()), strict=True))
    for joint in tree.joints:
        mimic = robot.mimics.get(joint.name)
        moved = motion(joint, mimic.offset if mimic is not None else 0.0)
        yield joint, np.linalg.solve(poses[joint.parent], poses[joint.child]) @ np.linalg.inv(moved)
