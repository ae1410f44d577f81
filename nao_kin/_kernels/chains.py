"""Poses of frames at the ends of chains of joints, and logarithms of rotations: scalar code for Python and Numba."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from nao_kin._kernels.cache import IntRow, Row, both_ways


class Chain(NamedTuple):
    """The joints between the base and each of several frames, one frame after another, as arrays."""

    joints: IntRow  # number of joints on the path to each frame
    links: Row  # placements before, between and after the joints of each frame: 3×4 by rows, joints + 1 of them
    slides: Row  # 1 for a prismatic joint, 0 for a revolute one
    place: IntRow  # index of the coordinate that moves a joint; −1 if none does
    ratio: Row  # value of a joint = ratio · coordinate + offset [rad or m]
    offset: Row


class FramePose(NamedTuple):
    """Pose of a frame in the base, 3×4 by rows, and the unit axes and origins of its joints, three numbers each."""

    T: Any
    axes: Any
    origins: Any


def chain_of(chains: Sequence[Any], names: Sequence[str]) -> Chain:
    """Join several `SerialChain`s into one `Chain`, moved by the coordinates with these names."""
    drivers = [driver for chain in chains for driver in chain.drivers]
    place = {name: k for k, name in enumerate(names)}
    return Chain(
        joints=np.array([len(chain.drivers) for chain in chains], dtype=np.int64),
        links=np.concatenate([chain.placements.reshape(-1) for chain in chains]),
        slides=np.concatenate([chain.slides for chain in chains]).astype(np.float64),
        place=np.array([place.get(driver.joint, -1) for driver in drivers], dtype=np.int64),
        ratio=np.array([driver.multiplier for driver in drivers], dtype=np.float64),
        offset=np.array([driver.offset for driver in drivers], dtype=np.float64),
    )


@both_ways
def to_frame(chain: Chain, values: Any, frame: int, first: int, out: Any) -> None:
    """Write the pose of a frame, and the axes and origins of its joints from the index `first` on, to `out`.

    `out` is a `FramePose` or another named tuple with its fields: passing these one by one slows the search by 7 %.
    """
    T, axes, origins = out.T, out.axes, out.origins
    last = first + chain.joints[frame]
    # Each frame has one more placement than joints.
    a = 12 * (first + frame)
    for i in range(12):
        T[i] = chain.links[a + i]
    for k in range(first, last):
        value = chain.offset[k]
        if chain.place[k] >= 0:
            value += chain.ratio[k] * values[chain.place[k]]
        for i in range(3):
            axes[3 * k + i], origins[3 * k + i] = T[4 * i + 2], T[4 * i + 3]
        if chain.slides[k] != 0.0:
            for i in range(3):
                T[4 * i + 3] += value * T[4 * i + 2]
        else:
            cosine, sine = math.cos(value), math.sin(value)
            for i in range(0, 12, 4):
                T[i], T[i + 1] = cosine * T[i] + sine * T[i + 1], cosine * T[i + 1] - sine * T[i]
        a += 12
        for i in range(0, 12, 4):
            x, y, z = T[i], T[i + 1], T[i + 2]
            T[i] = x * chain.links[a] + y * chain.links[a + 4] + z * chain.links[a + 8]
            T[i + 1] = x * chain.links[a + 1] + y * chain.links[a + 5] + z * chain.links[a + 9]
            T[i + 2] = x * chain.links[a + 2] + y * chain.links[a + 6] + z * chain.links[a + 10]
            T[i + 3] += x * chain.links[a + 3] + y * chain.links[a + 7] + z * chain.links[a + 11]


# --- Logarithms of rotations.


# Below this angle the closed form of J_l⁻¹ loses digits, and two terms of its series are exact to rounding [rad].
SMALL_ANGLE = 1e-2


@both_ways
def rotation_vector(
    m00: float, m01: float, m02: float, m10: float, m11: float, m12: float, m20: float, m21: float, m22: float
) -> tuple[float, float, float]:
    """Return the logarithm of a rotation from its unit quaternion: accurate at 0 and at π."""
    trace = m00 + m11 + m22
    # The quaternion times four times its largest component.
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
    # For a small angle the rotation vector is twice the vector part of the unit quaternion.
    scale = 2.0 * math.atan2(length, s) / length if length > 1e-150 else 2.0 / s
    return scale * x, scale * y, scale * z


@both_ways
def inverse_jacobian_factor(squares: float) -> float:
    """Return c = (1 − (φ/2) cot(φ/2))/φ² of J_l(v)⁻¹ = 1 − ½ [v×] + c [v×]², from φ² = v·v."""
    angle = math.sqrt(squares)
    if angle <= SMALL_ANGLE:
        return 1.0 / 12.0 + squares / 720.0
    return (1.0 - 0.5 * angle * math.cos(0.5 * angle) / math.sin(0.5 * angle)) / squares
