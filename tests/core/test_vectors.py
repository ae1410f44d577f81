"""Unit vectors at every scale."""

from __future__ import annotations

import numpy as np
import pytest

from nao_kin._core.arrays import largest, unit
from nao_kin.errors import ZeroNorm

SCALES = (5e-324, 1e-320, 1e-308, 1e-200, 1e-160, 1.0, 1e160, 1e307)


@pytest.mark.parametrize("scale", SCALES)
def test_a_unit_vector_and_its_length_are_right_down_to_the_smallest_floats(scale: float) -> None:
    for v in (np.array([3.0, 4.0, 0.0]), np.array([0.0, 0.0, -7.0]), np.array([2.0, -3.0, 0.0, 6.0])):
        length = float(np.linalg.norm(v))
        e, found = unit(scale * v, "vector")
        np.testing.assert_allclose(e, v / length, rtol=2.3e-16)
        np.testing.assert_allclose(found, scale * length, rtol=2.3e-16)
    together, lengths = unit(np.array([[scale, 0.0, 0.0], [0.0, 3.0, 4.0]]), "vector")
    np.testing.assert_array_equal(together, [[1.0, 0.0, 0.0], [0.0, 0.6, 0.8]])
    np.testing.assert_array_equal(lengths, [scale, 5.0])


def test_longer_than_any_float_a_vector_still_has_its_direction() -> None:
    e, length = unit(np.full(3, -1.7e308), "vector")
    np.testing.assert_allclose(e, -np.sqrt(np.full(3, 1 / 3)), rtol=2.3e-16)
    assert length == np.inf


def test_zero_has_no_direction() -> None:
    with pytest.raises(ZeroNorm, match=r"at index \[1\]"):
        unit(np.array([[1.0, 0.0], [0.0, 0.0]]), "vector")


def test_the_largest_component_is_found_wherever_it_stands() -> None:
    for size in (1, 2, 3, 4):
        for place in range(size):
            v = np.full((2, size), 0.5)
            v[1, place] = -3.0
            assert largest(v).tolist() == [0.5, 3.0]
    assert largest(np.ones((0, 3))).shape == (0,)
    assert largest(np.array([1.0, -2.0, 0.0])).shape == ()
