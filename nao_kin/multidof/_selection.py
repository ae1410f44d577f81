"""Which triple of each ball is meant: true to the couplings, near a reference or inside the limits, as carriers say."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nao_kin._arrays import Floats
from nao_kin.multidof._layout import Ball, Reading
from nao_kin.multidof._turns import near, shifted, turns_of_quaternion, uncertainty, unlocked, wrapped
from nao_kin.robot.coordinates import COUPLING_TOLERANCE
from nao_kin.robot.limits import TOLERANCE as LIMIT_TOLERANCE

# A value better known than this needs no second source.
_SURE = 1e-13
# No limit of a turn is larger than this [rad].
_UNLIMITED = 1e3


@dataclass(frozen=True, eq=False)
class Mismatch:
    """How far the joints that follow one driver are from what it asks of them.

    Attributes:
        follower: the joint that follows.
        driver_value: value of the driver, shape (n,).
        follower_value: value of the follower, shape (n,).
        violated: where rounding does not explain the difference, shape (n,).
        nearest: value of the driver that together with all its followers is nearest to the values given, shape (n,).
    """

    follower: Reading
    driver_value: Floats
    follower_value: Floats
    violated: NDArray[np.bool_]
    nearest: Floats


@dataclass(frozen=True, eq=False)
class _Triple:
    """One triple of angles of a ball.

    Attributes:
        angles: shape (n, 3).
        costs: squared distances from the reference or the limits, from the carriers, and from the middle of the
            limits, shape (3, n).
        doubt: uncertainty of the outer angles, shape (n,).
    """

    angles: Floats
    costs: Floats
    doubt: Floats


@dataclass(eq=False)
class _Choice:
    """One combination of triples: the values of all joints, and how good they are, what weighs most first."""

    angles: dict[str, Floats]
    costs: Floats
    mismatches: list[Mismatch]

    @property
    def order(self) -> Floats:
        """How many couplings are violated, then the costs of the triples; shape (4, n)."""
        n = self.costs.shape[-1]
        violations = np.sum([m.violated for m in self.mismatches], axis=0) if self.mismatches else np.zeros(n)
        return np.concatenate([np.broadcast_to(violations, (1, n)), self.costs])


class Selection:
    """Chooses the triples of all balls for n typed configurations at once."""

    def __init__(self, balls: Sequence[Ball], followers: Sequence[Reading]) -> None:
        self._balls, self._followers = tuple(balls), tuple(followers)
        self._place = {reading.name: (ball, k) for ball in self._balls for k, reading in enumerate(ball.readings)}
        self._clusters = list(self._connected())
        # Drivers that a whole turn takes to another value of a follower.
        self._wound = {follower.driver for follower in self._followers if follower.multiplier % 1.0 != 0.0}

    def choose(
        self,
        quaternions: Mapping[str, Floats],
        values: Mapping[str, Floats],
        carried: Mapping[str, Floats],
        reference: Floats | None,
    ) -> tuple[dict[str, Floats], list[Mismatch]]:
        """Values of all joints by name, each of shape (n,), and what the couplings miss.

        Args:
            quaternions: by the name of the ball, (x, y, z, w), shape (n, 4).
            values: the joints outside balls, by name, shape (n,).
            carried: what carriers and other copies say of joints, by name, shape (n,).
            reference: configurations of the robot, shape (n, nq).
        """
        chosen = dict(values)
        found = []
        for balls, followers in self._clusters:
            best: _Choice | None = None
            triples = [
                self._triples(ball, quaternions[ball.name], _told(ball, {**values, **carried}), reference)
                for ball in balls
            ]
            for combination in itertools.product(*triples):
                choice = self._settled(balls, followers, values, combination)
                best = choice if best is None else _better(best, choice)
            if best is not None:
                chosen |= best.angles
                found += best.mismatches
        return chosen, found

    def _connected(self) -> Iterator[tuple[list[Ball], list[Reading]]]:
        """Balls that share a motor, with the couplings of that motor; each ball and each coupling once."""
        waiting, couplings = list(self._balls), list(self._followers)
        while waiting or couplings:
            balls = [waiting.pop(0)] if waiting else []
            mine: list[Reading] = []
            drivers = {couplings[0].driver} if not balls else {r.driver for ball in balls for r in ball.readings}
            while True:
                joined = [ball for ball in waiting if drivers & {r.driver for r in ball.readings}]
                taken = [follower for follower in couplings if follower.driver in drivers]
                if not joined and not taken:
                    break
                waiting = [ball for ball in waiting if ball not in joined]
                couplings = [follower for follower in couplings if follower not in taken]
                balls, mine = balls + joined, mine + taken
                drivers |= {r.driver for ball in joined for r in ball.readings}
            yield balls, mine

    def _triples(self, ball: Ball, xyzw: Floats, told: list[Floats | None], reference: Floats | None) -> list[_Triple]:
        """Both triples, by whole turns and at a lock in every way that may be the one meant."""
        found = turns_of_quaternion(ball, xyzw)
        middles, halves = np.transpose([_window(reading) for reading in ball.readings])
        if reference is None:
            target = np.broadcast_to(middles, found.angles.shape)
        else:
            target = np.stack([reading.of(reference) for reading in ball.readings], axis=-1)
        triples = []
        for branch in (found.angles, found.other):
            angles = near(unlocked(ball, near(branch, target), found.locked, target), target)
            doubt = uncertainty(ball, angles[..., 1], found.locked)
            candidates = [angles]
            if reference is None:
                candidates += _as_told(ball, angles, told, doubt, middles[2])
            for candidate in [*candidates, *(turned for each in candidates for turned in self._wound_up(ball, each))]:
                off = candidate - middles
                excess = (
                    np.maximum(np.abs(off) - halves - LIMIT_TOLERANCE, 0.0) if reference is None else candidate - target
                )
                astray = np.zeros_like(off)
                for k, says in enumerate(told):
                    if says is not None:
                        astray[:, k] = wrapped(candidate[:, k] - says)
                costs = [np.sum(part * part, axis=-1) for part in (excess, astray, off)]
                triples.append(_Triple(candidate, np.array(costs), doubt))
        return triples

    def _wound_up(self, ball: Ball, angles: Floats) -> Iterator[Floats]:
        """The triple with a driver one turn further or less, where its followers tell the difference."""
        for k, reading in enumerate(ball.readings):
            if not reading.follows and reading.name in self._wound:
                for turns in (-1.0, 1.0):
                    yield angles + 2.0 * math.pi * turns * np.eye(3)[k]

    def _settled(
        self,
        balls: Sequence[Ball],
        followers: Sequence[Reading],
        values: Mapping[str, Floats],
        triples: Sequence[_Triple],
    ) -> _Choice:
        """The values of one combination, with every coupling given to the joint that knows its value best."""
        angles = {ball.name: triple.angles for ball, triple in zip(balls, triples, strict=True)}
        doubts = {ball.name: triple.doubt for ball, triple in zip(balls, triples, strict=True)}

        def read(name: str) -> tuple[Floats, Floats]:
            if name not in self._place:
                return values[name], np.zeros(1)
            ball, k = self._place[name]
            return angles[ball.name][..., k], doubts[ball.name] if k != 1 else np.zeros(1)

        def move(name: str, by: Floats) -> None:
            if name in self._place:
                ball, k = self._place[name]
                angles[ball.name] = shifted(ball, angles[ball.name], k, by)

        mismatches = []
        for driver in sorted({follower.driver for follower in followers}):
            mine = [follower for follower in followers if follower.driver == driver]
            value, doubt = read(driver)
            gaps = [_gap(follower, value, read(follower.name)[0]) for follower in mine]
            shift = np.zeros_like(value)
            for follower, gap in zip(mine, gaps, strict=True):
                other = read(follower.name)[1] / abs(follower.multiplier)
                explained = np.abs(gap / follower.multiplier) <= COUPLING_TOLERANCE + doubt + other
                better = (doubt > _SURE) & (other < doubt) & explained
                shift = np.where(better, gap / follower.multiplier, shift)
                doubt = np.where(better, other, doubt)
            move(driver, shift)
            value = value + shift
            gaps = [wrapped(gap - follower.multiplier * shift) for follower, gap in zip(mine, gaps, strict=True)]
            weight = 1.0 + sum(follower.multiplier**2 for follower in mine)
            pull = sum((follower.multiplier * gap for follower, gap in zip(mine, gaps, strict=True)), np.zeros(1))
            for follower, gap in zip(mine, gaps, strict=True):
                allowed = COUPLING_TOLERANCE + abs(follower.multiplier) * doubt + read(follower.name)[1]
                violated = np.abs(gap) > allowed
                stated = follower.multiplier * value + follower.offset + gap
                mismatches.append(Mismatch(follower, value, stated, violated, value + pull / weight))
                move(follower.name, np.where(violated, 0.0, -gap))
        by_name = {reading.name: angles[ball.name][..., k] for ball in balls for k, reading in enumerate(ball.readings)}
        costs = np.sum([triple.costs for triple in triples], axis=0) if triples else np.zeros((3, 1))
        return _Choice(by_name, costs, mismatches)


def _gap(follower: Reading, driver: Floats, value: Floats) -> Floats:
    """What the follower's value is above what the driver asks of it, by whole turns nearest to zero."""
    return wrapped(value - follower.multiplier * driver - follower.offset)


