"""Configurations as callers give them: checked once, and refused with the names of their joints."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._common.arrays import Floats, as_floats
from nao_kin._common.warn import warn_caller
from nao_kin.errors import BadArgument, DegreesWarning, NotFinite
from nao_kin.robot.build import Base
from nao_kin.robot.coordinates import UNIT_TOLERANCE

TURN = 2.0 * math.pi

_FLOAT64 = np.dtype(np.float64)
# Quaternions that are looked at at a time: few enough to take no memory to speak of.
_BLOCK = 1 << 15


class ConfigurationChecks:
    """What configurations of one robot must be.

    Args:
        base: "fixed" or "floating".
        nq: numbers in a configuration.
        joint_names: the joints with a coordinate of their own, which are the last numbers.
        turning: which of them turn.
        lower: their smallest values.
        upper: their largest values.
    """

    def __init__(
        self,
        base: Base,
        nq: int,
        joint_names: tuple[str, ...],
        turning: Sequence[bool],
        lower: Floats,
        upper: Floats,
    ) -> None:
        self._floating = base == "floating"
        self._shape = (nq,)
        self._names, self._lower, self._upper = joint_names, lower, upper
        self._bounded = np.array(turning, dtype=np.bool_) & np.isfinite(lower) & np.isfinite(upper)
        self._offset = nq - len(joint_names)

    def posed(self, q: ArrayLike) -> Floats:
        """`q` as configurations for poses, which come out whatever the unit: with a warning where it is degrees."""
        one = type(q) is np.ndarray and q.shape == self._shape and q.dtype is _FLOAT64
        if one and not self._floating and math.hypot(*q.tolist()) <= TURN:  # type: ignore[union-attr]
            # The common case in as few steps as possible: within a turn of zero nothing is infinite or in degrees.
            return q  # type: ignore[return-value]
        array = self.checked(q)
        self.warn_of_degrees(array)
        return array

    def checked(self, q: ArrayLike) -> Floats:
        """`q` as configurations: finite, of the right shape, with a unit quaternion for a floating base."""
        try:
            array = as_floats(q, self._shape, "q")
        except NotFinite as error:
            raise self._named(error) from None
        if self._floating:
            self.check_base(array)
            array = array.copy()
            # What is left of the norm would end up in the rotation matrices.
            array[..., 3:7] /= np.linalg.norm(array[..., 3:7], axis=-1)[..., None]
        return array

    def check_base(self, q: NDArray[Any]) -> None:
        """Refuse quaternions of a floating base that are not of unit length; what is not finite is another matter."""
        if not self._floating:
            return
        quaternions = q[..., 3:7]
        quaternions = quaternions.reshape(-1, 4) if quaternions.ndim > 2 else np.atleast_2d(quaternions)
        for start in range(0, len(quaternions), _BLOCK):
            norms = np.linalg.norm(quaternions[start : start + _BLOCK], axis=-1)
            error = np.abs(norms - 1.0)
            if np.any(error > UNIT_TOLERANCE):
                self.refuse_non_finite(q)
                worst = float(norms[np.argmax(error)])
                raise BadArgument(f"q[..., 3:7] must be a unit quaternion (x, y, z, w), got one of norm {worst:.6g}")

    def refuse_non_finite(self, q: NDArray[Any]) -> None:
        """Raise `NotFinite` for the first NaN or infinity, with the name of its joint."""
        finite = np.isfinite(q)
        if not finite.all():
            index = tuple(int(i) for i in np.argwhere(~finite)[0])
            raise self._named(NotFinite("q", index, float(q[index])))

    def warn_of_degrees(self, q: NDArray[Any]) -> None:
        """Warn where a turning joint with limits is outside of them and more than a turn from zero."""
        joints = q[..., self._offset :]
        if not joints.size or max(float(joints.max()), -float(joints.min())) <= TURN:
            return
        wrong = (np.abs(joints) > TURN) & ((joints < self._lower) | (joints > self._upper)) & self._bounded
        if wrong.any():
            place = tuple(np.argwhere(wrong)[0])
            joint, value = self._names[place[-1]], float(joints[place])
            warn_caller(
                f"{joint} = {value:.6g} rad is more than a full turn; q is in radians, np.deg2rad(q) converts degrees",
                DegreesWarning,
                subject="degrees",
            )

    def _named(self, error: NotFinite) -> NotFinite:
        column = error.index[-1] - self._offset
        return NotFinite("q", error.index, error.value, self._names[column] if column >= 0 else "base")
