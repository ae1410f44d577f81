"""The quaternions of a typed configuration: which of its numbers they are, and that they are rotations."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._arrays import Floats, as_floats
from nao_kin.errors import BadArgument
from nao_kin.robot.coordinates import UNIT_TOLERANCE


class Quaternions:
    """Where the quaternions (x, y, z, w) of a typed configuration stand."""

    def __init__(self, nq: int, starts: Mapping[str, int]) -> None:
        """Args: number of coordinates, and name of the joint (or "base") → column where its quaternion begins."""
        self._nq, self._names = nq, tuple(starts)
        self._columns = np.array(list(starts.values()), dtype=np.intp)[:, None] + np.arange(4)

    def checked(self, q_typed: ArrayLike) -> Floats:
        """`q_typed` with quaternions of norm 1 to rounding; a copy wherever there are any.

        Raises:
            BadArgument: a quaternion whose norm is not 1 to 1e-6, with its joint and its place in the batch.
            WrongShape, NotFinite: no typed configuration.
        """
        typed = as_floats(q_typed, (self._nq,), "q_typed")
        if not self._names:
            return typed
        parts = typed[..., self._columns]
        with np.errstate(over="ignore"):
            norms = np.sqrt(np.sum(parts * parts, axis=-1))
        wrong = ~(np.abs(norms - 1.0) <= UNIT_TOLERANCE)
        if wrong.any():
            place = tuple(int(i) for i in np.argwhere(wrong)[0])
            index, which, norm = list(place[:-1]), place[-1], float(norms[place])
            where = f" at index {index}" if index else ""
            raise BadArgument(
                f"{self._names[which]} must be a unit quaternion (x, y, z, w), got one of norm {norm:.8g}{where}"
            )
        unit = np.array(typed)
        # What is left of the norm would end up in the rotation matrices, squared.
        unit[..., self._columns] = parts / norms[..., None]
        return unit
