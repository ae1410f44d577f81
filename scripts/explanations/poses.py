"""Conventions of poses and quaternions: how poses are chained, and the two orders of a quaternion's numbers."""

from __future__ import annotations

import numpy as np

import nao_kin as nk
from explanations.drawing import AXES, INK, LINE, PALE, VIOLET, Drawing, Floats, View
from explanations.robot_outline import draw_robot, nao_shapes


def bent(start: Floats, end: Floats, by: float) -> Floats:
    """Return an arc between two points that bulges by a part of their distance."""
    s = np.linspace(0.0, 1.0, 41)[3:-3, None]
    across = by * np.array([start[1] - end[1], end[0] - start[0]])
    return np.asarray(start + s * (end - start) + 4.0 * s * (1.0 - s) * across)


def pose_composition() -> Drawing:
    """Draw torso, head and camera: the product of two poses is a third."""
    nao, _ = nao_shapes()
    q = nao.posture("StandInit", HeadPitch=np.radians(12.0))
    drawing = Drawing(
        760, 430, "The pose of the camera in the torso is the pose of the head times the camera's in the head"
    )
    view = View((270.0, 340.0), 1150.0, (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    draw_robot(drawing, view, q, only="HeadYaw")
    a, b, c = (view.flat(nao.position(q, name)) for name in ("Torso", "Head", "CameraTop"))
    for name, at, words in (("Torso", (22.0, 22.0), "a = Torso"), ("Head", (20.0, 18.0), "b = Head")):
        view.triad(drawing, nao.fk(q, name), 0.06, 3.0)
        drawing.text(view.flat(nao.position(q, name)) + np.array(at), words, 14.0, INK, weight="600", halo=True)
    view.triad(drawing, nao.fk(q, "CameraTop"), 0.06, 3.0)
    drawing.text((c[0] - 18.0, c[1] - 12.0), "c = CameraTop", 14.0, INK, anchor="end", weight="600", halo=True)

    for start, end, by, name, at in (
        (a, b, 0.22, "T_{ab}", (42.0, 4.0)),
        (b, c, 0.28, "T_{bc}", (12.0, -22.0)),
        (a, c, -0.2, "T_{ac}", (-28.0, 8.0)),
    ):
        way = bent(start, end, by)
        drawing.arrow(way, VIOLET if name == "T_{ac}" else INK, 2.0)
        drawing.text(
            way[17] + np.array(at), name, 16.0, VIOLET if name == "T_{ac}" else INK, anchor="middle", halo=True
        )
    for k, words in enumerate(("T_{ac} = T_{ab} T_{bc}", "p_{a} = T_{ac} p_{c}", "T_{ba} = T_{ab}⁻¹")):
        drawing.text((450.0, 120.0 + 46.0 * k), words, 20.0, VIOLET if k == 0 else INK)
    for k, words in enumerate(("Neighbouring letters are the same frame,", "and cancel: ab · bc = ac.")):
        drawing.text((450.0, 272.0 + 20.0 * k), words, 13.5, PALE)
    return drawing


def quaternion_order() -> Drawing:
    """Draw the same four numbers in two orders."""
    drawing = Drawing(
        760, 300, "A quaternion scalar first, as here, and scalar last, as in scipy, ROS and Pinocchio's q"
    )
    w, x, y, z = nk.rotations.quat_from_matrix(nk.rotations.rot_z(np.radians(60.0)))
    values = {"w": (w, VIOLET), "x": (x, AXES[0]), "y": (y, AXES[1]), "z": (z, AXES[2])}
    rows = (
        (70.0, "wxyz", "scalar first", "nao_kin, Hamilton, MuJoCo, Drake, MATLAB"),
        (200.0, "xyzw", "scalar last", "scipy, ROS, Pinocchio’s q, Eigen’s coeffs()"),
    )
    width, left = 92.0, 30.0
    for top, order, title, who in rows:
        for k, name in enumerate(order):
            number, colour = values[name]
            at = left + width * k
            corners = [(at, top), (at + width - 8, top), (at + width - 8, top + 46), (at, top + 46)]
            drawing.path(corners, stroke=colour, width=2.0, closed=True)
            drawing.text((at + 16, top + 30), name, 17.0, colour, anchor="middle", weight="600")
            drawing.text((at + 54, top + 30), f"{number:.3f}", 15.0, INK, anchor="middle")
        drawing.text((420.0, top + 20.0), title, 16.0, INK, weight="600")
        drawing.text((420.0, top + 40.0), who, 13.5, PALE)
    for k, name in enumerate("wxyz"):
        start, end = (left + width * i + 42.0 for i in (k, "xyzw".index(name)))
        drawing.arrow([(start, 122.0), (end, 194.0)], values[name][1] if name == "w" else LINE, 1.8)
    drawing.text((left, 40.0), "A turn by 60° about z", 15.0, INK, weight="600")
    drawing.text(
        (left, 280.0), "w = cos 30° = 0.866 belongs to the angle, z = sin 30° = 0.500 to the axis.", 13.5, PALE
    )
    return drawing


FIGURES = {"pose_composition": pose_composition, "quaternion_order": quaternion_order}
