"""Curves through the keys of one joint: straight, smooth (monotone cubic) and Bezier.

Every segment between two keys is one cubic in a parameter u from 0 to 1:

    value(u) = key₀ + 3 u (1 − u)² P + 3 u² (1 − u) Q + u³ D        D = key₁ − key₀
    x(u)     =        3 u (1 − u)² a + 3 u² (1 − u) (1 − b) + u³    x = (time − time₀) / (time₁ − time₀)

P is the value of the handle after the first key, Q − D that of the handle before the second; a and b are the lengths of
the two handles as fractions of the segment. For straight and smooth segments a = b = ⅓, so x = u.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats

Interpolation = Literal["linear", "bezier", "smooth"]
INTERPOLATIONS: tuple[Interpolation, ...] = ("linear", "bezier", "smooth")

_THIRD = 1.0 / 3.0
# Newton's method needs five steps; where dx/du = 0 it converges as slowly as bisection.
_MAX_STEPS = 80
# Accuracy of u.
_ACCURACY = 1e-15


def smooth_slopes(times: Floats, keys: Floats) -> Floats:
    """Return the slopes of the monotone cubic at the keys, shape (k,).

    The lines before and after a key have the widths h and the slopes d. The slope at the key is zero if d₁ and d₂
    differ in sign, else their weighted harmonic mean (w₁ + w₂) / (w₁ / d₁ + w₂ / d₂), w₁ = h₁ + 2 h₂, w₂ = 2 h₁ + h₂.
    It is zero at both ends, at rest. Between two keys the curve never leaves their range.
    Source: F. N. Fritsch and J. Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300–304.
    """
    slopes = np.zeros_like(keys)
    if len(keys) > 2:
        widths = np.diff(times)
        straight = np.diff(keys) / widths
        before, after = straight[:-1], straight[1:]
        w1, w2 = widths[:-1] + 2.0 * widths[1:], 2.0 * widths[:-1] + widths[1:]
        same = np.sign(before) * np.sign(after) > 0.0
        with np.errstate(divide="ignore", over="ignore"):
            inverse = w1[same] / before[same] + w2[same] / after[same]
            slopes[1:-1][same] = (w1 + w2)[same] / inverse
    return slopes


def handles_along(times: Floats, slopes_before: Floats, slopes_after: Floats) -> Floats:
    """Return Bezier handles (k, 2, 2), a third of their segment long, along the slopes before and after each key (k,).

    The axes are key, before or after it, time or value. The handles before the first and after the last key are zero.
    """
    handles = np.zeros((len(times), 2, 2))
    thirds = np.diff(times) * _THIRD
    handles[1:, 0, 0], handles[:-1, 1, 0] = -thirds, thirds
    handles[..., 1] = handles[..., 0] * np.stack([slopes_before, slopes_after], axis=-1)
    return handles


def bezier_handles(interpolation: Interpolation, times: Floats, keys: Floats) -> Floats:
    """Return the handles (k, 2, 2) with which a Bezier curve is the straight or the smooth one."""
    if interpolation == "linear":
        straight = np.diff(keys) / np.diff(times)
        return handles_along(times, np.concatenate([[0.0], straight]), np.concatenate([straight, [0.0]]))
    slopes = smooth_slopes(times, keys)
    return handles_along(times, slopes, slopes)


def bezier_parameter(a: Floats, b: Floats, x: Floats) -> Floats:
    """Return the u in [0, 1] with x(u) = x, for handles of lengths a and b in [0, 1]; shapes (n,).

    x(u) never decreases. A step of Newton's method that would leave the bracket found so far is replaced by bisection.
    """
    result = np.array(x)
    todo = np.arange(len(x))
    u, low, high = np.array(x), np.zeros(len(x)), np.ones(len(x))
    for _ in range(_MAX_STEPS):
        miss = _cubic(u, a, 1.0 - b, 1.0) - x
        low, high = np.where(miss <= 0.0, u, low), np.where(miss >= 0.0, u, high)
        slope = 3.0 * _quadratic(u, a, 1.0 - a - b, b)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            step = u - miss / slope
        new = np.where((step > low) & (step < high), step, 0.5 * (low + high))
        new = np.where(miss == 0.0, u, new)
        result[todo] = new
        left = np.abs(new - u) > _ACCURACY
        if not left.any():
            break
        todo, u, low, high = todo[left], new[left], low[left], high[left]
        a, b, x = a[left], b[left], x[left]
    return result


@dataclass(frozen=True, eq=False)
class Segments:
    """The m segments between the m + 1 keys of a joint."""

    start: Floats  # time of the beginning, shape (m,) [s]
    width: Floats  # duration, shape (m,) [s]; zero only for a joint that does not move
    first: Floats  # value at the beginning, shape (m,)
    controls: Floats  # P, Q and D of the value, shape (m, 3)
    lengths: Floats | None = None  # a and b of the time, shape (m, 2); None if all are a third

    def at(self, t: Floats) -> NDArray[np.intp]:
        """Return the segment of each time: at a key the one that begins there, at the last key the one before."""
        return np.asarray(np.clip(np.searchsorted(self.start, t, side="right") - 1, 0, None))

    def parameter(self, segment: NDArray[Any], t: Floats) -> Floats:
        """Return parameters u (n,) at times (n,) in segments (n,); times outside count as the nearest end."""
        width = self.width[segment]
        x: Floats = np.clip((t - self.start[segment]) / np.where(width > 0.0, width, 1.0), 0.0, 1.0)
        if self.lengths is None:
            return x
        return bezier_parameter(self.lengths[segment, 0], self.lengths[segment, 1], x)

    def time(self, segment: NDArray[Any], u: Floats) -> Floats:
        """Return times at parameters u [s]."""
        if self.lengths is None:
            return np.asarray(self.start[segment] + u * self.width[segment])
        a, b = self.lengths[segment].T
        return np.asarray(self.start[segment] + self.width[segment] * _cubic(u, a, 1.0 - b, 1.0))

    def value(self, segment: NDArray[Any], u: Floats) -> Floats:
        """Return values at parameters u; between equal keys, exactly the value of the keys at 0 and 1."""
        return np.asarray(self.first[segment] + _cubic(u, *self.controls[segment].T))

    def speed(self, segment: NDArray[Any], u: Floats) -> Floats:
        """Return the change of the value per second at parameters u; infinite where the curve is vertical."""
        value, time = self.slopes(segment), self.time_slopes(segment)
        over, under = _quadratic(u, *value), _quadratic(u, *time)
        vertical = under <= 0.0
        if vertical.any():
            # The limit of 0 / 0: the ratio of the second derivatives, then of the third.
            for order in (_quadratic_slope, _quadratic_bend):
                undetermined = vertical & (over == 0.0) & (under == 0.0)
                over = np.where(undetermined, order(u, *value), over)
                under = np.where(undetermined, order(u, *time), under)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.where(over == 0.0, 0.0, over / np.where(vertical & (under == 0.0), 0.0, under))
        width = self.width[segment]
        return np.asarray(ratio / np.where(width > 0.0, width, 1.0))

    def part(self, segment: NDArray[Any], u: Floats, v: Floats) -> Floats:
        """Return the control points of parts of segments between parameters u and v, shape (4, 2, n).

        The axes are control point, x or value; the value counts from the beginning of the segment. With its polar form
        f, a cubic has between u and v the control points f(u, u, u), f(u, u, v), f(u, v, v) and f(v, v, v).
        Source: L. Ramshaw, Blossoming: A Connect-the-Dots Approach to Splines, DEC SRC report 19 (1987).
        """
        a, b = np.full((2, len(segment)), _THIRD) if self.lengths is None else self.lengths[segment].T
        p, q, d = np.stack([np.array([a, 1.0 - b, np.ones_like(a)]), self.controls[segment].T], axis=1)
        rows = [(u, u, u), (u, u, v), (u, v, v), (v, v, v)]
        return np.array([_polar(p, q, d, *row) for row in rows])

    def slopes(self, segment: NDArray[Any]) -> Floats:
        """Return the Bernstein coefficients of a third of the value's derivative by u, shape (3, n)."""
        p, q, d = self.controls[segment].T
        return np.stack([p, q - p, d - q])

    def time_slopes(self, segment: NDArray[Any]) -> Floats:
        """Return the Bernstein coefficients of a third of the derivative of x by u, shape (3, n)."""
        if self.lengths is None:
            return np.full((3, len(segment)), _THIRD)
        a, b = self.lengths[segment].T
        return np.stack([a, 1.0 - a - b, b])


