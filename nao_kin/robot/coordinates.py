"""Joint values by name and as an array, with joints that follow others taken at their word or refused."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._arrays import Floats, as_floats
from nao_kin.errors import BadArgument, CouplingViolated, UnknownName
from nao_kin.urdf_reader import Mimic

# Two values for the two ends of one motor agree when they differ by less than single precision can tell.
COUPLING_TOLERANCE = 1e-6
# A quaternion within this of norm 1 is meant to be one; what is left of the norm is divided out.
UNIT_TOLERANCE = 1e-6


class Coordinates:
    """The coordinates of a robot: one column per joint of its own, and the joints that follow one of them."""

    def __init__(self, names: tuple[str, ...], mimics: Mapping[str, Mimic]) -> None:
        self.names, self.mimics = names, dict(mimics)
        self.column = {name: index for index, name in enumerate(names)}

    def values(self, angles: Mapping[str, ArrayLike]) -> tuple[Floats, set[str]]:
        """Joint values (..., n) from values by name, zero where not named, and the columns that were set.

        Raises:
            UnknownName, BadArgument, WrongShape, NotFinite, CouplingViolated: as `RobotModel.configuration`.
        """
        given = self._arrays(angles)
        try:
            shape = np.broadcast_shapes(*(value.shape for value in given.values()))
        except ValueError:
            found = ", ".join(f"{name} {value.shape}" for name, value in given.items())
            raise BadArgument(f"joint values must share one batch shape, got {found}") from None
        joints = np.zeros((*shape, len(self.names)))
        named = {name for name in given if name in self.column}
        for name in named:
            joints[..., self.column[name]] = given[name]
        for name, value in given.items():
            tie = self.mimics.get(name)
            if tie is None:
                continue
            driver = joints[..., self.column[tie.joint]]
            if tie.joint not in named and tie.multiplier != 0.0:
                driver[...] = (value - tie.offset) / tie.multiplier
                named.add(tie.joint)
            else:
                _check_coupling(tie, name, driver, value)
        return joints, named

    def by_name(self, joints: Floats) -> dict[str, Floats | float]:
        """Name → value, or → array of values of the batch shape."""
        if joints.ndim == 1:
            return {name: float(joints[index]) for name, index in self.column.items()}
        return {name: joints[..., index].copy() for name, index in self.column.items()}

    def with_mimics(self, joints: Floats, names: tuple[str, ...]) -> Floats:
        """Values (..., len(names)) of any joints, those that follow another one included."""
        values = np.empty((*joints.shape[:-1], len(names)))
        for index, name in enumerate(names):
            tie = self.mimics.get(name)
            if tie is None:
                values[..., index] = joints[..., self.column[name]]
            else:
                values[..., index] = tie.multiplier * joints[..., self.column[tie.joint]] + tie.offset
        return values

    def _arrays(self, angles: Mapping[str, ArrayLike]) -> dict[str, Floats]:
        if not isinstance(angles, Mapping):
            raise BadArgument(f"joint values must be a mapping name → value, got {type(angles).__name__}")
        given = {}
        for name, value in angles.items():
            if name not in self.column and name not in self.mimics:
                raise UnknownName("joint", name, (*self.names, *self.mimics))
            given[name] = as_floats(value, (), name)
        return given


def _check_coupling(tie: Mimic, name: str, driver: Floats, value: Floats) -> None:
    driver, value = np.broadcast_arrays(driver, value)
    expected = tie.multiplier * driver + tie.offset
    difference = np.abs(expected - value)
    if np.any(difference > COUPLING_TOLERANCE):
        worst = int(np.argmax(difference))
        raise CouplingViolated(
            tie.joint, name, float(driver.flat[worst]), float(value.flat[worst]), float(expected.flat[worst])
        )
