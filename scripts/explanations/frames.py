"""The main frames of the NAO, from four sides in the zero posture, and standing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from explanations.drawing import AXES, INK, LINE, PALE, Drawing, Floats, View
from explanations.robot_outline import draw_robot, nao_shapes

SCALE = 640.0
LENGTH = 0.052
X, Y, Z = np.eye(3)
# Directions drawn to the right and upwards.
SIDES = {"front": (Y, Z), "left": (-X, Z), "back": (-Y, Z), "top": (-Y, X)}
# Position of the torso, distance of the names to its left and right, and the frames named there.
Panel = tuple[tuple[float, float], tuple[float, float], list[str], list[str]]


def labelled(
    drawing: Drawing, view: View, q: Floats, columns: dict[str, Sequence[str]], edges: tuple[float, float], step: float
) -> None:
    """Draw the frames, and their names in columns on both sides, connected by lines that do not cross."""
    nao, _ = nao_shapes()
    places: list[tuple[Floats, Floats, str, str]] = []
    for anchor, x, names in (("end", edges[0], columns["left"]), ("start", edges[1], columns["right"])):
        if not names:
            continue
        points = {name: view.flat(nao.position(q, name)) for name in names}
        ordered = sorted(names, key=lambda name: (points[name][1], names.index(name)))
        heights = spread([float(points[name][1]) for name in ordered], step)
        places += [(points[n], np.array([x, h]), n, anchor) for n, h in zip(ordered, heights, strict=True)]
    for point, at, _, anchor in places:
        inwards = np.array([1.0 if anchor == "end" else -1.0, 0.0])
        drawing.path([at + 3.0 * inwards, at + 9.0 * inwards, point], stroke=LINE, width=0.9)
    for name in [name for names in columns.values() for name in names]:
        view.triad(drawing, nao.fk(q, name), LENGTH)
    for _, at, name, anchor in places:
        drawing.text((at[0], at[1] + 4.5), name, 13.0, anchor=anchor, halo=True)


def spread(heights: list[float], step: float) -> list[float]:
    """Return ascending heights, moved as little as necessary to be a step apart."""
    groups = [[height, 1] for height in heights]
    k = 0
    while k + 1 < len(groups):
        (a, m), (b, n) = groups[k], groups[k + 1]
        if b - a >= step * (m + n) / 2 - 1e-9:
            k += 1
            continue
        groups[k : k + 2] = [[(a * m + b * n) / (m + n), m + n]]
        k = max(k - 1, 0)
    return [middle + step * (i - (size - 1) / 2) for middle, size in groups for i in range(int(size))]


def four_sides() -> Drawing:
    """Draw the zero posture, where all frames except the cameras' are parallel to the torso."""
    nao, _ = nao_shapes()
    q = nao.neutral()
    drawing = Drawing(810, 945, "The main frames of the NAO in its zero posture from the front, left, back and top")
    left, right = ("LArm", "LFoot", "LLeg"), ("RArm", "RFoot", "RLeg")
    panels: dict[str, Panel] = {
        "front": ((205, 222), (118, 118), [*right, "Head", "CameraTop"], [*left, "Torso"]),
        "left": ((640, 222), (182, 58), ["CameraTop", "CameraBottom", *left], ["Head", "Torso", "Accelerometer"]),
        "back": ((205, 680), (118, 118), [*left, "Head"], [*right, "Torso"]),
        "top": ((605, 760), (118, 118), ["LArm", "CameraTop"], ["RArm", "Head"]),
    }
    for name, panel in panels.items():
        side(drawing, name, panel, q, 34.0 if panel[0][1] < 400 else 492.0)
    key(drawing, (250, 930))
    return drawing


def side(drawing: Drawing, name: str, panel: Panel, q: Floats, title_at: float) -> None:
    """Draw the robot from one side, with its frames."""
    (x, y), (to_left, to_right), left, right = panel
    view = View((x, y), SCALE, *SIDES[name])
    drawing.text((x, title_at), f"from the {name}", 16, anchor="middle", weight="600")
    draw_robot(drawing, view, q)
    labelled(drawing, view, q, {"left": left, "right": right}, (x - to_left, x + to_right), 19.0)


def key(drawing: Drawing, at: tuple[float, float]) -> None:
    """Draw the legend of colours and rings."""
    x, y = at
    for k, (name, colour) in enumerate(zip("xyz", AXES, strict=True)):
        drawing.arrow([(x + 52 * k, y - 4), (x + 26 + 52 * k, y - 4)], colour, 2.2)
        drawing.text((x + 31 + 52 * k, y), name, 13.0, colour, weight="600")
    drawing.circle((x + 170, y - 4), 5.0, "white", INK, 1.5)
    drawing.circle((x + 170, y - 4), 1.8, INK)
    drawing.text((x + 180, y), "towards you", 13.0, PALE)
    drawing.circle((x + 275, y - 4), 5.0, "white", INK, 1.5)
    for corner in ((3.4, 3.4), (3.4, -3.4)):
        drawing.line((x + 275 - corner[0], y - 4 - corner[1]), (x + 275 + corner[0], y - 4 + corner[1]), INK, 1.3)
    drawing.text((x + 285, y), "away", 13.0, PALE)


def standing() -> Drawing:
    """Draw StandInit, where the frames of the limbs have moved with them."""
    nao, _ = nao_shapes()
    q = nao.posture("StandInit")
    drawing = Drawing(810, 485, "The main frames of the NAO in StandInit from the front and from the left")
    left, right = ("LArm", "LKneePitch", "LFoot", "LLeg"), ("RArm", "RKneePitch", "RFoot", "RLeg")
    panels: dict[str, Panel] = {
        "front": ((225, 222), (132, 132), [*right, "Head"], [*left, "CameraTop", "Torso"]),
        "left": ((640, 222), (125, 70), ["CameraTop", "CameraBottom", *left], ["Head", "Torso"]),
    }
    for name, panel in panels.items():
        side(drawing, name, panel, q, 34.0)
    key(drawing, (250, 470))
    return drawing


FIGURES = {"frames_four_sides": four_sides, "frames_standing": standing}