def segments(interpolation: Interpolation, times: Floats, keys: Floats, handles: Floats | None) -> Segments:
    """Return the segments between the keys of one joint; a single key has none."""
    width, rise = np.diff(times), np.diff(keys)
    lengths = None
    if handles is not None:
        after, before = handles[:-1, 1], handles[1:, 0]
        lengths = np.clip(np.stack([after[:, 0], -before[:, 0]], axis=-1) / width[:, None], 0.0, 1.0)
        if np.all(np.abs(lengths - _THIRD) < 1e-15):
            lengths = None
        p, q = after[:, 1], rise + before[:, 1]
    elif interpolation == "smooth":
        slopes = smooth_slopes(times, keys)
        p, q = slopes[:-1] * width * _THIRD, rise - slopes[1:] * width * _THIRD
    else:
        p, q = rise * _THIRD, rise - rise * _THIRD
    return Segments(times[:-1], width, keys[:-1], np.stack([p, q, rise], axis=-1), lengths)


def _cubic(u: Floats, p: Any, q: Any, d: Any) -> Floats:
    rest = 1.0 - u
    return np.asarray(u * (3.0 * rest * (rest * p + u * q) + u * u * d))


def _polar(p: Any, q: Any, d: Any, r: Floats, s: Floats, t: Floats) -> Floats:
    """Return the polar form of a cubic with the Bernstein coefficients 0, p, q and d."""
    once = r * (1.0 - s) * (1.0 - t) + s * (1.0 - r) * (1.0 - t) + t * (1.0 - r) * (1.0 - s)
    twice = r * s * (1.0 - t) + r * t * (1.0 - s) + s * t * (1.0 - r)
    return np.asarray(p * once + q * twice + d * r * s * t)


def _quadratic(u: Floats, c0: Any, c1: Any, c2: Any) -> Floats:
    rest = 1.0 - u
    return np.asarray(rest * rest * c0 + 2.0 * u * rest * c1 + u * u * c2)


def _quadratic_slope(u: Floats, c0: Any, c1: Any, c2: Any) -> Floats:
    return np.asarray(2.0 * ((1.0 - u) * (c1 - c0) + u * (c2 - c1)))


def _quadratic_bend(u: Floats, c0: Any, c1: Any, c2: Any) -> Floats:
    return np.asarray(2.0 * (c0 - 2.0 * c1 + c2) + 0.0 * u)
