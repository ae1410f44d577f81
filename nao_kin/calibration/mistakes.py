"""Usual mistakes in pixels of known points: another order of the corners, exchanged coordinates, a wrong size."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin.calibration.observations import BEHIND, AnyObservation, Checked, Pixels
from nao_kin.errors import NaoKinError

if TYPE_CHECKING:
    from nao_kin.calibration.solve import Problem

# A mistake is named if this quantile of the residuals is without it below this part of the one with it, and of σ.
_QUANTILE, _BETTER, _GOOD = 0.85, 0.25, 5.0
# Units that are taken for metres, and their size.
_UNITS = {"mm": 1e-3, "cm": 1e-2, "inches": 0.0254}
# Sizes of squares are seldom wrong by more; most sizes that are tried.
_LARGEST_RATIO, _MOST_SIZES = 2.0, 20
_MAX_NAMED = 5
# Steps of a search, which needs fewer if the observations agree.
_STEPS = 25


def likely_mistake(problem: Problem, again: Callable[[Sequence[AnyObservation]], Problem]) -> str:
    """Return which usual mistake explains bad residuals of `Pixels`, to end a message; "" if none does.

    Args:
        problem: the observations as given.
        again: makes the same problem with other observations.
    """
    given = [one.given for one in problem.observations]
    if not any(isinstance(one, Pixels) for one in given):
        return ""
    limit = min(_GOOD, _BETTER * _misfit(problem))

    def misfit(changed: Sequence[AnyObservation]) -> float:
        try:
            return _misfit(again(changed))
        except NaoKinError:
            return np.inf

    tried = [(misfit(changed), what) for what, changed in _changes(problem, given)]
    best, what = min(tried, key=lambda pair: pair[0])
    if best < limit:
        return f"; they agree if {what}"
    from scipy.optimize import minimize_scalar

    found = minimize_scalar(
        lambda power: misfit(_stretched(given, _LARGEST_RATIO**power)),
        bounds=(-1.0, 1.0),
        method="bounded",
        options={"maxiter": _MOST_SIZES, "xatol": 1e-3},
    )
    if found.fun < limit:
        ratio = _LARGEST_RATIO**found.x
        return f"; they agree if the points are {ratio:.3g} times as far apart (is the size of a square right?)"
    return ""


def _changes(problem: Problem, given: Sequence[AnyObservation]) -> Iterator[tuple[str, list[AnyObservation]]]:
    """Yield each mistake in words, and the observations without it."""
    state = problem.unknowns.at(np.zeros(problem.size))
    turned, named = list(given), list[str]()
    for number, one in enumerate(problem.observations):
        if isinstance(one.given, Pixels):
            predicted = one.measure(state, one.q).residuals
            reverse = _distances(one.measured[:, ::-1], predicted) < _distances(one.measured, predicted)
            pixels = np.array(one.given.pixels, dtype=np.float64)
            rows = pixels.reshape(-1, *pixels.shape[-2:])
            rows[reverse] = rows[reverse, ::-1]
            turned[number] = replace(one.given, pixels=pixels)
            if reverse.any():
                named.append(_postures(number, one, np.flatnonzero(reverse).tolist()))
    if named:
        yield f"the points are in reverse order in {'; '.join(named)}", turned
    yield (
        "u and v are exchanged",
        [replace(one, pixels=np.asarray(one.pixels)[..., ::-1]) if isinstance(one, Pixels) else one for one in given],
    )
    for unit, size in _UNITS.items():
        yield (
            f"the points are in {unit}, not in metres",
            [replace(one, points=size * np.asarray(one.points)) if isinstance(one, Pixels) else one for one in given],
        )


def _stretched(given: Sequence[AnyObservation], size: float) -> list[AnyObservation]:
    """Return observations with points that are so many times as far from the first one."""
    changed = list(given)
    for number, one in enumerate(given):
        if isinstance(one, Pixels):
            points = np.asarray(one.points, dtype=np.float64)
            changed[number] = replace(one, points=points[0] + size * (points - points[0]))
    return changed


def _postures(number: int, one: Checked, rows: list[int]) -> str:
    """Return the name of an observation, and of its postures if they are not all of it."""
    if len(rows) == len(one.q):
        return f"observation {number}"
    listed = ", ".join(map(str, rows[:_MAX_NAMED])) + (" …" if len(rows) > _MAX_NAMED else "")
    return f"posture {listed} of observation {number}"


def _distances(measured: Floats, predicted: Floats) -> Floats:
    """Return the mean distance of the points that are seen in each posture, shape (n,); 0 if there is none."""
    distances = np.linalg.norm(measured - predicted, axis=-1)
    known = np.isfinite(distances)
    return np.asarray(np.where(known, distances, 0.0).sum(axis=-1) / np.maximum(known.sum(axis=-1), 1))


def _misfit(problem: Problem) -> float:
    """Return a high quantile of the residuals of pixels after a calibration, in σ; infinite if it cannot start."""
    x = np.zeros(problem.size)
    if any((part.residuals == BEHIND).any() for part in problem.seen(x)):
        return np.inf
    seen = problem.seen(problem.solved(x, np.ones(problem.size, dtype=bool), "linear", _STEPS))
    pixels = [part for part, one in zip(seen, problem.observations, strict=True) if isinstance(one.given, Pixels)]
    return float(np.quantile(np.concatenate([np.linalg.norm(part.residuals, axis=-1) for part in pixels]), _QUANTILE))
