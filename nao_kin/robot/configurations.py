"""The configurations of a robot: making them from values by name, and checks with errors that name the joint."""

from __future__ import annotations

import math
import operator
from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import (
    COUPLING_TOLERANCE,
    LIMIT_TOLERANCE,
    UNIT_TOLERANCE,
    Floats,
    LimitPolicy,
    as_floats,
    as_numbers,
    choice,
    common_batch,
    first_index,
    generator,
    limit_policy,
    shaped,
)
from nao_kin._core.sides import Hips, joints_of_side
from nao_kin._core.text import quoted
from nao_kin._core.warn import TURN, warn_caller
from nao_kin.errors import BadArgument, CouplingViolated, DegreesWarning, NotFinite, OutsideLimits, UnknownName
from nao_kin.robot.limits import JointLimits, OutsideRows
from nao_kin.robot.semantics import Mimic, Posture

# --- Conversion between joint values by name and arrays; mimic joints must agree with their driving joints.

_PLAIN = frozenset((float, int, np.float64))
# The norm of a quaternion that was divided by its norm differs from 1 by at most this.
_UNIT_ROUNDING = 2.0 * float(np.finfo(np.float64).eps)


class DataFrame(Protocol):
    """A data frame of pandas or polars, with one column for each name."""

    @property
    def columns(self) -> Any:
        """The names."""

    def __getitem__(self, name: Any, /) -> Any:
        """Return a column."""


class Series(Protocol):
    """A row of a data frame of pandas, with a value for each name."""

    def keys(self) -> Any:
        """Return the names."""

    def __getitem__(self, name: Any, /) -> Any:
        """Return a value."""


JointValues = Mapping[str, ArrayLike] | DataFrame | Series


class Coordinates:
    """The coordinates of a robot: a column per independent joint, mimic joints by name, and names for several."""

    def __init__(
        self,
        names: tuple[str, ...],
        mimics: Mapping[str, Mimic],
        chains: Mapping[str, tuple[str, ...]] = MappingProxyType({}),
        fixed: Collection[str] = (),
    ) -> None:
        self.names, self.mimics, self.chains, self._fixed = names, dict(mimics), dict(chains), fixed
        self.column = {name: index for index, name in enumerate(names)}

    def unknown(self, name: object, others: Iterable[str] = ()) -> UnknownName:
        """Return the error for a name that is neither a moving joint nor one of the `others`."""
        hint = f"{quoted(name)} is fixed in the robot's file" if name in self._fixed else ""
        return UnknownName("joint", name, (*self.names, *self.mimics, *others), hint)

    def values(self, angles: JointValues) -> tuple[Floats, set[str]]:
        """Return joint values (..., n) from values by name, zero by default, and the names of the joints set."""
        given = self.arrays(angles)
        shape = common_batch("values of joints", (), *(value.shape for value in given.values()))
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

    def plain_values(self, angles: JointValues) -> dict[str, float] | None:
        """Return joint → value for plain finite numbers without contradiction; None leaves all others to `values`."""
        if type(angles) is not dict or not _PLAIN.issuperset(map(type, angles.values())):
            return None
        if not all(map(math.isfinite, angles.values())):
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

    def arrays(self, angles: JointValues, *, ignore_other: bool = False, gaps: bool = False) -> dict[str, Floats]:
        """Return joint → values as an array; the name of a chain is replaced by its joints.

        With `ignore_other` other names are left out, with `gaps` values may be NaN.
        """
        given: dict[str, Floats] = {}
        for name, value in by_name(angles).items():
            if name in self.column or name in self.mimics:
                added = {name: as_floats(value, (), name, gaps=gaps)}
            elif name in self.chains:
                joints = self.chains[name]
                array = as_floats(value, (len(joints),), f"{name} ({', '.join(joints)})", gaps=gaps)
                added = {joint: array[..., index] for index, joint in enumerate(joints)}
            elif ignore_other:
                continue
            else:
                raise self.unknown(name, self.chains)
            for joint in added.keys() & given.keys():
                raise BadArgument(f"{joint} is given twice, by itself and with a chain, or with two chains")
            given |= added
        return given


