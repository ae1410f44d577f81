"""The balls of the model: their quaternions composed of three angles and taken apart, and the angles at a lock."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._common.arrays import Floats, as_floats
from nao_kin.errors import BadArgument, at_index
from nao_kin.multidof._readings import Ball, wrapped
from nao_kin.robot import UNIT_TOLERANCE
from nao_kin.rotations import (
    EulerAngles,
    davenport_angles,
    matrix_from_quat,
    quat_from_xyzw,
    quat_multiply,
    quat_to_xyzw,
)

# Rounding of a quaternion and of the matrix made from it, as it shows in an angle far from lock.
_ROUNDING = 32.0 * float(np.finfo(np.float64).eps)


class Quaternions:
    """Where the quaternions (x, y, z, w) of a typed configuration stand."""

    def __init__(self, nq: int, starts: Mapping[str, int]) -> None:
        """Args: number of coordinates, and name of the joint (or "base") → column where its quaternion begins."""
        self._nq, self._names = nq, tuple(starts)
        self._columns = np.array(list(starts.values()), dtype=np.intp)[:, None] + np.arange(4)

    def checked(self, q_typed: ArrayLike) -> Floats:
        """`q_typed` with quaternions of norm 1 to rounding; a copy wherever there are any.

        Raises:
            BadArgument: a quaternion whose norm is not 1 to 1e-6, with its joint and its place in the batch.
            WrongShape, NotFinite: no typed configuration.
        """
        typed = as_floats(q_typed, (self._nq,), "q_typed")
        if not self._names:
            return typed
        parts = typed[..., self._columns]
        with np.errstate(over="ignore"):
            norms = np.sqrt(np.sum(parts * parts, axis=-1))
        wrong = ~(np.abs(norms - 1.0) <= UNIT_TOLERANCE)
        if wrong.any():
            place = tuple(int(i) for i in np.argwhere(wrong)[0])
            name, norm = self._names[place[-1]], f"{norms[place]:.8g}{at_index(place[:-1])}"
            raise BadArgument(f"{name} must be a unit quaternion (x, y, z, w), got one of norm {norm}")
        unit = np.array(typed)
        # What is left of the norm would end up in the rotation matrices, squared.
        unit[..., self._columns] = parts / norms[..., None]
        return unit


def quaternion_of_turns(ball: Ball, angles: Floats) -> Floats:
    """The quaternion (x, y, z, w) of three turns, continuous in the angles; shape (..., 3) → (..., 4)."""
    half = 0.5 * angles[..., None]
    turns = np.concatenate([np.cos(half), np.sin(half) * ball.axes], axis=-1)
    return quat_to_xyzw(quat_multiply(quat_multiply(turns[..., 0, :], turns[..., 1, :]), turns[..., 2, :]))


def turns_of_quaternion(ball: Ball, xyzw: Floats) -> EulerAngles:
    """Both triples of angles of unit quaternions (x, y, z, w), shape (..., 4)."""
    return davenport_angles(matrix_from_quat(quat_from_xyzw(xyzw)), *ball.axes)


def angular_velocity_axes(ball: Ball, angles: Floats) -> Floats:
    """The matrix from the three joint rates to the ball's angular velocity in its moved frame, (..., 3) → (..., 3, 3).

    Its columns are Rot(a3, −γ) Rot(a2, −β) a1, Rot(a3, −γ) a2 and a3.
    """
    first, second, third = (np.broadcast_to(axis, (*angles.shape[:-1], 3)) for axis in ball.axes)
    first = _turned(_turned(first, ball.axes[1], -angles[..., 1]), ball.axes[2], -angles[..., 2])
    second = _turned(second, ball.axes[2], -angles[..., 2])
    return np.stack([first, second, third], axis=-1)


def opening(ball: Ball, middle: Floats) -> tuple[Floats, Floats]:
    """Cosine and sine of the angle between the outer axes when the middle angle has these values."""
    first, second, third = ball.axes
    theta = middle + math.atan2(float(second @ np.cross(first, third)), float(first @ third))
    return np.cos(theta), np.sin(theta)


def uncertainty(ball: Ball, middle: Floats, locked: NDArray[np.bool_]) -> Floats:
    """How far rounding may move the outer angles, which only their sum is sure of at lock [rad]."""
    _, sine = opening(ball, middle)
    with np.errstate(divide="ignore"):
        return np.where(locked, math.pi, np.minimum(_ROUNDING / np.abs(sine), math.pi))


def near(angles: Floats, target: Floats) -> Floats:
    """The same angles, by whole turns within half a turn of the target."""
    return np.asarray(target + wrapped(angles - target))


def moved(ball: Ball, angles: Floats, place: int, by: Floats) -> Floats:
    """One angle moved, and the opposite outer angle so that the rotation changes least; shape (3, n).

    Close to lock the two outer axes nearly coincide, and what one turn gains the other gives back.
    """
    result = np.array(angles)
    result[place] += by
    if place != 1:
        result[2 - place] -= by * opening(ball, angles[1])[0]
    return result


def nearest_at_lock(ball: Ball, angles: Floats, target: Floats) -> Floats:
    """Of all triples that give the same rotation at lock, the one nearest to the target; shape (3, n)."""
    sign = np.sign(opening(ball, angles[1])[0])
    spare = wrapped(angles[0] + sign * angles[2] - target[0] - sign * target[2]) / 2.0
    return np.stack([target[0] + spare, angles[1], target[2] + sign * spare])


def inside_at_lock(ball: Ball, angles: Floats, lower: Floats, upper: Floats) -> Floats:
    """At lock, the triple moved into the limits of both outer angles, or least outside of them; shape (3, n)."""
    sign = np.sign(opening(ball, angles[1])[0])
    # The first angle with the third at either end of its range: their sum, or difference, stays.
    ends = np.sort([angles[0] + sign * (angles[2] - end) for end in (lower[2], upper[2])], axis=0)
    least, most = np.maximum(lower[0], ends[0]), np.minimum(upper[0], ends[1])
    with np.errstate(invalid="ignore"):  # where there are no limits, ∞ − ∞ is computed and not taken
        first = np.where(least <= most, np.clip(angles[0], least, most), 0.5 * (least + most))
    return moved(ball, angles, 0, first - angles[0])


def _turned(vectors: Floats, axis: Floats, angle: Floats) -> Floats:
    """Rot(axis, angle) v by Rodrigues' formula."""
    cosine, sine = np.cos(angle)[..., None], np.sin(angle)[..., None]
    along = np.einsum("...i,i->...", vectors, axis)[..., None]
    return np.asarray(cosine * vectors + sine * np.cross(axis, vectors) + (1.0 - cosine) * along * axis)
