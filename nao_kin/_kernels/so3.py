"""Rotations in scalar code, which runs as Python or compiled."""

from __future__ import annotations

import math

from nao_kin._kernels.cache import both_ways

# Under this angle the closed form of J_l⁻¹ loses digits, and two terms of its series are exact [rad].
SMALL_ANGLE = 1e-2


@both_ways
def rotation_vector(
    m00: float, m01: float, m02: float, m10: float, m11: float, m12: float, m20: float, m21: float, m22: float
) -> tuple[float, float, float]:
    """The logarithm of a rotation, by its unit quaternion: accurate at 0 and at π."""
    trace = m00 + m11 + m22
    # Four times the products of the largest component with all of them.
    if trace >= max(m00, m11, m22):
        s, x, y, z = 1.0 + trace, m21 - m12, m02 - m20, m10 - m01
    elif m00 >= max(m11, m22):
        s, x, y, z = m21 - m12, 1.0 + m00 - m11 - m22, m01 + m10, m02 + m20
    elif m11 >= m22:
        s, x, y, z = m02 - m20, m01 + m10, 1.0 + m11 - m00 - m22, m12 + m21
    else:
        s, x, y, z = m10 - m01, m02 + m20, m12 + m21, 1.0 + m22 - m00 - m11
    if s < 0.0:
        s, x, y, z = -s, -x, -y, -z
    length = math.sqrt(x * x + y * y + z * z)
    # Of a small angle the vector is twice the quaternion's.
    scale = 2.0 * math.atan2(length, s) / length if length > 1e-150 else 2.0 / s
    return scale * x, scale * y, scale * z


@both_ways
def inverse_jacobian_factor(squares: float) -> float:
    """C = (1 − (φ/2) cot(φ/2))/φ² of J_l(v)⁻¹ = 1 − ½ [v×] + c [v×]², from φ² = v·v."""
    angle = math.sqrt(squares)
    if angle <= SMALL_ANGLE:
        return 1.0 / 12.0 + squares / 720.0
    return (1.0 - 0.5 * angle * math.cos(0.5 * angle) / math.sin(0.5 * angle)) / squares