def _told(ball: Ball, values: Mapping[str, Floats]) -> list[Floats | None]:
    """What others say of the three angles: their carriers, or what their drivers' carriers ask of them.

    Nobody may have set the carriers, so nothing they say is taken for more than `_UNLIMITED`.
    """
    told: list[Floats | None] = []
    for reading in ball.readings:
        if reading.name in values:
            told.append(np.clip(values[reading.name], -_UNLIMITED, _UNLIMITED))
        elif reading.driver in values:
            asked = reading.multiplier * np.clip(values[reading.driver], -_UNLIMITED, _UNLIMITED) + reading.offset
            told.append(np.clip(asked, -_UNLIMITED, _UNLIMITED))
        else:
            told.append(None)
    return told


def _as_told(
    ball: Ball, angles: Floats, told: Sequence[Floats | None], doubt: Floats, third: float
) -> Iterator[Floats]:
    """The same triple by the whole turns told, and in doubt with the outer angle told; nothing if that is the same."""
    moved = angles
    if told[0] is not None:
        by = wrapped(told[0] - angles[:, 0])
        use = (doubt > _SURE) & (np.abs(by) <= doubt)
        if use.any():
            moved = shifted(ball, angles, 0, np.where(use, by, 0.0))
            turns = np.round((moved[:, 2] - third) / (2.0 * math.pi))
            moved[:, 2] -= 2.0 * math.pi * np.where(use, turns, 0.0)
    for k, says in enumerate(told):
        if says is not None:
            turns = np.round((says - moved[:, k]) / (2.0 * math.pi))
            if turns.any():
                moved = moved + 2.0 * math.pi * turns[:, None] * np.eye(3)[k]
    if moved is not angles:
        yield moved


