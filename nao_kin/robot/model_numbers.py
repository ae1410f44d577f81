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


def address(array: Floats) -> int:
    """Where an array begins."""
    return int(array.__array_interface__["data"][0])


class ModelNumbers:
    """A copy of the numbers, and where they are."""

    def __init__(self, model: pin.Model) -> None:
        self._model = model
        # R by columns, then p. The mass stands before the lever: the masses of all but the first follow the tensors.
        self._parts = [
            _Part(model.jointPlacements, lambda placement: placement.rotation, 12),
            _Part(model.frames, lambda frame: frame.placement.rotation, 12),
            _Part(model.inertias, lambda inertia: inertia.lever, 3),
        ]
        self._held = model.inertias[0]
        self._masses = self._masses_now()

    def changed(self) -> bool:
        """Whether any number is another one than when it was first looked at."""
        placements, frames, levers = self._parts
        return placements.changed() or frames.changed() or levers.changed() or self._masses_now() != self._masses

    def placements_changed(self) -> bool:
        """Whether a joint or a frame stands elsewhere than when it was first looked at."""
        placements, frames, _ = self._parts
        return placements.changed() or frames.changed()

    def _masses_now(self) -> tuple[float, float]:
        """Mass of what moves, and of what no joint moves."""
        return float(pin.computeTotalMass(self._model)), float(self._held.mass)


class _Part:
    """One vector of Pinocchio's: so many doubles of each of its elements, from an array in it on."""

    def __init__(self, elements: Sequence[Any], array_in: Callable[[Any], Floats], doubles: int) -> None:
        self._elements, self._count = elements, len(elements)
        first = array_in(elements[0])
        step = address(array_in(elements[1])) - address(first) if self._count > 1 else _DOUBLE * doubles
        self._view = np.lib.stride_tricks.as_strided(first, (self._count, doubles), (step, _DOUBLE), writeable=False)
        self._seen = self._view.copy()

    def changed(self) -> bool:
        """Whether the vector has grown, which moves it and ends the view of it, or a number in it is another one."""
        return len(self._elements) != self._count or not (self._view == self._seen).all()
