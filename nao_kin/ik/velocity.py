"""Joint velocities for a twist, and the distance from singular configurations."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Annotated, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import (
    LIMIT_TOLERANCE,
    Floats,
    as_floats,
    batch_index,
    check_tolerance,
    choice,
    common_batch,
    positive,
)
from nao_kin._core.text import one_line_repr
from nao_kin._kernels.cache import CachedKernel, Floats1, Floats2, Floats3
from nao_kin.errors import WrongShape
from nao_kin.ik.closed_form import cached_limb
from nao_kin.ik.least_squares import FrameMotion
from nao_kin.ik.limit_regions import Region, limit_rows, max_rows
from nao_kin.ik.quadratic_program import quadratic_program
from nao_kin.robot import Expression, RobotModel

# --- The results: joint velocities, and the twists that are not possible.

TWIST_NAMES = ("vx", "vy", "vz", "ωx", "ωy", "ωz")

# A direction is lost if its singular value is a smaller share of the largest than this.
_SINGULAR = 1e-6
# Components of a named direction below this share of the largest are left out.
_SEEN = 1e-3


@one_line_repr
@dataclass(frozen=True, eq=False)
class TwistMap:
    """The Jacobian J = U Σ Vᵀ from joint velocities to the twist of a frame, for a batch (...) of configurations.

    J has r = 6 rows, or r = 3 if only the linear velocity is requested: a twist is then a linear velocity. Rows of
    translation are divided by `length`, so that all have the unit 1/s.

    Attributes:
        joints: names of the m joints that move the frame.
        singular_values: the k = min(r, m) singular values, largest first, shape (..., k).
        twists: U, a twist in each column; those after the first k are not possible, shape (..., r, r).
        velocities: V, joint velocities in each column; those after the first k do not move the frame, (..., m, m).
        length: the unit of translation [m].
    """

    joints: tuple[str, ...]
    singular_values: Floats
    twists: Floats
    velocities: Floats
    length: float

    @property
    def manipulability(self) -> Floats:
        """√det(J Jᵀ), or √det(Jᵀ J) with fewer than r joints: the product of the k singular values, shape (...).

        Source: Yoshikawa, Manipulability of robotic mechanisms, IJRR 1985.
        """
        return np.asarray(self.singular_values.prod(axis=-1))

    @property
    def condition_number(self) -> Floats:
        """Ratio of the largest to the smallest of the k singular values, shape (...); infinite if that is 0."""
        sigma = self.singular_values
        infinite = np.full(sigma.shape[:-1], np.inf)
        return np.asarray(np.divide(sigma[..., 0], sigma[..., -1], out=infinite, where=sigma[..., -1] > 0.0))

    def rank(self) -> NDArray[np.int64]:
        """Return the number of independent possible twists, shape (...): singular values over 1e-6 of the largest."""
        sigma = self.singular_values
        return np.asarray((sigma > _SINGULAR * sigma[..., :1]).sum(axis=-1), dtype=np.int64)

    def lost_twists(self, index: tuple[int, ...] = ()) -> tuple[str, ...]:
        """Return r − rank twists that are not possible, by name: "ωx", "vx + 0.5 ωz".

        They span the space perpendicular to all possible twists, in the axes of the Jacobian.

        Args:
            index: index of the configuration in a batch.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.posture("StandInit")
            >>> result = nk.ik.velocity(nao, q, [0.05, 0, 0, 0, 0, 0], "LArm")
            >>> int(result.map.rank()), len(result.map.lost_twists()), result.map.idle_joints()
            (5, 1, ())
        """
        index = batch_index(index, self.singular_values.shape[:-1])
        return _named(self.twists[index][:, int(self.rank()[index]) :], TWIST_NAMES)

    def idle_joints(self, index: tuple[int, ...] = ()) -> tuple[str, ...]:
        """Return joint velocities that do not move the frame, by name: "LElbowYaw − LWristYaw".

        Args:
            index: index of the configuration in a batch.
        """
        index = batch_index(index, self.singular_values.shape[:-1])
        return _named(self.velocities[index][:, int(self.rank()[index]) :], self.joints)


@one_line_repr
@dataclass(frozen=True, eq=False)
class VelocityResult:
    """Joint velocities for twists, for a batch (...).

    Attributes:
        joints: names of the m joints that may move.
        columns: their indices in v.
        v: velocities in the order of the Jacobian's columns, zero for all other joints, shape (..., nv).
        twist: the resulting twist, shape (..., 6) [m/s, rad/s].
        wanted: the requested twist, shape (..., 6), or linear velocity, shape (..., 3).
        limited: whether speed limits or ranges have changed the velocities, shape (...).
        damping: λ of each singular value, shape (..., k).
        map: the singular values and directions of the Jacobian.
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
        """Norms of wanted − twist in linear and angular velocity, shape (..., 2) [m/s, rad/s].

        The second is 0 if only a linear velocity is requested.
        """
        error = self.wanted - self.twist[..., : self.wanted.shape[-1]]
        return np.stack([np.linalg.norm(error[..., :3], axis=-1), np.linalg.norm(error[..., 3:], axis=-1)], axis=-1)


