"""Which triple of each ball is meant: nearest to a reference or inside the limits, and true to the couplings."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nao_kin._arrays import Floats
from nao_kin.typed._layout import Ball, Reading
from nao_kin.typed._turns import near, shifted, turns_of_quaternion, uncertainty, unlocked, wrapped

# Two values for one motor agree when they differ by less than single precision can tell, as everywhere in the library.
_COUPLING = 1e-6
# A limit missed by less than this is met, as everywhere in the library.
_LIMIT = 1e-9
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


@dataclass(eq=False)
class _Choice:
    """One combination of triples: the values of all joints, and how good they are."""

    angles: dict[str, Floats]
    cost: Floats
    mismatches: list[Mismatch]

    @property
    def violations(self) -> Floats:
        """How many couplings are violated, shape (n,)."""
        return np.sum([m.violated for m in self.mismatches], axis=0) if self.mismatches else np.zeros(len(self.cost))


class Selection:
    """Chooses the triples of all balls for n typed configurations at once."""

    def __init__(self, balls: Sequence[Ball], followers: Sequence[Reading]) -> None:
        self._balls, self._followers = tuple(balls), tuple(followers)
        self._place = {reading.name: (ball, k) for ball in self._balls for k, reading in enumerate(ball.readings)}
        self._clusters = list(self._connected())

    def choose(
        self, quaternions: Mapping[str, Floats], values: Mapping[str, Floats], reference: Floats | None
    ) -> tuple[dict[str, Floats], list[Mismatch]]:
        """Values of all joints by name, each of shape (n,), and what the couplings miss.

        Args:
            quaternions: by the name of the ball, (x, y, z, w), shape (n, 4).
            values: the joints outside balls, by name, shape (n,).
            reference: configurations of the robot, shape (n, nq).
        """
        chosen = dict(values)
        found = []
        for balls, followers in self._clusters:
            best: _Choice | None = None
            triples = [self._triples(ball, quaternions[ball.name], reference) for ball in balls]
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

    @staticmethod
    def _triples(ball: Ball, xyzw: Floats, reference: Floats | None) -> list[tuple[Floats, Floats, Floats]]:
        """Both triples, each with its cost and the uncertainty of its outer angles."""
        found = turns_of_quaternion(ball, xyzw)
        middles, halves = np.transpose([_window(reading) for reading in ball.readings])
        if reference is None:
            target = np.broadcast_to(middles, found.angles.shape)
        else:
            target = np.stack([reading.of(reference) for reading in ball.readings], axis=-1)
        triples = []
        for angles in (found.angles, found.other):
            angles = near(unlocked(ball, near(angles, target), found.locked, target), target)
            away = np.abs(angles - target)
            excess = np.maximum(away - halves - _LIMIT, 0.0) if reference is None else away
            doubt = uncertainty(ball, angles[..., 1], found.locked)
            triples.append((angles, np.sum(excess * excess, axis=-1), doubt))
        return triples

    def _settled(
        self,
        balls: Sequence[Ball],
        followers: Sequence[Reading],
        values: Mapping[str, Floats],
        triples: Sequence[tuple[Floats, Floats, Floats]],
    ) -> _Choice:
        """The values of one combination, with every coupling given to the joint that knows its value best."""
        angles = {ball.name: triple[0] for ball, triple in zip(balls, triples, strict=True)}
        doubts = {ball.name: triple[2] for ball, triple in zip(balls, triples, strict=True)}

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
                explained = np.abs(gap / follower.multiplier) <= _COUPLING + doubt + other
                better = (doubt > _SURE) & (other < doubt) & explained
                shift = np.where(better, gap / follower.multiplier, shift)
                doubt = np.where(better, other, doubt)
            move(driver, shift)
            value = value + shift
            gaps = [wrapped(gap - follower.multiplier * shift) for follower, gap in zip(mine, gaps, strict=True)]
            weight = 1.0 + sum(follower.multiplier**2 for follower in mine)
            pull = sum((follower.multiplier * gap for follower, gap in zip(mine, gaps, strict=True)), np.zeros(1))
            for follower, gap in zip(mine, gaps, strict=True):
                allowed = _COUPLING + abs(follower.multiplier) * doubt + read(follower.name)[1]
                violated = np.abs(gap) > allowed
                stated = follower.multiplier * value + follower.offset + gap
                mismatches.append(Mismatch(follower, value, stated, violated, value + pull / weight))
                move(follower.name, np.where(violated, 0.0, -gap))
        by_name = {reading.name: angles[ball.name][..., k] for ball in balls for k, reading in enumerate(ball.readings)}
        cost = np.sum([triple[1] for triple in triples], axis=0) if triples else np.zeros(1)
        return _Choice(by_name, cost, mismatches)


def _gap(follower: Reading, driver: Floats, value: Floats) -> Floats:
    """What the follower's value is above what the driver asks of it, by whole turns nearest to zero."""
    return wrapped(value - follower.multiplier * driver - follower.offset)


def _window(reading: Reading) -> tuple[float, float]:
    """Middle and half width of the range of a joint; without limits, a full turn about zero."""
    lower, upper = reading.lower, reading.upper
    if abs(lower) > _UNLIMITED and abs(upper) > _UNLIMITED:
        return 0.0, math.pi
    if abs(lower) > _UNLIMITED or abs(upper) > _UNLIMITED:
        return (upper - math.pi if abs(lower) > _UNLIMITED else lower + math.pi), math.pi
    return 0.5 * (lower + upper), 0.5 * (upper - lower)


def _better(best: _Choice, other: _Choice) -> _Choice:
    """Row by row the one that violates fewer couplings, or as few at less cost; the first of equals."""
    fewer, as_few = other.violations < best.violations, other.violations == best.violations
    wins = fewer | (as_few & (other.cost < best.cost))
    return _Choice(
        angles={name: np.where(wins, other.angles[name], values) for name, values in best.angles.items()},
        cost=np.where(wins, other.cost, best.cost),
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
