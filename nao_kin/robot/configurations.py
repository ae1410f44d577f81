"""The configurations of a robot: made from values by name, from postures and at random, and put inside its limits."""

from __future__ import annotations

import math
import operator
from collections.abc import Collection, Iterable, Mapping

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, choice
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument, OutsideLimits
from nao_kin.robot.checks import ConfigurationChecks, Coordinates, checked_mapping
from nao_kin.robot.limits import JointLimits, LimitPolicy, check_policy
from nao_kin.robot.semantics import Posture

# More would not fit in any memory.
_MOST_DRAWN = 10**10
# An error about a batch carries the violations of this many configurations, and counts the rest.
_MOST_LISTED = 100


class Configurations:
    """How one robot makes configurations q of shape (..., nq); `RobotModel` has these methods and says what they do.

    Args:
        coordinates: its joints by name; their values are the last numbers of q.
        checks: what its configurations must be.
        limits: the limits of its joints.
        neutral: the configuration of zeros, shape (nq,).
        units: joint → unit.
        postures: its postures by name.
    """

    def __init__(
        self,
        coordinates: Coordinates,
        checks: ConfigurationChecks,
        limits: JointLimits,
        neutral: Floats,
        units: Mapping[str, str],
        postures: Mapping[str, Posture],
    ) -> None:
        self._coordinates, self._checks, self._limits = coordinates, checks, limits
        self._neutral, self._units = np.array(neutral), units
        # Where the joints begin in q, and the place of each of them.
        self._offset = len(neutral) - len(coordinates.names)
        self._places = {name: self._offset + column for name, column in coordinates.column.items()}
        self._postures = {
            name: self.configuration(dict(posture.angles), "ignore", False) for name, posture in postures.items()
        }

    def neutral(self, shape: tuple[int, ...] = ()) -> Floats:
        """All joints at zero, for a batch shape."""
        return np.tile(self._neutral, (*shape, 1)) if shape else np.array(self._neutral)

    def posture(
        self,
        name: str,
        angles: Mapping[str, ArrayLike] | None,
        joints: Mapping[str, ArrayLike],
        limits: LimitPolicy,
    ) -> Floats:
        """A posture, with other values for the joints that `angles` and `joints` name."""
        choice(name, self._postures, "posture")
        if angles is None and not joints:
            return np.array(self._postures[name])
        values, given = self._coordinates.values(joints if angles is None else {**checked_mapping(angles), **joints})
        q = np.empty((*values.shape[:-1], len(self._neutral)))
        q[...] = self._postures[name]
        columns = [self._coordinates.column[joint] for joint in given]
        q[..., self._offset :][..., columns] = values[..., columns]
        return self.within(q, limits)

    def random(self, rng: np.random.Generator | int | None, n: int | tuple[int, ...] | None) -> Floats:
        """Configurations inside all limits, each joint uniform in its range."""
        try:
            generator = np.random.default_rng(rng)
            shape = () if n is None else tuple(map(operator.index, n if isinstance(n, Iterable) else (n,)))
        except (TypeError, ValueError) as error:
            raise BadArgument(f"random needs a generator or a seed, and a number or a shape: {error}") from None
        if any(length < 0 for length in shape):
            raise BadArgument(f"n must not be negative, got {n}")
        if math.prod(shape) > _MOST_DRAWN:
            raise BadArgument(f"n must not exceed {_MOST_DRAWN} configurations, got {quoted(n)}")
        q = self.neutral(shape)
        q[..., self._offset :] = self._limits.random(generator, shape)
        return q

    def configuration(self, angles: Mapping[str, ArrayLike], limits: LimitPolicy, degrees: bool) -> Floats:
        """The configuration with the given joint values."""
        if degrees:
            angles = self._coordinates.in_radians(angles, self._units)
        values = self._coordinates.plain_values(angles)
        check_policy(limits)
        if values is not None and (limits == "ignore" or (limits == "raise" and self._limits.surely_inside(values))):
            plain = self._neutral.tolist()
            places = self._places
            for name, value in values.items():
                plain[places[name]] = value
            return np.array(plain, dtype=np.float64)
        joints, given = self._coordinates.values(angles)
        q = self.neutral(joints.shape[:-1])
        q[..., self._offset :] = joints
        return self.within(q, limits, given)

    def joints(self, q: ArrayLike) -> Floats:
        """The joint values of configurations, shape (..., n)."""
        return self._checks.checked(q)[..., self._offset :]

    def angles(self, q: ArrayLike, degrees: bool) -> dict[str, Floats | float]:
        """Joint values by name."""
        joints = self.joints(q)
        if degrees:
            turning = [self._units[name] == "rad" for name in self._coordinates.names]
            joints = np.where(turning, np.degrees(joints), joints)
        return self._coordinates.by_name(joints)

    def within(self, q: Floats, limits: str, joints: Collection[str] | None = None) -> Floats:
        """Configurations as the limits policy wants them.

        Args:
            q: checked configurations.
            limits: "raise", "clamp" or "ignore".
            joints: look at these joints only; None for all.

        Raises:
            UnknownName: no such policy.
            OutsideLimits: with "raise", a joint is outside its limits.
        """
        if limits == "ignore":
            return q
        check_policy(limits)
        values, names = q[..., self._offset :], self._coordinates.names
        if limits == "raise":
            one = joints is None and values.ndim == 1
            if one and self._limits.surely_inside(dict(zip(names, values.tolist(), strict=True))):
                return q
            count = self._limits.count(values, joints)
            if count:
                raise OutsideLimits(self._limits.violations(values, joints, most=_MOST_LISTED), count)
            return q
        inside = np.array(q, order="C")
        clamped = self._limits.clamp(values)
        columns = slice(None) if joints is None else [self._coordinates.column[name] for name in joints]
        inside[..., self._offset :][..., columns] = clamped[..., columns]
        return inside