def _named(directions: Floats, names: tuple[str, ...]) -> tuple[str, ...]:
    """Return a basis of the columns' span, by Gauss–Jordan elimination with the largest pivots, as sums of names."""
    matrix: Floats = np.array(directions.T)
    order, done = [], np.zeros(len(matrix), dtype=np.bool_)
    for _ in range(len(matrix)):
        sizes = np.abs(matrix) * ~done[:, None]
        row, column = (int(i) for i in np.unravel_index(int(np.argmax(sizes)), sizes.shape))
        matrix[row] /= matrix[row, column]
        others = np.arange(len(matrix)) != row
        matrix[others] -= matrix[others, column][:, None] * matrix[row]
        done[row] = True
        order.append((column, row))
    return tuple(_sum_of(matrix[row], names) for _, row in sorted(order))


def _sum_of(vector: Floats, names: tuple[str, ...]) -> str:
    """Return a vector as a sum, "vx + 0.5 ωz", whose first term is positive."""
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


# --- `velocity`.

VelocityLimits = Literal["enforce", "scale", "ignore"]

# A singular value is damped if it is a smaller share of the largest than this.
_NEAR_SINGULAR = 0.02
# Repetitions of projecting velocities into their ranges and clipping them.
_MAX_PROJECTIONS = 8
# Singular values below this share of the largest are rounding.
_ZERO = 1e-12
# Rounding of a velocity at its limit.
_ROUNDING = 1e-9
# Cost of motions without a twist, as a share of the largest squared singular value.
_MIN_COST = 1e-10
# Fewer quadratic programs than this are solved as Python before the kernel is in memory.
_FEW = 64


def velocity(
    robot: RobotModel,
    q: ArrayLike,
    twist: ArrayLike,
    frame: str,
    *,
    expressed_in: Expression = "mixed",
    damping: float | None = None,
    limits: VelocityLimits = "enforce",
    dt: float = 0.01,
    length: float = 1.0,
) -> VelocityResult:
    """Return joint velocities that give a frame a twist or a linear velocity, by a damped pseudo-inverse.

    With J = U Σ Vᵀ and damping Λ, v = V Σ (Σ² + Λ²)⁻¹ Uᵀ t. Only the joints between the base and the frame move; a
    floating base does not. Among the velocities that give the twist, these have the least sum of squares; if no
    velocities give it, these approximate it in the sense of least squares.

    Args:
        robot: any robot.
        q: configurations, shape (..., nq).
        twist: (vx, vy, vz, ωx, ωy, ωz), shape (..., 6) [m/s, rad/s], or only (vx, vy, vz), shape (..., 3), with any
            angular velocity: J is then the rows of the linear velocity. Broadcasts with q.
        frame: the frame to move.
        expressed_in: "mixed", "frame" or "root", as in `RobotModel.jacobian`.
        damping: λ of every singular value, so that v = Jᵀ (J Jᵀ + λ² 1)⁻¹ t. With None, only singular values below ε,
            0.02 of the largest, are damped, by λ² = ε² − σ²: velocities stay below ‖t‖/ε and go to zero along lost
            directions, and other twists are not affected.
        limits: what to do if a joint would exceed its speed limit, or would leave its range or coupled limit in `dt`.
            "enforce": a quadratic program finds the velocities inside the limits with the nearest twist, which may
            have another direction. "scale": all joints slow down by the same factor, so that the twist keeps its
            direction; a joint at its limit may stop all joints. "ignore": limits are not applied.
        dt: the time [s] within which ranges hold.
        length: the unit of translation for damping and all measures [m]; with the characteristic length of the robot,
            singular values have one unit. It does not affect the velocities of a possible twist.

    Raises:
        UnknownName: a frame that does not exist.
        BadArgument: a frame that no joint moves, or `dt` or `length` that is not positive.

    Source: Maciejewski and Klein, Numerical filtering for the operation of robotic manipulators through kinematically
    singular configurations, J. Robotic Systems 1988; Angeles, Fundamentals of Robotic Mechanical Systems, 5.8, for the
    characteristic length.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = nao.posture("StandInit")
        >>> result = nk.ik.velocity(nao, q, [0.05, 0, 0, 0, 0, 0], "LArm")
        >>> result.twist.round(3).tolist()
        [0.049, -0.003, 0.007, 0.0, 0.001, 0.0]
        >>> nk.ik.velocity(nao, q, [0.05, 0, 0], "LArm").residual.round(9).tolist()
        [0.0, 0.0]
    """
    choice(limits, get_args(VelocityLimits), "limits")
    if damping is not None:
        check_tolerance(damping, "damping")
    positive(dt, "dt")
    positive(length, "length")
    motion = cached_limb(robot, FrameMotion, frame)
    start, twists = robot.checked(q), as_floats(twist, (), "twist")
    rows = twists.shape[-1] if twists.ndim else 0
    if rows not in (3, 6):
        raise WrongShape("twist", "(..., 6), or (..., 3) for a linear velocity", twists.shape)
    batch = common_batch("q and twist", start.shape[:-1], twists.shape[:-1])
    q_rows = np.array(np.broadcast_to(start, (*batch, robot.nq)).reshape(-1, robot.nq))
    twist_rows = np.array(np.broadcast_to(twists, (*batch, rows)).reshape(-1, rows))
    J = motion.jacobians(q_rows, expressed_in)
    unit = np.array([1.0 / length] * 3 + [1.0] * 3)[:rows]
    scaled = J[:, :rows] * unit[:, None]
    U, sigma, Vt = np.linalg.svd(scaled, full_matrices=True)
    dampings, wanted = _dampings(sigma, damping), twist_rows * unit
    speeds = unlimited = _solved(U, sigma, Vt, dampings, wanted)
    if limits == "scale":
        speeds = _Bounds(motion, q_rows, dt).scaled(unlimited)
    elif limits == "enforce":
        bounds = _Bounds(motion, q_rows, dt)
        speeds = _redistributed(scaled, wanted, unlimited, sigma, Vt, dampings, bounds)
    v = np.zeros((len(q_rows), robot.nv))
    v[:, motion.velocity_columns] = speeds
    changed = np.abs(speeds - unlimited) > _ROUNDING
    size, values = len(motion.joints), sigma.reshape(*batch, sigma.shape[-1])
    V = Vt.swapaxes(-1, -2).reshape(*batch, size, size)
    return VelocityResult(
        joints=motion.names,
        columns=tuple(motion.velocity_columns.tolist()),
        v=v.reshape(*batch, robot.nv),
        twist=np.einsum("nij,nj->ni", J, speeds).reshape(*batch, 6),
        wanted=twist_rows.reshape(*batch, rows),
        limited=changed.any(axis=-1).reshape(batch),
        damping=dampings.reshape(values.shape),
        map=TwistMap(motion.names, values, U.reshape(*batch, rows, rows), V, float(length)),
    )


