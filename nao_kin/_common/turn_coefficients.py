"""What stands before the powers of [v×] in the Jacobians of rotations and of rigid motions, right at every angle.

All of it follows from the functions cₖ(x) = Σ (−x)ⁿ/(2n + k)!, for x = φ² = ‖v‖²:
c₂ = (1 − cos φ)/φ², c₃ = (φ − sin φ)/φ³ and so on, with cₖ = 1/k! − x cₖ₊₂ and (dcₖ/dφ)/φ = k cₖ₊₂ − cₖ₊₁.
Up to φ = π the series of c₅ and c₆ converge without cancellation and the others follow; beyond, the closed forms do.

Source: Stumpff, Himmelsmechanik I, 1959, for the functions cₖ.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from nao_kin._common.kernels import Functions, Number

Numbers = tuple[Number, ...]

# At φ = π the first term left out is under 2⁻⁵³ of the sum.
_TERMS = 11
_FACTORS = {k: [1.0 / math.factorial(2 * n + k) for n in range(_TERMS, -1, -1)] for k in (5, 6)}
_NEAR = math.pi**2
# |sin(φ/2)|/(φ/2) up to which nothing tells φ from a multiple of 2π but rounding.
WHOLE_TURN = 4.0 * 2.0**-52


def jacobian_coefficients(f: Functions, square: Number) -> Numbers:
    """The kernel from φ² to B and C of the left Jacobian of SO(3), J(v) = 1 + B [v×] + C [v×]²."""
    return _by_size(f, square, lambda x: _stumpff(x)[:2], lambda x: _closed(f, x)[1:])


def jacobian_derivatives(f: Functions, square: Number) -> Numbers:
    """The kernel from φ² to B, C, (dB/dφ)/φ and (dC/dφ)/φ."""

    def near(x: Number) -> Numbers:
        c2, c3, c4, c5, _ = _stumpff(x)
        return c2, c3, 2.0 * c4 - c3, 3.0 * c5 - c4

    def far(x: Number) -> Numbers:
        A, B, C = _closed(f, x)
        return B, C, (A - 2.0 * B) / x, (B - 3.0 * C) / x

    return _by_size(f, square, near, far)


def inverse_coefficients(f: Functions, square: Number) -> Numbers:
    """The kernel from φ² to D of J(v)⁻¹ = 1 − ½ [v×] + D [v×]², to (dD/dφ)/φ, and to what is 0 at whole turns.

    That is sin(φ/2)/(φ/2), or 1 up to half a turn. Where it is `WHOLE_TURN` or less, D means nothing.
    """

    def near(x: Number) -> Numbers:
        c2, c3, c4, c5, c6 = _stumpff(x)
        # D = −B₁/(2B) with B₁ = (dB/dφ)/φ; once more, B₂ = (dB₁/dφ)/φ.
        first, second = 2.0 * c4 - c3, 8.0 * c6 - 5.0 * c5 + c4
        return -0.5 * first / c2, 0.5 * (first * first - c2 * second) / (c2 * c2), 1.0

    def far(x: Number) -> Numbers:
        half = 0.5 * f.sqrt(x)
        opening = f.sin(half) / half
        product = half / f.tan(half)
        return (1.0 - product) / x, (1.0 / (opening * opening) + product - 2.0) / (x * x), opening

    return _by_size(f, square, near, far)


def _stumpff(x: Number) -> Numbers:
    """The functions c₂ … c₆, for x from 0 to π²."""
    c5, c6 = _series(x, 5), _series(x, 6)
    c4 = 1.0 / 24.0 - x * c6
    return 0.5 - x * c4, 1.0 / 6.0 - x * c5, c4, c5, c6


def _series(x: Number, k: int) -> Number:
    minus = -x
    last, second, *others = _FACTORS[k]
    total = minus * last + second
    for factor in others:
        total *= minus
        total += factor
    return total


def _closed(f: Functions, x: Number) -> Numbers:
    """The quotient sin φ/φ, B and C, for x from π²."""
    angle = f.sqrt(x)
    A, half = f.sin(angle) / angle, f.sin(0.5 * angle)
    return A, 2.0 * half * half / x, (1.0 - A) / x


def _by_size(
    f: Functions, square: Number, near: Callable[[Number], Numbers], far: Callable[[Number], Numbers]
) -> Numbers:
    beyond = square > _NEAR
    found = near(f.where(beyond, 0.0, square))
    if not f.some(beyond):
        return found
    closed = far(f.where(beyond, square, _NEAR))
    return tuple(f.where(beyond, there, here) for there, here in zip(closed, found, strict=True))
