"""Frames of a robot's joints in the registers of a program."""

from __future__ import annotations

from nao_kin.batch.program import Builder, Frame, Register
from nao_kin.batch.tree import ROOT, JointTree, TreeFrame


class PosedTree:
    """Frames of joints in registers, made when they are asked for.

    Args:
        builder: where the operations go.
        tree: the joints.
        origin: the joint whose frame is the identity: all that is asked for must hang on it.
    """

    def __init__(self, builder: Builder, tree: JointTree, origin: int = ROOT) -> None:
        self.builder, self.tree = builder, tree
        self._frames: dict[int, Frame] = {origin: builder.root}
        # The axis of each joint as its own frame has it before the joint moves.
        self._axes: dict[int, Register] = {}

    def frame(self, joint: int) -> Frame:
        """The frame of a joint."""
        for place in self.tree.chain(joint):
            if place not in self._frames:
                parent = self.tree.joints[place].parent
                if parent in self._frames:
                    self._frames[place] = self._moved(place, self._frames[parent])
        return self._frames[joint]

    def placed(self, frame: TreeFrame) -> Frame:
        """A frame held to a joint."""
        return self.builder.placed(self.frame(frame.joint), frame.R, frame.t)

    def axis(self, joint: int) -> tuple[Register, float]:
        """The direction of a joint's axis, and the weight of its speed along or about it."""
        self.frame(joint)
        row = self.tree.joints[joint]
        return self._axes[joint], row.ratio if row.kind == "prismatic" else row.ratio * row.principal[1]

    def _moved(self, place: int, parent: Frame) -> Frame:
        builder, joint = self.builder, self.tree.joints[place]
        if joint.kind == "free":
            first = joint.coordinate  # a floating base stands in the world, where no joint carries it
            return Frame(*builder.orientation(first + 3), builder.position(first))
        k, sign = joint.principal
        if joint.kind == "prismatic":
            frame = builder.placed(parent, joint.R, joint.t)
            direction = builder.combination(builder.zero, zip(frame.columns, joint.axis, strict=True))
            self._axes[place] = direction
            origin = builder.combination(frame.origin, [(direction, joint.offset)])
            return Frame(*frame.columns, builder.scaled(origin, direction, joint.coordinate, joint.ratio))
        R = joint.R if joint.aligned else joint.R @ joint.alignment
        frame = builder.placed(parent, R, joint.t)
        self._axes[place] = frame.columns[k]
        angle = builder.angle(joint.coordinate, sign * joint.ratio, sign * joint.offset)
        turned = builder.turned(frame, k, angle)
        if joint.aligned:
            return turned
        columns = (
            builder.combination(builder.zero, zip(turned.columns, row, strict=True)) for row in joint.alignment.tolist()
        )
        x, y, z = columns
        return Frame(x, y, z, turned.origin)