def by_name(angles: JointValues) -> Mapping[str, ArrayLike]:
    """Return `angles`, or the values by name of a data frame of pandas or polars, or of a series of pandas."""
    if isinstance(angles, Mapping):
        return angles
    names = angles.columns if hasattr(angles, "columns") else getattr(angles, "keys", lambda: None)()
    if names is None:
        raise BadArgument(f"values by joint are expected, got {quoted(angles, 60)}; robot.posture names a posture")
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise BadArgument(
            f"column {quoted(twice[0])} of the {'data frame' if hasattr(angles, 'columns') else 'series'} occurs twice"
        )
    return {name: angles[name] for name in names}


def _check_coupling(mimic: Mimic, name: str, driver: Floats, value: Floats) -> None:
    driver, value = np.broadcast_arrays(driver, value)
    expected = mimic.value(driver)
    difference = np.abs(expected - value)
    if np.any(difference > COUPLING_TOLERANCE):
        index = first_index(difference > COUPLING_TOLERANCE)
        leading, given, asked = (float(array[index]) for array in (driver, value, expected))
        raise CouplingViolated(mimic.joint, name, leading, given, asked, index)


# --- Configurations from callers: making, checking and clamping them.

_FLOAT64 = np.dtype(np.float64)
# Number of quaternions that are checked at a time: few enough to need little memory.
_BLOCK = 1 << 15
# An error about a batch lists the violations of this many configurations, and counts the others.
_MAX_LISTED = 100


