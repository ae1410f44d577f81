"""Kernels from matrices to quaternions, and from quaternions to axes and half angles."""

from __future__ import annotations

from nao_kin._common.kernels import Functions, Number


def quaternion_of(f: Functions, *m: Number) -> tuple[Number, ...]:
    """The kernel from nine entries to the unit quaternion in canonical sign."""
    m00, m01, m02, m10, m11, m12, m20, m21, m22 = m
    # The symmetric matrix 4 r rᵀ.
    plus, minus = 1.0 + m00, 1.0 - m00
    sum_, difference = m11 + m22, m11 - m22
    d0, d1, d2, d3 = plus + sum_, plus - sum_, minus + difference, minus - difference
    d01, d02, d03 = m21 - m12, m02 - m20, m10 - m01
    d12, d13, d23 = m10 + m01, m02 + m20, m21 + m12
    upper = d0 >= d1
    a0, a1 = f.where(upper, d0, d01), f.where(upper, d01, d1)
    a2, a3 = f.where(upper, d02, d12), f.where(upper, d03, d13)
    lower = d2 >= d3
    b0, b1 = f.where(lower, d02, d03), f.where(lower, d12, d13)
    b2, b3 = f.where(lower, d2, d23), f.where(lower, d23, d3)
    first_pair = f.larger(d0, d1) >= f.larger(d2, d3)
    r0, r1 = f.where(first_pair, a0, b0), f.where(first_pair, a1, b1)
    r2, r3 = f.where(first_pair, a2, b2), f.where(first_pair, a3, b3)
    scale = _canonical_sign(f, r0, r1, r2) / f.sqrt(r0 * r0 + r1 * r1 + r2 * r2 + r3 * r3)
    # Adding 0.0 turns −0.0 into 0.0.
    return r0 * scale + 0.0, r1 * scale + 0.0, r2 * scale + 0.0, r3 * scale + 0.0


def axis_and_half_angle(f: Functions, r0: Number, r1: Number, r2: Number, r3: Number) -> tuple[Number, ...]:
    """The kernel from a quaternion to the unit vector along r, zero where r is, and atan2(‖r‖, r0)."""
    norm = f.sqrt(r1 * r1 + r2 * r2 + r3 * r3)
    unit: Number = 1.0
    tiny = norm < 1e-140
    if f.some(tiny):
        # The squares of the smallest angles underflow, unless taken in a larger unit.
        unit = f.where(tiny, 2.0**700, 1.0)
        r1, r2, r3 = r1 * unit, r2 * unit, r3 * unit
        norm = f.sqrt(r1 * r1 + r2 * r2 + r3 * r3)
    divisor = f.where(norm > 0.0, norm, 1.0)
    return r1 / divisor, r2 / divisor, r3 / divisor, f.atan2(norm / unit, r0)


def _canonical_sign(f: Functions, r0: Number, r1: Number, r2: Number) -> Number:
    # Where these three are zero the last component is the largest, hence a diagonal entry of 4 r rᵀ, and positive.
    first, zero = r0, r0 == 0.0
    if f.some(zero):
        first = f.where(zero, f.where(r1 != 0.0, r1, r2), r0)
    return f.where(first < 0.0, -1.0, 1.0)
