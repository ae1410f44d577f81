"""Twists and poses at which rigid motions go wrong, and exact results with forty digits."""

from __future__ import annotations

import math

import mpmath
import numpy as np
from hypothesis import Phase, settings, strategies as st
from rotation_samples import PROPERTY, axes, beside, turns

EPS = float(np.finfo(float).eps)
# Settings for comparisons at forty digits, without shrinking, which would take minutes.
EXACT = settings(PROPERTY, max_examples=40, phases=[Phase.explicit, Phase.generate])
BATCHES = [(), (0,), (1,), (2, 3)]

# Special angles, angles near them, and angles above half a turn, of both signs.
ANGLES = [0.0, math.pi, *(10.0**-k for k in range(1, 18)), *(math.pi - 10.0**-k for k in range(1, 17)), 1.0, 2.5]

lengths = st.one_of(st.floats(-3.0, 3.0), beside(0.0), st.sampled_from([-1.0, 0.0, 1.0, 1e3, 1e-9]))
points = st.tuples(lengths, lengths, lengths).map(np.array)
twists = st.builds(lambda v, e, a, s: np.r_[v, s * a * e], points, axes, turns, st.sampled_from([-1.0, 1.0]))
# Past half a turn, and past a whole one.
long_twists = st.builds(lambda v, e, a: np.r_[v, a * e], points, axes, st.floats(math.pi, 20.0))


def length(v: np.ndarray) -> float:
    """‖v‖, for vectors whose squares underflow too."""
    return math.hypot(*v)


def random_twists(count: int, seed: int = 0, angle: float | None = None) -> np.ndarray:
    """Twists of shape (count, 6), ‖v‖ about 1, by uniform angles up to 3 or all by one angle."""
    rng = np.random.default_rng(seed)
    v, e = rng.normal(size=(2, count, 3))
    e /= np.linalg.norm(e, axis=-1, keepdims=True)
    return np.concatenate([v, e * (rng.uniform(0.0, 3.0, (count, 1)) if angle is None else angle)], axis=-1)


def exact_hat(twist: np.ndarray) -> mpmath.matrix:
    """[[[ω×], v], [0, 0]]."""
    v0, v1, v2, x, y, z = (mpmath.mpf(float(c)) for c in twist)
    return mpmath.matrix([[0, -z, y, v0], [z, 0, -x, v1], [-y, x, 0, v2], [0, 0, 0, 0]])


def exact_ad(twist: np.ndarray) -> mpmath.matrix:
    """The 6 × 6 matrix of the bracket with a twist, [[[ω×], [v×]], [0, [ω×]]]."""
    hat = exact_hat(twist)
    ad = mpmath.zeros(6)
    v0, v1, v2 = hat[0, 3], hat[1, 3], hat[2, 3]
    shift = mpmath.matrix([[0, -v2, v1], [v2, 0, -v0], [-v1, v0, 0]])
    for i in range(3):
        for j in range(3):
            ad[i, j] = ad[i + 3, j + 3] = hat[i, j]
            ad[i, j + 3] = shift[i, j]
    return ad


def power_series(A: mpmath.matrix, shift: int = 0) -> mpmath.matrix:
    """Σ Aⁿ/(n + shift)!: the exponential for shift 0, the mean ∫₀¹ exp(s A) ds for shift 1."""
    total, term, n = mpmath.zeros(A.rows), mpmath.eye(A.rows) / mpmath.factorial(shift), 0
    while n < 4 or mpmath.mnorm(term, mpmath.inf) > mpmath.mpf(10) ** -38 * mpmath.mnorm(total, mpmath.inf):
        total += term
        n += 1
        term = term * A / (n + shift)
    return total


def as_array(M: mpmath.matrix) -> np.ndarray:
    return np.array([[float(M[i, j]) for j in range(M.cols)] for i in range(M.rows)])


def exact_pose(twist: np.ndarray) -> np.ndarray:
    """The exponential of a twist, right to the last bit."""
    with mpmath.workdps(60):
        return as_array(power_series(exact_hat(twist)))