class _Bounds:
    """Bounds on joint velocities at configurations (n, nq)."""

    def __init__(self, motion: FrameMotion, q: Floats, dt: float) -> None:
        self._motion, self._region, self._dt = motion, motion.limited, dt
        self._values = motion.joint_values(q)
        # Whether the configurations are inside the limits.
        off = np.abs(self._region.project(self._values) - self._values)
        self._inside: NDArray[np.bool_] = np.asarray(off.max(axis=-1) <= LIMIT_TOLERANCE)
        self._fastest: Floats = motion.robot.velocity_limits[motion.joints]

    def allowed(self, speeds: Floats, rows: NDArray[np.intp]) -> Floats:
        """Return velocities near `speeds` (k, m) inside the speed limits and, for the time dt, the ranges."""
        allowed = np.clip(speeds, -self._fastest, self._fastest)
        values = self._values[rows]
        for _ in range(_MAX_PROJECTIONS):
            ahead = values.copy()
            ahead[:, self._motion.joints] += allowed * self._dt
            moved = (self._region.project(ahead) - values)[:, self._motion.joints] / self._dt
            # Ignore rounding of the division.
            moved = np.where(np.abs(moved - allowed) <= _ROUNDING, allowed, moved)
            # Motion back into a range, or along the edge of a coupled limit, may be too fast.
            allowed = np.clip(moved, -self._fastest, self._fastest)
            fine: NDArray[np.bool_] = np.asarray(np.abs(allowed - moved).max(axis=-1) <= _ROUNDING)
            fine = np.asarray(fine | ~self._inside[rows])
            if np.all(fine):
                return np.asarray(allowed)
        # All joints slow down alike; in a coupled range that is not convex this may still lead out at a corner.
        slowest = np.max(np.abs(moved) / self._fastest, axis=-1, keepdims=True, initial=1.0)
        alike = np.where(fine[:, None], allowed, moved / slowest)
        ahead[:, self._motion.joints] = values[:, self._motion.joints] + alike * self._dt
        # At a steep edge the excess of a joint is larger than its distance from the edge: use a tenth of the tolerance.
        cornered = ~fine & (np.abs(self._region.project(ahead) - ahead).max(axis=-1) > 0.1 * LIMIT_TOLERANCE)
        return np.asarray(np.where(cornered[:, None], 0.0, alike))

    def numbers(self, rows: NDArray[np.intp]) -> tuple[Region, Floats, Floats, Floats, float]:
        """Return the arguments of `_programs` for configurations."""
        values = self._values[rows]
        moving = np.ascontiguousarray(values[:, self._motion.joints])
        return self._region.numbers, moving, self._region.fixed_values(values), self._fastest * self._dt, self._dt

    def scaled(self, speeds: Floats) -> Floats:
        """Return the velocities, all scaled by one factor so that every joint is inside."""
        rows = np.arange(len(speeds))
        share: Floats = 1.0 / np.max(np.abs(speeds) / self._fastest, axis=-1, initial=1.0)
        for _ in range(2 * len(self._motion.joints)):
            tried = speeds * share[:, None]
            allowed = self.allowed(tried, rows)
            outside: NDArray[np.bool_] = np.abs(allowed - tried) > _ROUNDING
            if not np.any(outside):
                return np.asarray(tried)
            # The allowed share of each velocity; 0 for a joint that would have to turn back.
            with np.errstate(divide="ignore", invalid="ignore"):
                shares = np.where(outside, np.clip(allowed / tried, 0.0, 1.0), 1.0)
            share = share * shares.min(axis=-1)
        return np.asarray(np.where(np.any(outside, axis=-1, keepdims=True), 0.0, tried))


