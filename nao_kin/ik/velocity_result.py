"""What is known about a twist: the joint velocities for it, and which twists are lost where."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._common.arrays import Floats
from nao_kin._common.scalars import check_tolerance

TWIST_NAMES = ("vx", "vy", "vz", "ωx", "ωy", "ωz")

# A singular value below this share of the largest makes its direction a lost one.
SINGULAR = 1e-6
# Components of a named direction below this share of the largest are left out.
_SEEN = 1e-3


@dataclass(frozen=True, eq=False)
class TwistMap:
    """The Jacobian J = U Σ Vᵀ from joint velocities to the twist of a frame, for a batch (...) of configurations.

    Rows of translation are divided by `length`, so that all have the unit 1/s.

    Attributes:
        joints: the m joints that move the frame, by name.
        singular_values: the k = min(6, m) singular values, largest first, shape (..., k).
        twists: U, a twist in each column; those after the first k cannot be made at all, shape (..., 6, 6).
        velocities: V, joint velocities in each column; those after the first k move nothing, shape (..., m, m).
        length: the unit of translation [m].

    Examples:
        >>> nao = nk.load_nao()
        >>> q = nao.posture("StandInit")
        >>> result = nk.ik.velocity(nao, q, [0.05, 0, 0, 0, 0, 0], "LArm")
        >>> result.map.joints[0], result.map.singular_values.shape
        ('LShoulderPitch', (5,))
    """

    joints: tuple[str, ...]
    singular_values: Floats
    twists: Floats
    velocities: Floats
    length: float

    @property
    def manipulability(self) -> Floats:
        """√det(J Jᵀ), or with fewer than six joints √det(Jᵀ J): the product of the k singular values, shape (...).

        Source: Yoshikawa, Manipulability of robotic mechanisms, IJRR 1985.
        """
        return np.asarray(self.singular_values.prod(axis=-1))

    @property
    def condition_number(self) -> Floats:
        """Largest by smallest of the k singular values, shape (...); infinite where the smallest is 0."""
        sigma = self.singular_values
        infinite = np.full(sigma.shape[:-1], np.inf)
        return np.asarray(np.divide(sigma[..., 0], sigma[..., -1], out=infinite, where=sigma[..., -1] > 0.0))

    def rank(self, singular: float = SINGULAR) -> NDArray[np.int64]:
        """How many independent twists can be made, shape (...).

        Args:
            singular: share of the largest singular value below which one counts as zero.

        Raises:
            BadArgument: no number ≥ 0.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.posture("StandInit")
            >>> result = nk.ik.velocity(nao, q, [0.05, 0, 0, 0, 0, 0], "LArm")
            >>> int(result.map.rank())
            5
        """
        check_tolerance(singular, "singular")
        sigma = self.singular_values
        return np.asarray((sigma > singular * sigma[..., :1]).sum(axis=-1), dtype=np.int64)

    def lost_twists(self, index: tuple[int, ...] = (), singular: float = SINGULAR) -> tuple[str, ...]:
        """Twists that cannot be made, by name: "ωx", "vx + 0.5 ωz"; as many as the rank is below six.

        They span, in the axes in which the Jacobian is expressed, what is perpendicular to all twists that can be made.

        Args:
            index: which configuration of the batch; () where there is one.
            singular: as in `rank`.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.posture("StandInit")
            >>> result = nk.ik.velocity(nao, q, [0.05, 0, 0, 0, 0, 0], "LArm")
            >>> len(result.map.lost_twists())
            1
        """
        rank = int(self.rank(singular)[index])
        return _named(self.twists[index][:, rank:], TWIST_NAMES)

    def idle_joints(self, index: tuple[int, ...] = (), singular: float = SINGULAR) -> tuple[str, ...]:
        """Joint velocities that do not move the frame, by name: "LElbowYaw − LWristYaw".

        Args:
            index: which configuration of the batch; () where there is one.
            singular: as in `rank`.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.posture("StandInit")
            >>> result = nk.ik.velocity(nao, q, [0.05, 0, 0, 0, 0, 0], "LArm")
            >>> result.map.idle_joints()
            ()
        """
        rank = int(self.rank(singular)[index])
        return _named(self.velocities[index][:, rank:], self.joints)


@dataclass(frozen=True, eq=False)
class VelocityResult:
    """Joint velocities for twists, for a batch (...).

    Attributes:
        joints: the m joints that may move, by name.
        columns: their places in v.
        v: velocities in the order of the Jacobian's columns, zero for all other joints, shape (..., nv).
        twist: the twist that they make, shape (..., 6) [m/s, rad/s].
        wanted: the twist that was asked for, shape (..., 6).
        limited: whether speed limits or ranges have changed the velocities, shape (...).
        damping: λ of each singular value, shape (..., k).
        map: the singular values and directions of the Jacobian.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = nao.posture("StandInit")
        >>> result = nk.ik.velocity(nao, q, [0.05, 0, 0, 0, 0, 0], "LArm")
        >>> result.v.shape, bool(result.limited.any())
        ((25,), False)
    """

    joints: tuple[str, ...]
    columns: tuple[int, ...]
    v: Floats
    twist: Floats
    wanted: Floats
    limited: NDArray[np.bool_]
    damping: Floats
    map: TwistMap

    @property
    def residual(self) -> Floats:
        """Sizes of wanted − twist in linear and angular velocity, shape (..., 2) [m/s, rad/s]."""
        left = self.wanted - self.twist
        return np.stack([np.linalg.norm(left[..., :3], axis=-1), np.linalg.norm(left[..., 3:], axis=-1)], axis=-1)

    @property
    def manipulability(self) -> Floats:
        """As `TwistMap.manipulability`."""
        return self.map.manipulability

    @property
    def condition_number(self) -> Floats:
        """As `TwistMap.condition_number`."""
        return self.map.condition_number


def _named(directions: Floats, names: tuple[str, ...]) -> tuple[str, ...]:
    """A basis of the columns' span with as many zeros as elimination brings, each vector as a sum of names."""
    basis = _reduced(directions.T)
    return tuple(_sum_of(vector, names) for vector in basis)


def _reduced(rows: ArrayLike) -> Floats:
    """Independent rows by Gauss–Jordan elimination, the largest entry as the pivot each time; pivots are 1."""
    matrix: Floats = np.array(rows, dtype=np.float64)
    order, done = [], np.zeros(len(matrix), dtype=np.bool_)
    for _ in range(len(matrix)):
        sizes = np.abs(matrix) * ~done[:, None]
        row, column = (int(i) for i in np.unravel_index(int(np.argmax(sizes)), sizes.shape))
        matrix[row] /= matrix[row, column]
        others = np.arange(len(matrix)) != row
        matrix[others] -= matrix[others, column][:, None] * matrix[row]
        done[row] = True
        order.append((column, row))
    return matrix[[row for _, row in sorted(order)]]


def _sum_of(vector: Floats, names: tuple[str, ...]) -> str:
    """The vector as a sum: "vx + 0.5 ωz"; the first name is positive."""
    scaled = vector / np.abs(vector).max()
    places = np.flatnonzero(np.abs(scaled) > _SEEN)
    scaled = scaled * np.sign(scaled[places[0]])
    text = ""
    for place in places:
        size = f"{abs(scaled[place]):.3g}"
        term = names[place] if size == "1" else f"{size} {names[place]}"
        sign = "−" if scaled[place] < 0.0 else "+"
        text += f" {sign} {term}" if text else term
    return text
