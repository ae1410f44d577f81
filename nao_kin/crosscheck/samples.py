"""The samples of a cross-check: configurations in which conventions differ, and the rotations of their frames."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import eigenpy
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats
from nao_kin.robot import RobotModel

_SHARES = {
    "inside": 0.25,
    "limits": 0.15,
    "right angles": 0.2,
    "near right angles": 0.2,
    "half turns": 0.1,
    "beyond": 0.1,
}
_TRIES = 20
_GOLDEN = 0.5 * (5.0**0.5 - 1.0)
_QUARTERS = np.array([0.5, -0.5, 1.0, -1.0]) * np.pi


@dataclass(frozen=True, eq=False)
class Configurations:
    """Configurations (n, nq) in the order in which they are compared, and the kind of each."""

    q: Floats
    kinds: tuple[str, ...]

    @property
    def counts(self) -> dict[str, int]:
        """Number of configurations of each kind."""
        return {name: count for name in ("zero", *_SHARES) if (count := self.kinds.count(name))}


def sample_configurations(robot: RobotModel, samples: int, seed: int) -> Configurations:
    """Return `samples` configurations of all kinds; the first one is zero.

    zero: every joint at zero. inside: uniform inside the limits. limits: every joint on one of its limits. right
    angles: most joints at a multiple of π/2 up to π, some anywhere, for rotations by π and sequences at lock. near
    right angles: the same, with every joint moved by 1e-16 … 1e-2. half turns: all joints anywhere in a turn, except
    one that rotates some frame by π, or nearly π, about a general axis. beyond: uniform in [−2π, 2π].
    """
    rng = np.random.default_rng(seed)
    # Rounded so that the numbers add up, and none is zero by rounding.
    bounds = np.ceil(np.cumsum(list(_SHARES.values())) * (samples - 1) - 1e-9).astype(int)
    count = dict(zip(_SHARES, np.diff(bounds, prepend=0).tolist(), strict=True))
    n = len(robot.joint_names)
    lower = np.where(np.isfinite(robot.lower), robot.lower, -np.pi)
    upper = np.where(np.isfinite(robot.upper), robot.upper, np.pi)
    near = _right_angles(rng, count["near right angles"], n)
    parts = {
        "zero": np.zeros((1, n)),
        "inside": robot.random(rng, count["inside"]),
        "limits": np.where(rng.random((count["limits"], n)) < 0.5, lower, upper),
        "right angles": _right_angles(rng, count["right angles"], n),
        "near right angles": near + _nudges(rng, near.shape),
        "half turns": _half_turns(robot, rng, count["half turns"]),
        "beyond": rng.uniform(-2.0 * np.pi, 2.0 * np.pi, (count["beyond"], n)),
    }
    kinds = np.array([name for name, part in parts.items() for _ in part])
    order = np.concatenate([[0], 1 + rng.permutation(samples - 1)])
    return Configurations(np.concatenate(list(parts.values()))[order], tuple(kinds[order].tolist()))


def _right_angles(rng: np.random.Generator, count: int, joints: int) -> Floats:
    """Return configurations with half of the joints at zero, three in ten at ±π/2 or ±π, the others anywhere."""
    kind = rng.random((count, joints))
    anywhere = rng.uniform(-np.pi, np.pi, kind.shape)
    return np.where(kind < 0.5, 0.0, np.where(kind < 0.8, rng.choice(_QUARTERS, kind.shape), anywhere))


def _half_turns(robot: RobotModel, rng: np.random.Generator, count: int) -> Floats:
    """Return configurations with one joint at the angle θ that rotates a frame by π, every second one perturbed.

    tr R(θ) = a + b cos θ + c sin θ has the minimum −1 at the half turn: θ = π + atan2(c, b).
    """
    configurations = rng.uniform(-np.pi, np.pi, (count, len(robot.joint_names)))
    joints, frames = _turned_frames(robot)
    waiting = np.arange(count if len(joints) else 0)
    for _ in range(_TRIES):
        pair = rng.integers(len(joints), size=len(waiting)) if len(waiting) else waiting
        nudge = np.where(waiting % 2 == 1, _nudges(rng, waiting.shape), 0.0)
        joint, frame = joints[pair], frames[pair]
        thirds = np.repeat(configurations[waiting, None], 3, axis=1)
        thirds[np.arange(len(waiting)), :, joint] = np.array([0.0, 2.0, 4.0]) * np.pi / 3.0
        traces = np.empty((len(waiting), 3))
        for index in np.unique(frame):
            R = robot.rotation(thirds[frame == index], robot.frame_names[index])
            traces[frame == index] = np.trace(R, axis1=-2, axis2=-1)
        b, c = traces @ [2 / 3, -1 / 3, -1 / 3], traces @ [0.0, 3**-0.5, -(3**-0.5)]
        found = b * b + c * c > 0.01
        configurations[waiting[found], joint[found]] = (np.pi + np.arctan2(c, b) + nudge)[found]
        waiting = waiting[~found]
    return configurations


def _turned_frames(robot: RobotModel) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return all pairs of a joint, as index in `joint_names`, and a frame that it turns, as index in `frame_names`."""
    zero = robot.neutral()
    R_zero = robot.rotation(zero, robot.frame_names)
    # One joint at a time, to limit memory for robots with hundreds of joints.
    turned = [
        np.abs(robot.rotation(q, robot.frame_names) - R_zero).max(axis=(1, 2)) > 1e-6 for q in zero + np.eye(len(zero))
    ]
    pairs = np.argwhere(np.reshape(turned, (len(turned), len(robot.frame_names))))
    return pairs[:, 0], pairs[:, 1]


