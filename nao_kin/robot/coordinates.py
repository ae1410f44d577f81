"""Joint values by name of joint or chain and as an array; joints that follow others must agree with them."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats, as_floats
from nao_kin.errors import BadArgument, CouplingViolated, UnknownName
from nao_kin.semantics import Mimic

_PLAIN = frozenset((float, int, np.float64))
# Two values for the two ends of one motor agree when they differ by less than single precision can tell.
COUPLING_TOLERANCE = 1e-6
# A quaternion within this of norm 1 is meant to be one; what is left of the norm is divided out.
UNIT_TOLERANCE = 1e-6


class Coordinates:
    """The coordinates of a robot: one column per joint of its own, and the joints that follow one of them.

    Args:
        names: the robot's own joints.
        mimics: the joints that follow, by name.
        chains: names that stand for several joints.
    """

    def __init__(
        self, names: tuple[str, ...], mimics: Mapping[str, Mimic], chains: Mapping[str, tuple[str, ...]] | None = None
    ) -> None:
        self.names, self.mimics, self.chains = names, dict(mimics), dict(chains or {})
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
            mimic = self.mimics.get(name)
            if mimic is None:
                continue
            driver = joints[..., self.column[mimic.joint]]
            if mimic.joint not in named and mimic.multiplier != 0.0:
                driver[...] = mimic.driver_value(value)
                named.add(mimic.joint)
            else:
                _check_coupling(mimic, name, driver, value)
        return joints, named

    def plain_values(self, angles: Mapping[str, ArrayLike]) -> dict[str, float] | None:
        """Own joint → value, where `angles` is a dictionary of plain finite numbers without contradiction; else None.

        None says no more than that the arrays must look at it.
        """
        if type(angles) is not dict or not _PLAIN.issuperset(map(type, angles.values())):
            return None
        try:
            if not all(map(math.isfinite, angles.values())):
                return None
        except OverflowError:
            return None
        if angles.keys() <= self.column.keys():
            return angles
        values = {name: value for name, value in angles.items() if name in self.column}
        for name, value in angles.items():
            if name in values:
                continue
            mimic = self.mimics.get(name)
            if mimic is None or mimic.multiplier == 0.0:
                return None
            asked = (value - mimic.offset) / mimic.multiplier
            if abs(values.setdefault(mimic.joint, asked) - asked) * abs(mimic.multiplier) > COUPLING_TOLERANCE:
                return None
        return values

    def in_radians(self, angles: Mapping[str, ArrayLike], units: Mapping[str, str]) -> dict[str, Floats]:
        """Joint → values, from values that are in degrees for joints of the unit "rad"; a chain becomes its joints."""
        given = self._arrays(angles)
        return {name: np.radians(value) if units[name] == "rad" else value for name, value in given.items()}

    def by_name(self, joints: Floats) -> dict[str, Floats | float]:
        """Name → value, or → array of values of the batch shape."""
        if joints.ndim == 1:
            return {name: float(joints[index]) for name, index in self.column.items()}
        return {name: joints[..., index].copy() for name, index in self.column.items()}

    def with_mimics(self, joints: Floats, names: tuple[str, ...]) -> Floats:
        """Values (..., len(names)) of any joints, those that follow another one included."""
        values = np.empty((*joints.shape[:-1], len(names)))
        for index, name in enumerate(names):
            mimic = self.mimics.get(name)
            if mimic is None:
                values[..., index] = joints[..., self.column[name]]
            else:
                values[..., index] = mimic.value(joints[..., self.column[mimic.joint]])
        return values

    def _arrays(self, angles: Mapping[str, ArrayLike]) -> dict[str, Floats]:
        given: dict[str, Floats] = {}
        for name, value in checked_mapping(angles).items():
            if name in self.column or name in self.mimics:
                added = {name: as_floats(value, (), name)}
            elif name in self.chains:
                joints = self.chains[name]
                array = as_floats(value, (len(joints),), f"{name} ({', '.join(joints)})")
                added = {joint: array[..., index] for index, joint in enumerate(joints)}
            else:
                raise UnknownName("joint", name, (*self.names, *self.mimics, *self.chains))
            for joint in added.keys() & given.keys():
                raise BadArgument(f"{joint} is given twice, by itself and with a chain, or with two chains")
            given |= added
        return given


def checked_mapping(angles: object) -> Mapping[str, ArrayLike]:
    """`angles`, when it is a mapping.

    Raises:
        BadArgument: it is none.
    """
    if not isinstance(angles, Mapping):
        raise BadArgument(f"joint values must be a mapping name → value, got {type(angles).__name__}")
    return angles


def _check_coupling(mimic: Mimic, name: str, driver: Floats, value: Floats) -> None:
    driver, value = np.broadcast_arrays(driver, value)
    expected = mimic.value(driver)
    difference = np.abs(expected - value)
    if np.any(difference > COUPLING_TOLERANCE):
        index = np.unravel_index(int(np.argmax(difference > COUPLING_TOLERANCE)), difference.shape)
        raise CouplingViolated(
            mimic.joint,
            name,
            float(driver[index]),
            float(value[index]),
            float(expected[index]),
            tuple(int(i) for i in index),
        )
