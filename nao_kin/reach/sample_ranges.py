"""Ranges of sample numbers: which are asked for, which are done, which are left."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from nao_kin._common.scalars import whole_number
from nao_kin._text import quoted
from nao_kin.errors import BadArgument

SampleRange = tuple[int, int]

# So many samples in one voxel, each of the best manipulability, still have a sum below 2⁶³.
MOST_SAMPLES = 2**32


def asked_range(samples: int | SampleRange, shard: tuple[int, int] | None) -> SampleRange:
    """The numbers of the samples that are asked for.

    Args:
        samples: how many, or from where to where.
        shard: (k, n) for the k-th of n parts of them, k from 0; None for all.

    Raises:
        BadArgument: no whole numbers, none at all, or more than can be counted.
    """
    if isinstance(samples, (tuple, list)):
        if len(samples) != 2:
            raise BadArgument(f"samples must be a number, or (start, stop), got {quoted(samples)}")
        start = whole_number(samples[0], "the first sample", 0)
        stop = whole_number(samples[1], "the end of the samples", start + 1, MOST_SAMPLES)
    else:
        start, stop = 0, whole_number(samples, "samples", 1, MOST_SAMPLES)
    if shard is None:
        return start, stop
    if not isinstance(shard, (tuple, list)) or len(shard) != 2:
        raise BadArgument(f"shard must be (k, n), the k-th of n parts, got {quoted(shard)}")
    count = whole_number(shard[1], "the number of shards", 1, stop - start)
    k = whole_number(shard[0], "the shard", 0, count - 1)
    return start + (stop - start) * k // count, start + (stop - start) * (k + 1) // count


def union(ranges: Iterable[SampleRange]) -> tuple[SampleRange, ...]:
    """The same samples in as few ranges as possible, ascending."""
    merged: list[SampleRange] = []
    for start, stop in sorted(ranges):
        if merged and start <= merged[-1][1]:
            merged[-1] = merged[-1][0], max(stop, merged[-1][1])
        elif start < stop:
            merged.append((start, stop))
    return tuple(merged)


def overlap(some: Sequence[SampleRange], others: Sequence[SampleRange]) -> SampleRange | None:
    """The first range that is in both; None when they share nothing."""
    shared = ((max(a, c), min(b, d)) for a, b in some for c, d in others)
    return next(((start, stop) for start, stop in shared if start < stop), None)


def without(asked: SampleRange, done: Sequence[SampleRange]) -> tuple[SampleRange, ...]:
    """What is left of `asked` where `done`, disjoint and ascending, is taken away."""
    left, (start, stop) = [], asked
    for first, last in done:
        if start < min(first, stop):
            left.append((start, min(first, stop)))
        start = max(start, last)
    if start < stop:
        left.append((start, stop))
    return tuple(left)
