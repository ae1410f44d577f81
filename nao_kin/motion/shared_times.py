"""Joints with keys at the same times, sampled together: a row of all at once instead of one joint after another."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from nao_kin._common.arrays import Floats
from nao_kin.motion.interpolation import Segments, segment_of

# Times at once, so that what is between two steps stays in the cache.
_AT_ONCE = 1024
# Coefficients that may be kept: 64 MB.
MOST_KEPT = 8_000_000


class SharedTimes:
    """The curves of all joints as polynomials c₀ + x (c₁ + x (c₂ + x c₃)) in the share x of a segment's time."""

    def __init__(self, times: Floats, keys: Sequence[Floats], segments: Sequence[Segments], *, straight: bool) -> None:
        """Prepare the coefficients.

        Args:
            times: of the keys, shape (k,), k ≥ 2.
            keys: of each joint, shape (k,).
            segments: of each joint, polynomials in time.
            straight: all are straight lines.
        """
        self._times, self._last = times, np.array([column[-1] for column in keys])
        first = np.stack([curve.first for curve in segments], axis=-1)
        p, q, d = np.moveaxis(np.stack([curve.controls for curve in segments], axis=-1), 1, 0)
        # A row of coefficients of all joints for each segment.
        rows = [first, d] if straight else [first, 3.0 * p, 3.0 * (q - 2.0 * p), d - 3.0 * (q - p)]
        self._coefficients = [np.ascontiguousarray(row) for row in rows]

    def sample(self, t: Floats) -> Floats:
        """Values at times (n,), shape (n, joints)."""
        result = np.empty((len(t), len(self._last)))
        for rows, segment, x in self._begun(t, result):
            for coefficients in self._coefficients[-2::-1]:
                rows *= x
                rows += coefficients[segment]
        # Exactly the keys, where a sum would round.
        result[t >= self._times[-1]] = self._last
        return result

    def speed(self, t: Floats) -> Floats:
        """Speeds at times (n,), shape (n, joints)."""
        result = np.empty((len(t), len(self._last)))
        for rows, segment, x in self._begun(t, result):
            rows *= len(self._coefficients) - 1
            for power in range(len(self._coefficients) - 2, 0, -1):
                rows *= x
                rows += power * self._coefficients[power][segment]
            rows /= (self._times[segment + 1] - self._times[segment])[:, None]
        result[(t < self._times[0]) | (t > self._times[-1])] = 0.0
        return result

    def _begun(self, t: Floats, result: Floats) -> Iterator[tuple[Floats, NDArray[np.intp], Floats]]:
        """Parts of the result with their last coefficients in them, their segments, and where in these they are."""
        for start in range(0, len(t), _AT_ONCE):
            part = slice(start, start + _AT_ONCE)
            segment = segment_of(self._times, t[part])
            rows = result[part]
            np.take(self._coefficients[-1], segment, axis=0, out=rows)
            yield rows, segment, self._share(segment, t[part])[:, None]

    def _share(self, segment: NDArray[np.intp], t: Floats) -> Floats:
        start = self._times[segment]
        return np.asarray(np.clip((t - start) / (self._times[segment + 1] - start), 0.0, 1.0))
