"""The operations of a program: each computes new three-vectors of all configurations of a tile.

A register holds a three-vector of every configuration of a tile: all x, all y, all z. An operation is a row of
integers: its code, the rows of scratch memory where its registers begin (results d e f, operands p a b c), the row of a
sine or another number, and the index of its first weight:

    TURN        d = cos a + sin b,  e = cos b − sin a: two columns of a matrix, rotated about the third
    ADD_1…3     d = p + w₀ a + w₁ b + w₂ c
    SLIDE       d = p + w x a, with one number x for each configuration
    CROSS       d = p + w a × b
    PROJECT     d = (a·p, b·p, c·p): p in the axes a, b, c
    BASE        d e f are the columns of the matrix of a quaternion (x, y, z, w · scalar)
    HINGE       d = p + R a + w, with R the rotation about the coordinate axis of number c
    MATRIX      d = p + W a, with a constant matrix
    QUATERNION  d = (r0, r1, r2), e = (r3, …): the unit quaternion of the matrix with the columns a b c
    RPY         d = roll, pitch and yaw of the matrix with the columns a b c
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any, TypeVar

import numba
import numpy as np
from numba import njit, types

from nao_kin._kernels.cache import CachedKernel, numba_type
from nao_kin._kernels.lanes_llvm import (
    Array,
    Lanes,
    following,
    lane_count,
    larger,
    largest,
    load,
    magnitude_bits,
    nearest,
    negated_by_bit,
    read_columns,
    spread,
    square_root,
    store,
    where_even,
    where_less,
    whole,
    with_sign,
    write_fours,
)
from nao_kin._kernels.program import (
    ADD_1,
    ADD_2,
    ADD_3,
    BASE,
    CROSS,
    FARTHEST,
    HINGE,
    MATRIX,
    PROJECT,
    QUATERNION,
    SLIDE,
    TURN,
    VECTORS,
    Tables,
)

# --- Sine, cosine and arc tangent of vectors, to two units in the last place.
#
# The arguments of sine and cosine are brought to ±π/4 by subtracting whole quarter turns, π/2 in three parts whose
# products with a count of turns are exact (Cody and Waite); then both are polynomials. The coefficients are those of
# fdlibm and, for single precision and for the arc tangent, of Cephes.

_Function = TypeVar("_Function", bound=Callable[..., Any])


def compiled(function: _Function) -> _Function:
    """Compile a function that is inlined into the kernel."""
    made: _Function = njit(nogil=True, error_model="numpy", forceinline=True)(function)
    return made


@compiled
def sine_and_cosine(m: Array, x: Lanes) -> tuple[Lanes, Lanes]:
    """Return sine and cosine of |x| ≤ FARTHEST; `m` is an array of the same kind of number."""
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
    """Return the angle of the point (x, y) in [−π, π], like atan2: zero at the origin, with the sign of y."""
    zero, one = spread(m, 0.0), spread(m, 1.0)
    far_x, far_y = with_sign(x, one), with_sign(y, one)
    steep = where_less(far_x, far_y, one, zero)
    short, long = where_less(far_x, far_y, far_x, far_y), where_less(far_x, far_y, far_y, far_x)
    long = where_less(zero, long, long, one)
    t = short / long
    # Beyond tan π/8, the angle is measured from π/4.
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
    # A negative zero counts as left of the origin.
    angle = where_less(with_sign(one, x), zero, spread(m, math.pi) - angle, angle)
    return with_sign(angle, y)


@compiled
def length(m: Array, x: Lanes, y: Lanes) -> Lanes:
    """Return √(x² + y²) of numbers of moderate size."""
    return square_root(x * x + y * y)


# --- The operations of a program, on the registers of a tile.

# Matrix entries that distinguish yaw and roll are rounding errors below this number of units of rounding.
_LOCKED = 4.0


@compiled
def perform(m: Array, operations: Array, weights: Array) -> None:
    """Perform all operations of a program on the registers in `m`."""
    width = VECTORS * lane_count(m)
    for k in range(len(operations)):
        code, d, p, a = operations[k, 0], width * operations[k, 1], width * operations[k, 4], width * operations[k, 5]
        b, c, x, w = width * operations[k, 6], width * operations[k, 7], width * operations[k, 8], operations[k, 9]
        e, f = width * operations[k, 2], width * operations[k, 3]
        if code == TURN:
            _turn(m, d, e, a, b, x)
        elif code == ADD_1:
            _add_1(m, d, p, a, weights[w])
        elif code == ADD_2:
            _add_2(m, d, p, a, b, weights[w], weights[w + 1])
        elif code == ADD_3:
            _add_3(m, d, p, a, b, c, weights[w], weights[w + 1], weights[w + 2])
        elif code == SLIDE:
            _slide(m, d, p, a, x, weights[w])
        elif code == CROSS:
            _cross(m, d, p, a, b, weights[w])
        elif code == PROJECT:
            _project(m, d, p, a, b, c)
        elif code == HINGE:
            _hinge(m, d, p, a, operations[k, 7], x, weights, w)
        elif code == MATRIX:
            _matrix(m, d, p, a, weights, w)
        elif code == BASE:
            _base(m, d, e, f, x, weights[w])
        elif code == QUATERNION:
            _quaternion(m, d, e, a, b, c)
        else:
            _rpy(m, d, a, b, c)


@compiled
def _turn(m: Array, d: int, e: int, a: int, b: int, x: int) -> None:
    n = lane_count(m)
    width = VECTORS * n
    for i in range(0, width, n):
        sine, cosine = load(m, x + i), load(m, x + width + i)
        for k in range(i, 3 * width, width):
            u, v = load(m, a + k), load(m, b + k)
            store(m, d + k, cosine * u + sine * v)
            store(m, e + k, cosine * v - sine * u)


@compiled
def _add_1(m: Array, d: int, p: int, a: int, w: float) -> None:
    n = lane_count(m)
    first = spread(m, w)
    for i in range(0, 3 * VECTORS * n, n):
        store(m, d + i, load(m, p + i) + first * load(m, a + i))


@compiled
def _add_2(m: Array, d: int, p: int, a: int, b: int, w: float, v: float) -> None:
    n = lane_count(m)
    first, second = spread(m, w), spread(m, v)
    for i in range(0, 3 * VECTORS * n, n):
        store(m, d + i, load(m, p + i) + first * load(m, a + i) + second * load(m, b + i))


@compiled
def _add_3(m: Array, d: int, p: int, a: int, b: int, c: int, w: float, v: float, u: float) -> None:
    n = lane_count(m)
    first, second, third = spread(m, w), spread(m, v), spread(m, u)
    for i in range(0, 3 * VECTORS * n, n):
        total = load(m, p + i) + first * load(m, a + i) + second * load(m, b + i) + third * load(m, c + i)
        store(m, d + i, total)


@compiled
def _slide(m: Array, d: int, p: int, a: int, x: int, w: float) -> None:
    n = lane_count(m)
    width = VECTORS * n
    weight = spread(m, w)
    for i in range(0, width, n):
        number = weight * load(m, x + i)
        for k in range(i, 3 * width, width):
            store(m, d + k, load(m, p + k) + number * load(m, a + k))


@compiled
def _cross(m: Array, d: int, p: int, a: int, b: int, w: float) -> None:
    n = lane_count(m)
    width = VECTORS * n
    weight = spread(m, w)
    for i in range(0, width, n):
        j, k = i + width, i + 2 * width
        ax, ay, az = load(m, a + i), load(m, a + j), load(m, a + k)
        bx, by, bz = load(m, b + i), load(m, b + j), load(m, b + k)
        store(m, d + i, load(m, p + i) + weight * (ay * bz - az * by))
        store(m, d + j, load(m, p + j) + weight * (az * bx - ax * bz))
        store(m, d + k, load(m, p + k) + weight * (ax * by - ay * bx))


@compiled
def _project(m: Array, d: int, p: int, a: int, b: int, c: int) -> None:
    n = lane_count(m)
    width = VECTORS * n
    for i in range(0, width, n):
        j, k = i + width, i + 2 * width
        u, v, w = load(m, p + i), load(m, p + j), load(m, p + k)
        store(m, d + i, load(m, a + i) * u + load(m, a + j) * v + load(m, a + k) * w)
        store(m, d + j, load(m, b + i) * u + load(m, b + j) * v + load(m, b + k) * w)
        store(m, d + k, load(m, c + i) * u + load(m, c + j) * v + load(m, c + k) * w)


@compiled
def _base(m: Array, d: int, e: int, f: int, x: int, sign: float) -> None:
    n = lane_count(m)
    width = VECTORS * n
    one, two = spread(m, 1.0), spread(m, 2.0)
    for i in range(0, width, n):
        j, k = i + width, i + 2 * width
        q1, q2, q3, q0 = load(m, x + i), load(m, x + j), load(m, x + k), spread(m, sign) * load(m, x + k + width)
        scale = two / (q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3)
        s1, s2, s3 = q1 * scale, q2 * scale, q3 * scale
        store(m, d + i, one - (s2 * q2 + s3 * q3))
        store(m, d + j, s1 * q2 + s3 * q0)
        store(m, d + k, s1 * q3 - s2 * q0)
        store(m, e + i, s1 * q2 - s3 * q0)
        store(m, e + j, one - (s1 * q1 + s3 * q3))
        store(m, e + k, s2 * q3 + s1 * q0)
        store(m, f + i, s1 * q3 + s2 * q0)
        store(m, f + j, s2 * q3 - s1 * q0)
        store(m, f + k, one - (s1 * q1 + s2 * q2))


@compiled
def _hinge(m: Array, d: int, p: int, a: int, axis: int, x: int, weights: Array, w: int) -> None:
    n = lane_count(m)
    width = VECTORS * n
    u, v = (axis + 1) % 3, (axis + 2) % 3
    tu, tv, ta = spread(m, weights[w + u]), spread(m, weights[w + v]), spread(m, weights[w + axis])
    u, v, axis = u * width, v * width, axis * width
    for i in range(0, width, n):
        sine, cosine = load(m, x + i), load(m, x + width + i)
        au, av = load(m, a + u + i), load(m, a + v + i)
        store(m, d + u + i, load(m, p + u + i) + tu + cosine * au - sine * av)
        store(m, d + v + i, load(m, p + v + i) + tv + sine * au + cosine * av)
        store(m, d + axis + i, load(m, p + axis + i) + ta + load(m, a + axis + i))


@compiled
def _matrix(m: Array, d: int, p: int, a: int, weights: Array, w: int) -> None:
    n = lane_count(m)
    width = VECTORS * n
    for r in range(3):
        first, second, third = (
            spread(m, weights[w + 3 * r]),
            spread(m, weights[w + 3 * r + 1]),
            spread(m, weights[w + 3 * r + 2]),
        )
        for i in range(0, width, n):
            k = r * width + i
            total = first * load(m, a + i) + second * load(m, a + width + i) + third * load(m, a + 2 * width + i)
            store(m, d + k, load(m, p + k) + total)


@compiled
def _quaternion(m: Array, d: int, e: int, a: int, b: int, c: int) -> None:
    """As `nao_kin.rotations.quat_from_matrix`: the row of 4 r rᵀ with the largest diagonal entry, normalised."""
    n = lane_count(m)
    width = VECTORS * n
    zero, one = spread(m, 0.0), spread(m, 1.0)
    for i in range(0, width, n):
        j, k = i + width, i + 2 * width
        m00, m10, m20 = load(m, a + i), load(m, a + j), load(m, a + k)
        m01, m11, m21 = load(m, b + i), load(m, b + j), load(m, b + k)
        m02, m12, m22 = load(m, c + i), load(m, c + j), load(m, c + k)
        d0, d1 = (one + m00) + (m11 + m22), (one + m00) - (m11 + m22)
        d2, d3 = (one - m00) + (m11 - m22), (one - m00) - (m11 - m22)
        d01, d02, d03 = m21 - m12, m02 - m20, m10 - m01
        d12, d13, d23 = m10 + m01, m02 + m20, m21 + m12
        a0, a1 = where_less(d0, d1, d01, d0), where_less(d0, d1, d1, d01)
        a2, a3 = where_less(d0, d1, d12, d02), where_less(d0, d1, d13, d03)
        b0, b1 = where_less(d2, d3, d03, d02), where_less(d2, d3, d13, d12)
        b2, b3 = where_less(d2, d3, d23, d2), where_less(d2, d3, d3, d23)
        upper, lower = where_less(d0, d1, d1, d0), where_less(d2, d3, d3, d2)
        r0, r1 = where_less(upper, lower, b0, a0), where_less(upper, lower, b1, a1)
        r2, r3 = where_less(upper, lower, b2, a2), where_less(upper, lower, b3, a3)
        # The sign that makes the first non-zero component positive.
        nonzero = where_less(zero, r1 * r1, r1, r2)
        nonzero = where_less(zero, r0 * r0, r0, nonzero)
        sign = where_less(nonzero, zero, zero - one, one)
        scale = sign / square_root(r0 * r0 + r1 * r1 + r2 * r2 + r3 * r3)
        store(m, d + i, r0 * scale + zero)
        store(m, d + j, r1 * scale + zero)
        store(m, d + k, r2 * scale + zero)
        store(m, e + i, r3 * scale + zero)


@compiled
def _rpy(m: Array, d: int, a: int, b: int, c: int) -> None:
    """As `nao_kin.rotations.rpy_from_matrix`: yaw first, then pitch and roll of the matrix without yaw."""
    n = lane_count(m)
    width = VECTORS * n
    zero, one = spread(m, 0.0), spread(m, 1.0)
    locked = spread(m, _LOCKED * 2.0**-52 if m.itemsize == 8 else _LOCKED * 2.0**-23)
    for i in range(0, width, n):
        j, k = i + width, i + 2 * width
        m00, m10, m20 = load(m, a + i), load(m, a + j), load(m, a + k)
        flat = length(m, m00, m10)
        x, y = where_less(locked, flat, m00, one), where_less(locked, flat, m10, zero)
        # (x, y) is a multiple of (cos yaw, sin yaw): removing yaw needs no division.
        sine = x * load(m, c + j) - y * load(m, c + i)
        cosine = x * load(m, b + j) - y * load(m, b + i)
        store(m, d + i, arc_tangent(m, zero - sine, cosine) + zero)
        store(m, d + j, arc_tangent(m, zero - m20, flat) + zero)
        store(m, d + k, arc_tangent(m, y, x) + zero)


# --- A program run on many configurations, a tile of them at a time.
#
# For each tile the configurations are read as columns, one row of the scratch memory for each number of a
# configuration; sines and cosines are computed; the operations follow; and the rows of the result are written, one
# configuration after another. The result of a configuration does not depend on its place in a tile or on the others.

_FARTHEST_DOUBLE, _FARTHEST_SINGLE = FARTHEST[8], FARTHEST[4]


def run(q: Array, v: Array, a: Array, tables: Tables, m: Array, out: Array, far: int) -> int:
    """Run a program on all configurations; return the bits of the largest magnitude of the inputs.

    q, v and a have one configuration after another, v and a are empty if not used; `m` is scratch memory, a tile for
    each row, with the constant registers filled; above the magnitude with the bits `far`, angles are too large for
    polynomials.
    """
    n = lane_count(m)
    width = VECTORS * n
    inputs = q, v, a
    angles, ratios = tables.angles, tables.ratios
    count = out.size // len(tables.sources)
    peak = 0
    for first in range(0, count, width):
        size = min(width, count - first)
        bits = magnitude_bits(spread(m, 0.0))
        for k in range(3):
            numbers, at = tables.widths[k], tables.inputs[k] * width
            if numbers:
                _read(inputs[k], numbers, first, size, m, at)
                for i in range(at, at + numbers * width, n):
                    bits = larger(bits, magnitude_bits(load(m, i)))
        top = largest(bits)
        peak = max(peak, top)
        for k in range(len(angles)):
            ratio, offset = spread(m, ratios[k, 0]), spread(m, ratios[k, 1])
            for i in range(0, width, n):
                sine, cosine = sine_and_cosine(m, load(m, angles[k, 0] * width + i) * ratio + offset)
                store(m, angles[k, 1] * width + i, sine)
                store(m, (angles[k, 1] + 1) * width + i, cosine)
        if top > far:
            _far_angles(m, angles, ratios)
        perform(m, tables.operations, tables.weights)
        _write(m, tables.sources, out, first, size)
    return peak


@compiled
def _read(values: Array, numbers: int, first: int, size: int, m: Array, at: int) -> None:
    """Write the numbers of a tile as rows of `m`, with zeros after the last configuration."""
    n = lane_count(m)
    width = VECTORS * n
    if size == width and numbers >= n:
        for i in range(0, width, n):
            for k in range(0, numbers, n):
                # The last block overlaps the previous one rather than reading past the end.
                column = min(k, numbers - n)
                read_columns(values, (first + i) * numbers + column, numbers, m, at + column * width + i, width)
        return
    for k in range(numbers):
        for i in range(size):
            m[at + k * width + i] = values[(first + i) * numbers + k]
        for i in range(size, width):
            m[at + k * width + i] = 0.0


@compiled
def _write(m: Array, sources: Array, out: Array, first: int, size: int) -> None:
    """Write the rows of `m` that make up the result, configuration by configuration."""
    n = lane_count(m)
    width = VECTORS * n
    numbers = len(sources)
    if size == width and numbers >= 4:
        for i in range(0, width, n):
            for k in range(0, numbers, 4):
                column = min(k, numbers - 4)
                write_fours(m, sources, column, width, i, out, (first + i) * numbers + column, numbers)
        return
    for i in range(size):
        for k in range(numbers):
            out[(first + i) * numbers + k] = m[sources[k] * width + i]


@compiled
def _far_angles(m: Array, angles: Array, ratios: Array) -> None:
    """Write sines and cosines of angles too large for the polynomials, by the C library in double precision."""
    width = VECTORS * lane_count(m)
    farthest = _FARTHEST_DOUBLE if m.itemsize == 8 else _FARTHEST_SINGLE
    for k in range(len(angles)):
        for i in range(width):
            x = m[angles[k, 0] * width + i] * ratios[k, 0] + ratios[k, 1]
            if abs(x) > farthest and math.isfinite(x):
                m[angles[k, 1] * width + i] = math.sin(x)
                m[(angles[k, 1] + 1) * width + i] = math.cos(x)


def signature(given: np.dtype[Any], computed: np.dtype[Any]) -> Any:
    """Return the types of `run` for inputs in one precision, computed in the same precision or in single precision."""
    values = types.Array(numba.from_dtype(given), 1, "C", readonly=True)
    memory = types.Array(numba.from_dtype(computed), 1, "C")
    return types.int64(values, values, values, numba_type(Tables), memory, memory, types.int64)


# The precisions of inputs and results for which the kernel is compiled.
_DOUBLE, _SINGLE = np.dtype(np.float64), np.dtype(np.float32)
RUNS = {
    precisions: CachedKernel(
        run, f"the batch kernel, {name} precision", f"batch kernel, {name} precision", partial(signature, *precisions)
    )
    for precisions, name in (
        ((_DOUBLE, _DOUBLE), "double"),
        ((_DOUBLE, _SINGLE), "double to single"),
        ((_SINGLE, _SINGLE), "single"),
    )
}
