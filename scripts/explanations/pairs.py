"""Reuleaux's six lower pairs, each with the motions that it allows."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from explanations.drawing import INK, ORANGE, PALE, VIOLET, Drawing, Floats, View, circle_points
from explanations.solids import box, cylinder, draw_solid
from nao_kin.joints import KINEMATIC_PAIRS

OUTER, INNER = (200, 206, 216), (178, 205, 243)
TURN, SLIDE = VIOLET, ORANGE
Z = np.eye(3)[2]


def slide(drawing: Drawing, view: View, centre: Floats, direction: Floats, length: float) -> None:
    """Draw a straight arrow with two heads."""
    drawing.arrow(view.flat([centre - length * direction, centre + length * direction]), SLIDE, 2.4, both=True)


def turn(drawing: Drawing, view: View, centre: Floats, axis: Floats, radius: float) -> None:
    """Draw an arc with two heads on the visible side of the axis."""
    side = np.cross(axis, [0.31, 0.52, 0.79])
    side = side / np.linalg.norm(side)
    bow = circle_points(centre, radius * side, radius * np.cross(axis, side), 0.0, 360.0, 73)[:-1]
    middle = int(np.argmax((bow - centre) @ view.towards))
    drawing.arrow(view.flat(bow[np.arange(middle - 21, middle + 22) % 72]), TURN, 2.4, both=True)


def revolute(drawing: Drawing, view: View) -> None:
    """Draw a pin with collars in a sleeve."""
    for low, high, radius, colour in (
        (-0.75, -0.5, 0.22, INNER), (-0.5, -0.42, 0.42, INNER), (-0.42, 0.3, 0.36, OUTER),
        (0.3, 0.38, 0.42, INNER), (0.38, 0.85, 0.22, INNER),
    ):  # fmt: skip
        draw_solid(drawing, view, cylinder(radius, low, high), colour=colour, edges=False)
    turn(drawing, view, 0.66 * Z, Z, 0.5)


def prismatic(drawing: Drawing, view: View) -> None:
    """Draw a square bar in a square sleeve."""
    for low, high, half, colour in ((-0.85, -0.42, 0.2, INNER), (-0.42, 0.3, 0.36, OUTER), (0.3, 0.8, 0.2, INNER)):
        draw_solid(drawing, view, box([-half, -half, low], [half, half, high]), colour=colour)
    slide(drawing, view, np.array([0.0, 0.62, 0.55]), Z, 0.36)


def helical(drawing: Drawing, view: View) -> None:
    """Draw a screw in its nut."""
    toward = np.arctan2(view.towards[1], view.towards[0])
    for low, high, radius, colour in ((-0.85, -0.42, 0.2, INNER), (-0.42, 0.3, 0.38, OUTER), (0.3, 0.9, 0.2, INNER)):
        corners = 6 if radius > 0.3 else 48
        draw_solid(drawing, view, cylinder(radius, low, high, corners), colour=colour, edges=corners == 6)
        if radius < 0.3:
            for start in np.arange(low + 0.05, high - 0.03, 0.09):
                winding = toward + np.radians(np.arange(-90.0, 91.0, 6.0))
                thread = [0.2 * np.cos(winding), 0.2 * np.sin(winding), start + 0.09 * (winding - toward) / (2 * np.pi)]
                drawing.path(view.flat(np.column_stack(thread)), stroke=PALE, width=1.1)
    rising = np.radians(np.linspace(-120.0, 120.0, 50))
    way = np.column_stack([0.5 * np.cos(rising + toward), 0.5 * np.sin(rising + toward), 0.58 + 0.09 * rising])
    drawing.arrow(view.flat(way), TURN, 2.4, both=True)
    slide(drawing, view, np.array([0.0, 0.72, 0.62]), Z, 0.24)


def cylindrical(drawing: Drawing, view: View) -> None:
    """Draw a smooth rod in a sleeve."""
    for low, high, radius, colour in ((-0.85, -0.42, 0.22, INNER), (-0.42, 0.3, 0.36, OUTER), (0.3, 0.85, 0.22, INNER)):
        draw_solid(drawing, view, cylinder(radius, low, high), colour=colour, edges=False)
    turn(drawing, view, 0.6 * Z, Z, 0.46)
    slide(drawing, view, np.array([0.0, 0.72, 0.55]), Z, 0.36)


def spherical(drawing: Drawing, view: View) -> None:
    """Draw a ball in its socket."""
    draw_solid(drawing, view, cylinder(0.45, -0.62, -0.1), colour=OUTER, edges=False)
    x, y = view.flat([0.0, 0.0, 0.05])
    drawing.circle((x, y), 0.43 * view.scale, "#b8d2f3", PALE, 1.0)
    lip = circle_points([0.0, 0.0, -0.1], [0.45, 0.0, 0.0], [0.0, 0.45, 0.0], 0.0, 360.0, 73)
    seen = lip[lip @ view.towards * 1.0 > -0.1 * view.towards[2]]
    order = np.argsort(seen @ np.asarray(view.right))
    wall = np.vstack([seen[order], seen[order][::-1] - 0.2 * Z])
    drawing.path(view.flat(wall), fill="#c8ced8", stroke="none", closed=True)
    drawing.path(view.flat(seen[order]), stroke=PALE, width=1.0)
    draw_solid(drawing, view, cylinder(0.12, 0.42, 0.95), colour=INNER, edges=False)
    turn(drawing, view, 0.78 * Z, Z, 0.36)
    for axis, centre in (([1.0, 0.0, 0.0], [0.72, 0.0, 0.05]), ([0.0, 1.0, 0.0], [0.0, -0.72, 0.05])):
        turn(drawing, view, np.array(centre), np.array(axis), 0.26)


def planar(drawing: Drawing, view: View) -> None:
    """Draw a block on a table."""
    draw_solid(drawing, view, box([-0.9, -0.9, -0.5], [0.9, 0.9, -0.32]), colour=OUTER)
    slide(drawing, view, np.array([0.0, -0.72, -0.32]), np.eye(3)[0], 0.55)
    slide(drawing, view, np.array([0.72, 0.05, -0.32]), np.eye(3)[1], 0.5)
    draw_solid(drawing, view, box([-0.4, -0.4, -0.32], [0.4, 0.4, 0.12]), colour=INNER)
    turn(drawing, view, 0.3 * Z, Z, 0.42)


PAIRS: dict[str, tuple[Callable[[Drawing, View], None], str]] = {
    "revolute": (revolute, "one turn"),
    "prismatic": (prismatic, "one slide"),
    "helical": (helical, "a turn that slides along"),
    "cylindrical": (cylindrical, "a turn and a slide"),
    "spherical": (spherical, "three turns"),
    "planar": (planar, "two slides and a turn"),
}


def lower_pairs() -> Drawing:
    """Draw all six pairs, three in a row."""
    drawing = Drawing(760, 560, "The six lower pairs: revolute, prismatic, helical, cylindrical, spherical and planar")
    for k, (name, (draw, words)) in enumerate(PAIRS.items()):
        x, y = 130.0 + 250.0 * (k % 3), 125.0 + 275.0 * (k // 3)
        draw(drawing, View.around((x, y), 84.0, -32.0, 24.0))
        pair = KINEMATIC_PAIRS[name]
        free = f"{pair.freedoms} freedom" + ("s" if pair.freedoms > 1 else "")
        drawing.text((x, y + 108.0), f"{name}, {pair.symbol}", 16, INK, anchor="middle", weight="600")
        drawing.text((x, y + 129.0), f"{free}: {words}", 13.5, PALE, anchor="middle")
    return drawing


FIGURES = {"lower_pairs": lower_pairs}
