"""From one pose to another along a screw."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats
from nao_kin._common.poses import join_poses
from nao_kin._common.vectors import as_batch, common_batch, cross, first_index, largest, norm, unit
from nao_kin.errors import BadArgument, at_index
from nao_kin.screws._exponential import log_parts, motion_of
from nao_kin.screws._poses import as_poses, turned

# As for slerp: beyond, the digits of the angle within a turn would be lost.
_LARGEST_PART = 1e15
# [m]; a motion whose screw axis is farther away is a translation.
FARTHEST_AXIS = 1e150


def sclerp(T_0: ArrayLike, T_1: ArrayLike, s: ArrayLike, *, longer: bool = False) -> Floats:
    """The pose a part s of the way from T_0 to T_1 along one screw, T_0 exp(s log(T_0⁻¹ T_1)), at constant speed.

    The body turns about a line and slides along it, both in proportion to s; the orientation is that of slerp. The
    path belongs to the motion, not to the frames: seen from another frame, or of another frame of the same body, it is
    the same.

    Args:
        T_0: poses at s = 0, shape (..., 4, 4).
        T_1: poses at s = 1; batch axes broadcast.
        s: shape (...), broadcasts with the poses; outside [0, 1] the motion goes on past its ends.
        longer: turn by θ − 2π about the same line instead of by θ ≤ π, with the same slide along it. At θ = π both
            ways are equally long, and the shorter one is about the axis whose first component that is not zero is
            positive, in frame 0.

    Returns:
        Poses, shape (..., 4, 4).

    Raises:
        NotARotation: the rotation part of some pose is none.
        BadArgument: s outside ±1e15; the last row of some pose is not (0, 0, 0, 1); or `longer` for two poses that
            differ by a translation alone, between which no line is distinguished.
        WrongShape, NotFinite: wrong or mismatched shapes, NaN or infinity.

    Source: Kavan, Collins, O'Sullivan and Zara, Dual quaternions for rigid transformation blending, TCD-CS-2006-46.

    Examples:
        >>> T_0, T_1 = np.eye(4), nk.screws.pose(nk.rotations.rot_z(np.pi), [2, 0, 0.4])
        >>> nk.screws.sclerp(T_0, T_1, [0.25, 0.5])[:, :3, 3]  # half a turn about the upright line through (1, 0, 0)
        array([[ 0.2929, -0.7071,  0.1   ],
               [ 1.    , -1.    ,  0.2   ]])
    """
    parts = as_batch(s, (), "s")
    if np.abs(parts).max(initial=0.0) > _LARGEST_PART:
        raise BadArgument(f"s must not exceed {_LARGEST_PART:.0e} in magnitude, for its digits would be lost")
    (R_0, p_0), (R_1, p_1) = as_poses(T_0, "T_0"), as_poses(T_1, "T_1")
    common_batch("T_0, T_1 and s", p_0.shape[:-1], p_1.shape[:-1], parts.shape)
    # From the difference of the points: two poses far from the origin of their frame may be close to each other.
    back = np.swapaxes(R_0, -1, -2)
    v, omega = log_parts(back @ R_1, turned(back, p_1 - p_0))
    if longer:
        v, omega = _the_other_way(v, omega)
    way = motion_of(parts[..., None] * v, parts[..., None] * omega)
    return join_poses(R_0 @ way[..., :3, :3], p_0 + turned(R_0, way[..., :3, 3]))


def _the_other_way(v: Floats, omega: Floats) -> tuple[Floats, Floats]:
    """The twist about the same screw axis with the angle θ − 2π and the same slide."""
    angle = norm(omega)
    turning = angle > 0.0
    e, _ = unit(np.where(turning[..., None], omega, 1.0), "axis")
    across = cross(cross(e, v), e)
    translation = ~turning | (largest(across) > FARTHEST_AXIS * angle)
    if translation.any():
        index = first_index(translation)
        raise BadArgument(
            f"the poses{at_index(index)} differ by a translation alone: no line is distinguished to turn about"
        )
    ratio = (1.0 - 2.0 * np.pi / angle)[..., None]
    return v - across + ratio * across, ratio * omega
