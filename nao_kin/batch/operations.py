"""The operations that a program is made of: each takes three-vectors of all configurations of a tile to new ones.

A register holds a three-vector of every configuration of a tile: all x, all y, all z. An operation is a row of
integers: its code, the rows of scratch memory where its registers begin (results d e f, operands p a b c), the row of a
sine or another number, and where its weights begin:

    TURN        d = cos a + sin b,  e = cos b − sin a: two columns of a matrix, turned about the third
    ADD_1…3     d = p + w₀ a + w₁ b + w₂ c
    SLIDE       d = p + w x a, with one number x for each configuration
    CROSS       d = p + w a × b
    PROJECT     d = (a·p, b·p, c·p): p in the axes a, b, c
    BASE        d e f are the columns of the matrix of a quaternion (x, y, z, w · scalar)
    HINGE       d = p + R a + w, with R the turn about the coordinate axis of number c
    MATRIX      d = p + W a, with a constant matrix
    QUATERNION  d = (r0, r1, r2), e = (r3, …): the unit quaternion of the matrix with the columns a b c
    RPY         d = roll, pitch and yaw of the matrix with the columns a b c
"""

from __future__ import annotations

from nao_kin.batch.functions import arc_tangent, compiled, length
from nao_kin.batch.lanes import Array, lane_count, load, spread, square_root, store, where_less
from nao_kin.batch.opcodes import (
    ADD_1,
    ADD_2,
    ADD_3,
    BASE,
    CROSS,
    HINGE,
    MATRIX,
    PROJECT,
    QUATERNION,
    SLIDE,
    TURN,
    VECTORS,
)

# Below this the entries of a matrix that tell yaw from roll are rounding errors.
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
        # The sign that makes the first part that is not zero positive.
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
    """As `nao_kin.rotations.rpy_from_matrix`: yaw first, turned out of the matrix, then pitch and roll."""
    n = lane_count(m)
    width = VECTORS * n
    zero, one = spread(m, 0.0), spread(m, 1.0)
    locked = spread(m, _LOCKED * 2.0**-52 if m.itemsize == 8 else _LOCKED * 2.0**-23)
    for i in range(0, width, n):
        j, k = i + width, i + 2 * width
        m00, m10, m20 = load(m, a + i), load(m, a + j), load(m, a + k)
        flat = length(m, m00, m10)
        x, y = where_less(locked, flat, m00, one), where_less(locked, flat, m10, zero)
        # (x, y) is a multiple of (cos yaw, sin yaw): turning it out needs no division.
        sine = x * load(m, c + j) - y * load(m, c + i)
        cosine = x * load(m, b + j) - y * load(m, b + i)
        store(m, d + i, arc_tangent(m, zero - sine, cosine) + zero)
        store(m, d + j, arc_tangent(m, zero - m20, flat) + zero)
        store(m, d + k, arc_tangent(m, y, x) + zero)
