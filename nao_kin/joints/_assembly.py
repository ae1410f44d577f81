"""The Pinocchio model of a robot whose merged joints are universal and spherical joints.

A merged joint has no links between its axes, but the robot has: they carry mass and frames. Each stays on a carrier, a
revolute joint about the original axis, on a side branch. The carrier of a universal joint mimics the universal joint's
own coordinate. A ball has no angles to mimic, so its carriers have coordinates of their own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from nao_kin.joints._readings import Ball, Slot, Source
from nao_kin.joints.grouping import JointNode
from nao_kin.joints.pairs import JointGroups, MultiDofJoint
from nao_kin.robot import LIMIT_ARRAYS, RobotModel
from nao_kin.robot.semantics import Mimic


class _Holder(NamedTuple):
    """The joint here that holds the value of a joint of the robot, and the place among that joint's coordinates."""

    joint: int
    place: int
    derived: bool


class Assembly:
    """A typed model, put together on construction.

    Attributes:
        model: the Pinocchio model; its first frames are the robot's, in the robot's order.
        slots: its coordinates that are joint values.
        balls: its spherical joints.
        followers: joints whose value it holds beside that of their driver, and where.
        hints: joints whose value it holds a second time, without a say in it, and where.
        carriers: names of the carriers.
        lumped: joints of the robot that have no place in the model → the joint that their bodies are fixed to.
    """

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
        self.slots: list[Slot] = []
        self.balls: list[Ball] = []
        self.followers: list[tuple[JointNode, Source]] = []
        self.hints: list[tuple[JointNode, Source]] = []
        self.carriers: list[str] = []
        self.lumped: dict[int, int] = {}
        self._keep = keep
        # Joint of the robot → the joint here that moves with it, and where in that joint's frame it is.
        self._places = {0: (0, pin.SE3.Identity())}
        self._holders: dict[str, _Holder] = {}
        self._add_joints(groups)
        self._add_bodies_and_frames(groups)

    def _add_joints(self, groups: JointGroups) -> None:
        # Pinocchio's algorithms want the joints in depth-first order; the last task added is the next one done.
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
                # Its carrier mimics it and comes after it.
                self._add_merged(group, members)
                tasks += carriers + outer
            elif task == "joint":
                # Its carriers hold the angles that joints further out may mimic, and come before it.
                tasks += [("ball", index), *carriers]
            else:
                self._add_merged(group, members)
                tasks += outer

    def _drop_between(self, members: Sequence[JointNode]) -> None:
        """Fix all that moves between the axes of a merged joint to the body before it, as with all joints at zero."""
        before = members[0].parent
        waiting = [member.index for member in members[:-1]]
        while waiting:
            index = waiting.pop()
            self.lumped[index] = before
            self._places[index] = self._held(before, self._nodes[index].T_root)
            waiting += [child for child in self._nodes[index].children if child not in self._merged]

    def _add_single(self, node: JointNode) -> None:
        if node.kind == "fixed":
            self._places[node.index] = self._held(node.parent, node.T_root)
            return
        parent, T_parent = self._places[node.parent]
        placement = T_parent * self._source.jointPlacements[node.index]
        if node.mimic is not None:
            self._add_follower(node, node.mimic, parent, placement)
            return
        joint = self._source.joints[node.index]
        index = self._add(node, parent, joint, placement)
        if node.kind == "free":  # the first joint of both models
            for name in LIMIT_ARRAYS:
                count = joint.nq if "Position" in name else joint.nv
                getattr(self.model, name)[:count] = getattr(self._source, name)[:count]
        else:
            self._hold(node, index, 0, derived=False)

    def _add_merged(self, group: MultiDofJoint, members: list[JointNode]) -> None:
        T_last = members[-1].T_root
        T_joint = pin.SE3(T_last.rotation, np.array(group.centre))
        axes = group.axes @ T_joint.rotation
        parent, placement = self._held(members[0].parent, T_joint)
        joint = group.pair.joint_model(axes if group.pair.axes else ())
        index = int(self.model.addJoint(parent, joint, placement, group.name))
        self._places[members[-1].index] = index, T_joint.actInv(T_last)
        if group.pair.name == "universal":
            for place, node in enumerate(members):
                self._hold(node, index, place, derived=False)
        else:
            first, second, third = members
            joint = self.model.joints[index]
            self.balls.append(Ball(group.name, (first, second, third), axes, joint.idx_q, joint.idx_v))

    def _add_carrier(self, group: MultiDofJoint, node: JointNode) -> None:
        parent, T_parent = self._places[node.parent]
        placement = T_parent * self._source.jointPlacements[node.index]
        self.carriers.append(node.name)
        if group.pair.name == "universal":
            holder = _Holder(self.model.getJointId(group.name), 0, derived=False)
            self._add(node, parent, self._mimic(node, holder, 1.0, 0.0), placement)
        elif node.mimic is not None:
            self._add_follower(node, node.mimic, parent, placement)
        else:
            self._hold(node, self._add(node, parent, _motion(node), placement), 0, derived=True)

    def _add_follower(self, node: JointNode, mimic: Mimic, parent: int, placement: pin.SE3) -> None:
        """A joint that mimics the joint that holds its driver's value, or with a coordinate of its own.

        It has its own where the driver's value is inside a ball, or comes later, or where Pinocchio's crba goes wrong.
        """
        holder = self._holders.get(mimic.joint)
        if holder is None or self._misleads_crba(node, holder.joint, parent):
            self._hold(node, self._add(node, parent, _motion(node), placement), 0, derived=True)
            return
        self._add(node, parent, self._mimic(node, holder, mimic.multiplier, mimic.offset), placement)
        if holder.derived and node.name not in self.carriers:
            source = Source(self.model.joints[holder.joint].idx_q + holder.place).follower_of(mimic)
            self.followers.append((node, source))

    def _misleads_crba(self, node: JointNode, holder: int, parent: int) -> bool:
        """Whether crba of Pinocchio 4.1 would put wrong entries into the mass matrix if this follower mimicked.

        It does where a joint of several coordinates carries the follower but not the joint it mimics, and where more
        than one coordinate begins behind the follower: it couples the first alone.
        """
        shared = set(self.model.supports[holder]) - {holder}
        carrying = set(self.model.supports[parent]) - shared
        return any(self.model.joints[joint].nv > 1 for joint in carrying) or self._branches(node) > 1

    def _branches(self, node: JointNode) -> int:
        """How many coordinates begin behind a joint that mimics, those behind other joints left out."""
        return sum(self._begun_by(node, self._nodes[child]) for child in node.children)

    def _begun_by(self, carrying: JointNode, node: JointNode) -> int:
        group, own = self._merged.get(node.index), self._merged.get(carrying.index)
        if group is not None and group is own:
            # Carriers of one ball carry each other; its last joint is the ball itself, elsewhere.
            return int(node.name != group.joints[-1])
        if group is not None:
            # A ball, and beside it its first carrier.
            return 2 if group.pair.name == "spherical" else 1
        if node.kind == "fixed":
            return self._branches(node)
        if node.mimic is None or node.mimic.joint not in self._holders:
            return 1
        return min(self._branches(node), 1)

    def _add(self, node: JointNode, parent: int, joint: pin.JointModel, placement: pin.SE3) -> int:
        index = int(self.model.addJoint(parent, joint, placement, node.name))
        self._places[node.index] = index, pin.SE3.Identity()
        return index

    def _hold(self, node: JointNode, index: int, place: int, *, derived: bool) -> None:
        """Make coordinate `place` of a joint of this model the value of a joint of the robot."""
        if not node.follows:
            self._holders[node.name] = _Holder(index, place, derived)
        joint, model = self.model.joints[index], self.model
        column, row = joint.idx_q + place, joint.idx_v + place
        self.slots.append(Slot(node, column, row, derived))
        if derived:
            # What only carries links between the axes of a merged joint has no say in its value.
            held = self.followers if node.follows and node.name not in self.carriers else self.hints
            held.append((node, Source(column)))
        model.lowerPositionLimit[column], model.upperPositionLimit[column] = node.lower, node.upper
        speed = abs(node.coupling.multiplier) * self._source.upperVelocityLimit[node.row]
        model.lowerVelocityLimit[row], model.upperVelocityLimit[row] = -speed, speed
        if not node.follows:
            effort = self._source.upperEffortLimit[node.row]
            model.lowerEffortLimit[row], model.upperEffortLimit[row] = -effort, effort

    def _mimic(self, node: JointNode, holder: _Holder, multiplier: float, offset: float) -> pin.JointModel:
        joint, place = self.model.joints[holder.joint], holder.place
        motion = _motion(node)
        # Pinocchio follows the indices, and so any coordinate of any joint.
        motion.setIndexes(joint.id, joint.idx_q + place, joint.idx_v + place, joint.idx_vExtended + place)
        return pin.JointModel(pin.JointModelMimic(pin.JointModel(motion), multiplier, offset))

    def _held(self, index: int, T_root: pin.SE3) -> tuple[int, pin.SE3]:
        """The joint here that moves with a joint of the robot, and in its frame a pose of the root's, all at zero."""
        joint, T_joint = self._places[index]
        return joint, T_joint * self._nodes[index].T_root.actInv(T_root) if index else T_joint * T_root

    def _add_bodies_and_frames(self, groups: JointGroups) -> None:
        for index, inertia in enumerate(self._source.inertias):
            joint, T_joint = self._places[index]
            self.model.appendBodyToJoint(joint, inertia, T_joint)
        # Place of a frame in the robot → its place here; of one that is dropped, that of the nearest before it.
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
