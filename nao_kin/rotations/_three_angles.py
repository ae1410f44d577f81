"""The kernels behind the three-angle conventions: three turns composed, and taken apart again."""

from __future__ import annotations

import math

from nao_kin.rotations._kernels import Functions, Kernel, Number
from nao_kin.rotations._sequences import Convention

# Below this the two matrix entries that tell the first angle from the third are rounding errors of the matrix.
LOCK = 4.0 * 2.0**-52


def composition(convention: Convention) -> Kernel:
    """The kernel (α, β, γ in the order written) → the nine entries of R."""
    i, j, k, s = convention.i, convention.j, convention.k, convention.sign

    def kernel(f: Functions, *angles: Number) -> tuple[Number, ...]:
        first, middle, third = angles[::-1] if convention.reversed else angles
        # An odd permutation of the axes mirrors space, in which every angle changes its sign.
        ca, sa = f.cos(first), s * f.sin(first)
        cb, sb = f.cos(middle), s * f.sin(middle)
        cc, sc = f.cos(third), s * f.sin(third)
        m: list[Number] = [0.0] * 9
        if convention.symmetric:
            m[3 * i + i], m[3 * i + j], m[3 * i + k] = cb, sb * sc, sb * cc
            m[3 * j + i], m[3 * k + i] = sa * sb, 0.0 - ca * sb
            u, v = ca * cb, sa * cb
            m[3 * j + j], m[3 * j + k] = ca * cc - v * sc, 0.0 - ca * sc - v * cc
            m[3 * k + j], m[3 * k + k] = sa * cc + u * sc, u * cc - sa * sc
        else:
            m[3 * i + i], m[3 * i + j], m[3 * i + k] = cb * cc, 0.0 - cb * sc, sb
            m[3 * j + k], m[3 * k + k] = 0.0 - sa * cb, ca * cb
            u, v = ca * sb, sa * sb
            m[3 * j + i], m[3 * j + j] = ca * sc + v * cc, ca * cc - v * sc
            m[3 * k + i], m[3 * k + j] = sa * sc - u * cc, sa * cc + u * sc
        return tuple(m)

    return kernel


def extraction(convention: Convention, third_is_zero: bool) -> Kernel:
    """The kernel from nine entries to both triples and the lock mask; `third_is_zero` speaks of moving axes."""
    i, j, k, s = convention.i, convention.j, convention.k, convention.sign
    positive = s > 0.0

    def signed(value: Number) -> Number:
        # Adding 0.0 turns −0.0 into 0.0, which keeps atan2 off −π.
        return 0.0 + value if positive else 0.0 - value

    def kernel(f: Functions, *m: Number) -> tuple[Number, ...]:
        if convention.symmetric:
            y, x = 0.0 + m[3 * j + i], m[3 * k + i] * -s
        else:
            y, x = 0.0 - signed(m[3 * j + k]), m[3 * k + k]
        h = f.sqrt(x * x + y * y)
        locked = h <= LOCK
        some_locked = f.some(locked)
        if some_locked:
            x = f.where(locked, m[3 * j + j] if third_is_zero else 1.0, x)
            y = f.where(locked, signed(m[3 * k + j]) if third_is_zero else 0.0, y)
        first = f.atan2(y, x)
        # (x, y) is h (cos, sin) of the first angle: turning it out needs no division, for atan2 is blind to scale.
        y = signed(y)
        cosine = x * m[3 * j + j] + y * m[3 * k + j]
        if convention.symmetric:
            middle = f.atan2(h, m[3 * i + i])
            third = f.atan2(0.0 - signed(x * m[3 * j + k] + y * m[3 * k + k]), cosine)
            other_middle = 0.0 - middle
        else:
            middle = f.atan2(signed(m[3 * i + k]), h)
            third = f.atan2(signed(x * m[3 * j + i] + y * m[3 * k + i]), cosine)
            other_middle = f.where(middle < 0.0, -math.pi, math.pi) - middle
        if some_locked and third_is_zero:
            third = f.where(locked, 0.0, third)
        other_first, other_third = _opposite(f, first), _opposite(f, third)
        if convention.reversed:
            first, third, other_first, other_third = third, first, other_third, other_first
        return first, middle, third, other_first, other_middle, other_third, locked

    return kernel


def _opposite(f: Functions, angle: Number) -> Number:
    return angle + f.where(angle > 0.0, -math.pi, math.pi)
