"""Tests of many values in one case fail with every value that fails."""

from __future__ import annotations

import pytest
from loops import for_all


def test_a_test_of_many_values_fails_with_all_that_fail() -> None:
    @for_all("base", [1, 2])
    @for_all(("power", "limit"), [(1, 2), (2, 3), (3, 7)])
    def below(base: int, power: int, limit: int) -> None:
        assert base**power < limit

    with pytest.raises(AssertionError) as failed:
        below()
    assert str(failed.value).startswith("1 of 2 fail:\nbase=2: AssertionError: 3 of 3 fail:\npower=1, limit=2: ")
    for_all("base", [1])(lambda base: None)()
