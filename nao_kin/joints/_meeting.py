"""Where axes meet, and where three of them stop spanning space."""

from __future__ import annotations

import math

import numpy as np

from nao_kin._arrays import Floats
from nao_kin._vectors import dot, norm
from nao_kin.joints.pairs import PARALLEL
from nao_kin.lines import PluckerLine, common_normal

# Three turns reach every rotation only if consecutive axes are perpendicular; cos of the angle, as a rounding allows.
_PERPENDICULAR = 1e-9


def meeting_point(centres: Floats, axes: Floats) -> Floats:
    """The point nearest to all axes: for two, halfway along the common normal; for more, by least squares.

    Args:
        centres: a point on each axis, shape (n, 3); the first is the origin of the computation.
        axes: unit directions, no two neighbours parallel, shape (n, 3).
    """
    lines = PluckerLine.from_point_direction(centres, axes, origin=centres[0])
    if len(axes) == 2:
        normal = common_normal(lines[0], lines[1])
        return np.asarray(0.5 * (normal.foot_a + normal.foot_b))
    # Across its direction, a line pins a point down: (1 − e eᵀ) x = (1 − e eᵀ) p.
    across = np.eye(3) - axes[:, :, None] * axes[:, None, :]
    offsets = np.einsum("nij,nj->ni", across, centres - centres[0])
    solution, *_ = np.linalg.lstsq(across.reshape(-1, 3), offsets.reshape(-1), rcond=None)
    return np.asarray(centres[0] + solution)


def distances(point: Floats, centres: Floats, axes: Floats) -> Floats:
    """Distance of a point from each axis, shape (n,) [m]."""
    return norm(np.cross(centres - point, axes))


def angles_between(axes: Floats) -> Floats:
    """Angles between consecutive axes, shape (n − 1,), in [0, π] [rad]."""
    sines = norm(np.cross(axes[:-1], axes[1:]))
    return np.asarray(np.arctan2(sines, dot(axes[:-1], axes[1:])))


def spans_a_joint(axes: Floats) -> bool:
    """Whether turns about these axes through one point make a universal or a spherical joint."""
    between = angles_between(axes)
    if np.any(np.minimum(between, math.pi - between) < PARALLEL):
        return False
    return len(axes) == 2 or bool(np.all(np.abs(np.cos(between)) <= _PERPENDICULAR))


def lock_angles(axes: Floats) -> tuple[float, float]:
    """The two values of the middle angle, in (−π, π], at which the third axis is parallel to the first.

    With δ the angle from a1 to a3 about a2 they are −δ and π − δ.
    """
    first, second, third = axes
    delta = math.atan2(float(second @ np.cross(first, third)), float(first @ third))
    lower, upper = sorted(_wrapped(angle) + 0.0 for angle in (-delta, math.pi - delta))
    return lower, upper


def _wrapped(angle: float) -> float:
    return angle - 2.0 * math.pi * math.ceil((angle - math.pi) / (2.0 * math.pi))
