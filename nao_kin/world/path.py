"""The trajectory of a root link over soles that stand in place, and its covariance.

The formulas take columns: arrays of n rows, or numbers for one row, for which they are ten times as fast.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, rigid_inverse, shaped
from nao_kin.screws import rigid_poses
from nao_kin.world.balance import feet_frame
from nao_kin.world.rest import Mask, Turns

# A number for one row, or an array of numbers for n rows.
Column = Any

# The covariance grows with each step by these deviations [m, rad], without a gyrometer also by that of the heading, and
# with the distance by a common error of scale, as slip makes it. With a gyrometer the heading diffuses [rad/√s].
# Source: simulated walks with encoder noise of 0.1 to 0.3° and slip (docs/balance.md).
_STEP, _STEP_TURN, _SCALE, _GYRO_DRIFT = 0.003, np.radians(0.5), 0.035, np.radians(0.3)
# Soles that carry slide and turn while the robot moves [m/√s, rad/√s]; the error of a gyrometer's scale; differences
# between two rows by noise and backlash of the joints [m, rad]. Source: robots simulated in MuJoCo, friction of 0.8.
_SLIDE, _SLIDE_TURN, _GYRO_SCALE, _NOISE, _NOISE_TURN = 0.004, np.radians(1.9), 0.01, 0.0015, np.radians(0.15)


def columns(values: NDArray[Any]) -> list[Column]:
    """Return the columns of values (n, k), as numbers if n is 1."""
    return list(values[0].tolist() if len(values) == 1 else values.T)


def column(values: NDArray[Any]) -> Column:
    """Return values (n,), as a number if n is 1."""
    return float(values[0]) if len(values) == 1 else values


def poses(entries: Sequence[Column]) -> Floats:
    """Return the poses (n, 4, 4) of the twelve columns of their first three rows."""
    upper = np.array(entries).T.reshape(-1, 3, 4)
    T = np.zeros((len(upper), 4, 4))
    T[:, :3], T[:, 3, 3] = upper, 1.0
    return T


def cosine_sine(angle: Column) -> tuple[Column, Column]:
    """Return cosine and sine of an angle."""
    return (math.cos(angle), math.sin(angle)) if isinstance(angle, float) else (np.cos(angle), np.sin(angle))


class Path:
    """The trajectory of the root link, in segments, from rows in the order of their times."""

    def __init__(self, start: ArrayLike | None = None) -> None:
        self._start = None if start is None else rigid_poses(shaped(start, (4, 4), "start"), "start")
        self._T_world_feet, self.segment = np.eye(4), -1
        self._T_base_soles = np.empty((0, 4, 4))
        self._place, self._sole, self._sums = (0.0, 0.0, 0.0), -1, [0.0] * 10

    def begin(self, T_base_soles: Floats, support: int) -> None:
        """Begin a segment with the soles (s, 4, 4) of its first row: where the one before it ended."""
        if len(self._T_base_soles):
            (T,) = poses(_root(*self._place, self._T_base_soles[self._sole].ravel().tolist())[0])
            self._T_world_feet = feet_frame(T @ self._T_base_soles)
            self._T_world_feet[2, 3] = 0.0
        first = T_base_soles[support]
        if self._start is None:
            frame = feet_frame(rigid_inverse(first) @ T_base_soles)
            frame[2, 3] = 0.0
            T = self._T_world_feet @ rigid_inverse(frame)
        else:
            T, self._start = self._start @ first, None
        # The support stands at x, y with its heading; the rows before this one have moments, rates and soles.
        self._place, self._sole = (float(np.arctan2(T[1, 0], T[0, 0])), float(T[0, 3]), float(T[1, 3])), support
        self._first: Floats | None = None
        self._T_base_soles, self._sums = T_base_soles, [0.0] * 10
        self.segment += 1
        self.mark()

    def mark(self) -> None:
        """Keep the place of the support and the covariance, for `settle`."""
        if self.segment >= 0:
            self._marked = self.segment, self._sole, self._place, self._sums

    def settle(self) -> None:
        """Go back to the place of the support that was marked: the robot was at rest since then."""
        if self.segment >= 0 and (self.segment, self._sole) == self._marked[:2]:
            self._place, self._sums = self._marked[2:]

    def extend(
        self, T_base_soles: Floats, support: NDArray[np.intp], moments: Floats, rest: Mask, turns: Turns | None
    ) -> tuple[Floats, Floats, Floats, Floats]:
        """Go on by n rows; return the poses of the root link and of the support, x, y and heading, and covariance.

        Shapes (n, 4, 4), (n, 4, 4), (n, 3) and (n, 3, 3).
        """
        count = len(moments)
        T_world_base, T_world_support, pose = np.empty((count, 4, 4)), np.zeros((count, 4, 4)), np.empty((count, 3))
        if self._first is None:
            self._moment, self._rates = float(moments[0]), [0.0] * 3 if turns is None else turns.rates[0].tolist()
        steps = moments - np.append(self._moment, moments[:-1])
        stepped = support != np.append(self._sole, support[:-1])
        moving = steps * ~rest
        edges = [0, *(np.flatnonzero(stepped[1:]) + 1).tolist(), count] if count > 1 else [0, 1]
        for begin, end in itertools.pairwise(edges):
            rows, sole = slice(begin, end), int(support[begin])
            if sole != self._sole:
                self._step_to(sole)
            (heading, x, y), soles = self._place, columns(T_base_soles[rows, sole].reshape(-1, 16))
            if turns is not None:
                rates, before = columns(turns.rates[rows]), self._T_base_soles[sole].ravel().tolist()
                slip = _slip(
                    _shifted(before, soles), soles, _shifted(self._rates, rates), rates, *columns(steps[rows, None])
                )
                heading = _summed(heading, slip * column(~rest[rows]))
                self._rates, self._place = turns.rates[end - 1].tolist(), (float(np.ravel(heading)[-1]), x, y)
            T_world_base[rows], pose[rows] = poses((root := _root(heading, x, y, soles))[0]), np.array(root[1]).T
            (c, s), T = cosine_sine(heading), T_world_support[rows]
            T[:, 0, 0], T[:, 0, 1], T[:, 0, 3], T[:, 1, 0], T[:, 1, 1], T[:, 1, 3] = c, -s, x, s, c, y
            T[:, 2, 2] = T[:, 3, 3] = 1.0
            self._T_base_soles = T_base_soles[end - 1]
        if self._first is None:
            self._first, self._begun = pose[0].copy(), float(moments[0])
        deviation = None if turns is None else column(turns.deviation)
        away, moved, step = columns(pose - self._first), column(moving), column(stepped)
        later = column(moments > self._begun)
        covariance, self._sums = _covariance(away, later, moved, step, deviation, self._sums)
        self._moment = float(moments[-1])
        return T_world_base, T_world_support, pose, covariance

    def _step_to(self, sole: int) -> None:
        """Put another sole flat on the floor where it is in the row before: where both legs agree best."""
        before, other = (self._T_base_soles[k].ravel().tolist() for k in (self._sole, sole))
        r, _ = _root(*self._place, before)
        ahead, left = (sum(r[4 * k + i] * other[4 * i] for i in range(3)) for k in range(2))
        x, y = (r[4 * k + 3] + sum(r[4 * k + i] * other[4 * i + 3] for i in range(3)) for k in range(2))
        turned = math.remainder(math.atan2(left, ahead) - self._place[0], 2.0 * math.pi)
        self._place, self._sole = (self._place[0] + turned, x, y), sole


def _shifted(before: Sequence[float], values: Sequence[Column]) -> list[Column]:
    """Return the columns of the rows before each row."""
    pairs = zip(before, values, strict=True)
    return [first if isinstance(column, float) else np.append(first, column[:-1]) for first, column in pairs]


def _summed(before: float, values: Column) -> Column:
    """Return the sums up to each row."""
    return before + (values if isinstance(values, float) else np.cumsum(values))


def _root(heading: Column, x: Column, y: Column, sole: Sequence[Column]) -> tuple[list[Column], list[Column]]:
    """Return the pose of the root link over a sole at x, y with a heading, and its own x, y and heading.

    `sole` is the pose of the sole in the root link. Poses are the entries of their first three rows.
    """
    r00, r01, r02, a, r10, r11, r12, b, r20, r21, r22, d, *_ = sole
    c, s = cosine_sine(heading)
    # The root link in the sole has Rᵀ and −Rᵀ p.
    u, v, w = -(r00 * a + r10 * b + r20 * d), -(r01 * a + r11 * b + r21 * d), -(r02 * a + r12 * b + r22 * d)
    place = x + c * u - s * v, y + s * u + c * v
    first = [c * r00 - s * r01, c * r10 - s * r11, c * r20 - s * r21, place[0]]
    second = [s * r00 + c * r01, s * r10 + c * r11, s * r20 + c * r21, place[1]]
    return [*first, *second, r02, r12, r22, w], [*place, heading + np.arctan2(r01, r00)]


def _slip(
    before: Sequence[Column],
    sole: Sequence[Column],
    rates_before: Sequence[Column],
    rates: Sequence[Column],
    step: Column,
) -> Column:
    """Return how much farther the gyrometer turned about the vertical than the leg did, since the row before [rad]."""
    a00, a01, a02, _, a10, a11, a12, _, a20, a21, a22, *_ = before
    b00, b01, b02, _, b10, b11, b12, _, b20, b21, b22, *_ = sole
    # The root link turns over the sole by R = Bᵀ A; z of log R is (r₁₀ − r₀₁)/2 · φ / sin φ, cos φ = (tr R − 1)/2.
    trace = b00 * a00 + b10 * a10 + b20 * a20 + b01 * a01 + b11 * a11 + b21 * a21 + b02 * a02 + b12 * a12 + b22 * a22
    turn = 0.5 * (b01 * a00 + b11 * a10 + b21 * a20 - b00 * a01 - b10 * a11 - b20 * a21)
    angle = np.arccos(np.minimum(0.5 * (trace - 1.0), 1.0))
    (p, q, r), (k, m, n) = rates_before, rates
    measured = 0.5 * (a02 * p + a12 * q + a22 * r + b02 * k + b12 * m + b22 * n)
    return measured * step - turn / np.sinc(angle / np.pi)


def _covariance(
    pose: Sequence[Column],
    later: Column,
    moving: Column,
    stepped: Column,
    deviation: Column | None,
    before: Sequence[float],
) -> tuple[Floats, list[float]]:
    """Return the covariance of poses x, y, heading relative to the first row of the segment, (n, 3, 3), and its sums.

    `later` is 0 in that row and otherwise 1; `moving` is the time from the row before in which the robot was not at
    rest [s], `deviation` that of the gyrometer's bias, None without one, and `before` are the ten sums before these
    rows. An error of the heading at row i moves row n by (−(y_n − y_i), x_n − x_i) times the error; the sums over i are
    those of powers of x_i and y_i.
    """
    x, y, heading = pose
    t = _STEP_TURN**2 * stepped + _SLIDE_TURN**2 * moving if deviation is None else _GYRO_DRIFT**2 * moving
    b = 0.0 * moving if deviation is None else deviation * moving
    slid = _STEP**2 * stepped + _SLIDE**2 * moving
    added = slid, t, x * t, y * t, x * x * t, x * y * t, y * y * t, b, x * b, y * b
    sums = [_summed(first, values) for first, values in zip(before, added, strict=True)]
    moved, q, qx, qy, qxx, qxy, qyy, s, sx, sy = sums
    # Errors that are the same in all rows: of scale, and of the gyrometer's bias.
    i, j, k = _SCALE * x, _SCALE * y, (_SCALE if deviation is None else _GYRO_SCALE) * heading
    u, v, w = sy - y * s, x * s - sx, s
    xx = moved + y * y * q - 2.0 * y * qy + qyy + i * i + u * u + later * _NOISE**2
    yy = moved + x * x * q - 2.0 * x * qx + qxx + j * j + v * v + later * _NOISE**2
    xy = -(x * y * q - x * qy - y * qx + qxy) + i * j + u * v
    xt, yt, tt = qy - y * q + i * k + u * w, x * q - qx + j * k + v * w, q + k * k + w * w + later * _NOISE_TURN**2
    last = [float(column) if isinstance(column, float) else float(column[-1]) for column in sums]
    return np.array([xx, xy, xt, xy, yy, yt, xt, yt, tt]).T.reshape(-1, 3, 3), last
