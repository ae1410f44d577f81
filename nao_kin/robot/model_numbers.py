"""The placements and masses of a Pinocchio model, watched for changes.

Whoever calibrates a robot writes into `robot.model`. Pinocchio sees that at once; what was made of those numbers has to
be made again. Reading them one by one takes longer than a small batch, so they are compared in the memory where
Pinocchio keeps them, one after another at equal distances.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from nao_kin._common.arrays import Floats

_DOUBLE = 8
# An inertia is its mass, lever and tensor: the mass of the next one follows the tensor.
_LEVER_AND_TENSOR = 9


def address(array: Floats) -> int:
    """Where an array begins."""
    return int(array.__array_interface__["data"][0])


class ModelNumbers:
    """A copy of the numbers, and where they are.

    Examples:
        >>> nao = nk.NaoModel("v6")
        >>> nk.robot.ModelNumbers(nao.model).changed()
        False
    """

    def __init__(self, model: pin.Model) -> None:
        self._inertias = model.inertias
        placements = _Part(model.jointPlacements, lambda placement: placement.rotation, 12)  # R by columns, then p
        frames = _Part(model.frames, lambda frame: frame.placement.rotation, 12)
        bodies = _Part(model.inertias, lambda inertia: inertia.lever, _LEVER_AND_TENSOR + 1, but=1)
        last = _Part(model.inertias, lambda inertia: inertia.lever, _LEVER_AND_TENSOR)
        self._parts = placements, frames, bodies, last
        self._first = self._inertias[0]
        self._first_mass = float(self._first.mass)
        masses = [float(inertia.mass) for inertia in model.inertias]
        self._masses = None if bodies.column(_LEVER_AND_TENSOR) == masses[1:] else masses

    def changed(self) -> bool:
        """Whether any number is another one than when it was first looked at.

        Examples:
            >>> nao = nk.NaoModel("v6")
            >>> numbers = nk.robot.ModelNumbers(nao.model)
            >>> nao.model.jointPlacements[1].translation *= 1.01
            >>> numbers.changed()
            True
        """
        placements, frames, bodies, last = self._parts
        if placements.changed() or frames.changed() or bodies.changed() or last.changed():
            return True
        if self._masses is not None:  # this Pinocchio keeps masses elsewhere
            return [float(inertia.mass) for inertia in self._inertias] != self._masses
        return bool(self._first.mass != self._first_mass)

    def placements_changed(self) -> bool:
        """Whether a joint or a frame stands elsewhere than when it was first looked at.

        Examples:
            >>> nao = nk.NaoModel("v6")
            >>> numbers = nk.robot.ModelNumbers(nao.model)
            >>> nao.model.inertias[1].mass *= 1.1
            >>> numbers.changed(), numbers.placements_changed()
            (True, False)
        """
        placements, frames, _, _ = self._parts
        return placements.changed() or frames.changed()


class _Part:
    """One vector of Pinocchio's: so many doubles of each of its elements `but` the last, from an array in it on."""

    def __init__(self, elements: Sequence[Any], array_in: Callable[[Any], Floats], doubles: int, but: int = 0) -> None:
        self._elements, self._count = elements, len(elements)
        first = array_in(elements[0])
        step = address(array_in(elements[1])) - address(first) if self._count > 1 else _DOUBLE * doubles
        shape = self._count - but, doubles
        self._view = np.lib.stride_tricks.as_strided(first, shape, (step, _DOUBLE), writeable=False)
        self._seen = self._view.copy()

    def changed(self) -> bool:
        """Whether the vector has grown, which moves it and ends the view of it, or a number in it is another one."""
        return len(self._elements) != self._count or not (self._view == self._seen).all()

    def column(self, k: int) -> list[float]:
        """One of the doubles of all elements."""
        column: list[float] = self._seen[:, k].tolist()
        return column
