"""The joints of a Pinocchio model as the batch kernels take them."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from nao_kin.batch import JointTree, TreeFrame, TreeJoint
from nao_kin.urdf import UrdfTree


def joint_tree(model: pin.Model, tree: UrdfTree) -> JointTree:
    """The joints of a model that `build_model` made of this tree."""
    joints: list[TreeJoint] = []
    drivers: dict[str, pin.JointModel] = {}
    moving = list(tree.moving_joints)
    first = model.njoints - len(moving)  # 2 where a floating base comes before them
    for index in range(1, model.njoints):
        placement, inertia = model.jointPlacements[index], model.inertias[index]
        own = model.joints[index]
        kind, axis, ratio, offset = "free", (1.0, 0.0, 0.0), 1.0, 0.0
        if index >= first:
            row = moving[index - first]
            kind, axis = row.kind, row.axis
            if row.mimic is None:
                drivers[row.name] = own
            else:
                own, ratio, offset = drivers[row.mimic.joint], row.mimic.multiplier, row.mimic.offset
        joints.append(
            TreeJoint(
                kind=kind,
                parent=int(model.parents[index]) - 1,
                R=np.array(placement.rotation),
                t=np.array(placement.translation),
                axis=axis,
                coordinate=int(own.idx_q),
                velocity=int(own.idx_v),
                ratio=ratio,
                offset=offset,
                mass=float(inertia.mass),
                moment=tuple((inertia.mass * inertia.lever).tolist()),
            )
        )
    held = model.inertias[0]
    return JointTree(
        int(model.nq), int(model.nv), tuple(joints), float(held.mass), tuple((held.mass * held.lever).tolist())
    )


def tree_frame(model: pin.Model, frame_id: int) -> TreeFrame:
    """A frame of the model by the joint that holds it."""
    frame = model.frames[frame_id]
    return TreeFrame(
        int(frame.parentJoint) - 1, np.array(frame.placement.rotation), np.array(frame.placement.translation)
    )
