"""When a robot is at rest, and the bias of its gyrometer.

A log is cut into intervals of half a second. The trunk is quiet in an interval if the gyrometer, or without one the
vertical, hardly varies; the robot is at rest in it if the trunk has been quiet and the legs in place since the interval
before, and its soles carry it. Head and arms may move. At rest the mean of the gyrometer is its bias, which drifts: a
Kalman filter of one interval after the other follows it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats

Mask = NDArray[np.bool_]

# An interval [s]. In a quiet one the gyrometer shows less than _SLOW on average, beside its bias, and varies by less
# than _QUIET [rad/s]; without gyrometer, the vertical moves and varies by less than _NODDING. The means of the legs'
# joints change by less than _STILL from one interval at rest to the next [rad].
INTERVAL, _SLOW, _QUIET, _NODDING, _STILL = 0.5, 0.1, 0.05, np.radians(1.0), np.radians(0.3)
# Standard deviations of a bias that is not known, of its drift in a second, and of its measurement in an interval, by
# the turn of a trunk that gives way; in addition to the noise of the gyrometer [rad/s].
_BIAS, _DRIFT, _MEASURED = np.radians(1.0), np.radians(0.02), np.radians(0.1)
# Deviation above which the bias counts as not known in a note [rad/s].
KNOWN = np.radians(0.5)


class Turns(NamedTuple):
    """The angular velocity of the root link in n rows.

    Attributes:
        rates: without the bias, shape (n, 3) [rad/s].
        near: in which rows it is known, shape (n,).
        deviation: standard deviation of the remaining bias, shape (n,) [rad/s].
    """

    rates: Floats
    near: Mask
    deviation: Floats


def bias_notes(measured: Floats, unknown: bool) -> list[str]:
    """Return what is noted of the biases in rows at rest, (m, 3), and if in some rows it is not known."""
    shown = ", ".join(f"{value:.4f}" for value in measured.mean(axis=0)) if len(measured) else ""
    notes = [f"the gyrometer's mean at rest, {shown} rad/s, is subtracted"] if shown else []
    if unknown:
        when = "in rows long before or after rest" if shown else "as the robot is never at rest on its soles"
        notes.append(f"the gyrometer's bias is not known, {when}: 1°/s of it is in the covariance of the heading")
    return notes


class Rest:
    """The rule above, for one interval after the other.

    Attributes:
        quiet: whether the trunk was quiet in the last interval; None if no sensor shows it.
        rest: whether the robot was at rest in it.
        bias, variance: of the gyrometer after it, shape (3,) [rad/s], and of each of the three numbers [rad²/s²].
    """

    def __init__(self, sensor: Literal["gyro", "up"] | None) -> None:
        self._sensor = sensor
        self.quiet: bool | None = None
        self.rest = False
        self.bias, self.variance = np.zeros(3), _BIAS**2
        self.measured: tuple[Floats, float] | None = None
        self._before: tuple[int, Floats, bool | None] | None = None

    @staticmethod
    def values(legs: Floats, stands: Mask, shown: Floats | None) -> Floats:
        """Return what rows (n, j), and what the sensor shows (n, 3), add to the sums of their interval."""
        found = np.zeros((len(legs), 8 + legs.shape[1]))
        found[:, 0], found[:, 1], found[:, 8:] = 1.0, stands, legs
        if shown is not None:
            found[:, 2:5], found[:, 5:8] = shown, shown * shown
        return found

    def lasts(self, legs: Floats, shown: Floats | None) -> bool:
        """Whether joints (j,), and what the sensor shows (3,), are those of the interval before, if it was at rest."""
        if not self.rest or self._before is None:
            return False
        mean, changes = self._before[1], _SLOW if self._sensor == "gyro" else 2.0 * _NODDING
        still = shown is None or np.abs(shown - mean[2:5]).max() < changes
        return bool(still and np.abs(legs - mean[8:]).max(initial=0.0) < 2.0 * _STILL)

    def close(self, number: int, sums: Floats) -> None:
        """Judge the interval of this number, with the `sums` of the values of its rows."""
        count, before = float(sums[0]), self._before
        self.measured, self.quiet, self.rest, self._before = None, None, False, None
        self.variance += _DRIFT**2 * INTERVAL * (1 if before is None else number - before[0])
        if count < 2.0:
            return
        mean = sums / count
        follows = before is not None and number == before[0] + 1
        spread = float(np.maximum(mean[5:8] - mean[2:5] ** 2, 0.0).max())
        if self._sensor == "gyro":
            self.quiet = bool(np.abs(mean[2:5] - self.bias).max() < _SLOW and spread < _QUIET**2)
        elif self._sensor == "up" and before is not None and follows:
            moved = float(np.abs(mean[2:5] - before[1][2:5]).max())
            self.quiet = moved < _NODDING and spread < _NODDING**2
        self._before = number, mean, self.quiet
        if before is None or not follows or False in (self.quiet, before[2]) or mean[1] < 1.0:
            return
        self.rest = bool(np.abs(mean[8:] - before[1][8:]).max(initial=0.0) < _STILL)
        if self.rest and self._sensor == "gyro":
            self.measured = mean[2:5], spread / count + _MEASURED**2
            self.bias, self.variance = _corrected(self.bias, self.variance, *self.measured)


def _corrected(bias: Floats, variance: float, measured: Floats, noise: float) -> tuple[Floats, float]:
    """Return a bias and its variance after a measurement."""
    gain = variance / (variance + noise) if np.isfinite(variance) else 1.0
    return bias + gain * (measured - bias), gain * noise


@dataclass(frozen=True, eq=False)
class RestLog:
    """Rest in the n rows of a log: of their intervals, known to its end.

    Attributes:
        quiet, rest: of the interval of each row, shape (n,); without a sensor, `quiet` is None.
        bias, deviation: of the gyrometer, forwards and backwards in time, shapes (n, 3) and (n,) [rad/s].
    """

    quiet: Mask | None
    rest: Mask
    bias: Floats
    deviation: Floats

    @property
    def notes(self) -> list[str]:
        """What is noted of the bias of the gyrometer."""
        return bias_notes(self.bias[self.rest], bool(self.deviation.max(initial=0.0) > KNOWN))

    @staticmethod
    def of(
        moments: Floats, legs: Floats, stands: Mask, used: Mask, shown: Floats | None, sensor: Literal["gyro", "up"]
    ) -> RestLog:
        """Return the rest in rows with legs (n, j), of which some are `used` (n,), and rates or verticals (n, 3)."""
        rule = Rest(None if shown is None else sensor)
        numbers, own = np.unique(np.floor((moments - moments[0]) / INTERVAL).astype(np.intp), return_inverse=True)
        values = np.where(used[:, None], rule.values(legs, stands, shown), 0.0)
        sums = np.add.reduceat(values, np.flatnonzero(np.diff(own, prepend=-1)), axis=0)
        quiet, rest = np.zeros((2, len(numbers)), dtype=np.bool_)
        bias, variance = np.empty((len(numbers), 3)), np.empty(len(numbers))
        measured: list[tuple[Floats, float] | None] = []
        for k, number in enumerate(numbers.tolist()):
            rule.close(number, sums[k])
            quiet[k], rest[k], bias[k], variance[k] = bool(rule.quiet), rule.rest, rule.bias, rule.variance
            measured.append(rule.measured)
        # Backwards from an unknown bias; both estimates count by their variances.
        later, unsure = np.zeros(3), np.inf
        for k in range(len(numbers) - 1, -1, -1):
            if np.isfinite(unsure):
                bias[k], variance[k] = _corrected(bias[k], variance[k], later, unsure)
            again = measured[k]
            if again is not None:
                later, unsure = _corrected(later, unsure, *again)
            unsure += _DRIFT**2 * INTERVAL * float(numbers[k] - numbers[max(k - 1, 0)])
        # An interval at rest begins with the one before it.
        rest[:-1] |= rest[1:]
        return RestLog(None if shown is None else quiet[own], rest[own], bias[own], np.sqrt(variance)[own])
