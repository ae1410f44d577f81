"""What stands before the powers of [ω×] in exponentials, Jacobians and their inverses, right at every angle.

All of it follows from the functions cₖ(x) = Σ (−x)ⁿ/(2n + k)!, for x = θ²:
c₂ = (1 − cos θ)/θ², c₃ = (θ − sin θ)/θ³ and so on, with cₖ = 1/k! − x cₖ₊₂ and (dcₖ/dθ)/θ = k cₖ₊₂ − cₖ₊₁.
Up to θ = π the series of c₅ and c₆ converge without cancellation and the others follow; beyond, the closed forms do.

Source: Stumpff, Himmelsmechanik I, 1959, for the functions cₖ.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from nao_kin._common.arrays import Floats

Number = Any  # a float or an array of floats: formulas are written once for both

# At θ = π the first term left out is under 2⁻⁵³ of the sum.
_TERMS = 11
_FACTORS = {k: [1.0 / math.factorial(2 * n + k) for n in range(_TERMS, -1, -1)] for k in (5, 6)}
_NEAR = math.pi**2


def exponential_coefficients(square: Floats) -> tuple[Floats, ...]:
    """B and C of J(ω) = 1 + B [ω×] + C [ω×]², the left Jacobian of SO(3); of θ² = `square`, any shape."""
    return _by_size(square, lambda x: _stumpff(x)[:2], _B_and_C)


def jacobian_coefficients(square: Floats) -> tuple[Floats, ...]:
    """B, C and (dB/dθ)/θ, (dC/dθ)/θ."""

    def near(x: Number) -> tuple[Number, ...]:
        c2, c3, c4, c5, _ = _stumpff(x)
        return c2, c3, 2.0 * c4 - c3, 3.0 * c5 - c4

    def far(x: Number) -> tuple[Number, ...]:
        B, C = _B_and_C(x)
        A = np.sin(np.sqrt(x)) / np.sqrt(x)
        return B, C, (A - 2.0 * B) / x, (B - 3.0 * C) / x

    return _by_size(square, near, far)


def inverse_coefficients(square: Floats) -> tuple[Floats, ...]:
    """D of J(ω)⁻¹ = 1 − ½ [ω×] + D [ω×]², and (dD/dθ)/θ; infinite at the whole turns but 0."""

    def near(x: Number) -> tuple[Number, ...]:
        c2, c3, c4, c5, c6 = _stumpff(x)
        # D = −B₁/(2B) with B₁ = (dB/dθ)/θ; once more, B₂ = (dB₁/dθ)/θ.
        first, second = 2.0 * c4 - c3, 8.0 * c6 - 5.0 * c5 + c4
        return -0.5 * first / c2, 0.5 * (first * first - c2 * second) / (c2 * c2)

    def far(x: Number) -> tuple[Number, ...]:
        half = 0.5 * np.sqrt(x)
        product = half / np.tan(half)
        return (1.0 - product) / x, (np.square(half / np.sin(half)) + product - 2.0) / (x * x)

    return _by_size(square, near, far)


def _stumpff(x: Number) -> tuple[Number, ...]:
    """The functions c₂ … c₆, for x from 0 to π²."""
    c5, c6 = _series(x, 5), _series(x, 6)
    c4 = 1.0 / 24.0 - x * c6
    return 0.5 - x * c4, 1.0 / 6.0 - x * c5, c4, c5, c6


def _series(x: Number, k: int) -> Number:
    minus = -x
    last, *others = _FACTORS[k]
    total = minus * 0.0 + last
    for factor in others:
        total *= minus
        total += factor
    return total


def _B_and_C(x: Number) -> tuple[Number, Number]:
    angle = np.sqrt(x)
    return 2.0 * np.square(np.sin(0.5 * angle)) / x, (1.0 - np.sin(angle) / angle) / x


def _by_size(
    square: Floats, near: Callable[[Number], tuple[Number, ...]], far: Callable[[Number], tuple[Number, ...]]
) -> tuple[Floats, ...]:
    if square.size == 1:
        # The same formulas on a Python float, for which arrays would cost ten times as much.
        x = square.item()
        return tuple(np.full(square.shape, value) for value in (near if x <= _NEAR else far)(x))
    flat = square.reshape(-1)
    beyond = flat > _NEAR
    found = near(np.where(beyond, 0.0, flat))
    if beyond.any():
        for values, closed in zip(found, far(flat[beyond]), strict=True):
            values[beyond] = closed
    return tuple(values.reshape(square.shape) for values in found)
