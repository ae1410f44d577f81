"""Shells lofted through sections: smooth bodies with a front, a back and two different sides."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from manifold3d import Manifold
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from nao_shapes.solids import from_triangles

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Section:
    """A cross-section: how far the body reaches to each side of the loft's axis [mm].

    Along z the sides are front, back, left, right (+x, -x, +y, -y); along x they are left, right, up, down
    (+y, -y, +z, -z).

    Attributes:
        at: its position on the axis.
        sides: the four reaches.
        power: 2 is an ellipse, larger is squarer.
    """

    at: float
    sides: tuple[float, float, float, float]
    power: float = 2.3


@dataclass(frozen=True)
class End:
    """The end of a loft: over `height` it curves in by the fraction `inset` of its reach; the rest is flat.

    Attributes:
        rings: cross-sections drawn in the curve.
    """

    height: float
    inset: float = 1.0
    rings: int = 3


def loft(
    sections: Sequence[Section],
    low: End,
    high: End,
    *,
    axis: Literal["x", "z"] = "z",
    grow: float = 0.0,
    around: int = 28,
    along: int = 5,
    press: Callable[[Floats], Floats] | None = None,
) -> Manifold:
    """Return the body through the sections, whose outline is a monotone cubic between them.

    Args:
        sections: ascending in `at`; the first and last are where the body ends.
        low: the end at the first section.
        high: the end at the last section.
        axis: the axis of the loft.
        grow: additional thickness everywhere, negative for a thinner body [mm].
        around: corners of a cross-section.
        along: cross-sections drawn between the ends.
        press: maps the points of the surface, shape (n, 3) to (n, 3), to press a flat face into a round body.
    """
    at = np.array([section.at for section in sections])
    table = np.array([(*section.sides, section.power) for section in sections])
    curve = PchipInterpolator(at, table)

    bottom, top = at[0], at[-1]
    levels = _levels(bottom, top, low, high, along)
    reach = curve(levels)
    squeeze = _closing((levels - bottom) / low.height, low.inset) * _closing((top - levels) / high.height, high.inset)
    sides = reach[:, :4] * squeeze[:, None]
    sides = np.where(sides > 1e-9, np.maximum(sides + grow, 0.05), 0.0)
    # Growing moves the ends out as well, in proportion to the body's length.
    middle, half = (bottom + top) / 2, (top - bottom) / 2
    levels = middle + (levels - middle) * (half + grow) / half

    angle = 2 * np.pi * np.arange(around) / around
    cos, sin = np.cos(angle), np.sin(angle)
    cos[np.abs(cos) < 1e-12] = 0.0
    sin[np.abs(sin) < 1e-12] = 0.0
    power = reach[:, 4:5]
    radius = (np.abs(cos) ** power + np.abs(sin) ** power) ** (-1 / power)
    u = radius * cos * np.where(cos >= 0, sides[:, 0:1], sides[:, 1:2])
    v = radius * sin * np.where(sin >= 0, sides[:, 2:3], sides[:, 3:4])
    rings = np.stack([u, v, np.broadcast_to(levels[:, None], u.shape)], axis=-1)
    middles = np.column_stack([np.zeros((len(levels), 2)), levels])
    # An end that closes to a point is a single point, not a ring of points.
    rings = rings[(sides > 0).any(axis=1)]
    vertices = np.concatenate([rings.reshape(-1, 3), middles[[0, -1]]])
    body = _skin(vertices if press is None else press(vertices), *rings.shape[:2])
    # (u, v, axis) are (x, y, z), or one step round for an axis along x: (y, z, x).
    return body if axis == "z" else body.transform(np.array([[0.0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0]]))


def _levels(bottom: float, top: float, low: End, high: End, along: int) -> Floats:
    """Return the heights of the rings: close together where the ends curve in."""
    lower = bottom + low.height * (1 - np.cos(np.linspace(0, np.pi / 2, low.rings + 1)))
    upper = top - high.height * (1 - np.cos(np.linspace(np.pi / 2, 0, high.rings + 1)))
    return np.concatenate([lower, np.linspace(lower[-1], upper[0], along + 2)[1:-1], upper])


def _closing(share: Floats, inset: float) -> Floats:
    rest = np.clip(1 - share, 0.0, 1.0)
    return np.asarray(1 - inset * (1 - np.sqrt(1 - rest**2)))


def _skin(vertices: Floats, count: int, around: int) -> Manifold:
    """Triangles between `count` neighbouring rings, and a fan from each end's middle, the last two vertices."""
    index = np.arange(count * around).reshape(count, around)
    beside = np.roll(index, -1, axis=1)
    a, b, c, d = index[:-1], beside[:-1], beside[1:], index[1:]
    quads = np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)
    fan_low = np.stack([beside[0], index[0], np.full(around, count * around)], axis=-1)
    fan_high = np.stack([index[-1], beside[-1], np.full(around, count * around + 1)], axis=-1)
    return from_triangles(vertices, np.concatenate([quads, fan_low, fan_high]))
