"""Conventions of rotations: active turns, moving and fixed axes, roll, pitch and yaw."""

from __future__ import annotations

import numpy as np

import nao_kin as nk
from explanations.drawing import (
    AXES,
    BLUE,
    GREEN,
    INK,
    LINE,
    PALE,
    RED,
    VIOLET,
    Drawing,
    Floats,
    View,
    circle_points,
)
from explanations.solids import NOSE, draw_solid, prism

BODY = prism(NOSE, -0.13, 0.13)
TOP = (191, 213, 245)
QUARTER = np.pi / 2


def placed(R: Floats) -> Floats:
    """Return a pose without a translation."""
    return nk.screws.pose(R, [0.0, 0.0, 0.0])


def body(drawing: Drawing, view: View, R: Floats) -> None:
    """Draw a body with a nose along its x and a blue upper side, and its axes."""
    draw_solid(drawing, view, BODY, placed(R), first=TOP)
    view.triad(drawing, placed(R), 0.95, 2.4)


def room(drawing: Drawing, view: View, length: float = 1.05) -> None:
    """Draw the axes of the room, pale."""
    for k, axis in enumerate(np.eye(3)):
        tip = view.flat(length * axis)
        drawing.arrow([view.flat([0, 0, 0]), tip], LINE, 1.2, head=7.0)
        away = (tip - view.flat([0, 0, 0])) / np.linalg.norm(tip - view.flat([0, 0, 0]))
        drawing.text(tip + 9.0 * away + [0.0, 4.5], "xyz"[k], 12.0, PALE, anchor="middle")


def turn(drawing: Drawing, view: View, axis: Floats, colour: str, at: float) -> None:
    """Draw a bent arrow of a right-handed rotation about an axis."""
    axis = axis / np.linalg.norm(axis)
    side = np.cross(axis, [0.31, 0.52, 0.79])
    side = side / np.linalg.norm(side)
    # It begins at the point nearest to the reader.
    bow = circle_points(at * axis, 0.3 * side, 0.3 * np.cross(axis, side), 0.0, 360.0, 73)[:-1]
    middle = int(np.argmax(bow @ view.towards - 0.3 * (bow @ np.asarray(view.up))))
    drawing.arrow(view.flat(bow[np.arange(middle - 24, middle + 24) % 72]), colour, 2.2)


def active_rotation() -> Drawing:
    """Draw one matrix as a rotation of a vector and as a change of coordinates."""
    drawing = Drawing(760, 330, "A rotation matrix turns a vector, and converts coordinates from frame b to frame a")
    angle, length = 40.0, 165.0
    R = nk.rotations.rot_z(np.radians(angle))[:2, :2]
    page = np.array([1.0, -1.0])

    def axes(at: Floats, M: Floats, names: tuple[str, str], width: float) -> None:
        for k in range(2):
            tip = at + 150.0 * page * M[:, k]
            drawing.arrow([at, tip], AXES[k], width)
            drawing.text(
                at + 164.0 * page * M[:, k] + [0.0, 4.5], names[k], 13.0, AXES[k], anchor="middle", weight="600"
            )

    drawing.text((190, 34), "a vector is turned", 16, anchor="middle", weight="600")
    drawing.text((570, 34), "coordinates are converted", 16, anchor="middle", weight="600")
    at = np.array([110.0, 255.0])
    axes(at, np.eye(2), ("x", "y"), 1.6)
    v = np.array([np.cos(np.radians(18.0)), np.sin(np.radians(18.0))])
    for vector, colour, name in ((v, PALE, "*v*"), (R @ v, VIOLET, "*R* *v*")):
        drawing.arrow([at, at + length * page * vector], colour, 3.0, head=12.0)
        drawing.text(
            at + (length + 16.0) * page * vector + [4.0, 4.0], name, 15.0, colour, anchor="middle", weight="600"
        )
    arc = circle_points(at, [88.0, 0.0], [0.0, -88.0], 18.0, 18.0 + angle)
    drawing.arrow(arc, INK, 1.4, head=8.0)
    drawing.text(at + 103.0 * page * [0.79, 0.62] + [0.0, 4.0], "φ", 14.0, INK, anchor="middle")
    drawing.text((190, 308), "one frame, two vectors: v′ = R v", 14, PALE, anchor="middle")

    at = np.array([490.0, 255.0])
    axes(at, np.eye(2), ("x_{a}", "y_{a}"), 1.6)
    axes(at, R, ("x_{b}", "y_{b}"), 2.8)
    p_b = np.array([118.0, 42.0])
    corner, p = at + page * (R @ [p_b[0], 0.0]), at + page * (R @ p_b)
    drawing.line(corner, p, GREEN, 1.3, "4 3")
    p_a = R @ p_b
    drawing.line(at + page * [p_a[0], 0.0], p, LINE, 1.3, "4 3")
    drawing.line(at + page * [0.0, p_a[1]], p, LINE, 1.3, "4 3")
    drawing.circle(p, 5.0, INK)
    drawing.text((p[0] + 10.0, p[1] - 6.0), "*p*", 15.0, INK, weight="600")
    arc = circle_points(at, [62.0, 0.0], [0.0, -62.0], 0.0, angle)
    drawing.arrow(arc, INK, 1.4, head=8.0)
    drawing.text(at + 76.0 * page * [0.94, 0.34] + [0.0, 4.0], "φ", 14.0, INK, anchor="middle")
    drawing.text((570, 308), "one point, two frames: p_{a} = R_{ab} p_{b}", 14, PALE, anchor="middle")
    return drawing


