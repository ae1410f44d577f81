"""What the cameras see of the world around the robot, and the frames of a camera."""

from __future__ import annotations

import numpy as np

import nao_kin as nk
from explanations.drawing import AXES, BODY, INK, LINE, ORANGE, PALE, Drawing, Floats, View
from explanations.robot_outline import draw_robot, nao_shapes
from explanations.solids import box, draw_solid

TOP, BOTTOM = "#0f766e", ORANGE
COLOURS = {"CameraTop": TOP, "CameraBottom": BOTTOM}
SIGHT, GROUND = 2.1, 1.75  # how far a field of view is drawn, in the air and on the ground [m]


def standing() -> tuple[nk.NaoModel, Floats, Floats]:
    """The robot, its configuration with the head upright, and its torso above the ground under it."""
    nao, _ = nao_shapes()
    q = nao.neutral()
    T_ground_torso = np.eye(4)
    T_ground_torso[2, 3] = -nao.position(q, "LLeg")[2]
    return nao, q, T_ground_torso


def rays(nao: nk.NaoModel, camera: str, u: Floats, v: Floats) -> Floats:
    """Directions in the torso of places in the picture, each from −1 to 1, to the right and down."""
    across, down = (np.tan(angle / 2) for angle in nao.semantics.fields_of_view[camera])
    directions = np.stack([np.ones(np.shape(u)), -u * across, -v * down], axis=-1)
    return np.asarray(directions @ nao.rotation(nao.neutral(), camera).T)