class ConfigurationSpace:
    """How one robot makes and checks configurations q of shape (..., nq); `RobotModel` describes most methods."""

    def __init__(
        self,
        coordinates: Coordinates,
        limits: JointLimits,
        neutral: Floats,
        units: Mapping[str, str],
        postures: Mapping[str, Posture],
    ) -> None:
        self._coordinates, self._limits = coordinates, limits
        self._neutral, self._units = np.array(neutral), units
        # Index of the first joint in q, after a floating base, and index of each joint.
        self._offset = len(neutral) - len(coordinates.names)
        self._floating, self._shape = self._offset > 0, (len(neutral),)
        self._places = {name: self._offset + column for name, column in coordinates.column.items()}
        self._turning = np.array([units[name] == "rad" for name in coordinates.names], dtype=np.bool_)
        self._bounded = self._turning & np.isfinite(limits.lower) & np.isfinite(limits.upper)
        self._postures = {
            name: self.configuration(dict(posture.angles), "ignore", False) for name, posture in postures.items()
        }

    def neutral(self, shape: tuple[int, ...] = ()) -> Floats:
        """Return configurations with all joints at zero, for a batch shape."""
        return np.tile(self._neutral, (*shape, 1)) if shape else np.array(self._neutral)

    def posture(
        self, name: str, angles: JointValues | None, joints: Mapping[str, ArrayLike], limits: LimitPolicy
    ) -> Floats:
        """Return a posture, with other values for the joints that `angles` and `joints` name."""
        choice(name, self._postures, "posture")
        if angles is None and not joints:
            return np.array(self._postures[name])
        values, given = self._coordinates.values(joints if angles is None else {**by_name(angles), **joints})
        q = np.empty((*values.shape[:-1], len(self._neutral)))
        q[...] = self._postures[name]
        columns = [self._coordinates.column[joint] for joint in given]
        q[..., self._offset :][..., columns] = values[..., columns]
        return self.within(q, limits, given)

    def random(self, rng: np.random.Generator | int | None, n: int | tuple[int, ...] | None) -> Floats:
        """Return configurations inside all limits, each joint uniform in its range."""
        shape = () if n is None else tuple(map(operator.index, n if isinstance(n, Iterable) else (n,)))
        q = self.neutral(shape)
        q[..., self._offset :] = self._limits.random(generator(rng), shape)
        return q

    def by_joint(
        self, angles: JointValues, degrees: bool, *, ignore_other: bool = False, gaps: bool = False
    ) -> dict[str, Floats]:
        """Return joint → values [rad, m or ratio] from values by joint or chain, as in `Coordinates.arrays`."""
        given = self._coordinates.arrays(angles, ignore_other=ignore_other, gaps=gaps)
        return {name: np.radians(v) if degrees and self._units[name] == "rad" else v for name, v in given.items()}

    def configuration(self, angles: JointValues, limits: LimitPolicy, degrees: bool) -> Floats:
        """Return the configuration with the given joint values."""
        if degrees:
            angles = self.by_joint(angles, degrees)
        values = self._coordinates.plain_values(angles)
        limits = limit_policy(limits)
        if values is not None and (limits == "ignore" or (limits == "enforce" and self._limits.surely_inside(values))):
            plain = self._neutral.tolist()
            places = self._places
            for name, value in values.items():
                plain[places[name]] = value
            return np.array(plain, dtype=np.float64)
        joints, named = self._coordinates.values(angles)
        q = self.neutral(joints.shape[:-1])
        q[..., self._offset :] = joints
        return self.within(q, limits, named)

    def joints(self, q: ArrayLike) -> Floats:
        """Return the joint values of configurations, shape (..., n)."""
        return self.checked(q)[..., self._offset :]

    def angles(self, q: ArrayLike, degrees: bool) -> dict[str, Floats | float]:
        """Return joint values by name."""
        joints = self.joints(q)
        if degrees:
            joints = np.where(self._turning, np.degrees(joints), joints)
        column = self._coordinates.column
        if joints.ndim == 1:
            return {name: float(joints[index]) for name, index in column.items()}
        return {name: joints[..., index].copy() for name, index in column.items()}

    def within(self, q: Floats, limits: str, joints: Collection[str] | None = None) -> Floats:
        """Return checked configurations after applying the limits policy to the named joints, or to all for None."""
        if limits == "ignore":
            return q
        limits = limit_policy(limits)
        values, names = q[..., self._offset :], self._coordinates.names
        if limits != "clamp":
            one = joints is None and values.ndim == 1
            if one and self._limits.surely_inside(dict(zip(names, values.tolist(), strict=True))):
                return q
            count = self._limits.count(values, joints, limits)
            if count:
                listed = self._limits.violations(values, joints, limits, max_configurations=_MAX_LISTED)
                raise OutsideLimits(listed, count)
            if limits == "enforce":
                return q
        inside = np.array(q, order="C")
        clamped = self._limits.clamp(values)
        columns: Any = slice(None)
        if joints is not None:  # and those whose range depends on one of them
            named = {*joints, *(table.joint for table in self._limits.tables if table.of in joints)}
            columns = [self._coordinates.column[name] for name in named]
        inside[..., self._offset :][..., columns] = clamped[..., columns]
        if limits == "measured":
            OutsideRows.of(values, inside[..., self._offset :], names).warn(self._units.__getitem__)
            return q
        return inside

    def joints_for(self, missing: str | float) -> dict[str, Floats]:
        """Return joint → value for joints that are not measured, from a posture or a number, within the limits."""
        if isinstance(missing, str):
            values = self._postures[choice(missing, self._postures, "posture")][self._offset :]
        else:
            values = np.full(len(self._coordinates.names), float(shaped(missing, (), "missing")))
        return dict(zip(self._coordinates.names, self._limits.clamp(values), strict=True))

    def posed(self, q: ArrayLike) -> Floats:
        """Return `q` as configurations for poses, with a warning if they seem to be in degrees."""
        one = type(q) is np.ndarray and q.shape == self._shape and q.dtype is _FLOAT64
        if one and not self._floating and math.hypot(*q.tolist()) <= TURN:  # type: ignore[union-attr]
            # A shortcut for the common case: values within a turn of zero are finite and not in degrees.
            return q  # type: ignore[return-value]
        array = self.checked(q)
        self.warn_of_degrees(array)
        return array

    def checked(self, q: ArrayLike) -> Floats:
        """Return `q` as configurations: finite, of the right shape, with unit quaternions for a floating base."""
        try:
            array = as_floats(q, self._shape, "q")
        except NotFinite as error:
            raise self._named(error) from None
        if self._floating:
            self.check_base(array)
            array = array.copy()
            norms = np.linalg.norm(array[..., 3:7], axis=-1)[..., None]
            # An error of the norm would scale the rotation matrices; errors due to rounding are left as they are.
            array[..., 3:7] /= np.where(np.abs(norms - 1.0) <= _UNIT_ROUNDING, 1.0, norms)
        return array

    def check_base(self, q: NDArray[Any]) -> None:
        """Refuse quaternions of a floating base that are not of unit length; NaN and infinity pass."""
        if not self._floating:
            return
        quaternions = q[..., 3:7].reshape(-1, 4)
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
            index = first_index(~finite)
            raise self._named(NotFinite("q", index, float(q[index])))

    def warn_of_degrees(self, q: NDArray[Any]) -> None:
        """Warn if a turning joint with limits is outside its limits and more than a turn from zero."""
        joints = q[..., self._offset :]
        if not joints.size or max(float(joints.max()), -float(joints.min())) <= TURN:
            return
        lower, upper = self._limits.lower - LIMIT_TOLERANCE, self._limits.upper + LIMIT_TOLERANCE
        wrong = (np.abs(joints) > TURN) & ((joints < lower) | (joints > upper)) & self._bounded
        if wrong.any():
            place = first_index(wrong)
            joint, value = self._coordinates.names[place[-1]], float(joints[place])
            warn_caller(
                f"{joint} = {value:.6g} rad is more than a full turn; q is in radians, np.deg2rad(q) converts degrees",
                DegreesWarning,
                subject="degrees",
            )

    def _named(self, error: NotFinite) -> NotFinite:
        column = error.index[-1] - self._offset
        return NotFinite("q", error.index, error.value, self._coordinates.names[column] if column >= 0 else "base")


