"""Runs of consecutive joints cut into joints of one, two or three axes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

_Item = TypeVar("_Item")


def partition(
    run: Sequence[_Item], mergeable: Callable[[Sequence[_Item]], bool], longest: int = 3
) -> list[list[_Item]]:
    """The best way to cut a run into pieces that are single or mergeable.

    Best is: the fewest pieces; among those the largest pieces (by the sum of squares of their lengths); among those the
    larger piece closer to the beginning of the run.
    """
    count = len(run)
    # best[i]: (pieces, −sum of squares, lengths from there on, negated) of the run from i on. Smaller is better.
    best: list[tuple[int, int, tuple[int, ...]]] = [(0, 0, ())] * (count + 1)
    for start in reversed(range(count)):
        options = []
        for length in range(1, min(longest, count - start) + 1):
            if length == 1 or mergeable(run[start : start + length]):
                pieces, squares, lengths = best[start + length]
                options.append((pieces + 1, squares - length * length, (-length, *lengths)))
        best[start] = min(options)
    cuts, start = [], 0
    for negative in best[0][2]:
        cuts.append(list(run[start : start - negative]))
        start -= negative
    return cuts