def fields_of_view() -> Drawing:
    """From the left, with the ground, and the part of the ground that is seen from above."""
    nao, q, T = standing()
    drawing = Drawing(
        760, 905, "The fields of view of both cameras of a standing NAO, from the left, and on the ground"
    )
    up = T[2, 3]
    scale, left, ground = 240.0, 78.0, 350.0
    view = View((left, ground - scale * up), scale, (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    drawing.text((24, 32), "from the right", 16, weight="600")
    edges: dict[str, list[float]] = {}
    zero = np.array([0.0, 0.0])
    for camera, colour in COLOURS.items():
        eye = nao.position(q, camera)
        upper, lower = rays(nao, camera, zero, np.array([-1.0, 1.0]))
        degrees = np.degrees(np.arctan2([upper[2], lower[2]], [upper[0], lower[0]]))
        sweep = np.radians(np.linspace(degrees[0], degrees[1], 200))
        reach = np.minimum(SIGHT, np.where(sweep < 0, (eye[2] + up) / np.maximum(np.sin(-sweep), 1e-9), np.inf))
        far = eye + reach[:, None] * np.column_stack([np.cos(sweep), 0 * sweep, np.sin(sweep)])
        drawing.path(view.flat([eye, *far]), fill=colour, opacity=0.14, stroke=colour, width=1.2, closed=True)
        middle = nao.rotation(q, camera)[:, 0]
        way = 1.75 if camera == "CameraTop" else 0.34
        drawing.line(view.flat(eye), view.flat(eye + way * middle), colour, 1.2, "6 4")
        edges[camera] = [float(eye[0] + (eye[2] + up) / np.tan(np.radians(-angle))) for angle in degrees]
    draw_robot(drawing, view, q, fill="#f3f4f6")
    drawing.line((14, ground), (746, ground), LINE, 1.6)
    h, v = (np.degrees(angle) for angle in nao.semantics.fields_of_view["CameraTop"])
    eye = nao.position(q, "CameraTop")
    drawing.text(view.flat(eye + np.array([0.75, 0.0, 0.08])), "CameraTop", 14, TOP, weight="600", halo=True)
    drawing.text(view.flat(eye + np.array([1.12, 0.0, 0.08])), "1.2° down", 14, TOP, halo=True)
    eye = nao.position(q, "CameraBottom")
    drawing.text(view.flat(eye + np.array([0.31, 0.0, -0.31])), "CameraBottom", 14, BOTTOM, weight="600", halo=True)
    drawing.text(view.flat(eye + np.array([0.31, 0.0, -0.385])), "39.7° down", 14, BOTTOM, halo=True)
    marks = [(edges["CameraBottom"][1], BOTTOM), (edges["CameraTop"][1], TOP), (edges["CameraBottom"][0], BOTTOM)]
    for x, colour in marks:
        foot = view.flat([x, 0.0, -up])
        drawing.line(foot, foot + np.array([0.0, 7.0]), colour, 2.0)
        drawing.text(foot + np.array([0.0, 21.0]), f"{x:.2f} m", 13, colour, anchor="middle")

    above = View((left, 655.0), scale, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    drawing.text((24, 420), "the ground from above", 16, weight="600")
    side = np.linspace(-1.0, 1.0, 25)
    for camera, colour in COLOURS.items():
        eye = nao.position(q, camera)
        steep = np.linspace(1.0, -1.0, 400)
        rows = rays(nao, camera, np.zeros(400), steep)
        last = float(steep[[eye[0] + (eye[2] + up) * r[0] / max(-r[2], 1e-9) < GROUND for r in rows]][-1])
        border = [(s, 1.0) for s in side] + [(1.0, t) for t in np.linspace(1.0, last, 12)]
        border += [(s, last) for s in side[::-1]] + [(-1.0, t) for t in np.linspace(last, 1.0, 12)]
        directions = rays(nao, camera, *np.array(border).T)
        points = eye + directions * ((eye[2] + up) / -directions[:, 2])[:, None]
        drawing.path(above.flat(points), fill=colour, opacity=0.14, stroke=colour, width=1.2, closed=True)
    draw_robot(drawing, above, q, fill="#f3f4f6")
    drawing.text(above.flat([0.55, 0.0, 0.0]), "CameraBottom", 14, BOTTOM, weight="600", halo=True)
    drawing.text(above.flat([1.85, 0.0, 0.0]), "CameraTop, and on", 14, TOP, weight="600", halo=True)
    drawing.text((24, 885), f"V6: {h:.1f}° across, {v:.1f}° high, both cameras alike; joints at zero.", 13.5, PALE)
    return drawing


def camera_frames() -> Drawing:
    """The body frame, the optical frame and the picture of one camera."""
    drawing = Drawing(760, 330, "A camera's body frame, its optical frame, and the axes u and v of its picture")
    nao, _ = nao_shapes()
    optical = nao.rotation(nao.neutral(), "CameraTop").T @ nao.rotation(nao.neutral(), "CameraTop_optical_frame")
    across, down = (np.tan(angle / 2) for angle in nao.semantics.fields_of_view["CameraTop"])
    panels = (
        ("CameraTop", np.eye(3), "x forward, y left, z up"),
        ("CameraTop_optical_frame", optical, "z forward, x right, y down"),
    )
    for k, (name, R, words) in enumerate(panels):
        view = View.around((75.0 + 262.0 * k, 205.0), 92.0, -128.0, 24.0)
        corners = np.array([[1.6, -1.6 * across * a, -1.6 * down * b] for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
        for corner in corners:
            drawing.line(view.flat([0.0, 0.0, 0.0]), view.flat(corner), LINE, 1.0)
        drawing.path(view.flat(corners), fill=BODY, opacity=0.5, stroke=PALE, width=1.2, closed=True)
        draw_solid(drawing, view, box([-0.34, -0.17, -0.17], [0.0, 0.17, 0.17]))
        T = np.eye(4)
        T[:3, :3] = R
        view.triad(drawing, T, 0.78, 2.6)
        for axis, (letter, colour) in enumerate(zip("xyz", AXES, strict=True)):
            tip = view.flat(0.92 * R[:, axis])
            drawing.text((tip[0], tip[1] + 4.5), letter, 14, colour, anchor="middle", weight="600", halo=True)
        drawing.text((125.0 + 255.0 * k, 40), name, 15, anchor="middle", weight="600")
        drawing.text((125.0 + 255.0 * k, 312), words, 13.5, PALE, anchor="middle")
    x, y, width, height = 545.0, 100.0, 180.0, 135.0
    drawing.text((635, 40), "the picture", 15, anchor="middle", weight="600")
    frame = [(x, y), (x + width, y), (x + width, y + height), (x, y + height)]
    drawing.path(frame, fill=BODY, opacity=0.5, stroke=PALE, width=1.2, closed=True)
    drawing.arrow([(x, y), (x + 70, y)], AXES[0], 2.6)
    drawing.arrow([(x, y), (x, y + 70)], AXES[1], 2.6)
    drawing.text((x + 78, y - 8), "u", 14, AXES[0], weight="600")
    drawing.text((x - 14, y + 78), "v", 14, AXES[1], weight="600")
    centre = np.array([x + width / 2, y + height / 2])
    for step in ((7.0, 0.0), (0.0, 7.0)):
        drawing.line(centre - step, centre + step, INK, 1.4)
    drawing.text(centre + np.array([6.0, 20.0]), "c_{u}, c_{v}", 13.5)
    drawing.text((x + width, y + height + 22), "640 × 480", 13, PALE, anchor="end")
    drawing.text((635, 312), "u right, v down", 13.5, PALE, anchor="middle")
    return drawing


FIGURES = {"cameras_fields_of_view": fields_of_view, "cameras_frames": camera_frames}
