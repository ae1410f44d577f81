"""The check of arrays that everything goes through."""

from __future__ import annotations

import numpy as np
import pytest
from loops import for_all

import nao_kin as nk
from nao_kin._core.arrays import all_finite, generator
from nao_kin.errors import BadArgument

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


# --- Generators of random numbers.


@for_all("seed", [0, 7, 2**80, np.int64(7), (1, 2), [2**40, 0], range(3), np.array([3, 4]), np.random.SeedSequence(5)])
def test_a_seed_gives_the_numbers_that_numpy_gives(seed: object) -> None:
    expected = np.random.default_rng(seed).random(3)  # type: ignore[arg-type]
    assert generator(seed).random(3).tolist() == expected.tolist()


def test_a_generator_stays_itself() -> None:
    own = np.random.default_rng(1)
    assert generator(own) is own
    assert generator(np.random.PCG64(3)).random() == np.random.default_rng(3).random()
    assert generator(None).random() != generator(None).random()


@pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")  # of a matrix
def test_a_configuration_is_not_drawn_with_anything_else(nao: nk.NaoModel) -> None:
    for rng in (np.matrix(np.eye(3)), "L" * 100_000, -1, [0.5]):
        with pytest.raises(
            BadArgument, match=r"^rng must be a generator, or a seed of whole numbers from 0, got .{1,200}$"
        ):
            nao.random(rng)  # type: ignore[arg-type]
