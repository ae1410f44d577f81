"""Poses as MuJoCo writes them, and the frames that semantics name."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from nao_kin.rotations import quat_from_matrix
from nao_kin.urdf import Origin, UrdfTree


def pose(origin: Origin) -> pin.SE3:
    """Where a URDF's origin stands."""
    return pin.SE3(pin.rpy.rpyToMatrix(*origin.rpy), np.array(origin.xyz))


def pos_quat(T: pin.SE3) -> dict[str, list[float]]:
    """Position [m] and quaternion, scalar first."""
    return {"pos": (T.translation + 0.0).tolist(), "quat": (quat_from_matrix(T.rotation) + 0.0).tolist()}


def link_of(tree: UrdfTree, frame: str) -> str:
    """The link that a frame's name means: a link, or the one that the joint of this name moves."""
    if frame in tree.links:
        return frame
    if frame in tree.shared_names:
        return tree.shared_names[frame]
    return next(joint.child for joint in tree.joints if joint.name == frame)