def _redistributed(
    J: Floats, wanted: Floats, unlimited: Floats, sigma: Floats, Vt: Floats, dampings: Floats, bounds: _Bounds
) -> Floats:
    """Return the v inside the bounds with the least ‖J v − t‖² + ‖Λ Vᵀ v‖²; `unlimited` is the least without bounds."""
    speeds: Floats = unlimited.copy()
    allowed = bounds.allowed(unlimited, np.arange(len(unlimited)))
    rows = np.flatnonzero(np.abs(allowed - unlimited).max(axis=-1, initial=0.0) > _ROUNDING)
    if not rows.size:
        return speeds
    sigma, Vt = sigma[rows], Vt[rows]
    # A small cost of motions without a twist makes the minimum unique.
    squares = np.repeat(_MIN_COST * np.square(sigma[:, :1]), Vt.shape[-1], axis=-1)
    squares[:, : sigma.shape[-1]] += np.square(sigma) + np.square(dampings[rows])
    H = np.ascontiguousarray(np.einsum("nki,nk,nkj->nij", Vt, squares, Vt))
    g = np.ascontiguousarray(-np.einsum("nij,ni->nj", J[rows], wanted[rows]))
    found, solved = np.zeros_like(g), np.zeros(len(rows), dtype=np.bool_)
    solve = _programs.uncompiled if len(rows) < _FEW and not _programs.in_memory else _programs
    solve(*bounds.numbers(rows), H, g, found, solved)
    speeds[rows] = bounds.allowed(np.where(solved[:, None], found, unlimited[rows]), rows)
    return speeds


@partial(CachedKernel, what="a kernel of inverse kinematics, velocities", name="ik kernel, velocities")
def _programs(
    region: Region, values: Floats2, fixed: Floats2, longest: Floats1, dt: float,
    H: Floats3, g: Floats2, velocities: Floats2, solved: Annotated[NDArray[np.bool_], "boolean", 1],
) -> None:  # fmt: skip
    """Minimise each ½ vᵀ H v + gᵀ v with the step v dt inside the limits and no longer than `longest`."""
    A, b = np.empty((max_rows(region), g.shape[1])), np.empty(max_rows(region))
    for k in range(len(g)):
        count = limit_rows(region, values[k], fixed[k], longest, A, b, 0)
        for i in range(count):
            b[i] /= dt
        solved[k] = quadratic_program(H[k], g[k], A, b, count, 0, velocities[k])


def _dampings(sigma: Floats, damping: float | None) -> Floats:
    """Return λ of each of the singular values (n, k), in descending order: the given one, or one for small values."""
    if damping is not None:
        return np.full(sigma.shape, float(damping))
    threshold = _NEAR_SINGULAR * sigma[:, :1]
    return np.asarray(np.sqrt(np.maximum(0.0, np.square(threshold) - np.square(sigma))))


def _solved(U: Floats, sigma: Floats, Vt: Floats, dampings: Floats, twist: Floats) -> Floats:
    """Return V Σ (Σ² + Λ²)⁻¹ Uᵀ t, shape (n, m); singular values that are rounding count as zero."""
    count = sigma.shape[-1]
    along = np.einsum("nij,ni->nj", U[:, :, :count], twist)
    squares = np.square(sigma) + np.square(dampings)
    real = sigma > _ZERO * sigma[:, :1]
    gains = np.divide(sigma, squares, out=np.zeros_like(sigma), where=real)
    return np.asarray(np.einsum("nji,nj->ni", Vt[:, :count], gains * along))
