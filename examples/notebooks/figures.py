"""Small figures of frames, rotations, lines and robots for the notebooks beside this file, in parallel projection.

Axes are red, green and blue for x, y and z, with letters at the tips and different brightness, so that they can be told
apart in black and white.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib.patheffects as effects
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import FancyArrowPatch, Polygon
from numpy.typing import ArrayLike, NDArray

from nao_kin.robot import RobotModel
from nao_kin.rotations import matrix_from_natural
from nao_kin.screws.lines import PluckerLine

X, Y, Z = np.eye(3)
ORIGIN, AT_REST = np.zeros(3), np.eye(3)
COLOURS = ("#d62728", "#35b04a", "#1640b0")
GREY, DARK, ACCENT = "#9a9a9a", "#333333", "#8a3fa0"

# A paper dart: nose along x, left wing towards y, fin along z.
NOSE, TAIL, FIN = (0.8, 0.0, 0.0), (-0.45, 0.0, 0.0), (-0.45, 0.0, 0.4)
LEFT, RIGHT = (-0.45, 0.5, 0.0), (-0.45, -0.5, 0.0)
DART = np.array([[NOSE, LEFT, TAIL], [NOSE, TAIL, RIGHT], [NOSE, TAIL, FIN]])


def use_style() -> None:
    """Set the fonts, sizes and line widths of the notebooks, which keep small pictures legible."""
    plt.rcParams.update(
        {
            "figure.dpi": 100,
            "font.size": 10,
            "axes.titlesize": 10,
            "axes.spines.top": False,
            "axes.spines.right": False,
            "axes.grid": True,
            "grid.alpha": 0.3,
            "lines.linewidth": 1.8,
            "legend.frameon": False,
            "figure.constrained_layout.use": True,
        }
    )


def scenes(
    titles: Sequence[str], *, size: float = 1.2, width: float = 1.25, scale: float = 1.1, **view: Any
) -> list[Scene]:
    """Return a row of empty scenes, one for each title.

    Args:
        titles: titles of the scenes.
        size: half the height of the view.
        width: half its width.
        scale: inches per unit.
        view: the other attributes of `Scene`.
    """
    figsize = (2 * scale * width * len(titles), 2 * scale * size + 0.3)
    row = plt.subplots(1, len(titles), figsize=figsize, squeeze=False)[1][0]
    return [Scene(axes, title, size=size, width=width, **view) for axes, title in zip(row, titles, strict=True)]


@dataclass
class Scene:
    """A picture in the coordinates of the room: x to the front left, y to the right, z up.

    Attributes:
        axes: the matplotlib axes.
        title: title of the picture.
        size: half the height of the view.
        centre: point of the room at the centre of the picture.
        azimuth, elevation: direction from the origin to the viewer [°].
        width: half the width of the view; None for that of the height.
    """

    axes: plt.Axes
    title: str = ""
    size: float = 1.35
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)
    azimuth: float = 33.0
    elevation: float = 24.0
    width: float | None = None

    def __post_init__(self) -> None:
        a, e = np.radians([self.azimuth, self.elevation])
        towards_viewer = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
        right = np.array([-np.sin(a), np.cos(a), 0.0])
        self._to_picture = np.array([right, np.cross(towards_viewer, right), towards_viewer])
        width = self.size if self.width is None else self.width
        self.axes.set(xlim=(-width, width), ylim=(-self.size, self.size), aspect="equal", title=self.title)
        self.axes.axis("off")

    def seen(self, points: ArrayLike) -> tuple[NDArray[np.float64], float]:
        """Return points in the picture, and their mean nearness to the viewer."""
        picture = (np.asarray(points, dtype=float) - self.centre) @ self._to_picture.T
        return picture[..., :2], float(np.mean(picture[..., 2])) / self.size

    def label(self, at: ArrayLike, text: str, colour: str = DARK, away: ArrayLike | None = None) -> None:
        """Write text at a point, moved aside in the direction `away` of the room."""
        place, _ = self.seen(at)
        step = np.zeros(2)
        if away is not None:
            step = self.seen(np.asarray(at) + away)[0] - place
            step *= 11 / max(float(np.linalg.norm(step)), 1e-9)
        how = {"color": colour, "ha": "center", "va": "center", "zorder": 40, "annotation_clip": False}
        halo = [effects.withStroke(linewidth=2.5, foreground="white")]
        self.axes.annotate(text, place, step, textcoords="offset points", path_effects=halo, **how)

    def path(
        self, points: ArrayLike, colour: str = DARK, *, width: float = 1.8, style: str = "-", order: float | None = None
    ) -> None:
        """Draw a line through points; a higher order is drawn later."""
        places, depth = self.seen(points)
        order = 20 + depth if order is None else order
        self.axes.plot(*places.T, style, color=colour, linewidth=width, zorder=order, solid_capstyle="round")

    def dot(self, at: ArrayLike, text: str = "", colour: str = DARK, away: ArrayLike = X) -> None:
        """Draw a point and its name."""
        self.axes.plot(*self.seen(at)[0], "o", color=colour, markersize=5, zorder=30)
        if text:
            self.label(at, text, colour, away)

    def arrow(
        self,
        vector: ArrayLike,
        colour: str,
        text: str = "",
        *,
        at: ArrayLike = ORIGIN,
        width: float = 2.0,
        style: str = "-",
    ) -> None:
        """Draw a vector from a point, with its name at the tip; nothing if it points at the viewer."""
        start, tip = np.asarray(at, dtype=float), np.asarray(at, dtype=float) + vector
        places, depth = self.seen(np.array([start, tip]))
        if np.linalg.norm(places[1] - places[0]) > 0.02 * self.size:
            self._arrow(places, colour, width, style, 20 + depth)
            self.label(tip, text, colour, vector)

    def frame(
        self,
        R: ArrayLike = AT_REST,
        *,
        at: ArrayLike = ORIGIN,
        names: str | tuple[str, ...] = "xyz",
        length: float = 1.0,
        of_the_room: bool = False,
    ) -> None:
        """Draw the axes of a frame, the columns of R; those of the room are thin and dashed."""
        for axis, colour, name in zip(np.transpose(R), COLOURS, names or ("", "", ""), strict=True):
            if of_the_room:
                self.path(np.array([at, at + length * axis]), colour, width=1.0, style="--", order=5)
                self.label(at + length * axis, name, colour, axis)
            else:
                self.arrow(length * axis, colour, name, at=at, width=2.2)

    def dart(self, R: ArrayLike = AT_REST, *, at: ArrayLike = ORIGIN, scale: float = 1.0) -> None:
        """Draw a paper dart with its nose along x, its left wing along y and its fin along z."""
        for face, shade in zip(scale * DART @ np.transpose(R) + at, ("#dddddd", "#c4c4c4", "#a8a8a8"), strict=True):
            places, depth = self.seen(face)
            self.axes.add_patch(Polygon(places, facecolor=shade, edgecolor=DARK, linewidth=0.9, zorder=10 + depth))

    def turn(
        self,
        axis: ArrayLike,
        angle: float,
        *,
        start: ArrayLike,
        at: ArrayLike = ORIGIN,
        colour: str = ACCENT,
        text: str = "",
    ) -> None:
        """Draw the path of the point `start` as it turns about an axis through `at`, with an arrow at its end."""
        e = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
        points = matrix_from_natural(e, np.linspace(0.0, angle, 60)) @ np.asarray(start, dtype=float) + at
        self.path(points[:-4], colour, width=1.6)
        places, depth = self.seen(points)
        self._arrow(places[[-6, -1]], colour, 1.6, "-", 21 + depth)
        if text:
            middle = points[len(points) // 2]
            self.label(middle, text, colour, middle - at)

    def robot(self, robot: RobotModel, q: ArrayLike, *, colour: str = GREY, width: float = 4.0) -> None:
        """Draw the links of a robot as strokes from joint to joint, and its torso as a sheet between them."""
        roots = []
        for effector, joints in robot.chains.items():
            points = robot.position(q, [*(name for name in joints if not name.endswith("Hand")), effector])
            self.path(points, colour, width=width, order=8)
            places = self.seen(points[:-1])[0].T
            self.axes.plot(*places, "o", color="white", markeredgecolor=colour, markersize=4, zorder=9)
            roots.append(points[0])
        head, left_arm, left_leg, right_leg, right_arm = roots
        sheet = self.seen(np.array([head, left_arm, left_leg, right_leg, right_arm]))[0]
        self.axes.add_patch(Polygon(sheet, facecolor="#ececec", edgecolor=colour, linewidth=1.0, zorder=4))

    def line(
        self,
        line: PluckerLine,
        near: ArrayLike,
        *,
        half: float,
        colour: str = ACCENT,
        text: str = "",
        style: str = "-.",
        width: float = 1.4,
    ) -> None:
        """Draw the part of a line around its point closest to `near`, named at its end, or at its start if half < 0."""
        middle = line.closest_point(near)
        ends = middle + np.outer([-half, half], line.direction)
        self.path(ends, colour, width=width, style=style, order=25)
        if text:
            self.label(ends[1], text, colour, ends[1] - ends[0])

    def _arrow(self, places: NDArray[np.float64], colour: str, width: float, style: str, order: float) -> None:
        arrow = FancyArrowPatch(
            *places,
            arrowstyle="-|>",
            mutation_scale=6 + 3 * width,
            color=colour,
            linewidth=width,
            linestyle=style,
            shrinkA=0,
            shrinkB=0,
            zorder=order,
        )
        self.axes.add_patch(arrow)
