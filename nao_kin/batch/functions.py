"""Sine, cosine and arc tangent of vectors, to two units in the last place.

The arguments of sine and cosine are brought to ±π/4 by taking away whole quarter turns, π/2 in three parts whose
products with a count of turns are exact (Cody and Waite); then both are polynomials. The coefficients are those of
fdlibm and, for single precision and for the arc tangent, of Cephes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, TypeVar

from numba import njit

from nao_kin.batch.lanes import (
    Array,
    Lanes,
    following,
    nearest,
    negated_by_bit,
    spread,
    square_root,
    where_even,
    where_less,
    whole,
    with_sign,
)

# Up to here the parts of π/2 are exact; the arguments of larger ones are left to the C library.
FARTHEST = {8: 1e5, 4: 500.0}

_Function = TypeVar("_Function", bound=Callable[..., Any])


def compiled(function: _Function) -> _Function:
    """A part of the kernel: compiled with it, and put in its place."""
    made: _Function = njit(nogil=True, error_model="numpy", forceinline=True)(function)
    return made


@compiled
def sine_and_cosine(m: Array, x: Lanes) -> tuple[Lanes, Lanes]:
    """Sine and cosine of |x| ≤ FARTHEST; `m` is an array of the same kind of number."""
    if m.itemsize == 8:
        quarters = nearest(x * spread(m, 2.0 / math.pi))
        r = x - quarters * spread(m, 1.57079632673412561417)
        r = r - quarters * spread(m, 6.07710050630396597660e-11)
        r = r - quarters * spread(m, 2.02226624879595063154e-21)
        z = r * r
        p = spread(m, 1.58969099521155010221e-10) * z + spread(m, -2.50507602534068634195e-08)
        p = p * z + spread(m, 2.75573137070700676789e-06)
        p = p * z + spread(m, -1.98412698298579493134e-04)
        p = p * z + spread(m, 8.33333333332248946124e-03)
        p = p * z + spread(m, -1.66666666666666324348e-01)
        c = spread(m, -1.13596475577881948265e-11) * z + spread(m, 2.08757232129817482790e-09)
        c = c * z + spread(m, -2.75573143513906633035e-07)
        c = c * z + spread(m, 2.48015872894767294178e-05)
        c = c * z + spread(m, -1.38888888888741095749e-03)
        c = c * z + spread(m, 4.16666666666666019037e-02)
    else:
        quarters = nearest(x * spread(m, 2.0 / math.pi))
        r = x - quarters * spread(m, 1.5703125)
        r = r - quarters * spread(m, 4.83751296997070312500e-4)
        r = r - quarters * spread(m, 7.54953362047672271729e-8)
        r = r - quarters * spread(m, 2.56334406825708960298e-12)
        z = r * r
        p = spread(m, -1.9515295891e-4) * z + spread(m, 8.3321608736e-3)
        p = p * z + spread(m, -1.6666654611e-1)
        c = spread(m, 2.443315711809948e-5) * z + spread(m, -1.388731625493765e-3)
        c = c * z + spread(m, 4.166664568298827e-2)
    sine = r + r * z * p
    cosine = (c * z + spread(m, -0.5)) * z + spread(m, 1.0)
    turns = whole(quarters)
    return (
        negated_by_bit(turns, where_even(turns, sine, cosine)),
        negated_by_bit(following(turns), where_even(turns, cosine, sine)),
    )


@compiled
def arc_tangent(m: Array, y: Lanes, x: Lanes) -> Lanes:
    """The angle of the point (x, y), in [−π, π], as atan2 has it: zero at the origin, and with the sign of y."""
    zero, one = spread(m, 0.0), spread(m, 1.0)
    far_x, far_y = with_sign(x, one), with_sign(y, one)
    steep = where_less(far_x, far_y, one, zero)
    short, long = where_less(far_x, far_y, far_x, far_y), where_less(far_x, far_y, far_y, far_x)
    long = where_less(zero, long, long, one)
    t = short / long
    # Beyond tan π/8, the angle from π/4.
    corner = where_less(spread(m, 0.4142135623730950488), t, one, zero)
    t = where_less(zero, corner, (short - long) / (short + long), t)
    z = t * t
    p = spread(m, -8.750608600031904122785e-1) * z + spread(m, -1.615753718733365076637e1)
    p = p * z + spread(m, -7.500855792314704667340e1)
    p = p * z + spread(m, -1.228866684490136173410e2)
    p = p * z + spread(m, -6.485021904942025371773e1)
    q = z + spread(m, 2.485846490142306297962e1)
    q = q * z + spread(m, 1.650270098316988542046e2)
    q = q * z + spread(m, 4.328810604912902668951e2)
    q = q * z + spread(m, 4.853903996359136964868e2)
    q = q * z + spread(m, 1.945506571482613964425e2)
    angle = t * (z * p / q) + t
    angle = angle + corner * spread(m, math.pi / 4.0)
    angle = where_less(zero, steep, spread(m, math.pi / 2.0) - angle, angle)
    # A negative zero is left of the origin too.
    angle = where_less(with_sign(one, x), zero, spread(m, math.pi) - angle, angle)
    return with_sign(angle, y)


@compiled
def length(m: Array, x: Lanes, y: Lanes) -> Lanes:
    """√(x² + y²) of numbers of moderate size."""
    return square_root(x * x + y * y)