def moving_and_fixed() -> Drawing:
    """Draw 90° about x and 90° about y, with moving and with fixed axes."""
    drawing = Drawing(760, 595, "Turns by 90 degrees about x and then y, about moving axes and about fixed axes")
    rot_x, rot_y = nk.rotations.rot_x(QUARTER), nk.rotations.rot_y(QUARTER)
    rows = {
        "moving": (rot_x @ rot_y, rot_x[:, 1], "90° about the body’s own y", "the nose points to the left, +y"),
        "fixed": (rot_y @ rot_x, np.eye(3)[1], "90° about the room’s y", "the nose points down, −z"),
    }
    for k, (name, (R, second, words, end)) in enumerate(rows.items()):
        y = 150.0 + 282.0 * k
        drawing.text((24, y - 112.0), f'axes="{name}"', 16, weight="600")
        steps = [(np.eye(3), None, "start"), (rot_x, np.eye(3)[0], "90° about x"), (R, second, words)]
        for column, (pose, axis, label) in enumerate(steps):
            x = 130.0 + 250.0 * column
            view = View.around((x, y), 82.0, -58.0, 24.0)
            room(drawing, view)
            if axis is not None:
                drawing.line(view.flat(-1.3 * axis), view.flat(1.3 * axis), VIOLET, 1.4, "5 4")
            body(drawing, view, pose)
            if axis is not None:
                turn(drawing, view, axis, VIOLET, -0.95)
            drawing.text((x, y + 126.0), label if column == 0 else f"{column}. {label}", 13.5, anchor="middle")
        drawing.text((630.0, y + 145.0), end, 13.5, VIOLET, anchor="middle", weight="600")
    return drawing


def roll_pitch_yaw() -> Drawing:
    """Draw yaw, then pitch, then roll, each about an axis moved by the previous rotations."""
    yaw, pitch, roll = np.radians([35.0, 25.0, 40.0])
    R = nk.rotations
    after_yaw = R.rot_z(yaw)
    after_pitch = after_yaw @ R.rot_y(pitch)
    end = R.matrix_from_rpy([roll, pitch, yaw])
    drawing = Drawing(
        760, 330, "A body is turned by yaw about z, by pitch about the y carried along, by roll about its x"
    )
    steps = (
        (np.eye(3), None, "start", "", INK, 0.0),
        (after_yaw, np.eye(3)[2], "1. yaw 35°", "about z: nose to the left", BLUE, 1.05),
        (after_pitch, after_yaw[:, 1], "2. pitch 25°", "about y: nose down", GREEN, -1.0),
        (end, after_pitch[:, 0], "3. roll 40°", "about x: right side down", RED, -1.0),
    )
    for k, (pose, axis, label, words, colour, at) in enumerate(steps):
        x = 98.0 + 188.0 * k
        view = View.around((x, 112.0), 66.0, -58.0, 28.0)
        room(drawing, view)
        if axis is not None:
            drawing.line(view.flat(-1.3 * axis), view.flat(1.3 * axis), colour, 1.4, "5 4")
        body(drawing, view, pose)
        if axis is not None:
            turn(drawing, view, axis, colour, at)
        drawing.text((x, 222.0), label, 15, colour, anchor="middle", weight="600")
        drawing.text((x, 242.0), words, 13, PALE, anchor="middle")
    drawing.text((380, 276), "R = R_{z}(yaw) R_{y}(pitch) R_{x}(roll)", 15, INK, anchor="middle")
    return drawing


FIGURES = {"active_rotation": active_rotation, "moving_and_fixed": moving_and_fixed, "roll_pitch_yaw": roll_pitch_yaw}
