"""The values of the robot's joints in a typed configuration, and the joints that share a motor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats
from nao_kin.joints.grouping import JointNode, wrapped
from nao_kin.robot.semantics import Mimic
from nao_kin.rotations import (
    EulerAngles,
    davenport_angles,
    matrix_from_quat,
    quat_from_xyzw,
    quat_multiply,
    quat_to_xyzw,
)


@dataclass(frozen=True)
class Slot:
    """A coordinate of the typed model that is the value of one joint of the robot."""

    joint: JointNode
    column: int  # index in the typed configuration
    row: int  # index of its rate in the typed velocity
    derived: bool  # whether it only repeats the value of another joint of the typed model


@dataclass(frozen=True)
class Reading:
    """A joint value as a linear function of one coordinate: scale · typed[column] + shift."""

    column: int
    scale: float = 1.0
    shift: float = 0.0

    def of(self, typed: Floats) -> Floats:
        """Return the values at typed configurations, shape (..., nq) → (...)."""
        return np.asarray(self.scale * typed[..., self.column] + self.shift)

    def driver_of(self, mimic: Mimic) -> Reading:
        """Return the value of the driver whose follower has this value."""
        return Reading(self.column, self.scale / mimic.multiplier, (self.shift - mimic.offset) / mimic.multiplier)

    def follower_of(self, mimic: Mimic) -> Reading:
        """Return the value of the follower whose driver has this value."""
        return Reading(self.column, self.scale * mimic.multiplier, self.shift * mimic.multiplier + mimic.offset)


@dataclass(frozen=True, eq=False)
class Ball:
    """A spherical joint of the typed model."""

    name: str
    joints: tuple[JointNode, JointNode, JointNode]  # the joints that it replaces
    axes: Floats  # in its frame with all joints at zero, one per row, shape (3, 3)
    column: int  # where its quaternion (x, y, z, w) begins in the typed configuration
    row: int  # where its angular velocity begins in the typed velocity

    def quaternions(self, typed: Floats) -> Floats:
        """Return the quaternions (x, y, z, w) of typed configurations, shape (..., nq) → (..., 4)."""
        return typed[..., self.column : self.column + 4]

    def angles(self, q: Floats) -> Floats:
        """Return the three angles at configurations of the robot, shape (..., robot.nq) → (..., 3)."""
        return np.stack([joint.of(q) for joint in self.joints], axis=-1)


@dataclass(frozen=True, eq=False)
class Mismatch:
    """The difference between a follower and the value that its driver requires, at n configurations."""

    follower: JointNode
    driver_value: Floats  # shape (n,), as the other arrays
    follower_value: Floats
    violated: NDArray[np.bool_]  # where rounding does not explain the difference
    nearest: Floats  # the driver's value that is nearest to the given values of the driver and all its followers


@dataclass(frozen=True)
class CouplingViolation:
    """A typed configuration in which two joints of one motor have values that no motor position produces.

    Attributes:
        primary: the driving joint.
        mimic: the joint that follows it.
        primary_value: value of the driving joint.
        mimic_value: value of the follower, moved by whole turns to be nearest to the expected value.
        expected: value of the follower that the driving joint requires.
        nearest: value of the driving joint that is nearest to the given values of this joint and all its followers.
        index: index of the configuration in the batch.
    """

    primary: str
    mimic: str
    primary_value: float
    mimic_value: float
    expected: float
    nearest: float
    index: tuple[int, ...] = ()


def coupling_violations(mismatches: Sequence[Mismatch], batch: tuple[int, ...]) -> tuple[CouplingViolation, ...]:
    """Return the violations of a flattened batch, in the order of its configurations."""
    rows = [
        CouplingViolation(
            primary=mismatch.follower.coupling.joint,
            mimic=mismatch.follower.name,
            primary_value=float(mismatch.driver_value[i]),
            mimic_value=float(mismatch.follower_value[i]),
            expected=float(mismatch.follower.coupling.value(mismatch.driver_value[i])),
            nearest=float(mismatch.nearest[i]),
            index=tuple(map(int, np.unravel_index(i, batch))) if batch else (),
        )
        for mismatch in mismatches
        for i in np.flatnonzero(mismatch.violated)
    ]
    return tuple(sorted(rows, key=lambda row: row.index))


# --- Spherical joints: quaternions from three angles, angles from quaternions, and the choice of angles at lock.

# Error of an angle far from lock that results from rounding the quaternion and the matrix made from it [rad].
_ROUNDING = 32.0 * float(np.finfo(np.float64).eps)


def quaternion_of_turns(ball: Ball, angles: Floats) -> Floats:
    """Return the quaternion (x, y, z, w) of three turns, continuous in the angles; (..., 3) → (..., 4)."""
    half = 0.5 * angles[..., None]
    turns = np.concatenate([np.cos(half), np.sin(half) * ball.axes], axis=-1)
    return quat_to_xyzw(quat_multiply(quat_multiply(turns[..., 0, :], turns[..., 1, :]), turns[..., 2, :]))


def turns_of_quaternion(ball: Ball, xyzw: Floats) -> EulerAngles:
    """Return both triples of angles of unit quaternions (x, y, z, w), shape (..., 4)."""
    return davenport_angles(matrix_from_quat(quat_from_xyzw(xyzw)), *ball.axes)


def angular_velocity_axes(ball: Ball, angles: Floats) -> Floats:
    """Return the matrix (..., 3, 3) from three joint rates to the angular velocity in the moved frame.

    Its columns are Rot(a3, −γ) Rot(a2, −β) a1, Rot(a3, −γ) a2 and a3.
    """
    first, second, third = (np.broadcast_to(axis, (*angles.shape[:-1], 3)) for axis in ball.axes)
    first = _turned(_turned(first, ball.axes[1], -angles[..., 1]), ball.axes[2], -angles[..., 2])
    second = _turned(second, ball.axes[2], -angles[..., 2])
    return np.stack([first, second, third], axis=-1)


def outer_axes_angle(ball: Ball, middle: Floats) -> tuple[Floats, Floats]:
    """Return cosine and sine of the angle between the outer axes at these values of the middle angle."""
    first, second, third = ball.axes
    theta = middle + math.atan2(float(second @ np.cross(first, third)), float(first @ third))
    return np.cos(theta), np.sin(theta)


def outer_uncertainty(ball: Ball, middle: Floats, locked: NDArray[np.bool_]) -> Floats:
    """Return how far rounding may move the outer angles [rad]; at lock only their sum or difference is determined."""
    _, sine = outer_axes_angle(ball, middle)
    with np.errstate(divide="ignore"):
        return np.where(locked, math.pi, np.minimum(_ROUNDING / np.abs(sine), math.pi))


def nearest_turn(angles: Floats, target: Floats) -> Floats:
    """Return the angles, moved by whole turns to within half a turn of the target."""
    return np.asarray(target + wrapped(angles - target))


def move_angle(ball: Ball, angles: Floats, place: int, by: Floats) -> Floats:
    """Return the triples (3, n) with one angle moved; if it is an outer angle, the other one moves to compensate.

    Close to lock the two outer axes nearly coincide, and a turn about one nearly cancels a turn about the other.
    """
    result = np.array(angles)
    result[place] += by
    if place != 1:
        result[2 - place] -= by * outer_axes_angle(ball, angles[1])[0]
    return result


def nearest_at_lock(ball: Ball, angles: Floats, target: Floats) -> Floats:
    """Return the triples (3, n) nearest to the target among all triples that give the same rotations at lock."""
    sign = np.sign(outer_axes_angle(ball, angles[1])[0])
    spare = wrapped(angles[0] + sign * angles[2] - target[0] - sign * target[2]) / 2.0
    return np.stack([target[0] + spare, angles[1], target[2] + sign * spare])


def inside_at_lock(ball: Ball, angles: Floats, lower: Floats, upper: Floats) -> Floats:
    """Return triples (3, n) at lock, moved into the limits of the outer angles or as near to them as possible."""
    sign = np.sign(outer_axes_angle(ball, angles[1])[0])
    # The values of the first angle for the third at either end of its range; their sum or difference does not change.
    ends = np.sort([angles[0] + sign * (angles[2] - end) for end in (lower[2], upper[2])], axis=0)
    low, high = np.maximum(lower[0], ends[0]), np.minimum(upper[0], ends[1])
    with np.errstate(invalid="ignore"):  # without limits, ∞ − ∞ is computed but not used
        first = np.where(low <= high, np.clip(angles[0], low, high), 0.5 * (low + high))
    return move_angle(ball, angles, 0, first - angles[0])


def _turned(vectors: Floats, axis: Floats, angle: Floats) -> Floats:
    """Return Rot(axis, angle) v by Rodrigues' formula."""
    cosine, sine = np.cos(angle)[..., None], np.sin(angle)[..., None]
    along = np.einsum("...i,i->...", vectors, axis)[..., None]
    return np.asarray(cosine * vectors + sine * np.cross(axis, vectors) + (1.0 - cosine) * along * axis)
