"""The path of one effector: poses at times, and the curve through them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.motion import Motion
from nao_kin.rotations import exp, log

_COORDINATES = ("x", "y", "z")


class EffectorPath:
    """A curve through poses at times, at rest at both ends.

    x, y and z each go along the monotone cubic of `nao_kin.motion`: straight to a single target, and never beyond the
    keys beside it. The rotation turns from key to key about one axis (slerp); how far it has turned in all is such a
    cubic too.

    Args:
        times: of the keys, ascending, shape (k,) [s].
        poses: at these times, shape (k, 4, 4).
    """

    def __init__(self, times: Sequence[float] | Floats, poses: Floats) -> None:
        self._times = np.asarray(times, dtype=np.float64)
        self._R = np.array(poses[:, :3, :3])
        self._turns = log(np.swapaxes(self._R[:-1], -1, -2) @ self._R[1:])
        angles = np.linalg.norm(self._turns, axis=-1)
        self._turned = np.concatenate([[0.0], np.cumsum(angles)])
        keys = np.column_stack([poses[:, :3, 3], self._turned])
        self._motion = Motion(self._times, (*_COORDINATES, "turn"), keys, "smooth")

    @property
    def end(self) -> float:
        """Time of the last key [s]."""
        return float(self._times[-1])

    def segment(self, time: float) -> int:
        """Which two keys a time lies between: 0 from the first to the second."""
        return int(np.clip(np.searchsorted(self._times, time, side="right") - 1, 0, max(0, len(self._times) - 2)))

    def pose(self, time: float) -> Floats:
        """The pose at a time, shape (4, 4)."""
        x, y, z, turned = self._motion.sample(time)
        T = np.eye(4)
        T[:3, 3] = x, y, z
        at = self.segment(time)
        if at >= len(self._turns):
            T[:3, :3] = self._R[-1]
            return T
        whole = self._turned[at + 1] - self._turned[at]
        share = min(max((turned - self._turned[at]) / whole, 0.0), 1.0) if whole > 0.0 else 1.0
        T[:3, :3] = self._R[at] @ exp(share * self._turns[at])
        return T


def moved_by(change: Floats, T: Floats) -> Floats:
    """A pose after a change along the axes of its space: places add up, and turns are made about these axes.

    Args:
        change: shape (..., 4, 4).
        T: the pose before, shape (4, 4).
    """
    moved = np.array(np.broadcast_to(T, change.shape))
    moved[..., :3, :3] = change[..., :3, :3] @ T[:3, :3]
    moved[..., :3, 3] += change[..., :3, 3]
    return moved
