"""An SVG drawing whose text remains text, and parallel projections of space onto it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Point = Sequence[float] | Floats

INK, PALE, LINE, BODY, PAPER = "#1f2937", "#6b7280", "#9ca3af", "#e5e7eb", "white"
RED, GREEN, BLUE, VIOLET, ORANGE = "#dc2626", "#15803d", "#2563eb", "#7c3aed", "#c2410c"
AXES = (RED, GREEN, BLUE)  # x, y, z


class Drawing:
    """A white card of shapes, in the order in which they are drawn.

    Args:
        width, height: its size in pixels.
        title: the text for screen readers.
    """

    def __init__(self, width: float, height: float, title: str) -> None:
        self._lines = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_n(width)} {_n(height)}" '
            'font-family="Helvetica, Arial, sans-serif" role="img" aria-labelledby="title">',
            f'<title id="title">{escape(title)}</title>',
            '<rect width="100%" height="100%" rx="8" fill="white"/>',
        ]

    def __str__(self) -> str:
        return "\n".join([*self._lines, "</svg>", ""])

    def path(
        self,
        points: Iterable[Point],
        *,
        stroke: str = "none",
        width: float = 1.5,
        fill: str = "none",
        closed: bool = False,
        dash: str = "",
        opacity: float = 1.0,
    ) -> None:
        """Draw straight lines from point to point."""
        d = "M " + " L ".join(_xy(point) for point in points) + (" Z" if closed else "")
        more = f' stroke-dasharray="{dash}"' if dash else ""
        more += f' fill-opacity="{_n(opacity)}"' if opacity < 1.0 else ""
        self._lines.append(
            f'<path d="{d}" fill="{fill}" stroke="{stroke}" stroke-width="{_n(width)}" '
            f'stroke-linejoin="round" stroke-linecap="round"{more}/>'
        )

    def line(self, a: Point, b: Point, colour: str, width: float = 1.5, dash: str = "") -> None:
        """Draw a straight line."""
        self.path([a, b], stroke=colour, width=width, dash=dash)

    def circle(self, at: Point, radius: float, fill: str, stroke: str = "none", width: float = 1.5) -> None:
        """Draw a circle."""
        x, y = _xy(at).split()
        self._lines.append(
            f'<circle cx="{x}" cy="{y}" r="{_n(radius)}" fill="{fill}" stroke="{stroke}" stroke-width="{_n(width)}"/>'
        )

    def arrow(
        self,
        points: Iterable[Point],
        colour: str,
        width: float = 2.0,
        *,
        head: float = 9.0,
        both: bool = False,
        dash: str = "",
    ) -> None:
        """Draw a straight or bent line with an arrow head at its end, or at both ends."""
        way = np.array([np.asarray(point, dtype=float) for point in points])
        heads = [_head(way, head)]
        way = _shortened(way, 0.7 * head)
        if both:
            heads.append(_head(way[::-1], head))
            way = _shortened(way[::-1], 0.7 * head)[::-1]
        self.path(way, stroke=colour, width=width, dash=dash)
        for corners in heads:
            self.path(corners, fill=colour, closed=True)

    def text(
        self,
        at: Point,
        words: str,
        size: float = 13.0,
        colour: str = INK,
        *,
        anchor: str = "start",
        weight: str = "400",
        halo: bool = False,
    ) -> None:
        """Draw text on a baseline at the point; text in `_{…}` is an index, text in `*…*` slanted."""
        x, y = _xy(at).split()
        more = ' paint-order="stroke" stroke="white" stroke-width="3.5" stroke-linejoin="round"' if halo else ""
        more += f' font-weight="{weight}"' if weight != "400" else ""
        self._lines.append(
            f'<text x="{x}" y="{y}" font-size="{_n(size)}" text-anchor="{anchor}" fill="{colour}"{more}>'
            f"{_marked(words)}</text>"
        )


@dataclass(frozen=True)
class View:
    """Parallel projection of space onto a drawing.

    Attributes:
        origin: position of the origin of space in the drawing.
        scale: pixels per unit of length.
        right, up: directions of space that are drawn to the right and upwards.
    """

    origin: Point
    scale: float
    right: Point
    up: Point

    @classmethod
    def around(cls, origin: Point, scale: float, azimuth: float, elevation: float) -> View:
        """Return a view from an azimuth, counted from x to y, and an elevation [deg]."""
        a, e = np.radians([azimuth, elevation])
        right = (-np.sin(a), np.cos(a), 0.0)
        return cls(origin, scale, right, (-np.cos(a) * np.sin(e), -np.sin(a) * np.sin(e), np.cos(e)))

    @property
    def towards(self) -> Floats:
        """The direction of space towards the reader."""
        return np.asarray(np.cross(self.right, self.up))

    def flat(self, points: ArrayLike) -> Floats:
        """Return points on the page, shape (..., 2)."""
        points = np.asarray(points, dtype=float)
        across, upwards = points @ np.asarray(self.right), points @ np.asarray(self.up)
        x, y = self.origin
        return np.stack([x + self.scale * across, y - self.scale * upwards], axis=-1)

    def triad(self, drawing: Drawing, T: Floats, length: float, width: float = 2.2) -> None:
        """Draw a frame: x red, y green, z blue; an axis towards the reader is a ring with a dot, away with a cross.

        Args:
            drawing: the drawing.
            T: the pose.
            length: length of the axes, in units of space.
            width: width of the lines in pixels.
        """
        start = self.flat(T[:3, 3])
        order = np.argsort(self.towards @ T[:3, :3])
        for k in order:
            axis, colour = T[:3, k], AXES[k]
            tip = self.flat(T[:3, 3] + length * axis)
            if abs(self.towards @ axis) > 0.97:
                _end_on(drawing, start, colour, width, towards=float(self.towards @ axis) > 0.0)
            else:
                drawing.arrow([start, tip], colour, width, head=3.6 * width)


def circle_points(centre: ArrayLike, a: ArrayLike, b: ArrayLike, start: float, end: float, n: int = 40) -> Floats:
    """Return an arc centre + a cos φ + b sin φ, φ from start to end [deg]; in space or in the plane, shape (n, ...)."""
    turn = np.radians(np.linspace(start, end, n))[:, None]
    return np.asarray(np.asarray(centre) + np.cos(turn) * np.asarray(a) + np.sin(turn) * np.asarray(b))


def _end_on(drawing: Drawing, at: Floats, colour: str, width: float, *, towards: bool) -> None:
    radius = 2.3 * width
    drawing.circle(at, radius, PAPER, colour, 0.7 * width)
    if towards:
        drawing.circle(at, 0.8 * width, colour)
        return
    for corner in ((1.0, 1.0), (1.0, -1.0)):
        half = 0.7 * radius * np.array(corner)
        drawing.line(at - half, at + half, colour, 0.6 * width)


def _head(way: Floats, size: float) -> list[Floats]:
    tip = way[-1]
    steps = np.linalg.norm(way - tip, axis=1)
    before = way[np.flatnonzero(steps >= min(size, steps.max()))[-1]]
    along = (tip - before) / np.linalg.norm(tip - before)
    across = np.array([-along[1], along[0]])
    foot = tip - size * along
    return [tip, foot + 0.42 * size * across, foot - 0.42 * size * across]


def _shortened(way: Floats, length: float) -> Floats:
    """Return a path without the part within a length of its end."""
    away = np.linalg.norm(way - way[-1], axis=1)
    last = int(np.flatnonzero(away >= min(length, 0.999 * away.max()))[-1])
    rest = (way[last + 1] if last + 1 < len(way) else way[-1]) - way[last]
    return np.vstack([way[: last + 1], way[last] + max(0.0, 1.0 - length / max(away[last], 1e-9)) * rest])


def _marked(words: str) -> str:
    """Return SVG text with indices and slanted words."""
    parts = re.split(r"(_\{[^}]*\}|\*[^*]*\*)", words)
    text, low = "", False
    for part in filter(None, parts):
        if part.startswith("_{"):
            text += f'<tspan dy="3.5" font-size="75%">{escape(part[2:-1])}</tspan>'
            low = True
            continue
        lifted = ' dy="-3.5"' if low else ""
        slanted = ' font-style="italic"' if part.startswith("*") else ""
        part = part.strip("*") if slanted else part
        text += f"<tspan{slanted}{lifted}>{escape(part)}</tspan>" if slanted or lifted else escape(part)
        low = False
    return text


def _xy(point: Point) -> str:
    return f"{_n(float(point[0]))} {_n(float(point[1]))}"


def _n(value: float) -> str:
    """Return a number with at most one decimal; no negative zero."""
    return f"{round(value, 1) + 0.0:g}" if abs(value) < 1e5 else f"{value:.1f}"
