"""The check of arrays that everything goes through."""

from __future__ import annotations

import numpy as np
from loops import for_all

from nao_kin._core.arrays import all_finite

# Exactly searched, just short enough for that, just too long, long.
SIZES = (1, 7, 2000, 2001, 10_000)


@for_all("size", SIZES)
@for_all("value", [0.0, 1.0, 1e-300, 1e154, 1e200, 1.7e308, -1.7e308])
def test_finite_numbers_are_finite_whether_or_not_their_squares_are(size: int, value: float) -> None:
    assert all_finite(np.full(size, value))
    one = np.zeros(size)
    one[size // 2] = value
    assert all_finite(one)


@for_all("size", SIZES)
@for_all("others", [0.0, 1.0, 1e200])
@for_all("bad", [np.nan, np.inf, -np.inf])
@for_all("place", [0, -1])
def test_one_entry_that_is_not_finite_is_enough(size: int, others: float, bad: float, place: int) -> None:
    array = np.full(size, others)
    array[place] = bad
    assert not all_finite(array)
    assert not all_finite(array.reshape(1, size, 1))


def test_an_array_in_any_layout_is_looked_at_whole() -> None:
    array = np.zeros((100, 60))
    array[99, 59] = np.nan
    for seen in (array, array.T, array[::-1, ::-1], np.asfortranarray(array), array[:, 30:]):
        assert not all_finite(seen)
    assert all_finite(array[:99])
    assert all_finite(np.zeros((0, 3)))
