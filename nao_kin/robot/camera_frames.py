"""The frames of one camera: its body frame, and the optical frame in which images are processed."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from nao_kin._core.arrays import Floats, join_poses
from nao_kin.robot.urdf import UrdfTree

if TYPE_CHECKING:
    from nao_kin.robot.model import RobotModel

# Axes of an optical frame (z along the optical axis, x to the right, y down) in the body frame (x along the optical
# axis, y to the left, z up). Source: REP 103, which also gives the ending of the name.
_T_BODY_OPTICAL = join_poses(np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]), np.zeros(3))
_ENDINGS = ("_optical", "_optical_frame")
# Largest difference from these axes in a file with rounded angles.
_ROUNDED = 1e-3


def camera_of(tree: UrdfTree, cameras: Iterable[str], frame: str) -> tuple[str, Floats] | None:
    """Return the camera that has this frame beside its body frame, and T_body_frame; None for other frames.

    It is the camera's optical frame, or a second name of its body frame, as CameraTop_frame in ROS: a frame fixed to
    the body frame, without translation.
    """
    link = tree.shared_names.get(frame, frame)
    row = next((joint for joint in tree.joints if joint.child == link and joint.kind == "fixed"), None)
    if row is None:
        return None
    for camera in cameras:
        if tree.shared_names.get(camera, camera) == row.parent:
            for T in (np.eye(4), _T_BODY_OPTICAL):
                if np.abs(row.origin.matrix - T).max() < _ROUNDED:
                    return camera, T
    return None


def body_frame_of(robot: RobotModel, frame: str) -> str:
    """Return the body frame of the camera that has this frame beside it; other frames as they are."""
    found = camera_of(robot.tree, robot.semantics.cameras, frame)
    return frame if found is None else found[0]


def pose_of_body(robot: RobotModel, frame: str) -> Floats | None:
    """Return the pose of a camera's body frame in its optical frame; None if `frame` is not an optical frame.

    An optical frame is that of a camera of the semantics, or has a name that ends as in REP 103.
    """
    cameras = robot.semantics.cameras
    if frame in cameras:
        return None
    found = camera_of(robot.tree, cameras, frame)
    optical = frame.endswith(_ENDINGS) if found is None else found[1] is _T_BODY_OPTICAL
    return _T_BODY_OPTICAL.T if optical else None
