"""The configurations of a robot by names of joints, chains and postures, and whether they are inside its limits."""

from __future__ import annotations

import math
import operator
from abc import ABC, abstractmethod
from collections.abc import Collection, Iterable, Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, whole_number
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument, OutsideLimits, UnknownName
from nao_kin.robot.checks import ConfigurationChecks, Coordinates, checked_mapping
from nao_kin.robot.limits import JointLimits, LimitPolicy, LimitViolation, check_policy

# More would not fit in any memory.
_MOST_DRAWN = 10**10
# An error about a batch carries the violations of this many configurations, and counts the rest.
_MOST_LISTED = 100


class ConfigurationMethods(ABC):
    """How every `RobotModel` makes, names, checks and clamps configurations q of shape (..., nq)."""

    joint_names: tuple[str, ...]
    _coordinates: Coordinates
    _limits: JointLimits
    _checks: ConfigurationChecks
    # The configuration of zeros, and those of the postures.
    _neutral: Floats
    _postures: Mapping[str, Floats]
    # Where the joints begin in q, and the place of each of them.
    _q_offset: int
    _places: Mapping[str, int]
    _units: Mapping[str, str]

    @property
    @abstractmethod
    def nq(self) -> int:
        """Number of coordinates in q."""

    @property
    def posture_names(self) -> tuple[str, ...]:
        """Names that `posture` takes."""
        return tuple(self._postures)

    # --- configurations -------------------------------------------------------------------------------------------

    def neutral(self) -> Floats:
        """All joints at zero, a floating base at the world's origin; shape (nq,).

        Zero is the configuration that the frames are defined in. It need not lie inside the limits: NAO's elbows
        stop 2° before it.

        Examples:
            >>> nk.load_nao().neutral().shape
            (25,)
        """
        return np.array(self._neutral)

    def posture(
        self,
        name: str,
        angles: Mapping[str, ArrayLike] | None = None,
        /,
        *,
        limits: LimitPolicy = "raise",
        **joints: ArrayLike,
    ) -> Floats:
        """A predefined posture, with other values for some joints.

        Joints that the posture leaves open are at zero. Without `angles` and `joints` it is given as it is; with them
        all of it is held against the limits, for a coupled limit may reach from a joint that is named to one that is
        not.

        Args:
            name: one of `posture_names`.
            angles: joint or chain → value, as `configuration` takes them.
            limits: what to do with joints outside their limits: "raise", "clamp" or "ignore".
            **joints: joint or chain → value, too, for names that Python can write so.

        Returns:
            q, shape (nq,), or (..., nq) for values of a batch shape.

        Raises:
            UnknownName: no such posture, joint or chain.
            OutsideLimits: a joint is outside its limits.
            WrongShape, NotFinite, CouplingViolated, BadArgument: as `configuration`.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.posture("Stand", HeadYaw=0.3)
            >>> nao.angles(q)["HeadYaw"]
            0.3
            >>> nao.posture("Stand", HeadYaw=[-0.3, 0.0, 0.3]).shape
            (3, 25)
        """
        if not isinstance(name, str) or name not in self._postures:
            raise UnknownName("posture", name, self.posture_names)
        if angles is None and not joints:
            return np.array(self._postures[name])
        values, given = self._coordinates.values(joints if angles is None else {**checked_mapping(angles), **joints})
        q = np.empty((*values.shape[:-1], self.nq))
        q[...] = self._postures[name]
        columns = [self._coordinates.column[joint] for joint in given]
        q[..., [self._q_offset + column for column in columns]] = values[..., columns]
        return self._within(q, limits)

    def random(self, rng: np.random.Generator | int | None = None, n: int | tuple[int, ...] | None = None) -> Floats:
        """Configurations inside all limits, coupled ones included, each joint uniform in its range.

        Joints without limits are uniform in [−π, π]; a floating base stays at the world's origin.

        Args:
            rng: a generator, or a seed for one.
            n: how many, or a batch shape; None for one configuration of shape (nq,).

        Returns:
            Configurations, shape (n…, nq).

        Raises:
            BadArgument: no generator and no seed, or no batch shape.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.random(rng=0, n=(2, 3))
            >>> q.shape, bool(nao.within_limits(q).all())
            ((2, 3, 25), True)
        """
        try:
            generator = np.random.default_rng(rng)
            shape = () if n is None else tuple(map(operator.index, n if isinstance(n, Iterable) else (n,)))
        except (TypeError, ValueError) as error:
            raise BadArgument(f"random needs a generator or a seed, and a number or a shape: {error}") from None
        if any(length < 0 for length in shape):
            raise BadArgument(f"n must not be negative, got {n}")
        if math.prod(shape) > _MOST_DRAWN:
            raise BadArgument(f"n must not exceed {_MOST_DRAWN} configurations, got {quoted(n)}")
        q = self._neutrals(shape)
        q[..., self._q_offset :] = self._limits.random(generator, shape)
        return q

    def configuration(
        self, angles: Mapping[str, ArrayLike], *, limits: LimitPolicy = "raise", degrees: bool = False
    ) -> Floats:
        """The configuration with the given joint values; joints not named are at zero.

        A joint that follows another one may be named too: alone it sets the driving joint, beside it the two must
        agree. A chain of the robot stands for its joints, from the trunk outwards.

        Args:
            angles: joint name → value, or an array of values of one batch shape [rad, m or ratio]; chain name →
                the values of its joints, shape (..., number of joints).
            limits: what to do with a named joint outside its limits: "raise", "clamp" or "ignore".
            degrees: the values of turning joints are in degrees.

        Returns:
            q, shape (..., nq), in radians whatever `degrees` says.

        Raises:
            UnknownName: no such joint or chain, or no such limits policy.
            CouplingViolated: two joints of one motor disagree.
            OutsideLimits: a named joint is outside its limits.
            WrongShape, NotFinite, BadArgument: values that are no numbers of one batch shape, or a joint named twice.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.configuration({"HeadYaw": 0.3, "RArm": [1.4, -0.2, 1.2, 0.4, 0.0, 0.5]})
            >>> nao.angles(q)["RShoulderPitch"]
            1.4
        """
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
        q = self._neutrals(joints.shape[:-1])
        q[..., self._q_offset :] = joints
        return self._within(q, limits, given)

    def angles(self, q: ArrayLike, *, degrees: bool = False) -> dict[str, Floats | float]:
        """Joint values by name, joints that follow another one not included: the inverse of `configuration`.

        Args:
            q: configurations, shape (..., nq).
            degrees: give the values of turning joints in degrees.

        Returns:
            name → float, or → array of the batch shape [rad, m or ratio].

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.angles(nao.configuration({"HeadYaw": 0.3}))["HeadYaw"]
            0.3
        """
        joints = self._checked(q)[..., self._q_offset :]
        if degrees:
            turning = [self._units[name] == "rad" for name in self._coordinates.names]
            joints = np.where(turning, np.degrees(joints), joints)
        return self._coordinates.by_name(joints)

    # --- limits ---------------------------------------------------------------------------------------------------

    def within_limits(self, q: ArrayLike, *, per_joint: bool = False) -> NDArray[np.bool_]:
        """Which configurations are inside all limits, the tables of coupled limits included.

        The answer for many configurations: `(~nao.within_limits(q, per_joint=True)).sum(axis=0)` counts, joint by
        joint, how many of a million are outside.

        Args:
            q: configurations, shape (..., nq).
            per_joint: one answer for each joint, in the order of `joint_names`.

        Returns:
            Shape (...), or with `per_joint` (..., n).

        Raises:
            WrongShape, NotFinite: q is no configuration.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.configuration({"HeadYaw": [0.0, 3.0], "LElbowRoll": -0.5, "RElbowRoll": 0.5}, limits="ignore")
            >>> nao.within_limits(q).tolist()
            [True, False]
        """
        inside = self._limits.inside(self._checked(q)[..., self._q_offset :])
        return inside if per_joint else np.asarray(inside.all(axis=-1))

    def limit_violations(self, q: ArrayLike, *, most: int | None = None) -> tuple[LimitViolation, ...]:
        """Every joint outside its limits, by configuration and then by how far; empty when all are inside.

        A row for each takes time and memory where there are many: `within_limits` answers with arrays.

        Args:
            q: configurations, shape (..., nq).
            most: stop after this many configurations with a violation; None for all.

        Raises:
            WrongShape, NotFinite: q is no configuration.
            BadArgument: `most` is no count.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.posture("Stand")
            >>> q[0] = 3.0
            >>> [violation.joint for violation in nao.limit_violations(q)]
            ['HeadYaw']
        """
        limit = None if most is None else whole_number(most, "most", 0)
        return self._limits.violations(self._checked(q)[..., self._q_offset :], most=limit)

    def check_limits(self, q: ArrayLike) -> Floats:
        """`q` as an array when every joint is inside its limits, the tables of coupled limits included.

        Raises:
            OutsideLimits: with the violations.

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.check_limits(nao.posture("Stand")).shape
            (25,)
        """
        return np.array(self._within(self._checked(q), "raise"), order="C")

    def clamp(self, q: ArrayLike) -> Floats:
        """The nearest configurations inside the limits: first every joint into its box, then into its table.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.clamp(nao.configuration({"HeadYaw": 3.0}, limits="ignore"))
            >>> round(nao.angles(q)["HeadYaw"], 3)
            2.086
        """
        return self._within(self._checked(q), "clamp")

    # --- inside ---------------------------------------------------------------------------------------------------

    def _neutrals(self, shape: tuple[int, ...]) -> Floats:
        q = np.empty((*shape, self.nq))
        q[...] = self._neutral
        return q

    def _checked(self, q: ArrayLike) -> Floats:
        return self._checks.checked(q)

    def _within(self, q: Floats, limits: str, joints: Collection[str] | None = None) -> Floats:
        if limits == "ignore":
            return q
        check_policy(limits)
        values = q[..., self._q_offset :]
        if limits == "raise":
            one = joints is None and values.ndim == 1
            if one and self._limits.surely_inside(dict(zip(self.joint_names, values.tolist(), strict=True))):
                return q
            count = self._limits.count(values, joints)
            if count:
                raise OutsideLimits(self._limits.violations(values, joints, most=_MOST_LISTED), count)
            return q
        inside = np.array(q, order="C")
        clamped = self._limits.clamp(values)
        if joints is None:
            inside[..., self._q_offset :] = clamped
        else:
            columns = [self._coordinates.column[name] for name in joints]
            inside[..., [self._q_offset + column for column in columns]] = clamped[..., columns]
        return inside