# --- Joints and the motors that move them; one motor may move several joints, such as the two HipYawPitch of a NAO.


def joints_by_motor(mimics: Mapping[str, Mimic], names: Iterable[str]) -> dict[str, list[str]]:
    """Return driving joint → the joints among `names` that its motor moves, the driving joint first."""
    motors: dict[str, list[str]] = {}
    for name in sorted(names, key=mimics.__contains__):
        mimic = mimics.get(name)
        if mimic is None or mimic.multiplier != 0.0:
            motors.setdefault(name if mimic is None else mimic.joint, []).append(name)
    return motors


def motor_values(mimics: Mapping[str, Mimic], values: Mapping[str, Floats], hips: Hips) -> dict[str, Floats]:
    """Return driving joint → values, from values of any joints; a mimic joint gives (value − offset) / multiplier.

    Several joints of one motor give the mean of their values, or of those on the side `hips` if there are any.
    """
    found = {}
    for motor, joints in joints_by_motor(mimics, values).items():
        columns = [
            mimics[name].driver_value(values[name]) if name in mimics else values[name]
            for name in joints_of_side(joints, hips)
        ]
        found[motor] = columns[0] if len(columns) == 1 else np.mean(np.broadcast_arrays(*columns), axis=0)
    return found


def values_by_name(values: Mapping[str, ArrayLike], coordinates: Coordinates) -> dict[str, Floats]:
    """Return joint → values as arrays whose shapes broadcast; NaN is accepted."""
    values = by_name(values)
    for name in values:
        if name not in coordinates.column and name not in coordinates.mimics:
            raise coordinates.unknown(name)
    found = {name: as_numbers(value, f"values of {name}") for name, value in values.items()}
    common_batch("values of joints", (), *(value.shape for value in found.values()))
    return found


def without_gaps(
    mimics: Mapping[str, Mimic], values: Mapping[str, Floats], rest: Mapping[str, Floats]
) -> dict[str, Floats]:
    """Return joint → finite values, with one for every motor, from values of some joints, in which NaN is a gap.

    A gap is filled with the value of another joint of the same motor, or else with that of the driving joint in `rest`,
    which also has the values of the joints that are absent.
    """
    found = dict(rest)
    couplings = {name: mimics.get(name) or Mimic(name) for name in values}
    measured: dict[str, Floats] = {}
    for name, coupling in couplings.items():
        if coupling.multiplier != 0.0:
            value = coupling.driver_value(values[name])
            known = measured.get(coupling.joint, value)
            measured[coupling.joint] = np.where(np.isnan(known), value, known)
    for motor, value in measured.items():
        found[motor] = np.where(np.isnan(value), found[motor], value)
    filled = {
        name: np.where(np.isnan(value), couplings[name].value(found[couplings[name].joint]), value)
        for name, value in values.items()
    }
    absent = {name: value for name, value in found.items() if name not in measured}
    return absent | filled
