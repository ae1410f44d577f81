"""Poses as the numbers people write down."""

from __future__ import annotations

from enum import Enum

import numpy as np

from nao_kin import rotations
from nao_kin._arrays import Floats


class PoseFormat(Enum):
    """How a pose is written.

    MATRIX: the 16 entries of the homogeneous matrix, row by row, as NAOqi's getTransform has them.
    POSITION6D: x, y, z, wx, wy, wz with R = Rz(wz) Ry(wy) Rx(wx), as NAOqi's getPosition has them.
    RPY: x, y, z, roll, pitch, yaw with R = Rz(yaw) Ry(pitch) Rx(roll).
    QUATERNION: x, y, z and the unit quaternion r0, r1, r2, r3, scalar first.
    """

    MATRIX = "matrix"
    POSITION6D = "position6d"
    RPY = "rpy"
    QUATERNION = "quaternion"


_POSITION = ("x", "y", "z")
_ORIENTATION = {
    PoseFormat.POSITION6D: ("wx", "wy", "wz"),
    PoseFormat.RPY: ("roll", "pitch", "yaw"),
    PoseFormat.QUATERNION: ("r0", "r1", "r2", "r3"),
}


def pose_columns(style: PoseFormat, *, degrees: bool) -> tuple[str, ...]:
    """Names of the numbers; angles in degrees carry a _deg."""
    if style is PoseFormat.MATRIX:
        return tuple(f"t{i}{j}" for i in range(1, 5) for j in range(1, 5))
    suffix = "_deg" if degrees and style is not PoseFormat.QUATERNION else ""
    return (*_POSITION, *(name + suffix for name in _ORIENTATION[style]))


def pose_numbers(T: Floats, style: PoseFormat, *, degrees: bool) -> Floats:
    """Homogeneous matrices (..., 4, 4) as rows of numbers, in the order of `pose_columns`."""
    if style is PoseFormat.MATRIX:
        return T.reshape(*T.shape[:-2], 16)
    if style is PoseFormat.QUATERNION:
        orientation = rotations.quat_from_matrix(T[..., :3, :3])
    else:
        orientation = rotations.rpy_from_matrix(T[..., :3, :3])
        if degrees:
            orientation = np.degrees(orientation)
    return np.concatenate([T[..., :3, 3], orientation], axis=-1)
