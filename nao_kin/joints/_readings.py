"""Where a typed configuration holds the values of which joints, and which of them share a motor."""

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
    """A coordinate of the typed model that is the value of one joint of the robot.

    Attributes:
        joint: the joint of the robot.
        column: place in the typed configuration.
        row: place of its rate in the typed velocity.
        derived: whether it only repeats the value of another joint of the typed model.
    """

    joint: JointNode
    column: int
    row: int
    derived: bool


@dataclass(frozen=True)
class Source:
    """A joint value read off a typed configuration: scale · typed[column] + shift."""

    column: int
    scale: float = 1.0
    shift: float = 0.0

    def of(self, typed: Floats) -> Floats:
        """The values at typed configurations, shape (..., nq) → (...)."""
        return np.asarray(self.scale * typed[..., self.column] + self.shift)

    def driver_of(self, mimic: Mimic) -> Source:
        """The driver's value, where this one is its follower's."""
        return Source(self.column, self.scale / mimic.multiplier, (self.shift - mimic.offset) / mimic.multiplier)

    def follower_of(self, mimic: Mimic) -> Source:
        """The follower's value, where this one is its driver's."""
        return Source(self.column, self.scale * mimic.multiplier, self.shift * mimic.multiplier + mimic.offset)


@dataclass(frozen=True, eq=False)
class Ball:
    """A spherical joint of the typed model.

    Attributes:
        name: its name.
        joints: the three joints of the robot it replaces.
        axes: their axes in the ball's frame with all joints at zero, one per row, shape (3, 3).
        column: where its quaternion (x, y, z, w) begins in the typed configuration.
        row: where its angular velocity begins in the typed velocity.
    """

    name: str
    joints: tuple[JointNode, JointNode, JointNode]
    axes: Floats
    column: int
    row: int

    def quaternions(self, typed: Floats) -> Floats:
        """The quaternions (x, y, z, w) of typed configurations, shape (..., nq) → (..., 4)."""
        return typed[..., self.column : self.column + 4]


@dataclass(frozen=True, eq=False)
class Mismatch:
    """How far a joint is from what the one it follows asks of it.

    Attributes:
        follower: the joint that follows.
        driver_value: value of the driver, shape (n,).
        follower_value: value of the follower, shape (n,).
        violated: where rounding does not explain the difference, shape (n,).
        nearest: value of the driver that together with all its followers is nearest to the values given, shape (n,).
    """

    follower: JointNode
    driver_value: Floats
    follower_value: Floats
    violated: NDArray[np.bool_]
    nearest: Floats


@dataclass(frozen=True)
class CouplingViolation:
    """Two joints of one motor that a typed configuration puts at values no motor position produces.

    Attributes:
        primary: the driving joint.
        mimic: the joint that follows it.
        primary_value: value of the driving joint.
        mimic_value: value of the joint that follows, by whole turns nearest to what is expected.
        expected: value the driving joint asks of it.
        nearest: value of the driving joint that, with what follows from it, is nearest to the values given.
        index: which configuration of the batch.

    Examples:
        >>> hips = "LHipYawPitch", "RHipYawPitch"
        >>> violation = nk.joints.CouplingViolation(*hips, -0.2, -0.3, expected=-0.2, nearest=-0.25)
        >>> violation.mimic, violation.nearest
        ('RHipYawPitch', -0.25)
    """

    primary: str
    mimic: str
    primary_value: float
    mimic_value: float
    expected: float
    nearest: float
    index: tuple[int, ...] = ()


def coupling_violations(mismatches: Sequence[Mismatch], batch: tuple[int, ...]) -> tuple[CouplingViolation, ...]:
    """The rows of what was found for the flattened batch, by configuration."""
    rows = []
    for mismatch in mismatches:
        follower = mismatch.follower
        for i in np.flatnonzero(mismatch.violated):
            value = mismatch.driver_value[i]
            rows.append(
                CouplingViolation(
                    primary=follower.driver,
                    mimic=follower.name,
                    primary_value=float(value),
                    mimic_value=float(mismatch.follower_value[i]),
                    expected=float(follower.coupling.value(value)),
                    nearest=float(mismatch.nearest[i]),
                    index=tuple(int(k) for k in np.unravel_index(int(i), batch)) if batch else (),
                )
            )
    return tuple(sorted(rows, key=lambda row: row.index))


# --- The balls of the model: their quaternions composed of three angles and taken apart, and the angles at a lock.

# Rounding of a quaternion and of the matrix made from it, as it shows in an angle far from lock.
_ROUNDING = 32.0 * float(np.finfo(np.float64).eps)


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
