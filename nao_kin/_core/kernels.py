"""Formulas that are written once, and evaluated for one rotation or for a million.

A kernel is a formula over single components, `kernel(f, m00, m01, …) -> (c0, c1, …)`. Its components are Python floats
(then `f` is `FLOATS`, the functions of `math`: one rotation takes a few microseconds) or contiguous arrays (then `f` is
`ARRAYS`, the ufuncs of NumPy). Batches are computed in chunks whose temporaries fit in the processor's cache.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats, first_index, largest
from nao_kin.errors import ZeroNorm

Number = Any  # a float or an array of floats: kernels are written once for both
Kernel = Callable[..., tuple[Number, ...]]

CHUNK = 8192

# Between these lengths the square is accurate.
SMALLEST_SQUARE, LARGEST_SQUARE = 1e-280, 1e280
SMALLEST_NORMAL = 2.0**-1022


class OutOfScale(Exception):
    """Raised by a kernel for a vector too short or too long to be squared; its caller rescales and calls again."""


@dataclass(frozen=True)
class Functions:
    """The functions a kernel may call besides + − × ÷ and comparison."""

    sqrt: Callable[[Number], Number]
    sin: Callable[[Number], Number]
    cos: Callable[[Number], Number]
    tan: Callable[[Number], Number]
    log: Callable[[Number], Number]
    atan2: Callable[[Number, Number], Number]
    larger: Callable[[Number, Number], Number]
    where: Callable[[Number, Number, Number], Number]
    some: Callable[[Number], object]  # true or false
    within: Callable[[Number, float], bool]

    def square(self, *components: Number) -> Number:
        """Return the sum of squares, or raise `OutOfScale` where it would not be accurate."""
        total = components[0] * components[0]
        for component in components[1:]:
            total = total + component * component
        if self.some(total < SMALLEST_SQUARE) or self.some(total > LARGEST_SQUARE):
            raise OutOfScale
        return total


def _choose(condition: bool, yes: float, no: float) -> float:
    return yes if condition else no


def _float_within(value: float, bound: float) -> bool:
    return -bound <= value <= bound


def _array_within(value: Any, bound: float) -> bool:
    # Written so that NaN, which min and max propagate, gives False.
    return bool(value.max() <= bound) and bool(value.min() >= -bound)


FLOATS = Functions(math.sqrt, math.sin, math.cos, math.tan, math.log, math.atan2, max, _choose, bool, _float_within)
ARRAYS = Functions(np.sqrt, np.sin, np.cos, np.tan, np.log, np.arctan2, np.maximum, np.where, np.any, _array_within)


def evaluate(kernel: Kernel, inputs: Sequence[Floats], *tails: tuple[int, ...]) -> list[Floats]:
    """Return the results of `kernel` for `inputs` (*batch, m_i): one array (*batch, *tail) for each of `tails`."""
    batch = inputs[0].shape[:-1]
    rows = [values.reshape(-1, values.shape[-1]) for values in inputs]
    count = len(rows[0])
    outs = [np.empty((count, math.prod(tail))) for tail in tails]
    if count == 1:
        components = [x for values in rows for x in values[0].tolist()]
        results = kernel(FLOATS, *components)
        for out in outs:
            out[0], results = results[: out.shape[1]], results[out.shape[1] :]
    else:
        targets = [column for out in outs for column in out.T]
        if count > CHUNK:
            keep_the_heap()
        # In case of overflow the kernel raises an error, which is more specific than a warning.
        with np.errstate(over="ignore", invalid="ignore"):
            for start in range(0, count, CHUNK):
                part = slice(start, start + CHUNK)
                columns = [column for values in rows for column in np.ascontiguousarray(values[part].T)]
                for target, result in zip(targets, kernel(ARRAYS, *columns), strict=True):
                    target[part] = result
    return [out.reshape((*batch, *tail)) for out, tail in zip(outs, tails, strict=True)]


def rescaled(vectors: Floats, what: str) -> Floats:
    """Return vectors (..., m) divided by their largest component, with lengths from 1 to √m; zero raises `ZeroNorm`."""
    size = largest(vectors)
    if not size.all():
        raise ZeroNorm(what, first_index(size == 0.0))
    return np.asarray(vectors / size[..., np.newaxis])


def keep_the_heap() -> None:
    """Free one large block, so that glibc keeps later temporaries: kernels run up to twice as fast."""
    np.empty(1 << 20)


# --- The coefficients of the powers of [v×] in the Jacobians of rotations and rigid motions, accurate at every angle.
#
# These coefficients follow from the functions cₖ(x) = Σ (−x)ⁿ/(2n + k)!, for x = φ² = ‖v‖²: c₂ = (1 − cos φ)/φ²,
# c₃ = (φ − sin φ)/φ³ and so on, with cₖ = 1/k! − x cₖ₊₂ and (dcₖ/dφ)/φ = k cₖ₊₂ − cₖ₊₁. Up to φ = π the series of c₅
# and c₆ converge without cancellation, and the others follow from them; beyond π the closed forms are used.
#
# Source: Stumpff, Himmelsmechanik I, 1959, for the functions cₖ.

Numbers = tuple[Number, ...]

# At φ = π the first term left out is under 2⁻⁵³ of the sum.
_TERMS = 11
_FACTORS = {k: [1.0 / math.factorial(2 * n + k) for n in range(_TERMS, -1, -1)] for k in (5, 6)}
_NEAR = math.pi**2
# |sin(φ/2)|/(φ/2) up to which φ is a multiple of 2π to rounding.
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
    """The kernel from φ² to D of J(v)⁻¹ = 1 − ½ [v×] + D [v×]², to (dD/dφ)/φ, and to a measure of regularity.

    The measure is 1 up to half a turn, and sin(φ/2)/(φ/2) beyond it. Where it is `WHOLE_TURN` or less, D is undefined.
    """

    def near(x: Number) -> Numbers:
        c2, c3, c4, c5, c6 = _stumpff(x)
        # D = −B₁/(2B) with B₁ = (dB/dφ)/φ; the derivative of D also needs B₂ = (dB₁/dφ)/φ.
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
    return tuple(f.where(beyond, x, y) for x, y in zip(closed, found, strict=True))
