"""Draw convex solids in parallel projection, with shaded faces."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from explanations.drawing import PALE, Drawing, Floats, View

NOSE = np.array([[-0.5, -0.34], [0.25, -0.34], [0.62, 0.0], [0.25, 0.34], [-0.5, 0.34]])


def prism(outline: Floats, low: float, high: float) -> list[Floats]:
    """Return the faces of an outline in x and y between two heights; the first is the upper one."""
    top, bottom = (np.column_stack([outline, np.full(len(outline), z)]) for z in (high, low))
    sides = [np.array([bottom[i], bottom[j], top[j], top[i]]) for i, j in pairwise([*range(len(outline)), 0])]
    return [top, bottom[::-1], *sides]


def box(low: ArrayLike, high: ArrayLike) -> list[Floats]:
    """Return the faces of a box along the axes."""
    (x0, y0, z0), (x1, y1, z1) = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    return prism(np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]), z0, z1)


def cylinder(radius: float, low: float, high: float, corners: int = 48) -> list[Floats]:
    """Return the faces of a cylinder about z."""
    turn = np.linspace(0.0, 2.0 * np.pi, corners, endpoint=False)
    return prism(radius * np.column_stack([np.cos(turn), np.sin(turn)]), low, high)


def draw_solid(
    drawing: Drawing,
    view: View,
    faces: list[Floats],
    T: Floats | None = None,
    *,
    colour: tuple[int, int, int] = (214, 219, 227),
    first: tuple[int, int, int] | None = None,
    edges: bool = True,
) -> None:
    """Draw the visible faces of a convex solid.

    Args:
        drawing: the drawing.
        view: the view.
        faces: their corners, counter-clockwise from outside.
        T: the pose of the solid.
        colour: colour of the solid, red, green and blue up to 255.
        first: the colour of the first face, if it differs.
        edges: whether to draw the edges of the sides too, not only those of the two ends.
    """
    pose = np.eye(4) if T is None else T
    light = view.towards + 0.6 * np.asarray(view.up) - 0.35 * np.asarray(view.right)
    light = light / np.linalg.norm(light)
    for k, face in enumerate(faces):
        placed = face @ pose[:3, :3].T + pose[:3, 3]
        normal = np.cross(placed[1] - placed[0], placed[2] - placed[1])
        normal = normal / np.linalg.norm(normal)
        if normal @ view.towards < 1e-6:
            continue
        shade = 0.86 + 0.2 * float(normal @ light)
        base = np.array(first if k == 0 and first is not None else colour)
        fill = "#" + "".join(f"{round(c):02x}" for c in np.clip(base * shade, 0, 255))
        drawing.path(
            view.flat(placed),
            fill=fill,
            stroke=PALE if edges or k < 2 else fill,
            width=1.0 if k < 2 else 0.8,
            closed=True,
        )
