"""Joint velocities for a twist, and how near the robot is to where some twists can no longer be made."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, as_floats, check_tolerance, common_batch
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.ik.compiling import kept
from nao_kin.ik.descent import FrameMotion
from nao_kin.ik.geometry import cached_limb
from nao_kin.ik.limit_regions import Region, limit_rows, most_rows, region_type
from nao_kin.ik.quadratic_program import quadratic_program
from nao_kin.robot import LIMIT_TOLERANCE, Expression, RobotModel, check_robot

# --- What is known about a twist: the joint velocities for it, and which twists are lost where.

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


# --- Joint velocities for a twist, and how near the robot is to where some twists can no longer be made.

VelocityLimits = Literal["redistribute", "scale", "ignore"]
_CHOICES = ("redistribute", "scale", "ignore")

# A singular value is damped where it falls below this share of the largest.
_NEAR_SINGULAR = 0.02
# Taking velocities back into their ranges and slowing them are repeated so often.
_MOST_PROJECTIONS = 8
# Singular values below this share of the largest are rounding.
_ZERO = 1e-12
# What rounding does to a velocity that is at its limit.
_ROUNDING = 1e-9
# What motions that make no twist cost, as a share of the largest squared singular value.
_LEAST_COST = 1e-10
# Fewer quadratic programs are solved as Python, if nothing has been compiled yet.
_FEW = 64

_Svd = tuple[Floats, Floats, Floats]


def velocity(
    robot: RobotModel,
    q: ArrayLike,
    twist: ArrayLike,
    frame: str,
    *,
    expressed_in: Expression = "mixed",
    damping: float | None = None,
    limits: VelocityLimits = "redistribute",
    dt: float = 0.01,
    length: float = 1.0,
) -> VelocityResult:
    """Joint velocities that give a frame a twist, by the damped pseudo-inverse of its Jacobian.

    With J = U Σ Vᵀ and damping Λ, v = V Σ (Σ² + Λ²)⁻¹ Uᵀ t. Only the joints between the base and the frame move; a
    floating base stands still. Among the velocities that make the twist, these have the least sum of squares; where
    none do, the twist is approached in the sense of least squares.

    Args:
        robot: any robot.
        q: configurations, shape (..., nq).
        twist: (vx, vy, vz, ωx, ωy, ωz), shape (..., 6) [m/s, rad/s]; broadcasts with q.
        frame: the frame to move.
        expressed_in: where the twist is taken, as in `RobotModel.jacobian`: "mixed", "frame" or "root".
        damping: λ of every singular value, so that v = Jᵀ (J Jᵀ + λ² 1)⁻¹ t. None for damping of those singular values
            alone that are below ε, 0.02 of the largest, by λ² = ε² − σ²: velocities stay below ‖t‖/ε and go to zero
            along directions that are lost, while twists that can be made well are not touched.
        limits: what happens where a joint would be faster than its speed limit, or in the time `dt` leave its range, a
            coupled one included. "redistribute": of all velocities inside the limits those that come nearest to the
            twist, by a quadratic program: other joints make up for the one as far as they can; the twist that is left
            may point elsewhere. "scale": all joints are slowed alike, so that the
            twist keeps its direction; a joint that stands at its limit stops all. "ignore": nothing.
        dt: the time [s] for which ranges are looked ahead.
        length: what translation is measured in, for damping and all measures [m]: with the characteristic length of the
            robot, singular values have one unit. Joint velocities of a twist that can be made do not depend on it.

    Returns:
        Velocities, the twist they make, and the measures.

    Raises:
        UnknownName: no such frame, expression or choice of limits.
        BadArgument: no robot, a frame that nothing moves, shapes that do not broadcast, numbers that must be positive.
        WrongShape, NotFinite: q is no configuration, or twist no twist.

    Source: Maciejewski and Klein, Numerical filtering for the operation of robotic manipulators through kinematically
    singular configurations, J. Robotic Systems 1988; Angeles, Fundamentals of Robotic Mechanical Systems, 5.8, for the
    characteristic length.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = nao.posture("StandInit")
        >>> result = nk.ik.velocity(nao, q, [0.05, 0, 0, 0, 0, 0], "LArm")
        >>> result.twist.round(3).tolist()
        [0.049, -0.003, 0.007, 0.0, 0.001, 0.0]
    """
    check_robot(robot)
    if not isinstance(limits, str) or limits not in _CHOICES:
        raise UnknownName("limits", limits, _CHOICES)
    if damping is not None:
        check_tolerance(damping, "damping")
    for value, name in ((dt, "dt"), (length, "length")):
        check_tolerance(value, name)
        if not 0.0 < value < np.inf:
            raise BadArgument(f"{name} must be a finite number above 0, got {value}")
    motion = cached_limb(robot, FrameMotion, frame)
    start, twists = robot.checked(q), as_floats(twist, (6,), "twist")
    batch = common_batch("q and twist", start.shape[:-1], twists.shape[:-1])
    q_rows = np.array(np.broadcast_to(start, (*batch, robot.nq)).reshape(-1, robot.nq))
    twist_rows = np.array(np.broadcast_to(twists, (*batch, 6)).reshape(-1, 6))
    J = motion.jacobians(q_rows, expressed_in)
    unit = np.array([1.0 / length] * 3 + [1.0] * 3)
    scaled = J * unit[:, None]
    svd = np.linalg.svd(scaled, full_matrices=True)
    U, sigma, Vt = svd
    wanted = twist_rows * unit
    asked = _solved(U, sigma, Vt, damping, wanted)
    if limits == "ignore":
        speeds = asked
    else:
        bounds = _Bounds(motion, q_rows, dt)
        if limits == "scale":
            speeds = bounds.scaled(asked)
        else:
            speeds = _redistributed(scaled, wanted, asked, svd, damping, bounds)
    v = np.zeros((len(q_rows), robot.nv))
    v[:, motion.velocity_columns] = speeds
    changed = np.abs(speeds - asked) > _ROUNDING
    size = len(motion.joints)
    return VelocityResult(
        joints=motion.names,
        columns=tuple(motion.velocity_columns.tolist()),
        v=v.reshape(*batch, robot.nv),
        twist=np.einsum("nij,nj->ni", J, speeds).reshape(*batch, 6),
        wanted=twist_rows.reshape(*batch, 6),
        limited=changed.any(axis=-1).reshape(batch),
        damping=_dampings(sigma, damping).reshape(*batch, min(6, size)),
        map=TwistMap(
            motion.names,
            sigma.reshape(*batch, min(6, size)),
            U.reshape(*batch, 6, 6),
            Vt.swapaxes(-1, -2).reshape(*batch, size, size),
            float(length),
        ),
    )


class _Bounds:
    """What velocities joints may have, from configurations (n, nq)."""

    def __init__(self, motion: FrameMotion, q: Floats, dt: float) -> None:
        self._motion, self._region, self._dt = motion, motion.limited, dt
        self._values = motion.joint_values(q)
        # Whether the configurations are inside to begin with.
        off = np.abs(self._region.project(self._values) - self._values)
        self._inside: NDArray[np.bool_] = np.asarray(off.max(axis=-1) <= LIMIT_TOLERANCE)
        speed = motion.robot.velocity_limits[motion.joints]
        # A URDF without speed limits says 0, which would hold every joint.
        self._fastest: Floats = np.where(speed > 0.0, speed, np.inf)

    def allowed(self, speeds: Floats, rows: NDArray[np.intp]) -> Floats:
        """Velocities near `speeds`, shape (k, m), that keep the speed limits, and the ranges for the time dt.

        From outside its range, a joint comes back as fast as it may.
        """
        allowed = np.clip(speeds, -self._fastest, self._fastest)
        values = self._values[rows]
        for _ in range(_MOST_PROJECTIONS):
            ahead = values.copy()
            ahead[:, self._motion.joints] += allowed * self._dt
            moved = (self._region.project(ahead) - values)[:, self._motion.joints] / self._dt
            # Rounding of the division counts for nothing.
            moved = np.where(np.abs(moved - allowed) <= _ROUNDING, allowed, moved)
            # What leads back into a range, or along the edge of a coupled one, may be too fast.
            allowed = np.clip(moved, -self._fastest, self._fastest)
            fine: NDArray[np.bool_] = np.asarray(np.abs(allowed - moved).max(axis=-1) <= _ROUNDING)
            fine = np.asarray(fine | ~self._inside[rows])
            if np.all(fine):
                return np.asarray(allowed)
        # Slowed alike, what leads into a range that is not convex may still lead out again, around a corner of a table.
        slowest = np.max(np.abs(moved) / self._fastest, axis=-1, keepdims=True, initial=1.0)
        alike = np.where(fine[:, None], allowed, moved / slowest)
        ahead[:, self._motion.joints] = values[:, self._motion.joints] + alike * self._dt
        # A joint is farther above a steep edge than from it, hence the tenth of the tolerance.
        cornered = ~fine & (np.abs(self._region.project(ahead) - ahead).max(axis=-1) > 0.1 * LIMIT_TOLERANCE)
        return np.asarray(np.where(cornered[:, None], 0.0, alike))

    def numbers(self, rows: NDArray[np.intp]) -> tuple[Region, Floats, Floats, Floats, float]:
        """What `_programs` takes of configurations."""
        values = self._values[rows]
        moving = np.ascontiguousarray(values[:, self._motion.joints])
        return self._region.numbers, moving, self._region.still_values(values), self._fastest * self._dt, self._dt

    def scaled(self, speeds: Floats) -> Floats:
        """The same velocities, all slowed alike until every joint is inside."""
        rows = np.arange(len(speeds))
        share: Floats = 1.0 / np.max(np.abs(speeds) / self._fastest, axis=-1, initial=1.0)
        for _ in range(2 * len(self._motion.joints)):
            tried = speeds * share[:, None]
            allowed = self.allowed(tried, rows)
            outside: NDArray[np.bool_] = np.abs(allowed - tried) > _ROUNDING
            if not np.any(outside):
                return np.asarray(tried)
            # How much of each velocity is allowed; nothing where a joint would have to turn back.
            with np.errstate(divide="ignore", invalid="ignore"):
                kept = np.where(outside, np.clip(allowed / tried, 0.0, 1.0), 1.0)
            share = share * kept.min(axis=-1)
        return np.asarray(np.where(np.any(outside, axis=-1, keepdims=True), 0.0, tried))


def _redistributed(
    J: Floats, wanted: Floats, asked: Floats, svd: _Svd, damping: float | None, bounds: _Bounds
) -> Floats:
    """The velocities inside the bounds with the least ‖J v − t‖² + ‖Λ Vᵀ v‖², as those asked have it without bounds."""
    speeds: Floats = asked.copy()
    allowed = bounds.allowed(asked, np.arange(len(asked)))
    rows = np.flatnonzero(np.abs(allowed - asked).max(axis=-1, initial=0.0) > _ROUNDING)
    if not rows.size:
        return speeds
    _, sigma, Vt = (part[rows] for part in svd)
    size = sigma.shape[-1]
    # Motions that are lost or make nothing cost next to nothing, so that there is one minimum.
    squares = np.repeat(_LEAST_COST * np.square(sigma[:, :1]), Vt.shape[-1], axis=-1)
    squares[:, :size] += np.square(sigma) + np.square(_dampings(sigma, damping))
    H = np.ascontiguousarray(np.einsum("nki,nk,nkj->nij", Vt, squares, Vt))
    g = np.ascontiguousarray(-np.einsum("nij,ni->nj", J[rows], wanted[rows]))
    found, solved = np.zeros_like(g), np.zeros(len(rows), dtype=np.bool_)
    solve = _programs.uncompiled if len(rows) < _FEW and not _programs.in_memory else _programs
    solve(*bounds.numbers(rows), H, g, found, solved)
    speeds[rows] = bounds.allowed(np.where(solved[:, None], found, asked[rows]), rows)
    return speeds


def _arguments() -> tuple[Any, ...]:
    from numba import types

    rows, number = types.float64[:, ::1], types.float64
    bounds = region_type(), rows, rows, types.float64[::1], number
    return *bounds, types.float64[:, :, ::1], rows, rows, types.boolean[::1]


@kept("velocities", _arguments)
def _programs(
    region: Region, values: Floats, still: Floats, longest: Floats, dt: float,
    H: Floats, g: Floats, found: Floats, solved: NDArray[np.bool_],
) -> None:  # fmt: skip
    """The minimum of each ½ vᵀ H v + gᵀ v whose step v dt stays inside the limits and is no longer than `longest`."""
    A, b = np.empty((most_rows(region), g.shape[1])), np.empty(most_rows(region))
    for k in range(len(g)):
        count = limit_rows(region, values[k], still[k], longest, A, b, 0)
        for i in range(count):
            b[i] /= dt
        solved[k] = quadratic_program(H[k], g[k], A, b, count, 0, found[k])


def _dampings(sigma: Floats, damping: float | None) -> Floats:
    """λ of each singular value, descending in (n, k): the one given, or one for each that is small."""
    if damping is not None:
        return np.full(sigma.shape, float(damping))
    threshold = _NEAR_SINGULAR * sigma[:, :1]
    return np.asarray(np.sqrt(np.maximum(0.0, np.square(threshold) - np.square(sigma))))


def _solved(U: Floats, sigma: Floats, Vt: Floats, damping: float | None, twist: Floats) -> Floats:
    """V Σ (Σ² + Λ²)⁻¹ Uᵀ t, shape (n, m); singular values that are rounding count as zero."""
    count = sigma.shape[-1]
    along = np.einsum("nij,ni->nj", U[:, :, :count], twist)
    squares = np.square(sigma) + np.square(_dampings(sigma, damping))
    real = sigma > _ZERO * sigma[:, :1]
    gains = np.divide(sigma, squares, out=np.zeros_like(sigma), where=real)
    return np.asarray(np.einsum("nji,nj->ni", Vt[:, :count], gains * along))
