"""Damped least squares for many problems at once: Levenberg–Marquardt with projection onto limits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nao_kin._common.arrays import Floats
from nao_kin.ik.limit_regions import LimitRegion
from nao_kin.ik.pose_errors import PoseErrors

Rows = NDArray[np.intp]
Reached = Callable[[Floats], NDArray[np.bool_]]

# Damping is this share of the squared error at first; it grows where a step fails, and shrinks where one succeeds.
_FIRST_DAMPING = 0.1
_LEAST_DAMPING, _MOST_DAMPING = 1e-6, 1e12
# A step that lessens the error by less than this share of what its linear model promised has failed.
_LEAST_GAIN = 1e-3
# No joint moves by more in one step [rad or m]: beyond, the linear model says nothing.
_LONGEST_STEP = 1.0
# A slope of this share of the steepest there could be is flat.
_FLAT = 1e-7


@dataclass(frozen=True, eq=False)
class Minimum:
    """Where searches have ended, n of them.

    Attributes:
        q: configurations, shape (n, nq).
        cost: half the squared weighted error, shape (n,).
        reached: the error was as small as asked, shape (n,).
        settled: no direction inside the limits lessens the error any more, shape (n,).
    """

    q: Floats
    cost: Floats
    reached: NDArray[np.bool_]
    settled: NDArray[np.bool_]

    def take(self, rows: Rows, other: Minimum, part: slice) -> None:
        """Take over what another search found for these rows, where it is the first to succeed or nearer."""
        better = ~self.reached[rows] & (other.reached[part] | (other.cost[part] < self.cost[rows]))
        good = rows[better]
        self.q[good], self.cost[good] = other.q[part][better], other.cost[part][better]
        self.reached[good], self.settled[good] = other.reached[part][better], other.settled[part][better]


def minimise(
    errors: PoseErrors, region: LimitRegion, q: Floats, rows: Rows, reached: Reached, most_iterations: int
) -> Minimum:
    """Lessen ½‖e(q)‖² from every start, inside the limits.

    A step solves (JᵀJ + λ 1) δ = −Jᵀe for the directions that the limits leave open, with λ in proportion to ‖e‖²
    (quadratic convergence also where J is singular), is shortened to 1 rad, and projected onto the limits. λ follows
    the ratio of the decrease found to the one the linear model promised.

    Args:
        errors: the errors and their derivatives.
        region: the limits; the starts are inside.
        q: starts, shape (n, nq).
        rows: the target of each start, shape (n,).
        reached: tells of weighted errors (k, 6) which are small enough.
        most_iterations: stop a search after so many steps.

    Returns:
        Where the searches ended.

    Source: Sugihara, Solvability-unconcerned inverse kinematics by the Levenberg–Marquardt method, IEEE T-RO 2011;
    Nielsen, Damping parameter in Marquardt's method, IMM-REP-1999-05.
    """
    search = _Searches(errors, region, q, rows, reached)
    for _ in range(most_iterations):
        if not search.active.size:
            break
        search.step()
    return Minimum(search.q, search.cost, search.reached, search.settled)


class _Searches:
    """The state of n searches; those that have ended are no longer computed."""

    def __init__(self, errors: PoseErrors, region: LimitRegion, q: Floats, rows: Rows, reached: Reached) -> None:
        count = len(q)
        self._errors, self._region, self._rows, self._is_reached = errors, region, rows, reached
        self.q: Floats = q.copy()
        self.residuals, self.J = errors(q, rows)
        self.cost: Floats = 0.5 * np.square(self.residuals).sum(axis=-1)
        self.reached: NDArray[np.bool_] = reached(self.residuals)
        self.settled: NDArray[np.bool_] = np.zeros(count, dtype=np.bool_)
        self._damping, self._growth = np.full(count, _FIRST_DAMPING), np.full(count, 2.0)
        self.active: Rows = np.flatnonzero(~self.reached)

    def step(self) -> None:
        """One step of every search that has not ended."""
        at, motion = self.active, self._errors.motion
        q, residuals, J, cost = self.q[at], self.residuals[at], self.J[at], self.cost[at]
        downhill = -np.einsum("nij,ni->nj", J, residuals)
        open_directions = self._region.tangents(motion.joint_values(q), downhill)
        J_open = J @ open_directions
        steps = _damped_steps(J_open, residuals, 2.0 * self._damping[at] * cost)
        steps /= np.maximum(1.0, np.abs(steps).max(axis=-1, initial=0.0) / _LONGEST_STEP)[:, None]
        ahead = motion.moved(q, steps)
        values = motion.joint_values(ahead)
        values[...] = self._region.project(values)
        # Where projection has changed the step, the model is asked about what is left of it.
        steps = (values - motion.joint_values(q))[:, motion.joints]
        change = np.einsum("nij,nj->ni", J, steps)
        promised = -(np.einsum("ni,ni->n", residuals, change) + 0.5 * np.square(change).sum(axis=-1))
        new_residuals, new_J = self._errors(ahead, self._rows[at])
        new_cost = 0.5 * np.square(new_residuals).sum(axis=-1)
        gain = (cost - new_cost) / np.where(promised > 0.0, promised, np.inf)
        better = (new_cost < cost) & (gain > _LEAST_GAIN)
        self._adapt(at, gain, better)
        good = at[better]
        self._region.unwind(values)
        self.q[good], self.residuals[good], self.J[good] = ahead[better], new_residuals[better], new_J[better]
        self.cost[good] = new_cost[better]
        self.reached[good] = self._is_reached(new_residuals[better])
        # What the open directions could gain is rounding: this is a minimum inside the limits.
        slope = np.einsum("nij,ni->nj", J_open, residuals)
        steepness = np.square(J).sum(axis=(-2, -1)) * 2.0 * cost
        flat = np.square(slope).sum(axis=-1) <= _FLAT**2 * steepness
        self.settled[at] = flat | (self._damping[at] >= _MOST_DAMPING)
        self.active = at[~(self.reached[at] | self.settled[at])]

    def _adapt(self, at: Rows, gain: Floats, better: NDArray[np.bool_]) -> None:
        damping, growth = self._damping[at], self._growth[at]
        less = damping * np.maximum(1.0 / 3.0, 1.0 - (2.0 * np.clip(gain, 0.0, 2.0) - 1.0) ** 3)
        self._damping[at] = np.clip(np.where(better, less, damping * growth), _LEAST_DAMPING, _MOST_DAMPING)
        self._growth[at] = np.where(better, 2.0, 2.0 * growth)


def _damped_steps(J: Floats, residuals: Floats, damping: Floats) -> Floats:
    """−(JᵀJ + λ 1)⁻¹ Jᵀ e = −Jᵀ (J Jᵀ + λ 1)⁻¹ e, by whichever system is smaller; shape (n, m)."""
    height, width = J.shape[-2:]
    size = min(height, width)
    Jt = J.swapaxes(-1, -2)
    normal = Jt @ J if width <= height else J @ Jt
    # A floor against rounding keeps the system regular where damping vanishes with the error.
    floor = 1e-15 * np.trace(normal, axis1=-2, axis2=-1) + np.finfo(np.float64).tiny
    normal[:, np.arange(size), np.arange(size)] += (damping + floor)[:, None]
    if width <= height:
        return np.asarray(-np.linalg.solve(normal, Jt @ residuals[:, :, None])[..., 0])
    return np.asarray(-(Jt @ np.linalg.solve(normal, residuals[:, :, None]))[..., 0])
