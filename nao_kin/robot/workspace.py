"""One thread's Pinocchio data, and any set of frame poses gathered from it in one step.

Pinocchio keeps the placements of all frames in one block of memory: twelve doubles each, the columns of R, then p. A
pose as a 4×4 matrix is therefore a fixed selection of that block; its zeros and its one are found in the first frame,
the universe, whose placement is always the identity. Selecting takes a tenth of the time of reading the placements one
by one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from nao_kin._arrays import Floats
from nao_kin.errors import UnknownName

_DOUBLES = 12
_ONE, _ZERO = 0, 1  # where the universe's rotation, stored by columns, holds a one and a zero

Selection = NDArray[np.intp]

# Where a twist is taken and in whose axes, by the names that methods use for it.
EXPRESSIONS = {
    "frame": pin.ReferenceFrame.LOCAL,
    "root": pin.ReferenceFrame.WORLD,
    "mixed": pin.ReferenceFrame.LOCAL_WORLD_ALIGNED,
}


def expression_named(name: str) -> pin.ReferenceFrame:
    """Pinocchio's reference frame for "frame", "root" or "mixed".

    Raises:
        UnknownName: none of the three.
    """
    if not isinstance(name, str) or name not in EXPRESSIONS:
        raise UnknownName("expression", name, tuple(EXPRESSIONS))
    return EXPRESSIONS[name]


def over_batch(q: Floats, shape: tuple[int, ...], compute: Callable[[Floats], Floats]) -> Floats:
    """`compute` for every configuration of a batch (..., nq), the results in one array (..., *shape)."""
    count = math.prod(q.shape[:-1])
    results = np.empty((count, *shape))
    for row, result in zip(q.reshape(count, q.shape[-1]), results, strict=True):
        result[...] = compute(row)
    return results.reshape(*q.shape[:-1], *shape)


def selection_of(frame_ids: Sequence[int]) -> Selection:
    """Where in the block the entries of the poses of these frames stand, shape (n, 4, 4)."""
    selection = np.full((len(frame_ids), 4, 4), _ZERO, dtype=np.intp)
    row, column = np.indices((3, 4))
    selection[:, :3] = _DOUBLES * np.asarray(frame_ids, dtype=np.intp)[:, None, None] + 3 * column + row
    selection[:, 3, 3] = _ONE
    return selection


class Workspace:
    """Pinocchio's data for one model; not to be shared between threads."""

    def __init__(self, model: pin.Model) -> None:
        self.model = model
        self.data = model.createData()
        self._block = _block_of(self.data, model.nframes)

    def pose(self, q: Floats, frame_id: int, selection: Selection) -> Floats:
        """The pose of one frame at configuration q, in the shape of `selection`."""
        pin.forwardKinematics(self.model, self.data, q)
        pin.updateFramePlacement(self.model, self.data, frame_id)
        pose: Floats = self._placements().take(selection)
        return pose

    def poses(self, q: Floats, selection: Selection) -> Floats:
        """The poses of any frames at configuration q, in the shape of `selection`."""
        pin.framesForwardKinematics(self.model, self.data, q)
        poses: Floats = self._placements().take(selection)
        return poses

    def jacobian(self, q: Floats, frame_id: int, expression: pin.ReferenceFrame) -> Floats:
        """The 6 × nv Jacobian of one frame, linear rows first."""
        jacobian: Floats = pin.computeFrameJacobian(self.model, self.data, q, frame_id, expression)
        return jacobian.reshape(6, self.model.nv)  # with one degree of freedom, a vector comes back

    def com(self, q: Floats) -> Floats:
        """Centre of mass of everything that moves; what is fixed to the world is not in it."""
        com: Floats = pin.centerOfMass(self.model, self.data, q)
        return com

    def _placements(self) -> Floats:
        if self._block is not None:
            return self._block
        return np.concatenate([np.append(pose.rotation.T, pose.translation) for pose in self.data.oMf])


def _block_of(data: pin.Data, count: int) -> Floats | None:
    """A view of all placements as one array; None when this Pinocchio lays them out otherwise."""
    first: Floats = data.oMf[0].rotation
    start = _address(first)
    for i in {0, count // 2, count - 1}:
        rotation, translation = data.oMf[i].rotation, data.oMf[i].translation
        expected = start + i * _DOUBLES * 8
        if _address(rotation) != expected or _address(translation) != expected + 9 * 8 or rotation.strides != (8, 24):
            return None
    return np.lib.stride_tricks.as_strided(first, shape=(count * _DOUBLES,), strides=(8,), writeable=False)


def _address(array: Floats) -> int:
    return int(array.__array_interface__["data"][0])
