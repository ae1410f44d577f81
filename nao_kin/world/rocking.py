"""How far a moving robot rocks over the edges of its soles: whether it only rocks, or falls.

A zero-moment point outside the support polygon does not tip a robot at once: the robot begins to turn about an edge, as
a rigid inverted pendulum, and the motion of the joints goes on. In each of eight directions about the robot, the tilt θ
about the edge that is farthest in this direction follows from the moment of the ground about it,

    m (h² + d²) θ″ = −M(t) + F_z h θ,   θ ≥ 0,

with the centre of mass at the height h and at the distance d from the edge, and M = F_z (distance of the zero-moment
point from the edge), which is negative where this point is outside. A foot that hovers over the floor lands where the
tilt reaches it, and the support reaches to it from then on. After the last row, the robot stays as it is.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats
from nao_kin.world.legs import GRAVITY

# Directions, counter-clockwise from ahead.
_TURNS = 0.25 * np.pi * np.arange(8)
DIRECTIONS = np.column_stack([np.cos(_TURNS), np.sin(_TURNS)])
# The equation is integrated in steps of at most this time, and after the last row for this time [s].
_STEP, _AFTER = 0.01, 1.5
# A robot that has turned by more lies soon, and is not followed any farther [rad].
_FARTHEST = 0.5
# Corners that reach beyond the others by less are as far [m].
_BEYOND = 1e-3


class Edges(NamedTuple):
    """The edges of the support in eight directions in n rows, all of shape (n, 8).

    Attributes:
        moment: moment of the ground about the edge, negative where it tips the robot [N m].
        arm: distance of the centre of mass from the edge, seen from above, negative outside [m].
        farther: how much farther the support reaches when a hovering foot has landed [m].
        landing: tilt at which it does [rad].
    """

    moment: Floats
    arm: Floats
    farther: Floats
    landing: Floats

    @staticmethod
    def of(corners: Floats, touching: NDArray[np.bool_], com: Floats, weight: Floats, lever: Floats) -> Edges:
        """Return the edges for the corners (n, c, 3) of all soles in axes of the robot, z from the floor.

        `touching` says which of them carry, shape (n, c). Further arguments are the centre of mass (n, 2), the vertical
        force of the ground (n,), and its moments (n, 2) beside that force at the centre of mass.
        """
        along = corners[..., :2] @ DIRECTIONS.T
        edge = np.where(touching[..., None], along, -np.inf).max(axis=1, initial=-np.inf)
        first = along.argmax(axis=1)[:, None]
        farther = np.take_along_axis(along, first, axis=1)[:, 0] - edge
        height = np.take_along_axis(np.broadcast_to(corners[..., 2:], along.shape), first, axis=1)[:, 0]
        with np.errstate(invalid="ignore"):
            landing = np.where(farther > _BEYOND, np.maximum(height, 0.0) / np.maximum(farther, _BEYOND), np.inf)
        arm = edge - com @ DIRECTIONS.T
        return Edges(weight[:, None] * arm + lever @ DIRECTIONS.T, arm, farther, landing)


def rocking(times: Floats, edges: Edges, weight: Floats, height: Floats, mass: float) -> Floats:
    """Return the largest tilt about an edge in each of n rows, shape (n,) [rad]; 0 on flat soles.

    The tilt after the last row counts as that of the last row. Rows in which the robot does not stand have NaN in
    `weight`: their tilt is NaN, and begins anew after them.

    Args:
        times: of the rows, without gaps [s].
        edges: of the support.
        weight: vertical force of the ground, shape (n,) [N].
        height: of the centre of mass, shape (n,) [m].
        mass: of the robot [kg].
    """
    found = np.where(np.isnan(weight), np.nan, 0.0)
    with np.errstate(invalid="ignore"):
        tipping = np.asarray((edges.moment < 0.0).any(axis=1), dtype=np.bool_)
    inertia = mass * (height[:, None] ** 2 + edges.arm**2)
    tilt, speed = np.zeros((2, len(DIRECTIONS)))

    def follow(row: int, seconds: float, moment: Floats, force: float) -> float:
        """Go on for some time with the moment and the force of the ground, and return the largest tilt."""
        nonlocal tilt, speed
        steps, most = max(1, round(seconds / _STEP)), 0.0
        step = seconds / steps
        for _ in range(steps):
            support = moment + force * np.where(tilt >= edges.landing[row], edges.farther[row], 0.0)
            speed = speed + step * (force * height[row] * tilt - support) / inertia[row]
            tilt = np.minimum(tilt + step * speed, _FARTHEST)
            flat = tilt <= 0.0
            tilt[flat] = speed[flat] = 0.0
            most = max(most, float(tilt.max()))
        return most

    for row in range(1, len(times)):
        if np.isnan(weight[row]):
            tilt, speed = np.zeros((2, len(DIRECTIONS)))
        elif tipping[row] or tilt.any():
            seconds = float(times[row] - times[row - 1])
            found[row] = follow(row, seconds, edges.moment[row], float(weight[row]))
    if tilt.any():
        force = mass * GRAVITY
        found[-1] = max(found[-1], follow(len(times) - 1, _AFTER, force * edges.arm[-1], force))
    return found