def _nudges(rng: np.random.Generator, shape: tuple[int, ...]) -> Floats:
    """Return ±1e-16 … ±1e-2, every power of ten equally likely."""
    return np.asarray(rng.choice([-1.0, 1.0], shape) * 10.0 ** rng.uniform(-16.0, -2.0, shape))


class RotationSample:
    """Rotation matrices R (n, 3, 3), and their parameters by Pinocchio and eigenpy, computed once for all checks."""

    def __init__(self, R: Floats) -> None:
        self.R = R
        self.moving_angles = functools.cache(self._moving_angles)
        self.moving_matrices = functools.cache(self._moving_matrices)

    @functools.cached_property
    def spread(self) -> Floats:
        """Numbers in [0, 1), shape (n,), evenly spread over the rotations of every frame and configuration."""
        return np.asarray(np.arange(len(self.R)) * _GOLDEN % 1.0)

    @functools.cached_property
    def quaternions(self) -> Floats:
        """(w, x, y, z) of pin.Quaternion, shape (n, 4)."""
        return each(lambda R: pin.Quaternion(R).coeffs(), (4,), self.R)[:, [3, 0, 1, 2]]

    @functools.cached_property
    def natural(self) -> tuple[Floats, Floats]:
        """Axes (n, 3) and angles (n,) of pin.AngleAxis."""
        rows = each(_natural, (4,), self.R)
        return rows[:, :3], rows[:, 3]

    @functools.cached_property
    def logarithms(self) -> Floats:
        """pin.log3, shape (n, 3)."""
        return each(pin.log3, (3,), self.R)

    @functools.cached_property
    def rpy(self) -> Floats:
        """pin.rpy.matrixToRpy, shape (n, 3)."""
        return each(pin.rpy.matrixToRpy, (3,), self.R)

    def _moving_angles(self, sequence: str) -> Floats:
        """eigenpy.toEulerAngles about moving axes, shape (n, 3); one of the two solutions."""
        numbers = axis_numbers(sequence)
        return each(lambda R: eigenpy.toEulerAngles(R, *numbers), (3,), self.R)

    def _moving_matrices(self, sequence: str) -> Floats:
        """eigenpy.fromEulerAngles of `moving_angles`, shape (n, 3, 3)."""
        return matrices_from_moving(self.moving_angles(sequence), sequence)


def each(function: Callable[..., Any], tail: tuple[int, ...], *arrays: Floats) -> Floats:
    """Return the results of a function for every row of the arrays, in one array (n, *tail)."""
    if len(arrays[0]) == 0:
        return np.empty((0, *tail))
    # One concatenation is twice as fast as filling an array row by row.
    return np.concatenate([function(*row) for row in zip(*arrays, strict=True)]).reshape(-1, *tail)


def axis_numbers(sequence: str) -> tuple[int, ...]:
    """Return 0 for x, 1 for y, 2 for z."""
    return tuple("xyz".index(axis) for axis in sequence)


def matrices_from_moving(angles: Floats, sequence: str) -> Floats:
    """Return eigenpy.fromEulerAngles about moving axes, shape (n, 3, 3)."""
    numbers = axis_numbers(sequence)
    return each(lambda row: eigenpy.fromEulerAngles(row, *numbers), (3, 3), angles)


def matrices_from_quaternions(wxyz: Floats) -> Floats:
    """Return matrices of pin.Quaternion, shape (n, 3, 3)."""
    return each(lambda q: pin.Quaternion(*q).matrix(), (3, 3), wxyz)


def matrices_from_natural(axes: Floats, angles: Floats) -> Floats:
    """Return matrices of pin.AngleAxis, shape (n, 3, 3)."""
    return each(lambda axis, angle: pin.AngleAxis(angle, axis).toRotationMatrix(), (3, 3), axes, angles)


def turns_about(axis: tuple[float, float, float], angles: Floats) -> Floats:
    """Return turns about one axis by pin.AngleAxis, shape (n, 3, 3)."""
    return matrices_from_natural(np.tile(axis, (len(angles), 1)), angles)


def _natural(R: Floats) -> Floats:
    both = pin.AngleAxis(R)
    return np.append(both.axis, both.angle)
