"""The Pinocchio model of a robot whose merged joints are universal and spherical joints.

A merged joint has no links between its axes, but the robot has such links, with mass and frames. Each of them is
attached to a carrier, a revolute joint about the original axis, on a side branch. The carrier of a universal joint
mimics that joint's first coordinate. A ball has no angles to mimic, so its carriers have their own coordinates.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pinocchio as pin

from nao_kin.joints._readings import Ball, Reading, Slot
from nao_kin.joints.grouping import JointNode
from nao_kin.joints.pairs import JointGroups, MultiDofJoint
from nao_kin.robot import RobotModel


class Assembly:
    """A typed model, put together on construction."""

    def __init__(
        self, robot: RobotModel, nodes: Mapping[int, JointNode], groups: JointGroups, *, keep: bool = True
    ) -> None:
        self._source, self._nodes = robot.model, nodes
        self._by_name = {node.name: node for node in nodes.values()}
        self._merged = {
            self._by_name[name].index: group for group in groups for name in group.joints if len(group.axes) > 1
        }
        self.model = pin.Model()
        self.model.name, self.model.gravity = self._source.name, self._source.gravity
        self.slots: list[Slot] = []  # the model's coordinates that are values of joints of the robot
        self.balls: list[Ball] = []  # spherical joints
        self.followers: list[tuple[JointNode, Reading]] = []  # held in addition to their drivers, and where
        self.hints: list[tuple[JointNode, Reading]] = []  # held a second time, only to resolve ambiguity
        self.carriers: list[str] = []  # names
        self.lumped: dict[int, int] = {}  # joint that is not in the model → the joint to which its body is fixed
        self._keep = keep
        # Joint of the robot → the joint of the new model that moves with it, and its pose in that joint's frame.
        self._places = {0: (0, pin.SE3.Identity())}
        self._holders: dict[str, Slot] = {}  # joint with its own coordinate → where its value is
        self._add_joints(groups)
        self._add_bodies_and_frames(groups)

    def _add_joints(self, groups: JointGroups) -> None:
        # Pinocchio's algorithms need the joints in depth-first order; the last task added is done next.
        tasks = [("joint", index) for index in reversed(list(self._nodes)) if self._nodes[index].parent == 0]
        while tasks:
            task, index = tasks.pop()
            node, group = self._nodes[index], self._merged.get(index)
            if group is None:
                self._add_single(node)
                tasks += [("joint", child) for child in reversed(node.children)]
                continue
            members = [self._by_name[name] for name in group.joints]
            outer = [("joint", child) for child in reversed(members[-1].children)]
            carriers = [("carrier", member.index) for member in reversed(members[:-1])] if self._keep else []
            if task == "joint" and not self._keep:
                self._drop_between(members)
            if task == "carrier":
                self._add_carrier(group, node)
                tasks += [("joint", child) for child in reversed(node.children) if self._merged.get(child) is not group]
            elif group.pair.name == "universal":
                # The carrier mimics the joint, so the joint comes first.
                self._add_merged(group, members)
                tasks += carriers + outer
            elif task == "joint":
                # The carriers have the angles that outer joints may mimic, so they come before the joint.
                tasks += [("ball", index), *carriers]
            else:
                self._add_merged(group, members)
                tasks += outer

    def _drop_between(self, members: Sequence[JointNode]) -> None:
        """Fix everything between the axes of a merged joint to the body before it, with all joints at zero."""
        before = members[0].parent
        waiting = [member.index for member in members[:-1]]
        while waiting:
            index = waiting.pop()
            self.lumped[index] = before
            self._places[index] = self._placed_with(before, self._nodes[index].T_root)
            waiting += [child for child in self._nodes[index].children if child not in self._merged]

    def _add_single(self, node: JointNode) -> None:
        if node.kind == "fixed":
            self._places[node.index] = self._placed_with(node.parent, node.T_root)
            return
        if node.mimic is not None:
            self._add_follower(node)
            return
        joint = self._source.joints[node.index]
        index = self._add(node, joint)
        if node.kind == "free":  # the first joint of both models
            for kind, count in (("Position", joint.nq), ("Velocity", joint.nv), ("Effort", joint.nv)):
                for name in (f"lower{kind}Limit", f"upper{kind}Limit"):
                    getattr(self.model, name)[:count] = getattr(self._source, name)[:count]
        else:
            self._set_holder(node, index, 0, derived=False)

    def _add_merged(self, group: MultiDofJoint, members: list[JointNode]) -> None:
        T_last = members[-1].T_root
        T_joint = pin.SE3(T_last.rotation, np.array(group.centre))
        axes = group.axes @ T_joint.rotation
        parent, placement = self._placed_with(members[0].parent, T_joint)
        joint = group.pair.joint_model(axes if group.pair.axes else ())
        index = int(self.model.addJoint(parent, joint, placement, group.name))
        self._places[members[-1].index] = index, T_joint.actInv(T_last)
        if group.pair.name == "universal":
            for place, node in enumerate(members):
                self._set_holder(node, index, place, derived=False)
        else:
            first, second, third = members
            joint = self.model.joints[index]
            self.balls.append(Ball(group.name, (first, second, third), axes, joint.idx_q, joint.idx_v))

    def _add_carrier(self, group: MultiDofJoint, node: JointNode) -> None:
        self.carriers.append(node.name)
        if group.pair.name == "universal":
            holder = next(slot for slot in self.slots if slot.joint is node)
            self._add(node, self._mimic(node, holder, 1.0, 0.0))
        else:
            self._add_follower(node)

    def _add_follower(self, node: JointNode) -> None:
        """Add a joint that mimics the coordinate with its driver's value, or a joint with its own coordinate.

        The joint has its own coordinate if it is a driver on a carrier, if its driver's value is inside a ball or comes
        later in the model, or if Pinocchio's crba would be wrong.
        """
        mimic = node.coupling
        holder = self._holders.get(mimic.joint)
        if holder is None or self._misleads_crba(node, holder.index):
            self._set_holder(node, self._add(node, _motion(node)), 0, derived=True)
            return
        self._add(node, self._mimic(node, holder, mimic.multiplier, mimic.offset))
        if holder.derived and node.name not in self.carriers:
            source = Reading(holder.column).follower_of(mimic)
            self.followers.append((node, source))

    def _misleads_crba(self, node: JointNode, holder: int) -> bool:
        """Return whether crba of Pinocchio 4.1 would compute a wrong mass matrix with this follower as a mimic joint.

        It would in two cases: a joint of several coordinates carries the follower but not its driver; or more than one
        coordinate comes directly behind the follower in the tree, of which crba couples only the first.
        """
        shared = set(self.model.supports[holder]) - {holder}
        carrying = set(self.model.supports[self._places[node.parent][0]]) - shared
        return any(self.model.joints[joint].nv > 1 for joint in carrying) or self._coordinates_behind(node) > 1

    def _coordinates_behind(self, node: JointNode) -> int:
        """Return the number of coordinates that would come directly behind this joint as a mimic joint."""
        return sum(self._coordinates_from(node, self._nodes[child]) for child in node.children)

    def _coordinates_from(self, carrying: JointNode, node: JointNode) -> int:
        group = self._merged.get(node.index)
        if group is not None and group is self._merged.get(carrying.index):
            # The carriers of a ball carry each other; the last joint of the group is the ball, on another branch.
            return int(node.name != group.joints[-1])
        if group is not None:
            # Two for a ball: the ball and its first carrier.
            return 2 if group.pair.name == "spherical" else 1
        if node.kind == "fixed":
            return self._coordinates_behind(node)
        if node.mimic is None or node.mimic.joint not in self._holders:
            return 1
        return min(self._coordinates_behind(node), 1)

    def _add(self, node: JointNode, joint: pin.JointModel) -> int:
        parent, T_parent = self._places[node.parent]
        placement = T_parent * self._source.jointPlacements[node.index]
        index = int(self.model.addJoint(parent, joint, placement, node.name))
        self._places[node.index] = index, pin.SE3.Identity()
        return index

    def _set_holder(self, node: JointNode, index: int, place: int, *, derived: bool) -> None:
        """Make coordinate `place` of a joint of this model the value of a joint of the robot."""
        joint, model = self.model.joints[index], self.model
        column, row = joint.idx_q + place, joint.idx_v + place
        self.slots.append(Slot(node, index, column, row, derived))
        if node.mimic is None:
            self._holders[node.name] = self.slots[-1]
        if derived:
            # The coordinate of a carrier does not determine the joint's value, and is only a hint.
            readings = self.followers if node.mimic is not None and node.name not in self.carriers else self.hints
            readings.append((node, Reading(column)))
        model.lowerPositionLimit[column], model.upperPositionLimit[column] = node.lower, node.upper
        speed = abs(node.coupling.multiplier) * self._source.upperVelocityLimit[node.row]
        model.lowerVelocityLimit[row], model.upperVelocityLimit[row] = -speed, speed
        if node.mimic is None:
            effort = self._source.upperEffortLimit[node.row]
            model.lowerEffortLimit[row], model.upperEffortLimit[row] = -effort, effort

    def _mimic(self, node: JointNode, holder: Slot, multiplier: float, offset: float) -> pin.JointModel:
        joint, motion = self.model.joints[holder.index], _motion(node)
        # Pinocchio reads only these indices, so a mimic joint can follow any coordinate of any joint.
        extended = joint.idx_vExtended + holder.row - joint.idx_v
        motion.setIndexes(joint.id, holder.column, holder.row, extended)
        return pin.JointModel(pin.JointModelMimic(pin.JointModel(motion), multiplier, offset))

    def _placed_with(self, index: int, T_root: pin.SE3) -> tuple[int, pin.SE3]:
        """Return the joint that moves with a joint of the robot, and T_root in that joint's frame, all at zero."""
        joint, T_joint = self._places[index]
        return joint, T_joint * self._nodes[index].T_root.actInv(T_root) if index else T_joint * T_root

    def _add_bodies_and_frames(self, groups: JointGroups) -> None:
        for index, inertia in enumerate(self._source.inertias):
            joint, T_joint = self._places[index]
            self.model.appendBodyToJoint(joint, inertia, T_joint)
        # Index of a frame in the robot → its index in this model, or that of the nearest frame before it if dropped.
        places = [0]
        for frame in list(self._source.frames)[1:]:
            if frame.parentJoint in self.lumped:
                places.append(places[frame.parentFrame])
                continue
            joint, T_joint = self._places[frame.parentJoint]
            before = places[frame.parentFrame]
            copy = pin.Frame(frame.name, joint, before, T_joint * frame.placement, frame.type)
            places.append(int(self.model.addFrame(copy, False)))
        for group in groups:
            if len(group.axes) > 1:
                first = self._source.frames[self._source.getFrameId(group.joints[0], pin.FrameType.JOINT)]
                self.model.addJointFrame(self.model.getJointId(group.name), places[first.parentFrame])


def _motion(node: JointNode) -> pin.JointModel:
    kind = pin.JointModelRevoluteUnaligned if node.kind == "revolute" else pin.JointModelPrismaticUnaligned
    return kind(node.axis)
