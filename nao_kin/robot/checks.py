"""Configurations as callers give them: checked once, and refused with the names of their joints."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, as_floats
from nao_kin._core.warn import warn_caller
from nao_kin.errors import BadArgument, CouplingViolated, DegreesWarning, NotFinite, UnknownName
from nao_kin.robot.build import Base
from nao_kin.robot.semantics import Mimic

# --- Joint values by name of joint or chain and as an array; joints that follow others must agree with them.

_PLAIN = frozenset((float, int, np.float64))
# Two values for the two ends of one motor agree when they differ by less than single precision can tell.
COUPLING_TOLERANCE = 1e-6
# A quaternion within this of norm 1 is meant to be one; what is left of the norm is divided out.
UNIT_TOLERANCE = 1e-6
# A quaternion divided by its norm has a norm within this of 1.
_UNIT_ROUNDING = 2.0 * float(np.finfo(np.float64).eps)


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


# --- Configurations as callers give them: checked once, and refused with the names of their joints.

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
            norms = np.linalg.norm(array[..., 3:7], axis=-1)[..., None]
            # What is left of the norm would end up in the rotation matrices; what is rounding stays as it came.
            array[..., 3:7] /= np.where(np.abs(norms - 1.0) <= _UNIT_ROUNDING, 1.0, norms)
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