def _window(reading: Reading) -> tuple[float, float]:
    """Middle and half width of the range of a joint; without limits, a full turn about zero."""
    lower, upper = reading.lower, reading.upper
    if abs(lower) > _UNLIMITED and abs(upper) > _UNLIMITED:
        return 0.0, math.pi
    if abs(lower) > _UNLIMITED or abs(upper) > _UNLIMITED:
        return (upper - math.pi if abs(lower) > _UNLIMITED else lower + math.pi), math.pi
    return 0.5 * (lower + upper), 0.5 * (upper - lower)


def _better(best: _Choice, other: _Choice) -> _Choice:
    """Row by row the one that comes first in order; the first of equals."""
    ours_first, theirs_first = best.order, other.order
    wins = np.zeros(ours_first.shape[-1], dtype=np.bool_)
    for ours_next, theirs_next in zip(ours_first[::-1], theirs_first[::-1], strict=True):
        wins = (theirs_next < ours_next) | ((theirs_next == ours_next) & wins)
    return _Choice(
        angles={name: np.where(wins, other.angles[name], values) for name, values in best.angles.items()},
        costs=np.where(wins, other.costs, best.costs),
        mismatches=[
            Mismatch(
                ours.follower,
                *(
                    np.where(wins, getattr(theirs, name), getattr(ours, name))
                    for name in ("driver_value", "follower_value", "violated", "nearest")
                ),
            )
            for ours, theirs in zip(best.mismatches, other.mismatches, strict=True)
        ],
    )
